"""Quadratic drag in the frequency domain: the port of a buoy that a drag brakes, by equivalent linearisation.

Drag c |u| u of the velocity u past the water (`vsb.engine.motion.forces.QuadraticDrag`) dissipates as much as a damper

    D = 8/(3 pi) c |U|    in a regular wave,        D = sqrt(8/pi) c s    in a sea of standard deviation s of u,

the first harmonic in the former, the least mean square error in the latter, Gaussian. The motion depends on D in turn:
D = g(D), and as more damping never makes u larger, g decreases and there is one such D.

With the take-off's port b and the dragged directions d, per frequency and unit wave amplitude,

    V_b = V_b0 - Y_bb F_b - Y_bd F_d,   V_d = V_d0 - Y_bd F_b - Y_dd F_d,   F_d = D u,   u = V_d - w.

With several directions, each has its own D, in the motion with all of them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize.elementwise import find_root

from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import Port
from vsb.engine.motion.tuning import MARGIN, Load, best_dampers, best_pairs, climbed, electrical_power
from vsb.errors import ConvergenceError
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

REGULAR, GAUSSIAN = 8 / (3 * np.pi), np.sqrt(8 / np.pi)
"""Linear damping over drag coefficient and amplitude of u, or over its standard deviation."""
CONVERGED = 1e-12
"""Relative tolerance on D."""
STEP = 0.25
"""Step of the logarithms of the dampers tried first."""
MOST_TURNS = 200
"""Most iterations for the dampers of several directions."""
ROUNDS = 4
"""Iterations of drag and its optimal pair, before pairs are compared at their own drag."""


class Relative(NamedTuple):
    """Flow past the dragged directions and their admittance under loads at the port, per load."""

    flow: ComplexArray  # u without drag, per wave amplitude (load, omega, dragged) [1/s]
    admittance: ComplexArray  # of d (load, omega, dragged, dragged) [m/(N s)]

    def with_drag(self, drag: FloatArray, at: IntArray) -> ComplexArray:
        """Return u under the drag's dampers (case, dragged), each case at one of the loads, (case, omega, dragged)."""
        held = self.admittance[at] * drag[:, None, None, :]
        if held.shape[-1] == 1:
            return np.asarray(self.flow[at] / (1 + held[..., 0]))
        return np.asarray(np.linalg.solve(np.eye(held.shape[-1]) + held, self.flow[at][..., None])[..., 0])


@dataclass(frozen=True)
class DraggedPort:
    """A port of one design, beside directions that quadratic drag acts on."""

    port: Port  # without drag
    across: ComplexArray  # Y_bd (omega, dragged) [m/(N s)]
    own: ComplexArray  # Y_dd (omega, dragged, dragged) [m/(N s)]
    past: ComplexArray  # V_d0 - w per wave amplitude (omega, dragged) [1/s]
    coefficient: FloatArray  # c (dragged,) [kg/m]

    @classmethod
    def of(
        cls,
        buoy: LinearSystem,
        omega: FloatArray,
        motions: FloatArray,
        direction: FloatArray,
        dragged: FloatArray,
        flow: ComplexArray,
        coefficient: FloatArray,
    ) -> "DraggedPort":
        """Return the port of a design, of a floating system in the waves of the flow.

        Parameters
        ----------
        omega : ndarray, shape (omega,) [rad/s]
            Outside its band with the coefficients of the nearest end.
        motions, direction, dragged : ndarray, shapes (dof, free), (dof,) and (dragged, dof)
            Those allowed, b and d.
        flow : ndarray, shape (omega, dragged)
            w per wave amplitude [1/s].
        coefficient : ndarray, shape (dragged,) [kg/m]
        """
        rate = -1j * omega
        equation = buoy.extended_equation(omega)
        moved = [equation.free_motion(motions, one) for one in dragged]
        forced = np.stack([free_velocity for _, free_velocity in moved], axis=-1)  # (omega, dof, dragged)
        port = equation.port(motions, direction)
        across = rate[:, None] * np.einsum("wdk,d->wk", forced, direction)
        return cls(
            port,
            across if port.moves else np.zeros_like(across),
            rate[:, None, None] * (dragged @ forced),
            rate[:, None] * (moved[0][0] @ dragged.T) - flow,
            coefficient,
        )

    @classmethod
    def joined(cls, ports: Sequence["DraggedPort"]) -> "DraggedPort":
        """Return ports in waves of several directions as one, at the frequencies of each, one after the other."""
        parts = [(p.port.omega, p.port.admittance, p.port.velocity, p.across, p.own, p.past) for p in ports]
        omega, admittance, velocity, *beside = (np.concatenate(part) for part in zip(*parts, strict=True))
        across, own, past = beside
        port = Port(omega, admittance, velocity, ports[0].port.compliance)
        return cls(port, across, own, past, ports[0].coefficient)

    def beside(self, damping: FloatArray) -> Port:
        """Return the port with linear dampers D, shape (dragged,), in place of the drag."""
        inside = np.eye(len(damping)) + self.own * damping
        held = np.linalg.solve(inside.transpose(0, 2, 1), (damping * self.across)[..., None])[..., 0]
        return Port(
            self.port.omega,
            self.port.admittance - np.einsum("wk,wk->w", held, self.across),
            self.port.velocity - np.einsum("wk,wk->w", held, self.past),
            self.port.compliance,
        )

    def seen(self, damping: FloatArray, stiffness: FloatArray) -> Relative:
        """Return the relative flow under loads; dampers and springs of shape (load,)."""
        load = self.port.load(damping, stiffness)
        held = self.across * (load / (1 + self.port.admittance * load))[..., None]
        flow = self.past - held * self.port.velocity[:, None]
        return Relative(flow, self.own - held[..., :, None] * self.across[:, None, :])

    def spread(self, force: ComplexArray, damping: FloatArray, squares: FloatArray) -> FloatArray:
        """Return the root mean squares of u (dragged,) [m/s] under a force at the port (omega,) [N/m] and dampers D."""
        flow = Relative((self.past - self.across * force[:, None])[None], self.own[None])
        moved = flow.with_drag(damping[None], np.zeros(1, dtype=np.intp))[0]
        return np.asarray(np.sqrt(0.5 * squares @ np.abs(moved) ** 2))

    def equivalent(self, squares: FloatArray, damping: FloatArray, stiffness: FloatArray) -> FloatArray:
        """Return D of every load in every sea, shape (load, sea, dragged) [N s/m].

        Seas are squared amplitudes (sea, omega) [m^2]; dampers [N s/m] and springs [N/m] have shape (load,). Raises
        `ConvergenceError` if the dampers of several directions do not converge.
        """
        seen, single = self.seen(damping, stiffness), (squares > 0).sum(axis=1) == 1
        factor = np.where(single, REGULAR, GAUSSIAN * np.sqrt(0.5))
        load, sea = np.indices((len(damping), len(squares))).reshape(2, -1)

        def given(drag: FloatArray, case: IntArray) -> FloatArray:
            strength = np.abs(seen.with_drag(drag, load[case])) ** 2
            spread = np.sqrt(np.einsum("cwk,cw->ck", strength, squares[sea[case]]))
            return np.asarray(self.coefficient * factor[sea[case], None] * spread)

        dragged = len(self.coefficient)
        solved = _one_equivalent(given, len(load)) if dragged == 1 else _several_equivalent(given, len(load), dragged)
        return solved.reshape(len(damping), len(squares), -1)

    def powers(
        self, squares: FloatArray, damping: FloatArray, stiffness: FloatArray, efficiency: float = 1.0
    ) -> FloatArray:
        """Return the mean power of every load in every sea, with drag at its own D, shape (load, sea) [W]."""
        drag, seen = self.equivalent(squares, damping, stiffness), self.seen(damping, stiffness)
        load, every = self.port.load(damping, stiffness), np.arange(len(damping))
        out = np.empty(drag.shape[:2])
        for sea, square in enumerate(squares):
            braking = drag[:, sea, None, :] * seen.with_drag(drag[:, sea], every)
            free_velocity = self.port.velocity - np.einsum("wk,lwk->lw", self.across, braking)
            speed = 0.5 * square * np.abs(free_velocity / (1 + self.port.admittance * load)) ** 2
            mean = speed.sum(axis=1), (speed / self.port.omega**2).sum(axis=1)
            out[:, sea] = electrical_power(damping, stiffness, *mean, efficiency)
        return out


Given = Callable[[FloatArray, IntArray], FloatArray]
"""Dampers (case, dragged) in place, case numbers -> dampers equivalent to their motion, of the same shape."""


def _one_equivalent(given: Given, cases: int) -> FloatArray:
    """Dampers of one direction, shape (case, 1): the root between 0 and the damper without drag."""
    most = given(np.zeros((cases, 1)), np.arange(cases))[:, 0]

    def missing(d: FloatArray, case: IntArray) -> FloatArray:
        return d - given(d[:, None], case)[:, 0]

    bracket = (np.zeros_like(most), 1.001 * most + 1e-300)
    solution = find_root(missing, bracket, args=(np.arange(cases),), tolerances={"xrtol": CONVERGED})
    return np.asarray(solution.x)[:, None]


def _several_equivalent(given: Given, cases: int, count: int) -> FloatArray:
    """Dampers of several directions, shape (case, dragged).

    Each step goes halfway to the equivalent ones on a logarithmic scale: these decrease with the damper, at most in
    proportion, so that a step leaves at most half of the distance.
    """
    every = np.arange(cases)
    solved = given(np.zeros((cases, count)), every)
    for _ in range(MOST_TURNS):
        before, solved = solved, np.sqrt(solved * given(solved, every))
        if np.all(np.abs(solved - before) <= CONVERGED * solved):
            return solved
    raise ConvergenceError("drag: the equivalent dampers of its directions do not converge")


def with_load(port: DraggedPort, squares: FloatArray, damping: float, stiffness: float, efficiency: float) -> Load:
    """Return one load and its power in every sea."""
    power = port.powers(squares, np.array([damping]), np.array([stiffness]), efficiency)[0]
    return Load(np.full(len(squares), damping), np.full(len(squares), stiffness), power)


def best_damper(port: DraggedPort, squares: FloatArray, stiffness: float, efficiency: float) -> float:
    """Return the damper with the largest sum of power over seas (sea, omega) [m^2] beside a given spring [N s/m]."""
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
    """Return the optimal spring and damper in one sea (1, omega) [m^2], of the maxima reached from a linear drag's.

    The load given is an optimal damper beside the given spring: the result absorbs no less.
    """
    if not port.port.moves:
        return given
    pair, softest = given, port.port.softest_spring
    least = np.finfo(float).tiny  # whose logarithm is one, where nothing holds the port
    for _ in range(ROUNDS):
        drag = port.equivalent(squares, pair.damping, pair.stiffness)[0, 0]
        pair = best_pairs(port.beside(drag), squares, given, efficiency)

    def load(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.exp(x[:, 0]), softest + np.exp(np.maximum(x[:, 1], np.log(max(-MARGIN * softest, least))))

    def power(x: FloatArray, _: object = None) -> FloatArray:
        return port.powers(squares, *load(x), efficiency)[:, 0]

    held = [(p.damping[0], max(p.stiffness[0] - softest, least)) for p in (pair, given)]
    starts = np.log(held)
    x, reached = climbed(power, starts, np.full(starts.shape, STEP / 4))
    best = int(np.argmax(reached))
    damping, stiffness = load(x[[best]])
    return given.elementwise_best(Load(damping, stiffness, reached[[best]]))
