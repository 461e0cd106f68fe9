"""The self-contained HTML report of a study: the answer first, then the evidence, then what to doubt.

First what the pages of studies, campaigns, designs and comparisons have in common.
"""

import importlib.resources
import itertools
import math
import re
import urllib.parse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jinja2
import markupsafe
import numpy as np
import xarray as xr

from vsb.engine.motion.take_off import DAMPERS, port_kind
from vsb.report.answer import (
    AT_FORCE,
    COMPUTED,
    ELSEWHERE,
    GIVEN,
    MISSING,
    NO_OPTIMUM,
    PARTS,
    Answer,
    advice,
    at_force_statements,
    at_force_table,
    cell,
    conversion_text,
    damping_in_words,
    elsewhere_table,
    gain_in_brackets,
    headline,
    knowledge_text,
    limited_statements,
    limits_aside,
    no_answer,
    parts_table,
    shares_text,
    tuned_statements,
    tuning_head,
    tuning_table,
    useful_band,
    warnings,
)
from vsb.report.figures import captions
from vsb.report.interactive import as_script, in_motion
from vsb.study.figure_names import FIGURE_KINDS
from vsb.tools.arrays import FloatArray
from vsb.tools.variables import FORCE, PortKind
from vsb.tools.words import csv_text, gain_decimals, multiple, plain, power, short, superscripts, the_rigid

INLINE = 1_000_000
"""Most bytes of figures inside a page; further ones are only linked."""
SCRIPTS = ("algebra.js", "chart.js", "interactive.js", "interactive_year.js", "buoys.js", "start.js")
"""Scripts of every page, in this order; the page can be read without them."""
FOLDED = {
    "radiation_kernel": "Radiation kernel",
    "witness": "Cross-check of two solvers",
    "energy_audit": "Energy balance",
}
"""Figures for specialists, folded under these titles."""
SECTION = re.compile(r'<section id="(\w+)">\s*<h2>(.*?)</h2>')
VERBATIM = re.compile(r"(<(?:script|style|svg|pre|code)\b.*?</(?:script|style|svg|pre|code)>|<[^>]*>)", re.DOTALL)
MINUS = "\N{MINUS SIGN}"
HYPHEN = re.compile(r"(?<![\w.)-])-(?=[\d.]*\d)")
"""A hyphen that is the sign of a number: not in 2026-11-29, e-05 or a name."""
CONTENTS = '<nav aria-label="Contents"></nav>'
"""Place of the table of contents in a page."""
NO_SEAS: Mapping[str, str] = {}


def page(template: str, **values: Any) -> str:
    """Return a page from a template of this package, with its contents; a missing value raises."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("vsb.report"), autoescape=True, undefined=jinja2.StrictUndefined
    )
    environment.globals |= {
        "csv": csv_link,
        "text_of": text_of,
        "advice": advice,
        "filled": filled,
        "short": short,
        "printed": superscripts,
        "kinds": FIGURE_KINDS,
        "scripts": SCRIPTS,
    }
    text = with_minus_signs(environment.get_template(template).render(**values))
    links = " ".join(f'<a href="#{name}">{title}</a>' for name, title in SECTION.findall(text))
    return text.replace(CONTENTS, CONTENTS.replace("><", f">{links}<"), 1)


def with_minus_signs(text: str) -> str:
    """Return a page whose negative numbers have a minus sign for a hyphen, but in scripts, figures, files and tags."""
    parts = VERBATIM.split(text)
    return "".join(part if i % 2 else HYPHEN.sub(MINUS, part) for i, part in enumerate(parts))


def text_of(name: str) -> str:
    """Return a file of the templates as it is."""
    return markupsafe.Markup((importlib.resources.files("vsb.report") / "templates" / name).read_text(encoding="utf-8"))


def filled(head: Sequence[str], body: Sequence[Sequence[str]]) -> tuple[list[str], list[list[str]]]:
    """Return a table without the columns that hold nothing but dashes, and without the sea if it is the same in all."""
    columns = [set(column) for column in zip(*body, strict=True)]
    kept = [i for i, cells in enumerate(columns) if cells != {"-"} and (head[i] != "sea" or len(cells) > 1)]
    return [head[i] for i in kept], [[row[i] for i in kept] for row in body]


def csv_link(name: str, head: Sequence[str], body: Sequence[Sequence[str]]) -> str:
    """Return a link that downloads a table as CSV; the data are part of the link."""
    data = urllib.parse.quote(csv_text(head, body))
    return markupsafe.Markup('<a class="csv" download="{}.csv" href="data:text/csv;charset=utf-8,{}">CSV</a>').format(
        name, data
    )


def captioned(
    figures: Mapping[str, str], captions: Mapping[str, str], seas: Mapping[str, str] = NO_SEAS
) -> list[dict[str, Any]]:
    """Return figures in groups: those of no sea, then those of each sea, the first of them unfolded.

    Figures (SVG) of one sea have its label behind a dash; captions are by what stands before it. Those for specialists
    have a title under which they are `folded`; what does not fit into `INLINE` bytes is only linked.
    """
    groups: dict[str, list[dict[str, Any]]] = {}
    room = INLINE
    for name, svg in figures.items():
        kind, _, sea = name.partition("-")
        drawn = svg[svg.index("<svg") :]
        if fits := len(drawn.encode()) <= room:
            room -= len(drawn.encode())
        shown = {"name": name, "caption": captions[kind], "svg": drawn if fits else ""}
        groups.setdefault(sea, []).append({**shown, "folded": FOLDED.get(kind, "")})
    for number, figure in enumerate(itertools.chain.from_iterable(groups.values()), 1):
        figure["number"] = number  # in the order of the page
    first = next((sea for sea in groups if sea), "")
    return [{"sea": seas.get(sea, sea), "open": sea == first, "figures": of} for sea, of in groups.items()]


Measure = tuple[str, str, float, str]
"""Column of the comparison, its head, factor to the unit shown, format."""
DETAILS = (
    ("energy", "energy of the run [kJ]", 1e-3, ""),
    ("energy_gain_percent", "energy gain [%]", 1.0, "+z.1f"),
    ("energy_residual", "energy residual [-]", 1.0, ".1e"),
)
"""Measures of the whole run, start-up included."""
STILL = "No animation: the coefficients of this body come without its mesh."
MOST_WARNINGS = 3
"""Failed checks listed at the top of a page."""
SAME = 1.0
"""Gains of less than this either way count as none [%]."""


class Band(NamedTuple):
    """An interval of wave frequency in which a design gains or loses."""

    start: float  # [rad/s]
    end: float
    gain: float  # largest gain or loss inside [%]
    at: float  # where [rad/s]


@dataclass(frozen=True)
class Report:
    """What the page is made from."""

    study: dict[str, Any]  # canonical form
    seas: dict[str, str]  # wave label -> the sea in words
    rows: Sequence[dict[str, Any]]  # comparison table
    checks: Sequence[dict[str, Any]]  # validity ledger
    response: xr.Dataset | None  # none without BEM
    reference: str | None
    figures: dict[str, str]  # name -> SVG
    facts: dict[str, str]  # how it was made
    irregular: Sequence[str] = ()  # labels of irregular seas
    statistics: Sequence[dict[str, Any]] = ()  # of irregular seas, realisations together
    equal_tuning: Sequence[dict[str, Any]] = ()  # designs at their optimal damping; empty without BEM
    within_limits: Sequence[dict[str, Any]] = ()  # optima within limits, if the take-off has any
    at_force: Sequence[dict[str, Any]] = ()  # causal control and dampers of the same rms force, in irregular seas
    elsewhere: Sequence[dict[str, Any]] = ()  # controllers in seas they are not tuned in
    invalid: Sequence[dict[str, Any]] = ()  # of `vsb.results.ledger.Invalid`: designs not valid, where and why
    thing: str = "buoy"  # what floats
    flexible: bool = True  # whether any design is
    sketches: Sequence[dict[str, str]] = ()  # of each design: name, words, SVG
    interactive: dict[str, Any] | None = None  # data of the page's scripts, see `vsb.report.interactive`
    no_slider: str = ""  # why there are no such data
    animated: dict[str, Any] | None = None  # the buoys in motion, see `vsb.report.interactive`

    @property
    def rigid(self) -> str | None:
        """The reference where sentences compare flexible designs with it; rigid ones stand side by side."""
        return self.reference if self.flexible else None


PUBLISHED = {
    "displacement_pp": ("displacement", "m peak to peak", 1.0),
    "velocity_pp": ("velocity", "m/s peak to peak", 1.0),
    "pto_force_pp": ("control force", "N peak to peak", 1.0),
    "power_peak": ("peak power", "W", 1.0),
    "power_mean": ("mean power", "W", 1.0),
    "energy": ("energy of the run", "kJ", 1e-3),
}
"""Measures that may be published elsewhere: name, unit as printed, factor to it."""
PUBLISHED_HEAD = ("design", "sea", "measure", "published", "ours", "difference")


def winning_bands(omega: FloatArray, gain: FloatArray, threshold: float = SAME) -> list[Band]:
    """Return the intervals of omega [rad/s] in which a gain [%] stays above threshold, each with its largest value."""
    inside = np.concatenate([[False], gain > threshold, [False]])
    starts, ends = np.flatnonzero(inside[1:] & ~inside[:-1]), np.flatnonzero(~inside[1:] & inside[:-1])
    bands = []
    for first, last in zip(starts, ends - 1, strict=True):
        peak = first + int(np.argmax(gain[first : last + 1]))
        bands.append(Band(float(omega[first]), float(omega[last]), float(gain[peak]), float(omega[peak])))
    return bands


def band_statements(absorbed: xr.DataArray, reference: str | None) -> list[str]:
    """Return, for each other design, where over the useful band it absorbs more or less than the reference."""
    if reference is None:
        return ["This study has no rigid design to compare with."]
    if not float(absorbed.max()) > 0:
        return ["No design absorbs power: the take-off has no damping."]
    if absorbed.sizes["design"] < 2:
        return [f"{reference} is the only design of this study."]
    if not float(absorbed.sel(design=reference).max()) > 0:
        return [f"{reference} does not move this port, so there is no gain."]
    moves = absorbed.isel(omega=absorbed.sel(design=reference).values > 0)
    useful = moves.where(useful_band(moves), drop=True)
    omega, base = useful.omega.values, useful.sel(design=reference).values
    statements = []
    for design in (str(d) for d in useful.design.values if d != reference):
        gain = 100 * (useful.sel(design=design).values / base - 1)
        wins = [_band_text("more", band) for band in winning_bands(omega, gain)]
        losses = [_band_text("less", band) for band in winning_bands(omega, -gain)]
        text = "; ".join([*wins, *losses]) or "the same within 1 % everywhere"
        statements.append(f"{design} absorbs {text} than {reference}." if wins or losses else f"{design}: {text}.")
    return statements


def _band_text(direction: str, band: Band) -> str:
    """One interval in words, as wave periods."""
    size = (multiple(band.gain) if direction == "more" else "") or f"{band.gain:.0f} %"
    return (
        f"{direction} in waves of {2 * np.pi / band.end:.2f} to {2 * np.pi / band.start:.2f} s "
        f"(up to {size} at {2 * np.pi / band.at:.2f} s)"
    )


def sea_statements(
    rows: Sequence[dict[str, Any]],
    reference: str | None,
    seas: dict[str, str],
    tuned: Sequence[dict[str, Any]] = (),
    where: str = GIVEN,
    unit: str = FORCE.damping_unit,
) -> list[str]:
    """Return, for each sea, which design absorbs most in time, and its share of the optimum at the given damping."""
    statements = []
    for wave in dict.fromkeys(row["wave"] for row in rows):
        sea = [row for row in rows if row["wave"] == wave]
        still = wave == "still"  # without waves the energy of the run counts
        key = "energy" if still else "power_mean"
        best = max(sea, key=lambda row: float(row[key]))
        if float(best[key]) <= 0:
            statements.append(f"{where}, in {seas[wave]}, no design absorbs power on average.")
            continue
        name, most = str(best["design"]), " most" if len(sea) > 1 else ""
        name = the_rigid(name) if name == reference else name
        text = f"{where}, in {seas[wave]}, {name} absorbs{most}: "
        text += f"{plain(1e-3 * float(best[key]))} kJ from the start" if still else f"{_absorbed(best)} on average"
        base = next((row for row in sea if row["design"] == reference), None)
        against = _against(sea, base, still=still) if base is not None else ""
        statements.append(f"{text}{against}{shares_text(tuned, wave, unit)}.")
    return statements


def irregular_statements(
    lines: Sequence[dict[str, Any]],
    reference: str | None,
    seas: dict[str, str],
    tuned: Sequence[dict[str, Any]] = (),
    where: str = GIVEN,
    unit: str = FORCE.damping_unit,
) -> list[str]:
    """Return, for each irregular sea, mean power of the sea and its gain with its interval; without a gain its own."""
    statements = []
    for name in dict.fromkeys(line["sea"] for line in lines):
        sea = [line for line in lines if line["sea"] == name]
        gains = [
            ""
            if line["design"] == reference or line["gain_percent"] in MISSING
            else gain_in_brackets(line, ends=("gain_low", "gain_high"))
            for line in sea
        ]
        parts = [
            f"{line['design']} absorbs {power(float(line['power_mean'])) if gain else _absorbed(line)}{gain}"
            for line, gain in zip(sea, gains, strict=True)
        ]
        statements.append(f"{where}, in {seas[name]}, {', '.join(parts)}{shares_text(tuned, name, unit)}.")
    return statements


def _absorbed(row: dict[str, Any]) -> str:
    """Mean power of a design with its interval, if that is known."""
    low, high = (None if row[end] in MISSING else float(row[end]) for end in ("power_low", "power_high"))
    return power(float(row["power_mean"]), low, high)


def _against(sea: Sequence[dict[str, Any]], base: dict[str, Any], *, still: bool) -> str:
    """How the other designs stand against the reference in one sea, in brackets; in still water by their energy."""
    own, others = float(base["energy"]), [row for row in sea if row is not base]
    if still:
        gains = [f"{row['design']} {100 * (float(row['energy']) / own - 1):+z.1f} %" for row in others if own > 0]
    else:
        known = [row for row in others if row["power_gain_percent"] not in MISSING]
        gains = [f"{row['design']}{gain_in_brackets(row, 'power_gain_percent')}" for row in known]
    return f" (against {base['design']}: {', '.join(gains)})" if gains else ""


def measures(kind: PortKind, thing: str) -> list[Measure]:
    """Return the columns of the comparison table; of a body, motion is that of the port."""
    motion = ("heave [m]", "heave velocity [m/s]")
    if thing == "body":
        motion = (f"port {kind.motion} [{kind.motion_unit}]", f"port {kind.rate} [{kind.rate_unit}]")
    return [
        ("displacement_pp", superscripts(f"peak-to-peak {motion[0]}"), 1.0, ""),
        ("velocity_pp", superscripts(f"peak-to-peak {motion[1]}"), 1.0, ""),
        ("power_peak", "peak power [W]", 1.0, ""),
        ("power_mean", "mean power [W]", 1.0, ""),
        ("power_low", "from [W]", 1.0, ""),
        ("power_high", "to [W]", 1.0, ""),
        ("capture_width", "capture width [m]", 1.0, ""),
        ("damping", f"damping [{superscripts(kind.damping_unit)}]", 1.0, ""),
        ("power_gain_percent", "gain of mean power [%]", 1.0, "+z.1f"),
        ("record_power_mean", "mean of the record [W]", 1.0, ""),
        ("record_start", "record from [s]", 1.0, ""),
        ("record_end", "to [s]", 1.0, ""),
    ]


def table(rows: Sequence[dict[str, Any]], measures: Sequence[Measure]) -> tuple[list[str], list[list[str]]]:
    """Return head and body of the comparison table as text; a quantity that does not exist is a dash."""
    body = []
    for row in rows:
        cells = [cell(row[key], spec, factor) for key, _, factor, spec in measures]
        body.append([str(row["design"]), str(row["wave"]), *cells])
    return ["design", "sea", *(label for _, label, _, _ in measures)], body


STATISTICS = (
    "design", "sea", "amplitudes", "realisations", "mean power [W]", "interval [W]", "gain [%]", "interval [%]",
    "linear theory, sea [W]", "mean of the records [W]", "linear theory, same waves [W]", "gain of the records [%]",
)  # fmt: skip
"""Head of the table of irregular seas."""


def statistics_table(lines: Sequence[dict[str, Any]]) -> list[list[str]]:
    """Return the cells of the table of irregular seas; a quantity that does not exist is a dash."""

    def bounds(line: dict[str, Any], name: str, form: str = "") -> str:
        low, high = line[f"{name}_low"], line[f"{name}_high"]
        return "-" if low in MISSING else f"{cell(low, form)} to {cell(high, form)}"

    def form(line: dict[str, Any]) -> str:
        ends = [None if line[end] in MISSING else float(line[end]) for end in ("gain_low", "gain_high")]
        return f"+z.{gain_decimals(*ends)}f"

    return [
        [
            *(str(line[key]) for key in ("design", "sea", "amplitudes", "realisations")),
            cell(line["power_mean"]), bounds(line, "power"),
            cell(line["gain_percent"], form(line)), bounds(line, "gain", form(line)), cell(line["power_linear"]),
            cell(line["record_power_mean"]), cell(line["power_linear_record"]),
            cell(line["record_gain_percent"], "+z.1f"),
        ]
        for line in lines
    ]  # fmt: skip


def published_table(study: dict[str, Any], rows: Sequence[dict[str, Any]]) -> list[list[str]]:
    """Return lines of design, sea, measure, published figure, ours, difference; none if nothing is published."""
    lines = []
    published = (study["published"] or {"values": {}})["values"]
    for row in (row for row in rows if row["design"] in published and row["wave"] != "still"):
        values = dict(row)
        if row["damping"] not in MISSING:
            values["pto_force_pp"] = float(row["damping"]) * float(row["velocity_pp"])
        for key, (name, unit, factor) in PUBLISHED.items():
            theirs = published[row["design"]].get(key)
            if theirs is None or key not in values:
                continue
            ours = float(values[key])
            difference = f"{100 * (ours / theirs - 1):+z.1f} %" if theirs else "-"
            cells = (plain(theirs * factor, 5), plain(ours * factor, 5), difference)
            lines.append([row["design"], row["wave"], f"{name} [{unit}]", *cells])
    return lines


def _neglected(report: Report) -> str:
    """What the frequency response leaves out, in words: drag, which depends on the amplitude."""
    return "without drag" if report.study.get("drag") else ""


def _aside(report: Report) -> str:
    """What powers at optimal damping leave aside, in words."""
    return limits_aside(report.study["pto"])


def _answer(report: Report, in_seas: Sequence[str]) -> Answer:
    """The answer at equal tuning if it is known, else as simulated; what is not valid stands below."""
    if report.response is None:
        said = [NO_OPTIMUM, *in_seas[:1]]
    else:
        best, names = report.response.best_power, report.seas
        found = headline(
            report.equal_tuning, best, report.rigid, names, report.invalid, _neglected(report), _aside(report)
        )
        if found.stands:
            return found
        said = tuned_statements(report.equal_tuning, report.rigid, report.seas, _aside(report))[:1] or list(in_seas[:1])
    designs = {row["design"] for row in report.rows} - {report.reference}
    if designs and designs <= {line["design"] for line in report.invalid}:
        return Answer([no_answer(report.invalid)], [f"{COMPUTED}{' '.join(said)}"])
    return Answer(said, [])


def render(report: Report) -> str:
    """Return the report as one HTML page with everything inside."""
    pto = report.study["pto"]
    kind, law = port_kind(pto.get("port")), pto.get("law", "linear")
    unit = superscripts(kind.damping_unit)
    head, body = table(report.rows, measures(kind, report.thing))
    details_head, details = table(report.rows, DETAILS)
    irregular, tuned, response = report.irregular, report.equal_tuning, report.response
    where, given = damping_in_words(pto), pto.get("damping") is not None
    at_damping = tuned if law in DAMPERS else ()  # else the power in time is not that of the damping
    regular = [row for row in report.rows if row["wave"] not in irregular]
    in_seas = [
        *sea_statements(regular, report.rigid, report.seas, at_damping, where, unit),
        *irregular_statements(report.statistics, report.reference, report.seas, at_damping, where, unit),
    ]
    failed, answer = warnings(report.checks), _answer(report, in_seas)
    limit = "" if response is None else str(response.attrs.get("limit", ""))
    compared = report.reference is not None and len({row["design"] for row in report.rows}) > 1
    heaving = pto.get("port") in (None, "heave") and not pto.get("stiffness")
    controlled = report.at_force if math.isfinite(pto.get("control", {}).get("force_rms", math.inf)) else ()
    known = {"given": given, "compared": compared, "heaving": heaving}
    words = captions(_neglected(report), body=report.thing == "body", limit=limit, **known)
    return page(
        "report.html.j2",
        study=report.study["study"],
        thing=report.thing,
        compared=report.rigid is not None,
        kind_of_design="flexible" if report.flexible else "rigid",
        answer=answer.stands,
        below=answer.below,
        parts_head=PARTS,
        parts=parts_table(report.equal_tuning),
        sketches=report.sketches,
        kind="study",
        port=kind,
        interactive=as_script(report.interactive) if report.interactive else "",
        no_slider=report.no_slider,
        conversion=conversion_text(report.study["pto"]),
        animated=in_motion(report.animated),
        still="" if report.animated else STILL,
        tuned=[
            *([] if response is None else tuned_statements(tuned, report.rigid, report.seas, _aside(report))),
            *limited_statements(report.within_limits, report.reference, report.seas),
            *at_force_statements(controlled, report.rigid, report.seas, superscripts(kind.load_unit)),
        ],
        seas=in_seas,
        neglected=_neglected(report),
        aside=_aside(report) if law not in DAMPERS else "",
        best_bands=[] if response is None else band_statements(response.best_power, report.reference),
        bands=band_statements(response.absorbed_power, report.reference) if given and response is not None else [],
        dampings=where,
        tuning_head=tuning_head(unit),
        tuning=tuning_table(tuned),
        at_force_head=[head.format(superscripts(kind.load_unit)) for head in AT_FORCE],
        at_force=at_force_table(report.at_force),
        knowledge=knowledge_text(report.at_force, dragged=bool(report.study.get("drag"))),
        elsewhere_head=[head.format(superscripts(kind.load_unit)) for head in ELSEWHERE],
        elsewhere=elsewhere_table(report.elsewhere),
        details_head=details_head,
        details=details,
        statistics_head=STATISTICS,
        statistics=statistics_table(report.statistics),
        published_head=PUBLISHED_HEAD,
        published=published_table(report.study, report.rows),
        source=(report.study["published"] or {"source": ""})["source"],
        warnings=failed[:MOST_WARNINGS],
        more_failed=len(failed[MOST_WARNINGS:]),
        doubts=sum(check["verdict"] == "doubt" for check in report.checks),
        head=head,
        body=body,
        figures=captioned(report.figures, words, report.seas),
        checks=[check for check in report.checks if check["verdict"] != "ok"],
        passed=[check for check in report.checks if check["verdict"] == "ok"],
        facts=report.facts,
    )
