"""Coefficients on shapes around a reference shape: derivatives, expansions, the shape database and its error."""

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.engine.hydro.dofs import displacements
from vsb.engine.hydro.shape_dependence import (
    COEFFICIENTS,
    ShapeFamily,
    extrapolated,
    haskind_damping,
    haskind_slope,
    measured_errors,
    misfit,
    shape_database,
    shape_derivative,
    tried_shapes,
)
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.shell.deformed import DeformedShell, rigid_sphere
from vsb.engine.shell.loaded import complete_basis
from vsb.engine.shell.shell import Curve, Shell
from vsb.errors import ConfigError, DatabaseError
from vsb.models.rest import reference_shell

OMEGAS = (0.8, 1.6, 3.2, 6.4)


def family_of(shape, **options):
    return ShapeFamily(shape, OMEGAS, 1025.0, 9.81, **{"nodes": 24, **options})


@pytest.fixture(scope="module")
def small(seed):
    """The seed with four degrees of freedom."""
    return varied(seed, modes={"degree": 2})


@pytest.fixture(scope="module")
def reference(small):
    return reference_shell(small)


@pytest.fixture(scope="module")
def family(reference):
    return family_of(reference.shape)


def test_extrapolation_is_exact_for_errors_of_second_and_fourth_power():
    levels = [xr.Dataset({"a": 3.0 + 2.0 * h**2 - 5.0 * h**4}) for h in (0.4, 0.2, 0.1)]
    value, correction = extrapolated(levels)
    assert float(value.a) == pytest.approx(3.0, abs=1e-14)
    assert float(correction.a) == pytest.approx(-5.0 * 0.2**4 / 4, rel=1e-9)


def test_heave_is_a_change_of_draft():
    height, levels = 0.32, []
    for h in (0.06, 0.03, 0.015):
        plus, minus = (family_of(rigid_sphere(2.0, height + s)).centre for s in (h, -h))
        levels.append((plus - minus) / (2 * h))
    family = family_of(rigid_sphere(2.0, height))
    slope, by_height = family.slopes.sel(shape_dof="Heave"), extrapolated(levels)[0]
    for name in COEFFICIENTS:
        assert misfit(slope[name], by_height[name]) < 1e-7
        assert np.abs(slope[name]).max() > 0.05 * np.abs(family.centre[name]).max()


@pytest.mark.parametrize("which", ["family"])
def test_haskinds_relation_holds_for_derivatives(which, request):
    family = request.getfixturevalue(which)
    x, dx = family.centre.excitation_force.values[:, 0], family.slopes.excitation_force.values[:, :, 0]
    expected = haskind_slope(np.array(OMEGAS), x, dx, 1025.0, 9.81)
    damping = family.slopes.radiation_damping.values
    assert np.abs(damping - expected).max() < 1e-6 * np.abs(damping).max()


@pytest.mark.parametrize("label", ["Membrane2"])
def test_the_error_estimate_bounds_the_error_and_is_small(label, family, reference):
    """Against more points and another step."""
    fine = family_of(reference.shape, nodes=56, step=0.008).along(np.eye(4)[family.labels.index(label)]).slope
    for name in COEFFICIENTS:
        estimate = float(family.slope_errors[name].sel(shape_dof=label))
        assert misfit(family.slopes[name].sel(shape_dof=label), fine[name]) < estimate + 1e-9
        assert 0 < estimate < 1e-6


@pytest.fixture(scope="module")
def errors(family):
    """Errors in random directions, at sizes from 0.2 m on, each half of the one before."""
    return [family.interpolation_error(0.2 / 2**i, samples=2) for i in range(5)]


@pytest.mark.parametrize("name", COEFFICIENTS)
@pytest.mark.parametrize("order", [1, 2])
def test_expansions_have_their_order(order, name, errors):
    """Mixed terms included: without them the second order would be wrong by the square of the size."""
    found = np.array([float(e[name].sel(order=order)) for e in errors])
    orders = np.log2(found[:-1] / found[1:])
    assert np.all(np.abs(orders - order - 1) < 0.3), orders
    assert abs(orders[-1] - order - 1) < 0.05, orders


GRID = np.array(OMEGAS)
REACH = np.array([0.25, 0.1, 0.1, 0.15])


@pytest.fixture(scope="module")
def database(family):
    return shape_database(family, REACH, samples=12)


def values(database, eta):
    """What the database holds of `COEFFICIENTS` at its own frequencies."""
    c = database.at(GRID, eta)
    return dict(zip(COEFFICIENTS, (c.added_mass, c.damping, c.excitation, database.added_mass_inf(eta)), strict=True))


def test_database_reproduces_the_reference_shape(database, family):
    """But for damping's from excitation, and asymmetry: errors of the solver."""
    for name, value in values(database, np.zeros(4)).items():
        exact = family.centre[name]
        assert misfit(exact.copy(data=value.reshape(exact.shape)), exact) < 1e-8


@pytest.mark.parametrize("scale", [1.0, 0.3, 0.05, 0.002])
def test_the_true_error_is_within_the_estimate(scale, database, family):
    """On new random shapes, and not by miles: within two orders of magnitude, if the error is not round-off."""
    shapes = scale * REACH * np.random.default_rng(2024).uniform(-1, 1, (6, 4))
    measured = measured_errors(database, family, shapes)
    estimated = np.array([list(database.error(eta).values()) for eta in shapes])
    assert np.all(measured <= estimated), measured / estimated
    assert np.all(measured[estimated > 1e-9] > 0.01 * estimated[estimated > 1e-9])


def test_the_estimate_is_of_third_order(database):
    eta = REACH * np.array([0.5, -0.7, 0.6, 0.8])
    large, small = database.error(eta), database.error(eta / 2)
    for name in COEFFICIENTS:
        assert large[name] / small[name] == pytest.approx(8.0, rel=1e-3)
    assert all(0 < error < 1e-8 for error in database.error(np.zeros(4)).values())


def test_damping_is_positive_on_every_shape(database):
    """At the end of the reach too, where an expansion of damping itself would not."""
    expanded = []
    for eta in tried_shapes(REACH, 30, seed=5):
        c, ds = database.at(GRID, eta), database.dataset
        size = np.abs(c.damping).max()
        assert np.linalg.eigvalsh(c.damping).min() > -1e-13 * size
        np.testing.assert_array_equal(c.damping, haskind_damping(GRID, c.excitation, 1025.0, 9.81))
        np.testing.assert_array_equal(c.added_mass, c.added_mass.swapaxes(1, 2))
        slope, curvature = ds.radiation_damping_slope.values, ds.radiation_damping_curvature.values
        taylor = ds.radiation_damping.values + np.tensordot(eta, slope + np.tensordot(eta, curvature, 1) / 2, 1)
        expanded.append(np.linalg.eigvalsh((taylor + taylor.swapaxes(1, 2)) / 2).min() / size)
    assert min(expanded) < -1e-5


@pytest.mark.parametrize(
    ("call", "error", "match"),
    [
        (lambda d: d.at(GRID, np.zeros(3)), ConfigError, r"modal_amplitude: received shape \(3,\); needs \(4,\)"),
        (lambda d: d.at(GRID, 1.01 * REACH), ConfigError, "received Heave = 0.2525 m; the shape database holds 0.25 m"),
        (lambda d: d.error(np.array([0, np.nan, 0, 0])), ConfigError, "received Membrane0 = nan m"),
        (lambda d: d.added_mass_inf(np.array([0, 0, 0, -0.2])), ConfigError, "received Membrane2 = -0.2 m"),
        (lambda d: d.at(np.array([0.7]), np.zeros(4)), DatabaseError, "0.7 to 0.7 rad/s are asked for, the shape"),
        (lambda d: d.at(np.array([2.0, 99.0]), np.zeros(4)), DatabaseError, "2 to 99 rad/s are asked for, the shape"),
        (lambda d: d.at(np.array([2.0, np.nan]), np.zeros(4)), DatabaseError, "are asked for, the shape database"),
        (lambda d: d.at(np.array([2.0, 0.7, 3.0]), np.zeros(4)), DatabaseError, "0.7 to 3 rad/s are asked for, the s"),
        (lambda d: d.at(np.array([2.0, 99.0, 3.0]), np.zeros(4)), DatabaseError, "2 to 99 rad/s are asked for, the s"),
    ],
)
def test_amplitudes_and_frequencies_out_of_reach_are_refused(call, error, match, database):
    with pytest.raises(error, match=match):
        call(database)


BASIS = complete_basis(Shell(2.0, 0.01, 1e7, 0.3, 2700.0), 3, 17170.0)
MOVED = displacements(["Radial0", "Radial1", "Meridional1", "Radial3", "Meridional3"])
TWO = [0.5, 2.0]


def problem(amplitude, depth, nodes=32):
    """A deformed shell, floating deeper than half."""
    rest = np.array([0.0, 0.1, 0.05, -0.1, 0.05, 0.04, 0.1])
    return SpectralProblem(DeformedShell(BASIS, -0.3, rest + amplitude), MOVED, 1025.0, 9.81, nodes, depth)


@pytest.mark.parametrize("depth", [np.inf, 4.0])
def test_derivatives_are_those_of_differences(depth):
    ways = np.vstack([np.eye(7)[:2], np.random.default_rng(3).normal(size=(2, 7)) / 4])

    def directions(colatitude):
        shapes = DeformedShell(BASIS, 0.0).meridian(colatitude)
        return Curve(*(ways @ part for part in shapes[4:]))

    def solved(amplitude):
        one = problem(amplitude, depth)
        forces = one.onto @ one.potentials(TWO)
        return forces[..., :-1], one.gravity * forces[..., -1]

    found = shape_derivative(problem(np.zeros(7), depth), TWO, directions)
    at_rest = solved(np.zeros(7))
    for values, expected in zip((found.radiation, found.excitation), at_rest, strict=True):
        np.testing.assert_allclose(values, expected, rtol=1e-12)
    for k, way in enumerate(ways):
        steps = {
            h: [np.subtract(*each) / (2 * h) for each in zip(solved(h * way), solved(-h * way), strict=True)]
            for h in (2e-3, 4e-3)
        }
        for change, fine, coarse in zip(
            (found.radiation_change, found.excitation_change), *steps.values(), strict=True
        ):
            expected = (4 * fine - coarse) / 3
            for part in (np.real, np.imag):
                off = np.abs(part(change[:, k] - expected)).max()
                assert off < 1e-8 * np.abs(part(expected)).max()


def test_only_axisymmetric_motion_has_derivatives():
    surge = SpectralProblem(DeformedShell(BASIS, 0.0), displacements(["Surge"], 1), 1025.0, 9.81, 16)
    with pytest.raises(ConfigError, match="azimuthal order 1"):
        shape_derivative(surge, [1.0], lambda phi: Curve(*np.zeros((4, 0, len(phi)))))
