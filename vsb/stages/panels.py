"""Rule panels: hydrodynamic coefficients of one block of frequencies by panels."""

import math
import time as clock
from dataclasses import replace
from pathlib import Path

import xarray as xr

from vsb.engine.hydro.dofs import displacements
from vsb.engine.hydro.panels import mesh as meshing
from vsb.engine.hydro.panels.bem import green_function, stored_green_function
from vsb.engine.hydro.panels.mesh import deformed_mesh
from vsb.engine.hydro.panels.rings import AxisymmetricProblem, TwoMeshes, witness_runs
from vsb.engine.hydro.witness import Deformed, Waves, compared, deformed_shapes, derivatives, spectral_runs
from vsb.engine.shell.deformed import DeformedShell, rigid_sphere
from vsb.engine.shell.modes import ModeBasis, shell_modes
from vsb.engine.shell.shell import Shell
from vsb.engine.waves.water import Water
from vsb.keys.quantities import id_in
from vsb.models.rest import reference_shell
from vsb.stages.stage import Stamp
from vsb.study.resolution import degree
from vsb.study.specs import DeformedMeshes, Mesh, PanelsBlock, Shapes
from vsb.study.study import Study
from vsb.tools.files import load, save, write_text


def run_mesh(grid: Mesh, out: str, stamp: Stamp) -> None:
    """Write the mean wetted mesh and lid."""
    save(mean_mesh(grid).assign_attrs(stamp), out)


def mean_mesh(grid: Mesh, coarser: int = 1) -> xr.Dataset:
    """Return the mean wetted mesh and lid, or one with a fraction of the panels in each direction."""
    rows, azimuth, lid_rows = (math.ceil(n / coarser) for n in (grid.rows, grid.azimuth, grid.lid_rows))
    shape = grid.shape
    if isinstance(shape, Study):
        return meshing.deformed_mesh(reference_shell(shape).shape, rows, azimuth, lid_rows)
    return meshing.mean_mesh(shape.radius, shape.centre_height, rows, azimuth, lid_rows)


def run_green(folder: str, out: str) -> None:
    """Compute and store the Green-function table, and say how long it took."""
    begun = clock.perf_counter()
    stored_green_function(folder)
    write_text(out, f"{clock.perf_counter() - begun:.1f} s\n")


def run_panels(block: PanelsBlock, mesh: str, green: str, out: str, stamp: Stamp) -> None:
    """Solve one block of frequencies, on the mesh and on a coarser one for the error."""
    begun = clock.perf_counter()
    read = load(mesh, expected=id_in(mesh))
    solved = solve_block(block, read, mean_mesh(block.mesh, coarser=2), green)
    save(solved.assign_attrs(**stamp, seconds=clock.perf_counter() - begun), out)


def run_deformed(shapes: DeformedMeshes, out: str, stamp: Stamp) -> None:
    """Write the meshes of all shapes, which have as many panels each."""
    found = shells(shapes)
    meshes = xr.concat([shape_mesh(shapes, shape) for shape in found], "shape")
    named = meshes.assign_coords(shape=[shape.name for shape in found])
    amplitudes = ("shape", [shape.amplitude for shape in found])
    save(named.assign(deformation_amplitude=amplitudes).assign_attrs(stamp), out)


def shells(given: DeformedMeshes) -> list[Deformed]:
    """Return the shell at rest, and deformed by either sign of each mode."""
    return deformed_shapes(_at_rest(given), given.deformed, given.depth)


def shape_mesh(given: DeformedMeshes, shape: Deformed, coarser: int = 1) -> xr.Dataset:
    """Return the mesh of a shape, or one with a fraction of the panels in each direction."""
    return deformed_mesh(shape.shell, given.rows // coarser, given.azimuth // coarser, given.lid_rows // coarser)


def compared_basis(given: DeformedMeshes, basis: ModeBasis) -> ModeBasis:
    """Return heave and the modes whose coefficients are compared."""
    return replace(basis, modes=tuple(mode for mode in basis.modes if mode.label in given.deformed))


def _at_rest(given: DeformedMeshes) -> DeformedShell:
    """The shell at rest; of one without load the modes that deform it are all there is."""
    shape = given.shape
    if isinstance(shape, Study):
        return reference_shell(shape).shape
    rigid = rigid_sphere(shape.radius, shape.centre_height)
    if not isinstance(shape, Shapes):
        return rigid
    shell = Shell(shape.radius, shape.thickness, 1.0, shape.poisson_ratio, 1.0)
    modes = shell_modes(shell, shape.basis, max(map(degree, given.deformed)))
    basis = ModeBasis(shell, modes, 1.0, bending=False)
    return DeformedShell(compared_basis(given, basis), shape.centre_height)


def run_witness(
    solver: str, shapes: DeformedMeshes, water: Water, omega: tuple[float, ...], meshes: str, out: str, stamp: Stamp
) -> None:
    """Solve every shape by both solvers, panels on the mesh in a file and on one of half its rows, and compare."""
    found, waves = shells(shapes), Waves(omega, water.density, water.depth, water.gravity)
    basis, stored = compared_basis(shapes, found[0].shell.basis), load(meshes, expected=id_in(meshes))
    by_panels = [
        witness_runs((stored.sel(shape=shape.name), shape_mesh(shapes, shape, coarser=2)), basis, waves)
        for shape in found
    ]
    by_spectral = [spectral_runs(shape.shell, basis, waves) for shape in found]
    ds = compared(found, by_panels, by_spectral, waves).merge(derivatives(found, by_panels, basis, waves))
    attrs = {"title": "two solvers on the mean and on deformed shapes", "panels": solver, "rows": shapes.rows}
    save(ds.assign_attrs(attrs, **stamp), out)


def solve_block(block: PanelsBlock, fine: xr.Dataset, coarse: xr.Dataset, green_folder: str | Path) -> xr.Dataset:
    """Solve one block of frequencies (`vsb.pipeline.graph`) on two meshes; infinite frequency is a block of its own."""
    water, moved, green = block.water, displacements(block.displacements), green_function(green_folder)
    meshes = (
        AxisymmetricProblem(green, mesh, moved, water.density, water.depth, water.gravity) for mesh in (fine, coarse)
    )
    problem = TwoMeshes(*meshes)
    if block.omega == (math.inf,):
        return problem.at_infinity()
    return problem.solve(list(block.omega), block.interpolation)
