"""Scenes: sums of forces in the motions allowed, initial state, rest; of a buoy linear, body-exact, under pressure."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from conftest import SEED, varied

from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.integrators.exact import propagate
from vsb.engine.integrators.exponential import integrate
from vsb.engine.motion.forces import AssumedPressure, ConstantForce, Damper, Excitation, Spring
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene, assumed_pressure_scene, body_exact_scene, linear_scene, resting
from vsb.engine.motion.system import System
from vsb.engine.motion.wetted import wave_forces
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import mode_basis
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.errors import ConvergenceError
from vsb.models.rest import design_motions, reference_shell
from vsb.study.study import load

SEA = Sea(np.array([1.5, 2.5]), np.array([0.05 + 0.02j, 0.03j]))
OMEGA = np.linspace(0.5, 6.0, 12)
DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC90": {"clamp": 90}}


@pytest.fixture(scope="module")
def studies():
    """A vented shell about its sphere, one at its equilibrium full of gas under pressure; the shell of each at rest."""
    vented = varied(load(SEED), designs=DESIGNS, modes={"degree": 3}, device={"young_modulus": 3e7})
    gas = {"internal_pressure": 30e3, "gas": {"adiabatic_index": 1.4}}
    pressurised = varied(vented, reference_shape="equilibrium", device=gas)
    return {"vented": (vented, reference_shell(vented)), "pressurised": (pressurised, reference_shell(pressurised))}


def made_up_buoy(study, reference):
    """A buoy with the shell of a study and made-up coefficients, and its shape at rest."""
    dof, rng = len(reference.basis.labels), np.random.default_rng(4)
    root, pair = rng.normal(size=(dof, dof)), ("influenced_dof", "radiating_dof")
    push = 1e4 * (rng.normal(size=(len(OMEGA), 1, dof)) + 1j * rng.normal(size=(len(OMEGA), 1, dof)))
    steady = {"inertia_matrix": reference.basis.inertia, "added_mass_inf": 1e3 * (root @ root.T)}
    steady |= {f"{name}_stiffness": k for name, k in reference.stiffness.items()}
    swept = {
        "added_mass": 2e3 * (root @ root.T) / (1 + OMEGA[:, None, None]),
        "radiation_damping": 1e3 * (root @ root.T),
    }
    forces = {"excitation_force": push, "diffraction_force": 0.4 * push, "Froude_Krylov_force": 0.6 * push}
    ds = xr.Dataset(
        {name: (pair, value) for name, value in steady.items()}
        | {name: (("omega", *pair), np.broadcast_to(v, (len(OMEGA), dof, dof))) for name, v in swept.items()}
        | {name: (("omega", "wave_direction", pair[0]), value) for name, value in forces.items()},
        coords={"omega": OMEGA, "influenced_dof": list(reference.basis.labels)},
        attrs={"water_density": study.water.density, "gravity": study.water.gravity, "water_depth": study.water.depth},
    )
    return LinearSystem(ds, reference.basis.damping, LinearPto(8000.0)), reference.shape


def memory(dof):
    """A radiation memory of two states."""
    channel = np.array([1.0, 0.5])
    return RadiationModel(
        np.array([[0.0, 2.0], [-2.0, 0.0]]) - np.outer(channel, channel) / 2, np.ones((2, dof)), channel
    )


def scenes(study, buoy, shape, design, sea=NO_WAVES):
    """The linear and the body-exact scene of a design, as functions: not every buoy comes to rest."""
    motions = design_motions(study, shape.basis, design)
    radiation = memory(len(motions))
    return {
        "linear": lambda: linear_scene(buoy, radiation, sea, motions),
        "body_exact": lambda: body_exact_scene(buoy, shape, radiation, sea, motions),
    }


@pytest.mark.parametrize(("design", "name"), [("FSB", "vented"), ("VSWEC90", "pressurised")])
@pytest.mark.parametrize("model", ["linear", "body_exact"])
def test_scene_has_the_stiffness_damping_and_mass_of_its_buoy(studies, name, model, design):
    buoy, shape = made_up_buoy(*studies[name])
    plant = scenes(studies[name][0], buoy, shape, design, SEA)[model]()
    n = plant.motions
    assert plant.stiffness == pytest.approx(n.T @ buoy.stiffness @ n, rel=1e-9, abs=1e-9 * np.abs(buoy.stiffness).max())
    assert plant.damping == pytest.approx(n.T @ buoy.damping @ n, rel=1e-12, abs=1e-12 * np.abs(buoy.damping).max())
    assert plant.mass == pytest.approx(buoy.mass + buoy.added_mass_inf, rel=1e-15)
    assert plant.memory.order == 2


@pytest.mark.parametrize(("design", "name"), [("VSWEC", "vented"), ("VSWEC90", "pressurised")])
def test_body_exact_scene_is_at_rest_in_still_water(studies, name, design):
    """All named forces cancel, weight and preload included."""
    buoy, shape = made_up_buoy(*studies[name])
    plant = scenes(studies[name][0], buoy, shape, design)["body_exact"]()
    weight = 9.81 * studies[name][0].device.mass
    assert plant.forces["weight"].value[0] == pytest.approx(-weight, rel=1e-12)
    rest = (plant.motions @ plant.rest)[None]
    at_rest = plant.named(np.zeros(1), rest, np.zeros_like(rest))
    total = sum(at_rest.values()) @ plant.motions
    assert np.abs(total).max() < 1e-9 * weight
    assert at_rest["hydrostatic"][0, 0] == pytest.approx(weight, rel=1e-6)
    start, rate = plant.start(0.0, 0.0)
    assert not rate.any()
    assert np.abs(plant.motions @ start - rest).max() < 1e-9
    if name == "pressurised":
        assert np.abs(rest).max() < 1e-9


def test_body_exact_waves_are_froude_krylov_and_diffraction(studies):
    """To first order in the waves, linear theory has their sum as excitation."""
    study, reference = studies["vented"]
    buoy, shape = made_up_buoy(study, reference)
    linear, exact = (scenes(study, buoy, shape, "VSWEC", SEA)[name]() for name in ("linear", "body_exact"))
    expected = buoy.coefficients(SEA.omega).excitation * SEA.amplitude[:, None]
    assert linear.excitation.phasors == pytest.approx(expected, rel=1e-12)
    assert exact.excitation.phasors == pytest.approx(0.4 * expected, rel=1e-9)
    assert exact.water.waves.omega == pytest.approx(SEA.omega)
    assert exact.water.waves.amplitude == pytest.approx(SEA.amplitude)
    assert exact.water.waves.wavenumber == pytest.approx(SEA.omega**2 / 9.81, rel=1e-12)
    assert exact.water.waves.radius == study.device.radius
    assert linear.excitation.omega == pytest.approx(SEA.omega)
    assert exact.excitation.omega == pytest.approx(SEA.omega)


def test_assumed_pressure_acts_on_the_waterplane(studies):
    """V = pi h^2 (3 r - h)/3 below the water, and pi (r^2 - z^2) of the section at its surface."""
    study, _ = studies["vented"]
    shape, (r, z) = reference_shell(study).shape, (study.device.radius, study.centre_height)
    motions = design_motions(study, shape.basis, "VSWEC")
    plant = assumed_pressure_scene(shape, LinearPto(0.0), AssumedPressure(100.0, 2.0), 1000.0, 10.0, motions)
    rest = np.zeros((2, len(motions)))
    named = plant.named(np.array([0.0, np.pi / 2]), rest, rest)
    assert named["hydrostatic"][:, 0] == pytest.approx(2 * [1e4 * np.pi * (r - z) ** 2 * (2 * r + z) / 3], rel=1e-6)
    assert np.abs(named["excitation"][:, 0]) == pytest.approx(2 * [100 * np.pi * (r**2 - z**2)], rel=1e-6)
    assert named["excitation"][1] == pytest.approx(-named["excitation"][0], rel=1e-12)


STIFFNESS, MORE, DAMPING = np.diag([3.0, 5.0]), np.array([[1.0, 0.5], [0.5, 2.0]]), np.array([[2.0, 0.0], [0.0, 1.0]])


def scene(motions=None, **more):
    forces = {
        "hydrostatic": Spring(STIFFNESS),
        "elastic": Spring(MORE),
        "structural_damping": Damper(0.1 * DAMPING),
        "pto": Damper(np.diag([4.0, 0.0])),
        "weight": ConstantForce(np.array([7.0, -1.0])),
    }
    return Scene(("Heave", "Membrane0"), np.eye(2), forces, np.eye(2) if motions is None else motions, **more)


def test_initial_state_is_heave_from_the_rest_position():
    one = scene(np.array([[0.6, 0.8], [-0.8, 0.6]]), origin=np.array([0.1, 0.2]), heave=np.array([0.6, 0.8]))
    y, rate = one.start(0.5, -2.0)
    assert y == pytest.approx([0.1 + 0.3, 0.2 + 0.4])
    assert rate == pytest.approx([-1.2, -1.6])
    np.testing.assert_array_equal(one.scaled_waves(0.5).heave, one.heave)
    np.testing.assert_array_equal(one.scaled_waves(0.5).origin, one.origin)


@pytest.mark.parametrize(
    ("labels", "stiffness", "unrestrained"),
    [
        (("Mode7", "Heave"), np.diag([0.0, 5.0]), True),
        (("Surge", "Sway"), 7.3 * np.outer([0.3, 0.7], [0.3, 0.7]), True),
        (("Surge", "Sway"), 7.3 * np.outer([0.3, 0.7], [0.3, 0.7]) + np.diag([1e-3, 0.0]), False),
        (("Heave",), np.array([[5.0]]), False),
    ],
)
def test_unrestrained_scene(labels, stiffness, unrestrained):
    free = np.eye(len(labels))
    assert Scene(labels, free, {"mooring": Spring(stiffness)}, free).unrestrained is unrestrained


@pytest.fixture(scope="module")
def wet(seed):
    """A shell with a spring at its take-off on the instantaneous wet surface; two of its motions come together."""
    basis = mode_basis(seed.device, "membrane", 2)
    shell, motions = DeformedShell(basis, seed.centre_height, np.zeros(4)), np.eye(4)[:, [0, 1, 3]]
    motions[2, 1] = 0.4
    return assumed_pressure_scene(shell, LinearPto(2e3, 3e4), AssumedPressure(0.0, 1.0), 1025.0, 9.81, motions)


@pytest.mark.parametrize("shape", [[0.0, 0.0, 0.0, 0.0], [0.05, 0.01, -0.02, 0.03]])
def test_forces_cancel_at_the_equilibrium(wet, shape):
    """Springs, weight and water on the shell, for any reference shape."""
    more = {"water": replace(wet.water, rest=np.array(shape)), "ballast": ConstantForce(np.array([-2e3, 0, 0, 0]))}
    one = replace(wet, forces={**wet.forces, **more})
    q = (one.motions @ one.rest)[None]
    assert np.abs(q).min() > 1e-3
    named = one.named(np.zeros(1), q, np.zeros((1, 4)))
    assert np.abs(named["weight"]).max() > 1e3
    np.testing.assert_allclose(one.motions.T @ sum(named.values())[0], 0.0, atol=1e-7)


def test_sinking_or_collapsing_body_is_refused(wet):
    heavy = {**wet.forces, "ballast": ConstantForce(np.array([-1e6, 0.0, 0.0, 0.0]))}
    soft = {**wet.forces, "more": Spring(np.diag([-1e7, 0.0, 0.0, 0.0]))}
    for forces in (heavy, soft):
        with pytest.raises(ConvergenceError, match="the loaded buoy does not come to rest: its shell gives way under"):
            resting(replace(wet, forces=forces))


WAVE = 2 * np.pi / 3.0


def swell(amplitude):
    return Sea(np.array([WAVE]), np.array([amplitude + 0j]))


def exact_linear(buoy, shape, radiation, motions, amplitude):
    """The linear scene with the Froude-Krylov force of the smooth shell in place of the panels'."""
    linear, tiny = linear_scene(buoy, radiation, swell(amplitude), motions), 1e-6
    water = body_exact_scene(buoy, shape, radiation, swell(tiny), motions).water

    def head(time):
        return wave_forces(water.shell.shape, water.rest[None], water.waves, np.array([time]))[0]

    still = water.shell.forces(water.rest[None])[0][0]
    smooth = (head(0.0) - still) / tiny + 1j * (head(np.pi / 2 / WAVE) - still) / tiny
    force = amplitude * (water.specific_weight * smooth + buoy.diffraction(np.array([WAVE]))[0])
    return replace(linear, forces={**linear.forces, "excitation": Excitation(np.array([WAVE]), force[None])})


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_small_motion_follows_linear_theory(wet_buoy, seed, design):
    """About the equilibrium of a shell that carries its load; the difference vanishes with the wave's amplitude."""
    study = varied(seed, device={"young_modulus": 1e12}, modes={"degree": 3}) if design == "VSWEC" else seed
    parts, time = wet_buoy(study, design), np.linspace(0.0, 10.0, 401)
    errors, amplitudes = [], np.array([0.04, 0.01])
    for a in amplitudes:
        plant = body_exact_scene(*parts[:3], swell(a), parts[3])
        linear = propagate(System.of(exact_linear(*parts, a)), time, plant.start(0.0, 0.0))
        motion, _ = integrate(System.of(plant), time, plant.start(0.0, 0.0), 1e-9)
        errors.append(np.abs(motion.position[:, 0] - linear.position[:, 0]).max() / a)
    slopes = np.diff(np.log(errors)) / np.diff(np.log(amplitudes))
    assert errors[-1] < 2e-3, errors
    assert np.all((slopes > 0.8) & (slopes < 2.2)), (errors, slopes)
