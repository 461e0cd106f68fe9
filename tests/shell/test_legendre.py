import numpy as np
import pytest

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
