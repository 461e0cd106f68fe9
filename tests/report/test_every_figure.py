"""Every figure is drawn as it was when it was looked at: what it shows is kept, artist by artist, in data/figures.txt.

After a change on purpose, look at the figure and write the file anew: `PYTHONPATH=tests python -m report.test_every_figure`.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import Collection
from matplotlib.colors import to_hex
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text
from report import test_campaign_figures, test_curves, test_sea_figures, test_side_by_side, test_witness_figure

from vsb.report.campaign_figures import DRAWN
from vsb.report.figures import draw
from vsb.report.sea_figures import year_spectra
from vsb.report.shape_figures import shape_figure
from vsb.report.side_by_side import figure as side_by_side
from vsb.scenes.shape_dependence import _EXPANSIONS

KEPT = Path(__file__).parents[1] / "data" / "figures.txt"
OMEGA = np.linspace(0.1, 6.0, 60)


def measure(values):
    """How many, the first, the last, the least, the largest, the mean, and a sum that tells their order."""
    values = np.ma.filled(np.ma.asarray(values, dtype=float), np.nan).ravel()
    known = values[np.isfinite(values)]
    if not len(known):
        return f"{len(values)} unknown"
    known = np.where(np.abs(known) < 1e-9 * np.abs(known).max(), 0.0, known)
    order = known @ np.cos(np.arange(len(known)))
    return f"{len(values)}/{len(known)}: " + " ".join(
        f"{value if abs(value) > 1e-12 * np.abs(known).max() else 0.0:.4g}"
        for value in (known[0], known[-1], known.min(), known.max(), known.mean(), order)
    )


def of_line(line):
    x, y = line.get_data(orig=False)
    dots = f"{line.get_marker()} {line.get_markersize():g} " if line.get_marker() not in ("None", None, "") else ""
    drawn = f"{to_hex(line.get_color())} {line.get_linestyle()} {line.get_linewidth():g} {dots}z{line.get_zorder():g}"
    return f"line {line.get_label()} {drawn} {line.get_alpha()} | x {measure(x)} | y {measure(y)}"


def of_patch(patch):
    (left, low), (right, high) = patch.get_path().transformed(patch.get_patch_transform()).get_extents().get_points()
    face = to_hex(patch.get_facecolor(), keep_alpha=True)
    return f"patch {face} {patch.get_hatch()} {left:.4g} {low:.4g} {right:.4g} {high:.4g}"


def of_collection(found):
    colours = [to_hex(colour, keep_alpha=True) for colour in (*found.get_facecolor()[:1], *found.get_edgecolor()[:1])]
    points = np.concatenate([np.zeros((0, 2)), *(path.vertices for path in found.get_paths())])
    mapped = "" if found.get_array() is None else f" | {measure(found.get_array())} in {found.get_clim()}"
    return f"{type(found).__name__} {' '.join(colours)} | x {measure(points[:, 0])} | y {measure(points[:, 1])}{mapped}"


def of_text(text):
    x, y = (f"{float(value):.4g}" for value in text.get_position())
    return f"text {text.get_text()!r} {x} {y} {text.get_ha()} {text.get_va()} {text.get_fontsize():g} {text.get_rotation():g}"


def of_axis(axis):
    low, high = sorted(axis.get_view_interval())
    inside = [t for t, place in zip(axis.get_ticklabels(), axis.get_ticklocs(), strict=False) if low <= place <= high]
    label, scale, turned = axis.get_label_text(), axis.get_scale(), axis.get_inverted()
    return f"{axis.axis_name} {label!r} {scale} {low:.4g} {high:.4g} {turned} {[t.get_text() for t in inside]}"


DRAWERS = {Line2D: of_line, Patch: of_patch, Collection: of_collection, Text: of_text}


def of_axes(ax):
    """All that is drawn in axes, a line each."""
    yield f"axes {ax.title.get_text()!r} {ax.axison}"
    yield from map(of_axis, ax._axis_map.values())
    for artist in ax.get_children():
        drawer = next((drawer for kind, drawer in DRAWERS.items() if isinstance(artist, kind)), None)
        if (
            drawer
            and artist not in (ax.patch, ax.title, *ax.spines.values())
            and (drawer is not of_text or artist.get_text())
        ):
            yield drawer(artist)
    for child in ax.child_axes:
        yield from map(of_axis, child._axis_map.values())


def of_figure(figure):
    """What a figure shows, a line each."""
    width, height = figure.get_size_inches()
    yield f"{width:g} {height:g} {figure.get_suptitle()!r}"
    for legend in figure.findobj(Legend):
        yield f"legend {legend._ncols} {[text.get_text() for text in legend.get_texts()]}"
    for ax in figure.axes:
        yield from of_axes(ax)


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
    time = test_curves.TIME
    fading = np.exp(-time)[:, None, None] * sizes
    kernels = {"kernel": (("time", *pair[1:]), fading), "kernel_state_space": (("time", *pair[1:]), 1.1 * fading)}
    radiation = xr.Dataset(kernels, {"time": time, "influenced_dof": labels, "radiating_dof": labels})
    given = test_curves.data(database=database, radiation=radiation)
    for k, found in enumerate(given.runs.values()):
        found.energy.loc[{"term": "stored"}] *= -1.0
        found.energy.loc[{"term": "radiated"}] *= 0.01  # less than a kilojoule
        for name, size in (("stroke", 0.3), ("stroke_rate", 0.6)):
            found[name] = ("time", (k + 1) * size * np.sin((1 + k) * time))
    rolling = test_curves.run("VSWEC", 1.0).isel(dof=[0, 1]).assign_coords(dof=["Heave", "Pitch"])
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
    "absorbed_power": lambda: draw("absorbed_power", test_curves.responding()),
    "reactance": lambda: draw("reactance", test_curves.responding()),
    **{
        name: (lambda name=name: draw(name, swimming()))
        for name in ("mode_shapes", "added_mass_damping", "radiation_kernel")
    },
    **{f"witness {w}": (lambda w=w: draw("witness", test_witness_figure.data(w))) for w in (False, True)},
    "year_spectra": lambda: year_spectra(test_sea_figures.year(0.7)),
    "shapes": lambda: shape_figure(shapes()),
    **{name: (lambda name=name: DRAWN[name](test_campaign_figures.campaign(), "one", "FSB")) for name in DRAWN},
    "side_by_side": lambda: side_by_side((test_side_by_side.RIGID, test_side_by_side.SHELL, test_side_by_side.YEAR)),
}


def parted(line):
    """Words of a line, and its numbers."""
    words, numbers = [], []
    for word in line.split():
        try:
            numbers.append(float(word))
        except ValueError:
            words.append(word)
    return words, numbers


def kept():
    """What each figure showed."""
    parts = KEPT.read_text(encoding="utf-8").split("\n= ")
    return {head: lines.splitlines() for head, _, lines in (part.removeprefix("= ").partition("\n") for part in parts)}


@pytest.mark.parametrize("name", CASES)
def test_a_figure_shows_what_it_showed_when_it_was_looked_at(name):
    now, then = list(of_figure(CASES[name]())), kept()[name]
    assert [parted(line)[0] for line in now] == [parted(line)[0] for line in then]
    for line, old in zip(now, then, strict=True):
        numbers = parted(old)[1]
        assert parted(line)[1] == pytest.approx(numbers, rel=2e-3, abs=1e-6 * max(map(abs, numbers), default=0.0)), old


if __name__ == "__main__":
    parts = ["\n".join([f"= {name}", *of_figure(made())]) for name, made in CASES.items()]
    KEPT.write_text("\n".join(parts) + "\n", encoding="utf-8")
