"""Stages members and verification: points of a campaign over its year, and a few of its seas in time beside them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from vsb.engine.hydro import database, orders, quality
from vsb.engine.hydro.database import Check
from vsb.engine.integrators.settings import Simulation
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.shell.orders import OrderBasis
from vsb.engine.waves.climate import Climate, realised
from vsb.errors import ConvergenceError, DatabaseError, StabilityError
from vsb.keys.quantities import canonical, content_id, result_id
from vsb.models.build import stored_memory
from vsb.models.floating_system import (
    STATED,
    BuoyOfShape,
    Floating,
    SweptShape,
    floating_body,
    floating_system,
    stored_body,
)
from vsb.models.rest import clamps, order_bases, rubber_shell
from vsb.models.stationary import realised_within
from vsb.models.viability import Viability, viability, viability_of_body, with_designs
from vsb.pipeline.graph import MEMORY, StudyPlan, database_path, radiation_path
from vsb.pipeline.plans import Member, members
from vsb.results.campaign import YearsWithin, member, ports_year, stacked
from vsb.results.causal_year import Schedule, schedules, year_of_schedules
from vsb.results.verification import (
    DECAYS,
    RECORD,
    STARTUP,
    Control,
    DesignInTime,
    Model,
    Sample,
    chances,
    drawn,
    record_of,
    verified,
    verified_dataset,
    with_all_designs,
    without_power,
)
from vsb.results.year import bins_of, frequencies
from vsb.stages.check import read_climate
from vsb.stages.make import make, solve
from vsb.stages.stage import Stamp
from vsb.stages.water import Blocks, refined
from vsb.study.campaign import CAUSAL, ClimateFile, Constrained, Tunings, Verify
from vsb.study.resolution import COARSEST_SWEEP, wets_rings
from vsb.study.specs import MemberSpec, VerificationSpec, spec_of
from vsb.study.study import Study
from vsb.study.vary import Point
from vsb.tools import packed
from vsb.tools.arrays import FloatArray
from vsb.tools.files import load, save


def run_members(
    base: dict[str, Any],
    points: list[Point],
    year: ClimateFile,
    tuning: tuple[Tunings, ...],
    constrained: Constrained | None,
    climate: str,
    folder: str,
    root: str,
    out: str,
) -> None:
    """Write the members of a batch, each to the end of one file as soon as it is finished, then all as netCDF.

    Members that are in another file of the folder, of batches that were cut otherwise, are taken from there.
    """
    batch = members(base, points, year, tuning, constrained)
    work = Work(read_climate(year, climate), tuning, constrained, root)
    stored, own = packed.packs(folder), packed.Pack(Path(folder, f"{Path(out).stem}{packed.SUFFIX}"))
    found = [finished(stored.get(one.id), own, one, work) for one in batch]
    ids = [one.id for one in batch]
    save(stacked(found, ids).assign_attrs(spec_id=content_id(ids)), out)


@dataclass
class Work:
    """What the members of a batch have in common."""

    climate: Climate
    tuning: tuple[Tunings, ...]
    constrained: Constrained | None
    root: str
    _coefficients: dict[tuple[str, ...], Any] = field(default_factory=dict)  # of the last shape or body alone
    _rigid: dict[bytes, Any] = field(default_factory=dict)  # years of rigid designs under dampers
    _optima: dict[bytes, Any] = field(default_factory=dict)  # years of rigid designs within limits

    def results(self, one: Member) -> xr.Dataset:
        """Return the results of a member."""
        rest, floating = at_rest(one.study, one.spec, self.root, self._coefficients)
        within: YearsWithin | None = None
        if given := self.constrained:
            from vsb.results.constrained_year import Optima  # compiled

            within = Optima(given.seconds, given.seed, self._optima)
        return member(rest, floating, self.climate, self.tuning, within, self._rigid)


def at_rest(
    study: Study, spec: MemberSpec, root: str, known: dict[tuple[str, ...], Any] | None = None
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

    if study.KIND == "body":
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
    found.attrs |= {"spec": canonical(spec_of("member", member=one.spec)), "spec_id": one.id}
    own.append(found)
    return found


def swept_shape(study: Study, basis: ModeBasis, root: str) -> SweptShape:
    """Return the coefficients of a shape, solved if they are not there.

    Raises `DatabaseError` if a check on them fails that the study does not accept.
    """
    plan = StudyPlan(study, root=root)
    solve(plan)
    families = order_bases(study, basis)
    orders = tuple(_of_order(plan, basis, one) for one in (None, *families))
    return SweptShape(orders, clamps(study) if wets_rings(study) else None)


def _of_order(plan: StudyPlan, basis: ModeBasis, family: OrderBasis | None) -> LinearSystem:
    """The coefficients of one azimuthal order, judged; none of a family: of heave and axisymmetric modes."""
    study, order, water = plan.study, family.order if family else 0, plan.study.water
    paths = [plan.block_path(block) for block in plan.sweep_blocks if block.order == order]
    blocks = {Path(path).stem: load(path, expected=Path(path).stem) for path in paths}
    tolerance = study.hydro.tolerance
    precision = min(1.0, tolerance / COARSEST_SWEEP) if not study.uses_panels else 1.0

    def assembled(blocks: Blocks) -> tuple[tuple[xr.Dataset, dict[str, float]], list[Check]]:
        some = list(blocks.values())
        whole = database.with_excitation(database.merged_blocks(some))
        wet = orders.in_wet_modes(whole, family) if family else database.in_modes(whole, basis)
        checks = quality.estimate_checks([block.attrs for block in some], tolerance)
        checks += quality.verdict(wet, None, water, precision, order)
        return (whole, {name: max(float(block.attrs.get(name, 0.0)) for block in some) for name in STATED}), checks

    (whole, errors), checks, _ = refined(blocks, assembled, study.hydro.accept)
    quality.judged(checks, study.hydro.accept)
    raw = database.with_symmetrized(whole)
    if order:
        raw = orders.with_haskind_damping(raw, order, water.depth, water.density, water.gravity)
    raw = raw.assign_attrs(errors)
    count = raw.sizes["influenced_dof"]
    return LinearSystem(raw, np.zeros((count, count)), LinearPto(0.0))


def run_verification(member: VerificationSpec, climate: str, root: str, out: str, stamp: Stamp) -> None:
    """Simulate the seas drawn from a member's year and write what they say about its designs that are viable.

    Where a run fails the corrected year has no values, and the attribute `failure` says which run and why.
    """
    seas, study = read_climate(member.climate, climate), member.study
    (rest, floating), found = at_rest(study, member, root), xr.Dataset(coords={"design": []})
    failure = ""
    if rest.designs:
        try:
            found = _of_viable(member, with_designs(study, rest.designs), floating(), seas, root)
        except (ConvergenceError, StabilityError) as error:  # linear theory of this member stands
            failure = str(error)
            print(failure, flush=True)
    found = with_all_designs(found, list(study.designs), study.reference_design)
    words = {"runs": in_words(member.verify), "model": member.verify.model, "failure": failure}
    save(found.assign_attrs(**words, **stamp), out)


def in_words(verify: Verify) -> str:
    """Return which runs these are."""
    model, means = verify.model.replace("_", "-"), f"means over {RECORD:g} energy periods"
    return f"{verify.seas} seas, {model}, {means} after a start-up of at least {STARTUP:g}"


def _of_viable(spec: VerificationSpec, study: Study, floating: Floating, seas: Climate, root: str) -> xr.Dataset:
    """The corrected year of designs that are viable, in the water of all."""
    (tuning,) = spec.tuning
    assert tuning in ("fixed", "one", "each", CAUSAL)  # the others are of no law in time
    at, by_bin = floating.at(frequencies(seas, *floating.band)), dict[str, Schedule]()
    if tuning == CAUSAL:
        by_bin = schedules(study, floating, seas, at.in_waves())
        year = year_of_schedules(study, seas, by_bin)
    else:
        year = ports_year(study, at.seen(study.pto.stiffness), seas, (tuning,))
        dampers = np.array([year.absorbed[design, tuning].of_seas for design in year.designs])
    if not year.annual_mean_power.any():
        return without_power(year)
    sample = drawn(chances(year, tuning), seas.hours, spec.verify.seas, spec.verify.seed)
    designs = bodies_in_time(spec, root) if study.KIND == "body" else in_time(spec.study, root)
    some = {design: designs[design] for design in study.designs}
    if tuning == CAUSAL:
        equipped = under_schedules(seas, by_bin, some)
        powers = runs_in_time(seas, sample, list(some), equipped, spec.study.simulation, spec.verify.model)
    else:
        powers = powers_in_time(seas, dampers, sample, some, spec.study.simulation, spec.verify.model)
    return verified_dataset(year, tuning, verified(year, tuning, sample, *powers))


def in_time(study: Study, root: str) -> Mapping[str, DesignInTime]:
    """Return the designs of a study ready for any sea, without a damper yet; its database made if it is not there."""
    plan = StudyPlan(study, root=root)
    make(plan, [plan.database.out, plan.radiation.out])
    return _ready(study, plan.database.out, plan.radiation.out)


def bodies_in_time(spec: VerificationSpec, root: str) -> Mapping[str, DesignInTime]:
    """Return the designs of a body ready for any sea, without a damper yet, from its database and radiation memory."""
    (database,) = spec.sweep
    memory = result_id(spec_of("radiation", **spec.study.hydro.model_dump(include=MEMORY)), database)
    return _ready(spec.study, database_path(root, database), radiation_path(root, memory), spec.climate.direction)


def _ready(study: Study, database: str, radiation: str, direction: float = 0.0) -> Mapping[str, DesignInTime]:
    """The designs of a study in waves of a direction [degrees], from its database and radiation memory."""
    floating, pto = floating_system(study, database), study.pto
    memory, shape = stored_memory(radiation, floating.linear), floating.shape
    linear, take_off = floating.towards(direction), LinearPto(0.0, pto.stiffness, floating.port)
    rubber = rubber_shell(study, shape.basis) if shape else None
    return {
        design: DesignInTime(linear, shape, memory, motions, take_off, pto, rubber)
        for design, motions in floating.motions.items()
    }


Equipped = Callable[[str, int], tuple[DesignInTime, float]]
"""Design, sea of the climate -> the design with its take-off there, and how long its motions last [s]."""


def under_schedules(climate: Climate, by_bin: Mapping[str, Schedule], designs: Mapping[str, DesignInTime]) -> Equipped:
    """Return the designs under the causal controller, or the damper, of the bin a sea is in."""
    bins, highest = bins_of(climate), float(climate.edges[-1])

    @cache
    def in_bin(name: str, row: int) -> tuple[DesignInTime, float]:
        design, own = designs[name], by_bin[name][row][CAUSAL]
        if own.optimum is None:
            damped = design.with_damping(own.damping)
            return damped, damped.decay_time(highest)
        (port, best), noise = own.optimum, design.pto.control.noise
        try:
            linear, limited = (realised_within(port, best, noise, f)[0] for f in (np.inf, design.pto.force_limit))
            control = Control(port.omega, port.controller(best.weights, noise), linear, limited)
            pto = design.pto.model_copy(update={"law": CAUSAL})
            controlled = replace(design, take_off=replace(design.take_off, damping=0.0), pto=pto, control=control)
            return controlled, controlled.decay_time(highest)
        except StabilityError as error:
            hs, te = (float(centres[row]) for centres in bins.centres)
            where = f"{name} in the bin of Hs {hs:.3g} m and Te {te:.3g} s"
            raise StabilityError(f"{where}: {error}") from None

    return lambda name, sea: in_bin(name, int(np.searchsorted(bins.occupied, bins.index[sea])))


def powers_in_time(
    climate: Climate,
    dampers: FloatArray,
    sample: Sample,
    designs: Mapping[str, DesignInTime],
    given: Simulation,
    model: Model,
) -> FloatArray:
    """Return `runs_in_time` of designs with a damper, or damper matrix, of each in each sea, (design, sea, ...)."""
    highest, names = float(climate.edges[-1]), list(designs)

    @cache
    def decay_time(name: str, damping: bytes) -> float:
        return designs[name].with_damping(np.frombuffer(damping).reshape(dampers.shape[2:])).decay_time(highest)

    def equipped(name: str, sea: int) -> tuple[DesignInTime, float]:
        own = dampers[names.index(name), sea]
        return designs[name].with_damping(own), decay_time(name, own.tobytes())

    return runs_in_time(climate, sample, names, equipped, given, model)


def runs_in_time(
    climate: Climate, sample: Sample, names: Sequence[str], equipped: Equipped, given: Simulation, model: Model
) -> FloatArray:
    """Return mean powers in the drawn seas: of the better model, of linear theory, of that without transients.

    Of shape (3, design, draw) [W]. Linear theory starts from rest where motions last longer than the longest start-up.
    Raises `ConvergenceError` or `StabilityError` if a run fails, with its sea.
    """
    found = np.empty((3, len(names), len(sample.sea)))
    for j, (index, seed) in enumerate(zip(sample.sea, sample.seed, strict=True)):
        designs = [equipped(name, int(index)) for name in names]
        longest = max(decay for _, decay in designs)
        settings = record_of(float(climate.te[index]), longest, given)  # all designs meet the same waves
        for i, (name, (design, decay)) in enumerate(zip(names, designs, strict=True)):
            low, high = design.buoy.database.omega.values[[0, -1]]
            sea = realised(climate, int(index), settings.duration, int(seed), low, high)
            where = f"{name} in a sea of Hs {climate.hs[index]:.3g} m and Te {climate.te[index]:.3g} s"
            try:
                run, steady = design.powers(sea, settings, model)
                decayed = settings.window[0] >= DECAYS * decay
                found[:, i, j] = run, steady if decayed else design.from_rest(sea, settings), steady
            except (ConvergenceError, StabilityError) as error:
                raise type(error)(f"{where}: {error}") from None
            print(f"{where}: {found[0, i, j]:.5g} W, {found[1, i, j]:.5g} W by linear theory", flush=True)
    return found
