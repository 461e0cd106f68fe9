"""Reduced motions: what a design does in waves, at its port and after a start, in few motions in place of all modes."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import varied

from vsb.engine.integrators.exact import propagate
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.reduced import FEWEST, reduced_motions
from vsb.engine.motion.scene import linear_scene, unit_heave
from vsb.engine.motion.system import System
from vsb.engine.waves.seas import NO_WAVES
from vsb.models.rest import design_motions, study_basis

DEVICE = {"young_modulus": 40e6, "thickness": 0.015, "density": 1100.0, "internal_pressure": 16.5e3}


@pytest.fixture(scope="module")
def many(seed):
    """A shell kept in shape by pressure, with 60 modes."""
    hydro = {"omega_max": 6.0, "tolerance": 1e-2}
    return varied(seed, device=DEVICE, modes={"basis": "full", "degree": 30}, hydro=hydro)


def of_design(study, buoy, design):
    """All motions of a design, the reduced ones, and its start in heave."""
    motions = design_motions(study, study_basis(study), design)
    start = unit_heave(buoy.labels, buoy.mass + buoy.added_mass_inf, motions)
    return motions, reduced_motions(buoy, motions, np.eye(len(motions))[0], start), start


@pytest.mark.parametrize("design", ["VSWEC", "VSWEC90"])
def test_power_at_the_port_is_that_of_all_modes(buoy_of, many, design):
    """Of any damper, at frequencies that were not looked at; and the clamp holds."""
    buoy = buoy_of(many)
    motions, found, _ = of_design(many, buoy, design)
    assert found.reduced
    assert found.motions.shape[1] <= 0.6 * motions.shape[1]
    omega, heave = np.linspace(0.31, 5.97, 41), np.eye(len(motions))[0]
    whole, few = (buoy.port(omega, some, heave) for some in (motions, found.motions))
    for damping in (2e3, 2e4, 2e5):
        power = [damping * np.abs(one.velocity_under(one.load(damping))) ** 2 for one in (whole, few)]
        assert np.abs(power[1] / power[0] - 1).max() < 1e-5
    assert np.abs(found.motions - motions @ (motions.T @ found.motions)).max() < 1e-12


def test_motion_after_a_start_in_heave_is_that_of_all_modes(buoy_of, many):
    """Where the shell rings at frequencies above those of waves: to 1 % of the largest displacement."""
    buoy = replace(buoy_of(many), pto=LinearPto(8e3))
    motions, found, _ = of_design(many, buoy, "VSWEC")
    time, moved = np.linspace(0.0, 8.0, 801), []
    for some in (motions, found.motions):
        system = System.of(linear_scene(buoy, None, NO_WAVES, some))
        moved.append(propagate(system, time, system.scene.start(0.1, -0.8)).position @ some.T)
    assert np.abs(moved[0] - moved[1]).max() < 1e-2 * np.abs(moved[0]).max()
    assert np.ptp(moved[0][:, 1:]) > 30 * np.abs(moved[0] - moved[1])[:, 1:].max()


def test_few_modes_are_all_kept(buoy_of, seed):
    buoy = buoy_of(seed)
    motions, found, _ = of_design(seed, buoy, "VSWEC")
    assert motions.shape[1] <= FEWEST
    assert found.motions is motions
    assert found.notes == {}
