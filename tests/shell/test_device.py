"""The buoy of a study: limits, mass, balance."""

import math

import numpy as np
import pytest
import yaml
from conftest import SEED

from vsb.engine.shell.device import (
    Device,
    Shape,
    cap_volume,
    centre_height,
    full_volume,
    keel_depth,
    volume_to,
    waterline_radius,
)
from vsb.engine.shell.material import NAMED
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.keys.quantities import canonical
from vsb.keys.reading import read_yaml, validated
from vsb.pipeline.plans import planned
from vsb.study.study import parse

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


OBLATE = {"spheroid": {"height": 3.0}}


def raw(shape, **changes):
    """The seed's study with a shape and no mass, its modes complete."""
    found = read_yaml(SEED, "a study")
    device = {key: value for key, value in found["device"].items() if key != "mass"}
    modes, others = {"basis": "full", "degree": 3}, {key: value for key, value in changes.items() if key != "device"}
    return {**found, "device": {**device, "shape": shape, **changes.get("device", {})}, "modes": modes, **others}


def test_without_mass_half_of_the_volume_is_immersed():
    study = parse(raw(OBLATE))
    assert study.device.mass == pytest.approx(study.water.density * 2 / 3 * math.pi * 4 * 1.5, rel=1e-12)
    assert study.draft == pytest.approx(1.5, rel=1e-12)
    assert study.centre_height == pytest.approx(0.0, abs=1e-12)
    assert study.waterline_radius == pytest.approx(2.0, rel=1e-9)
    assert study.heave_frequency == pytest.approx(math.sqrt(9.81 * math.pi * 4 / (2 / 3 * math.pi * 4 * 1.5)), rel=1e-9)


def test_profile_in_a_file(tmp_path):
    points = [(2 * math.sin(math.pi * i / 16) if i % 16 else 0.0, 1.5 * math.cos(math.pi * i / 16)) for i in range(17)]
    (tmp_path / "hull.csv").write_text("x,z\n" + "".join(f"{x!r},{z!r}\n" for x, z in points))
    found = parse(raw({"profile": "hull.csv"}), source=str(tmp_path / "study.yaml"))
    assert found.device.shape.profile == tuple(points)
    assert found.device.meridian.volume == pytest.approx(4 / 3 * math.pi * 4 * 1.5, rel=1e-4)
    assert planned(raw({"profile": "hull.csv"}), str(tmp_path / "study.yaml")).study == found
    assert parse(raw({"profile": points})) == found
    (tmp_path / "hull.csv").write_text("x [mm];z [m]\n" + "".join(f"{1e3 * x!r};{z!r}\n" for x, z in points))
    found = parse(raw({"profile": "hull.csv"}), source=str(tmp_path / "study.yaml"))
    assert np.array(found.device.shape.profile) == pytest.approx(np.array(points), rel=1e-14)
    (tmp_path / "hull.csv").write_text("x,z\n0,1\n1,0,2\n0,-1\n")
    with pytest.raises(ConfigError, match=r"hull.csv:3: received '1 0 2', needs 2 cells"):
        parse(raw({"profile": "hull.csv"}), source=str(tmp_path / "study.yaml"))


@pytest.mark.parametrize(
    ("shape", "changes", "message"),
    [({}, {}, "received none: needs one of spheroid, capsule, series, profile"),
        ({**OBLATE, "capsule": {"length": 1.0}}, {}, "received spheroid and capsule: needs one of"),
        ({"spheroid": {"height": 50.0}}, {}, r"shape.spheroid: received a height of 12.5 diameters, needs 0.1 to 10"),
        ({"spheroid": {"height": 0.5}}, {"device": {"thickness": 0.01}}, "a tenth of the shape's least radius of curv"),
        (OBLATE, {"device": {"mass": 1e6}}, "the buoy would sink; needs less than 25761"),
        (OBLATE, {"hydro": {"model": "auto"}}, "hydro.model 'auto': is known of the sphere alone"),
        (OBLATE, {"hydro": {"model": "assumed_pressure", "pressure": 1e3}}, "'assumed_pressure': is known of the sph"),
        (OBLATE, {"hydro": {"solver": "panels"}}, "hydro.solver: panels are those of the sphere"),
        (OBLATE, {"modes": {"basis": "membrane", "degree": 3}}, "modes.basis 'membrane': modes of another shape"),
        (OBLATE, {"modes": {"basis": "full", "degree": 0}}, "modes.degree 0: device.shape needs at least 1"),
        (OBLATE, {"motion": "planar", "device": {"centre_of_mass": -0.3, "ballast_inertia": 8e3}},
         "motion 'planar': is known of the sphere alone; device.shape needs heave")],
)  # fmt: skip
def test_unsupported_combinations_are_refused(shape, changes, message):
    with pytest.raises(ConfigError, match=message):
        parse(raw(shape, **changes))


def test_rubber_of_another_shape_at_its_equilibrium_is_refused():
    given = raw(OBLATE, reference_shape="equilibrium", device={"material": {"law": "neo_hookean", "mu": 1e7}})
    given["device"] = without(given["device"], "young_modulus", "poisson_ratio")
    with pytest.raises(ConfigError, match="wrinkles of rubber are known of the sphere alone"):
        parse(given)


@pytest.mark.parametrize("shape", [OBLATE, {"capsule": {"length": 1.0}}])
@pytest.mark.parametrize("reference", ["undeformed", "equilibrium"])
def test_any_shape_may_be_pressurised(shape, reference):
    study = parse(raw(shape, reference_shape=reference, device={"internal_pressure": 1e4, "gas": {}, "mass": 1.2e4}))
    assert study.device.internal_pressure == 1e4


@pytest.fixture
def raw_of_floating():
    return yaml.safe_load(SEED.read_text())


def without(section, *keys, **others):
    return {key: value for key, value in section.items() if key not in keys} | others


@pytest.mark.parametrize(("radius", "gravity", "omega_max"), [(2.0, 9.81, 12.0), (8.0, 9.81, 6.0), (5.0, 1.62, 3.1)])
def test_band_scales_with_the_root_of_gravity_over_radius(raw_of_floating, radius, gravity, omega_max):
    device = without(raw_of_floating["device"], "mass", radius=radius, thickness=radius / 200)
    swell = {"kind": "regular", "amplitude": 0.1, "period": 10.0}
    others = {"device": device, "hydro": {}, "water": {"gravity": gravity}, "waves": [swell]}
    assert parse(raw_of_floating | others).hydro.omega_max == omega_max
    assert omega_max == pytest.approx(5.4 * math.sqrt(gravity / radius), rel=0.02)


@pytest.mark.parametrize("draft", [None, 1.0, 2.5])
def test_mass_is_that_of_the_displaced_water(raw_of_floating, draft):
    """Without mass and draft half the sphere is immersed."""
    device = without(raw_of_floating["device"], "mass", **({} if draft is None else {"draft": draft}))
    study, sunk = parse(raw_of_floating | {"device": device}), draft or 2.0
    assert study.device.mass == pytest.approx(1025 * math.pi * sunk**2 * (6 - sunk) / 3, rel=1e-12)
    assert study.draft == pytest.approx(sunk, rel=1e-12)
    assert "draft" not in canonical(study)


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


RUBBER = {"radius": 2.0, "thickness": 0.05, "density": 1100.0, "mass": 17170.0}


@pytest.mark.parametrize(
    ("material", "modulus"),
    [
        ({"law": "neo_hookean", "mu": 4e5}, 1.2e6),
        ({"law": "mooney_rivlin", "c1": 1.6e5, "c2": 4e4}, 1.2e6),
        ({"law": "gent", "mu": 4e5, "jm": 30.0}, 1.2e6),
    ],
    ids=lambda value: value["law"] if isinstance(value, dict) else "",
)
def test_rubber_implies_its_moduli_and_stands_in_their_place(material, modulus):
    device = Device(**RUBBER, material=material)
    assert (device.young_modulus, device.poisson_ratio) == (pytest.approx(modulus), 0.5)
    said = device.model_dump()
    assert said["material"] == material
    assert not {"young_modulus", "poisson_ratio"} & said.keys()
    assert Device(**said) == device


@pytest.mark.parametrize("name", NAMED)
def test_a_material_by_name_stands_for_its_constants(name):
    """Also for its density where none is given; ids are those of the constants written out."""
    rest = {"radius": 2.0, "thickness": 0.05, "mass": 34000.0}
    named, found = Device(**rest, material=name), NAMED[name]
    assert named == Device(**rest, density=found.density, **found.keys)
    assert Device(**named.model_dump()) == named
    assert Device(**rest, material=name, density=999.0).density == 999.0
    modulus = 3 * found.mu if found.mu else found.young_modulus
    assert named.young_modulus == modulus


def test_hookes_law_is_the_default_and_changes_no_id():
    said = Device(**GIVEN, material={"law": "hookean"}).model_dump()
    assert said == Device(**GIVEN).model_dump()
    assert "material" not in said


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"material": {"law": "gent", "mu": 4e5, "jm": 30.0}, "young_modulus": 1e7}, "young_modulus: received"),
        ({"material": {"law": "gent", "mu": 4e5}}, "material.jm: missing, but required"),
        ({"material": "nitril"}, "material: received 'nitril'; did you mean nitrile?"),
        ({"material": "steel", "young_modulus": 1e7}, "young_modulus: received 10000000.0 beside material steel"),
        ({"material": {"law": "wood"}}, "material: kind 'wood': needs one of 'hookean', 'neo_hookean'"),
        ({"material": {"law": "neo_hookean", "mu": -1.0}}, "material.mu: received -1.0"),
        ({"young_modulus": 1e7, "poisson_ratio": 0.5}, "poisson_ratio 0.5: needs less than 0.5, or a material of rub"),
        ({}, "young_modulus: missing, but required"),
    ],
    ids=["both", "no_jm", "name", "beside", "wood", "negative", "half", "none"],
)
def test_what_a_material_may_not_be(changes, message):
    with pytest.raises(ConfigError, match=message):
        validated(Device, {**RUBBER, **changes}, "device")
