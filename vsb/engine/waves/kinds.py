"""The kinds of seas of a model spectrum: what a file may say of each, its words, and its spectral density.

A new kind is a class here, with `kind`, its keys and what they mean, `density` and `words`, and a name in `Spectral`.
"""

import copy
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from vsb.engine.waves.records import RecordedSea as RecordedSea
from vsb.engine.waves.records import read_record
from vsb.engine.waves.seas import BANDS, BaseWave, Height, Peak, Period
from vsb.engine.waves.seas import IrregularSea as IrregularSea
from vsb.engine.waves.seas import RegularWave as RegularWave
from vsb.engine.waves.seas import SeaOfFile as SeaOfFile
from vsb.engine.waves.seas import SpectralSea as SpectralSea
from vsb.engine.waves.seas import StillWater as StillWater
from vsb.engine.waves.seas import Travelling as Travelling
from vsb.engine.waves.spectrum_table import TabulatedSea, read_spectrum
from vsb.engine.waves.water import Water, wavenumbers
from vsb.keys.meanings import Key
from vsb.keys.quantities import Number, Positive, Section, within
from vsb.keys.schema import Located
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


class PeakedSea(SpectralSea):
    """A spectrum of one peak: significant height [m], peak period [s]."""

    of_file: ClassVar[Literal[False]] = False
    KEYS: ClassVar = {"tp": Key("s", "8.0", "period at the spectrum's peak")}
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


class Jonswap(PeakedSea):
    """JONSWAP sea: peakedness [-]."""

    KEYS: ClassVar = {
        "kind": Key("", "jonswap", "a growing wind sea"),
        "tp": Key("s", "5.0", "period at the spectrum's peak"),
        "gamma": Key("-", "3.3", "peakedness; 1 is Pierson and Moskowitz's sea"),
    }
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
    def jonswap(self) -> Peak | None:
        """Its peak; None of a kind made from this one that has another density."""
        own = type(self)
        same = (own.density, own.variances) == (Jonswap.density, Jonswap.variances)
        return Peak(self.hs, self.tp, self.gamma) if same else None

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad]."""
        return jonswap_spectrum(omega, self.hs, self.tp, self.gamma)


class Tma(Jonswap):
    """JONSWAP sea on water of a depth [m] that breaks its longer waves (Bouws et al. 1985); gravity [m/s^2]."""

    KEYS: ClassVar = {
        "kind": Key("", "tma", "a JONSWAP sea in water that is not deep"),
        "tp": Key("s", "8.0", "period at the peak of the deep-water spectrum"),
        "gamma": Key("-", "3.3", "peakedness of the deep-water spectrum"),
        "depth": Key("m", "20.0", "depth of the water, that of the section water"),
        "gravity": Key("m/s^2", "9.81", "gravity, that of the section water"),
    }
    kind: Literal["tma"]  # type: ignore[assignment]
    depth: Annotated[Positive, within(0.1, 2e4, "m", "no sea is deeper")]
    gravity: Annotated[Positive, within(0.01, 300.0, "m/s^2", "the sun has 274 m/s^2")] = 9.81

    @property
    def size(self) -> str:
        """Height, period, peakedness and depth, for names of files."""
        return f"{super().size}_h{self.depth:g}"

    @property
    def words(self) -> str:
        """The spectrum in words."""
        return f"a TMA sea of Hs = {self.hs:g} m and Tp = {self.tp:g} s in {self.depth:g} m of water"

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad]: JONSWAP's in water of the depth, 16 m0 = hs^2.

        S = S_J(w) tanh^2(kh)/(1 + 2kh/sinh 2kh), the factor (w^2 h/g)/2 in shallow, 1 in deep water: a saturated sea
        has in any depth the same spectrum over wavenumber (Kitaigorodskii et al. 1975; Bouws et al., J. Geophys. Res.
        90, 1985).
        """

        def shape(w: FloatArray) -> FloatArray:
            kh = np.minimum(self.depth * wavenumbers(w, self.depth, self.gravity), 300.0)
            factor = np.tanh(kh) ** 2 / (1 + 2 * kh / np.sinh(2 * kh))
            return np.asarray(_jonswap_shape(w, self.tp, self.gamma) * factor)

        return _scaled(shape, omega, self.hs, self.tp)

    def check_water(self, water: Water, where: str) -> None:
        """Check that the sea is one of this water; raises `ValueError`."""
        for key, given, here, unit in (
            ("depth", self.depth, water.depth, "m"),
            ("gravity", self.gravity, water.gravity, "m/s^2"),
        ):
            if given != here:
                raise ValueError(
                    f"{where}.{key} {given:g} {unit}: is that of another water; needs water.{key}, here {here:g} {unit}"
                )


class PiersonMoskowitz(PeakedSea):
    """Fully developed sea of Pierson and Moskowitz."""

    KEYS: ClassVar = {"kind": Key("", "pierson_moskowitz", "a fully developed sea")}
    kind: Literal["pierson_moskowitz"]

    @property
    def words(self) -> str:
        """The spectrum in words."""
        return f"a Pierson-Moskowitz sea of Hs = {self.hs:g} m and Tp = {self.tp:g} s"

    @property
    def jonswap(self) -> Peak | None:
        """That of the JONSWAP sea it is; None of a kind made from this one that has another density."""
        own = type(self)
        same = (own.density, own.variances) == (PiersonMoskowitz.density, PiersonMoskowitz.variances)
        return Peak(self.hs, self.tp, 1.0) if same else None

    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad]."""
        return jonswap_spectrum(omega, self.hs, self.tp, 1.0)


class WhiteNoise(SpectralSea):
    """Sea of constant spectral density over a band [rad/s]: significant height [m], random seed."""

    of_file: ClassVar[Literal[False]] = False
    KEYS: ClassVar = {
        "kind": Key("", "white_noise", "constant spectral density over a band"),
        "band": Key("rad/s", "[1.0, 3.0]", "lowest and highest frequency"),
    }
    even_components: ClassVar[bool] = False
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

    def check_below(self, omega_max: float, where: str) -> None:
        """Check that the band ends below a frequency [rad/s]; raises `ValueError`."""
        if self.band[1] > omega_max:
            raise ValueError(f"{where}.band {list(self.band)} rad/s: needs at most hydro.omega_max = {omega_max:g}")

    def components(self, omega_max: float, duration: float, omega_min: float = 0.0) -> tuple[FloatArray, FloatArray]:
        """Return components within the band, whatever the highest frequency."""
        return super().components(self.band[1], duration, self.band[0])


class SeaPart(Section):
    """One peak of a sea: significant height [m], peak period [s], peakedness lambda [-] of Ochi and Hubble."""

    KEYS: ClassVar = {
        "hs": SpectralSea.KEYS["hs"],
        "tp": Key("s", "12.0", "period at its peak"),
        "peakedness": Key("-", "3.0", "Ochi and Hubble's lambda: 1 is Pierson and Moskowitz's form; larger: narrower"),
    }
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

    def density(self, omega: FloatArray) -> FloatArray:
        """Return its spectral density, shape of `omega` [m^2 s/rad], 16 m0 = hs^2.

        S = (1/4) (p w_p^4/4)^l/Gamma(l) hs^2/w^p exp(-(p/4) (w_p/w)^4), p = 4 l + 1, with the peakedness l; l = 1 is
        Pierson and Moskowitz's form (Ochi and Hubble, Six-parameter wave spectra, Proc. 15th ICCE, 1976).
        """
        p, peak = self.exponent, 2 * np.pi / self.tp
        scale = 0.25 * (p / 4) ** self.peakedness / math.gamma(self.peakedness) * self.hs**2 / peak
        ratio = omega / peak
        return np.asarray(scale * np.exp(-p * (np.log(ratio) + 0.25 * ratio**-4.0)))

    @property
    def name(self) -> str:
        """What it adds to the name of a sea."""
        return f"Hs{self.hs:g}_Tp{self.tp:g}_l{self.peakedness:g}"


class OchiHubble(SpectralSea):
    """Sea of two peaks by Ochi and Hubble (1976), swell and the wind sea beside it: their energies add up."""

    of_file: ClassVar[Literal[False]] = False
    KEYS: ClassVar = {
        "kind": Key("", "ochi_hubble", "a sea of two peaks: swell and the wind sea beside it"),
        "swell": Key("", "{hs: 1.5, tp: 12.0, peakedness: 3.0}", "the longer waves"),
        "wind_sea": Key("", "{hs: 1.0, tp: 5.0}", "the shorter waves; the energies of both add up"),
    }
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
        return np.asarray(sum(part.density(omega) for part in self.parts))


Spectral = Jonswap | PiersonMoskowitz | Tma | OchiHubble | WhiteNoise | TabulatedSea
"""Seas of a spectrum."""
Irregular = Spectral | RecordedSea
Wave = Annotated[StillWater | RegularWave | Irregular, Field(discriminator="kind")]


def file_lines(waves: Iterable[BaseWave]) -> list[str]:
    """Return the lines `vsb check` prints of seas of files: how each was read, and what was left out."""
    return list(dict.fromkeys(f"file         {sea.family}: {note}" for sea in waves for note in sea.file_notes))


_DIRECTIONAL = {"directions", "shares"}
_READERS: dict[str, Callable[..., dict[str, Any]]] = {"record": read_record, "spectrum": read_spectrum}


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
            asked = [
                key for key in ("repair", "accept") if kind == "record" and isinstance(wave.get(key), list | tuple)
            ]
            faults = {key: [str(fault) for fault in wave[key]] for key in asked}  # wrong ones are reported later
            held = _READERS[kind](Path(source).parent / name, where, **faults)
            found = copy.deepcopy(raw) if found is raw else found
            found["waves"][i]["file"] = {key: held[key] for key in held if not (heaves and key in _DIRECTIONAL)}
    return found
