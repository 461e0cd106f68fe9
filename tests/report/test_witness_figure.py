"""Figure of the second solver: markers are differences, bars what estimates allow, signs the sides of a mode."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from vsb.report.canvas import StudyData
from vsb.report.witness_figure import _name_shapes, witness

SHAPES = ["mean", "Membrane0_minus", "Membrane0_plus"]
KINDS = ["added_mass", "radiation_damping", "excitation_force"]


def data(derived):
    rng = np.random.default_rng(0)
    dims, pair = ("omega", "shape", "coefficient"), ("influenced_dof", "radiating_dof")
    variables = {
        "witness_difference": (dims, rng.uniform(1e-4, 1e-3, (3, 3, 3))),
        "witness_estimate": (("solver", "shape", "coefficient"), np.full((2, 3, 3), 2e-3)),
        **{f"shape_{k}": (("solver", "shape", "omega", *pair), rng.uniform(1, 2, (2, 3, 3, 2, 2))) for k in KINDS[:2]},
    }
    coords = {"omega": [1.0, 2.0, 3.0], "shape": SHAPES, "coefficient": KINDS, "solver": ["panels", "spectral"]}
    if derived:
        variables["slope_difference"] = (("omega", "shape_dof", "coefficient"), rng.uniform(1e-3, 1e-2, (3, 1, 3)))
        variables["slope_estimate"] = (("shape_dof", "coefficient"), np.full((1, 3), 2e-2))
        coords["shape_dof"] = ["Membrane0"]
    empty, ds = xr.Dataset(), xr.Dataset(variables, coords)
    return StudyData(("FSB",), "FSB", (), {}, (0.0, 1.0), empty, empty, empty, empty, {}, ds)


@pytest.mark.parametrize("derived", [False, True])
def test_differences_are_the_largest_over_frequencies_and_bars_the_sum_of_both_estimates(derived):
    shown = data(derived)
    figure = witness(shown)
    assert len(figure.axes) == 2 + derived
    top = figure.axes[0]
    for line, kind in zip(top.get_lines(), KINDS, strict=True):
        expected = shown.witness.witness_difference.sel(coefficient=kind).max("omega")
        np.testing.assert_array_equal(line.get_ydata(), expected.values)
    assert {round(bar.get_height(), 12) for bar in top.patches} == {4e-3}
    assert [label.get_text() for label in top.get_xticklabels()] == ["mean", "Membrane0 \N{MINUS SIGN}", "Membrane0 +"]


def test_heave_is_shown_as_its_change_from_the_mean_shape():
    ax = witness(data(False)).axes[1]
    assert all(line.get_ydata()[0] == 0.0 for line in ax.get_lines() if len(line.get_ydata()) == len(SHAPES))


def test_changes_are_from_the_mean_shape_wherever_it_stands_among_the_shapes():
    shown = data(False)
    ds = shown.witness.isel(shape=[1, 0, 2])
    drawn = [line.get_ydata() for line in witness(replace(shown, witness=ds)).axes[1].get_lines()]
    changes = [of for of in drawn if len(of) == len(SHAPES)]
    assert len(changes) == 12
    assert all(of[1] == 0.0 and of[0] != 0.0 and of[2] != 0.0 for of in changes)


def test_marks_of_a_shape_stand_side_by_side_over_its_name_and_the_legend_above_them():
    shown = data(True)
    figure = witness(shown)
    figure.draw_without_rendering()
    for ax, count in zip(figure.axes, (3, 3, 1), strict=True):
        legend = ax.get_legend()
        assert legend.get_window_extent().y0 >= ax.get_window_extent().y1
        places = {float(x) for line in ax.get_lines() for x in line.get_xdata() if len(line.get_xdata()) == count}
        near = {round(x - round(x), 12) for x in places}
        assert (near, {round(x) for x in places}) == ({-0.24, 0.0, 0.24}, set(range(count)))
        assert ax.get_xticks().tolist() == list(range(count))
        assert ax.get_xlim() == pytest.approx((-0.6, count - 0.4))
    for ax in (figure.axes[0], figure.axes[2]):
        told = [text.get_text() for text in ax.get_legend().get_texts()]
        assert told == ["added mass", "radiation damping", "excitation", "sum of their estimated errors"]


@pytest.mark.parametrize(
    ("low", "high", "bar", "ends"),
    [
        (3e-4, 5e-4, 2e-3, (1e-4, 1e-2)),  # bars above the markers
        (3e-4, 9e-3, 2e-3, (1e-4, 1e-1)),  # 1.2 times the highest marker is above a power of ten
        (3e-4, 8e-3, 2e-3, (1e-4, 1e-2)),
        (1.9e-4, 8e-3, 2e-3, (1e-5, 1e-2)),  # half of the lowest is below one
    ],
)
def test_an_axis_of_differences_ends_at_powers_of_ten_that_leave_room(low, high, bar, ends):
    """The lowest marker is the largest difference of its shape and coefficient; smaller ones are not drawn."""
    shown = data(False)
    shown.witness["witness_difference"][:] = 1e-9
    shown.witness["witness_difference"][1] = low
    shown.witness["witness_difference"][1, 2, 1] = high
    shown.witness["witness_estimate"][:] = bar / 2
    assert witness(shown).axes[0].get_ylim() == pytest.approx(ends)


def test_changes_of_heave_are_those_of_its_own_coefficients_in_percent_by_both_solvers():
    shown = data(False)
    ax = witness(shown).axes[1]
    drawn = [tuple(line.get_ydata()) for line in ax.get_lines() if len(line.get_ydata()) == len(SHAPES)]
    expected = []
    for w in range(3):
        for kind in KINDS[:2]:
            of = shown.witness[f"shape_{kind}"].values[:, :, w, 0, 0]
            expected += [tuple(100 * (of[i] / of[i, 0] - 1)) for i in (1, 0)]  # spectral, then panels
    np.testing.assert_allclose(drawn, expected, atol=1e-12)
    told = [text.get_text() for text in ax.get_legend().get_texts()]
    assert told == [f"{word}, {w} rad/s" for w in (1, 2, 3) for word in ("added mass", "damping")] + ["panels"]


@pytest.mark.parametrize(("count", "rotation"), [(5, 0.0), (6, 90.0)])
def test_names_of_many_shapes_stand_upright(count, rotation):
    ax = Figure().subplots()
    _name_shapes(ax, [f"Bend{n}_plus" for n in range(count)])
    assert {label.get_rotation() for label in ax.get_xticklabels()} == {rotation}
    assert ax.get_xticklabels()[-1].get_text() == f"Bend{count - 1} +"
