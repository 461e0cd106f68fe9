"""The take-off of a study as forces of a scene."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from vsb.motion.scene import Plant
from vsb.motion.take_off import EndStop, TakeOff
from vsb.study.take_off import Law, Pto
from vsb.tools.units import FloatArray

STIFFER = 100.0
"""Spring of an end stop over the buoy's own stiffness at the port: it gives way by some per cent of what it stops."""

LAWS: Mapping[Law, Callable[[Pto, FloatArray], TakeOff]] = {
    "linear": lambda pto, port: TakeOff(port, pto.damping, limit=pto.force_limit),
    "saturated": lambda pto, port: TakeOff(port, pto.damping, limit=pto.force_limit),
    "coulomb": lambda pto, port: TakeOff(port, np.inf, limit=pto.force_limit),
}
"""`pto.law` -> its force at a port."""


def with_take_off(plant: Plant, pto: Pto) -> Plant:
    """Return a linear scene with the take-off of a study, and its end stop, if it switches; else the scene as it is."""
    if not pto.switches:
        return plant
    port = np.eye(len(plant.labels))[0]
    forces = {**plant.forces, plant.take_off: LAWS[pto.law](pto, port)}
    if pto.stroke_limit < np.inf:
        forces["end_stop"] = end_stop(plant, port, pto.stroke_limit)
    return replace(plant, forces=forces)


def end_stop(plant: Plant, port: FloatArray, stroke: float) -> EndStop:
    """Return the stop of a port: much stiffer than the buoy, critically damped with all that moves with the port.

    Parameters
    ----------
    plant : Plant
    port : ndarray, shape (dof,)
        b.
    stroke : float [m]
    """
    b = plant.motions.T @ port
    mass = 1 / float(b @ np.linalg.solve(plant.motions.T @ plant.mass @ plant.motions, b))
    stiffness = STIFFER / float(b @ np.linalg.solve(plant.stiffness, b))
    return EndStop(port, stroke, stiffness, 2 * float(np.sqrt(stiffness * mass)))
