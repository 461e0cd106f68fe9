"""Hydrodynamic coefficients: solvers, checks of their results, databases, and models of the radiation memory.

`spectral` solves smooth bodies of revolution, `panels` and `bodies` any other by capytaine, which is imported in
`panels` alone; `formats` reads and writes files of other codes.

Examples
--------
Added mass of a floating hemisphere of 2 m in heave over the mass of its water [-], at Ka = 1 (Hulme 1982: 0.40):

>>> import math
>>> from vsb.engine.hydro.dofs import Displacement
>>> from vsb.engine.hydro.spectral.solver import SpectralProblem
>>> from vsb.engine.shell.deformed import rigid_sphere
>>> problem = SpectralProblem(rigid_sphere(2.0, 0.0), (Displacement("heave"),), 1025.0, 9.81, 16)
>>> solved = problem.solve([math.sqrt(9.81 / 2.0)])
>>> round(float(solved.added_mass.values.item() / (1025.0 * 2 / 3 * math.pi * 2.0**3)), 2)
0.43
"""

from vsb.engine.hydro import variables as variables
