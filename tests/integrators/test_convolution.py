"""Cummins' convolution: second order, memory of the whole past."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from integrators.test_exact import CALM, damped, oscillator

from vsb.hydro.statespace import RadiationModel
from vsb.integrators.convolution import convolve
from vsb.integrators.exact import propagate
from vsb.motion.forces import Damper, Excitation, RadiationMemory, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System


def test_convolution_stepper_is_of_second_order():
    plant = oscillator({"pto": Damper(np.array([[1.2]]))})
    steps = [0.08, 0.04, 0.02, 0.01, 0.005]
    errors = []
    for step in steps:
        time = np.arange(0.0, 4.0 + step / 2, step)
        motion = convolve(System.of(plant), CALM, time, (np.array([1.0]), np.array([-0.5])))
        errors.append(np.abs(motion.position[:, 0] - damped(time)).max())
    slopes = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert np.all(np.abs(slopes[1:] - 2.0) < 0.1), slopes


class Fading:
    """A spectrum by its kernel alone, K(t) = k exp(-t)."""

    def kernel(self, time):
        return 6.0 * np.exp(-time)[:, None, None]


@pytest.mark.parametrize("start", [(1.0, -0.5), (0.0, 1.0), (0.3, 2.0)])
def test_convolution_of_a_motion_begun_at_speed_is_second_order(start):
    """The memory of one state in closed form; the first velocity counts half, else it would be of first order."""
    memory = RadiationModel(np.array([[-1.0]]), np.array([[np.sqrt(6.0)]]), np.array([np.sqrt(2.0)]))
    plant = oscillator({"pto": Damper(np.array([[1.2]])), "radiation": RadiationMemory(memory)})
    begin, errors = tuple(np.array([value]) for value in start), []
    for count in (100, 200, 400):
        time = np.linspace(0.0, 4.0, count + 1)
        exact, found = propagate(System.of(plant), time, begin), convolve(System.of(plant), Fading(), time, begin)
        errors.append([np.abs(getattr(found, of) - getattr(exact, of)).max() for of in ("position", "velocity")])
    slopes = np.diff(np.log(errors), axis=0) / np.log(0.5)
    assert np.all(np.abs(slopes - 2.0) < 0.1), slopes


COUPLED = RadiationModel(
    np.array([[-0.5, 0.7], [-0.7, -0.3]]), np.array([[1.5, 0.4], [-0.6, 1.1]]), np.diag(np.sqrt([1.0, 0.6]))
)
"""A memory of two states that swing, whose kernel is no symmetric matrix."""


@pytest.mark.parametrize("motions", [np.eye(2), np.array([[1.0, 0.5], [-0.2, 1.0]]), np.array([[0.8], [-0.5]])])
@pytest.mark.parametrize("stiff", [1.0, 0.01])
def test_convolution_of_coupled_motions_in_waves_is_second_order(motions, stiff):
    """Two motions coupled by mass, springs, dampers, memory and what a design holds; the softer below 1 rad/s."""
    memory = RadiationMemory(COUPLED)
    forces = {
        "hydrostatic": Spring(stiff * np.array([[50.0, 4.0], [4.0, 20.0]])),
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


def test_what_is_not_linear_or_remembers_twice_is_refused():
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
