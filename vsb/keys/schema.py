"""Schemas of the files: which keys stand where, with types, ranges and meanings; for editors, messages and docs."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import yaml
from pydantic import BaseModel

from vsb.keys.meanings import AT_PORT, KEYS, UNITS
from vsb.tools.units import parsed_unit, split, value_in
from vsb.tools.variables import KINDS, PortKind

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
    for name, section in {found["title"]: found, **found.get("$defs", {})}.items():
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


Place = tuple[str | int, ...]
"""Keys and indices from the top of a file to something in it."""


class Located(dict[str, Any]):
    """The mapping a YAML file holds, which knows the lines its parts stand in."""

    def __init__(self, data: dict[str, Any], node: yaml.MappingNode) -> None:
        super().__init__(data)
        self.node = node

    def line(self, place: Sequence[str | int]) -> int | None:
        """Return the line, from 1, of the innermost part of a place there is; None of one outside."""
        node: yaml.Node = self.node
        found = None
        for part in place:
            below: tuple[yaml.Node, yaml.Node] | None = None
            if isinstance(node, yaml.MappingNode):
                below = next((pair for pair in node.value if pair[0].value == part), None)
            elif isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
                below = node.value[part], node.value[part]
            if below is not None:
                key, node = below
                found = key.start_mark.line + 1
        return found


class KeyUnit(NamedTuple):
    """Unit of a key; where it is one of several, or that of a port not known, a plain number is needed."""

    unit: str
    several: bool = False
    key: str = ""


def in_si(model: type[BaseModel], raw: Any) -> Any:
    """Return nested mappings with every quantity a key's unit can measure as a number, 15 mm as 0.015.

    The same object without any. What cannot be read stays a text, for the checks of its key to refuse; `needed` says
    why.
    """
    changes: dict[Place, float] = {}
    for place, text in _texts(raw):
        if split(text) and (unit := unit_of(model, raw, place)) and not unit.several:
            try:
                changes[place] = value_in(text, unit.unit)
            except ValueError:
                continue
    return changed(raw, changes) if changes else raw


def _texts(raw: Any, place: Place = ()) -> list[tuple[Place, str]]:
    """All texts of nested mappings and lists, and where they stand."""
    if isinstance(raw, str):
        return [(place, raw)]
    if isinstance(raw, list | tuple):
        inner: Iterable[tuple[Any, Any]] = enumerate(raw)
    elif isinstance(raw, Mapping):
        inner = raw.items()
    else:
        return []
    return [one for part, value in inner if not isinstance(value, float) for one in _texts(value, (*place, part))]


def changed(raw: Any, changes: Mapping[Place, float], place: Place = ()) -> Any:
    """Return nested mappings and lists with other values at some places."""
    if place in changes:
        return changes[place]
    if isinstance(raw, Mapping):
        values = {key: changed(value, changes, (*place, key)) for key, value in raw.items()}
        return Located(values, raw.node) if isinstance(raw, Located) else values
    if isinstance(raw, list | tuple):
        return [changed(value, changes, (*place, i)) for i, value in enumerate(raw)]
    return raw


def unit_of(model: type[BaseModel], raw: Any, place: Sequence[str | int]) -> KeyUnit | None:
    """Return the unit of the innermost key at a place of a file that is described; None if it has none.

    Values by names of one's own have the unit of the key they stand under: dampers of designs, which are all at one
    port. Entries by degrees of freedom may be of rotations: their unit is one of several.
    """
    schema = schema_of(model)
    for n in range(len(place) - 1, -1, -1):
        key, outer = place[n], place[:n]
        if not isinstance(key, str):
            continue
        if outer and outer[-1] == "pareto":
            limit = KEYS["Limits"].get(key)
            return KeyUnit(limit.unit, bool(limit.at_port), key) if limit else None
        if outer and outer[-1] in ("vary", "variables"):
            word = key.rpartition(".")[2]
            unit = UNITS.get(word, "-")
            return KeyUnit(unit, unit == "SI" or key in AT_PORT, word)
        said = keys_at(schema, outer).get(key, {})
        if "unit_at_port" in said:
            kind: PortKind | None = model.kind_of_port(raw) if hasattr(model, "kind_of_port") else None
            if kind is None or tuple(outer) != ("pto",):
                return KeyUnit(said["unit"], True, key)
            unit = str(getattr(kind, said["unit_at_port"]))
            return KeyUnit(unit, unit == "SI", key)
        if "unit" in said:
            named = any(isinstance(part, str) for part in place[n + 1 :]) and said["unit"] != "-"
            return KeyUnit(said["unit"], named or "," in said["unit"], key) if said["unit"] else None
    return None


def needed(text: str, unit: KeyUnit | None) -> str:
    """Return what is needed in place of a text that looks like a quantity, empty if it does not.

    Examples
    --------
    >>> needed("15 kg", KeyUnit("m"))
    'needs a number in m: kg is of another kind'
    """
    parts = split(text)
    if parts is None or unit is None:
        return ""
    inside = "a pure number" if unit.unit in ("-", "1") else f"a number in {unit.unit.removeprefix('in ')}"
    if not unit.several:
        try:
            value_in(text, unit.unit)
        except ValueError as error:
            return f"needs {inside}: {error}"
        return ""
    try:
        given = parsed_unit(parts[1])
    except ValueError as error:
        return f"needs {inside}, without a unit: {error}"
    alike = [one for one in _SI_UNITS if parsed_unit(one).powers == given.powers]
    return f"needs {inside}, without a unit" + (f": {text} is {value_in(text, alike[0]):g} {alike[0]}" if alike else "")


LIKELY = {
    "m": ("mm", "cm"), "Pa": ("MPa", "GPa", "kPa"), "kg/m^3": ("g/cm^3",), "kg": ("t",), "-": ("%",), "1": ("%",),
    "N s/m": ("kN s/m",), "N/m": ("kN/m",), "N": ("kN",), "rad/s": ("Hz",), "s": ("ms",), "Hz": ("rad/s",),
}  # fmt: skip
"""Unit of a key -> units its number is most often meant in by mistake."""
USUAL = {
    "m": (0.1, 1e3), "thickness": (1e-4, 1.0), "Pa": (1e3, 2e12), "kg/m^3": (20.0, 2.5e4), "kg": (10.0, 1e9),
    "rad/s": (0.05, 100.0), "Hz": (0.01, 10.0), "s": (0.1, 1e5), "N s/m": (10.0, 1e9), "N/m": (10.0, 1e9),
    "N": (10.0, 1e9), "efficiency": (0.1, 1.0), "poisson_ratio": (0.1, 0.5), "tolerance": (1e-4, 0.1),
    "power_tolerance": (1e-3, 0.3), "uncertain": (1e-3, 0.5), "static_strain": (1e-3, 1.0),
}  # fmt: skip
"""Key, else unit of a key -> range of its likely values in it; of pure numbers those alone that people give in %."""


def other_units(model: type[BaseModel], raw: Any, place: Place) -> Iterator[tuple[str, float]]:
    """Yield quantities that a number at a place may mean in another unit than its key's: as text, and in that unit.

    Those alone that are likely values of the key: a draft of 450 may be in mm, one of 4.5 is not.
    """
    number, unit = raw, unit_of(model, raw, place)
    for part in place:
        number = number[part]
    known = isinstance(number, int | float) and not isinstance(number, bool) and math.isfinite(number)
    if unit is None or unit.several or not known:
        return
    least, most = USUAL.get(unit.key) or USUAL.get(unit.unit, (math.inf, math.inf))
    for other in LIKELY.get(unit.unit, ()):
        text = f"{number:.12g} {other}"
        if not split(text):
            continue
        value = value_in(text, unit.unit)
        if least <= abs(value) <= most and not abs(value) < abs(number) < 1:  # 0.017 is not meant in mm
            yield text, value


_SI_UNITS = (
    "N s/m", "N/m", "N m s", "N m", "N", "m", "kg", "kg m", "kg m^2", "Pa", "s",
    *(getattr(kind, name) for kind in KINDS.values() for name in ("load_unit", "damping_unit", "stiffness_unit")),
)  # fmt: skip
"""Units a quantity is stated in where that of its key is not known."""
