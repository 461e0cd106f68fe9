"""Switching take-offs: closed forms, independent integrators, energy, steady power, the instantaneous wet shell."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import springs
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.integrators.audit import absorbed_power, energies, residual
from vsb.engine.integrators.exact import propagate
from vsb.engine.integrators.exponential import integrate
from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import legs, simulate
from vsb.engine.integrators.switching import Switching, Trials, periodic_power
from vsb.engine.motion.controller import Controller
from vsb.engine.motion.forces import (
    AssumedPressure,
    Damper,
    EndStop,
    Excitation,
    RadiationMemory,
    Spring,
    SpringDamper,
    TakeOff,
)
from vsb.engine.motion.port import LinearPto, port_direction
from vsb.engine.motion.scene import Scene, assumed_pressure_scene
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import StrainPort
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import mode_basis, rigid_basis
from vsb.engine.waves.seas import Sea
from vsb.errors import ConfigError, ConvergenceError

B, MASS, SPRING, DRAG = np.array([1.0]), 2.0, 50.0, 0.3
TIME = np.linspace(0.0, 12.0, 801)
START = np.array([0.1]), np.array([0.3])
WAVES = Excitation(np.array([2.0, 3.3]), np.array([[30.0 + 5j], [-4j]]))
LAWS = {
    "saturated": (TakeOff(B, 4.0, 5.0, 8.0), None),
    "negative spring": (TakeOff(B, 4.0, -20.0, 12.0), None),
    "coulomb": (TakeOff(B, np.inf, limit=8.0), None),
    "end stop": (TakeOff(B, 4.0), EndStop(B, 0.4, 5e3, 200.0)),
    "latching": (TakeOff(B, 4.0, latching_time=0.3), None),
    "latching within a force": (TakeOff(B, 4.0, limit=15.0, latching_time=0.3), EndStop(B, 0.8, 5e3, 200.0)),
    "declutching": (TakeOff(B, 4.0, limit=8.0, latching_time=0.3, latching_damping=0.0), None),
    "hydraulic, declutched": (TakeOff(B, np.inf, limit=9.0, latching_time=0.3, latching_damping=0.0), None),
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
    """Position of the oscillator by scipy's DOP853 from event to event, with its own logic of the pieces."""
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
        in_latching_time = until > t + 1e-12
        friction = np.isinf(law.latching_damping if in_latching_time else law.damping)

        def rates(s, z, in_latching_time=in_latching_time, friction=friction, way=way):
            if friction and way == 0:
                return [0.0, 0.0]
            c, k = (law.latching_damping, 0.0) if in_latching_time else (law.damping, law.stiffness)
            taken = law.limit * way if friction else np.clip(c * z[1] + k * z[0], -law.limit, law.limit)
            return [z[1], (wave(s) - SPRING * z[0] - DRAG * z[1] - taken + stopped(z[0], z[1])) / MASS]

        events = [lambda s, z, until=until, in_latching_time=in_latching_time: until - s if in_latching_time else 1.0]
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
            if law.latching_time and until < 0 and way:
                until = t + law.latching_time
            friction = np.isinf(law.latching_damping if until > t + 1e-12 else law.damping)
            push = net(t, position)
            if way == 0:
                way = int(np.sign(push))
            elif friction:
                way, velocity = (0 if abs(push) <= law.limit else int(np.sign(push))), 0.0
            else:
                way, velocity = -way, 0.0
    return out


@pytest.mark.parametrize("name", LAWS)
def test_motion_agrees_with_an_independent_integrator_and_its_audit_closes(name):
    """Scipy's event location limits the comparison to some 1e-8 with an end stop."""
    law, stop = LAWS[name]
    system = oscillator(law, stop)
    motion, switches = Switching(system).follow(TIME, START)
    expected = reference(law, stop, TIME)
    assert switches > 5
    assert np.abs(motion.position[:, 0] - expected).max() < (2e-7 if stop else 1e-9) * np.abs(expected).max()
    assert residual(energies(system, motion)) < 1e-8
    assert MASS * motion.acceleration == pytest.approx(sum(system.forces(motion).values()), abs=1e-10)
    assert np.abs(motion.forces["pto"]).max() <= law.limit * (1 + 1e-12)
    assert not stop or np.abs(motion.position).max() < 1.1 * stop.stroke


@pytest.mark.parametrize("law", [TakeOff(B, 0.8, 1.5), TakeOff(B, 0.8, -0.2)], ids=["spring", "negative spring"])
def test_law_without_limits_equals_the_linear_take_off(shell, law):
    """Three modes with radiation memory, the port a combination of them, the spring in the take-off or in the mooring.

    A spring, and a limit that is never reached, absorb nothing: energy and power are those of the damper alone.
    """
    law = replace(law, direction=np.array([1.0, 0.3, -0.2]), limit=1e4)
    outer = np.outer(law.direction, law.direction)
    linear = {"pto": Damper(law.damping * outer), "spring": Spring(law.stiffness * outer)}
    time, start = np.linspace(0.0, 20.0, 1001), (np.array([0.1, 0.2, -0.1]), np.array([0.3, 0.0, 0.1]))
    system = System.of(replace(shell, forces={**shell.forces, "pto": law}))
    motion, _ = Switching(system).follow(time, start)
    expected = propagate(System.of(replace(shell, forces={**shell.forces, **linear})), time, start)
    for part in ("position", "velocity", "acceleration", "memory"):
        assert getattr(motion, part) == pytest.approx(getattr(expected, part), abs=1e-11)
    force = -(expected.velocity @ outer * law.damping + expected.position @ outer * law.stiffness)
    assert motion.forces["pto"] == pytest.approx(force, abs=1e-10)
    damper = law.damping * (expected.velocity @ law.direction) ** 2
    both = {"pto": SpringDamper(law.stiffness * outer, law.damping * outer, np.zeros(3))}
    absorbed = []
    for forces in ({"pto": law}, both, {"pto": linear["pto"], "mooring": linear["spring"]}):
        system = System.of(replace(shell, forces={**shell.forces, **forces}))
        motion = Switching(system).follow(time, start)[0] if system.switching else propagate(system, time, start)
        assert absorbed_power(system, motion, system.forces(motion)) == pytest.approx(damper, abs=1e-10)
        absorbed.append(energies(system, motion)["pto"])
    for one in absorbed:
        assert one == pytest.approx(absorbed[-1], abs=1e-10 * absorbed[-1][-1])
    assert absorbed[-1][-1] == pytest.approx(CubicSpline(time, damper).integrate(*time[[0, -1]]), rel=1e-6)


def test_coulomb_friction_decay_has_its_closed_form():
    """2 y'' + 50 y = -F sign y': every half swing ends 2 F/50 closer to zero, until the spring cannot overcome F."""
    system = oscillator(TakeOff(B, np.inf, limit=3.0), waves=None, drag=0.0)
    half = np.pi / 5
    motion, switches = Switching(system).follow(np.arange(0, 201) * half / 20, (np.ones(1), np.zeros(1)))
    turning = motion.position[::20, 0]
    left = 1.0 - 2 * 0.06 * np.arange(len(turning))
    left = np.where(left > 0, left, left[left > 0][-1])
    assert turning[:9] == pytest.approx(((-1.0) ** np.arange(9)) * left[:9], abs=1e-12)
    assert np.all(motion.position[-40:] == motion.position[-1])
    assert np.abs(motion.velocity[-40:]).max() < 1e-30
    assert motion.forces["pto"][-1] == pytest.approx(50 * motion.position[-1])
    assert switches == 8


@pytest.mark.parametrize("part", [0, 38])
def test_stick_slip_has_no_spurious_events(part):
    """Slip starts without velocity and acceleration; round-off alone made it reverse and stick again at once."""
    start = tuple(value * (1 + part * 1e-13) for value in START)
    _, switches = Switching(oscillator(*LAWS["coulomb"])).follow(TIME, start)
    assert switches == 13


@pytest.mark.parametrize("name", ["coulomb", "latching"])
def test_run_split_into_legs_equals_the_whole_run(name):
    """A held or latched port stays so across the border of two legs."""
    system, sea = oscillator(*LAWS[name]), Sea(WAVES.omega, np.array([0.1, 0.1]))
    setting = Simulation(duration=12.0, window=(6.0, 12.0), initial_position=0.1, initial_velocity=0.3)
    whole, stride, method = simulate(system, sea, setting, None)
    assert method.startswith("exact propagation between switches, ")
    parts = list(legs(system, sea, setting, None, longest=150))
    assert len(parts) > 3
    position = np.concatenate([part.motion.position[bool(i) :: part.stride] for i, part in enumerate(parts)])
    assert position == pytest.approx(whole.position[::stride], abs=1e-9)
    assert parts[-1].balance.residual < 1e-7


@settings(max_examples=6)
@given(st.floats(0.5, 20.0), st.floats(0.5, 30.0), st.floats(0.2, 1.0), st.integers(0, 2**32 - 1))
def test_any_law_respects_its_limit_and_conserves_energy(damping, limit, stroke, seed):
    rng = np.random.default_rng(seed)
    spring = rng.choice([0.0, 0.0, 30.0, -0.8 * SPRING]) * rng.random()
    law = TakeOff(B, damping if rng.random() < 0.7 else np.inf, spring, limit, rng.random() * 0.5 * (rng.random() < 0.6),
                  np.inf if rng.random() < 0.5 else 0.0)  # fmt: skip
    stop = EndStop(B, stroke, 5e3, 200.0) if rng.random() < 0.5 else None
    system = oscillator(law, stop, drag=float(rng.random()))
    motion, _ = Switching(system).follow(TIME[:401], (rng.normal(size=1) * 0.3, rng.normal(size=1)))
    assert residual(energies(system, motion)) < 1e-6
    assert np.abs(motion.forces["pto"]).max() <= limit * (1 + 1e-12)
    assert spring or np.all(motion.forces["pto"] * motion.velocity <= 1e-9)


def in_regular_wave(law, stop=None, omega=3.0, drag=1.0):
    return oscillator(law, stop, Excitation(np.array([omega]), np.array([[30.0 + 0j]])), drag)


@pytest.mark.parametrize("omega", [2.0, 7.0])
def test_steady_power_of_an_unlimited_damper_is_linear(omega):
    power, unsteady = periodic_power(in_regular_wave(TakeOff(B, 4.0), omega=omega), 1e-9)
    assert unsteady < 1e-9
    assert power == pytest.approx(2.0 * 30.0**2 / abs(5.0 + 1j * (50 / omega - 2 * omega)) ** 2, rel=1e-8)


def test_friction_stronger_than_the_wave_absorbs_nothing():
    assert periodic_power(in_regular_wave(TakeOff(B, np.inf, limit=31.0))) == (0.0, 0.0)


def test_transient_that_outlasts_the_run_is_reported():
    _, unsteady = periodic_power(in_regular_wave(TakeOff(B, 2e-4), omega=4.7, drag=0.0))
    assert unsteady > 1e-3


def test_steady_power_in_an_irregular_sea_is_refused():
    with pytest.raises(ConfigError, match="received 2 frequencies"):
        periodic_power(oscillator(TakeOff(B, 4.0)))


def test_trials_of_latching_times_find_the_power_of_a_run_from_rest():
    """Each trial starts from the end of the best one so far."""
    plants = [
        in_regular_wave(TakeOff(B, 4.0, latching_time=latching_time), omega=2.0, drag=3.0)
        for latching_time in (0.8, 0.85, 0.82)
    ]
    trials = Trials(1e-3)
    powers = [trials.power(plant) for plant in plants]
    assert powers == pytest.approx([periodic_power(plant, 1e-6)[0] for plant in plants], rel=2e-3)


@pytest.mark.parametrize(
    ("law", "stop"),
    [
        (TakeOff(B, 8.0, limit=8.0), None),
        (TakeOff(B, 8.0, -20.0, limit=12.0), None),
        (TakeOff(B, 2.0), EndStop(B, 0.8, 100.0, 0.0)),
    ],
    ids=["saturated", "negative spring", "end stop"],
)
def test_harmonic_balance_equals_the_steady_state_in_time(law, stop):
    system = in_regular_wave(law, stop)
    expected, unsettled = periodic_power(system)
    found = harmonic_balance(system, 1e-5)
    assert unsettled < 1e-6
    assert found.error <= 1e-5
    assert found.power.pto == pytest.approx(expected, rel=5e-5)
    assert found.power.residual < 1e-4
    assert 0 < found.decay < 1


def test_harmonic_balance_of_friction_reports_its_truncation_error():
    """The force jumps, so its harmonics decay slowly."""
    system = in_regular_wave(TakeOff(B, np.inf, limit=2.0))
    assert harmonic_balance(system, 3e-3).power.pto == pytest.approx(periodic_power(system)[0], rel=1e-2)
    with pytest.raises(ConvergenceError, match=r"the steady state is known to .* harmonics, needs 1e-06; use a"):
        harmonic_balance(system, 1e-6)


def test_methods_for_smooth_forces_refuse_a_switching_take_off():
    system = oscillator(TakeOff(B, 4.0, limit=8.0))
    with pytest.raises(ValueError, match="exact propagation: received nonlinear forces"):
        propagate(system, TIME, START)
    with pytest.raises(ValueError, match=r"received a take-off that switches, needs smooth forces; use .Switching."):
        integrate(system, TIME, START, 1e-6)
    with pytest.raises(ValueError, match="harmonic balance: received a latching or declutching take-off; needs"):
        harmonic_balance(
            oscillator(TakeOff(B, 4.0, latching_time=0.3), waves=Excitation(np.ones(1), np.ones((1, 1)) + 0j))
        )
    with pytest.raises(ValueError, match="switching: received the nonlinear forces none, needs a linear or body-exact"):
        Switching(oscillator(Damper(np.eye(1))))


# on the instantaneous wet shell

BEGIN, DURATION = (0.1, 0.2), 5.0
FILTER = Controller(
    np.array([[-0.5, 2.0], [-2.0, -0.5]]),
    np.array([60.0, 0.0]),
    np.array([0.0, 2e-3]),
    np.array([50.0, 20.0]),
    0.0,
    0.0,
)
WET_LAWS = {
    "saturated": (TakeOff(B, 8e3, 2e4, 4e3), None),
    "coulomb": (TakeOff(B, np.inf, limit=4e3), None),
    "latching": (TakeOff(B, 8e3, latching_time=0.4), None),
    "declutching": (TakeOff(B, 3e4, latching_time=0.4, latching_damping=0.0), None),
    "end stop": (TakeOff(B, 8e3), EndStop(B, 0.3, 1e6, 1e4)),
    "controller": (TakeOff(B, 6e3, -1e4, 4e3, controller=FILTER), None),
}


def scene(seed, degree, law=None, stop=None, damping=0.0):
    """The paper's buoy under an assumed pressure; degree 0: rigid."""
    basis = mode_basis(seed.device, "membrane", degree) if degree else rigid_basis(seed.device)
    shell = DeformedShell(basis, seed.centre_height, np.zeros(len(basis.labels)))
    motions = np.eye(len(basis.labels))
    found = assumed_pressure_scene(shell, LinearPto(damping), AssumedPressure(1800.0, 2.5), 1025.0, 9.81, motions)
    port = np.eye(len(basis.labels))[0]
    laws = {"pto": law, "end_stop": stop}
    forces = {name: replace(force, direction=port) for name, force in laws.items() if force}
    return replace(found, forces={**found.forces, **forces})


def test_motion_agrees_with_an_explicit_method(seed):
    """A rigid sphere, in closed form. A law with kinks only: DOP853 steps over them, with some loss of accuracy."""
    one, time = scene(seed, 0, *WET_LAWS["end stop"]), np.linspace(0.0, DURATION, 101)
    weight, mass, radius = one.forces["weight"].value[0], one.mass[0, 0], seed.device.radius
    assert not springs(one).any()

    def rates(t, y):
        heave, speed = y
        depth = min(max(radius - seed.centre_height - heave, 0.0), 2 * radius)
        water = 1025.0 * 9.81 * np.pi * depth**2 * (3 * radius - depth) / 3
        water += 1800.0 * np.cos(2.5 * t) * np.pi * depth * (2 * radius - depth)
        pressed = np.sign(heave) * max(abs(heave) - 0.3, 0.0)
        stop = 1e6 * pressed + (1e4 * speed if pressed * speed > 0 else 0.0)
        return [speed, (water + weight - 8e3 * speed - stop) / mass]

    expected = solve_ivp(rates, (0.0, DURATION), BEGIN, "DOP853", rtol=1e-11, atol=1e-12, t_eval=time, max_step=0.02)
    found, switches = Switching(System.of(one), 1e-9).follow(time, one.start(*BEGIN))
    assert switches > 8
    assert found.position[:, 0] == pytest.approx(expected.y[0], abs=2e-7 * np.abs(expected.y[0]).max())


@pytest.mark.parametrize("name", ["coulomb", "latching", "end stop", "controller"])
def test_energy_audit_closes_and_forces_balance(seed, name):
    """A flexible shell from rest."""
    law, stop = WET_LAWS[name]
    one = scene(seed, 2, law, stop)
    system, time = System.of(one), np.linspace(0.0, DURATION, 401)
    y, rate = one.start(*BEGIN)
    motion, switches = Switching(system, 1e-7).follow(time, (one.rest + y, rate))
    assert switches > 3
    assert residual(energies(system, motion)) < 1e-6
    assert motion.acceleration @ one.mass == pytest.approx(sum(system.forces(motion).values()), abs=1e-5)
    assert np.abs(motion.forces["pto"]).max() <= law.limit * (1 + 1e-12)
    if stop:  # without losses V sqrt(m/k)
        lossless = np.abs(motion.velocity[:, 0]).max() * np.sqrt(one.mass[0, 0] / stop.stiffness)
        assert 0.3 * lossless < np.abs(motion.position[:, 0]).max() - stop.stroke < lossless


@pytest.mark.parametrize("name", ["saturated", "latching"])
def test_motion_keeps_its_tolerance(seed, name):
    """However many instants one polynomial of the water's force reaches over."""
    law, stop = WET_LAWS[name]
    system, time = System.of(scene(seed, 2, law, stop)), np.linspace(0.0, DURATION, 401)
    start = (system.scene.rest + system.scene.start(*BEGIN)[0], system.scene.start(*BEGIN)[1])
    exact, coarse = (system.states(Switching(system, tol).follow(time, start)[0]) for tol in (1e-9, 1e-5))
    error = np.linalg.norm(coarse - exact, axis=1).max() / np.linalg.norm(exact, axis=1).max()
    assert 1e-12 < error < 1e-5


@pytest.mark.parametrize("name", ["coulomb", pytest.param("latching", marks=pytest.mark.slow)])
def test_energy_audit_closes_at_a_port_of_strain(seed, name):
    """Tension against the change of area, of friction [N/m] or latched: the shell strains in steps."""
    law = {"coulomb": TakeOff(B, np.inf, limit=100.0), "latching": TakeOff(B, 2e3, latching_time=0.1)}[name]
    one = scene(seed, 2, law)
    shape = one.water.shell
    area = port_direction(StrainPort(strain="area"), DeformedShell(shape.basis, shape.centre_height, one.water.rest))
    one = replace(one, forces={**one.forces, "pto": replace(law, direction=area)})
    system, time = System.of(one), np.linspace(0.0, 1.3, 131)
    y, rate = one.start(*BEGIN)
    motion, switches = Switching(system, 1e-7).follow(time, (one.rest + y, rate))
    energy = energies(system, motion)
    assert switches >= 3  # slips, sticks, slips; one more where rounding decides the sign of the first velocity
    assert residual(energy) < 1e-6
    assert energy["pto"][-1] > 0
    if name == "coulomb":
        assert np.abs(motion.forces["pto"] @ area / (area @ area)).max() <= law.limit * (1 + 1e-9)


def test_springs_and_stops_act_from_the_rest_position(seed):

    law, stop = WET_LAWS["saturated"][0], replace(WET_LAWS["end stop"][1], stroke=0.25)
    moved = [replace(x, rest=0.05) for x in (law, stop)]
    q, v = np.array([[0.2], [0.35], [-0.4]]), np.array([[0.1], [-0.2], [-0.3]])
    for there, here in zip(moved, (law, stop), strict=True):
        assert there.force(0.0, q + 0.05, v) == pytest.approx(here.force(0.0, q, v), rel=1e-12)
    one = scene(seed, 0, *moved)
    system, time = System.of(one), np.linspace(0.0, DURATION, 201)
    motion, _ = Switching(system).follow(time, one.start(*BEGIN))
    named = one.named(time, motion.position, motion.velocity)
    for name in ("pto", "end_stop"):
        assert motion.forces[name] == pytest.approx(named[name], abs=1e-6)
    assert np.abs(motion.forces["end_stop"]).max() > 100.0
