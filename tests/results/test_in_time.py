"""Runs in time of a climate's seas: without what linear theory leaves out they say what it says."""

from dataclasses import replace

import numpy as np
import pytest
from results.test_year import climate

from vsb.hydro.statespace import fit_radiation
from vsb.motion.pto import LinearPto
from vsb.results.in_time import DesignInTime
from vsb.scenes.rest import design_motions, reference_shell, study_basis
from vsb.study.study import Simulation
from vsb.waves.climate import realised


@pytest.fixture(scope="module")
def rigid(seed, spectral_seed):
    """The seed's rigid buoy at 20 kN s/m."""
    radiation, basis = fit_radiation(spectral_seed.spectrum, 1e-3)[0], study_basis(seed)
    return DesignInTime(
        spectral_seed, reference_shell(seed).shape, radiation, design_motions(seed, basis, "FSB"), LinearPto(2e4)
    )


def test_a_linear_run_agrees_with_linear_theory(rigid):
    """The transient of a body that radiates is gone after a minute: to the tolerance of the fitted memory."""
    sea = realised(climate(), 3, 150.0, seed=1)
    run, theory = rigid.powers(sea, Simulation(duration=150.0, window=(60.0, 150.0)), "linear")
    assert run == pytest.approx(theory, rel=2e-3)


def test_a_spring_of_the_take_off_is_in_both(rigid):
    """It takes nothing, and moves the resonance of the run as of the theory."""
    sea, settings = realised(climate(), 3, 150.0, seed=1), Simulation(duration=150.0, window=(60.0, 150.0))
    held = replace(rigid, take_off=replace(rigid.take_off, stiffness=2e4))
    run, theory = held.powers(sea, settings, "linear")
    assert run == pytest.approx(theory, rel=2e-3)
    assert abs(theory / rigid.powers(sea, settings, "linear")[1] - 1) > 0.05


def test_what_a_better_model_changes_grows_with_the_square_of_the_waves(rigid):
    """Beside the linear run in the same waves; small waves need no better model."""
    sea = realised(climate(), 3, 150.0, seed=1)
    settings = Simulation(duration=150.0, window=(60.0, 150.0), tolerance=1e-8)
    linear = rigid.powers(sea, settings, "linear")
    apart = []
    for part in (0.1, 0.2, 0.4):
        run, theory = rigid.powers(replace(sea, amplitude=part * sea.amplitude), settings)
        assert theory == pytest.approx(part**2 * linear[1], rel=1e-12)
        apart.append(run / theory - linear[0] / linear[1])
    assert abs(apart[0]) < 1e-3
    assert np.log2(np.array(apart[1:]) / apart[:-1]) == pytest.approx([2.0, 2.0], abs=0.2)
