"""The sea without its waves."""

import math
from typing import Annotated

from pydantic import Field, field_validator

from vsb.keys.quantities import Number, Positive, Section, within

DEEPEST = 2e4
"""No sea is deeper [m]."""


class Water(Section):
    """Density [kg/m^3], depth [m] (`.inf` for deep water), gravity [m/s^2]."""

    density: Annotated[Positive, within(1.0, 2e4, "kg/m^3", "mercury has 13 534 kg/m^3")] = 1025.0
    depth: Annotated[Number, Field(gt=0)] = math.inf
    gravity: Annotated[Positive, within(0.01, 300.0, "m/s^2", "the sun has 274 m/s^2")] = 9.81

    @field_validator("depth")
    @classmethod
    def _on_earth(cls, value: float) -> float:
        if DEEPEST < value < math.inf:
            raise ValueError(f"needs at most {DEEPEST:g} m, or .inf for deep water")
        return value
