"""The take-off of a study as forces of a scene."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from vsb.motion.scene import Scene
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


def with_take_off(scene: Scene, pto: Pto) -> Scene:
    """Return a linear scene with the take-off of a study, and its end stop, if it switches; else the scene as it is."""
    if not pto.switches:
        return scene
    port = np.eye(len(scene.labels))[0]
    forces = {**scene.forces, scene.take_off: LAWS[pto.law](pto, port)}
    if pto.stroke_limit < np.inf:
        forces["end_stop"] = end_stop(scene, port, pto.stroke_limit)
    return replace(scene, forces=forces)


def end_stop(scene: Scene, port: FloatArray, stroke: float) -> EndStop:
    """Return the stop of a port: much stiffer than the buoy, critically damped with all that moves with the port.

    Parameters
    ----------
    scene : Scene
    port : ndarray, shape (dof,)
        b.
    stroke : float [m]
    """
    b = scene.motions.T @ port
    mass = 1 / float(b @ np.linalg.solve(scene.motions.T @ scene.mass @ scene.motions, b))
    stiffness = STIFFER / float(b @ np.linalg.solve(scene.stiffness, b))
    return EndStop(port, stroke, stiffness, 2 * float(np.sqrt(stiffness * mass)))
