"""The take-off of a study and its drag as forces of a scene; its damper as given or as the linear port wants it."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from vsb.engine.motion import drag
from vsb.engine.motion.drag import DraggedPort
from vsb.engine.motion.forces import EndStop, Force, PortForce, QuadraticDrag, TakeOff
from vsb.engine.motion.frequency import allowed_part, compliance
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.take_off import Pto, SeveralPorts, distribution_of, entry_point, port_kind
from vsb.engine.motion.tuning import Kind, best_dampers, best_matrix, frequencies, squares
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.seas import Sea
from vsb.engine.waves.water import horizontal_velocity, vertical_velocity
from vsb.errors import ConfigError
from vsb.models.floating_system import FloatingSystem, heading, headings, port_in_seas
from vsb.study.sections import Plate, Vane
from vsb.study.study import Study
from vsb.tools.arrays import ComplexArray, FloatArray

STIFFER = 100.0
"""Spring of an end stop over the buoy's own stiffness at the port: it yields by some per cent of what it stops."""

Dragged = Callable[[FloatingSystem, str, Mapping[float, FloatArray]], drag.DraggedPort]


def _limited(pto: Pto, port: FloatArray, damper: float, rest: float) -> TakeOff:
    """A damper and a spring whose force is limited."""
    return TakeOff(port, damper, pto.stiffness, pto.force_limit, rest=rest)


FORCES: dict[str, Callable[[Pto, FloatArray, float, float], Force]] = {
    "linear": _limited,
    "saturated": _limited,
    "coulomb": lambda pto, port, _, rest: TakeOff(port, np.inf, limit=pto.force_limit, rest=rest),
    "latching": _limited,
    "declutching": lambda pto, port, damper, rest: replace(_limited(pto, port, damper, rest), latching_damping=0.0),
    "causal": lambda pto, port, _, rest: TakeOff(port, 0.0, limit=pto.force_limit, rest=rest),
}
"""Law of `vsb.engine.motion.take_off.LAWS`, at a port, with a damper [N s/m] and the stroke at rest [m] -> its force.

Latching times are found in a sea (`vsb.models.build`), and so is a causal controller (`vsb.models.stationary`)."""


def law_of_package(pto: Pto, port: FloatArray, rest: float) -> PortForce:
    """Return the force of a law of a package, `force = law(position, velocity, time, parameters)`.

    Position and velocity of the port, from rest, and time are arrays (time,); the force [N] acts on the buoy. Raises
    `ConfigError` if the package is not installed, in another version than the study is of, or its law cannot be had,
    raises, or gives no finite force for a port at rest.
    """
    try:
        entry = entry_point(pto.law)
    except ValueError as error:
        raise ConfigError(f"pto.{error}") from None
    if (found := distribution_of(entry)) != pto.distribution:
        raise ConfigError(f"pto.law: received {pto.law} of {found}, needs that of {pto.distribution}")
    try:
        law = entry.load()
    except Exception as error:  # whatever the import of a package may raise
        raise ConfigError(f"pto.law: {pto.law} of {found} cannot be imported ({error})") from error
    parameters = dict(pto.parameters)
    force = PortForce(port, lambda s, v, t: law(s, v, t, parameters), f"{pto.law} of {found}", rest)
    still = np.zeros((3, len(port)))
    force.force(np.zeros(3), still, still)  # raises
    return force


def check_law(pto: Pto) -> None:
    """Check that the law of a package, if the take-off has one, is there and gives a force; see `law_of_package`."""
    if pto.of_package:
        law_of_package(pto, np.ones(1), 0.0)


def tuned_take_off(
    pto: Pto, design: str, floating: FloatingSystem, seas: Sequence[tuple[Wave, Sea]], dragged: Dragged | None = None
) -> LinearPto:
    """Return spring and damper of a run: the damper given, or the one that absorbs most in seas by linear theory.

    Raises `ConfigError` if no damper is given and no sea has waves.

    Parameters
    ----------
    seas : sequence of (Wave, Sea)
        A damper that is not given maximises the sum of power over these, from any directions.
    dragged : callable, optional
        Floating system, design, frequencies by direction -> its port with drag, where there is drag.
    """
    if pto.several:
        matrix = given_matrix(pto, design, floating.port.shape[1])
        if matrix is None:
            together = [sea for _, sea in _with_waves(pto, seas)]
            omega = frequencies(together)
            ports, sums = floating.several_ports(omega)[design], squares(together, omega).sum(axis=0)
            matrix = best_matrix(ports, sums, matrix_kind(pto)).damping
        return LinearPto(matrix, port=floating.port)
    damper = pto.damper(design)
    if pto.tuning != "fixed":
        moving = _with_waves(pto, seas)
        seen = port_in_seas(floating, design, moving)
        if dragged:
            beside = dragged(floating, design, headings(moving))
            damper = drag.best_damper(beside, seen.squares, pto.stiffness, pto.efficiency)
        else:
            together = seen.squares.sum(axis=0, keepdims=True)
            damper = float(best_dampers(seen.port, together, pto.stiffness, pto.efficiency).damping[0])
    assert damper is not None  # a Pto's own check
    return LinearPto(damper, pto.stiffness, floating.port)


def _with_waves(pto: Pto, seas: Sequence[tuple[Wave, Sea]]) -> list[tuple[Wave, Sea]]:
    """Seas a damper can be tuned in; `ConfigError` if there is none."""
    moving = [(wave, sea) for wave, sea in seas if sea.omega.size]
    if not moving:
        unit = port_kind(pto.port).damping_unit
        raise ConfigError(
            f"pto.tuning: received {pto.tuning!r}, needs at least one sea with waves, or pto.damping in {unit}"
        )
    return moving


def given_matrix(pto: Pto, design: str, count: int) -> FloatArray | None:
    """Return the damper matrix given at several ports, or spread over the shell, (port, port); None if it is tuned."""
    if isinstance(pto.port, SeveralPorts):
        return None if pto.port.damping is None else np.array(pto.port.damping)
    damper = pto.damper(design)
    return None if damper is None or pto.tuning != "fixed" else damper * np.eye(count)


def given_damper(pto: Pto, design: str, ports: tuple[int, ...]) -> FloatArray | float | None:
    """Return the damper given [N s/m], whatever the tuning: of one port (), of several (count,) a damper matrix."""
    if not ports:
        return pto.damper(design)
    return given_matrix(pto.model_copy(update={"tuning": "fixed"}), design, *ports)


def matrix_kind(pto: Pto) -> Kind:
    """Return what the damper matrix of a take-off may be."""
    return pto.port.matrix if isinstance(pto.port, SeveralPorts) else "uniform"


def with_take_off(scene: Scene, pto: Pto, linear: LinearPto) -> Scene:
    """Return a scene with the take-off of a study, and its end stop, if it is nonlinear; else the scene as it is.

    Spring and stroke count from where the buoy rests.

    Parameters
    ----------
    linear : LinearPto
        Its damper and its port.
    """
    if not pto.nonlinear:
        return scene
    port = linear.direction(len(scene.labels))
    if not allowed_part(port, scene.motions).any():
        return scene  # nothing there moves
    rest = float(port @ scene.motions @ scene.rest)
    if pto.of_package:
        law: Force = law_of_package(pto, port, rest)
    else:
        law = FORCES[pto.law](pto, port, float(linear.damping), rest)
    forces: dict[str, Force] = {**scene.forces, scene.take_off: law}
    if pto.stroke_limit < np.inf:
        forces["end_stop"] = replace(end_stop(scene, port, pto.stroke_limit), rest=rest)
    return replace(scene, forces=forces)


def end_stop(scene: Scene, port: FloatArray, stroke: float) -> EndStop:
    """Return the stop of a port: much stiffer than the buoy, critically damped with all that moves with the port.

    Raises `ConfigError` if the port drifts.

    Parameters
    ----------
    port : ndarray, shape (dof,)
        b.
    stroke : float [m]
    """
    b = scene.motions.T @ port
    mass = 1 / float(b @ np.linalg.solve(scene.motions.T @ scene.mass @ scene.motions, b))
    yields = compliance(scene.stiffness, b)
    if np.isinf(yields):
        raise ConfigError("pto.stroke_limit: nothing holds this port at rest, so that no stroke counts from there")
    stiffness = STIFFER / yields
    return EndStop(port, stroke, stiffness, 2 * float(np.sqrt(stiffness * mass)))


# quadratic drag, as a force of a scene and as linear theory sees it -------------------------------------------------

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


def flow(run: Study, omega: FloatArray, direction: float) -> ComplexArray:
    """Return the velocity of undisturbed waves at half the draft per amplitude, shape (omega, dragged) [1/s].

    Along every direction the drag acts on, of waves going to one [degrees]. They have no vorticity, so of rotations
    there is none. A body is dragged through still water, as WEC-Sim's `quadDrag` has it.
    """
    if run.KIND == "body":
        return np.zeros((len(omega), len(run.plates)), dtype=complex)
    water, height, towards = run.water, -0.5 * run.draft, np.deg2rad(direction)
    along = horizontal_velocity(omega, height, water.depth, water.gravity)
    known = {
        "Surge": np.cos(towards) * along,
        "Sway": np.sin(towards) * along,
        "Heave": vertical_velocity(omega, height, water.depth, water.gravity),
    }
    return np.stack([known.get(name, 0.0 * along) for name in run.plates], axis=-1)


def with_drag(scene: Scene, run: Study, wave: Wave, sea: Sea) -> Scene:
    """Return a scene with the drag of its study, if it has one."""
    if not run.plates:
        return scene
    moved = sea.amplitude[:, None] * flow(run, sea.omega, heading(wave))
    strength = coefficients(run.plates.values(), run.water.density)
    force = QuadraticDrag(dragged(run.plates, scene.labels), strength, sea.omega, moved)
    return replace(scene, forces={**scene.forces, "drag": force})


def dragged_port(run: Study, floating: FloatingSystem, design: str, going: Mapping[float, FloatArray]) -> DraggedPort:
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
    run: Study, floating: FloatingSystem, design: str, pto: LinearPto, wave: Wave, sea: Sea
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
