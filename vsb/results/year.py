"""A site's year: what every design takes of every measured sea, under every tuning; matrices by IEC TS 62600-100.

Mean power of one sea is int 2 S(w) P(w; c) dw, P the power of a damper c per squared wave amplitude. A spectrum is
known as means over bands, so this is one product of the spectra with P integrated over each band. P goes on straight
lines between the frequencies of a port: the weights are positive, the order is two, and the error is a third of what
the answer changes by with every other frequency.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Literal

import numpy as np
import xarray as xr

from vsb.errors import ConfigError
from vsb.motion.port import Port
from vsb.motion.tuning import Take, best_damper_of_each, best_of_table, dampers
from vsb.results.bins import Bins, bins_of
from vsb.study.study import Water
from vsb.tools.arrays import FloatArray, IntArray
from vsb.tools.variables import described
from vsb.waves.climate import OUTSIDE, YEAR_HOURS, Climate
from vsb.waves.scatter import climate_of_cells

Tuning = Literal["fixed", "one", "each"]
TUNINGS: tuple[Tuning, ...] = ("fixed", "one", "each")
"""As given; one best damper for the year; the best in each sea."""
PART = 0.005
"""Distance of the frequencies of a port, as a part of them: every band of a climate is cut evenly into such parts."""
PRACTICE_GAMMA = 3.3
"""Peakedness of the JONSWAP seas at bin centres which usual practice puts in the place of spectra."""


def frequencies(climate: Climate, lowest: float, highest: float) -> FloatArray:
    """Return frequencies at which to take a port for a climate, ascending [rad/s].

    Parameters
    ----------
    climate : Climate
    lowest, highest : float [rad/s]
        The band the hydrodynamics are known in.
    """
    edges = np.unique(np.clip(climate.edges, lowest, highest))
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
    climate : Climate
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


@dataclass(frozen=True)
class DesignYear:
    """One design over a climate: its port, and the weights of the port's frequencies in each band."""

    port: Port
    climate: Climate

    @cached_property
    def weights(self) -> FloatArray:
        """See `band_weights`."""
        return band_weights(self.port.omega, self.climate)

    def table(self, damping: FloatArray) -> FloatArray:
        """Return the mean power of every damper in every sea, shape (damper, sea) [W]."""
        return np.asarray((self.port.power(damping) @ self.weights.T) @ self.climate.density.T)

    def annual(self, damping: FloatArray) -> FloatArray:
        """Return the mean power of every damper over the year, shape (damper,) [W]."""
        return np.asarray(self.port.power(damping) @ self.squares)

    @cached_property
    def squares(self) -> FloatArray:
        """Squared amplitudes of the year's mean spectrum at the frequencies of the port, shape (omega,) [m^2]."""
        return np.asarray(self.climate.mean_density @ self.weights)

    def take(self, tuning: Tuning, damping: float | None) -> Take:
        """Return what it takes under a tuning, `fixed` and `one` with a damper [N s/m].

        Raises
        ------
        ValueError
            If they have none.
        """
        seas = len(self.climate.hours)
        if not self.port.moves:
            return Take(np.zeros(seas), np.zeros(seas))
        if tuning == "each":
            tried = dampers(self.port)
            return best_of_table(tried, self.table(tried))
        if damping is None:
            raise ValueError(f"{tuning}: received no damper, needs one")
        return Take(np.full(seas, damping), self.table(np.array([damping]))[0])

    def coarser(self) -> "DesignYear":
        """Return the same with every other frequency of the port."""
        kept = np.unique(np.append(np.arange(0, len(self.port.omega), 2), len(self.port.omega) - 1))
        return DesignYear(self.port.at(kept), self.climate)


def gain_percent(power: FloatArray, reference: int) -> FloatArray | None:
    """Return gains of mean powers over those of one of the designs, (design, tuning) [%].

    Under a tuning with which that design takes nothing they are missing, NaN; under all of them there are none.
    """
    base = np.where(power[reference] > 0, power[reference], np.nan)
    return None if np.isnan(base).all() else np.asarray(100 * (power / base - 1))


def best_for_all(years: Sequence[DesignYear]) -> FloatArray:
    """Return the one damper that takes most over the year for each of some designs, shape (design,) [N s/m].

    Parameters
    ----------
    years : sequence of DesignYear
        Over one climate.
    """
    shared = all(np.array_equal(one.port.omega, years[0].port.omega) for one in years)
    together = [list(years)] if shared else [[one] for one in years]
    return np.concatenate([best_damper_of_each([one.port for one in some], some[0].squares) for some in together])


@dataclass(frozen=True)
class Year:
    """What every design takes of a site's year under every tuning."""

    climate: Climate
    water: Water
    designs: tuple[str, ...]
    tunings: tuple[str, ...]
    damping: FloatArray  # (design, tuning, sea) [N s/m]
    power: FloatArray  # (design, tuning, sea) [W]
    practice: FloatArray  # mean power of JONSWAP seas at the centres of the occupied bins (design, tuning) [W]
    quadrature_error: FloatArray  # of the mean power (design, tuning) [W]
    reference: str | None = None  # design gains are over
    notes: tuple[str, ...] = ()

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
    def force_rms(self) -> FloatArray:
        """Root mean square of the take-off's force over the year, sqrt(mean of c P), shape (design, tuning) [N]."""
        return np.sqrt((self.damping * self.power) @ self.climate.hours)

    @property
    def gain_percent(self) -> FloatArray | None:
        """Gain of the mean power over the reference under the same tuning, (design, tuning) [%]; none over nothing."""
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
        gain = self.gain_percent
        return {
            "annual_mean_power": (by, self.annual_mean_power),
            "annual_energy": (by, self.annual_energy),
            "capture_width": (by, self.capture_width),
            "force_rms": (by, self.force_rms),
            "practice_power": (by, self.practice),
            "quadrature_error": (by, self.quadrature_error),
            "damping": (matrices, self.matrices(self.damping)),
            "power_matrix": (matrices, self.matrices(self.power)),
            "capture_width_matrix": (matrices, self.matrices(width)),
            "power_deviation": (matrices, self.matrices(self.power, "deviation")),
            "capture_width_deviation": (matrices, self.matrices(width, "deviation")),
            "count": (("hs", "te"), self.bins.count),
            "occurrence": (("hs", "te"), self.bins.share),
            "flux_matrix": (("hs", "te"), self.bins.mean(self.flux)),
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
) -> Year:
    """Return a site's year of some designs.

    Parameters
    ----------
    ports : mapping design -> Port
        Over any frequencies, those of `frequencies` for choice; a spring of the take-off built in (`Port.beside`).
    climate : Climate
    water : Water
        Of the energy flux.
    tunings : sequence of {'fixed', 'one', 'each'}
    dampings : mapping design -> float, optional
        Dampers of the tuning `fixed` [N s/m].
    reference : str, optional
        Design gains are over.

    Raises
    ------
    ConfigError
        If `fixed` lacks a damper, or more than a hundredth of the waves lie beyond the frequencies of a port.
    """
    given = dict(dampings or {})
    _check_given(ports, tunings, given)
    outside = max(climate.variance_outside(port.omega[0], port.omega[-1]) for port in ports.values())
    if outside > OUTSIDE:
        low, high = (f(p.omega[k] for p in ports.values()) for f, k in ((max, 0), (min, -1)))
        raise ConfigError(
            f"climate {climate.name}: received {outside:.2%} of its variance outside {low:.4g} to {high:.4g} rad/s, "
            f"which hydrodynamics are known in, needs at most {OUTSIDE:.0%}; raise hydro.omega_max"
        )
    here = [DesignYear(port, climate) for port in ports.values()]
    rough, there = (
        [one.coarser() for one in here],
        [DesignYear(port, _practice(climate, PRACTICE_GAMMA)) for port in ports.values()],
    )
    fine, coarse = (_takes(ports, years, tunings, given) for years in (here, rough))
    errors = [[_error(climate, *both) for both in zip(*rows, strict=True)] for rows in zip(fine, coarse, strict=True)]
    practice = [
        [_of_practice(one, tuning, take) for tuning, take in zip(tunings, takes, strict=True)]
        for one, takes in zip(there, fine, strict=True)
    ]
    damping, power = (np.array([[take[k] for take in takes] for takes in fine]) for k in (0, 1))
    notes = (*climate.notes, f"{outside:.3%} of the variance lies outside the frequencies solved and is not counted")
    names = (tuple(ports), tuple(tunings))
    return Year(climate, water, *names, damping, power, np.array(practice), np.array(errors), reference, notes)


def _takes(
    designs: Iterable[str], years: Sequence[DesignYear], tunings: Sequence[Tuning], given: Mapping[str, float]
) -> list[list[Take]]:
    """What each design takes under each tuning."""
    best = best_for_all(years) if "one" in tunings else np.zeros(len(years))
    dampers = [{"fixed": given.get(design), "one": float(one)} for design, one in zip(designs, best, strict=True)]
    return [[one.take(t, damper.get(t)) for t in tunings] for one, damper in zip(years, dampers, strict=True)]


def _check_given(designs: Iterable[str], tunings: Sequence[str], given: Mapping[str, float]) -> None:
    """Check that tunings are known and `fixed` has its dampers."""
    if unknown := [tuning for tuning in tunings if tuning not in TUNINGS]:
        raise ConfigError(f"tuning: received {unknown[0]!r}, needs one of {', '.join(TUNINGS)}")
    if lacking := [design for design in designs if "fixed" in tunings and design not in given]:
        raise ConfigError(f"tuning: received fixed without a damping of {lacking[0]}, needs pto.damping")


@lru_cache(maxsize=2)
def _practice(climate: Climate, gamma: float) -> Climate:
    """JONSWAP seas at the centres of the occupied bins."""
    bins = bins_of(climate)
    share = bins.share.ravel()[bins.occupied]
    return climate_of_cells(*bins.centres, share, gamma, f"{climate.name}, JONSWAP at bin centres")


def _of_practice(there: DesignYear, tuning: Tuning, take: Take) -> float:
    """Mean power of a year of seas at bin centres under the tuning: the same damper, or each its own best one."""
    at = there.take("each" if tuning == "each" else "fixed", float(take.damping[0]))
    return float(at.power @ there.climate.hours)


def _error(climate: Climate, take: Take, rough: Take) -> float:
    """Error of the mean power by the quadrature: a third of what twice the step changes."""
    return abs(float((take.power - rough.power) @ climate.hours)) / 3
