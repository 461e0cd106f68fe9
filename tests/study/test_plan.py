"""Plan of a study: ids, figures, frequencies of the response, memory."""

import json
import math
import re
from typing import get_args

import pytest
import yaml
from conftest import EXAMPLE, SEED, varied
from pydantic import ValidationError

from vsb.study import specs
from vsb.study import study as config
from vsb.study.plan import StudyPlan, figure_names
from vsb.study.sections import Basis
from vsb.study.specs import PHYSICS
from vsb.study.study import canonical, content_id, load, result_id


@pytest.fixture(scope="module")
def seed(seed):
    """The seed study by panels, whose plan has meshes and blocks."""
    return varied(seed, hydro={"solver": "panels"})


def block_ids(study):
    return {content_id(block) for block in StudyPlan(study).sweep_blocks + StudyPlan(study).tabulated_blocks}


def database_id(study):
    return content_id(StudyPlan(study).database)


def test_labels_are_those_of_the_basis(seed):
    from vsb.scenes.rest import study_basis

    for basis in get_args(Basis):
        study = varied(seed, modes={"basis": basis, "degree": 4})
        assert study_basis(study).labels[1:] == StudyPlan(study).mode_labels


def test_figures_follow_from_the_study(seed):
    waves = [{"kind": "still"}, {"kind": "regular", "amplitude": 0.1, "period": 3.0}]
    study = varied(seed, waves=waves)
    assert len(figure_names(study)) == 8 + 2 * 8
    assert len(figure_names(varied(study, designs={"FSB": {"flexible": False}}))) == 8 + 2 * 5
    assumed = varied(study, hydro={"model": "assumed_pressure", "pressure": 100.0})
    assert len(figure_names(assumed)) == 1 + 2 * 8
    assert not {"absorbed_power", "radiation_kernel"} & set(figure_names(assumed))
    sea = {"kind": "pierson_moskowitz", "hs": 0.5, "tp": 4.0}
    assert "spectra" in figure_names(varied(seed, waves=[*waves, sea]))
    assert "spectra" not in figure_names(study)


def test_assumed_pressure_needs_no_bem(seed):
    plan = StudyPlan(varied(seed, hydro={"model": "assumed_pressure", "pressure": 100.0}))
    assert plan.bem_blocks == plan.hydro_files == plan.response_files == {}
    assert not [path for path in plan.products if "/hydro/db" in path or "response" in path]
    assert plan.simulation("FSB", plan.study.waves[0]).hydro.pressure == 100.0


def rewritten(text):
    """The seed with comments gone, keys in reverse order and numbers spelled otherwise."""
    raw = yaml.safe_load(text)
    reversed_keys = {key: dict(reversed(v.items())) if key == "device" else v for key, v in reversed(raw.items())}
    return yaml.safe_dump(reversed_keys, sort_keys=False).replace("10000000.0", "1e7").replace("17170.0", "17170")


@pytest.mark.parametrize("rewrite", [rewritten, lambda text: f"# remark\n{text}# end\n"], ids=["respelled", "comments"])
def test_ids_do_not_depend_on_spelling(tmp_path, rewrite):
    file = tmp_path / "other.yaml"
    file.write_text(rewrite(SEED.read_text()))
    assert file.read_text() != SEED.read_text()
    ours, theirs = StudyPlan(config.load(SEED)), StudyPlan(config.load(file))
    for spec in ("database", "radiation", "display", "modes", "response", "comparison"):
        assert content_id(getattr(theirs, spec)) == content_id(getattr(ours, spec))
    assert block_ids(theirs.study) == block_ids(ours.study)


def test_paths_lie_under_the_root_and_name_their_ids(seed):
    plan = StudyPlan(seed, root="elsewhere")
    block = plan.sweep_blocks[0]
    assert plan.database_path == f"elsewhere/hydro/db/{database_id(seed)}.nc"
    assert plan.block_path(block) == f"elsewhere/hydro/blocks/{content_id(block)}.nc"
    assert plan.mesh_path(block.mesh) == f"elsewhere/hydro/mesh/{content_id(block.mesh)}/mean.nc"
    assert plan.trajectory_path("FSB", "still") == "elsewhere/seed/trajectories/FSB-still.nc"
    assert len(set(plan.display_paths)) == 1 + 2 * 7


def test_memory_bounds_what_was_measured(seed):
    """Measured with the seed's free shell: 0.3 GB for 60 s, 0.6 GB for 16 000 s, 1.7 GB for 100 000 s."""
    asked = {}
    for duration in (60.0, 16e3, 1e5):
        plan = StudyPlan(varied(seed, simulation={"duration": duration, "window": (0.0, duration)}))
        asked[duration] = plan.simulation_megabytes(plan.study.waves[0])
    assert 600 < asked[60.0] < 1000
    assert 700 < asked[16e3] < 1400
    assert 1700 < asked[1e5] < 2 * 1700
    irregular = varied(seed, waves=[{"kind": "jonswap", "hs": 0.5, "tp": 4.0}], simulation={"duration": 1e5})
    assert 2900 < StudyPlan(irregular).simulation_megabytes(irregular.waves[0]) < 2 * 2900


@pytest.mark.parametrize("solver", ["spectral", "panels"])
def test_every_file_has_the_id_of_what_it_is_made_from(solver):
    """Shared files carry it in their name or folder; tables, figures and report have the study's."""
    plan = StudyPlan(varied(load(SEED), hydro={"solver": solver}), root="r")
    stages = dict.fromkeys(plan.response_files.values(), plan.response_id) | plan.shape_ids
    stages |= {f"{plan.folder}/ladder.{kind}": plan.ladder_id for kind in ("csv", "json")}
    runs = {
        plan.trajectory_path(design, wave.label): plan.trajectory_id(design, wave)
        for design in plan.study.designs
        for wave in plan.study.waves
    }
    assert len({plan.response_id, plan.ladder_id, plan.study_id, *runs.values()}) == 3 + len(runs)
    for path, identity in plan.ids.items():
        if path in stages or path in runs:
            assert identity == (stages | runs)[path]
        elif plan.is_shared(path):
            *_, folder, file = path.split("/")
            assert re.fullmatch("[0-9a-f]{16}", identity)
            assert file.startswith(f"{identity}.") or folder == identity
        else:
            assert identity == plan.study_id
    assert plan.ids[plan.database_path] == content_id(plan.database)
    assert {path for path in plan.ids if "/mesh/" in path}


@pytest.mark.parametrize("pressed", [False, True])
def test_study_id_covers_all_results(seed, pressed):
    hydro = {"model": "assumed_pressure", "pressure": 100.0} if pressed else {}
    regular = {"kind": "regular", "amplitude": 0.1, "period": 3.0}
    sea = {"kind": "jonswap", "hs": 0.5, "tp": 4.0, "realisations": 2}
    waves = [regular, {**regular, "period": 4.0}, *([] if pressed else [sea])]
    study = varied(seed, waves=waves, hydro=hydro, designs={"B": {}, "A": {"clamp": 0}})
    plan = StudyPlan(study)
    database, radiation = content_id(plan.database), content_id(plan.radiation)
    solved = () if pressed else (database, radiation)
    runs = [result_id(plan.simulation(name, wave), *solved) for wave in study.waves for name in ("A", "B")]
    answers = () if pressed else (result_id(plan.response, database), result_id(plan.ladder, database))
    witness = () if pressed else (content_id(plan.witness),)
    own = result_id(plan.comparison, content_id(plan.modes), *solved, *witness, *answers, *runs)
    assert plan.study_id == own
    assert plan.ids[f"{plan.folder}/report.html"] == own
    assert plan.ids[f"{plan.folder}/modes.nc"] == content_id(plan.modes)
    assert {plan.ids[path] for path in plan.display_paths} == {content_id(plan.display)}


def test_memory_of_runs_and_reports(seed):
    """Three records per run, one per design in the report, 0.6 kB per component of a spectrum."""
    waves = [
        {"kind": "regular", "amplitude": 0.1, "period": 5.0},
        {"kind": "regular", "amplitude": 0.1, "period": 2.5},
        {"kind": "jonswap", "hs": 0.5, "tp": 6.0},
        {"kind": "still"},
    ]
    run = {"duration": 2e4, "window": (0.0, 2e4)}
    study = varied(seed, waves=waves, simulation=run, hydro={"omega_max": 7.0}, designs={"A": {}, "B": {"clamp": 0}})
    plan = StudyPlan(study)
    records = [plan.record_megabytes(wave) for wave in study.waves]
    assert len(set(records)) > 2
    beyond = [plan.simulation_megabytes(wave) - 3 * record for wave, record in zip(study.waves, records, strict=True)]
    assert beyond == [800, 800, 800 + math.ceil(6e-4 * 7.0 * 2e4), 800]
    assert plan.study_megabytes == 800 + math.ceil(1.2 * 2 * max(records))


@pytest.fixture(scope="module")
def pressurised():
    """A study about its equilibrium, whose shapes and meshes hold the shell."""
    return load(EXAMPLE.with_name("pressurised.yaml"))


@pytest.mark.parametrize("kind", [specs.ModesSpec, specs.CompareSpec, specs.RadiationSpec])
def test_specification_of_another_stage_or_version_is_refused(seed, kind):
    plan = StudyPlan(seed)
    (spec,) = (one for one in (plan.modes, plan.comparison, plan.radiation) if isinstance(one, kind))
    raw = json.loads(canonical(spec))
    assert kind.model_validate(raw) == spec
    for key, value in (("stage", "other"), ("physics", spec.physics + 1)):
        with pytest.raises(ValidationError, match=f"{key} .*: needs .*, of this version; run vsb run CONFIG again"):
            kind.model_validate({**raw, key: value})
    with pytest.raises(ValidationError, match="Extra inputs"):
        kind.model_validate({**raw, "more": 1})


def test_simulated_member_is_its_study_in_still_water(seed):
    floats = specs.BuoySystem(**{name: part for name, part in seed if name in specs.BuoySystem.model_fields})
    parts = {"system": floats, "hydro": seed.hydro, "simulation": seed.simulation}
    climate = specs.ClimateSpec(contents="0" * 16, form="spectra")
    spec = specs.VerificationSpec(sweep=("a",), climate=climate, tuning=("one",), verify=specs.Verify(), **parts)
    read = specs.VerificationSpec.model_validate_json(canonical(spec))
    whole = varied(seed, waves=[{"kind": "still"}]).model_copy(update={"study": "member"})
    assert canonical(spec.simulated) == canonical(read.simulated) == canonical(whole)


def test_loaded_shape_depends_on_neither_damping_nor_depth(pressurised):
    shape = StudyPlan(pressurised).shape
    assert isinstance(shape, specs.LoadedShape)
    other = varied(pressurised, device={"damping": {"alpha": 1.0}}, water={"depth": 30.0})
    assert content_id(StudyPlan(other).shape) == content_id(shape)
    stiffer = varied(pressurised, device={"young_modulus": 2e7})
    assert content_id(StudyPlan(stiffer).shape) != content_id(shape)


SWELL, SEA = {"kind": "regular", "amplitude": 0.1, "period": 3.0}, {"kind": "jonswap", "hs": 0.2, "tp": 3.5}
DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC0": {"clamp": 30.0}}


@pytest.fixture(scope="module")
def study():
    return varied(load(SEED), waves=[SWELL, SEA], designs=DESIGNS)


def ids(study):
    """Ids of the results of a study; runs are those of the first sea."""
    plan, wave = StudyPlan(study), study.waves[0]
    return {
        "blocks": [content_id(block) for block in plan.sweep_blocks],
        "database": content_id(plan.database),
        "radiation": content_id(plan.radiation),
        "witness": plan.witness and content_id(plan.witness),
        "modes": content_id(plan.modes),
        "response": plan.response_id,
        "ladder": plan.ladder_id,
        "runs": [plan.trajectory_id(design, wave) for design in ("FSB", "VSWEC")],
        "report": plan.study_id,
    }


def changed(before, after):
    return {name for name in before if before[name] != after[name]}


MOTION = {"response", "ladder", "runs", "report"}
WATER = {"database", "radiation", *MOTION}
SHELL = {"modes", *WATER}
ALL = {"blocks", "witness", *SHELL}


@pytest.mark.parametrize(
    ("changes", "renamed"),
    [
        ({"water": {"density": 1000.0}}, ALL),
        ({"water": {"depth": 30.0}}, ALL),
        ({"device": {"mass": 17000.0}}, ALL),
        ({"modes": {"degree": 5}}, ALL),
        ({"reference_shape": "equilibrium"}, ALL),
        ({"device": {"thickness": 0.02}}, ALL - {"blocks"}),  # the second solver meshes deformed shells
        ({"modes": {"basis": "full"}}, ALL - {"blocks"}),
        ({"device": {"young_modulus": 2e7}}, SHELL),
        ({"device": {"damping": {"alpha": 1.0}}}, SHELL),
        ({"device": {"internal_pressure": 1e3}}, SHELL),
        ({"hydro": {"omega_max": 13.0}}, {"blocks", *WATER}),
        ({"hydro": {"tolerance": 1e-4}}, {"blocks", *WATER}),
        ({"hydro": {"omega": [2.0]}}, WATER),
        ({"hydro": {"accept": ["rank_one"]}}, WATER),
        ({"hydro": {"witness": "none"}}, {"witness", "report"}),
        ({"hydro": {"model": "body_exact"}}, {"runs", "report"}),
        ({"pto": {"damping": 1.0}}, MOTION),
        ({"pto": {"force_limit": 1e3}}, MOTION),
        ({"waves": [{**SWELL, "period": 4.0}, SEA]}, MOTION),
        ({"drag": {"heave": {"coefficient": 0.5, "area": 3.0}}}, MOTION - {"response"}),
        ({"simulation": {"duration": 100.0}}, MOTION - {"response"}),
        ({"simulation": {"method": "exact"}}, {"runs", "report"}),
        ({"waves": [SWELL, {**SEA, "seed": 2}]}, {"ladder", "report"}),  # runs of the other sea stay
        ({"designs": {**DESIGNS, "VSWEC0": {"clamp": 45.0}}}, {"modes", *MOTION} - {"runs"}),  # of the other designs
        ({"published": {"source": "a paper", "values": {"FSB": {"power_mean": 1.0}}}}, {"report"}),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else "",
)
def test_key_changes_the_ids_of_the_results_that_depend_on_it(study, changes, renamed):
    assert changed(ids(study), ids(varied(study, **changes))) == renamed


@pytest.mark.parametrize(
    ("tag", "renamed"),
    [
        ("block", {"blocks", *WATER}), ("database", WATER), ("radiation", {"radiation", "runs", "report"}),
        ("response", {"response", "report"}), ("ladder", {"ladder", "report"}), ("simulate", {"runs", "report"}),
        ("witness", {"witness", "report"}), ("compare", {"report"}), ("member", set()),
    ],
)  # fmt: skip
def test_version_of_the_physics_is_part_of_the_ids(study, monkeypatch, tag, renamed):
    before = ids(study)
    monkeypatch.setitem(PHYSICS, tag, PHYSICS[tag] + 1)
    assert changed(before, ids(study)) == renamed
