"""A design problem from its file to its report, in this process; plan and content ids; errors before anything is solved."""

import csv
import json
import os
import re
import runpy
import subprocess
import sys
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
import yaml
from design.conftest import DEVICE
from stages.test_members import with_seas

import vsb
from vsb.cli import main
from vsb.design.compared import COMPETITOR, FLEXIBLE
from vsb.design.evaluation import DesignModel
from vsb.design.problem import POWER, excesses, limit_parts
from vsb.design.searched import Outcome, finer_of, problem_of
from vsb.errors import ConfigError, ConvergenceError
from vsb.pipeline.jobs import rules
from vsb.pipeline.plans import DesignPlan, plan_of
from vsb.report import design_page
from vsb.report.design_answer import answer, fronts, where_it_gains
from vsb.report.design_page import buoys_table, front_table, limits_table, power_budget_table, variables_table, warnings
from vsb.results.budget import MODES
from vsb.results.year import POWER_ENDS
from vsb.stages.check import read_climate
from vsb.stages.design import outcomes, points_of, under_limits
from vsb.stages.design_preview import check, summary
from vsb.stages.design_results import sensitivity_table
from vsb.stages.make import best_so_far
from vsb.stages.stage import run_task
from vsb.study.campaign import study_at
from vsb.study.design import PARTS, load_design
from vsb.study.study import load as load_study
from vsb.tools.commands import HOME
from vsb.tools.files import attributes, load
from vsb.tools.words import within_text

STUDY = {
    "study": "shell",
    "device": {**DEVICE, "thickness": 0.015, "young_modulus": 4e7},
    "modes": {"basis": "full", "degree": 3},
    "reference_shape": "equilibrium",
    "designs": {"FSB": {"flexible": False}, "VSWEC": {}},
    "hydro": {"omega_max": 4.0},
    "waves": [{"kind": "regular", "amplitude": 0.2, "period": 4.0}],
}
DAMPER = {"pto.damping": {"log": [1e4, 1e6]}}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = with_seas(tmp_path_factory.mktemp("design"), (1.0, 6.0), (2.2, 9.0), (3.1, 12.0))
    (place / "shell.yaml").write_text(yaml.safe_dump(STUDY))
    return place


def planned(folder, name="damper", variables=None, **changes):
    raw = {"design": name, "study": "shell.yaml", "climate": {"spectra": "sea.txt"}, "variables": variables or DAMPER}
    raw |= {"limits": {"load_factor": None, "static_strain": None}, "starts": 1} | changes
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(raw, sort_keys=False))
    return DesignPlan(plan_of(str(folder / f"{name}.yaml")).loaded, root=str(folder / "results"))


def test_sensitivity_is_the_exponent_of_a_power_law(folder):
    """Of a power in proportion to the square of the damper: 2."""
    power, damper = 700.0, np.array([3e4])
    one = Outcome(
        keys=tuple(DAMPER), start=damper, values=damper, objective=power, quantities={POWER: power},
        gradients={POWER: 2 * power / damper}, multipliers={}, kkt=0.0, violation=0.0, curvatures=(), flat=(),
        accepted=True, message="", evaluations=1, degree=None, truncation=None, margins={},
    )  # fmt: skip
    rows = sensitivity_table(planned(folder, "squared").design.spec["spec"], {FLEXIBLE: one, COMPETITOR: one})[1]
    assert [(row[1], row[-1]) for row in rows] == 2 * [("pto.damping", pytest.approx(2.0, rel=1e-12))]


def test_front_far_from_what_the_buoys_have_is_doubted(folder):
    """Static proofs do not know forces: one buoy of each search is evaluated for the cost."""
    lines = summary(planned(folder, "front", pareto={"force_rms": [1e-9, 1e4]}))
    doubts = [line for line in lines if line.startswith("doubt        pareto")]
    assert [line.partition(", and")[0] for line in doubts] == 2 * ["doubt        pareto.force_rms: received 1e-09"]


def test_ranges_whose_limits_conflict_are_refused_before_anything_is_solved(folder):
    plan = planned(folder, "film", variables={"device.thickness": [1e-6, 2e-6], **DAMPER})
    with pytest.raises(
        ConfigError, match=r"film exceeded by .*device\.thickness at its upper bound, 2e-06 \(design VSWEC"
    ):
        check(plan)


def test_best_of_all_starts_is_told_while_they_run(folder):
    plan = planned(folder, "watched", starts=2)
    assert best_so_far(plan) == ""
    for start, power in zip(plan.starts, (1030.0, 812.4), strict=True):
        log = Path(plan.root, "logs", "design_start", f"{plan.name}-{start}.log")
        log.parent.mkdir(parents=True, exist_ok=True)
        log.write_text(f"best so far: {power} W with pto.damping 5000\n")
    assert best_so_far(plan) == "best so far: 1030.0 W with pto.damping 5000"


@pytest.fixture(scope="module")
def run(folder):
    """A problem of the damper alone, whose optimum is known."""
    plan = planned(folder, pareto={"force_rms": [1e4, 2e4]}, uncertain={"device.young_modulus": 0.1})
    for task in plan.tasks:
        run_task(task)
    return plan


def rows(plan, name):
    return list(csv.DictReader(Path(plan.folder, name).read_text().splitlines()))


@pytest.mark.slow
def test_every_product_is_there_and_carries_its_id(run):
    assert all(Path(path).is_file() for path in run.products)
    assert sorted(path for task in run.tasks for path in task.makes) == sorted(run.products)
    assert {rule.stem for rule in rules(run)} == {"design_start", "design_front", "design_results"}


BUILT = {
    "variables": {"device.internal_pressure": [2e4, 8e4], "device.thickness": [0.01, 0.02]},
    "limits": {"load_factor": None, "static_strain": 0.05, "beam": 4.2},
    "uncertain": {"device.young_modulus": 0.1, "device.thickness": 0.05},
}


@pytest.mark.slow
@pytest.mark.parametrize("sigmas", [0.0, 2.0])
def test_limits_of_built_buoys_hold_with_the_probability_that_is_stated(folder, sigmas):
    """Sixty buoys with modulus and wall as they may be built, evaluated with all physics, against first derivatives."""
    plan = planned(folder, f"built{sigmas:g}", **{**BUILT, "limits": BUILT["limits"] | {"sigmas": sigmas}})
    for task in plan.tasks:
        run_task(task)
    holds, limits = vsb.open(plan.folder).facts["holds"][FLEXIBLE], plan.flexible.limits
    (found,) = outcomes(f"{plan.folder}/starts", tuple(plan.starts))
    assert found.accepted
    shares, seas = BUILT["uncertain"], read_climate(plan.climate, plan.loaded.climate_path)
    study = load_study(f"{plan.folder}/optimum.yaml")
    model = DesignModel.of(study, "VSWEC", seas, [*shares, "pto.damping"], found.degree)
    kept = 0
    for modulus, wall in 1 + np.random.default_rng(3).standard_normal((60, 2)) * [*shares.values()]:
        built = model.at([modulus * model.point[0], wall * model.point[1], model.point[2]])
        terms = zip(limit_parts(limits), excesses(built, limits), strict=True)
        kept += all(one.value + found.margins[part] <= 1e-8 for part, one in terms)
    assert kept / 60 == pytest.approx(holds["all"], abs=0.15)
    assert (kept >= 54) == bool(sigmas)


def test_the_damper_found_is_the_optimal_one_of_the_year(folder):
    """The damper as the only variable, without limits: Newton's method in the damper finds the same."""
    plan = planned(folder, "free")
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    for search, starts in ((plan.flexible, plan.starts), (plan.rigid, plan.rigid_starts)):
        (task,) = (task for task in plan.tasks if Path(task.makes[0]).stem in starts)
        run_task(task)
        (end,) = outcomes(f"{plan.folder}/starts", [*starts])
        study = load_study(folder / "shell.yaml")
        if search is plan.rigid:
            study = study.model_copy(update={"designs": {"FSB": study.designs["FSB"]}, "reference_shape": "undeformed"})
        best = DesignModel.of(study, search.design, seas, [], 3).at([])
        assert end.accepted
        assert end.point["pto.damping"] == pytest.approx(best["damping"].value, rel=1e-5)
        assert end.quantities["annual_mean_power"] == pytest.approx(best["annual_mean_power"].value, rel=1e-9)


@pytest.mark.slow
def test_fronts_meet_their_limits(run):
    for row in rows(run, "pareto.csv"):
        assert row["accepted"] == "yes"
        assert 0.96 < float(row["force_rms"]) / float(row["value"]) < 1 + 1e-7  # of the shell by what modes leave out
    power = {(row["buoy"], row["value"]): float(row["annual_mean_power"]) for row in rows(run, "pareto.csv")}
    assert power["flexible", "10000"] < power["flexible", "20000"]


@pytest.mark.slow
def test_the_best_buoys_are_studies_that_run(run):
    seas = read_climate(run.climate, run.loaded.climate_path)
    for name, buoy in (("optimum", "flexible"), ("competitor", "rigid competitor")):
        study = load_study(Path(run.folder, f"{name}.yaml"))
        design = "VSWEC" if name == "optimum" else "FSB"
        (row,) = (row for row in rows(run, "starts.csv") if row["buoy"] == buoy)
        model = DesignModel.of(study, design, seas, ["pto.damping"], 3)
        assert model.at(model.point)["annual_mean_power"].value == pytest.approx(float(row["annual_mean_power"]))
        assert [wave.label for wave in study.waves] == ["regular_A0.2_T4"]


@pytest.mark.slow
def test_every_place_states_one_power_with_one_interval(run):
    found, table = vsb.open(run.folder), rows(run, "starts.csv")
    page = Path(run.folder, "report.html").read_text()
    budget = found.power_budget
    for name, file in ((FLEXIBLE, "optimum"), (COMPETITOR, "competitor")):
        power = found.power_intervals[name]
        (start,) = (row for row in table if row["buoy"] == name)
        cells = [start[key] for key in ("annual_mean_power", "power_low", "power_high")]
        assert [float(cell) for cell in cells] == pytest.approx(power, rel=1e-9)
        text = within_text(*(f"{number / 1e3:.2f}" for number in power)) + " kW"
        assert text in found.answer
        assert text in page
        assert text in Path(run.folder, f"{file}.yaml").read_text()
        sources = budget[budget.buoy == name].set_index("source")
        assert "the year as a sample" not in sources.index  # said beside, as of a campaign's power
        assert power.low == pytest.approx(power.value + sources.low.sum(), rel=1e-5)  # one statistic alone
        assert power.high == pytest.approx(power.value + sources.high.sum(), rel=1e-5)
    assert found.power == {name: power.value for name, power in found.power_intervals.items()}


@pytest.fixture(scope="module")
def clamped(folder):
    """The same with a clamp, which all degrees of the shell answer."""
    study = shell_with(folder, "held", designs={"FSB": {"flexible": False}, "VSWEC": {"clamp": 90}})
    plan = planned(folder, "clamped", study=study)
    for task in plan.tasks:
        run_task(task)
    return plan


def campaign_of(folder, plan, file, name, **changes):
    """The campaign of a buoy found, over the seas it was found in."""
    raw = yaml.safe_load(Path(plan.folder, f"{file}.yaml").read_text()) | changes
    raw["hydro"] = raw.get("hydro", {}) | {"tolerance": 1e-4}
    (folder / f"{name}_study.yaml").write_text(yaml.safe_dump(raw | {"study": f"{name}_study"}))
    campaign = {"campaign": name, "study": f"{name}_study.yaml", "tuning": ["fixed"]}
    campaign |= {"climate": {"spectra": "sea.txt"}, "vary": {"device.mass": [raw["device"]["mass"]]}}
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(campaign))
    found = replace(plan_of(str(folder / f"{name}.yaml")), root=str(folder / "results"))
    for task in found.tasks:
        if task.stage != "campaign_report":
            run_task(task)
    year = vsb.open(found.folder).data
    return year.squeeze([dim for dim, size in year.sizes.items() if size == 1 and dim != "design"])


@pytest.mark.slow
def test_a_campaign_of_the_optimum_at_a_finer_degree_lies_within_its_numerical_errors(run, folder):
    """Another solution of the same buoy: swept water, interpolated bands, degree 12 in place of 3."""
    found = vsb.open(run.folder)
    for name, file in ((FLEXIBLE, "optimum"), (COMPETITOR, "competitor")):
        finer = campaign_of(folder, run, file, f"finer_{file}", modes={"basis": "full", "degree": 12})
        power = float(finer.annual_mean_power.sel(design=found.facts["designs"][name]))
        budget = found.power_budget
        numerical = budget[(budget.buoy == name) & budget.source.isin([MODES, "coefficients and quadrature"])]
        own = 1e-4 * power  # of the campaign itself
        assert found.power[name] + numerical.low.sum() - own <= power <= found.power[name] + numerical.high.sum() + own


@pytest.mark.slow
def test_a_clamped_design_states_one_power_with_its_campaign(clamped, folder):
    """Both with the modes of its degree and what all others do at the clamp: intervals overlap, and are as narrow."""
    found, year = vsb.open(clamped.folder), campaign_of(folder, clamped, "optimum", "of_clamped").sel(design="VSWEC")
    power, ends = found.power_intervals[FLEXIBLE], [float(year[name]) for name in POWER_ENDS]
    assert float(year.annual_mean_power) == pytest.approx(power.value, rel=1e-4)
    assert max(power.low, ends[0]) < min(power.high, ends[1])
    assert 1 / 3 < (power.high - power.low) / (ends[1] - ends[0]) < 3


@pytest.mark.slow
def test_points_of_a_front_have_power_and_gain_with_intervals(run):
    table = rows(run, "pareto.csv")
    power = {(row["buoy"], row["value"]): float(row["annual_mean_power"]) for row in table}
    for row in table:
        assert float(row["power_low"]) < float(row["annual_mean_power"]) < float(row["power_high"])
        assert re.fullmatch(
            r"the year as a sample \(-.* to \+.* W in 95 % of years like it\); linear theory", row["not_in_interval"]
        )
        if row["buoy"] == FLEXIBLE:
            over = 100 * (power[FLEXIBLE, row["value"]] / power[COMPETITOR, row["value"]] - 1)
            assert float(row["gain"]) == pytest.approx(over, rel=1e-7)
            assert float(row["low"]) < over < float(row["high"])
    page = Path(run.folder, "report.html").read_text()
    gains = [f"{float(row['gain']):+.2f} % (" for row in table if row["buoy"] == FLEXIBLE]
    assert "flexibility gains at all limits of the rms force by more than the known errors" in page
    assert all(gain in page for gain in gains)
    assert "at 10 kN" in page


def within(value, half=100.0):
    """A number with its interval."""
    return {"value": value, "low": value - half, "high": value + half}


def test_a_front_says_where_flexibility_gains():
    """By gains whose intervals lie above zero: below a limit, above one, nowhere."""

    def points(*gains):
        limits = (1e4, 2e4, 4e4)
        return [{"limit": at, "gain": within(one, 0.5)} for at, one in zip(limits, gains, strict=False)]

    assert where_it_gains("force_rms", points(2.1, 0.7, 0.0)).endswith("limited to 20 kN or less")
    assert where_it_gains("force_rms", points(0.4, 0.7, 0.8)).endswith("limited to 20 kN or more")
    assert "gains at no limit of the rms force" in where_it_gains("force_rms", points(0.1, 0.2, -2.0))
    line = fronts({"fronts": {"force_rms": {FLEXIBLE: points(2.061, 0.734, 0.0)}}})[0]
    assert line.endswith(
        "+2.06 % (+1.56 to +2.56 %) at 10 kN, +0.73 % (+0.23 to +1.23 %) at 20 kN, +0.00 % (-0.50 to +0.50 %) at 40 kN."
    )
    unproven = [{**points(2.1)[0], "gain": None}, *points(0.0, 0.7, 0.8)[1:]]
    line = fronts({"fronts": {"force_rms": {FLEXIBLE: unproven}}})[0]
    assert "limited to 20 kN and 40 kN: +0.70 %" in line
    assert line.endswith("; at 10 kN no proven optimum of both buoys.")


@pytest.mark.slow
def test_the_report_says_the_answer_first(run):
    text = Path(run.folder, "report.html").read_text()
    assert text.index("The best flexible buoy absorbs") < text.index("What to doubt:") < text.index("<figure")
    assert ">nan" not in text
    budget = rows(run, "budget.csv")
    names = [row["source"] for row in budget]
    assert names == ["modes left out", "coefficients and quadrature", "device.young_modulus"]
    assert all(float(row["low"]) <= 0 <= float(row["high"]) for row in budget)


@pytest.mark.slow
def test_results_open_in_python(run):
    found = vsb.open(run.folder)
    assert isinstance(found, vsb.BestBuoy)
    assert found.answer in Path(run.folder, "report.html").read_text() or "The best flexible buoy" in found.answer
    assert found.gain.low <= found.gain.value <= found.gain.high
    power = found.power
    assert found.gain.value == pytest.approx(100 * (power[FLEXIBLE] / power[COMPETITOR] - 1))
    assert found.data.sel(buoy=FLEXIBLE).outline_z.min() == pytest.approx(
        -float(found.data.sel(buoy=FLEXIBLE).buoy_value.sel(quantity="draft")), rel=1e-6
    )
    assert found.optimum.designs.keys() == {"FSB", "VSWEC"}
    assert {*found.competitor.designs} == {"FSB"}
    assert [*found.budget.columns] == ["source", "low", "high", "one_sided", "shared"]


@pytest.mark.slow
def test_the_example_runs_a_design_in_15_lines_and_keeps_what_is_there(run, capsys, monkeypatch):
    example = HOME / "examples" / "best_buoy.py"
    code = example.read_text(encoding="utf-8").split("import vsb\n")[1]
    assert len([line for line in code.splitlines() if line]) <= 15
    before = {path: Path(path).stat().st_mtime_ns for path in run.products}
    monkeypatch.chdir(Path(run.root).parent)
    monkeypatch.setattr(sys, "argv", ["best_buoy.py", "damper.yaml"])
    runpy.run_path(str(example))
    assert "The best flexible buoy absorbs" in capsys.readouterr().out
    assert before == {path: Path(path).stat().st_mtime_ns for path in run.products}


def test_init_writes_a_design_and_its_study(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    assert main(["init", "mine.yaml", "--design"]) == 0
    assert capsys.readouterr().out.startswith("mine_study.yaml: the study it varies")
    assert load_design("mine.yaml").problem.design == "mine"
    study, variables = Path("mine.yaml").read_text().splitlines()[2:5:2]
    assert study.startswith("study: mine_study.yaml")
    assert study.index("#") == variables.index("#")
    assert main(["init", "mine.yaml", "--design"]) == 2
    assert "mine.yaml: exists already" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["init", "other.yaml", "--design", "--radius", "3"])
    assert "received several, needs at most one of them" in capsys.readouterr().err


def test_more_starts_keep_those_there_are(folder):
    few, many = (planned(folder, "several", MANY, starts=count) for count in (2, 5))
    assert list(many.starts)[:2] == list(few.starts)
    assert list(many.rigid_starts)[:2] == list(few.rigid_starts)


def test_a_start_is_kept_under_limits_that_do_not_hold_it(folder, capsys):
    """Beam holds the buoy and draft does not: other drafts, or none, need no search, another beam does."""
    limits = {"beam": 4.15, "draft": 30.0, "static_strain": 0.9, "load_factor": 0.02}
    variables = {"device.internal_pressure": [5e3, 4e4], "device.mass": [9e3, 2.2e4]}

    def ended(**changes):
        changed = {**limits, **changes}
        plan = planned(folder, "kept", variables, limits=changed)
        for task in plan.tasks:
            if task.stage == "design_start" and task.spec["search"].flexible:
                run_task(task)
        return outcomes(f"{plan.folder}/starts", [*plan.starts])[0]

    first = ended()
    assert first.accepted
    assert "beam" in first.multipliers
    for wider in ({"draft": None}, {"load_factor": 0.01}, {"static_strain": None, "draft": 50.0}):
        kept = ended(**wider)
        assert (kept.values == first.values).all()
        assert (kept.evaluations, kept.kkt) == (first.evaluations, first.kkt)
        assert set(kept.margins) == {name for name in first.margins if wider.get(name, 0.0) is not None}
    assert kept.margins["draft"] == pytest.approx(first.margins["draft"] * 30 / 50, rel=1e-12)
    capsys.readouterr()
    moved = ended(beam=4.2)
    assert "begun where start" in capsys.readouterr().out
    assert moved.quantities["beam"] > first.quantities["beam"] + 0.03
    assert moved.accepted
    assert moved.start == pytest.approx(first.values, rel=1e-12)
    draft = first.quantities["draft"]
    for narrower in ({"draft": 0.99 * draft}, {"load_factor": 1e9}, {"mass": 1e9}, {"beam": 4.1}):
        assert under_limits(first, limits, {**limits, **narrower}) is None
    close = {**limits, "draft": 1.02 * draft}
    assert under_limits(first, limits, close)
    assert under_limits(first, limits, close, sigmas=2.0) is None


def test_a_front_asked_for_later_keeps_the_starts(folder):
    one, two = planned(folder, "later"), planned(folder, "later", pareto={"force_rms": [1e4]})
    assert [*one.starts] == [*two.starts]
    assert one.identity != two.identity
    assert [*planned(folder, "later", {"pto.damping": {"log": [1e4, 2e6]}}).starts] != [*one.starts]
    assert len(two.fronts) == 2


MANY = {"device.internal_pressure": [5e3, 4e4], "device.mass": [9e3, 2.2e4], **DAMPER}


def test_the_order_of_a_file_changes_nothing(folder):
    """Variables, limits, fronts and their values, uncertain inputs: content ids are the same."""
    sections = {
        "limits": {"beam": 4.3, "force_rms": 2e4},
        "pareto": {"beam": [4.1, 4.2], "force_rms": [1e4, 2e4]},
        "uncertain": {"device.young_modulus": 0.1, "device.thickness": 0.05},
        "competitor": {"variables": ["device.mass", "pto.damping"]},
    }

    def turned(value):
        if isinstance(value, dict):
            return {key: turned(one) for key, one in reversed(value.items())}
        return value[::-1] if isinstance(value, list) else value

    one = planned(folder, "ordered", MANY, **sections)
    other = planned(folder, "ordered", dict(reversed(MANY.items())), **turned(sections))
    assert [*one.starts, *one.rigid_starts, *one.fronts] == [*other.starts, *other.rigid_starts, *other.fronts]
    assert one.identity == other.identity


def test_ends_of_belts_and_terms_of_shapes_are_variables_where_they_may_move(folder):
    shape = {"series": {"radial": [1.0, 0.1], "axial": [0.9]}}
    study = shell_with(
        folder,
        "belted",
        pto={"port": {"strain": "hoop", "belt": [60, 120]}},
        device={**STUDY["device"], "shape": shape},
    )
    free = {"pto.port.belt.1": [100, 150], "device.shape.series.radial.1": [-0.1, 0.2], "pto.port.belt.0": [40, 80]}
    plan = planned(folder, "belts", free, study=study, competitor={"port": "heave"})
    assert [one.key for one in plan.flexible.variables] == sorted(free)
    assert [one.key for one in plan.rigid.variables] == ["device.shape.series.radial.1"]  # a rigid buoy has a shape
    at = study_at(plan.flexible.base, {"pto.port.belt.0": 45.0, "device.shape.series.radial.1": 0.05})
    assert at.pto.port.belt == (45.0, 120.0)
    assert at.device.shape.series.radial == (1.0, 0.05)
    for key, bounds, words in (
        ("pto.port.belt.0", [40, 130], "may reach pto.port.belt.1"),
        ("pto.port.between.0", [40, 80], "has no pto.port.between.0"),
        ("device.shape.series.radial.2", [0.1, 0.2], "has no device.shape.series.radial.2"),
        ("device.shape.profile.2.0", [0.1, 0.2], "needs one of"),
    ):
        with pytest.raises(ConfigError, match=re.escape(words)):
            planned(folder, "belts", {key: bounds}, study=study, competitor={"port": "heave"})


def shell_with(folder, name, **changes):
    (folder / f"{name}.yaml").write_text(yaml.safe_dump({**STUDY, "study": name, **changes}))
    return f"{name}.yaml"


def test_several_ports_have_the_matrix_that_absorbs_most_and_keep_it_as_built(folder):
    study = shell_with(folder, "ports", pto={"ports": {"h": "heave", "v": "volume"}})
    free = {"device.mass": [9e3, 2.2e4]}
    plan = planned(folder, "at_ports", free, study=study, uncertain={"device.thickness": 0.05})
    for task in plan.tasks:
        run_task(task)
    found, seas = vsb.open(plan.folder), read_climate(plan.climate, plan.loaded.climate_path)
    best, keys = found.optimum, ["device.mass", "device.thickness"]
    given = np.array(best.pto.port.damping)
    model = DesignModel.of(best, "VSWEC", seas, keys)
    again = model.at(model.point)
    assert given == pytest.approx(again.dampers, rel=1e-4)
    assert again[POWER].value == pytest.approx(found.power[FLEXIBLE], rel=1e-9)
    assert abs(again[POWER].gradient[0]) * model.point[0] < 1e-6 * found.power[FLEXIBLE]
    thickness = [one for one in found.facts["powers"][FLEXIBLE]["budget"] if one["name"] == "device.thickness"]
    slope = abs(again[POWER].gradient[1]) * model.point[1]
    assert thickness[0]["high"] == pytest.approx(1.96 * 0.05 * slope, rel=1e-5)
    assert found.competitor.pto.port.damping[1] == (0.0, 0.0)
    assert "h, v: [[" in Path(plan.folder, "report.html").read_text()


PORTS_AT_FORCE = {"ports": {"h": "heave", "r": {"colatitude": 120}}, "matrix": "diagonal"}


def test_limits_and_objectives_that_several_ports_do_not_have_are_refused(folder):
    unlike = shell_with(folder, "unlike", pto={"ports": {"h": "heave", "v": "volume"}})
    study = shell_with(folder, "forces", pto=PORTS_AT_FORCE)
    for changes, words in (
        ({"study": unlike, "limits": {"force_rms": 5e3}}, r"limits\.force_rms.*no one load"),
        ({"study": study, "limits": {"stroke_rms": 0.5}}, r"limits\.stroke_rms.*no one stroke"),
        ({"study": study, "maximise": "power_per_force"}, r"maximise.*no one load"),
        ({"study": study, "limits": {"force_rms": 5e3}, "competitor": {"port": "heave"}}, r"force_rms.*no one load"),
    ):
        with pytest.raises(ConfigError, match=words):
            planned(folder, "refused", {"device.mass": [9e3, 2.2e4]}, **changes)


@pytest.mark.slow
def test_several_ports_keep_the_force_of_all_together(folder):
    study = shell_with(folder, "at_force", pto=PORTS_AT_FORCE)
    plan = planned(folder, "at_forces", {"device.mass": [9e3, 2.2e4]}, study=study, limits={"force_rms": 5e3})
    for task in plan.tasks:
        run_task(task)
    found = vsb.open(plan.folder)
    both = (FLEXIBLE, COMPETITOR)
    assert [found.facts["quantities"][name]["force_rms"] for name in both] == [5e3, 5e3]
    assert all(found.facts["found"][name]["multipliers"]["force_rms"] > 0.5 for name in both)
    model = DesignModel.of(found.optimum, "VSWEC", read_climate(plan.climate, plan.loaded.climate_path), [])
    kept = replace(model, dampers=np.array(found.optimum.pto.port.damping)).at([])
    assert kept[POWER].value == pytest.approx(found.power[FLEXIBLE], rel=1e-6)
    assert "rms force" in Path(plan.folder, "report.html").read_text()


@pytest.mark.slow
def test_several_ports_under_causal_control_of_the_same_force(folder):
    """Causal control absorbs more than the matrix of its rms force, less than control that knows all waves."""
    study = shell_with(folder, "forces", pto={"ports": {"h": "heave", "r": {"colatitude": 120}}})
    free, changes = {"device.mass": [9e3, 2.2e4]}, {"tuning": "causal", "limits": {"force_rms": 5e3}}
    plan = planned(folder, "causal_ports", free, study=study, **changes)
    for task in plan.tasks:
        run_task(task)
    found = vsb.open(plan.folder)
    for name in (FLEXIBLE, COMPETITOR):
        levels, end = found.facts["control"]["levels"][name], found.facts["found"][name]
        assert levels["damper_same_force"] < levels["causal"] == found.power[name] < levels["future_known"]
        assert end["multipliers"]["force_rms"] > 0.5
    assert found.optimum.pto.control.force_rms == 5e3
    (end,) = outcomes(f"{plan.folder}/starts", tuple(plan.starts))
    search, seas = plan.flexible, read_climate(plan.climate, plan.loaded.climate_path)
    wider = search.model_copy(update={"limits": search.limits | {"force_rms": 5.05e3}})
    at = [problem_of(one, seas, end.degree).model.at(end.values)[POWER].value for one in (search, wider)]
    assert np.log(at[1] / at[0]) / np.log(1.01) == pytest.approx(end.multipliers["force_rms"], rel=0.01)


def test_a_take_off_within_the_shell_competes_with_a_rigid_one_in_heave(folder):
    area = {"port": {"strain": "area"}, "held": {"place": "heave"}}
    study = shell_with(folder, "area", pto=area, designs={"VSWEC": {}})
    with pytest.raises(ConfigError, match=r"competitor: {port: heave}"):
        planned(folder, "unopposed", study=study)
    against = {"study": study, "competitor": {"port": "heave"}}
    for changes, words in (
        ({"limits": {"force_rms": 1e4}}, r"limits\.force_rms.*another load"),
        ({"maximise": "gain"}, r"maximise.*another take-off"),
        ({"tuning": "causal", "limits": {"force_rms": 1e4}}, r"tuning.*ports that act with forces"),
        ({"competitor": {"port": "heave", "variables": ["pto.damping"]}}, r"competitor\.variables.*another load"),
    ):
        with pytest.raises(ConfigError) as raised:
            planned(folder, "opposed", MANY, **against | changes)
        assert re.search(words, " ".join(raised.value.mistakes))
    plan = planned(folder, "opposed", {"device.mass": [9e3, 2.2e4]}, **against)
    heave = planned(folder, "heave_alone", {"device.mass": [9e3, 2.2e4]})
    assert [one.spec["search"].base["pto"] for one in plan.rigid_starts.values()] == [{"tuning": "each"}]
    rigid = [found_by(one)[COMPETITOR][0] for one in (plan, heave)]
    assert rigid[0].quantities[POWER] == pytest.approx(rigid[1].quantities[POWER], rel=1e-12)


def test_a_port_at_a_ring_keeps_no_buoy_away_from_limits_at_rest(folder):
    """What loads a ring in waves does not load the shell at rest: its beam is as well known as with another port."""
    belt = {"port": {"strain": "hoop", "belt": [60, 120]}}
    margins = []
    for pto, competitor in ((belt, {"port": "heave"}), ({}, {})):
        study = shell_with(folder, "loaded", pto={"tuning": "one", **pto})
        free, limits = {"device.mass": [9e3, 2.2e4]}, {"beam": 4.2}
        plan = planned(folder, "loaded_at", free, study=study, competitor=competitor, limits=limits)
        seas = read_climate(plan.climate, plan.loaded.climate_path)
        of = cache(partial(problem_of, plan.flexible, seas))
        known = finer_of(plan.flexible, of, of(3).at(np.array([0.5])), 3)
        margins.append(known.margins[of(3).limit_names.index("beam")])
    assert margins[0] == pytest.approx(margins[1], rel=1e-6)
    assert margins[0] > 0


def test_the_design_optimised_of_several_is_named(folder):
    """The first by name: renamed, another would be."""
    several = {"rigid": {"flexible": False}, "b": {}, "a": {"clamp": 90}}
    (folder / "several.yaml").write_text(yaml.safe_dump({**STUDY, "study": "several", "designs": several}))
    words = "optimise: none given of the flexible designs a, b; a, the first by name, is optimised"
    assert words in planned(folder, "unnamed", study="several.yaml").loaded.notes
    assert words not in planned(folder, "unnamed", study="several.yaml", optimise="b").loaded.notes


def found_by(plan):
    """Where the starts of a problem ended, as its table says: without names of designs there are none to differ."""
    for task in plan.tasks:
        if task.stage == "design_start":
            run_task(task)
    searches = {FLEXIBLE: plan.starts, COMPETITOR: plan.rigid_starts}
    return {name: outcomes(f"{plan.folder}/starts", [*starts]) for name, starts in searches.items()}


def test_renamed_studies_designs_and_sites_change_no_number(folder):
    designs = {"a stiff one".replace(" ", "_"): {"flexible": False}, "soft": {}}
    (folder / "renamed.yaml").write_text(yaml.safe_dump({**STUDY, "study": "renamed", "designs": designs}))
    (folder / "elsewhere.txt").write_bytes((folder / "sea.txt").read_bytes())
    renamed = planned(folder, "other_name", study="renamed.yaml", climate={"spectra": "elsewhere.txt"})
    for one, other in zip(*(found_by(plan).values() for plan in (planned(folder, "one_name"), renamed)), strict=True):
        assert [end.quantities for end in one] == [end.quantities for end in other]
        assert [end.dataset.attrs for end in one] == [end.dataset.attrs for end in other]


@pytest.mark.slow
def test_limits_never_reached_change_nothing_printed(folder):
    """Nor in tables to ten digits, of which round-off changes the last of none; each has a line of its own alone."""
    limits, never = {"beam": 4.3, "force_rms": 2e4}, {"draft": 30.0, "mass": 1e6, "stroke_rms": 50.0, "surface": 1e4}
    plans = [
        planned(folder, name, MANY, limits=limits | more, uncertain={"device.young_modulus": 0.1}, pareto=front)
        for front in ({"force_rms": [1e4, 2e4]},)
        for name, more in (("reached", {}), ("unreached", never))
    ]
    for plan in plans:
        for task in plan.tasks:
            run_task(task)
    for table in ("starts.csv", "pareto.csv", "sensitivity.csv", "budget.csv", "power_budget.csv"):
        assert rows(plans[0], table) == rows(plans[1], table)
    known = [vsb.open(plan.folder) for plan in plans]
    assert known[0].answer == known[1].answer
    facts = [one.facts for one in known]
    assert answer(facts[0]) == answer(facts[1])
    for part in (warnings, buoys_table, variables_table, design_page.starts_table, power_budget_table):
        assert part(facts[0]) == part(facts[1])
    assert front_table(facts[0], "force_rms") == front_table(facts[1], "force_rms")
    names = {name.replace("_", " ").replace("stroke rms", "rms stroke") for name in never}
    assert [row for row in limits_table(facts[1])["body"] if row[0] not in names] == limits_table(facts[0])["body"]


def test_a_limit_of_the_shell_holds_no_rigid_buoy(folder):
    """Along a front of the strain at rest the competitor is the same; its front asked for a strain it does not have."""
    plan = planned(folder, "strained", pareto={"static_strain": [0.2, 0.4]})
    (front,) = (name for name, task in plan.fronts.items() if not task.spec["search"].flexible)
    for task in plan.tasks:
        if {Path(path).stem for path in task.makes} & {front, *plan.rigid_starts}:
            run_task(task)
    ends = points_of(load(f"{plan.folder}/fronts/{front}.nc"))
    rigid = [end.quantities[POWER] for _, end in ends]
    assert len(rigid) == 2
    assert rigid[0] == pytest.approx(rigid[1], rel=1e-9)


def test_errors_along_a_front_under_causal_control_are_those_of_its_own_force(folder):
    """They were those of the same buoy at the force of the best one, with several times the power."""
    changes = {"tuning": "causal", "limits": {"force_rms": 2e4}, "pareto": {"force_rms": [5e3]}}
    plan = planned(folder, "weak", {"device.mass": [9e3, 2.2e4]}, **changes)
    for task in plan.tasks:
        if task.stage != "design_report":
            run_task(task)
    for row in rows(plan, "pareto.csv"):
        power = float(row["annual_mean_power"])
        assert 0.97 * power < float(row["power_low"]) <= power <= float(row["power_high"]) < 1.03 * power


def test_gain_as_an_objective_is_over_the_rigid_twin(folder):
    plan = planned(folder, "gained", maximise="gain")
    (task,) = (task for task in plan.tasks if task.stage == "design_start" and task.spec["search"].flexible)
    run_task(task)
    (end,) = outcomes(f"{plan.folder}/starts", [*plan.starts])
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    twin = DesignModel.of(load_study(folder / "shell.yaml"), "FSB", seas, ["pto.damping"], 3).at(list(end.values))
    ratio = end.quantities["annual_mean_power"] / twin["annual_mean_power"].value
    assert end.objective == pytest.approx(ratio, rel=1e-9)


def test_a_search_keeps_to_springs_that_the_water_is_stronger_than(folder):
    """Long waves ask for a spring below zero, which away from rest is stronger than the water."""
    plan = planned(folder, "sprung", {"pto.stiffness": [-1.2e5, 1e5], **DAMPER})
    for task in plan.tasks:
        if task.stage == "design_start":
            run_task(task)
    for ends in (plan.starts, plan.rigid_starts):
        (end,) = outcomes(f"{plan.folder}/starts", [*ends])
        assert end.accepted
        parts = PARTS["spring_pull"]
        assert 0.96 < max(end.quantities[part] for part in parts) / 0.05 < 1 + 1e-7
        assert any(end.multipliers.get(part, 0.0) > 0 for part in parts)


def test_check_prints_variables_limits_and_cost(folder, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    planned(folder, "checked", {"device.radius": [1.5, 2.5], **DAMPER}, starts=3, limits={"mass": 2e4})
    assert main(["check", "checked.yaml"]) == 0
    out = capsys.readouterr().out
    assert "variable     device.radius 1.5 to 2.5 m\n" in out
    assert "variable     pto.damping 10000 to 1e+06 N s/m, by its logarithm\n" in out
    assert "jobs         6 of 6 starts to do" in out
    assert "note         variables.device.radius: no limit on beam" in out


def test_a_climate_beyond_the_frequencies_solved_is_refused(folder):
    (folder / "low.yaml").write_text(yaml.safe_dump({**STUDY, "study": "low", "hydro": {"omega_max": 1.6}}))
    with pytest.raises(ConfigError, match=r"climate: .*% of its variance lies above 1.6 rad/s, up to which the water"):
        check(planned(folder, "beyond", study="low.yaml"))


@pytest.mark.slow
def test_starts_none_of_which_rests_are_named(folder):
    """Walls of 1 to 2 mm with at most 100 Pa inside buckle before they carry their load, some 20 kPa at the keel."""
    plan = planned(folder, "limp", {"device.thickness": [1e-3, 2e-3], "device.internal_pressure": [0.0, 100.0]})
    for task in plan.tasks:
        if task.stage == "design_start":
            run_task(task)
    with pytest.raises(ConvergenceError, match="none of 1 starts found a buoy within all limits: none of 17 buoys"):
        run_task(next(task for task in plan.tasks if task.stage == "design_results"))


@pytest.mark.slow
def test_runs_in_time_of_linear_theory_say_its_own_gain(folder):
    """Both buoys in time by the linear model: the gain of the year, but for the end of the transient."""
    plan = planned(folder, "intime", verify={"seas": 4, "model": "linear"})
    for task in plan.tasks:
        if task.stage != "design_report":
            run_task(task)
    found = vsb.open(plan.folder)
    said = found.facts["verified"]
    assert said["model"] == "linear"
    assert said["value"] == pytest.approx(found.gain.value, abs=0.1)
    assert said["low"] <= said["value"] <= said["high"]
    assert "linear theory" in set(found.budget.source)
    assert found.facts["not_viable"] == ""


def test_a_buoy_that_is_not_viable_is_no_answer():
    """Its power stands below the headline, named as not valid."""
    facts = {
        "not_viable": "overstrained: 12 % at rest",
        "climate": "site",
        "powers": {FLEXIBLE: within(14e3), COMPETITOR: within(10e3)},
        "gain": {"value": 40.0, "low": 39.0, "high": 41.0},
        "found": {FLEXIBLE: {"multipliers": {}, "flat": []}},
        "holds": {FLEXIBLE: {}},
        "sigmas": 0.0,
        "take_offs": {key: {"port": "heave"} for key in (FLEXIBLE, COMPETITOR)},
    }
    said = answer(facts)
    assert said.stands[0].startswith("No valid answer yet: the best flexible buoy found is not viable (overstrained")
    assert said.below[0].startswith("Computed, but not valid: The best flexible buoy absorbs 14")


def commanded(folder, *arguments, code=0):
    """What the command of users prints, which must end with an exit code."""
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    command = [sys.executable, "-m", "vsb.cli", "run", *arguments]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == code, done.stderr + done.stdout
    return done.stdout + done.stderr


@pytest.mark.slow
def test_a_run_in_time_that_fails_is_reported_with_all_that_was_found(folder):
    """A spring of nine tenths of the waterplane's stiffness throws the buoy out of the water; the exit code says so."""
    (folder / "soft.yaml").write_text(yaml.safe_dump({**STUDY, "study": "soft", "pto": {"stiffness": -1.0e5}}))
    limits = {"load_factor": None, "static_strain": None, "spring_pull": None}
    plan = planned(folder, "thrown", study="soft.yaml", limits=limits, verify={"seas": 4, "model": "body_exact"})
    for _ in range(2):  # the second time nothing is left to do
        out = commanded(folder, "thrown.yaml", "--cores", "1", code=1)
        assert "thrown: No valid answer yet: a run in time to verify it failed (VSWEC in a sea of Hs" in out
    page = Path(plan.folder, "report.html").read_text()
    assert "Computed, but not valid: The best flexible buoy absorbs" in page
    assert "a spring below zero that drives the buoy out of the water" in page
    assert all(Path(path).is_file() for path in plan.products)


@pytest.mark.slow
def test_a_design_through_snakemake_is_resumed(folder):
    """The command of users; a start that is missing is all that is computed again before what is made of it."""
    planned(folder, "whole", starts=2)

    def run(*options):
        return commanded(folder, "whole.yaml", *options)

    out = run("--cores", "2")
    assert "whole: The best flexible buoy absorbs" in out
    assert "Nothing to be done" in run("-n")
    facts = json.loads(attributes(folder / "results" / "whole" / "design.nc")["facts"])
    assert set(facts["power"]) >= {FLEXIBLE, COMPETITOR}
    first = next((folder / "results" / "whole" / "starts").glob("*.nc"))
    first.unlink()
    assert re.search(r"^design_start(_1)? +1$", run("-n"), re.MULTILINE)  # of rigid buoys several share a job
