import copy
import dataclasses

import numpy as np
import pytest
from conftest import varied

from vsb.errors import ConfigError, DatabaseError
from vsb.hydro.database import with_structure
from vsb.hydro.shapes.database import (
    ShapeDatabase,
    measured_errors,
    phase_rates,
    shape_database,
    tried_shapes,
)
from vsb.hydro.shapes.family import COEFFICIENTS, ShapeFamily, haskind_damping, misfit
from vsb.motion.frequency import LinearBuoy
from vsb.motion.port import LinearPto
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


def test_the_remainder_is_of_third_order(database, family):
    """Damping's too, though it is not expanded."""
    eta = REACH * np.array([0.5, -0.7, 0.6, 0.8])
    found = measured_errors(database, family, eta / 2.0 ** np.arange(5)[:, None])
    orders = np.log2(found[:-1] / found[1:])
    assert np.all(np.abs(orders - 3) < 0.5), orders
    assert np.all(np.abs(orders[-1] - 3) < 0.1), orders


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
