"""Checks of runs of a buoy or a body: energy, small motion, steady state, agreement with linear theory."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from vsb.engine.hydro.database import Check, check_at_most
from vsb.engine.hydro.dofs import flexible
from vsb.engine.hydro.formats.common import volume_of
from vsb.engine.hydro.variables import RIGID, ROTATIONS, body_of, is_of_ring, motion_of
from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import CONVOLVED
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.shell.orders import largest_deformation, largest_displacement, largest_strain
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.water import wavenumber
from vsb.models.drag import DAMPERS, LINEARISED
from vsb.models.rest import order_bases, reference_shell
from vsb.models.viability import static_strain
from vsb.results.comparison import Attributes, Row, Runs, linear_mean, relative_difference
from vsb.results.ledger import strain_check
from vsb.study.sections import POWER_TOLERANCE
from vsb.study.study import BaseStudy, Study
from vsb.tools.variables import FORCE, MOMENT
from vsb.tools.words import plain

ROTATION, TRANSLATION = 0.2, 0.3
"""Rotation of a body [rad], and translation over the cube root of the displaced volume, beyond which there is doubt."""
LEAST_MARGIN = 0.1
"""Distance of an open loop from -1 (Nyquist) below which its port must be known better than it is."""
NEAR_THE_END = 0.8
"""Part of the range of latching times searched, beyond which the best one may lie outside it."""


def sea_checks(
    study: BaseStudy, wave: Wave, runs: Runs, basis: ModeBasis | None = None, database: xr.Dataset | None = None
) -> list[Check]:
    """Return the checks of all runs in a sea: energy, small motion, slip at clamps, what model `auto` leaves out.

    Parameters
    ----------
    runs : mapping design -> trajectory in this sea
    basis : ModeBasis, optional
        Axisymmetric shell modes, of a study of a buoy.
    database : xarray.Dataset, optional
        Of a study of a body.
    """
    checks = []
    for design in study.designs:
        run = runs[design]
        energy = energy_check(study.simulation, run.attrs["energy_residual"])
        checks.append(replace(energy, design=design, wave=wave.label))
        if study.buoy:
            assert basis is not None
            checks += buoy_motion_checks(study.buoy, basis, wave, run)
        else:
            assert database is not None
            checks += body_motion_checks(study, database, run)
        if "constraint_drift" in run.attrs:
            linear = "over 10 000 wave periods" if study.needs_bem and wave.label != "still" else "over the run"
            text, drift = f"largest slip of the shell at its clamps {linear}", run.attrs["constraint_drift"]
            checks.append(check_at_most("constraint_drift", drift, 1e-9, "m", text, design=design, wave=wave.label))
    if study.buoy and study.buoy.hydro.model == "auto":
        checks += simplification_checks(study.buoy, wave, runs)
    return checks


def energy_check(settings: Simulation, residual: float) -> Check:
    """Return whether the energy residual of a run is what its integration method promises."""
    closed = max(settings.tolerance, CONVOLVED if settings.method == "convolution" else 1e-6)
    text = "unbalanced energy over the largest term"
    return check_at_most("energy_residual", residual, closed, "-", text, doubt=True)


def buoy_motion_checks(study: Study, basis: ModeBasis, wave: Wave, run: xr.Dataset) -> list[Check]:
    """Return heave, attitude, deformation and strain in the window against what a linear model allows."""
    radius, where = study.device.radius, {"design": run.attrs["design"], "wave": wave.label}
    inside = run.sel(time=slice(*study.simulation.window))
    heave = float(np.abs(inside.position.values[:, 0]).max()) / radius
    checks = [check_at_most("heave", heave, 0.3, "-", "heave amplitude over radius", doubt=True, **where)]
    if study.motion != "heave":
        moved = {name: inside.position.sel(dof=name).values if name in run.dof else 0.0 for name in RIGID}
        tilt = float(np.max(np.hypot(moved["Pitch"], moved["Roll"])))
        checks.append(check_at_most("pitch", tilt, 0.3, "rad", "largest angle from upright", doubt=True, **where))
        if not wave.still:
            towards = np.deg2rad(wave.direction)
            along = float(np.max(np.abs(np.cos(towards) * moved["Surge"] + np.sin(towards) * moved["Sway"])))
            phase = along * wavenumber(wave.omega, study.water.depth, study.water.gravity)
            text = f"wavenumber times the largest surge, {plain(along)} m; without a mooring a start drifts"
            checks.append(check_at_most("surge", phase, 0.5, "-", text, doubt=True, **where))
    if flexible(run.dof.values):
        moved_shell, strain = deformation(study, basis, inside)
        text = "shell displacement over radius"
        checks.append(check_at_most("deformation", moved_shell, 0.1, "-", text, doubt=True, **where))
        checks.append(strain_check("strain", strain, basis.shell.law.range, **where))
    return checks


def deformation(study: Study, basis: ModeBasis, run: xr.Dataset) -> tuple[float, float]:
    """Return displacement of the shell over its radius and largest strain [-], at the instant of largest amplitudes.

    Of rubber the strain is that of rest and motion together, as its law measures it.
    """
    position = run.position.sel(dof=[label for label in run.dof.values if not is_of_ring(str(label))])
    shell = [label for label in position.dof.values if label not in RIGID]
    peaks = position.values[np.argmax(np.abs(position.sel(dof=shell).values).sum(axis=1))]
    if orders := order_bases(study, basis):
        moved, strain = largest_deformation(basis, orders, peaks)
    else:
        moved, strain = largest_displacement(basis, peaks), largest_strain(basis, peaks)
        if basis.shell.rubber:
            strain = static_strain(basis, reference_shell(study, basis).modal_amplitude + peaks)
    return moved / study.device.radius, strain


def body_motion_checks(study: BaseStudy, database: xr.Dataset, run: xr.Dataset) -> list[Check]:
    """Return the largest rotation in the window, and the largest translation over the body's size if that is known."""
    where = {"design": run.attrs["design"], "wave": run.attrs["wave"]}
    largest = np.abs(run.position.sel(time=slice(*study.simulation.window))).max("time")
    labels, checks = list(map(str, run.dof.values)), []
    kinds = np.array(list(map(motion_of, labels)))
    if (rotations := np.isin(kinds, RIGID[3:])).any():
        value = float(largest.values[rotations].max())
        checks.append(check_at_most("rotation", value, ROTATION, "rad", "largest rotation", doubt=True, **where))
    whole = database.attrs.get(volume_of(""), 0.0)
    volumes = np.array([float(database.attrs.get(volume_of(body_of(label)), whole)) for label in labels])
    if (translations := np.isin(kinds, RIGID[:3]) & (volumes > 0)).any():
        value = float((largest.values[translations] / volumes[translations] ** (1 / 3)).max())
        text = "largest translation over the cube root of the displaced volume"
        checks.append(check_at_most("translation", value, TRANSLATION, "-", text, doubt=True, **where))
    return checks


def simplification_checks(study: Study, wave: Wave, runs: Runs) -> list[Check]:
    """Return the errors of powers and gains by what the automatic model leaves out in a sea."""
    limit, checks, errors = study.hydro.power_tolerance or POWER_TOLERANCE, [], {}
    for design in study.designs:
        attrs = runs[design].attrs
        errors[design] = float(attrs["power_error"])
        parts = [f"{item['what'].replace('_', ' ')} {item['error']:.1e}" for item in json.loads(attrs["left_out"])]
        text = (
            f"estimated error of mean power; described as {attrs['description']}; left out: {', '.join(parts) or '-'}"
        )
        if "unmeasured" in attrs:
            text = f"errors of simplifications could not be measured ({attrs['unmeasured']}); {text}"
            checks.append(Check("left_out", errors[design], limit, "-", "doubt", text, design, wave.label))
        else:
            checks.append(check_at_most("left_out", errors[design], limit, "-", text, design=design, wave=wave.label))
    if (base := errors.pop(study.reference_design or "", None)) is not None:
        text = "estimated error of the ratio of mean powers to the rigid design's, from what both leave out"
        for design, error in errors.items():
            total = error + base
            checks.append(check_at_most("gain_error", total, 2 * limit, "-", text, design=design, wave=wave.label))
    return checks


def transient_checks(runs: Attributes, rows: Sequence[Row]) -> list[Check]:
    """Return by how much mean power in the window differs from that of the steady state."""
    checks = []
    for row in rows:
        attrs, where = runs[row["design"], row["wave"]], {"design": row["design"], "wave": row["wave"]}
        if "no_steady_state" in attrs:
            text = f"no steady state to compare with, the mean depends on the window: {attrs['no_steady_state']}"
            checks.append(Check("transient", 1.0, 0.0, "-", "doubt", text, **where))
        elif "steady_power" in attrs:
            steady, mean = attrs["steady_power"], row["record_power_mean"]
            text = f"mean power is {mean:.6g} W in the window, {steady:.6g} W in the steady state; "
            if "steady_decay" in attrs:
                text += f"in a period a transient falls to {attrs['steady_decay']:.3g} of its size"
            else:
                text += f"its periods differ by {attrs['steady_difference']:.1e}"
            difference = relative_difference(mean, steady)
            checks.append(check_at_most("transient", difference, 0.005, "-", text, doubt=True, **where))
    return checks


def _controller_check(attrs: Mapping[str, Any], **where: str) -> Check:
    """The margin of a causal controller, whose loop is stable, and what it absorbs by linear theory without a limit."""
    margin = attrs["controller_margin"]
    text = f"margin of a controller of {attrs['controller_states']} states, distance of its open loop from -1 "
    text += f"(Nyquist): {margin:.3g}; by linear theory without a force limit it absorbs "
    text += f"{attrs['controller_power']:.4g} W with an rms force of {attrs['controller_force_rms']:.4g}, as a filter "
    text += f"{attrs['controller_error']:.1e} from the optimum"
    return check_at_most("controller_margin", LEAST_MARGIN / margin, 1.0, "-", text, doubt=True, **where)


def law_checks(runs: Attributes) -> list[Check]:
    """Return the margin of each controller, and where each body-exact latching time lies in the range searched."""
    checks = []
    for (design, wave), attrs in runs.items():
        if "controller_margin" in attrs:
            checks.append(_controller_check(attrs, design=design, wave=wave))
        if "linear_latching_time" not in attrs or not attrs["latching_time"]:
            continue
        best, linear, searched = (
            attrs[key] for key in ("latching_time", "linear_latching_time", "latching_time_searched")
        )
        text = f"absorbs most with a latching time of {best:.3g} s body-exact, {linear:.3g} s in the linear scene, "
        text += f"searched within {searched:.2g} s of that: the best one may lie outside"
        share = abs(best - linear) / searched
        checks.append(
            check_at_most("latching_time", share, NEAR_THE_END, "-", text, doubt=True, design=design, wave=wave)
        )
    return checks


def agreement_checks(study: BaseStudy, frequency: xr.Dataset, rows: Sequence[Row], runs: Attributes) -> list[Check]:
    """Return by how much mean powers of runs in regular waves differ from those of linear theory.

    Of a linear run the difference is an error of the simulation, of a body-exact run what nonlinearity does, and of
    a run with quadratic drag what its equivalent damper misses.
    """
    checks, waves = [], {wave.label: wave for wave in study.waves if wave.regular}
    for row in rows:
        design, label, mean = row["design"], row["wave"], row["record_power_mean"]
        run = runs[design, label]
        expected = linear_mean(study, waves[label], frequency, design, run) if label in waves else None
        if expected is None:
            continue
        if LINEARISED in run:
            name, limit = "drag", 0.05
            text = f"mean power is {plain(mean)} W with quadratic drag, {plain(expected)} W with its equivalent damper "
            text += f"of {_dampers_in_words(study, run)}; the frequency response and the matched limit have no drag"
        elif run["model"] == "body_exact":
            name, limit = "linearity", 0.05
            text = f"mean power is {plain(mean)} W body-exact, {plain(expected)} W in linear theory"
        else:
            name, limit = "time_and_frequency_domain", 0.005
            text = "relative difference of mean absorbed power; large if the window still holds a transient"
        difference = relative_difference(mean, expected)
        checks.append(check_at_most(name, difference, limit, "-", text, doubt=True, design=design, wave=label))
    return checks


def _dampers_in_words(study: BaseStudy, run: Any) -> str:
    """Equivalent dampers of a run's drag; of several directions each with its name."""
    names = [name.lower() if study.buoy else name for name in study.plates] or ["heave"]
    values = [plain(float(damper)) for damper in np.atleast_1d(run[DAMPERS])]
    if names == ["heave"]:
        return f"{values[0]} {FORCE.damping_unit}"
    units = ((MOMENT if name.rpartition("__")[2].capitalize() in ROTATIONS else FORCE).damping_unit for name in names)
    return " and ".join(f"{c} {unit} of {name}" for c, unit, name in zip(values, units, names, strict=True))
