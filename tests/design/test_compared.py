"""Buoys compared: how far a spring below zero lets them come back."""

import numpy as np
import pytest

from vsb.design.compared import displacement_held


def test_a_spring_below_zero_holds_a_sphere_it_has_lifted_far_enough():
    """Sphere of radius 1 m with its centre 0.25 m above the water: 0 = rho g (V(d) - V(d - s)) + k s of a spherical cap.

    A weak spring holds it where its pull is all the weight; one of 0.9 of the waterplane's stiffness, still in the
    water. Upside down, as much above the water as it had below, it is held as far below.
    """
    colatitude, draft, weight_density = np.linspace(0.0, np.pi, 2001), 0.75, 1025.0 * 9.81

    def volume(depth: float) -> float:
        return np.pi * depth**2 * (3 - depth) / 3

    for centre in (1 - draft, draft - 1):
        sphere = np.sin(colatitude), np.cos(colatitude) + centre
        weak = -weight_density * volume(draft) / 10.0
        assert displacement_held(sphere, 1025.0, 9.81, weak) == pytest.approx(10.0, rel=1e-3)
        strong = -0.9 * weight_density * np.pi * draft * (2 - draft)
        moved = displacement_held(sphere, 1025.0, 9.81, strong)
        assert weight_density * (volume(draft) - volume(draft - moved)) == pytest.approx(-strong * moved, rel=1e-3)
        assert 0 < moved < draft
    assert displacement_held(sphere, 1025.0, 9.81, 0.0) == np.inf
