import math
from typing import get_args

import numpy as np
import pytest
import yaml
from conftest import SEED, varied

from vsb.study import study as config
from vsb.study.plan import StudyPlan, figure_names
from vsb.study.resolution import KEPT, RECORDS_PER_PERIOD
from vsb.study.sections import Basis
from vsb.study.specs import PAUSE
from vsb.study.study import content_id, parse


@pytest.fixture(scope="module")
def seed(seed):
    """The seed study by panels, whose plan has meshes and blocks."""
    return varied(seed, hydro={"solver": "panels"})


def block_ids(study):
    return {content_id(block) for block in StudyPlan(study).sweep_blocks + StudyPlan(study).tabulated_blocks}


def database_id(study):
    return content_id(StudyPlan(study).database)


def test_a_wider_band_needs_only_new_blocks(seed):
    narrow, wide = block_ids(seed), block_ids(varied(seed, hydro={"omega_max": 15.0}))
    assert narrow < wide
    assert len(wide - narrow) == 1


@pytest.mark.parametrize(
    "changes",
    [
        {"pto": {"damping": 1.0}},
        {"waves": [{"kind": "still"}]},
        {"simulation": {"duration": 100.0}},
        {"designs": {"only": {"clamp": 45}}},
    ],
    ids=str,
)
def test_what_hydrodynamics_do_not_see_leaves_the_database_alone(seed, changes):
    assert database_id(varied(seed, **changes)) == database_id(seed)


@pytest.mark.parametrize(
    "changes",
    [
        {"device": {"young_modulus": 1e9}},
        {"device": {"density": 2000.0}},
        {"device": {"damping": {"alpha": 1.0, "beta": 0.0}}},
        {"modes": {"basis": "full"}},
        {"hydro": {"omega": [2.0, 3.0]}},
    ],
    ids=str,
)
def test_structure_and_basis_change_the_database_but_no_block_of_the_sweep(seed, changes):
    other = varied(seed, **changes)
    assert database_id(other) != database_id(seed)
    assert block_ids(seed) <= block_ids(other)


@pytest.mark.parametrize(
    "changes", [{"device": {"radius": 2.1, "mass": 18000.0}}, {"device": {"mass": 17000.0}}], ids=str
)
def test_another_wetted_shape_needs_other_blocks(seed, changes):
    assert not block_ids(seed) & block_ids(varied(seed, **changes))


def test_rigid_study_solves_heave_alone(seed):
    plan = StudyPlan(varied(seed, designs={"FSB": {"flexible": False}}))
    assert plan.displacements() == ("Radial1",)
    assert plan.mode_labels == ()
    assert [path.rsplit("/")[-1] for path in plan.display_paths] == ["mean.vtu"]


def test_labels_are_those_of_the_basis(seed):
    from vsb.scenes.rest import study_basis

    for basis in get_args(Basis):
        study = varied(seed, modes={"basis": basis, "degree": 4})
        assert study_basis(study).labels[1:] == StudyPlan(study).mode_labels


def test_figures_are_known_beforehand(seed):
    waves = [{"kind": "still"}, {"kind": "regular", "amplitude": 0.1, "period": 3.0}]
    study = varied(seed, waves=waves)
    assert len(figure_names(study)) == 6 + 2 * 8
    assert len(figure_names(varied(study, designs={"FSB": {"flexible": False}}))) == 6 + 2 * 5
    assumed = varied(study, hydro={"model": "assumed_pressure", "pressure": 100.0})
    assert len(figure_names(assumed)) == 1 + 2 * 8
    assert not {"absorbed_power", "radiation_kernel"} & set(figure_names(assumed))
    sea = {"kind": "pierson_moskowitz", "hs": 0.5, "tp": 4.0}
    assert "spectra" in figure_names(varied(seed, waves=[*waves, sea]))
    assert "spectra" not in figure_names(study)


def test_an_assumed_pressure_needs_no_bem(seed):
    plan = StudyPlan(varied(seed, hydro={"model": "assumed_pressure", "pressure": 100.0}))
    assert plan.bem_blocks == plan.hydro_files == plan.response_files == {}
    assert not [path for path in plan.products if "/hydro/db" in path or "response" in path]
    assert plan.simulation("FSB", plan.study.waves[0]).hydro.pressure == 100.0


@pytest.mark.parametrize("changes", [{"device": {"young_modulus": 1e9}}, {"device": {"density": 2000.0}}], ids=str)
def test_shell_material_changes_no_block_at_all(seed, changes):
    other = varied(seed, **changes)
    assert block_ids(other) == block_ids(seed)
    assert database_id(other) != database_id(seed)


@pytest.mark.parametrize(
    "changes",
    [
        {"pto": {"damping": 1.0}},
        {"waves": [{"kind": "jonswap", "hs": 1, "tp": 6}]},
        {"designs": {"only": {"clamp": 45}}},
        {"simulation": {"initial_velocity": 0.0}},
    ],
    ids=str,
)
def test_database_radiation_and_blocks_see_no_pto_wave_or_design(seed, changes):
    ours, theirs = StudyPlan(seed), StudyPlan(varied(seed, **changes))
    assert theirs.database_path == ours.database_path
    assert theirs.radiation_path == ours.radiation_path
    assert theirs.sweep_blocks == ours.sweep_blocks


def rewritten(text):
    """The seed with comments gone, keys in reverse order and numbers spelled otherwise."""
    raw = yaml.safe_load(text)
    reversed_keys = {key: dict(reversed(v.items())) if key == "device" else v for key, v in reversed(raw.items())}
    return yaml.safe_dump(reversed_keys, sort_keys=False).replace("10000000.0", "1e7").replace("17170.0", "17170")


@pytest.mark.parametrize("rewrite", [rewritten, lambda text: f"# remark\n{text}# end\n"], ids=["respelled", "comments"])
def test_ids_do_not_see_how_a_study_is_written(tmp_path, rewrite):
    file = tmp_path / "other.yaml"
    file.write_text(rewrite(SEED.read_text()))
    assert file.read_text() != SEED.read_text()
    ours, theirs = StudyPlan(config.load(SEED)), StudyPlan(config.load(file))
    for spec in ("database", "radiation", "display", "modes", "response", "comparison"):
        assert content_id(getattr(theirs, spec)) == content_id(getattr(ours, spec))
    assert block_ids(theirs.study) == block_ids(ours.study)


def test_each_stage_reads_its_own_sections(seed):
    other = varied(seed, pto={"damping": 1.0})
    ours, theirs = StudyPlan(seed), StudyPlan(other)
    assert content_id(theirs.response) != content_id(ours.response)
    assert content_id(theirs.comparison) != content_id(ours.comparison)
    assert content_id(theirs.modes) == content_id(ours.modes)
    assert content_id(theirs.display) == content_id(ours.display)


def test_a_response_is_known_at_tabulated_frequencies_of_the_sweep_and_at_every_regular_wave(seed):
    waves = [{"kind": "regular", "amplitude": 0.1, "period": T} for T in (3.0, 2.5, 3.0)] + [{"kind": "still"}]
    study = varied(seed, waves=waves[:2] + waves[3:], hydro={"solver": "spectral", "omega": [1e-3, 2.0, 5.0]})
    plan = StudyPlan(study)
    assert 1e-3 < plan.first_omega < 2.0
    assert plan.response.omega == (2.0, 2 * math.pi / 3, 2 * math.pi / 2.5, 5.0)


def test_a_run_sees_its_own_design_and_sea_only(seed):
    other = varied(
        seed, designs={"VSWEC": {}, "new": {"clamp": 30}}, waves=[*seed.model_dump()["waves"], {"kind": "still"}]
    )
    ours, theirs = (StudyPlan(study).simulation("VSWEC", seed.waves[0]) for study in (seed, other))
    assert ours == theirs
    assert StudyPlan(seed).simulation("VSWEC0", seed.waves[0]) != ours
    assert StudyPlan(other).simulation("VSWEC", other.waves[1]) != ours


def test_database_does_not_see_the_name_of_the_study(seed):
    plan = StudyPlan(config.parse({**seed.model_dump(), "study": "other"}))
    assert plan.database_path == StudyPlan(seed).database_path
    assert plan.folder == "results/other"


def test_paths_lie_under_the_root_and_name_their_ids(seed):
    plan = StudyPlan(seed, root="elsewhere")
    block = plan.sweep_blocks[0]
    assert plan.database_path == f"elsewhere/hydro/db/{database_id(seed)}.nc"
    assert plan.block_path(block) == f"elsewhere/hydro/blocks/{content_id(block)}.nc"
    assert plan.mesh_path(block.mesh) == f"elsewhere/hydro/mesh/{content_id(block.mesh)}/mean.nc"
    assert plan.trajectory_path("FSB", "still") == "elsewhere/seed/trajectories/FSB-still.nc"
    assert len(set(plan.display_paths)) == 1 + 2 * 7


def test_of_several_realisations_one_is_drawn(seed):
    sea = {"kind": "jonswap", "hs": 1.0, "tp": 4.0, "realisations": 3}
    study = varied(seed, waves=[{"kind": "still"}, sea, {**sea, "hs": 2.0, "seed": 4}])
    drawn = {name.partition("-")[2] for name in figure_names(study)} - {""}
    assert drawn == {"still", "jonswap_Hs1_Tp4_g3.3_s1", "jonswap_Hs2_Tp4_g3.3_s4"}
    assert len(study.waves) == 7


def test_the_tolerance_of_the_automatic_model_reaches_the_run(seed):
    plans = [StudyPlan(varied(seed, hydro={"model": "auto", "power_tolerance": t})) for t in (0.1, 0.01)]
    specs = [plan.simulation("VSWEC", seed.waves[0]) for plan in plans]
    assert [spec.hydro.power_tolerance for spec in specs] == [0.1, 0.01]


def test_memory_grows_with_the_record_not_with_what_is_followed(seed):
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


@pytest.mark.parametrize(("omega_max", "duration"), [(6.0, 1e3), (6.0, 1e5), (12.0, 2e4)])
def test_memory_beyond_the_record_is_of_the_components_of_a_sea(seed, omega_max, duration):
    """In a regular wave there is one; of a spectrum as many as its band times the duration, of some 4 kB each."""
    waves = [{"kind": "regular", "amplitude": 0.1, "period": 2.5}, {"kind": "jonswap", "hs": 0.5, "tp": 4.0}]
    run = {"duration": duration, "window": (0.0, duration)}
    study = varied(seed, waves=waves, simulation=run, hydro={"omega_max": omega_max})
    plan = StudyPlan(study)
    regular, sea = (plan.simulation_megabytes(wave) - 3 * plan.record_megabytes(wave) for wave in study.waves)
    assert regular == 800
    components = omega_max * duration / (2 * np.pi)
    assert sea - regular == pytest.approx(3.77e-3 * components, rel=0.01, abs=1.0)
    largest = max(plan.record_megabytes(wave) for wave in study.waves)
    assert plan.study_megabytes >= 800 + 1.2 * len(study.designs) * largest


@pytest.mark.parametrize(
    ("pto", "damping", "seas", "pause"),
    [
        ({"damping": 5.0}, 5.0, 0, 0),
        ({"damping": {"FSB": 5.0, "VSWEC": 6.0}}, 6.0, 0, 0),
        ({"damping": 5.0, "law": "latching"}, 5.0, 0, PAUSE),
        ({"tuning": "each"}, None, 0, 0),
        ({"tuning": "one"}, None, 2, 0),
    ],
)
def test_a_run_knows_its_damper_or_all_it_is_found_from(seed, pto, damping, seas, pause):
    """All seas where one damper is best over them; how pauses are found where there are any."""
    sea = {"kind": "jonswap", "hs": 0.5, "tp": 4.0}
    waves = [{"kind": "regular", "amplitude": 0.1, "period": 4.0}, sea, {**sea, "seed": 2}]
    raw = seed.model_dump() | {"waves": waves, "pto": pto, "designs": {"FSB": {"flexible": False}, "VSWEC": {}}}
    plan = StudyPlan(parse(raw))
    spec = plan.simulation("VSWEC", plan.study.waves[0])
    assert (spec.pto.damping, spec.seas, spec.pause) == (damping, plan.study.waves[:seas], pause)
    assert list(spec.designs) == ["VSWEC"]
    assert spec.waves == plan.study.waves[:1]


def test_memory_is_of_the_instants_kept_a_half_of_them_once_they_are_too_many(seed):
    """Nine series of every coordinate and ten others of eight bytes each; `thinning` counts the first instant, too."""
    sea = {"kind": "regular", "amplitude": 0.1, "period": 2.5}
    lasting = [2.5 / RECORDS_PER_PERIOD * (KEPT + more) for more in (-0.5, 0.5)]
    plans = [StudyPlan(varied(seed, waves=[sea], simulation={"duration": t, "window": (0.0, t)})) for t in lasting]
    series = 9 * plans[0].coordinates + 10
    assert plans[0].study.fastest(plans[0].study.waves[0]) == pytest.approx(2 * np.pi / 2.5)
    told = [plan.record_megabytes(plan.study.waves[0]) for plan in plans]
    assert told == [math.ceil(8e-6 * series * KEPT), math.ceil(8e-6 * series * KEPT / 2)]


def test_a_member_of_a_campaign_without_a_damper_has_a_plan(seed):
    """It lies in still water, where no damper is best; it is not run there, but its jobs are listed."""
    still = varied(seed, pto={"damping": None, "tuning": "each"}, waves=[{"kind": "still"}])
    run = StudyPlan(still).simulation("FSB", still.waves[0])
    assert (run.pto.damping, run.pto.tuning) == (None, "each")
    for damping in (8000.0, 0.0):
        given = varied(still, pto={"damping": damping})
        run = StudyPlan(given).simulation("FSB", given.waves[0])
        assert (run.pto.damping, run.pto.tuning) == (damping, "fixed")


def test_memory_to_draw_a_study_is_a_fifth_more_than_the_series_of_all_designs_in_its_longest_sea(seed):
    wave = {"kind": "regular", "amplitude": 0.1}
    study = varied(
        seed,
        waves=[{**wave, "period": 2.5}, {**wave, "period": 5.0}],
        simulation={"duration": 1e4, "window": (0.0, 1e4)},
        designs={"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC0": {"clamp": 0}},
    )
    plan = StudyPlan(study)
    short, long = (plan.record_megabytes(wave) for wave in study.waves)
    assert short > long > 20
    assert plan.study_megabytes == 800 + math.ceil(1.2 * 3 * short)


def test_figures_of_a_study_follow_from_what_moves_and_what_is_solved(seed):
    """In several directions the waves', but no whole shells; a second solver's, where there is one."""
    balance = {"centre_of_mass": -0.5, "ballast_inertia": 8e3, "ballast_yaw_inertia": 7e3}
    for motion in ("heave", "planar", "free"):
        device = {} if motion == "heave" else balance
        names = figure_names(varied(seed, motion=motion, device=device, hydro={"solver": "auto"}))
        assert any(name.startswith("directions-") for name in names) is (motion != "heave")
        assert any(name.startswith("shapes_3d-") for name in names) is (motion == "heave")
        assert any(name.startswith("extreme_shapes-") for name in names)
        assert "witness" in names
    assert "witness" not in figure_names(varied(seed, hydro={"witness": "none"}))
    assert not any("shapes_3d" in name for name in figure_names(varied(seed, designs={"A": {"flexible": False}})))


def test_shapes_are_shown_and_asked_about_at_rest_and_with_either_sign_of_every_mode(seed):
    plan = StudyPlan(varied(seed, modes={"degree": 2}, hydro={"solver": "auto"}), root="r")
    shapes = ["mean", *(f"Membrane{n}_{sign}" for n in (0, 1, 2) for sign in ("minus", "plus"))]
    assert [path.rpartition("/")[2] for path in plan.display_paths] == [f"{name}.vtu" for name in shapes]
    assert [path.rpartition("/")[2] for path in plan.deformed_paths] == [f"{name}.nc" for name in shapes]
    assert {*plan.deformed_paths, *plan.display_paths, *plan.witness_files.values()} <= set(plan.products)
    assert all(path.startswith("r/hydro/") for path in (*plan.deformed_paths, *plan.display_paths))


def test_every_block_of_panels_is_solved_on_its_own_mesh(seed):
    plan = StudyPlan(varied(seed, hydro={"omega": [2.0, 11.0]}), root="r")
    blocks = list(plan.bem_blocks.values())
    assert len(plan.solved_files) == 2 * len(blocks)
    assert {f"r/hydro/blocks/{content_id(block)}.nc" for block in blocks} | {
        f"r/hydro/mesh/{content_id(block.mesh)}/mean.nc" for block in blocks
    } == set(plan.solved_files)


def test_a_database_reaches_its_grid_and_a_response_what_is_asked(seed):
    plan = StudyPlan(varied(seed, hydro={"omega_max": 9.73, "accept": ["symmetry", "haskind"]}))
    assert plan.database.omega_max == 9.8
    assert plan.response.omega_max == plan.ladder.hydro.omega_max == plan.highest == 9.73
    assert plan.database.accept == ("haskind", "symmetry")


def test_shapes_are_shown_of_axisymmetric_modes_alone(seed):
    balance = {"centre_of_mass": -0.5, "ballast_inertia": 8e3}
    displays = [
        StudyPlan(
            varied(seed, motion="planar", device=balance, modes={"order": order}, hydro={"solver": "auto"})
        ).display
        for order in (1, 2)
    ]
    assert displays[0] == displays[1]


def test_a_ladder_follows_no_motion_and_knows_no_method(seed):
    exact = StudyPlan(varied(seed, simulation={"method": "exact"}))
    assert exact.ladder == StudyPlan(seed).ladder
    assert exact.simulation("FSB", seed.waves[0]).simulation.method == "exact"


@pytest.mark.parametrize("depth", [math.inf, 7.0])
def test_a_response_begins_at_the_first_frequency_solved(seed, depth):
    """On the grid, above what panels can solve in that depth; what is tabulated there is told."""
    plan = StudyPlan(varied(seed, water={"depth": depth}))
    first = plan.sweep_blocks[1].omega[0]
    assert (plan.lowest_omega < first) is (depth == 7.0)
    told = StudyPlan(varied(plan.study, hydro={"omega": [first, 1.23]})).response
    assert told.lowest == plan.response.lowest == first
    assert told.omega[:2] == (first, 1.23)
    assert told.step == 0.1


@pytest.mark.parametrize("solver", ["spectral", "panels"])
def test_every_stage_is_told_what_the_study_says(seed, solver):
    """Of tolerances, too, and of all sections it has any of."""
    balance = {"centre_of_mass": -0.5, "ballast_inertia": 8e3, "damping": {"alpha": 0.5}}
    motion = (
        {"motion": "planar", "device": balance, "mooring": [1e3, 0, 2e3, 0, 3e3, 0]} if solver == "spectral" else {}
    )
    study = varied(
        seed, **motion, hydro={"solver": solver, "tolerance": 2e-3, "omega": [2.0], "accept": ["haskind"], "omega_max": 9.0},
        water={"density": 1000.0, "depth": 30.0}, modes={"degree": 3}, drag={"heave": {"coefficient": 0.5, "area": 3.0}},
        pto={"stiffness": 7.0, "efficiency": 0.9}, simulation={"tolerance": 1e-5, "initial_position": 0.1},
    )  # fmt: skip
    plan = StudyPlan(study)
    run = plan.simulation("VSWEC", study.waves[0])
    specs = (plan.database, plan.modes, plan.response, plan.ladder, run)
    for spec in specs:
        for name in ("device", "water", "motion", "mooring", "modes", "pto", "drag"):
            if name in type(spec).model_fields and not (spec is run and name == "pto"):
                assert getattr(spec, name) == getattr(study, name), (type(spec).__name__, name)
    assert plan.database.tolerance == plan.radiation.tolerance == 2e-3
    assert (plan.database.omega, plan.database.accept) == ((2.0,), ("haskind",))
    assert plan.database.sweep == tuple(content_id(block) for block in plan.sweep_blocks)
    assert plan.database.tabulated == tuple(content_id(block) for block in plan.tabulated_blocks)
    assert [block.order for block in plan.tabulated_blocks] == list(study.orders)
    assert len(set(plan.database.tabulated)) == len(study.orders)
    for block in plan.bem_blocks.values():
        assert block.water == study.water
        assert getattr(block, "tolerance", 2e-3) == 2e-3
    assert (run.pto.damping, run.pto.stiffness, run.pto.efficiency) == (8000.0, 7.0, 0.9)
    assert run.simulation == study.simulation
    assert plan.ladder.waves == study.waves
    assert plan.ladder.simulation == study.simulation
    assert run.designs == {"VSWEC": study.designs["VSWEC"]}
    assert (run.reference_shape, run.hydro.omega_max, run.hydro.model) == ("undeformed", 9.0, "linear")
    assert plan.response.designs == plan.ladder.designs == plan.modes.designs == study.designs


@pytest.mark.parametrize(
    "changes",
    [
        {"hydro": {"witness": "none"}},
        {"hydro": {"model": "assumed_pressure", "pressure": 100.0}},
        {"water": {"depth": 2.02}},
        {"device": {"shape": {"spheroid": {"height": 5.0}}, "mass": 2e4}, "modes": {"basis": "full"}},
    ],
    ids=str,
)
def test_a_study_without_a_second_solver_asks_none_whatever_the_reason(seed, changes):
    spectral = varied(seed, hydro={"solver": "auto"})
    asked, alone = (StudyPlan(varied(spectral, **given), root="r") for given in ({}, changes))
    assert asked.witness is not None
    assert list(asked.witness_files) == ["witness"]
    assert len(asked.deformed_paths) == 1 + 2 * len(asked.witness.meshes.deformed)
    assert (alone.witness, alone.witness_files, alone.deformed_paths) == (None, {}, [])
    assert ("witness" in asked.figures, "witness" in alone.figures) == (True, False)
    assert not any("/witness/" in path for path in alone.ids)
