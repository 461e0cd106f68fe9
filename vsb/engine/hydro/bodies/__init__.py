"""Bodies of any shape: mesh and displacements from files, hydrostatics, and wave coefficients with their errors.

One mesh may hold several bodies, rigid or flexible, and the result is a hydro database like that of a buoy.
Imports from hydro and the rooms below it; hydro itself, except hydro.panels, imports nothing from here.
"""
