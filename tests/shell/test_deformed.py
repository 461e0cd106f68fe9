"""Deformed shells of revolution in still water: volume, area, waterlines, hydrostatic force and stiffness, bad meridians."""

import numpy as np
import pytest
from conftest import varied
from hypothesis import example, given, settings
from hypothesis import strategies as st

from vsb.engine.hydro.panels.mesh import deformed_mesh
from vsb.engine.shell.deformed import DeformedShell, ReferenceShell, check_meridian, enclosed, rigid_buoy
from vsb.engine.shell.meridian import capsule
from vsb.engine.shell.modes import ModeBasis, mode_basis, shell_modes
from vsb.engine.shell.shell import Shell
from vsb.errors import ConfigError

RHO, G = 1025.0, 9.81


@pytest.fixture(scope="module")
def full(seed):
    return mode_basis(seed.device, "full", 6)


def amplitudes(full, **by_label):
    return np.array([by_label.get(label, 0.0) for label in full.labels])


def test_dry_and_submerged_shells_and_several_waterlines(full):
    assert DeformedShell(full, 2.5).wet_segments == []
    assert DeformedShell(full, 2.5).volume() == 0.0
    assert np.all(DeformedShell(full, 2.5).hydrostatics(RHO, G)[0] == 0.0)
    assert DeformedShell(full, -2.5).wet_segments == [(0.0, np.pi)]
    assert DeformedShell(full, -2.5).volume() == pytest.approx(4 / 3 * np.pi * 8, rel=1e-12)
    dented = DeformedShell(full, -1.7, amplitudes(full, Bending6=-0.4))  # the top pole dips under, a ring stays out
    assert len(dented.wet_segments) == 2


@settings(max_examples=25)
@given(st.lists(st.floats(-0.05, 0.05), min_size=12, max_size=12), st.floats(-0.8, 0.8))
def test_buoyancy_is_the_weight_of_the_displaced_water(full, modal, height):
    """Archimedes for any deformed shape."""
    shell = DeformedShell(full, height, np.array([0.0, *modal]))
    assert shell.hydrostatics(RHO, G)[0][0] == pytest.approx(RHO * G * shell.volume(), rel=1e-10)


CROSSING = {"Bending6": -0.4}
"""With the centre at -1.7 m the top pole dips under water and a ring stays out: three waterlines."""


@pytest.mark.parametrize("height", [0.9, -1.7, -2.6])
def test_hydrostatic_stiffness_is_the_symmetric_jacobian(full, height):
    """With one waterline, three and none; central differences with two Richardson steps."""
    shape = CROSSING if height == -1.7 else {"Membrane2": 0.1, "Bending3": -0.1, "Heave": 0.02}
    start, h = amplitudes(full, **shape), 2e-3

    def central(j, h):
        ahead, behind = (
            DeformedShell(full, height, start + s * np.eye(13)[j]).hydrostatics(RHO, G)[0] for s in (h, -h)
        )
        return (behind - ahead) / (2 * h)

    expected = np.array([(64 * central(j, h / 4) - 20 * central(j, h / 2) + central(j, h)) / 45 for j in range(13)]).T
    stiffness = DeformedShell(full, height, start).hydrostatic_stiffness(RHO, G)
    largest = max(np.abs(stiffness).max(), 1.0)
    assert np.abs(stiffness - stiffness.T).max() <= 1e-11 * largest
    assert np.abs(stiffness - expected).max() <= 1e-8 * largest


def test_quadrature_converges_spectrally(full):
    shell = DeformedShell(full, 0.1, amplitudes(full, Membrane2=0.1, Bending4=-0.08))
    exact = shell.volume(120)
    errors = [abs(shell.volume(n) / exact - 1) for n in (6, 10, 14, 18, 40)]
    assert errors[-1] < 1e-12
    assert errors[0] > 100 * errors[1] > 1e4 * errors[3]


@pytest.mark.parametrize("node", [93, 140])
def test_waterline_on_a_sampled_colatitude(full, node):
    height = -2.0 * float(np.cos(np.linspace(0.0, np.pi, 281)[node]))
    depth = 2.0 - height
    assert DeformedShell(full, height).volume() == pytest.approx(np.pi * depth**2 * (6.0 - depth) / 3, rel=1e-12)


@pytest.mark.parametrize(("height", "swell"), [(0.4, 0.3), (-0.8, -0.2)])
def test_breathing_gives_a_sphere_of_another_radius(full, height, swell):
    radius = 2.0 + swell
    shell, depth = DeformedShell(full, height, amplitudes(full, Membrane0=swell)), min(radius - height, 2 * radius)
    assert shell.volume() == pytest.approx(np.pi * depth**2 * (3 * radius - depth) / 3, rel=1e-12)


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


@pytest.mark.parametrize(("across", "along"), [(2.2, 1.8), (1.9, 2.6)], ids=["oblate", "slender"])
def test_volume_and_area_of_spheroids(full, across, along):
    q = spheroid(full, across, along)
    half = DeformedShell(full, 0.0, q)
    assert half.volume(40) == pytest.approx(2 / 3 * np.pi * across**2 * along, rel=1e-12)
    volume, area = enclosed(full, q[None])
    assert volume[0] == pytest.approx(4 / 3 * np.pi * across**2 * along, rel=1e-12)
    assert area[0] == pytest.approx(spheroid_area(across, along), rel=1e-12)


CROSSED = {
    "axis": {"Membrane1": 2.0},
    "waist": {"Bending2": 5.0},
    "poles": {"Membrane2": -2.5},
    "itself": {"Membrane4": 1.2},
}
"""Shapes whose meridian crosses the axis near a pole, in between, from pole to pole, or itself."""


@pytest.mark.parametrize("crossed", CROSSED)
def test_meridian_that_crosses_the_axis_or_itself_is_refused(full, crossed):
    shell = DeformedShell(full, 0.2, amplitudes(full, **CROSSED[crossed]))
    where = "itself" if crossed == "itself" else "the axis"
    for use in (lambda: shell.waterline, lambda: deformed_mesh(shell, 12, 24, 6)):  # of both solvers
        with pytest.raises(ConfigError, match=f"^reference_shape: received a meridian that crosses {where} .*; needs"):
            use()


@pytest.mark.parametrize("height", [2.5, -2.5, -1.7], ids=["dry", "submerged", "ring"])
def test_a_floating_shell_needs_one_waterline(full, height):
    shell = DeformedShell(full, height, amplitudes(full, **(CROSSING if height == -1.7 else {})))
    with pytest.raises(ConfigError, match=r"wet parts are .* needs one waterline with the keel below it"):
        assert shell.waterline


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_non_finite_shape_is_refused(full, value):
    with pytest.raises(ConfigError, match="received a shape with NaN or infinite amplitudes; needs finite ones"):
        check_meridian(DeformedShell(full, 0.0, amplitudes(full, Membrane2=value)))


def test_overhanging_shapes_are_accepted(full):
    for shape in ({"Bending3": 2.0}, {"Bending5": -3.0}, {"Bending2": 3.0}):
        check_meridian(DeformedShell(full, 0.2, amplitudes(full, **shape)))


CURL = [-0.2611952595029945, 0.0703125, -0.5437249483965709, *[0.0] * 3, 0.263671875, -0.55859375, 0.0703125, 0.0,
        0.6875, 0.6953125]  # fmt: skip
"""Amplitudes of a curl between two points that are looked at."""


@settings(max_examples=25)
@given(st.lists(st.floats(-0.7, 0.7), min_size=12, max_size=12))
@example(CURL)
def test_accepted_meridian_has_turning_number_one(full, modal):
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


def test_rigid_capsule_displaces_its_volume_below_the_water():
    rest = capsule(0.7, 1.5)
    buoy = rigid_buoy(Shell(0.7, 0.01, 1.0, 0.0, 1.0, rest), 0.25)
    assert buoy.volume() == pytest.approx(rest.volume_below(-0.25), rel=1e-9)
    water = buoy.hydrostatics(RHO, G)
    assert water[0] == pytest.approx([RHO * G * rest.volume_below(-0.25)], rel=1e-9)
    assert water[1][0, 0] == pytest.approx(RHO * G * np.pi * rest.radius_at(-0.25) ** 2, rel=1e-9)
    assert enclosed(buoy.basis, np.array([[0.3]])) == pytest.approx((rest.volume, rest.area), rel=1e-9)


@pytest.mark.parametrize("kind", ["full", "paper", "spheroid"])
def test_curve_evaluates_the_meridian_by_its_cosine_series(seed, kind):
    shape = {"shape": {"spheroid": {"height": 3.0}}} if kind == "spheroid" else {}
    device = varied(seed, device=shape, modes={"basis": "full"}).device
    basis = mode_basis(device, "paper" if kind == "paper" else "full", 12)
    rng = np.random.default_rng(4)
    shell = DeformedShell(basis, 0.3, 0.1 * rng.normal(size=len(basis.labels)))
    phi = np.concatenate([[0.0, np.pi], rng.uniform(0.0, np.pi, 40)])
    slow, fast = shell.meridian(phi), shell.curve(phi)
    for name in ("x", "z", "dx", "dz"):
        np.testing.assert_allclose(getattr(fast, name), getattr(slow, name), atol=1e-13)


@pytest.mark.parametrize("radius", [0.8])
def test_keel_depth_of_a_deformed_shell_and_of_a_capsule(radius):
    shell = Shell(radius, 0.01, 1e7, 0.3, 2700.0)
    basis = ModeBasis(shell, shell_modes(shell, "full", 2), 1e4, bending=True)
    q = np.array([{"Heave": 0.1, "Membrane0": 0.05}.get(label, 0.0) for label in basis.labels])
    reference = ReferenceShell(DeformedShell(basis, 0.2, q), {})
    assert reference.keel_depth == pytest.approx(radius + 0.05 - 0.2 - 0.1, rel=1e-12)
    capsuled = Shell(radius, 0.01, 1e7, 0.3, 2700.0, capsule(radius, 1.0))
    rest = ReferenceShell(DeformedShell(ModeBasis(capsuled, (), 1e4, False), 0.2), {})
    assert rest.keel_depth == pytest.approx(radius + 0.5 - 0.2, rel=1e-12)
