"""Schemas of the files: which keys stand where, with types, ranges and meanings; for editors, messages and docs."""

import math
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

import yaml
from pydantic import BaseModel

from vsb.keys.meanings import KEYS

Schema = dict[str, Any]
DIALECT = "https://json-schema.org/draft/2020-12/schema"
QUANTITY = {"type": "string", "pattern": r"^\s*[-+]?(\d|\.\d).*\D\s*$"}
"""A number with a unit, as `vsb.tools.units` reads it."""
_BOUNDS = {"gt": "exclusiveMinimum", "ge": "minimum", "lt": "exclusiveMaximum", "le": "maximum"}
"""JSON's words for the bounds of numbers."""


@cache
def schema_of(model: type[BaseModel]) -> Schema:
    """Return the JSON schema of a model, not to be changed: types, ranges, defaults, choices, what every key means."""
    found: Schema = _with_bounds(model.model_json_schema())
    for name, section in {model.__name__: found, **found.get("$defs", {})}.items():
        for key, place in [*section.get("properties", {}).items()]:
            place.pop("title", None)
            if said := KEYS.get(name, {}).get(key):
                unit = f" [{said.unit}]" if said.unit else ""
                place |= {"description": said.meaning + unit, "examples": [yaml.safe_load(said.example)]}
                if said.unit:
                    section["properties"][key] = place = _or_quantity(place) | {"unit": said.unit}
                if said.at_port:
                    place["unit_at_port"] = said.at_port
            if isinstance(default := place.get("default"), dict):
                default |= _described_defaults(found, place, default)
    return {"$schema": DIALECT, **found}


def _or_quantity(node: Schema) -> Schema:
    """The same where every number may be a quantity, 15 mm."""
    if node.get("type") in ("number", "integer"):
        about: Schema = {key: node[key] for key in ("default", "description", "examples") if key in node}
        number = {key: value for key, value in node.items() if key not in about}
        return {"anyOf": [number, QUANTITY], **about}
    found = dict(node)
    for key in ("anyOf", "oneOf", "prefixItems"):
        if key in node:
            found[key] = [_or_quantity(one) for one in node[key]]
    for key in ("items", "additionalProperties"):
        if isinstance(node.get(key), dict):
            found[key] = _or_quantity(node[key])
    return found


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
