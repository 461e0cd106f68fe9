"""Keys that are all described, a schema that takes what a study takes, and hints."""

import json
import math

import jsonschema
import pytest
import yaml
from conftest import EXAMPLE, SEED
from pydantic import ValidationError
from study.test_ids import STUDIES as STUDIES_OF_EVERY_KIND

from vsb.study.body import BodyStudy
from vsb.study.body_file import BodyFile
from vsb.study.campaign import Campaign
from vsb.study.keys import KEYS
from vsb.study.quantities import Section
from vsb.study.reading import read_yaml
from vsb.study.schema import _with_bounds, dotted, hint, keys_at, nearest, schema_of
from vsb.study.study import Study, parse

MODELS = {"campaign": Campaign, "study": Study, "body-study": BodyStudy, "body": BodyFile}
FILES = {path: path.read_text() for path in EXAMPLE.parent.glob("*.yaml")}
CAMPAIGNS = sorted(path for path, text in FILES.items() if "\ncampaign:" in text)
STUDIES = sorted(path for path, text in FILES.items() if "\nstudy:" in text and "\ncampaign:" not in text)


def sections(schema):
    return {schema["title"]: schema, **schema["$defs"]}


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_every_key_says_what_it_means_and_gives_an_example_it_takes(model):
    schema = schema_of(model)
    for name, section in sections(schema).items():
        for key, its in section["properties"].items():
            assert its.get("description"), f"say in vsb.study.keys what {name}.{key} means"
            checker = jsonschema.Draft202012Validator({**its, "$defs": schema["$defs"]})
            assert [error.message for example in its["examples"] for error in checker.iter_errors(example)] == []


def test_no_key_is_described_that_is_none():
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


@pytest.mark.parametrize("name", STUDIES_OF_EVERY_KIND)
def test_what_a_study_takes_the_schema_takes(name):
    """Every kind of plan, with every section given."""
    raw = numbers(yaml.safe_load(SEED.read_text()))
    for section, given in STUDIES_OF_EVERY_KIND[name].items():
        raw[section] = {**raw.get(section, {}), **given} if isinstance(given, dict) else given
    if "shape" in raw["device"]:
        raw["designs"] = {"VSWEC": {}}
    parse(raw)
    jsonschema.validate(raw, schema_of(Study))


@pytest.mark.parametrize(("given", "valid"), [([[0, 1], [1, 0]], True), ("hull.csv", True), (None, True), (3.0, False)])
def test_points_of_a_profile_stand_in_the_study_or_in_a_file(given, valid):
    profile = schema_of(Study)["$defs"]["Shape"]["properties"]["profile"]
    assert jsonschema.Draft202012Validator(profile).is_valid(given) == valid


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
        (("device", "radius"), 0.005),
        (("device", "internal_pressure"), -2e8),
        (("device", "thicknes"), 0.01),
        (("designs", "VSWEC", "clamp"), 181),
        (("modes", "basis"), "membran"),
        (("waves", 0, "kind"), "tsunami"),
        (("hydro", "tolerance"), 1.0),
    ],
)
def test_the_schema_refuses_what_a_study_refuses(place, value):
    raw = numbers(yaml.safe_load(SEED.read_text()))
    *outer, last = place
    here = raw
    for part in outer:
        here = here[part]
    here[last] = value
    assert not jsonschema.Draft202012Validator(schema_of(Study)).is_valid(raw)


def test_it_is_json_of_its_dialect():
    for model in MODELS.values():
        schema = json.loads(json.dumps(schema_of(model), allow_nan=False))
        jsonschema.Draft202012Validator.check_schema(schema)
    assert schema["$defs"]["Water"]["properties"]["depth"]["default"] == ".inf"


def test_keys_of_a_place():
    schema = schema_of(Study)
    assert set(keys_at(schema, ("device", "damping"))) == {"alpha", "beta"}
    assert set(keys_at(schema, ("designs", "any"))) == {"flexible", "clamp"}
    assert set(keys_at(schema, ("waves", 3, "regular"))) == {"kind", "amplitude", "period", "direction"}
    assert {"hs", "amplitude", "band"} < set(keys_at(schema, ("waves", 3)))
    for place in (
        ("device", "model-of-one-kind", "damping"),
        ("device", "damping", "tuple[float, ...]"),
        ("device", 3, "damping"),
    ):
        assert keys_at(schema, place) == keys_at(schema, ("device", "damping"))
    assert {"device.gas.adiabatic_index", "waves.gamma", "study"} < set(dotted(schema))


@pytest.mark.parametrize(
    ("place", "key", "meant"),
    [
        (("device",), "youngs_modulus", "young_modulus"),
        (("waves", 0, "jonswap"), "Hs", "hs"),
        ((), "radius", "device.radius"),
        ((), "beta", "device.damping.beta"),
        (("device", "damping"), "bta", "beta"),
        (("device", "gas"), "beta", "device.damping.beta"),
        (("designs", "VSWEC"), "clmp", "clamp"),
        (("device",), "colour", ""),
        (("waves", 0), "hs", ""),  # which it has of another kind
        (("waves", 0), "density", "device.density"),
        (("pto", "port"), "colatitude", ""),
        (("pto", "port"), "direction", "waves.direction"),
    ],
)
def test_what_was_probably_meant(place, key, meant):
    assert hint(schema_of(Study), place, key) == meant


def test_nothing_is_near_to_nothing():
    assert nearest("x", []) == ""


def test_what_is_near_is_told_in_its_own_capitals():
    assert nearest("vswec9", ["FSB", "VSWEC90"]) == "VSWEC90"


def test_lines_of_a_file(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("a: 1\nb:\n  - c: 2\n  - {d: [3,\n    4]}\n")
    found = read_yaml(path, "any")
    places = [("a",), ("b",), ("b", 0, "c"), ("b", 1, "d", 1), ("b", "kind", 1, "x"), ("b", 7), ("no",), ()]
    assert [found.line(place) for place in places] == [1, 2, 3, 5, 4, 2, None, None]


def test_a_file_of_many_aliases_knows_its_lines(tmp_path):
    """Some ten thousand items; of a hundred thousand it is refused."""
    lines = ["a0: &a0 [x, x]"] + [f"a{i}: &a{i} [{', '.join(10 * [f'*a{i - 1}'])}]" for i in range(1, 5)]
    (tmp_path / "laughs.yaml").write_text("\n".join(lines))
    line = read_yaml(tmp_path / "laughs.yaml", "any").line(("a4", 0, 0, 0))
    assert line == 2


LIMITS = {
    "BetweenPort.between": "[0, 180]",
    "Body.length": "(0, inf)",
    "BodyFile.lid": "0..64",
    "BodyFile.omega": "[1e-3, 1e3]",
    "BodyFile.tolerance": "[1e-5, 0.1]",
    "BodyFile.wave_direction": "[-360, 360]",
    "BodyHydro.omega_max": "(0, inf)",
    "BodyHydro.tolerance": "[1e-6, 0.1]",
    "Capsule.length": "[0, 1e4]",
    "Constrained.seconds": "(0, 86400]",
    "Constrained.seed": "0..4294967295",
    "Design.clamp": "[0, 180]",
    "Device.ballast_inertia": "[0, 1e18]",
    "Device.ballast_yaw_inertia": "[0, 1e18]",
    "Device.centre_of_mass": "[-1e3, 1e3]",
    "Device.density": "[0.1, 2.5e4]",
    "Device.internal_pressure": "[-1e8, 1e8]",
    "Device.mass": "(0, inf)",
    "Device.poisson_ratio": "[-0.99, 0.5)",
    "Device.radius": "[0.01, 1e3]",
    "Device.thickness": "(0, inf)",
    "Device.young_modulus": "[1, 1e16]",
    "Gas.adiabatic_index": "[1, 2]",
    "Gas.atmospheric_pressure": "[1, 1e7]",
    "Hydro.omega": "(0, inf)",
    "Hydro.omega_max": "(0, inf)",
    "Hydro.power_tolerance": "(0, 0.5]",
    "Hydro.pressure": "[0, 1e8]",
    "Hydro.rows": "6..160",
    "Hydro.tolerance": "[1e-6, 0.1]",
    "Jonswap.gamma": "[1, 10]",
    "Jonswap.tp": "[1e-3, 1e7]",
    "Modes.degree": "0..90",
    "Modes.order": "1..8",
    "Modes.tolerance": "[1e-4, 0.1]",
    "Plate.area": "(0, inf)",
    "Plate.coefficient": "[0, 100]",
    "Pto.damping": "[0, 1e12]",
    "Pto.efficiency": "(0, 1]",
    "Pto.force_limit": "(0, inf]",
    "Pto.stiffness": "[-1e12, 1e12]",
    "Pto.stroke_limit": "(0, inf]",
    "RayleighDamping.alpha": "[0, 1e4]",
    "RayleighDamping.beta": "[0, 100]",
    "RegularWave.amplitude": "[1e-9, 100]",
    "RegularWave.period": "[1e-3, 1e7]",
    "Scatter.gamma": "[1, 10]",
    "ShellPort.colatitude": "[0, 180]",
    "Simulation.duration": "[1e-3, 2e5]",
    "Simulation.initial_position": "[-1e4, 1e4]",
    "Simulation.initial_velocity": "[-1e3, 1e3]",
    "Simulation.tolerance": "[1e-12, 0.1]",
    "Spheroid.height": "[1e-3, 1e4]",
    "Vane.lever": "(0, inf)",
    "Verify.seas": "4..1000",
    "Water.density": "[1, 2e4]",
    "Water.depth": "(0, 2e4]",
    "Water.gravity": "[0.01, 300]",
    "WhiteNoise.direction": "[-360, 360]",
    "WhiteNoise.hs": "[1e-9, 100]",
    "WhiteNoise.realisations": "1..1000",
}
"""What each number of a study may be: a study that is read today is read tomorrow."""
LISTED = ("BetweenPort.between", "BodyFile.omega", "BodyFile.wave_direction", "Hydro.omega")


def known_sections(kind=Section):
    return {kind.__name__: kind} | {k: v for below in kind.__subclasses__() for k, v in known_sections(below).items()}


def at_its_ends(interval):
    """Last numbers within, and first ones beyond; of infinity nothing is beyond."""
    if ".." in interval:
        low, high = map(int, interval.split(".."))
        return (low, high), (low - 1, high + 1)
    low, high = map(float, interval[1:-1].split(","))
    inner, outer = math.nextafter(low, math.inf), math.nextafter(low, -math.inf)
    lowest = (low, outer) if interval[0] == "[" else (inner, low)
    inner, outer = math.nextafter(high, -math.inf), math.nextafter(high, math.inf)
    highest = (high, outer if outer != high else math.nan) if interval[-1] == "]" else (inner, high)
    return tuple(zip(lowest, highest, strict=True))


def is_refused(section, name, value):
    """Whether a key is refused for its value, whatever else is missing."""
    try:
        known_sections()[section].model_validate({name: value})
    except ValidationError as error:
        return any(each["loc"][0] == name for each in error.errors() if each["loc"])
    return False


@pytest.mark.parametrize("key", LIMITS)
def test_a_number_is_taken_up_to_its_limits_and_not_beyond(key):
    within, beyond = at_its_ends(LIMITS[key])
    around = (lambda x: (x, 45.0)[: 1 + (key == "BetweenPort.between")]) if key in LISTED else float
    assert [is_refused(*key.split("."), around(value)) for value in within] == [False, False]
    assert [is_refused(*key.split("."), around(value)) for value in beyond] == [True, True]


def test_every_number_with_a_limit_stands_among_these():
    limits = {"minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"}
    limited = {
        name
        for model in MODELS.values()
        for section in sections(schema_of(model)).values()
        for name, its in section["properties"].items()
        if limits & {word for part in [its, *its.get("anyOf", [])] for word in part}
    }
    assert limited - {"draft"} <= {key.partition(".")[2] for key in LIMITS}  # which is made a mass before


@pytest.mark.parametrize(
    ("changes", "valid"),
    [({"mass": 1e4}, True), ({"draft": 1.5}, True), ({}, True), ({"draft": 0.0}, False), ({"draft": "deep"}, False)],
)
def test_an_editor_takes_a_mass_a_draft_or_neither(changes, valid):
    raw = numbers(yaml.safe_load(SEED.read_text()))
    raw["device"] = {key: value for key, value in raw["device"].items() if key != "mass"} | changes
    assert jsonschema.Draft202012Validator(schema_of(Study)).is_valid(raw) == valid


def test_bounds_are_told_in_the_words_of_json_of_numbers_alone():
    """Of whole ones and others, at any depth, in lists too; infinity as YAML writes it; a key named so keeps its name."""

    number, whole = {"type": "number", "gt": 0, "le": math.inf}, {"type": "integer", "ge": 1, "lt": 9, "default": -1}
    given = {"le": {"anyOf": [number, {"type": "array", "items": whole}], "gt": 5, "default": -math.inf}}
    number = {"type": "number", "exclusiveMinimum": 0, "maximum": ".inf"}
    whole = {"type": "integer", "minimum": 1, "exclusiveMaximum": 9, "default": -1}
    expected = {"le": {"anyOf": [number, {"type": "array", "items": whole}], "gt": 5, "default": -math.inf}}
    assert _with_bounds(given) == expected


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_keys_are_explained_with_their_units_under_their_own_names(model):
    """No unit of what has none; no title, which editors would show in place of a key's name."""
    schema = schema_of(model)
    for name, section in sections(schema).items():
        for key, its in section["properties"].items():
            assert "title" not in its
            said = KEYS[name][key]
            assert its["description"] == (f"{said.meaning} [{said.unit}]" if said.unit else said.meaning)
            assert its["examples"] == [yaml.safe_load(said.example)]
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"


@pytest.mark.parametrize(("value", "valid"), [("auto", True), (5.0, True), (0, False), ("wide", False), (None, False)])
def test_an_editor_takes_a_band_or_leaves_it_to_the_size(value, valid):
    place = schema_of(Study)["$defs"]["Hydro"]["properties"]["omega_max"]
    assert jsonschema.Draft202012Validator(place).is_valid(value) is valid
    assert place["default"] == "auto"


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_the_default_of_a_section_is_that_of_its_keys(model):
    """Auto where a key's is auto; the default is one the section itself takes."""
    schema, told = schema_of(model), 0
    for section in sections(schema).values():
        for its in section["properties"].values():
            if "$ref" in its and isinstance(its.get("default"), dict):
                keys = schema["$defs"][its["$ref"].rpartition("/")[2]]["properties"]
                for key, value in its["default"].items():
                    assert value == keys[key].get("default", value)
                    told += value == "auto"
    if model is Study:
        assert schema["properties"]["hydro"]["default"]["omega_max"] == "auto"
        assert told >= 3
