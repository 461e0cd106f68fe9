"""Results as an RO-Crate: all files are there and are what the metadata say, which are those the specification asks."""

import hashlib
import json
import mimetypes
import os
import re
import shutil
import time
import urllib.parse
import zipfile
from pathlib import Path
from types import SimpleNamespace

import pytest
from conftest import SMALL_PLAN as PLAN
from stages.test_members import planned, with_seas

from vsb.cli import main
from vsb.errors import VsbError
from vsb.stages import crate as module
from vsb.stages.crate import METADATA, PROFILE, crate, metadata
from vsb.tools.stamps import Fault

CC = "https://creativecommons.org/licenses/by/4.0/"


def opened(path):
    """Contents by name, and entities by identifier."""
    with zipfile.ZipFile(path) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    return contents, {one["@id"]: one for one in json.loads(contents.pop(METADATA))["@graph"]}


@pytest.fixture(scope="module")
def archive(finished, tmp_path_factory):
    out = tmp_path_factory.mktemp("crate") / "small.zip"
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(finished)
        crate("small.yaml", str(out), CC, "A. Person")
    return opened(out)


def test_every_product_is_there_and_is_what_is_said_of_it(archive):
    contents, entities = archive
    root = Path(PLAN.root)
    names = {Path(path).relative_to(root).as_posix() for path in (*PLAN.products, PLAN.manifest)} | {"small.yaml"}
    assert set(contents) == names
    for name, content in contents.items():
        said = entities[urllib.parse.quote(name)]
        assert said["sha256"] == hashlib.sha256(content).hexdigest()
        assert said["contentSize"] == str(len(content))
        assert said["encodingFormat"] != "application/octet-stream", name
    assert entities[f"{PLAN.name}/report.html"]["identifier"] == PLAN.study_id
    assert "ledger" in entities[f"{PLAN.name}/validity.json"]["description"]


def test_the_root_has_what_the_specification_asks(archive):
    """RO-Crate 1.1: descriptor, root with name, description, date and licence, every file a part of it."""
    contents, entities = archive
    descriptor, root = entities[METADATA], entities["./"]
    assert (descriptor["about"], descriptor["conformsTo"]) == ({"@id": "./"}, {"@id": PROFILE})
    assert root["@type"] == "Dataset"
    assert root["name"]
    assert root["description"]
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", root["datePublished"])
    assert entities[root["license"]["@id"]]["@type"] == "CreativeWork"
    assert root["license"] == {"@id": CC}
    assert entities[root["author"]["@id"]]["name"] == "A. Person"
    assert {part["@id"] for part in root["hasPart"]} == {urllib.parse.quote(name) for name in contents}


def test_every_reference_leads_somewhere_and_the_run_says_what_made_what(archive):
    contents, entities = archive
    referred = re.findall(r'\{"@id": "([^"]+)"\}', json.dumps(list(entities.values())))
    assert set(referred) - set(entities) == {PROFILE}
    run = entities["#run"]
    assert entities[run["instrument"]["@id"]]["name"] == "vsb"
    assert run["object"] == {"@id": "small.yaml"}
    packed = {urllib.parse.quote(name) for name in contents}
    assert {one["@id"] for one in run["result"]} == packed - {"small.yaml"}


def test_the_command_writes_one_file_and_without_a_licence_says_so(small, tmp_path, capsys):
    out = tmp_path / "small.zip"
    assert main(["crate", "small.yaml", str(out)]) == 0
    assert re.fullmatch(rf"{out}: \d+ files, [\d.]+ MB\n", capsys.readouterr().out)
    entities = opened(out)[1]
    assert entities[entities["./"]["license"]["@id"]]["name"] == "not stated"
    assert "author" not in entities["./"]


@pytest.mark.parametrize(
    ("damage", "message"),
    [(Path.unlink, r"comparison\.csv: is not there; "), (lambda path: path.write_text("x"), r"comparison\.csv: ")],
)
def test_what_is_not_as_it_should_be_is_not_packed(finished, tmp_path, monkeypatch, damage, message):
    shutil.copytree(finished, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    damage(Path(PLAN.folder, "comparison.csv"))
    with pytest.raises(VsbError, match=message + r".*vsb run small\.yaml makes it"):
        crate("small.yaml", "small.zip")
    assert not Path("small.zip").exists()


def test_of_all_that_is_missing_the_first_is_told_and_the_others_are_counted(finished, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(finished / "small.yaml", "small.yaml")
    first, *others = sorted({*PLAN.products, PLAN.manifest})
    line = f"{first}: is not there (and {len(others)} more); vsb run small.yaml makes it"
    with pytest.raises(VsbError, match=f"^{re.escape(line)}$"):
        crate("small.yaml", "small.zip")


def test_results_of_a_campaign_are_named_so(tmp_path):
    plan, path = planned(with_seas(tmp_path, (1.0, 6.0))), tmp_path / "sweep.yaml"
    root = metadata(plan, {path.name: str(path)}, path.name, None, None)["@graph"][1]
    assert root["name"] == "campaign sweep: flexible against rigid in waves"


def test_the_metadata_are_a_text_people_can_read_dated_by_the_newest_file(small, tmp_path):
    """Letters of all languages as they are, an entry a line; results of a study are named so."""
    out, newest = tmp_path / "small.zip", max(Path(path).stat().st_mtime for path in PLAN.products)
    crate("small.yaml", str(out), author="Žofie Ångström")
    with zipfile.ZipFile(out) as archive:
        text = archive.read(METADATA).decode()
    assert text.endswith("\n}\n")
    assert "\n" in text[:3]
    assert "Žofie Ångström" in text
    root = opened(out)[1]["./"]
    assert root["name"] == "study small: flexible against rigid in waves"
    assert root["datePublished"] >= time.strftime("%Y-%m-%d", time.gmtime(newest))


def test_a_date_is_of_the_newest_file_alone(tmp_path):
    files = {name: str(tmp_path / name) for name in ("a.csv", "b.csv", "c.csv")}
    for day, path in zip((100, 300, 200), files.values(), strict=True):
        Path(path).write_text("1")
        os.utime(path, (86400 * day, 86400 * day))
    root = metadata(PLAN, files, "a.csv", None, None)["@graph"][1]
    assert root["datePublished"] == "1970-10-28"  # day 301 of that year
    assert root["license"] == {"@id": "#licence"}


def test_names_are_addresses_wherever_they_are_referred_to(tmp_path):
    """What the run was asked for by is its object and no result; a file nobody named has no identifier."""
    held = {name: str(tmp_path / f"{i}") for i, name in enumerate(("my study.yaml", "a b/c d.csv", "e.bin"))}
    for path in held.values():
        Path(path).write_text("1")
    root, run, *_ = metadata(PLAN, held, "my study.yaml", None, None)["@graph"][1:]
    assert [part["@id"] for part in root["hasPart"]] == ["my%20study.yaml", "a%20b/c%20d.csv", "e.bin"]
    assert run["object"] == {"@id": "my%20study.yaml"}
    assert run["result"] == [{"@id": "a%20b/c%20d.csv"}, {"@id": "e.bin"}]
    files = metadata(PLAN, held, "my study.yaml", None, None)["@graph"][-3:]
    assert [one["@id"] for one in files] == [part["@id"] for part in root["hasPart"]]
    assert [one["name"] for one in files] == ["my study.yaml", "c d.csv", "e.bin"]
    types = ["application/yaml", "text/csv", "application/octet-stream"]
    assert [one["encodingFormat"] for one in files] == types
    assert not any("identifier" in one or "description" in one for one in files)


@pytest.mark.parametrize("name", ["a.csv", "a.html", "a.json", "a.pdf", "a.svg"])
def test_types_are_those_the_internet_registered(tmp_path, name):
    (tmp_path / name).write_text("1")
    one = metadata(PLAN, {name: str(tmp_path / name)}, "other", None, None)["@graph"][-1]
    assert one["encodingFormat"] == mimetypes.guess_type(name)[0]


def test_what_is_told_of_an_archive_is_its_files_and_its_size(small, tmp_path):
    out = tmp_path / "small.zip"
    (line,) = crate("small.yaml", str(out))
    count = len({*PLAN.products, PLAN.manifest}) + 1
    assert line == f"{out}: {count} files, {out.stat().st_size / 1e6:.1f} MB"


def test_what_is_damaged_counts_beside_what_is_missing(tmp_path, monkeypatch):
    """What is missing first; the same of a study whose files are all there."""
    there = tmp_path / "there.csv"
    there.touch()
    plan = SimpleNamespace(products=[str(there), "lost.csv"], manifest="also.json")
    found = [Fault("a.nc", "stale", "of another study"), Fault("b.nc", "damaged", "its contents are not")]
    monkeypatch.setattr(module, "plan_of", lambda config: plan)
    monkeypatch.setattr(module, "study_faults", lambda of: found)
    with pytest.raises(VsbError, match=r"^also\.json: is not there \(and 3 more\); vsb run x\.yaml makes it$"):
        crate("x.yaml", "x.zip")
    plan.products, plan.manifest = [str(there)], str(there)
    with pytest.raises(VsbError, match=r"^a\.nc: of another study \(and 1 more\); vsb run x\.yaml makes it$"):
        crate("x.yaml", "x.zip")
    found.pop()
    with pytest.raises(VsbError, match=r"^a\.nc: of another study; vsb run x\.yaml makes it$"):
        crate("x.yaml", "x.zip")


@pytest.mark.parametrize(("zone", "seconds"), [("UTC", 40), ("EST5", 40), ("NZST-12", 86000)])
def test_a_date_is_that_of_greenwich_wherever_results_are_packed(tmp_path, monkeypatch, zone, seconds):
    """West of it the day before has not ended, east of it the next has begun."""
    (tmp_path / "a.csv").write_text("1")
    os.utime(tmp_path / "a.csv", (86400 * 300 + seconds,) * 2)
    with monkeypatch.context() as patch:
        patch.setenv("TZ", zone)
        time.tzset()
        root = metadata(PLAN, {"a.csv": str(tmp_path / "a.csv")}, "a.csv", None, None)["@graph"][1]
    time.tzset()
    assert root["datePublished"] == "1970-10-28"


def test_a_study_file_of_another_folder_lies_at_the_root_of_the_archive(small, tmp_path):
    """By its name alone; what it was asked for by is told so."""
    (tmp_path / "elsewhere").mkdir()
    shutil.copy("small.yaml", tmp_path / "elsewhere" / "my study.yaml")
    crate(str(tmp_path / "elsewhere" / "my study.yaml"), str(tmp_path / "small.zip"))
    contents, entities = opened(tmp_path / "small.zip")
    assert contents["my study.yaml"] == Path("small.yaml").read_bytes()
    assert not any("elsewhere" in name for name in contents)
    assert (entities["#run"]["name"], entities["#run"]["object"]) == (
        "vsb run my study.yaml",
        {"@id": "my%20study.yaml"},
    )
    assert "made from my study.yaml;" in entities["./"]["description"]
