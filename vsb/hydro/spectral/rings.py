"""Potential and gradient of rings of sources whose strength goes with cos(m theta): integrals of 1/r over the azimuth.

With r1, r2 the largest and least distances between point and ring, r^2 = s^2 (1 + q^2 - 2 q cos theta) with
s = (r1 + r2)/2 and q = (r1 - r2)/(r1 + r2), so the integrals are Laplace's coefficients of celestial mechanics. Near
the ring a recurrence in m from elliptic integrals is stable, far from it their series in q converges.
"""

import numpy as np
from scipy.special import ellipe, ellipkm1, hyp2f1, poch

from vsb.tools.arrays import FloatArray

_FAR = 0.75
"""Ratio q below which the series is summed; the recurrence loses a factor q^(-2m) there."""


def ring(
    order: int, source: FloatArray, apart: FloatArray, height: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return p = int_0^{2 pi} cos(m theta)/r d theta and, as c and d, its gradient c e_R + d (apart, -height).

    Parameters
    ----------
    order : int
        Azimuthal order m.
    source : ndarray [m]
        Radius R' of the ring.
    apart, height : ndarray [m]
        By how much the point's radius exceeds it, and the point's height above the ring.

    Returns
    -------
    p, c, d : ndarray [1/m, 1/m^2, 1/m^3]
        The gradient is by the position of the source. At the ring p grows like log r2, d like 1/r2^2.

    Notes
    -----
    d = int cos(m theta)/r^3 d theta and c = (r2^2 d - p)/(2 R'); for m = 0 p = 4 K/r1 and d = 4 E/(r1 r2^2) with
    1 - m = (r2/r1)^2. The distance itself is the argument: no coordinates are subtracted near the singularity.
    """
    near = np.maximum(apart**2 + height**2, 1e-300)
    product = 4 * source * (source + apart)
    far = near + product
    root = np.sqrt(far)
    p: FloatArray = 4 * ellipkm1(near / far) / root
    e: FloatArray = 4 * ellipe(1 - near / far) / root
    if order:
        p, e = _of_order(order, p, e, near, product)
    return p, (e - p) / (2 * source), e / near


def _of_order(
    order: int, p: FloatArray, e: FloatArray, near: FloatArray, product: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Values p and e = r2^2 d of an order >= 1 from those of order 0, r2^2 and 4 R R'."""
    far = near + product
    total = np.sqrt(far) + np.sqrt(near)
    q = product / total**2
    series = q < _FAR
    of_p, of_e = np.empty_like(q), np.empty_like(q)
    of_p[series], of_e[series] = _by_series(order, q[series], total[series])
    close = ~series
    of_p[close], of_e[close] = _by_recurrence(order, p[close], e[close], near[close], product[close])
    return of_p, of_e


def _by_recurrence(
    order: int, p: FloatArray, e: FloatArray, near: FloatArray, product: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Order 0 to m, in the differences 2 R R' (p_n - p_{n+1}), which do not grow at the ring (DLMF 14.10.3)."""
    far = near + product
    step = far * e - near * p
    for n in range(1, order + 1):
        p = p - 2 * step / product
        step = ((n - 0.5) * step - 2 * n * near * p) / (n + 0.5)
    return p, (2 * order + 1) * (step + near * p) / far


def _by_series(order: int, q: FloatArray, total: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Laplace's coefficients, b_{1/2} and (1 - q)^2 b_{3/2}, for q well below 1; `total` is r1 + r2."""
    scale = 4 * np.pi * poch(0.5, order) / poch(1, order) * q**order / total
    p = scale * hyp2f1(0.5, order + 0.5, order + 1, q**2)
    return p, scale * (2 * order + 1) * hyp2f1(-0.5, order - 0.5, order + 1, q**2) / (1 + q) ** 2
