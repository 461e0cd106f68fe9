"""What moves: linear systems over frequency, their ports and optimal take-offs, and scenes of named forces in time.

A buoy or body is a `LinearSystem`; a run's equation of motion is a `Scene`, which integrators see as a `System`.
Imports errors, tools, study, shell, waves and hydro; knows no integrator.
"""

from vsb.motion import variables as variables
