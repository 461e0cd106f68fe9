import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from vsb.engine.hydro.realisation import LEVEL, Balanced, StateSpace, crossings, least_damping, rational_fit
from vsb.errors import StabilityError

OMEGA = np.linspace(0.05, 6.0, 80)


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
    hankel = hankel_values(system)
    for order in range(2, 12, 2):
        missed = np.linalg.norm(balanced.truncated(order).transfer(OMEGA) - whole.transfer(OMEGA), 2, axis=(1, 2)).max()
        assert missed <= 2 * hankel[order:].sum() + 1e-9
        assert missed > 1e-3 * hankel[order]


def hankel_values(system):
    """Roots of the eigenvalues of the Gramians' product, by their integrals' linear equations, descending."""
    a, b, c = system
    n = len(a)
    one = np.kron(a, np.eye(n)) + np.kron(np.eye(n), a)
    two = np.kron(a.T, np.eye(n)) + np.kron(np.eye(n), a.T)
    reached, seen = (np.linalg.solve(m, -q.ravel()).reshape(n, n) for m, q in ((one, b @ b.T), (two, c.T @ c)))
    return np.sort(np.sqrt(np.linalg.eigvals(reached @ seen).real))[::-1]


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
    """A resonance narrower than the samples are apart draws energy: no sample tells."""
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
