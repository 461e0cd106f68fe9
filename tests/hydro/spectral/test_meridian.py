import itertools

import numpy as np
import pytest

from vsb.errors import ConfigError
from vsb.hydro.spectral import meridian
from vsb.hydro.spectral.meridian import WetMeridian, log_rule
from vsb.shell.deformed import rigid_sphere


def wet_sphere(nodes=32, height=0.0, order=0):
    return WetMeridian(rigid_sphere(1.0, height), nodes, order)


def test_the_rule_for_logarithms_is_exact():
    u, w = log_rule()
    assert np.all(w > 0)
    for p in range(10):
        assert w @ u**p == pytest.approx(1 / (p + 1), rel=1e-13)
        assert w @ (u**p * np.log(u)) == pytest.approx(-1 / (p + 1) ** 2, rel=1e-12)


def test_points_of_the_meridian_measure_the_shell():
    for height in (-0.5, 0.0, 0.5):
        wet = wet_sphere(height=height)
        assert 2 * np.pi * wet.areas.sum() == pytest.approx(2 * np.pi * (1 - height), rel=1e-12)
        assert np.all(wet.points.z < 0)


@pytest.mark.parametrize("height", [-0.7, 0.0, 0.7])
@pytest.mark.parametrize("order", [0, 1, 3])
def test_the_points_inside_are_inside(height, order):
    wet = wet_sphere(24, height, order)
    x, z = (a[wet.nodes :] for a in wet.targets)
    assert len(x) >= len(meridian._INTERIOR)
    assert np.all(np.hypot(x, z - height) < 0.9)
    assert np.all(z < 0)
    assert np.all((x > 0) == (order > 0))  # where potentials of the order do not vanish


def source_and_image(points, order, depth):
    """Potential of order m of a ring inside, R^m over r^(2m+1), and of its image in a wall at the surface; w there."""
    value, velocity = 0.0, 0.0
    for z0 in (depth, -depth):
        r2 = points.x**2 + (points.z - z0) ** 2
        outward = points.n_x * points.x + points.n_z * (points.z - z0)
        each = points.x**order * r2 ** (-order - 0.5)
        value = value + each
        velocity = velocity + each * (order * points.n_x / points.x - (2 * order + 1) * outward / r2)
    return value, velocity


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_potential_flow_that_is_known_satisfies_the_equation(order):
    """A multipole inside the raised sphere and its image: the limit of zero frequency on the right side of a wall."""
    errors = []
    for nodes in (8, 12, 16, 24, 32):
        wet = wet_sphere(nodes, 0.3, order)
        exact, velocity = source_and_image(wet.points, order, -0.3)
        single, double = wet.rankine.sum(axis=0)
        phi = wet.solve(double + 0j, (-single @ velocity)[:, None] + 0j)[:, 0]
        errors.append(np.abs(phi - exact).max() / np.abs(exact).max())
    assert all(later < earlier / 4 for earlier, later in itertools.pairwise(errors)), errors
    assert errors[-1] < 3e-8


@pytest.mark.parametrize("height", [1.5, -1.5])
def test_a_shell_without_waterline_is_refused(height):
    with pytest.raises(ConfigError, match="needs one waterline with the keel"):
        _ = wet_sphere(12, height).points
