"""From a mesh file and a file of displacements to a hydro database with its verdict: any body, any modes.

Every frequency is a file of its own under `blocks/`, named by the content it was solved from: it is never solved twice,
and an interrupted run continues where it stopped.
"""

import hashlib
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from vsb import __version__
from vsb.engine.hydro.bodies.body import (
    SYMMETRIES,
    FlexibleBody,
    bed_below,
    check_symmetry,
    cut,
    detected_symmetry,
    panel_diameters,
    panel_size,
)
from vsb.engine.hydro.bodies.body_file import GIGABYTES, PHYSICS, SECONDS, BodyFile
from vsb.engine.hydro.bodies.build import build_body
from vsb.engine.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.engine.hydro.bodies.mesh import rotation_centre
from vsb.engine.hydro.bodies.solver import BodyProblem, first_irregular_frequency, interior_lid, unit_wave
from vsb.engine.hydro.bodies.verdict import (
    BELOW_IRREGULAR,
    Block,
    Swept,
    identities,
    least_sizes,
    lid_check,
    signed_errors,
    sizes,
    stiffness_error,
    verdict,
)
from vsb.engine.hydro.database import ESTIMATE, Check, as_json, with_excitation, with_symmetrized
from vsb.engine.hydro.panels import bem, panel_solver
from vsb.engine.hydro.sweep import FORCES, MOST_SOLVES, IncidentWave, joined, on_grid
from vsb.engine.hydro.variables import PAIR, ROTATIONS
from vsb.engine.waves.water import Water, wavenumber
from vsb.errors import ConfigError, DatabaseError
from vsb.keys.quantities import Section, canonical, content_id
from vsb.keys.reading import read_yaml, validated
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray
from vsb.tools.files import load, save
from vsb.tools.stamps import check_output
from vsb.tools.variables import described

Spec = dict[str, Any]
Model = TypeVar("Model", bound=Section)
_COARSEST = 4.0  # wavelengths in a panel from which on nothing is solved
_LARGE = 1000.0  # [m], of a body that is rather given in millimetres
_MOST_GIGABYTES = 256.0  # a body may need
_GROUPS = ("fewer_panels", "radiated_waves")  # of a block's file


def read_config(path: str | Path, model: type[Model]) -> Model:
    """Read and validate a YAML file; `ConfigError` in one line with file, key, value received and needed."""
    return validated(model, read_yaml(path, "a file such as config/barge/body.yaml"), str(path))


def run(config: str | Path, out: str | Path, tables: str | Path | None = None) -> list[Check]:
    """Solve a body file into `out` and return the verdict; `tables` keeps the Green function's table."""
    return solve(*read_study(config, out), out, tables)


def read_study(config: str | Path, out: str | Path) -> tuple[BodyFile, FlexibleBody]:
    """Return a body file and its body, whose `history` records repairs; `out` may hold no input."""
    study, folder = read_config(config, BodyFile), Path(config).parent
    paths = {name: folder / file for name, file in study.paths.items()}
    check_output(Path(out, f"{study.body}.nc"), list(paths.values()), "hydro database")
    return study, build_body(study, paths)


def solve(study: BodyFile, body: FlexibleBody, out: str | Path, tables: str | Path | None = None) -> list[Check]:
    """Solve a body into the database `out`/<name>.nc and return the verdict; blocks already there are kept."""
    ds, checks = solved(study, body, out, tables)
    save(ds, Path(out, f"{study.body}.nc"))
    return checks


def solved(
    study: BodyFile, body: FlexibleBody, out: str | Path, tables: str | Path | None = None, green: Any = None
) -> tuple[xr.Dataset, list[Check]]:
    """Return the database of a body and its verdict; blocks in `out` are kept, and those solved are added.

    `green` is the Green function, of `rings`; that of a stored table if not given.
    """
    check_solvable(study, body)
    blocks = blocks_of(study, body, out, tables, green)
    infinite, directions = blocks(np.inf), np.deg2rad(study.wave_direction)
    size = sizes(infinite.own.added_mass_inf.values, least_sizes(body, study.water.density))
    centre = (body.vertices.max(axis=0) + body.vertices.min(axis=0)) / 2
    measure = Measure(size, centre, directions, study.water)

    def froude_krylov(omegas: FloatArray) -> ComplexArray:
        return blocks.problem.froude_krylov(omegas, directions)

    found = swept(blocks, froude_krylov, study.omega, study.tolerance, measure)
    checks = verdict(study, body, infinite, found, size)
    regular = _regular(study, body)
    below = [omega for block in found.solved if (omega := float(block.own.omega[0])) <= regular]
    if blocks.lid and below:
        checks.append(lid_check(found.solved, replace(blocks, lid=None)(max(below)), size))
    return _database(study, body, blocks.symmetry, infinite, found, checks), checks


def blocks_of(
    study: BodyFile, body: FlexibleBody, out: str | Path, tables: str | Path | None = None, green: Any = None
) -> "Blocks":
    """Return the files of single frequencies of a body; parameters as of `solved`."""
    symmetry = detected_symmetry(body) if study.symmetry == "auto" else study.symmetry
    lid = interior_lid(body, study.lid) if study.lid and study.omega[-1] > _regular(study, body) else None
    return Blocks(study, body, symmetry, lid, Path(out, "blocks"), Path(tables or table_in(out)), green)


def table_in(out: str | Path) -> Path:
    """Return the folder of the Green function's table beside a database."""
    return Path(out, "green", panel_solver().replace(" ", "-"))


def _regular(study: BodyFile, body: FlexibleBody) -> float:
    """Frequency below which none is irregular [rad/s]."""
    return BELOW_IRREGULAR * first_irregular_frequency(body, study.water.gravity)


def check_solvable(study: BodyFile, body: FlexibleBody) -> None:
    """Check a body file against its body, before anything is solved.

    Raises `ConfigError` if the symmetry declared is not the body's, the water is no deeper than its draught, waves are
    shorter than its panels, or there are too many of them.
    """
    if study.symmetry != "auto":
        check_symmetry(body, study.symmetry)
    water = study.water
    if bed_below(body.vertices, water.depth) != body.bed:
        raise ConfigError(f"water.depth: received {water.depth:g} m; needs the depth the body was made for")
    memory, _ = cost(study, body)
    if memory > _MOST_GIGABYTES:
        raise ConfigError(
            f"mesh: received {len(body.faces)} panels, whose matrices take {memory:.3g} GB; needs at most "
            f"{_MOST_GIGABYTES:g} GB: fewer panels, or a symmetry"
        )
    longest = float(panel_diameters(body).max())
    shortest = 2 * np.pi / wavenumber(study.omega[-1], water.depth, water.gravity)
    if longest > _COARSEST * shortest:  # such waves would be aliases
        if body.size > _LARGE and study.metres == 1:
            raise ConfigError(
                f"mesh: received a body of {body.size:.3g} m, whose largest panel is longer than {_COARSEST:g} of the "
                "shortest waves; needs metres, or the unit of its file, such as mesh: {file: hull.stl, unit: mm}"
            )
        needed = np.sqrt(2 * np.pi * water.gravity * _COARSEST / longest)  # in deep water, as for such waves
        raise ConfigError(
            f"omega: received {study.omega[-1]:g} rad/s, whose waves are {shortest:.3g} m long and the largest panel "
            f"{longest:.3g} m of a body of {body.size:.3g} m; needs at most {needed:.3g} rad/s: smaller panels, lower "
            "frequencies, or a mesh in metres"
        )


def cost(study: BodyFile, body: FlexibleBody) -> tuple[float, float]:
    """Return the memory a frequency takes [GB], and the seconds on one core; planes of symmetry halve both."""
    planes = SYMMETRIES[detected_symmetry(body) if study.symmetry == "auto" else study.symmetry]
    size = len(body.faces) ** 2 / 2 ** len(planes)
    return GIGABYTES * size, SECONDS * size


# Files of single frequencies


@dataclass(frozen=True)
class Blocks:
    """Files of single frequencies: each is solved when first asked for, and never again."""

    study: BodyFile
    body: FlexibleBody
    symmetry: str
    lid: tuple[FloatArray, IntArray] | None
    folder: Path
    table: Path
    green: Any = None  # of `rings`; none: of the table

    @cached_property
    def problem(self) -> BodyProblem:
        """The body in waves."""
        green = self.green or bem.stored_green_function(self.table)
        return BodyProblem(green, self.body, self.study.water, self.symmetry, self.lid)

    @cached_property
    def _coarser(self) -> tuple[BodyProblem, float]:
        """The same on fewer panels, and their share."""
        return self.problem.coarser()

    @cached_property
    def _known(self) -> dict[float, Block]:
        """Blocks read or solved."""
        return {}

    def __call__(self, omega: float) -> Block:
        """Return the block of a frequency, finite or not [rad/s]."""
        if omega not in self._known:
            spec = _spec(self.study, self.body, omega, self.study.lid if self.lid else 0)
            path = self.folder / f"{content_id(spec)}.nc"
            known = _stored(path, content_id(spec))
            block = known or solved_block(self.problem, *self._coarser, spec)
            if known is None:
                save(block.own, path, dict(zip(_GROUPS, block[1:], strict=True)))
            self._known[omega] = Block(*map(described, block))
        return self._known[omega]


def _spec(study: BodyFile, body: FlexibleBody, omega: float, belts: int) -> Spec:
    """Inputs of one frequency; symmetry only saves time, infinite frequency has neither waves nor lid."""
    digest = hashlib.sha256()
    for array in (body.vertices, body.faces.astype(np.int64), body.modes):
        digest.update(np.ascontiguousarray(array).tobytes())
    spec = {"stage": "body", "physics": PHYSICS, "solver": panel_solver(), "omega": float(omega)}
    spec |= {"panels_and_modes": digest.hexdigest(), "labels": list(body.labels), "water": study.water.model_dump()}
    return spec if np.isinf(omega) else spec | {"lid": belts, "wave_direction": list(study.wave_direction)}


def _stored(path: Path, spec_id: str) -> Block | None:
    """A block if it is there; an unreadable file is solved again."""
    try:
        return Block(load(path, expected=spec_id), *(load(path, group) for group in _GROUPS))
    except DatabaseError:
        return None


def solved_block(problem: BodyProblem, fewer: BodyProblem, share: float, spec: Spec) -> Block:
    """Return the coefficients at one frequency, those on fewer panels, and those by their own radiated waves."""
    begun = clock.perf_counter()
    attrs: Spec = {"spec": canonical(spec), "spec_id": content_id(spec)}
    attrs |= {"resolution_ratio": panel_size(fewer.body) / panel_size(problem.body), "coarser_share": share}
    if np.isinf(spec["omega"]):
        found = Block(problem.at_infinity(), fewer.at_infinity(), xr.Dataset())
    else:
        own, other = (each.solve(spec["omega"], np.deg2rad(spec["wave_direction"])) for each in (problem, fewer))
        attrs |= identities(own, problem)
        waves = {"far_field_damping": "radiation_damping", "haskind_force": "excitation_force"}
        coefficients = ["added_mass", "radiation_damping", "excitation_force"]
        found = Block(own.drop_vars(list(waves)), with_excitation(other)[coefficients], own[list(waves)].rename(waves))
    return found._replace(own=found.own.assign_attrs(attrs, seconds=clock.perf_counter() - begun))


# Sweep over frequencies


@dataclass(frozen=True)
class Measure:
    """Units for interpolation: displacements of unit added mass, waves as they pass the middle of the body.

    With phases relative to a distant origin coefficients would turn fast with frequency and need many solves.
    """

    size: FloatArray  # (dof,): root of the added mass at infinite frequency
    centre: FloatArray  # (xyz) [m]
    directions: FloatArray  # (direction,) [rad]
    water: Water

    def __post_init__(self) -> None:
        """Refuse sizes that are not positive."""
        if not (self.size > 0).all():
            raise DatabaseError(
                "added_mass_inf: received a diagonal not above zero; needs another mesh: correct panels"
            )

    def force(self, omega: FloatArray) -> ComplexArray:
        """Return the units of forces, those of a unit wave over the middle, shape (omega, direction, dof) [N/m]."""
        over = np.append(self.centre[:2], 0.0)[None]
        k = [wavenumber(float(w), self.water.depth, self.water.gravity) for w in omega]
        waves = np.array([unit_wave(over, each, self.water.depth, self.directions)[:, 0] for each in k])
        return np.asarray(waves[:, :, None] * self.size)

    def applied(self, ds: xr.Dataset) -> xr.Dataset:
        """Return coefficients in this measure."""
        return _times(ds, 1 / self.size, 1 / self.force(ds.omega.values))

    def undone(self, ds: xr.Dataset) -> xr.Dataset:
        """Return coefficients in SI units from those in this measure."""
        return _times(ds, self.size, self.force(ds.omega.values))


def _times(ds: xr.Dataset, size: FloatArray, force: ComplexArray) -> xr.Dataset:
    """Coefficients times the sizes of their displacements, forces times theirs."""
    matrices = {name: ds[name] * np.outer(size, size) for name in ("added_mass", "radiation_damping")}
    return xr.Dataset(matrices | {name: ds[name] * force for name in FORCES})


def swept(
    solve: Callable[[float], Block],
    froude_krylov: Callable[[FloatArray], ComplexArray],
    omega: Sequence[float],
    tolerance: float | None,
    measure: Measure,
) -> Swept:
    """Return coefficients at ascending frequencies from as few solves as a tolerance allows (`hydro.sweep`), else all.

    `solve` gives the block of one frequency, `froude_krylov` the force of some, shape (omega, direction, dof) [N/m].
    """
    if tolerance is None:
        blocks = [solve(w) for w in omega]
        return Swept(joined(*(block.own for block in blocks)), blocks, 0.0)

    def in_measure(some: list[float]) -> xr.Dataset:
        return measure.applied(joined(*(solve(w).own for w in some)))

    def known(at: FloatArray) -> ComplexArray:
        return np.asarray(froude_krylov(at) / measure.force(at))

    # without a phase at the waterline: on a long barge none saved solves
    found = on_grid(in_measure, omega, tolerance, IncidentWave(np.zeros_like, known, 0), most=MOST_SOLVES)
    blocks, left = [solve(w) for w in found.solved], sorted(set(omega) - set(found.solved))
    between = [measure.undone(found.coefficients.sel(omega=left))] if left else []
    everywhere = joined(*(block.own for block in blocks), *between).sortby("omega")
    return Swept(everywhere, blocks, found.sweep.error if found.sweep else 0.0)


# Database


def _at_rest(body: FlexibleBody) -> Spec:
    """Attributes: displaced volume, its centre and, if known, the centres of mass and of rotations."""
    facts = {"displaced_volume": body.volume, "centre_of_buoyancy": body.centre_of_buoyancy}
    turning = [body.rigid.get(i) for i, label in enumerate(body.labels) if label in ROTATIONS]
    turned = rotation_centre([motion for motion in turning if motion]) if all(turning) else None
    points = {"centre_of_mass": body.centre_of_mass, "rotation_centre": turned}
    return facts | {name: point for name, point in points.items() if point is not None and point.ndim == 1}


def _database(
    study: BodyFile, body: FlexibleBody, symmetry: str, infinite: Block, found: Swept, checks: list[Check]
) -> xr.Dataset:
    """The database with capytaine's names."""
    blocks, water = [block.own for block in (infinite, *found.solved)], study.water
    stiffness = hydrostatic_stiffness(body, water.density, water.gravity)
    structure = {"inertia_matrix": body.mass, "structural_stiffness": body.stiffness}
    matrices = {"hydrostatic_stiffness": stiffness, **{k: m for k, m in structure.items() if m is not None}}
    found_all = found.coefficients.assign(added_mass_inf=infinite.own.added_mass_inf)
    repaired = {"history": body.history} if body.history else {}
    ds = with_symmetrized(with_excitation(found_all.assign_attrs(repaired)))
    spec = {"stage": "body_database", "study": study.model_dump(), "blocks": [b.attrs["spec_id"] for b in blocks]}
    attrs = {
        "Conventions": "CF-1.8",
        "title": f"hydro database of {study.body}: {len(body.faces)} panels, {len(body.labels)} degrees of freedom",
        "source": f"vsb {__version__}",
        "solver": panel_solver(),
        "spec": canonical(spec),
        "spec_id": content_id(spec),
        "quality": as_json(checks),
        "separate_sweep": 0,
        "symmetry": symmetry,
        "water_density": water.density,
        "water_depth": str(water.depth),
        "gravity": water.gravity,
        "solves": len(found.solved),
        "frequencies": len(study.omega),
        "bem_seconds": sum(block.attrs["seconds"] for block in blocks),
        **_at_rest(body),
    }
    complete = ds.assign({name: (PAIR, matrix) for name, matrix in matrices.items()}).assign(cut(body))
    if (errors := signed_errors(found)) is not None:
        error = stiffness_error(body, stiffness, found.resolution_ratio, water.density, water.gravity)
        complete = complete.merge(errors.assign({f"hydrostatic_stiffness_{ESTIMATE}": ((ESTIMATE, *PAIR), error)}))
    return complete.assign_attrs(ds.attrs, **attrs)


REFINABLE = ("error_estimate", "far_field", "haskind", "symmetry", "panels", "lid")
"""Checks whose failure smaller panels may mend."""
MOST_GIGABYTES, MOST_SECONDS = 1.0, 120.0
"""Memory of a frequency, and time of all on one core, that a refinement may take."""
SMALLEST_STEP, LARGEST_STEP = 0.5, 0.75
"""Bounds of the size of panels over that before: errors fall with it at least in proportion."""


def refined_file(file: BodyFile, body: FlexibleBody, checks: Sequence[Check]) -> BodyFile | None:
    """Return a body file with panels small enough for its failed checks; None where none, or no affordable ones, help.

    A hull is meshed anew, panels of a mesh file are divided. Panels with displacements of their own stay, and where
    irregular frequencies are solved without a lid no panels help.
    """
    failed = [check for check in checks if check.verdict == "fail"]
    bare = not file.lid and file.omega[-1] > BELOW_IRREGULAR * first_irregular_frequency(body, file.water.gravity)
    if not any(check.name in REFINABLE for check in failed) or file.rigid_motions is None or bare:
        return None
    wanted = min(0.8 * check.limit / check.value for check in failed if check.name in REFINABLE)
    factor = min(max(wanted, SMALLEST_STEP), LARGEST_STEP)
    squared = (len(body.faces) / factor**2) ** 2
    if GIGABYTES * squared > MOST_GIGABYTES or SECONDS * squared * len(file.omega) > MOST_SECONDS:
        return None
    if file.hull is not None:
        hull = file.hull.model_copy(update={"panel": factor * file.hull.panel})
        return file.model_copy(update={"mesh": hull})
    longest = file.panel or float(panel_diameters(body).max() / np.sqrt(2))
    return file.model_copy(update={"panel": factor * longest})


def history_of(file: BodyFile, finer: BodyFile, checks: Sequence[Check]) -> str:
    """Return what a refinement changes and why, for the history of a database."""
    failed = ", ".join(f"{check.name} {check.value:.3g}" for check in checks if check.verdict == "fail")
    before, after = (each.hull.panel if each.hull else each.panel for each in (file, finer))
    sizes = f"to {after or np.nan:.3g} m" + (f" from {before:.3g} m" if before else "")
    return f"panels made smaller, {sizes}, because of {failed}"
