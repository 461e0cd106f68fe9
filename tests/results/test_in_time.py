"""Runs in time of the seas of a climate against linear theory."""

from dataclasses import replace

import numpy as np
import pytest
from results.test_year import climate

from vsb.hydro.statespace import fit_radiation
from vsb.motion.port import LinearPto
from vsb.results.in_time import DesignInTime
from vsb.scenes.rest import design_motions, reference_shell, study_basis
from vsb.study.study import Simulation
from vsb.study.take_off import Pto
from vsb.waves.climate import realised


@pytest.fixture(scope="module")
def rigid(seed, spectral_seed):
    """The seed's rigid buoy at 20 kN s/m."""
    radiation, basis = fit_radiation(spectral_seed.spectrum, 1e-3)[0], study_basis(seed)
    return DesignInTime(
        spectral_seed, reference_shell(seed).shape, radiation, design_motions(seed, basis, "FSB"), LinearPto(2e4)
    )


def test_linear_run_agrees_with_linear_theory(rigid):
    """To the tolerance of the fitted memory, after a minute of transient."""
    sea = realised(climate(), 3, 150.0, seed=1)
    run, theory = rigid.powers(sea, Simulation(duration=150.0, window=(60.0, 150.0)), "linear")
    assert run == pytest.approx(theory, rel=2e-3)


def test_spring_of_the_take_off_shifts_run_and_theory_alike(rigid):
    sea, settings = realised(climate(), 3, 150.0, seed=1), Simulation(duration=150.0, window=(60.0, 150.0))
    held = replace(rigid, take_off=replace(rigid.take_off, stiffness=2e4))
    run, theory = held.powers(sea, settings, "linear")
    assert run == pytest.approx(theory, rel=2e-3)
    assert abs(theory / rigid.powers(sea, settings, "linear")[1] - 1) > 0.05


def test_nonlinear_correction_scales_with_the_amplitude_squared(rigid):
    """Relative to the linear run in the same waves."""
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


def test_force_and_stroke_limits_reduce_the_power(rigid):
    sea, settings = realised(climate(), 3, 60.0, seed=1), Simulation(duration=60.0, window=(40.0, 60.0))
    free, theory = rigid.powers(sea, settings, "linear")
    wide, tight = (replace(rigid, pto=Pto(damping=2e4, force_limit=limit)) for limit in (1e9, 4e3))
    assert wide.powers(sea, settings, "linear") == pytest.approx((free, theory), rel=1e-6)
    held = tight.powers(sea, settings, "linear")
    assert held[1] == theory
    assert 0.1 * free < held[0] < 0.9 * free
    stopped = replace(rigid, pto=Pto(damping=2e4, stroke_limit=0.3)).powers(sea, settings, "linear")
    assert stopped[0] < 0.9 * free


def test_latching_absorbs_more_than_a_weak_damper(rigid):
    weak = rigid.under(1e3)
    sea, settings = realised(climate(), 3, 30.0, seed=1), Simulation(duration=30.0, window=(10.0, 30.0))
    latched = replace(weak, pto=Pto(damping=1e3, law="latching")).powers(sea, settings, "linear")
    assert latched[0] > 1.2 * weak.powers(sea, settings, "linear")[0]
