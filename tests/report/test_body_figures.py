"""Figures of bodies are drawn of what runs record."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

from vsb.report.body_figures import degrees_of_freedom, port_motion
from vsb.report.canvas import style


@pytest.fixture
def data():
    time = np.linspace(0.0, 10.0, 101)
    wave = np.sin(time)
    runs = {}
    for design, labels in {"rigid": ["Heave"], "flexible": ["Heave", "Mode7"]}.items():
        position = np.stack([wave] * len(labels), axis=1) * np.array([2.0, 0.5])[: len(labels)]
        runs[design, "swell"] = xr.Dataset(
            {"position": (("time", "dof"), position), "stroke": ("time", wave), "stroke_rate": ("time", np.cos(time))},
            coords={"time": time, "dof": labels},
        )
    return SimpleNamespace(
        designs=("rigid", "flexible"), runs=runs, window=(2.0, 9.0), periods={"swell": 6.3}, port="heave"
    )


def test_the_port_of_every_design_is_drawn(data):
    top, bottom = port_motion(data, "swell").axes
    assert [line.get_label() for line in top.get_lines()] == ["rigid", "flexible"]
    assert bottom.get_ylabel() == "port's velocity [m/s]"


@pytest.mark.parametrize(
    ("port", "labels"),
    [
        ({"dofs": {"Heave": 1.0}}, ["port's displacement [m]", "port's velocity [m/s]"]),
        ({"dofs": {"aft__Pitch": 1.0}}, ["port's rotation [rad]", "port's velocity [rad/s]"]),
    ],
)
def test_a_port_that_turns_does_so_in_radians(data, port, labels):
    axes = port_motion(SimpleNamespace(**{**vars(data), "port": port}), "swell").axes
    assert [ax.get_ylabel() for ax in axes] == labels


def test_every_degree_of_freedom_has_a_bar_of_its_range(data):
    (ax,) = degrees_of_freedom(data, "swell").axes
    assert [text.get_text() for text in ax.get_yticklabels()] == ["Heave", "Mode7"]
    assert sorted(bar.get_width() for bar in ax.patches) == pytest.approx([0.5, 2.0, 2.0], rel=1e-2)


def test_bars_of_designs_lie_about_their_row_side_by_side(data):
    """They share four fifths of it, half above and half below its tick."""
    (ax,) = degrees_of_freedom(data, "swell").axes
    spans = sorted((bar.get_y(), bar.get_y() + bar.get_height()) for bar in ax.patches)
    rigid, heave, mode = spans
    assert (rigid[0], heave[1]) == pytest.approx((-0.4, 0.4))
    assert rigid[1] == pytest.approx(heave[0])
    assert mode == pytest.approx((1.0, 1.4))


def test_a_bar_is_half_of_what_lies_between_the_ends_of_the_window(data):
    """A body that swings about another place than zero, its start, and what follows, are no part of it."""
    runs = {key: run.assign(position=run.position + 3.0) for key, run in data.runs.items()}
    for run in runs.values():
        run.position[{"time": 0}] = 50.0
        run.position[{"time": -1}] = -50.0
    (ax,) = degrees_of_freedom(SimpleNamespace(**{**vars(data), "runs": runs}), "swell").axes
    assert sorted(bar.get_width() for bar in ax.patches) == pytest.approx([0.5, 2.0, 2.0], rel=1e-2)
    assert ax.get_xlabel() == "half of the range in the window [m, of rotations rad]"


def test_where_nothing_moves_nothing_is_on_a_logarithmic_axis(data, recwarn):
    """Still water: bars of nothing."""
    (ax,) = degrees_of_freedom(data, "swell").axes
    assert ax.get_xscale() == "log"
    runs = {key: run.assign(position=0.0 * run.position) for key, run in data.runs.items()}
    (ax,) = degrees_of_freedom(SimpleNamespace(**{**vars(data), "runs": runs}), "swell").axes
    assert ax.get_xscale() == "linear"
    assert not recwarn.list


def test_the_displacement_of_every_design_in_the_window_stands_above_its_velocity(data):
    for k, key in enumerate(data.runs):
        data.runs[key] = data.runs[key] * (k + 1)
    for ax, name in zip(port_motion(data, "swell").axes, ("stroke", "stroke_rate"), strict=True):
        for line, design in zip(ax.get_lines(), data.designs, strict=True):
            expected = data.runs[design, "swell"][name].sel(time=slice(2.0, 9.0))
            np.testing.assert_array_equal(line.get_xydata(), np.stack([expected.time, expected], axis=1))


def test_a_bar_lies_in_the_row_of_its_motion_whatever_the_order_of_a_design_and_in_its_colour(data):
    """One that does not move has none on the logarithmic axis of the others."""
    one = data.runs["flexible", "swell"].isel(dof=[1, 0]).assign_coords(dof=["Mode7", "Heave"])
    one.position[{"dof": 1}] = 0.0
    data.runs["flexible", "swell"] = one
    figure = degrees_of_freedom(data, "swell")
    (ax,) = figure.axes
    rows = {round(bar.get_y() + bar.get_height() / 2): [] for bar in ax.patches}
    for bar in ax.patches:
        rows[round(bar.get_y() + bar.get_height() / 2)].append((to_hex(bar.get_facecolor()), round(bar.get_width(), 2)))
    rigid, flexible = (to_hex(style(design, data.designs)["color"]) for design in data.designs)
    assert rows == {0: [(rigid, 2.0), (flexible, 0.0)], 1: [(flexible, 0.5)]}
    assert ax.get_xscale() == "log"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["rigid", "flexible"]


def test_degrees_of_freedom_of_all_designs_have_rows_in_the_order_they_come(data):
    """Of two designs that share one."""
    for design, labels in {"rigid": ["Surge", "Heave"], "flexible": ["Heave", "Mode7"]}.items():
        data.runs[design, "swell"] = data.runs["flexible", "swell"].assign_coords(dof=labels)
    (ax,) = degrees_of_freedom(data, "swell").axes
    assert [text.get_text() for text in ax.get_yticklabels()] == ["Surge", "Heave", "Mode7"]
    rows = sorted((round(bar.get_y() + bar.get_height() / 2, 1), round(bar.get_width(), 1)) for bar in ax.patches)
    assert rows == [(-0.2, 2.0), (0.8, 0.5), (1.2, 2.0), (2.2, 0.5)]
