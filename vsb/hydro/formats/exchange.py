"""Exchange of hydro databases with other codes: files out, and what can be said of numbers that came in."""

from collections.abc import Collection
from pathlib import Path

import numpy as np
import xarray as xr

from vsb.errors import ConfigError, DatabaseError
from vsb.hydro import quality
from vsb.hydro.database import Check, check_at_most, load_database
from vsb.hydro.dofs import RIGID
from vsb.hydro.formats.bemio import bemio_entries, write_h5
from vsb.hydro.formats.modes import WATER
from vsb.hydro.formats.wamit import wamit_texts
from vsb.tools.files import load, write_text
from vsb.waves.seas import group_velocity, wavenumber

FORMATS = ("wamit", "bemio")
LARGEST_HASKIND = 0.05
"""Difference of the damping from Haskind's, in terms of the largest damping of both motions."""
_UNSEEN = (
    "the only check that sees a wrong unit of length, density or column of periods: it needs wave directions in fine, "
    "equal steps all around, or one direction and --axisymmetric"
)


def export(
    database_path: str | Path,
    folder: str | Path,
    name: str,
    formats: Collection[str] = FORMATS,
    length: float = 1.0,
    expected_id: str | None = None,
) -> list[Path]:
    """Write a stored database for other codes and return the files written; none is begun unless all can be made.

    They are FOLDER/NAME.1, .3, .3fk, .3sc, .hst and .mmx of format `wamit` with ULEN = length [m] (see `wamit_texts`)
    and FOLDER/NAME.h5 of format `bemio` (see `bemio_entries`). With an `expected_id` it must be that database.
    """
    if not formats or set(formats) - set(FORMATS):
        raise DatabaseError(f"formats: received {list(formats)}, needs wamit, bemio or both.")
    attrs, source = load(database_path).attrs, str(database_path)
    if missing := {"spec_id", "separate_sweep"} - set(attrs):
        raise DatabaseError(f"{source}: holds no {', '.join(sorted(missing))}; needs a hydro database.")
    ds = load_database(database_path, expected_id or attrs["spec_id"])
    texts = wamit_texts(ds, source, length) if "wamit" in formats else {}
    entries = bemio_entries(ds, source) if "bemio" in formats else {}
    for extension, text in texts.items():
        write_text(Path(folder) / f"{name}{extension}", text)
    if entries:
        write_h5(entries, Path(folder) / f"{name}.h5")
    return [Path(folder) / f"{name}{extension}" for extension in [*texts, *[".h5"] * bool(entries)]]


def foreign_checks(ds: xr.Dataset, *, axisymmetric: bool = False) -> tuple[list[Check], str]:
    """Return the checks that a database of another code allows, and one line on what they cannot see, if anything.

    Damping follows from excitation (Haskind) by an integral over all wave directions, which one direction replaces if
    the body and all generalized modes are `axisymmetric`; damping of heave and these, one radiation channel, then also
    has rank one. Symmetry and sign of the damping see neither a wrong unit of length nor density nor a column of
    frequencies taken for periods.

    Raises
    ------
    ConfigError
        If the motions are said to be axisymmetric, and none can be.
    """
    radiating = np.einsum("wii->wi", ds.radiation_damping.values).any(axis=0)
    if not radiating.any():
        raise DatabaseError("radiation damping is zero for all motions; needs coefficients of waves.")
    wet = ds.isel(influenced_dof=radiating, radiating_dof=radiating)
    negative = quality.negative_damping(wet)
    checks = [
        _symmetry(ds),
        *_afloat(ds),
        check_at_most("positive_damping", negative, 0.01, "-", "no motion can draw energy from calm water"),
    ]
    rho, g, depth = (float(ds.attrs[name]) for name in WATER)
    if axisymmetric:
        ring = np.array([label == "Heave" or label not in RIGID for label in wet.influenced_dof.values])
        if not ring.any():
            raise ConfigError(f"--axisymmetric: received {', '.join(wet.influenced_dof.values)}; needs heave or modes.")
        wet = wet.isel(influenced_dof=ring, radiating_dof=ring)
        text = "axisymmetric motions radiate one ring wave"
        checks.append(check_at_most("rank_one", quality.second_channel(wet), 0.02, "-", text))
        value: float | None = quality.haskind_difference(wet, depth, rho, g)
    else:
        value = haskind_over_headings(wet, depth, rho, g)
    if value is None:
        return checks, f"not checked: haskind, {_UNSEEN}; received {ds.sizes['wave_direction']}"
    return [*checks, check_at_most("haskind", value, LARGEST_HASKIND, "-", "damping follows from excitation")], ""


def _symmetry(ds: xr.Dataset) -> Check:
    """Symmetry of the radiation impedance, in terms of the impedances of both motions."""
    omega = ds.omega.values[:, None, None]
    impedance = ds.radiation_damping.values + 1j * omega * ds.added_mass.values
    z = np.abs(np.einsum("wii->wi", impedance))
    pair = np.sqrt(z[:, :, None] * z[:, None, :])
    error = np.abs(impedance - impedance.transpose(0, 2, 1))
    worst = np.max(np.divide(error, pair, out=np.zeros_like(error), where=pair > 0))
    return check_at_most("symmetry", worst, 0.02, "-", "added mass and damping are symmetric matrices", doubt=True)


def _afloat(ds: xr.Dataset) -> list[Check]:
    """Mass in heave against the water displaced, if the file has both: a moored body may weigh less."""
    if "displaced_volume" not in ds.attrs or "inertia_matrix" not in ds or "Heave" not in ds.influenced_dof:
        return []
    mass = float(ds.inertia_matrix.sel(influenced_dof="Heave", radiating_dof="Heave"))
    error = abs(mass / (float(ds.attrs["water_density"]) * float(ds.attrs["displaced_volume"])) - 1)
    return [check_at_most("afloat", error, 0.01, "-", "mass in heave is that of the water displaced", doubt=True)]


def haskind_over_headings(ds: xr.Dataset, depth: float, density: float, gravity: float) -> float | None:
    """Return the largest difference of the damping from that of the excitation, or None if the headings are too few.

    Notes
    -----
    B = k/(8 pi rho g v_g) int X X^H d beta (Newman, Marine Hydrodynamics, ch. 6), by the trapezoidal rule, which is
    exact for Fourier series over beta that end below half the number of headings: of the power of each excitation the
    last two orders may have 2.5 %. Relative to the largest damping of both motions.
    """
    degrees, first = np.unique(np.round(np.degrees(ds.wave_direction.values) % 360, 3) % 360, return_index=True)
    n = len(degrees)
    if n < 6 or not np.allclose(np.diff([*degrees, degrees[0] + 360]), 360 / n, atol=0.01):
        return None
    factor = [wavenumber(w, depth, gravity) / group_velocity(w, depth, gravity) for w in ds.omega.values]
    root = np.sqrt(np.abs(np.einsum("wii->wi", ds.radiation_damping.values)).max(axis=0))
    x = ds.excitation_force.values[:, first, :] / root
    x = x * np.sqrt(np.array(factor) / (4 * density * gravity))[:, None, None]
    power = np.abs(np.fft.fft(x, axis=1) / n) ** 2
    last = np.abs(np.fft.fftfreq(n, 1 / n)) >= n // 2 - 1
    if np.any(power[:, last].sum(axis=1) > LARGEST_HASKIND / 2 * power.sum(axis=1).max(axis=0)):
        return None
    damping = np.einsum("whi,whj->wij", x, x.conj()).real / n
    return float(np.abs(damping - ds.radiation_damping.values / np.outer(root, root)).max())
