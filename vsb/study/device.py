"""The buoy of a study: shell, gas, ballast; validated and frozen.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

from typing import Annotated, Self

from pydantic import Field, model_validator

from vsb.study.meridian import RestMeridian
from vsb.study.quantities import Finite, NonNegative, Number, Positive, Section, Sized, within
from vsb.study.shape import Shape, shell_mass

ATMOSPHERE = 101325.0
"""Pressure of the atmosphere at the sea's surface [Pa]."""
THINNEST_SHELL = 1 / 3e4
"""Thickness over radius below which a sphere is a film."""


class RayleighDamping(Section):
    """Structural damping D = alpha M + beta K, alpha [1/s], beta [s]."""

    alpha: Annotated[NonNegative, within(0.0, 1e4, "1/s", "what dies in a tenth of a millisecond does not move")] = 0.0
    beta: Annotated[NonNegative, within(0.0, 100.0, "s", "a shell damped for minutes is rigid: flexible: false")] = 0.0


class Gas(Section):
    """Gas trapped in the shell: adiabatic index [-], pressure of the atmosphere outside [Pa]."""

    adiabatic_index: Annotated[Number, Field(ge=1, le=2)] = 1.4
    atmospheric_pressure: Annotated[Positive, within(1.0, 1e7, "Pa", "no atmosphere is denser than that of Venus")] = (
        ATMOSPHERE
    )


Inertia = Annotated[NonNegative, within(0.0, 1e18, "kg m^2", "no buoy is as heavy")]


class Device(Sized):
    """Buoy: largest radius [m], shell thickness [m], E [Pa], nu [-], shell density [kg/m^3], total mass [kg].

    A sphere, unless it has a `shape`.

    In a study file a `draft` [m] may stand for the mass, half immersion for both. The internal pressure [Pa] is gauge
    and constant; with `gas` it is that of the undeformed volume. Pitch needs the height of the whole buoy's centre of
    mass [m above the sphere's centre] and the transverse inertia of the ballast about its own [kg m^2]; yaw its inertia
    about the vertical axis.
    """

    radius: Annotated[Positive, within(0.01, 1e3, "m", "below surface tension matters, above nothing floats")]
    thickness: Positive
    young_modulus: Annotated[Positive, within(1.0, 1e16, "Pa", "diamond has 1.2e12 Pa; flexible: false is rigid")]
    poisson_ratio: Annotated[
        Number, Field(gt=-1, lt=0.5), within(-0.99, 0.5, "", "no material keeps its shape so while it shrinks")
    ]
    density: Annotated[Positive, within(0.1, 2.5e4, "kg/m^3", "aerogel has 0.2 kg/m^3, osmium 22 590 kg/m^3")]
    mass: Positive
    internal_pressure: Annotated[Finite, within(-1e8, 1e8, "Pa", "no vessel holds a thousand atmospheres")] = 0.0
    gas: Gas | None = None
    damping: RayleighDamping = RayleighDamping()
    centre_of_mass: Annotated[Finite, within(-1e3, 1e3, "m", "no buoy is larger")] | None = None
    ballast_inertia: Inertia | None = None
    ballast_yaw_inertia: Inertia | None = None
    shape: Shape | None = None

    @model_validator(mode="after")
    def _thin_and_light(self) -> Self:
        if not self.thickness < 0.1 * self.radius:
            raise ValueError(
                f"thickness {self.thickness:g} m: thin-shell theory (C3) needs less than "
                f"radius/10 = {0.1 * self.radius:g} m"
            )
        if not self.thickness >= THINNEST_SHELL * self.radius:
            raise ValueError(
                f"thickness {self.thickness:g} m: needs at least radius/3e4 = {THINNEST_SHELL * self.radius:.4g} m, "
                "because a thinner sphere is a film that wrinkles under a billionth of its modulus, no shell"
            )
        if (rest := self.meridian) is not None and not self.thickness < 0.1 * rest.sharpest:
            raise ValueError(
                f"thickness {self.thickness:g} m: thin-shell theory (C3) needs less than a tenth of the shape's least "
                f"radius of curvature, {0.1 * rest.sharpest:.4g} m"
            )
        if self.shell_mass > self.mass:
            raise ValueError(
                f"mass {self.mass:g} kg: needs at least the mass of the shell itself, {self.shell_mass:.6g} kg"
            )
        outside = self.gas.atmospheric_pressure if self.gas else ATMOSPHERE
        if not self.internal_pressure > -outside:
            raise ValueError(
                f"internal_pressure {self.internal_pressure:g} Pa, gauge: needs more than {-outside:g} Pa, because "
                "no gas is thinner than vacuum"
            )
        return self

    @model_validator(mode="after")
    def _ballast_inside(self) -> Self:
        moment, most = self.mass * (self.centre_of_mass or 0.0), (self.mass - self.shell_mass) * self.radius
        if abs(moment) > most:
            raise ValueError(
                f"centre_of_mass {self.centre_of_mass:g} m: needs at most {most / self.mass:.4g} m above or below the "
                "sphere's centre, because the ballast lies inside the sphere"
            )
        return self

    @property
    def shell_mass(self) -> float:
        """Mass of the shell [kg]; the rest of the mass is ballast."""
        return shell_mass(self.meridian, self.radius, self.thickness, self.density)

    @property
    def meridian(self) -> RestMeridian | None:
        """Meridian at rest about the middle of its height; none of a sphere."""
        return self.shape.meridian(self.radius) if self.shape else None
