"""Table of designs: columns and gains."""

import csv
import io

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.results import comparison as compare
from vsb.results.comparison import as_csv
from vsb.waves.seas import NO_WAVES, sea

CONTRACT = "design,wave,displacement_pp,velocity_pp,power_peak,power_mean,energy,capture_width,energy_gain_percent,energy_residual,damping,stiffness,power_gain_percent,low,high"


def test_table_has_the_documented_columns():
    row = dict.fromkeys(compare.COLUMNS, 1.0) | {"design": "A", "wave": "w", "capture_width": None}
    text = as_csv([row])
    assert text.splitlines()[0] == CONTRACT
    (back,) = csv.DictReader(io.StringIO(text))
    assert back["capture_width"] == ""
    assert back["energy"] == "1"


def still_run(energy, residual):
    """A buoy at rest with a given absorbed energy [J]."""
    time = np.linspace(0.0, 60.0, 601)
    motion = {name: (("time", "dof"), np.zeros((len(time), 1))) for name in ("position", "velocity")}
    absorbed = (("time", "term"), energy * (time / time[-1])[:, None])
    coords = {"time": time, "dof": ["Heave"], "term": ["pto"]}
    return xr.Dataset(motion | {"energy": absorbed}, coords, {"energy_residual": residual})


@pytest.mark.parametrize(("rigid", "gain"), [(1e3, 50.0), (1e-7, None), (0.0, None)])
def test_no_gain_over_a_reference_that_absorbs_nothing(seed, rigid, gain):
    designs = {"R": {"flexible": False}, "S": {"flexible": True}}
    two = varied(seed, designs=designs, waves=[{"kind": "still"}], published=None)
    runs = {"R": still_run(rigid, 1e-7), "S": still_run(1.5e3, 3e-6)}
    rows = compare.comparison(two, two.waves[0], runs, NO_WAVES)
    assert [row["design"] for row in rows] == ["R", "S"]
    assert [row["energy_residual"] for row in rows] == [1e-7, 3e-6]
    assert [row["energy"] for row in rows] == pytest.approx([rigid, 1.5e3])
    assert rows[1]["energy_gain_percent"] == (pytest.approx(gain) if gain else None)
    assert rows[1]["power_gain_percent"] is None  # no mean power to gain


def test_power_gain_is_of_the_window_and_energy_gain_of_the_run(seed):
    """The rigid buoy absorbs 10 W throughout; the other one 20 W, but nothing before the window."""
    designs = {"R": {"flexible": False}, "S": {"flexible": True}}
    two = varied(seed, designs=designs, pto={"damping": 8000.0, "stiffness": 500.0})
    time, (wave,) = np.linspace(0.0, 60.0, 601), two.waves
    runs = {name: still_run(600.0, 0.0) for name in designs}
    runs["S"]["energy"] = (("time", "term"), 20.0 * np.maximum(time - 40.0, 0.0)[:, None])
    rigid, shell = compare.comparison(two, wave, runs, sea(wave, 12.0, 60.0))
    assert (rigid["power_gain_percent"], rigid["energy_gain_percent"]) == (0.0, 0.0)
    assert shell["power_gain_percent"] == pytest.approx(100.0, rel=1e-3)
    assert shell["energy_gain_percent"] == pytest.approx(-100 / 3, rel=1e-9)
    assert (shell["damping"], shell["stiffness"]) == (8000.0, 500.0)
