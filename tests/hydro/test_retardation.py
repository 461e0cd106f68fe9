import numpy as np
import pytest
from scipy.integrate import quad

from vsb.engine.hydro.retardation import DampingSpectrum

OMEGA = np.arange(1, 121) * 0.1
TAIL = 2 / np.pi * 3 / (4 * 12.0**4)  # what w^-3 beyond 12 rad/s misses of w^-3 (1 - 3 w^-2 + ...)


def damping(w):
    """Smooth, ~ w^3 at low and w^-3 at high frequency, as a radiation damping is."""
    return w**3 / (1 + w**2) ** 3


@pytest.fixture(scope="module")
def spectrum():
    return DampingSpectrum(OMEGA, damping(OMEGA)[:, None, None])


@pytest.mark.parametrize("time", [0.0, 0.5, 3.0, 10.0])
def test_kernel_is_the_cosine_transform(spectrum, time):
    exact = 2 / np.pi * (quad(damping, 0, np.inf, weight="cos", wvar=time)[0] if time else quad(damping, 0, np.inf)[0])
    assert spectrum.kernel(np.array([time]))[0, 0, 0] == pytest.approx(exact, abs=1.1 * TAIL)


@pytest.mark.parametrize("omega", [0.55, 1.5, 4.0])
def test_added_mass_follows_from_damping_by_kramers_kronig(spectrum, omega):
    inner = quad(lambda v: damping(v) / (v + omega), 0, 60, weight="cauchy", wvar=omega, limit=400)[0]
    outer = quad(lambda v: damping(v) / (v**2 - omega**2), 60, np.inf)[0]
    exact = 2 / np.pi * (inner + outer)
    assert spectrum.added_mass_difference(np.array([omega]))[0, 0, 0] == pytest.approx(exact, abs=2e-5)


def test_interpolation_converges_at_fourth_order():
    steps = [0.2, 0.1, 0.05, 0.025, 0.0125]
    probe = np.linspace(1.013, 3.017, 57)
    errors = []
    for step in steps:
        omega = np.arange(1, round(12 / step) + 1) * step
        spectrum = DampingSpectrum(omega, damping(omega)[:, None, None])
        errors.append(np.abs(spectrum.at(probe)[:, 0, 0] - damping(probe)).max())
    slopes = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert np.all(np.abs(slopes[1:] - 4.0) < 0.15), slopes


@pytest.mark.parametrize("omega", [0.55, 2.2])
def test_damping_beyond_the_band_falls_as_its_cube(omega):
    """A band that ends where damping is largest: kernel and added mass are integrals of B over all frequencies."""
    cut = DampingSpectrum(OMEGA[:15], damping(OMEGA[:15])[:, None, None])
    top = OMEGA[14]

    def b(v):
        return float(cut.at(np.array([v]))[0, 0, 0])

    assert b(2 * top) == pytest.approx(damping(top) / 8)
    high = max(top, omega + 0.3)
    inner = quad(lambda v: b(v) / (v + omega), 0, high, weight="cauchy", wvar=omega, limit=400)[0]
    outer = quad(lambda v: b(v) / (v**2 - omega**2), high, np.inf)[0]
    assert cut.added_mass_difference(np.array([omega]))[0, 0, 0] == pytest.approx(2 / np.pi * (inner + outer), abs=2e-5)
    whole = quad(b, 0, top)[0] + damping(top) * top / 2
    assert cut.kernel(np.zeros(1))[0, 0, 0] == pytest.approx(2 / np.pi * whole, abs=1e-6)
