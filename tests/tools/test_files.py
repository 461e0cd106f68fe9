"""Files: exact round trips, checksums, damage, atomic writes, locks."""

import fcntl
import gzip
import itertools
import os
import signal
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

import vsb.engine.motion.variables  # noqa: F401  (registers rao)
from vsb.cli import main
from vsb.errors import DatabaseError
from vsb.tools.files import (
    ROOT,
    bounded_memory,
    bounded_time,
    checksum,
    load,
    locked,
    read_bounded,
    read_text,
    read_unpacked,
    save,
    write_text,
)
from vsb.tools.variables import VARIABLES

FINITE = st.floats(-1e12, 1e12)


def rao(values):
    size = values.shape[1]
    return xr.Dataset(
        {"rao": (("design", "omega", "dof"), values)},
        coords={"design": ["A"], "omega": np.arange(size) + 1.0, "dof": ["Heave", "Membrane0"]},
    )


@settings(max_examples=8)
@given(hnp.arrays(float, (1, 3, 2), elements=FINITE), hnp.arrays(float, (1, 3, 2), elements=FINITE))
def test_complex_round_trip_on_disk_is_exact_and_has_units(tmp_path_factory, real, imag):
    path = tmp_path_factory.mktemp("nc") / "a.nc"
    ds = rao(real + 1j * imag)
    save(ds, path)
    back = load(path)
    assert np.array_equal(back.rao.values, ds.rao.values)
    assert back.rao.attrs["units"] == VARIABLES["rao"].units
    with xr.open_dataset(path) as raw:
        assert raw.rao.dims[0] == "complex"
        assert list(raw.complex.values) == ["re", "im"]


def test_unknown_variable_is_refused(tmp_path):
    with pytest.raises(DatabaseError, match=r"variables \['wobble'\] are unknown; register them in variables.py"):
        save(xr.Dataset({"wobble": ("x", [1.0])}), tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []


def test_foreign_and_missing_files(tmp_path):
    xr.Dataset({"sst": ("lat", [1.0])}).to_netcdf(tmp_path / "foreign.nc")
    with pytest.raises(DatabaseError, match=r"foreign.nc: not a file of this project .*sst"):
        load(tmp_path / "foreign.nc")
    with pytest.raises(DatabaseError, match=r"none.nc: file not found; run the rule that makes it"):
        load(tmp_path / "none.nc")


def test_leftovers_of_a_killed_process_are_removed(tmp_path):
    """Not those of a living process, another machine or another file."""
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


HOLDER = """
import fcntl, sys
with open("a.lock", "a") as file:
    fcntl.flock(file, fcntl.LOCK_EX)
    print("held", flush=True)
    sys.stdin.read()
"""


def test_lock_blocks_another_process(tmp_path):
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


def test_failed_write_keeps_the_old_file(tmp_path):
    save(rao(np.ones((1, 3, 2))), tmp_path / "a.nc")
    with pytest.raises(DatabaseError, match=r"a.nc:late: variable rao holds NaN"):
        save(rao(np.zeros((1, 3, 2))), tmp_path / "a.nc", groups={"late": rao(np.full((1, 3, 2), np.inf))})
    assert np.all(load(tmp_path / "a.nc").rao.values == 1.0)
    assert [p.name for p in tmp_path.iterdir()] == ["a.nc"]


@pytest.mark.parametrize(
    "change",
    [
        lambda ds: ds.rename(rao="absorbed_power"),
        lambda ds: ds.rename(dof="shape_dof"),
        lambda ds: ds.assign_attrs(design="B"),
        lambda ds: ds.assign_coords(dof=["Heave", "Membrane1"]),
        lambda ds: ds.drop_vars("omega"),
        lambda ds: ds.isel(dof=[1, 0]),
        lambda ds: ds.astype(np.float32),
        lambda ds: ds.assign(rao=ds.rao.assign_attrs(units="m")),
    ],
)
def test_checksum_covers_names_dimensions_attributes_and_coordinates(change):
    ds = rao(np.arange(6.0).reshape(1, 3, 2)).assign_attrs(design="A", steps=3, step=0.1)
    assert checksum({ROOT: change(ds)}) != checksum({ROOT: ds}) == checksum({ROOT: ds.assign_attrs(checksum="x")})
    assert len({checksum(groups) for groups in ({ROOT: ds}, {"a": ds}, {ROOT: ds, "a": ds}, {})}) == 4


def rewritten(path, change):
    with netCDF4.Dataset(path, "a") as file:
        change(file)


def test_file_of_another_id_is_refused(tmp_path):
    path = tmp_path / "a.nc"
    save(rao(np.ones((1, 3, 2))).assign_attrs(spec_id="a" * 16), path)
    assert load(path, expected="a" * 16).equals(rao(np.ones((1, 3, 2))))
    with pytest.raises(DatabaseError, match=r"a.nc: holds 'a{16}', needs 'b{16}': stale or foreign; delete it and run"):
        load(path, expected="b" * 16)
    rewritten(path, lambda file: file.delncattr("checksum"))
    assert load(path).equals(rao(np.ones((1, 3, 2))))  # of before the stamps
    with pytest.raises(DatabaseError, match=r"a.nc: carries no checksum of its contents; delete it"):
        load(path, expected="a" * 16)


def test_flipped_bits_are_detected(tmp_path):
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


MARKED = "Höhe [m]\n1.5\n"


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be-sig"])
def test_text_is_read_in_any_encoding_packed_or_not(tmp_path, encoding, packed):
    data = b"\xfe\xff" + MARKED.encode("utf-16-be") if encoding == "utf-16-be-sig" else MARKED.encode(encoding)
    (tmp_path / "a.dat").write_bytes(gzip.compress(data) if packed else data)
    assert read_text(tmp_path / "a.dat") == MARKED


linux = pytest.mark.skipif(sys.platform != "linux", reason="memory is bounded on Linux only")


@linux
def test_memory_beyond_the_bound_raises():
    with bounded_memory(2**28):
        small = np.zeros(2**20)
        with pytest.raises(MemoryError):
            np.zeros(2**28)
    assert len(np.empty(2**28)) == 2**28  # the bound is gone
    assert small.any() == 0


def test_time_beyond_the_bound_raises():
    before = signal.getsignal(signal.SIGALRM)
    with pytest.raises(TimeoutError, match=r"it takes more than 0.05 s"), bounded_time(0.05):
        sum(1 for _ in itertools.count())
    assert signal.getsignal(signal.SIGALRM) is before
    with bounded_time(60.0):
        pass  # done in time: no alarm rings later
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pipes with names")
@pytest.mark.parametrize("command", ["check", "import-wamit", "export"])
def test_a_pipe_or_a_device_in_the_place_of_a_file_is_refused_and_not_waited_for(
    tmp_path, monkeypatch, capsys, command
):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.1")
    for name in ("pipe.1", "/dev/zero"):
        link = Path("in.nc" if command == "export" else "in.1")
        link.unlink(missing_ok=True)
        link.symlink_to(name)
        given = {"check": [str(link)], "import-bemio": [str(link), "o.nc"], "import-wamit": [".", "in", "o.nc"]}
        assert main([command, *given.get(command, [str(link), "out"])]) == 2
        assert capsys.readouterr().err.count("\n") == 1


def test_a_file_holds_no_more_than_it_may_packed_or_not(tmp_path, monkeypatch):
    path = tmp_path / "a"
    path.write_bytes(b"x" * 5)
    assert read_bounded(path, 5) == b"x" * 5
    with pytest.raises(OSError, match="it holds more than"):
        read_bounded(path, 4)
    monkeypatch.setattr("vsb.tools.files.LARGEST", 2**20)
    path.write_bytes(gzip.compress(b"0" * (2**20 + 1), 1))
    with pytest.raises(OSError, match="it holds more than 1 MiB"):
        read_unpacked(path)
