"""Faults of sensors in records of elevation: named with their time, repaired only where a study asks for it.

Spikes and steps are jumps many times those around them; a stuck sensor repeats a number for half a wave or more; drift
is what changes more slowly than waves do. A wave that only looks like one of these can be accepted.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

from vsb.errors import ConfigError

if TYPE_CHECKING:
    from vsb.tools.arrays import FloatArray, IntArray

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
    time: "FloatArray"
    elevation: "FloatArray"
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
    import numpy as np

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
    import numpy as np

    even = np.linspace(record.time[0], record.time[-1], len(record.time))
    off = np.abs(record.time - even)
    if off.max() <= record.tolerance:
        return replace(record, time=even)
    from scipy.interpolate import CubicSpline

    record, _ = _report(record, "times", np.flatnonzero(off > record.tolerance).tolist())
    return replace(record, time=even, elevation=CubicSpline(record.time, record.elevation)(even))


def _smooth(record: Record) -> Record:
    """Take out jumps that no wave makes, there and back or for good, or report them."""
    import numpy as np

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


def _levelled(record: Record, steps: Sequence[int]) -> "FloatArray":
    """Elevations without steps: each jump but for those beside it, or by a fit of all where that is closer.

    The fit is of a straight line and the steps; waves of period T and deviation s change it by s T/(pi length).
    """
    import numpy as np

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


def _around(size: "FloatArray", i: int) -> float:
    """Jumps around one that nine of ten do not exceed; those next to it may be of the same fault."""
    import numpy as np

    near = np.r_[max(i - WINDOW, 0) : max(i - BESIDE, 0), min(i + BESIDE + 1, len(size)) : min(i + WINDOW, len(size))]
    return float(np.quantile(size[near], 0.9)) if len(near) else math.inf


def _return(elevation: "FloatArray", i: int, around: float) -> int | None:
    """Last sample of a spike that begins with a jump: the next one is about where it began; None of a step."""
    jump = abs(float(elevation[i + 1] - elevation[i]))
    longest = min(LONGEST_SPIKE, max(2, int(0.5 * jump / around) if around else LONGEST_SPIKE))
    for last in range(i + 1, min(i + 1 + longest, len(elevation) - 1)):
        if abs(float(elevation[last + 1] - elevation[i])) < 0.5 * jump:
            return last
    return len(elevation) - 1 if i + 2 >= len(elevation) - 1 else None


def _not_stuck(record: Record) -> Record:
    """Report where a value stays the same for half a wave, but for still water before and after waves."""
    import numpy as np

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
    import numpy as np

    slow = _slow(record.elevation, record.step)
    waves = record.elevation - slow
    crossings = int(((waves[:-1] < 0) & (waves[1:] >= 0)).sum())
    share = float(np.var(slow) / np.var(record.elevation)) if np.ptp(record.elevation) else 0.0
    if crossings < 3 or share <= max(DRIFT, 2 / crossings**2):
        return record
    what = f"drift of {np.ptp(slow):.3g} m, {100 * share:.3g} % of the variance, largest"
    record, asked = record.reported("drift", what, [int(np.abs(slow - slow.mean()).argmax())])
    return replace(record, elevation=waves) if asked else record


def _slow(elevation: "FloatArray", step: float) -> "FloatArray":
    """The part of a record slower than waves: a straight line, and cosines of longer periods about it."""
    import numpy as np
    from scipy.fft import dct, idct

    time = np.arange(len(elevation))
    line = np.polyval(np.polyfit(time, elevation, 1), time)
    parts = dct(elevation - line, norm="ortho")
    parts[int(2 * len(elevation) * step / SLOWEST) + 1 :] = 0.0  # the k-th has k half periods in the record
    return np.asarray(line + idct(parts, norm="ortho"))


def _interpolated(time: "FloatArray", elevation: "FloatArray", bad: "FloatArray") -> "FloatArray":
    """Elevations with cubic splines through the good ones in place of the bad."""
    import numpy as np
    from scipy.interpolate import CubicSpline

    good = ~np.asarray(bad, dtype=bool)
    spline = CubicSpline(time[good], elevation[good])
    inside = np.clip(time, time[good][0], time[good][-1])
    return np.where(good, elevation, spline(inside))


def _runs(there: "FloatArray") -> "list[tuple[int, int]]":
    """First and last places of runs of true values."""
    import numpy as np

    edges: IntArray = np.flatnonzero(np.diff(np.r_[0, np.asarray(there, dtype=int), 0]))
    return [(int(first), int(last) - 1) for first, last in zip(edges[::2], edges[1::2], strict=True)]
