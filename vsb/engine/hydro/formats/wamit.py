"""WAMIT's numeric output files: written of one body, generalized modes included, read of one or several.

Phasors are Re(X e^{-i omega t}) here (C1) and Re(X e^{+i omega t}) in WAMIT, with phases relative to the elevation at
the origin, positive if the force leads. X is conjugated on writing and reading; nothing else changes sign.

WAMIT divides by density rho, gravity g, ULEN = L and wave amplitude a: A/(rho L^k), B/(rho L^k omega) and
C/(rho g L^(k-1)) with k = 3 between translations, 4 between a translation and a rotation, 5 between rotations;
X/(rho g a L^m) with m = 2 for translations, 3 for rotations (user manual, 3.1 to 3.3). Generalized modes count as
translations: their amplitudes are metres, their shapes dimensionless (C5). Mass, damping and stiffness of the dry body,
`.mmx`, are dimensional.
"""

import math
import re
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro.bodies.body_file import WAMIT
from vsb.engine.hydro.formats.common import (
    GENERALIZED,
    WATER,
    assembled,
    check_positive,
    checked,
    floating,
    is_floating,
    mode_labels,
    mode_numbers,
    rotation_centre,
    rotations,
    structure,
    volume_of,
    whole_lines,
)
from vsb.errors import DatabaseError
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.files import read_bounded

_FORCES = {"excitation_force": ".3", "Froude_Krylov_force": ".3fk", "diffraction_force": ".3sc"}
_HASKIND = ".2"  # the excitation by Haskind's relation
_LIMITS = {"added_mass_zero": -1.0, "added_mass_inf": 0.0}  # by the period that stands for the frequency
_DRY = ("inertia_matrix", "structural_damping_matrix", "structural_stiffness")  # columns of the .mmx file
_Table = dict[tuple[float, ...], list[float]]
_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[ED][-+]?\d+|[-+]\d{3}(?![\d.]))?"
_FIELDS = re.compile(rf"[-+]?{_NUMBER}(?:[-+]{_NUMBER})+|[-+]?{_NUMBER}")
"""Numbers of Fortran's fields, whose signs may follow the digits before without a space: 1.0E+00-2.0E+00."""
_RIGID = 6  # modes of every body, computed or not


class _Scales(NamedTuple):
    """Units WAMIT divides by."""

    mass: FloatArray  # of added mass and damping, (mode, mode) [kg]
    stiffness: FloatArray  # of hydrostatic stiffness, (mode, mode) [N/m]
    force: FloatArray  # of excitation, (mode,) [N/m]


def _scales(density: float, gravity: float, length: float, modes: Sequence[int]) -> _Scales:
    """Units of the coefficients of modes."""
    for (name, value), unit in zip(
        {"density": density, "gravity": gravity, "length": length}.items(), ("kg/m^3", "m/s^2", "m"), strict=True
    ):
        check_positive(name, value, unit)
    arm = length ** rotations(modes)
    pair = np.outer(arm, arm) * length**2
    return _Scales(density * length * pair, density * gravity * pair, density * gravity * length**2 * arm)


def wamit_texts(ds: xr.Dataset, source: str, length: float = 1.0) -> dict[str, str]:
    """Return the texts of WAMIT's numeric output files by extension, numbers to seven digits.

    `.1` holds PER I J A B, without B for PER = -1 (zero frequency, if the database has omega = 0) and for PER = 0
    (infinite frequency); `.3` PER BETA I MOD PHASE RE IM, angles in degrees; its parts `.3fk` and `.3sc` likewise;
    `.hst` I J C; `.mmx` I J MASS DAMP STIF of the dry body, if the database has its mass, stiffness, displaced volume
    and centres. The header states ULEN = length [m], the water, the centre of rotations and the modes, which WAMIT has
    in other files. Errors name the source.
    """
    ds = checked(ds, source, ("added_mass", "radiation_damping", "excitation_force", "hydrostatic_stiffness"))
    labels = [str(label) for label in ds.influenced_dof.values]
    density, gravity, depth = (float(ds.attrs[name]) for name in WATER)
    modes = mode_numbers(labels)
    mass, stiffness, force = _scales(density, gravity, length, modes)
    parts = {".1": _radiation_lines(ds, source, modes, mass)}
    parts |= {extension: _force_lines(ds[name] / force, modes) for name, extension in _FORCES.items() if name in ds}
    parts[".hst"] = _pair_lines("", modes, ds.hydrostatic_stiffness.values / stiffness)
    names = " ".join(f"{mode}={label}" for mode, label in sorted(zip(modes, labels, strict=True)))
    head = f" WAMIT's form: ULEN {length:g} density {density:g} gravity {gravity:g} depth {depth:g} "
    if rotations(modes).any() and (centre := rotation_centre(ds)) is not None:
        head += f"rotations about {' '.join(f'{x:g}' for x in centre)} "
    head += f"modes {names}\n"
    texts = {extension: head + "".join(lines) for extension, lines in parts.items()}
    if (dry := structure(ds, source)) is not None and is_floating(ds):
        texts[".mmx"] = head + _dry_head(ds, source, length) + "".join(_pair_lines("", modes, *dry))
    return texts


def _pair_lines(start: str, modes: list[int], *matrices: FloatArray) -> list[str]:
    """One line for every pair of modes: the start, I, J, and the entry of each matrix."""
    return [
        f"{start}{i:6d}{j:6d}" + "".join(f" {matrix[a, b]:13.6E}" for matrix in matrices) + "\n"
        for (i, a), (j, b) in product(_ascending(modes), _ascending(modes))
    ]


def _ascending(modes: list[int]) -> list[tuple[int, int]]:
    """Numbers of modes, ascending, with their places."""
    return sorted((mode, place) for place, mode in enumerate(modes))


def _radiation_lines(ds: xr.Dataset, source: str, modes: list[int], mass: FloatArray) -> list[str]:
    """Lines of the .1 file: zero frequency, infinite frequency, then periods ascending."""
    omega, a, b = ds.omega.values, ds.added_mass.values / mass, ds.radiation_damping.values / mass
    lines = _pair_lines(f"{-1:14.6E}", modes, a[0]) if omega[0] == 0 else []
    for name, period in _LIMITS.items():
        if name in ds and (period == 0 or not lines):
            lines += _pair_lines(f"{period:14.6E}", modes, ds[name].values / mass)
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
    for (i, period), (j, heading), (mode, m) in product(waves, enumerate(headings), _ascending(modes)):
        x = complex(np.conj(force.values[i, j, m]))
        polar = f"{abs(x):13.6E} {math.degrees(math.atan2(x.imag, x.real)):13.6E}"
        lines.append(f"{period:14.6E} {heading:13.6E}{mode:6d} {polar} {x.real:13.6E} {x.imag:13.6E}\n")
    return lines


def _dry_head(ds: xr.Dataset, source: str, length: float) -> str:
    """Head of the .mmx file, in WAMIT's words and spelling."""
    volume, buoyancy, mass = floating(ds, source)
    xyz = "{:14.6E}{:14.6E}{:14.6E}"
    return (
        f"\n Gravity:{float(ds.attrs['gravity']):14.6E}  Length scale:{length:14.6E}\n"
        f"\n NBODY =     1       IALTFRC = 2\n\n WAMIT  Ouputs for body N =     1    IALTFRCN = 2\n"
        f" Volumes (VOLX,VOLY,VOLZ):      {xyz.format(volume, volume, volume)}\n"
        f" Center of Buoyancy (Xb,Yb,Zb): {xyz.format(*buoyancy)}\n"
        f" Center of Gravity:  (Xg,Yg,Zg) {xyz.format(*mass)}\n\n External force matrices:\n"
        "     I     J      MASS(I,J)      DAMP(I,C)      STIF(I,J)\n"
    )


def import_wamit(
    folder: str | Path,
    name: str,
    *,
    density: float,
    gravity: float,
    length: float = 1.0,
    depth: float = np.inf,
    labels: Sequence[str] | None = None,
    bodies: int | None = None,
    modes: Sequence[int] | None = None,
) -> xr.Dataset:
    """Return a hydro database read from WAMIT's files NAME.1, .3 (or .2), .hst and, if there, .3fk, .3sc and .mmx.

    Parameters
    ----------
    density, gravity, length, depth : float
        Of the WAMIT run (rho, GRAV, ULEN, HBOT), which are in its control files only.
    labels : sequence of str, optional
        Names of the modes of one body, ascending; default those in the first line, where `wamit_texts` writes them, or
        Surge, ..., Yaw, Mode7, Mode8, ...
    bodies : int, optional
        Number of bodies (NBODY).
    modes : sequence of int, optional
        Number of modes of each body, 6 + NEWMDS, whether they were computed or not.

    Notes
    -----
    Only `.mmx` states how many bodies there are; beyond mode 6 it must be there, or `bodies` or `modes` given, and
    where a body of several has generalized modes, `modes`: they are never guessed. Labels of several bodies are
    body1__Surge, ..., body1__Mode7, ..., body2__Surge, .... All modes that `.1` lists are kept. Pairs that no period
    lists are zero: WAMIT leaves out what symmetry makes zero. Excitation is that of `.3`, without it that of `.2`.
    Damping and stiffness in `.mmx` are those of WAMIT's "external force matrices" (IALTFRC = 2); a file with a mass
    matrix alone (IALTFRC = 1) gives volumes, and of one body centres, only.
    """
    path = str(Path(folder) / name)
    if Path(name).suffix in WAMIT and not Path(f"{path}.1").is_file():
        raise DatabaseError(f"{name}: is one of WAMIT's files; needs the name of all of them, {Path(name).stem}.")
    table = _table(f"{path}.1", _lines(f"{path}.1", "PER I J A B"), (1, 2), (4, 5), "PER I J A, and B where PER > 0")
    failed = _failed(table)
    table = {key: row for key, row in table.items() if key[0] not in failed}
    if not table:
        raise DatabaseError(f"{path}.1: all coefficients are NaN at every period; needs some that were solved.")
    numbers = sorted({int(mode) for key in table for mode in key[1:]})
    dry = _read_dry(f"{path}.mmx", numbers, gravity, length) if Path(f"{path}.mmx").is_file() else _Dry(None, {}, {})
    counts = _modes_of_bodies(path, numbers, dry.bodies, bodies, modes)
    names, kinds = _named(path, numbers, counts, labels)
    mass, stiffness, force = _scales(density, gravity, length, kinds)
    check_positive("depth", depth, "m", infinite=True)
    waves, radiated = _radiation(f"{path}.1", table, numbers)
    variables: dict[str, Any] = {key: mass * values for key, values in radiated.items()}
    restoring = _table(f"{path}.hst", _lines(f"{path}.hst", "I J C"), (0, 1), (3,), "I J C")
    springs = _values(f"{path}.hst", restoring, numbers, numbers)[..., 0]
    variables["hydrostatic_stiffness"] = stiffness * springs
    headings, forces = _read_forces(path, waves, numbers, failed)
    variables |= {key: force * x for key, x in forces.items()}
    dropped = "added_mass_zero" not in radiated and any(key[0] < 0 for key in table)
    stated = re.search(r"rotations about (\S+) (\S+) (\S+) modes", _lines(f"{path}.1", "")[0])
    centre = [float(x) for x in stated.groups()] if stated else [0.0, 0.0, 0.0]  # WAMIT's: the body's own origin
    history = f"read from WAMIT's files {name}"
    if len(counts) > 1:
        ends = np.cumsum(counts).tolist()
        spans = [
            f"body{k} modes {end - size + 1} to {end}"
            for k, (end, size) in enumerate(zip(ends, counts, strict=True), 1)
        ]
        history += f"; {', '.join(spans)}"
    if not Path(f"{path}.3").is_file():
        history += "; excitation of .2, by Haskind's relation, as there is no .3"
    if failed:
        history += (
            f"; left out: {len(failed)} periods, from {min(failed):g} to {max(failed):g} s, of which A and B are NaN"
        )
    history += "; left out: zero frequency, not of all pairs" * dropped
    attrs = dict(zip(WATER, (density, gravity, str(depth)), strict=True), source="WAMIT", history=history, **dry.facts)
    attrs |= {"rotation_centre": centre} if len(counts) == 1 else {}
    return assembled(path, (names, 2 * np.pi / np.array(waves), headings), variables | dry.matrices, attrs)


def _modes_of_bodies(
    path: str, numbers: list[int], stated: int | None, bodies: int | None, modes: Sequence[int] | None
) -> list[int]:
    """Modes of each body, of which `numbers` were computed, from what `.mmx` states and what is given."""
    last, ours = numbers[-1], " modes " in _lines(f"{path}.1", "")[0]
    where = "--bodies and --modes, in a study body.bodies and body.modes"
    if modes and len(modes) != (bodies or len(modes)):
        raise DatabaseError(f"{path}.1: received {bodies} bodies and modes of {len(modes)}; needs modes of each body.")
    given = len(modes) if modes else bodies
    if stated and given and stated != given:
        raise DatabaseError(f"{path}.mmx: is of {stated} bodies, received {given}; needs the files of one run.")
    count = given or stated or (1 if last <= _RIGID or ours else None)
    if count is None:
        raise DatabaseError(
            f"{path}.1: holds modes up to {last}, and without .mmx nothing says of how many bodies; needs the number "
            f"of bodies, 1 if all further modes are generalized ones of one, and of the modes of each ({where})."
        )
    if not modes and count > 1 and last > _RIGID * count:
        raise DatabaseError(
            f"{path}.1: holds modes up to {last} of {count} bodies, which have more than six each; needs the number of "
            f"modes of each, such as {','.join([str(last - _RIGID * (count - 1)), *['6'] * (count - 1)])} ({where})."
        )
    counts = list(modes or ([last] if count == 1 else [_RIGID] * count))
    if modes and (min(counts) < _RIGID or not sum(counts[:-1]) < last <= sum(counts)):
        raise DatabaseError(
            f"{path}.1: holds modes up to {last}; received modes {','.join(map(str, counts))}; needs the number of "
            f"modes of each body, six rigid ones among them, computed or not ({where})."
        )
    return counts


def _named(path: str, modes: list[int], counts: list[int], labels: Sequence[str] | None) -> tuple[list[str], list[int]]:
    """Names of the modes, and their numbers among those of their body."""
    if len(counts) > 1:
        if labels:
            raise DatabaseError(f"{path}.1: is of {len(counts)} bodies; needs no labels, which are of one body.")
        ends = np.cumsum(counts)
        of = np.searchsorted(ends, modes)
        numbers = [mode - int(ends[k]) + counts[k] for mode, k in zip(modes, of, strict=True)]
        return [f"body{k + 1}__{name}" for k, name in zip(of, mode_labels(numbers), strict=True)], numbers
    stated = {
        int(n): label for n, label in re.findall(r" (\d+)=(\w+)", _lines(f"{path}.1", "")[0].partition("modes")[2])
    }
    names = list(labels or ([stated[m] for m in modes] if {*modes} <= {*stated} else mode_labels(modes)))
    if [min(n, GENERALIZED) for n in mode_numbers(names)] != [min(mode, GENERALIZED) for mode in modes]:
        raise DatabaseError(f"{path}.1: holds modes {modes}; needs as many labels of these, received {names}.")
    return names, modes


def _radiation(path: str, table: _Table, modes: list[int]) -> tuple[list[float], dict[str, FloatArray]]:
    """Periods descending, and added mass, damping, and added mass at both limits as the .1 file has them."""
    periods = sorted({key[0] for key in table}, reverse=True)
    waves = [period for period in periods if period > 0]
    if not waves:
        raise DatabaseError(f"{path}: holds no period > 0; needs lines PER I J A B of waves.")
    if unknown := {*periods[len(waves) :]} - {*_LIMITS.values()}:
        raise DatabaseError(f"{path}: holds period {min(unknown):g}; needs periods > 0, 0 or -1.")
    unlisted = {*product(modes, modes)} - {key[1:] for key in table}
    zeros = {(period, *pair): [0.0, 0.0] for period in periods for pair in unlisted}
    entries = {key: [*row, 0.0][:2] for key, row in table.items()} | zeros
    if any((periods[-1], *pair) not in entries for pair in product(modes, modes)) and periods[-1] < 0:
        periods.pop()  # no model needs zero frequency
    a, b = np.moveaxis(_values(path, entries, periods, modes, modes), -1, 0)
    omega = 2 * np.pi / np.array(waves)
    found = {"added_mass": a[: len(waves)], "radiation_damping": b[: len(waves)] * omega[:, None, None]}
    return waves, found | {name: a[periods.index(limit)] for name, limit in _LIMITS.items() if limit in periods}


def _lines(path: str, columns: str) -> list[str]:
    """Lines of a file."""
    try:
        return whole_lines(path, read_bounded(path).decode(errors="replace"))
    except OSError as error:
        if Path(path).with_name("Nemoh.cal").is_file():
            raise DatabaseError(f"{Path(path).parent}: is a folder of NEMOH; use vsb import-nemoh") from None
        other = ", nor is there a .2" if path.endswith(".3") else ""
        raise DatabaseError(f"{path}: cannot be read ({error.strerror}){other}; needs lines {columns}.") from None


def _table(path: str, lines: list[str], modes: tuple[int, ...], counts: tuple[int, ...], columns: str) -> _Table:
    """Values of lines by their first columns, up to the last that is a mode number; line 1 may be a header."""
    table: _Table = {}
    for number, line in enumerate(lines, 1):
        try:
            row = _numbers(line)
        except ValueError:
            row = [] if number == 1 else [math.nan]
        key = tuple(row[: modes[-1] + 1])
        if row and (wrong := "repeats an earlier line" if key in table else _problem(row, modes, counts)):
            raise DatabaseError(f"{path}, line {number}: {line.strip()!r} {wrong}; needs numbers {columns}.")
        if row:
            table[key] = row[len(key) :]
    if not table:
        raise DatabaseError(f"{path}: holds no data; needs lines {columns}.")
    return table


def _numbers(line: str) -> list[float]:
    """Numbers of a line as Fortran writes them: D for E, fields that touch, 7.9-116 for 7.9E-116; else ValueError.

    Only a sign can end a field that touches the next: digits alone could be cut in several ways.
    """
    found = []
    for word in line.upper().split():
        try:
            found.append(float(word.replace("D", "E")))
        except ValueError:
            if not _FIELDS.fullmatch(word):
                raise
            for number in re.findall(rf"[-+]?{_NUMBER}", word):
                exponent = re.sub(r"(?<=[\d.])(?=[-+]\d{3}$)", "E", number) if not {*"ED"} & {*number} else number
                found.append(float(exponent.replace("D", "E")))
    return found


def _problem(row: list[float], modes: tuple[int, ...], counts: tuple[int, ...]) -> str:
    """Error of a line; phases are not read: WAMIT's are arbitrary where symmetry makes forces zero."""
    known = row[: modes[-1] + 1] if len(row) in (4, 5, 7) and modes[0] > 0 else row  # coefficients of waves may be NaN
    if len(row) not in counts or any(map(math.isinf, row)) or any(map(math.isnan, known)):
        return f"is not of {' or '.join(map(str, counts))} finite numbers"
    if any(row[k] % 1 or row[k] < 1 for k in modes):
        return "has mode numbers that are not whole and from 1"
    if len(row) == 4 and row[0] > 0:
        return "has no damping"
    wrong = len(row) == 7 and abs(math.hypot(*row[5:]) - row[3]) > 1e-3 * abs(row[3])
    return "has a modulus that contradicts its parts" if wrong else ""


def _failed(table: _Table) -> set[float]:
    """Periods at which all coefficients are NaN, the mark of a solution that failed."""
    known = {key[0] for key, row in table.items() if not all(map(math.isnan, row))}
    return {key[0] for key in table} - known


def _values(path: str, table: _Table, *keys: Sequence[float]) -> FloatArray:
    """Array over all combinations of keys, the values of a line last."""
    if missing := [key for key in product(*keys) if key not in table]:
        raise DatabaseError(f"{path}: no line starts with {missing[0]}; needs all periods, headings and modes.")
    if nan := [key for key in product(*keys) if not all(map(math.isfinite, table[key]))]:
        raise DatabaseError(f"{path}: the line that starts with {nan[0]} holds NaN; needs numbers of every other mode.")
    return np.array([table[key] for key in product(*keys)]).reshape(*map(len, keys), -1)


def _read_forces(
    path: str, periods: list[float], modes: list[int], failed: set[float]
) -> tuple[list[float], dict[str, ComplexArray]]:
    """Headings [deg] and phasors (C1), shape (period, heading, mode); periods may differ from .1 in the last digit."""
    forces: dict[str, ComplexArray] = {}
    headings: list[float] = []
    endings = dict(_FORCES)
    if not Path(f"{path}.3").is_file() and Path(f"{path}{_HASKIND}").is_file():
        endings["excitation_force"] = _HASKIND
    for name, file in ((name, f"{path}{extension}") for name, extension in endings.items()):
        if not forces or Path(file).is_file():
            columns = "PER BETA I MOD PHASE RE IM"
            table = _table(file, _lines(file, columns), (2,), (7,), columns)
            table = {
                key: row for key, row in table.items() if not any(math.isclose(key[0], f, rel_tol=1e-5) for f in failed)
            }
            headings = headings or sorted({key[1] for key in table})
            given = np.array([key[0] for key in table])
            nearest = np.array(periods)[np.abs(given[:, None] - periods).argmin(axis=1)]
            near = {(period, *key[1:]): row for period, (key, row) in zip(nearest, table.items(), strict=True)}
            if len(near) < len(table) or np.any(np.abs(nearest - given) > 1e-5 * nearest):
                raise DatabaseError(f"{file}: its periods are not those of {path}.1; needs the files of one run.")
            values = _values(file, near, periods, headings, modes)
            forces[name] = values[..., 2] - 1j * values[..., 3]
    return headings, forces


class _Dry(NamedTuple):
    """Contents of the .mmx file."""

    bodies: int | None  # as stated
    matrices: dict[str, FloatArray]  # mass, damping and stiffness, (mode, mode)
    facts: dict[str, Any]  # attributes: displaced volumes, and centres of the only body


def _read_dry(path: str, modes: list[int], gravity: float, length: float) -> _Dry:
    """Bodies, their mass, damping and stiffness, displaced volumes and centres, of the .mmx file."""
    text = "\n".join(_lines(path, "I J MASS DAMP STIF"))
    words = {"NBODY =": 1, "Gravity:": 1, "Length scale:": 1}
    (bodies,), (g,), (scale,) = (_after(path, text, word, n) for word, n in words.items())
    parts = re.split(r"for body N =", text)[1:] or [text]
    if bodies != len(parts):
        raise DatabaseError(f"{path}: holds {bodies:g} bodies, {len(parts)} with matrices; needs those of all.")
    if not np.allclose([g, scale], [gravity, length], rtol=1e-5):
        raise DatabaseError(
            f"{path}: of a run with gravity {g:g} and ULEN {scale:g}; received gravity {gravity:g}, length {length:g}."
        )
    volumes = [float(np.median(_after(path, part, "Volumes", 3))) for part in parts]
    facts: dict[str, Any] = {volume_of(f"body{k + 1}"): volume for k, volume in enumerate(volumes)}
    if len(parts) == 1:
        buoyancy, mass = (_after(path, text, word, 3) for word in ("Buoyancy", "of Gravity:"))
        facts = {"displaced_volume": volumes[0], "centre_of_buoyancy": buoyancy, "centre_of_mass": mass}
    *_, rest = blocks = text.split("External force matrices")
    if len(blocks) == 1:
        return _Dry(len(parts), {}, facts)
    (form,) = _after(path, text, "IALTFRC =", 1)
    if len(blocks) > 2 or (form != 2 and len(parts) > 1):
        raise DatabaseError(
            f"{path}: holds external force matrices of {len(parts)} bodies with IALTFRC = {form:g}; needs IALTFRC = 2, "
            "one table of all bodies, or 1, and mass, damping and stiffness in the study."
        )
    table = _table(path, rest.splitlines()[2:], (0, 1), (5,), "I J MASS DAMP STIF")
    matrices = np.moveaxis(_values(path, table, modes, modes), -1, 0)
    return _Dry(len(parts), dict(zip(_DRY, matrices, strict=True)), facts)


def _after(path: str, text: str, word: str, count: int) -> FloatArray:
    """The first numbers on the line after a word."""
    line = text.partition(word)[2].partition("\n")[0]
    found = re.findall(r"[-+]?\d+\.?\d*(?:[ED][-+]?\d+)?", line.upper())
    if len(found) < count:
        raise DatabaseError(f"{path}: holds no {word.strip(' :=')!r}; needs the .mmx file as WAMIT writes it.")
    return np.array([float(number.replace("D", "E")) for number in found[:count]])
