import numpy as np
import pytest
from scipy.special import j0, struve, y0

from vsb.hydro.spectral.deepwater import WavePart, second_kind
from vsb.hydro.spectral.meridian import WetMeridian
from vsb.shell.deformed import rigid_sphere


def test_second_kind_of_low_degree():
    """Q_0 = artanh x, Q_1 = x Q_0 - 1, Q_2 = (3x^2 - 1)/2 Q_0 - 3x/2."""
    x = np.linspace(0.05, 0.95, 19)
    q, c = second_kind(3, x), 2 * x - 1
    assert q[0] == pytest.approx(np.arctanh(c), abs=1e-14)
    assert q[1] == pytest.approx(c * np.arctanh(c) - 1, abs=1e-14)
    assert q[2] == pytest.approx((3 * c**2 - 1) / 2 * np.arctanh(c) - 1.5 * c, abs=1e-14)


NODE, WEIGHT = np.polynomial.legendre.leggauss(80)


def deep_water(k, rho, z):
    """2K PV int_0^inf e^{qz} J0(q rho)/(q - K) dq + 2 pi i K e^{Kz} J0(K rho) as a finite integral, Newman (1985)."""
    u = np.arcsinh(z / rho)[..., None] * (NODE + 1) / 2  # t = rho sinh u takes the root away
    finite = -np.arcsinh(z / rho) * (np.exp(k * (z[..., None] - rho[..., None] * np.sinh(u))) @ (WEIGHT / 2))
    oscillating = np.pi * (struve(0, k * rho) + y0(k * rho)) - 2j * np.pi * j0(k * rho)
    return -k * (2 * finite + np.exp(k * z) * oscillating)


def of_ring(order, k, x, source, z, angles=600):
    """Its integral over the azimuth against cos(m theta), by the midpoint rule."""
    theta = 2 * np.pi * (np.arange(angles) + 0.5) / angles
    rho = np.sqrt((x - source) ** 2 + 4 * x * source * np.sin(theta / 2) ** 2)
    return 2 * np.pi * np.mean(np.cos(order * theta) * deep_water(k, rho, np.full_like(rho, z)))


@pytest.mark.parametrize("order", [0, 1, 2, 3])
@pytest.mark.parametrize(("k", "largest"), [(0.2, 5.0), (5.0, 5.0), (1.0, 1.0), (1e-2, 1e-2), (1e-3, 1e-3)])
def test_influence_is_the_integral_of_the_waves_over_the_azimuth(order, k, largest):
    """Between points apart and on one ring; the derivative by central differences along the normal."""
    meridian, h = WetMeridian(rigid_sphere(1.0, 0.0), 12, order), 1e-4
    found = next(WavePart(meridian, largest).influences(np.array([k])))
    (x, z), p = meridian.targets, meridian.points
    size = np.abs(found).max(axis=(1, 2))
    for i, j in ((0, 6), (4, 4), (7, 2), (11, 5), (13, 8)):
        ahead, here, behind = (
            of_ring(order, k, x[i], p.x[j] + s * p.n_x[j], z[i] + p.z[j] + s * p.n_z[j]) for s in (h, 0.0, -h)
        )
        assert abs(found[0, i, j] - here) < 1e-9 * size[0], (i, j)
        assert abs(found[1, i, j] - (ahead - behind) / (2 * h)) < 1e-6 * size[1], (i, j)


@pytest.mark.parametrize("order", [0, 1, 3])
def test_the_wavenumber_where_the_transform_takes_over_does_not_matter(order):
    """As an operator on the surface: next to the waterline the kernel itself is less exact, where there is no area."""
    meridian = WetMeridian(rigid_sphere(1.0, 0.2), 16, order)
    k, root = np.array([0.1, 1.0]), np.sqrt(meridian.areas)
    low, high = (np.array(list(WavePart(meridian, largest).influences(k))) for largest in (1.0, 4.0))
    on = (low - high)[:, :, :16] * root * root[:, None]
    inside = (low - high)[:, :, 16:] * root
    assert np.abs(on).max() < 1e-6 * np.abs(high[:, :, :16] * root * root[:, None]).max()
    assert np.abs(inside).max() < 1e-9 * np.abs(high[:, :, 16:] * root).max()
