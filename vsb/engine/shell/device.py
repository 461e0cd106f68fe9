"""The buoy of a study: shell, gas, ballast; validated and frozen.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

import copy
import math
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import ConfigDict, Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from vsb.engine.shell.material import NAMED, Hookean, Material, with_moduli
from vsb.engine.shell.meridian import ClosedMeridian, capsule, series, spheroid, through
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.keys.quantities import Brief, Finite, NonNegative, Number, Positive, Section, within
from vsb.tools.columns import read_columns
from vsb.tools.units import METRE, number, scale
from vsb.tools.words import shortened

Basis = Literal["paper", "membrane", "full"]

SHAPES, MOST_OF_SERIES = ("spheroid", "capsule", "series", "profile"), 12
"""Kinds of shapes other than the sphere, and the most terms of each series of one."""
SLENDEREST = 10.0
"""Of the diameter: height, or either of them, beyond which shapes and waves are no longer resolved."""


class Spheroid(Section):
    """An ellipsoid of revolution by its height from pole to pole [m]; the device's radius is that of its equator."""

    height: Annotated[Positive, within(1e-3, 1e4, "m", "this exceeds any buoy")]


class Capsule(Section):
    """A cylinder between two hemispheres by its length [m]."""

    length: Annotated[NonNegative, within(0.0, 1e4, "m", "this exceeds any buoy")]


class Series(Section):
    """A smooth meridian x = sum a_k sin k phi, z = sum b_k cos k phi by its terms from k = 1, scaled to the radius."""

    radial: Annotated[tuple[Finite, ...], Field(min_length=1, max_length=MOST_OF_SERIES)]
    axial: Annotated[tuple[Finite, ...], Field(min_length=1, max_length=MOST_OF_SERIES)]


class Shape(Brief):
    """One of a spheroid, a capsule, a series, and a profile: points (x, z) from top to keel in any unit.

    Series and profile are scaled to the radius.
    """

    BRIEF: ClassVar[tuple[str, ...]] = ("series",)
    spheroid: Spheroid | None = None
    capsule: Capsule | None = None
    series: Series | None = None
    profile: tuple[tuple[Finite, Finite], ...] | None = Field(
        default=None, json_schema_extra={"anyOf": [{"type": "array"}, {"type": "string"}, {"type": "null"}]}
    )

    @model_validator(mode="after")
    def _one(self) -> Self:
        given = [name for name in SHAPES if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"received {' and '.join(given) or 'none'}: needs one of {', '.join(SHAPES)}")
        return self

    def meridian(self, radius: float) -> ClosedMeridian:
        """Return the meridian of a largest radius [m].

        Raises `ValueError` if it bounds no body, or is too slender or too flat.
        """
        found: ClosedMeridian
        if self.spheroid:
            key, found = "spheroid", spheroid(radius, self.spheroid.height)
        elif self.capsule:
            key, found = "capsule", capsule(radius, self.capsule.length)
        else:
            key = "series" if self.series else "profile"
            try:
                found = (
                    series(self.series.radial, self.series.axial, radius)
                    if self.series
                    else through(self.profile or (), radius)
                )
            except ValueError as error:
                raise ValueError(f"shape.{key}: {error}") from None
        ratio = (found.highest - found.lowest) / (2 * radius)
        if not 1 / SLENDEREST <= ratio <= SLENDEREST:
            raise ValueError(
                f"shape.{key}: received a height of {ratio:.4g} diameters, needs {1 / SLENDEREST:g} to {SLENDEREST:g}"
            )
        return found


def with_points(raw: Any, source: str) -> Any:
    """Return a study as nested mappings with the points of its shape's profile in place of the file that holds them.

    Raises `ConfigError` if the file cannot be read, or holds no rows of two numbers.

    Parameters
    ----------
    source : str
        File of the study, which the profile's name is relative to.
    """
    try:
        name = raw["device"]["shape"]["profile"]
    except (KeyError, TypeError):
        return raw
    if not isinstance(name, str):
        return raw
    found = copy.deepcopy(raw)
    found["device"]["shape"]["profile"] = _points(Path(source).parent / name, f"{source}: device.shape.profile")
    return found


def _points(path: Path, where: str) -> list[list[float]]:
    """Rows x, z of a file in one unit, lines of names before them left out."""
    needed = "two numbers x, z"
    table = read_columns(path, where, needed)
    known = next(filter(None, table.units), "m")
    factors = [scale(stated or known, METRE) or 0.0 for stated in table.units]
    if not all(factors):
        raise ConfigError(f"{path}: received {table.label(factors.index(0.0))}, needs lengths")
    points = []
    for n, cells in table.rows:
        values = [number(cell) for cell in cells]
        if len(values) != 2 or None in values:
            raise ConfigError(f"{path}:{n}: received {shortened(repr(' '.join(cells)))}, needs {needed}")
        points.append(
            [factor * value for factor, value in zip(factors, values, strict=True) if factor and value is not None]
        )
    return points


def shell_mass(meridian: ClosedMeridian | None, radius: float, thickness: float, density: float) -> float:
    """Return the mass of a shell [kg], a sphere without another meridian."""
    area = 4 * math.pi * radius**2 if meridian is None else meridian.area
    return area * thickness * density


ATMOSPHERE = 101325.0
"""Pressure of the atmosphere at the sea's surface [Pa]."""
THINNEST_SHELL = 1 / 3e4
"""Thickness over radius below which a sphere is a film."""


class MaxwellBranch(Section):
    """A spring and a dashpot in series beside the shell: its stiffness over the shell's own [-], its time [s]."""

    ratio: Annotated[Positive, within(1e-6, 100.0, "", "the shell needs a stiffness beside the branch")]
    time: Annotated[Positive, within(1e-4, 1e6, "s", "relaxation so fast or slow does not affect a buoy")]


class StructuralDamping(Brief):
    """Structural damping D = alpha M + beta K, alpha [1/s], beta [s], and Maxwell branches of a viscous material."""

    BRIEF = ("maxwell",)
    alpha: Annotated[NonNegative, within(0.0, 1e4, "1/s", "a motion so damped decays within 0.1 ms")] = 0.0
    beta: Annotated[NonNegative, within(0.0, 100.0, "s", "a shell damped for minutes is rigid: flexible: false")] = 0.0
    maxwell: tuple[MaxwellBranch, ...] = ()


class Gas(Section):
    """Gas trapped in the shell: adiabatic index [-], pressure of the atmosphere outside [Pa]."""

    adiabatic_index: Annotated[Number, Field(ge=1, le=2)] = 1.4
    atmospheric_pressure: Annotated[Positive, within(1.0, 1e7, "Pa", "the pressure on Venus is 9.2e6 Pa")] = ATMOSPHERE


Inertia = Annotated[NonNegative, within(0.0, 1e18, "kg m^2", "this exceeds any buoy")]


def _material_or_moduli(schema: dict[str, Any]) -> None:
    """Tell editors that a material of rubber or by name may stand for constants, and a draft for the mass."""
    for key in ("young_modulus", "poisson_ratio", "density", "mass"):
        schema["required"].remove(key)
    schema["properties"]["draft"] = {"type": "number", "exclusiveMinimum": 0}
    law = schema["properties"]["material"]
    schema["properties"]["material"] = {"anyOf": [{"enum": list(NAMED)}, law]}


class Device(Section):
    """Buoy: largest radius [m], shell thickness [m], E [Pa], nu [-], shell density [kg/m^3], total mass [kg].

    A sphere, unless it has a `shape`. E and nu are those of Hooke's law; a `material` of rubber implies its own.

    In a study file a `draft` [m] may stand for the mass, half immersion for both. The internal pressure [Pa] is gauge
    and constant; with `gas` it is that of the undeformed volume. Pitch needs the height of the whole buoy's centre of
    mass [m above the sphere's centre] and the transverse inertia of the ballast about its own [kg m^2]; yaw its inertia
    about the vertical axis.
    """

    model_config = ConfigDict(json_schema_extra=_material_or_moduli)

    radius: Annotated[Positive, within(0.01, 1e3, "m", "surface tension matters below 1 cm, no buoy has 1 km")]
    thickness: Positive
    young_modulus: Annotated[Positive, within(1.0, 1e16, "Pa", "no material has more; if rigid set flexible: false")]
    poisson_ratio: Annotated[
        Number, Field(gt=-1, le=0.5), within(-0.99, 0.5, "", "no isotropic material is known below")
    ]
    density: Annotated[Positive, within(0.1, 2.5e4, "kg/m^3", "aerogel has 0.2 kg/m^3, osmium 22 590 kg/m^3")]
    mass: Positive
    internal_pressure: Annotated[Finite, within(-1e8, 1e8, "Pa", "this exceeds a thousand atmospheres")] = 0.0
    gas: Gas | None = None
    damping: StructuralDamping = StructuralDamping()
    material: Material = Hookean()
    centre_of_mass: Annotated[Finite, within(-1e3, 1e3, "m", "this exceeds any buoy")] | None = None
    ballast_inertia: Inertia | None = None
    ballast_yaw_inertia: Inertia | None = None
    shape: Shape | None = None

    @model_validator(mode="before")
    @classmethod
    def _of_material(cls, raw: Any) -> Any:
        return with_moduli(raw)

    @model_serializer(mode="wrap")
    def _as_given(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Say what a file says: Hooke's law by its moduli, rubber by its law."""
        said: dict[str, Any] = dump(self)
        for key in ("young_modulus", "poisson_ratio") if self.material.rubber else ("material",):
            said.pop(key, None)
        return said

    @model_validator(mode="after")
    def _changes_volume(self) -> Self:
        if not self.material.rubber and self.poisson_ratio == 0.5:
            raise ValueError("poisson_ratio 0.5: needs less than 0.5, or a material of rubber")
        return self

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
                "because a thinner sphere wrinkles: it is a film, not a shell"
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
    def meridian(self) -> ClosedMeridian | None:
        """Meridian at rest about the middle of its height; none of a sphere."""
        return self.shape.meridian(self.radius) if self.shape else None


def cap_volume(radius: float, height: float) -> float:
    """Return the volume of a spherical cap, pi h^2 (3r - h)/3, its height in radii [m^3]."""
    return math.pi * height**2 * (3 - height) / 3 * radius**3


@lru_cache(maxsize=64)
def floating_height(radius: float, volume: float) -> float:
    """Return the height of the centre at which the immersed cap, pi h^2 (3r - h)/3, has the given volume."""
    low, high = 0.0, 2 * radius
    while high - low > 1e-15 * radius:
        h = 0.5 * (low + high)
        if h in (low, high):
            break
        low, high = (h, high) if math.pi * h * h * (3 * radius - h) / 3 < volume else (low, h)
    return radius - 0.5 * (low + high)


def centre_height(device: Device, water: Water) -> float:
    """Return the height of the centre above still water at rest [m], from mass = rho V(immersed part).

    The centre of another shape than the sphere is the middle of its height.
    """
    if device.shape is not None:
        return _shape_height(device.shape, device.radius, device.mass / water.density)
    return floating_height(device.radius, device.mass / water.density)


@lru_cache(maxsize=64)
def _shape_height(shape: Shape, radius: float, volume: float) -> float:
    """The same of another shape than the sphere."""
    meridian = shape.meridian(radius)
    return -(meridian.lowest + meridian.draft_of(volume))


def full_volume(device: Device) -> float:
    """Return the volume of a buoy [m^3]."""
    return 4 / 3 * math.pi * device.radius**3 if (rest := device.meridian) is None else rest.volume


def volume_to(device: Device, part: float) -> float:
    """Return the volume of a buoy below a part of its height, 0 to 2 in halves of it [m^3]."""
    if (rest := device.meridian) is None:
        return cap_volume(device.radius, part)
    return rest.volume_below(rest.lowest + part / 2 * (rest.highest - rest.lowest))


def keel_depth(device: Device, centre: float) -> float:
    """Return the draft of a buoy by the height of its centre above still water [m]."""
    return (device.radius if (rest := device.meridian) is None else -rest.lowest) - centre


@lru_cache(maxsize=64)
def waterline_radius(shape: Shape | None, radius: float, centre: float) -> float:
    """Return the radius of the undeformed buoy at still water, its centre at a height above it [m]."""
    if shape is None:
        return math.sqrt(radius**2 - centre**2)
    return shape.meridian(radius).radius_at(-centre)


NEAREST_POLE = 0.01
"""Of the radius: least distance of the waterline from top and keel."""
