"""A site's year under causal control: one controller for each occupied bin of Hs and Te, a schedule over sea states.

The controller of a bin is the optimum of the bin's mean spectrum at a given rms force, of several ports that of all
forces together. It is linear: over the seas of the bin, whatever their spectra, it has the mean power and the mean
square of the force that it has in their mean. Where a damper, of several ports a damper matrix, of that rms force
absorbs more it is the controller of the bin. Beside it stands the year under such dampers.

With losses in conversion the power of each sea follows from its means of F V, F^2 and V^2, of which it is no linear
function (`vsb.engine.motion.tuning.converted_power`).
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.fft import next_fast_len
from scipy.interpolate import make_interp_spline

from vsb.engine.motion.causal import Controlled, RmsLimits, StationaryPort, StationaryPorts, numerical_error, optimum
from vsb.engine.motion.coefficient_errors import (
    sensitivity,
    sensitivity_of_forces,
)
from vsb.engine.motion.port import Port
from vsb.engine.motion.take_off import Pto
from vsb.engine.motion.tuning import converted_power, damper_within_force, priced_matrix
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.seas import RESOLVED
from vsb.models.floating_system import Floating, InWaves
from vsb.models.stationary import continued, force_units, free_density, grid, rms_force, rms_limits
from vsb.models.take_off import matrix_kind
from vsb.results.budget import LeftOut
from vsb.results.year import (
    DesignYear,
    MatrixYear,
    Slopes,
    Values,
    Year,
    band_weights,
    bins_of,
    design_year,
    frequencies,
    within_errors,
    year_of_bins,
)
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

    def beside(self, most: float) -> "Scheduled":
        """Return a damper as the best of both where the controller absorbs less, and `most` with its error [W]."""
        return self._replace(error=max(most - self.power, 0.0))


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
    force = load * seen.velocity_under(load)
    stroke = float(np.sqrt(0.5 * np.abs((seen.velocity - seen.admittance * force) / seen.omega) ** 2 @ squares))
    each, share, rms = converted(force), hours / hours.sum(), float(np.sqrt(0.5 * np.abs(force) ** 2 @ squares))
    damped = Scheduled(float(each @ share), 0.0, rms, force, of_seas=each, damping=float(damper.damping[0]))
    best = optimum(port, limits, noise, forecast, pto.efficiency)
    gain = np.interp(seen.omega, port.omega, port.controller(best.weights, noise, forecast))
    own = gain * seen.velocity / seen.admittance
    each = matched / port.matched_power * converted(own, (best.power, best.force, best.speed))
    power = float(each @ share)
    error = power * numerical_error(port, best, noise, forecast).size
    if stroke <= limits.stroke and damped.power >= power:
        return {SAME_FORCE: damped, CAUSAL: damped.beside(power + error)}
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


def scheduled_at_ports(pto: Pto, year: Any, squares: FloatArray, ports: StationaryPorts) -> dict[str, Scheduled]:
    """Return a damper matrix, and the causal control of its rms force, in the mean spectrum of a bin.

    The matrix is the best of a given rms force or, without one, of `MatrixYear.tried`, as in each sea. Parameters as of
    `scheduled`.
    """
    seen, noise, forecast = year.port, pto.control.noise, pto.control.forecast
    if pto.control.force_rms < np.inf:
        matrix = priced_matrix(seen, squares, pto.control.force_rms, year.kind)[0].damping
    else:
        matrix = max(year.tried, key=lambda one: float(squares @ seen.power(one)))
    power, force = float(squares @ seen.power(matrix)), seen.force(matrix)
    rms = seen.force_rms(matrix, squares)
    damped = Scheduled(power, 0.0, float(np.linalg.norm(rms)), force, matrix)
    if not power > 0:
        return {SAME_FORCE: damped, CAUSAL: damped}
    units = force_units(pto, rms)
    forces = np.diag(units) @ ports.over(np.diag(units)).moving()
    moved = ports.over(forces)
    limits = RmsLimits(rms_force(pto, float(np.linalg.norm(rms / units))))
    found = optimum(moved, limits, noise, forecast)
    ratio = float(squares @ seen.matched_power) / ports.matched_power
    error = ratio * found.power * numerical_error(moved, found, noise, forecast).size
    if power >= ratio * found.power:
        return {SAME_FORCE: damped, CAUSAL: damped.beside(ratio * found.power + error)}
    gain = make_interp_spline(moved.omega, moved.controller(found.weights, noise, forecast), k=1)(seen.omega)
    waves = np.linalg.solve(forces.T @ seen.admittance @ forces, (seen.velocity @ forces)[..., None])
    own = (forces @ gain @ waves)[..., 0]
    together = float(np.sqrt(0.5 * squares @ (np.abs(own) ** 2).sum(axis=1)))
    return {SAME_FORCE: damped, CAUSAL: Scheduled(ratio * found.power, error, together, own)}


def schedules(
    study: Study, floating: Floating, climate: Climate, waves: Mapping[str, InWaves[Any]]
) -> dict[str, Schedule]:
    """Return the schedule of every design."""
    spacing = RESOLVED * 2 * np.pi / float(climate.te @ climate.hours)
    inside, beyond = grid(spacing, next_fast_len(int(np.ceil(floating.band[1] / spacing))))
    near, far = (floating.at(omega).seen() for omega in (inside, beyond))
    bins, found = bins_of(climate), dict[str, Schedule]()
    for design, one in waves.items():
        year, found[design] = design_year(one.port, climate, kind=matrix_kind(study.pto)), []
        for place, row in zip(bins.occupied, bins.mean_densities(climate), strict=True):
            spectrum = np.interp(inside, climate.omega, row, left=0.0, right=0.0)
            free = free_density(near[design].velocity, spectrum)
            port = continued(spacing, near[design], far[design], free)
            here, squares = bins.index == place, row @ year.weights
            if study.pto.several:
                found[design].append(scheduled_at_ports(study.pto, year, squares, port))
            else:
                seas = climate.density[here] @ year.weights
                found[design].append(scheduled(study.pto, year, squares, port, seas, climate.hours[here]))
    return found


def year_of_schedules(study: Study, climate: Climate, schedules: Mapping[str, Schedule]) -> Year:
    """Return the year of the designs of a study under causal control at one port, sea by sea."""
    bins = bins_of(climate)
    power = np.zeros((len(schedules), 1, len(climate.hours)))
    for i, schedule in enumerate(schedules.values()):
        for place, in_bin in zip(bins.occupied, schedule, strict=True):
            power[i, 0, bins.index == place] = in_bin[CAUSAL].of_seas
    names, none = (tuple(schedules), (CAUSAL,)), np.zeros((len(schedules), 1))
    return Year(climate, study.water, *names, {}, power, none, none, study.reference_design)


def causal_years(
    study: Study,
    floating: Floating,
    climate: Climate,
    tunings: Sequence[str] = (SAME_FORCE, CAUSAL),
    left_out: LeftOut | None = None,
) -> Values:
    """Return the years of designs under causal control, or dampers of its rms force, and their gains.

    Parameters
    ----------
    study : Study
        Of viable designs alone.
    left_out : LeftOut, optional
        Errors by shell modes left out.
    """
    omega = frequencies(climate, *floating.band)
    at, errors = floating.at(omega), floating.errors(omega)
    waves = at.in_waves()
    own = schedules(study, floating, climate, waves)
    values = _values(study, climate, waves, own, tunings)
    if study.pto.several:
        slopes = _slopes_at_ports(study, waves, climate, own, values, tunings)
    else:
        slopes = _slopes(waves, climate)
    reference = None if study.reference_design is None else list(study.designs).index(study.reference_design)
    power, error = (np.asarray(values[name][1], dtype=float) for name in ("annual_mean_power", "quadrature_error"))
    return {**values, **within_errors(power, error, slopes, errors, reference, left_out)}


def _values(
    study: Study,
    climate: Climate,
    waves: Mapping[str, InWaves[Any]],
    schedules: Mapping[str, Schedule],
    tunings: Sequence[str],
) -> Values:
    """Powers, forces and motions of the years of schedules."""
    bins = bins_of(climate)
    density = bins.mean_densities(climate)
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
            means = float((bins.share * power).sum()), float((bins.share * error).sum())
            column = year_of_bins(climate, study.water, power, *means, moved, study.radius)
            if not study.pto.several:
                force = float(np.sqrt((bins.share * square).sum()))
                column |= {"force_rms": force, "damping": np.zeros(bins.shape)}
            else:
                share, count = bins.share.ravel()[bins.occupied], one.port.velocity.shape[1]
                dampers = [b.matrix for b in own if b.matrix is not None and tuning == SAME_FORCE]
                column["damper_matrix"] = (
                    np.tensordot(share, dampers, axes=1) if dampers else np.full((count, count), np.nan)
                )
            for name, value in column.items():
                columns.setdefault(name, [[] for _ in waves])[list(waves).index(design)].append(value)
    dims = {"energy_beyond": ("limit",), "damper_matrix": ("port", "port_")}
    together = {name: np.array(values) for name, values in columns.items()}
    return {
        name: (("design", "tuning", *dims.get(name, ("hs", "te")[: array.ndim - 2])), array)
        for name, array in together.items()
    }


def _motion_rms(one: InWaves[Any], schedule: Sequence[Scheduled], squares: FloatArray) -> dict[str, FloatArray]:
    """Root mean squares of heave and shell in each bin, each shape (bin,) [m]."""
    found: dict[str, list[float]] = {"heave": [], "deformation": []}
    for own, row in zip(schedule, squares, strict=True):
        heave, shell = one.motion.under(own.force)
        points = (0.5 * np.abs(shell) ** 2 @ row).sum(axis=0)
        found["heave"].append(float(np.sqrt(0.5 * np.abs(heave) ** 2 @ row)))
        found["deformation"].append(float(np.sqrt(points.max(initial=0.0))))
    return {name: np.array(values) for name, values in found.items()}


def _slopes(waves: Mapping[str, InWaves[Any]], climate: Climate) -> Slopes:
    """Those at the optimal damper of the year and at the matched force, the same of all tunings.

    A scarce force takes power in proportion to the free velocity, an ample one that of the matched force.
    """
    found, dampers = [], DesignYear.best_for_year([DesignYear(one.port, climate) for one in waves.values()])
    for matched in (False, True):
        slopes = []
        for one, damping in zip(waves.values(), dampers, strict=True):
            load = np.conj(one.port.impedance) if matched else one.port.load(float(damping), 0.0)
            squares = DesignYear(one.port, climate).squares
            slopes.append(sensitivity(one.moved, one.port, load, squares))
        found.append([slopes])
    return found


def _slopes_at_ports(
    study: Study,
    waves: Mapping[str, InWaves[Any]],
    climate: Climate,
    schedules: Mapping[str, Schedule],
    values: Values,
    tunings: Sequence[str],
) -> Slopes:
    """Those at the optimal damper matrix of the year, and at the forces of the schedule as they are."""
    bins, kind = bins_of(climate), matrix_kind(study.pto)
    density, share = bins.mean_densities(climate), bins.share.ravel()[bins.occupied]
    years = {design: MatrixYear(one.port, climate, kind=kind) for design, one in waves.items()}
    at_matrix = [
        sensitivity(one.moved, one.port, years[design].best, years[design].squares) for design, one in waves.items()
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
