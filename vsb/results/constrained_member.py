"""The tuning `constrained` of a member of a campaign: the best force of any kind within the take-off's limits."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from vsb.motion.coefficient_errors import CoefficientError, sensitivity_of_forces
from vsb.motion.force_bound import Harmonics, Limits
from vsb.motion.port import PortMotion
from vsb.results.constrained_year import ConstrainedYear, constrained_year, harmonics_of_year
from vsb.results.member import OF_LIMITS
from vsb.results.validity import LIMITS, motion_limits, wave_limits
from vsb.scenes.directions import order_bases
from vsb.scenes.ports import InWaves, ShapeWater, designs_in_waves
from vsb.shell.modes import ModeBasis
from vsb.shell.reference import ReferenceShell
from vsb.study.campaign import CONSTRAINED
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray
from vsb.waves.climate import YEAR_HOURS, Climate

KEPT = 32
"""Years of rigid designs that are kept: points of other shells share them."""


@dataclass
class Optima:
    """What finds the years of designs within limits; a rigid design that points have in common is solved once."""

    water: Callable[[ModeBasis, FloatArray], ShapeWater]  # coefficients of the member's shape at frequencies
    seconds: float  # budget of each design [s]
    seed: int
    known: dict[bytes, ConstrainedYear] = field(default_factory=dict)

    def __call__(
        self,
        study: Study,
        reference: ReferenceShell,
        climate: Climate,
        lowest: float,
        left_out: FloatArray | None = None,
    ) -> xr.Dataset:
        """Return the years of designs that are viable within the limits of their take-off.

        Parameters
        ----------
        study : Study
            Of those designs alone.
        reference : ReferenceShell
        climate : Climate
        lowest : float [rad/s]
            From where on coefficients and waves are known.
        left_out : ndarray, shape (design, end) [percentage points], optional
            As of `vsb.results.left_out.gain_of_year`.
        """
        harmonics = harmonics_of_year(climate, lowest, study.hydro.omega_max, self.seconds)
        waves = designs_in_waves(study, reference, self.water(reference.basis, harmonics.port_omega))
        found = {design: self._year(study, design, one, climate, harmonics) for design, one in waves.items()}
        water, families = self.water(reference.basis, harmonics.omega), order_bases(study, reference.basis)
        errors = water.errors(reference.basis, families, study.water)
        return constrained_dataset(study, found, waves, climate, errors, left_out)

    def _year(
        self, study: Study, design: str, waves: InWaves, climate: Climate, harmonics: Harmonics
    ) -> ConstrainedYear:
        """The year of one design."""
        limits = Limits(study.pto.force_limit, study.pto.stroke_limit)
        port, water = waves.port, study.water  # of which the port does not tell the energy flux
        given = np.array([*limits, water.density, water.depth, water.gravity])
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
    waves: Mapping[str, InWaves],
    climate: Climate,
    errors: Sequence[CoefficientError] = (),
    left_out: FloatArray | None = None,
) -> xr.Dataset:
    """Return the years of designs within limits as other tunings have theirs, and how far they are proved."""
    flux = climate.flux(study.water)
    columns: dict[str, dict[str, float | FloatArray]] = {
        design: _column(one, climate, flux) | _beyond(study, one, waves[design].motion, climate)
        for design, one in years.items()
    }
    reference = study.reference_design
    if reference is not None:
        missed = np.zeros((len(years), 2)) if left_out is None else left_out
        gains = _gains(years, reference, _apart(years, waves, reference, errors), missed)
        columns = {design: {**column, **gains.get(design, {})} for design, column in columns.items()}
    dims = {0: (), 1: ("limit",), 2: ("hs", "te")}
    names = next(iter(columns.values()))
    together = {name: np.stack([np.asarray(column[name]) for column in columns.values()]) for name in names}
    ds = xr.Dataset(
        {name: (("design", *dims[value.ndim - 1]), value) for name, value in together.items()},
        coords={"design": list(years)},
    )
    of_tuning = [name for name in ds.data_vars if name not in OF_LIMITS]
    return ds.assign({name: ds[name].expand_dims(tuning=[CONSTRAINED], axis=1) for name in of_tuning})


def _column(one: ConstrainedYear, climate: Climate, flux: FloatArray) -> dict[str, float | FloatArray]:
    """All of one design but what it does in too high seas."""
    mean, low, high = one.annual_mean_power
    of_bins = one.bins.mean(flux)
    none = np.zeros(one.bins.shape)
    return {
        "annual_mean_power": mean,
        "annual_energy": mean * YEAR_HOURS / 1e6,
        "capture_width": mean / float(flux @ climate.hours),
        "force_rms": one.force_rms,
        "quadrature_error": (high - low) / 2,
        "power_matrix": one.power_matrix,
        "capture_width_matrix": np.divide(one.power_matrix, of_bins, out=none.copy(), where=of_bins > 0),
        "damping": none,
        "power_deviation": none,
        "capture_width_deviation": none,
        "power_bound": one.bound,
        "optimum_gap": 1 - one.taken / one.bound if one.bound > 0 else 0.0,
        "optimum_share": one.flux_share,
        "optimum_excess": one.excess,
        "impossible_share": one.impossible,
    }


def _apart(
    years: Mapping[str, ConstrainedYear],
    waves: Mapping[str, InWaves],
    reference: str,
    errors: Sequence[CoefficientError],
) -> list[float]:
    """Largest relative change of every design's power over the reference's by errors of the coefficients [-]."""
    slopes = {}
    for design, one in years.items():
        _, each, count = one.amplitude.shape
        force = np.array([found.force if found else np.zeros(count) for pair in one.optima for found in pair])
        free, forced = (part[:count] for part in waves[design].moved)  # those beyond are of limits alone
        slopes[design] = sensitivity_of_forces(
            waves[design].port.omega[:count],
            (free, forced),
            one.amplitude.reshape(-1, count),
            force,
            one.taken,
            np.repeat(one.share, each) / each,
        )
    return [sum((slopes[design] - slopes[reference]).to(error) for error in errors) for design in years]


def _gains(
    years: Mapping[str, ConstrainedYear], reference: str, apart: Sequence[float], left_out: FloatArray
) -> dict[str, dict[str, float]]:
    """Gains over the reference and their intervals; none over nothing.

    Intervals are of what is proved, of few waves, of errors of the coefficients (`_apart`) and of shell modes left out
    (design, end) [percentage points].
    """
    found = {}
    for (design, one), error, (below, above) in zip(years.items(), apart, left_out, strict=True):
        gain = one.gain(years[reference])
        if gain is None:
            return {}
        width = error * (100 + gain.mean)
        low, high = (gain.low - width + below, gain.high + width + above) if design != reference else (0.0, 0.0)
        found[design] = {"gain_percent": gain.mean, "gain_low": low, "gain_high": high}
    return found


def _beyond(study: Study, one: ConstrainedYear, motion: PortMotion, climate: Climate) -> dict[str, float | FloatArray]:
    """Which part of the seas of each bin lies beyond what is described, and their shares of the energy.

    Steepness is that of every sea; the motion is that of the mean spectrum of a bin, which marks all of it.
    """
    bins = one.bins
    shares = {limit.name: bins.mean(limit.seas.astype(float)) for limit in wave_limits(climate, study.water)}
    steep = bins.mean(np.any([limit.seas for limit in wave_limits(climate, study.water)], axis=0).astype(float))
    moved = {name: one.matrix(values) for name, values in _motion_rms(one, motion).items()}
    for limit in motion_limits({name: v.ravel() for name, v in moved.items()}, study.device.radius):
        shares[limit.name] = limit.seas.reshape(bins.shape).astype(float)
    marked = np.where(shares["deformation"] > 0, 1.0, steep)
    energy = bins.share * one.power_matrix
    total = max(float(energy.sum()), np.finfo(float).tiny)
    return {
        "beyond_validity": marked,
        "energy_beyond": np.array([float((energy * shares[name]).sum()) / total for name in LIMITS]),
        "energy_beyond_validity": float((energy * marked).sum()) / total,
    }


def _motion_rms(one: ConstrainedYear, motion: PortMotion) -> dict[str, FloatArray]:
    """Root mean squares of heave and shell in the bins solved, shape (bin,) [m]; 0 where no force keeps the limits."""
    count = one.amplitude.shape[-1]  # harmonics of the band, the first frequencies of the motion
    zero = np.zeros(count, dtype=complex)
    force = np.array([[o.force if o else zero for o in pair] for pair in one.optima])
    held = np.array([[o is not None for o in pair] for pair in one.optima])[..., None]
    waves = np.where(held, one.amplitude, 0.0)
    heave = waves * motion.heave[0][:count] - force * motion.heave[1][:count]
    variance = (np.abs(heave) ** 2).sum(axis=-1).mean(axis=1) / 2
    largest = np.zeros(len(variance))
    for free, forced in zip(*(np.moveaxis(part, 1, 0) for part in motion.shell), strict=True):  # points
        both = waves[..., None, :] * free[..., :count] - force[..., None, :] * forced[..., :count]
        largest = np.maximum(largest, (np.abs(both) ** 2).sum(axis=(-1, -2)).mean(axis=1) / 2)
    return {"heave": np.sqrt(variance), "deformation": np.sqrt(largest)}
