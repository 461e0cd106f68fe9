"""The best flexible buoy beside rigid ones, the gain over the best of them, and what it is uncertain by.

Three rigid buoys separate size from flexibility: the competitor, optimised in every variable it has, under the same
limits; the twin, of the flexible one's rest shape and mass; the sphere before it was inflated. The last two have the
take-off that is optimal within the limits of the problem.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.integrate import cumulative_trapezoid

from vsb.design.evaluation import DAMPER, DesignModel
from vsb.design.linearised import linearised
from vsb.design.optimise import optimised
from vsb.design.problem import IMPOSSIBLE, POWER, Problem
from vsb.design.resting import RestingBuoy
from vsb.design.searched import Outcome, study_of
from vsb.design.year import PortYear
from vsb.results.budget import MODES, Budget, Source
from vsb.study.specs import DesignSpec, Search
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray
from vsb.waves.climate import Climate

FLEXIBLE, COMPETITOR, TWIN, SPHERE = "flexible", "rigid competitor", "rigid twin", "undeformed sphere"
"""Names of the buoys compared."""
OF_TAKE_OFF = ("force_rms", "stroke_rms", "spring_pull")
"""Limits that a take-off can meet."""
SAFETY = 2.0
"""Of the change by finer nodes and frequencies, for the error of those used."""
DEVIATIONS = 1.96
"""Standard deviations to the end of a 95 % interval."""
BLOCK_DAYS, RESAMPLED = 7.0, 2000
"""Length of the blocks of a year that are drawn again, in which seas belong together [days], and years drawn."""
SHAPE_POINTS = 181


@dataclass(frozen=True)
class Buoy:
    """One of the buoys compared."""

    name: str
    study: Study  # with all its values
    design: str
    degree: int | None
    quantities: Mapping[str, float]

    @property
    def power(self) -> float:
        """Annual mean power [W]."""
        return self.quantities[POWER]

    @cached_property
    def resting(self) -> RestingBuoy:
        """The buoy where it rests."""
        return RestingBuoy.of(self.study, self.degree or 1)

    @property
    def outline(self) -> tuple[FloatArray, FloatArray]:
        """Radius and height of the hull over colatitude, each shape (colatitude,) [m]."""
        at = self.resting.shape.curve(np.linspace(0.0, np.pi, SHAPE_POINTS))
        return np.asarray(at.x), np.asarray(at.z)

    @property
    def displacement_held(self) -> float:
        """How far it can be displaced before a spring below zero holds it there [m], see `displacement_held`."""
        water = self.study.water
        return displacement_held(self.outline, water.density, water.gravity, self.study.pto.stiffness)

    def model(self, climate: Climate, variables: Sequence[str] = ()) -> DesignModel:
        """Return its model in some variables and its damper."""
        return DesignModel.of(self.study, self.design, climate, [*variables, DAMPER], self.degree)

    def with_damper(self) -> "Buoy":
        """Return the same with the damper it has been found with given."""
        pto = self.study.pto.model_copy(update={"damping": self.quantities["damping"], "tuning": "fixed"})
        return replace(self, study=self.study.model_copy(update={"pto": pto}))


def buoy_of(name: str, search: Search, found: Outcome) -> Buoy:
    """Return the buoy a search has found."""
    return Buoy(name, study_of(search, found.degree, found.point), search.design, found.degree, found.quantities)


def twin(spec: DesignSpec, climate: Climate, found: Outcome) -> Buoy | None:
    """Return the rigid buoy of the flexible one's rest shape and mass; None if it cannot be."""
    search = spec.flexible.model_copy(update={"design": spec.rigid.design, "maximise": POWER})
    return _with_take_off(TWIN, search, climate, found)


def sphere(spec: DesignSpec, climate: Climate, found: Outcome) -> Buoy | None:
    """Return the rigid sphere of the flexible one's undeformed radius and its mass; None if it sinks."""
    search = spec.rigid.model_copy(update={"variables": spec.flexible.variables, "maximise": POWER})
    return _with_take_off(SPHERE, search, climate, replace(found, degree=None))


def _with_take_off(name: str, search: Search, climate: Climate, found: Outcome) -> Buoy | None:
    """A rigid buoy with the take-off that is best within the limits."""
    free = tuple(one for one in search.variables if one.key.startswith("pto."))
    point = {key: value for key, value in found.point.items() if key.startswith("device.")}
    try:
        study = study_of(search, found.degree, point)
        keys = [one.key for one in free]
        model = DesignModel.of(study, search.design, climate, keys, found.degree)
        limits = {key: value for key, value in search.limits.items() if key in OF_TAKE_OFF}
        problem = Problem(model, free, POWER, limits, {}, flexible=False)
        place = problem.place([found.point[key] for key in keys])
        end = optimised(problem, problem.at(place))
        values = dict(zip(keys, map(float, end.point.values), strict=True))
        quantities = {key: one.value for key, one in end.point.evaluation.quantities.items()}
        return Buoy(name, study_of(search, found.degree, point | values), search.design, found.degree, quantities)
    except IMPOSSIBLE:
        return None


def displacement_held(outline: tuple[FloatArray, FloatArray], density: float, gravity: float, spring: float) -> float:
    """Return how far a hull can be displaced from rest, in still water, before a spring below zero holds it there [m].

    Upwards or downwards, whichever is less; inf for a spring of zero or above. With V the volume under water, the
    water brings it back while rho g |V(s) - V(0)| > -k |s|: its change is bounded, by leaving the water or by
    submergence, and the force of the spring is not.

    Parameters
    ----------
    outline : (ndarray, ndarray)
        Radius and height of the hull at rest, from the top to the bottom, each shape (point,) [m].
    density, gravity : float
        Of the water [kg/m^3], and [m/s^2].
    spring : float
        Stiffness [N/m].
    """
    if spring >= 0:
        return np.inf
    radius, height = outline[0][::-1], outline[1][::-1]
    below = cumulative_trapezoid(np.pi * radius**2, height, initial=0)
    at_rest = float(np.interp(0.0, height, below))
    ends = [density * gravity * most / -spring for most in (at_rest, below[-1] - at_rest)]
    found = []
    for sign, end in zip((1.0, -1.0), ends, strict=True):
        moved = np.linspace(0.0, end, SHAPE_POINTS**2)[1:]
        change = np.abs(np.interp(-sign * moved, height, below) - at_rest)
        lost = density * gravity * change <= -spring * moved
        found.append(float(moved[np.argmax(lost)]) if lost.any() else end)
    return min(found)


def gain(flexible: float, rigid: float) -> float:
    """Return the gain of a power over another [%]."""
    return 100 * (flexible / rigid - 1)


def power_of_seas(buoy: Buoy, climate: Climate) -> FloatArray:
    """Return the mean power of a buoy in each sea under its damper of the year, shape (sea,) [W].

    The mean over the bands of the climate of c w^2 |u|^2, times the variance of each sea in them.
    """
    model = buoy.model(climate)
    matrices = linearised(buoy.resting, buoy.design, [], model.grid.solved, model.nodes)
    port, damper = PortYear.of(model.grid, *matrices, buoy.study.pto.stiffness), buoy.quantities["damping"]
    omega = model.grid.omega
    moved = port.motion / (1 - 1j * omega * damper * port.receptance)
    absorbed = damper * omega**2 * np.abs(moved) ** 2 * model.grid.variance
    band = np.searchsorted(climate.edges, omega, side="right") - 1
    of_band = np.bincount(band, absorbed, minlength=len(climate.omega))
    mean = climate.mean_density
    return np.asarray(climate.density @ np.divide(of_band, mean, out=np.zeros_like(mean), where=mean > 0))


def gain_of_years(flexible: FloatArray, rigid: FloatArray, hours: FloatArray, seed: int = 1) -> FloatArray:
    """Return the gain over years of blocks drawn from one year in the order of its seas, shape (year,) [%].

    The circular block bootstrap of Politis and Romano (1992), which keeps the persistence of seas; both buoys meet the
    same years.

    Parameters
    ----------
    flexible, rigid : ndarray, shape (sea,)
        Mean power of both in each sea [W].
    hours : ndarray, shape (sea,)
        Share of the year of each.
    """
    seas = len(hours)
    length = max(1, min(seas, round(BLOCK_DAYS / 365.25 * seas)))
    begins = np.random.default_rng(seed).integers(0, seas, (RESAMPLED, -(-seas // length)))
    sums = [
        np.convolve(np.concatenate([values, values[: length - 1]]), np.ones(length), mode="valid")
        for values in (flexible * hours, rigid * hours)
    ]
    drawn = [one[begins].sum(axis=1) for one in sums]
    return np.asarray(100 * (drawn[0] / drawn[1] - 1))


@dataclass(frozen=True)
class Uncertainty:
    """Sources of error of the gain over the best rigid buoy, in percentage points, and those that are not known."""

    budget: Budget
    unknown: tuple[str, ...] = ()


def numerical_errors(
    climate: Climate, flexible: Buoy, rigid: Buoy, truncation: tuple[float, float] | None
) -> Uncertainty:
    """Return bounds of the numerical error of the gain of a buoy over a rigid one, each under its damper.

    Parameters
    ----------
    truncation : (float, float), optional
        Changes of the power by all further degrees of shell modes, relative (`vsb.design.optimise.left_out`).
    """
    finer = [one.with_damper().model(climate).finer for one in (flexible, rigid)]
    powers = [model.at(model.point)[POWER].value for model in finer]
    change = gain(*powers) - gain(flexible.power, rigid.power)
    found = Source.within("coefficients and quadrature", SAFETY * abs(change))
    if truncation is None:
        return Uncertainty(Budget((found,)), (MODES,))
    low, high = (100 * flexible.power / rigid.power * one for one in truncation)
    return Uncertainty(Budget((Source(MODES, low, high), found)))


def uncertainty(
    spec: DesignSpec, climate: Climate, flexible: Buoy, rigid: Buoy, truncation: tuple[float, float] | None
) -> Uncertainty:
    """Return what the gain is uncertain by, linear theory itself apart; parameters as of `numerical_errors`."""
    numerical = numerical_errors(climate, flexible, rigid, truncation)
    found, unknown = list(numerical.budget.sources), list(numerical.unknown)
    value, ratio = gain(flexible.power, rigid.power), 100 * flexible.power / rigid.power
    if spec.flexible.climate.form == "spectra":
        years = gain_of_years(power_of_seas(flexible, climate), power_of_seas(rigid, climate), climate.hours)
        low, high = np.quantile(years, [0.025, 0.975])
        found.append(Source("the year as a sample", min(0.0, low - value), max(0.0, high - value), "statistic"))
    else:
        unknown.append("the year as a sample: a table has no order of its seas")
    for key, share in spec.uncertain.items():
        slopes = [_log_slope(one, climate, key) for one in (flexible, rigid)]
        change = DEVIATIONS * share * ratio * abs(slopes[0] - slopes[1])
        found.append(Source.within(key, change, "statistic", shared=key in ("device.radius", "device.mass")))
    return Uncertainty(Budget(tuple(found)), tuple(unknown))


def _log_slope(buoy: Buoy, climate: Climate, key: str) -> float:
    """Slope d ln P / d ln of an input of a buoy as built, its damper kept."""
    built = buoy.with_damper()
    if not built.study.designs[built.design].flexible and key not in ("device.radius", "device.mass"):
        return 0.0
    model = built.model(climate, [key])
    found = model.at(model.point)[POWER]
    return float(found.gradient[0] * model.point[0] / found.value)
