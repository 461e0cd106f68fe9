"""What the package brings along: the workflow, its profiles and example studies.

A wheel holds them inside the package, a checkout beside it; the current folder is never asked.
"""

from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
HOME = next((home for home in (PACKAGE, PACKAGE.parent) if (home / "workflow" / "Snakefile").is_file()), PACKAGE)
"""Folder of `workflow`, `profiles` and `config`."""
