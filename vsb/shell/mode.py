"""One shape of a shell as a value: of one Legendre degree on the sphere, of all of them on another meridian."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from vsb.shell.legendre import legendre
from vsb.shell.ritz import natural_modes
from vsb.shell.sphere import Shell
from vsb.tools.arrays import FloatArray


@dataclass(frozen=True)
class Mode:
    """One shape: v = radial P_n, u = meridional dP_n/dphi, scaled to max|displacement| = 1 (C5)."""

    label: str
    degree: int
    radial: float
    meridional: float
    others: tuple[tuple[int, float, float], ...] = ()  # degrees, radial and meridional, beside; on other meridians

    @property
    def parts(self) -> tuple[tuple[int, float, float], ...]:
        """Degree, radial and meridional amplitude of all it is made of."""
        return ((self.degree, self.radial, self.meridional), *self.others)


def scaled(label: str, degree: int, radial: float, meridional: float) -> Mode:
    """Return a shape of one degree scaled to max|displacement| = 1, radial at the top pole positive."""

    def displacement(phi: FloatArray) -> FloatArray:
        p, dp, _ = legendre(degree, np.atleast_1d(phi))
        return np.asarray(np.hypot(radial * p[degree], meridional * dp[degree]))

    largest = _largest(displacement, degree)
    scale = np.copysign(1.0, radial) / largest
    return Mode(label, degree, radial * scale, meridional * scale)


def _largest(displacement: Callable[[FloatArray], FloatArray], degree: int) -> float:
    """Largest displacement along the meridian, of a shape with the turns of a degree."""
    grid = np.linspace(0.0, np.pi, 20 * degree + 3)
    peak = grid[np.argmax(displacement(grid))]
    step = grid[1]
    refined = minimize_scalar(
        lambda phi: -float(displacement(phi)[0]), bounds=(peak - step, peak + step), options={"xatol": 1e-12}
    )
    return max(-float(refined.fun), float(displacement(np.array(peak))[0]))


def natural_shapes(shell: Shell, degree: int) -> tuple[Mode, ...]:
    """Return the natural modes of a shell of another meridian, by ascending frequency, from `Shell1` on."""
    shapes = natural_modes(shell, max(1, degree)).shapes.T
    return tuple(_natural_shape(f"Shell{i}", shape) for i, shape in enumerate(shapes, 1))


def _natural_shape(label: str, shape: FloatArray) -> Mode:
    """A mode of all degrees scaled to max|displacement| = 1, the largest radial amplitude at a pole positive."""
    highest = len(shape) // 2
    radial, meridional = shape[: highest + 1], np.concatenate([[0.0], shape[highest + 1 :]])

    def displacement(phi: FloatArray) -> FloatArray:
        p, dp, _ = legendre(highest, np.atleast_1d(phi))
        return np.asarray(np.hypot(radial @ p, meridional @ dp))

    largest = _largest(displacement, highest)
    at_poles = np.array([radial.sum(), radial @ (-1.0) ** np.arange(highest + 1)])
    scale = np.copysign(1.0, at_poles[0] if abs(at_poles[0]) > 1e-6 * largest else at_poles[1]) / largest
    parts = [(n, scale * float(v), scale * float(u)) for n, (v, u) in enumerate(zip(radial, meridional, strict=True))]
    leading = max(parts, key=lambda part: math.hypot(part[1], math.sqrt(part[0] * (part[0] + 1)) * part[2]))
    return Mode(label, *leading, tuple(part for part in parts if part is not leading))
