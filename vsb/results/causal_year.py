"""A site's year under causal control: one controller for each occupied bin of Hs and Te, a schedule over sea states.

The controller of a bin is the optimum of the bin's mean spectrum at a given rms force, of several ports that of all
forces together. It is linear: over the seas of the bin, whatever their spectra, it has the mean power and the mean
square of the force that it has in their mean. Where a damper, of several ports a damper matrix, of that rms force
absorbs more it is the controller of the bin. Beside it stands the year under such dampers.

With losses in conversion the power of each sea follows from its means of F V, F^2 and V^2, of which it is no linear
function (`vsb.engine.motion.tuning.converted_power`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.fft import next_fast_len
from scipy.interpolate import make_interp_spline

from vsb.engine.motion.causal import Controlled, StationaryPort, numerical_error, optimum
from vsb.engine.motion.causal_ports import StationaryPorts
from vsb.engine.motion.causal_ports import optimum as optimum_of_several
from vsb.engine.motion.coefficient_errors import (
    CoefficientError,
    Sensitivity,
    sensitivity,
    sensitivity_at_ports,
    sensitivity_of_forces,
)
from vsb.engine.motion.damper_matrix import matrix_within_force
from vsb.engine.motion.port import Port
from vsb.engine.motion.take_off import Pto
from vsb.engine.motion.tuning import converted_power, damper_within_force
from vsb.engine.waves.climate import YEAR_HOURS, Climate
from vsb.engine.waves.seas import RESOLVED
from vsb.models.floating_system import AnyBody, Floating, InWaves, SeveralInWaves
from vsb.models.stationary import continued, continued_several, force_units, grid, rms_force, rms_limits
from vsb.models.take_off import matrix_kind
from vsb.results.left_out import LeftOut
from vsb.results.matrix_year import MatrixYear
from vsb.results.year import (
    DesignYear,
    Values,
    Year,
    band_weights,
    best_for_all,
    bins_of,
    frequencies,
    gains_within,
    powers_within,
)
from vsb.results.year_validity import beyond_in_bins
from vsb.study.campaign import CAUSAL, SAME_FORCE
from vsb.study.study import Study
from vsb.tools.arrays import ComplexArray, FloatArray


class Scheduled(NamedTuple):
    """A take-off under the controller of a bin."""

    power: float  # [W]
    error: float  # numerical [W]
    force_rms: float  # [N]; of several ports that of all forces together
    force: ComplexArray  # per wave amplitude (omega,) or (omega, port) [N/m]
    matrix: FloatArray | None = None  # of a damper matrix (port, port)
    of_seas: FloatArray | None = None  # power in each sea of the bin, at one port (sea,) [W]
    damping: float = 0.0  # of a damper [N s/m]
    optimum: tuple[StationaryPort, Controlled] | None = None  # of a controller, at one port


Schedule = list[dict[str, Scheduled]]
"""By bin: tuning -> controller."""


def scheduled(
    pto: Pto, year: DesignYear, squares: FloatArray, port: StationaryPort, seas: FloatArray, hours: FloatArray
) -> dict[str, Scheduled]:
    """Return the damper of a given rms force, and the causal control, in the mean spectrum of a bin.

    Parameters
    ----------
    year : DesignYear
    squares : ndarray, shape (omega,) [m^2]
        Squared amplitudes of the spectrum at its frequencies.
    port : StationaryPort
        In the same spectrum.
    seas, hours : ndarray, shapes (sea, omega) [m^2], (sea,)
        Those of the seas of the bin, whose mean it is, and their shares.
    """
    seen, noise, forecast = year.port, pto.control.noise, pto.control.forecast
    if not seen.moves:
        still = Scheduled(0.0, 0.0, 0.0, np.zeros_like(seen.velocity), of_seas=np.zeros(len(hours)))
        return {SAME_FORCE: still, CAUSAL: still}
    limits, matched = rms_limits(pto, seen, squares), float(squares @ seen.matched_power)

    def converted(force: ComplexArray, known: tuple[float, float, float] | None = None) -> FloatArray:
        means = port_means(seen, force)
        mean = means @ squares if known is None else np.array(known)
        return powers_of_seas(means @ seas.T, hours, pto.efficiency, mean)

    damper = damper_within_force(seen, squares[None], limits.force, pto.stiffness, pto.efficiency)
    load = seen.load(damper.damping, damper.stiffness)[0]
    force = np.asarray(load * seen.velocity_under(load))
    stroke = float(np.sqrt(0.5 * np.abs((seen.velocity - seen.admittance * force) / seen.omega) ** 2 @ squares))
    each, share, rms = converted(force), hours / hours.sum(), float(np.sqrt(0.5 * np.abs(force) ** 2 @ squares))
    damped = Scheduled(float(each @ share), 0.0, rms, force, of_seas=each, damping=float(damper.damping[0]))
    best = optimum(port, limits, noise, forecast, pto.efficiency)
    gain = np.interp(seen.omega, port.omega, port.controller(best.weights, noise, forecast))
    own = gain * seen.velocity / seen.admittance
    each = matched / port.matched_power * converted(own, (best.power, best.force, best.speed))
    power = float(each @ share)
    if stroke <= limits.stroke and damped.power >= power:
        return {SAME_FORCE: damped, CAUSAL: damped}
    error = power * numerical_error(port, best, noise, forecast)
    controlled = Scheduled(power, error, best.force_rms, own, of_seas=each, optimum=(port, best))
    return {SAME_FORCE: damped, CAUSAL: controlled}


def port_means(port: Port, force: ComplexArray) -> FloatArray:
    """Return the means of F V, F^2 and V^2 per squared wave amplitude, shape (3, omega), of a force (omega,) [N/m]."""
    speed = port.velocity - port.admittance * force
    return 0.5 * np.stack([np.real(force.conj() * speed), np.abs(force) ** 2, np.abs(speed) ** 2])


def powers_of_seas(means: FloatArray, hours: FloatArray, efficiency: float, known: FloatArray) -> FloatArray:
    """Return the power after conversion in seas whose means are known in their mean spectrum, shape (sea,) [W].

    Parameters
    ----------
    means : ndarray, shape (3, sea)
        Of F V, F^2 and V^2 in each sea, see `port_means`.
    hours : ndarray, shape (sea,)
        Their shares.
    known : ndarray, shape (3,)
        The same in the mean spectrum, noise included, which is taken to be in proportion in each sea.
    """
    share = hours / hours.sum()
    power, square, speed = means * np.divide(known, means @ share, out=np.zeros(3), where=known > 0)[:, None]
    return converted_power(power, np.sqrt(square * speed), efficiency) if efficiency < 1 else power


def scheduled_at_ports(pto: Pto, year: MatrixYear, squares: FloatArray, ports: StationaryPorts) -> dict[str, Scheduled]:
    """Return a damper matrix, and the causal control of its rms force, in the mean spectrum of a bin.

    The matrix is the best of a given rms force or, without one, of `MatrixYear.tried`, as in each sea. Parameters as of
    `scheduled`.
    """
    seen, noise, forecast = year.port, pto.control.noise, pto.control.forecast
    if pto.control.force_rms < np.inf:
        matrix = matrix_within_force(seen, squares, pto.control.force_rms, year.kind).damping
    else:
        matrix = max(year.tried, key=lambda one: float(squares @ seen.power(one)))
    power, force = float(squares @ seen.power(matrix)), seen.velocity_under(matrix) @ matrix
    rms = seen.force_rms(matrix, squares)
    damped = Scheduled(power, 0.0, float(np.linalg.norm(rms)), force, matrix)
    if not power > 0:
        return {SAME_FORCE: damped, CAUSAL: damped}
    units = force_units(pto, rms)
    forces = np.diag(units) @ ports.over(np.diag(units)).moving()
    moved = ports.over(forces)
    found = optimum_of_several(moved, rms_force(pto, float(np.linalg.norm(rms / units))), noise, forecast)
    ratio = float(squares @ seen.matched_power) / ports.matched_power
    if power >= ratio * found.power:
        return {SAME_FORCE: damped, CAUSAL: damped}
    gain = make_interp_spline(moved.omega, moved.controller(found.weights, noise, forecast), k=1)(seen.omega)
    waves = np.linalg.solve(forces.T @ seen.admittance @ forces, (seen.velocity @ forces)[..., None])
    own = (forces @ gain @ waves)[..., 0]
    error = ratio * found.power * numerical_error(moved, found, noise, forecast)
    together = float(np.sqrt(0.5 * squares @ (np.abs(own) ** 2).sum(axis=1)))
    return {SAME_FORCE: damped, CAUSAL: Scheduled(ratio * found.power, error, together, own)}


@dataclass(frozen=True)
class _Spectra:
    """Mean spectra of the bins of a year at the frequencies of its controllers, and where ports are to be known."""

    spacing: float  # [rad/s]
    inside: FloatArray  # in the band (omega,)
    beyond: FloatArray  # beyond it
    density: FloatArray  # (bin, omega) [m^2 s]

    @classmethod
    def of_year(cls, climate: Climate, omega_max: float) -> "_Spectra":
        """Return those of a climate."""
        spacing = RESOLVED * 2 * np.pi / float(climate.te @ climate.hours)
        inside, beyond = grid(spacing, next_fast_len(int(np.ceil(omega_max / spacing))))
        rows = bins_of(climate).mean_densities(climate)
        return cls(
            spacing,
            inside,
            beyond,
            np.array([np.interp(inside, climate.omega, row, left=0.0, right=0.0) for row in rows]),
        )


def schedules_at_port(
    study: Study | AnyBody, floating: Floating, climate: Climate, waves: Mapping[str, InWaves]
) -> dict[str, Schedule]:
    """Return the schedule of every design at one port."""
    spectra, bins = _Spectra.of_year(climate, floating.band[1]), bins_of(climate)
    near, far = floating.at(spectra.inside).ports(), floating.at(spectra.beyond).ports()
    density, found = bins.mean_densities(climate), dict[str, Schedule]()
    for design, one in waves.items():
        year, found[design] = DesignYear(one.port, climate), []
        for place, row, spectrum in zip(bins.occupied, density, spectra.density, strict=True):
            free = np.abs(near[design].velocity) ** 2 * spectrum
            port = continued(spectra.spacing, near[design], far[design], free)
            inside = bins.index == place
            seas = climate.density[inside] @ year.weights
            found[design].append(scheduled(study.pto, year, row @ year.weights, port, seas, climate.hours[inside]))
    return found


def schedules_at_ports(
    study: Study | AnyBody, floating: Floating, climate: Climate, waves: Mapping[str, SeveralInWaves]
) -> dict[str, Schedule]:
    """Return the schedule of every design at several ports."""
    spectra, kind = _Spectra.of_year(climate, floating.band[1]), matrix_kind(study.pto)
    near, far = (floating.at(omega).several_ports() for omega in (spectra.inside, spectra.beyond))
    density, found = bins_of(climate).mean_densities(climate), dict[str, Schedule]()
    for design, one in waves.items():
        year, found[design] = MatrixYear(one.port, climate, kind), []
        free = near[design].velocity
        square = free[:, :, None] * free[:, None].conj()
        for row, spectrum in zip(density, spectra.density, strict=True):
            seen = square * spectrum[:, None, None]
            ports = continued_several(spectra.spacing, near[design], far[design], seen)
            found[design].append(scheduled_at_ports(study.pto, year, row @ year.weights, ports))
    return found


def year_of_schedules(study: Study | AnyBody, climate: Climate, schedules: Mapping[str, Schedule]) -> Year:
    """Return the year of the designs of a study under causal control at one port, sea by sea."""
    bins = bins_of(climate)
    power = np.zeros((len(schedules), 1, len(climate.hours)))
    for i, schedule in enumerate(schedules.values()):
        for place, in_bin in zip(bins.occupied, schedule, strict=True):
            power[i, 0, bins.index == place] = in_bin[CAUSAL].of_seas
    names, none = (tuple(schedules), (CAUSAL,)), np.zeros((len(schedules), 1))
    return Year(climate, study.water, *names, None, power, none, none, study.reference_design)


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
    omega = frequencies(climate, *floating.band)
    at, errors = floating.at(omega), floating.errors(omega)
    if study.pto.several:
        several = at.several_in_waves()
        schedules = schedules_at_ports(study, floating, climate, several)
        values = _values(study, climate, several, schedules, tunings)
        slopes = _slopes_at_ports(study, several, climate, schedules, values, tunings)
    else:
        waves = at.in_waves()
        schedules = schedules_at_port(study, floating, climate, waves)
        values = _values(study, climate, waves, schedules, tunings)
        slopes = _slopes(waves, climate)
    return {**values, **_intervals(study, slopes, errors, values, left_out)}


def _values(
    study: Study | AnyBody,
    climate: Climate,
    waves: Mapping[str, InWaves] | Mapping[str, SeveralInWaves],
    schedules: Mapping[str, Schedule],
    tunings: Sequence[str],
) -> Values:
    """Powers, forces and motions of the years of schedules."""
    bins, flux = bins_of(climate), climate.flux(study.water)
    density, radius = bins.mean_densities(climate), study.buoy.device.radius if study.buoy else None
    columns: dict[str, list[list[float | FloatArray]]] = {}
    for design, one in waves.items():
        rows = density @ band_weights(one.port.omega, climate)
        for tuning in tunings:
            own = [in_bin[tuning] for in_bin in schedules[design]]
            power, error, square = (
                bins.matrix(np.array(values))
                for values in zip(*((b.power, b.error, b.force_rms**2) for b in own), strict=True)
            )
            moved = {name: bins.matrix(rms) for name, rms in _motion_rms(one, own, rows).items()}
            mean, none, of_flux = float((bins.share * power).sum()), np.zeros(bins.shape), bins.mean(flux)
            column: dict[str, float | FloatArray] = {
                "annual_mean_power": mean,
                "annual_energy": mean * YEAR_HOURS / 1e6,
                "capture_width": mean / float(flux @ climate.hours),
                "quadrature_error": float((bins.share * error).sum()),
                "power_matrix": power,
                "capture_width_matrix": np.divide(power, of_flux, out=none.copy(), where=of_flux > 0),
                **dict.fromkeys(("power_deviation", "capture_width_deviation"), none),
            }
            if isinstance(one, InWaves):
                column |= {"force_rms": float(np.sqrt((bins.share * square).sum())), "damping": none}
            else:
                share, count = bins.share.ravel()[bins.occupied], one.port.velocity.shape[1]
                dampers = [b.matrix for b in own if b.matrix is not None and tuning == SAME_FORCE]
                column["damper_matrix"] = (
                    np.tensordot(share, dampers, axes=1) if dampers else np.full((count, count), np.nan)
                )
            column |= beyond_in_bins(bins, climate, study.water, power, moved, radius)
            for name, value in column.items():
                columns.setdefault(name, [[] for _ in waves])[list(waves).index(design)].append(value)
    dims = {"energy_beyond": ("limit",), "damper_matrix": ("port", "port_")}
    together = {name: np.array(values) for name, values in columns.items()}
    return {
        name: (("design", "tuning", *dims.get(name, ("hs", "te")[: array.ndim - 2])), array)
        for name, array in together.items()
    }


def _motion_rms(
    one: InWaves | SeveralInWaves, schedule: Sequence[Scheduled], squares: FloatArray
) -> dict[str, FloatArray]:
    """Root mean squares of heave and shell in each bin, each shape (bin,) [m]."""
    found: dict[str, list[float]] = {"heave": [], "deformation": []}
    for own, row in zip(schedule, squares, strict=True):
        heave, shell = one.motion_under(own.force)
        points = (0.5 * np.abs(shell) ** 2 @ row).sum(axis=0)
        found["heave"].append(float(np.sqrt(0.5 * np.abs(heave) ** 2 @ row)))
        found["deformation"].append(float(np.sqrt(points.max(initial=0.0))))
    return {name: np.array(values) for name, values in found.items()}


Slopes = list[list[list[Sensitivity]]]
"""Derivatives of the logarithms of powers, by take-off they are taken at, tuning, design."""


def _slopes(waves: Mapping[str, InWaves], climate: Climate) -> Slopes:
    """Those at the optimal damper of the year and at the matched force, the same of all tunings.

    A scarce force takes power in proportion to the free velocity, an ample one that of the matched force.
    """
    found: Slopes = []
    dampers = best_for_all([DesignYear(one.port, climate) for one in waves.values()])
    for matched in (False, True):
        slopes = []
        for one, damping in zip(waves.values(), dampers, strict=True):
            load = np.conj(one.port.impedance) if matched else one.port.load(float(damping), 0.0)
            squares = DesignYear(one.port, climate).squares
            slopes.append(sensitivity(one.port.omega, one.moved, one.port, load, squares))
        found.append([slopes])
    return found


def _slopes_at_ports(
    study: Study | AnyBody,
    waves: Mapping[str, SeveralInWaves],
    climate: Climate,
    schedules: Mapping[str, Schedule],
    values: Values,
    tunings: Sequence[str],
) -> Slopes:
    """Those at the optimal damper matrix of the year, and at the forces of the schedule as they are."""
    bins, kind = bins_of(climate), matrix_kind(study.pto)
    density, share = bins.mean_densities(climate), bins.share.ravel()[bins.occupied]
    years = {design: MatrixYear(one.port, climate, kind) for design, one in waves.items()}
    at_matrix = [
        sensitivity_at_ports(one.moved, one.port, years[design].best, years[design].squares)
        for design, one in waves.items()
    ]
    at_forces = []
    for j, tuning in enumerate(tunings):
        slopes = []
        for i, (design, one) in enumerate(waves.items()):
            amplitude = np.sqrt(density @ years[design].weights).astype(complex)
            forces = amplitude[..., None] * np.array([in_bin[tuning].force for in_bin in schedules[design]])
            power = float(np.asarray(values["annual_mean_power"][1])[i, j])
            slopes.append(sensitivity_of_forces(one.port.omega, one.moved, amplitude, forces, power, share))
        at_forces.append(slopes)
    return [[at_matrix], at_forces]


def _intervals(
    study: Study | AnyBody,
    slopes: Slopes,
    errors: Sequence[CoefficientError],
    found: Values,
    left_out: LeftOut | None,
) -> Values:
    """Intervals of powers and gains: the larger of what errors of the coefficients do at either take-off."""
    reference = None if study.reference_design is None else list(study.designs).index(study.reference_design)
    power, error = (np.asarray(found[name][1], dtype=float) for name in ("annual_mean_power", "quadrature_error"))
    of_power, of_ratio = np.zeros((2, *power.shape))
    for at in slopes:
        each = [[sum(slope.to(one) for one in errors) for slope in of_tuning] for of_tuning in at]
        of_power = np.maximum(of_power, np.array(each).T)
        if reference is not None:
            over = [[sum((slope - some[reference]).to(one) for one in errors) for slope in some] for some in at]
            of_ratio = np.maximum(of_ratio, np.array(over).T)
    within = powers_within(power, error, of_power, left_out.power if left_out else None)
    if reference is None:
        return within
    return {**within, **gains_within(power, error, of_ratio, reference, left_out.gain if left_out else None)}
