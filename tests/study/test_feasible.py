"""What no buoy of a design file's ranges can be: proofs that no buoy drawn at random contradicts."""

import math

import pytest
from conftest import SEED
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.engine.shell.device import centre_height, keel_depth
from vsb.study.feasible import Ranges, Reachable, Unmet
from vsb.study.study import load

STUDY = load(SEED)  # r 2 m, 10 mm of 2700 kg/m^3, half immersed
SPHEROID = STUDY.device.model_validate(
    {**STUDY.device.model_dump(), "thickness": 0.02, "shape": {"spheroid": {"height": 3.0}}}
)


def judged(bounds, limits=None, *, device=STUDY.device, deforms=False):
    return Ranges(device, STUDY.water, bounds, limits or {}, deforms).judged()


@pytest.mark.parametrize(
    ("bounds", "limits", "demand", "why"),
    [
        ({"device.mass": (10.0, 20.0)}, {}, "shell", "the shell alone has at least 1357 kg"),
        ({"device.mass": (9e5, 9.1e5), "device.radius": (1.4, 2.6)}, {}, "floats", "the largest displaces 7.546e+04 kg"),
        ({"device.thickness": (0.1, 0.15), "device.mass": (1e3, 1e4)}, {}, "shell", "at least 1.357e+04 kg"),
        ({"device.thickness": (0.25, 0.4), "device.density": (1.0, 2.0)}, {}, "thin", "thickness from 0.25 m"),
        ({"device.thickness": (1e-4, 2e-4), "device.mass": (0.1, 15.0), "device.density": (1.0, 2.0)}, {}, "", ""),
        ({"device.thickness": (1e-4, 2e-4), "device.mass": (0.1, 2.0), "device.density": (0.1, 2.0)}, {}, "weight", "lies on"),
        ({"device.radius": (1.6, 2.6)}, {"beam": 0.5}, "beam", "every hull is at least 3.2 m wide"),
        ({"device.mass": (7e3, 2e4)}, {"mass": 100.0}, "mass", "every buoy has at least 7000 kg"),
        ({"device.mass": (7e3, 2e4)}, {"draft": 0.01}, "draft", "the largest carries"),
        ({"device.mass": (7e3, 2e4)}, {"surface": 50.0}, "surface", r"at least 50.27 m\^2"),
        ({"device.mass": (7e3, 2e4)}, {"volume": 33.0}, "volume", r"at least 33.51 m\^3"),
        ({"device.radius": (1.0, 3.0), "device.mass": (1.2e4, 1.3e4)}, {"beam": 3.5, "draft": 1.2}, "together", "no radius meets all"),
    ],
)  # fmt: skip
def test_ranges_without_a_buoy_are_named_with_their_reason(bounds, limits, demand, why):
    found = judged(bounds, limits)
    if not demand:
        assert isinstance(found, Reachable)
        return
    assert isinstance(found, Unmet)
    assert found.demand == demand
    assert why.replace("\\", "") in found.why


def test_a_shell_at_equilibrium_may_shrink_as_far_as_its_strain_allows():
    """Green-Lagrange strain e = (lambda^2 - 1)/2: from 2 r to 2 r sqrt(1 - 2 e), to nothing where strain is free."""
    bounds = {"device.radius": (2.0, 2.4)}
    for strain, beam in ((0.1, 4 * math.sqrt(0.8)), (0.0, 4.0)):
        limits = {"static_strain": strain}
        assert isinstance(judged(bounds, {**limits, "beam": 1.001 * beam}, deforms=True), Reachable)
        assert isinstance(judged(bounds, {**limits, "beam": 0.999 * beam}, deforms=True), Unmet)
    assert isinstance(judged(bounds, {"beam": 0.1}, deforms=True), Reachable)


def test_reachable_part_of_wide_ranges():
    """A sphere of 7 t needs r > 1.18 m to float, a beam of 4.8 m r < 2.4 m; cells are 5 % wide."""
    found = judged({"device.radius": (0.02, 400.0), "device.mass": (7e3, 2.5e4)}, {"beam": 4.8})
    least = (7e3 / 1025 / (4 / 3 * math.pi)) ** (1 / 3)
    assert least / 1.06 < found.radius[0] < least < 2.4 < found.radius[1] < 2.4 * 1.06


@settings(max_examples=150)
@given(st.tuples(*[st.floats(0.0, 1.0)] * 8), st.sampled_from(["beam", "draft", "mass", "surface"]))
def test_no_buoy_that_floats_within_a_limit_is_excluded(draws, name):
    """Against the device's own draft and mass of the shell: a buoy drawn, and ranges and a limit that admit it."""
    r, t, m, *around = draws
    radius, thickness = 0.5 + 4 * r, 0.002 + 0.03 * t
    device = STUDY.device.model_copy(update={"radius": radius, "thickness": thickness})
    full, shell = 1025 * 4 / 3 * math.pi * radius**3, device.shell_mass
    mass = shell + m * (0.98 * full - shell)
    if not 0.02 * full < mass < 0.98 * full or thickness >= radius / 10:
        return
    device = device.model_copy(update={"mass": mass})
    has = {
        "beam": 2 * radius,
        "draft": keel_depth(device, centre_height(device, STUDY.water)),
        "mass": mass,
        "surface": 4 * math.pi * radius**2,
    }
    values = {"device.radius": radius, "device.thickness": thickness, "device.mass": mass}
    bounds = {
        key: (value * (1 - 0.5 * low), value * (1 + high))
        for (key, value), low, high in zip(values.items(), around, around[1:], strict=False)
    }
    found = judged(bounds, {name: has[name]}, device=device)
    assert isinstance(found, Reachable)
    assert found.radius[0] <= radius * (1 + 1e-9)
    assert radius <= found.radius[1] * (1 + 1e-9)
    assert found.mass[0] <= mass * (1 + 1e-9)
    assert mass <= found.mass[1] * (1 + 1e-9)


def test_height_of_a_spheroid_is_taken_at_the_end_that_admits_most():
    bounds = {"device.shape.spheroid.height": (1.0, 6.0), "device.radius": (1.5, 2.0), "device.mass": (1e3, 6e4)}
    assert isinstance(judged(bounds, device=SPHEROID), Reachable)
    assert judged({**bounds, "device.mass": (6e4, 7e4)}, device=SPHEROID).demand == "floats"  # 51.5 t of water at most
    assert judged({**bounds, "device.mass": (10.0, 20.0)}, device=SPHEROID).demand == "shell"
