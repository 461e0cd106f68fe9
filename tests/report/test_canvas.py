from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from report.test_figures import data

from vsb.report.canvas import (
    SPARE,
    STYLES,
    folded,
    force_of,
    grid_of_axes,
    heave_force,
    legend_above,
    note,
    panels,
    period_axis,
    plain_numbers,
    shown_window,
    style,
    zero_axis,
)
from vsb.report.svg import drawn


def test_the_papers_designs_keep_their_colours_whatever_the_study():
    assert style("VSWEC", ["VSWEC"]) == style("VSWEC", ["FSB", "other", "VSWEC"])
    assert len({colour for colour, _ in STYLES.values()}) == 4


@pytest.mark.parametrize("count", [2, 4])
def test_other_designs_differ_from_each_other_and_from_the_papers(count):
    names = ["FSB", *(f"D{i}" for i in range(count))]
    colours = [style(name, names)["color"] for name in names]
    assert len(set(colours)) == len(names)
    assert style("D1", names) == style("D1", names)


@pytest.mark.parametrize(
    ("labels", "columns", "rows"),
    [
        (["FSB", "VSWEC"], 2, 1),
        ([f"design {i}" for i in range(12)], 5, 3),
        (["x" * 34] * 3, 2, 2),
        (["x" * 35] * 3, 1, 3),
        (["a", "x" * 34, "b"], 2, 2),
        (["x" * 200] * 3, 1, 3),
    ],
)
def test_a_legend_is_as_wide_as_the_page_and_the_figure_grows_by_its_rows(labels, columns, rows):
    figure, axes = grid_of_axes(3.0)
    for label in labels:
        axes[0, 0].plot([0, 1], label=label)
    legend_above(figure, axes[0, 0])
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == labels
    assert legend._ncols == columns
    assert figure.get_figheight() == pytest.approx(3.0 + 0.17 * (rows - 1))


@pytest.mark.parametrize(
    ("values", "alone"), [([0.0, 0.0], True), ([0.0, 1e-6], False), ([-3.0, 0.0], False), ([2.0, 1.0], False)]
)
def test_an_axis_has_a_scale_if_any_line_leaves_zero(values, alone):
    """A rigid design's line of zeros beside one that moves does not take the numbers off the axis."""
    _, axes = grid_of_axes(3.0)
    for value in values:
        axes[0, 0].plot([0.0, 1.0], [0.0, value])
    zero_axis(axes[0, 0])
    assert (axes[0, 0].get_yticks().tolist() == [0.0]) == alone


def test_a_figure_fits_a_page_of_text():
    """A4 between margins of an inch: 159 mm, of which it leaves nothing unused."""
    figure, _ = grid_of_axes(3.0, columns=3)
    assert 25.4 * figure.get_figwidth() == pytest.approx(210 - 2 * 25.4, abs=2.0)


def test_why_axes_are_empty_stands_in_their_middle_and_no_number_beside_it():
    _, axes = grid_of_axes(3.0)
    note(axes[0, 0], "nothing is absorbed")
    (text,) = axes[0, 0].texts
    assert (text.get_text(), text.get_position()) == ("nothing is absorbed", (0.5, 0.5))
    assert text.get_transform() == axes[0, 0].transAxes
    assert (text.get_ha(), len(axes[0, 0].get_yticks())) == ("center", 0)


def test_a_legend_lies_above_the_axes_where_it_covers_no_data():
    figure, axes = grid_of_axes(3.0)
    axes[0, 0].plot([0, 1], label="FSB")
    legend_above(figure, axes[0, 0])
    figure.draw_without_rendering()
    assert figure.legends[0].get_window_extent().y0 >= axes[0, 0].get_window_extent().y1


def test_an_axis_of_periods_stands_where_the_frequencies_are():
    """T = 2 pi / omega, both ways, zero among them; its ticks are whole numbers of seconds as people read them."""
    figure, axes = grid_of_axes(3.0)
    axes[0, 0].set_xlim(0.0, 4.0)
    period_axis(axes[0, 0], (2, 2.5, 10))
    figure.draw_without_rendering()
    (period,) = axes[0, 0].child_axes
    assert [text.get_text() for text in period.get_xticklabels()] == ["2", "2.5", "10"]
    assert period.get_xlabel() == "wave period [s]"
    assert sorted(period.get_xlim()) == pytest.approx([np.pi / 2, 2e6 * np.pi])
    assert period.get_window_extent().y1 >= axes[0, 0].get_window_extent().y1


def test_sixteen_designs_of_a_study_are_told_apart():
    """Four colours with four kinds of lines each."""
    names = [f"D{i}" for i in range(16)]
    assert len({(look["color"], look["linestyle"]) for look in (style(name, names) for name in names)}) == 16


@pytest.mark.parametrize(
    ("wave", "window", "shown"),
    [("w", (0.0, 100.0), (70.0, 100.0)), ("w", (69.0, 100.0), (70.0, 100.0)), ("w", (71.0, 100.0), (71.0, 100.0)),
     ("still", (40.0, 100.0), (0.0, 120.0))],
)  # fmt: skip
def test_series_show_fifteen_periods_at_most_and_all_of_what_dies_out(wave, window, shown):
    run = xr.Dataset(coords={"time": np.linspace(0.0, 120.0, 13)})
    given = replace(data(), runs={("FSB", wave): run}, periods={wave: 2.0}, window=window)
    assert shown_window(given, wave) == shown


def test_forces_are_kilonewtons_and_zero_where_there_is_none():
    """Excitation of the body-exact model is the sum of its parts."""
    names = {"velocity": 3.0, "excitation": 500.0, "froude_krylov": 2000.0, "diffraction": 4000.0, "pto": 7000.0}
    run = xr.Dataset({name: (("time", "dof"), [[value, 9e9]]) for name, value in names.items()})
    assert heave_force(run, "excitation").values.tolist() == [6.5]
    assert heave_force(run, "pto").values.tolist() == [7.0]
    assert heave_force(run, "drag").values.tolist() == [0.0]
    assert force_of(run, "pto").values.tolist() == [[7.0, 9e6]]
    assert force_of(run, "drag").values.tolist() == [[0.0, 0.0]]


def test_a_logarithmic_axis_of_few_decades_is_numbered_as_people_read_it():
    figure, axes = grid_of_axes(3.0)
    axes[0, 0].set(yscale="log", ylim=(4.0, 300.0))
    plain_numbers(axes[0, 0].yaxis)
    figure.draw_without_rendering()
    told = [label.get_text() for label in axes[0, 0].get_yticklabels() if 4 <= label.get_position()[1] <= 300]
    assert told == ["5", "10", "20", "50", "100", "200"]
    assert not any(label.get_text() for label in axes[0, 0].get_yticklabels(minor=True))


def test_series_of_every_design_are_its_own_in_the_window_over_one_axis_of_time():
    """What does not move has one tick, of each panel by itself."""
    time = np.linspace(0.0, 20.0, 21)
    runs = {
        (design, "w"): xr.Dataset({"a": ("time", k * time), "b": ("time", 0 * time)}, {"time": time})
        for k, design in enumerate(("FSB", "VSWEC"), 2)
    }
    given = replace(data(), runs=runs, periods={"w": 0.5}, window=(5.0, 15.0))
    figure = panels(given, "w", [("first [m]", lambda run: run.a), ("second [m]", lambda run: run.b)])
    top, bottom = figure.axes
    for k, (line, design) in enumerate(zip(top.get_lines(), ("FSB", "VSWEC"), strict=True), 2):
        np.testing.assert_array_equal(line.get_xydata(), np.stack([time[8:16], k * time[8:16]], axis=1))
        assert (line.get_label(), line.get_color()) == (design, style(design, ["FSB", "VSWEC"])["color"])
    assert [(ax.get_xlabel(), ax.get_ylabel(), ax.get_xlim()) for ax in (top, bottom)] == [
        ("", "first [m]", (7.5, 15.0)), ("time [s]", "second [m]", (7.5, 15.0)),
    ]  # fmt: skip
    assert (len(top.get_yticks()) > 1, bottom.get_yticks().tolist()) == (True, [0.0])
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["FSB", "VSWEC"]


def test_a_long_name_stands_on_several_lines():
    name = "a buoy with a rather long name"
    assert folded(name) == "a buoy with a\nrather long name"
    assert folded(name, 24) == "a buoy with a rather\nlong name"
    assert folded("FSB") == "FSB"


def test_series_of_each_sea_show_its_own_periods():
    """Of runs that last differently; in still water from the first instant to the last, whatever the window."""
    time = {"short": (0.0, 200.0), "long": (0.0, 200.0), "still": (2.0, 150.0)}
    runs = {("FSB", wave): xr.Dataset(coords={"time": np.linspace(*ends, 13)}) for wave, ends in time.items()}
    periods = {"short": 2.0, "long": 6.0, "still": 1.0}
    given = replace(data(), runs=runs, periods=periods, window=(50.0, 180.0))
    shown = {wave: shown_window(given, wave) for wave in time}
    assert shown == {"short": (150.0, 180.0), "long": (90.0, 180.0), "still": (2.0, 150.0)}


def test_designs_of_a_study_have_looks_by_their_order_among_those_the_paper_has_not():
    """After four of them colours come again, with the lines moved on by one; the paper's own do not count."""
    names = ["A", "FSB", "B", "VSWEC0", "C", "D", "E", "VSWEC", "F"]
    looks = {name: (style(name, names)["color"], style(name, names)["linestyle"]) for name in names}
    assert {name: looks[name] for name in STYLES if name in names} == {n: STYLES[n] for n in STYLES if n in names}
    colours, lines = zip(*SPARE, strict=True)
    assert [looks[name] for name in "ABCD"] == list(zip(colours, lines, strict=True))
    assert [looks[name] for name in "EF"] == list(zip(colours[:2], (*lines[1:], lines[0])[:2], strict=True))
    assert all(style(name, names)["label"] == name for name in names)


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
