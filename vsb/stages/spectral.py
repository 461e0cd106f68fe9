"""Rule spectral: hydrodynamic coefficients of one block of frequencies without panels."""

import time as clock

from vsb.hydro.dofs import displacements
from vsb.hydro.spectral import solver
from vsb.hydro.spectral.sweep import FEWEST_NODES, converged, converged_on_grid
from vsb.scenes.rest import reference_shell
from vsb.shell.deformed import rigid_buoy
from vsb.shell.sphere import Shell
from vsb.stages.stage import stamp
from vsb.study.specs import LoadedShape, SpectralSpec
from vsb.tools.files import save

FILM = 1e-4
"""Thickness of a shell that moves as a whole, of no consequence, in radii."""


def run(spec: SpectralSpec, out: str) -> None:
    """Solve one block of frequencies, as finely as the tolerance needs."""
    begun = clock.perf_counter()
    problem, omega = spectral_problem(spec), list(spec.omega)
    if spec.interpolation:
        solved = converged_on_grid(problem, omega, spec.tolerance, spec.interpolation)
    else:
        solved = converged(problem, omega, spec.tolerance)
    save(solved.assign_attrs(**stamp(spec), seconds=clock.perf_counter() - begun), out)


def spectral_problem(spec: SpectralSpec) -> solver.SpectralProblem:
    """Return the problem of a block: the shape at rest and its displacements."""
    shape, water = spec.shape, spec.water
    if isinstance(shape, LoadedShape):
        shell = reference_shell(shape).shape
    else:
        rest = shape.shape.meridian(shape.radius) if shape.shape else None
        shell = rigid_buoy(Shell(shape.radius, FILM * shape.radius, 1.0, 0.0, 1.0, rest), shape.centre_height)
    moved = displacements(spec.displacements, spec.order)
    return solver.SpectralProblem(shell, moved, water.density, water.gravity, FEWEST_NODES, depth=water.depth)
