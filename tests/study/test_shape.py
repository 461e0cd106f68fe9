import math
from types import SimpleNamespace

import pytest
from conftest import SEED, varied

from vsb.errors import ConfigError
from vsb.study.campaign import read
from vsb.study.floating import centre_height, keel_depth
from vsb.study.plan import StudyPlan
from vsb.study.reading import read_yaml
from vsb.study.shape import Shape, shell_mass, with_points
from vsb.study.study import canonical, load, parse

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


@pytest.mark.parametrize("shape", [OBLATE, {"capsule": {"length": 1.0}}, {"spheroid": {"height": 6.0}}])
def test_a_draft_is_that_of_the_shape(shape):
    study = parse(raw(shape, device={"draft": 1.2}))
    assert study.draft == pytest.approx(1.2, rel=1e-9)
    meridian = study.device.meridian
    assert study.device.mass == pytest.approx(study.water.density * meridian.volume_below(meridian.keel + 1.2))
    assert keel_depth(study.device, centre_height(study.device, study.water)) == study.draft


def test_a_spheroid_of_two_radii_floats_as_the_sphere():
    ball, sphere = parse(raw({"spheroid": {"height": 4.0}}, device={"draft": 1.3})), varied(load(SEED))
    sphere = parse(raw(None, device={"draft": 1.3}))
    for name in ("draft", "centre_height", "waterline_radius", "heave_frequency"):
        assert getattr(ball, name) == pytest.approx(getattr(sphere, name), rel=1e-9), name
    assert ball.device.shell_mass == pytest.approx(sphere.device.shell_mass, rel=1e-12)


def test_a_sphere_says_nothing_of_shapes():
    sphere = parse(raw(None))
    assert '"shape"' not in canonical(sphere.device)
    assert "shape" not in StudyPlan(sphere).shape.model_dump()
    assert StudyPlan(parse(raw(OBLATE))).shape.model_dump()["shape"]["spheroid"] == {"height": 3.0}


def test_the_plan_of_a_shape_solves_meridional_displacements_too():
    plan = StudyPlan(parse(raw(OBLATE)))
    assert plan.displacements() == ("Radial0", "Radial1", "Radial2", "Radial3", *(f"Meridional{n}" for n in (1, 2, 3)))
    assert plan.mode_labels == tuple(f"Shell{i}" for i in range(1, 7))
    assert plan.coordinates == 7
    assert plan.witness is None
    rigid = StudyPlan(parse(raw(OBLATE, designs={"FSB": {"flexible": False}})))
    assert rigid.displacements() == ("Radial1", "Meridional1")


def test_a_profile_is_a_file_beside_the_study(tmp_path):
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
def test_a_profile_that_is_none_is_one_line(tmp_path, text, message):
    if text is not None:
        (tmp_path / "hull.csv").write_text(text)
    with pytest.raises(ConfigError, match=message) as refused:
        parse(raw({"profile": "hull.csv"}), source=str(tmp_path / "study.yaml"))
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith(str(tmp_path / "study.yaml"))


@pytest.mark.parametrize(
    ("shape", "changes", "message"),
    [
        ({}, {}, "received none: needs one of spheroid, capsule and profile"),
        ({**OBLATE, "capsule": {"length": 1.0}}, {}, "received spheroid and capsule: needs one of"),
        ({"spheroid": {"height": 50.0}}, {}, r"shape.spheroid: received a height of 12.5 diameters, needs 0.1 to 10"),
        ({"spheroid": {"height": 0.5}}, {"device": {"thickness": 0.01}}, "a tenth of the shape's least radius of curv"),
        (OBLATE, {"device": {"draft": 3.5}}, r"device.draft: received 3.5, needs more than 0 and less than the height"),
        (OBLATE, {"device": {"draft": True}}, "device.draft: received True"),
        (OBLATE, {"device": {"draft": "deep"}}, "device.draft: received 'deep', needs more than 0 and less than the h"),
        (OBLATE, {"device": {"draft": 0}}, "device.draft: received 0, needs more than 0 and less than the height, 3 m"),
        (OBLATE, {"device": {"mass": 1e6}}, "the buoy would sink; needs less than 25761"),
        (OBLATE, {"hydro": {"model": "auto"}}, "hydro.model 'auto': is known of the sphere alone"),
        (OBLATE, {"hydro": {"model": "assumed_pressure", "pressure": 1e3}}, "'assumed_pressure': is known of the sph"),
        (OBLATE, {"hydro": {"solver": "panels"}}, "hydro.solver: panels are those of the sphere"),
        (OBLATE, {"modes": {"basis": "membrane", "degree": 3}}, "modes.basis 'membrane': modes of another shape"),
        (OBLATE, {"modes": {"basis": "full", "degree": 0}}, "modes.degree 0: device.shape needs at least 1"),
        (OBLATE, {"device": {"internal_pressure": 1e4}}, "prestress and buckling are known of the sphere alone"),
        (OBLATE, {"device": {"internal_pressure": -1e4}}, "prestress and buckling are known of the sphere alone"),
        (OBLATE, {"device": {"gas": {}}}, "prestress and buckling are known of the sphere alone"),
        (OBLATE, {"reference_shape": "equilibrium"}, "prestress and buckling are known of the sphere alone"),
        (OBLATE, {"motion": "planar", "device": {"centre_of_mass": -0.3, "ballast_inertia": 8e3}},
         "motion 'planar': is known of the sphere alone; device.shape needs heave"),
    ],
)  # fmt: skip
def test_what_is_not_known_of_shapes_is_refused(shape, changes, message):
    with pytest.raises(ConfigError, match=message):
        parse(raw(shape, **changes))


def test_a_rigid_buoy_of_another_shape_has_no_modes_to_ask_anything_of():
    modes = {"basis": "membrane", "degree": 0}
    study = parse(raw(OBLATE, designs={"FSB": {"flexible": False}}, modes=modes))
    assert (study.modes.basis, study.modes.degree, study.flexible) == ("membrane", 0, False)


@pytest.mark.parametrize(
    ("key", "size", "limit", "inwards"),
    [("spheroid", "height", 0.4, 1.001), ("spheroid", "height", 40.0, 0.999), ("capsule", "length", 36.0, 0.999)],
)
def test_a_shape_is_a_tenth_to_ten_diameters_high(key, size, limit, inwards):
    """At a radius of 2 m; a capsule has two caps of that beside its length."""
    caps = 4.0 if key == "capsule" else 0.0
    found = Shape(**{key: {size: limit * inwards}}).meridian(2.0)
    assert found.highest - found.lowest == pytest.approx(limit * inwards + caps, rel=1e-9)
    across = (limit / inwards + caps) / 4.0
    with pytest.raises(ValueError, match="needs") as refused:
        Shape(**{key: {size: limit / inwards}}).meridian(2.0)
    assert str(refused.value) == f"shape.{key}: received a height of {across:.4g} diameters, needs 0.1 to 10"


def test_a_shell_weighs_its_area_times_its_thickness_and_density():
    """4 pi r^2 of a sphere, 2 pi a^2 (1 + c^2/(e a^2) artanh e) of an oblate spheroid, e^2 = 1 - c^2/a^2."""
    assert shell_mass(None, 2.0, 0.01, 2700.0) == pytest.approx(4 * math.pi * 4.0 * 27.0, rel=1e-14)
    e = math.sqrt(1 - (1.5 / 2) ** 2)
    area = 2 * math.pi * 4.0 * (1 + (1.5 / 2) ** 2 / e * math.atanh(e))
    meridian = Shape(**OBLATE).meridian(2.0)
    assert shell_mass(meridian, 2.0, 0.01, 2700.0) == pytest.approx(area * 27.0, rel=1e-9)


def test_points_stand_in_a_file_with_empty_lines_and_leave_what_was_given_as_it_was(tmp_path):
    (tmp_path / "hull.csv").write_text("x,z\n\n0,1\n , \n1,0.5\n")
    given = {"device": {"shape": {"profile": "hull.csv"}, "radius": 1.0}}
    found = with_points(given, str(tmp_path / "study.yaml"))
    assert found == {"device": {"shape": {"profile": [[0.0, 1.0], [1.0, 0.5]]}, "radius": 1.0}}
    assert given["device"]["shape"]["profile"] == "hull.csv"
    for other in ({"device": 3}, {}, [], {"device": {"shape": None}}, {"device": {"shape": {"profile": [[0, 1]]}}}):
        assert with_points(other, "study.yaml") is other


@pytest.mark.parametrize("data", [b"\xff\xfe0,1", b'0,1\n"' + b"1" * 200_000])
def test_a_profile_that_is_no_text_is_told(tmp_path, data):
    """Bytes that are no letters, a cell longer than any."""
    (tmp_path / "hull.csv").write_bytes(data)
    with pytest.raises(ConfigError) as refused:
        with_points({"device": {"shape": {"profile": "hull.csv"}}}, str(tmp_path / "study.yaml"))
    told = "device.shape.profile: received hull.csv, which cannot be read (no text); needs a CSV file"
    assert str(refused.value) == f"{tmp_path / 'study.yaml'}: {told}"


def test_a_campaign_is_of_spheres(tmp_path):
    text = SEED.read_text().replace("device:", "device: # oblate\n  shape: {spheroid: {height: 3.0}}", 1)
    (tmp_path / "study.yaml").write_text(text.replace("basis: membrane", "basis: full"))
    campaign = {"campaign": "c", "study": "study.yaml", "climate": {"spectra": "c.txt"}}
    with pytest.raises(ConfigError, match=r"received study\.yaml with device\.shape, whose buckling"):
        read(campaign, str(tmp_path / "campaign.yaml"))


def test_the_same_shape_has_the_same_meridian():
    assert Shape(spheroid={"height": 3.0}).meridian(2.0) is Shape(spheroid={"height": 3.0}).meridian(2.0)


@pytest.mark.parametrize("model", ["linear", "body_exact"])
def test_models_that_know_the_meridian_know_every_shape(model):
    assert parse(raw(OBLATE, hydro={"model": model})).hydro.model == model


@pytest.mark.parametrize("height", [0.4, 40.0])
def test_shapes_at_their_limits_are_shapes(height):
    assert Shape(spheroid={"height": height}).meridian(2.0).highest == height / 2


def test_one_line_of_words_stands_before_the_points(tmp_path):
    """A second one is a mistake."""
    (tmp_path / "egg.csv").write_text("x,z\nm,m\n0,1\n")
    with pytest.raises(ConfigError, match=r"device.shape.profile: received 'm,m' in egg.csv, needs two numbers x,z"):
        with_points({"device": {"shape": {"profile": "egg.csv"}}}, str(tmp_path / "study.yaml"))


def test_a_shape_that_is_none_is_the_only_mistake_told():
    """Not its mass, which cannot be told without it, nor a draft."""
    for more in ({}, {"draft": 1.0}):
        with pytest.raises(ConfigError) as refused:
            parse(raw({"spheroid": {"height": -1.0}}, device=more), source="here")
        assert len(refused.value.mistakes) == 1
        assert str(refused.value).startswith(
            "here: device.shape.spheroid.height: received -1.0; needs a number above 0"
        )


@pytest.mark.parametrize(("highest", "lowest", "taken"), [
    (0.3, -0.2, True), (0.2, -0.19, False), (19.0, -21.0, True), (21.0, -20.0, False),
])  # fmt: skip
def test_a_profile_is_as_high_as_its_highest_place_is_above_its_lowest_wherever_its_poles_are(
    monkeypatch, highest, lowest, taken
):
    """From a tenth of the diameter to ten of them."""
    found = SimpleNamespace(highest=highest, lowest=lowest, top=0.5, keel=0.45)
    monkeypatch.setattr("vsb.study.shape.through", lambda points, radius: found)
    shape = Shape.model_validate({"profile": [[0.0, 1.0], [1.0, 0.0], [0.0, -1.0]]})
    if taken:
        assert shape.meridian(2.0) is found
        return
    told = rf"shape.profile: received a height of {(highest - lowest) / 4:.4g} diameters, needs 0.1 to 10"
    with pytest.raises(ValueError, match=told):
        shape.meridian(2.0)


@pytest.mark.parametrize("words", ["", "x,z\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_a_profile_has_all_of_its_points_whatever_mark_its_file_begins_with(tmp_path, mark, words):
    """As spreadsheets write it: the first row is no line of words for the mark before it."""
    (tmp_path / "hull.csv").write_text(f"{mark}{words}0,1\n1,0.5\n", encoding="utf-8")
    found = with_points({"device": {"shape": {"profile": "hull.csv"}}}, str(tmp_path / "study.yaml"))
    assert found["device"]["shape"]["profile"] == [[0.0, 1.0], [1.0, 0.5]]
