"""Checks of bodies: large rotations and translations, seas outside the band."""

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


def test_rotations_and_translations_are_checked():
    moved = run(["float__Heave", "spar__Pitch", "Mode7"], [0.5, 1.5 * TURN, 9.0])
    sized = xr.Dataset(attrs={"displaced_volume": 8.0})
    turned, shifted = motion_checks(study(), sized, moved)
    assert (turned.name, turned.verdict, turned.value) == ("rotation", "doubt", pytest.approx(1.5 * TURN, rel=1e-3))
    assert (shifted.name, shifted.verdict, shifted.value) == ("translation", "ok", pytest.approx(0.25, rel=1e-3))
    assert shifted.limit == SHIFT
    apart = xr.Dataset(attrs={"displaced_volume_float": 1.0, "displaced_volume_spar": 8.0})
    (worst,) = motion_checks(study(), apart, run(["float__Heave", "spar__Heave"], [0.5, 0.6]))
    assert (worst.verdict, worst.value) == ("doubt", pytest.approx(0.5, rel=1e-3))  # relative to the smaller body


def test_energy_outside_the_band_is_reported():
    whole = {check.name: check for check in seas_checks(study(), xr.Dataset(coords={"omega": [0.1, 9.0]}))}
    part = {check.name: check for check in seas_checks(study(), xr.Dataset(coords={"omega": [0.9, 1.5]}))}
    assert whole["spectrum_cut"].value < 1e-3
    assert part["spectrum_cut"].value > 0.3
    assert part["spectrum_cut"].verdict == "fail"
    assert "beyond 0.9 to 1.5 rad/s of the database" in part["spectrum_cut"].explanation


@pytest.mark.parametrize("name", ["Surge", "Roll"])
def test_largest_motion_in_the_window_counts(name):
    """Of two bodies; larger motion before the window does not count."""
    time = np.linspace(0.0, 60.0, 61)
    position = np.zeros((61, 2))
    position[10, 0], position[40, 0], position[45] = 9.0, 0.01, (0.0, -0.17)
    coords = {"time": time, "dof": [f"float__{name}", f"spar__{name}"]}
    attrs = {"design": "a", "wave": "sea"}
    moved = xr.Dataset({"position": (("time", "dof"), position)}, coords, attrs)
    one = study(simulation={"duration": 60.0, "window": [20.0, 60.0]})
    (check,) = motion_checks(one, xr.Dataset(attrs={"displaced_volume": 1.0}), moved)
    kind = "rotation" if name == "Roll" else "translation"
    assert (check.name, check.value, check.design, check.wave) == (kind, pytest.approx(0.17, rel=1e-12), "a", "sea")
