"""Rule mesh: the mean wetted mesh and lid a job of panels reads."""

import math

import xarray as xr

from vsb.hydro.panels import mesh as meshing
from vsb.scenes.rest import reference_shell
from vsb.stages.stage import stamp
from vsb.study.specs import LoadedMesh, SphereMesh
from vsb.tools.files import save


def run(spec: SphereMesh | LoadedMesh, out: str) -> None:
    """Write the mean wetted mesh and lid."""
    save(mean_mesh(spec).assign_attrs(stamp(spec)), out)


def mean_mesh(spec: SphereMesh | LoadedMesh, coarser: int = 1) -> xr.Dataset:
    """Return the mean wetted mesh and lid of a spec, or one with a fraction of the panels in each direction."""
    rows, azimuth, lid_rows = (math.ceil(n / coarser) for n in (spec.rows, spec.azimuth, spec.lid_rows))
    if isinstance(spec, LoadedMesh):
        return meshing.deformed_mesh(reference_shell(spec).shape, rows, azimuth, lid_rows)
    return meshing.mean_mesh(spec.radius, spec.centre_height, rows, azimuth, lid_rows)
