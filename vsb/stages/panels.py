"""Rule panels: hydrodynamic coefficients of one block of frequencies by panels."""

import time as clock

from vsb.hydro.panels.sweep import solve_block
from vsb.stages.mesh import mean_mesh
from vsb.study.specs import PanelsSpec
from vsb.study.study import canonical, content_id
from vsb.tools.files import load, save


def run(spec: PanelsSpec, mesh: str, green: str, out: str) -> None:
    """Solve one block of frequencies, on the mesh and on a coarser one for the error."""
    begun = clock.perf_counter()
    solved = solve_block(spec, load(mesh), mean_mesh(spec.mesh, coarser=2), green)
    attrs = {"spec": canonical(spec), "spec_id": content_id(spec), "seconds": clock.perf_counter() - begun}
    save(solved.assign_attrs(solved.attrs | attrs), out)
