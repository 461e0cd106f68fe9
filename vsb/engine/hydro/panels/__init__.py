"""Boundary elements on flat panels, with capytaine's Green functions: the one route for buoys and bodies.

For `hydro.solver: panels`, the cross-check of the spectral solver, and general bodies. The only place that imports
capytaine; its name, version, and the water it is made for are known without that.
"""

from importlib.metadata import version

LEAST_DEPTH_IN_WAVENUMBERS = 0.3
"""Least depth times wavenumber of panels: capytaine has no finite-depth Green function for kd near 0.1."""


def panel_solver() -> str:
    """Name and version of the panel solver, part of every id of its results."""
    return f"capytaine {version('capytaine')}"
