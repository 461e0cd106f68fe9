"""The buoy of a study: what it may be, and how it is balanced."""

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


def test_the_shell_weighs_its_volume():
    assert Device(**GIVEN).shell_mass == pytest.approx(1357.168, abs=1e-3)


def test_balance_is_not_said_where_it_is_not_given():
    """Ids of studies of before stay."""
    assert {"centre_of_mass", "ballast_inertia"}.isdisjoint(Device(**GIVEN).model_dump())
    said = Device(**GIVEN, centre_of_mass=-0.5, ballast_inertia=0.0).model_dump()
    assert (said["centre_of_mass"], said["ballast_inertia"]) == (-0.5, 0.0)


@pytest.mark.parametrize("height", [-1.9, 1.85])
def test_the_ballast_lies_inside_the_sphere(height):
    with pytest.raises(
        ConfigError, match=r"centre_of_mass .* needs at most 1.842 m above or below the sphere's centre"
    ):
        validated(Device, {**GIVEN, "centre_of_mass": height}, "device")
    validated(Device, {**GIVEN, "centre_of_mass": 1.84}, "device")


def test_an_inertia_is_not_negative():
    with pytest.raises(ConfigError, match=r"ballast_inertia: received -1.0; needs a number of at least 0"):
        validated(Device, {**GIVEN, "ballast_inertia": -1.0}, "device")
