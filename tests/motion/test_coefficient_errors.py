"""Errors of coefficients from what a database says of itself."""

import numpy as np
import pytest
from motion.test_bodies import database, moored  # noqa: F401

from vsb.hydro.coefficients import Coefficients
from vsb.hydro.database import Check, as_json
from vsb.motion.coefficient_errors import (
    _SAFETY,
    INTERPOLATION,
    OF_OTHERS,
    RESOLUTION,
    coefficient_errors,
    haskind_misfits,
    relative_error,
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


def test_coefficients_that_agree_by_haskind_have_no_misfit():
    damping, force = one_channel(np.random.default_rng(1))
    for misfit in haskind_misfits(OMEGA, damping, damping, force, *WATER):
        assert np.abs(misfit).max() < 1e-12 * max(np.abs(force).max(), np.abs(damping).max())


def test_excitation_off_by_a_hundredth_is_told_as_such():
    """Of that entry alone, and safely so."""
    damping, force = one_channel(np.random.default_rng(2))
    off = force * np.array([1.01, 1.0])
    _, _, misfit = haskind_misfits(OMEGA, damping, damping, off, *WATER)
    np.testing.assert_allclose(misfit[:, 0], _SAFETY * 0.01 * np.abs(force[:, 0]), rtol=1e-9)
    assert np.abs(misfit[:, 1]).max() < 1e-9 * np.abs(force).max()


def test_damping_of_two_channels_is_an_error_of_added_mass_too():
    """B = b with 0.1 b taken off beside the diagonal is off from rank one by 0.1 b; A by as much over frequency."""
    damping, force = one_channel(np.random.default_rng(3))
    wrong = damping * np.array([[1.0, 0.9], [0.9, 1.0]])
    mass, of_damping, _ = haskind_misfits(OMEGA, wrong, damping, force, *WATER)
    expected = _SAFETY * 0.1 * np.abs(damping[:, 0, 1])
    np.testing.assert_allclose(mass[:, 0, 1], expected / OMEGA, rtol=1e-9)
    np.testing.assert_allclose(of_damping[:, 0, 1], expected, rtol=1e-9)


def test_a_misfit_that_changes_sign_is_as_large_as_nearby():
    """Between two frequencies solved an error passes through zero, which makes no number exact."""
    omega = np.linspace(0.5, 2.0, 97)
    k, speed = (np.array([of(w, np.inf, 9.81) for w in omega]) for of in (wavenumber, group_velocity))
    force = np.full((97, 1), 100.0 + 0j)
    damping = (k / (4 * 1025.0 * 9.81 * speed))[:, None, None] * np.abs(force)[:, :, None] ** 2
    wave = np.sin(np.linspace(0, 6 * np.pi, 97))[:, None]
    _, _, misfit = haskind_misfits(omega, damping, damping, force * (1 + 1e-3 * wave), *WATER)
    assert misfit.min() > 0.5 * _SAFETY * 0.1 * np.abs(wave[5:12]).max() / 2


def test_relative_errors_are_a_part_of_every_entry():
    found = Coefficients(np.array([[[2.0]]]), np.array([[[-3.0]]]), np.array([[3.0 + 4.0j]]))
    name, error, signed, stiffness = relative_error("x", found, 0.1)
    assert (name, signed, stiffness) == ("x", False, None)
    assert [values.item() for values in error] == pytest.approx([0.2, 0.3, 0.5])


def test_a_body_s_errors_are_those_of_its_panels_and_of_its_waves(database):  # noqa: F811
    """On straight lines between the frequencies solved; of stiffness fewer panels alone say something."""
    body, at = moored(database), database.omega.values[2:4]
    checks = as_json([Check("error_estimate", 0.2, 0.05, "-", "doubt", "")])
    stated = body.database.assign_attrs(quality=checks)
    panels, waves = coefficient_errors(type(body)(stated, body.structural_damping, body.pto), np.array([at.mean()]))
    assert (panels.name, waves.name) == (f"{RESOLUTION} (fewer panels)", f"{RESOLUTION} (waves radiated)")
    assert panels.signed
    both = database.added_mass_error.sel(omega=at).values
    np.testing.assert_allclose(panels.error.added_mass[0], both[0].mean(axis=0), atol=1e-9 * np.abs(both).max())
    assert not waves.error.added_mass.any()
    assert np.abs(waves.error.damping).max() > 0
    assert np.abs(panels.stiffness).max() > 0
    assert not waves.stiffness.any()


def test_a_file_that_states_no_error_is_taken_to_a_hundredth_and_says_so(database):  # noqa: F811
    body = moored(database)
    bare = body.database.drop_vars([name for name in body.database if str(name).endswith("_error")])
    stated = Check("interpolation_error", 0.02, 0.05, "-", "ok", "")
    for checks, names in (([], [OF_OTHERS]), ([stated], [OF_OTHERS, INTERPOLATION])):
        read = type(body)(bare.assign_attrs(quality=as_json(checks)), body.structural_damping, body.pto)
        errors = coefficient_errors(read, np.array([1.0]))
        assert [error.name for error in errors] == names
        known = read.coefficients(np.array([1.0])).added_mass
        np.testing.assert_allclose(errors[0].error.added_mass, 0.01 * np.abs(known))
