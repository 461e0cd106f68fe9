"""A design problem: which buoy of a study absorbs most in a site's year, within limits; validated and frozen.

Imports nothing heavy: the Snakefile reads a design file at every parse.
"""

import dataclasses
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, field_validator, model_validator

from vsb.engine.motion.take_off import Pto, SeveralPorts, port_kind
from vsb.engine.shell.device import Device
from vsb.errors import ConfigError
from vsb.keys.meanings import KEYS, Key
from vsb.keys.quantities import Count, Name, NonNegative, Positive, Section, at_key
from vsb.keys.reading import nearest, read_yaml, validated
from vsb.keys.schema import Located, range_at, schema_of
from vsb.study.campaign import CAUSAL, ClimateFile, Verify, check_no_direction, sections, sizes_hull, study_at
from vsb.study.feasible import Ranges, Unmet
from vsb.study.study import BuoyStudy, Study, not_reserved
from vsb.study.study import load as load_study
from vsb.tools.files import sha256_of
from vsb.tools.variables import FORCE, PortKind

VARIABLES = (
    "device.radius", "device.shape.spheroid.height", "device.shape.capsule.length", "device.thickness",
    "device.young_modulus", "device.poisson_ratio", "device.density", "device.internal_pressure", "device.mass",
    "device.damping.alpha", "device.damping.beta", "device.material.mu", "device.material.c1", "device.material.c2",
    "device.material.jm", "pto.damping", "pto.stiffness", "pto.port.colatitude",
)  # fmt: skip
"""Keys of a study that derivatives are taken by, beside the clamp of a design, designs.NAME.clamp, and `NUMBERED`."""
NUMBERED = ("pto.port.belt.0", "pto.port.between.0", "pto.port.ports.NAME.colatitude", "device.shape.series.radial.1")
"""Examples of keys of numbers in lists, counted from 0, and of one of several ports."""
CLAMP = re.compile(r"designs\.(\w+)\.clamp")
ANGLE = re.compile(r"pto\.port\.(?:ports\.\w+\.)?(?:colatitude|(?:belt|between)\.[01])")
"""Keys of colatitudes of a port, or of one of several: of a ring, of the upper and lower end of a belt, of points."""
TERM = re.compile(r"device\.shape\.series\.(?:radial|axial)\.\d+")
"""Keys of terms of a shape, counted from 0."""
OF_RIGID = (
    "device.radius", "device.shape.spheroid.height", "device.shape.capsule.length", "device.mass", "pto.damping",
    "pto.stiffness",
)  # fmt: skip
"""Those a rigid buoy has as well."""
Objective = Literal[
    "annual_mean_power", "gain", "power_per_force", "power_per_mass", "power_per_surface", "power_per_cost"
]
DesignTuning = Literal["one", "causal"]
"""Take-off of a design: one damper for the year, or one causal controller."""
CONTROLLED = ("force_rms", "stroke_rms")
"""Limits that a causal controller keeps itself."""
LEAST_STROKE = "stroke_rms_least"
"""Least stroke of control within the force: what the search limits, for the controller to keep its limit of stroke."""
DIVISORS = {
    "power_per_force": "force_rms", "power_per_mass": "mass", "power_per_surface": "surface", "power_per_cost": "cost",
}  # fmt: skip
"""Objective -> the quantity annual mean power is divided by."""
OF_SHELL = ("load_factor", "static_strain", "damage")
"""Limits of a flexible shell; a rigid sphere meets them."""
LIMITS = tuple(name for name in KEYS["Limits"] if name != "sigmas")
"""Names of the limits."""
QUANTITIES = {
    "annual_mean_power": Key("W", "", "mean power of the year under one damper"),
    "gain_percent": Key("%", "", "gain of mean power over the reference design"),
    "damping": Key("N s/m", "", "that damper, the optimal one unless it is a variable", "damping_unit"),
    **{name: KEYS["Limits"][name] for name in LIMITS},
    LEAST_STROKE: Key("m", "", "least rms stroke of any causal control within the limit of its force", "motion_unit"),
    "spring_pull_above": Key("-", "", "pull of a spring below zero at the rms stroke over the weight"),
    "spring_pull_below": Key("-", "", "the same over the buoyancy left"),
    "spring_share": Key("-", "", "stiffness of a spring below zero over that at which the buoy rests no more"),
    **{
        f"load_factor_inverse_{i}": Key("-", "", f"load over buckling load, mode {i + 1} of those that buckle first")
        for i in range(4)
    },
}
"""What is known of a design; units where its port is heave."""
PARTS = {
    "load_factor": tuple(f"load_factor_{i}" for i in range(4)),
    "spring_pull": ("spring_pull_above", "spring_pull_below"),
}
"""Limits of which several parts must be met, with names of their own, and a multiplier each."""
PRICED = {"per_kg": "mass", "per_newton": "force_rms", "per_square_metre": "surface"}
"""Price -> the quantity it is of."""
OF_WAVES = ("force_rms", "stroke_rms", "spring_pull", "spring_share", "cost", "damage")
"""Limits that a buoy meets in waves, by its take-off; the others at rest."""
OF_SIZE = ("beam", "surface", "volume", "force_rms")
"""Limits of which one must hold where the radius is free, or power grows with it up to its bound."""
NARROWEST = 1e-6
"""Width of a range in terms of its larger end, below which it is none."""
USUAL = {"load_factor": (1.0, 20.0), "static_strain": (1e-4, 1.0)}
"""Limits outside of which a slip is likely."""
MOST_UNCERTAIN = 0.3
"""Relative standard deviation beyond which a budget of first derivatives says little."""
MOSTLY = 0.5
"""Part of a range of radius or mass that some buoy must reach."""
STILL = 100.0
"""Stiffness or damper of a take-off, in terms of the water's stiffness or the damper it is critical with, that holds
a buoy still."""
_ENDS = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
_BOUNDS: dict[str, Any] = {
    "type": "object",
    "minProperties": 1,
    "additionalProperties": {
        "anyOf": [_ENDS, {"type": "object", "properties": {"log": _ENDS}, "additionalProperties": False}]
    },
}
"""What a file may say of its variables, as JSON schema."""
_FORMS = "[lowest, highest] or {log: [lowest, highest]}"


def limit_of(part: str) -> str:
    """Return the limit a part is of."""
    if part == LEAST_STROKE:
        return "stroke_rms"
    return next((limit for limit, parts in PARTS.items() if part in parts), part)


def unit_of(quantity: str, kind: PortKind = FORCE) -> str:
    """Return the unit of a quantity of a design, at a kind of port; 1 of one without."""
    key = QUANTITIES[quantity]
    said = getattr(kind, key.at_port) if key.at_port else key.unit
    return "1" if said == "-" else str(said)


class Variable(Section):
    """A key of the study, its bounds, and whether it is varied by its logarithm."""

    key: str
    low: float
    high: float
    log: bool = False

    def scaled(self, value: float) -> float:
        """Return the place of a value between the bounds, 0 to 1."""
        if self.log:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def value(self, place: float) -> float:
        """Return the value at a place, 0 to 1."""
        if self.log:
            return float(self.low * (self.high / self.low) ** place)
        return self.low + (self.high - self.low) * place

    def slope(self, value: float) -> float:
        """Return the derivative of the value by its place."""
        return value * math.log(self.high / self.low) if self.log else self.high - self.low

    def clipped(self, value: float) -> float:
        """Return the value nearest to another within the bounds."""
        return min(max(value, self.low), self.high)


def comparable(pto: Pto) -> bool:
    """Whether a take-off acts with one force, as one in heave does: limits and numbers may be common to both."""
    return not pto.several and port_kind(pto.port) is FORCE


def of_forces(pto: Pto) -> bool:
    """Whether several ports all act with forces, so that the rms of all together may be limited."""
    return isinstance(pto.port, SeveralPorts) and all(port_kind(one) is FORCE for one in pto.port.ports.values())


def _read_variables(raw: object) -> object:
    """Variables with their bounds as a file has them: a list, because canonical JSON sorts mappings.

    In the order of `VARIABLES`, others after them by name, whatever that of the file: starts are drawn by the place of
    a variable in the list.
    """
    if isinstance(raw, list | tuple):
        return raw
    if not isinstance(raw, Mapping) or not raw:
        raise ValueError(f"received {raw!r}, needs keys of the study, each with {_FORMS}")
    found = [_variable(str(key), given) for key, given in raw.items()]
    return tuple(sorted(found, key=lambda one: _order(one.key)))


def _order(key: str) -> tuple[int, str]:
    """What variables are sorted by."""
    return (VARIABLES.index(key), "") if key in VARIABLES else (len(VARIABLES), key)


def is_variable(key: str) -> bool:
    """Return whether derivatives are taken by a key of a study, if the study has it."""
    return key in VARIABLES or any(pattern.fullmatch(key) for pattern in (CLAMP, ANGLE, TERM))


def _variable(key: str, given: object) -> Variable:
    """One variable."""
    if not is_variable(key):
        near = nearest(key, VARIABLES)
        known = f"{', '.join(VARIABLES)}, {', '.join(NUMBERED)}, or designs.NAME.clamp"
        raise ValueError(f"{key}: needs one of {known}" + (f"; did you mean {near}?" if near else ""))
    ends: Any = given
    log = isinstance(given, Mapping) and set(given) == {"log"}
    if isinstance(given, Mapping) and log:
        ends = given["log"]
    try:
        if isinstance(ends, str | Mapping) or any(isinstance(end, bool) for end in ends):
            raise ValueError
        low, high = (float(end) for end in ends)
    except (TypeError, ValueError):
        raise ValueError(f"{key}: received {given!r}, needs {_FORMS}") from None
    place = "pto.port.colatitude" if ANGLE.fullmatch(key) else key
    least, most = (-math.inf, math.inf) if TERM.fullmatch(key) else range_at(schema_of(BuoyStudy), place.split("."))
    if not (math.isfinite(low) and math.isfinite(high)):
        raise ValueError(f"{key}: received {given!r}, needs finite bounds")
    if not high - low > NARROWEST * max(abs(low), abs(high)):
        raise ValueError(
            f"{key}: received {given!r}, needs the lower bound first, and another above it by more than {NARROWEST:g} "
            "of its size; what is not varied stands in the study alone"
        )
    if not (least < low and high < most):
        need = f"above {least:g}" if math.isinf(most) else f"above {least:g} and below {most:g}"
        raise ValueError(f"{key}: received {given!r}, needs bounds {need}")
    if log and low <= 0:
        raise ValueError(f"{key}: received {given!r}, needs bounds above 0 to be varied by the logarithm")
    return Variable(key=key, low=low, high=high, log=log)


Variables = Annotated[tuple[Variable, ...], BeforeValidator(_read_variables), WithJsonSchema(_BOUNDS)]


class Limits(Section):
    """What a buoy must keep within: `load_factor` from below, all others from above."""

    load_factor: Positive | None = 1.5
    static_strain: Positive | None = 0.1
    beam: Positive | None = None
    draft: Positive | None = None
    mass: Positive | None = None
    surface: Positive | None = None
    volume: Positive | None = None
    force_rms: Positive | None = None
    stroke_rms: Positive | None = None
    spring_pull: Positive | None = 0.05
    cost: Positive | None = None
    damage: Positive | None = None
    sigmas: NonNegative = 0.0  # standard deviations by the uncertain inputs that are kept away from them

    @property
    def given(self) -> dict[str, float]:
        """Limits that hold, by name."""
        return {name: value for name, value in self if name in LIMITS and value is not None}

    def without_shell(self) -> Self:
        """Return the limits of a rigid sphere."""
        return self.model_copy(update=dict.fromkeys(OF_SHELL))


class Competitor(Section):
    """The rigid sphere the best flexible buoy is compared with: its variables, and a port of its own if it has one."""

    variables: Annotated[tuple[str, ...], Field(min_length=1)] | None = None  # none: every one it has
    port: Literal["heave"] | None = None  # none: that of the study


class Cost(Section):
    """Prices of what a buoy is made of, in any currency."""

    per_kg: NonNegative = 0.0
    per_newton: NonNegative = 0.0
    per_square_metre: NonNegative = 0.0

    @model_validator(mode="after")
    def _costs(self) -> Self:
        if not self.given:
            raise ValueError(f"received no price above 0; needs one of {', '.join(PRICED)}")
        return self

    @property
    def given(self) -> dict[str, float]:
        """Prices above 0 by the quantity they are of."""
        return {of: price for name, of in PRICED.items() if (price := getattr(self, name))}


class Fatigue(Section):
    """Cycles of strain that a wall bears, N = cycles (range/strain)^-exponent, and the years it is to last."""

    exponent: Annotated[Positive, Field(ge=1, le=40)]
    strain: Annotated[Positive, Field(le=10)]  # range, from the least to the largest strain of a cycle [-]
    cycles: Positive = 1e6
    years: Positive = 20.0


class Optimisation(Section):
    """One design file; names of files are relative to it."""

    design: Name
    study: str
    optimise: Name | None = None  # none: the first flexible design by name
    climate: ClimateFile
    variables: Variables
    tuning: DesignTuning = "one"
    maximise: Objective = "annual_mean_power"
    cost: Cost | None = None
    fatigue: Fatigue | None = None
    limits: Limits = Limits()
    competitor: Competitor = Competitor()
    starts: Annotated[Count, Field(ge=1, le=200)] = 8
    seed: Annotated[Count, Field(ge=0, lt=2**32)] = 1
    pareto: dict[str, Annotated[tuple[Positive, ...], Field(min_length=1, max_length=100)]] = Field(
        default_factory=dict
    )
    uncertain: dict[str, Annotated[NonNegative, Field(le=1)]] = Field(default_factory=dict)
    verify: Verify | None = None

    _design_not_reserved = field_validator("design")(not_reserved)

    @property
    def prices(self) -> dict[str, float]:
        """Prices by the quantity they are of; none without a cost."""
        return self.cost.given if self.cost else {}

    @field_validator("pareto")
    @classmethod
    def _ascending(cls, pareto: dict[str, tuple[float, ...]]) -> dict[str, tuple[float, ...]]:
        return {name: tuple(sorted(values)) for name, values in sorted(pareto.items())}


def first_flexible(study: Study) -> str:
    """Return the first flexible design of a study by name."""
    return next(name for name, one in sorted(study.designs.items()) if one.flexible)


def is_design(raw: object) -> bool:
    """Whether what a file holds is a design problem, neither a study nor a campaign."""
    return isinstance(raw, dict) and "design" in raw


class LoadedDesign(Section):
    """A design problem, the study it varies and its climate file, by content."""

    problem: Optimisation
    source: str
    base: Study
    climate_path: str
    climate_id: str

    @property
    def flexible(self) -> str:
        """Name of the flexible design that is optimised."""
        return self.problem.optimise or first_flexible(self.base)

    @property
    def rigid(self) -> str:
        """Name of the rigid competitor."""
        return self.base.reference_design or "FSB"

    @property
    def competing(self) -> tuple[Variable, ...]:
        """Variables of the competitor."""
        names = competing(self.problem, self.base)
        return tuple(one for one in self.problem.variables if one.key in names)

    @property
    def sections(self) -> dict[str, Any]:
        """What the problem depends on of the study, with the design that is optimised and a rigid one."""
        found = sections(self.base)
        designs = {self.flexible: found["designs"][self.flexible]}
        if not self.base.pto.held:  # which a rigid one cannot move beside
            designs = {self.rigid: {"flexible": False}, **designs}
        return {**found, "pto": of_designs(found["pto"], designs), "designs": designs}

    @property
    def rigid_sections(self) -> dict[str, Any]:
        """The same of the competitor: a rigid sphere, undeformed, whose wall does not bound its mass."""
        found = {key: value for key, value in self.sections.items() if key not in ("modes", "reference_shape")}
        device = {**found["device"], **_no_wall(self.base.device, self.problem.variables)}
        designs = {self.rigid: {"flexible": False}}
        return {**found, "device": device, "pto": of_designs(self.rigid_take_off, designs), "designs": designs}

    @property
    def rigid_take_off(self) -> dict[str, Any]:
        """The take-off of rigid buoys: that of the study, or one in heave."""
        found: dict[str, Any] = sections(self.base)["pto"]
        if self.problem.competitor.port is None:
            return found
        own = ("damping", "stiffness", "tuning") if comparable(self.base.pto) else ()
        kept = ("control", "efficiency", *own)
        return {"tuning": "each"} | {key: value for key, value in found.items() if key in kept}

    @property
    def limits(self) -> dict[str, float]:
        """Limits of the flexible buoy."""
        return _pulled(self.problem.limits, self.base.pto)

    @property
    def rigid_limits(self) -> dict[str, float]:
        """Limits of the competitor."""
        return _pulled(self.problem.limits.without_shell(), Pto(**self.rigid_take_off))

    @property
    def ranges(self) -> dict[str, Ranges]:
        """What decides how the flexible buoy and its competitor float, by design."""
        return _ranges(self.problem, self.base)

    @property
    def doubts(self) -> list[str]:
        """What is probably a slip: limits, uncertainties and ranges that no engineer would give."""
        problem, variables, found = self.problem, {one.key: one for one in self.problem.variables}, []
        for name, value in problem.limits.given.items():
            low, high = USUAL.get(name, (0.0, math.inf))
            if not low <= value <= high:
                found.append(f"limits.{name}: received {value:g}, usual are {low:g} to {high:g}")
        for key, share in problem.uncertain.items():
            if share > MOST_UNCERTAIN:
                found.append(
                    f"uncertain.{key}: received {share:g}, a standard deviation of {100 * share:g} %; the budget is of "
                    f"first derivatives, which hold to about {100 * MOST_UNCERTAIN:g} %"
                )
        for design, ranges in self.ranges.items():
            reached = ranges.judged()
            for name in ("radius", "mass") if not isinstance(reached, Unmet) else ():
                one = variables.get(f"device.{name}")
                if one is None or one.key not in ranges.bounds:
                    continue
                low, high = (one.clipped(end) for end in getattr(reached, name))
                if one.scaled(high) - one.scaled(low) < MOSTLY:
                    found.append(
                        f"variables.{one.key}: received {one.low:g} to {one.high:g}, of which {design} floats within "
                        f"the limits at {low:.3g} to {high:.3g} at most"
                    )
        return [*found, *self._held_still]

    @property
    def _held_still(self) -> list[str]:
        """Springs and dampers of a take-off in heave all of which are so stiff that no buoy moves."""
        if self.base.pto.port != "heave":
            return []
        radius, mass = (max(self.ranges[self.rigid].ends(name)) for name in ("radius", "mass"))
        stiffness = self.base.water.density * self.base.water.gravity * math.pi * radius**2
        critical = 2 * math.sqrt(stiffness * mass)
        most = {
            "pto.stiffness": (stiffness, "the stiffness of the water"),
            "pto.damping": (critical, "the critical damping of the largest buoy"),
        }
        found = []
        for one in self.problem.variables:
            value, words = most.get(one.key, (math.inf, ""))
            if one.low > STILL * value:
                found.append(
                    f"variables.{one.key}: received {one.low:g} to {one.high:g}, all of which hold the buoy still: at "
                    f"least {one.low / value:.2g} times {words}"
                )
        return found

    @property
    def notes(self) -> list[str]:
        """What is to be said about the problem before it is solved."""
        problem, limits = self.problem, self.problem.limits.given
        keys = {one.key: one for one in problem.variables}
        found = []
        if problem.maximise == "annual_mean_power" and "device.radius" in keys and not set(OF_SIZE) & set(limits):
            found.append(
                "variables.device.radius: no limit on "
                f"{', '.join(OF_SIZE[:-1])} or {OF_SIZE[-1]}, and power grows with size: the radius will stand at its "
                f"bound, {keys['device.radius'].high:g} m"
            )
        if not self.competing:
            found.append(
                f"variables: none that a rigid buoy has ({', '.join(OF_RIGID)}), so the competitor is that of "
                "the study as it is, and the gain over it is that of size as well"
            )
        flexible = sorted(name for name, one in self.base.designs.items() if one.flexible)
        if problem.optimise is None and len(flexible) > 1:
            found.append(
                f"optimise: none given of the flexible designs {', '.join(flexible)}; {flexible[0]}, the first by "
                "name, is optimised"
            )
        if self.base.pto.efficiency < 1:
            found.append(
                f"pto.efficiency: powers are after conversion, with an efficiency {self.base.pto.efficiency:g} in both "
                "directions of power"
            )
        bound = [name for name in ("force_rms", "stroke_rms") if name in limits]
        if bound and "pto.damping" not in keys and problem.tuning != CAUSAL and not self.base.pto.several:
            found.append(
                f"limits.{bound[0]}: the damper is the optimal one for power, whatever the limit; with pto.damping "
                "among the variables it could give way"
            )
        return found


def _pulled(limits: Limits, pto: Pto) -> dict[str, float]:
    """Limits of a buoy: without that of a spring, where heave does not move one port."""
    pulled = pto.moved_by_heave and not pto.several
    return {name: value for name, value in limits.given.items() if pulled or name != "spring_pull"}


def of_designs(pto: Mapping[str, Any], designs: Iterable[str]) -> dict[str, Any]:
    """Return a take-off whose dampers, if given one by one, are those of some designs."""
    damping = pto.get("damping")
    if not isinstance(damping, Mapping):
        return dict(pto)
    first = next(iter(damping.values()))
    return {**pto, "damping": {name: damping.get(name, first) for name in designs}}


def competing(problem: Optimisation, study: Study) -> tuple[str, ...]:
    """Return the keys that a rigid competitor is optimised in; those of a take-off only if both have the same."""
    if problem.competitor.variables is not None:
        return problem.competitor.variables
    own = problem.competitor.port is None or comparable(study.pto)
    return tuple(one.key for one in problem.variables if of_rigid(one.key) and (own or not one.key.startswith("pto.")))


def of_rigid(key: str) -> bool:
    """Return whether a rigid buoy has a variable as well: its size, shape, mass and take-off."""
    return key in OF_RIGID or bool(TERM.fullmatch(key))


def load_design(path: str | Path) -> LoadedDesign:
    """Read and validate a design file and the study it names.

    Raises
    ------
    ConfigError
        One line with the file, the key, the value received and the value needed.
    """
    return read(read_yaml(path, "a design file such as config/best_buoy.yaml"), str(path))


def read(raw: object, source: str) -> LoadedDesign:
    """Validate a design problem as nested mappings, its files relative to that of its source; see `load_design`."""
    problem = validated(Optimisation, raw, source)
    folder = Path(source).parent
    given = read_yaml(folder / problem.study, "a study file such as config/buoy.yaml")
    mistakes = _Mistakes(source, raw)
    if isinstance(given, dict) and "body" in given:
        mistakes.end("study", f"received {problem.study}, a study of a body; needs a buoy with a device")
    check_no_direction(problem.climate, source)
    study = load_study(folder / problem.study)
    _check_study(problem, study, mistakes)
    _check_variables(problem, study, given, mistakes)
    _check_competitor(problem, study, mistakes)
    _check_others(problem, study, mistakes)
    if problem.tuning == CAUSAL:
        _check_control(problem, study, mistakes)
    climate = folder / problem.climate.file
    try:
        digest = sha256_of(climate)[:16]
    except OSError as error:
        mistakes.add(
            "climate",
            f"received {problem.climate.file}, which cannot be read ({error.strerror}); needs the path of a file, "
            "or of a folder of spectra, relative to this one",
        )
    mistakes.check()
    _check_reachable(problem, study, mistakes)
    mistakes.check()
    loaded = LoadedDesign(problem=problem, source=source, base=study, climate_path=str(climate), climate_id=digest)
    try:
        study_at(loaded.sections, {})
    except ConfigError as error:
        mistakes.end("study", str(error).removeprefix("with nothing varied: "))
    if (force := study.pto.control.force_rms) < math.inf:
        mistakes.end("study", f"pto.control.force_rms: received {force:g}; that of a design is limits.force_rms")
    return loaded


class _Mistakes:
    """Mistakes of a file, with the lines they stand in."""

    def __init__(self, source: str, raw: object) -> None:
        self.source, self.raw = source, raw
        self.found: list[str] = []

    def add(self, place: str | Sequence[str | int], text: str) -> None:
        """Add a mistake at a key, or at a key within a section."""
        path = [place] if isinstance(place, str) else [*place]
        line = self.raw.line(path) if isinstance(self.raw, Located) else None
        where = self.source if line is None else f"{self.source}:{line}"
        self.found.append(f"{where}: {'.'.join(map(str, path))}: {text}")

    def end(self, place: str | Sequence[str | int], text: str) -> None:
        """Add a mistake and report all."""
        self.add(place, text)
        self.check()

    def check(self) -> None:
        """Report all mistakes; `ConfigError`."""
        if self.found:
            more = f" (and {len(self.found) - 1} more)" if len(self.found) > 1 else ""
            raise ConfigError(self.found[0] + more, self.found)


def _check_study(problem: Optimisation, study: Study, mistakes: _Mistakes) -> None:
    """Check that the study is one whose year has derivatives."""
    flexible = [name for name, one in study.designs.items() if one.flexible]
    if not flexible:
        mistakes.end("study", f"received {problem.study} without a flexible design; needs one among its designs")
    if problem.optimise and problem.optimise not in flexible:
        mistakes.add("optimise", f"received {problem.optimise!r}, needs a flexible design: {', '.join(flexible)}")
    if problem.design == study.study:
        mistakes.add("design", f"received {problem.design!r}, the name of its study; needs another")
    if study.hydro.model == "assumed_pressure":
        mistakes.add(
            "study", f"{problem.study} has hydro.model 'assumed_pressure', which knows no waves; needs coefficients"
        )
    if study.motion != "heave":
        mistakes.add("study", f"{problem.study} has motion {study.motion!r}; derivatives are known of heave alone")
    if not study.pto.moved_by_heave and problem.competitor.port is None:
        mistakes.add(
            "study",
            f"{problem.study} has a pto.port that a rigid buoy does not move, so there is nothing to compare with; "
            "needs heave, a place of the shell against the sea bed, or beside it competitor: {port: heave}, a rigid "
            "buoy whose take-off is in heave",
        )
    _check_port(problem, study, mistakes)
    if study.pto.nonlinear:
        mistakes.add(
            "study",
            f"{problem.study} has a nonlinear take-off ({_nonlinear(study.pto)}), whose year has no derivatives; needs "
            "law: linear without limits, with limits.force_rms and stroke_rms in this file, or tuning: causal; "
            "optimum.yaml can then be run with any law",
        )


def _nonlinear(pto: Pto) -> str:
    """What makes a take-off nonlinear, as its file says it."""
    if pto.law != "linear":
        return f"law: {pto.law}"
    return ", ".join(
        f"{name}: {one:g}" for name in ("force_limit", "stroke_limit") if (one := getattr(pto, name)) < math.inf
    )


def _check_port(problem: Optimisation, study: Study, mistakes: _Mistakes) -> None:
    """Check what has no meaning for several ports, or for both buoys if they act with different loads."""
    pto, other = study.pto, problem.competitor.port is not None
    if problem.maximise == "gain" and other:
        mistakes.add(
            "maximise",
            "received gain, over the rigid buoy of the same shape, which has another take-off (competitor.port); needs "
            "annual_mean_power or a quotient",
        )
    if problem.verify and pto.efficiency < 1:
        mistakes.add(
            "verify",
            f"received with pto.efficiency {pto.efficiency:g} of {problem.study}; runs in time of designs know the "
            "power at the port alone, needs 1",
        )
    if problem.verify and pto.several:
        mistakes.add("verify", "received with several ports, or the whole shell; runs in time of designs need one port")
    forces = comparable(pto) or (of_forces(pto) and not other)
    if problem.tuning == CAUSAL and not forces and (pto.several or other):
        mistakes.add(
            "tuning",
            f"received causal with pto.port of {problem.study}; needs ports that act with forces, on both buoys, or "
            "tuning: one",
        )
    if problem.fatigue and study.opens_chamber:
        mistakes.add("fatigue", "received with gas between port and take-off (pto.port: volume); needs another port")
    if isinstance(pto.port, SeveralPorts):
        if problem.fatigue:
            mistakes.add(
                "fatigue", "received with several ports, whose damper matrix has no derivatives; needs one port"
            )
        for key in (one.key for one in problem.variables if one.key in ("pto.damping", "pto.stiffness")):
            mistakes.add(("variables", key), "received with several ports, which have a damper matrix, the best one")
    elif pto.several and "pto.stiffness" in (one.key for one in problem.variables):
        mistakes.add(("variables", "pto.stiffness"), "received with a damper spread over the shell, without a spring")
    if comparable(pto) or not (pto.several or other):
        return
    why = "which has no one load" if pto.several else "which has another load than the rigid buoy's in heave"
    alike = of_forces(pto) and not other
    limited = ("stroke_rms",) if alike else ("force_rms", "stroke_rms")
    for section, names in (("limits", problem.limits.given), ("pareto", problem.pareto)):
        for name in (name for name in limited if name in names):
            reason = "which has no one stroke" if alike else why
            mistakes.add((section, name), f"received with pto.port of {problem.study}, {reason}; remove it")
    if problem.maximise == "power_per_force" or "force_rms" in problem.prices:
        key = "maximise" if problem.maximise == "power_per_force" else "cost"
        mistakes.add(key, f"received a share of force with pto.port of {problem.study}, {why}; needs others")


def _value(study: Study, key: str) -> float | None:
    """The value of a key of a study; None of one it has not."""
    found = at_key(study, key)
    return found if isinstance(found, int | float) else None


def _check_variables(problem: Optimisation, study: Study, given: object, mistakes: _Mistakes) -> None:
    """Check the variables against the study."""
    keys = {one.key: one for one in problem.variables}
    device = given.get("device", {}) if isinstance(given, Mapping) else {}
    for key in keys:
        if found := CLAMP.fullmatch(key):
            chosen = problem.optimise or first_flexible(study)
            if found[1] != chosen or len(study.designs[chosen].clamp) != 1:
                mistakes.add(
                    ("variables", key),
                    f"received a clamp that {chosen}, which is optimised, has not; needs its only one",
                )
        elif key.startswith("pto.port.") and getattr(study.pto.port, "direction", "") == "radial":
            mistakes.add(
                ("variables", key), "received a radial port, whose share of heave changes with it; needs vertical"
            )
        elif key.startswith(("device.", "pto.port.")) and _value(study, key) is None:
            mistakes.add(("variables", key), f"{problem.study} has no {key}; remove it from the variables")
    for key in (key for key in keys if key.endswith((".belt.0", ".between.0", ".belt.1", ".between.1"))):
        other = key[:-1] + "10"[int(key[-1])]
        if _value(study, key) is None or (key.endswith("1") and other in keys):
            continue
        upper, lower = sorted((key, other))
        highest = keys[upper].high if upper in keys else _value(study, upper)
        lowest = keys[lower].low if lower in keys else _value(study, lower)
        if highest is not None and lowest is not None and highest >= lowest:
            mistakes.add(("variables", key), f"received bounds at which {upper} may reach {lower}; needs smaller ones")
    sizes = [key for key in keys if sizes_hull(key)]
    if sizes and "device.mass" not in keys and "mass" not in device:
        mistakes.add(
            ("variables", sizes[0]),
            f"received with the draft that {problem.study} asks for, which is of one size; needs device.mass among "
            "the variables, or a mass in the study",
        )
    if problem.limits.mass and "device.mass" not in keys and study.device.mass > problem.limits.mass:
        mistakes.add(
            ("limits", "mass"),
            f"received {problem.limits.mass:g} kg, and the mass is {study.device.mass:g} kg; needs device.mass among "
            "the variables",
        )


def _check_competitor(problem: Optimisation, study: Study, mistakes: _Mistakes) -> None:
    """Check what the competitor is optimised in."""
    keys = [one.key for one in problem.variables]
    for key in problem.competitor.variables or ():
        if not of_rigid(key):
            mistakes.add(("competitor", "variables"), f"received {key}; a rigid buoy has only {', '.join(OF_RIGID)}")
        elif key.startswith("pto.") and problem.competitor.port and not comparable(study.pto):
            mistakes.add(
                ("competitor", "variables"), f"received {key}, which is of another load than that of competitor.port"
            )
        elif key not in keys:
            mistakes.add(
                ("competitor", "variables"), f"received {key}, which has no bounds; needs it among variables too"
            )


def _check_control(problem: Optimisation, study: Study, mistakes: _Mistakes) -> None:
    """Check what causal control needs, and what it takes the place of."""
    if problem.limits.force_rms is None:
        mistakes.add("limits", "received no force_rms; tuning causal needs it, the rms force of the controller")
    for key in (one.key for one in problem.variables if one.key in ("pto.damping", "pto.stiffness")):
        mistakes.add(("variables", key), "received with tuning causal, whose controller is the whole force; remove it")
    if study.pto.stiffness:
        mistakes.add(
            "tuning",
            f"received causal, and {problem.study} has pto.stiffness {study.pto.stiffness:g}; the controller is the "
            "whole force, needs 0",
        )
    if study.pto.efficiency < 1:
        mistakes.add(
            "tuning",
            f"received causal with pto.efficiency {study.pto.efficiency:g} of {problem.study}; the best controller of "
            "a year is known without losses alone, needs 1, or tuning: one",
        )
    if problem.fatigue:
        mistakes.add(
            "fatigue", "received with tuning causal; the damage of the wall is computed with a damper, tuning: one"
        )
    if problem.verify:
        mistakes.add("verify", "received with tuning causal; runs in time of designs need one damper, tuning: one")


def _no_wall(device: Device, variables: Sequence[Variable]) -> dict[str, float]:
    """Thickness and density of a wall that bounds no rigid buoy: thin, and of no mass to speak of."""
    largest = max([device.radius, *(one.high for one in variables if one.key == "device.radius")])
    return {"thickness": 1e-4 * largest, "density": 0.1}


def _ranges(problem: Optimisation, study: Study) -> dict[str, Ranges]:
    """What decides how the flexible buoy and its competitor float, by design."""
    flexible, rigid = problem.optimise or first_flexible(study), study.reference_design or "FSB"
    ends = {one.key: (one.low, one.high) for one in problem.variables}
    of_competitor = {key: pair for key, pair in ends.items() if key in competing(problem, study)}
    limits, device, water = problem.limits, study.device, study.water
    return {
        flexible: Ranges(device, water, ends, limits.given, study.at_equilibrium),
        rigid: Ranges(
            device.model_copy(update=_no_wall(device, problem.variables)),
            water,
            of_competitor,
            limits.without_shell().given,
            deforms=False,
        ),
    }


def _check_reachable(problem: Optimisation, study: Study, mistakes: _Mistakes) -> None:
    """Check that some buoy of the ranges may float within the limits, and within each value of a front."""
    keys = [one.key for one in problem.variables]
    for design, ranges in _ranges(problem, study).items():
        found = ranges.judged()
        if isinstance(found, Unmet):
            if (limit := problem.limits.given.get(found.demand)) is not None:
                mistakes.add(("limits", found.demand), _refusal(found.demand, limit, design, found))
                return
            first = ("device.mass", "device.radius", "device.thickness")[:: -1 if found.demand == "thin" else 1]
            key = next((key for key in first if key in keys), keys[0])
            mistakes.add(("variables", key), f"{found.why} (design {design})")
            return
        for name, values in problem.pareto.items():
            for value in values:
                at = dataclasses.replace(ranges, limits={**ranges.limits, name: value}).judged()
                if isinstance(at, Unmet):
                    mistakes.add(("pareto", name), _refusal(name, value, design, at))
                    return


def _refusal(limit: str, value: float, design: str, found: Unmet) -> str:
    """What is said of a limit that no buoy of a design can keep."""
    received = f"{value:g} {unit_of(limit)}".removesuffix(" 1")
    return f"received {received}, which no buoy of {design} can keep: {found.why}"


def _check_others(problem: Optimisation, study: Study, mistakes: _Mistakes) -> None:
    """Check Pareto fronts and uncertain inputs."""
    for name, values in problem.pareto.items():
        if len(set(values)) < len(values):
            mistakes.add(
                ("pareto", name), f"received {', '.join(f'{one:g}' for one in values)}; needs every value once"
            )
        if name not in LIMITS:
            near = nearest(name, LIMITS)
            mistakes.add(
                ("pareto", name),
                f"needs one of {', '.join(LIMITS)}" + (f"; did you mean {near}?" if near else ""),
            )
    asked = {
        "maximise": problem.maximise == "power_per_cost",
        "limits": problem.limits.cost,
        "pareto": problem.pareto.get("cost"),
    }
    for key in (key for key, of_cost in asked.items() if of_cost and not problem.cost):
        mistakes.add((key,), "received the cost without prices; needs them, such as cost: {per_kg: 4, per_newton: 0.3}")
    for key in ("limits", "pareto"):
        if "damage" in (problem.limits.given if key == "limits" else problem.pareto) and not problem.fatigue:
            mistakes.add(
                (key, "damage"),
                "needs cycles of strain that the wall bears beside it, such as fatigue: {exponent: 5, strain: 0.6}: "
                "1e6 cycles with a range of 0.6",
            )
    if problem.limits.sigmas and not problem.uncertain:
        mistakes.add(
            ("limits", "sigmas"),
            f"received {problem.limits.sigmas:g} standard deviations of nothing; needs uncertain inputs beside it, "
            "such as uncertain: {device.young_modulus: 0.1}",
        )
    for key in problem.uncertain:
        if key not in (device := [one for one in VARIABLES if one.startswith("device.")]):
            mistakes.add(("uncertain", key), f"needs one of {', '.join(device)}")
        elif not _value(study, key):
            mistakes.add(("uncertain", key), f"{problem.study} has no {key}, or 0; a share of it says nothing")
