"""A site's year within limits of force and stroke: the optimum of the mean spectrum of each occupied bin.

Bins are taken in the order of the energy flux they bring, as many as a budget of time allows; how many that is follows
from the size of the programmes and no clock, so that an answer does not depend on how busy a machine is. The rest of
the year is bracketed: nothing, and what the best force of all would take.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vsb.errors import ConfigError, StabilityError
from vsb.motion.constrained import ConstrainedOptimum, constrained_optimum
from vsb.motion.harmonics import Harmonics
from vsb.motion.port import Port
from vsb.motion.tuning import BoolArray, IntArray
from vsb.results.bins import Bins
from vsb.results.statistics import Estimate
from vsb.results.year import OUTSIDE
from vsb.study.study import Water
from vsb.tools.units import ComplexArray, FloatArray
from vsb.waves.climate import Climate

SECONDS_PER_CUBE = 4e-9
"""Time of one optimum over the third power of its harmonics, on one core of a usual machine [s]."""
SECONDS_AT_LEAST = 5e-3
"""Time of the smallest one [s]."""


class Limits(NamedTuple):
    """What the force, and the displacement of the port from rest, must not exceed."""

    force: float = np.inf  # [N]
    stroke: float = np.inf  # [m]


@dataclass(frozen=True)
class ConstrainedYear:
    """Optima within limits of the bins that were reached."""

    bins: Bins
    solved: IntArray  # bins, by the energy flux they bring (bin,)
    optima: tuple[ConstrainedOptimum | None, ...]  # of each; none where no force keeps the stroke within its limit
    matched: FloatArray  # mean power of the best force of all, of every bin (hs, te) [W]
    flux_share: float  # of the year's energy flux in the bins solved [-]

    def _each(self, field: str) -> FloatArray:
        """A field of the optima, 0 where there is none, shape (bin,)."""
        return np.array([getattr(optimum, field) if optimum else 0.0 for optimum in self.optima])

    @property
    def power_matrix(self) -> FloatArray:
        """Mean power of the solved bins, 0 elsewhere, shape (hs, te) [W]."""
        out = np.zeros(self.bins.shape)
        out.ravel()[self.solved] = self._each("power")
        return out

    @property
    def reached(self) -> BoolArray:
        """Whether a bin was solved, shape (hs, te)."""
        out = np.zeros(self.bins.shape, dtype=bool)
        out.ravel()[self.solved] = True
        return out

    @property
    def impossible(self) -> float:
        """Share of the year in which no force keeps the stroke within its limit [-]."""
        none = [at for at, optimum in zip(self.solved, self.optima, strict=True) if optimum is None]
        return float(self.bins.share.ravel()[none].sum())

    @property
    def annual_mean_power(self) -> Estimate:
        """Mean power of the year and its bracket [W].

        The mean takes the same part of the matched power in bins not reached as in those solved.
        """
        share, reached = self.bins.share, self.reached
        taken = float(np.sum(share * self.power_matrix))
        bound = float(self.bins.share.ravel()[self.solved] @ self._each("bound"))
        could, left = (float(np.sum((share * self.matched)[which])) for which in (reached, ~reached))
        return Estimate(taken + (taken / could * left if could else 0.0), taken, bound + left)

    @property
    def force_rms(self) -> float:
        """Root mean square of the force over the bins solved [N]."""
        share = self.bins.share.ravel()[self.solved]
        return float(np.sqrt(share @ self._each("force_rms") ** 2 / share.sum()))

    @property
    def excess(self) -> float:
        """Largest part by which a limit is exceeded between the instants of collocation [-]."""
        return float(self._each("excess").max())


def affordable(harmonics: Harmonics, seconds: float) -> int:
    """Return how many optima a budget of time allows, at least one."""
    return max(1, int(seconds / (SECONDS_AT_LEAST + SECONDS_PER_CUBE * harmonics.count**3)))


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
        At the frequencies of the harmonics.
    climate : Climate
    water : Water
        Of the energy flux.
    harmonics : Harmonics
        Of the period every sea is taken to repeat in.
    limits : Limits
    seconds : float
        Budget of time [s].
    seed : int
        Of the phases, the same in every bin.

    Raises
    ------
    ConfigError
        If the port is known elsewhere, or harmonics leave out more than a hundredth of the variance.
    """
    if len(port.omega) != harmonics.count or not np.allclose(port.omega, harmonics.omega, rtol=1e-9):
        raise ConfigError(
            f"constrained: received a port at {len(port.omega)} frequencies up to {port.omega[-1]:.4g} rad/s, needs "
            f"the {harmonics.count} harmonics up to {harmonics.omega[-1]:.4g} rad/s"
        )
    bins = Bins(climate.hs, climate.te, climate.hours)
    squares = _squares(bins, climate, harmonics)
    phase = np.exp(2j * np.pi * np.random.default_rng(seed).uniform(size=harmonics.count))
    flux = bins.total(climate.flux(water) * climate.hours).ravel()
    order = bins.occupied[np.argsort(-flux[bins.occupied], kind="stable")]
    solved = order[: affordable(harmonics, seconds)]
    rows = np.searchsorted(bins.occupied, solved)
    optima = tuple(_optimum(port, harmonics, np.sqrt(squares[row]) * phase, limits) for row in rows)
    matched = np.zeros(bins.shape)
    matched.ravel()[bins.occupied] = squares @ port.matched_power
    return ConstrainedYear(bins, solved, optima, matched, float(flux[solved].sum() / flux.sum()))


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


def _optimum(port: Port, harmonics: Harmonics, amplitude: ComplexArray, limits: Limits) -> ConstrainedOptimum | None:
    """The optimum of one sea; none where no force keeps the stroke within its limit."""
    try:
        return constrained_optimum(harmonics, port.velocity * amplitude, port.admittance, limits.force, limits.stroke)
    except StabilityError:
        return None
