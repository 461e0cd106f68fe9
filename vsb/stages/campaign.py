"""Rule campaign: all members of a campaign together, as netCDF and as a table."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
import xarray as xr

from vsb.engine.hydro import database, orders, quality
from vsb.engine.hydro.database import Check
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.shell.orders import OrderBasis
from vsb.engine.waves.climate import Climate
from vsb.errors import DatabaseError
from vsb.keys.quantities import canonical, content_id
from vsb.models.floating_system import AnyBody, Floating, floating_body, stored_body
from vsb.models.load_advice import advice
from vsb.models.ports import STATED, BuoyOfShape, SweptShape
from vsb.models.rest import order_bases
from vsb.models.viability import Viability, viability, viability_of_body, with_designs
from vsb.pipeline.graph import StudyPlan, database_path
from vsb.pipeline.plans import Member, members
from vsb.results.campaign import as_csv, gathered, stacked, with_verification
from vsb.results.member import YearsWithin, member
from vsb.stages.climate import read_climate
from vsb.stages.make import solve
from vsb.stages.water import refined
from vsb.study.resolution import COARSEST_SWEEP
from vsb.study.specs import CampaignSpec, MemberSpec, MembersSpec
from vsb.study.study import Study
from vsb.tools import packed
from vsb.tools.files import load, save, write_text
from vsb.tools.stamps import record


def run_members(spec: MembersSpec, climate: str, folder: str, root: str, out: str) -> None:
    """Write the members of a batch, each to the end of one file as soon as it is finished, then all as netCDF.

    Members that are in another file of the folder, of batches that were cut otherwise, are taken from there.
    """
    batch = members(spec.base, spec.points, spec.climate, spec.tuning, spec.constrained)
    work = Work(read_climate(spec.climate, climate), spec, root)
    stored, own = packed.packs(folder), packed.Pack(Path(folder, f"{Path(out).stem}{packed.SUFFIX}"))
    found = [finished(stored.get(one.id), own, one, work) for one in batch]
    ids = [one.id for one in batch]
    save(stacked(found, ids).assign_attrs(spec_id=content_id(ids)), out)


@dataclass
class Work:
    """What the members of a batch have in common."""

    climate: Climate
    spec: MembersSpec
    root: str
    _coefficients: dict[tuple[str, ...], Any] = field(default_factory=dict)  # of the last shape or body alone
    _rigid: dict[bytes, Any] = field(default_factory=dict)  # years of rigid designs under dampers
    _optima: dict[bytes, Any] = field(default_factory=dict)  # years of rigid designs within limits

    def results(self, one: Member) -> xr.Dataset:
        """Return the results of a member."""
        rest, floating = at_rest(one.study, one.spec, self.root, self._coefficients)
        return member(rest, floating, self.climate, self.spec.tuning, self._years_within(), self._rigid)

    def _years_within(self) -> YearsWithin | None:
        """What finds years within limits, if they are asked for; only then what is compiled is read."""
        if not (given := self.spec.constrained):
            return None
        from vsb.results.constrained_year import Optima

        return Optima(given.seconds, given.seed, self._optima)


def at_rest(
    study: Study | AnyBody, spec: MemberSpec, root: str, known: dict[tuple[str, ...], Any] | None = None
) -> tuple[Viability, Callable[[], Floating]]:
    """Return which designs of a member are viable, and what floats of these, to be asked for if there are any.

    `known` keeps the coefficients while members of the same shape, or body, follow.
    """
    kept = {} if known is None else known

    def coefficients(read: Callable[[], Any]) -> Any:
        if spec.sweep not in kept:
            kept.clear()
            kept[spec.sweep] = read()
        return kept[spec.sweep]

    if not isinstance(study, Study):
        body: LinearSystem = coefficients(lambda: stored_body(database_path(root, *spec.sweep)))
        floating = floating_body(study, replace(body, direction=float(np.deg2rad(spec.climate.direction))))
        found = viability_of_body(study, floating)
        return found, lambda: floating_body(with_designs(study, found.designs), floating.linear)
    rest, buoy = viability(study), study

    def buoy_of_shape() -> BuoyOfShape:
        assert rest.reference is not None  # where designs are viable
        basis = rest.reference.basis
        swept = coefficients(lambda: swept_shape(buoy, basis, root))
        return BuoyOfShape(with_designs(buoy, rest.designs), rest.reference, swept)

    return rest, buoy_of_shape


def finished(stored: packed.Pack | None, own: packed.Pack, one: Member, work: Work) -> xr.Dataset:
    """Return the results of a member from where they are stored, computed and written now if they are not."""
    try:
        if stored:
            return stored.read(one.id)
    except DatabaseError as error:
        print(f"{error} It is computed anew.")
    found = work.results(one)
    found.attrs |= {"spec": canonical(one.spec), "spec_id": one.id}
    own.append(found)
    return found


def swept_shape(study: Study, basis: ModeBasis, root: str) -> SweptShape:
    """Return the coefficients of a shape, solved if they are not there.

    Raises `DatabaseError` if a check on them fails that the study does not accept.
    """
    plan = StudyPlan(study, root=root)
    solve(plan)
    families = order_bases(study, basis)
    return SweptShape(tuple(_of_order(plan, basis, one) for one in (None, *families)))


def _of_order(plan: StudyPlan, basis: ModeBasis, family: OrderBasis | None) -> LinearSystem:
    """The coefficients of one azimuthal order, judged; none of a family: of heave and axisymmetric modes."""
    study, order, water = plan.study, family.order if family else 0, plan.study.water
    paths = [plan.block_path(block) for block in plan.sweep_blocks if block.order == order]
    blocks = {Path(path).stem: load(path, expected=Path(path).stem) for path in paths}
    made, _ = refined(blocks, lambda found: _Swept.of(study, list(found.values()), basis, family), study.hydro.accept)
    quality.judged(made.checks, study.hydro.accept)
    raw = database.with_symmetrized(made.whole)
    if order:
        raw = orders.with_haskind_damping(raw, order, water.depth, water.density, water.gravity)
    raw = raw.assign_attrs(made.errors)
    count = raw.sizes["influenced_dof"]
    return LinearSystem(raw, np.zeros((count, count)), LinearPto(0.0))


class _Swept(NamedTuple):
    """Coefficients of one azimuthal order from blocks, judged as those of a database are, and errors stated of them."""

    whole: xr.Dataset
    checks: list[Check]
    errors: dict[str, float]

    @classmethod
    def of(cls, study: Study, blocks: Sequence[xr.Dataset], basis: ModeBasis, family: OrderBasis | None) -> Self:
        """Return the coefficients of blocks; none of a family: of heave and axisymmetric modes."""
        whole = database.with_excitation(database.merged_blocks(blocks))
        wet = orders.in_wet_modes(whole, family) if family else database.in_modes(whole, basis)
        tolerance, order = study.hydro.tolerance, family.order if family else 0
        precision = min(1.0, tolerance / COARSEST_SWEEP) if not study.uses_panels else 1.0
        checks = quality.estimate_checks([block.attrs for block in blocks], tolerance)
        checks += quality.verdict(wet, None, study.water, precision, order)
        errors = {name: max(float(block.attrs.get(name, 0.0)) for block in blocks) for name in STATED}
        return cls(whole, checks, errors)


def _tried(spec: CampaignSpec, found: xr.Dataset) -> dict[str, str]:
    """What would carry the load of the shell that is nearest to it, where the shells of all points buckle."""
    nearest = int(found.margin.values.argmax())
    if float(found.margin.values.flat[nearest]) >= 0:
        return {}
    (one,) = members(spec.base, [spec.vary.points[nearest]], spec.climate, spec.tuning)
    return {"advice": advice(one.study)} if isinstance(one.study, Study) else {}


def run_campaign(spec: CampaignSpec, batches: str, verifications: str, out: str, table: str, manifest: str) -> None:
    """Write the results of a campaign from its batches and from what runs in time say."""
    found = gathered(spec, (load(Path(batches) / f"{batch}.nc", expected=batch) for batch in spec.batches))
    runs = [load(Path(verifications) / f"{one}.nc", expected=one) for one in spec.verifications]
    found = with_verification(spec, found, runs)
    identity = content_id(spec)
    save(found.assign_attrs(_tried(spec, found), spec=canonical(spec), spec_id=identity), out)
    write_text(table, as_csv(spec, found))
    record(manifest, identity, [table])
