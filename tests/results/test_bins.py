"""Matrices of IEC TS 62600-100 against MHKiT."""

import json
from pathlib import Path

import numpy as np
import pytest

from vsb.results.bins import Bins
from vsb.study.study import Water
from vsb.waves.climate import YEAR_HOURS, Climate
from vsb.waves.ndbc import read_ndbc

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


def test_matrices_agree_with_mhkit(some, published):
    bins, flux = Bins(some.hs, some.te, some.hours), some.flux(Water(depth=published["depth"]))
    width = np.array(published["power"]) / flux
    row, column, mean, deviation, count, mean_flux = np.array(published["matrices"]).T
    at = row.astype(int), column.astype(int)
    assert bins.count[at].tolist() == count.tolist()
    assert bins.count.sum() == count.sum() == len(width)
    assert bins.mean(width)[at] == pytest.approx(mean, rel=1e-10)
    assert bins.deviation(width)[at] == pytest.approx(deviation, rel=1e-10, abs=1e-10)
    assert bins.mean(flux)[at] == pytest.approx(mean_flux, rel=1e-10)
    energy = YEAR_HOURS * float(np.sum(bins.mean(width) * bins.mean(flux) * bins.share))
    assert energy == pytest.approx(published["maep_Wh"], rel=1e-10)


def test_bins_are_half_open():
    """A sea on an edge belongs to the bin above it."""
    bins = Bins(np.array([0.5, 0.4999, 1.0]), np.array([7.0, 6.9999, 7.5]), np.full(3, 1 / 3))
    assert np.argwhere(bins.count).tolist() == [[0, 6], [1, 7], [2, 7]]
    assert bins.hs_centres.tolist() == [0.25, 0.75, 1.25]
    assert bins.te_centres[[0, -1]].tolist() == [0.5, 7.5]
    assert [v.tolist() for v in bins.centres] == [[0.25, 0.75, 1.25], [6.5, 7.5, 7.5]]


def test_means_and_deviations_are_weighted_by_hours():
    bins = Bins(np.array([0.1, 0.2]), np.array([0.1, 0.2]), np.array([0.25, 0.75]))
    assert bins.mean(np.array([4.0, 8.0])) == pytest.approx(7.0)
    assert bins.deviation(np.array([4.0, 8.0])) == pytest.approx(np.sqrt(3.0))
