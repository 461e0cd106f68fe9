import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.errors import StabilityError
from vsb.hydro.passivity import LEVEL, StateSpace, crossings, least_damping


def dissipative(order, channels, dof, seed):
    """A random passive state space."""
    rng = np.random.default_rng(seed)
    skew, channel, g = (rng.normal(size=(order, n)) for n in (order, channels, dof))
    return StateSpace(skew - skew.T - channel @ channel.T / 2, g, g.T)


@settings(max_examples=20)
@given(st.integers(2, 10), st.integers(1, 4), st.integers(1, 4), st.integers(0, 10**6))
def test_a_dissipative_state_space_is_proven_passive(order, channels, dof, seed):
    system = dissipative(order, channels, dof, seed)
    found = least_damping(system)
    size = np.abs(system.transfer(np.abs(np.linalg.eigvals(system.state_matrix)))).max()
    assert -1e-9 * size < found.value <= 0.0
    assert -2 * LEVEL * size < found.bound < found.value


@settings(max_examples=20)
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
def test_a_violation_between_samples_is_seen(width):
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


def test_the_level_is_crossed_where_it_is():
    """K = 1/(s + 1) has damping 1/(1 + omega^2): -K crosses -1/5 at omega = 2."""
    system = StateSpace(np.array([[-1.0]]), np.ones((1, 1)), -np.ones((1, 1)))
    assert crossings(system, 0.2) == pytest.approx([2.0])
    assert least_damping(system) == pytest.approx((-1.0, 0.0, -1.001), rel=1e-6)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("level", [0.1, 1.0])
def test_what_gives_no_energy_crosses_no_level_of_it_and_what_does_crosses_it_where_found(seed, level):
    """At each frequency an eigenvalue of the Hermitian part is minus the level, and there are as many as on a grid."""
    system = dissipative(6, 2, 2, seed)
    assert crossings(system, level).size == 0
    giving = system._replace(output_matrix=-system.output_matrix)
    found = crossings(giving, level)
    k = giving.transfer(found)
    eigenvalues = np.linalg.eigvalsh((k + k.conj().transpose(0, 2, 1)) / 2)
    assert np.abs(eigenvalues + level).min(axis=1, initial=np.inf) == pytest.approx(
        np.zeros(len(found)), abs=1e-6 * level
    )


def test_an_unstable_state_matrix_is_refused():
    with pytest.raises(StabilityError, match=r"received a pole with growth rate 0.5/s, needs a stable"):
        least_damping(StateSpace(np.array([[0.5]]), np.ones((1, 1)), np.ones((1, 1))))
