"""A study to begin with, at any size."""

import pytest
import yaml
from conftest import EXAMPLE

from vsb.cli import main
from vsb.errors import ConfigError
from vsb.shell.sphere import Shell, natural_frequencies
from vsb.stages.init import init, scaled
from vsb.study.study import load


def test_it_is_the_shipped_study_under_its_own_name(tmp_path, capsys):
    path = tmp_path / "my_buoy.yaml"
    assert main(["init", str(path)]) == 0
    assert f"vsb run {path}" in capsys.readouterr().out
    assert load(path) == load(EXAMPLE).model_copy(update={"study": "my_buoy"})
    assert path.read_text().count("#") == EXAMPLE.read_text().count("#")


def test_a_radius_told_is_that_of_the_study(tmp_path):
    assert main(["init", str(tmp_path / "b.yaml"), "--radius", "3.5"]) == 0
    assert load(tmp_path / "b.yaml").device.radius == 3.5


@pytest.mark.parametrize("radius", [0.02, 2.0, 8.0, 100.0])
def test_size_changes_nothing_without_dimension(tmp_path, radius):
    """By Froude: same draft over radius, frequencies times sqrt(r/g), stiffness and damping over the water's."""
    init(str(tmp_path / "b.yaml"), radius)
    found, example = load(tmp_path / "b.yaml"), load(EXAMPLE)
    assert found.device.radius == pytest.approx(radius)

    def numbers(study):
        device, water, run = study.device, study.water, study.simulation
        length, time = device.radius, (device.radius / water.gravity) ** 0.5
        (wave,) = study.waves
        return [
            study.draft / length,
            device.thickness / length,
            wave.amplitude / length,
            run.initial_velocity / length * time,
            study.hydro.omega_max * time,
            wave.omega * time,
            device.damping.beta / time,
            run.duration / time,
            run.window[0] / run.duration,
            device.internal_pressure / (water.density * water.gravity * length),
            *(natural_frequencies(Shell.of(device), 3) * time),
        ]

    assert numbers(found) == pytest.approx(numbers(example), rel=2e-5)


@pytest.mark.parametrize(
    ("name", "radius", "message"),
    [
        ("there.yaml", None, "there.yaml: exists already; give a new name"),
        ("study", None, "study: received a name without .yaml, needs one such as my_buoy.yaml"),
        ("9x.yaml", None, "9x.yaml: study: received '9x'; needs letters"),
        ("hydro.yaml", None, "hydro.yaml: study: received 'hydro'; 'hydro' is the name of a results folder"),
        ("a.yaml", float("nan"), "--radius: received nan m, needs 0.01 to 100 m"),
        ("a.yaml", 1e300, r"--radius: received 1e\+300 m, needs 0.01 to 100 m"),
        ("a.yaml", -1.0, "--radius: received -1 m"),
        ("a.yaml", 0.0, "--radius: received 0 m, needs 0.01 to 100 m"),
    ],
)
def test_what_cannot_be_begun_is_one_line_and_writes_nothing(tmp_path, monkeypatch, name, radius, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.yaml").write_text("kept")
    with pytest.raises(ConfigError, match=f"^{message}"):
        init(name, radius)
    assert [path.read_text() for path in tmp_path.iterdir()] == ["kept"]


def test_every_scaled_key_is_in_the_study():
    from vsb.stages.init import FROUDE

    keys = {
        key for section in yaml.safe_load(EXAMPLE.read_text()).values() if isinstance(section, dict) for key in section
    }
    others = {"omega", "pressure", "stiffness", "force_limit", "stroke_limit", "area"}  # of other studies
    others |= {"ballast_inertia", "centre_of_mass", "line_from", "line_to"}  # of those that surge and pitch
    others |= {"ballast_yaw_inertia", "lever", "height", "length"}  # of those that turn, of other shapes
    assert set(FROUDE) - keys == {"amplitude", "period", "alpha", "beta", *others}  # of the sea, of the shell's damping


def test_its_first_line_names_the_file_and_the_others_stay(tmp_path):
    for name in ("b.yml", "b.yaml"):
        (tmp_path / "sub").mkdir(exist_ok=True)
        init(str(tmp_path / "sub" / name))
        first, *others = (tmp_path / "sub" / name).read_text().splitlines()
        assert first == f"# A study of vsb: `vsb check {name}`, then `vsb run {name}`."
        assert others == EXAMPLE.read_text().replace("study: buoy", "study: b").splitlines()[1:]


@pytest.mark.parametrize(("radius", "inside"), [(0.01, True), (0.0099, False), (100.0, True), (100.1, False)])
def test_a_study_is_begun_from_a_hundredth_to_a_hundred_metres(tmp_path, radius, inside):
    if inside:
        init(str(tmp_path / "b.yaml"), radius)
        assert load(tmp_path / "b.yaml").device.radius == radius
    else:
        with pytest.raises(ConfigError, match=rf"^--radius: received {radius:g} m, needs 0.01 to 100 m$"):
            init(str(tmp_path / "b.yaml"), radius)


def test_numbers_of_every_form_are_scaled_to_six_digits_with_their_key_alone():
    """Negative ones, lists, exponents; not what only ends as a key does, nor words."""
    text = (
        "centre_of_mass: -0.5\nwindow: [-1.0, 2e1, 3.e-1]\nmy_mass: 7.0\nmass: 1.0  # radius 2\nperiod: 0.123456789\n"
    )
    told = "centre_of_mass: -2.0\nwindow: [-2.0, 40.0, 0.6]\nmy_mass: 7.0\nmass: 64.0  # radius 2\nperiod: 0.246914\n"
    assert scaled(text, 4.0) == told
    assert scaled("radius: 1\ndepth: 9.0\n", 1e7) == "radius: 10000000.0\ndepth: 9.0\n"
