"""The validity ledger of a study: what to doubt, with a limit and a verdict each, and which designs are not valid.

Checks of control levels stand beside the levels.
"""

import json
from collections.abc import Collection, Sequence
from dataclasses import asdict, replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro import witness
from vsb.engine.hydro.database import Check, Verdict, check_at_most, stored_checks
from vsb.engine.hydro.dofs import flexible
from vsb.engine.hydro.formats.common import volume_of
from vsb.engine.hydro.variables import RIGID, ROTATIONS, body_of, is_of_ring, motion_of
from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import CONVOLVED
from vsb.engine.motion.tuning import best_dampers
from vsb.engine.shell.deformed import ReferenceShell
from vsb.engine.shell.lobes import LobedShell
from vsb.engine.shell.material import Range
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.shell.orders import largest_deformation, largest_displacement, largest_strain
from vsb.engine.shell.rings import HIGHEST
from vsb.engine.shell.shell import Shell
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.water import Water, power_limit, wavenumber
from vsb.keys.meanings import KEYS
from vsb.keys.quantities import leaves
from vsb.models.floating_system import band, expected_sea, floating_system, port_in_seas
from vsb.models.rest import (
    carries_load,
    complete_at_rest,
    complete_loaded_shell,
    computed_buckling,
    has_attachment_modes,
    loaded_shell,
    order_bases,
    reference_shell,
    ring_loads,
)
from vsb.models.take_off import DAMPERS, LINEARISED
from vsb.models.viability import (
    MOST_LOAD,
    ROUND_OFF,
    advice,
    rubber_load_factor,
    static_modal_amplitude,
    static_strain,
    wrinkles,
)
from vsb.results.budget import MODES
from vsb.results.comparison import Attributes, Row, Runs, linear_mean, relative_difference
from vsb.results.ladder import ControlLevel
from vsb.results.statistics import batches_in, families
from vsb.study.resolution import loaded_at_ring, no_witness
from vsb.study.sections import POWER_TOLERANCE
from vsb.study.study import FEWEST_BATCHES, Study
from vsb.tools.variables import FORCE, MOMENT
from vsb.tools.words import plain

HEAVING = "an axisymmetric heaving body"
DEGREES = {name for keys in KEYS.values() for name, key in keys.items() if key.unit == "degrees"}
"""Last words of the keys that are angles."""
RESERVE = 1.5
"""Factor of its load a shell of rubber should bear: thickness and modulus are known to some ten per cent."""
OF_LOAD = ("buckling", "computed_buckling", "static_strain", "wrinkling")
"""Checks of what the static load does to a shell: what one pressure, wall or modulus mends, all are to hold with."""
RING_WIDTH = 0.01
"""Change of a power by the width of rings that is worth a doubt."""
LIKE_RADIANS = 4e-3
"""How near to a multiple of pi/12 an angle looks like radians: 1.57 and 6.28 do."""


# before anything is solved ------------------------------------------------------------------------------------------


def angle_checks(study: Study) -> list[Check]:
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


def seas_checks(study: Study, database: xr.Dataset | None = None, linear: Collection[str] = ()) -> list[Check]:
    """Return whether linear wave theory, and the band of the database, cover the seas, and whether records are long.

    The database of a buoy is not needed; `linear` is that of `record_checks`.
    """
    omega_min, omega_max = band(study, database)
    checks = [check for wave in study.waves for check in wave_checks(wave, study.water, omega_max, omega_min)]
    return [*checks, *record_checks(study, linear)]


def record_checks(study: Study, linear: Collection[str] = ()) -> list[Check]:
    """Return whether the records of each irregular sea are long enough for an interval of its mean power.

    Where hydrodynamics and take-off are linear mean power is the expectation over the spectrum, whatever the record;
    `linear` names the seas in which the runs turned out to be, as limits were out of reach.
    """
    (start, end), checks = study.simulation.window, []
    for name, waves in families(study).items():
        if study.power_of_spectrum or name in linear:
            whole = "the whole record" if waves[0].recorded else "the spectrum"
            text = f"mean power follows from {whole}, whatever the {end - start:.4g} s simulated; their mean may differ"
            checks.append(check_at_most("record_length", 0.0, 1.0, "-", text, doubt=True, wave=name))
            continue
        batches = len(waves) * batches_in(end - start, waves[0].memory)
        text = f"batches that an interval of mean power needs, {FEWEST_BATCHES}, over those of the records, {batches}, "
        text += (
            f"each of {waves[0].memory:.4g} s or more: with fewer the interval is as wide as the record is untypical"
        )
        checks.append(check_at_most("record_length", FEWEST_BATCHES / batches, 1.0, "-", text, doubt=True, wave=name))
    return checks


def wave_checks(wave: Wave, water: Water, omega_max: float, omega_min: float = 0.0) -> list[Check]:
    """Return the steepness of a sea, and the share of an irregular one outside a band [rad/s]."""
    if wave.still:
        return []
    steepness = wave.height * wavenumber(wave.omega, water.depth, water.gravity) / (2 * np.pi)
    text = "wave height over wavelength"
    checks = [check_at_most("steepness", steepness, 0.05, "-", text, doubt=True, wave=wave.label)]
    if wave.irregular:
        share, text = wave.share_above(omega_max), "share of the sea above hydro.omega_max"
        if omega_min:
            share += wave.share_below(omega_min)
            text = f"share of the sea left out, beyond {omega_min:.4g} to {omega_max:.4g} rad/s of the database"
        checks.append(check_at_most("spectrum_cut", share, 0.01, "-", text, doubt=True, wave=wave.label))
    return checks


# the shell at rest --------------------------------------------------------------------------------------------------


def shell_checks(study: Study, reference: ReferenceShell) -> list[Check]:
    """Return what the static load does to a flexible shell: buckling by two criteria, deformation, strain, wrinkles."""
    if not study.flexible:
        return []
    viability = viability_checks(study)
    checks = [*viability, *static_checks(study, reference)]
    if reference.basis.shell.rubber and study.at_equilibrium:
        checks.append(wrinkling_check(study))
    elif study.device.shape is None:
        classical, carried = classical_check(study, reference), all(check.verdict != "fail" for check in viability)
        checks = [classical, *checks] if classical.verdict == "ok" or not carried else checks
    failed = [check.name in OF_LOAD and check.verdict == "fail" for check in checks]
    tried = advice(study) if any(failed) else ""
    return [replace(check, advice=tried) if fails else check for check, fails in zip(checks, failed, strict=True)]


def classical_check(study: Study, reference: ReferenceShell) -> Check:
    """Return the classical criterion of buckling under uniform pressure.

    A shell with internal pressure hangs in the water and is pressed at its keel alone, which the criterion ignores: it
    says nothing of a shell that is computed to carry its own load.
    """
    shell, water = Shell.of(study.device), study.water
    keel = max(0.0, water.density * water.gravity * reference.keel_depth - pressure_at_rest(study, reference))
    classical = shell.buckling_pressure
    text = f"net pressure at the keel {plain(keel)} Pa over the classical buckling pressure {plain(classical)} Pa"
    text += ": above 1 the shell would buckle and the design is not viable"
    return check_at_most("buckling", keel / classical, 1.0, "-", text)


def pressure_at_rest(study: Study, reference: ReferenceShell) -> float:
    """Return the gauge pressure inside a shell at rest [Pa]: that of trapped gas falls as the shell expands."""
    loaded = loaded_shell(study, reference.basis)
    return loaded.pressure(reference.modal_amplitude) if study.at_equilibrium else loaded.pressure_inside


def viability_checks(study: Study) -> list[Check]:
    """Return the static load over the linear buckling load.

    With internal pressure linear buckling is advice: a shell that comes to a stable rest shape along the nonlinear
    path of the growing load carries it, and the check is a doubt at most. About the equilibrium there is nothing to
    add of a sphere: a shell that buckles on that path is refused there. How near rubber is to the end of that path is
    reported. Of other shapes the path is axisymmetric, so lobes around the axis are judged by linear theory everywhere.
    """
    if study.at_equilibrium:
        if Shell.of(study.device).rubber:
            factor = rubber_load_factor(complete_loaded_shell(study))
            text = "static load over that at which the growing load buckles the shell or takes it to its limit point"
            if factor >= MOST_LOAD:
                text += f"; it is stable at {MOST_LOAD:g} times its load"
            return [check_at_most("load_path", 1 / factor, 1 / RESERVE, "-", text, doubt=True)]
        if study.device.shape is None:
            return []
        (lobes,) = LobedShell.of(complete_loaded_shell(study)).buckling(1)
        text = f"static load over the linear buckling load, into a shape of azimuthal order {lobes.order}"
        return [check_at_most("computed_buckling", max(0.0, lobes.inverse_load_factor), 1.0, "-", text)]
    found = computed_buckling(study)
    into = f"azimuthal order {found.order}" if found.order else f"degree {found.degree}"
    text = f"static load over the linear buckling load, into a shape of {into}"
    pressed = study.device.internal_pressure > 0 and not found.order
    carried = found.load_factor < 1.0 and pressed and carries_load(study)
    if carried:
        text += "; advice only: along the nonlinear path of the growing load the shell comes to a stable rest shape, "
        text += "which reference_shape: equilibrium computes"
    check = check_at_most("computed_buckling", 1 / found.load_factor, 1.0, "-", text)
    return [replace(check, verdict="doubt") if carried else check]


def wrinkling_check(study: Study) -> Check:
    """Return whether a membrane force of the shell at rest is compressive, and whether that folds it into wrinkles.

    Compression that bending holds is a doubt; the check fails if a shape of azimuthal orders to `ORDERS` is unstable.
    """
    found = wrinkles(*complete_at_rest(study))
    text = f"compressive membrane force at rest, {plain(found.force)} N/m, over the largest tension"
    verdict: Verdict = "ok" if not found.compressed else "doubt" if found.stiffness > 0 else "fail"
    if verdict == "doubt":
        text += f": bending holds it, shapes of azimuthal order {found.order} keep {found.stiffness:.2g} of their "
        text += "stiffness"
    elif verdict == "fail":
        text += f": the shell wrinkles into azimuthal order {found.order}"
    return Check("wrinkling", found.share, ROUND_OFF, "-", verdict, text)


def static_checks(study: Study, reference: ReferenceShell) -> list[Check]:
    """Return displacement and strain of the shell at rest, about which motion is linearised or which is left out."""
    basis, static = reference.basis, static_modal_amplitude(study, reference)
    left_out = "" if study.at_equilibrium else "; the reference shape is undeformed"
    shell = basis.shell
    limit, holds = (0.5 if shell.rubber else 0.2) if study.at_equilibrium else 0.05, shell.law.range
    moved, strain = largest_displacement(basis, static) / shell.radius, static_strain(basis, static)
    text = f"static displacement of the shell over its radius{left_out}"
    return [
        check_at_most("static_deformation", moved, limit, "-", text, doubt=True),
        strain_check("static_strain", strain, holds, " at rest"),
    ]


def strain_check(name: str, strain: float, holds: Range, when: str = "", **where: str) -> Check:
    """Return whether a strain, as the law of the material measures it, is within the range of that law."""
    verdict: Verdict = "fail" if holds.is_invalid(strain) else "doubt" if holds.is_doubted(strain) else "ok"
    return Check(name, strain, holds.doubted, "-", verdict, f"{holds.measure}{when}", **where)


# coefficients and linear theory -------------------------------------------------------------------------------------


def radiation_checks(radiation: xr.Dataset, tolerance: float) -> list[Check]:
    """Return the error and the passivity certificate of the radiation state space."""
    order, error = radiation.attrs["order"], radiation.attrs["fit_error"]
    text = f"rms error of the {order}-state radiation model, each mode relative to its largest damping"
    if "up_to" in radiation.attrs:
        text += f"; up to {radiation.attrs['up_to']:.4g} rad/s, no memory follows more"
    passive = "most negative eigenvalue of the model's scaled damping over the band; passive by construction"
    negative = max(0.0, -radiation.attrs["passivity_margin"])
    return [
        check_at_most("radiation_fit", error, tolerance, "-", text, doubt=True),
        check_at_most("passivity", negative, 1e-12, "-", passive),
    ]


def limit_checks(study: Study, frequency: xr.Dataset) -> list[Check]:
    """Return the largest absorbed power over its limit, if one is known: above 1 the coefficients cannot be right."""
    if not study.LIMIT:
        return []
    absorbed = frequency.absorbed_power
    share = (absorbed / frequency.power_limit.where(absorbed > 0, 1.0)).max()  # 0/0 of a port that no design moves is 0
    text = f"largest absorbed power over the limit of {frequency.attrs.get('limit', HEAVING)}, within mesh error"
    return [check_at_most("power_limit", float(share), 1.01, "-", text)]


def witness_checks(study: Study, database: xr.Dataset, found: xr.Dataset) -> list[Check]:
    """Return whether a second solver agrees, on all shapes and with the database; a doubt where it cannot be used."""
    if study.KIND == "body" or study.hydro.witness == "none":
        return []
    if reason := no_witness(study):
        return [Check("witness", 1.0, 0.0, "-", "doubt", f"no second solver: {reason}")]
    estimates = ("error_estimate", "interpolation_error")
    own = sum(check.value for check in stored_checks(database) if check.name in estimates)
    return [*witness.witness_checks(found), *witness.database_checks(found, database, own)]


def mode_checks(study: Study, levels: Sequence[ControlLevel]) -> list[Check]:
    """Return by how much shell modes that the basis leaves out may change the mean power, at any damper computed."""
    if not study.has_shell:
        return []
    checks, tolerance = [], study.modes.tolerance
    for wave, design in product(study.waves, study.designs):
        found = [r for r in levels if (r.design, r.wave) == (design, wave.label) and r.rung in ("fixed", "best_damper")]
        if not study.designs[design].flexible or not found:
            continue
        shares = [
            max(-source["low"], source["high"]) / level.power_mean
            for level in found
            for source in level.power_error or ()
            if source["name"] == MODES and level.power_mean
        ]
        modes = f"{study.modes.basis} to degree {study.modes.max_degree}"
        text = f"relative change of mean power by shell modes left out, beyond {modes}"
        where = {"design": design, "wave": wave.label}
        worst = max(shares, default=0.0)
        checks.append(check_at_most("modes_left_out", worst, tolerance, "-", text, doubt=True, **where))
    return checks


def ring_width_checks(study: Study, database: str) -> list[Check]:
    """Return by how much rings as wide as the wall is thick, in place of lines, may change the mean power.

    Such rings feel degrees of the shell up to about r/h. Of each design that is loaded at a ring, at its optimal
    damping, the largest change in a sea.

    Parameters
    ----------
    database : str
        Path of the hydro database.
    """
    seas = [wave for wave in study.waves if not wave.still]
    if not study.has_shell or study.pto.several or not seas or not has_attachment_modes(study) or not ring_loads(study):
        return []
    shell, checks = Shell.of(study.device), []
    widths = HIGHEST, int(shell.reach / shell.thickness)
    line, wide = (floating_system(study, database, highest) for highest in widths)
    pairs = [(wave, expected_sea(study, wave, line.linear.database)) for wave in seas]
    for design in study.designs:
        if not (study.designs[design].flexible and loaded_at_ring(study, design)):
            continue
        powers = []
        for floating in (line, wide):
            port, squares, _ = port_in_seas(floating, design, pairs)
            powers.append(best_dampers(port, squares, study.pto.stiffness, study.pto.efficiency).power)
        change = np.abs(np.divide(powers[1], powers[0], out=np.ones_like(powers[0]), where=powers[0] > 0) - 1).max()
        text = "change of mean power if a ring is as wide as the wall is thick: clamps, held rings and ports are lines"
        checks.append(check_at_most("ring_width", change, RING_WIDTH, "-", text, doubt=True, design=design))
    return checks


def assumed_pressure_checks(study: Study, rows: Sequence[Row]) -> list[Check]:
    """Return by how much an assumed pressure makes a buoy absorb more than any wave could give it.

    A uniform pressure neither radiates nor has an energy flux. A wave whose pressure at the surface, rho g a, is as
    large has one, and gives a heaving axisymmetric body at most the flux over wavelength/(2 pi) of crest.
    """
    water = study.water
    amplitude = (study.hydro.pressure or 0.0) / (water.density * water.gravity)
    checks = []
    for wave in (w for w in study.waves if w.regular):
        limit = power_limit(wave.omega, water.depth, water.density, water.gravity) * amplitude**2
        best = max((row for row in rows if row["wave"] == wave.label), key=lambda row: float(row["power_mean"]))
        share = float(best["power_mean"]) / limit if limit else 0.0
        text = f"largest mean power over what a wave of the same surface pressure, {amplitude:.3g} m in amplitude, can "
        text += "give any heaving axisymmetric body: the model has no radiation"
        design = str(best["design"])
        checks.append(check_at_most("assumed_pressure", share, 1.0, "-", text, design=design, wave=wave.label))
    return checks


# verdicts -----------------------------------------------------------------------------------------------------------


class Invalid(NamedTuple):
    """A check by which a design is not valid in a sea, all realisations together."""

    design: str
    sea: str
    name: str  # of the check
    value: float
    limit: float
    advice: str = ""  # of the check


def flexible_designs(study: Study) -> list[str]:
    """Return the designs that are not rigid."""
    return [name for name, design in study.designs.items() if design.flexible]


def invalid_designs(study: Study, checks: Sequence[Check]) -> list[Invalid]:
    """Return why designs are not valid: a line for each design, sea and check that invalidates.

    A check that names no design invalidates all it may (`vsb.engine.hydro.database.INVALIDATING`), one without a sea
    all seas; of several realisations the worst is kept.
    """
    families = {wave.label: wave.family for wave in study.waves}
    found: dict[tuple[str, str, str], Invalid] = {}
    for check in checks:
        if (whose := check.invalidates) is None:
            continue
        name = check.name.removeprefix("hydro ")
        designs = [check.design] if check.design else list(study.designs) if whose == "all" else flexible_designs(study)
        seas = [families[check.wave]] if check.wave else list(dict.fromkeys(families.values()))
        for design, sea in product(designs, seas):
            line = Invalid(design, sea, name, check.value, check.limit, check.advice)
            before = found.get((design, sea, name), line)
            found[design, sea, name] = max(before, line, key=lambda one: one.value)
    return list(found.values())


def worst_first(checks: Sequence[Check]) -> list[Check]:
    """Return checks sorted by verdict, worst news first."""
    return sorted(checks, key=lambda check: ("fail", "accepted", "doubt", "ok").index(check.verdict))


def ledger_json(study: str, checks: Sequence[Check], invalid: Sequence[Invalid] = ()) -> str:
    """Return the ledger as JSON text: every check, and which designs are not valid, where and why."""
    lines = {"checks": [asdict(check) for check in checks], "invalid": [line._asdict() for line in invalid]}
    return json.dumps({"study": study, **lines}, indent=1, allow_nan=False) + "\n"


# runs of a buoy or a body: energy, small motion, steady state, agreement with linear theory -------------------------

ROTATION, TRANSLATION = 0.2, 0.3
"""Rotation of a body [rad], and translation over the cube root of the displaced volume, beyond which there is doubt."""
LEAST_MARGIN = 0.1
"""Distance of an open loop from -1 (Nyquist) below which its port must be known better than it is."""
NEAR_THE_END = 0.8
"""Part of the range of latching times searched, beyond which the best one may lie outside it."""


def sea_checks(
    study: Study, wave: Wave, runs: Runs, basis: ModeBasis | None = None, database: xr.Dataset | None = None
) -> list[Check]:
    """Return the checks of all runs in a sea: energy, small motion, slip at clamps, what model `auto` leaves out.

    Parameters
    ----------
    runs : mapping design -> trajectory in this sea
    basis : ModeBasis, optional
        Axisymmetric shell modes, of flexible buoys.
    database : xarray.Dataset, optional
        Of a study of a body.
    """
    checks = []
    for design in study.designs:
        run = runs[design]
        energy = energy_check(study.simulation, run.attrs["energy_residual"])
        checks.append(replace(energy, design=design, wave=wave.label))
        if study.KIND == "buoy":
            checks += buoy_motion_checks(study, basis, wave, run)
        else:
            assert database is not None
            checks += body_motion_checks(study, database, run)
        if "constraint_drift" in run.attrs:
            linear = "over 10 000 wave periods" if study.needs_bem and wave.label != "still" else "over the run"
            text, drift = f"largest slip of the shell at its clamps {linear}", run.attrs["constraint_drift"]
            checks.append(check_at_most("constraint_drift", drift, 1e-9, "m", text, design=design, wave=wave.label))
    if study.hydro.model == "auto":
        checks += simplification_checks(study, wave, runs)
    return checks


def energy_check(settings: Simulation, residual: float) -> Check:
    """Return whether the energy residual of a run is what its integration method promises."""
    closed = max(settings.tolerance, CONVOLVED if settings.method == "convolution" else 1e-6)
    text = "unbalanced energy over the largest term"
    return check_at_most("energy_residual", residual, closed, "-", text, doubt=True)


def buoy_motion_checks(study: Study, basis: ModeBasis | None, wave: Wave, run: xr.Dataset) -> list[Check]:
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
        assert basis is not None
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


def body_motion_checks(study: Study, database: xr.Dataset, run: xr.Dataset) -> list[Check]:
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


def law_checks(runs: Attributes) -> list[Check]:
    """Return the margin of each controller, and where each body-exact latching time lies in the range searched."""
    checks = []
    for (design, wave), attrs in runs.items():
        if "controller_margin" in attrs:
            margin = attrs["controller_margin"]
            text = f"margin of a controller of {attrs['controller_states']} states, distance of its open loop from -1 "
            text += f"(Nyquist): {margin:.3g}; by linear theory without a force limit it absorbs "
            text += f"{attrs['controller_power']:.4g} W with an rms force of {attrs['controller_force_rms']:.4g}, as a "
            text += f"filter {attrs['controller_error']:.1e} from the optimum"
            share, where = LEAST_MARGIN / margin, {"design": design, "wave": wave}
            checks.append(check_at_most("controller_margin", share, 1.0, "-", text, doubt=True, **where))
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


def agreement_checks(study: Study, frequency: xr.Dataset, rows: Sequence[Row], runs: Attributes) -> list[Check]:
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


def _dampers_in_words(study: Study, run: Any) -> str:
    """Equivalent dampers of a run's drag; of several directions each with its name."""
    names = [name.lower() if study.KIND == "buoy" else name for name in study.plates] or ["heave"]
    values = [plain(float(damper)) for damper in np.atleast_1d(run[DAMPERS])]
    if names == ["heave"]:
        return f"{values[0]} {FORCE.damping_unit}"
    units = ((MOMENT if name.rpartition("__")[2].capitalize() in ROTATIONS else FORCE).damping_unit for name in names)
    return " and ".join(f"{c} {unit} of {name}" for c, unit, name in zip(values, units, names, strict=True))
