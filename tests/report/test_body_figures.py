"""Figures of bodies: motion of the port, range of every degree of freedom."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from vsb.report.body_figures import degrees_of_freedom, port_motion
from vsb.tools.ports import FORCE, MOMENT


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
        designs=("rigid", "flexible"), runs=runs, window=(2.0, 9.0), periods={"swell": 6.3}, port=FORCE
    )


@pytest.mark.parametrize(
    ("port", "labels"),
    [
        (FORCE, ["port's displacement [m]", "port's velocity [m/s]"]),
        (MOMENT, ["port's rotation [rad]", "port's angular velocity [rad/s]"]),
    ],
)
def test_port_that_rotates_is_drawn_in_radians(data, port, labels):
    axes = port_motion(SimpleNamespace(**{**vars(data), "port": port}), "swell").axes
    assert [ax.get_ylabel() for ax in axes] == labels


def test_bar_is_half_of_the_range_within_the_window(data):
    runs = {key: run.assign(position=run.position + 3.0) for key, run in data.runs.items()}
    for run in runs.values():
        run.position[{"time": 0}] = 50.0
        run.position[{"time": -1}] = -50.0
    (ax,) = degrees_of_freedom(SimpleNamespace(**{**vars(data), "runs": runs}), "swell").axes
    assert sorted(bar.get_width() for bar in ax.patches) == pytest.approx([0.5, 2.0, 2.0], rel=1e-2)
    assert ax.get_xlabel() == "half of the range in the window [m, of rotations rad]"


def test_no_logarithmic_axis_where_nothing_moves(data, recwarn):
    (ax,) = degrees_of_freedom(data, "swell").axes
    assert ax.get_xscale() == "log"
    runs = {key: run.assign(position=0.0 * run.position) for key, run in data.runs.items()}
    (ax,) = degrees_of_freedom(SimpleNamespace(**{**vars(data), "runs": runs}), "swell").axes
    assert ax.get_xscale() == "linear"
    assert not recwarn.list


def test_displacement_and_velocity_of_the_port_within_the_window(data):
    for k, key in enumerate(data.runs):
        data.runs[key] = data.runs[key] * (k + 1)
    for ax, name in zip(port_motion(data, "swell").axes, ("stroke", "stroke_rate"), strict=True):
        for line, design in zip(ax.get_lines(), data.designs, strict=True):
            expected = data.runs[design, "swell"][name].sel(time=slice(2.0, 9.0))
            np.testing.assert_array_equal(line.get_xydata(), np.stack([expected.time, expected], axis=1))
