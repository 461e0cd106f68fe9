import re

import numpy as np
import pytest
import xarray as xr

from vsb.errors import DatabaseError
from vsb.hydro import database
from vsb.hydro.database import (
    Check,
    check_at_most,
    in_modes,
    load_database,
    merged_blocks,
    save_database,
    with_symmetrized,
)
from vsb.hydro.dofs import Displacement
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import mode_basis
from vsb.shell.reference import ReferenceShell


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


def test_blocks_merge_in_any_order():
    first, second, third = block([1.0, 2.0], seed=1), block([3.0, 4.0], seed=2), block([5.0], seed=3)
    assert merged_blocks([second, first, third]).equals(merged_blocks([first, second, third]))
    assert merged_blocks([third, second, first]).omega.values.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]


def test_repeated_frequencies_and_mixed_blocks_are_refused():
    with pytest.raises(DatabaseError, match=r"frequencies \[2.0\] rad/s occur in more than one block"):
        merged_blocks([block([1.0, 2.0]), block([2.0, 3.0])])
    with pytest.raises(DatabaseError, match="blocks with different degrees of freedom"):
        merged_blocks([block([1.0]), block([2.0], degrees=(0, 1))])
    with pytest.raises(
        DatabaseError, match=r"different degrees of freedom \[\('Radial0', 'Radial1'\), \('Radial1', 'Ra"
    ):
        merged_blocks([block([1.0], degrees=(0, 1)), block([2.0], degrees=(0, 1)), block([3.0], degrees=(1, 0))])


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


def test_coefficients_without_a_frequency_of_their_own_are_in_modes_as_well(seed):
    basis, raw = mode_basis(seed.device, "full", 2), block([1.0, 2.0])
    bare = in_modes(raw.drop_vars("omega"), basis)
    assert "omega" not in bare.coords
    assert bare.added_mass.values.tolist() == in_modes(raw, basis).added_mass.values.tolist()


def test_missing_degrees_are_refused(seed):
    with pytest.raises(DatabaseError, match=r"displacements \['Radial3'\] of the modes are not among those solved"):
        in_modes(block([1.0]), mode_basis(seed.device, "membrane", 3))
    lacking = re.escape(str([f"Radial{n}" for n in range(3, 9)]))
    with pytest.raises(DatabaseError, match=lacking):
        in_modes(block([1.0]), mode_basis(seed.device, "membrane", 8))


def test_symmetrizing_is_recorded_and_touches_nothing_else():
    raw = block([1.0, 2.0])
    even = with_symmetrized(raw)
    for name in ("added_mass", "radiation_damping"):
        m = even[name].values
        assert np.array_equal(m, m.transpose(0, 2, 1))
        assert m + m.transpose(0, 2, 1) == pytest.approx(raw[name].values + raw[name].values.transpose(0, 2, 1))
    assert even.attrs["history"] == "added mass and damping symmetrized"
    assert "history" not in raw.attrs


@pytest.mark.parametrize(
    ("value", "doubt", "verdict"), [(1.0, False, "ok"), (1.1, False, "fail"), (1.1, True, "doubt"), (5.1, True, "fail")]
)
def test_severity_of_a_check(value, doubt, verdict):
    assert check_at_most("c", value, 1.0, "-", "", doubt=doubt).verdict == verdict


def stored(folder, spec_id="a" * 16, **attrs):
    check = Check("symmetry", 0.0, 0.01, "-", "ok", "")
    facts = {"spec_id": spec_id, "quality": database.as_json([check]), "radius": 2.0, "basis": "full", "degree": 2}
    path = folder / "db" / f"{spec_id}.nc"
    save_database(block([1.0, 2.0]).assign_attrs(facts, water_depth="inf", **attrs), None, path)
    return path


def test_index_lists_what_is_there_and_what_is_foreign(tmp_path):
    stored(tmp_path)
    (tmp_path / "db" / "foreign.nc").write_bytes(b"?")
    stored(tmp_path, "b" * 16)
    lines = (tmp_path / "INDEX.tsv").read_text().splitlines()
    assert [line.split("\t")[0] for line in lines] == ["id", "a" * 16, "b" * 16, "foreign"]
    assert lines[1].endswith("\tok")
    assert lines[3].endswith("\tunreadable")


@pytest.mark.parametrize(
    ("verdicts", "told"),
    [
        (("ok", "doubt"), "doubt"),
        (("doubt", "accepted", "ok"), "accepted"),
        (("accepted", "fail", "doubt"), "fail"),
        (("ok",), "ok"),
        ((), "ok"),
    ],
)
def test_index_tells_the_worst_verdict_and_all_fields_in_the_order_of_their_columns(tmp_path, verdicts, told):
    checks = [Check(f"c{i}", 0.0, 0.01, "-", verdict, "") for i, verdict in enumerate(verdicts)]
    facts = {"spec_id": "a" * 16, "quality": database.as_json(checks), "radius": 2.5, "basis": "full", "degree": 3}
    path = tmp_path / "db" / "one.nc"
    save_database(block([1.0, 2.25]).assign_attrs(facts, water_depth=7.5), None, path)
    head, line = (tmp_path / "INDEX.tsv").read_text().splitlines()
    assert dict(zip(head.split("\t"), line.split("\t"), strict=True)) == {
        "id": "one", "radius_m": "2.5", "basis": "full", "degree": "3", "frequencies": "2", "omega_max": "2.25",
        "water_depth_m": "7.5", "verdict": told,
    }  # fmt: skip


def test_a_database_under_a_wrong_name_is_refused(tmp_path):
    path = stored(tmp_path)
    assert load_database(path, "a" * 16).sizes["omega"] == 2
    with pytest.raises(DatabaseError, match=r"holds the database 'a{16}', needs 'c{16}'; delete or move"):
        load_database(path, "c" * 16)


def test_separate_sweep_is_what_the_models_read(tmp_path):
    check = Check("symmetry", 0.0, 0.01, "-", "ok", "")
    facts = {"spec_id": "d" * 16, "quality": database.as_json([check])}
    save_database(block([7.0]).assign_attrs(facts), block([1.0, 2.0, 3.0]), tmp_path / "db" / "d.nc")
    assert load_database(tmp_path / "db" / "d.nc", "d" * 16).omega.values.tolist() == [1.0, 2.0, 3.0]
    assert xr.open_dataset(tmp_path / "db" / "d.nc").omega.values.tolist() == [7.0]


def test_a_separate_sweep_has_all_that_its_file_knows(tmp_path):
    """What does not depend on frequency, and the attributes, stand once; coefficients are those of the sweep."""
    facts = {"spec_id": "d" * 16, "quality": "[]", "water_depth": 30.0, "solver": "spectral", "gravity": 9.8}
    tabulated, sweep = block([7.0], seed=1), block([1.0, 2.0], seed=2)
    mass = (("influenced_dof", "radiating_dof"), np.diag([1.0, 2.0, 3.0]))
    path = tmp_path / "db" / "d.nc"
    save_database(tabulated.assign(inertia_matrix=mass).assign_attrs(facts), sweep, path)
    found = load_database(path, "d" * 16)
    assert {name: found.attrs[name] for name in facts} == facts
    assert found.inertia_matrix.values.tolist() == mass[1].tolist()
    np.testing.assert_array_equal(found.added_mass.values, sweep.added_mass.values)
    assert database.open_database(path).equals(found)


@pytest.mark.parametrize("name", ["added_mass", "radiation_damping", "added_mass_inf", "added_mass_zero"])
def test_every_matrix_of_the_water_is_symmetrized(name):
    pair = ("influenced_dof", "radiating_dof")
    skew = xr.DataArray([[1.0, 3.0], [2.0, 4.0]], {dim: ["a", "b"] for dim in pair}, pair)
    even = with_symmetrized(xr.Dataset({name: skew, "inertia_matrix": skew}))
    assert even[name].values.tolist() == [[1.0, 2.5], [2.5, 4.0]]
    assert even.inertia_matrix.equals(skew)


def test_a_check_is_one_line_with_its_value_its_limit_and_what_it_means():
    assert Check("haskind", 0.012345, 0.05, "-", "doubt", "why").line == (
        "doubt        haskind = 0.0123 (limit 0.05): why"
    )


@pytest.mark.parametrize(("value", "verdict"), [(5.0, "doubt"), (np.nextafter(5.0, 6.0), "fail")])
def test_a_doubt_goes_as_far_as_five_times_the_limit(value, verdict):
    check = check_at_most("c", value, 1.0, "m", "text", doubt=True, design="soft", wave="storm")
    assert check == Check("c", value, 1.0, "m", verdict, "text", "soft", "storm")
    assert database.stored_checks(xr.Dataset(attrs={"quality": database.as_json([check, check])})) == [check, check]


def test_infinite_frequency_is_a_block_of_its_own_wherever_it_stands():
    """It has no frequency; and every frequency that is there twice is told, once."""
    limit = block([1.0], seed=3).added_mass[0].drop_vars("omega")
    infinite = xr.Dataset({"added_mass_inf": limit})
    parts = [block([3.0, 4.0], seed=1), block([1.0, 2.0], seed=2)]
    for given in ([infinite, *parts], [parts[0], infinite, parts[1]], [*parts, infinite]):
        merged = merged_blocks(given)
        assert merged.added_mass_inf.equals(limit)
        assert merged.drop_vars("added_mass_inf").equals(merged_blocks(parts))
    assert "added_mass_inf" not in merged_blocks(parts)
    with pytest.raises(DatabaseError, match=r"^frequencies \[3.0, 4.0\] rad/s occur in more than one block; merge"):
        merged_blocks([parts[0], *parts])


def test_displacements_are_all_radial_ones_and_the_meridional_ones_that_there_are(seed):
    """Each degree once, though two modes have it; degree 0 moves nothing along the meridian."""
    found = database.displacements_of(mode_basis(seed.device, "full", 3))
    labels = [*(f"Radial{n}" for n in range(4)), *(f"Meridional{n}" for n in range(1, 4))]
    assert [each.label for each in found] == labels
    assert [each.label for each in database.displacements_of(mode_basis(seed.device, "full", 2))][-1] == "Meridional2"


def test_modes_are_made_of_their_radial_and_their_meridional_displacements(seed):
    """In whatever order they were solved; of those that a basis has not it takes nothing."""
    basis = mode_basis(seed.device, "full", 2)
    solved = (
        Displacement("meridional", 2), Displacement("radial", 1), Displacement("radial", 0),
        Displacement("radial", 3), Displacement("meridional", 1), Displacement("radial", 2),
    )  # fmt: skip
    found = database.shares(solved, basis)
    for row, mode in zip(found, basis.shapes, strict=True):
        of = {each.label: value for each, value in zip(solved, row, strict=True)}
        expected = dict.fromkeys(of, 0.0) | {f"Radial{mode.degree}": mode.radial}
        expected |= {f"Meridional{mode.degree}": mode.meridional} if mode.degree else {}
        assert of == expected
    assert found[0].tolist() == [0.0, 1.0, 0.0, 0.0, 1.0, 0.0]


def test_matrices_are_transformed_on_both_sides_and_forces_on_one():
    """Coordinates of other dimensions stay; a matrix that is not symmetric, and more motions than displacements."""
    rng, t = np.random.default_rng(4), np.array([[1.0, -2.0], [0.5, 0.0], [3.0, 4.0]])
    force = rng.normal(size=(2, 3, 2)) + 1j * rng.normal(size=(2, 3, 2))
    raw = block([1.0, 2.0], degrees=(0, 1)).assign(
        excitation_force=(("omega", "wave_direction", "influenced_dof"), force)
    )
    raw = raw.assign_coords(wave_direction=[0.0, 0.5, 1.0])
    found = database.transformed(raw, t, ("a", "b", "c"))
    for name in ("added_mass", "radiation_damping"):
        assert found[name].values == pytest.approx(np.array([t @ m @ t.T for m in raw[name].values]))
    assert found.excitation_force.values == pytest.approx(np.array([[t @ x for x in at] for at in force]))
    assert found.excitation_force.wave_direction.values.tolist() == [0.0, 0.5, 1.0]
    assert found.omega.values.tolist() == [1.0, 2.0]
    assert found.added_mass.radiating_dof.values.tolist() == ["a", "b", "c"]


def test_excitation_is_froude_krylov_and_diffraction():
    ds = xr.Dataset({"Froude_Krylov_force": ("omega", [1 + 2j]), "diffraction_force": ("omega", [-3 + 0.5j])})
    assert database.with_excitation(ds).excitation_force.values.tolist() == [-2 + 2.5j]


def test_symmetrizing_is_told_after_what_was_done_before():
    even = with_symmetrized(block([1.0]).assign_attrs(history="read", solver="panels"))
    assert even.attrs == {"history": "read; added mass and damping symmetrized", "solver": "panels"}


def test_what_is_no_database_is_said(tmp_path):
    block([1.0]).to_netcdf(tmp_path / "other.nc")
    with pytest.raises(DatabaseError, match=r"other.nc: holds no hydro database; needs one of results/hydro/db, or an"):
        database.open_database(tmp_path / "other.nc")


def test_the_index_has_dashes_where_a_body_has_no_such_thing(tmp_path):
    """And what does not tell its water is unreadable, with dashes for all that is not known."""
    facts = {"spec_id": "a" * 16, "quality": "[]", "water_depth": 20.0}
    save_database(block([1.0, 2.0]).assign_attrs(facts), None, tmp_path / "db" / "body.nc")
    save_database(block([1.0]).assign_attrs(spec_id="b" * 16, quality="[]"), None, tmp_path / "db" / "dry.nc")
    lines = database.index_text(tmp_path / "db").splitlines()[1:]
    assert [line.split("\t") for line in lines] == [
        ["body", "-", "-", "-", "2", "2", "20.0", "ok"], ["dry", "-", "-", "-", "-", "-", "-", "unreadable"],
    ]  # fmt: skip


def test_structure_is_inertia_every_stiffness_by_name_and_the_scale_of_the_modes(seed):
    basis = mode_basis(seed.device, "membrane", 2)
    rest, n = np.array([0.1, -0.2, 0.3, 0.4]), len(basis.labels)
    stiffness = {"structural": np.arange(16.0).reshape(n, n), "hydrostatic": -np.eye(n), "gas": np.ones((n, n))}
    reference = ReferenceShell(DeformedShell(basis, 0.0, rest), stiffness)
    pair = ("influenced_dof", "radiating_dof")
    bare = xr.Dataset({"added_mass_inf": (pair, np.eye(n))}, {dim: list(basis.labels) for dim in pair}, {"solver": "s"})
    found = database.with_structure(bare, reference)
    for name, matrix in stiffness.items():
        np.testing.assert_array_equal(found[f"{name}_stiffness"].values, matrix)
    np.testing.assert_array_equal(found.inertia_matrix.values, basis.inertia)
    np.testing.assert_array_equal(found.pole_radial_displacement.values, basis.pole_radial_displacement)
    np.testing.assert_array_equal(found.reference_amplitude.values, rest)
    assert found.attrs == {"solver": "s"}
    assert found[list(bare)].equals(bare)


@pytest.mark.parametrize("doubt", [False, True])
def test_what_is_no_number_is_within_no_limit(doubt):
    assert check_at_most("c", np.nan, 1.0, "-", "", doubt=doubt).verdict == "fail"
    assert check_at_most("c", np.inf, 1.0, "-", "", doubt=doubt).verdict == "fail"
    assert check_at_most("c", -np.inf, 1.0, "-", "", doubt=doubt).verdict == "ok"


@pytest.mark.parametrize("quality", ["no JSON", '[{"name": "haskind"}]', '[{"another": 1.0}]', "[1.0]"])
def test_a_verdict_that_cannot_be_read_leaves_a_line_that_says_so(tmp_path, quality):
    """Beside those of other files."""
    stored(tmp_path)
    facts = {"spec_id": "b" * 16, "quality": quality, "radius": 2.0, "water_depth": 20.0}
    save_database(block([1.0, 2.0]).assign_attrs(facts), None, tmp_path / "db" / "odd.nc")
    lines = [line.split("\t") for line in (tmp_path / "INDEX.tsv").read_text().splitlines()[1:]]
    assert [line[-1] for line in lines] == ["ok", "unreadable"]
    assert lines[1] == ["odd", *["-"] * 6, "unreadable"]
