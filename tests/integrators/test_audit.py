"""Energy audit: integrals over a step, work of every kind of force, random scenes; runs in legs and their records."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import varied
from hypothesis import given, settings
from hypothesis import strategies as st

from vsb.engine.hydro import database
from vsb.engine.hydro.radiation import RadiationModel, fit_radiation
from vsb.engine.integrators import settings as run_settings
from vsb.engine.integrators.audit import TERMS, energies, flow, residual
from vsb.engine.integrators.exact import propagate
from vsb.engine.integrators.simulate import legs, recorded, simulate
from vsb.engine.motion.builders import linear_scene
from vsb.engine.motion.forces import Damper, Excitation, RadiationMemory, Spring
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import Motion, System
from vsb.engine.waves.seas import sea
from vsb.errors import ConvergenceError
from vsb.models.rest import design_motions, reference_shell, study_basis


def one_mass(**forces):
    return Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1))


@pytest.mark.parametrize("count", [6, 40])
def test_work_of_a_polynomial_force_is_exact(count):
    """A force of fifth degree in time on a free mass: 1/2 m v^2."""
    time = np.linspace(0.0, 2.0, count)
    force = np.polynomial.Polynomial(np.random.default_rng(2).normal(size=6))
    velocity = (force / 2.0).integ()
    columns = [p(time)[:, None] for p in (velocity.integ(), velocity, force / 2.0)]
    motion, system = Motion(time, *columns, np.zeros((count, 0)), 0.0), System.of(one_mass())
    push = force(time)[:, None] @ system.shapes
    _, work = flow(system, motion, push).works(np.zeros((1, len(system.matrix), len(system.matrix))), [push])
    assert work == pytest.approx(velocity(time) ** 2, abs=1e-12)


def test_work_of_waves_converges_with_order_six():
    wave = Excitation(np.array([2.0, 3.3]), np.array([[30.0 + 5j], [-4j]]))
    plant = one_mass(hydrostatic=Spring(np.array([[50.0]])), pto=Damper(np.array([[9.0]])), excitation=wave)
    counts = np.array([60, 120, 240, 480])
    errors = []
    for count in counts:
        motion = propagate(System.of(plant), np.linspace(0.0, 20.0, count + 1), (np.array([0.2]), np.zeros(1)))
        errors.append(residual(energies(System.of(plant), motion)))
    slopes = -np.diff(np.log(errors)) / np.diff(np.log(counts))
    assert np.all(np.abs(slopes - 6.0) < 0.5), (errors, slopes)


@pytest.mark.parametrize("count", [2, 5])
def test_audit_of_few_records_closes(count):
    plant = one_mass(hydrostatic=Spring(np.array([[50.0]])), pto=Damper(np.array([[1.2]])))
    motion = propagate(System.of(plant), np.linspace(0.0, 5.0, count), (np.ones(1), np.zeros(1)))
    assert residual(energies(System.of(plant), motion)) < 1e-13


@pytest.fixture(scope="module")
def scene(seed, spectral_seed):
    """Function (design, changes but those of the water) -> linear scene, sea, settings, radiation damping."""
    radiation = fit_radiation(spectral_seed.spectrum, 1e-3)[0]

    def build(design="VSWEC", **changes):
        study = varied(seed, **changes)
        waves = sea(study.waves[0], 6.0, study.simulation.duration)
        basis = study_basis(study)
        ds = database.with_structure(spectral_seed.database, reference_shell(study))
        buoy = LinearSystem(ds, basis.damping, LinearPto(study.pto.damping))
        plant = linear_scene(buoy, radiation, waves, design_motions(study, basis, design))
        return plant, waves, study.simulation, buoy.spectrum

    return build


@settings(max_examples=15)
@given(st.integers(1, 4), st.integers(1, 6), st.floats(-2.0, 4.0), st.floats(-2.0, 1.0), st.integers(0, 10**6))
def test_audit_of_any_passive_scene_closes(dof, order, damping, step, seed):
    """Random masses, springs, dampers of any strength, radiation memory and record spacing."""
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(4, dof, dof))
    mass, stiffness, pto, structural = (root @ root.T / dof for root in roots)
    skew, channel = rng.normal(size=(order, order)), rng.normal(size=order)
    memory = RadiationModel(skew - skew.T - 0.5 * np.outer(channel, channel), rng.normal(size=(order, dof)), channel)
    forces = {
        "hydrostatic": Spring(5 * stiffness),
        "pto": Damper(10.0**damping * pto),
        "structural_damping": Damper(0.1 * structural),
        "radiation": RadiationMemory(memory),
    }
    plant = Scene(tuple("abcd"[:dof]), mass + np.eye(dof), forces, np.eye(dof))
    motion = propagate(System.of(plant), 10.0**step * np.arange(60), tuple(rng.normal(size=(2, dof))))
    assert residual(energies(System.of(plant), motion)) < 1e-10


def scaled(force, by):
    if isinstance(force, Spring):
        return Spring(by * force.stiffness)
    if isinstance(force, Damper):
        return Damper(by * force.damping)
    if isinstance(force, Excitation):
        return Excitation(force.omega, by * force.phasors)
    return RadiationMemory(replace(force.model, input_matrix=by * force.model.input_matrix))


@pytest.mark.parametrize("name", ["radiation", "pto", "excitation", "mass"])
def test_audit_detects_a_small_error_in_any_force(scene, name):
    """Audit of a motion in a scene that differs from its own by 1e-4 in one force or in mass."""
    plant, waves, settings, spectrum = scene()
    motion, _, _ = simulate(System.of(plant), waves, settings, spectrum)
    if name == "mass":
        other = replace(plant, mass=1.0001 * plant.mass)
    else:
        other = replace(plant, forces={**plant.forces, name: scaled(plant.forces[name], 1.0001)})
    sound = residual(energies(System.of(plant), motion))
    assert residual(energies(System.of(other), motion)) > 1e4 * sound
    assert residual(energies(System.of(other), motion)) > 1e-7


def test_run_whose_audit_does_not_close_is_refused(scene):
    """Action and reaction of the radiation memory differ by a thousandth."""
    plant, waves, settings, spectrum = scene("FSB")
    system = System.of(plant)
    matrix, n = system.matrix.copy(), system.free
    matrix[n : 2 * n, 2 * n :] *= 0.999
    with pytest.raises(ConvergenceError, match=r"audit does not close.*of the energy is missing, needs 1e-06"):
        simulate(replace(system, matrix=matrix), waves, settings, spectrum)


def in_legs(plant, waves, settings, spectrum, longest):
    """A run in legs of at most `longest` instants: the legs, and their motion and energies joined."""
    parts = list(legs(System.of(plant), waves, settings, spectrum, longest))
    first = [0] + [1] * (len(parts) - 1)
    position = np.concatenate([leg.motion.position[i:] for i, leg in zip(first, parts, strict=True)])
    energy = {
        term: np.concatenate([leg.energy[term][i:] for i, leg in zip(first, parts, strict=True)]) for term in TERMS
    }
    return parts, position, energy


def test_run_split_into_legs_equals_the_whole_run(scene):
    changes = {"duration": 20.0, "window": (10.0, 20.0)}
    waves = [{"kind": "jonswap", "hs": 1.0, "tp": 4.0}]
    plant, sea_, settings, spectrum = scene(waves=waves, simulation=changes)
    motion, _, _ = simulate(System.of(plant), sea_, settings, spectrum)
    energy = energies(System.of(plant), motion)
    parts, position, pieced = in_legs(plant, sea_, settings, spectrum, 300)
    assert len(parts) >= len(motion.time) // 300
    assert np.abs(position - motion.position).max() < 1e-11 * np.abs(motion.position).max()
    for term in TERMS:
        assert np.abs(pieced[term] - energy[term]).max() < 1e-9 * energy["pto"][-1], term
    assert parts[-1].balance.residual < 1e-6


def test_thinned_record_keeps_the_extremes(scene, monkeypatch):
    plant, waves, settings, spectrum = scene()
    (whole,) = legs(System.of(plant), waves, settings, spectrum)
    full = recorded(System.of(plant), whole, waves, settings.window)
    monkeypatch.setattr(run_settings, "KEPT", 1000)
    (leg,) = legs(System.of(plant), waves, settings, spectrum)
    run = recorded(System.of(plant), leg, waves, settings.window)
    assert leg.thinning == 5
    assert full.sizes["time"] // 5 < run.sizes["time"] < full.sizes["time"] // 5 + 50
    assert run.equals(full.sel(time=run.time))
    inside, all_inside = (one.sel(time=slice(*settings.window)) for one in (run, full))
    for name in ("position", "velocity"):
        assert float(np.ptp(inside[name].values, axis=0).min()) > 0
        assert np.array_equal(np.ptp(inside[name].values, axis=0), np.ptp(all_inside[name].values, axis=0)), name
    power = [float((-one.pto * one.velocity).sum("dof").max()) for one in (inside, all_inside)]
    assert power[0] == power[1]
