"""Figure of the dependence on the shape: errors by order, changes of power."""

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from vsb.report.shape_figures import _draw_errors, _draw_powers
from vsb.scenes.shape_dependence import _EXPANSIONS, NEGLIGIBLE

SIZE = np.array([0.05, 0.1, 0.2])


def test_guides_fall_with_the_order_of_each_expansion():
    errors = np.array([SIZE ** (i + 1) for i in range(len(_EXPANSIONS))])
    ds = xr.Dataset(
        {
            "interpolation_error": (("expansion", "deformation"), errors),
            "tried_shape": (("tried", "shape_dof"), [[0.03, 0.04]]),
            "tried_error": (("tried", "coefficient"), [[1e-4, 3e-4]]),
        },
        coords={"expansion": list(_EXPANSIONS), "deformation": SIZE},
    )
    ax = Figure().subplots()
    _draw_errors(ax, ds)
    drawn = {line.get_label(): line for line in ax.get_lines()}
    for kind, (label, _, _) in _EXPANSIONS.items():
        np.testing.assert_array_equal(drawn[label].get_ydata(), ds.interpolation_error.sel(expansion=kind).values)
    guides = [line for line in ax.get_lines() if line.get_linestyle() == ":"]
    slopes = [np.diff(np.log(line.get_ydata())) / np.diff(np.log(SIZE)) for line in guides]
    np.testing.assert_allclose(slopes, [[2.0, 2.0], [3.0, 3.0]])
    assert [line.get_ydata()[0] for line in guides] == pytest.approx(0.5 * errors[:2, 0])
    tried = drawn["shape database, within its reach"]
    assert (tried.get_xdata()[0], tried.get_ydata()[0]) == (0.05, 3e-4)


def test_powers_are_drawn_as_changes_in_percent():
    ds = xr.Dataset(
        {
            "power_at_shape": (("wave", "design", "instant"), [[[110.0, 90.0], [50.0, 50.0]]]),
            "power_at_reference": (("wave", "design"), [[100.0, 50.0]]),
        },
        coords={"wave": ["regular"], "design": ["FSB", "VSWEC"]},
    )
    with mpl.rc_context():
        ax = Figure().subplots()
        _draw_powers(ax, ds)
    first, second = (line.get_ydata() for line in ax.get_lines())
    np.testing.assert_allclose(first, [10.0, -10.0])
    np.testing.assert_allclose(second, [0.0, 0.0])
    rest = ds.assign(power_at_rest=(("wave", "design"), [[120.0, 40.0]]))
    with mpl.rc_context():
        beside = Figure().subplots()
        _draw_powers(beside, rest)
    marks = [float(line.get_ydata()[0]) for line in beside.get_lines() if line.get_marker() == "<"]
    assert marks == pytest.approx([20.0, -20.0]), "each over its own power at the reference"
    (band,) = ax.patches
    height = band.get_extents().transformed(ax.transData.inverted()).height
    assert height == pytest.approx(200 * NEGLIGIBLE)
