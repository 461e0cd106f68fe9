"""What moves: linear systems over frequency, their ports and optimal take-offs, and scenes of named forces in time.

A buoy or body is a `LinearSystem`; a run's equation of motion is a `Scene`, which integrators see as a `System`. Knows
no integrator.

Examples
--------
A port of impedance 3 + 4i [N s/m] that waves of 1 m move at 2 m/s: optimal damping, and its share of the matched power:

>>> import numpy as np
>>> from vsb.engine.motion.port import Port
>>> port = Port(np.array([1.0]), np.array([1 / (3 + 4j)]), np.array([2.0 + 0j]), compliance=1.0)
>>> round(float(port.best_damping[0]), 3), round(float(port.best_power[0] / port.matched_power[0]), 3)
(5.0, 0.75)
"""

from vsb.engine.motion import variables as variables
