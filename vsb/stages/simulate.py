"""Rule simulate: one design in one sea."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from vsb.engine.integrators.exact import propagate, steady_state
from vsb.engine.integrators.harmonic_balance import check_stable, harmonic_balance
from vsb.engine.integrators.simulate import in_words, legs, recorded
from vsb.engine.integrators.switching import periodic_power
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import port_kind
from vsb.engine.shell.deformed import DeformedShell, enclosed
from vsb.engine.shell.modes import constraint_drift
from vsb.engine.shell.orders import OrderBasis, enclosed_in_orders
from vsb.engine.waves.sampling import relative_error
from vsb.engine.waves.seas import FEW
from vsb.errors import ConvergenceError, StabilityError
from vsb.models.build import STEADY, DesignInSea, design_in_sea
from vsb.stages.stage import Stamp
from vsb.study.specs import Run
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray
from vsb.tools.files import save

UNSETTLED = 1e-3
"""Relative difference between the powers of late periods above which a motion does not repeat [-]."""


def run_simulate(run: Run, out: str, stamp: Stamp, database: str = "", radiation: str = "") -> None:
    """Simulate one design in one sea and write its trajectory."""
    study = run.study
    (design,), (wave,) = study.designs, study.waves
    made = design_in_sea(run, {"database": database, "radiation": radiation})
    scene, waves, system = made.scene, made.sea, made.system
    records: list[xr.Dataset] = []
    taken: list[tuple[int, float, int, float]] = []
    for leg in legs(system, waves, study.simulation, made.spectrum):
        record = recorded(system, leg, waves if database else None, study.simulation.window)
        record = with_enclosed(record, made.shape, made.orders) if made.shape else with_stroke(record, made)
        records.append(record.isel(time=slice(1 if records else 0, None)))
        drift = constraint_drift(leg.motion.position @ scene.motions.T, made.held)
        taken.append((len(leg.motion.time) - 1, leg.motion.seconds, leg.steps, drift))
    intervals, seconds, steps, drifts = zip(*taken, strict=True)
    attrs = {"design": design, "wave": wave.label, "energy_residual": leg.balance.residual, "status": "completed"}
    attrs |= {"method": in_words(leg.method, sum(steps)), "instants": 1 + sum(intervals)}
    attrs["port_kind"] = port_kind(study.pto.port).load
    attrs |= {"seconds": sum(seconds), **made.notes, **stamp}
    if scene.water and len(waves.omega) > FEW:
        attrs["wave_sampling_error"] = relative_error(float(waves.omega.max()), study.simulation.duration)
    if wave.regular:
        attrs |= _steady(system) if not study.pto.of_package else {"no_steady_state": "the law may depend on time"}
    if made.held.size:
        attrs["constraint_drift"] = max(*drifts, _linear_drift(study, system, made.held))
    save(xr.concat(records, "time").assign_attrs(attrs), out)


def with_enclosed(run: xr.Dataset, shape: DeformedShell, orders: Sequence[OrderBasis] = ()) -> xr.Dataset:
    """Return a record with the volume the shell encloses and its area."""
    labels = [*shape.basis.labels, *(label for basis in orders for label in basis.labels)]
    moved = run.position.reindex(dof=labels, fill_value=0.0).values
    if orders:
        volume, area = enclosed_in_orders(shape.basis, orders, moved)
    else:
        volume, area = enclosed(shape.basis, shape.modal_amplitude + moved)
    return run.assign(volume=("time", volume), area=("time", area))


def with_stroke(run: xr.Dataset, made: DesignInSea) -> xr.Dataset:
    """Return a record of a body with the displacement and the velocity of its take-off's port."""
    labels = list(made.scene.labels)
    port = xr.DataArray(made.port, dims="dof", coords={"dof": labels}).sel(dof=run.dof)
    return run.assign(stroke=run.position @ port, stroke_rate=run.velocity @ port)


def _steady(system: System) -> dict[str, float | str]:
    """Mean power of the steady state and what a period leaves of a transient; or why there is none.

    Under latching, or a force that jumps, the power of a motion followed until its periods agree.
    """
    if system.linear and system.scene.unrestrained:  # what nothing holds has no mean place
        return {"steady_power": _swinging_power(system), "steady_decay": 1.0}
    try:
        if system.has_latching_time or system.jumps:
            return _settled(system)
        if system.linear and system.scene.take_off not in system.scene.memories:
            period = 2 * np.pi / float(system.omega[0])
            power, left = _swinging_power(system), np.exp(np.linalg.eigvals(system.matrix) * period)
            check_stable(left, period)
            return {"steady_power": power, "steady_decay": float(np.abs(left).max())}
        found = harmonic_balance(system, 1e-6)
    except (ConvergenceError, StabilityError) as error:
        return _settled(system) if system.switching else {"no_steady_state": str(error)}
    return {"steady_power": found.power.pto, "steady_decay": found.decay}


def _swinging_power(system: System) -> float:
    """Mean power absorbed in a linear scene once transients are over [W]."""
    swinging, (damper, _) = steady_state(system)[:, system.free : 2 * system.free], system.dampers()
    return float(0.5 * np.real(np.einsum("wi,ij,wj->", swinging.conj(), damper, swinging)))


def _settled(system: System) -> dict[str, float | str]:
    """Mean power of a law that switches once its periods agree; or that they do not."""
    try:
        power, difference = periodic_power(system, STEADY)
    except ConvergenceError as error:
        return {"no_steady_state": str(error)}
    if difference > UNSETTLED:
        return {"no_steady_state": f"powers of periods from rest on differ by up to {100 * difference:.2g} %"}
    return {"steady_power": power, "steady_difference": difference}


def _linear_drift(study: Study, system: System, clamps: FloatArray) -> float:
    """Largest slip at the clamps [m] over 10 000 wave periods; motion that is not linear is followed once only."""
    if not system.linear or study.waves[0].still:
        return 0.0
    time = np.linspace(0.0, 1e4 * 2 * np.pi / study.waves[0].omega, 20_001)
    start = system.scene.start(study.simulation.initial_position, study.simulation.initial_velocity)
    return constraint_drift(propagate(system, time, start).position @ system.scene.motions.T, clamps)
