"""Specifications: their text says all they are, and nothing else can be read from it."""

import json

import pytest
from conftest import EXAMPLE, varied
from pydantic import ValidationError
from study.test_body_plan import plan as planned_body

from vsb.study import body_plan, specs
from vsb.study import plan as plans
from vsb.study.plan import StudyPlan
from vsb.study.study import canonical, content_id, load


@pytest.fixture(scope="module")
def pressurised():
    """A study about its equilibrium, whose shapes and meshes hold the shell."""
    return load(EXAMPLE.with_name("pressurised.yaml"))


@pytest.mark.parametrize("kind", [specs.ModesSpec, specs.CompareSpec, specs.RadiationSpec])
def test_a_specification_of_another_stage_or_version_is_refused(seed, kind):
    plan = StudyPlan(seed)
    (spec,) = (one for one in (plan.modes, plan.comparison, plan.radiation) if isinstance(one, kind))
    raw = json.loads(canonical(spec))
    assert kind.model_validate(raw) == spec
    for key, value in (("stage", "other"), ("physics", spec.physics + 1)):
        with pytest.raises(ValidationError, match=f"{key} .*: needs .*, of this version; run vsb run CONFIG again"):
            kind.model_validate({**raw, key: value})
    with pytest.raises(ValidationError, match="Extra inputs"):
        kind.model_validate({**raw, "more": 1})


@pytest.mark.parametrize("tag", specs.PHYSICS)
def test_the_version_of_its_physics_names_a_stage(seed, tag, monkeypatch):
    def ids():
        plan = StudyPlan(varied(seed, hydro={"rows": 30}))
        block = plan.sweep_blocks[0]
        found = (block.mesh, plan.modes, block, plan.database, plan.radiation, plan.response, plan.comparison)
        return [content_id(spec) for spec in (*found, plan.simulation("FSB", seed.waves[0]), plan.witness, plan.ladder)]

    before = ids()
    monkeypatch.setitem(specs.PHYSICS, tag, specs.PHYSICS[tag] + 1)
    changed = {
        "mesh": {0, 1, 2, 3, 4, 8}, "bem": {2, 3, 4}, "database": {3, 4}, "radiation": {4}, "response": {5}, "compare": {6},
        "simulate": {7}, "witness": {8}, "ladder": {9}, "degree": set(), "member": set(), "members": set(), "campaign": set(),
        "verification": set(), "body": set(),
    }  # fmt: skip
    assert {i for i, (old, new) in enumerate(zip(before, ids(), strict=True)) if old != new} == changed[tag]


LATCHING = {"law": "latching"}


@pytest.mark.parametrize(
    ("pto", "pauses"), [({}, False), ({"law": "saturated", "force_limit": 1e4}, False), (LATCHING, True),
                        ({"law": "declutching", "damping": None, "tuning": "each"}, True)]
)  # fmt: skip
def test_how_a_pause_is_found_names_the_runs_that_pause_and_no_others(seed, monkeypatch, pto, pauses):
    """Runs of a former rule are not taken for those of today's; runs without a pause keep their names."""

    def ids():
        plan = StudyPlan(varied(seed, pto=pto))
        stages = (plan.database, plan.radiation, plan.response, plan.ladder, plan.comparison)
        runs = (plan.simulation(design, seed.waves[0]) for design in seed.designs)
        return [content_id(spec) for spec in stages], [content_id(spec) for spec in runs]

    others, runs = ids()
    run = canonical(StudyPlan(varied(seed, pto=pto)).simulation("FSB", seed.waves[0]))
    assert (f'"pause":{specs.PAUSE}' in run) == pauses
    monkeypatch.setattr(plans, "PAUSE", specs.PAUSE + 1)
    after = ids()
    assert after[0] == others
    assert [new != old for new, old in zip(after[1], runs, strict=True)] == [pauses] * len(runs)


@pytest.mark.parametrize(
    ("pto", "costs"),
    [
        ({}, False),
        ({"stiffness": 2e3}, False),
        ({"efficiency": 0.8}, False),
        ({"stiffness": -2e3, "efficiency": 0.8}, True),
    ],
)
def test_how_dampers_beside_a_costly_spring_are_found_names_their_ladders_and_nothing_else(
    seed, monkeypatch, pto, costs
):
    """Ladders of a former rule are not taken for those of today's; all others keep their names, a body's likewise."""

    def ids():
        plan, body = StudyPlan(varied(seed, pto=pto)), planned_body(pto={"damping": 1e4, **pto})
        stages = [plan.database, plan.radiation, plan.response, plan.comparison, body.radiation, body.response]
        runs = [plan.simulation(design, seed.waves[0]) for design in seed.designs]
        ladders = [plan.ladder, body.ladder]
        assert [f'"spring":{specs.SPRING}' in canonical(ladder) for ladder in ladders] == [costs] * 2
        return [content_id(spec) for spec in stages + runs], [content_id(ladder) for ladder in ladders]

    others, ladders = ids()
    for plan_module in (plans, body_plan):
        monkeypatch.setattr(plan_module, "SPRING", specs.SPRING + 1)
    monkeypatch.setattr(specs, "SPRING", specs.SPRING + 1)
    after = ids()
    assert after[0] == others
    assert [new != old for new, old in zip(after[1], ladders, strict=True)] == [costs] * 2


def test_runs_of_a_year_that_pause_rest_on_how_a_pause_is_found(seed):
    """A verified year names what its runs rest on: the year by linear theory, coefficients, memory, runs."""
    limited = {"law": "saturated", "force_limit": 1e4}
    versions = [specs._versions(varied(seed, pto=pto).pto) for pto in ({}, LATCHING, limited)]
    assert (
        versions[0]
        == versions[2]
        == {tag: specs.PHYSICS[tag] for tag in ("member", "database", "radiation", "simulate")}
    )
    assert versions[1] == {**versions[0], "pause": specs.PAUSE}


@pytest.mark.parametrize(
    "changes",
    [{}, {"designs": {"FSB": {"flexible": False}}}, {"reference_shape": "equilibrium"}, {"device": {"mass": 12e3}},
     {"reference_shape": "equilibrium", "designs": {"FSB": {"flexible": False}}}, {"device": {"gas": {}}},
     {"device": {"gas": {}}, "pto": {"port": "volume"}}, {"pto": {"port": "volume"}},
     {"device": {"shape": {"capsule": {"length": 1.0}}, "mass": 2.2e4}, "modes": {"basis": "full", "degree": 2}}],
    ids=str,
)  # fmt: skip
def test_a_specification_says_what_its_study_says(seed, changes):
    """Whether a shell moves, in which shape, how high and how deep it rests, whether its gas is let out: of either."""
    study = varied(seed, **changes)
    plan = StudyPlan(study)
    for spec in (plan.modes, plan.display, plan.database):
        assert (spec.flexible, spec.at_equilibrium) == (study.flexible, study.at_equilibrium)
        assert spec.centre_height == study.centre_height
    for name, design in study.designs.items():
        run = plan.simulation(name, study.waves[0])
        assert run.flexible == design.flexible
        assert run.centre_height == plan.response.centre_height == plan.ladder.centre_height == study.centre_height
        assert run.draft == plan.ladder.draft == study.draft
        assert run.opens_chamber == plan.response.opens_chamber == plan.ladder.opens_chamber == study.opens_chamber


def test_what_is_simulated_of_a_member_is_its_study_in_no_sea(seed):
    """As it stands after a journey as text."""
    parts = {name: part for name, part in seed if name in specs.VerificationSpec.model_fields}
    climate = specs.ClimateSpec(contents="0" * 16, form="spectra")
    spec = specs.VerificationSpec(sweep=("a",), climate=climate, tuning=("one",), verify=specs.Verify(), **parts)
    read = specs.VerificationSpec.model_validate_json(canonical(spec))
    whole = varied(seed, waves=[{"kind": "still"}]).model_copy(update={"study": "member"})
    assert canonical(spec.simulated) == canonical(read.simulated) == canonical(whole)


def test_the_ladder_of_a_study_is_read_whatever_the_method_of_its_model(seed):
    followed = varied(seed, hydro={"model": "body_exact"}, simulation={"method": "exponential"})
    plan = StudyPlan(followed)
    assert plan.ladder.simulation.duration == followed.simulation.duration
    assert content_id(plan.ladder) == content_id(StudyPlan(seed).ladder)


def test_a_loaded_shape_sees_neither_damping_nor_depth(pressurised):
    shape = StudyPlan(pressurised).shape
    assert isinstance(shape, specs.LoadedShape)
    other = varied(pressurised, device={"damping": {"alpha": 1.0}}, water={"depth": 30.0})
    assert content_id(StudyPlan(other).shape) == content_id(shape)
    stiffer = varied(pressurised, device={"young_modulus": 2e7})
    assert content_id(StudyPlan(stiffer).shape) != content_id(shape)


def test_what_is_not_interpolated_does_not_say_so(seed):
    swept, tabulated = StudyPlan(varied(seed, hydro={"omega": [1.0]})).bem_blocks.values()
    assert json.loads(canonical(swept))["interpolation"] == 5e-4
    assert "interpolation" not in json.loads(canonical(tabulated))
