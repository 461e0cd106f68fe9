"""Tables of the compiled loops of body-exact motion for shells of another meridian than the sphere's.

Of any meridian x = sum a_k sin k phi, z = sum b_k cos k phi the loops' polynomials in c = cos phi are its terms:
X = sum a_k U_{k-1}(c), z = sum b_k T_k(c), z' = sum k b_k U_{k-1}(c) and T = dx/dphi = sum k a_k T_k(c).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev

from vsb.motion.wetted import Shape, WetShell
from vsb.shell.mode import Mode
from vsb.shell.modes import ModeBasis
from vsb.study.meridian import RestMeridian
from vsb.tools.arrays import FloatArray


def wet_shell(basis: ModeBasis, centre_height: float) -> WetShell:
    """Return the forces of water on the wet part of a shell of any meridian."""
    return (WetShell if basis.shell.rest is None else ShapedWetShell)(basis, centre_height)


@dataclass(frozen=True)
class ShapedWetShell(WetShell):
    """The same of a shell of another meridian than the sphere's."""

    @cached_property
    def shape(self) -> Shape:
        """Tables of the compiled loops; as many points as integrate their polynomials exactly."""
        highest, radius = self.basis.turns, self.basis.shell.radius
        node, weight = np.polynomial.legendre.leggauss(2 * highest + 3)
        grid = -np.cos(np.linspace(0.0, np.pi, 6 * (highest + 1) + 1))
        at_rest = _at_rest(self.basis.shell.meridian, highest + 2)
        at_rest[1, 0] += self.centre_height
        on_grid = np.ascontiguousarray(chebyshev.chebvander(grid, highest + 1).T)
        return Shape(radius, at_rest, _of_shapes(self.basis, highest + 2), node, weight, grid, on_grid)


def _of_shapes(basis: ModeBasis, terms: int) -> FloatArray:
    """Chebyshev coefficients of what each shape does, (dof, 4, term): its shares of displacements of single degrees."""
    degrees = range(basis.highest_degree + 1)
    units = [Mode(f"Radial{n}", n, 1.0, 0.0) for n in degrees] + [
        Mode(f"Meridional{n}", n, 0.0, 1.0) for n in degrees[1:]
    ]
    single = WetShell(ModeBasis(basis.shell, tuple(units), 1.0, bending=False), 0.0)
    order = basis.highest_degree + 2
    c = chebyshev.chebpts1(order)
    to_series = np.linalg.inv(chebyshev.chebvander(c, order - 1)).T
    found = np.zeros((len(basis.labels), 4, terms))
    found[:, :, :order] = np.einsum("id,dpk->ipk", basis.displacements, single._shapes(c)[1:]) @ to_series
    return found


def _at_rest(rest: RestMeridian, terms: int) -> FloatArray:
    """Chebyshev coefficients of X, z, z' and T of a meridian at rest, shape (4, term) [m]."""
    out = np.zeros((4, terms))
    for k, a in enumerate(rest.radial, 1):
        out[0] += a * _second_kind(k - 1, terms)
        out[3, k] += k * a
    for k, b in enumerate(rest.axial):
        out[1, k] += b
        out[2] += k * b * _second_kind(k - 1, terms)
    return out


def _second_kind(degree: int, terms: int) -> FloatArray:
    """U_n in terms of T_k, shape (term,): 2 T_n + 2 T_{n-2} + ..., the last T_0 once; none of n = -1."""
    out = np.zeros(terms)
    if degree >= 0:
        out[degree::-2] = 2.0
        out[0] /= 2
    return out
