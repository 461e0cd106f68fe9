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

from vsb.engine.hydro.bodies.body_file import WAMIT, BodyFile
from vsb.engine.hydro.variables import is_rigid
from vsb.engine.integrators.settings import Simulation
from vsb.engine.motion.take_off import DofPort, Pto
from vsb.engine.waves.kinds import Wave, with_files
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.keys.quantities import Brief, Count, Finite, Name, Number, Positive, Section
from vsb.keys.reading import read_yaml, validated
from vsb.study.sections import BodyDrag, Published, check_followed
from vsb.study.study import Study, check_all, parse
from vsb.tools.files import open_regular

MOST_BODIES = 100
"""Bodies in a file of another code."""


CONTENTS = "sha256:"
"""What begins the name of a file known by its contents."""
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


class BodyStudy(Brief, Study):
    """One study file of a body."""

    KIND, LIMIT = "body", ""
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
            self.check_depths,
            self._check_spreading,
            self.check_dampers_of_designs,
            self.check_published,
            self._check_take_off,
        )
        return self

    def _check_spreading(self) -> None:
        """A body's database holds waves of the directions it was solved in, and no others."""
        for i, wave in enumerate(self.waves):
            if wave.spreads:
                key = "spreading" if wave.drawn and wave.spreading else "file"
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
    def uses_panels(self) -> bool:
        """Whether its database is solved on the panels of a mesh, not read."""
        return isinstance(self.body.file, BodyFile)

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
        found = dict.fromkeys(wave.direction for wave in self.waves if not wave.still)
        return tuple(found) or (0.0,)

    def fastest(self, wave: Wave) -> float:
        """Frequency of the fastest motion a run in a sea must show [rad/s]."""
        return 2 * math.pi / _SHORTEST if wave.still else wave.fastest


class LocatedBody(NamedTuple):
    """A study, a body in it known by contents, and the files these are in, by what they are."""

    study: Study
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


def read_study(raw: object, source: str) -> LocatedBody:
    """Return the study in nested mappings, of a buoy or of a body; see `located`."""
    return located(raw, source) if is_body(raw) else LocatedBody(parse(raw, source=source), {})


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


def _of_a_mesh(study: Study, body: BodyFile, path: str, source: str, own_water: bool) -> LocatedBody:
    """A study of a body file, which stands at a path, in its water."""
    if own_water and study.water != body.water:
        raise ConfigError(f"{source}: water: differs from that of {path}; needs the same, or none here")
    files = {name: str(Path(path).parent / file) for name, file in body.paths.items()}
    known = {name: _contents([file], f"{path}: {name}") for name, file in files.items()}
    solved = body.with_files(known).model_copy(update={"body": "body"})
    return LocatedBody(_known_by(study.model_copy(update={"water": body.water}), {"file": solved}), files)


def _known_by(study: Study, source: Mapping[str, object]) -> Study:
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
