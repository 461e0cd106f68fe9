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


def test_a_buoy_that_pitches_and_rolls_leans_by_both_and_drifts_along_its_waves_alone():
    """Angles of 3 and 4 to 5, of either sign; of a way along waves at 30 degrees all counts, across them nothing."""
    data = load(SEED).model_dump() | {"motion": "planar"}
    data["device"] |= {"centre_of_mass": -0.5, "ballast_inertia": 8e3}
    study = varied(parse(data), waves=[{"kind": "regular", "amplitude": 0.1, "period": 3.0}])
    (wave,) = study.waves
    turned = study.model_copy(update={"waves": (wave.model_copy(update={"direction": 30.0}),)})
    number, going = wavenumber(wave.omega, np.inf, 9.81), np.deg2rad(30.0)
    dofs = ["Surge", "Sway", "Heave", "Roll", "Pitch"]
    along, across = np.array([np.cos(going), np.sin(going)]), np.array([-np.sin(going), np.cos(going)])
    for moved, expected in ((-0.7 * along, 0.7), (9.0 * across, 0.0), (0.4 * along + 5.0 * across, 0.4)):
        position = np.array([[0.0] * 5, [*moved, 9.0, -0.04, 0.03]])
        run = xr.Dataset({"position": (("time", "dof"), position)}, {"time": [0.0, 1.0], "dof": dofs})
        run = run.assign_attrs(design="FSB", wave=turned.waves[0].label)
        pitch, surge = attitude_checks(turned, run)
        assert pitch.value == pytest.approx(0.05, rel=1e-12)
        assert surge.value == pytest.approx(number * expected, abs=1e-12)


def test_a_run_is_judged_in_the_waves_it_was_made_in_and_says_whose_it_is():
    """In the second of two seas, over 4 m of water: its own wavenumber there, and metres in the words."""
    data = load(SEED).model_dump() | {"motion": "planar"}
    data["device"] |= {"centre_of_mass": -0.5, "ballast_inertia": 8e3}
    waves = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (3.0, 6.0)]
    study = varied(parse(data), waves=waves, water={"depth": 4.0})
    position = np.array([[0.0, 0.0, 0.0], [0.3, -0.75, -0.1]])
    run = xr.Dataset(
        {"position": (("time", "dof"), position)}, {"time": [0.0, 1.0], "dof": ["Heave", "Surge", "Pitch"]}
    )
    for wave, period in zip(study.waves, (3.0, 6.0), strict=True):
        checks = attitude_checks(study, run.assign_attrs(design="FSB", wave=wave.label))
        assert [(check.design, check.wave) for check in checks] == 2 * [("FSB", wave.label)]
        assert checks[1].value == pytest.approx(0.75 * wavenumber(2 * np.pi / period, 4.0, 9.81), rel=1e-12)
        assert checks[1].explanation.startswith("wavenumber times the largest surge, 0.75 m;")


def test_how_far_a_buoy_leans_and_drifts_is_told_of_one_instant_at_a_time():
    """Pitch and roll, surge and sway are largest at other instants than what both make together."""
    data = load(SEED).model_dump() | {"motion": "planar"}
    data["device"] |= {"centre_of_mass": -0.5, "ballast_inertia": 8e3}
    study = varied(parse(data), waves=[{"kind": "regular", "amplitude": 0.1, "period": 3.0}])
    (wave,) = study.waves
    turned = study.model_copy(update={"waves": (wave.model_copy(update={"direction": 30.0}),)})
    dofs = ["Surge", "Sway", "Heave", "Roll", "Pitch"]
    position = np.array(
        [[0.0] * 5, [0.5, -0.4, 0.0, 0.03, 0.04], [-0.2, -0.6, 0.0, -0.06, 0.01], [0.1, 0.7, 0.0, 0.02, -0.055]]
    )
    position[3, 1] = 0.3
    run = xr.Dataset({"position": (("time", "dof"), position)}, {"time": np.arange(4.0), "dof": dofs})
    pitch, surge = attitude_checks(turned, run.assign_attrs(design="FSB", wave=turned.waves[0].label))
    assert [(check.limit, check.unit) for check in (pitch, surge)] == [(0.3, "rad"), (0.5, "-")]
    assert pitch.value == pytest.approx(np.hypot(0.06, 0.01), rel=1e-12)
    along = 0.2 * np.cos(np.pi / 6) + 0.6 * np.sin(np.pi / 6)
    assert surge.value == pytest.approx(wavenumber(wave.omega, np.inf, 9.81) * along, rel=1e-12)
