"""JSON schema of the files a study is read from: for editors, for the reference of the keys, and for hints.

Made from the models themselves, with units and meanings of `vsb.study.keys`.
"""

import difflib
import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from typing import Any

import yaml
from pydantic import BaseModel

from vsb.study.keys import KEYS

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
                default |= _told_defaults(found, place, default)
    return {"$schema": DIALECT, **found}


def _told_defaults(schema: Schema, place: Schema, default: Schema) -> Schema:
    """What the keys of a section's default say of their own: auto is told as such."""
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
        nodes = [child for node in nodes for child in _below(schema, node, part)] or nodes
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


def _below(schema: Schema, node: Schema, part: str | int) -> Iterator[Schema]:
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
    "height": {"amplitude": "amplitude, half the height", "hs": "hs"},
    "significant_wave_height": {"hs": "hs"},
    "peak_period": {"tp": "tp"},
}
"""Words people know from other programs, the words here that mean the same, and how these are told."""


def same(word: str, words: Iterable[str]) -> str:
    """Return what means the same as a word of other programs, as it is told; empty if nothing does."""
    known = set(words)
    return next((text for one, text in SAME.get(word.lower(), {}).items() if one in known), "")


def hint(schema: Schema, place: Sequence[str | int], key: str) -> str:
    """Return the key that was probably meant: of the same section, or as it is named in another; empty if none is."""
    others = sorted(keys_at(schema, place).keys() - {key})  # a key of another kind may be called as this one
    if near := nearest(key, others):
        return near
    here = ".".join(part for part in [*place, key] if isinstance(part, str))
    return next((name for name in dotted(schema) if name.rpartition(".")[2] == key and name != here), "")


def nearest(word: str, words: Iterable[str]) -> str:
    """Return the word that means the same as another, or looks most like it, capitals or not; empty if none does."""
    small = {one.lower(): one for one in words}
    if meant := same(word, small.values()):
        return meant
    return next((small[one] for one in difflib.get_close_matches(word.lower(), list(small), n=1)), "")
