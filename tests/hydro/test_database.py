"""Coefficients of motions that do not couple through the water, side by side."""

import numpy as np
import pytest
import xarray as xr

from vsb.engine.hydro import database
from vsb.engine.hydro.database import Check, Coefficients, in_modes, load_database, save_database, with_symmetrized
from vsb.engine.shell.modes import mode_basis
from vsb.errors import DatabaseError


def block(omega, degrees=(0, 1, 2), seed=0):
    """Random coefficients in the form of a BEM block."""
    rng, n = np.random.default_rng(seed), len(degrees)
    labels = [f"Radial{d}" for d in degrees]
    pair = ("omega", "influenced_dof", "radiating_dof")
    return xr.Dataset(
        {
            "added_mass": (pair, rng.normal(size=(len(omega), n, n))),
            "radiation_damping": (pair, rng.normal(size=(len(omega), n, n))),
        },
        coords={"omega": list(omega), "influenced_dof": labels, "radiating_dof": labels},
    )


def test_modes_are_a_congruence_of_the_normal_velocities(seed):
    basis = mode_basis(seed.device, "full", 2)
    raw = block([1.0])
    transform = np.array(
        [
            [v if n == m else 0.0 for m in range(3)]
            for n, v in zip(basis.degrees, basis.pole_radial_displacement, strict=True)
        ]
    )
    expected = transform @ raw.added_mass.values[0] @ transform.T
    assert in_modes(raw, basis).added_mass.values[0] == pytest.approx(expected)
    assert in_modes(raw, basis).influenced_dof.values.tolist() == list(basis.labels)


def test_symmetrizing_is_recorded():
    raw = block([1.0, 2.0])
    even = with_symmetrized(raw)
    for name in ("added_mass", "radiation_damping"):
        m = even[name].values
        assert np.array_equal(m, m.transpose(0, 2, 1))
        assert m + m.transpose(0, 2, 1) == pytest.approx(raw[name].values + raw[name].values.transpose(0, 2, 1))
    assert even.attrs["history"] == "added mass and damping symmetrized"
    assert "history" not in raw.attrs


def stored(folder, spec_id="a" * 16, **attrs):
    check = Check("symmetry", 0.0, 0.01, "-", "ok", "")
    facts = {"spec_id": spec_id, "quality": database.as_json([check]), "radius": 2.0, "basis": "full", "degree": 2}
    path = folder / "db" / f"{spec_id}.nc"
    save_database(block([1.0, 2.0]).assign_attrs(facts, water_depth="inf", **attrs), None, path)
    return path


def test_index_lists_databases_and_other_files(tmp_path):
    stored(tmp_path)
    (tmp_path / "db" / "foreign.nc").write_bytes(b"?")
    stored(tmp_path, "b" * 16)
    lines = (tmp_path / "INDEX.tsv").read_text().splitlines()
    assert [line.split("\t")[0] for line in lines] == ["id", "a" * 16, "b" * 16, "foreign"]
    assert lines[1].endswith("\tok")
    assert lines[3].endswith("\tunreadable")


def test_a_database_under_a_wrong_name_is_refused(tmp_path):
    path = stored(tmp_path)
    assert load_database(path, "a" * 16).sizes["omega"] == 2
    with pytest.raises(DatabaseError, match=r"holds the database 'a{16}', needs 'c{16}'; delete or move"):
        load_database(path, "c" * 16)


def part(seed, count):
    rng = np.random.default_rng(seed)
    return Coefficients(
        rng.normal(size=(4, count, count)), rng.normal(size=(4, count, count)), rng.normal(size=(4, count)) + 1j
    )


@pytest.mark.parametrize("size", [2, 3])
def test_coefficients_of_orders_are_uncoupled_blocks(size):
    one, other = part(1, 2), part(2, size)
    found = Coefficients.side_by_side([one, other])
    for name in ("added_mass", "damping"):
        whole = getattr(found, name)
        np.testing.assert_array_equal(whole[:, :2, :2], getattr(one, name))
        np.testing.assert_array_equal(whole[:, 2:, 2:], getattr(other, name))
        assert not whole[:, :2, 2:].any()
        assert not whole[:, 2:, :2].any()
    np.testing.assert_array_equal(found.excitation, np.hstack([one.excitation, other.excitation]))
