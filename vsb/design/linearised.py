"""Matrices of a design about its shape at rest, over its free motions, and their derivatives by variables."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.linalg import null_space

from vsb.design.resting import RestingBuoy, Stepped
from vsb.engine.hydro.database import shares
from vsb.engine.hydro.dofs import Displacement
from vsb.engine.hydro.shape_dependence import shape_derivative
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.motion.port import port_direction
from vsb.engine.motion.take_off import (
    BetweenPort,
    DistributedPort,
    DofPort,
    SeveralPorts,
    ShellPort,
    SinglePort,
    StrainPort,
)
from vsb.engine.shell.loaded import ElasticShell
from vsb.engine.shell.meridian import Curve
from vsb.engine.shell.modes import DISTINCT
from vsb.errors import ConfigError
from vsb.models.rest import design_motions, mooring_rows
from vsb.tools.arrays import AnyArray, ComplexArray, FloatArray

Angle = str
"""A colatitude that is varied: that of the clamp, or of a port by its key."""
CLAMPED = "clamp"
"""The first."""


@dataclass(frozen=True)
class Linearised:
    """A buoy without its take-off over some motions: values, or derivatives by each variable (first axis)."""

    mass: FloatArray  # ([variable,] motion, motion) [kg]
    damping: FloatArray  # structural [N s/m]
    stiffness: FloatArray  # [N/m]
    radiation: ComplexArray  # A + i B/omega ([variable,] omega, motion, motion) [kg]
    excitation: ComplexArray  # ([variable,] omega, motion) [N/m]
    port: FloatArray  # b ([variable,] motion) [-]; of several ports B^T ([variable,] port, motion)
    chamber: FloatArray  # compliance of trapped gas between port and take-off ([variable]) [m^3/Pa]; 0 without it

    def over(self, motions: FloatArray) -> "Linearised":
        """Return N^T V N and N^T f of the matrices V and forces f, N being other motions, shape (motion, free)."""
        return Linearised(
            motions.T @ self.mass @ motions,
            motions.T @ self.damping @ motions,
            motions.T @ self.stiffness @ motions,
            motions.T @ self.radiation @ motions,
            self.excitation @ motions,
            self.port @ motions,
            self.chamber,
        )

    def turned(self, motions: FloatArray, change: FloatArray) -> "Linearised":
        """Return the derivatives of `over` by variables that change the motions, shape (variable, motion, free)."""

        def both(each: AnyArray) -> AnyArray:
            half = change.swapaxes(1, 2).reshape(len(change), *(1,) * (each.ndim - 2), *change.shape[:0:-1])
            found = half @ (each @ motions)
            return np.asarray(found + found.swapaxes(-1, -2))  # of symmetric V

        return Linearised(
            both(self.mass),
            both(self.damping),
            both(self.stiffness),
            both(self.radiation),
            self.excitation @ change,
            self.port @ change,
            np.zeros(len(change)),
        )

    def plus(self, other: "Linearised") -> "Linearised":
        """Return the sum with another."""
        return Linearised(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(self)))


def linearised(
    buoy: RestingBuoy, design: str, steps: Sequence[Stepped | Angle], omega: FloatArray, nodes: int
) -> tuple[Linearised, Linearised]:
    """Return the matrices of a design at rest over its free motions, and their derivatives by variables.

    Raises `ConfigError` if the design does not move the port, or the clamp is at a pole or one of several.

    Parameters
    ----------
    steps : sequence of Stepped
        Or of an angle: that of the design's clamp, or of the port [degrees].
    omega : ndarray, shape (omega,) [rad/s]
        Frequencies of radiation and excitation.
    nodes : int
        Of the boundary elements.
    """
    water, count = buoy.study.water, len(steps)
    dof, flexible = len(buoy.basis.labels), buoy.study.designs[design].flexible
    moved = displacements(buoy.basis.highest_degree if flexible else 0)
    shape = _displaced(buoy, moved) if flexible else np.eye(dof, 1)
    problem = SpectralProblem(buoy.shape, moved, water.density, water.gravity, nodes, water.depth)

    def directions(colatitude: FloatArray) -> Curve:
        """How points of the meridian move with each variable."""
        still = np.zeros((4, len(colatitude)))
        parts = [one.displacement(colatitude) if isinstance(one, Stepped) else still for one in steps]
        return Curve(*np.reshape(parts, (count, 4, len(colatitude))).swapaxes(0, 1))

    def change(of: Callable[[RestingBuoy], AnyArray], *size: int) -> FloatArray:
        """Derivatives by all variables of an analytic function of the buoy, of values of a size; by angles none."""
        parts = [one.derivative(of) if isinstance(one, Stepped) else np.zeros(size) for one in steps]
        return np.reshape(parts, (count, *size))

    def of_matrix(name: str) -> FloatArray:
        """Derivatives of one of the buoy's matrices: by angles of the part of the modes of rings."""
        found = change(lambda b: getattr(b.matrices, name), dof, dof)
        for i, one in enumerate(steps):
            if isinstance(one, str) and buoy.rings:
                by = _of_rings(buoy, design, one, lambda b: getattr(b.of_rings, name))
                found[i, dof - len(by) :, dof - len(by) :] = by
        return found

    def radiated(values: ComplexArray) -> ComplexArray:
        found = shape @ values @ shape.T
        return np.asarray((found + found.swapaxes(-1, -2)) / 2)  # symmetric but for the solver's error

    motions, turning = motions_of(buoy, design, steps)
    solved = shape_derivative(problem, list(omega), directions)
    values = Linearised(
        *buoy.matrices, radiated(solved.radiation), solved.excitation @ shape.T, _port(buoy), buoy.chamber
    )
    if not (values.port @ motions).any():
        raise ConfigError(
            f"pto.port: received {buoy.study.pto.port}, which design {design} does not move; needs another"
        )
    radiation_change, excitation_change = radiated(solved.radiation_change), solved.excitation_change @ shape.T
    if flexible and buoy.frame is not None:
        turned = change(lambda b: _displaced(b, moved), *shape.shape)[:, None].swapaxes(0, 1)
        mixed = turned @ ((solved.radiation + solved.radiation.swapaxes(1, 2)) / 2)[:, None] @ shape.T
        radiation_change = radiation_change + mixed + mixed.swapaxes(-1, -2)
        excitation_change = excitation_change + (solved.excitation[:, None, None] @ turned.swapaxes(-1, -2))[..., 0, :]
    sized = values.port.shape
    turned_by = [np.zeros(sized) if isinstance(one, Stepped) else _turned_port(buoy, design, one) for one in steps]
    by_port = np.reshape(turned_by, (count, *sized))
    changes = Linearised(
        of_matrix("mass"),
        of_matrix("damping"),
        of_matrix("stiffness"),
        radiation_change.swapaxes(0, 1),
        excitation_change.swapaxes(0, 1),
        _port_change(buoy, change, values.port) + by_port,
        change(lambda b: b.chamber),
    ).over(motions)
    if turning.any():
        changes = changes.plus(values.turned(motions, turning))
    return values.over(motions), changes


def _displaced(buoy: RestingBuoy, moved: Sequence[Displacement]) -> FloatArray:
    """Displacements that frame and modes consist of, shape (dof, displacement) [-]."""
    return np.asarray(buoy.framed(shares(moved, buoy.basis).T).T)


def _port(buoy: RestingBuoy) -> FloatArray:
    """The motion of the take-off's port, b over all degrees of freedom, (dof,); of several B^T, (port, dof)."""
    choice = buoy.study.pto.port
    if isinstance(choice, SeveralPorts):
        return np.stack([_port(_at_port(buoy, one)) for one in choice.ports.values()])
    if isinstance(choice, ShellPort) and buoy.frame is not None:
        to_sea_bed = port_direction(choice.model_copy(update={"against": "sea_bed"}), buoy.moving_shape)
        return _against(choice, buoy.framed(to_sea_bed))
    found = port_direction(choice, buoy.moving_shape).T
    return found if choice == "heave" or isinstance(choice, DofPort) else np.asarray(buoy.framed(found))


def _against(port: ShellPort, to_sea_bed: FloatArray) -> FloatArray:
    """The motion of a ring against what its take-off stands on, from that against the sea bed: frame or sea bed."""
    return to_sea_bed * (np.arange(len(to_sea_bed)) > 0) if port.against == "frame" else to_sea_bed


def _at_port(buoy: RestingBuoy, port: SinglePort) -> RestingBuoy:
    """A buoy with its take-off at another port."""
    pto = buoy.study.pto.model_copy(update={"port": port})
    return replace(buoy, study=buoy.study.model_copy(update={"pto": pto}))


def _port_change(buoy: RestingBuoy, change: Callable[..., FloatArray], port: FloatArray) -> FloatArray:
    """Derivatives of `_port` by all variables.

    Of a damper spread over the shell by those of the membrane's stiffness K = L L^T, whose rank is the same:
    dL = (1 - L L^+/2) dK L^+^T.
    """
    if not isinstance(buoy.study.pto.port, DistributedPort):
        return change(_port, *port.shape)
    inverse = np.linalg.pinv(port.T, rcond=DISTINCT)
    by = change(_membrane_stiffness, port.shape[1], port.shape[1])
    return np.asarray((inverse @ by) @ (np.eye(len(inverse.T)) - port.T @ inverse / 2).T)


def _membrane_stiffness(buoy: RestingBuoy) -> AnyArray:
    """Stiffness of the membrane about the shape at rest, shape (dof, dof) [N/m]."""
    moving = buoy.moving_shape
    return buoy.framed(buoy.framed(ElasticShell(moving.basis).membrane_stiffness(moving.modal_amplitude)).T)


def _port_slope(buoy: RestingBuoy, key: str) -> FloatArray:
    """Derivative of the functions' part of `_port` by a colatitude of a port [1/degree]."""
    port, basis, shape = buoy.study.pto.port, buoy.loaded.basis, buoy.shape
    _, _, name, *rest = key.split(".")
    if isinstance(port, SeveralPorts):
        one = _port_slope(_at_port(buoy, port.ports[rest[0]]), ".".join(["pto", "port", *rest[1:]]))
        return np.array([one * (other == rest[0]) for other in port.ports])
    given = {"colatitude": ShellPort, "belt": StrainPort, "between": BetweenPort}[name]
    if not isinstance(port, given):
        raise ConfigError(f"{key}: received another port; derivatives by it need one that has it")
    at = np.deg2rad([port.colatitude] if isinstance(port, ShellPort) else getattr(port, name))
    m = shape.meridian(at)
    if isinstance(port, ShellPort):
        slopes = basis.displacement_and_slope(at)[2:]
        slope = slopes[0][:, 0] if port.direction == "radial" else m.dshape_z[:, 0]
        return _against(port, buoy.framed(np.deg2rad(slope)))
    end, sign = int(rest[0]), 2 * int(rest[0]) - 1
    if isinstance(port, StrainPort):
        arc, (hoop, meridional, area) = np.hypot(m.dx, m.dz)[end], shape.strain_gradients(*map(float, at))
        around = 2 * np.pi * arc * m.shape_x[:, end]
        along = 2 * np.pi * m.x[end] / arc * (m.dshape_x * m.dx + m.dshape_z * m.dz)[:, end]
        ring = 2 * np.pi * m.x[end] * arc
        parts = {
            "area": around + along,
            "hoop": (around - ring * hoop) / area,
            "meridional": (along - ring * meridional) / area,
        }
        slope = sign * parts[port.strain]
    else:
        chord = np.array([np.diff(m.x)[0], np.diff(m.z)[0]])
        apart = np.array([np.diff(m.shape_x)[:, 0], np.diff(m.shape_z)[:, 0]])
        by_chord, by_shape = np.array([m.dx, m.dz])[:, end], np.array([m.dshape_x, m.dshape_z])[:, :, end]
        far = np.linalg.norm(chord)
        slope = sign * (by_chord @ apart + chord @ by_shape - (chord @ by_chord) * (chord @ apart) / far**2) / far
    return np.asarray(buoy.framed(np.deg2rad(slope) * (np.arange(len(slope)) > 0)))


def _turned_port(buoy: RestingBuoy, design: str, key: Angle) -> FloatArray:
    """Derivative of `_port` by a colatitude [1/degree]."""
    count = len(buoy.loaded.basis.labels)
    of_functions = np.zeros_like(_port(buoy)[..., :count]) if key == CLAMPED else _port_slope(buoy, key)
    if buoy.rings is None:
        return of_functions
    return np.concatenate([of_functions, _of_rings(buoy, design, key, lambda b: _port(b)[..., count:])], axis=-1)


TURN = np.rad2deg(0.04)
"""Step of differences by an angle times the highest degree that answers [degrees]: waves are longer."""


def _of_rings(buoy: RestingBuoy, design: str, key: Angle, of: Callable[[RestingBuoy], FloatArray]) -> FloatArray:
    """Derivative of what is the modes' of rings by a colatitude [1/degree], by differences of the fourth order.

    At a pole, where a load along the meridian does nothing, it is 0 by symmetry.
    """
    here = of(buoy)
    assert buoy.rings
    key = f"designs.{design}.clamp" if key == CLAMPED else key
    step = TURN / buoy.rings.resolved
    ends = [[buoy.turned(key, sign * far * step) for sign in (1, -1)] for far in (1, 2)]
    if any(len(end.loads) != len(buoy.loads) for pair in ends for end in pair):
        return np.zeros_like(here)
    near, far = ((of(up) - of(down)) / (2 * times * step) for times, (up, down) in zip((1, 2), ends, strict=True))
    return np.asarray((4 * near - far) / 3)


def _held(buoy: RestingBuoy, design: str) -> FloatArray:
    """What clamps and mooring hold at zero, Phi q = 0, (constraint, dof) [-]."""
    basis, at = buoy.basis, np.deg2rad(buoy.study.designs[design].clamp)
    clamps = np.vstack([part.T for part in basis.ring_displacement(at)])
    clamps = buoy.framed(clamps) * (np.arange(len(basis.labels)) > 0)  # relative to the frame
    return np.vstack([clamps, buoy.framed(mooring_rows(buoy.study, basis))])


def _held_change(buoy: RestingBuoy, design: str, step: Stepped | Angle) -> FloatArray:
    """Derivative of `_held` by a variable, shape (constraint, dof); by an angle per degree."""
    if isinstance(step, Stepped):
        return step.derivative(lambda b: _held(b, design))
    found = np.zeros(_held(buoy, design).shape)
    if step == CLAMPED:
        slopes = buoy.loaded.basis.displacement_and_slope(np.deg2rad(buoy.study.designs[design].clamp))[2:]
        rows = np.deg2rad(buoy.framed(np.vstack([part.T for part in slopes])))
        found[: len(rows), 1 : rows.shape[1]] = rows[:, 1:]
    if buoy.rings:
        own = slice(len(buoy.basis.labels) - len(buoy.rings.labels), None)
        found[:, own] = _of_rings(buoy, design, step, lambda b: _held(b, design)[:, own])
    return found


def motions_of(buoy: RestingBuoy, design: str, steps: Sequence[Stepped | Angle]) -> tuple[FloatArray, FloatArray]:
    """Return the motions a design allows, (dof, free) [-], and their derivatives by variables, (variable, dof, free).

    Parameters are those of `linearised`.
    """
    motions, flexible = _motions(buoy, design), buoy.study.designs[design].flexible
    if CLAMPED in steps or (flexible and (buoy.frame is not None or buoy.rings)):
        return motions, _motions_change(buoy, design, steps, motions)
    return motions, np.zeros((len(steps), *motions.shape))


def _motions(buoy: RestingBuoy, design: str) -> FloatArray:
    """The motions a design allows, shape (dof, free) [-]."""
    found = design_motions(buoy.study, buoy.basis, design)
    if buoy.frame is None or not buoy.study.designs[design].flexible:
        return found
    rows = _held(buoy, design)
    return null_space(rows) if len(rows) else np.eye(len(found))


def _motions_change(
    buoy: RestingBuoy, design: str, steps: Sequence[Stepped | Angle], motions: FloatArray
) -> FloatArray:
    """Derivatives of the motions N that clamp and mooring leave free, shape (variable, dof, free).

    Of Phi N = 0 remains Phi dN = -dPhi N, whose least solution turns the motions without mixing them.
    """
    colatitudes = buoy.study.designs[design].clamp
    if CLAMPED in steps and (len(colatitudes) != 1 or colatitudes[0] in (0.0, 180.0)):
        raise ConfigError(
            f"designs.{design}.clamp: received {list(colatitudes)}; derivatives by it need one clamp between the poles"
        )
    rows = _held(buoy, design)
    if not rows.any():
        return np.zeros((len(steps), *motions.shape))
    inverse = np.linalg.pinv(rows, rcond=DISTINCT)
    turned = [-inverse @ _held_change(buoy, design, one) @ motions for one in steps]
    return np.reshape(turned, (len(steps), *motions.shape))


def displacements(degree: int) -> tuple[Displacement, ...]:
    """Return radial and meridional functions to a degree, or rigid heave alone for degree 0."""
    if not degree:
        return (Displacement("heave"),)
    radial = [Displacement("radial", n) for n in range(degree + 1)]
    return (*radial, *(Displacement("meridional", n) for n in range(1, degree + 1)))


def of_all(values: AnyArray, places: Sequence[int], count: int) -> AnyArray:
    """Return derivatives by all of `count` variables, zero but for those at some places, (variable, ...)."""
    found = np.zeros((count, *values.shape[1:]), values.dtype)
    found[list(places)] = values
    return found
