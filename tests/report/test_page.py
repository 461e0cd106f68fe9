import re
import urllib.parse

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from vsb.report.page import (
    BODY_MEASURES,
    DETAILS,
    MEASURES,
    PUBLISHED,
    Report,
    band_statements,
    irregular_statements,
    published_table,
    render,
    sea_statements,
    statistics_table,
    table,
    winning_bands,
)

OMEGA = np.linspace(0.5, 4.0, 351)


def response(**gains):
    """Absorbed power: rigid a bump at 2 rad/s, the others times (1 + gain)."""
    base = np.exp(-((OMEGA - 2.0) ** 2))
    power = np.array([base, *((1 + gain) * base for gain in gains.values())])
    dims, coords = ("design", "omega"), {"design": ["FSB", *gains], "omega": OMEGA}
    return xr.Dataset({"absorbed_power": (dims, power), "best_power": (dims, power[:1] + 0 * power)}, coords=coords)


def row(design, power, wave="w"):
    values = dict.fromkeys(("displacement_pp", "velocity_pp", "power_peak", "energy", "energy_residual"), "1.0")
    return {
        "design": design,
        "wave": wave,
        "power_mean": str(power),
        "capture_width": "",
        "energy_gain_percent": "2",
        "power_gain_percent": "3",
        "damping": "10",
        **values,
    }


CHECKS = [
    {
        "name": "buckling",
        "design": "",
        "wave": "",
        "value": 66.4,
        "limit": 1.0,
        "unit": "-",
        "verdict": "fail",
        "explanation": "<p> & why",
    },
    {
        "name": "heave",
        "design": "A",
        "wave": "w",
        "value": 0.4,
        "limit": 0.3,
        "unit": "-",
        "verdict": "doubt",
        "explanation": "large",
    },
]


def test_winning_bands_are_the_intervals_above_the_threshold():
    gain = np.where(OMEGA < 1.0, 20.0, np.where((OMEGA > 2.0) & (OMEGA < 3.0), 5.0 + OMEGA, -10.0))
    first, second = winning_bands(OMEGA, gain)
    assert (first.start, first.gain) == (0.5, 20.0)
    assert abs(second.at - 2.99) < 1e-9
    assert winning_bands(OMEGA, -np.ones_like(OMEGA)) == []


@given(st.lists(st.floats(-50.0, 50.0), min_size=1, max_size=40))
def test_a_winning_band_has_its_own_peak(gain):
    """However near the next one is: bands hold all gains above the threshold, and each its largest."""
    gain, omega = np.array(gain), np.arange(len(gain)) / 10
    bands = winning_bands(omega, gain, 2.0)
    held = [(omega >= band.start) & (omega <= band.end) for band in bands]
    assert [(band.gain, gain[list(omega).index(band.at)]) for band in bands] == [(gain[k].max(),) * 2 for k in held]
    np.testing.assert_array_equal(np.any(held, axis=0) if held else gain > 2.0, gain > 2.0)


def test_a_reference_that_rests_in_one_wave_is_compared_in_the_others():
    """Where it takes nothing no gain can be stated; where it takes nothing at all there is none."""
    resting = response(wins=0.3).absorbed_power
    resting[{"design": 0, "omega": 100}] = 0.0
    (text,) = band_statements(resting, "FSB")
    assert text.startswith("wins absorbs more in waves of")
    resting[{"design": 0}] = 0.0
    assert band_statements(resting, "FSB") == ["FSB does not move this port, so no gain can be given."]


def test_statements_name_gains_losses_and_ties():
    text = band_statements(response(wins=0.3, loses=-0.2, same=0.001).absorbed_power, "FSB")
    assert text[0].startswith("wins absorbs more in waves of")
    assert "up to 30 %" in text[0]
    assert "less" not in text[0]
    assert "less in waves of" in text[1]
    assert "up to 20 %" in text[1]
    assert text[2] == "same: the same within 1 % everywhere."


def test_bands_are_told_to_the_word():
    """A gain of 20 % peaks at 2 rad/s, 3.14 s, from 1.6 to 2.4 rad/s, 2.62 to 3.93 s; beyond, a loss."""
    gain = np.where(np.abs(OMEGA - 2.0) < 0.405, 0.2 - 0.1 * np.abs(OMEGA - 2.0), -0.1 - 0.01 * OMEGA)
    shown = OMEGA[np.exp(-((OMEGA - 2.0) ** 2)) * np.maximum(1, 1 + gain) >= 0.05 * 1.2]
    longest, shortest = 2 * np.pi / shown[0], 2 * np.pi / shown[-1]
    (text,) = band_statements(response(A=gain).absorbed_power, "FSB")
    assert text == (
        "A absorbs more in waves of 2.62 to 3.93 s (up to 20 % at 3.14 s); "
        f"less in waves of 3.95 to {longest:.2f} s (up to 12 % at 3.95 s); "
        f"less in waves of {shortest:.2f} to 2.61 s (up to 14 % at {shortest:.2f} s) than FSB."
    )


def test_what_is_published_stands_beside_ours_and_other_designs_have_no_line():
    study = {
        "published": {"source": "x", "values": {
            "A": {"energy": 4000.0, "velocity_pp": 2.0, "pto_force_pp": 109480.0, "power_mean": 0.0}, "C": {}, "D": {"energy": 1.0},
        }},
    }  # fmt: skip
    ours = {"velocity_pp": 3.0, "energy": 5000.0, "power_mean": 1.0, "damping": 40000.0}
    rows = [{"design": d, "wave": w, **ours} for d in "ABC" for w in ("w", "still")]
    assert published_table(study, rows) == [
        ["A", "w", "velocity [m/s peak to peak]", "2", "3", "+50.0 %"],
        ["A", "w", "control force [N peak to peak]", "109480", "120000", "+9.6 %"],
        ["A", "w", "mean power [W]", "0", "1", "-"],
        ["A", "w", "energy of the run [kJ]", "4", "5", "+25.0 %"],
    ]
    assert published_table({**study, "published": None}, rows) == []


def test_no_reference_and_no_power_are_said_plainly():
    assert "No rigid design" in band_statements(response(a=0.1).absorbed_power, None)[0]
    assert "no power take-off damping" in band_statements(0 * response(a=0.1).absorbed_power, "FSB")[0]


def test_the_best_design_of_each_sea():
    rows = [
        row("FSB", 100),
        row("A", 120),
        row("FSB", 50, "v"),
        row("A", 40, "v"),
        row("FSB", 0, "z"),
        row("A", 0, "z"),
        row("FSB", 0, "n"),
        row("A", 5, "n"),
        row("FSB", 70, "u"),
    ]
    text = sea_statements(
        rows, "FSB", {"w": "a swell", "v": "a chop", "z": "still water", "n": "ripples", "u": "a wake"}
    )
    assert text[0] == "At the given damper, in a swell, A absorbs most: 120 W on average (against FSB: A +20.0 %)."
    assert (
        text[1]
        == "At the given damper, in a chop, the rigid FSB absorbs most: 50 W on average (against FSB: A -20.0 %)."
    )
    assert text[2] == "At the given damper, in still water, no design absorbs power on average."
    assert text[3] == "At the given damper, in ripples, A absorbs most: 5 W on average."
    assert text[4] == "At the given damper, in a wake, the rigid FSB absorbs: 70 W on average."


@pytest.mark.parametrize(("measure", "label", "factor", "form"), [*MEASURES, *BODY_MEASURES, *DETAILS])
def test_a_column_has_the_unit_its_head_says(measure, label, factor, form):
    """Of a comparison in SI units, gains in per cent."""
    unit = re.search(r"\[(.+)\]$", label).group(1)
    assert factor == {"kJ": 1e-3}.get(unit, 1.0)
    assert form == {"%": "+.1f", "-": ".1e"}.get(unit, "")
    assert (unit == "%") == measure.endswith("percent")


@pytest.mark.parametrize(("name", "unit", "factor"), PUBLISHED.values())
def test_what_is_published_is_in_the_unit_that_is_told(name, unit, factor):
    assert factor == (1e-3 if unit.startswith("k") else 1.0)
    assert unit in ("m peak to peak", "m/s peak to peak", "N peak to peak", "W", "kJ")


def test_what_does_not_exist_is_a_dash():
    head, body = table([row("FSB", 100)])
    assert len(head) == len(body[0])
    assert body[0][head.index("capture width [m]")] == "-"
    assert body[0][head.index("gain of mean power [%]")] == "+3.0"
    head, body = table([row("FSB", 100)], DETAILS)
    assert body[0][head.index("energy gain [%]")] == "+2.0"
    assert body[0][head.index("energy of the run [kJ]")] == "0.001"


def test_page_is_self_contained_and_escaped():
    page = render(
        Report({"study": "s", "published": None, "pto": {"damping": 10.0}, "hydro": {"tolerance": 1e-3}}, {"w": "a swell"}, [row("FSB", 100), row("A", 120)], CHECKS, response(A=0.2), "FSB",
               {"absorbed_power": "<?xml?><svg>x</svg>"}, {"Program": "vsb"})
    )  # fmt: skip
    assert (
        page.index("A absorbs most") < page.index("do not trust") < page.index("Evidence") < page.index("What to doubt")
    )
    assert "&lt;p&gt; &amp; why" in page
    assert "<?xml" not in page
    assert "<svg>x</svg>" in page
    assert page.index("Program") < page.index("vsb", page.index("Program"))
    assert "src=" not in page
    assert page.index("Over the whole band, each design at its own best damper") < page.rindex("A absorbs most")
    assert page.rindex("A absorbs most") < page.index("Over the whole band, all at the given damper")
    assert page.index("A: the same within 1 %") < page.index("A absorbs more in waves of")
    assert "1 further point is in doubt" in page


@pytest.mark.parametrize("drag", [None, {"heave": {"coefficient": 1.0, "area": 12.0}}])
def test_what_the_frequency_response_knows_nothing_of_stands_beside_its_numbers(drag):
    """Drag depends on the amplitude: bands and figures of the response are without, powers in seas are with it."""
    study = {"study": "s", "published": None, "pto": {"damping": 10.0}, "hydro": {"tolerance": 1e-3}}
    figures = dict.fromkeys(("absorbed_power", "reactance", "port_motion"), "<svg>x</svg>")
    rows = [row("FSB", 100), row("A", 120)]
    page = render(
        Report(
            study | {"drag": drag} if drag else study, {"w": "a swell"}, rows, [], response(A=0.2), "FSB", figures, {}
        )
    )
    assert page.count("Over the whole band and without drag, ") == (2 if drag else 0)
    assert page.count("Over the whole band, ") == (0 if drag else 2)
    assert page.count("Without drag: ") == (2 if drag else 0)


LINE = {
    "design": "A", "sea": "noise", "realisations": "4", "batches": "40", "power_mean": "120", "power_low": "110",
    "power_high": "130", "power_linear": "125", "gain_percent": "20", "gain_low": "18.04", "gain_high": "21.96",
}  # fmt: skip
BASE = {**LINE, "design": "FSB", "power_mean": "100", "gain_percent": "0", "gain_low": "0", "gain_high": "0"}
SHORT = {**LINE, "power_low": "", "power_high": "", "gain_low": "", "gain_high": ""}


def test_irregular_seas_are_answered_with_the_interval_of_the_gain():
    (text,) = irregular_statements([BASE, LINE], "FSB", {"noise": "white noise"})
    assert (
        text
        == "At the given damper, in white noise, FSB absorbs 100 W, A absorbs 120 W (+20.0 %; 95 %: +18.0 to +22.0 %)."
    )
    assert irregular_statements([SHORT], "FSB", {"noise": "it"}) == [
        "At the given damper, in it, A absorbs 120 W (+20.0 %)."
    ]


def test_table_of_irregular_seas_has_a_dash_for_what_does_not_exist():
    first, short = statistics_table([LINE, SHORT])
    assert first == ["A", "noise", "4", "40", "120", "110 to 130", "125", "+20.0", "+18.0 to +22.0"]
    assert (short[5], short[8]) == ("-", "-")


def test_what_holds_is_folded_and_tables_can_be_kept():
    """Data stand inside the page: it fetches nothing."""
    holds = {**CHECKS[0], "name": "thin_shell", "verdict": "ok"}
    page = render(
        Report({"study": "s", "published": None, "pto": {"damping": 10.0}, "hydro": {"tolerance": 1e-3}}, {"w": "a swell"}, [row("FSB", 18720.0)], [*CHECKS, holds],
               None, "FSB", {}, {})
    )  # fmt: skip
    open_part, _, folded = page.partition("1 check holds")
    assert "thin shell" in folded
    assert "thin shell" not in open_part
    assert "buckling" in open_part
    assert "18.72 kW on average" in page
    assert "e+0" not in open_part.replace("1.0e+00", "")  # energy residual
    assert "<script>" in page, "and does not need it: what moves is hidden until it can"
    assert "src=" not in page
    data = page.split('download="given_damper.csv" href="data:text/csv;charset=utf-8,')[1].split('"')[0]
    lines = urllib.parse.unquote(data.replace("&amp;", "&")).splitlines()
    assert lines[0].startswith("design,sea,")
    assert lines[1].startswith("FSB,w,1,1,1,18720,")


def test_realisations_of_a_sea_are_not_answered_one_by_one():
    page = render(
        Report({"study": "s", "published": None, "pto": {"damping": 10.0}, "hydro": {"tolerance": 1e-3}}, {"noise": "white noise"},
               [{**row("FSB", 100), "wave": "noise_s1"}], CHECKS, None, "FSB", {}, {}, ["noise_s1"], [BASE, LINE])
    )  # fmt: skip
    assert "in white noise, FSB absorbs 100 W" in page
    assert "Irregular seas" in page
    assert "in noise_s1" not in page
