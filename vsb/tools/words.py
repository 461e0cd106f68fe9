"""Numbers and values in words."""

from collections.abc import Sequence

POWERS = ((1e7, 1e-6, "MW"), (1e4, 1e-3, "kW"), (0.0, 1.0, "W"))
"""Smallest power [W], factor to its unit, unit."""

PRESSURES = ((1e9, 1e-9, "GPa"), (1e6, 1e-6, "MPa"), (0.0, 1.0, "Pa"))
"""Smallest pressure [Pa], factor to its unit, unit."""

TENFOLD = 900.0
"""Gain from which a multiple is printed instead of per cent [%]."""

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


def power(value: float) -> str:
    """Return a power [W] to four digits with a unit that suits it."""
    (text,), unit = watts([value])
    return f"{text} {unit}"


def multiple(gain: float) -> str:
    """Return a gain of tenfold and more [%] as a multiple; empty for smaller gains."""
    return f"{1 + gain / 100:.3g} times as much" if gain >= TENFOLD else ""


def the_rigid(name: str) -> str:
    """Return the rigid design in words; its name may already say so."""
    return "the rigid one" if name == "rigid" else f"the rigid {name}"


def against(gain: float, other: str) -> str:
    """Return a gain over another design [%] in words."""
    if abs(gain) < SAME:
        return f"as much as {other}"
    return f"{abs(gain):.1f} % {'more' if gain > 0 else 'less'} than {other}"
