"""The year's mean power of one buoy and take-off, what the take-off bears, and their derivatives.

With D = -w^2 (M + R) - i w C + K + k b b^T, R = A + i B/w (C1), the motion without a damper is q = D^-1 X, and
l = D^-1 b that under a unit force; the port moves by u = u_0/(1 - i w c y), u_0 = b^T q, y = b^T l. D is symmetric, so
l is also the adjoint state: du_0 = l^T (dX - dD q), dy = -l^T dD l. With the year's mean variance density S,

    mean power P = int c w^2 S |u|^2 dw,  stroke^2 = int S |u|^2 dw,  force^2 = int (c^2 w^2 + k^2) S |u|^2 dw.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from vsb.design.linearised import Linearised
from vsb.engine.hydro.spectral.meridian import unit_rule
from vsb.engine.motion.port import Port
from vsb.engine.motion.tuning import best_damper_of_each
from vsb.engine.waves.climate import Climate
from vsb.errors import ConfigError, ConvergenceError, DatabaseError
from vsb.tools.arrays import ComplexArray, FloatArray


def band(climate: Climate, omega_max: float) -> tuple[float, float]:
    """Return lowest and highest frequency of a climate's waves, the latter at most a given one [rad/s]."""
    edges, held = climate.edges, np.flatnonzero(climate.mean_density)
    low = edges[held[0]] or LOWEST * edges[held[0] + 1]
    if not low < omega_max:
        raise ConfigError(
            f"hydro.omega_max: received {omega_max:g} rad/s; the climate's waves begin at {low:.4g} rad/s"
        )
    return float(low), float(min(edges[held[-1] + 1], omega_max))


def chebyshev(low: float, high: float, count: int) -> FloatArray:
    """Return Chebyshev's points between two frequencies, in the root of frequency, ascending [rad/s]."""
    middle, half = (np.sqrt(low) + np.sqrt(high)) / 2, (np.sqrt(high) - np.sqrt(low)) / 2
    return np.asarray((middle - half * np.cos(np.pi * (np.arange(count) + 0.5) / count)) ** 2)


def interpolation(solved: FloatArray, omega: FloatArray) -> FloatArray:
    """Return values at frequencies per value at Chebyshev's points, shape (omega, solved) [-]; barycentric."""
    count = len(solved)
    weight = (-1.0) ** np.arange(count) * np.sin(np.pi * (np.arange(count) + 0.5) / count)
    apart = np.sqrt(omega)[:, None] - np.sqrt(solved)
    terms = weight / np.where(apart == 0.0, 1e-300, apart)
    return np.asarray(terms / terms.sum(axis=1, keepdims=True))


LOWEST = 0.01
"""Lowest frequency solved in a band that begins at 0, in its width."""


@dataclass(frozen=True)
class FrequencyGrid:
    """Frequencies that coefficients are solved at, and those that the year is integrated over.

    Coefficients are polynomials in the root of frequency through Chebyshev's points: smooth down to the low frequencies
    where added mass goes like w^2 log w. The year is integrated by Gauss' rule in each band of the climate, in which
    its density is constant.
    """

    solved: FloatArray  # ascending (solved,) [rad/s]
    omega: FloatArray  # (omega,) [rad/s]
    variance: FloatArray  # S dw of each (omega,) [m^2]

    @classmethod
    def of(cls, climate: Climate, omega_max: float, solves: int, points: int) -> "FrequencyGrid":
        """Return the grid of a climate up to a highest frequency [rad/s], with `points` in each band."""
        low, high = band(climate, omega_max)
        bounds = np.clip(climate.edges, low, high)
        node, weight = unit_rule(points)
        width = np.diff(bounds)[:, None]
        omega, variance = bounds[:-1, None] + width * node, climate.mean_density[:, None] * width * weight
        used = (variance > 0).ravel()
        return cls(chebyshev(low, high, solves), omega.ravel()[used], variance.ravel()[used])

    @cached_property
    def known(self) -> FloatArray:
        """Frequencies whose coefficients stand for those at the frequencies of the year, shape (omega,) [rad/s]."""
        return self.omega

    @cached_property
    def interpolation(self) -> FloatArray:
        """Values at the frequencies of the year per value at those solved, shape (omega, solved) [-]; barycentric."""
        return interpolation(self.solved, self.known)

    def radiation(self, solved: ComplexArray) -> ComplexArray:
        """Return A + iB/w at the frequencies of the year from A + iB/w at those solved (solved, motion, motion)."""
        found = np.tensordot(self.interpolation, solved, 1)
        return np.asarray(found.real + 1j * (self.known / self.omega)[:, None, None] * found.imag)


class Damper(NamedTuple):
    """The best damper of a given rms force at most."""

    damping: float  # [N s/m]
    change: FloatArray  # derivatives by the variables (variable,)
    power: float  # [W]
    stroke: float  # rms [m]
    worth: float  # relative gain of power per relative widening of the limit of force [-]


@dataclass(frozen=True)
class YearMotion:
    """The free motions of a buoy over the year beside its spring, without its damper; derivatives by each variable."""

    grid: FrequencyGrid
    buoy: Linearised
    change: Linearised
    spring: float  # [N/m]

    @cached_property
    def rows(self) -> FloatArray:
        """Motion of each port per free motion, B^T, shape (port, free) [-]."""
        return np.atleast_2d(self.buoy.port)

    @cached_property
    def row_changes(self) -> FloatArray:
        """Its derivatives by each variable, shape (variable, port, free)."""
        return self.change.port.reshape(-1, *self.rows.shape)

    @cached_property
    def excitation(self) -> ComplexArray:
        """X, shape (omega, free) [N/m]."""
        return np.asarray(self.grid.interpolation @ self.buoy.excitation)

    @cached_property
    def dynamic(self) -> ComplexArray:
        """D, shape (omega, free, free) [N/m]."""
        w, buoy = self.grid.omega[:, None, None], self.buoy
        beside = buoy.stiffness + self.spring * self.rows.T @ self.rows
        return np.asarray(-(w**2) * (buoy.mass + self.grid.radiation(buoy.radiation)) - 1j * w * buoy.damping + beside)

    @cached_property
    def undamped(self) -> tuple[ComplexArray, ComplexArray]:
        """Motion q = D^-1 X in the waves (omega, free) [m], and D^-1 B under unit forces (omega, free, port) [m/N]."""
        loads = np.broadcast_to(self.rows.T, (*self.excitation.shape, len(self.rows)))
        found = np.linalg.solve(self.dynamic, np.concatenate([self.excitation[..., None], loads], axis=-1))
        return found[..., 0], found[..., 1:]

    def damped(self, damper: float | FloatArray, undamped: ComplexArray) -> ComplexArray:
        """Return a motion (D - i w B C B^T)^-1 f beside dampers from the one without, D^-1 f, shape (omega, free) [m].

        Parameters
        ----------
        damper : float or ndarray, shape (port, port)
            C [N s/m], behind the chamber if there is one.
        undamped : ndarray, shape (omega, free) [m]
        """
        under, resisting = self.undamped[1], 1j * self.grid.omega[:, None, None] * np.atleast_2d(damper)
        beside = np.eye(len(self.rows)) - (self.rows @ under + self.buoy.chamber) @ resisting
        moved = np.linalg.solve(beside, (undamped @ self.rows.T)[..., None])
        return np.asarray(undamped + (under @ (resisting @ moved))[..., 0])

    def slopes(
        self,
        left: ComplexArray,
        motion: ComplexArray,
        damper: float | FloatArray = 0.0,
        by: FloatArray | None = None,
    ) -> ComplexArray:
        """Return l^T (dX - dD q) for each variable, shape (variable, omega); parameters are those of `reaction`."""
        forced = (self.grid.interpolation @ self.change.excitation * left).sum(axis=-1)
        return np.asarray(forced - self.reaction(left, motion, damper, by))

    def reaction(
        self,
        left: ComplexArray,
        motion: ComplexArray,
        damper: float | FloatArray = 0.0,
        by: FloatArray | None = None,
    ) -> ComplexArray:
        """Return l^T dD q for each variable, shape (variable, omega), D with a damper at the port.

        Parameters
        ----------
        left, motion : ndarray, shape (omega, free)
            l and q.
        damper : float or ndarray, shape (port, port) [N s/m]
        by : ndarray, shape (variable,) or (variable, port, port)
            Derivatives of the damper; none: 0.
        """
        w, between, change = self.grid.omega, self.grid.interpolation, self.change
        count, free = len(change.port), self.rows.shape[1]
        pairs = (left[:, :, None] * motion[:, None, :]).reshape(-1, free**2).T
        mass, damping, stiffness = (
            values.reshape(count, free**2) @ pairs for values in (change.mass, change.damping, change.stiffness)
        )
        added, damped = (
            ((part.reshape(-1, free**2) @ pairs).reshape(count, len(self.grid.solved), len(w)) * between.T).sum(axis=1)
            for part in (change.radiation.real, change.radiation.imag)
        )
        radiated = added + 1j * self.grid.known / w * damped
        dynamic = -(w**2) * (mass + radiated) - 1j * w * damping + stiffness
        at_left, at_port = left @ self.rows.T, motion @ self.rows.T
        taken = np.zeros_like(dynamic)
        for moved, other in ((left, at_port), (motion, at_left)):
            loaded = self.spring * other - 1j * w[:, None] * (other @ np.atleast_2d(damper))
            taken = taken + (self.row_changes @ moved.T * loaded.T).sum(axis=1)
        if by is not None:
            changed = by.reshape(count, len(self.rows), len(self.rows))
            taken = taken - 1j * w * ((changed @ at_port.T) * at_left.T).sum(axis=1)
        return np.asarray(dynamic + taken)


@dataclass(frozen=True)
class PortYear:
    """The port of a buoy over the year beside its spring, without its damper; derivatives by each variable."""

    of: YearMotion

    @property
    def grid(self) -> FrequencyGrid:
        """Its frequencies."""
        return self.of.grid

    @cached_property
    def motion(self) -> ComplexArray:
        """u_0, shape (omega,) [m/m]."""
        return self.of.undamped[0] @ self.of.buoy.port

    @cached_property
    def receptance(self) -> ComplexArray:
        """y, shape (omega,) [m/N]."""
        return np.asarray(self._under @ self.of.buoy.port + self.of.buoy.chamber)

    @cached_property
    def motion_change(self) -> ComplexArray:
        """Derivatives of u_0, shape (variable, omega)."""
        q = self.of.undamped[0]
        return np.asarray(self.of.slopes(self._under, q) + self.of.change.port @ q.T)

    @cached_property
    def receptance_change(self) -> ComplexArray:
        """Derivatives of y, shape (variable, omega)."""
        change, under = self.of.change, self._under
        return np.asarray(2 * change.port @ under.T - self.of.reaction(under, under) + change.chamber[:, None])

    @property
    def _under(self) -> ComplexArray:
        """l, shape (omega, free)."""
        return self.of.undamped[1][..., 0]

    @property
    def optimal_damping(self) -> float:
        """The damper that absorbs most over the year [N s/m]; raises `ConvergenceError` if the port is not passive."""
        waves = self.grid.variance > 0
        w, y = self.grid.omega[waves], self.receptance[waves]
        try:
            port = Port(w, -1j * w * y, -1j * w * self.motion[waves], 0.0)
        except DatabaseError:
            raise ConvergenceError("the water about it is not resolved: it would give energy to its take-off") from None
        found = float(best_damper_of_each([port], 2 * self.grid.variance[waves])[0])
        for _ in range(3):  # Newton's method in log c, from an error of 1e-8
            slope, bend, _ = self._optimality(found)
            found *= float(np.exp(-slope / (bend * found)))
        return found

    def _optimality(self, c: float) -> tuple[float, float, FloatArray]:
        """dP/dc, d2P/dc2 and the derivatives of dP/dc by the variables at fixed c, shape (variable,).

        P = sum c s/E, s = w^2 S |u_0|^2, E = |1 - i w c y|^2 = 1 + 2 w c Im y + (w c |y|)^2.
        """
        w, y, u = self.grid.omega, self.receptance, self.motion
        s = w**2 * self.grid.variance * np.abs(u) ** 2
        a, d = 2 * w * y.imag, (w * np.abs(y)) ** 2
        e, e_c = 1 + a * c + d * c**2, a + 2 * d * c
        top, top_c = 1 - d * c**2, -2 * d * c
        slope, bend = (s * top / e**2).sum(), (s * (top_c / e**2 - 2 * top * e_c / e**3)).sum()
        ds = 2 * w**2 * self.grid.variance * (u.conj() * self.motion_change).real
        da, dd = 2 * w * self.receptance_change.imag, 2 * w**2 * (y.conj() * self.receptance_change).real
        change = ds * top / e**2 - s * (dd * c**2 / e**2 + 2 * top * (da * c + dd * c**2) / e**3)
        return float(slope), float(bend), np.asarray(change.sum(axis=-1))

    def optimal_damping_change(self, c: float) -> FloatArray:
        """Return the derivatives of the optimal damper, -(d2P/dc dx)/(d2P/dc2), shape (variable,)."""
        _, bend, change = self._optimality(c)
        return -change / bend

    def absorbed(self, damper: float) -> FloatArray:
        """Return the mean power of a damper [N s/m] by frequency, c w^2 S |u|^2, shape (omega,) [W]."""
        w = self.grid.omega
        moved = self.motion / (1 - 1j * w * damper * self.receptance)
        return np.asarray(damper * w**2 * np.abs(moved) ** 2 * self.grid.variance)

    def damper_within(self, force: float) -> "Damper":
        """Return the damper that absorbs most with a force of a given rms at most [N].

        Its force^2 = int w^2 S |u_0/(1/c - i w y)|^2 dw grows with c, and its power is force^2/c.
        """
        best, w, still = self.optimal_damping, self.grid.omega, np.zeros(len(self.of.change.port))
        speed = w**2 * self.grid.variance * np.abs(self.motion) ** 2

        def square(c: float) -> float:
            return float(speed @ np.abs(1 / c - 1j * w * self.receptance) ** -2)

        if square(best) <= force**2:
            stroke, _ = self.mean_square(best, np.ones_like(w), still)
            return Damper(best, self.optimal_damping_change(best), square(best) / best, float(np.sqrt(stroke)), 0.0)
        least, most = (float(np.log(end)) for end in (force / np.sqrt(speed.sum()), best))
        c = float(np.exp(brentq(lambda x: float(np.log(square(np.exp(x)) / force**2)), least, most, xtol=1e-13)))
        along = 1 / c - 1j * w * self.receptance
        by_c = 2 / c**2 * float(speed @ (along.real / np.abs(along) ** 4))
        change = -(c**2) * self.mean_square(c, w**2, still)[1] / by_c
        stroke, _ = self.mean_square(c, np.ones_like(w), still)
        return Damper(c, change, force**2 / c, float(np.sqrt(stroke)), 2 - 2 * force**2 / (c * by_c))

    def mean_square(self, c: float, weight: FloatArray, c_change: FloatArray) -> tuple[float, FloatArray]:
        """Return sum weight S |u|^2 dw under a damper and its derivatives, weights fixed, by the variables.

        Parameters
        ----------
        c : float [N s/m]
        weight : ndarray, shape (omega,)
        c_change : ndarray, shape (variable,)
            Derivatives of the damper.
        """
        w, y = self.grid.omega, self.receptance
        below = 1 - 1j * w * c * y
        u = self.motion / below
        change = (self.motion_change + 1j * w * u * (c * self.receptance_change + c_change[:, None] * y)) / below
        square = weight * self.grid.variance
        return float(square @ np.abs(u) ** 2), np.asarray(2 * (u.conj() * change).real @ square)
