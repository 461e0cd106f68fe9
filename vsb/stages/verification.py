"""Rule verification: runs in time of few seas of a member's year beside linear theory, and the year they correct."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import xarray as xr

from vsb.engine.integrators.settings import Simulation
from vsb.engine.motion.port import LinearPto
from vsb.engine.waves.climate import Climate, realised
from vsb.errors import ConvergenceError, StabilityError
from vsb.keys.quantities import content_id
from vsb.models.build import Memory, body_memory, radiation_model
from vsb.models.floating_system import AnyBody, Floating, floating_system
from vsb.models.rest import rubber_shell
from vsb.models.stationary import realised_within
from vsb.models.viability import with_designs
from vsb.pipeline.graph import StudyPlan, database_path, radiation_path
from vsb.results.causal_year import Schedule, schedules_at_port, year_of_schedules
from vsb.results.matrix_year import year_of_matrices
from vsb.results.member import ports_year
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
from vsb.stages.campaign import at_rest
from vsb.stages.climate import read_climate
from vsb.stages.make import make
from vsb.stages.stage import stamp
from vsb.study.body import BodyHydro
from vsb.study.campaign import CAUSAL, Verify
from vsb.study.specs import BodySystem, RadiationSpec, VerificationSpec
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray
from vsb.tools.files import save


def run_verification(spec: VerificationSpec, climate: str, root: str, out: str) -> None:
    """Simulate the seas drawn from a member's year and write what they say about its designs that are viable.

    Where a run fails the corrected year has no values, and the attribute `failure` says which run and why.
    """
    seas, system = read_climate(spec.climate, climate), spec.system
    study = system if isinstance(system, BodySystem) else spec.simulated
    (rest, floating), found = at_rest(study, spec, root), xr.Dataset(coords={"design": []})
    failure = ""
    if rest.designs:
        try:
            found = _of_viable(spec, with_designs(study, rest.designs), floating(), seas, root)
        except (ConvergenceError, StabilityError) as error:  # linear theory of this member stands
            failure = str(error)
            print(failure, flush=True)
    found = with_all_designs(found, list(study.designs), study.reference_design)
    words = {"runs": in_words(spec.verify), "model": spec.verify.model, "failure": failure}
    save(found.assign_attrs(**words, **stamp(spec)), out)


def in_words(verify: Verify) -> str:
    """Return which runs these are."""
    return (
        f"{verify.seas} seas, {verify.model.replace('_', '-')}, means over {RECORD:g} energy periods after a start-up "
        f"of at least {STARTUP:g}"
    )


def _of_viable(
    spec: VerificationSpec, study: Study | AnyBody, floating: Floating, seas: Climate, root: str
) -> xr.Dataset:
    """The corrected year of designs that are viable, in the water of all."""
    (tuning,) = spec.tuning
    assert tuning in ("fixed", "one", "each", CAUSAL)  # the others are of no law in time
    at, schedules = floating.at(frequencies(seas, *floating.band)), dict[str, Schedule]()
    if tuning == CAUSAL:
        schedules = schedules_at_port(study, floating, seas, at.in_waves())
        year = year_of_schedules(study, seas, schedules)
    elif study.pto.several:
        year, dampers = year_of_matrices(study, at.several_ports(), seas, tuning)
    else:
        year = ports_year(study, at.ports(study.pto.stiffness), seas, (tuning,))
        dampers = year.dampers[:, 0]
    if not year.annual_mean_power.any():
        return without_power(year)
    sample = drawn(chances(year, tuning), seas.hours, spec.verify.seas, spec.verify.seed)
    designs = in_time(spec.simulated, root) if spec.buoy else bodies_in_time(spec, root)
    some = {design: designs[design] for design in study.designs}
    if tuning == CAUSAL:
        equipped = under_schedules(seas, schedules, some)
        powers = runs_in_time(seas, sample, list(some), equipped, spec.simulation, spec.verify.model)
    else:
        powers = powers_in_time(seas, dampers, sample, some, spec.simulation, spec.verify.model)
    return verified_dataset(year, tuning, verified(year, tuning, sample, *powers))


def in_time(study: Study, root: str) -> Mapping[str, DesignInTime]:
    """Return the designs of a study ready for any sea, without a damper yet; its database made if it is not there."""
    plan = StudyPlan(study, root=root)
    make(plan, [plan.database.out, plan.radiation.out])
    floating = floating_system(study, plan.database.out)
    radiation = radiation_model(plan.radiation.out, floating.linear.labels)
    take_off, shell = LinearPto(0.0, study.pto.stiffness, floating.port), floating.shell
    rubber, memory = rubber_shell(study, shell.basis), Memory(radiation, floating.linear.added_mass_inf)
    return {
        design: DesignInTime(floating.linear, shell, memory, motions, take_off, study.pto, rubber)
        for design, motions in floating.motions.items()
    }


def bodies_in_time(spec: VerificationSpec, root: str) -> Mapping[str, DesignInTime]:
    """Return the designs of a body ready for any sea, without a damper yet, from its database and radiation memory."""
    (database,), hydro, pto = spec.sweep, spec.hydro, spec.pto
    assert isinstance(hydro, BodyHydro)
    memory = RadiationSpec(database=database, tolerance=hydro.tolerance, added_mass_inf=hydro.added_mass_inf)
    radiation = body_memory(radiation_path(root, content_id(memory)))
    floating = floating_system(spec, database_path(root, database))
    linear, take_off = floating.towards(spec.climate.direction), LinearPto(0.0, pto.stiffness, floating.port)
    return {
        design: DesignInTime(linear, None, radiation, motions, take_off, pto)
        for design, motions in floating.motions.items()
    }


Equipped = Callable[[str, int], tuple[DesignInTime, float]]
"""Design, sea of the climate -> the design with its take-off there, and how long its motions last [s]."""


def under_schedules(
    climate: Climate, schedules: Mapping[str, Schedule], designs: Mapping[str, DesignInTime]
) -> Equipped:
    """Return the designs under the causal controller, or the damper, of the bin a sea is in."""
    bins, highest = bins_of(climate), float(climate.edges[-1])

    @cache
    def in_bin(name: str, row: int) -> tuple[DesignInTime, float]:
        design, own = designs[name], schedules[name][row][CAUSAL]
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
    """Return `runs_in_time` of designs with dampers.

    Parameters
    ----------
    dampers : ndarray, shape (design, sea) or (design, sea, port, port)
        Damper of each design in each sea, or its damper matrix.
    designs : mapping name -> DesignInTime
    """
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

    Linear theory starts from rest where motions last longer than the longest start-up.

    Raises `ConvergenceError` or `StabilityError` if a run fails, with its sea.

    Parameters
    ----------
    names : sequence of str
        Of the designs.
    given : Simulation
        Tolerance and method.
    model : {'body_exact', 'linear'}

    Returns
    -------
    ndarray, shape (3, design, draw) [W]
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
