"""Mass, draft and frequency band that follow from the size of the buoy."""

import math

import pytest
import yaml
from conftest import SEED

from vsb.errors import ConfigError
from vsb.study.device import (
    Device,
    Shape,
    cap_volume,
    centre_height,
    full_volume,
    keel_depth,
    volume_to,
    waterline_radius,
)
from vsb.study.sections import Water
from vsb.study.study import canonical, parse


@pytest.fixture
def raw():
    return yaml.safe_load(SEED.read_text())


def without(section, *keys, **others):
    return {key: value for key, value in section.items() if key not in keys} | others


@pytest.mark.parametrize(("radius", "gravity", "omega_max"), [(2.0, 9.81, 12.0), (8.0, 9.81, 6.0), (5.0, 1.62, 3.1)])
def test_band_scales_with_the_root_of_gravity_over_radius(raw, radius, gravity, omega_max):
    device = without(raw["device"], "mass", radius=radius, thickness=radius / 200)
    swell = {"kind": "regular", "amplitude": 0.1, "period": 10.0}
    others = {"device": device, "hydro": {}, "water": {"gravity": gravity}, "waves": [swell]}
    assert parse(raw | others).hydro.omega_max == omega_max
    assert omega_max == pytest.approx(5.4 * math.sqrt(gravity / radius), rel=0.02)


@pytest.mark.parametrize("draft", [None, 1.0, 2.5])
def test_mass_is_that_of_the_displaced_water(raw, draft):
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
def test_errors_of_mass_and_draft(raw, device, wrong):
    with pytest.raises(ConfigError, match=wrong):
        parse(raw | {"device": without(raw["device"], "mass") | device, "hydro": {"omega_max": "auto"}})


@pytest.mark.parametrize("height", [1.0, 3.0])
def test_waterline_must_stay_clear_of_the_poles(raw, height):
    """A hundredth of the half height."""
    least, most = (1025 * cap_volume(2.0, part) * height / 4.0 for part in (0.01, 1.99))
    shell = {"shape": {"spheroid": {"height": height}}, "density": 1.0, "thickness": 1e-3}  # next to nothing
    others = {"modes": {"basis": "full", "degree": 2}, "designs": {"FSB": {"flexible": False}}}

    def floating_system(mass):
        return parse(raw | others | {"device": without(raw["device"], mass=mass, **shell)})

    for inside, outside in ((1.000001 * least, 0.999999 * least), (0.999999 * most, 1.000001 * most)):
        assert floating_system(inside).device.mass == inside
        with pytest.raises(
            ConfigError, match=rf"needs {least:.6g} to {most:.6g} kg, because the waterplane is too small within 0.01"
        ):
            floating_system(outside)


def test_volume_of_spherical_caps():
    assert cap_volume(2.0, 0.0) == 0.0
    assert cap_volume(2.0, 1.0) == pytest.approx(2 / 3 * math.pi * 8)
    assert cap_volume(2.0, 2.0) == pytest.approx(4 / 3 * math.pi * 8)


SHELL = {"radius": 2.0, "thickness": 1e-3, "density": 1.0, "young_modulus": 1e7, "poisson_ratio": 0.3}


@pytest.mark.parametrize("height", [1.0, 3.0, 7.0])
@pytest.mark.parametrize("part", [0.2, 1.0, 1.7])
def test_spheroid_floats_as_the_stretched_sphere(part, height):
    volume = cap_volume(2.0, part) * height / 4.0
    shape = Shape.model_validate({"spheroid": {"height": height}})
    device, water = Device(**SHELL, mass=800.0 * volume, shape=shape), Water(density=800.0)
    centre = centre_height(device, water)
    assert centre == pytest.approx(height / 2 * (1 - part), abs=1e-12 * height)
    assert keel_depth(device, centre) == pytest.approx(part * height / 2, rel=1e-11)
    assert waterline_radius(shape, 2.0, centre) == pytest.approx(2.0 * math.sqrt(part * (2 - part)), rel=1e-11)
    assert volume_to(device, part) == pytest.approx(volume, rel=1e-12)
    assert full_volume(device) == pytest.approx(2 / 3 * math.pi * 4.0 * height, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "expected"),
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
def test_invalid_radius_or_water_is_the_only_error(raw, changes, expected, given):
    """A missing mass is not reported as a second error."""
    device = without(raw["device"], "mass", **given) | changes.get("device", {})
    with pytest.raises(ConfigError) as refused:
        parse(raw | {"water": changes.get("water", {}), "device": device}, source="here")
    assert len(refused.value.mistakes) == 1
    assert str(refused.value).startswith(f"here: {expected}")
