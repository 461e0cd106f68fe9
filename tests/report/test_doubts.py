"""The head of a page: failures by name, the worst of each, and what to change first."""

import re
from pathlib import Path

from vsb.report.doubts import ADVICE, advice, warnings
from vsb.study.body import CHECKS
from vsb.study.keys import KEYS

BUCKLING = {
    "name": "buckling",
    "design": "",
    "wave": "",
    "value": 66.4,
    "limit": 1.0,
    "verdict": "fail",
    "explanation": "<p> & why",
}
HEAVE = {
    "name": "heave",
    "design": "A",
    "wave": "w",
    "value": 0.4,
    "limit": 0.3,
    "verdict": "doubt",
    "explanation": "large",
}


def test_failures_are_for_the_head_of_the_page():
    assert warnings([BUCKLING, HEAVE]) == [f"buckling: 66.4, limit 1 (<p> & why). Change first: {ADVICE['buckling']}"]
    (accepted,) = warnings([{**HEAVE, "verdict": "accepted"}])
    assert accepted.startswith("heave of A in w: 0.4, limit 0.3 (large)")
    assert warnings([{**HEAVE, "verdict": "ok"}]) == []


def test_of_one_name_the_worst_is_told_and_the_others_are_counted():
    bad, worse = ({**HEAVE, "verdict": "fail", "value": value} for value in (0.4, 0.9))
    (text,) = warnings([bad, worse, bad])
    assert text.startswith("heave of A in w: 0.9, limit 0.3 (large); so in 2 more. Change first: ")


def test_the_worst_is_the_one_furthest_beyond_its_own_limit():
    """A limit that depends on the sea or the design, or a limit of zero, of which no multiple is told."""
    large, far, none = (
        {**HEAVE, "verdict": "fail", "value": v, "limit": at} for v, at in ((0.9, 0.6), (0.4, 0.1), (3.0, 0))
    )
    assert warnings([large, far])[0].startswith("heave of A in w: 0.4, limit 0.1 (large); so in 1 more")
    assert warnings([large, none])[0].startswith("heave of A in w: 3, limit 0 (large); so in 1 more")


def test_what_holds_needs_no_advice_and_an_unknown_check_has_none():
    assert advice(BUCKLING) == ADVICE["buckling"]
    assert advice({**BUCKLING, "verdict": "ok"}) == ""
    assert advice({**BUCKLING, "name": "weather"}) == ""
    assert "Change" not in warnings([{**BUCKLING, "name": "weather"}])[0]


def test_every_check_of_the_ledgers_page_and_of_bodies_says_what_to_change_first():
    """But one, which is round-off."""
    page = (Path(__file__).parents[2] / "docs" / "ledger.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`[^|]+) \|", page, re.M)
    names = {name for row in rows for name in re.findall(r"`(\w+)`", row)} | set(CHECKS)
    assert names - set(ADVICE) == {"constraint_drift"}


def test_what_is_advised_is_a_key_of_a_study_and_tolerances_are_lowered():
    """What the automatic model leaves out is bounded by a tolerance of its own."""
    for name, text in ADVICE.items():
        for section, key in re.findall(r"\b([a-z]+)\.(\w+)", text):
            assert section in {**KEYS["Study"], **KEYS["BodyStudy"]}, name
            assert any(key in keys for keys in KEYS.values()), name
        assert all(how == "lower" for how in re.findall(r"(\w+) hydro\.\w*tolerance", text)), name
    assert {name for name, text in ADVICE.items() if "hydro.power_tolerance" in text} == {"left_out", "gain_error"}
    assert all(("waves" in ADVICE[name]) or name == "surge" for name in ("pitch", "rotation", "translation", "pause"))


def test_every_check_that_is_named_where_it_is_made_says_what_to_change_first():
    """But one of round-off, and one of a matrix that was mended and tells so."""
    files = (Path(__file__).parents[2] / "vsb").rglob("*.py")
    made = re.compile(r"\b(?:check_at_most|check_at_least|Check)\(\s*\"(\w+)\"")
    names = {name for path in files for name in made.findall(path.read_text(encoding="utf-8"))}
    assert {"spectrum_cut", "buckling", "heave"} <= names
    assert names - set(ADVICE) == {"constraint_drift", "hydrostatic_symmetry"}


def test_a_check_is_told_with_the_design_and_the_sea_it_is_of():
    for design, wave, subject in (("A", "w", "heave of A in w"), ("A", "", "heave of A"), ("", "w", "heave in w")):
        (text,) = warnings([{**HEAVE, "design": design, "wave": wave, "verdict": "fail"}])
        assert text.startswith(f"{subject}: 0.4, limit 0.3 (large). Change first: ")


def test_failures_of_several_names_stand_each_by_itself_in_their_order():
    failing = [{**HEAVE, "verdict": "accepted"}, BUCKLING, {**HEAVE, "verdict": "fail", "value": 0.35}]
    first, second = warnings(failing)
    assert first.startswith("heave of A in w: 0.4, limit 0.3 (large); so in 1 more. Change first: ")
    assert second.startswith("buckling: 66.4, limit 1 (")
    assert advice(failing[0]) == advice({**HEAVE}) == ADVICE["heave"]
