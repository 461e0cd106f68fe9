"""A campaign: a study over a site's whole year, and over what is varied of it; validated and frozen.

Imports nothing heavy: the Snakefile reads a campaign at every parse.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Discriminator, Field, Tag, WithJsonSchema, field_validator

from vsb.engine.motion.take_off import DistributedPort, Pto, SeveralPorts, port_kind
from vsb.errors import ConfigError
from vsb.keys.quantities import Count, Name, Number, Section
from vsb.keys.reading import read_yaml, validated
from vsb.study.body import read_study
from vsb.study.study import Study, not_reserved
from vsb.study.vary import DAMPING, PORT, SCALE, VARIED, Point, Value, Vary, read_vary, scaled
from vsb.tools.files import sha256_of

Tunings = Literal["fixed", "one", "each", "damper_same_force", "causal", "constrained"]
"""Damper as given, the best one of the year, the best one of each sea; scheduled over sea states, the best damper of a
given rms force, and a causal controller; the best force of any kind within limits."""
SAME_FORCE: Literal["damper_same_force"] = "damper_same_force"
CAUSAL: Literal["causal"] = "causal"
AT_FORCE = (SAME_FORCE, CAUSAL)
CONSTRAINED: Literal["constrained"] = "constrained"
LEADING: tuple[Tunings, ...] = ("one", "each", "fixed", "causal", "damper_same_force", "constrained")
"""Order in which a campaign's answer is given for the tunings it has."""


def leading_tuning(tunings: Sequence[str]) -> Tunings:
    """Return the tuning a campaign's answer is given for."""
    return next(name for name in LEADING if name in tunings)


IN_TIME = {"body_exact": "body_exact", "linear": "in_time"}
"""Model of runs in time -> begin of the names of what they say of a year: linear runs see what linear theory does not,
as a nonlinear take-off."""


POWER_IN_TIME = ("mean_power", "power_low", "power_high")
GAIN_IN_TIME = ("gain_percent", "gain_low", "gain_high")
"""What runs in time say of a year, after that begin: values with their 95 % intervals."""


class Constrained(Section):
    """Budget of the optima within limits of each design at each point [s], and the seed of their waves."""

    seconds: Annotated[Number, Field(gt=0, le=86400)] = 10.0
    seed: Annotated[Count, Field(ge=0, lt=2**32)] = 1


class Verify(Section):
    """Seas of the year to be simulated in time, two of each stratum of its energy; seed of the draw.

    The model is `body_exact` of a buoy, if none is given, and `linear` of a body, which has no other.
    """

    seas: Annotated[Count, Field(ge=4, le=1000, multiple_of=2)] = 24
    model: Literal["linear", "body_exact"] = "body_exact"
    seed: Annotated[Count, Field(ge=0, lt=2**32)] = 1


SMALLEST, LARGEST = 1e-3, 1e3
"""Scales of a study by Froude."""
MOST_VERIFIED = 500
"""Points whose seas are simulated in time: each is a job of its own, of some ten seconds."""


class YearOfSeas(Section):
    """Where the seas of a year are from; all go in one direction [degrees], which matters to a body alone."""

    FILE: ClassVar[str]  # key of the file
    direction: Annotated[Number, Field(ge=-360, le=360)] = 0.0

    @property
    def file(self) -> str:
        """The file, as it is named."""
        return str(getattr(self, self.FILE))

    def of_contents(self, digest: str) -> Self:
        """Return the same, the file named by what it holds."""
        return self.model_copy(update={self.FILE: digest})


class Spectra(YearOfSeas):
    """Spectra: NDBC's text, plain or gz, SWAN's text, or netCDF."""

    FILE = "spectra"
    spectra: str
    spectrum: ClassVar[Literal["spectra"]] = "spectra"  # its own
    gamma: ClassVar[float] = 1.0


class Scatter(YearOfSeas):
    """Table of occurrences over significant height and period, each cell a spectrum of one form."""

    FILE = "scatter"
    scatter: str
    spectrum: Literal["jonswap", "pierson_moskowitz"] = "jonswap"
    gamma: Annotated[Number, Field(ge=1, le=10)] = 3.3


def _climate_kind(value: object) -> str:
    """Which kind of file is meant, by its key: no name of a key, which `vsb.keys.reading` would take for one."""
    counted = isinstance(value, Scatter) or (isinstance(value, dict) and "scatter" in value)
    return "occurrence" if counted else "measured"


ClimateFile = Annotated[
    Annotated[Spectra, Tag("measured")] | Annotated[Scatter, Tag("occurrence")],
    Discriminator(_climate_kind),
]
"""Where the seas of a year are from."""


Varied = Annotated[Vary, BeforeValidator(read_vary), WithJsonSchema(VARIED), Field(json_schema_extra={"default": {}})]
"""What is varied, as a file says it."""


class Campaign(Section):
    """One campaign file; names of files are relative to it."""

    campaign: Name
    study: str
    vary: Varied = Vary()
    climate: ClimateFile
    tuning: Annotated[tuple[Tunings, ...], Field(min_length=1)] | None = None  # none: all the study has
    constrained: Constrained | None = None
    verify: Verify | None = None

    _campaign_not_reserved = field_validator("campaign")(not_reserved)

    @field_validator("tuning")
    @classmethod
    def _each_once(cls, value: tuple[str, ...] | None) -> tuple[str, ...] | None:
        if value and len(set(value)) < len(value):
            raise ValueError("needs every tuning once")
        return value


def is_campaign(raw: object) -> bool:
    """Whether what a file holds is a campaign, and no study."""
    return isinstance(raw, dict) and "campaign" in raw


def load(path: str | Path) -> "LoadedCampaign":
    """Read and validate a campaign file, the study it names, and every point of it.

    Raises
    ------
    ConfigError
        One line with the file, the key, the value received and the value needed.
    """
    return read(read_yaml(path, "a campaign file such as config/year.yaml"), str(path))


def read(raw: object, source: str) -> "LoadedCampaign":
    """Validate a campaign given as nested mappings, its files relative to that of its source; see `load`."""
    campaign = validated(Campaign, raw, source)
    folder = Path(source).parent
    given = read_yaml(folder / campaign.study, "a study file such as config/buoy.yaml")
    study, files = read_study(given, str(folder / campaign.study))
    climate = folder / campaign.climate.file
    if campaign.campaign == study.study:
        raise ConfigError(f"{source}: campaign: received {campaign.campaign!r}, the name of its study; needs another")
    if study.hydro.model == "assumed_pressure":
        raise ConfigError(
            f"{source}: study: {campaign.study} has hydro.model 'assumed_pressure', which knows no waves; needs a "
            "study with coefficients"
        )
    if not study.pto.has_damper and "fixed" in (campaign.tuning or ()):
        raise ConfigError(
            f"{source}: tuning: received fixed, but {campaign.study} has no pto.damping; needs one in "
            f"{port_kind(study.pto.port).damping_unit}"
        )
    if DAMPING in campaign.vary.keys and not (study.pto.has_damper and "fixed" in (campaign.tuning or ("fixed",))):
        raise ConfigError(
            f"{source}: vary: {DAMPING}: received without the tuning fixed, and all others have dampers of their own; "
            f"needs fixed in tuning, and a {DAMPING} in {campaign.study}"
        )
    if study.pto.law == CAUSAL:
        raise ConfigError(
            f"{source}: study: {campaign.study} has pto.law 'causal', of runs in time; a year needs another law, and "
            "tuning: [causal]"
        )
    if study.pto.several:
        _check_matrix(campaign, study.pto.port, source)
    ports = {*campaign.vary.values.get(PORT, ())}
    if len({port_kind(port).load for port in ports}) > 1:
        alone = next(name for name in ("volume", "pitch") if name in ports)
        raise ConfigError(
            f"{source}: vary.{PORT}: received {', '.join(map(str, sorted(ports)))}, whose dampers and forces have "
            f"other units; needs {alone} alone, or others without it"
        )
    if campaign.verify and len(campaign.vary.points) > MOST_VERIFIED:
        raise ConfigError(
            f"{source}: verify: received a campaign of {len(campaign.vary.points)} points, each of which is simulated "
            f"in time; needs at most {MOST_VERIFIED}, or no verify"
        )
    if campaign.constrained and "constrained" not in (campaign.tuning or ()):
        raise ConfigError(
            f"{source}: constrained: applies with the tuning constrained only; add it to tuning, or remove this"
        )
    if campaign.verify and not {"fixed", "one", "each", CAUSAL} & {*(campaign.tuning or ("one",))}:
        raise ConfigError(
            f"{source}: verify: received tuning {', '.join(campaign.tuning or ())} alone, whose forces are of no law "
            "in time; needs fixed, one, each or causal beside it"
        )
    if study.KIND == "body":
        campaign, floats_by = _of_a_body(campaign, study, source), {}
    else:
        device = given["device"] if isinstance(given, Mapping) else {}  # mass or draft decides; else half immersion
        mass = {"mass": study.device.mass} if "mass" in device else {}
        floats_by = {"draft": study.draft} if "draft" in device else mass
        _check_buoy(campaign, study, floats_by, source)
    try:
        digest = sha256_of(climate)[:16]
    except OSError as error:
        raise ConfigError(
            f"{source}: climate: received {campaign.climate.file}, which cannot be read ({error.strerror}); needs the "
            "path of a file, or of a folder of spectra, relative to this one"
        ) from None
    return LoadedCampaign(
        campaign=campaign, source=source, base=study, climate_path=str(climate), climate_id=digest,
        floats_by=floats_by, files=files,
    )  # fmt: skip


def _of_a_body(campaign: Campaign, study: Study, source: str) -> Campaign:
    """The campaign of a body, whose runs in time are linear; refused where it varies what a body does not have."""
    keys, mesh = campaign.vary.keys, study.body.file is not None
    if SCALE in keys:
        raise ConfigError(
            f"{source}: vary.{SCALE}: received a body, whose files have one size; needs keys of its study"
        )
    if mesh and (own := [key for key in keys if key.startswith("water.")]):
        raise ConfigError(f"{source}: vary.{own[0]}: the water is that of the body file; needs body.file.{own[0]}")
    if not campaign.verify:
        return campaign
    if "model" in campaign.verify.model_fields_set and campaign.verify.model != "linear":
        raise ConfigError(f"{source}: verify.model: received {campaign.verify.model}; a body needs linear")
    verify = campaign.verify.model_copy(update={"model": "linear"})
    return campaign.model_copy(update={"verify": verify})


def _check_buoy(campaign: Campaign, study: Study, floats_by: Mapping[str, float], source: str) -> None:
    """Check that a year can judge a buoy, and that its draft follows when its radius or shape varies.

    Neither mass nor draft may stay behind: the answer would be of another buoy.
    """
    check_no_direction(campaign.climate, source)
    varied = {*campaign.vary.keys}
    stays = [key for key in floats_by if key == "mass" or SCALE in varied]
    sizes = [key for key in campaign.vary.keys if sizes_hull(key)]
    if sizes and stays and not {"device.mass", "device.draft"} & varied:
        others = "radii" if sizes[0] == "device.radius" else "shapes"
        raise ConfigError(
            f"{source}: vary: {sizes[0]}: received with device.{stays[0]} {floats_by[stays[0]]:g} as given in "
            f"{campaign.study}, with which other {others} float otherwise; needs device.{stays[0]} varied too, a study "
            "that gives neither mass nor draft, or scale alone"
        )


def sizes_hull(key: str) -> bool:
    """Return whether a key is of the hull's size or shape, with which its volume changes."""
    return key in ("device.radius", "device.shape") or key.startswith("device.shape.")


def _check_matrix(campaign: Campaign, port: object, source: str) -> None:
    """Refuse what a damper matrix, at several ports or spread over the shell, does not have in a year."""
    if PORT in campaign.vary.keys:
        raise ConfigError(f"{source}: vary.{PORT}: received several ports in the study; needs a study with one")
    asked, spread = {*(campaign.tuning or ())}, isinstance(port, DistributedPort)
    if optimal := asked & {CONSTRAINED, *(AT_FORCE if spread else ())}:
        there, needed = ("a damper spread over the shell", "") if spread else ("several ports", ", causal")
        raise ConfigError(
            f"{source}: tuning: received {min(optimal)}, and a study with {there}, which has no such optimum; needs "
            f"fixed, one, each{needed}"
        )


def check_no_direction(climate: YearOfSeas, source: str) -> None:
    """Refuse a direction of the seas of a buoy, which answers all alike."""
    if climate.direction:
        raise ConfigError(
            f"{source}: climate.direction: a buoy of revolution answers seas of all directions alike; remove it"
        )


class LoadedCampaign(Section):
    """A campaign, the study it names and its climate file, by content."""

    campaign: Campaign
    source: str
    base: Study
    climate_path: str
    climate_id: str
    floats_by: dict[str, float]  # mass or draft as the study gives it; neither: half immersion
    files: dict[str, str]  # a body is read from, by option of its stage

    @property
    def tuning(self) -> tuple[Tunings, ...]:
        """Tunings asked for; if none are, those for which the study says enough."""
        return self.campaign.tuning or (*(("fixed",) if self.base.pto.has_damper else ()), "one", "each")

    @property
    def constrained(self) -> Constrained | None:
        """Budget of the optima within limits, if they are asked for."""
        return (self.campaign.constrained or Constrained()) if "constrained" in self.tuning else None

    def check_take_off(self, study: Study, where: str) -> None:
        """Check that a nonlinear take-off is not judged by linear theory alone, which does not see it.

        And that its power after conversion is known. Raises `ConfigError`.
        """
        check_conversion(study.pto, f"{where}: pto", self.tuning)
        if study.pto.efficiency < 1 and study.pto.of_package and self.campaign.verify:
            raise ConfigError(
                f"{where}: pto.efficiency: received {study.pto.efficiency:g} with law {study.pto.law}, whose runs in "
                "time give the power at the port; needs 1, or no verify"
            )
        if self.campaign.verify and leading_tuning(self.tuning) == CAUSAL:
            check_in_time(study.pto, where)
        limited = (*AT_FORCE, CONSTRAINED)
        checked = (leading_tuning(self.tuning), *limited) if self.campaign.verify else limited
        blind = [tuning for tuning in self.tuning if tuning not in checked]
        if study.pto.nonlinear and blind:
            raise ConfigError(
                f"{where}: pto: received law {study.pto.law}, force_limit {study.pto.force_limit:g} N, stroke_limit "
                f"{study.pto.stroke_limit:g} m, which linear theory of tuning {blind[0]} does not see; needs tuning: "
                f"[causal] or [constrained], or [{blind[0]}] with verify"
            )


def check_in_time(pto: Pto, where: str) -> None:
    """Check that a causal controller of a year can be run in time; raises `ConfigError`."""
    needed: dict[str, tuple[object, object]] = {
        "law": (pto.law, "linear"),
        "stiffness": (pto.stiffness, 0.0),
        "control.forecast": (pto.control.forecast, 0.0),
        "efficiency": (pto.efficiency, 1.0),
        "port": (len(pto.port.ports) if isinstance(pto.port, SeveralPorts) else 1, 1),
    }
    for name, (received, only) in needed.items():
        if received != only:
            ports = " (of several)" if name == "port" else ""
            raise ConfigError(
                f"{where}: pto.{name}: received {received}{ports}; runs in time of tuning causal need {only}: another "
                "tuning beside it, or no verify"
            )


def check_conversion(pto: Pto, where: str, tunings: Sequence[str]) -> None:
    """Check that the power of a year after conversion is known; raises `ConfigError`."""
    if pto.efficiency == 1.0:
        return
    if CONSTRAINED in tunings:
        raise ConfigError(
            f"{where}.efficiency: received {pto.efficiency:g}; optima of tuning constrained are of the power at the "
            "port: needs 1, or tuning causal, which knows it"
        )
    dampers = [name for name in tunings if name not in AT_FORCE]
    if pto.spring_costs and dampers:
        raise ConfigError(
            f"{where}.stiffness: received {pto.stiffness:g} with an efficiency of {pto.efficiency:g}, through which "
            f"the spring sends power both ways; tuning {dampers[0]} of a year needs stiffness 0 or efficiency 1"
        )


def sections(study: Study) -> dict[str, Any]:
    """Return what a year depends on of a study: linear, its waves, its run in time and its name left out."""
    found: dict[str, Any] = study.model_dump(exclude={"study", "waves", "simulation", "published"})
    linear = {"model": "linear", "power_tolerance": None}
    found["hydro"] = {key: linear.get(key, value) for key, value in found["hydro"].items()}
    return {key: value for key, value in found.items() if value is not None}


def where_of(point: Point) -> str:
    """Return the values of a point in words."""
    return "with " + (", ".join(f"{key}: {value}" for key, value in point.items()) or "nothing varied")


def study_at(base: Mapping[str, Any], point: Point) -> Study:
    """Return a study with values of a point: scaled first, then each key set; linear, in no sea of its own.

    Raises `ConfigError` if it has no such key, or no study has such a value.
    """
    raw = dict(base)
    if SCALE in point:
        raw = scaled(raw, _scale(point[SCALE]))
    where = where_of(point)
    for key, value in point.items():
        if key != SCALE:
            raw = _with(raw, key.split("."), value, key)
    if isinstance(file := raw.get("body", {}).get("file"), dict):
        raw["water"] = file["water"]
    study, _ = read_study({"study": "member", "waves": [{"kind": "still"}], **raw}, where)
    if study.KIND == "buoy" and study.motion == "free":
        raise ConfigError(
            f"{where}: motion: received 'free'; the seas of a year have no directions: needs motion: heave or planar"
        )
    if study.plates:
        raise ConfigError(f"{where}: drag: a year is computed by linear theory, which has no drag; remove it")
    return study


def _scale(value: Value) -> float:
    """A scale of lengths."""
    if isinstance(value, str) or not SMALLEST <= value <= LARGEST:
        raise ConfigError(f"{SCALE}: received {value!r}, needs {SMALLEST:g} to {LARGEST:g}")
    return value


MATRICES = ("body.mass", "body.damping", "body.stiffness")
"""Sections of a study whose keys are degrees of freedom; a study need not have them."""


def _with(raw: Any, path: list[str], value: object, key: str) -> Any:
    """Nested mappings with one value set, in lists counted from 0; the last word may be new: an option."""
    first, *rest = path
    if isinstance(raw, list | tuple):
        if not first.isdigit() or int(first) >= len(raw):
            raise ConfigError(f"{key}: needs a number below {len(raw)} in place of {first}")
        place = int(first)
        return [*raw[:place], _with(raw[place], rest, value, key) if rest else value, *raw[place + 1 :]]
    if rest and not isinstance(raw.get(first) or {}, dict | list | tuple):
        raise ConfigError(f"{key}: {first} is a value, which has no key {rest[0]}")
    if rest and first not in raw and not key.startswith(MATRICES):
        raise ConfigError(f"{key}: the study has no {first}; needs one of {', '.join(raw)}")
    return {**raw, first: _with(raw.get(first) or {}, rest, value, key) if rest else value}
