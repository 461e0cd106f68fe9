"""Work of every kind of force: the energy audit against force times velocity, integrated by splines over the records."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import xarray as xr
from conftest import SEED, varied
from scipy.interpolate import CubicSpline

from vsb.engine.hydro.radiation import DampingSpectrum, fit_radiation
from vsb.engine.integrators.audit import TERMS, absorbed_power, energies, residual
from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.integrators.simulate import METHODS
from vsb.engine.motion.builders import assumed_pressure_scene, body_exact_scene, linear_scene
from vsb.engine.motion.forces import EXCITING, AssumedPressure, QuadraticDrag
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import Pto
from vsb.engine.waves.seas import Sea
from vsb.models.latching import with_latching_time
from vsb.models.rest import design_motions, reference_shell
from vsb.models.take_off import with_take_off
from vsb.study.study import load

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
    system, time = System.of(scene), np.linspace(0.0, 1.25 * PERIOD, 4001)
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
