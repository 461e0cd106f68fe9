"""Cummins' convolution against the state-space radiation memory."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from integrators.test_exact import oscillator

from vsb.hydro.statespace import RadiationModel
from vsb.integrators.exact import convolve, propagate
from vsb.motion.forces import Damper, Excitation, RadiationMemory, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System


class Fading:
    """A radiation kernel K(t) = k exp(-t)."""

    def kernel(self, time):
        return 6.0 * np.exp(-time)[:, None, None]


def test_convolution_with_initial_velocity_is_of_second_order():
    """The kernel as one memory state; the initial velocity has half weight, else the order would be one."""
    memory = RadiationModel(np.array([[-1.0]]), np.array([[np.sqrt(6.0)]]), np.array([np.sqrt(2.0)]))
    plant = oscillator({"pto": Damper(np.array([[1.2]])), "radiation": RadiationMemory(memory)})
    begin, errors = (np.array([0.3]), np.array([2.0])), []
    for count in (100, 200, 400):
        time = np.linspace(0.0, 4.0, count + 1)
        exact, found = propagate(System.of(plant), time, begin), convolve(System.of(plant), Fading(), time, begin)
        errors.append([np.abs(getattr(found, of) - getattr(exact, of)).max() for of in ("position", "velocity")])
    slopes = np.diff(np.log(errors), axis=0) / np.log(0.5)
    assert np.all(np.abs(slopes - 2.0) < 0.1), slopes


COUPLED = RadiationModel(
    np.array([[-0.5, 0.7], [-0.7, -0.3]]), np.array([[1.5, 0.4], [-0.6, 1.1]]), np.diag(np.sqrt([1.0, 0.6]))
)
"""A memory of two states whose kernel is not a symmetric matrix."""


@pytest.mark.parametrize("motions", [np.array([[1.0, 0.5], [-0.2, 1.0]]), np.array([[0.8], [-0.5]])])
def test_convolution_of_coupled_motions_in_waves_is_of_second_order(motions):
    """Two motions coupled by mass, springs, dampers and memory, free or constrained to one combination."""
    memory = RadiationMemory(COUPLED)
    forces = {
        "hydrostatic": Spring(np.array([[50.0, 4.0], [4.0, 20.0]])),
        "pto": Damper(np.array([[1.2, 0.2], [0.2, 0.5]])),
        "radiation": memory,
        "excitation": Excitation(np.array([0.9, 2.1]), np.array([[3.0 + 1.0j, -2.0j], [-1.0, 4.0 + 0.5j]])),
    }
    scene = Scene(("Heave", "Pitch"), np.array([[2.0, 0.3], [0.3, 1.5]]), forces, motions)
    system, free = System.of(scene), motions.shape[1]
    begin, errors = (np.array([0.3, -0.7])[:free], np.array([-0.5, 0.4])[:free]), []
    for count in (100, 200, 400):
        time = np.linspace(0.0, 4.0, count + 1)
        exact, found = propagate(system, time, begin), convolve(system, COUPLED, time, begin)
        errors.append(
            [np.abs(getattr(found, of) - getattr(exact, of)).max() for of in ("position", "velocity", "acceleration")]
        )
        assert found.time is time
        assert found.memory.shape == (count + 1, 0)
    slopes = np.diff(np.log(errors), axis=0) / np.log(0.5)
    assert np.all(np.abs(slopes - 2.0) < 0.15), slopes


def test_nonlinear_forces_and_other_memories_are_refused():
    memory = RadiationMemory(COUPLED)
    forces = {"hydrostatic": Spring(np.diag([50.0, 20.0])), "radiation": memory}
    scene = Scene(("Heave", "Pitch"), np.diag([2.0, 1.5]), forces, np.eye(2))
    time, start = np.linspace(0.0, 1.0, 11), (np.zeros(2), np.zeros(2))
    assert not convolve(System.of(scene), COUPLED, time, start).position.any()
    twice = replace(scene, forces={**forces, "chamber": memory})
    with pytest.raises(
        ValueError, match=r"^convolution: received forces that remember besides radiation, needs none; use"
    ):
        convolve(System.of(twice), COUPLED, time, start)
    with pytest.raises(
        ValueError, match=r"^convolution: received nonlinear forces, needs a linear scene; use `integrate`"
    ):
        convolve(SimpleNamespace(linear=False, scene=scene), COUPLED, time, start)
