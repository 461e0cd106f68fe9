"""Command check on every kind of file, and what is checked of studies and campaigns before anything is solved."""

import gzip
import hashlib
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from conftest import EXAMPLE, varied
from stages.test_members import BASE, planned, with_seas

from vsb.cli import main
from vsb.engine.shell.modes import mode_basis
from vsb.engine.shell.shell import Shell, natural_frequencies
from vsb.errors import ConfigError, DatabaseError
from vsb.pipeline.graph import StudyPlan
from vsb.pipeline.plans import plan_of
from vsb.stages import preview
from vsb.stages.campaign_preview import check, summary
from vsb.stages.check import read_climate, sea_lines
from vsb.study.campaign import Scatter, Spectra
from vsb.tools.packed import SUFFIX, Pack


@pytest.mark.parametrize("name", ["buoy", "float", "float_year"])
def test_check_leaves_no_file(name, tmp_path, monkeypatch, capsys):
    """Not even the number of shell modes it looked for, or an empty folder of results."""
    shutil.copytree(EXAMPLE.parent, tmp_path / "config")
    study = tmp_path / "config" / f"{name}.yaml"
    study.write_text(re.sub(r"omega: \[.*\]", "omega: [0.4, 0.8, 1.2, 2.0]", study.read_text()))
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")}
    monkeypatch.chdir(tmp_path)
    assert main(["check", f"config/{name}.yaml"]) == 0
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*")} == before
    out = capsys.readouterr().out
    assert "\nsea" in out
    assert ("solved of the mesh" in out) == (name == "float")


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


def test_check_says_that_rigid_designs_alone_know_no_rest_shape(seed):
    """Which is 3.6 % of the power of the example in waves of 4 s."""
    study = seed.model_copy(update={"reference_shape": "equilibrium", "designs": {"FSB": seed.designs["FSB"]}})
    assert sum("reference_shape: without a flexible design" in line for line in preview.summary(StudyPlan(study))) == 1


def test_check_prints_the_means_of_a_climate():
    """Weighted by the share of the year of each sea; the flux is that of the mean spectrum, for it is linear."""
    plan = plan_of(str(EXAMPLE.with_name("float_year.yaml")))
    seas, water = read_climate(plan.climate, plan.loaded.climate_path), plan.loaded.base.water
    (line,) = sea_lines(plan)
    hs, te, flux = (sum(seas.hours * one) for one in (seas.hs, seas.te, seas.flux(water)))
    assert line.endswith(f": mean Hs {hs:.3g} m, mean Te {te:.3g} s, {flux / 1000:.3g} kW/m")


def test_check_counts_finished_work(small, tmp_path, monkeypatch):
    there = preview.summary(small)
    monkeypatch.chdir(tmp_path)
    before = preview.summary(small)
    blocks = len(small.bem_blocks)
    assert any(f"to solve     {blocks} of {blocks} blocks" in line for line in before)
    assert any(f"to solve     0 of {blocks} blocks" in line for line in there)
    assert any(line.endswith("(there)") for line in there)
    assert not any(line.endswith("(there)") for line in before)
    assert any("cross-check  none: hydro.witness: none" in line for line in there)
    assert there[0].startswith("study        small: FSB, VSWEC in ")


def test_unreadable_stored_files_are_reported_before_any_job(small, finished, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(finished / "results", "results")
    preview.check(small)
    for path in (small.radiation.out, small.block_path(small.sweep_blocks[0]), small.database.out):
        Path(path).write_bytes(b"none")
        with pytest.raises(DatabaseError, match=f"{path}: cannot be read as netCDF"):
            preview.check(small)


def test_natural_frequencies_are_those_of_the_closed_form(seed):
    """Membrane modes of every degree, bending modes from degree 2; membrane frequencies are higher."""
    study = varied(seed, modes={"degree": 4})
    shell, table = Shell.of(study.device), preview.shell_table(study)
    lower, upper = np.transpose([natural_frequencies(shell, n) for n in range(5)])
    assert [row["degree"] for row in table["membrane"]] == [0, 1, 2, 3, 4]
    assert [row["omega"] for row in table["membrane"]] == upper.tolist()
    assert [(row["degree"], row["omega"]) for row in table["bending"]] == [(n, lower[n]) for n in (2, 3, 4)]
    assert [row["omega"] for row in table["paper_ritz"]] == mode_basis(
        study.device, "paper", 4
    ).dry_frequencies.tolist()
    third = preview.shell_text(table).splitlines()[3].split()
    assert third == ["2", f"{upper[2]:.9f}", f"{lower[2]:.9f}", f"{table['paper_ritz'][2]['omega']:.9f}"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return with_seas(tmp_path_factory.mktemp("campaign"), (1.0, 6.0), (2.2, 9.0), (2.3, 9.5), (3.1, 12.0))


def test_clamps_that_leave_no_free_mode_are_refused(folder):
    """Two clamps hold both modes of degree 1; modes of higher degrees leave some free."""
    designs = {"FSB": {"flexible": False}, "HELD": {"clamp": [0, 90]}}
    modes = {"basis": "membrane", "degree": 1}
    message = r"few.yaml: vary: with modes.degree: 1.0: designs.HELD.clamp: received \[0.0, 90.0\], which leaves none"
    with pytest.raises(ConfigError, match=message):
        check(planned(folder, {"modes.degree": [4, 1]}, name="few", designs=designs, modes=modes))
    check(planned(folder, {"modes.degree": [4, 5]}, name="some", designs=designs, modes=modes))


@pytest.mark.parametrize(
    ("varied", "message"),
    [
        (
            {"hydro.omega_max": [5.0, 2.5]},
            r"hydro\.omega_max: received 2.5 rad/s, needs at least .* rad/s, because the radiation memory",
        ),
        (
            {"hydro.omega_max": [5.0, 50.0]},
            r"hydro\.omega_max: received 50 rad/s, needs at most 14\.\d+ rad/s with the spec",
        ),
    ],
)
def test_points_with_an_unsolvable_band_are_refused(folder, monkeypatch, varied, message):
    """The first point can be solved, the last cannot."""
    monkeypatch.chdir(folder)
    with pytest.raises(ConfigError, match=message):
        check(planned(folder, varied, name="band"))


def test_check_counts_points_batches_and_shapes(folder, monkeypatch):
    """Elastic moduli and densities share the hydrodynamics."""
    monkeypatch.chdir(folder)
    plan = planned(folder, {"device.young_modulus": [1e6, 1e7], "device.density": [2e3, 2.5e3]}, name="counted")
    assert summary(plan)[-1].startswith("fail         buckling = ")
    assert summary(plan)[:3] == [
        "campaign     counted: counted_study.yaml over 4 seas, tuning fixed, one, each",
        "points       4 of device.young_modulus x device.density, 0 done",
        "jobs         1 of 1 batches to do, 1 shapes of the water",
    ]
    Pack(Path(plan.folder, "members", f"other{SUFFIX}")).append(xr.Dataset(attrs={"spec_id": plan.members[2].id}))
    (batch,) = (Path(one.out) for one in plan.batches.values())
    batch.parent.mkdir(parents=True, exist_ok=True)
    batch.touch()
    assert summary(plan)[1:3] == [
        "points       4 of device.young_modulus x device.density, 1 done",
        "jobs         0 of 1 batches to do, 1 shapes of the water",
    ]


def test_points_without_a_viable_flexible_design_are_named(folder, monkeypatch):
    """Inflated beyond what the law of Hooke holds for: p r (1 - nu) / (2 E h) alone is 35 % at 100 kPa."""
    monkeypatch.chdir(folder)
    wall = BASE["device"] | {"thickness": 0.02, "young_modulus": 1e7}
    plan = planned(folder, {"device.internal_pressure": [25e3, 1e5]}, name="strained", device=wall)
    *_, load, lost = summary(plan)
    assert load.startswith("ok           buckling = ")
    assert re.match(
        r"doubt +not_viable = 1 \(limit 0\): points of 2 at which no flexible design is viable: overstrained", lost
    )
    only = planned(folder, {"device.internal_pressure": [1e5]}, name="only_strained", device=wall)
    assert summary(only)[-1].startswith("fail         not_viable = 1")
    assert "; by linear buckling viable at device.internal_pressure = " in summary(only)[-1]


CLIMATES = Path(__file__).parents[2] / "config" / "climate"
BUOY = CLIMATES / "ndbc46042_1996_spectra.txt.gz"


def year(path, form, gamma=3.3):
    """A climate file, named by its contents."""
    named = Spectra(spectra="") if form == "spectra" else Scatter(scatter="", spectrum=form, gamma=gamma)
    return named.of_contents(hashlib.sha256(Path(path).read_bytes()).hexdigest()[:16])


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """Two days of the buoy, unpacked."""
    path = tmp_path_factory.mktemp("climate") / "short.txt"
    path.write_text("".join(gzip.decompress(BUOY.read_bytes()).decode().splitlines(keepends=True)[:49]))
    return path


def test_changed_or_missing_climate_file_is_refused(short, tmp_path):
    planned, other = year(short, "spectra"), tmp_path / "other.txt"
    other.write_text(short.read_text() + "\n")
    with pytest.raises(ConfigError, match=r"other.txt: changed since the run was planned; run vsb run CONFIG again"):
        read_climate(planned, str(other))
    with pytest.raises(ConfigError, match=r"nowhere.txt: cannot be read .*; needs the climate of the campaign"):
        read_climate(planned, str(tmp_path / "nowhere.txt"))
