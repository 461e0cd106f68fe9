"""Results packed as an RO-Crate 1.1."""

import hashlib
import json
import re
import shutil
import urllib.parse
import zipfile
from pathlib import Path

import pytest
from conftest import SMALL_PLAN as PLAN

from vsb.errors import VsbError
from vsb.stages.crate import PROFILE, crate
from vsb.tools.stamps import CRATE

CC = "https://creativecommons.org/licenses/by/4.0/"


def opened(path):
    """Contents by name, and entities by identifier."""
    with zipfile.ZipFile(path) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    return contents, {one["@id"]: one for one in json.loads(contents.pop(CRATE))["@graph"]}


@pytest.fixture(scope="module")
def archive(finished, tmp_path_factory):
    out = tmp_path_factory.mktemp("crate") / "small.zip"
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(finished)
        crate("small.yaml", str(out), CC, "A. Person")
    return opened(out)


def test_crate_holds_every_product_with_its_checksum(archive):
    contents, entities = archive
    root = Path(PLAN.root)
    held = (*PLAN.products, PLAN.manifest, f"{PLAN.display_folder}/manifest.json")
    names = {Path(path).relative_to(root).as_posix() for path in held} | {"small.yaml"}
    assert set(contents) == names
    for name, content in contents.items():
        said = entities[urllib.parse.quote(name)]
        assert said["sha256"] == hashlib.sha256(content).hexdigest()
        assert said["contentSize"] == str(len(content))
        assert said["encodingFormat"] != "application/octet-stream", name
    assert entities[f"{PLAN.name}/report.html"]["identifier"] == PLAN.study_id
    assert "ledger" in entities[f"{PLAN.name}/validity.json"]["description"]


def test_root_entity_follows_ro_crate_1_1(archive):
    """Descriptor; root with name, description, date and licence; every file is a part of it."""
    contents, entities = archive
    descriptor, root = entities[CRATE], entities["./"]
    assert (descriptor["about"], descriptor["conformsTo"]) == ({"@id": "./"}, {"@id": PROFILE})
    assert root["@type"] == "Dataset"
    assert root["name"]
    assert root["description"]
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", root["datePublished"])
    assert entities[root["license"]["@id"]]["@type"] == "CreativeWork"
    assert root["license"] == {"@id": CC}
    assert entities[root["author"]["@id"]]["name"] == "A. Person"
    assert {part["@id"] for part in root["hasPart"]} == {urllib.parse.quote(name) for name in contents}


@pytest.mark.parametrize(
    ("damage", "message"),
    [(Path.unlink, r"comparison\.csv: is not there; "), (lambda path: path.write_text("x"), r"comparison\.csv: ")],
)
def test_missing_or_damaged_results_are_not_packed(finished, tmp_path, monkeypatch, damage, message):
    shutil.copytree(finished, tmp_path / "copy")
    monkeypatch.chdir(tmp_path / "copy")
    damage(Path(PLAN.folder, "comparison.csv"))
    with pytest.raises(VsbError, match=message + r".*vsb run small\.yaml makes it"):
        crate("small.yaml", "small.zip")
    assert not Path("small.zip").exists()


def test_an_archive_is_named_as_one(finished, monkeypatch):
    monkeypatch.chdir(finished)
    with pytest.raises(VsbError, match=r"own\.csv: received a name without \.zip"):
        crate("small.yaml", "own.csv")
