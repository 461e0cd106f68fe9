"""Azimuthal order m: rigid surge and pitch, shell shapes that go with cos(m theta), and the waves' components.

On a body of revolution orders do not mix, neither in the shell nor in the water: each is a problem of its own;
of a wave each sees one component of e^{ikx} = sum_m (2 - delta_m0) i^m J_m(kR) cos(m theta).
"""

import re
from collections.abc import Sequence

import numpy as np
from scipy.special import assoc_legendre_p, j0, j1, jv

from vsb.errors import ConfigError
from vsb.tools.units import ComplexArray, FloatArray


def associated_legendre(degree: int, order: int, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return P_n^m(cos phi), without Condon and Shortley's sign: P_1^1 = sin phi, and its derivative by phi.

    Parameters
    ----------
    degree, order : int
    colatitude : ndarray, shape (point,) [rad]
        Strictly between the poles.
    """
    p, by_cos = (-1.0) ** order * assoc_legendre_p(degree, order, np.cos(colatitude), diff_n=1)
    return np.asarray(p), np.asarray(-np.sin(colatitude) * by_cos)


def order_velocities(
    displacements: Sequence[str], order: int, colatitude: FloatArray, position: FloatArray, normal: FloatArray
) -> FloatArray:
    """Return the normal velocities at theta = 0 of displacements of unit rate, shape (displacement, point).

    They go with cos(m theta) around the body.

    Parameters
    ----------
    displacements : sequence of str
        Radial<n>: P_n^m(cos phi) cos(m theta) along e_r; Meridional<n>: its derivative by phi along e_phi; Surge: along
        x; Pitch: about the y axis through the origin, as capytaine's [m/s per rad/s].
    order : int
        m > 0.
    colatitude : ndarray, shape (point,) [rad]
        Of the material points, on the undeformed sphere.
    position, normal : ndarray, shape (2, point)
        Radius and height of the points [m], and of the unit normal there.

    Raises
    ------
    ConfigError
        If the order has no such displacement.
    """
    (x, z), (n_x, n_z) = position, normal
    along_r, along_phi = (
        n_x * np.sin(colatitude) + n_z * np.cos(colatitude),
        n_x * np.cos(colatitude) - n_z * np.sin(colatitude),
    )

    def velocity(name: str) -> FloatArray:
        if order == 1 and name in ("Surge", "Pitch"):
            return np.asarray(n_x if name == "Surge" else z * n_x - x * n_z)
        match = re.fullmatch(r"(Radial|Meridional)(\d+)", name)
        if match is None or not 0 < order <= int(match[2]):
            raise ConfigError(
                f"displacements: received {name} of azimuthal order {order}; needs Radial<n> or Meridional<n> with "
                "n >= order > 0, or Surge or Pitch of order 1"
            )
        p, slope = associated_legendre(int(match[2]), order, colatitude)
        return np.asarray(p * along_r if match[1] == "Radial" else slope * along_phi)

    return np.array([velocity(name) for name in displacements])


def wave_around(order: int, points: int, kx: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Return the component of order m > 0 of exp(i kx cos theta) over points around a circle, and its rise by kx.

    2 i^m J_m(kx) and its derivative for many points; aliased like everything else that is known at few points only.

    Parameters
    ----------
    order, points : int
    kx : ndarray, shape (circle,)
        Wavenumber times radius.
    """
    theta = 2 * np.pi * np.arange(points) / points
    weight, wave = 2 / points * np.cos(order * theta), np.exp(1j * np.outer(kx, np.cos(theta)))
    return np.asarray(wave @ weight), np.asarray(wave @ (1j * np.cos(theta) * weight))


def multiplicity(order: int) -> int:
    """Return Neumann's factor 2 - delta_m0 of an azimuthal order; int cos^2(m theta) d theta is 2 pi over it."""
    return 2 if order else 1


def bessel(order: int, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Bessel's J_m(x) and J_{m-1}(x), each of the shape of x [-]; J_m' = J_{m-1} - m J_m/x."""
    if order == 0:
        return j0(x), -j1(x)
    return (j1(x), j0(x)) if order == 1 else (jv(order, x), jv(order - 1, x))
