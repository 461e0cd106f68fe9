"""Numbers of README and docs are those stored with the command they come from, and the command still gives them."""

import json

import pytest
import yaml
from conftest import HERE

from examples.published.__main__ import PICTURE, SENTENCES, VALUES, digest, pages
from examples.published.pages import MINUS, printed, unsourced, with_sentence
from examples.published.sources import SOURCES, stored
from vsb.errors import ConfigError

QUICK = [name for name, source in SOURCES.items() if source.quick]


def test_pages_hold_the_values_stored():
    """`python -m examples.published --stored` mends a number; changed words are changed in sentences.yaml, too."""
    for path, text in pages(stored(VALUES)).items():
        assert path.read_text(encoding="utf-8") == text, f"{path}: make published"


def test_every_result_on_a_page_is_sourced():
    """A percentage, a power or a CPU time in text that `make published` would not renew is found by its line."""
    values = stored(VALUES)
    for name, sentences in yaml.safe_load(SENTENCES.read_text(encoding="utf-8")).items():
        page = (HERE.parent / name).read_text(encoding="utf-8")
        assert unsourced(page, sentences or [], values) == [], f"{name}: sentences.yaml"


def test_result_outside_sentences_and_blocks_is_found():
    page = "It gains 3.1 %.\n\n<!-- once -->\n\n4 %\n\n<!-- end -->\n\nIt gains 5 to\n6 %, `7 %`, in waves of 8 s."
    assert unsourced(page, ["It gains {a|.1f} %."], {"a": 3.1}) == ["9: 5 to 6 %"]


def test_picture_shows_the_answer_stored():
    values = stored(VALUES)
    assert values["picture.answer"] == values["study.answer"]
    assert values["picture.sha256"] == digest(PICTURE)


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("published")


def compare_with_stored(name, folder):
    """Values anew are those stored, to what machines and versions of libraries change."""
    known = json.loads(VALUES.read_text(encoding="utf-8"))[name]["values"]
    found = SOURCES[name].compute(folder / name.partition(".")[0])
    assert known.keys() == found.keys()
    texts = {key: value for key, value in known.items() if isinstance(value, str)}
    assert texts == {key: found[key] for key in texts}
    numbers = {key: value for key, value in known.items() if key not in texts}
    assert {key: found[key] for key in numbers} == pytest.approx(numbers, rel=2e-3, abs=1e-3)


@pytest.mark.parametrize("name", QUICK)
def test_values_stored_are_those_of_quick_commands(name, folder, monkeypatch):
    monkeypatch.chdir(HERE.parent)
    compare_with_stored(name, folder)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in SOURCES if name not in QUICK])
def test_values_stored_are_those_of_commands(name, folder, monkeypatch):
    monkeypatch.chdir(HERE.parent)
    compare_with_stored(name, folder)


def test_number_is_put_into_its_sentence_over_the_end_of_a_line():
    page = f"One. It absorbs 3 %\nless, {MINUS}3.2 to {MINUS}2.9 %, in waves of 2 s. Two."
    sentence = "absorbs {-a|.1f} % less, {low|+.1f} to {high|+.1f} %, in waves of {period|.0f} s."
    values = {"a": -5.26, "low": -5.94, "high": 0.04, "period": 2.5}
    expected = f"One. It absorbs 5.3 %\nless, {MINUS}5.9 to 0.0 %, in waves of 2 s. Two."
    assert with_sentence(page, sentence, values) == expected


def test_sentence_that_stands_nowhere_or_twice_is_refused():
    for page in ("absorbs much", "absorbs 1 W, absorbs 2 W"):
        with pytest.raises(ConfigError, match="places of the sentence, needs one: absorbs"):
            with_sentence(page, "absorbs {a|g} W", {"a": 1.0})
    with pytest.raises(ConfigError, match="b}, which no source gives"):
        with_sentence("absorbs 1 W", "absorbs {b} W", {"a": 1.0})


def test_sign_that_its_words_deny_is_refused():
    """ "absorbs {-gain} % less" of a gain that has become positive."""
    assert printed(-0.3, ".1f", negated=True) == "0.3"
    with pytest.raises(ConfigError, match=r"received -0\.3, but the words around it give it a direction"):
        printed(0.3, ".1f", negated=True)
