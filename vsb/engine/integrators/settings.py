"""How a run in time is made: its section in a study, and how much of it is recorded."""

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from vsb.keys.quantities import Finite, NonNegative, Number, Positive, Section, within


class Simulation(Section):
    """Time-domain run: duration [s], window of the statistics [s], initial heave [m] and heave velocity [m/s].

    With a duration alone the window is its last third.
    """

    duration: Annotated[Positive, within(1e-3, 2e5, "s", "a sea state does not last two days")] = 60.0
    window: tuple[NonNegative, Positive] = (40.0, 60.0)
    initial_position: Annotated[Finite, within(-1e4, 1e4, "m", "a buoy starts near the surface")] = 0.0
    initial_velocity: Annotated[Finite, within(-1e3, 1e3, "m/s", "this is faster than sound in air")] = 0.0
    tolerance: Annotated[Number, Field(ge=1e-12, le=0.1)] = 1e-6
    method: Literal["auto", "exact", "convolution", "exponential"] = "auto"

    @model_validator(mode="after")
    def _window_inside(self) -> Self:
        if "window" not in self.model_fields_set:
            object.__setattr__(self, "window", (2 * self.duration / 3, self.duration))
        start, end = self.window
        if not start < end <= self.duration:
            raise ValueError(f"window {list(self.window)}: needs 0 <= start < end <= duration = {self.duration:g} s")
        return self


RECORDS_PER_PERIOD = 200
"""Instants recorded per period of the shortest wave that matters."""


LEG = 2**17
"""Instants followed at one time."""


KEPT, THINNEST = 2**17, 10
"""A run of more instants than that keeps a part of them, a tenth at least: 20 a period."""


def thinning(instants: int) -> int:
    """Return every how many instants a run of so many is recorded."""
    return min(THINNEST, math.ceil(instants / KEPT))
