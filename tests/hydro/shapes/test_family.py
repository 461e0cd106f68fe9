import dataclasses
from pathlib import Path
from types import SimpleNamespace

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


def test_second_derivatives_scale_twice(strained, strained_family):
    """Euler's identity once more: lengths l_k (A_kj l_j + ...) of a homogeneous function, at infinite frequency."""
    lengths = strained.modal_amplitude.copy()
    lengths[0] += strained.shape.centre_height
    lengths[1] += strained.basis.shell.radius
    eta = xr.DataArray(lengths, dims="shape_dof", coords={"shape_dof": strained_family.labels})
    curvature = strained_family.curvatures.added_mass_inf
    together = xr.dot(curvature, eta, eta.rename(shape_dof="other_shape_dof"))
    assert misfit(together, 6 * strained_family.centre.added_mass_inf) < 1e-5  # 3 (3 - 1) for a^3


def test_families_about_other_shapes_are_one(family):
    """Solved about a shape deformed by modes, or reached from the sphere: the same."""
    there, on = np.array([0.05, 0.02, 0.0, -0.08]), np.array([0.01, 0.0, 0.03, 0.02])
    about = family.about(there)
    xr.testing.assert_allclose(about.centre, family.at(there), rtol=0, atol=0)
    direct = family.at(there + on)
    for name in COEFFICIENTS:
        assert misfit(about.at(on)[name], direct[name]) < 1e-14


def test_shapes_solved_are_not_solved_again(reference, tmp_path, monkeypatch):
    """Nor is a stored shape taken for another: of other amplitudes, water, frequencies or points."""
    seen = []
    family = family_of(reference.shape, store=tmp_path / "shapes", after_each=lambda: seen.append(1))
    eta = np.array([0.02, 0.0, 0.01, 0.0])
    first = family.at(eta)
    others = [
        dataclasses.replace(family, **{k: v}) for k, v in {"omegas": OMEGAS[:4], "density": 1e3, "nodes": 24}.items()
    ]
    names = {other.about(eta).identity for other in (family, *others)} | {family.identity}
    assert len(names) == 5
    monkeypatch.setattr(ShapeFamily, "solved", lambda self: pytest.fail("solved again"))
    xr.testing.assert_equal(family.at(eta), first)
    assert len(seen) == 2
    assert [p.stem for p in (tmp_path / "shapes").iterdir()] == [family.about(eta).identity]


def test_whatever_changes_the_coefficients_of_a_shape_changes_its_name(reference):
    """Each by a thousand millionth or less; who stores it and by which steps it is differentiated changes none."""
    family, shape = family_of(reference.shape), reference.shape
    basis, modes = shape.basis, shape.basis.modes

    def of_basis(**changes):
        return family_of(dataclasses.replace(shape, basis=dataclasses.replace(basis, **changes)))

    first = [
        dataclasses.replace(modes[-1], **{k: getattr(modes[-1], k) * (1 + 1e-9)}) for k in ("radial", "meridional")
    ]
    others = [
        *(
            dataclasses.replace(family, **change)
            for change in (
                {"omegas": (*OMEGAS[:-1], OMEGAS[-1] + 1e-9)},
                {"density": family.density + 1e-6},
                {"gravity": family.gravity + 1e-9},
                {"nodes": 33},
            )
        ),
        *(of_basis(modes=(*modes[:-1], mode)) for mode in first),
        of_basis(shell=dataclasses.replace(basis.shell, radius=basis.shell.radius + 1e-9)),
        family_of(dataclasses.replace(shape, centre_height=shape.centre_height + 1e-10)),
        family_of(dataclasses.replace(shape, centre_height=-shape.centre_height)),
        *(family.about(1e-10 * one) for one in np.eye(len(family.labels))),
    ]
    assert shape.centre_height != 0
    assert len({one.identity for one in (family, *others)}) == 1 + len(others)
    assert dataclasses.replace(family, step=0.5 * family.step).identity == family.identity


def test_the_number_of_shapes(reference):
    seen = []
    family = family_of(reference.shape, nodes=16, after_each=lambda: seen.append(1))
    assert family.derivatives.added_mass_curvature.dims[:2] == ("shape_dof", "other_shape_dof")
    assert len(seen) == family.shapes_of_derivatives == 49


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


LABELS = ["Heave", "Mode0", "Mode3"]
GRADIENT = np.array([2.0, -3.0, 0.5])
BENDING = np.array([[4.0, -1.0, 2.5], [-1.0, -6.0, 0.75], [2.5, 0.75, 3.0]])
THIRD = np.array([7.0, -5.0, 0.2])
SIZES = dict(zip(COEFFICIENTS, (1.0, -2.0, 0.5 + 1.0j, 3.0), strict=True))


class Polynomial(ShapeFamily):
    """A family whose coefficients are known polynomials of the amplitudes."""

    def at(self, modal_amplitude):
        q = np.asarray(modal_amplitude)
        value = 10 + GRADIENT @ q + q @ BENDING @ q / 2 + THIRD @ q**3
        return xr.Dataset({name: ("omega", size * value * np.array([1.0, -2.0])) for name, size in SIZES.items()})


@pytest.fixture
def polynomial():
    shell = SimpleNamespace(labels=LABELS, shell=SimpleNamespace(radius=4.0))
    return Polynomial(SimpleNamespace(basis=shell), (1.0, 2.0), 1000.0, 9.81, step=0.05)


def test_derivatives_of_a_polynomial_are_its_own(polynomial):
    """Slopes, curvatures with all mixed terms, a sixth of the third derivative, at steps in radii of the shell."""
    for name, size in SIZES.items():
        at = size * np.array([1.0, -2.0])
        np.testing.assert_allclose(polynomial.slopes[name], GRADIENT[:, None] * at, rtol=1e-9)
        np.testing.assert_allclose(polynomial.curvatures[name], BENDING[:, :, None] * at, rtol=1e-7)
        for k, line in enumerate(polynomial.axes):
            np.testing.assert_allclose(line.cubic[name], THIRD[k] * at, rtol=1e-6)
            # what the last step of the extrapolation changed: nothing, for errors of second order
            np.testing.assert_allclose(line.correction[name], 0.0, atol=1e-9)
    assert polynomial.slopes.shape_dof.values.tolist() == LABELS
    assert polynomial.curvatures.added_mass.dims == ("shape_dof", "other_shape_dof", "omega")


def test_an_expansion_holds_what_is_of_its_order_and_no_more(polynomial):
    q = np.array([0.3, -0.2, 0.5])
    first, second = (polynomial.expansion(q, order) for order in (1, 2))
    for name, size in SIZES.items():
        at = size * np.array([1.0, -2.0])
        np.testing.assert_allclose(first[name], (10 + GRADIENT @ q) * at, rtol=1e-9)
        np.testing.assert_allclose(second[name], (10 + GRADIENT @ q + q @ BENDING @ q / 2) * at, rtol=1e-8)


def test_errors_of_expansions_are_the_largest_of_all_directions(polynomial):
    """In the same directions whatever the size, others of another seed."""
    for seed in (0, 5):
        found = polynomial.interpolation_error(0.8, samples=3, seed=seed)
        ways = np.random.default_rng(seed).standard_normal((3, 3))
        shapes = 0.8 * ways / np.linalg.norm(ways, axis=1, keepdims=True)
        left = np.array([[q @ BENDING @ q / 2 + THIRD @ q**3, THIRD @ q**3] for q in shapes])
        exact = np.array([10 + GRADIENT @ q + q @ BENDING @ q / 2 + THIRD @ q**3 for q in shapes])
        largest = np.abs(left / exact[:, None]).max(axis=0)
        for name in COEFFICIENTS:
            np.testing.assert_allclose(found[name], largest, rtol=1e-6)
            assert found[name].order.values.tolist() == [1, 2]


def test_a_misfit_is_the_largest_difference_over_the_largest_entry_whatever_their_signs():
    exact = xr.DataArray([[-5.0, 2.0], [1.0, 3.0]])
    assert misfit(exact + xr.DataArray([[0.0, -1.0], [0.5, 0.0]]), exact) == pytest.approx(0.2)
    assert misfit(exact * 1j, exact) == pytest.approx(np.sqrt(2))


def test_an_error_of_a_derivative_is_what_its_steps_and_its_own_relations_miss():
    """Of two motions: the last correction, and asymmetry, or damping against that of excitation, of each amplitude."""
    pair, waved = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
    omegas, labels = (1.0, 2.0), ["Heave", "Mode0"]
    x = np.array([[3.0 + 1.0j, -2.0j], [1.0, 0.5 - 2.0j]])
    lines = []
    for dx, asymmetric, scale in ((np.array([[1.0, 2.0j], [-1.0j, 4.0]]), 1.0, 1.25), (0.5 * x, 0.0, 1.0)):
        damping = scale * shapefamily.haskind_slope(np.array(omegas), x, dx, 1000.0, 9.81)
        added = np.array([[1.0, 3.0], [3.0 - asymmetric, -4.0]]) * np.ones((2, 1, 1))
        slope = xr.Dataset({
            "added_mass": (pair, added), "radiation_damping": (pair, damping),
            "excitation_force": (waved, dx[:, None]), "added_mass_inf": (pair[1:], 2.5 * added[0]),
        })  # fmt: skip
        lines.append(shapefamily.Line(slope, slope, -0.1 * slope, slope))
    basis = SimpleNamespace(labels=labels, shell=SimpleNamespace(radius=1.0))
    family = ShapeFamily(SimpleNamespace(basis=basis), omegas, 1000.0, 9.81)
    family.__dict__.update(axes=tuple(lines), centre=xr.Dataset({"excitation_force": (waved, x[:, None])}))
    expected = {"added_mass": 0.35, "added_mass_inf": 0.35, "radiation_damping": 0.3, "excitation_force": 0.3}
    for name, first in expected.items():
        np.testing.assert_allclose(family.slope_errors[name], [first, 0.1], rtol=1e-9)
    assert family.slope_errors.shape_dof.values.tolist() == labels


def test_coefficients_and_derivatives_have_their_units(polynomial):
    errors = xr.Dataset({name: ("shape_dof", [0.1, 0.2, 0.3]) for name in COEFFICIENTS}, {"shape_dof": LABELS})
    polynomial.__dict__.update(slope_errors=errors)
    found = polynomial.derivatives
    force = found.excitation_force
    assert [force.units, *(found[f"excitation_force_{name}"].units for name in ("slope", "curvature", "slope_error"))] == [
        "N/m", "N/m^2", "N/m^3", "1",
    ]  # fmt: skip
    assert found.added_mass_inf_curvature.units == "kg/m^2"
    np.testing.assert_allclose(found.radiation_damping_slope, polynomial.slopes.radiation_damping)
    np.testing.assert_allclose(found.added_mass_slope_error, [0.1, 0.2, 0.3])


def test_a_finer_family_has_a_third_more_points_and_not_one_less():
    for nodes, finer in ((24, 32), (25, 34), (26, 35), (27, 36)):
        assert ShapeFamily(None, OMEGAS, 1025.0, 9.81, nodes=nodes).finer.nodes == finer


def test_a_shape_is_solved_in_its_own_water_with_its_own_points(reference, monkeypatch):
    """All its displacements, at all its frequencies and at infinite frequency, in modes; no more than is asked for."""
    made, basis = [], reference.shape.basis
    moved = shapefamily.displacements_of(basis)
    labels = [each.label for each in moved]
    pair, n = ("influenced_dof", "radiating_dof"), len(labels)
    rng = np.random.default_rng(4)
    force = ("omega", "wave_direction", "influenced_dof")
    raw = xr.Dataset({
        **{name: (("omega", *pair), rng.normal(size=(2, n, n))) for name in ("added_mass", "radiation_damping")},
        **{f"{name}_force": (force, rng.normal(size=(2, 1, n))) for name in ("Froude_Krylov", "diffraction")},
    }, {"omega": [1.0, 3.0], "wave_direction": [0.0], **dict.fromkeys(pair, labels)})  # fmt: skip
    limit = rng.normal(size=(n, n))

    def problem(*given):
        made.append(given)
        return SimpleNamespace(solve=lambda omegas: made.append(omegas) or raw, at_infinity=lambda: limit)

    monkeypatch.setattr(shapefamily, "SpectralProblem", problem)
    found = ShapeFamily(reference.shape, (1.0, 3.0), 700.0, 4.0, nodes=31).solved()
    assert made == [(reference.shape, moved, 700.0, 4.0, 31), [1.0, 3.0]]
    assert list(found.data_vars) == list(COEFFICIENTS)
    expected = shapefamily.in_modes(raw.assign(
        added_mass_inf=(pair, limit), excitation_force=raw.Froude_Krylov_force + raw.diffraction_force
    ), basis)  # fmt: skip
    for name in COEFFICIENTS:
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-12, atol=1e-12)
