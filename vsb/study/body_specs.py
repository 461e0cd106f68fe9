"""What the stages of a study of a body compute from: its database knows the body, all others its designs and seas."""

from typing import Literal

from vsb.study.body import Body, BodyDesign, BodyStudy
from vsb.study.quantities import Name
from vsb.study.sections import Simulation, Water
from vsb.study.specs import Spec
from vsb.study.take_off import Pto
from vsb.study.waves import Wave


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
