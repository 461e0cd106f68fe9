"""Doubts in words: checks that fail, the worst of each kind, and what to change first."""

from collections.abc import Mapping, Sequence
from typing import Any

from vsb.tools.words import plain, short

ADVICE = {
    "buckling": "raise device.internal_pressure to carry the load, or device.thickness",
    "computed_buckling": "raise device.internal_pressure to carry the load, or device.thickness",
    "static_deformation": "reference_shape: equilibrium if it is undeformed, or a stiffer shell",
    "static_strain": "a stiffer shell",
    "load_path": "a thicker or stiffer shell",
    "wrinkling": "raise device.internal_pressure until all of the shell is in tension",
    "angles": "angles in degrees",
    "specific_energy": "a thicker shell, or a smaller damper: the material converts less than the waves offer",
    "modes_left_out": "a smaller modes.tolerance or a higher modes.degree, of modes: {basis: full}",
    "ring_width": "rings further apart, by several thicknesses of the wall",
    "reference_power": "longer waves, in which the rigid design absorbs power",
    "fair_damping": "pto.tuning: each, or read the gains at optimal damping",
    "energy_residual": "lower simulation.tolerance",
    "transient": "a later simulation.window",
    "time_and_frequency_domain": "a later simulation.window",
    "heave": "lower waves, or hydro.model: body_exact if it is linear and the buoy heaves alone",
    "deformation": "a stiffer shell, or hydro.model: body_exact if it is linear and the buoy heaves alone",
    "strain": "a stiffer or thicker shell, or lower waves",
    "steepness": "lower or longer waves",
    "linearity": "lower waves, or take the powers of the runs: those of linear theory do not hold here",
    "statistical_error": "more waves.realisations, or a longer simulation.duration",
    "spectral_prediction": "a later simulation.window",
    "record_length": "a longer simulation.duration",
    "spectrum_cut": "raise hydro.omega_max",
    "power_limit": "lower hydro.tolerance",
    "radiation_fit": "lower hydro.tolerance",
    "passivity": "lower hydro.tolerance",
    "witness": "lower hydro.tolerance",
    "constrained": "a shorter simulation.duration, or looser limits",
    "assumed_pressure": "hydro.model: linear, which includes radiation",
    "left_out": "lower hydro.power_tolerance",
    "gain_error": "lower hydro.power_tolerance",
    "controller_margin": "a lower pto.force_limit, or more pto.control.noise",
    "latching_time": "lower waves, or another damping",
    "drag": "use the powers in the time domain, or lower waves",
    "pitch": "lower waves",
    "rotation": "lower waves",
    "translation": "a mooring (body.stiffness), if the body drifts; lower waves",
    "surge": "a mooring",
    "irregular_frequencies": "a lid, or finer panels",
    "resonance": "damping of the enclosed water (body.damping): linear theory has none but radiation",
    "lid": "finer panels, or lid: 0 and frequencies below the first irregular one",
    "closure": "a mesh without the gap",
    "displaced_mass": "the mass, or the vertical position of the mesh",
    "rigid_names": "the labels of the displacements",
    "hinge_gap": "a mesh whose parts are closed at the hinge",
    "second_order": "second_order in the file of the displacements",
    **dict.fromkeys(("panels", "modes", "corners", "one_resolution"), "finer panels"),
    **dict.fromkeys(
        ("error_estimate", "interpolation_error", "symmetry", "far_field", "positive_damping", "rank_one", "haskind",
         "kramers_kronig", "limit_difference", "witness_derivatives", "witness_database"),
        "lower hydro.tolerance, or finer panels",
    ),
    **dict.fromkeys(
        ("phases", "displaced_volume", "parts", "trim", "added_mass_limits", "tilt", "rotation_centre", "waterplane",
         "centre_of_buoyancy", "mass_coupling", "places"),
        "the coefficient file, as the check explains",
    ),
    **dict.fromkeys(
        ("long_waves", "haskind_scale", "haskind_long_waves"), "length, gravity and depth of the coefficient file"
    ),
}  # fmt: skip
"""Name of a check -> what to change first in the study where it fails, if the check itself has tried nothing."""
REASONS = {
    "buckling": "the shell buckles under its static load ({value} times the classical buckling pressure)",
    "computed_buckling": "the shell buckles under its static load ({value} times what it can carry)",
    "static_strain": "the strain at rest is {percent} %, beyond the limit of its material's law (Hooke's: 10 %)",
    "strain": "the strain reaches {percent} %, beyond the limit of its material's law (Hooke's: 10 %)",
    "modes_left_out": "the omitted shell modes change the absorbed power by up to {percent} %",
    "modes": "the panels do not resolve the shortest mode",
    "panels": "the panels do not resolve the shortest waves",
    "energy_residual": "the energy balance of the simulation does not close (residual {value})",
    "power_limit": "a design absorbs {value} times the theoretical limit of any device",
    "assumed_pressure": "the assumed pressure gives a buoy {value} times the power of a wave with that pressure",
}
"""Name of a check that invalidates results (`vsb.engine.hydro.database.INVALIDATING`) -> the reason in words."""


def reasons(invalid: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return why results are not valid, each reason once, with its largest value.

    Parameters
    ----------
    invalid : sequence of dict
        Of `vsb.results.ledger.Invalid`.
    """
    worst: dict[str, float] = {}
    for line in invalid:
        worst[line["name"]] = max(worst.get(line["name"], 0.0), float(line["value"]))
    if "computed_buckling" in worst:
        worst.pop("buckling", None)
    return [REASONS[name].format(value=short(value), percent=plain(100 * value, 2)) for name, value in worst.items()]


def no_answer(invalid: Sequence[Mapping[str, Any]]) -> str:
    """Return why there is no valid answer, and what to change."""
    changes = dict.fromkeys(line.get("advice") or ADVICE[line["name"]] for line in invalid)
    return f"No valid answer yet: {'; '.join(reasons(invalid))}. Change first: {'; '.join(changes)}."


def warnings(checks: Sequence[dict[str, Any]]) -> list[str]:
    """Return the checks that failed, for each name the one furthest beyond its limit; doubts are in the ledger only."""
    found: dict[str, list[dict[str, Any]]] = {}
    for check in checks:
        if check["verdict"] in ("fail", "accepted"):
            found.setdefault(str(check["name"]), []).append(check)
    return [_together(of) for of in found.values()]


def _together(of: Sequence[dict[str, Any]]) -> str:
    """Failures of one name: the worst, the number of others, what to change first."""
    worst = max(of, key=lambda check: float(check["value"]) / (float(check["limit"]) or 1.0))
    others = f"; {len(of) - 1} more fail" if len(of) > 1 else ""
    change = f". Change first: {text}" if (text := advice(worst)) else ""
    return f"{in_words(worst)}{others}{change}"


def in_words(check: dict[str, Any]) -> str:
    """Return a check with its value and limit in words."""
    return f"{_subject(check)}: {short(check['value'])}, limit {short(check['limit'])} ({check['explanation']})"


def advice(check: dict[str, Any]) -> str:
    """Return what to change first if a check does not hold; empty if it holds or no general advice exists."""
    return "" if check["verdict"] == "ok" else check.get("advice") or ADVICE.get(str(check["name"]), "")


def _subject(check: dict[str, Any]) -> str:
    """What a check is about, in words: name, design, sea."""
    of = f" of {check['design']}" if check["design"] else ""
    where = f" in {check['wave']}" if check["wave"] else ""
    return str(check["name"]).replace("_", " ") + of + where
