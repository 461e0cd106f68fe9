"""Runge-Kutta methods compiled with the right-hand side: what a general integrator takes without calls from Python.

RK4 has a fixed step. DOP853 has the coefficients, the error estimate and the step control of SciPy's; it ends a step at
each instant at which the motion is compared, so that it needs no interpolation.
"""

from typing import Any

import numpy as np
from scipy.integrate._ivp import dop853_coefficients as dop853

from vsb.tools.arrays import FloatArray
from vsb.tools.compiled import njit

RK4, COMPILED_DOP853 = "RK4, compiled", "DOP853, compiled"
STAGES = dop853.N_STAGES
A, B, C = dop853.A[:STAGES, :STAGES].copy(), dop853.B.copy(), dop853.C[:STAGES].copy()
E3, E5 = dop853.E3.copy(), dop853.E5.copy()
SAFETY, LEAST, MOST, EXPONENT = 0.9, 0.2, 10.0, -1.0 / 8.0
"""Step control: factor and its range, and the power of the error."""


@njit(cache=False)
def rk4(rates: Any, first: FloatArray, time: FloatArray, steps: int, given: Any) -> FloatArray:
    """Return the states at given instants, shape (time, state), with so many steps between two of them."""
    out, z = np.empty((len(time), len(first))), first.copy()
    out[0] = z
    for i in range(len(time) - 1):
        h = (time[i + 1] - time[i]) / steps
        for k in range(steps):
            t = time[i] + k * h
            a = rates(t, z, *given)
            b = rates(t + h / 2, z + h / 2 * a, *given)
            c = rates(t + h / 2, z + h / 2 * b, *given)
            d = rates(t + h, z + h * c, *given)
            z = z + h / 6 * (a + 2 * b + 2 * c + d)
        out[i + 1] = z
    return out


@njit(cache=False)
def eighth_order(rates: Any, first: FloatArray, time: FloatArray, tolerance: float, given: Any) -> FloatArray:
    """Return the states at given instants, shape (time, state), by Dormand and Prince's method of order eight."""
    out, z, t = np.empty((len(time), len(first))), first.copy(), time[0]
    out[0] = z
    stages = np.empty((STAGES + 1, len(first)))
    stages[0] = rates(t, z, *given)
    step = 1e-3 * (time[1] - time[0])
    for i in range(1, len(time)):
        while t < time[i]:
            last = t + step >= time[i]
            h = time[i] - t if last else step
            for s in range(1, STAGES):
                moved = z.copy()
                for j in range(s):
                    moved += h * A[s, j] * stages[j]
                stages[s] = rates(t + C[s] * h, moved, *given)
            new = z.copy()
            for j in range(STAGES):
                new += h * B[j] * stages[j]
            stages[STAGES] = rates(t + h, new, *given)
            fifth, third = 0.0, 0.0
            for k in range(len(z)):
                scale = tolerance + tolerance * max(abs(z[k]), abs(new[k]))
                five, three = 0.0, 0.0
                for j in range(STAGES + 1):
                    five += stages[j, k] * E5[j]
                    three += stages[j, k] * E3[j]
                fifth += (five / scale) ** 2
                third += (three / scale) ** 2
            error = h * fifth / np.sqrt((fifth + 0.01 * third) * len(z)) if fifth > 0 else 0.0
            if not error < 1.0:
                step = h * max(LEAST, SAFETY * error**EXPONENT)
                continue
            grown = h * min(MOST, SAFETY * error**EXPONENT) if error > 0 else MOST * h
            step = max(step, grown) if last else grown
            t, z = (time[i] if last else t + h), new
            stages[0] = stages[STAGES]
        out[i] = z
    return out
