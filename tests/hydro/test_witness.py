"""Two solvers that share nothing but the shape, on a sphere and on what one of its modes makes of it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from scipy.interpolate import CubicSpline

from vsb.errors import ConfigError
from vsb.hydro import witness
from vsb.hydro.database import displacements_of, in_modes, with_excitation
from vsb.hydro.panels import rings
from vsb.hydro.panels.mesh import deformed_mesh
from vsb.hydro.panels.sweep import witness_runs
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.hydro.witness import COEFFICIENTS, Versions, Waves, deformed_shapes, error_estimate
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis, shell_modes
from vsb.shell.sphere import Shell
from vsb.tools.files import load, save

SHELL = Shell(2.0, 0.01, 1.0, 0.3, 1.0)
BASIS = ModeBasis(SHELL, shell_modes(SHELL, "full", 2), 1.0, bending=True)
WAVES = Waves((1.2, 2.2, 3.8), 1025.0, np.inf, 9.81)
MODE = "Bending2"
ROWS = 32


def afloat(height=0.0):
    return DeformedShell(BASIS, height)


def by_panels(shapes, green_folder, rows=ROWS):
    def mesh(shape, part):
        return deformed_mesh(shape.shell, rows // part, 2 * rows // part, 16 // part)

    return [witness_runs(green_folder, (mesh(s, 1), mesh(s, 2)), BASIS, WAVES) for s in shapes]


def by_spectral(shapes):
    return [witness.spectral_runs(s.shell, BASIS, WAVES) for s in shapes]


@pytest.fixture(scope="module")
def shapes():
    return deformed_shapes(afloat(), [MODE], np.inf)


@pytest.fixture(scope="module")
def panels(shapes, green_folder):
    return by_panels(shapes, green_folder)


@pytest.fixture(scope="module")
def spectral(shapes):
    return by_spectral(shapes)


@pytest.fixture(scope="module")
def compared(shapes, panels, spectral):
    return witness.compared(shapes, panels, spectral, WAVES)


@pytest.fixture(scope="module")
def derivatives(shapes, panels):
    return witness.derivatives(shapes, panels, BASIS, WAVES)


def test_the_solvers_agree_within_estimates_that_are_no_excuse(compared, derivatives, tmp_path):
    save(compared.merge(derivatives), tmp_path / "witness.nc")
    checks = witness.witness_checks(load(tmp_path / "witness.nc"))
    assert [check.name for check in checks] == ["witness", "witness_derivatives"]
    for check in checks:
        assert check.verdict == "ok", check
        assert 0.05 < check.value < 1, check
    assert float(compared.witness_difference.max()) < 3e-3
    assert float(compared.witness_estimate.sel(solver="panels").max()) < 8e-3
    assert float(compared.witness_estimate.sel(solver="spectral").max()) < 1e-5


def test_deformed_by_five_percent_the_coefficients_are_others(compared):
    """Else agreement on deformed shapes would say no more than on the mean one."""
    a = compared.shape_added_mass.sel(solver="spectral")
    for side in ("minus", "plus"):
        moved = np.abs(a.sel(shape=f"{MODE}_{side}") - a.sel(shape="mean")).max() / np.abs(a).max()
        assert moved > 10 * float(compared.witness_difference.max())


def test_one_percent_in_the_spectral_solver_is_a_doubt(shapes, panels, monkeypatch):
    sound = SpectralProblem.onto.func
    broken = property(lambda problem: 1.01 * sound(problem))
    monkeypatch.setattr(SpectralProblem, "onto", broken)
    check, *_ = witness.witness_checks(witness.compared(shapes, panels, by_spectral(shapes), WAVES))
    assert (check.name, check.verdict) == ("witness", "doubt")
    assert "added mass" in check.explanation
    assert 1 < check.value < 10


def test_one_percent_in_the_panels_is_a_doubt(shapes, spectral, green_folder, monkeypatch):
    sound = rings.ring_matrices

    def broken(*arguments):
        s, d = sound(*arguments)
        return 1.01 * s, d

    monkeypatch.setattr(rings, "ring_matrices", broken)
    check, *_ = witness.witness_checks(
        witness.compared(shapes[:1], by_panels(shapes[:1], green_folder), spectral[:1], WAVES)
    )
    assert check.verdict == "doubt"


def test_one_percent_in_the_derivatives_of_one_mode_is_seen(compared, derivatives):
    """The panels' errors are nearly the same on both sides: their difference is better than they are."""
    assert float(derivatives.slope_difference.max()) < 0.01


def test_central_differences_are_off_by_a_known_term_of_third_order(shapes, spectral):
    """With a solver that has next to no error of its own."""
    found = witness.derivatives(shapes, spectral, BASIS, WAVES)
    minus, plus = (run.found.fine for run in spectral[1:])
    slope = found.isel(shape_dof=0)[[f"{name}_slope" for name in COEFFICIENTS]]
    slope = slope.rename({f"{name}_slope": name for name in COEFFICIENTS})
    raw, left = witness.differences((plus - minus) / 0.2, slope, slope), found.slope_difference
    assert float(left.max()) < raw.max() / 10
    assert 0.01 * left.max() < found.slope_estimate.max() < 10 * left.max()
    assert np.all(left <= found.slope_estimate)


def matrices(value=1.0):
    pair, force = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
    shape = (2, 2, 2)
    return xr.Dataset({
        "added_mass": (pair, np.full(shape, value)),
        "radiation_damping": (pair, np.full(shape, value)),
        "excitation_force": (force, np.full((2, 1, 2), value + 0j)),
    })  # fmt: skip


@pytest.mark.parametrize(
    ("version", "name", "deep", "shallow"),
    [
        ("coarse", "added_mass", [1, 1, 1], [1, 1, 1]),
        ("coarse", "excitation_force", [1, 1, 1], [1, 1, 1]),
        ("implied", "added_mass", [1, 0, 0], [1, 0, 0]),
        ("implied", "radiation_damping", [0, 1, 1], [1, 1, 1]),
    ],
)
def test_every_part_of_the_estimate_counts(version, name, deep, shallow):
    """An error of 0.3 in one entry at one frequency."""
    fine, other = matrices(), matrices()
    other[name].values[1, 0, 1] = 1.3
    found = Versions(fine, fine, fine)._replace(**{version: other})
    for depth, parts in ((np.inf, deep), (10.0, shallow)):
        np.testing.assert_allclose(error_estimate(found, fine, depth), 0.3 * np.array(parts), atol=1e-12)


def test_estimates_are_in_terms_of_the_largest_entry_at_each_frequency():
    fine, other = matrices(), matrices()
    fine.added_mass.values[0] *= 100.0
    other.added_mass.values[:] = fine.added_mass.values
    other.added_mass.values[1, 0, 0] += 0.1
    np.testing.assert_allclose(witness.differences(other, fine, fine), [[0, 0, 0], [0.1, 0, 0]], atol=1e-12)


def database(solver, factor=1.0):
    omegas = [0.8, *WAVES.omegas, 4.5, 5.5]
    problem = SpectralProblem(afloat(), displacements_of(BASIS), WAVES.density, WAVES.gravity, 24)
    solved = with_excitation(in_modes(problem.solve(omegas), BASIS))
    return (factor * solved).assign_attrs(solver=solver)


@pytest.mark.parametrize(("solver", "least"), [("spectral", 0.05), ("capytaine 3.0", 0.0)])
def test_a_database_is_judged_by_the_other_solver(compared, solver, least):
    (check,) = witness.database_checks(compared, database(solver), 1e-9)
    other = "panels" if solver == "spectral" else "the spectral solver"
    assert check.explanation.startswith(f"hydro database and {other} on the mean shape")
    assert check.explanation.endswith(f"({other})")
    assert check.verdict == "ok", check
    assert least <= check.value < 1
    (check,) = witness.database_checks(compared, database(solver, 1.01), 1e-9)
    assert check.verdict == "doubt", check
    (check,) = witness.database_checks(compared, database(solver, 1.01), 0.02)  # which says so itself
    assert check.verdict == "ok", check
    asides = database(solver).reindex(wave_direction=[0.0, np.pi / 2], fill_value=9.9)  # what surge and sway need
    assert witness.database_checks(compared, asides, 1e-9) == witness.database_checks(compared, database(solver), 1e-9)


def test_a_database_may_be_off_by_what_it_says_of_the_bands_largest_entries(compared):
    """Damping of the longest waves is a small part of the largest: as far off as that allows it is no doubt."""
    sound = database("spectral")
    off, b = sound.copy(deep=True), np.abs(sound.radiation_damping.values).max(axis=(1, 2))
    off.radiation_damping.values[1] *= 1.02
    assert b.max() > 1.8 * b[1]
    for error, verdict in ((0.01, "ok"), (0.001, "doubt")):
        (check,) = witness.database_checks(compared, off, error)
        assert check.verdict == verdict, check


def test_a_database_elsewhere_in_frequency_is_not_judged(compared):
    assert witness.database_checks(compared, database("spectral").sel(omega=[4.5, 5.5]), 1e-9) == []


def test_shapes_have_the_names_of_their_modes_and_signs(shapes):
    assert [(s.name, s.amplitude) for s in shapes] == [("mean", 0.0), (f"{MODE}_minus", -0.1), (f"{MODE}_plus", 0.1)]
    for s in shapes[1:]:
        np.testing.assert_array_equal(s.shell.modal_amplitude, s.amplitude * np.eye(len(BASIS.labels))[4])


def test_shapes_are_counted_from_the_one_at_rest():
    rest = replace(afloat(), modal_amplitude=np.array([0.02, -0.05, 0.0, 0.01, 0.03]))
    for s in deformed_shapes(rest, [MODE], np.inf):
        moved = s.shell.modal_amplitude - rest.modal_amplitude
        np.testing.assert_allclose(moved, s.amplitude * np.eye(len(BASIS.labels))[4], atol=1e-15)


@pytest.mark.parametrize(("depth", "size"), [(2.5, 0.1), (2.1, 0.05), (2.02, 0.00625)])
def test_no_shape_comes_near_the_bottom(depth, size):
    found = deformed_shapes(afloat(), ["Membrane0"], depth)
    assert [s.amplitude for s in found] == pytest.approx([0.0, -size, size])
    lowest = [-float(s.shell.meridian(np.array([np.pi])).z[0]) for s in found]
    assert max(lowest) <= (2.0 + depth) / 2 + 1e-12


def test_no_shape_is_dry_or_under_water():
    for height in (1.95, -1.95):
        for s in deformed_shapes(afloat(height), ["Membrane0"], np.inf):
            ((start, end),) = s.shell.wet_segments
            assert start > 0
            assert end == np.pi


@pytest.mark.parametrize(
    ("wet", "once"),
    [
        ([(1.0, np.pi)], True),
        ([(0.0, np.pi)], False),  # under water
        ([(1.0, 2.0)], False),  # the keel is dry
        ([(1.0, 1.5), (2.0, np.pi)], False),
        ([], False),
    ],
)
def test_afloat_once_is_one_waterline_and_a_wet_keel(wet, once):
    assert witness._afloat_once(SimpleNamespace(wet_segments=wet)) is once


def test_a_keel_on_the_bottom_has_no_witness():
    with pytest.raises(ConfigError, match=r"hydro.witness: received modes Membrane0, one of which, however small"):
        deformed_shapes(afloat(), ["Membrane0"], 2.0)


def test_a_rigid_buoy_has_one_shape_and_no_derivatives(panels):
    rigid = deformed_shapes(afloat(), [], np.inf)
    assert [s.name for s in rigid] == ["mean"]
    assert not witness.derivatives(rigid, panels[:1], BASIS, WAVES)


def test_derivatives_are_of_deep_water(shapes, panels, compared):
    assert not witness.derivatives(shapes, panels, BASIS, WAVES._replace(depth=20.0))
    assert [check.name for check in witness.witness_checks(compared)] == ["witness"]


@pytest.mark.parametrize(("kept", "at"), [(slice(1, None), 0), (slice(0, 4), 3)])
def test_a_database_is_judged_at_both_ends_of_its_band(compared, kept, at):
    off = database("spectral").isel(omega=kept).copy(deep=True)
    assert off.omega.values[at] in WAVES.omegas
    off.added_mass.values[at] *= 1.02
    (check,) = witness.database_checks(compared, off, 1e-9)
    assert check.verdict == "doubt", check


def test_shapes_of_several_modes_are_one_after_the_other_and_all_of_one_size():
    """As small as the one nearest to the bottom needs it."""
    found = deformed_shapes(afloat(), ["Membrane0", "Bending2"], 2.1)
    names = ["mean", "Membrane0_minus", "Membrane0_plus", "Bending2_minus", "Bending2_plus"]
    assert [s.name for s in found] == names
    assert [s.amplitude for s in found] == pytest.approx([0.0, -0.05, 0.05, -0.05, 0.05])
    other = deformed_shapes(afloat(), ["Bending2", "Membrane0"], 2.1)
    assert [s.amplitude for s in other] == [s.amplitude for s in found]
    with pytest.raises(ConfigError, match=r"received modes Bending2, Membrane0, one of which, however small, makes"):
        deformed_shapes(afloat(), ["Bending2", "Membrane0"], 2.0)


def told(fine, off=0.0, seconds=1.0):
    """What a solver says: a finer run, and a coarser one that is off."""
    coarse = fine.map(lambda a: a + off)
    return witness.Runs(Versions(fine, coarse, fine), seconds)


def two_motions(value):
    """Coefficients of two motions at two frequencies, with their names."""
    names = {
        "omega": [1.0, 2.0],
        "wave_direction": [0.0],
        "influenced_dof": ["a", "b"],
        "radiating_dof": ["a", "b"],
    }
    return matrices(value).assign_coords(names)


def test_what_solvers_say_is_told_by_solver_and_shape():
    """Differences are of panels from the spectral solver, in terms of its own; estimates each in terms of their own."""
    shapes_ = [witness.Deformed(None), witness.Deformed(None, "m", -0.2), witness.Deformed(None, "m", 0.2)]
    by_panels_ = [told(two_motions(v), 0.1, s) for v, s in ((1.1, 5.0), (2.0, 6.0), (3.0, 7.0))]
    by_spectral_ = [told(two_motions(v), 0.01, s) for v, s in ((1.0, 0.5), (4.0, 0.6), (2.0, 0.7))]
    found = witness.compared(shapes_, by_panels_, by_spectral_, WAVES)
    assert found.shape.values.tolist() == ["mean", "m_minus", "m_plus"]
    assert found.solver.values.tolist() == ["panels", "spectral"]
    assert found.deformation_amplitude.values.tolist() == [0.0, -0.2, 0.2]
    assert found.witness_seconds.values.tolist() == [[5.0, 6.0, 7.0], [0.5, 0.6, 0.7]]
    assert found.witness_difference.values == pytest.approx(
        np.tile(np.array([0.1, 0.5, 0.5])[:, None, None], (1, 2, 3))
    )
    expected = 0.1 / np.array([1.1, 2.0, 3.0]), 0.01 / np.array([1.0, 4.0, 2.0])
    assert found.witness_estimate.values == pytest.approx(np.tile(np.array(expected)[..., None], (1, 1, 3)))
    for name in COEFFICIENTS:
        assert found[f"shape_{name}"].sel(solver="spectral", shape="m_plus").values == pytest.approx(2.0)
        assert found[f"shape_{name}"].sel(solver="panels", shape="m_minus").values == pytest.approx(2.0)


@pytest.mark.parametrize(("depth", "part"), [(np.inf, 0.0), (7.0, 0.2)])
def test_where_the_bottom_is_haskinds_error_is_that_of_added_mass_of_every_solver(depth, part):
    """The Green function of finite depth is itself approximate."""
    fine = two_motions(1.0)
    off = fine.assign(radiation_damping=fine.radiation_damping + 0.2)
    said = witness.Runs(Versions(fine, fine, off), 1.0)
    found = witness.compared([witness.Deformed(None)], [said], [said], WAVES._replace(depth=depth))
    assert found.witness_estimate.values == pytest.approx(np.tile([part, 0.2, 0.2], (2, 1, 1)))


def test_derivatives_of_several_modes_are_each_of_their_own_two_shapes(monkeypatch):
    shapes_ = deformed_shapes(afloat(), ["Membrane0", "Bending2"], np.inf)
    asked = []

    def derivative(family, low, sides, basis):
        asked.append((family, low.name, sides, basis))
        return two_motions(float(len(asked))), np.full((2, 3), 0.1 * len(asked)), np.full(3, 0.2 * len(asked))

    made = []
    monkeypatch.setattr(witness, "ShapeFamily", lambda *args: made.append(args) or "family")
    monkeypatch.setattr(witness, "_derivative", derivative)
    found = witness.derivatives(shapes_, ["0", "1-", "1+", "2-", "2+"], BASIS, WAVES)
    assert made == [(shapes_[0].shell, WAVES.omegas, WAVES.density, WAVES.gravity, witness.NODES)]
    assert asked == [
        ("family", "Membrane0_minus", ("1-", "1+"), BASIS), ("family", "Bending2_minus", ("2-", "2+"), BASIS),
    ]  # fmt: skip
    assert found.shape_dof.values.tolist() == ["Membrane0", "Bending2"]
    assert found.slope_difference.values == pytest.approx(np.tile([[[0.1]], [[0.2]]], (1, 2, 3)))
    assert found.slope_estimate.values == pytest.approx(np.tile([[0.2], [0.4]], (1, 3)))
    assert found.added_mass_slope.sel(shape_dof="Bending2").values == pytest.approx(2.0)


def hand_made(worst):
    """Differences and estimates of two solvers on two shapes at two frequencies; the worst for its estimates told."""
    dims = ("shape", "omega", "coefficient")
    names = {"shape": ["mean", "m_plus"], "omega": [1.25, 2.5], "coefficient": list(COEFFICIENTS)}
    difference = np.full((2, 2, 3), 0.001)
    difference[0, 0, 0] = 0.4  # the largest, as expected
    difference[1, 1, 2] = worst
    estimate = np.full((2, 2, 3), 0.01)
    estimate[0, 0, 0] = 0.9
    estimate[:, 1, 2] = [0.02, 0.03]
    return xr.Dataset(
        {"witness_difference": (dims, difference), "witness_estimate": (("solver", "shape", "coefficient"), estimate)},
        {**names, "solver": list(witness.SOLVERS)},
    )


@pytest.mark.parametrize(("worst", "verdict"), [(0.05, "ok"), (0.0501, "doubt")])
def test_the_worst_is_told_in_terms_of_both_estimates_with_its_place(worst, verdict):
    (check,) = witness.witness_checks(hand_made(worst))
    assert (check.name, check.limit, check.verdict) == ("witness", 1.0, verdict)
    assert check.value == pytest.approx(worst / 0.05, rel=1e-12)
    assert check.explanation == (
        f"panels and spectral solver on 2 shapes at 2 frequencies: {worst:.1e} of the largest entry apart in "
        "excitation force, m_plus at 2.5 rad/s, for estimated errors of 2.0e-02 (panels) and 3.0e-02 (the spectral solver)"
    )


def test_derivatives_are_judged_by_themselves_with_the_worst_mode():
    slopes = xr.Dataset(
        {
            "slope_difference": (("shape_dof", "omega", "coefficient"), [[[0.1, 0.0]], [[0.2, 0.06]]]),
            "slope_estimate": (("shape_dof", "coefficient"), [[0.2, 0.1], [0.5, 0.02]]),
        },
        {"shape_dof": ["Membrane0", "Bending2"], "omega": [1.5], "coefficient": ["added_mass", "radiation_damping"]},
    )
    _, check = witness.witness_checks(
        hand_made(0.01).merge(slopes.reindex(omega=[1.25, 1.5, 2.5], fill_value=0.0), fill_value=0.0, join="outer")
    )
    assert (check.name, check.verdict, check.value) == ("witness_derivatives", "doubt", pytest.approx(3.0))
    assert check.explanation == (
        "derivatives by 2 modes, central differences of panels and the spectral solver's: 6.0e-02 of the largest entry "
        "apart in radiation damping, Bending2 at 1.5 rad/s, for estimated errors of 2.0e-02 (both)"
    )


def test_runs_of_a_solver_are_in_modes_with_what_haskind_and_symmetry_imply_in_their_water(monkeypatch):
    """Of the finer run; added mass turned, damping from excitation in water of a depth."""
    waves, seen = Waves((1.0, 2.0), 700.0, 12.0, 4.0), []
    fine, coarse = two_motions(1.0), two_motions(3.0)
    fine.added_mass.values[:, 0, 1] = 5.0
    monkeypatch.setattr(witness, "in_modes", lambda ds, basis: ds.assign_attrs(basis=basis))
    monkeypatch.setattr(witness, "with_excitation", lambda ds: ds.assign(left_out=1.0))
    monkeypatch.setattr(witness, "haskind_damping", lambda *args: seen.append(args) or np.full((2, 2, 2), 9.0))
    found, seconds = witness.runs(lambda: fine, lambda: coarse, "basis", waves)
    assert seconds >= 0
    assert [args[1:] for args in seen] == [(12.0, 700.0, 4.0)]
    assert seen[0][0].equals(fine)
    assert [list(version.data_vars) for version in found] == [list(COEFFICIENTS)] * 3
    assert found.fine.equals(fine)
    assert found.coarse.equals(coarse)
    assert found.implied.added_mass.values.tolist() == [[[1.0, 1.0], [5.0, 1.0]]] * 2
    assert found.implied.radiation_damping.values.tolist() == np.full((2, 2, 2), 9.0).tolist()
    assert found.implied.excitation_force.equals(fine.excitation_force)


def test_a_witness_of_the_spectral_solver_is_solved_twice_in_its_own_water(monkeypatch):
    made, waves = [], Waves((1.0, 3.0), 700.0, 12.0, 4.0)

    def problem(*args, **named):
        made.append((args, named))
        return SimpleNamespace(solve=lambda omegas: (args[4], omegas))

    monkeypatch.setattr(witness, "SpectralProblem", problem)
    monkeypatch.setattr(witness, "runs", lambda fine, coarse, *rest: (fine(), coarse(), *rest))
    found = witness.spectral_runs("shell", BASIS, waves)
    moved = displacements_of(BASIS)
    assert made == [(("shell", moved, 700.0, 4.0, nodes), {"depth": 12.0}) for nodes in (24, 18)]
    assert found == ((24, [1.0, 3.0]), (18, [1.0, 3.0]), BASIS, waves)


def test_the_smallest_deformation_is_a_thousandth_of_the_radius():
    """Halved six times from a twentieth it is the last that is tried."""
    found = deformed_shapes(afloat(), ["Membrane0"], 2.007)
    assert [s.amplitude for s in found] == pytest.approx([0.0, -0.003125, 0.003125])
    with pytest.raises(ConfigError, match=r"^hydro.witness: received modes Membrane0, one of which"):
        deformed_shapes(afloat(), ["Membrane0"], 2.005)


@pytest.mark.parametrize("amplitude", [-0.4, 0.4])
def test_a_keel_is_the_deepest_point_wherever_that_is(amplitude):
    """Of a shell whose pole is pulled up, on a ring about it."""
    for place in range(1, len(BASIS.labels)):
        shell = replace(afloat(0.3), modal_amplitude=amplitude * np.eye(len(BASIS.labels))[place])
        deepest = -shell.meridian(np.linspace(0.0, np.pi, 20_001)).z.min()
        assert witness._keel(shell) == pytest.approx(deepest, rel=1e-3)
    pole = [-replace(afloat(), modal_amplitude=0.4 * sign * np.eye(len(BASIS.labels))[i]).meridian(np.array([np.pi])).z[0]
            for i in range(1, len(BASIS.labels)) for sign in (-1, 1)]  # fmt: skip
    assert min(pole) < 1.9


@pytest.mark.parametrize(("solver", "other"), [("spectral", "panels"), ("capytaine 3.0", "spectral")])
def test_a_database_is_compared_by_splines_in_terms_of_its_own_bands_largest(monkeypatch, solver, other):
    """Frequencies of the witness beyond its band are left out, both ends kept; motions may stand in any order.

    Largest is what the database has anywhere, in motions the witness has; differences are of those of the mean shape,
    in terms of the witness' largest at that frequency.
    """
    rng, grid, told_ = np.random.default_rng(2), np.array([1.0, 1.5, 2.0, 2.5, 3.0, 4.0]), []
    pair, waved = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")

    def database_of(labels, omega):
        n, m = len(labels), len(omega)
        return xr.Dataset({
            "added_mass": (pair, rng.normal(size=(m, n, n))), "radiation_damping": (pair, rng.normal(size=(m, n, n))),
            "excitation_force": (waved, rng.normal(size=(m, 1, n)) + 1j * rng.normal(size=(m, 1, n))),
        }, {"omega": omega, "wave_direction": [0.0], "influenced_dof": labels, "radiating_dof": labels})  # fmt: skip

    whole = database_of(["b", "yaw", "a"], grid).assign_attrs(solver=solver)
    for name in COEFFICIENTS:
        whole[name].loc[{"omega": 4.0}] *= 7.0
        whole[name].loc[{"influenced_dof": "yaw"}] *= 1e3
    asked = [0.9, 1.0, 2.2, 3.0, 4.0, 4.1]
    parts = {who: {shape: database_of(["a", "b"], asked) for shape in ("mean", "m_plus")} for who in witness.SOLVERS}
    ds = xr.concat([xr.concat(list(parts[who].values()), "shape") for who in parts], "solver")
    estimate = rng.uniform(0.1, 0.2, (2, 2, 3))
    ds = ds.rename({name: f"shape_{name}" for name in COEFFICIENTS}).assign(
        witness_estimate=(("solver", "shape", "coefficient"), estimate)
    ).assign_coords(solver=list(witness.SOLVERS), shape=["mean", "m_plus"], coefficient=list(COEFFICIENTS))  # fmt: skip
    monkeypatch.setattr(witness, "_agreement", lambda *given: told_.append(given) or "a check")
    assert witness.database_checks(ds, whole, 0.01) == ["a check"]
    ((name, what, apart, errors),) = told_
    assert name == "witness_database"
    assert what == f"hydro database and {witness.SOLVERS[other]} on the mean shape"
    kept = asked[1:5]
    assert apart.omega.values.tolist() == kept
    judge = parts[other]["mean"].sel(omega=kept)
    own = whole.sel(influenced_dof=["a", "b"], radiating_dof=["a", "b"])
    for name in COEFFICIENTS:
        theirs = judge[name].values
        largest = np.abs(theirs).reshape(4, -1).max(axis=1)
        missed = np.abs(CubicSpline(grid, own[name].values)(kept) - theirs).reshape(4, -1).max(axis=1)
        np.testing.assert_allclose(apart.sel(coefficient=name), missed / largest, rtol=1e-9)
        size = np.abs(own[name].values).max()
        np.testing.assert_allclose(errors["the database"].sel(coefficient=name), 0.01 * size / largest, rtol=1e-9)
    assert list(errors) == ["the database", witness.SOLVERS[other]]
    place = list(witness.SOLVERS).index(other)
    np.testing.assert_array_equal(errors[witness.SOLVERS[other]].values, estimate[place, 0])


@pytest.mark.parametrize("h", [0.2, 0.05])
def test_a_derivative_is_compared_less_its_third_order_and_expected_off_by_the_square_of_that(h):
    """In terms of the slope's largest entry; of the mode asked for, motions in the order of the basis."""
    basis, asked = SimpleNamespace(labels=("a", "b")), []
    slope, cubic = two_motions(2.0), two_motions(-0.5)

    def along(direction, levels):
        asked.append((direction.tolist(), levels))
        turned = {"influenced_dof": ["b", "a"], "radiating_dof": ["b", "a"]}
        return SimpleNamespace(slope=slope.sel(turned), cubic=cubic.sel(turned))

    family = SimpleNamespace(labels=["Heave", "a", "m"], along=along)
    third = -0.5 * h**2
    minus, plus = (Versions(*(two_motions(v) for v in each)) for each in (
        (1.0, 1.1, 1.0), (1.0 + 2 * h * (2.3 + third), 1.1 + 2 * h * (2.4 + third), 1.0 + 2 * h * (2.3 + third))
    ))  # fmt: skip
    found, apart, expected = witness._derivative(
        family, witness.Deformed(None, "m", -h), (witness.Runs(minus, 1.0), witness.Runs(plus, 1.0)), basis
    )
    assert asked == [([0.0, 0.0, 1.0], 2)]
    assert found.influenced_dof.values.tolist() == ["a", "b"]
    assert found.equals(slope)
    np.testing.assert_allclose(apart, np.full((2, 3), 0.3 / 2.0), rtol=1e-9)
    np.testing.assert_allclose(expected, np.full(3, 0.1 / 2.0 + (third / 2.0) ** 2), rtol=1e-9)
