"""The validity ledger of a study: what to doubt, with a limit and a verdict for each."""

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import product

import numpy as np
import xarray as xr

from vsb.errors import ConvergenceError
from vsb.hydro import witness
from vsb.hydro.database import Check, check_at_most, stored_checks
from vsb.hydro.dofs import flexible
from vsb.results.attitude import attitude_checks
from vsb.results.comparison import Row, Runs
from vsb.results.ladder import Rung
from vsb.results.power import apart
from vsb.results.run_checks import Attributes, drift_checks, energy_check
from vsb.results.rung_errors import MODES
from vsb.results.verdicts import Invalid
from vsb.scenes.directions import loaded_shell, order_bases
from vsb.scenes.mode_convergence import knows_port
from vsb.scenes.rest import carries_load, computed_buckling
from vsb.scenes.viability import DOUBTED_STRAIN, static_modal_amplitude, static_strain
from vsb.shell.loaded import viable_pressure
from vsb.shell.modes import ModeBasis
from vsb.shell.reference import ReferenceShell
from vsb.shell.sphere import Shell
from vsb.shell.surface import largest_deformation, largest_displacement, largest_strain
from vsb.study.blocks import no_witness
from vsb.study.body import BodyStudy
from vsb.study.keys import KEYS
from vsb.study.quantities import RIGID, leaves
from vsb.study.sections import POWER_TOLERANCE
from vsb.study.study import IrregularSea, RegularWave, StillWater, Study, Water, Wave
from vsb.tools.words import plain
from vsb.waves.dispersion import power_limit, wavenumber
from vsb.waves.seas import share_above, share_below

HEAVING = "an axisymmetric heaving body"
DEGREES = {name for keys in KEYS.values() for name, key in keys.items() if key.unit == "degrees"}
"""Last words of the keys that are angles."""
LIKE_RADIANS = 4e-3
"""How near to a multiple of pi/12 an angle looks like radians: 1.57 and 6.28 do."""
_OWN_ERRORS = ("error_estimate", "interpolation_error")
"""Checks of a hydro database that say how far its coefficients may be off."""


def shell_checks(study: Study, reference: ReferenceShell) -> list[Check]:
    """Return what the static load does to a flexible shell: buckling by two criteria, deformation, strain."""
    if not study.flexible:
        return []
    checks, static = viability_checks(study), static_checks(study, reference)
    if study.device.shape is not None:
        return [*checks, *static]
    return [classical_check(study, reference, all(check.verdict != "fail" for check in checks)), *checks, *static]


def angle_checks(study: Study | BodyStudy) -> list[Check]:
    """Return a doubt if angles, which are given in degrees, look like radians: multiples of pi/12 with few digits."""
    found = []
    for key, value in leaves(study.model_dump()).items():
        words = [word for word in key.split(".") if not word.isdigit()]
        if words[-1] in DEGREES and isinstance(value, float) and 0.0 < abs(value) < 6.3 and not value.is_integer():
            degrees = 15 * round(np.degrees(value) / 15)
            if degrees and abs(value - np.radians(degrees)) < LIKE_RADIANS:
                found.append(f"{key} {value:g} ({degrees} degrees are {np.radians(degrees):.5g} rad)")
    text = f"angles are taken as degrees: {', '.join(found)}"
    return [Check("angles", len(found), 0.0, "-", "doubt", text)] if found else []


def classical_check(study: Study, reference: ReferenceShell, carried: bool) -> Check:
    """Return the classical criterion of buckling, of a uniform pressure; a remark where the shell is computed to hold.

    That a shell with internal pressure hangs in the water, pressed on its keel alone, is not its to know.
    """
    shell, water = Shell.of(study.device), study.water
    keel = max(0.0, water.density * water.gravity * reference.keel_depth - pressure_at_rest(study, reference))
    classical = shell.buckling_pressure
    text = f"net pressure at the keel {plain(keel)} Pa over the classical buckling pressure {plain(classical)} Pa"
    consequence = "above 1 the shell would buckle and the design is not viable"
    if carried:
        consequence = "of a uniform pressure; a remark, for the shell is computed to carry its own load"
    check = check_at_most("buckling", keel / classical, 1.0, "-", f"{text}: {consequence}")
    return replace(check, verdict="ok") if carried else check


def pressure_at_rest(study: Study, reference: ReferenceShell) -> float:
    """Return the gauge pressure inside a shell at rest [Pa]: that of trapped gas falls as the shell expands."""
    loaded = loaded_shell(study, reference.basis)
    return loaded.pressure(reference.modal_amplitude) if study.at_equilibrium else loaded.pressure_inside


def viability_checks(study: Study) -> list[Check]:
    """Return the linear buckling load, and the internal pressure that would carry a shell that buckles.

    Under internal pressure linear buckling is advice: a shell that comes to a stable rest shape along the nonlinear
    path of the growing load carries it, and the check is a doubt at most. About the equilibrium there is nothing to
    add: no shell that buckles on that path is accepted there.
    """
    if study.at_equilibrium:
        return []
    if study.device.shape is not None:
        text = "buckling is computed of the sphere alone: whether this shell carries its load is not known"
        return [Check("computed_buckling", 1.0, 1.0, "-", "doubt", text)]
    found = computed_buckling(study)
    text = f"static load over the linear buckling load, into a shape of degree {found.degree}"
    carried = found.load_factor < 1.0 and study.device.internal_pressure > 0 and carries_load(study)
    if carried:
        text += "; advice only: along the nonlinear path of the growing load the shell comes to a stable rest shape, "
        text += "which reference_shape: equilibrium computes"
    elif found.load_factor < 1.0:
        text += viable_text(study)
    check = check_at_most("computed_buckling", 1 / found.load_factor, 1.0, "-", text)
    return [replace(check, verdict="doubt") if carried else check]


def viable_text(study: Study) -> str:
    """Say from which internal pressure the shell is viable, and at what strain."""
    try:
        pressure, found = viable_pressure(study.device, study.centre_height, study.water)
    except ConvergenceError as error:
        return f"; {error}"
    strain = f"{100 * found.linear_strain:.2g} % linear strain at rest"
    least = float(f"{pressure:.3e}")
    least += 10.0 ** (math.floor(math.log10(least)) - 3) if 0 < least < pressure else 0.0  # rounded up: it holds there
    return f"; by linear buckling viable from device.internal_pressure = {plain(least)} Pa, at {strain}"


def static_checks(study: Study, reference: ReferenceShell) -> list[Check]:
    """Return displacement and strain of the shell at rest, about which motion is linearised or which is left out."""
    basis, static = reference.basis, static_modal_amplitude(study, reference)
    left_out = "" if study.at_equilibrium else "; the reference shape is undeformed"
    moved = largest_displacement(basis, static) / basis.shell.radius
    strain = static_strain(basis, static)
    limit = 0.2 if study.at_equilibrium else 0.05
    return [
        check_at_most(
            "static_deformation", moved, limit, "-",
            f"static displacement of the shell over its radius{left_out}", doubt=True,
        ),
        check_at_most("static_strain", strain, DOUBTED_STRAIN, "-", "largest membrane strain at rest", doubt=True),
    ]  # fmt: skip


def wave_checks(wave: Wave, water: Water, omega_max: float, lowest: float = 0.0) -> list[Check]:
    """Return whether linear wave theory and the solved band, from `lowest` [rad/s] on, cover a sea."""
    if isinstance(wave, StillWater):
        return []
    height = 2 * wave.amplitude if isinstance(wave, RegularWave) else wave.hs
    steepness = height * wavenumber(wave.omega, water.depth, water.gravity) / (2 * np.pi)
    text = "wave height over wavelength"
    checks = [check_at_most("steepness", steepness, 0.05, "-", text, doubt=True, wave=wave.label)]
    if isinstance(wave, IrregularSea):
        share, text = share_above(wave, omega_max), "share of the sea above hydro.omega_max"
        if lowest:
            share += share_below(wave, lowest)
            text = f"share of the sea left out, beyond {lowest:.4g} to {omega_max:.4g} rad/s of the database"
        checks.append(check_at_most("spectrum_cut", share, 0.01, "-", text, doubt=True, wave=wave.label))
    return checks


def run_checks(study: Study, basis: ModeBasis, run: xr.Dataset) -> list[Check]:
    """Return whether a run stays within small motion and closes its energy balance."""
    where = {"design": run.attrs["design"], "wave": run.attrs["wave"]}
    inside = run.sel(time=slice(*study.simulation.window))
    heave = float(np.abs(inside.position.values[:, 0]).max()) / study.device.radius
    checks = [
        energy_check(study, run),
        check_at_most("heave", heave, 0.3, "-", "heave amplitude over radius", doubt=True, **where),
        *drift_checks(study, run),
        *attitude_checks(study, inside),
    ]
    if flexible(run.dof.values):
        moved, strain = deformation(study, basis, inside)
        checks += [
            check_at_most("deformation", moved, 0.1, "-", "shell displacement over radius", doubt=True, **where),
            check_at_most("strain", strain, 0.02, "-", "largest membrane strain", doubt=True, **where),
        ]
    return checks


def deformation(study: Study, basis: ModeBasis, run: xr.Dataset) -> tuple[float, float]:
    """Return the largest displacement of a run's shell over its radius and its largest strain [-]: at one instant."""
    shell = [label for label in run.dof.values if label not in RIGID]
    peaks = run.position.values[np.argmax(np.abs(run.position.sel(dof=shell).values).sum(axis=1))]
    moved, strain = (largest(basis, peaks[: len(basis.labels)]) for largest in (largest_displacement, largest_strain))
    moved, strain = largest_deformation(basis, at, peaks) if (at := order_bases(study, basis)) else (moved, strain)
    return moved / study.device.radius, strain


def transient_checks(runs: Attributes, rows: Sequence[Row]) -> list[Check]:
    """Return by how much mean power in the window differs from the steady state's: what the transient still does."""
    checks = []
    for row in rows:
        attrs, where = runs[row["design"], row["wave"]], {"design": row["design"], "wave": row["wave"]}
        if "no_steady_state" in attrs:
            text = f"no steady state to compare with, the mean depends on the window: {attrs['no_steady_state']}"
            checks.append(Check("transient", 1.0, 0.0, "-", "doubt", text, **where))
        elif "steady_power" in attrs:
            steady, mean = attrs["steady_power"], row["power_mean"]
            text = f"mean power is {mean:.6g} W in the window, {steady:.6g} W in the steady state; "
            if "steady_decay" in attrs:
                text += f"a period leaves {attrs['steady_decay']:.3g} of a transient"
            else:
                text += f"its periods differ by {attrs['steady_unsettled']:.1e}"
            difference = apart(mean, steady)
            checks.append(check_at_most("transient", difference, 0.005, "-", text, doubt=True, **where))
    return checks


def mode_checks(study: Study, rungs: Sequence[Rung]) -> list[Check]:
    """Return by how much shell modes that the basis leaves out may change the mean power, at any damper computed."""
    checks, tolerance = [], study.modes.tolerance
    for wave, design in product(study.waves, study.designs):
        found = [r for r in rungs if (r.design, r.wave) == (design, wave.label) and r.rung in ("fixed", "best_damper")]
        if not study.designs[design].flexible or not found:
            continue
        if not knows_port(study):
            text = f"not estimated for pto.port {study.pto.port}; raise modes.degree and compare"
            checks.append(Check("modes_left_out", 1.0, tolerance, "-", "doubt", text, design, wave.label))
            continue
        shares = [
            max(-source["low"], source["high"]) / rung.power_mean
            for rung in found
            for source in rung.power_error or ()
            if source["name"] == MODES and rung.power_mean
        ]
        text = (
            f"mean power may change with more shell modes than {study.modes.basis} to degree {study.modes.max_degree}"
        )
        where = {"design": design, "wave": wave.label}
        worst = max(shares, default=0.0)
        checks.append(check_at_most("modes_left_out", worst, tolerance, "-", text, doubt=True, **where))
    return checks


def limit_check(frequency: xr.Dataset) -> Check:
    """Return the largest absorbed power over its theoretical limit: above 1 the coefficients cannot be right.

    Nothing over nothing, of a port that no design moves, is nothing.
    """
    taken = frequency.absorbed_power
    share = (taken / frequency.power_limit.where(taken > 0, 1.0)).max()
    text = f"largest absorbed power over the limit of {frequency.attrs.get('limit', HEAVING)}, within mesh error"
    return check_at_most("power_limit", float(share), 1.01, "-", text)


def sea_checks(study: Study, basis: ModeBasis, wave: Wave, runs: Runs) -> list[Check]:
    """Return the checks of every run in a sea, and of what the automatic model left out there."""
    checks = [check for design in study.designs for check in run_checks(study, basis, runs[design])]
    return checks + (simplification_checks(study, wave, runs) if study.hydro.model == "auto" else [])


def simplification_checks(study: Study, wave: Wave, runs: Runs) -> list[Check]:
    """Return what the automatic model left out in a sea, and the error of powers and gains that causes."""
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
    text = "estimated error of the ratio of mean powers to the rigid design's, from what both leave out"
    if (base := errors.pop(study.reference_design or "", None)) is not None:
        for design, error in errors.items():
            checks.append(
                check_at_most("gain_error", error + base, 2 * limit, "-", text, design=design, wave=wave.label)
            )
    return checks


def witness_checks(study: Study, database: xr.Dataset, found: xr.Dataset) -> list[Check]:
    """Return whether a second solver agrees, on all shapes and with the database; in doubt where it cannot be asked."""
    if study.hydro.witness == "none":
        return []
    if reason := no_witness(study):
        return [Check("witness", 1.0, 0.0, "-", "doubt", f"no second solver: {reason}")]
    own = sum(check.value for check in stored_checks(database) if check.name in _OWN_ERRORS)
    return [*witness.witness_checks(found), *witness.database_checks(found, database, own)]


def assumed_pressure_checks(study: Study, rows: Sequence[Row]) -> list[Check]:
    """Return by how much an assumed pressure makes a buoy absorb more than any wave could give it.

    A uniform pressure neither radiates nor knows an energy flux. A wave whose pressure at the surface, rho g a, is as
    large has one, and gives a heaving axisymmetric body at most the flux over wavelength/(2 pi) of crest.
    """
    water = study.water
    amplitude = (study.hydro.pressure or 0.0) / (water.density * water.gravity)
    checks = []
    for wave in (w for w in study.waves if isinstance(w, RegularWave)):
        limit = power_limit(wave.omega, water.depth, water.density, water.gravity) * amplitude**2
        best = max((row for row in rows if row["wave"] == wave.label), key=lambda row: float(row["power_mean"]))
        share = float(best["power_mean"]) / limit if limit else 0.0
        text = f"largest mean power over what a wave of the same surface pressure, {amplitude:.3g} m in amplitude, can "
        text += "give any heaving axisymmetric body: the model has no radiation"
        design = str(best["design"])
        checks.append(check_at_most("assumed_pressure", share, 1.0, "-", text, design=design, wave=wave.label))
    return checks


def worst_first(checks: Sequence[Check]) -> list[Check]:
    """Return checks sorted by verdict, worst news first."""
    return sorted(checks, key=lambda check: ("fail", "accepted", "doubt", "ok").index(check.verdict))


def radiation_checks(radiation: xr.Dataset, tolerance: float) -> list[Check]:
    """Return the error and the passivity certificate of the radiation state space."""
    order, error = radiation.attrs["order"], radiation.attrs["fit_error"]
    band = f"; up to {radiation.attrs['up_to']:.4g} rad/s, no memory follows more" if "up_to" in radiation.attrs else ""
    return [
        check_at_most(
            "radiation_fit", error, tolerance, "-",
            f"rms error of the {order}-state radiation model, each mode relative to its largest damping{band}",
            doubt=True,
        ),
        check_at_most(
            "passivity", max(0.0, -radiation.attrs["passivity_margin"]), 1e-12, "-",
            "most negative eigenvalue of the model's scaled damping over the band; passive by construction",
        ),
    ]  # fmt: skip


def ledger_json(study: str, checks: Sequence[Check], invalid: Sequence[Invalid] = ()) -> str:
    """Return the ledger as JSON text: every check, and which designs are not valid, where and why."""
    lines = {"checks": [asdict(check) for check in checks], "invalid": [line._asdict() for line in invalid]}
    return json.dumps({"study": study, **lines}, indent=1, allow_nan=False) + "\n"
