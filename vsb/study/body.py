"""A study of any body: what floats is a hydro database, solved of a mesh or read from files, and matrices beside it.

A body is known by what its files hold, never by where they lie: `located` puts checksums in the place of their paths.
Imports nothing heavy: the Snakefile reads a study at every parse.
"""

import hashlib
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, Self, TypeGuard

from pydantic import (
    Discriminator,
    Field,
    Tag,
    field_validator,
    model_validator,
)

from vsb.errors import ConfigError
from vsb.study.drag import BodyDrag, check_followed
from vsb.study.hulls import BoxHull, CapsuleHull, CylinderHull, ScaledMesh, SphereHull
from vsb.study.quantities import RIGID, Brief, Count, Finite, Name, NonNegative, Number, Positive, Section, is_rigid
from vsb.study.reading import read_yaml, validated
from vsb.study.sections import LEAST_DEPTH_IN_WAVENUMBERS, Published, Simulation, Water
from vsb.study.study import BaseStudy, Study, check_all
from vsb.study.take_off import DofPort, Pto
from vsb.study.waves import SpectralSea, StillWater, Wave, with_files
from vsb.tools.bounded import open_regular

PHYSICS = 4
"""Hand-bumped version of the physics behind a block."""
Frequency = Annotated[Number, Field(ge=1e-3, le=1e3)]
"""Frequencies of gravity waves on Earth, tsunamis and ripples among them [rad/s]."""
Direction = Annotated[Number, Field(ge=-360, le=360)]
RigidMotion = Literal["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]
MOST_MODES = 20
"""Modes of bending, or polynomials."""
MOST_BODIES = 100
"""Bodies in a file of another code."""
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
    return "scaled" if isinstance(value, ScaledMesh) or (isinstance(value, dict) and "file" in value) else "hull"


PlainHull = SphereHull | CylinderHull | CapsuleHull | BoxHull
Mesh = Annotated[
    Annotated[str, Tag("path")]
    | Annotated[ScaledMesh, Tag("scaled")]
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
            if self.metres != 1:
                raise ValueError("mesh: the unit of the displacements in the file of modes is unknown; needs metres")
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
        return None if isinstance(self.mesh, str | ScaledMesh) else self.mesh

    @property
    def metres(self) -> float:
        """Length of the unit of its mesh [m]."""
        return self.mesh.metres if isinstance(self.mesh, ScaledMesh) else 1.0

    @property
    def paths(self) -> dict[str, str]:
        """Names of the files it is read from, by key."""
        file = self.mesh.file if isinstance(self.mesh, ScaledMesh) else self.mesh
        mesh = {"mesh": file} if isinstance(file, str) else {}
        return mesh | ({"modes": str(self.modes)} if self.rigid_motions is None else {})

    def with_files(self, names: Mapping[str, str]) -> Self:
        """Return the same read from files of other names, by key."""
        known: dict[str, object] = dict(names)
        if isinstance(self.mesh, ScaledMesh) and "mesh" in names:
            known["mesh"] = self.mesh.model_copy(update={"file": names["mesh"]})
        return self.model_copy(update=known)


CONTENTS = "sha256:"
"""What begins the name of a file known by its contents."""
WAMIT = (".1", ".3", ".2", ".hst", ".3fk", ".3sc", ".mmx")
"""WAMIT's files of one run; `.1`, `.3` (or `.2`) and `.hst` must be there."""
KINDS = ("file", "database", "wamit", "bemio")
_SHORTEST = 1.0  # period a record of still water shows [s]
CHECKS = (
    "error_estimate", "interpolation_error", "one_resolution", "symmetry", "far_field", "haskind", "positive_damping",
    "panels", "modes", "corners", "rigid_names", "closure", "lid", "displaced_mass", "irregular_frequencies",
    "kramers_kronig", "long_waves", "haskind_scale", "haskind_long_waves", "phases", "displaced_volume", "parts",
    "added_mass_limits", "tilt", "rotation_centre", "waterplane", "mass_coupling", "places",
)  # fmt: skip
"""Names of the checks on a body's database, solved or read; a study may accept their failures."""
REPAIRS = ("positive_damping", "kramers_kronig", "phases")
"""Those whose failure a study may have repaired."""
NOT_OF_A_BODY = {
    "device": "is the spherical buoy; a study has a device or a body",
    "modes": "are shapes of the spherical shell; those of a body stand in its files",
    "reference_shape": "is of the spherical shell; a body is linear about the rest its files are of",
}
"""Keys of a study of a buoy that make no sense here, and why."""
NOT_OF_ITS_HYDRO = {
    "solver": "is for the buoy; the body's file says how it is solved",
    "rows": "are of the sphere's mesh; the body has a mesh of its own",
    "omega": "is of the body's file, or of the database read",
    "pressure": "is of the paper's model of the buoy",
    "power_tolerance": "is of hydro.model: auto, which the buoy has",
    "witness": "is for the buoy: its second solver knows no other body",
}
Rows = tuple[tuple[Finite, ...], ...]
Entry = Annotated[
    Annotated[Finite, Tag("one")] | Annotated[Rows, Tag("rows")],
    Discriminator(lambda value: "rows" if isinstance(value, list | tuple) else "one"),
]
Matrix = Annotated[
    Annotated[dict[str, Entry], Tag("entries")] | Annotated[Rows, Tag("rows")],
    Discriminator(lambda value: "entries" if isinstance(value, dict) else "rows"),
]
"""Entries by a degree of freedom, or by two with a space between them, rows by a body, or all rows as in the file."""


Meshed = Annotated[
    Annotated[str, Tag("path")] | Annotated[BodyFile, Tag("contents")],
    Discriminator(lambda value: "contents" if isinstance(value, dict | BodyFile) else "path"),
]
"""A body file by its path, or what it holds."""
Chosen = Annotated[
    Annotated[Literal["all", "rigid"], Tag("group")] | Annotated[tuple[str, ...], Tag("names")],
    Discriminator(lambda value: "names" if isinstance(value, list | tuple) else "group"),
]
"""Degrees of freedom by their names, or a group of them."""


class Body(Brief):
    """What floats, by one of four sources, and matrices of the dry body that take the place of those in its files."""

    file: Meshed | None = None
    database: str | None = None
    wamit: str | None = None
    bemio: str | None = None
    length: Positive = 1.0
    bodies: Annotated[Count, Field(ge=1, le=MOST_BODIES)] | None = None
    modes: tuple[Annotated[Count, Field(ge=1, le=1000)], ...] | None = None
    mass: Matrix | None = None
    damping: Matrix | None = None
    stiffness: Matrix | None = None

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        given = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            raise ValueError(f"received {' and '.join(given) or 'no source'}; needs one of {', '.join(KINDS)}")
        if self.length != 1.0 and given != ["wamit"]:
            raise ValueError(f"length {self.length:g} m: is WAMIT's ULEN, which {given[0]} does not have; remove it")
        for key in ("bodies", "modes"):
            if getattr(self, key) is not None and given != ["wamit"]:
                raise ValueError(f"{key}: is for WAMIT's files, which do not state it; {given[0]} does; remove it")
        if self.bodies and self.modes and len(self.modes) != self.bodies:
            raise ValueError(f"modes {list(self.modes)}: needs a number for each of {self.bodies} bodies")
        return self

    @property
    def kind(self) -> str:
        """Which source it has."""
        return next(kind for kind in KINDS if getattr(self, kind) is not None)


class BodyDesign(Section):
    """One variant of a body: the degrees of freedom it moves in, and combinations of them that are held at zero."""

    dofs: Chosen = "all"
    held: tuple[dict[str, Finite], ...] = ()

    @model_validator(mode="after")
    def _some(self) -> Self:
        if isinstance(self.dofs, tuple) and (not self.dofs or len(set(self.dofs)) < len(self.dofs)):
            raise ValueError(f"dofs {list(self.dofs)}: needs at least one degree of freedom, and none twice")
        for shares in self.held:
            if not any(shares.values()):
                raise ValueError(f"held {shares}: needs a share that is not zero")
        return self

    @property
    def flexible(self) -> bool:
        """Whether it moves in more than rigid motions."""
        return not (self.dofs == "rigid" or (isinstance(self.dofs, tuple) and all(map(is_rigid, self.dofs))))


class BodyHydro(Section):
    """Linear hydrodynamics: tolerance of the radiation memory [-], highest frequency kept [rad/s], accepted checks.

    A failure accepted leaves the coefficients as they are; `repair` changes them, as little as it takes.

    The memory's added mass at infinite frequency is `fitted`, so that memory and samples agree, or as the database
    has it (`given`).
    """

    model: Literal["linear"] = "linear"
    tolerance: Annotated[Number, Field(ge=1e-6, le=0.02)] = 1e-2  # no memory is let off further
    added_mass_inf: Literal["fitted", "given"] = "fitted"
    omega_max: Positive | None = None
    accept: tuple[Name, ...] = ()
    repair: tuple[Name, ...] = ()

    @field_validator("accept")
    @classmethod
    def _known(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        if unknown := [name for name in value if name not in CHECKS]:
            raise ValueError(f"{unknown}: no such check; needs some of {', '.join(CHECKS)}")
        return value

    @field_validator("repair")
    @classmethod
    def _repairable(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        if unknown := [name for name in value if name not in REPAIRS]:
            raise ValueError(f"{unknown}: cannot be repaired; needs some of {', '.join(REPAIRS)}")
        return value

    @model_validator(mode="after")
    def _one_or_the_other(self) -> Self:
        if both := sorted({*self.accept} & {*self.repair}):
            raise ValueError(f"repair {both}: is accepted as well; needs to be accepted as it is, or repaired")
        return self


class BodyStudy(Brief, BaseStudy):
    """One study file of a body."""

    BRIEF = ("drag",)
    study: Name
    body: Body
    designs: Annotated[dict[Name, BodyDesign], Field(min_length=1)]
    water: Water = Water()
    hydro: BodyHydro = BodyHydro()
    pto: Pto = Pto()
    drag: BodyDrag | None = None
    waves: Annotated[tuple[Wave, ...], Field(min_length=1)]
    simulation: Simulation = Simulation()
    published: Published | None = None

    @field_validator("body", mode="before", json_schema_input_type=str | Body)
    @classmethod
    def _a_file_alone(cls, value: object) -> object:
        """The name of a body file may stand for itself."""
        return {"file": value} if isinstance(value, str) else value

    @model_validator(mode="before")
    @classmethod
    def _without_a_buoy(cls, raw: Any) -> Any:
        """Refuse what only a buoy has, with the reason."""
        if not isinstance(raw, dict):
            return raw
        hydro = raw.get("hydro")
        refused = [f"{key}: {why}; remove it" for key, why in NOT_OF_A_BODY.items() if key in raw]
        refused += [
            f"hydro.{key}: {why}; remove it"
            for key, why in NOT_OF_ITS_HYDRO.items()
            if isinstance(hydro, Mapping) and key in hydro
        ]
        if isinstance(hydro, Mapping) and hydro.get("model", "linear") != "linear":
            refused.append(f"hydro.model {hydro['model']!r}: is of the spherical shell; a body is linear; remove it")
        if refused:
            raise ValueError("\n".join(refused))
        return raw

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        check_all(
            self.check_labels,
            self.check_records,
            self.check_control,
            self._check_spreading,
            self.check_dampers_of_designs,
            self.check_published,
            self._check_take_off,
        )
        return self

    def _check_spreading(self) -> None:
        """A body's database holds waves of the directions it was solved in, and no others."""
        for i, wave in enumerate(self.waves):
            if isinstance(wave, SpectralSea) and wave.spreads:
                key = "spreading" if wave.spreading else "file"
                raise ValueError(
                    f"waves.{i}.{key}: the database of a body holds the directions it was solved in, none between; "
                    "needs a buoy, or several seas of one direction each"
                )

    def _check_take_off(self) -> None:
        """The port is of degrees of freedom, the method one that can follow."""
        if self.pto.port != "heave" and not isinstance(self.pto.port, DofPort):
            raise ValueError("pto.port: is of the spherical shell; needs {dof: NAME} or {dofs: {NAME: share, ...}}")
        method = self.simulation.method
        if self.drag is not None:
            check_followed("linear", method, self.pto)
        if method == "exponential" or (self.pto.nonlinear and method != "auto"):
            suitable = "auto" if self.pto.nonlinear else "auto, exact or convolution"
            raise ValueError(f"simulation.method {method!r}: cannot follow this body and take-off; needs {suitable}")

    @property
    def buoy(self) -> None:
        """There is none."""

    @property
    def dofs(self) -> tuple[str, ...] | None:
        """Degrees of freedom that designs move in, `rigid` for all rigid ones; none if some design moves in all."""
        if any(design.dofs == "all" for design in self.designs.values()):
            return None
        named = {name for d in self.designs.values() for name in (["rigid"] if d.dofs == "rigid" else d.dofs)}
        return tuple(sorted(named))

    @property
    def directions(self) -> tuple[float, ...]:
        """Directions of the seas, each once [degrees]; 0 if there is none."""
        found = dict.fromkeys(wave.direction for wave in self.waves if not isinstance(wave, StillWater))
        return tuple(found) or (0.0,)

    def fastest(self, wave: Wave) -> float:
        """Frequency of the fastest motion a run in a sea must show [rad/s]."""
        return 2 * math.pi / _SHORTEST if isinstance(wave, StillWater) else wave.fastest


AnyStudy = Annotated[
    Annotated[Study, Tag("buoy")] | Annotated[BodyStudy, Tag("body")],
    Discriminator(lambda value: "body" if isinstance(value, BodyStudy) or "body" in dict(value) else "buoy"),
]
"""A study of a buoy or of a body."""


class LocatedBody(NamedTuple):
    """A study of a body, known by contents, and the files these are in, by what they are."""

    study: BodyStudy
    files: dict[str, str]


def is_body(raw: object) -> TypeGuard[dict[str, Any]]:
    """Return whether nested mappings are a study of a body."""
    return isinstance(raw, dict) and "study" in raw and "body" in raw


def located(raw: object, source: str) -> LocatedBody:
    """Return the study of a body in nested mappings, its files found from the folder of the source.

    Raises `ConfigError`: one line with the file, the key, the value received and the value needed.
    """
    study = validated(BodyStudy, with_files(raw, source), source)
    body, folder = study.body, Path(source).parent
    given, own_water = getattr(body, body.kind), "water" in raw if isinstance(raw, dict) else False
    if isinstance(given, BodyFile):
        known = given.paths and all(name.startswith(CONTENTS) for name in given.paths.values())
        if not known and own_water and "water" not in given.model_fields_set:
            given = given.model_copy(update={"water": study.water})
        return LocatedBody(study, {}) if known else _of_a_mesh(study, given, f"{source}: body.file", source, own_water)
    if given.startswith(CONTENTS):
        return LocatedBody(study, {})
    path = folder / given
    if body.kind == "file":
        file = validated(BodyFile, read_yaml(path, "a body file, as `vsb body` takes"), str(path))
        return _of_a_mesh(study, file, str(path), source, own_water)
    files = {body.kind: str(path)}
    if body.kind == "wamit" and not os.path.isfile(f"{path}.1") and (path.is_dir() or path.suffix in WAMIT):
        if os.path.isfile(path / "Nemoh.cal"):
            _contents([str(path)], f"{source}: body.wamit")
        what = "a folder" if path.is_dir() else "one of WAMIT's files"
        name = f"{given}/NAME" if path.is_dir() else given.removesuffix(path.suffix)
        raise ConfigError(f"{source}: body.wamit: {given} is {what}; needs the name that all have, {name}")
    held = wamit_files(str(path)) if body.kind == "wamit" else [str(path)]
    return LocatedBody(_known_by(study, {body.kind: _contents(held, f"{source}: body.{body.kind}")}), files)


def wamit_files(path: str) -> list[str]:
    """Return WAMIT's files of a run by their path without endings: those needed, there or not, and others there."""
    there = [ending for ending in WAMIT if os.path.isfile(path + ending)]
    force = ".2" if ".2" in there and ".3" not in there else ".3"
    return [
        path + ending for ending in WAMIT if ending in (".1", ".hst", force) or (ending in there and ending != ".2")
    ]


def load_body(path: str | Path) -> LocatedBody:
    """Read and validate a study file of a body; see `located`."""
    return located(read_yaml(path, "a study file of a body such as config/barge.yaml"), str(path))


def _of_a_mesh(study: BodyStudy, body: BodyFile, path: str, source: str, own_water: bool) -> LocatedBody:
    """A study of a body file, which stands at a path, in its water."""
    if own_water and study.water != body.water:
        raise ConfigError(f"{source}: water: differs from that of {path}; needs the same, or none here")
    files = {name: str(Path(path).parent / file) for name, file in body.paths.items()}
    known = {name: _contents([file], f"{path}: {name}") for name, file in files.items()}
    solved = body.with_files(known).model_copy(update={"body": "body"})
    return LocatedBody(_known_by(study.model_copy(update={"water": body.water}), {"file": solved}), files)


def _known_by(study: BodyStudy, source: Mapping[str, object]) -> BodyStudy:
    """The study with its source known by contents."""
    return study.model_copy(update={"body": study.body.model_copy(update=dict(source))})


def _contents(paths: list[str], where: str) -> str:
    """Name of files by what they hold."""
    digest = hashlib.sha256()
    for path in paths:
        try:
            with open_regular(path) as file:
                digest.update(f"{Path(path).suffix} {os.fstat(file.fileno()).st_size} ".encode())
                while part := file.read(2**20):
                    digest.update(part)
        except OSError as error:
            if os.path.isfile(os.path.join(path, "Nemoh.cal")):
                raise ConfigError(
                    f"{where}: {path} is a folder of NEMOH; needs the database vsb import-nemoh makes"
                ) from None
            raise ConfigError(f"{where}: {path} cannot be read ({error.strerror}); needs the path of a file") from None
    return f"{CONTENTS}{digest.hexdigest()}"
