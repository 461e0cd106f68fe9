"""Take-offs that switch: exact between events, against closed forms, an independent integrator and the linear answer."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from vsb.errors import ConvergenceError
from vsb.hydro.statespace import RadiationModel
from vsb.integrators.audit import energies, residual
from vsb.integrators.energy_preserving import structure_preserving
from vsb.integrators.exact import propagate
from vsb.integrators.harmonic_balance import harmonic_balance
from vsb.integrators.phases import Signals
from vsb.integrators.settled import settled_power
from vsb.integrators.simulate import legs, simulate
from vsb.integrators.switching import Mode, Switching, switched
from vsb.integrators.track import dips
from vsb.motion.forces import Damper, Excitation, QuadraticDrag, RadiationMemory, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.motion.take_off import EndStop, TakeOff
from vsb.study.sections import Simulation
from vsb.waves.seas import Sea

B, MASS, SPRING, DRAG = np.array([1.0]), 2.0, 50.0, 0.3
TIME = np.linspace(0.0, 12.0, 801)
START = np.array([0.1]), np.array([0.3])
WAVES = Excitation(np.array([2.0, 3.3]), np.array([[30.0 + 5j], [-4j]]))
LAWS = {
    "saturated": (TakeOff(B, 4.0, 5.0, 8.0), None),
    "negative spring": (TakeOff(B, 4.0, -20.0, 12.0), None),
    "coulomb": (TakeOff(B, np.inf, limit=8.0), None),
    "end stop": (TakeOff(B, 4.0), EndStop(B, 0.4, 5e3, 200.0)),
    "latching": (TakeOff(B, 4.0, pause=0.3), None),
    "latching within a force": (TakeOff(B, 4.0, limit=15.0, pause=0.3), EndStop(B, 0.8, 5e3, 200.0)),
    "declutching": (TakeOff(B, 4.0, limit=8.0, pause=0.3, paused_damping=0.0), None),
    "hydraulic, declutched": (TakeOff(B, np.inf, limit=9.0, pause=0.3, paused_damping=0.0), None),
}


def oscillator(law, stop=None, waves=WAVES, drag=DRAG):
    """2 y'' + drag y' + 50 y = waves + take-off + stop."""
    forces = {"hydrostatic": Spring(np.array([[SPRING]])), "pto": law}
    forces |= {"structural_damping": Damper(np.array([[drag]]))} if drag else {}
    forces |= {"excitation": waves} if waves else {}
    forces |= {"end_stop": stop} if stop else {}
    return System.of(Scene(("Heave",), np.array([[MASS]]), forces, np.eye(1)))


@pytest.fixture(scope="module")
def shell():
    """Three coupled motions with two dampers, waves and a memory of two states; a take-off on a mixture of them."""
    rng = np.random.default_rng(11)
    mass, stiffness, damping = (root @ root.T + np.eye(3) for root in rng.normal(size=(3, 3, 3)))
    channel, turning = np.array([1.0, 0.5]), np.array([[0.0, 1.0], [-1.0, 0.0]])
    memory = RadiationModel(turning - np.outer(channel, channel) / 2, rng.normal(size=(2, 3)), channel)
    forces = {
        "hydrostatic": Spring(5 * stiffness),
        "structural_damping": Damper(0.1 * damping),
        "excitation": Excitation(np.array([1.3, 2.1]), rng.normal(size=(2, 3)) + 1j * rng.normal(size=(2, 3))),
        "radiation": RadiationMemory(memory),
    }
    return Scene(("Heave", "Radial2", "Radial3"), mass, forces, np.eye(3))


def reference(law, stop, time, rtol=1e-12):
    """The oscillator by an explicit method of order 8 from event to event, pieces chosen by its own few lines."""
    position, velocity = float(START[0][0]), float(START[1][0])

    def wave(t):
        return np.real(np.exp(-1j * WAVES.omega * t) @ WAVES.phasors[:, 0])

    def stopped(y, v):
        beyond = np.sign(y) * max(abs(y) - stop.stroke, 0.0) if stop else 0.0
        return -stop.stiffness * beyond - stop.damping * v * (beyond * v > 0) if beyond else 0.0

    def net(t, y):
        return wave(t) - SPRING * y + stopped(y, 0.0)

    out, t, until, way = np.full(len(time), np.nan), float(time[0]), -1.0, int(np.sign(velocity))
    while t < time[-1]:
        paused = until > t + 1e-12
        friction = np.isinf(law.paused_damping if paused else law.damping)

        def rates(s, z, paused=paused, friction=friction, way=way):
            if friction and way == 0:
                return [0.0, 0.0]
            c, k = (law.paused_damping, 0.0) if paused else (law.damping, law.stiffness)
            taken = law.limit * way if friction else np.clip(c * z[1] + k * z[0], -law.limit, law.limit)
            return [z[1], (wave(s) - SPRING * z[0] - DRAG * z[1] - taken + stopped(z[0], z[1])) / MASS]

        events = [lambda s, z, until=until, paused=paused: until - s if paused else 1.0]
        if friction and way == 0:
            events.append(lambda s, z: law.limit - abs(net(s, z[0])) if np.isfinite(law.limit) else 1.0)
        else:
            events.append(lambda s, z, way=way: way * z[1])
            if np.isfinite(law.limit) and not friction:
                c, k = law.damping, law.stiffness
                events.append(lambda s, z, c=c, k=k: law.limit - abs(c * z[1] + k * z[0]))
        if stop:
            events.append(lambda s, z: abs(z[0]) - stop.stroke)
        for event in events[:2]:
            event.terminal, event.direction = True, -1
        found = solve_ivp(rates, (t, time[-1]), [position, velocity], "DOP853", rtol=rtol, atol=1e-14, events=events,
                          dense_output=True, max_step=0.02)  # fmt: skip
        inside = (time >= t) & (time <= found.t[-1])
        if inside.any():
            out[inside] = found.sol(time[inside])[0]
        t, (position, velocity) = float(found.t[-1]), found.y[:, -1]
        if found.status == 0:
            break
        if len(found.t_events[0]):  # the pause is over
            until, way = -1.0, way or int(np.sign(net(t, position)))
        else:
            if law.pause and until < 0 and way:
                until = t + law.pause
            friction = np.isinf(law.paused_damping if until > t + 1e-12 else law.damping)
            push = net(t, position)
            if way == 0:
                way = int(np.sign(push))
            elif friction:
                way, velocity = (0 if abs(push) <= law.limit else int(np.sign(push))), 0.0
            else:
                way, velocity = -way, 0.0
    return out


@pytest.mark.parametrize("name", LAWS)
def test_motion_is_that_of_an_independent_integrator(name):
    """Events and pieces found by scipy's at 1e-12; steps over kinks limit it to some 1e-8."""
    law, stop = LAWS[name]
    system = oscillator(law, stop)
    motion, switches = switched(system, TIME, START)
    expected = reference(law, stop, TIME)
    assert switches > 5
    assert np.abs(motion.position[:, 0] - expected).max() < (2e-7 if stop else 1e-9) * np.abs(expected).max()


@pytest.mark.parametrize("name", LAWS)
def test_the_audit_closes_and_forces_stay_within_their_limits(name):
    law, stop = LAWS[name]
    system = oscillator(law, stop)
    motion, _ = switched(system, TIME, START)
    assert residual(energies(system, motion)) < 1e-8
    total = sum(system.forces(motion).values())
    assert MASS * motion.acceleration == pytest.approx(total, abs=1e-10)
    assert np.abs(motion.forces["pto"]).max() <= law.limit * (1 + 1e-12)
    assert not stop or np.abs(motion.position).max() < 1.1 * stop.stroke
    if np.isfinite(law.limit):
        assert np.abs(motion.forces["pto"]).max() > 0.999 * law.limit


@pytest.mark.parametrize("law", [TakeOff(B, 0.8, 1.5), TakeOff(B, 0.8, -0.2)], ids=["spring", "negative spring"])
def test_a_law_without_limits_is_the_linear_take_off(shell, law):
    """Memory, three motions, port on a mixture of them."""
    law = replace(law, direction=np.array([1.0, 0.3, -0.2]))
    outer = np.outer(law.direction, law.direction)
    linear = {"pto": Damper(law.damping * outer), "spring": Spring(law.stiffness * outer)}
    time, start = np.linspace(0.0, 20.0, 1001), (np.array([0.1, 0.2, -0.1]), np.array([0.3, 0.0, 0.1]))
    system = System.of(replace(shell, forces={**shell.forces, "pto": law}))
    motion, _ = switched(system, time, start)
    expected = propagate(System.of(replace(shell, forces={**shell.forces, **linear})), time, start)
    for part in ("position", "velocity", "acceleration", "memory"):
        assert getattr(motion, part) == pytest.approx(getattr(expected, part), abs=1e-11)
    force = -(expected.velocity @ outer * law.damping + expected.position @ outer * law.stiffness)
    assert motion.forces["pto"] == pytest.approx(force, abs=1e-10)


@pytest.mark.parametrize("name", LAWS)
def test_laws_on_a_shell_with_memory_close_their_audit(shell, name):
    law, stop = (part and replace(part, direction=np.array([1.0, 0.3, -0.2])) for part in LAWS[name])
    law = replace(law, limit=law.limit / 20)  # of the size of this scene's forces
    forces = {**shell.forces, "pto": law} | ({"end_stop": replace(stop, stroke=0.05)} if stop else {})
    system = System.of(replace(shell, forces=forces))
    motion, switches = switched(system, np.linspace(0.0, 20.0, 1001), (np.zeros(3), np.zeros(3)))
    assert switches > 5
    assert residual(energies(system, motion)) < 1e-7


def test_friction_takes_its_share_of_every_swing_and_then_holds():
    """2 y'' + 50 y = -F sign y': every half swing ends 2 F/50 nearer to the middle, until the spring is too weak."""
    system = oscillator(TakeOff(B, np.inf, limit=3.0), waves=None, drag=0.0)
    half = np.pi / 5
    motion, switches = switched(system, np.arange(0, 201) * half / 20, (np.ones(1), np.zeros(1)))
    turning = motion.position[::20, 0]
    left = 1.0 - 2 * 0.06 * np.arange(len(turning))
    left = np.where(left > 0, left, left[left > 0][-1])
    assert turning[:9] == pytest.approx(((-1.0) ** np.arange(9)) * left[:9], abs=1e-12)
    assert np.all(motion.position[-40:] == motion.position[-1])
    assert np.abs(motion.velocity[-40:]).max() < 1e-30
    assert motion.forces["pto"][-1] == pytest.approx(50 * motion.position[-1])
    assert switches == 8


def test_no_step_enters_but_the_lookout_and_that_not_either():
    """Motion and events at twice and half the recorded step, at twice the lookout: equal to round-off."""
    for law, stop in LAWS.values():
        system = oscillator(law, stop)
        whole = Switching(system)
        motion, _ = whole.follow(TIME, START)
        coarse, _ = switched(system, TIME[::2], START)
        assert coarse.position == pytest.approx(motion.position[::2], abs=1e-10)
        twice = Switching(system)
        track, _ = twice.track(TIME, system.first(START), 2 * whole.finer(TIME[1]))
        again, _ = whole.track(TIME, system.first(START), whole.finer(TIME[1]))
        assert track.events == pytest.approx(again.events, abs=1e-9)


def test_how_far_it_looks_ahead_and_how_much_is_accounted_for_at_a_time_change_nothing(monkeypatch):
    runs = [switched(oscillator(law, stop), TIME, START) for law, stop in LAWS.values()]
    monkeypatch.setattr("vsb.integrators.switching.CLOSE", 1)
    monkeypatch.setattr("vsb.integrators.phases.Phase.reach", 3)
    monkeypatch.setattr("vsb.integrators.works.AT_ONCE", 7)
    monkeypatch.setattr("vsb.integrators.switching.AT_ONCE", 50)
    for (motion, switches), (law, stop) in zip(runs, LAWS.values(), strict=True):
        again, as_many = switched(oscillator(law, stop), TIME, START)
        assert as_many == switches
        assert again.position == pytest.approx(motion.position, abs=1e-11)
        assert again.time == pytest.approx(TIME)
        for term in motion.works:
            assert again.works[term] == pytest.approx(motion.works[term], abs=1e-10)


@pytest.mark.parametrize(("tolerance", "finer"), [(1e-9, 32), (1e-6, 32), (64e-6, 16), (4.096e-3, 8), (np.inf, 8)])
def test_the_lookout_is_as_coarse_as_a_rule_of_order_six_may_be(tolerance, finer):
    """5 rad/s: 20 quarters of a radian in a second, rounded up to a power of two; up to four times as far apart."""
    assert Switching(oscillator(LAWS["saturated"][0], drag=0), tolerance).finer(1.0) == finer


@pytest.mark.parametrize(("position", "contact"), [(0.69, 0), (0.71, 1), (-0.09, 0), (-0.11, -1)])
def test_a_run_begins_in_contact_where_the_stroke_from_the_rest_of_the_law_is_beyond_the_stop(position, contact):
    law, stop = (replace(x, rest=0.3) for x in LAWS["end stop"])
    one = Switching(oscillator(law, stop))
    state, lookout = one.system.first((np.array([position]), np.array([0.3]))), one.lookout(TIME, 1)
    assert one.first(0.0, one.fresh(0.0, state, lookout), lookout).contact == contact


def test_a_state_under_another_force_is_another_state():
    one = Switching(oscillator(LAWS["coulomb"][0]))
    state = one.fresh(0.0, one.system.first(START), one.lookout(TIME, 1))
    before = state.copy()
    pushed = one.under(3.5, state)
    np.testing.assert_array_equal(state, before)
    assert sorted(pushed - before) == [0.0] * (len(state) - 1) + [3.5]


@pytest.mark.parametrize(("position", "way"), [(0.5, -1), (-0.5, 1)])
def test_what_begins_at_rest_goes_where_it_is_pushed(position, way):
    """The spring of the water alone."""
    one = Switching(oscillator(LAWS["saturated"][0], waves=None))
    state, lookout = one.system.first((np.array([position]), np.zeros(1))), one.lookout(TIME, 1)
    assert one.first(0.0, one.fresh(0.0, state, lookout), lookout).way == way


def test_a_stop_costs_only_where_it_is_pressed():
    """One out of reach: the very motion without it; one met: some fine instants, the same at each lookout."""
    law, time = LAWS["end stop"][0], np.linspace(0.0, 12.0, 61)
    free, out_of_reach, met = (
        Switching(oscillator(law, stop)) for stop in (None, EndStop(B, 10.0, 5e5, 200.0), LAWS["end stop"][1])
    )
    tracks = [one.track(time, one.system.first(START), one.finer(time[1]))[0] for one in (free, out_of_reach, met)]
    assert out_of_reach.finer(time[1]) == 128 * free.finer(time[1])
    nodes, same, more = (np.concatenate(track.times) for track in tracks)
    np.testing.assert_allclose(same, nodes, atol=1e-14)
    pressed = np.array([bool(mode.contact) for mode in tracks[2].modes])
    step = tracks[2].lookout.step
    assert 0 < np.count_nonzero(np.diff(more) <= step * (1 + 1e-9)) <= np.count_nonzero(pressed) + len(tracks[2].events)
    assert np.diff(more)[pressed[:-1]].max() <= step * (1 + 1e-9)
    assert np.diff(more)[~pressed[:-1]].max() == pytest.approx(step * tracks[2].lookout.stride)


@pytest.mark.parametrize("part", [0, 1, 38, 39])
def test_friction_that_lets_go_does_so_once(part):
    """It begins without velocity and acceleration: round-off alone made it turn round, and stick again, at once."""
    law, stop = LAWS["coulomb"]
    start = tuple(value * (1 + part * 1e-13) for value in START)
    whole = Switching(oscillator(law, stop))
    track, _ = whole.track(TIME, whole.system.first(start), 2 * whole.finer(TIME[1]))
    assert len(track.events) == 13
    assert np.diff(track.events).min() > 0.3


def test_two_switches_between_instants_of_the_lookout_are_seen(monkeypatch):
    """Spans of more than half a radian of the buoy's own motion: a limit met and left between two instants."""
    system, time = oscillator(*LAWS["saturated"]), np.linspace(0.0, 12.0, 97)
    exact, switches = switched(system, time, START)
    monkeypatch.setattr("vsb.integrators.switching.RESOLVED", 1e9)
    found, again = switched(system, time, START)
    assert again == switches
    assert found.position == pytest.approx(exact.position, abs=1e-8)


def test_a_dip_is_seen_by_values_and_rates_at_its_ends():
    s = np.array([0.0, 1.0, 2.0])
    assert dips((s - 0.4) ** 2 - 1e-3, 2 * (s - 0.4)) == [(0, pytest.approx(0.4))]
    assert dips((s - 0.4) ** 2 + 1e-3, 2 * (s - 0.4)) == []
    assert dips(-((s - 0.4) ** 2) + 1.0, -2 * (s - 0.4)) == []


@pytest.mark.parametrize("name", LAWS)
def test_a_run_in_legs_is_the_whole_run(name):
    """The mode, held or paused, goes over the border of a leg."""
    system, sea = oscillator(*LAWS[name]), Sea(WAVES.omega, np.array([0.1, 0.1]))
    setting = Simulation(duration=12.0, window=(6.0, 12.0), initial_position=0.1, initial_velocity=0.3)
    whole, stride, method = simulate(system, sea, setting, None)
    assert method.startswith("exact propagation between switches, ")
    parts = list(legs(system, sea, setting, None, longest=150))
    assert len(parts) > 3
    position = np.concatenate([part.motion.position[bool(i) :: part.stride] for i, part in enumerate(parts)])
    assert position == pytest.approx(whole.position[::stride], abs=1e-9)
    assert parts[-1].balance.residual < 1e-7


@settings(max_examples=15)
@given(st.floats(0.5, 20.0), st.floats(0.5, 30.0), st.floats(0.2, 1.0), st.integers(0, 2**32 - 1))
def test_any_law_keeps_its_limits_and_its_energy(damping, limit, stroke, seed):
    rng = np.random.default_rng(seed)
    spring = rng.choice([0.0, 0.0, 30.0, -0.8 * SPRING]) * rng.random()
    law = TakeOff(B, damping if rng.random() < 0.7 else np.inf, spring, limit, rng.random() * 0.5 * (rng.random() < 0.6),
                  np.inf if rng.random() < 0.5 else 0.0)  # fmt: skip
    stop = EndStop(B, stroke, 5e3, 200.0) if rng.random() < 0.5 else None
    system = oscillator(law, stop, drag=float(rng.random()))
    motion, _ = switched(system, TIME[:401], (rng.normal(size=1) * 0.3, rng.normal(size=1)))
    assert residual(energies(system, motion)) < 1e-6
    assert np.abs(motion.forces["pto"]).max() <= limit * (1 + 1e-12)
    assert spring or np.all(motion.forces["pto"] * motion.velocity <= 1e-9)


def test_a_limit_left_and_met_again_on_the_other_side_at_once_does_not_chatter():
    """A guard that has just vanished is negative by round-off, and negative again at the end of its lookout."""
    system = oscillator(TakeOff(B, 15.599975418751978, limit=0.5), drag=0.35912332)
    motion, switches = switched(system, TIME[:401], (np.array([-0.02936286]), np.array([0.61980221])))
    assert 5 < switches < 100
    assert residual(energies(system, motion)) < 1e-7


def steady_power(law, omega, force):
    """Mean power of the last of many periods in a regular wave [W], and the amplitude of the velocity."""
    system = oscillator(law, waves=Excitation(np.array([omega]), np.array([[force + 0j]])))
    period = 2 * np.pi / omega
    motion, _ = switched(system, np.linspace(0.0, 60 * period, 60 * 64 + 1), (np.zeros(1), np.zeros(1)))
    return (motion.works["pto"][-1] - motion.works["pto"][-65]) / period, np.abs(motion.velocity[-65:]).max()


def test_a_damper_below_its_limit_is_the_linear_answer():
    """P = c |V|^2/2, V = F/Z."""
    power, velocity = steady_power(TakeOff(B, 4.0, limit=100.0), 3.0, 30.0)
    expected = 30.0 / abs(DRAG + 4.0 + 1j * (50.0 / 3.0 - 3.0 * MASS))
    assert velocity == pytest.approx(expected, rel=1e-3)
    assert power == pytest.approx(2.0 * expected**2, rel=1e-9)


@pytest.mark.parametrize("share", [0.9, 0.5, 0.2])
def test_a_saturated_damper_takes_what_its_describing_function_says_within_its_harmonics(share):
    """c_eq = 2c/pi (asin x + x sqrt(1 - x^2)), x = limit/(c V), and a bound of what it neglects.

    The law g is c-Lipschitz, so beyond the first harmonic v = v1 + w has |w| <= h/(z - c), with h the rms of g(v1)
    there and z the least impedance there. Hence |Z + c_eq| V is within sqrt(2) c |w| of the wave's force, and the power
    within (c |v| + h) |w| of c_eq V^2/2.
    """
    omega, force, damping, drag = 5.0, 30.0, 0.5, 1.0
    limit = share * damping * force / (drag + damping)
    first, higher = (drag + 1j * (SPRING / w - w * MASS) for w in (omega, 3 * omega))

    def equivalent(v):
        x = min(1.0, limit / (damping * v))
        return 2 * damping / np.pi * (np.arcsin(x) + x * np.sqrt(1 - x * x))

    def beyond(v):
        """Rms of the harmonics of the force that the describing function leaves out, and of their velocity."""
        samples = np.clip(damping * v * np.cos(np.linspace(0.0, 2 * np.pi, 4096, endpoint=False)), -limit, limit)
        h = np.sqrt(max(np.mean(samples**2) - (equivalent(v) * v) ** 2 / 2, 0.0))
        return h, h / (abs(higher) - damping)

    def velocity(sign):
        def unbalanced(v):
            return v * abs(first + equivalent(v)) + sign * np.sqrt(2) * damping * beyond(v)[1] - force

        return brentq(unbalanced, 1e-3, 100.0)

    low, high = velocity(1.0), velocity(-1.0)
    h, w = beyond(high)
    slack = (damping * np.hypot(high / np.sqrt(2), w) + h) * w
    bounds = [0.5 * equivalent(v) * v * v + sign * slack for v, sign in ((low, -1.0), (high, 1.0))]
    waves = Excitation(np.array([omega]), np.array([[force + 0j]]))
    power, unsettled = settled_power(oscillator(TakeOff(B, damping, limit=limit), waves=waves, drag=drag))
    assert unsettled <= 1e-6
    assert bounds[0] < power < bounds[1]
    assert bounds[1] - bounds[0] < 0.03 * power


def in_regular_wave(law, stop=None, omega=3.0):
    return oscillator(law, stop, Excitation(np.array([omega]), np.array([[30.0 + 0j]])), drag=1.0)


@pytest.mark.parametrize(
    ("law", "stop"),
    [
        (TakeOff(B, 8.0, limit=100.0), None),
        (TakeOff(B, 8.0, limit=8.0), None),
        (TakeOff(B, 8.0, 10.0, limit=4.0), None),
        (TakeOff(B, 8.0, -20.0, limit=12.0), None),
        (TakeOff(B, 2.0), EndStop(B, 0.8, 100.0, 0.0)),
    ],
    ids=["linear", "saturated", "spring", "negative spring", "end stop"],
)
def test_harmonic_balance_is_what_a_run_settles_at(law, stop):
    """A tangent in the velocity, too: where the law rules, Newton's method needs it."""
    system = in_regular_wave(law, stop)
    expected, unsettled = settled_power(system)
    found = harmonic_balance(system, 1e-5)
    assert unsettled < 1e-6
    assert found.error <= 1e-5
    assert found.power.pto == pytest.approx(expected, rel=5e-5)
    assert found.power.residual < 1e-4
    assert 0 < found.decay < 1


def test_harmonic_balance_of_friction_is_coarse_and_refused_beyond():
    """A force that jumps: its harmonics fall slowly."""
    system = in_regular_wave(TakeOff(B, np.inf, limit=2.0))
    assert harmonic_balance(system, 3e-3).power.pto == pytest.approx(settled_power(system)[0], rel=1e-2)
    with pytest.raises(
        ConvergenceError, match=r"the steady state is known to .* harmonics, needs 1e-06; use a gentler"
    ):
        harmonic_balance(system, 1e-6)


def test_a_latched_port_does_not_move_and_a_declutched_one_feels_nothing():
    held, _ = switched(oscillator(TakeOff(B, 4.0, pause=0.3)), TIME, START)
    still = np.abs(held.velocity[:, 0]) < 1e-14
    assert 0.15 < still.mean() < 0.8
    loose, _ = switched(oscillator(TakeOff(B, 4.0, pause=0.3, paused_damping=0.0)), TIME, START)
    nothing = (loose.forces["pto"][:, 0] == 0.0) & (np.abs(loose.velocity[:, 0]) > 0.01)
    assert 0.2 < nothing.mean() < 0.8


def test_who_cannot_follow_switches_says_so(monkeypatch):
    system = oscillator(TakeOff(B, 4.0, limit=8.0))
    with pytest.raises(ValueError, match="exact propagation: received nonlinear forces"):
        propagate(system, TIME, START)
    with pytest.raises(ValueError, match=r"received a take-off that switches, needs smooth forces; use .switched."):
        structure_preserving(system, TIME, START, 1e-6)
    with pytest.raises(
        ValueError, match="harmonic balance: received a take-off that pauses, needs one without; follow"
    ):
        harmonic_balance(oscillator(TakeOff(B, 4.0, pause=0.3), waves=Excitation(np.ones(1), np.ones((1, 1)) + 0j)))
    with pytest.raises(
        ValueError, match="switching: received the nonlinear forces none, needs a linear or body-exact scene"
    ):
        Switching(oscillator(Damper(np.eye(1))))
    monkeypatch.setattr("vsb.integrators.switching.MOST_EVENTS", 0)
    with pytest.raises(ConvergenceError, match=r"the take-off switches without end at t = 0.*larger force_limit"):
        switched(system, TIME, START)


MODES = {
    "damped": Mode(1), "the other way": Mode(-1), "limited": Mode(1, limited=1), "limited below": Mode(-1, limited=-1),
    "pressed": Mode(1, contact=1), "pressed below": Mode(1, contact=-1), "leaving": Mode(-1, contact=1),
}  # fmt: skip


@pytest.mark.parametrize("mode", MODES.values(), ids=MODES)
@pytest.mark.parametrize("start", [(0.3, 0.7), (-0.5, 0.2), (0.9, -0.4)])
def test_rates_of_guards_are_their_derivatives(mode, start):
    """By differences over 20 microseconds of the exact motion, on a port of a mass that is not one."""
    law, stop = TakeOff(B, 4.0, 5.0, 8.0), EndStop(B, 0.4, 5e3, 200.0)
    found = Switching(oscillator(law, stop), 1e-6)
    phase, constant = found.phase(mode, found.lookout(TIME, 1))
    transient, s, h = phase.transient(0.2, np.array([*start, constant])), 5e-3, 1e-5
    here = phase.later(transient, s)[None]
    at = phase.watched(np.array([0.2 + s]), phase.states(np.array([0.2 + s]), here))
    rates = found.rates(mode, at)
    assert rates.keys() == {"turn", "limit", "stop"}
    for name, rate in rates.items():
        ends = [found.guard(name, mode, phase, 0.2, transient, s + side) for side in (-h, h)]
        assert rate[0] == pytest.approx((ends[1] - ends[0]) / (2 * h), rel=1e-6, abs=1e-6), name


@pytest.mark.parametrize(
    ("mode", "guards"),
    [
        (Mode(1), {"turn": -2.0, "limit": 8.0 - 6.5, "stop": 0.1}),
        (Mode(-1), {"turn": 2.0, "limit": 8.0 - 6.5, "stop": 0.1}),
        (Mode(1, limited=1), {"turn": -2.0, "limit": -6.5 - 8.0, "stop": 0.1}),
        (Mode(1, limited=-1), {"turn": -2.0, "limit": 6.5 - 8.0, "stop": 0.1}),
        (Mode(1, contact=1), {"turn": -2.0, "limit": 1.5, "stop": 0.3 - 0.4}),
        (Mode(1, contact=-1), {"turn": -2.0, "limit": 1.5, "stop": -0.3 - 0.4}),
        (Mode(0), {"slip": 8.0 - 3.0, "stop": 0.1}),
        (Mode(1, paused=True, until=0.5), {"resume": 0.3, "turn": -2.0, "limit": 8.0, "stop": 0.1}),
    ],
)
def test_guards_are_what_is_left_to_each_event(mode, guards):
    """0.3 m and -2 m/s under 4 N s/m and 5 N/m: -6.5 N of at most 8; the stop is at 0.4 m; of a limited force, what is
    beyond the limit on its side; a paused one wants nothing.
    """
    law, stop = TakeOff(B, 4.0, 5.0, 8.0, pause=0.3, paused_damping=0.0), EndStop(B, 0.4, 5e3, 200.0)
    at = Signals(np.array([0.3]), np.array([-2.0]), np.array([-3.0]))
    found = Switching(oscillator(law, stop), 1e-6).guards(mode, at, np.array([0.2]))
    assert {name: value[0] for name, value in found.items()} == pytest.approx(guards, rel=1e-12)


def test_friction_and_a_law_without_limits_watch_no_limit():
    at = Signals(np.array([0.3]), np.array([2.0]), np.array([-3.0]))
    for law, names in ((TakeOff(B, np.inf, limit=8.0), {"turn"}), (TakeOff(B, 4.0), {"turn"})):
        found = Switching(oscillator(law), 1e-6)
        assert found.guards(Mode(1), at, np.zeros(1)).keys() == names
        assert found.rates(Mode(1), at).keys() == names


# laws, one by one ----------------------------------------------------------------------------------------------------


def signals(stroke=0.0, velocity=0.0, push=0.0):
    return Signals(stroke, velocity, push)


FRICTION, CLUTCH = TakeOff(B, np.inf, limit=8.0), TakeOff(B, np.inf, limit=9.0, pause=0.3, paused_damping=0.0)
SPRUNG, LATCH = TakeOff(B, 4.0, 5.0, 8.0), TakeOff(B, 4.0, 5.0, 8.0, pause=0.3)
LOOSE = TakeOff(B, 4.0, 5.0, 8.0, pause=0.3, paused_damping=0.0)


@pytest.mark.parametrize(("law", "event", "mode", "at", "expected"), [
    (SPRUNG, "turn", Mode(1, limited=1), signals(), Mode(-1, limited=1)),
    (SPRUNG, "turn", Mode(-1, contact=-1), signals(), Mode(1, contact=-1)),
    (FRICTION, "turn", Mode(1), signals(push=7.9), Mode(0)),
    (FRICTION, "turn", Mode(1), signals(push=-7.9), Mode(0)),
    (FRICTION, "turn", Mode(1), signals(push=8.0), Mode(0)),
    (FRICTION, "turn", Mode(1), signals(push=-8.1), Mode(-1)),
    (FRICTION, "turn", Mode(-1), signals(push=8.1), Mode(1)),
    (FRICTION, "slip", Mode(0), signals(push=-8.1), Mode(-1)),
    (FRICTION, "slip", Mode(0, contact=1), signals(push=8.1), Mode(1, contact=1)),
    (LATCH, "turn", Mode(-1, limited=-1), signals(push=50.0), Mode(1, paused=True, until=2.3)),
    (LATCH, "turn", Mode(-1, limited=-1), signals(push=7.0), Mode(0, paused=True, until=2.3)),
    (LOOSE, "turn", Mode(1, limited=1, contact=1), signals(), Mode(-1, contact=1, paused=True, until=2.3)),
    (LOOSE, "turn", Mode(1, paused=True, until=2.1), signals(), Mode(-1, paused=True, until=2.1)),
    (CLUTCH, "turn", Mode(1), signals(push=20.0), Mode(-1, paused=True, until=2.3)),
    (LATCH, "resume", Mode(0, paused=True, until=2.0), signals(0.1, 0.0, -3.0), Mode(-1)),
    (LATCH, "resume", Mode(0, paused=True, until=2.0), signals(1.7, 0.0, 3.0), Mode(1, limited=1)),
    (LATCH, "resume", Mode(0, paused=True, until=2.0), signals(-1.7, 0.0, 3.0), Mode(1, limited=-1)),
    (LOOSE, "resume", Mode(-1, paused=True, until=2.0), signals(0.1, -1.5, 9.0), Mode(-1)),
    (LOOSE, "resume", Mode(-1, paused=True, until=2.0), signals(0.1, -2.2, 9.0), Mode(-1, limited=-1)),
    (CLUTCH, "resume", Mode(-1, paused=True, until=2.0), signals(0.1, -2.2, 9.0), Mode(-1)),
    (SPRUNG, "limit", Mode(1), signals(0.0, 2.0), Mode(1, limited=1)),
    (SPRUNG, "limit", Mode(-1), signals(-0.1, -1.8), Mode(-1, limited=-1)),
    (SPRUNG, "limit", Mode(1, limited=1), signals(0.0, 2.0), Mode(1)),
    (SPRUNG, "stop", Mode(1), signals(stroke=-0.4), Mode(1, contact=-1)),
    (SPRUNG, "stop", Mode(1), signals(stroke=0.4), Mode(1, contact=1)),
    (SPRUNG, "stop", Mode(-1, contact=1, limited=-1), signals(stroke=0.4), Mode(-1, limited=-1)),
])  # fmt: skip
def test_what_is_in_force_after_an_event(law, event, mode, at, expected):
    """At 2 s; friction holds up to its limit, a law that pauses does so once, what comes free goes where it is pushed."""
    found = Switching(oscillator(law, EndStop(B, 0.4, 5e3, 200.0))).after(event, mode, 2.0, at)
    assert found == expected


@pytest.mark.parametrize(("law", "mode", "load"), [
    (SPRUNG, Mode(1), (4.0, 5.0, 1.5)), (SPRUNG, Mode(-1, limited=1), (0.0, 0.0, -8.0)),
    (SPRUNG, Mode(1, limited=-1), (0.0, 0.0, 8.0)), (FRICTION, Mode(1), (0.0, 0.0, -8.0)),
    (FRICTION, Mode(-1), (0.0, 0.0, 8.0)), (FRICTION, Mode(0), (0.0, 0.0, 0.0)),
    (LATCH, Mode(0, paused=True), (0.0, 0.0, 0.0)), (LOOSE, Mode(1, paused=True), (0.0, 0.0, 0.0)),
])  # fmt: skip
def test_what_the_take_off_does_in_a_mode(law, mode, load):
    """Its spring counts from where it rests, at 0.3 m."""
    found = Switching(oscillator(replace(law, rest=0.3))).taken(mode)
    assert found == pytest.approx(load)


@pytest.mark.parametrize(("mode", "load"), [
    (Mode(1), (0.0, 0.0, 0.0)), (Mode(1, contact=1), (200.0, 5e3, 5e3 * 0.7)), (Mode(-1, contact=1), (0.0, 5e3, 5e3 * 0.7)),
    (Mode(-1, contact=-1), (200.0, 5e3, -5e3 * 0.1)), (Mode(1, contact=-1), (0.0, 5e3, -5e3 * 0.1)),
    (Mode(0, contact=1), (0.0, 5e3, 5e3 * 0.7)),
])  # fmt: skip
def test_what_the_end_stop_does_in_a_mode(mode, load):
    """It damps what presses it further alone; 0.4 m from where the buoy rests, at 0.3 m."""
    found = Switching(oscillator(replace(SPRUNG, rest=0.3), EndStop(B, 0.4, 5e3, 200.0, rest=0.3))).stopped(mode)
    assert found == pytest.approx(load)
    assert Switching(oscillator(SPRUNG)).stopped(mode) == (0.0, 0.0, 0.0)


def test_a_regime_is_that_of_both_laws_together_and_made_once():
    """Coefficients add, and so do constant forces; a held port and steps of another length are other regimes."""
    one = Switching(oscillator(replace(SPRUNG, rest=0.1), EndStop(B, 0.4, 5e3, 200.0, rest=0.1)))
    lookout = one.lookout(TIME, 4)
    phase, f = one.phase(Mode(1, contact=1), lookout)
    assert (phase.damping, phase.stiffness, phase.held, phase.rest) == (204.0, 5005.0, False, 0.1)
    assert f == pytest.approx(5.0 * 0.1 + 5e3 * 0.5)
    assert phase.step == lookout.step
    limited, push = one.phase(Mode(1, limited=1, contact=1), lookout)
    assert (limited.damping, limited.stiffness, push) == (200.0, 5e3, pytest.approx(5e3 * 0.5 - 8.0))
    assert one.phase(Mode(1, contact=1, until=3.0), lookout)[0] is phase
    assert one.phase(Mode(1), lookout)[0].step == lookout.step * lookout.stride
    assert one.phase(Mode(0), lookout)[0].held


def test_the_rate_of_a_port_is_the_fastest_of_its_springs_and_dampers():
    """2 kg on 50 N/m: under 50 + 22 N/m 6 rad/s, with a stop of 288 N/m 13, under a damper c/2; friction damps none."""

    def rate(law, stop=None):
        return Switching(oscillator(law, drag=0.0)).rate(stop)

    assert rate(TakeOff(B, 1.0)) == pytest.approx(5.0)
    assert rate(TakeOff(B, 1.0, 22.0)) == pytest.approx(6.0)
    assert rate(TakeOff(B, 1.0, -32.0)) == pytest.approx(5.0)
    assert rate(TakeOff(B, 30.0)) == pytest.approx(15.0)
    assert rate(TakeOff(B, 1.0, pause=0.3, paused_damping=40.0)) == pytest.approx(20.0)
    assert rate(FRICTION) == pytest.approx(5.0)
    assert rate(TakeOff(B, 1.0), EndStop(B, 0.4, 288.0, 2.0)) == pytest.approx(13.0)
    assert rate(TakeOff(B, 1.0), EndStop(B, 0.4, 2.0, 100.0)) == pytest.approx(50.0)


@pytest.mark.parametrize(("angle", "instants"), [(0.1, 1), (0.25, 1), (0.26, 2), (0.5, 2), (0.51, 4), (1e6, 2**22)])
def test_instants_of_the_lookout_resolve_a_quarter_of_a_radian(angle, instants):
    assert Switching(oscillator(SPRUNG))._instants(angle) == instants


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_port_that_is_held_loses_its_velocity_and_the_other_modes_keep_theirs(shell, way):
    law = replace(LAWS["coulomb"][0], direction=way * np.array([1.0, 0.3, -0.2]))
    one = Switching(System.of(replace(shell, forces={**shell.forces, "pto": law})))
    z = np.arange(1.0, 9.0)
    found = one.held(z)
    assert one.port @ found[3:6] == pytest.approx(0.0, abs=1e-12)
    across = np.cross(one.port, [0.3, 1.0, 2.0])
    assert across @ found[3:6] == pytest.approx(across @ z[3:6])
    np.testing.assert_array_equal(np.delete(found, [3, 4, 5]), np.delete(z, [3, 4, 5]))
    assert z.tolist() == list(range(1, 9))


# when ----------------------------------------------------------------------------------------------------------------


def event_of(monkeypatch, guards, broken, span=2.0):
    """When the first of some guards, functions of time, vanishes in a span, and its name."""
    monkeypatch.setattr(Switching, "guard", lambda self, name, mode, phase, t, transient, s: guards[name](s))
    return Switching(oscillator(SPRUNG)).next_event(broken, Mode(1), None, 0.0, None, span)


def test_of_several_guards_the_one_that_vanishes_first_is_the_event(monkeypatch):
    guards = {"turn": lambda s: 1.4 - s, "limit": lambda s: 1.1 - s, "stop": lambda s: 1.7 - s}
    assert event_of(monkeypatch, guards, dict.fromkeys(guards, 1.0)) == (pytest.approx(1.1, rel=1e-14), "limit")


def test_a_guard_that_dips_inside_a_span_vanishes_before_its_bottom(monkeypatch):
    """Below zero from 0.6 to 1.4 of 2 s."""
    dip = {"turn": lambda s: (s - 0.6) * (s - 1.4)}
    assert event_of(monkeypatch, dip, {"turn": 0.5}) == (pytest.approx(0.6, rel=1e-14), "turn")


def test_a_guard_that_is_set_up_by_the_event_before_is_looked_at_a_little_later(monkeypatch):
    """It rises from zero and falls again at 1.5 s, or falls at once; what round-off alone breaks vanishes at the end."""
    rising, falling = {"turn": lambda s: s * (1.5 - s)}, {"turn": lambda s: -s}
    assert event_of(monkeypatch, rising, {"turn": 1.0}) == (pytest.approx(1.5, rel=1e-14), "turn")
    assert event_of(monkeypatch, falling, {"turn": 1.0}) == (0.0, "turn")
    for end in (0.0, 1e-18):
        assert event_of(monkeypatch, {"turn": lambda s, end=end: 2.0 - s + end}, {"turn": 1.0}) == (2.0, "turn")


def test_switches_without_end_are_told_by_their_instant_and_a_run_may_have_many(monkeypatch):
    """A thousand in the first recorded step, twice as many by the second: two of each four here."""
    monkeypatch.setattr("vsb.integrators.switching.MOST_EVENTS", 2)
    law, stop = LAWS["saturated"]
    assert switched(oscillator(law, stop), TIME[:401], START)[1] > 2 * 2
    monkeypatch.setattr("vsb.integrators.switching.MOST_EVENTS", 2 / 400)
    with pytest.raises(
        ConvergenceError, match=r"^the take-off switches without end at t = 0\.\d+ s; use a larger force"
    ):
        switched(oscillator(law, stop), TIME[:401], START)


def test_other_forces_that_are_not_linear_are_named():
    drag = QuadraticDrag(np.eye(1), np.array([3.0]), np.zeros(0), np.zeros((0, 1), dtype=complex))
    scene = oscillator(SPRUNG).scene
    with pytest.raises(
        ValueError, match=r"^switching: received the nonlinear forces drag, needs a linear or body-exact"
    ):
        Switching(System.of(replace(scene, forces={**scene.forces, "drag": drag})))
    renamed = {("other" if name == "pto" else name): force for name, force in scene.forces.items()}
    with pytest.raises(ValueError, match="received the nonlinear forces none, needs"):
        Switching(System.of(replace(scene, forces=renamed)))


# works ---------------------------------------------------------------------------------------------------------------


def test_works_of_a_law_that_is_linear_are_those_of_the_linear_scene(shell):
    """Each of its own: waves, take-off, other dampers, radiation; a port on a mixture of three motions."""
    law = replace(TakeOff(B, 0.8), direction=np.array([1.0, 0.3, -0.2]))
    damper = {"pto": Damper(law.damping * np.outer(law.direction, law.direction))}
    time, start = np.linspace(0.0, 20.0, 1001), (np.array([0.1, 0.2, -0.1]), np.array([0.3, 0.0, 0.1]))
    motion, _ = switched(System.of(replace(shell, forces={**shell.forces, "pto": law})), time, start)
    linear = System.of(replace(shell, forces={**shell.forces, **damper}))
    expected = energies(linear, propagate(linear, time, start))
    assert motion.works.keys() == {"wave", "pto", "structural", "radiated"}
    for term, work in motion.works.items():
        assert np.abs(expected[term]).max() > 0.1
        assert work == pytest.approx(expected[term], abs=1e-8 * np.abs(expected["wave"]).max()), term


@pytest.mark.parametrize("name", LAWS)
def test_works_are_those_of_the_forces_along_the_motion(name):
    """By the trapezoidal rule: what the law takes at its port, what drag and a stop's damper do, what the waves give."""
    law, stop = (part and replace(part, rest=0.05) for part in LAWS[name])
    stop = stop and replace(
        stop, stroke=0.3, damping=20.0
    )  # jumps, of which a sum over instants knows little, are small
    system, time = oscillator(law, stop), np.linspace(0.0, 4.0, 4001)
    motion, _ = switched(system, time, START)
    v, y = motion.velocity[:, 0], motion.position[:, 0]

    def work(power):
        return np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(time))])

    wave = np.real(np.exp(-1j * np.outer(time, WAVES.omega)) @ WAVES.phasors[:, 0])
    lost = work(DRAG * v**2)
    if stop:
        stored = stop.stored(motion.position)
        lost = lost + work(-motion.forces["end_stop"][:, 0] * v) - (stored - stored[0])
        assert np.ptp(stored) > 0.1
        assert motion.forces["end_stop"] == pytest.approx(stop.force(time, motion.position, motion.velocity), abs=1e-6)
    exact = {"wave": work(wave * v), "pto": work(-motion.forces["pto"][:, 0] * v), "structural": lost}
    size = np.abs(exact["wave"]).max()
    for term, found in exact.items():
        assert motion.works[term] == pytest.approx(found, abs=5e-3 * size), term
    assert not motion.works["radiated"].any()
    assert np.abs(y).max() > 0.1


def test_what_smooth_forces_store_beyond_their_tangents_is_taken_from_the_waves_from_the_start_on(monkeypatch):
    """The rest of the water's force is counted with the waves' while it is added: what is stored of it is no work."""
    system = oscillator(*LAWS["saturated"])
    plain, _ = switched(system, TIME[:101], START)
    monkeypatch.setattr(System, "beyond_tangents", lambda _, position: 3.0 + 7.0 * position[:, 0])
    motion, _ = switched(system, TIME[:101], START)
    beyond = 7.0 * (motion.position[:, 0] - START[0][0])
    assert np.abs(beyond).max() > 0.5
    np.testing.assert_allclose(motion.works["wave"], plain.works["wave"] + beyond, rtol=1e-12, atol=1e-12)
    for term in ("pto", "structural", "radiated"):
        np.testing.assert_array_equal(motion.works[term], plain.works[term])


@pytest.mark.parametrize(("law", "start", "mode"), [
    (FRICTION, (0.1, 0.0), Mode(0)), (FRICTION, (0.2, 0.0), Mode(-1)), (FRICTION, (-0.2, 0.0), Mode(1)),
    (FRICTION, (0.2, 0.3), Mode(1)), (FRICTION, (-0.2, -0.3), Mode(-1)),
    (SPRUNG, (0.1, 0.0), Mode(-1)), (SPRUNG, (-0.1, 0.0), Mode(1)), (SPRUNG, (0.1, -3.0), Mode(-1, limited=-1)),
    (SPRUNG, (0.1, 1.8), Mode(1)), (SPRUNG, (0.1, 1.9), Mode(1, limited=1)),
    (SPRUNG, (1.7, 0.0), Mode(-1, limited=1, contact=1)), (SPRUNG, (-1.7, 0.0), Mode(1, limited=-1, contact=-1)),
    (TakeOff(B, 4.0, 5.0), (1.7, 3.0), Mode(1, contact=1)), (FRICTION, (-0.5, 0.0), Mode(1, contact=-1)),
    (LATCH, (0.1, 0.0), Mode(-1)),
])  # fmt: skip
def test_a_run_begins_where_it_moves_or_is_pushed_to_on_the_pieces_it_is_on(law, start, mode):
    """Under the spring of the water alone, 50 N/m, and a stop at 0.4 m; friction up to 8 N holds what does not move."""
    one = Switching(oscillator(law, EndStop(B, 0.4, 5e3, 200.0), waves=None))
    state, lookout = one.system.first(tuple(np.array([x]) for x in start)), one.lookout(TIME, 1)
    assert one.first(0.0, one.fresh(0.0, state, lookout), lookout) == mode


def test_a_motion_with_switches_is_followed_to_a_millionth_unless_asked_otherwise(monkeypatch):
    known = []
    monkeypatch.setattr(Switching, "follow", lambda self, time, start: known.append((self.tolerance, time, start)) or 7)
    assert switched(oscillator(SPRUNG), "time", "start") == switched(oscillator(SPRUNG), "time", "start", 1e-3) == 7
    assert known == [(1e-6, "time", "start"), (1e-3, "time", "start")]
    assert Switching(oscillator(SPRUNG)).tolerance == 1e-6


@pytest.mark.parametrize(("largest", "least", "limit"), [(0.5, 2.0, 2e-6), (3.0, 2.0, 3e-6), (0.0, 2.0, 2e-6)])
def test_a_lookout_is_made_finer_until_errors_are_small_beside_the_motion_or_what_matters(
    monkeypatch, largest, least, limit
):
    """The mode a leg ends in is noted for the next one, of the lookout that serves."""
    asked, one = [], Switching(oscillator(SPRUNG), 1e-6)

    def track(self, time, z, finer):
        asked.append(finer)
        error = limit * (0.99 if len(asked) == 3 else 1.01)
        return SimpleNamespace(error=error, largest=largest, lookout=SimpleNamespace(step=0.5)), f"mode {finer}"

    monkeypatch.setattr(System, "least", property(lambda _: least))
    monkeypatch.setattr(Switching, "track", track)
    first = one.finer(TIME[1])
    found, finer = one.tracked(TIME, START)
    assert (found.largest, finer, asked) == (largest, 4 * first, [first, 2 * first, 4 * first])
    assert one.modes == {TIME[-1]: f"mode {4 * first}"}
    with pytest.raises(ConvergenceError, match=r"is not followed to 1e-06 by steps of 0\.5 s; raise simulation.tol"):
        one.tracked(TIME, START)
    assert asked[-1] == 1024


@pytest.mark.parametrize("name", ["saturated", "end stop"])
def test_dips_are_sought_by_rates_of_the_length_of_a_span(monkeypatch, name):
    """How a guard changes over the spans it is told at, and over how many of them, is how its rate has it."""
    seen = []
    monkeypatch.setattr("vsb.integrators.switching.dips", lambda values, rates: seen.append((values, rates)) or [])
    law, stop = LAWS[name]
    switched(oscillator(law, stop), TIME, START)
    longest = sorted(seen, key=lambda each: len(each[0]))[-4:]
    for values, rates in longest:
        assert len(values) > 8
        missed = np.diff(values) - (rates[1:] + rates[:-1]) / 2
        assert np.median(np.abs(missed)) < 0.01 * np.abs(rates).max()  # a stop's guard jumps as its side changes
