"""A sketch of each design: the buoy at rest in the water, its take-off, where its shell is held."""

import html
import math
from collections.abc import Callable, Sequence
from typing import Any

from vsb.report.canvas import style
from vsb.study.study import Study

Outline = Callable[[float], tuple[float, float]]
"""Radius and height of a buoy's surface about its centre by colatitude [radii]."""
_WATERLINE, _BED = 62.0, 118.0
_SCALE = 34.0  # of a radius
_POLES = {0.0: "at the top", 90.0: "at the equator", 180.0: "at the keel"}


def design_in_words(design: dict[str, Any]) -> str:
    """Return what a design is, from its canonical form."""
    if not design["flexible"]:
        return "rigid"
    held = [_POLES.get(float(clamp), f"{clamp:g}° from the top") for clamp in design["clamp"]]
    return f"elastic shell, held {' and '.join(held)}" if held else "elastic shell, free"


def sketches(study: Study) -> list[dict[str, str]]:
    """Return a sketch of each design of a study with its name, and what it is in words."""
    designs = study.model_dump()["designs"]
    height, outline = study.centre_height / study.device.radius, _outline(study)
    return [
        {"name": name, "words": design_in_words(one), "svg": sketch(name, designs, height, outline)}
        for name, one in designs.items()
    ]


def _sphere(colatitude: float) -> tuple[float, float]:
    """Outline of the sphere."""
    return math.sin(colatitude), math.cos(colatitude)


def _outline(study: Study) -> Outline:
    """Outline of a study's buoy."""
    if (rest := study.device.meridian) is None:
        return _sphere

    def outline(colatitude: float) -> tuple[float, float]:
        x, z, _, _ = rest.at(colatitude)
        return x / study.device.radius, z / study.device.radius

    return outline


def sketch(name: str, designs: dict[str, dict[str, Any]], height: float, outline: Outline = _sphere) -> str:
    """Return the sketch of a design as SVG of 140 by 120.

    Parameters
    ----------
    designs : mapping name -> dict
        All designs of the study in canonical form.
    height : float
        Of the buoy's centre above still water, in radii [-].
    outline : callable
        Of the buoy.
    """
    reference = next((one for one, values in designs.items() if not values["flexible"]), None)
    design, colour = designs[name], style(name, list(designs), reference)["color"]
    scale = _SCALE / max(1.0, outline(0.0)[1], -outline(math.pi)[1])
    centre = _WATERLINE - scale * height
    keel = centre - scale * outline(math.pi)[1]
    body = f'{_surface(outline, centre, scale)} fill="{colour}" stroke="{colour}"'
    parts = [
        f'<rect x="0" y="{_WATERLINE:g}" width="140" height="{_BED - _WATERLINE:g}" class="water"/>',
        f'<{body} fill-opacity="0.12" stroke-width="{2 if design["flexible"] else 5}"/>',
        *([_swollen(outline, centre, scale, colour, design["clamp"])] if design["flexible"] else []),
        f'<path d="M70 {keel:.1f}V{_BED:g}M63 {_BED - 7:g}h14M63 {_BED - 12:g}v5m14 0v-5" class="takeoff"/>',
        *(_clamp(outline, centre, scale, clamp) for clamp in design["clamp"]),
    ]
    words = html.escape(f"{name}, {design_in_words(design)}")
    return f'<svg viewBox="0 0 140 120" role="img" aria-label="{words}">{"".join(parts)}</svg>'


def _surface(outline: Outline, centre: float, scale: float) -> str:
    """The buoy as an element of SVG, open for its attributes: a circle if it is a sphere."""
    if outline is _sphere:
        return f'circle cx="70" cy="{centre:.1f}" r="{scale:g}"'
    half = [outline(math.pi * i / 48) for i in range(49)]
    around = [*half, *((-x, z) for x, z in reversed(half))]
    return f'path d="M{"L".join(f"{70 + scale * x:.1f} {centre - scale * z:.1f}" for x, z in around)}Z"'


def _swollen(outline: Outline, centre: float, scale: float, colour: str, clamps: Sequence[float]) -> str:
    """The shell swollen and squeezed, dotted, still where it is held."""
    angles = [math.pi * i / 24 for i in range(49)]
    paths = []
    for sign in (1, -1):
        points = []
        for angle in angles:
            free = math.prod(
                abs(math.sin((abs(math.remainder(angle, 2 * math.pi)) - math.radians(c)) / 2)) * 1.4 for c in clamps
            )
            size = scale * (1 + 0.13 * sign * min(1.0, free))
            x, z = outline(angle)
            points.append(f"{70 + size * x:.1f} {centre - size * z:.1f}")
        paths.append("M" + "L".join(points))
    return f'<path d="{"".join(paths)}" fill="none" stroke="{colour}" stroke-width="0.9" stroke-dasharray="1.5 2.5"/>'


def _clamp(outline: Outline, centre: float, scale: float, colatitude: float) -> str:
    """Marks on either side where a shell is held."""
    x, z = outline(math.radians(colatitude))
    x, y = scale * x, centre - scale * z
    return "".join(f'<circle cx="{70 + side * x:.1f}" cy="{y:.1f}" r="3.5" class="clamp"/>' for side in (-1, 1))
