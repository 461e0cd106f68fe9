"""Legendre functions of the colatitude and their derivatives."""

import numpy as np
import pytest
from scipy.special import gammaln

from vsb.shell.legendre import legendre


def test_legendre_equation_and_poles():
    """(sin phi P')' + n(n+1) sin phi P = 0; at the poles P = (+-1)^n, P' = 0, P'' = -n(n+1)/2 P."""
    phi, n = np.linspace(0.3, 2.8, 9), np.arange(13)[:, None]
    p, dp, ddp = legendre(12, phi)
    assert ddp * np.sin(phi) + dp * np.cos(phi) == pytest.approx(-n * (n + 1) * np.sin(phi) * p, abs=1e-11)
    p, dp, ddp = legendre(12, np.array([0.0, np.pi]))
    assert p == pytest.approx(np.hstack([n**0, (-1) ** n]))
    assert np.abs(dp).max() < 1e-13
    assert ddp == pytest.approx(-n * (n + 1) / 2 * p)


def fourier(degree, phi):
    """P_n(cos phi) = sum_k a_k a_(n-k) cos (n-2k) phi, a_k = (2k)!/(2^k k!)^2, and two derivatives."""
    k = np.arange(degree + 1)
    a = np.exp(gammaln(2 * k + 1) - 2 * gammaln(k + 1) - k * np.log(4))
    m, weight = degree - 2 * k, a * a[::-1]
    angle = np.outer(m, phi)
    return weight @ np.cos(angle), -(weight * m) @ np.sin(angle), -(weight * m**2) @ np.cos(angle)


@pytest.mark.parametrize("degree", [0, 1, 2, 7, 40, 80])
def test_legendre_functions_match_their_fourier_series(degree):
    phi = np.linspace(0.0, np.pi, 501)
    for order, (ours, series) in enumerate(zip(legendre(80, phi), fourier(degree, phi), strict=True)):
        assert np.abs(ours[degree] - series).max() < 2e-13 * max(1, degree) ** order
