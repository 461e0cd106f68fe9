"""Hydrodynamic coefficients: solvers, checks of their results, databases, and models of the radiation memory.

May import errors, tools, study, shell and waves. `capytaine` is imported in `vsb.hydro.panels` alone.
"""

from vsb.hydro import variables as variables
