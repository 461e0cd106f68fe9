"""Exponential Adams method for a body-exact scene: the linear part exactly, the rest of the water by polynomials.

Of z' = A z + B (n + waves) A holds elasticity, damping, memory and the tangent of the water's force, so stiff modes do
not limit the step; n is smooth and small and depends on positions alone. The steps are those of
`vsb.integrators.exponential_steps`, of order 6: the recorded ones, or every 2^k-th or 2^-k-th of them. Recorded
instants between them follow from the same polynomial.
"""

import time as clock
from dataclasses import dataclass
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
    Step,
    march,
    step_matrices,
)
from vsb.integrators.phi import PhiIntegrals, doubled, is_small, phi_integrals
from vsb.motion.motion import Motion
from vsb.motion.system import Remainder, System, remainder
from vsb.tools.arrays import FloatArray


class Run(NamedTuple):
    """Recorded states of a run, and what it took."""

    states: FloatArray  # (time, state)
    pushes: FloatArray  # n (time, free)
    steps: int  # tried
    evaluations: int  # of n


@dataclass(frozen=True)
class ExponentialIntegrator:
    """Steps of a body-exact system from one recorded instant to the next."""

    system: System
    dt: float  # between recorded instants [s]
    begin: float = 0.0  # the first of them [s]

    @cached_property
    def remainder(self) -> Remainder:
        """Arguments of the compiled n and waves; `ValueError` of a linear scene."""
        water, order = self.system.remainder, np.argsort(self.system.omega, kind="stable")
        if water is None:
            raise ValueError("exponential steps: needs a scene with water pressure; use propagate for a linear one.")
        if len(order) and not np.array_equal(self.system.omega[order], water.waves.omega):
            raise ValueError("exponential steps: received linear waves unlike those on the wet shell, needs one sea.")
        return water._replace(diffraction=np.ascontiguousarray(self.system.waves[order]), begin=self.begin)

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
                phi_integrals(a, self.system.input, h, KEPT + 1)
                if is_small(a, h)
                else doubled(self.integrals(unit, level - 1))
            )
            self._integrals[key] = new
        return self._integrals[key]

    def step(self, level: int) -> Step:
        """Matrices of a step of dt 2^level."""
        part = self.integrals(PROBE * self.dt, level)
        return step_matrices(self.integrals(self.dt, level), part, self.integrals(self.dt, 0), self.system.free)

    def run(self, first: FloatArray, count: int, tolerance: float) -> Run:
        """Return the states at `count` recorded instants.

        Raises
        ------
        ConvergenceError
            If steps have to be shorter than dt 2^-20.
        """
        free = self.system.free
        run = Run(np.zeros((count, len(first))), np.zeros((count, free)), 0, 0)
        z, past, places = first.copy(), np.zeros((HISTORY, free)), np.zeros((HISTORY, free))
        largest = max(float(np.linalg.norm(first)), self.system.least)
        counters, levels = np.array([0, 0, 0, 0, HISTORY]), np.array([largest, 0.0, tolerance * largest])
        run.states[0], steps = first, {}
        remainder(self.remainder, 0.0, first[:free].copy(), run.pushes[0])
        level, change, horizon = -1, 1, self.horizon(self.dt * (count - 1))
        while change:
            if level < SHORTEST:
                shortest = self.dt * 2.0**SHORTEST
                raise ConvergenceError(
                    f"the motion cannot be followed at t = {self.begin + counters[TICK] * shortest:.6g} s: the step "
                    f"became shorter than {shortest:.1e} s; check the study for loads that crush the shell, or raise "
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


def integrate(system: System, time: FloatArray, start: tuple[FloatArray, ...], tolerance: float) -> tuple[Motion, int]:
    """Return the motion of a body-exact scene at equally spaced times, and the number of steps tried.

    Parameters
    ----------
    system : System
        With water pressure.
    time, start
        See `vsb.integrators.exact.propagate`.
    tolerance : float
        Of the error of the motion, relative to the largest norm of the state so far: the root of twice its energy.

    Raises
    ------
    ConvergenceError
        If the motion cannot be followed.
    ValueError
        If the scene is linear.
    """
    system.check_compiled()
    method = ExponentialIntegrator(system, float(time[1] - time[0]), float(time[0]))
    if not march.signatures:  # compile or load: no part of the motion's seconds
        method.run(np.zeros(len(system.matrix)), 2, 1.0)
        method = ExponentialIntegrator(system, method.dt, method.begin)
    begun = clock.perf_counter()
    run = method.run(system.first(start), len(time), tolerance)
    return system.motion(time, run.states, run.pushes, clock.perf_counter() - begun), run.steps
