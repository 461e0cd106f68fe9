import dataclasses
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.errors import ConfigError
from vsb.hydro.shapes import family as shapefamily
from vsb.hydro.shapes.family import COEFFICIENTS, ShapeFamily, extrapolated, misfit
from vsb.scenes.rest import reference_shell
from vsb.shell.deformed import DeformedShell, rigid_sphere
from vsb.study import study as config

HERE = Path(__file__).parents[2]
OMEGAS = (0.8, 1.6, 2.4, 3.2, 4.8, 6.4)
SCALING = {
    "added_mass": (3.0, 0.5),
    "radiation_damping": (2.5, 0.5),
    "excitation_force": (2.0, 0.5),
    "added_mass_inf": (3.0, 0.0),
}
"""a d/da of a geometry scaled by a, at fixed frequency: the powers of (value, omega d/d omega), from Froude's law."""


def family_of(shape, **options):
    return ShapeFamily(shape, OMEGAS, 1025.0, 9.81, **{"nodes": 32, **options})


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


@pytest.fixture(scope="module")
def strained():
    """The pressurised shell at rest, strained by 14 %, in five degrees of freedom."""
    study = varied(config.load(HERE.parent / "config" / "pressurised.yaml"), modes={"degree": 2})
    return reference_shell(study)


@pytest.fixture(scope="module")
def strained_family(strained):
    return family_of(strained.shape)


def by_frequency(family):
    """omega d/d omega of the coefficients, by differences of solutions at scaled frequencies."""
    levels = []
    for h in (0.02, 0.01, 0.005):
        plus, minus = (dataclasses.replace(family, omegas=tuple(w * (1 + s) for w in OMEGAS)).centre for s in (h, -h))
        levels.append((plus.assign_coords(omega=list(OMEGAS)) - minus.assign_coords(omega=list(OMEGAS))) / (2 * h))
    return extrapolated(levels)[0]


def scaled(family):
    """What a d/da of every coefficient is by Froude's law."""
    change = by_frequency(family)
    return {name: p * family.centre[name] + q * change[name] for name, (p, q) in SCALING.items()}


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


def test_the_breathing_mode_of_a_sphere_is_a_change_of_radius(reference):
    """The centre at the water's surface: no other length."""
    family = family_of(DeformedShell(reference.basis, 0.0))
    slope, expected = family.along(np.eye(len(family.labels))[1]).slope, scaled(family)
    for name in COEFFICIENTS:
        assert misfit(slope[name], expected[name] / 2.0) < 1e-7


def test_all_amplitudes_together_scale_the_shape(strained, strained_family):
    """Euler's identity: lengths of the shape times derivatives by them, heave and all modes of the strained shell."""
    lengths = strained.modal_amplitude.copy()
    lengths[0] += strained.shape.centre_height
    lengths[1] += strained.basis.shell.radius
    assert np.count_nonzero(np.abs(lengths) > 1e-3) == 5
    eta = xr.DataArray(lengths, dims="shape_dof", coords={"shape_dof": strained_family.labels})
    together, expected = (eta * strained_family.slopes).sum("shape_dof"), scaled(strained_family)
    for name in COEFFICIENTS:
        assert misfit(together[name], expected[name]) < 3e-7


@pytest.mark.parametrize("which", ["family", "strained_family"])
def test_haskinds_relation_holds_for_derivatives(which, request):
    family = request.getfixturevalue(which)
    x, dx = family.centre.excitation_force.values[:, 0], family.slopes.excitation_force.values[:, :, 0]
    expected = shapefamily.haskind_slope(np.array(OMEGAS), x, dx, 1025.0, 9.81)
    damping = family.slopes.radiation_damping.values
    assert np.abs(damping - expected).max() < 1e-6 * np.abs(damping).max()


def test_the_slope_of_a_rank_one_matrix():
    """haskind_slope against a difference of its integral."""
    rng = np.random.default_rng(3)
    x, dx = rng.standard_normal((2, 2, 3))
    omega, h = np.array([1.0, 2.0]), 1e-3

    def damping(x):
        return omega[:, None, None] ** 3 / (2 * 7.0 * 5.0**3) * x[:, :, None] * x[:, None, :]

    difference = (damping(x + h * dx) - damping(x - h * dx)) / (2 * h)
    got = shapefamily.haskind_slope(omega, x.astype(complex), dx.astype(complex), 7.0, 5.0)
    np.testing.assert_allclose(got, difference, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", ["added_mass", "radiation_damping", "added_mass_inf"])
@pytest.mark.parametrize("which", ["slopes", "curvatures"])
def test_derivatives_are_symmetric(name, which, strained_family):
    matrix = getattr(strained_family, which)[name]
    turned = matrix.rename(influenced_dof="radiating_dof", radiating_dof="influenced_dof")
    assert misfit(turned, matrix) < {"slopes": 1e-6, "curvatures": 2e-5}[which]


@pytest.mark.parametrize("label", ["Heave", "Membrane2"])
def test_the_error_estimate_bounds_the_error_and_is_small(label, family, reference):
    """Against more points and another step."""
    fine = family_of(reference.shape, nodes=56, step=0.008).along(np.eye(4)[family.labels.index(label)]).slope
    for name in COEFFICIENTS:
        estimate = float(family.slope_errors[name].sel(shape_dof=label))
        assert misfit(family.slopes[name].sel(shape_dof=label), fine[name]) < estimate + 1e-9
        assert 0 < estimate < 1e-6


def test_the_estimate_sees_a_step_too_large():
    family = family_of(DeformedShell(rigid_sphere(2.0, 0.3).basis, 0.3), nodes=24, step=0.2)
    assert float(family.slope_errors.to_array().max()) > 1e-5


@pytest.fixture(scope="module")
def errors(family):
    """Errors in random directions, at sizes from 0.2 m on, each half of the one before."""
    return [family.interpolation_error(0.2 / 2**i, samples=4) for i in range(5)]


@pytest.mark.parametrize("name", COEFFICIENTS)
@pytest.mark.parametrize("order", [1, 2])
def test_expansions_have_their_order(order, name, errors):
    """Mixed terms included: without them the second order would be wrong by the square of the size."""
    found = np.array([float(e[name].sel(order=order)) for e in errors])
    orders = np.log2(found[:-1] / found[1:])
    assert np.all(np.abs(orders - order - 1) < 0.3), orders
    assert abs(orders[-1] - order - 1) < 0.05, orders


def test_mixed_derivatives_are_differences_of_slopes(family, reference):
    """d/d eta_3 of the slope by heave, taken on shapes deformed by a mode."""
    h, unit, levels = 0.02, np.eye(4), []
    for step in (h, h / 2):
        plus, minus = (family.about(sign * step * unit[3]).along(unit[0]).slope for sign in (1, -1))
        levels.append((plus - minus) / (2 * step))
    expected, mixed = extrapolated(levels)[0], family.curvatures.sel(shape_dof="Heave", other_shape_dof="Membrane2")
    for name in COEFFICIENTS:
        assert misfit(mixed[name], expected[name]) < 1e-5
        assert np.abs(mixed[name]).max() > 1e-3 * np.abs(family.centre[name]).max()
        np.testing.assert_array_equal(
            mixed[name], family.curvatures[name].sel(shape_dof="Membrane2", other_shape_dof="Heave")
        )


def test_families_about_other_shapes_are_one(family):
    """Solved about a shape deformed by modes, or reached from the sphere: the same."""
    there, on = np.array([0.05, 0.02, 0.0, -0.08]), np.array([0.01, 0.0, 0.03, 0.02])
    about = family.about(there)
    xr.testing.assert_allclose(about.centre, family.at(there), rtol=0, atol=0)
    direct = family.at(there + on)
    for name in COEFFICIENTS:
        assert misfit(about.at(on)[name], direct[name]) < 1e-14


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda f: f.at(np.zeros(3)), r"modal_amplitude: received shape \(3,\); needs \(4,\)"),
        (lambda f: f.at(np.array([3.0, 0, 0, 0])), "reference_shape: received a shape"),
        (lambda f: f.expansion(np.zeros(4), 3), "order: received 3; needs 1 or 2"),
        (lambda f: f.interpolation_error(0.0), "amplitude: received 0 m"),
        (lambda f: f.interpolation_error(float("nan")), "amplitude: received nan m"),
    ],
)
def test_what_cannot_be_is_refused(call, match, family):
    with pytest.raises(ConfigError, match=match):
        call(family)
