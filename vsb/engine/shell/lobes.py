"""Linear buckling of a loaded shell of revolution into lobes around its axis, shapes of azimuthal order m >= 1.

Displacements s_x cos(m theta) away from the axis, s_z cos(m theta) along it and w sin(m theta) around it. With the
tangent t and the normal n of the meridian, s its length, and primes for derivatives by it, the displacement psi has

    e_s = t.psi_s,  e_theta = (s_x + m w)/x,  gamma = w' + t.psi_theta/x,
    beta_s = n.psi_s,  beta_theta = n.psi_theta/x,
    kappa_s = -beta_s',  kappa_theta = -(x' beta_s + m beta_theta)/x,
    2 kappa_stheta = (m beta_s + x' beta_theta)/x - beta_theta' + (k_theta - k_s)(w' - t.psi_theta/x)/2

(Sanders, Q. Appl. Math. 21, 1963; k are the curvatures of meridian and parallel; with m = 0 they are those of
`vsb.engine.shell.ritz`). The membrane forces of the load do work on half the squared gradient of psi. Pressure and
still water follow the shell. The load, its membrane forces and the axisymmetric buckling are those of
`vsb.engine.shell.loaded`.

On a smooth closed surface the Cartesian components of a smooth displacement are smooth: s_z is a sum of spherical
harmonics of order m, s_x + w of order m + 1 and s_x - w of order m - 1, in cos(phi) of the meridian's angle.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from vsb.engine.shell.deformed import DeformedShell, rigid_buoy
from vsb.engine.shell.loaded import Buckling, LoadedShell, Pencil, buckling
from vsb.engine.shell.meridian import Curve, bend, curve, gauss_rule, length, meridian_rule, parts
from vsb.engine.shell.modes import Mode, strain_shapes
from vsb.engine.shell.orders import Ballast, OrderBasis, geometric_stiffness
from vsb.engine.shell.shell import Shell, converged_degree
from vsb.tools.arrays import FloatArray

LEAST = 28
"""Least degree of displacements."""


class Displacement(NamedTuple):
    """Amplitudes away from the axis, around it and along it, and their derivatives by phi, each (shape, point) [-]."""

    x: FloatArray
    w: FloatArray
    z: FloatArray
    dx: FloatArray
    dw: FloatArray
    dz: FloatArray
    ddx: FloatArray
    ddz: FloatArray

    def around(self, order: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the components of the derivative by theta: away from the axis, around it, along it."""
        return -order * self.x - self.w, order * self.w + self.x, -order * self.z


def harmonics(order: int, degree: int, phi: FloatArray) -> FloatArray:
    """Return normalised associated Legendre functions of cos(phi) and two derivatives by phi, (3, function, point).

    Of degrees `order` to `degree`, int P^2 sin(phi) dphi = 1; analytic in phi, which lies between the poles.
    """
    sin, cos = np.sin(phi), np.cos(phi)
    n = np.arange(order, degree + 1)[:, None]
    ratio = np.sqrt((n**2 - order**2) / (4 * n**2 - 1))
    start = math.sqrt(math.prod(1 + 1 / (2 * i) for i in range(1, order + 1)) / 2)
    p = np.zeros((len(n) + 1, len(phi)), np.result_type(phi))  # row 0: of degree order - 1
    p[1] = start * sin**order
    for i in range(1, len(n)):
        p[i + 1] = (cos * p[i] - ratio[i - 1] * p[i - 1]) / ratio[i]
    before, p = p[:-1], p[1:]
    dp = (n * cos * p - (2 * n + 1) * ratio * before) / sin
    return np.array([p, dp, -cos / sin * dp - (n * (n + 1) - order**2 / sin**2) * p])


def displacements(order: int, degree: int, phi: FloatArray) -> Displacement:
    """Return displacements of an order m >= 1 whose Cartesian components are harmonics to a degree.

    Those of s_x - w, s_z and s_x + w, one after the other; the first of order 1 is surge.
    """
    apart, along, together = (harmonics(m, degree, phi) for m in (order - 1, order, order + 1))
    none = np.zeros_like
    x, dx, ddx = np.concatenate([apart, none(along), together], axis=1)
    w, dw, _ = np.concatenate([-apart, none(along), together], axis=1)
    z, dz, ddz = np.concatenate([none(apart), along, none(together)], axis=1)
    return Displacement(x, w, z, dx, dw, dz, ddx, ddz)


@lru_cache(maxsize=64)
def _at_nodes(order: int, degree: int, points: int, junctions: tuple[float, ...]) -> Displacement:
    """The same at the points of a quadrature along a meridian; not to be written to."""
    return displacements(order, degree, meridian_rule(junctions, points)[0])


class Strains(NamedTuple):
    """Strains and changes of curvature along, around and sheared, then gradients along and around the surface."""

    membrane: tuple[FloatArray, FloatArray, FloatArray]
    bending: tuple[FloatArray, FloatArray, FloatArray]
    along: tuple[FloatArray, FloatArray, FloatArray]
    around: tuple[FloatArray, FloatArray, FloatArray]


def strains(psi: Displacement, m: int, at: Curve, bent: tuple[FloatArray, FloatArray]) -> Strains:
    """Strains of displacements of order m on a meridian."""
    slope, (ddx, ddz) = length(at.dx, at.dz), bent
    tx, tz = at.dx / slope, at.dz / slope
    stretched = (at.dx * ddx + at.dz * ddz) / slope**2
    along = psi.dx / slope, psi.dw / slope, psi.dz / slope
    ax, aw, az = psi.around(m)
    around = ax / at.x, aw / at.x, az / at.x
    rotation, other = -tz * along[0] + tx * along[2], -tz * around[0] + tx * around[2]
    turned = (-ddz * psi.dx - at.dz * psi.ddx + ddx * psi.dz + at.dx * psi.ddz) / slope**2 - 2 * stretched * rotation
    dax, daz = -m * psi.dx - psi.dw, -m * psi.dz
    change = (-ddz * ax - at.dz * dax + ddx * az + at.dx * daz) / (slope * at.x)
    other_turned = change - other * (stretched + at.dx / at.x)
    sheared = tx * around[0] + tz * around[2]
    curved = -tz / at.x - (at.dz * ddx - at.dx * ddz) / slope**3
    twist = (m * rotation + tx * other) / at.x - other_turned / slope + curved * (along[1] - sheared) / 2
    return Strains(
        (tx * along[0] + tz * along[2], around[1], along[1] + sheared),
        (-turned / slope, -(tx * rotation + m * other) / at.x, twist),
        along,
        around,
    )


def _energy(parts: tuple[FloatArray, FloatArray, FloatArray], ratio: float, area: FloatArray) -> FloatArray:
    """Hessian of int [a^2 + b^2 + 2 nu a b + (1 - nu) c^2/2]/2 over areas."""
    a, b, c = parts
    first, second = a + ratio * b, b + ratio * a
    return np.asarray((area * first) @ a.T + (area * second) @ b.T + ((1 - ratio) / 2 * area * c) @ c.T)


def _follower(psi: Displacement, m: int, at: Curve, weight: FloatArray) -> FloatArray:
    """Return pi int psi_j.dN_k with N = r_phi x r_theta, weights those of dphi: the Hessian of a volume."""
    ax, aw, az = psi.around(m)
    changed = (-at.x * psi.dz - at.dz * aw, at.dz * ax - at.dx * az, at.x * psi.dx + at.dx * aw)
    each = zip((psi.x, psi.w, psi.z), changed, strict=True)
    return np.asarray(np.pi * sum((weight * one) @ other.T for one, other in each))


class Lobes(NamedTuple):
    """A shape the shell buckles into."""

    inverse_load_factor: float  # kappa: load over buckling load [-]
    order: int  # m: number of waves around the axis
    shape: FloatArray  # over `displacements`, x^T K_0 x = 1


@dataclass(frozen=True)
class LobedShell:
    """A loaded shell and the shapes of azimuthal orders m >= 1 that it may buckle into."""

    loaded: LoadedShell  # in a basis that resolves its membrane forces; also with a complex step
    degree: int  # of the displacements

    @classmethod
    def of(cls, loaded: LoadedShell) -> "LobedShell":
        """Return a loaded shell with displacements that resolve its buckling."""
        return cls(loaded, converged_degree(loaded.basis.shell, LEAST))

    @property
    def shell(self) -> Shell:
        """The shell itself."""
        return self.loaded.basis.shell

    def degree_of(self, order: int) -> int:
        """Return the highest degree of an order's displacements: `degree`, or half of it above the order."""
        return max(self.degree, order + self.degree // 2)

    @cached_property
    def points(self) -> int:
        """Points of the quadrature along the meridian."""
        degree = self.degree_of(math.ceil(self.most_lobes))
        return degree + self.loaded.basis.highest_degree // 2 + 2 * self.shell.meridian.terms + 40

    @cached_property
    def rings(self) -> tuple[Curve, tuple[FloatArray, FloatArray], FloatArray, tuple[FloatArray, FloatArray]]:
        """Meridian, its second derivatives, weights of dphi and membrane forces [N/m] at the points."""
        meridian = self.shell.meridian
        phi, dphi = meridian_rule(meridian.junctions, self.points)
        return curve(meridian, phi), bend(meridian, phi), dphi, self.loaded.linear_resultants(phi)

    @cached_property
    def wet(self) -> list[tuple[float, float]]:
        """Parts of the meridian under water [rad]."""
        return rigid_buoy(self.shell, self.loaded.centre_height).wet_segments

    @cached_property
    def most_lobes(self) -> float:
        """Number of lobes at which bending alone is as stiff as curvature makes a wall, the most along it.

        x k with k^4 = 12 (1 - nu^2) c^2/h^2, c the larger principal curvature: of shapes with more waves stiffness
        grows faster than the work of the membrane forces.
        """
        phi, shell = np.pi * (np.arange(200) + 0.5) / 200, self.shell
        at, (ddx, ddz) = shell.at_rest(phi), bend(shell.meridian, phi)
        slope = length(at.dx, at.dz)
        curved = (ddx * at.dz - at.dx * ddz) / slope**3, at.dz / (at.x * slope)
        curvature = np.maximum(*(np.abs(np.real(one)) for one in curved))
        wave = np.sqrt(math.sqrt(12 * (1 - shell.poisson_ratio.real**2)) * curvature / shell.thickness.real)
        return float((at.x.real * wave).max())

    def pencil(self, order: int, shapes: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Return K_0 and K_1 of K(L) = K_0 + L K_1 over displacements of an order, each (shape, shape) [N/m].

        As `vsb.engine.shell.loaded.buckling_pencil` of axisymmetric ones.

        Parameters
        ----------
        order : int
            Azimuthal order m >= 1.
        shapes : ndarray, shape (displacement, shape), optional
            Combinations of its `displacements` to `degree_of` it; all of them if not given.
        """
        shell, (at, bent, dphi, forces), degree = self.shell, self.rings, self.degree_of(order)
        psi = _combined(_at_nodes(order, degree, self.points, shell.meridian.junctions), shapes)
        found, nu, area = strains(psi, order, at, bent), shell.poisson_ratio, np.pi * at.x * length(at.dx, at.dz) * dphi
        elastic = shell.membrane_stiffness * _energy(found.membrane, nu, area)
        elastic = elastic + shell.bending_stiffness * _energy(found.bending, nu, area)
        meridional, hoop = (force * area for force in forces)
        load = np.asarray(sum((meridional * one) @ one.T for one in found.along))
        load = load + sum((hoop * one) @ one.T for one in found.around)
        if self.loaded.internal_pressure:
            load = load - self.loaded.pressure_inside * _follower(psi, order, at, dphi)
        load = load + self._water(order, shapes)
        return elastic, (load + load.T) / 2

    def _water(self, order: int, shapes: FloatArray | None) -> FloatArray:
        """Stiffness of still water, -rho g pi int [s_z psi.N + z psi.dN] over the wet shell, as of `DeformedShell`."""
        loaded, degree, found = self.loaded, self.degree_of(order), np.zeros(1)
        node, weight = gauss_rule(degree + self.shell.meridian.terms + 30)
        for a, b in (part for ends in self.wet for part in parts(self.shell.meridian.junctions, *ends)):
            phi, dphi = (a + b) / 2 + (b - a) / 2 * node, (b - a) / 2 * weight
            psi, at = _combined(displacements(order, degree, phi), shapes), self.shell.at_rest(phi)
            across = at.x * (at.dx * psi.z - at.dz * psi.x)
            found = found + np.pi * (across * dphi) @ psi.z.T
            found = found + _follower(psi, order, at, (loaded.centre_height + at.z) * dphi)
        return -loaded.water_density * loaded.gravity * found

    def buckling(self, count: int) -> list[Lobes]:
        """Return so many lobed shapes of the largest inverse load factors, descending.

        Eigenvalues kappa of -K_1 x = kappa K_0 x, order by order to `most_lobes`, and on while an order has one of the
        largest above zero.

        Notes
        -----
        The buoy heaves without surge and pitch: of order 1 the first two of `displacements` are left out. The first is
        surge, which costs nothing; without the second the rotation in the mean over the solid angle is zero.
        """
        order, found = 0, list[Lobes]()
        while order <= self.most_lobes or any(one.order == order and one.inverse_load_factor > 0 for one in found):
            order += 1
            elastic, load = self._without_rigid_motion(order)
            last = len(load) - 1
            kappa, x = eigh(-load, elastic, subset_by_index=[max(0, last + 1 - count), last])
            shapes = np.concatenate([np.zeros((_held(order), x.shape[1])), x]).T
            found += [Lobes(float(k), order, shape) for k, shape in zip(kappa, shapes, strict=True)]
            found = sorted(found, key=lambda one: -one.inverse_load_factor)[:count]
        return found

    def _without_rigid_motion(self, order: int) -> Pencil:
        """`pencil` over the displacements that strain the shell."""
        elastic, load = (matrix[_held(order) :, _held(order) :] for matrix in self.pencil(order))
        return elastic, load

    def pencils(self) -> list[Pencil]:
        """Return K_0 and K_1 of all orders to `most_lobes`."""
        return [self._without_rigid_motion(order) for order in range(1, math.ceil(self.most_lobes) + 1)]


def _held(order: int) -> int:
    """How many of the first displacements of an order are left out, see `LobedShell.buckling`."""
    return 2 if order == 1 else 0


def _combined(psi: Displacement, shapes: FloatArray | None) -> Displacement:
    """Combinations of displacements, or all as they are."""
    return psi if shapes is None else Displacement(*(shapes.T @ part for part in psi))


def with_lobes(loaded: LoadedShell) -> Buckling:
    """Return the linear buckling of a shell into axisymmetric and lobed shapes, whichever comes first."""
    found, (lobes,) = buckling(loaded), LobedShell.of(loaded).buckling(1)
    if lobes.inverse_load_factor <= 1 / found.load_factor:
        return found
    return replace(found, load_factor=1 / lobes.inverse_load_factor, order=lobes.order)


def azimuthal_stiffness(basis: OrderBasis, loaded: LoadedShell, q: FloatArray) -> FloatArray:
    """Return the tangent stiffness of shell, inner pressure and water, shape (dof, dof) [N/m]; 0 of rigid motions.

    Parameters
    ----------
    basis : OrderBasis
        Of the sphere.
    q : ndarray, shape (dof,) [m]
        Its heave and axisymmetric modes at rest.
    """
    stiffness = _elastic(basis, loaded, q) + _pressure(basis, loaded, q) + _water(basis, loaded, q)
    stiffness[: basis.rigid, :] = stiffness[:, : basis.rigid] = 0.0
    return np.asarray((stiffness + stiffness.T) / 2)


def _elastic(basis: OrderBasis, loaded: LoadedShell, q: FloatArray) -> FloatArray:
    """The wall's: material and geometric."""
    elastic, wall = loaded.elastic, basis.shell.wall
    colatitude, area = elastic.rings
    meridional, hoop, rotation = (1 + q @ elastic.shapes[0], 1 + q @ elastic.shapes[1], q @ elastic.shapes[2])
    r, m, sin, cos = basis.shell.radius, basis.order, np.sin(colatitude), np.cos(colatitude)
    (v, u, w), (dv, du, dw) = basis.field(colatitude), basis.field(colatitude, derivative=1)
    kappa, around, twist = basis.curvatures(colatitude)
    normal = (
        (meridional * (du + v) + rotation * (dv - u)) / r,
        hoop * (m * w + v * sin + u * cos) / (r * sin),
        kappa,
        around,
    )
    sheared = -meridional * (m * u + w * cos) - rotation * (m * v + w * sin)
    shear = (sheared / (r * sin) + hoop * dw / r, twist)
    moduli, half = wall.moduli(elastic.deformation(q)), area / 2  # cos^2 and sin^2 around
    found = geometric_stiffness(basis, colatitude, area, *elastic.resultants(q))
    for strains, by in ((normal, moduli.normal), (shear, moduli.shear)):
        for one, row in zip(strains, half * by, strict=True):
            found = found + one @ sum(c * other for c, other in zip(row, strains, strict=True)).T
    return np.asarray(found)


def _turned(
    basis: OrderBasis, loaded: LoadedShell, q: FloatArray, phi: FloatArray
) -> tuple[FloatArray, tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    """psi.N, psi and the change dN of N = r_phi x r_theta by each amplitude along e_r, e_phi, e_theta."""
    e, t, b = strain_shapes(loaded.basis, phi)
    r, m, sin, cos = basis.shell.radius, basis.order, np.sin(phi), np.cos(phi)
    across, along, around = r * (q @ b), r * (1 + q @ e), r * sin * (1 + q @ t)
    (v, u, w), (dv, du, _) = basis.field(phi), basis.field(phi, derivative=1)
    turn = m * w + v * sin + u * cos
    changed = (
        (du + v) * around + along * turn,
        -(dv - u) * around - across * turn,
        along * (m * v + w * sin) - across * (m * u + w * cos),
    )
    return around * (along * v - across * u), (v, u, w), changed


def _pressure(basis: OrderBasis, loaded: LoadedShell, q: FloatArray) -> FloatArray:
    """That of the pressure inside, -p d2V; trapped gas adds nothing, for the volume does not change."""
    cosine, weight = gauss_rule(2 * (basis.highest_degree + loaded.basis.highest_degree) + 16)
    phi = np.arccos(cosine)
    _, psi, changed = _turned(basis, loaded, q, phi)
    dphi = weight / np.sin(phi)
    volume = sum((one * dphi) @ other.T for one, other in zip(psi, changed, strict=True))
    return np.asarray(-np.pi * loaded.pressure(q) * volume)


def _water(basis: OrderBasis, loaded: LoadedShell, q: FloatArray) -> FloatArray:
    """That of the water, -rho g int [psi_z psi.N + z psi.dN] over the wet shell."""
    shape = DeformedShell(loaded.basis, loaded.centre_height, q)
    node, weight = gauss_rule(2 * (basis.highest_degree + loaded.basis.highest_degree) + 30)
    found = np.zeros((len(basis.labels),) * 2)
    for a, b in shape.wet_segments:
        phi, dphi = (a + b) / 2 + (b - a) / 2 * node, (b - a) / 2 * weight
        across, psi, changed = _turned(basis, loaded, q, phi)
        raised = psi[0] * np.cos(phi) - psi[1] * np.sin(phi)
        height = shape.curve(phi).z * dphi
        found += (across * dphi) @ raised.T
        found += sum((one * height) @ other.T for one, other in zip(psi, changed, strict=True))
    return -np.pi * loaded.water_density * loaded.gravity * found


def complete_order(loaded: LoadedShell, order: int, degree: int) -> OrderBasis:
    """Return all gradient shapes of an order to a degree, radial and meridional ones apart."""
    modes = []
    for n in range(max(2, order), degree + 1):
        modes += [Mode(f"Radial{n}c{order}", n, 1.0, 0.0), Mode(f"Meridional{n}c{order}", n, 0.0, 1 / n)]
    shell = loaded.basis.shell
    return OrderBasis(shell, order, tuple(modes), Ballast(loaded.basis.total_mass, 0.0, 0.0), bending=True)


def softest_order(loaded: LoadedShell, q: FloatArray, orders: int, degree: int) -> tuple[float, int]:
    """Return the least stiffness about a rest shape over that of the unloaded shell, and its order, of 2 to `orders`.

    Below 0 the shell buckles or wrinkles into it.
    """
    found = []
    for order in range(2, orders + 1):
        basis = complete_order(loaded, order, degree)
        stiffness = azimuthal_stiffness(basis, loaded, q)
        found.append((float(eigh(stiffness, basis.stiffness, eigvals_only=True, subset_by_index=[0, 0])[0]), order))
    return min(found)
