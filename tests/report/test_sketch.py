"""Sketches of designs: shape, clamps and colour."""

import xml.etree.ElementTree as ET

import pytest

from vsb.report.canvas import style
from vsb.report.sketch import sketch, sketches
from vsb.study.study import parse

DESIGNS = {
    "FSB": {"flexible": False, "clamp": []},
    "VSWEC": {"flexible": True, "clamp": []},
    "VSWEC0": {"flexible": True, "clamp": [0.0]},
    "two": {"flexible": True, "clamp": [30.0, 180.0]},
}


@pytest.mark.parametrize("name", DESIGNS)
def test_sketch_has_the_colour_and_clamps_of_its_design(name):
    text = sketch(name, DESIGNS, 0.2)
    root = ET.fromstring(text)
    assert root.get("aria-label").startswith(f"{name}, ")
    assert style(name, list(DESIGNS), "FSB")["color"] in text
    assert text.count('class="clamp"') == 2 * len(DESIGNS[name]["clamp"])
    assert ("stroke-dasharray" in text) == DESIGNS[name]["flexible"]


@pytest.mark.parametrize("radius", [0.5, 2.0, 7.0])
@pytest.mark.parametrize("draft", [0.6, 1.0, 1.3])
def test_sphere_floats_at_its_draft(seed, radius, draft):
    """In radii, of 34 units each; the take-off begins at its keel."""
    raw = seed.model_dump() | {"designs": {"FSB": {"flexible": False}, "VSWEC": {}}, "published": None}
    raw["device"] |= {"radius": radius, "thickness": radius / 200, "draft": draft * radius}
    del raw["device"]["mass"]
    for one in sketches(parse(raw, source="sphere")):
        root = ET.fromstring(one["svg"])
        (body,) = root.iter("circle")
        assert float(body.get("cy")) + float(body.get("r")) == pytest.approx(62.0 + 34.0 * draft, abs=0.1)
        line = next(e.get("d") for e in root.iter("path") if e.get("class") == "takeoff")
        assert float(line.removeprefix("M70 ").partition("V")[0]) == pytest.approx(62.0 + 34.0 * draft, abs=0.1)
