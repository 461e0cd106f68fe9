"""Coefficients of a body: the small study's buoy as one, repairs, and frequencies that are solved side by side."""

import json
import math
import re
from contextlib import chdir
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import SMALL, SMALL_PLAN, error_line, tables_of

import vsb
from vsb.api.results import Results
from vsb.cli import main
from vsb.engine.hydro.bodies.solution import read_study, solve
from vsb.engine.hydro.formats.exchange import read_source
from vsb.errors import DatabaseError
from vsb.pipeline import costs
from vsb.pipeline.graph import BodyPlan, frequencies
from vsb.pipeline.jobs import jobs
from vsb.pipeline.plans import plan_of
from vsb.stages.coefficients import judged
from vsb.stages.stage import run_task
from vsb.study.body import load_body

SWELL = {"kind": "regular", "amplitude": 0.1, "period": 2.5}


def as_body(finished, **changes):
    """The small study with a body read from its database."""
    kept = {key: SMALL[key] for key in ("water", "pto", "simulation") if key in SMALL}
    designs = {"FSB": {"dofs": ["Heave"]}, "VSWEC": {"dofs": "all"}}
    made = {"study": "general", "body": {"database": str(finished / SMALL_PLAN.database.out)}, "designs": designs}
    waves = [*SMALL["waves"], {**SWELL, "direction": 0.0}]
    return {**made, "hydro": {"tolerance": 1e-3}, "waves": waves[:1], **kept, **changes}


@pytest.fixture(scope="module")
def general(finished, tmp_path_factory):
    """Results of that study."""
    folder = tmp_path_factory.mktemp("general")
    with chdir(folder):
        Path("general.yaml").write_text(yaml.safe_dump(as_body(finished)))
        found = load_body("general.yaml")
        tables_of(BodyPlan(found.study, files=found.files))
    return folder


@pytest.fixture
def both(finished, general):
    """Results by the axisymmetric chain and by the general route."""
    with chdir(finished):
        study = vsb.load("small.yaml")
    with chdir(general):
        body = load_body("general.yaml").study
    return Results(study, str(finished / "results")), Results(body, str(general / "results"))


def test_response_equals_that_of_the_axisymmetric_chain(both):
    """The two interpolate differently between solved frequencies, within the tolerance of the database."""
    own, body = both[0].response, both[1].response.isel(wave_direction=0)
    omega = [w for w in both[1].database.omega.values if w < 4.5]
    for design in ("FSB", "VSWEC"):
        for name in ("rao", "port_impedance", "port_velocity", "best_power", "matched_power", "absorbed_power"):
            a, b = (ds[name].sel(design=design).sel(omega=omega, method="nearest").values for ds in (own, body))
            assert np.abs(a - b).max() < 2e-3 * np.abs(a).max(), (design, name)
    listed, every = (ds.wet_natural_frequency.values for ds in (own, body))  # of a shell to twice the band alone
    nearest = every[np.abs(every[:, None] - listed).argmin(axis=0)]
    assert nearest == pytest.approx(listed, rel=2e-3)


def test_control_levels_equal_those_of_the_axisymmetric_chain(both):
    for own, body in zip(both[0].ladder.to_dict("records"), both[1].ladder.to_dict("records"), strict=True):
        assert [own[k] for k in ("design", "wave", "rung")] == [body[k] for k in ("design", "wave", "rung")]
        assert body["power_mean"] == pytest.approx(own["power_mean"], rel=2e-3)


def test_motion_in_time_equals_that_of_the_axisymmetric_chain(both):
    for own, body in zip(both[0].comparison.to_dict("records"), both[1].comparison.to_dict("records"), strict=True):
        for name in ("displacement_pp", "velocity_pp", "power_mean", "energy"):
            assert body[name] == pytest.approx(own[name], rel=5e-3), (own["design"], name)
        assert body["energy_residual"] < 1e-9


def test_checks_of_a_body(both):
    names = {check["name"] for check in both[1].checks.to_dict("records")}
    assert {"energy_residual", "radiation_fit", "passivity", "steepness", "transient", "hydro rank_one"} <= names
    assert not names & {"heave", "buckling", "power_limit", "witness", "modes_left_out"}
    failed = [check["name"] for check in both[1].checks.to_dict("records") if check["verdict"] == "fail"]
    assert failed == [
        check["name"]
        for check in both[0].checks.to_dict("records")
        if check["verdict"] == "fail" and check["name"] in names
    ]


def test_ids_depend_on_file_contents_not_paths(finished, general, tmp_path):
    """A copy of the file is the same body; a changed file is another one."""
    source = finished / SMALL_PLAN.database.out
    (tmp_path / "copy.nc").write_bytes(source.read_bytes())
    raw = as_body(finished, body={"database": "copy.nc"})
    (tmp_path / "copy.yaml").write_text(yaml.safe_dump(raw))
    copied = load_body(tmp_path / "copy.yaml").study
    assert (
        Results(copied).plan.file_ids.keys() == Results(load_body(general / "general.yaml").study).plan.file_ids.keys()
    )
    assert Results(copied).plan.identity == Results(load_body(general / "general.yaml").study).plan.identity
    (tmp_path / "copy.nc").write_bytes(source.read_bytes() + b" ")
    assert Results(load_body(tmp_path / "copy.yaml").study).plan.identity != Results(copied).plan.identity


def test_database_with_failed_checks_is_refused(finished, workplace, capsys):
    with xr.open_dataset(finished / SMALL_PLAN.database.out) as ds:
        dull = ds.load().assign_attrs(quality=json.dumps([
            {"name": "symmetry", "value": 1.0, "limit": 0.02, "unit": "-", "verdict": "fail", "explanation": "even"}
        ]))  # fmt: skip
    dull.attrs.pop("checksum")
    dull.to_netcdf("dull.nc")
    Path("dull.yaml").write_text(yaml.safe_dump(as_body(finished, body={"database": "dull.nc"})))
    refused = "check 'symmetry' failed: 1, needs at most 0.02 (even); use smaller"
    assert error_line(["check", "dull.yaml"], capsys).startswith(f"hydro database: {refused}")
    with pytest.raises(DatabaseError, match=re.escape(refused)):
        vsb.run(vsb.load_body("dull.yaml"))
    assert not Path("results").exists()


FORCES = ("Froude_Krylov_force", "diffraction_force")


def of_ball(name, **changes):
    """A study of a file of capytaine's, written beside it."""
    study = {
        "study": name, "body": {"database": f"{name}.nc"}, "designs": {"a": {"dofs": ["Heave", "Pitch"]}},
        "water": {"density": 1025.0, "gravity": 9.81}, "pto": {"port": {"dof": "Heave"}},
        "waves": [{"kind": "regular", "amplitude": 0.05, "period": 3.0}],
        "simulation": {"duration": 60.0, "window": [30.0, 60.0]}, **changes,
    }  # fmt: skip
    Path(f"{name}.yaml").write_text(yaml.safe_dump(study))
    return f"{name}.yaml"


@pytest.fixture
def conjugated(ball, tmp_path, monkeypatch):
    """In the current folder: sound.nc of the ball, and turned.nc whose excitation has the other sign of phase."""
    monkeypatch.chdir(tmp_path)
    with xr.open_dataset(ball) as ds:
        turned = {name: ds[name] * xr.DataArray([1.0, -1.0], dims="complex") for name in FORCES}
        ds.load().to_netcdf("sound.nc")
        ds.assign(turned).to_netcdf("turned.nc")


@pytest.mark.usefixtures("conjugated")
def test_conjugated_excitation_stops_a_study_that_keeps_no_surge(capsys):
    """Surge, which the study does not use, shows that the file's phases have the other sign."""
    for name, code in (("sound", 0), ("turned", 2)):
        assert main(["check", of_ball(name)]) == code
    assert "check 'phases' failed" in capsys.readouterr().err


@pytest.mark.usefixtures("conjugated")
def test_conjugated_excitation_is_repaired_on_request(capsys):
    """A file that was right is not conjugated: the check then fails."""
    assert main(["check", of_ball("turned", hydro={"repair": ["phases"]})]) == 0
    assert "doubt        hydro repaired phases" in capsys.readouterr().out
    assert main(["check", of_ball("sound", hydro={"repair": ["phases"]})]) == 2
    assert "check 'phases' failed" in capsys.readouterr().err
    bodies = []
    for name, repair in (("sound", []), ("turned", ["phases"])):
        plan = plan_of(of_ball(name, hydro={"repair": repair}))
        found = read_source("database", plan.files["database"], plan.study.water, 1.0)
        bodies.append(judged(plan.database.spec["source"], found).database.excitation_force)
    np.testing.assert_array_equal(*bodies)


def test_negative_damping_beyond_the_sea_is_left_out_and_told_and_stops_a_sea_that_reaches_there(
    ball, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    with xr.open_dataset(ball) as ds:
        noise = -1e-4 * ds.radiation_damping.max()
        ds.assign(radiation_damping=ds.radiation_damping.where(ds.omega < 5.2, noise)).load().to_netcdf("late.nc")
    assert main(["check", of_ball("late")]) == 0
    assert "left out: 2 frequencies outside 0.5 to 5 rad/s, where damping is negative" in capsys.readouterr().out
    short = [{"kind": "regular", "amplitude": 0.01, "period": 1.1}]
    assert main(["check", of_ball("late", waves=short)]) == 2
    assert "received a frequency of 5.712 rad/s, needs 0.5 to 5 rad/s" in capsys.readouterr().err


def test_stiffness_that_a_file_does_not_hold_is_asked_for(ball, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    with xr.open_dataset(ball) as ds:
        ds.load().drop_vars("hydrostatic_stiffness").to_netcdf("bare.nc")
    assert main(["check", of_ball("bare")]) == 2
    assert "body.stiffness: received none, and the body's files hold no hydrostatic" in capsys.readouterr().err
    given = {"database": "bare.nc", "stiffness": {"Heave": 3e4, "Pitch": 2e3}}
    assert main(["check", of_ball("bare", body=given)]) == 0


HULL = {"kind": "cylinder", "radius": 3.0, "height": 6.0, "draft": 4.0, "panel": 1.5}
CYLINDER = {
    "body": "float", "mesh": HULL, "modes": ["Heave"], "mass": "displaced", "centre_of_mass": [0.0, 0.0, -2.5],
    "radii_of_gyration": [1.8, 1.8, 2.0], "omega": [0.5, 0.9, 1.3, 1.7],
}  # fmt: skip


def hull_study(place, panel, **more):
    """A study of the hull in a file."""
    raw = {
        "study": "fine", "body": {"file": {**CYLINDER, "mesh": {**HULL, "panel": panel}, **more}},
        "designs": {"rigid": {}}, "pto": {"port": {"dof": "Heave"}},
        "waves": [{"kind": "regular", "amplitude": 0.5, "period": 7.0}],
    }  # fmt: skip
    (place / "fine.yaml").write_text(yaml.safe_dump(raw))
    return str(place / "fine.yaml")


def test_long_bodies_are_shared_among_jobs_each_frequency_once(tmp_path):
    some = jobs(plan_of(hull_study(tmp_path, 0.1)))
    apart = [job for job in some if job.rule == "frequencies"]
    asked = [omega for job in apart for task in job.tasks for omega in task.spec["omega"]]
    assert len(apart) > 1
    assert sorted(asked) == [*CYLINDER["omega"], math.inf]
    (database,) = (job for job in some if job.rule == "coefficients")
    assert {path for job in apart for path in job.makes} <= {*database.needs}


@pytest.mark.parametrize(("panel", "more"), [(1.5, {}), (0.1, {"tolerance": 1e-3})])
def test_short_ones_and_adaptive_sweeps_are_one_task(tmp_path, panel, more):
    assert not [task for task in plan_of(hull_study(tmp_path, panel, **more)).tasks if task.stage == "frequencies"]


def test_database_of_frequencies_solved_apart_is_the_same(tmp_path, monkeypatch, green_folder):
    """And solves none of them again."""
    monkeypatch.setattr(costs, "FREQUENCIES_SECONDS", 1e-3)
    (tmp_path / "body.yaml").write_text(yaml.safe_dump(CYLINDER))
    found, written_at = {}, {}
    for name in ("apart", "at once"):
        out = tmp_path / name
        study, body = read_study(tmp_path / "body.yaml", out)
        if name == "apart":
            sources = {"folder": str(out), "green": str(green_folder)}
            for task in frequencies(study, sources, (), out):
                run_task(task)
            written_at = {path: path.stat().st_mtime_ns for path in Path(out, "blocks").glob("*.nc")}
            assert len(written_at) == len(CYLINDER["omega"]) + 1
        solve(study, body, out, green_folder)
        found[name] = xr.load_dataset(out / "float.nc")
    assert {path: path.stat().st_mtime_ns for path in written_at} == written_at
    for name, variable in found["apart"].variables.items():
        xr.testing.assert_identical(variable, found["at once"].variables[name])
