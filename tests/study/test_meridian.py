import itertools
import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from vsb.study.meridian import JUNCTION, RestMeridian, _crossing, _spline, _terms, capsule, spheroid, through


def test_a_sphere_is_one_term_each():
    sphere = spheroid(2.0, 4.0)
    assert (sphere.radial, sphere.axial) == ((2.0,), (0.0, 2.0))
    assert sphere.volume == pytest.approx(4 / 3 * math.pi * 8, rel=1e-14)
    assert sphere.area == pytest.approx(16 * math.pi, rel=1e-14)
    assert sphere.curvatures(1.0) == pytest.approx((0.5, 0.5), rel=1e-14)
    assert (sphere.radius, sphere.top, sphere.keel) == (2.0, 2.0, -2.0)


@given(st.floats(0.2, 5.0), st.floats(0.1, 0.9))
def test_the_cap_of_a_spheroid(stretch, part):
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


def test_a_capsule_is_the_plain_one_with_smooth_junctions():
    body = capsule(1.5, 3.0)
    assert (body.radius, body.top, body.keel) == pytest.approx((1.5, 3.0, -3.0), rel=1e-12)
    plain = math.pi * 1.5**2 * 3.0 + 4 / 3 * math.pi * 1.5**3
    assert 0.001 < 1 - body.volume / plain < 0.02
    middle, cap = body.curvatures(math.pi / 2), body.curvatures(0.02)
    assert middle == pytest.approx((0.0, 1 / 1.5), abs=1e-5)
    assert cap == pytest.approx((1 / 1.5, 1 / 1.5), rel=0.03)
    length = 2 * math.pi * 1.5 / 4 + 1.5  # of the arc from a pole to the middle
    bends = [body.curvatures(math.pi / 2 * s / length)[0] for s in (2.3, 2.31, 2.4, 2.41, 2.5, 2.51)]
    assert all(a > b > 0 for a, b in itertools.pairwise(bends))
    steepest = max(abs(b - a) / 0.01 for a, b in zip(bends[::2], bends[1::2], strict=True))
    assert steepest == pytest.approx(1 / (math.sqrt(2 * math.pi) * JUNCTION * 1.5**2), rel=0.05)  # a Gaussian's


def test_half_of_a_capsule_floats_at_half_its_height():
    body = capsule(1.0, 1.0)
    assert body.draft_of(body.volume / 2) == pytest.approx(1.5, rel=1e-10)


def _points(shape, count):
    return tuple((0.0 if i in (0, count) else shape(math.pi * i / count)[0], shape(math.pi * i / count)[1])
                 for i in range(count + 1))  # fmt: skip


def test_points_of_an_ellipse_give_the_spheroid_at_fourth_order_or_more():
    def ellipse(phi):
        return 3 * math.sin(phi), 2 * math.cos(phi)

    exact = spheroid(1.5, 2.0)
    errors = [abs(through(_points(ellipse, n), 1.5).volume / exact.volume - 1) for n in (8, 16)]
    assert 3.5 < math.log2(errors[0] / errors[1]) < 6.0
    assert errors[1] < 1e-5
    found = through(_points(ellipse, 24), 1.5)
    assert found.radius == pytest.approx(1.5, rel=1e-9)
    assert found.top == pytest.approx(-found.keel, abs=1e-12) == pytest.approx(1.0, rel=1e-4)


def test_a_profile_passes_through_its_points():
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
def test_what_bounds_no_body_is_refused(points, message):
    with pytest.raises(ValueError, match=message):
        through(tuple((float(x), float(z)) for x, z in points), 1.0)


@pytest.mark.parametrize("turned", [-1.0, 1.0])
def test_a_meridian_that_leaves_a_pole_along_the_axis_is_refused(turned):
    """Of the radius sin t (1 - cos t) the slope is 0 at the top, of sin t (1 + cos t) at the keel: a cusp each."""
    with pytest.raises(ValueError, match=r"crosses the axis near .*; needs one clear of it between its poles"):
        RestMeridian((1.0, turned / 2), (0.0, 1.0))


def test_a_meridian_that_meets_the_axis_is_refused():
    with pytest.raises(ValueError, match=r"crosses the axis near \(-0.5, "):
        RestMeridian((1.0, 0.0, 1.5), (0.0, 1.0))
    with pytest.raises(ValueError, match="crosses the axis near"):
        RestMeridian((-1.0,), (0.0, 1.0))


def test_a_profile_with_more_turns_than_terms_is_refused():
    saw = [(math.sin(math.pi * i / 300) * (1 + 0.01 * (-1) ** i), math.cos(math.pi * i / 300)) for i in range(1, 300)]
    with pytest.raises(ValueError, match="turn too sharply for a smooth meridian"):
        through(((0.0, 1.0), *saw, (0.0, -1.0)), 1.0)


def test_terms_are_numbers():
    with pytest.raises(ValueError, match="received NaN or infinite numbers"):
        RestMeridian((1.0,), (0.0, math.inf))


@pytest.mark.parametrize(("ratio", "small", "count"), [(0.5, 2.0**-12.5, 16), (0.5, 2.0**-20.5, 24), (0.1, 1e-3, 9)])
def test_terms_end_with_four_small_ones_and_are_nine_at_least(ratio, small, count):
    """Of a function sum q^k cos k phi, and of sum (-q)^k sin k phi."""
    phi = np.pi * (np.arange(200) + 0.5) / 200
    k = np.arange(1, 60)[:, None]
    even, odd = (ratio**k * np.cos(k * phi)).sum(axis=0), ((-ratio) ** k * np.sin(k * phi)).sum(axis=0)
    cosines, sines = _terms(even.tolist(), odd.tolist(), small)
    assert len(cosines) == len(sines) == count
    assert cosines == pytest.approx(ratio ** np.arange(1.0, count + 1), abs=1e-14)
    assert sines == pytest.approx((-ratio) ** np.arange(1.0, count + 1), abs=1e-14)


@pytest.mark.parametrize("height", [-1.01, 1.01])
def test_beyond_a_body_it_has_no_radius(height):
    sphere = spheroid(1.0, 2.0)
    assert sphere.radius_at(height) == 0.0
    assert sphere.radius_at(0.6) == pytest.approx(0.8)


def test_an_overhang_floats_too():
    """A bell, hollow from below: water up to its rim fills the hollow."""
    bell = RestMeridian((1.0,), (0.0, 1.0, 0.6))
    assert bell.keel < bell.highest
    assert bell.lowest < bell.keel
    total = bell.volume
    assert bell.draft_of(total / 2) + bell.keel > bell.lowest
    below, above = (bell.volume_below(bell.keel + d) for d in (-0.05, 0.05))
    assert 0 < below < above < total


@pytest.mark.parametrize("natural", [True, False])
def test_the_spline_is_that_of_scipy(natural):
    """Steps far from equal; no curvature at both ends, or no slope."""
    at, values = np.array([0.0, 0.3, 1.7, 1.9, 4.0]), np.array([1.0, -2.0, 0.5, 3.0, 2.0])
    found, exact = (
        _spline(at.tolist(), values.tolist(), natural),
        CubicSpline(at, values, bc_type="natural" if natural else "clamped"),
    )
    for s in np.linspace(0.0, 4.0, 23):
        assert found(float(s)) == pytest.approx(float(exact(s)), rel=1e-11, abs=1e-11)


BELL = RestMeridian((1.0,), (0.0, 1.0, 0.6))


@pytest.mark.parametrize("body", [BELL, RestMeridian((1.0, 0.3), (0.2, 1.0, -0.6)), BELL.scaled(2.0, 3.0, 5.0)])
@pytest.mark.parametrize("part", [0.1, 0.3, 0.5, 0.8, 0.95])
def test_what_is_below_a_height_of_a_hollow_body_is_between_its_walls(body, part):
    """By sums of rings over a fine meridian, cut at the height; hollow from below or from above."""
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


def test_poles_and_ends_of_a_hollow_body():
    """z = cos t + 0.6 cos 2t is least where 1 + 2.4 cos t is 0, above its keel."""
    rim = -1 / 2.4 + 0.6 * (2 / 2.4**2 - 1)
    assert (BELL.top, BELL.keel, BELL.highest) == pytest.approx((1.6, -0.4, 1.6), rel=1e-14)
    assert BELL.lowest == pytest.approx(rim, rel=1e-4)
    moved = BELL.scaled(2.0, 3.0, 5.0)
    assert (moved.top, moved.keel, moved.highest) == pytest.approx((9.8, 3.8, 9.8), rel=1e-14)
    assert moved.lowest == pytest.approx(5 + 3 * rim, rel=1e-4)
    assert moved.radius == pytest.approx(2.0, rel=1e-13)


@pytest.mark.parametrize("second", [-0.3, -0.11, -0.01, 0.01, 0.04, 0.11, 0.3])
def test_the_largest_radius_is_between_the_samples(second):
    """Of sin t + b sin 2t: where cos t + 2 b cos 2t is 0."""
    cosine = (-1 + math.sqrt(1 + 32 * second**2)) / (8 * second)
    widest = math.sqrt(1 - cosine**2) * (1 + 2 * second * cosine)
    assert RestMeridian((1.0, second), (0.0, 1.0)).radius == pytest.approx(widest, rel=1e-13)


@pytest.mark.parametrize(("unit", "raised"), [(1e-3, 0.0), (1e3, 7.0)])
def test_a_profile_is_the_same_in_any_unit_from_any_height(unit, raised):
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


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (((0, 1), (1, 0.5), (1, -0.5), (0, -1)), "received 4 points; needs at least five, from the top to the keel"),
        (((-0.2, 1), (1, 0.5), (1, 0), (1, -0.5), (0, -1)), r"received the first point at \(-0.2, 1\), so the merid"),
        (((0, 1), (1, 0.5), (1, 0), (1, -0.5), (-0.2, -1)), r"received the last point at \(-0.2, -1\), so the merid"),
        (((2e-9, 1), (1, 0.5), (1, 0), (1, -0.5), (0, -1)), r"received the first point at \(2e-09, 1\), so the merid"),
        (((0, 1), (1, 0.5), (1, 0), (1, 0.5), (0, 1)), "a first point at height 1 and a last one at 1; needs the top"),
        (((0, 1), (1, 0.5), (-0.5, 0), (1, -0.5), (0, -1)), "received a point at radius -0.5 between the poles; need"),
        (((0, math.inf), (1, 0.5), (1, 0), (1, -0.5), (0, -1)), "received points that are no finite numbers; needs fin"),
        (((0, 1), (1, 0.5), (1, 0), (1, -0.5), (math.nan, -1)), "received points that are no finite numbers; needs f"),
    ],
)  # fmt: skip
def test_a_profile_begins_and_ends_on_the_axis_with_the_top_first(points, message):
    with pytest.raises(ValueError, match=message):
        through(tuple((float(x), float(z)) for x, z in points), 1.0)


def test_five_points_are_a_profile():
    found = through(((0.0, 1.0), (0.8, 0.6), (1.0, 0.0), (0.8, -0.6), (0.0, -1.0)), 1.0)
    assert found.volume == pytest.approx(4 / 3 * math.pi, rel=0.02)


def test_a_profile_may_have_a_flat_top_and_a_straight_side():
    """Only all of a point given twice is one too many: here neither height nor radius is."""
    points = ((0.0, 1.0), (0.5, 1.0), (0.9, 0.6), (1.0, 0.2), (1.0, -0.2), (0.9, -0.6), (0.5, -1.0), (0.0, -1.0))
    found = through(points, 1.0)
    assert found.radius == pytest.approx(1.0, rel=1e-9)
    assert found.volume > 4 / 3 * math.pi


def test_the_sharpest_place_may_bend_inwards_or_around_the_axis():
    """At a waist, of curvatures x''/z'^2 of the meridian and 1/x of the parallel."""
    dented, narrow = RestMeridian((1.0, 0.0, 0.3), (0.0, 1.0, 0.0, 0.1)), RestMeridian((1.0, 0.0, 0.6), (0.0, 4.0))
    assert dented.curvatures(math.pi / 2) == pytest.approx((-1.7 / 0.7**2, 1 / 0.7), rel=1e-13)
    assert dented.sharpest == pytest.approx(0.7**2 / 1.7, rel=1e-9)
    assert narrow.curvatures(math.pi / 2) == pytest.approx((-4.4 / 4.0**2, 1 / 0.4), rel=1e-13)
    assert narrow.sharpest == pytest.approx(0.4, rel=1e-9)


def test_a_polygon_that_crosses_itself_is_told_where_that_side_begins():
    """The first of them, which is crossed by the next but one; one that only turns back crosses nothing."""
    crossed = [(0.0, 0.0, 2.0), (1.0, 2.0, 0.0), (2.0, 2.0, 2.0), (3.0, 0.0, 0.0)]
    assert _crossing(crossed) == (0.0, 2.0)
    assert _crossing([(-1.0, 0.0, 3.0), *crossed]) == (0.0, 2.0)
    assert _crossing([*crossed[:3], (3.0, 3.0, 0.0)]) is None
    assert _crossing([*crossed[:3], (3.0, 1.1, 1.1)]) is None


@pytest.mark.parametrize("term", [5, 19, 41])
def test_a_volume_is_that_of_all_terms_of_either_coordinate(term):
    """pi int x^2 z' of sin t + b sin kt and cos t, and of sin t and cos t + b cos kt, with int sin^2 t sin kt known."""
    share, b = 1 / term - 0.5 / (term + 2) - 0.5 / (term - 2), 0.01
    own = 1 - 0.5 / (2 * term + 1) + 0.5 / (2 * term - 1)  # int of sin^2 kt sin t
    ripple = (1.0, *(term - 2) * (0.0,), b)
    across, along = RestMeridian(ripple, (0.0, 1.0)), RestMeridian((1.0,), (0.0, *ripple))
    assert across.volume == pytest.approx(math.pi * (4 / 3 + 2 * b * share + b**2 * own), rel=1e-12)
    assert along.volume == pytest.approx(math.pi * (4 / 3 + term * b * share), rel=1e-12)


@pytest.mark.parametrize("height", [0.4, 0.8, 10.0, 40.0])
def test_the_area_of_flat_and_slender_spheroids_is_right_to_the_last_digits(height):
    a, c = 2.0, height / 2
    e = math.sqrt(1 - (min(a, c) / max(a, c)) ** 2)
    sides = (1 - e**2) / e * math.atanh(e) if c < a else c / (a * e) * math.asin(e)
    assert spheroid(a, height).area == pytest.approx(2 * math.pi * a**2 * (1 + sides), rel=1e-13)


def test_a_meridian_is_told_where_it_crosses_itself():
    """By its symmetry at its middle, where 0.5 c + 0.7 (4 c^3 - 3 c) is 0 for c = cos t: c^2 = 4/7."""
    sine = math.sqrt(3 / 7)
    x = 1.5 * sine + 0.8 * (3 * sine - 4 * sine**3)
    with pytest.raises(ValueError, match="received a meridian that crosses itself near") as refused:
        RestMeridian((1.5, 0.0, 0.8), (0.3, 0.5, 0.0, 0.7))
    told = [
        float(number) for number in re.search(r"\((.*), (.*)\) m; needs one that does not", str(refused.value)).groups()
    ]
    assert told == pytest.approx([x, 0.3], abs=0.03)


def test_points_a_smooth_meridian_misses_are_told():
    saw = [(math.sin(math.pi * i / 300) * (1 + 0.01 * (-1) ** i), math.cos(math.pi * i / 300)) for i in range(1, 300)]
    with pytest.raises(ValueError, match="turn too sharply for a smooth meridian") as refused:
        through(((0.0, 1.0), *saw, (0.0, -1.0)), 1.0)
    x, z = re.search(r"near \((.*), (.*)\); needs fewer turns", str(refused.value)).groups()
    assert (x, z) in {(f"{x:.4g}", f"{z:.4g}") for x, z in saw}


@pytest.mark.parametrize("height", [1 - 1e-6, 1 - 1e-4, -1 + 1e-6, -1 + 1e-4])
def test_a_radius_is_told_to_the_poles(height):
    sphere = spheroid(1.0, 2.0)
    assert sphere.radius_at(height) == pytest.approx(math.sqrt(1 - height**2), rel=1e-9)
    assert sphere.volume_below(height) == pytest.approx(
        math.pi * (1 + height) ** 2 * (2 - height) / 3, rel=1e-6, abs=1e-14
    )


def test_a_meridian_whose_height_has_more_terms_than_its_radius_is_looked_at_finely_enough_for_both():
    """Eight points a term: its lowest place beside the keel is found to (pi/16)^2/2 of the term."""
    phi = [math.pi * i / 200_000 for i in range(200_001)]
    lowest = min(2.0 * math.cos(x) + 0.02 * math.cos(90 * x) for x in phi)
    found = RestMeridian((2.0,), (0.0, 2.0, *88 * (0.0,), 0.02))
    assert lowest < found.keel - 0.03
    assert found.lowest == pytest.approx(lowest, abs=0.02 * (math.pi / 16) ** 2 / 2)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", range(4))
def test_every_term_of_either_coordinate_is_a_finite_number(value, place):
    terms = [1.0, 0.1, 0.0, 1.0]
    terms[place] = value
    with pytest.raises(ValueError, match="received NaN or infinite numbers; needs finite ones"):
        RestMeridian(tuple(terms[:2]), tuple(terms[2:]))
