"""Command init: a study to begin with, at any size."""

import pytest
from conftest import EXAMPLE

from vsb.cli import main
from vsb.engine.shell.shell import Shell, natural_frequencies
from vsb.errors import ConfigError
from vsb.pipeline.plans import plan_of
from vsb.stages.init import init, init_body, init_campaign
from vsb.study.study import load


def test_new_study_is_the_example_under_its_own_name(tmp_path, capsys):
    path = tmp_path / "my_buoy.yaml"
    assert main(["init", str(path)]) == 0
    assert f"vsb run {path}" in capsys.readouterr().out
    assert load(path) == load(EXAMPLE).model_copy(update={"study": "my_buoy"})
    assert path.read_text().count("#") == EXAMPLE.read_text().count("#")


@pytest.mark.parametrize("radius", [0.02, 8.0])
def test_radius_scales_the_study_by_froude_similarity(tmp_path, radius):
    """Lengths over the radius, times over sqrt(r/g), pressures over rho g r."""
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
        ("9x.yaml", None, "'9x.yaml': received '9x'; needs letters"),
        ("a\nb.yaml", None, r"'a\\nb.yaml': received 'a\\nb'; needs letters"),  # a line of YAML ended there
        ("a\\1b.yaml", None, r"'a\\\\1b.yaml': received"),  # a reference to a group in a pattern
        ("hydro.yaml", None, "hydro.yaml: study: received 'hydro'; 'hydro' is the name of a results folder"),
        ("a.yaml", float("nan"), "--radius: received nan, needs 0.01 to 100 m"),
        ("a.yaml", 101.0, "--radius: received 101.0, needs 0.01 to 100 m"),
        ("a.yaml", 0.0, "--radius: received 0.0, needs 0.01 to 100 m"),
    ],
)
def test_errors_of_init_write_nothing(tmp_path, monkeypatch, name, radius, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.yaml").write_text("kept")
    with pytest.raises(ConfigError, match=f"^{message}"):
        init(name, radius)
    assert [path.read_text() for path in tmp_path.iterdir()] == ["kept"]


def test_new_study_of_a_body_has_a_plan(tmp_path):
    path = tmp_path / "raft.yaml"
    assert main(["init", str(path), "--body"]) == 0
    plan = plan_of(str(path))
    assert (plan.name, set(plan.study.designs)) == ("raft", {"heave", "rigid"})
    with pytest.raises(ConfigError, match=r"raft\.yaml: exists already"):
        init_body(str(path))


def test_new_campaign_is_of_a_study_and_a_table_of_seas(tmp_path, monkeypatch, capsys):
    (tmp_path / "sub").mkdir()
    monkeypatch.chdir(tmp_path)
    init("buoy.yaml")
    assert main(["init", "sub/year.yaml", "--campaign", "buoy.yaml"]) == 0
    assert "sub/year_site.csv" in capsys.readouterr().out
    plan = plan_of("sub/year.yaml")
    assert (plan.name, plan.loaded.campaign.study, len(plan.members)) == ("year", "../buoy.yaml", 2)
    with pytest.raises(ConfigError, match=r"year_site\.csv: exists already; give the campaign a new name"):
        init_campaign("sub/year.yml", "buoy.yaml")
    init_body("hull.yaml")
    init_campaign("sub/hulls.yaml", "hull.yaml")
    assert plan_of("sub/hulls.yaml").loaded.campaign.study == "../hull.yaml"
    (tmp_path / "my: buoys").mkdir()
    init("my: buoys/buoy.yaml")
    assert init_campaign("one.yaml", "my: buoys/buoy.yaml") == "one_site.csv"  # a path YAML needs in quotes
    with pytest.raises(SystemExit):
        main(["init", "sub/b.yaml", "--campaign", "buoy.yaml", "--body"])


def test_check_fails_where_the_ledger_would(tmp_path, monkeypatch, capsys):
    """A shell open to constant pressure buckles under its draft; the example, which internal pressure holds, does not."""
    monkeypatch.chdir(tmp_path)  # no results of an earlier "soft" there
    init(str(tmp_path / "soft.yaml"))
    text = (tmp_path / "soft.yaml").read_text()
    soft = text.replace("internal_pressure: 16.5e3", "internal_pressure: 0.0").replace(
        "reference_shape: equilibrium", ""
    )
    (tmp_path / "soft.yaml").write_text(soft.replace("modes: {tolerance: 0.005}", "modes: {degree: 6}"))
    assert main(["check", str(tmp_path / "soft.yaml")]) == 1
    assert "\nfail         buckling" in capsys.readouterr().out
    init(str(tmp_path / "pressurised.yaml"))
    assert main(["check", str(tmp_path / "pressurised.yaml")]) == 0
