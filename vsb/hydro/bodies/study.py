"""From a mesh file and a file of displacements to a hydro database with its verdict: any body, any modes.

Every frequency is a file of its own under `blocks/`, named by the content of what it was solved from: it is never
solved twice, and an interrupted run goes on where it stopped.
"""

import hashlib
import time as clock
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from vsb import __version__
from vsb.errors import ConfigError, DatabaseError
from vsb.hydro import quality
from vsb.hydro.bodies.body import (
    SYMMETRIES,
    FlexibleBody,
    at_centres,
    check_symmetry,
    detected_symmetry,
    panel_diameters,
    panel_size,
    panels_per_lobe,
    rigid_misfit,
)
from vsb.hydro.bodies.coarsening import coarser_body
from vsb.hydro.bodies.files import read_body
from vsb.hydro.bodies.hydrostatics import hinge_gap, hydrostatic_stiffness, linear_share
from vsb.hydro.bodies.lid import first_irregular_frequency, gap_resonance, interior_lid
from vsb.hydro.bodies.rigid import rotation_centre
from vsb.hydro.bodies.solver import BodyProblem
from vsb.hydro.bodies.sweep import (
    Block,
    Measure,
    Swept,
    change_by_lid,
    error_estimate,
    least_sizes,
    resolution_ratio,
    signed_errors,
    sizes,
    swept,
)
from vsb.hydro.database import ESTIMATE, Check, as_json, check_at_most, with_excitation, with_symmetrized
from vsb.hydro.panels import rings as bem
from vsb.hydro.variables import PAIR
from vsb.study.blocks import panel_solver
from vsb.study.body import PHYSICS, BodyFile
from vsb.study.quantities import ROTATIONS, Section, canonical, content_id
from vsb.study.reading import read_yaml, validated
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray
from vsb.tools.files import load, save
from vsb.tools.stamps import check_output
from vsb.waves.dispersion import group_velocity, wavenumber

Spec = dict[str, Any]
Model = TypeVar("Model", bound=Section)
LARGEST_ERROR = 0.05
"""Estimated error above which there is doubt."""
FEWEST_PER_LOBE = 3.5
"""Panels in half a wavelength of a displacement below which there is doubt: fewer, and the estimate says too little."""
CHOICE = 0.02
"""Share of a stiffness in still water above which a choice that was made for it is doubted."""
LARGEST_GAP = 1e-3
"""Difference of the three volumes of a surface, relatively, above which its gaps are doubted."""
_SHUT = 1e-6  # below which there are none
_UNFELT = 0.9  # of the first irregular frequency
_UNRESOLVED = 2.0  # panels there, below which it fails
_COARSEST = 4.0  # wavelengths in a panel from which on nothing is solved
_GIGABYTES, _SECONDS = 6.3e-8, 6.5e-7  # per squared number of panels, of a frequency on one core; with 3200 panels
_MOST_GIGABYTES = 256.0  # a body may need
_GROUPS = ("fewer_panels", "radiated_waves")  # of a block's file


def read_config(path: str | Path, model: type[Model]) -> Model:
    """Read and validate a YAML file; `ConfigError` in one line with file, key, value received and needed."""
    return validated(model, read_yaml(path, "a file such as config/barge/body.yaml"), str(path))


def run(config: str | Path, out: str | Path, tables: str | Path | None = None) -> list[Check]:
    """Solve what a body file asks for into `out` and return the verdict; `tables` keeps the Green function's table."""
    return solve(*read_study(config, out), out, tables)


def read_study(config: str | Path, out: str | Path) -> tuple[BodyFile, FlexibleBody]:
    """Return a body file and the body it names, whose `history` says what was mended; `out` may hold no input."""
    study, folder = read_config(config, BodyFile), Path(config).parent
    check_output(Path(out, f"{study.body}.nc"), [folder / study.mesh, folder / study.modes])
    return study, read_body(folder / study.mesh, folder / study.modes, study.water.gravity)


def solve(study: BodyFile, body: FlexibleBody, out: str | Path, tables: str | Path | None = None) -> list[Check]:
    """Solve a body into the database `out`/<name>.nc and return the verdict; blocks already there are kept."""
    ds, checks = solved(study, body, out, tables)
    save(ds, Path(out, f"{study.body}.nc"))
    return checks


def solved(
    study: BodyFile, body: FlexibleBody, out: str | Path, tables: str | Path | None = None
) -> tuple[xr.Dataset, list[Check]]:
    """Return the database of a body and its verdict; blocks in `out` are kept, and those solved join them."""
    check_solvable(study, body)
    symmetry = detected_symmetry(body) if study.symmetry == "auto" else study.symmetry
    lid = needed_lid(study, body)
    table = Path(tables or Path(out, "green", panel_solver().replace(" ", "-")))
    blocks = Blocks(study, body, symmetry, lid, Path(out, "blocks"), table)
    infinite, directions = blocks(np.inf), np.deg2rad(study.wave_direction)
    size = sizes(infinite.own.added_mass_inf.values, least_sizes(body, study.water.density))
    centre = (body.vertices.max(axis=0) + body.vertices.min(axis=0)) / 2
    measure = Measure(size, centre, directions, study.water)

    def froude_krylov(omegas: FloatArray) -> ComplexArray:
        return blocks.problem.froude_krylov(omegas, directions)

    found = swept(blocks, froude_krylov, study.omega, study.tolerance, measure)
    checks = verdict(study, body, infinite, found, size)
    if lid:
        checks += lid_checks(blocks, found, size)
    return _database(study, body, symmetry, infinite, found, checks), checks


def needed_lid(study: BodyFile, body: FlexibleBody) -> tuple[FloatArray, IntArray] | None:
    """Return the lid a body file asks for, None if all its frequencies lie below the irregular ones."""
    return interior_lid(body, study.lid) if study.lid and study.omega[-1] > _regular(study, body) else None


def _regular(study: BodyFile, body: FlexibleBody) -> float:
    """Frequency up to which no irregular frequency is felt [rad/s]."""
    return _UNFELT * first_irregular_frequency(body, study.water.gravity)


def check_solvable(study: BodyFile, body: FlexibleBody) -> None:
    """Check what a body file asks for against its body, before anything is solved.

    Raises
    ------
    ConfigError
        If the symmetry declared is not the body's, the water is no deeper than its draught, waves are shorter than its
        panels, or there are too many of them.
    """
    if study.symmetry != "auto":
        check_symmetry(body, study.symmetry)
    if study.water.depth <= (draught := -float(body.vertices[:, 2].min())):
        raise ConfigError(
            f"water.depth: received {study.water.depth:g} m, needs more than the body's draught of {draught:.6g} m"
        )
    memory, _ = cost(study, body)
    if memory > _MOST_GIGABYTES:
        raise ConfigError(
            f"mesh: received {len(body.faces)} panels, whose matrices take {memory:.3g} GB; needs at most "
            f"{_MOST_GIGABYTES:g} GB: fewer panels, or a symmetry"
        )
    _check_wavelengths(study, body)


def cost(study: BodyFile, body: FlexibleBody) -> tuple[float, float]:
    """Return the memory a frequency takes [GB], and the seconds on one core; planes of symmetry halve both."""
    planes = SYMMETRIES[detected_symmetry(body) if study.symmetry == "auto" else study.symmetry]
    size = len(body.faces) ** 2 / 2 ** len(planes)
    return _GIGABYTES * size, _SECONDS * size


def _check_wavelengths(study: BodyFile, body: FlexibleBody) -> None:
    """Refuse waves of which a panel holds several: all that is found would be aliases, at a cost without bounds."""
    water, longest = study.water, float(panel_diameters(body).max())
    shortest = 2 * np.pi / wavenumber(study.omega[-1], water.depth, water.gravity)
    if longest > _COARSEST * shortest:
        needed = np.sqrt(2 * np.pi * water.gravity * _COARSEST / longest)  # in deep water, as such waves are
        raise ConfigError(
            f"omega: received {study.omega[-1]:g} rad/s, whose waves are {shortest:.3g} m long and the largest panel "
            f"{longest:.3g} m; needs at most {needed:.3g} rad/s: smaller panels or lower frequencies"
        )


@dataclass(frozen=True)
class Blocks:
    """Files of single frequencies: solved when first asked for, and never again."""

    study: BodyFile
    body: FlexibleBody
    symmetry: str
    lid: tuple[FloatArray, IntArray] | None
    folder: Path
    table: Path

    @cached_property
    def problem(self) -> BodyProblem:
        """The body in waves."""
        return BodyProblem(bem.stored_green_function(self.table), self.body, self.study.water, self.symmetry, self.lid)

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
            if not _is_solved(path, content_id(spec)):
                own, *others = _block(self.problem, *self._coarser, spec)
                save(own, path, dict(zip(_GROUPS, others, strict=True)))
            self._known[omega] = Block(load(path), *(load(path, group) for group in _GROUPS))
        return self._known[omega]


def _spec(study: BodyFile, body: FlexibleBody, omega: float, belts: int) -> Spec:
    """What one frequency is solved from; symmetry only saves time, infinite frequency has neither waves nor lid."""
    digest = hashlib.sha256()
    for array in (body.vertices, body.faces.astype(np.int64), body.modes):
        digest.update(np.ascontiguousarray(array).tobytes())
    spec = {"stage": "body", "physics": PHYSICS, "solver": panel_solver(), "omega": float(omega)}
    spec |= {"panels_and_modes": digest.hexdigest(), "labels": list(body.labels), "water": study.water.model_dump()}
    return spec if np.isinf(omega) else spec | {"lid": belts, "wave_direction": list(study.wave_direction)}


def _is_solved(path: Path, spec_id: str) -> bool:
    """Whether a block is there; what cannot be read is solved again."""
    try:
        return path.is_file() and load(path).attrs.get("spec_id") == spec_id
    except DatabaseError:
        return False


def _block(problem: BodyProblem, fewer: BodyProblem, share: float, spec: Spec) -> Block:
    """Coefficients at one frequency, those on fewer panels, and what their own waves say of them."""
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


def identities(ds: xr.Dataset, problem: BodyProblem) -> dict[str, float]:
    """Return errors at one frequency in terms of the radiation impedance |B_ii + i omega A_ii| of both motions [-].

    Of A and B from symmetry, of B from the energy of the far field, of excitation from Haskind's relation. An entry of
    B is measured by sqrt(Z_i Z_j), of X_i by the excitation that damping Z_i has, sqrt(4 rho g v_g Z_i/k).
    """
    omega, water = float(ds.omega[0]), problem.water
    impedance = (ds.radiation_damping + 1j * omega * ds.added_mass).values[0]
    z = np.maximum(np.abs(np.diag(impedance)), omega * least_sizes(problem.body, water.density) ** 2)
    pair = np.sqrt(np.outer(z, z))
    k, v_g = (f(omega, water.depth, water.gravity) for f in (wavenumber, group_velocity))
    wave = np.sqrt(4 * water.density * water.gravity * v_g / k * z)
    far = (ds.radiation_damping - ds.far_field_damping).values[0]
    haskind = (ds.Froude_Krylov_force + ds.diffraction_force - ds.haskind_force).values[0]
    return {
        "symmetry": float(np.abs((impedance - impedance.T) / pair).max()),
        "far_field": float(np.abs(far / pair).max()),
        "haskind": float(np.abs(haskind / wave).max()),
    }


_ERROR = "estimated error of added mass, damping and excitation, relative to the largest entry; smaller panels lower it"
_ALONE = "share of the surface without fewer panels to compare with, whose part of the error no estimate has"
_LOBE = "panel in terms of half a wavelength of the shortest mode; beyond the limit the error may exceed its estimate"
_LID = "change of coefficients by the lid, relative to the largest entry, where no irregular frequency is near:"
_IRREGULAR = "; irregular frequencies begin at about {:.3g} rad/s, a lid (lid: 8) removes them"
_PISTON = (
    "; near {:.3g} rad/s the water resonates in a gap of {:.3g} m between two bodies, which is no irregular frequency: "
    "panels there as small as the gap is wide, and viscous damping (body.damping), for linear waves hardly damp it"
)
_OPEN = "difference of the volumes by the normals' x, y and z, of gaps between panels"
_GAP = "share by which sealing the gap of a hinge, here full of water, would change its stiffness; waves see it sealed"
_LINEAR = "share of a displacement's stiffness that its unknown second-order part may have; second_order states it"
_MEANING = {
    "symmetry": "added mass and damping are symmetric matrices",
    "far_field": "damping is the energy of the waves sent in all directions",
    "haskind": "excitation follows from the waves radiated",
}


def verdict(study: BodyFile, body: FlexibleBody, infinite: Block, found: Swept, size: FloatArray) -> list[Check]:
    """Return the checks of a database before it is symmetrized."""
    solved, error = found.solved, error_estimate(found.solved, infinite, size)
    negative = quality.negative_damping(found.coefficients, np.outer(size, size))
    first = first_irregular_frequency(body, study.water.gravity)
    cure = "" if study.lid or study.omega[-1] < _UNFELT * first else _IRREGULAR.format(first)
    gap = gap_resonance(body, study.water.gravity)
    cure += _PISTON.format(*gap) if gap and study.omega[0] < gap.omega < study.omega[-1] else ""
    checks = [
        check_at_most("error_estimate", error, LARGEST_ERROR, "-", _ERROR + cure, doubt=True),
        check_at_most("one_resolution", 1 - infinite.own.attrs["coarser_share"], 0.5, "-", _ALONE, doubt=True),
        *(
            check_at_most(name, max(block.own.attrs[name] for block in solved), 0.02, "-", text + cure, doubt=True)
            for name, text in _MEANING.items()
        ),
        check_at_most("positive_damping", negative, 0.01, "-", "no motion can draw energy from calm water"),
    ]
    if study.tolerance is not None:
        text = f"{len(solved)} solves for {len(study.omega)} frequencies; relative to the band's largest entry"
        checks.insert(1, check_at_most("interpolation_error", found.error, study.tolerance, "-", text))
    return [*checks, *mesh_checks(study, body)]


def lid_checks(blocks: Blocks, found: Swept, size: FloatArray) -> list[Check]:
    """Return the check of a lid where it has nothing to mend, at the last frequency solved below irregular ones."""
    solved = [float(block.own.omega[0]) for block in found.solved]
    below = max((omega for omega in solved if omega <= _regular(blocks.study, blocks.body)), default=None)
    if below is None:
        return []
    change = change_by_lid(found.solved, replace(blocks, lid=None)(below), size)
    return [check_at_most("lid", change, LARGEST_ERROR, "-", f"{_LID} at {below:g} rad/s", doubt=True)]


def mesh_checks(study: BodyFile, body: FlexibleBody) -> list[Check]:
    """Return the checks of a body's panels, displacements and mass, which nothing need be solved for."""
    longest = float(panel_diameters(body).max())
    k = wavenumber(study.omega[-1], study.water.depth, study.water.gravity)
    lobe = 1 / panels_per_lobe(body)
    misfit = np.abs(at_centres(body.vertices, body.faces, body.shapes) - body.modes).max(axis=(1, 2))
    between = float((misfit / np.abs(body.modes).max(axis=(1, 2))).max())
    checks = [
        check_at_most("panels", longest * k / (2 * np.pi), 0.25, "-", "largest panel in wavelengths", doubt=True),
        check_at_most("modes", lobe, 1 / FEWEST_PER_LOBE, "-", _LOBE, doubt=lobe <= 1 / _UNRESOLVED),
        check_at_most("corners", between, 0.05, "-", "displacement of panels agrees with that of corners", doubt=True),
    ]
    named = "displacements named Surge, ..., Yaw are unit rigid motions"
    checks.append(check_at_most("rigid_names", rigid_misfit(body), 0.01, "-", named, doubt=True))
    for name, share, text in (("hinge_gap", hinge_gap(body), _GAP), ("second_order", linear_share(body), _LINEAR)):
        if share is not None:  # what is modelled is a choice: a doubt, never a failure
            checks.append(Check(name, share, CHOICE, "-", "doubt" if share > CHOICE else "ok", text))
    if (open_share := float(np.ptp(body.volumes) / body.volumes.max())) > _SHUT:
        text = f"{_OPEN} {body.gaps.width:.3g} m wide, widest at ({', '.join(f'{x:.4g}' for x in body.gaps.place)})"
        checks.append(check_at_most("closure", open_share, LARGEST_GAP, "-", text, doubt=True))
    heave = [i for i, (t, a) in body.rigid.items() if np.allclose([*t, *a], [0, 0, 1, 0, 0, 0], atol=1e-9)]
    if body.mass is not None and heave:
        afloat = abs(body.mass[heave[0], heave[0]] / (study.water.density * body.volume) - 1)
        checks.append(check_at_most("afloat", afloat, 0.01, "-", "mass in heave is that of the water displaced"))
    return checks


def _at_rest(body: FlexibleBody) -> Spec:
    """Volume of the water displaced, its centre and, if known, that of mass and of rotations, as attributes."""
    corner, area, _ = body.triangles
    square = ((corner**2).sum(axis=1) + corner.sum(axis=1) ** 2) / 12  # mean of x^2 over a triangle
    centre = (square * area).sum(axis=0) / 2 / body.volumes
    facts = {"displaced_volume": body.volume, "centre_of_buoyancy": centre}
    turning = [body.rigid.get(i) for i, label in enumerate(body.labels) if label in ROTATIONS]
    turned = rotation_centre([motion for motion in turning if motion]) if all(turning) else None
    points = {"centre_of_mass": body.centre_of_mass, "rotation_centre": turned}
    return facts | {name: point for name, point in points.items() if point is not None and point.ndim == 1}


def _stiffness_error(study: BodyFile, body: FlexibleBody, stiffness: FloatArray, ratio: float) -> FloatArray:
    """Estimated errors of the stiffness of still water, as of `signed_errors`, (way, dof, dof) [N/m].

    From the same fewer panels; waves radiated say nothing of it.
    """
    fewer, _ = coarser_body(body, SYMMETRIES[detected_symmetry(body)])
    fewer = replace(fewer, centre_of_mass=body.centre_of_mass, second_order=body.second_order)
    change = hydrostatic_stiffness(fewer, study.water.density, study.water.gravity) - stiffness
    return np.array([change / (ratio - 1), np.zeros_like(change)])


def _database(
    study: BodyFile, body: FlexibleBody, symmetry: str, infinite: Block, found: Swept, checks: list[Check]
) -> xr.Dataset:
    """What was found as a database with capytaine's names."""
    blocks = [block.own for block in (infinite, *found.solved)]
    stiffness = hydrostatic_stiffness(body, study.water.density, study.water.gravity)
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
        "water_density": study.water.density,
        "water_depth": str(study.water.depth),
        "gravity": study.water.gravity,
        "solves": len(found.solved),
        "frequencies": len(study.omega),
        "bem_seconds": sum(block.attrs["seconds"] for block in blocks),
        **_at_rest(body),
    }
    complete = ds.assign({name: (PAIR, matrix) for name, matrix in matrices.items()})
    if (errors := signed_errors(found)) is not None:
        of_stiffness = (ESTIMATE, *PAIR), _stiffness_error(study, body, stiffness, resolution_ratio(found))
        complete = complete.merge(errors.assign({f"hydrostatic_stiffness_{ESTIMATE}": of_stiffness}))
    return complete.assign_attrs(ds.attrs, **attrs)
