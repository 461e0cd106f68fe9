"""Records of the sea's elevation: read from a file, and as sums of harmonics of their own length.

Imports nothing heavy unless there is a record: the Snakefile reads a study at every parse.
"""

import math
import re
from collections.abc import Collection, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Field, model_validator

from vsb.engine.waves.record_faults import Record, without_faults
from vsb.errors import ConfigError
from vsb.keys.quantities import Brief, Positive, content_id
from vsb.tools import units
from vsb.tools.columns import Columns, dates, plain_name, read_columns
from vsb.tools.units import number
from vsb.tools.words import shortened

if TYPE_CHECKING:
    from vsb.tools.arrays import ComplexArray, FloatArray

FEWEST, MOST = 32, 2**17
"""Samples of a record."""
HIGHEST = 50.0
"""Largest elevation [m]; missing values are often written as 99 or 999."""
UNEVEN = 1e-6
"""Largest deviation of an instant from equal steps, in steps and at least in seconds."""
MISSING = {"", "nan", "na", "n/a", "mm", "null", "none", "-", "--"}
"""Words that stand for a missing elevation."""
ROUNDED = 0.1
"""Largest rounding of instants, in steps, within which their steps count as equal."""
TAIL = 0.005
"""Share of the variance that lies below the lowest frequency a record needs solved [-]."""
LEFT_OUT = 0.01
"""Largest share of the variance of a record that may lie outside the band solved [-]."""
STANDARD_GRAVITY = 9.81
STEEPEST = 0.1
"""Largest possible steepness, Hs over g Te^2/(2 pi): waves as high as a seventh of their length break [-]."""
HIGHEST_SEA = 40.0
"""Largest possible Hs [m]."""


def impossible(hs: Any, te: Any) -> Any:
    """Return whether seas are steeper or higher than possible, of numbers or arrays; many of them mean wrong units."""
    return (2 * math.pi * hs > STEEPEST * STANDARD_GRAVITY * te**2) | (hs > HIGHEST_SEA)


class Samples(Brief):
    """Elevations [m] at the buoy's axis at equal steps of time [s], as a sum of harmonics of their own length.

    Still water is the mean of the record. The harmonics a_k = conj(2 X_k/N), X the discrete Fourier transform of the N
    samples, have frequencies 2 pi k/(N step), and Re sum_k a_k exp(-i omega_k t) passes through every sample.
    """

    BRIEF = ("notes",)
    step: Positive
    elevation: Annotated[
        tuple[Annotated[float, Field(ge=-HIGHEST, le=HIGHEST)], ...], Field(min_length=FEWEST, max_length=MOST)
    ]
    notes: tuple[str, ...] = ()  # what the file holds beside, and how it was read

    @model_validator(mode="after")
    def _moves(self) -> Self:
        if min(self.elevation) == max(self.elevation):
            raise ValueError(f"elevation: received {self.elevation[0]:g} m throughout, needs waves")
        return self

    @property
    def length(self) -> float:
        """Time after which the sum of harmonics repeats [s]."""
        return self.step * len(self.elevation)

    @cached_property
    def phasors(self) -> "ComplexArray":
        """Complex amplitudes of the harmonics (harmonic,) [m]."""
        import numpy as np

        count = len(self.elevation)
        found = 2 * np.conj(np.fft.rfft(self.elevation)[1:]) / count
        if count % 2 == 0:
            found[-1] /= 2  # of two samples a period: it and its mirror image are the same
        return np.asarray(found)

    @cached_property
    def omega(self) -> "FloatArray":
        """Frequencies of the harmonics (harmonic,) [rad/s]."""
        import numpy as np

        return np.asarray(2 * np.pi / self.length * np.arange(1, len(self.phasors) + 1))

    @cached_property
    def variances(self) -> "FloatArray":
        """Variance of each harmonic (harmonic,) [m^2]."""
        return abs(self.phasors) ** 2 / 2

    @property
    def size(self) -> str:
        """How much it holds, in words."""
        return f"{len(self.elevation)} samples, one in {self.step:g} s"

    @property
    def hs(self) -> float:
        """Significant height, four standard deviations [m]."""
        return 4 * math.sqrt(float(self.variances.sum()))

    @property
    def energy_frequency(self) -> float:
        """Frequency of the energy period m_-1/m_0 [rad/s]."""
        return float(self.variances.sum() / (self.variances / self.omega).sum())

    @property
    def lowest(self) -> float:
        """Frequency below which lies less than `TAIL` of the variance [rad/s]."""
        below = self.variances.cumsum()
        return float(self.omega[(below >= TAIL * below[-1]).argmax()])

    @property
    def fastest(self) -> float:
        """Frequency above which no harmonic has a twentieth of the largest amplitude [rad/s]."""
        return float(self.omega[self.variances > 0.05**2 * self.variances.max()][-1])

    def share_outside(self, low: float, high: float) -> float:
        """Return the share of the variance outside a band [rad/s]."""
        outside = (self.omega < low - 1e-9) | (self.omega > high + 1e-9)
        return float(self.variances[outside].sum() / self.variances.sum())

    @cached_property
    def digest(self) -> str:
        """Eight hexadecimal digits that name the record by what it holds."""
        return content_id(self.model_dump(exclude={"notes"}))[:8]


def read_record(path: Path, where: str, repair: Collection[str] = (), accept: Collection[str] = ()) -> dict[str, Any]:
    """Return step [s], elevations [m] and notes of a file of two columns, time and elevation.

    Times are in seconds, another unit that the file states, or dates; elevations in metres or a unit that it states:
    see `vsb.tools.columns.read_columns`. Raises `ConfigError` if it cannot be read, a row is not two numbers, or of a
    fault of the sensor that is neither repaired nor accepted: see `vsb.engine.waves.record_faults`.

    Parameters
    ----------
    where : str
        Place in the study, for messages about the file as a whole.
    repair, accept : collection of str
        Faults that are repaired, and that are left as they are.
    """
    table = read_columns(path, where, "two columns, time [s] and elevation [m]", _is_of_a_record)
    of_time, of_elevation, seconds, metres, notes = _two_columns(path, table)
    written = [cells[of_time] for _, cells in table.rows]
    days = dates(written)
    instants = [(day - days[0]).total_seconds() for day in days] if days else [number(cell) for cell in written]
    lines: list[int] = []
    times: list[float] = []
    elevations: list[float] = []
    for instant, (n, cells) in zip(instants, table.rows, strict=True):
        cell = cells[of_elevation] if of_elevation < len(cells) else "none"
        elevation = math.nan if cell.lower() in MISSING else number(cell)
        if instant is None or elevation is None or (not table.header and len(cells) != 2):
            raise ConfigError(
                f"{path}:{n}: received {shortened(repr(' '.join(cells)))}, needs two numbers, time [s] and "
                "elevation [m]"
            )
        if abs(elevation * metres) > HIGHEST and "gaps" not in repair:
            raise ConfigError(
                f"{path}:{n}: elevation: received {elevation * metres:g} m at {seconds * instant:g} s, needs at most "
                f"{HIGHEST:g} m: cut the record, or repair: [gaps] if this stands for a missing value"
            )
        if not math.isfinite(instant) or (times and seconds * instant <= times[-1]):
            last = f" after {times[-1]:.9g} s" if times else ""
            raise ConfigError(f"{path}:{n}: time: received {seconds * instant:.9g} s{last}, needs ascending times")
        lines.append(n)
        times.append(seconds * instant)
        elevations.append(elevation * metres if abs(elevation * metres) <= HIGHEST else math.nan)
    if not FEWEST <= len(times) <= MOST:
        raise ConfigError(
            f"{where}: received {len(times)} samples in {path.name}, needs {FEWEST} to {MOST}: lines of time [s] and "
            "elevation [m]"
        )
    step, repaired, remarks = _checked(path, lines, times, elevations, seconds * _written_to(written), repair, accept)
    held: dict[str, Any] = {"step": step, "elevation": repaired, "notes": [*notes, *remarks]}
    if not all(table.units) and len({*repaired}) > 1:
        of_file = Samples(**held)
        if abs(level := math.fsum(repaired) / len(repaired)) > of_file.hs:
            held["notes"].append(f"its mean, {level:.4g} m, taken as still water")
        check_possible(str(path), of_file.hs, 2 * math.pi / of_file.energy_frequency, "time in s, elevation in m")
    return held


def _checked(
    path: Path, lines: list[int], times: list[float], elevations: list[float], written: float,
    repair: Collection[str], accept: Collection[str],
) -> tuple[float, list[float], list[str]]:  # fmt: skip
    """Step, elevations and notes of a record without faults of its sensor, its times `written` to so many seconds."""
    import numpy as np

    usual = float(np.median(np.diff(times)))
    if sum(elevation == elevation for elevation in elevations) < FEWEST:
        raise ConfigError(f"{path}: received fewer than {FEWEST} elevations that are numbers, needs a record")
    tolerance = max(UNEVEN * max(1.0, usual), written if written <= ROUNDED * usual else 0.0)
    record = Record(path, np.array(times), np.array(elevations), tuple(lines), tolerance, repair, accept)
    record = without_faults(record)
    return record.step, record.elevation.tolist(), list(record.notes)


def check_possible(source: str, hs: float, te: float, needed: str) -> None:
    """Check the steepness of a sea whose file states no units; raises `ConfigError`.

    Parameters
    ----------
    hs, te : float [m], [s]
    needed : str
        Units the numbers were taken in.
    """
    if impossible(hs, te):
        raise ConfigError(
            f"{source}: received waves of Hs {hs:.4g} m with Te {te:.4g} s, which are physically impossible; needs "
            f"{needed}, or the units in the names of the columns"
        )


_Read = tuple[int, int, float, float, list[str]]
"""Columns of time and elevation, factors to s and m, notes."""
TIMES = {"t", "time", "date", "datetime", "timestamp", "zeit", "seconds", "elapsedtime", "validtime"}
ELEVATIONS = {
    "eta", "η", "zeta", "elevation", "surface", "surfaceelevation", "waveelevation", "freesurface", "heave", "z",
    "level", "waterlevel", "wave", "seasurfaceelevation", "displacement", "height", "h", "wavegauge",
}  # fmt: skip


def _is_of_a_record(name: str) -> bool:
    """Whether a column of a name may be of times or elevations."""
    return plain_name(name) in TIMES | ELEVATIONS


def _two_columns(path: Path, table: Columns) -> _Read:
    """Which columns are time and elevation, by their units, then names, then places."""
    if not table.header:
        return 0, 1, 1.0, 1.0, []
    line = f"{path}: received the columns {shortened(repr(table.header))}"
    columns = range(len(table.names))
    of_time = [i for i in columns if table.units[i] and units.scale(table.units[i], units.SECOND)]
    of_time = of_time or [i for i in columns if table.plain[i] in TIMES and not table.units[i]] or [0]
    rest = [i for i in columns if i != of_time[0]]
    chosen = [i for i in rest if table.units[i] and units.scale(table.units[i], units.METRE)]
    named = [i for i in chosen or rest if table.plain[i] in ELEVATIONS and not (table.units[i] and not chosen)]
    chosen = named if len(chosen) != 1 and named else chosen or (rest if len(rest) == 1 else [])
    if len(chosen) != 1:
        several = f"{len(chosen)} of them elevations" if chosen else "none of them known as an elevation"
        raise ConfigError(f"{line}, {several}; needs time and one elevation, such as time [s], elevation [m]")
    time, elevation = of_time[0], chosen[0]
    seconds, metres = (
        units.scale(table.units[i], powers) if table.units[i] else 1.0
        for i, powers in ((time, units.SECOND), (elevation, units.METRE))
    )
    if seconds is None or metres is None:
        wrong = table.label(time if seconds is None else elevation)
        raise ConfigError(f"{line}; needs times in s and elevations in m, or units of these, no {wrong}")
    notes = []
    if (seconds, metres) != (1.0, 1.0):
        notes.append(f"{table.label(time)} and {table.label(elevation)} turned into s and m")
    elif not (table.units[time] and table.units[elevation]):
        notes.append("units that are not stated taken as s and m")
    if left := [table.label(i) for i in rest if i != elevation]:
        notes.append(f"columns left out: {', '.join(left)}")
    return time, elevation, seconds, metres, notes


def _written_to(cells: Sequence[str]) -> float:
    """The last decimal that numbers of a file are written to; 0 of dates and powers of ten."""
    digits = [re.fullmatch(r"[-+]?\d+[.,]?(\d*)", cell) for cell in cells]
    return 10.0 ** -max(len(found[1]) for found in digits if found) if digits and all(digits) else 0.0
