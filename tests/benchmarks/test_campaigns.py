"""Campaigns against plain loops: the same numbers, to round-off."""

import csv

import numpy as np
import pytest
from results.test_year import climate, port
from stages.test_members import THICKER, planned, with_seas

from benchmarks import campaigns
from vsb.errors import ConfigError


@pytest.mark.parametrize("step", [0.02, 0.3])
def test_a_year_is_what_a_loop_over_its_hours_says(step):
    """Frequencies that are finer than the bands, and coarser."""
    ports = [port(np.arange(0.1, 3.0, step), mass=mass) for mass in (9e3, 17e3)]
    tried = np.geomspace(1e3, 1e6, 7)
    found, expected = (way(ports, climate(), tried) for way in (campaigns.at_once, campaigns.by_hours))
    assert found == pytest.approx(expected, rel=1e-12)


def test_the_table_has_seconds_of_both_ways_and_their_difference(tmp_path, monkeypatch):
    monkeypatch.setattr(campaigns, "SEAS", 1)
    monkeypatch.setattr(campaigns, "VERIFIED", 4)
    short = {"duration": 4.0, "window": [2.0, 4.0]}
    planned(with_seas(tmp_path, (1.0, 6.0), (2.3, 9.5)), THICKER, simulation=short)
    rows = campaigns.benchmark(str(tmp_path / "sweep.yaml"), tmp_path / "out", dampers=3, count=2)
    assert [row["cells"] for row in rows] == [2 * 3, 2 * 2, 2, 2, 1, 2 * 3 + 4]
    of_interpolation = {"sweep, each member a study": 1e-8}
    assert all(row["error"] < of_interpolation.get(row["case"], 1e-12) and row["seconds"] > 0 for row in rows)
    written = list(csv.DictReader((tmp_path / "out" / "campaigns.csv").read_text().splitlines()))
    assert [row["case"] for row in written] == [row["case"] for row in rows]
    with pytest.raises(ConfigError, match="received a study, needs a campaign such as"):
        campaigns.benchmark(str(tmp_path / "sweep_study.yaml"), tmp_path / "out")
