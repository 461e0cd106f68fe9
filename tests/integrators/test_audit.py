"""Energy audit: integrals over a step, work of every kind of force, random scenes; runs in legs and their records."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import xarray as xr
from conftest import SEED, varied
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from vsb.engine.hydro import database
from vsb.engine.hydro.radiation import DampingSpectrum, RadiationModel, fit_radiation
from vsb.engine.integrators import settings as run_settings
from vsb.engine.integrators.audit import TERMS, absorbed_power, energies, flow, residual
from vsb.engine.integrators.exact import propagate
from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.integrators.simulate import METHODS, legs, recorded, simulate
from vsb.engine.motion.forces import (
    EXCITING,
    AssumedPressure,
    Damper,
    Excitation,
    QuadraticDrag,
    RadiationMemory,
    Spring,
)
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene, assumed_pressure_scene, body_exact_scene, linear_scene
from vsb.engine.motion.system import Motion, System
from vsb.engine.motion.take_off import Pto
from vsb.engine.waves.seas import Sea
from vsb.errors import ConvergenceError
from vsb.models.build import with_latching_time
from vsb.models.rest import design_motions, reference_shell, study_basis
from vsb.models.take_off import with_take_off
from vsb.study.study import load


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
        waves = study.waves[0].realisation(6.0, study.simulation.duration)
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


PERIOD = 4.0
SEA = Sea(np.array([2 * np.pi / PERIOD]), np.array([0.15 + 0.0j]))
OMEGA = np.linspace(0.02, 12.0, 400)
STIFFNESS = 9e3


@cache
def parts():
    """A study, its shell, a made-up database with one resonant radiation channel, and the radiation fitted to it."""
    study = varied(
        load(SEED),
        designs={"FSB": {"flexible": False}, "VSWEC": {}},
        modes={"basis": "membrane", "degree": 2},
        device={"young_modulus": 3e7},
    )
    reference = reference_shell(study)
    basis, dof = reference.basis, len(reference.basis.labels)
    direction, pair = np.linspace(1.0, 0.2, dof), ("influenced_dof", "radiating_dof")
    damping = 4e3 * (OMEGA / 2) ** 3 * np.exp(-((OMEGA / 2) ** 2)) * np.e
    swept = damping[:, None, None] * np.outer(direction, direction)
    push = 6e4 * np.exp(-0.2 * OMEGA**2)[:, None, None] * direction
    values = {
        "inertia_matrix": (pair, basis.inertia), "added_mass_inf": (pair, 8e3 * np.outer(direction, direction)),
        "added_mass": (("omega", *pair), 0 * swept), "radiation_damping": (("omega", *pair), swept),
        "mooring_stiffness": (pair, 700.0 * np.outer(direction, direction)),
        **{f"{name}_stiffness": (pair, k) for name, k in reference.stiffness.items()},
        **{f"{name}_force": (("omega", "wave_direction", pair[0]), share * push + 0j)
           for name, share in (("excitation", 1.0), ("diffraction", 0.4), ("Froude_Krylov", 0.6))},
    }  # fmt: skip
    attrs = {"water_density": 1025.0, "gravity": 9.81, "water_depth": "inf"}
    ds = xr.Dataset(values, {"omega": OMEGA, "influenced_dof": list(basis.labels)}, attrs)
    spectrum = DampingSpectrum(OMEGA, swept)
    return study, reference, LinearSystem(ds, basis.damping, LinearPto(0.0)), spectrum, fit_radiation(spectrum, 1e-4)[0]


def scene_of(model, design, pto, chamber=0.0, *, drag=False, port=None):
    """A scene of one model with a take-off; moored except under an assumed pressure."""
    study, reference, buoy, _, radiation = parts()
    motions, linear = design_motions(study, reference.basis, design), LinearPto(pto.damping, pto.stiffness, port)
    if model == "assumed_pressure":
        load_ = AssumedPressure(900.0, 2 * np.pi / PERIOD)
        scene = assumed_pressure_scene(reference.shape, linear, load_, 1025.0, 9.81, motions)
    elif model == "linear":
        scene = linear_scene(replace(buoy, pto=linear, chamber=chamber), radiation, SEA, motions)
    else:
        scene = body_exact_scene(replace(buoy, pto=linear), reference.shape, radiation, SEA, motions)
    scene = with_take_off(scene, pto, linear)
    if pto.has_latching_time:
        scene = with_latching_time(scene, 0.4)
    if drag:
        heave = np.eye(len(scene.labels))[:1]
        water = QuadraticDrag(heave, np.array([2e3]), SEA.omega, 0.2j * np.ones((1, 1)))
        scene = replace(scene, forces={**scene.forces, "drag": water})
    return scene


def integral(time, power):
    """Integral since the start by a cubic spline through the records."""
    return CubicSpline(time, power).antiderivative()(time)


def taken_by_law(pto, scene, motion, q, v, port):
    """Power of the take-off [W] for laws that depend on stroke and velocity only, its spring storing what it takes."""
    rest = float(port @ scene.motions @ scene.rest) if "water" in scene.forces and scene.origin.size else 0.0
    speed, stroke = v @ port, q @ port - rest
    if pto.law == "coulomb":
        return pto.force_limit * np.abs(speed)
    if pto.nonlinear:
        spring, most = pto.stiffness * stroke, pto.force_limit
        return (np.clip(pto.damping * speed + spring, -most, most) - np.clip(spring, -most, most)) * speed
    return pto.damping * speed**2


HEAVE, SHELL = "heave", "shell"
TAKE_OFFS: dict[str, dict[str, object]] = {
    "damper": {}, "spring": {"stiffness": STIFFNESS}, "negative spring": {"stiffness": -STIFFNESS},
    "saturated": {"law": "saturated", "force_limit": 1500.0},
    "saturated spring": {"law": "saturated", "force_limit": 1500.0, "stiffness": STIFFNESS},
    "coulomb": {"law": "coulomb", "force_limit": 1200.0},
    "latching": {"law": "latching", "stiffness": STIFFNESS}, "declutching": {"law": "declutching"},
    "end stop": {"stroke_limit": 0.05, "stiffness": STIFFNESS},
}  # fmt: skip
SMOOTH = ("damper", "spring", "negative spring")
CASES = [
    *(("linear", "FSB", name, "switching", {}) for name in TAKE_OFFS if name not in SMOOTH),
    ("body_exact", "VSWEC", "saturated", "switching", {}), ("body_exact", "VSWEC", "latching", "switching", {}),
    ("assumed_pressure", "FSB", "end stop", "switching", {}),
    ("linear", "VSWEC", "damper", "exact", {}), ("linear", "VSWEC", "negative spring", "convolution", {}),
    ("body_exact", "VSWEC", "spring", "exponential", {}), ("assumed_pressure", "VSWEC", "negative spring", "exponential", {}),
    ("body_exact", "FSB", "spring", "exponential", {}), ("assumed_pressure", "FSB", "spring", "collocation", {}),
    *((model, "VSWEC", "spring", "collocation", {"drag": True}) for model in ("linear", "body_exact")),
    ("body_exact", "VSWEC", "spring", "exponential", {"port": SHELL}),
    *(("linear", "VSWEC", name, "exact", {"port": SHELL, "chamber": 2e-6}) for name in ("spring", "negative spring")),
]  # fmt: skip


@pytest.mark.parametrize(
    ("model", "design", "name", "method", "more"),
    [
        pytest.param(*case, marks=pytest.mark.slow) if case[0] != "linear" and case[3] == "switching" else case
        for case in CASES
    ],
)
def test_work_of_every_force_equals_force_times_velocity(model, design, name, method, more):
    """Each term of the audit against the integral of -f.v less the potential energy; all powers give the kinetic energy."""
    more = dict(more)
    pto = Pto.model_validate({"damping": 2e4, **TAKE_OFFS[name]})
    dof = len(parts()[1].basis.labels)
    b = np.linspace(-0.5, 0.6, dof) if more.pop("port", HEAVE) == SHELL else np.eye(dof)[0]
    scene = scene_of(model, design, pto, port=b, **more)
    system, time = System.of(scene), np.linspace(0.0, 1.25 * PERIOD, 2001 if method == "convolution" else 4001)
    spectrum, tolerance = parts()[3], 1e-9
    start = scene.start(0.02, 0.1)
    motion, _ = METHODS[method].follower(system, tolerance, spectrum)(time, start)
    found = energies(system, motion)
    q, v = (x @ scene.motions.T for x in (motion.position, motion.velocity))
    power = {key: np.sum(force * v, axis=1) for key, force in system.forces(motion).items()}
    largest = max(np.abs(found[term]).max() for term in TERMS)
    kinked = method == "switching"
    close = 2e-4 if kinked or method == "convolution" else 1e-5  # the stop's force jumps between records
    close = 2e-2 if name == "end stop" else close

    def stored(key):
        energy = scene.forces[key].potential_energy(q)
        return energy - energy[0]

    if not pto.has_latching_time and "chamber" not in more:
        law = integral(time, taken_by_law(pto, scene, motion, q, v, b))
        assert found["pto"] == pytest.approx(law, abs=close * largest)
    kept = stored("pto")
    if "chamber" in more and motion.memory.size:
        own = motion.memory[:, scene.remembered["pto"]]
        kept = kept + 0.5 * np.sum(own**2 - own[0] ** 2, axis=1)
    assert found["pto"] == pytest.approx(-integral(time, power["pto"]) - kept, abs=close * largest)
    assert found["pto"][-1] > 0.05 * largest
    absorbed = absorbed_power(system, motion, system.forces(motion))
    assert found["pto"] == pytest.approx(integral(time, absorbed), abs=close * largest)

    wave = sum((power[key] for key in EXCITING if key in power), np.zeros(len(time)))
    if not (kinked and scene.water):  # there the balance alone separates work and stored energy
        assert found["wave"] == pytest.approx(integral(time, wave), abs=close * largest)
    for term in {*found} - {*TERMS, "turned"}:
        assert found[term] == pytest.approx(-integral(time, power[term]), abs=close * largest), term
    stop = -integral(time, power["end_stop"]) - stored("end_stop") if "end_stop" in power else 0.0
    structural = -integral(time, power.get("structural_damping", 0.0 * time)) + stop
    assert found["structural"] == pytest.approx(structural, abs=close * largest)

    turned = np.einsum("ti,ij,tj->t", v, scene.mass, v) / 2
    works = integral(time, sum(power.values()))
    assert works == pytest.approx(turned - turned[0], abs=close * largest)
    assert residual(found) < (1e-4 if method == "convolution" else 1e-6)


@pytest.mark.parametrize(("model", "design", "name"), [
    ("linear", "VSWEC", "spring"), ("body_exact", "VSWEC", "negative spring"), ("assumed_pressure", "FSB", "damper"),
])  # fmt: skip
def test_mean_power_of_the_steady_state_equals_that_of_the_damper(model, design, name):
    """1/2 c |V|^2 over all harmonics of the velocity at the port."""
    scene = scene_of(model, design, Pto.model_validate({"damping": 2e4, **TAKE_OFFS[name]}))
    found = harmonic_balance(System.of(scene), 1e-9)
    velocity = found.omega * np.arange(len(found.harmonics)) * np.abs(found.harmonics @ scene.motions[0])
    assert found.power.pto == pytest.approx(0.5 * 2e4 * np.sum(velocity**2), rel=1e-7)
    assert found.power.residual < 1e-6
