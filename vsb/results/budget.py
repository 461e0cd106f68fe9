"""The error budget of a published number: every known source of error, and the interval they give together.

Bounds add linearly: nothing is known of their signs. Statistical half-widths add in quadrature: they are independent.
Both together add linearly.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, Self

from vsb.errors import VsbError

Kind = Literal["bound", "statistic"]
Rows = Sequence[Mapping[str, Any]]
"""A budget as JSON has it."""
MODES = "modes left out"
"""Name of the source of error by shell modes that the basis of a study leaves out."""


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
    def towards(cls, name: str, change: float, kind: Kind = "bound", *, shared: bool = False) -> Self:
        """Return a one-sided source: the true value lies between the number and the number plus a change."""
        return cls(name, min(0.0, change), max(0.0, change), kind, shared)


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
