"""A drawn figure as files: SVG and PDF with real text, the data behind it as CSV, and what it shows in words.

The SVG says where its axes lie and what each curve is called, so that a page can read values off the drawn curves.
"""

import hashlib
import io
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vsb.study.plan import FIGURE_KINDS
from vsb.tools.arrays import FloatArray
from vsb.tools.files import atomic_write
from vsb.tools.tables import csv_text, svg_text
from vsb.tools.words import plain

SVG, XLINK = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xlink}"
LOOKS: Any = {"svg.fonttype": "none", "pdf.fonttype": 42, "path.simplify_threshold": 0.25}
"""Text as text, in print too; curves without points nobody can tell apart."""
FONTS = "DejaVu Sans, Verdana, sans-serif"
SERIES = 8
"""Curves of one pair of axes that are told in words."""
POINTS = 1000
"""Most points of one curve among its data; more than a figure shows."""
_NUMBER = re.compile(r"-?\d*\.\d+(?:e-?\d+)?")
_LETTERS = re.compile(r"[A-Za-z]")
_REFERRED = re.compile(r"#([\w.-]+)")


@dataclass(frozen=True)
class Drawn:
    """The files of one figure, by kind."""

    svg: str
    pdf: bytes
    csv: str

    def write(self, folder: str, name: str) -> list[str]:
        """Write the files into a folder and return their paths."""
        paths = [f"{folder}/{name}.{kind}" for kind in FIGURE_KINDS]
        for path, content in zip(paths, (self.svg.encode(), self.pdf, self.csv.encode()), strict=True):
            with atomic_write(path) as temporary:
                temporary.write_bytes(content)
        return paths


def drawn(figure: Figure, name: str) -> Drawn:
    """Return the files of a figure; its name makes identifiers of the SVG unique on a page of many."""
    with mpl.rc_context(LOOKS):
        for i, ax in enumerate(figure.axes):
            ax.set_gid(f"axes-{i}")
            for j, line in enumerate(_curves(ax)):
                line.set_gid(f"curve-{i}-{j}")
        text, sheet = svg_text(figure), io.BytesIO()
        figure.set_layout_engine(None)  # it is laid out: nor drawn once more to be
        figure.savefig(sheet, format="pdf", metadata={"CreationDate": None})
    return Drawn(_compact(text, figure, name), sheet.getvalue(), data_csv(figure))


def in_words(figure: Figure) -> str:
    """Return what a figure shows, with numbers: the range of every named curve."""
    parts = []
    for ax in figure.axes:
        told = [text for line in _curves(ax)[:SERIES] if (text := _range(ax, line))]
        bars = [_bars(ax, one) for one in ax.containers[:SERIES] if not str(one.get_label()).startswith("_")]
        if bars:
            parts.append(f"{_one_line(ax.get_xlabel() or ax.get_ylabel())}: {'; '.join(bars)}")
        elif told:
            what = _one_line(ax.get_ylabel() or ax.get_title())
            parts.append(f"{what} over {_one_line(_x_label(figure, ax))}: {', '.join(told)}")
        elif ax.get_title():
            parts.append(_one_line(ax.get_title()))
    title = figure.get_suptitle()
    return ". ".join([*([_one_line(title)] if title else []), *parts])


def data_csv(figure: Figure) -> str:
    """Return the points of all curves, bars and maps of a figure, as far as it shows them, a row each."""
    rows: list[list[object]] = []
    for i, ax in enumerate(figure.axes):
        where = _one_line(ax.get_title() or ax.get_ylabel()) or f"axes {i + 1}"
        for series, points in _points(ax):
            thinned = points[:: max(1, -(-len(points) // POINTS))] if series != "map" else points
            rows += [[where, series, *point] for point in thinned]
    return csv_text(["axes", "series", "x", "y", "value"], rows, 6)


def _points(ax: Axes) -> Iterator[tuple[str, FloatArray]]:
    """Name and points (point, 2 or 3) of all that is drawn of data on axes."""
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
    """Points of a curve that exist, between the ends of the horizontal axis."""
    x, y = (np.asarray(values, dtype=float).ravel() for values in line.get_data())
    low, high = sorted(ax.get_xlim())
    shown = (x >= low) & (x <= high) & np.isfinite(y)
    return x[shown], y[shown]


def _range(ax: Axes, line: Any) -> str:
    """Name of a curve, its least and its largest value; nothing for one without points."""
    _, y = _shown(ax, line)
    if y.size < 2:
        return ""
    low, high = plain(float(y.min())), plain(float(y.max()))
    return f"{line.get_label()} {low}" + ("" if low == high else f" to {high}")


def _bars(ax: Axes, bars: Any) -> str:
    """Name of bars, and how long each is, with the name it has on its axis."""
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


def _compact(text: str, figure: Figure, name: str) -> str:
    """The same SVG without what no reader sees, with what a page reads values by."""
    ET.register_namespace("", SVG[1:-1])
    ET.register_namespace("xlink", XLINK[1:-1])
    root = ET.fromstring(text)
    for child in [one for one in root if one.tag == f"{SVG}metadata"]:
        root.remove(child)
    _mark_axes(root, figure)
    kept = {found for element in root.iter() for value in element.attrib.values() for found in _REFERRED.findall(value)}
    styles: dict[str, str] = {}
    for element in root.iter():
        _shorten(element, kept, name)
        _name_style(element, styles)
    _unwrap(root)
    for child in [one for one in root if one.tag == f"{SVG}defs" and one.find(f"{SVG}style") is not None]:
        root.remove(child)
    sheet = ET.Element(f"{SVG}style")
    sheet.text = "".join(f".{identity}{{{style}}}" for style, identity in styles.items())
    root.insert(0, sheet)
    width, height = (72 * size for size in figure.get_size_inches())
    looks = {"font-family": FONTS, "stroke-linejoin": "round", "stroke-linecap": "butt"}
    words = {"role": "img", "aria-label": in_words(figure) or f"{name.replace('_', ' ')}: nothing to show"}
    size = {"width": f"{width:.4g}pt", "height": f"{height:.4g}pt", "viewBox": f"0 0 {width:.4g} {height:.4g}"}
    root.attrib = {**size, **looks, **words}
    return ET.tostring(root, encoding="unicode")


def _mark_axes(root: ET.Element, figure: Figure) -> None:
    """Say of axes where they lie on the page and in data, and of curves their names."""
    groups = {element.get("id"): element for element in root.iter(f"{SVG}g")}
    width, height = (72 * size for size in figure.get_size_inches())
    for i, ax in enumerate(figure.axes):
        group = groups.get(f"axes-{i}")
        if group is None or {ax.get_xscale(), ax.get_yscale()} - {"linear", "log"} or not _curves(ax):
            continue
        box = ax.get_position()
        x = [box.x0 * width, box.x1 * width, *ax.get_xlim()]
        y = [(1 - box.y0) * height, (1 - box.y1) * height, *ax.get_ylim()]
        for key, ends, scale, label in (
            ("x", x, ax.get_xscale(), _x_label(figure, ax)),
            ("y", y, ax.get_yscale(), ax.get_ylabel()),
        ):
            group.set(f"data-{key}", " ".join([*(f"{end:.7g}" for end in ends), scale]))
            group.set(f"data-{key}-label", _one_line(label))
        for j, line in enumerate(_curves(ax)):
            if (curve := groups.get(f"curve-{i}-{j}")) is not None:
                curve.set("data-curve", str(line.get_label()))


def _shorten(element: ET.Element, kept: set[str], name: str) -> None:
    """Take what is not needed from an element: identifiers nothing refers to, blanks, digits beyond a hundredth."""
    identity = element.attrib.pop("id", None)
    if identity in kept:
        element.set("id", f"{name}-{identity}")
    for key, value in element.attrib.items():
        if key == "d":
            element.set(key, _relative(value) if set(_LETTERS.findall(value)) <= set("MLz") else _rounded_all(value))
        elif key in ("points", "transform", "x", "y", "width", "height"):
            element.set(key, _rounded_all(value))
        elif key == "style":
            style = _NUMBER.sub(_rounded, value).replace(": ", ":").replace("; ", ";").replace("url(#", f"url(#{name}-")
            element.set(key, style.replace("font-family:'DejaVu Sans';", "").replace(";font-family:'DejaVu Sans'", ""))
    for key in ("clip-path", f"{XLINK}href"):
        if key in element.attrib:
            element.set(key, element.attrib[key].replace("#", f"#{name}-"))
    for part in ("text", "tail"):
        value = getattr(element, part)
        if value is not None and not value.strip():
            setattr(element, part, None)


def _name_style(element: ET.Element, styles: dict[str, str]) -> None:
    """Put a class in the place of a style, named by what it says: the same in all figures of a page."""
    if style := element.attrib.pop("style", ""):
        element.set("class", styles.setdefault(style, f"v{hashlib.sha256(style.encode()).hexdigest()[:6]}"))
    if element.attrib.get("transform", "").startswith("rotate(-0 "):
        del element.attrib["transform"]


def _relative(path: str) -> str:
    """A path of lines with steps in place of points: half as long; steps lead from where rounded ones have led."""
    words, at, out = path.split(), np.zeros(2, dtype=int), ""
    for i, word in enumerate(words):
        if word == "z":
            out += "z"
        elif word in "ML":
            to = np.rint(100 * np.array(words[i + 1 : i + 3], dtype=float)).astype(int)
            step = to if word == "M" else to - at
            out += f"{'M' if word == 'M' else 'l'}{_hundredths(step[0])} {_hundredths(step[1])}".replace(" -", "-")
            at = to
    return out


def _hundredths(value: int) -> str:
    """Hundredths as a short decimal number."""
    text = f"{value / 100:.2f}".rstrip("0").rstrip(".")
    return text.replace("0.", ".", 1) if abs(value) < 100 else text


def _rounded_all(text: str) -> str:
    """A text with all its numbers rounded."""
    return " ".join(_NUMBER.sub(_rounded, text).split())


def _rounded(number: re.Match[str]) -> str:
    """A number to a hundredth, short."""
    text = f"{float(number.group()):.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _unwrap(element: ET.Element) -> None:
    """Put children of groups that say nothing in the place of those groups."""
    children: list[ET.Element] = []
    for child in list(element):
        _unwrap(child)
        children += list(child) if child.tag == f"{SVG}g" and not child.attrib else [child]
    for child in list(element):
        element.remove(child)
    element.extend(children)
