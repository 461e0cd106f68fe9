"""Reading of YAML files into checked values: one line for every mistake, with the file's line it stands in."""

import difflib
import math
import re
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import yaml
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from vsb.errors import ConfigError
from vsb.study.keys import KEYS
from vsb.tools.bounded import LARGEST_STUDY, read_bounded
from vsb.tools.words import LONGEST, shortened

Schema = dict[str, Any]
DIALECT = "https://json-schema.org/draft/2020-12/schema"
_BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
"""JSON's words for the bounds of numbers."""


@cache
def schema_of(model: type[BaseModel]) -> Schema:
    """Return the JSON schema of a model, not to be changed: types, ranges, defaults, choices, what every key means."""
    found: Schema = _with_bounds(model.model_json_schema())
    for name, section in {model.__name__: found, **found.get("$defs", {})}.items():
        for key, place in section.get("properties", {}).items():
            place.pop("title", None)
            if said := KEYS.get(name, {}).get(key):
                unit = f" [{said.unit}]" if said.unit else ""
                place |= {"description": said.meaning + unit, "examples": [yaml.safe_load(said.example)]}
            if isinstance(default := place.get("default"), dict):
                default |= _described_defaults(found, place, default)
    return {"$schema": DIALECT, **found}


def _described_defaults(schema: Schema, place: Schema, default: Schema) -> Schema:
    """Defaults of a section by its keys, auto as it is written."""
    said = {
        key: its["default"]
        for form in _forms(schema, place)
        for key, its in form["properties"].items()
        if "default" in its
    }
    return {key: said.get(key, value) for key, value in default.items()}


def _with_bounds(node: Any) -> Any:
    """The same with bounds in JSON's words, where a number is checked after it was read, and infinity in YAML's."""
    if isinstance(node, list):
        return [_with_bounds(item) for item in node]
    if not isinstance(node, dict):
        return ".inf" if node == math.inf else node
    number = node.get("type") in ("number", "integer")
    return {(_BOUNDS.get(key, key) if number else key): _with_bounds(value) for key, value in node.items()}


def keys_at(schema: Schema, place: Sequence[str | int]) -> dict[str, Schema]:
    """Return the keys a mapping may have, by name: at a place such as ("waves", 0); names of kinds may be among it."""
    nodes = [schema]
    for part in place:
        nodes = [child for node in nodes for child in _schemas_below(schema, node, part)] or nodes
    forms = [form for node in nodes for form in _forms(schema, node)]
    return {key: its for form in forms for key, its in form.get("properties", {}).items()}


def _forms(schema: Schema, node: Schema) -> Iterator[Schema]:
    """What a node may be."""
    if "$ref" in node:
        node = schema["$defs"][node["$ref"].rpartition("/")[2]]
    several = node.get("anyOf") or node.get("oneOf")
    if several:
        for one in several:
            yield from _forms(schema, one)
    else:
        yield node


def _schemas_below(schema: Schema, node: Schema, part: str | int) -> Iterator[Schema]:
    """What stands below a node: a key, any key, an item, or one of several kinds."""
    if isinstance(part, str) and part in (kinds := node.get("discriminator", {}).get("mapping", {})):
        yield {"$ref": kinds[part]}
        return
    for form in _forms(schema, node):
        if isinstance(part, str) and part in (known := form.get("properties", {})):
            yield known[part]
        else:
            yield from _unnamed(form)


def _unnamed(form: Schema) -> list[Schema]:
    """What stands in a list, or in a mapping of names of one's own."""
    inner = [form.get("items"), form.get("additionalProperties"), *form.get("patternProperties", {}).values()]
    return [one for one in inner if isinstance(one, dict)]


def range_at(schema: Schema, place: Sequence[str]) -> tuple[float, float]:
    """Return the least and the largest number a key may have, at a place such as ("device", "mass")."""
    forms = list(_forms(schema, keys_at(schema, place[:-1])[place[-1]]))
    while forms and forms[0].get("type") != "number":
        forms += [inner for one in _unnamed(forms.pop(0)) for inner in _forms(schema, one)]
    ends = [[end for name, end in forms[0].items() if name.lower().endswith(of)] for of in ("minimum", "maximum")]
    return max([-math.inf, *ends[0]]), min([math.inf, *ends[1]])


def dotted(schema: Schema, node: Schema | None = None, prefix: str = "") -> Iterator[str]:
    """Yield the names of all keys, those of sections within sections with dots; lists and own names are left out."""
    for form in _forms(schema, node or schema):
        for key, its in form.get("properties", {}).items():
            yield prefix + key
            yield from dotted(schema, its, f"{prefix}{key}.")
        for inner in _unnamed(form):
            yield from dotted(schema, inner, prefix)


SAME = {
    "nonlinear": {"body_exact": "body_exact"},
    "irregular": {"jonswap": "jonswap"},
    "bretschneider": {"pierson_moskowitz": "pierson_moskowitz"},
    "lambda": {"peakedness": "peakedness"},
    "height": {"amplitude": "amplitude, half the height", "hs": "hs"},
    "h": {"amplitude": "amplitude, half the height", "hs": "hs"},
    "t": {"period": "period", "tp": "tp"},
    "hm0": {"hs": "hs"},
    "significant_wave_height": {"hs": "hs"},
    "peak_period": {"tp": "tp"},
    "te": {"tp": "tp, the peak period"},
    "fp": {"tp": "tp = 1/fp"},
    "nowave": {"still": "still"},
    "pm": {"pierson_moskowitz": "pierson_moskowitz"},
    "elevationimport": {"record": "record"},
    "spectrumimport": {"spectrum": "spectrum"},
    "endtime": {"duration": "duration"},
    "ramptime": {"window": "window, which begins after the start-up"},
    "dt": {"tolerance": "tolerance, from which the steps follow"},
    "c": {"damping": "damping"},
    "k": {"stiffness": "stiffness"},
    "hardstops": {"stroke_limit": "stroke_limit"},
    "equilibrium": {"displaced": "displaced"},
    "inertia": {"radii_of_gyration": "radii_of_gyration", "mass": "mass, with rotations in kg m^2"},
    "mooring": {"body": "body.stiffness"},
    "h5": {"bemio": "bemio"},
    "period": {"omega": "omega = 2 pi/period"},
    "omega": {"period": "period = 2 pi/omega"},
    "freq": {"omega": "omega = 2 pi freq"},
    "wavelength": {"omega": "omega, which follows from the wavelength"},
    "heading": {"wave_direction": "wave_direction, in degrees", "direction": "direction, in degrees"},
    "lid_mesh": {"lid": "lid"},
    "dofs": {"modes": "modes"},
    "water_depth": {"water": "water.depth"},
    "rho": {"water": "water.density", "density": "density"},
    "g": {"water": "water.gravity", "gravity": "gravity"},
    "diameter": {"radius": "radius, half the diameter"},
}
"""Words of other programs, in small letters -> words here that mean the same -> how they are suggested."""


def same(word: str, words: Iterable[str]) -> str:
    """Return the suggestion for a word of other programs; empty if there is none."""
    known = set(words)
    return next((text for one, text in SAME.get(word.lower(), {}).items() if one in known), "")


def hint(schema: Schema, place: Sequence[str | int], key: str) -> str:
    """Return the key that was probably meant: of the same section, or as it is named in another; empty if none is."""
    others = sorted(keys_at(schema, place).keys() - {key})  # a key of another kind may be called as this one
    if near := nearest(key, others):
        return near
    section = "".join(f"{part}." for part in place if isinstance(part, str))
    alike = (name for name in dotted(schema) if name.rpartition(".")[2] == key and name != key)
    return next((name for name in alike if not section or not name.startswith(section)), "")


def nearest(word: str, words: Iterable[str]) -> str:
    """Return the word that means the same as another, or looks most like it, capitals or not; empty if none does."""
    small = {one.lower(): one for one in words}
    if meant := same(word, small.values()):
        return meant
    return next((small[one] for one in difflib.get_close_matches(word.lower(), list(small), n=1)), "")


Model = TypeVar("Model", bound=BaseModel)


class _UniqueKeyLoader(yaml.SafeLoader):
    """YAML loader that refuses a key given twice, and knows the lines of the keys of what it read."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        """Build a mapping; a repeated key is an error."""
        seen: set[object] = set()
        for key_node, _ in node.value:
            if key_node.tag == "tag:yaml.org,2002:merge":
                continue
            key = self.construct_object(key_node, deep=deep)
            if key in seen:
                raise yaml.MarkedYAMLError(
                    problem=f"key {shortened(repr(key))} is given twice", problem_mark=key_node.start_mark
                )
            seen.add(key)
        return super().construct_mapping(node, deep)

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        """Build an integer that Python can print, since error messages quote it."""
        if len(node.value) > LONGEST_INTEGER:
            problem = f"an integer of {len(node.value)} characters"
            raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark)
        return int(super().construct_yaml_int(node))


_UniqueKeyLoader.add_constructor("tag:yaml.org,2002:int", _UniqueKeyLoader.construct_yaml_int)


Place = Sequence[str | int]
"""Keys and indices from the top of a file to something in it."""
LONGEST_INTEGER = 1000
"""Characters of an integer in a file."""
MOST_REPORTED = 20
"""Most errors of one file that are listed."""
MOST_NODES = 100_000
"""Values of a file with its aliases written out; a few lines of aliases within aliases stand for any number."""


class Located(dict[str, Any]):
    """The mapping a YAML file holds, which knows the lines its parts stand in."""

    def __init__(self, data: dict[str, Any], node: yaml.MappingNode) -> None:
        super().__init__(data)
        self.node = node

    def line(self, place: Place) -> int | None:
        """Return the line, from 1, of the innermost part of a place there is; None of one outside."""
        node: yaml.Node = self.node
        found = None
        for part in place:
            below = _below(node, part)
            if below is not None:
                key, node = below
                found = key.start_mark.line + 1
        return found


def _below(node: yaml.Node, part: str | int) -> tuple[yaml.Node, yaml.Node] | None:
    """The nodes of a key, or an item, and of its value."""
    if isinstance(node, yaml.MappingNode):
        return next((pair for pair in node.value if pair[0].value == part), None)
    if isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
        return node.value[part], node.value[part]
    return None


def read_yaml(path: str | Path, wanted: str) -> object:
    """Return what a YAML file holds; a mapping at its top knows the lines of the file.

    Raises `ConfigError` if it cannot be read, is not YAML, gives a key twice, or a number of more digits than can be
    printed.

    Parameters
    ----------
    wanted : str
        What kind of file is needed, in words.
    """
    try:
        data = _loaded(read_bounded(path, LARGEST_STUDY).decode())
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}); give the path of {wanted}") from None
    except RecursionError:
        raise ConfigError(f"{path}: not valid YAML (nested too deeply); give {wanted}") from None
    except (yaml.YAMLError, TypeError, ValueError) as error:
        line, words = _yaml_words(error)
        raise ConfigError(f"{path}{line}: not valid YAML ({words})") from None
    return data


def _loaded(text: str) -> object:
    """What a YAML text holds."""
    loader = _UniqueKeyLoader(text)
    try:
        node = loader.get_single_node()
        if node is not None and _written_out(node, {}) > MOST_NODES:
            raise ValueError(f"its aliases stand for more than {MOST_NODES} values")
        data = None if node is None else loader.construct_document(node)
        return Located(data, node) if isinstance(node, yaml.MappingNode) and isinstance(data, dict) else data
    finally:
        loader.dispose()


def _written_out(node: yaml.Node, known: dict[int, float]) -> float:
    """How many values a node stands for with its aliases written out; infinitely many of one that holds itself."""
    if id(node) not in known:
        known[id(node)] = float("inf")
        parts = (part for pair in node.value for part in (pair if isinstance(pair, tuple) else (pair,)))
        known[id(node)] = 1 + sum(_written_out(part, known) for part in parts if isinstance(part, yaml.Node))
    return known[id(node)]


def _yaml_words(error: Exception) -> tuple[str, str]:
    """The line an error of YAML is in, as it follows a file's name, and what it says."""
    if not isinstance(error, yaml.MarkedYAMLError) or error.problem_mark is None:
        return "", " ".join(str(error).split())
    said = [(error.problem, error.problem_mark), (error.context, error.context_mark)]
    words = [f"{text}, line {mark.line + 1}, column {mark.column + 1}" for text, mark in said if text and mark]
    return f":{error.problem_mark.line + 1}", " ".join(", ".join(words).split())


def validated(model: type[Model], raw: object, source: str) -> Model:
    """Return a model from nested mappings.

    Raises `ConfigError`: one line with the source, its line if it is a YAML file, the key, the value received and the
    value needed; all mistakes there are as `mistakes`.
    """
    if not isinstance(raw, dict):
        raise ConfigError(
            f"{source}: received {type(raw).__name__}, needs a mapping with keys {', '.join(model.model_fields)}"
        )
    try:
        return model.model_validate(raw)
    except ValidationError as error:
        found = _ordered(error)
        lines = [
            f"{source}{_line_of(one, raw)}: {_message(one, error.title, raw, model)}" for one in found[:MOST_REPORTED]
        ]
        rest = len(found) - len(lines)
        last = [f"{source}: and {rest} more mistakes like these"] if rest else []
        raise ConfigError(lines[0] + _more(found), [*lines, *last]) from None


def one_line(error: ValidationError, raw: object) -> str:
    """Return the first error of a validation in one line, and how many more: a misspelt key before what it left out."""
    found = _ordered(error)
    return _message(found[0], error.title, raw) + _more(found)


def lines_of(error: ValidationError, raw: object, model: type[BaseModel]) -> list[str]:
    """Return all errors of a validation, a line each."""
    return [_message(one, error.title, raw, model) for one in _ordered(error)]


def _ordered(error: ValidationError) -> list[ErrorDetails]:
    """All errors, misspelt keys first; a check across sections may report several, a line each."""
    found = [cast(ErrorDetails, {**one, "msg": text}) for one in error.errors() for text in _lines(one)]
    inner = {one["loc"][:n] for one in found for n in range(len(one["loc"]))}
    found = [one for one in found if one["type"] != "too_short" or one["loc"] not in inner]  # not of wrong items
    return sorted(found, key=lambda one: one["type"] != "extra_forbidden")


def _lines(error: ErrorDetails) -> list[str]:
    """Lines of an error; only messages of this project have several."""
    text = error["msg"].removeprefix("Value error, ")
    return text.splitlines() if error["type"] == "value_error" else [text]


def _more(found: Sequence[object]) -> str:
    """How many there are beside the first."""
    return f" (and {len(found) - 1} more)" if len(found) > 1 else ""


def _line_of(error: ErrorDetails, raw: dict[str, Any]) -> str:
    """The line a mistake stands in, as it follows a file's name; a check of a whole section begins with its key."""
    if not isinstance(raw, Located):
        return ""
    words = re.match(r"\w+(\.\w+)*", error["msg"]) if error["type"] == "value_error" else None
    named = [int(part) if part.isdigit() else part for part in words[0].split(".")] if words else []
    line = raw.line([*_written(error, raw), *named])
    return "" if line is None else f":{line}"


def _written(error: ErrorDetails, raw: object) -> Place:
    """Keys of a mistake as the file has them: without the names pydantic adds of the kind it took a value for."""
    *outer, last = error["loc"] or ("",)
    place: list[str | int] = []
    for part in outer:
        if (inner := _inside(raw, part)) is not None:
            place, raw = [*place, part], inner[0]
    return [*place, last] if error["type"] == "missing" or _inside(raw, last) is not None else place


def _inside(raw: object, part: str | int) -> tuple[object] | None:
    """What is at a key of a mapping, or an index of a list; None where there is no such."""
    if isinstance(raw, Mapping):
        return (raw[part],) if part in raw else None
    return (raw[part],) if isinstance(raw, list | tuple) and isinstance(part, int) and part < len(raw) else None


def _message(error: ErrorDetails, title: str, raw: object, model: type[BaseModel] | None = None) -> str:
    """An error in one line: key, value received, what is needed."""
    place = _written(error, raw)
    key = shortened(".".join(map(str, place))) or _in_words(title)
    received = "" if isinstance(error["input"], dict | BaseModel) else f" received {shortened(repr(error['input']))};"
    return " ".join(f"{key}:{received} {_needed(error, place, schema_of(model) if model else {})}".split())


def _in_words(title: str) -> str:
    """Name of a kind of file as people write it: body study for BodyStudy."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", title).lower()


_WORDS = {
    "bool_parsing": "needs true or false",
    "bool_type": "needs true or false",
    "dict_type": "needs a mapping of keys and values",
    "finite_number": "needs a finite number",
    "float_parsing": "needs a number",
    "float_type": "needs a number",
    "greater_than": "needs a number above {gt:g}",
    "greater_than_equal": "needs a number of at least {ge:g}",
    "int_from_float": "needs a whole number",
    "int_parsing": "needs a whole number",
    "int_parsing_size": "needs a whole number of fewer digits",
    "int_type": "needs a whole number",
    "less_than": "needs a number below {lt:g}",
    "less_than_equal": "needs a number of at most {le:g}",
    "list_type": "needs a list",
    "literal_error": "needs {expected}",
    "model_attributes_type": "needs a mapping of keys and values",
    "model_type": "needs a mapping of keys and values",
    "string_pattern_mismatch": "needs letters, digits and _, first a letter",
    "string_too_long": "needs at most {max_length} characters",
    "string_type": "needs a word or a text",
    "string_unicode": "needs a word or a text",
    "too_long": "needs at most {max_length} item(s), not {actual_length}",
    "too_short": "needs at least {min_length} item(s), not {actual_length}",
    "tuple_type": "needs a list",
}
"""Mistakes in words of this project, by pydantic's name."""


def _needed(error: ErrorDetails, place: Place, schema: dict[str, Any]) -> str:
    """What is needed in place of what was received, and what was probably meant."""
    kind, ctx = error["type"], error.get("ctx", {})
    if kind == "extra_forbidden":
        key, within = str(place[-1]), error["loc"][:-1]
        meant = (same(key, keys_at(schema, within)) or hint(schema, place[:-1], key)) if schema else ""
        return "unknown key; " + (f"did you mean {meant}?" if meant else "remove it or correct its spelling")
    if kind == "missing":
        what = keys_at(schema, place[:-1]).get(str(place[-1]), {}).get("description", "") if schema else ""
        return f"missing, but required{what and ': '}{what}"
    if kind == "union_tag_invalid":
        tag, choices = str(ctx["tag"]), str(ctx["expected_tags"])
        return f"kind {shortened(repr(tag))}: needs one of {choices}{_meant(tag, choices)}"
    if kind == "union_tag_not_found":
        return "kind: missing, but required"
    if kind == "float_parsing" and re.fullmatch(r"\s*[+-]?\d+,\d+\s*", str(error["input"])):
        return "needs a number with a decimal point, not a comma"
    what = error["msg"] if kind == "value_error" else _WORDS.get(kind, "needs another value").format(**ctx)
    return what + (_meant(error["input"], str(ctx["expected"])) if kind == "literal_error" else "")


def _meant(received: object, choices: str) -> str:
    """Ask for the choice that was probably meant."""
    near = nearest(received, re.findall("'(.*?)'", choices)) if isinstance(received, str) else ""
    return f"; did you mean {near}?" if near and len(str(received)) <= LONGEST else ""
