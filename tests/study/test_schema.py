"""Every key is described, and the schema accepts what a study accepts."""

import jsonschema
import pytest
import yaml
from conftest import EXAMPLE, SEED

from vsb.study.body import BodyFile, BodyStudy
from vsb.study.campaign import Campaign
from vsb.study.keys import KEYS
from vsb.study.reading import hint, schema_of
from vsb.study.study import Study

MODELS = {"campaign": Campaign, "study": Study, "body-study": BodyStudy, "body": BodyFile}
FILES = {path: path.read_text() for path in EXAMPLE.parent.glob("*.yaml")}
CAMPAIGNS = sorted(path for path, text in FILES.items() if "\ncampaign:" in text)
STUDIES = sorted(path for path, text in FILES.items() if "\nstudy:" in text and "\ncampaign:" not in text)


def sections(schema):
    return {schema["title"]: schema, **schema["$defs"]}


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_every_key_has_a_meaning_and_a_valid_example(model):
    schema = schema_of(model)
    for name, section in sections(schema).items():
        for key, its in section["properties"].items():
            assert its.get("description"), f"say in vsb.study.keys what {name}.{key} means"
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


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_shipped_studies_are_valid_by_the_schema(path):
    raw = numbers(yaml.safe_load(path.read_text()))
    jsonschema.validate(raw, schema_of(BodyStudy if "body" in raw else Study))


@pytest.mark.parametrize("path", CAMPAIGNS, ids=lambda path: path.stem)
def test_shipped_campaigns_are_valid_by_the_schema(path):
    given = numbers(yaml.safe_load(path.read_text()))
    jsonschema.validate(given, schema_of(Campaign))
    jsonschema.validate({**given, "vary": schema_of(Campaign)["properties"]["vary"]["default"]}, schema_of(Campaign))
    for wrong in (
        {"vary": {"device.mass": {"log": [1.0]}}},
        {"vary": {"device.mass": {"log": [1.0, 2.0, 3, 4]}}},
        {"tuning": ["best"]},
        {"years": 1},
    ):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(given | wrong, schema_of(Campaign))


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
    assert not jsonschema.Draft202012Validator(schema_of(Study)).is_valid(raw)


@pytest.mark.parametrize(
    ("place", "key", "meant"),
    [
        (("device",), "youngs_modulus", "young_modulus"),
        ((), "radius", "device.radius"),
        (("device", "damping"), "bta", "beta"),
        (("designs", "VSWEC"), "clmp", "clamp"),
        (("device",), "colour", ""),
        (("waves", 0), "hs", ""),
        (("pto", "port"), "direction", "waves.direction"),
    ],
)
def test_suggestions_for_misspelt_keys(place, key, meant):
    assert hint(schema_of(Study), place, key) == meant
