"""Stages spectral, panels, witness and database: blocks of two solvers, their comparison, and the database made of them."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import shipped, varied

from vsb.engine.hydro import database
from vsb.engine.shell.deformed import rigid_sphere
from vsb.errors import DatabaseError
from vsb.keys.quantities import content_id
from vsb.pipeline.graph import StudyPlan
from vsb.stages import panels
from vsb.stages import water as solving
from vsb.stages.make import make
from vsb.stages.water import spectral_problem
from vsb.study.specs import DatabaseSpec
from vsb.study.study import load
from vsb.tools import files


@pytest.mark.parametrize("name", ["seed", "pressurised"])
def test_spectral_problem_is_that_of_the_wetted_shape(name):
    study = load(shipped(name))
    plan = StudyPlan(study)
    problem = spectral_problem(plan.sweep_blocks[0])
    assert tuple(d.label for d in problem.displacements) == plan.displacements()
    keel = problem.shell.meridian(np.array([np.pi])).z[0]
    sphere = rigid_sphere(study.device.radius, study.centre_height).meridian(np.array([np.pi])).z[0]
    assert (keel == pytest.approx(sphere)) == (not study.at_equilibrium)


def test_panel_block_agrees_with_the_spectral_solver_within_its_error_estimate(seed, green_folder, tmp_path):
    found = {}
    for solver in ("panels", "spectral"):
        hydro = {"omega": [1.0, 2.0], "omega_max": 3.0} | ({"rows": 12} if solver == "panels" else {})
        (spec,) = StudyPlan(varied(seed, hydro=hydro, modes={"degree": 1})).tabulated_blocks
        out = tmp_path / f"{solver}.nc"
        if solver == "panels":
            panels.run_mesh(spec.mesh, str(tmp_path / "mean.nc"))
            panels.run_panels(spec, str(tmp_path / "mean.nc"), str(green_folder), str(out))
        else:
            solving.run_spectral(spec, str(out))
        found[solver] = files.load(out, expected=content_id(spec))
    for name in ("added_mass", "radiation_damping"):
        one, other = (found[solver][name].values for solver in found)
        assert one.shape == other.shape == (2, 2, 2)
        assert np.abs(one - other).max() < found["panels"].attrs["error_estimate"] * np.abs(other).max()


@pytest.mark.slow
def test_both_solvers_agree_within_their_error_estimates(seed, tmp_path):
    """Of a rigid sphere on few rows."""
    spec = StudyPlan(varied(seed, designs={"FSB": {"flexible": False}})).witness.spec
    spec = spec.model_copy(update={"meshes": spec.meshes.model_copy(update={"rows": 16, "azimuth": 32})})
    panels.run_deformed(spec.meshes, str(tmp_path / "meshes"))
    panels.run_witness(spec, str(tmp_path / "meshes"), str(tmp_path / "witness.nc"))
    ds = files.load(tmp_path / "witness.nc", expected=content_id(spec))
    assert tuple(ds.omega.values) == spec.omega
    assert (ds.witness_difference <= ds.witness_estimate.sum("solver")).all()
    assert float(ds.witness_difference.max()) < 0.02


def test_missing_or_foreign_block_is_refused(small, tmp_path):
    (name,) = small.database.spec.sweep
    with pytest.raises(DatabaseError, match=rf"{name}.nc: file not found"):
        solving.run_database(small.database.spec, str(tmp_path), str(tmp_path / "out.nc"))
    block = files.load(small.block_path(small.sweep_blocks[0]))
    files.save(block.assign_attrs(spec_id="0" * 16), tmp_path / f"{name}.nc")
    with pytest.raises(DatabaseError, match=rf"{name}.nc: holds block 0+, needs {name}; delete it and run again"):
        solving.run_database(small.database.spec, str(tmp_path), str(tmp_path / "out.nc"))
    assert not (tmp_path / "out.nc").exists()


def test_failed_check_stops_unless_accepted(small, tmp_path):
    """Damping of the wrong size violates Haskind's relation; solved again it does, too, of water that is too dense."""
    (name,) = small.database.spec.sweep
    shutil.copy(small.block_path(small.sweep_blocks[0]), tmp_path)
    block = files.load(tmp_path / f"{name}.nc")
    other = json.loads(block.attrs["spec"])
    other["water"]["density"] *= 1.3
    damaged = block.assign(radiation_damping=1.3 * block.radiation_damping).assign_attrs(spec=json.dumps(other))
    files.save(damaged, tmp_path / f"{name}.nc")
    out = str(tmp_path / "db" / "out.nc")
    with pytest.raises(DatabaseError, match=r"hydro database: check '\w+' failed: .*list the name under hydro.accept"):
        solving.run_database(small.database.spec, str(tmp_path), out)
    assert not Path(out).exists()
    spec = DatabaseSpec(**{**small.database.spec.model_dump(), "accept": ("haskind", "kramers_kronig")})
    solving.run_database(spec, str(tmp_path), out)
    assert "accepted" in files.load(out).attrs["quality"]


def test_coefficients_too_coarse_for_a_check_are_solved_again(tmp_path):
    """Interpolation to a thousandth of the largest damping leaves 7 % of that of the fourth bending mode, a 400th of it.

    Haskind's relation then fails; ten times finer it holds a hundred times better, and the history says so.
    """
    plan = StudyPlan(load(written_study(tmp_path, GENT)), root=str(tmp_path))
    make(plan, [plan.database.out])
    ds = files.load(plan.database.out)
    assert re.search(r"solved again to 0.1 of the tolerance: haskind 0.07\d+ became 0.000\d+$", ds.attrs["history"])
    assert all(check.verdict == "ok" for check in database.stored_checks(ds))


GENT = """
study: gent
device: {radius: 0.56, thickness: 0.0165, density: 1100.0, mass: 395.0, internal_pressure: 6707.0,
         material: {law: gent, mu: 196395.0, jm: 57.9}}
reference_shape: equilibrium
modes: {basis: full, degree: 4}
designs: {V: {}}
water: {density: 1000.0, depth: 1.51}
hydro: {tolerance: 1.0e-3, omega_max: 21.1, witness: none}
pto: {damping: 73.0}
waves: [{kind: still}]
"""


def written_study(folder, text):
    """The path of a study file with a text."""
    path = folder / "study.yaml"
    path.write_text(text)
    return path


@pytest.mark.slow
def test_sway_and_roll_are_surge_and_pitch_turned(seed, tmp_path):
    """By 90 degrees about the vertical axis, so that pitch becomes negative roll. Yaw moves no water; damping of surge is Haskind's, k |X|^2/(8 rho g v_g); the mooring is as given."""
    mooring = [2e4, 3e4, 1e3, 4e3, 5e3, 6e3]
    device = {"centre_of_mass": -0.3, "ballast_inertia": 5e3, "ballast_yaw_inertia": 7e3}
    hydro = {"omega_max": 4.0, "tolerance": 1e-2, "witness": "none"}
    study = varied(seed, motion="free", mooring=mooring, device=device, modes={"degree": 2, "order": 1}, hydro=hydro)
    plan = StudyPlan(study, root=str(tmp_path))
    make(plan, [plan.database.out])
    ds = files.load(plan.database.out)
    labels, order = list(ds.influenced_dof.values), ds.azimuthal_order.values
    even, odd = ([label for label, m in zip(labels, order, strict=True) if m == sign] for sign in (1, -1))
    assert {"Surge", "Pitch"} <= set(even)
    assert {"Sway", "Roll"} <= set(odd)
    signs = [-1 if label == "Pitch" else 1 for label in even]
    for name in ("added_mass", "radiation_damping", "hydrostatic_stiffness", "inertia_matrix"):
        along, across = (ds[name].sel(influenced_dof=own, radiating_dof=own).values for own in (even, odd))
        turned = along * np.outer(signs, signs)
        np.testing.assert_allclose(across, turned, rtol=1e-9, atol=1e-9 * np.abs(along).max(), err_msg=name)
    force = ds.excitation_force
    ahead = force.sel(influenced_dof=even).sel(wave_direction=0.0).values
    abeam = force.sel(influenced_dof=odd).sel(wave_direction=np.pi / 2, method="nearest").values
    np.testing.assert_allclose(abeam, signs * ahead, rtol=1e-9, atol=1e-9 * np.abs(ahead).max())
    assert not ds.added_mass.sel(influenced_dof="Yaw").values.any()
    k, omega = ds.omega.values**2 / 9.81, ds.omega.values
    haskind = k * np.abs(ahead[:, even.index("Surge")]) ** 2 / (8 * 1025.0 * 9.81 * 9.81 / (2 * omega))
    surge = {"influenced_dof": "Surge", "radiating_dof": "Surge"}
    np.testing.assert_allclose(ds.radiation_damping.sel(surge).values, haskind, rtol=1e-9)
    names = ("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")
    stored = [float(ds.mooring_stiffness.sel(influenced_dof=name, radiating_dof=name)) for name in names]
    assert stored == mooring
