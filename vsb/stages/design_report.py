"""Rule design_report: figures and report of a design problem."""

import json
from collections.abc import Iterator

import matplotlib as mpl
import xarray as xr
from matplotlib.figure import Figure

from vsb.keys.quantities import content_id
from vsb.report.canvas import drawn
from vsb.report.design_page import figure_of, render
from vsb.study import figure_names
from vsb.study.specs import DesignSpec
from vsb.tools.files import load, write_text
from vsb.tools.stamps import record


def run_design_report(spec: DesignSpec, data: str, figures: str, out: str, manifest: str) -> None:
    """Draw the figures of a design problem and write its report."""
    identity = content_id(spec)
    ds = load(data, expected=identity)
    facts = json.loads(ds.attrs["facts"])
    with mpl.rc_context():  # the caller's own figures keep their looks
        every = {name: drawn(figure, name) for name, figure in figures_of(spec, ds)}
    files = [path for name, one in every.items() for path in one.write(figures, name)]
    write_text(out, render(facts, {name: one.svg for name, one in every.items()}, identity))
    record(manifest, identity, [out, *files])


def figures_of(spec: DesignSpec, ds: xr.Dataset) -> Iterator[tuple[str, Figure]]:
    """Draw the figures of a design problem by name."""
    facts = json.loads(ds.attrs["facts"])
    yield from ((name, figure_of(name, facts, ds)) for name in figure_names.of_design(spec))
