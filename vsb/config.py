"""A study: validated, frozen, with one canonical JSON form and content ids.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

import hashlib
import json
import math
from collections.abc import Hashable
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import yaml
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, field_validator, model_validator

from vsb.errors import ConfigError

RESERVED_NAMES = ("hydro", "logs", "benchmarks")


def _number(value: object) -> object:
    """Refuse what pydantic would silently turn into a number (true -> 1.0)."""
    if isinstance(value, bool):
        raise ValueError("a number is needed, not true/false")
    return value


Number = Annotated[float, BeforeValidator(_number)]
Positive = Annotated[Number, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[Number, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[Number, Field(allow_inf_nan=False)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]


class Section(BaseModel):
    """A part of a study: unknown keys are errors, values never change."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class RayleighDamping(Section):
    """Structural damping D = alpha M + beta K, alpha [1/s], beta [s]."""

    alpha: NonNegative = 0.0
    beta: NonNegative = 0.0


class Device(Section):
    """Spherical buoy: radius [m], shell thickness [m], E [Pa], nu [-], shell density [kg/m^3], total mass [kg]."""

    radius: Positive
    thickness: Positive
    young_modulus: Positive
    poisson_ratio: Annotated[Number, Field(gt=-1, lt=0.5)]
    density: Positive
    mass: Positive
    internal_pressure: Finite = 0.0
    damping: RayleighDamping = RayleighDamping()

    @field_validator("internal_pressure")
    @classmethod
    def _vented(cls, value: float) -> float:
        if value:
            raise ValueError("needs 0 (vented): the prestress of a pressurised shell is not part of the model")
        return value

    @model_validator(mode="after")
    def _thin_and_light(self) -> Self:
        if not self.thickness < 0.1 * self.radius:
            raise ValueError(
                f"thickness {self.thickness:g} m: thin-shell theory (C3) needs less than "
                f"radius/10 = {0.1 * self.radius:g} m"
            )
        shell = 4 * math.pi * self.radius**2 * self.thickness * self.density
        if shell > self.mass:
            raise ValueError(f"mass {self.mass:g} kg: needs at least the mass of the shell itself, {shell:.6g} kg")
        return self


class Modes(Section):
    """Ritz basis of the shell: `paper`, `membrane` or `full`, up to Legendre degree `degree`."""

    basis: Literal["paper", "membrane", "full"] = "membrane"
    degree: Annotated[int, BeforeValidator(_number), Field(ge=0, le=40)] = 6


class Design(Section):
    """One buoy of the comparison: rigid or flexible, clamped at colatitudes [degrees] from the top pole."""

    flexible: bool = True
    clamp: tuple[Annotated[Number, Field(ge=0, le=180)], ...] = ()

    @field_validator("clamp", mode="before")
    @classmethod
    def _one_or_many(cls, value: object) -> object:
        return value if isinstance(value, list | tuple) else (value,)

    @model_validator(mode="after")
    def _clamp_needs_a_shell(self) -> Self:
        if self.clamp and not self.flexible:
            raise ValueError(
                f"clamp {list(self.clamp)}: a rigid design (flexible: false) has no shell to clamp; "
                "remove one of the two"
            )
        return self


class Water(Section):
    """Density [kg/m^3], depth [m] (`.inf` for deep water), gravity [m/s^2]."""

    density: Positive = 1025.0
    depth: Annotated[Number, Field(gt=0)] = math.inf
    gravity: Positive = 9.81


class Hydro(Section):
    """Hydrodynamic model, tolerance [-], highest frequency solved [rad/s], optional tabulated frequencies [rad/s]."""

    model: Literal["linear"] = "linear"
    tolerance: Annotated[Number, Field(ge=1e-5, le=0.1)] = 1e-3
    omega_max: Positive = 12.0
    omega: tuple[Positive, ...] = ()
    rows: Annotated[int, BeforeValidator(_number), Field(ge=4, le=160)] | None = None
    accept: tuple[Name, ...] = ()

    @model_validator(mode="after")
    def _ascending(self) -> Self:
        if list(self.omega) != sorted(set(self.omega)):
            raise ValueError(f"omega {list(self.omega)}: frequencies must ascend without repetition")
        return self


class Pto(Section):
    """Linear power take-off: damping [N s/m] between the heaving plate and the sea bed."""

    damping: NonNegative = 8000.0


class StillWater(Section):
    """No waves: free decay."""

    kind: Literal["still"]

    @property
    def label(self) -> str:
        """Name of the sea in tables and file names."""
        return "still"

    @property
    def description(self) -> str:
        """The sea in words."""
        return "still water"


class RegularWave(Section):
    """Sine wave: amplitude [m], period [s]."""

    kind: Literal["regular"]
    amplitude: Positive
    period: Positive

    @property
    def label(self) -> str:
        """Name of the sea in tables and file names."""
        return f"regular_A{self.amplitude:g}_T{self.period:g}"

    @property
    def description(self) -> str:
        """The sea in words."""
        return f"regular waves of {self.amplitude:g} m amplitude and {self.period:g} s period"

    @property
    def omega(self) -> float:
        """Angular frequency [rad/s]."""
        return 2 * math.pi / self.period


class Jonswap(Section):
    """JONSWAP sea: significant height [m], peak period [s], peakedness [-] (1: Pierson-Moskowitz), random seed."""

    kind: Literal["jonswap"]
    hs: Positive
    tp: Positive
    gamma: Annotated[Number, Field(ge=1, le=10)] = 3.3
    seed: Annotated[int, BeforeValidator(_number), Field(ge=0)] = 1

    @property
    def label(self) -> str:
        """Name of the sea in tables and file names."""
        return f"jonswap_Hs{self.hs:g}_Tp{self.tp:g}_g{self.gamma:g}_s{self.seed}"

    @property
    def description(self) -> str:
        """The sea in words."""
        return f"a JONSWAP sea of Hs = {self.hs:g} m and Tp = {self.tp:g} s (seed {self.seed})"

    @property
    def omega(self) -> float:
        """Peak angular frequency [rad/s]."""
        return 2 * math.pi / self.tp


Wave = Annotated[StillWater | RegularWave | Jonswap, Field(discriminator="kind")]


class Simulation(Section):
    """Time-domain run: duration [s], window of the statistics [s], initial heave [m] and heave velocity [m/s]."""

    duration: Positive = 60.0
    window: tuple[NonNegative, Positive] = (40.0, 60.0)
    initial_position: Finite = 0.0
    initial_velocity: Finite = 0.0
    tolerance: Annotated[Number, Field(ge=1e-12, le=0.1)] = 1e-6
    method: Literal["auto", "exact", "convolution"] = "auto"

    @model_validator(mode="after")
    def _window_inside(self) -> Self:
        start, end = self.window
        if not start < end <= self.duration:
            raise ValueError(f"window {list(self.window)}: needs 0 <= start < end <= duration = {self.duration:g} s")
        return self


class Study(Section):
    """One study file."""

    study: Name
    device: Device
    modes: Modes = Modes()
    designs: Annotated[dict[Name, Design], Field(min_length=1)]
    water: Water = Water()
    hydro: Hydro = Hydro()
    pto: Pto = Pto()
    waves: Annotated[tuple[Wave, ...], Field(min_length=1)]
    simulation: Simulation = Simulation()

    @field_validator("study")
    @classmethod
    def _not_reserved(cls, value: str) -> str:
        if value in RESERVED_NAMES:
            raise ValueError(
                f"{value!r} is the name of a results folder; choose a name other than {', '.join(RESERVED_NAMES)}"
            )
        return value

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        self._check_afloat()
        self._check_waves()
        return self

    def _check_afloat(self) -> None:
        """The buoy must float partly immersed."""
        full = 4 / 3 * math.pi * self.device.radius**3 * self.water.density
        if not self.device.mass < full:
            raise ValueError(
                f"device.mass {self.device.mass:g} kg: the buoy would sink; needs less than {full:.6g} kg, "
                "the mass of the water it displaces fully immersed"
            )
        if not self.water.depth > self.draft:
            raise ValueError(
                f"water.depth {self.water.depth:g} m: needs more than the draft of the buoy, {self.draft:.4g} m"
            )

    def _check_waves(self) -> None:
        """Every wave must lie inside the solved band, every label be unique."""
        for i, wave in enumerate(self.waves):
            if not isinstance(wave, StillWater) and wave.omega > self.hydro.omega_max:
                shortest = 2 * math.pi / self.hydro.omega_max
                raise ValueError(
                    f"waves.{i} {wave.label}: the wave is too short for the mesh and band solved; "
                    f"needs a period of at least {shortest:.4g} s, or a larger hydro.omega_max "
                    f"(now {self.hydro.omega_max:g} rad/s)"
                )
        labels = [wave.label for wave in self.waves]
        if len(set(labels)) < len(labels):
            raise ValueError(f"waves {labels}: the same sea is listed twice")
        if self.hydro.omega and self.hydro.omega[-1] > self.hydro.omega_max:
            raise ValueError(
                f"hydro.omega {self.hydro.omega[-1]:g} rad/s: needs at most hydro.omega_max = "
                f"{self.hydro.omega_max:g} rad/s"
            )

    @property
    def centre_height(self) -> float:
        """Height of the sphere centre above still water at rest [m], from mass = rho V(immersed cap)."""
        return _floating_height(self.device.radius, self.device.mass / self.water.density)

    @property
    def draft(self) -> float:
        """Depth of the keel below still water [m]."""
        return self.device.radius - self.centre_height

    @property
    def flexible(self) -> bool:
        """Whether any design needs shell modes."""
        return any(design.flexible for design in self.designs.values())

    @property
    def reference_design(self) -> str | None:
        """The first rigid design: gains are measured against it."""
        return next((name for name, design in self.designs.items() if not design.flexible), None)


def _floating_height(radius: float, volume: float) -> float:
    """Height of the centre at which the immersed cap, pi h^2 (3r - h)/3, has the given volume."""
    low, high = 0.0, 2 * radius
    while high - low > 1e-15 * radius:
        h = 0.5 * (low + high)
        if h in (low, high):
            break
        low, high = (h, high) if math.pi * h * h * (3 * radius - h) / 3 < volume else (low, h)
    return radius - 0.5 * (low + high)


class _UniqueKeyLoader(yaml.SafeLoader):
    """YAML loader that refuses a key given twice."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        """Build a mapping; a repeated key is an error."""
        seen: set[object] = set()
        for key_node, _ in node.value:
            if key_node.tag == "tag:yaml.org,2002:merge":
                continue
            key = self.construct_object(key_node, deep=deep)
            if key in seen:
                raise yaml.MarkedYAMLError(problem=f"key {key!r} is given twice", problem_mark=key_node.start_mark)
            seen.add(key)
        return super().construct_mapping(node, deep)


def load(path: str | Path) -> Study:
    """Read and validate a study file.

    Raises
    ------
    ConfigError
        One line with the file, the key, the value received and the value needed.
    """
    try:
        raw = yaml.load(Path(path).read_text(encoding="utf-8"), Loader=_UniqueKeyLoader)  # noqa: S506 (a SafeLoader)
    except OSError as error:
        raise ConfigError(
            f"{path}: cannot be read ({error.strerror}); give the path of a study file such as config/seed.yaml"
        ) from None
    except (yaml.YAMLError, TypeError, ValueError) as error:
        raise ConfigError(f"{path}: not valid YAML ({' '.join(str(error).split())})") from None
    return parse(raw, source=str(path))


def parse(raw: object, source: str = "study") -> Study:
    """Validate a study given as nested mappings; see `load`."""
    if not isinstance(raw, dict):
        raise ConfigError(
            f"{source}: received {type(raw).__name__}, needs a mapping with keys {', '.join(Study.model_fields)}"
        )
    try:
        return Study.model_validate(raw)
    except ValidationError as error:
        raise ConfigError(f"{source}: {_one_line(error)}") from None
    except OverflowError:
        raise ConfigError(
            f"{source}: device or water: a number is too large to compute with; check the units (SI)"
        ) from None


def _one_line(error: ValidationError) -> str:
    """Say the first error of a validation in one line, and how many more there are."""
    first, *more = error.errors()
    key = ".".join(str(part) for part in first["loc"]) or "study"
    received = "" if isinstance(first["input"], dict | Section) else f" received {first['input']!r};"
    what = first["msg"].removeprefix("Value error, ")
    if first["type"] == "extra_forbidden":
        what = "unknown key; remove it or correct its spelling"
    return " ".join(f"{key}:{received} {what}".split()) + (f" (and {len(more)} more)" if more else "")


def canonical(data: object) -> str:
    """Return the canonical JSON of plain data: sorted keys, no spaces, infinity as a string."""
    return json.dumps(_plain(data), sort_keys=True, separators=(",", ":"), allow_nan=False)


def _plain(data: object) -> object:
    """Make data fit for JSON: tuples to lists, numbers that are whole stay as floats, infinity to "inf"."""
    if isinstance(data, BaseModel):
        return _plain(data.model_dump())
    if isinstance(data, dict):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    if isinstance(data, float) and math.isinf(data):
        return "inf" if data > 0 else "-inf"
    return data + 0.0 if isinstance(data, float) else data  # no negative zero


def content_id(data: object) -> str:
    """Return the content id (16 hex digits of sha256 over the canonical JSON) of a spec."""
    return hashlib.sha256(canonical(data).encode()).hexdigest()[:16]
