"""Studies of everything that heaves, in other units of mass and length, and with designs of other names."""

import re
from pathlib import Path

import numpy as np

from vsb.study import study as config

SEED = config.load(Path(__file__).parents[1] / "config" / "seed.yaml").model_dump(exclude_none=True)
REGULAR = {"kind": "regular", "amplitude": 0.179, "period": 2.5}
JONSWAP = {"kind": "jonswap", "hs": 0.3, "tp": 3.0, "seed": 3, "realisations": 2}
HEAVE = SEED | {
    "modes": {"basis": "membrane", "degree": 2},
    "hydro": {"omega_max": 4.0, "witness": "none"},
    "designs": {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC90": {"clamp": 90}},
    "pto": {"damping": {"FSB": 6e3, "VSWEC": 8e3, "VSWEC90": 9e3}, "stiffness": 1e3, "efficiency": 0.9},
    "waves": [REGULAR, JONSWAP],
    "simulation": SEED["simulation"] | {"duration": 12.0, "window": [6.0, 12.0]},
}
LENGTH, MASS = 2.0, 4.0
"""Of another system of units, its second the same: twice the gravity, half the density."""
POWERS = {
    "radius": (1, 0), "thickness": (1, 0), "young_modulus": (-1, 1), "density": (-3, 1), "mass": (0, 1),
    "internal_pressure": (-1, 1), "atmospheric_pressure": (-1, 1), "pressure": (-1, 1), "gravity": (1, 0), "depth": (1, 0),
    "damping": (0, 1), "stiffness": (0, 1), "force_limit": (1, 1), "stroke_limit": (1, 0), "amplitude": (1, 0),
    "hs": (1, 0), "initial_velocity": (1, 0), "initial_position": (1, 0), "area": (2, 0), "centre_of_mass": (1, 0),
    "ballast_inertia": (2, 1), "mooring": (0, 1), "alpha": (0, 0), "beta": (0, 0),
}  # fmt: skip
"""Of length and mass in each quantity of a study."""
NAMES = {"FSB": "Zeta", "VSWEC": "Mid", "VSWEC90": "Alpha"}
"""Of designs, which are told in the order of their names."""


def assert_close(found, expected, what, rtol=1e-7):
    """Within so much of the largest."""
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape, what
    np.testing.assert_allclose(
        found, expected, rtol=0, atol=rtol * np.nanmax(np.abs(expected), initial=0.0), err_msg=str(what)
    )


def restated(raw, power=(0, 0)):
    """A study in the other units."""
    if isinstance(raw, dict):
        return {key: restated(part, POWERS.get(key, power)) for key, part in raw.items()}
    if isinstance(raw, list | tuple):
        return [restated(part, power) for part in raw]
    return raw if isinstance(raw, bool | str) or not any(power) else raw * LENGTH ** power[0] * MASS ** power[1]


def factor(units):
    """What a number in so-called units is multiplied by: "kg/(m^2 s)"."""
    known = {
        "m": LENGTH,
        "kg": MASS,
        "N": LENGTH * MASS,
        "J": LENGTH**2 * MASS,
        "W": LENGTH**2 * MASS,
        "Pa": MASS / LENGTH,
    }
    known |= dict.fromkeys(("1", "-", "", "rad", "s", "%"), 1.0)
    over, _, under = units.partition("/")
    parts = [
        (part.partition("^"), sign) for text, sign in ((over, 1), (under, -1)) for part in text.strip("()").split()
    ]
    return np.prod([known[name] ** (sign * float(power or 1)) for (name, _, power), sign in parts])


def renamed(raw):
    """The same with designs of other names, in another order of the file."""
    return {NAMES.get(key, key): renamed(raw[key]) for key in reversed(raw)} if isinstance(raw, dict) else raw


def usual(text):
    """A text with the names designs usually have."""
    names = {other: name for name, other in NAMES.items()}
    return re.sub("|".join(names), lambda found: names[found[0]], text)
