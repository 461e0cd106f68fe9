"""Drawing surface of all figures: what they are drawn from, the style of a design, axes, legends, time series.

The same design always has the same colour and line style.
"""

import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from vsb.report.band import lowest
from vsb.tools.arrays import FloatArray
from vsb.tools.variables import FORCE, PortKind
from vsb.tools.words import plain

WIDTH = 6.3
"""Width of a figure [inch]: a page of text."""
PERIODS = 15
"""Most periods of a sea shown in time series."""
LIGHT = 0.6
"""Share of the largest value from which on the colours viridis are light."""
FEW_DIGITS = 99.5
"""From where on a number has three digits before the point."""
PORT = "take-off port"
"""Label of the port among the motions of `StudyData.raos`."""
RIGID_STYLE = ("#000000", "-")
"""Colour and line style of the rigid design gains are measured against."""
# Okabe & Ito's colour-blind-safe palette. Its orange marks the waves and is replaced by wine red.
STYLES = (
    ("#D55E00", "-"), ("#0072B2", "--"), ("#009E73", "-."),
    ("#CC79A7", "-"), ("#882255", "--"), ("#56B4E9", "-."), ("#999999", ":"),
)  # fmt: skip
"""Colours and line styles of the other designs, in the order of the study."""


@dataclass(frozen=True)
class StudyData:
    """What the figures of a study are drawn from."""

    designs: tuple[str, ...]
    reference: str | None  # the rigid design gains are measured against
    wave_frequencies: tuple[float, ...]  # of the study's seas [rad/s]
    periods: dict[str, float]  # wave label -> period [s]
    window: tuple[float, float]  # [s]
    modes: xr.Dataset
    database: xr.Dataset  # this and the next two are empty without BEM
    radiation: xr.Dataset
    response: xr.Dataset
    runs: Mapping[tuple[str, str], xr.Dataset]  # (design, wave label) -> trajectory
    witness: xr.Dataset  # empty without a second solver
    tuned: bool = False  # no damper is given
    limit: str = "limit λ/2π"  # name of the limit of a body of revolution; empty for any other body
    spectra: xr.DataArray = field(default_factory=xr.DataArray)  # of irregular seas (sea, omega) [m^2 s/rad]
    port: PortKind = FORCE
    ports: Mapping[str, PortKind] = field(default_factory=dict)  # of several by name
    # of irregular seas by label, see `vsb.results.forecast.worth_of_knowledge`
    knowledge: Mapping[str, xr.Dataset] = field(default_factory=dict)
    raos: xr.DataArray = field(default_factory=xr.DataArray)  # (wave_direction, design, omega, dof), `PORT` among dof

    def style(self, design: str) -> dict[str, Any]:
        """Colour, line style and label of a design."""
        return style(design, self.designs, self.reference)


def style(design: str, designs: Sequence[str], reference: str | None = None) -> dict[str, Any]:
    """Return colour, line style and label of a design: by its role, then by its place among the designs.

    Parameters
    ----------
    designs : sequence of str
        All designs of the study.
    reference : str, optional
        The rigid design gains are measured against.
    """
    if design == reference:
        colour, line = RIGID_STYLE
    else:  # after each round of colours the line styles move on by one
        turn, index = divmod([name for name in designs if name != reference].index(design), len(STYLES))
        colour, line = STYLES[index][0], STYLES[(index + turn) % len(STYLES)][1]
    return {"color": colour, "linestyle": line, "label": design}


def grid_of_axes(height: float, rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, np.ndarray]:
    """A figure of page width with a grid of axes, always a 2-D array of them; no matplotlibrc of a user changes it."""
    mpl.rcdefaults()
    mpl.rcParams.update({
        "font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.3, "svg.hashsalt": "vsb",
        "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "font.family": "DejaVu Sans",
    })  # fmt: skip
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def legend_above(figure: Figure, *axes: Axes) -> None:
    """One legend of the curves of some axes, each name once, above all axes, where it covers no data."""
    entries = [zip(*ax.get_legend_handles_labels(), strict=True) for ax in axes]
    named = {label: handle for own in entries for handle, label in own}
    handles, labels = list(named.values()), list(named)
    columns = min(len(labels), max(1, int(80 / (6 + max(map(len, labels))))))
    figure.legend(handles, labels, loc="outside upper center", ncols=columns, fontsize=8)
    figure.set_figheight(figure.get_figheight() + 0.17 * (math.ceil(len(labels) / columns) - 1))


def period_axis(ax: Any, ticks: Sequence[float] = (1.5, 2, 2.5, 3, 4, 6, 10)) -> None:
    """Put an axis of wave periods [s] above one of frequencies."""
    period = ax.secondary_xaxis("top", functions=(_period, _period))
    period.set_xlabel("wave period [s]")
    period.set_xticks(ticks, [f"{tick:g}" for tick in ticks])


def _period(omega: FloatArray) -> FloatArray:
    """2 pi over the argument: period of a frequency, frequency of a period."""
    return 2 * np.pi / np.maximum(omega, 1e-6)


def shown_band(data: StudyData) -> tuple[float, float]:
    """Frequencies shown: from the `lowest` on to where no design absorbs 1 % of its largest power, and all waves."""
    power = data.response.absorbed_power.max(dim="design")
    absorbs = power.omega.where(power > 0.01 * power.max(), drop=True) if float(power.max()) > 0 else power.omega
    last = float(absorbs.max())
    ends = np.array([lowest(float(power.omega[0]), last), last, *data.wave_frequencies])
    return float(ends.min()), float(ends.max())


def note(ax: Axes, text: str) -> None:
    """Write on empty axes why they are empty, without ticks."""
    ax.text(0.5, 0.5, text, transform=ax.transAxes, ha="center")
    ax.set_yticks([])
    ax.grid(visible=False)


def zero_axis(ax: Axes) -> None:
    """Keep only the tick at zero where all data are zero."""
    if not any(np.any(np.asarray(line.get_ydata(), dtype=float)) for line in ax.get_lines()):
        ax.set_yticks([0.0])


def plain_numbers(axis: Axis) -> None:
    """Number a logarithmic axis of few decades as 5, 10, 20, without powers of ten."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: plain(value)))
    axis.set_minor_formatter(NullFormatter())


def bin_edges(centres: np.ndarray, width: float) -> np.ndarray:
    """Return the edges of bins of some width, of one, too."""
    return np.append(centres - width / 2, centres[-1] + width / 2)


def number_cells(ax: Axes, x: FloatArray, y: FloatArray, values: FloatArray, largest: float) -> None:
    """Write the values (y, x) of a map in the colours viridis into its cells, to two digits; none where unknown."""
    for (i, j), value in np.ndenumerate(values):
        if np.isfinite(value):
            colour = "black" if value > LIGHT * largest else "white"
            text = f"{value:.0f}" if abs(value) >= FEW_DIGITS else plain(float(value), 2)
            ax.text(float(x[j]), float(y[i]), text, ha="center", va="center", fontsize=6.0, color=colour)


def folded(name: str, width: int = 16) -> str:
    """A long name on several lines."""
    return "\n".join(textwrap.wrap(name, width))


def panels(
    data: StudyData, wave: str, quantities: Sequence[tuple[str, Callable[[xr.Dataset], xr.DataArray]]]
) -> Figure:
    """Draw time series of all designs in the window, one panel per quantity."""
    figure, axes = grid_of_axes(1.0 + 1.9 * len(quantities), len(quantities), 1, sharex=True)
    window = shown_window(data, wave)
    for ax, (label, quantity) in zip(axes[:, 0], quantities, strict=True):
        for design in data.designs:
            run = data.runs[design, wave].sel(time=slice(*window))
            ax.plot(run.time, quantity(run), **data.style(design))
        ax.set_ylabel(label)
        zero_axis(ax)
    axes[-1, 0].set(xlabel="time [s]", xlim=window)
    legend_above(figure, axes[0, 0])
    return figure


def shown_window(data: StudyData, wave: str) -> tuple[float, float]:
    """The window of the study, at most its last `PERIODS`; in still water the whole run."""
    time, (start, end) = data.runs[data.designs[0], wave].time, data.window
    if wave == "still":
        return float(time[0]), float(time[-1])
    return max(start, end - PERIODS * data.periods[wave]), end


def heave_force(run: xr.Dataset, name: str) -> xr.DataArray:
    """Heave component of a force [kN]; zero where the scene has no such force."""
    parts = (name, "froude_krylov", "diffraction") if name == "excitation" else (name,)
    return sum((run[part].isel(dof=0) / 1e3 for part in parts if part in run), 0.0 * run.velocity.isel(dof=0))
