"""Tables and figures as text, the same bytes at any time."""

import csv
import io
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from vsb.errors import DatabaseError
from vsb.tools.files import check_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def csv_text(head: Iterable[object], rows: Iterable[Iterable[object]], digits: int = 10) -> str:
    """Return a table as CSV, its numbers with so many digits; an empty cell is a quantity that does not exist."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([f"{v:.{digits}g}" if isinstance(v, float) else v for v in row] for row in rows)
    return text.getvalue()


def check_table(path: str | Path, head: Iterable[object]) -> None:
    """Check, before hours of work, that a table can be written and replaces at most an earlier one of its columns.

    Raises `DatabaseError` if it cannot be written, or is any other file.
    """
    check_file(path)
    if Path(path).exists():
        columns = csv_text(head, []).encode()
        with Path(path).open("rb") as file:
            if file.read(len(columns)) != columns:
                raise DatabaseError(
                    f"{path}: is no earlier table of this command, and would be lost; needs another name for the output"
                )


def svg_text(figure: "Figure") -> str:
    """Return a figure as SVG without a date; drawn once, where `savefig` draws all of it twice to lay it out."""
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    text, dpi, canvas = io.StringIO(), figure.dpi, FigureCanvasSVG(figure)
    canvas.print_svg(text, metadata={"Date": None, "Creator": "vsb"})  # type: ignore[no-untyped-call]
    figure.set_dpi(dpi)
    return text.getvalue()
