"""Records of the sea's elevation: read from a file, checked for faults of sensors, and as sums of harmonics.

Faults are named with their time, and repaired only where a study asks for it. Spikes and steps are jumps many times
those around them; a stuck sensor repeats a number for half a wave or more; drift is what changes more slowly than waves
do. A wave that only looks like one of these can be accepted.
"""

import math
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, get_args

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from vsb.engine.waves.seas import TAIL, Sea, SeaFile, SeaOfFile
from vsb.errors import ConfigError
from vsb.keys.meanings import Key
from vsb.keys.quantities import Positive
from vsb.tools import units
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray
from vsb.tools.columns import Columns, dates, plain_name, read_columns
from vsb.tools.units import number
from vsb.tools.words import shortened

Repairable = Literal["gaps", "times", "spikes", "steps", "drift"]
Acceptable = Literal["spikes", "steps", "stuck", "drift"]
Fault = Repairable | Acceptable
"""Faults; without gaps and at equal times a record must be, and nobody knows what a stuck sensor missed."""
JUMP, AROUND, OF_RECORD = 8.0, 3.0, 0.5
"""Jumps are faults above all: robust standard deviations of jumps, the largest tenth around, the record's deviation."""
WINDOW, BESIDE, LONGEST_SPIKE, PASSES = 24, 4, 20, 5
"""Jumps around one, those next to it left out; samples of a spike; passes, as large spikes hide small ones."""
SHORTEST_STUCK = 5
"""Samples of one value from which on a sensor may be stuck, if they last half a zero-crossing period."""
SLOWEST = 40.0
"""Longest period of waves [s]: what changes more slowly is drift, tide or surge."""
DRIFT = 0.05
"""Share of the variance that may lie in slower changes."""
LONGEST_GAP = 0.5
"""Longest gap that is filled, in zero-crossing periods."""
SHOWN = 3
"""Instants named in a message."""


@dataclass(frozen=True, eq=False)
class Record:
    """A record while it is checked: instants [s], elevations [m], NaN where they are missing, lines of the file."""

    path: Path
    time: FloatArray
    elevation: FloatArray
    lines: tuple[int, ...]
    tolerance: float  # deviation of instants from equal steps that counts as rounding [s]
    repair: Collection[str]
    accept: Collection[str]
    notes: tuple[str, ...] = ()

    @property
    def crossing_period(self) -> float:
        """Mean time between zero up-crossings [s]; the length where there is none."""
        import numpy as np

        waves = self.elevation[~np.isnan(self.elevation)]
        waves = waves - _slow(waves, self.step)
        crossings = int(((waves[:-1] < 0) & (waves[1:] >= 0)).sum())
        return float(self.time[-1] - self.time[0]) / max(crossings, 1)

    @property
    def step(self) -> float:
        """The usual time between samples [s]."""
        import numpy as np

        return float(np.median(np.diff(self.time)))

    def reported(self, fault: Fault, what: str, at: Sequence[int]) -> tuple["Record", bool]:
        """Return the record with a note of a fault, and whether it is to be repaired; raise if nothing is asked."""
        places = ", ".join(f"{self.time[i]:.6g} s" for i in at[:SHOWN]) + (", ..." if len(at) > SHOWN else "")
        for asked, words in ((self.repair, "repaired"), (self.accept, "accepted")):
            if fault in asked:
                note = f"{words}: {what} at {places}"
                return replace(self, notes=tuple(dict.fromkeys([*self.notes, note]))), asked is self.repair
        remedies = [f"repair: [{fault}]"] if fault in get_args(Repairable) else []
        remedies += [f"accept: [{fault}]"] if fault in get_args(Acceptable) else []
        raise ConfigError(
            f"{self.path}:{self.lines[at[0]]}: received {what} at {places}; needs none, or beside the file in the "
            f"study {' or '.join(remedies)}"
        )


def without_faults(record: Record) -> Record:
    """Return a record at equal steps, its faults repaired or accepted as its notes say.

    Raises `ConfigError` of a fault that is neither, with its line and time.
    """
    record = _even_times(_filled(record))
    record = _not_stuck(record)
    for _ in range(PASSES):
        before, record = record, _smooth(record)
        if record.elevation is before.elevation:
            break
    record = _without_drift(record)
    absent = [_WORDS[fault] for fault in record.repair if fault in _WORDS]
    absent = [what for what in absent if not any(what in note for note in record.notes)]
    return replace(record, notes=(*record.notes, *(f"repair: no {what} found" for what in absent)))


_WORDS = {
    "gaps": "missing value", "times": "uneven time", "spikes": "spike", "steps": "level step", "drift": "drift",
    "stuck": "stuck value",
}  # fmt: skip


def _report(record: Record, fault: Fault, at: list[int]) -> tuple[Record, bool]:
    """Report a fault that occurs at some samples; see `Record.reported`."""
    return record.reported(fault, f"{len(at)} {_WORDS[fault]}{'s' if len(at) > 1 else ''}", at)


def _filled(record: Record) -> Record:
    """Rows that are missing are put in, values that are missing are interpolated, over a part of a wave at most."""
    time, elevation, lines = record.time, record.elevation, list(record.lines)
    whole = np.rint(np.diff(time) / record.step).astype(int)
    for i in np.flatnonzero(whole > 1)[::-1]:
        inserted = np.linspace(time[i], time[i + 1], whole[i] + 1)[1:-1]
        time = np.insert(time, i + 1, inserted)
        elevation = np.insert(elevation, i + 1, np.full(len(inserted), np.nan))
        lines[i + 1 : i + 1] = [lines[i + 1]] * len(inserted)
    record, missing = replace(record, time=time, elevation=elevation, lines=tuple(lines)), np.isnan(elevation)
    if not missing.any():
        return record
    record, _ = _report(record, "gaps", np.flatnonzero(missing).tolist())
    longest = LONGEST_GAP * record.crossing_period
    for first, last in _runs(missing):
        if (last - first + 2) * record.step > max(longest, 2 * record.step) or first == 0 or last == len(missing) - 1:
            raise ConfigError(
                f"{record.path}:{record.lines[first]}: received a gap of {(last - first + 1) * record.step:.3g} s at "
                f"{record.time[first]:.6g} s, needs at most {longest:.3g} s, half of the waves' period, within the "
                "record: cut it there"
            )
    return replace(record, elevation=_interpolated(time, elevation, missing))


def _even_times(record: Record) -> Record:
    """Instants that are not equally spaced: the elevations between them are interpolated."""
    even = np.linspace(record.time[0], record.time[-1], len(record.time))
    off = np.abs(record.time - even)
    if off.max() <= record.tolerance:
        return replace(record, time=even)
    from scipy.interpolate import CubicSpline

    record, _ = _report(record, "times", np.flatnonzero(off > record.tolerance).tolist())
    return replace(record, time=even, elevation=CubicSpline(record.time, record.elevation)(even))


def _smooth(record: Record) -> Record:
    """Take out jumps that no wave makes, there and back or for good, or report them."""
    jumps = np.diff(record.elevation)
    size = np.abs(jumps)
    robust = 1.4826 * float(np.median(np.abs(jumps - np.median(jumps))))
    least = max(JUMP * robust, OF_RECORD * float(record.elevation.std()))
    suspects = [i for i in np.flatnonzero(size > least).tolist() if size[i] > AROUND * _around(size, i)]
    spikes, steps, end = [], [], -1
    for i in suspects:
        if i < end:
            continue
        if i < BESIDE // 2 and i + 1 not in suspects:
            spikes.append((0, i))
        elif (last := _return(record.elevation, i, float(_around(size, i)))) is not None:
            spikes.append((i + 1, last))
            end = last + 1
        else:
            steps.append(i + 1)
    if spikes:
        record, asked = _report(record, "spikes", [first for first, _ in spikes])
        bad = np.zeros(len(record.elevation), dtype=bool)
        for first, last in spikes:
            bad[first : last + 1] = True
        record = replace(record, elevation=_interpolated(record.time, record.elevation, bad)) if asked else record
    if steps:
        record, asked = _report(record, "steps", steps)
        record = replace(record, elevation=_levelled(record, steps)) if asked else record
    return record


def _levelled(record: Record, steps: Sequence[int]) -> FloatArray:
    """Elevations without steps: each jump but for those beside it, or by a fit of all where that is closer.

    The fit is of a straight line and the steps; waves of period T and deviation s change it by s T/(pi length).
    """
    jumps, places = np.diff(record.elevation), np.arange(len(record.elevation))
    curved = 1.4826 * float(np.median(np.abs(np.diff(jumps))))
    heights = [jumps[i - 1] - np.mean(np.delete(jumps, i - 1)[max(i - 2, 0) : i]) for i in steps]
    fitted = np.linalg.lstsq(np.column_stack([places**0, places, *(places >= i for i in steps)]), record.elevation)[0][
        2:
    ]
    left = record.elevation - sum(height * (places >= i) for height, i in zip(fitted, steps, strict=True))
    length = float(record.time[-1] - record.time[0]) / (len(steps) + 1)
    by_fit = float(left.std()) * record.crossing_period / (math.pi * length) < curved
    chosen = fitted if by_fit else heights
    steady = np.sum([height * (places >= i) for height, i in zip(chosen, steps, strict=True)], axis=0)
    return np.asarray(record.elevation - steady)


def _around(size: FloatArray, i: int) -> float:
    """Jumps around one that nine of ten do not exceed; those next to it may be of the same fault."""
    near = np.r_[max(i - WINDOW, 0) : max(i - BESIDE, 0), min(i + BESIDE + 1, len(size)) : min(i + WINDOW, len(size))]
    return float(np.quantile(size[near], 0.9)) if len(near) else math.inf


def _return(elevation: FloatArray, i: int, around: float) -> int | None:
    """Last sample of a spike that begins with a jump: the next one is about where it began; None of a step."""
    jump = abs(float(elevation[i + 1] - elevation[i]))
    longest = min(LONGEST_SPIKE, max(2, int(0.5 * jump / around) if around else LONGEST_SPIKE))
    for last in range(i + 1, min(i + 1 + longest, len(elevation) - 1)):
        if abs(float(elevation[last + 1] - elevation[i])) < 0.5 * jump:
            return last
    return len(elevation) - 1 if i + 2 >= len(elevation) - 1 else None


def _not_stuck(record: Record) -> Record:
    """Report where a value stays the same for half a wave, but for still water before and after waves."""
    jumps = np.abs(np.diff(record.elevation))
    deviation = float(record.elevation.std())
    if not jumps.any() or deviation < 2 * float(jumps[jumps > 0].min()):
        return record
    fewest = max(SHORTEST_STUCK, math.ceil(0.5 * record.crossing_period / record.step))
    found = []
    for first, last in _runs(jumps == 0):
        calm = abs(float(record.elevation[first] - np.median(record.elevation))) < 0.1 * deviation
        at_end = first == 0 or last == len(jumps) - 1
        if last - first + 2 >= fewest and not (calm and at_end):
            found.append(int(first))
    return _report(record, "stuck", found)[0] if found else record


def _without_drift(record: Record) -> Record:
    """Take out what changes more slowly than waves do, or report it."""
    slow = _slow(record.elevation, record.step)
    waves = record.elevation - slow
    crossings = int(((waves[:-1] < 0) & (waves[1:] >= 0)).sum())
    share = float(np.var(slow) / np.var(record.elevation)) if np.ptp(record.elevation) else 0.0
    if crossings < 3 or share <= max(DRIFT, 2 / crossings**2):
        return record
    what = f"drift of {np.ptp(slow):.3g} m, {100 * share:.3g} % of the variance, largest"
    record, asked = record.reported("drift", what, [int(np.abs(slow - slow.mean()).argmax())])
    return replace(record, elevation=waves) if asked else record


def _slow(elevation: FloatArray, step: float) -> FloatArray:
    """The part of a record slower than waves: a straight line, and cosines of longer periods about it."""
    from scipy.fft import dct, idct

    time = np.arange(len(elevation))
    line = np.polyval(np.polyfit(time, elevation, 1), time)
    parts = dct(elevation - line, norm="ortho")
    parts[int(2 * len(elevation) * step / SLOWEST) + 1 :] = 0.0  # the k-th has k half periods in the record
    return np.asarray(line + idct(parts, norm="ortho"))


def _interpolated(time: FloatArray, elevation: FloatArray, bad: FloatArray) -> FloatArray:
    """Elevations with cubic splines through the good ones in place of the bad."""
    from scipy.interpolate import CubicSpline

    good = ~np.asarray(bad, dtype=bool)
    spline = CubicSpline(time[good], elevation[good])
    inside = np.clip(time, time[good][0], time[good][-1])
    return np.where(good, elevation, spline(inside))


def _runs(there: FloatArray) -> list[tuple[int, int]]:
    """First and last places of runs of true values."""
    edges: IntArray = np.flatnonzero(np.diff(np.r_[0, np.asarray(there, dtype=int), 0]))
    return [(int(first), int(last) - 1) for first, last in zip(edges[::2], edges[1::2], strict=True)]


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
SMOOTHED = 0.05
"""Of the frequency of the energy period: width of the bands a record's spectrum is averaged over."""
STANDARD_GRAVITY = 9.81
STEEPEST = 0.1
"""Largest possible steepness, Hs over g Te^2/(2 pi): waves as high as a seventh of their length break [-]."""
HIGHEST_SEA = 40.0
"""Largest possible Hs [m]."""


def impossible(hs: Any, te: Any) -> Any:
    """Return whether seas are steeper or higher than possible, of numbers or arrays; many of them mean wrong units."""
    return (2 * math.pi * hs > STEEPEST * STANDARD_GRAVITY * te**2) | (hs > HIGHEST_SEA)


class Samples(SeaFile):
    """Elevations [m] at the buoy's axis at equal steps of time [s], as a sum of harmonics of their own length.

    Still water is the mean of the record. The harmonics a_k = conj(2 X_k/N), X the discrete Fourier transform of the N
    samples, have frequencies 2 pi k/(N step), and Re sum_k a_k exp(-i omega_k t) passes through every sample.
    """

    KEYS: ClassVar = {
        "step": Key("s", "0.5", "time between samples"),
        "elevation": Key("m", str([0.1, -0.2] * 16), "elevation at each instant, from the start of the run"),
        "notes": Key("", "['columns left out: wind']", "what its file holds beside, and how it was read"),
    }
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
    def phasors(self) -> ComplexArray:
        """Complex amplitudes of the harmonics (harmonic,) [m]."""
        import numpy as np

        count = len(self.elevation)
        found = 2 * np.conj(np.fft.rfft(self.elevation)[1:]) / count
        if count % 2 == 0:
            found[-1] /= 2  # of two samples a period: it and its mirror image are the same
        return np.asarray(found)

    @cached_property
    def omega(self) -> FloatArray:
        """Frequencies of the harmonics (harmonic,) [rad/s]."""
        import numpy as np

        return np.asarray(2 * np.pi / self.length * np.arange(1, len(self.phasors) + 1))

    @cached_property
    def variances(self) -> FloatArray:
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


def read_record(path: Path, where: str, repair: Collection[str] = (), accept: Collection[str] = ()) -> dict[str, Any]:
    """Return step [s], elevations [m] and notes of a file of two columns, time and elevation.

    Times are in seconds, another unit that the file states, or dates; elevations in metres or a unit that it states:
    see `vsb.tools.columns.read_columns`. Raises `ConfigError` if it cannot be read, a row is not two numbers, or of a
    fault of the sensor that is neither repaired nor accepted: see `vsb.engine.waves.records`.

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


class RecordedSea(SeaOfFile):
    """A sea that was measured: elevations at the buoy's axis, of which a run follows the beginning.

    Faults of the sensor are repaired or accepted as the file is read: what was done stands in the notes of the file.
    """

    KEYS: ClassVar = {
        "kind": Key("", "record", "measured elevations, from the beginning of the record"),
        "file": Key(
            "",
            "elevation.csv",
            "file of two columns, time in equal steps and elevation at the buoy's axis, in s and m or as their header "
            "says; or step and elevation",
        ),
        "repair": Key(
            "",
            "[spikes, drift]",
            "faults of the sensor that are repaired: gaps, times, spikes, steps of the level, drift",
        ),
        "accept": Key("", "[steps]", "what looks like spikes, steps, stuck or drift, but is of the sea"),
    }
    drawn: ClassVar[Literal[False]] = False
    recorded: ClassVar[Literal[True]] = True
    even_components: ClassVar[bool] = False
    kind: Literal["record"]
    repair: tuple[Repairable, ...] = Field((), exclude=True)
    accept: tuple[Acceptable, ...] = Field((), exclude=True)
    file: Samples

    @field_validator("file", mode="before", json_schema_input_type=str | Samples)
    @classmethod
    def _read(cls, value: Any, info: ValidationInfo) -> Any:
        """A path stands for the file there."""
        if not isinstance(value, str | Path):
            return value
        return read_record(Path(value), "file", info.data.get("repair", ()), info.data.get("accept", ()))

    @property
    def amplitudes(self) -> Literal["fixed"]:  # type: ignore[override]
        """Those of the record: nothing is drawn."""
        return "fixed"

    @property
    def words(self) -> str:
        """The record in words."""
        return f"a record of {self.file.length:g} s of {self._size_in_words}"

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad], averaged over bands of `SMOOTHED`."""
        width = SMOOTHED * self.omega
        return self.variances(omega - width / 2, omega + width / 2) / width

    def variances(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the variance of the elevation in bands between frequencies [rad/s], shape (band,) [m^2].

        Each harmonic stands for the band of frequencies nearest to it, and is cut with it.
        """
        edges = 2 * math.pi / self.file.length * (np.arange(len(self.file.omega) + 1) + 0.5)
        below = np.concatenate([[0.0], np.cumsum(self.file.variances)])
        return np.asarray(np.interp(high, edges, below) - np.interp(low, edges, below))

    def bands(self) -> tuple[FloatArray, FloatArray]:
        """Return frequencies [rad/s] and variances [m^2] of its harmonics."""
        return self.file.omega, self.file.variances

    def realisation(self, omega_max: float = math.inf, duration: float = 0.0) -> Sea:
        """Return the harmonics up to a frequency [rad/s]; with all of them the elevation is the record."""
        kept = self.file.omega <= omega_max + 1e-9
        return Sea(self.file.omega[kept], self.file.phasors[kept])
