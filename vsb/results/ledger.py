"""The validity ledger of a study: what to doubt, with a limit and a verdict each, and which designs are not valid.

Checks of runs are in `vsb.results.run_checks`, those of control levels beside the levels.
"""

import json
from collections.abc import Collection, Sequence
from dataclasses import asdict, replace
from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro import witness
from vsb.engine.hydro.database import Check, Verdict, check_at_most, stored_checks
from vsb.engine.motion.tuning import best_dampers
from vsb.engine.shell.deformed import ReferenceShell
from vsb.engine.shell.lobes import LobedShell
from vsb.engine.shell.material import Range
from vsb.engine.shell.orders import largest_displacement
from vsb.engine.shell.rings import HIGHEST
from vsb.engine.shell.shell import Shell
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.water import Water, power_limit, wavenumber
from vsb.keys.meanings import KEYS
from vsb.keys.quantities import leaves
from vsb.models.floating_system import band, expected_sea, floating_system, port_in_seas
from vsb.models.load_advice import advice
from vsb.models.rest import (
    carries_load,
    complete_at_rest,
    complete_loaded_shell,
    computed_buckling,
    loaded_at_ring,
    loaded_shell,
)
from vsb.models.ring_loads import has_attachment_modes, ring_loads
from vsb.models.viability import (
    MOST_LOAD,
    ROUND_OFF,
    rubber_load_factor,
    static_modal_amplitude,
    static_strain,
    wrinkles,
)
from vsb.results.budget import MODES
from vsb.results.comparison import Row
from vsb.results.ladder import ControlLevel
from vsb.results.statistics import batches_in, families
from vsb.study.body import BodyStudy
from vsb.study.resolution import no_witness
from vsb.study.study import FEWEST_BATCHES, BaseStudy, Study
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


def angle_checks(study: BaseStudy) -> list[Check]:
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


def seas_checks(
    study: Study | BodyStudy, database: xr.Dataset | None = None, linear: Collection[str] = ()
) -> list[Check]:
    """Return whether linear wave theory, and the band of the database, cover the seas, and whether records are long.

    The database of a buoy is not needed; `linear` is that of `record_checks`.
    """
    omega_min, omega_max = band(study, database)
    checks = [check for wave in study.waves for check in wave_checks(wave, study.water, omega_max, omega_min)]
    return [*checks, *record_checks(study, linear)]


def record_checks(study: Study | BodyStudy, linear: Collection[str] = ()) -> list[Check]:
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
            return [_path_check(study)]
        return [_lobes_check(study)] if study.device.shape is not None else []
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


def _lobes_check(study: Study) -> Check:
    """Return the static load over that of linear buckling into lobes around the axis."""
    (found,) = LobedShell.of(complete_loaded_shell(study)).buckling(1)
    text = f"static load over the linear buckling load, into a shape of azimuthal order {found.order}"
    return check_at_most("computed_buckling", max(0.0, found.inverse_load_factor), 1.0, "-", text)


def _path_check(study: Study) -> Check:
    """Return the static load over that at which the growing load makes a shell of rubber unstable."""
    factor = rubber_load_factor(complete_loaded_shell(study))
    text = "static load over that at which the growing load buckles the shell or takes it to its limit point"
    if factor >= MOST_LOAD:
        text += f"; it is stable at {MOST_LOAD:g} times its load"
    return check_at_most("load_path", 1 / factor, 1 / RESERVE, "-", text, doubt=True)


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


def limit_check(frequency: xr.Dataset) -> Check:
    """Return the largest absorbed power over its theoretical limit: above 1 the coefficients cannot be right."""
    absorbed = frequency.absorbed_power
    share = (absorbed / frequency.power_limit.where(absorbed > 0, 1.0)).max()  # 0/0 of a port that no design moves is 0
    text = f"largest absorbed power over the limit of {frequency.attrs.get('limit', HEAVING)}, within mesh error"
    return check_at_most("power_limit", float(share), 1.01, "-", text)


def witness_checks(study: Study, database: xr.Dataset, found: xr.Dataset) -> list[Check]:
    """Return whether a second solver agrees, on all shapes and with the database; a doubt where it cannot be used."""
    if study.hydro.witness == "none":
        return []
    if reason := no_witness(study):
        return [Check("witness", 1.0, 0.0, "-", "doubt", f"no second solver: {reason}")]
    estimates = ("error_estimate", "interpolation_error")
    own = sum(check.value for check in stored_checks(database) if check.name in estimates)
    return [*witness.witness_checks(found), *witness.database_checks(found, database, own)]


def mode_checks(study: Study, levels: Sequence[ControlLevel]) -> list[Check]:
    """Return by how much shell modes that the basis leaves out may change the mean power, at any damper computed."""
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
    if study.pto.several or not seas or not has_attachment_modes(study) or not ring_loads(study):
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


def flexible_designs(study: BaseStudy) -> list[str]:
    """Return the designs that are not rigid."""
    return [name for name, design in study.designs.items() if design.flexible]


def invalid_designs(study: BaseStudy, checks: Sequence[Check]) -> list[Invalid]:
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
