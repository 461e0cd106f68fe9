"""Manifests of results: stale, damaged and missing products are found."""

import hashlib
import json
import os
import re
import threading

import numpy as np
import pytest
from tools.test_files import rao, rewritten

from vsb.errors import DatabaseError
from vsb.tools.files import locked, save, write_text
from vsb.tools.stamps import Stamp, faults, read_manifest, read_text, record

ID, OTHER = "a" * 16, "b" * 16


@pytest.fixture
def place(tmp_path):
    """A folder with a table, a figure and a trajectory, their stamps where they belong."""
    write_text(tmp_path / "table.csv", "design,power\nFSB,364.0\n")
    write_text(tmp_path / "figures" / "power.svg", "<svg/>")
    record(tmp_path / "manifest.json", ID, [tmp_path / "table.csv", tmp_path / "figures" / "power.svg"])
    save(rao(np.ones((1, 3, 2))).assign_attrs(spec_id=ID), tmp_path / "run.nc")
    return tmp_path


def found(place, expected=ID):
    files = {str(place / name): expected for name in ("table.csv", "figures/power.svg", "run.nc", "none.nc")}
    return {os.path.basename(f.path): f.kind for f in faults(files, read_manifest(place / "manifest.json"))}


def test_manifest_holds_relative_names(place):
    stored = json.loads((place / "manifest.json").read_text())
    assert list(stored) == ["figures/power.svg", "table.csv"]
    text = (place / "table.csv").read_bytes()
    assert stored["table.csv"] == {"spec_id": ID, "checksum": hashlib.sha256(text).hexdigest(), "size": len(text)}


def test_product_of_another_specification_is_stale(place):
    assert found(place, expected=OTHER) == dict.fromkeys(("table.csv", "power.svg", "run.nc"), "stale")


def cut(path):
    path.write_bytes(path.read_bytes()[:-5])


def edited(path):
    path.write_bytes(path.read_bytes().replace(b"364", b"729"))


def scaled(path):
    def change(file):
        file["rao"][:] = 2 * file["rao"][:]

    rewritten(path, change)


def to_nan(path):
    def change(file):
        file["rao"][0, 0, 0] = np.nan

    rewritten(path, change)


def foreign(path):
    save(rao(np.ones((1, 3, 2))).assign_attrs(spec_id=OTHER), path)


def unnamed(path):
    rewritten(path, lambda file: file.delncattr("spec_id"))


def undone(path):
    rewritten(path, lambda file: file.delncattr("checksum"))


@pytest.mark.parametrize(
    ("name", "damage", "kind"),
    [
        ("table.csv", cut, "damaged"),
        ("table.csv", edited, "damaged"),
        ("figures/power.svg", cut, "damaged"),
        ("run.nc", cut, "damaged"),
        ("run.nc", scaled, "damaged"),
        ("run.nc", to_nan, "damaged"),
        ("run.nc", foreign, "stale"),
        ("run.nc", unnamed, "damaged"),
        ("run.nc", undone, "damaged"),
    ],
)
def test_damage_is_found_even_with_the_old_modification_time(place, name, damage, kind):
    times = (place / name).stat()
    damage(place / name)
    os.utime(place / name, ns=(times.st_atime_ns, times.st_mtime_ns))
    assert found(place) == {os.path.basename(name): kind}


def test_product_without_an_entry_is_reported(place):
    (place / "manifest.json").unlink()
    assert read_manifest(place / "manifest.json") == {}
    assert found(place) == {"table.csv": "nameless", "power.svg": "nameless"}


def test_text_is_read_only_if_it_is_the_expected_one(place):
    table, manifest = place / "table.csv", place / "manifest.json"
    assert read_text(table, manifest, ID).startswith("design,power")
    with pytest.raises(DatabaseError, match=r"table.csv: is of 'a{16}', needs 'b{16}'; delete it and run again"):
        read_text(table, manifest, OTHER)
    other = table.rename(table.with_name("copied.csv"))
    with pytest.raises(DatabaseError, match=r"copied.csv: is not in the manifest; delete it and run again"):
        read_text(other, manifest, ID)
    other.rename(table)
    edited(table)
    with pytest.raises(DatabaseError, match=r"table.csv: its contents are not those it was written with .*; delete it"):
        read_text(table, manifest, ID)
    table.unlink()
    with pytest.raises(DatabaseError, match=r"table.csv: file not found; run the rule that makes it"):
        read_text(table, manifest, ID)


def entry(name="table.csv", **changes):
    return json.dumps({name: {"spec_id": ID, "checksum": "0" * 64, "size": 1, **changes}})


UNREADABLE = [
    *("", "{", "[]", "[" * 100_000, "9" * 100_000, '{"a": 1}', '{"a": {"size": 1}}', '{"\\u0000": {}}'),
    *(entry(spec_id="x"), entry(spec_id=5), entry(checksum=ID), entry(checksum=None), entry(size=-1), entry(size=True)),
    *(
        entry("../../precious.txt"),
        entry("/etc/hosts"),
        entry("figures/../../../precious.txt"),
        entry(**{"x" * 9999: 1}),
    ),
]


@pytest.mark.parametrize("content", UNREADABLE, ids=range(len(UNREADABLE)))
def test_damaged_manifest_is_one_line_and_written_anew(place, content):
    manifest = place / "manifest.json"
    manifest.write_text(content)
    with pytest.raises(DatabaseError, match=r"manifest.json: cannot be read as a manifest .*; delete it") as error:
        read_manifest(manifest)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 400
    assert not re.search("Expecting|JSON|argument|object|digits|Error|char ", str(error.value))  # of libraries
    record(manifest, ID, [place / "table.csv"])
    assert read_manifest(manifest) == {str(place / "table.csv"): Stamp.of(place / "table.csv", ID)}


def test_manifest_is_locked_while_it_is_written(place):
    write_text(place / "late.csv", "design\n")
    late = threading.Thread(target=record, args=(place / "manifest.json", ID, [place / "late.csv"]))
    with locked(place / ".manifest.json.lock"):
        stored = (place / "manifest.json").read_bytes()
        late.start()
        late.join(0.1)
        assert late.is_alive()
        assert (place / "manifest.json").read_bytes() == stored
    late.join()
    names = {os.path.basename(path) for path in read_manifest(place / "manifest.json")}
    assert names == {"late.csv", "power.svg", "table.csv"}
