"""Numbers a file writes with a unit, 15 mm or 8 kN s/m: read in the unit of their key; and what else a number may mean.

One place for every key: its unit is that of `vsb.keys.meanings`, of a take-off that of its port.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from pydantic import BaseModel

from vsb.keys.meanings import AT_PORT, KEYS, UNITS
from vsb.keys.schema import Schema, keys_at, schema_of
from vsb.tools.ports import KINDS, PortKind
from vsb.tools.units import parsed_unit, split, value_in

Place = tuple[str | int, ...]
"""Keys and indices from the top of a file to something in it."""
Rebuilt = Callable[[Any, dict[Any, Any]], Any]
"""Makes a mapping of changed values from the one it replaces and those values."""


class KeyUnit(NamedTuple):
    """Unit of a key; where it is one of several, or that of a port not known, a plain number is needed."""

    unit: str
    several: bool = False


def with_units_read(raw: Any, model: type[BaseModel], rebuilt: Rebuilt) -> Any:
    """Return nested mappings with every quantity a key's unit can measure as a number; the same object without any.

    What cannot be read stays a text, for the checks of its key to refuse; `needed` says why.

    Parameters
    ----------
    model : type
        What the mappings are of.
    rebuilt : callable
        See `Rebuilt`.
    """
    changes: dict[Place, float] = {}
    for place, text in _texts(raw):
        if split(text) and (unit := unit_of(model, raw, place)) and not unit.several:
            try:
                changes[place] = value_in(text, unit.unit)
            except ValueError:
                continue
    return _changed(raw, (), changes, rebuilt) if changes else raw


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


def changed(raw: Any, place: Place, value: float, rebuilt: Rebuilt) -> Any:
    """Return nested mappings with another value at a place."""
    return _changed(raw, (), {place: value}, rebuilt)


def _changed(raw: Any, place: Place, changes: Mapping[Place, float], rebuilt: Rebuilt) -> Any:
    """Nested mappings and lists with other values at some places."""
    if place in changes:
        return changes[place]
    if isinstance(raw, Mapping):
        return rebuilt(raw, {key: _changed(value, (*place, key), changes, rebuilt) for key, value in raw.items()})
    if isinstance(raw, list | tuple):
        return [_changed(value, (*place, i), changes, rebuilt) for i, value in enumerate(raw)]
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
        if outer and outer[-1] in ("vary", "variables", "pareto"):
            return _unit_of_varied(key, of_limits=outer[-1] == "pareto")
        said = keys_at(schema, outer).get(key, {})
        if "unit_at_port" in said:
            return _unit_at_port(model, raw, outer, said)
        if "unit" in said:
            named = any(isinstance(part, str) for part in place[n + 1 :]) and said["unit"] != "-"
            return KeyUnit(said["unit"], several=named or "," in said["unit"]) if said["unit"] else None
    return None


def _unit_of_varied(key: str, *, of_limits: bool) -> KeyUnit | None:
    """Unit of a key of a study that a campaign or a design file varies, or of a limit."""
    if of_limits:
        limit = KEYS["Limits"].get(key)
        return KeyUnit(limit.unit, several=bool(limit.at_port)) if limit else None
    unit = UNITS.get(key.rpartition(".")[2], "-")
    return KeyUnit(unit, several=unit == "SI" or key in AT_PORT)


def _unit_at_port(model: type[BaseModel], raw: Any, outer: Sequence[str | int], said: Schema) -> KeyUnit:
    """Unit of a key of a take-off by its port, where the file says it."""
    kind: PortKind | None = model.kind_of_port(raw) if hasattr(model, "kind_of_port") else None
    if kind is None or tuple(outer) != ("pto",):
        return KeyUnit(said["unit"], several=True)
    unit = str(getattr(kind, said["unit_at_port"]))
    return KeyUnit(unit, several=unit == "SI")


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


def other_units(model: type[BaseModel], raw: Any, place: Place) -> Iterator[tuple[str, float]]:
    """Yield quantities that a number at a place may mean in another unit than its key's: as text, and in that unit."""
    number, unit = raw, unit_of(model, raw, place)
    for part in place:
        number = number[part]
    known = isinstance(number, int | float) and not isinstance(number, bool) and math.isfinite(number)
    if unit is None or unit.several or not known:
        return
    for other in LIKELY.get(unit.unit, ()):
        text = f"{number:.12g} {other}"
        if split(text) and not abs(value := value_in(text, unit.unit)) < abs(number) < 1:  # 0.017 is not meant in mm
            yield text, value


_SI_UNITS = (
    "N s/m", "N/m", "N m s", "N m", "N", "m", "kg", "kg m", "kg m^2", "Pa", "s",
    *(getattr(kind, name) for kind in KINDS.values() for name in ("load_unit", "damping_unit", "stiffness_unit")),
)  # fmt: skip
"""Units a quantity is stated in where that of its key is not known."""
