"""A study: validated, frozen, with one canonical JSON form and content ids.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

import contextlib
import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, Union, cast

from pydantic import ConfigDict, Discriminator, Field, GetCoreSchemaHandler, Tag, field_validator, model_validator
from pydantic_core import CoreSchema

from vsb.engine.integrators.settings import RECORDS_PER_PERIOD, Simulation
from vsb.engine.motion.take_off import Pto, SeveralPorts, Tuning, port_kind
from vsb.engine.shell.device import (
    NEAREST_POLE,
    Device,
    centre_height,
    full_volume,
    keel_depth,
    volume_to,
    waterline_radius,
    with_points,
)
from vsb.engine.waves.kinds import (
    IrregularSea,
    Wave,
    with_files,
)
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.keys.quantities import Name, Section
from vsb.keys.reading import read_yaml, validated
from vsb.keys.schema import LIKELY
from vsb.study.sections import (
    Design,
    Drag,
    Hydro,
    Modes,
    Mooring,
    Motion,
    Plate,
    Published,
    RestShape,
    check_directions,
    check_followed,
    check_heading,
    check_rubber,
    check_shape,
    check_spreading,
    resolved,
)
from vsb.tools.units import value_in
from vsb.tools.variables import FORCE, PortKind

RESERVED_NAMES = ("hydro", "hydro_precision", "barge", "logs", "benchmarks", "trash")


FEWEST_BATCHES = 6
"""Batches of records, each as long as the memory of their sea, that an interval of mean power needs."""


def not_reserved(value: str) -> str:
    """Return the name of a study, campaign or design, unless it is that of a folder of the workflow."""
    if value in RESERVED_NAMES:
        raise ValueError(f"{value!r} is the name of a results folder; choose another than {', '.join(RESERVED_NAMES)}")
    return value


def first_rigid(designs: Mapping[str, Any]) -> str | None:
    """Return the first rigid design by name, the order of results: gains are relative to it."""
    return next((name for name, design in sorted(designs.items()) if not design.flexible), None)


class Study(Section):
    """Designs compared in seas: of a buoy where there is a `device`, of any other body where there is a `body`.

    Two kinds of it declare the keys of their files and answer what differs; `Study` makes the one that keys are of.
    Reading what its kind does not have raises `AttributeError`.
    """

    KINDS: ClassVar[dict[str, type["Study"]]] = {}  # by what floats
    KIND: ClassVar[Literal["buoy", "body"]]  # that floats
    FLOATS: ClassVar[tuple[str, ...]] = ()  # keys of what floats, beside designs and take-off; none of a body
    LIMIT: ClassVar[str]  # of the power absorbed, in words; empty where none is known
    if TYPE_CHECKING:
        study: str
        device: Device
        body: Any
        motion: Motion
        modes: Modes
        reference_shape: RestShape
        mooring: Mooring | None
        water: Water
        pto: Pto
        waves: tuple[Wave, ...]
        simulation: Simulation
        hydro: Any
        published: Published | None
        designs: Mapping[str, Any]  # each knows whether it is flexible
        drag: Any

        def __init__(self, **keys: Any) -> None: ...

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Know a kind by what floats in it."""
        super().__pydantic_init_subclass__(**_)
        cls.KINDS[cls.KIND] = cls

    @classmethod
    def kind_of(cls, raw: object) -> "type[Study]":
        """Return the kind of study that keys of a file are of."""
        return cls.KINDS["body" if isinstance(raw, Mapping) and "body" in raw else "buoy"] if cls is Study else cls

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Read either kind where a study is asked for."""
        if cls is not Study:
            return handler(source)
        either: Any = Union[tuple(Annotated[kind, Tag(name)] for name, kind in cls.KINDS.items())]  # noqa: UP007
        tag = Discriminator(lambda value: (type(value) if isinstance(value, Study) else cls.kind_of(value)).KIND)
        return handler.generate_schema(Annotated[either, tag])

    @classmethod
    def part(cls, raw: Mapping[str, Any], **within: type[Section]) -> Self:
        """Return what a stage reads of a study, from its JSON: of a body its database holds what floats."""
        kind = cls.KINDS["buoy" if "device" in raw else "body"] if cls is Study else cls
        hydro = cast(type[Section], kind.model_fields["hydro"].annotation)
        return cast(Self, super(Study, kind).part(raw, hydro=hydro, **within))

    @property
    def flexible(self) -> bool:
        """Whether any design moves in more than rigid motions."""
        return any(design.flexible for design in self.designs.values())

    @property
    def reference_design(self) -> str | None:
        """The first rigid design by name, the order of results: gains are relative to it."""
        return first_rigid(self.designs)

    @property
    def has_shell(self) -> bool:
        """Whether any design has a shell that deforms; those of a body are of its database."""
        return False

    @property
    def dofs(self) -> tuple[str, ...] | None:
        """Degrees of freedom of a body that designs move in; none if some design moves in all."""
        return None

    @property
    def radius(self) -> float | None:
        """Radius of a buoy, in terms of which its motion is judged [m]; None of a body."""
        return None

    @property
    def plates(self) -> Mapping[str, Plate]:
        """What brakes each degree of freedom that quadratic drag acts on."""
        return self.drag.plates if isinstance(self.drag, Drag) else self.drag or {}

    _study_not_reserved = field_validator("study", check_fields=False)(not_reserved)

    @field_validator("waves", check_fields=False)
    @classmethod
    def _each_realisation(cls, value: tuple[Wave, ...]) -> tuple[Wave, ...]:
        """Seas of several realisations become as many seas, of seeds one after the other."""
        seas: list[Wave] = []
        for wave in value:
            if wave.drawn:
                seeds = range(wave.seed, wave.seed + wave.realisations)
                seas += [wave.model_copy(update={"seed": seed, "realisations": 1}) for seed in seeds]
            else:
                seas.append(wave)
        return tuple(seas)

    @model_validator(mode="after")
    def _records_long_enough(self) -> Self:
        """Without a duration or window, records last as long as an interval of mean power needs, if it is of them."""
        if self.simulation.model_fields_set & {"duration", "window"} or self.power_of_spectrum:
            return self
        families: dict[str, list[IrregularSea]] = {}
        for wave in self.waves:
            if wave.irregular:
                families.setdefault(wave.family, []).append(wave)
        start, end = self.simulation.window
        for some in families.values():
            begin = max(start, some[0].memory)
            last = begin + math.ceil(FEWEST_BATCHES / len(some)) * some[0].memory
            if last > end:
                start, end = begin, last
        lengths = [wave.file.length for wave in self.waves if wave.recorded]
        end = min(end, *lengths) if lengths else end
        if start < end:
            settings = self.simulation.model_copy(update={"duration": end, "window": (start, end)})
            object.__setattr__(self, "simulation", settings)
        return self

    @property
    def power_of_spectrum(self) -> bool:
        """Whether mean power is the expectation over spectra: hydrodynamics and take-off are linear."""
        return bool(self.hydro.model == "linear" and not self.pto.nonlinear and not self.plates)

    def check_labels(self) -> None:
        """Check that no sea is there twice; `ValueError`."""
        labels = [wave.label for wave in self.waves]
        if len(set(labels)) < len(labels):
            raise ValueError(f"waves {labels}: the same sea is listed twice")

    def check_records(self) -> None:
        """Check that no run is longer than the record of its sea; `ValueError`."""
        for i, wave in enumerate(self.waves):
            if wave.recorded and self.simulation.duration > wave.file.length * (1 + 1e-9):
                raise ValueError(
                    f"simulation.duration {self.simulation.duration:g} s: is longer than the record waves.{i}; needs "
                    f"at most {wave.file.length:.6g} s"
                )

    def check_control(self) -> None:
        """Check that a causal controller has seas that it does not know beforehand; `ValueError`."""
        for i, wave in enumerate(self.waves):
            if self.pto.law == "causal" and not wave.irregular:
                raise ValueError(f"pto.law 'causal': controls in irregular seas alone, received waves.{i} {wave.label}")

    def check_depths(self) -> None:
        """Check that seas of a finite depth are in water of that depth and gravity; `ValueError`."""
        for i, wave in enumerate(self.waves):
            wave.check_water(self.water, f"waves.{i}")

    def check_dampers_of_designs(self) -> None:
        """Check that dampers given one by one are those of the designs; `ValueError`."""
        if isinstance(self.pto.damping, dict) and set(self.pto.damping) != set(self.designs):
            raise ValueError(
                f"pto.damping: received dampers of {', '.join(self.pto.damping) or 'no design'}, needs one for every "
                f"design: {', '.join(self.designs)}"
            )

    def check_published(self) -> None:
        """Check that figures are published of designs there are; `ValueError`."""
        if self.published and (absent := sorted(set(self.published.values) - set(self.designs))):
            raise ValueError(f"published.values {absent}: no such design; needs some of {', '.join(self.designs)}")

    @classmethod
    def kind_of_port(cls, raw: Mapping[str, Any]) -> PortKind | None:
        """Return what the take-off of a file acts with, before the file is checked; None if that cannot be said."""
        section = raw.get("pto", {})
        if not isinstance(section, Mapping):
            return None
        port = dict(section) if "ports" in section else section.get("port", "heave")
        if isinstance(port, Mapping) and isinstance(port.get("dof"), str):
            port = {"dofs": {port["dof"]: 1.0}}
        try:
            return port_kind(port)
        except (AttributeError, TypeError):  # its check reports it
            return None

    @property
    def needs_bem(self) -> bool:
        """Whether the hydrodynamic model rests on radiation and diffraction coefficients."""
        return True

    @property
    def band(self) -> tuple[float, float] | None:
        """Frequencies a sea may have components at [rad/s]; None where the database decides."""
        return None

    @property
    def uses_panels(self) -> bool:
        """Whether coefficients are solved on panels, which takes minutes."""
        raise NotImplementedError

    @property
    def directions(self) -> tuple[float, ...]:
        """Directions of its waves [degrees]; none where direction does not matter."""
        raise NotImplementedError

    def fastest(self, wave: Wave) -> float:
        """Frequency of the fastest motion a run in a sea must show [rad/s]."""
        raise NotImplementedError

    def tuning(self, wave: Wave) -> Tuning:
        """Return how the damping of a run is found; still water has no optimum, there it is the given one."""
        alone = wave.still and (self.pto.tuning == "each" or not self.one_of_each_sea)
        return "fixed" if alone else self.pto.tuning

    def check_dampers(self) -> None:
        """Check that every run has a damper; raises `ConfigError`."""
        for i, wave in enumerate(self.waves):
            if self.tuning(wave) == "fixed" and not self.pto.has_damper:
                raise ConfigError(
                    f"waves.{i} {wave.label}: still water has no optimal damping; needs pto.damping in "
                    f"{port_kind(self.pto.port).damping_unit}"
                )

    @property
    def one_of_each_sea(self) -> tuple[Wave, ...]:
        """The seas one damper is to suit: of several realisations the first, still water left out."""
        return tuple(wave for wave in self.drawn_waves if not wave.still)

    @property
    def drawn_waves(self) -> tuple[Wave, ...]:
        """The seas figures are drawn of: of several realisations the first."""
        first = {wave.family: wave for wave in reversed(self.waves)}
        return tuple(wave for wave in self.waves if wave in first.values())

    @property
    def has_spectra(self) -> bool:
        """Whether any of the seas is irregular."""
        return any(wave.irregular for wave in self.waves)

    # of a buoy ------------------------------------------------------------------------------------------------------

    def check_record(self) -> None:
        """Check that every run is short enough to be recorded, and the window long enough to see the motion.

        Raises
        ------
        ConfigError
        """
        (start, end), duration = self.simulation.window, self.simulation.duration
        convolved = self.simulation.method == "convolution"
        most, reason = MOST_INSTANTS, "it must be recorded"
        if convolved:
            most, reason = MOST_CONVOLVED, "a convolution needs all of its past at every instant"
        for i, wave in enumerate(self.waves):
            period = 2 * math.pi / self.fastest(wave)
            if RECORDS_PER_PERIOD * duration > most * period:
                raise ConfigError(
                    f"simulation.duration: received {duration:g} s, needs at most "
                    f"{most / RECORDS_PER_PERIOD * period:.4g} s in waves.{i} {wave.label}, whose fastest motion takes "
                    f"{period:.3g} s, because {reason}"
                )
            slowest = 2 * math.pi / (self.heave_frequency if wave.still else wave.omega)
            if end - start < LEAST_WINDOW * slowest:
                raise ConfigError(
                    f"simulation.window: received {list(self.simulation.window)} s, needs to be at least "
                    f"{LEAST_WINDOW * slowest:.4g} s long, because the motion in waves.{i} {wave.label} takes "
                    f"{slowest:.4g} s"
                )

    @property
    def centre_height(self) -> float:
        """Height of the sphere's centre above still water at rest [m]."""
        return centre_height(self.device, self.water)

    @property
    def draft(self) -> float:
        """Depth of the keel below still water [m]."""
        return keel_depth(self.device, self.centre_height)

    @property
    def at_equilibrium(self) -> bool:
        """Whether it is about the shape the loaded shell takes at rest; a rigid buoy has no other shape."""
        return self.has_shell and self.reference_shape == "equilibrium"

    @property
    def opens_chamber(self) -> bool:
        """Whether the take-off lets trapped gas in and out: the gas is then a chamber before it, and no spring."""
        return self.pto.port == "volume" and self.device.gas is not None

    @property
    def rests_deformed(self) -> bool:
        """Whether the wetted shape at rest is not that of the device."""
        return self.has_shell and self.reference_shape != "undeformed"

    def with_degree(self, degree: int) -> Self:
        """Return the same with shell modes up to a degree."""
        return self.model_copy(update={"modes": self.modes.model_copy(update={"degree": degree})})

    @property
    def waterline_radius(self) -> float:
        """Radius of the undeformed buoy at still water [m]."""
        return waterline_radius(self.device.shape, self.device.radius, self.centre_height)

    @property
    def heave_frequency(self) -> float:
        """Natural frequency of heave without the water's inertia, sqrt(rho g pi r_w^2/m) [rad/s]."""
        weight = self.water.density * self.water.gravity
        return math.sqrt(weight * math.pi * self.waterline_radius**2 / self.device.mass)

    @property
    def orders(self) -> tuple[int, ...]:
        """Azimuthal orders of what moves: 0 of heave; 1 of surge and pitch; of shell modes as many as asked for."""
        return tuple(range(1 + (0 if self.motion == "heave" else self.modes.order if self.flexible else 1)))


def check_all(*checks: Callable[[], None]) -> None:
    """Make all checks; `ValueError` with every mistake found, a line each."""
    mistakes = []
    for check in checks:
        try:
            check()
        except ValueError as mistake:
            mistakes.append(str(mistake))
    if mistakes:
        raise ValueError("\n".join(mistakes))


CLEARANCE = 1.02
"""Least depth the spectral solver is given, in drafts."""
LEAST_WINDOW = 0.02
"""Of a period: least length of the window of the statistics, four instants recorded."""
MOST_INSTANTS, MOST_CONVOLVED = 5e7, 2**16
"""Instants a run records at most; a convolution, whose cost is their square."""
CHECKS = (
    "error_estimate", "interpolation_error", "limit_difference", "symmetry", "positive_damping", "rank_one", "haskind",
    "irregular_frequencies", "kramers_kronig",
)  # fmt: skip
"""Names of the checks on a hydro database, as `hydro.quality` gives them; a study may accept their failures."""


class BuoyStudy(Study):
    """One study file."""

    model_config = ConfigDict(title="Study")
    KIND, LIMIT = "buoy", "λ/2π"
    FLOATS = ("device", "motion", "mooring", "modes", "reference_shape")
    study: Name
    motion: Motion = "heave"
    device: Device
    modes: Modes = Modes()
    reference_shape: RestShape = "undeformed"
    designs: Annotated[dict[Name, Design], Field(min_length=1)]
    water: Water = Water()
    mooring: Mooring | None = None
    hydro: Hydro = Hydro()
    pto: Pto = Pto()
    drag: Drag | None = None
    waves: Annotated[tuple[Wave, ...], Field(min_length=1)]
    simulation: Simulation = Simulation()
    published: Published | None = None

    @model_validator(mode="before")
    @classmethod
    def _to_size(cls, raw: Any) -> Any:
        """Fill in what follows from the size of the buoy before ids are computed."""
        return resolved(raw) if isinstance(raw, dict) else raw

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        of_the_sea = (self._check_floats, self._check_waves, self.check_records, self.check_control, self.check_depths)
        check_all(*of_the_sea, self._check_model, self._check_take_off, partial(check_shape, self))
        return self

    def _check_floats(self) -> None:
        """The buoy must float partly immersed."""
        full = full_volume(self.device) * self.water.density
        if not self.device.mass < full:
            raise ValueError(
                f"device.mass {self.device.mass:g} kg: the buoy would sink; needs less than {full:.6g} kg, "
                "the mass of the water it displaces fully immersed"
            )
        low, high = (volume_to(self.device, part) * self.water.density for part in (NEAREST_POLE, 2 - NEAREST_POLE))
        if not low <= self.device.mass <= high:
            raise ValueError(
                f"device.mass {self.device.mass:g} kg: needs {low:.6g} to {high:.6g} kg, because the waterplane is too "
                f"small within {NEAREST_POLE:g} radii of a pole"
            )
        if not self.water.depth > self.draft:
            raise ValueError(
                f"water.depth {self.water.depth:g} m: needs more than the draft of the buoy, {self.draft:.4g} m"
            )

    def _check_waves(self) -> None:
        """Every wave must lie inside the solved band, every label be unique."""
        for i, wave in enumerate(self.waves):
            if not wave.still:
                check_heading(self, wave.direction, f"waves.{i}")
            if wave.spreads:
                check_spreading(self, f"waves.{i}.{'spreading' if wave.drawn and wave.spreading else 'file'}")
            wave.check_below(self.hydro.omega_max, f"waves.{i}")
            if self.needs_bem and not wave.still and wave.omega > self.hydro.omega_max:
                shortest = 2 * math.pi / self.hydro.omega_max
                raise ValueError(
                    f"waves.{i} {wave.label}: the wave is too short for the mesh and band solved; "
                    f"needs a period of at least {shortest:.4g} s, or a larger hydro.omega_max "
                    f"(now {self.hydro.omega_max:g} rad/s)"
                )
        self.check_labels()
        if self.hydro.omega and self.hydro.omega[-1] > self.hydro.omega_max:
            raise ValueError(
                f"hydro.omega {self.hydro.omega[-1]:g} rad/s: needs at most hydro.omega_max = "
                f"{self.hydro.omega_max:g} rad/s"
            )

    def _check_model(self) -> None:
        """Seas, method and published designs must suit the hydrodynamic model."""
        model, method = self.hydro.model, self.simulation.method
        if model == "assumed_pressure" and any(wave.irregular for wave in self.waves):
            raise ValueError(
                "hydro.model 'assumed_pressure': has one period, of a regular wave; remove the irregular seas"
            )
        if model == "assumed_pressure" and (self.reference_shape, self.device.internal_pressure) != ("undeformed", 0.0):
            raise ValueError(
                f"hydro.model {model!r}: is the paper's undeformed shell, open to constant pressure; needs "
                "device.internal_pressure: 0 and reference_shape: undeformed"
            )
        if model == "assumed_pressure" and (self.device.gas or self.device.damping.maxwell):
            raise ValueError(
                f"hydro.model {model!r}: has no trapped gas and no viscous material; remove device.gas and "
                "device.damping.maxwell"
            )
        idle = [key for key in ("omega", "rows", "accept") if getattr(self.hydro, key)]
        if model == "assumed_pressure" and idle:
            raise ValueError(f"hydro.{idle[0]}: hydro.model {model!r} has no coefficients to solve or judge; remove it")
        if unknown := [name for name in self.hydro.accept if name not in CHECKS]:
            raise ValueError(f"hydro.accept {unknown}: no such check; needs some of {', '.join(CHECKS)}")
        if model == "auto" and self.pto.idle:
            raise ValueError("hydro.model 'auto': selects the model by mean absorbed power; needs pto.damping above 0")
        if self.hydro.solver == "spectral" and self.hydro.rows:
            raise ValueError("hydro.solver 'spectral': has no rows; remove hydro.rows, or use 'panels'")
        if self.hydro.solver == "spectral" and self.water.depth < CLEARANCE * self.draft:
            raise ValueError(
                f"hydro.solver 'spectral': needs a water.depth of at least {CLEARANCE:g} drafts, "
                f"{CLEARANCE * self.draft:.4g} m; use 'panels'"
            )
        suitable = {"linear": ("auto", "exact", "convolution"), "auto": ("auto",)}.get(model, ("auto", "exponential"))
        if method not in suitable:
            raise ValueError(f"simulation.method {method!r}: hydro.model {model!r} needs one of {', '.join(suitable)}")
        if self.flexible and self.device.material.rubber:
            check_rubber(model, method, self.pto)
        self.check_published()

    def _check_several(self) -> None:
        """Several ports are of a buoy that heaves, without drag."""
        if not self.pto.several:
            return
        if self.motion != "heave" or self.hydro.model not in ("linear", "body_exact") or self.drag is not None:
            raise ValueError(
                "pto.port: several ports, or a damper spread over the shell, need motion: heave, hydro.model: linear "
                "or body_exact, and no drag"
            )
        if self.device.gas and isinstance(self.pto.port, SeveralPorts) and "volume" in self.pto.port.ports.values():
            raise ValueError("pto.ports: the volume of trapped gas is a port alone; needs others, or no device.gas")

    def _check_held(self) -> None:
        """What is held must leave every design something to move, of a buoy that heaves."""
        if (held := self.pto.held) is None:
            return
        given = f"pto.held {{place: {held.place}}}"
        if self.motion != "heave" or self.hydro.model not in ("linear", "body_exact"):
            raise ValueError(f"{given}: needs motion: heave, and hydro.model: linear or body_exact")
        if rigid := [name for name, design in self.designs.items() if not design.flexible]:
            raise ValueError(f"{given}: leaves the rigid design {rigid[0]} no motion; needs flexible designs alone")
        ports = self.pto.port.ports.values() if isinstance(self.pto.port, SeveralPorts) else (self.pto.port,)
        if held.place == "heave" and "heave" in ports:
            raise ValueError(f"{given}: holds the take-off's port, heave; needs another pto.port")
        if self.simulation.initial_position or self.simulation.initial_velocity:
            raise ValueError(f"{given}: starts at rest; needs simulation.initial_position and initial_velocity of 0")

    def _check_take_off(self) -> None:
        """Dampers must be those of the designs, and model and method able to follow the take-off."""
        model, method, pto = self.hydro.model, self.simulation.method, self.pto
        self.check_dampers_of_designs()
        self._check_held()
        self._check_several()
        if model == "assumed_pressure" and pto.tuning != "fixed":
            raise ValueError(
                f"pto.tuning {pto.tuning!r}: an assumed pressure has no optimal damping; "
                "needs pto.damping and tuning: fixed"
            )
        if pto.port != "heave" and model != "linear" and not ((pto.on_shell or pto.several) and model == "body_exact"):
            at_shell = " and those of the shell" if model == "body_exact" else ""
            raise ValueError(
                f"pto.port: hydro.model {model!r} has no other port than heave{at_shell}; needs hydro.model: linear"
            )
        if self.opens_chamber and pto.nonlinear:
            raise ValueError(
                "pto.port 'volume': with device.gas the take-off drives gas without inertia, whose flow jumps where "
                "the force does; needs law: linear without force_limit and stroke_limit, or no device.gas"
            )
        if method == "convolution" and (self.opens_chamber or self.device.damping.maxwell):
            raise ValueError(
                "simulation.method 'convolution': has neither trapped gas behind a volume port nor a viscous material; "
                "needs auto"
            )
        if pto.nonlinear and model == "auto":
            raise ValueError(
                f"pto: received law {pto.law} with force_limit {pto.force_limit:g} N and stroke_limit "
                f"{pto.stroke_limit:g} m, for which hydro.model 'auto' cannot choose; needs hydro.model: "
                "linear or body_exact, or law: linear without limits"
            )
        if pto.has_latching_time and model == "assumed_pressure":
            raise ValueError(
                f"pto.law {pto.law!r}: its latching time is found in waves, which hydro.model {model!r} does not "
                "have; needs hydro.model: linear or body_exact"
            )
        if pto.nonlinear and method != "auto":
            raise ValueError(f"simulation.method {method!r}: cannot follow a nonlinear take-off; needs auto")
        if self.drag is not None:
            check_followed(model, method, pto)
        check_directions(self)

    @property
    def radius(self) -> float:
        """Radius of the buoy [m]."""
        return self.device.radius

    @property
    def has_shell(self) -> bool:
        """Whether any design has a shell that deforms."""
        return self.flexible

    @property
    def band(self) -> tuple[float, float]:
        """Frequencies a sea may have components at [rad/s]."""
        return 0.0, self.hydro.omega_max

    @property
    def needs_bem(self) -> bool:
        """Whether the hydrodynamic model rests on radiation and diffraction coefficients."""
        return self.hydro.model != "assumed_pressure"

    @property
    def uses_panels(self) -> bool:
        """Whether coefficients come from capytaine's panels, not from the spectral solver: asked for or shallow."""
        solver, panels = self.hydro.solver, self.hydro.rows is not None or self.water.depth < CLEARANCE * self.draft
        return self.needs_bem and (solver == "panels" or (solver == "auto" and panels))

    def fastest(self, wave: Wave) -> float:
        """Frequency of the fastest motion a run in a sea must show [rad/s]; in still water that of heave."""
        if wave.still:
            return self.heave_frequency
        return min(wave.fastest, self.hydro.omega_max) if self.needs_bem else max(wave.omega, self.heave_frequency)

    @property
    def directions(self) -> tuple[float, ...]:
        """Directions its waves go to [degrees]; none where all go along x, as those a buoy that heaves knows."""
        going = dict.fromkeys(one for wave in self.waves for one in wave.directions)
        return tuple(going) if any(going) else ()


def load(path: str | Path) -> Study:
    """Read and validate a study file.

    Raises
    ------
    ConfigError
        One line with the file, the key, the value received and the value needed.
    """
    return parse(read_yaml(path, "a study file such as config/buoy.yaml"), source=str(path))


def parse(raw: object, source: str = "study") -> Study:
    """Validate a study given as nested mappings; see `load`."""
    if isinstance(raw, dict) and "body" in raw and "study" not in raw:
        raise ConfigError(
            f"{source}: study: missing; this is a body file: solve it by `vsb body {source} FOLDER`, or name it in a "
            f"study, body: {Path(source).name}"
        )
    if isinstance(raw, dict) and "body" in raw and "device" not in raw:
        raise ConfigError(f"{source}: body: received a study of a body, needs one of a buoy, with a device")
    raw = with_files(with_points(raw, source), source)
    try:
        return validated(BuoyStudy, raw, source)
    except OverflowError:
        raise ConfigError(
            f"{source}: device or water: a number is too large to compute with; check the units (SI)"
        ) from None


# numbers that are likely in another unit ------------------------------------------------------------------------------


def unlikely_units(study: Study) -> list[str]:
    """Return a line for every number outside its usual range that is within in another unit; of a body none."""
    lines = []
    for key, value, unit, least, most in _ranges(study) if study.KIND == "buoy" else ():
        size = abs(value)
        if size == 0 or math.isinf(size) or least <= size <= most:
            continue
        meant = [f"{value:.12g} {other}" for other in LIKELY[unit]]
        if probable := [one for one in meant if least <= abs(value_in(one, unit)) <= most]:
            side = "little" if size < least else "much"
            lines.append(f"{key}: {value:g} {unit} is very {side}; did you mean {probable[0]}?")
    return lines


def _ranges(study: Study) -> Iterator[tuple[str, float, str, float, float]]:
    """Keys with value, unit and usual range: of materials, and of what acts on a buoy by rho, g and radius."""
    device, water, pto = study.device, study.water, study.pto
    radius, weight = device.radius, water.density * water.gravity
    yield ("water.density", water.density, "kg/m^3", 500.0, 2e4)
    if study.flexible:
        yield ("device.density", device.density, "kg/m^3", 20.0, 2.5e4)
        if not device.material.rubber:
            yield ("device.young_modulus", device.young_modulus, "Pa", 1e3, 2e12)
        for name in ("mu", "c1", "c2"):
            if (modulus := getattr(device.material, name, None)) is not None:
                yield (f"device.material.{name}", modulus, "Pa", 1e3, 1e9)
        yield ("device.internal_pressure", device.internal_pressure, "Pa", 5e-3 * weight * radius, 1e6)
    if port_kind(pto.port) != FORCE:
        return
    for design in study.designs if isinstance(pto.damping, dict) else ("",):
        damper = water.density * radius**3 * math.sqrt(water.gravity / radius)
        key = f"pto.damping.{design}".rstrip(".")
        yield (key, pto.damper(design) or 0.0, "N s/m", 1e-3 * damper, 1e3 * damper)
    yield ("pto.stiffness", pto.stiffness, "N/m", 1e-3 * weight * radius**2, 1e3 * weight * radius**2)
    yield ("pto.force_limit", pto.force_limit, "N", 1e-3 * weight * radius**3, 1e3 * weight * radius**3)


@contextlib.contextmanager
def units_doubted(study: Study) -> Iterator[None]:
    """Put before a `ConfigError` raised inside the units that may be its cause."""
    try:
        yield
    except ConfigError as error:
        if not (lines := unlikely_units(study)):
            raise
        raise ConfigError(lines[0], [*lines, *error.mistakes]) from None
