"""Degrees of freedom are values: what they do, and which strings are none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.engine.hydro import variables
from vsb.engine.hydro.dofs import (
    Displacement,
    bessel,
    displacements,
    legendre_function,
    multiplicity,
    normal_velocities,
)

PHI = np.linspace(0.05, np.pi - 0.05, 41)
SPHERE = np.array([np.sin(PHI), np.cos(PHI)])
SURGE, HEAVE, PITCH = Displacement("surge", order=1), Displacement("heave"), Displacement("pitch", order=1)


def shapes():
    """Any displacement of the shell in a shape of its own."""

    def one(kind, order, more):
        return Displacement(kind, max(order + more, 1), order)

    return st.builds(one, st.sampled_from(["radial", "meridional"]), st.integers(0, 5), st.integers(0, 9))


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


def test_legendre_functions_of_low_order():
    """Abramowitz and Stegun 8.6, without their (-1)^m."""
    s, c = np.sin(PHI), np.cos(PHI)
    for (n, m), (value, slope) in {
        (1, 1): (s, c),
        (2, 1): (3 * s * c, 3 * np.cos(2 * PHI)),
        (2, 2): (3 * s**2, 6 * s * c),
        (3, 3): (15 * s**3, 45 * s**2 * c),
    }.items():
        for found, expected in zip(legendre_function(n, m, PHI), (value, slope), strict=True):
            assert found == pytest.approx(expected, abs=1e-13)


@given(st.integers(1, 6), st.integers(0, 6))
def test_slope_of_legendre_functions_is_their_derivative(order, more):
    h = 1e-5
    ahead, behind = (legendre_function(order + more, order, PHI + sign * h)[0] for sign in (1, -1))
    slope = legendre_function(order + more, order, PHI)[1]
    assert np.abs((ahead - behind) / (2 * h) - slope).max() < 1e-6 * np.abs(slope).max()


@given(st.floats(0.01, 20.0), st.floats(-np.pi, np.pi))
def test_components_add_up_to_the_plane_wave(kr, theta):
    """Jacobi and Anger's expansion of exp(i k R cos theta)."""
    parts = [multiplicity(m) * 1j**m * bessel(m, np.array(kr))[0] * np.cos(m * theta) for m in range(50)]
    assert sum(parts) == pytest.approx(np.exp(1j * kr * np.cos(theta)), abs=1e-12)


@pytest.mark.parametrize(
    ("label", "body", "motion", "rigid"),
    [("Heave", "", "Heave", True), ("float__Heave", "float", "Heave", True), ("Mode7", "", "Mode7", False),
     ("left__float__Pitch", "left__float", "Pitch", True), ("Heave__Mode7", "Heave", "Mode7", False)],
)  # fmt: skip
def test_labels_of_motions_of_several_bodies(label, body, motion, rigid):
    """A body's name may be two words, or that of a motion."""
    assert (variables.body_of(label), variables.motion_of(label)) == (body, motion)
    assert variables.is_rigid(label) is rigid
