"""Rule spectral: a block without panels, swept or solved at every frequency."""

import numpy as np
import pytest
import xarray as xr
from conftest import SEED, varied

from vsb.shell.deformed import rigid_sphere
from vsb.stages import spectral
from vsb.study.plan import StudyPlan
from vsb.study.study import content_id, load
from vsb.tools import files


def test_the_problem_is_that_of_the_wetted_shape():
    for name in ("seed", "pressurised"):
        study = load(SEED.with_name(f"{name}.yaml"))
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
