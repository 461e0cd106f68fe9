import csv
import html
import io
import re
import urllib.parse

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from report.test_tuned import SWELL

from vsb.report.page import (
    BODY_MEASURES,
    DETAILS,
    MEASURES,
    PUBLISHED,
    PUBLISHED_HEAD,
    STATISTICS,
    STILL,
    Band,
    Report,
    _answer,
    _band_text,
    band_statements,
    irregular_statements,
    published_table,
    render,
    sea_statements,
    statistics_table,
    table,
    winning_bands,
)
from vsb.report.tuned import NO_BEST_DAMPER, TUNING, tuned_statements, tuning_table

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


def test_a_design_that_rests_in_some_waves_loses_all_there_and_hides_nothing_of_the_others():
    """Whatever one design does, bands of another are the same."""
    absorbed = response(wins=0.3, rests=0.3).absorbed_power
    alone = band_statements(absorbed.sel(design=["FSB", "wins"]), "FSB")
    absorbed[{"design": 2}] = absorbed[2].where((OMEGA < 1.5) | (OMEGA > 2.5), 0.0)
    wins, rests = band_statements(absorbed, "FSB")
    assert [wins] == alone
    assert "less in waves of 2.51 to 4.19 s (up to 100 % at " in rests


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
            "A": {"energy": 4000.0, "velocity_pp": 2.0, "pto_force_pp": 109480.0, "power_mean": 0.0},
            "B": {"power_mean": -4.0}, "C": {}, "D": {"energy": 1.0},
        }},
    }  # fmt: skip
    ours = {"velocity_pp": 3.0, "energy": 5000.0, "power_mean": 1.0, "damping": 40000.0}
    rows = [{"design": d, "wave": w, **ours} for d in "ABC" for w in ("w", "still")]
    assert published_table(study, rows) == [
        ["A", "w", "velocity [m/s peak to peak]", "2", "3", "+50.0 %"],
        ["A", "w", "control force [N peak to peak]", "109480", "120000", "+9.6 %"],
        ["A", "w", "mean power [W]", "0", "1", "-"],
        ["A", "w", "energy of the run [kJ]", "4", "5", "+25.0 %"],
        ["B", "w", "mean power [W]", "-4", "1", "-125.0 %"],
    ]
    assert published_table({**study, "published": None}, rows) == []


def test_the_control_force_of_each_line_is_of_its_own_damper_and_velocity():
    """Dampers differ by design and, where they are tuned, by sea."""
    study = {"published": {"source": "x", "values": {name: {"pto_force_pp": 1e3} for name in "AB"}}}
    known = [("A", "w", 100.0, 20.0), ("A", "v", 300.0, 5.0), ("B", "w", 50.0, 30.0)]
    ours = {"displacement_pp": 1.0, "power_peak": 1.0, "power_mean": 1.0, "energy": 1.0}
    rows = [{"design": d, "wave": w, "damping": c, "velocity_pp": v, **ours} for d, w, c, v in known]
    assert [line[:2] + line[4:] for line in published_table(study, rows)] == [
        ["A", "w", "2000", "+100.0 %"], ["A", "v", "1500", "+50.0 %"], ["B", "w", "1500", "+50.0 %"],
    ]  # fmt: skip


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


def test_in_still_water_the_energy_of_the_run_is_told_and_not_the_power_of_its_end():
    """A buoy let go: FSB takes more in the end, A more in all; what is less than nothing takes nothing."""
    rows = [
        row("FSB", 9.0, "still") | {"energy": "4000"},
        row("A", 1.0, "still") | {"energy": "5000"},
        row("B", 8.0, "still"),
    ]
    assert sea_statements(rows, "FSB", {"still": "still water"}) == [
        "At the given damper, in still water, A absorbs most: 5 kJ from the start (against FSB: A +25.0 %, B -100.0 %)."
    ]
    assert sea_statements(rows[:1], "FSB", {"still": "still water"}) == [
        "At the given damper, in still water, the rigid FSB absorbs: 4 kJ from the start."
    ]
    none = [one | {"energy": "0.0"} for one in rows]
    assert sea_statements(none, "FSB", {"still": "still water"}) == [
        "At the given damper, in still water, no design absorbs power on average."
    ]


def test_a_design_without_others_has_no_gain_over_any_band():
    """A rigid one, beside itself; whether it takes anything is said before."""
    alone = response().absorbed_power
    assert band_statements(alone, "FSB") == ["FSB is the only design of this study, so there is no gain to give."]
    assert band_statements(0 * alone, "FSB") == ["No design absorbs power: the study has no power take-off damping."]


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
        page.index("A absorbs most")
        < page.index("Checks that fail:")
        < page.index("Evidence")
        < page.index("What to doubt")
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
    "design": "A", "sea": "noise", "amplitudes": "random", "realisations": "4", "batches": "40", "power_mean": "120",
    "power_low": "110", "power_high": "130", "power_linear": "125", "power_linear_record": "121", "gain_percent": "20", "gain_low": "18.04", "gain_high": "21.96",
}  # fmt: skip
BASE = {**LINE, "design": "FSB", "power_mean": "100", "gain_percent": "0", "gain_low": "0", "gain_high": "0"}
SHORT = {**LINE, "power_low": "", "power_high": "", "gain_low": "", "gain_high": ""}


def test_irregular_seas_are_answered_with_the_interval_of_the_gain():
    (text,) = irregular_statements([BASE, LINE], "FSB", {"noise": "white noise"})
    assert (
        text
        == "At the given damper, in white noise, FSB absorbs 100 W, A absorbs 120 W (+20.0 %; +18.0 to +22.0 % of the sea, "
        "95 %)."
    )
    assert irregular_statements([LINE | {"amplitudes": "fixed"}], "FSB", {"noise": "it"}) == [
        "At the given damper, in it, A absorbs 120 W (+20.0 %; +18.0 to +22.0 % of these waves, by the numbers' tolerance)."
    ]
    assert irregular_statements([SHORT], "FSB", {"noise": "it"}) == [
        "At the given damper, in it, A absorbs 120 W (+20.0 %)."
    ]


@pytest.mark.parametrize(("low", "high", "bounds"), [(0.0, 2.0, "+0.0 to +2.0"), (-2.0, 0.0, "-2.0 to +0.0")])
def test_an_interval_that_ends_at_nothing_is_known(low, high, bounds):
    """So is a gain of nothing; what does not exist is empty or none."""
    line = {**LINE, "gain_percent": 0.0, "gain_low": low, "gain_high": high}
    (text,) = irregular_statements([line], "FSB", {"noise": "it"})
    assert text == f"At the given damper, in it, A absorbs 120 W (+0.0 %; {bounds} % of the sea, 95 %)."
    assert statistics_table([line])[0][8:] == ["+0.0", f"{bounds} %".removesuffix(" %")]
    (text,) = irregular_statements([line | {"gain_low": None, "gain_high": None}], "FSB", {"noise": "it"})
    assert text == "At the given damper, in it, A absorbs 120 W (+0.0 %)."


def test_every_irregular_sea_has_a_sentence_of_its_own_lines():
    """In the order of the lines, whatever stands between those of one sea."""
    rough = {"sea": "rough", "power_mean": "300", "gain_percent": "-5", "gain_low": "-6", "gain_high": "-4"}
    lines = [BASE, BASE | {"sea": "rough", "power_mean": "315"}, LINE, LINE | rough]
    assert irregular_statements(lines, "FSB", {"rough": "a storm", "noise": "white noise"}) == [
        "At the given damper, in white noise, FSB absorbs 100 W, A absorbs 120 W (+20.0 %; +18.0 to +22.0 % of the sea, "
        "95 %).",
        "At the given damper, in a storm, FSB absorbs 315 W, A absorbs 300 W (-5.0 %; -6.0 to -4.0 % of the sea, 95 %).",
    ]


def test_table_of_irregular_seas_has_a_dash_for_what_does_not_exist():
    first, short = statistics_table([LINE, SHORT])
    assert first == ["A", "noise", "random", "4", "120", "110 to 130", "121", "125", "+20.0", "+18.0 to +22.0"]
    assert (short[5], short[9]) == ("-", "-")


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


def test_a_gain_of_just_a_per_cent_is_none():
    assert winning_bands(np.array([1.0, 2.0]), np.array([1.0, 1.0])) == []
    (band,) = winning_bands(np.array([1.0, 2.0]), np.array([1.0, 1.001]))
    assert band == (2.0, 2.0, 1.001, 2.0)
    said = [band_statements(response(A=gain).absorbed_power, "FSB")[0] for gain in (0.0099, 0.0101, -0.0099, -0.0101)]
    same = "A: the same within 1 % everywhere."
    assert [text == same for text in said] == [True, False, True, False]
    assert [text.split()[2] for text in said if text != same] == ["more", "less"]


STUDY = {"study": "s", "published": None, "pto": {"damping": 10.0}, "hydro": {"tolerance": 1e-3}}


BOTH = (row("FSB", 100), row("A", 120))


def page_of(rows=BOTH, checks=(), study=STUDY, found=None, figures=(), **more):
    """A page of a swell, as text."""
    drawn = dict.fromkeys(figures, "<svg>x</svg>")
    seas = {line["wave"]: "a swell" for line in rows}
    return render(Report(study, seas, rows, checks, found, more.pop("reference", "FSB"), drawn, {}, **more))


def test_the_head_of_a_page_tells_three_failures_and_counts_what_else_fails_or_is_in_doubt():
    failing = [{**CHECKS[0], "name": name} for name in ("buckling", "passivity", "steepness", "strain", "surge")]
    page = page_of(checks=[*failing, *[CHECKS[1]] * 4, {**CHECKS[1], "verdict": "ok", "name": "drag"}])
    head = page.partition("2 more checks fail, 4 further points are in doubt: see")[0]
    assert head != page
    told = [name for name in ("buckling", "passivity", "steepness", "strain", "surge") if f"{name}: 66.4" in head]
    assert told == ["buckling", "passivity", "steepness"]
    assert "1 check holds" in page


def test_tables_of_a_buoy_are_of_its_heave_and_those_of_a_body_of_its_port():
    for thing, there, other in (("buoy", "heave", "port"), ("body", "port", "heave")):
        page = page_of(thing=thing)
        assert f"{there}, peak to peak [m]" in page
        assert f"{other}, peak to peak [m]" not in page
        assert f"Does the flexible {thing} absorb more power than the rigid one?" in page
        energies = page.partition("Energy of the whole run, start-up included")[2]
        assert "energy of the run [kJ]" in energies.partition("</table>")[0]
    assert "How much power does the rigid buoy absorb?" in page_of(flexible=False)


def test_captions_are_of_what_floats_of_its_limit_and_of_whom_it_is_compared_with():
    figures = ("absorbed_power", "added_mass_damping")
    found = response(A=0.2)
    page = page_of(found=found.assign_attrs(limit="2 λ/2π"), figures=figures)
    assert "a capture width of 2 λ/2π, the limit of a body of revolution at this port" in page
    assert "mode of degree 1" in page
    assert "the limit of an axisymmetric heaving body" in page_of(found=found, figures=figures)
    assert "all degrees of freedom; dotted: heave" in page_of(thing="body", found=found, figures=figures)
    gain = "and the gain over the rigid design"
    assert gain in page
    assert gain not in page_of(found=found, figures=figures, reference=None)
    for alone in ([row("FSB", 100)], [row("FSB", 100), row("FSB", 90, "v")]):  # in two seas it has no other either
        assert gain not in page_of(alone, found=found, figures=figures)


def test_dampers_are_named_in_the_units_of_their_port_and_bands_at_a_damper_need_one():
    volume = {**STUDY, "pto": {"damping": 10.0, "port": "volume"}}
    assert "damper [N s/m]" in page_of()
    assert "damper [Pa s/m³]" in page_of(study=volume)
    assert "N s/m" not in page_of(study=volume)
    assert "Designs side by side, at the given damper<" in page_of()
    tuned = {**STUDY, "pto": {"tuning": "each"}}
    both = [page_of(study=study, found=response(A=0.2)) for study in (STUDY, tuned)]
    assert ["all at the given damper:" in page for page in both] == [True, False]
    assert "Designs side by side, in time, at their own best dampers<" in both[1]


def test_limits_and_what_is_published_stand_on_the_page_with_their_source():
    limited = [
        {"design": "FSB", "sea": "w", "power": 100.0, "gain_percent": 0.0},
        {"design": "A", "sea": "w", "power": 112.3, "gain_percent": 12.3},
    ]
    study = {**STUDY, "published": {"source": "Somebody 2020", "values": {"A": {"power_mean": 100.0}}}}
    page = page_of(study=study, within_limits=limited)
    assert "In a swell, no take-off within its limits absorbs more than: FSB 100 W, A 112.3 W (+12.3 %)." in page
    assert "<p>Somebody 2020</p>" in page
    assert "published" not in page_of().partition("<body")[2].lower()


def test_the_fair_answer_of_every_sea_stands_on_the_page_where_waves_are_known():
    """At own best dampers, sentence by sentence; without a frequency response nothing is tuned."""
    page = page_of(found=response(A=0.2), equal_tuning=SWELL)
    said = tuned_statements(SWELL, "FSB", {"w": "a swell"})
    assert said
    for sentence in said:
        assert f"<p>{html.escape(sentence)}</p>" in page
        assert sentence not in html.unescape(page_of(equal_tuning=SWELL))


def test_a_page_that_moves_nothing_says_why():
    assert STILL in page_of(thing="body")


@pytest.mark.parametrize(
    ("gain", "told"), [(8.99, "up to 899 % at"), (9.01, "up to 10 times as much at"), (-0.5, "up to 50 % at")]
)
def test_a_band_of_tenfold_power_is_told_as_a_multiple(gain, told):
    assert told in band_statements(response(A=gain).absorbed_power, "FSB")[0]


@given(st.floats(900.0, 1e5))
def test_what_is_less_is_never_told_as_a_multiple_of_more(size):
    """However large the number is."""
    band = Band(1.0, 2.0, size, 1.5)
    assert f"(up to {size:.0f} % at 4.19 s)" in _band_text("less", band)
    assert f"(up to {1 + size / 100:.3g} times as much at 4.19 s)" in _band_text("more", band)


def test_the_answer_of_a_study_is_the_fair_one_if_there_is_one_and_one_sentence_of_a_sea_if_not():
    """Its two sentences; without a rigid design what the first sea says at own best dampers, else as it was run."""
    seas = {"w": "a swell", "v": "a chop"}
    tuned = [*SWELL, *({**line, "sea": "v"} for line in SWELL)]
    in_seas = ["First said.", "Then said."]

    def answered(found, reference="FSB", lines=tuned, study=STUDY):
        return _answer(Report(study, seas, [], [], found, reference, {}, {}, equal_tuning=lines), in_seas)

    found = response(A=0.2).assign(best_power=lambda ds: ds.absorbed_power)
    assert answered(None).stands == [NO_BEST_DAMPER, "First said."]
    first, second = answered(found).stands
    assert first.startswith(
        "In a swell, the most favourable of 2 seas, each design at its own optimal damper, A absorbs"
    )
    assert second.startswith("Over all waves that carry power, tuned wave by wave, A absorbs")
    assert "wave by wave and without drag, A" in answered(found, study={**STUDY, "drag": {"heave": 1}}).stands[1]
    assert answered(found, None).stands == tuned_statements(tuned, None, seas)[:1]
    assert answered(found, None, []).stands == ["First said."]


def test_what_the_given_damper_leaves_stands_beside_powers_of_irregular_seas_too():
    tuned = [{**line, "sea": "noise"} for line in SWELL]
    (text,) = irregular_statements([BASE, LINE], "FSB", {"noise": "it"}, tuned, "In time")
    assert text.startswith("In time, in it, FSB absorbs 100 W, A absorbs 120 W (+20.0 %;")
    assert text.endswith("); at 8000 N s/m FSB reaches 26 % of its own best, A 32 %.")
    lost = {**LINE, "gain_percent": None, "gain_low": None, "gain_high": None}
    assert irregular_statements([lost], "FSB", {"noise": "it"}) == ["At the given damper, in it, A absorbs 120 W."]
    nothing = {**LINE, "gain_percent": 0, "gain_low": 0, "gain_high": 0.0}
    assert irregular_statements([nothing], "FSB", {"noise": "it"})[0].endswith(
        "(+0.0 %; +0.0 to +0.0 % of the sea, 95 %)."
    )
    assert statistics_table([nothing])[0][8:] == ["+0.0", "+0.0 to +0.0"]


def test_a_reference_that_gives_up_power_is_no_measure_of_the_others():
    rows = [row("FSB", -4), row("A", 5), row("B", 2)]
    assert sea_statements(rows, "FSB", {"w": "it"}) == ["At the given damper, in it, A absorbs most: 5 W on average."]
    several = [row("B", 2), row("FSB", 4), row("A", 5)]
    (text,) = sea_statements(several, "FSB", {"w": "it"}, where="In time")
    assert text == "In time, in it, A absorbs most: 5 W on average (against FSB: B -50.0 %, A +25.0 %)."


def test_checks_that_do_not_hold_are_listed_whatever_their_verdict():
    """Doubts and what was accepted stand beside failures; those that hold are folded away."""
    checks = [
        {**CHECKS[0], "name": f"{verdict}_one", "verdict": verdict} for verdict in ("fail", "accepted", "doubt", "ok")
    ]
    page = page_of(checks=checks)
    shown, _, folded = page.partition("1 check holds")
    listed = shown[shown.index("What to doubt") :]
    assert [f"{verdict} one" in listed for verdict in ("fail", "accepted", "doubt", "ok")] == [True, True, True, False]
    assert "ok one" in folded
    assert "1 further point is in doubt" in page


def test_what_moves_is_sketched_and_computed_stands_on_the_page():
    sea = {"calm": True, "designs": []}
    moving = {"designs": [{"name": "FSB"}], "factor": 1.0, "seas": [sea]}
    sketch = {"name": "soft one", "words": "elastic shell, free", "svg": "<svg>sketched</svg>"}
    page = page_of(sketches=[sketch], living={"here": 1}, buoys=moving)
    for part in ("FSB side by side; all is to scale.", '"here":1', "elastic shell, free"):
        assert part in page
        assert part not in page_of()
    assert (STILL in page, STILL in page_of()) == (False, True)
    assert "In time, at their own best dampers, in a swell, A absorbs most" in page_of(
        study={**STUDY, "pto": {"tuning": "each"}}
    )


def test_what_the_given_damper_leaves_is_told_of_each_sea_by_itself():
    """In the second sea B is given its own best; in the third nothing is known of it."""
    chop = [{**line, "sea": "v", "share": share} for line, share in zip(SWELL, (0.5, 1.0), strict=True)]
    rows = [row(design, power, wave) for wave in "wvu" for design, power in (("FSB", 100), ("A", 120))]
    seas = {"w": "a swell", "v": "a chop", "u": "a wake"}
    swell, choppy, wake = sea_statements(rows, "FSB", seas, [*SWELL, *chop])
    assert swell.endswith("(against FSB: A +20.0 %); at 8000 N s/m FSB reaches 26 % of its own best, A 32 %.")
    assert choppy.endswith("(against FSB: A +20.0 %); at 8000 N s/m FSB reaches 50 % of its own best, A 100 %.")
    assert wake.endswith("(against FSB: A +20.0 %).")


@pytest.mark.parametrize(
    ("verdicts", "told"),
    [
        ([], None),
        (["ok"] * 2, None),
        (["doubt"], "1 point is in doubt: see"),
        (["doubt", "ok", "doubt"], "2 points are in doubt: see"),
        (["fail"], None),
        (["accepted", "doubt"], "1 further point is in doubt: see"),
        (["fail", "accepted", "fail"], None),
        (["fail", "accepted", "fail", "accepted"], "1 more check fails: see"),
        (["accepted"] * 5 + ["doubt"] * 2 + ["ok"], "2 more checks fail, 2 further points are in doubt: see"),
    ],
)
def test_the_head_of_a_page_counts_what_was_accepted_with_what_fails_and_apart_what_is_in_doubt(verdicts, told):
    """Three of those that fail are told by name; what is accepted is no less wrong."""
    checks = [{**CHECKS[0], "name": f"check {i}", "verdict": verdict} for i, verdict in enumerate(verdicts)]
    page = page_of(checks=checks)
    head = page.partition('<section id="doubt">')[0]
    words = " ".join(re.sub("<[^>]+>", "", head).split())
    said = re.findall(
        r"(?:\d+ more checks? fails?(?:, )?)?(?:\d+(?: further)? points? (?:is|are) in doubt)?: see", words
    )
    assert [one for one in said if one != ": see"] == ([told] if told else [])
    failing = [one["name"] for one in checks if one["verdict"] in ("fail", "accepted")]
    assert [one["name"] for one in checks if f"{one['name']}: 66.4" in words] == failing[:3]
    assert ("Checks that fail:" in words) == bool(failing)
    held = verdicts.count("ok")
    assert (f"{held} check{'s hold' * (held > 1) or ' holds'}" in page) == (held > 0)
    assert ("Nothing: every check holds." in page) == (held == len(verdicts))


def test_tables_of_a_page_are_those_of_its_data():
    """Each can be kept as a file, of the columns that hold anything; one whose rows are none is not there."""
    rows = [row("FSB", 100), row("A", 120), row("FSB", 0.0, "v") | {"capture_width": 1.5}]
    study = {**STUDY, "published": {"source": "x", "values": {"A": {"power_mean": 100.0}}}}
    seas = {"w": "a swell", "v": "a chop", "noise": "noise"}
    given = Report(
        study, seas, rows, [], response(A=0.2), "FSB", {}, {}, (), [BASE, LINE, SHORT], SWELL
    )  # fmt: skip
    page = render(given)
    found = {
        name: list(csv.reader(io.StringIO(urllib.parse.unquote(html.unescape(data)))))
        for name, data in re.findall(r'download="(\w+)\.csv" href="data:text/csv;charset=utf-8,([^"]*)"', page)
    }
    tables = {
        "equal_tuning": (TUNING, tuning_table(SWELL)), "given_damper": table(rows), "energy": table(rows, DETAILS),
        "irregular_seas": (STATISTICS, statistics_table(given.statistics)),
        "published": (PUBLISHED_HEAD, published_table(study, rows)),
    }  # fmt: skip
    for name, (head, body) in tables.items():
        assert found[name] == [list(head), *body], name
    bare = page_of(found=None)
    assert [name for name in tables if f'download="{name}.csv"' in bare] == ["given_damper", "energy"]


def test_sentences_of_all_seas_say_at_which_dampers_and_what_these_leave():
    """Of regular ones first, then of irregular ones; each with the shares of its own sea."""
    noise = [{**line, "sea": "noise", "share": share} for line, share in zip(SWELL, (0.5, 1.0), strict=True)]
    rows = [*BOTH, {**row("FSB", 100), "wave": "noise_s1"}]
    study = {**STUDY, "pto": {"tuning": "each"}}
    more = {"irregular": ["noise_s1"], "statistics": [BASE, LINE], "equal_tuning": [*SWELL, *noise]}
    seas = {"w": "a swell", "noise": "white noise", "noise_s1": "one of them"}
    page = render(Report(study, seas, rows, [], response(A=0.2), "FSB", {}, {}, **more))
    where = "In time, at their own best dampers, in"
    swell = (
        f"{where} a swell, A absorbs most: 120 W on average (against FSB: A +20.0 %); at 8000 N s/m FSB reaches 26 %"
    )
    white = f"{where} white noise, FSB absorbs 100 W, A absorbs 120 W (+20.0 %; +18.0 to +22.0 % of the sea, 95 %)"
    assert 0 < page.index(swell) < page.index(f"{white}; at 8000 N s/m FSB reaches 50 % of its own best, A 100 %.")
    assert "in one of them" not in page


@pytest.mark.parametrize(
    ("damping", "given"), [(10.0, True), (0.0, True), ({"FSB": 0.0, "A": 5.0}, True), (None, False)]
)
def test_a_damper_of_nothing_is_a_given_one_too(damping, given):
    page = page_of(
        study={**STUDY, "pto": {"damping": damping, "tuning": "fixed" if given else "each"}}, found=response(A=0.2),
        figures=("absorbed_power",),
    )  # fmt: skip
    assert ("Over the whole band, all at the given damper:" in page) == given
    assert ("right at the given damper" in page) == given


def test_bands_are_of_every_other_design_wherever_the_rigid_one_stands():
    absorbed = response(wins=0.3, loses=-0.2).absorbed_power
    for order in ([0, 1, 2], [1, 0, 2], [2, 1, 0]):
        said = band_statements(absorbed.isel(design=order), "FSB")
        names = [str(absorbed.design.values[i]) for i in order if i]
        assert [text.split()[:3] for text in said] == [
            [name, "absorbs", {"wins": "more", "loses": "less"}[name]] for name in names
        ]
        assert all(text.endswith(" than FSB.") for text in said)
