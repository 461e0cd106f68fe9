"""Floating balloon of rubber as a membrane, by shooting from both poles: nothing of the package is imported.

A sphere of radius a, colatitude phi from the top, goes to the meridian x(phi), z(phi) with the stretches
lambda_1 = |d(x, z)/dphi|/a and lambda_2 = x/(a sin phi) and its tangent psi below the horizontal:

    x' = a lambda_1 cos psi,  z' = -a lambda_1 sin psi,
    (W_1 sin phi)' = W_2 cos psi - a w sin phi sin psi/h          (along the meridian),
    T_1 psi'/(a lambda_1) + T_2 sin psi/x = p - w cos psi/(lambda_1 lambda_2)       (across),

W_i the derivatives of the energy per undeformed volume by the stretches, T_1 = h W_1/lambda_2 and T_2 = h W_2/lambda_1
the tensions, w the weight of the whole buoy per undeformed area, p the pressure inside less rho g times the depth.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

GRAVITY, WATER = 9.81, 1025.0
MEET = 1e-8
"""Gap of the halves at most, in metres, radians and stretch: that of the integration is 1e-10."""
POLE = 1e-4
"""Colatitude at which the integration begins: the curvature there is that of the pole to 1e-8."""
Slopes = tuple[float, float, float, float]


def neo_hookean(mu: float) -> Callable[[float, float], Slopes]:
    """W_1, W_2, W_11 and W_12 of mu/2 (l1^2 + l2^2 + (l1 l2)^-2 - 3)."""
    return lambda a, b: (
        mu * (a - a**-3 * b**-2),
        mu * (b - b**-3 * a**-2),
        mu * (1 + 3 * a**-4 * b**-2),
        2 * mu * a**-3 * b**-3,
    )


def mooney_rivlin(c1: float, c2: float) -> Callable[[float, float], Slopes]:
    """The same of c1 (I1 - 3) + c2 (I2 - 3), I2 = (l1 l2)^2 + l1^-2 + l2^-2."""
    first = neo_hookean(2 * c1)

    def slopes(a: float, b: float) -> Slopes:
        one, other, twice, mixed = first(a, b)
        return (
            one + 2 * c2 * (a * b**2 - a**-3),
            other + 2 * c2 * (b * a**2 - b**-3),
            twice + 2 * c2 * (b**2 + 3 * a**-4),
            mixed + 4 * c2 * a * b,
        )

    return slopes


@dataclass(frozen=True)
class Balloon:
    """A sphere of rubber with constant pressure inside, afloat; half immersed without deformation."""

    radius: float
    thickness: float
    slopes: Callable[[float, float], Slopes]
    mass: float
    pressure: float

    @property
    def weight(self) -> float:
        """Of the buoy per undeformed area [Pa]."""
        return self.mass * GRAVITY / (4 * np.pi * self.radius**2)

    def _net(self, z: float) -> float:
        return self.pressure + WATER * GRAVITY * min(z, 0.0)

    def _rates(self, phi: float, y: np.ndarray) -> list[float]:
        x, z, psi, one = y
        a, h, s, c = self.radius, self.thickness, np.sin(phi), np.cos(phi)
        other = x / (a * s)
        w1, w2, w11, w12 = self.slopes(one, other)
        rate = (w2 * np.cos(psi) - w1 * c) / s - a * self.weight * np.sin(psi) / h
        turned = (one * np.cos(psi) - other * c) / s
        across = self._net(z) - self.weight * np.cos(psi) / (one * other)
        bent = a * one * (across - h * w2 / one * np.sin(psi) / x) / (h * w1 / other)
        return [a * one * np.cos(psi), -a * one * np.sin(psi), bent, (rate - w12 * turned) / w11]

    def _from_pole(self, stretch: float, z: float, top: bool) -> list[float]:
        """State near a pole of equal stretches and curvatures."""
        side = 1.0 if top else -1.0
        tension = self.thickness * self.slopes(stretch, stretch)[0] / stretch
        across = self._net(z) - side * self.weight / stretch**2
        angle = POLE * self.radius * stretch * across / (2 * tension)
        return [self.radius * stretch * np.sin(POLE), z, angle if top else np.pi - angle, stretch]

    def _half(self, stretch: float, z: float, top: bool, points: np.ndarray | None = None) -> np.ndarray:
        """States from a pole to the equator of the undeformed sphere: the last, or at some colatitudes."""
        begin = POLE if top else np.pi - POLE
        found = solve_ivp(
            self._rates,
            (begin, np.pi / 2),
            self._from_pole(stretch, z, top),
            method="DOP853",
            rtol=1e-10,
            atol=1e-12,
            t_eval=points,
            max_step=0.02,
        )
        return found.y if points is not None else found.y[:, -1]

    def meridian(self, phi: np.ndarray, guess: tuple[float, float, float, float]) -> tuple[np.ndarray, np.ndarray]:
        """x and z at rest at colatitudes between the poles [m]; guessed stretch and height of top and keel."""

        def gap(q: np.ndarray) -> np.ndarray:
            return self._half(q[0], q[1], True) - self._half(q[2], q[3], False)

        q, found, _, message = fsolve(gap, guess, xtol=1e-11, full_output=True)
        if np.abs(found["fvec"]).max() > MEET:
            raise RuntimeError(f"the halves do not meet: {message}")
        above, below = phi[phi <= np.pi / 2], phi[phi > np.pi / 2]
        upper, lower = self._half(q[0], q[1], True, above), self._half(q[2], q[3], False, below[::-1])[:, ::-1]
        return np.concatenate([upper[0], lower[0]]), np.concatenate([upper[1], lower[1]])
