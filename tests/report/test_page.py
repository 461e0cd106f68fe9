"""The report page of a study: statements, tables and their data, figures and numbers in HTML."""

import csv
import html
import io
import re
import urllib.parse

import jinja2
import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from report.test_answer import BUCKLING, HEAVE, SWELL

from vsb.report import page as pages
from vsb.report.answer import tuning_head, tuning_table
from vsb.report.page import (
    DETAILS,
    PUBLISHED_HEAD,
    STATISTICS,
    Report,
    band_statements,
    captioned,
    irregular_statements,
    measures,
    published_table,
    render,
    statistics_table,
    table,
    winning_bands,
)
from vsb.tools.variables import FORCE

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
        **dict.fromkeys(("power_low", "power_high", "record_power_mean"), str(power)),
        **{"record_start": "40", "record_end": "60"},
        **values,
    }


STUDY = {"study": "s", "published": None, "pto": {"damping": 10.0}, "hydro": {"tolerance": 1e-3}}
CHECKS = [BUCKLING | {"unit": "-"}, HEAVE | {"unit": "-"}]


def test_waves_in_which_a_design_gains_and_loses_are_told_apart():
    """10 % more below 2 rad/s, 20 % less from there on."""
    (text,) = band_statements(response(A=np.where(OMEGA < 2.0, 0.1, -0.2)).absorbed_power, "FSB")
    more, less = text.split("; ")
    assert re.fullmatch(r"A absorbs more in waves of 3\.16 to 12\.57 s \(up to 10 % at .* s\)", more)
    assert re.fullmatch(r"less in waves of \d\.\d\d to 3\.14 s \(up to 20 % at .* s\) than FSB\.", less)


@given(st.lists(st.floats(-50.0, 50.0), min_size=1, max_size=40))
def test_bands_hold_all_gains_above_the_threshold_and_each_its_largest(gain):
    gain, omega = np.array(gain), np.arange(len(gain)) / 10
    bands = winning_bands(omega, gain, 2.0)
    held = [(omega >= band.start) & (omega <= band.end) for band in bands]
    assert [(band.gain, gain[list(omega).index(band.at)]) for band in bands] == [(gain[k].max(),) * 2 for k in held]
    np.testing.assert_array_equal(np.any(held, axis=0) if held else gain > 2.0, gain > 2.0)


def test_published_values_beside_computed_ones():
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


def test_page_is_self_contained_and_escaped():
    page = render(
        Report(STUDY, {"w": "a swell"}, [row("FSB", 100), row("A", 120)], CHECKS, response(A=0.2), "FSB",
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
    assert page.index("Over the whole band, each design at its optimal damping") < page.rindex("A absorbs most")
    assert page.rindex("A absorbs most") < page.index("Over the whole band, all at the given damping")
    assert page.index("A: the same within 1 %") < page.index("A absorbs more in waves of")
    assert "1 further check is in doubt" in page
    contents = page[page.index("<nav") : page.index("</nav>")]
    assert re.findall('href="#(.*?)">(.*?)<', contents)[-1] == ("making", "How it was made")
    assert all(f'<section id="{name}">' in page for name in re.findall('href="#(.*?)"', contents))


LINE = {
    "design": "A", "sea": "noise", "amplitudes": "random", "realisations": "4", "batches": "40", "power_mean": "120",
    "power_low": "110", "power_high": "130", "power_linear": "125", "power_linear_record": "121", "gain_percent": "20", "gain_low": "18.04", "gain_high": "21.96", "record_power_mean": "119", "record_gain_percent": "19",
}  # fmt: skip
BASE = {
    **LINE,
    "design": "FSB",
    "power_mean": "100",
    "power_low": "98",
    "power_high": "103",
    "gain_percent": "0",
    "gain_low": "0",
    "gain_high": "0",
}
SHORT = {**LINE, "power_low": "", "power_high": "", "gain_low": "", "gain_high": ""}


def test_irregular_seas_are_answered_with_the_interval_of_the_gain():
    (text,) = irregular_statements([BASE, LINE], "FSB", {"noise": "white noise"})
    assert text == (
        "At the given damping, in white noise, FSB absorbs 100 (98 to 103) W, A absorbs 120 W (+20.0 %; +18.0 to +22.0 %)."
    )
    assert irregular_statements([SHORT], "FSB", {"noise": "it"}) == [
        "At the given damping, in it, A absorbs 120 W (+20.0 %)."
    ]


def test_tables_can_be_downloaded_as_they_stand():
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
        "equal_tuning": (tuning_head("N s/m"), tuning_table(SWELL)), "given_damper": table(rows, measures(FORCE, "buoy")), "energy": table(rows, DETAILS),
        "irregular_seas": (STATISTICS, statistics_table(given.statistics)),
        "published": (PUBLISHED_HEAD, published_table(study, rows)),
    }  # fmt: skip
    for name, (head, body) in tables.items():
        assert found[name] == [list(head), *body], name
    bare = render(Report(STUDY, {"w": "a swell"}, rows[:2], [], None, "FSB", {}, {}))
    assert [name for name in tables if f'download="{name}.csv"' in bare] == ["given_damper", "energy"]


def test_table_can_be_downloaded():
    body = [['a "b", c', "1 %"], ["<i>", "2"]]
    link = pages.csv_link("t", ["x", "y"], body)
    data = re.search(r'href="data:text/csv;charset=utf-8,([^"]*)"', link)[1]
    assert list(csv.reader(io.StringIO(urllib.parse.unquote(data)))) == [["x", "y"], *body]


def test_sea_is_named_in_a_table_of_several_only():
    assert pages.filled(["design", "sea"], [["A", "T3"], ["B", "T3"]]) == (["design"], [["A"], ["B"]])
    assert pages.filled(["design", "sea"], [["A", "T3"], ["A", "T4"]])[0] == ["design", "sea"]


def test_missing_value_of_a_template_raises():
    with pytest.raises(jinja2.UndefinedError, match="is undefined"):
        pages.page("campaign.html.j2")


def test_negative_numbers_have_one_minus_sign():
    """Numbers of text alone: no name, date, exponent, script, figure, file or study is changed."""
    text = '<p title="-1">-6.3 % (-.5 to -1e-05), 2026-11-29, VSWEC-2, up-1, -</p><pre>x: -0.8</pre><svg>-1</svg>'
    signs = text.replace(">-6.3 % (-.5 to -1e", ">\N{MINUS SIGN}6.3 % (\N{MINUS SIGN}.5 to \N{MINUS SIGN}1e")
    assert pages.with_minus_signs(text) == signs


def test_a_figure_too_large_for_the_page_takes_no_room_of_others():
    figures = {"map": f"<svg>{' ' * pages.INLINE}</svg>", "spectra": "<svg></svg>"}
    ((one, other),) = (group["figures"] for group in captioned(figures, {"map": "", "spectra": ""}))
    assert (one["svg"], other["svg"]) == ("", "<svg></svg>")
