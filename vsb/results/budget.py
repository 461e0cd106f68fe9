"""The error budget of a published number: every known source of error, and the interval they give together.

Bounds add linearly: nothing is known of their signs. Statistical half-widths add in quadrature: they are independent.
Both together add linearly.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, NamedTuple, Self

import numpy as np
import xarray as xr

from vsb.engine.waves.climate import Climate
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.seas import Sea
from vsb.errors import VsbError
from vsb.models.floating_system import BuoyOfShape, Floating
from vsb.models.mode_convergence import (
    SAMPLED,
    SOLVED_EACH,
    ModeConvergence,
    by_all_modes,
    directed,
    mean_sea,
    reach_of_modes,
    take_offs,
)
from vsb.models.rest import has_attachment_modes
from vsb.study.resolution import expected_change, line_change, loaded_at_ring
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

Kind = Literal["bound", "statistic"]
Rows = Sequence[Mapping[str, Any]]
"""A budget as JSON has it."""
MODES = "modes left out"
"""Name of the source of error by shell modes that the basis of a study leaves out."""
NUMERICAL = "time step of the controller"
"""Of that by the frequencies and time step of a causal controller."""


@dataclass(frozen=True)
class Source:
    """One source of error of a number, in the number's own unit.

    Raises `VsbError` if its range is not finite, or does not hold zero: the number itself must lie in its interval.
    """

    name: str
    low: float  # at most 0: how far the true value may lie below the number
    high: float  # at least 0
    kind: Kind = "bound"
    shared: bool = False  # whether all designs share it: of a gain only what does not cancel is left

    def __post_init__(self) -> None:
        """Check the range."""
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low <= 0.0 <= self.high):
            raise VsbError(
                f"error budget: {self.name}: received {self.low:g} to {self.high:g}, needs a finite range about zero"
            )

    @classmethod
    def within(cls, name: str, half_width: float, kind: Kind = "bound", *, shared: bool = False) -> Self:
        """Return a source of the same size to both sides, as of a share of a number, which may be below 0."""
        return cls(name, 0.0 - abs(half_width), abs(half_width), kind, shared)

    @classmethod
    def towards(cls, name: str, change: float) -> Self:
        """Return a one-sided source: the true value lies between the number and the number plus a change."""
        return cls(name, min(0.0, change), max(0.0, change))


@dataclass(frozen=True)
class Budget:
    """All known sources of error of one number."""

    sources: tuple[Source, ...] = ()

    @classmethod
    def of(cls, rows: Iterable[Mapping[str, Any]]) -> Self:
        """Return a budget from its `rows`."""
        return cls(tuple(Source(**row) for row in rows))

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Its sources as mappings, for JSON."""
        return [asdict(source) for source in self.sources]

    @property
    def low(self) -> float:
        """Largest distance of the true value below the number, at most 0."""
        return -_together([-source.low for source in self._of("bound")], [-s.low for s in self._of("statistic")])

    @property
    def high(self) -> float:
        """Largest distance above it, at least 0."""
        return _together([source.high for source in self._of("bound")], [s.high for s in self._of("statistic")])

    def interval(self, value: float) -> tuple[float, float]:
        """Return the interval about a value."""
        return value + self.low, value + self.high

    def scaled(self, factor: float) -> "Budget":
        """Return the budget in another unit, `factor` > 0 of them to one."""
        return Budget(tuple(Source(s.name, factor * s.low, factor * s.high, s.kind, s.shared) for s in self.sources))

    def __add__(self, other: "Budget") -> "Budget":
        """Both together."""
        return Budget((*self.sources, *other.sources))

    def _of(self, kind: Kind) -> list[Source]:
        """Sources of a kind."""
        return [source for source in self.sources if source.kind == kind]


def _together(bounds: Sequence[float], statistics: Sequence[float]) -> float:
    """Bounds linearly, statistics in quadrature, both linearly."""
    return math.fsum(bounds) + math.hypot(*statistics)


def mean_budget(budgets: Sequence[Budget]) -> Budget:
    """Return the budget of the mean of numbers, as of the realisations of a sea.

    Their bounds have the same cause and do not average out; their statistics are independent.
    """
    found: dict[tuple[str, Kind, bool], list[Source]] = {}
    for budget in budgets:
        for source in budget.sources:
            found.setdefault((source.name, source.kind, source.shared), []).append(source)
    count, sources = len(budgets), []
    for (name, kind, shared), some in found.items():
        total = math.fsum if kind == "bound" else lambda values: math.hypot(*values)
        low, high = (total([abs(getattr(one, end)) for one in some]) / count for end in ("low", "high"))
        sources.append(Source(name, -low, high, kind, shared))
    return Budget(tuple(sources))


# shell modes that a study leaves out: of powers and gains, in every sea and over a year -----------------------------

SCATTER = 2.0
"""Of powers of two degrees that do not share their water, over the tolerance of each [-]."""
ENDS = ("low", "high")
"""Of a range about zero: the value with all modes less the one computed."""


def modes_left_out(
    study: Study, seas: Sequence[tuple[Wave, Sea]], families: Sequence[int] | None = None, *, wet: bool = False
) -> xr.Dataset:
    """Return how far powers and gains may lie from those of a shell with all its modes.

    Parameters
    ----------
    seas : sequence of (Wave, Sea)
        Without still water.
    families : sequence of int, optional
        One sea of each, by index, that the damper for all seas is tuned to; by default all.
    wet : bool
        Whether shapes beside loaded rings move water.

    Returns
    -------
    xarray.Dataset
        `power(design, wave, take_off, end)`, of the mean power [-], and `gain(design, wave, take_off, end)`, of the
        gain over the reference design [percentage points], `end` as `ENDS`, `take_off` as of
        `vsb.models.mode_convergence.take_offs`; empty of a rigid buoy, or without seas.

    Notes
    -----
    The change from the basis of the study to the full basis of twice the degree that is enough for the tolerance, and
    for all further degrees the span of powers up to there: they change less where errors fall like 1/degree or faster.
    They fall like its power of 1.4 or, where a load acts at a ring of the shell, unevenly: there changes may be small
    by chance, and count at least what is to be expected (`vsb.study.resolution.expected_change`), and further degrees
    may count for more than those compared (`vsb.study.resolution.line_change`).
    """
    if not study.has_shell or not seas:
        return xr.Dataset()
    directions = tuple(directed(wave, sea) for wave, sea in seas)
    found = _left_out(ModeConvergence(study, directions, families, wet=wet))
    dims = ("design", "wave", "take_off", "end")
    coords = {
        "design": list(study.designs),
        "wave": [wave.label for wave, _ in seas],
        "take_off": list(take_offs(study.pto)),
        "end": list(ENDS),
    }
    return xr.Dataset({name: (dims, values) for name, values in found._asdict().items()}, coords)


class LeftOut(NamedTuple):
    """Errors of mean powers and of their gains by shell modes left out, the last dimension as `ENDS`."""

    power: FloatArray  # relative [-]
    gain: FloatArray  # over the reference, 0 without one [percentage points]


def left_out_of_year(study: Study, floating: Floating, climate: Climate) -> LeftOut:
    """Return how far a year's mean power and its gain may lie from those of a shell with all its modes.

    Parameters
    ----------
    study : Study
        Of viable designs.
    floating : Floating
        What floats in it; a body has the modes of its files, and leaves out no others that are known.

    Returns
    -------
    LeftOut
        Shape (design, end), the wider of the damper given and the optimal one; 0 of what has no shell modes of this
        project.

    Notes
    -----
    As in `modes_left_out`, in the mean spectrum of the year, from which its mean power follows.
    """
    if not isinstance(floating, BuoyOfShape) or not floating.study.flexible:
        return LeftOut(*np.zeros((2, len(study.designs), len(ENDS))))
    buoy = floating.study
    found = _left_out(
        ModeConvergence(
            buoy, [mean_sea(climate, buoy.hydro.omega_max)], judged=True, wet=floating.swept.clamps is not None
        )
    )
    widest = [np.stack([one[:, 0, :, 0].min(axis=1), one[:, 0, :, 1].max(axis=1)], axis=-1) for one in found]
    return LeftOut(*widest)


def _left_out(convergence: ModeConvergence) -> LeftOut:
    """The same of every sea and take-off, (design, sea, take-off, end)."""
    study, finer = convergence.study, convergence.compared
    own = study.modes.basis == "full" and study.modes.max_degree == convergence.enough < convergence.finer
    before = finer[0] if own else convergence.powers(study.modes, convergence.finer)
    at_ring = np.array([_uneven(convergence, design) for design in study.designs])
    share = expected_change(study, convergence.enough, wet=convergence.wet) * at_ring
    if study.at_equilibrium:  # each degree has its own water
        share = np.maximum(share, SCATTER * SOLVED_EACH)
    expected = share[:, None, None] * before
    if has_attachment_modes(study):
        far = np.where(at_ring, _beyond(convergence), 1.0)
    else:
        far = np.array([reach_of_modes(study, one, convergence.finer) for one in study.designs])
    if 0 < convergence.finer - convergence.enough < convergence.enough:  # errors like 1/degree
        far = far * convergence.enough / (convergence.finer - convergence.enough)
    reach = SAMPLED + far[:, None, None]
    power = _relative(by_all_modes(before, finer, reach, expected), before)
    gain = np.zeros_like(power)
    if not study.at_equilibrium:  # else the shape at rest depends on the modes, too
        power[[i for i, design in enumerate(study.designs.values()) if not design.flexible]] = 0.0
    if (reference := study.reference_design) is not None:
        at = list(study.designs).index(reference)
        base = before[[at]]
        points = np.divide(100 * expected, base, out=np.zeros_like(before), where=base > 0)
        gain = by_all_modes(_gains(before, at), [_gains(one, at) for one in finer], reach, points)
        gain[at] = 0.0  # over itself
    return LeftOut(power, gain)


def _uneven(convergence: ModeConvergence, design: str) -> bool:
    """Whether powers approach their limit unevenly: under loads at rings, but for ports whose modes see the water."""
    study = convergence.study
    if convergence.wet and not study.designs[design].clamp and study.pto.held is None:
        return False
    return loaded_at_ring(study, design)


def _beyond(convergence: ModeConvergence) -> float:
    """What degrees beyond the finest change beside loaded rings, over what those up to there do, at least 1 [-].

    In water each yields otherwise than its attachment modes say, by shares of `line_change`: a thin stiff wall has few
    degrees in its basis of all that yield.
    """
    study, last = convergence.study, convergence.finer
    first = convergence.enough if last > convergence.enough else last // 2
    before, left = (line_change(study, degree) for degree in (first, last))
    return max(1.0, left / (before - left)) if left > 0 else 1.0  # all degrees that yield are in both


def _gains(power: FloatArray, at: int) -> FloatArray:
    """Gains over one of the designs, of powers (design, sea, take-off) [percentage points]; 0 over no power."""
    base = np.broadcast_to(power[[at]], power.shape)
    return np.divide(100 * (power - base), base, out=np.zeros_like(power), where=base > 0)


def _relative(bounds: FloatArray, size: FloatArray) -> FloatArray:
    """Bounds (..., end) in terms of powers (...); 0 of no power."""
    there = np.broadcast_to((size > 0)[..., None], bounds.shape)
    return np.divide(bounds, size[..., None], out=np.zeros_like(bounds), where=there)
