"""Azimuthal order m: rigid surge and pitch, shell shapes that go with cos(m theta), and the waves' components.

On a body of revolution orders do not mix, neither in the shell nor in the water: each is a problem of its own;
of a wave each sees one component of e^{ikx} = sum_m (2 - delta_m0) i^m J_m(kR) cos(m theta).
"""

import numpy as np
from scipy.special import assoc_legendre_p, j0, j1, jv

from vsb.shell.legendre import legendre
from vsb.tools.arrays import ComplexArray, FloatArray


def legendre_function(degree: int, order: int, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return P_n^m(cos phi), without Condon and Shortley's sign: P_1^1 = sin phi, and its derivative by phi.

    Parameters
    ----------
    degree, order : int
    colatitude : ndarray, shape (point,) [rad]
        Strictly between the poles for m > 0.
    """
    if order == 0:
        p, dp, _ = legendre(degree, colatitude)
        return p[degree], dp[degree]
    p, by_cos = (-1.0) ** order * assoc_legendre_p(degree, order, np.cos(colatitude), diff_n=1)
    return np.asarray(p), np.asarray(-np.sin(colatitude) * by_cos)


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
