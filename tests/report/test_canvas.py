import numpy as np
import pytest

from vsb.report.canvas import STYLES, grid_of_axes, legend_above, note, period_axis, style, zero_axis


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
