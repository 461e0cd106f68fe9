"""A site's year: power of every design in every measured sea under every tuning, bins of Hs and Te, limits of theory.

Mean power of one sea is int 2 S(w) P(w; c) dw, P the power of a damper c per squared wave amplitude. A spectrum is
known as means over bands, so this is one product of the spectra with P integrated over each band. P is interpolated
linearly between the frequencies of a port: the weights are positive, the order is two, and the error is a third of what
the answer changes by with every other frequency. Matrices over bins follow IEC TS 62600-100.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Self

import numpy as np
import xarray as xr

from vsb.engine.motion.coefficient_errors import CoefficientError, Sensitivity
from vsb.engine.motion.port import Port, Ports
from vsb.engine.motion.tuning import Kind, best_damper_of_each, best_matrix, best_of_table, dampers
from vsb.engine.waves.climate import OUTSIDE, YEAR_HOURS, Climate
from vsb.engine.waves.scatter import climate_of_cells
from vsb.engine.waves.water import Water, wavenumber
from vsb.errors import ConfigError
from vsb.tools.arrays import AnyArray, BoolArray, ComplexArray, FloatArray, IntArray
from vsb.tools.variables import described

if TYPE_CHECKING:  # they import what is compiled
    from vsb.models.floating_system import InWaves
    from vsb.results.budget import LeftOut

Tuning = Literal["fixed", "one", "each"]
TUNINGS: tuple[Tuning, ...] = ("fixed", "one", "each")
"""Given damper; one best damper for the year; the best in each sea."""
Slopes = Sequence[Sequence[Sequence[Sensitivity]]]
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


class Absorbed(NamedTuple):
    """Dampers, which of them every sea has, and the mean power it absorbs with it."""

    dampers: FloatArray  # (damper,) [N s/m]; of damper matrices (damper, port, port)
    chosen: IntArray  # (sea,)
    power: FloatArray  # (sea,) [W]

    @property
    def of_seas(self) -> FloatArray:
        """The damper of every sea, shape (sea,) [N s/m], or (sea, port, port)."""
        return self.dampers[self.chosen]

    def mean_damper(self, hours: FloatArray) -> FloatArray:
        """Return the mean damper of the year, shape () or (port, port)."""
        share = np.bincount(self.chosen, hours, minlength=len(self.dampers))
        return np.asarray(np.tensordot(share, self.dampers, axes=1))


@dataclass(frozen=True)
class DesignYear:
    """One design over a climate, its power after conversion: of a damper, whose power goes one way, a part of it."""

    port: Any  # Port; of a `MatrixYear` Ports
    climate: Climate
    efficiency: float = 1.0

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

    def table(self, dampers: FloatArray) -> FloatArray:
        """Return the mean power of every damper in every sea, shape (damper, sea) [W]."""
        return np.asarray((self.efficiency * self.port.power(dampers) @ self.weights.T) @ self.climate.density.T)

    def annual(self, dampers: FloatArray) -> FloatArray:
        """Return the mean power of every damper over the year, shape (damper,) [W]."""
        return np.asarray(self.efficiency * self.port.power(dampers) @ self.squares)

    @staticmethod
    def best_for_year(years: Sequence[Any]) -> FloatArray:
        """Return the one damper that absorbs most over the year for each design, shape (design,) [N s/m]."""
        shared = all(np.array_equal(one.port.omega, years[0].port.omega) for one in years)
        together = [list(years)] if shared else [[one] for one in years]
        return np.concatenate([best_damper_of_each([one.port for one in some], some[0].squares) for some in together])

    def with_dampers(self, dampers: FloatArray) -> Absorbed:
        """Return for every sea the best of some dampers, shape (damper,) [N s/m], or (damper, port, port)."""
        table = self.table(dampers)
        chosen = table.argmax(axis=0)
        return Absorbed(dampers, chosen, table[chosen, np.arange(len(chosen))])

    def absorbed(self, tuning: Tuning, damper: FloatArray | float | None) -> Absorbed:
        """Return damper and absorbed power in each sea under a tuning, `fixed` and `one` with a damper [N s/m].

        Raises `ValueError` if they have none.
        """
        if not self.port.moves:
            return self.with_dampers(np.zeros(1))
        if tuning == "each":
            tried = dampers(self.port)
            best = best_of_table(tried, self.table(tried))
            return Absorbed(best.damping, np.arange(len(best.damping)), best.power)
        if damper is None:
            raise ValueError(f"{tuning}: received no damper, needs one")
        return self.with_dampers(np.array([damper]))

    def again(self, tuning: str, found: Absorbed) -> Absorbed:
        """Return the same take-off in other seas: with its damper, or the best one in each of them."""
        return self.absorbed("each" if tuning == "each" else "fixed", found.dampers[0])

    retunes = True
    """Whether the error of quadrature is of a damper that is tuned again with other frequencies."""


@dataclass(frozen=True)
class MatrixYear(DesignYear):
    """One design at several ports over a climate, under damper matrices."""

    kind: Kind = "full"

    @cached_property
    def best(self) -> FloatArray:
        """The matrix that absorbs most over the year, shape (port, port)."""
        return best_matrix(self.port, self.squares, self.kind).damping

    @cached_property
    def tried(self) -> FloatArray:
        """The best of the year, and of the mean spectrum of every bin of energy period, shape (matrix, port, port)."""
        _, column = np.unravel_index(bins_of(self.climate).index, bins_of(self.climate).shape)
        energy = [self.climate.hours * (column == one) @ self.climate.density for one in np.unique(column)]
        return np.array([self.best, *(best_matrix(self.port, one @ self.weights, self.kind).damping for one in energy)])

    @staticmethod
    def best_for_year(years: Sequence[Any]) -> FloatArray:
        """Return the matrix that absorbs most over the year for each design, shape (design, port, port)."""
        return np.array([one.best for one in years])

    def absorbed(self, tuning: Tuning, damper: FloatArray | float | None) -> Absorbed:
        """Return matrices and power of each sea under a tuning; `fixed` and `one` with a matrix."""
        if tuning == "each":
            return self.with_dampers(self.tried)
        assert damper is not None  # a campaign's own check
        return self.with_dampers(np.asarray(damper)[None])

    def again(self, tuning: str, found: Absorbed) -> Absorbed:
        """Return the best of the same matrices in other seas."""
        return self.with_dampers(found.dampers)

    retunes = False


def gain_percent(power: FloatArray, reference: int) -> FloatArray | None:
    """Return gains of mean powers (design, tuning) over those of one of the designs [%].

    NaN under a tuning with which that design absorbs nothing; None if that is so under all of them.
    """
    base = np.where(power[reference] > 0, power[reference], np.nan)
    return None if np.isnan(base).all() else np.asarray(100 * (power / base - 1))


def within_errors(
    power: FloatArray,
    quadrature_error: FloatArray,
    slopes: Slopes,
    errors: Sequence[CoefficientError],
    reference: int | None,
    left_out: "LeftOut | None",
) -> dict[str, tuple[tuple[str, ...], AnyArray]]:
    """Return the intervals of mean powers by all known errors, gains over a reference design and theirs.

    Of errors of the coefficients the larger of what they do at either take-off the derivatives are taken at.

    Parameters
    ----------
    power, quadrature_error : ndarray, shape (design, tuning) [W]
    slopes : sequence
        Derivatives of the logarithms of the powers, by take-off, tuning (or one for all of them) and design.
    errors : sequence of CoefficientError
    reference : int, optional
        The design gains are over.
    left_out : LeftOut, optional
        Errors by shell modes left out, shape (design, end).
    """
    of_power, of_ratio = np.zeros((2, *power.shape))
    for at in slopes:
        each = [[sum(slope.to(one) for one in errors) for slope in some] for some in at]
        of_power = np.maximum(of_power, np.array(each).T)
        if reference is not None:
            over = [
                [0.0 if i == reference else sum((slope - some[reference]).to(one) for one in errors)
                 for i, slope in enumerate(some)]
                for some in at
            ]  # fmt: skip
            of_ratio = np.maximum(of_ratio, np.array(over).T)
    none, width = np.zeros((len(power), 2)), quadrature_error + of_power * power
    low, high = (none if left_out is None else left_out.power).T[:, :, None] * power
    ends = {POWER_ENDS[0]: power - width + low, POWER_ENDS[1]: power + width + high}
    gain = None if reference is None else gain_percent(power, reference)
    if gain is not None:
        quadrature = np.divide(quadrature_error, power, out=np.zeros_like(power), where=power > 0)
        width = (quadrature + quadrature[reference] + of_ratio) * (100 + gain)
        width[reference] *= 0.0
        low, high = (none if left_out is None else left_out.gain).T[:, :, None]
        ends |= {"gain_percent": gain, "gain_low": gain - width + low, "gain_high": gain + width + high}
    return {name: (("design", "tuning"), values) for name, values in ends.items()}


@dataclass(frozen=True)
class Year:
    """Power of every design in every sea of a site's year under every tuning."""

    climate: Climate
    water: Water
    designs: tuple[str, ...]
    tunings: tuple[str, ...]
    absorbed: Mapping[tuple[str, str], Absorbed]  # by design and tuning; empty of controllers
    power: FloatArray  # (design, tuning, sea) [W]
    practice: FloatArray  # mean power of JONSWAP seas at the centres of the occupied bins (design, tuning) [W]
    quadrature_error: FloatArray  # of the mean power (design, tuning) [W]
    reference: str | None = None  # design that gains are over
    notes: tuple[str, ...] = ()
    efficiency: float = 1.0  # of the conversion that powers are after
    spring_force: FloatArray | float = 0.0  # mean square of the spring's beside a damper (design, tuning) [N^2]

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

    @cached_property
    def damping(self) -> FloatArray | None:
        """Dampers, shape (design, tuning, sea) [N s/m]; None of damper matrices and controllers."""
        found = [[self.absorbed.get((one, tuning)) for tuning in self.tunings] for one in self.designs]
        dampers = np.array([[one.of_seas for one in row if one and one.dampers.ndim == 1] for row in found])
        return dampers if dampers.size else None

    @property
    def force_rms(self) -> FloatArray:
        """Root mean square of the take-off's force over the year, shape (design, tuning) [N].

        The mean of c P, P the power, and of (k x)^2 of a spring, whose force is a quarter of a period behind.
        """
        assert self.damping is not None
        return np.sqrt((self.damping * self.power / self.efficiency) @ self.climate.hours + self.spring_force)

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
    ports: Mapping[str, Port | Ports],
    climate: Climate,
    water: Water,
    tunings: Sequence[Tuning] = TUNINGS,
    dampings: Mapping[str, Any] | None = None,
    reference: str | None = None,
    efficiency: float = 1.0,
    kind: Kind = "full",
    stiffness: float = 0.0,
) -> Year:
    """Return a site's year of some designs.

    Raises `ConfigError` if `fixed` lacks a damper, or more than a hundredth of the waves lie beyond the frequencies of
    a port.

    Parameters
    ----------
    ports : mapping design -> Port or Ports
        Over any frequencies, those of `frequencies` for choice; a spring of the take-off built in (`Port.beside`).
    water : Water
        Of the energy flux.
    tunings : sequence of {'fixed', 'one', 'each'}
    dampings : mapping design -> float or ndarray, shape (port, port), optional
        Dampers, or damper matrices of several ports, of the tuning `fixed` [N s/m].
    reference : str, optional
        Design gains are over.
    efficiency : float
        Of conversion; below 1 beside no spring.
    kind : {'full', 'diagonal', 'uniform'}
        Of damper matrices.
    stiffness : float [N/m]
        Of the spring built in, whose force is part of the take-off's.
    """
    given = dict(dampings or {})
    if unknown := [tuning for tuning in tunings if tuning not in TUNINGS]:
        raise ConfigError(f"tuning: received {unknown[0]!r}, needs one of {', '.join(TUNINGS)}")
    if lacking := [design for design in ports if "fixed" in tunings and given.get(design) is None]:
        raise ConfigError(f"tuning: received fixed without a damping of {lacking[0]}, needs pto.damping")
    outside = variance_outside({design: port.omega for design, port in ports.items()}, climate)
    here = {design: design_year(port, climate, efficiency, kind) for design, port in ports.items()}
    fine = _absorbed(here, tunings, given)
    rough = {design: one.coarser() for design, one in here.items()}
    there = {design: replace(one, climate=practice(climate, PRACTICE_GAMMA)) for design, one in here.items()}
    usual = {(design, tuning): there[design].again(tuning, one) for (design, tuning), one in fine.items()}
    if all(one.retunes for one in here.values()):
        coarse = _absorbed(rough, tunings, given)
    else:
        coarse = {(design, tuning): rough[design].again(tuning, one) for (design, tuning), one in fine.items()}

    def each(found: Mapping[tuple[str, str], Absorbed]) -> FloatArray:
        return np.array([[found[design, tuning].power for tuning in tunings] for design in ports])

    power, hours = each(fine), practice(climate, PRACTICE_GAMMA).hours
    errors = np.abs((power - each(coarse)) @ climate.hours) / 3
    notes, names = (*climate.notes, outside), (tuple(ports), tuple(tunings))
    spring: FloatArray | float = 0.0
    if stiffness:
        spring = np.array([[_spring_force(here[d], fine[d, tuning], stiffness) for tuning in tunings] for d in ports])
    return Year(climate, water, *names, fine, power, each(usual) @ hours, errors, reference, notes, efficiency, spring)


def design_year(port: Port | Ports, climate: Climate, efficiency: float = 1.0, kind: Kind = "full") -> DesignYear:
    """Return one design over a climate, under dampers or, at several ports, damper matrices of a kind."""
    if isinstance(port, Ports):
        return MatrixYear(port, climate, efficiency, kind)
    return DesignYear(port, climate, efficiency)


def _absorbed(
    years: Mapping[str, DesignYear], tunings: Sequence[Tuning], given: Mapping[str, Any]
) -> dict[tuple[str, str], Absorbed]:
    """Dampers and power of each design under each tuning."""
    own = list(years.values())
    best = dict(zip(years, own[0].best_for_year(own), strict=True)) if "one" in tunings else {}
    return {
        (design, tuning): one.absorbed(tuning, best[design] if tuning == "one" else given.get(design))
        for design, one in years.items()
        for tuning in tunings
    }


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


# beyond the validity of linear waves and small motions ----------------------------------------------------------------

STEEPEST = 0.05
"""Hs over the length of the energy period, as the ledger of a study has it [-]."""
HIGHEST_WAVE = 1.86
"""Highest of a thousand waves over Hs, sqrt(ln 1000/2) of Rayleigh's distribution [-]."""
HIGHEST_VALUE = 3.72
"""Highest of a thousand maxima over the standard deviation, sqrt(2 ln 1000) [-]."""
MICHE = 0.142
"""Height over length at which waves break in deep water, times tanh(k d) in any [-]."""
MOTION = 0.3
"""Heave over radius beyond which linear hydrodynamics are in doubt [-]."""
DEFORMATION = 0.1
"""Displacement of the shell over radius beyond which small deformations are [-]."""
LIMITS = ("steepness", "breaking", "deformation", "heave")
MARKED = LIMITS[:3]
"""Limits that mark a sea; heave does not: in long waves a buoy follows the water, however far."""
OF_WAVES = 2
"""Limits, the first ones, of the waves alone: of a body no others are known."""
NODES = 8
"""Dampers at which variances are computed, to interpolate between them to 1e-3."""

Marks = dict[str, tuple[tuple[str, ...], FloatArray]]
"""Dimensions and values by name."""


class Beyond(NamedTuple):
    """Seas beyond one limit."""

    name: str
    largest: float  # over the seas of the climate [-]
    limit: float
    seas: BoolArray  # (sea,)

    def energy(self, power: FloatArray, hours: FloatArray) -> float:
        """Return the part of a year's energy from those seas; power and hours of each sea, shape (sea,)."""
        total = float(power @ hours)
        return float((power * hours)[self.seas].sum()) / total if total > 0 else 0.0


def limits_of(radius: float | None) -> tuple[str, ...]:
    """Return the limits known of a buoy of a radius [m], or of a body."""
    return LIMITS if radius is not None else LIMITS[:OF_WAVES]


@lru_cache(maxsize=4)
def wave_limits(climate: Climate, water: Water) -> list[Beyond]:
    """Return the seas too steep for linear waves, and those whose highest of a thousand waves breaks (Miche)."""
    numbers = np.array([wavenumber(2 * np.pi / te, water.depth, water.gravity) for te in climate.te])
    steepness = climate.hs * numbers / (2 * np.pi)
    breaking = HIGHEST_WAVE * steepness / MICHE
    if np.isfinite(water.depth):
        breaking = breaking / np.tanh(numbers * water.depth)
    return [_beyond("steepness", steepness, STEEPEST), _beyond("breaking", breaking, 1.0)]


def motion_limits(motions: Mapping[str, FloatArray], radius: float) -> list[Beyond]:
    """Return the seas in which the highest of a thousand maxima exceeds its limit.

    Parameters
    ----------
    motions : mapping 'heave' or 'deformation' -> ndarray, shape (sea,) [m]
        Root mean squares, see `rms`.
    radius : float [m]
    """
    limits = {"heave": MOTION, "deformation": DEFORMATION}
    return [_beyond(name, HIGHEST_VALUE * value / radius, limits[name]) for name, value in motions.items()]


def _beyond(name: str, values: FloatArray, limit: float) -> Beyond:
    """Seas beyond a limit."""
    return Beyond(name, float(values.max()), limit, values > limit)


def motion_rms(
    waves: "InWaves[Any]", climate: Climate, dampers: FloatArray, chosen: IntArray, stiffness: float
) -> dict[str, FloatArray]:
    """Return the root mean squares of heave and deformation in each sea, shape (sea,) [m].

    Parameters
    ----------
    dampers : ndarray, shape (damper,) [N s/m] or (damper, port, port)
    chosen : ndarray, shape (sea,)
        The damper of each sea.
    stiffness : float [N/m]
        Of the take-off's spring.

    Notes
    -----
    Variances are smooth in the logarithm of one damper, see `vsb.engine.motion.tuning`: a polynomial through few.
    """
    nodes, shares = _nodes(dampers, chosen)
    heave, shell = waves.motion.under(waves.port.force(nodes, stiffness))
    squares = np.concatenate([_square(heave)[:, None], _square(shell).sum(axis=1)], axis=1)
    squares = squares[:, [0, *(1 + np.flatnonzero(squares[:, 1:].any(axis=(0, 2))))]]  # points that move at all
    bands = (squares / 2) @ band_weights(waves.port.omega, climate).T
    if len(nodes) == 1:
        bands = np.concatenate([bands[:, :1], _undominated(bands[0, 1:])[None]], axis=1)
    each = bands @ climate.density.T  # (damper, row, sea)
    variance = np.maximum(np.einsum("nrs,ns->rs", each, shares), 0.0)
    return {"heave": np.sqrt(variance[0]), "deformation": np.sqrt(variance[1:].max(axis=0, initial=0.0))}


def spring_squares(port: Port, dampers: FloatArray, stiffness: float) -> FloatArray:
    """Return the mean square k^2 |V|^2/(2 w^2) of the force of a spring beside dampers, per squared amplitude.

    Parameters
    ----------
    port : Port
        Beside this spring.
    dampers : ndarray, shape (damper,) [N s/m]
    stiffness : float [N/m]

    Returns
    -------
    ndarray, shape (damper, omega) [N^2/m^2]
    """
    return np.asarray(0.5 * stiffness**2 * _square(port.velocity_under(port.load(dampers))) / port.omega**2)


def _spring_force(one: DesignYear, absorbed: Absorbed, stiffness: float) -> float:
    """Mean square of the force of a spring over the year [N^2]."""
    nodes, shares = _nodes(absorbed.dampers, absorbed.chosen)
    each = spring_squares(one.port, nodes, stiffness) @ one.weights.T @ one.climate.density.T  # (node, sea)
    return max(0.0, float((each * shares).sum(axis=0) @ one.climate.hours))


def _undominated(rows: FloatArray) -> FloatArray:
    """The rows no other exceeds in every band, (row, band): in any sea the largest is one of them."""
    below = (rows[:, None] <= rows).all(axis=2)
    twins = below & below.T
    return rows[~((below & ~twins) | np.tril(twins, -1)).any(axis=1)]


def _square(phasor: ComplexArray) -> FloatArray:
    """Squared size."""
    return np.asarray(phasor.real**2 + phasor.imag**2)


def _nodes(dampers: FloatArray, chosen: IntArray) -> tuple[FloatArray, FloatArray]:
    """Dampers at which variances are computed, and the share of each in every sea, shape (node, sea).

    Of one port Chebyshev's nodes between the least and the largest damper, of matrices those that are chosen.
    """
    if dampers.ndim > 1:
        used, place = np.unique(chosen, return_inverse=True)
        return dampers[used], np.eye(len(used))[:, place]
    damping = dampers[chosen]
    low, high = float(damping.min()), float(damping.max())
    if low <= 0 or high - low <= 1e-9 * high:
        return np.array([high]), np.ones((1, len(damping)))
    nodes = np.cos((np.arange(NODES) + 0.5) * np.pi / NODES)
    middle, half = np.log(high * low) / 2, np.log(high / low) / 2
    x = (np.log(damping) - middle) / half
    others = [np.delete(nodes, k)[:, None] for k in range(NODES)]
    shares = [np.prod((x - other) / (node - other), axis=0) for node, other in zip(nodes, others, strict=True)]
    return np.exp(middle + half * nodes), np.array(shares)


def beyond_validity(year: Year, motions: Callable[[str, str], Mapping[str, FloatArray]], radius: float | None) -> Marks:
    """Return which part of the seas of each bin lies beyond validity, and their shares of the energy.

    Parameters
    ----------
    motions : callable
        Design, tuning -> root mean squares of its motions in each sea, as of `motion_rms`.
    radius : float or None [m]
        Of a buoy; of a body only the waves are judged.
    """
    of_waves, hours = wave_limits(year.climate, year.water), year.climate.hours
    sizes, known = (len(year.designs), len(year.tunings)), limits_of(radius)
    marked, energy = np.zeros((*sizes, *year.bins.shape)), np.zeros((*sizes, len(known)))
    together = np.zeros(sizes)
    for i, design in enumerate(year.designs):
        for j, tuning in enumerate(year.tunings):
            limits = list(of_waves)
            if radius is not None:
                limits += motion_limits(motions(design, tuning), radius)
            limits.sort(key=lambda one: known.index(one.name))
            power, beyond = year.power[i, j], np.any([one.seas for one in limits if one.name in MARKED], axis=0)
            marked[i, j] = year.bins.mean(beyond.astype(float))
            energy[i, j] = [one.energy(power, hours) for one in limits]
            together[i, j] = Beyond("marked", 0.0, 0.0, beyond).energy(power, hours)
    by = ("design", "tuning")
    return {
        "beyond_validity": ((*by, "hs", "te"), marked),
        "energy_beyond": ((*by, "limit"), energy),
        "energy_beyond_validity": (by, together),
    }


def year_of_bins(
    climate: Climate,
    water: Water,
    power: FloatArray,
    mean: float,
    error: float,
    moved: Mapping[str, FloatArray],
    radius: float | None,
) -> dict[str, float | FloatArray]:
    """Return the year of one design whose power and motion are known of the mean spectrum of each bin, by name.

    A limit that its motion exceeds there marks all seas of the bin.

    Parameters
    ----------
    power : ndarray, shape (hs, te) [W]
    mean, error : float [W]
        Mean power over the year, and its numerical error.
    moved : mapping 'heave' or 'deformation' -> ndarray, shape (hs, te) [m]
        Root mean squares.
    """
    bins, flux = bins_of(climate), climate.flux(water)
    none, of_bins = np.zeros(bins.shape), bins.mean(flux)
    shares = {limit.name: bins.mean(limit.seas.astype(float)) for limit in wave_limits(climate, water)}
    steep = bins.mean(np.any([limit.seas for limit in wave_limits(climate, water)], axis=0).astype(float))
    marked = steep
    if radius is not None:
        for limit in motion_limits({name: values.ravel() for name, values in moved.items()}, radius):
            shares[limit.name] = limit.seas.reshape(bins.shape).astype(float)
        marked = np.where(shares["deformation"] > 0, 1.0, steep)
    energy = bins.share * power
    total = max(float(energy.sum()), np.finfo(float).tiny)
    return {
        "annual_mean_power": mean,
        "annual_energy": mean * YEAR_HOURS / 1e6,
        "capture_width": mean / float(flux @ climate.hours),
        "quadrature_error": error,
        "power_matrix": power,
        "capture_width_matrix": np.divide(power, of_bins, out=none.copy(), where=of_bins > 0),
        **dict.fromkeys(("power_deviation", "capture_width_deviation"), none),
        "beyond_validity": marked,
        "energy_beyond": np.array([float((energy * shares[name]).sum()) / total for name in limits_of(radius)]),
        "energy_beyond_validity": float((energy * marked).sum()) / total,
    }
