"""Time integration of a linear plant: exact propagation, and Cummins' convolution as its reference."""

import time as clock
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from vsb.errors import StabilityError
from vsb.kernel import DampingSpectrum
from vsb.plant import Damper, LinearSystem, Plant, Spring
from vsb.units import ComplexArray, FloatArray


@dataclass(frozen=True)
class Motion:
    """Motion of the free coordinates on equally spaced times."""

    time: FloatArray  # (time,) [s]
    position: FloatArray  # y (time, free) [m]
    velocity: FloatArray  # (time, free) [m/s]
    acceleration: FloatArray  # (time, free) [m/s^2]
    memory: FloatArray  # x (time, state), empty for the convolution
    seconds: float  # wall time [s]


def steady_state(system: LinearSystem) -> ComplexArray:
    """Return the phasors of the steady state, shape (component, state): (-i omega - A) z = b.

    Raises
    ------
    StabilityError
        If a wave component meets an undamped resonance: the response grows without bound.
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
    matrices = -1j * system.omega[:, None, None] * np.eye(len(system.matrix)) - system.matrix
    return np.asarray(np.linalg.solve(matrices, system.input[..., None])[..., 0])


def propagate(plant: Plant, time: FloatArray, start: tuple[FloatArray, FloatArray]) -> Motion:
    """Return the exact motion of a linear plant at equally spaced times.

    Parameters
    ----------
    plant : Plant
    time : ndarray, shape (time,) [s]
    start : tuple of ndarray, each shape (free,)
        Initial y [m] and y' [m/s]; the water is at rest.

    Notes
    -----
    z(t) = z_s(t) + exp(A t) (z(0) - z_s(0)) with the steady state z_s: no step-size error, stiff modes cost nothing.
    """
    begun = clock.perf_counter()
    system = plant.linear_system()
    n = plant.motions.shape[1]
    first = np.zeros(len(system.matrix))
    first[:n], first[n : 2 * n] = np.linalg.solve(system.position, start[0]), np.linalg.solve(system.velocity, start[1])
    phasors = steady_state(system)
    rotation = np.exp(-1j * np.outer(time, system.omega))
    states = np.real(rotation @ phasors)
    rates = np.real(rotation @ (-1j * system.omega[:, None] * phasors))
    transient = _powers(expm(system.matrix * (time[1] - time[0])), first - states[0], len(time))
    states, rates = states + transient, rates + transient @ system.matrix.T
    position, velocity = states[:, :n] @ system.position.T, states[:, n : 2 * n] @ system.velocity.T
    acceleration = rates[:, n : 2 * n] @ system.velocity.T
    return Motion(time, position, velocity, acceleration, states[:, 2 * n :], clock.perf_counter() - begun)


def _powers(step: FloatArray, first: FloatArray, count: int) -> FloatArray:
    """Return step^i first for i < count, shape (count, state), by doubling."""
    out = first[None, :]
    while len(out) < count:
        out = np.concatenate([out, out @ step.T])
        step = step @ step
    return out[:count]


def convolve(plant: Plant, spectrum: DampingSpectrum, time: FloatArray, start: tuple[FloatArray, FloatArray]) -> Motion:
    """Return the motion with Cummins' convolution integral, by the average-acceleration method, second order.

    The reference for the state space: memory is int K(t - s) v(s) ds by the trapezoidal rule over the whole past, the
    kernel straight from the damping. The plant's own radiation memory is not used.
    """
    begun = clock.perf_counter()
    dt, n, count = time[1] - time[0], plant.motions.shape[1], len(time)
    kernel = plant.motions.T @ spectrum.kernel(time) @ plant.motions
    mass = plant.motions.T @ plant.mass @ plant.motions
    damping, stiffness = plant.total(Damper), plant.total(Spring)
    push = _excitation(plant, time)
    y, v, a = np.zeros((count, n)), np.zeros((count, n)), np.zeros((count, n))
    y[0], v[0] = start
    a[0] = np.linalg.solve(mass, push[0] - damping @ v[0] - stiffness @ y[0])
    system = np.linalg.inv(mass + dt / 2 * (damping + dt / 2 * kernel[0]) + dt**2 / 4 * stiffness)
    for i in range(1, count):
        guess_v = v[i - 1] + dt / 2 * a[i - 1]
        guess_y = y[i - 1] + dt * v[i - 1] + dt**2 / 4 * a[i - 1]
        past = np.einsum("tij,tj->i", kernel[i - 1 : 0 : -1], v[1:i]) + 0.5 * kernel[i] @ v[0]
        memory = dt * (past + 0.5 * kernel[0] @ guess_v)
        a[i] = system @ (push[i] - memory - damping @ guess_v - stiffness @ guess_y)
        v[i], y[i] = guess_v + dt / 2 * a[i], guess_y + dt**2 / 4 * a[i]
    return Motion(time, y, v, a, np.zeros((count, 0)), clock.perf_counter() - begun)


def _excitation(plant: Plant, time: FloatArray) -> FloatArray:
    """Wave excitation of the free coordinates, shape (time, free) [N]; zero in still water."""
    if plant.excitation is None:
        return np.zeros((len(time), plant.motions.shape[1]))
    phasors = plant.excitation.force @ plant.motions
    return np.real(np.exp(-1j * np.outer(time, plant.excitation.omega)) @ phasors)
