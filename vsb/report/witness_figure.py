"""Figure of the second solver: how far two solvers are apart, on which shapes, and what their estimates allow."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vsb.report.canvas import StudyData, grid_of_axes

_COEFFICIENTS = {
    "added_mass": ("added mass", "#000000", "o"),
    "radiation_damping": ("radiation damping", "#D55E00", "s"),
    "excitation_force": ("excitation", "#0072B2", "^"),
}
_COLOURS = ("#56B4E9", "#009E73", "#CC79A7")
"""Of the three frequencies."""


_OF_HEAVE = {"added_mass": ("added mass", "o"), "radiation_damping": ("damping", "s")}


def witness(data: StudyData) -> Figure:
    """Draw differences with what is to be expected of them, heave's coefficients by shape, and their derivatives."""
    ds = data.witness
    derived = "slope_difference" in ds
    figure, axes = grid_of_axes(9.0 if derived else 6.0, 2 + derived, 1, height_ratios=[3, 3, 3][: 2 + derived])
    _draw_differences(axes[0, 0], ds.witness_difference, ds.witness_estimate.sum("solver"), "shape")
    axes[0, 0].set(ylabel="difference of two solvers [-]")
    _draw_heave(axes[1, 0], ds)
    if derived:
        _draw_differences(axes[2, 0], ds.slope_difference, ds.slope_estimate, "shape_dof")
        axes[2, 0].set(ylabel="difference in derivatives [-]", xlabel="mode by which the shape changes")
    return figure


def _draw_differences(ax: Axes, apart: xr.DataArray, expected: xr.DataArray, dim: str) -> None:
    """Largest difference at any frequency of each coefficient; bars reach up to its estimated errors."""
    names = [str(name) for name in apart[dim].values]
    place = np.arange(len(names))
    for i, (coefficient, (label, colour, marker)) in enumerate(_COEFFICIENTS.items()):
        x, allowed = place + 0.24 * (i - 1), expected.sel(coefficient=coefficient).values
        bar = "sum of their estimated errors" if i == 0 else None
        ax.bar(x, allowed, 0.2, color="#999999", alpha=0.35, label=bar)
        found = apart.sel(coefficient=coefficient).max("omega")
        ax.plot(x, found, marker, color=colour, markersize=4, linestyle="none", label=label)
    least, most = float(apart.max("omega").min()), float(max(apart.max(), expected.max()))
    ax.set(yscale="log", ylim=(10 ** np.floor(np.log10(least / 2)), 10 ** np.ceil(np.log10(1.2 * most))))
    _name_shapes(ax, names)
    ax.legend(fontsize=8, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0))


def _draw_heave(ax: Axes, ds: xr.Dataset) -> None:
    """Change of heave's added mass and damping from the mean shape's, at each frequency, by both solvers."""
    names = [str(name) for name in ds.shape.values]
    for i, (omega, colour) in enumerate(zip(ds.omega.values, _COLOURS, strict=True)):
        x = np.arange(len(names)) + 0.24 * (i - 1)
        for name, (words, marker) in _OF_HEAVE.items():
            heave = ds[f"shape_{name}"].sel(omega=omega).isel(influenced_dof=0, radiating_dof=0)
            change = 100 * (heave / heave.sel(shape="mean") - 1)
            label = f"{words}, {omega:.3g} rad/s"
            ax.plot(x, change.sel(solver="spectral"), marker, color=colour, markersize=6, fillstyle="none", label=label)
            ax.plot(x, change.sel(solver="panels"), ".", color="black", markersize=3)
    ax.axhline(0, color="black", linewidth=0.7)
    ax.set(ylabel="change of heave's\ncoefficients [%]")
    ax.plot([], [], ".", color="black", markersize=3, label="panels")
    _name_shapes(ax, names)
    ax.legend(fontsize=7, ncols=4, loc="lower center", bbox_to_anchor=(0.45, 1.0), columnspacing=0.8, handletextpad=0.2)


def _name_shapes(ax: Axes, names: list[str]) -> None:
    """Names of shapes under the axis: minus and plus as signs."""
    signs = [name.replace("_minus", " \N{MINUS SIGN}").replace("_plus", " +") for name in names]
    ax.set_xticks(range(len(names)), signs, rotation=90 if len(names) > 5 else 0, fontsize=8)
    ax.set_xlim(-0.6, len(names) - 0.4)
    ax.grid(axis="x", visible=False)
