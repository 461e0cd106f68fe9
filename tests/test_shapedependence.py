import dataclasses
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb import config, shapedependence, units
from vsb.database import with_structure
from vsb.errors import ConfigError
from vsb.modes import design_motions
from vsb.pto import LinearPto
from vsb.reference import reference_shell
from vsb.response import LinearBuoy
from vsb.shapedependence import COEFFICIENTS, ShapeFamily, extrapolated, misfit
from vsb.surface import DeformedShell, rigid_sphere

HERE = Path(__file__).parent
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
def oblate():
    """The pressurised shell at rest, strained by 14 %, in seven degrees of freedom."""
    return reference_shell(varied(config.load(HERE.parent / "config" / "pressurised.yaml"), modes={"degree": 3}))


@pytest.fixture(scope="module")
def oblate_family(oblate):
    return family_of(oblate.shape)


@pytest.fixture(scope="module")
def dataset(small, family):
    return shapedependence.shape_dataset(small, family, samples=2)


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
    slope, expected = family._along(1)[0], scaled(family)
    for name in COEFFICIENTS:
        assert misfit(slope[name], expected[name] / 2.0) < 1e-7


def test_all_amplitudes_together_scale_the_shape(oblate, oblate_family):
    """Euler's identity: lengths of the shape times derivatives by them, heave and all modes of the strained shell."""
    lengths = oblate.amplitudes.copy()
    lengths[0] += oblate.shape.centre_height
    lengths[1] += oblate.basis.shell.radius
    assert np.count_nonzero(np.abs(lengths) > 1e-3) == 7
    eta = xr.DataArray(lengths, dims="shape_dof", coords={"shape_dof": oblate_family.labels})
    together, expected = (eta * oblate_family.slopes).sum("shape_dof"), scaled(oblate_family)
    for name in COEFFICIENTS:
        assert misfit(together[name], expected[name]) < 3e-7


@pytest.mark.parametrize("which", ["family", "oblate_family"])
def test_haskinds_relation_holds_for_derivatives(which, request):
    family = request.getfixturevalue(which)
    x, dx = family.centre.excitation_force.values[:, 0], family.slopes.excitation_force.values[:, :, 0]
    expected = shapedependence.haskind_slope(np.array(OMEGAS), x, dx, 1025.0, 9.81)
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
    got = shapedependence.haskind_slope(omega, x.astype(complex), dx.astype(complex), 7.0, 5.0)
    np.testing.assert_allclose(got, difference, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", ["added_mass", "radiation_damping", "added_mass_inf"])
@pytest.mark.parametrize("which", ["slopes", "curvatures"])
def test_derivatives_are_symmetric(name, which, oblate_family):
    matrix = getattr(oblate_family, which)[name]
    turned = matrix.rename(influenced_dof="radiating_dof", radiating_dof="influenced_dof")
    assert misfit(turned, matrix) < {"slopes": 1e-6, "curvatures": 2e-5}[which]


@pytest.mark.parametrize("label", ["Heave", "Membrane2"])
def test_the_error_estimate_bounds_the_error_and_is_small(label, family, reference):
    """Against more points and another step."""
    fine = family_of(reference.shape, nodes=56, step=0.008)._along(family.labels.index(label))[0]
    for name in COEFFICIENTS:
        estimate = float(family.slope_errors[name].sel(shape_dof=label))
        assert misfit(family.slopes[name].sel(shape_dof=label), fine[name]) < estimate + 1e-9
        assert 0 < estimate < 1e-6


def test_the_estimate_sees_a_step_too_large():
    family = family_of(DeformedShell(rigid_sphere(2.0, 0.3).basis, 0.3), nodes=24, step=0.2)
    assert float(family.slope_errors.to_array().max()) > 1e-5


@pytest.fixture(scope="module")
def errors(family):
    """Errors at sizes from 0.2 m on, each half of the one before: whether one mode at a time -> list of datasets."""
    return {s: [family.interpolation_error(0.2 / 2**i, single=s, samples=4) for i in range(5)] for s in (False, True)}


@pytest.mark.parametrize("name", COEFFICIENTS)
@pytest.mark.parametrize(("order", "single", "power"), [(1, False, 2), (1, True, 2), (2, True, 3)])
def test_expansions_have_their_order(order, single, power, name, errors):
    found = np.array([float(e[name].sel(order=order)) for e in errors[single]])
    orders = np.log2(found[:-1] / found[1:])
    assert np.all(np.abs(orders - power) < 0.3), orders
    assert abs(orders[-1] - power) < 0.08, orders


def test_without_mixed_terms_the_second_order_is_second_in_random_directions(errors):
    found = [float(e.added_mass.sel(order=2)) for e in errors[False]]
    assert np.log2(found[3] / found[4]) == pytest.approx(2.0, abs=0.2)


def test_the_power_slope_is_that_of_the_response_on_deformed_shapes(small, reference, family):
    def power(eta, design):
        ds = with_structure(family.at(eta), reference)
        buoy = LinearBuoy(ds, reference.basis.damping, LinearPto(small.pto.damping))
        omega = np.array(OMEGAS)
        return buoy.absorbed_power(omega, buoy.rao(omega, design_motions(small, reference.basis, design)))

    changes = shapedependence.power_changes(small, reference, family)
    direction, h = np.array([0.6, 0.3, -0.5, 0.4]), 4e-3
    for design in ("FSB", "VSWEC"):
        d = [(power(s * h * direction, design) - power(-s * h * direction, design)) / (2 * s * h) for s in (1, 2)]
        got = direction @ changes.power_slope.sel(design=design).values
        np.testing.assert_allclose(got, (4 * d[0] - d[1]) / 3, rtol=1e-5, atol=1e-5 * np.abs(got).max())
        np.testing.assert_allclose(changes.absorbed_power.sel(design=design), power(0 * direction, design), rtol=1e-12)


def test_the_swing_is_the_largest_change_over_a_cycle(small, reference, family):
    changes = shapedependence.power_changes(small, reference, family)
    buoy = LinearBuoy(with_structure(family.centre, reference), reference.basis.damping, LinearPto(small.pto.damping))
    q = buoy.rao(np.array(OMEGAS), design_motions(small, reference.basis, "VSWEC"))
    phase = np.linspace(0, 2 * np.pi, 2001)
    motion = np.real(q[:, :, None] * np.exp(-1j * phase))
    change = np.einsum("kw,wkt->wt", changes.power_slope.sel(design="VSWEC").values, motion)
    np.testing.assert_allclose(changes.power_swing.sel(design="VSWEC"), change.max(axis=1), rtol=1e-5)


def test_power_of_the_undeformed_sphere(small, reference, family):
    """None about the sphere itself; about another shape, minus its amplitudes times the slope."""
    assert np.all(shapedependence.power_changes(small, reference, family).power_undeformed == 0)
    q = np.array([0.1, 0.05, 0.0, -0.02])
    moved = dataclasses.replace(reference, shape=dataclasses.replace(reference.shape, amplitudes=q))
    changes = shapedependence.power_changes(small, moved, family)
    np.testing.assert_allclose(
        changes.power_undeformed, -np.einsum("k,dkw->dw", q, changes.power_slope.values), rtol=1e-12
    )


def test_everything_has_units_and_the_dimensions_named(dataset):
    assert all(data.attrs["units"] for data in dataset.data_vars.values())
    assert dataset.added_mass_slope.dims == ("shape_dof", "omega", "influenced_dof", "radiating_dof")
    assert dataset.excitation_force_curvature.dims == ("shape_dof", "omega", "wave_direction", "influenced_dof")
    assert dataset.added_mass_inf_slope.dims == ("shape_dof", "influenced_dof", "radiating_dof")
    assert dataset.radiation_damping_slope.attrs["units"] == "kg/(m s)"


def test_the_table_of_errors_is_that_of_the_family(dataset, family):
    size = float(dataset.deformation[2])
    random, single = (
        family.interpolation_error(size, single=s, samples=2).to_array().max("variable") for s in (False, True)
    )
    at = dataset.interpolation_error.isel(deformation=2)
    assert float(at.sel(expansion="first")) == pytest.approx(float(random.sel(order=1)), rel=1e-9)
    assert float(at.sel(expansion="second")) == pytest.approx(float(random.sel(order=2)), rel=1e-9)
    assert float(at.sel(expansion="single")) == pytest.approx(float(single.sel(order=2)), rel=1e-9)


def test_relative_slopes_are_logarithmic_derivatives(dataset, family):
    h = 0.01
    for name in ("added_mass", "excitation_force"):
        heave = [
            np.abs(family.at(np.array([s * h, 0, 0, 0]))[name].values.reshape(len(OMEGAS), -1)[:, 0]) for s in (1, -1)
        ]
        got = shapedependence.relative_slope(dataset, name).sel(shape_dof="Heave")
        np.testing.assert_allclose(got, np.log(heave[0] / heave[1]) / (2 * h), rtol=2e-3, atol=1e-4)


def test_the_figure_shows_heave_and_the_largest_mode(dataset):
    upper, lower = shapedependence.shape_figure(dataset).axes
    labels = [line.get_label() for line in upper.get_lines()]
    assert shapedependence.largest_mode(dataset) == "Membrane0"
    assert labels == [f"{s} by {m}" for m in ("Heave", "Membrane0") for s in ("added mass", "damping", "excitation")]
    np.testing.assert_array_equal(lower.get_lines()[0].get_ydata(), dataset.interpolation_error.sel(expansion="first"))


def test_a_rigid_buoy_has_heave_alone(seed):
    rigid = varied(seed, designs={"FSB": {"flexible": False}})
    ds = shapedependence.shape_dataset(rigid, family_of(reference_shell(rigid).shape), samples=1)
    assert shapedependence.largest_mode(ds) is None
    assert len(shapedependence.shape_figure(ds).axes[0].get_lines()) == 3


def test_files_are_written(small, dataset, tmp_path, monkeypatch):
    monkeypatch.setattr(shapedependence, "shape_dataset", lambda study: dataset)
    for name in {str(v) for v in dataset.variables} - set(units.ATTRS):
        quantity = units.Quantity(dataset[name].dims, dataset[name].attrs.get("units", "1"), name)
        monkeypatch.setitem(units.ATTRS, name, quantity)
    shapedependence.shape_dependence(small, str(tmp_path / "a.nc"), str(tmp_path / "a.svg"))
    back = units.load(tmp_path / "a.nc")
    np.testing.assert_array_equal(back.excitation_force_slope, dataset.excitation_force_slope)
    assert "size of the deformation" in (tmp_path / "a.svg").read_text()


def test_frequencies_of_a_study_hold_its_waves(small, reference):
    family = shapedependence.study_family(small, reference, frequencies=6)
    assert family.omegas == (2.0, small.waves[0].omega, 4.0, 6.0, 8.0, 10.0, 12.0)


def test_finite_depth_is_refused(small, reference):
    shallow = varied(small, water={"depth": 20.0})
    with pytest.raises(ConfigError, match=r"water\.depth: received 20 m"):
        shapedependence.study_family(shallow, reference)


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda f: f.at(np.zeros(3)), r"amplitudes: received shape \(3,\); needs \(4,\)"),
        (lambda f: f.at(np.array([3.0, 0, 0, 0])), "reference_shape: received a shape"),
        (lambda f: f.expansion(np.zeros(4), 3), "order: received 3; needs 1 or 2"),
        (lambda f: f.interpolation_error(0.0), "amplitude: received 0 m"),
        (lambda f: f.interpolation_error(float("nan")), "amplitude: received nan m"),
    ],
)
def test_what_cannot_be_is_refused(call, match, family):
    with pytest.raises(ConfigError, match=match):
        call(family)
