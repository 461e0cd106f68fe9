"""Design: a measured year's power and the limits of a buoy, with exact derivatives by its dimensions and materials.

May import from all rooms below: errors, tools, study, shell, waves, hydro, motion, integrators, scenes, results.
"""
