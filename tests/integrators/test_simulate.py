"""The table of methods: what `auto` is, and that a new method is a function and a row."""

import time as clock
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import EXAMPLE, HERE, only_run, varied

from vsb.errors import ConvergenceError
from vsb.hydro.retardation import DampingSpectrum
from vsb.integrators import simulate as simulating
from vsb.integrators.audit import energies, residual
from vsb.integrators.harmonic_balance import harmonic_balance
from vsb.integrators.phi import phi_integrals
from vsb.integrators.simulate import METHODS, Method, in_words, legs, recorded_steps, simulate, suited
from vsb.motion.forces import ConstantForce, Damper, Excitation, Force, Linear, Spring
from vsb.motion.motion import Motion
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.motion.take_off import TakeOff
from vsb.scenes.build import assumed_pressure_design
from vsb.study.study import Simulation, load
from vsb.waves.seas import NO_WAVES, Sea

SWELL = Sea(np.array([2.5]), np.array([0.1 + 0j]))


def exponential_time_differencing(system, tolerance, spectrum):
    """Cox and Matthews' method of second order: predicted with n at the start, corrected by its slope over the step."""

    def follow(time, start):
        h, z = time[1] - time[0], [system.first(start)]
        whole, (one, slope) = (phi := phi_integrals(system.matrix, system.input, h, 2)).exponential, phi.integrals
        for t in time[:-1]:
            here = forcing(t, z[-1])
            ahead = whole @ z[-1] + one @ here
            z.append(ahead + slope @ (forcing(t + h, ahead) - here) / h)
        return system.motion(time, np.array(z), system.forcing(time, np.array(z)), 0.0), len(time) - 1

    def forcing(t, state):
        return system.forcing(np.array([t]), state[None])[0]

    return follow


@dataclass(frozen=True)
class Hardening(Force):
    """f = -k q - k3 q^3 on every coordinate: a law no module of the package knows."""

    stiffness: float
    cubic: float

    def linear(self):
        """Return its tangent at rest."""
        return Linear(stiffness=np.array([[self.stiffness]]), whole=False)

    def force(self, time, q, v):
        """Return the force."""
        return -self.stiffness * q - self.cubic * q**3

    def stored(self, q):
        """Return its potential energy."""
        return (self.stiffness * q**2 / 2 + self.cubic * q**4 / 4).sum(axis=1)


@pytest.fixture(scope="module")
def paper():
    study = load(EXAMPLE.parent / "paper.yaml")
    short = varied(study, published=None, simulation={"duration": 2.0, "window": (1.0, 2.0)})
    return varied(short, designs={"FSB": short.designs["FSB"].model_dump()})


@pytest.fixture(scope="module")
def oscillator():
    wave = Excitation(SWELL.omega, np.array([[30.0 + 5j]]))
    forces = {"hydrostatic": Spring(np.array([[50.0]])), "pto": Damper(np.array([[1.2]])), "excitation": wave}
    return System.of(Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1)))


def added(monkeypatch, settings):
    """Settings that ask for the method of these tests, which becomes a row of the table."""
    monkeypatch.setitem(METHODS, "etd2", Method("exponential time differencing", exponential_time_differencing))
    return settings.model_copy(update={"method": "etd2"})


def test_a_new_method_is_a_function_and_a_row(paper, monkeypatch):
    """Body-exact heave of the paper's rigid buoy; it closes its audit and says its name."""
    system = assumed_pressure_design(only_run(paper), {}).system
    exact, _, words = simulate(system, NO_WAVES, paper.simulation, None)
    motion, _, name = simulate(system, NO_WAVES, added(monkeypatch, paper.simulation), None)
    assert words.startswith("exponential Adams, ")
    assert name == f"exponential time differencing, {len(motion.time) - 1} steps"
    every = (len(motion.time) - 1) // (len(exact.time) - 1)
    assert np.abs(motion.position[::every] - exact.position).max() < 1e-3 * np.ptp(exact.position)


@pytest.mark.parametrize("name", ["linear", "body-exact"])
def test_the_new_method_has_its_order(paper, oscillator, name):
    system = oscillator if name == "linear" else assumed_pressure_design(only_run(paper), {}).system
    errors, counts, start = [], np.array([100, 200, 400, 800]), (np.array([0.1]), np.array([-0.3]))
    best = "exact" if system.linear else "exponential"
    for count in counts:
        time = np.linspace(0.0, 2.0, count + 1)
        follow, true = (f(system, 1e-12, None) for f in (exponential_time_differencing, METHODS[best].follower))
        errors.append(np.abs(follow(time, start)[0].position - true(time, start)[0].position).max())
    orders = -np.diff(np.log2(errors))
    assert np.all(np.abs(orders - 2.0) < 0.1), (orders, errors)


def test_auto_is_exact_where_all_is_linear_and_exponential_elsewhere(paper, oscillator):
    assert paper.simulation.method == "auto"
    assert simulate(oscillator, SWELL, paper.simulation, None)[2] == "exact propagation"
    forced = paper.simulation.model_copy(update={"method": "exact"})
    with pytest.raises(ValueError, match="exact propagation: received nonlinear forces"):
        next(legs(assumed_pressure_design(only_run(paper), {}).system, NO_WAVES, forced, None))


def test_a_convolution_without_damping_is_refused(paper, oscillator):
    settings = paper.simulation.model_copy(update={"method": "convolution"})
    with pytest.raises(ValueError, match="convolution: received no radiation damping, needs a scene with a hydro data"):
        simulate(oscillator, SWELL, settings, None)
    omega = np.linspace(0.1, 8.0, 80)
    calm = DampingSpectrum(omega, np.zeros((80, 1, 1)))
    assert simulate(oscillator, SWELL, settings, calm)[2] == "convolution"


def test_a_new_force_is_followed_audited_and_balanced(oscillator):
    """Duffing's oscillator: a method in time after its transient, and the steady state by harmonic balance."""
    plant = replace(oscillator.scene, forces={**oscillator.scene.forces, "hydrostatic": Hardening(50.0, 40.0)})
    system, period = System.of(plant), 2 * np.pi / 2.5
    found = harmonic_balance(system, 1e-8)
    linear = harmonic_balance(oscillator).harmonics[1, 0]
    assert abs(abs(found.harmonics[1, 0] / linear) - 1) > 0.05  # the cube matters
    assert found.power.residual < 1e-8
    time = np.linspace(0.0, 20 * period, 20 * 256 + 1)
    follow = exponential_time_differencing(system, 0.0, None)
    motion, _ = follow(time, tuple(values[0] for values in found.at(np.zeros(1))))
    assert np.abs(motion.position - found.at(time)[0]).max() < 2e-4 * np.abs(motion.position).max()
    assert residual(energies(system, motion)) < 1e-3  # of the motion's own second order


def test_a_constant_force_moves_the_mean_alone(oscillator):
    forces = {**oscillator.scene.forces, "weight": ConstantForce(np.array([-3.0]))}
    found, plain = (harmonic_balance(s) for s in (System.of(replace(oscillator.scene, forces=forces)), oscillator))
    assert found.harmonics[0, 0] == pytest.approx(-3.0 / 50.0, rel=1e-9)
    assert found.harmonics[1, 0] == pytest.approx(plain.harmonics[1, 0], rel=1e-9)


def test_the_recipe_for_an_integrator_is_followed(oscillator, monkeypatch):
    """The first block of `docs/extending.md`, at most 15 lines without its row, as it stands there."""
    recipe = (HERE.parent / "docs" / "extending.md").read_text(encoding="utf-8").split("```python\n")[1].split("```")[0]
    assert len(recipe.split("METHODS[")[0].strip().splitlines()) <= 15
    rows = dict(METHODS)
    exec(recipe, {"np": np, "clock": clock, "phi_integrals": phi_integrals, "METHODS": rows, "Method": Method})
    errors, start = [], (np.array([0.1]), np.array([-0.3]))
    for count in (200, 400, 800):
        time = np.linspace(0.0, 2.0, count + 1)
        new, true = (rows[name].follower(oscillator, 0.0, None)(time, start)[0] for name in ("euler", "exact"))
        errors.append(np.abs(new.position - true.position).max())
    assert np.all(np.abs(-np.diff(np.log2(errors)) - 1.0) < 0.1), errors


@pytest.mark.parametrize("omega", [0.5, 2.5])
@pytest.mark.parametrize("duration", [30.0, 90.0])
def test_records_are_two_hundred_a_period_of_the_fastest_wave_that_matters(oscillator, omega, duration):
    """A wave below a twentieth of the highest does not matter, one above does; without any, free heave at 5 rad/s."""
    settings = Simulation(duration=duration, window=(1.0, duration))

    def count(sea):
        return recorded_steps(oscillator, sea, settings)

    periods = omega * duration / (2 * np.pi)
    assert count(Sea(np.array([omega]), np.array([0.3j]))) == np.ceil(200 * periods)
    assert count(Sea(np.array([omega, 2 * omega]), np.array([1.0, 0.049j]))) == np.ceil(200 * periods)
    assert count(Sea(np.array([omega, 2 * omega]), np.array([1.0, 0.051j]))) == np.ceil(400 * periods)
    for amplitudes in ([0.06, 1.0, 0.049j], [0.049j, 1.0, -0.049], [-0.06, -1.0j, 0.049]):
        assert count(Sea(omega * np.array([1.0, 2.0, 3.0]), np.array(amplitudes))) == np.ceil(400 * periods)
    assert count(Sea(omega * np.array([2.0, 3.0, 1.0]), np.array([0.051j, 0.049, -1.0]))) == np.ceil(400 * periods)
    assert count(NO_WAVES) == np.ceil(200 * 5.0 * duration / (2 * np.pi))  # sqrt(50/2) rad/s
    brief = Simulation(duration=duration, window=(1.0, 1.0 + 1e-3))
    assert recorded_steps(oscillator, NO_WAVES, brief) == pytest.approx(4e3 * duration, abs=1)


# legs ----------------------------------------------------------------------------------------------------------------


@pytest.fixture
def followed(oscillator, monkeypatch):
    """Function residuals, settings, ... -> legs of a run whose audits leave such parts, and what its method is asked.

    The motion stands where its leg ends, in metres the number of the leg asked for.
    """

    def run(residuals, longest=300, name="fake", count=1000, tolerance=1e-6):
        asked, left = [], iter(residuals)

        def follow(time, start):
            asked.append((float(time[0]), float(time[-1]), len(time), float(start[0][0])))
            end = np.full((len(time), 1), float(len(asked)))
            return Motion(time, end, 0 * end, 0 * end, np.zeros((len(time), 0)), 0.0), 7

        def audited(system, motion):
            course, missing = np.linspace(0.0, 1.0, len(motion.time)), next(left)
            energy = dict.fromkeys(("radiated", "structural", "stored", "turned"), 0.0 * course)
            return {"wave": course, "pto": (1.0 - missing) * course, **energy}

        monkeypatch.setitem(METHODS, name, Method("as told", lambda *_: follow))
        monkeypatch.setattr(simulating, "energies", audited)
        monkeypatch.setattr(simulating, "recorded_steps", lambda *_: count)
        settings = Simulation(duration=100.0, window=(1.0, 100.0), initial_position=0.25, tolerance=tolerance)
        settings = settings.model_copy(update={"method": name})
        return legs(oscillator, SWELL, settings, None, longest), asked

    return run


def test_legs_are_of_equal_length_and_go_on_where_the_one_before_ended(followed):
    """A thousand steps at most 300 at a time: four of 250, of 25 s; what they take adds up."""
    found, asked = followed([0.0] * 4)
    found = list(found)
    assert asked == [(25.0 * k, 25.0 * (k + 1), 251, float(k) if k else 0.25) for k in range(4)]
    assert [leg.energy["pto"][-1] for leg in found] == pytest.approx([1.0, 2.0, 3.0, 4.0])
    assert [leg.energy["pto"][0] for leg in found] == pytest.approx([0.0, 1.0, 2.0, 3.0])
    assert {(leg.stride, leg.method, leg.steps, leg.thinning) for leg in found} == {(1, "as told", 7, 1)}
    found, asked = followed([0.0] * 4, longest=333)
    assert len(list(found)) == 4
    assert [last - first for first, last, *_ in asked] == pytest.approx([25.0] * 4)
    found, asked = followed([0.0], longest=None)
    assert len(list(found)) == 1
    assert asked == [(0.0, 100.0, 1001, 0.25)]


def test_a_leg_is_followed_at_half_the_distance_until_its_audit_closes_and_the_next_begins_so(followed):
    """In parts as much shorter, so that none is longer than it may be."""
    found, asked = followed([1e-3, 1e-5, 0.9e-6, *[0.0] * 20])
    found = list(found)
    assert [given[2] for given in asked[:3]] == [251, 287, 289]
    assert [given[1] for given in asked[:3]] == pytest.approx([25.0, 14.3, 7.2])
    assert {leg.stride for leg in found} == {4}
    assert {first for first, *_ in asked[:3]} == {0.0}
    assert all(given[3] == 0.25 for given in asked[:3])
    assert max(given[2] for given in asked) <= 301
    assert asked[3][::3] == (pytest.approx(7.2), 3.0)  # from where the leg ended that closed


@pytest.mark.parametrize(("kept", "stride"), [(0.89, 8), (0.91, 4)])
def test_an_audit_that_finer_records_do_not_close_is_left_as_it_is(followed, kept, stride):
    """Where four times as many leave more than nine tenths of it: there, and in the legs after, not tried again."""
    found, asked = followed([1e-3, 0.95e-3, kept * 1e-3, *[0.88e-3] * 40], longest=10**6)
    (leg,) = found
    assert leg.stride == stride
    found, asked = followed([1e-3, 1e-3, 1e-3, *[2e-3] * 40], longest=2000)
    found = list(found)
    assert len(found) == 2
    assert {leg.stride for leg in found} == {4}
    assert len(asked) == 4
    assert found[-1].balance.unbalanced == pytest.approx(3e-3)


def test_records_are_made_finer_32_fold_at_most(followed):
    found, asked = followed(0.5 ** np.arange(3, 20), longest=None, tolerance=1e-12)
    (leg,) = found
    assert leg.stride == 32
    assert [given[2] - 1 for given in asked] == [1000 * 2**k for k in range(6)]


@pytest.mark.parametrize(("name", "tolerance", "enough"), [
    ("fake", 1e-6, 1e-6), ("fake", 1e-12, 1e-9), ("convolution", 1e-6, 1e-4), ("convolution", 1e-3, 1e-3),
])  # fmt: skip
def test_an_audit_is_closed_to_the_tolerance_or_to_what_its_method_can(followed, name, tolerance, enough):
    """To round-off, of the convolution to its own order; that needs its whole past and has one leg."""
    for share, stride in ((0.99, 1), (1.01, 2)):
        found = list(followed([share * enough, *[0.0] * 20], name=name, tolerance=tolerance)[0])
        assert found[0].stride == stride
        assert (len(found) == 1) == (name == "convolution")


def test_an_exact_run_is_not_recorded_finer(followed):
    """What its audit misses of the energy of all legs so far is told; a leg that closed before it stays."""
    found, asked = followed([0.0, 3e-5], name="exact", tolerance=1e-5)
    next(found)
    with pytest.raises(ConvergenceError, match=r"does not close: 1\.5e-05 of the energy is missing, needs 1e-05;"):
        next(found)
    assert len(asked) == 2


@pytest.mark.parametrize(("linear", "switching", "foreign", "name"), [
    (True, False, [], "exact"), (False, True, [], "switching"), (False, True, ["drag"], "switching"),
    (False, False, ["drag"], "collocation"), (False, False, [], "exponential"),
])  # fmt: skip
def test_the_method_that_suits_a_system(linear, switching, foreign, name):
    assert suited(SimpleNamespace(linear=linear, switching=switching, foreign=foreign)) == name


def test_a_method_that_takes_steps_of_its_own_tells_them():
    assert [in_words("so", steps) for steps in (0, 1, 42)] == ["so", "so, 1 steps", "so, 42 steps"]


def test_every_method_is_given_the_tolerance_and_where_to_begin(monkeypatch):
    """And tells the steps it took; what is exact has none."""
    for name in ("integrate", "collocated", "structure_preserving", "propagate", "convolve"):
        monkeypatch.setattr(simulating, name, lambda *given, name=name: ((name, *given), 9))
    monkeypatch.setattr(simulating, "steady_state", lambda system: f"steady {system}")
    start = ("y", "v", "x")

    def followed(method):
        return METHODS[method].follower("system", 1e-7, "damping")("time", start)

    for method, function in (("exponential", "integrate"), ("collocation", "collocated"),
                             ("structure_preserving", "structure_preserving")):  # fmt: skip
        assert followed(method) == ((function, "system", "time", start, 1e-7), 9)
    assert followed("exact") == ((("propagate", "system", "time", start, "steady system"), 9), 0)
    assert followed("convolution") == ((("convolve", "system", "damping", "time", ("y", "v")), 9), 0)


def test_without_waves_records_follow_the_faster_of_heave_and_an_assumed_pressure():
    """In still water that of heave alone; at least four in the window of the statistics, wherever that begins."""
    settings = Simulation(duration=50.0, window=(10.0, 50.0))
    for heaving, frequencies, omega in ((3.0, [1.0], 3.0), (3.0, [1.0, 4.0], 4.0), (3.0, [], 3.0)):
        still = SimpleNamespace(heaving=heaving, frequencies=np.array(frequencies))
        assert recorded_steps(still, NO_WAVES, settings) == np.ceil(200 * omega / (2 * np.pi) * 50.0)
    slow = SimpleNamespace(heaving=1e-3, frequencies=np.zeros(0))
    brief = Simulation(duration=50.0, window=(49.5, 50.0))
    assert recorded_steps(slow, NO_WAVES, brief) == 4 / 0.5 * 50


def test_a_whole_motion_is_one_leg_and_what_that_tells(monkeypatch):
    """However long: its stride, and the method in words with its steps."""
    asked, leg = [], SimpleNamespace(motion="motion", stride=4, method="Adams", steps=9)

    def one(*given, **more):
        asked.append((given, more))
        return iter([leg])

    monkeypatch.setattr(simulating, "legs", one)
    assert simulate("system", "sea", "settings", "damping") == ("motion", 4, "Adams, 9 steps")
    assert asked == [(("system", "sea", "settings", "damping"), {"longest": None})]


def test_legs_are_no_longer_than_memory_allows_unless_asked_for(followed, oscillator, monkeypatch):
    """2^17 instants."""
    followed([0.0] * 3, count=2**17 + 2)
    settings = Simulation(duration=100.0, window=(1.0, 100.0)).model_copy(update={"method": "fake"})
    assert [len(leg.motion.time) - 1 for leg in legs(oscillator, SWELL, settings, None)] == [2**16 + 1] * 2


@pytest.mark.parametrize("method", ["exact", "structure_preserving", "collocation", "switching"])
def test_a_motion_tells_the_seconds_it_took(oscillator, monkeypatch, method):
    """By a clock that is looked at twice."""
    now, module = iter([10.0, 12.5]), {"structure_preserving": "energy_preserving"}.get(method, method)
    monkeypatch.setattr(f"vsb.integrators.{module}.clock", SimpleNamespace(perf_counter=lambda: next(now)))
    system = oscillator
    if method == "switching":
        forces = {**oscillator.scene.forces, "pto": TakeOff(np.ones(1), 1.2)}
        system = System.of(replace(oscillator.scene, forces=forces))
    follow = METHODS[method].follower(system, 1e-3, None)
    motion, _ = follow(np.linspace(0.0, 1.0, 11), (np.array([0.1]), np.array([0.3])))
    assert motion.seconds == 2.5
    assert motion.time.tolist() == np.linspace(0.0, 1.0, 11).tolist()
