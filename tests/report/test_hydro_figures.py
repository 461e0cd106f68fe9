"""Figures of seas and of hydrodynamic coefficients."""

import numpy as np
import pytest
import xarray as xr
from report.test_figures import data

from vsb.engine.waves.climate import Climate, band_edges
from vsb.engine.waves.kinds import jonswap_spectrum
from vsb.report.canvas import StudyData, in_words
from vsb.report.hydro_figures import spectra, witness, year_spectra

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


SHAPES = ["mean", "Membrane0_minus", "Membrane0_plus"]
KINDS = ["added_mass", "radiation_damping", "excitation_force"]


def crosschecked(derived):
    rng = np.random.default_rng(0)
    dims, pair = ("omega", "shape", "coefficient"), ("influenced_dof", "radiating_dof")
    variables = {
        "witness_difference": (dims, rng.uniform(1e-4, 1e-3, (3, 3, 3))),
        "witness_estimate": (("solver", "shape", "coefficient"), np.full((2, 3, 3), 2e-3)),
        **{f"shape_{k}": (("solver", "shape", "omega", *pair), rng.uniform(1, 2, (2, 3, 3, 2, 2))) for k in KINDS[:2]},
    }
    coords = {"omega": [1.0, 2.0, 3.0], "shape": SHAPES, "coefficient": KINDS, "solver": ["panels", "spectral"]}
    if derived:
        variables["slope_difference"] = (("omega", "shape_dof", "coefficient"), rng.uniform(1e-3, 1e-2, (3, 1, 3)))
        variables["slope_estimate"] = (("shape_dof", "coefficient"), np.full((1, 3), 2e-2))
        coords["shape_dof"] = ["Membrane0"]
    empty, ds = xr.Dataset(), xr.Dataset(variables, coords)
    return StudyData(("FSB",), "FSB", (), {}, (0.0, 1.0), empty, empty, empty, empty, {}, ds)


@pytest.mark.parametrize("derived", [False, True])
def test_markers_are_the_largest_differences_and_the_sum_of_error_estimates(derived):
    shown = crosschecked(derived)
    figure = witness(shown)
    assert len(figure.axes) == 2 + derived
    top = figure.axes[0]
    for estimate, line, kind in zip(top.lines[::2], top.lines[1::2], KINDS, strict=True):
        expected = shown.witness.witness_difference.sel(coefficient=kind).max("omega")
        np.testing.assert_array_equal(line.get_ydata(), expected.values)
        np.testing.assert_allclose(estimate.get_ydata(), 4e-3)
    assert figure.axes[1] in top.get_shared_x_axes().get_siblings(top)
    assert [label.get_text() for label in figure.axes[1].get_xticklabels()] == [
        "mean",
        "Membrane0 \N{MINUS SIGN}",
        "Membrane0 +",
    ]
