"""Captions name what is drawn."""

from conftest import varied

from vsb.report.captions import captions
from vsb.study.plan import figure_names


def test_limit_of_axisymmetric_buoys_is_not_claimed_for_bodies():
    buoy, body = (captions(given=True, body=body) for body in (False, True))
    assert "axisymmetric" in buoy["absorbed_power"]
    assert "if and only if it lowers Q" in buoy["reactance"]
    assert "axisymmetric" not in body["absorbed_power"]
    assert body["reactance"].endswith("Q = |X|/R.")
    assert "mode of degree 1" in buoy["added_mass_damping"]
    assert body["added_mass_damping"].endswith("all degrees of freedom; dotted: heave.")


def test_neglected_effects_come_first():
    limited, plain = captions("without drag", given=True, body=False), captions(given=True, body=False)
    changed = {name for name in plain if limited[name] != plain[name]}
    assert changed == {"absorbed_power", "reactance"}
    assert all(limited[name] == f"Without drag: {plain[name]}" for name in changed)
    assert not any("{" in text for text in plain.values())


def test_every_figure_of_a_study_has_a_caption(seed):
    irregular = varied(seed, waves=[{"kind": "jonswap", "hs": 0.5, "tp": 4.0}])
    names = {*figure_names(irregular), *figure_names(seed.model_copy(update={"motion": "planar"}))}
    assert {"spectra", "directions-regular_A0.179_T2.5"} < names
    assert {name.partition("-")[0] for name in names} <= captions(given=True, body=False).keys()
