"""Packed datasets: exact, reproducible, and refused when damaged or stale."""

import io

import numpy as np
import pytest
import xarray as xr

import vsb.results.variables  # noqa: F401  (registers where results may be missing)
from vsb.errors import DatabaseError
from vsb.tools import packed
from vsb.tools.files import seal_of


@pytest.fixture
def dataset():
    values = {
        "margin": ((), -0.25),
        "viable": ("design", np.array([True, False])),
        "reason": ("design", np.array(["", "unstable: 3 N/m"], dtype=object)),
        "annual_energy": (("design", "tuning"), np.array([[1.5], [np.nan]])),
        "count": (("hs", "te"), np.arange(6).reshape(2, 3)),
    }
    at = {"design": ["FSB", "VSWEC"], "tuning": ["one"], "hs": [0.25, 0.75]}
    at |= {"device.radius": 2.0, "drawn_hs": ("design", [1.25, 0.75])}  # coordinates no dimension is called by
    return xr.Dataset(values, coords=at, attrs={"spec_id": "0123456789abcdef", "spec": "{}"})


NAME = "0123456789abcdef"


@pytest.fixture
def pack(dataset, tmp_path):
    found = packed.Pack(tmp_path / "one.pack")
    found.append(dataset)
    return found


def test_datasets_round_trip_from_a_file_that_grows(dataset, pack):
    other = dataset.assign(margin=0.5).assign_attrs(spec_id="f" * 16)
    packed.Pack(pack.path).append(other)
    found = packed.packs(pack.path.parent)
    assert {*found} == {NAME, "f" * 16}
    for one in (dataset, other):
        read = found[one.attrs["spec_id"]].read(one.attrs["spec_id"])
        assert read.attrs == one.attrs
        assert set(read.coords) == set(one.coords)
        for name, variable in one.variables.items():
            assert read[name].dims == variable.dims
            np.testing.assert_array_equal(read[name].values, variable.values)


def test_what_a_killed_writer_left_is_written_over(dataset, pack):
    whole = pack.path.read_bytes()
    packed.Pack(pack.path).append(dataset.assign_attrs(spec_id="f" * 16))
    twice = pack.path.read_bytes()
    for left in (len(whole) + 5, len(whole) + 40, len(twice) - 1):
        pack.path.write_bytes(twice[:left])
        found = packed.Pack(pack.path)
        assert [*found.places] == [NAME]
        with pytest.raises(DatabaseError, match="ends within a dataset"):
            found.check()
        found.append(dataset.assign_attrs(spec_id="f" * 16))
        assert pack.path.read_bytes() == twice


@pytest.mark.parametrize("at", [40, -300, -10])
def test_changed_byte_is_detected_and_the_last_of_an_id_counts(dataset, pack, at):
    data = bytearray(pack.path.read_bytes())
    data[at] ^= 1
    pack.path.write_bytes(data)
    with pytest.raises(DatabaseError, match="its contents are not those it was written with"):
        pack.read(NAME)
    pack.append(dataset)
    packed.Pack(pack.path).check()


def with_content(path, content, name=NAME):
    """A pack of one dataset of these bytes, sealed."""
    sealed = content + seal_of(content)
    path.write_bytes(b"%s %12d\n" % (name.encode(), len(sealed)) + sealed)
    return packed.Pack(path)


def test_stale_or_invalid_contents_are_refused(pack):
    pack.path.write_bytes(pack.path.read_bytes().replace(NAME.encode(), b"f" * 16, 1))
    with pytest.raises(DatabaseError, match="stale or foreign"):
        packed.Pack(pack.path).read("f" * 16)
    with pytest.raises(DatabaseError, match="no packed dataset"):
        with_content(pack.path, b"text\n").read(NAME)


def test_pickled_objects_are_never_read(tmp_path):
    """Objects of Python are never read, however well they are sealed."""
    header = '{"dims": {"a": ["x"]}, "coords": [], "attrs": {}, "kinds": {"a": ["|O", [1]]}}'
    content = io.BytesIO()
    np.savez(content, **{".": np.array(header), "|O": np.array([{}], dtype=object)})
    with pytest.raises(
        DatabaseError,
        match=r"one.pack: no packed dataset \(it is damaged, cut short or not what its name says\); delete it",
    ):
        with_content(tmp_path / "one.pack", content.getvalue()).read(NAME)
