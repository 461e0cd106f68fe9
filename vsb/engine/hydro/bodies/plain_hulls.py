"""Hulls that a body file names: a mesh file and how it is placed, or a sphere, cylinder, capsule or box. Pure Python.

`vsb.engine.hydro.bodies.hulls` meshes them.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from vsb.keys.quantities import Brief, Number, Positive, Section
from vsb.tools.units import parsed_unit


class PlacedMesh(Brief):
    """A mesh file: its unit of length, or what its lengths are multiplied by to be metres, and how the hull lies."""

    BRIEF = ("scale", "unit", "up", "draft")
    file: str
    scale: Positive = 1.0
    unit: Literal["m", "mm", "cm", "km", "in", "ft"] = "m"
    up: Literal["x", "y", "z", "-x", "-y", "-z"] = "z"  # axis of the file that points upwards
    draft: Positive | None = None  # depth of the lowest point below still water [m]; none: as the file has it

    @model_validator(mode="after")
    def _one_of_them(self) -> Self:
        if self.scale != 1 and self.unit != "m":
            raise ValueError(f"unit: received {self.unit} and scale {self.scale:g}; needs one of them")
        return self

    @property
    def metres(self) -> float:
        """Length of the unit of the file [m]."""
        return self.scale * float(parsed_unit(self.unit).factor)


class Hull(Section):
    """A plain hull on the z axis whose lowest point lies `draft` [m] below still water, in panels of a size [m]."""

    draft: Positive
    panel: Annotated[Number, Field(ge=1e-3)]


class SphereHull(Hull):
    """A sphere."""

    kind: Literal["sphere"]
    radius: Positive

    @property
    def height(self) -> float:
        """From the lowest point to the highest [m]."""
        return 2 * self.radius


class CylinderHull(Hull):
    """An upright cylinder."""

    kind: Literal["cylinder"]
    radius: Positive
    height: Positive


class CapsuleHull(Hull):
    """An upright cylinder between two hemispheres, of a height over all."""

    kind: Literal["capsule"]
    radius: Positive
    height: Positive

    @model_validator(mode="after")
    def _with_ends(self) -> Self:
        if self.height < 2 * self.radius:
            raise ValueError(f"height {self.height:g} m: needs at least that of its two ends, {2 * self.radius:g} m")
        return self


class BoxHull(Hull):
    """A box, its length along x, its width along y."""

    kind: Literal["box"]
    length: Positive
    width: Positive
    height: Positive
