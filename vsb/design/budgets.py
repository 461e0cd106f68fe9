"""Error budgets of the annual mean power of buoys, and of the gain of one over another, from the same parts.

The parts of a buoy are its power computed in other ways under the same damper: more finely, through the points of a
profile by another curve, in every sea of the year by itself, and its slope by every uncertain input. What two buoys
have in common cancels in their gain. Linear theory itself is not among the parts: runs in time say how far it is off.
A power is the mean over the year of the climate, here as in a campaign; how other years of the site would differ is not
an error of it, and said beside.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from scipy.integrate import quad

from vsb.design.compared import Buoy, gain
from vsb.design.evaluation import RESOLVED, DesignModel
from vsb.design.problem import POWER, depends, objective
from vsb.design.take_offs import SeveralYear
from vsb.design.year import PortYear, band
from vsb.engine.motion.causal import GridError
from vsb.engine.shell.meridian import also_through
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.water import power_limit
from vsb.results.budget import MODES, NUMERICAL, Budget, Source
from vsb.study.design import DIVISORS, OF_RIGID, Objective
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

SAFETY = 2.0
"""Of the change by finer nodes and frequencies, or by another curve through a profile, for the error of those used."""
DEVIATIONS = 1.96
"""Standard deviations to the end of a 95 % interval."""
BLOCK_DAYS, RESAMPLED = 7.0, 2000
"""Length of the blocks of a year that are drawn again, in which seas belong together [days], and years drawn."""
POINTS = 97
"""Of a profile that stands for the other curve through the points of one."""
YEAR = "the year as a sample"
LINEAR_THEORY = "linear theory"


@dataclass(frozen=True)
class Uncertainty:
    """Sources of error of a number, in its unit, and those that are not known."""

    budget: Budget
    unknown: tuple[str, ...] = ()  # and what is known of another number, such as of other years


@dataclass(frozen=True)
class PowerParts:
    """What the errors of one buoy's annual mean power are made of."""

    power: float  # [W]
    truncation: tuple[float, float] | None  # by shell modes left out, relative: at most 0, at least 0; None: not known
    finer: float  # the same power, computed more finely [W]
    reshaped: float  # with the other curve through the points of a profile [W]; the power itself of other shapes
    unsolved: float  # most that waves above the frequencies solved may add [W]
    years: FloatArray | None  # of years drawn again (year,) [W]; None of a table of seas, which has no order
    slopes: Mapping[str, float]  # d ln P/d ln of uncertain inputs [-]
    grid: GridError = field(default_factory=GridError)  # by that of a causal controller, of the finer power


def power_parts(
    buoy: Buoy,
    climate: Climate,
    uncertain: Sequence[str] = (),
    *,
    ordered: bool = False,
    maximise: Objective = POWER,
    cost: Mapping[str, float] | None = None,
) -> PowerParts:
    """Return the parts of the errors of a buoy's annual mean power, or of that over what it is divided by.

    The divisor is known as well as the design is; it changes with uncertain inputs, finer nodes and shapes. A force
    grows and falls with the power: what shell modes leave out of their quotient is less than what they do of the power.

    Parameters
    ----------
    uncertain : sequence of str
        Keys of its device.
    ordered : bool
        Whether the seas of the climate stand in the order of the year.
    maximise : str
        `annual_mean_power`, or a quotient such as `power_per_mass`.
    cost : mapping
        Prices by the quantity they are of.
    """
    built, keys = buoy.with_damper(), [key for key in uncertain if depends(buoy.study, key)]
    model = replace(built.model(climate, keys), cost=cost or {})
    over = buoy.quantities[DIVISORS[maximise]] if maximise in DIVISORS else 1.0
    finer = replace(model, variables=model.variables[len(keys) :]).finer
    slopes = dict.fromkeys(uncertain, 0.0)
    if keys:
        found = objective(model.at(model.point), maximise)
        slopes |= dict(zip(keys, map(float, found.gradient * model.point / found.value), strict=False))
    return PowerParts(
        power=buoy.power / over,
        truncation=buoy.truncation,
        finer=_value(finer, maximise),
        reshaped=_reshaped(built, climate, maximise, cost or {}),
        unsolved=_unsolved(buoy.study, climate) / over,
        years=drawn_years(power_of_seas(built, model, climate), climate.hours) if ordered else None,
        slopes=slopes,
        grid=built.controlled(finer).grid_error if built.control else GridError(),
    )


def _value(model: DesignModel, maximise: Objective) -> float:
    """What is maximised of the study of a model."""
    return objective(model.at(model.point), maximise).value


def _reshaped(built: Buoy, climate: Climate, maximise: Objective, cost: Mapping[str, float]) -> float:
    """The same with the other curve through the points of a profile; as it is without a profile."""
    device = built.study.device
    if device.shape is None or device.shape.profile is None:
        return built.power / (built.quantities[DIVISORS[maximise]] if maximise in DIVISORS else 1.0)
    other = also_through(device.shape.profile, device.radius)
    curve = [other.at(float(phi)) for phi in np.linspace(0.0, np.pi, POINTS)]
    shape = device.shape.model_copy(update={"profile": tuple((float(x), float(z)) for x, z, *_ in curve)})
    study = built.study.model_copy(update={"device": device.model_copy(update={"shape": shape})})
    return _value(replace(replace(built, study=study).model(climate), cost=cost), maximise)


def _unsolved(study: Study, climate: Climate) -> float:
    """Most that waves above the highest frequency solved can add [W]: capture width is at most wavelength/(2 pi)."""
    water, high = study.water, band(climate, study.hydro.omega_max)[1]
    total = 0.0
    for low, end, density in zip(climate.edges[:-1], climate.edges[1:], climate.mean_density, strict=True):
        if density > 0 and end > high:
            of = quad(lambda w: power_limit(w, water.depth, water.density, water.gravity), max(low, high), end)[0]
            total += 2 * float(density) * of
    return total


def power_of_seas(buoy: Buoy, model: DesignModel, climate: Climate) -> FloatArray:
    """Return the mean power of a buoy in each sea under its take-off of the year, shape (sea,) [W].

    The mean over the bands of the climate of c w^2 |u|^2, times the variance of each sea in them.

    Parameters
    ----------
    model : DesignModel
        Of the buoy over the climate: its nodes and frequencies are used.
    """
    motion, lost, omega = buoy.motion(model), 0.0, model.grid.omega
    if buoy.control:
        omega, absorbed, lost = buoy.controlled(model).absorbed
    elif buoy.study.pto.several:
        damper = buoy.quantities.get("damping", 0.0)
        absorbed = SeveralYear(motion).absorbed(
            damper * np.eye(len(motion.rows)) if buoy.dampers is None else np.array(buoy.dampers)
        )
    elif buoy.study.pto.efficiency < 1:
        return model.converted(buoy.study, PortYear(motion)).of_seas(buoy.quantities["damping"])
    else:
        absorbed = PortYear(motion).absorbed(buoy.quantities["damping"])
    of_band = np.histogram(omega, climate.edges, weights=absorbed)[0]
    mean = climate.mean_density
    return np.asarray(climate.density @ np.divide(of_band, mean, out=np.zeros_like(mean), where=mean > 0) - lost)


def drawn_years(power: FloatArray, hours: FloatArray) -> FloatArray:
    """Return the mean power of years of blocks drawn from one year in the order of its seas, shape (year,) [W].

    The circular block bootstrap of Politis and Romano (1992), which keeps the persistence of seas; all buoys meet the
    same years.

    Parameters
    ----------
    power : ndarray, shape (sea,)
        In each sea [W].
    hours : ndarray, shape (sea,)
        Share of the year of each.
    """
    seas = len(hours)
    length = max(1, min(seas, round(BLOCK_DAYS / 365.25 * seas)))
    begins = np.random.default_rng(1).integers(0, seas, (RESAMPLED, -(-seas // length)))
    sums = [
        np.convolve(np.concatenate([values, values[: length - 1]]), np.ones(length), mode="valid")
        for values in (power * hours, hours)
    ]
    energy, time = (one[begins].sum(axis=1) for one in sums)
    return np.asarray(energy / time)


def uncertainty(buoys: Sequence[PowerParts], uncertain: Mapping[str, float] | None = None) -> Uncertainty:
    """Return what a power is uncertain by [W], of two buoys the gain of the first over the second [percentage points].

    Parameters
    ----------
    buoys : sequence of PowerParts
        One or two.
    uncertain : mapping
        Relative standard deviations of inputs.
    """
    of: Callable[..., float] = gain if len(buoys) == 2 else lambda power: power
    powers = [one.power for one in buoys]
    value = of(*powers)
    weights = [100 * powers[0] / powers[1] * sign for sign in (1, -1)] if len(buoys) == 2 else powers  # d value/d ln P
    sources: list[Source] = []
    unknown = [MODES] if any(one.truncation is None for one in buoys) else []
    ends = [
        sorted(weight * end for end in one.truncation)
        for weight, one in zip(weights, buoys, strict=True)
        if one.truncation
    ]
    if any(any(pair) for pair in ends):
        sources.append(Source(MODES, sum(low for low, _ in ends), sum(high for _, high in ends)))
    change = abs(of(*(one.finer for one in buoys)) - value)
    least = RESOLVED * sum(map(abs, weights))  # nodes and frequencies aim at no less
    sources.append(Source.within("coefficients and quadrature", max(SAFETY * change, least)))
    of_grid = buoys[0].grid.over(buoys[1].grid) if len(buoys) == 2 else buoys[0].grid
    if of_grid.size:
        sources.append(Source.within(NUMERICAL, weights[0] * of_grid.size))
    if change := of(*(one.reshaped for one in buoys)) - value:
        sources.append(Source.within("shape between the points of the profile", SAFETY * abs(change)))
    if any(one.unsolved for one in buoys):
        corners = [of(*powers) - value for powers in product(*((one.power, one.power + one.unsolved) for one in buoys))]
        sources.append(Source("waves above the frequencies solved", min(corners), max(corners)))
    years, unit = [one.years for one in buoys if one.years is not None], "points" if len(buoys) == 2 else "W"
    if len(years) == len(buoys):
        low, high = np.quantile(of(*years), [0.025, 0.975]) - value
        unknown.append(f"{YEAR} ({low:+.3g} to {high:+.3g} {unit} in 95 % of years like it)")
    else:
        unknown.append(f"{YEAR} (a table has no order of its seas)")
    for key, share in (uncertain or {}).items():
        slope = sum(weight * one.slopes[key] for weight, one in zip(weights, buoys, strict=True))
        sources.append(Source.within(key, DEVIATIONS * share * abs(slope), "statistic", shared=key in OF_RIGID))
    return Uncertainty(Budget(tuple(sources)), tuple(unknown))


def with_linear_theory(known: Uncertainty, value: float, low: float, high: float) -> Uncertainty:
    """Return an uncertainty with what linear theory errs by, as runs in time say: their interval of the same number."""
    source = Source(LINEAR_THEORY, min(0.0, low - value), max(0.0, high - value))
    return Uncertainty(known.budget + Budget((source,)), known.unknown)
