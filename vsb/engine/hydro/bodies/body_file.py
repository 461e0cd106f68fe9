"""A body file: mesh, modes, water, frequencies of a body that is solved on panels."""

import math
from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import (
    Discriminator,
    Field,
    Tag,
    field_validator,
    model_validator,
)

from vsb.engine.hydro.bodies.plain_hulls import BoxHull, CapsuleHull, CylinderHull, PlacedMesh, SphereHull
from vsb.engine.hydro.labels import RIGID
from vsb.engine.hydro.panel_solver import LEAST_DEPTH_IN_WAVENUMBERS
from vsb.engine.waves.water import Water
from vsb.keys.quantities import Brief, Count, Finite, Name, NonNegative, Number, Positive, Section

PHYSICS = 4
"""Hand-bumped version of the physics behind a block."""


Frequency = Annotated[Number, Field(ge=1e-3, le=1e3)]
"""Frequencies of gravity waves on Earth, tsunamis and ripples among them [rad/s]."""


Direction = Annotated[Number, Field(ge=-360, le=360)]


RigidMotion = Literal["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]


MOST_MODES = 20
"""Modes of bending, or polynomials."""


MOST_DEGREE = 12
"""Degree of a plate's polynomials."""


class Line(Section):
    """Modes of a beam along an axis of the hull, `count` of them, with its bending stiffness EI [N m^2]."""

    count: Annotated[Count, Field(ge=1, le=MOST_MODES)]
    axis: Literal["x", "y"] = "x"
    stiffness: NonNegative = 0.0


class Hinge(Section):
    """A hinge across an axis of the hull: its place along the axis and its height [m], its stiffness [N m/rad]."""

    at: tuple[Finite, Finite]
    axis: Literal["x", "y"] = "x"
    stiffness: NonNegative = 0.0


class RoundPlate(Section):
    """Bending modes of a round plate up to a polynomial degree, its stiffness D = E h^3/12(1 - nu^2) [N m], and nu."""

    degree: Annotated[Count, Field(ge=2, le=MOST_DEGREE)]
    stiffness: NonNegative = 0.0
    poisson_ratio: Annotated[Number, Field(ge=0, le=0.5)] = 0.3


class ModeFamilies(Brief):
    """Modes by name: rigid motions, all or some; bending or polynomials along the hull; a round plate's; hinges."""

    BRIEF = ("plate",)
    rigid: bool | tuple[RigidMotion, ...] = True
    bending: Line | None = None
    polynomial: Line | None = None
    hinge: tuple[Hinge, ...] = ()
    plate: RoundPlate | None = None

    @field_validator("hinge", mode="before", json_schema_input_type=Hinge | tuple[Hinge, ...])
    @classmethod
    def _one_or_many(cls, value: object) -> object:
        return value if isinstance(value, list | tuple) else (value,)

    @model_validator(mode="after")
    def _some(self) -> Self:
        if self.bending and self.polynomial:
            raise ValueError("polynomial: received beside bending, which it nearly repeats; needs one of them")
        if not (self.rigid or self.bending or self.polynomial or self.hinge or self.plate):
            raise ValueError("rigid: received none, and no other modes; needs at least one")
        return self


def _modes_kind(value: object) -> str:
    """Which kind of modes is meant, by its form."""
    if isinstance(value, dict | ModeFamilies):
        return "families"
    return "names" if isinstance(value, list | tuple) else "path"


Modes = Annotated[
    Annotated[str, Tag("path")]
    | Annotated[tuple[RigidMotion, ...], Tag("names")]
    | Annotated[ModeFamilies, Tag("families")],
    Discriminator(_modes_kind),
]
"""A file of displacements, `rigid` for the six rigid motions, some of these by their names, or families of modes."""


def _mass_kind(value: object) -> str:
    """Whether a mass is a word; YAML reads 1e3 as one, too."""
    try:
        float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return "displaced" if isinstance(value, str) else "number"
    return "number"


Mass = Annotated[
    Annotated[Literal["displaced"], Tag("displaced")] | Annotated[Positive, Tag("number")],
    Discriminator(_mass_kind),
]
"""A mass [kg], or that of the water displaced."""


Point = tuple[Finite, Finite, Finite]


DRY = ("mass", "density", "centre_of_mass", "radii_of_gyration", "rotation_point")
"""Keys of the dry body, for modes that are made here; a file of displacements has its own."""


def _mesh_kind(value: object) -> str:
    """Which kind of mesh is meant, by its form."""
    if isinstance(value, str):
        return "path"
    return "placed" if isinstance(value, PlacedMesh) or (isinstance(value, dict) and "file" in value) else "hull"


PlainHull = SphereHull | CylinderHull | CapsuleHull | BoxHull


Mesh = Annotated[
    Annotated[str, Tag("path")]
    | Annotated[PlacedMesh, Tag("placed")]
    | Annotated[Annotated[PlainHull, Field(discriminator="kind")], Tag("hull")],
    Discriminator(_mesh_kind),
]
"""A mesh file, in metres or another unit, or a plain hull that is meshed here."""


class BodyFile(Brief):
    """A body file: mesh, modes, water, frequencies [rad/s], wave directions [degrees], symmetry and lid.

    Paths count from the folder of the file. Panels with edges longer than `panel` [m] are divided, as triangles.
    Symmetry `auto` is what the panels have. `lid` is the largest number of panels on the water inside between the
    middle and the waterline; without it (0) coefficients at irregular frequencies are wrong. Below them there is none.
    With a `tolerance` [-] of interpolation only as many of the frequencies are solved as it asks for, without all.

    Modes `rigid`, or names of rigid motions, are made here, rotations about `centre_of_mass` [m]. Their mass matrix is
    that of `mass` [kg] or of a `density` [kg/m^3], with `radii_of_gyration` about the axes through the centre of mass
    [m]. Centre and radii that are not given are those of the mesh filled evenly, for which it must be closed. A
    `rotation_point` [m] takes the place of the centre of mass as what rigid rotations are about. Families of modes add
    bending, polynomials and hinges; each section of the hull then carries the mass of the water it displaces.
    """

    BRIEF = (*DRY, "panel")
    body: Name
    mesh: Mesh
    modes: Modes
    mass: Mass | None = None
    density: Positive | None = None
    centre_of_mass: Point | None = None
    radii_of_gyration: tuple[Positive, Positive, Positive] | None = None
    rotation_point: Point | None = None
    panel: Positive | None = None
    water: Water = Water()
    omega: tuple[Frequency, ...]
    wave_direction: tuple[Direction, ...] = (0.0,)
    symmetry: Literal["auto", "none", "xOz", "yOz", "xOz+yOz"] = "auto"
    lid: Annotated[Count, Field(ge=0, le=64)] = 8
    tolerance: Annotated[Number, Field(ge=1e-5, le=0.1)] | None = None

    @model_validator(mode="after")
    def _usable(self) -> Self:
        for name, values in (("omega", self.omega), ("wave_direction", self.wave_direction)):
            if not values or list(values) != sorted(set(values)):
                raise ValueError(f"{name} {list(values)}: needs at least one value, ascending without repetition")
        kd, water = LEAST_DEPTH_IN_WAVENUMBERS, self.water
        lowest = math.sqrt(kd * math.tanh(kd) * water.gravity / water.depth)
        if self.omega[0] < lowest:
            raise ValueError(
                f"omega {self.omega[0]:g} rad/s: in {water.depth:g} m of water needs at least {lowest:.4g}"
            )
        return self

    @model_validator(mode="after")
    def _dry(self) -> Self:
        """Masses are of rigid motions made here, and of one source."""
        given = [name for name in DRY if getattr(self, name) is not None]
        if self.rigid_motions is None:
            if self.hull:
                raise ValueError(
                    f"modes: received {self.modes!r}; a {self.hull.kind} needs rigid, or names such as Heave"
                )
            if isinstance(self.mesh, PlacedMesh) and self.mesh != PlacedMesh(file=self.mesh.file):
                raise ValueError(
                    "mesh: the displacements in the file of modes are of the mesh as it is; needs metres, z upwards "
                    "and still water at z = 0"
                )
            if self.panel is not None:
                raise ValueError("panel: the file of modes has displacements of these panels alone; remove it")
            if given:
                raise ValueError(f"{given[0]}: is given by the file of modes; remove it here, or use modes: rigid")
            return self
        named = self.rigid_motions
        if len(set(named)) < len(named) or not (named or self.families):
            raise ValueError(f"modes {list(self.rigid_motions)}: needs at least one rigid motion, and none twice")
        if {"mass", "density"} <= {*given}:
            raise ValueError("density: received both density and mass; needs one of them")
        if "radii_of_gyration" in given and not {"mass", "density"} & {*given}:
            raise ValueError("radii_of_gyration: received no mass; needs mass or density as well")
        return self

    @property
    def rigid_motions(self) -> tuple[str, ...] | None:
        """Names of the rigid motions to be made; none if a file has the displacements."""
        if isinstance(self.modes, str):
            return RIGID if self.modes == "rigid" else None
        if isinstance(self.modes, ModeFamilies):
            rigid = self.modes.rigid
            return (RIGID if rigid else ()) if isinstance(rigid, bool) else rigid
        return self.modes

    @property
    def families(self) -> ModeFamilies | None:
        """Families of modes, if they are given."""
        return self.modes if isinstance(self.modes, ModeFamilies) else None

    @property
    def all_rigid(self) -> bool:
        """Whether all rigid motions are asked for: those that move no water are then left out."""
        return self.modes == "rigid" or (self.families is not None and self.families.rigid is True)

    @property
    def hull(self) -> PlainHull | None:
        """The plain hull, if it is no mesh file."""
        return None if isinstance(self.mesh, str | PlacedMesh) else self.mesh

    @property
    def metres(self) -> float:
        """Length of the unit of its mesh [m]."""
        return self.mesh.metres if isinstance(self.mesh, PlacedMesh) else 1.0

    @property
    def paths(self) -> dict[str, str]:
        """Names of the files it is read from, by key."""
        file = self.mesh.file if isinstance(self.mesh, PlacedMesh) else self.mesh
        mesh = {"mesh": file} if isinstance(file, str) else {}
        return mesh | ({"modes": str(self.modes)} if self.rigid_motions is None else {})

    def with_files(self, names: Mapping[str, str]) -> Self:
        """Return the same read from files of other names, by key."""
        known: dict[str, object] = dict(names)
        if isinstance(self.mesh, PlacedMesh) and "mesh" in names:
            known["mesh"] = self.mesh.model_copy(update={"file": names["mesh"]})
        return self.model_copy(update=known)


WAMIT = (".1", ".3", ".2", ".hst", ".3fk", ".3sc", ".mmx")
"""WAMIT's files of one run; `.1`, `.3` (or `.2`) and `.hst` must be there."""
