"""Units: what "kN s/m" or "15 mm" measures, and how much of it, in SI.

Factors are fractions, so that 15 mm is the very number 0.015, and both have one id. Symbols are those of SI, in which
MPa and mPa differ; `vsb.tools.units` reads headers of files of waves, where capitals mean nothing.
"""

import math
import re
from fractions import Fraction
from functools import cache
from typing import NamedTuple

BASE = ("m", "kg", "s", "rad")
"""Units all others are products of; the angle is one of them, so that rad/s, Hz and 1/s are three."""
_SI = {
    "1": "", "-": "", "m": "m", "g": "kg", "s": "s", "rad": "rad", "N": "kg m/s^2", "Pa": "kg/(m s^2)",
    "J": "kg m^2/s^2", "W": "kg m^2/s^3", "Hz": "rad/s",
}  # fmt: skip
"""Units that may have a prefix, and 1, as products of base units; `_OTHER` says how much of them."""
_OTHER: dict[str, tuple[str | Fraction, str]] = {
    "g": ("0.001", "kg"), "Hz": (2 * Fraction(math.pi), "rad/s"), "%": ("0.01", ""), "t": ("1000", "kg"),
    "deg": (Fraction(math.pi) / 180, "rad"), "rpm": (Fraction(math.pi) / 30, "rad/s"), "bar": ("1e5", "Pa"),
    "mbar": ("100", "Pa"), "atm": ("101325", "Pa"), "psi": ("6894.757293168361", "Pa"),
    "ksi": ("6894757.293168361", "Pa"),
    "min": ("60", "s"), "h": ("3600", "s"), "d": ("86400", "s"), "in": ("0.0254", "m"), "ft": ("0.3048", "m"),
    "yd": ("0.9144", "m"), "mi": ("1609.344", "m"), "nmi": ("1852", "m"), "l": ("0.001", "m^3"),
    "lb": ("0.45359237", "kg"), "lbf": ("4.4482216152605", "N"), "kgf": ("9.80665", "N"),
}  # fmt: skip
_SAME = {
    "metre": "m", "metres": "m", "meter": "m", "meters": "m", "sec": "s", "second": "s", "seconds": "s",
    "minutes": "min", "hour": "h", "hours": "h", "day": "d", "days": "d", "tonne": "t", "tonnes": "t", "°": "deg",
    "degree": "deg", "degrees": "deg", "inch": "in", "inches": "in", "foot": "ft", "feet": "ft", "lbs": "lb",
    "percent": "%", "L": "l",
}  # fmt: skip
"""Other spellings."""
_PREFIXES = {"G": 9, "M": 6, "k": 3, "m": -3, "µ": -6, "u": -6, "n": -9}
_OF_FEW = {"h": (2, "Pa"), "d": (-1, "m"), "c": (-2, "m")}
"""Prefixes of one unit: hPa, dm, cm."""
_QUANTITY = re.compile(
    r"\s*([+-]?(?:\d{1,40}\.?\d{0,40}|\.\d{1,40})(?:[eE][+-]?\d{1,3})?)\s*([^\W\d_].*|[%°].*|1/.+)", re.DOTALL
)
_TOKEN = re.compile(r"[^\W\d_]+|\^?-?\d(?:\.\d)?|\S")
_POWER = re.compile(r"\^?-?\d(?:\.\d)?")
_PLAIN = str.maketrans({"²": "2", "³": "3", "⁻": "-", "¹": "1", "·": " ", "⋅": " ", "*": " ", "μ": "µ"})


class Unit(NamedTuple):
    """How much of the product of base units, and the power of each of them."""

    factor: Fraction
    powers: tuple[Fraction, ...]  # of `BASE`

    def times(self, other: "Unit", power: Fraction = Fraction(1)) -> "Unit":
        """Return the product with a power of another unit."""
        factor = Fraction(other.factor**power)  # a float of a root
        powers = (mine + power * its for mine, its in zip(self.powers, other.powers, strict=True))
        return Unit(self.factor * factor, tuple(powers))


ONE = Unit(Fraction(1), (Fraction(0),) * len(BASE))


@cache
def parsed_unit(text: str) -> Unit:
    """Return a unit such as m, kN s/m, kg/m^3, kg/m3, N-m, rad/(m s) or %; `ValueError` if it is none known here."""
    plain = re.sub(r"(?<=[^\W\d])[-.](?=[^\W\d])", " ", text.replace("**", "^").translate(_PLAIN)).rstrip(" .")
    tokens = _TOKEN.findall(plain)
    found = _product(tokens)
    if tokens:
        raise ValueError(f"{text!r} is no unit: a bracket is closed that is not open")
    return found


def _product(tokens: list[str]) -> Unit:
    """The product of the factors up to a closing bracket; / divides by the factor behind it alone."""
    found, sign = ONE, 1
    while tokens and tokens[0] != ")":
        token = tokens.pop(0)
        if token == "/" and sign == 1 and tokens:
            sign = -1
            continue
        one = _product(tokens) if token == "(" else _symbol(token)
        if token == "(" and (not tokens or tokens.pop(0) != ")"):
            raise ValueError("a bracket of the unit is not closed")
        power = tokens.pop(0).lstrip("^") if tokens and _POWER.fullmatch(tokens[0]) else "1"
        found, sign = found.times(one, sign * Fraction(power)), 1
    return found


def _symbol(name: str) -> Unit:
    """A unit by its symbol, with a prefix or none."""
    name = _SAME.get(name, name)
    if name in BASE:
        return Unit(Fraction(1), tuple(Fraction(name == base) for base in BASE))
    if name in _OTHER:
        factor, of = _OTHER[name]
        return Unit(Fraction(factor), ONE.powers).times(parsed_unit(of) if of else ONE)
    if name in _SI:
        return parsed_unit(_SI[name]) if _SI[name] else ONE
    prefix, rest = name[:1], name[1:]
    if rest in _SI and rest not in ("1", "-") and prefix in _PREFIXES:
        return Unit(Fraction(10) ** _PREFIXES[prefix], ONE.powers).times(_symbol(rest))
    if prefix in _OF_FEW and rest == _OF_FEW[prefix][1]:
        return Unit(Fraction(10) ** _OF_FEW[prefix][0], ONE.powers).times(_symbol(rest))
    if run_together := re.fullmatch(r"([kMG]?N)([ms])", name):  # kNm
        return _symbol(run_together[1]).times(_symbol(run_together[2]))
    raise ValueError(f"{name!r} is no unit known here{_meant(name)}")


def _meant(name: str) -> str:
    """Ask for the units that differ from a name in capitals alone."""
    prefixed = [prefix + unit for unit in _SI if unit not in "1-" for prefix in ("", *_PREFIXES)]
    alike = sorted(one for one in {*prefixed, *_OTHER} if one.lower() == name.lower())
    near = [one for one in alike if one[0] == name[0]] or alike
    return f"; did you mean {' or '.join(near)}?" if near else ""


def split(text: str) -> tuple[str, str] | None:
    """Return number and unit of a text such as 15 mm, 30% or 8 kN s/m; None of another text."""
    found = _QUANTITY.fullmatch(text)
    if _is_number(text):  # 1.0e5
        return None
    return (found[1], found[2].strip()) if found else None


def _is_number(text: str) -> bool:
    """Whether Python reads a text as a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def value_in(text: str, unit: str) -> float:
    """Return the number of a quantity in a unit; `ValueError` if the text is none, or measures something else.

    Examples
    --------
    >>> value_in("15 mm", "m"), value_in("30 %", "-"), value_in("8 kN s/m", "N s/m")
    (0.015, 0.3, 8000.0)
    """
    parts = split(text)
    if parts is None:
        raise ValueError(f"{text!r} is no number with a unit")
    number, given = parts
    mine = parsed_unit(given)
    wanted = parsed_unit(unit)
    if mine.powers != wanted.powers:
        raise ValueError(f"{given} is of another kind")
    return float(Fraction(number) * mine.factor / wanted.factor)
