"""Checks of every figure: axes are labelled, curves are visible, a design keeps its colour."""

import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from report import test_campaign_page, test_figures, test_hydro_figures, test_side_by_side

from vsb.models.shape_dependence import _EXPANSIONS
from vsb.report.campaign_page import DRAWN
from vsb.report.canvas import style
from vsb.report.figures import draw
from vsb.report.hydro_figures import shape_figure, year_spectra
from vsb.report.side_by_side import figure as side_by_side

OMEGA = np.linspace(0.1, 6.0, 60)


def swimming():
    """A buoy with a database, a kernel, tilted runs and losing terms: what the curves' own study has not."""
    labels = ["Heave", "Membrane0", "Membrane1"]
    pair, bump = ("omega", "influenced_dof", "radiating_dof"), np.exp(-((OMEGA - 2.0) ** 2))
    sizes = np.diag([5e4, 2e4, 1e4])
    database = xr.Dataset(
        {
            "added_mass": (pair, (1 + bump[:, None, None]) * sizes),
            "added_mass_inf": (pair[1:], 0.9 * sizes),
            "radiation_damping": (pair, bump[:, None, None] * sizes),
        },
        {"omega": OMEGA, "influenced_dof": labels, "radiating_dof": labels},
    )
    time = test_figures.TIME
    fading, dims = np.exp(-time)[:, None] * np.diag(sizes), ("time", "radiating_dof")
    kernels = {"kernel": (dims, fading), "kernel_state_space": (dims, 1.1 * fading)}
    radiation = xr.Dataset(kernels, {"time": time, "radiating_dof": labels})
    pushed = 5e4 * bump[None, :, None] * np.exp(0.3j * OMEGA[:, None] * np.arange(1, 4))
    database["excitation_force"] = (("wave_direction", "omega", "influenced_dof"), pushed)
    given = test_figures.data(database=database.assign_coords(wave_direction=[0.0]), radiation=radiation)
    given = replace(given, response=test_figures.responding().response, raos=test_figures.raos())
    for found in given.runs.values():
        found.energy.loc[{"term": "stored"}] *= -1.0
        found.energy.loc[{"term": "radiated"}] *= 0.01  # less than a kilojoule
    rolling = test_figures.run("VSWEC", 1.0).isel(dof=[0, 1]).assign_coords(dof=["Heave", "Pitch"])
    rolling.position[{"dof": 1}] *= 100.0
    return replace(given, runs={**given.runs, ("FSB", "still"): rolling})


def shapes():
    """Errors of expansions, and powers at the shapes of a motion."""
    sizes = np.array([0.05, 0.1, 0.2])
    errors = [0.3 * sizes ** (i + 1.1) for i in range(len(_EXPANSIONS))]
    powers = 100 + np.arange(12.0).reshape(1, 2, 6)
    pair, waved = ("omega", "influenced_dof", "radiating_dof"), ("omega", "influenced_dof")
    heave = (2.0 + np.sin(OMEGA))[:, None, None]
    slopes = np.array([0.3, 0.1, -0.5])[:, None, None, None] * np.cos(OMEGA)[:, None, None]
    coefficients = {}
    for name, dims, own in (
        ("added_mass", pair, heave), ("radiation_damping", pair, 1.5 * heave), ("excitation_force", waved, 2j * heave[..., 0]),
    ):  # fmt: skip
        slope = slopes * own if dims == pair else slopes[..., 0] * own
        coefficients |= {name: (dims, own), f"{name}_slope": (("shape_dof", *dims), slope)}
    return xr.Dataset(
        coefficients
        | {
            "interpolation_error": (("expansion", "deformation"), errors),
            "tried_shape": (("tried", "shape_dof"), [[0.03, 0.04, 0.0], [0.0, 0.06, 0.08]]),
            "tried_error": (("tried", "coefficient"), [[1e-4, 3e-4], [2e-4, 1e-4]]),
            "power_at_shape": (("wave", "design", "instant"), powers),
            "power_at_reference": (("wave", "design"), [[100.0, 50.0]]),
            "power_at_rest": (("wave", "design"), [[98.0, 53.0]]),
        },
        coords={
            "omega": OMEGA,
            "shape_dof": ["Heave", "Membrane0", "Membrane2"],
            "wave": ["regular"],
            "design": ["FSB", "VSWEC"],
            "expansion": list(_EXPANSIONS),
            "deformation": sizes,
        },
        attrs={"reference": "FSB"},
    )


OF_A_WAVE = (
    "heave_excitation", "velocity_pto", "power_energy", "energy_audit", "snapshots", "extreme_shapes", "shapes_3d",
    "volume_area", "port_motion", "degrees_of_freedom",
)  # fmt: skip
CASES = {
    **{f"{name}-w": (lambda name=name: draw(f"{name}-w", swimming())) for name in OF_A_WAVE},
    **{
        f"{name}-still": (lambda name=name: draw(f"{name}-still", swimming())) for name in ("power_energy", "snapshots")
    },
    "absorbed_power": lambda: draw("absorbed_power", test_figures.responding()),
    "reactance": lambda: draw("reactance", test_figures.responding()),
    "rao": lambda: draw("rao", swimming()),
    "excitation": lambda: draw("excitation", swimming()),
    **{
        name: (lambda name=name: draw(name, swimming()))
        for name in ("mode_shapes", "added_mass_damping", "radiation_kernel")
    },
    **{f"witness {w}": (lambda w=w: draw("witness", test_hydro_figures.crosschecked(w))) for w in (False, True)},
    "year_spectra": lambda: year_spectra(test_hydro_figures.year(0.7)),
    "shapes": lambda: shape_figure(shapes()),
    **{name: (lambda name=name: DRAWN[name](test_campaign_page.campaign(), "one", "FSB")) for name in DRAWN},
    "side_by_side": lambda: side_by_side((test_side_by_side.RIGID, test_side_by_side.SHELL, test_side_by_side.YEAR)),
}


DRAWN_ONCE = {}


def figure_of(name):
    """A figure, drawn once for all tests, its layout done."""
    if name not in DRAWN_ONCE:
        DRAWN_ONCE[name] = CASES[name]()
        DRAWN_ONCE[name].draw_without_rendering()
    return DRAWN_ONCE[name]


def axes_of(name):
    return [ax for ax in figure_of(name).axes if ax.axison and ax.get_visible() and not hasattr(ax, "get_zlim")]


def is_number(text):
    return re.fullmatch(r"[\d.,\s-]+(e-?\d+)?|\$.*\$", text.replace("\N{MINUS SIGN}", "-")) is not None


@pytest.mark.parametrize("name", CASES)
def test_axes_with_numbers_are_labelled(name):
    for ax in axes_of(name):
        for axis, shared in ((ax.xaxis, ax.get_shared_x_axes()), (ax.yaxis, ax.get_shared_y_axes())):
            labels = [label.get_text() for label in axis.get_ticklabels() if label.get_visible() and label.get_text()]
            numbers = [text for text in labels if is_number(text)]
            words = [getattr(one, f"{axis.axis_name}axis").get_label_text() for one in shared.get_siblings(ax)]
            assert not numbers or any(words), (axis.axis_name, labels)
            assert len(set(labels)) == len(labels), "two ticks with one text"


@pytest.mark.parametrize("name", CASES)
def test_legends_match_the_lines_and_designs_keep_their_colour(name):
    figure = figure_of(name)
    designs = {design: style(design, ["FSB", "VSWEC"], "FSB")["color"] for design in ("FSB", "VSWEC")}
    for legend in figure.findobj(Legend):
        names = [text.get_text() for text in legend.get_texts()]
        assert len(set(names)) == len(names)
        colours = {
            text: handle.get_color()
            for text, handle in zip(names, legend.legend_handles, strict=True)
            if isinstance(handle, Line2D)
        }
        for line in (line for ax in figure.axes for line in ax.lines if line.get_label() in colours):
            assert to_hex(line.get_color()) == to_hex(colours[line.get_label()])
    for line in (line for ax in figure.axes for line in ax.lines if line.get_label() in designs):
        assert to_hex(line.get_color()) == designs[line.get_label()].lower()
