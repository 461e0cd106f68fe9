"""Rule simulate: one design in one sea."""

from typing import Any

import numpy as np

from vsb.errors import ConvergenceError, StabilityError
from vsb.integrators import trajectory
from vsb.integrators.exact import propagate
from vsb.integrators.harmonic_balance import harmonic_balance
from vsb.motion.clamps import constraint_drift
from vsb.motion.motion import Motion
from vsb.motion.scene import Plant
from vsb.scenes.build import SCENES
from vsb.shell.deformed import enclosed
from vsb.stages.stage import partial_study
from vsb.study.study import RegularWave, StillWater, Study
from vsb.tools.files import save
from vsb.tools.units import FloatArray

Spec = dict[str, Any]


def simulate(spec: Spec, paths: dict[str, Any], out: str) -> None:
    """Run one design in one sea and write its trajectory."""
    study = partial_study(spec)
    (design,), (wave,) = study.designs, study.waves
    plant, shape, waves, spectrum, notes = SCENES[study.hydro.model](study, paths)
    motion, stride, method = trajectory.simulate(plant, waves, study.simulation, spectrum)
    run = trajectory.labelled(plant, motion, waves if study.needs_bem else None, design, wave.label, stride)
    moved = np.zeros((run.sizes["time"], len(shape.amplitudes)))
    moved[:, : run.sizes["dof"]] = run.position.values
    volume, area = enclosed(shape.basis, shape.amplitudes + moved)
    attrs = {"method": method, "instants": len(motion.time), "seconds": motion.seconds, **notes}
    if isinstance(study.waves[0], RegularWave):
        attrs |= _steady(plant)
    if rows := study.designs[design].clamp:
        attrs["constraint_drift"] = _drift(study, plant, motion, shape.basis.clamp_rows(np.deg2rad(rows)))
    save(run.assign(volume=("time", volume), area=("time", area)).assign_attrs(run.attrs, **attrs), out)


def _steady(plant: Plant) -> dict[str, float | str]:
    """Mean power of the steady state and what a period leaves of a transient; or why there is none."""
    try:
        found = harmonic_balance(plant, 1e-6)
    except (ConvergenceError, StabilityError) as error:
        return {"no_steady_state": str(error)}
    return {"steady_power": found.power.pto, "steady_decay": found.decay}


def _drift(study: Study, plant: Plant, motion: Motion, rows: FloatArray) -> float:
    """Largest slip at the clamps [m]: over the run, and where motion is linear over 10 000 wave periods."""
    drift = constraint_drift(motion.position @ plant.motions.T, rows)
    if plant.water or isinstance(study.waves[0], StillWater):
        return drift
    time = np.linspace(0.0, 1e4 * 2 * np.pi / study.waves[0].omega, 20_001)
    start = plant.start(study.simulation.initial_position, study.simulation.initial_velocity)
    return max(drift, constraint_drift(propagate(plant, time, start).position @ plant.motions.T, rows))
