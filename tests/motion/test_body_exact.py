"""Hydrostatics and Froude-Krylov forces on the instantaneous wet shell, with linear radiation and diffraction."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import varied

from vsb.engine.integrators.exact import propagate
from vsb.engine.integrators.exponential import integrate
from vsb.engine.motion.builders import body_exact_scene, linear_scene
from vsb.engine.motion.forces import Excitation
from vsb.engine.motion.system import System
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.errors import ConvergenceError
from vsb.models.rest import design_motions, reference_shell, study_basis

OMEGA = 2 * np.pi / 3.0


@pytest.fixture(scope="module")
def parts(seed, buoy_of, radiation_of):
    """Function (study, design) -> buoy with its attributes, shape, radiation model, motions."""

    def build(study, design):
        buoy, basis = buoy_of(study), study_basis(study)
        attrs = {"gravity": 9.81, "water_depth": "inf", "water_density": 1025.0}
        buoy = replace(buoy, database=buoy.database.assign_attrs(attrs))
        shape = DeformedShell(basis, study.centre_height, reference_shell(study).modal_amplitude)
        return buoy, shape, radiation_of(study), design_motions(study, basis, design)

    return build


def swell(amplitude):
    return Sea(np.array([OMEGA]), np.array([amplitude + 0j]))


def scene(parts, study, design, sea):
    buoy, shape, radiation, motions = parts(study, design)
    return body_exact_scene(buoy, shape, radiation, sea, motions)


def exact_linear(parts, study, design, amplitude):
    """The linear scene with the Froude-Krylov force of the smooth shell in place of the panels'."""
    buoy, shape, radiation, motions = parts(study, design)
    linear = linear_scene(buoy, radiation, swell(amplitude), motions)
    tiny = 1e-6
    water = body_exact_scene(buoy, shape, radiation, swell(tiny), motions).water

    def head(wave, time):
        from vsb.engine.motion.froude_krylov import wave_forces

        return wave_forces(water.shell.shape, water.rest[None], wave, np.array([time]))[0]

    still = water.shell.forces(water.rest[None])[0][0]
    quarter = np.pi / 2 / OMEGA
    smooth = (head(water.waves, 0.0) - still) / tiny + 1j * (head(water.waves, quarter) - still) / tiny
    force = amplitude * (water.specific_weight * smooth + buoy.diffraction(np.array([OMEGA]))[0])
    return replace(linear, forces={**linear.forces, "excitation": Excitation(np.array([OMEGA]), force[None])})


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_small_motion_follows_linear_theory(parts, seed, design):
    """About the equilibrium of a shell that carries its load; the difference vanishes with the wave's amplitude."""
    study = varied(seed, device={"young_modulus": 1e12}, modes={"degree": 3}) if design == "VSWEC" else seed
    time = np.linspace(0.0, 10.0, 401)
    errors, amplitudes = [], np.array([0.04, 0.01])
    for a in amplitudes:
        plant = scene(parts, study, design, swell(a))
        linear = propagate(System.of(exact_linear(parts, study, design, a)), time, plant.start(0.0, 0.0))
        motion, _ = integrate(System.of(plant), time, plant.start(0.0, 0.0), 1e-9)
        errors.append(np.abs(motion.position[:, 0] - linear.position[:, 0]).max() / a)
    slopes = np.diff(np.log(errors)) / np.diff(np.log(amplitudes))
    assert errors[-1] < 2e-3, errors
    assert np.all((slopes > 0.8) & (slopes < 2.2)), (errors, slopes)


def test_shell_too_soft_to_rest_is_refused(parts, seed):
    buoy, shape, radiation, motions = parts(seed, "VSWEC")
    soft = buoy.database.assign(structural_stiffness=1e-3 * buoy.database.structural_stiffness)
    with pytest.raises(ConvergenceError, match=r"does not come to rest.*internal_pressure"):
        body_exact_scene(replace(buoy, database=soft), shape, radiation, NO_WAVES, motions)
