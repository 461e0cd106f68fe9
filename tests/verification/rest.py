"""Rest shape of a floating pressurised sphere by minimising its energy over splines: nothing of the package is imported.

The meridian phi in [0, pi] from the top goes to x = r sin phi + X, z = c + r cos phi + Z. Energies, per unit azimuth
2 pi: Green-Lagrange strains of the membrane, ((x'^2 + z'^2)/r^2 - 1)/2 and ((x/(r sin phi))^2 - 1)/2; bending by the
linear rotation (v' - u)/r; less the work p V of the pressure inside; the water's -rho g int z dV below z = 0; and the
weight, spread evenly over the shell's area.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.interpolate import BSpline
from scipy.optimize import root

GRAVITY, WATER = 9.81, 1025.0
ORDER = 5


@dataclass(frozen=True)
class Floating:
    """A sphere of Hooke's law with constant internal gauge pressure; half immersed without deformation."""

    radius: float
    thickness: float
    young_modulus: float
    poisson_ratio: float
    mass: float
    pressure: float
    pieces: int = 40
    """Of the splines between the poles."""

    @cached_property
    def _splines(self) -> tuple[np.ndarray, np.ndarray]:
        """Knots, and the map from unknowns to coefficients of X, then of Z: X = 0 and Z' = 0 at both poles."""
        knots = np.concatenate([[0.0] * ORDER, np.linspace(0, np.pi, self.pieces + 1), [np.pi] * ORDER])
        n = len(knots) - ORDER - 1
        x, z = np.eye(n)[:, 1:-1], np.eye(n)[:, 1:-1]
        z[0, 0] = z[-1, -1] = 1.0
        return knots, np.block([[x, np.zeros_like(z)], [np.zeros_like(x), z]])

    def shapes(self, phi: np.ndarray, derivative: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """X and Z of every unknown, or their derivatives, (point, unknown)."""
        knots, unknowns = self._splines
        n = len(unknowns) // 2
        values = BSpline(knots, np.eye(n), ORDER)(phi, nu=derivative)
        return values @ unknowns[:n], values @ unknowns[n:]

    @cached_property
    def _gauss(self) -> tuple[np.ndarray, ...]:
        """Points and weights on every piece, shapes and first derivatives there, rotation and its derivative."""
        t, weight = leggauss(6)
        edges = np.linspace(0, np.pi, self.pieces + 1)
        half = np.diff(edges)[:, None] / 2
        phi = ((edges[:-1] + edges[1:])[:, None] / 2 + half * t).ravel()
        (x, z), (x1, z1), (x2, z2) = (self.shapes(phi, k) for k in range(3))
        s, c = np.sin(phi)[:, None], np.cos(phi)[:, None]
        turn = (s * x1 + c * z1) / self.radius  # e_r . d/dphi of the displacement
        bent = (c * x1 - s * z1 + s * x2 + c * z2) / self.radius
        return phi, (half * weight).ravel(), x, z, x1, z1, turn, bent

    @cached_property
    def _linear(self) -> tuple[np.ndarray, np.ndarray]:
        """Bending stiffness and weight, which do not depend on the shape."""
        phi, weight, _, z, *_, turn, bent = self._gauss
        area = self.radius**2 * np.sin(phi) * weight
        k1, k2 = -bent / self.radius, -turn / np.tan(phi)[:, None] / self.radius
        d = self.young_modulus * self.thickness**3 / (12 * (1 - self.poisson_ratio**2))
        cross = (k1 * area[:, None]).T @ k2
        stiff = d * ((k1 * area[:, None]).T @ k1 + (k2 * area[:, None]).T @ k2 + self.poisson_ratio * (cross + cross.T))
        return stiff, self.mass * GRAVITY / (4 * np.pi * self.radius**2) * (area @ z)

    def gradient(self, q: np.ndarray, load: float) -> np.ndarray:
        """Derivative of the energy by the unknowns, at a share of weight, water and pressure."""
        phi, weight, x, z, x1, z1, *_ = self._gauss
        r, s, c = self.radius, np.sin(phi), np.cos(phi)
        own, dx, dz = r * s + x @ q, r * c + x1 @ q, -r * s + z1 @ q
        e1, e2 = ((dx**2 + dz**2) / r**2 - 1) / 2, ((own / (r * s)) ** 2 - 1) / 2
        stiff = self.young_modulus * self.thickness / (1 - self.poisson_ratio**2) * r**2 * s * weight
        n1, n2 = stiff * (e1 + self.poisson_ratio * e2), stiff * (e2 + self.poisson_ratio * e1)
        found = ((n1 * dx) @ x1 + (n1 * dz) @ z1) / r**2 + (n2 * own / (r * s) ** 2) @ x
        bending, weights = self._linear
        inside = (own * dx * weight) @ z - (own * dz * weight) @ x  # of V/(2 pi)
        return found + bending @ q + load * (weights - self.pressure * inside + self._water(q))

    def _water(self, q: np.ndarray) -> np.ndarray:
        """Derivative of the water's energy: int rho g z n.psi dS below the waterline, n outward."""
        low, high = 0.25 * np.pi, 0.75 * np.pi
        for _ in range(60):  # the height falls along the meridian
            middle = (low + high) / 2
            above = self.radius * np.cos(middle) + (self.shapes(np.array([middle]))[1] @ q)[0] > 0
            low, high = (middle, high) if above else (low, middle)
        edges = np.linspace(0, np.pi, self.pieces + 1)
        edges = np.concatenate([[low], edges[edges > low + 1e-12]])
        t, weight = leggauss(8)
        half = np.diff(edges)[:, None] / 2
        phi, weight = ((edges[:-1] + edges[1:])[:, None] / 2 + half * t).ravel(), (half * weight).ravel()
        (x, z), (x1, z1) = self.shapes(phi), self.shapes(phi, 1)
        own, height = self.radius * np.sin(phi) + x @ q, self.radius * np.cos(phi) + z @ q
        dx, dz = self.radius * np.cos(phi) + x1 @ q, -self.radius * np.sin(phi) + z1 @ q
        pressure = -WATER * GRAVITY * height * weight * own
        return (pressure * dx) @ z - (pressure * dz) @ x

    def rest(self, steps: int = 4) -> np.ndarray:
        """Unknowns at rest under the whole load, which grows step by step."""
        q = np.zeros(self._splines[1].shape[1])
        for load in np.arange(1, steps + 1) / steps:
            found = root(self.gradient, q, load, method="hybr", options={"xtol": 1e-10})
            if not found.success:
                raise RuntimeError(f"no rest at {load} of the load: {found.message}")
            q = found.x
        return q

    def displacement(self, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """X and Z at rest [m]."""
        q = self.rest()
        x, z = self.shapes(phi)
        return x @ q, z @ q
