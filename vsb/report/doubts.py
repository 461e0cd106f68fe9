"""What to doubt, for the head of a page: what fails, the worst of its kind, and what to change first."""

from collections.abc import Sequence
from typing import Any

from vsb.tools.words import short

ADVICE = {
    "buckling": "raise device.internal_pressure to carry the load, or device.thickness",
    "computed_buckling": "raise device.internal_pressure to carry the load, or device.thickness",
    "static_deformation": "reference_shape: equilibrium if it is undeformed, or a stiffer shell",
    "static_strain": "a stiffer shell",
    "bending_modes": "modes.basis: full",
    "reference_power": "longer waves, in which the rigid design absorbs",
    "fair_damping": "pto.tuning: each, or read the gains at own best dampers",
    "energy_residual": "lower simulation.tolerance",
    "transient": "a later simulation.window",
    "time_and_frequency_domain": "a later simulation.window, or hydro.model: body_exact",
    "heave": "hydro.model: body_exact, or lower waves",
    "deformation": "hydro.model: body_exact, or a stiffer shell",
    "strain": "a stiffer or thicker shell, or lower waves",
    "steepness": "lower or longer waves",
    "linearity": "hydro.model: body_exact",
    "statistical_error": "more waves.realisations, or a longer simulation.duration",
    "spectral_prediction": "more waves.realisations, or a longer simulation.duration",
    "record_length": "a longer simulation.duration",
    "spectrum_cut": "raise hydro.omega_max",
    "power_limit": "lower hydro.tolerance",
    "radiation_fit": "lower hydro.tolerance",
    "passivity": "lower hydro.tolerance",
    "witness": "lower hydro.tolerance",
    "constrained": "a shorter simulation.duration, or looser limits",
    "assumed_pressure": "hydro.model: linear, in which waves radiate",
    "left_out": "lower hydro.power_tolerance",
    "gain_error": "lower hydro.power_tolerance",
    "pause": "lower waves, or another damper",
    "drag": "read the powers in time, or lower waves",
    "pitch": "lower waves",
    "rotation": "lower waves",
    "translation": "lower waves",
    "surge": "a mooring",
    "irregular_frequencies": "a lid, or finer panels",
    "afloat": "the mass, or how deep the mesh lies",
    "rigid_names": "the names of the displacements",
    "hinge_gap": "second_order of the displacements, or a body of two closed parts",
    "second_order": "second_order of the displacements",
    **dict.fromkeys(("panels", "modes", "corners", "one_resolution"), "finer panels"),
    **dict.fromkeys(
        ("error_estimate", "interpolation_error", "symmetry", "far_field", "positive_damping", "rank_one", "haskind",
         "kramers_kronig", "limit_difference", "witness_derivatives", "witness_database"),
        "finer coefficients: lower hydro.tolerance, or finer panels",
    ),
    **dict.fromkeys(
        ("long_waves", "haskind_scale", "haskind_long_waves"), "length, gravity and depth of the file that was read"
    ),
}  # fmt: skip
"""Name of a check -> what to change first in the study where it does not hold."""


def warnings(checks: Sequence[dict[str, Any]]) -> list[str]:
    """Return the checks that failed, by name the one furthest beyond its limit; doubts are left to the ledger."""
    found: dict[str, list[dict[str, Any]]] = {}
    for check in checks:
        if check["verdict"] in ("fail", "accepted"):
            found.setdefault(str(check["name"]), []).append(check)
    return [_together(of) for of in found.values()]


def _together(of: Sequence[dict[str, Any]]) -> str:
    """Failures of one name in words: the worst, how many others, what to change first."""
    worst = max(of, key=lambda check: float(check["value"]) / (float(check["limit"]) or 1.0))
    others = f"; so in {len(of) - 1} more" if len(of) > 1 else ""
    change = f". Change first: {text}" if (text := advice(worst)) else ""
    return f"{in_words(worst)}{others}{change}"


def in_words(check: dict[str, Any]) -> str:
    """Return a check with its value and limit in words."""
    return f"{_subject(check)}: {short(check['value'])}, limit {short(check['limit'])} ({check['explanation']})"


def advice(check: dict[str, Any]) -> str:
    """Return what to change first where a check does not hold; empty if it holds or nothing general can be said."""
    return "" if check["verdict"] == "ok" else ADVICE.get(str(check["name"]), "")


def _subject(check: dict[str, Any]) -> str:
    """What a check is about, in words: name, design, sea."""
    of = f" of {check['design']}" if check["design"] else ""
    where = f" in {check['wave']}" if check["wave"] else ""
    return str(check["name"]).replace("_", " ") + of + where
