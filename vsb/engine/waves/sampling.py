"""Sums of many regular components at any instant, from samples: the cost of an instant does not grow with their number.

A signal s(t) = Re sum_j a_j exp(-i omega_j t) holds no frequency above omega_max. Samples at instants h apart of

    c(t) = Re sum_j a_j/F(omega_j h) exp(-i omega_j t),    F(xi) = int psi(x) exp(i xi x) dx,

give it back at any instant, s(t) = sum_n psi(t/h - n) c(n h), but for what F has at omega_j h + 2 pi m, m not 0, over
F(omega_j h). With the kernel psi(x) = exp(beta (sqrt(1 - (2x/w)^2) - 1)), |x| < w/2, of Barnett, Magland and af
Klinteberg, SIAM J. Sci. Comput. 41 (2019) C479, two samples per shortest half period and `WIDTH` of them per instant
this is round-off. The samples are sums by fast Fourier transforms (`superposed`).
"""

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from vsb.engine.waves.seas import FEW, superposed
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.tools.compiled import njit

WIDTH = 16
"""w, samples that one instant reads."""
OVERSAMPLED = 2.0
"""Samples per half period of the fastest component."""
BETA = 0.97 * np.pi * WIDTH * (1 - 0.5 / OVERSAMPLED)
"""Shape of the kernel that leaves the least aliases, by the authors' rule."""
INTERPOLATED = 1e-13
"""Bound of the error relative to the sum of |a_j|, beside that of the phases omega_j t; see `relative_error`."""
QUADRATURE = 200
"""Gauss-Legendre points of F: the kernel is smooth but for its ends, where it is exp(-beta)."""


def relative_error(omega_max: float, end: float) -> float:
    """Return the bound of the error of sampled signals up to an instant [s], relative to the sum of |a_j| [-].

    Phases are known to the round-off of omega t, with samples or without.
    """
    return INTERPOLATED + 2 * float(np.finfo(float).eps) * omega_max * end


class Signals(NamedTuple):
    """Signals that are sums of one set of components, and samples of them over a span of time, or none."""

    omega: FloatArray  # (component,) [rad/s]
    phasors: ComplexArray  # (component, signal)
    begin: float  # instant of the first sample [s]
    spacing: float  # h [s]
    samples: FloatArray  # c (instant, signal); none: components are summed


def signals(omega: FloatArray, phasors: ComplexArray) -> Signals:
    """Return signals without samples, from components (component,) and their phasors (component, signal)."""
    rows = np.ascontiguousarray(phasors, dtype=complex)
    return Signals(np.asarray(omega, dtype=float), rows, 0.0, 1.0, np.zeros((0, rows.shape[1])))


@cache
def _quadrature() -> tuple[FloatArray, FloatArray]:
    """Nodes and weights of Gauss and Legendre."""
    return np.polynomial.legendre.leggauss(QUADRATURE)


def kernel_transform(xi: FloatArray) -> FloatArray:
    """Return F of the kernel, shape of xi."""
    node, weight = _quadrature()
    kernel = np.exp(BETA * (np.sqrt(1 - node**2) - 1))
    return np.asarray(WIDTH / 2 * np.cos(np.multiply.outer(xi, WIDTH / 2 * node)) @ (weight * kernel))


def sampled(source: Signals, begin: float, end: float) -> Signals:
    """Return signals with samples for a span of time [s], or a longer one; few components are cheaper summed.

    The span has at least as many samples as there are components: the transforms of a run that is followed part by part
    then cost in proportion to its length.
    """
    if len(source.omega) <= FEW:
        return source
    spacing = np.pi / (OVERSAMPLED * float(source.omega.max()))
    count = WIDTH + max(int(np.ceil((end - begin) / spacing)), len(source.omega))
    first = begin - WIDTH / 2 * spacing
    phasors = source.phasors / kernel_transform(source.omega * spacing)[:, None]
    samples = superposed(source.omega, phasors, first + spacing * np.arange(count + 1))
    return source._replace(begin=first, spacing=spacing, samples=np.ascontiguousarray(samples))


@dataclass
class Sampler:
    """Signals with samples for the span of time last asked for, kept while they last."""

    held: Signals

    def during(self, begin: float, end: float) -> Signals:
        """Return the signals with samples for a span of time [s]."""
        source = self.held
        first = source.begin + WIDTH / 2 * source.spacing
        last = source.begin + (len(source.samples) - 1 - WIDTH / 2) * source.spacing
        if not (first <= begin + 1e-9 and end - 1e-9 <= last):
            self.held = sampled(source, begin, end)
        return self.held


@njit(cache=True)
def signals_at(source: Signals, time: float) -> FloatArray:
    """Return signals at an instant, shape (signal,): by samples or, beyond them, by their components."""
    count = source.phasors.shape[1]
    out = np.zeros(count)
    place = (time - source.begin) / source.spacing
    first = int(np.floor(place)) - WIDTH // 2 + 1
    if first >= 0 and first + WIDTH <= len(source.samples):
        for n in range(first, first + WIDTH):
            x = (place - n) * (2 / WIDTH)
            weight = np.exp(BETA * (np.sqrt(max(1 - x * x, 0.0)) - 1))
            for i in range(count):
                out[i] += weight * source.samples[n, i]
        return out
    for j in range(len(source.omega)):
        cosine, sine = np.cos(source.omega[j] * time), np.sin(source.omega[j] * time)
        for i in range(count):
            out[i] += cosine * source.phasors[j, i].real + sine * source.phasors[j, i].imag
    return out


@njit(cache=True)
def signals_along(source: Signals, time: FloatArray) -> FloatArray:
    """Return signals at any instants, shape (time, signal)."""
    out = np.empty((len(time), source.phasors.shape[1]))
    for i in range(len(time)):
        out[i] = signals_at(source, time[i])
    return out
