"""Recipes of `docs/extending.md` as they stand there; the integrator's is followed in `integrators/test_simulate.py`."""

from dataclasses import dataclass

import numpy as np
import pytest
from conftest import HERE

from vsb.integrators.harmonic_balance import harmonic_balance
from vsb.motion.forces import Damper, Excitation, Force, Linear, Spring
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.study.sections import WhiteNoise
from vsb.waves import seas


def recipe(title, **names):
    """What the code of a recipe defines."""
    text = (HERE.parent / "docs" / "extending.md").read_text(encoding="utf-8").split(f"## {title}\n")[1]
    code = text.split("```python\n")[1].split("```")[0]
    assert len(code.strip().splitlines()) <= 15
    exec(code, names)
    return names


def test_a_take_off_law_takes_what_the_wave_brings():
    """Its mean power is that of its force on the steady motion, and the balance of harmonic balance closes."""
    law = recipe("A take-off law", dataclass=dataclass, Force=Force, Linear=Linear, np=np)["QuadraticDamper"](0.5)
    wave, spring = Excitation(np.array([2.5]), np.array([[30.0 + 5j]])), Spring(np.array([[50.0]]))
    forces = {"hydrostatic": spring, "damper": Damper(np.array([[1.2]])), "excitation": wave, "square": law}
    found = harmonic_balance(
        System.of(Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1), take_off="square")), 1e-8
    )
    _, rate = found.at(np.linspace(0.0, 2 * np.pi / 2.5, 4097)[:-1])
    assert found.power.pto == pytest.approx(float(np.mean(0.5 * np.abs(rate[:, 0]) ** 3)), rel=1e-5)
    assert found.power.residual < 1e-6


def test_a_spectrum_carries_its_significant_height(monkeypatch):
    swell = recipe("A sea spectrum", np=np)["swell"]
    monkeypatch.setattr(seas, "spectrum", lambda wave, omega: swell(omega, wave.hs, 1.0, 0.05))
    sea = seas.irregular(WhiteNoise(kind="white_noise", hs=1.5, band=(0.5, 1.5)), 3.0, 600.0)
    assert 16 * np.sum(np.abs(sea.amplitude) ** 2) / 2 == pytest.approx(1.5**2, rel=1e-6)
    assert sea.omega[np.argmax(np.abs(sea.amplitude))] == pytest.approx(1.0, abs=0.01)
