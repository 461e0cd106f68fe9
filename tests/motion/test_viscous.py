"""Viscous material: complex modulus, relaxation, work of a cycle; the loss in time and in the energy audit."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from vsb.engine.integrators.audit import energies, residual
from vsb.engine.integrators.collocation import collocated
from vsb.engine.integrators.exact import propagate, steady_state
from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.motion.builders import still_scene
from vsb.engine.motion.forces import Excitation, Spring
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.engine.motion.viscous import ViscousForce, loss, stiffening
from vsb.engine.shell.device import MaxwellBranch
from vsb.errors import ConfigError
from vsb.models.rest import loaded_shell, reference_shell
from vsb.study.study import parse

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


def study(model="linear", **more):
    device = {
        "radius": 2.0, "thickness": 0.05, "density": 1100.0, "mass": 17170.0, "internal_pressure": 2.2e4,
        "material": {"law": "neo_hookean", "mu": 1e6},
        "damping": {"maxwell": [{"ratio": 0.4, "time": 0.2}]},
    }  # fmt: skip
    return parse({
        "study": "viscous", "device": device, "designs": {"VSWEC": {}}, "waves": [{"kind": "still"}],
        "modes": {"basis": "full", "degree": 3}, "reference_shape": "equilibrium", "hydro": {"model": model}, **more,
    })  # fmt: skip


def test_loss_of_rubber_in_a_body_exact_motion():
    """Of large amplitude, a tenth of the radius: rubber exact, its branches beside the stiffness at rest."""
    rubber = study("body_exact")
    reference = reference_shell(rubber)
    free = np.eye(len(reference.basis.labels))
    scene = still_scene(reference, 1025.0, 9.81, free, loaded_shell(rubber, reference.basis))
    branches = ViscousForce(rubber.device.damping.maxwell, reference.stiffness["structural"])
    system = System.of(replace(scene, forces={**scene.forces, "viscous": branches}))
    start = np.zeros(len(free))
    start[:2] = 0.2, 0.2
    motion, _ = collocated(system, np.linspace(0.0, 1.0, 401), (start, np.zeros_like(start)), 1e-8)
    found = energies(system, motion)
    assert residual(found) < 1e-6
    assert found["structural"][-1] > 0.01 * found["turned"].max()


def test_a_convolution_is_refused():
    with pytest.raises(ConfigError, match="nor a viscous material"):
        study(simulation={"method": "convolution"})
