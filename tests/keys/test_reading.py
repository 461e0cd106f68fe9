"""Reading of files: every error is one line with file, line, key, value and need."""

import re
from functools import cache
from itertools import pairwise

import jsonschema
import pytest
import yaml
from conftest import EXAMPLE, SEED

from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.errors import ConfigError
from vsb.keys import reading
from vsb.keys.meanings import KEYS
from vsb.keys.schema import schema_of
from vsb.study import study as config
from vsb.study.body import BodyStudy
from vsb.study.campaign import Campaign
from vsb.study.design import Optimisation
from vsb.study.study import BuoyStudy
from vsb.tools.commands import HOME


def test_merged_mappings_are_not_duplicate_keys(written):
    """What stands in a mapping itself goes before what is merged into it."""
    text = "a: &a {radius: 2, mass: 1}\nb: &b {depth: 9}\nboth: {<<: *a, <<: *b, mass: 3}\n"
    assert reading.read_yaml(written(text), "a study file")["both"] == {"radius": 2, "mass": 3, "depth": 9}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("- a\n- b\n", "received a list, needs a mapping"),
        ("a: [1\n", "not valid YAML"),
        ("a: 1\na: 2\n", "key 'a' is given twice"),
        ("", "received nothing, needs a mapping with keys study, device, designs, waves; of all"),
        ("a: !!python/object:os.system 1\n", "not valid YAML .*could not determine a constructor"),
        ("study: alone\n", r"device: missing, but required: the spherical buoy, .* \(and 2 more\)"),
        pytest.param("? [a, b]\n: 1\n", "not valid YAML"),
        pytest.param("a: 2020-99-99\n", "not valid YAML"),
        pytest.param(
            "a: &a [0, 0, 0, 0]\n"
            + "".join(f"{k}: &{k} [{', '.join(9 * [f'*{j}'])}]\n" for j, k in pairwise("abcdefgh")),
            "aliases stand for more than 100000 values",
        ),
        pytest.param("study: me\ndevice: &d {radius: 2.0, more: *d}", "aliases stand for more than 100000 values"),
        pytest.param("a: " + 1000 * "[" + 1000 * "]", r"not valid YAML \(nested too deeply\); give a study file"),
    ],
)
def test_invalid_yaml(tmp_path, text, message):
    file = tmp_path / "odd.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=message) as error:
        config.load(file)
    assert "\n" not in str(error.value)


def test_lists_of_many_values_are_no_aliases(tmp_path, monkeypatch):
    monkeypatch.setattr(reading, "MOST_NODES", 100)
    file = tmp_path / "many.yaml"
    file.write_text("a: [" + "1, " * (reading.MOST_NODES + 1) + "]\nb: &b [2]\nc: *b\n")
    assert len(reading.read_yaml(file, "a study file")["a"]) == reading.MOST_NODES + 1


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("a: 1\nb: 2\na: 2\n", 3, "key 'a' is given twice, first in line 1"),
        ("a: !x 1\n", 1, "could not determine a constructor .*line 1, column 4"),
        ("a:\n  b: 1\n\tc: 2\n", 3, "a tab stands in column 1; write spaces there"),
        ("a: 1\nwaves: [{kind: still}\nb: 2\n", 2, r"the bracket \[ in column 8 is not closed"),
        ("a: {b: 1, c: 2\nd: 3\n", 1, r"the bracket \{ in column 4 is not closed"),
        ("a: {b: [1, 2}\n", 1, r"the bracket \[ of line 1 is closed by }"),
        ("a: {b: 1}}\n", 1, "the bracket } closes none that is open"),
        ("a: {b: 1 c: 2}\n", 1, "a comma is missing between two values, before column 11"),
        ("a:\n  b: 1\n   c: 2\n", 3, "indented by 3 spaces, the line above by 2"),
        ("a:\n    b: 1\n  c: 2\n", 3, "indented by 2 spaces, the line above by 4"),
        ("a:\n  b: 1\n  - 3\n", 3, "a list item, with a dash, stands among keys"),
        ("a:\n  b 1  # two\n  c: 2\n", 2, "a colon is missing behind the key; write b: and its value"),
        ("a: 1\nb\n  c: 2\n", 2, "a colon is missing behind the key; write b: and its value"),
        ("a:1\nb: 2\n", 1, "a space is missing behind the colon; write a: and its value"),
        ("a: b: c\n", 1, "two colons in one line"),
        ("a: 1\nb: 'c\nd: 1\n", 2, "the quotation mark ' in column 4 is not closed"),
        ("a: @b\n", 1, "a text cannot begin with @"),
        ("a: 1\nb: {[1, 2]}\n", 2, r"a list or a section stands where a key belongs; write {key: value}, or \[value"),
        ("a: *.csv\n", 1, r"a text cannot begin with \*"),
        ("a: 1\n---\nb: 1\n", 2, "--- begins a second document"),
        ("a: 1\nb: \x00\n", 2, "a character of number 0 is no text"),
    ],
)
def test_errors_of_yaml_are_plain_and_name_the_line_to_mend(tmp_path, text, line, words):
    """PyYAML names the line it could not go on in: a bracket or a colon is missing above it."""
    file = tmp_path / "odd.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=words) as error:
        config.load(file)
    assert str(error.value).startswith(f"{file}:{line}: not valid YAML (")


def test_a_file_of_another_encoding_is_named_as_such(tmp_path):
    file = tmp_path / "odd.yaml"
    file.write_bytes("a: 1\nb: \u00e9\n".encode("latin-1"))
    with pytest.raises(ConfigError, match=r"odd\.yaml:2: is no text in UTF-8"):
        config.load(file)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("pto: {damping 8000.0}", "unknown key; needs a colon and a space, damping: 8000.0"),
        ("pto: {damping:8000.0}", "unknown key; needs a colon and a space, damping: 8000.0"),
        ("pto: {damping = 8000.0}", "unknown key; needs a colon and a space, damping: 8000.0"),
        ("pto:\n  damping:8000.0", "pto: .* needs a mapping of keys and values: a space behind every colon"),
        ("-kind: still", "unknown key; a space is missing behind the dash"),
        ("\u00a0pto: 3", "unknown key; it holds blanks that are no spaces"),
    ],
)
def test_valid_yaml_that_was_meant_otherwise_is_told(tmp_path, text, words):
    file = tmp_path / "odd.yaml"
    file.write_text(f"study: a\n{text}\n")
    with pytest.raises(ConfigError) as error:
        config.load(file)
    assert any(re.search(words, line) for line in error.value.mistakes), error.value.mistakes


def test_missing_file():
    with pytest.raises(ConfigError, match=r"nowhere.yaml: cannot be read \(No such file"):
        config.load("nowhere.yaml")


WAVE = {"kind": "regular", "amplitude": 0.1}


@pytest.mark.parametrize(
    ("model", "name", "section", "value", "expected"),
    [
        (BuoyStudy, "seed", "waves", [{**WAVE, "period": -2}], "waves.0.period: received -2; needs"),
        (BuoyStudy, "seed", "waves", [WAVE], "waves.0.period: missing"),
        (BuoyStudy, "seed", "waves", [3], "waves.0: received 3; needs a mapping of keys and values"),
        (BuoyStudy, "seed", "waves", {"kind": "still"}, r"waves: received a mapping; needs a list of them"),
        (BuoyStudy, "seed", "designs", {"a": {0: None}}, r"designs.a.0: .*a number has a decimal point"),
        (
            BuoyStudy,
            "seed",
            "pto",
            {"port": {"between": [40]}},
            r"pto.port.between.1: received \[40\]; the list is too short",
        ),
        (
            BuoyStudy,
            "seed",
            "device",
            {"radius": 2, "damping": {"bta": 1}},
            r"device.damping.bta: .* did you mean beta\?",
        ),
        (BuoyStudy, "seed", "pto", {"port": {"line_to": [0, "a"]}}, "pto.port.line_to.1: received 'a'"),
        (
            BuoyStudy,
            "seed",
            "pto",
            {"ports": {"a": "heave", "b": "heave"}},
            "pto.ports: a: received the port of b once more",
        ),
        (BuoyStudy, "seed", "designs", {"B b": {}}, "designs.B b: received 'B b'; needs letters"),
        (Campaign, "year", "climate", {"spectra": 3}, "climate.spectra: received 3"),
        (Campaign, "year", "climate", {"scatr": "a"}, r"climate.scatr: .* did you mean scatter\?"),
        (BodyStudy, "barge", "simulation", {"rampTime": 9}, ".*did you mean window, which begins after the start-up"),
        (BodyStudy, "barge", "mooring", [1.0], ".*did you mean body.stiffness"),
        (BodyStudy, "barge", "body", {"file": {"mesh": 3}}, "body.file.body: missing"),
        (BodyStudy, "barge", "body", {"bemio": "a", "mass": {"Heave": [["x"]]}}, "body.mass.Heave.0.0: received 'x'"),
        (BodyStudy, "barge", "designs", {"A": {"dofs": "rgid"}}, r"designs.A.dofs: .* did you mean rigid\?"),
    ],
)
def test_keys_are_named_as_in_the_file(model, name, section, value, expected):
    raw = yaml.safe_load((HOME / "config" / f"{name}.yaml").read_text(encoding="utf-8")) | {section: value}
    with pytest.raises(ConfigError) as error:
        reading.validated(model, raw, "file.yaml")
    assert re.match(f"file.yaml: {expected}", error.value.mistakes[0])


MODELS = {"campaign": Campaign, "design": Optimisation, "study": BuoyStudy, "body-study": BodyStudy, "body": BodyFile}
FILES = {path: path.read_text() for path in EXAMPLE.parent.glob("*.yaml")}
CAMPAIGNS = sorted(path for path, text in FILES.items() if "\ncampaign:" in text)
DESIGNS = sorted(path for path, text in FILES.items() if "\ndesign:" in text)
STUDIES = sorted({path for path, text in FILES.items() if "\nstudy:" in text} - {*CAMPAIGNS, *DESIGNS})


def sections(schema):
    return {schema["title"]: schema, **schema["$defs"]}


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_every_key_has_a_meaning_and_a_valid_example(model):
    schema = schema_of(model)
    for name, section in sections(schema).items():
        for key, its in section["properties"].items():
            assert its.get("description"), f"say in vsb.keys.meanings what {name}.{key} means"
            checker = jsonschema.Draft202012Validator({**its, "$defs": schema["$defs"]})
            assert [error.message for example in its["examples"] for error in checker.iter_errors(example)] == []


def test_every_described_key_exists():
    known = {}
    for model in MODELS.values():
        known |= {name: set(section["properties"]) for name, section in sections(schema_of(model)).items()}
    described = {name: set(keys) for name, keys in KEYS.items()}
    left = {name: keys - known.get(name, set()) for name, keys in described.items() if name in known}
    assert not any(left.values()), left
    assert described.keys() - known.keys() <= {"ShellPort", "BetweenPort", "LinePort", "DofPort"}


def numbers(data):
    """Numbers as an editor reads them, where PyYAML sees text: 10.0e6."""
    if isinstance(data, dict):
        return {key: numbers(value) for key, value in data.items()}
    if isinstance(data, list):
        return [numbers(value) for value in data]
    return float(data) if isinstance(data, str) and data[0].isdigit() else data


@cache
def by_schema(model):
    """What checks files by the schema of a model, which is itself valid."""
    schema = schema_of(model)
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_shipped_studies_are_valid_by_the_schema(path):
    raw = numbers(yaml.safe_load(path.read_text()))
    by_schema(BodyStudy if "body" in raw else BuoyStudy).validate(raw)


@pytest.mark.parametrize("path", CAMPAIGNS, ids=lambda path: path.stem)
def test_shipped_campaigns_are_valid_by_the_schema(path):
    given = numbers(yaml.safe_load(path.read_text()))
    by_schema(Campaign).validate(given)
    by_schema(Campaign).validate({**given, "vary": schema_of(Campaign)["properties"]["vary"]["default"]})
    for wrong in (
        {"vary": {"device.mass": {"log": [1.0]}}},
        {"vary": {"device.mass": {"log": [1.0, 2.0, 3, 4]}}},
        {"tuning": ["best"]},
        {"years": 1},
    ):
        assert not by_schema(Campaign).is_valid(given | wrong)


@pytest.mark.parametrize("path", DESIGNS, ids=lambda path: path.stem)
def test_shipped_designs_are_valid_by_the_schema(path):
    given = numbers(yaml.safe_load(path.read_text()))
    by_schema(Optimisation).validate(given)
    for wrong in ({"variables": {"device.mass": [1.0]}}, {"variables": {}}, {"limits": {"beams": 1.0}}):
        assert not by_schema(Optimisation).is_valid(given | wrong)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("device", "radius"), 2000.0),
        (("device", "thicknes"), 0.01),
        (("modes", "basis"), "membran"),
        (("waves", 0, "kind"), "tsunami"),
        (("hydro", "tolerance"), 1.0),
    ],
)
def test_schema_refuses_what_a_study_refuses(place, value):
    raw = numbers(yaml.safe_load(SEED.read_text()))
    *outer, last = place
    here = raw
    for part in outer:
        here = here[part]
    here[last] = value
    assert not by_schema(BuoyStudy).is_valid(raw)
