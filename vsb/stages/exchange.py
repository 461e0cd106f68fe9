"""Databases from other codes' files."""

from pathlib import Path
from typing import Any

import xarray as xr

from vsb.hydro import database
from vsb.hydro.formats import bemio, wamit
from vsb.hydro.formats import exchange as interchange
from vsb.hydro.formats.modes import check_positive
from vsb.tools.files import save

Spec = dict[str, Any]


def import_wamit(
    folder: str,
    name: str,
    out: str,
    *,
    density: float,
    gravity: float,
    length: float,
    depth: float,
    axisymmetric: bool,
) -> tuple[list[database.Check], list[str]]:
    """Read WAMIT's output into a database file; return its verdict and what was left out."""
    values = (density, "kg/m^3"), (gravity, "m/s^2"), (length, "m"), (depth, "m")
    for option, (value, unit) in zip(("density", "gravity", "length", "depth"), values, strict=True):
        check_positive(f"--{option}", value, unit, infinite=option == "depth")
    ds = wamit.import_wamit(folder, name, density=density, gravity=gravity, length=length, depth=depth)
    return _store_foreign(ds, out, axisymmetric)


def import_bemio(path: str, out: str, *, axisymmetric: bool) -> tuple[list[database.Check], list[str]]:
    """Read BEMIO's .h5 into a database file; return its verdict and what was left out."""
    return _store_foreign(bemio.read_bemio(path), out, axisymmetric)


def _store_foreign(ds: xr.Dataset, out: str, axisymmetric: bool) -> tuple[list[database.Check], list[str]]:
    """Store a database of another code with the verdict of the identities that need no other data."""
    checks, missing = interchange.foreign_checks(ds, axisymmetric=axisymmetric)
    notes = [ds.attrs["history"], *[missing] * bool(missing)]
    attrs = {"quality": database.as_json(checks), "spec_id": Path(out).stem, "separate_sweep": 0}
    save(ds.assign_attrs(**attrs, history="; ".join(notes)), out)
    return checks, notes
