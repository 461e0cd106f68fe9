"""The paper's loading at own best dampers: linear where the pressure is small, and no study of another kind."""

from pathlib import Path

import numpy as np
import pytest
from conftest import SEED, told, varied

from examples.paper_at_best_dampers import Row, best_damper, main, power_of, rows_of
from vsb.study.study import load

PAPER = Path(__file__).parents[2] / "config" / "paper_inferred.yaml"


def test_in_a_small_pressure_the_best_damper_is_the_reactance():
    """Nothing radiates, so the best damper of a heaving mass on its waterplane is |omega m - rho g A/omega|."""
    study = varied(load(PAPER), hydro={"pressure": 1.0})
    (wave,), water = study.waves, study.water
    waterplane = np.pi * (study.device.radius**2 - study.centre_height**2)
    stiffness = water.density * water.gravity * waterplane
    reactance = abs(wave.omega * study.device.mass - stiffness / wave.omega)
    damping, power = best_damper(power_of(study, "FSB"))
    assert damping == pytest.approx(reactance, rel=2e-3)
    assert power == pytest.approx((waterplane * 1.0) ** 2 / (4 * reactance), rel=1e-4)


def test_gains_are_over_the_first_design_and_no_damper_beats_the_best(monkeypatch):
    powers = {"FSB": lambda c: 10.0 - np.log(c / 2000.0) ** 2, "VSWEC": lambda c: 8.0 - np.log(c / 6000.0) ** 2}
    monkeypatch.setattr("examples.paper_at_best_dampers.power_of", lambda _, design: powers[design])
    study = varied(load(PAPER), designs={"FSB": {"flexible": False}, "VSWEC": {}}, published=None)
    rigid, shell = rows_of(study)
    assert (rigid.gain_percent, rigid.best_gain_percent) == (0.0, 0.0)
    assert rigid == Row(
        "FSB", 6000.0, pytest.approx(10 - np.log(3) ** 2), 0.0, pytest.approx(2000, rel=1e-3), 10.0, 0.0
    )
    assert shell.best_damping == pytest.approx(6000.0, rel=1e-3)
    assert shell.best_gain_percent == pytest.approx(-20.0, abs=1e-4)
    assert shell.gain_percent == pytest.approx(100 * (8.0 / rigid.power - 1))


def test_waves_have_a_port_that_tells_the_best_damper(workplace, capsys):
    text = told([str(SEED), "out.csv"], capsys, main)
    assert text.endswith("hydro.model: received 'linear', needs 'assumed_pressure', the paper's loading")
