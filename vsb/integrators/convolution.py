"""Cummins' convolution integral: the reference of the radiation memory's state space."""

import time as clock

import numpy as np

from vsb.hydro.retardation import DampingSpectrum
from vsb.motion.motion import Motion
from vsb.motion.system import System
from vsb.tools.arrays import FloatArray


def convolve(
    system: System, spectrum: DampingSpectrum, time: FloatArray, start: tuple[FloatArray, FloatArray]
) -> Motion:
    """Return the motion with Cummins' convolution integral, by the average-acceleration method, second order.

    The reference for the state space: memory is int K(t - s) v(s) ds by the trapezoidal rule over the whole past, the
    kernel straight from the damping. The system's own radiation memory is not used.

    Parameters
    ----------
    system : System
        Linear.
    spectrum : DampingSpectrum
    time : ndarray, shape (time,) [s]
        Equally spaced.
    start : tuple of ndarray, each shape (free,)
        Initial y [m] and y' [m/s]; the water is at rest.

    Raises
    ------
    ValueError
        If the system is not linear, or remembers more than radiation.
    """
    if not system.linear:
        raise ValueError("convolution: received nonlinear forces, needs a linear scene; use `integrate`.")
    if len(system.scene.memories) > 1:
        raise ValueError("convolution: received forces that remember besides radiation, needs none; use `propagate`.")
    begun = clock.perf_counter()
    dt, n, count = time[1] - time[0], system.free, len(time)
    kernel = system.shapes.T @ spectrum.kernel(time) @ system.shapes
    damping, stiffness = -system.matrix[n : 2 * n, n : 2 * n], -system.matrix[n : 2 * n, :n] * system.scale
    push = system.push(time)
    p, v, a = np.zeros((count, n)), np.zeros((count, n)), np.zeros((count, n))
    p[0], v[0] = np.linalg.solve(system.modes, np.array(start).T).T
    a[0] = push[0] - damping @ v[0] - stiffness @ p[0]
    inverse = np.linalg.inv(np.eye(n) + dt / 2 * (damping + dt / 2 * kernel[0]) + dt**2 / 4 * stiffness)
    for i in range(1, count):
        guess_v = v[i - 1] + dt / 2 * a[i - 1]
        guess_p = p[i - 1] + dt * v[i - 1] + dt**2 / 4 * a[i - 1]
        past = np.einsum("tij,tj->i", kernel[i - 1 : 0 : -1], v[1:i]) + 0.5 * kernel[i] @ v[0]
        memory = dt * (past + 0.5 * kernel[0] @ guess_v)
        a[i] = inverse @ (push[i] - memory - damping @ guess_v - stiffness @ guess_p)
        v[i], p[i] = guess_v + dt / 2 * a[i], guess_p + dt**2 / 4 * a[i]
    y, rate, acceleration = (part @ system.modes.T for part in (p, v, a))
    return Motion(time, y, rate, acceleration, np.zeros((count, 0)), clock.perf_counter() - begun)
