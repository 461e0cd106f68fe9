"""Rule deformed: meshes of the shell at rest and deformed by its modes, for the second solver."""

from dataclasses import replace
from pathlib import Path

import xarray as xr

from vsb.hydro.panels.mesh import deformed_mesh
from vsb.hydro.witness import Deformed, deformed_shapes
from vsb.scenes.rest import reference_shell
from vsb.shell.deformed import DeformedShell, rigid_sphere
from vsb.shell.modes import ModeBasis, shell_modes
from vsb.shell.sphere import Shell
from vsb.stages.stage import stamp
from vsb.study.blocks import degree
from vsb.study.specs import DeformedSpec, LoadedShape, Shapes
from vsb.tools.files import save


def run(spec: DeformedSpec, out: str) -> None:
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
