"""A self-contained HTML page: what the reports of studies and of campaigns have in common."""

import importlib.resources
import itertools
import re
import urllib.parse
from collections.abc import Mapping, Sequence
from typing import Any

import jinja2
import markupsafe

from vsb.report.doubts import advice
from vsb.study.figure_names import FIGURE_KINDS
from vsb.tools.words import csv_text, short, superscripts

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

    A figure for specialists has a title under which it is `folded`.

    Parameters
    ----------
    figures : mapping name -> str
        SVG; figures of one sea have its label behind a dash. Beyond `INLINE` they are only linked.
    captions : mapping kind -> str
        By what stands before the dash.
    seas : mapping label -> str
        Every sea in words.
    """
    groups: dict[str, list[dict[str, Any]]] = {}
    room = INLINE
    for name, svg in figures.items():
        kind, _, sea = name.partition("-")
        drawn = svg[svg.index("<svg") :]
        room -= len(drawn.encode())
        shown = {"name": name, "caption": captions[kind], "svg": drawn if room >= 0 else ""}
        groups.setdefault(sea, []).append({**shown, "folded": FOLDED.get(kind, "")})
    for number, figure in enumerate(itertools.chain.from_iterable(groups.values()), 1):
        figure["number"] = number  # in the order of the page
    first = next((sea for sea in groups if sea), "")
    return [{"sea": seas.get(sea, sea), "open": sea == first, "figures": of} for sea, of in groups.items()]
