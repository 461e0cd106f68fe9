"""Shapes of the shell of azimuthal order m >= 1, and the rigid motions among them: surge and pitch of order 1.

Of each order there are two families: even ones in y, which go with cos(m theta) and move in the plane of waves along x,
and odd ones, the same turned by 90 degrees/m, which go with sin(m theta): sway, roll and their shell modes. Yaw is the
one odd motion of order 0.

A shape of degree n is v = V S_n^m(cos phi) cos(m theta) along e_r, and along the surface U times its gradient on the
unit sphere: u = U S' cos(m theta) along e_phi, w = -U m S/sin(phi) sin(m theta) along e_theta. S is Schmidt's
semi-normalised function, sqrt(2 (n-m)!/(n+m)!) P_n^m. A closed sphere looks the same from every direction: in (V, U)
its energies are those of m = 0, degree by degree. Surge is n = 1, V = U = 1. Pitch, about the sphere's centre, is no
gradient; shapes of its kind twist the shell and move no water. Neither strain nor inertia couples them to these, but a
clamp or a port at a ring does: what they and the gradients of higher degrees do under such loads is a mode of rings
(`vsb.engine.shell.rings`).

Prestress of the sphere for m >= 1: the membrane forces of the load at rest do work on the second-order part of Green's
strains, half the squared gradient of the displacement along each line of the surface, and the internal pressure on the
second-order part of the volume. Neither depends on the buoy's attitude, so rigid motions have none.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import factorial, sqrt
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag
from scipy.special import eval_gegenbauer, factorial2

from vsb.engine.shell.device import Device
from vsb.engine.shell.loaded import LoadedShell
from vsb.engine.shell.meridian import gauss_rule
from vsb.engine.shell.modes import (
    POINTS,
    SAME,
    Mode,
    ModeBasis,
    largest_along,
    mass_of,
    null_space,
    stiffness_of,
    strain_shapes,
)
from vsb.engine.shell.rings import RingModes
from vsb.engine.shell.shell import Shell
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray

RIGID = {False: ("Surge", "Pitch"), True: ("Sway", "Roll")}
"""Rigid motions of order 1 of the even and the odd family, before the modes: amplitudes are metres and radians."""


def semi_normalisation(degree: int, order: int) -> float:
    """Return S_n^m over P_n^m, sqrt(2 (n-m)!/(n+m)!) for m >= 1 [-]."""
    return sqrt(2 * factorial(degree - order) / factorial(degree + order))


def semi_normalised(degree: int, order: int, colatitude: FloatArray) -> FloatArray:
    """Return S_n^m(cos phi) of m >= 1, its first and second derivative by phi, S/sin(phi) and its, shape (5, point).

    From sin^m(phi) times the m-th derivative of P_n, (2m-1)!! C_(n-m)^(m+1/2) of Gegenbauer, regular at the poles.
    """
    cos, sin, m = np.cos(colatitude), np.sin(colatitude), order
    q, by_cos, twice = (
        semi_normalisation(degree, order) * factorial2(2 * k - 1) * eval_gegenbauer(degree - k, k + 0.5, cos)
        if degree >= k
        else 0.0 * cos
        for k in (m, m + 1, m + 2)
    )
    dq, ddq = -sin * by_cos, sin**2 * twice - cos * by_cos
    beside = (m - 1) * sin ** max(m - 2, 0) * cos  # derivative of sin^(m-1)
    slope = m * sin ** (m - 1) * cos
    bend = m * (beside * cos - sin**m)
    around = sin ** (m - 1)
    return np.array(
        [
            sin**m * q,
            slope * q + sin**m * dq,
            bend * q + 2 * slope * dq + sin**m * ddq,
            around * q,
            beside * q + around * dq,
        ]
    )


class Field(NamedTuple):
    """Displacements per unit amplitude along e_r, e_phi and e_theta, each shape (dof, point).

    The first two go with cos(m theta), the last with sin(m theta); of the odd family with sin and with -cos.
    """

    radial: FloatArray
    meridional: FloatArray
    azimuthal: FloatArray


class Ballast(NamedTuple):
    """Mass and balance of the whole buoy."""

    total_mass: float  # [kg]
    centre_of_mass: float  # of the whole buoy above the sphere's centre [m]
    inertia: float  # of the ballast about its own centre of mass, transverse [kg m^2]
    yaw_inertia: float = 0.0  # of the ballast about the vertical axis; of yaw alone [kg m^2]


def ballast_of(device: Device) -> Ballast:
    """Return mass and balance of a device.

    Raises `ConfigError` if the device does not give them.
    """
    if device.centre_of_mass is None or device.ballast_inertia is None:
        raise ConfigError("device: received no centre_of_mass or no ballast_inertia; pitch needs both.")
    return Ballast(device.mass, device.centre_of_mass, device.ballast_inertia, device.ballast_yaw_inertia or 0.0)


@dataclass(frozen=True)
class OrderBasis:
    """Degrees of freedom of one azimuthal order and family: of order 1 two rigid motions, then the shell modes."""

    shell: Shell
    order: int
    modes: tuple[Mode, ...]  # shapes of m >= 1 by (V, U) of S_n^m
    ballast: Ballast
    bending: bool  # whether the energy of bending is part of the stiffness
    alpha: float = 0.0  # mass-proportional damping [1/s]
    beta: float = 0.0  # stiffness-proportional damping [s]
    odd: bool = False  # in y: going with sin(m theta)
    rings: RingModes | None = None  # what twists and higher degrees do under loads at rings

    @property
    def signed(self) -> int:
        """Azimuthal order, negative of the odd family, as real spherical harmonics are numbered."""
        return -self.order if self.odd else self.order

    @property
    def highest_degree(self) -> int:
        """Highest Legendre degree of its shapes."""
        return max(mode.degree for mode in self._shapes)

    @property
    def rigid(self) -> int:
        """How many of the degrees of freedom, the first, are rigid motions."""
        return len(RIGID[self.odd]) if self.order == 1 else 0

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the degrees of freedom."""
        return (*RIGID[self.odd][: self.rigid], *(mode.label for mode in self._of_shell))

    def turned(self) -> "OrderBasis":
        """Return the odd family, this one turned by 90 degrees/m: Membrane3c2 becomes Membrane3s2."""
        named = (replace(m, label=m.label.replace(f"c{self.order}", f"s{self.order}")) for m in self.modes)
        return replace(self, modes=tuple(named), odd=True)

    @property
    def _signs(self) -> FloatArray:
        """Signs that turn rigid motions with the shapes: pitch turned by 90 degrees is negative roll."""
        signs = np.ones(len(self.labels))
        signs[1 : self.rigid] = -1.0 if self.odd else 1.0
        return signs

    @cached_property
    def _of_shell(self) -> tuple[Mode, ...]:
        """Its modes, then those of rings, whose radial displacements and gradients are too short to be seen."""
        labels = self.rings.labels if self.rings else ()
        family = "s" if self.odd else "c"
        return (*self.modes, *(Mode(one.replace("c", family), self.order, 0.0, 0.0) for one in labels))

    @cached_property
    def _shapes(self) -> tuple[Mode, ...]:
        """All shapes but pitch: in order 1 surge, then those of the shell."""
        return (Mode("Surge", 1, 1.0, 1.0), *self._of_shell) if self.rigid else self._of_shell

    @property
    def radial(self) -> list[tuple[int, float]]:
        """Degree and amplitude of the radial displacement of each degree of freedom [-]; of pitch none."""
        surge = [(1, 1.0), (1, 0.0)][: self.rigid]
        return [*surge, *((mode.degree, mode.radial) for mode in self._of_shell)]

    def of_rings(self, matrix: FloatArray) -> FloatArray:
        """Return a matrix over the modes of rings as one over all degrees of freedom, shape (dof, dof)."""
        return np.pad(matrix, (len(self.labels) - len(matrix), 0))

    def _with_pitch(self, matrix: FloatArray, row: FloatArray) -> FloatArray:
        """A matrix over the shapes with the row and column of pitch, `row` over (pitch, shapes); none of m > 1."""
        if not self.rigid:
            return matrix
        out = np.insert(np.insert(matrix, 1, row[1:], axis=0), 1, 0.0, axis=1)
        out[:, 1] = np.insert(row[1:], 1, row[0])
        return out * np.outer(self._signs, self._signs)

    @cached_property
    def _shell_mass(self) -> FloatArray:
        """Mass of the shell alone over the shapes; row 0 in order 1 is the momentum along x, int psi_x dm [kg]."""
        return mass_of(self.shell, self._shapes)

    @cached_property
    def inertia(self) -> FloatArray:
        """Mass of ballast and shell, shape (dof, dof) [kg], of pitch [kg m^2].

        About the sphere's centre the ballast m_b has I + m_b z_b^2, with m_b z_b = m z_G, for the shell's own centre of
        mass is that of the sphere. Pitch and shapes of the shell do not couple: one is a curl, the others gradients.
        """
        matrix = self._shell_mass.copy()
        if self.rigid:
            mass, centre, own, _ = self.ballast
            matrix[0, 0] = mass
            pitch = 2 / 3 * self.shell.mass * self.shell.radius**2 + own
            if centre:
                pitch += (mass * centre) ** 2 / (mass - self.shell.mass)
            matrix = self._with_pitch(matrix, np.array([pitch, mass * centre, *np.zeros(len(self._of_shell))]))
        return matrix + self.of_rings(self.rings.inertia) if self.rings else matrix

    @cached_property
    def stiffness(self) -> FloatArray:
        """Elastic stiffness, shape (dof, dof) [N/m]; zero for rigid motions."""
        matrix = stiffness_of(self.shell, self._shapes, bending=self.bending)
        if self.rigid:
            matrix[0, :] = matrix[:, 0] = 0.0  # exact: rigid motion strains nothing
        matrix = self._with_pitch(matrix, np.zeros(1 + len(self._shapes)))
        return matrix + self.of_rings(self.rings.stiffness) if self.rings else matrix

    @property
    def damping(self) -> FloatArray:
        """Rayleigh damping alpha M + beta K of the shell modes, shape (dof, dof) [kg/s]; none for rigid motions."""
        matrix = self.alpha * self.inertia + self.beta * self.stiffness
        matrix[: self.rigid, :] = matrix[:, : self.rigid] = 0.0
        return matrix

    @cached_property
    def dry_frequencies(self) -> FloatArray:
        """Rayleigh quotient of each shell mode, shape (mode,) [rad/s]."""
        return np.asarray(np.sqrt(np.diag(self.stiffness)[self.rigid :] / np.diag(self.inertia)[self.rigid :]))

    def field(self, colatitude: FloatArray, derivative: int = 0) -> Field:
        """Return displacements per unit amplitude, or their derivative by colatitude (0 or 1).

        Of the modes of rings what the water sees, their twists of low degrees; see `ring_field`.

        Parameters
        ----------
        colatitude : ndarray, shape (point,) [rad]
        """
        m, sin, cos = self.order, np.sin(colatitude), np.cos(colatitude)
        rows, known = [], dict[int, FloatArray]()
        for mode in self._shapes:
            if mode.degree not in known:
                known[mode.degree] = semi_normalised(mode.degree, m, colatitude)
            s, ds, dds, *around = known[mode.degree]
            v, u = ((s, ds), (ds, dds))[derivative]
            rows.append((mode.radial * v, mode.meridional * u, -m * mode.meridional * around[derivative]))
        if self.rings:
            own = len(rows) - len(self.rings.labels)
            rows[own:] = zip(*self._twisted(colatitude, derivative), strict=True)
        if self.rigid:
            r, zero = self._signs[1] * self.shell.radius, 0.0 * cos
            rows.insert(1, ((zero, r + zero, -r * cos), (zero, zero, r * sin))[derivative])
        return Field(*(np.array([row[i] for row in rows]).reshape(len(rows), len(sin)) for i in range(3)))

    def _twisted(self, colatitude: FloatArray, derivative: int) -> Field:
        """Displacements of the modes of rings by their twists of low degrees, or the derivatives of these."""
        assert self.rings is not None
        degrees, amplitudes = self.rings.twists
        none = np.zeros((len(self.rings.labels), len(colatitude)))
        if not len(degrees):
            return Field(none, none, none)
        tables = np.array([semi_normalised(int(n), self.order, colatitude) for n in degrees])
        around, slope = self.order * tables[:, 3 + derivative], tables[:, 1 + derivative]
        return Field(none, amplitudes.T @ around, -amplitudes.T @ slope)

    def ring_field(self, colatitude: FloatArray) -> Field:
        """Return displacements of rings per unit amplitude, those by the modes of rings as a whole; see `field`."""
        found = self.field(colatitude)
        if self.rings:
            for part, own in zip(found, self.rings.displacement(colatitude), strict=True):
                part[len(part) - len(own) :] = own
        return found

    def curvatures(self, colatitude: FloatArray) -> Field:
        """Return changes of curvature kappa_phi, kappa_theta and twice the twist per unit amplitude [1/m^2].

        -(V - U)/r^2 times the second derivatives of S cos(m theta) on the unit sphere; none of rigid motions. The first
        two go with cos(m theta), the twist with sin(m theta).
        """
        rows = []
        for mode in self._shapes:
            n, turned = mode.degree, (mode.radial - mode.meridional) / self.shell.radius**2
            s, _, dds, _, slope = semi_normalised(n, self.order, colatitude)
            rows.append((-turned * dds, turned * (n * (n + 1) * s + dds), 2 * self.order * turned * slope))
        if self.rigid:
            rows.insert(1, (0.0 * colatitude,) * 3)
        return Field(*(np.array([row[i] for row in rows]).reshape(len(rows), len(colatitude)) for i in range(3)))

    def hydrostatic_stiffness(self, centre_height: float, density: float, gravity: float) -> FloatArray:
        """Return the stiffness of still water and weight about the undeformed sphere, shape (dof, dof) [N/m].

        Parameters
        ----------
        centre_height : float
            Of the sphere's centre above still water [m].
        density, gravity : float
            Of the water [kg/m^3], [m/s^2].

        Notes
        -----
        Minus the Jacobian of Q_j = rho g int z N.psi_j, N = r_phi x r_theta, as of `DeformedShell`: height, and what
        turns and stretches N. Shapes turn with the buoy, d(psi_j)/d(pitch) = e_y x psi_j: the work of the load at rest
        along that is stiffness, too, so the sum is the Hessian of a potential. A sphere that turns about its centre
        moves no water: pitch alone has only the weight's -m g z_G.
        """
        if self.odd:
            even = replace(self, odd=False).hydrostatic_stiffness(centre_height, density, gravity)
            return np.asarray(even * np.outer(self._signs, self._signs))
        low = np.arccos(np.clip(-centre_height / self.shell.radius, -1.0, 1.0))
        node, weight = gauss_rule(2 * self.highest_degree + 30)
        phi, dphi = (low + np.pi) / 2 + (np.pi - low) / 2 * node, (np.pi - low) / 2 * weight
        r, m, sin, cos = self.shell.radius, self.order, np.sin(phi), np.cos(phi)
        (v, u, w), (dv, du, _) = self.field(phi), self.field(phi, derivative=1)
        z = centre_height + r * cos
        normal = (sin * (du + v) + v * sin + u * cos + m * w, -sin * (dv - u), m * v + w * sin)  # dN/(r d amplitude)
        turned = (v * (z * dphi)) @ normal[0].T + (u * (z * dphi)) @ normal[1].T + (w * (z * dphi)) @ normal[2].T
        raised = (v * (r * sin * dphi)) @ (v * cos - u * sin).T
        water = -np.pi * density * gravity * r * (raised + turned)
        if not self.rigid:
            return np.asarray(water)
        water[0, :] = water[:, 0] = 0.0  # exact: the water's surface is the same everywhere
        along = np.pi * density * gravity * r**2 * ((u - w * cos) @ (z * sin * dphi))
        along_weight = -gravity * np.insert(
            self._shell_mass[0], 1, self.ballast.total_mass * self.ballast.centre_of_mass
        )
        along += along_weight
        along[0] = 0.0  # surge moves all of the buoy, turned or not
        water[1] += along
        water[:, 1] += along
        water[1, 1] = along_weight[1]  # exact: a sphere that turns about its centre moves no water
        return np.asarray(water)

    def clamp_rows(self, colatitudes: Iterable[float]) -> FloatArray:
        """Return the constraint matrix of clamps at rings of the shell, shape (3 * clamp, dof) [-].

        The shell does not move relative to the frame, sphere centre and ballast, there. Only shapes of order 1 move a
        pole, along the surface.
        """
        rows = np.concatenate([part.T for part in self.ring_field(np.array(list(colatitudes), dtype=float))])
        rows[:, : self.rigid] = 0.0
        return np.where(np.abs(rows) > SAME, rows, 0.0)

    def allowed(self, flexible: bool, colatitudes: Iterable[float] = (), loaded: bool = True) -> FloatArray:
        """Return an orthonormal basis of the motions of a design, shape (dof, free), rigid motions first.

        Parameters
        ----------
        flexible : bool
            Whether the shell moves.
        colatitudes : iterable of float [rad]
            Of its clamps, whose `clamp_rows` times the motions vanish.
        loaded : bool
            Whether anything loads the shell at a ring; else modes of rings are at rest.
        """
        if not flexible:
            return np.eye(len(self.labels), self.rigid)
        rows = self.clamp_rows(colatitudes)[:, self.rigid :]
        if not (rows.size and rows.any()):
            at_rest = len(self.rings.labels) if self.rings and not loaded else 0
            return np.eye(len(self.labels), len(self.labels) - at_rest)
        return np.asarray(block_diag(np.eye(self.rigid), null_space(rows)))


@dataclass(frozen=True)
class Yaw(OrderBasis):
    """Rotation of a buoy about its axis: it moves no water and strains nothing; only a mooring may hold it."""

    @property
    def rigid(self) -> int:
        """The only degree of freedom."""
        return 1

    @property
    def labels(self) -> tuple[str, ...]:
        """Its name."""
        return ("Yaw",)

    @cached_property
    def inertia(self) -> FloatArray:
        """Inertia of shell and ballast about the axis, shape (1, 1) [kg m^2]."""
        return np.array([[2 / 3 * self.shell.mass * self.shell.radius**2 + self.ballast.yaw_inertia]])

    @cached_property
    def stiffness(self) -> FloatArray:
        """None, shape (1, 1) [N m]."""
        return np.zeros((1, 1))

    def hydrostatic_stiffness(self, centre_height: float, density: float, gravity: float) -> FloatArray:
        """Return none, shape (1, 1) [N m]."""
        return np.zeros((1, 1))

    def field(self, colatitude: FloatArray, derivative: int = 0) -> Field:
        """Return displacements per radian; see `OrderBasis.field`."""
        around, none = (np.sin, np.cos)[derivative](colatitude), np.zeros((1, len(colatitude)))
        return Field(none, none, -self.shell.radius * around[None])  # goes with -cos(0 theta)


def yaw(basis: ModeBasis, ballast: Ballast) -> Yaw:
    """Return the yaw of a buoy with a shell."""
    return Yaw(basis.shell, 0, (), ballast, False, odd=True)


@lru_cache(maxsize=1024)
def _scaled(mode: Mode, order: int) -> Mode:
    """An axisymmetric mode's shape at another order, scaled to max|displacement| = 1, V positive."""

    def displacement(phi: FloatArray) -> FloatArray:
        s, ds, _, around, _ = semi_normalised(mode.degree, order, np.atleast_1d(phi))
        v, u, w = mode.radial * s, mode.meridional * ds, order * mode.meridional * around
        return np.asarray(np.sqrt(np.maximum(v**2 + u**2, w**2)))

    grid = np.linspace(0.0, np.pi, POINTS * mode.degree + 3)
    scale = np.copysign(1.0, mode.radial) / largest_along(displacement, grid, displacement(grid))
    return Mode(f"{mode.label}c{order}", mode.degree, mode.radial * scale, mode.meridional * scale)


def goes_with_sine(label: str) -> bool:
    """Return whether the label is that of a mode of the odd family, such as Membrane3s2."""
    return re.search(r"\d+s\d+$", label) is not None


def order_basis(basis: ModeBasis, order: int, ballast: Ballast) -> OrderBasis:
    """Return the degrees of freedom of order m >= 1 whose modes are those of an axisymmetric basis.

    Labels are those of m = 0 with `c` and the order: Membrane3c2 goes with cos(2 theta).
    """
    modes = tuple(_scaled(mode, order) for mode in basis.modes if mode.degree >= order)
    rings = dict(enumerate(basis.order_rings, 1)).get(order)
    return OrderBasis(basis.shell, order, modes, ballast, basis.bending, basis.alpha, basis.beta, rings=rings)


def all_clamp_rows(clamps: Iterable[float], basis: ModeBasis, orders: Iterable[OrderBasis]) -> FloatArray:
    """Return the constraint matrix of clamps [degrees] over the degrees of freedom of all orders, (row, dof) [-]."""
    at = np.deg2rad(list(clamps))
    return np.asarray(block_diag(basis.clamp_rows(at), *(order.clamp_rows(at) for order in orders)))


def geometric_stiffness(
    basis: OrderBasis, colatitude: FloatArray, area: FloatArray, meridional: FloatArray, hoop: FloatArray
) -> FloatArray:
    """Return int [N_phi |d u/d phi|^2 + N_theta |d u/d theta|^2/sin^2(phi)]/r^2 dA, shape (dof, dof) [N/m].

    Parameters
    ----------
    colatitude, area : ndarray, shape (point,)
        Quadrature points [rad], and the area of the ring of each [m^2].
    meridional, hoop : ndarray, shape (point,)
        Membrane forces N_phi and N_theta, the same around [N/m].

    Notes
    -----
    The gradient of v e_r + u e_phi + w e_theta, v and u with cos(m theta), w with sin(m theta); either is a half on
    average around. For m = 0 the same are strains and rotation of `ElasticShell.geometric_stiffness`.
    """
    r, m, sin, cos = basis.shell.radius, basis.order, np.sin(colatitude), np.cos(colatitude)
    (v, u, w), (dv, du, dw) = basis.field(colatitude), basis.field(colatitude, derivative=1)
    along = (dv - u, du + v, dw)
    around = (-m * v - w * sin, -m * u - w * cos, m * w + v * sin + u * cos)
    by_phi, by_theta = area * meridional / (2 * r**2), area * hoop / (2 * (r * sin) ** 2)
    found = np.asarray(sum((by_phi * one) @ one.T for one in along) + sum((by_theta * one) @ one.T for one in around))
    if basis.rings:
        found = found + basis.of_rings(basis.rings.prestress)
    return _of_shapes(basis, found)


def volume_hessian(basis: OrderBasis) -> FloatArray:
    """Return d2V/dq_j dq_k of the volume enclosed, int psi_j.dN_k with N = r_phi x r_theta, shape (dof, dof) [m]."""
    cosine, weight = gauss_rule(2 * max(mode.degree for mode in basis.modes) + 2)
    phi = np.arccos(cosine)
    r, m, sin, cos, dphi = basis.shell.radius, basis.order, np.sin(phi), cosine, weight / np.sin(phi)
    (v, u, w), (dv, du, _) = basis.field(phi), basis.field(phi, derivative=1)
    normal = (sin * (du + v) + v * sin + u * cos + m * w, -sin * (dv - u), m * v + w * sin)  # dN/(r d amplitude)
    found = sum((one * dphi) @ changed.T for one, changed in zip((v, u, w), normal, strict=True))
    return _of_shapes(basis, np.pi * r * np.asarray(found))


def prestress_stiffness(basis: OrderBasis, loaded: LoadedShell) -> FloatArray:
    """Return the prestress of shapes of an order about the undeformed sphere, shape (dof, dof) [N/m].

    As `LoadedShell.prestress_stiffness` of axisymmetric ones, whose load it is; zero of rigid motions.
    """
    if not basis.modes:
        return np.zeros((len(basis.labels),) * 2)
    colatitude, area = loaded.elastic.rings
    forces = loaded.linear_resultants(colatitude)
    return geometric_stiffness(basis, colatitude, area, *forces) - loaded.pressure_inside * volume_hessian(basis)


def _of_shapes(basis: OrderBasis, matrix: FloatArray) -> FloatArray:
    """A matrix with exact zeros where rigid motions take part."""
    matrix[: basis.rigid, :] = matrix[:, : basis.rigid] = 0.0
    return matrix


AT_ONCE = 4096
"""Instants at which a surface is drawn at one time: some tens of megabytes."""


class _Shapes(NamedTuple):
    """Displacements per unit amplitude along e_r, e_phi, e_theta and their derivatives, each (dof, point)."""

    value: FloatArray  # (3, dof, point)
    by_colatitude: FloatArray
    by_azimuth: FloatArray


def enclosed_in_orders(
    basis: ModeBasis, orders: Sequence[OrderBasis], amplitudes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the volume a shell encloses [m^3] and its surface area [m^2] along a motion.

    Parameters
    ----------
    amplitudes : ndarray, shape (time, dof) [m]
        Of all degrees of freedom, axisymmetric ones first; rigid ones are without effect.

    Returns
    -------
    volume, area : ndarray, shape (time,)
        int r.N/3 and int |N| over colatitude and azimuth, N = r_phi x r_theta; the volume without error of quadrature.
    """
    highest, order = basis.highest_degree, max((each.order for each in orders), default=0)
    node, weight = gauss_rule(2 * highest + 24)
    count = 4 * order + 8
    phi = np.repeat(np.arccos(node), count)
    theta = np.tile(2 * np.pi * np.arange(count) / count, len(node))
    area = np.repeat(weight, count) / np.sin(phi) * 2 * np.pi / count
    shapes = _tabulated(basis, orders, phi, theta)
    parts = [
        _enclosed(basis.shell.radius, shapes, np.asarray(part), phi, area)
        for part in np.array_split(amplitudes, max(1, -(-len(amplitudes) // AT_ONCE)))
    ]
    volume, surface = zip(*parts, strict=True)
    return np.concatenate(volume), np.concatenate(surface)


def _tabulated(basis: ModeBasis, orders: Sequence[OrderBasis], phi: FloatArray, theta: FloatArray) -> _Shapes:
    """Shapes of all degrees of freedom at points, rigid ones zero."""
    v, u = basis.displacement(phi)
    dv, du = basis.displacement(phi, derivative=1)
    none = np.zeros_like(v)
    found = [(np.array([v, u, none]), np.array([dv, du, none]), np.array([none, none, none]))]
    found[0][0][:, 0], found[0][1][:, 0] = 0.0, 0.0  # heave
    for each in orders:
        m, cos, sin = each.order, np.cos(each.order * theta), np.sin(each.order * theta)
        at, slope = np.array(each.field(phi)), np.array(each.field(phi, derivative=1))
        at[:, : each.rigid], slope[:, : each.rigid] = 0.0, 0.0
        if each.odd:  # the same, a quarter of a period further around
            cos, sin = sin, -cos
        around, turned = np.array([cos, cos, sin])[:, None], np.array([-m * sin, -m * sin, m * cos])[:, None]
        found.append((at * around, slope * around, at * turned))
    return _Shapes(*(np.concatenate(part, axis=1) for part in zip(*found, strict=True)))


def _enclosed(
    radius: float, shapes: _Shapes, amplitudes: FloatArray, phi: FloatArray, area: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Volume and area at some instants."""
    sin, cos = np.sin(phi), np.cos(phi)
    v, u, w = (amplitudes @ shape for shape in shapes.value)
    dv, du, dw = (amplitudes @ shape for shape in shapes.by_colatitude)
    tv, tu, tw = (amplitudes @ shape for shape in shapes.by_azimuth)
    out = radius + v
    along = (dv - u, out + du, dw)
    around = (tv - w * sin, tu - w * cos, tw + out * sin + u * cos)
    normal = (
        along[1] * around[2] - along[2] * around[1],
        along[2] * around[0] - along[0] * around[2],
        along[0] * around[1] - along[1] * around[0],
    )
    volume = (out * normal[0] + u * normal[1] + w * normal[2]) @ area / 3
    return volume, np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2) @ area


def largest_deformation(basis: ModeBasis, orders: Sequence[OrderBasis], amplitudes: FloatArray) -> tuple[float, float]:
    """Return the largest displacement of the shell relative to its frame [m] and its largest membrane strain [-].

    Parameters
    ----------
    amplitudes : ndarray, shape (dof,) [m]
        Of all degrees of freedom, axisymmetric ones first; rigid ones are without effect.
    """
    grid, around = np.linspace(0.01, np.pi - 0.01, 181), 8 * max((each.order for each in orders), default=0) + 1
    end = np.pi  # even shapes are the same on both sides
    if any(each.odd for each in orders):
        around, end = 2 * around - 1, 2 * np.pi
    phi, theta = np.repeat(grid, around), np.tile(np.linspace(0, end, around), len(grid))
    value, by_colatitude, by_azimuth = (amplitudes @ part for part in _tabulated(basis, orders, phi, theta))
    meridional = by_colatitude[1] + value[0]
    hoop = value[1] / np.tan(phi) + value[0] + by_azimuth[2] / np.sin(phi)
    strain = np.maximum(np.abs(meridional), np.abs(hoop)).max() / basis.shell.radius
    return float(np.sqrt((value**2).sum(axis=0)).max()), float(strain)


def largest_displacement(basis: ModeBasis, modal_amplitude: FloatArray) -> float:
    """Return the largest displacement of the shell relative to its centre [m]."""
    u = basis.displacement(np.linspace(0.0, np.pi, 361))
    modal_amplitude = np.concatenate([[0.0], modal_amplitude[1:]])
    return float(np.hypot(modal_amplitude @ u[0], modal_amplitude @ u[1]).max())


def largest_strain(basis: ModeBasis, modal_amplitude: FloatArray) -> float:
    """Return the largest membrane strain, |(u' + v)/r| or |(u cot phi + v)/r| [-]."""
    strains = strain_shapes(basis, np.linspace(0.01, np.pi - 0.01, 361))[:2]
    return float(np.abs([modal_amplitude[1:] @ strain[1:] for strain in strains]).max())
