"""Colours, axes and series that figures share; files of a figure: SVG with real text, data, description, print."""

import csv
import io
import re
import xml.etree.ElementTree as ET

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from report.test_campaign_page import campaign

from vsb.report.campaign_page import DRAWN
from vsb.report.canvas import (
    data_csv,
    drawn,
    for_print,
    grid_of_axes,
    heave_force,
    in_words,
    legend_above,
    period_axis,
    style,
)


def test_designs_are_drawn_by_their_role_whatever_their_names():
    names = ["a", "stiff", "z"]
    rigid, *others = (style(name, names, "stiff") for name in ("stiff", "a", "z"))
    assert rigid == {"color": "#000000", "linestyle": "-", "label": "stiff"}
    assert [look["color"] for look in others] == [style(name, ["a", "z"])["color"] for name in ("a", "z")]
    many = [f"{i}" for i in range(14)]
    assert len({(look["color"], look["linestyle"]) for look in (style(name, many) for name in many)}) == 14


def test_axis_of_periods_is_2_pi_over_frequency():
    figure, axes = grid_of_axes(3.0)
    axes[0, 0].set_xlim(0.0, 4.0)
    period_axis(axes[0, 0], (2, 2.5, 10))
    figure.draw_without_rendering()
    (period,) = axes[0, 0].child_axes
    assert [text.get_text() for text in period.get_xticklabels()] == ["2", "2.5", "10"]
    assert period.get_xlabel() == "wave period [s]"
    assert sorted(period.get_xlim()) == pytest.approx([np.pi / 2, 2e6 * np.pi])
    assert period.get_window_extent().y1 >= axes[0, 0].get_window_extent().y1


def test_forces_are_kilonewtons():
    """Excitation of the body-exact model is the sum of its parts."""
    names = {"velocity": 3.0, "excitation": 500.0, "froude_krylov": 2000.0, "diffraction": 4000.0, "pto": 7000.0}
    run = xr.Dataset({name: (("time", "dof"), [[value, 9e9]]) for name, value in names.items()})
    assert heave_force(run, "excitation").values.tolist() == [6.5]
    assert heave_force(run, "pto").values.tolist() == [7.0]
    assert heave_force(run, "drag").values.tolist() == [0.0]


def test_no_settings_of_a_user_change_a_figure():
    def svg():
        figure, axes = grid_of_axes(2.0)
        axes[0, 0].plot([0.0, 1.0], [0.0, 1.0])
        return drawn(figure, "line").svg

    own = {"axes.facecolor": "red", "lines.linestyle": "--", "mathtext.fontset": "stix", "axes.labelsize": 30}
    with mpl.rc_context():
        plain = svg()
    with mpl.rc_context(own):
        assert svg() == plain


X = np.linspace(0.0, 10.0, 400)


@pytest.fixture(scope="module")
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


@pytest.fixture(scope="module")
def files(figure):
    return drawn(figure, "wave")


def test_text_stays_text_in_svg_and_pdf(files, figure):
    texts = {
        "".join(element.itertext()) for element in ET.fromstring(files.svg).iter("{http://www.w3.org/2000/svg}text")
    }
    assert {"time [s]", "power [W]", "A"} <= texts
    pdf = for_print(figure, "pdf")
    assert b"/TrueType" in pdf or b"/Type42" in pdf or b"/CIDFontType2" in pdf
    assert for_print(figure, "png").startswith(b"\x89PNG")


def test_identifiers_are_unique_and_all_references_resolve(files):
    text = files.svg
    identities = re.findall(r'\bid="([^"]+)"', text)
    assert len(set(identities)) == len(identities)
    assert identities
    assert set(re.findall(r'(?:href="|url\()#([^")]+)', text)) == set(identities)


def test_values_can_be_read_off_the_drawn_curve(files):
    """Place and scale of the axes lead from the path back to the data to 0.01 pt."""
    root = ET.fromstring(files.svg)
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
    """Corners of a path of M and L."""
    return np.array(re.findall(r"-?\d*\.?\d+", path), dtype=float).reshape(-1, 2).T


def test_description_has_the_range_of_named_curves(figure):
    assert in_words(figure) == ("heave [m] over time [s]: A -1 to 1. power [W] over time [s]: A 1 to 22030")


def test_figure_is_reproducible_to_the_byte():
    first, again = (drawn(DRAWN["power_matrices"](campaign(), "one", "FSB"), "x") for _ in range(2))
    assert "clip-path" in first.svg
    assert first == again


def test_data_of_a_map_have_no_value_in_bins_without_seas():
    figure, axes = grid_of_axes(3.0, 1, 1)
    axes[0, 0].set_title("power")
    axes[0, 0].pcolormesh([0.0, 1.0, 2.0], [0.0, 1.0], np.array([[3.0, np.nan]]))
    assert [line.rpartition(",")[2] for line in data_csv(figure).splitlines()[1:]] == ["3", ""]


def test_data_leave_out_points_that_are_not_finite_or_not_shown():
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
