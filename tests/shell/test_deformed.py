import re
import tracemalloc
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import varied
from hypothesis import example, given, settings
from hypothesis import strategies as st
from shell.test_sphere import STRETCH, larger

from vsb.errors import ConfigError
from vsb.hydro.dofs import Displacement
from vsb.hydro.panels.mesh import deformed_mesh
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.shell import deformed as deformed_module
from vsb.shell.deformed import (
    DeformedShell,
    _crossing,
    _curl,
    check_meridian,
    enclosed,
    gauss_rule,
    rigid_buoy,
    rigid_sphere,
)
from vsb.shell.loaded import complete_basis
from vsb.shell.modes import ModeBasis, mode_basis, shell_modes
from vsb.shell.sphere import Shell
from vsb.study.meridian import RestMeridian, capsule

RHO, G = 1025.0, 9.81


@pytest.fixture(scope="module")
def full(seed):
    return mode_basis(seed.device, "full", 6)


def amplitudes(full, **by_label):
    return np.array([by_label.get(label, 0.0) for label in full.labels])


@pytest.mark.parametrize("height", [-1.5, -0.3, 0.0, 0.7, 1.9])
def test_cap_of_a_sphere(full, height):
    shell, depth = DeformedShell(full, height), 2.0 - height
    assert shell.volume() == pytest.approx(np.pi * depth**2 * (6.0 - depth) / 3, rel=1e-12)
    assert shell.wet_area() == pytest.approx(2 * np.pi * 2.0 * depth, rel=1e-12)


def test_breathing_is_a_larger_sphere(full):
    larger = DeformedShell(full, 0.4, amplitudes(full, Membrane0=0.3))
    depth = 2.3 - 0.4
    assert larger.volume() == pytest.approx(np.pi * depth**2 * (6.9 - depth) / 3, rel=1e-12)


def test_dry_submerged_and_several_waterlines(full):
    assert DeformedShell(full, 2.5).wet_segments == []
    assert DeformedShell(full, 2.5).volume() == 0.0
    assert np.all(DeformedShell(full, 2.5).hydrostatic_force(RHO, G) == 0.0)
    assert DeformedShell(full, -2.5).wet_segments == [(0.0, np.pi)]
    assert DeformedShell(full, -2.5).volume() == pytest.approx(4 / 3 * np.pi * 8, rel=1e-12)
    dented = DeformedShell(full, -1.7, amplitudes(full, Bending6=-0.4))  # the top pole dips under, a ring stays out
    assert len(dented.wet_segments) == 2


@settings(max_examples=25)
@given(st.lists(st.floats(-0.05, 0.05), min_size=12, max_size=12), st.floats(-0.8, 0.8))
def test_buoyancy_is_the_weight_of_displaced_water(full, modal, height):
    """Archimedes for any deformed shape."""
    shell = DeformedShell(full, height, np.array([0.0, *modal]))
    assert shell.hydrostatic_force(RHO, G)[0] == pytest.approx(RHO * G * shell.volume(), rel=1e-10)


@pytest.mark.parametrize("height", [-0.6, 0.0, 0.00031, 0.9])
@pytest.mark.parametrize("deformed", [False, True])
def test_stiffness_is_the_exact_symmetric_jacobian(full, height, deformed):
    start = np.array([0.02, -0.03, 0.04, *np.linspace(-0.05, 0.05, 10)]) * deformed

    def force(q):
        return DeformedShell(full, height, q).hydrostatic_force(RHO, G)

    def central(j, h):
        return (force(start + h * np.eye(13)[j]) - force(start - h * np.eye(13)[j])) / (2 * h)

    stiffness = DeformedShell(full, height, start).hydrostatic_stiffness(RHO, G)
    largest = np.abs(stiffness).max()
    assert np.abs(stiffness - stiffness.T).max() < 1e-11 * largest
    h = 2e-3
    richardson = np.array([
        (64 * central(j, h / 4) - 20 * central(j, h / 2) + central(j, h)) / 45 for j in range(13)
    ]).T  # fmt: skip
    assert np.abs(stiffness + richardson).max() < 1e-9 * largest


def test_heave_stiffness_is_that_of_the_waterplane(full):
    stiffness = DeformedShell(full, 0.5).hydrostatic_stiffness(RHO, G)
    assert stiffness[0, 0] == pytest.approx(RHO * G * np.pi * (4.0 - 0.25), rel=1e-12)


def test_quadrature_converges_spectrally(full):
    shell = DeformedShell(full, 0.1, amplitudes(full, Membrane2=0.1, Bending4=-0.08))
    exact = shell.volume(120)
    errors = [abs(shell.volume(n) / exact - 1) for n in (6, 10, 14, 18, 40)]
    assert errors[-1] < 1e-12
    assert errors[0] > 100 * errors[1] > 1e4 * errors[3]


CROSSING = {"Bending6": -0.4}
"""With the centre at -1.7 m the top pole dips under water and a ring stays out: three waterlines."""


def jacobian_by_differences(basis, height, start, h=2e-3):
    """Central differences, two Richardson steps, of minus the hydrostatic force."""

    def central(j, h):
        ahead, behind = (
            DeformedShell(basis, height, start + s * np.eye(len(start))[j]).hydrostatic_force(RHO, G) for s in (h, -h)
        )
        return (behind - ahead) / (2 * h)

    return np.array([
        (64 * central(j, h / 4) - 20 * central(j, h / 2) + central(j, h)) / 45 for j in range(len(start))
    ]).T  # fmt: skip


@pytest.mark.parametrize("height", [-1.72, -1.7, -2.6, 2.6], ids=["two bands", "two bands again", "submerged", "dry"])
def test_jacobian_with_several_waterlines_one_or_none(full, height):
    start = amplitudes(full, **CROSSING) if abs(height) < 2 else amplitudes(full, Membrane2=0.1, Bending3=-0.1)
    shell = DeformedShell(full, height, start)
    assert len(shell.wet_segments) == {-1.72: 2, -1.7: 2, -2.6: 1, 2.6: 0}[height]
    stiffness = shell.hydrostatic_stiffness(RHO, G)
    largest = max(np.abs(stiffness).max(), 1.0)
    assert np.abs(stiffness - stiffness.T).max() <= 1e-11 * largest
    assert np.abs(stiffness - jacobian_by_differences(full, height, start)).max() <= 1e-8 * largest


@pytest.mark.parametrize("height", [-0.9, 0.0, 1.2])
def test_heave_stiffness_of_a_deformed_shell_is_that_of_its_waterplane(full, height):
    shell = DeformedShell(full, height, amplitudes(full, Heave=0.1, Membrane0=0.05, Membrane3=-0.1, Bending2=0.2))
    ((start, _),) = shell.wet_segments
    waterplane = np.pi * shell.meridian(np.array([start])).x[0] ** 2
    assert shell.hydrostatic_stiffness(RHO, G)[0, 0] == pytest.approx(RHO * G * waterplane, rel=1e-11)


def test_heave_stiffness_of_a_ring_shaped_waterplane(full):
    shell = DeformedShell(full, -1.7, amplitudes(full, **CROSSING))
    (_, inner), (outer, _) = shell.wet_segments
    radii = shell.meridian(np.array([inner, outer])).x
    ring = np.pi * (radii[1] ** 2 - radii[0] ** 2)
    assert shell.hydrostatic_stiffness(RHO, G)[0, 0] == pytest.approx(RHO * G * ring, rel=1e-9)


def test_every_waterline_lies_on_the_water(full):
    shell = DeformedShell(full, -1.7, amplitudes(full, **CROSSING))
    assert shell.wet_segments[0][0] == 0.0
    assert shell.wet_segments[-1][1] == np.pi
    waterlines = [edge for segment in shell.wet_segments for edge in segment if 0.0 < edge < np.pi]
    assert np.abs(shell.meridian(np.array(waterlines)).z).max() < 1e-14
    for start, end in shell.wet_segments:
        assert shell.meridian(np.linspace(start, end, 203)[1:-1]).z.max() < 0


def test_half_submerged_sphere_is_wet_below_its_equator(full):
    (segment,) = DeformedShell(full, 0.0).wet_segments
    assert segment == pytest.approx((np.pi / 2, np.pi), abs=1e-14)


@settings(max_examples=50)
@given(st.floats(-1.99, 1.99))
def test_waterline_of_the_sphere_at_any_height(full, height):
    (segment,) = DeformedShell(full, height).wet_segments
    assert segment == pytest.approx((np.arccos(-height / 2), np.pi), abs=1e-12)


@pytest.mark.parametrize("node", [1, 93, 140, 200])
def test_waterline_exactly_on_a_sampled_colatitude(full, node):
    height = -2.0 * float(np.cos(np.linspace(0.0, np.pi, 281)[node]))
    depth = 2.0 - height
    assert DeformedShell(full, height).volume() == pytest.approx(np.pi * depth**2 * (6.0 - depth) / 3, rel=1e-12)


@pytest.mark.parametrize(("height", "swell"), [(0.4, 0.3), (-0.8, -0.2), (-3.0, 0.5), (1.1, 0.0)])
def test_breathing_is_exactly_a_sphere_of_another_radius(full, height, swell):
    radius = 2.0 + swell
    shell, depth = DeformedShell(full, height, amplitudes(full, Membrane0=swell)), min(radius - height, 2 * radius)
    assert shell.volume() == pytest.approx(np.pi * depth**2 * (3 * radius - depth) / 3, rel=1e-12)
    assert shell.wet_area() == pytest.approx(2 * np.pi * radius * depth, rel=1e-12)


@pytest.mark.parametrize("heave", [-0.7, 0.0, 0.35])
def test_heave_lifts_the_sphere(full, heave):
    lifted, placed = DeformedShell(full, 0.2, amplitudes(full, Heave=heave)), DeformedShell(full, 0.2 + heave)
    assert lifted.volume() == pytest.approx(placed.volume(), rel=1e-13)
    assert lifted.hydrostatic_force(RHO, G) == pytest.approx(placed.hydrostatic_force(RHO, G), rel=1e-11, abs=1e-8)


@pytest.mark.parametrize(
    ("height", "modal"),
    [
        (-0.4, {"Membrane2": 0.3}),
        (0.6, {"Bending5": 0.2, "Membrane1": -0.2}),
        (-1.7, CROSSING),
        (-2.7, {"Bending4": 0.3}),
    ],
)
def test_archimedes_for_strongly_deformed_shells(full, height, modal):
    shell = DeformedShell(full, height, amplitudes(full, **modal))
    assert shell.hydrostatic_force(RHO, G)[0] == pytest.approx(RHO * G * shell.volume(), rel=1e-11)


def test_breathing_force_and_stiffness_of_the_half_submerged_sphere(full):
    """Q_0 = -rho g pi R^3 for a sphere of any radius R with its centre in the surface, so K_00 = 3 rho g pi r^2."""
    shell = DeformedShell(full, 0.0)
    assert shell.hydrostatic_force(RHO, G)[1] == pytest.approx(-RHO * G * np.pi * 8, rel=1e-12)
    assert shell.hydrostatic_stiffness(RHO, G)[1, 1] == pytest.approx(3 * RHO * G * np.pi * 4, rel=1e-12)


def test_breathing_force_under_water_is_mean_pressure_times_area(full):
    force = DeformedShell(full, -5.0).hydrostatic_force(RHO, G)
    assert force[1] == pytest.approx(-RHO * G * 5.0 * 16 * np.pi, rel=1e-12)
    assert force[0] == pytest.approx(RHO * G * 32 / 3 * np.pi, rel=1e-12)


def test_a_submerged_body_has_no_heave_stiffness(full):
    stiffness = DeformedShell(full, -5.0, amplitudes(full, Membrane2=0.2)).hydrostatic_stiffness(RHO, G)
    assert abs(stiffness[0, 0]) < 1e-10 * np.abs(stiffness).max()


def test_force_is_the_gradient_of_the_displaced_potential_energy(full):
    """Q_j = -dE/dq_j with E = -rho g int z dV over the displaced water."""
    node, weight = np.polynomial.legendre.leggauss(80)

    def energy(q):
        shell = DeformedShell(full, 0.2, q)
        ((a, b),) = shell.wet_segments
        m = shell.meridian((a + b) / 2 + (b - a) / 2 * node)
        return RHO * G * np.pi * np.sum((b - a) / 2 * weight * m.z * m.x**2 * m.dz)

    start, h = amplitudes(full, Membrane2=0.05, Bending3=-0.05), 2e-3
    slopes = [
        [(energy(start + k * e) - energy(start - k * e)) / (2 * k) for k in (h, h / 2, h / 4)] for e in np.eye(13)
    ]
    gradient = np.array([(64 * c - 20 * b + a) / 45 for a, b, c in slopes])
    force = DeformedShell(full, 0.2, start).hydrostatic_force(RHO, G)
    assert np.abs(force + gradient).max() < 1e-9 * np.abs(force).max()


def test_derivatives_of_the_meridian(full):
    shell = DeformedShell(full, 0.1, amplitudes(full, Membrane2=0.3, Bending5=0.2))
    phi, h = np.linspace(0.0, np.pi, 37), 1e-5
    ahead, here, behind = (shell.meridian(phi + s) for s in (h, 0.0, -h))
    for value, slope in (("x", "dx"), ("z", "dz"), ("shape_x", "dshape_x"), ("shape_z", "dshape_z")):
        difference = (getattr(ahead, value) - getattr(behind, value)) / (2 * h)
        assert getattr(here, slope) == pytest.approx(difference, abs=1e-7)


def spheroid(full, across, along):
    """Amplitudes that stretch the sphere to semi-axes `across` and `along` [m]: degrees 0 and 2 hold it exactly."""
    a, b = along / 2.0 - 1, across / 2.0 - 1  # relative stretch of height and radius
    shapes = {mode.label: (mode.radial, mode.meridional) for mode in full.shapes}
    # v = r (b + (a - b) cos^2), u = r (b - a) sin cos in P_0, P_2 and dP_2/dphi = -3 sin cos
    wanted = 2.0 * np.array([2 * (a - b) / 3, (a - b) / 3])
    pair = np.linalg.solve(np.array([shapes["Membrane2"], shapes["Bending2"]]).T, wanted)
    return amplitudes(full, Membrane0=2.0 * (b + (a - b) / 3), Membrane2=pair[0], Bending2=pair[1])


def spheroid_area(across, along):
    """Surface of a spheroid of revolution, textbook formula."""
    if along > across:
        e = np.sqrt(1 - (across / along) ** 2)
        return 2 * np.pi * across**2 * (1 + along / (across * e) * np.arcsin(e))
    e = np.sqrt(1 - (along / across) ** 2)
    return 2 * np.pi * across**2 * (1 + (1 - e**2) / e * np.arctanh(e))


@pytest.mark.parametrize(
    ("across", "along"), [(2.2, 1.8), (1.8, 2.3), (1.9, 2.6)], ids=["oblate", "prolate", "slender"]
)
def test_volume_and_area_of_spheroids(full, across, along):
    q = spheroid(full, across, along)
    half = DeformedShell(full, 0.0, q)
    assert half.volume(40) == pytest.approx(2 / 3 * np.pi * across**2 * along, rel=1e-12)
    assert half.wet_area(40) == pytest.approx(spheroid_area(across, along) / 2, rel=1e-12)
    volume, area = enclosed(full, q[None], 40)
    assert volume[0] == pytest.approx(4 / 3 * np.pi * across**2 * along, rel=1e-12)
    assert area[0] == pytest.approx(spheroid_area(across, along), rel=1e-12)


def test_enclosed_volume_and_area_forget_heave(full):
    q = np.array([amplitudes(full, Heave=h, Membrane2=0.1, Bending3=0.05) for h in (0.0, 0.4, -3.0)])
    volume, area = enclosed(full, q)
    assert np.ptp(volume) < 1e-12
    assert np.ptp(area) < 1e-12


CROSSED = {
    "axis": {"Membrane1": 2.0},
    "waist": {"Bending2": 5.0},
    "poles": {"Membrane2": -2.5},
    "itself": {"Membrane4": 1.2},
}
"""Shapes whose meridian crosses the axis near a pole, in between, from pole to pole, or itself."""


def first_crossing(points):
    """The first two sides but neighbours that meet, by the place on each where their lines do."""
    sides = list(pairwise(points))
    for i, (a, b) in enumerate(sides):
        for j, (c, d) in enumerate(sides[i + 2 :], i + 2):
            s, t = np.linalg.solve(np.column_stack([b - a, c - d]), c - a)
            if 0 <= s <= 1 and 0 <= t <= 1:
                return i, j
    return None


@pytest.mark.parametrize("sides", [3, 4, 6, 40])
def test_the_first_crossing_of_a_polygon_is_found_however_near_its_sides_are(sides):
    """A random walk; of three sides the first and the last alone may cross."""
    random, found = np.random.default_rng(sides), []
    for _ in range(30):
        points = np.cumsum(random.normal(size=(sides + 1, 2)), axis=0)
        found.append(first_crossing(points))
        assert _crossing(*points.T) == found[-1]
    assert len({*found}) > 1


@pytest.mark.parametrize("crossed", CROSSED)
@pytest.mark.parametrize("solver", ["spectral", "panels", "check"])
def test_a_meridian_that_crosses_the_axis_or_itself_is_refused(full, crossed, solver):
    """The one gave NaN, the other was solved."""
    shell = DeformedShell(full, 0.2, amplitudes(full, **CROSSED[crossed]))
    use = {
        "spectral": lambda: SpectralProblem(shell, (Displacement("heave"),), RHO, G, 8).at_infinity(),
        "panels": lambda: deformed_mesh(shell, 12, 24, 6),
        "check": lambda: check_meridian(shell),
    }
    where = "itself" if crossed == "itself" else "the axis"
    with pytest.raises(ConfigError, match=f"^reference_shape: received a meridian that crosses {where} .*; needs one"):
        use[solver]()


@pytest.mark.parametrize(
    "wet",
    [[], [(0.0, np.pi)], [(1.0, 2.5)], [(0.0, 1.0)], [(0.5, 1.0), (2.0, np.pi)]],
    ids=["dry", "sunk", "keel out", "top", "two"],
)
def test_what_floats_has_one_waterline_with_the_keel_below(full, wet):
    shell = DeformedShell(full, 0.2)
    shell.__dict__["wet_segments"] = wet
    with pytest.raises(ConfigError, match=r"wet parts are .* needs one waterline with the keel below it"):
        assert shell.waterline
    sound = DeformedShell(full, 0.2)
    sound.__dict__["wet_segments"] = [(1.0, np.pi)]
    assert sound.waterline == 1.0


@pytest.mark.parametrize(("pole", "name"), [(0.0, "top"), (np.pi, "keel")])
def test_a_shell_turned_in_at_one_pole_alone_is_refused(full, pole, name):
    """By a slope of 1e-6 m, far nearer to the pole than any other point that is looked at; turned out as much it is one."""
    m, at = DeformedShell(full, 0.0).meridian(np.array([pole])), full.labels.index("Membrane3")

    def shell(slope):
        q = np.zeros(len(full.labels))
        q[at] = (np.cos(pole) * slope - m.dx[0]) / m.dshape_x[at, 0]
        return DeformedShell(full, 0.0, q)

    assert shell(-1e-6)._on_grid[0][1:-1].min() > 0
    check_meridian(shell(1e-6))
    slopes = {"top": "slope -1e-06 m at the top, -4 m at the keel", "keel": "slope 4 m at the top, 1e-06 m at the keel"}
    with pytest.raises(
        ConfigError, match=rf"that crosses the axis \(radius .* m at colatitude .* rad, {slopes[name]}\)"
    ):
        check_meridian(shell(-1e-6))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_meridian_without_points_is_refused(full, value):
    with pytest.raises(ConfigError, match="received a shape with NaN or infinite amplitudes; needs finite ones"):
        check_meridian(DeformedShell(full, 0.0, amplitudes(full, Membrane2=value)))


def test_a_shape_not_seen_whole_from_its_centre_is_none_the_worse(full):
    """Overhanging, dented past the centre: a surface all the same."""
    for shape in ({"Bending3": 2.0}, {"Bending5": -3.0}, {"Bending2": 3.0}):
        check_meridian(DeformedShell(full, 0.2, amplitudes(full, **shape)))


CURL = [-0.2611952595029945, 0.0703125, -0.5437249483965709, *[0.0] * 3, 0.263671875, -0.55859375, 0.0703125, 0.0,
        0.6875, 0.6953125]  # fmt: skip
"""Amplitudes of a curl between two points that are looked at."""


@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_a_curl_is_where_it_is_told(full, turned):
    """Where the meridian turns back it hardly goes on: between two neighbours on the grid, upside down as well."""
    shell = DeformedShell(full, 0.0, np.array([0.0, *CURL]) * np.power(turned, full.degrees))
    first, last = _curl(shell)
    phi = np.linspace(0.0, np.pi, 40001)
    m = shell.meridian(phi)
    assert last == first + 1
    assert shell._grid[first] <= phi[np.argmin(np.hypot(m.dx, m.dz))] <= shell._grid[last]
    told = f"crosses itself (colatitudes {shell._grid[first]:.3g} and {shell._grid[last]:.3g} rad)"
    with pytest.raises(ConfigError, match=re.escape(told)):
        check_meridian(shell)


@pytest.mark.parametrize(
    ("share", "expected"), [(0.0, (0, 1)), (0.3, (1, 2)), (0.5, (2, 3)), (0.9, (3, 4)), (1.0, (4, 4))]
)
def test_a_curl_lies_between_points_of_the_grid_also_at_a_pole(share, expected):
    """Told is where the meridian hardly goes on: a tangent that turns by half a circle too much, or the other way."""

    def made(turns):
        def meridian(phi):
            speed = 0.1 + np.abs(phi - share * np.pi)
            return SimpleNamespace(dx=speed * np.cos(turns * phi), dz=speed * np.sin(turns * phi))

        return SimpleNamespace(_grid=np.linspace(0.0, np.pi, 5), meridian=meridian)

    assert [_curl(made(turns)) for turns in (-3, -2, 0, 1)] == [expected] * 4
    assert _curl(made(-1)) is None


@settings(max_examples=200)
@given(st.lists(st.floats(-0.7, 0.7), min_size=12, max_size=12))
@example(CURL)
def test_a_meridian_that_passes_turns_once(full, modal):
    """Hopf: the tangent of a closed curve that does not meet itself turns by 2 pi, from pole to pole by half of it."""
    shell = DeformedShell(full, 0.0, np.array([0.0, *modal]))
    m = shell.meridian(np.linspace(0.0, np.pi, 4001))
    turned = np.unwrap(np.arctan2(m.dz, m.dx))
    crosses_axis = bool(m.x[1:-1].min() < -1e-3)
    try:
        check_meridian(shell)
    except ConfigError:
        return
    assert not crosses_axis
    assert turned[-1] - turned[0] == pytest.approx(-np.pi, abs=1e-6)


def test_the_stiffness_of_a_thousand_shapes_takes_no_cube_of_memory():
    """The integrand of 241 shapes at 520 points, (dof, dof, point), would be 240 MB."""
    basis = complete_basis(Shell(2.0, 0.01, 1e7, 0.3, 2700.0), 120, 1e4)
    dof, points = len(basis.labels), 520
    tracemalloc.start()
    stiffness = DeformedShell(basis, 0.1).hydrostatic_stiffness(1025.0, 9.81, points)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert np.abs(stiffness - stiffness.T).max() < 1e-10 * np.abs(stiffness).max()
    assert peak < 0.25 * 8 * dof * dof * points


@pytest.mark.parametrize("more", [-1, 0, 1, 2 * deformed_module.AT_ONCE + 1])
def test_points_are_looked_at_so_many_at_once_and_none_are_lost(more):
    """Memory does not grow with the points asked for; none at all are one empty part."""
    points = np.arange(deformed_module.AT_ONCE + more, dtype=float)
    parts = deformed_module._parts(points)
    assert max(map(len, parts)) <= deformed_module.AT_ONCE
    assert len(parts) == np.ceil(len(points) / deformed_module.AT_ONCE)
    np.testing.assert_array_equal(np.concatenate(parts), points)
    assert [len(part) for part in deformed_module._parts(points[:0])] == [0]


def similar(degree=4, meridian=None):
    """A basis on a shell and that on one 1.7 times as large."""
    shell = Shell(2.0, 0.01, 1e7, 0.3, 2700.0, meridian)
    return [ModeBasis(one, shell_modes(one, "full", degree), 1e4, bending=True) for one in (shell, larger(shell))]


@pytest.mark.parametrize("meridian", [None, capsule(2.0, 1.5)], ids=["sphere", "capsule"])
@pytest.mark.parametrize("height", [0.35, -0.6, -6.0])
def test_a_larger_shell_bent_alike_displaces_and_bears_by_the_powers_of_its_size(meridian, height):
    """Volumes go with the cube, areas with the square, pressures with the depth."""
    small, large = similar(meridian=meridian)
    q = 0.05 * np.sin(1.3 * np.arange(len(small.labels)) + 0.2)
    one, other = DeformedShell(small, height, q), DeformedShell(large, STRETCH * height, STRETCH * q)
    assert other.volume() == pytest.approx(STRETCH**3 * one.volume(), rel=1e-12)
    assert other.wet_area() == pytest.approx(STRETCH**2 * one.wet_area(), rel=1e-12)
    (force, stiffness), (more, stiffer) = one.hydrostatics(RHO, G), other.hydrostatics(RHO, G)
    assert more == pytest.approx(STRETCH**3 * force, abs=1e-10 * np.abs(more).max())
    assert stiffer == pytest.approx(STRETCH**2 * stiffness, abs=1e-10 * np.abs(stiffer).max())
    volumes, areas = zip(*(enclosed(basis, s * q[None]) for basis, s in ((small, 1), (large, STRETCH))), strict=True)
    assert volumes[1] == pytest.approx(STRETCH**3 * volumes[0], rel=1e-12)
    assert areas[1] == pytest.approx(STRETCH**2 * areas[0], rel=1e-9)
    assert other.wet_segments[0] == pytest.approx(one.wet_segments[0], abs=1e-12)
    check_meridian(other)


@pytest.mark.parametrize("radius", [0.6, 5.0])
@pytest.mark.parametrize("part", [-0.7, 0.0, 0.4])
def test_a_rigid_sphere_of_any_size_displaces_its_cap(radius, part):
    shell, depth = rigid_sphere(radius, part * radius), radius * (1 - part)
    assert shell.volume() == pytest.approx(np.pi * depth**2 * (3 * radius - depth) / 3, rel=1e-12)
    assert shell.wet_area() == pytest.approx(2 * np.pi * radius * depth, rel=1e-12)
    assert shell.waterline == pytest.approx(np.arccos(-part), abs=1e-12)
    assert shell.modal_amplitude.tolist() == [0.0]
    assert shell.basis.shell.radius == radius


@pytest.mark.parametrize("up", [0.0, 0.8, -0.5])
def test_a_rigid_capsule_displaces_what_its_meridian_holds_below_the_water(up):
    """An origin that is not the middle of its height is counted from; its hydrostatic stiffness is its waterplane."""
    rest = capsule(0.7, 1.5).scaled(1.0, 1.0, up)
    buoy = rigid_buoy(Shell(0.7, 0.01, 1.0, 0.0, 1.0, rest), 0.25)
    assert buoy.volume() == pytest.approx(rest.volume_below(-0.25), rel=1e-9)
    water = buoy.hydrostatics(RHO, G)
    assert water[0] == pytest.approx([RHO * G * rest.volume_below(-0.25)], rel=1e-9)
    assert water[1][0, 0] == pytest.approx(RHO * G * np.pi * rest.radius_at(-0.25) ** 2, rel=1e-9)
    assert enclosed(buoy.basis, np.array([[0.3]])) == pytest.approx((rest.volume, rest.area), rel=1e-9)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_shell_at_no_height_is_refused(full, value):
    with pytest.raises(ConfigError, match="received a shape with NaN or infinite amplitudes; needs finite ones"):
        check_meridian(DeformedShell(full, value))


@pytest.mark.parametrize("height", [0.2, -3.0, 7.0])
@pytest.mark.parametrize("crossed", ["axis", "waist", "poles"])
def test_where_a_meridian_crosses_the_axis_is_told_by_its_least_radius(full, crossed, height):
    """Between the poles, and with the slopes there; whatever the height it is held at."""
    shell = DeformedShell(full, height, amplitudes(full, **CROSSED[crossed]))
    phi = shell._grid
    m = shell.meridian(phi)
    least = 1 + int(m.x[1:-1].argmin())
    told = (
        f"reference_shape: received a meridian that crosses the axis (radius {m.x[least]:.3g} m at colatitude "
        f"{phi[least]:.3g} rad, slope {m.dx[0]:.3g} m at the top, {m.dx[-1]:.3g} m at the keel); needs one clear of it "
        "between its poles: deform the shell less: raise its stiffness, or change device.internal_pressure"
    )
    with pytest.raises(ConfigError, match=f"^{re.escape(told)}$"):
        check_meridian(shell)


@pytest.mark.parametrize("height", [0.0, -3.0, 4.0])
def test_where_a_meridian_crosses_itself_is_told_at_any_height(full, height):
    """Where two of its points coincide, by differences of all from all."""
    shell = DeformedShell(full, height, amplitudes(full, **CROSSED["itself"]))
    phi = np.linspace(0.0, np.pi, 1501)
    m = shell.meridian(phi)
    apart = np.hypot(m.x[:, None] - m.x, m.z[:, None] - m.z) + 10.0 * (np.abs(phi[:, None] - phi) < 0.3)
    i, j = np.unravel_index(apart.argmin(), apart.shape)
    with pytest.raises(ConfigError, match=r"that crosses itself \(colatitudes") as refused:
        check_meridian(shell)
    found = [float(value) for value in re.findall(r"[\d.]+", str(refused.value).partition("(colatitudes")[2])[:2]]
    others = sorted([phi[i], phi[j]])
    mirrored = sorted(np.pi - np.array(others))
    step = shell._grid[1] + 0.01
    assert any(np.abs(np.array(found) - pair).max() < step for pair in (others, mirrored))
    assert str(refused.value).endswith(
        "rad); needs one that does not: deform the shell less: raise its stiffness, or change device.internal_pressure"
    )


def test_a_shell_of_several_waters_says_which_parts_are_wet(full):
    shell = DeformedShell(full, -1.7, amplitudes(full, **CROSSING))
    told = (
        f"reference_shape: received a shape whose wet parts are {shell.wet_segments} rad; needs one waterline with the "
        "keel below it: change device.mass or device.internal_pressure"
    )
    with pytest.raises(ConfigError, match=f"^{re.escape(told)}$"):
        assert shell.waterline


def test_nodes_of_a_rule_are_found_once_and_stay_as_they_are():
    node, weight = gauss_rule(7)
    assert gauss_rule(7)[0] is node
    assert weight @ node**12 == pytest.approx(2 / 13, rel=1e-14)
    for values in (node, weight):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 0.0


def test_the_grid_is_looked_at_in_parts_that_are_all_of_it(full, monkeypatch):
    shell = DeformedShell(full, 0.3, amplitudes(full, Membrane2=0.1))
    m = shell.meridian(shell._grid)
    monkeypatch.setattr(deformed_module, "AT_ONCE", 50)
    for found, whole in zip(DeformedShell(full, 0.3, shell.modal_amplitude)._on_grid, (m.x, m.z, m.dx), strict=True):
        np.testing.assert_allclose(found, whole, atol=1e-14)
    assert len(shell._grid) == 40 * 7 + 1


def test_quadrature_in_parts_is_that_at_once(full, monkeypatch):
    shell = DeformedShell(full, -1.7, amplitudes(full, **CROSSING))
    whole = shell.volume(), shell.wet_area(), *shell.hydrostatics(RHO, G)
    monkeypatch.setattr(deformed_module, "AT_ONCE", 7)
    parts = shell.volume(), shell.wet_area(), *shell.hydrostatics(RHO, G)
    for one, other in zip(whole, parts, strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-12, atol=1e-12 * np.abs(one).max())


def test_a_meridian_of_many_terms_is_resolved_as_well_as_a_plain_one():
    """The points of a rule grow with its terms; at rest the meridian knows its volume itself."""
    rest = RestMeridian((2.0,), (0.1, 2.0, *98 * (0.0,), 0.002))
    buoy = rigid_buoy(Shell(2.0, 0.01, 1.0, 0.0, 1.0, rest), 0.25)
    assert buoy.volume() == pytest.approx(rest.volume_below(-0.25), rel=1e-12)
    assert buoy.wet_area() == pytest.approx(buoy.wet_area(400), rel=1e-10)
    force, stiffness = buoy.hydrostatics(RHO, G, 40)
    assert force == pytest.approx([RHO * G * rest.volume_below(-0.25)], rel=1e-12)
    assert stiffness[0, 0] == pytest.approx(RHO * G * np.pi * rest.radius_at(-0.25) ** 2, rel=1e-9)


@pytest.mark.parametrize("kind", ["full", "paper", "spheroid"])
def test_a_curve_is_the_meridian_without_its_shapes(seed, kind):
    """By one series in cos(phi) instead of a sum over modes; at the poles, too, and beside another rest shape."""
    shape = {"shape": {"spheroid": {"height": 3.0}}} if kind == "spheroid" else {}
    device = varied(seed, device=shape, modes={"basis": "full"}).device
    basis = mode_basis(device, "paper" if kind == "paper" else "full", 12)
    rng = np.random.default_rng(4)
    shell = DeformedShell(basis, 0.3, 0.1 * rng.normal(size=len(basis.labels)))
    phi = np.concatenate([[0.0, np.pi], rng.uniform(0.0, np.pi, 40)])
    slow, fast = shell.meridian(phi), shell.curve(phi)
    for name in ("x", "z", "dx", "dz"):
        np.testing.assert_allclose(getattr(fast, name), getattr(slow, name), atol=1e-13)


class Waved(DeformedShell):
    """A meridian whose height goes up and down seven times."""

    def curve(self, colatitude):
        """Return it; nothing but its height is looked at."""
        height = self.centre_height + np.cos(7 * colatitude) * self.modal_amplitude[0]
        return super().curve(colatitude)._replace(z=height)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_every_part_below_the_water_is_wet_however_many_there_are(full, sign):
    """From the top on, at either pole or not."""
    found = Waved(full, 0.2, np.append(sign, np.zeros(len(full.labels) - 1))).wet_segments
    first = np.arccos(-0.2 * sign)
    edges = np.sort([part for k in range(4) for part in (2 * np.pi * k + first, 2 * np.pi * (k + 1) - first)])
    edges = np.concatenate([[0.0], edges[edges < 7 * np.pi], [7 * np.pi]]) / 7
    wet = np.stack([edges[:-1], edges[1:]], axis=1)[int(sign > 0) :: 2]
    assert len(wet) == 4
    np.testing.assert_allclose(found, wet, atol=1e-12)


@pytest.mark.parametrize(
    ("slopes", "told"), [((-0.3, -2.0), "slope -0.3 m at the top, -2 m"), ((2.0, 0.1), "2 m at the top, 0.1 m")]
)
def test_a_meridian_turned_in_at_a_pole_is_told_by_its_least_radius_beside_the_poles(slopes, told):
    """Though all that is looked at lies beside the axis, and the poles on it."""
    x = np.array([0.0, 1.0, 0.4, 0.7, 0.0])
    grid, dx = np.linspace(0.0, 2.0, 5), np.array([slopes[0], 1.0, -1.0, 1.0, slopes[1]])
    seen = SimpleNamespace(centre_height=0.1, modal_amplitude=np.zeros(1), _grid=grid, _on_grid=(x, 1 - grid, dx))
    with pytest.raises(
        ConfigError, match=rf"crosses the axis \(radius 0\.4 m at colatitude 1 rad, .*{re.escape(told)}"
    ):
        check_meridian(seen)
