from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

from vsb.errors import ConfigError
from vsb.hydro import dofs, sweep
from vsb.hydro.rational import Rational
from vsb.hydro.retardation import DampingSpectrum
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.hydro.spectral.sweep import converged_on_grid, incident_wave
from vsb.hydro.sweep import FORCES, GridSweep, IncidentWave, largest, on_grid
from vsb.scenes.rest import reference_shell
from vsb.shell.deformed import rigid_sphere
from vsb.study import study as config

HERE = Path(__file__).parents[1]
GRID = [round(0.1 * i, 10) for i in range(1, 129)]
BETWEEN = np.linspace(GRID[0], GRID[-1], 300)
LEGENDRE = tuple(f"Radial{n}" for n in range(7))


def buoy(height=0.0, displacements=LEGENDRE, nodes=32, order=0):
    """The seed's sphere in water."""
    return SpectralProblem(rigid_sphere(2.0, height), dofs.displacements(displacements, order), 1025.0, 9.81, nodes)


def pressurised():
    """The shell of the pressurised study at equilibrium, strained by 14 %."""
    shape = reference_shell(config.load(HERE.parent / "config" / "pressurised.yaml")).shape
    return SpectralProblem(
        shape, dofs.displacements([*LEGENDRE, *(f"Meridional{n}" for n in range(1, 7))]), 1025.0, 9.81, 32
    )


def largest_error(found, exact):
    """Of added mass, damping and excitation, each relative to the band's largest entry."""
    pairs = [(found[name].values, exact[name].values) for name in ("added_mass", "radiation_damping")]
    pairs.append(tuple(sum(ds[name].values for name in FORCES) for ds in (found, exact)))
    return max(float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs)


def swept(solver, tolerance, grid=GRID):
    found = on_grid(solver.solve, grid, tolerance, incident_wave(solver)).sweep
    assert found
    return found


@pytest.fixture(scope="module")
def cases():
    """Problems by name with their coefficients between the grid."""
    solvers = {"hemisphere": buoy(), "heave": buoy(displacements=("Radial1",)), "high": buoy(0.6), "low": buoy(-0.8)}
    solvers |= {"surge": buoy(displacements=("Surge", "Pitch"), order=1), "oblate": pressurised()}
    return {name: (solver, solver.solve(list(BETWEEN))) for name, solver in solvers.items()}


NAMES = ("hemisphere", "heave", "high", "low", "surge", "oblate")


@pytest.mark.parametrize(("tolerance", "solves"), [(1e-2, 15), (1e-3, 17), (1e-4, 19), (1e-5, 23), (1e-6, 27)])
@pytest.mark.parametrize("name", NAMES)
def test_the_estimate_bounds_the_error_and_few_solves_reach_the_tolerance(cases, name, tolerance, solves):
    solver, exact = cases[name]
    found = swept(solver, tolerance)
    assert found.solves <= solves
    assert found.error <= tolerance
    assert largest_error(found.at(BETWEEN), exact) <= found.error


@pytest.mark.parametrize("name", NAMES)
def test_limits_at_zero_and_infinity_are_those_solved_there(cases, name):
    """Neither is a sample, infinity is far outside the band; K log K makes zero the harder one."""
    solver, _ = cases[name]
    tolerance = 1e-4  # within it the distance changes a hundredfold with the round-off of the samples
    found = swept(solver, tolerance)
    for ours, theirs, bound in (
        (found.at_infinity, solver.at_infinity(), tolerance),
        (found.at_zero, solver.at_zero(), 3 * tolerance),
    ):
        assert np.abs(ours - theirs).max() <= bound * np.abs(theirs).max()


@pytest.mark.parametrize(("tolerance", "step"), [(1e-3, 0.1), (1e-4, 0.05), (3e-5, 0.025)])
def test_damping_added_mass_and_its_limit_satisfy_ogilvies_relations(cases, tolerance, step):
    solver, _ = cases["hemisphere"]
    grid = list(np.arange(1, round(12.8 / step) + 1) * step)
    ds = swept(solver, tolerance, grid).at(grid)
    spectrum, infinite = DampingSpectrum(ds.omega.values, ds.radiation_damping.values), solver.at_infinity()
    lower = ds.omega.values < 6.4
    missed = (ds.added_mass.values - infinite - spectrum.added_mass_difference(ds.omega.values))[lower]
    assert np.abs(missed).max() <= tolerance * np.abs(ds.added_mass.values).max()


def test_the_retardation_kernel_gives_added_mass_and_damping_back(cases):
    """A = A(inf) - (1/w) int K sin wt dt, B = int K cos wt dt, for heave."""
    solver, _ = cases["heave"]
    ds = swept(solver, 1e-4).at(GRID)
    time = np.linspace(0.0, 100.0, 5_001)
    kernel = DampingSpectrum(ds.omega.values, ds.radiation_damping.values).kernel(time)[:, 0, 0]
    some = ds.isel(omega=slice(9, 70, 10))
    for omega, a, b in zip(
        some.omega.values, some.added_mass.values[:, 0, 0], some.radiation_damping.values[:, 0, 0], strict=True
    ):
        sine, cosine = (cumulative_simpson(kernel * f(omega * time), x=time)[-1] for f in (np.sin, np.cos))
        assert solver.at_infinity().item() - sine / omega == pytest.approx(a, abs=1e-3 * a)
        assert cosine == pytest.approx(b, abs=1e-3 * ds.radiation_damping.values.max())


@pytest.mark.parametrize("name", NAMES)
def test_froude_krylov_force_needs_no_solve(cases, name):
    solver, exact = cases[name]
    known = incident_wave(solver).froude_krylov(BETWEEN)
    np.testing.assert_allclose(known, exact.Froude_Krylov_force.values, atol=1e-12 * np.abs(known).max())
    found = swept(solver, 1e-3).at(BETWEEN)
    np.testing.assert_allclose(found.Froude_Krylov_force.values, known, atol=1e-12 * np.abs(known).max())
    assert found.sizes == exact.sizes
    assert list(found.influenced_dof.values) == list(exact.influenced_dof.values)


def test_as_many_solves_serve_splines_far_worse(cases):
    solver, exact = cases["hemisphere"]
    found = swept(solver, 1e-4)
    spaced = np.linspace(GRID[0], GRID[-1], 4 * found.solves)
    spline = CubicSpline(spaced, solver.solve(list(spaced)).added_mass.values)(BETWEEN)
    missed = [np.abs(a - exact.added_mass.values).max() for a in (spline, found.at(BETWEEN).added_mass.values)]
    assert missed[1] < 0.01 * missed[0]


class Noisy:
    """A solver with an error that is not smooth, as a lid or a series of the Green function leaves."""

    def __init__(self, solver, size):
        self.solver, self.size, self.calls = solver, size, []

    def __call__(self, omegas):
        self.calls += omegas
        ds = self.solver.solve(list(omegas))
        rough = np.sin(1e4 * ds.omega)  # of each frequency its own, the same every time
        return ds.map(lambda a: a + self.size * rough * float(np.abs(a).max()) if "omega" in a.dims else a)


def test_noise_above_the_tolerance_is_refused_and_below_it_is_not_fitted(cases):
    solver, exact = cases["heave"]
    incident = incident_wave(solver)
    assert on_grid(Noisy(solver, 3e-3), GRID, 1e-4, incident).sweep is None
    quiet = on_grid(Noisy(solver, 1e-5), GRID, 1e-3, incident).sweep
    assert quiet.solves <= 17
    assert largest_error(quiet.at(BETWEEN), exact) <= quiet.error <= 1e-3


@pytest.mark.parametrize("count", [1, 3, 13, 128])
def test_what_cannot_be_interpolated_is_solved_once_each(cases, count):
    solver, _ = cases["heave"]
    noisy, grid = Noisy(solver, 3e-3), GRID[:count]
    found = on_grid(noisy, grid, 1e-4, incident_wave(solver))
    assert found.sweep is None
    assert sorted(noisy.calls) == found.solved == list(found.coefficients.omega.values) == grid
    assert largest_error(found.coefficients, solver.solve(grid)) < 1e-2
    assert (found.spline_error(solver.solve) > 1e-4) is (count > 1)


@given(st.permutations(range(7)), st.integers(-3, 3))
@settings(max_examples=5)
def test_order_of_displacements_and_density_do_not_matter(order, power):
    ours = swept(buoy(nodes=16), 1e-3)
    solver = SpectralProblem(
        rigid_sphere(2.0, 0.0), dofs.displacements(LEGENDRE[i] for i in order), 1025.0 * 2.0**power, 9.81, 16
    )
    theirs = swept(solver, 1e-3)
    np.testing.assert_array_equal(theirs.solved.omega.values, ours.solved.omega.values)
    added = theirs.at(BETWEEN).added_mass.sel(influenced_dof=list(LEGENDRE), radiating_dof=list(LEGENDRE))
    expected = 2.0**power * ours.at(BETWEEN).added_mass.values
    np.testing.assert_allclose(added.values, expected, atol=1e-6 * np.abs(expected).max())


def test_motions_that_move_no_water_have_zeros():
    solver = buoy(displacements=("Meridional1",))
    found = converged_on_grid(solver, GRID, 1e-3, 5e-4)
    assert 0 <= found.attrs["interpolation_error"] < 1e-3
    assert all(np.isfinite(found[name].values).all() for name in found)
    assert np.abs(found.added_mass.values).max() < 1e-20


@pytest.mark.parametrize("omega", [[0.05, 1.0], [1.0, 13.0]])
def test_beyond_the_band_nothing_is_told(cases, omega):
    found = swept(cases["heave"][0], 1e-2)
    with pytest.raises(ConfigError, match=r"omega: received .* rad/s, the sweep holds 0.1 to 12.8; sweep a wider band"):
        found.at(omega)


def test_splines_through_the_grid_converge_at_fourth_order(cases):
    solver, _ = cases["hemisphere"]
    found, steps = swept(solver, 1e-7), np.array([0.4, 0.2, 0.1, 0.05])
    errors = []
    for step in steps:
        grid = np.linspace(0.8, 6.4, round(5.6 / step) + 1)
        errors.append(GridSweep(found.at(grid), None).spline_error(found.at))
    slopes = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert errors[-1] < 1e-4
    assert np.all(slopes > 3.0), (errors, slopes)
    assert np.all(slopes < 5.0), (errors, slopes)


@pytest.mark.parametrize("name", ["added_mass", "radiation_damping", *FORCES])
def test_splines_through_any_one_coefficient_may_tell_of_the_error(name):
    """All are constant; between the frequencies of the grid one of them is 1.25, not 1."""
    grid = np.arange(1.0, 9.0)
    names = ("added_mass", "radiation_damping", *FORCES)
    flat = xr.Dataset({each: (("omega", "dof"), np.ones((len(grid), 2))) for each in names}, {"omega": grid})

    def exact(omega):
        between = flat.isel(omega=slice(len(omega))).assign_coords(omega=omega)
        return between.assign({name: 1.25 * between[name]})

    assert GridSweep(flat, None).spline_error(exact) == pytest.approx(0.2, rel=1e-12)


def test_the_largest_coefficients_are_those_of_all_parts():
    """Of each its own, in whatever part, of either sign; of motions that move no water they are one."""
    pair, force = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")

    def part(added_mass, damping, excitation):
        """One frequency of one motion."""
        values = {"added_mass": (pair, [[[added_mass]]]), "radiation_damping": (pair, [[[damping]]])}
        return xr.Dataset(values | {name: (force, [[[excitation / len(FORCES)]]]) for name in FORCES})

    assert largest(part(1.0, 5.0, 2j), part(-3.0, 0.5, -4.0)) == pytest.approx((3.0, 5.0, 4.0))
    assert largest(part(0.0, 0.0, 0.0), part(0.0, 2.0, 0.0)) == (1.0, 2.0, 1.0)


def coefficients_at(omega, seed=0):
    """Any coefficients of two motions at frequencies, of either sign."""
    rng, n = np.random.default_rng(seed), len(omega)
    pair, wave = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
    values = {name: (pair, rng.normal(size=(n, 2, 2))) for name in ("added_mass", "radiation_damping")}
    values |= {name: (wave, rng.normal(size=(n, 1, 2)) + 1j * rng.normal(size=(n, 1, 2))) for name in FORCES}
    return xr.Dataset(values, {"omega": omega})


def test_an_error_counts_in_terms_of_the_largest_of_its_own_wherever_that_is():
    """Of A and B, which share their poles, where it counts more: B is omega times the imaginary part."""
    omega = np.array([0.5, 2.0, 3.0])
    here, there = coefficients_at(omega), 3.0 * coefficients_at(np.array([9.0]), 1)
    incident = IncidentWave(lambda w: 0.7 * w**2, lambda w: np.zeros((len(w), 1, 2)), 1)
    a, b, x = (1 / size for size in largest(here, there))
    assert min(a / (1 / largest(here)[0]), x * largest(here)[2]) < 0.9
    radiation, excitation = sweep._families(here, incident, [there])
    at = np.array([0.1 * a / b, a / b, 4.0 * a / b])
    assert radiation.scale(at) == pytest.approx([a, a, 4.0 * a])
    assert excitation.scale(at) == pytest.approx([x] * 3)
    rows = here.added_mass.values + 1j * here.radiation_damping.values / omega[:, None, None]
    assert radiation.values == pytest.approx(rows.reshape(3, 4))
    total = sum(here[name].values for name in FORCES)[:, 0]
    phase = 0.7 * omega**2
    turned = -1j * np.exp(1j * phase * np.sqrt(phase / (2 + phase)))
    assert excitation.values == pytest.approx(total * turned[:, None])


def told_of(doubt, error, values=0.0):
    """What an interpolant of constants says of itself."""
    return SimpleNamespace(doubt=np.array(doubt), error=error, rational=lambda at: np.full((len(at), 2), values))


@pytest.mark.parametrize(
    ("first", "second", "solved", "chosen"),
    [
        ([0, 1, 9, 3, 2, 0], [0, 5, 1, 0, 0, 8], [0], [2, 5]),
        ([0, 1, 9, 3, 2, 0], [0, 8, 1, 0, 0, 5], [0], [2]),  # a neighbour
        ([0, 1, 9, 3, 2, 0], [0, 1, 1, 8, 0, 5], [0], [2]),
        ([0, 1, 9, 3, 2, 0], [0, 1, 9, 0, 4, 0], [0, 5], [2, 4]),  # both in doubt of one
        ([0, 1, 9, 3, 2, 0], [7, 1, 1, 0, 0, 5], [0, 2, 5], [3, 1]),
    ],
)
def test_the_next_frequencies_are_where_each_is_in_doubt_most_the_worse_one_first(first, second, solved, chosen):
    fits = [told_of(first, 0.2), told_of(second, 0.1)]
    for given_ in (fits, fits[::-1]):
        assert sweep._doubtful(given_, solved) == chosen
    if chosen == [2, 5]:
        assert sweep._doubtful([told_of(first, 0.1), told_of(second, 0.2)], solved) == [5, 2]


def test_a_surprise_is_the_largest_of_either_at_the_frequencies_solved_last():
    omega = np.array([1.0, 4.0, 2.0, 3.0])
    values = np.array([[9.0, 9.0], [9.0, 9.0], [1.0, -3.0], [1.0, 2.0]])
    fits = [told_of([0], 0.0, 1.0), told_of([0], 0.0, 0.5)]
    families = [sweep._Family(values, lambda at: 1 / at), sweep._Family(values / 2, lambda at: 0 * at + 0.7)]
    assert sweep._surprise(fits, families, omega, 2) == pytest.approx(2.0)
    assert sweep._surprise(fits, families, omega, 1) == pytest.approx(0.35)
    families = [families[1], families[0]]
    assert sweep._surprise([told_of([0], 0.0, -3.0), told_of([0], 0.0, 1.0)], families, omega, 2) == pytest.approx(
        0.7 * 4
    )


def test_differences_are_in_terms_of_the_largest_and_of_nothing_as_they_are():
    assert sweep.relative(np.array([0.5, -2.0j]), np.array([[3.0, -8.0], [1.0, 0.0]])) == 0.25
    assert sweep.relative(np.array([0.5, -2.0]), np.zeros(3)) == 2.0
    assert sweep.apart(np.array([1.0, 2.0 + 3j]), np.array([1.5, 2.0 - 1j])) == 4.0


@pytest.mark.parametrize("count", [14, 15, 64, 129])
def test_first_solves_are_both_ends_and_crowded_to_them(count):
    chosen = sweep.crowded(count)
    assert len(chosen) == sweep.FIRST_SOLVES
    assert (chosen[0], chosen[-1]) == (0, count - 1)
    gaps = np.diff(chosen)
    assert np.all(gaps > 0)
    assert gaps[0] < gaps[2] >= gaps[-1]
    assert [count - 1 - i for i in chosen[::-1]] == pytest.approx(chosen, abs=1)


@pytest.mark.parametrize(("count", "interpolated"), [(13, False), (14, True)])
def test_fourteen_frequencies_are_enough_to_interpolate(cases, count, interpolated):
    solver, _ = cases["heave"]
    grid = list(np.linspace(1.0, 2.0, count))
    found = on_grid(solver.solve, grid, 1e-2, incident_wave(solver), (), 20)
    assert (found.sweep is not None) is interpolated
    assert found.coefficients.omega.values.tolist() == grid
    assert (len(found.solved) < count) is interpolated


def test_what_is_larger_elsewhere_and_how_many_solves_there_may_be_are_heard(cases):
    """A tolerance of a band is one of the whole; and no more are solved by interpolation than allowed."""
    solver, _ = cases["heave"]
    incident = incident_wave(solver)
    alone = on_grid(solver.solve, GRID, 1e-5, incident)
    beside = on_grid(solver.solve, GRID, 1e-5, incident, [1000.0 * solver.solve([2.0])])
    assert len(beside.solved) < len(alone.solved)
    few = on_grid(solver.solve, GRID, 1e-5, incident, (), 9)
    assert few.sweep is None
    assert few.solved == GRID
    assert few.coefficients.added_mass.values == pytest.approx(solver.solve(GRID).added_mass.values)


@pytest.mark.parametrize(
    ("errors", "surprises", "most", "rounds", "told"),
    [
        ([(1e-5, 2e-5), (1e-5, 1e-5)], [3e-5], None, 2, 3e-5),  # never after the first
        ([(1e-5, 2e-5), (1e-5, 1e-5), (4e-5, 3e-5)], [1e-2, 1e-5], None, 3, 4e-5),  # a surprise
        ([(1e-5, 2e-5), (1e-5, 1e-2), (1e-5, 1e-5), (1e-5, 6e-5)], [1e-5, 1e-5, 1e-6], None, 4, 6e-5),  # the one before
        ([(1.0, 2.0), (0.1, 0.3), (0.2, 0.1)], [0.7, 0.4], 10, 3, 0.4),  # 7 solved, 8, 9: two more would be too many
        ([(1.0, 2.0), (0.1, 0.3), (0.2, 0.1)], [0.7, 0.05], 10, 3, 0.3),
        ([(1.0, 2.0)], [], 8, 1, np.inf),
    ],
)
def test_a_sweep_ends_once_two_interpolants_in_a_row_and_what_was_solved_between_agree(
    monkeypatch, errors, surprises, most, rounds, told
):
    """Its error is the largest of these; it goes on one by one, where doubt is largest, as long as two more may be."""
    grid, solved, seen = np.arange(1.0, 61.0), [], []
    left, surprise = iter(errors), iter(surprises)
    pair = iter(())

    def solve(omegas):
        solved.append(list(omegas))
        return coefficients_at(np.array(omegas))

    def families(ds, incident, elsewhere):
        nonlocal pair
        pair = iter(next(left))
        seen.append((len(ds.omega), incident, elsewhere))
        return sweep._Family("radiation", np.ones_like), sweep._Family("excitation", np.ones_like)

    def settled(omega, values, size, at, on_grid):
        assert at.tolist() == grid.tolist()
        assert (len(size), len(on_grid)) == (len(omega), len(grid))
        return SimpleNamespace(error=next(pair), rational=(values, len(omega)))

    def surprised(fits, both, omega, new):
        assert (len(fits), len(both), new) == (2, 2, 1)
        return next(surprise)

    monkeypatch.setattr(sweep, "_families", families)
    monkeypatch.setattr(sweep, "settled", settled)
    monkeypatch.setattr(sweep, "_surprise", surprised)
    monkeypatch.setattr(sweep, "_doubtful", lambda fits, there: [min(set(range(60)) - set(there))])
    found = sweep._sampled(solve, list(grid), 1e-4, "incident", "elsewhere", most)
    assert [len(each) for each in solved] == [7, *[1] * (rounds - 1)]
    assert seen == [(7 + i, "incident", "elsewhere") for i in range(rounds)]
    assert found.error == told
    assert found.solved.omega.values.tolist() == sorted(omega for each in solved for omega in each)
    assert (found.radiation, found.excitation) == (("radiation", 6 + rounds), ("excitation", 6 + rounds))
    assert found.incident == "incident"


@pytest.mark.parametrize(("count", "most", "solves"), [(60, None, 29), (200, None, 39), (60, 80, 59), (60, 20, 19)])
def test_no_more_is_solved_than_half_the_frequencies_or_forty_or_what_is_allowed(monkeypatch, count, most, solves):
    """One at a time; up to where two more would be more than that."""
    fit = SimpleNamespace(error=1.0, rational="r", doubt=np.zeros(count))
    monkeypatch.setattr(sweep, "settled", lambda *_: fit)
    monkeypatch.setattr(sweep, "_surprise", lambda *_: 1.0)
    monkeypatch.setattr(sweep, "_doubtful", lambda fits, there: [min(set(range(count)) - set(there))])
    incident = IncidentWave(lambda w: w, lambda w: np.zeros((len(w), 1, 2)), 0)
    grid = list(np.arange(1.0, count + 1))
    found = sweep._sampled(lambda omegas: coefficients_at(np.array(omegas)), grid, 1e-4, incident, (), most)
    assert found.solves == solves


def test_what_a_sweep_holds_is_what_its_interpolants_and_the_wave_say():
    """At frequencies in any order and at the limits; damping is omega times the imaginary part."""
    omega = np.array([0.5, 2.0, 3.0])
    solved = coefficients_at(omega).assign_coords(
        wave_direction=[0.0], influenced_dof=["a", "b"], radiating_dof=["a", "b"]
    )
    incident = IncidentWave(lambda w: 0.7 * w**2, lambda w: np.stack([w, -2j * w], axis=1)[:, None], 1)
    radiation = Rational(omega, np.arange(12.0).reshape(3, 4) * (1 + 0.5j), np.array([1.0 + 0.2j, -0.5, 0.3j]))
    excitation = Rational(omega, np.arange(6.0).reshape(3, 2) - 2j, np.array([0.4j, 1.0, -0.3 + 1j]))
    one = sweep.AdaptiveSweep(solved, radiation, excitation, incident, 0.1)
    at = np.array([2.7, 0.6, 3.0])
    found = one.at(at)
    assert found.omega.values.tolist() == at.tolist()
    assert found.added_mass.values == pytest.approx(radiation(at).real.reshape(3, 2, 2))
    assert found.radiation_damping.values == pytest.approx((at[:, None] * radiation(at).imag).reshape(3, 2, 2))
    total = excitation(at) / incident.turn(at)
    assert found.Froude_Krylov_force.values == pytest.approx(incident.froude_krylov(at))
    assert sum(found[name].values for name in FORCES)[:, 0] == pytest.approx(total)
    assert found.influenced_dof.values.tolist() == ["a", "b"]
    assert one.at_zero == pytest.approx(radiation(np.zeros(1)).real.reshape(2, 2))
    assert one.at_infinity == pytest.approx(radiation.at_infinity.reshape(2, 2))
    assert one.solves == 3
    with pytest.raises(ConfigError, match=r"received 0.6 to 3.1 rad/s, the sweep holds 0.5 to 3; sweep a wider band$"):
        one.at([3.1, 0.6])


def test_a_line_between_two_frequencies_is_a_spline_too_and_one_frequency_has_none():
    names = ("added_mass", "radiation_damping", *FORCES)
    grid = np.array([1.0, 3.0])
    line = xr.Dataset(
        {each: (("omega", "dof"), np.array([[1.0, -2.0], [3.0, 0.0]])) for each in names}, {"omega": grid}
    )
    asked = []

    def exact(omega):
        asked.append(omega)
        between = xr.DataArray([[2.5, -1.0]], dims=("omega", "dof"))
        return xr.Dataset({each: between if each == "radiation_damping" else 0.8 * between for each in names})

    assert GridSweep(line, None).spline_error(exact) == pytest.approx(0.2)
    assert asked == [[2.0]]
    assert GridSweep(line.isel(omega=[1]), None).spline_error(exact) == 0.0
