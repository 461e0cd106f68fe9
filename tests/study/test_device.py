"""The buoy of a study: limits, mass, balance."""

import math

import pytest

from vsb.errors import ConfigError
from vsb.study.device import Device
from vsb.study.reading import validated

GIVEN = {
    "radius": 2.0,
    "thickness": 0.01,
    "young_modulus": 1e7,
    "poisson_ratio": 0.3,
    "density": 2700.0,
    "mass": 17170.0,
}


def test_mass_is_at_least_that_of_the_shell():
    bare = Device(**GIVEN).shell_mass
    assert Device(**{**GIVEN, "mass": bare}).mass == bare
    with pytest.raises(ConfigError, match=r"mass 1355 kg: needs at least the mass of the shell itself, 1357.17 kg"):
        validated(Device, {**GIVEN, "mass": 1355.0}, "device")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"thickness": 0.2}, r"thickness 0.2 m: thin-shell theory \(C3\) needs less than radius/10 = 0.2 m"),
        ({"thickness": 6.6e-5}, r"thickness 6.6e-05 m: needs at least radius/3e4 = 6.667e-05 m, because a thinner"),
        ({"internal_pressure": -101325.0}, r"internal_pressure -101325 Pa, gauge: needs more than -101325 Pa, because"),
        ({"internal_pressure": -5e4, "gas": {"atmospheric_pressure": 5e4}}, r"needs more than -50000 Pa"),
    ],
)
def test_limits_of_thickness_and_pressure(changes, said):
    with pytest.raises(ConfigError, match=said):
        validated(Device, {**GIVEN, **changes}, "device")
    within = {"thickness": {0.2: 0.1999, 6.6e-5: 6.67e-5}, "internal_pressure": {-101325.0: -101324.0, -5e4: -49999.0}}
    nearly = {key: within[key][value] if key in within else value for key, value in changes.items()}
    validated(Device, {**GIVEN, "mass": 40000.0, **nearly}, "device")


def test_spheroidal_shell_mass_and_thickness_limit():
    """Half as high as wide: sharpest at its equator, b^2/a."""
    shape, eccentricity = {"spheroid": {"height": 2.0}}, math.sqrt(0.75)
    area = 2 * math.pi * 4.0 + math.pi / eccentricity * math.log((1 + eccentricity) / (1 - eccentricity))
    device = validated(Device, {**GIVEN, "shape": shape}, "device")
    assert device.shell_mass == pytest.approx(area * 0.01 * 2700.0, rel=1e-9)
    validated(Device, {**GIVEN, "shape": shape, "thickness": 0.0499}, "device")
    with pytest.raises(ConfigError, match=r"thickness 0.0501 m: .* a tenth of the shape's least radius of .*, 0.05 m"):
        validated(Device, {**GIVEN, "shape": shape, "thickness": 0.0501}, "device")
