"""Estimated CPU time and memory: measured runs of shipped files, what is left of a run, and campaigns about an equilibrium."""

import math
from dataclasses import replace

import psutil
import pytest
import yaml
from conftest import EXAMPLE, varied
from stages.test_members import with_seas

from vsb.pipeline import costs
from vsb.pipeline import jobs as schedule
from vsb.pipeline.graph import StudyPlan, Task
from vsb.pipeline.jobs import jobs
from vsb.pipeline.plans import plan_of
from vsb.stages.check import cost_lines
from vsb.study.study import load, parse

MEASURED = 6.4
"""CPU-seconds of the example in one process."""


def seconds(plan):
    """CPU time of what is left, without the start of processes."""
    return sum(task.seconds for job in schedule.left(plan) for task in job.tasks)


def test_estimate_is_within_a_factor_of_two_of_a_measured_run(tmp_path):
    plan = StudyPlan(varied(load(EXAMPLE), modes={"degree": 6}), root=str(tmp_path))
    assert MEASURED / 2 < seconds(plan) < 2 * MEASURED
    assert schedule.cost_line(plan, {}).startswith("cost         8 of 8 jobs to do: about ")


def test_what_is_there_costs_nothing(tmp_path):
    """A run that was killed goes on: only jobs whose files are missing are counted; both solvers took 3.5 s."""
    plan = StudyPlan(varied(load(EXAMPLE), modes={"degree": 9}), root=str(tmp_path))
    before = seconds(plan)
    for job in jobs(plan):
        if job.rule in ("spectral", "cross_check"):
            for path in job.makes:
                (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
                (tmp_path / path).touch()
    assert seconds(plan) < before - 3.5
    assert "6 of 8 jobs" in schedule.cost_line(plan, {})


REGULAR, IRREGULAR = {"kind": "regular", "amplitude": 0.1, "period": 3.5}, {"kind": "jonswap", "hs": 0.4, "tp": 5.0}


@pytest.mark.parametrize(
    ("degree", "height", "depth", "wave", "measured"),
    [
        (6, None, math.inf, REGULAR, 2.2),
        (30, None, math.inf, REGULAR, 4.4),
        (60, None, math.inf, REGULAR, 11.3),
        (30, None, math.inf, IRREGULAR, 19.3),
        (15, 4.4, 15.0, REGULAR, 4.5),
        (30, 4.4, math.inf, REGULAR, 5.7),
        (30, 4.4, 15.0, REGULAR, 7.0),
    ],
)
def test_shell_modes_depth_and_seas_are_counted(tmp_path, degree, height, depth, wave, measured):
    """CPU-seconds of a rigid and a free design: within a factor of two."""
    device = {"radius": 2.0, "thickness": 0.03, "young_modulus": 4e8, "poisson_ratio": 0.3, "density": 1100.0}
    device |= {"mass": 17000.0, "damping": {"beta": 1e-3}}
    device |= {"shape": {"spheroid": {"height": height}}} if height else {}
    raw = {"study": "one", "device": device, "designs": {"FSB": {"flexible": False}, "VSB": {}}, "waves": [wave]}
    raw |= {"modes": {"basis": "full", "degree": degree}, "hydro": {"witness": "none"}, "water": {"depth": depth}}
    found = seconds(StudyPlan(parse(raw), root=str(tmp_path)))
    assert measured / 2 < found < 2 * measured


def test_points_about_their_own_equilibrium_cost_their_shape_and_rest(tmp_path):
    """Measured 0.4 to 0.5 s of each, 0.1 of an undeformed shape."""
    with_seas(tmp_path, (1.0, 6.0), (2.2, 9.0))
    raw = yaml.safe_load(EXAMPLE.read_text()) | {"study": "shell", "modes": {"degree": 9}}
    given = {"campaign": "many", "study": "shell.yaml", "climate": {"spectra": "sea.txt"}}
    found = {}
    for shape in ("equilibrium", "undeformed"):
        for count in (10, 20):
            (tmp_path / "shell.yaml").write_text(yaml.safe_dump({**raw, "reference_shape": shape}))
            vary = {"device.young_modulus": {"log": [1e7, 1e8, count]}}
            (tmp_path / "many.yaml").write_text(yaml.safe_dump({**given, "vary": vary}))
            plan = replace(plan_of(str(tmp_path / "many.yaml")), root=str(tmp_path / "results"))
            found[shape, count] = sum(task.seconds for task in plan.tasks if task.stage == "members")
    assert found["equilibrium", 20] - found["equilibrium", 10] == pytest.approx(10 * 0.45, rel=0.5)
    assert found["undeformed", 20] - found["undeformed", 10] == pytest.approx(10 * 0.13, rel=0.3)


@pytest.mark.parametrize(("tuning", "seconds"), [("each", 20.0), ("one", 0.0)])
def test_damper_matrices_of_each_sea_are_counted(tmp_path, tuning, seconds):
    """Two designs; 54 and 13 CPU-seconds of three, not 7."""
    with_seas(tmp_path, (1.0, 6.0), (2.2, 9.0))
    raw = yaml.safe_load(EXAMPLE.read_text()) | {"study": "shell", "modes": {"degree": 4}}
    raw |= {"designs": {"FSB": {"flexible": False}, "VSB": {}}}
    raw |= {"pto": {"ports": {"a": "heave", "b": {"strain": "area"}}, "matrix": "full"}}
    (tmp_path / "shell.yaml").write_text(yaml.safe_dump(raw))
    given = {"campaign": "one", "study": "shell.yaml", "climate": {"spectra": "sea.txt"}, "tuning": [tuning]}
    (tmp_path / "one.yaml").write_text(yaml.safe_dump(given))
    assert plan_of(str(tmp_path / "one.yaml")).member_seconds == pytest.approx(seconds + 0.016)


def test_causal_control_costs_the_cells_and_the_band(tmp_path):
    """Two points of a small buoy at PacWave, take 72 CPU-seconds; the estimate was 21."""
    raw = {"study": "shell", "device": {"radius": 0.715, "thickness": 0.00615, "young_modulus": 3e7}}
    raw["device"] |= {"poisson_ratio": 0.29, "density": 1032.0, "mass": 763.0, "internal_pressure": 1.2e4}
    raw |= {"designs": {"FSB": {"flexible": False}, "VSB": {}}, "modes": {"basis": "full", "degree": 6}}
    raw |= {"water": {"depth": 3.63}, "waves": [{"kind": "still"}]}
    (tmp_path / "shell.yaml").write_text(yaml.safe_dump(raw))
    table = EXAMPLE.parent / "climate" / "PacWave-South_Oregon_Wave-Resource.csv"
    given = {"campaign": "two", "study": "shell.yaml", "vary": {"device.young_modulus": [3e7, 9e7]}}
    given |= {"climate": {"scatter": str(table), "spectrum": "jonswap"}, "tuning": ["causal", "damper_same_force"]}
    (tmp_path / "two.yaml").write_text(yaml.safe_dump(given))
    plan = replace(plan_of(str(tmp_path / "two.yaml")), root=str(tmp_path / "results"))
    assert 36 < sum(task.seconds for task in plan.tasks if task.stage == "members") < 144


def test_body_solved_in_parts_costs_the_planes_of_symmetry_it_has():
    """Its mesh has two, which a plan does not know: 18 CPU-seconds were estimated as 108."""
    (line,) = cost_lines(plan_of(str(EXAMPLE.parent / "hinged_barge.yaml"), "nowhere"))
    assert 9 < float(line.split("about ")[1].removesuffix(" s on one core")) < 36


def test_points_of_panels_cost_their_panels(tmp_path):
    """A campaign whose study has them was announced as if the spectral solver took 0.4 s."""
    with_seas(tmp_path, (1.0, 6.0), (2.2, 9.0))
    raw = yaml.safe_load(EXAMPLE.read_text()) | {"study": "shell", "reference_shape": "undeformed"}
    raw |= {"modes": {"degree": 6}, "hydro": {"solver": "panels", "omega_max": 6.0}}
    (tmp_path / "shell.yaml").write_text(yaml.safe_dump(raw))
    (tmp_path / "one.yaml").write_text("{campaign: one, study: shell.yaml, climate: {spectra: sea.txt}}")
    plan = replace(plan_of(str(tmp_path / "one.yaml")), root=str(tmp_path / "results"))
    (found,) = (task.seconds for task in plan.tasks if task.stage == "members")
    study = StudyPlan(parse(raw), root=str(tmp_path / "results"))
    panels = sum(task.seconds for task in study.tasks if task.stage == "panels")
    assert panels > 1.0
    assert found == pytest.approx(panels, rel=0.2)


def test_a_job_that_fills_the_memory_is_doubted():
    """22 GB on a machine of 23 GB end in the system's killer, not in a result."""
    there = psutil.virtual_memory().total / 1e9
    assert costs.memory_doubts(0.5 * there) == []
    (line,) = costs.memory_doubts(0.95 * there)
    assert line.startswith("doubt        memory: a frequency needs about")


@pytest.mark.parametrize(("value", "words"), [(7.31, "7.3 s"), (89.0, "89 s"), (250.0, "4.2 min"), (9000.0, "2.5 h")])
def test_seconds_are_as_precise_as_the_estimate(value, words):
    assert costs.plain_seconds(value) == words


@pytest.mark.parametrize(("duration", "short"), [(60.0, True), (2e5, False)])
def test_a_short_plan_does_without_snakemake(tmp_path, duration, short):
    seas = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.5, 3.0, 3.5, 4.0)]
    raw = yaml.safe_load(EXAMPLE.read_text()) | {"modes": {"degree": 6}, "waves": seas}
    raw["hydro"] = raw["hydro"] | {"model": "body_exact"}
    raw["simulation"] |= {"duration": duration, "window": [10.0, 40.0]}
    assert schedule.is_short(StudyPlan(parse(raw), root=str(tmp_path))) is short


def work(name, seconds, *needs):
    """A task that makes a file of its name."""
    return Task("modes", None, {}, (name,), needs, seconds=seconds)


@pytest.mark.parametrize(
    ("some", "cores", "count"),
    [
        ([work("a", 10.0), work("b", 10.0)], 2, 2),
        ([work("a", 10.0), work("b", 10.0)], 1, 1),
        ([work("a", 10.0), work("b", 10.0, "a")], 2, 1),
        ([work("a", 0.5), work("b", 0.5)], 2, 1),
        ([work("a", 10.0), work("b", 10.0)], 64, 2),
        ([], 2, 1),
    ],
    ids=["apart", "one core", "a chain", "short", "many cores", "nothing left"],
)
def test_processes_side_by_side_where_they_end_sooner(monkeypatch, some, cores, count):
    monkeypatch.setattr(schedule, "cores", lambda: cores)
    assert schedule.workers(some) == count


def test_longest_chains_count_what_waits():
    some = [work("a", 1.0), work("b", 2.0), work("c", 3.0, "a", "b"), work("d", 4.0, "a")]
    assert schedule.longest_chains(some) == [5.0, 5.0, 3.0, 4.0]
