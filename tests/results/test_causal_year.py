"""A year under causal control: order of tunings, one sea's level, a schedule that is linear in the spectra."""

from dataclasses import replace

import numpy as np
import pytest
from models.test_stationary import example  # noqa: F401

from vsb.engine.waves.scatter import climate_of_cells
from vsb.results.causal_year import causal_years
from vsb.results.year import DesignYear, bins_of, frequencies


@pytest.fixture(scope="module")
def climate():
    """Three seas, two of them in one bin."""
    cells = np.array([1.0, 1.1, 1.6]), np.array([3.4, 3.9, 4.4])
    return climate_of_cells(*cells, np.array([0.5, 0.3, 0.2]), 3.3, "three seas")


@pytest.mark.parametrize("limit", [1e3, np.inf])
def test_year_lies_between_dampers_and_the_matched_force(example, climate, limit):  # noqa: F811
    study, floating = example
    water = {"water_depth": np.inf, "water_density": 1025.0, "gravity": 9.81}
    checked = floating.linear.database.assign_attrs(quality="[]", **water)
    floating = replace(floating, linear=replace(floating.linear, database=checked))
    limited = study.model_copy(update={"pto": type(study.pto)(force_limit=limit)})
    whole = causal_years(limited, floating, climate)
    dampers, found = ({name: np.asarray(values)[:, i] for name, (_, values) in whole.items()} for i in (0, 1))
    assert (dampers["annual_mean_power"] < found["annual_mean_power"]).all()
    power, bins = found["annual_mean_power"], bins_of(climate)
    omega = frequencies(climate, *floating.band)
    for i, one in enumerate(floating.at(omega).in_waves().values()):
        year = DesignYear(one.port, climate)
        matched = float(year.squares @ one.port.matched_power)
        free = np.sqrt(0.5 * bins.mean_densities(climate) @ year.weights @ np.abs(one.port.velocity) ** 2)
        if limit == 1e3:
            assert 0.8 < power[i] / (1e3 * float(bins.share[bins.share > 0] @ free)) < 1.0
            assert found["force_rms"][i] == pytest.approx(1e3, rel=1e-5)
        else:
            best = float(year.absorbed("each", None).power @ climate.hours)
            assert 1.1 * best < power[i] < matched
            assert dampers["annual_mean_power"][i] == pytest.approx(best, rel=1e-2)  # of each bin, not of each sea
        assert found["annual_mean_power_low"][i] < power[i] < found["annual_mean_power_high"][i]
        assert (bins.share * found["power_matrix"][i]).sum() == pytest.approx(power[i])
    assert 0.0 < found["gain_percent"][1] < 5.0 if limit == 1e3 else found["gain_percent"][0] == 0.0
    assert all(np.isfinite(values).all() for values in found.values())
