"""The ledger of bodies: large rotations and translations are doubted, seas beyond the band told."""

import numpy as np
import pytest
import xarray as xr

from vsb.results.body_ledger import SHIFT, TURN, motion_checks, seas_checks
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
