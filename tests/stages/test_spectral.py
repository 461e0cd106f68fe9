"""Rule spectral: a block without panels, swept or solved at every frequency."""

import numpy as np
import pytest
import xarray as xr
from conftest import SEED, shipped, varied
from study.test_shape import OBLATE, raw

from vsb.hydro.dofs import displacements
from vsb.shell.deformed import rigid_sphere
from vsb.stages import spectral
from vsb.stages.stage import stamp
from vsb.study.plan import StudyPlan
from vsb.study.study import content_id, load, parse
from vsb.tools import files


def test_the_problem_is_that_of_the_wetted_shape():
    for name in ("seed", "pressurised"):
        study = load(shipped(name))
        plan = StudyPlan(study)
        problem = spectral.spectral_problem(plan.sweep_blocks[0])
        assert tuple(d.label for d in problem.displacements) == plan.displacements()
        keel = problem.shell.meridian(np.array([np.pi])).z[0]
        sphere = rigid_sphere(study.device.radius, study.centre_height).meridian(np.array([np.pi])).z[0]
        assert (keel == pytest.approx(sphere)) == (not study.at_equilibrium)


def test_a_sweep_is_as_fine_as_its_interpolation_wants(monkeypatch, tmp_path):
    """Which is not the tolerance of the boundary elements."""
    spec = StudyPlan(load(SEED)).sweep_blocks[0].model_copy(update={"interpolation": 0.25})
    asked = []

    def converged(problem, omega, *tolerances):
        asked.append((tuple(omega), *tolerances))
        return xr.Dataset()

    monkeypatch.setattr(spectral, "converged_on_grid", converged)
    monkeypatch.setattr(spectral, "save", lambda ds, path: None)
    spectral.run(spec, str(tmp_path / "block.nc"))
    assert asked == [(spec.omega, spec.tolerance, 0.25)]
    assert spec.tolerance != 0.25


@pytest.mark.parametrize("tabulated", [False, True])
def test_a_block_is_swept_if_it_is_to_be_interpolated(small, tmp_path, tabulated):
    plan = StudyPlan(varied(small.study, hydro={"omega": [1.0, 2.0]})) if tabulated else small
    spec = (plan.tabulated_blocks if tabulated else plan.sweep_blocks)[0]
    spectral.run(spec, str(tmp_path / "block.nc"))
    ds = files.load(tmp_path / "block.nc", expected=content_id(spec))
    assert tuple(ds.omega.values) == spec.omega
    assert (ds.attrs["solves"] < ds.attrs["frequencies"]) == (not tabulated)
    assert ("interpolation_error" in ds.attrs) == (not tabulated)
    assert ds.attrs["error_estimate"] <= spec.tolerance


@pytest.mark.parametrize("interpolation", [None, 0.25])
def test_a_block_is_solved_to_its_tolerance_and_stored_with_its_id_and_seconds(monkeypatch, interpolation):
    """All of its frequencies, or as many as interpolation asks for: of the problem of its specification."""
    spec = StudyPlan(load(SEED)).sweep_blocks[0].model_copy(update={"interpolation": interpolation})
    asked, saved = [], []
    monkeypatch.setattr(spectral, "spectral_problem", lambda given: asked.append(given) or "problem")
    for name in ("converged", "converged_on_grid"):
        monkeypatch.setattr(spectral, name, lambda *given, name=name: asked.append((name, *given)) or xr.Dataset())
    monkeypatch.setattr(spectral, "save", lambda *given: saved.append(given))
    spectral.run(spec, "block.nc")
    one = ("converged_on_grid", "problem", list(spec.omega), spec.tolerance, 0.25)
    assert asked == [spec, one if interpolation else ("converged", *one[1:-1])]
    ((ds, out),) = saved
    assert out == "block.nc"
    assert {name: ds.attrs[name] for name in ("spec", "spec_id")} == stamp(spec)
    assert 0 <= ds.attrs["seconds"] < 60


@pytest.mark.parametrize("depth", [np.inf, 9.0])
@pytest.mark.parametrize(("order", "labels"), [(0, ("Radial0", "Radial1")), (1, ("Surge", "Radial2"))])
@pytest.mark.parametrize("shape", [None, OBLATE])
def test_the_problem_of_a_block_is_of_its_water_its_order_and_its_displacements(depth, order, labels, shape):
    """From the fewest points on; of a shape of its own where there is one, at its height."""
    study = load(SEED) if shape is None else parse(raw(shape, device={"mass": 9e3}))
    water = study.water.model_copy(update={"depth": depth, "density": 1010.0, "gravity": 9.7})
    block = StudyPlan(study).sweep_blocks[0]
    spec = block.model_copy(update={"water": water, "order": order, "displacements": labels})
    problem = spectral.spectral_problem(spec)
    assert (problem.density, problem.gravity, problem.depth) == (1010.0, 9.7, depth)
    assert problem.displacements == displacements(labels, order)
    assert problem.order == order
    assert problem.nodes == 16
    keel = problem.shell.meridian(np.array([np.pi])).z[0]
    across = problem.shell.meridian(np.array([np.pi / 2])).x[0]
    own = study.device.radius if shape is None else 1.5
    assert keel == pytest.approx(spec.shape.centre_height - own)
    assert spec.shape.centre_height != 0.0
    assert across == pytest.approx(study.device.radius)
