"""Waves and seas: what every kind of them answers, and their realisations as sums of regular components.

A kind of sea is one class with its keys, their meanings, words and numbers. Model spectra are in
`vsb.engine.waves.kinds`, seas of files in `vsb.engine.waves.records` and `vsb.engine.waves.spectrum_table`.
"""

import bisect
import math
from abc import abstractmethod
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from vsb.engine.waves.water import Water, group_velocity
from vsb.errors import ConfigError
from vsb.keys.meanings import Key
from vsb.keys.quantities import Brief, Count, Number, Positive, Section, content_id, within
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray, IntArray

FEW = 32
"""Up to this number components are summed directly."""
_TABLE = 2**14  # cosines at a time: they fit the cache
_AT_ONCE = 2**21  # complex numbers of a transform, for as many signals as fit
_SAME = 4e-15  # round-off, relative to the highest frequency
RESOLVED = 0.01
"""Of the frequency of the peak: bands within which a density hardly changes."""
BANDS, HIGHEST = 2000, 40.0
"""Bands a spectrum is summed over, to this multiple of its highest peak frequency: beyond it lies 1e-6 of JONSWAP's."""
TAIL = 0.005
"""Share of the variance that lies below the lowest frequency a sea of a file needs solved [-]."""
LEFT_OUT = 0.01
"""Largest share of the variance of a sea of a file that may lie outside the band solved [-]."""
Height = Annotated[Positive, within(1e-9, 100.0, "m", "the highest wave ever measured had 30 m, molecules have 1e-9 m")]
Period = Annotated[Positive, within(1e-3, 1e7, "s", "gravity waves have periods between")]


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
    spacing = 0.0  # of many components that are equally spaced [rad/s]
    if len(omega) > FEW:
        even = float(omega[-1] - omega[0]) / (len(omega) - 1)
        off = np.abs(omega - (omega[0] + even * np.arange(len(omega)))).max()
        spacing = even if off <= _SAME * np.abs(omega).max() else 0.0
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


class SeaEnergy(NamedTuple):
    """Height, energy period and energy flux of a sea."""

    height: float  # significant height of an irregular sea, crest to trough of regular waves [m]
    period: float  # energy period of an irregular sea, Te = 2 pi m_-1/m_0 [s]
    flux: float  # rho g int v_g S dw, per metre of crest [W/m]


class Peak(NamedTuple):
    """The peak of a JONSWAP sea."""

    hs: float  # significant height [m]
    tp: float  # peak period [s]
    gamma: float  # peakedness [-]


class BaseWave(Section):
    """What every kind of waves answers, so that nobody else asks which it is."""

    still: ClassVar[bool] = False
    regular: ClassVar[bool] = False
    irregular: ClassVar[bool] = False
    drawn: ClassVar[bool] = False  # whether its phases are drawn, by a seed
    of_file: ClassVar[bool] = False
    recorded: ClassVar[bool] = False

    @property
    @abstractmethod
    def label(self) -> str:
        """Name of the sea in tables and file names."""

    @property
    @abstractmethod
    def description(self) -> str:
        """The sea in words."""

    @property
    def family(self) -> str:
        """Name of the sea without its seed."""
        return self.label

    @property
    def directions(self) -> tuple[float, ...]:
        """Directions its waves go to, the mean one first where they are spread about it [degrees]."""
        return ()

    @property
    def spreads(self) -> bool:
        """Whether its waves go to several directions."""
        return False

    @property
    def expected(self) -> Self:
        """The sea with the amplitudes of its spectrum, |a_j|^2 = E |a_j|^2, so that powers are expected values."""
        return self

    @property
    def file_notes(self) -> tuple[str, ...]:
        """How the file of the sea was read, and what was left out."""
        return ()

    def check_water(self, water: Water, where: str) -> None:
        """Check that the sea is one of this water; raises `ValueError`."""

    def check_below(self, omega_max: float, where: str) -> None:
        """Check that the sea ends below a frequency [rad/s], if it has an end; raises `ValueError`."""

    @abstractmethod
    def realisation(self, omega_max: float = math.inf, duration: float = 0.0) -> Sea:
        """Return its regular components up to a frequency [rad/s], which do not repeat within a run [s]."""


class StillWater(BaseWave):
    """No waves: free decay."""

    KEYS: ClassVar = {"kind": Key("", "still", "no waves: free decay")}
    still: ClassVar[Literal[True]] = True
    regular: ClassVar[Literal[False]] = False
    irregular: ClassVar[Literal[False]] = False
    drawn: ClassVar[Literal[False]] = False
    of_file: ClassVar[Literal[False]] = False
    recorded: ClassVar[Literal[False]] = False
    kind: Literal["still"]

    @property
    def label(self) -> str:
        """Name of the sea in tables and file names."""
        return "still"

    @property
    def description(self) -> str:
        """The sea in words."""
        return "still water"

    def realisation(self, omega_max: float = math.inf, duration: float = 0.0) -> Sea:
        """Return no components."""
        return NO_WAVES


class Travelling(BaseWave):
    """Waves that go somewhere: their direction [degrees] from the x axis."""

    KEYS: ClassVar = {
        "direction": Key(
            "degrees", "45.0", "direction the waves travel to, from the x axis; for a body, or a buoy that surges"
        )
    }
    still: ClassVar[Literal[False]] = False
    direction: Annotated[Number, Field(ge=-360, le=360)] = 0.0

    @property
    def directions(self) -> tuple[float, ...]:
        """Directions its waves go to, the mean one first where they are spread about it [degrees]."""
        return (self.direction,)

    @property
    def _towards(self) -> str:
        """What the direction adds to a name."""
        return f"_d{self.direction:g}" if self.direction else ""

    @property
    def _going(self) -> str:
        """What the direction adds to words."""
        return f" going to {self.direction:g} degrees" if self.direction else ""

    @property
    @abstractmethod
    def omega(self) -> float:
        """Frequency of the peak, of the middle of the band, or of the energy period [rad/s]."""

    @property
    @abstractmethod
    def fastest(self) -> float:
        """Frequency above which no component has a twentieth of the largest amplitude [rad/s]."""

    @property
    @abstractmethod
    def height(self) -> float:
        """Significant height of an irregular sea, crest to trough of regular waves [m]."""

    @abstractmethod
    def bands(self) -> tuple[FloatArray, FloatArray]:
        """Return middles [rad/s] and variances [m^2] of bands that hold all of the sea."""

    def energy(self, water: Water) -> SeaEnergy:
        """Return height, period and energy flux of the sea in water of a depth (IEC TS 62600-101).

        Examples
        --------
        In deep water the flux is rho g^2 Hs^2 Te/(64 pi):

        >>> import math
        >>> from vsb.engine.waves.kinds import Jonswap
        >>> sea = Jonswap(kind="jonswap", hs=2.0, tp=8.0).energy(Water())
        >>> round(sea.period, 2), round(sea.flux / (1025 * 9.81**2 * 2.0**2 * sea.period / (64 * math.pi)), 6)
        (7.23, 1.0)
        """
        omega, variance = self.bands()
        speed = np.array([group_velocity(w, water.depth, water.gravity) for w in omega])
        period = 2 * np.pi * float(variance @ (1 / omega) / variance.sum())
        return SeaEnergy(self.height, period, water.density * water.gravity * float(variance @ speed))


class RegularWave(Travelling):
    """Sine wave: amplitude [m], period [s]."""

    KEYS: ClassVar = {
        "kind": Key("", "regular", "a sine wave"),
        "amplitude": Key("m", "0.179", "half the height from trough to crest"),
        "period": Key("s", "2.5", "period of the wave"),
    }
    regular: ClassVar[Literal[True]] = True
    irregular: ClassVar[Literal[False]] = False
    drawn: ClassVar[Literal[False]] = False
    of_file: ClassVar[Literal[False]] = False
    recorded: ClassVar[Literal[False]] = False
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
    def fastest(self) -> float:
        """Its one frequency [rad/s]."""
        return self.omega

    @property
    def height(self) -> float:
        """Height from trough to crest [m]."""
        return 2 * self.amplitude

    def bands(self) -> tuple[FloatArray, FloatArray]:
        """Return its frequency [rad/s] and variance [m^2]."""
        return np.array([self.omega]), np.array([self.amplitude**2 / 2])

    def realisation(self, omega_max: float = math.inf, duration: float = 0.0) -> Sea:
        """Return the wave, crest at the axis at t = 0."""
        return Sea(np.array([self.omega]), np.array([complex(self.amplitude)]))


class IrregularSea(Travelling):
    """A sea of many components."""

    irregular: ClassVar[Literal[True]] = True
    regular: ClassVar[Literal[False]] = False
    even_components: ClassVar[bool] = True  # odd multiples of half their spacing, at one density each
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

    @abstractmethod
    def density(self, omega: FloatArray) -> FloatArray:
        """Return the spectral density, shape of `omega` [m^2 s/rad]: 16 m0 = hs^2."""

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
    def height(self) -> float:
        """Significant height [m]."""
        return self.hs

    @property
    def jonswap(self) -> Peak | None:
        """The peak of the JONSWAP sea it is; None if it is none."""
        return None

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

    def components(self, omega_max: float, duration: float, omega_min: float = 0.0) -> tuple[FloatArray, FloatArray]:
        """Return frequencies and amplitudes of components that do not repeat within a run, each (component,).

        Components lie at the centres of equal bands no wider than 2 pi/(1.1 duration), up to omega_max [rad/s].
        Amplitudes [m] follow the spectrum exactly: a_j^2 = 2 int S dw over the band.
        """
        count = int(np.ceil((omega_max - omega_min) * 1.1 * duration / (2 * np.pi)))
        width = (omega_max - omega_min) / count
        omega = omega_min + (np.arange(count) + 0.5) * width
        return omega, np.sqrt(2 * self.variances(omega - width / 2, omega + width / 2))


GOLDEN = (math.sqrt(5) - 1) / 2
"""Golden ratio, whose multiples modulo one are spread most evenly."""
FEWEST_OF_MOMENTS, MOST_STEPS = 7, 12
"""Directions from which on two moments of a spreading are kept; steps of Newton's method, which needs up to seven."""


class Spreading(Section):
    """Waves spread about their mean direction, cos^2s of half the angle (Longuet-Higgins), in some directions."""

    KEYS: ClassVar = {
        "s": Key("-", "10.0", "exponent of cos^2s of half the angle from the mean direction; large: long-crested"),
        "directions": Key("-", "9", "how many directions of equal energy stand for it"),
    }
    s: Annotated[Number, Field(ge=1, le=1e4)]
    directions: Annotated[Count, Field(ge=2, le=36)] = 9

    @property
    def angles(self) -> tuple[float, ...]:
        """Directions from the mean [degrees], ascending: about the middles of parts of equal energy.

        The middles themselves, of nine directions and s = 10, would absorb 1.4 % too much at a surging port. They are
        moved, x to (a + b x^2) x, until the means of cos theta and cos 2 theta, which the power of a buoy of revolution
        goes with, are those of the law, s/(s + 1) and s(s - 1)/((s + 1)(s + 2)); of few directions the second alone.
        """
        middles, s = np.array(self._middles), self.s
        orders = np.array([1, 2] if self.directions >= FEWEST_OF_MOMENTS else [2])
        wanted = {1: 1 / (s + 1), 2: (4 * s + 2) / ((s + 1) * (s + 2))}  # means of 1 - cos
        shape = middles[:, None] ** (2 * np.arange(len(orders)) + 1)
        shape *= middles[-1] / shape[-1]
        moved = np.eye(len(orders))[0]
        for _ in range(MOST_STEPS):
            turned = np.outer(orders, shape @ moved)
            off = 2 * np.mean(np.sin(turned / 2) ** 2, axis=1) - [wanted[order] for order in orders]
            slopes = (orders[:, None] * np.sin(turned)) @ shape / len(middles)
            moved = moved - np.linalg.solve(slopes, off)
        return tuple(np.degrees(shape @ moved).tolist())

    @property
    def _middles(self) -> list[float]:
        """Middles of parts of equal energy, from the mean direction [rad], ascending."""
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
            found.append(math.copysign(half[i - 1] + part * (half[i] - half[i - 1]), wanted))
        return found


class SpectralSea(Brief, IrregularSea):
    """A sea of a spectrum: seed, number of realisations, amplitudes; its height [m] is `hs`, a key or a property.

    Phases are random. `fixed` amplitudes follow the spectrum, so that every realisation carries the energy of the sea;
    `random` ones are Rayleigh-distributed about it, as in records of a Gaussian sea. Realisations have seeds one after
    the other; a study lists each as a sea of its own and takes statistics over all.
    """

    BRIEF = ("spreading",)
    KEYS: ClassVar = {
        "hs": Key("m", "1.0", "significant wave height, four times the root of the spectrum's area"),
        "amplitudes": Key(
            "",
            "random",
            "fixed: those of the spectrum; random: Rayleigh-distributed about it, as in records of a real sea",
        ),
        "seed": Key("-", "1", "seed of the random phases and amplitudes"),
        "realisations": Key("-", "8", "how many seas of this spectrum are simulated, with consecutive seeds"),
        "spreading": Key("", "{s: 10.0}", "short-crested waves, spread about the direction; for a buoy that surges"),
    }
    drawn: ClassVar[Literal[True]] = True
    recorded: ClassVar[Literal[False]] = False
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

    @property
    def expected(self) -> Self:
        """The sea with the amplitudes of its spectrum, |a_j|^2 = E |a_j|^2, so that powers are expected values."""
        return self.model_copy(update={"amplitudes": "fixed"})

    def realisation(self, omega_max: float = math.inf, duration: float = 0.0) -> Sea:
        """Return a realisation that does not repeat within the run: random phases, amplitudes of `components`.

        Random amplitudes are Rayleigh-distributed about those, |a_j|^2 exponential of that mean: real and imaginary
        parts are independent normal variables, and the elevation is exactly Gaussian. Of a spread sea see `headings`.
        """
        omega, amplitude = self.components(omega_max, duration)
        random = np.random.default_rng(self.seed)
        phasor = np.exp(1j * random.uniform(0.0, 2 * np.pi, len(omega)))
        if self.amplitudes == "random":
            phasor *= np.sqrt(random.exponential(size=len(omega)))
        return Sea(omega, amplitude * phasor, self.headings(omega)).part(amplitude > 1e-12 * amplitude.max())

    @property
    def parts_around(self) -> int:
        """Parts of equal energy that the directions of a spread sea are drawn from in turn."""
        return self.spreading.directions if self.spreading else 1

    def angles_at(self, omega: FloatArray, part: IntArray, random: np.random.Generator) -> FloatArray:
        """Return the angles from `direction` of parts of a spread sea at frequencies, shape (omega,) [degrees]."""
        assert self.spreading is not None
        return np.asarray(np.array(self.spreading.angles)[part])

    def shares_around(self, omega: FloatArray) -> list[tuple[float, FloatArray]]:
        """Return the directions of a spread sea [degrees], and what part of the energy at frequencies goes to each."""
        assert self.spreading is not None
        angles = self.spreading.angles
        return [(round(self.direction + angle, 6), np.full(len(omega), 1 / len(angles))) for angle in angles]

    def headings(self, omega: FloatArray) -> FloatArray | None:
        """Return the direction of each component of a spread sea, (omega,) [degrees]; None of a long-crested one.

        Every component goes to one direction, so that the sea is the same all along a run. Parts of equal energy take
        turns, in an order drawn anew for every round: each carries the same part of the spectrum. Of a spreading a part
        is one direction, of a table over direction it is of the energy there at the component's frequency.
        """
        if not self.spreads:
            return None
        parts = self.parts_around
        random = np.random.default_rng([self.seed, 1])
        rounds = -(-len(omega) // parts)
        order = np.concatenate([random.permutation(parts) for _ in range(rounds)])[: len(omega)]
        return self.headings_of(omega, order, random)

    def headings_of(self, omega: FloatArray, part: IntArray, random: np.random.Generator) -> FloatArray:
        """Return the directions of parts of a spread sea at frequencies, shape (omega,) [degrees]."""
        return np.asarray(np.round(self.direction + self.angles_at(omega, part, random), 6))

    def even_headings(self, omega: FloatArray) -> FloatArray:
        """Return likewise directions that take turns most evenly, whatever the seed, for expectations.

        The order of a round is that of multiples of the golden ratio modulo one, so that each part of it has all
        directions; every other round is turned round, so that no slope of the spectrum favours a direction.
        """
        order = np.argsort(np.arange(self.parts_around) * GOLDEN % 1.0)
        part = np.resize(np.concatenate([order, order[::-1]]), len(omega))
        return self.headings_of(omega, part, np.random.default_rng(1))


class SeaFile(Brief):
    """What a file holds of a sea; its `notes` say what it holds beside, and how it was read."""

    BRIEF = ("notes",)
    if TYPE_CHECKING:
        notes: tuple[str, ...]

    @property
    @abstractmethod
    def hs(self) -> float:
        """Significant height, four standard deviations [m]."""

    @property
    @abstractmethod
    def energy_frequency(self) -> float:
        """Frequency of the energy period m_-1/m_0 [rad/s]."""

    @property
    @abstractmethod
    def lowest(self) -> float:
        """Frequency below which lies less than `TAIL` of the variance [rad/s]."""

    @property
    @abstractmethod
    def fastest(self) -> float:
        """Frequency above which no component has a twentieth of the largest amplitude [rad/s]."""

    @abstractmethod
    def share_outside(self, low: float, high: float) -> float:
        """Return the share of the variance outside a band [rad/s]."""

    @cached_property
    def digest(self) -> str:
        """Eight hexadecimal digits that name it by what it holds."""
        return content_id(self.model_dump(exclude={"notes"}))[:8]


class SeaOfFile(IrregularSea):
    """A sea that was measured or computed elsewhere, of what its file holds."""

    of_file: ClassVar[Literal[True]] = True
    if TYPE_CHECKING:
        file: SeaFile

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
    def file_notes(self) -> tuple[str, ...]:
        """How the file of the sea was read, and what was left out."""
        return self.file.notes

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
