"""Forces of a shell: of rubber along a motion, exact however far it is stretched, and of viscous material."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from vsb.engine.integrators.audit import energies, residual
from vsb.engine.integrators.collocation import collocated
from vsb.engine.integrators.exact import propagate, steady_state
from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.integrators.simulate import suited
from vsb.engine.motion.forces import Excitation, Spring, ViscousForce, loss, shell_forces, stiffening
from vsb.engine.motion.scene import Scene, still_scene
from vsb.engine.motion.system import System
from vsb.engine.shell.device import MaxwellBranch
from vsb.engine.shell.loaded import equilibrium
from vsb.errors import ConfigError
from vsb.models.rest import loaded_shell, reference_shell
from vsb.study.study import parse


def buoy(reference_shape="equilibrium", pressure=2.2e4, gas=None, damping=None, model="body_exact", **more):
    """A study of a shell of rubber, and its reference shell."""
    device = {
        "radius": 2.0, "thickness": 0.05, "density": 1100.0, "mass": 17170.0, "internal_pressure": pressure,
        "material": {"law": "neo_hookean", "mu": 1e6}, "gas": gas, "damping": damping or {},
    }  # fmt: skip
    study = parse({
        "study": "rubber", "device": device, "designs": {"VSWEC": {}}, "waves": [{"kind": "still"}],
        "modes": {"basis": "full", "degree": 3}, "reference_shape": reference_shape, "hydro": {"model": model}, **more,
    })  # fmt: skip
    return study, reference_shell(study)


def at_rest(study, reference, rubber=True):
    """The scene in still water, all motions allowed."""
    loaded = loaded_shell(study, reference.basis) if rubber else None
    return still_scene(reference, 1025.0, 9.81, np.eye(len(reference.basis.labels)), loaded)


GAS = {"adiabatic_index": 1.4}


@pytest.mark.parametrize(("pressure", "gas"), [(2.2e4, None), (1e5, GAS), (1e5, {"adiabatic_index": 1.0})])
def test_forces_and_stiffness_are_slopes_of_their_potentials(pressure, gas):
    study, reference = buoy(pressure=pressure, gas=gas)
    loaded, still = loaded_shell(study, reference.basis), np.zeros(1)
    q, step = 0.1 * np.cos(1.9 * np.arange(len(reference.basis.labels)) + 0.3), 1e-4
    for force in shell_forces(loaded, reference.modal_amplitude).values():
        moved = np.array([q + s * step * e for e in np.eye(len(q)) for s in (1, -1)])
        energy = force.potential_energy(moved).reshape(-1, 2)
        found = force.force(still, q[None], q[None])[0]
        np.testing.assert_allclose(-(energy[:, 0] - energy[:, 1]) / (2 * step), found, atol=1e-6 * np.abs(found).max())
        slope = force.force(still, moved, moved).reshape(len(q), 2, -1)
        stiffness = force.stiffness(q)
        assert stiffness == pytest.approx(-(slope[:, 0] - slope[:, 1]) / (2 * step), abs=1e-6 * np.abs(stiffness).max())


def test_a_scene_about_the_undeformed_shell_rests_where_the_shell_does():
    study, reference = buoy("undeformed", pressure=1.8e4)
    origin = at_rest(study, reference).origin
    np.testing.assert_allclose(origin, equilibrium(loaded_shell(study, reference.basis)), atol=1e-10)


MAXWELL = {"maxwell": [{"ratio": 0.4, "time": 0.2}]}


@pytest.mark.parametrize(("gas", "damping"), [(GAS, {}), (None, {"beta": 5e-3, **MAXWELL})])
def test_energy_of_a_free_motion(gas, damping):
    """Of large amplitude: the shell moves by a tenth of its radius; branches stand beside the stiffness at rest."""
    study, reference = buoy(pressure=1e5 if gas else 2.2e4, gas=gas, damping=damping)
    scene = at_rest(study, reference)
    if branches := study.device.damping.maxwell:
        force = ViscousForce(branches, reference.stiffness["structural"])
        scene = replace(scene, forces={**scene.forces, "viscous": force})
    system = System.of(scene)
    assert suited(system) == "collocation"
    time, start = np.linspace(0.0, 0.5, 201), np.zeros(len(reference.basis.labels))
    start[:2] = 0.2, 0.2
    motion, _ = collocated(system, time, (start, np.zeros_like(start)), 1e-8)
    found = energies(system, motion)
    assert residual(found) < 1e-6
    kinetic = found["turned"].max()
    if damping:
        assert found["structural"][-1] > 0.01 * kinetic
    else:
        assert np.abs(found["stored"]).max() < 1e-6 * kinetic
    lossy = {"beta": {"structural_damping"}, "maxwell": {"viscous"}}
    expected = {"elastic", "internal_pressure", "hydrostatic", "weight"}.union(*(lossy[key] for key in damping))
    assert set(system.forces(motion)) == expected


def test_small_motions_are_those_of_the_springs():
    rubber, springs = (at_rest(*buoy(), some) for some in (True, False))
    np.testing.assert_allclose(rubber.stiffness, springs.stiffness, atol=1e-9 * np.abs(springs.stiffness).max())
    np.testing.assert_allclose(rubber.origin, 0.0, atol=1e-9)


BRANCHES = (MaxwellBranch(ratio=0.4, time=0.5), MaxwellBranch(ratio=0.1, time=3.0))
K = 50.0


def relaxation_modulus(time):
    """What is left of a unit step of strain beyond the stiffness at rest."""
    return sum(b.ratio * np.exp(-time / b.time) for b in BRANCHES)


def one_mass(**forces):
    return Scene(("Heave", "Radial0"), np.diag([1.0, 2.0]), forces, np.eye(2)[:, 1:])


def viscous(branches=BRANCHES):
    return ViscousForce(branches, np.diag([0.0, K]))


@pytest.mark.parametrize("omega", [0.3, 2.0, 20.0])
def test_storage_and_loss_are_transforms_of_the_relaxation(omega):
    """G' = w int G(s) sin(w s) ds, G'' = w int G(s) cos(w s) ds (Ferry, eqs. 1.23 and 1.24)."""
    storage, lost = (omega * quad(relaxation_modulus, 0, np.inf, weight=kind, wvar=omega)[0] for kind in ("sin", "cos"))
    at = np.array([omega])
    assert stiffening(BRANCHES, at)[0] == pytest.approx(storage, rel=1e-7)
    assert omega * loss(BRANCHES, at)[0] == pytest.approx(lost, rel=1e-7)


def test_the_force_in_time_has_the_complex_stiffness_of_the_frequency_domain():
    """Of a velocity -i w q, conj(transfer) is loss + i stiffening/w (C1)."""
    omega = np.array([0.3, 2.0, 20.0])
    found = viscous().model.transfer(omega).conj()[:, 1, 1]
    assert found == pytest.approx(K * (loss(BRANCHES, omega) + 1j * stiffening(BRANCHES, omega) / omega), rel=1e-12)


def test_work_of_a_cycle_is_pi_times_the_loss_modulus():
    """In the audit of a driven mass, in the harmonic balance, and by pi Im K |q|^2."""
    omega = 3.0
    excitation = Excitation(np.array([omega]), np.array([[0.0, 7.0 + 2.0j]]))
    scene = one_mass(elastic=Spring(np.diag([0.0, K])), viscous=viscous(), excitation=excitation)
    system = System.of(scene)
    q = 7.0 + 2.0j
    q /= K * (1 + stiffening(BRANCHES, np.array([omega]))[0] - 1j * omega * loss(BRANCHES, np.array([omega]))[0]) - (
        2 * omega**2
    )
    cycle = np.pi * omega * K * loss(BRANCHES, np.array([omega]))[0] * abs(q) ** 2
    steady = harmonic_balance(system)
    assert steady.harmonics[1, 0] == pytest.approx(q, rel=1e-9)
    assert 2 * np.pi / omega * steady.power.structural == pytest.approx(cycle, rel=1e-9)
    assert steady.power.wave == pytest.approx(steady.power.structural, rel=1e-9)
    state = steady_state(system).sum(axis=0).real
    begin = (np.array([q.real]), np.array([(-1j * omega * q).real]), state[2:])
    motion = propagate(system, np.linspace(0.0, 2 * np.pi / omega, 129), begin)
    found = energies(system, motion)
    assert found["structural"][-1] == pytest.approx(cycle, rel=1e-6)
    assert np.abs(found["radiated"]).max() == 0.0
    assert residual(found) < 1e-6


def test_a_convolution_is_refused():
    with pytest.raises(ConfigError, match="nor a viscous material"):
        buoy(damping=MAXWELL, model="linear", simulation={"method": "convolution"})
