"""What a study leaves to the size of its buoy: mass by draft or half immersion, the band of frequencies."""

import math

import pytest
import yaml
from conftest import SEED
from hypothesis import given
from hypothesis import strategies as st

import vsb
from vsb.errors import ConfigError
from vsb.study.device import Device
from vsb.study.floating import (
    cap_volume,
    centre_height,
    floating_height,
    full_volume,
    keel_depth,
    volume_to,
    waterline_radius,
)
from vsb.study.sections import Water
from vsb.study.shape import Shape
from vsb.study.study import canonical, load, parse


@pytest.fixture
def raw():
    return yaml.safe_load(SEED.read_text())


def without(section, *keys, **others):
    return {key: value for key, value in section.items() if key not in keys} | others


def test_the_seeds_band_is_that_of_its_size(raw):
    """What is said by number or by word has one canonical form, so results keep their names."""
    said = canonical(load(SEED))
    for hydro in (without(raw["hydro"], "omega_max"), raw["hydro"] | {"omega_max": "auto"}):
        assert canonical(parse(raw | {"hydro": hydro})) == said


@pytest.mark.parametrize(("radius", "gravity", "omega_max"), [(2.0, 9.81, 12.0), (8.0, 9.81, 6.0), (5.0, 1.62, 3.1)])
def test_the_band_scales_with_the_root_of_gravity_over_radius(raw, radius, gravity, omega_max):
    device = without(raw["device"], "mass", radius=radius, thickness=radius / 200)
    swell = {"kind": "regular", "amplitude": 0.1, "period": 10.0}
    others = {"device": device, "hydro": {}, "water": {"gravity": gravity}, "waves": [swell]}
    assert parse(raw | others).hydro.omega_max == omega_max
    assert omega_max == pytest.approx(5.4 * math.sqrt(gravity / radius), rel=0.02)


def test_a_band_that_is_given_stays(raw):
    assert parse(raw | {"hydro": {"omega_max": 7.0}}).hydro.omega_max == 7.0


def test_sections_made_in_python_are_told_their_band_by_the_study(raw):
    device, wave = vsb.Device(**raw["device"]), vsb.RegularWave(kind="regular", amplitude=0.1, period=3.0)
    wide = vsb.Device(**without(raw["device"], radius=8.0, thickness=0.04, mass=1e6))
    for known, hydro, omega_max in (
        (device, vsb.Hydro(), 12.0), (wide, vsb.Hydro(), 6.0), (wide, vsb.Hydro(omega_max=5.0), 5.0),
        (wide, vsb.Hydro(tolerance=1e-4, solver="spectral"), 6.0), (wide, vsb.Hydro(tolerance=1e-4, omega_max=5.0), 5.0),
        (wide, vsb.Hydro(omega_max=12.0), 12.0),
    ):  # fmt: skip
        study = vsb.Study(study="a", device=known, designs={"A": vsb.Design()}, hydro=hydro, waves=(wave,))
        assert study.hydro.omega_max == omega_max


@pytest.mark.parametrize("draft", [None, 1.0, 2.5])
def test_the_mass_is_that_of_the_water_displaced(raw, draft):
    """Without mass and draft half the sphere is immersed."""
    device = without(raw["device"], "mass", **({} if draft is None else {"draft": draft}))
    study, sunk = parse(raw | {"device": device}), draft or 2.0
    assert study.device.mass == pytest.approx(1025 * math.pi * sunk**2 * (6 - sunk) / 3, rel=1e-12)
    assert study.draft == pytest.approx(sunk, rel=1e-12)
    assert "draft" not in canonical(study)


@pytest.mark.parametrize(
    ("device", "wrong"),
    [
        ({"mass": 1e4, "draft": 1.0}, r"device: received mass and draft, needs one of them"),
        ({"draft": 4.0}, r"device.draft: received 4.0, needs more than 0 and less than two radii, 4 m"),
        ({"draft": -1}, r"device.draft: received -1, needs more than 0"),
        ({"draft": "deep"}, r"device.draft: received 'deep', needs more than 0"),
        ({"draft": True}, r"device.draft: received True, needs more than 0"),
        ({"mass": 1e4, "radius": "x"}, r"device.radius: received 'x'; needs a number$"),
        ({"mass": 1e4, "radius": True}, r"device.radius: received True; a number is needed, not true/false$"),
    ],
)
def test_a_draft_that_makes_no_sense_is_one_line(raw, device, wrong):
    with pytest.raises(ConfigError, match=wrong):
        parse(raw | {"device": without(raw["device"], "mass") | device, "hydro": {"omega_max": "auto"}})


@pytest.mark.parametrize("height", [1.0, 3.0])
def test_a_spheroid_floats_with_its_waterline_a_hundredth_of_its_half_height_from_either_pole(raw, height):
    """A spheroid is a sphere stretched along its axis, and so is every part of it."""
    least, most = (1025 * cap_volume(2.0, part) * height / 4.0 for part in (0.01, 1.99))
    shell = {"shape": {"spheroid": {"height": height}}, "density": 1.0, "thickness": 1e-3}  # next to nothing
    others = {"modes": {"basis": "full", "degree": 2}, "designs": {"FSB": {"flexible": False}}}

    def afloat(mass):
        return parse(raw | others | {"device": without(raw["device"], mass=mass, **shell)})

    for inside, outside in ((1.000001 * least, 0.999999 * least), (0.999999 * most, 1.000001 * most)):
        assert afloat(inside).device.mass == inside
        with pytest.raises(ConfigError, match=rf"needs {least:.6g} to {most:.6g} kg, because a waterline within 0.01"):
            afloat(outside)


def test_caps_are_nothing_half_and_all_of_the_sphere():
    assert cap_volume(2.0, 0.0) == 0.0
    assert cap_volume(2.0, 1.0) == pytest.approx(2 / 3 * math.pi * 8)
    assert cap_volume(2.0, 2.0) == pytest.approx(4 / 3 * math.pi * 8)


@given(st.floats(0.01, 100.0), st.floats(0.01, 1.99))
def test_the_cap_under_water_has_the_volume_asked_for(radius, height):
    """Its height in radii and what is left of the sphere above are one radius apart."""
    centre = floating_height(radius, cap_volume(radius, height))
    assert centre == pytest.approx(radius * (1 - height), abs=1e-7 * radius)
    below = cap_volume(radius, height) + cap_volume(radius, 2 - height)
    assert below == pytest.approx(4 / 3 * math.pi * radius**3, rel=1e-12)


SHELL = {"radius": 2.0, "thickness": 1e-3, "density": 1.0, "young_modulus": 1e7, "poisson_ratio": 0.3}
EGG = [[0.0, 4.0], [0.6, 3.8], [1.2, 3.2], [1.7, 2.2], [2.0, 1.2], [1.6, 0.4], [0.9, 0.07], [0.0, 0.0]]


@pytest.mark.parametrize("height", [1.0, 3.0, 7.0])
@pytest.mark.parametrize("part", [0.2, 1.0, 1.7])
def test_a_spheroid_floats_as_the_sphere_it_is_stretched_from(part, height):
    """In water of any density: its draft, its centre, its waterline and what is below."""
    volume = cap_volume(2.0, part) * height / 4.0
    shape = Shape.model_validate({"spheroid": {"height": height}})
    device, water = Device(**SHELL, mass=800.0 * volume, shape=shape), Water(density=800.0)
    centre = centre_height(device, water)
    assert centre == pytest.approx(height / 2 * (1 - part), abs=1e-12 * height)
    assert keel_depth(device, centre) == pytest.approx(part * height / 2, rel=1e-11)
    assert waterline_radius(shape, 2.0, centre) == pytest.approx(2.0 * math.sqrt(part * (2 - part)), rel=1e-11)
    assert volume_to(device, part) == pytest.approx(volume, rel=1e-12)
    assert full_volume(device) == pytest.approx(2 / 3 * math.pi * 4.0 * height, rel=1e-12)


@pytest.mark.parametrize("draft", [0.4, 1.2, 2.2, 3.2])
def test_an_egg_has_the_waterline_of_its_profile_at_its_draft(draft):
    """Its keel not as its top; its largest radius is between the points, a thousandth wider than they say."""
    shape = Shape.model_validate({"profile": EGG})
    wanted = next(x for x, z in EGG if z == draft)
    assert waterline_radius(shape, 2.0, 2.0 - draft) == pytest.approx(wanted, abs=5e-3)


@pytest.mark.parametrize("draft", [0.5, 1.0, 2.9])
def test_a_mass_is_of_the_water_there_is_whatever_the_shape(raw, draft):
    device = without(raw["device"], "mass", density=1.0, draft=draft)
    others = raw | {"water": {"density": 800.0}, "modes": {"basis": "full", "degree": 2}}
    assert parse(others | {"device": device}).device.mass == pytest.approx(800.0 * cap_volume(2.0, draft / 2.0))
    shaped = device | {"shape": {"spheroid": {"height": 3.0}}, "thickness": 1e-3}
    found = parse(others | {"device": shaped, "designs": {"FSB": {"flexible": False}}})
    assert found.device.mass == pytest.approx(800.0 * cap_volume(2.0, draft / 1.5) * 0.75)
    assert found.draft == pytest.approx(draft, rel=1e-11)


@pytest.mark.parametrize("draft", [3.0, 3.5, 0.0, -1.0, True])
def test_a_draft_of_another_shape_is_less_than_its_height(raw, draft):
    device = without(raw["device"], "mass", draft=draft, shape={"spheroid": {"height": 3.0}})
    with pytest.raises(
        ConfigError, match=rf"device.draft: received {draft}, needs more than 0 and less than the hei.*, 3 m"
    ):
        parse(raw | {"device": device})


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"water": 5}, ["water: received 5; needs a mapping"]),
        ({"device": None}, ["device: received None; needs a mapping"]),
        (
            {"device": 3.0, "water": [1]},
            ["device: received 3.0; needs a mapping", "water: received [1]; needs a mapping"],
        ),
        ({"hydro": 7}, ["hydro: received 7; needs a mapping"]),
    ],
    ids=str,
)
def test_sections_that_are_none_are_told_and_nothing_that_follows_from_them(raw, changes, told):
    with pytest.raises(ConfigError) as refused:
        parse(raw | {"hydro": {"omega_max": "auto"}} | changes, source="here")
    assert len(refused.value.mistakes) == len(told)
    for line, begins in zip(refused.value.mistakes, told, strict=True):
        assert line.startswith(f"here: {begins}")


def test_all_else_of_a_section_is_judged_where_its_band_cannot_be_told(raw):
    device = without(raw["device"], radius="wide")
    with pytest.raises(ConfigError) as refused:
        parse(
            raw | {"device": device, "hydro": {"omega_max": "auto", "tolerance": 7.0, "model": "magic"}}, source="here"
        )
    assert [line.split()[1] for line in refused.value.mistakes] == [
        "device.radius:",
        "hydro.model:",
        "hydro.tolerance:",
    ]


def test_sections_made_in_python_tell_their_density_gravity_and_shape(raw):
    """Beside others that are mappings; without a section there is no mistake in it."""
    moon, oblate = vsb.Water(density=800.0, gravity=1.62), Shape.model_validate({"spheroid": {"height": 3.0}})
    device = without(raw["device"], "mass", density=1.0, draft=1.0)
    swell = [{"kind": "regular", "amplitude": 0.1, "period": 10.0}]
    study = parse(without(raw, "hydro") | {"device": device, "water": moon, "waves": swell})
    assert study.hydro.omega_max == pytest.approx(5.4 * math.sqrt(1.62 / 2.0), rel=0.02)
    assert study.device.mass == pytest.approx(800.0 * cap_volume(2.0, 0.5), rel=1e-12)
    shaped = device | {"shape": oblate, "thickness": 1e-3}
    modes = {"basis": "full", "degree": 2}
    found = parse(raw | {"device": shaped, "water": moon, "modes": modes, "hydro": {}, "waves": swell})
    assert found.device.mass == pytest.approx(800.0 * cap_volume(2.0, 1.0 / 1.5) * 0.75, rel=1e-11)
    with pytest.raises(ConfigError) as refused:
        parse(without(raw, "hydro") | {"device": device | {"radius": "wide"}}, source="here")
    assert refused.value.mistakes == ("here: device.radius: received 'wide'; needs a number",)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"device": {"radius": "wide"}}, "device.radius: received 'wide'; needs a number"),
        (
            {"device": {"radius": 1e5, "thickness": 100.0}},
            "device.radius: received 100000.0; needs at most 1000 m, because",
        ),
        ({"water": {"density": "heavy"}}, "water.density: received 'heavy'; needs a number"),
        ({"water": {"gravity": 0.0}}, "water.gravity: received 0.0; needs a number above 0"),
    ],
    ids=str,
)
@pytest.mark.parametrize("given", [{}, {"draft": 1.0}, {"mass": 17170.0}])
def test_neither_mass_nor_draft_is_a_mistake_where_what_they_follow_from_is_none(raw, changes, told, given):
    """As it may be left out, a mass is not missed; a draft is no unknown key."""
    device = without(raw["device"], "mass", **given) | changes.get("device", {})
    with pytest.raises(ConfigError) as refused:
        parse(raw | {"water": changes.get("water", {}), "device": device}, source="here")
    assert len(refused.value.mistakes) == 1
    assert str(refused.value).startswith(f"here: {told}")


@pytest.mark.parametrize(
    ("device", "told"),
    [
        ({"radius": True, "draft": 2.5}, ["device.radius: received True; a number is needed, not true/false"]),
        ({"shape": {"spheroid": {"height": -3.0}}}, ["device.shape.spheroid.height: received -3.0; needs a number"]),
        ({"shape": {"profile": [[0.0, 1.0], [1.0, 0.0], [0.0, "x"]]}, "draft": 0.4}, ["device.shape.profile"]),
        ({"shape": 7, "draft": 9.0}, ["device.shape: received 7; needs a mapping"]),
    ],
    ids=str,
)
def test_what_no_mass_can_be_told_of_is_the_one_mistake_there_is(raw, device, told):
    """Neither a mass that is missing, nor a draft that may be right."""
    section = without(raw["device"], "mass", "radius") | {"radius": 2.0} | device
    with pytest.raises(ConfigError) as refused:
        parse(raw | {"device": section, "hydro": {"omega_max": "auto"}}, source="here")
    assert len(refused.value.mistakes) == len(told)
    for line, begins in zip(refused.value.mistakes, told, strict=True):
        assert line.startswith(f"here: {begins}")
