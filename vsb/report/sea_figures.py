"""Figures of seas: spectra of a study's irregular seas, and of a site's year. Spectra in, Figure out."""

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vsb.report.canvas import StudyData, grid_of_axes, legend_above, period_axis
from vsb.tools.arrays import FloatArray
from vsb.waves.climate import Climate

LEAST = 0.01
"""Part of the peak of a spectrum below which nothing is left to be seen."""
BETWEEN = (0.1, 0.9)
"""Shares of the year between which a spectrum lies most of the time."""
MEAN = "#0072B2"
PERIODS = (1, 1.5, 2, 3, 4, 6, 10, 15, 25)
"""Of the axis above [s]."""
LINES = ("-", "--", "-.", ":")


def spectra(data: StudyData) -> Figure:
    """Draw the spectra of a study's irregular seas."""
    figure, axes = grid_of_axes(2.8)
    ax, seas = axes[0, 0], data.spectra
    colours = mpl.colormaps["viridis"].resampled(1 + seas.sizes["sea"])
    for i, (name, density) in enumerate(zip(seas.sea.values, seas.values, strict=True)):
        ax.plot(seas.omega, density, color=colours(i), linestyle=LINES[i % len(LINES)], label=str(name))
    return _with_axes(figure, ax, seas.omega.values, seas.values)


def year_spectra(climate: Climate) -> Figure:
    """Draw the mean spectrum of a year, its median, and between which densities it lies most of the time."""
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
    """A figure with axes for spectra (sea, omega): frequencies between which they lie, a little room on both sides."""
    seen = omega[(densities > LEAST * densities.max(axis=1, keepdims=True)).any(axis=0)]
    room = 0.03 * (seen[-1] - seen[0])
    span = max(0.0, float(seen[0] - room)), float(seen[-1] + room)
    ax.set(xlabel="wave frequency [rad/s]", ylabel="spectral density [m² s/rad]", xlim=span)
    ax.set_ylim(bottom=0)
    period_axis(ax, PERIODS)
    legend_above(figure, ax)
    return figure
