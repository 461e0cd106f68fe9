"""Sketches of designs: valid, named, held where they are held, in the colour of their curves."""

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


def test_designs_are_said_in_words():
    assert [design_in_words(design) for design in DESIGNS.values()] == [
        "rigid", "elastic shell, free", "elastic shell, held at the top",
        "elastic shell, held 30° from the top and at the keel",
    ]  # fmt: skip


@pytest.mark.parametrize("name", DESIGNS)
def test_a_sketch_has_the_colour_and_the_marks_of_its_design(name):
    text = sketch(name, DESIGNS, 0.2)
    root = ET.fromstring(text)
    assert root.get("aria-label").startswith(f"{name}, ")
    assert style(name, list(DESIGNS))["color"] in text
    assert text.count('class="clamp"') == 2 * len(DESIGNS[name]["clamp"])
    assert ("stroke-dasharray" in text) == DESIGNS[name]["flexible"]


def test_another_shape_is_drawn_as_it_is_and_held_on_its_surface():
    """An oblate buoy of half the height: as wide, its keel and its clamps there; a tall one fits."""
    flat = sketch("two", DESIGNS, 0.0, lambda angle: (math.sin(angle), 0.5 * math.cos(angle)))
    assert '<circle cx="70" cy="62.0"' not in flat
    body = next(e.get("d") for e in ET.fromstring(flat).iter("path") if "fill-opacity" in e.attrib)
    points = [tuple(map(float, point.split())) for point in body.strip("MZ").split("L")]
    assert max(x for x, _ in points) - min(x for x, _ in points) == pytest.approx(68.0)
    assert max(y for _, y in points) - min(y for _, y in points) == pytest.approx(34.0)
    held = [(float(e.get("cx")), float(e.get("cy"))) for e in ET.fromstring(flat).iter("circle")]
    assert sorted(held) == [(53.0, 47.3), (70.0, 79.0), (70.0, 79.0), (87.0, 47.3)]
    high = sketch("FSB", DESIGNS, 0.0, lambda angle: (math.sin(angle), max(3.0 * math.cos(angle), math.cos(angle))))
    body = next(e.get("d") for e in ET.fromstring(high).iter("path") if "fill-opacity" in e.attrib)
    assert min(float(point.split()[1]) for point in body.strip("MZ").split("L")) == pytest.approx(62.0 - 34.0)
    tall = sketch("FSB", DESIGNS, 0.0, lambda angle: (math.sin(angle), 3.0 * math.cos(angle)))
    body = next(e.get("d") for e in ET.fromstring(tall).iter("path") if "fill-opacity" in e.attrib)
    assert max(float(point.split()[1]) for point in body.strip("MZ").split("L")) == pytest.approx(62.0 + 34.0)


def test_the_shell_stays_where_it_is_held():
    """At the clamp on top swollen and squeezed meridians meet: both start there."""
    path = next(
        e.get("d") for e in ET.fromstring(sketch("VSWEC0", DESIGNS, 0.0)).iter("path") if "stroke-dasharray" in e.attrib
    )
    swollen, squeezed = (part.split("L")[0] for part in path.split("M")[1:])
    assert swollen == squeezed == "70.0 28.0"


@pytest.mark.parametrize("radius", [0.5, 2.0, 7.0])
def test_a_spheroid_of_any_size_is_drawn_in_radii(seed, radius):
    """As wide as the sphere of its radius, as high as it is to its width."""
    raw = seed.model_dump()
    raw["device"] |= {"radius": radius, "thickness": radius / 200, "draft": 0.6 * radius}
    del raw["device"]["mass"]
    raw["device"] |= {"shape": {"spheroid": {"height": 1.4 * radius}}}
    raw["modes"] |= {"basis": "full"}
    study = parse({**raw, "designs": {"VSWEC": {}}, "published": None}, source="spheroid")
    (one,) = sketches(study)
    body = next(e.get("d") for e in ET.fromstring(one["svg"]).iter("path") if "fill-opacity" in e.attrib)
    x, y = zip(*(map(float, point.split()) for point in body.strip("MZ").split("L")), strict=True)
    assert max(x) - min(x) == pytest.approx(68.0, abs=0.3)
    assert max(y) - min(y) == pytest.approx(0.7 * 68.0, abs=0.3)


@pytest.mark.parametrize("radius", [0.5, 2.0, 7.0])
@pytest.mark.parametrize("draft", [0.6, 1.0, 1.3])
def test_a_sphere_of_any_size_lies_as_deep_as_its_draft(seed, radius, draft):
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


@pytest.mark.parametrize("height", [-0.4, 0.0, 0.3])
def test_a_free_shell_swells_and_shrinks_by_an_eighth_about_its_centre(height):
    """Thirteen per cent either way, in the colour of the design; the centre is above the water by its height."""
    root = ET.fromstring(sketch("VSWEC", DESIGNS, height))
    (path,) = (one for one in root.iter("path") if "stroke-dasharray" in one.attrib)
    assert path.get("stroke") == style("VSWEC", list(DESIGNS))["color"]
    for part, size in zip(path.get("d").split("M")[1:], (1.13, 0.87), strict=True):
        points = [tuple(map(float, point.split())) for point in part.split("L")]
        sizes = [math.hypot(x - 70, y - (62.0 - 34.0 * height)) for x, y in points]
        assert sizes == pytest.approx([34.0 * size] * len(points), abs=0.1)


def test_a_shell_is_still_where_it_is_held_on_both_sides_and_moves_in_between():
    """Held at 30 degrees and at the keel: both meridians meet there, and nowhere else."""
    root = ET.fromstring(sketch("two", DESIGNS, 0.0))
    (path,) = (one for one in root.iter("path") if "stroke-dasharray" in one.attrib)
    swollen, squeezed = (
        [tuple(map(float, point.split())) for point in part.split("L")] for part in path.get("d").split("M")[1:]
    )
    held = [k for k, (one, other) in enumerate(zip(swollen, squeezed, strict=True)) if one == other]
    assert held == [4, 24, 44]
    assert all(math.dist((70, 62), one) > math.dist((70, 62), other)
               for k, (one, other) in enumerate(zip(swollen, squeezed, strict=True)) if k not in held)  # fmt: skip


def test_a_rigid_buoy_has_a_thick_line_and_names_may_have_any_letters():
    widths = {}
    for name in ("FSB", "VSWEC"):
        (body,) = (
            one for one in ET.fromstring(sketch(name, DESIGNS, 0.0)).iter("circle") if "fill-opacity" in one.attrib
        )
        widths[name] = body.get("stroke-width")
        assert body.get("fill") == body.get("stroke") == style(name, list(DESIGNS))["color"]
    assert widths == {"FSB": "5", "VSWEC": "2"}
    odd = {"a<b>": DESIGNS["VSWEC0"]}
    assert ET.fromstring(sketch("a<b>", odd, 0.0)).get("aria-label") == "a<b>, elastic shell, held at the top"
    assert design_in_words({"flexible": True, "clamp": [90.0, 22.5]}) == (
        "elastic shell, held at the equator and 22.5° from the top"
    )


def test_a_body_that_reaches_farther_down_than_up_fits_too():
    """Three radii to its keel, one to its top: as large as the taller of the two allows."""
    deep = sketch("FSB", DESIGNS, 0.0, lambda angle: (math.sin(angle), min(3.0 * math.cos(angle), math.cos(angle))))
    root = ET.fromstring(deep)
    body = next(e.get("d") for e in root.iter("path") if "fill-opacity" in e.attrib)
    heights = [float(point.split()[1]) for point in body.strip("MZ").split("L")]
    assert (min(heights), max(heights)) == pytest.approx((62.0 - 34.0 / 3, 62.0 + 34.0), abs=0.1)
    line = next(e.get("d") for e in root.iter("path") if e.get("class") == "takeoff")
    assert line.startswith("M70 96.0V118")


@pytest.mark.parametrize("clamps", [[0.0], [90.0], [30.0, 180.0], [0.0, 90.0, 180.0]])
def test_a_shell_moves_the_more_the_farther_it_is_from_where_it_is_held(clamps):
    """1.4 times the sine of half the angle to each clamp, all of them together, up to all of its thirteen per cent."""
    root = ET.fromstring(sketch("held", {"held": {"flexible": True, "clamp": clamps}}, 0.0))
    (path,) = (one for one in root.iter("path") if "stroke-dasharray" in one.attrib)
    for part, sign in zip(path.get("d").split("M")[1:], (1, -1), strict=True):
        points = [tuple(map(float, point.split())) for point in part.split("L")]
        assert len(points) == 49
        for i, (x, y) in enumerate(points):
            colatitude = 7.5 * min(i, 48 - i)
            free = math.prod(1.4 * abs(math.sin(math.radians(colatitude - clamp) / 2)) for clamp in clamps)
            size = 34.0 * (1 + 0.13 * sign * min(1.0, free))
            assert math.hypot(x - 70, y - 62) == pytest.approx(size, abs=0.1)
