"""The drag of a study as a force of a scene, and as linear theory sees it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vsb.motion.drag import DraggedPort
from vsb.motion.forces import QuadraticDrag
from vsb.motion.port import LinearPto
from vsb.motion.scene import Scene
from vsb.motion.tuning import squares
from vsb.scenes.floating_system import FloatingSystem, heading
from vsb.study.directions import Drag, Vane
from vsb.study.specs import BuoySystem
from vsb.study.waves import Wave
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.waves.dispersion import horizontal_velocity, vertical_velocity
from vsb.waves.seas import Sea

LINEARISED = "linearised_power"
"""Attribute of a run with drag: mean power of linear theory with the equivalent dampers of the drag [W]."""
DAMPERS = "drag_damping"
"""Attribute: those dampers, in the order of the drag's directions [N s/m], of rotations [N m s]."""


def coefficients(drag: Drag, density: float) -> FloatArray:
    """Return rho C A/2 of every direction, shape (dragged,) [kg/m], of rotations times the lever's cube [kg m^2]."""
    plates = drag.directions.values()
    levers = [plate.lever if isinstance(plate, Vane) else 1.0 for plate in plates]
    return np.array(
        [0.5 * density * p.coefficient * p.area * lever**3 for p, lever in zip(plates, levers, strict=True)]
    )


def dragged(drag: Drag, labels: Sequence[str]) -> FloatArray:
    """Return the directions of a drag over degrees of freedom, shape (dragged, dof) [-]."""
    return np.array([[float(label == name.capitalize()) for label in labels] for name in drag.directions])


def flow(run: BuoySystem, omega: FloatArray, direction: float) -> ComplexArray:
    """Return the velocity of undisturbed waves at half the draft per amplitude, shape (omega, dragged) [1/s].

    Along every direction the drag acts on, of waves going to one [degrees]. They have no vorticity, so of rotations
    there is none.
    """
    assert run.drag is not None
    water, height, towards = run.water, -0.5 * run.draft, np.deg2rad(direction)
    along = horizontal_velocity(omega, height, water.depth, water.gravity)
    known = {
        "surge": np.cos(towards) * along,
        "sway": np.sin(towards) * along,
        "heave": vertical_velocity(omega, height, water.depth, water.gravity),
    }
    return np.stack([known.get(name, 0.0 * along) for name in run.drag.directions], axis=-1)


def with_drag(scene: Scene, run: BuoySystem, wave: Wave, sea: Sea) -> Scene:
    """Return a scene with the drag of its study, if it has one."""
    if run.drag is None:
        return scene
    moved = sea.amplitude[:, None] * flow(run, sea.omega, heading(wave))
    strength = coefficients(run.drag, run.water.density)
    force = QuadraticDrag(dragged(run.drag, scene.labels), strength, sea.omega, moved)
    return replace(scene, forces={**scene.forces, "drag": force})


def dragged_port(
    run: BuoySystem, floating: FloatingSystem, design: str, going: Mapping[float, FloatArray]
) -> DraggedPort:
    """Return the port of a design of a study with drag, in waves of directions [degrees], each at its frequencies."""
    assert run.drag is not None
    labels, strength = floating.linear.labels, coefficients(run.drag, run.water.density)
    motions, directions = floating.motions[design], dragged(run.drag, labels)
    return DraggedPort.joined(
        [
            DraggedPort.of(
                floating.towards(at), omega, motions, floating.port, directions, flow(run, omega, at), strength
            )
            for at, omega in going.items()
        ]
    )


def linearised(
    run: BuoySystem, floating: FloatingSystem, design: str, pto: LinearPto, wave: Wave, sea: Sea
) -> dict[str, Any]:
    """Return the attributes of a run with drag: equivalent dampers and the mean power of linear theory with them."""
    if run.drag is None or not sea.omega.size:
        return {}
    at = dragged_port(run, floating, design, {heading(wave): sea.omega})
    waves, load = squares([sea], sea.omega), (np.array([float(pto.damping)]), np.array([pto.stiffness]))
    return {
        DAMPERS: [float(damper) for damper in at.equivalent(waves, *load)[0, 0]],
        LINEARISED: float(at.powers(waves, *load)[0, 0]),
    }
