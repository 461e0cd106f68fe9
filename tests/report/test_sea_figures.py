"""Figures of seas show the energy of their spectra."""

import numpy as np
import pytest
import xarray as xr
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


def test_area_under_a_spectrum_is_its_energy():
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
def test_median_mean_and_quantiles_of_a_year(hours, median):
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
