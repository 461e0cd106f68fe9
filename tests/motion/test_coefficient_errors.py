"""Errors of coefficients: derivatives of power against differences, errors a database states about itself."""

import numpy as np
import pytest

from vsb.engine.hydro.database import Coefficients
from vsb.engine.motion.coefficient_errors import (
    _SAFETY,
    CoefficientError,
    Sensitivity,
    haskind_misfits,
    relative_error,
    sensitivity,
    sensitivity_of_forces,
)
from vsb.engine.motion.frequency import LinearEquation
from vsb.engine.waves.water import group_velocity, wavenumber

OMEGA = np.array([0.7, 1.1, 1.9])
SQUARES = np.array([0.3, 1.0, 0.2])
MASS = np.diag([3.0, 1.0, 0.5])
STIFFNESS = np.array([[9.0, 1.0, 0.5], [1.0, 4.0, 0.2], [0.5, 0.2, 6.0]])
DAMPING = 0.02 * STIFFNESS
B = np.array([1.0, 0.0, 0.3])
FREE = {"rigid": np.eye(3)[:, :1], "flexible": np.eye(3)}


def symmetric(rng, scale=1.0):
    a = rng.normal(size=(len(OMEGA), 3, 3))
    return scale * (a + a.transpose(0, 2, 1))


def water(rng):
    root = rng.normal(size=(len(OMEGA), 3, 2))
    force = rng.normal(size=(len(OMEGA), 3)) + 1j * rng.normal(size=(len(OMEGA), 3))
    return Coefficients(np.eye(3) + symmetric(rng, 0.05), 0.3 * root @ root.transpose(0, 2, 1), force)


def at_work(c, motions, load, stiffness=STIFFNESS):
    """Motions, port and power of a design under a take-off."""
    equation = LinearEquation(OMEGA, c, MASS, DAMPING, stiffness)
    moved, port = equation.free_motion(motions, B), equation.port(motions, B)
    impedance = np.conj(port.impedance) if load is None else port.load(*load)
    power = np.sum(0.5 * SQUARES * impedance.real * np.abs(port.velocity_under(impedance)) ** 2)
    return moved, port, impedance, power


def by_name(slopes):
    """Derivatives by coefficients, entry by entry."""
    real, imaginary = (left @ right.swapaxes(1, 2) for left, right in slopes._factors(slice(None)))
    w = slopes.omega[:, None, None]
    by_matrices = {"added_mass": -(w**2) * real, "damping": w * imaginary, "stiffness": real}
    return {**by_matrices, "excitation": slopes.excitation}


def best(c, motions, load, stiffness=STIFFNESS):
    """Power under a take-off, the best force of all if none is given."""
    return at_work(c, motions, load, stiffness)[3]


@pytest.mark.parametrize("load", [(2.0, 0.0), (2.0, 1.5), None])
@pytest.mark.parametrize("design", FREE)
def test_sensitivities_match_differences_of_the_power(load, design):
    """By central differences; the matched force follows the coefficients, to first order without effect."""
    rng = np.random.default_rng(3)
    c, changed, of_stiffness = water(rng), (symmetric(rng), symmetric(rng), water(rng).excitation), symmetric(rng)[0]
    moved, port, impedance, power = at_work(c, FREE[design], load)
    slopes = by_name(sensitivity(moved, port, impedance, SQUARES))
    size = 1e-5
    for name, change in (*zip(Coefficients._fields, changed, strict=True), ("stiffness", of_stiffness)):
        ends = []
        for sign in (1, -1):
            if name == "stiffness":
                ends.append(best(c, FREE[design], load, STIFFNESS + sign * size * change))
            else:
                ends.append(best(c._replace(**{name: getattr(c, name) + sign * size * change}), FREE[design], load))
        expected = (ends[0] - ends[1]) / (2 * size) / power
        assert np.sum(slopes[name] * change).real == pytest.approx(expected, rel=1e-6, abs=1e-9), name


def test_sensitivities_of_a_damper_matrix_match_differences_of_the_power():
    """At two ports, by central differences."""
    rng, directions = np.random.default_rng(5), np.stack([B, [0.0, 1.0, -0.4]], axis=-1)
    matrix = np.array([[2.0, 0.5], [0.5, 1.0]])
    c, changed, of_stiffness = water(rng), (symmetric(rng), symmetric(rng), water(rng).excitation), symmetric(rng)[0]

    def power(found, stiffness=STIFFNESS):
        equation = LinearEquation(OMEGA, found, MASS, DAMPING, stiffness)
        return SQUARES @ equation.ports(np.eye(3), directions).power(matrix)

    equation = LinearEquation(OMEGA, c, MASS, DAMPING, STIFFNESS)
    ports = equation.ports(np.eye(3), directions)
    slopes = by_name(sensitivity(equation.free_motion(np.eye(3), directions), ports, matrix, SQUARES))
    size = 1e-5
    ends = [power(c, STIFFNESS + sign * size * of_stiffness) for sign in (1, -1)]
    expected = (ends[0] - ends[1]) / (2 * size) / power(c)
    assert np.sum(slopes["stiffness"] * of_stiffness) == pytest.approx(expected, rel=1e-6)
    for name, change in zip(Coefficients._fields, changed, strict=True):
        ends = [power(c._replace(**{name: getattr(c, name) + sign * size * change})) for sign in (1, -1)]
        expected = (ends[0] - ends[1]) / (2 * size) / power(c)
        assert np.sum(slopes[name] * change).real == pytest.approx(expected, rel=1e-6), name


def test_unsigned_errors_combine_in_the_worst_way():
    rng = np.random.default_rng(5)
    vectors = [water(rng).excitation for _ in range(5)]
    slopes = Sensitivity(OMEGA, vectors[0], ((vectors[1], vectors[2]), (vectors[3], vectors[4])))
    by = by_name(slopes)
    sizes = Coefficients(np.abs(symmetric(rng)), np.abs(symmetric(rng)), np.abs(water(rng).excitation))
    worst = CoefficientError("worst", sizes, signed=False)
    for _ in range(20):
        signs = [np.sign(rng.normal(size=size.shape)) for size in sizes]
        one = CoefficientError("one", Coefficients(*(s * v for s, v in zip(signs, sizes, strict=True))), signed=True)
        assert slopes.to(one) <= slopes.to(worst)
    aligned = CoefficientError(
        "aligned",
        Coefficients(
            np.sign(by["added_mass"]) * sizes.added_mass,
            np.sign(by["damping"]) * sizes.damping,
            np.exp(-1j * np.angle(slopes.excitation)) * sizes.excitation,
        ),
        signed=True,
    )
    assert slopes.to(aligned) == pytest.approx(slopes.to(worst), rel=1e-12)


def test_coupling_has_the_larger_relative_error_of_its_two_motions():
    found, size = water(np.random.default_rng(7)), np.array([0.1, 0.01, 0.0])
    mass, damping, force = relative_error("resolution", found, size).error
    of_pair = np.array([[0.1, 0.1, 0.1], [0.1, 0.01, 0.01], [0.1, 0.01, 0.0]])
    np.testing.assert_allclose(mass, of_pair * np.abs(found.added_mass), rtol=1e-15)
    np.testing.assert_allclose(damping, of_pair * np.abs(found.damping), rtol=1e-15)
    np.testing.assert_allclose(force, size * np.abs(found.excitation), rtol=1e-15)


@pytest.mark.parametrize("design", FREE)
def test_of_the_best_force_of_all_both_derivatives_agree(design):
    """Told by its impedance or as it is, in two seas of the same energy and other phases."""
    moved, port, impedance, power = at_work(water(np.random.default_rng(5)), FREE[design], None)
    waves = np.sqrt(SQUARES) * np.exp(1j * np.array([[0.3, 1.0, 2.0], [-1.0, 0.4, 0.0]]))
    forces = waves * impedance * port.velocity_under(impedance)
    found = sensitivity_of_forces(OMEGA, moved, waves, forces, power, np.array([0.75, 0.25]))
    expected = by_name(sensitivity(moved, port, impedance, SQUARES))
    for name, one in by_name(found).items():
        assert one == pytest.approx(expected[name], rel=1e-10, abs=1e-14), name


STATED = np.linspace(0.5, 2.0, 10)
WATER = (np.inf, 1025.0, 9.81)


def one_channel(rng):
    """Damping and excitation that agree by Haskind's relation."""
    k, speed = (np.array([of(w, np.inf, 9.81) for w in STATED]) for of in (wavenumber, group_velocity))
    force = rng.normal(size=(len(STATED), 2)) * np.exp(1j * STATED)[:, None]
    damping = (k / (4 * 1025.0 * 9.81 * speed))[:, None, None] * np.real(force[:, :, None] * force[:, None].conj())
    return damping, force


def test_coefficients_satisfying_haskind_have_no_misfit():
    damping, force = one_channel(np.random.default_rng(1))
    for misfit in haskind_misfits(STATED, damping, damping, force, *WATER):
        assert np.abs(misfit).max() < 1e-12 * max(np.abs(force).max(), np.abs(damping).max())


def test_excitation_error_is_found():
    damping, force = one_channel(np.random.default_rng(2))
    off = force * np.array([1.01, 1.0])
    _, _, misfit = haskind_misfits(STATED, damping, damping, off, *WATER)
    np.testing.assert_allclose(misfit[:, 0], _SAFETY * 0.01 * np.abs(force[:, 0]), rtol=1e-9)
    assert np.abs(misfit[:, 1]).max() < 1e-9 * np.abs(force).max()


def test_second_channel_is_an_error_of_damping_and_added_mass():
    """Damping reduced by 0.1 b off the diagonal is 0.1 b from rank one; added mass by as much over frequency."""
    damping, force = one_channel(np.random.default_rng(3))
    wrong = damping * np.array([[1.0, 0.9], [0.9, 1.0]])
    mass, of_damping, _ = haskind_misfits(STATED, wrong, damping, force, *WATER)
    expected = _SAFETY * 0.1 * np.abs(damping[:, 0, 1])
    np.testing.assert_allclose(mass[:, 0, 1], expected / STATED, rtol=1e-9)
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
