"""Figure of what the dependence of the coefficients on the shape means for a study."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from vsb.report.canvas import grid_of_axes, legend_above, style
from vsb.scenes.shape_dependence import _CURVES, _EXPANSIONS, NEGLIGIBLE, largest_mode, power_effects, relative_slope


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
        look, power = style(design, designs), float(run.power_at_reference)
        ax.plot(phase, 100 * (run.power_at_shape / power - 1), **look)
        if "power_at_rest" in run:
            ax.plot(1.02, 100 * (float(run.power_at_rest) / power - 1), "<", color=look["color"], markersize=5)
    limits = [-100 * NEGLIGIBLE, 100 * NEGLIGIBLE]
    ax.axhspan(*limits, color="#999999", alpha=0.3, linewidth=0)
    ax.set(xlabel=f"instant of the shape, {ds.wave.values[0]} [period or run]; triangles: shape at rest")
    ax.set(ylabel="change of mean power [%]", xlim=(0.0, 1.04))
    ax.legend(fontsize=8, loc="best")


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
