"""The kinds of seas: what a file may say of each, its words, and its spectral density; validated and frozen.

A new kind is a class here, with `kind`, `density` and `words`, a name in `Spectral`, and its keys in
`vsb.keys.meanings`. Realisations are in `vsb.engine.waves.seas`.
"""

import bisect
import copy
import math
from abc import abstractmethod
from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, ValidationInfo, field_validator, model_validator

from vsb.engine.waves.records import LEFT_OUT, Acceptable, Repairable, Samples, read_record
from vsb.engine.waves.spectrum_table import SpectrumTable, read_spectrum
from vsb.engine.waves.water import wavenumbers
from vsb.errors import ConfigError
from vsb.keys.quantities import Brief, Count, Number, Positive, Section, within
from vsb.keys.reading import Located
from vsb.tools.arrays import FloatArray


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
    return _scaled(lambda w: _jonswap_shape(w, tp, gamma), omega, hs, tp)


def tma_spectrum(omega: FloatArray, hs: float, tp: float, gamma: float, depth: float, gravity: float) -> FloatArray:
    """Return the TMA spectral density, shape of `omega` [m^2 s/rad]: JONSWAP's in water of a depth [m], 16 m0 = hs^2.

    S = S_J(w) tanh^2(kh)/(1 + 2kh/sinh 2kh): a saturated sea has in any depth the same spectrum over wavenumber
    (Kitaigorodskii et al. 1975; Bouws et al., J. Geophys. Res. 90, 1985). In deep water it is JONSWAP's.
    """
    return _scaled(lambda w: _jonswap_shape(w, tp, gamma) * depth_factor(w, depth, gravity), omega, hs, tp)


def depth_factor(omega: FloatArray, depth: float, gravity: float) -> FloatArray:
    """Return tanh^2(kh)/(1 + 2kh/sinh 2kh), shape of `omega` [-]: (w^2 h/g)/2 in shallow, 1 in deep water."""
    kh = np.minimum(depth * wavenumbers(omega, depth, gravity), 300.0)
    return np.asarray(np.tanh(kh) ** 2 / (1 + 2 * kh / np.sinh(2 * kh)))


def _jonswap_shape(omega: FloatArray, tp: float, gamma: float) -> FloatArray:
    """JONSWAP's spectrum but for its height."""
    peak = 2 * np.pi / tp
    sigma = np.where(omega <= peak, 0.07, 0.09)
    bump: FloatArray = gamma ** np.exp(-((omega / peak - 1) ** 2) / (2 * sigma**2))
    return np.asarray(omega**-5.0 * np.exp(-1.25 * (peak / omega) ** 4) * bump)


def _scaled(shape: Callable[[FloatArray], FloatArray], omega: FloatArray, hs: float, tp: float) -> FloatArray:
    """A shape with the variance of a sea."""
    fine = np.linspace(0.02, 40.0, 40001) * 2 * np.pi / tp
    m0 = float(np.trapezoid(shape(fine), fine))
    return np.asarray(hs**2 / 16 / m0 * shape(omega))


def ochi_hubble_peak(omega: FloatArray, hs: float, tp: float, peakedness: float) -> FloatArray:
    """Return the spectral density of one of Ochi and Hubble's two peaks, shape of `omega` [m^2 s/rad], 16 m0 = hs^2.

    S = (1/4) (p w_p^4/4)^l/Gamma(l) hs^2/w^p exp(-(p/4) (w_p/w)^4), p = 4 l + 1, with the peakedness l; l = 1 is
    Pierson and Moskowitz's form (Ochi and Hubble, Six-parameter wave spectra, Proc. 15th ICCE, 1976).
    """
    p, peak = 4 * peakedness + 1, 2 * np.pi / tp
    scale = 0.25 * (p / 4) ** peakedness / math.gamma(peakedness) * hs**2 / peak
    ratio = omega / peak
    return np.asarray(scale * np.exp(-p * (np.log(ratio) + 0.25 * ratio**-4.0)))


RESOLVED = 0.01
"""Of the frequency of the peak: bands within which a density hardly changes."""
SMOOTHED = 0.05
"""Of the frequency of the energy period: width of the bands a record's spectrum is averaged over."""
BANDS, HIGHEST = 2000, 40.0
"""Bands a spectrum is summed over, to this multiple of its highest peak frequency: beyond it lies 1e-6 of JONSWAP's."""
Height = Annotated[Positive, within(1e-9, 100.0, "m", "the highest wave ever measured had 30 m, molecules have 1e-9 m")]
Period = Annotated[Positive, within(1e-3, 1e7, "s", "gravity waves have periods between")]


class StillWater(Section):
    """No waves: free decay."""

    kind: Literal["still"]

    @property
    def label(self) -> str:
        """Name of the sea in tables and file names."""
        return "still"

    @property
    def description(self) -> str:
        """The sea in words."""
        return "still water"

    @property
    def family(self) -> str:
        """Name of the sea without its seed."""
        return self.label


class Travelling(Section):
    """Waves that go somewhere: their direction [degrees] from the x axis."""

    direction: Annotated[Number, Field(ge=-360, le=360)] = 0.0

    @property
    def _towards(self) -> str:
        """What the direction adds to a name."""
        return f"_d{self.direction:g}" if self.direction else ""

    @property
    def _going(self) -> str:
        """What the direction adds to words."""
        return f" going to {self.direction:g} degrees" if self.direction else ""


class RegularWave(Travelling):
    """Sine wave: amplitude [m], period [s]."""

    kind: Literal["regular"]
    amplitude: Height
    period: Period

    @property
    def label(self) -> str:
        """Name of the sea in tables and file names."""
        return f"regular_A{self.amplitude:g}_T{self.period:g}{self._towards}"

    @property
    def description(self) -> str:
        """The sea in words."""
        return f"regular waves of {self.amplitude:g} m amplitude and {self.period:g} s period{self._going}"

    @property
    def omega(self) -> float:
        """Angular frequency [rad/s]."""
        return 2 * math.pi / self.period

    @property
    def family(self) -> str:
        """Name of the sea without its seed."""
        return self.label

    @property
    def fastest(self) -> float:
        """Its one frequency [rad/s]."""
        return self.omega


class IrregularSea(Travelling):
    """A sea of many components."""

    if TYPE_CHECKING:
        kind: str
        hs: float  # significant height [m]
        amplitudes: Literal["fixed", "random"]  # of a realisation: those of the sea, or about them

    @property
    @abstractmethod
    def size(self) -> str:
        """Every key of its spectrum that matters, for names of files."""

    @property
    @abstractmethod
    def words(self) -> str:
        """Its spectrum in words."""

    @property
    def family(self) -> str:
        """Name of the sea without its seed."""
        return f"{self.kind}_{self.size}{self._towards}"

    @property
    def label(self) -> str:
        """Name of the sea in tables and file names."""
        return self.family

    @property
    def description(self) -> str:
        """The sea in words."""
        return f"{self.words}{self._going}"

    @property
    @abstractmethod
    def omega(self) -> float:
        """Frequency of the peak, of the middle of the band, or of the energy period [rad/s]."""

    @property
    def reach(self) -> tuple[float, float]:
        """Frequencies the sea must find solved [rad/s]: below 0.4 times the peak there is less than 1e-10 of it."""
        return 0.4 * self.omega, self.omega

    @property
    def fastest(self) -> float:
        """Frequency above which no component has a twentieth of the largest amplitude [rad/s]."""
        return 4.3 * self.omega

    @property
    def memory(self) -> float:
        """Time after which the waves have forgotten what they were [s]: ten peak periods."""
        return 20 * math.pi / self.omega

    @property
    def resolution(self) -> float:
        """Width of bands within which the density hardly changes [rad/s]."""
        return RESOLVED * self.omega

    @abstractmethod
    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad]: 16 m0 = hs^2."""

    def variances(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the variance of the elevation in bands between frequencies [rad/s], shape (band,) [m^2]."""
        width = high - low
        inside = math.ceil(float(np.max(width, initial=0.0)) / (2 * self.resolution))  # a band may hold the peak
        fine = low[:, None] + (np.arange(inside) + 0.5) / inside * width[:, None]
        return np.asarray(self.density(fine).mean(axis=1) * width)

    def bands(self) -> tuple[FloatArray, FloatArray]:
        """Return middles [rad/s] and variances [m^2] of bands that hold all of the sea."""
        low, high = self.reach
        edges = np.geomspace(low, HIGHEST * high, BANDS + 1)
        middle = (edges[1:] + edges[:-1]) / 2
        return middle, self.density(middle) * np.diff(edges)

    def share_below(self, omega: float) -> float:
        """Return the share of the sea's energy below a frequency [rad/s]."""
        below = np.linspace(0.0, omega, 4001)[1:]
        return float(np.trapezoid(self.density(below), below)) * 16 / self.hs**2

    def share_above(self, omega: float) -> float:
        """Return the share of the sea's energy above a frequency [rad/s]."""
        beyond = np.linspace(omega, 20 * omega, 4001)
        return float(np.trapezoid(self.density(beyond), beyond)) * 16 / self.hs**2


class Spreading(Section):
    """Waves spread about their mean direction, cos^2s of half the angle (Longuet-Higgins), in some directions."""

    s: Annotated[Number, Field(ge=1, le=1e4)]
    directions: Annotated[Count, Field(ge=2, le=36)] = 9

    @property
    def angles(self) -> tuple[float, ...]:
        """Directions from the mean [degrees], ascending: in the middle of parts of equal energy."""
        steps = 2 * math.ceil(500 * math.sqrt(self.s))
        half = [math.pi * i / steps for i in range(steps + 1)]  # of the circle, its density even
        density = [math.cos(angle / 2) ** (2 * self.s) for angle in half]
        energy = [0.0]
        for before, after in pairwise(density):
            energy.append(energy[-1] + (before + after) / 2)
        found = []
        for k in range(self.directions):
            wanted = (2 * k + 1 - self.directions) / self.directions * energy[-1]  # from the mean, of either sign
            i = bisect.bisect_left(energy, abs(wanted), 1, steps)
            part = (abs(wanted) - energy[i - 1]) / (energy[i] - energy[i - 1])
            found.append(math.copysign(math.degrees(half[i - 1] + part * (half[i] - half[i - 1])), wanted))
        return tuple(found)


class SpectralSea(Brief, IrregularSea):
    """A sea of a spectrum: seed, number of realisations, amplitudes; its height [m] is `hs`, a key or a property.

    Phases are random. `fixed` amplitudes follow the spectrum, so that every realisation carries the energy of the sea;
    `random` ones are Rayleigh-distributed about it, as in records of a Gaussian sea. Realisations have seeds one after
    the other; a study lists each as a sea of its own and takes statistics over all.
    """

    BRIEF = ("spreading",)
    amplitudes: Literal["fixed", "random"] = "fixed"
    seed: Annotated[Count, Field(ge=0)] = 1
    realisations: Annotated[Count, Field(ge=1, le=1000)] = 1
    spreading: Spreading | None = None

    @property
    def spreads(self) -> bool:
        """Whether its waves go to several directions."""
        return self.spreading is not None

    @property
    def directions(self) -> tuple[float, ...]:
        """Directions its waves go to, the mean one first [degrees]."""
        beside = self.spreading.angles if self.spreading else ()
        return tuple(dict.fromkeys([self.direction, *(round(self.direction + angle, 6) for angle in beside)]))

    @property
    def _towards(self) -> str:
        """What direction and spreading add to a name."""
        spread = f"_s{self.spreading.s:g}x{self.spreading.directions}" if self.spreading else ""
        return f"{super()._towards}{spread}"

    @property
    def _going(self) -> str:
        """What direction and spreading add to words."""
        spread = f", spread by s = {self.spreading.s:g}" if self.spreading else ""
        return f"{super()._going}{spread}"

    @model_validator(mode="after")
    def _seeds_fit_a_file_name(self) -> Self:
        if self.seed + self.realisations > 2**32:
            raise ValueError(f"seed of {len(str(self.seed))} digits: needs at most 2^32 - realisations")
        return self

    @property
    def family(self) -> str:
        """Name of the sea without its seed."""
        return super().family + ("_random" if self.amplitudes == "random" else "")

    @property
    def label(self) -> str:
        """Name of the sea in tables and file names."""
        return f"{self.family}_s{self.seed}"

    @property
    def description(self) -> str:
        """The sea in words."""
        varying = ", amplitudes random" if self.amplitudes == "random" else ""
        return f"{self.words}{varying}{self._going}"


class PeakedSea(SpectralSea):
    """A spectrum of one peak: significant height [m], peak period [s]."""

    hs: Height
    tp: Period

    @property
    def size(self) -> str:
        """Height and period, for names of files."""
        return f"Hs{self.hs:g}_Tp{self.tp:g}"

    @property
    def omega(self) -> float:
        """Peak angular frequency [rad/s]."""
        return 2 * math.pi / self.tp

    @property
    def jonswap_gamma(self) -> float | None:
        """Peakedness of the JONSWAP sea it is [-]; None if it is none."""
        return None


class Jonswap(PeakedSea):
    """JONSWAP sea: peakedness [-]."""

    kind: Literal["jonswap"]
    gamma: Annotated[Number, Field(ge=1, le=10)] = 3.3

    @property
    def size(self) -> str:
        """Height, period and peakedness, for names of files."""
        return f"{super().size}_g{self.gamma:g}"

    @property
    def words(self) -> str:
        """The spectrum in words."""
        return f"a JONSWAP sea of Hs = {self.hs:g} m and Tp = {self.tp:g} s"

    @property
    def jonswap_gamma(self) -> float:
        """Its peakedness [-]."""
        return self.gamma

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad]."""
        return jonswap_spectrum(omega, self.hs, self.tp, self.gamma)


class Tma(PeakedSea):
    """JONSWAP sea on water of a depth [m] that breaks its longer waves (Bouws et al. 1985); gravity [m/s^2]."""

    kind: Literal["tma"]
    gamma: Annotated[Number, Field(ge=1, le=10)] = 3.3
    depth: Annotated[Positive, within(0.1, 2e4, "m", "no sea is deeper")]
    gravity: Annotated[Positive, within(0.01, 300.0, "m/s^2", "the sun has 274 m/s^2")] = 9.81

    @property
    def size(self) -> str:
        """Height, period, peakedness and depth, for names of files."""
        return f"{super().size}_g{self.gamma:g}_h{self.depth:g}"

    @property
    def words(self) -> str:
        """The spectrum in words."""
        return f"a TMA sea of Hs = {self.hs:g} m and Tp = {self.tp:g} s in {self.depth:g} m of water"

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad]."""
        return tma_spectrum(omega, self.hs, self.tp, self.gamma, self.depth, self.gravity)


class PiersonMoskowitz(PeakedSea):
    """Fully developed sea of Pierson and Moskowitz."""

    kind: Literal["pierson_moskowitz"]

    @property
    def words(self) -> str:
        """The spectrum in words."""
        return f"a Pierson-Moskowitz sea of Hs = {self.hs:g} m and Tp = {self.tp:g} s"

    @property
    def jonswap_gamma(self) -> float:
        """Peakedness of the JONSWAP sea it is [-]."""
        return 1.0

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad]."""
        return jonswap_spectrum(omega, self.hs, self.tp, 1.0)


class WhiteNoise(SpectralSea):
    """Sea of constant spectral density over a band [rad/s]: significant height [m], random seed."""

    kind: Literal["white_noise"]
    hs: Height
    band: tuple[Positive, Positive]

    @field_validator("band")
    @classmethod
    def _ascending(cls, value: tuple[float, float]) -> tuple[float, float]:
        if not 1.01 * value[0] <= value[1]:
            raise ValueError("needs the lowest frequency first, then one at least 1 % higher, in rad/s")
        return value

    @property
    def reach(self) -> tuple[float, float]:
        """Frequencies the sea must find solved [rad/s]: its band."""
        return self.band

    @property
    def fastest(self) -> float:
        """Highest frequency of the band [rad/s]."""
        return self.band[1]

    @property
    def memory(self) -> float:
        """Time after which the waves have forgotten what they were [s]: ten periods, or twice 2 pi over the band."""
        return max(20 * math.pi / self.omega, 4 * math.pi / (self.band[1] - self.band[0]))

    @property
    def resolution(self) -> float:
        """Width of bands within which the density hardly changes [rad/s]; a hundred of the whole."""
        return min(super().resolution, (self.band[1] - self.band[0]) / 100)

    @property
    def size(self) -> str:
        """Height and band, for names of files."""
        return f"Hs{self.hs:g}_w{self.band[0]:g}-{self.band[1]:g}"

    @property
    def words(self) -> str:
        """The spectrum in words."""
        return f"white noise of {self.band[0]:g} to {self.band[1]:g} rad/s and Hs = {self.hs:g} m"

    @property
    def omega(self) -> float:
        """Frequency in the middle of the band [rad/s]."""
        return 0.5 * (self.band[0] + self.band[1])

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad]."""
        low, high = self.band
        return np.where((omega >= low) & (omega <= high), self.hs**2 / 16 / (high - low), 0.0)

    def variances(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the variance of the elevation in bands between frequencies [rad/s], shape (band,) [m^2]."""
        inside = np.clip(high, *self.band) - np.clip(low, *self.band)
        return np.asarray(self.hs**2 / 16 / (self.band[1] - self.band[0]) * inside)

    def bands(self) -> tuple[FloatArray, FloatArray]:
        """Return middles [rad/s] and variances [m^2] of bands that hold all of the sea."""
        edges = np.linspace(*self.band, BANDS + 1)
        middle = (edges[1:] + edges[:-1]) / 2
        return middle, self.density(middle) * np.diff(edges)

    def share_below(self, omega: float) -> float:
        """Return the share of the sea's energy below a frequency [rad/s]."""
        low, high = self.band
        return min(1.0, max(0.0, (omega - low) / (high - low)))

    def share_above(self, omega: float) -> float:
        """Return the share of the sea's energy above a frequency [rad/s]."""
        return 1.0 - self.share_below(omega)


class SeaPart(Section):
    """One peak of a sea: significant height [m], peak period [s], peakedness lambda [-] of Ochi and Hubble."""

    hs: Height
    tp: Period
    peakedness: Annotated[Number, Field(ge=0.6, le=10)] = 1.0

    @property
    def omega(self) -> float:
        """Peak angular frequency [rad/s]."""
        return 2 * math.pi / self.tp

    @property
    def exponent(self) -> float:
        """Power of 1/omega that the density falls with, 4 lambda + 1."""
        return 4 * self.peakedness + 1

    @property
    def inverse_frequency(self) -> float:
        """Mean of 1/omega over the energy, m_-1/m_0 [s]."""
        share = math.gamma(self.peakedness + 0.25) / math.gamma(self.peakedness)
        return float((self.exponent / 4) ** -0.25 * share / self.omega)

    @property
    def fastest(self) -> float:
        """Frequency above which the density is less than an 800th of that at the peak [rad/s]."""
        return float(self.omega * math.exp(0.25) * 800 ** (1 / self.exponent))

    @property
    def name(self) -> str:
        """What it adds to the name of a sea."""
        return f"Hs{self.hs:g}_Tp{self.tp:g}_l{self.peakedness:g}"


class OchiHubble(SpectralSea):
    """Sea of two peaks by Ochi and Hubble (1976), swell and the wind sea beside it: their energies add up."""

    kind: Literal["ochi_hubble"]
    swell: SeaPart
    wind_sea: SeaPart

    @model_validator(mode="after")
    def _swell_is_longer(self) -> Self:
        if self.swell.tp <= self.wind_sea.tp:
            raise ValueError(
                f"swell.tp {self.swell.tp:g} s: needs more than that of the wind sea, {self.wind_sea.tp:g} s"
            )
        return self

    @property
    def parts(self) -> tuple[SeaPart, SeaPart]:
        """Swell and wind sea."""
        return self.swell, self.wind_sea

    @property
    def hs(self) -> float:  # type: ignore[override]
        """Significant height of both together [m]."""
        return math.hypot(self.swell.hs, self.wind_sea.hs)

    @property
    def size(self) -> str:
        """Both parts, for names of files."""
        return f"{self.swell.name}_{self.wind_sea.name}"

    @property
    def words(self) -> str:
        """The spectrum in words."""
        swell, wind = (f"Hs = {part.hs:g} m and Tp = {part.tp:g} s" for part in self.parts)
        return f"swell of {swell} with a wind sea of {wind}"

    @property
    def omega(self) -> float:
        """Frequency of the energy period [rad/s]."""
        return self.hs**2 / sum(part.hs**2 * part.inverse_frequency for part in self.parts)

    @property
    def reach(self) -> tuple[float, float]:
        """Frequencies the sea must find solved [rad/s]: from 0.4 times the swell's peak to the wind sea's."""
        return 0.4 * self.swell.omega, self.wind_sea.omega

    @property
    def fastest(self) -> float:
        """Frequency above which no component has a twentieth of the largest amplitude [rad/s]."""
        return max(part.fastest for part in self.parts)

    @property
    def memory(self) -> float:
        """Time after which the waves have forgotten what they were [s]: ten peak periods of the swell."""
        return 10 * self.swell.tp

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad]."""
        return np.asarray(sum(ochi_hubble_peak(omega, part.hs, part.tp, part.peakedness) for part in self.parts))


class SeaOfFile(IrregularSea):
    """A sea that was measured or computed elsewhere, of what its file holds."""

    if TYPE_CHECKING:
        file: Samples | SpectrumTable

    @property
    def hs(self) -> float:  # type: ignore[override]
        """Significant height [m]."""
        return self.file.hs

    @property
    def omega(self) -> float:
        """Frequency of the energy period [rad/s]."""
        return self.file.energy_frequency

    @property
    def reach(self) -> tuple[float, float]:
        """Frequencies the sea must find solved [rad/s]; see `check_band` for what may lie outside."""
        return self.file.lowest, self.omega

    @property
    def fastest(self) -> float:
        """Frequency above which no component has a twentieth of the largest amplitude [rad/s]."""
        return self.file.fastest

    @property
    def size(self) -> str:
        """Height, energy period, and what the file holds, for names of files."""
        return f"Hs{self.hs:.3g}_Te{2 * math.pi / self.omega:.3g}_{self.file.digest}"

    @property
    def description(self) -> str:
        """The sea in words, and how its file was read."""
        return super().description + (f" ({'; '.join(self.file.notes)})" if self.file.notes else "")

    @property
    def _size_in_words(self) -> str:
        """Height and period in words."""
        return f"Hs = {self.hs:.3g} m and Te = {2 * math.pi / self.omega:.3g} s"

    def share_below(self, omega: float) -> float:
        """Return the share of the sea's energy below a frequency [rad/s]."""
        return self.file.share_outside(omega, math.inf)

    def share_above(self, omega: float) -> float:
        """Return the share of the sea's energy above a frequency [rad/s]."""
        return self.file.share_outside(0.0, omega)

    def check_band(self, low: float, high: float, where: str) -> None:
        """Check that a band [rad/s] holds the sea, but for little of its variance; raises `ConfigError`."""
        if (share := self.file.share_outside(low, high)) > LEFT_OUT:
            raise ConfigError(
                f"{where}: received a {self.kind} with {100 * share:.3g} % of its variance outside the band solved, "
                f"needs at most {100 * LEFT_OUT:g} % outside {low:.4g} to {high:.4g} rad/s; filter the {self.kind}, or "
                "solve more"
            )


class RecordedSea(SeaOfFile):
    """A sea that was measured: elevations at the buoy's axis, of which a run follows the beginning.

    Faults of the sensor are repaired or accepted as the file is read: what was done stands in the notes of the file.
    """

    kind: Literal["record"]
    repair: tuple[Repairable, ...] = Field((), exclude=True)
    accept: tuple[Acceptable, ...] = Field((), exclude=True)
    file: Samples

    @field_validator("file", mode="before", json_schema_input_type=str | Samples)
    @classmethod
    def _read(cls, value: Any, info: ValidationInfo) -> Any:
        """A path stands for the file there."""
        if not isinstance(value, str | Path):
            return value
        return read_record(Path(value), "file", info.data.get("repair", ()), info.data.get("accept", ()))

    @property
    def amplitudes(self) -> Literal["fixed"]:  # type: ignore[override]
        """Those of the record: nothing is drawn."""
        return "fixed"

    @property
    def words(self) -> str:
        """The record in words."""
        return f"a record of {self.file.length:g} s of {self._size_in_words}"

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad], averaged over bands of `SMOOTHED`."""
        width = SMOOTHED * self.omega
        return self.variances(omega - width / 2, omega + width / 2) / width

    def variances(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the variance of the elevation in bands between frequencies [rad/s], shape (band,) [m^2].

        Each harmonic stands for the band of frequencies nearest to it, and is cut with it.
        """
        edges = 2 * math.pi / self.file.length * (np.arange(len(self.file.omega) + 1) + 0.5)
        below = np.concatenate([[0.0], np.cumsum(self.file.variances)])
        return np.asarray(np.interp(high, edges, below) - np.interp(low, edges, below))

    def bands(self) -> tuple[FloatArray, FloatArray]:
        """Return frequencies [rad/s] and variances [m^2] of its harmonics."""
        return self.file.omega, self.file.variances


class TabulatedSea(SeaOfFile, SpectralSea):
    """A sea of a spectrum in a file, over frequency or over frequency and direction; random seed."""

    kind: Literal["spectrum"]
    file: SpectrumTable

    @field_validator("file", mode="before", json_schema_input_type=str | SpectrumTable)
    @classmethod
    def _read(cls, value: Any) -> Any:
        """A path stands for the file there."""
        return read_spectrum(Path(value), "file") if isinstance(value, str | Path) else value

    @model_validator(mode="after")
    def _spread_once(self) -> Self:
        if self.spreading and self.file.directions:
            raise ValueError("spreading: the file holds directions of its own; remove it")
        return self

    @property
    def spreads(self) -> bool:
        """Whether its waves go to several directions."""
        return bool(self.spreading or self.file.directions)

    @property
    def directions(self) -> tuple[float, ...]:
        """Directions its waves go to [degrees]: those of the file, turned by `direction`."""
        if not self.file.directions:
            return super().directions
        return tuple(dict.fromkeys(round(self.direction + one, 6) for one in self.file.directions))

    @property
    def words(self) -> str:
        """The spectrum in words."""
        directional = "directional " if self.file.directions else ""
        return f"a {directional}spectrum of {self._size_in_words}"

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad], linear between frequencies of the file."""
        return self.file.at(omega)

    def variances(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the variance of the elevation in bands between frequencies [rad/s], shape (band,) [m^2]."""
        return self.file.variance_below(high) - self.file.variance_below(low)

    def bands(self) -> tuple[FloatArray, FloatArray]:
        """Return middles [rad/s] and variances [m^2] of bands that hold all of the sea."""
        edges = np.linspace(self.file.omega[0], self.file.omega[-1], BANDS + 1)
        return (edges[1:] + edges[:-1]) / 2, self.variances(edges[:-1], edges[1:])


def directions_of(wave: Travelling) -> tuple[float, ...]:
    """Return the directions the waves of a sea go to, the mean one first where they are spread about it [degrees]."""
    return wave.directions if isinstance(wave, SpectralSea) else (wave.direction,)


def file_lines(waves: Iterable[Travelling | StillWater]) -> list[str]:
    """Return the lines `vsb check` prints of seas of files: how each was read, and what was left out."""
    seas = (wave for wave in waves if isinstance(wave, SeaOfFile))
    return list(dict.fromkeys(f"file         {sea.family}: {note}" for sea in seas for note in sea.file.notes))


_DIRECTIONAL = {"directions", "shares"}
_READERS: dict[str, Callable[..., dict[str, Any]]] = {"record": read_record, "spectrum": read_spectrum}


def _faults_of(wave: dict[str, Any]) -> dict[str, list[str]]:
    """Faults of a record that are to be repaired or accepted, as it is written; wrong ones are reported later."""
    asked = {key: wave[key] for key in ("repair", "accept") if isinstance(wave.get(key), list | tuple)}
    return {key: [str(name) for name in names] for key, names in asked.items()} if wave["kind"] == "record" else {}


def with_files(raw: Any, source: str) -> Any:
    """Return a study as nested mappings with records and spectra of its waves in place of the files that hold them.

    A buoy that heaves answers waves of all directions alike: its spectra are over frequency alone. Raises `ConfigError`
    as of `read_record` and `read_spectrum`.

    Parameters
    ----------
    source : str
        File of the study, which names of files are relative to.
    """
    waves = raw.get("waves") if isinstance(raw, dict) else None
    heaves = isinstance(raw, dict) and "device" in raw and raw.get("motion", "heave") == "heave"
    found = raw
    for i, wave in enumerate(waves if isinstance(waves, list | tuple) else ()):
        if not isinstance(wave, dict) or not isinstance(name := wave.get("file"), str):
            continue
        if isinstance(kind := wave.get("kind"), str) and kind in _READERS:
            line = raw.line(("waves", i, "file")) if isinstance(raw, Located) else None
            where = f"{source}{'' if line is None else f':{line}'}: waves.{i}.file"
            held = _READERS[kind](Path(source).parent / name, where, **_faults_of(wave))
            found = copy.deepcopy(raw) if found is raw else found
            found["waves"][i]["file"] = {key: held[key] for key in held if not (heaves and key in _DIRECTIONAL)}
    return found


Spectral = Jonswap | PiersonMoskowitz | Tma | OchiHubble | WhiteNoise | TabulatedSea
"""Seas of a spectrum."""
Irregular = Spectral | RecordedSea
Wave = Annotated[StillWater | RegularWave | Irregular, Field(discriminator="kind")]
