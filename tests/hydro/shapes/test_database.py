import copy
import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.errors import ConfigError, DatabaseError
from vsb.hydro.database import with_structure
from vsb.hydro.shapes import database as shapedatabase
from vsb.hydro.shapes.database import (
    SAFETY,
    ShapeDatabase,
    _left_out,
    measured_errors,
    phase_rates,
    shape_database,
    tried_shapes,
)
from vsb.hydro.shapes.family import COEFFICIENTS, ShapeFamily, haskind_damping, misfit
from vsb.motion.frequency import LinearBuoy
from vsb.motion.pto import LinearPto
from vsb.scenes.rest import reference_shell
from vsb.tools import files

OMEGAS = (0.8, 1.6, 2.4, 3.2, 4.8, 6.4)
GRID = np.array(OMEGAS)
REACH = np.array([0.25, 0.1, 0.1, 0.15])


@pytest.fixture(scope="module")
def reference(seed):
    return reference_shell(varied(seed, modes={"degree": 2}))


@pytest.fixture(scope="module")
def family(reference):
    return ShapeFamily(reference.shape, OMEGAS, 1025.0, 9.81, nodes=24)


@pytest.mark.parametrize("rate", [0.0, 0.7, -2.0])
def test_what_is_left_out_of_third_order_is_the_size_alone_whatever_the_phase(rate):
    """Of X = (a + b q + c q^2 + d q^3) e^{i(p + r q)}: |d|, and by Haskind 2 a |d| of damping, at any r and p."""
    random, shape = np.random.default_rng(3), (2, len(GRID), 1, 3)  # (shape_dof, omega, wave_direction, dof)
    phase = np.exp(1j * random.uniform(0, 6, shape[1:]))
    a = random.uniform(1, 2, shape[1:])
    b, c, d = random.uniform(-1, 1, (3, *shape))
    turn, dims = 1j * rate, ("omega", "wave_direction", "influenced_dof")

    def dataset(*values):
        """Excitation that is so many terms long."""
        damping = (("omega", "influenced_dof", "radiating_dof"), np.zeros((len(GRID), 3, 3)))
        return xr.Dataset({"excitation_force": (dims, values[0] * phase), "radiation_damping": damping})

    slope = b + turn * a
    curvature = 2 * (c + turn * b + turn**2 / 2 * a)
    cubic = d + turn * c + turn**2 / 2 * b + turn**3 / 6 * a
    axes = [SimpleNamespace(slope=dataset(s), curvature=dataset(k), cubic=dataset(t))
            for s, k, t in zip(slope, curvature, cubic, strict=True)]  # fmt: skip
    slopes = xr.Dataset({"excitation_force": (("shape_dof", *dims), slope * phase)})
    family = SimpleNamespace(centre=dataset(a), slopes=slopes, axes=axes, omegas=OMEGAS, density=1000.0, gravity=9.81)
    for found, third in zip(_left_out(family), d, strict=True):
        np.testing.assert_allclose(found.excitation_force, np.abs(third), rtol=1e-9)
        pair = a[:, 0, :, None] * np.abs(third[:, 0, None])
        haskind = (GRID**3 / (2 * 1000.0 * 9.81**3))[:, None, None] * (pair + pair.swapaxes(1, 2))
        np.testing.assert_allclose(found.radiation_damping, haskind, rtol=1e-9)


@pytest.fixture(scope="module")
def database(family):
    return shape_database(family, REACH, samples=12)


def values(database, eta):
    """What the database holds of `COEFFICIENTS` at its own frequencies."""
    c = database.at(GRID, eta)
    return dict(zip(COEFFICIENTS, (c.added_mass, c.damping, c.excitation, database.added_mass_inf(eta)), strict=True))


def test_it_holds_the_reference_shape(database, family):
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


def test_each_amplitude_alone_is_within_the_estimate_too(database, family):
    shapes = 0.6 * np.diag(REACH)
    estimated = np.array([list(database.error(eta).values()) for eta in shapes])
    assert np.all(measured_errors(database, family, shapes) <= estimated)


def test_the_remainder_is_of_third_order(database, family):
    """Damping's too, though it is not expanded."""
    eta = REACH * np.array([0.5, -0.7, 0.6, 0.8])
    found = measured_errors(database, family, eta / 2.0 ** np.arange(5)[:, None])
    orders = np.log2(found[:-1] / found[1:])
    assert np.all(np.abs(orders - 3) < 0.5), orders
    assert np.all(np.abs(orders[-1] - 3) < 0.1), orders


def test_the_remainder_is_the_largest_third_derivative_of_all_entries(database, family):
    for name in ("added_mass", "added_mass_inf"):
        largest = np.abs(family.centre[name].values).max()
        exact = [np.abs(line.cubic[name].values).max() / largest for line in family.axes]
        assert database.dataset.remainder.sel(coefficient=name).values == pytest.approx(exact, rel=1e-12)


def test_the_estimate_is_of_third_order(database):
    eta = REACH * np.array([0.5, -0.7, 0.6, 0.8])
    large, small = database.error(eta), database.error(eta / 2)
    for name in COEFFICIENTS:
        assert large[name] / small[name] == pytest.approx(8.0, rel=1e-3)
    assert all(0 < error < 1e-8 for error in database.error(np.zeros(4)).values())


def spoiled(family, **cached):
    """The family with some of what it has found replaced."""
    other = copy.copy(family)
    other.__dict__.update(cached)
    return other


@pytest.mark.parametrize("name", COEFFICIENTS)
def test_only_the_error_of_the_slope_tells_of_small_amplitudes(name, database, family):
    """A derivative by draft a fifth off: its largest entry times the amplitude, whatever third order is left out."""
    wrong = 0 * family.slope_errors
    wrong[name].values[0] = 0.2
    small = np.array([1e-6, 0.0, 0.0, 0.0])
    told, base = (
        shape_database(spoiled(family, slope_errors=wrong), REACH, samples=1).error(small),
        database.error(small),
    )
    slope, size = (float(np.abs(ds[name]).max()) for ds in (family.slopes.isel(shape_dof=0), family.centre))
    for each in COEFFICIENTS:
        assert told[each] == pytest.approx(base[each] + (0.2e-6 * slope / size if each == name else 0.0), abs=1e-9)
    assert told[name] > 100 * base[name]


def test_only_the_error_of_the_reference_tells_of_what_its_own_relations_miss(family):
    """Added mass a thousandth unsymmetric, excitation a per cent too large for the damping, thrice as SAFETY says."""
    pair = ("influenced_dof", "radiating_dof")
    uneven = family.centre.added_mass + 1e-3 * abs(family.centre.added_mass).max() * xr.DataArray(
        np.eye(4, k=1), dims=pair
    )
    wrong = {"added_mass": uneven, "excitation_force": 1.01 * family.centre.excitation_force}
    whole = {"centre": family.centre.assign(wrong), "derivatives": family.derivatives.assign(wrong)}
    told = shape_database(spoiled(family, **whole), REACH, samples=1).error(np.zeros(4))
    assert told["added_mass"] == pytest.approx(SAFETY * 0.5e-3, rel=0.1)
    assert told["radiation_damping"] == pytest.approx(SAFETY * 0.0201, rel=1e-3)


@pytest.mark.parametrize("nodes", [6, 8, 10])
def test_few_points_are_told_of_each_coefficient_and_no_more_than_thrice(nodes, family):
    """On the reference shape: symmetry and Haskind's relation hold far better than the values, excitation has neither."""
    few = dataclasses.replace(family, nodes=nodes)
    rough = shape_database(few, REACH, samples=1)
    told, held = rough.error(np.zeros(4)), values(rough, np.zeros(4))
    for name, value in held.items():
        exact = dataclasses.replace(family, nodes=48).centre[name]
        truth = misfit(exact.copy(data=value.reshape(exact.shape)), exact)
        assert truth < told[name] < 1.5 * SAFETY * truth, name


def test_the_scale_of_the_remainder_is_the_largest_of_the_errors_measured(database):
    """Third orders alone would say less of shapes that mix amplitudes; thrice as much as is met is said, no more."""
    ds, shapes = database.dataset, database.dataset.tried_shape.values
    told = np.array([list(database.error(eta).values()) for eta in shapes])
    share = ds.tried_error.values / told
    np.testing.assert_allclose(share.max(axis=0), 1 / SAFETY, rtol=1e-4)
    assert np.all(ds.remainder_scale.values > SAFETY)


def test_damping_takes_energy_on_every_shape(database):
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


def test_a_model_on_a_shape_is_that_solved_there(database, family, reference):
    """Response of the buoy with the database's coefficients, and with those of a solution on the shape."""
    eta, motions = REACH * np.array([0.3, 0.2, -0.3, 0.3]), np.eye(4)
    pto = LinearPto(8000.0)
    solved = LinearBuoy(with_structure(family.at(eta), reference), reference.basis.damping, pto)
    c = database.at(GRID, eta)
    w = GRID[:, None, None]
    impedance = -(w**2) * (solved.mass + c.added_mass) - 1j * w * (c.damping + solved.damping) + solved.stiffness
    got = np.linalg.solve(impedance, c.excitation[..., None])[..., 0]
    expected = solved.rao(GRID, motions)
    frozen = LinearBuoy(with_structure(family.centre, reference), reference.basis.damping, pto).rao(GRID, motions)
    missed, ignored = (np.abs(rao - expected).max() for rao in (got, frozen))
    assert missed < 2e-3 * np.abs(expected).max()
    assert missed < 0.1 * ignored


def test_between_frequencies_it_is_a_cubic_spline(database, family):
    """As of the linear buoy: of order 4 or better in the distance of the solved frequencies, on a deformed shape."""
    eta, errors = np.array([0.05, 0.02, -0.03, 0.04]), []
    between = np.array([2.2, 2.6, 3.0])
    near = dataclasses.replace(family, omegas=tuple(between)).at(eta)
    for count in (5, 9, 17):
        omega = np.linspace(0.4, 5.2, count)
        direct = dataclasses.replace(family, omegas=tuple(omega)).at(eta).assign_coords(omega=omega)
        slopes = {f"{n}_slope": 0 * direct[n].expand_dims(shape_dof=4) for n in COEFFICIENTS}
        curvatures = {f"{n}_curvature": 0 * direct[n].expand_dims(shape_dof=4, other_shape_dof=4) for n in COEFFICIENTS}
        bare = database.dataset[["shape_reach"]].merge({**direct, **slopes, **curvatures})
        added = ShapeDatabase(bare).at(between, 0 * eta).added_mass
        errors.append(np.abs(added - near.added_mass.values).max() / np.abs(near.added_mass.values).max())
    assert errors[2] < 1e-4
    assert np.all(np.log2(np.array(errors[:-1]) / errors[1:]) > 2.5), errors


def test_the_phase_of_short_waves_turns_with_the_waterline(family, database):
    """Of a breathing sphere, by K a: expanded without its phase, excitation has several times the error."""
    fast = dataclasses.replace(family, omegas=(6.0, 8.0, 10.0))
    omega, breathing = np.array(fast.omegas), np.eye(4)[1]
    line, x = fast.along(breathing), fast.centre.excitation_force.values[:, 0]
    rates = phase_rates(x, line.slope.excitation_force.values[None, :, 0])[0]
    mode = family.shape.basis.displacement(np.array([np.pi / 2]))[0][1, 0]  # of the waterline, outwards
    np.testing.assert_allclose(np.abs(rates), omega**2 / 9.81 * np.abs(mode), rtol=0.1)
    h, turn = 0.05, 1j * rates[:, None]
    direct, slope, curvature = (
        ds.excitation_force.values[:, 0] for ds in (fast.at(h * breathing), line.slope, line.curvature)
    )
    turned = np.abs(np.angle(np.sum(x.conj() * direct, axis=1)))
    np.testing.assert_allclose(turned, h * np.abs(rates), rtol=0.02)
    plain = x + h * slope + h**2 / 2 * curvature
    apart = x + h * (slope - turn * x) + h**2 / 2 * (curvature - 2 * turn * slope + turn**2 * x)
    missed = np.abs(np.exp(h * turn) * apart - direct).max(axis=1) / np.abs(plain - direct).max(axis=1)
    assert np.all(missed < 0.3), missed


def test_a_shape_deformed_by_a_mode_has_a_database_of_its_own(family):
    """About the shape deformed by an amplitude, the same water: one database at eta, another at eta less its centre."""
    moved = np.array([0.0, 0.0, 0.0, 0.12])
    about = shape_database(dataclasses.replace(family.about(moved)), REACH / 4, samples=2)
    on = REACH / 4 * np.array([0.5, 0.4, -0.3, 0.6])
    direct = family.at(moved + on)
    for name, value in values(about, on).items():
        exact = direct[name]
        assert misfit(exact.copy(data=value.reshape(exact.shape)), exact) < about.error(on)[name] < 1e-3


def test_it_is_stored_and_read_back(database, tmp_path):
    database.save(tmp_path / "shapes.nc")
    back, eta = ShapeDatabase.load(tmp_path / "shapes.nc"), 0.5 * REACH
    for ours, theirs in zip(database.at(GRID[:3], eta), back.at(GRID[:3], eta), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    assert back.error(eta) == database.error(eta)
    assert back.labels == ["Heave", "Membrane0", "Membrane1", "Membrane2"]


def test_a_file_of_another_kind_is_refused(database, tmp_path):
    files.save(database.dataset[["added_mass"]], tmp_path / "other.nc")
    with pytest.raises(DatabaseError, match=r"no shape database, without \['added_mass_inf', 'excitation_force', 'ref"):
        ShapeDatabase.load(tmp_path / "other.nc")


def test_shapes_tried_are_within_reach():
    shapes = tried_shapes(REACH, 10)
    assert shapes.shape == (18, 4)
    assert np.abs(shapes / REACH).max() == 1
    np.testing.assert_array_equal(shapes[:8], np.diag(REACH)[[0, 1, 2, 3] * 2] * np.repeat([1, -1], 4)[:, None])
    corners = np.all(np.abs(shapes[8:]) == REACH, axis=1)
    assert corners.sum() == 5


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
def test_what_it_does_not_hold_is_refused(call, error, match, database):
    with pytest.raises(error, match=match):
        call(database)


@pytest.mark.parametrize("reach", [np.ones(3), np.array([0.1, 0.1, 0.0, 0.1]), np.array([0.1, 0.1, np.nan, 0.1])])
def test_a_reach_must_be_positive(reach, family):
    with pytest.raises(ConfigError, match=r"reach: received .* m; needs 4 positive amplitudes"):
        shape_database(family, reach)


def test_an_estimate_is_the_sum_of_what_each_amplitude_leaves_out_either_way():
    """Third orders together, noise of derivatives, the reference; of every coefficient its own."""
    remainder = np.array([[8.0, 0.027], [1.0, 0.0], [0.0, 64.0], [0.125, 1.0]])
    scale, noise = np.array([3.0, 5.0, 2.0, 1.0]), np.array([[0.1, 0.2], [0.0, 0.3], [0.4, 0.0], [0.0, 0.0]])
    points = np.array([1e-3, 2e-3, 3e-3, 0.0])
    table = ("coefficient", "shape_dof")
    ds = xr.Dataset({
        "shape_reach": ("shape_dof", [0.5, 0.7]), "remainder": (table, remainder), "slope_noise": (table, noise),
        "remainder_scale": ("coefficient", scale), "reference_error": ("coefficient", points),
    }, {"shape_dof": ["Heave", "Mode0"]})  # fmt: skip
    for q in ([0.3, 0.6], [-0.3, 0.6], [0.3, -0.6], [-0.5, 0.0]):
        a, b = np.abs(q)
        third = [(r ** (2 / 3) * a**2 + s ** (2 / 3) * b**2) ** 1.5 for r, s in remainder]
        expected = scale * third + noise[:, 0] * a + noise[:, 1] * b + points
        assert list(ShapeDatabase(ds).error(np.array(q)).values()) == pytest.approx(expected)


def test_a_phase_turns_with_the_part_of_a_derivative_that_is_out_of_step():
    """Of e^{i b q} X (1 + c q) by b, whatever c; of no excitation by nothing."""
    x = np.array([[3.0 + 1.0j, -2.0j], [0.0, 0.5 - 2.0j], [0.0, 0.0]])
    rates, growth = np.array([[2.0, -3.0, 0.0], [0.5, 1.0, 0.0]]), np.array([0.7, -1.5])
    slopes = (1j * rates + growth[:, None])[:, :, None] * x
    np.testing.assert_allclose(phase_rates(x, slopes), rates, rtol=1e-12)


def test_the_ends_of_its_reach_and_of_its_band_are_part_of_it(database):
    for sign in (1, -1):
        assert database.error(sign * REACH) == database.error(REACH)
        ends = database.at(GRID[[0, -1]], sign * REACH)
        whole = database.at(GRID, sign * REACH)
        np.testing.assert_allclose(ends.damping, whole.damping[[0, -1]], rtol=1e-12, atol=1e-9 * whole.damping.max())


def test_noise_is_the_error_of_each_amplitudes_own_derivative(database, family):
    """In terms of the coefficient itself, per metre: of every coefficient and every amplitude its own."""
    ds = database.dataset
    assert ds.slope_noise.dims == ("coefficient", "shape_dof")
    largest = {name: float(np.abs(family.centre[name]).max()) for name in COEFFICIENTS}
    for i, name in enumerate(COEFFICIENTS):
        for k, line in enumerate(family.axes):
            error = float(family.slope_errors[name].values[k]) * float(np.abs(line.slope[name]).max())
            assert float(ds.slope_noise[i, k]) == pytest.approx(error / largest[name], rel=1e-9)
    assert (ds.attrs["water_density"], ds.attrs["gravity"]) == (family.density, family.gravity)
    assert ds.coefficient.values.tolist() == list(COEFFICIENTS)


@pytest.mark.parametrize(("q", "name", "value", "reach"), [
    ([1.5, -0.9, 0.1], "Mode0", "-0.9", "0.7"), ([1.9, 0.1, 0.25], "Mode2", "0.25", "0.2"),
    ([-2.1, 0.0, 0.3], "Heave", "-2.1", "2"), ([0.0, np.nan, 0.0], "Mode0", "nan", "0.7"),
])  # fmt: skip
def test_the_first_amplitude_beyond_its_own_reach_is_named(q, name, value, reach):
    ds = xr.Dataset({"shape_reach": ("shape_dof", [2.0, 0.7, 0.2])}, {"shape_dof": ["Heave", "Mode0", "Mode2"]})
    words = f"received {name} = {value} m; the shape database holds {reach} m either way: build it with more reach"
    with pytest.raises(ConfigError, match=f"^modal_amplitude: {words}$"):
        ShapeDatabase(ds).error(np.array(q))
    edge = np.array([2.0, -0.7, 0.2]) * (1 + 0.9e-9)
    np.testing.assert_array_equal(ShapeDatabase(ds)._checked(edge), edge)
    with pytest.raises(
        ConfigError, match=r"^modal_amplitude: received shape \(2,\); needs \(3,\), heave and all modes$"
    ):
        ShapeDatabase(ds).error(np.ones(2))


@pytest.mark.parametrize("samples", [0, 1, 5])
def test_every_other_random_shape_is_a_corner_from_the_second_on(samples):
    shapes = tried_shapes(REACH, samples)[2 * len(REACH) :]
    at_end = np.abs(shapes) == REACH
    assert at_end.tolist() == [[at % 2 == 1] * len(REACH) for at in range(samples)]


@pytest.mark.parametrize("end", [0, -1])
def test_round_off_beyond_either_end_of_the_band_is_part_of_it(database, end):
    """A thousand millionth of a radian per second, and no more."""
    outwards = -1e-9 if end == 0 else 1e-9
    held = database.at(GRID[[end]] + 0.9 * outwards, np.zeros(4))
    np.testing.assert_allclose(held.added_mass, database.at(GRID[[end]], np.zeros(4)).added_mass, rtol=1e-6)
    with pytest.raises(DatabaseError, match=r"are asked for, the shape database holds 0\.8 to 6\.4 rad/s; build"):
        database.at(GRID[[end]] + 1.2 * outwards, np.zeros(4))


def test_a_database_is_told_of_what_is_left_out_of_what_was_measured_and_of_more_points(monkeypatch):
    """Two motions; each coefficient in terms of its own largest entry, of either sign, the worst of all shapes thrice."""
    rng, reach, labels = np.random.default_rng(6), np.array([0.5, 0.2]), ["Heave", "Mode0"]
    pair, wave = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")

    def coefficients(size):
        return xr.Dataset({
            "added_mass": (pair, size * rng.normal(size=(2, 2, 2))),
            "radiation_damping": (pair, size * rng.normal(size=(2, 2, 2))),
            "excitation_force": (wave, size * (rng.normal(size=(2, 1, 2)) + 1j * rng.normal(size=(2, 1, 2)))),
            "added_mass_inf": (pair[1:], size * rng.normal(size=(2, 2))),
        })  # fmt: skip

    centre, left_out, lines = (
        coefficients(-5.0),
        [coefficients(2.0), coefficients(7.0)],
        [coefficients(3.0), coefficients(1.0)],
    )
    slopes = xr.concat(lines, "shape_dof")
    errors = xr.Dataset({name: ("shape_dof", rng.uniform(0.1, 1.0, 2)) for name in COEFFICIENTS})
    family = SimpleNamespace(
        labels=labels, centre=centre, slopes=slopes, slope_errors=errors, density=700.0, gravity=4.0,
        derivatives=xr.Dataset(coords={"shape_dof": labels}), finer=SimpleNamespace(centre="finer"),
    )  # fmt: skip
    measured, asked = rng.uniform(0.0, 1.0, (4 + 6, 4)), []
    monkeypatch.setattr(shapedatabase, "_left_out", lambda given: left_out)
    monkeypatch.setattr(
        shapedatabase, "measured_errors", lambda base, its, shapes: asked.append((its, shapes)) or measured
    )
    monkeypatch.setattr(
        shapedatabase,
        "_measured",
        lambda base, q, direct: asked.append((q.tolist(), direct)) or [1e-3, 2e-3, 3e-3, 4e-3],
    )
    ds = shape_database(family, reach, samples=6).dataset
    (its, shapes), (at, direct) = asked
    assert its is family
    assert (at, direct) == ([0.0, 0.0], "finer")
    np.testing.assert_array_equal(shapes, tried_shapes(reach, 6))
    for i, name in enumerate(COEFFICIENTS):
        size = np.abs(centre[name].values).max()
        cubic = np.array([np.abs(each[name].values).max() for each in left_out]) / size
        noise = [errors[name].values[k] * np.abs(lines[k][name].values).max() / size for k in (0, 1)]
        third = ((np.cbrt(cubic) * shapes) ** 2).sum(axis=1) ** 1.5
        told = ds.sel(coefficient=name)
        np.testing.assert_allclose(told.remainder, cubic, rtol=1e-12)
        np.testing.assert_allclose(told.slope_noise, noise, rtol=1e-12)
        assert float(told.remainder_scale) == pytest.approx(3 * (measured[:, i] / third).max(), rel=1e-12)
        assert float(told.reference_error) == pytest.approx(3e-3 * (i + 1), rel=1e-12)
        np.testing.assert_array_equal(told.tried_error, measured[:, i])
    np.testing.assert_array_equal(ds.shape_reach, reach)
    np.testing.assert_array_equal(ds.tried_shape, shapes)
    assert ds.attrs == {"water_density": 700.0, "gravity": 4.0}
