"""The equation of motion in the frequency domain: dynamic stiffness, motion without take-off, port, restraint."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh, null_space

from vsb.engine.hydro.database import Coefficients
from vsb.engine.motion.port import ROUND_OFF, Port, Ports
from vsb.tools.arrays import ComplexArray, FloatArray, in_parts

UNRESTRAINED = 1e-6
"""Share of a steady force without restoring force from which on the port is unrestrained [-]."""


@dataclass(frozen=True)
class LinearEquation:
    """The linear equation of motion at some frequencies, in waves of unit amplitude.

        [-w^2 (M + A) - i w (B + D) + K + K_v] q = X - b F    (C1)

    Every design of a floating system moves by it within its own motions N.
    """

    omega: FloatArray  # (omega,) [rad/s]
    water: Coefficients  # A, B, X at these frequencies
    mass: FloatArray  # M (dof, dof) [kg]
    damping: FloatArray  # D of everything but radiation ([omega,] dof, dof) [N s/m]
    stiffness: FloatArray  # K, that at rest ([omega,] dof, dof) [N/m]
    stiffening: FloatArray | float = 0.0  # K_v, what a viscous material adds in motion (omega, dof, dof) [N/m]
    chamber: float = 0.0  # compliance in series with a port, of the gas before a turbine [m^3/Pa]

    def blocks(self, motions: FloatArray) -> Iterator[tuple[slice, ComplexArray]]:
        """Yield places of neighbouring frequencies, and the dynamic stiffness there of a design, (omega, free, free).

        N^T [-w^2 (M + A) - i w (B + D) + K + K_v] N [N/m]; those of all frequencies at once would take gigabytes.
        """
        for part in in_parts(max(1, len(self.omega)), motions.size):
            w, (added_mass, radiated, _) = self.omega[part, None, None], self.water
            damping, stiffness, stiffening = (
                each[part] if isinstance(each, np.ndarray) and each.ndim == 3 else each
                for each in (self.damping, self.stiffness, self.stiffening)
            )
            elastic = stiffness + stiffening - w**2 * (self.mass + added_mass[part])
            lossy = -w * (radiated[part] + damping)
            yield part, motions.T @ elastic @ motions + 1j * (motions.T @ lossy @ motions)

    def response(self, load: ComplexArray, motions: FloatArray) -> ComplexArray:
        """Return the motion of a design under a load, both of shape (..., omega, dof) [N], [m].

        Parameters
        ----------
        load : ndarray, shape (..., omega, dof)
        motions : ndarray, shape (dof, free)
            N, the motions the design allows.
        """
        allowed = load @ motions
        solved = [
            np.linalg.solve(stiffness, allowed[..., part, :, None])[..., 0] for part, stiffness in self.blocks(motions)
        ]
        return np.asarray(np.concatenate(solved, axis=-2) @ motions.T)

    def free_motion(self, motions: FloatArray, direction: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Return displacements without take-off, per wave amplitude [m/m], and under its unit force [m/N].

        Parameters
        ----------
        motions : ndarray, shape (dof, free)
            The motions the design allows.
        direction : ndarray, shape (dof,) or (dof, port)
            b: the take-off moves with b.q; B of several ports.

        Returns
        -------
        free, forced : ndarray, shapes (omega, dof), and (omega, dof) or (omega, dof, port)
            A take-off's force F against the motion leaves free - F forced.
        """
        allowed = allowed_part(direction, motions)
        loads = np.empty((len(self.omega), len(allowed), 1 + allowed[0].size), dtype=complex)
        loads[..., 0], loads[..., 1:] = self.water.excitation @ motions, allowed.reshape(len(allowed), -1)
        parts = [np.linalg.solve(stiffness, loads[part]) for part, stiffness in self.blocks(motions)]
        solved = np.asarray(motions @ np.concatenate(parts), dtype=complex)
        free, forced = np.ascontiguousarray(solved[..., 0]), np.ascontiguousarray(solved[..., 1:])
        return free, forced.reshape(*free.shape, *direction.shape[1:])

    def port(self, motions: FloatArray, direction: FloatArray) -> Port:
        """Return the port of a design, see `port_of_motion`; parameters as `free_motion`."""
        return self.port_of_motion(*self.free_motion(motions, direction), motions, direction)

    def ports(self, motions: FloatArray, directions: FloatArray) -> Ports:
        """Return several ports of a design at once, see `ports_of_motion`; parameters as `free_motion`."""
        return self.ports_of_motion(*self.free_motion(motions, directions), motions, directions)

    def ports_of_motion(
        self, free: ComplexArray, forced: ComplexArray, motions: FloatArray, directions: FloatArray
    ) -> Ports:
        """Return V0 = -i w B^T q_free and Y = -i w B^T q_forced from the motions of `free_motion`.

        Re Y is what unit forces lose, w^2 q^H (B + D) q: of a port that is nearly all spring, Re Y/|Y| down to 1e-13,
        the real part of B^T q is round-off.
        """
        along, rate = motions @ allowed_part(directions, motions), -1j * self.omega[:, None]
        parts = np.stack([forced.real, forced.imag])
        loss = (parts.swapaxes(2, 3) @ (self.water.damping @ parts + self.damping @ parts)).sum(axis=0)
        reactive = (rate[..., None] * (along.T @ forced)).imag
        admittance = self.omega[:, None, None] ** 2 * loss + 1j * (reactive + reactive.swapaxes(1, 2)) / 2
        return Ports(self.omega, admittance, rate * (free @ along))

    def port_of_motion(
        self, free: ComplexArray, forced: ComplexArray, motions: FloatArray, direction: FloatArray
    ) -> Port:
        """Return one port from the motions of `free_motion`: the 1 x 1 case, with a chamber in series with it."""
        one = self.ports_of_motion(free, forced[..., None], motions, direction[:, None])
        yields = compliance(motions.T @ self.stiffness @ motions, allowed_part(direction, motions))
        return Port(self.omega, one.admittance[:, 0, 0], one.velocity[:, 0], yields).behind(self.chamber)


def compliance(stiffness: FloatArray, force: FloatArray) -> float:
    """Return the displacement of a port under a steady unit force along it, infinite if it is unrestrained [m/N].

    Parameters
    ----------
    stiffness : ndarray, shape (free, free) [N/m]
    force : ndarray, shape (free,)
    """
    size = np.sqrt(np.abs(np.diag(stiffness)))
    if size.all() and np.linalg.cond(stiffness / np.outer(size, size)) < 1 / ROUND_OFF:
        return float(force @ np.linalg.solve(stiffness, force))
    moved = np.linalg.lstsq(stiffness, force, rcond=ROUND_OFF)[0]
    unrestrained = np.abs(stiffness @ moved - force).max(initial=0.0) > UNRESTRAINED * np.abs(force).max(initial=0.0)
    return np.inf if unrestrained else float(force @ moved)


def allowed_part(direction: FloatArray, motions: FloatArray) -> FloatArray:
    """Return N^T b of a port in the motions of a design, (free,) or (free, port): zero where only round-off is left."""
    part = motions.T @ direction
    return np.where(np.abs(part) > ROUND_OFF * np.linalg.norm(direction, axis=0), part, 0.0)


SAME = 1e-9
"""Relative difference of frequencies that are the same but for round-off."""


def with_others(omega: FloatArray, others: Iterable[float]) -> FloatArray:
    """Return ascending frequencies with others but those that differ by round-off alone: splines would magnify it."""
    kept = omega
    for one in others:
        if np.all(np.abs(kept - one) > SAME * one):
            kept = np.append(kept, one)
    return np.sort(kept)


def frequency_grid(step: float, lowest: float, omega_max: float, extra: Iterable[float]) -> FloatArray:
    """Return the frequencies of a response: a grid of a fifth of the solved step, and the extra ones."""
    first, last = int(np.ceil(5 * lowest / step - 1e-9)), int(np.floor(5 * omega_max / step + 1e-9))
    grid = [round(step / 5 * i, 10) for i in range(first, last + 1)]
    return with_others(np.array([*extra]), grid)


SLIDING = ("Surge", "Sway", "Yaw")
"""Rigid motions restrained by a mooring alone."""
_ROUND_OFF = 1e-13
"""Share of the largest stiffness that is round-off, each coordinate in terms of its own [-]."""


def unrestrained_motions(stiffness: FloatArray, labels: Sequence[str], motions: FloatArray) -> FloatArray:
    """Return the motions without restoring force, orthonormal in those a design allows, shape (free, unrestrained).

    Parameters
    ----------
    stiffness : ndarray, shape (free, free) [N/m]
        Symmetric, of the whole system.
    labels : sequence of str
        Degrees of freedom.
    motions : ndarray, shape (dof, free)
        Those a design allows.

    Notes
    -----
    K v = 0, v of surge, sway and yaw: all of them without a mooring, the motion across a single mooring line.
    """
    sliding = motions[[label in SLIDING for label in labels]].T
    sliding = sliding[:, sliding.any(axis=0)]
    size = np.sqrt(np.abs(stiffness).max(axis=0, initial=0.0))
    size[size == 0.0] = 1.0
    own = np.abs(sliding).T @ size
    _, values, rows = np.linalg.svd(stiffness @ (sliding / own) / size[:, None])
    left = rows[np.count_nonzero(values > _ROUND_OFF) :].T / own[:, None]
    return np.linalg.qr(sliding @ (left / np.abs(left).max(axis=0, initial=0.0)))[0]


def softest(stiffness: FloatArray, loose: FloatArray) -> tuple[float, FloatArray]:
    """Return the least stiffness of the restrained motions, above 0 if stable, and its motion, shape (free,)."""
    held = null_space(loose.T) if loose.size else np.eye(len(stiffness))
    values, shapes = np.linalg.eigh(held.T @ stiffness @ held)
    return float(values[0]), held @ shapes[:, 0]


def normal_modes(stiffness: FloatArray, mass: FloatArray, loose: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return squared frequencies and normal modes V, V^T M V = 1; zero for unrestrained motions.

    Parameters
    ----------
    stiffness, mass : ndarray, shape (free, free) [N/m], [kg]
    loose : ndarray, shape (free, unrestrained)
        Of `unrestrained_motions`: round-off of their stiffness would give them a mean position.
    """
    squares, modes = eigh(stiffness, mass)
    if np.count_nonzero(squares == 0.0) >= loose.shape[1]:  # uncoupled ones are exact already
        return squares, modes
    held, unrestrained = null_space(loose.T @ mass), loose @ eigh(loose.T @ mass @ loose)[1]
    unrestrained = unrestrained / np.sqrt(np.einsum("ij,ij->j", unrestrained, mass @ unrestrained))
    squares, shapes = eigh(held.T @ stiffness @ held, held.T @ mass @ held)
    return np.append(np.zeros(unrestrained.shape[1]), squares), np.hstack([unrestrained, held @ shapes])
