"""Rules mesh and display_meshes: the mean wetted mesh a job of panels reads, and viewable deformed ones."""

import math
from typing import Any

import xarray as xr

from vsb.hydro.panels import mesh as meshing
from vsb.scenes.rest import reference_shell
from vsb.stages.stage import partial_study
from vsb.tools.files import save

Spec = dict[str, Any]


def mesh(spec: Spec, out: str) -> None:
    """Write the mean wetted mesh and lid a BEM job reads."""
    save(mean_mesh(spec), out)


def mean_mesh(spec: Spec, coarser: int = 1) -> xr.Dataset:
    """Return the mean wetted mesh and lid of a spec, or one with a fraction of the panels in each direction."""
    panels = {key: math.ceil(spec[key] / coarser) for key in ("rows", "azimuth", "lid_rows")}
    if spec.get("reference_shape") == "equilibrium":
        return meshing.deformed_mesh(reference_shell(partial_study(spec)).shape, **panels)
    return meshing.mean_mesh(spec["radius"], spec["centre_height"], **panels)


def display_meshes(spec: Spec, folder: str) -> None:
    """Write the viewable meshes: the mean wetted shell, and one deformed shell per mode and sign."""
    study = partial_study(spec)
    for name, shape in meshing.display_shapes(reference_shell(study).shape).items():
        meshing.write_wet_shell(shape, f"{folder}/{name}.vtu")
