"""Runs under a causal controller: what theory says without a limit, between damper and proof under one."""

from dataclasses import replace

import numpy as np
import pytest
from models.test_stationary import PUBLISHED, example  # noqa: F401

from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import legs
from vsb.engine.motion.constrained import optimum_in_sea
from vsb.engine.motion.force_bound import Harmonics, Limits
from vsb.engine.motion.forces import TakeOff
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import linear_scene
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import Pto
from vsb.engine.waves.climate import realised
from vsb.engine.waves.scatter import climate_of_cells
from vsb.engine.waves.seas import Sea
from vsb.models.build import Memory
from vsb.models.floating_system import expected_sea
from vsb.models.stationary import controlled
from vsb.results.causal_year import schedules_at_port
from vsb.results.verification import DesignInTime, record_of
from vsb.results.year import frequencies
from vsb.stages.members import under_schedules

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


def test_controllers_of_a_year_absorb_in_time_what_theory_says_and_less_within_a_limit(example, radiation_of):  # noqa: F811
    study, floating = example
    cells = np.array([1.0, 1.0]), np.array([2.7, 3.6])
    climate = climate_of_cells(*cells, np.array([0.5, 0.5]), 3.3, "two seas")
    memory = Memory(radiation_of(study), floating.linear.added_mass_inf)
    waves = floating.at(frequencies(climate, *floating.band)).in_waves()
    ratios = []
    for limit in (np.inf, 1e3):
        own = study.model_copy(update={"pto": Pto(force_limit=limit, tuning="each")})
        schedules = schedules_at_port(own, floating, climate, waves)
        design = DesignInTime(
            floating.linear, None, memory, floating.motions["FSB"], LinearPto(0.0, port=floating.port), own.pto
        )
        controlled, decay = under_schedules(climate, schedules, {"FSB": design})("FSB", 1)
        settings = record_of(float(climate.te[1]), decay, Simulation())
        sea = realised(climate, 1, settings.duration, 3, *floating.band)
        run, theory = controlled.powers(sea, settings, "linear")
        again, _ = replace(controlled, control=controlled.control._replace(limited=controlled.control.linear)).powers(
            sea, settings, "linear"
        )
        ratios.append((run / theory, again / run))
    assert ratios[0] == pytest.approx((1.0, 1.0), abs=1e-2)  # the filter's error
    assert 0.6 < ratios[1][0] < 0.9  # 0.8 of a force that is scarce
    assert ratios[1][1] < 1.02  # cut, the controller that knows of the limit absorbs more
