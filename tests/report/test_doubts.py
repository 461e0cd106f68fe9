"""Failed checks at the head of a page, with advice."""

import re
from pathlib import Path

from vsb.keys.meanings import KEYS
from vsb.report.doubts import ADVICE, no_answer, reasons, warnings

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


def test_failed_checks_head_the_page():
    assert warnings([BUCKLING, HEAVE]) == [f"buckling: 66.4, limit 1 (<p> & why). Change first: {ADVICE['buckling']}"]
    (accepted,) = warnings([{**HEAVE, "verdict": "accepted"}])
    assert accepted.startswith("heave of A in w: 0.4, limit 0.3 (large)")
    assert warnings([{**HEAVE, "verdict": "ok"}]) == []


def test_what_was_tried_for_a_shell_replaces_general_advice():
    """A page that says "raise the pressure" of a wall that no pressure carries sends its reader in circles."""
    tried = {**BUCKLING, "advice": "no pressure carries this wall; from 90 mm it stands (tried)"}
    assert warnings([tried])[0].endswith(f"Change first: {tried['advice']}")
    both = no_answer([tried, {**tried, "name": "computed_buckling"}])
    assert both.endswith(f"Change first: {tried['advice']}."), "said once"


def test_a_reason_has_the_largest_of_its_values():
    (text,) = reasons([{"name": "strain", "value": value} for value in (0.11, 0.13, 0.12)])
    assert text.startswith("the strain reaches 13 %")


def test_advice_names_keys_that_exist():
    for name, text in ADVICE.items():
        for section, key in re.findall(r"\b([a-z]+)\.(\w+)", text):
            assert section in {**KEYS["Study"], **KEYS["BodyStudy"]}, name
            assert any(key in keys for keys in KEYS.values()), name
        assert "body_exact" not in ADVICE["linearity"], "a check of body-exact runs alone"
    assert all(how == "lower" for how in re.findall(r"(\w+) hydro\.\w*tolerance", text)), name
    assert {name for name, text in ADVICE.items() if "hydro.power_tolerance" in text} == {"left_out", "gain_error"}
    assert all(
        ("waves" in ADVICE[name]) or name == "surge" for name in ("pitch", "rotation", "translation", "latching_time")
    )


def test_every_check_has_advice():
    """Except one of round-off, and one of a matrix that is repaired."""
    files = (Path(__file__).parents[2] / "vsb").rglob("*.py")
    made = re.compile(r"\b(?:check_at_most|check_at_least|Check)\(\s*\"(\w+)\"")
    names = {name for path in files for name in made.findall(path.read_text(encoding="utf-8"))}
    assert {"spectrum_cut", "buckling", "heave"} <= names
    assert names - set(ADVICE) == {"constraint_drift", "hydrostatic_symmetry"}
