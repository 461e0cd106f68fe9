"""A site's year within limits of force and stroke: the optimum of the mean spectrum of each occupied bin.

Bins are taken in the order of the energy flux they bring, as many as a budget of time allows; how many that is follows
from the size of the programmes and no clock, so that an answer does not depend on how busy a machine is. The rest of
the year is bracketed: nothing, and what the best force of all would take.

A bin is two realisations of its mean spectrum, phases drawn apart and the same for all designs: what they differ by
says how well few waves know the mean, and how well they know the gain of one design over another.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vsb.errors import ConfigError, StabilityError
from vsb.motion.constrained import ConstrainedOptimum, NoForceFoundError, constrained_optimum
from vsb.motion.force_bound import Harmonics, Limits
from vsb.motion.port import Port
from vsb.results.bins import Bins, bins_of
from vsb.results.verification import half_width
from vsb.study.study import Water
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from vsb.waves.climate import OUTSIDE, Climate

SECONDS_PER_CUBE = 4e-9
"""Time of one optimum over the third power of its harmonics, on one core of a usual machine [s]."""
SECONDS_AT_LEAST = 5e-3
"""Time of the smallest one [s]."""
REALISATIONS = 2
"""Realisations of each bin."""
SHORTEST, LONGEST = 4.0, 32.0
"""Periods a sea may be taken to repeat in, over the mean energy period of the year [-]."""


class Bracket(NamedTuple):
    """A value and what it lies between."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class ConstrainedYear:
    """Optima within limits of the bins that were reached."""

    bins: Bins
    solved: IntArray  # bins, by the energy flux they bring (bin,)
    amplitude: ComplexArray  # of the waves (bin, realisation, harmonic) [m]
    optima: tuple[tuple[ConstrainedOptimum | None, ...], ...]  # (bin, realisation); none: no force keeps the stroke
    matched: FloatArray  # mean power of the best force of all, of every bin (hs, te) [W]
    flux_share: float  # of the year's energy flux in the bins solved [-]
    undecided: FloatArray | float = 0.0  # bounds where no force was found, but none is ruled out (bin, realisation) [W]

    def _each(self, field: str) -> FloatArray:
        """A field of the optima, 0 where there is none, shape (bin, realisation)."""
        return np.array([[getattr(one, field) if one else 0.0 for one in pair] for pair in self.optima])

    @cached_property
    def share(self) -> FloatArray:
        """Share of the year of the solved bins, shape (bin,) [-]."""
        return np.asarray(self.bins.share.ravel()[self.solved])

    def matrix(self, values: FloatArray) -> FloatArray:
        """Return values of the solved bins, shape (bin,), in their places, 0 elsewhere, shape (hs, te)."""
        out = np.zeros(self.bins.shape)
        out.ravel()[self.solved] = values
        return out

    @property
    def power_matrix(self) -> FloatArray:
        """Mean power of the solved bins, 0 elsewhere, shape (hs, te) [W]."""
        return self.matrix(self._each("power").mean(axis=1))

    @property
    def reached(self) -> BoolArray:
        """Whether a bin was solved, shape (hs, te)."""
        out = np.zeros(self.bins.shape, dtype=bool)
        out.ravel()[self.solved] = True
        return out

    @property
    def impossible(self) -> float:
        """Share of the year in which no force was found that keeps the stroke within its limit [-]."""
        none = np.array([[one is None for one in pair] for pair in self.optima])
        return float(self.share @ none.mean(axis=1))

    @property
    def taken(self) -> float:
        """Mean power of the year, nothing in the bins not reached [W]."""
        return float(self.share @ self._each("power").mean(axis=1))

    @property
    def bound(self) -> float:
        """What no force within the limits exceeds in these waves, nor any force in the bins not reached [W]."""
        left = float(np.sum((self.bins.share * self.matched)[~self.reached]))
        return float(self.share @ (self._each("bound") + self.undecided).mean(axis=1)) + left

    @property
    def _whole(self) -> float:
        """The year over what is solved of it: bins not reached take the same part of the matched power."""
        could, left = (float(np.sum((self.bins.share * self.matched)[at])) for at in (self.reached, ~self.reached))
        return 1 + left / could if could else 1.0

    @property
    def annual_mean_power(self) -> Bracket:
        """Mean power of the year, its bracket widened by what the realisations leave open [W]."""
        half = half_width(self._draws)
        return Bracket(self.taken * self._whole, max(0.0, self.taken - half), self.bound + half)

    @property
    def _draws(self) -> FloatArray:
        """Draws whose mean is the power taken, two of each bin one after the other [W]."""
        return np.asarray((len(self.share) * self.share[:, None] * self._each("power")).ravel())

    def gain(self, over: "ConstrainedYear") -> Bracket | None:
        """Return the gain over another design in the same waves [%]; none over nothing.

        Its interval is that of differences within pairs of realisations, widened by what is not proved.
        """
        base = over.annual_mean_power.mean
        if not base > 0:
            return None
        ratio = self.annual_mean_power.mean / base
        half = half_width((self._draws - ratio * over._draws) / over.taken)
        least, most = self.taken / over.bound - half, self.bound / over.taken + half
        return Bracket(100 * (ratio - 1), 100 * (least - 1), 100 * (most - 1))

    @property
    def force_rms(self) -> float:
        """Root mean square of the force over the bins solved [N]."""
        squares = (self._each("force_rms") ** 2).mean(axis=1)
        return float(np.sqrt(self.share @ squares / self.share.sum()))

    @property
    def excess(self) -> float:
        """Largest part by which a limit is exceeded between the instants of collocation [-]."""
        return float(self._each("excess").max())


def affordable(harmonics: Harmonics, seconds: float) -> int:
    """Return how many bins a budget of time allows, at least one."""
    return max(1, int(seconds / (SECONDS_AT_LEAST + SECONDS_PER_CUBE * harmonics.count**3) / REALISATIONS))


def harmonics_of_year(climate: Climate, lowest: float, highest: float, seconds: float) -> Harmonics:
    """Return harmonics so near each other that a budget of time allows the optima of all bins of a year.

    Parameters
    ----------
    climate : Climate
    lowest, highest : float [rad/s]
        The band the force may be of.
    seconds : float
        Budget of time [s].
    """
    bins = bins_of(climate)
    each = seconds / (REALISATIONS * len(bins.occupied)) - SECONDS_AT_LEAST
    apart = np.cbrt(max(each, 0.0) / SECONDS_PER_CUBE) - 1  # of one harmonic more
    te = float(climate.te @ climate.hours)
    period = np.clip(2 * np.pi * apart / (highest - lowest), SHORTEST * te, LONGEST * te)
    spacing = float(2 * np.pi / period)
    first = max(1, int(np.ceil(lowest / spacing - 1e-9)))
    return Harmonics(spacing, float(first), int(highest / spacing + 1e-9) - first + 1)


def constrained_year(
    port: Port,
    climate: Climate,
    water: Water,
    harmonics: Harmonics,
    limits: Limits,
    seconds: float = 10.0,
    seed: int = 0,
) -> ConstrainedYear:
    """Return the year of one design within limits.

    Parameters
    ----------
    port : Port
        At `harmonics.port_omega`.
    climate : Climate
    water : Water
        Of the energy flux.
    harmonics : Harmonics
        Of the period every sea is taken to repeat in.
    limits : Limits
    seconds : float
        Budget of time [s].
    seed : int
        Of the phases, of each bin its own.

    Raises
    ------
    ConfigError
        If the port is known elsewhere, or harmonics leave out more than a hundredth of the variance.
    """
    needed = harmonics.port_omega
    if len(port.omega) != len(needed) or not np.allclose(port.omega, needed, rtol=1e-9):
        raise ConfigError(
            f"constrained: received a port at {len(port.omega)} frequencies up to {port.omega[-1]:.4g} rad/s, needs "
            f"the {harmonics.count} harmonics up to {harmonics.omega[-1]:.4g} rad/s and those outside"
        )
    bins = bins_of(climate)
    squares = _squares(bins, climate, harmonics)
    flux = bins.total(climate.flux(water) * climate.hours).ravel()
    order = bins.occupied[np.argsort(-flux[bins.occupied], kind="stable")]
    solved = order[: affordable(harmonics, seconds)]
    rows = np.searchsorted(bins.occupied, solved)
    amplitude = np.array([np.sqrt(squares[row]) * _phases(seed, int(bins.occupied[row]), harmonics) for row in rows])
    found = [[_optimum(port, harmonics, one, limits) for one in pair] for pair in amplitude]
    optima = tuple(tuple(None if isinstance(one, float) else one for one in pair) for pair in found)
    undecided = np.array([[one if isinstance(one, float) else 0.0 for one in pair] for pair in found])
    matched = np.zeros(bins.shape)
    matched.ravel()[bins.occupied] = squares @ port.matched_power[: harmonics.count]
    share = float(flux[solved].sum() / flux.sum())
    return ConstrainedYear(bins, solved, amplitude, optima, matched, share, undecided)


def _phases(seed: int, place: int, harmonics: Harmonics) -> ComplexArray:
    """Random phases of the realisations of a bin, shape (realisation, harmonic)."""
    drawn = np.random.default_rng([seed, place]).uniform(size=(REALISATIONS, harmonics.count))
    return np.asarray(np.exp(2j * np.pi * drawn))


def _squares(bins: Bins, climate: Climate, harmonics: Harmonics) -> FloatArray:
    """Squared amplitudes at the harmonics of the mean spectrum of each occupied bin, (bin, harmonic) [m^2]."""
    weight = np.zeros((len(bins.occupied), len(climate.hours)))
    weight[np.searchsorted(bins.occupied, bins.index), np.arange(len(climate.hours))] = climate.hours
    mean = weight @ climate.density / weight.sum(axis=1, keepdims=True)
    edges = climate.edges
    below = np.concatenate([np.zeros((len(mean), 1)), np.cumsum(mean * np.diff(edges), axis=1)], axis=1)
    half = harmonics.spacing / 2
    cuts = np.append(harmonics.omega - half, harmonics.omega[-1] + half)
    inside = np.array([np.diff(np.interp(cuts, edges, row)) for row in below])
    left_out = 1 - float((bins.share.ravel()[bins.occupied] @ inside).sum() / (climate.hours @ climate.variance))
    if left_out > OUTSIDE:
        raise ConfigError(
            f"constrained: received harmonics from {cuts[0]:.4g} to {cuts[-1]:.4g} rad/s, which leave out "
            f"{left_out:.2%} of the variance of {climate.name}, needs at most {OUTSIDE:.0%}: a longer period "
            "or a higher omega_max"
        )
    return 2 * inside


def _optimum(port: Port, harmonics: Harmonics, amplitude: ComplexArray, limits: Limits) -> ConstrainedOptimum | float:
    """The optimum of one sea; where no force is found that keeps the stroke, the bound of those that might [W]."""
    if not port.moves:
        nothing = np.zeros(harmonics.count, dtype=complex)
        return ConstrainedOptimum(nothing, nothing, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0)
    try:
        return constrained_optimum(harmonics, port, amplitude, limits)
    except NoForceFoundError as error:
        return max(0.0, error.bound)
    except StabilityError:
        return 0.0
