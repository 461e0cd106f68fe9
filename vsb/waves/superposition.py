"""Sums of many harmonic components at equally spaced instants, as of a sea of thousands of them."""

import numpy as np

from vsb.tools.arrays import ComplexArray, FloatArray

FEW = 32
"""So many components are summed as they stand."""
_TABLE = 2**14  # cosines at a time: they stay in the cache
_AT_ONCE = 2**21  # complex numbers of a transform, of as many signals as that is
_SAME = 4e-15  # of the highest frequency: round-off


def superposed(omega: FloatArray, phasors: ComplexArray, time: FloatArray) -> FloatArray:
    """Return Re sum_j a_j exp(-i omega_j t) (C1) of several signals, shape (time, signal).

    Parameters
    ----------
    omega : ndarray, shape (component,) [rad/s]
    phasors : ndarray, shape (component, signal)
    time : ndarray, shape (time,) [s]
        Equally spaced.

    Notes
    -----
    Components of one spacing, such as those of a sea, are summed by fast Fourier transforms (Bluestein's chirp
    transform), blockwise in time so that the chirp's phase stays small. Others are summed as they stand.
    """
    if len(time) == 1:
        return np.asarray(np.real(np.exp(-1j * omega * time[0]) @ phasors)[None])
    out = np.empty((len(time), phasors.shape[1]))
    dt = float(time[-1] - time[0]) / max(len(time) - 1, 1)
    spacing = _spacing(omega)
    length = 3 * len(omega) if spacing else max(_TABLE // (1 + len(omega)), 1)
    for start in range(0, len(time), length):
        block, here = time[start : start + length], slice(start, start + length)
        if spacing:
            turned = np.exp(-1j * omega * block[0])[:, None] * phasors
            out[here] = _chirped(turned, float(omega[0]) * dt, spacing * dt, len(block))
        else:
            angle = np.outer(block, omega)
            out[here] = np.hstack([np.cos(angle), np.sin(angle)]) @ np.vstack([phasors.real, phasors.imag])
    return out


def _spacing(omega: FloatArray) -> float:
    """The one distance between many components [rad/s]; 0 if they are few, or not equally spaced."""
    if len(omega) <= FEW:
        return 0.0
    spacing = float(omega[-1] - omega[0]) / (len(omega) - 1)
    off = np.abs(omega - (omega[0] + spacing * np.arange(len(omega)))).max()
    return spacing if off <= _SAME * np.abs(omega).max() else 0.0


def _chirped(phasors: ComplexArray, first: float, ratio: float, count: int) -> FloatArray:
    """Re sum_j a_j exp(-i (first + j ratio) k), k < count: j k = (j^2 + k^2 - (k - j)^2)/2."""
    from scipy.fft import fft, ifft, next_fast_len  # what sums no sea does not wait for it

    j, k = np.arange(len(phasors)), np.arange(count)
    size = next_fast_len(len(j) + len(k) - 1)
    chirp = np.zeros(size, dtype=complex)
    chirp[: len(k)] = np.exp(0.5j * ratio * k**2)
    chirp[size - len(j) + 1 :] = np.exp(0.5j * ratio * j[:0:-1] ** 2)
    chirp, turn = fft(chirp), np.exp(-1j * (first * k + 0.5 * ratio * k**2))
    phasors = np.exp(-0.5j * ratio * j**2)[:, None] * phasors
    out, few = np.empty((count, phasors.shape[1])), max(_AT_ONCE // size, 1)
    for start in range(0, phasors.shape[1], few):
        here = slice(start, start + few)
        out[:, here] = (ifft(fft(phasors[:, here].T, size) * chirp, overwrite_x=True)[:, :count] * turn).real.T
    return out
