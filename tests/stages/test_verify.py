"""Damaged, stale and foreign results: detected by verify and run, recomputed or refused."""

import os
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from conftest import SMALL as RAW
from conftest import SMALL_PLAN as PLAN
from tools.test_files import rewritten

import vsb
from vsb.cli import main
from vsb.errors import DatabaseError, VsbError
from vsb.pipeline.graph import StudyPlan
from vsb.stages import report
from vsb.stages.stage import shared_lock
from vsb.stages.verify import differences, stale_products, study_faults, verify
from vsb.study import study as config

TOGETHER = ("report.html", "comparison.csv", "statistics.csv", "validity.json", "study.json", "tables.json")


@pytest.fixture
def place(finished, tmp_path, monkeypatch):
    """A copy of the small study without Snakemake's records, as the current folder."""
    shutil.copytree(finished, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    return tmp_path / "copy"


def plan_of(**changes):
    return StudyPlan(config.parse({**RAW, **changes}))


(WAVE,) = PLAN.study.waves
FSB, VSWEC = (PLAN.simulation(design, WAVE).out for design in ("FSB", "VSWEC"))
RESPONSE, TABLE = f"{PLAN.folder}/response.nc", f"{PLAN.folder}/comparison.csv"


def scaled(name, factor):
    def change(file):
        file[name][...] = factor * file[name][...]

    return lambda path: rewritten(path, change)


def replaced(old, new):
    def change(path):
        text = Path(path).read_text()
        assert old in text
        Path(path).write_text(text.replace(old, new, 1))

    return change


def cut(path):
    content = Path(path).read_bytes()
    Path(path).write_bytes(content[: len(content) // 2])


DAMAGE = [
    (FSB, scaled("velocity", 2.0)),
    (FSB, lambda path: shutil.copy(VSWEC, path)),
    (FSB, lambda path: Path(path).write_bytes(b"")),
    (RESPONSE, cut),
    (f"{PLAN.folder}/tables.json", replaced('"verdict": "fail"', '"verdict": "ok"')),
    (f"{PLAN.folder}/study.json", replaced("8000", "5000")),
    (f"{PLAN.folder}/figures/absorbed_power.svg", cut),
    (PLAN.display.makes[0], cut),
]
SHARED = [
    (PLAN.database.out, scaled("hydrostatic_stiffness", 1.3)),
    (PLAN.radiation.out, lambda path: shutil.copy(FSB, path)),
    (PLAN.block_path(PLAN.sweep_blocks[0]), cut),
]
"""Files that studies share are not removed by a run."""


def with_old_time(path, damage):
    times = os.stat(path)
    damage(path)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def test_copied_results_are_valid_without_snakemakes_records(place):
    assert not (place / ".snakemake").exists()
    assert study_faults(PLAN) == []
    assert verify("small.yaml") == [f"small.yaml: {len(PLAN.file_ids)} files are what they should be"]
    for folder in ("results", "results/small"):
        assert verify(folder) == [f"{folder}: {len(PLAN.file_ids)} files are what they should be"]


def test_change_of_a_study_is_told_from_what_it_was_to_what_it_is(place):
    assert differences(PLAN) == ""
    assert differences(plan_of(pto={**RAW["pto"], "damping": 5000.0})) == "pto.damping 8000.0 -> 5000.0"


def test_copied_results_are_continued(place):
    """From another folder only what is missing, and what rests on it, is made."""
    whole, before = Path(FSB).read_bytes(), {path: os.stat(path).st_mtime_ns for path in PLAN.file_ids if path != FSB}
    power = vsb.open("results/small").comparison.power_mean
    Path(FSB).unlink()
    again = vsb.run(vsb.load("small.yaml"))
    assert len(Path(FSB).read_bytes()) == len(whole)
    assert again.comparison.power_mean.equals(power)
    made = {path for path, then in before.items() if os.stat(path).st_mtime_ns != then}
    assert made.isdisjoint({VSWEC, RESPONSE, PLAN.database.out, PLAN.radiation.out})


def test_shared_files_are_known_in_the_folder_of_another_user(place, tmp_path, monkeypatch):
    """A link to the hydrodynamics of a finished study: viewable meshes carry their stamps with them."""
    (tmp_path / "other" / "results").mkdir(parents=True)
    (tmp_path / "other" / "results" / "hydro").symlink_to(place / "results" / "hydro")
    monkeypatch.chdir(tmp_path / "other")
    assert Path(PLAN.display.makes[0]).is_file()
    assert stale_products(PLAN, dry=True) == []


def test_run_keeps_what_a_user_put_in_the_place_of_a_product(place):
    """Dry runs move nothing."""
    table = Path(f"{PLAN.folder}/comparison.csv")
    table.write_text("hers")
    for dry, there in ((True, True), (False, False)):
        assert str(table) in stale_products(PLAN, dry=dry)
        assert table.exists() == there
    (kept,) = Path(PLAN.root, "trash").rglob("comparison.csv")
    assert kept.read_text() == "hers"


def test_what_another_run_is_making_for_both_stays(place):
    """Meshes that are written and not yet in their manifest are not moved: the run waits for the other one."""
    meshes = PLAN.display.makes
    manifest, aside = Path(PLAN.display.files["manifest"]), Path("manifest.json")
    with ThreadPoolExecutor() as pool:
        with shared_lock(PLAN.root, meshes):
            manifest.rename(aside)
            found = pool.submit(stale_products, PLAN, dry=False)
            with pytest.raises(TimeoutError):
                found.result(timeout=0.3)
            aside.rename(manifest)
        assert found.result(timeout=60.0) == []
    assert all(Path(path).is_file() for path in meshes)


@pytest.mark.parametrize(("path", "damage"), DAMAGE)
def test_damaged_results_are_recomputed(place, path, damage, capsys):
    with_old_time(path, damage)
    assert stale_products(PLAN, dry=True) == [path]
    assert f"vsb: {path}: " in capsys.readouterr().out
    with pytest.raises(VsbError, match=rf"{path}: .*; delete what is wrong, then vsb run small.yaml makes it anew$"):
        verify("small.yaml")


@pytest.mark.parametrize(("path", "damage"), SHARED)
def test_damaged_shared_file_stops_the_run(place, path, damage, capsys):
    with_old_time(path, damage)
    assert main(["run", "small.yaml"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"vsb: error: {path}: ")
    assert err.count("\n") == 1
    assert "delete" in err


@pytest.mark.parametrize(
    ("changes", "stale"),
    [
        ({"pto": {"damping": 5000.0}}, {FSB, VSWEC, RESPONSE}),
        ({"simulation": {**RAW["simulation"], "duration": 9.0}}, {FSB, VSWEC}),
        (
            {"designs": {"FSB": {"flexible": False}, "VSWEC": {"clamp": 0}}},
            {VSWEC, RESPONSE, f"{PLAN.folder}/modes.nc"},
        ),
    ],
)
def test_changed_study_makes_dependent_results_stale(place, changes, stale):
    found = set(stale_products(plan_of(**changes), dry=True))
    assert {path for path in found if path.endswith(".nc")} == stale
    assert {f"{PLAN.folder}/{name}" for name in TOGETHER} < found
    assert set(PLAN.display.makes).isdisjoint(found)


def report_files():
    return {
        "tables": f"{PLAN.folder}/tables.json",
        "modes": f"{PLAN.folder}/modes.nc",
        "trajectories": f"{PLAN.folder}/trajectories",
        "figures": f"{PLAN.folder}/figures",
        "manifest": PLAN.manifest,
        **PLAN.hydro_files,
        "response": RESPONSE,
    }


@pytest.mark.parametrize(("path", "damage"), [DAMAGE[1], DAMAGE[3], DAMAGE[4], DAMAGE[6], SHARED[0]])
def test_stage_refuses_damaged_input(place, path, damage):
    damage(path)
    with pytest.raises(DatabaseError, match=rf"{path}: .*delete"):
        report.run_report(PLAN.study, out="again.html", **report_files())
    assert not Path("again.html").exists()


def test_verify_checks_every_file_of_a_folder(place, capsys):
    old = Path(PLAN.folder, "trajectories", "of_before.nc")
    shutil.copy(FSB, old)
    verify("results")
    scaled("velocity", 2.0)(old)
    with pytest.raises(VsbError, match=r"of_before.nc: its contents are not .*; delete what is wrong, then vsb run"):
        verify("results")
    Path(PLAN.manifest).write_text("{")
    with pytest.raises(VsbError, match=r"is not in the manifest \(and \d+ more\)"):
        verify("results/small")
    assert "of_before.nc: its contents are not" in capsys.readouterr().out  # each a line
    Path(PLAN.manifest).unlink()
    Path(RESPONSE).unlink()
    with pytest.raises(VsbError, match=r"is not in the manifest \(and \d+ more\)"):
        verify("small.yaml")
    assert f"{RESPONSE}: is not there\n" in capsys.readouterr().out


def test_half_written_files_are_ignored_and_misnamed_files_refused(place):
    """Names of files being written begin with a dot; a file named by an id must hold it."""
    Path(PLAN.folder, ".half.nc").write_bytes(b"half")
    verify("results")
    shutil.copy(PLAN.database.out, Path(PLAN.folder, "0123456789abcdef.nc"))
    with pytest.raises(VsbError, match=rf"0123456789abcdef.nc: holds '{Path(PLAN.database.out).stem}'"):
        verify("results")


def test_an_index_is_what_its_databases_make_it(place):
    index = Path("results/hydro/INDEX.tsv")
    index.write_text(index.read_text() + "more\n")
    with pytest.raises(VsbError, match=r"INDEX.tsv: does not list the databases there"):
        verify("results")
