"""The drag of a study as a force of a scene, and as linear theory sees it."""

from dataclasses import replace
from typing import Any

import numpy as np

from vsb.motion.drag import DraggedPort
from vsb.motion.forces import QuadraticDrag
from vsb.motion.frequency import LinearBuoy
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene
from vsb.motion.tuning import squares
from vsb.study.drag import Drag
from vsb.study.specs import DraggedSpec
from vsb.tools.units import ComplexArray, FloatArray
from vsb.waves.seas import Sea, vertical_velocity

LINEARISED = "linearised_power"
"""What a run with drag records of its linear theory: mean power [W] under the drag's equivalent damper."""


def coefficient(drag: Drag, density: float) -> float:
    """Return rho C A/2 of heave [kg/m]."""
    return 0.5 * density * drag.heave.coefficient * drag.heave.area


def flow(run: DraggedSpec, omega: FloatArray) -> ComplexArray:
    """Return the vertical velocity of undisturbed waves at half the draft per amplitude, shape (omega,) [1/s]."""
    return vertical_velocity(omega, -0.5 * run.draft, run.water.depth, run.water.gravity)


def with_drag(scene: Scene, run: DraggedSpec, sea: Sea) -> Scene:
    """Return a scene with the drag of its study, if it has one."""
    if run.drag is None:
        return scene
    heave = np.eye(len(scene.labels))[0]
    moved = sea.amplitude * flow(run, sea.omega)
    force = QuadraticDrag(heave, coefficient(run.drag, run.water.density), sea.omega, moved)
    return replace(scene, forces={**scene.forces, "drag": force})


def dragged_port(
    run: DraggedSpec, buoy: LinearBuoy, omega: FloatArray, motions: FloatArray, port: FloatArray
) -> DraggedPort:
    """Return the port of a design of a study with drag; arguments as of `LinearBuoy.port`."""
    assert run.drag is not None
    heave = np.eye(len(buoy.mass))[0]
    c = coefficient(run.drag, run.water.density)
    return DraggedPort.of(buoy, omega, motions, port, heave, flow(run, omega), c)


def linearised(run: DraggedSpec, buoy: LinearBuoy, motions: FloatArray, pto: LinearPto, sea: Sea) -> dict[str, Any]:
    """Return what a run in a sea records of its drag by linear theory: its damper and the mean power beside it."""
    if run.drag is None or not sea.omega.size:
        return {}
    at = dragged_port(run, buoy, sea.omega, motions, pto.direction(len(buoy.mass)))
    waves, load = squares([sea], sea.omega), (np.array([float(pto.damping)]), np.array([pto.stiffness]))
    return {
        "drag_damping": float(at.settled(waves, *load)[0, 0]),
        LINEARISED: float(at.powers(waves, *load)[0, 0]),
    }
