"""Captions name what is drawn, and nothing that is not."""

import pytest
from conftest import varied
from report.test_curves import SERIES
from report.test_shell_figures import data as shell_data

from vsb.report.captions import captions
from vsb.report.shell_figures import extreme_shapes, shapes_3d
from vsb.study.plan import figure_names


@pytest.mark.parametrize("given", [True, False])
def test_a_side_at_the_given_damper_is_named_where_there_is_one(given):
    text = captions(given=given, body=False)["absorbed_power"]
    assert "each design at its own best damper" in text
    assert ("right at the given damper" in text) == given
    assert ("left" in text) == given


def test_a_limit_of_buoys_of_revolution_is_none_of_a_body():
    buoy, body = (captions(given=True, body=body) for body in (False, True))
    assert "axisymmetric" in buoy["absorbed_power"]
    assert "if and only if it lowers Q" in buoy["reactance"]
    assert "axisymmetric" not in body["absorbed_power"]
    assert body["reactance"].endswith("Q = |X|/R.")
    assert "mode of degree 1" in buoy["added_mass_damping"]
    assert body["added_mass_damping"].endswith("all degrees of freedom; dotted: heave.")


def test_a_port_that_reaches_more_than_heave_has_its_own_limit():
    said = captions(given=True, body=False, limit="2 λ/2π")["absorbed_power"]
    assert "a capture width of 2 λ/2π, the limit of a body of revolution at this port" in said
    assert "heaving" not in said


def test_no_gain_is_told_of_a_figure_without_one():
    told = captions(given=False, body=True, compared=False)["absorbed_power"]
    assert "gain" not in told.lower()
    assert "gain" in captions(given=False, body=True)["absorbed_power"]


@pytest.mark.parametrize("given", [True, False])
def test_where_gains_are_drawn_is_said_where_designs_are_compared_whatever_their_dampers(given):
    for compared in (True, False):
        told = captions(given=given, body=False, compared=compared)["absorbed_power"]
        assert ("Gains are drawn where at least 5 % of the largest power is absorbed." in told) == compared


def test_what_is_left_out_stands_first():
    told, plain = captions("without drag", given=True, body=False), captions(given=True, body=False)
    changed = {name for name in plain if told[name] != plain[name]}
    assert changed == {"absorbed_power", "reactance"}
    assert all(told[name] == f"Without drag: {plain[name]}" for name in changed)
    assert not any("{" in text for text in plain.values())


def test_every_figure_of_a_study_has_a_caption(seed):
    """The report asks for it by the figure's name."""
    irregular = varied(seed, waves=[{"kind": "jonswap", "hs": 0.5, "tp": 4.0}])
    names = {*figure_names(irregular), *figure_names(seed.model_copy(update={"motion": "planar"}))}
    assert {"spectra", "directions-regular_A0.179_T2.5"} < names
    assert {name.partition("-")[0] for name in names} <= captions(given=True, body=False).keys()


@pytest.mark.parametrize("name", SERIES)
def test_a_caption_names_what_the_axes_of_its_figure_show(name):
    text = captions(given=True, body=False)[name].lower()
    for label, _ in SERIES[name]:
        assert all(word in text for word in label.partition(" [")[0].split()), label


def test_captions_of_shells_say_of_which_instants_they_are(seed):
    """In the words of the figures' titles."""
    told, given = captions(given=True, body=False), shell_data()
    (height, _) = extreme_shapes(given, "w").get_suptitle().lower().split(" in the window")
    assert f"shells of all designs at their {height}, displacement magnified." == told["extreme_shapes"].lower()
    start, least, greatest = (ax.get_title().partition("\n")[0] for ax in shapes_3d(given, "w").axes)
    assert f"at the {start} and at its {least.removesuffix(' height')} and {greatest}" in told["shapes_3d"]


def test_what_is_left_out_is_said_of_a_body_without_a_rigid_design_too():
    told = captions("neither drag nor limits", given=False, body=True, limit="2 λ/2π", compared=False)
    assert told["absorbed_power"] == (
        "Neither drag nor limits: Mean absorbed power per squared wave amplitude over the whole band: each design at its own "
        "best damper at every frequency; grey: a capture width of a wavelength over 2π."
    )
    assert told["reactance"].startswith("Neither drag nor limits: Why")
