"""Heave of a rigid half-submerged sphere in time, by Cummins' equation and the multipoles' damping: a reference.

(M + A_inf) v' + int K(t - s) v(s) ds + C z + f = F(t), K(t) = 2/pi int B cos(omega t) domega, A_inf half the displaced
mass. Trapezoidal rule in time and in the memory; the nonlinear force f acts at the middle of a step and is solved for
exactly. Nothing of the package is imported.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from verification.multipoles import GRAVITY, Shell, radiation

Resolvent = Callable[[float, float, float], float]
"""(a, b, t) -> v that solves a v + f(v, t) = b."""


@lru_cache(maxsize=8)
def memory(shell: Shell, step: float, duration: float) -> np.ndarray:
    """K at multiples of the step, kg/s^2: cosine integral by Simpson's rule; damping falls as omega^-3 beyond the last."""
    last = np.sqrt(15.0 * GRAVITY / shell.radius)
    omega = np.linspace(0.0, last, 601)
    damping = np.zeros_like(omega)
    for i, w in enumerate(omega[1:], start=1):
        ka = w**2 / GRAVITY * shell.radius
        damping[i] = radiation(ka, 1, 60).damping[1, 1] * shell.water * w * shell.radius**3
    beyond = last * np.linspace(1, 20, 4001)[1:]
    omega, damping = np.append(omega, beyond), np.append(damping, damping[-1] * (last / beyond) ** 3)
    weight = np.gradient(omega)
    weight[[0, -1]] /= 2
    at = np.arange(round(duration / step) + 1) * step
    return np.array([2 / np.pi * np.sum(weight * damping * np.cos(omega * t)) for t in at])


def linear(damping: float) -> Resolvent:
    """A damper."""
    return lambda a, b, _: b / (a + damping)


def coulomb(limit: float) -> Resolvent:
    """Friction of constant size that holds while it can."""
    return lambda a, b, _: float(np.sign(b) * max(abs(b) - limit, 0.0) / a)


def saturated(damping: float, limit: float) -> Resolvent:
    """A damper whose force is limited."""

    def resolvent(a: float, b: float, _: float) -> float:
        v = b / (a + damping)
        return v if abs(damping * v) <= limit else float((b - np.sign(v) * limit) / a)

    return resolvent


def drag(damping: float, coefficient: float, flow: Callable[[float], float]) -> Resolvent:
    """A damper beside the drag coefficient |v - w| (v - w) past the flow w."""

    def resolvent(a: float, b: float, t: float) -> float:
        w, d = flow(t), a + damping
        q = b - d * w
        return w + float(np.sign(q) * (-d + np.sqrt(d**2 + 4 * coefficient * abs(q))) / (2 * coefficient))

    return resolvent


class Pausing:
    """A damper that holds the motion, or lets it go, for a pause after each reversal; `taken`: its power by step."""

    def __init__(self, damping: float, pause: float, hold: bool, step: float) -> None:
        self.damping, self.pause, self.hold, self.step = damping, pause, hold, step
        self.taken: list[float] = []
        self._velocity, self._sign, self._until = 0.0, 0.0, -1.0

    def __call__(self, a: float, b: float, t: float) -> float:
        """Velocity at the middle of the step; a held motion stops within it."""
        paused = t < self._until
        v = b / (a + (0.0 if paused and not self.hold else self.damping))
        ahead = 2 * v - self._velocity
        if not paused and self._sign * ahead < 0:
            self._until, paused = t + self.pause, True
        if not (paused and self.hold):
            self._sign = float(np.sign(ahead))
        if paused and self.hold:
            v, self._sign = self._velocity / 2, 0.0  # it is released into either direction
        self.taken.append(0.0 if paused else self.damping * v**2)
        self._velocity = 2 * v - self._velocity
        return v


def heave(
    shell: Shell,
    resolvent: Resolvent,
    duration: float,
    step: float,
    force: Callable[[float], float] = lambda t: 0.0,
    position: float = 0.0,
    velocity: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Follow the motion: time, position and velocity at the steps, and the velocity at their middles (one fewer)."""
    count = round(duration / step)
    kernel = memory(shell, step, duration)
    mass = shell.total_mass + shell.water * np.pi / 3 * shell.radius**3
    spring = shell.water * GRAVITY * np.pi * shell.radius**2
    time = np.arange(count + 1) * step
    z, v, middle = np.zeros(count + 1), np.zeros(count + 1), np.zeros(count)
    z[0], v[0] = position, velocity
    past = 0.0  # the memory's force now
    # m (v1 - v0)/step = mean of (F - past) - spring (z0 + step/2 vm) - f(vm), v1 = 2 vm - v0
    a = 2 * mass / step + spring * step / 2 + kernel[0] * step / 2
    for i in range(count):
        ahead = step * (kernel[i + 1 : 0 : -1] @ v[: i + 1]) - step / 2 * kernel[i + 1] * v[0]  # without its last point
        push = (force(time[i]) + force(time[i + 1])) / 2 - (past + ahead) / 2
        b = 2 * mass / step * v[i] + push - spring * z[i] + kernel[0] * step / 4 * v[i]
        middle[i] = resolvent(a, b, time[i] + step / 2)
        v[i + 1] = 2 * middle[i] - v[i]
        z[i + 1] = z[i] + step * middle[i]
        past = ahead + step / 2 * kernel[0] * v[i + 1]
    return time, z, v, middle


def excitation(shell: Shell, period: float) -> complex:
    """Heave force of a wave of unit amplitude, N/m, in phase with its crest at the axis."""
    ka = (2 * np.pi / period) ** 2 / GRAVITY * shell.radius
    return complex(2 * np.pi * shell.water * GRAVITY * shell.radius**2 * radiation(ka, 1).amplitude[1])
