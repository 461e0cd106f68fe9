"""A scene in a regular wave, in its natural modes and at the harmonics of the wave: impedance and what the water adds.

With the natural modes u of the scene, y = S u, and u(t) = Re sum U_h exp(-i h omega t) (C1) the equation of motion is

    Z(h omega) U_h = G_h,    Z(w) = diag(s) - w^2 - i w (D + conj K(i w)),

s the squared natural frequencies, K the radiation at any frequency, G what the water does beyond its tangent.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vsb.errors import ConfigError
from vsb.integrators.floquet import harmonics_of, largest, synthesized
from vsb.motion.system import System
from vsb.tools.arrays import ComplexArray, FloatArray

Transfer = Callable[[FloatArray], ComplexArray]
"""Radiation K(i w) = B + i w (A - A(infinity)), shape (omega, dof, dof) [kg/s], at any w > 0."""


def regular_frequency(system: System) -> float:
    """Return the frequency of the waves or the assumed pressure of a scene, zero without either [rad/s].

    Raises
    ------
    ConfigError
        If there are several, or a load without a period.
    """
    found = system.frequencies.tolist()
    if len(found) > 1 or 0.0 in found:
        raise ConfigError(
            f"waves: received {len(found)} frequencies from {min(found):.4g} to {max(found):.4g} rad/s, needs one "
            "above zero: only a regular wave has a steady state; use kind: regular, or follow the motion in time."
        )
    return float(found.pop()) if found else 0.0


@dataclass(frozen=True)
class PeriodicScene:
    """A scene in a regular wave, in its natural modes."""

    system: System
    omega: float
    transfer: Transfer | None  # none: nothing radiates

    def radiation(self, omega: FloatArray) -> ComplexArray:
        """Return conj K between the modes: radiation force -conj K U' (C1), shape (omega, free, free)."""
        return self._between_modes(self.transfer, omega)

    def relaxation(self, omega: FloatArray) -> ComplexArray:
        """Return the same of a take-off that remembers, one behind a chamber."""
        memory = self.system.scene.memories.get(self.system.scene.take_off)
        return self._between_modes(memory.transfer if memory else None, omega)

    def _between_modes(self, transfer: Transfer | None, omega: FloatArray) -> ComplexArray:
        """Conjugate of a transfer function between the modes."""
        shapes = self.system.shapes
        if transfer is None:
            return np.zeros((len(omega), self.system.free, self.system.free), dtype=complex)
        return np.asarray(shapes.T @ transfer(omega).conj() @ shapes)

    def impedance(self, count: int) -> ComplexArray:
        """Return Z of the harmonics below `count`, shape (count, free, free) [1/s^2]."""
        free = self.system.free
        squares = -np.diag(self.system.matrix[free : 2 * free, :free]) * self.system.scale
        omega = self.omega * np.arange(1, count)
        damping = -self.system.matrix[free : 2 * free, free : 2 * free] + self.radiation(omega) + self.relaxation(omega)
        moving = np.diag(squares) - omega[:, None, None] ** 2 * np.eye(free) - 1j * omega[:, None, None] * damping
        return np.concatenate([np.diag(squares)[None].astype(complex), moving])

    @property
    def push(self) -> ComplexArray:
        """Phasor of the linear waves on the modes, shape (free,)."""
        return self.system.waves[0] if len(self.system.waves) else np.zeros(self.system.free, dtype=complex)

    @property
    def size(self) -> float:
        """Length no amplitude is measured against if smaller [m]."""
        return self.system.size

    @property
    def reach(self) -> float:
        """Displacement beyond which an orbit is given up [m]."""
        return 1e7 * self.size or np.inf

    def states(self, harmonics: ComplexArray, phase: FloatArray) -> FloatArray:
        """Return z of the modes and their rates along an orbit, shape (phase, 2 free)."""
        rates = -1j * self.omega * np.arange(len(harmonics))[:, None] * harmonics
        return synthesized(np.hstack([self.system.scale * harmonics, rates]), phase)

    def remainder(self, phase: FloatArray, z: FloatArray) -> FloatArray:
        """Return what nonlinear forces do to the modes beyond their tangents, shape (phase, free)."""
        return self.system.added(phase / self.omega, z)

    def tangents(self, phase: FloatArray, z: FloatArray) -> FloatArray:
        """Return E = d remainder/d(u, u') along an orbit by central differences, shape (phase, free, free or 2 free).

        Rates count only where a force beyond the water's depends on them.
        """
        count, free = len(z), self.system.free
        if self.system.linear:
            return np.zeros((count, free, free))
        step = self.size / np.abs(self.system.shapes).max(axis=0)
        steps, moves = step, step * self.system.scale
        if self.system.foreign:
            steps, moves = (np.append(x, self.omega * step) for x in (steps, moves))
        away = np.eye(len(moves), z.shape[1])[:, None] * moves[:, None, None]
        moved = np.concatenate([z + away, z - away]).reshape(-1, z.shape[1])
        force = self.remainder(np.tile(phase, 2 * len(moves)), moved).reshape(2, len(moves), count, free)
        return np.asarray(((force[0] - force[1]) / (2 * steps[:, None, None])).transpose(1, 2, 0))

    def coupling(self, harmonics: ComplexArray, phase: FloatArray) -> FloatArray:
        """Return E along an orbit as it acts in the linear system, shape (phase, free, free or 2 free) [1/s]."""
        out = self.tangents(phase, self.states(harmonics, phase))
        out[..., : self.system.free] /= self.system.scale
        return out

    def forced(self, harmonics: ComplexArray, phase: FloatArray) -> ComplexArray:
        """Return G of an orbit, sampled at phases a whole period long, shape (sample/2, free)."""
        force = harmonics_of(self.remainder(phase, self.states(harmonics, phase)))
        force *= np.exp(1j * phase[0] * np.arange(len(force)))[:, None]
        force[1] += self.push
        return force

    def amplitude(self, harmonics: ComplexArray) -> float:
        """Return the largest amplitude of any coordinate [m], no less than `size`."""
        return max(largest(harmonics[1:] @ self.system.modes.T), self.size) or 1.0
