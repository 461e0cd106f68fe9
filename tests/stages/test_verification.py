"""Stage verification: time-domain runs that correct the linear power of a campaign."""

from contextlib import chdir
from dataclasses import replace

import numpy as np
import pytest
import yaml
from stages.test_invariance import barge
from stages.test_members import BASE, batches, gather, with_seas

from vsb.engine.hydro.database import save_database
from vsb.engine.motion.port import LinearPto
from vsb.pipeline.graph import BodyPlan
from vsb.pipeline.plans import plan_of
from vsb.report.campaign_answer import answer as answer_of
from vsb.report.campaign_page import head, rows, warnings
from vsb.results.campaign import with_verification
from vsb.results.verification import DesignInTime
from vsb.stages.body_preview import check
from vsb.stages.stage import run_task
from vsb.study.body import located
from vsb.tools import packed
from vsb.tools.files import load
from vsb.tools.variables import check_finite

RUNS = {"duration": 60.0, "window": [40.0, 60.0], "tolerance": 1e-4}
VERIFY = {"seas": 4, "seed": 3}
MASSES = {"device.mass": [17170.0, 17000.0]}


def members_of(plan):
    """Years of the members as they are stored."""
    stored = packed.packs(f"{plan.folder}/members")
    return [stored[one.id].read(one.id) for one in plan.members]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return with_seas(tmp_path_factory.mktemp("verified"), (0.6, 5.0), (1.0, 6.0), (1.3, 6.5), (1.6, 7.0))


def planned(folder, name="checked", vary=None, verify=None, tuning=("fixed", "one"), **sections):
    raw = {**BASE, **sections, "study": f"{name}_study", "simulation": {**BASE["simulation"], **RUNS}}
    (folder / f"{name}_study.yaml").write_text(yaml.safe_dump(raw))
    given = {"campaign": name, "study": f"{name}_study.yaml", "climate": {"spectra": "sea.txt"}, "vary": vary or {}}
    given |= {"tuning": list(tuning), "verify": verify or VERIFY}
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(given, sort_keys=False))
    with chdir(folder):
        return plan_of(f"{name}.yaml")


def simulated(plan):
    for task in plan.verifications.values():
        run_task(task)
    return [load(task.out, expected=task.id) for task in plan.verifications.values()]


def run(plan):
    batches(plan)
    found = simulated(plan)
    gather(plan)
    return found, load(plan.data_path, expected=plan.identity)


@pytest.fixture(scope="module")
def checked(folder):
    plan = planned(folder, vary=MASSES)
    with chdir(folder):
        return plan, *run(plan)


def test_corrected_power_is_the_linear_power_times_the_ratio_of_weighted_means(checked):
    """Means of N h/q over means of L h/q, by hand from what is stored."""
    _, runs, found = checked
    for i, one in enumerate(runs):
        at = found.isel(mass=i)
        ratio = (one.drawn_weight * one.run_power).mean("draw") / (one.drawn_weight * one.linear_run_power).mean("draw")
        expected = at.annual_mean_power.sel(tuning="one") * ratio
        np.testing.assert_allclose(at.body_exact_mean_power, expected, rtol=1e-9)
        assert float(np.abs(ratio - 1).max()) > 1e-2
        rigid, shell = at.body_exact_mean_power.values
        assert float(at.body_exact_gain_percent.sel(design="VSWEC")) == pytest.approx(100 * (shell / rigid - 1))


def test_gains_of_linear_theory_and_of_runs_lie_in_their_intervals(folder, checked):
    plan, runs, found = checked
    with chdir(folder):
        linear = members_of(plan)
    for i, (one, before) in enumerate(zip(runs, linear, strict=True)):
        at = found.isel(mass=i)
        for name in ("gain_percent", "gain_low", "gain_high"):
            np.testing.assert_array_equal(at[name], before[name])
            beyond = (before[name] - before.gain_percent).sel(tuning="one")  # errors of numbers, modes left out
            np.testing.assert_allclose(at[f"body_exact_{name}"], one[f"corrected_{name}"] + beyond, rtol=1e-12)
        shell = at.sel(design="VSWEC")
        assert shell.body_exact_gain_low < shell.body_exact_gain_percent < shell.body_exact_gain_high
        linear_one = shell.sel(tuning="one")
        assert linear_one.gain_low < linear_one.gain_percent < linear_one.gain_high


@pytest.mark.slow
def test_linear_runs_need_no_correction(folder):
    """But for the fitted memory and the end of the transient."""
    plan = planned(folder, "same", verify={**VERIFY, "model": "linear"})
    with chdir(folder):
        _, found = run(plan)
    assert found.in_time_mean_power.dims == ("design",)
    np.testing.assert_allclose(found.in_time_mean_power, found.annual_mean_power.sel(tuning="one"), rtol=2e-3)
    assert " by linear time-domain runs" in answer_of(found, "FSB", "one")


AT_ONCE = {"frame": "heave", "wall": {"strain": "area"}}


def test_runs_under_a_damper_matrix_absorb_what_linear_theory_expects(folder):
    """Of a year's own matrix, which couples heave with the change of area; but for memory and transient."""
    plan = planned(folder, "two", verify={**VERIFY, "model": "linear"}, tuning=("one",), pto={"ports": AT_ONCE})
    with chdir(folder):
        (found,) = simulated(plan)
    np.testing.assert_allclose(found.run_power, found.linear_run_power, rtol=5e-3)


@pytest.mark.slow
def test_runs_under_a_matrix_that_acts_on_heave_alone_are_those_of_a_damper(folder):
    """Body-exact; the seas drawn are the same."""
    alone = planned(folder, "alone", tuning=("fixed",))
    damper = alone.loaded.base.pto.damping
    pto = {"ports": AT_ONCE, "damping": [[damper, 0.0], [0.0, 0.0]]}
    matrix = planned(folder, "beside", tuning=("fixed",), pto=pto)
    with chdir(folder):
        (one,), (other,) = simulated(alone), simulated(matrix)
    np.testing.assert_allclose(other.run_power, one.run_power, rtol=1e-5)
    np.testing.assert_allclose(other.corrected_mean_power, one.corrected_mean_power, rtol=1e-5)


def test_points_whose_runs_fail_keep_their_linear_year(checked):
    """The page says which run failed; where all did it answers by linear theory."""
    plan, runs, found = checked
    said = {name: value for name, value in found.attrs.items() if not name.startswith("verif")}
    linear = found.drop_vars([name for name in found if str(name).startswith("body_exact_")]).drop_attrs()
    why = "FSB in a sea of Hs 4 m and Te 9 s: the motion cannot be followed"
    lost = [one.where(False).assign_attrs(one.attrs, failure=why) for one in runs]
    some, none = (
        with_verification(plan.campaign.spec["spec"], linear.assign_attrs(said), chosen)
        for chosen in ([lost[0], runs[1]], lost)
    )
    for ds in (some, none):
        check_finite(ds, "campaign.nc")
        assert f"Of a point whose runs failed there is linear theory alone: {why}" in warnings(ds)
        assert bool(ds.annual_mean_power.notnull().all())
    assert " by body-exact " in answer_of(some, "FSB", "one")
    assert "mass 17000" in answer_of(some, "FSB", "one")
    assert len({len(row) for row in (head(some), *rows(some))}) == 1
    assert "body-exact" not in answer_of(none, "FSB", "one")


def test_designs_that_are_not_viable_are_not_simulated(folder):
    """The seed without internal pressure buckles at its equilibrium."""
    plan = planned(folder, "lost", reference_shape="equilibrium", device={**BASE["device"], "internal_pressure": 0.0})
    with chdir(folder):
        (found,) = simulated(plan)
    assert not found.viable.any()
    assert np.isnan(found.corrected_mean_power).all()
    assert np.isnan(found.corrected_gain_low).all()


def test_designs_that_are_viable_are_simulated_in_the_water_of_all(folder):
    """A shell too soft for Hooke's law leaves the rigid buoy, whose year is that of its campaign."""
    plan = planned(folder, "rigid_alone", device={**BASE["device"], "young_modulus": 6e6})
    with chdir(folder):
        batches(plan)
        (found,) = simulated(plan)
        (linear,) = members_of(plan)
    assert linear.viable.values.tolist() == found.viable.values.tolist() == [True, False]
    runs = found.sel(design="FSB")
    ratio = (runs.drawn_weight * runs.run_power).mean() / (runs.drawn_weight * runs.linear_run_power).mean()
    year = linear.annual_mean_power.sel(design="FSB", tuning="one")
    assert float(runs.corrected_mean_power / year) == pytest.approx(float(ratio), rel=1e-9)


def test_surge_that_lasts_for_minutes_does_not_delay_records_of_heave(tmp_path):
    """A soft mooring leaves surge to radiation, which takes 870 s; the take-off of heave never sees it."""
    save_database(barge(), None, tmp_path / "barge.nc")
    raw = {"study": "raft", "body": {"database": "barge.nc", "stiffness": {"Surge": 8e5}},
           "water": {"density": 1000.0}, "designs": {"rigid": {"dofs": ["Heave", "Pitch", "Surge"]}},
           "pto": {"port": {"dof": "Heave"}, "damping": 8e5}, "waves": [{"kind": "still"}]}  # fmt: skip
    found = located(raw, str(tmp_path / "study.yaml"))
    body = check(BodyPlan(found.study, root=str(tmp_path), files=found.files)).body
    heave = np.array([float(label == "Heave") for label in body.labels])
    design = DesignInTime(body, None, None, np.eye(3), LinearPto(8e5, 0.0, heave))
    omega, ratio = replace(body, pto=design.take_off).natural_modes(np.eye(3), 1.5)
    assert (1 / (ratio * omega)).max() > 800.0
    assert design.decay_time(1.5) < 100.0
