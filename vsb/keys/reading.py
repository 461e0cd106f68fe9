"""Reading of YAML files into checked values: one line for every mistake, with the file's line it stands in."""

import difflib
import re
from collections.abc import Hashable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast

import yaml
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from vsb.errors import ConfigError
from vsb.keys.schema import Located, Schema, changed, dotted, in_si, keys_at, needed, other_units, schema_of, unit_of
from vsb.tools.files import LARGEST_STUDY, read_bounded
from vsb.tools.words import LONGEST, shortened


def yaml_mistake(error: Exception, text: str) -> tuple[int | None, str]:
    """Return the line, from 1, that an error of PyYAML means, none where it is not known, and what is wrong there.

    PyYAML names the place where it could not go on. What is wrong is often a line or two above: a bracket or a
    quotation mark that is still open, a key without its colon.
    """
    if isinstance(error, yaml.reader.ReaderError):
        line = text.count("\n", 0, error.position) + 1
        return line, f"a character of number {error.character!r} is no text; remove it"
    if not isinstance(error, yaml.MarkedYAMLError) or error.problem_mark is None:
        return None, " ".join(str(error).split())
    problem, context, lines = error.problem or "", error.context or "", text.splitlines()
    stopped, begun = error.problem_mark, error.context_mark or error.problem_mark
    line, first, before = stopped.line + 1, begun.line + 1, f"before column {stopped.column + 1}"
    opened = lines[begun.line][begun.column : begun.column + 1] if begun.line < len(lines) else ""
    if "'\\t'" in problem:
        return line, f"a tab stands in column {stopped.column + 1}; write spaces there"
    if found := re.fullmatch(r"expected <block end>, but found '([\]}])'", problem):
        return line, f"the bracket {found[1]} closes none that is open"
    if context.startswith("while parsing a flow"):
        got = problem.partition("got ")[2].strip("'")
        if context.endswith("node"):
            return line, f"a value is missing {before}"
        if got in ("]", "}"):
            return line, f"the bracket {opened} of line {first} is closed by {got}"
        if line == first and got != "<stream end>":
            return line, f"a comma is missing between two values, {before}"
        return first, f"the bracket {opened} in column {begun.column + 1} is not closed"
    if "quoted scalar" in context:
        if "escape" in problem:
            return line, "a backslash in double quotation marks begins an escape; write single ones"
        return first, f"the quotation mark {opened} in column {begun.column + 1} is not closed"
    found = re.fullmatch(r"found character '(.)' that cannot start any token", problem)
    if found or re.fullmatch("while scanning an (alias|anchor)", context):
        return line, f"a text cannot begin with {found[1] if found else opened}; put it in quotation marks"
    if "another document" in problem:
        return line, "--- begins a second document; needs one in a file"
    if "could not find expected ':'" in problem:
        return first, _without_colon(lines[begun.line] if begun.line < len(lines) else "")
    if found_in_lines := _misplaced(problem, stopped, lines):
        return found_in_lines
    said = [(error.problem, error.problem_mark), (error.context, error.context_mark)]
    words = [f"{part}, line {mark.line + 1}, column {mark.column + 1}" for part, mark in said if part and mark]
    return line, " ".join(", ".join(words).split())


def _misplaced(problem: str, stopped: yaml.Mark, lines: list[str]) -> tuple[int, str] | None:
    """A second colon in a line, a key without colon, keys or items that do not begin in one column."""
    here = lines[stopped.line] if stopped.line < len(lines) else ""
    above = next((i for i in range(min(stopped.line, len(lines)) - 1, -1, -1) if _said(lines[i])), stopped.line)
    line_above = lines[above] if above < len(lines) else ""
    two = "mapping values are not allowed" in problem
    if two and re.search(r":\s", here[: stopped.column]):
        words = "two colons in one line: put a text with a colon in quotation marks, a section in lines below"
        return stopped.line + 1, words
    if (two or "<block mapping start>" in problem) and not re.search(r":(\s|$)", _said(line_above)):
        return above + 1, _without_colon(_said(line_above))
    if not (two or any(f in problem for f in ("<block mapping start>", "<block sequence start>", "but found '-'"))):
        return None
    blanks, others = (len(one) - len(one.lstrip()) for one in (here, line_above))
    if blanks == others:
        return stopped.line + 1, "a list item, with a dash, stands among keys; needs one or the other"
    indented = f"indented by {blanks} space{'s' * (blanks != 1)}, the line above by {others}"
    words = f"{indented}; keys of one section begin in one column, and so do the items of a list"
    return stopped.line + 1, words


def _said(line: str) -> str:
    """A line without comment and blanks."""
    return re.sub(r"(^|\s)#.*", "", line).strip()


def _without_colon(line: str) -> str:
    """What a line lacks that should be a key and its value."""
    word = re.split(r"[\s:=]", _said(line), maxsplit=1)[0]
    lacks = "a space is missing behind the colon" if ":" in line else "a colon is missing behind the key"
    return f"{lacks}; write {word}: and its value"


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
    "freq": {"omega": "omega = 2 pi freq", "period": "period = 1/freq"},
    "frequency": {"omega": "omega = 2 pi frequency", "period": "period = 1/frequency, in Hz"},
    "type": {"kind": "kind"},
    "optimal": {"each": "each, the optimal damper of each design in each sea"},
    "infinite": {".inf": ".inf"},
    "infinity": {".inf": ".inf"},
    "deep": {".inf": ".inf"},
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
        seen: dict[object, int] = {}
        for key_node, _ in node.value:
            if key_node.tag == "tag:yaml.org,2002:merge":
                continue
            if not isinstance(key_node, yaml.ScalarNode):
                problem = "a list or a section stands where a key belongs; write {key: value}, or [value, value] alone"
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=key_node.start_mark)
            key = self.construct_object(key_node, deep=deep)
            if key in seen:
                problem = f"key {shortened(repr(key))} is given twice, first in line {seen[key]}"
                raise yaml.MarkedYAMLError(problem=problem, problem_mark=key_node.start_mark)
            seen[key] = key_node.start_mark.line + 1
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
"""Values that the aliases of a file may stand for; a few lines of aliases within aliases stand for any number."""


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
        text = read_bounded(path, LARGEST_STUDY).decode()
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}); give the path of {wanted}") from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise ConfigError(f"{path}:{line}: is no text in UTF-8; save it as such") from None
    try:
        return _loaded(text)
    except RecursionError:
        raise ConfigError(f"{path}: not valid YAML (nested too deeply); give {wanted}") from None
    except (yaml.YAMLError, TypeError, ValueError) as error:
        where, words = yaml_mistake(error, text)
        place = "" if where is None else f":{where}"
        raise ConfigError(f"{path}{place}: not valid YAML ({words})") from None


def _loaded(text: str) -> object:
    """What a YAML text holds."""
    loader = _UniqueKeyLoader(text)
    try:
        node = loader.get_single_node()
        known: dict[int, float] = {}
        if node is not None and _written_out(node, known) > len(known) + MOST_NODES:
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


def validated(model: type[Model], raw: object, source: str) -> Model:
    """Return a model from nested mappings.

    Raises `ConfigError`: one line with the source, its line if it is a YAML file, the key, the value received and the
    value needed; all mistakes there are as `mistakes`.
    """
    if not isinstance(raw, dict):
        received = "nothing" if raw is None else "a list" if isinstance(raw, list) else shortened(repr(raw))
        required = [name for name, its in model.model_fields.items() if its.is_required()]
        raise ConfigError(
            f"{source}: received {received}, needs a mapping with keys {', '.join(required)}; "
            f"of all there are: {', '.join(model.model_fields)}"
        )
    given = in_si(model, raw)
    try:
        return model.model_validate(given)
    except ValidationError as error:
        found = _without_misspelt(_ordered(error), given, model)
        lines = []
        for one in found[:MOST_REPORTED]:
            line = given.line(_place_of(one, given)) if isinstance(given, Located) else None
            place = source if line is None else f"{source}:{line}"
            lines.append(f"{place}: {_message(one, error.title, given, model)}{_guess(one, given, model)}")
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
    found = []
    for one in error.errors():
        text = one["msg"].removeprefix("Value error, ")  # only messages of this project have several lines
        lines = text.splitlines() if one["type"] == "value_error" else [text]
        found += [cast(ErrorDetails, {**one, "msg": line}) for line in lines]
    inner = {one["loc"][:n] for one in found for n in range(len(one["loc"]))}
    found = [one for one in found if one["type"] != "too_short" or one["loc"] not in inner]  # not of wrong items
    return sorted(found, key=lambda one: one["type"] != "extra_forbidden")


def _without_misspelt(found: list[ErrorDetails], raw: object, model: type[BaseModel]) -> list[ErrorDetails]:
    """The errors without the keys that are missing only because they are misspelt."""
    meant = {
        (*one["loc"][:-1], words[1])
        for one in found
        if one["type"] == "extra_forbidden"
        and (words := re.search(r"did you mean (\w+)\?$", _needed(one, _written(one, raw), raw, model)))
    }
    return [one for one in found if one["type"] != "missing" or one["loc"] not in meant]


def _more(found: Sequence[object]) -> str:
    """How many there are beside the first."""
    return f" (and {len(found) - 1} more)" if len(found) > 1 else ""


def _place_of(error: ErrorDetails, raw: dict[str, Any]) -> Place:
    """Keys of a mistake as the file has them; a check of a whole section begins with its key."""
    words = re.match(r"\w+(\.\w+)*", error["msg"]) if error["type"] == "value_error" else None
    named = [int(part) if part.isdigit() else part for part in words[0].split(".")] if words else []
    return [*_written(error, raw), *named]


OUT_OF_RANGE = ("value_error", "greater_than", "greater_than_equal", "less_than", "less_than_equal")
"""Mistakes, by pydantic's name, of numbers that may be meant in another unit."""


def _guess(error: ErrorDetails, raw: dict[str, Any], model: type[BaseModel]) -> str:
    """Ask for the unit a number out of range was probably meant in: the first with which its mistake is gone."""
    place = tuple(_place_of(error, raw))
    while place and _value_at(raw, place) is None:
        place = place[:-1]
    if error["type"] not in OUT_OF_RANGE or not isinstance(_value_at(raw, place), int | float):
        return ""
    for text, value in other_units(model, raw, place):
        try:
            model.model_validate(changed(raw, {place: value}))
        except ValidationError as left:
            if any(tuple(_place_of(one, raw))[: len(place)] == place for one in _ordered(left)):
                continue
        return f"; did you mean {text}?"
    return ""


def _value_at(raw: object, place: Place) -> object:
    """What stands at a place; None outside the file."""
    for part in place:
        inner = _inside(raw, part)
        if inner is None:
            return None
        raw = inner[0]
    return raw


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
    key = shortened(".".join(map(str, place))) or re.sub(r"(?<=[a-z])(?=[A-Z])", " ", title).lower()  # body study
    given = "nothing" if error["input"] is None else shortened(repr(error["input"]))
    received = "" if isinstance(error["input"], dict | BaseModel) else f" received {given};"
    return " ".join(f"{key}:{received} {_needed(error, place, raw, model)}".split())


_WORDS = {
    "bool_parsing": "needs true or false",
    "bool_type": "needs true or false",
    "dict_type": "needs a mapping of keys and values",
    "finite_number": "needs a finite number",
    "float_parsing": "needs a number",
    "float_type": "needs a number",
    "greater_than": "needs a number above {gt:g}",
    "greater_than_equal": "needs a number of at least {ge:g}",
    "invalid_key": "needs a word as a key; a number has a decimal point, 2.0, not a comma",
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


def _needed(error: ErrorDetails, place: Place, raw: object, model: type[BaseModel] | None) -> str:
    """What is needed in place of what was received, and what was probably meant."""
    kind, ctx, schema = error["type"], error.get("ctx", {}), schema_of(model) if model else {}
    if kind == "extra_forbidden":
        key, within = str(place[-1]), error["loc"][:-1]
        if misread := _misread_key(key):
            return f"unknown key; {misread}"
        meant = (same(key, keys_at(schema, within)) or hint(schema, place[:-1], key)) if schema else ""
        if not meant and (kinds := _kinds_with(schema, key, raw, place)):
            return f"unknown key; it belongs to kind {kinds}"
        return "unknown key; " + (f"did you mean {meant}?" if meant else "remove it or correct its spelling")
    if kind == "missing" and isinstance(place[-1], int):
        return "the list is too short; needs a value here, too"
    if kind == "missing":
        what = keys_at(schema, place[:-1]).get(str(place[-1]), {}).get("description", "") if schema else ""
        return f"missing, but required{what and ': '}{what}"
    if kind == "union_tag_invalid":
        tag, choices = str(ctx["tag"]), str(ctx["expected_tags"])
        return f"kind {shortened(repr(tag))}: needs one of {choices}{_meant(tag, choices)}"
    if kind == "union_tag_not_found":
        other = next((key for key in error["input"] if same(str(key), ["kind"])), "")
        return "kind: missing, but required" + (f"; did you mean kind in place of {other}?" if other else "")
    if kind == "float_parsing" and re.fullmatch(r"\s*[+-]?\d+,\d+\s*", str(error["input"])):
        return "needs a number with a decimal point, not a comma"
    if model and isinstance(text := error["input"], str) and (said := needed(text, unit_of(model, raw, place))):
        return said
    if kind == "float_parsing" and schema:
        what = keys_at(schema, place[:-1]).get(str(place[-1]), {}).get("description", "")
        meant = same(str(error["input"]), [".inf"])
        return f"needs a number{what and ': '}{what}" + (f"; did you mean {meant}?" if meant else "")
    if kind in ("list_type", "tuple_type") and isinstance(error["input"], str | int | float):
        return f"needs a list, [{shortened(str(error['input']))}]"
    if kind in ("list_type", "tuple_type") and isinstance(error["input"], dict):
        return "received a mapping; needs a list of them: square brackets around it"
    if kind in ("model_type", "dict_type", "model_attributes_type") and isinstance(error["input"], list):
        example = keys_at(schema, place[:-1]).get(str(place[-1]), {}).get("examples", [""])[0] if schema else ""
        return "needs a mapping of keys and values" + (f" such as {example}" if example else "")
    if kind in ("model_type", "dict_type", "model_attributes_type") and re.match(r"\w+:\S", str(error["input"])):
        return "needs a mapping of keys and values: a space behind every colon"
    what = error["msg"] if kind == "value_error" else _WORDS.get(kind, "needs another value").format(**ctx)
    return what + (_meant(error["input"], str(ctx["expected"])) if kind == "literal_error" else "")


def _kinds_with(schema: Schema, key: str, raw: object, place: Place) -> str:
    """Kinds, of those whose kind is chosen, that have a key, with `or`; empty where there is no kind."""
    section = _value_at(raw, place[:-1])
    if not isinstance(section, Mapping) or "kind" not in section:
        return ""
    forms = (one.get("properties", {}) for one in schema.get("$defs", {}).values())
    kinds = [str(form["kind"]["const"]) for form in forms if key in form and "const" in form.get("kind", {})]
    return " or ".join(kinds)


def _misread_key(key: str) -> str:
    """What is wrong with a key that holds more than a name; empty of a name."""
    if key.startswith("-"):
        return "a space is missing behind the dash of a list"
    if found := re.fullmatch(r"(\w+)(?:\s*=\s*|:| +)(\S.*)", key):
        return f"needs a colon and a space, {found[1]}: {shortened(found[2])}"
    return "it holds blanks that are no spaces" if re.search(r"[^\S ]", key) else ""


def _meant(received: object, choices: str) -> str:
    """Ask for the choice that was probably meant."""
    near = nearest(received, re.findall("'(.*?)'", choices)) if isinstance(received, str) else ""
    return f"; did you mean {near}?" if near and len(str(received)) <= LONGEST else ""
