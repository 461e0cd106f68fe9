"""NEMOH's results, read: a folder with Nemoh.cal, Results/*.tec and Mesh/*.dat of version 2 or 3.

Phasors are Re(X e^{-i omega t}) as here (C1), with moduli and angles [rad] in `ExcitationForce.tec`; numbers are in SI
units. Which motions a body has and what they turn about stands in `Nemoh.cal`, stiffness in still water and points at
rest in `KH.dat` and `Hydrostatics.dat`, of several bodies `KH_0.dat`, ....
"""

import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.linalg import block_diag

from vsb.engine.hydro.formats.common import WATER, assembled, body_names, point_of, volume_of, whole_lines
from vsb.engine.hydro.variables import RIGID
from vsb.errors import DatabaseError
from vsb.tools.arrays import FloatArray
from vsb.tools.files import read_bounded

CAL, RESULTS, MESH = "Nemoh.cal", ("Results", "results"), ("Mesh", "mesh")
_NEEDED = "a folder of NEMOH with Nemoh.cal, Results/RadiationCoefficients.tec and Results/ExcitationForce.tec"
_LINES_BEHIND = 3  # of a body: points and panels behind the mesh's name
_AXES = ("w (rad/s)", "f (Hz)", "T (s)")  # first columns: angular frequencies, frequencies or periods


class _Case(NamedTuple):
    """What Nemoh.cal states."""

    density: float  # [kg/m^3]
    gravity: float  # [m/s^2]
    depth: float  # [m]
    motions: list[list[int]]  # of each body, by their places in `RIGID`
    centres: list[FloatArray | None]  # of each body's rotations (xyz) [m], if all are about one


def read_nemoh(folder: str | Path) -> xr.Dataset:
    """Return the hydro database in a folder of NEMOH: all motions of all bodies.

    Motions are unit translations along the axes and rotations about them; of several bodies their names have the
    number of the body before them, body1__Heave. Without `KH.dat` the database has no `hydrostatic_stiffness`, which
    its history says. Raises `DatabaseError` if a file is missing, damaged, or of another run.
    """
    place = Path(folder)
    case = _case(place / CAL)
    radiation, omega = _zones(_found(place, RESULTS, "RadiationCoefficients.tec"), "motion of body")
    force, waves = _zones(_found(place, RESULTS, "ExcitationForce.tec"), "excitation force|diffraction force")
    prefixes = [f"{name}__" if name else "" for name in body_names([""] * len(case.motions))]
    labels = [f"{body}{RIGID[k]}" for body, some in zip(prefixes, case.motions, strict=True) for k in some]
    count = len(labels)
    if len(radiation) != count or {values.shape[1] for _, values in (*radiation, *force)} != {2 * count}:
        raise DatabaseError(
            f"{folder}: {CAL} states {count} motions, the results hold {len(radiation)} motions and "
            f"{radiation[0][1].shape[1] // 2} forces of each; needs the files of one run, a force for every motion."
        )
    if len(omega) != len(waves) or not np.allclose(omega, waves, rtol=1e-5):
        raise DatabaseError(f"{folder}: radiation and excitation have other frequencies; needs the files of one run.")
    order = np.argsort(omega)
    pairs = np.array([values.reshape(len(omega), count, 2)[order] for _, values in radiation])  # (radiating, ...)
    forces = np.array([values.reshape(len(omega), count, 2)[order] for _, values in force])
    headings = [_heading(title, folder) for title, _ in force]
    history = [f"read from NEMOH's folder {place.name}"]
    variables: dict[str, Any] = {
        "added_mass": np.moveaxis(pairs[..., 0], 0, -1),
        "radiation_damping": np.moveaxis(pairs[..., 1], 0, -1),
        "excitation_force": np.moveaxis(forces[..., 0] * np.exp(1j * forces[..., 1]), 0, 1),
    }
    stiffness, facts, missing = _at_rest(place, case)
    if stiffness is not None:
        variables["hydrostatic_stiffness"] = stiffness
    repeated = [k for k, heading in enumerate(headings) if any((heading - h) % 360 == 0 for h in headings[:k])]
    if repeated:
        kept = [k for k in range(len(headings)) if k not in repeated]
        variables["excitation_force"] = variables["excitation_force"][:, kept]
        history.append(f"left out: wave direction {headings[repeated[0]]:g} degrees, which is {headings[0]:g} again")
        headings = [headings[k] for k in kept]
    if missing:
        history.append(f"not there: {', '.join(missing)}")
    attrs = dict(zip(WATER, (case.density, case.gravity, str(case.depth)), strict=True), source="NEMOH")
    return assembled(
        str(folder), (labels, omega[order], headings), variables, {**attrs, **facts, "history": "; ".join(history)}
    )


def _found(folder: Path, names: tuple[str, ...], file: str) -> Path:
    """A file in a folder whose name may begin with a capital."""
    return next((path for name in names if (path := folder / name / file).is_file()), folder / names[0] / file)


def _text(path: Path) -> list[str]:
    """Lines of a file."""
    try:
        return whole_lines(path, read_bounded(path).decode(errors="replace"))
    except OSError as error:
        raise DatabaseError(f"{path}: cannot be read ({error.strerror}); needs {_NEEDED}.") from None


def _numbers(path: Path, number: int, line: str, count: int) -> list[float]:
    """The first numbers of a line."""
    try:
        found = [float(word.upper().replace("D", "E")) for word in line.split()[:count]]
    except ValueError:
        found = []
    if len(found) < count or not np.isfinite(found).all():
        raise DatabaseError(f"{path}, line {number}: received {line.strip()[:60]!r}; needs {count} finite numbers.")
    return found


def _case(path: Path) -> _Case:
    """What Nemoh.cal states: it has its numbers in lines of a fixed order."""
    lines = _text(path)
    at = 0

    def after(skipped: int, count: int) -> list[float]:
        nonlocal at
        at += skipped + 1
        if at > len(lines):
            raise DatabaseError(f"{path}: ends at line {len(lines)}; needs a whole {CAL}.")
        return _numbers(path, at, lines[at - 1], count)

    (density,), (gravity,), (depth,) = after(1, 1), after(0, 1), after(0, 1)
    bodies = int(after(2, 1)[0])
    motions, centres = list[list[int]](), list[FloatArray | None]()
    for _ in range(bodies):
        count = int(after(_LINES_BEHIND, 1)[0])
        rows = [after(0, 7) for _ in range(count)]
        motions.append([_motion(path, at - count + k + 1, row) for k, row in enumerate(rows)])
        about = np.array([row[4:] for row in rows if row[0] == 2]).reshape(-1, 3)
        centres.append(about[0] if len(about) and np.ptp(about, axis=0).max() == 0 else None)
        after(int(after(0, 1)[0]), 1)  # the generalised forces, then the number of lines of more information
        at += int(_numbers(path, at, lines[at - 1], 1)[0])
    return _Case(density, gravity, depth or np.inf, motions, centres)


def _motion(path: Path, number: int, row: list[float]) -> int:
    """Place of a motion in `RIGID`: 1 or 2 for a translation or rotation, direction, and point."""
    kind, direction = row[0], row[1:4]
    if kind not in (1, 2) or sorted(direction) != [0, 0, 1]:
        raise DatabaseError(
            f"{path}, line {number}: motion {row[:4]}; needs unit translations (1) or rotations (2) along an axis."
        )
    return int(kind - 1) * 3 + direction.index(1)


def _zones(path: Path, title: str) -> tuple[list[tuple[str, FloatArray]], FloatArray]:
    """Titles and numbers of the zones of a Tecplot file, shape (frequency, column), and the frequencies [rad/s]."""
    lines = _text(path)
    starts = [k for k, line in enumerate(lines) if re.match(r"\s*zone\b", line, re.IGNORECASE)]
    if not starts or any(not re.search(title, lines[k], re.IGNORECASE) for k in starts):
        raise DatabaseError(f"{path}: holds no zones of {title.split('|')[0]}; needs {_NEEDED}.")
    unit = re.search(r'VARIABLES\s*=\s*"([^"]*)"', lines[0])
    if unit is None or unit[1].strip() not in _AXES:
        raise DatabaseError(f"{path}:1: received {lines[0].strip()[:60]!r}; needs {', '.join(_AXES)}.")
    zones, column = list[tuple[str, FloatArray]](), np.zeros(0)
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        rows = [
            _numbers(path, k + 1, lines[k], len(lines[k].split())) for k in range(start + 1, end) if lines[k].strip()
        ]
        if not rows or {len(row) for row in rows} != {len(rows[0])} or len(rows[0]) % 2 != 1:
            raise DatabaseError(f"{path}, line {start + 1}: zone of rows of unequal length; needs a whole file.")
        values = np.array(rows)
        column = column if zones else values[:, 0]
        if values.shape[0] != len(column) or not np.array_equal(values[:, 0], column) or not (column > 0).all():
            raise DatabaseError(f"{path}, line {start + 1}: zone of other frequencies than the first, or not above 0.")
        zones.append((lines[start], values[:, 1:]))
    if unit[1].strip() == _AXES[0]:
        return zones, column
    return zones, np.asarray(2 * np.pi * (column if unit[1].strip() == _AXES[1] else 1 / column))


def _heading(title: str, folder: str | Path) -> float:
    """Direction of waves in the title of a zone [degrees]."""
    found = re.search(r"beta\s*=\s*([-+\d.EDed]+)\s*deg", title)
    try:
        return float(found[1]) if found else float("nan")
    except ValueError:
        raise DatabaseError(f"{folder}: zone {title.strip()[:60]!r}; needs a wave direction in degrees.") from None


def _at_rest(folder: Path, case: _Case) -> tuple[FloatArray | None, dict[str, Any], list[str]]:
    """Stiffness in still water, points and volumes at rest, and the files that are not there."""
    facts: dict[str, Any] = {}
    blocks, missing, bodies = list[FloatArray](), list[str](), len(case.motions)
    for k, name in enumerate(body_names([""] * bodies)):
        suffix = f"_{k}" if bodies > 1 else ""
        if (centre := case.centres[k]) is not None:
            facts[point_of("rotation_centre", name)] = centre
        path = _found(folder, MESH, f"KH{suffix}.dat")
        if path.is_file():
            rows = [_numbers(path, n, line, 6) for n, line in enumerate(_text(path)[:6], 1)]
            if len(rows) < 6:
                raise DatabaseError(f"{path}: holds {len(rows)} lines; needs six of six numbers.")
            blocks.append(np.array(rows)[np.ix_(case.motions[k], case.motions[k])])
        else:
            missing.append(path.name)
        path = _found(folder, MESH, f"Hydrostatics{suffix}.dat")
        if path.is_file():
            text = "\n".join(_text(path))
            numbers = {
                key: re.findall(rf"{key}\s*=\s*([-+\d.EDed]+)", text) for key in ("[XYZ]F", "[XYZ]G", "Displacement")
            }
            if [len(found) for found in numbers.values()] != [3, 3, 1]:
                raise DatabaseError(f"{path}: holds other lines than XF - XG, ..., Displacement; needs NEMOH's file.")
            buoyancy, mass, (volume,) = (_numbers(path, 1, " ".join(f), len(f)) for f in numbers.values())
            facts |= {point_of("centre_of_buoyancy", name): buoyancy, point_of("centre_of_mass", name): mass}
            facts[volume_of(name)] = volume
        else:
            missing.append(path.name)
    return block_diag(*blocks) if len(blocks) == bodies else None, facts, missing
