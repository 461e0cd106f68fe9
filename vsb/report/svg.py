"""A drawn figure as files: SVG with real text, the data behind it as CSV, and what it shows in words; for print, PDF.

The SVG says where its axes lie and what each curve is called, so that a page can read values off the drawn curves.
"""

import html
import io
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vsb.study.figure_names import FIGURE_KINDS
from vsb.tools.arrays import FloatArray
from vsb.tools.files import atomic_write
from vsb.tools.words import csv_text, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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


def for_print(figure: Figure, kind: str) -> bytes:
    """Return a figure as a file of another kind that matplotlib writes: pdf with real text, png at 300 dots an inch."""
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
        elif ax.get_title():
            parts.append(_one_line(ax.get_title()))
    title = figure.get_suptitle()
    return ". ".join([*([_one_line(title)] if title else []), *parts])


def data_csv(figure: Figure) -> str:
    """Return the points of all curves, bars and maps of a figure, as far as it shows them, a row each.

    A bin of a map that is not coloured has no value.
    """
    rows: list[list[object]] = []
    for i, ax in enumerate(figure.axes):
        where = _one_line(ax.get_title() or ax.get_ylabel()) or f"axes {i + 1}"
        for series, points in _points(ax):
            thinned = points[:: max(1, -(-len(points) // MOST_POINTS))] if series != "map" else points
            rows += [[where, series, *("" if math.isnan(number) else number for number in point)] for point in thinned]
    return csv_text(["axes", "series", "x", "y", "value"], rows, 6)


def _points(ax: Axes) -> Iterator[tuple[str, FloatArray]]:
    """Name and points (point, 2 or 3) of all data drawn on axes."""
    for i, line in enumerate(ax.get_lines()):
        label = str(line.get_label())
        points = _shown(ax, line) if ax.name != "3d" else line.get_data_3d()  # type: ignore[attr-defined]
        yield label if not label.startswith("_") else f"line {i + 1}", np.column_stack(points)
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


def svg_text(figure: "Figure") -> str:
    """Return a figure as SVG without a date; drawn once, where `savefig` draws all of it twice to lay it out."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    text, dpi, canvas = io.StringIO(), figure.dpi, FigureCanvasSVG(figure)
    canvas.print_svg(text, metadata={"Date": None, "Creator": "vsb"})  # type: ignore[no-untyped-call]
    figure.set_dpi(dpi)
    return text.getvalue()
