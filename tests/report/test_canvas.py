"""Colours, axes and series that figures share."""

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr

from vsb.report.canvas import (
    grid_of_axes,
    heave_force,
    period_axis,
    style,
)
from vsb.report.svg import drawn


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
