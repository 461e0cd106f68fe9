"""Exponential Adams method for a body-exact scene: the linear part exactly, the rest of the water by polynomials.

The scene is split into z' = A z + B n(t, z). A holds elasticity, damping, memory and the tangent of the water's force,
so stiff modes do not limit the step; n is smooth and small and depends on positions alone. The steps are those of
`vsb.adams`, of order 6: the recorded ones, or every 2^k-th or 2^-k-th of them. Recorded instants between them follow
from the same polynomial.
"""

import time as clock
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vsb.errors import ConvergenceError
from vsb.integrators.exponential_steps import (
    EVALUATIONS,
    HISTORY,
    KEPT,
    PROBE,
    SHORTEST,
    STEPS,
    TICK,
    Remainder,
    Step,
    march,
    remainder,
    step_matrices,
)
from vsb.integrators.phi import PhiIntegrals, doubled, is_small, phi_integrals
from vsb.motion.froude_krylov import incident
from vsb.motion.motion import Motion
from vsb.motion.scene import AssumedPressure, ConstantForce, Excitation, LinearSystem, Plant, Spring, WaterPressure
from vsb.tools.units import FloatArray
from vsb.waves.seas import NO_WAVES


class Run(NamedTuple):
    """Recorded states of a run, and what it took."""

    states: FloatArray  # (time, state)
    pushes: FloatArray  # n (time, free)
    steps: int  # tried
    evaluations: int  # of n


@dataclass(frozen=True)
class ExponentialIntegrator:
    """A body-exact scene split into its linear part and the remainder."""

    plant: Plant
    water: WaterPressure
    dt: float  # between recorded instants [s]
    begin: float = 0.0  # the first of them [s]

    @cached_property
    def system(self) -> LinearSystem:
        """Linear part, the tangent of the water's force among its springs."""
        linear = {name: f for name, f in self.plant.forces.items() if not isinstance(f, Excitation)}
        forces = {**linear, "tangent": Spring(self.water.tangent)}
        return replace(self.plant, forces=forces).linear_system()

    @cached_property
    def input(self) -> FloatArray:
        """B: forces act on the velocity rows, shape (state, free)."""
        n = self.plant.motions.shape[1]
        b = np.zeros((len(self.system.matrix), n))
        b[n : 2 * n] = np.eye(n)
        return b

    @cached_property
    def remainder(self) -> Remainder:
        """Arguments of the compiled remainder."""
        motions, water, dof = self.plant.motions, self.water, len(self.plant.labels)
        constants = [force.force for force in self.plant.forces.values() if isinstance(force, ConstantForce)]
        assumed = water.assumed or AssumedPressure(0.0, 0.0)
        waves = water.waves or incident(NO_WAVES, np.inf, 1.0, water.shell.shape.radius)
        linear = self.plant.excitation or Excitation(np.zeros(0), np.zeros((0, dof), dtype=complex))
        diffraction = linear.force[np.argsort(linear.omega, kind="stable")]  # the longest first, as in `waves`
        position, project = motions @ self.system.position, (motions @ self.system.velocity).T
        return Remainder(
            water.shell.shape,
            water.rest,
            np.ascontiguousarray(position),
            np.ascontiguousarray(project),
            project @ sum(constants, np.zeros(dof)),
            project @ water.tangent @ position,
            water.specific_weight,
            assumed.amplitude,
            assumed.omega,
            waves,
            np.ascontiguousarray(diffraction @ motions @ self.system.velocity, dtype=complex),
            1e-14 * float(np.linalg.norm(project)) * water.specific_weight * water.shell.shape.radius**3,
            self.begin,
        )

    @cached_property
    def least_scale(self) -> float:
        """Norm of a state too small to matter: a millionth of the root of rho g r^4."""
        return 1e-6 * float(np.sqrt(self.water.specific_weight) * self.water.shell.shape.radius**2)

    def horizon(self, duration: float) -> float:
        """Time over which errors add up [s]: the motion, or less where its slowest mode forgets sooner."""
        slowest = -float(np.linalg.eigvals(self.system.matrix).real.max())
        return min(duration, 1.0 / slowest) if slowest > 0 else duration

    @cached_property
    def _integrals(self) -> dict[tuple[float, int], PhiIntegrals]:
        """Integrals found so far, by unit and level."""
        return {}

    def integrals(self, unit: float, level: int) -> PhiIntegrals:
        """Integrals over unit 2^level, twice those of half the span."""
        key, a = (unit, level), self.system.matrix
        if key not in self._integrals:
            h = unit * 2.0**level
            new = (
                phi_integrals(a, self.input, h, KEPT + 1)
                if is_small(a, h)
                else doubled(self.integrals(unit, level - 1))
            )
            self._integrals[key] = new
        return self._integrals[key]

    def step(self, level: int) -> Step:
        """Matrices of a step of dt 2^level."""
        part = self.integrals(PROBE * self.dt, level)
        return step_matrices(self.integrals(self.dt, level), part, self.integrals(self.dt, 0), self.input.shape[1])

    def run(self, first: FloatArray, count: int, tolerance: float) -> Run:
        """Return the states at `count` recorded instants.

        Raises
        ------
        ConvergenceError
            If steps have to be shorter than dt 2^-20.
        """
        free = self.input.shape[1]
        run = Run(np.zeros((count, len(first))), np.zeros((count, free)), 0, 0)
        z, past, places = first.copy(), np.zeros((HISTORY, free)), np.zeros((HISTORY, free))
        largest = max(float(np.linalg.norm(first)), self.least_scale)
        counters, levels = np.array([0, 0, 0, 0, HISTORY]), np.array([largest, 0.0, tolerance * largest])
        run.states[0], steps = first, {}
        remainder(self.remainder, 0.0, first[:free].copy(), run.pushes[0])
        level, change, horizon = -1, 1, self.horizon(self.dt * (count - 1))
        while change:
            if level < SHORTEST:
                shortest = self.dt * 2.0**SHORTEST
                reached = self.begin + counters[TICK] * shortest
                raise ConvergenceError(
                    f"the motion cannot be followed at t = {reached:.6g} s: the step became shorter "
                    f"than {shortest:.1e} s; check the study for loads that crush the shell, or raise "
                    "simulation.tolerance."
                )
            if level not in steps:
                steps[level] = self.step(level)
            change = march(
                self.remainder, steps[level], self.dt, level, tolerance, horizon, z, past, places, counters, levels,
                run.states, run.pushes,
            )  # fmt: skip
            level += change
        return run._replace(steps=int(counters[STEPS]), evaluations=int(counters[EVALUATIONS]) + 1)


def integrate(plant: Plant, time: FloatArray, start: tuple[FloatArray, ...], tolerance: float) -> tuple[Motion, int]:
    """Return the motion of a body-exact scene at equally spaced times, and the number of steps tried.

    Parameters
    ----------
    plant : Plant
        With a `WaterPressure` among its forces.
    time : ndarray, shape (time,) [s]
    start : tuple of ndarray
        y [m] and y' [m/s] at the first instant, each shape (free,); then memory states, if the water is not at rest.
    tolerance : float
        Of the error of the motion, relative to the largest norm of the state so far: the root of twice its energy.

    Raises
    ------
    ConvergenceError
        If the motion cannot be followed.
    """
    if plant.water is None:
        raise ValueError("an exponential integrator needs a scene with water pressure; use propagate for a linear one.")
    dt = float(time[1] - time[0])
    if not march.signatures:  # compile or load: no part of the motion's seconds
        warm = ExponentialIntegrator(plant, plant.water, dt)
        warm.run(np.zeros(len(warm.system.matrix)), 2, 1.0)
    begun = clock.perf_counter()
    method = ExponentialIntegrator(plant, plant.water, dt, float(time[0]))
    system, n = method.system, plant.motions.shape[1]
    run = method.run(system.first(start), len(time), tolerance)
    rates = run.states @ system.matrix.T
    rates[:, n : 2 * n] += run.pushes
    motion = Motion(
        time,
        run.states[:, :n] @ system.position.T,
        run.states[:, n : 2 * n] @ system.velocity.T,
        rates[:, n : 2 * n] @ system.velocity.T,
        run.states[:, 2 * n :],
        clock.perf_counter() - begun,
    )
    return motion, run.steps
