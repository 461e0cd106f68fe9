"""Meridians of axisymmetric shapes: volume, area, curvature, draft, errors."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.engine.shell.meridian import RestMeridian, also_through, capsule, spheroid, through


@settings(max_examples=15)
@given(st.floats(0.2, 5.0), st.floats(0.1, 0.9))
def test_cap_of_a_spheroid(stretch, part):
    """An affine image of the sphere's cap, pi h^2 (3r - h)/3."""
    body, h = spheroid(2.0, 4.0 * stretch), 4.0 * part
    cap = stretch * math.pi * h**2 * (6 - h) / 3
    assert body.volume_below(stretch * (h - 2.0)) == pytest.approx(cap, rel=1e-12)
    assert body.draft_of(cap) == pytest.approx(stretch * h, rel=1e-12)
    centroid = -stretch * 3 * (4.0 - h) ** 2 / (4 * (6.0 - h))  # of a cap, 3 (2r - h)^2/4(3r - h) below the centre
    assert body.centroid_below(stretch * (h - 2.0)) == pytest.approx(centroid, rel=1e-10)


def test_area_and_curvature_of_spheroids():
    a, c = 2.0, 1.5
    e = math.sqrt(1 - c**2 / a**2)
    oblate = spheroid(a, 2 * c)
    assert oblate.area == pytest.approx(2 * math.pi * a**2 * (1 + (1 - e**2) / e * math.atanh(e)), rel=1e-13)
    assert oblate.curvatures(math.pi / 2) == pytest.approx((a / c**2, 1 / a), rel=1e-13)
    assert oblate.sharpest == pytest.approx(c**2 / a, rel=1e-9)  # at the equator
    c = 3.0
    e = math.sqrt(1 - a**2 / c**2)
    prolate = spheroid(a, 2 * c)
    assert prolate.area == pytest.approx(2 * math.pi * a**2 * (1 + c / (a * e) * math.asin(e)), rel=1e-13)
    assert prolate.sharpest == pytest.approx(a**2 / c, rel=1e-3)  # at the poles


def test_capsule_is_a_cylinder_between_two_hemispheres():
    r, length = 1.5, 3.0
    body = capsule(r, length)
    assert (body.radius, body.top, body.keel) == pytest.approx((r, r + length / 2, -r - length / 2), rel=1e-12)
    assert body.volume == pytest.approx(math.pi * r**2 * length + 4 / 3 * math.pi * r**3, rel=1e-13)
    assert body.area == pytest.approx(2 * math.pi * r * length + 4 * math.pi * r**2, rel=1e-13)
    assert body.sharpest == pytest.approx(r, rel=1e-12)
    for phi in np.linspace(0.01, math.pi - 0.01, 41):
        x, z, _, _ = body.at(phi)
        beyond = max(abs(z) - length / 2, 0.0)
        assert math.hypot(x, beyond) == pytest.approx(r, rel=1e-12)
        assert body.curvatures(phi) == pytest.approx((1 / r if beyond else 0.0, 1 / r), abs=1e-12)
    for draft in (0.7, r, 2.9, 5.2):  # in the lower cap, where it ends, in the cylinder, in the upper cap
        cap = math.pi * min(draft, r) ** 2 * (3 * r - min(draft, r)) / 3
        upper = max(draft - r - length, 0.0)
        below = cap + math.pi * r**2 * min(max(draft - r, 0.0), length) + math.pi * upper * (r**2 - upper**2 / 3)
        assert body.volume_below(body.lowest + draft) == pytest.approx(below, rel=1e-12)
        assert body.draft_of(below) == pytest.approx(draft, rel=1e-12)


def test_capsule_tends_to_the_sphere():
    body, sphere = capsule(1.5, 1e-9), capsule(1.5, 0.0)
    assert sphere.volume == pytest.approx(4 / 3 * math.pi * 1.5**3, rel=1e-13)
    for phi in np.linspace(0.0, math.pi, 19):
        assert body.at(phi) == pytest.approx(sphere.at(phi), abs=1e-8)


def _points(shape, count):
    return tuple((0.0 if i in (0, count) else shape(math.pi * i / count)[0], shape(math.pi * i / count)[1])
                 for i in range(count + 1))  # fmt: skip


def test_profile_converges_at_fourth_order():
    def ellipse(phi):
        return 3 * math.sin(phi), 2 * math.cos(phi)

    exact = spheroid(1.5, 2.0)
    errors = [abs(through(_points(ellipse, n), 1.5).volume / exact.volume - 1) for n in (8, 16)]
    assert 3.5 < math.log2(errors[0] / errors[1]) < 6.0
    assert errors[1] < 1e-5
    found = through(_points(ellipse, 24), 1.5)
    assert found.radius == pytest.approx(1.5, rel=1e-9)
    assert found.top == pytest.approx(-found.keel, abs=1e-12) == pytest.approx(1.0, rel=1e-4)


def test_two_curves_through_the_same_points_approach_each_other():
    def ellipse(phi):
        return 3 * math.sin(phi), 2 * math.cos(phi)

    apart = []
    for count in (8, 16, 32):
        points = _points(ellipse, count)
        spline, other = through(points, 1.5), also_through(points, 1.5)
        assert other.radius == pytest.approx(1.5, rel=1e-9)
        apart.append(max(math.dist(spline.at(phi)[:2], other.at(phi)[:2]) for phi in np.linspace(0.0, math.pi, 101)))
    assert apart[0] > 2 * apart[1] > 4 * apart[2] > 0.0


def test_profile_passes_through_its_points():
    points = ((0.0, 1.0), (0.7, 0.9), (1.0, 0.3), (0.8, -0.3), (0.75, -0.8), (0.5, -1.4), (0.0, -1.5))
    found = through(points, max(x for x, _ in points))
    fine = [found.at(math.pi * i / 4000) for i in range(4001)]
    middle = 0.5 * (points[0][1] + points[-1][1])
    size = (found.top - found.keel) / (points[0][1] - points[-1][1])  # its largest radius lies between two points
    for x, z in points:
        nearest = min(math.hypot(p[0] - size * x, p[1] - size * (z - middle)) for p in fine)
        assert nearest < 1e-3


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (((0, 1), (1, 0), (0, -1)), "received 3 points; needs at least five"),
        (((0, 1), (1, 0.5), (1, math.nan), (1, -0.5), (0, -1)), "no finite numbers"),
        (((0.2, 1), (1, 0.5), (1, 0), (1, -0.5), (0, -1)), r"first point at \(0.2, 1\), so the meridian is not closed"),
        (((0, 1), (1, 0.5), (1, 0), (1, -0.5), (0.3, -1)), r"last point at \(0.3, -1\), so the meridian is not closed"),
        (((0, -1), (1, -0.5), (1, 0), (1, 0.5), (0, 1)), "needs the top first"),
        (((0, 1), (1, 0.5), (0, 0), (1, -0.5), (0, -1)), "radius 0 between the poles"),
        (((0, 1), (1, 0.5), (1, 0.5), (1, -0.5), (0, -1)), "the same point twice in a row"),
        (((0, 1), (0.8, 1), (1.2, 0.2), (0.7, -0.6), (0.3, 0.2), (0.8, 0.4), (1.3, -0.6), (0.6, -1.4), (0, -1.4)),
         "crosses itself near"),
    ],
)  # fmt: skip
def test_invalid_profile_is_refused(points, message):
    with pytest.raises(ValueError, match=message):
        through(tuple((float(x), float(z)) for x, z in points), 1.0)


def test_meridian_that_crosses_the_axis_is_refused():
    with pytest.raises(ValueError, match=r"crosses the axis near \(-0.5, "):
        RestMeridian((1.0, 0.0, 1.5), (0.0, 1.0))
    with pytest.raises(ValueError, match="crosses the axis near"):
        RestMeridian((-1.0,), (0.0, 1.0))


BELL = RestMeridian((1.0,), (0.0, 1.0, 0.6))


@pytest.mark.parametrize("body", [BELL, RestMeridian((1.0, 0.3), (0.2, 1.0, -0.6)), BELL.scaled(2.0, 3.0, 5.0)])
@pytest.mark.parametrize("part", [0.1, 0.5, 0.95])
def test_volume_and_centroid_below_a_height_of_a_hollow_body(body, part):
    """Against sums of rings over a fine meridian cut at the height."""
    x, z = np.array([body.at(math.pi * i / 20000)[:2] for i in range(20001)]).T
    height = body.lowest + part * (body.highest - body.lowest)
    ring, cut = math.pi * (0.5 * (x[1:] + x[:-1])) ** 2, np.minimum(z, height)
    volume = -np.sum(ring * np.diff(cut))
    assert body.volume_below(height) == pytest.approx(volume, rel=2e-6)
    assert body.centroid_below(height) == pytest.approx(-np.sum(ring * np.diff(cut**2)) / 2 / volume, rel=2e-6)
    assert body.draft_of(volume) == pytest.approx(height - body.lowest, rel=2e-6)
    crossing = np.flatnonzero((z[1:] < height) != (z[:-1] < height))
    assert body.radius_at(height) == pytest.approx(x[crossing].max(), rel=2e-3)
    assert body.volume == pytest.approx(-np.sum(ring * np.diff(z)), rel=2e-6)


def test_profile_is_invariant_to_units_and_height():
    unit, raised = 1e-3, 7.0
    points = ((0.0, 1.0), (0.7, 0.9), (1.0, 0.3), (0.8, -0.3), (0.75, -0.8), (0.5, -1.4), (0.0, -1.5))
    own = through(points, 2.0)
    other = through(tuple((unit * x, unit * (z + raised)) for x, z in points), 2.0)
    assert other.radius == pytest.approx(2.0, rel=1e-9)
    assert other.top == pytest.approx(-other.keel, rel=1e-9)
    assert other.volume == pytest.approx(own.volume, rel=1e-9)
    assert len(other.radial) == pytest.approx(len(own.radial), abs=2)
    ends = ((unit * 0.9e-9, unit * 1.0), (-unit * 0.9e-9, -unit * 1.5))
    near = (ends[0], *((unit * x, unit * z) for x, z in points[1:-1]), ends[1])
    assert through(near, 2.0).volume == pytest.approx(own.volume, rel=1e-6)


@pytest.mark.parametrize("term", [5, 19, 41])
def test_volume_in_closed_form_for_any_term(term):
    """pi int x^2 z' of sin t + b sin kt and cos t, and of sin t and cos t + b cos kt, with int sin^2 t sin kt known."""
    share, b = 1 / term - 0.5 / (term + 2) - 0.5 / (term - 2), 0.01
    own = 1 - 0.5 / (2 * term + 1) + 0.5 / (2 * term - 1)  # int of sin^2 kt sin t
    ripple = (1.0, *(term - 2) * (0.0,), b)
    across, along = RestMeridian(ripple, (0.0, 1.0)), RestMeridian((1.0,), (0.0, *ripple))
    assert across.volume == pytest.approx(math.pi * (4 / 3 + 2 * b * share + b**2 * own), rel=1e-12)
    assert along.volume == pytest.approx(math.pi * (4 / 3 + term * b * share), rel=1e-12)
