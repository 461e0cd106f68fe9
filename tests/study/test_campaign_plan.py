"""Members and batches of a campaign: content ids, batches from the file alone, a sweep widened."""

import itertools

import pytest
import yaml
from conftest import SEED

from vsb.errors import ConfigError
from vsb.study.campaign_plan import MOST_BATCHES, CampaignPlan, figure_names, plan_of
from vsb.study.campaign_plan import planned as plan_as_run
from vsb.study.plan import StudyPlan
from vsb.study.study import content_id


@pytest.fixture
def planned(tmp_path):
    (tmp_path / "seed.yaml").write_text(SEED.read_text())
    (tmp_path / "sea.txt").write_text("spectra")

    def plan(vary=None, name="sweep", study=None, **changes):
        if study:
            raw = yaml.safe_load(SEED.read_text())
            for section, update in study.items():
                raw[section] = {**raw[section], **update} if isinstance(update, dict) else update
            (tmp_path / "seed.yaml").write_text(yaml.safe_dump(raw))
        raw = {"campaign": name, "study": "seed.yaml", "climate": {"spectra": "sea.txt"}, "vary": vary or {}, **changes}
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(raw))
        return plan_of(str(tmp_path / f"{name}.yaml"))

    return plan


def ids(plan):
    return [one.id for one in plan.members]


def test_members_do_not_know_what_a_year_does_not_depend_on(planned):
    before = ids(planned({"device.mass": [16000.0, 17000.0]}))
    other = planned(
        {"device.mass": [17000.0, 16000.0]},
        name="other",
        study={"study": "renamed", "waves": [{"kind": "still"}], "simulation": {"duration": 100.0}},
    )
    assert set(ids(other)) == set(before)


@pytest.mark.parametrize(
    "study",
    [
        {"device": {"density": 2600.0}},
        {"modes": {"degree": 5}},
        {"water": {"gravity": 9.8}},
        {"pto": {"damping": 1.0}},
        {"hydro": {"tolerance": 1e-4}},
        {"designs": {"NEW": {"clamp": 45.0}}},
        {"reference_shape": "equilibrium"},
    ],
)
def test_members_know_what_a_year_depends_on(planned, study):
    before = ids(planned())
    assert ids(planned(study={"reference_shape": "undeformed", **study})) != before


def test_members_know_climate_and_tuning(planned, tmp_path):
    before = ids(planned())
    assert ids(planned(tuning=["each"])) != before
    table = ids(planned(climate={"scatter": "sea.txt"}))
    assert table != before
    assert ids(planned(climate={"scatter": "sea.txt", "gamma": 1.0})) != table
    (tmp_path / "sea.txt").write_text("others")
    assert ids(planned()) != before


def test_a_form_without_a_peak_factor_is_the_same_climate_whatever_it_is(planned):
    found = [
        planned(climate={"scatter": "sea.txt", "spectrum": form, "gamma": gamma}).climate
        for form in ("pierson_moskowitz", "jonswap")
        for gamma in (1.0, 5.0)
    ]
    assert [(one.form, one.gamma) for one in found] == [
        ("pierson_moskowitz", None),
        ("pierson_moskowitz", None),
        ("jonswap", 1.0),
        ("jonswap", 5.0),
    ]


def test_a_widened_sweep_keeps_its_members(planned):
    narrow = planned({"device.young_modulus": {"log": [1e6, 1e9, 4]}})
    wide = planned({"device.young_modulus": {"log": [1e6, 1e10, 5]}, "device.thickness": [0.01, 0.02]})
    assert set(ids(narrow)) < set(ids(wide))


def test_all_materials_and_clamps_of_a_sphere_share_its_water(planned):
    vary = {"device.young_modulus": [1e6, 1e9], "device.thickness": [0.01, 0.02], "designs.VSWEC0.clamp": [0.0, 45.0]}
    sphere = planned(vary)
    assert {one.spec.sweep for one in sphere.members} == {
        tuple(content_id(block) for block in StudyPlan(sphere.loaded.base).sweep_blocks)
    }
    assert len({one.spec.sweep for one in planned({**vary, "device.mass": [16000.0, 17000.0]}).members}) == 2
    deformed = planned(vary, study={"reference_shape": "equilibrium"})
    assert len({one.spec.sweep for one in deformed.members}) == 4  # clamps are of designs, not of the shape at rest


def test_batches_follow_from_the_file_alone(planned, tmp_path, monkeypatch):
    vary = {"device.young_modulus": {"log": [1e6, 1e9, 40]}, "device.thickness": {"linear": [0.01, 0.1, 25]}}
    plan = planned(vary)
    batches = {name: [str(point) for point in spec.points] for name, spec in plan.batches.items()}
    monkeypatch.chdir(tmp_path)
    again = CampaignPlan(plan.loaded, root="elsewhere")
    assert {name: [str(point) for point in spec.points] for name, spec in again.batches.items()} == batches
    assert sorted(itertools.chain(*batches.values())) == sorted(str(one.point) for one in plan.members)
    assert len(set(ids(plan))) == 1000
    thicknesses = [{point["device.thickness"] for point in spec.points} for spec in plan.batches.values()]
    assert len(thicknesses) == 3
    assert sum(map(len, thicknesses)) <= 25 + 2  # shapes and buckling of each are computed in one batch, or in two


@pytest.mark.parametrize(
    ("key", "count", "jobs"),
    [
        ("young_modulus", 1, 1),
        ("young_modulus", 374, 1),  # 2 s of one shape and 16 ms of each: just below 8 s
        ("young_modulus", 376, 2),
        ("mass", 3, 1),  # each another shape under water
        ("mass", 4, 2),
        ("mass", 40, 11),
        ("mass", 150, MOST_BATCHES),
    ],
)
def test_many_points_are_few_jobs(planned, key, count, jobs):
    lowest = {"young_modulus": 1e6, "mass": 1e4}[key]
    plan = planned({f"device.{key}": {"linear": [lowest, 2 * lowest, count]}})
    assert len(plan.batches) == jobs
    assert sum(len(spec.points) for spec in plan.batches.values()) == count


def test_a_batch_is_named_by_its_members(planned):
    (name,), (other,) = (planned({"device.mass": [mass]}).batches for mass in (16000.0, 17000.0))
    assert name != other == next(iter(planned({"device.mass": [17000.0]}, name="other").batches))


def test_points_without_a_study_are_told_with_the_file(planned):
    with pytest.raises(ConfigError, match=r"sweep.yaml: vary: with device.thickness: 1.0: device: thickness 1 m"):
        _ = planned({"device.thickness": [0.01, 1.0]}).members


def test_a_study_file_is_a_study(planned, tmp_path):
    planned()
    assert plan_of(str(tmp_path / "seed.yaml")).name == "seed"


def test_every_product_has_an_id(planned):
    """Batches and runs in time their own, all else that of the campaign."""
    plan = planned({"device.mass": [1.2e4, 1.4e4, 1.6e4, 1.7e4]}, verify={})
    assert set(plan.ids) == set(plan.products)
    assert not any(map(plan.is_shared, plan.products))
    assert (len(plan.batches), len(plan.verifications)) == (2, 4)
    own = {f"results/sweep/batches/{one}.nc": one for one in plan.batches}
    own |= {f"results/sweep/verification/{one}.nc": one for one in plan.verifications}
    assert plan.ids == dict.fromkeys(plan.products, plan.campaign_id) | own
    assert len({*own.values(), plan.campaign_id}) == 7


def test_results_lie_where_a_run_has_them_lie(planned, tmp_path, monkeypatch):
    """Its folder travels among the keys of the file, of which it is none."""
    monkeypatch.chdir(tmp_path)
    planned()
    for name in ("sweep", "seed"):
        raw = yaml.safe_load((tmp_path / f"{name}.yaml").read_text())
        here, there = (plan_as_run({**raw, **root}, f"{name}.yaml") for root in ({}, {"root": "elsewhere"}))
        assert (here.folder, there.folder) == (f"results/{name}", f"elsewhere/{name}")
        assert list(there.ids.values()) == list(here.ids.values())
    raw = yaml.safe_load((tmp_path / "seed.yaml").read_text())
    with pytest.raises(ConfigError, match=r"^seed.yaml: device: missing"):
        plan_as_run({key: value for key, value in raw.items() if key != "device"}, "seed.yaml")


def verified(planned, name="sweep", study=None, **changes):
    """Ids of the runs in time of a campaign."""
    given = {"verify": {"seas": 4}, **changes}
    return list(planned({"device.mass": [16000.0, 17000.0]}, name=name, study=study, **given).verifications)


def test_runs_in_time_know_what_they_depend_on(planned):
    before = verified(planned)
    assert len(set(before)) == 2
    assert verified(planned, name="other", study={"study": "renamed"}, tuning=["each", "one"]) == before
    for changes in ({"verify": {"seas": 6}}, {"verify": {"seas": 4, "seed": 2}}, {"tuning": ["each", "fixed"]}):
        assert not set(verified(planned, **changes)) & set(before)
    linear = planned({"device.mass": [16000.0, 17000.0]}, verify={"seas": 4, "model": "linear"})
    assert {spec.hydro.model for spec in linear.verifications.values()} == {"linear"}
    assert not set(linear.verifications) & set(before)
    members = ids(linear)
    assert verified(planned, study={"simulation": {"duration": 100.0}}) == before  # how long follows from the seas
    assert not set(verified(planned, study={"simulation": {"tolerance": 1e-5}})) & set(before)
    assert ids(planned({"device.mass": [16000.0, 17000.0]})) == members


def test_a_campaign_without_verify_has_the_id_it_had(planned):
    plan = planned()
    assert "verifications" not in plan.campaign.model_dump()
    assert plan.verification_paths == []
    assert planned(verify={"seas": 4}).campaign_id != plan.campaign_id


def test_a_run_in_time_its_study_cannot_have_is_told_with_the_file(planned):
    plan = planned(verify={"seas": 4}, study={"simulation": {"method": "exact"}})
    with pytest.raises(ConfigError, match=r"sweep.yaml: verify: .*simulation.method 'exact': hydro.model 'body_exact'"):
        _ = plan.verifications


LIMITS = {"pto.force_limit": [1e4, 2e4]}


@pytest.mark.parametrize(
    ("vary", "changes", "blind"),
    [
        (LIMITS, {"tuning": ["one"]}, "one"),
        (LIMITS, {}, "fixed"),
        (LIMITS, {"tuning": ["one", "constrained"]}, "one"),
        (LIMITS, {"tuning": ["one", "each", "constrained"], "verify": {}}, "each"),
        ({"pto.stroke_limit": [1.0, 2.0]}, {"tuning": ["each"]}, "each"),
        ({}, {"study": {"pto": {"law": "latching"}}, "tuning": ["fixed"]}, "fixed"),
    ],
)
def test_what_linear_theory_does_not_see_is_not_told(planned, vary, changes, blind):
    """Limits and laws need runs in time, or optima that know the limits."""
    expected = rf"sweep\.yaml: vary: with .*: pto: received law .* linear theory of tuning {blind} does not see; needs"
    with pytest.raises(ConfigError, match=expected):
        planned(vary, **changes).members  # noqa: B018


@pytest.mark.parametrize(
    "changes",
    [{"tuning": ["constrained"]}, {"tuning": ["one", "constrained"], "verify": {}}, {"tuning": ["one"], "verify": {}}],
)
def test_limits_are_varied_where_they_are_seen(planned, changes):
    plan = planned(LIMITS, **changes)
    assert [one.study.pto.force_limit for one in plan.members] == [1e4, 2e4]
    assert plan.member_seconds == pytest.approx(40.016 if "constrained" in changes["tuning"] else 0.016)


def test_optima_have_batches_of_their_own_and_one_limit_each(planned):
    """Four designs of ten seconds are no work of milliseconds; what batches share of a rigid design, they keep."""
    vary = {"device.young_modulus": [float(i) * 1e7 for i in range(1, 21)], **LIMITS}
    plan = planned(vary, tuning=["constrained"])
    assert len(plan.batches) == MOST_BATCHES
    limits = [{point["pto.force_limit"] for point in batch.points} for batch in plan.batches.values()]
    assert sum(len(one) == 1 for one in limits) >= MOST_BATCHES - 1


def test_no_batch_is_empty_however_long_a_member_takes(planned):
    for count in (1, 3):
        vary = {"device.mass": [1.6e4, 1.65e4, 1.7e4][:count]}
        plan = planned(vary, tuning=["constrained"], constrained={"seconds": 3600})
        assert [len(batch.points) for batch in plan.batches.values()] == [1] * count


def test_optima_are_of_their_budget_and_their_waves(planned):
    """A member within limits is another one for every budget and seed; a member under dampers knows neither."""
    found = [
        ids(planned(LIMITS, tuning=["constrained"], constrained=given)) for given in ({}, {"seconds": 5}, {"seed": 2})
    ]
    assert len({tuple(one) for one in found}) == 3
    assert planned({}).members[0].spec.constrained is None


def test_curves_over_dampers_are_of_take_offs_without_limits(planned):
    assert "tuned_power" in figure_names(planned({}).campaign)
    assert "tuned_power" not in figure_names(planned(LIMITS, tuning=["constrained"]).campaign)
    limited = planned({}, name="own", study={"pto": {"force_limit": 1e4}}, tuning=["constrained"])
    assert "tuned_power" not in figure_names(limited.campaign)


RADII = {"device.radius": [2.0, 3.0]}


def test_a_mass_that_would_stay_behind_is_refused(planned):
    expected = (
        r"sweep.yaml: vary: device.radius: received with device.mass 17170 as given in seed.yaml, with which other"
    )
    with pytest.raises(ConfigError, match=expected):
        planned(RADII)
    both = planned(RADII | {"device.mass": [17170.0, 57950.0], "pairs": True})
    assert [one.study.device.mass for one in both.members] == [17170.0, 57950.0]


def test_what_floats_by_its_draft_or_half_immersed_follows_the_radius(planned, tmp_path):
    """As the file says it: half immersion at every radius and density, or the draft in metres."""
    raw = yaml.safe_load(SEED.read_text())
    del raw["device"]["mass"]
    (tmp_path / "seed.yaml").write_text(yaml.safe_dump(raw))
    for one in planned(RADII).members:
        assert one.study.draft == pytest.approx(one.study.device.radius, rel=1e-9)
    for one in planned({"water.density": [1000.0, 1025.0]}).members:
        assert one.study.draft == pytest.approx(2.0, rel=1e-9)
    raw["device"]["draft"] = 1.8
    (tmp_path / "seed.yaml").write_text(yaml.safe_dump(raw))
    for one in planned(RADII).members:
        assert one.study.draft == pytest.approx(1.8, rel=1e-9)
    assert [one.study.draft for one in planned({"device.draft": [1.5, 2.2]}).members] == pytest.approx([1.5, 2.2])
    with pytest.raises(ConfigError, match=r"received with device.draft 1.8 as given"):
        planned(RADII | {"scale": [1.0, 2.0]})
    both = planned(RADII | {"scale": [1.0, 2.0], "device.draft": [1.5]})
    assert [one.study.draft for one in both.members] == pytest.approx([1.5] * 4, rel=1e-9)


@pytest.mark.parametrize(("flexible", "shapes"), [(True, 3), (False, 1)])
def test_modes_are_other_displacements_of_the_water_of_flexible_designs_alone(planned, flexible, shapes):
    """Degrees 2, 3 and 4: a shape to solve for each, of a rigid buoy one for all."""
    designs = {name: {"flexible": flexible} for name in ("FSB", "VSWEC", "VSWEC0", "VSWEC90")}
    plan = planned({"modes.degree": [2, 3, 4]}, study={"designs": designs})
    assert len({member.spec.sweep for member in plan.members}) == shapes


@pytest.mark.parametrize(
    ("vary", "study"),
    [
        ({"water.density": [1000.0, 1025.0]}, {}),
        ({"water.depth": [20.0, 30.0]}, {}),
        ({"hydro.tolerance": [1e-3, 1e-4]}, {}),
        ({"modes.order": [1, 2]}, {"motion": "planar", "device": {"centre_of_mass": -0.5, "ballast_inertia": 8e3}}),
        ({"modes.basis": ["membrane", "full"]}, {"reference_shape": "equilibrium"}),
        ({"reference_shape": ["undeformed", "equilibrium"]}, {}),
        ({"device.young_modulus": [1e7, 2e7]}, {"reference_shape": "equilibrium"}),
    ],
    ids=str,
)
def test_every_member_rests_on_the_blocks_of_its_own_study(planned, vary, study):
    """Members of one shape share them: what another sweep depends on is no part of their shape."""
    found = planned(vary, study=study).members
    for one in found:
        assert one.spec.sweep == tuple(content_id(block) for block in StudyPlan(one.study).sweep_blocks)
    assert len({one.spec.sweep for one in found}) == 2


def test_a_take_off_no_tuning_sees_is_found_at_any_point(planned):
    with pytest.raises(ConfigError, match=r"vary: with pto.law: latching: pto: received law latching, .* tuning fixed"):
        planned({"pto.law": ["linear", "latching"]}, tuning=["fixed"]).members  # noqa: B018


def test_members_of_one_shape_then_one_take_off_then_one_thickness_go_together(planned):
    vary = {"device.thickness": [0.01, 0.02], "pto.stiffness": [1.0, 0.0], "device.mass": [1.6e4, 1.7e4]}
    points = [point for batch in planned(vary).batches.values() for point in batch.points]
    for keys in (("device.mass",), ("device.mass", "pto.stiffness")):
        runs = [tuple(point[key] for key in keys) for point in points]
        assert len(list(itertools.groupby(runs))) == len(set(runs)) == 2 ** len(keys)
    assert [point["device.thickness"] for point in points] == [0.01, 0.02] * 4


def test_a_campaign_tells_its_study_its_climate_and_its_members_in_their_order(planned, tmp_path):
    (tmp_path / "site.2021.txt").write_text("spectra")
    plan = planned({"device.mass": [1.7e4, 1.6e4, 1.65e4, 1.72e4, 1.62e4]}, climate={"spectra": "site.2021.txt"})
    assert plan.campaign.study == "seed"
    assert plan.campaign.campaign == "sweep"
    assert plan.campaign.climate_name == "site"
    assert plan.campaign.members == tuple(ids(plan))
    assert (plan.campaign.base, plan.campaign.climate, plan.campaign.tuning) == (
        plan.base,
        plan.climate,
        plan.loaded.tuning,
    )
    assert plan.campaign.vary == plan.loaded.campaign.vary
    assert plan.campaign.batches == tuple(plan.batches)
    assert len(plan.batches) == 2
    for batch in plan.batches.values():
        assert (batch.base, batch.climate, batch.tuning) == (plan.base, plan.climate, plan.loaded.tuning)
    assert [one.study.device.mass for one in plan.members] == [1.7e4, 1.6e4, 1.65e4, 1.72e4, 1.62e4]


def test_batches_know_the_budget_of_their_optima_and_are_named_by_their_members(planned):
    plan = planned(LIMITS, tuning=["constrained"], constrained={"seconds": 5.0, "seed": 7})
    by_point = {tuple(one.point.items()): one.id for one in plan.members}
    for name, batch in plan.batches.items():
        assert (batch.constrained.seconds, batch.constrained.seed) == (5.0, 7)
        assert name == content_id([by_point[tuple(point.items())] for point in batch.points])


@pytest.mark.parametrize("model", ["linear", "body_exact"])
def test_runs_in_time_are_by_the_model_asked_for(planned, model):
    (spec,) = planned(verify={"model": model}).verifications.values()
    assert spec.hydro.model == spec.simulated.hydro.model == model


@pytest.mark.parametrize(
    ("vary", "swept"),
    [({}, False), ({"device.mass": [1.7e4]}, False), ({"device.mass": [1.7e4, 1.6e4]}, True),
     ({"device.mass": [1.7e4], "water.density": [1000.0, 1025.0]}, True)],
)  # fmt: skip
def test_a_sweep_is_drawn_where_any_key_has_several_values(planned, vary, swept):
    assert ("sweep" in figure_names(planned(vary).campaign)) is swept


@pytest.mark.parametrize("key", ["force_limit", "stroke_limit"])
def test_no_curves_over_dampers_are_of_any_limit_varied_or_given(planned, key):
    tuned = {"tuning": ["constrained"]}
    assert "tuned_power" not in figure_names(planned({f"pto.{key}": [1e3, 1e4]}, **tuned).campaign)
    assert "tuned_power" not in figure_names(planned({}, name="own", study={"pto": {key: 1e3}}, **tuned).campaign)


def test_runs_in_time_are_told_in_the_order_of_the_members_each_with_all_of_its_own(planned):
    """Sweep, climate and the study of the point, by one tuning; the method in time is the study's."""
    study = {"simulation": {"duration": 99.0, "initial_velocity": -0.8, "tolerance": 1e-5}}
    plan = planned({"device.mass": [1.7e4, 1.6e4]}, study=study, tuning=["each", "one"], verify={"seas": 6, "seed": 3})
    assert plan.campaign.verifications == tuple(plan.verifications)
    for one, spec in zip(plan.members, plan.verifications.values(), strict=True):
        assert spec.device.mass == one.study.device.mass
        assert (spec.sweep, spec.climate, spec.tuning) == (one.spec.sweep, plan.climate, ("one",))
        assert (spec.verify.seas, spec.verify.seed, spec.verify.model) == (6, 3, "body_exact")
        assert (spec.simulation.tolerance, spec.simulation.initial_velocity) == (1e-5, 0.0)
        assert spec.pto == one.study.pto


def test_members_of_one_thickness_go_together_whatever_is_varied_before_it(planned):
    points = [
        point
        for batch in planned({"device.density": [2600.0, 2700.0], "device.thickness": [0.02, 0.01]}).batches.values()
        for point in batch.points
    ]
    assert [tuple(point.values()) for point in points] == [
        (density, thickness) for thickness in (0.01, 0.02) for density in (2600.0, 2700.0)
    ]


def test_a_campaign_promises_its_report_its_data_its_table_and_all_they_are_made_of(planned):
    plan = planned({"device.mass": [1.2e4, 1.4e4, 1.6e4, 1.7e4]}, verify={})
    names = ("sweep", "spectra", "power_matrices", "tuned_power", "pareto")
    own = [f"figures/{name}.{kind}" for name in names for kind in ("svg", "pdf", "csv")]
    own += [f"batches/{one}.nc" for one in plan.batches] + [f"verification/{one}.nc" for one in plan.verifications]
    own += ["report.html", "campaign.nc", "campaign.csv"]
    assert sorted(plan.products) == sorted(f"results/sweep/{name}" for name in own)
