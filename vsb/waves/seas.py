"""Regular and irregular seas as sums of regular components."""

from dataclasses import dataclass

import numpy as np

from vsb.study.study import Irregular, IrregularSea, Jonswap, RegularWave, Wave, WhiteNoise
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.waves.superposition import superposed


def jonswap_spectrum(omega: FloatArray, hs: float, tp: float, gamma: float) -> FloatArray:
    """Return the JONSWAP spectral density, shape (omega,) [m^2 s/rad], scaled to 16 m0 = hs^2 exactly.

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
    hs, tp : float
        Significant wave height [m], peak period [s].
    gamma : float
        Peakedness; 1 gives Pierson-Moskowitz.
    """

    def shape(w: FloatArray) -> FloatArray:
        peak = 2 * np.pi / tp
        sigma = np.where(w <= peak, 0.07, 0.09)
        bump: FloatArray = gamma ** np.exp(-((w / peak - 1) ** 2) / (2 * sigma**2))
        return np.asarray(w**-5.0 * np.exp(-1.25 * (peak / w) ** 4) * bump)

    fine = np.linspace(0.02, 40.0, 40001) * 2 * np.pi / tp
    m0 = float(np.trapezoid(shape(fine), fine))
    density: FloatArray = hs**2 / 16 / m0 * shape(omega)
    return density


@dataclass(frozen=True)
class Sea:
    """A sum of regular components: elevation Re sum a_j exp(-i omega_j t) at the buoy's axis (C1)."""

    omega: FloatArray  # (component,) [rad/s]
    amplitude: ComplexArray  # (component,) [m], phase included

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


def spectrum(wave: Irregular, omega: FloatArray) -> FloatArray:
    """Return the spectral density of an irregular sea, shape (omega,) [m^2 s/rad], 16 m0 = hs^2."""
    if isinstance(wave, WhiteNoise):
        low, high = wave.band
        return np.where((omega >= low) & (omega <= high), wave.hs**2 / 16 / (high - low), 0.0)
    return jonswap_spectrum(omega, wave.hs, wave.tp, wave.gamma if isinstance(wave, Jonswap) else 1.0)


def share_above(wave: Irregular, omega: float) -> float:
    """Return the share of an irregular sea's energy above a frequency [rad/s]."""
    if isinstance(wave, WhiteNoise):
        low, high = wave.band
        return min(1.0, max(0.0, (high - omega) / (high - low)))
    beyond = np.linspace(omega, 20 * omega, 4001)
    return float(np.trapezoid(spectrum(wave, beyond), beyond)) * 16 / wave.hs**2


def share_below(wave: Irregular, omega: float) -> float:
    """Return the share of an irregular sea's energy below a frequency [rad/s]."""
    if isinstance(wave, WhiteNoise):
        low, high = wave.band
        return min(1.0, max(0.0, (omega - low) / (high - low)))
    below = np.linspace(0.0, omega, 4001)[1:]
    return float(np.trapezoid(spectrum(wave, below), below)) * 16 / wave.hs**2


def components(wave: Irregular, omega_max: float, duration: float) -> tuple[FloatArray, FloatArray]:
    """Return frequencies and amplitudes of components of a sea that does not repeat within a run, each (component,).

    Components lie at the centres of equal bands no wider than 2 pi/(1.1 duration), up to omega_max [rad/s]. Amplitudes
    [m] follow the spectrum exactly: a_j^2 = 2 int S dw over the band.
    """
    low, high = wave.band if isinstance(wave, WhiteNoise) else (0.0, omega_max)
    count = int(np.ceil((high - low) * 1.1 * duration / (2 * np.pi)))
    width = (high - low) / count
    omega = low + (np.arange(count) + 0.5) * width
    inside = int(np.ceil(width / (0.02 * wave.omega)))  # the spectrum may peak within a band of a short record
    fine = low + (np.arange(count * inside) + 0.5) * width / inside
    return omega, np.sqrt(2 * spectrum(wave, fine).reshape(count, inside).mean(axis=1) * width)


def irregular(wave: Irregular, omega_max: float, duration: float) -> Sea:
    """Return a realisation that does not repeat within the run: random phases, amplitudes of `components`.

    Random amplitudes are Rayleigh-distributed about those, |a_j|^2 exponential of that mean: real and imaginary parts
    are independent normal variables, and the elevation is exactly Gaussian.
    """
    omega, amplitude = components(wave, omega_max, duration)
    random = np.random.default_rng(wave.seed)
    phasor = np.exp(1j * random.uniform(0.0, 2 * np.pi, len(omega)))
    if wave.amplitudes == "random":
        phasor *= np.sqrt(random.exponential(size=len(omega)))
    kept = amplitude > 1e-12 * amplitude.max()
    return Sea(omega[kept], (amplitude * phasor)[kept])


def expected(wave: Wave) -> Wave:
    """Return a sea with the amplitudes of its spectrum, |a_j|^2 = E |a_j|^2: powers in it are those expected."""
    return wave.model_copy(update={"amplitudes": "fixed"}) if isinstance(wave, IrregularSea) else wave


def sea(wave: Wave, omega_max: float, duration: float) -> Sea:
    """Return the sea of a study's wave; still water has no components."""
    if isinstance(wave, RegularWave):
        return regular(wave)
    if isinstance(wave, IrregularSea):
        return irregular(wave, omega_max, duration)
    return NO_WAVES
