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
from vsb.keys.quantities import content_id
from vsb.models.rest import reference_shell
from vsb.stages.stage import stamp
from vsb.study.resolution import degree
from vsb.study.specs import DeformedSpec, LoadedMesh, LoadedShape, PanelsSpec, Shapes, SphereMesh, WitnessSpec
from vsb.tools.files import load, save, write_text


def run_mesh(spec: SphereMesh | LoadedMesh, out: str) -> None:
    """Write the mean wetted mesh and lid."""
    save(mean_mesh(spec).assign_attrs(stamp(spec)), out)


def mean_mesh(spec: SphereMesh | LoadedMesh, coarser: int = 1) -> xr.Dataset:
    """Return the mean wetted mesh and lid of a spec, or one with a fraction of the panels in each direction."""
    rows, azimuth, lid_rows = (math.ceil(n / coarser) for n in (spec.rows, spec.azimuth, spec.lid_rows))
    if isinstance(spec, LoadedMesh):
        return meshing.deformed_mesh(reference_shell(spec).shape, rows, azimuth, lid_rows)
    return meshing.mean_mesh(spec.radius, spec.centre_height, rows, azimuth, lid_rows)


def run_green(folder: str, out: str) -> None:
    """Compute and store the Green-function table, and say how long it took."""
    begun = clock.perf_counter()
    stored_green_function(folder)
    write_text(out, f"{clock.perf_counter() - begun:.1f} s\n")


def run_panels(spec: PanelsSpec, mesh: str, green: str, out: str) -> None:
    """Solve one block of frequencies, on the mesh and on a coarser one for the error."""
    begun = clock.perf_counter()
    read = load(mesh, expected=content_id(spec.mesh))
    solved = solve_block(spec, read, mean_mesh(spec.mesh, coarser=2), green)
    save(solved.assign_attrs(**stamp(spec), seconds=clock.perf_counter() - begun), out)


def run_deformed(spec: DeformedSpec, out: str) -> None:
    """Write the mesh of every shape into a folder."""
    for shape in shapes(spec):
        mesh = shape_mesh(spec, shape).assign_attrs(**stamp(spec), deformed_by=shape.mode, amplitude=shape.amplitude)
        save(mesh, Path(out) / f"{shape.name}.nc")


def shapes(spec: DeformedSpec) -> list[Deformed]:
    """Return the shell at rest, and deformed by either sign of each mode."""
    return deformed_shapes(_at_rest(spec), spec.deformed, spec.depth)


def shape_mesh(spec: DeformedSpec, shape: Deformed, coarser: int = 1) -> xr.Dataset:
    """Return the mesh of a shape, or one with a fraction of the panels in each direction."""
    return deformed_mesh(shape.shell, spec.rows // coarser, spec.azimuth // coarser, spec.lid_rows // coarser)


def compared_basis(spec: DeformedSpec, basis: ModeBasis) -> ModeBasis:
    """Return heave and the modes whose coefficients are compared."""
    return replace(basis, modes=tuple(mode for mode in basis.modes if mode.label in spec.deformed))


def _at_rest(spec: DeformedSpec) -> DeformedShell:
    """The shell at rest; of one without load the modes that deform it are all there is."""
    shape = spec.shape
    if isinstance(shape, LoadedShape):
        return reference_shell(shape).shape
    rigid = rigid_sphere(shape.radius, shape.centre_height)
    if not isinstance(shape, Shapes):
        return rigid
    shell = Shell(shape.radius, shape.thickness, 1.0, shape.poisson_ratio, 1.0)
    modes = shell_modes(shell, shape.basis, max(map(degree, spec.deformed)))
    basis = ModeBasis(shell, modes, 1.0, bending=False)
    return DeformedShell(compared_basis(spec, basis), shape.centre_height)


def run_witness(spec: WitnessSpec, meshes: str, out: str) -> None:
    """Solve every shape by both solvers, panels on the mesh in a folder and on one of half its rows, and compare."""
    found, water = shapes(spec.meshes), spec.water
    waves = Waves(spec.omega, water.density, water.depth, water.gravity)
    basis = compared_basis(spec.meshes, found[0].shell.basis)
    stored = [load(Path(meshes) / f"{shape.name}.nc", expected=content_id(spec.meshes)) for shape in found]
    by_panels = [
        witness_runs((mesh, shape_mesh(spec.meshes, shape, coarser=2)), basis, waves)
        for shape, mesh in zip(found, stored, strict=True)
    ]
    by_spectral = [spectral_runs(shape.shell, basis, waves) for shape in found]
    ds = compared(found, by_panels, by_spectral, waves).merge(derivatives(found, by_panels, basis, waves))
    attrs = {"title": "two solvers on the mean and on deformed shapes", "panels": spec.solver, "rows": spec.meshes.rows}
    save(ds.assign_attrs(attrs, **stamp(spec)), out)


def solve_block(spec: PanelsSpec, fine: xr.Dataset, coarse: xr.Dataset, green_folder: str | Path) -> xr.Dataset:
    """Solve one block of frequencies (`vsb.pipeline.graph`) on two meshes; infinite frequency is a block of its own."""
    water, moved, green = spec.water, displacements(spec.displacements), green_function(green_folder)
    meshes = (
        AxisymmetricProblem(green, mesh, moved, water.density, water.depth, water.gravity) for mesh in (fine, coarse)
    )
    problem = TwoMeshes(*meshes)
    if spec.omega == (math.inf,):
        return problem.at_infinity()
    return problem.solve(list(spec.omega), spec.interpolation)
