"""What the stages compute from: frozen values, whose canonical JSON travels to a job and names its result.

Only what a stage reads stands in its specification.
"""

from typing import Any, ClassVar, Literal

from pydantic import Field, field_serializer, model_validator

from vsb.study.body import Body, BodyDesign, BodyStudy
from vsb.study.campaign import Constrained, Tunings, Verify
from vsb.study.device import Device, Shape, centre_height, keel_depth
from vsb.study.directions import Drag, Mooring, Motion
from vsb.study.quantities import Name, Section
from vsb.study.sections import Basis, Design, Hydro, Modes, RestShape, Simulation, Water
from vsb.study.study import Study
from vsb.study.take_off import Pto, opens_chamber
from vsb.study.vary import Vary
from vsb.study.waves import StillWater, Wave

PHYSICS = {
    "block": 1, "body": 1, "campaign": 1, "compare": 1, "database": 1, "degree": 1, "ladder": 1, "member": 2,
    "members": 1, "mesh": 1, "radiation": 1, "response": 1, "simulate": 1, "verification": 1, "witness": 1,
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
    """Specification of what floats, in the directions it moves in."""

    device: Device
    water: Water
    motion: Motion = "heave"
    mooring: Mooring | None = None

    @property
    def centre_height(self) -> float:
        """Height of the sphere's centre above still water at rest [m]."""
        return centre_height(self.device, self.water)


class RestSpec(FloatingSpec):
    """Specification of what rests in a shape of its own; without modes it is rigid."""

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


class DesignsSpec(FloatingSpec):
    """Specification of designs that share a shell."""

    modes: Modes
    designs: dict[Name, Design]

    @property
    def flexible(self) -> bool:
        """Whether any design needs shell modes."""
        return any(design.flexible for design in self.designs.values())

    @property
    def reference_design(self) -> str | None:
        """The first rigid design by name: gains are measured against it."""
        return next((name for name, design in sorted(self.designs.items()) if not design.flexible), None)


class DesignsAtRest(DesignsSpec, RestSpec):
    """Specification of designs that share a shape at rest."""

    modes: Modes


class DrivenSpec(DesignsSpec):
    """Specification of designs with a take-off."""

    pto: Pto

    @property
    def opens_chamber(self) -> bool:
        """Whether the take-off lets trapped gas in and out."""
        return opens_chamber(self.device, self.pto)


class DraggedSpec(DrivenSpec):
    """Specification of designs whose motion a drag may brake."""

    drag: Drag | None = None

    @property
    def draft(self) -> float:
        """Depth of the keel below still water [m]."""
        return keel_depth(self.device, self.centre_height)


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


Designed = Study | DesignsSpec
"""What has designs."""
Driven = Study | DrivenSpec
"""What has a take-off, too."""
AtRest = Study | RestSpec | LoadedShape
"""What a shape at rest follows from."""


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


class ModesSpec(DesignsAtRest):
    """Shell modes of a study."""

    TAG = "mesh"


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


class RadiationSpec(Spec):
    """Radiation model of a database, by its id."""

    TAG = "radiation"
    database: str
    tolerance: float


class ResponseSpec(DrivenSpec):
    """Frequency response of all designs: step, ends and further frequencies of its grid [rad/s]."""

    TAG = "response"
    step: float
    lowest: float
    omega_max: float
    omega: tuple[float, ...]
    directions: tuple[float, ...] = ()  # of the waves [degrees]; all along x


class Dynamics(Section):
    """What a run in time reads of the section `hydro`."""

    model: str
    pressure: float | None
    power_tolerance: float | None
    omega_max: float


class Band(Section):
    """What the tuning ladder reads of the section `hydro`."""

    omega_max: float


class ClimateSpec(Section):
    """The seas of a year: sha256 of the file, and what it is read as."""

    contents: str
    form: Literal["spectra", "jonswap", "pierson_moskowitz"]  # of a table the spectrum of its cells
    gamma: float | None = None


class LadderSpec(DesignsAtRest, DraggedSpec):
    """Tuning ladder of all designs in all seas."""

    TAG = "ladder"
    waves: tuple[Wave, ...]
    simulation: Simulation
    hydro: Band


class DegreeSpec(LadderSpec):
    """Search for the degree of the shell modes: what powers follow from, in seas of a study or in those of a year."""

    TAG = "degree"
    climate: ClimateSpec | None = None


class SimulateSpec(DesignsAtRest, DraggedSpec):
    """One design in one sea; `seas` are those its damper is to suit, where one is for all."""

    TAG = "simulate"
    simulation: Simulation
    waves: tuple[Wave, ...]
    hydro: Dynamics
    seas: tuple[Wave, ...] = ()


class CompareSpec(Spec):
    """Comparison of all designs in all seas: the whole study."""

    TAG = "compare"
    study: Study


class MemberSpec(DesignsAtRest, DrivenSpec):
    """One point of a campaign: a study without seas over a year, every design and tuning; blocks of its sweep by id."""

    TAG = "member"
    hydro: Hydro
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
        """The study of the member, in no sea of its own."""
        parts = {name: value for name, value in self if name in Study.model_fields}
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


class BodyRadiationSpec(Spec):
    """Radiation memory of a body's database, by its id."""

    TAG = "radiation"
    database: str
    tolerance: float
    added_mass_inf: Literal["fitted", "given"]


class OfDesigns(Spec):
    """What every stage after the database reads of a study."""

    designs: dict[Name, BodyDesign]
    water: Water
    pto: Pto

    @property
    def reference_design(self) -> str | None:
        """The first rigid design by name: gains are measured against it."""
        return next((name for name, design in sorted(self.designs.items()) if design.rigid), None)


class BodyResponseSpec(OfDesigns):
    """Frequency response of all designs in waves of some directions [degrees]; further frequencies [rad/s]."""

    TAG = "response"
    directions: tuple[float, ...]
    omega: tuple[float, ...]


class BodyLadderSpec(OfDesigns):
    """Tuning ladder of all designs in all seas."""

    TAG = "ladder"
    waves: tuple[Wave, ...]
    simulation: Simulation


class BodySimulateSpec(OfDesigns):
    """One design in one sea; `seas` are those its damper is to suit, where one is for all."""

    TAG = "simulate"
    waves: tuple[Wave, ...]
    simulation: Simulation
    seas: tuple[Wave, ...] = ()


class BodyCompareSpec(Spec):
    """Comparison of all designs in all seas: the whole study."""

    TAG = "compare"
    study: BodyStudy
