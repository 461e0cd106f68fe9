"""Units of measurement: what "kN s/m", "15 mm" or "m^2/Hz" measures, and how much of it.

Factors are fractions, so that 15 mm is the very number 0.015, and both have one id. Symbols are those of SI, in which
MPa and mPa differ; in headers of files of waves capitals mean nothing. Imports nothing heavy: the Snakefile reads a
study at every parse.
"""

import math
import re
from fractions import Fraction
from functools import cache
from typing import NamedTuple

from vsb.tools.words import LONGEST, shortened

DIMENSIONS = ("m", "kg", "s", "rad", "deg", "cycle")
"""Units all others are products of. Angles are among them, so that rad/s, Hz and 1/s are three; and each of them, as
a density per degree is another one than per radian per second."""
_UNITS = {
    "1": ("1", ""), "-": ("1", ""), "%": ("0.01", ""), "g": ("0.001", "kg"), "t": ("1000", "kg"),
    "lb": ("0.45359237", "kg"), "min": ("60", "s"), "h": ("3600", "s"), "d": ("86400", "s"), "in": ("0.0254", "m"),
    "ft": ("0.3048", "m"), "yd": ("0.9144", "m"), "mi": ("1609.344", "m"), "nmi": ("1852", "m"), "l": ("0.001", "m^3"),
    "Hz": ("1", "cycle/s"), "rpm": ("1", "cycle/min"), "N": ("1", "kg m/s^2"), "lbf": ("4.4482216152605", "N"),
    "kgf": ("9.80665", "N"), "J": ("1", "N m"), "W": ("1", "J/s"), "Pa": ("1", "N/m^2"), "bar": ("1e5", "Pa"),
    "mbar": ("100", "Pa"), "atm": ("101325", "Pa"), "psi": ("6894.757293168361", "Pa"),
    "ksi": ("6894757.293168361", "Pa"),
}  # fmt: skip
"""Symbol -> how much of which product."""
_SPELLINGS = {
    "m": "metre metres meter meters", "cm": "centimetre centimetres centimeter centimeters",
    "mm": "millimetre millimetres millimeter millimeters", "in": "inch inches", "ft": "foot feet",
    "s": "sec secs second seconds", "ms": "msec millisecond milliseconds", "min": "mins minute minutes",
    "h": "hr hrs hour hours", "d": "day days", "Hz": "hertz cps", "mHz": "millihertz", "cycle": "cycles",
    "rad": "rads radian radians", "deg": "degr degree degrees °", "t": "tonne tonnes", "lb": "lbs", "%": "percent",
    "l": "L", "-": "", "1": "",
}  # fmt: skip
_SYMBOLS = {name: symbol for symbol, names in _SPELLINGS.items() for name in names.split()}
"""Other spelling -> symbol."""
_IN_HEADERS = {
    name.lower(): symbol
    for symbol, names in _SPELLINGS.items()
    for name in (symbol, *names.split())
    if symbol not in ("in", "t", "lb", "l")
}
"""Name in small letters -> symbol, of what files of waves hold: no megahertz, and t is a time, no tonne."""
_PREFIXED = ("m", "g", "s", "rad", "N", "Pa", "J", "W", "Hz")
_PREFIXES = {"G": 9, "M": 6, "k": 3, "m": -3, "µ": -6, "u": -6, "n": -9}
_OF_FEW = {"h": (2, "Pa"), "d": (-1, "m"), "c": (-2, "m")}
"""Prefixes of one unit: hPa, dm, cm."""
_QUANTITY = re.compile(
    r"\s*([+-]?(?:\d{1,40}\.?\d{0,40}|\.\d{1,40})(?:[eE][+-]?\d{1,3})?)\s*([^\W\d_].*|[%°].*|1/.+)", re.DOTALL
)
_TOKEN = re.compile(r"[^\W\d_]+|(?:\^|\*\*)?\s*[-+]?\d+(?:\.\d+)?|\*\*|\S")
_POWER = re.compile(r"(?:\^|\*\*)?\s*([-+]?\d(?:\.\d)?)")
_PLAIN = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻\u2212μ", "0123456789--µ", "{}$\\")


class Unit(NamedTuple):
    """How much of the product of `DIMENSIONS`, and the power of each of them."""

    factor: Fraction
    powers: tuple[Fraction, ...]

    def times(self, other: "Unit", power: Fraction = Fraction(1)) -> "Unit":
        """Return the product with a power of another unit."""
        factor = Fraction(other.factor**power)  # a float of a root
        powers = (mine + power * its for mine, its in zip(self.powers, other.powers, strict=True))
        return Unit(self.factor * factor, tuple(powers))

    def in_radians(self) -> "Unit":
        """Return the unit with degrees and cycles as radians."""
        *others, rad, deg, cycle = self.powers
        factor = Fraction((_PI / 180) ** deg) * Fraction((2 * _PI) ** cycle)
        return Unit(self.factor * factor, (*others, rad + deg + cycle, Fraction(0), Fraction(0)))


def _powers(**powers: int) -> tuple[Fraction, ...]:
    """Powers of `DIMENSIONS` by name."""
    return tuple(Fraction(powers.get(name, 0)) for name in DIMENSIONS)


_PI = Fraction(math.pi)
ONE = Unit(Fraction(1), _powers())
METRE, SECOND = _powers(m=1), _powers(s=1)


def parsed_unit(text: str) -> Unit:
    """Return a unit such as kN s/m, kg/m3, N-m, rad/(m s) or %, its angles in radians; `ValueError` if it is none."""
    return _parsed(text).in_radians()


def unit(text: str) -> Unit | None:
    """Return the unit a header means, such as m^2/Hz, M2 s rad-1 or (meter*meter)/hertz; None if it means none."""
    try:
        return _parsed(text, in_header=True)
    except ValueError:
        return None


@cache
def _parsed(text: str, in_header: bool = False) -> Unit:
    """A unit whose angles keep their names."""
    plain = re.sub(r"\s+per\s+", "/", text.translate(_PLAIN).strip(), flags=re.IGNORECASE)
    if len(text) > LONGEST:
        raise ValueError(f"{shortened(text)!r} is no unit")
    tokens = _TOKEN.findall(plain)
    found = _symbol(plain, in_header) if plain == "-" else _product(tokens, in_header)
    if tokens and plain != "-":
        raise ValueError(f"{text!r} is no unit: a bracket is closed that is not open")
    return found


def _product(tokens: list[str], in_header: bool) -> Unit:
    """The product of the factors up to a closing bracket; / divides by the factor behind it alone."""
    found: Unit | None = None
    sign = 1
    while tokens and tokens[0] != ")":
        token = tokens.pop(0)
        if token in "*·⋅\u00d7.-":
            continue
        if token == "/" and sign == 1 and tokens:
            sign = -1
            continue
        one = _product(tokens, in_header) if token == "(" else _symbol(token, in_header)
        if token == "(" and (not tokens or tokens.pop(0) != ")"):
            raise ValueError("a bracket of the unit is not closed")
        power = _POWER.fullmatch(tokens[0]) if tokens else None
        if power:
            tokens.pop(0)
        found, sign = (found or ONE).times(one, sign * Fraction(power[1] if power else 1)), 1
    if found is None or sign == -1:
        raise ValueError("a unit is missing")
    return found


def _symbol(name: str, in_header: bool = False) -> Unit:
    """A unit by its symbol, with a prefix or none."""
    symbol = _IN_HEADERS.get(name.lower(), "") if in_header else _SYMBOLS.get(name, name)
    prefix, rest = symbol[:1], symbol[1:]
    if symbol in DIMENSIONS:
        return Unit(Fraction(1), _powers(**{symbol: 1}))
    if symbol in _UNITS:
        factor, product = _UNITS[symbol]
        return Unit(Fraction(factor), ONE.powers).times(_parsed(product) if product else ONE)
    if prefix in _PREFIXES and rest in _PREFIXED:
        return Unit(Fraction(10) ** _PREFIXES[prefix], ONE.powers).times(_symbol(rest))
    if prefix in _OF_FEW and rest == _OF_FEW[prefix][1]:
        return Unit(Fraction(10) ** _OF_FEW[prefix][0], ONE.powers).times(_symbol(rest))
    if run_together := re.fullmatch(r"([kMG]?N)([ms])", symbol):  # kNm
        return _symbol(run_together[1]).times(_symbol(run_together[2]))
    raise ValueError(f"{name!r} is no unit known here{_meant(name)}")


def _meant(name: str) -> str:
    """Ask for the units that differ from a name in capitals alone."""
    prefixed = [prefix + one for one in _PREFIXED for prefix in ("", *_PREFIXES)]
    alike = sorted(one for one in {*prefixed, *_UNITS} if one.lower() == name.lower())
    near = [one for one in alike if one[0] == name[0]] or alike
    return f"; did you mean {' or '.join(near)}?" if near else ""


def split(text: str) -> tuple[str, str] | None:
    """Return number and unit of a text such as 15 mm, 30% or 8 kN s/m; None of another text."""
    found = _QUANTITY.fullmatch(text)
    if is_number(text):  # 1.0e5
        return None
    return (found[1], found[2].strip()) if found else None


def is_number(text: str) -> bool:
    """Return whether Python reads a text as a number."""
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


def scale(text: str, powers: tuple[Fraction, ...]) -> float | None:
    """Return the factor from a unit of some powers, as `METRE` or `SECOND`, to that of SI; None if it has others."""
    found = unit(text)
    return float(found.factor) if found and found.powers == powers else None


class Frequency(NamedTuple):
    """How to turn numbers of a unit into frequencies [Hz]."""

    factor: float  # of a frequency to Hz, or of a period to s
    angular: bool = False  # radians per second
    period: bool = False


def frequency(text: str) -> Frequency | None:
    """Return what a unit of frequencies, or of periods, means; one over a second is a hertz."""
    if (found := unit(text)) is None:
        return None
    factor = float(found.factor)
    meanings = {
        _powers(s=-1, cycle=1): Frequency(factor),
        _powers(s=-1): Frequency(factor),
        _powers(s=-1, rad=1): Frequency(factor / (2 * math.pi), angular=True),
        _powers(s=-1, deg=1): Frequency(factor / 360.0),
        SECOND: Frequency(factor, period=True),
    }
    return meanings.get(found.powers)


def density(text: str, axis: Frequency, directional: bool) -> float | None:
    """Return the factor from a unit of spectral density to m^2/Hz, over directions to m^2/Hz/rad; None if it is none.

    Parameters
    ----------
    text : str
        Metres squared times seconds are per hertz, or per radian per second if the frequencies are in that.
    axis : Frequency
    directional : bool
        Whether the density is over directions as well.
    """
    if (found := unit(text)) is None:
        return None
    per_angle = {
        _powers(m=2, s=1, cycle=-1, rad=-1): 1.0,
        _powers(m=2, s=1, cycle=-1, deg=-1): 180 / math.pi,
        _powers(m=2, s=1, rad=-2): 2 * math.pi,
        _powers(m=2, s=1, rad=-1, deg=-1): 360.0,
    }
    if not axis.angular:  # else these do not say whether the density is per angle or per radian per second
        per_angle |= {_powers(m=2, s=1, rad=-1): 1.0, _powers(m=2, s=1, deg=-1): 180 / math.pi}
    over_all = {
        _powers(m=2, s=1, cycle=-1): 1.0,
        _powers(m=2, s=1): 2 * math.pi if axis.angular else 1.0,
        _powers(m=2, s=1, rad=-1): 2 * math.pi,
    }
    factor = (per_angle if directional else over_all).get(found.powers)
    return None if factor is None else factor * float(found.factor)


def number(cell: str) -> float | None:
    """Return a cell as a number, NaN where that stands there; a single comma without a point is a decimal comma."""
    plain = cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell
    try:
        return float(plain) if "_" not in plain else None
    except ValueError:
        return None
