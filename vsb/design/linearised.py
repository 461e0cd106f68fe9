"""Matrices of a design about its shape at rest, over its free motions, and their derivatives by variables."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from vsb.design.resting import Matrices, RestingBuoy, Stepped
from vsb.errors import ConfigError
from vsb.hydro.database import shares
from vsb.hydro.dofs import Displacement
from vsb.hydro.spectral.shape_derivative import shape_derivative
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.motion.port import port_direction
from vsb.scenes.rest import design_motions, mooring_rows
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
    buoy: RestingBuoy, design: str, stepped: Sequence[Stepped], omega: FloatArray, nodes: int, clamped: bool = False
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
    clamped : bool
        Whether the colatitude of the clamp [degrees] is one more variable, the last.
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
    direction = _port(buoy)
    if not (motions.T @ direction).any():
        raise ConfigError(
            f"pto.port: received {buoy.study.pto.port}, which design {design} does not move; needs another"
        )
    structure, structure_change = Matrices(*map(reduced, buoy.matrices)), Matrices(*map(change, range(3)))
    values = Linearised(
        structure.mass,
        structure.damping,
        structure.stiffness,
        radiated(solved.radiation),
        solved.excitation @ transform,
        motions.T @ direction,
    )
    changes = Linearised(
        structure_change.mass,
        structure_change.damping,
        structure_change.stiffness,
        radiated(solved.radiation_change).swapaxes(0, 1),
        (solved.excitation_change @ transform).swapaxes(0, 1),
        np.reshape([one.derivative(_port) for one in stepped], (count, len(motions))) @ motions,
    )
    if not clamped:
        return values, changes

    turned = _motions_change(buoy, design, motions)

    def both(one: AnyArray, by: FloatArray, other: FloatArray) -> AnyArray:
        """By^T one other + other^T one by."""
        return np.asarray(by.T @ one @ other + other.T @ one @ by)

    across = shares(moved, basis).T @ turned
    structure = Matrices(*(both(one, turned, motions) for one in buoy.matrices))
    last = Linearised(
        structure.mass,
        structure.damping,
        structure.stiffness,
        both((solved.radiation + solved.radiation.swapaxes(1, 2)) / 2, across, transform),
        solved.excitation @ across,
        turned.T @ direction,
    )
    names = [field.name for field in fields(Linearised)]
    return values, Linearised(*(np.concatenate([getattr(changes, n), getattr(last, n)[None]]) for n in names))


def _port(buoy: RestingBuoy) -> FloatArray:
    """The motion of the take-off's port, b over all degrees of freedom."""
    return port_direction(buoy.study.pto.port, buoy.shape)


def _motions_change(buoy: RestingBuoy, design: str, motions: FloatArray) -> FloatArray:
    """Derivatives of the motions N a clamp allows by its colatitude, shape (dof, free) [1/degree].

    Of Phi N = 0 remains Phi dN = -dPhi N, whose least solution turns the motions without mixing them.
    """
    basis, colatitudes = buoy.loaded.basis, buoy.study.designs[design].clamp
    if len(colatitudes) != 1 or colatitudes[0] in (0.0, 180.0):
        raise ConfigError(
            f"designs.{design}.clamp: received {list(colatitudes)}; derivatives by it need one clamp between the poles"
        )
    at = np.deg2rad(colatitudes)
    _, _, radial, meridional = basis.displacement_and_slope(at)
    held = mooring_rows(buoy.study, basis)
    rows, slopes = np.vstack([basis.clamp_rows(at), held]), np.vstack([radial.T, meridional.T, 0 * held])
    slopes[:, 0] = 0.0  # as those of `clamp_rows`, rigid heave is free
    return np.asarray(np.deg2rad(-np.linalg.pinv(rows) @ slopes @ motions))


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
