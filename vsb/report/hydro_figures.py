"""Figures of waves and of hydrodynamic coefficients, their cross-check by two solvers, and shape dependence."""

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from vsb.engine.hydro.variables import ROTATIONS, is_rigid, motion_of
from vsb.engine.waves.climate import Climate
from vsb.models.shape_dependence import _CURVES, _EXPANSIONS, NEGLIGIBLE, largest_mode, power_effects, relative_slope
from vsb.report.canvas import StudyData, grid_of_axes, legend_above, period_axis, style
from vsb.tools.arrays import FloatArray

LEAST = 0.01
"""Spectra are shown where they exceed this share of their peak."""
BETWEEN = (0.1, 0.9)
"""Quantiles of the spectra of a year that are drawn."""
MEAN = "#0072B2"
PERIODS = (1, 1.5, 2, 3, 4, 6, 10, 15, 25)
"""Of the axis above [s]."""
LINES = ("-", "--", "-.", ":")
_COEFFICIENTS = {
    "added_mass": ("added mass", "#000000", "o"),
    "radiation_damping": ("radiation damping", "#D55E00", "s"),
    "excitation_force": ("excitation", "#0072B2", "^"),
}
_COLOURS = ("#56B4E9", "#009E73", "#CC79A7")
"""Of the three frequencies."""
_OF_HEAVE = {"added_mass": ("added mass", "o"), "radiation_damping": ("damping", "s")}


def spectra(data: StudyData) -> Figure:
    """Draw the spectra of a study's irregular seas."""
    figure, axes = grid_of_axes(2.8)
    ax, seas = axes[0, 0], data.spectra
    colours = mpl.colormaps["viridis"].resampled(1 + seas.sizes["sea"])
    for i, (name, density) in enumerate(zip(seas.sea.values, seas.values, strict=True)):
        ax.plot(seas.omega, density, color=colours(i), linestyle=LINES[i % len(LINES)], label=str(name))
    return _with_axes(figure, ax, seas.omega.values, seas.values)


def year_spectra(climate: Climate) -> Figure:
    """Draw the mean spectrum of a year, its median, and the range between two quantiles."""
    figure, axes = grid_of_axes(2.8)
    ax, omega = axes[0, 0], climate.omega
    bounds = [climate.quantile(share) for share in BETWEEN]
    ax.fill_between(omega, *bounds, color=MEAN, alpha=0.15, linewidth=0)
    for share, bound, line in zip(BETWEEN, bounds, (":", "-"), strict=True):
        ax.plot(omega, bound, color=MEAN, linestyle=line, linewidth=0.8, label=f"{100 * share:.0f} % of the year below")
    ax.plot(omega, climate.quantile(0.5), color="black", linestyle="--", label="median")
    ax.plot(omega, climate.mean_density, color=MEAN, label="mean of the year")
    return _with_axes(figure, ax, omega, climate.mean_density[None])


def _with_axes(figure: Figure, ax: Axes, omega: FloatArray, densities: FloatArray) -> Figure:
    """A figure with axes for spectra (sea, omega), limited to frequencies where they are not negligible."""
    seen = omega[(densities > LEAST * densities.max(axis=1, keepdims=True)).any(axis=0)]
    room = 0.03 * (seen[-1] - seen[0])
    span = max(0.0, float(seen[0] - room)), float(seen[-1] + room)
    ax.set(xlabel="wave frequency [rad/s]", ylabel="spectral density [m² s/rad]", xlim=span)
    ax.set_ylim(bottom=0)
    period_axis(ax, PERIODS)
    legend_above(figure, ax)
    return figure


MOST_NAMED = 24
"""Degrees of freedom the legend of added mass names."""


def added_mass_damping(data: StudyData) -> Figure:
    """Draw the diagonal of added mass and radiation damping; dashed: added mass at infinite frequency."""
    database = data.database
    figure, axes = grid_of_axes(4.6, 2, 1, sharex=True)
    top, bottom = axes[:, 0]
    labels = database.influenced_dof.values
    colours = mpl.colormaps["viridis"].resampled(max(2, len(labels)))
    for i, label in enumerate(labels):
        own = {"influenced_dof": label, "radiating_dof": label}
        if not database.added_mass.sel(own).any():  # pitch about a sphere's centre moves no water
            continue
        line = {"color": "black" if i == 0 else colours(i - 1), "label": label if i < MOST_NAMED else f"_{label}"}
        if motion_of(str(label)) == "Heave":  # above a mode that moves the same water, which is seen between its dots
            line |= {"linestyle": (0, (1, 1.5)), "linewidth": 2.2, "zorder": 3}
        top.plot(database.omega, database.added_mass.sel(own), **line)
        top.axhline(float(database.added_mass_inf.sel(own)), color=line["color"], linewidth=0.7, linestyle="--")
        bottom.plot(database.omega, database.radiation_damping.sel(own).clip(min=1e-3), **line)
    turns = any(_turns(str(label)) for label in labels)  # a rotation beside displacements
    top.set(ylabel="added mass\n[kg, rotations kg m²]" if turns else "added mass [kg]", yscale="log")
    largest = float(database.radiation_damping.max())
    unit = "\n[N s/m, rotations N m s]" if turns else " [N s/m]"
    bottom.set(ylabel=f"radiation damping{unit}", yscale="log", ylim=(1e-5 * largest, 2 * largest))
    bottom.set(xlabel="frequency [rad/s]", xlim=(0, float(database.omega[-1])))
    legend_above(figure, top)
    return figure


def radiation_kernel(data: StudyData) -> Figure:
    """Draw the retardation kernel from the damping and from the state space, of three motions: displacements first."""
    kernel = data.radiation
    labels = sorted(map(str, kernel.radiating_dof.values), key=lambda label: (_turns(label), not is_rigid(label)))
    labels = [label for label in labels if not _turns(label)][:3] or labels[:3]
    figure, axes = grid_of_axes(1.3 + 1.3 * len(labels), len(labels), 1, sharex=True)
    for ax, label in zip(axes[:, 0], labels, strict=True):
        own = kernel.sel(radiating_dof=label)
        ax.plot(kernel.time, own.kernel / 1e3, color="black", label="convolution kernel")
        ax.plot(kernel.time, own.kernel_state_space / 1e3, color="#D55E00", linestyle="--", label="state space")
        ax.set_ylabel(f"{label}\n[10³ kg{' m²' * _turns(label)}/s²]")
    axes[-1, 0].set(xlabel="time [s]", xlim=(0, min(12.0, float(kernel.time[-1]))))
    legend_above(figure, axes[0, 0])
    return figure


def _turns(label: str) -> bool:
    """Whether a degree of freedom is a rotation, of whichever body."""
    return motion_of(label) in ROTATIONS


def witness(data: StudyData) -> Figure:
    """Draw differences of two solvers with their estimated errors, heave's coefficients by shape, and derivatives."""
    ds = data.witness
    derived = "slope_difference" in ds
    figure, axes = grid_of_axes(8.2 if derived else 5.2, 2 + derived, 1)
    _draw_differences(axes[0, 0], ds.witness_difference, ds.witness_estimate.sum("solver"), "shape")
    axes[0, 0].set(ylabel="difference of two solvers [-]")
    axes[0, 0].sharex(axes[1, 0])
    axes[0, 0].tick_params(labelbottom=False)
    _draw_heave(axes[1, 0], ds)
    if derived:
        _draw_differences(axes[2, 0], ds.slope_difference, ds.slope_estimate, "shape_dof")
        axes[2, 0].set(ylabel="difference in derivatives [-]", xlabel="mode by which the shape changes")
    return figure


def _draw_differences(ax: Axes, apart: xr.DataArray, expected: xr.DataArray, dim: str) -> None:
    """Largest difference at any frequency of each coefficient, and the sum of its estimated errors."""
    names = [str(name) for name in apart[dim].values]
    place = np.arange(len(names))
    for i, (coefficient, (label, colour, marker)) in enumerate(_COEFFICIENTS.items()):
        x, allowed = place + 0.24 * (i - 1), expected.sel(coefficient=coefficient)
        name = "sum of their estimated errors" if i == 0 else f"_estimated errors of {label}"
        ax.plot(x, allowed, "_", color="#999999", markersize=6, markeredgewidth=2, label=name)
        found = apart.sel(coefficient=coefficient).max("omega")
        ax.plot(x, found, marker, color=colour, markersize=4, linestyle="none", label=label)
    least, most = float(apart.max("omega").min()), float(max(apart.max(), expected.max()))
    ax.set(yscale="log", ylim=(10 ** np.floor(np.log10(least / 2)), 10 ** np.ceil(np.log10(1.2 * most))))
    _name_shapes(ax, names)
    ax.legend(fontsize=8, ncols=4, loc="lower center", bbox_to_anchor=(0.47, 1.0), columnspacing=1.0, handletextpad=0.3)


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


def shape_figure(ds: xr.Dataset) -> Figure:
    """Draw relative changes of heave's coefficients per metre, errors of expansions, and changes of mean power."""
    powered = bool(power_effects(ds))
    figure, axes = grid_of_axes(9.0 if powered else 6.0, 2 + powered, 1)
    _draw_slopes(axes[0, 0], ds)
    _draw_errors(axes[1, 0], ds)
    if powered:
        _draw_powers(axes[2, 0], ds)
    legend_above(figure, axes[0, 0])
    return figure


def _draw_slopes(ax: Axes, ds: xr.Dataset) -> None:
    """Relative changes of heave's coefficients by heave and by the largest mode, linear near zero."""
    shown = [str(ds.shape_dof.values[0]), largest_mode(ds)]
    for shape_dof, line in zip(shown, ("-", "--"), strict=True):
        for name, (symbol, colour) in _CURVES.items() if shape_dof else ():
            change = relative_slope(ds, name).sel(shape_dof=shape_dof)
            ax.plot(ds.omega, change, color=colour, linestyle=line, label=f"{symbol} by {shape_dof}")
    ax.set_yscale("asinh", linear_width=0.5)
    ax.yaxis.set_major_locator(FixedLocator([-30, -10, -3, -1, 0, 1, 3, 10, 30]))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.set(xlabel="angular frequency [rad/s]", ylabel="relative change [1/m]", xlim=(0, float(ds.omega[-1])))


def _draw_errors(ax: Axes, ds: xr.Dataset) -> None:
    """Errors against the size of the deformation: of the expansions, what is of order 2 and 3, of the database."""
    size, table = ds.deformation.values, ds.interpolation_error
    for kind, (label, colour, marker) in _EXPANSIONS.items():
        ax.loglog(size, table.sel(expansion=kind), color=colour, marker=marker, markersize=4, label=label)
    for order, kind in ((2, "first"), (3, "second")):
        guide = 0.5 * float(table.sel(expansion=kind)[0]) * (size / size[0]) ** order
        ax.loglog(size, guide, color="#999999", linestyle=":", linewidth=1.0)
        ax.annotate(f"size$^{order}$", (size[1], guide[1]), (4, -10), textcoords="offset points", fontsize=8)
    tried = np.linalg.norm(ds.tried_shape.values, axis=1)
    ax.loglog(tried, ds.tried_error.max("coefficient"), ".", color="#0072B2", label="shape database, within its reach")
    ax.set_xticks(size, [f"{x:.3g}" for x in size])
    ax.set_xticks([], minor=True)
    ax.set(xlabel="size of the deformation [m]", ylabel="largest relative error [-]")
    ax.legend(fontsize=8, loc="upper left")


def _draw_powers(ax: Axes, ds: xr.Dataset) -> None:
    """Change of every design's mean power by the shapes of its motion in the first sea, and by the shape at rest."""
    phase, designs = np.arange(ds.sizes["instant"]) / ds.sizes["instant"], [str(d) for d in ds.design.values]
    for design in designs:
        run = ds.isel(wave=0).sel(design=design)
        look, power = style(design, designs, ds.attrs.get("reference")), float(run.power_at_reference)
        ax.plot(phase, 100 * (run.power_at_shape / power - 1), **look)
        if "power_at_rest" in run:
            ax.plot(1.02, 100 * (float(run.power_at_rest) / power - 1), "<", color=look["color"], markersize=5)
    limits = [-100 * NEGLIGIBLE, 100 * NEGLIGIBLE]
    ax.axhspan(*limits, color="#999999", alpha=0.3, linewidth=0)
    ax.set(xlabel=f"instant of the shape, {ds.wave.values[0]} [period or run]; triangles: shape at rest")
    ax.set(ylabel="change of mean power [%]", xlim=(0.0, 1.04))
    ax.legend(fontsize=8, loc="best")
