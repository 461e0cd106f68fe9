"""Runs under a causal controller: what theory says without a limit, between damper and proof under one."""

from dataclasses import replace

import numpy as np
import pytest
from models.test_stationary import PUBLISHED, example  # noqa: F401

from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import legs
from vsb.engine.motion.builders import linear_scene
from vsb.engine.motion.constrained import optimum_in_sea
from vsb.engine.motion.force_bound import Harmonics, Limits
from vsb.engine.motion.forces import TakeOff
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import Pto
from vsb.engine.waves.seas import Sea
from vsb.models.floating_system import expected_sea
from vsb.models.stationary import controlled

TP, DURATION = 3.0, 120.0
SETTINGS = Simulation(duration=DURATION + 80.0, window=(80.0, DURATION + 80.0))


@pytest.fixture(scope="module")
def bare(example, radiation_of):  # noqa: F811
    """The rigid buoy of the example in waves that repeat after the window, and its scene without take-off."""
    study, floating = example
    (wave,) = (wave for wave in study.waves if wave.tp == TP)
    spacing = 2 * np.pi / DURATION
    omega = spacing * np.arange(np.ceil(1.0 / spacing), 6.0 / spacing)
    phases = np.random.default_rng(5).uniform(0, 2 * np.pi, len(omega))
    sea = Sea(omega, np.sqrt(2 * wave.density(omega) * spacing) * np.exp(1j * phases))
    linear = replace(floating.linear, pto=LinearPto(0.0))
    return study, floating, wave, sea, linear_scene(linear, radiation_of(study), sea, floating.motions["FSB"])


def power(scene, sea, law):
    """Mean power over the window, and the run's system."""
    system, energy = System.of(replace(scene, forces={**scene.forces, "pto": law})), []
    for leg in legs(system, sea, SETTINGS, None):
        energy.append((leg.motion.time, leg.energy["pto"]))
    time, taken = (np.concatenate(part) for part in zip(*energy, strict=True))
    return float(np.diff(np.interp(SETTINGS.window, time, taken))[0]) / DURATION


@pytest.fixture(scope="module")
def controller(bare):
    """Function force limit -> law of the controller, and what a run records of it."""
    study, floating, wave, _, scene = bare

    def find(limit):
        pto = Pto(law="causal", force_limit=limit)
        law = TakeOff(floating.port, 0.0, limit=limit)
        whole = replace(scene, forces={**scene.forces, "pto": law})
        expected = expected_sea(study, wave, floating.linear.database)
        found, notes = controlled(whole, floating, "FSB", pto, wave, expected)
        return found.law, notes

    return find


def test_mean_power_in_time_is_that_of_theory(bare, controller):
    *_, sea, scene = bare
    law, notes = controller(np.inf)
    assert notes["controller_power"] == pytest.approx(PUBLISHED[TP][5800.0][0], rel=5e-3)
    assert power(scene, sea, law) == pytest.approx(notes["controller_power"], rel=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("limit", "damping", "least"), [(580.0, 4e4, 0.997), (5800.0, 15e3, 1.05)])
def test_under_a_limit_it_absorbs_more_than_a_damper_and_less_than_the_bound(bare, controller, limit, damping, least):
    """With little force a damper that is cut leaves next to nothing to a controller: 303.1 of at most 303.4 W."""
    _, floating, _, sea, scene = bare
    found = power(scene, sea, controller(limit)[0])
    damper = power(scene, sea, TakeOff(floating.port, damping, limit=limit))
    harmonics = Harmonics.of_sea(sea.omega, float(floating.linear.database.omega[0]), 6.0)
    port = floating.extended_port("FSB", harmonics.port_omega, direction=0.0)
    bound = optimum_in_sea(port, sea, harmonics, Limits(limit, np.inf)).bound
    assert least * damper < found < bound
