"""What figures of a study show and what they leave out."""

import numpy as np
import pytest
import xarray as xr

from vsb.report.band import USEFUL
from vsb.report.canvas import StudyData
from vsb.report.figures import (
    absorbed_power,
    added_mass_damping,
    directions,
    radiation_kernel,
)

OMEGA = np.linspace(0.1, 6.0, 600)
NONE = xr.Dataset()


def data(**changes):
    """A rigid and a flexible design; what a figure is drawn of is put in."""
    given = dict.fromkeys(("modes", "database", "radiation", "response", "witness"), NONE)
    return StudyData(**{
        "designs": ("FSB", "VSWEC"), "reference": "FSB", "wave_frequencies": (2.5,), "periods": {}, "window": (0.0, 1.0),
        "runs": {}, **given, **changes,
    })  # fmt: skip


@pytest.fixture
def responding():
    """A bump of power at 2 rad/s; the gain runs away where nothing is absorbed any more."""
    power = np.exp(-4 * (OMEGA - 2.0) ** 2) * np.array([np.ones_like(OMEGA), 1 + 0.01 * OMEGA**4])
    pair = (("design", "omega"), 1e3 * power)
    response = xr.Dataset(
        {"best_power": pair, "absorbed_power": pair, "power_limit": ("omega", 5e3 / OMEGA)},
        coords={"design": ["FSB", "VSWEC"], "omega": OMEGA},
    )
    return data(response=response)


def test_gains_are_drawn_only_where_power_is_absorbed(responding):
    (_, _, low, _) = absorbed_power(responding).axes[:4]
    drawn = next(line for line in low.get_lines() if line.get_label() == "VSWEC")
    best = responding.response.best_power.max("design").values
    shown = ~np.isnan(drawn.get_ydata())
    assert shown.any()
    assert (best[shown] >= USEFUL * best.max()).all()
    assert low.get_ylim()[1] < 250  # beyond the bump it is a thousand


def test_no_panel_of_gains_without_a_rigid_design(responding):
    alone = data(response=responding.response, reference=None)
    assert len(absorbed_power(alone).axes) < len(absorbed_power(responding).axes)
    labels = [ax.get_xlabel() for ax in absorbed_power(alone).axes]
    assert labels == ["wave frequency [rad/s]"] * 2


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("omega", [0.12, 5.8])
def test_band_shown_includes_the_wave_of_the_study(responding, omega):
    figure = absorbed_power(data(response=responding.response, wave_frequencies=(omega,)))
    low, high = figure.axes[0].get_xlim()
    assert low <= omega <= high
    assert low <= 0.3 < 2.9 < high
    figure.draw_without_rendering()
    assert min(ax.get_position().width for ax in figure.axes[:4]) > 0.2


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


@pytest.mark.parametrize(
    ("labels", "shown"),
    [
        (["Pitch"], ["Pitch\n[10³ kg m²/s²]"]),
        (["a__Pitch", "Bend", "a__Heave"], ["a__Heave\n[10³ kg/s²]", "Bend\n[10³ kg/s²]"]),
        (["Mode7", "Heave", "Mode8", "Surge"], ["Heave\n[10³ kg/s²]", "Surge\n[10³ kg/s²]", "Mode7\n[10³ kg/s²]"]),
    ],
)
def test_kernels_are_of_displacements_or_else_of_rotations(labels, shown):
    """A flap has only pitch; motions of several bodies keep their names."""
    time, pair = np.linspace(0.0, 5.0, 11), ("influenced_dof", "radiating_dof")
    values = (("time", *pair), np.exp(-time)[:, None, None] * np.ones((len(labels), len(labels))))
    kernel = xr.Dataset({"kernel": values, "kernel_state_space": values}, dict.fromkeys(pair, labels) | {"time": time})
    assert [ax.get_ylabel() for ax in radiation_kernel(data(radiation=kernel)).axes] == shown


def test_every_regular_wave_is_marked(responding):
    for waves, label in (((2.5, 1.0), "study's waves"), ((1.0,), "study's wave"), ((), None)):
        figure = absorbed_power(data(response=responding.response, wave_frequencies=waves))
        for ax in figure.axes[:4]:
            marks = [line for line in ax.get_lines() if str(line.get_label()).startswith("study's")]
            assert [(line.get_label(), tuple(line.get_xdata())) for line in marks] == (
                [(label, waves)] if waves else []
            )


def test_rotations_are_drawn_in_degrees_and_displacements_in_metres():
    time, labels = np.linspace(0.0, 1.0, 5), ["Heave", "Pitch", "Surge"]
    position = xr.DataArray(np.outer(time, [1.0, np.pi, -2.0]), {"time": time, "dof": labels}, ("time", "dof"))
    runs = {(design, "w"): xr.Dataset({"position": k * position}) for k, design in enumerate(("FSB", "VSWEC"))}
    figure = directions(data(runs=runs, periods={"w": 1.0}), "w")
    assert [ax.get_ylabel() for ax in figure.axes] == ["surge [m]", "heave [m]", "pitch [degrees]"]
    for ax, end in zip(figure.axes, (-2.0, 1.0, 180.0), strict=True):
        rigid, shell = (line.get_ydata() for line in ax.get_lines())
        assert (rigid[-1], shell[-1]) == pytest.approx((0.0, end))


def test_motion_has_a_panel_if_any_design_moves_in_that_sea():
    time, labels = np.linspace(0.0, 1.0, 5), ["Heave", "Surge", "Pitch"]

    def run(*moved):
        return xr.Dataset(
            {"position": xr.DataArray(np.outer(time, moved), {"time": time, "dof": labels}, ("time", "dof"))}
        )

    runs = {
        ("FSB", "w"): run(1.0, 0.0, 0.0), ("VSWEC", "w"): run(1.0, 0.0, 0.5),
        ("FSB", "v"): run(1.0, 2.0, 0.0), ("VSWEC", "v"): run(1.0, 0.0, 0.0),
    }  # fmt: skip
    given = data(runs=runs, periods={"w": 1.0, "v": 1.0})
    for wave, shown in (("w", ["heave [m]", "pitch [degrees]"]), ("v", ["surge [m]", "heave [m]"])):
        assert [ax.get_ylabel() for ax in directions(given, wave).axes] == shown


@pytest.mark.filterwarnings("error")
def test_no_division_by_zero_power_of_the_rigid_design(responding):
    given = responding.response.absorbed_power.copy()
    given[0] = 0.0
    best, other = absorbed_power(data(response=responding.response.assign(absorbed_power=given))).axes[2:4]
    assert [text.get_text() for text in other.texts] == ["no absorbed power to compare with"]
    (gain,) = (line.get_ydata() for line in best.get_lines() if line.get_label() == "VSWEC")
    assert best.get_ylim() == pytest.approx((-20.0, 1.15 * np.nanmax(gain)))
    assert np.nanmax(gain) < 100
