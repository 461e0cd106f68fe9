"""Figure of the cross-check by the second solver."""

import numpy as np
import pytest
import xarray as xr

from vsb.report.canvas import StudyData
from vsb.report.witness_figure import witness

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
def test_markers_are_the_largest_differences_and_bars_the_sum_of_error_estimates(derived):
    shown = data(derived)
    figure = witness(shown)
    assert len(figure.axes) == 2 + derived
    top = figure.axes[0]
    for line, kind in zip(top.get_lines(), KINDS, strict=True):
        expected = shown.witness.witness_difference.sel(coefficient=kind).max("omega")
        np.testing.assert_array_equal(line.get_ydata(), expected.values)
    assert {round(bar.get_height(), 12) for bar in top.patches} == {4e-3}
    assert [label.get_text() for label in top.get_xticklabels()] == ["mean", "Membrane0 \N{MINUS SIGN}", "Membrane0 +"]


def test_changes_of_heave_are_in_percent_of_the_mean_shape():
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
