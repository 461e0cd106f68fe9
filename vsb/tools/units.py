"""Units of measurement as files write them: one parser for spectra, tables, records and netCDF.

Imports nothing heavy: the Snakefile reads a study at every parse.
"""

import math
import re
from typing import NamedTuple

from vsb.tools.words import LONGEST

DIMENSIONS = ("m", "s", "rad", "deg", "cycle")
"""What powers are of. Angles keep their names, since a density per degree is another one than per radian per second."""


class Unit(NamedTuple):
    """A product of powers."""

    factor: float  # of the unit, in the product of `DIMENSIONS` to their powers
    powers: tuple[int, ...]

    def times(self, other: "Unit", power: int) -> "Unit":
        """Return the product with a power of another unit."""
        powers = tuple(a + power * b for a, b in zip(self.powers, other.powers, strict=True))
        return Unit(self.factor * other.factor**power, powers)


def _one(factor: float = 1.0, **powers: int) -> Unit:
    """A unit by its powers."""
    return Unit(factor, tuple(powers.get(name, 0) for name in DIMENSIONS))


ONE = _one()
_NAMES = {
    "m metre metres meter meters": _one(m=1),
    "cm centimetre centimetres centimeter centimeters": _one(1e-2, m=1),
    "mm millimetre millimetres millimeter millimeters": _one(1e-3, m=1),
    "ft foot feet": _one(0.3048, m=1),
    "s sec secs second seconds": _one(s=1),
    "ms msec millisecond milliseconds": _one(1e-3, s=1),
    "min mins minute minutes": _one(60.0, s=1),
    "h hr hrs hour hours": _one(3600.0, s=1),
    "d day days": _one(86400.0, s=1),
    "hz hertz cps": _one(s=-1, cycle=1),
    "mhz millihertz": _one(1e-3, s=-1, cycle=1),
    "cycle cycles": _one(cycle=1),
    "rad rads radian radians": _one(rad=1),
    "deg degr degree degrees °": _one(deg=1),
    "% percent": _one(1e-2),
    "-": ONE,
}
UNITS = {name: unit for names, unit in _NAMES.items() for name in names.split()}
"""Units by their names in small letters: no file of waves holds megametres or millimolars."""
METRE, SECOND = UNITS["m"].powers, UNITS["s"].powers
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻\u2212", "0123456789--")
_TOKEN = re.compile(r"\*\*|\^|[*·.\u00d7]|/|[()]|[-+]?\d+|[a-z°%]+|-")


def unit(text: str) -> Unit | None:
    """Return the unit a text means, None if it means none.

    Products of names and their powers: `m^2/Hz`, `m2 s rad-1`, `m**2.s`, `(meter*meter)/Hz`, `m²·s/rad`.
    """
    if not 0 < len(text) <= LONGEST:
        return None
    plain = re.sub(r"[{}$\\]", "", text.translate(_RAISED).lower()).replace(" per ", "/").strip()
    if plain in UNITS:
        return UNITS[plain]
    tokens = _TOKEN.findall(plain)
    if "".join(tokens) != "".join(plain.split()):
        return None
    found = _product(tokens)
    return None if tokens else found


def _product(tokens: list[str]) -> Unit | None:
    """The product of some tokens up to a closing bracket, which are taken from the list."""
    found, sign, any_there = ONE, 1, False
    while tokens and tokens[0] != ")":
        token = tokens.pop(0)
        if token in "*·.\u00d7-":
            continue
        if token == "/":
            sign = -1
            continue
        factor = UNITS.get(token) if token != "1" else ONE
        if token == "(":
            factor = _product(tokens)
            if not tokens or tokens.pop(0) != ")":
                return None
        if factor is None:
            return None
        if tokens and tokens[0] in ("^", "**"):
            tokens.pop(0)
        power = int(tokens.pop(0)) if tokens and re.fullmatch(r"[-+]?\d", tokens[0]) else 1
        found, sign, any_there = found.times(factor, sign * power), 1, True
    return found if any_there and sign == 1 else None


def scale(text: str, powers: tuple[int, ...]) -> float | None:
    """Return the factor from a unit of some powers, as `METRE` or `SECOND`, to that of SI; None if it has others."""
    found = unit(text)
    return found.factor if found and found.powers == powers else None


class Frequency(NamedTuple):
    """How to turn numbers of a unit into frequencies [Hz]."""

    factor: float  # of a frequency to Hz, or of a period to s
    angular: bool = False  # radians per second
    period: bool = False


def frequency(text: str) -> Frequency | None:
    """Return what a unit of frequencies, or of periods, means; one over a second is a hertz."""
    if (found := unit(text)) is None:
        return None
    meanings = {
        _one(s=-1, cycle=1).powers: Frequency(found.factor),
        _one(s=-1).powers: Frequency(found.factor),
        _one(s=-1, rad=1).powers: Frequency(found.factor / (2 * math.pi), angular=True),
        _one(s=-1, deg=1).powers: Frequency(found.factor / 360.0),
        SECOND: Frequency(found.factor, period=True),
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
        _one(m=2, s=1, cycle=-1, rad=-1).powers: 1.0,
        _one(m=2, s=1, cycle=-1, deg=-1).powers: 180 / math.pi,
        _one(m=2, s=1, rad=-2).powers: 2 * math.pi,
        _one(m=2, s=1, rad=-1, deg=-1).powers: 360.0,
    }
    if not axis.angular:  # else these do not say whether the density is per angle or per radian per second
        per_angle |= {
            _one(m=2, s=1, rad=-1).powers: 1.0,
            _one(m=2, s=1, deg=-1).powers: 180 / math.pi,
        }
    over_all = {
        _one(m=2, s=1, cycle=-1).powers: 1.0,
        _one(m=2, s=1).powers: 2 * math.pi if axis.angular else 1.0,
        _one(m=2, s=1, rad=-1).powers: 2 * math.pi,
    }
    factor = (per_angle if directional else over_all).get(found.powers)
    return None if factor is None else factor * found.factor


def number(cell: str) -> float | None:
    """Return a cell as a number, NaN where that stands there; a single comma without a point is a decimal comma."""
    plain = cell.replace(",", ".") if cell.count(",") == 1 and "." not in cell else cell
    try:
        return float(plain) if "_" not in plain else None
    except ValueError:
        return None
