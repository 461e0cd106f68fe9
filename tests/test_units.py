import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from vsb.errors import DatabaseError
from vsb.units import ATTRS, load, merged, save, separated, write_text

FINITE = st.floats(-1e12, 1e12)


def rao(values):
    size = values.shape[1]
    return xr.Dataset(
        {"rao": (("design", "omega", "dof"), values)},
        coords={"design": ["A"], "omega": np.arange(size) + 1.0, "dof": ["Heave", "Membrane0"]},
    )


@settings(max_examples=20, deadline=None)
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


def test_separated_form_is_the_one_capytaine_writes():
    from capytaine.io.xarray import separate_complex_values

    ds = rao(np.arange(6).reshape(1, 3, 2) * (1 + 2j))
    ours, theirs = separated(ds), separate_complex_values(ds)
    assert ours.rao.transpose(*theirs.rao.dims).equals(theirs.rao)
    assert merged(ours).rao.equals(ds.rao)


def test_nan_is_never_written(tmp_path):
    ds = rao(np.full((1, 3, 2), np.nan))
    with pytest.raises(DatabaseError, match="variable rao holds NaN or infinite values"):
        save(ds, tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []


def test_unknown_variable_is_refused(tmp_path):
    with pytest.raises(DatabaseError, match=r"variables \['wobble'\] are not in vsb.units.ATTRS"):
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
