"""Quadratic drag in a study: coefficients and areas, of a buoy's rigid motions and of a body's motions. Pure Python.

`vsb.models.drag` makes forces of them, `vsb.engine.motion.drag` what linear theory sees.
"""

from collections.abc import Mapping
from typing import Annotated, Self

from pydantic import Field, model_validator

from vsb.engine.motion.take_off import Pto
from vsb.keys.quantities import Name, NonNegative, Positive, Section, within

Coefficient = Annotated[NonNegative, within(0.0, 100.0, "", "this exceeds any shape")]


class Plate(Section):
    """Quadratic drag rho C A |u| u/2 on one direction: coefficient C [-] and reference area A [m^2]."""

    coefficient: Coefficient
    area: Positive


class Vane(Plate):
    """Quadratic drag on a rotation: that of a plate at a distance from the sphere's centre [m], rho C A l^3 |w| w/2."""

    lever: Positive


BodyDrag = Annotated[dict[Name, Vane | Plate], Field(min_length=1)]
"""Quadratic drag on degrees of freedom of a body, by name; of the body's velocity alone, the waves' flow left out."""


class Drag(Section):
    """Quadratic drag on the buoy's rigid motion past the water, whose flow is that of the undisturbed waves."""

    surge: Plate | None = None
    sway: Plate | None = None
    heave: Plate | None = None
    roll: Vane | None = None
    pitch: Vane | None = None
    yaw: Vane | None = None

    @model_validator(mode="after")
    def _acts(self) -> Self:
        if not self.directions:
            raise ValueError(f"needs one of {', '.join(type(self).model_fields)}")
        return self

    @property
    def plates(self) -> Mapping[str, Plate]:
        """What brakes each degree of freedom it acts on."""
        return {name.capitalize(): plate for name, plate in self.directions.items()}

    @property
    def directions(self) -> Mapping[str, Plate]:
        """The rigid motions it acts on, by name."""
        return {name: plate for name in type(self).model_fields if isinstance(plate := getattr(self, name), Plate)}


def check_followed(model: str, method: str, pto: Pto) -> None:
    """Check that the hydrodynamic model, the method in time and the take-off of a study can follow a drag.

    Raises `ValueError`.
    """
    if model not in ("linear", "body_exact"):
        raise ValueError(f"drag: hydro.model {model!r} knows none; needs linear or body_exact")
    if pto.nonlinear:
        raise ValueError(
            f"drag: cannot be followed beside a nonlinear take-off, received law {pto.law} with force_limit "
            f"{pto.force_limit:g} N and stroke_limit {pto.stroke_limit:g} m; needs law: linear without limits"
        )
    if method != "auto":
        raise ValueError(f"simulation.method {method!r}: cannot follow a drag; needs auto")
