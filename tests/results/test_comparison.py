import csv
import io

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.results import comparison as compare
from vsb.results.comparison import as_csv, gains
from vsb.results.power import energy_flux
from vsb.scenes.build import TUNED
from vsb.waves.seas import NO_WAVES, sea

CONTRACT = "design,wave,displacement_pp,velocity_pp,power_peak,power_mean,energy,capture_width,energy_gain_percent,energy_residual,damping,stiffness,power_gain_percent,low,high"


def test_table_has_the_promised_columns_and_no_nan():
    row = dict.fromkeys(compare.COLUMNS, 1.0) | {"design": "A", "wave": "w", "capture_width": None}
    text = as_csv([row])
    assert text.splitlines()[0] == CONTRACT
    (back,) = csv.DictReader(io.StringIO(text))
    assert back["capture_width"] == ""
    assert back["energy"] == "1"


def still_run(energy, residual):
    """A buoy at rest whose take-off is said to have absorbed some energy [J]."""
    time = np.linspace(0.0, 60.0, 601)
    motion = {name: (("time", "dof"), np.zeros((len(time), 1))) for name in ("position", "velocity")}
    absorbed = (("time", "term"), energy * (time / time[-1])[:, None])
    coords = {"time": time, "dof": ["Heave"], "term": ["pto"]}
    return xr.Dataset(motion | {"energy": absorbed}, coords, {"energy_residual": residual})


@pytest.mark.parametrize(("rigid", "gain"), [(1e3, 50.0), (1e-7, None), (0.0, None)])
def test_each_row_is_of_its_own_run_and_no_gain_is_over_round_off(seed, rigid, gain):
    """1500 J against 1000 J; a rigid buoy at rest absorbs nothing gains could be measured against."""
    designs = {"R": {"flexible": False}, "S": {"flexible": True}}
    two = varied(seed, designs=designs, waves=[{"kind": "still"}], published=None)
    runs = {"R": still_run(rigid, 1e-7), "S": still_run(1.5e3, 3e-6)}
    rows = compare.comparison(two, two.waves[0], runs, NO_WAVES)
    assert [row["design"] for row in rows] == ["R", "S"]
    assert [row["energy_residual"] for row in rows] == [1e-7, 3e-6]
    assert [row["energy"] for row in rows] == pytest.approx([rigid, 1.5e3])
    assert rows[1]["energy_gain_percent"] == (pytest.approx(gain) if gain else None)
    assert rows[1]["power_gain_percent"] is None  # no mean power to gain


def test_a_gain_of_mean_power_is_over_whole_periods_and_of_energy_over_the_whole_run(seed):
    """A rigid buoy that takes 10 W throughout; the other one 20 W, but nothing before the window."""
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


def test_a_gain_is_over_the_reference_and_over_nothing_there_is_none():
    assert compare.gains({"FSB": 200.0, "A": 220.0}, "FSB") == {"FSB": 0.0, "A": pytest.approx(10.0)}
    assert compare.gains({"FSB": 1e-8, "A": 220.0}, "FSB") == {"FSB": None, "A": None}
    assert compare.gains({"A": 220.0}, None) == {"A": None}


@pytest.mark.parametrize(("base", "known"), [(0.9e-6, False), (1.1e-6, True), (-1.0, False)])
def test_no_gain_is_over_round_off(base, known):
    """A thousand millionth of what the best design takes."""
    found = gains({"FSB": base, "VSWEC": 1e3}, "FSB")
    assert (found["VSWEC"] is not None) == known
    assert not known or found["FSB"] == 0.0


def test_each_row_has_the_damper_its_run_was_tuned_to_and_the_capture_width_of_its_own_water(seed):
    """Over 3 m of water the same power is of less energy flux than over none below."""
    designs, widths = {"R": {"flexible": False}, "S": {"flexible": True}}, []
    for depth in (np.inf, 3.0):
        two = varied(seed, designs=designs, water={"depth": depth})
        (wave,) = two.waves
        runs = {"R": still_run(600.0, 0.0), "S": still_run(1200.0, 0.0).assign_attrs({TUNED: 777.0})}
        waves = sea(wave, 12.0, 60.0)
        rows = compare.comparison(two, wave, runs, waves)
        assert [row["damping"] for row in rows] == [two.pto.damper("R"), 777.0]
        assert [row["capture_width"] for row in rows] == pytest.approx(
            np.array([10.0, 20.0]) / energy_flux(waves, two.water), rel=1e-9
        )
        widths.append(rows[0]["capture_width"])
    assert abs(widths[1] / widths[0] - 1) > 0.01


def test_a_row_tells_what_its_take_off_is_and_what_its_design_gains_wherever_the_rigid_one_stands(seed):
    """The second of two: a damper of each design's own, the spring of all."""
    designs = {"S": {"flexible": True}, "R": {"flexible": False}}
    two = varied(seed, designs=designs, pto={"damping": {"S": 7e3, "R": 9e3}, "stiffness": 500.0})
    (wave,) = two.waves
    runs = {"S": still_run(900.0, 1e-8), "R": still_run(600.0, 2e-8)}
    first, second = compare.comparison(two, wave, runs, sea(wave, 12.0, 60.0))
    for row, design, damper, gain in ((first, "S", 7e3, 50.0), (second, "R", 9e3, 0.0)):
        assert (row["design"], row["wave"]) == (design, wave.label)
        assert (row["damping"], row["stiffness"]) == (damper, 500.0)
        assert (row["power_gain_percent"], row["energy_gain_percent"]) == pytest.approx((gain, gain), abs=1e-6)
        assert row["power_mean"] == pytest.approx(row["energy"] / 60.0, rel=1e-9)
