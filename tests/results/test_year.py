"""A site's year: against a loop over its hours written apart, against published practice."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from vsb.errors import ConfigError
from vsb.motion.damping_curve import Take
from vsb.motion.port import Port
from vsb.results.year import DesignYear, _error, band_weights, frequencies, gain_percent, year
from vsb.study.study import Water
from vsb.waves.climate import Climate
from vsb.waves.scatter import climate_of_cells

HOME = Path(__file__).parents[2]
WATER = Water()


def port(omega, mass=17000.0, loss=3000.0, stiffness=1.26e5):
    """A mass on a spring that radiates, not the hydrodynamics of any buoy."""
    impedance = -1j * omega * mass + loss * omega + stiffness / (-1j * omega)
    return Port(omega, 1 / impedance, 5e4 / (1 + omega**2) / impedance, 1 / stiffness)


def climate(seas=40, seed=1):
    """Seas of random spectra over 20 bands."""
    random = np.random.default_rng(seed)
    omega = 0.3 + 0.1 * np.arange(20)
    peak = random.uniform(0.4, 1.5, (seas, 1))
    density = random.uniform(0.1, 0.4, (seas, 1)) * np.exp(-(((omega - peak) / 0.2) ** 2))
    hours = random.uniform(0.5, 1.5, seas)
    return Climate.of_spectra(omega, density, hours / hours.sum(), "random seas")


def rms(climate, omega, response):
    """Root mean square of a signal in each sea, sqrt(int S |H|^2 dw), from |H|^2 per wave amplitude, (sea,)."""
    return np.sqrt(climate.density @ (band_weights(omega, climate) @ (response / 2)))


def stroke_rms(port, climate, damping):
    """That of the port's displacement under a damper, (sea,) [m]."""
    velocity = port.velocity_under(port.load(damping))
    return rms(climate, port.omega, np.abs(velocity / port.omega) ** 2)


def looped(sea, damping, omega, port):
    """Mean power of one sea, hour by hour and band by band: the integral of the broken line of its power."""
    load = 0.5 * damping * np.abs(port.velocity / (1 + port.admittance * damping)) ** 2
    total = 0.0
    for k, centre in enumerate(omega):
        inside = np.union1d(port.omega[np.abs(port.omega - centre) < 0.05], [centre - 0.05, centre + 0.05])
        power = np.interp(inside, port.omega, load)
        total += 2 * sea[k] * float(np.sum((power[1:] + power[:-1]) / 2 * np.diff(inside)))
    return total


@pytest.mark.parametrize("step", [0.031, 0.0123])
def test_every_hour_by_itself(step):
    seas, grid = climate(), np.arange(0.1, 3.0, step)
    ports = {"A": port(grid), "B": port(grid, mass=9000.0)}
    found = year(ports, seas, WATER, dampings={"A": 8e3, "B": 2e4}, reference="A")
    for i, p in enumerate(ports.values()):
        for j in range(3):
            hourly = [looped(s, found.damping[i, j, n], seas.omega, p) for n, s in enumerate(seas.density)]
            assert found.power[i, j] == pytest.approx(hourly, rel=1e-12)
            assert found.annual_mean_power[i, j] == pytest.approx(float(np.dot(hourly, seas.hours)), rel=1e-12)


def test_tunings_stand_in_their_order():
    seas = climate()
    grid = frequencies(seas, 0.1, 4.0)
    found = year({"A": port(grid)}, seas, WATER, dampings={"A": 8e3}).annual_mean_power[0]
    assert found[0] < found[1] < found[2]


def test_too_much_beyond_the_port():
    seas = climate()
    with pytest.raises(ConfigError, match=r"of its variance outside 0\.1 to 1 rad/s, .* raise hydro\.omega_max"):
        year({"A": port(np.linspace(0.1, 1.0, 100))}, seas, WATER, tunings=["one"])


def test_tunings_that_are_none():
    ports = {"A": port(np.arange(0.1, 3.0, 0.05))}
    with pytest.raises(ConfigError, match="tuning: received 'best', needs one of fixed, one, each"):
        year(ports, climate(), WATER, ["best"])
    with pytest.raises(ConfigError, match="tuning: received 'best', needs one of fixed, one, each"):
        year(ports, climate(), WATER, ["one", "best", "fixed", "none"])
    with pytest.raises(ConfigError, match=r"tuning: received fixed without a damping of A, needs pto\.damping"):
        year(ports, climate(), WATER, ["fixed"], {"B": 1.0})


def test_a_fixed_damper_is_given():
    with pytest.raises(ValueError, match="fixed: received no damper, needs one"):
        DesignYear(port(np.arange(0.1, 3.0, 0.05)), climate()).take("fixed", None)


def test_annual_power_of_a_damper_is_the_mean_of_its_seas():
    one, tried = DesignYear(port(np.arange(0.1, 3.0, 0.05)), climate()), np.geomspace(1e2, 1e6, 9)
    assert one.annual(tried) == pytest.approx(one.table(tried) @ one.climate.hours, rel=1e-13)


@pytest.mark.parametrize(("lowest", "highest"), [(0.1, 4.0), (0.52, 4.0), (0.1, 1.97), (0.25, 0.31)])
def test_every_band_is_cut_evenly_into_the_fewest_parts_of_half_a_percent(lowest, highest):
    """As far as hydrodynamics are known."""
    seas = climate()
    grid, edges = frequencies(seas, lowest, highest), np.unique(np.clip(seas.edges, lowest, highest))
    assert grid[0] == max(lowest, seas.edges[0])
    assert grid[-1] == min(highest, seas.edges[-1])
    assert np.all(np.diff(grid) > 0)
    assert set(edges) <= set(grid)
    for low, high in pairwise(edges):
        step, middle = np.diff(grid[(grid >= low) & (grid <= high)]), (low + high) / 2
        assert np.ptp(step) < 1e-12
        assert (len(step) - 1) * 0.005 * middle < high - low <= len(step) * 0.005 * middle * (1 + 1e-12)


def test_weights_are_shared_by_all_ports_over_the_same_frequencies():
    seas, grid = climate(), np.arange(0.1, 3.0, 0.05)
    assert band_weights(grid, seas) is band_weights(grid.copy(), climate())
    assert band_weights(grid[::2], seas).shape == (len(seas.omega), len(grid[::2]))


def test_designs_of_different_frequencies_keep_their_own():
    seas, fine, rough = climate(), np.arange(0.1, 3.0, 0.02), np.arange(0.1, 3.0, 0.05)
    together = year({"A": port(fine), "B": port(rough)}, seas, WATER, ["one"])
    moved = 1.1 * rough  # as many
    other = year({"A": port(rough), "B": port(moved)}, seas, WATER, ["one"])
    assert other.damping[1].tolist() == year({"B": port(moved)}, seas, WATER, ["one"]).damping[0].tolist()
    assert other.damping[1, 0, 0] != other.damping[0, 0, 0]
    for i, grid in enumerate((fine, rough)):
        alone = year({"A": port(grid)}, seas, WATER, ["one"])
        assert together.damping[i].tolist() == alone.damping[0].tolist()


def test_a_port_that_waves_do_not_move_takes_nothing():
    grid = np.arange(0.1, 3.0, 0.05)
    still = Port(grid, np.zeros(len(grid), dtype=complex), np.zeros(len(grid), dtype=complex), 0.0)
    found = year(
        {"rigid": still, "A": port(grid)}, climate(), WATER, dampings={"rigid": 1e3, "A": 1e4}, reference="rigid"
    )
    assert found.annual_mean_power[0].tolist() == [0.0, 0.0, 0.0]
    assert found.gain_percent is None
    assert "gain_percent" not in found.dataset()
    alone = year({"rigid": still}, climate(), WATER, ["one"])
    assert not alone.annual_mean_power.any()


def test_the_dataset_says_what_the_year_says():
    """Units on everything, no missing number, matrices that sum to the year."""
    grid = np.arange(0.1, 3.0, 0.02)
    found = year({"A": port(grid), "B": port(grid, mass=9e3)}, climate(), WATER, ["one", "each"], reference="A")
    ds = found.dataset()
    assert all(variable.attrs["units"] and np.isfinite(variable).all() for variable in ds.data_vars.values())
    by_bins = (ds.power_matrix * ds.occurrence).sum(["hs", "te"])
    assert by_bins.values == pytest.approx(found.annual_mean_power, rel=1e-12)
    assert ds.annual_energy.values == pytest.approx(found.annual_mean_power * 8766 / 1e6)
    assert ds.gain_percent.sel(design="B", tuning="one").item() == pytest.approx(
        100 * (found.annual_mean_power[1, 0] / found.annual_mean_power[0, 0] - 1)
    )
    assert int(ds["count"].sum()) == 40
    assert (ds.hs.values.tolist(), ds.te.values.tolist()) == (
        found.bins.hs_centres.tolist(),
        found.bins.te_centres.tolist(),
    )
    width = ds.annual_mean_power / float((ds.flux_matrix * ds.occurrence).sum())
    assert ds.capture_width.values == pytest.approx(width.values, rel=1e-12)


def test_the_rms_force_is_that_of_the_waves():
    """Mean square of c V over the year, from the spectra themselves."""
    seas, grid = climate(), np.arange(0.1, 3.0, 0.01)
    here = port(grid)
    found = year({"A": here}, seas, WATER, ["fixed"], {"A": 2e4})
    squared = np.abs(2e4 * here.velocity_under(here.load(2e4))) ** 2
    inside = np.arange(0.25, 2.25, 0.001) + 0.0005
    density = (seas.hours @ seas.density)[np.searchsorted(seas.edges, inside) - 1]
    mean = 0.001 * float(np.interp(inside, grid, squared) @ density)
    assert found.force_rms[0, 0] == pytest.approx(np.sqrt(mean), rel=1e-5)


@given(
    hnp.arrays(float, (3, 2), elements=st.floats(0.1, 10.0)),
    st.sampled_from([1e-9, 1e-3, 1e6]),
)
def test_gains_know_no_units(power, scale):
    """Of a power however small; of none there is no gain."""
    found = gain_percent(scale * power, 1)
    np.testing.assert_allclose(found, gain_percent(power, 1), rtol=1e-9, atol=1e-9)
    assert found[1].tolist() == [0.0, 0.0]
    power[1, 0] = 0.0
    part = gain_percent(scale * power, 1)
    assert np.isnan(part[:, 0]).all()
    np.testing.assert_array_equal(part[:, 1], found[:, 1])
    power[1] = 0.0
    assert gain_percent(scale * power, 1) is None


def test_the_error_of_the_quadrature_is_a_third_of_what_twice_the_step_changes():
    """By a year over every other frequency."""
    seas, grid = climate(), np.arange(0.1, 3.0, 0.04)[:71]
    fine, rough = (year({"A": port(one)}, seas, WATER, ["fixed"], {"A": 8e3}) for one in (grid, grid[::2]))
    (error,) = fine.quadrature_error[0]
    assert error == pytest.approx(abs(fine.annual_mean_power - rough.annual_mean_power)[0, 0] / 3, rel=1e-9)
    assert 0 < error < 0.1 * fine.annual_mean_power[0, 0]


def test_one_port_that_does_not_reach_is_enough_to_refuse():
    seas = climate()
    wide, narrow = port(np.linspace(0.1, 3.0, 100)), port(np.linspace(0.1, 1.0, 100))
    for ports in ({"A": wide, "B": narrow}, {"A": narrow, "B": wide}):
        with pytest.raises(ConfigError, match=r"of its variance outside 0\.1 to 1 rad/s"):
            year(ports, seas, WATER, ["one"])
    year({"A": wide}, seas, WATER, ["one"])


@pytest.mark.parametrize("count", [70, 71])
def test_half_the_frequencies_of_a_port_reach_from_its_first_to_its_last(count):
    """Of an even number the last two stay: the error of the quadrature is of the step alone."""
    grid = 0.1 + 0.04 * np.arange(count)
    half = DesignYear(port(grid), climate()).coarser().port
    assert half.omega.tolist() == [*grid[: count - 1 : 2], grid[-1]]
    assert half.velocity.tolist() == port(half.omega).velocity.tolist()


def test_the_band_that_is_told_is_what_all_ports_are_known_in():
    """From the highest first to the lowest last frequency, whichever port has them."""
    low, high = np.linspace(0.1, 1.0, 100), np.linspace(0.5, 3.0, 100)
    for ports in ({"A": port(low), "B": port(high)}, {"A": port(high), "B": port(low)}):
        with pytest.raises(
            ConfigError, match=r"climate random seas: received .*% of its variance outside 0\.5 to 1 rad/s"
        ):
            year(ports, climate(), WATER, ["one"])


def test_of_several_designs_without_a_damper_the_first_is_told():
    ports = {name: port(np.arange(0.1, 3.0, 0.05)) for name in "ABC"}
    with pytest.raises(ConfigError, match=r"received fixed without a damping of B, needs pto\.damping"):
        year(ports, climate(), WATER, ["one", "fixed"], {"A": 1.0})


def test_notes_of_the_climate_stand_before_what_is_not_counted():
    grid = np.arange(0.2, 2.19, 0.01)
    noted = replace(climate(), notes=("two records left out",))
    first, last = year({"A": port(grid)}, noted, WATER, ["one"]).notes
    outside = noted.variance_outside(grid[0], grid[-1])
    assert first == "two records left out"
    assert 0 < outside < 0.01
    assert last == f"{100 * outside:.3f}% of the variance lies outside the frequencies solved and is not counted"


def test_every_figure_of_a_bin_is_of_its_seas_and_gains_are_over_the_reference_wherever_it_stands():
    """Means and deviations by hours of power, of capture width and of the damper, bin by bin; the second design's gain."""
    seas, grid, water = climate(), np.arange(0.1, 3.0, 0.02), Water(depth=12.0, density=900.0)
    found = year({"A": port(grid), "B": port(grid, mass=9e3)}, seas, water, ["each", "one"], reference="B")
    ds, flux = found.dataset(), seas.flux(water)
    values = {"damping": found.damping, "power_matrix": found.power, "capture_width_matrix": found.power / flux}
    for i, j in np.ndindex(2, 2):
        for place in found.bins.occupied:
            its, at = found.bins.index == place, np.unravel_index(place, found.bins.shape)
            mean = {name: np.average(v[i, j, its], weights=seas.hours[its]) for name, v in values.items()}
            for name, each in mean.items():
                assert float(ds[name][i, j][at]) == pytest.approx(each, rel=1e-9), name
            for name, of in (("power_deviation", "power_matrix"), ("capture_width_deviation", "capture_width_matrix")):
                spread = np.average((values[of][i, j, its] - mean[of]) ** 2, weights=seas.hours[its])
                assert float(ds[name][i, j][at]) == pytest.approx(np.sqrt(spread), abs=1e-9 * mean[of]), name
            assert float(ds.flux_matrix[at]) == pytest.approx(np.average(flux[its], weights=seas.hours[its]))
    power = found.annual_mean_power
    assert ds.gain_percent.values == pytest.approx(100 * (power / power[1] - 1), abs=1e-9)
    assert np.abs(ds.gain_percent.values[0]).min() > 0.1
    np.testing.assert_array_equal(ds.practice_power, found.practice)
    np.testing.assert_array_equal(ds.quadrature_error, found.quadrature_error)


def test_usual_practice_has_the_same_tuning_in_seas_at_the_centres_of_bins():
    """The best damper of each such sea under each; else the year's own one."""
    seas, grid = climate(), np.arange(0.1, 3.0, 0.02)
    here = port(grid)
    found = year({"A": here}, seas, WATER, ["each", "fixed", "one"], {"A": 5e3})
    bins = found.bins
    there = DesignYear(here, climate_of_cells(*bins.centres, bins.share.ravel()[bins.occupied], 3.3, "centres"))
    dampers = (None, 5e3, found.damping[0, 2, 0])
    for practice, name, damper in zip(found.practice[0], ("each", "fixed", "fixed"), dampers, strict=True):
        assert practice == pytest.approx(float(there.take(name, damper).power @ there.climate.hours), rel=1e-12)
    assert found.practice[0, 0] > found.practice[0, 2] * (1 + 1e-6)


def test_the_error_of_the_quadrature_has_no_sign_and_weighs_seas_by_their_hours():
    seas = climate(seas=2)
    fine, rough = Take(np.zeros(2), np.array([5.0, 2.0])), Take(np.zeros(2), np.array([2.0, 8.0]))
    expected = abs(3.0 * seas.hours[0] - 6.0 * seas.hours[1]) / 3
    assert _error(seas, fine, rough) == _error(seas, rough, fine) == pytest.approx(expected)


@pytest.mark.parametrize(("low", "high"), [(0.1, 3.0), (0.41, 1.87), (0.05, 1.12), (1.31, 2.6)])
def test_weights_integrate_what_is_straight_over_what_band_and_port_have_in_common(low, high):
    """Bands of several widths, wider than the port at either end: 2 dw and 2 w dw of what is left of each."""
    omega = np.array([0.3, 0.4, 0.6, 0.9, 1.0, 1.6, 1.9, 2.2])
    seas = Climate.of_spectra(omega, np.ones((1, 8)), np.ones(1), "flat")
    grid = np.linspace(low, high, 23) ** 1.5 / np.sqrt(high) + low * (1 - np.sqrt(low / high))
    weights = band_weights(grid, seas)
    inside = np.clip(seas.edges, grid[0], grid[-1])
    assert weights.sum(axis=1) == pytest.approx(2 * np.diff(inside), abs=1e-12)
    assert weights @ grid == pytest.approx(np.diff(inside**2), abs=1e-12)
    assert weights.min() >= 0


def test_the_rms_force_of_dampers_of_each_sea_is_that_of_all_of_them():
    """The mean square of c V over the year, each sea under its own damper; the second of two designs too."""
    seas, grid = climate(), np.arange(0.1, 3.0, 0.02)
    ports = {"A": port(grid), "B": port(grid, mass=9e3)}
    found = year(ports, seas, WATER, ["one", "each"])
    for i, here in enumerate(ports.values()):
        each = found.damping[i, 1]
        assert np.ptp(each) > 0.1 * each.mean()
        moved = [
            np.abs(c * here.velocity_under(here.load(c))) ** 2 @ band_weights(grid, seas).T @ s / 2
            for c, s in zip(each, seas.density, strict=True)
        ]
        assert found.force_rms[i, 1] == pytest.approx(np.sqrt(np.dot(moved, seas.hours)), rel=1e-9)


def test_figures_stand_beside_the_notes_of_their_year():
    """All of them: of the climate, and on what is not counted."""
    found = year({"A": port(np.arange(0.1, 3.0, 0.05))}, replace(climate(), notes=("half a year",)), WATER, ["one"])
    assert found.dataset().attrs["notes"] == list(found.notes)
    assert len(found.notes) == 2


def test_there_is_no_gain_over_what_drives():
    power = np.array([[3.0, 2.0], [-1.0, 4.0]])
    np.testing.assert_array_equal(gain_percent(power, 1), [[np.nan, -50.0], [np.nan, 0.0]])
    assert gain_percent(power[:, :1], 1) is None


def test_a_port_that_waves_do_not_move_has_a_damper_of_nothing_under_every_tuning():
    grid, nothing = np.arange(0.1, 3.0, 0.05), np.zeros(58, dtype=complex)
    for tuning, damper in (("fixed", 1e3), ("one", 2e3), ("each", None)):
        taken = DesignYear(Port(grid, nothing, nothing, 0.0), climate()).take(tuning, damper)
        assert not taken.damping.any()
        assert taken.power.shape == taken.damping.shape == (40,)


def test_what_a_year_says_of_a_design_and_a_tuning_is_what_it_says_of_them_alone():
    """Dampers, powers, usual practice and error, of the second design under the third tuning as of the first."""
    seas, grid = climate(), np.arange(0.1, 3.0, 0.04)
    ports, dampers = {"A": port(grid), "B": port(grid, mass=9e3)}, {"A": 8e3, "B": 2e4}
    together = year(ports, seas, WATER, ("each", "fixed", "one"), dampers)
    for i, name in enumerate(ports):
        for j, tuning in enumerate(together.tunings):
            alone = year({name: ports[name]}, seas, WATER, (tuning,), dampers)
            for figure in ("damping", "power", "practice", "quadrature_error", "annual_mean_power", "force_rms"):
                of_all, of_one = getattr(together, figure)[i, j], getattr(alone, figure)[0, 0]
                np.testing.assert_allclose(of_all, of_one, rtol=1e-9, err_msg=f"{figure} of {name}, {tuning}")
    assert len(np.unique(together.quadrature_error)) == len(np.unique(together.practice)) == 6


def test_a_damper_of_nothing_is_given_and_takes_nothing():
    grid = np.arange(0.1, 3.0, 0.05)
    found = year({"A": port(grid), "B": port(grid)}, climate(), WATER, ["fixed", "one"], {"A": 0.0, "B": 8e3})
    assert not found.damping[0, 0].any()
    assert found.annual_mean_power[0, 0] == found.practice[0, 0] == found.force_rms[0, 0] == 0.0
    assert found.annual_mean_power[0, 1] > found.annual_mean_power[1, 0] > 0.0
