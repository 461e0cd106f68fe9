"""The year of a site: a loop over its hours, tunings, the quadrature, usual practice, bins of IEC TS 62600-100."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import varied
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from models.test_buoy_of_shape import water

from vsb.engine.motion.port import Port
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.measured_spectra import read_ndbc
from vsb.engine.waves.scatter import climate_of_cells
from vsb.engine.waves.water import Water, wavenumber
from vsb.errors import ConfigError
from vsb.models.floating_system import buoy_at
from vsb.models.rest import design_motions, reference_shell, study_basis
from vsb.results.budget import LeftOut
from vsb.results.year import (
    LIMITS,
    Absorbed,
    Bins,
    DesignYear,
    band_weights,
    beyond_validity,
    frequencies,
    gain_percent,
    motion_rms,
    wave_limits,
    within_errors,
    year,
)

WATER = Water()


def port(omega, mass=17000.0, loss=3000.0, stiffness=1.26e5):
    """A made-up port: a mass on a spring with radiation."""
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


def looped(sea, damping, omega, port):
    """Mean power of one sea: the integral of piecewise linear power, band by band."""
    load = 0.5 * damping * np.abs(port.velocity / (1 + port.admittance * damping)) ** 2
    total = 0.0
    for k, centre in enumerate(omega):
        inside = np.union1d(port.omega[np.abs(port.omega - centre) < 0.05], [centre - 0.05, centre + 0.05])
        power = np.interp(inside, port.omega, load)
        total += 2 * sea[k] * float(np.sum((power[1:] + power[:-1]) / 2 * np.diff(inside)))
    return total


def test_year_equals_a_loop_over_its_hours():
    seas, grid = climate(), np.arange(0.1, 3.0, 0.031)
    ports = {"A": port(grid), "B": port(grid, mass=9000.0)}
    found = year(ports, seas, WATER, dampings={"A": 8e3, "B": 2e4}, reference="A")
    for i, p in enumerate(ports.values()):
        for j in range(3):
            hourly = [looped(s, found.damping[i, j, n], seas.omega, p) for n, s in enumerate(seas.density)]
            assert found.power[i, j] == pytest.approx(hourly, rel=1e-12)
            assert found.annual_mean_power[i, j] == pytest.approx(float(np.dot(hourly, seas.hours)), rel=1e-12)


def test_climate_outside_the_band_is_refused():
    seas = climate()
    with pytest.raises(ConfigError, match=r"of its variance outside 0\.1 to 1 rad/s, .* raise hydro\.omega_max"):
        year({"A": port(np.linspace(0.1, 1.0, 100))}, seas, WATER, tunings=["one"])


def test_port_that_does_not_move_absorbs_nothing():
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


def test_dataset_of_the_year_is_consistent():
    """Units, no missing values, matrices that sum to the year."""
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
    width = ds.annual_mean_power / float((ds.flux_matrix * ds.occurrence).sum())
    assert ds.capture_width.values == pytest.approx(width.values, rel=1e-12)


@given(hnp.arrays(float, (3, 2), elements=st.floats(0.1, 10.0)), st.sampled_from([1e-9, 1e-3, 1e6]))
def test_gains_do_not_depend_on_units(power, scale):
    """However small the power; there is no gain over zero."""
    found = gain_percent(scale * power, 1)
    np.testing.assert_allclose(found, gain_percent(power, 1), rtol=1e-9, atol=1e-9)
    assert found[1].tolist() == [0.0, 0.0]
    power[1, 0] = 0.0
    part = gain_percent(scale * power, 1)
    assert np.isnan(part[:, 0]).all()
    np.testing.assert_array_equal(part[:, 1], found[:, 1])
    power[1] = 0.0
    assert gain_percent(scale * power, 1) is None


def test_quadrature_error_is_a_third_of_the_change_with_the_step():
    seas, grid = climate(), np.arange(0.1, 3.0, 0.04)[:71]
    fine, rough = (year({"A": port(one)}, seas, WATER, ["fixed"], {"A": 8e3}) for one in (grid, grid[::2]))
    (error,) = fine.quadrature_error[0]
    assert error == pytest.approx(abs(fine.annual_mean_power - rough.annual_mean_power)[0, 0] / 3, rel=1e-9)
    assert 0 < error < 0.1 * fine.annual_mean_power[0, 0]


def test_usual_practice_is_the_year_of_the_bin_centres():
    seas, grid = climate(), np.arange(0.1, 3.0, 0.02)
    here = port(grid)
    found = year({"A": here}, seas, WATER, ["each", "fixed", "one"], {"A": 5e3})
    bins = found.bins
    there = DesignYear(here, climate_of_cells(*bins.centres, bins.share.ravel()[bins.occupied], 3.3, "centres"))
    dampers = (None, 5e3, found.damping[0, 2, 0])
    for practice, name, damper in zip(found.practice[0], ("each", "fixed", "fixed"), dampers, strict=True):
        assert practice == pytest.approx(float(there.absorbed(name, damper).power @ there.climate.hours), rel=1e-12)
    assert found.practice[0, 0] > found.practice[0, 2] * (1 + 1e-6)


@pytest.mark.parametrize(("low", "high"), [(0.1, 3.0), (0.41, 1.87)])
def test_band_weights_integrate_linear_functions(low, high):
    """Over bands of several widths, clipped to the frequencies of the port."""
    omega = np.array([0.3, 0.4, 0.6, 0.9, 1.0, 1.6, 1.9, 2.2])
    seas = Climate.of_spectra(omega, np.ones((1, 8)), np.ones(1), "flat")
    grid = np.linspace(low, high, 23) ** 1.5 / np.sqrt(high) + low * (1 - np.sqrt(low / high))
    weights = band_weights(grid, seas)
    inside = np.clip(seas.edges, grid[0], grid[-1])
    assert weights.sum(axis=1) == pytest.approx(2 * np.diff(inside), abs=1e-12)
    assert weights @ grid == pytest.approx(np.diff(inside**2), abs=1e-12)
    assert weights.min() >= 0


def test_mean_damper_matrix_of_a_year_counts_hours():
    weak, strong = np.eye(2), np.array([[3.0, 1.0], [1.0, 2.0]])
    found = Absorbed(np.array([weak, strong]), np.array([0, 1, 1]), np.ones(3)).mean_damper(np.array([0.7, 0.2, 0.1]))
    np.testing.assert_allclose(found, 0.7 * weak + 0.3 * strong, rtol=1e-14)


@pytest.mark.parametrize(("spring", "within"), [(0.0, 1e-9), (-6e4, 1e-4)])
def test_rms_force_of_individual_dampers(spring, within):
    """Mean square of c V + k x over the year, each sea at its own damping."""
    seas, grid = climate(), np.arange(0.1, 3.0, 0.02)
    ports = {"A": port(grid), "B": port(grid, mass=9e3)}
    beside = {name: one.beside(spring) for name, one in ports.items()}
    found = year(beside, seas, WATER, ["one", "each"], stiffness=spring)
    for i, here in enumerate(ports.values()):
        each = found.damping[i, 1]
        assert np.ptp(each) > 0.1 * each.mean()
        for j, dampers in enumerate((np.full(len(each), found.damping[i, 0, 0]), each)):
            moved = [
                np.abs(here.force(c, spring)) ** 2 @ band_weights(grid, seas).T @ s / 2
                for c, s in zip(dampers, seas.density, strict=True)
            ]
            assert found.force_rms[i, j] == pytest.approx(np.sqrt(np.dot(moved, seas.hours)), rel=within)


HOME = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def published():
    return json.loads((HOME / "tests" / "data" / "mhkit_performance.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def some(published):
    """The records evaluated with MHKiT."""
    year = read_ndbc(HOME / "config" / "climate" / "ndbc46042_1996_spectra.txt.gz")
    density = year.density[:: published["every"]]
    return Climate.of_spectra(year.omega, density, np.full(len(density), 1 / len(density)), "every 143rd hour")


def test_heights_periods_and_fluxes_agree_with_mhkit(some, published):
    assert some.hs == pytest.approx(published["hm0"], rel=1e-10)
    assert some.te == pytest.approx(published["te"], rel=1e-10)
    assert some.flux(Water()) == pytest.approx(published["flux_deep"], rel=1e-10)
    assert some.flux(Water(depth=published["depth"])) == pytest.approx(published["flux"], rel=1e-10)


def test_bins_are_half_open():
    """A sea on an edge belongs to the bin above it."""
    bins = Bins(np.array([0.5, 0.4999, 1.0]), np.array([7.0, 6.9999, 7.5]), np.full(3, 1 / 3))
    assert np.argwhere(bins.count).tolist() == [[0, 6], [1, 7], [2, 7]]
    assert bins.hs_centres.tolist() == [0.25, 0.75, 1.25]
    assert bins.te_centres[[0, -1]].tolist() == [0.5, 7.5]
    assert [v.tolist() for v in bins.centres] == [[0.25, 0.75, 1.25], [6.5, 7.5, 7.5]]


SPECTRA = Path(__file__).parents[2] / "config" / "climate" / "ndbc46042_1996_spectra.txt.gz"
SEAS = read_ndbc(SPECTRA)


@pytest.fixture(scope="module")
def rigid(seed, spectral_seed):
    """Function scale -> port of the seed's rigid buoy by Froude scaling."""
    motions = design_motions(seed, study_basis(seed), "FSB")
    heave = np.eye(len(motions))[0]

    def of(scale):
        root = np.sqrt(scale)
        first, last = spectral_seed.database.omega.values[[0, -1]]
        omega = frequencies(SEAS, first / root, last / root)
        port = spectral_seed.port(omega * root, motions, heave)
        return Port(omega, port.admittance / scale**2.5, port.velocity / root, port.compliance / scale**2)

    return of


@pytest.fixture(scope="module")
def found(rigid):
    """The year of a buoy three times as large at its optimal damping."""
    return year({"FSB": rigid(3)}, SEAS, Water(), ("one",))


def test_usual_practice_overestimates_the_year(found):
    """Spectra of standard shape at the centres of bins exceed the measured year by 10 to 15 % at this site."""
    assert 10 < 100 * (found.practice / found.annual_mean_power - 1)[0, 0] < 15


def test_product_of_matrices_is_the_hourly_sum(found):
    """The product of capture width and energy flux over the bins (IEC TS 62600-100), within 0.06 %."""
    flux = found.bins.mean(found.flux) * found.bins.share
    product = float(np.sum(found.bins.mean(found.power[0, 0] / found.flux) * flux))
    assert product == pytest.approx(found.annual_mean_power[0, 0], rel=6e-4)


def test_interval_of_mean_power_adds_all_known_errors():
    """Quadrature, coefficients, shell modes left out: of two tunings of one design."""
    slopes = [[[SimpleNamespace(to=lambda _, share=share: share)] for share in (0.01, 0.02)]]
    left_out = LeftOut(np.array([[-0.1, 0.05]]), np.zeros((1, 2)))
    found = within_errors(np.array([[100.0, 50.0]]), np.array([[1.0, 2.0]]), slopes, [None], None, left_out)
    assert found["annual_mean_power_low"][1][0] == pytest.approx([88.0, 42.0])
    assert found["annual_mean_power_high"][1][0] == pytest.approx([107.0, 55.5])


def test_losses_in_conversion_take_their_part_of_every_damper():
    """Each damper stays the best, and its force what it was."""
    grid = np.linspace(0.2, 3.0, 300)
    ports = {"A": port(grid), "B": port(grid, mass=9e3)}
    whole, part = (year(ports, climate(), WATER, dampings={"A": 8e3, "B": 2e4}, efficiency=e) for e in (1.0, 0.8))
    for name, (_, values) in whole.values.items():
        lost = name in ("annual_mean_power", "annual_energy", "practice_power", "quadrature_error") or (
            name.startswith(("power_", "capture_width"))
        )
        np.testing.assert_allclose(part.values[name][1], (0.8 if lost else 1.0) * values, 1e-9, 1e-9, err_msg=name)


CELLS = climate_of_cells(np.array([1.0, 4.0, 6.0]), np.array([9.0, 7.0, 6.5]), np.array([0.5, 0.3, 0.2]), 3.3, "three")


def test_steep_and_breaking_seas_in_deep_water():
    """Steepness Hs over g Te^2/(2 pi): 0.0079, 0.0523, 0.0910."""
    steep, breaking = wave_limits(CELLS, Water())
    assert steep.seas.tolist() == [False, True, True]
    assert breaking.seas.tolist() == [False, False, True]
    assert steep.largest == pytest.approx(6.0 * 2 * np.pi / (9.81 * 6.5**2), rel=1e-9)
    assert breaking.largest == pytest.approx(1.86 * steep.largest / 0.142, rel=1e-9)
    assert steep.energy(np.array([1.0, 10.0, 20.0]), CELLS.hours) == pytest.approx(7.0 / 7.5)
    assert steep.energy(np.zeros(3), CELLS.hours) == 0.0


@pytest.fixture(scope="module")
def shells(seed):
    """The seed's designs and their motions in a year of twelve seas."""
    study = varied(seed, modes={"degree": 2}, pto={"damping": 8e3, "stiffness": 2e4})
    waves = buoy_at(study, reference_shell(study), water(study, omega=np.arange(0.1, 3.0, 0.01))).in_waves()
    return study, waves, climate(seas=12)


def by_the_sea(one, seas, damping, stiffness):
    """Rms heave and largest rms displacement of the shell in each sea at its own damping."""
    omega, found = one.port.omega, []
    for density, c in zip(seas.density, damping, strict=True):
        load = c + 1j * stiffness / omega
        force = load * one.port.velocity / (1 + one.port.admittance * load)
        weights = band_weights(omega, seas).T @ density / 2
        heave = one.motion.heave[0] - force * one.motion.heave[1]
        shell = one.motion.shell[0] - force * one.motion.shell[1]
        squares = (np.abs(shell) ** 2).sum(axis=0) @ weights
        found.append([float(weights @ np.abs(heave) ** 2), float(squares.max())])
    return np.sqrt(np.array(found).T)


def test_motions_under_individual_dampers_equal_a_loop_over_seas(shells):
    study, waves, seas = shells
    each = year({d: w.port.beside(2e4) for d, w in waves.items()}, seas, study.water, ("each",))
    for i, (design, one) in enumerate(waves.items()):
        heave, deformation = by_the_sea(one, seas, each.damping[i, 0], 2e4)
        found = motion_rms(one, seas, each.damping[i, 0], np.arange(12), 2e4)
        np.testing.assert_allclose(found["heave"], heave, rtol=2e-3, err_msg=design)
        np.testing.assert_allclose(found["deformation"], deformation, rtol=2e-3, err_msg=design)
        assert (deformation.max() > 0) == study.designs[design].flexible
        same = motion_rms(one, seas, np.full(1, 3e3), np.zeros(12, dtype=int), 2e4)
        for name, expected in zip(same, by_the_sea(one, seas, np.full(12, 3e3), 2e4), strict=True):
            np.testing.assert_allclose(same[name], expected, rtol=1e-12, err_msg=f"{design} {name}")


def test_seas_beyond_validity_are_marked_in_their_bins(shells):
    """For a radius small enough that some seas deform the shell too much."""
    study, waves, seas = shells
    found = year({d: w.port.beside(2e4) for d, w in waves.items()}, seas, study.water, ("one",))
    radius = float(np.median(by_the_sea(waves["VSWEC"], seas, found.damping[1, 0], 2e4)[1])) * 3.72 / 0.1
    rms = {
        name: motion_rms(one, seas, found.damping[i, 0], np.arange(12), 2e4)
        for i, (name, one) in enumerate(waves.items())
    }
    ds = xr.Dataset(beyond_validity(found, lambda design, _: rms[design], radius))
    steep, breaking = wave_limits(seas, study.water)
    for i, design in enumerate(waves):
        heave, deformation = by_the_sea(waves[design], seas, found.damping[i, 0], 2e4) * 3.72 / radius
        each = {"steepness": steep.seas, "breaking": breaking.seas, "deformation": deformation > 0.1}
        marked = np.any(list(each.values()), axis=0)
        taken = found.power[i, 0] * seas.hours
        for name, which in {**each, "heave": heave > 0.3}.items():
            share = float(taken[which].sum() / taken.sum())
            assert float(ds.energy_beyond[i, 0].isel(limit=LIMITS.index(name))) == pytest.approx(share), (design, name)
        assert float(ds.energy_beyond_validity[i, 0]) == pytest.approx(float(taken[marked].sum() / taken.sum()))
        for bin_ in found.bins.occupied:
            inside = found.bins.index == bin_
            share = float(seas.hours[inside & marked].sum() / seas.hours[inside].sum())
            assert ds.beyond_validity[i, 0].values.ravel()[bin_] == pytest.approx(share)
    assert 0 < float(ds.energy_beyond_validity[1, 0]) < 1
    assert not ds.beyond_validity.values[..., found.bins.count == 0].any()


def test_wave_limits_depend_on_gravity_and_depth():
    for sea_water in (Water(gravity=3.7), Water(gravity=3.7, depth=8.0), Water(density=900.0)):
        numbers = np.array([wavenumber(2 * np.pi / te, sea_water.depth, sea_water.gravity) for te in CELLS.te])
        steep, breaking = wave_limits(CELLS, sea_water)
        assert steep.largest == pytest.approx((CELLS.hs * numbers).max() / (2 * np.pi), rel=1e-12)
        broken = 1.86 * CELLS.hs * numbers / (2 * np.pi * 0.142 * np.tanh(numbers * min(sea_water.depth, 1e3)))
        assert breaking.largest == pytest.approx(broken.max(), rel=1e-9)
        assert breaking.seas.tolist() == (broken > 1.0).tolist()
