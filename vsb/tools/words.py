"""Numbers and values in words."""

import csv
import io
import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

POWERS = ((1e7, 1e-6, "MW"), (1e4, 1e-3, "kW"), (0.0, 1.0, "W"))
"""Smallest power [W], factor to its unit, unit."""

PRESSURES = ((1e9, 1e-9, "GPa"), (1e6, 1e-6, "MPa"), (0.0, 1.0, "Pa"))
"""Smallest pressure [Pa], factor to its unit, unit."""

_LARGE = ((1e7, 1e-6, "M"), (1e4, 1e-3, "k"), (0.0, 1.0, ""))
PREFIXES = {
    "N": _LARGE,
    "W": _LARGE,
    "J": _LARGE,
    "Pa": ((1e9, 1e-9, "G"), (1e6, 1e-6, "M"), (1e4, 1e-3, "k"), (0.0, 1.0, "")),
}
"""Smallest value, factor and prefix of units, and of others in terms of them: N s/m, N/m."""

TENFOLD = 900.0
"""Gain from which a multiple is printed instead of per cent [%]."""

SAME_VALUE = 1e-6
"""Relative difference of values up to which no decimals are spent on telling them apart."""

SAME = 0.05
"""Gains below this are printed as 0.0 % [%]."""

LONGEST = 80
"""Most characters of a value repeated in a message."""


def shortened(text: str) -> str:
    """Return a text, cut if it is long."""
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}... ({len(text)} characters)"


def plain(value: float, digits: int = 4) -> str:
    """Return a number of some significant digits without an exponent, if it has no more than 15 digits."""
    return f"{float(f'{value:.{digits}g}'):.15g}"


def short(value: float) -> str:
    """Return a number of three digits, with an exponent where it is tiny or huge."""
    return plain(value, 3) if value == 0 or 1e-3 <= abs(value) < 1e6 else f"{value:.3g}"


def superscripts(unit: str) -> str:
    """Return a unit as it is printed: "m³" of "m^3", as files have it."""
    return unit.replace("^2", "²").replace("^3", "³")


def prefixed(value: float, unit: str) -> tuple[float, str]:
    """Return the factor and the prefix that suit a value of a unit: k, M or G of large ones of N, W, J or Pa.

    Examples
    --------
    >>> prefixed(41600.0, "N s/m"), prefixed(17170.0, "kg")
    ((0.001, 'k'), (1.0, ''))
    """
    known = PREFIXES.get(unit.split()[0].partition("/")[0], ((0.0, 1.0, ""),))
    printed = abs(float(f"{value:.4g}"))  # 9999.99 N is 10 kN, as 10000 N is
    return next((factor, prefix) for least, factor, prefix in known if printed >= least)


def quantity(value: object, unit: str) -> str:
    """Return a value with its unit, `1` for none; pressures of a million pascal and more in MPa or GPa."""
    if not isinstance(value, float):
        return str(value)
    if unit == "Pa":
        factor, unit = next((factor, unit) for least, factor, unit in PRESSURES if abs(value) >= least)
        value *= factor
    return f"{value:g}{'' if unit == '1' else f' {unit}'}"


def watts(values: Sequence[float]) -> tuple[list[str], str]:
    """Return powers [W] to four digits in one unit that suits the largest, and the unit.

    Examples
    --------
    >>> watts([18720.4, 271.04])
    (['18.72', '0.271'], 'kW')
    """
    largest = max(map(abs, values))
    factor, unit = next((factor, unit) for least, factor, unit in POWERS if largest >= least)
    return [plain(factor * value) for value in values], unit


def decimals_of(values: Sequence[tuple[float, float, float]], least: int, most: int) -> int:
    """Return decimals that show the intervals of some values and their differences, between two numbers of them.

    Parameters
    ----------
    values : sequence of (float, float, float)
        Values with their intervals, low and high.
    """
    middle = sorted(value for value, _, _ in values)
    steps = [b - a for a, b in pairwise(middle)] + [(high - low) / 2 for _, low, high in values]
    finest = min((step for step in steps if step > SAME_VALUE * max(map(abs, middle))), default=1.0)
    return min(max(least, math.ceil(-math.log10(finest))), most)


def watts_within(values: Sequence[tuple[float, float, float]]) -> tuple[list[str], str]:
    """Return powers [W] with their intervals in one unit, to four to six digits as the intervals need, and the unit.

    Examples
    --------
    >>> watts_within([(18720.4, 18712.0, 18731.0), (18310.0, 18290.0, 18330.0)])
    (['18.720 (18.712 to 18.731)', '18.310 (18.290 to 18.330)'], 'kW')
    """
    texts, unit = watts_and_ends(values)
    return [within_text(*each) for each in texts], unit


def within_text(value: str, low: str, high: str, unit: str = "") -> str:
    """Return a printed value with its interval, or in words one that its digits do not show.

    Examples
    --------
    >>> within_text("18.72", "18.71", "18.73"), within_text("4601.6", "4601.6", "4601.6")
    ('18.72 (18.71 to 18.73)', '4601.6 (within its last digit)')
    """
    return f"{value}{unit} ({'within its last digit' if low == value == high else f'{low} to {high}{unit}'})"


def watts_and_ends(values: Sequence[tuple[float, float, float]]) -> tuple[list[list[str]], str]:
    """Return the numbers of `watts_within` one by one: value, low and high of each; and the unit."""
    largest = max(abs(value) for value, _, _ in values)
    factor, unit = next((factor, unit) for least, factor, unit in POWERS if largest >= least)
    here = [(factor * value, factor * low, factor * high) for value, low, high in values]
    whole = math.floor(math.log10(factor * largest)) if largest > 0 else 0
    digits = decimals_of(here, max(0, 3 - whole), max(0, 5 - whole))
    return [[f"{number:.{digits}f}" for number in each] for each in here], unit


def gains_within(values: Sequence[tuple[float, float, float]]) -> list[str]:
    """Return gains [%] with their intervals, to two to four decimals as the intervals need.

    Examples
    --------
    >>> gains_within([(4.07, 3.6, 4.4), (-0.0012, -0.0031, 0.0002)])
    ['+4.070 % (+3.600 to +4.400 %)', '-0.001 % (-0.003 to +0.000 %)']
    """
    digits = decimals_of(values, 2, 4)
    texts = [[f"{number:+z.{digits}f}" for number in each] for each in values]
    return [within_text(value, low, high, " %") for value, low, high in texts]


GAIN_DIGITS = 5
"""Most decimals of a gain in per cent."""


def gain_decimals(low: float | None, high: float | None) -> int:
    """Return the decimals that tell the ends of an interval of a gain [%] apart; one without an interval.

    Examples
    --------
    >>> gain_decimals(-3.64, 1.2), gain_decimals(4.4012, 4.4047), gain_decimals(None, None)
    (1, 3, 1)
    """
    if low is None or high is None:
        return 1
    apart = (digits for digits in range(1, GAIN_DIGITS + 1) if round(low, digits) != round(high, digits))
    return next(apart, 1)


def gain_text(gain: float, low: float | None = None, high: float | None = None) -> str:
    """Return a gain [%] with its sign, to the decimals of its interval.

    Examples
    --------
    >>> gain_text(1.021, 1.012, 1.029), gain_text(1.021)
    ('+1.02', '+1.0')
    """
    return f"{gain:+z.{gain_decimals(low, high)}f}"


def interval_text(low: float | None, high: float | None) -> str:
    """Return an interval of a gain in per cent; empty without one, or of no width.

    Examples
    --------
    >>> interval_text(-3.64, 1.2), interval_text(4.4012, 4.4047)
    ('-3.6 to +1.2 %', '+4.401 to +4.405 %')
    """
    if low is None or high is None or low == high:
        return ""
    ends = [gain_text(end, low, high) for end in (low, high)]
    if ends[0] == ends[1]:
        return f"{ends[0]} %, exact to 1e-{GAIN_DIGITS} points"
    return f"{ends[0]} to {ends[1]} %"


def power(value: float, low: float | None = None, high: float | None = None) -> str:
    """Return a power [W] to four digits with a unit that suits it, and with its interval if it has one.

    Examples
    --------
    >>> power(74.1), power(15000.0, 14800.0, 15210.0)
    ('74.1 W', '15 (14.8 to 15.21) kW')
    """
    if low is None or high is None or low == high:
        (text,), unit = watts([value])
        return f"{text} {unit}"
    (text, *ends), unit = watts([value, low, high])
    return f"{text} ({ends[0]} to {ends[1]}) {unit}" if ends[0] != ends[1] else f"{text} {unit}"


def multiple(gain: float) -> str:
    """Return a gain of tenfold and more [%] as a multiple; empty for smaller gains."""
    return f"{1 + gain / 100:.3g} times as much" if gain >= TENFOLD else ""


def the_rigid(name: str) -> str:
    """Return the rigid design in words; its name may already say so."""
    return "the rigid one" if name == "rigid" else f"the rigid {name}"


def against(gain: float, other: str, decimals: int = 1) -> str:
    """Return a gain over another design [%] in words."""
    if abs(gain) < SAME:
        return f"as much as {other}"
    return f"{abs(gain):.{decimals}f} % {'more' if gain > 0 else 'less'} than {other}"


def csv_text(head: Iterable[object], rows: Iterable[Iterable[object]], digits: int = 10) -> str:
    """Return a table as CSV, its numbers with so many digits; an empty cell is a quantity that does not exist."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([f"{v:.{digits}g}" if isinstance(v, float) else v for v in row] for row in rows)
    return text.getvalue()
