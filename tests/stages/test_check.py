"""Command check on every kind of file: what it prints of seas and climates, and that it leaves nothing behind."""

import shutil

import pytest
from conftest import EXAMPLE, varied

from vsb.cli import main
from vsb.pipeline.graph import StudyPlan
from vsb.pipeline.plans import plan_of
from vsb.stages.check import sea_lines
from vsb.stages.climate import read_climate


@pytest.mark.parametrize("name", ["buoy", "float", "float_year"])
def test_check_leaves_no_file(name, tmp_path, monkeypatch, capsys):
    """Not even the number of shell modes it looked for, or an empty folder of results."""
    shutil.copytree(EXAMPLE.parent, tmp_path / "config")
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    monkeypatch.chdir(tmp_path)
    assert main(["check", f"config/{name}.yaml"]) == 0
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == before
    assert "\nsea" in capsys.readouterr().out


def test_check_prints_height_period_and_flux_of_every_sea(seed):
    """One line for all realisations of a sea, none for still water; deep water: rho g^2 Hs^2 Te/(64 pi)."""
    gusts = [{"kind": "pierson_moskowitz", "hs": 2.0, "tp": 8.0, "seed": seed} for seed in (1, 2)]
    wave = {"kind": "regular", "amplitude": 0.5, "period": 6.0}
    study = varied(seed, waves=[{"kind": "still"}, *gusts, wave])
    flux = 1025 * 9.81**2 / (64 * 3.14159265) * 2.0**2 * (te := 0.8572 * 8.0)  # Te/Tp of Pierson and Moskowitz
    assert sea_lines(StudyPlan(study)) == [
        f"sea          pierson_moskowitz_Hs2_Tp8: Hs 2 m, Te {te:.3g} s, {flux / 1000:.3g} kW/m",
        f"sea          regular_A0.5_T6: height 1 m, period 6 s, {1025 * 9.81**2 * 6 / (32 * 3.14159265) / 1000:.3g} kW/m",
    ]
    assumed = varied(study, waves=[wave], hydro={"model": "assumed_pressure", "pressure": 1800.0})
    assert sea_lines(StudyPlan(assumed)) == []  # its amplitude is not used


def test_check_prints_the_means_of_a_climate():
    """Weighted by the share of the year of each sea; the flux is that of the mean spectrum, for it is linear."""
    plan = plan_of(str(EXAMPLE.with_name("float_year.yaml")))
    seas, water = read_climate(plan.climate, plan.loaded.climate_path), plan.loaded.base.water
    (line,) = sea_lines(plan)
    hs, te, flux = (sum(seas.hours * one) for one in (seas.hs, seas.te, seas.flux(water)))
    assert line.endswith(f": mean Hs {hs:.3g} m, mean Te {te:.3g} s, {flux / 1000:.3g} kW/m")
