"""Shared by all formats: numbers and names of modes, the body at rest, its structure, and checks of plain numbers.

WAMIT and BEMIO know six rigid modes, 1 to 6 = Surge, Sway, Heave, Roll, Pitch, Yaw, and generalized ones from 7 on.
Translations and generalized modes have amplitudes in metres, rotations in radians, about the origin of the body's mode
shapes: coefficients have one more length for each rotation.
"""

import json
import math
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro.database import transformed
from vsb.engine.hydro.variables import PAIR, RIGID, ROTATIONS, is_rigid, of_bodies
from vsb.errors import ConfigError, DatabaseError
from vsb.tools.arrays import FloatArray
from vsb.tools.files import bounded_reading, reason_of
from vsb.tools.variables import VARIABLES, check_finite, described

GENERALIZED = 7
"""Number of the first generalized mode."""
WATER = ("water_density", "gravity", "water_depth")
"""Facts every database holds."""
POINTS = ("centre_of_buoyancy", "centre_of_mass", "rotation_centre")
"""Points of a body that a database may state."""
RANGE = (1e-6, 1e6)
"""Of density, gravity, length, depth and frequency in SI units: beyond, products of coefficients may overflow."""
LARGEST = 1e40
"""Coefficient of any body in SI units; its square is far from overflow."""
DRY = ("structural_stiffness", "prestress_stiffness", "gas_stiffness")
"""All stiffness but the water's."""
_DAMAGE = (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError, ArithmeticError, MemoryError)
"""Errors netCDF4, xarray and numpy raise for a damaged file."""


def whole_lines(path: str | Path, text: str) -> list[str]:
    """Return the lines of a table; `DatabaseError` if the last is shorter than the others, and has no end.

    A number that lost its last digits, or those of its exponent, is still a number.
    """
    lines = text.splitlines()
    lengths = [len(line.rstrip()) for line in lines[-3:]]
    if text[-1:] not in ("\n", "\r", "") and len(lengths) == 3 and lengths[2] < lengths[1] == lengths[0]:
        raise DatabaseError(
            f"{path}, line {len(lines)}: is shorter than those before, and has no end: it was cut; needs all of it, "
            "or a new line at its end."
        )
    return lines


@contextmanager
def readable(path: str | Path, needed: str) -> Iterator[None]:
    """Read a file within bounds; a `DatabaseError` in one line for whatever error a library raises."""
    try:
        with bounded_reading(path):
            yield
    except DatabaseError:
        raise
    except _DAMAGE as error:
        raise DatabaseError(f"{path}: cannot be read: {reason_of(error)}; needs {needed}.") from None


class Floating(NamedTuple):
    """A body at rest."""

    volume: float  # of the water it displaces [m^3]
    centre_of_buoyancy: FloatArray  # (xyz,) [m]
    centre_of_mass: FloatArray  # (xyz,) [m]


class Structure(NamedTuple):
    """Modal matrices of a body without water, shape (dof, dof)."""

    mass: FloatArray  # [kg]
    damping: FloatArray  # [N s/m]
    stiffness: FloatArray  # [N/m], prestress and gas included


def mode_numbers(labels: Sequence[str]) -> list[int]:
    """Return the numbers of degrees of freedom: 1 to 6 for those named as in `RIGID`, 7, 8, ... for the others."""
    if not labels or len(set(labels)) < len(labels):
        raise DatabaseError(f"degrees of freedom {list(labels)}: needs at least one, and none twice.")
    if several := [label for label in labels if is_rigid(label) and label not in RIGID]:
        raise DatabaseError(f"degrees of freedom {', '.join(several)}: are of several bodies; needs those of one.")
    others = [label for label in labels if label not in RIGID]
    return [RIGID.index(label) + 1 if label in RIGID else GENERALIZED + others.index(label) for label in labels]


def mode_labels(numbers: Sequence[int]) -> list[str]:
    """Return the labels of modes: those of `RIGID`, then Mode7, Mode8, ..."""
    return [RIGID[n - 1] if n < GENERALIZED else f"Mode{n}" for n in numbers]


def body_names(found: Sequence[str]) -> list[str]:
    """Return the prefix of labels of each body: its name, or body1, ... if names do not serve; of one body none."""
    if len(found) == 1:
        return [""]
    proper = all(re.fullmatch(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*", name) for name in found)
    return list(found) if proper and len(set(found)) == len(found) else [f"body{k + 1}" for k in range(len(found))]


def volume_of(body: str) -> str:
    """Return the attribute with the displaced volume of a body [m^3]; a single body has no name."""
    return f"displaced_volume_{body}" if body else "displaced_volume"


def point_of(name: str, body: str) -> str:
    """Return the attribute with a point of a body, (xyz,) [m], such as `centre_of_mass`; a single body has no name."""
    return f"{name}_{body}" if body else name


def rotations(modes: Sequence[int]) -> FloatArray:
    """Return 1 for rotations, modes 4 to 6, and 0 for the others: the additional lengths of a coefficient."""
    return np.array([float(4 <= mode < GENERALIZED) for mode in modes])


def check_positive(name: str, value: float, unit: str, *, infinite: bool = False) -> None:
    """Raise `ConfigError` unless a value is positive and in `RANGE`, or infinite where it may be."""
    low, high = RANGE
    if not (low <= value <= high or (infinite and value == math.inf)):
        needed = f"a positive number of {unit}" + (", or inf" if infinite else "")
        beyond = f" from {low:g} to {high:g}" if 0 < value < math.inf else ""
        raise ConfigError(f"{name}: received {value}, needs {needed}{beyond}.")


def checked(ds: xr.Dataset, source: str, needed: Sequence[str] = ()) -> xr.Dataset:
    """Return the dataset with dimensions in order, after checking that it is complete and has plausible numbers.

    Checked are variables, coordinates and the attributes about water and body. Errors name the source.
    """
    if missing := [name for name in (*WATER, *needed) if name not in ds and name not in ds.attrs]:
        raise DatabaseError(f"{source}: holds no {', '.join(missing)}; needs a complete hydro database.")
    for name, unit in zip(WATER, ("kg/m^3", "m/s^2", "m"), strict=True):
        try:
            check_positive(name, float(ds.attrs[name]), unit, infinite=name == "water_depth")
        except (ConfigError, TypeError, ValueError) as error:
            raise DatabaseError(f"{source}: {error}") from None
    bodies = list(of_bodies(map(str, ds.influenced_dof.values)))
    for name in map(volume_of, bodies):
        volume = np.asarray(ds.attrs.get(name, 0.0), dtype=float)
        if volume.shape or not 0 <= volume <= LARGEST:
            raise DatabaseError(f"{source}: {name} {volume} m^3; needs a finite one, not negative.")
    for name in (point_of(name, body) for name in POINTS for body in {"", *bodies}):
        centre = np.asarray(ds.attrs.get(name, np.zeros(3)), dtype=float)
        if centre.shape != (3,) or not np.all(np.abs(centre) <= LARGEST):
            raise DatabaseError(f"{source}: {name} {centre} m; needs three finite numbers.")
    omega, headings = ds.omega.values, ds.wave_direction.values
    if not (omega.size and np.isfinite(omega).all() and omega[0] >= 0 and np.all(np.diff(omega) > 0)):
        raise DatabaseError(f"{source}: frequencies {omega} rad/s; needs finite, ascending ones, none negative.")
    if np.any(omega[omega > 0] < RANGE[0]) or omega[-1] > RANGE[1]:
        raise DatabaseError(f"{source}: frequencies {omega} rad/s; needs them from {RANGE[0]:g} to {RANGE[1]:g}.")
    if not (headings.size and np.isfinite(headings).all() and len(np.unique(headings)) == headings.size):
        raise DatabaseError(f"{source}: wave directions {np.degrees(headings)} degrees; needs finite ones, none twice.")
    check_finite(ds, source)
    for variable, data in ds.data_vars.items():
        if np.abs(data.values).max(initial=0.0) > LARGEST:
            raise DatabaseError(f"{source}: {variable} holds {np.abs(data.values).max():.3g}; no body has that.")
    return described(ds)


def assembled(source: str, axes: tuple[Any, Any, Any], variables: dict[str, Any], attrs: dict[str, Any]) -> xr.Dataset:
    """Return arrays over labels, frequencies and headings [degrees] as a hydro database: units everywhere, no NaN."""
    labels, omega, headings = axes
    dofs = dict.fromkeys(PAIR, labels)
    data = {name: (VARIABLES[name].dims, values) for name, values in variables.items()}
    return checked(xr.Dataset(data, {"omega": omega, "wave_direction": np.radians(headings), **dofs}, attrs), source)


_AT_REST = ("displaced_volume", "centre_of_buoyancy", "centre_of_mass")


def _is_sphere(ds: xr.Dataset) -> bool:
    """Whether the displaced water follows from radius, height and mass in heave."""
    return {"radius", "centre_height"} <= {*ds.attrs} and "inertia_matrix" in ds and "Heave" in ds.influenced_dof


def is_floating(ds: xr.Dataset) -> bool:
    """Return whether a database has the attributes for `floating`."""
    return {*_AT_REST} <= {*ds.attrs} or _is_sphere(ds)


def floating(ds: xr.Dataset, source: str) -> Floating:
    """Return the body at rest; for a sphere it follows from radius, height and mass."""
    missing = [name for name in _AT_REST if name not in ds.attrs]
    if not missing:
        volume, buoyancy, mass = (np.asarray(ds.attrs[name], dtype=float) for name in _AT_REST)
        return Floating(float(volume), buoyancy, mass)
    if not _is_sphere(ds):
        raise DatabaseError(f"{source}: holds no {', '.join(missing)}; needs them in its attributes.")
    r, z = (float(ds.attrs[name]) for name in ("radius", "centre_height"))
    heave = float(ds.inertia_matrix.sel(influenced_dof="Heave", radiating_dof="Heave"))
    wet = z - 0.75 * (r + z) ** 2 / (2 * r + z)  # centroid of the cap below z = 0, of height r - z
    above = _device(ds).get("centre_of_mass") or 0.0
    return Floating(heave / float(ds.attrs["water_density"]), np.array([0, 0, wet]), np.array([0, 0, z + above]))


def _device(ds: xr.Dataset) -> dict[str, Any]:
    """The device of a database by its spec; empty if it names none."""
    spec = json.loads(ds.attrs.get("spec", "{}"))
    found: dict[str, Any] = spec.get("study", spec).get("device", {})  # until 1.0.0 beside all else
    return found


def rotation_centre(ds: xr.Dataset) -> FloatArray | None:
    """Return the centre of the rotations of a database, (xyz,) [m], of a buoy its own centre; None if unknown."""
    if "rotation_centre" in ds.attrs:
        return np.asarray(ds.attrs["rotation_centre"], dtype=float)
    return np.array([0.0, 0.0, float(ds.attrs["centre_height"])]) if "centre_height" in ds.attrs else None


def turned_about(ds: xr.Dataset, point: FloatArray, source: str) -> xr.Dataset:
    """Return matrices and forces with rotations about another point.

    A rotation a about the point is one about the database's own centre and a translation a x (own - point). Raises
    `DatabaseError` if the centre of rotations is unknown, or the translations this takes are not in the database.
    """
    labels = [str(label) for label in ds.influenced_dof.values]
    turning = [label for label in labels if label in ROTATIONS]
    if not turning:
        return ds
    at = f"the centre of mass ({', '.join(f'{x:g}' for x in point)})"
    if (own := rotation_centre(ds)) is None:
        raise DatabaseError(
            f"{source}: holds no rotation_centre, what {', '.join(turning)} turn about; needs it in its attributes, "
            f"for rotations about {at}."
        )
    shares, size = np.eye(len(labels)), 1e-9 * (1.0 + float(np.abs(own).max()))
    for label in turning:
        moved = np.cross(np.eye(3)[ROTATIONS.index(label)], own - point)
        for translation, share in zip(RIGID[:3], moved, strict=True):
            if translation in labels:
                shares[labels.index(label), labels.index(translation)] = share
            elif abs(share) > size:
                raise DatabaseError(
                    f"{source}: {label} turns about ({', '.join(f'{x:g}' for x in own)}); needs {translation} beside "
                    f"it to turn about {at}."
                )
    names = [name for name, data in ds.data_vars.items() if data.dims[-1] in PAIR]
    return ds.assign(transformed(ds[names], shares, labels)).assign_attrs(rotation_centre=point)


def structure(ds: xr.Dataset, source: str, damping: FloatArray | None = None) -> Structure | None:
    """Return mass, damping and stiffness of the dry body, or None if the database has no mass or no stiffness.

    Damping is the given, else the stored, else Rayleigh damping of the device in the spec, alpha M + beta K of the
    generalized modes.
    """
    if {"inertia_matrix", "structural_stiffness"} - set(ds):
        return None
    mass, elastic = ds.inertia_matrix.values, ds.structural_stiffness.values
    stiffness = np.sum([ds[name].values for name in DRY if name in ds], axis=0)
    if damping is not None:
        return Structure(mass, damping, stiffness)
    if "structural_damping_matrix" in ds:
        return Structure(mass, ds.structural_damping_matrix.values, stiffness)
    if "spec" not in ds.attrs:
        raise DatabaseError(f"{source}: holds no spec; needs structural_damping_matrix, or a spec with its factors.")
    factors = _device(ds).get("damping", {"alpha": 0.0, "beta": 0.0})
    damping = factors["alpha"] * mass + factors["beta"] * elastic
    rigid = np.array([is_rigid(str(label)) for label in ds.influenced_dof.values])
    damping[rigid, :] = damping[:, rigid] = 0.0
    return Structure(mass, damping, stiffness)
