"""A scene: sums of its forces in the motions it allows, its start, and losses by who takes them."""

from dataclasses import replace

import numpy as np
import pytest

from vsb.errors import ConvergenceError
from vsb.hydro.statespace import RadiationModel
from vsb.motion.builders import assumed_pressure_scene
from vsb.motion.forces import (
    AssumedPressure,
    ConstantForce,
    Damper,
    Excitation,
    RadiationMemory,
    RelaxingDamper,
    Spring,
    SpringDamper,
)
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene, resting
from vsb.motion.take_off import EndStop, TakeOff
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import mode_basis

STIFFNESS, MORE, DAMPING = np.diag([3.0, 5.0]), np.array([[1.0, 0.5], [0.5, 2.0]]), np.array([[2.0, 0.0], [0.0, 1.0]])


def scene(motions=None, **more):
    forces = {
        "hydrostatic": Spring(STIFFNESS),
        "elastic": Spring(MORE),
        "structural_damping": Damper(0.1 * DAMPING),
        "pto": Damper(np.diag([4.0, 0.0])),
        "weight": ConstantForce(np.array([7.0, -1.0])),
    }
    return Scene(("Heave", "Membrane0"), np.eye(2), forces, np.eye(2) if motions is None else motions, **more)


def test_matrices_are_sums_over_forces_in_the_allowed_motions():
    along = np.array([[1.0], [2.0]])
    one = scene(along)
    np.testing.assert_allclose(one.stiffness, along.T @ (STIFFNESS + MORE) @ along)
    np.testing.assert_allclose(one.damping, along.T @ (0.1 * DAMPING + np.diag([4.0, 0.0])) @ along)
    np.testing.assert_array_equal(one.constant, [7.0, -1.0])
    assert one.memory is one.excitation is one.water is None


def test_it_is_flexible_if_an_allowed_motion_deforms_the_shell():
    assert scene().flexible
    assert not scene(np.array([[1.0], [0.0]])).flexible


def test_the_start_is_heave_from_where_it_rests():
    y, rate = scene(origin=np.array([0.1, 0.2])).start(0.5, -0.8)
    assert (y.tolist(), rate.tolist()) == (pytest.approx([0.6, 0.2]), [-0.8, 0.0])
    assert scene().start(0.5, 0.0)[0].tolist() == [0.5, 0.0]
    assert scene().rest.tolist() == [0.0, 0.0]
    assert scene(origin=np.array([0.1, 0.2])).rest.tolist() == [0.1, 0.2]


def test_losses_are_of_the_take_off_it_names_and_of_all_others():
    v = np.array([[1.0, 2.0], [0.0, 3.0]])
    taken, lost = scene().lost(v)
    np.testing.assert_allclose(taken, [4.0, 0.0])
    np.testing.assert_allclose(lost, [0.1 * (2.0 + 4.0), 0.1 * 9.0])
    other, rest = scene(take_off="structural_damping").lost(v)
    np.testing.assert_allclose((other, rest), (lost, taken))


def test_a_share_of_the_waves_leaves_all_other_forces():
    wave = Excitation(np.array([1.0]), np.array([[2.0 + 1.0j, 0.0]]))
    one = Scene(("Heave", "Membrane0"), np.eye(2), {**scene().forces, "excitation": wave}, np.eye(2))
    half = one.raised(0.5)
    np.testing.assert_allclose(half.excitation.phasors, 0.5 * wave.phasors)
    np.testing.assert_array_equal(half.stiffness, one.stiffness)
    assert one.excitation is wave


def test_what_is_constant_is_all_that_pushes_at_zero():
    """Constant forces, and springs that are slack elsewhere."""
    slack = SpringDamper(MORE, DAMPING, np.array([0.3, -0.2]))
    one = Scene(("Heave", "Membrane0"), np.eye(2), {**scene().forces, "spring": slack}, np.eye(2))
    none = np.zeros((1, 2))
    np.testing.assert_allclose(sum(one.named(np.zeros(1), none, none).values())[0], one.constant)
    np.testing.assert_allclose(one.constant, [7.0 + 0.3 - 0.5 * 0.2, -1.0 + 0.5 * 0.3 - 2.0 * 0.2])
    bare = Scene(("Heave", "Membrane0"), np.eye(2), {"hydrostatic": Spring(STIFFNESS)}, np.eye(2))
    assert bare.constant.tolist() == [0.0, 0.0]


def test_radiation_is_what_remembers_but_for_the_take_off():
    """A chamber of gas before a take-off remembers, too, and radiates nothing."""
    memory = RadiationModel(np.array([[-0.5, 3.0], [-3.0, 0.0]]), np.eye(2), np.array([1.0, 0.0]))
    chamber = RelaxingDamper(np.zeros((2, 2)), np.array([1.0, 0.5]), 4.0, 0.1)
    water, through = {"radiation": RadiationMemory(memory)}, {"pto": chamber}
    both, alone, dry = (
        Scene(("Heave", "Membrane0"), np.eye(2), forces, np.eye(2)) for forces in (water | through, water, through)
    )
    assert (both.memory.order, alone.memory.order, dry.memory.order) == (3, 2, 1)
    for one in (both, alone):
        np.testing.assert_array_equal(one.radiation.state_matrix, memory.state_matrix)
    assert dry.radiation is None


def remembering(rate, order):
    """A memory of some states."""
    return RadiationModel(-rate * np.eye(order), np.ones((order, 2)) * rate, np.sqrt(2 * rate) * np.eye(order))


def test_states_are_of_the_memories_in_their_order_whatever_their_numbers():
    forces = {
        "radiation": RadiationMemory(remembering(0.5, 3)), "elastic": Spring(MORE),
        "pto": RelaxingDamper(MORE, np.array([1.0, 0.5]), 4.0, 0.1), "other": RadiationMemory(remembering(2.0, 2)),
    }  # fmt: skip
    one = Scene(("Heave", "Membrane0"), np.eye(2), forces, np.eye(2))
    assert one.remembered == {"radiation": slice(0, 3), "pto": slice(3, 4), "other": slice(4, 6)}
    np.testing.assert_allclose(np.diag(one.memory.state_matrix), [-0.5] * 3 + [-2.5] + [-2.0] * 2)
    assert one.radiation.order == 5
    np.testing.assert_allclose(np.diag(one.radiation.state_matrix), [-0.5] * 3 + [-2.0] * 2)
    other = Scene(("Heave", "Membrane0"), np.eye(2), forces, np.eye(2), take_off="other")
    np.testing.assert_allclose(np.diag(other.radiation.state_matrix), [-0.5] * 3 + [-2.5])
    np.testing.assert_allclose(one.stiffness, 2 * MORE)  # a spring that remembers is one
    assert one.named(np.zeros(1), np.ones((1, 2)), np.ones((1, 2))).keys() == {"elastic"}


@pytest.mark.parametrize("turned", [False, True])
def test_a_take_off_and_an_end_stop_are_known_apart_in_either_order(turned):
    b = np.array([1.0, 0.5])
    law, stop = TakeOff(b, 4.0, 10.0, 5.0), EndStop(b, 0.7, 100.0, 30.0)
    pair = [("pto", law), ("end_stop", stop)]
    one = Scene(("Heave", "Membrane0"), np.eye(2), dict(pair[::-1] if turned else pair), np.eye(2))
    assert (one.law, one.stop) == (law, stop)
    assert list(one.laws) == (["end_stop", "pto"] if turned else ["pto", "end_stop"])
    for name, found in (("pto", (law, None)), ("end_stop", (None, stop))):
        alone = Scene(
            ("Heave", "Membrane0"), np.eye(2), {"hydrostatic": Spring(MORE), name: dict(pair)[name]}, np.eye(2)
        )
        assert (alone.law, alone.stop) == found
        assert list(alone.laws) == [name]


def test_a_start_moves_in_heave_by_both_its_parts():
    """Where heave is not the first motion, or comes with others."""
    one = scene(np.array([[0.6, 0.8], [-0.8, 0.6]]), origin=np.array([0.1, 0.2]), heave=np.array([0.6, 0.8]))
    y, rate = one.start(0.5, -2.0)
    assert y == pytest.approx([0.1 + 0.3, 0.2 + 0.4])
    assert rate == pytest.approx([-1.2, -1.6])
    np.testing.assert_array_equal(one.raised(0.5).heave, one.heave)
    np.testing.assert_array_equal(one.raised(0.5).origin, one.origin)


def test_every_constant_force_counts_below_zero_too():
    more = {
        "preload": ConstantForce(np.array([-20.0, 3.0])),
        "spring": SpringDamper(MORE, DAMPING, np.array([-1.0, 0.0])),
    }
    one = Scene(("Heave", "Membrane0"), np.eye(2), {**scene().forces, **more}, np.eye(2))
    np.testing.assert_allclose(one.constant, [7.0 - 20.0 - 1.0, -1.0 + 3.0 - 0.5])


def test_a_take_off_that_is_not_there_takes_nothing_and_all_others_lose():
    v = np.array([[1.0, -2.0]])
    taken, lost = scene(take_off="turbine").lost(v)
    np.testing.assert_allclose(taken, [0.0])
    np.testing.assert_allclose(lost, [0.1 * (2.0 + 4.0) + 4.0])


@pytest.mark.parametrize(
    ("labels", "stiffness", "adrift"),
    [
        (("Mode7", "Heave"), np.diag([0.0, 5.0]), True),
        (("Surge", "Sway"), 7.3 * np.outer([0.3, 0.7], [0.3, 0.7]), True),
        (("Surge", "Sway"), 7.3 * np.outer([0.3, 0.7], [0.3, 0.7]) + np.diag([1e-3, 0.0]), False),
        (("Heave",), np.array([[5.0]]), False),
    ],
)
def test_a_scene_of_which_a_motion_is_held_by_nothing_is_adrift(labels, stiffness, adrift):
    free = np.eye(len(labels))
    assert Scene(labels, free, {"mooring": Spring(stiffness)}, free).adrift is adrift


@pytest.fixture(scope="module")
def wet(seed):
    """A shell with a spring at its take-off on the instantaneous wet surface; two of its motions come together."""
    basis = mode_basis(seed.device, "membrane", 2)
    shell, motions = DeformedShell(basis, seed.centre_height, np.zeros(4)), np.eye(4)[:, [0, 1, 3]]
    motions[2, 1] = 0.4
    return assumed_pressure_scene(shell, LinearPto(2e3, 3e4), AssumedPressure(0.0, 1.0), 1025.0, 9.81, motions)


@pytest.mark.parametrize("shape", [[0.0, 0.0, 0.0, 0.0], [0.05, 0.01, -0.02, 0.03]])
def test_a_body_rests_where_all_its_forces_cancel(wet, shape):
    """Springs, weight, more weight and the water on the shell as it lies there, from whatever shape it is measured."""
    more = {"water": replace(wet.water, rest=np.array(shape)), "ballast": ConstantForce(np.array([-2e3, 0, 0, 0]))}
    one = replace(wet, forces={**wet.forces, **more})
    q = (one.motions @ one.rest)[None]
    assert np.abs(q).min() > 1e-3
    named = one.named(np.zeros(1), q, np.zeros((1, 4)))
    assert np.abs(named["weight"]).max() > 1e3
    np.testing.assert_allclose(one.motions.T @ sum(named.values())[0], 0.0, atol=1e-7)


def test_a_body_that_sinks_or_whose_shell_gives_way_does_not_rest(wet):
    heavy = {**wet.forces, "ballast": ConstantForce(np.array([-1e6, 0.0, 0.0, 0.0]))}
    soft = {**wet.forces, "more": Spring(np.diag([-1e7, 0.0, 0.0, 0.0]))}
    for forces in (heavy, soft):
        with pytest.raises(ConvergenceError, match="the loaded buoy does not come to rest: its shell gives way under"):
            resting(replace(wet, forces=forces))


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_body_that_would_move_by_more_than_its_radius_at_once_is_given_up(wet, way):
    """Held by its spring alone it would rest metres beyond the water, or below it."""
    moved = {}
    for load in (3.0e5, 3.25e5):
        forces = {**wet.forces, "load": ConstantForce(np.array([way * load, 0.0, 0.0, 0.0]))}
        moved[load] = replace(wet, forces=forces, motions=np.eye(4, 1))
    assert 2 * 2.0 < way * resting(moved[3.0e5])[0] < 5.0
    with pytest.raises(ConvergenceError, match="the loaded buoy does not come to rest"):
        resting(moved[3.25e5])
