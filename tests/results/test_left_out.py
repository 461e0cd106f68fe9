"""Modes left out: the change that bending makes, one-sided, in every sea."""

import numpy as np
import pytest
from conftest import varied

from vsb.motion.tuning import best_dampers
from vsb.results.left_out import modes_left_out
from vsb.scenes.rest import design_motions, study_basis
from vsb.study.plan import StudyPlan
from vsb.waves.seas import sea

WAVES = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (2.5, 3.3, 8.0)]
WAVES.append({"kind": "jonswap", "hs": 0.5, "tp": 4.0})
DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}}


@pytest.fixture
def study(coarse):
    return varied(coarse, waves=WAVES, designs=DESIGNS)


def seas(study):
    return [(wave, sea(wave, study.hydro.omega_max, 60.0)) for wave in study.waves]


def test_the_truth_lies_between_none_and_all_of_what_bending_changes(study, buoy_of):
    """As of a database with bending, each design at its own optimal damper; a rigid design has no modes."""
    met, powers = seas(study), {}
    for kind in ("membrane", "full"):
        own = varied(study, modes={"basis": kind})
        buoy, basis = buoy_of(own), study_basis(own)
        heave = np.eye(len(basis.labels))[0]
        for design in DESIGNS:
            power = []
            for _, waves in met:
                port = buoy.port(waves.omega, design_motions(own, basis, design), heave)
                power.append(best_dampers(port, np.abs(waves.amplitude[None]) ** 2).power[0])
            powers[design, kind] = np.array(power)
    found = modes_left_out(StudyPlan(study).ladder, buoy_of(study).database, met)
    change = powers["VSWEC", "full"] / powers["VSWEC", "membrane"] - 1
    gain = 100 * (powers["VSWEC", "full"] - powers["VSWEC", "membrane"]) / powers["FSB", "membrane"]
    assert change[0] < 0 < change[1]
    for name, expected in (("power", change), ("gain", gain)):
        low, high = (found[name].sel(design="VSWEC", end=end).values for end in ("low", "high"))
        np.testing.assert_allclose(low, np.minimum(expected, 0), rtol=1e-6, atol=1e-9)
        np.testing.assert_allclose(high, np.maximum(expected, 0), rtol=1e-6, atol=1e-9)
        assert not found[name].sel(design="FSB").values.any()


@pytest.mark.parametrize(
    "changes",
    [
        {"modes": {"basis": "full"}},
        {"designs": {"FSB": {"flexible": False}}},
        {"modes": {"degree": 1}},
    ],
)
def test_where_nothing_is_known_to_be_left_out_nothing_is_said(study, buoy_of, changes):
    other = varied(study, **changes)
    assert not modes_left_out(StudyPlan(other).ladder, buoy_of(other).database, seas(other)).data_vars
