import fcntl
import gzip
import os
import socket
import subprocess
import sys
import threading
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from vsb.errors import ConfigError, DatabaseError
from vsb.tools.files import (
    ROOT,
    attributes,
    check_file,
    check_folder,
    checksum,
    load,
    locked,
    read_groups,
    read_text,
    save,
    seal,
    seal_of,
    sealed,
    whole,
    write_text,
)
from vsb.tools.units import ATTRS, PAIR

FINITE = st.floats(-1e12, 1e12)


def rao(values):
    size = values.shape[1]
    return xr.Dataset(
        {"rao": (("design", "omega", "dof"), values)},
        coords={"design": ["A"], "omega": np.arange(size) + 1.0, "dof": ["Heave", "Membrane0"]},
    )


@settings(max_examples=20)
@given(hnp.arrays(float, (1, 3, 2), elements=FINITE), hnp.arrays(float, (1, 3, 2), elements=FINITE))
def test_complex_round_trip_on_disk_is_exact_and_has_units(tmp_path_factory, real, imag):
    path = tmp_path_factory.mktemp("nc") / "a.nc"
    ds = rao(real + 1j * imag)
    save(ds, path)
    back = load(path)
    assert np.array_equal(back.rao.values, ds.rao.values)
    assert back.rao.attrs["units"] == ATTRS["rao"].units
    with xr.open_dataset(path) as raw:
        assert raw.rao.dims[0] == "complex"
        assert list(raw.complex.values) == ["re", "im"]


def test_nan_is_never_written(tmp_path):
    ds = rao(np.full((1, 3, 2), np.nan))
    with pytest.raises(DatabaseError, match="variable rao holds NaN or infinite values"):
        save(ds, tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []


def test_unknown_variable_is_refused(tmp_path):
    with pytest.raises(DatabaseError, match=r"variables \['wobble'\] are not in ATTRS of vsb/tools/units.py"):
        save(xr.Dataset({"wobble": ("x", [1.0])}), tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("content", "message"), [(b"", "cannot be read as netCDF"), (b"CDF?junk", "cannot be read as netCDF")]
)
def test_corrupt_file(tmp_path, content, message):
    (tmp_path / "bad.nc").write_bytes(content)
    with pytest.raises(DatabaseError, match=message) as error:
        load(tmp_path / "bad.nc")
    assert "\n" not in str(error.value)


def test_what_a_library_says_nothing_of_is_told_by_its_kind(tmp_path, monkeypatch):
    save(rao(np.ones((1, 3, 2))), tmp_path / "a.nc")

    def fail(*_, **__):
        raise MemoryError

    monkeypatch.setattr(xr, "open_groups", fail)
    with pytest.raises(
        DatabaseError, match=r"a\.nc: cannot be read as netCDF \(MemoryError\); delete it and run again\.$"
    ):
        load(tmp_path / "a.nc")


@pytest.mark.parametrize(
    ("data", "at", "why"),
    [
        ({"annual_energy": ("x", [1.0])}, {}, r"Dimensions .* do not exist.*"),
        ({"rao": (("complex", "omega"), np.ones((2, 3)))}, {}, "dimension complex: received 0, 1, needs re, im"),
        ({"rao": (("complex", "omega"), np.ones((2, 3)))}, {"complex": ["a", "im"]}, ".* received a, im, needs re, im"),
        ({"rao": (("complex", "omega"), np.ones((1, 3)))}, {"complex": ["re"]}, ".* received re, needs re, im"),
        (
            {"rao": (("complex", "omega"), np.ones((2, 3)))},
            {"complex": ["re", "re"]},
            ".* received re, re, needs re, im",
        ),
    ],
)
def test_a_foreign_file_whose_names_are_ours_is_told_by_what_they_hold(tmp_path, data, at, why):
    xr.Dataset(data, at).to_netcdf(tmp_path / "foreign.nc")
    with pytest.raises(
        DatabaseError, match=rf"foreign\.nc: not a file of this project \({why}\); delete or move it and run again"
    ):
        load(tmp_path / "foreign.nc")


def test_foreign_and_missing_files(tmp_path):
    xr.Dataset({"sst": ("lat", [1.0])}).to_netcdf(tmp_path / "foreign.nc")
    with pytest.raises(DatabaseError, match=r"foreign.nc: not a file of this project .*sst"):
        load(tmp_path / "foreign.nc")
    with pytest.raises(DatabaseError, match=r"none.nc: file not found; run the rule that makes it"):
        load(tmp_path / "none.nc")


def test_text_is_replaced_whole(tmp_path):
    write_text(tmp_path / "sub" / "a.txt", "one")
    write_text(tmp_path / "sub" / "a.txt", "two")
    assert (tmp_path / "sub" / "a.txt").read_text() == "two"
    assert [p.name for p in (tmp_path / "sub").iterdir()] == ["a.txt"]


def test_what_a_killed_process_left_of_a_file_goes_when_it_is_written_again(tmp_path):
    """Not what somebody writes who lives, here or on another machine, nor what is left of another file."""
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    dead, alive, host = process.pid, os.getppid(), socket.gethostname()
    left = f".a[1].txt.{host}.{dead}.x1.tmp"
    kept = [
        f".a[1].txt.{host}.{alive}.x2.tmp", f".a[1].txt.other.{dead}.x3.tmp", f".b.txt.{host}.{dead}.x4.tmp",
        f".a[1].txt.{host}.nobody.x5.tmp", f".a[1].txt.{host}.{dead}.x6.txt",
    ]  # fmt: skip
    for name in (left, *kept):
        (tmp_path / name).write_text("half")
    write_text(tmp_path / "a[1].txt", "whole")
    assert {path.name for path in tmp_path.iterdir()} == {"a[1].txt", *kept}


def test_no_file_stays_open_behind_what_is_written(tmp_path):
    """The system gives the lowest number that is free."""
    free = []
    for _ in range(2):
        handle = os.open(os.devnull, os.O_RDONLY)
        os.close(handle)
        free.append(handle)
        write_text(tmp_path / "a.txt", "one")
    assert free[0] == free[1]


@pytest.mark.parametrize("write", [lambda path, x: write_text(path, x * 10**5), lambda path, x: save(longer(x), path)])
def test_whoever_reads_a_file_while_it_is_replaced_reads_the_old_one_whole(tmp_path, write, monkeypatch):
    """The new one is another file, complete when it takes the name: never the old one written over."""
    path, moved = tmp_path / "a", []
    write(path, "1")
    old, number, replace = path.read_bytes(), path.stat().st_ino, os.replace

    def moves(source, target):
        moved.append((Path(source).read_bytes(), Path(source).parent, os.fspath(target)))
        replace(source, target)

    monkeypatch.setattr("vsb.tools.files.os.replace", moves)
    with path.open("rb") as reader:
        write(path, "2")
        assert reader.read() == old
    assert path.stat().st_ino != number
    assert moved == [(path.read_bytes(), tmp_path, os.fspath(path))]
    assert moved[0][0] != old


def longer(x):
    return rao(np.full((1, 3, 2), float(x)))


HOLDER = """
import fcntl, sys
with open("a.lock", "a") as file:
    fcntl.flock(file, fcntl.LOCK_EX)
    print("held", flush=True)
    sys.stdin.read()
"""


def test_a_lock_keeps_another_process_waiting(tmp_path):
    """One that reads, changes and writes a file the others also refresh."""
    other = subprocess.Popen(
        [sys.executable, "-c", HOLDER], cwd=tmp_path, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert other.stdout.readline() == "held\n"
    done = []

    def refresh():
        with locked(tmp_path / "a.lock"):
            done.append("refreshed")

    waiting = threading.Thread(target=refresh)
    waiting.start()
    waiting.join(0.3)
    assert waiting.is_alive()
    other.stdin.close()
    waiting.join(60)
    other.wait(60)
    assert done == ["refreshed"]
    with locked(tmp_path / "a.lock"), (tmp_path / "a.lock").open() as another, pytest.raises(BlockingIOError):
        fcntl.flock(another, fcntl.LOCK_SH | fcntl.LOCK_NB)


@settings(max_examples=15)
@given(
    hnp.arrays(float, (2, 2), elements=FINITE),
    hnp.arrays(complex, (2, 1, 2), elements=st.complex_numbers(max_magnitude=1e9)),
)
def test_groups_round_trip_beside_the_main_dataset(tmp_path_factory, stiffness, force):
    path = tmp_path_factory.mktemp("nc") / "a.nc"
    dofs = ["Heave", "Membrane0"]
    main = xr.Dataset(
        {"hydrostatic_stiffness": (("influenced_dof", "radiating_dof"), stiffness)},
        coords={"influenced_dof": dofs, "radiating_dof": dofs},
    )
    group = xr.Dataset(
        {"excitation_force": (("omega", "wave_direction", "influenced_dof"), force)},
        coords={"omega": [1.0, 2.0], "wave_direction": [0.0], "influenced_dof": dofs},
    )
    save(main, path, groups={"tabulated": group})
    assert np.array_equal(load(path).hydrostatic_stiffness, stiffness)
    back = load(path, group="tabulated")
    assert np.array_equal(back.excitation_force, force)
    assert list(back.influenced_dof.values) == dofs
    assert back.omega.attrs["units"] == "rad/s"


def test_large_variables_are_compressed_without_loss(tmp_path):
    values = np.random.default_rng(1).standard_normal((1, 6000, 2)) + 1j
    save(rao(values), tmp_path / "a.nc")
    assert np.array_equal(load(tmp_path / "a.nc").rao.values, values)
    with xr.open_dataset(tmp_path / "a.nc") as raw:
        assert raw.rao.encoding["zlib"]


def test_a_failed_write_keeps_the_old_file_and_leaves_nothing_behind(tmp_path):
    save(rao(np.ones((1, 3, 2))), tmp_path / "a.nc")
    with pytest.raises(DatabaseError, match=r"a.nc:late: variable rao holds NaN"):
        save(rao(np.zeros((1, 3, 2))), tmp_path / "a.nc", groups={"late": rao(np.full((1, 3, 2), np.inf))})
    assert np.all(load(tmp_path / "a.nc").rao.values == 1.0)
    assert [p.name for p in tmp_path.iterdir()] == ["a.nc"]


def test_missing_group_is_one_line(tmp_path):
    save(rao(np.ones((1, 3, 2))), tmp_path / "a.nc")
    with pytest.raises(DatabaseError, match=r"a.nc: cannot be read as netCDF .*delete it and run again") as error:
        load(tmp_path / "a.nc", group="nowhere")
    assert "\n" not in str(error.value)


def test_what_cannot_be_written_is_one_line_and_loses_nothing(tmp_path):
    (tmp_path / "file").write_text("kept")
    (tmp_path / "folder").mkdir()
    for path, reason in (
        (tmp_path / "file" / "a.nc", f"{tmp_path / 'file'} is no folder"),
        (tmp_path / "file" / "deep" / "a.nc", f"{tmp_path / 'file'} is no folder"),
        (tmp_path / "folder", "it is a folder or a device"),
        (tmp_path / ("a" * 300), "File name too long"),
    ):
        for write in (lambda p: save(rao(np.ones((1, 3, 2))), p), lambda p: write_text(p, "new")):
            with pytest.raises(DatabaseError, match=r"cannot be written \(.*\); needs") as error:
                write(path)
            assert str(error.value).startswith(f"{path}: cannot be written ({reason}); needs ")
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "folder"]
    assert (tmp_path / "file").read_text() == "kept"


def test_a_device_is_never_replaced_by_a_file():
    with pytest.raises(
        DatabaseError, match=r"/dev/null: cannot be written \(it is a folder or a device\); needs a file"
    ):
        check_file("/dev/null")


def test_a_folder_that_is_not_there_yet_can_be_written(tmp_path, monkeypatch):
    check_folder(tmp_path / "new" / "deeper")
    check_file(tmp_path / "new" / "a.nc")
    monkeypatch.setattr("vsb.tools.files.os.access", lambda *_: False)  # root may write anywhere
    with pytest.raises(
        DatabaseError, match=f"new: cannot be written .no permission to write to {tmp_path}.; needs a folder"
    ):
        check_folder(tmp_path / "new")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("lacking", [os.W_OK, os.X_OK])
def test_a_folder_needs_both_permissions(tmp_path, monkeypatch, lacking):
    """One that may be written but not entered takes no file either."""
    monkeypatch.setattr("vsb.tools.files.os.access", lambda _, mode: not mode & lacking)
    with pytest.raises(DatabaseError, match="no permission to write"):
        check_folder(tmp_path)


def test_a_folder_whose_name_is_too_long_is_one_line(tmp_path):
    with pytest.raises(
        DatabaseError, match=r"cannot be written \(File name too long\); needs a folder you may write to"
    ):
        check_folder(tmp_path / ("a" * 300))


def stored(ds, path, groups=None):
    save(ds, path, groups)
    return read_groups(path)


@settings(max_examples=20, deadline=None)
@given(hnp.arrays(float, (1, 3, 2), elements=FINITE), st.integers(0, 11), st.integers(0, 63))
def test_the_checksum_is_of_every_bit_of_every_value(tmp_path_factory, values, place, bit):
    groups = stored(rao(values + 1j), tmp_path_factory.mktemp("nc") / "a.nc")
    before = checksum(groups)
    assert before == groups[ROOT].attrs["checksum"]
    bits = groups[ROOT].rao.values.reshape(-1).view(np.uint64)
    bits[place] ^= np.uint64(1 << bit)
    assert checksum(groups) != before


@pytest.mark.parametrize(
    "change",
    [
        lambda ds: ds.rename(rao="absorbed_power"),
        lambda ds: ds.rename(dof="shape_dof"),
        lambda ds: ds.assign_attrs(design="B"),
        lambda ds: ds.assign_attrs(steps=4),
        lambda ds: ds.assign_attrs(step=0.25),
        lambda ds: ds.assign_coords(dof=["Heave", "Membrane1"]),
        lambda ds: ds.drop_vars("omega"),
        lambda ds: ds.isel(dof=[1, 0]),
        lambda ds: ds.astype(np.float32),
        lambda ds: ds.assign(rao=ds.rao.assign_attrs(units="m")),
    ],
)
def test_the_checksum_is_of_names_dimensions_attributes_and_coordinates(change):
    ds = rao(np.arange(6.0).reshape(1, 3, 2)).assign_attrs(design="A", steps=3, step=0.1)
    assert checksum({ROOT: change(ds)}) != checksum({ROOT: ds}) == checksum({ROOT: ds.assign_attrs(checksum="x")})
    assert len({checksum(groups) for groups in ({ROOT: ds}, {"a": ds}, {ROOT: ds, "a": ds}, {})}) == 4


def test_the_checksum_tells_coordinates_from_variables_and_dimensions_of_one_size_apart(tmp_path):
    values = np.arange(4.0).reshape(2, 2)
    ds = xr.Dataset({"added_mass_inf": (PAIR, values), "azimuthal_order": (PAIR[0], [0.0, 1.0])})
    others = [
        ds.set_coords("azimuthal_order"),
        ds.assign(added_mass_inf=(PAIR[::-1], values)),
        ds.assign(azimuthal_order=(PAIR[1], [0.0, 1.0])),
        ds.assign(azimuthal_order=((*PAIR[:1], "one"), [[0.0], [1.0]])),
        ds.assign(azimuthal_order=(PAIR[0], [0, 1])),
        ds.assign(azimuthal_order=(PAIR[0], ["0.0", "1.0"])),
    ]
    assert len({checksum({ROOT: one}) for one in (ds, *others)}) == 7
    save(others[0], tmp_path / "a.nc")
    assert list(read_groups(tmp_path / "a.nc")[ROOT].coords) == ["azimuthal_order"]


def test_the_checksum_knows_no_order_of_names():
    ds = xr.Dataset({"b": ("t", np.arange(3.0)), "a": ("t", np.ones(3))}, {"t": np.arange(3)}, {"z": 1, "y": 2})
    turned = xr.Dataset({"a": ds.a.variable, "b": ds.b.variable}, {"t": ds.t}, {"y": 2, "z": 1})
    assert list(ds.variables) != list(turned.variables)
    assert checksum({ROOT: ds, "a": ds}) == checksum({"a": turned, ROOT: turned})


@pytest.mark.parametrize(
    "value",
    [3, 0.1, np.int64(3), np.float32(0.1), "text", "", "ü", [1], [1.0, 2.0], ["a", "b"], np.arange(3)],
    ids=repr,
)
def test_attributes_of_every_kind_are_the_same_after_they_were_on_disk(tmp_path, value):
    save(rao(np.ones((1, 3, 2))).assign_attrs(value=value), tmp_path / "a.nc")
    assert checksum(read_groups(tmp_path / "a.nc")) == load(tmp_path / "a.nc").attrs["checksum"]


def rewritten(path, change):
    with netCDF4.Dataset(path, "a") as file:
        change(file)


@pytest.mark.parametrize("group", ["a", None])
def test_contents_that_are_not_those_written_are_refused(tmp_path, group):
    path = tmp_path / "a.nc"
    save(rao(np.ones((1, 3, 2))), path, groups={"a": rao(np.ones((1, 3, 2)))})

    def soften(file):
        (file["a"] if group else file)["rao"][0, 1, 1] *= 1.3

    rewritten(path, soften)
    with pytest.raises(
        DatabaseError, match=r"a.nc: its contents are not those .*; delete it, or let vsb verify --heal"
    ):
        load(path)


def test_a_file_is_the_one_expected_or_refused(tmp_path):
    path = tmp_path / "a.nc"
    save(rao(np.ones((1, 3, 2))).assign_attrs(spec_id="a" * 16), path)
    assert load(path, expected="a" * 16).equals(rao(np.ones((1, 3, 2))))
    with pytest.raises(DatabaseError, match=r"a.nc: holds 'a{16}', needs 'b{16}': stale or foreign; delete it, or let"):
        load(path, expected="b" * 16)
    rewritten(path, lambda file: file.delncattr("checksum"))
    assert load(path).equals(rao(np.ones((1, 3, 2))))  # of before the stamps
    with pytest.raises(DatabaseError, match=r"a.nc: carries no checksum of its contents; delete it"):
        load(path, expected="a" * 16)


def test_the_seal_is_behind_what_others_read_and_they_drop_it(tmp_path):
    path = tmp_path / "a.nc"
    save(rao(np.ones((1, 3, 2))), path)
    assert sealed(path)
    with netCDF4.Dataset(path) as file:
        assert list(file["dof"][:]) == ["Heave", "Membrane0"]
    assert attributes(path) == load(path).attrs
    rewritten(path, lambda file: file["rao"].setncattr("remark", "x"))
    assert not sealed(path)
    with pytest.raises(DatabaseError, match=r"a.nc: its contents are not those it was written with .checksum."):
        attributes(path)


def test_words_of_a_file_that_begin_like_its_seal_are_none(tmp_path):
    ds = rao(np.ones((1, 3, 2))).assign_attrs(remark="sha256:" + "a" * 64)
    save(ds, tmp_path / "a.nc")
    assert sealed(tmp_path / "a.nc")
    assert load(tmp_path / "a.nc").attrs["remark"] == ds.attrs["remark"]


@pytest.mark.parametrize("lost", [1, 40, 70, 71, 500])
def test_a_cut_file_is_found_or_has_lost_nothing(tmp_path, lost):
    path = tmp_path / "a.nc"
    save(rao(np.ones((1, 3, 2))), path)
    path.write_bytes(path.read_bytes()[:-lost])
    if lost in (70, 71):  # nothing that says it was sealed
        assert load(path).equals(rao(np.ones((1, 3, 2))))
    else:
        with pytest.raises(DatabaseError, match=r"a.nc: (its contents|cannot be read as netCDF)"):
            load(path)


def test_no_flipped_bit_changes_a_value_unseen(tmp_path):
    rng = np.random.default_rng(7)
    path = tmp_path / "a.nc"
    save(rao(rng.standard_normal((1, 30, 2))).assign_attrs(spec_id="a" * 16), path)
    good, reference, caught = path.read_bytes(), load(path), 0
    for bit in rng.integers(8 * len(good), size=60):
        bad = bytearray(good)
        bad[bit // 8] ^= 1 << (bit % 8)
        path.write_bytes(bad)
        try:
            assert load(path, expected="a" * 16).identical(reference), bit
        except DatabaseError as error:
            assert "\n" not in str(error)  # noqa: PT017
            caught += 1
    assert caught >= 59  # the word that begins the seal may be lost: then the checksum decides


FULL = """
import resource, sys

import numpy as np
from tools.test_files import rao
from vsb.errors import ConfigError, DatabaseError
from vsb.tools.files import save, write_text
resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))
for write in (lambda: write_text("a.txt", "new" * 10**5), lambda: save(rao(np.random.rand(1, 6000, 2)), "a.nc")):
    try:
        write()
    except DatabaseError as error:
        print(error)
"""


def test_a_full_disk_keeps_the_old_files(tmp_path):
    write_text(tmp_path / "a.txt", "old")
    save(rao(np.ones((1, 3, 2))), tmp_path / "a.nc")
    path = os.pathsep.join(map(str, Path(__file__).parents[1:3]))
    done = subprocess.run(
        [sys.executable, "-c", FULL],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    text, data = done.stdout.splitlines()
    assert text == "a.txt: cannot be written (File too large); needs space in a folder you may write to"
    assert data.startswith("a.nc: cannot be written (")
    assert (tmp_path / "a.txt").read_text() == "old"
    assert np.all(load(tmp_path / "a.nc").rao.values == 1.0)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.nc", "a.txt"]


def test_a_mistake_while_writing_is_not_the_users(tmp_path):
    with pytest.raises(ZeroDivisionError, match="division by zero"), whole(tmp_path / "a.txt") as temporary:
        temporary.write_text(str(1 / 0))
    assert list(tmp_path.iterdir()) == []


def test_what_is_written_may_be_read_by_all_and_changed_by_its_owner(tmp_path):
    """A temporary file is its owner's alone: results are for colleagues, too."""
    write_text(tmp_path / "a.txt", "one")
    save(rao(np.ones((1, 3, 2))), tmp_path / "a.nc")
    assert [(tmp_path / name).stat().st_mode & 0o777 for name in ("a.txt", "a.nc")] == [0o644, 0o644]


def test_a_file_without_a_content_id_is_not_the_one_expected(tmp_path):
    path = tmp_path / "a.nc"
    save(rao(np.ones((1, 3, 2))), path)
    assert load(path).attrs.keys() == {"checksum"}
    with pytest.raises(DatabaseError, match=rf"{path}: holds None, needs 'b{{16}}': stale or foreign; delete it"):
        load(path, expected="b" * 16)


def test_words_like_a_seal_before_the_end_of_a_file_without_one_are_words(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(
        b"sha256:" + b"a" * 64 + b" is no seal, as it does not stand at the end: 71 bytes from there on do not hold it"
    )
    assert not sealed(path)
    path.write_bytes(path.read_bytes() + b"sha256:" + b"a" * 64)
    with pytest.raises(
        DatabaseError, match=r"a: its contents are not those it was written with \(checksum\); delete it"
    ):
        sealed(path)


MARKED = "Höhe [m]\n1.5\n"


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be-sig"])
def test_a_text_of_others_is_read_packed_or_not_whatever_its_mark_and_name(tmp_path, encoding, packed):
    data = b"\xfe\xff" + MARKED.encode("utf-16-be") if encoding == "utf-16-be-sig" else MARKED.encode(encoding)
    (tmp_path / "a.dat").write_bytes(gzip.compress(data) if packed else data)
    assert read_text(tmp_path / "a.dat") == MARKED


@pytest.mark.parametrize(
    "damage", [lambda x: x[:-9], lambda x: x[:14] + b"\xff" * 40 + x[54:], lambda x: x[:-8] + 8 * b"x"]
)
def test_a_packed_text_that_is_cut_or_damaged_is_told_so(tmp_path, damage):
    path = tmp_path / "a.gz"
    path.write_bytes(damage(gzip.compress(np.random.default_rng(1).bytes(200).hex().encode())))
    with pytest.raises(ConfigError, match=r"a.gz: received a packed file that is cut or damaged, needs a whole one$"):
        read_text(path)


def test_a_text_that_is_none_is_told_by_its_first_byte_that_is_not(tmp_path):
    (tmp_path / "a").write_bytes(b"H\xc3\xb6he, gr\xf6\xdf")
    with pytest.raises(ConfigError, match=r"a: received byte 9 that is no text, needs UTF-8: save it as CSV UTF-8 or"):
        read_text(tmp_path / "a")
    with pytest.raises(ConfigError, match=r"none: cannot be read \(No such file or directory\)$"):
        read_text(tmp_path / "none")


@pytest.mark.parametrize(("count", "compressed"), [(5000, False), (5001, True)])
def test_variables_of_more_than_ten_thousand_values_are_compressed(tmp_path, count, compressed):
    save(rao(np.ones((1, count, 2))), tmp_path / "a.nc")
    with xr.open_dataset(tmp_path / "a.nc") as raw:
        assert bool(raw.rao.encoding["zlib"]) is compressed


def test_the_checksum_is_that_of_values_whatever_the_order_of_their_bytes():
    one = rao(np.arange(6.0).reshape(1, 3, 2))
    turned = one.assign(rao=(one.rao.dims, one.rao.values.astype(">f8")))
    assert checksum({ROOT: one}) == checksum({ROOT: turned})


def test_what_a_library_says_in_several_lines_is_told_in_one(tmp_path, monkeypatch):
    save(rao(np.ones((1, 3, 2))), tmp_path / "a.nc")

    def fail(*_, **__):
        raise ValueError("one\n  and another")

    monkeypatch.setattr(xr, "open_groups", fail)
    with pytest.raises(DatabaseError, match=r"a\.nc: cannot be read as netCDF \(one and another\); delete it and run"):
        load(tmp_path / "a.nc")


@pytest.mark.parametrize("size", [0, 1, 2**16 + 1, 2**20 + 1, 2**23 + 3])
def test_a_seal_is_of_all_of_a_file_however_large(tmp_path, size):
    content = np.arange(size, dtype=np.uint32).astype(np.uint8).tobytes()
    path = tmp_path / "large.nc"
    path.write_bytes(content)
    seal(path)
    assert path.read_bytes() == content + seal_of(content)
    assert sealed(path)
    for place in {0, size // 2, size - 1} if size else ():
        changed = bytearray(content + seal_of(content))
        changed[place] ^= 1
        path.write_bytes(changed)
        with pytest.raises(DatabaseError, match=r"large\.nc"):
            sealed(path)
