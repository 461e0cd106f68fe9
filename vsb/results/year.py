"""A site's year: power of every design in every measured sea under every tuning, and bins of Hs and Te.

Mean power of one sea is int 2 S(w) P(w; c) dw, P the power of a damper c per squared wave amplitude. A spectrum is
known as means over bands, so this is one product of the spectra with P integrated over each band. P is interpolated
linearly between the frequencies of a port: the weights are positive, the order is two, and the error is a third of what
the answer changes by with every other frequency. Matrices over bins follow IEC TS 62600-100.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Generic, Literal, Self, TypeVar

import numpy as np
import xarray as xr

from vsb.engine.motion.damper_matrix import Ports
from vsb.engine.motion.port import Port
from vsb.engine.motion.tuning import Load, best_damper_of_each, best_of_table, dampers
from vsb.engine.waves.climate import OUTSIDE, YEAR_HOURS, Climate
from vsb.engine.waves.scatter import climate_of_cells
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.tools.arrays import AnyArray, FloatArray, IntArray
from vsb.tools.variables import described

Tuning = Literal["fixed", "one", "each"]
TUNINGS: tuple[Tuning, ...] = ("fixed", "one", "each")
"""Given damper; one best damper for the year; the best in each sea."""
Values = Mapping[str, tuple[tuple[str, ...], AnyArray]]
"""Dimensions and values by name; a dataset is made of them only at the end, which takes as long as computing them."""
POWER_ENDS = ("annual_mean_power_low", "annual_mean_power_high")
"""Interval of the mean power over the year by all known errors [W]."""
PART = 0.005
"""Distance of the frequencies of a port, as a part of them: every band of a climate is cut evenly into such parts."""
PRACTICE_GAMMA = 3.3
"""Peakedness of the JONSWAP seas at bin centres which usual practice puts in the place of spectra."""


HEIGHT = 0.5
"""Width of bins of significant wave height [m]."""
PERIOD = 1.0
"""Width of bins of energy period [s]."""


@dataclass(frozen=True)
class Bins:
    """Half-open bins of IEC TS 62600-100: [0.5 i, 0.5 (i + 1)) m of Hs, [j, j + 1) s of Te, to the highest occupied."""

    hs: FloatArray  # (sea,) [m]
    te: FloatArray  # (sea,) [s]
    hours: FloatArray  # share of the year of each sea (sea,) [-]

    @cached_property
    def _at(self) -> tuple[IntArray, IntArray]:
        """Row and column of each sea."""
        return np.floor(self.hs / HEIGHT).astype(np.intp), np.floor(self.te / PERIOD).astype(np.intp)

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Number of bins of height and of period."""
        return int(self._at[0].max()) + 1, int(self._at[1].max()) + 1

    @cached_property
    def index(self) -> IntArray:
        """Bin of each sea, rows one after the other, shape (sea,)."""
        return np.asarray(self._at[0] * self.shape[1] + self._at[1])

    @property
    def hs_centres(self) -> FloatArray:
        """Centres of the bins of height, shape (hs,) [m]."""
        return np.asarray(HEIGHT * (np.arange(self.shape[0]) + 0.5))

    @property
    def te_centres(self) -> FloatArray:
        """Centres of the bins of period, shape (te,) [s]."""
        return np.asarray(PERIOD * (np.arange(self.shape[1]) + 0.5))

    @cached_property
    def count(self) -> IntArray:
        """Number of seas, shape (hs, te)."""
        return np.asarray(np.bincount(self.index, minlength=self.shape[0] * self.shape[1]).reshape(self.shape))

    @cached_property
    def share(self) -> FloatArray:
        """Share of the year, shape (hs, te) [-]."""
        return self.total(self.hours)

    @cached_property
    def occupied(self) -> IntArray:
        """Bins that hold seas, as `index`, ascending, shape (bin,)."""
        return np.asarray(np.flatnonzero(self.count))

    @property
    def centres(self) -> tuple[FloatArray, FloatArray]:
        """Hs and Te at the centres of the occupied bins, each shape (bin,)."""
        row, column = np.unravel_index(self.occupied, self.shape)
        return self.hs_centres[row], self.te_centres[column]

    def matrix(self, values: FloatArray) -> FloatArray:
        """Return values of the occupied bins, shape (bin,), in their places, 0 elsewhere, shape (hs, te)."""
        out = np.zeros(self.shape)
        out.ravel()[self.occupied] = values
        return out

    def mean_densities(self, climate: Climate) -> FloatArray:
        """Return the mean spectrum of each occupied bin, shape (bin, omega) [m^2 s]."""
        weight = np.zeros((len(self.occupied), len(self.hours)))
        weight[np.searchsorted(self.occupied, self.index), np.arange(len(self.hours))] = self.hours
        return np.asarray(weight @ climate.density / weight.sum(axis=1, keepdims=True))

    def total(self, values: FloatArray) -> FloatArray:
        """Return sums over the seas of each bin, shape (hs, te), of values, shape (sea,)."""
        size = self.shape[0] * self.shape[1]
        return np.asarray(np.bincount(self.index, values, minlength=size).reshape(self.shape))

    def mean(self, values: FloatArray) -> FloatArray:
        """Return means over the seas of each bin, weighted by their hours, shape (hs, te); 0 where there are none."""
        return np.divide(self.total(self.hours * values), self.share, out=np.zeros(self.shape), where=self.share > 0)

    def deviation(self, values: FloatArray) -> FloatArray:
        """Return standard deviations within each bin, weighted by hours, shape (hs, te); 0 where there are none.

        Of the bin's own seas, N below the line: Formula D.5 of Edition 2.
        """
        return np.sqrt(self.mean((values - self.mean(values).ravel()[self.index]) ** 2))


@lru_cache(maxsize=4)
def bins_of(climate: Climate) -> Bins:
    """Return the bins of the seas of a climate: all designs and members over it share them."""
    return Bins(climate.hs, climate.te, climate.hours)


def frequencies(climate: Climate, omega_min: float, omega_max: float) -> FloatArray:
    """Return frequencies at which to compute a port for a climate, ascending [rad/s].

    Parameters
    ----------
    omega_min, omega_max : float [rad/s]
        The band the hydrodynamics are known in.
    """
    edges = np.unique(np.clip(climate.edges, omega_min, omega_max))
    parts = [
        np.linspace(a, b, int(np.ceil((b - a) / (PART * (a + b) / 2))), endpoint=False) for a, b in pairwise(edges)
    ]
    return np.concatenate([*parts, edges[-1:]])


def band_weights(omega: FloatArray, climate: Climate) -> FloatArray:
    """Return int 2 h_j(w) dw over each band, h_j the broken line of 1 at one frequency, shape (band, omega) [rad/s].

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
        Frequencies of a port; beyond them there is nothing.
    """
    return _band_weights(*(np.asarray(values, dtype=float).tobytes() for values in (omega, climate.edges)))


@lru_cache(maxsize=16)
def _band_weights(frequencies: bytes, limits: bytes) -> FloatArray:
    """The same of values as they lie in memory: all designs and members over one climate share them."""
    omega, edges = np.frombuffer(frequencies), np.frombuffer(limits)
    cuts = np.unique(np.concatenate([omega, edges[(edges > omega[0]) & (edges < omega[-1])]]))
    middle, width = (cuts[1:] + cuts[:-1]) / 2, np.diff(cuts)
    left = np.searchsorted(omega, middle) - 1
    share = (middle - omega[left]) / (omega[left + 1] - omega[left])  # of the frequency to the right
    band = np.searchsorted(edges, middle) - 1
    inside = (band >= 0) & (band < len(edges) - 1)
    out = np.zeros((len(edges) - 1, len(omega)))
    np.add.at(out, (band[inside], left[inside]), (2 * width * (1 - share))[inside])
    np.add.at(out, (band[inside], left[inside] + 1), (2 * width * share)[inside])
    out.setflags(write=False)
    return out


P = TypeVar("P", Port, Ports)


@dataclass(frozen=True)
class OverClimate(Generic[P]):
    """What a design's take-off sees of it, over a climate."""

    port: P
    climate: Climate

    @cached_property
    def weights(self) -> FloatArray:
        """See `band_weights`."""
        return band_weights(self.port.omega, self.climate)

    @cached_property
    def squares(self) -> FloatArray:
        """Squared amplitudes of the year's mean spectrum at the frequencies of the port, shape (omega,) [m^2]."""
        return np.asarray(self.climate.mean_density @ self.weights)

    def coarser(self) -> Self:
        """Return the same with every other frequency of the port."""
        kept = np.unique(np.append(np.arange(0, len(self.port.omega), 2), len(self.port.omega) - 1))
        return replace(self, port=self.port.at(kept))


@dataclass(frozen=True)
class DesignYear(OverClimate[Port]):
    """One design over a climate, its power after conversion: of a damper, whose power goes one way, a part of it."""

    efficiency: float = 1.0

    def table(self, damping: FloatArray) -> FloatArray:
        """Return the mean power of every damper in every sea, shape (damper, sea) [W]."""
        return np.asarray((self.efficiency * self.port.power(damping) @ self.weights.T) @ self.climate.density.T)

    def annual(self, damping: FloatArray) -> FloatArray:
        """Return the mean power of every damper over the year, shape (damper,) [W]."""
        return np.asarray(self.efficiency * self.port.power(damping) @ self.squares)

    def absorbed(self, tuning: Tuning, damping: float | None) -> Load:
        """Return damper and absorbed power in each sea under a tuning, `fixed` and `one` with a damper [N s/m].

        Raises `ValueError` if they have none.
        """
        seas = len(self.climate.hours)
        if not self.port.moves:
            return Load(*np.zeros((3, seas)))
        if tuning == "each":
            tried = dampers(self.port)
            return best_of_table(tried, self.table(tried))
        if damping is None:
            raise ValueError(f"{tuning}: received no damper, needs one")
        return Load(np.full(seas, damping), np.zeros(seas), self.table(np.array([damping]))[0])


def gain_percent(power: FloatArray, reference: int) -> FloatArray | None:
    """Return gains of mean powers (design, tuning) over those of one of the designs [%].

    NaN under a tuning with which that design absorbs nothing; None if that is so under all of them.
    """
    base = np.where(power[reference] > 0, power[reference], np.nan)
    return None if np.isnan(base).all() else np.asarray(100 * (power / base - 1))


def gains_within(
    power: FloatArray,
    quadrature_error: FloatArray,
    by_coefficients: FloatArray,
    reference: int,
    left_out: FloatArray | None,
) -> Values:
    """Return gains of mean powers and their intervals by all known errors.

    Parameters
    ----------
    power, quadrature_error : ndarray, shape (design, tuning) [W]
    by_coefficients : ndarray, shape (design, tuning)
        What errors of the coefficients do to the ratio of powers, relative to it [-].
    reference : int
        The design gains are over.
    left_out : ndarray, shape (design, end) [percentage points], optional
        As of `vsb.results.left_out.LeftOut.gain`.
    """
    gain = gain_percent(power, reference)
    if gain is None:
        return {}
    quadrature = np.divide(quadrature_error, power, out=np.zeros_like(power), where=power > 0)
    width = (quadrature + quadrature[reference] + by_coefficients) * (100 + gain)
    width[reference] *= 0.0
    low, high = (np.zeros((len(power), 2)) if left_out is None else left_out).T[:, :, None]
    ends = {"gain_percent": gain, "gain_low": gain - width + low, "gain_high": gain + width + high}
    return {name: (("design", "tuning"), values) for name, values in ends.items()}


def powers_within(
    power: FloatArray, quadrature_error: FloatArray, by_coefficients: FloatArray, left_out: FloatArray | None
) -> Values:
    """Return the intervals of mean powers by all known errors.

    Parameters
    ----------
    power, quadrature_error : ndarray, shape (design, tuning) [W]
    by_coefficients : ndarray, shape (design, tuning)
        What errors of the coefficients do to the powers, relative to them [-].
    left_out : ndarray, shape (design, end), optional
        What shell modes left out do to them, likewise [-].
    """
    width = quadrature_error + by_coefficients * power
    low, high = (np.zeros((len(power), 2)) if left_out is None else left_out).T[:, :, None] * power
    ends = {POWER_ENDS[0]: power - width + low, POWER_ENDS[1]: power + width + high}
    return {name: (("design", "tuning"), values) for name, values in ends.items()}


def best_for_all(years: Sequence[DesignYear]) -> FloatArray:
    """Return the one damper that absorbs most over the year for each design, shape (design,) [N s/m]."""
    shared = all(np.array_equal(one.port.omega, years[0].port.omega) for one in years)
    together = [list(years)] if shared else [[one] for one in years]
    return np.concatenate([best_damper_of_each([one.port for one in some], some[0].squares) for some in together])


@dataclass(frozen=True)
class Year:
    """Power of every design in every sea of a site's year under every tuning."""

    climate: Climate
    water: Water
    designs: tuple[str, ...]
    tunings: tuple[str, ...]
    damping: FloatArray | None  # (design, tuning, sea) [N s/m]; None of damper matrices
    power: FloatArray  # (design, tuning, sea) [W]
    practice: FloatArray  # mean power of JONSWAP seas at the centres of the occupied bins (design, tuning) [W]
    quadrature_error: FloatArray  # of the mean power (design, tuning) [W]
    reference: str | None = None  # design that gains are over
    notes: tuple[str, ...] = ()
    efficiency: float = 1.0  # of the conversion that powers are after

    @cached_property
    def bins(self) -> Bins:
        """Bins of the seas."""
        return bins_of(self.climate)

    @cached_property
    def flux(self) -> FloatArray:
        """Energy flux of each sea, shape (sea,) [W/m]."""
        return self.climate.flux(self.water)

    @cached_property
    def annual_mean_power(self) -> FloatArray:
        """Mean over the year, every sea by itself, shape (design, tuning) [W]."""
        return np.asarray(self.power @ self.climate.hours)

    @property
    def annual_energy(self) -> FloatArray:
        """Energy of 8766 hours, shape (design, tuning) [MWh]."""
        return self.annual_mean_power * YEAR_HOURS / 1e6

    @property
    def capture_width(self) -> FloatArray:
        """Mean power over mean energy flux, shape (design, tuning) [m]."""
        return np.asarray(self.annual_mean_power / float(self.flux @ self.climate.hours))

    @property
    def dampers(self) -> FloatArray:
        """Dampers, shape (design, tuning, sea) [N s/m]."""
        assert self.damping is not None
        return self.damping

    @property
    def force_rms(self) -> FloatArray:
        """Root mean square of the take-off's force over the year, shape (design, tuning) [N]: sqrt(mean of c P)."""
        return np.sqrt((self.dampers * self.power / self.efficiency) @ self.climate.hours)

    @property
    def gain_percent(self) -> FloatArray | None:
        """Gain of the mean power over the reference under the same tuning, (design, tuning) [%]; see `gain_percent`."""
        return gain_percent(self.annual_mean_power, self.designs.index(self.reference)) if self.reference else None

    def matrices(self, values: FloatArray, of: str = "mean") -> FloatArray:
        """Return means (or `deviation`s) within bins of values by design, tuning and sea, (design, tuning, hs, te)."""
        matrix = self.bins.mean if of == "mean" else self.bins.deviation
        return np.array([[matrix(row) for row in rows] for rows in values])

    @property
    def values(self) -> dict[str, tuple[tuple[str, ...], FloatArray | IntArray]]:
        """All figures as dimensions and values: by design and tuning, and matrices by bins of Hs and Te."""
        by = ("design", "tuning")
        matrices = (*by, "hs", "te")
        width = self.power / self.flux
        gain, of_dampers = self.gain_percent, dict[str, tuple[tuple[str, ...], FloatArray]]()
        if self.damping is not None:
            of_dampers = {"force_rms": (by, self.force_rms), "damping": (matrices, self.matrices(self.damping))}
        return {
            "annual_mean_power": (by, self.annual_mean_power),
            "annual_energy": (by, self.annual_energy),
            "capture_width": (by, self.capture_width),
            "practice_power": (by, self.practice),
            "quadrature_error": (by, self.quadrature_error),
            "power_matrix": (matrices, self.matrices(self.power)),
            "capture_width_matrix": (matrices, self.matrices(width)),
            "power_deviation": (matrices, self.matrices(self.power, "deviation")),
            "capture_width_deviation": (matrices, self.matrices(width, "deviation")),
            "count": (("hs", "te"), self.bins.count),
            "occurrence": (("hs", "te"), self.bins.share),
            "flux_matrix": (("hs", "te"), self.bins.mean(self.flux)),
            **of_dampers,
            **({} if gain is None else {"gain_percent": (by, gain)}),
        }

    def dataset(self) -> xr.Dataset:
        """Return all figures with units; see `values`."""
        at = {"hs": self.bins.hs_centres, "te": self.bins.te_centres}
        names = {"design": list(self.designs), "tuning": list(self.tunings)}
        return described(xr.Dataset(self.values, coords=names | at, attrs={"notes": list(self.notes)}))


def year(
    ports: Mapping[str, Port],
    climate: Climate,
    water: Water,
    tunings: Sequence[Tuning] = TUNINGS,
    dampings: Mapping[str, float] | None = None,
    reference: str | None = None,
    efficiency: float = 1.0,
) -> Year:
    """Return a site's year of some designs.

    Raises `ConfigError` if `fixed` lacks a damper, or more than a hundredth of the waves lie beyond the frequencies of
    a port.

    Parameters
    ----------
    ports : mapping design -> Port
        Over any frequencies, those of `frequencies` for choice; a spring of the take-off built in (`Port.beside`).
    water : Water
        Of the energy flux.
    tunings : sequence of {'fixed', 'one', 'each'}
    dampings : mapping design -> float, optional
        Dampers of the tuning `fixed` [N s/m].
    reference : str, optional
        Design gains are over.
    efficiency : float
        Of conversion; below 1 beside no spring.
    """
    given = dict(dampings or {})
    if unknown := [tuning for tuning in tunings if tuning not in TUNINGS]:
        raise ConfigError(f"tuning: received {unknown[0]!r}, needs one of {', '.join(TUNINGS)}")
    if lacking := [design for design in ports if "fixed" in tunings and design not in given]:
        raise ConfigError(f"tuning: received fixed without a damping of {lacking[0]}, needs pto.damping")
    outside = variance_outside({design: port.omega for design, port in ports.items()}, climate)
    here = [DesignYear(port, climate, efficiency) for port in ports.values()]
    fine, coarse = (_absorbed(ports, years, tunings, given) for years in (here, [one.coarser() for one in here]))
    errors = [
        [abs(float((one.power - rough.power) @ climate.hours)) / 3 for one, rough in zip(*rows, strict=True)]
        for rows in zip(fine, coarse, strict=True)
    ]
    usual = []
    for port, tuned in zip(ports.values(), fine, strict=True):
        there = DesignYear(port, practice(climate, PRACTICE_GAMMA), efficiency)
        powers = []
        for tuning, one in zip(tunings, tuned, strict=True):  # the same damper, or the best in each sea
            absorbed = there.absorbed("each" if tuning == "each" else "fixed", float(one.damping[0])).power
            powers.append(float(absorbed @ there.climate.hours))
        usual.append(powers)
    damping, power = (
        np.array([[getattr(one, name) for one in tuned] for tuned in fine]) for name in ("damping", "power")
    )
    notes = (*climate.notes, outside)
    names, of_power = (tuple(ports), tuple(tunings)), (power, np.array(usual), np.array(errors))
    return Year(climate, water, *names, damping, *of_power, reference, notes, efficiency)


def _absorbed(
    designs: Iterable[str], years: Sequence[DesignYear], tunings: Sequence[Tuning], given: Mapping[str, float]
) -> list[list[Load]]:
    """Damper and power of each design under each tuning."""
    best = best_for_all(years) if "one" in tunings else np.zeros(len(years))
    found = []
    for design, one, damper in zip(designs, years, best, strict=True):
        dampers = {"fixed": given.get(design), "one": float(damper)}
        found.append([one.absorbed(tuning, dampers.get(tuning)) for tuning in tunings])
    return found


def variance_outside(omega: Mapping[str, FloatArray], climate: Climate) -> str:
    """Return in words how much of the variance of a climate lies beyond the frequencies of designs [rad/s].

    Raises `ConfigError` if it is more than a hundredth.
    """
    low, high = (f(float(one[k]) for one in omega.values()) for f, k in ((max, 0), (min, -1)))
    outside = climate.variance_outside(low, high)
    if outside > OUTSIDE:
        raise ConfigError(
            f"climate {climate.name}: received {outside:.2%} of its variance outside {low:.4g} to {high:.4g} rad/s, "
            f"the band of the hydrodynamics, needs at most {OUTSIDE:.0%}; raise hydro.omega_max"
        )
    return f"{outside:.3%} of the variance lies outside the frequencies solved and is not counted"


@lru_cache(maxsize=2)
def practice(climate: Climate, gamma: float) -> Climate:
    """Return JONSWAP seas at the centres of the occupied bins, as usual practice computes a year."""
    bins = bins_of(climate)
    share = bins.share.ravel()[bins.occupied]
    return climate_of_cells(*bins.centres, share, gamma, f"{climate.name}, JONSWAP at bin centres")
