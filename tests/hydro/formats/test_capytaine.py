"""Capytaine's own netCDF files: read as they are, of one body or two, or refused in one line."""

import numpy as np
import pytest
import xarray as xr

from vsb.engine.hydro.formats.capytaine import read_capytaine
from vsb.errors import DatabaseError
from vsb.tools.files import merged

LABELS = ["float__Heave", "spar__Heave"]
OMEGA = np.array([0.0, 0.5, 1.0, 1.5, np.inf])


def dataset(labels=LABELS, **changes):
    """A file as capytaine writes it: radiating degrees of freedom first, water in coordinates, complex apart."""
    n, pair = len(labels), ("omega", "radiating_dof", "influenced_dof")
    mass = np.arange(1.0, n * n + 1).reshape(n, n) + 0.1 * np.arange(5.0)[:, None, None]
    force = (np.arange(5.0)[:, None, None] + 1j) * np.ones((1, 2, n))
    data = {
        "added_mass": (pair, mass),
        "radiation_damping": (pair, np.zeros((5, n, n)) + np.eye(n)),
        "inertia_matrix": (("influenced_dof", "radiating_dof"), 5.0 * np.eye(n)),
        "hydrostatic_stiffness": (("influenced_dof", "radiating_dof"), 9.0 * np.eye(n)),
    }
    for name in ("diffraction_force", "Froude_Krylov_force"):
        both = np.stack([force.real, force.imag])
        data[name] = (("complex", "omega", "wave_direction", "influenced_dof"), both)
    coords = {"omega": OMEGA, "wave_direction": [0.0, np.pi / 4], "influenced_dof": labels, "radiating_dof": labels}
    water = {"rho": 1000.0, "g": 9.81, "water_depth": np.inf, "body_name": "float+spar", "complex": ["re", "im"]}
    ds = xr.Dataset(data, {**coords, **water}, {"capytaine_version": "2.3.1"})
    return ds.assign(changes) if changes else ds


def test_file_of_two_bodies_is_read(tmp_path):
    dataset().to_netcdf(tmp_path / "rm3.nc")
    found = read_capytaine(tmp_path / "rm3.nc")
    assert list(map(str, found.influenced_dof.values)) == LABELS
    assert found.omega.values == pytest.approx([0.5, 1.0, 1.5])
    heave = {"influenced_dof": "float__Heave", "radiating_dof": "spar__Heave"}
    assert found.added_mass.sel(heave).values == pytest.approx(
        [3.1, 3.2, 3.3]
    )  # radiated by the spar, felt by the float
    assert float(found.added_mass_inf.sel(heave)) == pytest.approx(3.4)
    assert found.excitation_force.values[0, 1, 0] == pytest.approx(2 * (1 + 1j))
    assert (found.attrs["water_density"], found.attrs["water_depth"]) == (1000.0, "inf")
    assert found.attrs["history"] == "read from rm3.nc"


def test_native_complex_numbers_and_names_as_bytes_are_read(tmp_path):
    """As `to_netcdf(auto_complex=True)` writes them, and names as arrays of characters; the numbers are the same."""
    dataset().to_netcdf(tmp_path / "a.nc")
    native = merged(dataset())
    names = {dim: (dim, np.array(LABELS, dtype="S")) for dim in ("influenced_dof", "radiating_dof")}
    native.assign_coords(names).to_netcdf(tmp_path / "b.nc", auto_complex=True)
    as_bytes = dataset().assign_coords(complex=("complex", np.array(["re", "im"], dtype="S")), **names)
    as_bytes.to_netcdf(tmp_path / "c.nc")
    expected = read_capytaine(tmp_path / "a.nc")
    for name in ("b.nc", "c.nc"):
        found = read_capytaine(tmp_path / name)
        assert found.equals(expected)
        assert list(map(str, found.influenced_dof.values)) == LABELS


SOLVED = ("added_mass", "radiation_damping", "diffraction_force")


def test_failed_frequencies_are_left_out(tmp_path):
    """Of WEC-Sim's own files of capytaine five in seven have some; one coefficient alone is no such frequency."""
    solved = dataset().omega != 0.5
    dataset(**{name: dataset()[name].where(solved) for name in SOLVED}).to_netcdf(tmp_path / "a.nc")
    found = read_capytaine(tmp_path / "a.nc")
    assert found.omega.values == pytest.approx([1.0, 1.5])
    assert found.attrs["history"] == (
        "read from a.nc; left out: 1 of 3 frequencies, from 0.5 to 0.5 rad/s, of which all coefficients are NaN"
    )
    heave = (dataset().influenced_dof != LABELS[0]) | solved  # the spar's are known there
    dataset(**{name: dataset()[name].where(heave) for name in SOLVED}).to_netcdf(tmp_path / "c.nc")
    with pytest.raises(DatabaseError, match="holds NaN"):
        read_capytaine(tmp_path / "c.nc")
    dataset(added_mass=dataset().added_mass.where(solved)).to_netcdf(tmp_path / "b.nc")
    with pytest.raises(DatabaseError, match="added_mass holds NaN"):
        read_capytaine(tmp_path / "b.nc")


@pytest.mark.parametrize(
    ("spoiled", "message"),
    [
        (lambda ds: ds.drop_vars("diffraction_force"), "holds no diffraction_force; needs a hydro database of"),
        (lambda ds: ds.assign_coords(forward_speed=1.0), "is of a body under way; needs forward_speed 0"),
        (lambda ds: ds.assign_coords(rho=("depths", [1.0, 2.0])), "holds 2 values of rho; needs the coefficients of"),
        (lambda ds: ds.assign(added_mass=np.nan * ds.added_mass), "NaN"),
        (lambda ds: ds.isel(omega=[0, 4]), r"frequencies \[\] rad/s; needs finite, ascending ones"),
        (lambda ds: ds.assign({name: np.nan * ds[name] for name in SOLVED}), "all coefficients are NaN at every"),
    ],
)
def test_wrong_files_are_refused(tmp_path, spoiled, message):
    spoiled(dataset()).to_netcdf(tmp_path / "a.nc")
    with pytest.raises(DatabaseError, match=message):
        read_capytaine(tmp_path / "a.nc")
    (tmp_path / "b.nc").write_text("no netCDF")
    with pytest.raises(DatabaseError, match=r"b.nc: cannot be read: .*; needs a hydro database of capytaine"):
        read_capytaine(tmp_path / "b.nc")


def asked_by(path, name, **changes):
    """The file of capytaine's as it is when the frequencies are asked for by another quantity."""
    with xr.open_dataset(path) as ds:
        ds.load().isel(omega=slice(1, -1)).swap_dims(omega=name).assign(changes).to_netcdf(path.with_name(f"{name}.nc"))
    return path.with_name(f"{name}.nc")


@pytest.mark.parametrize(
    ("name", "named"),
    [("period", True), ("period", False), ("freq", False), ("wavenumber", False), ("wavelength", False)],
)
def test_frequencies_given_by_another_quantity(ball, name, named):
    path, expected = asked_by(ball, name), read_capytaine(ball)
    if not named:
        with xr.open_dataset(path) as ds:
            ds.load().drop_vars("omega").to_netcdf(path.with_name("bare.nc"))
        path = path.with_name("bare.nc")
    found = read_capytaine(path)
    assert found.omega.values == pytest.approx(expected.omega.values)
    assert found.radiation_damping.values == pytest.approx(expected.radiation_damping.values)


def test_single_cases_and_radiation_by_wave_direction(ball):
    """Problems given one by one make added mass depend on the direction of waves, which it must not."""
    expected = read_capytaine(ball)
    with xr.open_dataset(ball) as ds:
        ds = ds.load()
    names = ("added_mass", "radiation_damping")
    by_direction = ds.assign({name: ds[name].expand_dims(wave_direction=ds.wave_direction) for name in names})
    by_direction.expand_dims(body_name=["ball"]).to_netcdf(ball.with_name("cases.nc"))
    assert read_capytaine(ball.with_name("cases.nc")).added_mass.identical(expected.added_mass)
    uneven = by_direction.added_mass * xr.DataArray([1.0, 1.1, 1.0], dims="wave_direction")
    by_direction.assign(added_mass=uneven).to_netcdf(ball.with_name("cases.nc"))
    with pytest.raises(DatabaseError, match="added_mass depends on wave_direction; needs coefficients in still water"):
        read_capytaine(ball.with_name("cases.nc"))
