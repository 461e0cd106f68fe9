"""Exact forces of a shell of rubber in a scene: potentials, rest, and the energy of a free motion."""

import numpy as np
import pytest

from vsb.engine.integrators.audit import energies, residual
from vsb.engine.integrators.collocation import collocated
from vsb.engine.integrators.simulate import suited
from vsb.engine.motion.builders import still_scene
from vsb.engine.motion.shell_forces import shell_forces
from vsb.engine.motion.system import System
from vsb.engine.shell.loaded import equilibrium
from vsb.models.rest import loaded_shell, reference_shell
from vsb.study.study import parse

RHO, G = 1025.0, 9.81


def buoy(reference_shape="equilibrium", pressure=2.2e4, gas=None, law=None, beta=0.0):
    device = {
        "radius": 2.0, "thickness": 0.05, "density": 1100.0, "mass": 17170.0, "internal_pressure": pressure,
        "material": law or {"law": "neo_hookean", "mu": 1e6}, "gas": gas, "damping": {"beta": beta},
    }  # fmt: skip
    raw = {
        "study": "rubber", "device": device, "designs": {"VSWEC": {}}, "waves": [{"kind": "still"}],
        "modes": {"basis": "full", "degree": 3}, "reference_shape": reference_shape, "hydro": {"model": "body_exact"},
    }  # fmt: skip
    return parse(raw)


GAS = {"adiabatic_index": 1.4}


@pytest.mark.parametrize(("pressure", "gas"), [(2.2e4, None), (1e5, GAS), (1e5, {"adiabatic_index": 1.0})])
def test_forces_and_stiffness_are_slopes_of_their_potentials(pressure, gas):
    study = buoy(pressure=pressure, gas=gas)
    reference = reference_shell(study)
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
    study = buoy("undeformed", pressure=1.8e4)
    reference = reference_shell(study)
    loaded = loaded_shell(study, reference.basis)
    scene = still_scene(reference, RHO, G, np.eye(len(reference.basis.labels)), loaded)
    np.testing.assert_allclose(scene.origin, equilibrium(loaded), atol=1e-10)


@pytest.mark.parametrize("gas", [None, GAS], ids=["constant", "trapped"])
@pytest.mark.parametrize("beta", [0.0, 5e-3])
def test_energy_of_a_free_motion(gas, beta):
    """Of large amplitude: the shell moves by a tenth of its radius."""
    study = buoy(pressure=1e5 if gas else 2.2e4, gas=gas, beta=beta)
    reference = reference_shell(study)
    loaded = loaded_shell(study, reference.basis)
    scene = still_scene(reference, RHO, G, np.eye(len(reference.basis.labels)), loaded)
    system = System.of(scene)
    assert suited(system) == "collocation"
    time, start = np.linspace(0.0, 1.0, 401), np.zeros(len(reference.basis.labels))
    start[:2] = 0.2, 0.2
    motion, _ = collocated(system, time, (start, np.zeros_like(start)), 1e-8)
    found = energies(system, motion)
    assert residual(found) < 1e-6
    kinetic = found["turned"].max()
    if beta:
        assert found["structural"][-1] > 0.01 * kinetic
    else:
        assert np.abs(found["stored"]).max() < 1e-6 * kinetic
    assert set(system.forces(motion)) == {"elastic", "internal_pressure", "hydrostatic", "weight"} | (
        {"structural_damping"} if beta else set()
    )


def test_small_motions_are_those_of_the_springs():
    study = buoy()
    reference = reference_shell(study)
    rubber = still_scene(reference, RHO, G, np.eye(len(reference.basis.labels)), loaded_shell(study, reference.basis))
    springs = still_scene(reference, RHO, G, np.eye(len(reference.basis.labels)))
    np.testing.assert_allclose(rubber.stiffness, springs.stiffness, atol=1e-9 * np.abs(springs.stiffness).max())
    np.testing.assert_allclose(rubber.origin, 0.0, atol=1e-9)
