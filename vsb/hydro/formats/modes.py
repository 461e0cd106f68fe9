"""What the forms of WAMIT and BEMIO share: numbers of modes, facts about the body, its structure.

Both know six rigid modes, 1 to 6 = Surge, Sway, Heave, Roll, Pitch, Yaw, and generalized ones from 7 on. Translations
and generalized modes have amplitudes in metres, rotations, about the point the body's mode shapes turn about, in
radians: coefficients of a rotation take one more length each.
"""

import json
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vsb.errors import ConfigError, DatabaseError
from vsb.hydro.dofs import RIGID
from vsb.tools.units import ATTRS, FloatArray, check_finite, described

GENERALIZED = 7
"""Number of the first generalized mode."""
WATER = ("water_density", "gravity", "water_depth")
"""Facts every database holds."""
DRY = ("structural_stiffness", "prestress_stiffness", "gas_stiffness")
"""All stiffness but the water's."""


class Floating(NamedTuple):
    """A body at rest."""

    volume: float  # of the water it displaces [m^3]
    centre_of_buoyancy: FloatArray  # (xyz,) [m]
    centre_of_mass: FloatArray  # (xyz,) [m]


class Structure(NamedTuple):
    """Modal matrices of a body without water, shape (dof, dof)."""

    mass: FloatArray  # [kg]
    damping: FloatArray  # [kg/s]
    stiffness: FloatArray  # [N/m], prestress and gas included


def mode_numbers(labels: Sequence[str]) -> list[int]:
    """Return the numbers of degrees of freedom: 1 to 6 for those named as in `RIGID`, 7, 8, ... for the others."""
    if not labels or len(set(labels)) < len(labels):
        raise DatabaseError(f"degrees of freedom {list(labels)}: needs at least one, and none twice.")
    others = [label for label in labels if label not in RIGID]
    return [RIGID.index(label) + 1 if label in RIGID else GENERALIZED + others.index(label) for label in labels]


def mode_labels(numbers: Sequence[int]) -> list[str]:
    """Return the labels of modes: those of `RIGID`, then Mode7, Mode8, ..."""
    return [RIGID[n - 1] if n < GENERALIZED else f"Mode{n}" for n in numbers]


def rotations(modes: Sequence[int]) -> FloatArray:
    """Return 1 for rotations, modes 4 to 6, and 0 for the others: how many more lengths a coefficient takes."""
    return np.array([float(4 <= mode < GENERALIZED) for mode in modes])


def check_positive(name: str, value: float, unit: str, *, infinite: bool = False) -> None:
    """Raise `ConfigError` unless a value is positive and, but for those that may be infinite, finite."""
    if not value > 0 or not (infinite or math.isfinite(value)):
        needed = f"a positive number of {unit}" + (", or inf" if infinite else "")
        raise ConfigError(f"{name}: received {value}, needs {needed}.")


def checked(ds: xr.Dataset, source: str, needed: Sequence[str] = ()) -> xr.Dataset:
    """Return the dataset with dimensions in order, after checking that it holds what is needed, and no NaN.

    Errors name the source.
    """
    if missing := [name for name in (*WATER, *needed) if name not in ds and name not in ds.attrs]:
        raise DatabaseError(f"{source}: holds no {', '.join(missing)}; needs a complete hydro database.")
    check_finite(ds, source)
    if not (np.isfinite(omega := ds.omega.values).all() and omega[0] >= 0 and np.all(np.diff(omega) > 0)):
        raise DatabaseError(f"{source}: frequencies {omega} rad/s; needs finite, ascending ones, none negative.")
    return described(ds)


def assembled(source: str, axes: tuple[Any, Any, Any], variables: dict[str, Any], attrs: dict[str, Any]) -> xr.Dataset:
    """Return arrays over labels, frequencies and headings [degrees] as a hydro database: units everywhere, no NaN."""
    labels, omega, headings = axes
    dofs = dict.fromkeys(("influenced_dof", "radiating_dof"), labels)
    data = {name: (ATTRS[name].dims, values) for name, values in variables.items()}
    return checked(xr.Dataset(data, {"omega": omega, "wave_direction": np.radians(headings), **dofs}, attrs), source)


def floating(ds: xr.Dataset, source: str) -> Floating:
    """Return what a database says of the body at rest, which for a sphere follows from its radius, height and mass."""
    names = ("displaced_volume", "centre_of_buoyancy", "centre_of_mass")
    missing = [name for name in names if name not in ds.attrs]
    if not missing:
        volume, buoyancy, mass = (np.asarray(ds.attrs[name], dtype=float) for name in names)
        return Floating(float(volume), buoyancy, mass)
    if {"radius", "centre_height"} - set(ds.attrs) or "inertia_matrix" not in ds or "Heave" not in ds.influenced_dof:
        raise DatabaseError(f"{source}: holds no {', '.join(missing)}; needs them in its attributes.")
    r, z = (float(ds.attrs[name]) for name in ("radius", "centre_height"))
    heave = float(ds.inertia_matrix.sel(influenced_dof="Heave", radiating_dof="Heave"))
    wet = z - 0.75 * (r + z) ** 2 / (2 * r + z)  # centroid of the cap below z = 0, of height r - z
    return Floating(heave / float(ds.attrs["water_density"]), np.array([0, 0, wet]), np.array([0, 0, z]))


def structure(ds: xr.Dataset, source: str) -> Structure | None:
    """Return mass, damping and stiffness of the dry body, or None if the database has no mass or no stiffness.

    Damping is that stored, or Rayleigh's of the device in the spec, alpha M + beta K, of the generalized modes.
    """
    if {"inertia_matrix", "structural_stiffness"} - set(ds):
        return None
    mass, elastic = ds.inertia_matrix.values, ds.structural_stiffness.values
    stiffness = np.sum([ds[name].values for name in DRY if name in ds], axis=0)
    if "structural_damping_matrix" in ds:
        return Structure(mass, ds.structural_damping_matrix.values, stiffness)
    if "spec" not in ds.attrs:
        raise DatabaseError(f"{source}: holds no spec; needs structural_damping_matrix, or a spec with its factors.")
    factors = json.loads(ds.attrs["spec"]).get("device", {}).get("damping", {"alpha": 0.0, "beta": 0.0})
    damping = factors["alpha"] * mass + factors["beta"] * elastic
    rigid = np.isin(ds.influenced_dof.values, RIGID)
    damping[rigid, :] = damping[:, rigid] = 0.0
    return Structure(mass, damping, stiffness)
