"""Exact motion of a linear system, and Cummins' convolution integral as the reference of its radiation memory."""

import time as clock

import numpy as np
from scipy.linalg import block_diag

from vsb.engine.hydro.radiation import DampingSpectrum
from vsb.engine.motion.system import Motion, System
from vsb.engine.waves.seas import superposed
from vsb.errors import StabilityError
from vsb.tools.arrays import ComplexArray, FloatArray

SERIES = 16  # terms of exp(X), |X| <= 1/2
GONE = 1e-30
"""A transient of so much of its start is over."""
SOLVED = 256  # components at a time
AT_ONCE = 8  # blocks of a transient: they stay in the cache


def steady_state(system: System) -> ComplexArray:
    """Return the phasors of the steady state, shape (component, state): (-i omega - A) z = B w.

    Raises `StabilityError` if a wave component meets an undamped resonance: the response grows without bound.
    """
    if system.omega.size:
        natural = np.linalg.eigvals(system.matrix)
        distance = np.abs(natural[:, None] + 1j * system.omega) / system.omega
        if distance.min() < 1e-9:
            omega = system.omega[int(np.argmin(distance.min(axis=0)))]
            raise StabilityError(
                f"the wave of {omega:.6g} rad/s meets an undamped resonance: no steady state exists; "
                "add device.damping or pto.damping, or change the wave period."
            )
    right = system.waves @ system.input.T
    out = np.empty_like(right)
    for start in range(0, len(out), SOLVED):
        here = slice(start, start + SOLVED)
        matrices = -1j * system.omega[here, None, None] * np.eye(len(system.matrix)) - system.matrix
        out[here] = np.linalg.solve(matrices, right[here, :, None])[..., 0]
    return out


def propagate(
    system: System, time: FloatArray, start: tuple[FloatArray, ...], steady: ComplexArray | None = None
) -> Motion:
    """Return the exact motion of a linear system at equally spaced times.

    Raises `ValueError` if the system is not linear.

    Parameters
    ----------
    time : ndarray, shape (time,) [s]
    start : tuple of ndarray
        y [m] and y' [m/s] at the first instant, each shape (free,); then memory states, if the water is not at rest.
    steady : ndarray, shape (component, state), optional
        `steady_state` of the system, where it is known from a run before.

    Notes
    -----
    z(t) = z_s(t) + exp(A t) (z(0) - z_s(0)) with the steady state z_s: no step-size error, stiff modes cost nothing.
    """
    if not system.linear:
        raise ValueError("exact propagation: received nonlinear forces, needs a linear scene; use `integrate`.")
    begun = clock.perf_counter()
    n, order, first = system.free, len(system.matrix), system.first(start)
    phasors = steady_state(system) if steady is None else steady
    read = block_diag(system.position, system.modes, np.eye(order - 2 * n))  # y, y', memory of z
    swinging = phasors @ read.T
    swinging = np.hstack([swinging, -1j * system.omega[:, None] * swinging[:, n : 2 * n]])
    out = superposed(system.omega, swinging, time)
    read = np.vstack([read, system.modes @ system.matrix[n : 2 * n]])
    turn = np.exp(-1j * system.omega * time[0])
    _add_transient(out, read, transition(system.matrix * (time[1] - time[0])), first - np.real(turn @ phasors))
    parts = np.split(out, [n, 2 * n, order], axis=1)
    return Motion(time, parts[0], parts[1], parts[3], parts[2], clock.perf_counter() - begun)


def _add_transient(out: FloatArray, read: FloatArray, step: FloatArray, state: FloatArray) -> None:
    """Add read step^i z to row i: blocks of rows share one table of read step^j. Stops when nothing is left of z."""
    length = int(np.ceil(np.sqrt(len(out))))
    table, power = read[None], step
    while len(table) < length:
        table, power = np.concatenate([table, table @ power]), power @ power
    flat, leap = table[:length].reshape(-1, len(step)), np.linalg.matrix_power(step, length)
    states, least = [state], GONE * np.abs(state).max()
    while len(states) * length < len(out) and np.abs(states[-1]).max() > least:
        states.append(leap @ states[-1])
    for start in range(0, len(states), AT_ONCE):
        rows = (np.array(states[start : start + AT_ONCE]) @ flat.T).reshape(-1, len(read))
        here = out[start * length : start * length + len(rows)]
        here += rows[: len(here)]


def series(x: FloatArray) -> tuple[list[FloatArray], int]:
    """Return the terms I, X h, (X h)^2/2, ... of exp(X h) and how often h = 2^-k is halved until |X h| <= 1/2."""
    halvings = max(0, int(np.ceil(np.log2(max(2 * np.abs(x).sum(axis=0).max(), 1.0)))))
    x = x / 2.0**halvings
    terms: list[FloatArray] = [np.eye(len(x))]
    for k in range(1, SERIES):
        terms.append(x @ terms[-1] / k)
    return terms, halvings


def transition(x: FloatArray) -> FloatArray:
    """Return exp(X), shape (state, state).

    Squares exp - I, not exp: 2 (E - I) + (E - I)^2. Beside a stiff mode, which sets the number of squarings, slow
    motion keeps its digits.
    """
    terms, halvings = series(x)
    change = np.sum(terms[:0:-1], axis=0)
    for _ in range(halvings):
        change = 2 * change + change @ change
    return np.asarray(np.eye(len(x)) + change)


def convolve(
    system: System, spectrum: DampingSpectrum, time: FloatArray, start: tuple[FloatArray, FloatArray]
) -> Motion:
    """Return the motion with Cummins' convolution integral, by the average-acceleration method, second order.

    The reference for the state space: memory is int K(t - s) v(s) ds by the trapezoidal rule over the whole past, the
    kernel straight from the damping; the system's own radiation memory is not used and the water rests at the start.
    Parameters as `propagate`. Raises `ValueError` if the system is not linear, or remembers more than radiation.
    """
    if not system.linear:
        raise ValueError("convolution: received nonlinear forces, needs a linear scene; use `integrate`.")
    if len(system.scene.memories) > 1:
        raise ValueError("convolution: received forces that remember besides radiation, needs none; use `propagate`.")
    begun = clock.perf_counter()
    dt, n, count = time[1] - time[0], system.free, len(time)
    kernel = system.shapes.T @ spectrum.kernel(time) @ system.shapes
    damping, stiffness = -system.matrix[n : 2 * n, n : 2 * n], -system.matrix[n : 2 * n, :n] * system.scale
    waves = system.wave_forcing(time)
    p, v, a = np.zeros((count, n)), np.zeros((count, n)), np.zeros((count, n))
    p[0], v[0] = np.linalg.solve(system.modes, np.array(start).T).T
    a[0] = waves[0] - damping @ v[0] - stiffness @ p[0]
    inverse = np.linalg.inv(np.eye(n) + dt / 2 * (damping + dt / 2 * kernel[0]) + dt**2 / 4 * stiffness)
    for i in range(1, count):
        guess_v = v[i - 1] + dt / 2 * a[i - 1]
        guess_p = p[i - 1] + dt * v[i - 1] + dt**2 / 4 * a[i - 1]
        past = np.einsum("tij,tj->i", kernel[i - 1 : 0 : -1], v[1:i]) + 0.5 * kernel[i] @ v[0]
        memory = dt * (past + 0.5 * kernel[0] @ guess_v)
        a[i] = inverse @ (waves[i] - memory - damping @ guess_v - stiffness @ guess_p)
        v[i], p[i] = guess_v + dt / 2 * a[i], guess_p + dt**2 / 4 * a[i]
    y, rate, acceleration = (part @ system.modes.T for part in (p, v, a))
    return Motion(time, y, rate, acceleration, np.zeros((count, 0)), clock.perf_counter() - begun)
