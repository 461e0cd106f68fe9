"""The paper's loading with optimal damping: the closed form where the pressure is small."""

from pathlib import Path

import numpy as np
import pytest
from conftest import SEED, error_line, varied

from examples.paper_at_optimal_damping import best_damper, main, power_of
from vsb.study.study import load

PAPER = Path(__file__).parents[2] / "config" / "paper_inferred.yaml"


def test_optimal_damping_in_a_small_pressure_is_the_reactance():
    """Nothing radiates, so the optimum of a heaving mass on its waterplane is |omega m - rho g A/omega|."""
    study = varied(load(PAPER), hydro={"pressure": 1.0})
    (wave,), water = study.waves, study.water
    waterplane = np.pi * (study.device.radius**2 - study.centre_height**2)
    stiffness = water.density * water.gravity * waterplane
    reactance = abs(wave.omega * study.device.mass - stiffness / wave.omega)
    damping, power = best_damper(power_of(study, "FSB"))
    assert damping == pytest.approx(reactance, rel=2e-3)
    assert power == pytest.approx((waterplane * 1.0) ** 2 / (4 * reactance), rel=1e-4)


def test_linear_study_is_refused(workplace, capsys):
    text = error_line([str(SEED), "out.csv"], capsys, main)
    assert text.endswith("hydro.model: received 'linear', needs 'assumed_pressure', the paper's loading")
