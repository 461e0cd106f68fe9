"""Reading of files: what is none is one line."""

import math
import re
from itertools import pairwise
from typing import Annotated, Literal

import pytest
import yaml
from invariance import SEED
from pydantic import Field, ValidationError, create_model
from study.test_sections import changed

from vsb.errors import ConfigError
from vsb.study import reading
from vsb.study import study as config
from vsb.study.body import BodyStudy
from vsb.study.campaign import Campaign
from vsb.study.quantities import Finite, Name, Section
from vsb.study.study import Study
from vsb.study.waves import Wave
from vsb.tools.shipped import HOME
from vsb.tools.words import shortened


def test_merged_mappings_are_no_key_given_twice(written):
    """What stands in a mapping itself goes before what is merged into it."""
    text = "a: &a {radius: 2, mass: 1}\nb: &b {depth: 9}\nboth: {<<: *a, <<: *b, mass: 3}\n"
    assert reading.read_yaml(written(text), "a study file")["both"] == {"radius": 2, "mass": 3, "depth": 9}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("- a\n- b\n", "received list, needs a mapping"),
        ("a: [1\n", "not valid YAML"),
        ("a: 1\na: 2\n", "key 'a' is given twice"),
        ("device: {radius: 2, mass: 1, radius: 3}\n", r"key 'radius' is given twice.* line 1, column 30"),
        ("", "received NoneType, needs a mapping with keys study, motion, device"),
        ("a: !!python/object:os.system 1\n", "not valid YAML .*could not determine a constructor"),
        ("study: alone\n", r"device: missing, but required: the spherical buoy, .* \(and 2 more\)"),
        pytest.param("? [a, b]\n: 1\n", "not valid YAML"),
        pytest.param("? {a: 1}\n: 1\n", "not valid YAML"),
        pytest.param("a: 2020-99-99\n", "not valid YAML"),
        pytest.param(
            "a: &a [0, 0, 0, 0]\n"
            + "".join(f"{k}: &{k} [{', '.join(9 * [f'*{j}'])}]\n" for j, k in pairwise("abcdefgh")),
            "aliases stand for more than 100000 values",
        ),
        pytest.param("study: me\ndevice: &d {radius: 2.0, more: *d}", "aliases stand for more than 100000 values"),
        pytest.param("a: " + 5000 * "[" + 5000 * "]", r"not valid YAML \(nested too deeply\); give a study file"),
    ],
)
def test_what_is_no_study_at_all(tmp_path, text, message):
    file = tmp_path / "odd.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=message) as error:
        config.load(file)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "line", "column"), [("a: 1\nb: 2\na: 2\n", 3, 1), ("a: 1\n\n  - : [\n", 3, 5), ("a: !x 1\n", 1, 4)]
)
def test_lines_are_counted_from_one_wherever_they_are_told(tmp_path, text, line, column):
    file = tmp_path / "odd.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError) as error:
        config.load(file)
    assert str(error.value).startswith(f"{file}:{line}: not valid YAML (")
    assert f", line {line}, column {column}" in str(error.value)


def test_missing_file():
    with pytest.raises(ConfigError, match=r"nowhere.yaml: cannot be read \(No such file"):
        config.load("nowhere.yaml")


def test_file_that_is_no_text(tmp_path):
    file = tmp_path / "binary.yaml"
    file.write_bytes(b"\xff\xfe\x00a")
    with pytest.raises(ConfigError, match=r"binary.yaml: not valid YAML \('utf-8' codec can't decode"):
        config.load(file)


def test_folder_in_place_of_a_file(tmp_path):
    with pytest.raises(ConfigError, match=r"cannot be read \(Is a directory\); give the path of a study file"):
        config.load(tmp_path)


@pytest.mark.parametrize("raw", [None, [], "seed", 3.0])
def test_data_that_are_no_mapping_name_what_was_received(raw):
    with pytest.raises(ConfigError, match=f"here: received {type(raw).__name__}, needs a mapping"):
        config.parse(raw, source="here")


def test_a_misspelt_key_is_named_before_the_key_it_left_out(seed):
    data = seed.model_dump()
    data["device"]["youngs_modulus"] = data["device"].pop("young_modulus")
    with pytest.raises(ConfigError, match=r"device.youngs_modulus: received 10000000.0; unknown key; .*\(and 1 more\)"):
        config.parse(data)


def test_line_break_in_a_key_stays_in_one_line():
    with pytest.raises(ConfigError) as error:
        config.parse(changed(("designs",), {"A\n": {}}))
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("count", "last"), [(20, "unknown key"), (25, "and 5 more mistakes like these")])
def test_twenty_mistakes_are_told_line_by_line(count, last):
    raw = changed(("device", "thickness"), 0.01)
    raw["device"] |= {f"wrong{i:02}": 1.0 for i in range(count)}
    with pytest.raises(ConfigError) as error:
        config.parse(raw)
    assert len(error.value.mistakes) == min(count, 20) + (count > 20)
    assert last in error.value.mistakes[-1]
    assert str(error.value) == f"{error.value.mistakes[0]} (and {count - 1} more)"


def test_first_of_several_errors_is_told_and_the_rest_counted():
    raw = changed(("device", "thickness"), -1.0)
    raw["pto"]["damping"] = -1.0
    with pytest.raises(ConfigError, match=r"device.thickness: received -1.0; .* \(and 1 more\)$"):
        config.parse(raw)


WRONG = [
    None,
    True,
    "x" * 70,
    "!",
    -1,
    0,
    1e9,
    2.5,
    float("nan"),
    float("inf"),
    [],
    [[]],
    {},
    {"x": 1},
    10**30,
    b"\xff",
]


def wronged(raw, value):
    """The same file with a value in place of each of its values, kinds of seas left."""
    if isinstance(raw, dict):
        return {key: wronged(inner, value) for key, inner in raw.items() if key != "kind"} | (
            {"kind": raw["kind"]} if "kind" in raw else {}
        )
    return [wronged(inner, value) for inner in raw] if isinstance(raw, list) and raw else value


@pytest.mark.parametrize("value", WRONG, ids=lambda value: shortened(repr(value)))
@pytest.mark.parametrize(
    ("model", "name"), [(Study, "seed"), (Study, "irregular"), (Campaign, "year"), (BodyStudy, "hinged_barge")]
)
def test_mistakes_are_told_in_words_of_this_project(monkeypatch, model, name, value):
    """Whatever stands where: no word of the library that reads the values, and no mistake that has no words."""
    monkeypatch.setattr(reading, "MOST_TOLD", 1000)
    raw = wronged(yaml.safe_load((HOME / "config" / f"{name}.yaml").read_text(encoding="utf-8")), value)
    with pytest.raises(ConfigError) as error:
        reading.validated(model, raw, "file.yaml")
    found = [
        text for text in error.value.mistakes if re.search("should|Input|pydantic|valid|needs another value", text)
    ]
    assert not found


TOLD = {  # pydantic's name: kind of the value, the value, what is needed
    "bool_parsing": (bool, "x", "true or false"), "bool_type": (bool, [], "true or false"),
    "dict_type": (dict[str, int], 1, "a mapping of keys and values"),
    "finite_number": (Finite, math.inf, "a finite number"), "float_parsing": (float, "x", "a number"),
    "float_type": (float, [], "a number"),
    "greater_than": (Annotated[float, Field(gt=2.5)], 2.5, "a number above 2.5"),
    "greater_than_equal": (Annotated[float, Field(ge=2.5)], 2.0, "a number of at least 2.5"),
    "int_from_float": (int, 2.5, "a whole number"), "int_parsing": (int, "x", "a whole number"),
    "int_parsing_size": (int, 4301 * "1", "a whole number of fewer digits"), "int_type": (int, [], "a whole number"),
    "less_than": (Annotated[float, Field(lt=2.5)], 2.5, "a number below 2.5"),
    "less_than_equal": (Annotated[float, Field(le=2.5)], 3.0, "a number of at most 2.5"),
    "list_type": (list[int], 1, "a list"),
    "literal_error": (Literal["linear", "log"], "linaer", "'linear' or 'log'; did you mean linear?"),
    "model_attributes_type": (Wave, 1, "a mapping of keys and values"),
    "model_type": (Section, 1, "a mapping of keys and values"),
    "string_pattern_mismatch": (Name, "2 b", "letters, digits and _, first a letter"),
    "string_too_long": (Annotated[str, Field(max_length=3)], "four", "at most 3 characters"),
    "string_type": (str, 1, "a word or a text"), "string_unicode": (str, b"\xff", "a word or a text"),
    "too_long": (Annotated[list[int], Field(max_length=1)], [1, 2], "at most 1 item(s), not 2"),
    "too_short": (Annotated[list[int], Field(min_length=2)], [1], "at least 2 item(s), not 1"),
    "tuple_type": (tuple[int, ...], 1, "a list"),
}  # fmt: skip


def test_no_mistake_is_without_a_sentence_or_a_case():
    assert reading._WORDS.keys() == TOLD.keys()


@pytest.mark.parametrize("kind", TOLD)
def test_every_mistake_has_its_sentence(kind):
    annotation, value, needed = TOLD[kind]
    model = create_model("Given", key=(annotation, ...))
    with pytest.raises(ValidationError) as found:
        model.model_validate({"key": value})
    assert [error["type"] for error in found.value.errors()] == [kind]
    with pytest.raises(ConfigError) as told:
        reading.validated(model, {"key": value}, "a.yaml")
    assert str(told.value) == f"a.yaml: key: received {shortened(repr(value))}; needs {needed}"


def test_one_degree_of_freedom_is_a_name():
    with pytest.raises(ConfigError, match=r"pto.port: dof \[\]: needs the name of a degree of freedom"):
        config.parse(changed(("pto",), {"port": {"dof": []}}))


WAVE = {"kind": "regular", "amplitude": 0.1}


@pytest.mark.parametrize(
    ("model", "name", "section", "value", "told"),
    [
        (Study, "seed", "waves", [{**WAVE, "period": -2}], "waves.0.period: received -2; needs"),
        (Study, "seed", "waves", [{**WAVE, "perod": 2}], r"waves.0.perod: .* did you mean period\?"),
        (Study, "seed", "waves", [WAVE], "waves.0.period: missing"),
        (Study, "seed", "waves", [{**WAVE, "period": 2, "tp": 2}], "waves.0.tp: .* unknown key; remove it"),
        (Study, "seed", "waves", [3], "waves.0: received 3; needs a mapping of keys and values"),
        (Study, "seed", "waves", [{"kind": "irregular"}], r"waves.0: kind 'irregular': .* did you mean jonswap\?"),
        (Study, "seed", "waves", [{"kind": "regular", "height": 1}], r"waves.0.height: .* mean amplitude, half the "),
        (Study, "seed", "waves", [{"kind": "jonswap", "height": 1}], r"waves.0.height: .* did you mean hs\?"),
        (
            Study,
            "seed",
            "waves",
            [{"kind": "jonswap", "hs": "1,5", "tp": 5}],
            "waves.0.hs: .* decimal point, not a comma",
        ),
        (Study, "seed", "hydro", {"model": "nonlinear"}, r"hydro.model: .* did you mean body_exact\?"),
        (Study, "seed", "device", {"r" * 500: 1}, r"device.r{73}\.\.\. \(507 characters\): received 1; unknown key"),
        (Study, "seed", "pto", {"port": "heav"}, "pto.port: received 'heav'; needs 'heave'"),
        (Study, "seed", "pto", {"port": {"between": [0, -1]}}, "pto.port.between.1: received -1"),
        (
            Study,
            "seed",
            "pto",
            {"port": {"between": [40]}},
            r"pto.port.between.1: received \[40\]; missing, but required",
        ),
        (Study, "seed", "device", {"radius": 2, "damping": {"bta": 1}}, r"device.damping.bta: .* did you mean beta\?"),
        (Study, "seed", "pto", {"port": {"colatitude": -1}}, "pto.port.colatitude: received -1"),
        (Study, "seed", "pto", {"port": {"line_to": [0, "a"]}}, "pto.port.line_to.1: received 'a'"),
        (Study, "seed", "pto", {"port": {"line_from": [0, 1]}}, "pto.port.line_to: missing"),
        (Study, "seed", "pto", {"port": {"dofs": {"a": "b"}}}, "pto.port.dofs.a: received 'b'"),
        (Study, "seed", "designs", {"A": {"clamp": "x"}}, "designs.A.clamp: received 'x'"),
        (Study, "seed", "designs", {"B b": {}}, "designs.B b: received 'B b'; needs letters"),
        (Study, "seed", "mooring", [0, 0, "a", 0, 0, 0], "mooring.2: received 'a'"),
        (Campaign, "year", "climate", {"spectra": 3}, "climate.spectra: received 3"),
        (Campaign, "year", "climate", {"spectra": "a", "gamma": 3}, "climate.gamma: .* unknown key; remove it"),
        (Campaign, "year", "climate", {"scatr": "a"}, r"climate.scatr: .* did you mean scatter\?"),
        (Campaign, "year", "climate", {"scatter": "a", "gamma": -1}, "climate.gamma: received -1"),
        (BodyStudy, "barge", "body", {"file": {"mesh": 3}}, "body.file.body: missing"),
        (BodyStudy, "barge", "body", {"bemio": "a", "mass": {"Heave": [["x"]]}}, "body.mass.Heave.0.0: received 'x'"),
        (BodyStudy, "barge", "body", {"bemio": "a", "mass": 3}, "body.mass: received 3; needs a list"),
        (BodyStudy, "barge", "designs", {"A": {"dofs": "rgid"}}, r"designs.A.dofs: .* did you mean rigid\?"),
        (BodyStudy, "barge", "designs", {"A": {"dofs": ["a", 3]}}, "designs.A.dofs.1: received 3"),
        (BodyStudy, "barge", "pto", {"port": {"dofs": {"a": "b"}}}, "pto.port.dofs.a: received 'b'"),
    ],
)
def test_keys_are_told_as_the_file_has_them(model, name, section, value, told):
    """Whichever of several kinds a value was taken for, its name stands in no file."""
    raw = yaml.safe_load((HOME / "config" / f"{name}.yaml").read_text(encoding="utf-8")) | {section: value}
    with pytest.raises(ConfigError) as error:
        reading.validated(model, raw, "file.yaml")
    assert re.match(f"file.yaml: {told}", error.value.mistakes[0])


@pytest.mark.parametrize(
    ("waves", "told"),
    [
        ([], ["waves: received []; needs at least 1 item(s), not 0"]),
        ([{"kind": "nope"}], ["waves.0: kind 'nope': needs one of 'still', 'regular', 'jonswap', "]),
        ([{"kind": "regular"}], ["waves.0.amplitude: missing", "waves.0.period: missing"]),
    ],
)
def test_a_list_whose_items_are_wrong_is_not_told_to_be_too_short_as_well(waves, told):
    raw = changed(("waves",), waves)
    with pytest.raises(ConfigError) as caught:
        config.parse(raw, source="a.yaml")
    assert len(caught.value.mistakes) == len(told)
    for line, begins in zip(caught.value.mistakes, told, strict=True):
        assert line.startswith(f"a.yaml: {begins}")


def test_a_number_nobody_can_print_is_refused_in_any_yaml_file(tmp_path):
    """Of a profile, too, which no model looks at: with its line and key."""
    path = tmp_path / "config.yaml"
    path.write_text(f"jobs: 2\nset:\n  mem: 0x{'f' * 20_000}\n")
    with pytest.raises(ConfigError, match=r"config.yaml:3: set.mem: received a number of too many digits"):
        reading.read_yaml(path, "a profile")


def test_a_key_without_a_value_is_told_at_its_own_line(written):
    text = yaml.safe_dump(
        SEED | {"device": {**SEED["device"], "poisson_ratio": None}, "published": None}, sort_keys=False
    )
    line = text.splitlines().index("  poisson_ratio: null") + 1
    with pytest.raises(ConfigError, match=rf"given.txt:{line}: device.poisson_ratio: received None; needs a number"):
        config.load(written(text))


@pytest.mark.parametrize("text", ["b: {<<: *a, mass: 3, mass: 4}", "b: {mass: 3, <<: *a, mass: 4}"])
def test_a_key_given_twice_beside_a_merged_mapping_is_given_twice(written, text):
    with pytest.raises(ConfigError, match=r"given.txt:2: not valid YAML \(key 'mass' is given twice, line 2"):
        reading.read_yaml(written(f"a: &a {{radius: 2}}\n{text}\n"), "a study file")


@pytest.mark.parametrize(
    ("text", "nodes"),
    [("a", 1), ("[a, b]", 3), ("{a: 1, b: 2}", 5), ("a: &a {b: 1}\nc: [*a, *a]\n", 13), ("{? [a, b] : 1}", 5)],
)
def test_values_are_counted_with_their_keys_and_aliases_written_out(written, monkeypatch, text, nodes):
    """As many as there may be are read, one more are refused."""
    monkeypatch.setattr(reading, "MOST_NODES", nodes)
    loads = "? [" not in text  # a list is no key
    if loads:
        assert reading.read_yaml(written(text), "a study file") == yaml.safe_load(text)
    monkeypatch.setattr(reading, "MOST_NODES", nodes - 1)
    with pytest.raises(ConfigError, match=rf"its aliases stand for more than {nodes - 1} values"):
        reading.read_yaml(written(text), "a study file")


def test_a_mistake_of_yaml_is_told_with_what_it_stands_in(written):
    """Where it was met, and where what it belongs to began."""
    with pytest.raises(ConfigError) as error:
        reading.read_yaml(written("a: 1\nb:\n  - [1,\n    2\nc: 3\n"), "a study file")
    told = str(error.value)
    assert ":5: not valid YAML (" in told
    assert ", line 5, column 2, while parsing a flow sequence, line 3, column 5)" in told


BEYOND = 10**4300


@pytest.mark.parametrize(
    ("raw", "place"),
    [
        ({"a": BEYOND}, "a"), ({"a": -BEYOND}, "a"), ({BEYOND: 1}, "a key"), ({-BEYOND: 1}, "a key"),
        ({"a": {"b": [1, {"c": -BEYOND}]}}, "a.b.1.c"), ({"a": (1, (2, BEYOND))}, "a.1.1"), ({"a": [{BEYOND: 1}]}, "a.0.a key"),
    ],
    ids=lambda value: value if isinstance(value, str) else "raw",
)  # fmt: skip
def test_what_python_does_not_print_is_refused_wherever_it_stands(raw, place):
    """Of either sign, as a key, in lists and tuples; a number that is printed is any other mistake."""
    with pytest.raises(ConfigError) as error:
        reading.validated(Study, raw, "here")
    assert str(error.value) == f"here: {place}: received a number of too many digits; needs at most 4300"
    printed = BEYOND - 1
    with pytest.raises(ConfigError, match=r"^here: \w+: received -?9{70,}\.\.\. \(430[01] characters\); unknown key"):
        reading.validated(Study, {"a": -printed, "b": printed}, "here")


def test_a_check_of_all_the_study_is_told_at_the_line_of_what_it_names(written):
    """Of the second sea, not the first nor the list."""
    waves = [{"kind": "regular", "amplitude": 0.1, "period": period} for period in (3.0, 0.3)]
    text = yaml.safe_dump(SEED | {"waves": waves}, sort_keys=False)
    line = [i for i, one in enumerate(text.splitlines(), 1) if one.startswith("- ")][1]
    with pytest.raises(
        ConfigError, match=rf"given.txt:{line}: study: waves.1 regular_A0.1_T0.3: the wave is too short"
    ):
        config.load(written(text))


@pytest.mark.parametrize(
    ("kind", "meant"), [("regulr", "regular"), ("pierson_moskovitz", "pierson_moskowitz"), ("tsunami", "")]
)
def test_a_kind_that_was_probably_meant_is_told(kind, meant):
    with pytest.raises(ConfigError) as error:
        config.parse(changed(("waves",), [{"kind": kind, "amplitude": 0.1, "period": 3.0}]))
    asked = f"; did you mean {meant}?" if meant else ""
    assert str(error.value).endswith(f"kind '{kind}': needs one of 'still', 'regular', 'jonswap', 'pierson_moskowitz', "
                                     f"'white_noise'{asked}")  # fmt: skip


def test_without_its_schema_the_first_mistake_is_a_misspelt_key_and_how_many_there_are():
    """What a stage tells of a specification: nothing is said of what a missing key means."""
    model = create_model("Given", __base__=Section, key=(float, ...), other=(float, ...))
    for raw, told in (
        ({"kye": 1.0}, "kye: received 1.0; unknown key; remove it or correct its spelling (and 2 more)"),
        ({"key": 1.0}, "other: missing, but required"),
    ):
        with pytest.raises(ValidationError) as error:
            model.model_validate(raw)
        assert reading.one_line(error.value, raw) == told


@pytest.mark.parametrize(
    ("place", "line"),
    [
        ((), None), (("x",), None), (("a",), 1), (("a", "x"), 1), (("b",), 2), (("b", "c"), 3), (("b", "c", 0), 4),
        (("b", "c", 1), 5), (("b", "c", 1, "f"), 6), (("b", "c", 2), 3), (("b", "c", "0"), 3), (("b", "x"), 2),
        (("b", "b", "c"), 3), (("b", "x", "c", 1, "x"), 5), (("x", "a"), 1), (("f",), 7),
    ],
    ids=str,
)  # fmt: skip
def test_the_line_of_a_place_is_that_of_the_innermost_part_there_is(written, place, line):
    """What is not there is passed over: of a section a check names again, too."""
    raw = reading.read_yaml(written("a: 1\nb:\n  c:\n    - d: 2\n    - e: 3\n      f: 4\nf: 5\n"), "a study file")
    assert raw.line(place) == line


def test_mistakes_of_several_checks_across_sections_are_a_line_each():
    """A buoy that sinks in waves too short for what is solved."""
    raw = changed(("device", "mass"), 1e5)
    raw["waves"] = [{"kind": "regular", "amplitude": 0.1, "period": 0.3}]
    with pytest.raises(ConfigError) as error:
        config.parse(raw, source="a.yaml")
    first, second = error.value.mistakes
    assert first.startswith("a.yaml: study: device.mass 100000 kg: the buoy would sink; needs less than ")
    assert second.startswith("a.yaml: study: waves.0 regular_A0.1_T0.3: the wave is too short ")
    assert str(error.value) == f"{first} (and 1 more)"
    assert "\n" not in f"{first}{second}"
