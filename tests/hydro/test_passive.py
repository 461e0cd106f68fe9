from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from vsb.errors import ConvergenceError, DatabaseError, StabilityError
from vsb.hydro import passive
from vsb.hydro.passive import (
    RadiationSamples,
    entry_error,
    fit_lowest,
    fit_passive,
    leading_directions,
    sizes,
)
from vsb.hydro.passivity import least_damping
from vsb.hydro.realisation import StateSpace
from vsb.hydro.retardation import DampingSpectrum
from vsb.hydro.statespace import RadiationModel, truncated

OMEGA = np.linspace(0.05, 6.0, 80)


def reciprocal(order, channels, dof, seed, ring=0.8):
    """A random passive model with symmetric K: coupled oscillators, their rates driven, seen and damped."""
    rng, half = np.random.default_rng(seed), order // 2
    omega, zero = np.diag(np.sort(rng.uniform(0.3, 4.0, half))), np.zeros((half, half))
    channel, g = ring * rng.normal(size=(half, channels)), rng.normal(size=(half, dof))
    a = np.block([[zero, omega], [-omega, -channel @ channel.T / 2]])
    return RadiationModel(a, np.vstack([np.zeros_like(g), g]), np.vstack([np.zeros_like(channel), channel]))


def samples(model, omega=OMEGA, noise=0.0, **changes):
    """Added mass and damping of a model, with noise relative to each motion's largest damping."""
    k = model.transfer(omega)
    inertia = 50.0 * np.ones(k.shape[1])
    size = sizes(omega, k.real, inertia)
    random = np.random.default_rng(5).normal(size=(2, *k.shape)) * noise * np.outer(size, size)
    random = (random + random.swapaxes(-1, -2)) / 2
    added_mass = np.diag(inertia) + (k.imag + random[0]) / omega[:, None, None]
    made = RadiationSamples(omega, added_mass, k.real + random[1], np.diag(inertia), size)
    return replace(made, **changes)


def narrow(seed=7):
    """A body's memory, and one of its motions coupled to a gap whose water swings with hardly any damping."""
    one = reciprocal(8, 3, 3, seed)
    gap = np.array([[0.0, 2.2], [-2.2, -5e-3]])
    g = np.vstack([one.input_matrix, [[0.0, 0.0, 0.0], [0.3, 0.0, 0.2]]])
    a = np.block([[one.state_matrix, np.zeros((8, 2))], [np.zeros((2, 8)), gap]])
    channel = np.block([[one.channel, np.zeros((8, 1))], [np.zeros((2, 3)), np.array([[0.0], [0.1]])]])
    return RadiationModel(a, g, channel)


def is_passive(model):
    """Whether a Hamiltonian matrix proves a model's damping, scaled, nowhere negative."""
    scale = np.linalg.norm(model.input_matrix, axis=0)
    g = model.input_matrix / np.where(scale > 0, scale, 1.0)
    found = least_damping(StateSpace(model.state_matrix, g, g.T))
    return found.value > 0.5 * found.bound  # what there is is round-off of the proof


@settings(max_examples=20, deadline=None)
@given(st.integers(3, 5), st.integers(2, 4), st.integers(1, 4), st.integers(0, 10**6))
def test_random_passive_memories_are_recovered_with_their_poles(half, channels, dof, seed):
    """All poles at least half as far below the axis as samples are apart: narrower peaks fall between these."""
    true = reciprocal(2 * half, channels, dof, seed)
    assume(-np.linalg.eigvals(true.state_matrix).real.max() > 0.5 * (OMEGA[1] - OMEGA[0]))
    given_ = samples(true)
    fit = fit_passive(given_, 1e-4)
    assert fit.error < 1e-4
    assert is_passive(fit.model)
    found, poles = (np.linalg.eigvals(model.state_matrix) for model in (fit.model, true))
    if fit.model.order == true.order and fit.error < 1e-7:
        assert np.abs(found[:, None] - poles).min(axis=0).max() < 1e-3


def test_poles_order_and_kernel_of_a_known_memory():
    true = reciprocal(8, 4, 3, 0)
    fit = fit_passive(samples(true), 1e-5)
    found, poles = (np.linalg.eigvals(model.state_matrix) for model in (fit.model, true))
    assert fit.model.order == 8
    assert np.abs(found[:, None] - poles).min(axis=0).max() < 1e-8
    time = np.linspace(0.0, 20.0, 101)
    assert fit.model.kernel(time) == pytest.approx(true.kernel(time), abs=1e-4)
    assert fit.model.kernel(time)[0] == pytest.approx(true.input_matrix.T @ true.input_matrix, rel=1e-4)


@pytest.mark.parametrize("count", [4, 7, 11])
def test_a_memory_of_two_poles_and_their_conjugates_is_found_from_as_few_frequencies(count):
    """Four are the fewest there may be."""
    fit = fit_passive(samples(reciprocal(4, 2, 1, 0), np.linspace(0.3, 4.5, count)), 1e-4)
    assert fit.error < 1e-4
    assert fit.model.order == 4


def test_a_memory_of_thirty_states_is_followed_to_a_hundred_millionth():
    true, omega = reciprocal(30, 15, 1, 1, ring=0.5), np.linspace(0.05, 6.0, 200)
    fit = fit_passive(samples(true, omega), 1e-8)
    assert fit.error < 1e-8
    assert 24 < fit.model.order <= 30


def smooth(dof=3):
    """Samples of damping that no state space has: two channels, B = h h^T/2 summed, with its added mass."""
    omega = np.arange(1, 161) * 0.05
    n = np.arange(1.0, dof + 1)
    one, other = omega[:, None] ** 2 * np.exp(-omega[:, None] * n / dof), omega[:, None] * np.exp(-omega[:, None] / n)
    damping = one[:, :, None] * one[:, None, :] + other[:, :, None] * other[:, None, :] * (-1) ** (n[:, None] + n)
    change = DampingSpectrum(omega, damping).added_mass_difference(omega)
    return RadiationSamples(omega, np.eye(dof) + change, damping, np.eye(dof), sizes(omega, damping, np.zeros(dof)))


def test_error_falls_and_order_grows_with_the_tolerance():
    tolerances = (1e-2, 5e-3, 2e-3, 1e-3)
    fits = [fit_passive(smooth(), tolerance) for tolerance in tolerances]
    assert all(fit.error <= tolerance for fit, tolerance in zip(fits, tolerances, strict=True))
    orders = [fit.model.order for fit in fits]
    assert orders == sorted(orders)
    assert orders[0] < orders[-1]
    assert all(is_passive(fit.model) for fit in fits)


def test_added_mass_and_damping_of_the_model_are_of_one_causal_function():
    """Kramers and Kronig between both parts of K, by quadrature."""
    fit = fit_passive(samples(reciprocal(8, 3, 2, 4)), 1e-3)
    omega = np.linspace(0.0, 60.0, 6001)[1:]
    spectrum = DampingSpectrum(omega, fit.model.damping(omega))
    at = np.array([0.5, 1.5, 3.0])
    expected = fit.model.transfer(at).imag
    found = at[:, None, None] * spectrum.added_mass_difference(at)
    uneven = 0.5 * (expected + expected.swapaxes(1, 2))
    assert found == pytest.approx(uneven, abs=5e-3 * np.abs(expected).max())


@pytest.mark.parametrize("noise", [1e-4, 1e-3, 5e-3])
def test_noise_is_repaired_and_told(noise):
    true = reciprocal(8, 4, 3, 0)
    fit = fit_passive(samples(true, noise=noise), 1e-5)
    assert fit.error < 3 * noise
    assert is_passive(fit.model)
    assert fit.drawn < 0 < fit.changed < 3 * noise
    assert "made passive by a change of" in fit.history
    size = samples(true).size
    assert entry_error((fit.model.transfer(OMEGA) - true.transfer(OMEGA)) / np.outer(size, size)) < 2 * noise


@pytest.mark.parametrize("noisy_first", [True, False])
def test_of_motions_that_radiate_apart_the_worst_is_told(noisy_first):
    """One that needs a repair beside one that needs none: what is told is of the first, in either order."""
    parts = [samples(reciprocal(4, 2, 2, 0), noise=5e-3), samples(reciprocal(4, 2, 1, 4))]
    alone = fit_passive(parts[0], 1e-3)
    one, other = parts if noisy_first else parts[::-1]

    def both(a, b):
        return np.concatenate([
            np.concatenate([a, np.zeros((*a.shape[:-1], b.shape[-1]))], axis=-1),
            np.concatenate([np.zeros((*b.shape[:-1], a.shape[-1])), b], axis=-1),
        ], axis=-2)  # fmt: skip

    fit = fit_passive(RadiationSamples(
        OMEGA, both(one.added_mass, other.added_mass), both(one.damping, other.damping),
        both(one.added_mass_inf, other.added_mass_inf), np.concatenate([one.size, other.size]),
    ), 1e-3)  # fmt: skip
    clean = fit_passive(parts[1], 1e-3)
    assert (fit.drawn, fit.changed, fit.error) == pytest.approx((alone.drawn, alone.changed, alone.error), rel=1e-3)
    assert alone.drawn < clean.drawn
    assert alone.changed > 10 * clean.changed


def test_damping_sampled_slightly_negative_is_repaired_and_told():
    model = samples(reciprocal(8, 4, 3, 0))
    lowest = model.drawn - 0.01
    damping = model.damping - 0.01 * np.diag(model.size**2)
    fit = fit_passive(replace(model, damping=damping), 1e-3)
    assert fit.sampled < lowest + 0.01
    assert 3e-3 < fit.error < 0.02
    assert "least eigenvalue of the damping given" in fit.history
    assert is_passive(fit.model)


def test_irregular_frequencies_at_the_end_of_a_band_leave_a_memory_of_what_lies_below():
    """Damping in the last fifth goes up and down by its largest."""
    model = reciprocal(6, 2, 2, 3)
    sound = samples(model)
    ragged = np.where(sound.omega > 0.8 * sound.omega[-1], 0.5 * (1 + np.cos(np.arange(len(sound.omega)) * 2.5)), 0.0)
    spoiled = replace(sound, damping=sound.damping + ragged[:, None, None] * np.diag(sound.size**2))
    with pytest.raises(ConvergenceError):
        fit_passive(spoiled, 1e-3)
    fit = fit_lowest(spoiled, 1e-3)
    assert 0.5 * sound.omega[-1] < fit.up_to <= 0.8 * sound.omega[-1]
    assert "above which no passive memory follows the coefficients" in fit.history
    below = sound.omega <= fit.up_to
    missed = fit.model.transfer(sound.omega[below]) - model.transfer(sound.omega[below])
    assert np.abs(missed / np.outer(sound.size, sound.size)).max() < 5e-3
    assert fit_lowest(sound, 1e-3).up_to == np.inf


def test_a_wrong_limit_is_found_and_told():
    """Added mass at infinite frequency from another mesh than that at all others: no passive K has both."""
    true = samples(reciprocal(6, 3, 2, 0))
    wrong = replace(true, added_mass_inf=1.005 * true.added_mass_inf)
    with pytest.raises(ConvergenceError, match="or fit added mass at infinite frequency"):
        fit_passive(wrong, 1e-3)
    fit = fit_passive(wrong, 1e-3, limit="fitted")
    assert fit.error < 1e-3
    added_mass = fit.added_mass_inf + fit.model.transfer(OMEGA).imag / OMEGA[:, None, None]
    assert added_mass[10:] == pytest.approx(true.added_mass[10:], abs=0.03)  # 0.25 off before
    assert 0.003 < fit.shifted < 0.02
    assert fit.changed < 1e-3  # beside the limit, which is told by itself and is 30 times as much
    assert "added mass at infinite frequency fitted" in fit.history
    assert fit_passive(true, 1e-3).shifted == 0.0


def test_what_needs_no_repair_tells_of_none():
    assert passive.PassiveFit(reciprocal(4, 1, 1, 0), 1e-4, 0.0, 0.0, 0.0, np.eye(1)).history == ""


class TestHardCases:
    def test_yaw_of_a_round_body_radiates_nothing_but_round_off(self):
        true = reciprocal(8, 3, 3, 1)
        model = samples(replace(true, input_matrix=true.input_matrix * np.array([1.0, 1.0, 1e-9])))
        noise = 1e-9 * np.random.default_rng(1).normal(size=model.damping.shape)
        given_ = replace(model, damping=model.damping + noise + noise.swapaxes(1, 2))
        fit = fit_passive(given_, 1e-3)
        assert fit.error < 1e-3
        assert not fit.model.input_matrix[:, 2].any()

    def test_motions_without_inertia_are_measured_by_their_damping(self):
        k = reciprocal(6, 2, 2, 3).transfer(OMEGA)
        size = sizes(OMEGA, k.real, np.zeros(2))
        assert size == pytest.approx(np.sqrt(np.einsum("wii->wi", k.real).max(axis=0)))

    def test_thirty_motions_of_two_channels_cost_the_states_of_few(self):
        fit = fit_passive(samples(reciprocal(8, 2, 30, 4)), 1e-3)
        assert fit.error < 1e-3
        assert fit.model.order == 8
        assert fit.model.input_matrix.shape == (8, 30)

    def test_a_gap_between_two_bodies_rings(self):
        fine = np.union1d(OMEGA, np.linspace(2.1, 2.3, 41))
        fit = fit_passive(samples(narrow(), fine), 1e-3)
        assert fit.error < 1e-3
        slowest = np.linalg.eigvals(fit.model.state_matrix)
        assert np.abs(slowest - (-2.5e-3 + 2.2j)).min() < 1e-3
        assert is_passive(fit.model)

    def test_groups_that_do_not_couple_are_fitted_apart(self):
        one, other = reciprocal(6, 2, 2, 1), reciprocal(4, 1, 1, 2)
        k = np.zeros((len(OMEGA), 3, 3), dtype=complex)
        k[:, :2, :2], k[:, 2:, 2:] = one.transfer(OMEGA), other.transfer(OMEGA)
        model = RadiationSamples(
            OMEGA, k.imag / OMEGA[:, None, None], k.real, np.zeros((3, 3)), sizes(OMEGA, k.real, np.zeros(3))
        )
        fit = fit_passive(model, 1e-4)
        assert fit.model.order == 10
        assert not fit.model.input_matrix[:6, 2].any()
        assert not fit.model.input_matrix[6:, :2].any()

    def test_what_is_above_the_band_is_free_but_passive(self):
        """A band that ends before damping does: a plain fit of it draws energy above."""
        given_ = samples(reciprocal(20, 3, 3, 6), OMEGA[OMEGA < 2.5])
        fit = fit_passive(given_, 1e-3)
        assert fit.error < 5e-3
        assert is_passive(fit.model)


def test_a_truncated_model_of_many_channels_is_passive():
    model = reciprocal(12, 4, 3, 0)
    short = truncated(model, 7)
    assert short.order == 7
    assert short.channel.shape == (7, 4)
    assert is_passive(short)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e6])
def test_states_are_empty_in_terms_of_the_largest_energy(scale):
    """K is quadratic in F; of two oscillators that radiate in proportion a combination stores nothing."""
    true = reciprocal(6, 3, 2, 0)
    outputs = passive._PassiveOutputs(true.state_matrix, true.input_matrix)
    full = outputs.model(scale * true.channel, np.eye(2))
    assert full.order == 6
    assert full.transfer(OMEGA) == pytest.approx(scale**2 * true.transfer(OMEGA), rel=1e-9, abs=1e-9 * scale**2)
    twice = passive._PassiveOutputs(*(np.kron(np.eye(2), true.state_matrix), np.vstack([true.input_matrix] * 2)))
    model = twice.model(scale * np.vstack([true.channel] * 2), np.eye(2))
    assert model.order == 6
    assert model.transfer(OMEGA) == pytest.approx(4 * scale**2 * true.transfer(OMEGA), rel=1e-6, abs=1e-6 * scale**2)


def test_directions_that_matter():
    rng = np.random.default_rng(0)
    mixing = rng.normal(size=(2, 5))
    inner = rng.normal(size=(30, 2, 2)) + 0j
    k = mixing.T @ (inner + inner.swapaxes(1, 2)) @ mixing
    lead = leading_directions(k, 1e-8)
    assert lead.shape == (5, 2)
    assert lead @ lead.T @ k == pytest.approx(k)
    assert leading_directions(k, 1e3).shape == (5, 0)


def test_what_hardly_radiates_is_measured_by_its_inertia_at_the_frequency_of_its_largest_damping():
    omega, damping = np.array([0.5, 1.0, 2.0]), np.zeros((3, 2, 2))
    damping[:, 0, 0], damping[:, 1, 1] = [1.0, 4.0, 2.0], [1e-9, 2e-9, 5e-9]
    assert sizes(omega, damping, np.array([3.0, -6.0])) ** 2 == pytest.approx([4.0, 1e-4 * 2.0 * 6.0])


class TestRefused:
    def test_samples(self):
        good = samples(reciprocal(6, 2, 2, 0))
        with pytest.raises(DatabaseError, match=r"damping: received shape \(80, 2\), needs \(80, 2, 2\)"):
            replace(good, damping=good.damping[:, 0])
        with pytest.raises(DatabaseError, match="added_mass: received NaN or infinite values"):
            replace(good, added_mass=good.added_mass * np.nan)
        uneven = good.damping + np.array([[0.0, 1.0], [0.0, 0.0]])
        with pytest.raises(DatabaseError, match=r"damping: received an asymmetry of .* use `with_symmetrized`"):
            replace(good, damping=uneven)
        for share in (0.9e-6, -0.9e-6):  # round-off, in terms of the largest of all in their sizes
            scaled = good.damping / np.outer(good.size, good.size)
            scaled[3, 0, 1] += share * np.abs(scaled).max()
            replace(good, damping=scaled * np.outer(good.size, good.size))
            scaled[3, 0, 1] += 0.3 * share * np.abs(scaled).max()
            with pytest.raises(DatabaseError, match=r"damping: received an asymmetry of 1.2e-06 of its largest entry"):
                replace(good, damping=scaled * np.outer(good.size, good.size))
        with pytest.raises(DatabaseError, match="received 80 frequencies, needs four or more, positive and ascending"):
            replace(good, omega=OMEGA[::-1])
        with pytest.raises(DatabaseError, match="needs four or more, positive and ascending"):
            replace(good, omega=OMEGA - OMEGA[0])
        with pytest.raises(DatabaseError, match="size: received values that are not positive"):
            replace(good, size=np.array([1.0, 0.0]))
        with pytest.raises(
            DatabaseError, match="size: received values that are not positive, needs one above 0 for each"
        ):
            replace(good, size=np.array([1.0, np.inf]))

    def test_damping_that_draws_energy(self):
        good = samples(reciprocal(6, 2, 2, 0))
        with pytest.raises(
            StabilityError, match=r"received a least eigenvalue of -1.* would draw energy from calm water"
        ):
            fit_passive(replace(good, damping=-good.damping), 1e-3)

    @pytest.mark.parametrize("tolerance", [0.0, 0.5, np.nan])
    def test_tolerances(self, tolerance):
        with pytest.raises(ConvergenceError, match=r"tolerance: received .*, needs 1e-9 to 0.1"):
            fit_passive(samples(reciprocal(6, 2, 2, 0)), tolerance)

    def test_no_waves(self):
        good = samples(reciprocal(6, 2, 2, 0))
        with pytest.raises(DatabaseError, match="received damping of no motion"):
            fit_passive(
                replace(good, damping=0 * good.damping, added_mass=0 * good.added_mass + good.added_mass_inf), 1e-3
            )

    def test_what_no_passive_memory_is_near(self):
        good = samples(reciprocal(6, 2, 2, 0))
        with pytest.raises(ConvergenceError, match=r"reaches an error of .* needs 0.02; refine the mesh"):
            fit_passive(replace(good, added_mass_inf=good.added_mass_inf * 1.2), 1e-3)

    def test_a_start_that_does_not_exist(self, monkeypatch):
        monkeypatch.setattr(passive, "_STARTS", 0)
        with pytest.raises(ConvergenceError, match="received no start with"):
            fit_passive(samples(reciprocal(6, 2, 2, 0)), 1e-3)


@pytest.mark.parametrize(("size", "groups"), [(1.1e-3, [[0, 2], [1]]), (0.9e-3, [[0], [1], [2]])])
def test_motions_that_couple_in_any_phase_radiate_together(size, groups):
    """A coupling is as large as its size over the band, though its real part changes sign and its mean is none."""
    phase = np.exp(2j * np.pi * np.arange(12) / 12)
    k = np.tile(np.eye(3, dtype=complex), (12, 1, 1))
    k[:, 0, 2] = k[:, 2, 0] = size * phase
    assert [group.tolist() for group in passive.coupled(k, 1e-3)] == groups


@pytest.mark.parametrize(
    "omega",
    [[0.5, 1.0, 2.0], [0.0, 1.0, 2.0, 3.0], [1.0, 2.0, 2.0, 3.0], [3.0, 2.0, 1.0, 0.5]]
    + [[0.5, 1.0, 2.0, last] for last in (np.inf, np.nan)],
)
def test_frequencies_that_are_no_grid_are_refused(omega):
    count = len(omega)
    values = np.ones((count, 1, 1))
    with pytest.raises(DatabaseError, match=f"omega: received {count} frequencies, needs four or more, positive and"):
        RadiationSamples(np.array(omega), values, values, np.eye(1), np.ones(1))
    RadiationSamples(np.array([0.5, 1.0, 2.0, 3.0]), *np.ones((2, 4, 1, 1)), np.eye(1), np.ones(1))


@pytest.mark.parametrize("name", ["added_mass", "damping", "added_mass_inf"])
def test_every_matrix_of_samples_is_looked_through(name):
    good = samples(reciprocal(6, 2, 2, 0))
    values = getattr(good, name)
    wrong = {
        r"received shape \(.*\), needs \(.*2, 2\)\.": values[..., :1],
        "received NaN or infinite values; solve these": np.where(values == values.max(), np.inf, values),
        "received an asymmetry of .* of its largest entry, needs": values + values.max() * np.array([[0, 1], [0, 0]]),
    }
    for words, bad in wrong.items():
        with pytest.raises(DatabaseError, match=rf"^{name}: {words}"):
            replace(good, **{name: bad})


def test_what_is_drawn_is_the_least_eigenvalue_of_the_damping_in_its_sizes_and_never_positive():
    """Off the diagonal alone a coupling draws; at one frequency of four."""
    omega, size = np.array([1.0, 2.0, 3.0, 4.0]), np.array([2.0, 0.5])
    damping = np.tile(np.diag(size**2), (4, 1, 1))
    calm = RadiationSamples(omega, 0 * damping, damping, np.zeros((2, 2)), size)
    assert calm.drawn == 0.0
    assert calm.transfer == pytest.approx(np.tile(np.eye(2), (4, 1, 1)))
    damping[2] += 1.25 * np.array([[0.0, 1.0], [1.0, 0.0]])
    assert RadiationSamples(omega, 0 * damping, damping, np.zeros((2, 2)), size).drawn == pytest.approx(-0.25)


def test_samples_are_damping_and_added_mass_less_its_limit():
    omega, size, limit = np.array([1.0, 2.0, 3.0, 4.0]), np.array([2.0, 0.5]), np.array([[3.0, 1.0], [1.0, -2.0]])
    a, b = (np.random.default_rng(i).normal(size=(4, 2, 2)) for i in range(2))
    a, b = a + a.swapaxes(1, 2), b + b.swapaxes(1, 2)
    expected = (b + 1j * omega[:, None, None] * (a - limit)) / np.array([[4.0, 1.0], [1.0, 0.25]])
    assert RadiationSamples(omega, a, b, limit, size).transfer == pytest.approx(expected)


def test_what_neither_radiates_nor_weighs_anything_is_measured_in_one():
    """And what draws is measured by its inertia, at the frequency where it draws most."""
    omega, damping = np.array([0.5, 1.0, 2.0]), np.zeros((3, 2, 2))
    damping[:, 1, 1] = [-1.0, -2.0, -5.0]
    assert sizes(omega, damping, np.array([0.0, 4.0]), 1e-2) ** 2 == pytest.approx([1.0, 1e-2 * 2.0 * 4.0])


def test_a_fit_tells_of_all_that_was_repaired():
    fit = passive.PassiveFit(reciprocal(4, 1, 1, 0), 1e-4, -0.012, -0.0034, 0.0056, np.eye(1), 0.0078)
    assert fit.history == (
        "radiation memory, in terms of each motion's largest damping: least eigenvalue of the damping given -1.2e-02, "
        "of its rational fit -3.4e-03, made passive by a change of 5.6e-03, "
        "added mass at infinite frequency fitted, a change of 7.8e-03 of the diagonal's"
    )
    only = "radiation memory, in terms of each motion's largest damping: least eigenvalue of the damping given -1.2e-02"
    assert fit._replace(drawn=0.0, shifted=0.0).history == only


def test_the_error_is_the_largest_rms_of_any_entry():
    """Not the largest at any frequency, nor that of all entries; complex, and off the diagonal."""
    difference = np.zeros((4, 2, 2), dtype=complex)
    difference[0, 0, 0], difference[:, 0, 1] = 5.0, [3.0, 3.0j, -3.0, 2.0]
    assert entry_error(difference) == pytest.approx(np.sqrt(31 / 4))


def test_the_limit_that_suits_what_is_missed_is_symmetric_and_of_least_squares():
    """An even i omega D is found whatever real parts are beside it; of an uneven one the even part."""
    omega = np.array([0.5, 1.0, 3.0])
    d = np.array([[1.0, 4.0], [-2.0, -3.0]])
    missed = 1j * omega[:, None, None] * d + 7.0
    assert passive.limit_shift(omega, missed) == pytest.approx(np.array([[1.0, 1.0], [1.0, -3.0]]))
    odd = missed + 1j * np.array([3.0, 0.0, -0.5])[:, None, None]  # at right angles to omega
    assert passive.limit_shift(omega, odd) == pytest.approx(np.array([[1.0, 1.0], [1.0, -3.0]]))
    left = passive._without_rate(omega, odd)
    assert left == pytest.approx(odd - 1j * omega[:, None, None] * d)
    assert np.einsum("w,wij->ij", omega, left.imag) == pytest.approx(np.zeros((2, 2)), abs=1e-12)


@pytest.mark.parametrize(("least", "count"), [(0.19, 3), (0.21, 2), (0.53, 2), (0.55, 1), (2.06, 1), (2.08, 0)])
def test_what_is_left_out_of_the_directions_is_less_in_all_than_allowed(least, count):
    """Rms over frequency: of the third alone 0.2, with the second 0.54, with the first 2.07."""
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    k = np.array([turn @ np.diag([2.0, 0.5j, -0.2]) @ turn.T] * 5)
    lead = leading_directions(k, least)
    assert lead.shape == (3, count)
    assert np.abs(lead.T @ turn[:, :count]) == pytest.approx(np.eye(count), abs=1e-12)


def test_stored_energy_and_its_rates_are_those_of_the_factor():
    """A^T P + P A = -F F^T, P symmetric, and the slope of C = B^T P by each entry of F, by central differences."""
    true, rng = reciprocal(6, 2, 2, 0), np.random.default_rng(1)
    outputs = passive._PassiveOutputs(true.state_matrix, true.input_matrix)
    factor = rng.normal(size=(6, 3))
    p, a = outputs.energy(factor), true.state_matrix
    assert a.T @ p + p @ a == pytest.approx(-factor @ factor.T, abs=1e-10)
    assert np.array_equal(p, p.T)
    slope, h = outputs.slope(factor), 1e-5
    for i, j in ((0, 0), (3, 1), (5, 2)):
        step = h * np.eye(6)[:, i : i + 1] * np.eye(3)[j]
        change = (outputs.energy(factor + step) - outputs.energy(factor - step)) @ true.input_matrix / (2 * h)
        assert slope[:, :, i, j] == pytest.approx(change, abs=1e-7 * np.abs(slope).max())


def test_a_start_makes_the_output_lifted_by_epsilon_passive():
    """F F^T of Riccati's equation: |H|^2/(2 epsilon) of the spectral factor is the Hermitian part of K + epsilon."""
    true = reciprocal(6, 2, 2, 0)
    outputs = passive._PassiveOutputs(true.state_matrix, true.input_matrix)
    factor, epsilon = outputs.start(1.02 * true.input_matrix.T, 0.3), 0.3
    inside = np.linalg.inv(1j * OMEGA[:, None, None] * np.eye(6) - true.state_matrix) @ true.input_matrix
    h = factor.T @ inside + np.sqrt(2 * epsilon) * np.eye(2)
    k = 1.02 * true.input_matrix.T @ inside
    lifted = k + k.conj().swapaxes(1, 2) + 2 * epsilon * np.eye(2)
    assert h.conj().swapaxes(1, 2) @ h == pytest.approx(lifted, abs=1e-9)


def test_a_model_of_combinations_is_in_the_motions_they_are_of():
    true = reciprocal(6, 3, 2, 0)
    lead = np.array([[0.6, 0.0], [0.0, -1.0], [0.8, 0.0]])
    model = passive._PassiveOutputs(true.state_matrix, true.input_matrix).model(true.channel, lead)
    assert model.transfer(OMEGA) == pytest.approx(lead @ true.transfer(OMEGA) @ lead.T, abs=1e-9)


def test_the_shortest_is_within_the_tolerance_and_no_shorter_one_is():
    model = reciprocal(12, 4, 3, 0)
    k = model.transfer(OMEGA)
    errors = [entry_error(truncated(model, order).transfer(OMEGA) - k) for order in range(1, 13)]
    for tolerance in (errors[3] * 1.001, errors[8] * 1.001, 0.0):
        order = passive.shortest(model, OMEGA, k, tolerance).order
        assert order == 12 or errors[order - 1] <= tolerance
        assert order == 1 or errors[order - 2] > tolerance
    assert passive.shortest(model, OMEGA, k, 2 * max(errors)).order == 1


@pytest.mark.parametrize("limit", ["given", "fitted"])
def test_groups_whose_motions_alternate_come_out_in_their_places(limit):
    """First and third radiate together, the second by itself, each in its own units; each with its own wrong limit."""
    one, other = reciprocal(6, 2, 2, 1), reciprocal(4, 1, 1, 2)
    units, pair = np.array([1.0, 30.0, 0.2]), np.ix_([0, 2], [0, 2])
    k = np.zeros((len(OMEGA), 3, 3), dtype=complex)
    k[:, [[0], [2]], [0, 2]], k[:, 1, 1] = one.transfer(OMEGA), other.transfer(OMEGA)[:, 0, 0]
    k *= np.outer(units, units)
    wrong = np.zeros((3, 3))
    if limit == "fitted":
        wrong[pair], wrong[1, 1] = [[0.02, -0.005], [-0.005, 0.03]], -0.01
        wrong *= np.outer(units, units)
    base = np.diag([4.0, 0.0, 1.0]) * np.outer(units, units)
    given_ = RadiationSamples(
        OMEGA, base + k.imag / OMEGA[:, None, None], k.real, base - wrong, sizes(OMEGA, k.real, np.zeros(3))
    )
    fit = fit_passive(given_, 1e-3, limit=limit)
    scale = np.outer(given_.size, given_.size)
    assert fit.error < 1e-3
    found = fit.model.transfer(OMEGA) + 1j * OMEGA[:, None, None] * (fit.added_mass_inf - base)
    assert entry_error((found - k) / scale) == pytest.approx(fit.error, rel=1e-6, abs=1e-12)
    shift = fit.added_mass_inf - given_.added_mass_inf
    own = np.sqrt(np.maximum(np.abs(np.diag(given_.added_mass_inf)), np.abs(np.diag(shift))) + 1e-100)
    assert fit.shifted == pytest.approx(np.abs(shift / np.outer(own, own)).max(), abs=1e-12)
    assert not fit.model.transfer(OMEGA)[:, 1, [0, 2]].any()


@pytest.mark.parametrize(("share", "refused"), [(0.019, False), (0.021, True)])
def test_damping_is_refused_from_two_percent_below_nothing_on(share, refused):
    good = samples(reciprocal(6, 2, 2, 0))
    lowest = np.linalg.eigvalsh(good.transfer.real).min()
    below = replace(good, damping=good.damping - (lowest + share) * np.diag(good.size**2))
    assert below.drawn == pytest.approx(-share)
    if not refused:
        assert fit_passive(below, 1e-2).sampled == below.drawn
        return
    words = "a least eigenvalue of -0.021 relative to each motion's largest damping, needs at least -0.02; motion would"
    with pytest.raises(StabilityError, match=words):
        fit_passive(below, 1e-2)


@pytest.mark.parametrize("tolerance", [0.9e-9, 0.11])
def test_tolerances_just_beyond_are_refused(tolerance):
    with pytest.raises(ConvergenceError, match=rf"^tolerance: received {tolerance:g}, needs 1e-9 to 0.1\."):
        fit_passive(samples(reciprocal(4, 2, 1, 0)), tolerance)


def test_the_coarsest_tolerance_is_taken():
    assert fit_passive(samples(reciprocal(4, 2, 1, 0)), 0.1).error <= 0.02


@pytest.mark.parametrize("name", ["added_mass", "damping", "added_mass_inf"])
def test_an_asymmetry_is_in_terms_of_the_largest_entry_whatever_that_is(name):
    """Either way; of a matrix of a thousand of what it is measured in and of one of a thousandth."""
    omega, size = np.array([1.0, 2.0, 3.0, 4.0]), np.array([2.0, 0.5])
    for largest in (1e3, 1e-3):
        for share in (0.9e-6, -0.9e-6, 1.1e-6, -1.1e-6):
            even = largest * np.array([[1.0, 0.2], [0.2, 0.5]])
            even[1, 0] += share * largest
            parts = {
                "added_mass": np.ones((4, 2, 2)), "damping": np.ones((4, 2, 2)), "added_mass_inf": np.ones((2, 2)),
            }  # fmt: skip
            parts[name] = parts[name] * even * np.outer(size, size)
            if name != "added_mass_inf":
                parts[name][:3] = 0.0
            made = {key: value * (np.outer(size, size) if key != name else 1.0) for key, value in parts.items()}
            if abs(share) < 1e-6:
                RadiationSamples(omega, size=size, **made)
                continue
            with pytest.raises(DatabaseError, match=rf"^{name}: received an asymmetry of 1.1e-06 of its largest entry"):
                RadiationSamples(omega, size=size, **made)


def fitted_with(monkeypatch, parts, groups):
    """What `fit_passive` makes of parts fitted apart, given as they come."""
    given = iter(parts)
    monkeypatch.setattr(passive, "_fit_block", lambda *_: next(given))
    monkeypatch.setattr(passive, "_fit_limit", lambda *_: next(given))
    monkeypatch.setattr(passive, "coupled", lambda k, least: [np.array(group) for group in groups])


@pytest.mark.parametrize("turned", [False, True])
def test_of_parts_the_least_drawn_and_the_most_changed_are_told(monkeypatch, turned):
    """By different parts, one of which radiates nothing; the shift of each at its own motions."""
    true = reciprocal(4, 2, 1, 0)
    made = samples(reciprocal(6, 2, 3, 1))
    shift = np.array([[1e-3]])
    parts = [
        passive._Part(true, 0.0, -0.03, 0.01, shift),
        passive._Part(None, np.inf, 0.0, 0.0, 0 * shift),
        passive._Part(true, 0.0, -0.01, 0.04, -2 * shift),
    ]
    groups = [[0], [1], [2]]
    if turned:
        parts, groups = parts[::-1], groups[::-1]
    monkeypatch.setattr(passive, "UNUSABLE", 1e3)
    fitted_with(monkeypatch, parts, groups)
    fit = fit_passive(made, 1e-3, limit="fitted")
    assert (fit.drawn, fit.changed) == (-0.03, 0.04)
    units = made.size**2
    expected = np.diag([1e-3 * units[0], 0.0, -2e-3 * units[2]])
    assert fit.added_mass_inf - made.added_mass_inf == pytest.approx(expected, abs=1e-12)
    assert fit.shifted == pytest.approx(np.abs(expected / 50.0).max())
    assert not fit.model.input_matrix[:, 1].any()
    k = true.transfer(OMEGA)[:, 0, 0]
    for at in (0, 2):
        assert fit.model.transfer(OMEGA)[:, at, at] == pytest.approx(k * units[at])


@pytest.mark.parametrize(("second", "better"), [(0.5e-3, True), (2e-3, False), (1e-3, False)])
def test_a_limit_is_found_twice_and_the_better_is_kept(monkeypatch, second, better):
    """The second of what the first leaves, its shift added to the first's."""
    omega, k = np.array([1.0, 2.0]), np.array([[[1.0 + 2j]], [[3.0 - 1j]]])
    parts = [passive._Part(None, 1e-3, 0, 0, np.array([[0.5]])), passive._Part(None, second, 0, 0, np.array([[-0.1]]))]
    asked = []

    def block(*given):
        asked.append(given)
        return parts[len(asked) - 1]

    monkeypatch.setattr(passive, "_fit_block", block)
    found = passive._fit_limit(omega, k, 0.01)
    assert found.error == (second if better else 1e-3)
    assert found.shift == pytest.approx(np.array([[0.4 if better else 0.5]]))
    assert [(tolerance, limit) for _, _, tolerance, limit in asked] == [(0.01, "fitted")] * 2
    assert asked[1][1] == pytest.approx(k - 1j * omega[:, None, None] * 0.5)


def test_a_start_is_lifted_until_there_is_one(monkeypatch):
    """Four times each time, from what is asked for."""
    true = reciprocal(6, 2, 2, 0)
    outputs = passive._PassiveOutputs(true.state_matrix, true.input_matrix)
    asked, solve = [], passive.solve_continuous_are

    def refuses_thrice(a, b, q, r, **others):
        asked.append(r[0, 0])
        if len(asked) < 4:
            raise np.linalg.LinAlgError("no solution")
        return solve(a, b, q, r, **others)

    monkeypatch.setattr(passive, "solve_continuous_are", refuses_thrice)
    factor = outputs.start(true.input_matrix.T, 0.01)
    assert asked == pytest.approx([0.02, 0.08, 0.32, 1.28])
    monkeypatch.undo()
    assert factor == pytest.approx(outputs.start(true.input_matrix.T, 0.64))


def test_candidates_have_more_poles_until_two_numbers_of_them_gain_nothing(monkeypatch):
    """Of noise the best is reduced to within half as much again; of what is fitted each that is near enough."""
    omega, tried, reduced = np.linspace(0.1, 6.0, 41), [], []
    errors = {4: 1.0, 6: 0.5, 8: 0.46, 10: 0.47, 12: 0.1, 14: 0.1, 16: 0.1, 20: 0.1}

    class Fit:
        def __init__(self, poles):
            self.poles = poles

        def transfer(self, at):
            return errors[self.poles] * np.ones((len(at), 1, 1))

    def fit(at, k, poles):
        tried.append(poles)
        return Fit(poles)

    def reductions(at, k, whole, tolerance):
        reduced.append((whole.poles, tolerance))
        yield whole

    monkeypatch.setattr(passive, "rational_fit", fit)
    monkeypatch.setattr(passive, "_reductions", reductions)
    k = np.zeros((41, 1, 1), dtype=complex)
    assert [each.poles for each in passive._candidates(omega, k, 1e-3)] == [8]
    assert tried == [4, 6, 8, 10, 8]
    assert reduced == [(8, pytest.approx(0.69))]
    tried.clear()
    reduced.clear()
    assert [each.poles for each in passive._candidates(omega, k, 0.93)] == [8]
    assert tried == [4, 6, 8, 10]
    assert reduced == [(8, 0.93)]
    tried.clear()
    errors[8] = 0.44
    assert [each.poles for each in passive._candidates(omega, k, 0.3)] == [12, 14, 16]
    assert tried == [4, 6, 8, 10, 12, 14, 16]
    tried.clear()
    list(passive._candidates(omega[:13], k[:13], 1e-3))
    assert tried == [4, 6, 6]
    tried.clear()
    list(passive._candidates(omega[:5], k[:5], 1e-3))
    assert tried == [4, 4]


def test_reductions_are_the_shortest_within_the_tolerance_and_a_quarter_more():
    whole = StateSpace(*(lambda m: (m.state_matrix, m.input_matrix, m.input_matrix.T))(reciprocal(16, 8, 2, 3)))
    k = whole.transfer(OMEGA)
    balanced = passive.Balanced.of(whole)
    errors = [entry_error(balanced.truncated(order).transfer(OMEGA) - k) for order in range(1, balanced.order + 1)]
    for order in (4, 9, balanced.order):
        tolerance = 1.0001 * max(errors[order - 1], 1e-9) / 0.7
        found = [len(one.state_matrix) for one in passive._reductions(OMEGA, k, whole, tolerance)]
        low = found[0]
        assert errors[low - 1] <= 0.7 * tolerance
        assert low == 1 or errors[low - 2] > 0.7 * tolerance
        assert found == sorted({low, min(low + max(1, low // 4), balanced.order)})


def test_poles_above_the_band_are_reached_by_all_motions_and_leave_the_others_as_they_are():
    true = reciprocal(4, 2, 2, 0)
    a, b = passive._widened(true.state_matrix, true.input_matrix, np.array([-1.0 + 5j, -2.0 + 8j]))
    assert a.shape == (12, 12)
    assert b.shape == (12, 2)
    assert np.array_equal(a[:4, :4], true.state_matrix)
    assert np.array_equal(b[:4], true.input_matrix)
    assert not a[:4, 4:].any()
    assert not a[4:, :4].any()
    poles = np.sort_complex(np.linalg.eigvals(a[4:, 4:]))
    assert poles == pytest.approx(np.repeat(np.sort_complex([-1 + 5j, -1 - 5j, -2 + 8j, -2 - 8j]), 2))
    states = np.linalg.solve(3j * np.eye(8) - a[4:, 4:], b[4:])
    assert np.linalg.matrix_rank(states) == 2
    none = passive._widened(true.state_matrix, true.input_matrix, np.zeros(0, dtype=complex))
    assert np.array_equal(none[0], true.state_matrix)
    assert np.array_equal(none[1], true.input_matrix)


class Known:
    """A model of a known transfer function."""

    def __init__(self, k, order=8):
        self.k, self.order = k, order

    def transfer(self, omega):
        return self.k


@pytest.mark.parametrize("limit", ["given", "fitted"])
@pytest.mark.parametrize(
    ("errors", "tried", "best"), [((0.05, 0.02, 0.03), 3, 1), ((0.05, 0.009, 0.001), 2, 1), ((0.04, 0.041, 0.05), 3, 0)]
)
def test_of_candidates_the_nearest_is_kept_and_shortened(monkeypatch, limit, errors, tried, best):
    """The first within the tolerance ends it. Poles above the band are for those that draw by more than their share.

    A third motion radiates less than what may be left out. What is told of is the candidate kept: what it drew, and
    by how much the model, with its shift of added mass, is another.
    """
    omega, tolerance, asked = np.linspace(0.5, 3.0, 7), 0.01, []
    rate, two = 1j * omega[:, None, None], np.array([[2.0, 0.5], [0.5, 1.0]])
    k = np.zeros((7, 3, 3), dtype=complex)
    k[:, :2, :2] = two * (1 + 0.3j * np.cos(3 * omega)[:, None, None])
    k[:, 2, 2] = 0.9e-3
    wrong = np.array([[0.3, 0.1, 0.0], [0.1, -0.2, 0.0], [0.0, 0.0, 0.0]]) if limit == "fitted" else np.zeros((3, 3))
    candidates = [StateSpace(*(lambda m: (m.state_matrix, m.input_matrix, m.input_matrix.T))(reciprocal(4, 2, 2, i)))
                  for i in range(3)]  # fmt: skip
    drawn = [(-1.1e-3, -0.002), (-0.9e-3, -0.004), (-0.5, -0.6)]
    models = [Known(k - rate * wrong + error * np.eye(3)[0] * np.eye(3)[0][:, None]) for error in errors]

    class Outputs:
        def __init__(self, a, b):
            self.a, self.number = a, len([name for name, *_ in asked if name == "states"])
            asked.append(("states", len(a), len(b)))

        def start(self, output, epsilon):
            asked.append(("start", output.shape, epsilon))
            return f"start {self.number}"

        def fitted(self, at, inside, start, enough, given_limit):
            asked.append(("fitted", inside.shape, start, enough, given_limit))
            return f"factor {self.number}"

        def model(self, factor, lead):
            assert lead.T @ lead == pytest.approx(np.eye(2))
            assert not lead[2].any()
            assert factor == f"factor {self.number}"
            return models[self.number]

    def shortest(model, at, own, within):
        asked.append(("shortest", models.index(model), within))
        assert own == pytest.approx(model.k - errors[models.index(model)] * np.diag([1.0, 0, 0]), abs=1e-9)
        return Known(model.k + 1e-3 * np.diag([1.0, 0, 0]))

    def least(free):
        (number,) = (i for i, one in enumerate(candidates) if one is free)
        return SimpleNamespace(value=drawn[number][0], bound=drawn[number][1])

    monkeypatch.setattr(passive, "_candidates", lambda *given: iter(candidates))
    monkeypatch.setattr(passive, "least_damping", least)
    monkeypatch.setattr(passive, "_PassiveOutputs", Outputs)
    monkeypatch.setattr(passive, "shortest", shortest)
    part = passive._fit_block(omega, k, tolerance, limit)
    widths = [12, 4, 12][:tried]
    assert [each for each in asked if each[0] == "states"] == [("states", n, n) for n in widths]
    assert [each for each in asked if each[0] == "start"] == [
        ("start", (2, n), -drawn[i][1]) for i, n in enumerate(widths)
    ]
    assert [each for each in asked if each[0] == "fitted"] == [
        ("fitted", (7, 2, 2), f"start {i}", pytest.approx(1e-3), limit) for i in range(tried)
    ]
    kept = [i for i in range(tried) if errors[i] < min(errors[:i], default=np.inf)]
    assert [each for each in asked if each[0] == "shortest"] == [
        ("shortest", i, pytest.approx(max(0.01, 1.02 * errors[i]))) for i in kept
    ]
    assert kept[-1] == best
    assert part.error == pytest.approx(errors[best] + 1e-3)
    assert part.drawn == drawn[best][0]
    assert part.shift == pytest.approx(wrong)
    lead = passive.leading_directions(k, 1e-3)
    free = lead @ candidates[best].transfer(omega) @ lead.T
    assert part.changed == pytest.approx(entry_error(part.model.k + rate * wrong - free))


def test_of_motions_that_radiate_less_than_may_be_left_out_nothing_is_fitted():
    k = np.full((5, 2, 2), 0.4e-3 + 0j)
    part = passive._fit_block(np.arange(1.0, 6.0), k, 1e-2)
    assert part.model is None
    assert (part.error, part.drawn, part.changed, part.shift.tolist()) == (np.inf, 0.0, 0.0, [[0.0] * 2] * 2)


@pytest.mark.parametrize("limit", ["given", "fitted"])
def test_motions_couple_by_a_tenth_of_the_tolerance_and_each_group_is_fitted_to_all_of_it(monkeypatch, limit):
    """Those of a group in their order, by the rows and columns that are theirs; all frequencies."""
    made, true, asked = samples(reciprocal(6, 2, 3, 1)), reciprocal(4, 2, 1, 0), []
    fits = {"given": "_fit_block", "fitted": "_fit_limit"}

    def fit(omega, k, tolerance):
        asked.append((omega, k, tolerance))
        return passive._Part(
            replace(true, input_matrix=np.tile(true.input_matrix, (1, k.shape[1]))), 0, 0, 0, 0 * k[0].real
        )

    monkeypatch.setattr(passive, "UNUSABLE", 1e3)
    monkeypatch.setattr(
        passive, "coupled", lambda k, least: asked.append((k, least)) or [np.array([0, 2]), np.array([1])]
    )
    monkeypatch.setattr(passive, fits.pop(limit), fit)
    monkeypatch.setattr(passive, *fits.values(), None)
    fit_passive(made, 3e-3, limit=limit)
    assert asked[0] == (made.transfer, pytest.approx(3e-4))
    pairs = ([[0], [2]], [0, 2]), ([[1]], [1])
    for (omega, k, tolerance), pair in zip(asked[1:], pairs, strict=True):
        np.testing.assert_array_equal(omega, OMEGA)
        np.testing.assert_array_equal(k, made.transfer[:, *pair])
        assert tolerance == 3e-3


@pytest.mark.parametrize(
    ("field", "value", "told"),
    [
        ("sampled", -1e-9, "least eigenvalue of the damping given -1.0e-09"),
        ("drawn", -1e-9, "of its rational fit -1.0e-09, made passive by a change of 2.0e-10"),
        ("shifted", 1e-9, "added mass at infinite frequency fitted, a change of 1.0e-09 of the diagonal's"),
    ],
)
def test_a_repair_is_told_however_small_it_is(field, value, told):
    fit = passive.PassiveFit(reciprocal(4, 1, 1, 0), 1e-4, 0.0, 0.0, 2e-10, np.eye(1), 0.0)
    assert fit.history == ""
    assert (
        fit._replace(**{field: value}).history == f"radiation memory, in terms of each motion's largest damping: {told}"
    )


@pytest.mark.parametrize("limit", ["given", "fitted"])
def test_what_a_factor_makes_small_is_the_distance_from_all_that_was_sampled(monkeypatch, limit):
    """But for a constant, and for what any i omega D makes good where the limit is fitted; with its rates by each entry."""
    true, rng, told = reciprocal(6, 2, 2, 0), np.random.default_rng(7), []
    outputs = passive._PassiveOutputs(true.state_matrix, true.input_matrix)
    omega = np.array([0.3, 0.9, 1.4, 2.0, 3.1, 3.3, 5.0])
    k = rng.normal(size=(7, 2, 2)) + 1j * rng.normal(size=(7, 2, 2))

    def least(residual, jacobian, start, near):
        told.append((residual, jacobian, start, near))
        return start + 1.0

    monkeypatch.setattr(passive, "levenberg_marquardt", least)
    start = rng.normal(size=(6, 2))
    assert outputs.fitted(omega, k, start, 0.02, limit) == pytest.approx(start + 1.0)
    ((residual, jacobian, given_, near),) = told
    assert given_.tolist() == start.ravel().tolist()
    assert near == pytest.approx(7 * 0.02**2)

    def distance(entries):
        inside = np.linalg.solve(1j * omega[:, None, None] * np.eye(6) - true.state_matrix, true.input_matrix[None])
        missed = (outputs.energy(entries.reshape(6, 2)) @ true.input_matrix).T @ inside - k
        if limit == "fitted":
            missed = missed - 1j * omega[:, None, None] * np.einsum("w,wij->ij", omega, missed.imag) / (omega @ omega)
        return (np.abs(missed) ** 2).sum()

    one, other = rng.normal(size=(2, 12))
    apart = residual(one) @ residual(one) - residual(other) @ residual(other)
    assert apart == pytest.approx(distance(one) - distance(other), rel=1e-9)
    for at in range(12):
        step = 1e-5 * np.eye(12)[at]
        change = (residual(one + step) - residual(one - step)) / 2e-5
        np.testing.assert_allclose(jacobian(one)[:, at], change, atol=1e-6 * np.abs(jacobian(one)).max())
