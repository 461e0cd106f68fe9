"""Errors of coefficients from what a database says of itself."""

import numpy as np

from vsb.motion.coefficient_errors import (
    _SAFETY,
    haskind_misfits,
)
from vsb.waves.dispersion import group_velocity, wavenumber

OMEGA = np.linspace(0.5, 2.0, 10)
WATER = (np.inf, 1025.0, 9.81)


def one_channel(rng):
    """Damping and excitation that agree by Haskind's relation."""
    k, speed = (np.array([of(w, np.inf, 9.81) for w in OMEGA]) for of in (wavenumber, group_velocity))
    force = rng.normal(size=(len(OMEGA), 2)) * np.exp(1j * OMEGA)[:, None]
    damping = (k / (4 * 1025.0 * 9.81 * speed))[:, None, None] * np.real(force[:, :, None] * force[:, None].conj())
    return damping, force


def test_coefficients_satisfying_haskind_have_no_misfit():
    damping, force = one_channel(np.random.default_rng(1))
    for misfit in haskind_misfits(OMEGA, damping, damping, force, *WATER):
        assert np.abs(misfit).max() < 1e-12 * max(np.abs(force).max(), np.abs(damping).max())


def test_excitation_error_is_found():
    damping, force = one_channel(np.random.default_rng(2))
    off = force * np.array([1.01, 1.0])
    _, _, misfit = haskind_misfits(OMEGA, damping, damping, off, *WATER)
    np.testing.assert_allclose(misfit[:, 0], _SAFETY * 0.01 * np.abs(force[:, 0]), rtol=1e-9)
    assert np.abs(misfit[:, 1]).max() < 1e-9 * np.abs(force).max()


def test_second_channel_is_an_error_of_damping_and_added_mass():
    """Damping reduced by 0.1 b off the diagonal is 0.1 b from rank one; added mass by as much over frequency."""
    damping, force = one_channel(np.random.default_rng(3))
    wrong = damping * np.array([[1.0, 0.9], [0.9, 1.0]])
    mass, of_damping, _ = haskind_misfits(OMEGA, wrong, damping, force, *WATER)
    expected = _SAFETY * 0.1 * np.abs(damping[:, 0, 1])
    np.testing.assert_allclose(mass[:, 0, 1], expected / OMEGA, rtol=1e-9)
    np.testing.assert_allclose(of_damping[:, 0, 1], expected, rtol=1e-9)


def test_misfit_is_an_envelope_over_neighbouring_frequencies():
    """An error that passes through zero makes no coefficient exact."""
    omega = np.linspace(0.5, 2.0, 97)
    k, speed = (np.array([of(w, np.inf, 9.81) for w in omega]) for of in (wavenumber, group_velocity))
    force = np.full((97, 1), 100.0 + 0j)
    damping = (k / (4 * 1025.0 * 9.81 * speed))[:, None, None] * np.abs(force)[:, :, None] ** 2
    wave = np.sin(np.linspace(0, 6 * np.pi, 97))[:, None]
    _, _, misfit = haskind_misfits(omega, damping, damping, force * (1 + 1e-3 * wave), *WATER)
    assert misfit.min() > 0.5 * _SAFETY * 0.1 * np.abs(wave[5:12]).max() / 2
