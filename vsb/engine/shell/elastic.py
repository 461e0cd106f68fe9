"""The elastic shell: exact membrane and bending energy and enclosed volume over the amplitudes of a basis."""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple, cast

import numpy as np

from vsb.engine.shell.deformed import DeformedShell, Meridian
from vsb.engine.shell.modes import ModeBasis, curvature_shapes, strain_shapes
from vsb.engine.shell.shell import Shell, length, meridian_rule
from vsb.tools.arrays import FloatArray


class Tables(NamedTuple):
    """Shapes at the quadrature points of the undeformed shell."""

    colatitude: FloatArray  # (point,) [rad]
    area: FloatArray  # of the ring of each point, (point,) [m^2]
    dphi: FloatArray  # weights of int f dphi, (point,) [rad]
    strains: tuple[FloatArray, FloatArray, FloatArray]  # `strain_shapes`
    curvatures: tuple[FloatArray, FloatArray]  # `curvature_shapes`
    meridian: Meridian


@lru_cache(maxsize=16)
def _tables(basis: ModeBasis, points: int) -> Tables:
    """Shapes at a number of quadrature points, cached for all materials; not to be written to."""
    colatitude, dphi = meridian_rule(basis.shell.meridian.junctions, points)
    at = basis.shell.at_rest(colatitude)
    area = 2 * np.pi * at.x * length(at.dx, at.dz) * dphi
    meridian = DeformedShell(basis, 0.0).meridian(colatitude)
    strains, curvatures = strain_shapes(basis, colatitude), curvature_shapes(basis, colatitude)
    return Tables(colatitude, area, dphi, strains, curvatures, meridian)


@dataclass(frozen=True)
class ElasticShell:
    """Elastic energy and enclosed volume over the amplitudes of a basis; bending always included.

    The energy is the integral of the wall's, Psi(E, kappa), over the undeformed surface
    (`vsb.engine.shell.elasticity`). The Green strains E_phi = e_phi + (e_phi^2 + beta^2)/2 and E_theta = e_theta +
    e_theta^2/2 are those of the deformed surface, whatever the displacements; changes of curvature kappa are linear in
    them. With Hooke's law every integrand is a polynomial in cos phi, of degree at most 4N (energy) or 3N+2 (volume),
    so Gauss-Legendre quadrature with 2N+2 points or more is exact; rubber is given further points.
    """

    basis: ModeBasis

    @cached_property
    def _tables(self) -> Tables:
        prestress = converged_degree(self.basis.shell) // 2  # points for membrane forces of more degrees than the basis
        further = 4 * (self.basis.turns + 16) if self.basis.shell.rest is not None else 0
        if self.basis.shell.rubber is not None:
            further += 2 * self.basis.highest_degree + 16
        return _tables(self.basis.immaterial, 2 * self.basis.highest_degree + 2 + prestress + further)

    @property
    def rings(self) -> tuple[FloatArray, FloatArray]:
        """Colatitudes of the quadrature points [rad] and the areas of their rings [m^2], each shape (point,)."""
        return self._tables.colatitude, self._tables.area

    @property
    def shapes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Linear strains e_phi, e_theta and rotation beta per unit amplitude there, each shape (dof, point) [1/m]."""
        return self._tables.strains

    def strains(self, q: FloatArray, colatitude: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Return Green-Lagrange strains E_phi, E_theta, each shape (point,) [-]; at the quadrature points if none."""
        shapes = self._tables.strains if colatitude is None else strain_shapes(self.basis, colatitude)
        meridional, hoop, rotation = (q @ shape for shape in shapes)
        return meridional + (meridional**2 + rotation**2) / 2, hoop + hoop**2 / 2

    def deformation(self, q: FloatArray) -> FloatArray:
        """Return strains and changes of curvature E_phi, E_theta, kappa_phi, kappa_theta, shape (4, point)."""
        return np.array([*self.strains(q), *(q @ shape for shape in self._tables.curvatures)])

    def resultants(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the membrane forces N_phi = dPsi/dE_phi, N_theta, each (point,) [N per metre undeformed]."""
        meridional, hoop, *_ = self.basis.shell.wall.resultants(self.deformation(q))
        return meridional, hoop

    def linear_resultants(self, q: FloatArray, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the membrane forces of small strains, C (e_phi + nu e_theta), N_theta, each shape (point,) [N/m]."""
        meridional, hoop, _ = (q @ shape for shape in strain_shapes(self.basis, colatitude))
        stiffness, nu = self.basis.shell.membrane_stiffness, self.basis.shell.poisson_ratio
        return stiffness * (meridional + nu * hoop), stiffness * (hoop + nu * meridional)

    def admits(self, q: FloatArray) -> bool:
        """Return whether the material can be strained so."""
        return self.basis.shell.law.admits(*self.strains(q))

    def energy(self, q: FloatArray) -> float:
        """Return U = int Psi dA [J]; of amplitudes (time, dof) shape (time,)."""
        energy = self.basis.shell.wall.energy(self.deformation(q)) @ self._tables.area
        if self._of_rings is not None:
            energy = energy + np.einsum("...i,ij,...j->...", q, self._of_rings, q) / 2
        return cast(float, energy)

    @cached_property
    def _of_rings(self) -> FloatArray | None:
        """Stiffness of the modes of rings, linear whatever the wall, shape (dof, dof) [N/m]; None without them."""
        rings = self.basis.rings
        return self.basis.of_rings(rings.stiffness + rings.prestress) if rings else None

    def force(self, q: FloatArray) -> FloatArray:
        """Return the elastic force -dU/dq, shape (dof,) [N]; of amplitudes (time, dof) that shape."""
        (e, t, b), (kappa, around), area = self._tables.strains, self._tables.curvatures, self._tables.area
        meridional, hoop, moment, other = area * self.basis.shell.wall.resultants(self.deformation(q))
        along, across = (meridional * (1 + q @ e)) @ e.T + (meridional * (q @ b)) @ b.T, (hoop * (1 + q @ t)) @ t.T
        force = np.asarray(-(along + across + moment @ kappa.T + other @ around.T))
        return force if self._of_rings is None else force - q @ self._of_rings

    def _gradients(self, q: FloatArray) -> tuple[FloatArray, ...]:
        """Derivatives of `deformation` by the amplitudes, each shape (dof, point)."""
        meridional, hoop, rotation = self._tables.strains
        along = (1 + q @ meridional) * meridional + (q @ rotation) * rotation
        return along, (1 + q @ hoop) * hoop, *self._tables.curvatures

    def membrane_factor(self, q: FloatArray) -> FloatArray:
        """Return L of the membrane's stiffness L L^T at amplitudes q, shape (dof, rank) [(N/m)^0.5]."""
        values, vectors = np.linalg.eigh(self.membrane_stiffness(q))
        kept = values > 1e-12 * values[-1]
        return np.asarray(vectors[:, kept] * np.sqrt(values[kept]))

    def membrane_stiffness(self, q: FloatArray) -> FloatArray:
        """Return the membrane's stiffness at amplitudes q, without bending, shape (dof, dof) [N/m].

        h d2W/dE_i dE_j dA in the gradients of the Green strains, the moduli those of the material as it is stretched.
        """
        along, hoop, *_ = self._gradients(q)
        moduli, volume = self.basis.shell.law.moduli(*self.strains(q)), self.basis.shell.thickness * self._tables.area
        mixed = (volume * moduli.mixed * along) @ hoop.T
        whole = (volume * moduli.first * along) @ along.T + (volume * moduli.second * hoop) @ hoop.T + mixed + mixed.T
        return np.asarray(whole)

    def material_stiffness(self, q: FloatArray) -> FloatArray:
        """Return the part of the Hessian of U that holds the elastic moduli, bending included, (dof, dof) [N/m]."""
        gradients, moduli = (
            self._gradients(q),
            self._tables.area * self.basis.shell.wall.moduli(self.deformation(q)).normal,
        )
        return np.asarray(
            sum(
                one @ sum(c * other for c, other in zip(row, gradients, strict=True)).T
                for one, row in zip(gradients, moduli, strict=True)
            )
        )

    def geometric_stiffness(self, meridional: FloatArray, hoop: FloatArray) -> FloatArray:
        """Return int [N_phi (e_phi e_phi + beta beta) + N_theta e_theta e_theta] dA, shape (dof, dof) [N/m]."""
        (e, t, b), area = self._tables.strains, self._tables.area
        return (area * meridional * e) @ e.T + (area * meridional * b) @ b.T + (area * hoop * t) @ t.T

    def stiffness(self, q: FloatArray) -> FloatArray:
        """Return the Hessian of U, material and geometric, shape (dof, dof) [N/m]."""
        stiffness = self.material_stiffness(q) + self.geometric_stiffness(*self.resultants(q))
        return stiffness if self._of_rings is None else stiffness + self._of_rings

    def _deformed(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Radius x of the deformed meridian, dx/dphi and dz/dphi at the quadrature points, each shape (point,) [m]."""
        m = self._tables.meridian
        return m.x + q @ m.shape_x, m.dx + q @ m.dshape_x, m.dz + q @ m.dshape_z

    def volume(self, q: FloatArray) -> float:
        """Return the enclosed volume pi int x^2 dz over the closed meridian [m^3]; of (time, dof) shape (time,)."""
        x, _, dz = self._deformed(q)
        volume: float = -np.pi * np.dot(x**2 * dz, self._tables.dphi)  # phi runs downwards
        return volume

    def volume_gradient(self, q: FloatArray) -> FloatArray:
        """Return dV/dq_j = int n.psi_j dS, shape (dof,) [m^2]; of amplitudes (time, dof) that shape."""
        (x, dx, dz), weight, m = self._deformed(q), 2 * np.pi * self._tables.dphi, self._tables.meridian
        return np.asarray((weight * x * dx) @ m.shape_z.T - (weight * x * dz) @ m.shape_x.T)

    def volume_hessian(self, q: FloatArray) -> FloatArray:
        """Return d2V/dq_j dq_k = -2 pi int [x_j x_k z' + x (x_j z_k' + x_k z_j')] dphi, shape (dof, dof) [m]."""
        (x, _, dz), weight = self._deformed(q), 2 * np.pi * self._tables.dphi
        shape = self._tables.meridian.shape_x
        mixed = (x * weight * shape) @ self._tables.meridian.dshape_z.T
        return -((dz * weight * shape) @ shape.T + mixed + mixed.T)


def converged_degree(shell: Shell, least: int = 40) -> int:
    """Return 1.6 times the classical degree of buckling, sqrt(r/h) [12 (1 - nu^2)]^(1/4), and no less than `least`.

    On other meridians than the sphere's times the most by which they stretch the angle, max |(x', z')|/r.
    """
    slenderness = (shell.radius / shell.thickness).real
    critical = math.sqrt(slenderness * math.sqrt(12 * (1 - shell.poisson_ratio.real**2)))
    degree = max(least, math.ceil(1.6 * critical))
    if shell.rest is None:
        return degree
    at = shell.at_rest(np.linspace(0.0, np.pi, 4 * shell.rest.terms + 41))
    stretch = float(np.hypot(at.dx.real, at.dz.real).max()) / shell.radius.real
    return math.ceil(degree * max(1.0, stretch - 1e-9))
