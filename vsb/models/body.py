"""A body of a study from its database: degrees of freedom chosen, matrices of the dry body as the study has them."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from vsb.engine.hydro.bodies.body import FlexibleBody
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.engine.hydro.database import with_history, with_symmetrized
from vsb.engine.hydro.formats.checks import sizes
from vsb.engine.hydro.formats.common import DRY, structure, volume_of
from vsb.engine.hydro.repairs import with_symmetric_stiffness
from vsb.engine.hydro.variables import PAIR, is_rigid, of_bodies
from vsb.engine.motion.linear import LinearSystem, linear_body
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.study.body import Body, Matrix, Rows
from vsb.tools.arrays import FloatArray

_SAME_WATER = 1e-6
FEWEST = 4
"""Frequencies a radiation memory can be fitted to."""


def within_band(ds: xr.Dataset, omega_max: float | None) -> xr.Dataset:
    """Return a database without the frequencies above one [rad/s], and the repair in its history.

    Raises `ConfigError` if fewer than four are left.
    """
    kept = ds.omega.values > 0 if omega_max is None else (ds.omega.values > 0) & (ds.omega.values <= omega_max + 1e-9)
    if kept.sum() < FEWEST:
        left = f"{kept.sum()} of {len(kept)} frequencies of the database"
        received = f"hydro.omega_max: received {omega_max:g} rad/s, which leaves {left}" if omega_max else ""
        raise ConfigError(f"{received or f'body: received {left} above zero'}; needs {FEWEST} or more")
    if kept.all():
        return ds
    return with_history(ds.isel(omega=np.flatnonzero(kept)), f"left out: {np.count_nonzero(~kept)} frequencies")


def without_negative_ends(ds: xr.Dataset, labels: Sequence[str]) -> xr.Dataset:
    """Return a database without the frequencies at the ends of its band where a motion's own damping is not positive.

    That is noise of files of others where hardly any waves are made; no sea need reach there, and the history says so.
    Where fewer than four frequencies would be left, or damping is negative inside, the database stays as it is.
    """
    part = ds.sel(influenced_dof=list(labels), radiating_dof=list(labels))
    own = np.einsum("wii->wi", part.radiation_damping.values)[:, sizes(part).wet]
    good = np.flatnonzero((own > 0).all(axis=1))
    if len(good) == len(own) or len(good) < FEWEST:
        return ds
    kept = np.arange(good[0], good[-1] + 1)
    if len(kept) == len(own):
        return ds
    first, last = ds.omega.values[kept[[0, -1]]]
    return with_history(
        ds.isel(omega=kept),
        f"left out: {len(own) - len(kept)} frequencies outside {first:g} to {last:g} rad/s, where damping is negative",
    )


def with_hydrostatics(body: Body, ds: xr.Dataset) -> xr.Dataset:
    """Return a database with hydrostatic stiffness: none where files hold none and the study's is all there is.

    Raises `ConfigError` if neither files nor study have a stiffness.
    """
    if "hydrostatic_stiffness" in ds:
        return ds
    if body.stiffness is None:
        raise ConfigError(
            "body.stiffness: received none, and the body's files hold no hydrostatic stiffness; needs that of still "
            "water and mooring in N/m, of rotations in N m (or capytaine's fill_dataset with hydrostatics=True)"
        )
    none = np.zeros((ds.sizes["influenced_dof"],) * 2)
    made = ds.assign(hydrostatic_stiffness=(PAIR, none))
    return with_history(made, "no hydrostatic stiffness: the study's is all there is")


def complete_body(body: Body, dofs: Sequence[str] | None, ds: xr.Dataset) -> LinearSystem:
    """Return the body of a study from the database of its files.

    Raises `ConfigError` if degrees of freedom, or masses of rigid motions, are missing.

    Parameters
    ----------
    body : Body
        Its matrices stand before those of the files.
    dofs : sequence of str or None
        Degrees of freedom kept, `rigid` for all rigid ones; all.
    """
    labels = [str(label) for label in ds.influenced_dof.values]
    mass, damping, stiffness = (
        with_entries(name, given, labels, held)
        for name, given, held in (
            ("mass", body.mass, _held(ds, ("inertia_matrix",))),
            ("damping", body.damping, _damping(ds)),
            ("stiffness", body.stiffness, _held(ds, DRY)),
        )
    )
    kept = chosen(dofs, labels)
    index = [labels.index(label) for label in kept]
    for label, i in zip(kept, index, strict=True):
        if mass[i, i] < 0:
            raise ConfigError(f"body.mass: received {mass[i, i]:g} for {label}; needs a mass above 0")
    if weightless := [label for label, i in zip(kept, index, strict=True) if is_rigid(label) and not mass[i, i] > 0]:
        raise ConfigError(
            f"body.mass: received none for {', '.join(weightless)}, nor do the files hold one; needs the mass in kg, "
            "of rotations in kg m^2"
        )
    pick = np.ix_(index, index)
    even, _ = with_symmetric_stiffness(with_symmetrized(ds))
    return linear_body(even, kept, mass=mass[pick], damping=damping[pick], stiffness=stiffness[pick])


def chosen(dofs: Sequence[str] | None, labels: Sequence[str]) -> list[str]:
    """Return the degrees of freedom kept, in the order of the file; `rigid` are all rigid ones."""
    if dofs is None:
        return list(labels)
    if unknown := [name for name in dofs if name not in (*labels, "rigid")]:
        raise ConfigError(f"designs: received dofs {', '.join(unknown)}; needs some of {', '.join(labels)}")
    kept = [label for label in labels if label in dofs or ("rigid" in dofs and is_rigid(label))]
    if not kept:
        raise ConfigError(f"designs: received dofs rigid, but {', '.join(labels)} are none; needs some of these")
    return kept


def _damping(ds: xr.Dataset) -> FloatArray:
    """Structural damping a database holds, or a buoy's by the factors in its spec; zero without."""
    if "structural_damping_matrix" not in ds and "spec" in ds.attrs and (dry := structure(ds, "database")):
        return dry.damping
    return _held(ds, ("structural_damping_matrix",))


def _held(ds: xr.Dataset, names: Sequence[str]) -> FloatArray:
    """Sum of the matrices of a database by these names; zero without."""
    none = np.zeros((ds.sizes["influenced_dof"],) * 2)
    return np.asarray(sum((ds[name].values for name in names if name in ds), none))


def with_entries(name: str, given: Matrix | None, labels: Sequence[str], held: FloatArray) -> FloatArray:
    """Return a matrix of the dry bodies: rows as given in the study, or those of the files with entries as given.

    Raises `ConfigError` if rows are not as many as degrees of freedom, or an entry is of none.
    """
    if given is None:
        return held
    if not isinstance(given, dict):
        rows = [len(row) for row in given]
        if rows != [len(labels)] * len(labels):
            raise ConfigError(
                f"body.{name}: received {len(rows)} rows of {', '.join(map(str, rows))} numbers; needs "
                f"{len(labels)} of {len(labels)}, for {', '.join(labels)}"
            )
        return np.array(given)
    matrix, bodies = held.copy(), of_bodies(labels)
    for key, value in given.items():
        if isinstance(value, tuple):
            place = _places(name, key, value, bodies)
            matrix[np.ix_(place, place)] = value
            continue
        words = key.split()
        if not 1 <= len(words) <= 2 or set(words) - set(labels):
            raise ConfigError(f"body.{name}: received {key!r}; needs one or two of {', '.join(labels)}")
        i, j = labels.index(words[0]), labels.index(words[-1])
        matrix[i, j] = matrix[j, i] = value
    return matrix


def _places(name: str, key: str, rows: Rows, bodies: Mapping[str, Sequence[int]]) -> Sequence[int]:
    """Places of a body's degrees of freedom, for which there must be as many rows."""
    if not key or key not in bodies:
        needed = f"a body, {' or '.join(filter(None, bodies))}" if all(bodies) else "a degree of freedom and a number"
        raise ConfigError(f"body.{name}: received rows of {key!r}; needs {needed}")
    count = len(bodies[key])
    if [len(row) for row in rows] != [count] * count:
        raise ConfigError(
            f"body.{name}.{key}: received {len(rows)} rows of {', '.join(str(len(row)) for row in rows)} numbers; "
            f"needs {count} of {count}"
        )
    return bodies[key]


def check_water(water: Water, ds: xr.Dataset) -> None:
    """Check that a study's water is that of its body's files.

    Raises `ConfigError` with a line for each value that is not.
    """
    own = {"density": "water_density", "depth": "water_depth", "gravity": "gravity"}
    other = {name: (float(getattr(water, name)), float(ds.attrs[attribute])) for name, attribute in own.items()}
    mistakes = [
        f"water.{name}: received {received:g}, needs {needed:.10g}, as the body's files have"
        for name, (received, needed) in other.items()
        if not math.isclose(received, needed, rel_tol=_SAME_WATER)
    ]
    if mistakes:
        raise ConfigError(mistakes[0], mistakes)


_NEXT_TO_NONE = 1e-6


def _moved_water(body: FlexibleBody) -> FloatArray:
    """Integral over the surface of the products of normal displacements, shape (dof, dof) [m^2]."""
    area, moved = body.triangles.area, body.triangles.moved.mean(axis=2)
    flux, size = np.einsum("itx,tx->it", moved, area), np.linalg.norm(area, axis=1)
    there = size > 0
    return np.asarray(flux[:, there] / size[there] @ flux[:, there].T)


def dry_database(body: FlexibleBody, file: BodyFile) -> xr.Dataset:
    """Return what is known of a body before anything is solved: its degrees of freedom, still water, band, directions.

    Added mass at infinite frequency counts as next to none: what a displacement has no mass of its own for, water has.
    """
    labels = list(body.labels)
    matrices = {"inertia_matrix": body.mass, "structural_stiffness": body.stiffness}
    matrices["hydrostatic_stiffness"] = hydrostatic_stiffness(body, file.water.density, file.water.gravity)
    matrices["added_mass_inf"] = _NEXT_TO_NONE * file.water.density * body.size * _moved_water(body)
    coords = {"omega": list(file.omega), "wave_direction": np.deg2rad(file.wave_direction)}
    known = {name: (PAIR, matrix) for name, matrix in matrices.items() if matrix is not None}
    stated = {"water_density": file.water.density, volume_of(""): body.volume}
    return xr.Dataset(known, {**coords, **dict.fromkeys(PAIR, labels)}, stated)
