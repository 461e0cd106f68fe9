"""What the stages compute from: frozen values, whose canonical JSON travels to a job and names its result.

Only what a stage reads stands in its specification.
"""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Field, PlainValidator, SerializeAsAny

from vsb.engine.integrators.settings import Simulation
from vsb.engine.shell.device import Basis, Shape
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.water import Water
from vsb.keys.quantities import Brief, Name, Section
from vsb.study.body import Body
from vsb.study.campaign import CAUSAL, ClimateFile, Constrained, Tunings, Verify
from vsb.study.design import CONTROLLED, LEAST_STROKE, DesignTuning, Fatigue, Objective, Variable
from vsb.study.study import Study
from vsb.study.vary import Vary

PHYSICS = {
    "block": 5, "body": 1, "campaign": 4, "compare": 10, "database": 2, "design_front": 14,
    "design_results": 16, "design_start": 16, "design_verification": 8, "ladder": 22, "member": 20,
    "members": 1, "mesh": 2, "radiation": 4, "response": 12, "simulate": 18, "verification": 8, "witness": 2,
}  # fmt: skip
"""Hand-bumped version of the physics behind each tag: a library edit alone never reruns anything."""
RUN_BY = {tag: PHYSICS[tag] for tag in ("member", "database", "radiation", "simulate")}
"""Versions of the physics that runs in time of a member rest on, beside their own."""


def spec_of(tag: str, **reads: Any) -> dict[str, Any]:
    """Return all that a result follows from, beside other results: the version of its physics, and what is read.

    Further `versions` may stand there by their names.
    """
    return {"stage": tag, "physics": PHYSICS[tag], **reads}


def _read_study(value: Any) -> Any:
    """What a stage reads of a study, from its JSON."""
    return Study.part(value) if isinstance(value, Mapping) else value


StudyPart = Annotated[SerializeAsAny[Study], PlainValidator(_read_study)]
"""Of a study what a stage reads, and nothing else (`Section.only`)."""


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


def _read_shape(value: Any) -> Any:
    """A shape at rest from its JSON."""
    if not isinstance(value, Mapping) or "device" in value:
        return _read_study(value)
    return (Shapes if "basis" in value else Sphere).model_validate(value)


AnyShape = Annotated[SerializeAsAny[Sphere | Shapes | Study], PlainValidator(_read_shape)]
"""A wetted shape: undeformed, or of a buoy that its load deforms at rest."""


class Rows(Section):
    """Resolution of a mean mesh: rows of panels from keel to waterline, panels around, rows of the lid."""

    rows: int
    azimuth: int
    lid_rows: int


class Mesh(Rows):
    """Mean wetted mesh of a shape at rest."""

    shape: AnyShape


class DeformedMeshes(Mesh):
    """Meshes of a shell at rest and deformed by either sign of each mode, clear of the bottom."""

    deformed: tuple[str, ...]
    depth: float

    @property
    def count(self) -> int:
        """Number of shapes."""
        return 1 + 2 * len(self.deformed)


class Block(Section):
    """Coefficients of displacements at frequencies [rad/s], as many of them solved as `interpolation` [-] asks for."""

    solver: str
    water: Water
    displacements: tuple[str, ...]
    omega: tuple[float, ...]
    interpolation: float | None = None
    order: int = 0


class PanelsBlock(Block):
    """A block of frequencies by panels."""

    mesh: Mesh


class SpectralBlock(Block):
    """A block of frequencies without panels."""

    shape: AnyShape
    tolerance: float


class BodySource(Section):
    """Hydro database of a body: its source by contents, its matrices, the degrees of freedom kept; none: all."""

    body: Body
    water: Water
    dofs: tuple[str, ...] | None
    omega_max: float | None  # highest frequency kept [rad/s]; none: all
    accept: tuple[Name, ...]
    repair: tuple[Name, ...] = ()  # checks whose failure is repaired


class Run(Section):
    """One design in one sea; `seas` are those its damper is tuned to, where one damper serves all seas."""

    study: StudyPart
    seas: tuple[Wave, ...] = ()


class MemberSpec(Section):
    """One point of a campaign: a study without seas over a year, every design and tuning.

    `sweep` are the coefficients by id: blocks of a buoy's shape, or the database of a body.
    """

    study: StudyPart
    sweep: tuple[str, ...]
    climate: ClimateFile
    tuning: tuple[Tunings, ...]
    constrained: Constrained | None = None


class VerificationSpec(MemberSpec):
    """One point of a campaign under one tuning, and the runs in time its year is corrected by."""

    verify: Verify


class CampaignSpec(Section):
    """A whole campaign: what is varied of which sections, and its batches by id, each with the members it holds."""

    campaign: str
    study: str
    base: dict[str, Any]
    vary: Vary
    climate: ClimateFile
    climate_name: str
    tuning: tuple[Tunings, ...]
    batches: tuple[str, ...]
    members: tuple[str, ...]
    verifications: tuple[str, ...] = ()  # by id, in the order of the members; none if nothing is simulated in time


class Search(Brief):
    """What one buoy is optimised over: a design of a study in a site's year, its variables, objective and limits."""

    base: dict[str, Any]  # sections of the study
    design: str
    climate: ClimateFile
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


class DesignVerificationSpec(Section):
    """The best flexible buoy and the best rigid one in the same seas in time."""

    flexible: Search
    rigid: Search
    verify: Verify
    simulation: Simulation
    starts: tuple[str, ...]  # by id
    rigid_starts: tuple[str, ...]


class DesignSpec(Section):
    """A whole design problem: the best flexible buoy beside the best rigid one."""

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
