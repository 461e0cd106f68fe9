"""A body file: a mesh, the displacements it can make, and what is solved of them. Pure Python."""

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from vsb.study.blocks import LEAST_DEPTH_IN_WAVENUMBERS
from vsb.study.quantities import Count, Name, Number, Section
from vsb.study.sections import Water

PHYSICS = 4
"""Hand-bumped version of the physics behind a block."""
Frequency = Annotated[Number, Field(ge=1e-3, le=1e3)]
"""Frequencies of gravity waves on Earth, tsunamis and ripples among them [rad/s]."""
Direction = Annotated[Number, Field(ge=-360, le=360)]


class BodyFile(Section):
    """A body file: mesh, modes, water, frequencies [rad/s], wave directions [degrees], symmetry and lid.

    Paths count from the folder of the file. Symmetry `auto` is what the panels have. `lid` is the largest number
    of panels on the water inside between the middle and the waterline; without it (0) coefficients at irregular
    frequencies are wrong. Below them there is none.
    With a `tolerance` [-] of interpolation only as many of the frequencies are solved as it asks for, without all.
    """

    body: Name
    mesh: str
    modes: str
    water: Water = Water()
    omega: tuple[Frequency, ...]
    wave_direction: tuple[Direction, ...] = (0.0,)
    symmetry: Literal["auto", "none", "xOz", "yOz", "xOz+yOz"] = "auto"
    lid: Annotated[Count, Field(ge=0, le=64)] = 8
    tolerance: Annotated[Number, Field(ge=1e-5, le=0.1)] | None = None

    @model_validator(mode="after")
    def _usable(self) -> Self:
        for name, values in (("omega", self.omega), ("wave_direction", self.wave_direction)):
            if not values or list(values) != sorted(set(values)):
                raise ValueError(f"{name} {list(values)}: needs at least one value, ascending without repetition")
        kd, water = LEAST_DEPTH_IN_WAVENUMBERS, self.water
        lowest = math.sqrt(kd * math.tanh(kd) * water.gravity / water.depth)
        if self.omega[0] < lowest:
            raise ValueError(
                f"omega {self.omega[0]:g} rad/s: in {water.depth:g} m of water needs at least {lowest:.4g}"
            )
        return self
