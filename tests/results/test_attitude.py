"""Pitch and surge of a run against what linear theory knows."""

import numpy as np
import pytest
import xarray as xr
from conftest import SEED, varied

from vsb.results.attitude import attitude_checks
from vsb.study.study import load, parse
from vsb.waves.dispersion import wavenumber


@pytest.mark.parametrize(("pitch", "surge", "verdicts"), [(0.1, 0.2, ("ok", "ok")), (0.5, 1.5, ("doubt", "doubt"))])
def test_large_angles_and_excursions_are_doubted(pitch, surge, verdicts):
    data = load(SEED).model_dump() | {"motion": "planar"}
    data["device"] |= {"centre_of_mass": -0.5, "ballast_inertia": 8e3}
    study = varied(parse(data), waves=[{"kind": "regular", "amplitude": 0.1, "period": 3.0}])
    position = np.array([[0.0, 0.0, 0.0], [0.3, -surge, pitch]])
    run = xr.Dataset(
        {"position": (("time", "dof"), position)}, {"time": [0.0, 1.0], "dof": ["Heave", "Surge", "Pitch"]}
    )
    run = run.assign_attrs(design="FSB", wave=study.waves[0].label)
    checks = attitude_checks(study, run)
    assert [check.name for check in checks] == ["pitch", "surge"]
    assert tuple(check.verdict for check in checks) == verdicts
    assert checks[0].value == pitch
    assert checks[1].value == pytest.approx(surge * wavenumber(2 * np.pi / 3, np.inf, 9.81))
    assert attitude_checks(load(SEED), run) == []
    still = varied(study, waves=[{"kind": "still"}])
    assert [check.name for check in attitude_checks(still, run.assign_attrs(wave="still"))] == ["pitch"]
