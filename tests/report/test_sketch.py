"""Sketches of designs: shape, clamps and colour."""

import math
import xml.etree.ElementTree as ET

import pytest

from vsb.report.canvas import style
from vsb.report.sketch import design_in_words, sketch, sketches
from vsb.study.study import parse

DESIGNS = {
    "FSB": {"flexible": False, "clamp": []},
    "VSWEC": {"flexible": True, "clamp": []},
    "VSWEC0": {"flexible": True, "clamp": [0.0]},
    "two": {"flexible": True, "clamp": [30.0, 180.0]},
}


def test_designs_in_words():
    assert [design_in_words(design) for design in DESIGNS.values()] == [
        "rigid", "elastic shell, free", "elastic shell, held at the top",
        "elastic shell, held 30° from the top and at the keel",
    ]  # fmt: skip


@pytest.mark.parametrize("name", DESIGNS)
def test_sketch_has_the_colour_and_clamps_of_its_design(name):
    text = sketch(name, DESIGNS, 0.2)
    root = ET.fromstring(text)
    assert root.get("aria-label").startswith(f"{name}, ")
    assert style(name, list(DESIGNS))["color"] in text
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


def test_shell_is_at_rest_at_its_clamps():
    root = ET.fromstring(sketch("two", DESIGNS, 0.0))
    (path,) = (one for one in root.iter("path") if "stroke-dasharray" in one.attrib)
    swollen, squeezed = (
        [tuple(map(float, point.split())) for point in part.split("L")] for part in path.get("d").split("M")[1:]
    )
    held = [k for k, (one, other) in enumerate(zip(swollen, squeezed, strict=True)) if one == other]
    assert held == [4, 24, 44]
    assert all(math.dist((70, 62), one) > math.dist((70, 62), other)
               for k, (one, other) in enumerate(zip(swollen, squeezed, strict=True)) if k not in held)  # fmt: skip
