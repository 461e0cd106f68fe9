"""What a campaign may ask of a year: tunings, and beyond linear theory optima within limits, runs in time."""

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field

from vsb.study.quantities import Count, Number, Section

Tunings = Literal["fixed", "one", "each", "constrained"]
"""Damper as given, the best one of the year, the best one of each sea; the best force of any kind within limits."""
CONSTRAINED: Literal["constrained"] = "constrained"
LEADING: tuple[Tunings, ...] = ("one", "each", "fixed", "constrained")
"""Tunings by what a campaign's answer is told at, if it has them."""


def leading_tuning(tunings: Sequence[str]) -> Tunings:
    """Return the tuning a campaign's answer is told at."""
    return next(name for name in LEADING if name in tunings)


IN_TIME = {"body_exact": "body_exact", "linear": "in_time"}
"""Model of runs in time -> begin of the names of what they say of a year: linear runs see what linear theory does not,
as a take-off that switches."""


POWER_IN_TIME = ("mean_power", "power_low", "power_high")
GAIN_IN_TIME = ("gain_percent", "gain_low", "gain_high")
"""What runs in time say of a year, after that begin: values with their 95 % intervals."""


class Constrained(Section):
    """Budget of the optima within limits of each design at each point [s], and the seed of their waves."""

    seconds: Annotated[Number, Field(gt=0, le=86400)] = 10.0
    seed: Annotated[Count, Field(ge=0, lt=2**32)] = 1


class Verify(Section):
    """Seas of the year to be simulated in time, two of each stratum of its energy; seed of the draw."""

    seas: Annotated[Count, Field(ge=4, le=1000, multiple_of=2)] = 24
    model: Literal["linear", "body_exact"] = "body_exact"
    seed: Annotated[Count, Field(ge=0, lt=2**32)] = 1
