"""What the stages compute from: frozen values, whose canonical JSON travels to a job and names its result.

Only what a stage reads stands in its specification.
"""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    Discriminator,
    Field,
    SerializerFunctionWrapHandler,
    Tag,
    field_serializer,
    model_serializer,
    model_validator,
)

from vsb.engine.integrators.settings import Simulation
from vsb.engine.motion.take_off import Pto
from vsb.engine.shell.device import Basis, Device, Shape, centre_height
from vsb.engine.waves.kinds import StillWater, Wave
from vsb.engine.waves.water import Water
from vsb.keys.quantities import Brief, Name, Section
from vsb.study.body import AnyStudy, Body, BodyDesign, BodyHydro
from vsb.study.campaign import CAUSAL, Constrained, Scatter, Spectra, Tunings, Verify
from vsb.study.design import CONTROLLED, LEAST_STROKE, DesignTuning, Fatigue, Objective, Variable
from vsb.study.sections import BodyDrag, Design, Drag, Hydro, Modes, Mooring, Motion, RestShape
from vsb.study.study import Buoy, Study, WithDesigns, first_rigid
from vsb.study.vary import Vary

PHYSICS = {
    "block": 4, "body": 1, "campaign": 3, "compare": 9, "database": 1, "design_front": 12,
    "design_results": 13, "design_start": 14, "design_verification": 7, "ladder": 18, "member": 16,
    "members": 1, "mesh": 2, "radiation": 4, "response": 10, "simulate": 16, "verification": 8, "witness": 2,
}  # fmt: skip
"""Hand-bumped version of the physics behind each tag: a library edit alone never reruns anything."""


class Spec(Section):
    """Specification of one stage, with the version of its physics."""

    TAG: ClassVar[str]
    stage: str = ""
    physics: int = 0

    @model_validator(mode="before")
    @classmethod
    def _tagged(cls, raw: Any) -> Any:
        """Tag a specification made here; one that was read must be of this stage and of today's physics."""
        tags: dict[str, Any] = {"stage": cls.TAG, "physics": PHYSICS[cls.TAG]}
        if not isinstance(raw, dict):
            return raw
        for key, value in tags.items():
            if (received := raw.get(key, value)) != value:
                raise ValueError(f"{key} {received!r}: needs {value!r}, of this version; run vsb run CONFIG again")
        return {**raw, **tags}


class Sphere(Section):
    """Undeformed wetted shape: radius and height of the centre above still water [m], of a sphere but for a shape."""

    radius: float
    centre_height: float
    shape: Shape | None = None


class Shapes(Sphere):
    """Undeformed shell, and all that the shapes of its modes follow from."""

    thickness: float
    poisson_ratio: float
    basis: Basis


class FloatingSpec(Spec):
    """Specification of a buoy at rest in the directions it moves in."""

    device: Device
    water: Water
    motion: Motion = "heave"
    mooring: Mooring | None = None

    @property
    def centre_height(self) -> float:
        """Height of the sphere's centre above still water at rest [m]."""
        return centre_height(self.device, self.water)


class RestSpec(FloatingSpec):
    """Specification of a buoy and the shape it rests in; without modes it is rigid."""

    modes: Modes | None
    reference_shape: RestShape

    @property
    def flexible(self) -> bool:
        """Whether the shell has modes."""
        return self.modes is not None

    @property
    def at_equilibrium(self) -> bool:
        """Whether it is about the shape the loaded shell takes at rest."""
        return self.flexible and self.reference_shape == "equilibrium"


class Sparse(Section):
    """A section in whose JSON stands what was given, or has a default: not what is None because it is absent."""

    @model_serializer(mode="wrap")
    def _without_absent(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        said: dict[str, Any] = dump(self)
        return {key: value for key, value in said.items() if value is not None or key in self.model_fields_set}


class BuoySystem(Sparse, Buoy):
    """A buoy as a stage reads it; absent is what the stage does not need."""

    device: Device
    water: Water
    motion: Motion = "heave"
    mooring: Mooring | None = None
    modes: Modes
    designs: dict[Name, Design]
    pto: Pto
    reference_shape: RestShape | None = None
    drag: Drag | None = None


class BodySystem(Sparse, WithDesigns):
    """A body as a stage after its database reads it, which knows all else."""

    designs: dict[Name, BodyDesign]
    water: Water
    pto: Pto
    drag: BodyDrag | None = None

    @property
    def buoy(self) -> None:
        """There is none."""


AnySystem = Annotated[
    Annotated[BuoySystem, Tag("buoy")] | Annotated[BodySystem, Tag("body")],
    Discriminator(lambda value: "buoy" if isinstance(value, BuoySystem) or "device" in dict(value) else "body"),
]
"""What floats."""


class SystemSpec(Spec):
    """Specification of a stage that works on what floats; in its JSON the sections of that stand beside its own."""

    system: AnySystem

    @model_validator(mode="before")
    @classmethod
    def _nested(cls, raw: Any) -> Any:
        if not isinstance(raw, dict) or "system" in raw:
            return raw
        own = {key: value for key, value in raw.items() if key in cls.model_fields}
        return {**own, "system": {key: value for key, value in raw.items() if key not in own}}

    @model_serializer(mode="wrap")
    def _flat(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        said: dict[str, Any] = dump(self)
        own = {key: value for key, value in said.items() if value is not None or key in self.model_fields_set}
        return {**own.pop("system"), **own}

    @property
    def buoy(self) -> BuoySystem | None:
        """The buoy; None if a body floats."""
        return self.system if isinstance(self.system, BuoySystem) else None

    def with_take_off(self, pto: Pto) -> Self:
        """Return the same with another take-off."""
        return self.model_copy(update={"system": self.system.model_copy(update={"pto": pto})})

    @property
    def designs(self) -> Mapping[str, Design | BodyDesign]:
        """Designs by name."""
        return self.system.designs

    @property
    def pto(self) -> Pto:
        """The take-off."""
        return self.system.pto

    @property
    def water(self) -> Water:
        """The water."""
        return self.system.water

    @property
    def reference_design(self) -> str | None:
        """The first rigid design by name: gains are relative to it."""
        return first_rigid(self.designs)


class LoadedShape(Spec):
    """Wetted shape of a shell that its load deforms at rest; neither its damping nor the depth matters."""

    TAG = "mesh"
    radius: float
    centre_height: float
    device: Device
    modes: Modes
    water: Water
    reference_shape: RestShape
    flexible: ClassVar[bool] = True

    @property
    def at_equilibrium(self) -> bool:
        """Whether that is the shape the loaded shell takes at rest."""
        return self.reference_shape == "equilibrium"

    @field_serializer("device")
    def _without_damping(self, device: Device) -> dict[str, Any]:
        return device.model_dump(exclude={"damping"})

    @field_serializer("water")
    def _without_depth(self, water: Water) -> dict[str, Any]:
        return water.model_dump(exclude={"depth"})


class Rows(Section):
    """Resolution of a mean mesh: rows of panels from keel to waterline, panels around, rows of the lid."""

    rows: int
    azimuth: int
    lid_rows: int


class SphereMesh(Spec, Sphere, Rows):
    """Mean wetted mesh of a sphere."""

    TAG = "mesh"


class LoadedMesh(LoadedShape, Rows):
    """Mean wetted mesh of a shell deformed by its load."""


class DeformedSpec(Spec, Rows):
    """Meshes of a shell at rest and deformed by either sign of each mode, clear of the bottom."""

    TAG = "mesh"
    shape: Sphere | Shapes | LoadedShape
    deformed: tuple[str, ...]
    depth: float


class WitnessSpec(Spec):
    """What panels and the spectral solver are both asked: shapes, water, frequencies [rad/s]."""

    TAG = "witness"
    solver: str
    meshes: DeformedSpec
    water: Water
    omega: tuple[float, ...]


class DisplaySpec(RestSpec):
    """Viewable meshes: mean and deformed wetted shells."""

    TAG = "mesh"


class ModesSpec(WithDesigns, RestSpec):
    """Shell modes of a study."""

    TAG = "mesh"
    modes: Modes
    designs: dict[Name, Design]


AnyBuoy = Study | BuoySystem
"""A buoy with its designs and take-off."""
AtRest = AnyBuoy | RestSpec | LoadedShape
"""What a shape at rest follows from."""
Designed = AnyBuoy | ModesSpec
"""What has designs."""


class Block(Spec):
    """Coefficients of displacements at frequencies [rad/s], as many of them solved as `interpolation` [-] asks for."""

    TAG = "block"
    solver: str
    water: Water
    displacements: tuple[str, ...]
    omega: tuple[float, ...]
    interpolation: float | None = None
    order: int = 0


class PanelsSpec(Block):
    """A block of frequencies by panels."""

    mesh: SphereMesh | LoadedMesh


class SpectralSpec(Block):
    """A block of frequencies without panels."""

    shape: Sphere | LoadedShape
    tolerance: float


class DatabaseSpec(RestSpec):
    """Hydro database: ids of the blocks in use, the modes and the structure, the checks whose failure is accepted."""

    TAG = "database"
    sweep: tuple[str, ...]
    tabulated: tuple[str, ...]
    omega: tuple[float, ...]
    omega_max: float
    tolerance: float
    accept: tuple[str, ...]


class BodySpec(Spec):
    """Hydro database of a body: its source by contents, its matrices, the degrees of freedom kept; none: all."""

    TAG = "body"
    body: Body
    water: Water
    dofs: tuple[str, ...] | None
    omega_max: float | None  # highest frequency kept [rad/s]; none: all
    accept: tuple[Name, ...]
    solver: str = ""  # of a mesh, and the version of what solves it
    solved: int = 0
    repair: tuple[Name, ...] = ()  # checks whose failure is repaired


class FrequenciesSpec(Spec):
    """Frequencies of a body on panels [rad/s] that are solved apart from its others."""

    TAG = "body"
    body: Body  # its mesh alone
    omega: tuple[float, ...]
    solver: str
    solved: int


class RadiationSpec(Sparse, Spec):
    """Radiation memory of a database, by its id; of a body also which added mass at infinite frequency it has."""

    TAG = "radiation"
    database: str
    tolerance: float
    added_mass_inf: Literal["fitted", "given"] | None = None


class ResponseSpec(SystemSpec):
    """Frequency response of all designs: the step, ends and further frequencies of its grid [rad/s].

    Without a step the grid is that of the database, refined.
    """

    TAG = "response"
    step: float | None = None
    lowest: float | None = None
    omega_max: float | None = None
    omega: tuple[float, ...]
    directions: tuple[float, ...] = ()  # of the waves [degrees]; empty if all go along x


class Band(Section):
    """What the control levels read of the section `hydro`."""

    omega_max: float


class Dynamics(Band):
    """What a run in time reads of the section `hydro`."""

    model: str
    pressure: float | None
    power_tolerance: float | None


class ClimateSpec(Brief):
    """The seas of a year: sha256 of the file, and what it is read as."""

    BRIEF = ("direction",)
    contents: str
    form: Literal["spectra", "jonswap", "pierson_moskowitz"]  # of a table the spectrum of its cells
    gamma: float | None = None
    direction: float = 0.0  # [degrees]

    @classmethod
    def of(cls, given: Spectra | Scatter, contents: str) -> Self:
        """Return the seas of a file as a campaign or a design names it, its contents by their sha256."""
        if isinstance(given, Scatter):
            gamma = given.gamma if given.spectrum == "jonswap" else None
            return cls(contents=contents, form=given.spectrum, gamma=gamma, direction=given.direction)
        return cls(contents=contents, form="spectra", direction=given.direction)


class SeasSpec(SystemSpec):
    """Specification of a stage that works on what floats in seas."""

    waves: tuple[Wave, ...]
    simulation: Simulation
    hydro: Band | None = None

    @property
    def band(self) -> tuple[float, float] | None:
        """Frequencies a sea may have components at [rad/s]; None where the database decides."""
        return (0.0, self.hydro.omega_max) if self.hydro else None


class LadderSpec(SeasSpec):
    """Control levels of all designs in all seas."""

    TAG = "ladder"


class SimulateSpec(SeasSpec):
    """One design in one sea; `seas` are those its damper is tuned to, where one damper serves all seas."""

    TAG = "simulate"
    hydro: Dynamics | None = None
    seas: tuple[Wave, ...] = ()


class CompareSpec(Spec):
    """Comparison of all designs in all seas: the whole study."""

    TAG = "compare"
    study: AnyStudy


class MemberSpec(SystemSpec):
    """One point of a campaign: a study without seas over a year, every design and tuning.

    `sweep` are the coefficients by id: blocks of a buoy's shape, or the database of a body.
    """

    TAG = "member"
    hydro: Hydro | BodyHydro
    sweep: tuple[str, ...]
    climate: ClimateSpec
    tuning: tuple[Tunings, ...]
    constrained: Constrained | None = None


RUN_BY = ("member", "database", "radiation", "simulate")
"""Tags of the physics runs in time of a member rest on, beside their own."""


class VerificationSpec(MemberSpec):
    """One point of a campaign under one tuning, and the runs in time its year is corrected by."""

    TAG = "verification"
    simulation: Simulation
    verify: Verify
    versions: dict[str, int] = Field(default_factory=lambda: {tag: PHYSICS[tag] for tag in RUN_BY})

    @property
    def simulated(self) -> Study:
        """The study of the member, a buoy's, in no sea of its own."""
        parts = dict(self.system) | {"hydro": self.hydro, "simulation": self.simulation}
        return Study(study="member", waves=(StillWater(kind="still"),), **parts)


class MembersSpec(Spec):
    """Some points of a campaign: sections of its study, and what each point sets in them."""

    TAG = "members"
    base: dict[str, Any]
    points: tuple[dict[str, float | str], ...]
    climate: ClimateSpec
    tuning: tuple[Tunings, ...]
    constrained: Constrained | None = None


class CampaignSpec(Spec):
    """A whole campaign: what is varied of which sections, and its batches by id, each with the members it holds."""

    TAG = "campaign"
    campaign: str
    study: str
    base: dict[str, Any]
    vary: Vary
    climate: ClimateSpec
    climate_name: str
    tuning: tuple[Tunings, ...]
    batches: tuple[str, ...]
    members: tuple[str, ...]
    verifications: tuple[str, ...] = ()  # by id, in the order of the members; none if nothing is simulated in time


class Search(Brief):
    """What one buoy is optimised over: a design of a study in a site's year, its variables, objective and limits."""

    base: dict[str, Any]  # sections of the study
    design: str
    climate: ClimateSpec
    variables: tuple[Variable, ...]
    maximise: Objective
    limits: dict[str, float]
    degrees: tuple[int, ...] = ()  # of shell modes, to be tried in turn, the last two for errors; none of a rigid buoy
    tolerance: float = 0.0  # change of the power by the next two degrees that is small enough
    cost: dict[str, float] = Field(default_factory=dict)  # prices by the quantity they are of
    fatigue: Fatigue | None = None  # what the wall of a flexible buoy bears
    sigmas: float = 0.0  # standard deviations by the uncertain inputs that limits are kept away by
    uncertain: dict[str, float] = Field(default_factory=dict)  # those of these inputs, relative; none without sigmas
    tuning: DesignTuning = "one"

    BRIEF: ClassVar[tuple[str, ...]] = ("tuning", "fatigue")

    @property
    def kept(self) -> dict[str, float]:
        """Limits that the search keeps.

        That of force is kept by the damper matrix of several ports, those of force and stroke by a causal controller,
        if it can.
        """
        if self.tuning != CAUSAL:
            return {name: limit for name, limit in self.limits.items() if not (self.several and name == "force_rms")}
        found = {name: limit for name, limit in self.limits.items() if name not in CONTROLLED}
        return found | ({LEAST_STROKE: self.limits["stroke_rms"]} if "stroke_rms" in self.limits else {})

    @property
    def several(self) -> bool:
        """Whether the take-off acts at several ports."""
        return "ports" in self.base["pto"].get("port", "heave")

    @property
    def flexible(self) -> bool:
        """Whether the buoy that is optimised has a shell."""
        return bool(self.degrees)


class DesignStartSpec(Spec):
    """The best buoy from one of several starts."""

    TAG = "design_start"
    search: Search
    seed: int
    start: int  # from 0; how many there are changes none


class DesignFrontSpec(Spec):
    """The best buoys over the values of one limit, from the best of some starts."""

    TAG = "design_front"
    search: Search
    limit: str
    values: tuple[float, ...]
    starts: tuple[str, ...]  # by id


class DesignVerificationSpec(Spec):
    """The best flexible buoy and the best rigid one in the same seas in time."""

    TAG = "design_verification"
    flexible: Search
    rigid: Search
    verify: Verify
    simulation: Simulation
    starts: tuple[str, ...]  # by id
    rigid_starts: tuple[str, ...]
    versions: dict[str, int] = Field(default_factory=lambda: {tag: PHYSICS[tag] for tag in RUN_BY})


class DesignSpec(Spec):
    """A whole design problem: the best flexible buoy beside the best rigid one."""

    TAG = "design_results"
    name: str
    study: str
    climate_name: str
    flexible: Search
    rigid: Search
    starts: tuple[str, ...]  # by id
    rigid_starts: tuple[str, ...]
    fronts: tuple[str, ...] = ()  # of the flexible and the rigid buoy in turn, by id
    pareto: tuple[str, ...] = ()  # limits of the fronts
    uncertain: dict[str, float] = Field(default_factory=dict)
    verification: str | None = None
    runs: dict[str, Any] = Field(
        default_factory=dict
    )  # waves and simulation of the study, for studies that are written
    notes: tuple[str, ...] = ()  # what is to be said of the problem
