"""Figures of the shell: closed outlines in their place, magnified by a round factor."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

from vsb.report import shell_figures as figures
from vsb.report.canvas import STYLES, StudyData

PHI = np.linspace(0.0, np.pi, 19)
TIME = np.linspace(0.0, 10.0, 101)


def run(breathing, heave=0.0):
    """A buoy that heaves and breathes in a period of 5 s; a rigid one has heave alone."""
    labels = ["Heave", "Membrane0"] if breathing else ["Heave"]
    motion = np.sin(2 * np.pi * TIME / 5.0)[:, None] * np.array([heave, breathing])[: len(labels)]
    variables = {"position": (("time", "dof"), motion), "volume": ("time", 33.5 + 0 * TIME)}
    variables |= {"area": ("time", 50.3 + 0 * TIME), "elevation": ("time", 0.1 * np.cos(TIME))}
    return xr.Dataset(variables, coords={"time": TIME, "dof": labels})


def data(breathing=0.01):
    shape = np.ones((1, len(PHI)))
    modes = xr.Dataset(
        {"radial": (("mode", "colatitude"), shape), "meridional": (("mode", "colatitude"), 0 * shape),
         "degree": ("mode", [0]), "dry_frequency": ("mode", [51.4]), "static_amplitude": ("mode", [0.0])},
        coords={"mode": ["Membrane0"], "colatitude": PHI}, attrs={"radius": 2.0, "centre_height": 0.0},
    )  # fmt: skip
    empty = xr.Dataset()
    runs = {("FSB", "w"): run(0.0, 0.2), ("VSWEC", "w"): run(breathing, 0.2)}
    return StudyData(("FSB", "VSWEC"), "FSB", (1.0,), {"w": 5.0}, (0.0, 10.0), modes, empty, empty, empty, runs, empty)


@pytest.mark.parametrize(("breathing", "factor"), [(0.01, 20.0), (0.05, 5.0), (0.4, 1.0), (3.0, 1.0)])
def test_the_largest_displacement_is_magnified_to_a_fifth_of_the_radius_by_a_round_factor(breathing, factor):
    assert figures._magnification(data(breathing), "w") == factor


def test_five_instants_of_the_last_period_of_every_design():
    figure = figures.snapshots(data(), "w")
    assert len(figure.axes) == 10
    assert [ax.get_title() for ax in figure.axes[:5]] == [f"t = {t:.2f} s" for t in (5.0, 6.0, 7.0, 8.0, 9.0)]
    outline = figure.axes[6].get_lines()[-1]
    x, z = outline.get_xdata(), outline.get_ydata()
    swell = 20.0 * 0.01 * np.sin(2 * np.pi * 6.0 / 5.0)
    centre = 0.2 * np.sin(2 * np.pi * 6.0 / 5.0)
    np.testing.assert_allclose(np.hypot(x, z - centre), 2.0 + swell, rtol=1e-9)


def test_modes_are_drawn_about_the_sphere_and_a_rigid_study_says_it_has_none():
    figure = figures.mode_shapes(data())
    assert figure.axes[0].get_title().startswith("Membrane0\n51.40 rad/s")
    x, z = figure.axes[0].get_lines()[1].get_data()
    np.testing.assert_allclose(np.hypot(x, z), 1.25, rtol=1e-9)


def test_shapes_are_extreme_where_the_poles_are_closest():
    figure = figures.extreme_shapes(data(), "w")
    rigid, shell = (line.get_data() for line in figure.axes[0].get_lines())
    np.testing.assert_allclose(np.hypot(*rigid), 2.0, rtol=1e-9)
    np.testing.assert_allclose(np.hypot(*shell), 2.0 - 20.0 * 0.01, rtol=1e-2)
    assert [ax.get_title().split("\n")[0] for ax in figures.shapes_3d(data(), "w").axes] == [
        "start", "least height", "greatest height"
    ]  # fmt: skip
    assert len(figures.volume_area(data(), "w").axes) == 2


def test_where_no_design_moves_its_shell_the_first_is_drawn():
    """`hydro.model: auto` may describe every design of a flexible study as rigid."""
    assert [ax.get_title().split("\n")[0] for ax in figures.shapes_3d(data(0.0), "w").axes] == [
        "start", "least height", "greatest height"
    ]  # fmt: skip


@pytest.mark.parametrize("angle", [-0.7, 0.0, 0.3, np.pi / 2])
def test_a_buoy_that_pitches_is_drawn_turned(angle):
    """Points keep their distances from the centre; the top goes by the sine of the angle, along x."""
    x, z = 2.0 * np.sin(PHI), 2.0 * np.cos(PHI)
    tilted = xr.Dataset({"position": ("dof", [0.4, 0.1, angle])}, {"dof": ["Surge", "Heave", "Pitch"]})
    turned = np.array(figures._tilted(tilted, x, z))
    np.testing.assert_allclose(np.hypot(*turned), 2.0, rtol=1e-12)
    np.testing.assert_allclose(turned[:, 0], [2.0 * np.sin(angle), 2.0 * np.cos(angle)], atol=1e-12)
    np.testing.assert_array_equal(figures._tilted(tilted.drop_sel(dof="Pitch"), x, z), (x, z))


def test_a_mode_of_order_one_moves_both_meridians_the_same_way():
    """V = sin, U = cos of the colatitude at theta = 0, of the other sign at pi: the whole sphere moves sideways."""
    given = data()
    modes = given.modes.assign(radial=(("mode", "colatitude"), np.sin(PHI)[None]), order=("mode", [1]))
    modes = modes.assign(meridional=(("mode", "colatitude"), np.cos(PHI)[None]))
    at = given.runs["VSWEC", "w"].isel(time=10)
    x, z = figures._closed(*figures._meridians(replace(given, modes=modes), at, 20.0))
    moved = 20.0 * float(at.position[1])
    assert abs(moved) > 0.1
    np.testing.assert_allclose(np.hypot(x - moved, z), 2.0, rtol=1e-9)


def test_volume_and_area_are_drawn_each_on_its_axis():
    figure = figures.volume_area(data(), "w")
    for ax, drawn in zip(figure.axes, ("volume", "area"), strict=True):
        assert drawn in ax.get_ylabel()
        for line, name in zip(ax.get_lines(), ("FSB", "VSWEC"), strict=False):
            np.testing.assert_array_equal(line.get_ydata(), data().runs[name, "w"][drawn].values)


def bulging():
    """A body thicker at its top that swells by 10 mm at 4 s and shrinks as much at 6 s, by far more before the window."""
    given = data()
    swell = 0.01 * (np.exp(-((TIME - 4.0) ** 2)) - np.exp(-((TIME - 6.0) ** 2))) - 0.03 * np.exp(-9 * (TIME - 1) ** 2)
    given.runs["VSWEC", "w"].position[:, 1] = swell
    rest = {"rest_radial": ("colatitude", 0.3 * np.cos(PHI)), "rest_meridional": ("colatitude", 0 * PHI)}
    return replace(given, modes=given.modes.assign(rest), window=(3.0, 10.0)), swell


def test_the_least_height_is_that_of_the_window_and_axes_say_what_is_drawn():
    given, swell = bulging()
    figure = figures.extreme_shapes(given, "w")
    (ax,) = figure.axes
    _, (x, z) = (line.get_data() for line in ax.get_lines())
    factor = 20.0  # 0.4 m over 10 mm is 40
    np.testing.assert_allclose(np.hypot(x, z), 2.0 + 0.3 * z / np.hypot(x, z) + factor * swell[60], rtol=1e-9)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("radius [m]", "height above the sphere centre [m]")
    assert figure.get_suptitle() == (
        "Least height from pole to pole in the window; shell displacement magnified 20 times"
    )
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["FSB", "VSWEC"]


def test_wires_of_a_shell_lie_on_it_at_its_instants_within_a_cube_of_axes():
    """Those of the flexible design, at the start, its least and its greatest height, as large as the title says."""
    given, swell = bulging()
    figure = figures.shapes_3d(given, "w")
    assert [ax.get_title() for ax in figure.axes] == [
        "start\nt = 0.00 s", "least height\nt = 6.00 s", "greatest height\nt = 4.00 s"
    ]  # fmt: skip
    title = "VSWEC, heights from pole to pole, shell displacement magnified 20 times; z in m"
    assert figure.get_suptitle() == title
    for ax, at in zip(figure.axes, (0, 60, 40), strict=True):
        points = np.concatenate([np.stack(np.broadcast_arrays(*line.get_data_3d()), 1) for line in ax.lines])
        size = np.linalg.norm(points, axis=1)
        np.testing.assert_allclose(size, 2.0 + 0.3 * points[:, 2] / size + 20.0 * swell[at], rtol=1e-9)
        (low, high), *others = ax.get_xlim(), ax.get_ylim(), ax.get_zlim()
        assert others == [(low, high)] * 2
        assert low == -high < -np.abs(points).max()
        assert len(set(ax.get_box_aspect())) == 1
        assert {to_hex(line.get_color()) for line in ax.lines} == {STYLES["VSWEC"][0].lower()}


def test_the_height_changes_by_both_poles():
    """Of V = P_n(cos phi) by V_0 (1 + (-1)^n) = 0, 2 of an amplitude of one; a rigid buoy keeps its diameter."""
    given = data()
    for radial, both in ((np.cos(PHI), 0.0), (1.5 * np.cos(PHI) ** 2 - 0.5, 2.0), (np.linspace(0.25, 0.5, 19), 0.75)):
        modes = given.modes.assign(radial=(("mode", "colatitude"), radial[None]))
        height = figures._height(replace(given, modes=modes), given.runs["VSWEC", "w"])
        amplitude = given.runs["VSWEC", "w"].position.values[:, 1]
        np.testing.assert_allclose(height, 4.0 + both * amplitude, rtol=1e-12)
    assert (figures._height(given, given.runs["FSB", "w"]) == 4.0).all()


@pytest.mark.parametrize(("end", "times"), [(3.0, (0.0, 0.6, 1.2, 1.8, 2.4)), (6.0, (1.0, 2.0, 3.0, 4.0, 5.0))])
def test_a_run_shorter_than_a_period_is_shown_from_its_start(end, times):
    figure = figures.snapshots(replace(data(), window=(0.0, end)), "w")
    assert [ax.get_title() for ax in figure.axes[:5]] == [f"t = {t:.2f} s" for t in times]


def test_what_magnifies_motion_leaves_the_shape_at_rest():
    """A shell swollen by 0.3 m at rest, which breathes by 10 mm; a rigid design of the study rests so, too."""
    given = data()
    given = replace(given, modes=given.modes.assign(static_amplitude=("mode", [0.3])))
    rigid, shell = (line.get_data() for line in figures.extreme_shapes(given, "w").axes[0].get_lines())
    np.testing.assert_allclose(np.hypot(*rigid), 2.3, rtol=1e-9)
    np.testing.assert_allclose(np.hypot(*shell), 2.3 - 20.0 * 0.01, rtol=1e-3)


def test_displacements_of_all_designs_in_the_window_count_for_the_factor():
    """The first design that moves its shell less, or more, or before the window."""
    given = data(0.01)
    for runs in ({"VSWEC": run(0.01), "more": run(0.05)}, {"VSWEC": run(0.05), "less": run(0.01)}):
        both = replace(given, designs=("FSB", *runs), runs={**given.runs, **{(n, "w"): one for n, one in runs.items()}})
        assert figures._magnification(both, "w") == 5.0
    early = run(0.01)
    early.position[5, 1] = -3.0
    late = replace(given, window=(1.0, 10.0), runs={**given.runs, ("VSWEC", "w"): early})
    assert figures._magnification(late, "w") == 20.0
    assert figures._magnification(replace(late, window=(0.0, 10.0)), "w") == 1.0
    early.position[5, 1], early.position[-1, 1] = 0.0, 3.0
    assert figures._magnification(replace(late, window=(0.0, 9.9)), "w") == 20.0
    assert figures._magnification(replace(given, designs=("FSB",)), "w") == 1.0


def test_modes_that_move_the_other_meridian_and_rigid_motions_are_none_of_the_drawn():
    labels = ["Surge", "Heave", "Membrane1c1", "Membrane1s1", "Pitch", "Membrane2"]
    moved = xr.Dataset({"position": (("time", "dof"), [[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]])}, {"dof": labels})
    assert figures._modal(moved).tolist() == [[3.0, 6.0]]


@pytest.mark.parametrize(
    ("breathing", "order", "title"),
    [
        (0.01, None, "Shell displacement times 20, heave and wave times 1 (dotted: undeformed)"),
        (0.01, 0, "Shell displacement times 20, heave, pitch and wave times 1 (dotted: undeformed)"),
        (0.5, None, "All to scale (dotted: undeformed)"),
    ],
)
def test_snapshots_say_what_is_magnified(breathing, order, title):
    given = data(breathing)
    if order is not None:
        given = replace(given, modes=given.modes.assign(order=("mode", [order])))
    assert figures.snapshots(given, "w").get_suptitle() == title


def test_a_snapshot_has_room_for_a_tall_body_and_water_at_rest_where_no_wave_is_known():
    """A body of three metres from its centre to its poles; its centre is half a metre above the water."""
    given = data()
    rest = {"rest_radial": ("colatitude", np.cos(PHI) ** 2), "rest_meridional": ("colatitude", 0 * PHI)}
    modes = given.modes.assign(rest).assign_attrs(centre_height=0.5)
    runs = {key: one.drop_vars("elevation") for key, one in given.runs.items()}
    deep, high = (
        modes.assign(rest_radial=("colatitude", np.where(side * np.cos(PHI) < 0, np.cos(PHI) ** 2, 0.0)))
        for side in (1, -1)
    )
    for one, reach in ((modes, 4.5), (deep, 4.5), (high, 4.5), (given.modes, 3.0)):
        ax = figures.snapshots(replace(given, modes=one, runs=runs), "w").axes[0]
        assert (ax.get_xlim(), ax.get_ylim()) == ((-reach, reach), (-reach, reach))
        (level,) = (line for line in ax.get_lines() if line.get_color() == "#0072B2")
        assert set(level.get_ydata()) == {0.0}
    ax = figures.snapshots(replace(given, modes=modes, runs=runs), "w").axes[0]
    dotted = next(line for line in ax.get_lines() if line.get_linestyle() == ":")
    assert (dotted.get_ydata().max(), dotted.get_ydata().min()) == pytest.approx((3.5, -2.5))


def test_modes_stand_four_in_a_row_and_those_of_order_one_go_the_same_way_on_both_sides():
    """On a body that is no sphere, too: what it is at rest is drawn in radii."""
    given, phi = data(), PHI
    five = given.modes.isel(mode=[0] * 5).assign_coords(mode=[f"M{k}" for k in range(5)])
    assert len(figures.mode_shapes(replace(given, modes=five)).axes) == 8
    rest = {"rest_radial": ("colatitude", 0.4 * np.cos(phi) ** 2), "rest_meridional": ("colatitude", 0 * phi)}
    sideways = {
        "radial": (("mode", "colatitude"), [np.sin(phi)]),
        "meridional": (("mode", "colatitude"), [np.cos(phi)]),
    }
    modes = given.modes.assign(**rest, **sideways, order=("mode", [1]), degree=("mode", [1]))
    at_rest, moved = (
        np.array(line.get_data()) for line in figures.mode_shapes(replace(given, modes=modes)).axes[0].lines
    )
    assert at_rest[1].max() == pytest.approx(1.2)
    shift = moved - at_rest
    np.testing.assert_allclose(shift[0], shift[0, 0], atol=1e-9)
    np.testing.assert_allclose(shift[1], 0.0, atol=1e-9)
    assert shift[0, 0] > 0.1


FINE = np.linspace(0.0, np.pi, 721)


@pytest.mark.parametrize(
    ("degree", "radial", "meridional", "amplitude"),
    [
        (0, np.ones_like(FINE), 0 * FINE, 0.25),
        (1, np.cos(FINE), -np.sin(FINE), 0.25),
        (2, np.cos(2 * FINE) / 9, 0 * FINE, 0.25),
        (8, np.cos(8 * FINE) / 9, 0 * FINE, 0.25 / 4**0.7),
        (0, -np.ones_like(FINE), 0 * FINE, 0.25),  # shortened by a quarter
        (0, -2 * np.ones_like(FINE), 0 * FINE, 0.2),  # by two fifths, and no more
        (2, 0 * FINE, np.sin(2 * FINE), 0.2),
        (2, -np.cos(FINE), np.sin(FINE), 0.25),  # as a whole to below
        (2, -np.cos(FINE), -np.sin(FINE), 0.2),
    ],
)
def test_modes_are_drawn_with_an_amplitude_that_falls_with_their_degree_and_shortens_no_part_too_much(
    degree, radial, meridional, amplitude
):
    """A quarter of the radius up to degree 2, then as the degree to 0.7; no piece of a meridian by more than 0.4."""
    given = data()
    shapes = {
        "radial": (("mode", "colatitude"), radial[None]),
        "meridional": (("mode", "colatitude"), meridional[None]),
    }
    modes = xr.Dataset(
        shapes | {"degree": ("mode", [degree]), "dry_frequency": ("mode", [51.4])},
        {"mode": ["M"], "colatitude": FINE}, given.modes.attrs,
    )  # fmt: skip
    x, z = figures.mode_shapes(replace(given, modes=modes)).axes[0].get_lines()[1].get_data()
    half = slice(0, len(FINE))
    expected = (
        (1 + amplitude * radial) * np.sin(FINE) + amplitude * meridional * np.cos(FINE),
        (1 + amplitude * radial) * np.cos(FINE) - amplitude * meridional * np.sin(FINE),
    )
    np.testing.assert_allclose((x[half], z[half]), expected, atol=1e-4)  # of a derivative by differences
    np.testing.assert_allclose((-x[half][::-1], z[half][::-1]), (x[len(FINE) :], z[len(FINE) :]), atol=1e-12)


@pytest.mark.parametrize(
    ("largest", "factor"),
    [
        (0.0, 1.0),
        (0.08, 5.0),
        (0.0801, 2.0),
        (0.2, 2.0),
        (0.04, 10.0),
        (0.0401, 5.0),
        (0.4, 1.0),
        (0.41, 1.0),
        (4e-4, 1e3),
    ],
)
def test_a_round_factor_is_the_largest_that_leaves_a_fifth_of_the_radius(largest, factor):
    """Of a radius of two metres 0.4 m, just reached; of what is larger than that nothing is made smaller."""
    assert figures.round_factor(largest, 2.0) == pytest.approx(factor)
    assert figures.round_factor(3 * largest, 6.0) == pytest.approx(factor)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_what_shrinks_a_shell_is_magnified_like_what_swells_it(sign):
    """A shell that never swells beyond its shape at rest, or never shrinks."""
    given = data()
    given.runs["VSWEC", "w"].position[:, 1] = sign * 0.05 * np.sin(np.pi * TIME / 10.0) ** 2
    assert figures._magnification(given, "w") == 5.0


def test_wires_are_twelve_meridians_all_around_and_rings_between_the_poles():
    """Thirty degrees apart; rings are level, closed, and as wide as the body where they are."""
    ax = mpl.figure.Figure().add_subplot(projection="3d")
    x, z = 2.0 * np.sin(PHI), 3.0 * np.cos(PHI)
    figures._draw_wires(ax, x, z, "#123456")
    lines = [np.stack(np.broadcast_arrays(*line.get_data_3d())) for line in ax.lines]
    meridians, rings = lines[:12], lines[12:]
    angles = sorted(round(float(np.rad2deg(np.arctan2(one[1, 9], one[0, 9]))) % 360) for one in meridians)
    assert angles == list(range(0, 360, 30))
    for one in meridians:
        np.testing.assert_allclose((np.hypot(*one[:2]), one[2]), (x, z), atol=1e-12)
    assert [round(float(one[2, 0]), 9) for one in rings] == [round(float(z[i]), 9) for i in (5, 10, 15)]
    for one, i in zip(rings, (5, 10, 15), strict=True):
        np.testing.assert_allclose(np.hypot(*one[:2]), x[i])
        np.testing.assert_allclose(one[:, 0], one[:, -1], atol=1e-12)
        assert np.ptp(one[2]) == 0.0
