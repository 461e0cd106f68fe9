"""Motion in time by one of several methods, steady states in regular waves, and the energy audit of a run.

`simulate` chooses the method and follows a run; each method is a module of its own (docs/extending.md). Of motion only
`system` is imported.

Examples
--------
Free decay of 2 kg on 50 N/m with 1.2 N s/m after 4 s [m], exact to round-off in any number of steps:

>>> import numpy as np
>>> from vsb.engine.integrators.exact import propagate
>>> from vsb.engine.motion.forces import Damper, Spring
>>> from vsb.engine.motion.scene import Scene
>>> from vsb.engine.motion.system import System
>>> forces = {"hydrostatic": Spring(np.array([[50.0]])), "pto": Damper(np.array([[1.2]]))}
>>> system = System.of(Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1)))
>>> motion = propagate(system, np.linspace(0.0, 4.0, 5), (np.array([0.5]), np.array([0.0])))
>>> round(float(motion.position[-1, 0]), 6)
0.074495
"""
