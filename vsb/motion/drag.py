"""Quadratic drag in the frequency domain: the port of a buoy that a drag brakes, by equivalent linearisation.

Drag c |u| u of the velocity u past the water (`vsb.motion.forces.QuadraticDrag`) takes as much as a damper

    D = 8/(3 pi) c |U|    in a regular wave,        D = sqrt(8/pi) c s    in a sea of standard deviation s of u,

the first harmonic of the one, the least mean square of what is missed of the other, Gaussian. How fast the buoy moves
follows from D again: D = g(D), and as more damping never makes u larger, g falls and there is one such D.

With the take-off's port b and the dragged direction d, per frequency and unit wave amplitude,

    V_b = V_b0 - Y_bb F_b - Y_bd F_d,   V_d = V_d0 - Y_bd F_b - Y_dd F_d,   F_d = D u,   u = V_d - w.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize.elementwise import find_root

from vsb.motion.frequency import LinearBuoy
from vsb.motion.port import Port
from vsb.motion.tuning import MARGIN, Load, best_dampers, best_pairs, climbed, electrical_power
from vsb.tools.units import ComplexArray, FloatArray

REGULAR, GAUSSIAN = 8 / (3 * np.pi), np.sqrt(8 / np.pi)
"""Linear damping over drag coefficient and amplitude of u, or over its standard deviation."""
SETTLED = 1e-12
"""Of the damping: how well it is solved for."""
STEP = 0.25
"""Step of the logarithms of the dampers tried first."""
ROUNDS = 4
"""Turns of drag and the pair that is best beside it, before pairs are compared at their own drag."""


class Seen(NamedTuple):
    """What the drag sees under loads at the port, each shape (load, omega)."""

    flow: ComplexArray  # u without drag, per wave amplitude [1/s]
    admittance: ComplexArray  # of d [m/(N s)]


@dataclass(frozen=True)
class DraggedPort:
    """A port of one design, beside a direction that quadratic drag acts on."""

    port: Port  # without drag
    across: ComplexArray  # Y_bd (omega,) [m/(N s)]
    own: ComplexArray  # Y_dd (omega,) [m/(N s)]
    past: ComplexArray  # V_d0 - w per wave amplitude (omega,) [1/s]
    coefficient: float  # c [kg/m]

    @classmethod
    def of(
        cls,
        buoy: LinearBuoy,
        omega: FloatArray,
        motions: FloatArray,
        direction: FloatArray,
        dragged: FloatArray,
        flow: ComplexArray,
        coefficient: float,
    ) -> "DraggedPort":
        """Return the port of a design.

        Parameters
        ----------
        buoy : LinearBuoy
        omega : ndarray, shape (omega,) [rad/s]
        motions : ndarray, shape (dof, free)
        direction, dragged : ndarray, shape (dof,)
            b and d.
        flow : ndarray, shape (omega,)
            w per wave amplitude [1/s].
        coefficient : float [kg/m]
        """
        rate = -1j * omega
        free, forced = buoy.free_motion(omega, motions, dragged)
        port = buoy.port(omega, motions, direction)
        return cls(
            port,
            rate * (forced @ direction) if port.moves else np.zeros_like(flow),
            rate * (forced @ dragged),
            rate * (free @ dragged) - flow,
            coefficient,
        )

    def beside(self, damping: float) -> Port:
        """Return the port with a linear damper D in place of the drag."""
        held = damping * self.across / (1 + damping * self.own)
        return Port(
            self.port.omega,
            self.port.admittance - held * self.across,
            self.port.velocity - held * self.past,
            self.port.compliance,
        )

    def seen(self, damping: FloatArray, stiffness: FloatArray) -> Seen:
        """Return what the drag sees under loads; dampers and springs of shape (load,)."""
        load = self.port.load(damping, stiffness)
        held = self.across * load / (1 + self.port.admittance * load)
        return Seen(self.past - held * self.port.velocity, self.own - held * self.across)

    def settled(self, squares: FloatArray, damping: FloatArray, stiffness: FloatArray) -> FloatArray:
        """Return D of every load in every sea, shape (load, sea) [N s/m].

        Parameters
        ----------
        squares : ndarray, shape (sea, omega) [m^2]
        damping, stiffness : ndarray, shape (load,) [N s/m], [N/m]
        """
        seen, single = self.seen(damping, stiffness), (squares > 0).sum(axis=1) == 1
        ratio = self.coefficient * np.where(single, REGULAR, GAUSSIAN * np.sqrt(0.5))
        flow, at = np.abs(seen.flow) ** 2, np.indices((len(damping), len(squares))).reshape(2, -1)

        def given(d: FloatArray, load: npt.NDArray[np.intp], sea: npt.NDArray[np.intp]) -> FloatArray:
            slowed = flow[load] / np.abs(1 + d[:, None] * seen.admittance[load]) ** 2
            return np.asarray(ratio[sea] * np.sqrt(np.sum(slowed * squares[sea], axis=1)))

        def missing(d: FloatArray, load: npt.NDArray[np.intp], sea: npt.NDArray[np.intp]) -> FloatArray:
            return d - given(d, load, sea)

        most = given(np.zeros(at.shape[1]), *at)
        found = find_root(
            missing, (np.zeros_like(most), 1.001 * most + 1e-300), args=tuple(at), tolerances={"xrtol": SETTLED}
        )
        return np.asarray(found.x).reshape(len(damping), len(squares))

    def powers(
        self, squares: FloatArray, damping: FloatArray, stiffness: FloatArray, efficiency: float = 1.0
    ) -> FloatArray:
        """Return the mean power every load takes of every sea, drag at its own D, shape (load, sea) [W]."""
        drag, seen = self.settled(squares, damping, stiffness), self.seen(damping, stiffness)
        load = self.port.load(damping, stiffness)
        out = np.empty(drag.shape)
        for sea, square in enumerate(squares):
            d = drag[:, sea, None]
            pushed = self.port.velocity - d * self.across * seen.flow / (1 + d * seen.admittance)
            speed = 0.5 * square * np.abs(pushed / (1 + self.port.admittance * load)) ** 2
            mean = speed.sum(axis=1), (speed / self.port.omega**2).sum(axis=1)
            out[:, sea] = electrical_power(damping, stiffness, *mean, efficiency)
        return out


def under(port: DraggedPort, squares: FloatArray, damping: float, stiffness: float, efficiency: float) -> Load:
    """Return what one load takes of every sea."""
    power = port.powers(squares, np.array([damping]), np.array([stiffness]), efficiency)[0]
    return Load(np.full(len(squares), damping), np.full(len(squares), stiffness), power)


def best_damper(port: DraggedPort, squares: FloatArray, stiffness: float, efficiency: float) -> float:
    """Return the damper that takes most of the sum of seas beside a given spring [N s/m].

    Parameters
    ----------
    port : DraggedPort
    squares : ndarray, shape (sea, omega) [m^2]
    stiffness : float [N/m]
    efficiency : float
    """
    free = best_dampers(port.port, squares.sum(axis=0, keepdims=True), stiffness, efficiency).damping[0]
    if free == 0.0:
        return 0.0

    def power(x: FloatArray, _: object = None) -> FloatArray:
        powers = port.powers(squares, np.exp(x[:, 0]), np.full(len(x), stiffness), efficiency)
        return np.asarray(powers.sum(axis=1))

    tried = np.log(free) + STEP * np.arange(-16.0, 17.0)[:, None]
    start = tried[[int(np.argmax(power(tried)))]]
    return float(np.exp(climbed(power, start, np.array([[STEP]]))[0][0, 0]))


def best_pair(port: DraggedPort, squares: FloatArray, given: Load, efficiency: float) -> Load:
    """Return spring and damper that take most of one sea, of the maxima reached from the best pair beside a linear one.

    Parameters
    ----------
    port : DraggedPort
    squares : ndarray, shape (1, omega) [m^2]
    given : Load
        A best damper beside the given spring: what is returned takes no less.
    efficiency : float
    """
    if not port.port.moves:
        return given
    pair, softest = given, port.port.softest_spring
    for _ in range(ROUNDS):
        drag = float(port.settled(squares, pair.damping, pair.stiffness)[0, 0])
        pair = best_pairs(port.beside(drag), squares, given, efficiency)

    def load(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.exp(x[:, 0]), softest + np.exp(np.maximum(x[:, 1], np.log(-MARGIN * softest)))

    def power(x: FloatArray, _: object = None) -> FloatArray:
        return port.powers(squares, *load(x), efficiency)[:, 0]

    starts = np.array([[np.log(p.damping[0]), np.log(p.stiffness[0] - softest)] for p in (pair, given)])
    x, found = climbed(power, starts, np.full(starts.shape, STEP / 4))
    best = int(np.argmax(found))
    damping, stiffness = load(x[[best]])
    return given.or_better(Load(damping, stiffness, found[[best]]))
