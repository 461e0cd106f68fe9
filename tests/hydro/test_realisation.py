import numpy as np
import pytest

from vsb.hydro.realisation import Balanced, StateSpace, _combined, rational_fit

OMEGA = np.linspace(0.05, 6.0, 80)


def oscillators(order, dof, seed):
    """A random stable state space with symmetric K."""
    rng, half = np.random.default_rng(seed), order // 2
    omega, g = np.diag(np.sort(rng.uniform(0.3, 4.0, half))), rng.normal(size=(half, dof))
    damping = rng.normal(size=(half, 3))
    a = np.block([[np.zeros((half, half)), omega], [-omega, -damping @ damping.T / 2]])
    b = np.vstack([np.zeros_like(g), g])
    return StateSpace(a, b, b.T)


def test_a_rational_function_is_found():
    k = oscillators(8, 3, 0).transfer(OMEGA)
    whole = rational_fit(OMEGA, k, 8)
    assert whole.transfer(OMEGA) == pytest.approx(k, abs=1e-9)
    assert len(whole.state_matrix) == 24


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


def uneven(order, dof, seed):
    """A random stable state space whose K is not symmetric."""
    rng = np.random.default_rng(seed)
    one = oscillators(order, dof, seed)
    return one._replace(output_matrix=rng.normal(size=(dof, order)))


def test_balancing_tells_what_is_reached_from_what_is_seen():
    """Gramians of the truncated space, by their equations, are both the diagonal of Hankel's values."""
    whole = uneven(6, 2, 3)
    balanced = Balanced.of(whole)
    a, b, c = balanced.truncated(6)
    assert balanced.truncated(6).transfer(OMEGA) == pytest.approx(whole.transfer(OMEGA), abs=1e-9)
    hankel = np.diag(hankel_values(whole))
    assert a @ hankel + hankel @ a.T == pytest.approx(-b @ b.T, abs=1e-8)
    assert a.T @ hankel + hankel @ a == pytest.approx(-c.T @ c, abs=1e-8)


@pytest.mark.parametrize("unit", [1e-13, 1e13])
def test_a_function_is_found_in_any_units(unit):
    """Of what is round-off beside the largest, too."""
    k = oscillators(8, 3, 0).transfer(OMEGA)
    assert _combined(unit * k.reshape(len(k), -1)).shape == _combined(k.reshape(len(k), -1)).shape
    assert rational_fit(OMEGA, unit * k, 8).transfer(OMEGA) == pytest.approx(unit * k, abs=1e-9 * unit)
