"""Records of the sea's elevation: read from a file, and as sums of harmonics of their own length.

Imports nothing heavy unless there is a record: the Snakefile reads a study at every parse.
"""

import math
import re
import zlib
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Field, model_validator

from vsb.errors import ConfigError
from vsb.study.quantities import Positive, Section, content_id
from vsb.tools.bounded import read_unpacked
from vsb.tools.words import shortened

if TYPE_CHECKING:
    from vsb.tools.arrays import ComplexArray, FloatArray

FEWEST, MOST = 32, 2**17
"""Samples of a record."""
HIGHEST = 50.0
"""Largest elevation [m]; missing values are often written as 99 or 999."""
UNEVEN = 1e-6
"""Largest deviation of an instant from equal steps, in steps and at least in seconds."""
TAIL = 0.005
"""Share of the variance that lies below the lowest frequency a record needs solved [-]."""
LEFT_OUT = 0.01
"""Largest share of the variance of a record that may lie outside the band solved [-]."""


class Samples(Section):
    """Elevations [m] at the buoy's axis at equal steps of time [s], as a sum of harmonics of their own length.

    Still water is the mean of the record. The harmonics a_k = conj(2 X_k/N), X the discrete Fourier transform of the N
    samples, have frequencies 2 pi k/(N step), and Re sum_k a_k exp(-i omega_k t) passes through every sample.
    """

    step: Positive
    elevation: Annotated[
        tuple[Annotated[float, Field(ge=-HIGHEST, le=HIGHEST)], ...], Field(min_length=FEWEST, max_length=MOST)
    ]

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
        return content_id(self)[:8]


def read_record(path: Path, where: str) -> dict[str, Any]:
    """Return step [s] and elevations [m] of a file of two columns, time [s] and elevation [m].

    Columns are separated by commas, semicolons or blanks; a line of their names may stand first, and lines that begin
    with # are left out. The file may be packed with gzip. Raises `ConfigError` if it cannot be read, a row is not two
    numbers, or the instants are not equally spaced.

    Parameters
    ----------
    where : str
        Place in the study, for messages about the file as a whole.
    """
    rows = text_rows(path, where, "two columns, time [s] and elevation [m]")
    known: list[tuple[int, float, float]] = []
    for i, (n, words) in enumerate(rows):
        try:
            time, elevation = map(float, words)
        except ValueError:
            if i == 0:
                continue  # names of the columns
            raise ConfigError(
                f"{path}:{n}: received {shortened(repr(' '.join(words)))}, needs two numbers, time [s] and "
                "elevation [m]"
            ) from None
        if not (math.isfinite(time) and abs(elevation) <= HIGHEST):
            raise ConfigError(
                f"{path}:{n}: elevation: received {elevation:g} m at {time:g} s, needs at most {HIGHEST:g} m: missing "
                "values must be filled before, or the record cut"
            )
        known.append((n, time, elevation))
    if not FEWEST <= len(known) <= MOST:
        raise ConfigError(f"{where}: received {len(known)} samples in {path.name}, needs {FEWEST} to {MOST}")
    return {"step": _step(path, known), "elevation": [elevation for _, _, elevation in known]}


def text_rows(path: Path, where: str, needed: str) -> list[tuple[int, list[str]]]:
    """Return the lines of a text file, packed with gzip or not, each its number and its words.

    Words are separated by commas, semicolons or blanks; empty lines and those that begin with # are left out.
    Raises `ConfigError` with the place in a study and what is needed if the file cannot be read.
    """
    try:
        lines = read_unpacked(path).decode("utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError, EOFError, zlib.error) as error:
        reason = (isinstance(error, OSError) and error.strerror) or "it is no text"
        raise ConfigError(
            f"{where}: received {path.name}, which cannot be read ({reason}); needs a text file of {needed}"
        ) from None
    return [
        (n, re.split(r"\s*[,;]\s*|\s+", line.strip()))
        for n, line in enumerate(lines, 1)
        if line.strip() and line.strip()[0] != "#"
    ]


def _step(path: Path, known: list[tuple[int, float, float]]) -> float:
    """The step of equally spaced instants, else `ConfigError`."""
    times = [time for _, time, _ in known]
    usual = sorted(later - earlier for earlier, later in pairwise(times))[len(times) // 2]
    allowed = UNEVEN * max(1.0, abs(usual))
    for (_, before, _), (n, time, _) in pairwise(known):
        if not (usual > 0 and abs(time - before - usual) <= 2 * allowed):
            raise ConfigError(
                f"{path}:{n}: time: received {time:.9g} s after {before:.9g} s, needs equal steps, here of {usual:.6g} "
                "s throughout: gaps must be filled before, or the record cut"
            )
    step = (times[-1] - times[0]) / (len(times) - 1)
    uneven = max(abs(time - times[0] - i * step) for i, time in enumerate(times))
    if uneven > allowed:
        raise ConfigError(
            f"{path}: time: received steps that differ, by up to {uneven:.2g} s in all; needs equal steps"
        )
    return step
