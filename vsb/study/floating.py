"""A sphere afloat: the cap of it under water, its mass by its draft, the band of waves it answers. Pure Python."""

import math
from collections.abc import Mapping
from typing import Any

from vsb.study.device import Device
from vsb.study.sections import Hydro, Water


def cap_volume(radius: float, height: float) -> float:
    """Return the volume of a spherical cap, pi h^2 (3r - h)/3, its height in radii [m^3]."""
    return math.pi * height**2 * (3 - height) / 3 * radius**3


def floating_height(radius: float, volume: float) -> float:
    """Return the height of the centre at which the immersed cap, pi h^2 (3r - h)/3, has the given volume."""
    low, high = 0.0, 2 * radius
    while high - low > 1e-15 * radius:
        h = 0.5 * (low + high)
        if h in (low, high):
            break
        low, high = (h, high) if math.pi * h * h * (3 * radius - h) / 3 < volume else (low, h)
    return radius - 0.5 * (low + high)


def centre_height(device: Device, water: Water) -> float:
    """Return the height of the sphere's centre above still water at rest [m], from mass = rho V(immersed cap)."""
    return floating_height(device.radius, device.mass / water.density)


BAND = 5.4
"""omega_max over sqrt(g/r): beyond it waves are shorter than a quarter of the radius, and the damping has died out."""


def resolved(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return a study as nested mappings with what it leaves to its size: mass by draft or half immersion, omega_max.

    What is needed for it and wrong, or missing, is left to be found by its own check.

    Raises
    ------
    ValueError
        If mass and draft are both given, or the draft is none of this sphere.
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
    draft = device.get("draft", radius)
    if isinstance(draft, bool) or not isinstance(draft, int | float) or not 0 < draft < 2 * radius:
        raise ValueError(
            f"device.draft: received {draft!r}, needs more than 0 and less than two radii, {2 * radius:g} m"
        )
    others = {key: value for key, value in device.items() if key != "draft"}
    return {**others, "mass": density * cap_volume(radius, draft / radius)}


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
    """A study without an omega_max that cannot be told."""
    hydro = raw.get("hydro")
    if isinstance(hydro, Mapping) and hydro.get("omega_max") == "auto":
        hydro = {key: value for key, value in hydro.items() if key != "omega_max"}
    return {**raw, "hydro": hydro} if "hydro" in raw else dict(raw)
