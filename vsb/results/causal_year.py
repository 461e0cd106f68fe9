"""A site's year under causal control: one controller for each occupied bin of Hs and Te, a schedule over sea states.

The controller of a bin is the optimum of the bin's mean spectrum at a given rms force. It is linear: over the seas of
the bin, whatever their spectra, it has the mean power and the mean square of the force that it has in their mean. Where
a damper of that rms force absorbs more it is the controller of the bin. Beside it stands the year under such dampers.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.fft import next_fast_len

from vsb.engine.motion.causal import StationaryPort, numerical_error, optimum
from vsb.engine.motion.coefficient_errors import CoefficientError, sensitivity
from vsb.engine.motion.take_off import Pto
from vsb.engine.motion.tuning import damper_within_force
from vsb.engine.waves.climate import YEAR_HOURS, Climate
from vsb.engine.waves.kinds import RESOLVED
from vsb.models.floating_system import AnyBody, Floating, InWaves
from vsb.models.stationary import continued, grid, rms_limits
from vsb.results.left_out import LeftOut
from vsb.results.year import DesignYear, Values, best_for_all, bins_of, frequencies, gains_within, powers_within
from vsb.results.year_validity import beyond_in_bins
from vsb.study.campaign import CAUSAL, SAME_FORCE
from vsb.study.study import Study
from vsb.tools.arrays import ComplexArray, FloatArray


class Scheduled(NamedTuple):
    """A port under the controller of a bin."""

    power: float  # [W]
    error: float  # numerical [W]
    force_rms: float  # [N]
    force: ComplexArray  # per wave amplitude (omega,) [N/m]


def scheduled(pto: Pto, year: DesignYear, squares: FloatArray, port: StationaryPort) -> dict[str, Scheduled]:
    """Return the damper of a given rms force, and the causal control, in the mean spectrum of a bin.

    Parameters
    ----------
    year : DesignYear
    squares : ndarray, shape (omega,) [m^2]
        Squared amplitudes of the spectrum at its frequencies.
    port : StationaryPort
        In the same spectrum.
    """
    seen, noise, forecast = year.port, pto.control.noise, pto.control.forecast
    limits, matched = rms_limits(pto, seen, squares), float(squares @ seen.matched_power)
    best = optimum(port, limits, noise, forecast)
    ratio = matched / port.matched_power
    damper = damper_within_force(seen, squares[None], limits.force, pto.stiffness)
    load = seen.load(damper.damping, damper.stiffness)[0]
    force = np.asarray(load * seen.velocity_under(load))
    stroke = float(np.sqrt(0.5 * np.abs((seen.velocity - seen.admittance * force) / seen.omega) ** 2 @ squares))
    damped = Scheduled(float(damper.power[0]), 0.0, float(np.sqrt(0.5 * np.abs(force) ** 2 @ squares)), force)
    if stroke <= limits.stroke and damper.power[0] >= ratio * best.power:
        return {SAME_FORCE: damped, CAUSAL: damped}
    gain = np.interp(seen.omega, port.omega, port.controller(best.weights, noise, forecast))
    error = ratio * best.power * numerical_error(port, best, noise, forecast)
    own = Scheduled(ratio * best.power, error, best.force_rms, gain * seen.velocity / seen.admittance)
    return {SAME_FORCE: damped, CAUSAL: own}


def causal_years(
    study: Study | AnyBody,
    floating: Floating,
    climate: Climate,
    tunings: Sequence[str] = (SAME_FORCE, CAUSAL),
    left_out: LeftOut | None = None,
) -> Values:
    """Return the years of designs under causal control, or dampers of its rms force, and their gains.

    Parameters
    ----------
    study : Study or BodyStudy
        Of viable designs alone.
    left_out : LeftOut, optional
        Errors by shell modes left out.
    """
    bins, omega = bins_of(climate), frequencies(climate, *floating.band)
    density, flux = bins.mean_densities(climate), climate.flux(study.water)
    spacing = RESOLVED * 2 * np.pi / float(climate.te @ climate.hours)
    inside, beyond = grid(spacing, next_fast_len(int(np.ceil(floating.band[1] / spacing))))
    waves, near, far = floating.at(omega).in_waves(), floating.at(inside).ports(), floating.at(beyond).ports()
    spectra = np.array([np.interp(inside, climate.omega, row, left=0.0, right=0.0) for row in density])
    radius = study.buoy.device.radius if study.buoy else None
    columns: dict[str, list[list[float | FloatArray]]] = {}
    for design, one in waves.items():
        year = DesignYear(one.port, climate)
        rows = density @ year.weights
        found = []
        for squares, spectrum in zip(rows, spectra, strict=True):
            free = np.abs(near[design].velocity) ** 2 * spectrum
            found.append(scheduled(study.pto, year, squares, continued(spacing, near[design], far[design], free)))
        by_tuning = [[in_bin[tuning] for in_bin in found] for tuning in tunings]
        for own in by_tuning:
            power, error, square = (
                bins.matrix(np.array(values))
                for values in zip(*((b.power, b.error, b.force_rms**2) for b in own), strict=True)
            )
            moved = {
                name: bins.matrix(rms) for name, rms in _motion_rms(one, np.array([b.force for b in own]), rows).items()
            }
            mean, none, of_flux = float((bins.share * power).sum()), np.zeros(bins.shape), bins.mean(flux)
            column: dict[str, float | FloatArray] = {
                "annual_mean_power": mean,
                "annual_energy": mean * YEAR_HOURS / 1e6,
                "capture_width": mean / float(flux @ climate.hours),
                "force_rms": float(np.sqrt((bins.share * square).sum())),
                "quadrature_error": float((bins.share * error).sum()),
                "power_matrix": power,
                "capture_width_matrix": np.divide(power, of_flux, out=none.copy(), where=of_flux > 0),
                **dict.fromkeys(("damping", "power_deviation", "capture_width_deviation"), none),
            }
            column |= beyond_in_bins(bins, climate, study.water, power, moved, radius)
            for name, value in column.items():
                columns.setdefault(name, [[] for _ in waves])[list(waves).index(design)].append(value)
    dims = {2: (), 3: ("limit",), 4: ("hs", "te")}
    together = {name: np.array(values) for name, values in columns.items()}
    values = {name: (("design", "tuning", *dims[array.ndim]), array) for name, array in together.items()}
    return {**values, **_intervals(study, waves, climate, floating.errors(omega), values, left_out)}


def _motion_rms(one: InWaves, force: ComplexArray, squares: FloatArray) -> dict[str, FloatArray]:
    """Root mean squares of heave and shell in each bin under forces per wave amplitude, each shape (bin,) [m]."""
    found: dict[str, list[float]] = {"heave": [], "deformation": []}
    for own, row in zip(force, squares, strict=True):
        heave, shell = (free - own * forced for free, forced in (one.motion.heave, one.motion.shell))
        points = (0.5 * np.abs(shell) ** 2 @ row).sum(axis=0)
        found["heave"].append(float(np.sqrt(0.5 * np.abs(heave) ** 2 @ row)))
        found["deformation"].append(float(np.sqrt(points.max(initial=0.0))))
    return {name: np.array(values) for name, values in found.items()}


def _intervals(
    study: Study | AnyBody,
    waves: Mapping[str, InWaves],
    climate: Climate,
    errors: Sequence[CoefficientError],
    found: Values,
    left_out: LeftOut | None,
) -> Values:
    """Intervals of powers and gains.

    What errors of the coefficients do is taken at the optimal damper of the year and at the matched force, whichever is
    larger: a scarce force takes power in proportion to the free velocity, an ample one that of the matched force.
    """
    names = list(waves)
    reference = None if study.reference_design is None else names.index(study.reference_design)
    power, error = (np.asarray(found[name][1], dtype=float) for name in ("annual_mean_power", "quadrature_error"))
    of_power, of_ratio = np.zeros((2, *power.shape))
    dampers = best_for_all([DesignYear(one.port, climate) for one in waves.values()])
    for matched in (False, True):
        slopes = []
        for one, damping in zip(waves.values(), dampers, strict=True):
            load = np.conj(one.port.impedance) if matched else one.port.load(float(damping), 0.0)
            squares = DesignYear(one.port, climate).squares
            slopes.append(sensitivity(one.port.omega, one.moved, one.port, load, squares))
        each = np.array([[sum(slope.to(one) for one in errors)] for slope in slopes])
        of_power = np.maximum(of_power, each)
        if reference is not None:
            over = [[sum((slope - slopes[reference]).to(one) for one in errors)] for slope in slopes]
            of_ratio = np.maximum(of_ratio, np.array(over))
    within = powers_within(power, error, of_power, left_out.power if left_out else None)
    if reference is None:
        return within
    return {**within, **gains_within(power, error, of_ratio, reference, left_out.gain if left_out else None)}
