"""Mean power in irregular seas with confidence intervals, the linear spectral prediction beside it.

A record is cut into batches long enough to be nearly independent; batches of all realisations of a sea are pooled, and
Student's t gives the 95 % interval of their mean. Designs meet the same waves, so their gain is estimated batch by
batch, which takes most of the scatter out of it.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.special import stdtrit

from vsb.hydro.database import Check, check_at_most
from vsb.results.power import in_direction, power_response
from vsb.scenes.drag import LINEARISED
from vsb.study.compared import Compared
from vsb.study.study import Irregular, IrregularSea
from vsb.tools.tables import csv_text
from vsb.tools.units import FloatArray
from vsb.tools.words import plain
from vsb.waves.seas import Sea

FEWEST_BATCHES = 6
CONFIDENCE = 0.95


class Estimate(NamedTuple):
    """An estimated mean and its 95 % confidence interval; no interval from fewer than `FEWEST_BATCHES` batches."""

    mean: float
    low: float | None
    high: float | None


class Line(NamedTuple):
    """One design in one irregular sea, all its realisations together."""

    design: str
    sea: str
    realisations: int
    batches: int
    power_mean: float  # [W]
    power_low: float | None
    power_high: float | None
    power_linear: float  # spectral prediction of linear theory [W]
    gain_percent: float | None  # of mean power over the first rigid design's
    gain_low: float | None
    gain_high: float | None


def interval(samples: FloatArray) -> Estimate:
    """Return the mean of independent samples, shape (sample,), and its confidence interval."""
    return ratio_interval(samples, np.ones_like(samples))


def ratio_interval(samples: FloatArray, base: FloatArray) -> Estimate:
    """Return the ratio of the means of paired samples, each shape (sample,), and its confidence interval.

    Notes
    -----
    R = sum a/sum b with the standard error of a - R b over mean b: the delta method.
    """
    count, ratio = len(samples), float(samples.sum() / base.sum())
    if count < FEWEST_BATCHES:
        return Estimate(ratio, None, None)
    scatter = float(np.std(samples - ratio * base, ddof=1) / (base.mean() * np.sqrt(count)))
    half = student(count - 1) * scatter
    return Estimate(ratio, ratio - half, ratio + half)


def student(freedom: float) -> float:
    """Return half the confidence interval of Student's t in standard errors, of some degrees of freedom."""
    return float(stdtrit(freedom, 0.5 + CONFIDENCE / 2))  # scipy.stats alone takes half a second to import


def batch_means(run: xr.Dataset, window: tuple[float, float], length: float) -> FloatArray:
    """Return the mean absorbed power of each batch of a run, shape (batch,) [W].

    Parameters
    ----------
    run : xarray.Dataset
        See `vsb.integrators.trajectory.recorded`.
    window : tuple of float [s]
        Cut into as many equal batches as fit, at least one.
    length : float
        Least length of a batch [s].
    """
    start, end = window
    edges = np.linspace(start, end, max(1, int((end - start) / length + 1e-9)) + 1)
    energy = CubicSpline(run.time.values, run.energy.sel(term="pto").values)(edges)
    return np.asarray(np.diff(energy) / np.diff(edges))


def families(study: Compared) -> dict[str, list[Irregular]]:
    """Return the irregular seas of a study, realisations of one sea together, by the name without seed."""
    found: dict[str, list[Irregular]] = {}
    for wave in study.waves:
        if isinstance(wave, IrregularSea):
            found.setdefault(wave.family, []).append(wave)
    return found


class Sample(NamedTuple):
    """What statistics keep of a run in an irregular sea."""

    batches: FloatArray  # mean power of each (batch,) [W]
    linear: float  # mean power linear theory predicts [W]


def sample(study: Compared, wave: Irregular, design: str, run: xr.Dataset, sea: Sea, response: xr.Dataset) -> Sample:
    """Return what statistics keep of the run of a design in a realisation of a sea."""
    if LINEARISED in run.attrs:
        linear = float(run.attrs[LINEARISED])
    else:
        linear = linear_power(power_response(study, in_direction(response, wave), design, run.attrs), sea)
    return Sample(batch_means(run, study.simulation.window, wave.memory), linear)


def statistics(study: Compared, samples: Mapping[tuple[str, str], Sample]) -> list[Line]:
    """Return one line per design and irregular sea.

    Parameters
    ----------
    study : Study
    samples : mapping (design, wave label) -> Sample
    """
    lines = []
    for name, waves in families(study).items():
        means = {d: np.concatenate([samples[d, w.label].batches for w in waves]) for d in study.designs}
        base = means.get(study.reference_design or "")  # has no gain over itself
        for design, batches in means.items():
            predicted = float(np.mean([samples[design, w.label].linear for w in waves]))
            gain = gain_percent(batches, None if design == study.reference_design else base)
            lines.append(Line(design, name, len(waves), len(batches), *interval(batches), predicted, *gain))
    return lines


def linear_power(power: xr.DataArray, sea: Sea) -> float:
    """Return the mean power linear theory predicts, sum of P(omega) |a|^2 over the components [W]."""
    return float(sea.mean_of(CubicSpline(power.omega.values, power.values)(sea.omega)))


def gain_percent(batches: FloatArray, base: FloatArray | None) -> tuple[float | None, float | None, float | None]:
    """Return the gain of mean power over the reference and its interval [%]; nothing over nothing."""
    if base is None or not base.sum() > 0:
        return None, None, None
    estimate = ratio_interval(batches, base)
    low, high = (None if bound is None else 100 * (bound - 1) for bound in estimate[1:])
    return 100 * (estimate.mean - 1), low, high


def statistical_checks(study: Compared, lines: Sequence[Line]) -> list[Check]:
    """Return whether records are long enough for the power they give, and agree with the spectral prediction."""
    checks = []
    for line in lines:
        where = {"design": line.design, "wave": line.sea}
        if line.power_low is None or line.power_high is None:
            text = f"{line.batches} batches, of ten peak periods or more, give no confidence interval: lengthen "
            text += "simulation.duration and window, or ask for more realisations"
            checks.append(
                check_at_most("record_length", FEWEST_BATCHES / line.batches, 1.0, "-", text, doubt=True, **where)
            )
            continue
        half = 0.5 * (line.power_high - line.power_low)
        share, text = _sharpness(line, [other for other in lines if other.sea == line.sea])
        checks.append(check_at_most("statistical_error", share, 0.1, "-", text, doubt=True, **where))
        if study.hydro.model == "linear" and half:
            apart = abs(line.power_mean - line.power_linear) / half
            text = f"distance from the spectral prediction, {plain(line.power_linear)} W, in halves of the interval"
            checks.append(check_at_most("spectral_prediction", apart, 1.5, "-", text, doubt=True, **where))
    return checks


def _sharpness(line: Line, sea: Sequence[Line]) -> tuple[float, str]:
    """Relative error of what is asked, and its words: of gains in the same waves, if they are known; else of power."""
    low, mean, high = line.power_low or 0.0, line.power_mean, line.power_high or 0.0
    share = 0.5 * (high - low) / abs(mean) if mean else 0.0
    gains = [_half_gain(one) for one in ([line] if line.gain_low is not None else sea)]
    known = [half for half in gains if half is not None]
    if not known:
        return share, f"half the 95 % confidence interval of mean power, {plain(mean)} W, over it"
    text = f"half the 95 % confidence interval of the gain in the same waves; that of mean power is {100 * share:.2g} %"
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
