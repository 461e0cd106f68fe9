"""Scenes: sums of forces in the allowed motions, initial state, losses, equilibrium."""

from dataclasses import replace

import numpy as np
import pytest

from vsb.engine.motion.builders import assumed_pressure_scene
from vsb.engine.motion.forces import AssumedPressure, ConstantForce, Damper, Spring
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene, resting
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import mode_basis
from vsb.errors import ConvergenceError

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


def test_initial_state_is_heave_from_the_rest_position():
    one = scene(np.array([[0.6, 0.8], [-0.8, 0.6]]), origin=np.array([0.1, 0.2]), heave=np.array([0.6, 0.8]))
    y, rate = one.start(0.5, -2.0)
    assert y == pytest.approx([0.1 + 0.3, 0.2 + 0.4])
    assert rate == pytest.approx([-1.2, -1.6])
    np.testing.assert_array_equal(one.scaled_waves(0.5).heave, one.heave)
    np.testing.assert_array_equal(one.scaled_waves(0.5).origin, one.origin)


@pytest.mark.parametrize(
    ("labels", "stiffness", "unrestrained"),
    [
        (("Mode7", "Heave"), np.diag([0.0, 5.0]), True),
        (("Surge", "Sway"), 7.3 * np.outer([0.3, 0.7], [0.3, 0.7]), True),
        (("Surge", "Sway"), 7.3 * np.outer([0.3, 0.7], [0.3, 0.7]) + np.diag([1e-3, 0.0]), False),
        (("Heave",), np.array([[5.0]]), False),
    ],
)
def test_unrestrained_scene(labels, stiffness, unrestrained):
    free = np.eye(len(labels))
    assert Scene(labels, free, {"mooring": Spring(stiffness)}, free).unrestrained is unrestrained


@pytest.fixture(scope="module")
def wet(seed):
    """A shell with a spring at its take-off on the instantaneous wet surface; two of its motions come together."""
    basis = mode_basis(seed.device, "membrane", 2)
    shell, motions = DeformedShell(basis, seed.centre_height, np.zeros(4)), np.eye(4)[:, [0, 1, 3]]
    motions[2, 1] = 0.4
    return assumed_pressure_scene(shell, LinearPto(2e3, 3e4), AssumedPressure(0.0, 1.0), 1025.0, 9.81, motions)


@pytest.mark.parametrize("shape", [[0.0, 0.0, 0.0, 0.0], [0.05, 0.01, -0.02, 0.03]])
def test_forces_cancel_at_the_equilibrium(wet, shape):
    """Springs, weight and water on the shell, for any reference shape."""
    more = {"water": replace(wet.water, rest=np.array(shape)), "ballast": ConstantForce(np.array([-2e3, 0, 0, 0]))}
    one = replace(wet, forces={**wet.forces, **more})
    q = (one.motions @ one.rest)[None]
    assert np.abs(q).min() > 1e-3
    named = one.named(np.zeros(1), q, np.zeros((1, 4)))
    assert np.abs(named["weight"]).max() > 1e3
    np.testing.assert_allclose(one.motions.T @ sum(named.values())[0], 0.0, atol=1e-7)


def test_sinking_or_collapsing_body_is_refused(wet):
    heavy = {**wet.forces, "ballast": ConstantForce(np.array([-1e6, 0.0, 0.0, 0.0]))}
    soft = {**wet.forces, "more": Spring(np.diag([-1e7, 0.0, 0.0, 0.0]))}
    for forces in (heavy, soft):
        with pytest.raises(ConvergenceError, match="the loaded buoy does not come to rest: its shell gives way under"):
            resting(replace(wet, forces=forces))
