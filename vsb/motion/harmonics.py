"""Signals of equally spaced frequencies: their values at instants, and what a quadratic programme needs of them."""

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Self

import numpy as np
from scipy.fft import fft, ifft, next_fast_len

from vsb.errors import ConfigError
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

POINTS_PER_WAVE = 4
"""Instants of collocation in the shortest period."""
FEWEST_POINTS = 64
BEYOND = 4
"""Highest frequency at which a piecewise-linear force is evaluated, over the highest of the band."""
SPACING = 1e-6
"""Part of the spacing by which a frequency may miss its order."""


@dataclass(frozen=True)
class Harmonics:
    """Equally spaced frequencies (first + k) spacing and the instants of collocation in 2 pi/spacing.

    Raises
    ------
    ValueError
        If twice the first order is no whole number above 0: a signal and its limits would not repeat.
    """

    spacing: float  # [rad/s]
    first: float  # order of the lowest, a multiple of 1/2 [-]
    count: int

    def __post_init__(self) -> None:
        """Check that signals repeat, if only with the other sign."""
        if self.first <= 0 or 2 * self.first % 1 or self.spacing <= 0 or self.count < 1:
            raise ValueError(
                f"harmonics: received first order {self.first:g}, spacing {self.spacing:g} rad/s and {self.count} of "
                "them; needs a first order of 1/2, 1, 3/2, ..., a spacing above 0 and at least one"
            )

    @classmethod
    def of_sea(cls, omega: FloatArray, lowest: float, highest: float) -> Self:
        """Return the harmonics of a sea's components in a band: of a regular wave its own, of others their grid.

        Parameters
        ----------
        omega : ndarray, shape (component,) [rad/s]
            Ascending.
        lowest, highest : float [rad/s]
            The band, the sea within it.

        Raises
        ------
        ConfigError
            If the components are no multiples of half their spacing: the sea does not repeat.
        """
        spacing = float(np.diff(omega).min()) if len(omega) > 1 else float(omega[0])
        orders = omega / spacing
        halves = np.rint(2 * orders)
        if np.abs(2 * orders - halves).max() > SPACING or np.ptp(halves % 2) > 0:
            raise ConfigError(
                f"waves: received components {spacing:.4g} rad/s apart from {omega[0]:.4g} rad/s on, which never "
                "repeat; an optimum under limits needs multiples of half that: change the band or simulation.duration"
            )
        part = float(halves[0] / 2 % 1)
        first = part + max(np.ceil(lowest / spacing - part - SPACING), 0.0 if part else 1.0)
        return cls(spacing, float(first), int(np.floor(highest / spacing - first + SPACING)) + 1)

    @property
    def omega(self) -> FloatArray:
        """Angular frequencies, shape (harmonic,) [rad/s]."""
        return (self.first + np.arange(self.count)) * self.spacing

    @cached_property
    def instants(self) -> int:
        """Number of instants of collocation."""
        return int(next_fast_len(max(FEWEST_POINTS, int(np.ceil(POINTS_PER_WAVE * (self.first + self.count))))))

    @cached_property
    def _orders_outside(self) -> IntArray:
        """Integer parts of the orders below the band, without the mean, and above it up to `BEYOND` times its end."""
        low, top = int(self.first), int(self.first) + self.count
        return np.concatenate([np.arange(0 if self.first % 1 else 1, low), np.arange(top, BEYOND * top)])

    @cached_property
    def outside(self) -> FloatArray:
        """Frequencies outside the band at which a piecewise-linear force is evaluated, shape (outside,) [rad/s]."""
        return (self._orders_outside + self.first % 1) * self.spacing

    @property
    def port_omega(self) -> FloatArray:
        """Frequencies at which a port must be given: those of the band, then those outside [rad/s]."""
        return np.concatenate([self.omega, self.outside])

    def signal(self, phasors: ComplexArray, finer: int = 1) -> FloatArray:
        """Return Re sum c_k exp(-i omega_k t) on the instants or some times as many, shape (instant,)."""
        count = finer * self.instants
        padded = np.zeros(count, dtype=complex)
        whole = int(self.first)
        padded[whole : whole + self.count] = phasors
        values = fft(padded)
        return np.asarray((values * _half_turns(count) if self.first % 1 else values).real)

    def phasors(self, weights: FloatArray) -> ComplexArray:
        """Return sum_j w_j exp(i omega_k t_j), shape (harmonic,): the adjoint of `signal`."""
        turned = ifft(weights * _half_turns(len(weights)).conj() if self.first % 1 else weights) * len(weights)
        whole = int(self.first)
        return np.asarray(turned[whole : whole + self.count])

    def phasors_outside(self, weights: FloatArray) -> ComplexArray:
        """Return `phasors` at the frequencies outside the band, shape (outside,)."""
        turned = ifft(weights * _half_turns(len(weights)).conj() if self.first % 1 else weights) * len(weights)
        return np.asarray(turned[self._orders_outside])

    def signal_with(self, phasors: ComplexArray, outside: ComplexArray, finer: int) -> FloatArray:
        """Return the signal of harmonics in and outside the band on a refined time grid, shape (instant,)."""
        padded = np.zeros(finer * self.instants, dtype=complex)
        padded[int(self.first) : int(self.first) + self.count] = phasors
        padded[self._orders_outside] = outside
        values = fft(padded)
        return np.asarray((values * _half_turns(len(padded)) if self.first % 1 else values).real)

    def products(self, weights: FloatArray) -> tuple[ComplexArray, ComplexArray]:
        """Return sums of w_j e_k conj(e_l) over k - l, of w_j e_k e_l over k + l, e_k = exp(i omega_k t_j).

        A Toeplitz and a Hankel matrix: shapes (harmonic,), the others being conjugates, and (2 harmonic - 1,).
        """
        hat = np.asarray(ifft(weights) * len(weights))
        n, start = self.count, int(2 * self.first)
        return hat[:n], hat[np.arange(start, start + 2 * n - 1) % len(hat)]


@cache
def _half_turns(count: int) -> ComplexArray:
    """exp(-i t spacing/2) on so many instants, what half whole orders need beside a Fourier transform."""
    return np.asarray(np.exp(-1j * np.pi * np.arange(count) / count))
