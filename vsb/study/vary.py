"""What a campaign varies: keys of a study, their values, and the points they make.

Imports nothing heavy: the Snakefile reads a campaign at every parse.
"""

import itertools
import json
import math
import random
import re
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any, Self

import vsb.engine.shell.device
import vsb.engine.waves.kinds  # noqa: F401  (describes its keys)
from vsb.engine.motion.take_off import port_kind
from vsb.keys.meanings import AT_PORT, UNITS
from vsb.keys.quantities import Section
from vsb.tools.units import DIMENSIONS, parsed_unit
from vsb.tools.variables import FORCE, PortKind
from vsb.tools.words import shortened

FROUDE_POWERS = {"m": Fraction(1), "kg": Fraction(3), "s": Fraction(1, 2)}
"""Power of the length scale that a unit goes with at equal Froude number, density and gravity; angles stay."""
STAYS = ("depth", "atmospheric_pressure")
"""Keys that are not scaled, whatever their unit: those of water and air."""


def length_power(unit: str) -> float:
    """Return the power of the length scale a unit such as N s/m or rad/(m s) goes with, at equal Froude number."""
    powers = parsed_unit(unit).powers
    return float(sum(power * FROUDE_POWERS.get(base, 0) for base, power in zip(DIMENSIONS, powers, strict=True)))


def scaled(raw: Any, scale: float, power: float = 0.0) -> Any:
    """Return a buoy's study, given as nested mappings, with every quantity scaled by Froude.

    Parameters
    ----------
    scale : float
        Of lengths; times go with its root.
    power : float
        With which numbers go that stand under no key of a unit.
    """
    if isinstance(raw, dict):
        return {
            key: _SCALED_APART[key](value, scale)
            if key in _SCALED_APART
            else scaled(value, scale, FROUDE.get(key, power))
            for key, value in raw.items()
        }
    if isinstance(raw, list | tuple):
        return [scaled(value, scale, power) for value in raw]
    if isinstance(raw, bool) or not isinstance(raw, int | float) or not power:
        return raw
    return scale**power * raw


def scaled_mooring(raw: Any, scale: float) -> Any:
    """Return the stiffness of a mooring scaled by Froude: forces per length, per angle, moments per angle."""
    if not isinstance(raw, list | tuple):
        return raw
    diagonal = not any(isinstance(row, list | tuple) for row in raw)
    if diagonal:
        return [scaled(one, scale, 2.0 if i < 3 else 4.0) for i, one in enumerate(raw)]
    return [[scaled(one, scale, 2.0 + (i > 2) + (j > 2)) for j, one in enumerate(row)] for i, row in enumerate(raw)]


def scaled_take_off(raw: Any, scale: float) -> Any:
    """Return a take-off scaled by Froude, by the units of its port.

    Parameters of a law of a package stay as they are: only the package knows what they mean.
    """
    if not isinstance(raw, dict):
        return raw
    port = raw.get("port")
    several = raw if "ports" in raw else port
    if isinstance(several, dict) and "ports" in several:
        own = {key: value for key, value in raw.items() if key not in ("ports", "damping", "matrix", "port")}
        return scaled(own, scale) | _scaled_matrix(several, scale)
    known = powers(port_kind(port))
    return {
        key: value if key == "parameters" else scaled(value, scale, known.get(key, 0.0)) for key, value in raw.items()
    }


def _scaled_matrix(raw: dict[str, Any], scale: float) -> dict[str, Any]:
    """Several ports and their damper matrix scaled by Froude: load of each over rate of each."""
    own: dict[str, Any] = {key: raw[key] for key in ("ports", "damping", "matrix") if key in raw}
    kinds, rows = [port_kind(port) for port in raw["ports"].values()], raw.get("damping")
    if rows is None:
        return own
    loads, rates = ([length_power(getattr(kind, name)) for kind in kinds] for name in ("load_unit", "rate_unit"))
    matrix = [
        [scaled(x, scale, load - rate) for x, rate in zip(row, rates, strict=True)]
        for row, load in zip(rows, loads, strict=True)
    ]
    return {**own, "damping": matrix}


def powers(kind: PortKind = FORCE) -> dict[str, float]:
    """Return the powers of the length scale that keys go with, by their last word, at a kind of port."""
    return FROUDE | {key.removeprefix("pto."): length_power(unit(key, kind)) for key in AT_PORT}


_SCALED_APART = {"mooring": scaled_mooring, "pto": scaled_take_off}
"""Sections whose quantities go with more than their names."""


Value = float | str
Point = dict[str, Value]
"""A value of every varied key, by key."""
SCALE = "scale"
"""The key that scales the whole study by Froude, no key of its own."""
MEMBER = "member"
"""Dimension of points that are no product."""
MOST_POINTS = 100_000
"""Points of a campaign: each is validated and named by its content whenever the plan is read, 1 ms."""
SECTIONS = ("device", "body", "reference_shape", "modes", "designs", "water", "hydro", "pto")
"""Sections of a study whose keys can be varied: its waves are the climate's, its simulation makes no year."""
FROUDE = {
    name: length_power(unit)
    for name, unit in UNITS.items()
    if name not in STAYS and not {"SI", "port", ","} & {*re.findall(r"SI|port|,", unit)}
}
"""Power of the length scale that a key goes with, by its last word; of the take-off see `powers`."""
PORT = "pto.port"
DAMPING = "pto.damping"
_FORMS = "a list of values, {log: [first, last, count]} or {linear: [first, last, count]}"
_SPACED = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 3}
_SPACING = {"type": "object", "properties": {"log": _SPACED, "linear": _SPACED}, "additionalProperties": False}
VARIED: dict[str, Any] = {
    "type": "object",
    "default": {},
    "properties": {
        "pairs": {"type": "boolean", "default": False, "description": "the first value of each key, the second, ..."},
        "latin_hypercube": {
            "type": "object",
            "description": "points drawn evenly between the ends of each key",
            "properties": {"samples": {"type": "integer", "minimum": 1}, "seed": {"type": "integer", "default": 1}},
            "required": ["samples"],
            "additionalProperties": False,
        },
    },
    "additionalProperties": {"anyOf": [{"type": "array", "items": {"type": ["number", "string"]}}, _SPACING]},
}
"""What a file may say of what is varied, as JSON schema."""
_DIGITS = 12
"""Digits of values spaced evenly: those of a sweep and of its widening are the same."""


def unit(key: str, kind: PortKind = FORCE) -> str:
    """Return the unit of a key, of a take-off's at a kind of port; a damper of one design has that of all."""
    key = DAMPING if key.startswith(f"{DAMPING}.") else key
    word = next(word for word in reversed(key.split(".")) if not word.isdigit())
    return str(getattr(kind, AT_PORT[key])) if key in AT_PORT else UNITS.get(word, "1")


class Vary(Section):
    """Values of the varied keys: every combination of them, or `together`, the first of each, the second, ...

    Lists, not a mapping: canonical JSON sorts mappings, and the order of keys is that of dimensions and points.
    """

    keys: tuple[str, ...] = ()
    lists: tuple[tuple[Value, ...], ...] = ()
    together: bool = False

    @classmethod
    def of(cls, values: Mapping[str, Sequence[Value]], *, together: bool = False) -> Self:
        """Return what is varied from the values of each key."""
        return cls(keys=tuple(values), lists=tuple(map(tuple, values.values())), together=together)

    @property
    def values(self) -> dict[str, tuple[Value, ...]]:
        """Values of each key."""
        return dict(zip(self.keys, self.lists, strict=True))

    @property
    def points(self) -> list[Point]:
        """All points, the last key varying fastest; one, of no keys, if nothing is varied."""
        combined = (
            zip(*self.values.values(), strict=True) if self.together else itertools.product(*self.values.values())
        )
        return [dict(zip(self.values, values, strict=True)) for values in combined]

    def dimensions(self, taken: Iterable[str]) -> dict[str, str]:
        """Return the dimension, or of points that are no product the coordinate, of each key.

        Parameters
        ----------
        taken : iterable of str
            Names of variables and other dimensions: the last word of a key is its name, or all of them where that is
            taken, or the last word of another key as well.
        """
        last = [key.rpartition(".")[2] for key in self.values]
        clashing = {word for word in last if last.count(word) > 1} | set(taken) | {MEMBER}
        return {
            key: key.replace(".", "_") if word in clashing else word
            for key, word in zip(self.values, last, strict=True)
        }

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each dimension."""
        lengths = tuple(len(values) for values in self.values.values())
        return lengths[:1] if self.together else lengths


def read_vary(raw: object) -> Vary:
    """Return what is varied from the section of a campaign file.

    Raises `ValueError`: one line with the key, what was received and what is needed.
    """
    if isinstance(raw, Vary):
        return raw
    if not isinstance(raw, Mapping):
        raise ValueError(f"received {raw!r}, needs keys of the study, each with {_FORMS}")
    keys = {str(key): value for key, value in raw.items() if key not in ("pairs", "latin_hypercube")}
    within = [name for name in SECTIONS if name != "reference_shape"]
    for key in keys:  # whether the study has it shows when it is set
        section, dot, _ = key.partition(".")
        if key not in (SCALE, "reference_shape") and not (dot and section in within):
            raise ValueError(
                f"{shortened(key)}: needs {SCALE}, reference_shape, or a key of {', '.join(within)} such as device.mass"
            )
    if "latin_hypercube" in raw:
        return _hypercube(keys, raw["latin_hypercube"], raw.get("pairs", False))
    if (pairs := raw.get("pairs", False)) not in (True, False):
        raise ValueError(f"pairs: received {pairs!r}, needs true or false")
    values = {key: _values(key, value) for key, value in keys.items()}
    lengths = {key: len(each) for key, each in values.items()}
    if pairs and len(set(lengths.values())) != 1:
        raise ValueError(f"pairs: received {lengths} values, needs as many of every key")
    points = max(lengths.values(), default=1) if pairs else math.prod(lengths.values())
    if points > MOST_POINTS:
        raise ValueError(f"received {points} points, needs at most {MOST_POINTS}; make several campaigns of more")
    return Vary.of(values, together=pairs)


def _values(key: str, raw: object) -> tuple[Value, ...]:
    """The values of a key."""
    if isinstance(raw, Mapping):
        kind, (first, last, *count) = _spacing(key, raw)
        if len(count) != 1 or count[0] != int(count[0]) or not 1 <= count[0] <= MOST_POINTS:
            needed = f"{{{kind}: [first, last, count]}} with a count of 1 to {MOST_POINTS}"
            raise ValueError(f"{key}: received {dict(raw)}, needs {needed}")
        steps = int(count[0]) - 1
        return _distinct(key, [_between(kind, first, last, i / steps if steps else 0.0) for i in range(steps + 1)])
    if not isinstance(raw, list | tuple) or not raw:
        raise ValueError(f"{key}: received {raw!r}, needs {_FORMS}")
    return _distinct(key, [_value(key, each) for each in raw])


def _spacing(key: str, raw: Mapping[Any, Any]) -> tuple[str, list[float]]:
    """Kind and numbers of values spaced evenly."""
    ((kind, given),) = raw.items() if len(raw) == 1 else [("", None)]
    if kind not in ("log", "linear") or not isinstance(given, list | tuple) or len(given) not in (2, 3):
        raise ValueError(f"{key}: received {dict(raw)}, needs {_FORMS}")
    numbers = [_value(key, each) for each in given]
    if not all(isinstance(each, float) and math.isfinite(each) for each in numbers):
        raise ValueError(f"{key}: received {dict(raw)}, needs finite numbers")
    found = [float(each) for each in numbers]
    if kind == "log" and min(found[:2]) <= 0:
        raise ValueError(f"{key}: received {dict(raw)}, needs ends above 0 to be spaced by their logarithm")
    return str(kind), found


def _between(kind: str, first: float, last: float, part: float) -> float:
    """A number some part of the way from one to another."""
    value = first * (last / first) ** part if kind == "log" else first + (last - first) * part
    return float(f"{value:.{_DIGITS}g}")


def _value(key: str, raw: object) -> Value:
    """One value: a number, written as YAML does not know it (1.0e6) as well, or a word."""
    if isinstance(raw, bool) or not isinstance(raw, int | float | str):
        raise ValueError(f"{key}: received {raw!r}, needs numbers or words")
    try:
        number = float(raw)
    except ValueError:
        return str(raw)
    except OverflowError:
        raise ValueError(f"{key}: received a number of too many digits, needs numbers or words") from None
    if math.isnan(number):
        raise ValueError(f"{key}: received {raw!r}, needs numbers or words")
    return number


def _distinct(key: str, values: list[Value] | list[float]) -> tuple[Value, ...]:
    """Check that no value is given twice, nor numbers beside words."""
    if len(set(values)) < len(values):
        raise ValueError(f"{key}: received {_shown(values)}, needs every value once")
    if len({type(value) for value in values}) > 1:
        raise ValueError(f"{key}: received {_shown(values)}, needs numbers, or words")
    return tuple(values)


def _shown(values: object) -> str:
    """Values, not pages of them."""
    text = json.dumps(values)
    return text if len(text) < 80 else f"{text[:80]}..."


def _hypercube(keys: Mapping[str, object], raw: object, pairs: object) -> Vary:
    """Points of a Latin hypercube: of each key one value in every of as many strata, in an order drawn at random."""
    given = dict(raw) if isinstance(raw, Mapping) else {}
    samples, seed = given.pop("samples", None), given.pop("seed", 1)
    if (
        type(samples) is not int
        or type(seed) is not int
        or not 1 <= samples <= MOST_POINTS
        or given
        or not keys
        or pairs
    ):
        raise ValueError(
            f"latin_hypercube: received {raw!r}, needs {{samples: n, seed: 1}} beside keys with {{log: [low, high]}} "
            "or {linear: [low, high]}, and no pairs"
        )
    values: dict[str, tuple[Value, ...]] = {}
    for key, ends in keys.items():
        kind, numbers = _spacing(key, ends) if isinstance(ends, Mapping) else ("", [])
        if len(numbers) != 2:
            raise ValueError(f"{key}: received {ends!r}, needs {{log: [low, high]}} or {{linear: [low, high]}}")
        drawn = random.Random(f"{seed} {key}")
        strata = drawn.sample(range(samples), samples)
        values[key] = tuple(
            _between(kind, numbers[0], numbers[1], (stratum + drawn.random()) / samples) for stratum in strata
        )
    return Vary.of(values, together=True)
