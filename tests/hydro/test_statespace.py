import numpy as np
import pytest
from conftest import varied
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.errors import ConvergenceError, DatabaseError, StabilityError
from vsb.hydro import statespace as radiation
from vsb.hydro.retardation import DampingSpectrum
from vsb.hydro.statespace import (
    RadiationModel,
    _dissipative,
    _polish,
    fit_order,
    fit_radiation,
    joined,
    truncated,
    vector_fit,
)


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


def test_states_are_cut_alike_whatever_units_the_motions_have():
    """And a motion that nothing remembers is in nobody's way."""
    model = chain(8, 3, 4)
    units = np.array([1.0, 1e4, 1e-3])
    one = truncated(model, 5)
    other = truncated(RadiationModel(model.state_matrix, model.input_matrix * units, model.channel), 5)
    omega = np.linspace(0.1, 5.0, 20)
    assert other.transfer(omega) / np.outer(units, units) == pytest.approx(one.transfer(omega), rel=1e-6, abs=1e-9)
    still = truncated(
        RadiationModel(model.state_matrix, model.input_matrix * np.array([1.0, 1.0, 0.0]), model.channel), 5
    )
    pair = truncated(RadiationModel(model.state_matrix, model.input_matrix[:, :2], model.channel), 5)
    assert still.transfer(omega)[:, :2, :2] == pytest.approx(pair.transfer(omega), abs=1e-9)
    assert truncated(model, 8) is truncated(model, 9) is model


def test_memories_of_several_channels_are_joined_channel_by_channel():
    def turning(seed):
        rng = np.random.default_rng(seed)
        skew, channel = rng.normal(size=(4, 4)), rng.normal(size=(4, 2))
        return RadiationModel(skew - skew.T - channel @ channel.T / 2, rng.normal(size=(4, 3)), channel)

    models = [turning(0), chain(3, 3, 1), turning(2)]
    whole, omega = joined(models), np.array([0.3, 2.0])
    assert (whole.order, whole.channel.shape) == (11, (11, 5))
    for name in ("transfer", "damping"):
        assert getattr(whole, name)(omega) == pytest.approx(sum(getattr(each, name)(omega) for each in models))


@pytest.mark.parametrize("dof", [2, 3])
def test_a_fit_of_several_motions_goes_by_the_rates_of_the_even_part(dof):
    model, omega = chain(6, dof, 3), np.linspace(0.1, 4.0, 60)
    resolvent = np.linalg.inv(1j * omega[:, None, None] * np.eye(6) - model.state_matrix)
    k = model.transfer(omega)
    even = (k + k.swapaxes(1, 2)) / 2
    start = model.input_matrix * (1 + 0.02 * np.random.default_rng(0).normal(size=(6, dof)))
    found, error = _polish(resolvent, even, start)
    assert error < 1e-8
    back = np.einsum("ni,wnm,mj->wij", found, resolvent, found)
    assert (back + back.swapaxes(1, 2)) / 2 == pytest.approx(even, abs=1e-6)


def test_amplitudes_have_the_signs_of_the_strongest_and_vanish_where_damping_is_negative():
    """The second radiates most in its own size; against it the first is of the other sign at high frequencies."""
    omega = np.array([1.0, 2.0, 3.0])
    x = np.array([[0.5, 2.0, 0.1], [0.2, 3.0, 0.4], [-0.6, 1.0, -0.3]])
    b = x[:, :, None] * x[:, None, :]
    b[0, 2, 2] = -0.01
    scale = np.array([1.0, 2.0, 0.5])
    found = radiation._channel_amplitudes(DampingSpectrum(omega, b), omega, scale)
    expected = x / scale
    expected[0, 2] = 0.0
    assert found == pytest.approx(expected)
    wide, narrow = np.array([2.0, 2.0, 2.0]), np.array([0.1, 2.5, -0.3])  # in all, not at one frequency
    for x in (np.stack([wide, narrow], axis=1), np.stack([narrow, wide], axis=1)):
        b = x[:, :, None] * x[:, None, :]
        assert radiation._channel_amplitudes(DampingSpectrum(omega, b), omega, np.ones(2)) == pytest.approx(x)


@pytest.mark.parametrize(("share", "refused"), [(0.0199, False), (0.0201, True)])
@pytest.mark.parametrize("largest", [100.0, 1e-9])
def test_couplings_alone_may_draw_energy(share, refused, largest):
    """By up to two percent of each motion's largest, of which one radiates nothing at all."""
    b = np.zeros((6, 3, 3))
    b[:, 0, 0], b[:, 1, 1] = largest, 4 * largest
    b[3, 0, 1] = 2.3 * largest  # made even: half
    b[3, 1, 0] = 2 * 2 * (1 + share) * largest - 2.3 * largest
    spectrum = DampingSpectrum(np.arange(1.0, 7.0), b)
    if not refused:
        radiation.check_positive(spectrum)
        return
    with pytest.raises(
        StabilityError, match=r"received a least eigenvalue of -0.02 relative .*, needs at least -0.02;"
    ):
        radiation.check_positive(spectrum)


@pytest.mark.parametrize(
    ("errors", "asked", "best"),
    [
        ([0.01, 0.0099, 0.0098, 0.0001, 0.0], 3, 0.0098),  # twice no tenth better: the mesh's
        ([0.01, 0.0099, 0.005, 0.0049, 0.0048], 5, 0.0048),
        ([0.01, 0.02, 0.0011, 0.03, 0.04], 5, 0.0011),
        ([0.01, 0.005, 0.0005, 0.0, 0.0], 3, 0.0005),
        ([0.0009, 0.0, 0.0, 0.0, 0.0], 1, 0.0009),
    ],
)
def test_orders_grow_until_the_tolerance_or_until_two_gain_nothing(monkeypatch, errors, asked, best):
    spectrum = DampingSpectrum(np.arange(1, 65) * 0.1, np.ones((64, 1, 1)))
    orders = []

    def fit(_, omega, order):
        orders.append(order)
        return f"model {order}", errors[len(orders) - 1]

    monkeypatch.setattr(radiation, "fit_order", fit)
    assert fit_radiation(spectrum, 1e-3) == (f"model {radiation.ORDERS[errors.index(best)]}", best)
    assert orders == list(radiation.ORDERS[:asked])


def test_of_states_those_are_cut_that_are_hardly_reached():
    one, faint = chain(5, 2, 0), chain(3, 2, 1)
    faint = RadiationModel(faint.state_matrix, 1e-7 * faint.input_matrix, faint.channel)
    short, omega = truncated(joined([faint, one]), 5), np.linspace(0.1, 5.0, 20)
    assert short.transfer(omega) == pytest.approx(one.transfer(omega), rel=1e-6, abs=1e-9)


def test_partial_fractions_are_the_states_of_their_matrix_driven_by_their_vector():
    """(s - block)^-1 ones, real poles first, however many there are of either kind and in whatever order."""
    poles = np.array([-0.3 + 2j, -0.7, -1.0 - 0.5j, -0.3 - 2j, -1.9, -1.0 + 0.5j])
    s = 1j * np.array([0.2, 1.5, 4.0]) + 0.1
    basis, block, ones = radiation.partial_fractions(s, poles)
    assert basis.shape == (3, 6)
    states = [np.linalg.solve(each * np.eye(6) - block, ones) for each in s]
    np.testing.assert_allclose(basis, states, rtol=1e-12)
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(block)), np.sort_complex(poles), rtol=1e-12)


def test_vector_fitting_finds_poles_on_the_axis_of_decay_beside_pairs():
    """It starts from pairs alone."""
    poles = np.array([-0.5, -2.0, -0.3 + 2j, -0.3 - 2j])
    residues = np.array([[1.0, -2.0, 0.5 + 1j, 0.5 - 1j], [0.3, 1.0, 1.0, 1.0], [-1.0, 0.4, 0.2j, -0.2j]])
    omega = np.linspace(0.05, 6.0, 60)
    found = vector_fit(omega, np.array([[sum(r / (1j * w - poles)) for r in residues] for w in omega]), 4)
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(poles), abs=1e-6)


def test_poles_that_grow_are_those_that_decay_as_fast_at_the_same_frequency():
    poles = np.array([0.3 + 2j, 0.3 - 2j, -1.0 + 0.7j, -1.0 - 0.7j])
    omega = np.linspace(0.05, 6.0, 60)
    values = np.array([[sum(r / (1j * w - poles)) for r in ([1j, -1j, 0.5, 0.5], [1, 1, 2j, -2j])] for w in omega])
    expected = np.where(poles.real > 0, -poles.conj(), poles)
    assert np.sort_complex(vector_fit(omega, values, 4)) == pytest.approx(np.sort_complex(expected), abs=1e-6)


def channel_of(order, seed):
    """A channel's resolvent over frequencies, and what it is read by."""
    model, omega = chain(order, 1, seed), np.linspace(0.1, 4.0, 60)
    return np.linalg.inv(1j * omega[:, None, None] * np.eye(order) - model.state_matrix), model.channel


def test_a_start_from_the_true_phase_has_the_true_amplitudes_of_either_sign():
    """Of motions in and against phase, whose sum nearly cancels, from a phase that is half a radian off."""
    resolvent, channel = channel_of(6, 3)
    h = channel @ resolvent @ np.random.default_rng(1).normal(size=6)
    share = np.array([1.0, -1.3, 0.2])
    x = np.abs(h)[:, None] * share / np.sqrt(2)
    g, error = radiation._start(resolvent, channel, x, np.angle(h))
    assert error < 1e-12 * np.abs(h).max()
    assert channel @ resolvent @ g == pytest.approx(h[:, None] * share, abs=1e-9 * np.abs(h).max())
    _, other = radiation._start(resolvent, channel, x, np.angle(h) + 0.5 * np.sin(np.arange(60)))
    assert other < 1e-2 * np.abs(h).max()


def test_the_error_of_a_start_is_how_far_its_channel_is_from_the_amplitudes():
    """In the phase of the motions together, once that turns no more."""
    resolvent, channel = channel_of(4, 5)
    omega = np.linspace(0.1, 4.0, 60)
    x = np.stack([omega * np.exp(-omega), -0.5 * omega**2 * np.exp(-omega)], axis=1)
    g, error = radiation._start(resolvent, channel, x, -0.5 * omega)
    h = channel @ resolvent @ g
    turned = np.exp(1j * np.angle((h * x).sum(axis=1)))[:, None]
    missed = np.sqrt(np.mean(np.abs(h - np.sqrt(2) * x * turned) ** 2))
    assert 0.05 * np.abs(x).max() < missed < np.abs(x).max()
    assert error == pytest.approx(missed, rel=2e-2)


def test_of_all_starts_the_two_nearest_are_polished_and_the_better_is_taken(monkeypatch):
    """Phases turn by multiples of what the peak of all damping, scaled, takes: the second motion's, above the first's.

    Motions that radiate alike, the second and the third, are fitted once, each in its own size.
    """
    omega = np.linspace(0.1, 6.0, 40)
    x = np.stack([np.exp(-((omega - 1.0) ** 2)), 3 * np.exp(-((omega - 2.5) ** 2) / 8)], axis=1)
    x = np.concatenate([x, -0.2 * x[:, 1:]], axis=1)
    spectrum = DampingSpectrum(omega, x[:, :, None] * x[:, None, :])
    phases, polished = [], []

    def start(resolvent, channel, amplitudes, phase):
        phases.append(phase)
        number = float(len(phases))
        return np.full((len(channel), amplitudes.shape[1]), number), {1: 5.0, 2: 2.0, 3: 4.0, 4: 1.0, 5: 3.0}[number]

    def polish(resolvent, target, given):
        polished.append(given[0, 0])
        return given, {4.0: 0.02, 2.0: 0.01}.get(given[0, 0], 0.001)

    monkeypatch.setattr(radiation, "_start", start)
    monkeypatch.setattr(radiation, "_polish", polish)
    model, error = fit_order(spectrum, omega, 4)
    assert (polished, error) == ([4.0, 2.0], 0.01)
    size = np.abs(x).max(axis=0)
    peak = omega[(x**2 / size**2).sum(axis=1).argmax()]
    assert peak != omega[(x[:, 0] ** 2).argmax()] != omega[(x**2).sum(axis=1).argmax()]
    np.testing.assert_allclose(phases, [-omega * delay / peak for delay in (0.0, 0.5, 1.0, 1.5, 2.0)])
    assert model.order == 4
    own = model.input_matrix / size
    assert own[:, 2] == pytest.approx(-own[:, 1])


def test_the_memory_of_unlike_motions_is_theirs_in_their_own_units():
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


def test_a_motion_that_draws_at_all_frequencies_is_refused_beside_one_that_radiates():
    """However little: it has no size to be measured in; one that does nothing is in nobody's way."""
    b = np.zeros((6, 3, 3))
    b[:, 0, 0], b[:, 2, 2] = 5.0, 1e-3
    spectrum = DampingSpectrum(np.arange(1.0, 7.0), b)
    radiation.check_positive(spectrum)
    b[:, 2, 2] = -1e-9
    with pytest.raises(StabilityError, match="received a least eigenvalue of -inf relative to each mode's largest"):
        radiation.check_positive(DampingSpectrum(np.arange(1.0, 7.0), b))


@pytest.mark.parametrize(("count", "stride"), [(5, 1), (60, 1), (119, 1), (120, 2), (200, 3)])
def test_a_memory_is_fitted_at_sixty_frequencies_or_a_few_more_and_beyond_both_ends(monkeypatch, count, stride):
    omega, asked = 0.3 + 0.1 * np.arange(count), []
    monkeypatch.setattr(radiation, "fit_order", lambda _, at, order: asked.append((at, order)) or ("model", 1e-4))
    fit_radiation(DampingSpectrum(omega, np.ones((count, 1, 1))), 1e-3)
    ((at, order),) = asked
    top = omega[-1]
    np.testing.assert_allclose(at, [0.06, *omega[::stride], 1.1 * top, 1.4 * top, 2.0 * top])
    assert order == radiation.ORDERS[0]


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_a_model_radiates_is_its_own_to_a_hundred_millionth_of_its_rates(scale, sign):
    """In any unit of time; of one that radiates more than it loses as of one that radiates less."""
    channel = np.sqrt(scale) * np.array([[1.0, 0.2], [0.5, -0.7]])
    a = scale * np.array([[0.0, 3.0], [-3.0, 0.0]]) - channel @ channel.T / 2
    for share in (0.9e-8, 1.1e-8):
        off = a.copy()
        off[0, 1] += sign * share * np.abs(a).max()
        if share < 1e-8:
            RadiationModel(off, np.ones((2, 1)), channel)
            continue
        with pytest.raises(
            StabilityError, match=r"the radiation model is not passive: .* needs a stable A whose symmetri"
        ):
            RadiationModel(off, np.ones((2, 1)), channel)
