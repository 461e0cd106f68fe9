"""Files of figures: small SVG with real text and identifiers of its own, PDF with text, data, words."""

import csv
import io
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from report.test_campaign_figures import campaign

from vsb.report.campaign_figures import DRAWN
from vsb.report.canvas import grid_of_axes, legend_above
from vsb.report.svg import Drawn, _hundredths, _relative, _rounded_all, _shorten, _unwrap, data_csv, drawn, in_words

X = np.linspace(0.0, 10.0, 400)


@pytest.fixture
def figure():
    """Two pairs of axes over the same time, one of them logarithmic, and a curve without a name."""
    figure, axes = grid_of_axes(4.0, 2, 1, sharex=True)
    axes[0, 0].plot(X, np.sin(X), label="A")
    axes[0, 0].plot(X, 2 + 0 * X)
    axes[1, 0].semilogy(X, np.exp(X), label="A")
    axes[0, 0].set(ylabel="heave\n[m]", xlim=(0, 10))
    axes[1, 0].set(xlabel="time [s]", ylabel="power [W]", ylim=(1, 1e5))
    legend_above(figure, axes[0, 0])
    return figure


def test_text_is_text_on_screen_and_in_print(figure):
    files = drawn(figure, "wave")
    texts = {
        "".join(element.itertext()) for element in ET.fromstring(files.svg).iter("{http://www.w3.org/2000/svg}text")
    }
    assert {"time [s]", "power [W]", "A"} <= texts
    assert b"/TrueType" in files.pdf or b"/Type42" in files.pdf or b"/CIDFontType2" in files.pdf
    assert drawn(figure, "wave").pdf == files.pdf, "the same figure is the same file"


def test_hatching_is_drawn_with_a_pattern_that_is_there(figure):
    """A style refers to it, which stands in the sheet of the figure."""
    figure.axes[0].fill_between(X, -1.0, 0.0, facecolor="none", hatch="////")
    root = ET.fromstring(drawn(figure, "wave").svg)
    (pattern,) = (element.get("id") for element in root.iter("{http://www.w3.org/2000/svg}pattern"))
    filled = re.findall(r"\.(\w+){fill:url\(#([^)]+)\)", root.findtext("{http://www.w3.org/2000/svg}style"))
    assert [reference for _, reference in filled] == [pattern]
    assert [element for element in root.iter() if element.get("class") == filled[0][0]]


def test_identifiers_are_of_the_figure_and_all_references_are_met(figure):
    text = drawn(figure, "wave").svg
    identities = re.findall(r'\bid="([^"]+)"', text)
    assert len(set(identities)) == len(identities)
    assert identities
    assert all(identity.startswith("wave-") for identity in identities)
    assert set(re.findall(r'(?:href="|url\()#([^")]+)', text)) == set(identities)


def test_values_can_be_read_off_the_drawn_curve(figure):
    """Place and scale of the axes lead from the path back to the data, to a hundredth of a point."""
    root = ET.fromstring(drawn(figure, "w").svg)
    top, bottom = (g for g in root.iter("{http://www.w3.org/2000/svg}g") if "data-x" in g.attrib)
    assert (bottom.get("data-x-label"), top.get("data-x-label")) == ("time [s]", "time [s]")
    (curve,) = (g for g in bottom.iter() if "data-curve" in g.attrib)
    assert curve.get("data-curve") == "A"
    x, y = _points(next(child.get("d") for child in curve.iter() if "d" in child.attrib))
    left, right, low, high = map(float, bottom.get("data-x").split()[:4])
    foot, head, least, most, scale = bottom.get("data-y").split()
    assert scale == "log"
    time = low + (x - left) / (right - left) * (high - low)
    share = (y - float(foot)) / (float(head) - float(foot))
    value = float(least) * (float(most) / float(least)) ** share
    assert np.allclose(np.log(value), time, atol=5e-3)


def _points(path):
    """Corners of a path of one M and steps."""
    numbers = [np.array(re.findall(r"-?\d*\.?\d+", part), dtype=float) for part in re.split(r"[Ml]", path)[1:]]
    return np.cumsum(numbers, axis=0).T


def test_words_have_the_numbers_of_named_curves(figure):
    assert in_words(figure) == ("heave [m] over time [s]: A -1 to 1. power [W] over time [s]: A 1 to 22030")


def test_bars_are_told_by_their_names():
    figure, axes = grid_of_axes(3.0)
    axes[0, 0].barh([0, 1], [3.0, -4.0], label="stored")
    axes[0, 0].set_yticks([0, 1], ["A", "B"])
    axes[0, 0].set_xlabel("energy [kJ]")
    assert in_words(figure) == "energy [kJ]: stored: A 3, B -4"


def test_data_are_those_of_the_figure(figure):
    figure.axes[0].set_xlim(0, 5)
    rows = list(csv.DictReader(io.StringIO(data_csv(figure))))
    named = [row for row in rows if row["axes"] == "heave [m]" and row["series"] == "A"]
    x, y = (np.array([float(row[key]) for row in named]) for key in "xy")
    assert len(x) == np.sum(X <= 5)
    assert np.allclose(y, np.sin(x), atol=1e-5)
    assert {row["series"] for row in rows if row["axes"] == "heave [m]"} == {"A", "line 2"}


def test_bars_and_maps_have_data_too():
    figure, axes = grid_of_axes(3.0, 1, 2)
    axes[0, 0].bar([1, 2], [3.0, 4.0], label="mass")
    axes[0, 1].pcolormesh([0, 1, 2], [0, 1], [[5.0, np.nan]])
    rows = list(csv.reader(io.StringIO(data_csv(figure))))[1:]
    assert [row[1:4:2] for row in rows if row[1] == "mass"] == [["mass", "3"], ["mass", "4"]]
    assert [row[2:] for row in rows if row[1] == "map"] == [["0.5", "0.5", "5"], ["1.5", "0.5", "nan"]]


def test_a_figure_is_small_on_a_page(figure):
    """Glyphs as paths alone took 30 kB."""
    assert len(drawn(figure, "w").svg) < 16_000


def test_no_number_has_more_than_two_decimals_and_no_element_a_space_of_names(figure):
    """Hundredths of a point are more than anybody sees; a prefix of names is more than a page understands."""
    text = drawn(figure, "wave").svg
    numbers = [value for place in re.findall(r'(?<!-)\b(?:d|points|transform|x|y|width|height)="([^"]*)"', text)
               for value in re.findall(r"\.(\d+)", place)]  # fmt: skip
    assert numbers
    assert max(map(len, numbers)) <= 2
    assert text.startswith("<svg ")
    assert "rotate(-90 " in text  # the label of a vertical axis
    assert "rotate(-0 " not in text  # all others
    assert "<metadata" not in text  # which has a date
    assert not re.search(r"</?\w+:|xmlns:ns\d", text)


def test_its_files_are_written_together(figure, tmp_path):
    paths = drawn(figure, "wave").write(str(tmp_path), "wave")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["wave.csv", "wave.pdf", "wave.svg"]
    assert [path.rsplit(".")[-1] for path in paths] == ["svg", "pdf", "csv"]


def test_a_figure_drawn_again_is_the_same_to_the_byte():
    """Names of what is cut off at the axes, too, which would otherwise be random."""
    first, again = (drawn(DRAWN["power_matrices"](campaign(), "one", "FSB"), "x").svg for _ in range(2))
    assert "clip-path" in first
    assert first == again


def test_of_a_long_curve_every_so_many_a_point_is_kept_and_of_a_map_every_cell():
    figure, axes = grid_of_axes(3.0, 1, 2)
    axes[0, 0].plot(np.arange(2001.0), np.arange(2001.0), label="long")
    axes[0, 0].plot(np.arange(1000.0), np.arange(1000.0), label="short")
    cells = np.arange(40.0 * 30).reshape(30, 40)
    axes[0, 1].pcolormesh(np.arange(41.0), np.arange(31.0), cells)
    rows = list(csv.DictReader(io.StringIO(data_csv(figure))))
    found = {name: [row for row in rows if row["series"] == name] for name in ("long", "short", "map")}
    assert [float(row["x"]) for row in found["long"]] == list(range(0, 2001, 3))
    assert len(found["short"]) == 1000
    assert [float(row["value"]) for row in found["map"]] == cells.ravel().tolist()


def test_words_are_of_the_first_eight_curves_as_far_as_they_are_shown_and_of_none_without_points():
    """A curve that is level has one number, of a title alone there is the title."""
    figure, axes = grid_of_axes(3.0, 1, 3)
    for k in range(10):
        axes[0, 0].plot([0.0, 1.0, 9.0], [k, k + 1.0, 99.0], label=f"c{k}")
    axes[0, 0].set(xlabel="time [s]", ylabel="heave [m]", xlim=(0.0, 2.0))
    axes[0, 1].plot([0.0, 1.0], [2.5, 2.5], label="level")
    axes[0, 1].plot([0.5], [7.0], label="point")
    axes[0, 1].plot([0.0, 1.0, 2.0], [-3.0, np.nan, 4.0], label="gap")
    axes[0, 1].set(title="a\ntitle", xlim=(0.0, 2.0))
    axes[0, 2].set(title="empty")
    figure.suptitle("all of\nit")
    told = ", ".join(f"c{k} {k} to {k + 1}" for k in range(8))
    assert in_words(figure) == (
        f"all of it. heave [m] over time [s]: {told}. a title over x: level 2.5, gap -3 to 4. empty"
    )


def test_upright_bars_have_the_names_below_them_and_bars_without_a_name_are_not_told():
    figure, axes = grid_of_axes(3.0)
    axes[0, 0].bar([0, 1], [3.0, -4.0], label="given")
    axes[0, 0].bar([0, 1], [1.0, 2.0], label="kept")
    axes[0, 0].bar([0, 1], [5.0, 6.0])
    axes[0, 0].set_xticks([0, 1], ["A", "B\nC"])
    axes[0, 0].set_ylabel("energy [kJ]")
    assert in_words(figure) == "energy [kJ]: given: A 3, B C -4; kept: A 1, B C 2"


@pytest.mark.parametrize(
    ("path", "short"),
    [
        ("M 1.234 5.678 L 2 3 z", "M1.23 5.68l.77-2.68z"),
        ("M -0.5 0.25 L -0.5 0.25 L 100.5 -10", "M-.5 .25l0 0l101-10.25"),
        ("M 1 1 L 2 2 M 7 3 L 6 3.5 z", "M1 1l1 1M7 3l-1 .5z"),
        ("M 0.004 0.006 L 0.008 0.012 L 0.012 0.018", "M0 .01l.01 0l0 .01"),
    ],
)
def test_paths_are_steps_between_rounded_places(path, short):
    """Every place begins anew at an M; errors of rounding do not add up."""
    assert _relative(path) == short


@pytest.mark.parametrize(
    ("path", "short"),
    [
        ("M 1.234 5.678 L 2 3 z", "M1.23 5.68l.77-2.68z"),
        ("M 1.234 5.678 Q 2 3.456 4 5 z", "M 1.23 5.68 Q 2 3.46 4 5 z"),
        ("M 1.234 5.678 L 2 2 C 2 3.456 4 5 6 7.001", "M 1.23 5.68 L 2 2 C 2 3.46 4 5 6 7"),
    ],
)
def test_a_path_with_bends_keeps_its_places(path, short):
    """Of steps there are those of lines alone."""
    element = ET.Element("path", {"d": path})
    _shorten(element, set(), "figure")
    assert element.get("d") == short


def test_data_are_of_points_that_exist_on_an_axis_of_either_direction_and_of_axes_without_a_name():
    figure, axes = grid_of_axes(3.0, 1, 2)
    axes[0, 0].set(title="first", ylabel="not this")
    axes[0, 0].plot([0.0, 1.0, 2.0, 3.0, 4.0], [5.0, np.nan, 7.0, np.inf, 9.0], label="A")
    axes[0, 0].set_xlim(3.5, 0.0)
    axes[0, 1].barh([1, 3], [-2.0, 4.0], height=0.5, left=[0.0, 1.0], label="stored")
    rows = list(csv.reader(io.StringIO(data_csv(figure))))
    assert rows == [
        ["axes", "series", "x", "y", "value"], ["first", "A", "0", "5"], ["first", "A", "2", "7"],
        ["axes 2", "stored", "-2", "1.25"], ["axes 2", "stored", "5", "3.25"],
    ]  # fmt: skip


def test_values_are_read_off_curves_on_axes_of_numbers_alone():
    """Not where a scale is neither linear nor logarithmic, nor where nothing has a name; of two curves each has its own."""
    figure, axes = grid_of_axes(4.0, 1, 3)
    for name, values in (("A", [1.0, 10.0]), ("B", [2.0, 20.0])):
        axes[0, 0].plot([1.0, 100.0], values, label=name)
        axes[0, 1].plot([1.0, 100.0], values, label=name)
    axes[0, 0].set(xscale="log", xlim=(1, 100), ylim=(0, 30), xlabel="force\n[kN]", ylabel="power [W]")
    axes[0, 1].set_yscale("asinh")
    axes[0, 2].plot([0.0, 1.0])
    root = ET.fromstring(drawn(figure, "x").svg)
    (marked,) = (element for element in root.iter() if "data-x" in element.attrib)
    assert marked.get("data-x").split()[2:] == ["1", "100", "log"]
    assert marked.get("data-y").split()[2:] == ["0", "30", "linear"]
    assert (marked.get("data-x-label"), marked.get("data-y-label")) == ("force [kN]", "power [W]")
    assert [element.get("data-curve") for element in root.iter() if "data-curve" in element.attrib] == ["A", "B"]


def test_each_file_is_of_its_kind(tmp_path):
    files = Drawn("<svg/>", b"%PDF", "axes\n")
    files.write(str(tmp_path), "a")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {
        "a.svg": b"<svg/>", "a.pdf": b"%PDF", "a.csv": b"axes\n"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("text", "short"),
    [
        ("translate(-0.001 5.0)", "translate(0 5)"),
        ("1.234,-5.678   .5", "1.23,-5.68 0.5"),
        ("matrix(1.5e-07 -2.5e1 10 0.995)", "matrix(0 -25 10 0.99)"),
        ("100 -20.10", "100 -20.1"),
    ],
)
def test_numbers_of_a_text_are_rounded_to_hundredths_and_nothing_has_no_sign(text, short):
    """Whole numbers stay as they are."""
    assert _rounded_all(text) == short


@pytest.mark.parametrize(
    ("value", "text"),
    [(0, "0"), (5, ".05"), (-5, "-.05"), (-99, "-.99"), (100, "1"), (-100, "-1"), (-150, "-1.5"), (2010, "20.1")],
)
def test_hundredths_are_written_as_short_as_they_can_be(value, text):
    assert _hundredths(value) == text


def test_groups_that_say_nothing_are_taken_away_and_what_is_in_them_stays_in_its_order():
    """However deep; a group with an attribute stays."""
    root = ET.fromstring(
        '<svg xmlns="http://www.w3.org/2000/svg"><a/><g><b/><g><c/></g><g id="x"><g><d/></g></g></g><e/></svg>'
    )
    _unwrap(root)
    told = [(element.tag.partition("}")[2], element.get("id")) for element in root.iter()]
    assert told == [("svg", None), ("a", None), ("b", None), ("c", None), ("g", "x"), ("d", None), ("e", None)]


def test_a_drawing_is_as_large_as_its_figure_and_says_what_it_shows(figure):
    """In points, 72 of an inch; wider than it is high."""
    figure.set_size_inches(6.25, 4.5)
    root = ET.fromstring(drawn(figure, "wave").svg)
    size = (root.get("width"), root.get("height"), root.get("viewBox"))
    assert size == ("450pt", "324pt", "0 0 450 324")
    assert (root.get("role"), root.get("aria-label")) == ("img", in_words(figure))


def test_of_many_bars_the_first_eight_are_told():
    figure, axes = grid_of_axes(3.0)
    for k in range(10):
        axes[0, 0].bar([0], [k + 1.0], label=f"b{k}")
    axes[0, 0].set_xticks([0], ["A"])
    axes[0, 0].set_xlabel("mass [kg]")
    assert in_words(figure) == "mass [kg]: " + "; ".join(f"b{k}: A {k + 1}" for k in range(8))
