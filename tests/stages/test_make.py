import re
from contextlib import contextmanager
from pathlib import Path

import pytest
from conftest import HERE, SEED, varied

from vsb.stages import make as stage_make
from vsb.stages.make import Job, due, jobs, make, solve
from vsb.stages.stage import STAGES
from vsb.study import study as config
from vsb.study.body import BodyStudy
from vsb.study.body_plan import BodyPlan, plan_for
from vsb.study.plan import StudyPlan
from vsb.study.reading import validated
from vsb.study.study import content_id

STUDIES = {
    "spectral": {},
    "without witness": {"hydro": {"witness": "none"}},
    "panels": {"hydro": {"rows": 16, "omega_max": 5.0, "omega": (1.0, 2.0)}},
    "shallow": {"water": {"depth": 2.02}},
    "assumed pressure": {"hydro": {"model": "assumed_pressure", "pressure": 1800.0}},
}


@pytest.fixture(params=STUDIES)
def plan(request, tmp_path):
    return StudyPlan(varied(config.load(SEED), **STUDIES[request.param]), root=str(tmp_path))


def test_jobs_make_all_products_each_once_after_what_it_needs(plan):
    made = []
    for job in jobs(plan):
        assert set(job.needs) <= set(made), job.stage
        made += job.makes
    assert len(made) == len(set(made))
    assert set(plan.products) <= set(made)
    assert set(made) - set(plan.ids) <= {f"{plan.green_folder}.done"}


def test_a_job_hands_over_all_that_its_stage_asks_for_and_nothing_else(plan):
    stages = {stage.name: stage for stage in STAGES}
    for job in jobs(plan):
        stage = stages[job.stage]
        assert set(stage.files) <= set(job.files) <= {*stage.files, *stage.optional}, job.stage
        assert (job.spec is None) == (stage.spec is None), job.stage


def test_every_block_of_panels_is_solved_on_its_own_mesh(tmp_path):
    """Lids are finer at high frequencies: the blocks of one study have several meshes."""
    plan = StudyPlan(varied(config.load(SEED), **STUDIES["shallow"]), root=str(tmp_path))
    panels = [job for job in jobs(plan) if job.stage == "panels"]
    assert len({job.files["mesh"] for job in panels}) > 1
    for job in panels:
        assert job.files["mesh"] == plan.mesh_path(job.spec.mesh)
        assert job.files["mesh"] in job.needs


def test_every_rule_of_the_workflow_is_a_job_of_some_study(tmp_path):
    files = (HERE.parent / "workflow" / "rules").glob("*.smk")
    rules = "".join(path.read_text() for path in files if path.stem != "campaign")
    plans = [StudyPlan(varied(config.load(SEED), **changes)) for changes in STUDIES.values()]
    body = {"file": {"body": "raft", "mesh": "-", "modes": "-", "omega": [0.5, 1.0]}}
    raft = {"study": "raft", "body": body, "designs": {"a": {}}, "waves": [{"kind": "still"}]}
    raft["pto"] = {"damping": 1.0}
    plans.append(plan_for(validated(BodyStudy, raft, "raft.yaml")))
    assert {job.stage for plan in plans for job in jobs(plan)} == set(re.findall(r"^rule (\w+):", rules, re.MULTILINE))


@pytest.mark.parametrize(("name", "before"), [("spectral", []), ("panels", ["green", "mesh"])])
def test_a_shape_is_solved_without_the_rest_of_its_study(name, before, tmp_path, monkeypatch):
    """Neither its second solver nor its answers; and nothing once it is there."""
    plan, ran = StudyPlan(varied(config.load(SEED), **STUDIES[name]), root=str(tmp_path)), []

    def run(job):
        ran.append(job.stage)
        for path in map(Path, job.makes):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()

    monkeypatch.setattr(Job, "run", run)
    solve(plan)
    assert ran == [*before, *[name] * len(plan.sweep_blocks)]
    solve(plan)
    assert len(ran) == len(before) + len(plan.sweep_blocks)
    Path(plan.block_path(plan.sweep_blocks[-1])).unlink()
    solve(plan)
    assert ran[-1] == name  # what alone is missing
    assert len(ran) > len(before) + len(plan.sweep_blocks)


def test_only_what_is_missing_or_stale_and_wanted_is_due(tmp_path):
    plan = StudyPlan(varied(config.load(SEED), hydro={"witness": "none"}), root=str(tmp_path))
    ordered, targets = jobs(plan), [plan.radiation_path]
    named = [job.stage for job in due(ordered, targets)]
    assert named[-2:] == ["database", "radiation"]
    assert set(named[:-2]) == {"spectral"}
    (tmp_path / "hydro" / "db").mkdir(parents=True)
    (tmp_path / "hydro" / "db" / plan.database_path.split("/")[-1]).touch()
    assert [job.stage for job in due(ordered, targets)] == ["radiation"]
    assert [job.stage for job in due(ordered, targets, stale=[plan.database_path])] == named


@pytest.mark.parametrize(
    ("there", "stale", "wanted", "named"),
    [
        ("abc", "", "abc", []),
        ("ab", "", "abc", ["last"]),
        ("ac", "", "abc", ["first"]),
        ("bc", "", "abc", ["first"]),
        ("ac", "", "a", []),
        ("ac", "", "b", ["first"]),
        ("abc", "b", "abc", ["first"]),
        ("abc", "a", "abc", ["first"]),
        ("a", "", "c", ["first", "last"]),
        ("b", "", "c", ["first", "last"]),
        ("c", "", "c", []),
    ],
)
def test_a_job_is_due_if_anything_wanted_of_what_it_makes_is_missing_or_stale(tmp_path, there, stale, wanted, named):
    """Of two files of one job either may be the one that is not there; what nothing due needs may be."""
    a, b, c = (str(tmp_path / name) for name in "abc")
    ordered = [Job("first", None, {}, (a, b)), Job("last", None, {}, (c,), (b, a))]
    for name in there:
        (tmp_path / name).touch()
    found = due(ordered, [str(tmp_path / name) for name in wanted], [str(tmp_path / name) for name in stale])
    assert [job.stage for job in found] == named


@pytest.mark.parametrize(
    ("there", "stale", "made"),
    [
        ((), (), 1),
        (("a",), (), 1),
        (("b",), (), 1),
        (("a", "b"), (), 0),
        (("a", "b"), ("a",), 1),
        (("a", "b"), ("b",), 1),
    ],
)
def test_a_job_is_done_where_all_it_makes_was_made_meanwhile(tmp_path, monkeypatch, there, stale, made):
    """While it waited for another run; a part of it, or one that is stale, is not enough."""
    plan, ran = StudyPlan(config.load(SEED), root=str(tmp_path)), []
    job = Job("waits", None, {}, (str(tmp_path / "a"), str(tmp_path / "b")))
    for name in there:
        (tmp_path / name).touch()
    monkeypatch.setattr(stage_make, "due", lambda ordered, targets, stale: [job])
    monkeypatch.setattr(Job, "run", lambda self: ran.append(self.stage))
    make(plan, job.makes, [str(tmp_path / name) for name in stale])
    assert len(ran) == made


def test_stamps_of_all_that_a_study_writes_go_into_its_one_manifest(plan):
    told = {job.stage: job.files["manifest"] for job in jobs(plan) if "manifest" in job.files}
    assert set(told) >= {"display", "report"}
    assert set(told.values()) == {f"{plan.folder}/manifest.json"}


def test_a_job_needs_all_that_other_jobs_make_for_it(plan):
    """Files it is handed one by one; of folders those in them that its specification names."""
    made = {path for job in jobs(plan) for path in job.makes}
    for job in jobs(plan):
        read = {path for path in job.files.values() if path in made} - set(job.makes)
        assert read <= set(job.needs), job.stage
    needs = {job.stage: set(job.needs) for job in jobs(plan)}
    drawn = {path for job in jobs(plan) if job.stage == "figures" for path in job.makes}
    assert drawn <= needs["report"]
    if plan.study.needs_bem:
        assert needs["database"] == {plan.block_path(block) for block in plan.bem_blocks.values()}
        for stage in ("radiation", "response", "ladder"):
            assert needs[stage] == {plan.database_path}, stage
    for job in jobs(plan):
        if "green" in job.files and job.stage in ("panels", "witness"):
            assert f"{plan.green_folder}.done" in job.needs


def test_a_job_makes_what_its_own_specification_names(tmp_path):
    """Blocks, meshes and runs are many of a kind: two designs in three seas, blocks of several meshes."""
    seas = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.0, 3.0, 4.0)]
    changes = {"waves": seas, "designs": {"A": {"flexible": False}, "B": {}}, **STUDIES["shallow"]}
    plan, runs = StudyPlan(varied(config.load(SEED), **changes), root=str(tmp_path)), []
    for job in jobs(plan):
        if job.stage in ("modes", "mesh", "panels", "spectral", "deformed"):
            assert all(plan.ids[path] == content_id(job.spec) for path in job.makes if path in plan.ids), job.stage
        if job.stage == "simulate":
            (design,), (wave,) = job.spec.designs, job.spec.waves
            assert job.makes == (job.files["out"],) == (plan.trajectory_path(design, wave.label),)
            runs.append((design, wave))
    assert runs == [(design, wave) for wave in plan.study.waves for design in "AB"]
    trajectories = {plan.trajectory_path(design, wave.label) for design, wave in runs}
    assert all(trajectories <= set(job.needs) for job in jobs(plan) if job.stage in ("compare", "figures", "report"))


def test_a_body_is_made_of_all_its_files_which_it_waits_for(tmp_path):
    """By option; where it is solved by the table of the Green function, too."""
    raw = {
        "study": "raft",
        "body": {"file": {"body": "raft", "mesh": "-", "modes": "-", "omega": [0.5, 1.0]}},
        "designs": {"a": {}},
        "waves": [{"kind": "still"}],
    }
    study = validated(BodyStudy, {**raw, "pto": {"damping": 1.0}}, "raft.yaml")
    files = {"file": "raft.yaml", "mesh": "m.stl"}
    plan = BodyPlan(study, root=str(tmp_path), files=files)
    green, coefficients, *_ = jobs(plan)
    done = f"{plan.green_folder}.done"
    assert (green.stage, green.files, green.makes) == ("green", {"folder": plan.green_folder, "out": done}, (done,))
    assert coefficients.files == {**plan.sources, "out": plan.database_path}
    assert coefficients.files.items() >= files.items()
    assert coefficients.needs == ("raft.yaml", "m.stl", done)
    assert (coefficients.spec, coefficients.makes) == (plan.database, (plan.database_path,))


def test_only_what_studies_share_is_held_while_it_is_made(tmp_path, monkeypatch):
    """A study's own files are held with its folder."""
    plan, held = StudyPlan(config.load(SEED), root=str(tmp_path)), []

    @contextmanager
    def sharing(root, paths):
        held.append((root, list(paths)))
        yield []

    made = {"own": f"{plan.folder}/modes.nc", "shared": plan.database_path, "also": plan.radiation_path}
    some = [Job("one", None, {}, (made["own"],)), Job("two", None, {}, (made["shared"], made["own"], made["also"]))]
    monkeypatch.setattr(stage_make, "sharing", sharing)
    monkeypatch.setattr(stage_make, "due", lambda *_: some)
    monkeypatch.setattr(Job, "run", lambda self: None)
    make(plan, [])
    assert held == [(str(tmp_path), []), (str(tmp_path), [made["shared"], made["also"]])]
