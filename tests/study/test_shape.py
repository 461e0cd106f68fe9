"""Buoys of other axisymmetric shapes: spheroid, capsule, profile."""

import math

import pytest
from conftest import SEED

from vsb.errors import ConfigError
from vsb.study.device import Shape
from vsb.study.plan import StudyPlan
from vsb.study.reading import read_yaml
from vsb.study.study import parse

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
    assert StudyPlan.of(raw({"profile": "hull.csv"}), str(tmp_path / "study.yaml")).study == found
    assert parse(raw({"profile": points})) == found


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, r"device.shape.profile: received hull.csv, which cannot be read \(No such file"),
        ("x,z\n0,1\nup,0.5\n", "received 'up,0.5' in hull.csv, needs two numbers x,z"),
        ("0,1\n1,0,3\n", "received '1,0,3' in hull.csv, needs two numbers x,z"),
        (f"0,1\n{50 * 'u'},0.5\n", f"received '{40 * 'u'}' in hull.csv, needs two numbers x,z"),
        ("0,1\n1,0\n0,-1\n", "shape.profile: received 3 points; needs at least five"),
    ],
)
def test_errors_of_a_profile_file(tmp_path, text, message):
    if text is not None:
        (tmp_path / "hull.csv").write_text(text)
    with pytest.raises(ConfigError, match=message) as refused:
        parse(raw({"profile": "hull.csv"}), source=str(tmp_path / "study.yaml"))
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith(str(tmp_path / "study.yaml"))


@pytest.mark.parametrize(
    ("shape", "changes", "message"),
    [({}, {}, "received none: needs one of spheroid, capsule and profile"),
        ({**OBLATE, "capsule": {"length": 1.0}}, {}, "received spheroid and capsule: needs one of"),
        ({"spheroid": {"height": 50.0}}, {}, r"shape.spheroid: received a height of 12.5 diameters, needs 0.1 to 10"),
        ({"spheroid": {"height": 0.5}}, {"device": {"thickness": 0.01}}, "a tenth of the shape's least radius of curv"),
        (OBLATE, {"device": {"mass": 1e6}}, "the buoy would sink; needs less than 25761"),
        (OBLATE, {"hydro": {"model": "auto"}}, "hydro.model 'auto': is known of the sphere alone"),
        (OBLATE, {"hydro": {"model": "assumed_pressure", "pressure": 1e3}}, "'assumed_pressure': is known of the sph"),
        (OBLATE, {"hydro": {"solver": "panels"}}, "hydro.solver: panels are those of the sphere"),
        (OBLATE, {"modes": {"basis": "membrane", "degree": 3}}, "modes.basis 'membrane': modes of another shape"),
        (OBLATE, {"modes": {"basis": "full", "degree": 0}}, "modes.degree 0: device.shape needs at least 1"),
        (OBLATE, {"device": {"internal_pressure": 1e4}}, "prestress and buckling are known of the sphere alone"),
        (OBLATE, {"device": {"gas": {}}}, "prestress and buckling are known of the sphere alone"),
        (OBLATE, {"reference_shape": "equilibrium"}, "prestress and buckling are known of the sphere alone"),
        (OBLATE, {"motion": "planar", "device": {"centre_of_mass": -0.3, "ballast_inertia": 8e3}},
         "motion 'planar': is known of the sphere alone; device.shape needs heave")],
)  # fmt: skip
def test_unsupported_combinations_are_refused(shape, changes, message):
    with pytest.raises(ConfigError, match=message):
        parse(raw(shape, **changes))


@pytest.mark.parametrize(
    ("key", "size", "limit", "inwards"),
    [("spheroid", "height", 0.4, 1.001), ("spheroid", "height", 40.0, 0.999), ("capsule", "length", 36.0, 0.999)],
)
def test_height_is_a_tenth_to_ten_diameters(key, size, limit, inwards):
    """At a radius of 2 m; a capsule has two caps beside its length."""
    caps = 4.0 if key == "capsule" else 0.0
    found = Shape(**{key: {size: limit * inwards}}).meridian(2.0)
    assert found.highest - found.lowest == pytest.approx(limit * inwards + caps, rel=1e-9)
    across = (limit / inwards + caps) / 4.0
    with pytest.raises(ValueError, match="needs") as refused:
        Shape(**{key: {size: limit / inwards}}).meridian(2.0)
    assert str(refused.value) == f"shape.{key}: received a height of {across:.4g} diameters, needs 0.1 to 10"
