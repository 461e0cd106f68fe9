"""How the documentation is built: `make docs`, every warning an error."""

import os
import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import generate  # noqa: E402
from docutils.nodes import SkipNode  # noqa: E402
from latex2mathml.converter import convert  # noqa: E402

from vsb import __version__  # noqa: E402

project, author, release = "vsb", "the authors of vsb", __version__
project_copyright = "the authors of vsb, GPL-3.0-or-later"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
html_math_renderer = "mathml"  # drawn by browsers: pages need neither scripts nor a network
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "force"  # notebooks are run from the root of the repository; finished results are reused
nb_execution_timeout = 900
nb_execution_raise_on_error = True
nb_merge_streams = True
nb_output_stderr = "remove"  # lines of progress
exclude_patterns = ["_build", "requirements.*", "reference/materials.md"]  # which is included in a page
html_static_path, html_css_files, html_js_files = ["_static"], ["vsb.css"], ["keys.js"]
html_theme, html_title = "furo", f"vsb {release}"
html_copy_source = html_show_sourcelink = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings state types, shapes and units

generate.write(HERE / "reference")
# Kernels say nothing of their transport: it stays on this machine.
(profile := HERE / "_build" / "ipython" / "profile_default").mkdir(parents=True, exist_ok=True)
(profile / "ipython_kernel_config.json").write_text('{"IPKernelApp": {"log_level": 40}}', encoding="utf-8")
os.environ["IPYTHONDIR"] = str(profile.parent)


def _bars(app, what, name, obj, options, lines):
    """Escape |X|, which Sphinx would read as a substitution."""
    lines[:] = [line.replace("|", "\\|") for line in lines]


def _formula(display):
    """A visitor that writes a formula as MathML."""

    def visit(self, node):
        self.body.append(convert(node.astext(), display=display))
        raise SkipNode

    return visit


ACCESSIBLE = {
    ' role="heading">': ' role="heading" aria-level="2">',
    '<aside class="sidebar-drawer">': '<aside class="sidebar-drawer" aria-label="all pages">',
    '<aside class="toc-drawer">': '<aside class="toc-drawer" aria-label="this page">',
    '<div class="table-wrapper': '<div tabindex="0" role="group" aria-label="table" class="table-wrapper',
    '<div class="cell_output': '<div tabindex="0" role="group" aria-label="output" class="cell_output',
}
"""What readers by keyboard or ear need, and the theme and its tools leave out."""


def _accessible(app, exception):
    """Add it to the pages; a head without words is a cell, and a page has a heading of the first level."""
    for path in Path(app.outdir).rglob("*.html"):
        text = page = path.read_text(encoding="utf-8")
        for found, better in ACCESSIBLE.items():
            text = text.replace(found, better)
        text = re.sub(r"<th([^>]*)>(?:<p></p>|\s*)</th>", r"<td\1></td>", text)
        if "<h1" not in text:
            text = text.replace('<div id="search-results">', '<h1>Search</h1><div id="search-results">')
        if text != page:
            path.write_text(text, encoding="utf-8")


def setup(app):
    """Register the changes to docstrings, formulas and pages."""
    app.connect("build-finished", _accessible)
    app.connect("autodoc-process-docstring", _bars)
    app.add_html_math_renderer("mathml", (_formula("inline"), None), (_formula("block"), None))
