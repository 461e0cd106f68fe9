"""The year of a buoy whose take-off acts on several motions at once: by a damper matrix, or spread over its shell.

With dampers C at the ports B and D_c = D - i w B C B^T the motion is q = D_c^-1 X, and the ports move by u = B^T q.
With the year's mean variance density S

    mean power P = int w^2 S u^H C u dw,
    dP = int w^2 S [u^H dC u + 2 Re u^H C dB^T q + 2 Re l^T (dX - dD_c q)] dw,   l = D_c^-1 B C u*.

At the matrix that absorbs most dC does not count: the matrices to choose from, C >= 0, are the same for all buoys. With
a limit of the rms of all forces together, int w^2 S u^H C^2 u dw, that matrix is the best of P less a price times their
mean square: where the limit holds the derivatives are those of this difference, at fixed C and price. The damper spread
over a shell, C = c 1, has a derivative of its own (`SeveralYear.optimal_change`).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vsb.design.year import YearMotion
from vsb.engine.motion.damper_matrix import Kind, Ports, best_matrix, priced_matrix
from vsb.tools.arrays import ComplexArray, FloatArray

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
