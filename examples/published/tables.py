"""Blocks of pages that are written whole: tables, and lines that commands print."""

from collections.abc import Callable, Mapping
from functools import partial

from examples import claims
from examples.published.pages import Values, printed
from examples.published.sources import CONDITIONS, SOURCES

MODELS = ("linear", "exact")
YEAR = {"VSWEC": "VSWEC, free", "VSWEC0": "VSWEC0, clamped at the top", "VSWEC90": "VSWEC90, clamped at the equator"}


def interval(values: Values, name: str, digits: int = 1) -> str:
    """Return a gain with its interval as a cell."""
    gain, low, high = (printed(values[f"{name}.{end}"], f"+.{digits}f") for end in ("percent", "low", "high"))
    return f"{gain} ({low} to {high})"


def table(head: list[str], rows: list[list[str]]) -> str:
    """Return a table in Markdown."""
    lines = [f"| {' | '.join(line)} |" for line in (head, *rows)]
    return "\n".join([lines[0], "|---" * len(head) + "|", *lines[1:]])


def year(values: Values) -> str:
    """Gains of the example's designs over a year."""
    rows = [
        [words, *(interval(values, f"study.year.{size}.{name}.{model}") for size in (1, 4) for model in MODELS)]
        for name, words in YEAR.items()
    ]
    head = ["design", "2 m: linear [%]", "body-exact [%]", "8 m: linear [%]", "body-exact [%]"]
    return table(head, rows)


def last_line(values: Values) -> str:
    """What the example study prints at its end."""
    return f"```text\n{values['study.last_line']}\n```"


def case(name: str, values: Values) -> str:
    """Figures of a case of the claims or surprises, as its script prints them."""
    figures = {key.removeprefix(f"{name}."): value for key, value in values.items() if key.startswith(f"{name}.")}
    conditions = str(figures.pop(CONDITIONS, ""))
    numbers = {key: float(value) for key, value in figures.items()}
    return claims.with_conditions(name.partition(".")[2], numbers, conditions)


BLOCKS: Mapping[str, Callable[[Values], str]] = {
    "year": year,
    "last-line": last_line,
    **{name: partial(case, name) for name in SOURCES if name.startswith(("claims.", "surprises."))},
}
"""By the name in the marker."""
