import itertools
import math

import numpy as np
import pytest
import yaml
from conftest import SEED, varied
from hypothesis import given
from hypothesis import strategies as st

from vsb.errors import ConfigError
from vsb.hydro.panels.mesh import graded_colatitudes
from vsb.study import study as config
from vsb.study.plan import StudyPlan, figure_names
from vsb.study.resolution import frequency_step, tolerance_rows, wave_rows
from vsb.study.specs import SpectralSpec
from vsb.study.study import content_id


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


def test_grid_is_absolute_and_round(seed):
    grid = [w for block in StudyPlan(seed).sweep_blocks[1:] for w in block.omega]
    assert grid[:3] == [0.1, 0.2, 0.3]
    assert grid == [round(0.1 * i, 1) for i in range(1, 129)]


@pytest.mark.parametrize(("radius", "step"), [(2.0, 0.1), (5.0, 0.05), (20.0, 0.02), (0.5, 0.2), (1.9, 0.1)])
def test_step_scales_with_the_body(radius, step):
    assert frequency_step(radius, 9.81) == step


def test_resolution_follows_tolerance_and_wavelength():
    assert [tolerance_rows(t) for t in (4e-3, 1e-3, 2.5e-4)] == [20, 40, 80]
    assert wave_rows(2.0, 0.2) > wave_rows(2.0, 0.8) > wave_rows(2.0, 10.0)


def test_wave_too_short_for_the_mesh_is_refused(seed):
    with pytest.raises(
        ConfigError, match=r"hydro.omega_max: received 12 .* too short for the mesh: it needs \d+ rows .* raise"
    ):
        block_ids(varied(seed, hydro={"rows": 8}))
    with pytest.raises(
        ConfigError, match=r"hydro.omega_max: received 100 rad/s, .* there are 160; lower hydro.omega_max$"
    ):
        block_ids(varied(seed, hydro={"omega_max": 100.0}))


def test_tolerance_beyond_the_finest_mesh_is_refused(seed):
    with pytest.raises(ConfigError, match=r"hydro.tolerance: received 1e-05, needs at least 6.25e-05"):
        block_ids(varied(seed, hydro={"tolerance": 1e-5}))


def test_rigid_study_solves_heave_alone(seed):
    plan = StudyPlan(varied(seed, designs={"FSB": {"flexible": False}}))
    assert plan.displacements == ("Radial1",)
    assert plan.mode_labels == ()
    assert [path.rsplit("/")[-1] for path in plan.display_paths] == ["mean.vtu"]


def test_labels_are_those_of_the_basis(seed):
    from vsb.shell.modes import study_basis

    for basis in ("paper", "membrane", "full"):
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


def test_an_assumed_pressure_needs_no_bem(seed):
    plan = StudyPlan(varied(seed, hydro={"model": "assumed_pressure", "pressure": 100.0}))
    assert plan.bem_blocks == plan.hydro_files == plan.response_files == {}
    assert not [path for path in plan.products if "/hydro/db" in path or "response" in path]
    assert plan.simulation("FSB", plan.study.waves[0]).hydro.pressure == 100.0


@pytest.mark.parametrize("wider", [13.0, 14.0, 16.0, 19.2])
def test_blocks_of_a_wider_band_begin_with_those_of_the_narrow_one(seed, wider):
    narrow, wide = (
        [content_id(b) for b in StudyPlan(varied(seed, hydro={"omega_max": w})).sweep_blocks] for w in (12.0, wider)
    )
    assert wide[: len(narrow)] == narrow
    assert len(wide) == 1 + math.ceil(wider / 3.2 - 1e-9)


@given(st.floats(0.3, 16.0))
def test_sweep_covers_the_band_without_gap_or_repetition(seed, omega_max):
    infinite, *blocks = StudyPlan(varied(seed, hydro={"omega_max": omega_max}, waves=[{"kind": "still"}])).sweep_blocks
    grid = [w for block in blocks for w in block.omega]
    assert infinite.omega == (math.inf,)
    assert grid == [round(0.1 * i, 1) for i in range(1, len(grid) + 1)]
    assert omega_max <= grid[-1] + 1e-6
    assert grid[-1] < omega_max + 3.2 + 1e-6


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


def test_tabulated_frequencies_are_kept_in_blocks_of_32(seed):
    omega = [0.1 * i for i in range(1, 71)]
    blocks = StudyPlan(varied(seed, hydro={"omega": omega})).tabulated_blocks
    assert [len(block.omega) for block in blocks] == [32, 32, 6]
    assert list(itertools.chain.from_iterable(block.omega for block in blocks)) == omega
    assert StudyPlan(seed).tabulated_blocks == []


@given(st.floats(0.01, 1000.0), st.floats(1.0, 30.0))
def test_step_is_the_largest_round_number_below_its_bound(radius, gravity):
    step, bound = frequency_step(radius, gravity), 0.05 * math.sqrt(gravity / radius)
    assert step <= bound * (1 + 1e-12)
    assert bound < 2.5 * step * (1 + 1e-12)
    assert f"{step:.0e}"[0] in "125"
    assert float(f"{step:.0e}") == step


@given(st.floats(0.02, 5.0), st.integers(-2, 2))
def test_step_scales_with_the_root_of_the_radius(radius, decades):
    bound = 0.05 * math.sqrt(9.81 / radius)
    if abs(frequency_step(radius, 9.81) / bound - 1) > 1e-9:  # not on the edge between two steps
        scaled = frequency_step(radius * 100.0**decades, 9.81)
        assert scaled == pytest.approx(frequency_step(radius, 9.81) / 10.0**decades, rel=1e-12)


@given(st.floats(1e-5, 0.1))
def test_rows_grow_with_the_root_of_the_tolerance(tolerance):
    rows = tolerance_rows(tolerance)
    assert rows % 2 == 0
    assert 1e-3 * (40 / rows) ** 2 <= tolerance * (1 + 1e-12)  # second order: the error is met


@pytest.mark.parametrize(("radius", "wavelength"), [(2.0, 0.1), (2.0, 0.43), (2.0, 3.0), (5.0, 1.0)])
def test_six_rows_lie_within_half_a_wavelength_of_the_surface(radius, wavelength):
    rows = wave_rows(radius, wavelength)
    depth = -radius * np.cos(graded_colatitudes(np.pi / 2, rows))
    assert np.sum(depth[1:] <= wavelength / 2 * (1 + 1e-12)) >= 6


@pytest.mark.parametrize(("rows", "azimuth"), [(20, 40), (48, 96)])
def test_rows_of_a_study_are_used_as_given(seed, rows, azimuth):
    resolution = StudyPlan(varied(seed, hydro={"rows": rows, "omega_max": 6.0})).resolution(6.0)
    assert (resolution.rows, resolution.azimuth) == (rows, azimuth)
    assert resolution.lid_rows >= 16


def test_finer_tolerance_needs_more_rows(seed):
    rows = [
        StudyPlan(varied(seed, modes={"degree": 2}, hydro={"tolerance": t})).resolution(3.0).rows
        for t in (4e-3, 1e-3, 2.5e-4)
    ]
    assert rows == [20, 40, 80]


def test_paths_lie_under_the_root_and_name_their_ids(seed):
    plan = StudyPlan(seed, root="elsewhere")
    block = plan.sweep_blocks[0]
    assert plan.database_path == f"elsewhere/hydro/db/{database_id(seed)}.nc"
    assert plan.block_path(block) == f"elsewhere/hydro/blocks/{content_id(block)}.nc"
    assert plan.mesh_path(block.mesh) == f"elsewhere/hydro/mesh/{content_id(block.mesh)}/mean.nc"
    assert plan.trajectory_path("FSB", "still") == "elsewhere/seed/trajectories/FSB-still.nc"
    assert len(set(plan.display_paths)) == 1 + 2 * 7


def test_solver_follows_from_depth_and_rows(seed):
    auto = {"solver": "auto"}
    assert not varied(seed, hydro=auto).uses_panels
    assert not varied(seed, hydro=auto, water={"depth": 20.0}).uses_panels
    assert varied(seed, hydro=auto, water={"depth": 1.01 * seed.draft}).uses_panels
    assert varied(seed, hydro={**auto, "rows": 20}).uses_panels
    assert not varied(seed, hydro={"model": "assumed_pressure", "pressure": 1.0}).uses_panels
    with pytest.raises(ConfigError, match=r"hydro.solver 'spectral': needs a water.depth of at least 1.02 drafts"):
        varied(seed, hydro={"solver": "spectral"}, water={"depth": 1.01 * seed.draft})
    with pytest.raises(ConfigError, match=r"hydro.solver 'spectral': has no rows"):
        varied(seed, hydro={"solver": "spectral", "rows": 20})


def test_spectral_plan_is_one_job_without_a_mesh(seed):
    plan = StudyPlan(varied(seed, hydro={"solver": "spectral"}))
    (block,) = plan.sweep_blocks
    assert isinstance(block, SpectralSpec)
    assert list(block.omega) == [round(0.1 * i, 1) for i in range(1, 129)]
    assert block.omega[0] == plan.first_omega == plan.step
    wide = StudyPlan(varied(seed, hydro={"solver": "spectral", "omega_max": 15.0}))
    with pytest.raises(ConfigError, match=r"hydro.omega_max: received 15 rad/s, needs at most 14.01 rad/s"):
        wide.check_waves()


@pytest.mark.parametrize(("tolerance", "half"), [(1e-1, 5e-4), (1e-3, 5e-4), (1e-4, 5e-5)])
def test_the_sweep_is_interpolated_to_half_the_tolerance_and_what_is_tabulated_is_not(seed, tolerance, half):
    hydro = {"solver": "spectral", "tolerance": tolerance, "omega": [1.0, 2.0]}
    plan = StudyPlan(varied(seed, hydro=hydro))
    assert plan.sweep_blocks[0].interpolation == half
    assert "interpolation" not in plan.tabulated_blocks[0].model_dump()
    by_panels = StudyPlan(varied(seed, hydro={"tolerance": max(tolerance, 1e-3), "omega": [1.0, 2.0]}))
    infinite, *blocks = by_panels.sweep_blocks
    assert {block.interpolation for block in blocks} == {max(half, 5e-4)}
    assert not [block for block in (infinite, *by_panels.tabulated_blocks) if "interpolation" in block.model_dump()]


@pytest.mark.parametrize(("omega_max", "shared"), [(9.7, True), (12.8, True), (12.9, False), (9.6, False)])
def test_bands_that_end_in_the_same_block_share_their_sweep(seed, omega_max, shared):
    ours, theirs = (
        StudyPlan(varied(seed, hydro={"solver": "spectral", "omega_max": w})).sweep_blocks for w in (12.0, omega_max)
    )
    assert (ours == theirs) is shared


@pytest.mark.parametrize(
    ("depth", "tolerance", "finer"),
    [
        *((math.inf, t, n) for t, n in ((1e-2, 1), (1e-4, 1), (8e-5, 2), (2.5e-5, 2), (1e-5, 4), (1e-6, 16))),
        *((5.0, t, n) for t, n in ((1e-2, 1), (1e-3, 4), (1e-4, 8), (1e-5, 16), (1e-6, 32))),
    ],
)
def test_a_tight_tolerance_refines_the_grid_that_is_interpolated(seed, depth, tolerance, finer):
    hydro = {"solver": "spectral", "tolerance": tolerance}
    plan = StudyPlan(varied(seed, hydro=hydro, water={"depth": depth}))
    assert plan.step == pytest.approx(0.1 / finer)
    grid = [w for block in plan.sweep_blocks for w in block.omega]
    assert np.diff(grid) == pytest.approx(np.full(len(grid) - 1, 0.1 / finer))


def test_the_spectral_solver_tabulates_frequencies_below_its_grid_and_panels_do_not(seed):
    asked = {"omega": [0.01, 2.0]}
    plan = StudyPlan(varied(seed, hydro={"solver": "spectral", **asked}))
    assert plan.tabulated_blocks[0].omega == (0.01, 2.0)
    assert plan.response.omega == tuple(sorted({2.0, *(w.omega for w in plan.study.waves)}))
    with pytest.raises(ConfigError, match=r"hydro.omega: received 0.01 rad/s, needs at least 0.1 rad/s with panels in"):
        StudyPlan(varied(seed, hydro=asked)).tabulated_blocks  # noqa: B018


def test_of_several_realisations_one_is_drawn(seed):
    sea = {"kind": "jonswap", "hs": 1.0, "tp": 4.0, "realisations": 3}
    study = varied(seed, waves=[{"kind": "still"}, sea, {**sea, "hs": 2.0, "seed": 4}])
    drawn = {name.partition("-")[2] for name in figure_names(study)} - {""}
    assert drawn == {"still", "jonswap_Hs1_Tp4_g3.3_s1", "jonswap_Hs2_Tp4_g3.3_s4"}
    assert len(study.waves) == 7


@pytest.mark.parametrize(
    "wave", [{"kind": "white_noise", "hs": 0.5, "band": [0.01, 1.0]}, {"kind": "jonswap", "hs": 0.5, "tp": 28.0}]
)
def test_a_sea_below_the_lowest_frequency_solved_is_refused(seed, wave):
    with pytest.raises(ConfigError, match=r"waves.0: received .*from 0.0.* rad/s on; needs at least 0.1 rad/s"):
        StudyPlan(varied(seed, waves=[wave])).check_waves()


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


@given(st.floats(0.3, 5.0), st.floats(3.0, 12.0), st.sampled_from([1e-3, 1e-4, 1e-2]), st.sampled_from([math.inf, 9.0]))
def test_the_database_reaches_any_highest_frequency_asked_for(seed, radius, highest, tolerance, depth):
    device = {"radius": radius, "thickness": 0.005 * radius, "mass": 2100.0 * radius**3}
    water = {"depth": depth}
    study = varied(seed, device=device, water=water, hydro={"omega_max": highest, "tolerance": tolerance})
    plan = StudyPlan(study)
    assert highest - 1e-9 <= plan.highest_omega < highest + plan.step
    assert plan.highest_omega in plan.sweep_blocks[-1].omega
    on_grid = StudyPlan(varied(study, hydro={"omega_max": plan.highest_omega}))
    assert content_id(on_grid.database) == content_id(plan.database)  # what is solved names it, not what was asked
