"""One page of HTML with everything inside: what the reports of studies and of campaigns have in common."""

import csv
import io
import urllib.parse
from collections.abc import Mapping, Sequence
from typing import Any

import jinja2
import markupsafe


def page(template: str, **values: Any) -> str:
    """Return a page from a template of this package, which knows `csv` for `csv_link`; a value it lacks raises."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("vsb.report"), autoescape=True, undefined=jinja2.StrictUndefined
    )
    environment.globals["csv"] = csv_link
    return environment.get_template(template).render(**values)


def csv_link(name: str, head: Sequence[str], body: Sequence[Sequence[str]]) -> str:
    """Return a link that keeps a table as a CSV file: the data are inside it, nothing is fetched."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([head, *body])
    data = urllib.parse.quote(text.getvalue())
    return markupsafe.Markup('<a class="csv" download="{}.csv" href="data:text/csv;charset=utf-8,{}">CSV</a>').format(
        name, data
    )


def captioned(figures: Mapping[str, str], captions: Mapping[str, str]) -> list[dict[str, str]]:
    """Return figures as a page shows them: name, caption, sea and SVG without its head.

    Parameters
    ----------
    figures : mapping name -> str
        SVG; of one sea, its label stands behind a dash in the name.
    captions : mapping kind -> str
        By what stands before the dash.
    """
    named = [(name, *name.partition("-")[::2], svg) for name, svg in figures.items()]
    return [
        {"name": name, "caption": captions[kind], "sea": sea, "svg": svg[svg.index("<svg") :]}
        for name, kind, sea, svg in named
    ]
