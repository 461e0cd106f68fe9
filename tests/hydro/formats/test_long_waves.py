"""Long waves tell the conventions of a file: on capytaine's own files, and where they are none."""

import capytaine as cpt
import numpy as np
import pytest
import xarray as xr
from capytaine.io.xarray import merge_complex_values
from hydro.formats.test_foreign import PAIR, WAVE

from vsb.hydro.formats.capytaine import read_capytaine
from vsb.hydro.formats.foreign import foreign_checks
from vsb.hydro.formats.long_waves import lift_check
from vsb.hydro.formats.wamit import import_wamit

FORCES = ("excitation_force", "Froude_Krylov_force", "diffraction_force")


def lifted(stiffness=(0.0, 100.0, 0.0, 200.0), force=((101.0, 93.0), (170.0, 200.0))):
    """Two bodies in two headings, in the first of two waves 0.5 rad/s; sizes of their added masses."""
    labels = ["float__Surge", "float__Heave", "spar__Surge", "spar__Heave"]
    x = np.zeros((2, 2, 4), dtype=complex)
    x[0, :, 1], x[0, :, 3] = (np.array(each) * np.exp(2j) for each in force)
    data = {"hydrostatic_stiffness": (PAIR, np.diag(stiffness)), "excitation_force": (WAVE, x)}
    return xr.Dataset(
        data, {"omega": [0.5, 0.7], "wave_direction": [0.0, 1.0], **dict.fromkeys(PAIR, labels)}
    ), np.array([5.0, 3.0, 50.0, 4.0])


def test_of_two_bodies_the_one_lifted_most_beyond_its_own_limit_is_told():
    """0.07 of 0.05 + 2 (0.02) is nearer than 0.15 of 0.05 + 2 (0.0675): each with the water of its own translations."""
    (check,), notes = lift_check(*lifted())
    assert (check.value, check.limit, notes) == (pytest.approx(0.07), pytest.approx(0.05 + 2 * 0.02), [])
    (check,), _ = lift_check(*lifted(force=((101.0, 99.0), (160.0, 200.0))))
    assert (check.value, check.limit) == (pytest.approx(0.2), pytest.approx(0.05 + 2 * 0.0675))
    (check,), _ = lift_check(*lifted(force=((101.0, 93.0), (200.0, 262.0))))
    assert check.value == pytest.approx(0.31)


@pytest.mark.parametrize(("stiffness", "known"), [(10.0, True), (9.99, False)])
def test_waves_are_long_up_to_a_second_order_of_a_fifth(stiffness, known):
    checks, notes = lift_check(*lifted((0.0, stiffness, 0.0, -200.0)))
    assert (len(checks), notes) == (
        (1, []) if known else (0, ["not checked: long_waves, of which 0.5 rad/s is none for this body"])
    )


def phases(ds, dofs=None):
    (found,) = [check for check in foreign_checks(ds, dofs=dofs)[0] if check.name == "phases"]
    return found


def conjugated(ds, names=FORCES):
    return ds.assign({name: ds[name].conj() for name in names})


@pytest.mark.parametrize("kept", [None, ["Heave"], ["Heave", "Pitch"]])
def test_conjugated_forces_are_seen_whatever_is_kept_of_the_file(ball, kept):
    """Of heave alone by its own phase -omega B; surge tells it for those that are kept."""
    ds = read_capytaine(ball)
    assert phases(ds, kept).verdict == "ok"
    found = phases(conjugated(ds), kept)
    assert (found.verdict, found.value) == ("fail", pytest.approx(2.0, abs=0.02))
    assert "their complex conjugates would fit" in found.explanation
    alone = ds.sel(influenced_dof=["Heave"], radiating_dof=["Heave"])
    assert (phases(alone).verdict, phases(conjugated(alone)).verdict) == ("ok", "fail")
    assert phases(conjugated(ds, ["diffraction_force"])).verdict == "fail", "one part alone"


@pytest.mark.parametrize(("factor", "where"), [(np.pi / 180, "radians where"), (180 / np.pi, "degrees where")])
def test_headings_in_another_unit_are_seen(ball, factor, where):
    ds = read_capytaine(ball)
    found = phases(ds.assign_coords(wave_direction=ds.wave_direction * factor))
    assert found.verdict == "fail"
    assert f"headings would fit in {where}" in found.explanation


def test_a_body_away_from_the_origin_is_sound(ball):
    """Its phases are those of the place, of surge and heave alike."""
    ds = read_capytaine(ball)
    delay = np.exp(1j * ds.omega**2 / 9.81 * 30.0 * np.cos(ds.wave_direction))
    assert phases(ds.assign({name: ds[name] * delay for name in FORCES})).verdict == "ok"


def test_a_displaced_volume_is_that_of_the_water_long_waves_push(ball):
    ds = read_capytaine(ball)
    for factor, verdict in ((1.0, "ok"), (1.3, "doubt"), (5.0, "fail")):
        checks = foreign_checks(ds.assign_attrs(displaced_volume=factor * ds.attrs["displaced_volume"]))[0]
        (found,) = [check for check in checks if check.name == "displaced_volume"]
        assert found.verdict == verdict, found


@pytest.mark.parametrize("swapped", [False, True])
def test_exchanged_limits_of_wamits_files_are_seen(ball, tmp_path, swapped):
    """Of capytaine's own writer: rows PER = -1 and 0 exchanged, as version 2.3 wrote them."""
    with xr.open_dataset(ball) as ds:
        cpt.export_dataset(tmp_path / "ball", merge_complex_values(ds), format="wamit")
    path = tmp_path / "ball.1"
    rows = path.read_text()
    if swapped:
        path.write_text(rows.replace("-1.000000e+00", "_").replace("0.000000e+00\t", "-1.0\t").replace("_", "0.0"))
    found = import_wamit(tmp_path, "ball", density=1025.0, gravity=9.81)
    verdicts = {check.name: check.verdict for check in foreign_checks(found)[0]}
    assert verdicts["added_mass_limits"] == ("fail" if swapped else "ok")
    assert verdicts["phases"] == "ok"
