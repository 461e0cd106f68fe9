"""Rule panels: hydrodynamic coefficients of one block of frequencies by panels."""

import time as clock

from vsb.hydro.panels.sweep import solve_block
from vsb.stages.mesh import mean_mesh
from vsb.stages.stage import stamp
from vsb.study.specs import PanelsSpec
from vsb.study.study import content_id
from vsb.tools.files import load, save


def run(spec: PanelsSpec, mesh: str, green: str, out: str) -> None:
    """Solve one block of frequencies, on the mesh and on a coarser one for the error."""
    begun = clock.perf_counter()
    read = load(mesh, expected=content_id(spec.mesh))
    solved = solve_block(spec, read, mean_mesh(spec.mesh, coarser=2), green)
    save(solved.assign_attrs(**stamp(spec), seconds=clock.perf_counter() - begun), out)
