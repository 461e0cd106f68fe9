"""A scene in a regular wave, in its natural modes and at the harmonics of the wave: impedance and what the water adds.

With the natural modes u of the scene, y = S u, and u(t) = Re sum U_h exp(-i h omega t) (C1) the equation of motion is

    Z(h omega) U_h = G_h,    Z(w) = diag(s) - w^2 - i w (D + conj K(i w)),

s the squared natural frequencies, K the radiation at any frequency, G what the water does beyond its tangent.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vsb.errors import ConfigError
from vsb.integrators.floquet import harmonics_of, largest, synthesized
from vsb.motion.froude_krylov import wave_forces
from vsb.motion.scene import ConstantForce, Excitation, LinearSystem, Plant, Spring, WaterPressure
from vsb.tools.units import ComplexArray, FloatArray

Transfer = Callable[[FloatArray], ComplexArray]
"""Radiation K(i w) = B + i w (A - A(infinity)), shape (omega, dof, dof) [kg/s], at any w > 0."""


def regular_frequency(plant: Plant) -> float:
    """Return the frequency of the waves or the assumed pressure of a scene, zero without either [rad/s].

    Raises
    ------
    ConfigError
        If there are several, or a load without a period.
    """
    force, water = plant.excitation, plant.water
    found = set(force.omega.tolist()) if force else set()
    if water and water.assumed and water.assumed.amplitude:
        found.add(water.assumed.omega)
    if water and water.waves:
        found |= set(water.waves.omega.tolist())
    if len(found) > 1 or 0.0 in found:
        raise ConfigError(
            f"waves: received {len(found)} frequencies from {min(found):.4g} to {max(found):.4g} rad/s, needs one "
            "above zero: only a regular wave has a steady state; use kind: regular, or follow the motion in time."
        )
    return float(found.pop()) if found else 0.0


def raised(plant: Plant, share: float) -> Plant:
    """Return the scene with a share of its waves or assumed pressure."""
    forces = {}
    for name, force in plant.forces.items():
        if isinstance(force, Excitation):
            force = replace(force, force=share * force.force)
        elif isinstance(force, WaterPressure) and force.waves:
            force = replace(force, waves=force.waves._replace(amplitude=share * force.waves.amplitude))
        elif isinstance(force, WaterPressure) and force.assumed:
            force = replace(force, assumed=replace(force.assumed, amplitude=share * force.assumed.amplitude))
        forces[name] = force
    return replace(plant, forces=forces)


@dataclass(frozen=True)
class PeriodicScene:
    """A scene in a regular wave, in its natural modes."""

    plant: Plant
    omega: float
    transfer: Transfer | None  # none: nothing radiates

    @cached_property
    def system(self) -> LinearSystem:
        """Linear part, the tangent of the water's force among its springs."""
        plant, water = self.plant, self.plant.water
        if water is None:
            return plant.linear_system()
        linear = {name: f for name, f in plant.forces.items() if not isinstance(f, Excitation)}
        return replace(plant, forces={**linear, "tangent": Spring(water.tangent)}).linear_system()

    @cached_property
    def shapes(self) -> FloatArray:
        """Natural modes in all degrees of freedom, q = shapes u, shape (dof, free)."""
        return np.ascontiguousarray(self.plant.motions @ self.system.velocity)

    @cached_property
    def scale(self) -> FloatArray:
        """Frequencies the positions of the linear system are scaled by, shape (free,) [rad/s]."""
        free = self.shapes.shape[1]
        return np.diag(self.system.matrix[:free, free : 2 * free])

    def radiation(self, omega: FloatArray) -> ComplexArray:
        """Return conj K between the modes: radiation force -conj K U' (C1), shape (omega, free, free)."""
        free = self.shapes.shape[1]
        if self.transfer is None:
            return np.zeros((len(omega), free, free), dtype=complex)
        return np.asarray(self.shapes.T @ self.transfer(omega).conj() @ self.shapes)

    def impedance(self, count: int) -> ComplexArray:
        """Return Z of the harmonics below `count`, shape (count, free, free) [1/s^2]."""
        free = self.shapes.shape[1]
        squares = -np.diag(self.system.matrix[free : 2 * free, :free]) * self.scale
        omega = self.omega * np.arange(1, count)
        damping = -self.system.matrix[free : 2 * free, free : 2 * free] + self.radiation(omega)
        moving = np.diag(squares) - omega[:, None, None] ** 2 * np.eye(free) - 1j * omega[:, None, None] * damping
        return np.concatenate([np.diag(squares)[None].astype(complex), moving])

    @cached_property
    def push(self) -> ComplexArray:
        """Phasor of the linear excitation of the modes, shape (free,)."""
        force = self.plant.excitation
        return force.force[0] @ self.shapes if force else np.zeros(self.shapes.shape[1], dtype=complex)

    @cached_property
    def constant(self) -> FloatArray:
        """Constant forces, shape (dof,) [N]."""
        forces = [force.force for force in self.plant.forces.values() if isinstance(force, ConstantForce)]
        return sum(forces, np.zeros(len(self.plant.labels)))

    @cached_property
    def size(self) -> float:
        """Length no amplitude is measured against if smaller: a millionth of the radius [m]."""
        return 1e-6 * self.plant.water.shell.shape.radius if self.plant.water else 0.0

    @property
    def reach(self) -> float:
        """Displacement beyond which an orbit is given up [m]."""
        return 1e7 * self.size or np.inf

    def pressure(self, water: WaterPressure, phase: FloatArray, u: FloatArray) -> FloatArray:
        """Return the water's force, shape (phase, dof) [N]."""
        q = water.rest + u @ self.shapes.T
        if water.waves:
            return water.specific_weight * wave_forces(water.shell.shape, q, water.waves, phase / self.omega)
        static, uniform, _ = water.shell.forces(q)
        amplitude = water.assumed.amplitude if water.assumed else 0.0
        return water.specific_weight * static + amplitude * np.cos(phase)[:, None] * uniform

    def remainder(self, phase: FloatArray, u: FloatArray) -> FloatArray:
        """Return what the water and constant forces do to the modes beyond the tangent, shape (phase, free)."""
        water = self.plant.water
        if water is None:
            return np.broadcast_to(self.constant @ self.shapes, u.shape)
        force = self.pressure(water, phase, u) + self.constant + u @ (water.tangent @ self.shapes).T
        return np.asarray(force @ self.shapes)

    def tangents(self, phase: FloatArray, u: FloatArray) -> FloatArray:
        """Return E = d remainder/du along an orbit by central differences, shape (phase, free, free)."""
        count, free = u.shape
        if self.plant.water is None:
            return np.zeros((count, free, free))
        step = self.size / np.abs(self.shapes).max(axis=0)
        moved = np.concatenate([u[None] + np.diag(step)[:, None], u[None] - np.diag(step)[:, None]])
        force = self.remainder(np.tile(phase, 2 * free), moved.reshape(-1, free)).reshape(2, free, count, free)
        return np.asarray(((force[0] - force[1]) / (2 * step[:, None, None])).transpose(1, 2, 0))

    def coupling(self, harmonics: ComplexArray, phase: FloatArray) -> FloatArray:
        """Return E along an orbit as it acts in the linear system, shape (phase, free, free) [1/s]."""
        return self.tangents(phase, synthesized(harmonics, phase)) / self.scale

    def forced(self, harmonics: ComplexArray, phase: FloatArray) -> ComplexArray:
        """Return G of an orbit, sampled at phases a whole period long, shape (sample/2, free)."""
        force = harmonics_of(self.remainder(phase, synthesized(harmonics, phase)))
        force *= np.exp(1j * phase[0] * np.arange(len(force)))[:, None]
        force[1] += self.push
        return force

    def amplitude(self, harmonics: ComplexArray) -> float:
        """Return the largest amplitude of any coordinate [m], no less than `size`."""
        return max(largest(harmonics[1:] @ self.system.velocity.T), self.size) or 1.0
