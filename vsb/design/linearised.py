"""Matrices of a design about its shape at rest, over its free motions, and their derivatives by variables."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vsb.design.resting import RestingBuoy, Stepped
from vsb.hydro.database import shares
from vsb.hydro.dofs import Displacement
from vsb.hydro.spectral.shape_derivative import shape_derivative
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.motion.port import port_direction
from vsb.scenes.rest import design_motions
from vsb.shell.shell import Curve
from vsb.tools.arrays import AnyArray, ComplexArray, FloatArray


@dataclass(frozen=True)
class Linearised:
    """A buoy without its take-off over free motions: values, or derivatives by each variable (first axis)."""

    mass: FloatArray  # ([variable,] free, free) [kg]
    damping: FloatArray  # structural [N s/m]
    stiffness: FloatArray  # [N/m]
    radiation: ComplexArray  # A + i B/omega ([variable,] omega, free, free) [kg]
    excitation: ComplexArray  # ([variable,] omega, free) [N/m]
    port: FloatArray  # b ([variable,] free) [-]


def linearised(
    buoy: RestingBuoy, design: str, stepped: Sequence[Stepped], omega: FloatArray, nodes: int
) -> tuple[Linearised, Linearised]:
    """Return the matrices of a design at rest, and their derivatives by the variables that are stepped.

    Parameters
    ----------
    buoy : RestingBuoy
    design : str
    stepped : sequence of Stepped
    omega : ndarray, shape (omega,) [rad/s]
        Frequencies of radiation and excitation.
    nodes : int
        Of the boundary elements.
    """
    basis, water, count = buoy.loaded.basis, buoy.study.water, len(stepped)
    motions = design_motions(buoy.study, basis, design)
    moved = displacements(basis.highest_degree if buoy.study.designs[design].flexible else 0)
    transform = shares(moved, basis).T @ motions if len(moved) > 1 else np.eye(1)
    problem = SpectralProblem(buoy.shape, moved, water.density, water.gravity, nodes, water.depth)

    def directions(colatitude: FloatArray) -> Curve:
        """How points of the meridian move with each variable."""
        parts = [one.displacement(colatitude) for one in stepped]
        return Curve(*np.reshape(parts, (count, 4, len(colatitude))).swapaxes(0, 1))

    def reduced(values: FloatArray) -> FloatArray:
        return np.asarray(motions.T @ values @ motions)

    def radiated(values: ComplexArray) -> ComplexArray:
        found = transform.T @ values @ transform
        return np.asarray((found + found.swapaxes(-1, -2)) / 2)  # symmetric but for the solver's error

    def change(which: int) -> FloatArray:
        slopes = [one.derivative(lambda b: np.asarray(b.matrices[which])) for one in stepped]
        return reduced(np.reshape(slopes, (count, len(motions), len(motions))))

    solved = shape_derivative(problem, list(omega), directions)
    mass, damping, stiffness = buoy.matrices
    port = motions.T @ port_direction(buoy.study.pto.port, buoy.shape)
    values = Linearised(
        reduced(mass),
        reduced(damping),
        reduced(stiffness),
        radiated(solved.radiation),
        solved.excitation @ transform,
        port,
    )
    changes = Linearised(
        change(0),
        change(1),
        change(2),
        radiated(solved.radiation_change).swapaxes(0, 1),
        (solved.excitation_change @ transform).swapaxes(0, 1),
        np.zeros((count, len(port))),
    )
    return values, changes


def displacements(degree: int) -> tuple[Displacement, ...]:
    """Return radial and meridional functions to a degree, or rigid heave alone for degree 0."""
    if not degree:
        return (Displacement("heave"),)
    radial = [Displacement("radial", n) for n in range(degree + 1)]
    return (*radial, *(Displacement("meridional", n) for n in range(1, degree + 1)))


def of_all(values: AnyArray, places: Sequence[int], count: int) -> AnyArray:
    """Return derivatives by all of `count` variables, zero but for those at some places, (variable, ...)."""
    found = np.zeros((count, *values.shape[1:]), values.dtype)
    found[list(places)] = values
    return found
