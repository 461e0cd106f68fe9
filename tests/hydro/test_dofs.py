"""Degrees of freedom are values: what they do, and which strings are none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.errors import ConfigError
from vsb.hydro.azimuthal import legendre_function
from vsb.hydro.dofs import Displacement, azimuthal_order, displacements, flexible, normal_velocities

PHI = np.linspace(0.05, np.pi - 0.05, 41)
SPHERE = np.array([np.sin(PHI), np.cos(PHI)])
SURGE, HEAVE, PITCH = Displacement("surge", order=1), Displacement("heave"), Displacement("pitch", order=1)


def shapes():
    """Any displacement of the shell in a shape of its own."""

    def one(kind, order, more):
        return Displacement(kind, max(order + more, 1), order)

    return st.builds(one, st.sampled_from(["radial", "meridional"]), st.integers(0, 5), st.integers(0, 9))


@pytest.mark.parametrize(
    ("labels", "answer"),
    [(["Heave"], False), (["Surge", "Heave", "Pitch"], False), (["Membrane0"], True), (["Heave", "Bending2"], True)],
)
def test_what_is_flexible_says_so_itself(labels, answer):
    """However many motions there are."""
    assert flexible(np.array(labels)) is answer


def test_heave_of_a_sphere_is_its_first_radial_and_meridional_shape():
    """e_z = e_r cos phi - e_phi sin phi, on any surface."""
    normal = np.array([0.6 * np.ones(41), -0.8 * np.ones(41)])
    heave, radial, meridional = normal_velocities(
        displacements(["Heave", "Radial1", "Meridional1"]), PHI, SPHERE, normal
    )
    assert heave == pytest.approx(-0.8, abs=1e-15)
    assert radial + meridional == pytest.approx(heave, abs=1e-14)


@given(st.lists(shapes(), min_size=1, max_size=3), st.floats(0, 2 * np.pi))
def test_shapes_are_along_the_radius_and_the_meridian(moved, angle):
    """Of a surface of any slope."""
    normal = np.array([np.cos(angle) * np.ones(41), np.sin(angle) * np.ones(41)])
    along = {"radial": (np.sin(PHI), np.cos(PHI)), "meridional": (np.cos(PHI), -np.sin(PHI))}
    for each, found in zip(moved, normal_velocities(moved, PHI, SPHERE, normal), strict=True):
        (x, z), p = along[each.kind], legendre_function(each.degree, each.order, PHI)
        size = p[each.kind == "meridional"]
        assert found == pytest.approx(size * (x * normal[0] + z * normal[1]), abs=1e-13 * np.abs(size).max())


def test_surge_of_a_sphere_is_its_first_radial_and_meridional_shape():
    """e_x = e_r sin phi cos theta + e_phi cos phi cos theta - e_theta sin theta; meridional shapes move no water."""
    surge, radial, meridional = normal_velocities(
        displacements(["Surge", "Radial1", "Meridional1"], 1), PHI, SPHERE, SPHERE
    )
    assert surge == pytest.approx(radial, abs=1e-14)
    assert meridional == pytest.approx(0.0, abs=1e-14)


@given(st.floats(-3.0, 3.0), st.floats(0.1, 3.0))
def test_pitch_is_a_rotation_about_y_through_the_origin(height, ratio):
    """On any body: (e_y x r) . n; here a spheroid about (0, 0, height)."""
    position = np.array([np.sin(PHI), height + ratio * np.cos(PHI)])
    normal = np.array([ratio * np.sin(PHI), np.cos(PHI)])
    normal /= np.linalg.norm(normal, axis=0)
    pitch = normal_velocities((PITCH,), PHI, position, normal)[0]
    x, z = position
    expected = (np.cross([0.0, 1.0, 0.0], np.column_stack([x, 0 * x, z])) * np.insert(normal, 1, 0.0, axis=0).T).sum(1)
    assert pitch == pytest.approx(expected, abs=1e-13)


def test_pitch_about_the_centre_of_a_sphere_moves_no_water():
    assert np.abs(normal_velocities((PITCH,), PHI, SPHERE, SPHERE)).max() < 1e-15


@pytest.mark.parametrize(
    "label",
    ["Rubbish2", "Membrane2", "Bending3", "radial2", "Radial", "Radial-1", "Radial02", "Sway", "2", ""],
)
@pytest.mark.parametrize("order", [0, 1])
def test_labels_that_name_none(label, order):
    with pytest.raises(
        ConfigError, match=rf"^displacements: received {label} of azimuthal order {order}; needs Radial"
    ):
        displacements([label], order)


@given(st.text(max_size=300))
def test_no_other_text_is_a_displacement(label):
    try:
        found = displacements([label])[0].label
    except ConfigError as error:
        found, message = None, str(error)
    assert found == label or (len(message) < 300 and len(message.splitlines()) == 1)


@pytest.mark.parametrize(
    ("name", "order"),
    [("Radial1", 2), ("Surge", 2), ("Surge", 0), ("Pitch", 0), ("Heave", 1), ("Meridional0", 0), ("Meridional1", 2)],
)
def test_displacements_an_order_does_not_have(name, order):
    with pytest.raises(ConfigError, match=rf"received {name} of azimuthal order {order}; needs Radial<n>"):
        displacements([name], order)


@pytest.mark.parametrize(
    ("moved", "received"),
    [((), "none"), ((HEAVE, SURGE), "Heave of order 0, Surge of order 1"), ((HEAVE, HEAVE), "Heave of order 0, Heave")],
)
def test_displacements_of_a_problem_are_of_one_order_and_different(moved, received):
    with pytest.raises(ConfigError, match=f"received {received}.*; needs one or more, all of one order, none twice"):
        azimuthal_order(moved)
