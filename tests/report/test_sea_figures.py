"""Figures of seas: what they show is the energy that is there."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb
from report.test_figures import data

from vsb.report.sea_figures import spectra, year_spectra
from vsb.report.svg import in_words
from vsb.waves.climate import Climate, band_edges
from vsb.waves.seas import jonswap_spectrum

OMEGA = np.geomspace(0.2, 8.0, 400)
SEAS = {"calm": (0.5, 4.0), "storm": (3.0, 10.0)}


def year(hours):
    """A year of two seas, the first for a share of it."""
    omega = np.linspace(0.1, 6.0, 300)
    density = np.array([jonswap_spectrum(omega, hs, tp, 3.3) for hs, tp in SEAS.values()])
    return Climate.of_spectra(omega, density, np.array([hours, 1 - hours]), "made up")


def named(ax):
    return {line.get_label(): line for line in ax.get_lines()}


def test_every_sea_has_a_curve_whose_area_is_its_energy():
    density = [jonswap_spectrum(OMEGA, hs, tp, 3.3) for hs, tp in SEAS.values()]
    found = xr.DataArray(density, {"sea": list(SEAS), "omega": OMEGA})
    figure = spectra(data(spectra=found))
    ax = figure.axes[0]
    curves = named(ax)
    for name, (hs, _) in SEAS.items():
        m0 = np.trapezoid(curves[name].get_ydata(), curves[name].get_xdata())
        assert 4 * np.sqrt(m0) == pytest.approx(hs, rel=5e-3)
    low, high = ax.get_xlim()
    assert low < 2 * np.pi / 10 < 2 * np.pi / 4 < high < 6
    assert ax.get_ylabel().endswith("[m² s/rad]")
    assert all(name in in_words(figure) for name in SEAS)


@pytest.mark.parametrize(("hours", "median"), [(0.7, "calm"), (0.3, "storm")])
def test_a_years_median_is_the_sea_of_half_the_year_and_its_mean_holds_its_energy(hours, median):
    climate = year(hours)
    curves = named(year_spectra(climate).axes[0])
    row = list(SEAS).index(median)
    peak = climate.density[1].argmax()  # where the storm is above the calm
    assert curves["median"].get_ydata()[peak] == pytest.approx(climate.density[row, peak])
    widths = np.diff(band_edges(climate.omega))
    mean = curves["mean of the year"].get_ydata() @ widths
    assert mean == pytest.approx(climate.hours @ climate.variance)
    below, above = (curves[f"{share} % of the year below"].get_ydata() for share in (10, 90))
    assert np.all(below <= above)
    assert below[peak] == pytest.approx(climate.density[0, peak])
    assert above[peak] == pytest.approx(climate.density[1, peak])


@pytest.mark.parametrize(("peak", "width", "first"), [(2.0, 0.2, 1.36), (0.5, 0.2, 0.0)])
def test_the_axis_begins_a_little_below_the_first_wave_seen_and_at_none_below_zero(peak, width, first):
    """A Gaussian is seen to sqrt(2 ln 100) = 3.03 of its widths; beyond zero there is no frequency."""
    omega = np.linspace(0.001, 6.0, 3000)
    climate = Climate.of_spectra(omega, np.exp(-(((omega - peak) / width) ** 2) / 2)[None], np.ones(1), "made up")
    low, high = year_spectra(climate).axes[0].get_xlim()
    assert low == pytest.approx(first, abs=0.01)
    assert high == pytest.approx(
        peak + 3.035 * width + 0.03 * (peak + 3.035 * width - max(peak - 3.035 * width, 0.0)), abs=0.01
    )


def test_seas_are_told_apart_and_seen_on_white():
    """However many: each has a colour of its own, half as bright as paper at most, and one of four kinds of lines."""
    names = [f"sea {i}" for i in range(7)]
    density = [jonswap_spectrum(OMEGA, 1.0 + i, 4.0, 3.3) for i in range(7)]
    curves = named(spectra(data(spectra=xr.DataArray(density, {"sea": names, "omega": OMEGA}))).axes[0])
    colours = np.array([to_rgb(curves[name].get_color()) for name in names])
    assert len(set(map(tuple, colours))) == 7
    assert (colours @ [0.299, 0.587, 0.114]).max() < 0.75
    assert {curves[name].get_linestyle() for name in names} == {"-", "--", "-.", ":"}


@pytest.mark.parametrize("tp", [2.5, 4.0, 8.0, 16.0])
def test_every_axis_of_frequencies_has_several_periods_above_it(tp):
    omega = np.linspace(0.05, 12.0, 2000)
    density = jonswap_spectrum(omega, 1.0, tp, 3.3)[None]
    ax = year_spectra(Climate.of_spectra(omega, density, np.ones(1), "made up")).axes[0]
    low, high = ax.get_xlim()
    (periods,) = ax.child_axes
    assert np.sum((2 * np.pi / high < periods.get_xticks()) & (periods.get_xticks() < 2 * np.pi / low)) >= 3


def test_a_calm_sea_beside_a_storm_is_seen_by_its_own_peak():
    """Its highest density is less than a hundredth of the storm's, at waves a fifth as long."""
    density = [jonswap_spectrum(OMEGA, 0.1, 2.0, 3.3), jonswap_spectrum(OMEGA, 6.0, 10.0, 3.3)]
    assert density[0].max() < 0.001 * density[1].max()
    for rows in (density, density[::-1]):
        found = xr.DataArray(rows, {"sea": ["one", "other"], "omega": OMEGA})
        low, high = spectra(data(spectra=found)).axes[0].get_xlim()
        assert low < 2 * np.pi / 10 < 2 * np.pi / 2 < high


def test_what_lies_between_a_tenth_and_nine_tenths_of_the_year_is_shaded():
    """Below it a dotted line, above it a full one."""
    climate = year(0.7)
    ax = year_spectra(climate).axes[0]
    curves = named(ax)
    below, above = (curves[f"{share} % of the year below"] for share in (10, 90))
    assert (below.get_linestyle(), above.get_linestyle(), curves["median"].get_linestyle()) == (":", "-", "--")
    edge = {tuple(point) for path in ax.collections[0].get_paths() for point in path.vertices}
    for share in (0.1, 0.9):
        assert set(zip(climate.omega, climate.quantile(share), strict=True)) <= edge
    assert ax.get_ylim()[0] == 0.0
