"""Radiation and diffraction in deep water by boundary elements of spectral order, for shells with one smooth wet side.

No panels: potentials are polynomials in a parameter of the meridian that crowds its points to the waterline, where
they have weak singularities. With K = omega^2/g, Z = z + z' and phasors exp(-i omega t),

    G = 1/r + 1/r' + 2K PV int_0^inf e^{kZ} J0(k rho)/(k - K) dk + 2 pi i K e^{KZ} J0(K rho),

whose mean over the azimuth has J0(kR) J0(kR') in place of J0(k rho). With n out of the body, on it

    2 pi phi(x) - int phi dG/dn' dS' = -int G w dS'      (radiation by the normal velocity w)
                                     = 4 pi phi_I(x)     (total potential of incident wave and fixed body)

and the same without 2 pi phi at points inside the body, which pins down what the surface alone leaves open at the
eigenfrequencies of the water inside ("irregular frequencies").
"""

import itertools
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.special import ellipe, ellipkm1, j0, j1, roots_legendre

from vsb.errors import ConfigError
from vsb.modes import normal_velocities
from vsb.surface import DeformedShell
from vsb.units import ComplexArray, FloatArray
from vsb.waves import wavenumber

_CROWDING = 3
"""Power of t the distance r from the waterline grows with: r log r becomes t^3 log t. Whole, for a smooth shell."""
_KEEL_SLOPE = 1.5
"""Rate of the colatitude at the keel, in terms of equal spacing."""
_INTERIOR = (0.02, 0.15, 0.4)
"""Depths of the points inside, in drafts: on the axis below the surface every eigenfunction is at its largest."""
_CUTOFF = 6.0
"""Wavenumber, in largest wavenumbers, beyond which the waves' part is a Laplace transform instead of a quadrature."""
_NEGLIGIBLE = 23.0
"""Exponent of what is left out of the transform, 1e-10; more would amplify the round-off of its small integrand."""
_COARSER = 0.75
"""Resolution of the run that estimates the error."""


@cache
def _unit_rule(points: int) -> tuple[FloatArray, FloatArray]:
    """Gauss-Legendre nodes and weights on [0, 1], each shape (points,)."""
    node, weight = roots_legendre(points)
    return (node + 1) / 2, weight / 2


@cache
def log_rule(points: int = 24, degree: int = 10) -> tuple[FloatArray, FloatArray]:
    """Return nodes and weights on [0, 1], each shape (points,), of a rule for f + g log u with smooth f and g.

    Nodes u = v^2 of Gauss' rule in v; its weights are moved as little as makes u^p and u^p log u exact for p < degree.
    """

    def moments(u: FloatArray) -> FloatArray:
        p = np.polynomial.legendre.legvander(2 * u - 1, degree - 1).T
        return np.concatenate([p, p * np.log(u)])

    (v, w), (fine_v, fine_w) = _unit_rule(points), _unit_rule(200)
    weight, rows = 2 * v * w, moments(v**2)
    exact = moments(fine_v**6) @ (6 * fine_v**5 * fine_w)
    return v**2, weight + np.linalg.lstsq(rows, exact - rows @ weight, rcond=1e-13)[0]


def ring(source: FloatArray, apart: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return int_0^{2 pi} d theta/r of a ring, p, and c, d of its gradient at the source, c e_R + d (apart, -height).

    `source` is the radius of the ring, `apart` by how much the point's exceeds it, `height` the point's above it [m].
    p = 4 K(m)/r1, c = 2 (E - K)/(R' r1), d = 4 E/(r1 r2^2) with r1, r2 the largest and least distances and
    1 - m = (r2/r1)^2. Nothing is subtracted but E - K: the distance itself is the argument.
    """
    near = np.maximum(apart**2 + height**2, 1e-300)
    far = near + 4 * source * (source + apart)
    root = np.sqrt(far)
    k, e = ellipkm1(near / far), ellipe(1 - near / far)
    return 4 * k / root, 2 * (e - k) / (source * root), 4 * e / (root * near)


class Points(NamedTuple):
    """Points of the wet meridian, each shape (point,)."""

    x: FloatArray  # radius [m]
    z: FloatArray  # height [m]
    n_x: FloatArray  # unit normal out of the body
    n_z: FloatArray
    rate: FloatArray  # x ds/dt, area per radian of azimuth and unit of t [m^2]
    colatitude: FloatArray  # on the undeformed sphere [rad]

    def influence(self, apart: FloatArray, height: FloatArray, sign: float) -> FloatArray:
        """Return potential and normal derivative of rings here (sign -1) or their images (1), shape (2, ..., point).

        `apart` and `height` lead from the (mirrored) rings to the points of influence.
        """
        potential, along, across = ring(self.x, apart, height)
        return np.stack([potential, self.n_x * along + across * (self.n_x * apart - sign * self.n_z * height)])

    def wave(self, k: FloatArray) -> FloatArray:
        """Return e^{kz} J0(kx) and its normal derivative, shape (2, point, wavenumber)."""
        kx, decay = np.outer(self.x, k), np.exp(np.outer(self.z, k))
        return decay * np.stack([j0(kx), k * (self.n_z[:, None] * j0(kx) - self.n_x[:, None] * j1(kx))])


def _rule_about(t: float) -> tuple[FloatArray, FloatArray]:
    """Distances from t and weights of a rule on [0, 1] for a logarithm at t and its mirror images beyond both ends."""
    offsets, weights = [], []
    for sign, end in ((-1, t), (1, 1 - t)):
        doubling = 2.0 ** np.arange(np.ceil(np.log2(2 * end / min(t, 1 - t) + 1)) + 1) - 1
        edges = doubling * end / doubling[-1]
        for a, b in itertools.pairwise(edges):
            u, w = _unit_rule(16) if a else log_rule()
            offsets.append(sign * (a + (b - a) * u))
            weights.append((b - a) * w)
    return np.concatenate(offsets), np.concatenate(weights)


@dataclass(frozen=True)
class WetMeridian:
    """The wet side of a shell at Gauss points in t, 0 at the waterline and 1 at the keel."""

    shell: DeformedShell
    nodes: int

    @cached_property
    def waterline(self) -> float:
        """Colatitude of the waterline [rad]; `ConfigError` if the shell at rest does not cross the water once."""
        wet = self.shell.wet_segments
        if len(wet) != 1 or wet[0][0] == 0.0 or wet[0][1] < np.pi:
            raise ConfigError(
                f"reference_shape: received a shape whose wet parts are {wet} rad; needs one waterline with the keel "
                "below it: change device.mass or device.internal_pressure"
            )
        return wet[0][0]

    def _colatitude(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Colatitude and its rate by t: from the waterline by t^q (1 + (q - s)(1 - t)), s the slope at the keel."""
        q, extra, span = _CROWDING, _CROWDING - _KEEL_SLOPE, np.pi - self.waterline
        rate = span * t ** (q - 1) * (q * (1 + extra * (1 - t)) - extra * t)
        return self.waterline + span * t**q * (1 + extra * (1 - t)), rate

    def chord(self, start: FloatArray, offset: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the way from t = start on by `offset`, radial and vertical, each shape (point,) [m].

        As an integral of the slope: a difference of coordinates near the waterline would be all round-off.
        """
        v, w = _unit_rule(16)
        phi, rate = self._colatitude((start[:, None] + offset[:, None] * v).ravel())
        m = self.shell.meridian(phi)
        dx, dz = (offset * ((slope * rate).reshape(-1, len(v)) @ w) for slope in (m.dx, m.dz))
        return dx, dz

    def at(self, t: FloatArray) -> Points:
        """Return the points at t."""
        phi, rate = self._colatitude(t)
        m = self.shell.meridian(phi)
        length = np.hypot(m.dx, m.dz)
        _, z = self.chord(np.zeros_like(t), t)
        return Points(m.x, z, -m.dz / length, m.dx / length, m.x * length * rate, phi)

    @cached_property
    def points(self) -> Points:
        """The shell at the Gauss points."""
        return self.at(_unit_rule(self.nodes)[0])

    @cached_property
    def areas(self) -> FloatArray:
        """Area per radian of azimuth that each node stands for, shape (node,) [m^2]."""
        return _unit_rule(self.nodes)[1] * self.points.rate

    @cached_property
    def targets(self) -> tuple[FloatArray, FloatArray]:
        """Radius and height of the equations' points: nodes, then inside, each shape (target,) [m]."""
        inside = self.shell.meridian(np.array([np.pi])).z * np.array(_INTERIOR)
        return np.concatenate([self.points.x, 0 * inside]), np.concatenate([self.points.z, inside])

    def interpolation(self, t: FloatArray) -> FloatArray:
        """Return the values at t of the polynomials that are one at one node, shape (point, node); barycentric."""
        node, weight = _unit_rule(self.nodes)
        scale = (-1.0) ** np.arange(self.nodes) * np.sqrt(node * (1 - node) * weight)
        apart = t[:, None] - node
        terms = scale / np.where(apart == 0.0, 1e-300, apart)
        return np.asarray(terms / terms.sum(axis=1, keepdims=True))

    def _singular_row(self, i: int) -> FloatArray:
        """Integrals over the shell of 1/r, 1/r' at node i, shape (2 sources, 2 potential and derivative, node)."""
        start = _unit_rule(self.nodes)[0][i]
        offset, weight = _rule_about(float(start))
        points = self.at(start + offset)
        dx, dz = self.chord(np.full_like(offset, start), offset)
        values = np.stack([points.influence(-dx, h, s) for h, s in ((-dz, -1.0), (self.points.z[i] + points.z, 1.0))])
        return np.asarray((values * weight * points.rate) @ self.interpolation(start + offset))

    @cached_property
    def rankine(self) -> FloatArray:
        """Influence of 1/r and 1/r', shape (2 sources, 2 potential and derivative, target, node) [m, -]."""
        on = np.stack([self._singular_row(i) for i in range(self.nodes)], axis=2)
        p, z = self.points, self.targets[1][self.nodes :, None]
        inside = np.stack([p.influence(-p.x, z + sign * p.z, sign) for sign in (-1.0, 1.0)])
        return np.concatenate([on, inside * self.areas], axis=2)

    def solve(self, double: ComplexArray, right: ComplexArray) -> ComplexArray:
        """Return phi of 2 pi phi - D phi = right on the nodes and -D phi = right inside, shape (node, column).

        Least squares in the norm of the surface; an interior equation counts as much as all of the surface.
        """
        root = np.sqrt(self.areas)
        rows = np.concatenate([root, np.full(len(_INTERIOR), np.sqrt(root @ root))])[:, None]
        matrix = -double * rows / root
        matrix[: self.nodes] += 2 * np.pi * np.eye(self.nodes)
        adjoint = matrix.conj().T
        return np.asarray(np.linalg.solve(adjoint @ matrix, adjoint @ (rows * right)) / root[:, None])


def second_kind(count: int, x: FloatArray) -> FloatArray:
    """Return Legendre's Q_n on the cut at 2x - 1 for 0 < x < 1 and n < count, shape (count, point) [-]."""
    argument = 2 * x - 1
    q = np.empty((count, len(x)))
    q[0] = 0.5 * np.log(x / (1 - x))
    q[1] = argument * q[0] - 1
    for n in range(1, count - 1):
        q[n + 1] = ((2 * n + 1) * argument * q[n] - n * q[n - 1]) / (n + 1)
    return q


@dataclass(frozen=True)
class WavePart:
    """The waves' part of Green's function between the equations' points and the nodes, up to a largest wavenumber.

    Below the cutoff kc the integral over k is Gauss' with weights that take the pole exactly (polynomials times
    1/(k - K) are Legendre's Q). Above it, 1/(k - K) = int_0^inf e^{-(k-K)s} ds turns the slowly decaying rest into

        2K int_0^inf e^{Ks} T(Z - s) ds,   T(Z) = int_kc^inf e^{kZ} J0(kR) J0(kR') dk = [1/r'] - int_0^kc ... dk

    with T in closed form, independent of frequency, and smaller than e^{-kc s}: tabulated once.
    """

    meridian: WetMeridian
    largest: float  # [1/m]

    @cached_property
    def wavenumbers(self) -> tuple[FloatArray, FloatArray]:
        """Gauss points and weights from 0 to kc, in terms of kc, each shape (wavenumber,) [-]; J0^2 turns 2 kc R."""
        return _unit_rule(int(40 + _CUTOFF * self.largest * self.meridian.points.x.max()))

    @cached_property
    def factors(self) -> tuple[FloatArray, FloatArray]:
        """e^{kz} J0(kR) of targets, (target, wavenumber); of nodes, with derivative, (2, wavenumber, node)."""
        x, z = self.meridian.targets
        k = _CUTOFF * self.largest * self.wavenumbers[0]
        return np.exp(np.outer(z, k)) * j0(np.outer(x, k)), self.meridian.points.wave(k).swapaxes(1, 2).copy()

    @cached_property
    def lengths(self) -> tuple[FloatArray, FloatArray]:
        """Nodes s of the Laplace transform and their weights, each shape (length,) [m]; ever finer to s = 0."""
        u, w = _unit_rule(32)
        end = _NEGLIGIBLE / ((_CUTOFF - 1) * self.largest)
        return end * u**4, end * 4 * u**3 * w

    @cached_property
    def tail(self) -> FloatArray:
        """T and its derivative by the source's normal, summed over the azimuth, shape (length, 2, target, node)."""
        (x, z), p, (at, source) = self.meridian.targets, self.meridian.points, self.factors
        k, w = (_CUTOFF * self.largest * a for a in self.wavenumbers)
        apart, height = x[:, None] - p.x, z[:, None] + p.z
        whole = [p.influence(apart, height - s, 1.0) for s in self.lengths[0]]
        below = [(at * (2 * np.pi * w * np.exp(-k * s))) @ source for s in self.lengths[0]]
        return np.asarray(np.array(whole) - np.array(below))

    def pole_weights(self, k: FloatArray) -> FloatArray:
        """Return the weights of PV int_0^kc f(k')/(k' - k) dk' on the Gauss points, shape (k, wavenumber) [-]."""
        node, weight = self.wavenumbers
        degree = np.arange(len(node))
        p = np.polynomial.legendre.legvander(2 * node - 1, degree[-1]) * (2 * degree + 1)
        return np.asarray(-2 * weight * (p @ second_kind(len(node), k / (_CUTOFF * self.largest))).T)

    def influence(self, k: float, pole_weights: FloatArray) -> ComplexArray:
        """Return potential and derivative, (2, target, node): 2K(PV int + Laplace) + 2 pi i K e^{KZ} J0 J0."""
        (at, source), (s, w), (x, z) = self.factors, self.lengths, self.meridian.targets
        real = (at * (2 * np.pi * pole_weights)) @ source + np.tensordot(w * np.exp(k * s), self.tail, 1)
        outgoing = (np.exp(k * z) * j0(k * x))[:, None] * self.meridian.points.wave(np.array([k])).swapaxes(1, 2)
        return np.asarray(2 * k * (real + 2j * np.pi**2 * outgoing))


@dataclass(frozen=True)
class SpectralProblem:
    """Radiation and diffraction in deep water of prescribed displacements of the immersed shell.

    Radial<n> is P_n(cos phi) along e_r, Meridional<n> is dP_n/dphi along e_phi, phi the colatitude on the undeformed
    sphere, as in `vsb.bem.AxisymmetricProblem`; conventions and results are the same.
    """

    shell: DeformedShell
    displacements: tuple[str, ...]
    density: float
    gravity: float
    nodes: int = 32

    @cached_property
    def meridian(self) -> WetMeridian:
        """The wet side of the shell."""
        return WetMeridian(self.shell, self.nodes)

    @cached_property
    def velocities(self) -> FloatArray:
        """Normal velocities of the displacements at the nodes, shape (displacement, node) [m/s per m/s]."""
        points = self.meridian.points
        return normal_velocities(self.displacements, points.colatitude, (points.n_x, points.n_z))

    @cached_property
    def _onto(self) -> FloatArray:
        """Generalized force of a unit potential at the nodes, -rho w_i dS, shape (displacement, node)."""
        return -2 * np.pi * self.density * self.velocities * self.meridian.areas

    def _limit(self, image: float) -> FloatArray:
        """Added mass with G = 1/r + image/r', shape (displacement, displacement) [kg]."""
        single, double = self.meridian.rankine[0] + image * self.meridian.rankine[1]
        return np.real(self._onto @ self.meridian.solve(double + 0j, -single @ self.velocities.T + 0j))

    def at_infinity(self) -> FloatArray:
        """Added mass at infinite frequency, where the potential vanishes at z = 0 [kg]."""
        return self._limit(-1.0)

    def at_zero(self) -> FloatArray:
        """Added mass at frequency zero, where the water's surface is a wall [kg]."""
        return self._limit(1.0)

    def solve(self, omegas: list[float]) -> xr.Dataset:
        """Solve at positive, finite frequencies (else: `ConfigError`); dataset as of `vsb.bem.AxisymmetricProblem`."""
        if not omegas or not all(0 < omega < np.inf for omega in omegas):
            raise ConfigError(f"omega: received {omegas} rad/s; needs positive, finite frequencies")
        k = np.array([wavenumber(omega, np.inf, self.gravity) for omega in omegas])
        part = WavePart(self.meridian, float(k.max()))
        columns = [self._at(part, *each) for each in zip(omegas, k, part.pole_weights(k), strict=True)]
        names = "added_mass", "radiation_damping", "Froude_Krylov_force", "diffraction_force"
        pair, wave = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
        arrays = zip((pair, pair, wave, wave), map(np.array, zip(*columns, strict=True)), strict=True)
        dofs = {name: list(self.displacements) for name in pair[1:]}
        return xr.Dataset(dict(zip(names, arrays, strict=True)), {"omega": omegas, "wave_direction": [0.0], **dofs})

    def _at(
        self, part: WavePart, omega: float, k: float, pole_weights: FloatArray
    ) -> tuple[FloatArray | ComplexArray, ...]:
        """Added mass, damping, Froude-Krylov and diffraction force at one frequency.

        Pressure i omega rho phi, so A + iB/omega = -rho int phi_j w_i dS; incident wave -i g/omega e^{kz} J0(kR).
        """
        m = self.meridian
        x, z = m.targets
        single, double = m.rankine.sum(axis=0) + part.influence(k, pole_weights) * m.areas
        incident = np.exp(k * z) * j0(k * x)
        right = np.column_stack([-single @ self.velocities.T, 4 * np.pi * incident])
        potential = self._onto @ m.solve(double, right)
        froude_krylov = self.gravity * (self._onto @ incident[: m.nodes]).astype(complex)
        radiated, total = potential[:, :-1], self.gravity * potential[:, -1]
        return radiated.real, omega * radiated.imag, froude_krylov[None], (total - froude_krylov)[None]

    def error_estimate(self, omegas: list[float]) -> xr.Dataset:
        """Return estimates of the errors of a run, relative to the largest entry at each frequency.

        Twice the largest difference from a run with three quarters of the points, whose own error is the larger one;
        for damping and excitation also that from Haskind's damping omega^3 X X^H/(2 rho g^3): what both have wrong.
        """
        runs = [p.solve(omegas) for p in (replace(self, nodes=int(_COARSER * self.nodes)), self)]
        forces = [(ds.Froude_Krylov_force + ds.diffraction_force).values[:, 0] for ds in runs]
        scale = np.array(omegas)[:, None, None] ** 3 / (2 * self.density * self.gravity**3)
        haskind = scale * forces[1][:, :, None] * forces[1][:, None, :].conj()
        missed = _relative(haskind, runs[1].radiation_damping.values)
        errors = {
            "added_mass": _relative(*(ds.added_mass.values for ds in runs)),
            "radiation_damping": _relative(*(ds.radiation_damping.values for ds in runs)) + missed,
            "excitation_force": _relative(*forces) + missed,
        }
        return xr.Dataset({name: ("omega", 2 * e) for name, e in errors.items()}, coords={"omega": omegas})


def _relative(other: ComplexArray, value: ComplexArray) -> FloatArray:
    """Largest difference at each frequency in terms of the largest value there, shape (omega,)."""
    difference, size = (np.abs(a).reshape(len(value), -1).max(axis=1) for a in (other - value, value))
    return np.asarray(difference / size)
