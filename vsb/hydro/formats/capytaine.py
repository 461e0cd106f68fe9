"""Capytaine's own netCDF files, of one body or of several: read.

Names, dimensions and phasors (C1) are those of a database; water stands in coordinates, complex numbers on a dimension.
Degrees of freedom of several bodies are named with the body before them, `float__Heave`.
"""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from vsb.errors import DatabaseError
from vsb.hydro.formats.modes import WATER, assembled, readable
from vsb.tools.units import ATTRS, BoolArray, merged

_WATER = ("rho", "g", "water_depth")
_NEEDED = ("added_mass", "radiation_damping", "diffraction_force", "Froude_Krylov_force", "hydrostatic_stiffness")
_SOLVED = ("added_mass", "radiation_damping", "diffraction_force")
_DRY = {"inertia_matrix": "mass", "structural_stiffness": "stiffness"}


def read_capytaine(path: str | Path) -> xr.Dataset:
    """Return the hydro database in a netCDF file of capytaine's `export_dataset` or `separate_complex_values`.

    Added mass at infinite frequency is taken from that row, if there is one; rows of zero frequency, which no motion
    needs, are left out, and so are matrices of the dry body that hold NaN, capytaine's mark of what it does not know,
    and frequencies at which every coefficient is NaN, its mark of a solution that failed. The history tells of both.

    Raises
    ------
    DatabaseError
        If the file cannot be read, or lacks what a database needs.
    """
    with readable(path, "a hydro database of capytaine's"):
        with xr.open_dataset(path, engine="netcdf4") as opened:
            ds = merged(opened.load())
        found = _from_capytaine(ds, str(path))
    return found


def _failed(ds: xr.Dataset) -> BoolArray:
    """Frequencies at which nothing that is solved for is known, (omega,)."""
    unknown = [ds[name].isnull().all([dim for dim in ds[name].dims if dim != "omega"]) for name in _SOLVED]
    found: BoolArray = np.logical_and.reduce([each.values for each in unknown])
    return found


def _from_capytaine(ds: xr.Dataset, source: str) -> xr.Dataset:
    """The database in a dataset of capytaine's."""
    if missing := [name for name in (*_NEEDED, *_WATER, "omega", "wave_direction") if name not in ds]:
        raise DatabaseError(f"{source}: holds no {', '.join(missing)}; needs a hydro database of capytaine's.")
    for name in _WATER:
        if ds[name].size != 1:
            raise DatabaseError(f"{source}: holds {ds[name].size} values of {name}; needs the coefficients of one.")
    if float(ds.get("forward_speed", 0.0)):
        raise DatabaseError(f"{source}: is of a body under way; needs forward_speed 0.")
    omega = np.asarray(ds.omega.values, dtype=float)
    kept = np.isfinite(omega) & (omega > 0)
    labels, history = list(map(str, ds.influenced_dof.values)), [f"read from {Path(source).name}"]
    failed = kept & _failed(ds)
    if kept.any() and (failed == kept).all():
        raise DatabaseError(f"{source}: all coefficients are NaN at every frequency; needs some that were solved.")
    if failed.any():
        history.append(
            f"left out: {failed.sum()} of {kept.sum()} frequencies, from {omega[failed].min():g} to "
            f"{omega[failed].max():g} rad/s, of which all coefficients are NaN"
        )
    finite = ds.isel(omega=np.flatnonzero(kept & ~failed)).sortby("omega")
    radiating = [list(map(str, ds.radiating_dof.values)).index(label) for label in labels]
    variables: dict[str, Any] = {}
    for name in (*_NEEDED, *(name for name in _DRY if name in ds)):
        data = finite[name].transpose(*ATTRS[name].dims)
        values = data.isel(radiating_dof=radiating).values if "radiating_dof" in data.dims else data.values
        if name in _DRY and not np.isfinite(values).all():
            history.append(f"left out: {name}, which holds NaN")
            continue
        variables[name] = values
    variables["excitation_force"] = variables["Froude_Krylov_force"] + variables["diffraction_force"]
    if np.isinf(omega).any():
        limit = ds.added_mass.isel(omega=int(np.argmax(omega)), radiating_dof=radiating)
        variables["added_mass_inf"] = limit.transpose(*ATTRS["added_mass_inf"].dims).values
    water = (float(ds.rho), float(ds.g), str(float(ds.water_depth)))
    attrs = dict(zip(WATER, water, strict=True), source="capytaine", history="; ".join(history))
    return assembled(source, (labels, finite.omega.values, np.degrees(finite.wave_direction.values)), variables, attrs)
