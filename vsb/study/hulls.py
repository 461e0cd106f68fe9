"""Hulls that a body file may name instead of a mesh file: sphere, cylinder, capsule, box. Pure Python.

`vsb.hydro.bodies.hulls` meshes them.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from vsb.study.quantities import Number, Positive, Section


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
