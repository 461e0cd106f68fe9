"""A buoy afloat: the part of it under water, its mass by its draft, the band of waves it answers. Pure Python."""

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from vsb.study.device import Device
from vsb.study.sections import Hydro, Water
from vsb.study.shape import Shape


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
    """Return the height of the centre above still water at rest [m], from mass = rho V(immersed part).

    The centre of another shape than the sphere is the middle of its height.
    """
    if device.shape is not None:
        return _shape_height(device.shape, device.radius, device.mass / water.density)
    return floating_height(device.radius, device.mass / water.density)


@lru_cache(maxsize=64)
def _shape_height(shape: Shape, radius: float, volume: float) -> float:
    """The same of another shape than the sphere."""
    meridian = shape.meridian(radius)
    return -(meridian.lowest + meridian.draft_of(volume))


def full_volume(device: Device) -> float:
    """Return the volume of a buoy [m^3]."""
    return 4 / 3 * math.pi * device.radius**3 if (rest := device.meridian) is None else rest.volume


def volume_to(device: Device, part: float) -> float:
    """Return the volume of a buoy below a part of its height, 0 to 2 in halves of it [m^3]."""
    if (rest := device.meridian) is None:
        return cap_volume(device.radius, part)
    return rest.volume_below(rest.lowest + part / 2 * (rest.highest - rest.lowest))


def keel_depth(device: Device, centre: float) -> float:
    """Return the draft of a buoy by the height of its centre above still water [m]."""
    return (device.radius if (rest := device.meridian) is None else -rest.lowest) - centre


@lru_cache(maxsize=64)
def waterline_radius(shape: Shape | None, radius: float, centre: float) -> float:
    """Return the radius of the undeformed buoy at still water, its centre at a height above it [m]."""
    if shape is None:
        return math.sqrt(radius**2 - centre**2)
    return shape.meridian(radius).radius_at(-centre)


HEAVIEST = 1e300
"""Mass [kg] of a buoy whose own cannot be told."""
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
        return {"mass": 1.0, **{key: value for key, value in device.items() if key != "draft"}}  # its own check tells
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
    """A study without an omega_max that cannot be told, and with a mass no check of its device's finds too small."""
    found, hydro, device = dict(raw), raw.get("hydro"), raw.get("device")
    if isinstance(hydro, Mapping) and hydro.get("omega_max") == "auto":
        found["hydro"] = {key: value for key, value in hydro.items() if key != "omega_max"}
    if isinstance(device, Mapping):
        found["device"] = {"mass": HEAVIEST, **{key: value for key, value in device.items() if key != "draft"}}
    return found
