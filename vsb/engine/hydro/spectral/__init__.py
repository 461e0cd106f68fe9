"""Boundary elements of spectral order for bodies of revolution, the default solver.

Meridian and influence of 1/r, Green's function of the waves, the solver and its sweep over frequency.
May import what vsb.engine.hydro may.
"""
