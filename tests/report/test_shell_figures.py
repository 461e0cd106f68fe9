"""Figures of the shell: closed outlines at their place, magnified by a round factor; sketches of designs."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

from vsb.report import shell_figures as figures
from vsb.report.canvas import STYLES, StudyData, data_csv, in_words, style
from vsb.report.shell_figures import sketch, sketches
from vsb.study.study import parse

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


def test_snapshots_at_five_instants_of_the_last_period():
    figure = figures.snapshots(data(), "w")
    (ax,) = figure.axes
    times = [f"t = {t:.2f} s" for t in (5.0, 6.0, 7.0, 8.0, 9.0)]
    assert [text.get_text() for text in ax.texts] == ["FSB", "VSWEC", *times]
    assert len(ax.lines) == 10
    level = 0.1 * np.cos(6.0)
    outline = ax.lines[6]
    assert outline.get_label() == f"_VSWEC, t = 6.00 s, water at {level:.4g} m"
    x, z = outline.get_data()
    swell = 20.0 * 0.01 * np.sin(2 * np.pi * 6.0 / 5.0)
    centre = 0.2 * np.sin(2 * np.pi * 6.0 / 5.0)
    np.testing.assert_allclose(np.hypot(x, z - centre), 2.0 + swell, rtol=1e-9)
    water, surface, rest = ax.collections
    (left, _), (right, top) = water.get_paths()[6].get_extents().get_points()
    assert surface.get_paths()[6].vertices == pytest.approx(np.array([[right, top], [left, top]]))
    place = outline.get_transform() - ax.transData
    assert place.transform((0.0, level))[1] == pytest.approx(top)
    assert place.transform((0.0, 0.0))[0] == pytest.approx((left + right) / 2)
    np.testing.assert_allclose(
        np.hypot(*(place.inverted().transform(rest.get_paths()[6].vertices) - [0, centre]).T), 2.0
    )


def bulging():
    """A body thicker at its top that swells by 10 mm at 4 s and shrinks as much at 6 s, by far more before the window."""
    given = data()
    swell = 0.01 * (np.exp(-((TIME - 4.0) ** 2)) - np.exp(-((TIME - 6.0) ** 2))) - 0.03 * np.exp(-9 * (TIME - 1) ** 2)
    given.runs["VSWEC", "w"].position[:, 1] = swell
    rest = {"rest_radial": ("colatitude", 0.3 * np.cos(PHI)), "rest_meridional": ("colatitude", 0 * PHI)}
    return replace(given, modes=given.modes.assign(rest), window=(3.0, 10.0)), swell


def test_extreme_shape_is_the_lowest_within_the_window():
    given, swell = bulging()
    figure = figures.extreme_shapes(given, "w")
    (ax,) = figure.axes
    _, (x, z) = (line.get_data() for line in ax.get_lines())
    factor = 20.0  # 0.4 m over 10 mm is 40
    np.testing.assert_allclose(np.hypot(x, z), 2.0 + 0.3 * z / np.hypot(x, z) + factor * swell[60], rtol=1e-9)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("radius [m]", "height above the sphere centre [m]")
    assert figure.get_suptitle() == ("Smallest distance between the poles; shell displacement magnified 20 times")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["FSB", "VSWEC"]


def test_wires_in_space_lie_on_the_deformed_shell():
    """At the start and at the least and greatest height, magnified as the title says; seen from above."""
    given, swell = bulging()
    figure = figures.shapes_3d(given, "w")
    (ax,) = figure.axes
    title = "VSWEC, height between the poles; shell displacement magnified 20 times"
    assert figure.get_suptitle() == title
    names, heights = ("start", "smallest height", "largest height"), 4.0 + 2 * swell[[0, 60, 40]]
    words = [f"{n}\nt = {t:.2f} s, {h:.3f} m" for n, t, h in zip(names, (0.0, 6.0, 4.0), heights, strict=True)]
    assert [text.get_text() for text in ax.texts] == words
    meridians = [line for line in ax.lines if line.get_label() != "_"]
    assert [line.get_label() for line in meridians] == [f"_{name}" for name in names]
    for line, at in zip(meridians, (0, 60, 40), strict=True):
        x, z = line.get_data()
        np.testing.assert_allclose(np.hypot(x, z), 2.0 + 0.3 * z / np.hypot(x, z) + 20.0 * swell[at], rtol=1e-9)
    assert {to_hex(line.get_color()) for line in ax.lines} == {STYLES[0][0].lower()}
    back, front, meridian = ax.lines[:3]
    x, z = meridian.get_data()
    for half, behind in ((back, 1.0), (front, -1.0)):
        across, up = half.get_data()
        size = len(x)
        np.testing.assert_allclose(across[:size], x)  # the meridian beside
        np.testing.assert_allclose(up[:size], z * np.cos(figures.ELEVATION))
        middle = slice(3 * (size + 1), 3 * (size + 1) + size)  # the one a quarter around
        np.testing.assert_allclose(across[middle], 0.0, atol=1e-9)
        rise = behind * x * np.sin(figures.ELEVATION)
        np.testing.assert_allclose(up[middle], z * np.cos(figures.ELEVATION) + rise)


def test_mode_of_order_one_moves_both_meridians_the_same_way():
    """About a body that is not a sphere."""
    given, phi = data(), PHI
    five = given.modes.isel(mode=[0] * 5).assign_coords(mode=[f"M{k}" for k in range(5)])
    figure = figures.mode_shapes(replace(given, modes=five))
    (ax,) = figure.axes
    assert [line.get_label() for line in ax.lines[1::2]] == [f"_M{k}" for k in range(5)]
    words = "; ".join(f"M{k} 51.40 rad/s dry" for k in range(5))
    assert in_words(figure) == f"Shell modes (black: undeformed). {words}"
    rows = [line.split(",") for line in data_csv(figure).splitlines()[1:]]
    assert list(dict.fromkeys(row[1] for row in rows)) == ["undeformed", "M0", "M1", "M2", "M3", "M4"]
    np.testing.assert_allclose(np.hypot(*np.array([row[2:4] for row in rows[:38]], dtype=float).T), 1.0, rtol=1e-5)
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


@pytest.mark.parametrize(("largest", "factor"), [(0.0, 1.0), (0.0801, 2.0), (0.0401, 5.0), (0.41, 1.0)])
def test_magnification_is_the_largest_round_factor_within_a_fifth_of_the_radius(largest, factor):
    assert figures.round_factor(largest, 2.0) == pytest.approx(factor)
    assert figures.round_factor(3 * largest, 6.0) == pytest.approx(factor)


DESIGNS = {
    "FSB": {"flexible": False, "clamp": []},
    "VSWEC": {"flexible": True, "clamp": []},
    "VSWEC0": {"flexible": True, "clamp": [0.0]},
    "two": {"flexible": True, "clamp": [30.0, 180.0]},
}


@pytest.mark.parametrize("name", DESIGNS)
def test_sketch_has_the_colour_and_clamps_of_its_design(name):
    text = sketch(name, DESIGNS, 0.2)
    root = ET.fromstring(text)
    assert root.get("aria-label").startswith(f"{name}, ")
    assert style(name, list(DESIGNS), "FSB")["color"] in text
    assert text.count('class="clamp"') == 2 * len(DESIGNS[name]["clamp"])
    assert ("stroke-dasharray" in text) == DESIGNS[name]["flexible"]


@pytest.mark.parametrize("radius", [0.5, 2.0, 7.0])
@pytest.mark.parametrize("draft", [0.6, 1.0, 1.3])
def test_sphere_floats_at_its_draft(seed, radius, draft):
    """In radii, of 34 units each; the take-off begins at its keel."""
    raw = seed.model_dump() | {"designs": {"FSB": {"flexible": False}, "VSWEC": {}}, "published": None}
    raw["device"] |= {"radius": radius, "thickness": radius / 200, "draft": draft * radius}
    del raw["device"]["mass"]
    for one in sketches(parse(raw, source="sphere")):
        root = ET.fromstring(one["svg"])
        (body,) = root.iter("circle")
        assert float(body.get("cy")) + float(body.get("r")) == pytest.approx(62.0 + 34.0 * draft, abs=0.1)
        line = next(e.get("d") for e in root.iter("path") if e.get("class") == "takeoff")
        assert float(line.removeprefix("M70 ").partition("V")[0]) == pytest.approx(62.0 + 34.0 * draft, abs=0.1)
