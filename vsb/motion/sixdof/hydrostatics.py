"""Hydrostatic force on the deformed shell at any tilt in still water: a named force of every scene.

The water sees the tilt only through the slope s of the body's axis: the height of a point of the shell is
Z = A + B cos(theta), A = centre height + c zeta, B = s x, with theta the azimuth from the upward side, x and zeta the
meridian's radius and height along the axis, c and s cosine and sine of the tilt. On every circle of colatitude the wet
arc is known, so azimuth is integrated in closed form; what remains is one integral along the meridian.
"""

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from vsb.motion.sixdof.body import State, skew
from vsb.shell.deformed import DeformedShell, Meridian
from vsb.shell.modes import ModeBasis
from vsb.tools.arrays import FloatArray


class _Tilted(NamedTuple):
    """The deformed shell over still water, as far as the water can tell."""

    shell: DeformedShell  # in body axes
    height: float  # of the sphere centre above still water [m]
    cos: float  # of the tilt
    sin: float
    upward: FloatArray  # direction of theta = 0 in body axes, (3,)

    @classmethod
    def of(cls, basis: ModeBasis, state: State) -> "_Tilted":
        """Return the shell of a state."""
        up = state.rotation[2]  # the vertical in body axes
        azimuth = np.arctan2(up[1], up[0])
        upward = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        shell = DeformedShell(basis, 0.0, np.concatenate([[0.0], state.modal_amplitude]))
        return cls(shell, float(state.position[2]), float(up[2]), float(np.hypot(up[0], up[1])), upward)

    def heights(self, colatitude: FloatArray, side: int) -> FloatArray:
        """Heights of the upward (+1) or downward (-1) meridian above still water, shape (point,) [m]."""
        m = self.shell.meridian(colatitude)
        return self.height + self.cos * m.z + side * self.sin * m.x

    def edges(self) -> list[float]:
        """Colatitudes between which the wet arc varies smoothly: poles, and circles that touch the water plane."""
        grid = np.linspace(0.0, np.pi, 40 * (self.shell.basis.highest_degree + 1) + 1)
        found = {0.0, float(np.pi)}
        for side in (1, -1) if self.sin else (1,):
            wet = self.heights(grid, side) < 0
            for i in np.flatnonzero(wet[1:] != wet[:-1]):
                found.add(float(brentq(self._height, grid[i], grid[i + 1], args=(side,), xtol=1e-15, rtol=1e-15)))
        return sorted(found)

    def _height(self, colatitude: float, side: int) -> float:
        return float(self.heights(np.array([colatitude]), side)[0])


def _wet_cosines(a: FloatArray, b: FloatArray) -> FloatArray:
    """Integrals of cos^k(theta) over the wet arc a + b cos(theta) < 0, b >= 0, shape (4, point)."""
    dry = np.arctan2(np.sqrt(np.maximum(b**2 - a**2, 0.0)), -a)  # half of the dry arc: 0 wet all round, pi dry
    wet, sin, cos = np.pi - dry, np.sin(dry), np.cos(dry)
    return np.array([2 * wet, -2 * sin, wet - sin * cos, -2 * sin + 2 / 3 * sin**3])


@dataclass(frozen=True)
class Hydrostatic:
    """Pressure -rho g Z on the wet part of the tilted, deformed shell.

    Notes
    -----
    Q = -int p n.(dr/dq) dS = rho g int Z n.(dr/dq) dS with n dS = x (-zeta' e_x + x' e_3) dphi dtheta in body axes.
    Where a circle of colatitude touches the water's plane the integrand is as smooth as a power 3/2; the points crowd
    there like a sine, which makes it analytic: convergence is spectral at every tilt. No tilt, no azimuth: the force
    is `DeformedShell.hydrostatic_force`.
    """

    basis: ModeBasis
    density: float  # of the water [kg/m^3]
    gravity: float  # [m/s^2]
    points: int = 40  # per piece of the meridian

    def _quadrature(self, tilted: _Tilted) -> tuple[Meridian, FloatArray, FloatArray, FloatArray]:
        """Return points of the wet meridian, weights, A [m] and B [m], over all pieces with any water."""
        node, weight = np.polynomial.legendre.leggauss(self.points)
        place, weight = np.sin(np.pi / 2 * node), np.pi / 2 * np.cos(np.pi / 2 * node) * weight
        halves = [((a + b) / 2, (b - a) / 2) for a, b in itertools.pairwise(tilted.edges())]
        wet = [(middle, half) for middle, half in halves if tilted._height(middle, -1) < 0]
        m = tilted.shell.meridian(np.concatenate([np.zeros(0), *(middle + half * place for middle, half in wet)]))
        weights = np.concatenate([np.zeros(0), *(half * weight for _, half in wet)])
        return m, weights, tilted.height + tilted.cos * m.z, tilted.sin * m.x

    def __call__(self, time: float, state: State) -> FloatArray:
        """Return the generalized force, shape (6 + mode,) [N, N m, N]: inertial axes, body axes, modal."""
        tilted = _Tilted.of(self.basis, state)
        m, weight, a, b = self._quadrature(tilted)
        c = _wet_cosines(a, b)
        scale = self.density * self.gravity * weight * m.x
        mean, upward = scale * (a * c[0] + b * c[1]), scale * (a * c[1] + b * c[2])  # Z over the wet arc, Z cos(theta)
        along_shapes = (-m.dz * m.shape_x + m.dx * m.shape_z) @ mean  # heave's shape is e_3: the force along the axis
        axis = np.array([0.0, 0.0, 1.0])
        force = along_shapes[0] * axis - (m.dz @ upward) * tilted.upward
        torque = -((m.z * m.dz + m.x * m.dx) @ upward) * skew(axis) @ tilted.upward
        return np.concatenate([state.rotation @ force, torque, along_shapes[1:]])

    def potential(self, state: State) -> float:
        """Return the energy of the water displaced, rho g int (-Z) dV = -rho g/2 int Z^2 n_Z dS [J]."""
        tilted = _Tilted.of(self.basis, state)
        m, weight, a, b = self._quadrature(tilted)
        c = _wet_cosines(a, b)
        square, upward = (a**2 * c[k] + 2 * a * b * c[k + 1] + b**2 * c[k + 2] for k in (0, 1))
        lift = tilted.cos * m.dx * square - tilted.sin * m.dz * upward
        return float(-0.5 * self.density * self.gravity * (weight * m.x) @ lift)
