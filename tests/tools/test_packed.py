"""Packed datasets: exact, reproducible, and refused when damaged or stale."""

import numpy as np
import pytest
import xarray as xr

import vsb.results.variables  # noqa: F401  (registers where results may be missing)
from vsb.errors import DatabaseError
from vsb.tools import packed
from vsb.tools.files import seal


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


def test_dataset_round_trips(dataset, tmp_path):
    packed.save(dataset, tmp_path / "one.npz")
    found = packed.load(tmp_path / "one.npz", expected="0123456789abcdef")
    assert found.attrs == dataset.attrs
    assert set(found.coords) == set(dataset.coords)
    for name, variable in dataset.variables.items():
        assert found[name].dims == variable.dims
        np.testing.assert_array_equal(found[name].values, variable.values)


@pytest.mark.parametrize("at", [10, -300, -10])
def test_changed_byte_is_detected(dataset, tmp_path, at):
    path = tmp_path / "one.npz"
    packed.save(dataset, path)
    data = bytearray(path.read_bytes())
    data[at] ^= 1
    path.write_bytes(data)
    with pytest.raises(DatabaseError, match="its contents are not those it was written with"):
        packed.read(path)


def test_missing_stale_or_invalid_file_is_refused(dataset, tmp_path):
    path = tmp_path / "one.npz"
    with pytest.raises(DatabaseError, match="file not found"):
        packed.read(path)
    packed.save(dataset, path)
    with pytest.raises(DatabaseError, match="stale or foreign"):
        packed.load(path, expected="f" * 16)
    path.write_bytes(b"text\n")
    seal(path)
    with pytest.raises(DatabaseError, match="no packed dataset"):
        packed.read(path)
    np.savez(path, **{".": np.array('{"dims": {}, "coords": [], "attrs": {}}')})  # as before arrays stood in rows
    seal(path)
    with pytest.raises(DatabaseError, match="no packed dataset"):
        packed.read(path)


def test_pickled_objects_are_never_read(tmp_path):
    """Objects of Python are never read, however well the file is sealed."""
    path = tmp_path / "one.npz"
    header = '{"dims": {"a": ["x"]}, "coords": [], "attrs": {}, "kinds": {"a": ["|O", [1]]}}'
    np.savez(path, **{".": np.array(header), "|O": np.array([{}], dtype=object)})
    seal(path)
    with pytest.raises(
        DatabaseError,
        match=r"one.npz: no packed dataset \(it is damaged, cut short or not what its name says\); delete it",
    ):
        packed.read(path)
