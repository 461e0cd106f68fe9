"""The take-off of a study: what it acts on, and by which law.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

from typing import Annotated, Literal

from pydantic import Discriminator, Field, Tag, field_validator

from vsb.study.quantities import NonNegative, Number, Section, within

Colatitude = Annotated[Number, Field(ge=0, le=180)]


class ShellPort(Section):
    """Port at a ring of the shell: its colatitude [degrees], the direction it moves in, what the take-off stands on.

    Against the `frame`, sphere centre and ballast, the heave of the whole buoy does not count.
    """

    colatitude: Colatitude
    direction: Literal["vertical", "radial"] = "vertical"
    against: Literal["sea_bed", "frame"] = "sea_bed"


class BetweenPort(Section):
    """Port between two points of one meridian of the shell, colatitudes [degrees], along the line that joins them."""

    between: tuple[Colatitude, Colatitude]

    @field_validator("between")
    @classmethod
    def _apart(cls, value: tuple[float, float]) -> tuple[float, float]:
        if value[0] == value[1]:
            raise ValueError("needs two different colatitudes")
        return value


def _port_kind(value: object) -> str:
    """Which kind of port is meant, by its form."""
    if isinstance(value, dict | Section):
        return "between" if "between" in dict(value) else "shell"
    return "name"


PortChoice = Annotated[
    Annotated[Literal["heave", "volume"], Tag("name")]
    | Annotated[ShellPort, Tag("shell")]
    | Annotated[BetweenPort, Tag("between")],
    Discriminator(_port_kind),
]
"""What the take-off acts on: heave against the sea bed, the enclosed volume (pressure against flow), or the shell."""


class Pto(Section):
    """Linear power take-off: damping [N s/m] between the heaving plate and the sea bed."""

    damping: Annotated[
        NonNegative, within(0.0, 1e12, "N s/m", "a take-off that holds a ship still does not take off")
    ] = 8000.0
