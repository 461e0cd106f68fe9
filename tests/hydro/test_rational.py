import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.engine.hydro.rational import interpolants, selected
from vsb.errors import ConvergenceError

GRID = np.linspace(0.1, 12.0, 400)
ONE = np.ones_like(GRID)


def resonances(omega, poles, residues, constant):
    """Real rational functions of -i omega with given poles below the real axis, one column per row of residues."""
    return (
        (1 / (omega[:, None] - poles)) @ residues.T
        - (1 / (omega[:, None] + poles.conj())) @ residues.conj().T
        + constant
    )


def body(count, columns, seed):
    """Poles, residues and limits of functions with a few resonances, as of floating bodies."""
    rng = np.random.default_rng(seed)
    poles = np.linspace(0.8, 8.0, count) + rng.uniform(-0.3, 0.3, count) - 1j * rng.uniform(0.5, 2.0, count)
    residues = rng.normal(size=(columns, count)) + 1j * rng.normal(size=(columns, count))
    return poles, residues, rng.normal(size=columns)


def samples(count):
    """Frequencies crowded to both ends of the band."""
    return 0.1 + 11.9 * (1 - np.cos(np.linspace(0.0, np.pi, count))) / 2


def slow(omega):
    """What deep water does at frequency zero: K log K."""
    s = -1j * omega
    return (s**2 * np.log(s) / (1 + s) ** 3)[:, None]


@pytest.mark.parametrize("count", [1, 2, 3, 4])
@pytest.mark.parametrize("columns", [1, 3, 20])
def test_a_rational_function_is_recovered_with_its_poles_and_limit(count, columns):
    """From as few samples as have as many equations as weights: one more support point than pairs of poles."""
    poles, residues, limit = body(count, columns, count)
    omega = samples(max(4, count + 1 + math.ceil((2 * count + 1) / (2 * columns))))
    found = interpolants(omega, resonances(omega, poles, residues, limit), np.ones(len(omega)))[count]
    exact = resonances(GRID, poles, residues, limit)
    assert np.abs(found(GRID) - exact).max() < 1e-9 * np.abs(exact).max()
    right = np.sort_complex(found.poles[found.poles.real > 0.0])
    there = [right[np.abs(right - p).argmin()] for p in poles]
    np.testing.assert_allclose(there, poles, rtol=1e-6)
    np.testing.assert_allclose(found.at_infinity, limit, atol=1e-6 * np.abs(exact).max())


@given(st.integers(0, 10_000))
@settings(max_examples=25)
def test_interpolants_are_real_functions_of_time_and_exact_at_the_support(seed):
    rng = np.random.default_rng(seed)
    omega = np.sort(rng.uniform(0.1, 12.0, 6))
    values = rng.normal(size=(6, 3)) + 1j * rng.normal(size=(6, 3))
    for found in interpolants(omega, values, np.ones(6)):
        np.testing.assert_allclose(found(found.support), found.values, rtol=1e-14)
        mirrored = found(-GRID)
        np.testing.assert_allclose(mirrored, found(GRID).conj(), rtol=1e-9, atol=1e-9 * np.abs(mirrored).max())
        assert np.abs(found(np.zeros(1)).imag).max() <= 1e-12 * np.abs(found(np.zeros(1))).max()


def test_convergence_is_root_exponential_at_a_branch_point():
    counts = np.array([8, 12, 16, 24])
    found = [selected(samples(n), slow(samples(n)), np.ones(n), GRID, ONE) for n in counts]
    errors = [float(np.abs(f.rational(GRID) - slow(GRID)).max()) for f in found]
    slopes = np.diff(np.log(errors)) / np.diff(np.sqrt(counts))
    assert errors[-1] < 1e-6
    assert np.all(slopes < -2.0), (errors, slopes)
    assert np.all(slopes > -20.0), (errors, slopes)


@pytest.mark.parametrize(("depth", "hidden"), [(1e-3, True), (1e-2, True), (0.2, False), (1.0, False)])
def test_pole_between_grid_and_axis_is_found(depth, hidden):
    omega = samples(6)
    poles, residues = np.array([2.015 - depth * 1j]), np.full((2, 1), 1e-3 + 0j)
    values = resonances(omega, poles, residues, np.array([1.0, 2.0]))
    found = interpolants(omega, values, np.ones(6))[1]
    assert found.spurious(GRID) is hidden
    assert not found.spurious(GRID[GRID > 3.0])  # beside the grid
    result = selected(omega, values, np.ones(6), GRID, ONE)
    assert not (np.isfinite(result.error) and result.rational.spurious(GRID))


def test_too_few_samples_are_refused():
    with pytest.raises(ConvergenceError, match=r"omega: received 3 samples, rational interpolation needs 4; solve"):
        selected(samples(3), slow(samples(3)), np.ones(3), GRID, ONE)
