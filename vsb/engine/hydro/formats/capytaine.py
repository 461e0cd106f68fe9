"""Capytaine's own netCDF files, of one body or of several: read.

Names, dimensions and phasors (C1) are those of a database; water stands in coordinates, complex numbers on a dimension.
Degrees of freedom of several bodies are named with the body before them, `float__Heave`. Frequencies may be given as
omega, period, freq, wavenumber or wavelength, and only some motions may radiate.
"""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from vsb.engine.hydro.formats.common import WATER, assembled, point_of, readable, volume_of
from vsb.errors import DatabaseError
from vsb.tools.arrays import AnyArray
from vsb.tools.files import merged
from vsb.tools.variables import VARIABLES

_WATER = ("rho", "g", "water_depth")
_NEEDED = ("added_mass", "radiation_damping", "diffraction_force", "Froude_Krylov_force")
_SOLVED = ("added_mass", "radiation_damping", "diffraction_force")
_AT_REST = ("hydrostatic_stiffness", "inertia_matrix", "structural_stiffness")
_FREQUENCIES = ("omega", "period", "freq", "wavenumber", "wavelength")
_POINTS = {
    "center_of_buoyancy": "centre_of_buoyancy",
    "center_of_mass": "centre_of_mass",
    "rotation_center": "rotation_centre",
}


def read_capytaine(path: str | Path) -> xr.Dataset:
    """Return the hydro database in a netCDF file of capytaine's `export_dataset` or `separate_complex_values`.

    Added mass at zero and infinite frequency is taken from these rows, where they are; motions that did not radiate are
    left out, and so are matrices at rest that hold NaN, capytaine's mark of unknown values, and frequencies at which
    every coefficient is NaN, its mark of a solution that failed. The history records all three. A file without
    hydrostatics gives a database without `hydrostatic_stiffness`. Raises `DatabaseError` if the file cannot be read, or
    lacks what a database needs.
    """
    with readable(path, "a hydro database of capytaine's"):
        with xr.open_dataset(path, engine="netcdf4") as opened:
            ds = merged(_in_plain_types(opened.load()))
        found = _from_capytaine(ds, str(path))
    return found


def _in_plain_types(ds: xr.Dataset) -> xr.Dataset:
    """The dataset with native complex numbers, which netCDF shows as pairs, as complex ones, and bytes as text."""

    def plain(values: AnyArray) -> AnyArray:
        if values.dtype.names and len(values.dtype.names) == 2:
            re, im = (values[name] for name in values.dtype.names)
            return np.asarray(re + 1j * im)
        whole_text = values.dtype.kind == "O" and all(isinstance(value, bytes) for value in values.ravel())
        return np.char.decode(values.astype(bytes), "utf-8") if values.dtype.kind == "S" or whole_text else values

    found = {name: (v.dims, plain(v.values), v.attrs) for name, v in ds.variables.items()}
    data, coords = ({name: found[name] for name in names} for names in (ds.data_vars, ds.coords))
    return xr.Dataset(data, coords, ds.attrs)


def _by_omega(ds: xr.Dataset, source: str) -> xr.Dataset:
    """The dataset over angular frequencies, whichever quantity its file uses."""
    asked = [name for name in _FREQUENCIES if name in ds.added_mass.dims]
    if len(asked) != 1:
        raise DatabaseError(
            f"{source}: added_mass has dimensions {', '.join(map(str, ds.added_mass.dims))}; needs omega."
        )
    (name,) = asked
    if name == "omega":
        return ds
    if "omega" not in ds.coords:
        values = ds[name].values
        if name in ("period", "freq"):
            omega = 2 * np.pi * (values if name == "freq" else 1 / values)
        else:
            k = values if name == "wavenumber" else 2 * np.pi / values
            omega = np.sqrt(float(ds.g) * k * np.tanh(k * float(ds.water_depth)))
        ds = ds.assign_coords(omega=(name, omega))
    return ds.swap_dims({name: "omega"})


def _of_one_case(ds: xr.Dataset, source: str) -> xr.Dataset:
    """The dataset without other dimensions of one entry, and with radiation that does not depend on wave direction.

    Raises `DatabaseError` if there are several cases, or radiation depends on the direction of waves.
    """
    kept = {*_FREQUENCIES, "wave_direction", "influenced_dof", "radiating_dof"}
    used = {str(dim) for name in (*_NEEDED, *_WATER) for dim in ds[name].dims} - kept
    if several := [dim for dim in sorted(used) if ds.sizes[dim] > 1]:
        named = next((name for name in _WATER if several[0] in ds[name].dims), several[0])
        raise DatabaseError(f"{source}: holds {ds.sizes[several[0]]} values of {named}; needs the coefficients of one.")
    ds = ds.squeeze(sorted(used))
    for name in ("added_mass", "radiation_damping"):
        if "wave_direction" in ds[name].dims:
            first = ds[name].isel(wave_direction=0, drop=True)
            if not np.allclose(ds[name], first, rtol=1e-6, atol=1e-9 * float(np.abs(first).max()), equal_nan=True):
                raise DatabaseError(f"{source}: {name} depends on wave_direction; needs coefficients in still water.")
            ds = ds.assign({name: first})
    return ds


def _from_capytaine(ds: xr.Dataset, source: str) -> xr.Dataset:
    """The database in a dataset of capytaine's."""
    if missing := [name for name in (*_NEEDED, *_WATER, "wave_direction") if name not in ds]:
        raise DatabaseError(f"{source}: holds no {', '.join(missing)}; needs a hydro database of capytaine's.")
    ds = _by_omega(_of_one_case(ds, source), source)
    if np.any(ds.get("forward_speed", 0.0)):
        raise DatabaseError(f"{source}: is of a body under way; needs forward_speed 0.")
    omega = np.asarray(ds.omega.values, dtype=float)
    kept = np.isfinite(omega) & (omega > 0)
    history = [f"read from {Path(source).name}"]
    unknown = [ds[name].isnull().all([dim for dim in ds[name].dims if dim != "omega"]) for name in _SOLVED]
    failed = np.logical_and.reduce([kept, *(each.values for each in unknown)])
    if kept.any() and (failed == kept).all():
        raise DatabaseError(f"{source}: all coefficients are NaN at every frequency; needs some that were solved.")
    if failed.any():
        history.append(
            f"left out: {failed.sum()} of {kept.sum()} frequencies, from {omega[failed].min():g} to "
            f"{omega[failed].max():g} rad/s, of which all coefficients are NaN"
        )
    radiating = list(map(str, np.atleast_1d(ds.radiating_dof.values)))
    influenced = list(map(str, ds.influenced_dof.values))
    labels = [label for label in influenced if label in radiating]
    if silent := [label for label in influenced if label not in radiating]:
        history.append(f"left out: {', '.join(silent)}, which did not radiate")
    ds = ds.sel({"influenced_dof": labels, "radiating_dof": labels})
    finite = ds.isel(omega=np.flatnonzero(kept & ~failed)).sortby("omega")
    variables: dict[str, Any] = {}
    for name in (*_NEEDED, *(name for name in _AT_REST if name in ds)):
        values = finite[name].transpose(*VARIABLES[name].dims).values
        if name in _AT_REST and not np.isfinite(values).all():
            history.append(f"left out: {name}, which holds NaN")
            continue
        variables[name] = values
    variables["excitation_force"] = variables["Froude_Krylov_force"] + variables["diffraction_force"]
    for name, limit in (("added_mass_inf", np.isinf(omega)), ("added_mass_zero", omega == 0)):
        if limit.any():
            row = ds.added_mass.isel(omega=int(np.argmax(limit))).transpose(*VARIABLES[name].dims).values
            variables |= {name: row} if name == "added_mass_inf" or np.isfinite(row).all() else {}
    water = (float(ds.rho), float(ds.g), str(float(ds.water_depth)))
    attrs = dict(zip(WATER, water, strict=True), source="capytaine", history="; ".join(history))
    directions = np.degrees(finite.wave_direction.values)
    return assembled(source, (labels, finite.omega.values, directions), variables, attrs | _facts(ds))


def _facts(ds: xr.Dataset) -> dict[str, Any]:
    """Displaced volume, centres and the point of rotation of each body, as far as they are known."""
    names = list(map(str, ds["body"].values)) if ds.sizes.get("body", 1) > 1 else [""]
    points = {name: ds[theirs] for theirs, name in _POINTS.items() if theirs in ds}
    facts: dict[str, Any] = {
        point_of(name, body): point
        for name, values in points.items()
        if values.size == 3 * len(names)
        for body, point in zip(names, np.asarray(values.values, dtype=float).reshape(-1, 3), strict=True)
    }
    if "disp_mass" in ds:
        volumes = np.atleast_1d(ds.disp_mass.values / float(ds.rho))
        facts |= {volume_of(name): float(volume) for name, volume in zip(names, volumes, strict=True)}
    return {name: value for name, value in facts.items() if np.isfinite(value).all()}
