"""A sketch of each design: the buoy at rest in the water, its take-off, where its shell is held."""

import html
import math
from collections.abc import Sequence
from typing import Any

from vsb.report.canvas import style
from vsb.study.study import Study

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
    height = study.centre_height / study.device.radius
    return [
        {"name": name, "words": design_in_words(one), "svg": sketch(name, designs, height)}
        for name, one in designs.items()
    ]


def sketch(name: str, designs: dict[str, dict[str, Any]], height: float) -> str:
    """Return the sketch of a design as SVG of 140 by 120.

    Parameters
    ----------
    name : str
    designs : mapping name -> dict
        All designs of the study in canonical form.
    height : float
        Of the sphere's centre above still water, in radii [-].
    """
    design, colour = designs[name], style(name, list(designs))["color"]
    centre = _WATERLINE - _SCALE * height
    body = f'cx="70" cy="{centre:.1f}" r="{_SCALE:g}" fill="{colour}" stroke="{colour}"'
    parts = [
        f'<rect x="0" y="{_WATERLINE:g}" width="140" height="{_BED - _WATERLINE:g}" class="water"/>',
        f'<circle {body} fill-opacity="0.12" stroke-width="{2 if design["flexible"] else 5}"/>',
        *([_swollen(centre, colour, design["clamp"])] if design["flexible"] else []),
        f'<path d="M70 {centre + _SCALE:.1f}V{_BED:g}M63 {_BED - 7:g}h14M63 {_BED - 12:g}v5m14 0v-5" class="takeoff"/>',
        *(_clamp(centre, clamp) for clamp in design["clamp"]),
    ]
    words = html.escape(f"{name}, {design_in_words(design)}")
    return f'<svg viewBox="0 0 140 120" role="img" aria-label="{words}">{"".join(parts)}</svg>'


def _swollen(centre: float, colour: str, clamps: Sequence[float]) -> str:
    """The shell swollen and squeezed, dotted, still where it is held."""
    angles = [math.pi * i / 24 for i in range(49)]
    paths = []
    for sign in (1, -1):
        points = []
        for angle in angles:
            free = math.prod(
                abs(math.sin((abs(math.remainder(angle, 2 * math.pi)) - math.radians(c)) / 2)) * 1.4 for c in clamps
            )
            radius = _SCALE * (1 + 0.13 * sign * min(1.0, free))
            points.append(f"{70 + radius * math.sin(angle):.1f} {centre - radius * math.cos(angle):.1f}")
        paths.append("M" + "L".join(points))
    return f'<path d="{"".join(paths)}" fill="none" stroke="{colour}" stroke-width="0.9" stroke-dasharray="1.5 2.5"/>'


def _clamp(centre: float, colatitude: float) -> str:
    """Marks on either side where a shell is held."""
    x, y = _SCALE * math.sin(math.radians(colatitude)), centre - _SCALE * math.cos(math.radians(colatitude))
    return "".join(f'<circle cx="{70 + side * x:.1f}" cy="{y:.1f}" r="3.5" class="clamp"/>' for side in (-1, 1))
