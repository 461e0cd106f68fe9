"""The sea without its waves, and how waves run in it: dispersion relation, group and orbital velocities."""

import math
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field, field_validator

from vsb.keys.meanings import Key
from vsb.keys.quantities import Number, Positive, Section, within
from vsb.tools.arrays import ComplexArray, FloatArray

DEEPEST = 2e4
"""No sea is deeper [m]."""


class Water(Section):
    """Density [kg/m^3], depth [m] (`.inf` for deep water), gravity [m/s^2]."""

    KEYS: ClassVar = {
        "density": Key("kg/m^3", "1025.0", "density of the water"),
        "depth": Key("m", "50.0", "depth of the sea; .inf is deep water"),
        "gravity": Key("m/s^2", "9.81", "acceleration of gravity"),
    }
    density: Annotated[Positive, within(1.0, 2e4, "kg/m^3", "mercury has 13 534 kg/m^3")] = 1025.0
    depth: Annotated[Number, Field(gt=0)] = math.inf
    gravity: Annotated[Positive, within(0.01, 300.0, "m/s^2", "the sun has 274 m/s^2")] = 9.81

    @field_validator("depth")
    @classmethod
    def _on_earth(cls, value: float) -> float:
        if DEEPEST < value < math.inf:
            raise ValueError(f"needs at most {DEEPEST:g} m, or .inf for deep water")
        return value


def wavenumber(omega: float, depth: float, gravity: float) -> float:
    """Return k of the dispersion relation omega^2 = g k tanh(k d) [1/m]."""
    deep = omega**2 / gravity
    if not np.isfinite(depth) or deep * depth > 20.0:
        return deep
    from scipy.optimize import brentq  # slow to import, and not needed in deep water

    return float(brentq(lambda k: k * np.tanh(k * depth) - deep, deep, deep / np.tanh(deep * depth) * 2, xtol=1e-15))


def wavenumbers(omega: FloatArray, depth: float, gravity: float) -> FloatArray:
    """Return k of the dispersion relation of many frequencies at once, shape of `omega` [1/m]; the depth is finite."""
    deep = omega**2 * depth / gravity
    kd = np.where(deep > 1.0, deep, np.sqrt(deep))
    for _ in range(10):  # Newton's method, whose error squares: 1e-16 after six steps from anywhere
        tanh = np.tanh(kd)
        kd = kd - (kd * tanh - deep) / (tanh + kd * (1 - tanh**2))
    return np.asarray(kd / depth)


def group_velocity(omega: float, depth: float, gravity: float) -> float:
    """Return v_g = d omega/dk = omega/(2k) (1 + 2kd/sinh 2kd) [m/s].

    Examples
    --------
    Waves of 8 s in deep water, and in 10 m of it:

    >>> import math
    >>> [round(group_velocity(2 * math.pi / 8, depth, 9.81), 2) for depth in (math.inf, 10.0)]
    [6.25, 7.18]
    """
    k = wavenumber(omega, depth, gravity)
    kd2 = 2 * k * depth
    finite = kd2 / np.sinh(kd2) if kd2 < 40.0 else 0.0
    return float(omega / (2 * k) * (1 + finite))


def haskind_factor(omega: FloatArray, depth: float, density: float, gravity: float) -> FloatArray:
    """Return k/(4 rho g v_g), the factor of Haskind's damping X X^H of ring waves, shape (omega,) [s^3/(kg m)]."""
    k, speed = (np.array([of(w, depth, gravity) for w in omega]) for of in (wavenumber, group_velocity))
    return np.asarray(k / (4 * density * gravity * speed))


def vertical_velocity(omega: FloatArray, height: float, depth: float, gravity: float) -> ComplexArray:
    """Return the vertical velocity of waves at a height below still water per amplitude, shape (omega,) [1/s].

    -i w sinh k(z + d)/sinh kd; -i w exp kz in deep water.
    """
    k = np.array([wavenumber(w, depth, gravity) for w in omega])
    share = np.exp(k * height)
    if np.isfinite(depth):
        share = share * np.expm1(-2 * k * (height + depth)) / np.expm1(-2 * k * depth)
    return np.asarray(-1j * omega * share)


def horizontal_velocity(omega: FloatArray, height: float, depth: float, gravity: float) -> ComplexArray:
    """Return the velocity of waves along their way at a height below still water per amplitude, shape (omega,) [1/s].

    w cosh k(z + d)/sinh kd; w exp kz in deep water.
    """
    k = np.array([wavenumber(w, depth, gravity) for w in omega])
    share = np.exp(k * height)
    if np.isfinite(depth):
        share = share * (1 + np.exp(-2 * k * (height + depth))) / -np.expm1(-2 * k * depth)
    return np.asarray(omega * share, dtype=complex)


def power_limit(omega: float, depth: float, density: float, gravity: float) -> float:
    """Return the largest mean power an axisymmetric heaving body can absorb, per squared wave amplitude [W/m^2].

    Capture width 1/k = wavelength/(2 pi) times the energy flux rho g v_g/2 (Budal & Falnes; Evans).
    """
    flux = 0.5 * density * gravity * group_velocity(omega, depth, gravity)
    return float(flux / wavenumber(omega, depth, gravity))
