"""A body file: mesh, modes, water, frequencies of a body that is solved on panels, and what that costs. Pure Python.

`build` meshes plain hulls. The matrices of a frequency grow with the square of the number of panels. That number is
known of plain hulls and of GDF files, and bounded by the size of other mesh files. Nothing is read but a header:
Snakemake asks at every parse.
"""

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, NamedTuple, Self

from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from vsb.engine.hydro.panels import LEAST_DEPTH_IN_WAVENUMBERS
from vsb.engine.hydro.variables import RIGID
from vsb.engine.waves.water import Water
from vsb.keys.quantities import Brief, Count, Finite, Name, NonNegative, Number, Positive, Section
from vsb.tools.units import parsed_unit


class PlacedMesh(Brief):
    """A mesh file: its unit of length, or what its lengths are multiplied by to be metres, and how the hull lies."""

    BRIEF = ("scale", "unit", "up", "draft")
    file: str
    scale: Positive = 1.0
    unit: Literal["m", "mm", "cm", "km", "in", "ft"] = "m"
    up: Literal["x", "y", "z", "-x", "-y", "-z"] = "z"  # axis of the file that points upwards
    draft: Positive | None = None  # depth of the lowest point below still water [m]; none: as the file has it

    @model_validator(mode="after")
    def _one_of_them(self) -> Self:
        if self.scale != 1 and self.unit != "m":
            raise ValueError(f"unit: received {self.unit} and scale {self.scale:g}; needs one of them")
        return self

    @property
    def metres(self) -> float:
        """Length of the unit of the file [m]."""
        return self.scale * float(parsed_unit(self.unit).factor)


class Hull(Section):
    """A plain hull on the z axis whose lowest point lies `draft` [m] below still water, in panels of a size [m]."""

    draft: Positive
    panel: Annotated[Number, Field(ge=1e-3)]


class SphereHull(Hull):
    """A sphere."""

    kind: Literal["sphere"]
    radius: Positive

    @property
    def height(self) -> float:
        """From the lowest point to the highest [m]."""
        return 2 * self.radius


class CylinderHull(Hull):
    """An upright cylinder."""

    kind: Literal["cylinder"]
    radius: Positive
    height: Positive


class CapsuleHull(Hull):
    """An upright cylinder between two hemispheres, of a height over all."""

    kind: Literal["capsule"]
    radius: Positive
    height: Positive

    @model_validator(mode="after")
    def _with_ends(self) -> Self:
        if self.height < 2 * self.radius:
            raise ValueError(f"height {self.height:g} m: needs at least that of its two ends, {2 * self.radius:g} m")
        return self


class BoxHull(Hull):
    """A box, its length along x, its width along y."""

    kind: Literal["box"]
    length: Positive
    width: Positive
    height: Positive


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
    Annotated[Literal["displaced"], Tag("displaced")] | Annotated[Positive, Tag("number")], Discriminator(_mass_kind)
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


# Cost

GIGABYTES, SECONDS = 6.3e-8, 6.5e-7
"""Of a frequency on one core, per squared number of panels; measured with 3200 panels."""
_IN_FINITE_DEPTH = 5.0  # times as long at most
_FURTHER = 4.0  # times as long as the frequencies on a quick core: fewer panels for the error, lids, slower cores
_LEAST_MEGABYTES, _LEAST_MINUTES = 1500, 30
_UNKNOWN = 8000  # panels
_MOST = 60_000  # panels; beyond, `solution` refuses the body or its symmetry decides
_HEADER = 4  # lines of a GDF: title, ULEN GRAV, ISX ISY, NPAN
_BYTES = {".stl": 50, ".nc": 56}
"""Of a panel at least: a binary STL has 50 of a triangle, netCDF four corners and one vertex."""
_TEXT_BYTES = 40  # a vertex and four numbers in text
_OF_DISPLACEMENTS = 6 * 24  # bytes of a vertex in netCDF that holds six displacements at least


class Resources(NamedTuple):
    """What a job asks a cluster for."""

    megabytes: int
    minutes: int


def hull_panel_count(hull: SphereHull | CylinderHull | CapsuleHull | BoxHull) -> float:
    """Return about how many panels the wetted part of a plain hull has; rows have as many all along a meridian."""
    depth = hull.draft
    if isinstance(hull, BoxHull):
        area = hull.length * hull.width + 2 * (hull.length + hull.width) * depth
        return 1.3 * area / hull.panel**2 + 16
    r = hull.radius
    if isinstance(hull, CylinderHull):
        meridian = r + depth
    else:  # a capsule's lower end is a sphere's
        sphere = depth if isinstance(hull, SphereHull) else min(depth, r)
        meridian = r * math.acos(1 - min(sphere / r, 2.0)) + depth - sphere
    return 1.2 * 2 * math.pi * r * meridian / hull.panel**2 + 16


def panel_count(file: BodyFile, paths: Mapping[str, str]) -> float:
    """Return about how many panels a body has at most; `paths` are those of its files, by key."""
    if file.hull:
        return hull_panel_count(file.hull)
    path = paths.get("mesh", "")
    if not os.path.isfile(path):
        return _UNKNOWN
    suffix = Path(path).suffix.lower()
    if suffix == ".gdf" and (found := _of_gdf(path)):
        return found
    each, size = _BYTES.get(suffix, _TEXT_BYTES), os.path.getsize(path)
    if suffix == ".nc" and file.rigid_motions is None and paths.get("modes") == path:
        each += _OF_DISPLACEMENTS
    return size / each


def _of_gdf(path: str) -> int | None:
    """Panels of a GDF with its mirrored parts; none if its header is not that."""
    try:
        with open(path, encoding="utf-8", errors="replace") as stream:
            lines = [stream.readline(1000) for _ in range(_HEADER)]
        isx, isy = (int(word) for word in lines[2].split()[:2])
        mirrored = (isx == 1) + (isy == 1)
        return int(lines[3].split()[0]) << mirrored
    except (OSError, ValueError, IndexError):
        return None


def solve_resources(file: BodyFile, paths: Mapping[str, str]) -> Resources:
    """Return the memory and the time a job that solves a body asks for, frequencies one after the other."""
    squared = min(panel_count(file, paths), _MOST) ** 2
    slower = _FURTHER * (1.0 if math.isinf(file.water.depth) else _IN_FINITE_DEPTH)
    minutes = slower * SECONDS * squared * (len(file.omega) + 1) / 60
    return Resources(_LEAST_MEGABYTES + math.ceil(1e3 * GIGABYTES * squared), _LEAST_MINUTES + math.ceil(minutes))
