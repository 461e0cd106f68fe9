"""Figure of the dependence on the shape: errors by size with their orders, powers by instant with what is negligible."""

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from report.test_every_figure import shapes

from vsb.report.shape_figures import _draw_errors, _draw_powers, _draw_slopes, shape_figure
from vsb.scenes.shape_dependence import _CURVES, _EXPANSIONS, NEGLIGIBLE, largest_mode, relative_slope

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


def test_powers_are_drawn_as_changes_about_a_band_that_is_negligible():
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


OMEGA = np.array([0.5, 1.0, 2.0])


def test_slopes_are_those_of_heave_and_of_the_largest_mode_in_terms_of_the_coefficient():
    """Full by heave, dashed by the mode of the largest change; axes end at the last frequency."""
    ds = shapes()
    ax = Figure().subplots()
    _draw_slopes(ax, ds)
    drawn = {line.get_label(): line for line in ax.get_lines()}
    mode = largest_mode(ds)
    assert mode == "Membrane2"
    for shape_dof, look in (("Heave", "-"), (mode, "--")):
        for name, (symbol, _) in _CURVES.items():
            line = drawn.pop(f"{symbol} by {shape_dof}")
            np.testing.assert_allclose(line.get_ydata(), relative_slope(ds, name).sel(shape_dof=shape_dof))
            assert line.get_linestyle() == look
    assert not drawn
    assert (ax.get_xlim()[0], ax.get_xlim()[1]) == (0.0, ds.omega.values[-1])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("angular frequency [rad/s]", "relative change [1/m]")


def test_powers_are_of_the_first_sea_and_stand_at_their_part_of_its_period():
    powers = np.arange(100.0, 116.0).reshape(2, 2, 4)
    ds = xr.Dataset(
        {
            "power_at_shape": (("wave", "design", "instant"), powers),
            "power_at_reference": (("wave", "design"), [[100.0, 50.0], [1.0, 2.0]]),
            "power_at_rest": (("wave", "design"), [[90.0, 60.0], [7.0, 8.0]]),
        },
        coords={"wave": ["swell", "chop"], "design": ["FSB", "VSWEC"]},
    )
    ax = Figure().subplots()
    _draw_powers(ax, ds)
    first, one, second, other = (line.get_xydata() for line in ax.get_lines())
    phase = [0.0, 0.25, 0.5, 0.75]
    np.testing.assert_allclose(first, np.stack([phase, [0.0, 1.0, 2.0, 3.0]], axis=1), atol=1e-12)
    np.testing.assert_allclose(second, np.stack([phase, [108.0, 110.0, 112.0, 114.0]], axis=1))
    np.testing.assert_allclose([one[0], other[0]], [[1.02, -10.0], [1.02, 20.0]])
    assert ax.get_xlabel() == "instant of the shape, swell [period or run]; triangles: shape at rest"


def test_powers_have_axes_of_their_own_where_there_are_any():
    ds = shapes()
    assert [ax.get_ylabel() for ax in shape_figure(ds).axes] == [
        "relative change [1/m]", "largest relative error [-]", "change of mean power [%]",
    ]  # fmt: skip
    assert len(shape_figure(ds.assign(power_at_reference=0 * ds.power_at_reference)).axes) == 2


def test_of_a_rigid_buoy_slopes_are_those_of_heave_alone():
    ds = shapes().isel(shape_dof=[0])
    ax = Figure().subplots()
    _draw_slopes(ax, ds)
    assert [line.get_label() for line in ax.get_lines()] == [f"{symbol} by Heave" for symbol, _ in _CURVES.values()]
