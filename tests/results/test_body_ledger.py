"""The ledger of bodies: large rotations and translations are doubted, seas beyond the band told."""

import numpy as np
import pytest
import xarray as xr

from vsb.results import body_ledger
from vsb.results.body_ledger import SHIFT, TURN, motion_checks, runs_checks, seas_checks
from vsb.results.ledger import wave_checks
from vsb.study.body import BodyStudy
from vsb.study.reading import validated

SEA = {"kind": "jonswap", "hs": 1.0, "tp": 7.0}


def study(**changes):
    made = {"study": "a", "body": {"database": "-"}, "designs": {"a": {}}, "waves": [SEA], **changes}
    return validated(BodyStudy, made, "a.yaml")


def run(labels, amplitudes):
    time = np.linspace(0.0, 60.0, 601)
    position = np.array(amplitudes) * np.cos(time)[:, None]
    coords = {"time": time, "dof": labels}
    return xr.Dataset({"position": (("time", "dof"), position)}, coords, {"design": "a", "wave": "sea"})


def test_rotations_and_translations_of_any_body_are_measured():
    moved = run(["float__Heave", "spar__Pitch", "Mode7"], [0.5, 1.5 * TURN, 9.0])
    sized = xr.Dataset(attrs={"displaced_volume": 8.0})
    turned, shifted = motion_checks(study(), sized, moved)
    assert (turned.name, turned.verdict, turned.value) == ("rotation", "doubt", pytest.approx(1.5 * TURN, rel=1e-3))
    assert (shifted.name, shifted.verdict, shifted.value) == ("translation", "ok", pytest.approx(0.25, rel=1e-3))
    assert shifted.limit == SHIFT
    assert [check.name for check in motion_checks(study(), xr.Dataset(), moved)] == ["rotation"]
    assert motion_checks(study(), sized, run(["Mode7"], [9.0])) == []
    apart = xr.Dataset(attrs={"displaced_volume_float": 1.0, "displaced_volume_spar": 8.0})
    (worst,) = motion_checks(study(), apart, run(["float__Heave", "spar__Heave"], [0.5, 0.6]))
    assert (worst.verdict, worst.value) == ("doubt", pytest.approx(0.5, rel=1e-3))  # of the small one, not the sum
    (worst,) = motion_checks(
        study(), apart.assign_attrs(displaced_volume=27.0), run(["float__Heave", "buoy__Heave"], [0.5, 1.8])
    )
    assert worst.value == pytest.approx(0.6, rel=1e-3)  # of what says nothing of itself, the whole counts
    (own,) = motion_checks(study(), apart.assign_attrs(displaced_volume=27.0), run(["float__Heave"], [0.5]))
    assert own.value == pytest.approx(0.5, rel=1e-3)


def test_what_of_a_sea_lies_beyond_the_band_is_told():
    whole = {check.name: check for check in seas_checks(study(), xr.Dataset(coords={"omega": [0.1, 9.0]}))}
    part = {check.name: check for check in seas_checks(study(), xr.Dataset(coords={"omega": [0.9, 1.5]}))}
    assert whole["spectrum_cut"].value < 1e-3
    assert part["spectrum_cut"].value > 0.3
    assert part["spectrum_cut"].verdict == "fail"
    assert "beyond 0.9 to 1.5 rad/s of the database" in part["spectrum_cut"].explanation


@pytest.mark.parametrize("name", ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"])
def test_the_largest_of_a_motion_counts_in_the_window_alone_up_or_down_and_of_whichever_body(name):
    """Of two bodies the second goes further, down, in the middle of the window; before it the first did much more."""
    time = np.linspace(0.0, 60.0, 61)
    position = np.zeros((61, 2))
    position[10, 0], position[40, 0], position[45] = 9.0, 0.01, (0.0, -0.17)
    coords = {"time": time, "dof": [f"float__{name}", f"spar__{name}"]}
    attrs = {"design": "a", "wave": "sea"}
    moved = xr.Dataset({"position": (("time", "dof"), position)}, coords, attrs)
    one = study(simulation={"duration": 60.0, "window": [20.0, 60.0]})
    (check,) = motion_checks(one, xr.Dataset(attrs={"displaced_volume": 1.0}), moved)
    kind = "rotation" if name in ("Roll", "Pitch", "Yaw") else "translation"
    assert (check.name, check.value, check.design, check.wave) == (kind, pytest.approx(0.17, rel=1e-12), "a", "sea")


def test_every_sea_is_judged_in_the_study_s_own_water():
    """A regular wave and an irregular sea over 5 m of water, the band of the database from 0.3 to 2 rad/s."""
    waves = [{"kind": "regular", "amplitude": 0.4, "period": 6.0}, SEA]
    one = study(waves=waves, water={"depth": 5.0})
    found = seas_checks(one, xr.Dataset(coords={"omega": [0.3, 2.0]}))
    assert found == [check for wave in one.waves for check in wave_checks(wave, one.water, 2.0, 0.3)]
    assert [check.name for check in found] == ["steepness", "steepness", "spectrum_cut"]


def test_every_design_s_own_run_is_judged_for_energy_motion_and_what_it_holds(monkeypatch):
    """In the order of the designs, whatever the order of the runs."""
    one = study(designs={"a": {}, "b": {}})
    kinds = ("energy_check", "motion_checks", "drift_checks")
    monkeypatch.setattr(body_ledger, kinds[0], lambda study, run: (kinds[0], run))
    monkeypatch.setattr(body_ledger, kinds[1], lambda study, database, run: [(kinds[1], run, database)])
    monkeypatch.setattr(body_ledger, kinds[2], lambda study, run: [(kinds[2], run)])
    found = runs_checks(one, "database", one.waves[0], {"b": "run of b", "a": "run of a"})
    assert found == [
        told
        for run in ("run of a", "run of b")
        for told in ((kinds[0], run), (kinds[1], run, "database"), (kinds[2], run))
    ]


def test_a_turn_of_a_fifth_and_a_shift_of_three_tenths_of_its_size_are_the_most_a_body_is_known_at():
    for part, verdict in ((0.99, "ok"), (1.01, "doubt")):
        moved = run(["Yaw", "Sway"], [0.2 * part, 2.0 * 0.3 * part])
        found = motion_checks(study(), xr.Dataset(attrs={"displaced_volume": 8.0}), moved)
        assert [(check.limit, check.unit, check.verdict) for check in found] == [
            (0.2, "rad", verdict), (0.3, "-", verdict),
        ]  # fmt: skip
