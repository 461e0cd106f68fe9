"""Frequencies of a body on panels that are solved side by side, and the database that finds them."""

import math
from pathlib import Path

import pytest
import xarray as xr
import yaml

from vsb.engine.hydro.bodies.solution import read_study, solve
from vsb.pipeline import costs
from vsb.pipeline.graph import frequencies
from vsb.pipeline.jobs import jobs
from vsb.pipeline.plans import plan_of
from vsb.stages.coefficients import run_frequencies

HULL = {"kind": "cylinder", "radius": 3.0, "height": 6.0, "draft": 4.0, "panel": 1.5}
FILE = {
    "body": "float", "mesh": HULL, "modes": ["Heave"], "mass": "displaced", "centre_of_mass": [0.0, 0.0, -2.5],
    "radii_of_gyration": [1.8, 1.8, 2.0], "omega": [0.5, 0.8, 1.1, 1.4, 1.7],
}  # fmt: skip


def written(place, panel, **more):
    """A study of the hull in a file."""
    raw = {
        "study": "fine", "body": {"file": {**FILE, "mesh": {**HULL, "panel": panel}, **more}},
        "designs": {"rigid": {}}, "pto": {"port": {"dof": "Heave"}},
        "waves": [{"kind": "regular", "amplitude": 0.5, "period": 7.0}],
    }  # fmt: skip
    (place / "fine.yaml").write_text(yaml.safe_dump(raw))
    return str(place / "fine.yaml")


def test_long_bodies_are_shared_among_jobs_each_frequency_once(tmp_path):
    some = jobs(plan_of(written(tmp_path, 0.1)))
    apart = [job for job in some if job.rule == "frequencies"]
    asked = [omega for job in apart for task in job.tasks for omega in task.spec.omega]
    assert len(apart) > 1
    assert sorted(asked) == [*FILE["omega"], math.inf]
    (database,) = (job for job in some if job.rule == "coefficients")
    assert {path for job in apart for path in job.makes} <= {*database.needs}


@pytest.mark.parametrize(("panel", "more"), [(1.5, {}), (0.1, {"tolerance": 1e-3})])
def test_short_ones_and_adaptive_sweeps_are_one_task(tmp_path, panel, more):
    assert not [task for task in plan_of(written(tmp_path, panel, **more)).tasks if task.stage == "frequencies"]


def test_database_of_frequencies_solved_apart_is_the_same(tmp_path, monkeypatch, green_folder):
    """And solves none of them again."""
    monkeypatch.setattr(costs, "FREQUENCIES_SECONDS", 1e-3)
    (tmp_path / "body.yaml").write_text(yaml.safe_dump(FILE))
    found, written_at = {}, {}
    for name in ("apart", "at once"):
        out = tmp_path / name
        study, body = read_study(tmp_path / "body.yaml", out)
        if name == "apart":
            sources = {"folder": str(out), "green": str(green_folder)}
            for task in frequencies(study, sources, (), out):
                run_frequencies(task.spec, **task.files)
            written_at = {path: path.stat().st_mtime_ns for path in Path(out, "blocks").glob("*.nc")}
            assert len(written_at) == len(FILE["omega"]) + 1
        solve(study, body, out, green_folder)
        found[name] = xr.load_dataset(out / "float.nc")
    assert {path: path.stat().st_mtime_ns for path in written_at} == written_at
    for name, variable in found["apart"].variables.items():
        xr.testing.assert_identical(variable, found["at once"].variables[name])
