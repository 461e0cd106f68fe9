"""Froude's scaling of a study: the same buoy of another size, in the same water and gravity."""

from typing import Any

FROUDE = {
    "radius": 1.0, "thickness": 1.0, "young_modulus": 1.0, "mass": 3.0, "internal_pressure": 1.0, "alpha": -0.5,
    "beta": 0.5, "omega_max": -0.5, "omega": -0.5, "pressure": 1.0, "damping": 2.5, "stiffness": 2.0,
    "force_limit": 3.0, "stroke_limit": 1.0, "amplitude": 1.0, "period": 0.5, "duration": 0.5, "window": 0.5,
    "initial_position": 1.0, "initial_velocity": 0.5, "area": 2.0, "lever": 1.0,
    "centre_of_mass": 1.0, "ballast_inertia": 5.0, "ballast_yaw_inertia": 5.0, "line_to": 1.0, "line_from": 1.0,
    "height": 1.0, "length": 1.0,
}  # fmt: skip
"""Power of the length scale each quantity goes with, at the same water and gravity."""
STROKES = {"volume": 3.0, "pitch": 0.0}
"""That of what a take-off's port moves by, where it is no length."""


def scaled(raw: Any, scale: float, power: float = 0.0) -> Any:
    """Return a study, given as nested mappings, with every quantity scaled by Froude.

    Parameters
    ----------
    raw : mapping, sequence or value
    scale : float
        Of lengths; times go with its root.
    power : float
        With which values go that stand under no key of `FROUDE` of their own, as the dampers of designs by name.
    """
    if isinstance(raw, dict):
        return {
            key: SECTIONS[key](value, scale) if key in SECTIONS else scaled(value, scale, FROUDE.get(key, power))
            for key, value in raw.items()
        }
    if isinstance(raw, list | tuple):
        return [scaled(value, scale, power) for value in raw]
    if isinstance(raw, bool) or not isinstance(raw, int | float) or not power:
        return raw
    return scale**power * raw


def scaled_mooring(raw: Any, scale: float) -> Any:
    """Return the stiffness of a mooring scaled by Froude: forces per length, per angle, moments per angle."""
    if not isinstance(raw, list | tuple):
        return raw
    diagonal = not any(isinstance(row, list | tuple) for row in raw)
    if diagonal:
        return [scaled(one, scale, 2.0 if i < 3 else 4.0) for i, one in enumerate(raw)]
    return [[scaled(one, scale, 2.0 + (i > 2) + (j > 2)) for j, one in enumerate(row)] for i, row in enumerate(raw)]


def scaled_take_off(raw: Any, scale: float) -> Any:
    """Return a take-off scaled by Froude: its force times what its port moves by is a work, of the fourth power."""
    if not isinstance(raw, dict):
        return raw
    port = raw.get("port")
    stroke = STROKES.get(port, 1.0) if isinstance(port, str) else 1.0
    powers = {
        "damping": 4.5 - 2 * stroke,
        "stiffness": 4 - 2 * stroke,
        "force_limit": 4 - stroke,
        "stroke_limit": stroke,
    }
    return {key: scaled(value, scale, powers.get(key, 0.0)) for key, value in raw.items()}


SECTIONS = {"mooring": scaled_mooring, "pto": scaled_take_off}
"""Sections whose quantities go with more than their names."""
