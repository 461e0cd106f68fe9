"""A design problem as an optimiser sees it: variables between 0 and 1, objective and limits without units.

With x the variables scaled to their bounds, f(x) = -objective / scale is minimised subject to g(x) <= 0, where
g = q/L - 1 for a quantity q limited from above by L. The load factor 1/kappa is limited from below: g = L kappa - 1 for
the largest kappa, which are smooth where the load factor passes through infinity. What every buoy must keep (a thin
wall that is no heavier than the buoy, a draft) is g = ln(share), see `vsb.study.feasible.shares`, linear in logarithms.
With margins (1 + g) f - 1 <= 0, f >= 1, a buoy keeps away from its limits by what shell modes left out and uncertain
inputs may change.

Margins of limits: what shell modes left out, and inputs that are uncertain, may change a limited quantity by.

An optimiser goes to the limits. Where shell modes beyond those of its basis, or a wall as it is built, strain the shell
more, a buoy that meets a limit exactly exceeds it. With g the excess over a limit, relative to it, a buoy holds if
g + m <= 0 with m = m_modes + k sigma: m_modes the most that further shell modes add (`by_modes`), sigma the standard
deviation of g by the uncertain inputs, sigma^2 = sum (dg/d ln p s)^2 to first order (`spread`), k how many of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, Protocol

import numpy as np

from vsb.design.evaluation import DAMPER, DesignModel, Evaluation, Quantity
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.models.mode_convergence import by_all_modes
from vsb.study.design import DIVISORS, OF_RIGID, OF_WAVES, PARTS, Objective, Variable, limit_of
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

POWER: Literal["annual_mean_power"] = "annual_mean_power"
"""Name of a quantity, and of an objective."""
INVERSE_LOAD_FACTOR = "load_factor_inverse"
"""What the names of the largest inverse load factors begin with, numbered from 0."""
SPARE = 1e-6
"""By which a buoy keeps from the limits every buoy has: a study at them is refused."""
STEP = 1e-5
"""Of a central difference of the shares of those limits, relative: its error is 1e-10."""
SMALLEST = 1e-300
"""Least scale of an objective."""
IMPOSSIBLE = (ConfigError, ConvergenceError, StabilityError, np.linalg.LinAlgError)
"""What an evaluation raises where there is no such buoy: the shell has no stable rest shape, or the buoy sinks."""


class Model(Protocol):
    """What evaluates a buoy: `vsb.design.evaluation.DesignModel`."""

    def at(self, values: Sequence[float]) -> Evaluation:
        """Return the quantities of a buoy at values of the variables, with their derivatives."""


def objective(found: Evaluation, maximise: Objective, reference: Evaluation | None = None) -> Quantity:
    """Return what is maximised: annual mean power, over a quantity, or over the power of a reference.

    Parameters
    ----------
    maximise : {'annual_mean_power', 'gain', 'power_per_force', 'power_per_mass', 'power_per_surface', 'power_per_cost'}
    reference : Evaluation, optional
        The rigid buoy of the same shape and mass, which `gain` needs: the term is 1 + gain.
    """
    power = found[POWER]
    if maximise == POWER:
        return power
    return power / (reference[POWER] if reference else found[DIVISORS[maximise]])


def excesses(found: Evaluation, limits: Mapping[str, float]) -> list[Quantity]:
    """Return the excesses g of a buoy over limits, relative to them, with their derivatives: of the parts of each."""
    terms = []
    for name, limit in limits.items():
        if name == "load_factor":
            parts = [found[f"{INVERSE_LOAD_FACTOR}_{i}"] for i in range(4)]
            terms += [Quantity(limit * one.value - 1, limit * one.gradient) for one in parts]
        else:
            parts = [found[part] for part in PARTS.get(name, (name,))]
            terms += [Quantity(one.value / limit - 1, one.gradient / limit) for one in parts]
    return terms


def limit_parts(limits: Mapping[str, float]) -> list[str]:
    """Return the names of the parts of limits in the order of `excesses`."""
    return [part for name in limits for part in PARTS.get(name, (name,))]


@dataclass(frozen=True)
class Point:
    """A buoy as the optimiser sees it: objective f and its gradient, excess g over limits and its Jacobian."""

    place: FloatArray  # of each variable between its bounds, 0 to 1
    values: FloatArray
    objective: float  # with its unit
    cost: float  # f
    slope: FloatArray  # df/dx
    excess: FloatArray  # g, shape (limit,)
    jacobian: FloatArray  # dg/dx, shape (limit, variable)
    evaluation: Evaluation

    @property
    def violation(self) -> float:
        """Largest excess over a limit, relative to it; 0 within all."""
        return float(max(0.0, *self.excess)) if self.excess.size else 0.0


Known = tuple[Evaluation, Evaluation | None]
"""A buoy, and the rigid one its gain is over."""


@dataclass(frozen=True)
class Problem:
    """A design problem in scaled variables, which remembers its evaluations."""

    model: Model
    variables: tuple[Variable, ...]
    maximise: Objective
    limits: Mapping[str, float]  # by name, as in a design file
    shares: Callable[[FloatArray], Mapping[str, float]] | None = None  # values -> those of limits of every buoy
    twin: Model | None = None  # the rigid buoy of the same shape and mass, which the gain is over
    scale: float = 1.0  # of the objective
    margins: FloatArray | None = None  # f (limit,); none: 1
    resting: Model | None = None  # what it is at rest, without waves
    sloped: bool = True  # else of values alone, see `valued`
    known: dict[bytes, Known | Exception] = field(default_factory=dict)  # evaluations by place

    @property
    def limit_names(self) -> list[str]:
        """Names of the limits in the order of the excesses; of the load factor one for each of the largest kappa."""
        return [*limit_parts(self.limits), *self.bounding(np.full(len(self.variables), 0.5))]

    def values(self, place: FloatArray) -> FloatArray:
        """Return the values of the variables at a place."""
        return np.array([one.value(float(x)) for one, x in zip(self.variables, place, strict=True)])

    def place(self, values: Sequence[float]) -> FloatArray:
        """Return the place of values, those out of bounds moved to them."""
        return np.array([one.scaled(one.clipped(v)) for one, v in zip(self.variables, values, strict=True)])

    def at(self, place: FloatArray) -> Point:
        """Return a buoy.

        Raises `ConvergenceError`, `ConfigError` or `StabilityError` where there is no such buoy at rest.
        """
        place = np.array(place, dtype=float)
        key = place.tobytes()
        if not self.sloped and key not in self.known:
            key += b"values alone"
        if key not in self.known:
            values = [float(value) for value in self.values(place)]
            try:
                self.known[key] = self.model.at(values), self.twin.at(values) if self.twin else None
            except IMPOSSIBLE as error:
                self.known[key] = error
        found = self.known[key]
        if isinstance(found, Exception):
            raise found
        return self._point(place, *found)

    @property
    def evaluations(self) -> int:
        """Number of buoys evaluated so far, those that do not rest among them."""
        return len(self.known)

    @property
    def at_rest(self) -> "Problem | None":
        """The problem of its limits at rest, without waves and objective; None if what it is at rest is not known."""
        if self.resting is None:
            return None
        limits = {name: limit for name, limit in self.limits.items() if limit_of(name) not in OF_WAVES}
        return replace(self, model=self.resting, limits=limits, twin=None, margins=None, known={})

    @property
    def valued(self) -> "Problem":
        """The same problem of values alone: where derivatives are not known, those by the device are zero."""

        def of(model: Model) -> Model:
            return replace(model, sloped=False) if isinstance(model, DesignModel) else model

        return replace(self, model=of(self.model), twin=self.twin and of(self.twin), sloped=False)

    def rescaled(self, point: Point) -> "Problem":
        """Return the same problem with its objective scaled to that of a point."""
        return replace(self, scale=max(abs(point.objective), SMALLEST))

    def _point(self, place: FloatArray, found: Evaluation, twin: Evaluation | None) -> Point:
        """A buoy, evaluated."""
        values = self.values(place)
        slopes = np.array([one.slope(float(v)) for one, v in zip(self.variables, values, strict=True)])
        waves = POWER in found.quantities
        aim = objective(found, self.maximise, twin) if waves else Quantity(0.0, np.zeros(len(values)))
        terms = [*excesses(found, self.limits), *self.bounding(place).values()]
        margins = np.ones(len(terms)) if self.margins is None else self.margins
        excess = margins * np.array([1 + term.value for term in terms]) - 1
        jacobian = np.array([term.gradient for term in terms]).reshape(len(terms), len(values)) * slopes
        jacobian = margins[:, None] * jacobian
        cost, slope = -aim.value / self.scale, -aim.gradient * slopes / self.scale
        if not all(np.isfinite(part).all() for part in (cost, slope, excess, jacobian)):
            raise ConvergenceError("a quantity of the buoy, or a derivative, is not finite")
        return Point(place, values, aim.value, cost, slope, excess, jacobian, found)

    def bounding(self, place: FloatArray) -> dict[str, Quantity]:
        """Return the excesses over the limits of every buoy by name, with derivatives by values."""
        if self.shares is None:
            return {}
        values, shares = self.values(place), self.shares
        steps = np.diag([STEP * (abs(v) or one.high - one.low) for one, v in zip(self.variables, values, strict=True)])
        here, ends = shares(values), [(shares(values + step), shares(values - step)) for step in steps]
        sizes = 2 * steps.sum(axis=1)
        return {
            name: Quantity(
                float(np.log(share) + SPARE),
                np.array([(ahead[name] - behind[name]) for ahead, behind in ends]) / sizes / share,
            )
            for name, share in here.items()
        }


DRAWS = 100_000
"""Buoys drawn for the probability that all limits hold together."""
ROUND_OFF = 1e-8
"""Excess over a limit, relative to it, that is none."""


def by_modes(changes: Sequence[FloatArray]) -> FloatArray:
    """Return the most by which shell modes left out may raise excesses over limits, 0 or more, shape (limit,).

    Parameters
    ----------
    changes : sequence of ndarray
        Of the excesses from a basis to each of some with more degrees, ascending; none, as of a rigid sphere, are none.
    """
    if not changes:
        return np.zeros(())
    none = np.zeros_like(changes[0])
    return np.asarray(by_all_modes(none, [none, *changes])[..., 1])


def depends(study: Study, key: str) -> bool:
    """Return whether a buoy has an input at all: a rigid one that stays a sphere has only its size and mass."""
    return study.flexible or key in OF_RIGID


def spread(
    model: DesignModel, study: Study, damping: float | None, limits: Mapping[str, float], shares: Mapping[str, float]
) -> FloatArray:
    """Return what one standard deviation of each uncertain input changes excesses over limits, shape (part, input).

    The buoy keeps the damper it was designed with; a causal controller is that of the buoy as built.

    Parameters
    ----------
    model : DesignModel
        Whose nodes and frequencies are used, and damper matrix of several ports.
    study : Study
        The buoy.
    damping : float, optional
        Its damper [N s/m]; none under causal control, and at several ports.
    limits, shares : mapping
        Limits, and relative standard deviations of inputs.
    """
    keys = [key for key in shares if depends(study, key)]
    if damping is not None:
        study = study.model_copy(update={"pto": study.pto.model_copy(update={"damping": damping, "tuning": "fixed"})})
    varied = tuple(keys) if damping is None else (*keys, DAMPER)
    built = replace(model, study=study, variables=varied, rests={})  # those known are of other studies
    terms = excesses(built.at(built.point), limits)
    sizes = np.array([shares[key] * value for key, value in zip(keys, built.point, strict=False)])
    return np.array([one.gradient[: len(keys)] * sizes for one in terms]).reshape(len(terms), len(keys))


def probabilities(excess: FloatArray, scatter: FloatArray, parts: Sequence[str]) -> dict[str, float]:
    """Return the probability that each limit holds of a buoy as it is built, and that all hold, under `all`.

    Inputs are normal and independent, excesses linear in them.

    Parameters
    ----------
    excess : ndarray, shape (part,)
        Of the buoy as designed, with what shell modes left out add.
    scatter : ndarray, shape (part, input)
        Of `spread`.
    parts : sequence of str
        Names of the parts.
    """
    drawn = np.random.default_rng(1).standard_normal((DRAWS, scatter.shape[1]))
    holds = excess + drawn @ scatter.T <= ROUND_OFF
    limits = [limit_of(part) for part in parts]
    found = {
        limit: float(holds[:, [one == limit for one in limits]].all(axis=1).mean()) for limit in dict.fromkeys(limits)
    }
    return {**found, "all": float(holds.all(axis=1).mean())}


Spread = Callable[[FloatArray], FloatArray]
"""Values of the variables -> `spread` at them, (part, input)."""
