"""The year of take-offs other than one damper: at several ports, under causal control, with losses in conversion.

The year of a buoy whose take-off acts on several motions at once: by a damper matrix, or spread over its shell.

With dampers C at the ports B and D_c = D - i w B C B^T the motion is q = D_c^-1 X, and the ports move by u = B^T q.
With the year's mean variance density S

    mean power P = int w^2 S u^H C u dw,
    dP = int w^2 S [u^H dC u + 2 Re u^H C dB^T q + 2 Re l^T (dX - dD_c q)] dw,   l = D_c^-1 B C u*.

At the matrix that absorbs most dC does not count: the matrices to choose from, C >= 0, are the same for all buoys. With
a limit of the rms of all forces together, int w^2 S u^H C^2 u dw, that matrix is the best of P less a price times their
mean square: where the limit holds the derivatives are those of this difference, at fixed C and price. The damper spread
over a shell, C = c 1, has a derivative of its own (`SeveralYear.optimal_change`).

The year of a buoy under causal control: one controller, the best at a given rms force in the mean spectrum.

The controller is linear: its mean power and the mean square of its force over the seas of the year are those in the
mean spectrum of the year. See `vsb.engine.motion.causal`. At several ports the rms is that of all forces together. With
the price lambda of its square dP = dL, the derivative of the objective at given lambda, where the limit binds. Where it
does not lambda is small, and dP = dL + lambda d(force^2), of which the latter follows from differences of dL by lambda.

The year's mean power after conversion: a take-off of damper and spring whose two directions of power both lose.

In a sea in which its velocity has the mean square v and its displacement x, a take-off -(c V + k X) absorbs A = c v and
moves B = |k| sqrt(x v) to and fro. Of Gaussian motions it returns R = (B - A theta)/pi, tan theta = B/A, to the sea
(`vsb.engine.motion.tuning.converted_power`), so that with an efficiency eta of both directions

    P = sum over seas of share [eta A - (1/eta - eta) R],
    dR = [sin^2 theta dB - (theta - sin theta cos theta) dA]/pi.

P depends on more of the seas than their mean spectrum, unless k = 0: then P = eta A. With |u|^2 = |u_0|^2/E(c), E(c) a
polynomial (`vsb.design.year.PortYear`), all of it is analytic in c.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.fft import next_fast_len
from scipy.optimize import brentq

from vsb.design.limits import SeaMoments
from vsb.design.resting import STEP
from vsb.design.year import Damper, FrequencyGrid, PortYear, YearMotion, band, chebyshev
from vsb.engine.motion.causal import (
    KEPT,
    LEAST_WEIGHT,
    Controlled,
    GridError,
    RmsLimits,
    Slopes,
    StationaryPort,
    StationaryPorts,
    Weights,
    numerical_error,
    optimum,
    slopes,
    steadiest,
)
from vsb.engine.motion.port import Ports
from vsb.engine.motion.take_off import Control
from vsb.engine.motion.tuning import Kind, best_matrix, priced_matrix
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.seas import RESOLVED
from vsb.errors import ConvergenceError
from vsb.models.stationary import BEYOND, grid
from vsb.tools.arrays import AnyArray, ComplexArray, FloatArray

NEWTON_STEPS = 5
"""From where quasi-Newton ends: of ports that matter powers are then optimal to 1e-9 and better."""


@dataclass(frozen=True)
class SeveralYear:
    """The ports of a buoy over the year."""

    motion: YearMotion  # without dampers

    @cached_property
    def ports(self) -> Ports:
        """Free velocities and admittances of the ports over the year."""
        (q, under), rows, w = self.motion.undamped, self.motion.rows, self.motion.grid.omega
        return Ports(w, -1j * w[:, None, None] * (rows @ under), -1j * w[:, None] * (q @ rows.T))

    def best(self, kind: Kind) -> FloatArray:
        """Return the damper matrix of a kind that absorbs most over the year, shape (port, port)."""
        found = best_matrix(self.ports, 2 * self.motion.grid.variance, kind, NEWTON_STEPS).damping
        if kind != "uniform" or not found.any():
            return found
        damper = float(found[0, 0])
        for _ in range(NEWTON_STEPS):
            slope, change = self._optimality(damper)
            damper *= float(np.exp(-slope / (change[-1] * damper)))
        return damper * np.eye(len(found))

    def within(self, force: float, kind: Kind) -> tuple[FloatArray, float]:
        """Return the best matrix with a given rms of all forces together at most, and the price of their square."""
        found, price = priced_matrix(self.ports, 2 * self.motion.grid.variance, force, kind, NEWTON_STEPS)
        return found.damping, price

    def absorbed(self, dampers: FloatArray) -> FloatArray:
        """Return the part of the mean power of each frequency, shape (omega,) [W]."""
        return 2 * self.motion.grid.variance * self.ports.power(dampers)

    def power(self, dampers: FloatArray, by: FloatArray | None = None, price: float = 0.0) -> tuple[float, FloatArray]:
        """Return the mean power under a damper matrix [W], and its derivatives by the variables, shape (variable,).

        Parameters
        ----------
        dampers : ndarray, shape (port, port)
        by : ndarray, shape (variable, port, port)
            Derivatives of it; none: 0.
        price : float [m/(N s)]
            Less this times the mean square of all forces.
        """
        q, u, weight = self._moved(dampers)
        force = u.conj() @ (dampers - price * dampers @ dampers)
        slopes = 2 * self._slopes(force, q, dampers, by).real
        if by is not None:
            slopes = slopes + ((by @ u.T) * u.conj().T).real.sum(axis=1)
        return float(weight @ (force * u).sum(axis=1).real), slopes @ weight

    @property
    def changes(self) -> tuple[ComplexArray, ComplexArray]:
        """Derivatives of u_0 (variable, omega, port) and of y = B^T D^-1 B (variable, omega, port, port), no dampers.

        With l = D^-1 B they are dB^T q + l^T (dX - dD q) and dB^T l + its transpose - l^T dD l.
        """
        motion, (q, under) = self.motion, self.motion.undamped
        loads, none = np.moveaxis(under, -1, 0), np.zeros((len(motion.rows), len(motion.rows)))
        moved = np.array([motion.slopes(load, q, none) for load in loads]) + np.swapaxes(motion.row_changes @ q.T, 0, 1)
        turned = np.swapaxes(motion.row_changes[:, None] @ under, -1, -2)
        own = np.array([[motion.reaction(one, other, none) for other in loads] for one in loads])
        receptance = turned + turned.swapaxes(-1, -2) - own.transpose(2, 3, 0, 1)
        return moved.transpose(1, 2, 0), receptance

    def optimal_change(self, damper: float) -> FloatArray:
        """Return the derivatives of the optimal damper spread over the shell, shape (variable,)."""
        change = self._optimality(damper)[1]
        return np.asarray(-change[:-1] / change[-1])

    def _moved(self, dampers: FloatArray) -> tuple[ComplexArray, ComplexArray, FloatArray]:
        """Motion q beside dampers (omega, free), that of the ports u (omega, port), and w^2 S dw (omega,)."""
        q = self.motion.damped(dampers, self.motion.undamped[0])
        return q, q @ self.motion.rows.T, self.motion.grid.omega**2 * self.motion.grid.variance

    def _under(self, force: ComplexArray, dampers: FloatArray) -> ComplexArray:
        """D_c^-1 B f under forces at the ports (omega, port), shape (omega, free)."""
        return self.motion.damped(dampers, (self.motion.undamped[1] @ force[..., None])[..., 0])

    def _slopes(
        self, force: ComplexArray, q: ComplexArray, dampers: FloatArray, by: FloatArray | None = None
    ) -> ComplexArray:
        """Derivatives of f.u at fixed f, f.(dB^T q) + l^T (dX - dD_c q), shape (variable, omega)."""
        own = ((self.motion.row_changes @ q.T) * force.T).sum(axis=1)
        return np.asarray(own + self.motion.slopes(self._under(force, dampers), q, dampers, by))

    def _optimality(self, c: float) -> tuple[float, FloatArray]:
        """dP/dc of a damper spread over the shell, and its derivatives by the variables and by c, (variable + 1,).

        dP/dc = int w^2 S [|u|^2 + 2 c Re i w u^H y u] dw, y = B^T D_c^-1 B: du counts by a = u* - 2 w c Im(y) u*, and
        dy = dB^T (D_c^-1 B) + its transpose - (D_c^-1 B)^T dD_c (D_c^-1 B).
        """
        dampers = c * np.eye(len(self.motion.rows))
        q, u, weight = self._moved(dampers)
        w, conj = self.motion.grid.omega, u.conj()
        at, under = self._under(u, dampers), self._under(conj, dampers)
        y_u, y_conj = at @ self.motion.rows.T, under @ self.motion.rows.T
        stored = 1j * w * (conj * y_u).sum(axis=1)
        slope = float(weight @ ((np.abs(u) ** 2).sum(axis=1) + 2 * c * stored.real))
        force = conj + 1j * w[:, None] * c * (y_conj - y_u.conj())
        by_u, rows = self._slopes(force, q, dampers), self.motion.row_changes
        by_y = ((rows @ at.T) * conj.T + (rows @ under.T) * u.T).sum(axis=1)
        by_y = by_y - self.motion.reaction(under, at, dampers)
        by_c = 2j * w * (force * y_u).sum(axis=1) + 2 * stored - 2 * c * w**2 * (y_conj * y_u).sum(axis=1)
        slopes = 2 * by_u.real + 2 * c * (1j * w * by_y).real
        return slope, np.append(slopes @ weight, weight @ by_c.real)


SOLVED = 2.5
"""End of the band whose coefficients are solved, over that of the climate's waves: the controller acts there, too. With
more of it the gain of the example changes by less than 0.001 points."""


def controlled_band(climate: Climate, omega_max: float) -> tuple[float, float]:
    """Return the band solved for causal control, up to a given frequency at most [rad/s]."""
    low, high = band(climate, omega_max)
    return low, min(SOLVED * high, omega_max)


@dataclass(frozen=True)
class ControlGrid(FrequencyGrid):
    """The frequencies of a causal controller, (k + 1/2) spacing within the band solved, and some beyond it.

    Outside the band added mass and radiation damping are those of its nearest end. Between the frequencies of the
    climate its mean density is a broken line, scaled such that the variance is that of its bands.
    """

    ends: tuple[float, float]  # of the band solved [rad/s]
    spacing: float  # [rad/s]
    count: int  # of frequencies in the band
    climate: Climate
    further: float  # end of the frequencies beyond the band, over its own

    @classmethod
    def of_control(
        cls, climate: Climate, omega_max: float, solves: int, finer: float = 1.0, further: float = BEYOND
    ) -> "ControlGrid":
        """Return the grid of a climate up to a highest frequency [rad/s]; a finer one has less spacing."""
        low, high = controlled_band(climate, omega_max)
        spacing = RESOLVED * 2 * np.pi / (finer * float(climate.te @ climate.hours))
        count = next_fast_len(int(np.ceil(high / spacing)))
        inside, beyond = grid(spacing, count, further)
        density, edges = climate.mean_density, np.clip(climate.edges, *band(climate, omega_max))
        broken = np.interp(inside, climate.omega, density, left=0.0, right=0.0)
        variance = np.append(broken * (density @ np.diff(edges)) / broken.sum(), np.zeros_like(beyond))
        omega = np.append(inside, beyond)
        solved = chebyshev(low, high, solves)
        return cls(solved, omega, variance, (low, high), spacing, count, climate, further)

    def finer(self, times: float) -> "ControlGrid":
        """Return the same with less spacing."""
        own = RESOLVED * 2 * np.pi / (self.spacing * float(self.climate.te @ self.climate.hours))
        return self.of_control(self.climate, self.ends[1], len(self.solved), times * own, self.further)

    @cached_property
    def known(self) -> FloatArray:
        """Frequencies whose coefficients stand for those at all frequencies, shape (omega,) [rad/s]."""
        return np.clip(self.omega, *self.ends)

    def throughout(self, values: AnyArray) -> AnyArray:
        """Return values at all frequencies of the controller from those at the frequencies of this grid, last axis."""
        end = (np.round(self.omega[-1] / self.spacing + 0.5)).astype(int)
        beyond = (np.arange(self.count, end) + 0.5) * self.spacing
        place = np.interp(np.log(beyond), np.log(self.omega[self.count :]), np.arange(len(self.omega) - self.count))
        low = self.count + np.minimum(place.astype(int), len(self.omega) - self.count - 2)
        part = self.count + place - low
        between = (1 - part) * values[..., low] + part * values[..., low + 1]
        return np.concatenate([values[..., : self.count], between], axis=-1)


LATE = 0.03
"""Part of the rms of a controller's signal that may be left in the second half of the times it may last."""


@dataclass(frozen=True)
class ControlledYear:
    """A buoy's port over the year under the best causal controller within limits, or the damper that absorbs more."""

    year: PortYear
    limits: RmsLimits
    control: Control

    @cached_property
    def port(self) -> StationaryPort:
        """The port in the year's mean spectrum."""
        grid, omega = self._grid, self.year.grid.omega
        density = omega**2 * grid.variance * np.abs(self.year.motion) ** 2 / grid.spacing
        admittance = grid.throughout(-1j * omega * self.year.receptance)
        passive = np.maximum(admittance.real, 0.0) + 1j * admittance.imag
        return StationaryPort(grid.spacing, passive, grid.throughout(density))

    @property
    def _grid(self) -> ControlGrid:
        assert isinstance(self.year.grid, ControlGrid)
        return self.year.grid

    @cached_property
    def found(self) -> Controlled:
        """The optimum, or, where no control keeps the stroke, the one with the least: a search looks beyond limits."""
        if not self.keeps_stroke:
            return self.steadiest
        return optimum(self.port, self.limits, self.control.noise, self.control.forecast)

    @cached_property
    def steadiest(self) -> Controlled:
        """The control with the least stroke."""
        return steadiest(self.port, self.limits.force, self.control.noise, self.control.forecast)

    @property
    def resolved(self) -> bool:
        """Whether its signals have died away at the end of the times that its frequencies tell apart."""
        try:
            return self.port.lasts(self.found.weights, self.control.noise, self.control.forecast) <= LATE
        except ConvergenceError:  # not found: it outlasts them
            return False

    @property
    def keeps_stroke(self) -> bool:
        """Whether some control keeps the stroke."""
        limit = self.limits.stroke
        return bool(np.isinf(limit)) or self.steadiest.stroke_rms <= limit * (1 + KEPT)

    @cached_property
    def damper(self) -> Damper | None:
        """The best damper of the same rms force, where it absorbs more than the controller."""
        best = self.year.damper_within(self.limits.force)
        return best if best.power > self.found.power and best.stroke <= self.limits.stroke else None

    @property
    def absorbed(self) -> tuple[FloatArray, FloatArray, float]:
        """Frequencies [rad/s], mean power by frequency, shape (omega,), and what noise loses of it in each sea [W]."""
        if self.damper:
            return self.year.grid.omega, self.year.absorbed(self.damper.damping), 0.0
        port, noise = self.port, self.control.noise
        gain = port.controller(self.found.weights, noise, self.control.forecast)
        lost = port.integral(port.admittance.real * np.abs(gain) ** 2) * noise * float(port.excitation.max())
        return port.omega, port.spacing * port.absorbed(gain), lost

    @property
    def other_levels(self) -> dict[str, float]:
        """Mean power of the best damper whose force has the same rms, and with the future known [W]."""
        damper = self.year.damper_within(self.found.force_rms)
        return {"damper_same_force": damper.power, "future_known": optimum(self.port, self.limits, 0.0, np.inf).power}

    @property
    def grid_error(self) -> GridError:
        """Error of the power by the grid."""
        return _grid_error(self, self.damper.power if self.damper else 0.0)

    @property
    def slopes(self) -> Slopes:
        """Derivatives of power and mean squares by the variables."""
        return self._slopes(self.found, steadiest=not self.keeps_stroke)

    @property
    def least_stroke(self) -> tuple[float, FloatArray]:
        """Least rms stroke within the limit of force [m], and its derivatives by the variables, shape (variable,)."""
        rms = self.steadiest.stroke_rms
        return rms, self._slopes(self.steadiest, steadiest=True).stroke / (2 * rms)

    def _slopes(self, found: Controlled, *, steadiest: bool) -> Slopes:
        """Derivatives of an optimum."""
        grid, year = self._grid, self.year
        admittance = grid.throughout(-1j * grid.omega * year.receptance_change)
        admittance = np.where(self.port.admittance.real > 0, admittance.real, 0.0) + 1j * admittance.imag
        moved = 2 * np.real(year.motion.conj() * year.motion_change)
        density = grid.throughout(grid.omega**2 * grid.variance * moved / grid.spacing)
        known = self.control
        return slopes(self.port, found, admittance, density, known.noise, known.forecast, steadiest=steadiest)


NEARBY = 2e-3
"""Relative change of a price in a difference."""


@dataclass(frozen=True)
class ControlledPorts:
    """The ports of a buoy over the year under the best causal controller with an rms of all forces together at most."""

    year: SeveralYear
    limits: RmsLimits  # that of the force
    control: Control
    kind: Kind  # of the dampers it is compared with

    @cached_property
    def _ports(self) -> StationaryPorts:
        """The ports in the year's mean spectrum."""
        ports, grid = self.year.ports, self._grid
        density = grid.variance[:, None, None] / grid.spacing * _product(ports.velocity, ports.velocity)
        return StationaryPorts(grid.spacing, self._throughout(ports.admittance), self._throughout(density))

    @cached_property
    def _forces(self) -> FloatArray:
        """Forces of the ports that move (port, force)."""
        return self._ports.moving()

    @cached_property
    def port(self) -> StationaryPorts:
        """What moves of the ports."""
        return self._ports.over(self._forces)

    @property
    def _grid(self) -> ControlGrid:
        assert isinstance(self.year.motion.grid, ControlGrid)
        return self.year.motion.grid

    def _throughout(self, values: ComplexArray) -> ComplexArray:
        """Values of pairs of ports at all frequencies, (omega, port, port), from those of the grid."""
        return np.moveaxis(self._grid.throughout(np.moveaxis(values, 0, -1)), -1, 0)

    @cached_property
    def found(self) -> Controlled:
        """The optimum."""
        return optimum(self.port, self.limits, self.control.noise, self.control.forecast)

    @cached_property
    def damper(self) -> tuple[FloatArray, float] | None:
        """The best damper matrix of the same rms force and its price, where it absorbs more than the controller."""
        dampers, price, power = self._damper_within(self.limits.force)
        return (dampers, price) if power > self.found.power else None

    def _damper_within(self, force: float) -> tuple[FloatArray, float, float]:
        """The best damper matrix of an rms force, the price of its square, and its mean power [W]."""
        free = np.isinf(force)
        dampers, price = (self.year.best(self.kind), 0.0) if free else self.year.within(force, self.kind)
        return dampers, price, float(self.year.absorbed(dampers).sum())

    @property
    def grid_error(self) -> GridError:
        """As of `ControlledYear`."""
        return _grid_error(self, float(self.year.absorbed(self.damper[0]).sum()) if self.damper else 0.0)

    @property
    def binds(self) -> bool:
        """Whether the limit of the force binds."""
        return self.found.weights.force > LEAST_WEIGHT * self.port.largest_loss * (1 + KEPT)

    @property
    def slopes(self) -> Slopes:
        """Derivatives of power and mean square of all forces by the variables."""
        changes, weight = self._changes, self.found.weights.force
        slope = self._slopes(weight, changes)
        if self.binds:
            return Slopes(slope, np.zeros_like(slope), np.zeros_like(slope))
        apart = [weight * (1 + NEARBY), weight * (1 - NEARBY)]
        by_weight = self._slopes(apart[0], changes) - self._slopes(apart[1], changes)
        squares = [self.port.controlled(Weights(one), self.control.noise, self.control.forecast).force for one in apart]
        loss, vectors = np.linalg.eigh(self.port.admittance.real)
        largest = int(loss[:, -1].argmax())
        most = vectors[largest, :, -1]
        price = LEAST_WEIGHT * np.array([most @ one[largest].real @ most for one, _ in changes])
        square = ((squares[0] - squares[1]) * price - by_weight) / (apart[0] - apart[1])
        return Slopes(slope + weight * square, square, np.zeros_like(slope))

    def _slopes(self, weight: float, changes: Sequence[tuple[ComplexArray, ComplexArray]]) -> FloatArray:
        """Derivatives of the objective at a price of the force, shape (variable,)."""
        return self.port.slopes(Weights(weight), self.control.noise, self.control.forecast, changes)

    @property
    def _changes(self) -> list[tuple[ComplexArray, ComplexArray]]:
        """Derivatives of admittance and density of what moves by each variable, each shape (omega, force, force)."""
        grid, w, found = self._grid, self._grid.omega, []
        for free, receptance in zip(*self.year.changes, strict=True):
            product = _product(-1j * w[:, None] * free, self.year.ports.velocity)
            density = grid.variance[:, None, None] / grid.spacing * (product + product.conj().swapaxes(1, 2))
            found.append((self._moving(-1j * w[:, None, None] * receptance), self._moving(density)))
        return found

    def _moving(self, values: ComplexArray) -> ComplexArray:
        """The same of what moves, (omega, force, force)."""
        return np.asarray(self._forces.T @ self._throughout(values) @ self._forces)

    @property
    def absorbed(self) -> tuple[FloatArray, FloatArray, float]:
        """As of `ControlledYear`."""
        if self.damper:
            return self.year.motion.grid.omega, self.year.absorbed(self.damper[0]), 0.0
        port, noise = self.port, self.control.noise
        gain = port.controller(self.found.weights, noise, self.control.forecast)
        loss = gain.conj().swapaxes(1, 2) @ port.admittance.real @ gain
        along = port.admittance.conj().swapaxes(1, 2) @ gain - loss
        power = np.einsum("wij,wji->w", along, port.excitation).real * port.spacing
        peak = float(np.einsum("wii->w", port.excitation).real.max())
        return port.omega, power, port.integral(np.einsum("wii->w", loss)) * noise * peak

    @property
    def other_levels(self) -> dict[str, float]:
        """As of `ControlledYear`."""
        within = RmsLimits(self.found.force_rms)
        known = optimum(self.port, within, 0.0, np.inf).power
        return {"damper_same_force": self._damper_within(within.force)[2], "future_known": known}


def _grid_error(year: ControlledYear | ControlledPorts, damped: float) -> GridError:
    """Error by the grid of a controller, or of a damper that absorbs more, with its power [W]."""
    error = numerical_error(year.port, year.found, year.control.noise, year.control.forecast)
    return error.of_damper(year.found.power / damped) if damped else error


def _product(one: ComplexArray, other: ComplexArray) -> ComplexArray:
    """Return products v w^H of vectors at each frequency, (omega, port, port)."""
    return np.asarray(one[:, :, None] * other[:, None, :].conj())


AROUND = np.logspace(-3.0, 3.0, 61)
"""Dampers tried, over the one that is optimal without losses."""
ROOT_STEPS = 3


@dataclass(frozen=True)
class ConvertedYear:
    """The port of a buoy over the seas of a year, its take-off's power after conversion."""

    port: PortYear
    seas: SeaMoments
    efficiency: float
    spring: float  # k [N/m]

    def of_seas(self, damper: AnyArray | float) -> AnyArray:
        """Return the mean power of a damper in each sea, shape (sea,) [W]."""
        to_and_fro, absorbed, theta, _ = self._turned(damper)
        return np.asarray(self.efficiency * absorbed - self._lost * (to_and_fro - absorbed * theta) / np.pi)

    def slopes(self, damper: complex, spring_change: FloatArray) -> AnyArray:
        """Return the derivatives of the mean power by the variables at a fixed damper, and by it, (variable + 1,).

        Parameters
        ----------
        damper : complex [N s/m]
        spring_change : ndarray, shape (variable,)
            Derivatives of the spring.
        """
        w, (flat, bend, e), free = self.port.grid.omega, self._around(damper), np.abs(self.port.motion) ** 2
        to_and_fro, absorbed, theta, (x, v) = self._turned(damper)
        size = absorbed**2 + to_and_fro**2
        sine, both = _ratio(to_and_fro**2, size), _ratio(absorbed * to_and_fro, size)
        by_b = -self.seas.climate.hours * self._lost * sine / np.pi
        by_a = self.seas.climate.hours * (self.efficiency + self._lost * (theta - both) / np.pi)
        swing = np.sqrt(_ratio(x, v))
        by_v = by_a * damper + by_b * abs(self.spring) * swing / 2
        by_x = by_b * abs(self.spring) * _ratio(np.ones_like(swing), swing) / 2
        weight = self.seas.back(by_x) + w**2 * self.seas.back(by_v)
        y, y_change = self.port.receptance, self.port.receptance_change
        e_change = 2 * w * y_change.imag * damper + 2 * (w * damper) ** 2 * (y.conj() * y_change).real
        change = 2 * (self.port.motion.conj() * self.port.motion_change).real / e - free * e_change / e**2
        by_spring = np.sign(self.spring) * (by_b @ np.sqrt(x * v))
        by_damper = by_a @ v - weight @ (free * (flat + 2 * damper * bend) / e**2)
        return np.append(change @ weight + spring_change * by_spring, by_damper)

    @cached_property
    def optimal_damping(self) -> float:
        """The damper with the most power [N s/m]."""
        none = np.zeros(len(self.port.motion_change))
        tried = self.port.optimal_damping * AROUND
        best = int(np.argmax([self.seas.climate.hours @ self.of_seas(c) for c in tried]))

        def slope(c: float) -> float:
            return float(np.real(self.slopes(c, none)[-1]))

        low, high = tried[max(best - 1, 0)], tried[min(best + 1, len(tried) - 1)]
        found = float(brentq(slope, low, high, rtol=1e-8)) if slope(low) > 0 > slope(high) else float(tried[best])
        for _ in range(ROOT_STEPS):
            found *= float(np.exp(-slope(found) / (self._bend(found, none)[-1] * found)))
        return found

    def optimal_damping_change(self, spring_change: FloatArray) -> FloatArray:
        """Return its derivatives by the variables, -(d2P/dc dx)/(d2P/dc2), shape (variable,)."""
        bend = self._bend(self.optimal_damping, spring_change)
        return np.asarray(-bend[:-1] / bend[-1])

    def _bend(self, c: float, spring_change: FloatArray) -> FloatArray:
        """Derivatives of `slopes` by the damper, by the complex step."""
        return np.asarray(np.imag(self.slopes(c * (1 + 1j * STEP), spring_change)) / (c * STEP))

    @property
    def _lost(self) -> float:
        return 1 / self.efficiency - self.efficiency

    def _around(self, c: AnyArray | complex) -> tuple[FloatArray, FloatArray, AnyArray]:
        """Coefficients of E by c and c^2, and E, each shape (omega,)."""
        w, y = self.port.grid.omega, self.port.receptance
        flat, bend = 2 * w * y.imag, (w * np.abs(y)) ** 2
        return flat, bend, np.asarray(1 + flat * c + bend * c**2)

    def _turned(self, c: AnyArray | complex) -> tuple[AnyArray, AnyArray, AnyArray, tuple[AnyArray, AnyArray]]:
        """B, A and theta in each sea, and x and v."""
        square = np.abs(self.port.motion) ** 2 / self._around(c)[2]
        x, v = self.seas.of(square), self.seas.of(square * self.port.grid.omega**2)
        absorbed, to_and_fro = c * v, abs(self.spring) * np.sqrt(x * v)
        return to_and_fro, absorbed, np.arctan(_ratio(to_and_fro, absorbed)), (x, v)


def _ratio(one: AnyArray, other: AnyArray) -> AnyArray:
    """One over another, 0 in still water."""
    return np.asarray(np.divide(one, other, out=np.zeros_like(other), where=other != 0))
