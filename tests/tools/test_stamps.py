import hashlib
import json
import os
import threading

import netCDF4
import numpy as np
import pytest
from tools.test_files import rao, rewritten

from vsb.errors import DatabaseError
from vsb.study.blocks import panel_solver
from vsb.tools.files import load, locked, save, sealed, write_text
from vsb.tools.stamps import Stamp, faults, read_manifest, read_text, record, stamp_file

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


def test_what_was_written_is_sound_also_in_another_place(place):
    assert found(place) == {}
    assert found(place.rename(place.with_name("elsewhere"))) == {}


def test_a_manifest_holds_names_from_its_folder_on(place):
    stored = json.loads((place / "manifest.json").read_text())
    assert list(stored) == ["figures/power.svg", "table.csv"]
    text = (place / "table.csv").read_bytes()
    assert stored["table.csv"] == {"spec_id": ID, "checksum": hashlib.sha256(text).hexdigest(), "size": len(text)}


def test_what_another_specification_made_is_stale(place):
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
    """A file of before the stamps."""
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
        ("run.nc", undone, "stale"),
    ],
)
def test_damage_is_found_also_with_the_old_time(place, name, damage, kind):
    times = (place / name).stat()
    damage(place / name)
    os.utime(place / name, ns=(times.st_atime_ns, times.st_mtime_ns))
    assert found(place) == {os.path.basename(name): kind}


def test_a_product_without_a_stamp_is_stale(place):
    (place / "manifest.json").unlink()
    assert read_manifest(place / "manifest.json") == {}
    assert found(place) == {"table.csv": "nameless", "power.svg": "nameless"}


def test_a_text_is_read_only_if_it_is_the_one_promised(place):
    table, manifest = place / "table.csv", place / "manifest.json"
    assert read_text(table, manifest, ID).startswith("design,power")
    with pytest.raises(DatabaseError, match=r"table.csv: is of 'a{16}', needs 'b{16}'; delete it, or let vsb verify"):
        read_text(table, manifest, OTHER)
    other = table.rename(table.with_name("copied.csv"))
    with pytest.raises(DatabaseError, match=r"copied.csv: is not in the manifest; delete it, or let vsb verify"):
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
def test_a_damaged_manifest_is_one_line_and_begun_anew_by_the_next_product(place, content):
    manifest = place / "manifest.json"
    manifest.write_text(content)
    with pytest.raises(DatabaseError, match=r"manifest.json: cannot be read as a manifest .*; delete it") as error:
        read_manifest(manifest)
    assert "\n" not in str(error.value)
    assert len(str(error.value)) < 400
    record(manifest, ID, [place / "table.csv"])
    assert read_manifest(manifest) == {str(place / "table.csv"): Stamp.of(place / "table.csv", ID)}


def test_what_is_no_file_is_no_manifest(place):
    (place / "manifest.json").unlink()
    (place / "manifest.json").mkdir()
    with pytest.raises(DatabaseError, match=r"manifest.json: cannot be read as a manifest .*Is a directory"):
        read_manifest(place / "manifest.json")


def test_meshes_of_all_studies_stand_beside_the_folder(place):
    """A manifest names what is in its study's folder, or beside that; `..` alone is no reason to doubt it."""
    shared = place.parent / "hydro" / "mean.vtu"
    write_text(shared, "<vtu/>")
    record(place / "manifest.json", ID, [shared])
    assert "../hydro/mean.vtu" in json.loads((place / "manifest.json").read_text())
    assert str(shared) in read_manifest(place / "manifest.json")


def test_products_that_are_gone_leave_the_manifest(place):
    (place / "figures" / "power.svg").unlink()
    record(place / "manifest.json", OTHER, [place / "table.csv"])
    assert read_manifest(place / "manifest.json") == {str(place / "table.csv"): Stamp.of(place / "table.csv", OTHER)}


def test_a_file_of_before_that_agrees_with_its_specification_is_stamped(tmp_path):
    spec, path = '{"stage":"radiation"}', tmp_path / "a.nc"
    identity = hashlib.sha256(spec.encode()).hexdigest()[:16]
    save(rao(np.ones((1, 3, 2))).assign_attrs(spec=spec, spec_id=identity), path)
    undone(path)
    times = os.stat(path).st_mtime_ns
    (fault,) = faults({str(path): identity}, {})
    assert fault.kind == "unstamped"
    stamp_file(path)
    assert faults({str(path): identity}, {}) == []
    assert load(path, expected=identity).equals(rao(np.ones((1, 3, 2))))
    assert os.stat(path).st_mtime_ns == times
    assert sealed(path)
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr("spec", '{"stage":"other"}')
        file.delncattr("checksum")
    (fault,) = faults({str(path): identity}, {})
    assert fault.kind == "stale"


def test_the_table_of_the_panel_solver_carries_its_name(tmp_path):
    """It is of no specification: the solver and its version are what it should be."""
    (tmp_path / "table.npz").write_bytes(b"table")
    record(tmp_path / "manifest.json", panel_solver(), [tmp_path / "table.npz"])
    (stamp,) = read_manifest(tmp_path / "manifest.json").values()
    assert stamp.spec_id == panel_solver()


def test_a_job_waits_until_another_has_written_its_stamps(place):
    """Both stand in the manifest: what is in it is read when nobody else writes it."""
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


def test_a_manifest_is_begun_with_its_folder(tmp_path):
    write_text(tmp_path / "a.csv", "x\n")
    record(tmp_path / "new" / "study" / "manifest.json", ID, [])
    assert read_manifest(tmp_path / "new" / "study" / "manifest.json") == {}
    record(tmp_path / "other" / "manifest.json", ID, [tmp_path / "a.csv"])
    assert list(read_manifest(tmp_path / "other" / "manifest.json")) == [str(tmp_path / "a.csv")]


def test_a_manifest_names_no_file_from_the_root_on(place):
    """Not even one of its own folder: it would be of the place the results once stood at."""
    (place / "manifest.json").write_text(entry(str(place / "table.csv")))
    with pytest.raises(DatabaseError, match=r"cannot be read as a manifest \('/.*delete it"):
        read_manifest(place / "manifest.json")


def test_what_stands_where_a_product_should_is_seen(place):
    """As a dangling name is none, a table whose name holds that of a netCDF file is a text."""
    table = place / "run.nc.csv"
    write_text(table, "x\n")
    record(place / "manifest.json", ID, [table])
    stamps = read_manifest(place / "manifest.json")
    assert faults({str(table): ID, str(place / "none.csv"): ID}, stamps) == []
    (fault,) = faults({str(table): OTHER}, stamps)
    assert fault == (str(table), "stale", f"is of {ID!r}, needs {OTHER!r}")


def test_faults_are_told_of_all_files_each_by_its_own_id(place):
    other = place / "other.nc"
    foreign(other)
    files = {str(place / "run.nc"): OTHER, str(other): OTHER, str(place / "table.csv"): OTHER}
    told = faults(files, read_manifest(place / "manifest.json"))
    assert [(os.path.basename(f.path), f.kind, f.reason) for f in told] == [
        (name, "stale", f"is of {ID!r}, needs {OTHER!r}") for name in ("run.nc", "table.csv")
    ]


def test_a_stamped_file_keeps_both_its_times(place):
    undone(place / "run.nc")
    os.utime(place / "run.nc", ns=(10**18, 2 * 10**18))
    stamp_file(place / "run.nc")
    assert os.stat(place / "run.nc").st_mtime_ns == 2 * 10**18
    assert load(place / "run.nc").attrs["checksum"]


@pytest.mark.parametrize(
    "spec_id", ["a" * 15, "a" * 17, "A" * 16, "capytaine 2.3 beta", "capytaine ", "capytaine 2.3\n", ""]
)
def test_an_id_that_no_product_has_makes_no_stamp(spec_id):
    with pytest.raises(ValueError, match="no stamp of an id, a checksum and a size"):
        Stamp(spec_id, "0" * 64, 1)
    assert Stamp("capytaine 2.3.1_dev", "0" * 64, 0).size == 0


@pytest.mark.parametrize("checksum", ["0" * 63, "0" * 65, "g" * 64, "A" * 64])
def test_a_checksum_that_is_none_makes_no_stamp(checksum):
    with pytest.raises(ValueError, match="no stamp of an id, a checksum and a size"):
        Stamp(ID, checksum, 1)


def test_a_stamp_that_is_written_again_is_the_new_one(place):
    """Of another specification, and of other contents."""
    table, before = place / "table.csv", read_manifest(place / "manifest.json")
    edited(table)
    record(place / "manifest.json", OTHER, [table])
    after = read_manifest(place / "manifest.json")
    assert after[str(table)] == Stamp.of(table, OTHER) != before[str(table)]
    assert len(after) == len(before) == 2
