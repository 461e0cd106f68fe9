"""Mean power in irregular seas with intervals, the linear spectral prediction beside it.

In a sea of random amplitudes the interval is the 95 % confidence interval of its expected mean power, from records of
the length and number computed. The variance of their means by linear theory is known exactly (`record_covariance`);
what linear theory leaves out is estimated from batches of the records (`half_width`). Designs are run in the same
waves, in which most of the scatter of their gain cancels. With fixed amplitudes every realisation has the energy of the
sea and mean power hardly varies: the interval is that of the realisations computed and holds the numerical error alone.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.special import stdtrit

from vsb.engine.hydro.database import Check, check_at_most
from vsb.engine.waves.kinds import Irregular
from vsb.engine.waves.seas import Sea, superposed
from vsb.models.take_off import LINEARISED
from vsb.results.comparison import in_direction, power_response, power_waves, relative_difference
from vsb.study.study import FEWEST_BATCHES, Study
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray
from vsb.tools.words import csv_text, plain

CONFIDENCE = 0.95
INSTANTS = 8
"""Instants per shortest period of a sea at which linear power is averaged."""
AGREEMENT, AGREEMENT_WITH_DRAG = 0.005, 0.05
"""Relative difference of mean power from linear theory in the same waves above which it is in doubt [-]."""


class Estimate(NamedTuple):
    """An estimated mean and its interval."""

    mean: float
    low: float
    high: float


class Line(NamedTuple):
    """One design in one irregular sea, all its realisations together."""

    design: str
    sea: str
    amplitudes: str  # `random`: intervals are of the expected mean power of the sea, else of these realisations
    realisations: int
    batches: int
    power_mean: float  # of the runs [W]
    power_low: float | None
    power_high: float | None
    power_linear: float  # spectral prediction of linear theory, of the sea [W]
    power_linear_record: float  # linear theory in the same waves over the same window [W]
    gain_percent: float | None  # of mean power over the first rigid design's
    gain_low: float | None
    gain_high: float | None
    record_power_mean: float | None = None  # of the runs, where `power_mean` is of the sea [W]
    record_gain_percent: float | None = None


def student(freedom: float) -> float:
    """Return half the confidence interval of Student's t in standard errors, of some degrees of freedom."""
    return float(stdtrit(freedom, 0.5 + CONFIDENCE / 2))  # scipy.stats alone takes half a second to import


def batch_means(run: xr.Dataset, window: tuple[float, float], length: float) -> FloatArray:
    """Return the mean absorbed power of each batch of a run, shape (batch,) [W].

    Parameters
    ----------
    run : xarray.Dataset
        See `vsb.engine.integrators.simulate.recorded`.
    window : tuple of float [s]
        Cut into as many equal batches as fit, at least one.
    length : float
        Least length of a batch [s].
    """
    start, end = window
    edges = np.linspace(start, end, batches_in(end - start, length) + 1)
    energy = CubicSpline(run.time.values, run.energy.sel(term="pto").values)(edges)
    return np.asarray(np.diff(energy) / np.diff(edges))


def batches_in(record: float, length: float) -> int:
    """Return how many batches of a length or more there are in a record, at least one; both in s."""
    return max(1, int(record / length + 1e-9))


def families(study: Study) -> dict[str, list[Irregular]]:
    """Return the irregular seas of a study, realisations of one sea together, by the name without seed."""
    found: dict[str, list[Irregular]] = {}
    for wave in study.waves:
        if wave.irregular:
            found.setdefault(wave.family, []).append(wave)
    return found


def _parts(wave: Irregular, sea: Sea) -> list[tuple[Irregular, BoolArray]]:
    """A sea in every direction its waves go to, and which of its components do, shape (component,)."""
    if sea.heading is None:
        return [(wave, np.ones(len(sea.omega), dtype=bool))]
    return [(wave.model_copy(update={"direction": float(one)}), sea.heading == one) for one in np.unique(sea.heading)]


class Sample(NamedTuple):
    """What statistics keep of the run of a design in an irregular sea, or of all its realisations together."""

    batches: FloatArray  # mean power of each (batch,) [W]
    linear_batches: FloatArray  # by linear theory in the same waves (batch,) [W]
    linear: float  # expected by linear theory of the sea [W]
    components: ComplexArray  # u, |u|^2 their expected powers by linear theory (component, load) [W^0.5]
    spacing: float  # of the components in frequency [rad/s]
    drag: float = 1.0  # expected power with the equivalent dampers of drag over that without [-]

    @property
    def linear_record(self) -> float:
        """Mean power of linear theory in the same waves and window [W]."""
        return self.drag * float(self.linear_batches.mean())


def sample(
    study: Study,
    wave: Irregular,
    design: str,
    run: xr.Dataset,
    sea: Sea,
    spectral: Sea,
    response: xr.Dataset,
    fine: Sea | None = None,
) -> Sample:
    """Return what statistics keep of the run of a design in a realisation of a sea.

    Parameters
    ----------
    sea, spectral : Sea
        The realisation, and the same with the amplitudes of the spectrum (`vsb.engine.waves.seas.BaseWave.expected`).
    response : xarray.Dataset
        The frequency response of the study.
    fine : Sea, optional
        The spectrum in finer bands (`vsb.models.floating_system.expected_sea`), for expectations.
    """
    window, found, whole = study.simulation.window, [], spectral if fine is None else fine
    linear = sum(
        linear_power(power_response(study, in_direction(response, going), design, run.attrs), whole.part(mine))
        for going, mine in _parts(wave, whole)
    )
    for going, mine in _parts(wave, sea):
        here = in_direction(response, going)
        transfer = power_waves(study, here, design, run.attrs)
        found.append((mine, CubicSpline(transfer.omega.values, transfer.values)(sea.omega[mine])))
    drag = float(run.attrs.get(LINEARISED, linear)) / linear if linear else 1.0
    absorbed = np.zeros((len(sea.omega), found[0][1].shape[1]), dtype=complex)
    for mine, values in found:
        absorbed[mine] = values
    batches = batch_means(run, window, wave.memory)
    alike = linear_batches(sea.omega, absorbed * sea.amplitude[:, None], window, len(batches))
    components = np.sqrt(0.5) * absorbed * np.abs(spectral.amplitude)[:, None]
    spacing = float(np.ptp(sea.omega)) / max(len(sea.omega) - 1, 1)
    return Sample(batches, alike, drag * linear, components, spacing, drag)


def linear_batches(omega: FloatArray, absorbed: ComplexArray, window: tuple[float, float], count: int) -> FloatArray:
    """Return the mean power u^2 of equal batches of a window by linear theory, transients past, (batch,) [W].

    Parameters
    ----------
    omega : ndarray, shape (component,) [rad/s]
    absorbed : ndarray, shape (component, load) [W^0.5]
        Phasors of u, sqrt(c) times the velocity of a port.
    window : tuple of float [s]
    count : int
        Number of batches.
    """
    length = (window[1] - window[0]) / count
    steps = int(np.ceil(INSTANTS * float(omega.max()) * length / (2 * np.pi)))
    power = np.sum(superposed(omega, absorbed, np.linspace(*window, count * steps + 1)) ** 2, axis=1)
    return np.array([np.trapezoid(power[i * steps : (i + 1) * steps + 1]) / steps for i in range(count)])


def record_covariance(
    first: ComplexArray, second: ComplexArray, spacing: float, length: float, *, random: bool = True
) -> float:
    """Return the covariance of the mean powers of two designs over records of one Gaussian sea [W^2].

    Parameters
    ----------
    first, second : ndarray, shape (component, load) [W^0.5]
        See `Sample.components`.
    spacing : float
        Of the components in frequency [rad/s].
    length : float
        Of the records [s].
    random : bool
        Whether amplitudes are random; fixed ones, under random phases, leave out the terms j = k.

    Notes
    -----
    With independent complex normal z_j of E |z_j|^2 = 1 the mean power of a record of length T is, but for terms at
    the sums of frequencies, sum_jk u_j* u_k z_j* z_k sinc((w_j - w_k) T/2), so that
    Cov = sum_jk Re(a_j a_k*) sinc^2((w_j - w_k) T/2), a_j = u1_j* u2_j, of several loads summed over all pairs.
    """
    count = len(first)
    product = (first.conj()[:, :, None] * second[:, None, :]).reshape(count, -1)
    spectra = np.sum(np.abs(np.fft.fft(product, 2 * count, axis=0)) ** 2, axis=1)
    lagged = np.fft.ifft(spectra).real[:count]  # sum_j Re(a_j* a_{j+m})
    weight = np.sinc(np.arange(count) * spacing * length / (2 * np.pi)) ** 2
    return float(2 * weight @ lagged - (1 + (not random)) * lagged[0])


def record_interval(mean: float, own: Sample, length: float, *, random: bool) -> tuple[float, float]:
    """Return the 95 % interval of the mean power of a sea by the mean of one record of a length [s] alone [W].

    Scatter as by linear theory, in proportion to the mean.
    """
    variance = record_covariance(own.components, own.components, own.spacing, length, random=random)
    expected = float(np.sum(np.abs(own.components) ** 2))
    half = student(np.inf) * float(np.sqrt(max(variance, 0.0))) * (mean / expected if expected else 0.0)
    return mean - half, mean + half


def half_width(samples: FloatArray, alike: FloatArray, covariance: FloatArray) -> float:
    """Return half the 95 % confidence interval of the mean of samples, one for each batch of the records.

    Parameters
    ----------
    samples : ndarray, shape (batch,)
    alike : ndarray, shape (batch, k)
        By linear theory in the same waves.
    covariance : ndarray, shape (k, k)
        Of the means of `alike` over all records, which is known (`record_covariance`).

    Notes
    -----
    Samples are b.alike + rest by least squares: the mean of the first part has the variance b^T covariance b, whatever
    the batches are; that of the rest, which linear theory does not explain, is estimated from their scatter, with
    Satterthwaite's degrees of freedom. Batches alone do not give the variance of a record's mean: they are few, and
    neighbours are correlated.
    """
    count, explained = alike.shape
    centred, about = samples - samples.mean(), alike - alike.mean(axis=0)
    slope = np.linalg.lstsq(about, centred)[0]
    freedom = count - 1 - explained
    rest = float(np.sum((centred - about @ slope) ** 2)) / (freedom * count)
    variance = float(slope @ covariance @ slope) + rest
    if variance <= 0:
        return 0.0
    return student(freedom * (variance / rest) ** 2 if rest > 0 else np.inf) * float(np.sqrt(variance))


def stratified_variance(draws: FloatArray) -> tuple[float, float]:
    """Return the variance of the mean of draws, two of each stratum one after the other, and its degrees of freedom.

    Satterthwaite's F = (sum v)^2/sum v^2 of S strata with one degree each is about (S + 2)/3 where all scatter alike:
    3 F - 2 would be right there. But a storm that is not drawn is missing in mean and variance at once. Of 1000
    campaigns each of ten models 5/2 F - 3/2 covered the truth in 93.1 to 96.2 % (12 seas, year of NDBC 46042).
    Differences that begin above a threshold of height, power or steepness are covered in 87 to 95 % (gains in 91 to
    97 %) while seas above it hold 7 to 26 % of the energy, in 83 to 94 % at 5 %, in 77 to 95 % at 3 %; drawn by energy
    alone it was 55 to 92, 48 to 66 and 50 to 86 %.
    """
    parts = (draws[0::2] - draws[1::2]) ** 2 / len(draws) ** 2
    squares = float(np.sum(parts**2))
    effective = float(parts.sum()) ** 2 / squares if squares > 0 else 1.0
    return float(parts.sum()), min(float(len(parts)), 2.5 * effective - 1.5)


def stratified_half_width(draws: FloatArray) -> float:
    """Return half the 95 % interval of the mean of draws; see `stratified_variance`."""
    variance, freedom = stratified_variance(draws)
    return student(freedom) * float(np.sqrt(variance))


def statistics(study: Study, samples: Mapping[tuple[str, str], Sample]) -> list[Line]:
    """Return one line per design and irregular sea.

    Parameters
    ----------
    samples : mapping (design, wave label) -> Sample
    """
    return [line for waves in families(study).values() for line in _of_sea(study, waves, samples)]


def _of_sea(study: Study, waves: Sequence[Irregular], samples: Mapping[tuple[str, str], Sample]) -> list[Line]:
    """One line per design in one irregular sea."""
    designs, reference = list(study.designs), study.reference_design
    records = {design: together([samples[design, wave.label] for wave in waves]) for design in designs}
    base = records.get(reference or "")
    random, length = waves[0].amplitudes == "random", float(np.diff(study.simulation.window)[0])
    tolerance, lines = study.hydro.tolerance, []
    for design, own in records.items():
        power, gain = float(own.batches.mean()), None
        half = _half_width(own.batches, [own], len(waves), length) if random else tolerance * abs(power)
        of_gain = None
        if base is not None and base.batches.sum() > 0 and design != reference:
            mean = float(base.batches.mean())
            gain = 100 * (power / mean - 1)
            left = 100 * (own.batches - power / mean * base.batches) / mean  # the delta method
            of_gain = _half_width(left, [own, base], len(waves), length) if random else 2 * tolerance * abs(100 + gain)
        lines.append(
            Line(
                design, waves[0].family, waves[0].amplitudes, len(waves), len(own.batches),
                power, *_bounds(power, half), own.linear, own.linear_record,
                gain, *_bounds(gain, of_gain),
            )
        )  # fmt: skip
    return lines


def together(some: Sequence[Sample]) -> Sample:
    """The realisations of a sea one after the other; their components are the same."""
    batches, linear_batches = (np.concatenate([getattr(one, name) for one in some]) for name in Sample._fields[:2])
    linear = float(np.mean([one.linear for one in some]))
    return Sample(batches, linear_batches, linear, *some[0][3:])


def _half_width(samples: FloatArray, records: Sequence[Sample], realisations: int, length: float) -> float | None:
    """Half the interval of the mean of samples, by designs that explain them; None of too few."""
    if len(samples) < FEWEST_BATCHES:
        return None
    covariance = [
        [record_covariance(one.components, other.components, one.spacing, length) for other in records]
        for one in records
    ]
    alike = np.stack([one.linear_batches for one in records], axis=1)
    return half_width(samples, alike, np.array(covariance) / realisations)


def _bounds(value: float | None, half: float | None) -> tuple[float | None, float | None]:
    """Ends of an interval, if it is known."""
    return (None, None) if value is None or half is None else (value - half, value + half)


def linear_power(power: xr.DataArray, sea: Sea) -> float:
    """Return the mean power linear theory predicts, sum of P(omega) |a|^2 over the components [W]."""
    return float(sea.mean_of(CubicSpline(power.omega.values, power.values)(sea.omega)))


def statistical_checks(study: Study, lines: Sequence[Line]) -> list[Check]:
    """Return how well mean powers in irregular seas are known, and whether runs agree with linear theory."""
    checks, linear = [], study.hydro.model == "linear" and not study.pto.nonlinear
    for line in lines:
        where = {"design": line.design, "wave": line.sea}
        if line.power_low is not None:
            share, text = _sharpness(line, [other for other in lines if other.sea == line.sea])
            checks.append(check_at_most("statistical_error", share, 0.1, "-", text, doubt=True, **where))
        if linear:
            limit = AGREEMENT_WITH_DRAG if study.plates else AGREEMENT
            expected, mean = line.power_linear_record, line.record_power_mean
            text = f"relative difference of mean power from linear theory in the same waves, {plain(expected)} W"
            difference = relative_difference(line.power_mean if mean is None else mean, expected)
            checks.append(check_at_most("spectral_prediction", difference, limit, "-", text, doubt=True, **where))
    return checks


def _sharpness(line: Line, sea: Sequence[Line]) -> tuple[float, str]:
    """Relative error of the gains in the same waves if they are known, else of power; and its words."""
    low, mean, high = line.power_low or 0.0, line.power_mean, line.power_high or 0.0
    share = 0.5 * (high - low) / abs(mean) if mean else 0.0
    gains = [_half_gain(one) for one in ([line] if line.gain_low is not None else sea)]
    known = [half for half in gains if half is not None]
    if not known:
        return share, f"half the interval of mean power, {plain(mean)} W, over it"
    text = f"half the interval of the gain in the same waves; that of mean power is {100 * share:.2g} %"
    return max(known), text


def _half_gain(line: Line) -> float | None:
    """Half the interval of a design's power over the reference's, over it; None if it is not known, or of nothing."""
    if line.gain_percent is None or line.gain_low is None or line.gain_high is None:
        return None
    part = abs(100 + line.gain_percent)
    return 0.5 * (line.gain_high - line.gain_low) / part if part else None


def as_csv(lines: Sequence[Line]) -> str:
    """Return the lines as CSV; an empty cell is a quantity that does not exist."""
    return csv_text(Line._fields, lines)
