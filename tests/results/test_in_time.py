"""Runs in time of a climate's seas: without what linear theory leaves out they say what it says."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from results.test_year import climate

from vsb.errors import ConvergenceError
from vsb.hydro.statespace import fit_radiation
from vsb.motion.pto import LinearPto
from vsb.results import in_time
from vsb.results.in_time import DesignInTime
from vsb.scenes.pause import BestPause
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


def test_a_take_off_with_limits_is_followed_with_them(rigid):
    """Beside the same linear theory: a limit no force reaches changes nothing, one that it does takes power away."""
    sea, settings = realised(climate(), 3, 60.0, seed=1), Simulation(duration=60.0, window=(40.0, 60.0))
    free, theory = rigid.powers(sea, settings, "linear")
    wide, tight = (replace(rigid, pto=Pto(damping=2e4, force_limit=limit)) for limit in (1e9, 4e3))
    assert wide.powers(sea, settings, "linear") == pytest.approx((free, theory), rel=1e-6)
    held = tight.powers(sea, settings, "linear")
    assert held[1] == theory
    assert 0.1 * free < held[0] < 0.9 * free
    stopped = replace(rigid, pto=Pto(damping=2e4, stroke_limit=0.3)).powers(sea, settings, "linear")
    assert stopped[0] < 0.9 * free


def test_a_law_that_pauses_pauses_as_long_as_is_best(rigid):
    """With a damper far below the best, holding the port between its strokes takes more than the damper alone."""
    weak = rigid.under(1e3)
    sea, settings = realised(climate(), 3, 30.0, seed=1), Simulation(duration=30.0, window=(10.0, 30.0))
    latched = replace(weak, pto=Pto(damping=1e3, law="latching")).powers(sea, settings, "linear")
    assert latched[0] > 1.2 * weak.powers(sea, settings, "linear")[0]


def test_a_body_exact_run_pauses_as_long_as_suits_the_wet_shell(rigid, monkeypatch):
    refined = []

    def refine(scene, linear, *_):
        refined.append((scene.water is not None, linear.pause))
        return BestPause(0.0, 0.0, 0.0)

    monkeypatch.setattr(in_time, "best_pause_in_sea", lambda *_: BestPause(0.9, 0.0, 0.0))
    monkeypatch.setattr(in_time, "refined_pause", refine)
    sea, settings = realised(climate(), 3, 30.0, seed=1), Simulation(duration=30.0, window=(10.0, 30.0))
    latching = replace(rigid.under(1e4), pto=Pto(damping=1e4, law="latching"))
    without = replace(latching, pto=Pto(damping=1e4, force_limit=1e9))
    assert latching.powers(sea, settings)[0] == pytest.approx(without.powers(sea, settings)[0], rel=1e-6)
    latching.powers(sea, settings, "linear")
    assert refined == [(True, 0.9)]


def test_a_run_is_followed_with_the_spectrum_of_its_memory_and_its_own_settings(rigid, monkeypatch):
    """Only the convolution reads it; the scene is of the design's own take-off."""
    seen, followed = [], in_time.legs

    def legs(system, sea, settings, spectrum):
        seen.append((sea, settings, spectrum))
        return followed(system, sea, settings, spectrum)

    monkeypatch.setattr(in_time, "legs", legs)
    sea, settings = realised(climate(), 3, 20.0, seed=1), Simulation(duration=20.0, window=(10.0, 20.0))
    rigid.powers(sea, settings, "linear")
    assert seen == [(sea, settings, rigid.buoy.spectrum)]
    assert rigid.buoy.spectrum is not None


def test_mean_power_is_what_the_take_off_gains_in_the_window_over_all_legs(rigid, monkeypatch):
    """Of a cubic, which splines are exact of, in three legs of other lengths, one after the other; times between."""
    ends = ([0.0, 2.0, 3.0, 5.0], [5.0, 6.0, 9.0], [9.0, 10.0, 11.0, 14.0, 20.0])

    def energy(time):
        return 3.0 + 40.0 * time - 2.5 * time**2 + 0.25 * time**3

    lost = 0.0

    def legs(*_):
        for time in map(np.array, ends):
            energies = {"pto": energy(time), "radiation": 0 * time}
            balance = SimpleNamespace(residual=lost * time[-1] / ends[-1][-1])
            yield SimpleNamespace(motion=SimpleNamespace(time=time), energy=energies, balance=balance)

    monkeypatch.setattr(in_time, "legs", legs)
    sea, settings = realised(climate(), 3, 20.0, seed=1), Simulation(duration=20.0, window=(4.5, 17.0))
    run, _ = rigid.powers(sea, settings, "linear")
    assert run == pytest.approx((energy(17.0) - energy(4.5)) / 12.5, rel=1e-12)
    lost = 6e-6
    with pytest.raises(ConvergenceError, match=r"^the energy audit fails: 6\.0e-06 of the energy is missing"):
        rigid.powers(sea, settings, "linear")


def test_the_pause_of_a_body_exact_run_is_looked_for_near_that_of_its_linear_scene(rigid, monkeypatch):
    """Of the same take-off in the same sea; what moves nothing pauses nothing."""
    asked = []

    def linear(scene, *given):
        asked.append(("linear", scene.water is None, bool(scene.law), given))
        return BestPause(0.9, 0.0, 0.0)

    def refined(scene, best, *given):
        asked.append(("refined", scene.water is None, best.pause, given))
        return BestPause(0.3, 0.0, 0.0)

    paused = []
    monkeypatch.setattr(in_time, "best_pause_in_sea", linear)
    monkeypatch.setattr(in_time, "refined_pause", refined)
    monkeypatch.setattr(in_time, "with_pause", lambda scene, pause: paused.append(pause) or scene)
    sea, settings = realised(climate(), 3, 12.0, seed=1), Simulation(duration=12.0, window=(6.0, 12.0))
    latching = replace(rigid.under(1e4), pto=Pto(damping=1e4, law="latching"))
    latching.powers(sea, settings)
    latching.powers(sea, settings, "linear")
    given = (sea, settings)
    assert asked == [("linear", True, True, given), ("refined", False, 0.9, given), ("linear", True, True, given)]
    assert paused == [0.3, 0.9]
    breathing = np.eye(len(rigid.buoy.mass))[1]
    still = replace(latching, take_off=LinearPto(1e4, 0.0, breathing))
    still._run(sea, settings, "linear")
    assert len(asked) == 3
