"""Flexible (variable-shape) against rigid (fixed-shape) wave-energy buoys, from shell modes to absorbed power.

Public names are those of `__init__.pyi` (docs/api.md says what each is). They are imported when they are asked for:
`import vsb` itself loads nothing, so a Snakefile stays light.
"""

import ast
import importlib
from pathlib import Path

__version__ = "1.1.0"
_HOMES = {
    alias.name: node.module
    for node in ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")).body
    if isinstance(node, ast.ImportFrom) and node.module
    for alias in node.names
}
"""Module of every public name."""
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> object:
    """Import a public name on first use (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = found = getattr(importlib.import_module(_HOMES[name]), name)
    return found


def __dir__() -> list[str]:
    """Return the public names, those not imported yet among them."""
    return [*__all__, "__version__"]
