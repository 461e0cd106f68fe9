import pytest
from conftest import varied

from vsb.config import content_id
from vsb.errors import ConfigError
from vsb.specs import StudyPlan, figure_names, frequency_step, tolerance_rows, wave_rows


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
    grid = [w for block in StudyPlan(seed).sweep_blocks[1:] for w in block["omega"]]
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


def test_rigid_study_solves_heave_alone(seed):
    plan = StudyPlan(varied(seed, designs={"FSB": {"flexible": False}}))
    assert plan.velocity_degrees == (1,)
    assert plan.mode_labels == ()
    assert [path.rsplit("/")[-1] for path in plan.display_paths] == ["mean.vtu"]


def test_labels_are_those_of_the_basis(seed):
    from vsb.modes import study_basis

    for basis in ("paper", "membrane", "full"):
        study = varied(seed, modes={"basis": basis, "degree": 4})
        assert study_basis(study).labels[1:] == StudyPlan(study).mode_labels


def test_figures_are_known_beforehand():
    assert len(figure_names(["a", "b"])) == 4 + 2 * 5
