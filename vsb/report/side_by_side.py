"""Finished studies and campaigns side by side: as text, as CSV, as one page of HTML with a figure."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vsb.report.campaign_answer import TUNED
from vsb.report.canvas import drawn, grid_of_axes, legend_above, style
from vsb.report.page import page
from vsb.tools.variables import FORCE
from vsb.tools.words import csv_text, gain_decimals, interval_text, plain, superscripts


class Line(NamedTuple):
    """One design of a study in one sea, or of a point of a campaign over its year; none: there is no such number."""

    study: str
    point: str  # what is varied of a campaign, in words
    design: str
    sea: str  # of a campaign its climate
    tuning: str
    power_mean: float | None  # [W]
    gain_percent: float | None  # over the rigid design under the same tuning
    damping: float | None  # in its unit
    capture_width: float | None  # [m]
    annual_energy: float | None  # [MWh]
    damping_unit: str = FORCE.damping_unit
    power_low: float | None = None  # interval of the mean power by all known errors [W]
    power_high: float | None = None
    low: float | None = None  # of the gain [%]
    high: float | None = None


COLUMNS = {
    "study": "study", "point": "point", "design": "design", "sea": "sea", "tuning": "tuning",
    "power_mean": "power [W]", "power_low": "from [W]", "power_high": "to [W]",
    "gain_percent": "gain [%]", "low": "from [%]", "high": "to [%]",
    "damping": "damper", "capture_width": "width [m]", "annual_energy": "MWh/year", "damping_unit": "damper in",
}  # fmt: skip
"""Columns of the table with their heads."""
GAINS = ("gain_percent", "low", "high")
MEASURES = {
    "gain_percent": "gain over the rigid design [%]",
    "capture_width": "capture width [m]",
    "power_mean": "power [W]",
}
"""What the figure shows of every line: the first two that are known."""
BOUNDS = {"gain_percent": ("low", "high"), "power_mean": ("power_low", "power_high")}
"""Bounds of the interval of a measure."""
DOUBTS = (
    "Mean powers and gains are those of the reports at the tuning of their row, with the interval of all known errors: "
    "each: every design at its optimal damping in each sea; fixed: at the given one; one: at its best for all seas.",
    "They are by linear theory; by runs in time where those are not linear and have this damper. At another damper the "
    "interval then contains what linear theory leaves out.",
    "Each gain is over the rigid design of the same study; studies of other sizes and waters also differ in power.",
    "Doubts are in the reports.",
)
EQUAL = 0.05
"""Gain that would be printed as 0.0 [%]."""
MOST_POINTS = 24
"""Points of a campaign a table shows; the file holds all."""


def as_text(lines: Sequence[Line]) -> str:
    """Return a table for a terminal, numbers to the right; columns nobody has are left out."""
    cells = _table(_shown(lines))
    kept = [j for j in range(len(cells[0])) if any(row[j] not in ("", "-") for row in cells[1:])]
    widths = {j: max(len(row[j]) for row in cells) for j in kept}
    text = [
        "  ".join(row[j].rjust(widths[j]) if j > 4 else row[j].ljust(widths[j]) for j in kept).rstrip() for row in cells
    ]
    left = len(lines) - len(_shown(lines))
    return "\n".join([*text, *([f"{left} more lines with --out FILE.csv"] if left else [])])


def _table(lines: Sequence[Line]) -> list[list[str]]:
    """Heads and cells of a table; the unit of dampers stands in their head, in a column where there are several."""
    cells = [list(COLUMNS.values()), *([_cell(line, field) for field in COLUMNS] for line in lines)]
    if len(units := {line.damping_unit for line in lines}) == 1:
        cells = [row[:-1] for row in cells]
        cells[0][list(COLUMNS).index("damping")] = f"damping [{superscripts(units.pop())}]"
    return cells


def _shown(lines: Sequence[Line]) -> list[Line]:
    """Lines of the first points of every campaign."""
    points = {(line.study, line.point): None for line in lines}
    first = {study: [point for name, point in points if name == study][:MOST_POINTS] for study, _ in points}
    return [line for line in lines if line.point in first[line.study]]


def _cell(line: Line, field: str) -> str:
    """A value of a line as a table shows it; gains to the decimals their interval resolves."""
    value = getattr(line, field)
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    return f"{value:+z.{gain_decimals(line.low, line.high)}f}" if field in GAINS else plain(value)


def as_csv(lines: Sequence[Line]) -> str:
    """Return all lines as CSV; an empty cell is a number there is none of."""
    return csv_text(Line._fields, lines, 12)


def as_page(lines: Sequence[Line], reports: Mapping[str, tuple[str, str]], left_out: Sequence[str] = ()) -> str:
    """Return a page with everything inside: where flexibility brings most, a figure, the table.

    `reports` are path, as seen from the page, and content id by name; `left_out` says what has no line.
    """
    shown = _shown(lines)
    head, *body = _table(shown)
    return page(
        "side_by_side.html.j2",
        names=list(reports),
        answer=[answer(lines)],
        below=[],
        sketches=(),
        warnings=(*DOUBTS, *left_out),
        interactive="",
        animated=None,
        still="",
        reports={name: path for name, (path, _) in reports.items()},
        figure=drawn(figure(shown), "side_by_side").svg,
        head=head,
        body=body,
        left_out=len(lines) - len(shown),
        figures=(),
        facts={name: identity for name, (_, identity) in reports.items()},
    )


def answer(lines: Sequence[Line]) -> str:
    """Return in one sentence where flexibility brings most; without gains, which design absorbs most."""
    lines = _leading(lines)
    gains = [(line.gain_percent, line) for line in lines if line.gain_percent is not None and line.gain_percent != 0]
    if gains:
        gain, best = max(gains, key=lambda one: one[0])
        subject, rigid = f"in {_place(best)}: design {best.design} absorbs", f"the rigid one ({_under(best)})."
        interval, decimals = interval_text(best.low, best.high), gain_decimals(best.low, best.high)
        known = f" ({interval})" if interval else ""
        if gain >= EQUAL:
            return f"Flexibility brings most {subject} {gain:.{decimals}f} % more{known} than {rigid}"
        how = "as much as" if gain > -EQUAL else f"{-gain:.{decimals}f} % less{known} than"
        return f"Flexibility brings nothing here; at best, {subject} {how} {rigid}"
    powers = [(line.power_mean, line) for line in lines if line.power_mean is not None]
    if not powers:
        return "No design is viable."
    power, most = max(powers, key=lambda one: one[0])
    return f"Most power in {_place(most)}: design {most.design} absorbs {plain(power)} W ({_under(most)})."


def _leading(lines: Sequence[Line]) -> list[Line]:
    """Lines under the first tuning of each place: every design at its own best damper where that is known."""
    first: dict[str, str] = {}
    return [line for line in lines if first.setdefault(_place(line), line.tuning) == line.tuning]


def _under(line: Line) -> str:
    """Tuning of a line, or the law of its take-off, in words."""
    return TUNED.get(line.tuning, f"under the law {line.tuning}")


def _place(line: Line) -> str:
    """Study, point and sea of a line, in words."""
    return ", ".join(part for part in (line.study, line.point, line.sea) if part)


def figure(lines: Sequence[Line]) -> Figure:
    """Draw gain and capture width of every design, a row for each sea of a study and each point of a campaign."""
    lines = _leading(lines)
    rows = list(dict.fromkeys(_place(line) for line in lines))
    designs = list(dict.fromkeys(line.design for line in lines))
    known = [kind for kind in MEASURES if any(getattr(line, kind) is not None for line in lines)]
    kinds = known[:2] or ["power_mean"]
    reference = next((line.design for line in lines if line.gain_percent == 0), None)  # gains are over it
    looks = {
        design: style(design, designs, reference) | {"linestyle": "none", "marker": "osD^v"[i % 5]}
        for i, design in enumerate(designs)
    }
    canvas, axes = grid_of_axes(1.1 + 0.22 * len(rows), columns=len(kinds), sharey=True)
    for ax, kind in zip(axes[0], kinds, strict=True):
        for design in designs:
            _mark(ax, [line for line in lines if line.design == design], kind, rows, looks[design])
        ax.set_xlabel(MEASURES[kind])
        ax.margins(x=0.08)
    axes[0, 0].set_yticks(range(len(rows)), rows, fontsize=8)
    axes[0, 0].set_ylim(len(rows) - 0.5, -0.5)
    legend_above(canvas, axes[0, 0])
    return canvas


def _mark(ax: Axes, lines: Sequence[Line], kind: str, rows: Sequence[str], look: Mapping[str, Any]) -> None:
    """Mark one measure of one design in every row that has it."""
    known = [(getattr(line, kind), rows.index(_place(line))) for line in lines if getattr(line, kind) is not None]
    values, at = ([pair[k] for pair in known] for k in (0, 1))
    for line in lines if kind in BOUNDS else ():
        low, high = (getattr(line, name) for name in BOUNDS[kind])
        if low is not None and high is not None:
            ax.plot([low, high], 2 * [rows.index(_place(line))], color=look["color"], linewidth=1.5, alpha=0.5)
    ax.plot(values, at, markersize=4, alpha=0.8, **look)
    if kind == "gain_percent":
        ax.axvline(0.0, color="#444444", linewidth=0.8, label="_zero")
