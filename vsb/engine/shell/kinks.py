"""Residual attachment modes of shells of any meridian under loads along rings; see `vsb.engine.shell.rings`.

Degrees do not separate on another meridian than the sphere's, but all of them answer a load at a ring together by what
the load does there: along the wall its displacement has a kink, normal to it a jump of the third derivative, and both
have jumps of higher ones. With s = phi - phi_0 the functions

    |s| t,  s|s| t,  s|s| n,  |s|^3 t,  |s|^3 n,  s|s|^3 t,  s|s|^3 n,    each times sin(phi)^2,

t and n the tangent and the normal of the meridian at the ring, and displacements of degrees that bending resolves, hold
the response: on a sphere with r/h = 200, 8 % of the energy are missed with degrees to 24, 0.03 % with degrees to 60,
where degrees alone leave 1/degree. The responses less those of degrees up to N are orthogonal to these in energy.
"""

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vsb.engine.shell.elastic import converged_degree
from vsb.engine.shell.rings import AT_POLE, HIGHEST, AttachmentModes, BeltLoad, RingLoad
from vsb.engine.shell.ritz import Displacements, Strains, energy, heave, of_degrees, strains
from vsb.engine.shell.shell import curve, length, meridian_rule
from vsb.tools.arrays import FloatArray, IntArray

FINER = 2
"""Degree of the responses over that which resolves buckling, whose waves are those of bending about a ring [-]."""
MOST = 400
"""Degree of the responses at most."""
POWERS = 4
"""Powers of |s|, each with its sign so that the derivative of its order jumps."""
ROUND_OFF = 1e-14
"""Part of the largest eigenvalue below which one is round-off: kinks of neighbouring rings are nearly alike [-]."""


class _At(NamedTuple):
    """Points of a quadrature over the wall, displacements and strains there."""

    area: FloatArray  # (point,) [m^2]
    of: Displacements
    strains: Strains


class KinkModes(AttachmentModes):
    """Residual attachment modes of a shell of any meridian, of order 0; below `HIGHEST` without kinks."""

    @cached_property
    def _rings(self) -> tuple[float, ...]:
        """Where displacements have kinks [rad]; at poles they have none."""
        if self.highest < HIGHEST:
            return ()
        at = list(self.shell.meridian.junctions)  # where the curvature jumps, too
        for load in self.loads:
            at += (load.upper, load.lower) if isinstance(load, BeltLoad) else (load.colatitude,)
        return tuple(sorted({float(phi) for phi in at if abs(math.sin(phi)) > AT_POLE}))

    @cached_property
    def _finest(self) -> int:
        """Degree of the displacements beside kinks; a tension T of the wall bends it within sqrt(D/T) of a ring."""
        if self.highest < HIGHEST:
            return min(self.highest, MOST)
        tension = max(0.0, *self.tension)
        tight = math.ceil(self.shell.reach * math.sqrt(tension / self.shell.bending_stiffness))
        finest = max(FINER * max(converged_degree(self.shell), tight), self.degree + 20)
        return min(finest, MOST)

    def _kinks(self, phi: FloatArray) -> Displacements:
        """Displacements with kinks at the rings."""
        found: list[list[FloatArray]] = [[] for _ in Displacements._fields]
        weight = np.sin(phi) ** 2, np.sin(2 * phi), 2 * np.cos(2 * phi)
        for ring in self._rings:
            at = curve(self.shell.meridian, np.array([ring]))
            slope, sin, cos = length(at.dx, at.dz)[0], math.sin(ring), math.cos(ring)
            tangent = (at.dx[0] * sin + at.dz[0] * cos) / slope, (at.dx[0] * cos - at.dz[0] * sin) / slope
            normal = -tangent[1], tangent[0]
            s, sign = phi - ring, np.where(phi < ring, -1.0, 1.0)
            for k in range(1, POWERS + 1):
                f, df = sign * s**k, k * sign * s ** (k - 1)
                ddf = k * (k - 1) * sign * s ** max(k - 2, 0)
                kink = (
                    f * weight[0],
                    df * weight[0] + f * weight[1],
                    ddf * weight[0] + 2 * df * weight[1] + f * weight[2],
                )
                for way in (tangent,) if k == 1 else (tangent, normal):
                    for column, value in zip(found, [share * part for share in way for part in kink], strict=True):
                        column.append(value)
        return Displacements(*(np.array(column).reshape(len(column), len(phi)) for column in found))

    def _displacements(self, phi: FloatArray) -> Displacements:
        """Displacements of degrees, then those with kinks."""
        pairs = zip(of_degrees(self._finest, phi), self._kinks(phi), strict=True)
        return Displacements(*(np.concatenate(pair) for pair in pairs))

    def _at(self, start: float = 0.0, end: float = math.pi) -> _At:
        """Points of a rule for energies, of the belt between two colatitudes [rad]."""
        meridian = self.shell.meridian
        breaks = sorted({*meridian.junctions, *self._rings, start, end} - {0.0, math.pi})
        phi, dphi = meridian_rule(breaks, 4 * self._finest + 64 + meridian.terms)
        inside = (start < phi) & (phi < end)
        phi, dphi = phi[inside], dphi[inside]
        at, of = curve(meridian, phi), self._displacements(phi)
        return _At(2 * np.pi * at.x * length(at.dx, at.dz) * dphi, of, strains(meridian, phi, of))

    @cached_property
    def _matrices(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Mass, elastic stiffness and that of a tension of 1 N/m in all directions, each over displacements."""
        area, of, found = self._at()
        shell, nu = self.shell, self.shell.poisson_ratio
        mass = (of.v * area) @ of.v.T + (of.u * area) @ of.u.T
        elastic = shell.membrane_stiffness * energy(found.meridional, found.hoop, nu, area)
        elastic += shell.bending_stiffness * energy(found.meridional_bending, found.hoop_bending, nu, area)
        turned = (found.rotation * area) @ found.rotation.T
        return shell.density * shell.thickness * mass, elastic, energy(found.meridional, found.hoop, 0.0, area) + turned

    @property
    def _heave(self) -> FloatArray:
        """Rigid heave over displacements."""
        rigid = heave(self._finest)
        return np.pad(rigid, (0, len(self._matrices[0]) - len(rigid)))

    @cached_property
    def _responses(self) -> FloatArray:
        """Displacement under each load, shape (displacement, load) [m/N]; that of degrees to N left out, and heave.

        Loads are balanced by the inertia of the shell, and its displacement is orthogonal to rigid heave.
        """
        mass, elastic, stretched = self._matrices
        rigid = self._heave
        weighed = mass @ rigid / (rigid @ mass @ rigid)
        rows = np.array([self._row(load) for load in self.loads])
        rows -= np.outer(rows @ rigid, weighed)
        count = self._finest + 1
        balanced = np.delete(np.arange(len(mass)), count)  # all but meridional degree 1, which heave stands for
        few = np.r_[0 : self.degree + 1, count + 1 : count + self.degree]
        found = np.zeros((len(mass), len(self.loads)))
        for force in dict.fromkeys(self.tension):
            own = np.equal(self.tension, force)
            stiffness = elastic + max(force, 0.0) * stretched
            found[:, own] = _static(stiffness, rows[own].T, balanced) - _static(stiffness, rows[own].T, few)
        return found - np.outer(rigid, weighed @ found)

    def _row(self, load: RingLoad | BeltLoad) -> FloatArray:
        """Work of a load on displacements, shape (displacement,) [-]; of a belt times the radius."""
        if isinstance(load, RingLoad):
            v, u = self._values(np.array([load.colatitude]))
            return load.radial * v[:, 0] + load.meridional * u[:, 0]
        hoop, meridional = self._of_belt(load.upper, load.lower)
        return self.shell.radius * (load.hoop * hoop + load.meridional * meridional)

    def _values(self, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Displacements along e_r and e_phi, each (displacement, point) [-]; at the poles, too."""
        inside = np.clip(colatitude, 1e-6, math.pi - 1e-6)
        of = self._displacements(inside)
        return of.v, of.u * (np.sin(colatitude) > AT_POLE)

    def _of_belt(self, upper: float, lower: float) -> tuple[FloatArray, FloatArray]:
        """Mean strains around the axis and along the meridian of a belt by displacements, (displacement,) [1/m]."""
        area, _, found = self._at(upper, lower)
        whole = area.sum()
        return found.hoop @ area / whole, found.meridional @ area / whole

    @cached_property
    def _under_loads(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """See `AttachmentModes`; the tension is that at the rings."""
        responses, tension = self._responses, np.array(self.tension)
        mass, elastic, stretched = (responses.T @ matrix @ responses for matrix in self._matrices)
        return mass, elastic, np.asarray(np.add.outer(tension, tension) / 2 * stretched)

    def displacement(self, colatitude: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return displacements along e_r, e_phi and e_theta at colatitudes [rad], each shape (mode, point) [-]."""
        modes = (self._responses @ self._combinations).T
        v, u = self._values(np.asarray(colatitude, dtype=float))
        return modes @ v, modes @ u, np.zeros((len(modes), len(colatitude)))

    def mean_strains(self, upper: float, lower: float) -> tuple[FloatArray, FloatArray]:
        """Return the mean strains around the axis and along the meridian of a belt, each shape (mode,) [1/m]."""
        modes = (self._responses @ self._combinations).T
        hoop, meridional = self._of_belt(upper, lower)
        return modes @ hoop, modes @ meridional


def _static(stiffness: FloatArray, loads: FloatArray, kept: IntArray) -> FloatArray:
    """Displacements under loads among those kept, shape (displacement, load)."""
    matrix, found = stiffness[np.ix_(kept, kept)], np.zeros_like(loads)
    size = 1 / np.sqrt(np.diag(matrix))
    values, vectors = np.linalg.eigh(size[:, None] * matrix * size)
    known = values > ROUND_OFF * values[-1]
    vectors = vectors[:, known]
    found[kept] = size[:, None] * (vectors @ ((vectors.T @ (size[:, None] * loads[kept])) / values[known, None]))
    return found
