"""Power of a take-off that switches in a regular wave once its motion repeats."""

from types import SimpleNamespace

import numpy as np
import pytest

from vsb.errors import ConfigError, ConvergenceError
from vsb.hydro.statespace import RadiationModel
from vsb.integrators import settled
from vsb.integrators.settled import Trials, _settling, settled_power
from vsb.integrators.switching import Switching
from vsb.motion.forces import Damper, Excitation, RadiationMemory, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.motion.take_off import TakeOff

B = np.ones(1)


def system(law, omega=(2.0,), drag=0.3):
    """2 y'' + drag y' + 50 y = 30 cos omega t + take-off."""
    waves = Excitation(np.array(omega), np.full((len(omega), 1), 30.0 + 0j))
    forces = {"hydrostatic": Spring(np.array([[50.0]])), "structural_damping": Damper(np.array([[drag]]))}
    return System.of(Scene(("Heave",), np.array([[2.0]]), {**forces, "pto": law, "excitation": waves}, np.eye(1)))


@pytest.mark.parametrize("omega", [2.0, 7.0])
def test_a_law_without_switches_settles_at_the_linear_answer(omega):
    power, unsettled = settled_power(system(TakeOff(B, 4.0), (omega,)), 1e-9)
    assert unsettled < 1e-9
    assert power == pytest.approx(2.0 * 30.0**2 / abs(4.3 + 1j * (50 / omega - 2 * omega)) ** 2, rel=1e-8)


def test_friction_stronger_than_the_wave_takes_nothing_and_is_settled():
    assert settled_power(system(TakeOff(B, np.inf, limit=31.0))) == (0.0, 0.0)


def test_a_transient_that_outlasts_the_run_is_told():
    """Nothing but a weak take-off damps: at the end most of the transient is left."""
    _, unsettled = settled_power(system(TakeOff(B, 2e-4), (4.7,), 0.0))
    assert unsettled > 1e-3


def test_a_sea_has_no_settled_power():
    with pytest.raises(ConfigError, match="received 2 frequencies"):
        settled_power(system(TakeOff(B, 4.0), (2.0, 3.0)))


def test_a_steady_state_that_would_take_hours_is_refused():
    with pytest.raises(ConvergenceError, match=r"feels motion at 1e\+05 rad/s, so each period takes 2097152 instants"):
        settled_power(system(TakeOff(B, 2e5, limit=8.0)))


def test_trials_begin_where_the_best_before_ended_and_end_where_a_run_from_rest_does(monkeypatch):
    """The first from rest, the others from the end of the one that took most so far."""
    trials, laws, begun, ended = Trials(1e-3), [TakeOff(B, 4.0, pause=p) for p in (0.8, 0.85, 0.82, 0.81)], [], {}

    def follow(self, time, start, known=Switching.follow):
        found = known(self, time, start)
        begun.extend([start[0][0]] if time[0] == 0 else [])
        ended[self.law.pause] = found[0].position[-1, 0]
        return found

    expected = [settled_power(system(law, drag=3.0), 1e-6)[0] for law in laws]
    monkeypatch.setattr(Switching, "follow", follow)
    powers = [trials.power(system(law, drag=3.0)) for law in laws]
    assert powers == pytest.approx(expected, rel=2e-3)
    assert powers[1] == max(powers)
    assert begun == [0.0, ended[0.8], ended[0.85], ended[0.85]]


def test_a_motion_goes_on_where_it_was_left_with_all_it_remembers():
    """Four periods and eight more are twelve at once: position, velocity and the water's memory."""
    turning, channel = np.array([[0.0, 1.4], [-1.4, 0.0]]), np.array([1.0, 0.6])
    memory = RadiationModel(turning - np.outer(channel, channel) / 2, np.array([[2.0], [1.5]]), channel)
    scene = system(TakeOff(B, 4.0, pause=0.4)).scene
    driven = System.of(
        Scene(scene.labels, scene.mass, {**scene.forces, "radiation": RadiationMemory(memory)}, np.eye(1))
    )
    power, _, ended = _settling(driven, 0.0, driven.scene.start(0.0, 0.0), 4, 8)
    motion, _ = Switching(driven).follow(np.linspace(0.0, 12 * np.pi, 12 * 16 + 1), driven.scene.start(0.0, 0.0))
    for found, whole in zip(ended, (motion.position, motion.velocity, motion.memory), strict=True):
        np.testing.assert_allclose(found, whole[-1], rtol=1e-7, atol=1e-9)
    assert np.abs(motion.memory[-1]).min() > 1e-3
    assert power == pytest.approx((motion.works["pto"][-1] - motion.works["pto"][-33]) / (2 * np.pi), rel=1e-7)


def followed(powers):
    """What `Switching.follow` finds where the periods of a run have given powers [W], and the instants it is asked for."""
    asked = []

    def follow(self, time, start):
        asked.append((time[0], time[-1], start[0][0]))
        first = round(time[0] / np.pi)
        work = np.concatenate([[0.0], np.cumsum(powers(np.arange(first, round(time[-1] / np.pi))) * np.pi)])
        pto = np.interp(np.arange(len(time)) / 16, np.arange(len(work)), work)
        end = np.full((len(time), 1), float(len(asked)))
        return SimpleNamespace(works={"pto": pto}, position=end, velocity=2 * end, memory=3 * end), 0

    return follow, asked


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_powers_are_those_of_the_last_quarter_and_differ_over_the_last_half(monkeypatch, sign):
    """Periods of 10, 1, 2, 3, ...: at most twice as many are followed again, from where those before ended."""
    follow, asked = followed(lambda k: sign * np.where(k == 0, 10.0, k))
    monkeypatch.setattr(Switching, "follow", follow)
    plant = system(TakeOff(B, 4.0))
    power, unsettled, ended = _settling(plant, 1e-3, (np.array([7.0]), np.zeros(1), np.zeros(0)), 8, 16)
    assert asked == [(0.0, pytest.approx(8 * np.pi), 7.0), (pytest.approx(8 * np.pi), pytest.approx(24 * np.pi), 1.0)]
    assert power == pytest.approx(sign * np.mean([20, 21, 22, 23]))
    assert unsettled == pytest.approx(7 / 23)
    assert [part[0] for part in ended] == [2.0, 4.0, 6.0]
    assert _settling(plant, 0.6, (np.array([7.0]), np.zeros(1), np.zeros(0)), 8, 16)[:2] == pytest.approx(
        (sign * 6.5, 3 / 7)
    )


def test_a_motion_that_cannot_be_followed_takes_nothing_and_no_other_begins_there(monkeypatch):
    trials, found = Trials(1e-3), iter([5.0, None, -2.0, 5.0])
    monkeypatch.setattr(settled, "_settling", lambda s, tol, start, *counts: given(next(found), start, counts))
    begun = []

    def given(power, start, counts):
        begun.append((start[0], *counts))
        if power is None:
            raise ConvergenceError("lost")
        return power, 0.0, (f"end {len(begun)}",)

    plant = SimpleNamespace(scene=SimpleNamespace(start=lambda *_: ("rest",)))
    assert [trials.power(plant) for _ in range(4)] == [5.0, 0.0, -2.0, 5.0]
    assert begun == [("rest", 8, 16), ("end 1", 8, 16), ("end 1", 8, 16), ("end 1", 8, 16)]
    assert trials.most == 5.0


@pytest.mark.parametrize(("tolerance", "followed_to"), [(1e-3, 1e-4), (1e-6, 1e-6)])
def test_a_motion_is_followed_to_a_tenth_of_what_its_power_is_to_be_known_to(monkeypatch, tolerance, followed_to):
    """No closer than what switching is made for."""
    follow, known = followed(lambda k: 1.0 + 0.0 * k)[0], []

    def noted(self, time, start):
        known.append(self.tolerance)
        return follow(self, time, start)

    monkeypatch.setattr(Switching, "follow", noted)
    settled_power(system(TakeOff(B, 4.0)), tolerance)
    assert known == [pytest.approx(followed_to)]
