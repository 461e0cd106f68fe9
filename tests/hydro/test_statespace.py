import numpy as np
import pytest
from conftest import varied
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.errors import ConvergenceError, DatabaseError, StabilityError
from vsb.hydro import statespace as radiation
from vsb.hydro.retardation import DampingSpectrum
from vsb.hydro.statespace import RadiationModel, _dissipative, _polish, fit_order, fit_radiation, joined, vector_fit


def chain(order: int, dof: int, seed: int) -> RadiationModel:
    """A random passive single-channel model."""
    rng = np.random.default_rng(seed)
    skew = rng.normal(size=(order, order))
    channel = rng.normal(size=order)
    return RadiationModel(skew - skew.T - 0.5 * np.outer(channel, channel), rng.normal(size=(order, dof)), channel)


@settings(max_examples=30)
@given(st.integers(2, 8), st.integers(1, 4), st.integers(0, 10**6))
def test_any_such_model_is_passive_with_one_channel(order, dof, seed):
    model = chain(order, dof, seed)
    omega = np.linspace(0.0, 20.0, 101)
    transfer = model.transfer(omega)
    hermitian = 0.5 * (transfer + transfer.conj().transpose(0, 2, 1))
    eigenvalues = np.linalg.eigvalsh(hermitian)
    scale = np.abs(transfer).max()
    assert np.abs(hermitian.real - model.damping(omega)).max() < 1e-9 * scale
    assert eigenvalues.min() > -1e-9 * scale
    assert np.abs(eigenvalues[:, :-1]).max(initial=0.0) < 1e-9 * scale


def test_kernel_is_the_impulse_response_of_the_transfer_function():
    model = RadiationModel(
        np.array([[-0.5, 1.0], [-1.0, 0.0]]), np.array([[1.0, 0.3], [0.2, -1.0]]), np.array([1.0, 0.0])
    )
    time = np.linspace(0.0, 60.0, 12001)
    transform = np.trapezoid(model.kernel(time) * np.exp(-1j * 0.8 * time)[:, None, None], time, axis=0)
    assert transform == pytest.approx(model.transfer(np.array([0.8]))[0], abs=1e-5)


def test_vector_fitting_recovers_the_poles_of_a_rational_function():
    poles = np.array([-0.3 + 2j, -0.3 - 2j, -1.0 + 0.7j, -1.0 - 0.7j])
    residues = np.array([[1 + 1j, 1 - 1j, 0.5, 0.5], [0.2j, -0.2j, 1.0, 1.0]])
    omega = np.linspace(0.05, 6.0, 60)
    values = np.array([[sum(r / (1j * w - poles)) for r in residues] for w in omega])
    found = vector_fit(omega, values, 4)
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(poles), abs=1e-6)


def test_what_a_model_radiates_is_exact_however_close_its_poles_are():
    """A + A^T = -l l^T to the last bits, though the observability of poles so close is known to a few digits only."""
    poles = np.array([-0.02 + 2.0j, -0.0201 + 2.001j, -0.8 + 2.5j])
    poles = np.concatenate([poles, poles.conj(), [-0.5, -0.51]])
    a, channel = _dissipative(poles)
    assert np.abs(a + a.T + np.outer(channel, channel)).max() < 4 * np.finfo(float).eps * np.abs(a).max()
    by_parts = np.sort_complex(np.linalg.eigvals(a))
    assert by_parts == pytest.approx(np.sort_complex(poles), abs=1e-5)


def test_a_fit_that_begins_near_the_amplitudes_ends_at_them():
    """Thirty steps of Gauss and Newton from a tenth away: the rates they go by must be those of the fit."""
    model, omega = chain(6, 1, 3), np.linspace(0.1, 4.0, 60)
    resolvent = np.linalg.inv(1j * omega[:, None, None] * np.eye(6) - model.state_matrix)
    start = 1.1 * model.input_matrix
    found, error = _polish(resolvent, model.transfer(omega), start)
    assert error < 1e-13
    assert np.abs(found) == pytest.approx(np.abs(model.input_matrix), abs=1e-9)


def test_not_passive_is_refused():
    with pytest.raises(StabilityError, match="not passive"):
        RadiationModel(np.array([[0.1]]), np.ones((1, 1)), np.ones(1))
    with pytest.raises(StabilityError, match="needs a stable A"):
        RadiationModel(np.array([[-1.0, 0.0], [0.0, -1.0]]), np.ones((2, 1)), np.ones(2))
    turning = np.array([[0.0, 1.0], [-1.0, 0.0]])  # radiates nothing: what it stores, it stores for ever
    with pytest.raises(StabilityError, match=r"largest growth rate 0\.0e\+00/s; needs a stable A"):
        RadiationModel(turning, np.ones((2, 1)), np.zeros(2))


def test_what_no_order_can_fit_is_an_error(monkeypatch):
    omega = np.arange(1, 65) * 0.1
    spectrum = DampingSpectrum(omega, np.random.default_rng(0).uniform(0.0, 1.0, (64, 1, 1)))
    monkeypatch.setattr(radiation, "ORDERS", (6,))
    with pytest.raises(ConvergenceError, match=r"needs 0.02; widen the band"):
        fit_radiation(spectrum, 1e-6)


def test_a_coarse_tolerance_is_no_excuse_for_a_model_that_is_refused(monkeypatch):
    spectrum = DampingSpectrum(np.arange(1, 65) * 0.1, np.ones((64, 1, 1)))
    errors = iter((0.025, 0.015))
    monkeypatch.setattr(radiation, "fit_order", lambda *_: ("model", next(errors)))
    assert fit_radiation(spectrum, 0.03) == ("model", 0.015)


class TestOfTheSeed:
    def test_error_falls_with_order(self, buoy_of, coarse):
        spectrum = buoy_of(coarse).spectrum
        omega = spectrum.omega[::2]
        errors = [fit_order(spectrum, omega, order)[1] for order in (4, 8, 16)]
        assert errors[0] > 1.5 * errors[1] > 2 * errors[2]
        assert errors[2] < 2e-3

    def test_kernel_agrees_with_the_convolution(self, buoy_of, radiation_of, coarse):
        spectrum, model = buoy_of(coarse).spectrum, radiation_of(coarse)
        time = np.linspace(0.0, 20.0, 201)
        scale = np.sqrt(np.einsum("wii->wi", spectrum.damping).max(axis=0))
        exact, ours = (m.kernel(time) / np.outer(scale, scale) for m in (spectrum, model))
        assert np.sqrt(np.mean((ours - exact) ** 2)) < 5e-3 * np.abs(exact).max()

    def test_passive_over_all_frequencies(self, radiation_of, coarse):
        model = radiation_of(coarse)
        omega = np.concatenate([[0.0], np.geomspace(1e-4, 1e4, 400)])
        scale = np.sqrt(np.einsum("wii->wi", model.damping(omega)).max(axis=0))
        real = model.transfer(omega).real / np.outer(scale, scale)
        assert np.linalg.eigvalsh(0.5 * (real + real.transpose(0, 2, 1))).min() > -1e-10

    def test_modes_that_radiate_alike_cost_no_states(self, buoy_of, coarse):
        full = buoy_of(varied(coarse, modes={"basis": "full"})).spectrum
        few = buoy_of(coarse).spectrum
        omega = few.omega[::2]
        errors = [fit_order(s, omega, 14)[1] for s in (few, full)]
        assert errors[1] < 2 * errors[0]


@pytest.mark.parametrize("largest", [100.0, 1e-9])
@pytest.mark.parametrize("share", [-0.05, -1.0])
def test_damping_that_draws_energy_is_refused(share, largest):
    """In any units."""
    omega = np.linspace(0.1, 8.0, 80)
    bump = largest * omega**2 * np.exp(-omega)
    damping = np.where(omega > 4.0, share * bump.max(), bump) if share > -1 else share * bump
    with pytest.raises(StabilityError, match=r"would draw energy from calm water"):
        fit_radiation(DampingSpectrum(omega, damping[:, None, None]), 1e-3)


def test_damping_that_is_no_number_is_refused():
    damping = np.ones((10, 1, 1))
    damping[3] = np.nan
    with pytest.raises(DatabaseError, match="received NaN or infinite values"):
        DampingSpectrum(np.arange(1.0, 11.0), damping)


def test_memories_joined_act_side_by_side():
    one = RadiationModel(np.array([[-0.5]]), np.array([[1.2, 0.4]]), np.ones(1))
    other = RadiationModel(np.array([[-2.0]]), np.array([[0.0, 3.0]]), np.array([2.0]))
    both, omega = joined([one, other]), np.array([0.3, 2.0])
    assert both.order == 2
    assert both.transfer(omega) == pytest.approx(one.transfer(omega) + other.transfer(omega))
    assert both.damping(omega) == pytest.approx(one.damping(omega) + other.damping(omega))
    assert joined([one]) is one


def test_the_memory_is_fitted_beyond_the_band_as_well():
    """To twice its end, where damping falls as omega^-3: no error there is above the root of the sum of all squares."""
    omega = np.arange(1.0, 26.0) * 0.1
    b = omega**3 / (1 + omega**2) ** 3
    spectrum = DampingSpectrum(omega, b[:, None, None])
    model, error = fit_radiation(spectrum, 1e-3)
    at = np.concatenate([[0.02], omega, [2.75, 3.5, 5.0]])
    missed = np.abs(model.transfer(at) - spectrum.transfer(at)) / b.max()
    assert missed.max() <= error * np.sqrt(2 * len(at))
    assert np.sqrt((missed**2).sum() / (2 * len(at))) == pytest.approx(error, rel=1e-6)
