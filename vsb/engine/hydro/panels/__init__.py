"""Boundary elements on rings of flat panels, with capytaine's Green functions.

For `hydro.solver: panels`, the cross-check of the spectral solver, and the panel matrices of general bodies.
May import what vsb.engine.hydro may; the only place that imports capytaine.
"""
