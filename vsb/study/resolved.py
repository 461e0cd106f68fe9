"""What a study leaves to the size of its buoy: mass by draft, the band; and what is known of its shape."""

import math
from collections.abc import Mapping
from typing import Any

from vsb.engine.motion.take_off import Pto
from vsb.engine.shell.device import Shape, cap_volume
from vsb.engine.shell.material import Hookean
from vsb.engine.waves.water import Water
from vsb.study.sections import Hydro


def check_shape(study: Any) -> None:
    """Check that a study, of `vsb.study.study`, asks of another shape than the sphere what is known of it.

    Raises `ValueError`: one line with the key, what was received and what is needed.
    """
    device, hydro = study.device, study.hydro
    if hydro.model not in ("linear", "body_exact"):
        raise ValueError(
            f"hydro.model {hydro.model!r}: is known of the sphere alone; device.shape needs linear or body_exact"
        )
    if study.motion != "heave":
        raise ValueError(f"motion {study.motion!r}: is known of the sphere alone; device.shape needs heave")
    if study.uses_panels:
        raise ValueError(
            "hydro.solver: panels are those of the sphere; device.shape needs the spectral solver, without hydro.rows "
            "and in water the keel clears"
        )
    if study.flexible and study.modes.basis != "full":
        raise ValueError(
            f"modes.basis {study.modes.basis!r}: modes of another shape than the sphere have no branches; device.shape "
            "needs full"
        )
    if study.flexible and study.modes.degree == 0:
        raise ValueError("modes.degree 0: device.shape needs at least 1")
    if study.reference_shape == "equilibrium" and not isinstance(device.material, Hookean):
        raise ValueError(
            "reference_shape 'equilibrium': wrinkles of rubber are known of the sphere alone; device.shape with a "
            "material of rubber needs undeformed"
        )


HEAVIEST = 1e300
"""Mass [kg] that stands in where the real one cannot be computed."""


BAND = 5.4
"""omega_max over sqrt(g/r): beyond it waves are shorter than a quarter of the radius, and the damping has died out."""


def resolved(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return a study as nested mappings with what it leaves to its size: mass by draft or half immersion, omega_max.

    What is needed for it and wrong, or missing, is left to be found by its own check. Raises `ValueError` if mass and
    draft are both given, or the draft is none of this sphere.
    """
    try:
        radius = _number(raw["device"], "radius", None)
        density, gravity = (_number(raw.get("water", {}), key, getattr(Water(), key)) for key in ("density", "gravity"))
    except (KeyError, TypeError, ValueError, AttributeError):
        return _without_words(raw)
    return {**raw, "device": _with_mass(raw["device"], radius, density), "hydro": _with_band(raw, radius, gravity)}


def _number(section: Any, key: str, default: float | None) -> float:
    """A number above zero of a section, which may be validated already."""
    value = section.get(key, default) if isinstance(section, Mapping) else getattr(section, key)
    if isinstance(value, bool) or not 0 < float(value) < math.inf:
        raise ValueError
    return float(value)


def _with_mass(device: Any, radius: float, density: float) -> Any:
    """The section `device` with its mass."""
    if not isinstance(device, Mapping) or ("mass" in device and "draft" not in device):
        return device
    if "mass" in device:
        raise ValueError("device: received mass and draft, needs one of them")
    if device.get("shape") is not None:
        return _with_mass_of_shape(device, radius, density)
    draft = device.get("draft", radius)
    if isinstance(draft, bool) or not isinstance(draft, int | float) or not 0 < draft < 2 * radius:
        raise ValueError(
            f"device.draft: received {draft!r}, needs more than 0 and less than two radii, {2 * radius:g} m"
        )
    others = {key: value for key, value in device.items() if key != "draft"}
    return {**others, "mass": density * cap_volume(radius, draft / radius)}


def _with_mass_of_shape(device: Mapping[str, Any], radius: float, density: float) -> Any:
    """The same of another shape than the sphere; half immersed is half of its volume."""
    try:
        shape = device["shape"] if isinstance(device["shape"], Shape) else Shape.model_validate(device["shape"])
        rest = shape.meridian(radius)
    except ValueError:
        return {
            "mass": 1.0,
            **{key: value for key, value in device.items() if key != "draft"},
        }  # reported by its check
    draft, height = device.get("draft"), rest.highest - rest.lowest
    if "draft" in device and (isinstance(draft, bool) or not isinstance(draft, int | float) or not 0 < draft < height):
        raise ValueError(f"device.draft: received {draft!r}, needs more than 0 and less than the height, {height:g} m")
    volume = rest.volume / 2 if draft is None else rest.volume_below(rest.lowest + draft)
    return {**{key: value for key, value in device.items() if key != "draft"}, "mass": density * volume}


def _with_band(raw: Mapping[str, Any], radius: float, gravity: float) -> Any:
    """The section `hydro` with its highest frequency."""
    hydro = raw.get("hydro", {})
    omega_max = float(f"{BAND * math.sqrt(gravity / radius):.2g}")
    if isinstance(hydro, Hydro):
        given = "omega_max" in hydro.model_fields_set
        return hydro if given else hydro.model_copy(update={"omega_max": omega_max})
    if not isinstance(hydro, Mapping) or hydro.get("omega_max", "auto") != "auto":
        return hydro
    return {**hydro, "omega_max": omega_max}


def _without_words(raw: Mapping[str, Any]) -> dict[str, Any]:
    """A study without the omega_max that cannot be computed, and with a mass that passes the checks of the device."""
    found, hydro, device = dict(raw), raw.get("hydro"), raw.get("device")
    if isinstance(hydro, Mapping) and hydro.get("omega_max") == "auto":
        found["hydro"] = {key: value for key, value in hydro.items() if key != "omega_max"}
    if isinstance(device, Mapping):
        found["device"] = {"mass": HEAVIEST, **{key: value for key, value in device.items() if key != "draft"}}
    return found


def check_rubber(model: str, method: str, pto: Pto) -> None:
    """Check that the hydrodynamic model, the method in time and the take-off of a study can follow a shell of rubber.

    Raises `ValueError`.
    """
    if model == "assumed_pressure":
        raise ValueError(f"hydro.model {model!r}: knows no rubber; needs linear, body_exact or auto")
    if model == "body_exact" and method != "auto":
        raise ValueError(f"simulation.method {method!r}: cannot follow a shell of rubber; needs auto")
    if model == "body_exact" and pto.nonlinear:
        raise ValueError(
            "device.material: with hydro.model 'body_exact' rubber cannot be followed beside a nonlinear take-off, "
            f"received law {pto.law} with force_limit {pto.force_limit:g} N and stroke_limit {pto.stroke_limit:g} m; "
            "needs law: linear without limits, or hydro.model: linear"
        )
