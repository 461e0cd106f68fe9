"""Rule design_verification: the best flexible buoy and the best rigid one in the same seas of the year in time."""

import json
from typing import Any, Literal

import numpy as np
import xarray as xr

from vsb.design.compared import COMPETITOR, FLEXIBLE, Buoy, buoy_of
from vsb.design.searched import best
from vsb.engine.motion.port import Port
from vsb.engine.waves.climate import Climate
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.models.floating_system import BuoyOfShape
from vsb.models.rest import reference_shell
from vsb.models.viability import with_designs
from vsb.results.verification import DesignInTime, chances, drawn, verified, verified_dataset
from vsb.results.year import frequencies, year
from vsb.stages.check import read_climate
from vsb.stages.design import outcomes
from vsb.stages.members import in_time, in_words, powers_in_time, swept_shape
from vsb.stages.stage import Stamp
from vsb.study.sections import DEGREES
from vsb.study.specs import DesignVerificationSpec
from vsb.study.study import Study, parse
from vsb.tools.files import save

GIVEN: Literal["fixed"] = "fixed"
"""Tuning of the runs: each buoy has the damper it was found with."""


def run_design_verification(
    spec: DesignVerificationSpec, climate: str, starts: str, root: str, out: str, stamp: Stamp
) -> None:
    """Simulate seas drawn from the year with both buoys and write the gain they say, or why a run failed.

    A failure is a result: the search before it took minutes, and its report says what to change.
    """
    try:
        said, found = _followed(spec, climate, starts, root)
    except (ConfigError, ConvergenceError, StabilityError) as error:
        said, found = {"failure": str(error).removeprefix("verify: ")}, xr.Dataset()
    said |= {"model": spec.verify.model, "runs": in_words(spec.verify)}
    save(found.assign_attrs(verified=json.dumps(said), model=spec.verify.model, **stamp), out)


def _followed(spec: DesignVerificationSpec, climate: str, starts: str, root: str) -> tuple[dict[str, Any], xr.Dataset]:
    """The gain both buoys have in the same seas with its interval [%], their powers [W], and the corrected year."""
    seas = read_climate(spec.flexible.climate, climate)
    buoys = [
        buoy_of(FLEXIBLE, spec.flexible, best(outcomes(starts, spec.starts))),
        buoy_of(COMPETITOR, spec.rigid, best(outcomes(starts, spec.rigid_starts))),
    ]
    studies = {one.design: simulated(one, spec) for one in buoys}
    ports = {design: _port(study, design, seas, root) for design, study in studies.items()}
    given = {one.design: one.quantities["damping"] for one in buoys}
    linear_year = year(ports, seas, next(iter(studies.values())).water, (GIVEN,), given, spec.rigid.design)
    sample = drawn(chances(linear_year, GIVEN), seas.hours, spec.verify.seas, spec.verify.seed)
    designs: dict[str, DesignInTime] = {design: in_time(study, root)[design] for design, study in studies.items()}
    dampers = np.array([one.of_seas for one in linear_year.absorbed.values()])
    powers = powers_in_time(seas, dampers, sample, designs, spec.simulation, spec.verify.model)
    runs = verified(linear_year, GIVEN, sample, *powers)
    gain = runs.gain(0, 1)
    assert gain is not None  # the reference is the other one
    powers_of = {one.name: runs.power(i).mean for i, one in enumerate(buoys)}
    said = {"value": gain.mean, "low": gain.low, "high": gain.high, "power": powers_of}
    return said, verified_dataset(linear_year, GIVEN, runs)


def simulated(one: Buoy, spec: DesignVerificationSpec) -> Study:
    """Return the study of a buoy with the model of the runs, its own design alone.

    Raises `ConfigError` if the study cannot be followed by the model.
    """
    raw = one.with_damper().study.model_dump(exclude_none=True)
    raw |= {"simulation": spec.simulation, "hydro": {**raw["hydro"], "model": spec.verify.model}}
    raw["modes"] |= {"degree": one.degree or DEGREES[0]}
    return with_designs(parse(raw, source=f"verify: {one.name}"), [one.design])


def _port(study: Study, design: str, seas: Climate, root: str) -> Port:
    """What the damper of a buoy sees over the frequencies of the year."""
    rest = reference_shell(study)
    floating = BuoyOfShape(study, rest, swept_shape(study, rest.basis, root))
    return floating.at(frequencies(seas, *floating.band)).ports(study.pto.stiffness)[design]
