"""Rule witness: panels and the spectral solver on the mean and on deformed shells, how far they are apart."""

from pathlib import Path

from vsb.hydro.panels.sweep import witness_runs
from vsb.hydro.witness import Waves, compared, derivatives, spectral_runs
from vsb.stages.deformed import compared_basis, shape_mesh, shapes
from vsb.stages.stage import stamp
from vsb.study.specs import WitnessSpec
from vsb.study.study import content_id
from vsb.tools.files import load, save


def run(spec: WitnessSpec, meshes: str, green: str, out: str) -> None:
    """Solve every shape by both solvers, panels on the mesh in a folder and on one of half its rows, and compare."""
    found, water = shapes(spec.meshes), spec.water
    waves = Waves(spec.omega, water.density, water.depth, water.gravity)
    basis = compared_basis(spec.meshes, found[0].shell.basis)
    stored = [load(Path(meshes) / f"{shape.name}.nc", expected=content_id(spec.meshes)) for shape in found]
    by_panels = [
        witness_runs(green, (mesh, shape_mesh(spec.meshes, shape, coarser=2)), basis, waves)
        for shape, mesh in zip(found, stored, strict=True)
    ]
    by_spectral = [spectral_runs(shape.shell, basis, waves) for shape in found]
    ds = compared(found, by_panels, by_spectral, waves).merge(derivatives(found, by_panels, basis, waves))
    attrs = {"title": "two solvers on the mean and on deformed shapes", "panels": spec.solver, "rows": spec.meshes.rows}
    save(ds.assign_attrs(attrs, **stamp(spec)), out)
