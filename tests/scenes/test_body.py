"""A body of a study from its database: degrees of freedom, matrices, water, band."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hydro.formats.test_capytaine import LABELS, dataset

from examples.barge import box
from vsb.errors import ConfigError
from vsb.hydro.bodies.body import FlexibleBody, at_centres
from vsb.hydro.formats.capytaine import read_capytaine
from vsb.hydro.formats.modes import volume_of
from vsb.scenes.body import check_water, chosen, complete_body, dry_database, with_entries, within_band
from vsb.study.body import Body
from vsb.study.body_file import BodyFile
from vsb.study.sections import Water
from vsb.tools.units import PAIR

BODY = Body(database="sha256:0")


@pytest.fixture
def theirs(tmp_path):
    dataset().to_netcdf(tmp_path / "a.nc")
    return read_capytaine(tmp_path / "a.nc")


def test_matrices_of_the_study_stand_before_those_of_the_file(theirs):
    body = complete_body(Body(database="-", mass={"float__Heave": 7.0}, stiffness={"spar__Heave": 3.0}), None, theirs)
    assert np.diag(body.mass) == pytest.approx([7.0, 5.0])
    assert np.diag(body.stiffness) == pytest.approx([9.0, 12.0])
    assert not body.structural_damping.any()
    assert "symmetrized" in body.database.attrs["history"]


def test_entries_of_two_motions_are_those_of_both():
    held = np.diag([1.0, 2.0])
    assert with_entries("mass", {"a b": 0.5}, ["a", "b"], held) == pytest.approx(np.array([[1.0, 0.5], [0.5, 2.0]]))
    assert with_entries("mass", ((4.0, 0.0), (0.0, 4.0)), ["a", "b"], held) == pytest.approx(4 * np.eye(2))
    assert with_entries("mass", None, ["a", "b"], held) is held


def test_degrees_of_freedom_kept():
    labels = ["Heave", "Pitch", "Mode7"]
    assert chosen(None, labels) == labels
    assert chosen(["rigid"], labels) == ["Heave", "Pitch"]
    assert chosen(["Mode7", "Heave"], labels) == ["Heave", "Mode7"]


def test_frequencies_above_one_are_left_out_and_told(theirs):
    more = theirs.reindex(omega=[0.5, 0.7, 0.9, 1.0, 1.2, 1.5], method="nearest")
    assert within_band(more, None) is more
    cut = within_band(more, 1.2)
    assert cut.omega.values[-1] == 1.2
    assert cut.attrs["history"].endswith("left out: 1 frequencies")


def test_structural_damping_is_that_of_the_file_or_of_the_factors_in_its_spec_or_none(theirs):
    """alpha M + beta K of generalized modes; factors without a mass or a stiffness of the file say nothing."""
    labels, spec = ["Heave", "Mode7"], json.dumps({"device": {"damping": {"alpha": 0.3, "beta": 0.01}}})
    ours = theirs.assign_coords(influenced_dof=labels, radiating_dof=labels).assign_attrs(spec=spec)
    ours = ours.assign(structural_stiffness=(PAIR, np.diag([0.0, 40.0])))
    own = Body(database="-", mass={"Heave": 5.0, "Mode7": 5.0})
    assert complete_body(own, None, ours).structural_damping == pytest.approx(np.diag([0.0, 0.3 * 5.0 + 0.01 * 40.0]))
    for name in ("inertia_matrix", "structural_stiffness"):
        assert not complete_body(own, None, ours.drop_vars(name)).structural_damping.any()
    stored = ours.assign(structural_damping_matrix=(PAIR, np.diag([1.0, 2.0])))
    assert complete_body(own, None, stored).structural_damping == pytest.approx(np.diag([1.0, 2.0]))


def test_rows_of_a_body_are_those_of_its_degrees_of_freedom():
    labels = ["float__Heave", "spar__Heave", "float__Pitch"]
    rows = ((4.0, 0.5), (0.5, 9.0))
    expected = [[4.0, 0.0, 0.5], [0.0, 7.0, 0.0], [0.5, 0.0, 9.0]]
    made = with_entries("mass", {"float": rows, "spar__Heave": 7.0}, labels, np.zeros((3, 3)))
    assert made == pytest.approx(np.array(expected))


class TestRefused:
    def test_rows_of_no_body_or_too_few(self):
        labels = ["float__Heave", "spar__Heave"]
        with pytest.raises(ConfigError, match=r"body.mass: received rows of 'boat'; needs a body, float or spar"):
            with_entries("mass", {"boat": ((1.0,),)}, labels, np.eye(2))
        with pytest.raises(
            ConfigError, match=r"body.mass: received rows of 'Heave'; needs a degree of freedom and a num"
        ):
            with_entries("mass", {"Heave": ((1.0,),)}, ["Heave", "Pitch"], np.eye(2))
        with pytest.raises(ConfigError, match=r"body.mass.float: received 2 rows of 1, 1 numbers; needs 1 of 1"):
            with_entries("mass", {"float": ((1.0,), (1.0,))}, labels, np.eye(2))

    def test_what_has_no_mass(self, theirs):
        dry = theirs.drop_vars("inertia_matrix")
        with pytest.raises(
            ConfigError, match=r"body.mass: received none for float__Heave, spar__Heave, nor do the files"
        ):
            complete_body(BODY, None, dry)
        with pytest.raises(ConfigError, match=r"body.mass: received -5 for spar__Heave; needs a mass above 0"):
            complete_body(Body(database="sha256:0", mass={"float__Heave": 3.0, "spar__Heave": -5.0}), None, dry)

    def test_degrees_of_freedom_that_are_not_there(self):
        with pytest.raises(ConfigError, match=r"designs: received dofs Roof; needs some of float__Heave, spar__Heave"):
            chosen(["Roof"], LABELS)
        with pytest.raises(ConfigError, match=r"designs: received dofs rigid, but Mode7 are none"):
            chosen(["rigid"], ["Mode7"])

    def test_entries_and_rows_of_nothing(self):
        with pytest.raises(ConfigError, match=r"body.mass: received 'c'; needs one or two of a, b"):
            with_entries("mass", {"c": 1.0}, ["a", "b"], np.eye(2))
        with pytest.raises(ConfigError, match=r"body.mass: received 1 rows of 2 numbers; needs 2 of 2, for a, b"):
            with_entries("mass", ((1.0, 2.0),), ["a", "b"], np.eye(2))

    @pytest.mark.parametrize("key", ["", " ", "a b a"])
    def test_entries_of_none_or_more_than_two_motions(self, key):
        with pytest.raises(ConfigError, match=rf"^body.mass: received '{key}'; needs one or two of a, b$"):
            with_entries("mass", {key: 1.0}, ["a", "b"], np.eye(2))

    def test_rows_of_a_body_without_a_name(self):
        """The only body has none: its rows are all there are, and no entry."""
        with pytest.raises(
            ConfigError, match=r"^body.mass: received rows of ''; needs a degree of freedom and a number$"
        ):
            with_entries("mass", {"": ((4.0, 0.0), (0.0, 4.0))}, ["Heave", "Pitch"], np.eye(2))

    def test_other_water(self, theirs):
        check_water(Water(density=1000.0), theirs)
        with pytest.raises(ConfigError, match=r"water.depth: received 50, needs inf, as the body's files have"):
            check_water(Water(density=1000.0, depth=50.0), theirs)
        with pytest.raises(ConfigError) as error:
            check_water(Water(density=1025.0, depth=50.0), theirs)
        assert [line.split(":")[0] for line in error.value.mistakes] == ["water.density", "water.depth"]

    @pytest.mark.parametrize("name", ["density", "depth", "gravity"])
    @pytest.mark.parametrize("side", [1, -1])
    def test_water_that_is_another_by_more_than_a_millionth(self, theirs, name, side):
        own = {"density": 1000.0, "depth": 50.0, "gravity": 9.81}
        held = theirs.assign_attrs(water_density=1000.0, water_depth="50.0", gravity=9.81)
        check_water(Water(**{**own, name: own[name] * (1 + 0.9e-6 * side)}), held)
        with pytest.raises(ConfigError, match=rf"^water.{name}: received .*, needs {own[name]:g}, as the body's files"):
            check_water(Water(**{**own, name: own[name] * (1 + 1.2e-6 * side)}), held)

    def test_too_few_frequencies(self, theirs):
        with pytest.raises(ConfigError, match=r"hydro.omega_max: received 1 rad/s, which leaves 2 of 3"):
            within_band(theirs, 1.0)
        five = theirs.reindex(omega=[0.5, 0.7, 0.9, 1.0, 1.2], method="nearest")
        assert within_band(five, 1.0).sizes["omega"] == 4
        with pytest.raises(
            ConfigError, match=r"received 0.9 rad/s, which leaves 3 of 5 frequencies .* needs 4 or more"
        ):
            within_band(five, 0.9)


def test_what_is_known_of_a_mesh_before_it_is_solved():
    from motion.test_bodies import BARGE

    file = BodyFile(body="barge", mesh="-", modes="-", omega=(0.5, 1.0), wave_direction=(0.0, 90.0))
    ds = dry_database(BARGE.body(1, 1025.0), file)
    assert float(ds.hydrostatic_stiffness[0, 0]) == pytest.approx(1025.0 * 9.81 * 20.0 * 8.0)
    assert np.degrees(ds.wave_direction.values) == pytest.approx([0.0, 90.0])
    assert complete_body(BODY, ["rigid"], ds.assign_attrs(history="")).labels == ("Heave", "Pitch")


@pytest.mark.parametrize(("given", "stored"), [("mass", "inertia_matrix"), ("stiffness", "structural_stiffness")])
def test_a_mesh_whose_modes_have_no_matrix_of_their_own_has_none_before_it_is_solved(given, stored):
    from motion.test_bodies import BARGE

    file = BodyFile(body="barge", mesh="-", modes="-", omega=(0.5, 1.0), wave_direction=(0.0,))
    whole = BARGE.body(1, 1025.0)
    known, left = (set(dry_database(body, file)) for body in (whole, replace(whole, **{given: None})))
    assert known - left == {stored}


@pytest.mark.parametrize("kept", [["spar__Heave"], ["float__Heave"], None])
def test_a_body_of_some_degrees_of_freedom_has_their_rows_of_all_its_matrices(theirs, kept):
    labels = [str(label) for label in theirs.influenced_dof.values]
    numbers = {name: size + np.array([[1.0, 0.3], [0.3, 7.0]]) for name, size in (("mass", 20), ("damping", 40))}
    numbers["stiffness"] = 60 + np.array([[1.0, 0.2], [0.2, 5.0]])
    given = {name: tuple(map(tuple, matrix)) for name, matrix in numbers.items()}
    hydrostatic = np.array([[9.0, 4.0], [2.0, 11.0]])
    found = complete_body(Body(database="-", **given), kept, theirs.assign(hydrostatic_stiffness=(PAIR, hydrostatic)))
    at = np.ix_(*[[labels.index(label) for label in kept or labels]] * 2)
    assert found.labels == tuple(kept or labels)
    np.testing.assert_array_equal(found.mass, numbers["mass"][at])
    np.testing.assert_array_equal(found.structural_damping, numbers["damping"][at])
    even = np.array([[9.0, 3.0], [3.0, 11.0]])
    np.testing.assert_allclose(found.stiffness, (numbers["stiffness"] + even)[at], rtol=1e-14)


def test_still_frequencies_are_left_out_and_the_highest_is_kept_but_for_round_off(theirs):
    """Told after what was told before; those left out are counted."""
    more = theirs.reindex(omega=[0.0, 0.5, 0.7, 0.9, 1.0, 1.2], method="nearest").assign_attrs(history="read")
    for highest, left, told in ((None, [0.5, 0.7, 0.9, 1.0, 1.2], 1), (1.0 - 5e-10, [0.5, 0.7, 0.9, 1.0], 2)):
        cut = within_band(more, highest)
        np.testing.assert_array_equal(cut.omega, left)
        assert cut.attrs["history"] == f"read; left out: {told} frequencies"
    assert within_band(more.drop_attrs(), None).attrs["history"] == "left out: 1 frequencies"
    with pytest.raises(
        ConfigError,
        match=r"^hydro.omega_max: received 0.999 rad/s, which leaves 3 of 6 frequencies of the database; needs 4 or ",
    ):
        within_band(more, 0.999)
    with pytest.raises(ConfigError, match=r"^hydro.omega_max: received inf rad/s, which leaves 2 of 3 frequencies"):
        within_band(more.isel(omega=slice(0, 3)), None)


def test_two_entries_of_different_motions_in_any_order_of_their_names():
    held = np.diag([1.0, 2.0, 3.0])
    found = with_entries("mass", {"c a": -0.5, "b": 7.0}, ["a", "b", "c"], held)
    np.testing.assert_array_equal(found, [[1.0, 0.0, -0.5], [0.0, 7.0, 0.0], [-0.5, 0.0, 3.0]])
    np.testing.assert_array_equal(held, np.diag([1.0, 2.0, 3.0]))


def test_water_a_displacement_has_no_mass_without_is_a_millionth_of_what_it_moves():
    """A box afloat: heave moves the water under its bottom, 20 m by 8 m; a unit of it goes with the box' diagonal."""
    from motion.test_bodies import BARGE

    file = BodyFile(
        body="barge", mesh="-", modes="-", omega=(0.5, 1.0), wave_direction=(0.0,), water={"density": 900.0}
    )
    ds = dry_database(BARGE.body(1, 900.0), file)
    diagonal = np.sqrt(20.0**2 + 8.0**2 + 3.0**2)
    assert float(ds.added_mass_inf[0, 0]) == pytest.approx(1e-6 * 900.0 * diagonal * 160.0, rel=1e-9)
    assert ds.attrs["water_density"] == 900.0
    assert ds.attrs[volume_of("")] == pytest.approx(480.0)
    assert ds.omega.values.tolist() == [0.5, 1.0]
    assert float(ds.hydrostatic_stiffness[0, 0]) == pytest.approx(900.0 * 9.81 * 160.0)


def test_all_stiffness_but_the_waters_stands_beside_the_body_once(theirs):
    """Of the structure, its prestress and a gas; entries of the study take the place of the sum."""
    parts = {"structural_stiffness": 1.0, "prestress_stiffness": 10.0, "gas_stiffness": 100.0}
    skew = np.array([[1.0, 0.2], [0.2, 3.0]])
    ds = theirs.assign({name: (PAIR, size * skew) for name, size in parts.items()})
    assert complete_body(BODY, None, ds).dry_stiffness == pytest.approx(111.0 * skew)
    own = complete_body(Body(database="-", stiffness={"spar__Heave": 7.0}), None, ds)
    assert own.dry_stiffness == pytest.approx(np.array([[111.0, 22.2], [22.2, 7.0]]))


def test_only_rigid_motions_need_a_mass_of_their_own(theirs):
    """What moves water has that of the water; nothing has less than none."""
    labels = ["Heave", "Mode7"]
    ds = theirs.assign_coords(influenced_dof=labels, radiating_dof=labels)
    body = complete_body(Body(database="-", mass={"Mode7": 0.0}), None, ds)
    assert np.diag(body.mass) == pytest.approx([5.0, 0.0])
    with pytest.raises(ConfigError, match=r"^body.mass: received -1 for Mode7; needs a mass above 0$"):
        complete_body(Body(database="-", mass={"Mode7": -1.0}), None, ds)
    with pytest.raises(ConfigError, match=r"^body.mass: received none for Heave, nor do the files hold one; needs the"):
        complete_body(Body(database="-", mass={"Heave": 0.0}), None, ds)
    assert complete_body(Body(database="-", mass={"Heave": 0.0}), ["Mode7"], ds).labels == ("Mode7",)


@pytest.mark.parametrize(
    ("dofs", "kept"),
    [
        (["rigid", "Mode8"], ["spar__Yaw", "Heave", "Mode8"]),
        (["Mode8", "Heave", "rigid"], ["spar__Yaw", "Heave", "Mode8"]),
        (["Mode7", "spar__Yaw"], ["Mode7", "spar__Yaw"]),
    ],
)
def test_rigid_motions_of_whichever_body_may_stand_beside_modes(dofs, kept):
    assert chosen(dofs, ["Mode7", "spar__Yaw", "Heave", "Mode8"]) == kept
    with pytest.raises(ConfigError, match=r"^designs: received dofs B, A; needs some of Mode7, Heave$"):
        chosen(["B", "Heave", "rigid", "A"], ["Mode7", "Heave"])


def test_rows_of_a_body_are_as_many_as_its_degrees_of_freedom_each():
    labels = ["float__Heave", "spar__Heave", "float__Pitch"]
    for rows, told in (
        (((1.0, 2.0), (3.0,)), "2 rows of 2, 1"),
        (((1.0, 2.0),), "1 rows of 2"),
        (((1.0,),) * 3, "3 rows of 1, 1, 1"),
    ):
        with pytest.raises(ConfigError, match=rf"^body.damping.float: received {told} numbers; needs 2 of 2$"):
            with_entries("damping", {"float": rows}, labels, np.zeros((3, 3)))
    for rows, told in (
        (((1.0, 2.0, 3.0),) * 2, "2 rows of 3, 3"),
        (((1.0,) * 3, (1.0,) * 3, (1.0,)), "3 rows of 3, 3, 1"),
    ):
        with pytest.raises(
            ConfigError, match=rf"^body.damping: received {told} numbers; needs 3 of 3, for {', '.join(labels)}$"
        ):
            with_entries("damping", rows, labels, np.zeros((3, 3)))


def test_water_moved_by_two_displacements_is_what_both_push_aside():
    """Of a box 6 m by 4 m by 2 m: heave its bottom, surge its ends, both together the sum of what they have alone."""
    vertices, faces = box(6.0, 4.0, 2.0, 1)
    heave, surge = np.zeros((2, *vertices.shape))
    heave[:, 2], surge[:, 0] = 1.0, -0.5
    shapes = np.stack([heave, surge, heave + surge])
    body = FlexibleBody(vertices, faces, ("Heave", "A", "B"), at_centres(vertices, faces, shapes), shapes)
    file = BodyFile(body="box", mesh="-", modes="-", omega=(0.5, 1.0), water={"density": 900.0})
    ends, bottom = 0.25 * 16.0, 24.0
    expected = np.array([[bottom, 0.0, bottom], [0.0, ends, ends], [bottom, ends, bottom + ends]])
    found = dry_database(body, file).added_mass_inf
    assert found.dims == PAIR
    assert found.values == pytest.approx(1e-6 * 900.0 * np.sqrt(56.0) * expected, rel=1e-9, abs=1e-12)
