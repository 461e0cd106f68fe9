"""Legendre polynomials along a meridian."""

import numpy as np
from scipy.special import legendre_p_all

from vsb.tools.arrays import FloatArray


def legendre(degree: int, colatitude: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return P_n(cos phi) and its first and second derivatives by phi for n = 0..degree.

    Parameters
    ----------
    degree : int
    colatitude : ndarray, shape (point,) [rad]

    Returns
    -------
    tuple of ndarray, each shape (degree + 1, point) [-]
    """
    cos, sin = np.cos(colatitude), np.sin(colatitude)
    p, dp, ddp = legendre_p_all(degree, cos, diff_n=2)
    return p, -sin * dp, sin**2 * ddp - cos * dp
