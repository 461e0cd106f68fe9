import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from vsb.engine.hydro.radiation import (
    DampingSpectrum,
    RadiationModel,
    _dissipative,
    fit_order,
    fit_radiation,
    vector_fit,
)
from vsb.errors import StabilityError

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


@settings(max_examples=30)
@given(st.integers(2, 8), st.integers(1, 4), st.integers(0, 10**6))
def test_random_chain_is_passive_with_one_channel(order, dof, seed):
    # a random passive single-channel model
    rng = np.random.default_rng(seed)
    skew = rng.normal(size=(order, order))
    channel = rng.normal(size=order)
    model = RadiationModel(skew - skew.T - 0.5 * np.outer(channel, channel), rng.normal(size=(order, dof)), channel)
    omega = np.linspace(0.0, 20.0, 101)
    transfer = model.transfer(omega)
    hermitian = 0.5 * (transfer + transfer.conj().transpose(0, 2, 1))
    eigenvalues = np.linalg.eigvalsh(hermitian)
    scale = np.abs(transfer).max()
    assume(scale < 1e5)  # a pole next to the axis leaves few digits
    assert np.abs(hermitian.real - model.damping(omega)).max() < 1e-9 * scale
    assert eigenvalues.min() > -1e-9 * scale
    assert np.abs(eigenvalues[:, :-1]).max(initial=0.0) < 1e-9 * scale


def test_vector_fitting_recovers_the_poles_of_a_rational_function():
    poles = np.array([-0.3 + 2j, -0.3 - 2j, -1.0 + 0.7j, -1.0 - 0.7j])
    residues = np.array([[1 + 1j, 1 - 1j, 0.5, 0.5], [0.2j, -0.2j, 1.0, 1.0]])
    omega = np.linspace(0.05, 6.0, 60)
    values = np.array([[sum(r / (1j * w - poles)) for r in residues] for w in omega])
    found = vector_fit(omega, values, 4)
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(poles), abs=1e-6)


def test_radiated_power_is_exact_for_close_poles():
    """A + A^T = -l l^T to the last bits, though the observability of poles so close is known to a few digits only."""
    poles = np.array([-0.02 + 2.0j, -0.0201 + 2.001j, -0.8 + 2.5j])
    poles = np.concatenate([poles, poles.conj(), [-0.5, -0.51]])
    a, channel = _dissipative(poles)
    assert np.abs(a + a.T + np.outer(channel, channel)).max() < 4 * np.finfo(float).eps * np.abs(a).max()
    by_parts = np.sort_complex(np.linalg.eigvals(a))
    assert by_parts == pytest.approx(np.sort_complex(poles), abs=1e-5)


def test_not_passive_is_refused():
    with pytest.raises(StabilityError, match="not passive"):
        RadiationModel(np.array([[0.1]]), np.ones((1, 1)), np.ones(1))
    with pytest.raises(StabilityError, match="needs a stable A"):
        RadiationModel(np.array([[-1.0, 0.0], [0.0, -1.0]]), np.ones((2, 1)), np.ones(2))
    turning = np.array([[0.0, 1.0], [-1.0, 0.0]])  # radiates nothing: what it stores, it stores for ever
    with pytest.raises(StabilityError, match=r"largest growth rate 0\.0e\+00/s; needs a stable A"):
        RadiationModel(turning, np.ones((2, 1)), np.zeros(2))


@pytest.fixture(scope="module")
def seed_spectrum(spectral_seed):
    return spectral_seed.spectrum


def test_error_falls_with_order(seed_spectrum):
    omega = seed_spectrum.omega[::2]
    errors = [fit_order(seed_spectrum, omega, order)[1] for order in (4, 8, 16)]
    assert errors[0] > 1.5 * errors[1] > 2 * errors[2]
    assert errors[2] < 2e-3


def test_fitted_model_is_passive_and_has_the_kernel_of_the_convolution(seed_spectrum):
    model, time = fit_radiation(seed_spectrum, 1e-3)[0], np.linspace(0.0, 20.0, 201)
    scale = np.sqrt(np.einsum("wii->wi", seed_spectrum.damping).max(axis=0))
    exact, ours = (m.kernel(time) / np.outer(scale, scale) for m in (seed_spectrum, model))
    assert np.sqrt(np.mean((ours - exact) ** 2)) < 5e-3 * np.abs(exact).max()
    real = model.transfer(np.concatenate([[0.0], np.geomspace(1e-4, 1e4, 400)])).real / np.outer(scale, scale)
    assert np.linalg.eigvalsh(0.5 * (real + real.transpose(0, 2, 1))).min() > -1e-10


def test_fit_of_motions_in_different_units():
    """Two that radiate in and against phase at once, in units a thousand apart, and a third like the second."""
    omega = np.arange(1.0, 61.0) * 0.1
    one, other = omega**1.5 / (1 + omega**2) ** 1.5, omega**2.5 / (1 + omega**2) ** 2
    x = np.stack([one, -other, 0.5 * other], axis=1) * np.array([1.0, 1e3, 1e-2])
    spectrum = DampingSpectrum(omega, x[:, :, None] * x[:, None, :])
    model, error = fit_radiation(spectrum, 2e-3)
    size = np.abs(x).max(axis=0)
    at = np.concatenate([[0.02], omega, np.array([1.1, 1.4, 2.0]) * omega[-1]])
    missed = (model.transfer(at) - spectrum.transfer(at)) / np.outer(size, size)
    even = np.abs(missed + missed.swapaxes(1, 2)) / 2
    assert error < 0.02
    assert 0.3 * error < np.sqrt((even**2).mean()) < 3 * error
