"""Residual attachment modes of a shell under loads along rings: clamps, held rings, take-offs on rings.

Such a load acts along a line, and all degrees yield to it: normal to the wall like n^-4, by bending, but along it like
n^-2, by stretching, so that modes up to degree N miss something like 1/N. The static response of degrees above N
(MacNeal 1971, Rubin 1975) follows from the displacements R_n of the rings in degree n and the stiffness K_n of that
degree. One further shape for each load,

    w_n = K_n^-1 R_n^T,    n > N,

is a shell mode like the others, with its own mass and stiffness, that moves the rings. It moves little water, its
wavelengths being short, which counts where a take-off drives the bending of the wall beside a ring, or the wall is soft
(`vsb.study.resolution.wets_rings`). There two more loads are pressures that set in at the waterline, as all pressures
of water do.
`RingModes` are of the sphere, `KinkModes` of other shapes.

Loads that go with cos(m theta), m >= 1, do the same: of radial displacements and gradients along the surface a degree
has the stiffness it has for m = 0 (`vsb.engine.shell.orders`). They also twist the wall,

    u = T m S/sin(phi) along e_phi,  w = -T S' along e_theta,

which moves no water and couples with nothing but such loads and the weight of still water, so that all degrees of it
from 2 on answer here: the lowest by themselves, for water softens them, the others with the static response. Its energy
is that of shear, G h (n-1)(n+2) int (u^2 + w^2) dA/r^2; a tension p r/2 adds to G h.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag
from scipy.special import factorial2, legendre_p_all

from vsb.engine.shell.meridian import curve, length, meridian_rule
from vsb.engine.shell.ritz import (
    Displacements,
    Strains,
    bending_block,
    energy,
    heave,
    mass_block,
    membrane_block,
    of_degrees,
    strains,
    tension_block,
    twisted,
    twisting_mass,
)
from vsb.engine.shell.shell import Shell, converged_degree
from vsb.tools.arrays import FloatArray, IntArray

HIGHEST = 4000
"""Degree to which responses are summed; what is left of a sum is N/HIGHEST of it."""
AT_POLE = 1e-9
"""Sine of a colatitude below which nothing moves along the meridian, by symmetry [-]."""
TWISTS = 4
"""Degree up to which twists are degrees of freedom of their own."""
SAME = 1e-10
"""Part of the compliance of a load below which, without what others do, it repeats these [-]."""


class RingLoad(NamedTuple):
    """A load along a ring of the shell, per unit of its resultant."""

    colatitude: float  # [rad]
    radial: float  # its direction [-]
    meridional: float
    azimuthal: float = 0.0

    @property
    def moves(self) -> bool:
        """Whether it moves the shell, if it is the same all around: at a pole only if it is radial, by symmetry."""
        return bool(self.radial) or abs(np.sin(self.colatitude)) > AT_POLE

    def rows(self, degrees: IntArray, order: int = 0) -> FloatArray:
        """Return its work on radial and surface amplitudes of degrees, (degree, 2) [-]; of order m it goes with cos."""
        s, slope, around = _harmonics(degrees, order, np.array([self.colatitude]))
        return np.hstack([self.radial * s, self.meridional * slope - self.azimuthal * around])

    def twist_rows(self, degrees: IntArray, order: int) -> FloatArray:
        """Return its work on the twist of degrees, shape (degree,) [-]."""
        _, slope, around = _harmonics(degrees, order, np.array([self.colatitude]))
        return np.asarray((self.meridional * around - self.azimuthal * slope)[:, 0])


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

    def rows(self, degrees: IntArray, order: int = 0) -> FloatArray:
        """Return its work on radial and meridional amplitudes of degrees times the radius, shape (degree, 2) [-].

        Of order 0: a mean over the belt has no other.

        Strains are (u cot phi + v)/r and (u' + v)/r, their means over the sphere's belt integrals in closed form, as
        (sin phi P_n')' = -n(n+1) sin phi P_n.
        """
        assert order == 0
        ends = np.array([self.upper, self.lower])
        p, slope, _ = _harmonics(degrees, 0, ends)
        edges = np.diff(slope * np.sin(ends))[:, 0]
        radial = -edges / (degrees * (degrees + 1))
        around = np.diff(p * np.cos(ends))[:, 0] + radial
        hoop, meridional = np.array([radial, around]).T, np.array([radial, edges - around]).T
        return np.asarray((self.hoop * hoop + self.meridional * meridional) / -np.diff(np.cos(ends)))


class PressureLoad(NamedTuple):
    """A pressure on the wall below still water, constant or growing with the depth: what water does near the surface.

    Every pressure of water sets in at the waterline so; terms of degrees fall like n^-3/2 and n^-5/2.
    """

    colatitude: float  # of the waterline [rad]
    power: int  # 0 or 1, of the depth over the radius

    @property
    def moves(self) -> bool:
        """Whether it moves the shell."""
        return True

    def rows(self, degrees: IntArray, order: int = 0) -> FloatArray:
        """Return its work on radial and meridional amplitudes of degrees on a sphere, shape (degree, 2) [-].

        Of order 0. With x the cosine of the colatitude, int P_n dx = (P_(n+1) - P_(n-1))/(2n + 1), also twice.
        """
        assert order == 0
        p, *_ = _harmonics(np.arange(int(degrees[-1]) + 3), 0, np.array([self.colatitude]))

        def below(n: IntArray) -> FloatArray:
            return np.asarray((p[n + 1] - p[n - 1])[:, 0] / (2 * n + 1))

        moment = (below(degrees + 1) - below(degrees - 1)) / (2 * degrees + 1) if self.power else below(degrees)
        return np.stack([moment, np.zeros(len(degrees))], axis=-1)


Load = RingLoad | BeltLoad | PressureLoad


def normal_to_wall(colatitude: float) -> RingLoad:
    """Return a radial load at a colatitude [rad]."""
    return RingLoad(float(colatitude), 1.0, 0.0)


def along_wall(colatitude: float) -> RingLoad:
    """Return a meridional load at a colatitude [rad]."""
    return RingLoad(float(colatitude), 0.0, 1.0)


def around_axis(colatitude: float) -> RingLoad:
    """Return a load along the ring at a colatitude [rad], which goes with sin(m theta) where others go with cos."""
    return RingLoad(float(colatitude), 0.0, 0.0, 1.0)


def vertical(colatitude: float) -> RingLoad:
    """Return a vertical load at a colatitude [rad]."""
    return RingLoad(float(colatitude), float(np.cos(colatitude)), float(-np.sin(colatitude)))


@dataclass(frozen=True)
class AttachmentModes(ABC):
    """Residual attachment modes of a shell: its static response to loads at rings by all degrees above those it has.

    They are combined so that their stiffness is diagonal. Loads given twice, or at one ring in more directions than it
    moves in, have no modes of their own.

    Parameters
    ----------
    shell : Shell
    degree : int
        N, of the modes beside which they stand.
    loads : tuple of RingLoad, BeltLoad or PressureLoad
    tension : tuple of float
        Membrane force along the meridian at each ring, of a shell under load [N/m].
    highest : int
        Degree to which they are summed.
    order : int
        Azimuthal order m, of loads and modes.
    stepped_from : AttachmentModes, optional
        Those of which these have an imaginary step: their combinations of responses are these modes' too.
    """

    shell: Shell
    degree: int
    loads: tuple[Load, ...]
    tension: tuple[float, ...]
    highest: int = HIGHEST
    order: int = 0
    stepped_from: "AttachmentModes | None" = field(default=None, compare=False)

    @property
    def resolved(self) -> int:
        """The highest degree that answers."""
        return self.highest

    @property
    def wet(self) -> int:
        """How many of the first loads see the water: up to the last pressure of it."""
        return max((i for i, load in enumerate(self.loads, 1) if isinstance(load, PressureLoad)), default=0)

    @property
    @abstractmethod
    def _under_loads(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Mass, elastic stiffness and that of the tension over responses to loads, and twists, each (shape, shape)."""

    @abstractmethod
    def displacement(self, colatitude: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return displacements along e_r, e_phi and e_theta at colatitudes [rad], each shape (mode, point) [-]."""

    @abstractmethod
    def mean_strains(self, upper: float, lower: float) -> tuple[FloatArray, FloatArray]:
        """Return the mean strains around the axis and along the meridian of a belt, each shape (mode,) [1/m]."""

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the modes."""
        of_order = f"c{self.order}" if self.order else ""
        return tuple(f"Ring{i}{of_order}" for i in range(1, self._combinations.shape[1] + 1))

    @cached_property
    def _combinations(self) -> FloatArray:
        """Responses and twists of the modes, one column for each: of equal stiffness and without coupling.

        Each is of one load and of those before it: further loads leave the modes of the first ones as they are.
        """
        if self.stepped_from:
            return self.stepped_from._combinations
        _, elastic, stretched = self._under_loads
        count = len(self.loads)
        compliance, combined = (elastic + stretched)[:count, :count], np.zeros((count, 0))
        own = np.diag(compliance)
        first = next((each for each in own if each > SAME * own.max()), 1.0)
        for i, load in enumerate(np.eye(count)):
            for _ in range(2):  # once more, for round-off
                load = load - combined @ (combined.T @ compliance @ load)
            if (left := load @ compliance @ load) > SAME * max(own[i], first):
                combined = np.column_stack([combined, load / np.sqrt(left)])
        twists = np.diag(1 / np.sqrt(np.diag(elastic)[count:]))
        return np.asarray(block_diag(combined, twists) / np.sqrt(first))

    @cached_property
    def _own_compliance(self) -> FloatArray:
        """Displacement of each load under itself, shape (load,) [m/N]."""
        loads, (_, elastic, stretched) = len(self.loads), self._under_loads
        return np.diag(elastic + stretched)[:loads]

    @cached_property
    def _units(self) -> FloatArray:
        """What is a displacement of one under each load: of the ring, under a pressure at most, shape (load,) [m/N]."""
        found = self._own_compliance.copy()
        if self.wet:
            p, *_ = _harmonics(np.arange(MOST + 1), 0, np.linspace(0.0, np.pi, 2 * MOST))
            largest = np.abs(self._in_degrees(MOST)[0] @ p).max(axis=1)
            found = np.where([isinstance(load, PressureLoad) for load in self.loads], largest, found)
        return found

    def of_loads(self, count: int) -> FloatArray:
        """Return the share in each mode of what a unit displacement of the first loads does, shape (mode, count) [-].

        Of modes of further loads 0.
        """
        alone = ~self._combinations[count:].any(axis=0)
        return np.asarray((self._combinations[:count] * alone * self._units[:count, None]).T)

    def under_loads(self, highest: int) -> FloatArray:
        """Return radial and meridional amplitudes of degrees, where each load moves by one, (2, load, degree) [-]."""
        return self._in_degrees(highest) / self._units[:, None]

    @abstractmethod
    def _in_degrees(self, highest: int) -> FloatArray:
        """Radial and meridional amplitudes of degrees to one under each load, shape (2, load, degree) [m/N]."""

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
        """Stiffness by the tension of the wall, shape (mode, mode) [N/m]; of order m of degrees above N alone."""
        return self._over_modes(self._under_loads[2])


class RingModes(AttachmentModes):
    """Residual attachment modes of a sphere, degree by degree."""

    @cached_property
    def _degrees(self) -> IntArray:
        """The degrees above N."""
        return np.arange(max(self.degree, 1) + 1, self.highest + 1)

    @cached_property
    def _twists(self) -> IntArray:
        """The degrees that twist: all from 2 on, for none of them are among the modes."""
        return np.arange(max(2, self.order), self.highest + 1) if self.order else np.arange(0)

    @cached_property
    def _own(self) -> int:
        """How many of them are degrees of freedom of their own."""
        return int(np.sum(self._twists <= min(self.degree, TWISTS)))

    @cached_property
    def _responses(self) -> FloatArray:
        """Radial and surface amplitudes of each degree under each load, none of twists, (degree, 2, shape) [m/N]."""
        n = self._degrees
        rows = np.stack([load.rows(n, self.order) for load in self.loads], axis=-1)
        elastic, stretched, found = self._elastic, tension_block(n), []
        for i, force in enumerate(self.tension):
            stiffness = elastic + (force if force.real > 0 else 0.0) * stretched
            found.append(np.linalg.solve(stiffness, rows[..., i, None]))
        return np.pad(np.concatenate(found, axis=-1), ((0, 0), (0, 0), (0, self._own)))

    def _in_degrees(self, highest: int) -> FloatArray:
        """See `AttachmentModes`; of order 0."""
        found, inside = np.zeros((2, len(self.loads), highest + 1)), self._degrees <= highest
        found[:, :, self._degrees[inside]] = self._responses[inside].transpose(1, 2, 0)
        return found

    @cached_property
    def _twist_responses(self) -> FloatArray:
        """Twist of each degree under each load [m/N], then of the lowest degrees by themselves, (degree, shape)."""
        found = np.zeros((len(self._twists), len(self.loads) + self._own))
        if self.order:
            rows = [load.twist_rows(self._twists, self.order) for load in self.loads if isinstance(load, RingLoad)]
            shear = self.shell.shear_stiffness + np.maximum(self.tension, 0.0)
            found[:, : len(self.loads)] = np.transpose(rows) / (twisted(self._twists)[:, None] * shear)
            found[: self._own] = np.eye(self._own, found.shape[1], len(self.loads))
        return found

    @property
    def _elastic(self) -> FloatArray:
        """Elastic stiffness of each degree, (degree, 2, 2) [N/m]."""
        return np.asarray(membrane_block(self.shell, self._degrees) + bending_block(self.shell, self._degrees))

    @cached_property
    def _under_loads(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Mass, elastic stiffness and that of the tension over responses and twists, each (shape, shape).

        Tension is of degrees above N: what it does to twists below depends on where, see `twists`.
        """
        n, responses, tension = self._degrees, self._responses, np.pad(self.tension, (0, self._own))
        blocks = mass_block(self.shell, n), self._elastic, tension_block(n)
        mass, elastic, stretched = (
            np.einsum("nai,nab,nbj->ij", responses, block, responses, optimize=True) for block in blocks
        )
        twists, shear, far = (
            self._twist_responses,
            twisted(self._twists),
            np.flatnonzero(self._twists > max(self.degree, 1)),
        )
        mass = mass + (twists.T * twisting_mass(self.shell, self._twists)) @ twists
        elastic = elastic + self.shell.shear_stiffness * (twists.T * shear) @ twists
        stretched = stretched + (twists[far].T * shear[far]) @ twists[far]
        return mass, elastic, np.asarray(np.add.outer(tension, tension) / 2 * stretched)

    @cached_property
    def twists(self) -> tuple[IntArray, FloatArray]:
        """Degrees up to N that twist, and their amplitudes, shape (degree, mode) [-]: long enough for water and load.

        These see them as they do the shapes of the basis.
        """
        below = self._twists <= self.degree
        return self._twists[below], np.asarray(self._twist_responses[below] @ self._combinations)

    def displacement(self, colatitude: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return displacements along e_r, e_phi and e_theta at colatitudes [rad], each shape (mode, point) [-]."""
        at = np.asarray(colatitude, dtype=float)
        radial, along = np.moveaxis(self._responses @ self._combinations, 1, 0)
        s, slope, around = _harmonics(self._degrees, self.order, at)
        v, u, w = radial.T @ s, along.T @ slope, -along.T @ around
        if self.order:
            twist = (self._twist_responses @ self._combinations).T
            _, slope, around = _harmonics(self._twists, self.order, at)
            u, w = u + twist @ around, w - twist @ slope
        return v, u, w

    def mean_strains(self, upper: float, lower: float) -> tuple[FloatArray, FloatArray]:
        """Return the mean strains around the axis and along the meridian of a belt, each shape (mode,) [1/m]."""
        rows = np.stack([BeltLoad(upper, lower, *way).rows(self._degrees) for way in ((1.0, 0.0), (0.0, 1.0))])
        hoop, meridional = np.einsum("wna,naj->wj", rows, self._responses @ self._combinations) / self.shell.radius
        return hoop, meridional


def _harmonics(degrees: IntArray, order: int, colatitude: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """S, its derivative by phi and m S/sin(phi) of consecutive degrees, each (degree, point).

    P_n for m = 0, else Schmidt's functions by their recurrence in the degree, of S/sin(phi), regular at the poles: with
    k_n = sqrt(n^2 - m^2), k_n S_n = (2n - 1) cos(phi) S_(n-1) - k_(n-1) S_(n-2) and sin(phi) S_n' = n cos(phi) S_n -
    k_n S_(n-1).
    """
    cos, sin, highest = np.cos(colatitude), np.sin(colatitude), int(degrees[-1])
    if not order:
        p, by_cos = legendre_p_all(highest, cos, diff_n=1)
        return p[degrees], -sin * by_cos[degrees], np.zeros((len(degrees), len(cos)))
    over_sin = np.zeros((highest + 1, len(cos)))
    over_sin[order] = math.sqrt(2 / math.factorial(2 * order)) * factorial2(2 * order - 1) * sin ** (order - 1)
    n = np.arange(highest + 1)[:, None]
    k = np.sqrt(np.maximum(n**2 - order**2, 0))
    for i in range(order + 1, highest + 1):
        over_sin[i] = ((2 * i - 1) * cos * over_sin[i - 1] - k[i - 1] * over_sin[i - 2]) / k[i]
    slope = n[1:] * cos * over_sin[1:] - k[1:] * over_sin[:-1]
    return sin * over_sin[degrees], slope[degrees - 1], order * over_sin[degrees]


FINER = 2
"""Degree of the responses over that which resolves buckling, whose waves are those of bending about a ring [-]."""
MOST = 400
"""Degree of the responses at most."""
FLAT = 0.01
"""Least curvature of a wall around the axis, by ds/dphi, for the length over which it bends beside a load [-]."""
BESIDE_POLE = 1e-3
"""Distance from a pole at which its curvature is taken [rad]."""
GRADED = 0.3, 0.06, 0.012, 0.0024, 0.0005
"""Distances from a loaded pole between which the wall is integrated: bending there grows like a logarithm [rad]."""
ROUND_OFF = 1e-14
"""Part of the largest eigenvalue below which one is round-off: kinks of neighbouring rings are nearly alike [-]."""


Derivatives = tuple[FloatArray, FloatArray, FloatArray]
"""A displacement and its first two derivatives by phi, each shape (point,)."""


class _At(NamedTuple):
    """Points of a quadrature over the wall, displacements and strains there."""

    area: FloatArray  # (point,) [m^2]
    of: Displacements
    strains: Strains


class KinkModes(AttachmentModes):
    """Residual attachment modes of a shell of any meridian, of order 0; below `HIGHEST` of degrees alone.

    Displacements are those of degrees, and beside loaded rings and poles those of a wall there.
    """

    @cached_property
    def _rings(self) -> tuple[float, ...]:
        """Where displacements have kinks [rad]; at poles they have none."""
        if self.highest < HIGHEST:
            return ()
        at = list(self.shell.meridian.junctions)  # where the curvature jumps, too
        for load in self.loads:
            at += (load.upper, load.lower) if isinstance(load, BeltLoad) else (load.colatitude,)
        return tuple(sorted({phi for phi in at if abs(np.sin(phi)) > AT_POLE}, key=np.real))

    @cached_property
    def _poles(self) -> tuple[float, ...]:
        """The poles that are loaded, 1 the upper and -1 the lower one."""
        if self.highest < HIGHEST:
            return ()
        at = [load.colatitude for load in self.loads if isinstance(load, RingLoad)]
        return tuple(sorted({1.0 if np.real(phi) < 1 else -1.0 for phi in at if abs(np.sin(phi)) <= AT_POLE}))

    @property
    def resolved(self) -> int:
        """The highest degree that answers, beside kinks."""
        return self._finest

    @cached_property
    def _finest(self) -> int:
        """Degree of the displacements beside kinks; a tension T of the wall bends it within sqrt(D/T) of a ring."""
        if isinstance(self.stepped_from, KinkModes):
            return self.stepped_from._finest
        if self.highest < HIGHEST:
            return min(self.highest, MOST)
        tension = max(0.0, *self.tension)
        tight = math.ceil(self.shell.reach * math.sqrt(tension / self.shell.bending_stiffness))
        finest = max(FINER * max(converged_degree(self.shell), tight), self.degree + 20)
        return min(finest, MOST)

    def _kinks(self, phi: FloatArray) -> Displacements:
        """Displacements of the wall beside the rings, whose derivatives jump there, and under loads at poles."""
        found: list[list[FloatArray]] = [[] for _ in Displacements._fields]

        def add(part: Derivatives, way: tuple[FloatArray | float, ...]) -> None:
            for column, value in zip(found, [share * one for share in way for one in part], strict=True):
                column.append(value)

        w, dw, ddw = np.sin(phi) ** 2, np.sin(2 * phi), 2 * np.cos(2 * phi)  # regular at the poles
        for ring in self._rings:
            tangent, normal, rate = self._wall(ring)
            along, across = _edge_effect(phi - ring, rate)
            for way, parts in ((tangent, along), (normal, across)):
                for f, df, ddf in parts:
                    add((f * w, df * w + f * dw, ddf * w + 2 * df * dw + f * ddw), way)
        for pole in self._poles:
            *_, rate = self._wall(BESIDE_POLE if pole > 0 else math.pi - BESIDE_POLE)
            *across_wall, along_wall = _beside_pole(phi, pole, rate)
            for part in across_wall:
                add(part, (1, 0))
            add(along_wall, (0, 1))
        return Displacements(*(np.array(column).reshape(len(column), len(phi)) for column in found))

    def _wall(self, phi: float) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray], FloatArray]:
        """Tangent and normal at an angle, along e_r and e_phi, and beta ds/dphi: an edge effect falls like e^(-beta s).

        beta^4 = 3 (1 - nu^2)/(R h)^2, R the radius of curvature around the axis.
        """
        at, shell = curve(self.shell.meridian, np.array([phi])), self.shell
        slope, sin, cos = length(at.dx, at.dz)[0], np.sin(phi), np.cos(phi)
        tangent = (at.dx[0] * sin + at.dz[0] * cos) / slope, (at.dx[0] * cos - at.dz[0] * sin) / slope
        normal = -tangent[1], tangent[0]
        across = normal[0] * sin + normal[1] * cos
        curvature = max(across * np.sign(across.real) / at.x[0], FLAT / slope, key=np.real)
        beta = (3 * (1 - shell.poisson_ratio**2)) ** 0.25 * np.sqrt(curvature / shell.thickness)
        return tangent, normal, beta * slope

    def _displacements(self, phi: FloatArray) -> Displacements:
        """Displacements of degrees, then those with kinks."""
        pairs = zip(of_degrees(self._finest, phi), self._kinks(phi), strict=True)
        return Displacements(*(np.concatenate(pair) for pair in pairs))

    def _points(self, start: float, end: float) -> tuple[FloatArray, FloatArray]:
        """Colatitudes between two [rad], and weights of a rule for energies."""
        meridian = self.shell.meridian
        graded = {angle if pole > 0 else math.pi - angle for pole in self._poles for angle in GRADED}
        breaks = sorted({*meridian.junctions, *self._rings, *graded, start, end} - {0.0, math.pi}, key=np.real)
        phi, dphi = meridian_rule(breaks, 4 * self._finest + 64 + meridian.terms)
        inside = (start < np.real(phi)) & (np.real(phi) < end)
        return phi[inside], dphi[inside]

    def _at(self, start: float = 0.0, end: float = math.pi) -> _At:
        """What energies of the belt between two colatitudes need [rad]."""
        meridian, (phi, dphi) = self.shell.meridian, self._points(start, end)
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
        rows = rows - np.outer(rows @ rigid, weighed)
        count = self._finest + 1
        balanced = np.delete(np.arange(len(mass)), count)  # all but meridional degree 1, which heave stands for
        few = np.r_[0 : self.degree + 1, count + 1 : count + self.degree]
        found = np.zeros((len(mass), len(self.loads)), np.result_type(rows, elastic, *self.tension))
        for force in dict.fromkeys(self.tension):
            own = np.equal(self.tension, force)
            stiffness = elastic + (force if force.real > 0 else 0.0) * stretched
            found[:, own] = _static(stiffness, rows[own].T, balanced) - _static(stiffness, rows[own].T, few)
        return np.asarray(found - np.outer(rigid, weighed @ found))

    def _row(self, load: Load) -> FloatArray:
        """Work of a load on displacements, shape (displacement,) [-]; of a belt times the radius."""
        if isinstance(load, RingLoad):
            v, u = self._values(np.array([load.colatitude]))
            return load.radial * v[:, 0] + load.meridional * u[:, 0]
        if isinstance(load, PressureLoad):
            return self._under_pressure(load)
        hoop, meridional = self._of_belt(load.upper, load.lower)
        return self.shell.radius * (load.hoop * hoop + load.meridional * meridional)

    def _values(self, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Displacements along e_r and e_phi, each (displacement, point) [-]; at the poles, too."""
        inside = np.clip(colatitude, 1e-6, math.pi - 1e-6)
        of = self._displacements(inside)
        return of.v, of.u * (np.sin(colatitude) > AT_POLE)

    def _under_pressure(self, load: PressureLoad) -> FloatArray:
        """Work of a pressure on displacements, int p N.psi dA below the waterline, over 2 pi r^2."""
        phi, dphi = self._points(load.colatitude, math.pi)
        at, of, sin, cos = curve(self.shell.meridian, phi), self._displacements(phi), np.sin(phi), np.cos(phi)
        depth = curve(self.shell.meridian, np.array([load.colatitude])).z[0] - at.z
        outwards = (at.dx * cos - at.dz * sin) * of.v - (at.dx * sin + at.dz * cos) * of.u
        weight = at.x * (depth / self.shell.radius) ** load.power * dphi
        return np.asarray(outwards @ weight / self.shell.radius**2)

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

    def _in_degrees(self, highest: int) -> FloatArray:
        """See `AttachmentModes`: by orthogonality of Legendre's functions and of their derivatives."""
        ends = sorted(
            {*self._rings, *GRADED, *(math.pi - angle for angle in GRADED)} if self._poles else {*self._rings}
        )
        phi, dphi = meridian_rule(ends, 2 * (highest + self._finest) + 64)
        (v, u), (p, slope, _) = self._values(phi), _harmonics(np.arange(highest + 1), 0, phi)
        n, weight = np.arange(highest + 1), dphi * np.sin(phi) / 2
        radial = (self._responses.T @ v * weight) @ p.T * (2 * n + 1)
        along = (self._responses.T @ u * weight) @ slope.T * (2 * n + 1) / np.maximum(n * (n + 1), 1)
        return np.array([radial, along])

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


def _edge_effect(s: FloatArray, rate: FloatArray) -> tuple[list[Derivatives], list[Derivatives]]:
    """Displacements along the wall and normal to it beside a ring at s = 0, each with two derivatives.

    Along it |s|, where a membrane force jumps. The others are the edge effect (Geckeler 1926), with x = rate |s|:
    e^-x (cos x + sin x), where a transverse force jumps, and sign(s) e^-x sin x, where a moment does, normal to the
    wall, and their integrals along it.
    """
    sign = np.where(np.real(s) < 0, -1.0, 1.0)
    x = rate * sign * s
    fall, cos, sin = np.exp(-x), np.cos(x), np.sin(x)
    kink = sign * s, sign, 0 * s
    force = fall * (cos + sin), -2 * rate * sign * fall * sin, 2 * rate**2 * fall * (sin - cos)
    moment = sign * fall * sin, rate * fall * (cos - sin), -2 * rate**2 * sign * fall * cos
    of_force = sign * (1 - fall * cos), rate * force[0], rate * force[1]
    return [kink, of_force, force], [force, moment]


def _beside_pole(phi: FloatArray, pole: float, rate: FloatArray) -> tuple[Derivatives, ...]:
    """Displacements of the wall under a point load at a pole, each with two derivatives.

    With t = s^2 = 2 (1 -+ cos(phi)) they are t ln t and t^2 ln t normal to the wall and sin(phi) t ln t along it, all
    times e^(-rate^2 t/5): far from the pole degrees suffice.
    """
    sin, cos, k = np.sin(phi), np.cos(phi), rate**2 / 5
    t, dt, ddt = 2 - 2 * pole * cos, 2 * pole * sin, 2 * pole * cos
    log, near = np.log(t), np.exp(-k * t)
    e, de, dde = near, -k * dt * near, (k**2 * dt**2 - k * ddt) * near
    f = t * log, (log + 1) * dt, dt**2 / t + (log + 1) * ddt
    g = t**2 * log, (2 * log + 1) * t * dt, (2 * log + 3) * dt**2 + (2 * log + 1) * t * ddt
    h = sin * f[0], cos * f[0] + sin * f[1], sin * (f[2] - f[0]) + 2 * cos * f[1]
    return tuple((a * e, da * e + a * de, dda * e + 2 * da * de + a * dde) for a, da, dda in (f, g, h))


def _static(stiffness: FloatArray, loads: FloatArray, kept: IntArray) -> FloatArray:
    """Displacements under loads among those kept, shape (displacement, load); analytic in an imaginary step."""
    matrix, found = stiffness[np.ix_(kept, kept)], np.zeros(loads.shape, np.result_type(stiffness, loads))
    size = 1 / np.sqrt(np.diag(matrix.real))
    values, vectors = np.linalg.eigh(size[:, None] * matrix.real * size)
    known = values > ROUND_OFF * values[-1]
    vectors = size[:, None] * vectors[:, known]

    def solved(forces: FloatArray) -> FloatArray:
        return np.asarray(vectors @ ((vectors.T @ forces) / values[known, None]))

    found[kept] = solved(loads[kept].real)
    if np.iscomplexobj(found):
        found[kept] += 1j * solved((loads[kept] - matrix @ found[kept]).imag)
    return found
