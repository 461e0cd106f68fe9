"""The drag of a study as a force of a scene, and as linear theory sees it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vsb.engine.motion.drag import DraggedPort
from vsb.engine.motion.forces import QuadraticDrag
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.tuning import squares
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.seas import Sea
from vsb.engine.waves.water import horizontal_velocity, vertical_velocity
from vsb.errors import ConfigError
from vsb.models.floating_system import FloatingSystem, heading
from vsb.study.sections import Plate, Vane
from vsb.study.specs import AnySystem, BodySystem
from vsb.tools.arrays import ComplexArray, FloatArray

LINEARISED = "linearised_power"
"""Attribute of a run with drag: mean power of linear theory with the equivalent dampers of the drag [W]."""
DAMPERS = "drag_damping"
"""Attribute: those dampers, in the order of the drag's directions [N s/m], of rotations [N m s]."""


def coefficients(plates: Iterable[Plate], density: float) -> FloatArray:
    """Return rho C A/2 of every direction, shape (dragged,) [kg/m], of rotations times the lever's cube [kg m^2]."""
    cubes = [(plate, plate.lever**3 if isinstance(plate, Vane) else 1.0) for plate in plates]
    return np.array([0.5 * density * plate.coefficient * plate.area * cube for plate, cube in cubes])


def dragged(names: Iterable[str], labels: Sequence[str]) -> FloatArray:
    """Return the degrees of freedom that drag acts on as unit vectors, shape (dragged, dof) [-].

    Raises `ConfigError` if there is no such degree of freedom.
    """
    for name in names:
        if name not in labels:
            raise ConfigError(f"drag.{name}: no such degree of freedom; needs some of {', '.join(labels)}")
    return np.array([[float(label == name) for label in labels] for name in names])


def flow(run: AnySystem, omega: FloatArray, direction: float) -> ComplexArray:
    """Return the velocity of undisturbed waves at half the draft per amplitude, shape (omega, dragged) [1/s].

    Along every direction the drag acts on, of waves going to one [degrees]. They have no vorticity, so of rotations
    there is none. A body is dragged through still water, as WEC-Sim's `quadDrag` has it.
    """
    if isinstance(run, BodySystem):
        return np.zeros((len(omega), len(run.plates)), dtype=complex)
    water, height, towards = run.water, -0.5 * run.draft, np.deg2rad(direction)
    along = horizontal_velocity(omega, height, water.depth, water.gravity)
    known = {
        "Surge": np.cos(towards) * along,
        "Sway": np.sin(towards) * along,
        "Heave": vertical_velocity(omega, height, water.depth, water.gravity),
    }
    return np.stack([known.get(name, 0.0 * along) for name in run.plates], axis=-1)


def with_drag(scene: Scene, run: AnySystem, wave: Wave, sea: Sea) -> Scene:
    """Return a scene with the drag of its study, if it has one."""
    if not run.plates:
        return scene
    moved = sea.amplitude[:, None] * flow(run, sea.omega, heading(wave))
    strength = coefficients(run.plates.values(), run.water.density)
    force = QuadraticDrag(dragged(run.plates, scene.labels), strength, sea.omega, moved)
    return replace(scene, forces={**scene.forces, "drag": force})


def dragged_port(
    run: AnySystem, floating: FloatingSystem, design: str, going: Mapping[float, FloatArray]
) -> DraggedPort:
    """Return the port of a design of a study with drag, in waves of directions [degrees], each at its frequencies."""
    labels, strength = floating.linear.labels, coefficients(run.plates.values(), run.water.density)
    motions, directions = floating.motions[design], dragged(run.plates, labels)
    return DraggedPort.joined(
        [
            DraggedPort.of(
                floating.towards(at), omega, motions, floating.port, directions, flow(run, omega, at), strength
            )
            for at, omega in going.items()
        ]
    )


def linearised(
    run: AnySystem, floating: FloatingSystem, design: str, pto: LinearPto, wave: Wave, sea: Sea
) -> dict[str, Any]:
    """Return the attributes of a run with drag: equivalent dampers and the mean power of linear theory with them."""
    if not (run.plates and sea.omega.size):
        return {}
    at = dragged_port(run, floating, design, {heading(wave): sea.omega})
    waves, load = squares([sea], sea.omega), (np.array([float(pto.damping)]), np.array([pto.stiffness]))
    return {
        DAMPERS: [float(damper) for damper in at.equivalent(waves, *load)[0, 0]],
        LINEARISED: float(at.powers(waves, *load)[0, 0]),
    }
