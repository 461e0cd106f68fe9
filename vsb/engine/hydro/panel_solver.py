"""The solver by panels as others must know it: name, version, and the water it is made for."""

from importlib.metadata import version

LEAST_DEPTH_IN_WAVENUMBERS = 0.3
"""Least depth times wavenumber of panels: capytaine has no finite-depth Green function for kd near 0.1."""


def panel_solver() -> str:
    """Name and version of the panel solver, part of every id of its results."""
    return f"capytaine {version('capytaine')}"
