"""Results that are not what they should be: one small finished study, damaged in every way anybody thought of."""

import json
import os
import re
import shutil
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import netCDF4
import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import SMALL as RAW
from conftest import SMALL_PLAN as PLAN
from stages.test_coefficients import as_body
from stages.test_members import planned, with_seas
from tools.test_files import rewritten

from vsb.cli import main
from vsb.errors import DatabaseError, VsbError
from vsb.hydro.database import save_database
from vsb.stages import figures, report, simulate
from vsb.stages import verify as module
from vsb.stages.verify import _more, differences, stale_products, study_faults, verify
from vsb.study import study as config
from vsb.study.body import located
from vsb.study.body_plan import BodyPlan
from vsb.study.canonical import leaves
from vsb.study.plan import StudyPlan
from vsb.study.study import content_id
from vsb.tools import packed
from vsb.tools.files import load, read_groups
from vsb.tools.stamps import Fault, record

TOGETHER = ("report.html", "comparison.csv", "statistics.csv", "validity.json", "study.json", "tables.json")


@pytest.fixture
def place(finished, tmp_path, monkeypatch):
    """A copy of it, of which Snakemake remembers nothing, as the current folder."""
    shutil.copytree(finished, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    return tmp_path / "copy"


def plan_of(**changes):
    return StudyPlan(config.parse({**RAW, **changes}))


(WAVE,) = PLAN.study.waves
FSB, VSWEC = (PLAN.trajectory_path(design, WAVE.label) for design in ("FSB", "VSWEC"))
RESPONSE, TABLE = f"{PLAN.folder}/response.nc", f"{PLAN.folder}/comparison.csv"


def scaled(name, factor):
    def change(file):
        file[name][...] = factor * file[name][...]

    return lambda path: rewritten(path, change)


def to_nan(path):
    def change(file):
        file["position"][3, 0] = np.nan

    rewritten(path, change)


def replaced(old, new):
    def change(path):
        text = Path(path).read_text()
        assert old in text
        Path(path).write_text(text.replace(old, new, 1))

    return change


def cut(path):
    content = Path(path).read_bytes()
    Path(path).write_bytes(content[: len(content) // 2])


def first_power(text):
    return next(csv_row.split(",")[5] for csv_row in text.splitlines()[1:])


def nan_power(path):
    text = Path(path).read_text()
    Path(path).write_text(text.replace(first_power(text), "nan", 1))


def without_a_design(path):
    Path(path).write_text("\n".join(line for line in Path(path).read_text().splitlines() if "VSWEC" not in line))


DAMAGE = [
    (FSB, scaled("energy", 2.0)),
    (FSB, scaled("velocity", 2.0)),
    (FSB, to_nan),
    (FSB, lambda path: shutil.copy(VSWEC, path)),
    (FSB, lambda path: Path(path).write_bytes(b"")),
    (FSB, cut),
    (RESPONSE, scaled("absorbed_power", 1.5)),
    (RESPONSE, cut),
    (f"{PLAN.folder}/modes.nc", scaled("radial", -1.0)),
    (TABLE, nan_power),
    (TABLE, without_a_design),
    (TABLE, cut),
    (f"{PLAN.folder}/validity.json", replaced('"verdict": "fail"', '"verdict": "ok"')),
    (f"{PLAN.folder}/tables.json", replaced('"verdict": "fail"', '"verdict": "ok"')),
    (f"{PLAN.folder}/study.json", replaced("8000", "5000")),
    (f"{PLAN.folder}/report.html", replaced("absorbs", "wastes")),
    (f"{PLAN.folder}/figures/absorbed_power.svg", cut),
    (PLAN.display_paths[0], cut),
]
SHARED = [
    (PLAN.database_path, scaled("hydrostatic_stiffness", 1.3)),
    (PLAN.database_path, lambda path: shutil.copy(PLAN.radiation_path, path)),
    (PLAN.radiation_path, scaled("input_matrix", 1.1)),
    (PLAN.radiation_path, lambda path: shutil.copy(FSB, path)),
    (PLAN.radiation_path, cut),
    (PLAN.block_path(PLAN.sweep_blocks[0]), scaled("added_mass", 1.01)),
]
"""Files studies share: a run does not remove them by itself."""


def trashed(path):
    """Where healing moved a file to."""
    (found,) = Path("results/trash").rglob(Path(path).name)
    return found


def with_old_time(path, damage):
    times = os.stat(path)
    damage(path)
    os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def test_a_copy_means_the_same_without_snakemakes_memory(place):
    assert not (place / ".snakemake").exists()
    assert study_faults(PLAN) == []
    assert verify("small.yaml", heal=False) == [f"small.yaml: {len(PLAN.ids)} files are what they should be"]
    for folder in ("results", "results/small"):
        assert verify(folder, heal=False) == [f"{folder}: {len(PLAN.ids)} files are what they should be"]


def test_every_file_promised_carries_a_stamp(place):
    promised = json.loads(Path(PLAN.manifest).read_text())
    for path in PLAN.products:
        if path.endswith(".nc"):
            attrs = load(path).attrs
            assert attrs["spec_id"] == PLAN.ids[path]
            assert len(attrs["checksum"]) == 64
        else:
            assert promised[os.path.relpath(path, PLAN.folder)]["spec_id"] == PLAN.ids[path]


@pytest.mark.parametrize(("path", "damage"), DAMAGE)
def test_damage_of_a_studys_own_files_is_computed_anew(place, path, damage, capsys):
    with_old_time(path, damage)
    assert stale_products(PLAN, dry=True) == [path]
    assert f"vsb: {path}: " in capsys.readouterr().out
    with pytest.raises(VsbError, match=rf"{path}: .*vsb verify small.yaml --heal moves what is wrong to"):
        verify("small.yaml", heal=False)
    assert verify("small.yaml", heal=True)[-1] == "vsb run small.yaml makes 1 files"
    assert not Path(path).exists()


@pytest.mark.parametrize(("path", "damage"), SHARED)
def test_damage_of_what_studies_share_is_refused(place, path, damage, capsys):
    with_old_time(path, damage)
    assert main(["run", "small.yaml"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith(f"vsb: error: {path}: ")
    assert err.count("\n") == 1
    assert "vsb verify --heal" in err or "delete" in err
    verify("small.yaml", heal=True)
    assert not Path(path).exists()


OTHER = str(Path(PLAN.database_path).with_name("f" * 16 + ".nc"))


@pytest.mark.parametrize(
    ("path", "kind", "refused"),
    [
        (PLAN.database_path, "nameless", True),
        (PLAN.database_path, "damaged", True),
        (OTHER, "damaged", True),
        (OTHER, "nameless", False),
    ],
)
def test_of_what_studies_share_a_run_removes_what_nobody_promised_and_names_nothing(
    monkeypatch, tmp_path, path, kind, refused
):
    monkeypatch.chdir(tmp_path)
    Path(path).parent.mkdir(parents=True)
    Path(path).write_text("-")
    monkeypatch.setattr("vsb.stages.verify.differences", lambda plan: "")
    monkeypatch.setattr("vsb.stages.verify.study_faults", lambda plan: [Fault(path, kind, "why")])
    with pytest.raises(DatabaseError, match=f"{path}: why; ") if refused else nullcontext():
        assert stale_products(PLAN, dry=False) == []
    assert Path(path).exists() == refused


def test_a_dry_run_removes_nothing(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    Path(OTHER).parent.mkdir(parents=True)
    Path(OTHER).write_text("-")
    monkeypatch.setattr("vsb.stages.verify.study_faults", lambda plan: [Fault(OTHER, "nameless", "why")])
    assert stale_products(PLAN, dry=True) == []
    assert Path(OTHER).exists()


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
def test_a_changed_study_finds_its_old_results_stale(place, changes, stale):
    found = set(stale_products(plan_of(**changes), dry=True))
    assert {path for path in found if path.endswith(".nc")} == stale
    assert {f"{PLAN.folder}/{name}" for name in TOGETHER} < found
    assert set(PLAN.display_paths).isdisjoint(found)


def test_a_changed_damping_is_computed_also_without_snakemakes_memory(place):
    Path("small.yaml").write_text(yaml.safe_dump({**RAW, "pto": {"damping": 5000.0}}))
    before = load(FSB)
    assert main(["run", "small.yaml", "--quiet", "all"]) == 0
    assert np.abs(load(FSB).position - before.position).max() > 1e-3
    assert study_faults(plan_of(pto={"damping": 5000.0})) == []
    assert {FSB, VSWEC, RESPONSE, TABLE} < set(stale_products(PLAN, dry=True))


def report_files(**others):
    files = {
        "tables": f"{PLAN.folder}/tables.json",
        "modes": f"{PLAN.folder}/modes.nc",
        "trajectories": f"{PLAN.folder}/trajectories",
        "figures": f"{PLAN.folder}/figures",
        "manifest": PLAN.manifest,
        **PLAN.hydro_files,
        "response": RESPONSE,
    }
    return {**files, **others}  # fmt: skip


@pytest.mark.parametrize("path", [TABLE, f"{PLAN.folder}/validity.json", f"{PLAN.folder}/statistics.csv"])
def test_tables_for_people_are_never_read_back(place, path):
    Path(path).write_text("nonsense")
    text = Path(f"{PLAN.folder}/report.html").read_text()
    report.run(PLAN.study, out="again.html", **report_files())
    assert Path("again.html").read_text() == text


@pytest.mark.parametrize(
    ("path", "damage"),
    [case for case in DAMAGE if case[0] in (FSB, RESPONSE) or "tables.json" in case[0] or ".svg" in case[0]]
    + SHARED[:5],
)
def test_a_stage_reads_nothing_that_is_not_what_it_should_be(place, path, damage):
    damage(path)
    with pytest.raises(DatabaseError, match=rf"{path}: .*delete"):
        report.run(PLAN.study, out="again.html", **report_files())
    assert not Path("again.html").exists()


def test_a_run_does_not_take_the_radiation_model_of_another_study(place):
    other = f"results/hydro/radiation/{'0' * 16}.nc"
    shutil.copy(PLAN.radiation_path, other)
    files = {"database": PLAN.database_path, "radiation": other}
    with pytest.raises(DatabaseError, match=rf"{other}: holds '\w+', needs '0+': stale or foreign"):
        simulate.run(PLAN.simulation("FSB", WAVE), "out.nc", **files)


def test_figures_do_not_take_the_modes_of_another_study(place):
    other = plan_of(modes={"basis": "full", "degree": 2})
    bem = {**PLAN.hydro_files, "response": RESPONSE}
    with pytest.raises(
        DatabaseError, match=f"modes.nc: holds '{content_id(PLAN.modes)}', needs '{content_id(other.modes)}'"
    ):
        figures.run(
            config.parse({**RAW, "modes": {"basis": "full", "degree": 2}, "designs": RAW["designs"]}),
            f"{PLAN.folder}/trajectories", "figures", "manifest.json", modes=f"{PLAN.folder}/modes.nc",
            database=PLAN.database_path, radiation=PLAN.radiation_path,
            response=relabelled(bem["response"], other.response_id),
        )  # fmt: skip


def relabelled(path, identity):
    """A response that claims to be of another study, checksum and all."""
    from vsb.tools.files import save

    save(load(path).assign_attrs(spec_id=identity), "claims.nc")
    return "claims.nc"


def test_files_of_before_are_stamped_if_they_are_as_specified(place):
    def bare(path):
        rewritten(path, lambda file: file.delncattr("checksum"))

    for path in (PLAN.database_path, PLAN.radiation_path):
        bare(path)
    assert [fault.kind for fault in study_faults(PLAN)] == ["unstamped"] * 2
    assert stale_products(PLAN, dry=True) == []
    assert len(study_faults(PLAN)) == 2  # a dry run changes nothing
    assert stale_products(PLAN, dry=False) == []
    assert "checksum" in load(PLAN.database_path).attrs
    assert study_faults(PLAN) == []
    bare(FSB)  # never was without
    assert stale_products(PLAN, dry=False) == [FSB]


def test_results_of_before_the_stamps_are_computed_anew(place):
    for path in (FSB, RESPONSE):
        rewritten(path, lambda file: [file.delncattr(name) for name in ("checksum", "spec_id", "spec")])
    Path(PLAN.manifest).unlink()
    found = stale_products(PLAN, dry=True)
    assert {FSB, RESPONSE, TABLE} < set(found)
    assert VSWEC not in found


def test_a_folder_is_verified_whole(place):
    old = Path(PLAN.folder, "trajectories", "of_before.nc")
    shutil.copy(FSB, old)
    verify("results", heal=False)
    scaled("velocity", 2.0)(old)
    with pytest.raises(VsbError, match=r"of_before.nc: its contents are not .*vsb verify results --heal"):
        verify("results", heal=False)
    Path(PLAN.manifest).write_text("{")
    with pytest.raises(VsbError, match=r"is not in the manifest \(and \d+ more\)"):
        verify("results/small", heal=False)
    Path("results/hydro/INDEX.tsv").write_text("id\n")
    verify("results", heal=True)
    assert Path("results/hydro/INDEX.tsv").read_text().count("\n") == 2
    assert not Path(PLAN.manifest).exists()
    with pytest.raises(VsbError, match=r": is not there \(and \d+ more\); vsb run small.yaml makes it anew"):
        verify("small.yaml", heal=False)


def test_healing_stamps_what_is_of_before_removes_what_is_damaged_and_says_so(place):
    assert verify("small.yaml", heal=True) == ["small.yaml: all is sound"]
    rewritten(PLAN.database_path, lambda file: file.delncattr("checksum"))
    scaled("velocity", 2.0)(FSB)
    *healed, makes = verify("small.yaml", heal=True)
    assert sorted(line.partition(": ")[0] for line in healed) == [
        f"moved {FSB} to {trashed(FSB)}",
        f"stamped {PLAN.database_path}",
    ]
    assert makes == "vsb run small.yaml makes 2 files"
    assert "checksum" in load(PLAN.database_path).attrs
    assert not Path(FSB).exists()
    assert verify("small.yaml", heal=True) == ["vsb run small.yaml makes 1 files"]


def test_the_index_is_of_the_databases_healing_leaves(place):
    """One of another specification is removed from both, though the index told of it rightly."""
    save_database(load(PLAN.database_path).assign_attrs(spec_id="0" * 16), None, PLAN.database_path)
    healed, _ = verify("results", heal=True)
    assert healed.startswith(f"moved {PLAN.database_path} to {trashed(PLAN.database_path)}: is of '0000000000000000'")
    assert len(verify("results", heal=True)) == 1


def test_where_there_are_no_databases_healing_writes_no_index_of_them(place):
    shutil.rmtree("results/hydro")
    scaled("velocity", 2.0)(FSB)
    assert verify("results/small", heal=True)[0].startswith(f"moved {FSB} to ")
    assert not Path("results/hydro").exists()


def test_what_is_half_written_is_nobodys_and_what_is_named_by_another_id_is_foreign(place):
    """A file named by an id holds it; what begins with a dot is being written, and replaced as a whole."""
    Path(PLAN.folder, ".half.nc").write_bytes(b"half")
    verify("results", heal=False)
    shutil.copy(PLAN.database_path, Path(PLAN.folder, "0123456789abcdef.nc"))
    with pytest.raises(VsbError, match=rf"0123456789abcdef.nc: holds '{Path(PLAN.database_path).stem}'"):
        verify("results", heal=False)


def test_of_many_lines_one_is_told_and_the_others_are_counted():
    assert [_more(["line"] * count) for count in (1, 2, 3)] == ["", " (and 1 more)", " (and 2 more)"]


def test_an_index_is_what_its_databases_make_it(place):
    index = Path("results/hydro/INDEX.tsv")
    index.write_text(index.read_text() + "more\n")
    with pytest.raises(VsbError, match=r"INDEX.tsv: its contents are not"):
        verify("results", heal=False)
    index.unlink()
    with pytest.raises(VsbError, match=r"INDEX.tsv: is not there"):
        verify("results", heal=False)
    assert verify("results", heal=True)[0] == "wrote results/hydro/INDEX.tsv again: is not there"
    verify("results", heal=False)


def test_an_edited_study_does_not_condemn_its_results(place):
    """What it is of is read from the folder itself: healing must not take the word of a file somebody edited."""
    replaced("8000", "5000")(f"{PLAN.folder}/study.json")
    assert len(verify("results", heal=True)) == 2
    assert Path(FSB).exists()
    assert not Path(PLAN.folder, "study.json").exists()


def test_a_new_product_needs_no_entry_of_its_own(place):
    class Wider(StudyPlan):
        @property
        def products(self):
            return [*super().products, f"{self.folder}/rungs.csv", f"{self.root}/hydro/witness/{'a' * 16}.nc"]

    wider = Wider(PLAN.study)
    assert wider.ids[f"{PLAN.folder}/rungs.csv"] == PLAN.study_id
    assert wider.ids[f"results/hydro/witness/{'a' * 16}.nc"] == "a" * 16
    ladder = Path(PLAN.folder, "rungs.csv")
    ladder.write_text("rung\n")
    assert [fault.path for fault in study_faults(wider)] == [str(ladder)]
    record(PLAN.manifest, PLAN.study_id, [ladder])
    assert study_faults(wider) == []


def contents(path):
    return read_groups(path) if path.endswith(".nc") else Path(path).read_bytes()


def same(one, other):
    if isinstance(one, bytes):
        return one == other
    return one.keys() == other.keys() and all(one[name].identical(other[name]) for name in one)


def test_no_flipped_bit_of_any_file_is_silent(place):
    rng, files = np.random.default_rng(11), [*PLAN.ids, "results/hydro/INDEX.tsv"]
    sizes = [os.path.getsize(path) for path in files]
    for path in rng.choice(files, size=60, p=np.array(sizes) ** 0.5 / np.sum(np.array(sizes) ** 0.5)):
        good = Path(path).read_bytes()
        bit, bad = int(rng.integers(8 * len(good))), bytearray(good)
        bad[bit // 8] ^= 1 << (bit % 8)
        before = contents(str(path))
        Path(path).write_bytes(bad)
        try:
            verify("small.yaml", heal=False)
        except VsbError as error:
            assert str(path) in str(error)  # noqa: PT017
            assert "\n" not in str(error)  # noqa: PT017
        else:
            assert same(contents(str(path)), before), (path, bit)
        Path(path).write_bytes(good)
    with netCDF4.Dataset(FSB) as file:
        assert file.spec_id == PLAN.ids[FSB]


def test_what_a_changed_study_replaces_is_said(tmp_path):
    def planned(**changes):
        return StudyPlan(config.parse({**RAW, **changes}), root=str(tmp_path))

    before = planned()
    assert differences(before) == ""
    Path(before.folder).mkdir()
    Path(before.folder, "study.json").write_text(config.canonical(before.study))
    assert differences(before) == ""
    assert differences(planned(pto={"damping": 9000.0})) == "pto.damping 8000.0 -> 9000.0"
    more = differences(planned(waves=[*RAW["waves"], {"kind": "jonswap", "hs": 0.2, "tp": 5.0}]))
    assert more.startswith("waves.1.hs nothing -> 0.2, waves.1.amplitudes nothing -> fixed, ")
    shorter = {"simulation": {"duration": 9.0, "window": [5.0, 9.0], "initial_velocity": 0.1, "tolerance": 1e-5}}
    many = planned(water={"density": 1020.0, "depth": 90.0, "gravity": 9.8}, **shorter)
    assert differences(many).endswith(" (and 2 more)")
    Path(before.folder, "study.json").write_text("{")
    assert differences(planned(pto={"damping": 9000.0})) == ""


@pytest.mark.parametrize("damping", ["5000.0", "15000.0"])
def test_a_study_that_was_edited_since_it_was_stamped_is_of_no_plan(tmp_path, damping):
    """It can be read as ever, but is not what was computed; in as many letters or in more."""
    before = StudyPlan(config.parse(RAW), root=str(tmp_path))
    changed = StudyPlan(config.parse({**RAW, "pto": {"damping": 9000.0}}), root=str(tmp_path))
    path = Path(before.folder, "study.json")
    path.parent.mkdir()
    path.write_text(config.canonical(before.study))
    record(before.manifest, before.study_id, [path])
    assert differences(changed) == "pto.damping 8000.0 -> 9000.0"
    replaced("8000.0", damping)(path)
    assert module._plan(path.parent) is None
    assert differences(changed) == ""


def test_a_body_changes_as_a_study_does_and_a_campaign_of_its_name_is_none(finished, tmp_path):
    def body(**changes):
        found = located(as_body(finished, **changes), "a.yaml")
        return BodyPlan(found.study, root=str(tmp_path / "results"), files=found.files)

    campaign = planned(with_seas(tmp_path, (1.0, 6.0)), name="general")
    assert campaign.folder == body().folder
    Path(body().folder).mkdir(parents=True)
    Path(body().folder, "study.json").write_text(config.canonical(body().study))
    assert differences(body()) == ""
    assert differences(body(pto={"damping": 9000.0})) == "pto.damping 8000.0 -> 9000.0"
    assert differences(campaign) == ""


def test_of_missing_files_the_first_by_name_is_told_and_the_others_are_counted(tmp_path, monkeypatch):
    """Of a study that was never run these are all."""
    monkeypatch.chdir(tmp_path)
    Path("small.yaml").write_text(yaml.safe_dump(RAW))
    first, *others = sorted(set(PLAN.products))
    line = f"{first}: is not there (and {len(others)} more); vsb run small.yaml makes it anew"
    with pytest.raises(VsbError, match=f"^{re.escape(line)}$"):
        verify("small.yaml", heal=False)


def test_of_shared_files_those_are_made_anew_that_take_no_time(monkeypatch, tmp_path, capsys):
    """Meshes to look at, whatever is wrong with them; netCDF beside them is for the user to remove."""
    monkeypatch.chdir(tmp_path)
    mesh = next(path for path in PLAN.ids if PLAN.is_shared(path) and not path.endswith(".nc"))
    for kind in ("nameless", "stale", "damaged"):
        monkeypatch.setattr("vsb.stages.verify.study_faults", lambda plan, kind=kind: [Fault(mesh, kind, "why")])
        assert stale_products(PLAN, dry=False) == [mesh]
        assert capsys.readouterr().out == f"vsb: {mesh}: why; computed anew\n"


def test_a_folder_is_of_all_studies_in_it_that_it_knows(tmp_path, monkeypatch):
    """Its own first, then those below it by name; one whose study is not readable any more has no plan."""
    for name in ("b", "a", "c", "none"):
        (tmp_path / name).mkdir()
        if name != "none":
            (tmp_path / name / "study.json").touch()
    monkeypatch.setattr(module, "_plan", lambda folder: None if folder.name == "b" else folder.name)
    monkeypatch.setattr(module, "plan_of", lambda target: f"of {target}")
    assert module._plans(str(tmp_path)) == ["a", "c"]
    (tmp_path / "study.json").touch()
    assert module._plans(str(tmp_path)) == [tmp_path.name, "a", "c"]
    assert module._plans(str(tmp_path / "study.yaml")) == [f"of {tmp_path / 'study.yaml'}"]


def test_of_manifests_one_that_cannot_be_read_hides_no_other(tmp_path):
    for name in "abc":
        (tmp_path / name).mkdir()
        (tmp_path / name / "x.csv").write_text(name)
        record(tmp_path / name / "manifest.json", name * 16, [tmp_path / name / "x.csv"])
    assert {stamp.spec_id[0] for stamp in module.manifests(tmp_path).values()} == {"a", "b", "c"}
    for name, others in (("a", "bc"), ("b", "c")):
        (tmp_path / name / "manifest.json").write_text("{")
        assert set(module.manifests(tmp_path)) == {str(tmp_path / other / "x.csv") for other in others}


def test_values_of_nested_data_are_known_by_their_names_with_dots():
    """Of a list without any there is none."""
    data = {"a": {"b": [1, (2, {})], "": 3}, "c": None, "d": [], "e": "xy", "f": False}
    named = {"a.b.0": 1, "a.b.1.0": 2, "a.b.1.1": {}, "a.": 3, "c": None, "e": "xy", "f": False}
    assert leaves(data) == named


@pytest.mark.parametrize(("changed", "more"), [(6, ""), (7, " (and 1 more)"), (9, " (and 3 more)")])
def test_six_changes_of_a_study_are_told_and_what_it_no_longer_says_is_one(tmp_path, monkeypatch, changed, more):
    """In the order of what it said before; then what is new."""
    old = {"lost": 1, **{f"k{i}": i for i in range(9)}, "kept": 5}
    new = {"kept": 5, **{f"k{i}": 10 * i for i in range(1, 9)}, "k0": 0, "new": None, "found": 3}
    keys = ["lost", *(f"k{i}" for i in range(1, 9)), "found"][: changed - 1]
    old = {key: value for key, value in old.items() if key in keys or key == "kept"}
    new = {key: value for key, value in new.items() if key in [*keys[1:], "kept"]} | {"last": 7}
    study = lambda data: SimpleNamespace(model_dump=lambda: data)  # noqa: E731
    monkeypatch.setattr(module, "_plan", lambda folder: SimpleNamespace(study=study(old)))
    (tmp_path / "study.json").touch()
    told = differences(SimpleNamespace(folder=str(tmp_path), study=study(new)))
    lines = ["lost 1 -> nothing", *(f"k{i} {i} -> {10 * i}" for i in range(1, changed - 1)), "last nothing -> 7"]
    assert told == ", ".join(lines[:6]) + more


@pytest.mark.parametrize(("dry", "word"), [(True, "holds"), (False, "held")])
def test_what_a_run_replaces_is_told_as_what_there_is_or_was(monkeypatch, capsys, dry, word):
    """And the first of the files it makes anew, with the number of the others."""
    found = [Fault(f"results/small/{name}", "stale", f"of {name}") for name in ("a.csv", "b.csv", "c.csv")]
    monkeypatch.setattr(module, "differences", lambda plan: "all of it")
    monkeypatch.setattr(module, "study_faults", lambda plan: found)
    assert stale_products(PLAN, dry=dry) == [fault.path for fault in found]
    assert capsys.readouterr().out == (
        f"vsb: {PLAN.folder} {word} another study of this name: all of it\n"
        "vsb: results/small/a.csv: of a.csv (and 2 more); computed anew\n"
    )


def test_healing_leaves_a_users_own_files_and_moves_ours_to_the_trash(place, capsys):
    """Whatever their names; what carries our stamp and is damaged can be taken back from the trash."""
    own = [Path(PLAN.folder, name) for name in (f"{'a' * 16}.nc", f"{'b' * 16}.npz", "data.nc", "notes/manifest.json")]
    own.append(Path("results/own/half.nc"))
    for path in own:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"neither netCDF nor packed")
    with netCDF4.Dataset(Path(PLAN.folder, f"{'c' * 16}.nc"), "w"):
        pass
    assert main(["verify", "results"]) == 2
    assert "may be your own (and 4 more)" in capsys.readouterr().err
    old = Path(PLAN.folder, "trajectories", "of_before.nc")
    shutil.copy(FSB, old)
    scaled("velocity", 2.0)(old)
    packed.save(
        xr.Dataset({"power": ("hs", [1.0])}, attrs={"spec_id": "d" * 16}), f"{PLAN.folder}/{'e' * 16}{packed.SUFFIX}"
    )
    damaged = {path: path.read_bytes() for path in (old, Path(f"{PLAN.folder}/{'e' * 16}{packed.SUFFIX}"))}
    assert main(["verify", "results", "--heal"]) == 2  # nobody can be asked
    assert "would move 2 files to the trash; needs --yes" in capsys.readouterr().err
    assert all(path.exists() for path in damaged)
    assert main(["verify", "results", "--heal", "--yes"]) == 0
    assert {trashed(path).read_bytes() for path in damaged} == set(damaged.values())
    assert not any(path.exists() for path in damaged)
    assert {path.read_bytes() for path in own} == {b"neither netCDF nor packed"}
    assert main(["verify", "small.yaml"]) == 0
