"""Regular and irregular seas as sums of regular components."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vsb.engine.waves.kinds import (
    Irregular,
    RecordedSea,
    RegularWave,
    Spectral,
    SpectralSea,
    TabulatedSea,
    Wave,
    WhiteNoise,
)
from vsb.engine.waves.water import Water, group_velocity
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray

PARTS = 36
"""Parts of equal energy that the directions at a frequency of a table are drawn from in turn."""
FEW = 32
"""Up to this number components are summed directly."""
_TABLE = 2**14  # cosines at a time: they fit the cache
_AT_ONCE = 2**21  # complex numbers of a transform, for as many signals as fit
_SAME = 4e-15  # round-off, relative to the highest frequency


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
    transform), blockwise in time so that the chirp's phase stays small. Others are summed directly.
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
    """Spacing of many components [rad/s]; 0 if they are few or not equally spaced."""
    if len(omega) <= FEW:
        return 0.0
    spacing = float(omega[-1] - omega[0]) / (len(omega) - 1)
    off = np.abs(omega - (omega[0] + spacing * np.arange(len(omega)))).max()
    return spacing if off <= _SAME * np.abs(omega).max() else 0.0


def _chirped(phasors: ComplexArray, first: float, ratio: float, count: int) -> FloatArray:
    """Re sum_j a_j exp(-i (first + j ratio) k), k < count: j k = (j^2 + k^2 - (k - j)^2)/2."""
    from scipy.fft import fft, ifft, next_fast_len  # slow to import

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


@dataclass(frozen=True)
class Sea:
    """A sum of regular components: elevation Re sum a_j exp(-i omega_j t) at the buoy's axis (C1)."""

    omega: FloatArray  # (component,) [rad/s]
    amplitude: ComplexArray  # (component,) [m], phase included
    heading: FloatArray | None = None  # direction of each, where they differ (component,) [degrees]

    def part(self, kept: BoolArray) -> "Sea":
        """Return some of the components."""
        heading = None if self.heading is None else self.heading[kept]
        return Sea(self.omega[kept], self.amplitude[kept], heading)

    def elevation(self, time: FloatArray) -> FloatArray:
        """Return the undisturbed elevation at the buoy's axis at equally spaced times, shape (time,) [m]."""
        return superposed(self.omega, self.amplitude[:, None], time)[:, 0]

    def mean_of(self, power_per_squared_amplitude: FloatArray) -> float:
        """Return the mean over the components of a power [W/m^2] that is additive over frequencies [W]."""
        return float(np.sum(power_per_squared_amplitude * np.abs(self.amplitude) ** 2))


NO_WAVES = Sea(np.zeros(0), np.zeros(0, dtype=complex))
"""Still water."""


def regular(wave: RegularWave) -> Sea:
    """Return a regular wave, crest at the axis at t = 0."""
    return Sea(np.array([wave.omega]), np.array([complex(wave.amplitude)]))


def components(wave: Irregular, omega_max: float, duration: float) -> tuple[FloatArray, FloatArray]:
    """Return frequencies and amplitudes of components of a sea that does not repeat within a run, each (component,).

    Components lie at the centres of equal bands no wider than 2 pi/(1.1 duration), up to omega_max [rad/s]. Amplitudes
    [m] follow the spectrum exactly: a_j^2 = 2 int S dw over the band.
    """
    low, high = wave.band if isinstance(wave, WhiteNoise) else (0.0, omega_max)
    count = int(np.ceil((high - low) * 1.1 * duration / (2 * np.pi)))
    width = (high - low) / count
    omega = low + (np.arange(count) + 0.5) * width
    return omega, np.sqrt(2 * wave.variances(omega - width / 2, omega + width / 2))


def recorded(wave: RecordedSea, omega_max: float) -> Sea:
    """Return the harmonics of a record up to a frequency [rad/s]: with all of them its elevation is the record."""
    kept = wave.file.omega <= omega_max + 1e-9
    return Sea(wave.file.omega[kept], wave.file.phasors[kept])


def irregular(wave: Spectral, omega_max: float, duration: float) -> Sea:
    """Return a realisation that does not repeat within the run: random phases, amplitudes of `components`.

    Random amplitudes are Rayleigh-distributed about those, |a_j|^2 exponential of that mean: real and imaginary parts
    are independent normal variables, and the elevation is exactly Gaussian. Of a spread sea see `headings`.
    """
    omega, amplitude = components(wave, omega_max, duration)
    random = np.random.default_rng(wave.seed)
    phasor = np.exp(1j * random.uniform(0.0, 2 * np.pi, len(omega)))
    if wave.amplitudes == "random":
        phasor *= np.sqrt(random.exponential(size=len(omega)))
    return Sea(omega, amplitude * phasor, headings(wave, omega)).part(amplitude > 1e-12 * amplitude.max())


def headings(wave: SpectralSea, omega: FloatArray) -> FloatArray | None:
    """Return the direction of each component of a spread sea, shape (omega,) [degrees]; None of a long-crested one.

    Every component goes to one direction, so that the sea is the same all along a run. Parts of equal energy take
    turns, in an order drawn anew for every round: each carries the same part of the spectrum. Of a spreading a part is
    one direction, of a table over direction it is of the energy there at the component's frequency.
    """
    if not wave.spreads:
        return None
    parts = wave.spreading.directions if wave.spreading else PARTS
    random = np.random.default_rng([wave.seed, 1])
    rounds = -(-len(omega) // parts)
    order = np.concatenate([random.permutation(parts) for _ in range(rounds)])[: len(omega)]
    if isinstance(wave, TabulatedSea) and not wave.spreading:
        angles = wave.file.direction_at(omega, (order + random.uniform(size=len(omega))) / parts)
    else:
        assert wave.spreading is not None
        angles = np.array(wave.spreading.angles)[order]
    return np.asarray(np.round(wave.direction + angles, 6))


def expected(wave: Wave) -> Wave:
    """Return a sea with the amplitudes of its spectrum, |a_j|^2 = E |a_j|^2, so that powers are expected values."""
    return wave.model_copy(update={"amplitudes": "fixed"}) if isinstance(wave, SpectralSea) else wave


def sea(wave: Wave, omega_max: float, duration: float) -> Sea:
    """Return the sea of a study's wave; still water has no components."""
    if isinstance(wave, RegularWave):
        return regular(wave)
    if isinstance(wave, RecordedSea):
        return recorded(wave, omega_max)
    if isinstance(wave, SpectralSea):
        return irregular(wave, omega_max, duration)
    return NO_WAVES


class SeaEnergy(NamedTuple):
    """Height, energy period and energy flux of a sea."""

    height: float  # significant height of an irregular sea, crest to trough of regular waves [m]
    period: float  # energy period of an irregular sea, Te = 2 pi m_-1/m_0 [s]
    flux: float  # rho g int v_g S dw, per metre of crest [W/m]


def sea_energy(wave: RegularWave | Irregular, water: Water) -> SeaEnergy:
    """Return height, period and energy flux of a sea in water of a depth (IEC TS 62600-101).

    Examples
    --------
    In deep water the flux is rho g^2 Hs^2 Te/(64 pi):

    >>> import math
    >>> from vsb.engine.waves.kinds import Jonswap
    >>> sea = sea_energy(Jonswap(kind="jonswap", hs=2.0, tp=8.0), Water())
    >>> round(sea.period, 2), round(sea.flux / (1025 * 9.81**2 * 2.0**2 * sea.period / (64 * math.pi)), 6)
    (7.23, 1.0)
    """
    if isinstance(wave, RegularWave):
        omega, variance = np.array([wave.omega]), np.array([wave.amplitude**2 / 2])
        height = 2 * wave.amplitude
    else:
        (omega, variance), height = wave.bands(), wave.hs
    speed = np.array([group_velocity(w, water.depth, water.gravity) for w in omega])
    period = 2 * np.pi * float(variance @ (1 / omega) / variance.sum())
    return SeaEnergy(height, period, water.density * water.gravity * float(variance @ speed))
