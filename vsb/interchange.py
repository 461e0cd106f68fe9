"""Exchange of hydro databases: WAMIT's numeric output files, and BEMIO's .h5 file, which WEC-Sim reads.

Both formats know six rigid modes and generalized ones from number 7 on: rigid heave is mode 3, the shell modes are 7,
8, ... in the order of the database. Databases of axisymmetric motions hold no other rigid modes: WAMIT's files leave
them out, the .h5 file, whose arrays are full, holds zeros for them and is meant for a body held to heave.

Phasors are Re(X e^{-i omega t}) here (C1) and Re(X e^{+i omega t}) in both formats, phases relative to the elevation at
the axis and positive where the force leads. X is conjugated on the way out and in; nothing else changes sign.

WAMIT divides by density rho, gravity g, ULEN = L and wave amplitude a: A/(rho L^3), B/(rho L^3 omega), X/(rho g a L^2),
C/(rho g L^2) for translations; an angle adds one power of L for each index it takes. Shell modes count as translations:
their amplitudes are metres, their shapes dimensionless (C5). BEMIO's numbers are the same with L = 1.
"""

import json
import math
import os
from collections.abc import Collection, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from vsb.database import load_database
from vsb.errors import DatabaseError
from vsb.kernel import DampingSpectrum
from vsb.units import ATTRS, ComplexArray, FloatArray, check_finite, described, write_text

HEAVE, GENERALIZED = 3, 7  # numbers of rigid heave and of the first generalized mode
FORMATS = ("wamit", "bemio")
_WATER = ("water_density", "gravity", "water_depth")
_FORCES = {"excitation_force": ".3", "Froude_Krylov_force": ".3fk", "diffraction_force": ".3sc"}
_FOLDERS = {"excitation_force": "", "Froude_Krylov_force": "froude-krylov/", "diffraction_force": "scattering/"}
_WAVES, _BODY, _HYDRO = "/simulation_parameters/", "/body1/properties/", "/body1/hydro_coeffs/"
_IMPULSE = f"{_HYDRO}radiation_damping/impulse_response_fun/"
_MATRICES = {  # dataset of the .h5 file: variable, what it is divided by
    f"{_HYDRO}added_mass/all": ("added_mass", "rho"),
    f"{_HYDRO}added_mass/inf_freq": ("added_mass_inf", "rho"),
    f"{_HYDRO}radiation_damping/all": ("radiation_damping", "rho*w"),
    f"{_HYDRO}linear_restoring_stiffness": ("hydrostatic_stiffness", "rho*g"),
    f"{_BODY}mass": ("inertia_matrix", "1"),
    f"{_BODY}stiffness": ("structural_stiffness", "1"),
}
_UNITS = "g=m/s^2 rho=kg/m^3 T=s w=rad/s wave_dir=deg disp_vol=m^3 cg=m cb=m mass=kg damping=kg/s stiffness=N/m t=s"
_UNITS += " all=m^3 inf_freq=m^3 K=m^3/s^2 linear_restoring_stiffness=m^2 re=m^2 im=m^2 mag=m^2 phase=rad water_depth=m"
_Table = dict[tuple[float, ...], list[float]]


def export(
    database_path: str | Path, folder: str | Path, name: str, formats: Collection[str] = FORMATS, length: float = 1.0
) -> list[Path]:
    """Write a stored database for other codes and return the files written; none is begun unless all can be made.

    They are FOLDER/NAME.1, .3, .3fk, .3sc and .hst of format `wamit` with ULEN = length [m] (see `wamit_texts`) and
    FOLDER/NAME.h5 of format `bemio` (see `bemio_entries`).
    """
    if not formats or set(formats) - set(FORMATS):
        raise DatabaseError(f"formats: received {list(formats)}, needs wamit, bemio or both.")
    ds, source = load_database(database_path, Path(database_path).stem), str(database_path)
    texts = wamit_texts(ds, source, length) if "wamit" in formats else {}
    entries = bemio_entries(ds, source) if "bemio" in formats else {}
    for extension, text in texts.items():
        write_text(Path(folder) / f"{name}{extension}", text)
    if entries:
        write_h5(entries, Path(folder) / f"{name}.h5")
    return [Path(folder) / f"{name}{extension}" for extension in [*texts, *[".h5"] * bool(entries)]]


def mode_numbers(labels: Sequence[str]) -> list[int]:
    """Return the numbers of degrees of freedom: 3 for Heave, which must come first, then 7, 8, ..."""
    if not labels or labels[0] != "Heave" or len(set(labels)) < len(labels):
        raise DatabaseError(f"degrees of freedom {list(labels)}: needs Heave first, then each mode once.")
    return [HEAVE, *range(GENERALIZED, GENERALIZED + len(labels) - 1)]


def _scales(density: float, gravity: float, length: float) -> tuple[float, float]:
    """Return rho L^3 [kg], of added mass and damping, and rho g L^2 [N/m], of excitation and hydrostatic stiffness."""
    for name, value in {"density": density, "gravity": gravity, "length": length}.items():
        if not (math.isfinite(value) and value > 0):
            raise DatabaseError(f"{name}: received {value!r}, needs a positive number.")
    return density * length**3, density * gravity * length**2


def _checked(ds: xr.Dataset, source: str, needed: Sequence[str] = ()) -> xr.Dataset:
    """The dataset with dimensions in order, after checking that it holds the variables or facts needed, and no NaN."""
    if missing := [name for name in (*_WATER, *needed) if name not in ds and name not in ds.attrs]:
        raise DatabaseError(f"{source}: holds no {', '.join(missing)}; needs a complete hydro database.")
    check_finite(ds, source)
    if not (np.isfinite(omega := ds.omega.values).all() and omega[0] >= 0 and np.all(np.diff(omega) > 0)):
        raise DatabaseError(f"{source}: frequencies {omega} rad/s; needs finite, ascending ones, none negative.")
    return described(ds)


def wamit_texts(ds: xr.Dataset, source: str, length: float = 1.0) -> dict[str, str]:
    """Return the texts of WAMIT's numeric output files by extension, numbers to seven digits.

    `.1` holds PER I J A B, without B for PER = -1 (zero frequency, if the database has omega = 0) and for PER = 0
    (infinite frequency); `.3` PER BETA I MOD PHASE RE IM, angles in degrees; its parts `.3fk` and `.3sc` likewise;
    `.hst` I J C. The header states ULEN = length [m], the water and the modes, which WAMIT keeps in other files. Errors
    name the source.
    """
    ds = _checked(ds, source, ("added_mass", "radiation_damping", "excitation_force", "hydrostatic_stiffness"))
    labels = [str(label) for label in ds.influenced_dof.values]
    density, gravity, depth = (float(ds.attrs[name]) for name in _WATER)
    modes, (mass, force) = mode_numbers(labels), _scales(density, gravity, length)
    parts = {".1": _radiation_lines(ds, source, modes, mass)}
    parts |= {extension: _force_lines(ds[name] / force, modes) for name, extension in _FORCES.items() if name in ds}
    parts[".hst"] = _pair_lines("", modes, ds.hydrostatic_stiffness.values / force)
    names = " ".join(f"{mode}={label}" for mode, label in zip(modes, labels, strict=True))
    head = f" WAMIT's form: ULEN {length:g} density {density:g} gravity {gravity:g} depth {depth:g} modes {names}\n"
    return {extension: head + "".join(lines) for extension, lines in parts.items()}


def _pair_lines(start: str, modes: list[int], *matrices: FloatArray) -> list[str]:
    """One line for every pair of modes: the start, I, J, and the entry of each matrix."""
    return [
        f"{start}{i:6d}{j:6d}" + "".join(f" {matrix[a, b]:13.6E}" for matrix in matrices) + "\n"
        for (a, i), (b, j) in product(enumerate(modes), enumerate(modes))
    ]


def _radiation_lines(ds: xr.Dataset, source: str, modes: list[int], mass: float) -> list[str]:
    """Lines of the .1 file: zero frequency, infinite frequency, then periods ascending."""
    omega, a, b = ds.omega.values, ds.added_mass.values / mass, ds.radiation_damping.values / mass
    lines = _pair_lines(f"{-1:14.6E}", modes, a[0]) if omega[0] == 0 else []
    if "added_mass_inf" in ds:
        lines += _pair_lines(f"{0:14.6E}", modes, ds.added_mass_inf.values / mass)
    starts = {f"{2 * np.pi / w:14.6E}": i for i, w in reversed(list(enumerate(omega))) if w > 0}
    if len(starts) < np.count_nonzero(omega):
        raise DatabaseError(f"{source}: periods equal to seven digits; WAMIT's files need frequencies further apart.")
    for start, i in starts.items():
        lines += _pair_lines(start, modes, a[i], b[i] / omega[i])
    return lines


def _force_lines(force: xr.DataArray, modes: list[int]) -> list[str]:
    """Lines of a .3 file, periods ascending; there is no wave of zero frequency."""
    waves = [(i, 2 * np.pi / w) for i, w in reversed(list(enumerate(force.omega.values))) if w > 0]
    headings, lines = np.degrees(force.wave_direction.values), []
    for (i, period), (j, heading), (m, mode) in product(waves, enumerate(headings), enumerate(modes)):
        x = complex(np.conj(force.values[i, j, m]))
        polar = f"{abs(x):13.6E} {math.degrees(math.atan2(x.imag, x.real)):13.6E}"
        lines.append(f"{period:14.6E} {heading:13.6E}{mode:6d} {polar} {x.real:13.6E} {x.imag:13.6E}\n")
    return lines


def import_wamit(
    folder: str | Path,
    name: str,
    *,
    density: float,
    gravity: float,
    length: float = 1.0,
    depth: float = np.inf,
    labels: Sequence[str] | None = None,
) -> xr.Dataset:
    """Return a hydro database read from WAMIT's files NAME.1, NAME.3, NAME.hst and, if there, NAME.3fk and NAME.3sc.

    Parameters
    ----------
    folder, name : path, str
    density, gravity, length, depth : float
        Of the WAMIT run (rho, GRAV, ULEN, HBOT); they are in its control files, not in these.
    labels : sequence of str, optional
        Names of the modes, Heave first; default Heave, Mode7, Mode8, ...

    Notes
    -----
    The files are of one body: modes from 7 on are its generalized ones. Pairs that no period lists are zero: WAMIT
    leaves out what symmetry makes zero. Rigid modes other than heave are left out, that is held fixed, and so is zero
    frequency, where models need no data; `history` says so.
    """
    (mass, force), path = _scales(density, gravity, length), str(Path(folder) / name)
    table = _table(f"{path}.1", (1, 2), (4, 5), "PER I J A, and B where PER > 0")
    found = sorted({int(mode) for key in table for mode in key[1:]})
    modes = [mode for mode in found if mode == HEAVE or mode >= GENERALIZED]
    names = list(labels or ["Heave", *(f"Mode{mode}" for mode in modes[1:])])
    if HEAVE not in modes or len(mode_numbers(names)) != len(modes):
        raise DatabaseError(f"{path}.1: holds modes {found}; needs mode 3, and from 7 on as many as labels {names}.")
    periods = sorted({key[0] for key in table if key[0] >= 0}, reverse=True)
    waves = [period for period in periods if period > 0]
    unlisted = {*product(modes, modes)} - {key[1:] for key in table}
    zeros = {(period, *pair): [0.0, 0.0] for period in periods for pair in unlisted}
    entries = {key: [*row, 0.0][:2] for key, row in table.items()} | zeros
    a, b = np.moveaxis(mass * _values(f"{path}.1", entries, periods, modes, modes), -1, 0)
    omega = 2 * np.pi / np.array(waves)
    variables = {"added_mass": a[: len(waves)], "radiation_damping": b[: len(waves)] * omega[:, None, None]}
    if len(periods) > len(waves):
        variables["added_mass_inf"] = a[-1]
    stiffness = _table(f"{path}.hst", (0, 1), (3,), "I J C")
    variables["hydrostatic_stiffness"] = force * _values(f"{path}.hst", stiffness, modes, modes)[..., 0]
    headings, forces = _read_forces(path, waves, modes)
    variables |= {key: force * x for key, x in forces.items()}
    left_out = [*(f"mode {m}" for m in found if m not in modes), *["zero frequency"] * any(k[0] < 0 for k in table)]
    history = f"read from WAMIT's files {name}" + (f"; left out: {', '.join(left_out)}" if left_out else "")
    attrs = dict(zip(_WATER, (density, gravity, str(depth)), strict=True), source="WAMIT", history=history)
    return _database(path, (names, omega, headings), variables, attrs)


def _database(source: str, axes: tuple[Any, Any, Any], variables: dict[str, Any], attrs: dict[str, Any]) -> xr.Dataset:
    """Arrays over labels, frequencies and headings [deg] as a hydro database: units on everything, no NaN."""
    labels, omega, headings = axes
    dofs = dict.fromkeys(("influenced_dof", "radiating_dof"), labels)
    data = {name: (ATTRS[name].dims, values) for name, values in variables.items()}
    return _checked(xr.Dataset(data, {"omega": omega, "wave_direction": np.radians(headings), **dofs}, attrs), source)


def _table(path: str, modes: tuple[int, ...], counts: tuple[int, ...], columns: str) -> _Table:
    """Values of a file's lines by their first columns, up to the last that is a mode number; line 1 may be a header."""
    try:
        lines = Path(path).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError as error:
        raise DatabaseError(f"{path}: cannot be read ({error.strerror}); needs lines {columns}.") from None
    table: _Table = {}
    for number, line in enumerate(lines, 1):
        try:
            row = [float(word.upper().replace("D", "E")) for word in line.split()]
        except ValueError:
            row = [] if number == 1 else [math.nan]
        key = tuple(row[: modes[-1] + 1])
        if row and (wrong := "repeats an earlier line" if key in table else _problem(row, modes, counts)):
            raise DatabaseError(f"{path}, line {number}: {line.strip()!r} {wrong}; needs numbers {columns}.")
        if row:
            table[key] = row[len(key) :]
    if not any(len(key) < 3 or key[0] > 0 for key in table):
        raise DatabaseError(f"{path}: holds no data; needs lines {columns}.")
    return table


def _problem(row: list[float], modes: tuple[int, ...], counts: tuple[int, ...]) -> str:
    """What is wrong with a line; phases are not read: WAMIT's are arbitrary where symmetry makes forces zero."""
    if len(row) not in counts or not all(map(math.isfinite, row)):
        return f"is not of {' or '.join(map(str, counts))} finite numbers"
    if any(row[k] % 1 or row[k] < 1 for k in modes):
        return "has mode numbers that are not whole and from 1"
    if len(row) == 4 and row[0] > 0:
        return "has no damping"
    wrong = len(row) == 7 and abs(math.hypot(*row[5:]) - row[3]) > 1e-3 * abs(row[3])
    return "has a modulus that contradicts its parts" if wrong else ""


def _values(path: str, table: _Table, *keys: Sequence[float]) -> FloatArray:
    """Array over all combinations of keys, the values of a line last."""
    if missing := [key for key in product(*keys) if key not in table]:
        raise DatabaseError(f"{path}: no line starts with {missing[0]}; needs all periods, headings and modes.")
    return np.array([table[key] for key in product(*keys)]).reshape(*map(len, keys), -1)


def _read_forces(path: str, periods: list[float], modes: list[int]) -> tuple[list[float], dict[str, ComplexArray]]:
    """Headings [deg] and phasors (C1), shape (period, heading, mode); periods may differ from .1 in the last digit."""
    forces: dict[str, ComplexArray] = {}
    headings: list[float] = []
    for name, file in ((name, f"{path}{extension}") for name, extension in _FORCES.items()):
        if not forces or Path(file).is_file():
            table = _table(file, (2,), (7,), "PER BETA I MOD PHASE RE IM")
            headings = headings or sorted({key[1] for key in table})
            given = np.array([key[0] for key in table])
            nearest = np.array(periods)[np.abs(given[:, None] - periods).argmin(axis=1)]
            near = {(period, *key[1:]): row for period, (key, row) in zip(nearest, table.items(), strict=True)}
            if len(near) < len(table) or np.any(np.abs(nearest - given) > 1e-5 * nearest):
                raise DatabaseError(f"{file}: its periods are not those of {path}.1; needs the files of one run.")
            values = _values(file, near, periods, headings, modes)
            forces[name] = values[..., 2] - 1j * values[..., 3]
    return headings, forces


def bemio_entries(ds: xr.Dataset, source: str) -> dict[str, Any]:
    """Return the datasets of BEMIO's .h5 file by path, dimensions in the order of HDF5, which MATLAB shows reversed.

    Notes
    -----
    Paths, dimensions and normalization (`scaled` = 0: A/rho, B/(rho omega), X/(rho g), C/(rho g), K/rho) are those of
    WEC-Sim's writeBEMIOH5. `mass`, `damping` (Rayleigh's) and `stiffness` (structure, prestress and gas) are
    dimensional; as WEC-Sim reads their block of generalized modes only, a database in which they couple heave to a mode
    is refused. The displaced volume is mass/rho. The centre of gravity is that of the sphere, of buoyancy that of its
    wet part undeformed; a body held to heave feels neither. The excitation's impulse response is left out.
    """
    needed = [name for name, _ in _MATRICES.values()]
    ds, damping = _dry(_checked(ds, source, ("excitation_force", *needed, "radius", "centre_height", "spec")), source)
    labels, omega, headings = (ds[name].values for name in ("influenced_dof", "omega", "wave_direction"))
    rho, g, depth, r, z = (float(ds.attrs[name]) for name in (*_WATER, "radius", "centre_height"))
    modes, time = mode_numbers(list(map(str, labels))), np.arange(1001) * 0.1
    if omega[0] == 0:
        raise DatabaseError(f"{source}: holds zero frequency; the .h5 file needs periods.")
    dof, volume = max(6, modes[-1]), ds.inertia_matrix.values[0, 0] / rho
    waves = {"scaled": 0, "g": g, "rho": rho, "T": 2 * np.pi / omega, "w": omega, "wave_dir": np.degrees(headings)}
    body = {"body_number": 1, "disp_vol": volume, "cg": [0, 0, z], "cb": [0, 0, z - 0.75 * (r + z) ** 2 / (2 * r + z)]}
    body |= {"dof": dof, "dof_start": 1, "dof_end": dof}
    lists = {f"{_WAVES}{key}": value for key, value in waves.items()} | {f"{_BODY}{k}": v for k, v in body.items()}
    entries: dict[str, Any] = {k: np.reshape(v, (-1, 1)) for k, v in (lists | {f"{_IMPULSE}t": time}).items()}
    entries |= {"/bem_data/code": "vsb", f"{_BODY}name": "buoy", f"{_BODY}modes": " ".join(labels)}
    entries[f"{_WAVES}water_depth"] = "infinite" if np.isinf(depth) else np.array([[depth]])
    spectrum = DampingSpectrum(omega, ds.radiation_damping.values)
    matrices = {f"{_BODY}damping": damping, f"{_IMPULSE}K": spectrum.kernel(time) / rho}
    matrices |= {place: ds[name].values / _divisor(by, rho, g, omega) for place, (name, by) in _MATRICES.items()}
    entries |= {place: _spread(value, modes, dof, 2) for place, value in matrices.items()}
    for name, folder in [item for item in _FOLDERS.items() if item[0] in ds]:
        x = np.conj(_spread(ds[name].values, modes, dof, 1)) / (rho * g)
        parts = {"re": x.real, "im": x.imag, "mag": np.abs(x), "phase": np.angle(x)}
        entries |= {f"{_HYDRO}excitation/{folder}{part}": value for part, value in parts.items()}
    return entries


def _dry(ds: xr.Dataset, source: str) -> tuple[xr.Dataset, FloatArray]:
    """The dataset with prestress and gas in its structural stiffness, and Rayleigh's damping; heave is uncoupled."""
    factors = json.loads(ds.attrs["spec"])["device"]["damping"]
    damping = factors["alpha"] * ds.inertia_matrix.values + factors["beta"] * ds.structural_stiffness.values
    damping[0, :] = damping[:, 0] = 0.0
    dry = sum(ds[name] for name in ("structural_stiffness", "prestress_stiffness", "gas_stiffness") if name in ds)
    ds = ds.assign(structural_stiffness=dry)
    for name in ("inertia_matrix", "structural_stiffness"):
        if np.abs(ds[name].values[0, 1:]).max(initial=0.0) > 1e-9 * np.abs(ds[name].values).max():
            raise DatabaseError(f"{source}: {name} couples heave and modes, which WEC-Sim drops; needs another basis.")
    return ds, damping


def _divisor(by: str, rho: float, g: float, omega: FloatArray) -> Any:
    """What a dataset of the .h5 file is divided by."""
    return {"rho": rho, "rho*w": rho * omega[:, None, None], "rho*g": rho * g, "1": 1.0}[by]


def _spread(values: Any, modes: list[int], dof: int, axes: int) -> Any:
    """Values over heave and modes, the last one or two axes, among all modes, zero for the others; other axes last."""
    full, index = np.zeros((*values.shape[:-axes], *[dof] * axes), values.dtype), np.array(modes) - 1
    full[(..., index[:, None], index) if axes == 2 else (..., index)] = values
    return full.T if axes == 1 else np.moveaxis(full, 0, -1) if full.ndim == 3 else full


def write_h5(entries: dict[str, Any], path: Path) -> None:
    """Write datasets by path to an HDF5 file, complete or not at all; netCDF adds their sizes to its root."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary, units = path.with_name(f".{path.name}.{os.getpid()}.tmp"), dict(u.split("=") for u in _UNITS.split())
    try:
        with netCDF4.Dataset(temporary, "w") as file:
            for place, values in entries.items():
                for size in {*np.shape(values)} - {dimension.size for dimension in file.dimensions.values()}:
                    file.createDimension(f"n{size}", size)
                kind: Any = str if isinstance(values, str) else "f8"
                dimensions = [f"n{size}" for size in np.shape(values)]
                variable = file.createVariable(place, kind, dimensions, zlib=np.size(values) > 10_000)
                variable[...] = values
                variable.units = units.get(place.rpartition("/")[2], "")
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def read_bemio(path: str | Path) -> xr.Dataset:
    """Return the hydro database of a BEMIO .h5 file of one body: heave and generalized modes, dimensional.

    Parts of the excitation with NaN, BEMIO's mark of what was not computed, are left out; `structural_stiffness` is all
    stiffness but the water's; labels are Heave, Mode7, ... where the file does not name them.
    """
    try:
        with netCDF4.Dataset(path) as file:
            file.set_auto_mask(False)
            return _from_bemio(_datasets(file), str(path))
    except (OSError, KeyError, ValueError, IndexError) as error:
        raise DatabaseError(f"{path}: cannot be read: {error}; needs BEMIO's .h5 file with all its datasets.") from None


def _datasets(group: Any) -> dict[str, Any]:
    """All datasets of a file by path."""
    found = {f"{group.path.rstrip('/')}/{name}": variable[...] for name, variable in group.variables.items()}
    return found | {place: value for child in group.groups.values() for place, value in _datasets(child).items()}


def _from_bemio(found: dict[str, Any], source: str) -> xr.Dataset:
    """The database in the datasets of an .h5 file."""
    rho, g, dof = (np.asarray(found[key]).item() for key in (f"{_WAVES}rho", f"{_WAVES}g", f"{_BODY}dof"))
    omega, headings, depth, scaled = (found[f"{_WAVES}{name}"] for name in ("w", "wave_dir", "water_depth", "scaled"))
    index = np.array([HEAVE, *range(GENERALIZED, int(dof) + 1)]) - 1
    labels = found.get(f"{_BODY}modes", "").split() or ["Heave", *(f"Mode{i + 1}" for i in index[1:])]
    variables = {}
    for place, (name, by) in _MATRICES.items():
        if place in found or place.startswith(_HYDRO):
            block = np.moveaxis(np.atleast_3d(found[place])[np.ix_(index, index)], -1, 0)
            value = block if "omega" in ATTRS[name].dims else block[0]
            variables[name] = value * (1.0 if np.all(scaled) else _divisor(by, rho, g, np.ravel(omega)))
    for name, folder in _FOLDERS.items():
        if not folder or f"{_HYDRO}excitation/{folder}re" in found:
            re, im = (found[f"{_HYDRO}excitation/{folder}{part}"][index] for part in ("re", "im"))
            if not folder or np.isfinite(re + im).all():
                variables[name] = (re - 1j * im).T * (1.0 if np.all(scaled) else rho * g)
    water = rho, g, "inf" if "inf" in str(depth) else str(np.asarray(depth).item())
    attrs = dict(zip(_WATER, water, strict=True), source="BEMIO", history=f"read from {Path(source).name}")
    return _database(source, (labels, np.ravel(omega), np.ravel(headings)), variables, attrs)
