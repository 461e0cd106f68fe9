"""Derivatives of all designs of a study as labelled arrays."""

import contextlib
import io
import re
from pathlib import Path

import numpy as np
import pytest

import vsb
from tests.design.conftest import study_of
from vsb.errors import ConfigError

HOME = Path(__file__).parent.parent.parent
KEYS = ["device.radius", "device.internal_pressure", "pto.stiffness"]


def test_designs_are_labelled_and_gains_have_deviations(climate):
    study = study_of(designs={"FSB": {"flexible": False}, "VSWEC": {}}, modes={"basis": "full", "degree": 2})
    found = vsb.gradient(study, climate, KEYS, uncertain={"device.radius": 0.01, "device.internal_pressure": 0.02})
    assert list(found.unit.values) == ["m", "Pa", "N/m"]
    assert list(found.value.values) == [2.0, 16.5e3, 0.0]
    assert found.annual_mean_power.units == "W"
    power, slope = found.annual_mean_power, found.annual_mean_power_gradient
    ratio = power / power.sel(design="FSB")
    np.testing.assert_allclose(found.gain_percent, 100 * (ratio - 1), atol=1e-12)
    gain = 100 * (slope - ratio * slope.sel(design="FSB")) / power.sel(design="FSB")
    np.testing.assert_allclose(found.gain_percent_gradient, gain, atol=1e-12)
    spread = np.sqrt((gain[:, 0] * 0.02) ** 2 + (gain[:, 1] * 330.0) ** 2)
    np.testing.assert_allclose(found.gain_percent_deviation, spread)
    assert found.gain_percent_deviation[0] == 0.0 < found.gain_percent_deviation[1]
    assert not any(values.isnull().any() for values in found.values())


def test_what_it_does_not_know_is_named(climate):
    with pytest.raises(ConfigError, match=r"uncertain: received device\.mass"):
        vsb.gradient(study_of(), climate, KEYS, uncertain={"device.mass": 0.1})
    with pytest.raises(ConfigError, match=r"pto\.damping: received None"):
        vsb.gradient(study_of(), climate, ["pto.damping"])
    with pytest.raises(ConfigError, match=r"pto\.damping: received 0\.0; needs one above 0"):
        vsb.gradient(study_of(pto={"damping": 0.0}), climate, ["pto.damping"])


def test_sentence_of_the_documentation_says_what_its_example_prints():
    page = " ".join((HOME / "docs" / "gradients.md").read_text(encoding="utf-8").split())
    slopes, gains = (list(map(float, row.split())) for row in re.findall(r"\[ ?(-?\d+\.[-\d. ]+)\]", page)[:2])
    minus = "\N{MINUS SIGN}"
    assert f"1 % more radius gives this buoy {slopes[0]:.1f} % more power" in page
    assert f"1 % more wall thickness reduces it by {-slopes[1]:.2f} %" in page
    assert f"{gains[0]:.1f} %, is known to within {gains[1]:.1f} points".replace("-", minus) in page


@pytest.mark.slow
def test_example_of_the_documentation(monkeypatch):
    monkeypatch.chdir(HOME)
    page = (HOME / "docs" / "gradients.md").read_text(encoding="utf-8")
    (code,), (printed,) = (re.findall(rf"```{kind}\n(.*?)```", page, re.DOTALL) for kind in ("python", "text"))
    with contextlib.redirect_stdout(io.StringIO()) as out:
        exec(code, {})
    assert out.getvalue() == printed
