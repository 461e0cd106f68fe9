"""Forces: value, tangent, potential energy and loss are consistent; take-off laws and end stops."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.engine.motion.forces import (
    AssumedPressure,
    ConstantForce,
    Damper,
    EndStop,
    Excitation,
    Linear,
    QuadraticDrag,
    RelaxingDamper,
    Spring,
    SpringDamper,
    TakeOff,
    WaterPressure,
)
from vsb.engine.motion.wetted import WetShell, incident
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import mode_basis
from vsb.engine.waves.seas import Sea

DOF, RNG = 5, np.random.default_rng(3)
ROOT = RNG.normal(size=(DOF, DOF))
TIME = np.linspace(0.0, 2.0, 9)
SWELL = Sea(np.array([2.0, 3.0]), np.array([0.2 + 0.1j, 0.1 - 0.05j]))


@pytest.fixture(scope="module")
def water(seed):
    """The seed's shell in still water, under an assumed pressure and in waves."""
    basis = mode_basis(seed.device, "membrane", 3)
    shell = WetShell(basis, seed.centre_height)
    tangent = DeformedShell(basis, seed.centre_height).hydrostatic_stiffness(1025.0, 9.81)
    parts = {
        "still": {},
        "assumed": {"assumed": AssumedPressure(500.0, 2.5)},
        "waves": {"waves": incident(SWELL, np.inf, 9.81, 2.0)},
    }
    return {name: WaterPressure(shell, np.zeros(DOF), 1025.0 * 9.81, tangent, **part) for name, part in parts.items()}


@pytest.fixture(params=["spring", "damper", "spring_damper", "excitation", "constant", "still", "assumed", "waves"])
def force(request, water):
    plain = {
        "spring": Spring(ROOT @ ROOT.T),
        "damper": Damper(ROOT @ ROOT.T),
        "spring_damper": SpringDamper(ROOT @ ROOT.T, np.diag(ROOT[0] ** 2), 0.03 * ROOT[1]),  # slack elsewhere
        "excitation": Excitation(SWELL.omega, RNG.normal(size=(2, DOF)) + 0j),
        "constant": ConstantForce(ROOT[0]),
    }
    return (plain | water)[request.param]


def motion():
    rng = np.random.default_rng(5)
    return 0.02 * rng.normal(size=(len(TIME), DOF)), rng.normal(size=(len(TIME), DOF))


def test_force_is_minus_the_gradient_of_energy_and_dissipation(force):
    """f.w = -dU(q + s w)/ds - d(lost)/2, for any direction w, in still water."""
    calm = force.scaled_waves(0.0)
    q, v = motion()
    way, h = np.random.default_rng(7).normal(size=DOF), 1e-6
    falls = -(calm.potential_energy(q + h * way) - calm.potential_energy(q - h * way)) / (2 * h)
    takes = -(calm.dissipated_power(v + h * way) - calm.dissipated_power(v - h * way)) / (4 * h)
    pushed = calm.force(TIME, q, v) @ way
    assert falls + takes == pytest.approx(pushed, abs=1e-7 * (1.0 + np.abs(pushed).max()))


def test_linear_part_is_the_tangent_at_rest(force):
    """-K and -D by central differences about the reference shape in still water."""
    part, calm, h = force.linear(), force.scaled_waves(0.0), 1e-6
    zero = np.zeros((1, DOF))
    for matrix, direction in ((part.stiffness, 0), (part.damping, 1)):
        moved = [[zero, zero], [zero, zero]]
        slope = np.zeros((DOF, DOF))
        for j in range(DOF):
            moved[0][direction], moved[1][direction] = h * np.eye(DOF)[j : j + 1], -h * np.eye(DOF)[j : j + 1]
            ahead, behind = (calm.force(TIME[:1], *state) for state in moved)
            slope[:, j] = -(ahead - behind)[0] / (2 * h)
        expected = np.zeros((DOF, DOF)) if matrix is None else matrix
        assert slope == pytest.approx(expected, abs=2e-6 * (1.0 + np.abs(expected).max()))


def test_scaled_waves_scale_the_force(force):
    """Exactly for linear waves and an assumed pressure; on the wet shell up to the square of the wave height."""
    q, v = motion()
    calm, part, whole = (force.scaled_waves(s).force(TIME, q, v) for s in (0.0, 0.5, 1.0))
    np.testing.assert_array_equal(whole, force.force(TIME, q, v))
    exact = force.frequencies().size == 0 or getattr(force, "waves", None) is None
    tolerance = 1e-12 * np.abs(whole).max() if exact else 0.3 * np.abs(whole - calm).max()
    assert part - calm == pytest.approx(0.5 * (whole - calm), abs=tolerance)


def test_damper_behind_a_compliance_relaxes():
    """At constant speed from rest its force is c V (1 - exp(-t/cC))."""
    relaxing = RelaxingDamper(np.zeros((2, 2)), np.array([3.0, 4.0]), damping=2.0, compliance=0.4)
    model, speed, t = relaxing.linear().memory, 3.0 * 0.1 + 4.0 * 0.2, np.linspace(0.0, 5.0, 6)
    state = model.input_matrix @ [0.1, 0.2] * (1 - np.exp(t * model.state_matrix[0, 0])) / -model.state_matrix[0, 0]
    force = 2.0 * speed * (1 - np.exp(-t / 0.8))
    assert state[:, None] @ model.input_matrix == pytest.approx(np.outer(force, [3.0, 4.0]))
    assert 0.5 * state**2 == pytest.approx(0.5 * 0.4 * force**2)
    assert model.radiated[0, 0] * state**2 == pytest.approx(force**2 / 2.0)


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_quadratic_drag_in_waves(share):
    """f = -sum c |u| u b, u = b.q' - Re sum W exp(-i omega t), of two directions, some instants or all."""
    along, coefficient = np.array([[1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.6, 0.8, 0.0, 0.0]]), np.array([3.0, 7.0])
    flow = np.array([[0.5 + 0.2j, -0.3j], [0.1 - 0.4j, 0.7]])
    drag = QuadraticDrag(along, coefficient, SWELL.omega, flow).scaled_waves(share)
    q, v = motion()
    water = np.real(np.exp(-1j * np.outer(TIME, SWELL.omega)) @ flow)
    past = v @ along.T - share * water
    expected = -(coefficient * np.abs(past) * past) @ along
    assert drag.force(TIME, q, v) == pytest.approx(expected, rel=1e-12)
    assert drag.during(TIME)(q[3:6], v[3:6], slice(3, 6)) == pytest.approx(expected[3:6], rel=1e-12)
    assert drag.linear() == Linear(fully_linear=False)


@pytest.mark.parametrize("name", ["assumed", "waves"])
def test_water_pressure_about_a_deformed_reference_shape(water, name):
    """About amplitudes r the motion q equals r + q about none: force, parts and energy."""
    q, v = motion()
    rest = 0.01 * np.array([3.0, -1.0, 2.0, 1.0, -2.0])
    plain, moved = water[name], replace(water[name], rest=rest)
    np.testing.assert_allclose(moved.force(TIME, q, v), plain.force(TIME, rest + q, v), rtol=1e-12)
    np.testing.assert_allclose(moved.potential_energy(q), plain.potential_energy(rest + q), rtol=1e-12)
    named, expected = moved.named("water", TIME, q, v), plain.named("water", TIME, rest + q, v)
    assert named.keys() == expected.keys() == {
        "still": {"hydrostatic"}, "assumed": {"hydrostatic", "excitation"}, "waves": {"hydrostatic", "froude_krylov"},
    }[name]  # fmt: skip
    for part, values in expected.items():
        np.testing.assert_allclose(named[part], values, rtol=1e-9, atol=1e-9 * np.abs(values).max(), err_msg=part)
    assert moved.scaled_waves(0.0).named("water", TIME, q, v).keys() <= {"hydrostatic", "froude_krylov"}


B = np.array([1.0, 0.5])
small = st.floats(-3.0, 3.0)


@given(small, small, small, small)
def test_saturated_spring_and_damper(y, x, vy, vx):
    q, v = np.array([[y, x]]), np.array([[vy, vx]])
    force = TakeOff(B, 4.0, 10.0, 5.0).force(np.zeros(1), q, v)
    wanted = 4.0 * (v @ B)[0] + 10.0 * (q @ B)[0]
    assert force[0] == pytest.approx(-np.clip(wanted, -5.0, 5.0) * B)


def test_friction_opposes_the_velocity():
    force = TakeOff(B, np.inf, limit=5.0).force(np.zeros(3), np.zeros((3, 2)), np.array([[2.0, 0], [-1e-9, 0], [0, 0]]))
    assert force[:, 0].tolist() == [-5.0, 5.0, 0.0]


@pytest.mark.parametrize("limit", [0.0, np.inf])
def test_friction_without_a_finite_limit_is_refused(limit):
    with pytest.raises(ValueError, match=f"friction: received a limit of {limit:g} N, needs a finite one above 0"):
        TakeOff(B, np.inf, limit=limit)


@given(small, small)
def test_end_stop_only_pushes(stroke, speed):
    """It returns what its spring stores and no more."""
    stop = EndStop(np.array([1.0]), 0.7, 100.0, 30.0)
    q, v = np.array([[stroke]]), np.array([[speed]])
    force = stop.force(np.zeros(1), q, v)[0, 0]
    assert force * stroke <= 0.0
    assert force == 0.0 or abs(stroke) > 0.7
    step = np.array([[1e-6]])
    gradient = (stop.potential_energy(q + step) - stop.potential_energy(q - step))[0] / 2e-6
    if abs(abs(stroke) - 0.7) > 1e-5:
        lost = -(force + gradient) * speed
        loading = abs(stroke) > 0.7 and stroke * speed > 0
        assert lost == pytest.approx(30.0 * speed**2 if loading else 0.0, abs=1e-5)
