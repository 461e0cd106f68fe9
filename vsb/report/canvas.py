"""Drawing surface of all figures: what they are drawn from, the style of a design, axes, legends, time series; files.

The same design always has the same colour and line style. A drawn figure is written as SVG with real text, the data
behind it as CSV, and what it shows in words; for print as PDF. The SVG says where its axes lie and what each curve is
called, so that a page can read values off the drawn curves.
"""

import html
import io
import math
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_mixed import MixedModeRenderer
from matplotlib.backends.backend_svg import FigureCanvasSVG, RendererSVG
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from matplotlib.ticker import FuncFormatter, LogFormatterSciNotation, LogLocator, NullFormatter

from vsb.report.answer import lowest
from vsb.study.figure_names import FIGURE_KINDS
from vsb.tools.arrays import FloatArray
from vsb.tools.files import atomic_write
from vsb.tools.variables import FORCE, PortKind
from vsb.tools.words import csv_text, plain

PAD = 0.5
"""Room around axes with their labels, in heights of letters."""
FEW_DECADES = 100.0
"""Ratio of the ends of a logarithmic axis up to which it has more numbers than powers of ten."""
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
    # of irregular seas by label, see `vsb.results.gains.worth_of_knowledge`
    knowledge: Mapping[str, xr.Dataset] = field(default_factory=dict)
    raos: xr.DataArray = field(default_factory=xr.DataArray)  # (wave_direction, design, omega, dof), `PORT` among dof

    def style(self, design: str) -> dict[str, Any]:
        """Colour, line style and label of a design."""
        return style(design, self.designs, self.reference)

    @cached_property
    def band(self) -> tuple[float, float]:
        """Frequencies shown: from the `lowest` to where no design absorbs 1 % of its largest power, and all waves."""
        power = self.response.absorbed_power.max(dim="design")
        absorbs = power.omega.where(power > 0.01 * power.max(), drop=True) if float(power.max()) > 0 else power.omega
        last = float(absorbs.max())
        ends = np.array([lowest(float(power.omega[0]), last), last, *self.wave_frequencies])
        return float(ends.min()), float(ends.max())


def style(design: str, designs: Sequence[str], reference: str | None = None) -> dict[str, Any]:
    """Return colour, line style and label of a design: by its role, then by its place among all of the study."""
    if design == reference:
        colour, line = RIGID_STYLE
    else:  # after each round of colours the line styles move on by one
        turn, index = divmod([name for name in designs if name != reference].index(design), len(STYLES))
        colour, line = STYLES[index][0], STYLES[(index + turn) % len(STYLES)][1]
    return {"color": colour, "linestyle": line, "label": design}


def grid_of_axes(
    height: float, rows: int = 1, columns: int = 1, layout: Literal["constrained"] | None = None, **options: Any
) -> tuple[Figure, np.ndarray]:
    """A figure of page width with a grid of axes, always a 2-D array of them; no matplotlibrc of a user changes it.

    Its `layout` is that of `lay_out`, which leaves no room for bars of colours: those need a constrained one.
    """
    figure = _page(height, layout)
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def sheet(height: float) -> tuple[Figure, Axes]:
    """A figure of page width, drawn on in inches: for many small shapes, each of which would need its own axes."""
    figure = _page(height)
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, WIDTH), ylim=(0.0, height), frame_on=False)
    ax.set_axis_off()
    return figure, ax


def _page(height: float, layout: Literal["constrained"] | None = None) -> Figure:
    """An empty figure with our looks."""
    mpl.rcdefaults()
    mpl.rcParams.update({
        "font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.3, "svg.hashsalt": "vsb",
        "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "font.family": "DejaVu Sans",
    })  # fmt: skip
    return Figure(figsize=(WIDTH, height), layout=layout)


def legend_above(figure: Figure, *axes: Axes) -> None:
    """One legend of the curves of some axes, each name once, above all axes, where it covers no data."""
    entries = [zip(*ax.get_legend_handles_labels(), strict=True) for ax in axes]
    named = {label: handle for own in entries for handle, label in own}
    handles, labels = list(named.values()), list(named)
    columns = min(len(labels), max(1, int(80 / (6 + max(map(len, labels))))))
    figure.legend(handles, labels, loc="upper center", ncols=columns, fontsize=8, borderaxespad=PAD)
    figure.set_figheight(figure.get_figheight() + 0.17 * (math.ceil(len(labels) / columns) - 1))


def title_above(figure: Figure, title: str) -> None:
    """Write a title at the top of a figure."""
    size = mpl.rcParams["font.size"]
    figure.suptitle(title, fontsize=size, y=1 - PAD * size / 72 / figure.get_figheight())


def period_axis(ax: Any, ticks: Sequence[float] = (1.5, 2, 2.5, 3, 4, 6, 10)) -> None:
    """Put an axis of wave periods [s] above one of frequencies."""
    period = ax.secondary_xaxis("top", functions=(_period, _period))
    period.set_xlabel("wave period [s]")
    period.set_xticks(ticks, [f"{tick:g}" for tick in ticks])


def _period(omega: FloatArray) -> FloatArray:
    """2 pi over the argument: period of a frequency, frequency of a period."""
    return 2 * np.pi / np.maximum(omega, 1e-6)


def note(ax: Axes, text: str) -> None:
    """Write on empty axes why they are empty, without ticks."""
    ax.text(0.5, 0.5, text, transform=ax.transAxes, ha="center")
    ax.set_yticks([])
    ax.grid(visible=False)


def zero_axis(ax: Axes) -> None:
    """Keep only the tick at zero where all data are zero."""
    if not any(np.any(np.asarray(line.get_ydata(), dtype=float)) for line in ax.get_lines()):
        ax.set_yticks([0.0])


def number_decades(axis: Axis) -> None:
    """Number a logarithmic axis by powers of ten, written as letters; one of few decades as 5, 10, 20."""
    low, high = sorted(axis.get_view_interval())
    few = high < FEW_DECADES * low
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,)))
    axis.set_minor_locator(LogLocator(subs=range(2, 10) if few else (2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: plain(value) if few else _power_of_ten(value)))
    axis.set_minor_formatter(NullFormatter())


def _power_of_ten(value: float) -> str:
    """A power of ten with its exponent raised."""
    return "10" + str(round(math.log10(value))).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


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


FONTS = "DejaVu Sans, Verdana, sans-serif"
_AUTHOR: dict[str, dict[str, str | None]] = {
    "pdf": {"Creator": "vsb", "CreationDate": None},
    "png": {"Software": "vsb"},
}
"""Metadata of figures for print, by which they are known as ours."""
MOST_CURVES = 8
"""Curves of one pair of axes that are described in words."""
MOST_POINTS = 1000
"""Points of one curve in the CSV file; more than a figure shows."""


@dataclass(frozen=True)
class Drawn:
    """The files of one figure, by kind."""

    svg: str
    csv: str

    def write(self, folder: str, name: str) -> list[str]:
        """Write the files into a folder and return their paths."""
        paths = [f"{folder}/{name}.{kind}" for kind in FIGURE_KINDS]
        for path, content in zip(paths, (self.svg.encode(), self.csv.encode()), strict=True):
            with atomic_write(path) as temporary:
                temporary.write_bytes(content)
        return paths


def drawn(figure: Figure, name: str) -> Drawn:
    """Return the files of a figure; its name makes the identifiers of its SVG unique on a page with several figures."""
    looks: Any = {"svg.fonttype": "none", "path.simplify_threshold": 0.25, "svg.hashsalt": name}
    with mpl.rc_context(looks):  # real text; curves without points nobody can tell apart
        for i, ax in enumerate(figure.axes):
            ax.set_gid(f"axes-{i}")
            for j, line in enumerate(_curves(ax)):
                line.set_gid(f"curve-{i}-{j}")
        text = svg_text(figure)
    return Drawn(_for_page(text, figure, name), data_csv(figure))


def lay_out(figure: Figure) -> None:
    """Give axes what their labels and legends of the figure leave, and logarithmic ones numbers, before it is drawn.

    Labels are measured once, where a constrained layout of matplotlib's does so twice.
    """
    for ax in (ax for one in figure.axes for ax in (one, *one.child_axes)):
        ax.spines[:].set_in_layout(False)  # within what is measured
        for axis in (ax.xaxis, ax.yaxis):
            if isinstance(axis.get_major_formatter(), LogFormatterSciNotation):
                number_decades(axis)
            if not axis.get_label_text():
                axis.set_label_coords(0.0, 0.0)  # else tick labels are measured to place it
    if figure.get_layout_engine() or not any(ax.get_subplotspec() for ax in figure.axes):
        return
    height, above = figure.get_figheight(), sum(one.get_window_extent().height for one in figure.legends) / figure.dpi
    figure.set_figheight(height - above)
    figure.tight_layout(pad=PAD)
    figure.set_figheight(height)
    share = 1 - above / height
    figure.subplots_adjust(top=share * figure.subplotpars.top, bottom=share * figure.subplotpars.bottom)


@lru_cache(4096)
def _text_size(text: str, font: FontProperties, is_math: Any) -> tuple[float, float, float]:
    """Width, height and descent of a text [pt]: figures have many in common, and to measure one takes long."""
    return text_to_path.get_text_width_height_descent(text, font, is_math)


class _Renderer(RendererSVG):
    """Writes SVG."""

    def get_text_width_height_descent(self, s: str, prop: FontProperties, ismath: Any) -> tuple[float, float, float]:
        """Measure a text [pt]."""
        return _text_size(s, prop, ismath)


def svg_text(figure: Figure) -> str:
    """Return a figure as SVG without a date; drawn once, where `savefig` draws all of it twice to lay it out."""
    text, dpi, canvas = io.StringIO(), figure.dpi, figure.canvas
    figure.set_dpi(72)
    width, height = figure.get_size_inches()
    about: Any = {"Date": None, "Creator": "vsb"}
    writer = _Renderer(72 * width, 72 * height, text, image_dpi=dpi, metadata=about)  # type: ignore[no-untyped-call]
    renderer: Any = MixedModeRenderer(figure, width, height, dpi, writer)  # type: ignore[no-untyped-call]
    measured: Any = FigureCanvasSVG(figure)
    measured.get_renderer = lambda: renderer  # for the layout
    lay_out(figure)
    figure.draw(renderer)
    renderer.finalize()
    figure.set_canvas(canvas)
    figure.set_dpi(dpi)
    return text.getvalue()


def for_print(figure: Figure, kind: str) -> bytes:
    """Return a figure as a file of another kind that matplotlib writes: pdf with real text, png at 300 dots an inch."""
    lay_out(figure)
    looks: Any = {"pdf.fonttype": 42, "path.simplify_threshold": 0.25}
    with mpl.rc_context(looks), io.BytesIO() as sheet:
        figure.savefig(sheet, format=kind, dpi=300, metadata=_AUTHOR[kind])
        return sheet.getvalue()


def _for_page(text: str, figure: Figure, name: str) -> str:
    """The SVG with axes and curves marked, described in words, and without what a page does not need."""
    text = re.sub(r"<metadata>.*?</metadata>|<defs>\s*<style.*?</style>\s*</defs>", "", text, flags=re.DOTALL)
    text = re.sub(r'="[^"]*\.[^"]*"', _round_numbers, text)
    text = re.sub(r">\s+<", "><", text).replace(" \n", "").replace("font-family: 'DejaVu Sans'; ", "")
    for identity, marks in _marks(figure):
        text = text.replace(f'<g id="{identity}">', f"<g {marks}>", 1)
    used = set(re.findall(r"#([\w.-]+)", text))
    text = re.sub(r' id="([^"]+)"', lambda found: found[0] if found[1] in used else "", text)
    width, height = (72 * size for size in figure.get_size_inches())
    words = html.escape(in_words(figure) or f"{name.replace('_', ' ')}: nothing to show")
    root = (
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        f'width="{width:.4g}pt" height="{height:.4g}pt" viewBox="0 0 {width:.4g} {height:.4g}" '
        f'font-family="{FONTS}" stroke-linejoin="round" stroke-linecap="butt" role="img" aria-label="{words}">'
    )
    return root + text[text.index(">", text.index("<svg")) + 1 :]


def _round_numbers(attribute: re.Match[str]) -> str:
    """An attribute with its numbers rounded to hundredths of a point."""
    return re.sub(r"-?\d*\.\d{3,}(?:e-?\d+)?", lambda number: f"{float(number[0]):.2f}", attribute[0])


def _marks(figure: Figure) -> Iterator[tuple[str, str]]:
    """Identifiers of axes and curves, and attributes that say where axes lie on the page and in data, and names."""
    width, height = (72 * size for size in figure.get_size_inches())
    for i, ax in enumerate(figure.axes):
        if {ax.get_xscale(), ax.get_yscale()} - {"linear", "log"} or not _curves(ax):
            continue
        box = ax.get_position()
        x = [box.x0 * width, box.x1 * width, *ax.get_xlim()]
        y = [(1 - box.y0) * height, (1 - box.y1) * height, *ax.get_ylim()]
        marks = {
            "x": " ".join([*(f"{end:.7g}" for end in x), ax.get_xscale()]), "x-label": _x_label(figure, ax),
            "y": " ".join([*(f"{end:.7g}" for end in y), ax.get_yscale()]), "y-label": ax.get_ylabel(),
        }  # fmt: skip
        yield f"axes-{i}", " ".join(f'data-{key}="{html.escape(_one_line(text))}"' for key, text in marks.items())
        for j, line in enumerate(_curves(ax)):
            yield f"curve-{i}-{j}", f'data-curve="{html.escape(str(line.get_label()))}"'


def in_words(figure: Figure) -> str:
    """Return what a figure shows, with numbers: the range of every named curve."""
    parts = []
    for ax in figure.axes:
        ranges = [text for line in _curves(ax)[:MOST_CURVES] if (text := _range(ax, line))]
        bars = [_bars(ax, one) for one in ax.containers[:MOST_CURVES] if not str(one.get_label()).startswith("_")]
        if bars:
            parts.append(f"{_one_line(ax.get_xlabel() or ax.get_ylabel())}: {'; '.join(bars)}")
        elif ranges:
            what = _one_line(ax.get_ylabel() or ax.get_title())
            parts.append(f"{what} over {_one_line(_x_label(figure, ax))}: {', '.join(ranges)}")
        elif ax.get_title() or not ax.axison:
            parts.append(_one_line(ax.get_title()) or "; ".join(_one_line(text.get_text()) for text in ax.texts))
    title = figure.get_suptitle()
    return ". ".join([*([_one_line(title)] if title else []), *parts])


def data_csv(figure: Figure) -> str:
    """Return the points of all curves, bars and maps of a figure, as far as it shows them, a row each.

    A bin of a map that is not coloured has no value. A curve whose label is _ is none of the data.
    """
    text = [csv_text(["axes", "series", "x", "y", "value"], [])]
    for i, ax in enumerate(figure.axes):
        where = _one_line(ax.get_title() or ax.get_ylabel()) or f"axes {i + 1}"
        for series, points in _points(ax):
            thinned = points[:: max(1, -(-len(points) // MOST_POINTS))] if series != "map" else points
            named, numbers = csv_text([where, series], []).rstrip("\n"), ",%.6g" * points.shape[-1] + "\n"
            text += [named + (numbers % tuple(point)).replace("nan", "") for point in thinned.tolist()]
    return "".join(text)


def _points(ax: Axes) -> Iterator[tuple[str, FloatArray]]:
    """Name and points (point, 2 or 3) of all data drawn on axes."""
    for i, line in enumerate(line for line in ax.get_lines() if line.get_label() != "_"):
        label = str(line.get_label())
        points = _shown(ax, line) if ax.axison else line.get_data()
        yield f"line {i + 1}" if label.startswith("_child") else label.removeprefix("_"), np.column_stack(points)
    for bars in ax.containers:
        boxes = [(patch.get_x() + patch.get_width(), patch.get_y() + patch.get_height()) for patch in bars]
        yield str(bars.get_label()), np.array(boxes, dtype=float)
    for mesh in (one for one in ax.collections if isinstance(one, mpl.collections.QuadMesh)):
        corners = np.asarray(mesh.get_coordinates(), dtype=float)
        centres = (corners[1:, 1:] + corners[:-1, :-1]) / 2
        values: FloatArray = np.ma.filled(np.ma.array(mesh.get_array(), dtype=float), np.nan)
        yield "map", np.column_stack([centres.reshape(-1, 2), values.ravel()])


def _curves(ax: Axes) -> list[Any]:
    """Curves of axes that have a name."""
    return [line for line in ax.get_lines() if not str(line.get_label()).startswith("_")]


def _shown(ax: Axes, line: Any) -> tuple[FloatArray, FloatArray]:
    """Finite points of a curve between the ends of the horizontal axis."""
    x, y = (np.asarray(values, dtype=float).ravel() for values in line.get_data())
    low, high = sorted(ax.get_xlim())
    shown = (x >= low) & (x <= high) & np.isfinite(y)
    return x[shown], y[shown]


def _range(ax: Axes, line: Any) -> str:
    """Name of a curve, its smallest and its largest value; empty without points."""
    _, y = _shown(ax, line)
    if y.size < 2:
        return ""
    low, high = plain(float(y.min())), plain(float(y.max()))
    return f"{line.get_label()} {low}" + ("" if low == high else f" to {high}")


def _bars(ax: Axes, bars: Any) -> str:
    """Name of a set of bars, and the length of each with its name on the axis."""
    sizes = [float(value) for value in bars.datavalues]
    ticks = (ax.get_yticklabels() if bars.orientation == "horizontal" else ax.get_xticklabels())[: len(sizes)]
    named = (f"{_one_line(tick.get_text())} {plain(size)}" for tick, size in zip(ticks, sizes, strict=False))
    return f"{bars.get_label()}: {', '.join(named)}"


def _x_label(figure: Figure, ax: Axes) -> str:
    """Label of the horizontal axis, that of axes below where it is shared."""
    below = [other.get_xlabel() for other in figure.axes if other.get_shared_x_axes().joined(ax, other)]
    return ax.get_xlabel() or next((label for label in below if label), "x")


def _one_line(text: str) -> str:
    """A label on one line."""
    return " ".join(text.split())
