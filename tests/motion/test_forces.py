"""What every force says of itself agrees: value, tangent, stored energy, loss."""

from dataclasses import replace

import numpy as np
import pytest

from vsb.hydro.statespace import RadiationModel
from vsb.motion.forces import (
    AssumedPressure,
    ConstantForce,
    Damper,
    Excitation,
    Linear,
    QuadraticDrag,
    RadiationMemory,
    RelaxingDamper,
    Spring,
    SpringDamper,
    WaterPressure,
)
from vsb.motion.froude_krylov import incident
from vsb.motion.wetted import WetShell
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import mode_basis
from vsb.waves.seas import Sea

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


def test_the_named_parts_add_up_to_the_force(force):
    q, v = motion()
    whole = force.force(TIME, q, v)
    assert sum(force.named("it", TIME, q, v).values()) == pytest.approx(whole, abs=1e-12 * np.abs(whole).max())


def test_without_waves_the_force_is_minus_the_gradient_of_what_it_stores_and_what_it_takes(force):
    """f.w = -dU(q + s w)/ds - lost/2 derivative, for any direction w."""
    calm = force.raised(0.0)
    q, v = motion()
    way, h = np.random.default_rng(7).normal(size=DOF), 1e-6
    falls = -(calm.stored(q + h * way) - calm.stored(q - h * way)) / (2 * h)
    takes = -(calm.lost(v + h * way) - calm.lost(v - h * way)) / (4 * h)
    pushed = calm.force(TIME, q, v) @ way
    assert falls + takes == pytest.approx(pushed, abs=1e-7 * (1.0 + np.abs(pushed).max()))


def test_the_linear_part_is_the_tangent_at_rest(force):
    """-K and -D by central differences about the reference shape in still water."""
    part, calm, h = force.linear(), force.raised(0.0), 1e-6
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


@pytest.mark.parametrize("share", [0.0, 0.5])
def test_a_share_of_the_waves_is_a_share_of_what_they_add(force, share):
    """Exactly of linear waves and an assumed pressure; of waves on the wet shell but for their height squared."""
    q, v = motion()
    calm, part, whole = (force.raised(s).force(TIME, q, v) for s in (0.0, share, 1.0))
    np.testing.assert_array_equal(whole, force.force(TIME, q, v))
    exact = force.frequencies().size == 0 or getattr(force, "waves", None) is None or share == 0.0
    tolerance = 1e-12 * np.abs(whole).max() if exact else 0.3 * np.abs(whole - calm).max()
    assert part - calm == pytest.approx(share * (whole - calm), abs=tolerance)


def test_frequencies_are_those_of_what_drives(water):
    assert Excitation(SWELL.omega, np.zeros((2, DOF), dtype=complex)).frequencies() == pytest.approx(SWELL.omega)
    found = {name: force.frequencies().tolist() for name, force in water.items()}
    assert found == {"still": [], "assumed": [2.5], "waves": [2.0, 3.0]}
    assert water["assumed"].raised(0.0).frequencies().size == 0


def test_memory_pushes_through_its_states_alone():
    channel = np.array([1.0, 0.5])
    turning = np.array([[0.0, 1.0], [-1.0, 0.0]])
    model = RadiationModel(turning - np.outer(channel, channel) / 2, np.ones((2, DOF)), channel)
    assert RadiationMemory(model).linear() == Linear(memory=model)
    assert not RadiationMemory(model).force(TIME, *motion()).any()


def test_a_damper_behind_a_compliance_relaxes():
    """Dragged at a speed from rest on its force is c V (1 - exp(-t/cC)); it holds what it stores, it loses the rest."""
    relaxing = RelaxingDamper(np.zeros((2, 2)), np.array([3.0, 4.0]), damping=2.0, compliance=0.4)
    model, speed, t = relaxing.linear().memory, 3.0 * 0.1 + 4.0 * 0.2, np.linspace(0.0, 5.0, 6)
    state = model.input_matrix @ [0.1, 0.2] * (1 - np.exp(t * model.state_matrix[0, 0])) / -model.state_matrix[0, 0]
    force = 2.0 * speed * (1 - np.exp(-t / 0.8))
    assert state[:, None] @ model.input_matrix == pytest.approx(np.outer(force, [3.0, 4.0]))
    assert 0.5 * state**2 == pytest.approx(0.5 * 0.4 * force**2)
    assert model.radiated[0, 0] * state**2 == pytest.approx(force**2 / 2.0)


@pytest.mark.parametrize("share", [1.0, 0.5, 0.0])
def test_drag_goes_with_the_square_of_the_velocity_past_the_water_of_its_share_of_the_waves(share):
    """f = -sum c |u| u b, u = b.q' - Re sum W exp(-i omega t), of two directions, some instants or all."""
    along, coefficient = np.array([[1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.6, 0.8, 0.0, 0.0]]), np.array([3.0, 7.0])
    flow = np.array([[0.5 + 0.2j, -0.3j], [0.1 - 0.4j, 0.7]])
    drag = QuadraticDrag(along, coefficient, SWELL.omega, flow).raised(share)
    q, v = motion()
    water = np.real(np.exp(-1j * np.outer(TIME, SWELL.omega)) @ flow)
    past = v @ along.T - share * water
    expected = -(coefficient * np.abs(past) * past) @ along
    assert drag.force(TIME, q, v) == pytest.approx(expected, rel=1e-12)
    assert drag.during(TIME)(q[3:6], v[3:6], slice(3, 6)) == pytest.approx(expected[3:6], rel=1e-12)
    assert drag.linear() == Linear(whole=False)


@pytest.mark.parametrize("rest", [0.0, 0.3])
def test_a_spring_slack_elsewhere_is_not_all_linear(rest):
    force = SpringDamper(ROOT @ ROOT.T, np.eye(DOF), rest * np.ones(DOF))
    assert force.linear().whole is (rest == 0.0)


@pytest.mark.parametrize("name", ["still", "assumed", "waves"])
def test_water_presses_on_the_shape_its_reference_has_moved_to(water, name):
    """About amplitudes r the motion q is that of r + q about none: force, parts and energy."""
    q, v = motion()
    rest = 0.01 * np.array([3.0, -1.0, 2.0, 1.0, -2.0])
    plain, moved = water[name], replace(water[name], rest=rest)
    np.testing.assert_allclose(moved.force(TIME, q, v), plain.force(TIME, rest + q, v), rtol=1e-12)
    np.testing.assert_allclose(moved.stored(q), plain.stored(rest + q), rtol=1e-12)
    named, expected = moved.named("water", TIME, q, v), plain.named("water", TIME, rest + q, v)
    assert named.keys() == expected.keys() == {
        "still": {"hydrostatic"}, "assumed": {"hydrostatic", "excitation"}, "waves": {"hydrostatic", "froude_krylov"},
    }[name]  # fmt: skip
    for part, values in expected.items():
        np.testing.assert_allclose(named[part], values, rtol=1e-9, atol=1e-9 * np.abs(values).max(), err_msg=part)
    assert moved.raised(0.0).named("water", TIME, q, v).keys() <= {"hydrostatic", "froude_krylov"}


def test_a_force_at_some_instants_is_that_of_those_instants():
    wave = Excitation(SWELL.omega, np.arange(1.0, 11.0).reshape(2, 5) + 1j)
    q, v = motion()
    whole = wave.force(TIME, q, v)
    assert wave.during(TIME)(q[2:6], v[2:6], slice(2, 6)) == pytest.approx(whole[2:6], rel=1e-12)
    assert wave.during(TIME)(q, v) == pytest.approx(whole, rel=1e-12)


def test_matrices_that_are_not_symmetric_push_by_their_rows():
    """f = -K q - D v: what a motion does to another is not what that does to it."""
    matrix, (q, v) = np.arange(25.0).reshape(5, 5), motion()
    assert Spring(matrix).force(TIME, q, v) == pytest.approx(np.array([-matrix @ each for each in q]))
    assert Damper(matrix).force(TIME, q, v) == pytest.approx(np.array([-matrix @ each for each in v]))
    both = SpringDamper(matrix, 2 * matrix, np.zeros(5))
    assert both.force(TIME, q, v) == pytest.approx(np.array([-matrix @ (a + 2 * b) for a, b in zip(q, v, strict=True)]))
    assert both.stored(q) == pytest.approx(np.array([each @ matrix @ each / 2 for each in q]))
    assert both.lost(v) == pytest.approx(np.array([each @ (2 * matrix) @ each for each in v]))


def test_a_spring_slack_elsewhere_in_one_motion_is_not_all_linear():
    for place in np.eye(DOF):
        assert SpringDamper(ROOT @ ROOT.T, np.eye(DOF), -0.3 * place).linear().whole is False


def test_a_spring_beside_a_relaxing_damper_is_its_linear_part():
    stiffness = np.diag([1.0, 2.0])
    relaxing = RelaxingDamper(stiffness, np.array([3.0, 4.0]), damping=2.0, compliance=0.4)
    part = relaxing.linear()
    np.testing.assert_array_equal(part.stiffness, stiffness)
    assert part.damping is None
    assert part.whole
    q = np.array([[0.1, 0.2]])
    assert relaxing.force(np.zeros(1), q, q) == pytest.approx(np.array([[-0.1, -0.4]]))
    assert relaxing.stored(q) == pytest.approx([0.5 * (0.01 + 0.08)])


@pytest.mark.parametrize("share", [0.5, -0.25, 0.0])
def test_a_share_of_the_waves_on_the_wet_shell_is_that_of_each_component_in_its_phase(water, share):
    np.testing.assert_allclose(water["waves"].raised(share).waves.amplitude, share * SWELL.amplitude, rtol=1e-15)
    np.testing.assert_array_equal(water["waves"].raised(share).waves.omega, SWELL.omega)
    assert water["assumed"].raised(share).assumed == AssumedPressure(500.0 * share, 2.5)
    assert water["still"].raised(share) is water["still"]
