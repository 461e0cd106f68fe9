"""Blocks of docs/speed.md and of the times in docs/paper.md, from the tables that `make benchmark` leaves."""

import csv
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.coefficients import CORRECTED, PLAIN, ROTATION, SPECTRAL
from benchmarks.compiled_solvers import COMPILED_DOP853, RK4
from benchmarks.general_solvers import SCIPY, SUNDIALS
from benchmarks.measure import seconds_at
from benchmarks.time_domain import BALANCE, BALANCED, CONVOLUTION, EXPONENTIAL, IRREGULAR, PERIODS, REGULAR
from examples.published.pages import Values, printed, table
from vsb.engine.integrators.simulate import EXACT

FOLDER = Path(__file__).parents[2] / "docs" / "published" / "speed"
Row = dict[str, Any]
ERROR = 1e-6
"""At which integrators are compared."""
METHODS = {
    "linear": (EXACT, CONVOLUTION, COMPILED_DOP853, RK4, *SCIPY, SUNDIALS),
    "body-exact": (EXPONENTIAL, COMPILED_DOP853, RK4, *SCIPY, SUNDIALS),
}
"""By model, ours first."""
CALLED = {**{name: f"{name} (SciPy)" for name in SCIPY}, EXACT: "exact propagation"}
GROWTH = {
    "duration": "body-exact run in a JONSWAP sea, stage `simulate` [s of motion]",
    "frequencies": "spectral solver, 7 motions [frequencies]",
    "modes": "`vsb run`, two designs in a regular wave [degree of the modes]",
    "designs": "`vsb run`, likewise, modes to degree 6 [designs]",
    "points": "`vsb run` of a campaign over a year, about equilibrium [springs]",
}
WHOLE = {
    "study": "`buoy.yaml`",
    "campaign": "`year.yaml`, 100 springs, no `verify`",
    "body": "`float.yaml`",
    "design": "`best_buoy.yaml`, one start",
}


def rows_of(name: str) -> list[Row]:
    """Return the rows of a table, numbers as numbers; empty cells are left out."""
    return [{key: _value(text) for key, text in row.items() if text} for row in _lines(name)]


def _lines(name: str) -> list[dict[str, str]]:
    """Rows of a table as they are written."""
    with (FOLDER / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _value(text: str) -> float | str:
    """A number if it is one."""
    try:
        return float(text)
    except ValueError:
        return text


def few(value: float) -> str:
    """Two digits, without a power of ten where it is readable."""
    return f"{float(f'{value:.2g}'):,.10g}".replace(",", " ")


def scientific(value: float) -> str:
    """An error with one digit."""
    return printed(value, ".0e") if value else "0"


def machine(values: Values) -> str:
    """What was measured, and where."""
    known = {row["name"]: row["value"] for row in _lines("machine")}
    versions = ", ".join(f"{name} {known[name]}" for name in ("vsb", "capytaine", "numpy", "scipy", "numba", "python"))
    return (
        f"Measured with {versions} on {known['processor']}, {known['cores']} cores, load {known['load']} at first.\n"
        "Times are those one thread keeps a processor busy. On another machine all of them change, their ratios less."
    )


def coefficients(values: Values) -> str:
    """Errors, seconds and memory of coefficients, and what they say at equal error."""
    rows = [row for row in rows_of("coefficients") if "error" in row]
    lines = [
        [
            row["method"],
            *(f"{row[key]:.0f}" for key in ("setting", "unknowns")),
            printed(row["error"], ".1e"),
            few(1e3 * row["seconds"]),
            few(row["memory_mb"]),
        ]
        for row in rows
    ]
    head = ["method", "rows or nodes", "unknowns", "largest error", "ms per frequency", "memory [MB]"]
    found = []
    for base in (ROTATION, PLAIN):
        finest = max((row for row in rows if row["method"] == base), key=lambda row: float(row["setting"]))
        times = []
        for name in (CORRECTED, SPECTRAL):
            seconds, better = seconds_at(rows, name, finest["error"])
            times.append(f"{name}: {'more than ' if better else ''}{few(finest['seconds'] / seconds)}")
        found.append(
            f"How many times faster at the error of {base} with {finest['setting']:.0f} rows, "
            f"{printed(finest['error'], '.0e')}: {'; '.join(times)}."
        )
    return table(head, lines) + "\n\n" + "\n\n".join(found)


def integrators(model: str, values: Values) -> str:
    """Milliseconds of every method at equal error in both seas."""
    measured = [row for row in rows_of("motion") if row["table"] == "integrators"]
    cases = {sea: [row for row in measured if row["case"] == f"{model}, {sea}"] for sea in (REGULAR, IRREGULAR)}
    ours = METHODS[model][0]
    lines = []
    for method in METHODS[model]:
        cells = [CALLED.get(method, method)]
        for rows in cases.values():
            first, _ = seconds_at(rows, ours, ERROR)
            seconds, better = seconds_at(rows, method, ERROR)
            cells += [_at_most(1e3 * seconds, better), "" if method == ours else _at_most(seconds / first, better)]
        lines.append(cells)
    return table(["method", *(text for sea in cases for text in (f"{sea} [ms]", "times ours"))], lines)


def _at_most(value: float, better: bool) -> str:
    """A value, or a bound where the coarsest run is better already, or a dash where no run is as good."""
    return f"{'≤ ' if better else ''}{few(value)}" if np.isfinite(value) else "not reached"


def ours(values: Values) -> str:
    """Error beside the time of our integrators in each scene."""
    rows, lines = [row for row in rows_of("motion") if row["table"] == "integrators"], []
    states = max(float(row["setting"]) for row in rows if row["method"] == EXACT)
    shown = [(EXACT, states), *((EXPONENTIAL, tolerance) for tolerance in (1e-4, 1e-6, 1e-8))]
    for row in rows:
        if (row["method"], row["setting"]) in shown and "error" in row:
            setting = f"{row['setting']:.0f} states" if row["method"] == EXACT else printed(row["setting"], ".0e")
            known = CALLED.get(row["method"], row["method"])
            lines.append([row["case"], known, setting, scientific(row["error"]), few(1e3 * row["seconds"])])
    return table(["scene", "method", "memory states, tolerance", "error of heave", "ms"], lines)


def mean_power(values: Values) -> str:
    """Error and seconds of the mean power of the steady state."""
    lines = []
    for row in rows_of("motion"):
        if row["table"] == "power" and row["setting"] in (*BALANCED, *PERIODS[1:4]):
            exact = row["method"] == BALANCE
            setting = printed(row["setting"], ".0e") if exact else f"{row['setting']:.0f} periods"
            lines.append([row["method"], setting, scientific(row["error"]), few(1e3 * row["seconds"])])
    return table(["mean power of the steady state, body-exact", "tolerance, length", "relative error", "ms"], lines)


def growth(values: Values) -> str:
    """Seconds and errors at three sizes, and the power of the size by which seconds grow between the last two."""
    rows, lines = rows_of("growth"), []
    for direction, words in GROWTH.items():
        if not (some := [row for row in rows if row["direction"] == direction]):
            continue
        size, seconds = ([float(row[key]) for row in some] for key in ("size", "seconds"))
        power = np.log(seconds[-1] / seconds[-2]) / np.log(size[-1] / size[-2])
        errors = [scientific(row["error"]) if "error" in row else "reference" for row in some]
        lines.append(
            [words, *("; ".join(cells) for cells in (map(few, size), map(few, seconds), errors)), f"{power:.1f}"]
        )
    return table(["what", "sizes", "CPU s", "error", "grows with power"], lines)


def shares(values: Values) -> str:
    """Percent of the processor time of whole commands by part."""
    rows = rows_of("shares")
    spent = {(row["command"], row["part"]): float(row["seconds"]) for row in rows}
    total = {name: sum(value for (one, _), value in spent.items() if one == name) for name in WHOLE}
    total = {name: seconds for name, seconds in total.items() if seconds}
    parts = sorted({part for _, part in spent}, key=lambda part: -sum(spent.get((one, part), 0.0) for one in total))
    lines = [[part, *(f"{100 * spent.get((one, part), 0.0) / total[one]:.0f}" for one in total)] for part in parts]
    lines = [line for line in lines if set(line[1:]) != {"0"}]
    head = ["CPU time [%]", *(WHOLE[one] for one in total)]
    return table(head, [*lines, ["all [CPU s]", *(few(seconds) for seconds in total.values())]])


def paper(values: Values) -> str:
    """Times of the paper's designs beside the published ones, and other integrators on its last one."""
    rows = rows_of("paper")
    lines = [
        [
            row["case"],
            few(row["published_seconds"]),
            few(1e3 * row["seconds"]),
            *(scientific(row[key]) for key in ("error", "error_energy")),
        ]
        for row in rows
        if row["table"] == "paper"
    ]
    head = ["design", "published [s]", "ours [ms]", "error of heave", "error of energy"]
    some = [row for row in rows if row["table"] == "integrators" and row["case"] == lines[-1][0]]
    others = []
    for method in METHODS["body-exact"]:
        done = [row for row in some if row["method"] == method and "error" in row]
        ends = sorted(done, key=lambda row: float(row["seconds"]))
        if ends:
            cells = [f"{scientific(row['error'])} in {few(1e3 * row['seconds'])} ms" for row in (ends[0], ends[-1])]
            others.append([CALLED.get(method, method), *cells])
    return f"{table(head, lines)}\n\n{lines[-1][0]}, error of heave by method:\n\n" + table(
        ["method", "quickest run", "longest run"], others
    )


def block(name: str, write: Callable[[Values], str]) -> Callable[[Values], str]:
    """Return what writes a block from a table, or says that there is none."""
    missing = "*Not measured with this version yet: `make benchmark`.*"
    return lambda values: write(values) if (FOLDER / f"{name}.csv").exists() else missing


BLOCKS: Mapping[str, Callable[[Values], str]] = {
    "speed.machine": block("machine", machine),
    "speed.coefficients": block("coefficients", coefficients),
    "speed.linear": block("motion", partial(integrators, "linear")),
    "speed.body-exact": block("motion", partial(integrators, "body-exact")),
    "speed.ours": block("motion", ours),
    "speed.power": block("motion", mean_power),
    "speed.growth": block("growth", growth),
    "speed.shares": block("shares", shares),
    "speed.paper": block("paper", paper),
}
"""By the name in the marker."""
