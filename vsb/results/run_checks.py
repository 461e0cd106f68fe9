"""Checks of runs that hold of any floating thing: energy, what is held, time against frequency domain."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from vsb.hydro.database import Check, check_at_most
from vsb.integrators.simulate import CONVOLVED
from vsb.results.comparison import Row
from vsb.results.power import apart, in_direction, power_response
from vsb.scenes.drag import DAMPERS, LINEARISED
from vsb.study.quantities import ROTATIONS
from vsb.study.study import BaseStudy, Simulation, Study
from vsb.study.waves import RegularWave, Wave
from vsb.tools.words import plain

Attributes = Mapping[tuple[str, str], Mapping[str, Any]]
"""What runs say of themselves, by design and label of the sea."""


def energy_check(study: BaseStudy, run: xr.Dataset) -> Check:
    """Return whether a run closes its energy balance."""
    check = audit_check(study.simulation, run.attrs["energy_residual"])
    return replace(check, design=run.attrs["design"], wave=run.attrs["wave"])


def audit_check(settings: Simulation, residual: float) -> Check:
    """Return whether an energy residual is what the method of a run promises."""
    closed = max(settings.tolerance, CONVOLVED if settings.method == "convolution" else 1e-6)
    text = "unbalanced energy over the largest term"
    return check_at_most("energy_residual", residual, closed, "-", text, doubt=True)


def drift_checks(study: BaseStudy, run: xr.Dataset) -> list[Check]:
    """Return whether what a design holds at zero stays there, if it holds something."""
    if "constraint_drift" not in run.attrs:
        return []
    where = {"design": run.attrs["design"], "wave": run.attrs["wave"]}
    linear = "over 10 000 wave periods" if study.needs_bem and where["wave"] != "still" else "over the run"
    text = f"largest slip of the shell at its clamps {linear}"
    return [check_at_most("constraint_drift", run.attrs["constraint_drift"], 1e-9, "m", text, **where)]


def agreement_checks(
    study: BaseStudy, wave: Wave, frequency: xr.Dataset, rows: Sequence[Row], runs: Attributes
) -> list[Check]:
    """Return by how much mean powers in a regular wave in time differ from those of the frequency domain."""
    if not isinstance(wave, RegularWave) or study.pto.switches:
        return []
    checks, label = [], wave.label  # not made anew for every row: there may be thousands of each
    means = {row["design"]: row["power_mean"] for row in rows if row["wave"] == label}
    for design in study.designs:
        run = runs[design, label]
        if LINEARISED in run:
            checks.append(drag_check(study, wave, run, means[design], design))
            continue
        found = power_response(study, in_direction(frequency, wave), design, run)
        power = float(found.sel(omega=wave.omega, method="nearest"))
        check = linearity_check if run["model"] == "body_exact" else steady_state_check
        checks.append(check(study, wave, power, means[design], design))
    return checks


def steady_state_check(study: BaseStudy, wave: RegularWave, power: float, mean: float, design: str) -> Check:
    """Return the difference of mean power between time and frequency domain."""
    expected = power * wave.amplitude**2
    difference = apart(mean, expected)
    return check_at_most(
        "time_and_frequency_domain", difference, 0.005, "-",
        "relative difference of mean absorbed power; large if the window still holds a transient",
        doubt=True, design=design, wave=wave.label,
    )  # fmt: skip


def linearity_check(study: BaseStudy, wave: RegularWave, power: float, mean: float, design: str) -> Check:
    """Return the difference of body-exact mean power from linear theory: what nonlinearity does."""
    expected = power * wave.amplitude**2
    difference = apart(mean, expected)
    text = f"mean power is {plain(mean)} W body-exact, {plain(expected)} W in linear theory"
    return check_at_most("linearity", difference, 0.05, "-", text, doubt=True, design=design, wave=wave.label)


def dampers_in_words(study: BaseStudy, run: Mapping[str, Any]) -> str:
    """Return the equivalent dampers of a run's drag, of several directions each with its name."""
    names = list(study.drag.directions) if isinstance(study, Study) and study.drag else ["heave"]
    found = [plain(float(damper)) for damper in np.atleast_1d(run[DAMPERS])]
    if names == ["heave"]:
        return f"{found[0]} N s/m"
    units = ("N m s" if name.capitalize() in ROTATIONS else "N s/m" for name in names)
    each = zip(found, units, names, strict=True)
    return " and ".join(f"{damper} {unit} of {name}" for damper, unit, name in each)


def drag_check(study: BaseStudy, wave: RegularWave, run: Mapping[str, Any], mean: float, design: str) -> Check:
    """Return the difference of mean power with quadratic drag from that beside its equivalent damper."""
    expected = float(run[LINEARISED])
    difference = apart(mean, expected)
    text = f"mean power is {plain(mean)} W with quadratic drag, {plain(expected)} W beside its equivalent damper of "
    text += f"{dampers_in_words(study, run)}; the frequency response and the matched limit know no drag"
    return check_at_most("drag", difference, 0.05, "-", text, doubt=True, design=design, wave=wave.label)
