"""Residual attachment modes of a spherical shell under loads along rings: clamps, held rings, take-offs on rings.

Such a load acts along a line, and all degrees yield to it: normal to the wall like n^-4, by bending, but along it like
n^-2, by stretching, so that modes up to degree N miss something like 1/N. The static response of degrees above N
(MacNeal 1971, Rubin 1975) follows from the displacements R_n of the rings in degree n and the stiffness K_n of that
degree. One further shape for each load,

    w_n = K_n^-1 R_n^T,    n > N,

is a shell mode like the others, with its own mass and stiffness, that moves the rings. It moves hardly any water, its
wavelengths being short, and none is counted.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import legendre_p_all

from vsb.engine.shell.degrees import bending_block, mass_block, membrane_block, tension_block
from vsb.engine.shell.shell import Shell
from vsb.tools.arrays import FloatArray, IntArray

HIGHEST = 4000
"""Degree to which responses are summed; what is left of a sum is N/HIGHEST of it."""
AT_POLE = 1e-9
"""Sine of a colatitude below which nothing moves along the meridian, by symmetry [-]."""
SAME = 1e-10
"""Part of the largest compliance of a combination of loads below which it repeats others [-]."""


class RingLoad(NamedTuple):
    """A load along a ring of the shell, per unit of its resultant."""

    colatitude: float  # [rad]
    radial: float  # its direction [-]
    meridional: float

    @property
    def moves(self) -> bool:
        """Whether it moves the shell: at a pole only if it is radial, by symmetry."""
        return bool(self.radial) or abs(np.sin(self.colatitude)) > AT_POLE

    def rows(self, degrees: IntArray) -> FloatArray:
        """Return its work on radial and meridional amplitudes of degrees, shape (degree, 2) [-]."""
        p, slope = _legendre(degrees, np.array([self.colatitude]))
        return np.hstack([self.radial * p, self.meridional * slope])


class BeltLoad(NamedTuple):
    """A tension of a belt of the wall, per unit of the mean strains between two colatitudes; its edges are lines."""

    upper: float  # [rad]
    lower: float
    hoop: float  # share of the strain around the axis [-]
    meridional: float  # and along the meridian

    @property
    def colatitude(self) -> float:
        """The middle of the belt [rad]."""
        return (self.upper + self.lower) / 2

    @property
    def moves(self) -> bool:
        """Whether degrees above 1 answer: not if it is the change of the whole area."""
        ends = np.sin([self.upper, self.lower])
        return bool(np.abs(ends).max() > AT_POLE) or self.hoop != self.meridional

    def rows(self, degrees: IntArray) -> FloatArray:
        """Return its work on radial and meridional amplitudes of degrees times the radius, shape (degree, 2) [-].

        Strains are (u cot phi + v)/r and (u' + v)/r, their means over the sphere's belt integrals in closed form, as
        (sin phi P_n')' = -n(n+1) sin phi P_n.
        """
        ends = np.array([self.upper, self.lower])
        p, slope = _legendre(degrees, ends)
        edges = np.diff(slope * np.sin(ends))[:, 0]
        radial = -edges / (degrees * (degrees + 1))
        around = np.diff(p * np.cos(ends))[:, 0] + radial
        hoop, meridional = np.array([radial, around]).T, np.array([radial, edges - around]).T
        return np.asarray((self.hoop * hoop + self.meridional * meridional) / -np.diff(np.cos(ends)))


def normal_to_wall(colatitude: float) -> RingLoad:
    """Return a radial load at a colatitude [rad]."""
    return RingLoad(float(colatitude), 1.0, 0.0)


def along_wall(colatitude: float) -> RingLoad:
    """Return a meridional load at a colatitude [rad]."""
    return RingLoad(float(colatitude), 0.0, 1.0)


def vertical(colatitude: float) -> RingLoad:
    """Return a vertical load at a colatitude [rad]."""
    return RingLoad(float(colatitude), float(np.cos(colatitude)), float(-np.sin(colatitude)))


@dataclass(frozen=True)
class RingModes:
    """Residual attachment modes of a sphere: its static response to loads at rings by all degrees above one.

    Parameters
    ----------
    shell : Shell
        A sphere.
    degree : int
        N, of the modes beside which they stand.
    loads : tuple of RingLoad or BeltLoad
    tension : tuple of float
        Membrane force along the meridian at each ring, of a shell under load [N/m].
    highest : int
        Degree to which they are summed.

    Notes
    -----
    They are combined so that their stiffness is diagonal. Loads given twice, or at one ring in three directions, have
    no modes of their own.
    """

    shell: Shell
    degree: int
    loads: tuple[RingLoad | BeltLoad, ...]
    tension: tuple[float, ...]
    highest: int = HIGHEST

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the modes."""
        return tuple(f"Ring{i}" for i in range(1, self._combinations.shape[1] + 1))

    @cached_property
    def _degrees(self) -> IntArray:
        """The degrees above N."""
        return np.arange(max(self.degree, 1) + 1, self.highest + 1)

    @cached_property
    def _responses(self) -> FloatArray:
        """Radial and meridional amplitudes of each degree under each load, shape (degree, 2, load) [m/N]."""
        n = self._degrees
        rows = np.stack([load.rows(n) for load in self.loads], axis=-1)
        elastic, stretched, found = self._elastic, tension_block(n), np.empty_like(rows)
        for i, force in enumerate(self.tension):
            stiffness = elastic + max(force, 0.0) * stretched
            found[..., i] = np.linalg.solve(stiffness, rows[..., i, None])[..., 0]
        return np.asarray(found)

    @property
    def _elastic(self) -> FloatArray:
        """Elastic stiffness of each degree, (degree, 2, 2) [N/m]."""
        return np.asarray(membrane_block(self.shell, self._degrees) + bending_block(self.shell, self._degrees))

    @cached_property
    def _under_loads(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Mass, elastic stiffness and that of the tension over the responses to the loads, each (load, load)."""
        n, responses, tension = self._degrees, self._responses, np.array(self.tension)
        blocks = mass_block(self.shell, n), self._elastic, tension_block(n)
        mass, elastic, stretched = (
            np.einsum("nai,nab,nbj->ij", responses, block, responses, optimize=True) for block in blocks
        )
        return mass, elastic, np.asarray(np.add.outer(tension, tension) / 2 * stretched)

    @cached_property
    def _combinations(self) -> FloatArray:
        """Loads of unit amplitudes, one column for each mode [N/m]: of equal stiffness and without coupling."""
        _, elastic, stretched = self._under_loads
        compliance, directions = np.linalg.eigh(elastic + stretched)
        kept = compliance > SAME * compliance[-1]
        return np.asarray(directions[:, kept] / np.sqrt(compliance[kept] * compliance[-1]))

    def _over_modes(self, matrix: FloatArray) -> FloatArray:
        """A matrix over the loads as one over the modes."""
        found = self._combinations.T @ matrix @ self._combinations
        return np.asarray((found + found.T) / 2)

    @cached_property
    def inertia(self) -> FloatArray:
        """Mass, shape (mode, mode) [kg]."""
        return self._over_modes(self._under_loads[0])

    @cached_property
    def stiffness(self) -> FloatArray:
        """Elastic stiffness, shape (mode, mode) [N/m]."""
        return self._over_modes(self._under_loads[1])

    @cached_property
    def prestress(self) -> FloatArray:
        """Stiffness by the tension of the wall, shape (mode, mode) [N/m]."""
        return self._over_modes(self._under_loads[2])

    def displacement(self, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return radial and meridional displacements at colatitudes [rad], each shape (mode, point) [-]."""
        radial, meridional = np.moveaxis(self._responses @ self._combinations, 1, 0)
        p, slope = _legendre(self._degrees, np.asarray(colatitude, dtype=float))
        return np.asarray(radial.T @ p), np.asarray(meridional.T @ slope)

    def mean_strains(self, upper: float, lower: float) -> tuple[FloatArray, FloatArray]:
        """Return the mean strains around the axis and along the meridian of a belt, each shape (mode,) [1/m]."""
        rows = np.stack([BeltLoad(upper, lower, *way).rows(self._degrees) for way in ((1.0, 0.0), (0.0, 1.0))])
        hoop, meridional = np.einsum("wna,naj->wj", rows, self._responses @ self._combinations) / self.shell.radius
        return hoop, meridional


def _legendre(degrees: IntArray, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
    """P_n(cos phi) and its derivative by phi of consecutive degrees, each shape (degree, point)."""
    p, by_cos = legendre_p_all(int(degrees[-1]), np.cos(colatitude), diff_n=1)
    return np.asarray(p[degrees]), np.asarray(-np.sin(colatitude) * by_cos[degrees])
