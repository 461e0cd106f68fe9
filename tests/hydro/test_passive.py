from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from vsb.engine.hydro.passive import (
    LEVEL,
    Balanced,
    RadiationSamples,
    StateSpace,
    crossings,
    entry_error,
    fit_lowest,
    fit_passive,
    least_damping,
    rational_fit,
    sizes,
)
from vsb.engine.hydro.radiation import DampingSpectrum, RadiationModel
from vsb.errors import ConvergenceError, DatabaseError, StabilityError

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


def is_passive(model):
    """Whether a Hamiltonian matrix proves a model's damping, scaled, nowhere negative."""
    scale = np.linalg.norm(model.input_matrix, axis=0)
    g = model.input_matrix / np.where(scale > 0, scale, 1.0)
    found = least_damping(StateSpace(model.state_matrix, g, g.T))
    return found.value > 0.75 * found.bound  # less than three times the level of the proof, 1e-8 of the largest entry


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


def smooth(dof=3):
    """Samples of damping that no state space has: two channels, B = h h^T/2 summed, with its added mass."""
    omega = np.arange(1, 161) * 0.05
    n = np.arange(1.0, dof + 1)
    one, other = omega[:, None] ** 2 * np.exp(-omega[:, None] * n / dof), omega[:, None] * np.exp(-omega[:, None] / n)
    damping = one[:, :, None] * one[:, None, :] + other[:, :, None] * other[:, None, :] * (-1) ** (n[:, None] + n)
    change = DampingSpectrum(omega, damping).added_mass_difference(omega)
    return RadiationSamples(omega, np.eye(dof) + change, damping, np.eye(dof), sizes(omega, damping, np.zeros(dof)))


def test_error_falls_and_order_grows_with_the_tolerance():
    tolerances = (1e-2, 1e-3)
    fits = [fit_passive(smooth(), tolerance) for tolerance in tolerances]
    assert all(fit.error <= tolerance for fit, tolerance in zip(fits, tolerances, strict=True))
    orders = [fit.model.order for fit in fits]
    assert orders == sorted(orders)
    assert orders[0] < orders[-1]
    assert all(is_passive(fit.model) for fit in fits)


@pytest.mark.parametrize("noise", [1e-4, 1e-3, 5e-3])
def test_noise_is_repaired_and_reported(noise):
    true = reciprocal(8, 4, 3, 0)
    fit = fit_passive(samples(true, noise=noise), 1e-5)
    assert fit.error < 3 * noise
    assert is_passive(fit.model)
    assert fit.drawn < 0 < fit.changed < 3 * noise
    assert "made passive by a change of" in fit.history
    size = samples(true).size
    assert entry_error((fit.model.transfer(OMEGA) - true.transfer(OMEGA)) / np.outer(size, size)) < 2 * noise


def test_damping_sampled_slightly_negative_is_repaired_and_reported():
    model = samples(reciprocal(8, 4, 3, 0))
    lowest = model.drawn - 0.01
    damping = model.damping - 0.01 * np.diag(model.size**2)
    fit = fit_passive(replace(model, damping=damping), 1e-3)
    assert fit.sampled < lowest + 0.01
    assert 3e-3 < fit.error < 0.02
    assert "least eigenvalue of the damping given" in fit.history
    assert is_passive(fit.model)


def test_band_with_irregular_frequencies_is_fitted_below_them():
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


def test_a_wrong_limit_is_found_and_reported():
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


class TestHardCases:
    def test_yaw_of_a_round_body_radiates_nothing_but_round_off(self):
        true = reciprocal(8, 3, 3, 1)
        model = samples(replace(true, input_matrix=true.input_matrix * np.array([1.0, 1.0, 1e-9])))
        noise = 1e-9 * np.random.default_rng(1).normal(size=model.damping.shape)
        given_ = replace(model, damping=model.damping + noise + noise.swapaxes(1, 2))
        fit = fit_passive(given_, 1e-3)
        assert fit.error < 1e-3
        assert not fit.model.input_matrix[:, 2].any()

    def test_size_of_motions_without_inertia_is_from_damping(self):
        k = reciprocal(6, 2, 2, 3).transfer(OMEGA)
        size = sizes(OMEGA, k.real, np.zeros(2))
        assert size == pytest.approx(np.sqrt(np.einsum("wii->wi", k.real).max(axis=0)))

    def test_thirty_motions_of_two_channels_need_few_states(self):
        fit = fit_passive(samples(reciprocal(8, 2, 30, 4)), 1e-3)
        assert fit.error < 1e-3
        assert fit.model.order == 8
        assert fit.model.input_matrix.shape == (8, 30)

    def test_narrow_resonance_of_a_gap_is_fitted(self):
        fine = np.union1d(OMEGA, np.linspace(2.1, 2.3, 41))
        # a body's memory, and one of its motions coupled to a gap whose water swings with hardly any damping
        one = reciprocal(8, 3, 3, 7)
        gap = np.array([[0.0, 2.2], [-2.2, -5e-3]])
        g = np.vstack([one.input_matrix, [[0.0, 0.0, 0.0], [0.3, 0.0, 0.2]]])
        a = np.block([[one.state_matrix, np.zeros((8, 2))], [np.zeros((2, 8)), gap]])
        channel = np.block([[one.channel, np.zeros((8, 1))], [np.zeros((2, 3)), np.array([[0.0], [0.1]])]])
        fit = fit_passive(samples(RadiationModel(a, g, channel), fine), 1e-3)
        assert fit.error < 1e-3
        slowest = np.linalg.eigvals(fit.model.state_matrix)
        assert np.abs(slowest - (-2.5e-3 + 2.2j)).min() < 1e-3
        assert is_passive(fit.model)

    def test_uncoupled_groups_are_fitted_separately(self):
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

    def test_model_is_passive_above_the_band(self):
        """A band that ends before damping does: a plain fit of it draws energy above."""
        given_ = samples(reciprocal(20, 3, 3, 6), OMEGA[OMEGA < 2.5])
        fit = fit_passive(given_, 1e-3)
        assert fit.error < 5e-3
        assert is_passive(fit.model)


GOOD = samples(reciprocal(6, 2, 2, 0))
ASYMMETRIC = GOOD.damping + np.array([[0.0, 1.0], [0.0, 0.0]])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"damping": GOOD.damping[:, 0]}, r"damping: received shape \(80, 2\), needs \(80, 2, 2\)"),
        ({"added_mass": GOOD.added_mass * np.nan}, "added_mass: received NaN or infinite values"),
        ({"damping": ASYMMETRIC}, r"damping: received an asymmetry of .* use `with_symmetrized`"),
        ({"omega": OMEGA[::-1]}, "received 80 frequencies, needs four or more, positive and ascending"),
        ({"size": np.array([1.0, 0.0])}, "size: received values that are not positive, needs one above 0 for each"),
    ],
)
def test_errors_of_samples(changes, message):
    with pytest.raises(DatabaseError, match=message):
        replace(GOOD, **changes)


@pytest.mark.parametrize(
    ("changes", "tolerance", "error", "message"),
    [
        ({"damping": -GOOD.damping}, 1e-3, StabilityError, "least eigenvalue of -1.* would draw energy from calm water"),
        ({}, 0.5, ConvergenceError, "tolerance: received .*, needs 1e-9 to 0.1"),
        ({"damping": 0 * GOOD.damping, "added_mass": 0 * GOOD.added_mass + GOOD.added_mass_inf}, 1e-3, DatabaseError,
         "received damping of no motion"),
        ({"added_mass_inf": GOOD.added_mass_inf * 1.2}, 1e-3, ConvergenceError, "needs 0.02; most at .* rad/s: smaller panels"),
    ],
)  # fmt: skip
def test_samples_that_no_passive_model_fits(changes, tolerance, error, message):
    with pytest.raises(error, match=message):
        fit_passive(replace(GOOD, **changes), tolerance)


def oscillators(order, dof, seed):
    """A random stable state space with symmetric K."""
    rng, half = np.random.default_rng(seed), order // 2
    omega, g = np.diag(np.sort(rng.uniform(0.3, 4.0, half))), rng.normal(size=(half, dof))
    damping = rng.normal(size=(half, 3))
    a = np.block([[np.zeros((half, half)), omega], [-omega, -damping @ damping.T / 2]])
    b = np.vstack([np.zeros_like(g), g])
    return StateSpace(a, b, b.T)


def test_the_smallest_realisation_is_found():
    """All 24 states of a fit with full residues, of a function that has 8."""
    whole = rational_fit(OMEGA, oscillators(8, 3, 0).transfer(OMEGA), 8)
    short = Balanced.of(whole).truncated(8)
    assert short.transfer(OMEGA) == pytest.approx(whole.transfer(OMEGA), abs=1e-7)


def test_balanced_truncation_is_off_by_twice_the_other_singular_values_at_most():
    whole = oscillators(12, 2, 8)
    balanced = Balanced.of(whole)
    left, right = balanced.left, balanced.right
    assert left.T @ right == pytest.approx(np.eye(12), abs=1e-8)
    system = balanced.truncated(12)
    assert system.transfer(OMEGA) == pytest.approx(whole.transfer(OMEGA), abs=1e-9)
    # roots of the eigenvalues of the Gramians' product, by their integrals' linear equations, descending
    a, b, c = system
    n = len(a)
    one = np.kron(a, np.eye(n)) + np.kron(np.eye(n), a)
    two = np.kron(a.T, np.eye(n)) + np.kron(np.eye(n), a.T)
    reached, seen = (np.linalg.solve(m, -q.ravel()).reshape(n, n) for m, q in ((one, b @ b.T), (two, c.T @ c)))
    hankel = np.sort(np.sqrt(np.linalg.eigvals(reached @ seen).real))[::-1]
    for order in range(2, 12, 2):
        missed = np.linalg.norm(balanced.truncated(order).transfer(OMEGA) - whole.transfer(OMEGA), 2, axis=(1, 2)).max()
        assert missed <= 2 * hankel[order:].sum() + 1e-9
        assert missed > 1e-3 * hankel[order]


def dissipative(order, channels, dof, seed):
    """A random passive state space."""
    rng = np.random.default_rng(seed)
    skew, channel, g = (rng.normal(size=(order, n)) for n in (order, channels, dof))
    return StateSpace(skew - skew.T - channel @ channel.T / 2, g, g.T)


@settings(max_examples=20)
@given(st.integers(2, 10), st.integers(1, 4), st.integers(1, 4), st.integers(0, 10**6))
@example(5, 2, 3, 1)
def test_a_dissipative_state_space_is_proven_passive(order, channels, dof, seed):
    """To `LEVEL` of the largest |K|, which is not always where a pole is: here at frequency 0."""
    system = dissipative(order, channels, dof, seed)
    found = least_damping(system)
    poles = np.linalg.eigvals(system.state_matrix)
    size = np.abs(system.transfer(np.abs([0.0 * poles, poles, poles.imag]).ravel())).max()
    assert -1e-9 * size < found.value <= 0.0
    assert -2 * LEVEL * size < found.bound < found.value


@settings(max_examples=8)
@given(st.floats(-3.0, 0.0), st.integers(0, 10**6))
def test_the_least_damping_is_that_of_a_fine_grid(decade, seed):
    system = dissipative(8, 2, 3, seed)
    other = system.output_matrix + 10**decade * np.random.default_rng(seed + 1).normal(size=(3, 8))
    system = system._replace(output_matrix=other)
    found = least_damping(system)
    near = found.omega * (1 + np.linspace(-1e-3, 1e-3, 2001)) if np.isfinite(found.omega) else np.zeros(1)
    grid = np.concatenate([np.linspace(0.0, 40.0, 20001), near])
    least = system.damping(grid).min()
    assert found.bound < least
    assert found.value == pytest.approx(min(least, 0.0), rel=2e-3, abs=1e-5)
    if found.value < 0:
        assert system.damping(np.array([found.omega]))[0] == pytest.approx(found.value)


@pytest.mark.parametrize("width", [1e-4, 1e-6, 1e-8])
def test_violation_between_samples_is_found(width):
    """A resonance narrower than the samples are apart draws energy, which no sample shows."""
    one, at = dissipative(6, 2, 2, 3), 2.005
    a, b, c = one
    ring = np.array([[-width * at, at], [-at, -width * at]])
    wide = StateSpace(
        np.block([[a, np.zeros((6, 2))], [np.zeros((2, 6)), ring]]),
        np.vstack([b, [[1.0, 0.0], [0.0, 0.0]]]),
        np.hstack([c, [[-30.0 * width, 0.0], [0.0, 0.0]]]),
    )
    samples = np.arange(0.0, 10.0, 0.01)
    assert wide.damping(samples).min() > 0 < one.damping(np.array([at]))[0]
    found = least_damping(wide)
    assert found.omega == pytest.approx(at, rel=1e-3)
    assert found.value == pytest.approx(wide.damping(np.array([at]))[0], rel=1e-2)
    assert found.value < -0.5


def test_level_crossing_of_a_first_order_system():
    """K = 1/(s + 1) has damping 1/(1 + omega^2): -K crosses -1/5 at omega = 2."""
    system = StateSpace(np.array([[-1.0]]), np.ones((1, 1)), -np.ones((1, 1)))
    assert crossings(system, 0.2) == pytest.approx([2.0])
    assert least_damping(system) == pytest.approx((-1.0, 0.0, -1.001), rel=1e-6)


def test_an_unstable_state_matrix_is_refused():
    with pytest.raises(StabilityError, match=r"received a pole with growth rate 0.5/s, needs a stable"):
        least_damping(StateSpace(np.array([[0.5]]), np.ones((1, 1)), np.ones((1, 1))))
