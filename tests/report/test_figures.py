"""Figures of a study and their captions: what they show and what they leave out."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.report.canvas import StudyData, style
from vsb.report.figures import (
    added_mass_damping,
    captions,
    degrees_of_freedom,
    directions,
    port_motion,
)
from vsb.study.figure_names import of_study
from vsb.tools.variables import FORCE, MOMENT

OMEGA = np.linspace(0.1, 6.0, 600)
NONE = xr.Dataset()


def data(**changes):
    """A rigid and a flexible design; what a figure is drawn of is put in."""
    given = dict.fromkeys(("modes", "database", "radiation", "response", "witness"), NONE)
    return StudyData(**{
        "designs": ("FSB", "VSWEC"), "reference": "FSB", "wave_frequencies": (2.5,), "periods": {}, "window": (0.0, 1.0),
        "runs": {}, **given, **changes,
    })  # fmt: skip


def test_coefficients_are_drawn_on_axes_that_fit_them():
    """Zero damping is drawn below the logarithmic axis; a motion that moves no water is left out."""
    labels = ["Heave", "Pitch", "Membrane0"]
    added, damping = np.zeros((2, 4, 3))
    added[:, 0], added[:, 2] = [5.0, 4.0, 3.0, 2.0], [1.0, 2.0, 3.0, -4.0]
    damping[:, 0], damping[:, 2] = [0.0, 40.0, 200.0, 1e-5], [0.0, 0.5, 3.0, 2.0]
    pair = ("omega", "influenced_dof", "radiating_dof")
    coords = {"omega": [0.5, 1.0, 2.0, 4.0], "influenced_dof": labels, "radiating_dof": labels}
    values = {"added_mass": added, "radiation_damping": damping}
    database = xr.Dataset({name: (pair, v[:, :, None] * np.eye(3)) for name, v in values.items()}, coords)
    database["added_mass_inf"] = (pair[1:], np.diag([2.5, 0.0, 1.5]))
    figure = added_mass_damping(data(database=database))
    top, bottom = figure.axes
    drawn_ = {line.get_label(): line for line in bottom.get_lines()}
    assert list(drawn_) == ["Heave", "Membrane0"]
    assert drawn_["Heave"].get_ydata().tolist() == [1e-3, 40.0, 200.0, 1e-3]
    assert drawn_["Membrane0"].get_ydata().tolist() == [1e-3, 0.5, 3.0, 2.0]
    assert drawn_["Heave"].get_xdata().tolist() == [0.5, 1.0, 2.0, 4.0]
    assert (bottom.get_yscale(), bottom.get_ylim(), bottom.get_xlim()) == ("log", (2e-3, 400.0), (0.0, 4.0))
    lines = [line.get_ydata() for line in top.get_lines()]
    assert [list(y) for y in lines] == [list(added[:, 0]), [2.5, 2.5], list(added[:, 2]), [1.5, 1.5]]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["Heave", "Membrane0"]


def test_rotations_are_drawn_in_degrees_and_displacements_in_metres():
    time, labels = np.linspace(0.0, 1.0, 5), ["Heave", "Pitch", "Surge"]
    position = xr.DataArray(np.outer(time, [1.0, np.pi, -2.0]), {"time": time, "dof": labels}, ("time", "dof"))
    runs = {(design, "w"): xr.Dataset({"position": k * position}) for k, design in enumerate(("FSB", "VSWEC"))}
    figure = directions(data(runs=runs, periods={"w": 1.0}), "w")
    assert [ax.get_ylabel() for ax in figure.axes] == ["surge [m]", "heave [m]", "pitch [degrees]"]
    for ax, end in zip(figure.axes, (-2.0, 1.0, 180.0), strict=True):
        rigid, shell = (line.get_ydata() for line in ax.get_lines())
        assert (rigid[-1], shell[-1]) == pytest.approx((0.0, end))


@pytest.fixture
def body():
    time = np.linspace(0.0, 10.0, 101)
    wave = np.sin(time)
    runs = {}
    for design, labels in {"rigid": ["Heave"], "flexible": ["Heave", "Mode7"]}.items():
        position = np.stack([wave] * len(labels), axis=1) * np.array([2.0, 0.5])[: len(labels)]
        runs[design, "swell"] = xr.Dataset(
            {"position": (("time", "dof"), position), "stroke": ("time", wave), "stroke_rate": ("time", np.cos(time))},
            coords={"time": time, "dof": labels},
        )
    looks = partial(style, designs=("rigid", "flexible"), reference="rigid")
    return SimpleNamespace(
        designs=("rigid", "flexible"), style=looks, runs=runs, window=(2.0, 9.0), periods={"swell": 6.3}, port=FORCE
    )


@pytest.mark.parametrize(
    ("port", "labels"),
    [
        (FORCE, ["port's displacement [m]", "port's velocity [m/s]"]),
        (MOMENT, ["port's rotation [rad]", "port's angular velocity [rad/s]"]),
    ],
)
def test_port_that_rotates_is_drawn_in_radians(body, port, labels):
    axes = port_motion(SimpleNamespace(**{**vars(body), "port": port}), "swell").axes
    assert [ax.get_ylabel() for ax in axes] == labels


def test_bar_is_half_of_the_range_within_the_window(body):
    runs = {key: run.assign(position=run.position + 3.0) for key, run in body.runs.items()}
    for run in runs.values():
        run.position[{"time": 0}] = 50.0
        run.position[{"time": -1}] = -50.0
    (ax,) = degrees_of_freedom(SimpleNamespace(**{**vars(body), "runs": runs}), "swell").axes
    assert sorted(bar.get_width() for bar in ax.patches) == pytest.approx([0.5, 2.0, 2.0], rel=1e-2)
    assert ax.get_xlabel() == "half of the range in the window [m or rad]"


def test_displacement_and_velocity_of_the_port_within_the_window(body):
    for k, key in enumerate(body.runs):
        body.runs[key] = body.runs[key] * (k + 1)
    for ax, name in zip(port_motion(body, "swell").axes, ("stroke", "stroke_rate"), strict=True):
        for line, design in zip(ax.get_lines(), body.designs, strict=True):
            expected = body.runs[design, "swell"][name].sel(time=slice(2.0, 9.0))
            np.testing.assert_array_equal(line.get_xydata(), np.stack([expected.time, expected], axis=1))


def test_every_figure_of_a_study_has_a_caption(seed):
    irregular = varied(seed, waves=[{"kind": "jonswap", "hs": 0.5, "tp": 4.0}])
    names = {*of_study(irregular), *of_study(seed.model_copy(update={"motion": "planar"}))}
    assert {"spectra", "directions-regular_A0.179_T2.5"} < names
    assert {name.partition("-")[0] for name in names} <= captions(given=True, body=False).keys()
