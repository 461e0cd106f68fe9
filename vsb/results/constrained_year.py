"""A site's year within limits of force and stroke: the optimum of the mean spectrum of each occupied bin.

Bins are solved in the order of the energy flux they bring, as many as a budget of time allows; how many follows from
the size of the programmes and no clock, so that results do not depend on how busy a machine is. The rest of the year is
bracketed between zero and the matched power.

A bin is two realisations of its mean spectrum, with independent phases that are the same for all designs: their scatter
says how well few waves know the mean, and the gain of one design over another.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import xarray as xr

from vsb.engine.motion.coefficient_errors import CoefficientError, Sensitivity, sensitivity_of_forces
from vsb.engine.motion.constrained import ConstrainedOptimum, NoForceFoundError, constrained_optimum, optimum_in_sea
from vsb.engine.motion.force_bound import Harmonics, Limits
from vsb.engine.motion.port import Port, PortMotion
from vsb.engine.motion.tuning import best_dampers
from vsb.engine.waves.climate import OUTSIDE, Climate
from vsb.engine.waves.kinds import Irregular, RegularWave
from vsb.engine.waves.seas import Sea
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError, StabilityError, VsbError
from vsb.models.floating_system import Floating, InWaves
from vsb.results.budget import LeftOut
from vsb.results.campaign import OF_LIMITS
from vsb.results.statistics import Estimate, stratified_half_width
from vsb.results.year import POWER_ENDS, Bins, bins_of, year_of_bins
from vsb.study.campaign import CONSTRAINED
from vsb.study.study import Study
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray, IntArray

SECONDS_PER_CUBE = 4e-9
"""Time of one optimum over the third power of its harmonics, on one core of a usual machine [s]."""
SECONDS_AT_LEAST = 5e-3
"""Time of the smallest one [s]."""
REALISATIONS = 2
"""Realisations of each bin."""
SHORTEST, LONGEST = 4.0, 32.0
"""Periods after which a sea may be taken to repeat, over the mean energy period of the year [-]."""
KEPT = 32
"""Years of rigid designs that are kept: members with other shells share them."""


@dataclass(frozen=True)
class ConstrainedYear:
    """Optima within limits of the bins that were solved."""

    bins: Bins
    solved: IntArray  # bins, by the energy flux they bring (bin,)
    amplitude: ComplexArray  # of the waves (bin, realisation, harmonic) [m]
    optima: tuple[tuple[ConstrainedOptimum | None, ...], ...]  # (bin, realisation); None: no force keeps the stroke
    matched: FloatArray  # matched power of every bin (hs, te) [W]
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
    def absorbed(self) -> float:
        """Mean power of the year, zero in the bins not solved [W]."""
        return float(self.share @ self._each("power").mean(axis=1))

    @property
    def bound(self) -> float:
        """Bound of every force within the limits in these waves, of any force in the bins not solved [W]."""
        left = float(np.sum((self.bins.share * self.matched)[~self.reached]))
        return float(self.share @ (self._each("bound") + self.undecided).mean(axis=1)) + left

    @property
    def _whole(self) -> float:
        """The year over what is solved of it: other bins are taken to absorb the same part of the matched power."""
        could, left = (float(np.sum((self.bins.share * self.matched)[at])) for at in (self.reached, ~self.reached))
        return 1 + left / could if could else 1.0

    @property
    def annual_mean_power(self) -> Estimate:
        """Mean power of the year, its bracket widened by what the realisations leave open [W]."""
        half = stratified_half_width(self._draws)
        return Estimate(self.absorbed * self._whole, max(0.0, self.absorbed - half), self.bound + half)

    @property
    def _draws(self) -> FloatArray:
        """Draws whose mean is the power absorbed, two of each bin one after the other [W]."""
        return np.asarray((len(self.share) * self.share[:, None] * self._each("power")).ravel())

    def gain(self, over: "ConstrainedYear") -> Estimate | None:
        """Return the gain over another design in the same waves [%]; None over no power.

        Its interval is that of differences within pairs of realisations, widened by what is not proved.
        """
        base = over.annual_mean_power.mean
        if not base > 0:
            return None
        ratio = self.annual_mean_power.mean / base
        half = stratified_half_width((self._draws - ratio * over._draws) / over.absorbed)
        least, most = self.absorbed / over.bound - half, self.bound / over.absorbed + half
        return Estimate(100 * (ratio - 1), 100 * (least - 1), 100 * (most - 1))

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


def harmonics_of_year(climate: Climate, omega_min: float, omega_max: float, seconds: float) -> Harmonics:
    """Return the most closely spaced harmonics with which a budget of time allows the optima of all bins of a year.

    Parameters
    ----------
    omega_min, omega_max : float [rad/s]
        The band the force may be of.
    seconds : float
        Budget of time [s].
    """
    bins = bins_of(climate)
    each = seconds / (REALISATIONS * len(bins.occupied)) - SECONDS_AT_LEAST
    intervals = np.cbrt(max(each, 0.0) / SECONDS_PER_CUBE) - 1
    te = float(climate.te @ climate.hours)
    period = np.clip(2 * np.pi * intervals / (omega_max - omega_min), SHORTEST * te, LONGEST * te)
    spacing = float(2 * np.pi / period)
    first = max(1, int(np.ceil(omega_min / spacing - 1e-9)))
    return Harmonics(spacing, float(first), int(omega_max / spacing + 1e-9) - first + 1)


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

    Raises `ConfigError` if the port is known elsewhere, or harmonics leave out more than a hundredth of the variance.

    Parameters
    ----------
    port : Port
        At `harmonics.port_omega`.
    water : Water
        Of the energy flux.
    harmonics : Harmonics
        Of the period every sea is taken to repeat in.
    seconds : float
        Budget of time [s].
    seed : int
        Of the phases, of each bin its own.
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
    turns = [
        np.random.default_rng([seed, int(place)]).uniform(size=(REALISATIONS, harmonics.count))
        for place in bins.occupied[rows]
    ]
    amplitude = np.sqrt(squares[rows])[:, None] * np.exp(2j * np.pi * np.array(turns))
    found = [[_optimum(port, harmonics, one, limits) for one in pair] for pair in amplitude]
    optima = tuple(tuple(None if isinstance(one, float) else one for one in pair) for pair in found)
    undecided = np.array([[one if isinstance(one, float) else 0.0 for one in pair] for pair in found])
    matched = np.zeros(bins.shape)
    matched.ravel()[bins.occupied] = squares @ port.matched_power[: harmonics.count]
    share = float(flux[solved].sum() / flux.sum())
    return ConstrainedYear(bins, solved, amplitude, optima, matched, share, undecided)


def _squares(bins: Bins, climate: Climate, harmonics: Harmonics) -> FloatArray:
    """Squared amplitudes at the harmonics of the mean spectrum of each occupied bin, (bin, harmonic) [m^2]."""
    mean, edges = bins.mean_densities(climate), climate.edges
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


# of a member of a campaign -------------------------------------------------------------------------------------------


@dataclass
class Optima:
    """Computes the years of designs within limits; a rigid design that members have in common is solved once."""

    seconds: float  # budget of each design [s]
    seed: int
    known: dict[bytes, ConstrainedYear] = field(default_factory=dict)

    def __call__(
        self, study: Study, floating: Floating, climate: Climate, left_out: LeftOut | None = None
    ) -> xr.Dataset:
        """Return the years of designs within the limits of their take-off.

        Parameters
        ----------
        study : Study
            Of viable designs alone.
        floating : Floating
            What floats in it.
        left_out : LeftOut, optional
            Errors by shell modes left out.
        """
        low, high = floating.band
        low = max(low, float(climate.edges[0]))
        high = study.band[1] if study.band else high
        harmonics = harmonics_of_year(climate, low, high, self.seconds)
        waves = floating.at(harmonics.port_omega).in_waves()
        found = {design: self._year(study, design, one, climate, harmonics) for design, one in waves.items()}
        return constrained_dataset(study, found, waves, climate, floating.errors(harmonics.omega), left_out)

    def _year(
        self, study: Study, design: str, waves: InWaves[Port], climate: Climate, harmonics: Harmonics
    ) -> ConstrainedYear:
        """The year of one design."""
        limits = Limits(study.pto.force_limit, study.pto.stroke_limit)
        port, water = waves.port, study.water
        given = np.array([*limits, water.density, water.depth, water.gravity])  # of the energy flux
        key = port.velocity.tobytes() + port.admittance.tobytes() + given.tobytes()
        if key in self.known:
            return self.known[key]
        one = constrained_year(port, climate, water, harmonics, limits, self.seconds, self.seed)
        if not study.designs[design].flexible:
            if len(self.known) == KEPT:
                del self.known[next(iter(self.known))]
            self.known[key] = one
        return one


def constrained_dataset(
    study: Study,
    years: Mapping[str, ConstrainedYear],
    waves: Mapping[str, InWaves[Port]],
    climate: Climate,
    errors: Sequence[CoefficientError] = (),
    left_out: LeftOut | None = None,
) -> xr.Dataset:
    """Return the years of designs within limits as other tunings have theirs, and how far they are proved.

    Intervals of powers and gains are of what is not proved, of few waves, of errors of the coefficients and of shell
    modes left out.
    """
    columns, reference = {}, study.reference_design
    slopes = _slopes(years, waves)
    for i, (design, one) in enumerate(years.items()):
        mean, low, high = one.annual_mean_power
        moved = {name: one.matrix(values) for name, values in _motion_rms(one, waves[design].motion).items()}
        of_year = year_of_bins(climate, study.water, one.power_matrix, mean, (high - low) / 2, moved, study.radius)
        column: dict[str, float | FloatArray] = {
            **of_year,
            "force_rms": one.force_rms,
            "damping": np.zeros(one.bins.shape),
            "power_bound": one.bound,
            "optimum_gap": 1 - one.absorbed / one.bound if one.bound > 0 else 0.0,
            "optimum_share": one.flux_share,
            "optimum_excess": one.excess,
            "impossible_share": one.impossible,
        }
        least, most = (0.0, 0.0) if left_out is None else mean * left_out.power[i]
        error = mean * sum(slopes[design].to(each) for each in errors)
        column |= dict(zip(POWER_ENDS, (low - error + least, high + error + most), strict=True))
        if reference is not None and (gain := one.gain(years[reference])) is not None:
            by_coefficients = sum((slopes[design] - slopes[reference]).to(error) for error in errors)
            half = by_coefficients * (100 + gain.mean)
            below, above = (0.0, 0.0) if left_out is None else left_out.gain[i]
            ends = (gain.low - half + below, gain.high + half + above) if design != reference else (0.0, 0.0)
            column |= {"gain_percent": gain.mean, "gain_low": ends[0], "gain_high": ends[1]}
        columns[design] = column
    dims = {0: (), 1: ("limit",), 2: ("hs", "te")}
    names = next(iter(columns.values()))
    together = {name: np.stack([np.asarray(column[name]) for column in columns.values()]) for name in names}
    ds = xr.Dataset(
        {name: (("design", *dims[value.ndim - 1]), value) for name, value in together.items()},
        coords={"design": list(years)},
    )
    of_tuning = [name for name in ds.data_vars if name not in OF_LIMITS]
    return ds.assign({name: ds[name].expand_dims(tuning=[CONSTRAINED], axis=1) for name in of_tuning})


def _forces(one: ConstrainedYear) -> ComplexArray:
    """Optimal forces of the bins solved, (bin, realisation, harmonic) [N]; 0 where no force keeps the limits."""
    zero = np.zeros(one.amplitude.shape[-1], dtype=complex)
    return np.array([[found.force if found else zero for found in pair] for pair in one.optima])


def _slopes(years: Mapping[str, ConstrainedYear], waves: Mapping[str, InWaves[Port]]) -> dict[str, Sensitivity]:
    """Derivatives of the year's power by the coefficients, by design."""
    slopes = {}
    for design, one in years.items():
        _, each, count = one.amplitude.shape
        free, forced = (part[:count] for part in waves[design].moved)  # those beyond are of limits alone
        slopes[design] = sensitivity_of_forces(
            waves[design].port.omega[:count],
            (free, forced),
            one.amplitude.reshape(-1, count),
            _forces(one).reshape(-1, count),
            one.absorbed,
            np.repeat(one.share, each) / each,
        )
    return slopes


def _motion_rms(one: ConstrainedYear, motion: PortMotion) -> dict[str, FloatArray]:
    """Root mean squares of heave and shell in the bins solved, shape (bin,) [m]; 0 where no force keeps the limits."""
    count = one.amplitude.shape[-1]  # harmonics of the band, the first frequencies of the motion
    force = _forces(one)
    held = np.array([[o is not None for o in pair] for pair in one.optima])[..., None]
    waves = np.where(held, one.amplitude, 0.0)
    heave = waves * motion.heave[0][:count] - force * motion.heave[1][:count]
    variance = (np.abs(heave) ** 2).sum(axis=-1).mean(axis=1) / 2
    largest = np.zeros(len(variance))
    for free, forced in zip(*(np.moveaxis(part, 1, 0) for part in motion.shell), strict=True):  # points
        both = waves[..., None, :] * free[..., :count] - force[..., None, :] * forced[..., :count]
        largest = np.maximum(largest, (np.abs(both) ** 2).sum(axis=(-1, -2)).mean(axis=1) / 2)
    return {"heave": np.sqrt(variance), "deformation": np.sqrt(largest)}


# optima in a sea at a few limits of force, for an interactive page to step through ----------------------------------

# An irregular sea is taken to repeat: one realisation of its spectrum on equally spaced frequencies, the same for all
# designs and limits, as many as a budget of time allows. How many follows from the size of the problem, not a clock.

SHARES = (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0)
"""Limits of force, over the largest force of the reference's best damper [-]."""
SECONDS = 4.0
"""Budget of time of all seas, designs and limits of a page [s]."""
FEWEST, MOST = 64, 200
"""Harmonics of an irregular sea."""
WITHIN = 16
"""Frequencies at which a spectrum is averaged within the band of a harmonic."""

SeenPort = Callable[[FloatArray], Port]


@dataclass(frozen=True)
class ForceSteps:
    """Optima at some limits of force in one sea."""

    limits: tuple[float, ...]  # ascending [N]
    powers: Mapping[str, tuple[float | None, ...]]  # by design, at each limit [W]; None: not known
    of: str  # whose best damper needs the largest of the limits
    repeats: float | None  # period after which the sea is taken to repeat [s]; None of a regular wave


def harmonics_within(band: tuple[float, float], programmes: int) -> Harmonics:
    """Return equally spaced frequencies of a band [rad/s], as many as the budget allows for so many optima."""
    each = SECONDS / programmes - SECONDS_AT_LEAST
    count = int(np.clip(np.cbrt(max(each, 0.0) / SECONDS_PER_CUBE), FEWEST, MOST))
    low, high = band
    spacing = (high - low) / count
    first = max(1, int(np.ceil(low / spacing - 1e-9)))
    return Harmonics(spacing, float(first), int(high / spacing + 1e-9) - first + 1)


def repeating(wave: Irregular, harmonics: Harmonics) -> Sea:
    """Return a realisation of a spectrum on harmonics, each with the variance of the band around it.

    A record's own phases are not of these harmonics: it has random ones, too.
    """
    low, high = (harmonics.omega + side * harmonics.spacing / 2 for side in (-1, 1))
    amplitude = np.sqrt(2 * wave.variances(low, high))
    phase = np.random.default_rng(wave.seed if wave.drawn else 1).uniform(0.0, 2 * np.pi, harmonics.count)
    return Sea(harmonics.omega, amplitude * np.exp(1j * phase))


def force_steps(
    wave: RegularWave | Irregular,
    seen: Mapping[str, SeenPort],
    reference: str | None,
    band: tuple[float, float],
    seas: int = 1,
    stroke: float = np.inf,
) -> ForceSteps | None:
    """Return the optima of all designs in one sea; None where waves move no port.

    Parameters
    ----------
    seen : mapping design -> callable
        Frequencies -> its port, also outside the band.
    reference : str or None
        The design whose best damper the limits are of; else the first whose port waves move.
    band : (float, float) [rad/s]
        Of the force.
    seas : int
        How many the budget of time is for.
    stroke : float
        Limit of the port's displacement from rest [m].
    """
    if wave.irregular:
        harmonics = harmonics_within(band, seas * len(seen) * len(SHARES))
        waves, repeats = repeating(wave, harmonics), 2 * np.pi / harmonics.spacing
    else:
        waves, repeats = wave.realisation(), None
        harmonics = Harmonics.of_sea(waves.omega, *band)
    ports = {design: port(harmonics.port_omega) for design, port in seen.items()}
    of = next((d for d in (reference, *ports) if d in ports and ports[d].moves), None)
    if of is None:
        return None
    port, amplitude = ports[of].at(np.arange(harmonics.count)), np.zeros(harmonics.count, dtype=complex)
    amplitude[np.rint(waves.omega / harmonics.spacing - harmonics.first).astype(int)] = waves.amplitude
    damping = float(best_dampers(port, np.abs(amplitude[None]) ** 2).damping[0])
    largest = float(np.abs(harmonics.signal(port.force(damping) * amplitude)).max())
    limits = tuple(share * largest for share in SHARES)
    powers = {d: tuple(_power(port, waves, harmonics, limit, stroke) for limit in limits) for d, port in ports.items()}
    return ForceSteps(limits, powers, of, repeats)


def _power(port: Port, waves: Sea, harmonics: Harmonics, force: float, stroke: float) -> float | None:
    """Mean power of the best force within limits [W]; None where there is none, or none is found."""
    if not port.moves:
        return 0.0
    try:
        return optimum_in_sea(port, waves, harmonics, Limits(force, stroke)).power
    except VsbError:
        return None
