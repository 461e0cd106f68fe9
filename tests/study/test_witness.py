"""What the second solver of a study is asked depends on geometry, water and modes alone."""

import math

import pytest
import xarray as xr
from conftest import EXAMPLE, shipped, varied

from vsb.errors import ConfigError
from vsb.results.ledger import witness_checks
from vsb.study.blocks import LEAST_DEPTH_IN_WAVENUMBERS, panel_solver
from vsb.study.plan import StudyPlan, figure_names
from vsb.study.study import canonical, content_id, load
from vsb.study.witness import LONGEST, lowest_modes, no_witness
from vsb.waves.dispersion import wavenumber


def identity(study):
    return content_id(StudyPlan(study).witness)


SAME = {
    "material": {"device": {"young_modulus": 1e9, "density": 1000.0}},
    "pressure": {"device": {"internal_pressure": 1e3, "damping": {"alpha": 1.0}}},
    "dampers": {"pto": {"damping": 1.0}},
    "clamps": {"designs": {"only": {"clamp": 0}}},
    "seas": {"waves": [{"kind": "still"}]},
    "precision": {"hydro": {"tolerance": 1e-4, "omega_max": 5.0}},
    "solver": {"hydro": {"rows": 30}},
}
OTHER = {
    "size": {"device": {"radius": 2.1}},
    "mass": {"device": {"mass": 16000.0}},
    "thickness": {"device": {"thickness": 0.02}},
    "shapes": {"device": {"poisson_ratio": 0.4}},
    "basis": {"modes": {"basis": "full"}},
    "degree": {"modes": {"degree": 5}},
    "depth": {"water": {"depth": 30.0}},
    "density": {"water": {"density": 1000.0}},
    "gravity": {"water": {"gravity": 9.8}},
    "no shell": {"designs": {"FSB": {"flexible": False}}},
}


@pytest.mark.parametrize("change", SAME.values(), ids=SAME)
def test_studies_of_one_geometry_share_a_witness(seed, change):
    assert identity(varied(seed, **change)) == identity(seed)


@pytest.mark.parametrize("change", OTHER.values(), ids=OTHER)
def test_another_geometry_has_another(seed, change):
    assert identity(varied(seed, **change)) != identity(seed)


def test_about_an_equilibrium_it_is_the_shape_that_counts():
    study = load(EXAMPLE.with_name("pressurised.yaml"))
    assert identity(varied(study, device={"young_modulus": 1.1e7})) != identity(study)
    assert identity(varied(study, device={"damping": {"alpha": 1.0}})) == identity(study)


def test_the_version_of_the_panel_solver_counts(seed, monkeypatch):
    before = identity(seed)
    monkeypatch.setattr("vsb.study.witness.panel_solver", lambda: "capytaine 9")
    assert identity(seed) != before


def test_by_default_a_study_is_what_it_was(seed):
    assert "witness" not in canonical(seed)
    assert canonical(varied(seed, hydro={"witness": "auto"})) == canonical(seed)
    assert '"witness":"none"' in canonical(varied(seed, hydro={"witness": "none"}))
    with pytest.raises(ConfigError, match=r"hydro.witness: received 'maybe'; needs 'auto' or 'none'"):
        varied(seed, hydro={"witness": "maybe"})


@pytest.mark.parametrize(
    ("name", "change", "reason", "checks"),
    [
        ("seed", {"hydro": {"witness": "none"}}, "hydro.witness: none", 0),
        ("paper", {}, "an assumed pressure has no coefficients", None),
        ("seed", {"water": {"depth": 2.02}}, "the spectral solver needs a water.depth of 1.02 drafts", 1),
    ],
)
def test_where_there_is_none_the_reason_is_said(name, change, reason, checks):
    study = varied(load(shipped(name)), **change)
    plan = StudyPlan(study)
    assert no_witness(study) == reason
    assert plan.witness is None
    assert plan.deformed_paths == []
    assert plan.witness_files == {}
    assert "witness" not in figure_names(study)
    if checks is not None:
        found = witness_checks(study, xr.Dataset(), xr.Dataset())
        assert [check.verdict for check in found] == ["doubt"] * checks
        assert all(reason in check.explanation for check in found)


def test_twelve_modes_of_the_lowest_degrees_are_asked_for(seed):
    full = StudyPlan(varied(seed, modes={"basis": "full", "degree": 20})).witness.meshes
    six = (*(f"Membrane{n}" for n in range(7)), *(f"Bending{n}" for n in range(2, 7)))
    assert full.deformed == six
    assert len(StudyPlan(varied(seed, modes={"basis": "full", "degree": 20})).deformed_paths) == 25
    assert lowest_modes(tuple(f"Membrane{n}" for n in range(30))) == tuple(f"Membrane{n}" for n in range(12))
    assert StudyPlan(varied(seed, modes={"degree": 12})).witness.meshes.rows == 44  # eight on a lobe
    assert (StudyPlan(seed).witness.meshes.rows, StudyPlan(seed).witness.meshes.azimuth) == (32, 64)


def test_in_shallow_water_the_shortest_wave_is_half_the_longest_at_most(seed):
    """Of a flat float, whose draft is far below its radius."""
    flat = varied(seed, device={"mass": 150.0, "thickness": 0.001}, water={"depth": 0.3})
    low, _, high = (wavenumber(w, 0.3, 9.81) for w in StudyPlan(flat).witness.omega)
    assert low == pytest.approx(LEAST_DEPTH_IN_WAVENUMBERS / 0.3, rel=1e-4)
    assert high == pytest.approx(2 * low, rel=1e-4)


@pytest.mark.parametrize("depth", [math.inf, 100.0, 20.0, 2.5])
def test_waves_lie_around_the_resonance_of_heave_and_in_reach_of_both_solvers(seed, depth):
    spec = StudyPlan(varied(seed, water={"depth": depth})).witness
    assert len(spec.omega) == 3
    assert list(spec.omega) == sorted(set(spec.omega))
    wavenumbers = [w**2 / 9.81 for w in spec.omega]  # or larger
    assert wavenumbers[-1] * 2.0 == pytest.approx(3.0, rel=1e-2)
    if math.isinf(depth):
        assert wavenumbers[0] * 2.0 == pytest.approx(0.3, rel=1e-5)
    else:
        assert spec.omega[0] >= math.sqrt(9.81 * 0.3 / depth * math.tanh(0.3)) - 1e-5


@pytest.mark.parametrize("depth", [3.0, 10.0, math.inf])
def test_the_three_waves_are_in_geometric_progression_as_waves_of_that_depth(seed, depth):
    """Lengths, not frequencies: k of omega^2 = g k tanh(k d)."""
    spec = StudyPlan(varied(seed, water={"depth": depth})).witness
    low, middle, high = (wavenumber(w, depth, 9.81) for w in spec.omega)
    assert middle**2 == pytest.approx(low * high, rel=1e-4)
    assert low == pytest.approx(max(LONGEST / 2.0, LEAST_DEPTH_IN_WAVENUMBERS / depth), rel=1e-4)


def test_no_second_solver_is_of_another_shape_or_of_water_the_keel_touches(seed):
    spheroid = {
        "device": {"shape": {"spheroid": {"height": 3.0}}, "mass": 9e3},
        "modes": {"basis": "full", "degree": 2},
    }
    assert no_witness(varied(seed, **spheroid)) == "panels are those of the sphere"
    deep = varied(seed, water={"depth": 1.02 * seed.draft})
    assert no_witness(deep) == ""
    shallow = varied(seed, water={"depth": 1.0199 * seed.draft})
    assert no_witness(shallow) == "the spectral solver needs a water.depth of 1.02 drafts"


def test_meshes_are_of_the_water_and_the_shell_there_is(seed):
    flexible = varied(seed, water={"depth": 30.0}, device={"thickness": 0.02, "poisson_ratio": 0.4})
    spec = StudyPlan(flexible).witness
    meshes = spec.meshes
    assert meshes.depth == 30.0
    assert (meshes.lid_rows, meshes.azimuth) == (16, 2 * meshes.rows)
    assert (spec.water, spec.solver) == (flexible.water, panel_solver())
    assert (meshes.shape.radius, meshes.shape.centre_height) == (2.0, flexible.centre_height)
    assert (meshes.shape.thickness, meshes.shape.poisson_ratio, meshes.shape.basis) == (0.02, 0.4, "membrane")
    rigid = StudyPlan(varied(flexible, designs={"FSB": {"flexible": False}})).witness.meshes
    assert not hasattr(rigid.shape, "thickness")
    assert rigid.deformed == ()
