"""Bodies of a study from their database: degrees of freedom, matrices, water, band, refused input."""

import json

import numpy as np
import pytest
from hydro.formats.test_capytaine import dataset

from examples.barge import Barge, box
from vsb.engine.hydro.bodies.body import FlexibleBody
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.mesh import at_centres
from vsb.engine.hydro.formats.capytaine import read_capytaine
from vsb.engine.hydro.variables import PAIR
from vsb.errors import ConfigError
from vsb.models.body import chosen, complete_body, dry_database, with_entries, within_band
from vsb.study.body import Body

BODY = Body(database="sha256:0")


@pytest.fixture
def theirs(tmp_path):
    dataset().to_netcdf(tmp_path / "a.nc")
    return read_capytaine(tmp_path / "a.nc")


def test_matrices_of_the_study_take_precedence(theirs):
    body = complete_body(Body(database="-", mass={"float__Heave": 7.0}, stiffness={"spar__Heave": 3.0}), None, theirs)
    assert np.diag(body.mass) == pytest.approx([7.0, 5.0])
    assert np.diag(body.stiffness) == pytest.approx([9.0, 12.0])
    assert not body.structural_damping.any()
    assert "symmetrized" in body.database.attrs["history"]


def test_coupled_entries_are_symmetric():
    held = np.diag([1.0, 2.0])
    assert with_entries("mass", {"a b": 0.5}, ["a", "b"], held) == pytest.approx(np.array([[1.0, 0.5], [0.5, 2.0]]))
    assert with_entries("mass", ((4.0, 0.0), (0.0, 4.0)), ["a", "b"], held) == pytest.approx(4 * np.eye(2))
    assert with_entries("mass", None, ["a", "b"], held) is held


def test_selected_degrees_of_freedom():
    labels = ["Heave", "Pitch", "Mode7"]
    assert chosen(None, labels) == labels
    assert chosen(["rigid"], labels) == ["Heave", "Pitch"]
    assert chosen(["Mode7", "Heave"], labels) == ["Heave", "Mode7"]


def test_structural_damping_of_a_body(theirs):
    """Of the file, or alpha M + beta K of generalized modes; none without a mass or stiffness."""
    labels, spec = ["Heave", "Mode7"], json.dumps({"device": {"damping": {"alpha": 0.3, "beta": 0.01}}})
    ours = theirs.assign_coords(influenced_dof=labels, radiating_dof=labels).assign_attrs(spec=spec)
    ours = ours.assign(structural_stiffness=(PAIR, np.diag([0.0, 40.0])))
    own = Body(database="-", mass={"Heave": 5.0, "Mode7": 5.0})
    assert complete_body(own, None, ours).structural_damping == pytest.approx(np.diag([0.0, 0.3 * 5.0 + 0.01 * 40.0]))
    for name in ("inertia_matrix", "structural_stiffness"):
        assert not complete_body(own, None, ours.drop_vars(name)).structural_damping.any()
    stored = ours.assign(structural_damping_matrix=(PAIR, np.diag([1.0, 2.0])))
    assert complete_body(own, None, stored).structural_damping == pytest.approx(np.diag([1.0, 2.0]))


def test_rows_of_one_of_several_bodies():
    labels = ["float__Heave", "spar__Heave", "float__Pitch"]
    rows = ((4.0, 0.5), (0.5, 9.0))
    expected = [[4.0, 0.0, 0.5], [0.0, 7.0, 0.0], [0.5, 0.0, 9.0]]
    made = with_entries("mass", {"float": rows, "spar__Heave": 7.0}, labels, np.zeros((3, 3)))
    assert made == pytest.approx(np.array(expected))


def test_dry_database_of_a_mesh():
    barge = Barge(length=20.0, beam=8.0, draught=3.0, centre_of_mass=-1.5, bending_stiffness=2e8, modes=2)
    file = BodyFile(body="barge", mesh="-", modes="-", omega=(0.5, 1.0), wave_direction=(0.0, 90.0))
    ds = dry_database(barge.body(1, 1025.0), file)
    assert float(ds.hydrostatic_stiffness[0, 0]) == pytest.approx(1025.0 * 9.81 * 20.0 * 8.0)
    assert np.degrees(ds.wave_direction.values) == pytest.approx([0.0, 90.0])
    assert complete_body(BODY, ["rigid"], ds.assign_attrs(history="")).labels == ("Heave", "Pitch")


def test_frequencies_outside_the_band_are_left_out(theirs):
    more = theirs.reindex(omega=[0.0, 0.5, 0.7, 0.9, 1.0, 1.2], method="nearest").assign_attrs(history="read")
    for highest, left, count in ((None, [0.5, 0.7, 0.9, 1.0, 1.2], 1), (1.0 - 5e-10, [0.5, 0.7, 0.9, 1.0], 2)):
        cut = within_band(more, highest)
        np.testing.assert_array_equal(cut.omega, left)
        assert cut.attrs["history"] == f"read; left out: {count} frequencies"
    assert within_band(more.drop_attrs(), None).attrs["history"] == "left out: 1 frequencies"
    with pytest.raises(
        ConfigError,
        match=r"^hydro.omega_max: received 0.999 rad/s, which leaves 3 of 6 frequencies of the database; needs 4 or ",
    ):
        within_band(more, 0.999)
    with pytest.raises(ConfigError, match=r"^body: received 2 of 3 frequencies of the database above zero"):
        within_band(more.isel(omega=slice(0, 3)), None)


def test_dry_stiffness_is_the_sum_of_structure_prestress_and_gas(theirs):
    parts = {"structural_stiffness": 1.0, "prestress_stiffness": 10.0, "gas_stiffness": 100.0}
    skew = np.array([[1.0, 0.2], [0.2, 3.0]])
    ds = theirs.assign({name: (PAIR, size * skew) for name, size in parts.items()})
    assert complete_body(BODY, None, ds).stiffness_parts["structural"] == pytest.approx(111.0 * skew)
    own = complete_body(Body(database="-", stiffness={"spar__Heave": 7.0}), None, ds)
    assert own.stiffness_parts["structural"] == pytest.approx(np.array([[111.0, 22.2], [22.2, 7.0]]))


def test_only_rigid_motions_need_a_dry_mass(theirs):
    labels = ["Heave", "Mode7"]
    ds = theirs.assign_coords(influenced_dof=labels, radiating_dof=labels)
    body = complete_body(Body(database="-", mass={"Mode7": 0.0}), None, ds)
    assert np.diag(body.mass) == pytest.approx([5.0, 0.0])
    with pytest.raises(ConfigError, match=r"^body.mass: received -1 for Mode7; needs a mass above 0$"):
        complete_body(Body(database="-", mass={"Mode7": -1.0}), None, ds)
    with pytest.raises(ConfigError, match=r"^body.mass: received none for Heave, nor do the files hold one; needs the"):
        complete_body(Body(database="-", mass={"Heave": 0.0}), None, ds)
    assert complete_body(Body(database="-", mass={"Heave": 0.0}), ["Mode7"], ds).labels == ("Mode7",)


def test_nominal_added_mass_of_two_displacements():
    """A box of 6 m by 4 m by 2 m: heave moves its bottom, surge its ends."""
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


def test_missing_or_negative_mass_is_refused(theirs):
    dry = theirs.drop_vars("inertia_matrix")
    with pytest.raises(ConfigError, match=r"body.mass: received none for float__Heave, spar__Heave, nor do the files"):
        complete_body(BODY, None, dry)
    with pytest.raises(ConfigError, match=r"body.mass: received -5 for spar__Heave; needs a mass above 0"):
        complete_body(Body(database="sha256:0", mass={"float__Heave": 3.0, "spar__Heave": -5.0}), None, dry)
