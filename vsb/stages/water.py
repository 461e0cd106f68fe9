"""Shell modes of a study, meshes to look at, the spectral solution of the water, and the hydro database of blocks."""

import json
import math
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from vsb import __version__
from vsb.engine.hydro import database, orders, quality
from vsb.engine.hydro.database import Check, with_history
from vsb.engine.hydro.dofs import displacements
from vsb.engine.hydro.panels.mesh import write_shell
from vsb.engine.hydro.spectral.solver import MOST_NODES, SpectralProblem, converged, converged_on_grid, fewest_nodes
from vsb.engine.hydro.variables import AT_GEOMETRY, OF_GEOMETRY, PAIR, is_of_ring
from vsb.engine.shell.deformed import ReferenceShell, rigid_buoy
from vsb.engine.shell.meridian import also_through, curve
from vsb.engine.shell.modes import Mode
from vsb.engine.shell.orders import OrderBasis
from vsb.engine.shell.shell import Shell
from vsb.errors import ConvergenceError, DatabaseError
from vsb.models.rest import (
    check_stable,
    clamps,
    load_displacements,
    mooring_stiffness,
    order_bases,
    order_stiffness,
    reference_shell,
    with_rings,
)
from vsb.stages.stage import Stamp
from vsb.study.resolution import COARSEST_SWEEP
from vsb.study.specs import SpectralBlock, StudyPart
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray
from vsb.tools.files import load, save
from vsb.tools.stamps import record

COLATITUDES = np.linspace(0.0, np.pi, 181)
REST = ("rest_radial", "rest_meridional")
"""Variables that lead from the sphere to another shape at rest, where there is one."""
ORDER = "order"
"""Azimuthal order of a mode; a study of heave alone has none but 0, and does not say so."""


def run_modes(study: StudyPart, out: str, stamp: Stamp) -> None:
    """Write the shell modes of a study, after checking that every design has motions left."""
    reference = reference_shell(study)
    check_stable(study, reference)
    save(shell_modes(study, reference).assign_attrs(basis=study.modes.basis, **stamp), out)


def shell_modes(study: Study, reference: ReferenceShell) -> xr.Dataset:
    """Return shapes, degrees, dry frequencies and amplitudes at rest of the shell modes, in the plane of the waves."""
    orders = [basis for basis in order_bases(study, reference.basis) if not basis.odd]  # the odd ones are these, turned
    heaving = reference.basis
    v, u = heaving.displacement(COLATITUDES)
    parts = [_shapes(heaving.modes, 0, v[1:], u[1:], heaving.dry_frequencies, reference.modal_amplitude[1:])]
    for basis in orders:
        v, u, _ = (part[basis.rigid :] for part in basis.field(COLATITUDES))
        parts.append(_shapes(basis.modes, basis.order, v, u, basis.dry_frequencies, np.zeros(len(basis.modes))))
    modes = xr.concat(parts, "mode") if orders else parts[0].drop_vars(ORDER)
    if (rest := reference.basis.shell.rest) is not None:  # what leads to it from the sphere, along e_r and e_phi
        at, sin, cos = curve(rest, COLATITUDES), np.sin(COLATITUDES), np.cos(COLATITUDES)
        beyond = at.x * sin + at.z * cos - study.device.radius, at.x * cos - at.z * sin
        modes = modes.assign({name: ("colatitude", each) for name, each in zip(REST, beyond, strict=True)})
    height = study.centre_height + reference.modal_amplitude[0]
    return modes.assign_attrs(radius=study.device.radius, centre_height=height)


def _shapes(
    modes: Sequence[Mode], order: int, radial: FloatArray, meridional: FloatArray, dry: FloatArray, static: FloatArray
) -> xr.Dataset:
    """Shapes of the modes of an order along the meridian theta = 0."""
    return xr.Dataset(
        {
            "radial": (("mode", "colatitude"), radial),
            "meridional": (("mode", "colatitude"), meridional),
            "degree": ("mode", [mode.degree for mode in modes]),
            ORDER: ("mode", np.full(len(modes), order)),
            "dry_frequency": ("mode", dry),
            "static_amplitude": ("mode", static),
        },
        coords={"mode": np.array([mode.label for mode in modes], dtype=str), "colatitude": COLATITUDES},
    )


def run_display(study: StudyPart, out: str, manifest: str, stamp: Stamp) -> None:
    """Write the shell at rest and the displacement of every mode as a mesh to look at."""
    write_shell(reference_shell(study).shape, out)
    record(manifest, stamp["spec_id"], [out])


REFINED = (0.1, 0.01)
"""Shares of the tolerance to which blocks of a database that fails a check are solved again, one after the other."""
REFINABLE = ("haskind", "rank_one", "symmetry", "positive_damping", "irregular_frequencies", "kramers_kronig")
"""Checks that fail of motions which move little water: their coefficients are small parts of the largest entry."""
_ALONG_BAND = (0.3, 0.7, 1.0, 1.3, 1.6, 2.0)
"""Frequencies at which a shape's own error is sampled, over sqrt(g/r)."""
_NODES = 64
"""Points of the solver there: the spline of forty points bends as often."""
_SOLVED = ("added_mass", "radiation_damping", "excitation_force")
_GEOMETRY = (AT_GEOMETRY, *OF_GEOMETRY.values())
FILM = 1e-4
"""Thickness of a shell that moves as a whole, of no consequence, in radii."""


def run_spectral(block: SpectralBlock, out: str, stamp: Stamp) -> None:
    """Solve one block of frequencies, as finely as the tolerance needs."""
    solved = _solved(block)
    save(solved.assign_attrs(**geometry_errors(block), **stamp), out)


def _solved(block: SpectralBlock, share: float = 1.0) -> xr.Dataset:
    """A block solved to a share of its tolerances, with its `seconds`."""
    begun, problem, omega = clock.perf_counter(), spectral_problem(block), list(block.omega)
    if block.interpolation:
        found = converged_on_grid(problem, omega, share * block.tolerance, share * block.interpolation)
    else:
        found = converged(problem, omega, share * block.tolerance)
    return found.assign_attrs(seconds=clock.perf_counter() - begun)


def spectral_problem(block: SpectralBlock) -> SpectralProblem:
    """Return the problem of a block: the shape at rest and its displacements."""
    shape, water = block.shape, block.water
    moved = displacements(block.displacements, block.order)
    if isinstance(shape, Study):
        reference = reference_shell(shape)
        shell, moved = reference.shape, (*moved, *(load_displacements(shape, reference) if shape.has("pto") else ()))
    else:
        rest = shape.shape.meridian(shape.radius) if shape.shape else None
        shell = rigid_buoy(Shell(shape.radius, FILM * shape.radius, 1.0, 0.0, 1.0, rest), shape.centre_height)
    nodes = min(fewest_nodes(moved), MOST_NODES)
    return SpectralProblem(shell, moved, water.density, water.gravity, nodes, depth=water.depth)


def geometry_errors(block: SpectralBlock) -> dict[str, object]:
    """Return relative errors of the coefficients of heave by what a profile's points leave open, as attributes.

    Twice the difference of two curves through the points at the same displacement: of a capsule by 9 to 42 points it
    was 1.1 to 22 times the error of the spline, coefficient by coefficient. Nothing of other shapes.
    """
    shape, water = block.shape, block.water
    hull = shape.device if isinstance(shape, Study) else shape
    given, radius = hull.shape, hull.radius
    if given is None or given.profile is None or block.order:
        return {}
    rest = given.meridian(radius)
    volume = rest.volume_below(-shape.centre_height)
    omega = [share * math.sqrt(water.gravity / radius) for share in _ALONG_BAND]
    found = []
    for meridian in (rest, also_through(given.profile, radius)):
        height = -(meridian.lowest + meridian.draft_of(volume))
        shell = rigid_buoy(Shell(radius, 1e-9 * radius, 1.0, 0.0, 1.0, meridian), height)
        heave = SpectralProblem(shell, displacements(["Heave"]), water.density, water.gravity, _NODES, water.depth)
        ds = database.with_excitation(heave.solve(omega))
        plane = shell.hydrostatic_stiffness(water.density, water.gravity)[0, 0]
        found.append([*(np.abs(ds[name].values).ravel() for name in _SOLVED), np.full(len(omega), plane)])
    errors = (2 * np.abs(other / own - 1) for own, other in zip(*found, strict=True))
    return {AT_GEOMETRY: omega} | dict(zip(OF_GEOMETRY.values(), (each.tolist() for each in errors), strict=True))


def run_database(
    study: StudyPart,
    sweep: list[str],
    tabulated: list[str],
    omega_max: float,
    tolerance: float,
    accept: list[str],
    blocks: str,
    out: str,
    stamp: Stamp,
) -> None:
    """Merge the blocks in a folder, express them in the modes, check them, and store them with their verdict.

    Raises `DatabaseError` if a block is missing or foreign, or a check fails that the study does not accept.
    """
    water = study.water
    found = {name: _block(f"{blocks}/{name}.nc", name) for name in (*sweep, *tabulated)}
    solver = str(_asked(next(iter(found.values())))["solver"])
    precision = min(1.0, tolerance / COARSEST_SWEEP) if solver == "spectral" else 1.0
    reference = reference_shell(study)
    families = order_bases(study, reference.basis)
    if study.has("pto"):  # beside loaded rings, too
        reference = with_rings(study, reference, wet=clamps(study))

    def in_modes(blocks: Blocks) -> tuple[tuple[list[_Part], list[xr.Dataset], list[xr.Dataset] | None], list[Check]]:
        parts = [_Part(study, reference, blocks, basis) for basis in (None, *(one for one in families if not one.odd))]
        swept = [part.in_modes(sweep) for part in parts]
        infinite = [name for name in sweep if "omega" not in blocks[name].dims]
        asked = [part.in_modes([*tabulated, *infinite]) for part in parts] if tabulated else None
        checks = quality.estimate_checks([block.attrs for block in blocks.values()], tolerance)
        for i, part in enumerate(parts):
            checks += part.verdict(swept[i], asked[i] if asked else None, precision)
        return (parts, swept, asked), checks

    (parts, swept, asked), checks, history = refined(found, in_modes, accept)
    attrs = {
        "title": "hydro database of an axisymmetric shell in heave and its modes",
        "source": f"vsb {__version__}",
        **stamp,
        "quality": database.as_json(quality.judged(checks, accept)),
        "radius": study.radius,
        **_at_rest(study),
        "centre_height": study.centre_height,
        "basis": study.modes.basis if study.flexible else "rigid",
        "degree": study.modes.max_degree if study.flexible else 1,
        "clamps": json.dumps(clamps(study)),
        "water_density": water.density,
        "water_depth": str(water.depth),
        "gravity": water.gravity,
        "solver": solver,
        **{name: value for block in found.values() for name, value in block.attrs.items() if name in _GEOMETRY},
        "bem_seconds": sum(block.attrs["seconds"] for block in found.values()),
    }
    everywhere = _whole(study, parts, swept, families)
    if asked is None:
        kept = with_history(everywhere.sel(omega=slice(None, omega_max + 1e-9)), *history)
        database.save_database(kept.assign_attrs(kept.attrs, **attrs), None, out)
    else:
        asked_for = with_history(_whole(study, parts, asked, families), *history)
        database.save_database(asked_for.assign_attrs(asked_for.attrs, **attrs), everywhere, out)


Blocks = Mapping[str, xr.Dataset]
"""Blocks of frequencies by their ids."""
Made = TypeVar("Made")


def refined(
    blocks: Blocks, assemble: Callable[[Blocks], tuple[Made, list[Check]]], accept: Sequence[str]
) -> tuple[Made, list[Check], list[str]]:
    """Return what is made of blocks with its checks, and their history.

    They are solved again more finely while a check fails that this may mend. Blocks of panels stay as they are: their
    mesh would be another one.
    """
    (made, checks), history = assemble(blocks), []
    for share in REFINED:
        failing = {check.name for check in checks if check.verdict == "fail"} - set(accept)
        if not failing & set(REFINABLE):
            break
        try:
            blocks = {name: _solved_again(block, share) for name, block in blocks.items()}
        except ConvergenceError:
            break
        worse, (made, checks) = checks, assemble(blocks)
        pairs = zip(worse, checks, strict=True)
        changes = (f"{one.name} {one.value:.3g} became {new.value:.3g}" for one, new in pairs if one.name in failing)
        history.append(f"solved again to {share:g} of the tolerance: {', '.join(changes)}")
    return made, checks, history


def _solved_again(block: xr.Dataset, share: float) -> xr.Dataset:
    """A block solved again to a share of its tolerances; `ConvergenceError` where its solver does not reach it."""
    raw = _asked(block)
    if raw["solver"] != "spectral":
        raise ConvergenceError("panels: solved again they need another mesh")
    solved = _solved(SpectralBlock.model_validate(raw), share)
    stamps = {key: block.attrs[key] for key in ("spec", "spec_id")}
    return solved.assign_attrs(**stamps, seconds=block.attrs["seconds"] + solved.attrs["seconds"])


def _at_rest(study: Study) -> dict[str, object]:
    """Volume and centres of a shape that is not a sphere, for other codes."""
    if (rest := study.device.meridian) is None:
        return {}
    height = study.centre_height
    return {
        "displaced_volume": rest.volume_below(-height),
        "centre_of_buoyancy": [0.0, 0.0, height + rest.centroid_below(-height)],
        "centre_of_mass": [0.0, 0.0, height + (study.device.centre_of_mass or 0.0)],
    }


@dataclass(frozen=True)
class _Part:
    """The degrees of freedom of one azimuthal order, from blocks to the database."""

    study: Study
    reference: ReferenceShell
    found: Blocks
    basis: OrderBasis | None = None  # of order m >= 1; none: heave and axisymmetric modes

    @property
    def order(self) -> int:
        """Azimuthal order m."""
        return self.basis.order if self.basis else 0

    def in_modes(self, ids: Sequence[str]) -> xr.Dataset:
        """Coefficients of blocks, those of other orders left out."""
        own = [name for name in ids if _asked(self.found[name])["order"] == self.order]
        merged = database.merged_blocks([self.found[name] for name in own])
        moved = (
            orders.in_order_modes(merged, self.basis) if self.basis else database.in_modes(merged, self.reference.basis)
        )
        return _limited_by_band(database.with_excitation(moved))

    def verdict(self, swept: xr.Dataset, asked: xr.Dataset | None, precision: float) -> list[Check]:
        """Checks of what moves water, as pitch about the sphere's centre does not."""
        still = [label for label in swept.influenced_dof.values if label == "Pitch"]
        wet, tabulated = (
            None if part is None else part.drop_sel(influenced_dof=still, radiating_dof=still)
            for part in (swept, asked)
        )
        assert wet is not None
        return quality.verdict(wet, tabulated, self.study.water, precision, self.order)

    def complete(self, raw: xr.Dataset) -> xr.Dataset:
        """Coefficients made symmetric, with the structure; those of orders m >= 1 also passive at all frequencies."""
        water, even = self.study.water, database.with_symmetrized(raw)
        if not self.basis:
            return database.with_structure(even, self.reference)
        passive = orders.with_haskind_damping(even, self.order, water.depth, water.density, water.gravity)
        return orders.with_order_structure(passive, self.basis, order_stiffness(self.study, self.basis, self.reference))


def _limited_by_band(ds: xr.Dataset) -> xr.Dataset:
    """Coefficients whose added mass at infinity is, of shapes beside loads, what it is as seen from within the band.

    At the waterline their damping lasts beyond it, at frequencies far below their own.
    """
    ring = np.array([is_of_ring(str(label)) for label in ds.influenced_dof.values])
    if "added_mass_inf" not in ds or not ring.any() or ds.sizes["omega"] < 3:
        return ds
    known, limit = ds.added_mass_inf, quality.by_ogilvie(ds)
    return ds.assign(added_mass_inf=known.copy(data=np.where(np.logical_or.outer(ring, ring), limit, known.values)))


def _whole(
    study: Study, parts: Sequence[_Part], raw: Sequence[xr.Dataset], families: Sequence[OrderBasis]
) -> xr.Dataset:
    """All orders side by side, sines the same as their cosines, and what moors them."""
    complete = {part.order: part.complete(one) for part, one in zip(parts, raw, strict=True)}
    if not families:
        return complete[0]
    signed, going = [0, *(one.signed for one in families)], orders.headings([one.signed for one in families])
    own = [
        complete[0],
        *(complete[one.order] if not one.odd else _odd(study, parts[0].reference, one, complete) for one in families),
    ]
    turned = own if len(going) == 1 else [orders.in_headings(*one, going) for one in zip(own, signed, strict=True)]
    whole = orders.side_by_side(turned, signed)
    mooring = mooring_stiffness(study, tuple(map(str, whole.influenced_dof.values)))
    return whole.assign({f"{name}_stiffness": (PAIR, matrix) for name, matrix in mooring.items()})


def _odd(study: Study, reference: ReferenceShell, basis: OrderBasis, complete: Mapping[int, xr.Dataset]) -> xr.Dataset:
    """Motions of an odd family, in the waves that excite them most: as the even ones, turned; yaw moves no water."""
    like = complete[basis.order]
    part = orders.renamed(like, basis.labels) if basis.order else orders.still_part(like, basis)
    return orders.with_order_structure(part, basis, order_stiffness(study, basis, reference))


def _asked(block: xr.Dataset) -> dict[str, Any]:
    """What a block was solved for."""
    asked: dict[str, Any] = json.loads(block.attrs["spec"])["block"]
    return asked


def _block(path: str, name: str) -> xr.Dataset:
    """The block of a name."""
    block = load(path)
    if (found := block.attrs.get("spec_id")) != name:
        raise DatabaseError(f"{path}: holds block {found}, needs {name}; delete it and run again.")
    return block
