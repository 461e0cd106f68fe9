"""Searches of a design file: the problem of a study in a climate, and where its starts ended, as files keep it."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np
import xarray as xr

import vsb.design.variables  # noqa: F401  registers them
from vsb.design.certificate import VIOLATION
from vsb.design.evaluation import DAMPER, SPRING, AtRest, DesignModel
from vsb.design.optimise import FURTHER, Converged, Finer, Optimum, Progress, converged, finer, start_places
from vsb.design.problem import IMPOSSIBLE, Point, Problem, spread
from vsb.design.resting import RestingBuoy, with_values
from vsb.engine.motion.causal import RmsLimits
from vsb.engine.waves.climate import Climate
from vsb.errors import ConvergenceError
from vsb.study.campaign import CAUSAL, study_at
from vsb.study.design import CONTROLLED, Variable
from vsb.study.feasible import shares
from vsb.study.resolution import expected_change
from vsb.study.specs import Search
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray


def study_of(search: Search, degree: int | None, point: Mapping[str, float] | None = None) -> Study:
    """Return the study of a search, with a degree of its shell modes and values of its variables."""
    base = dict(search.base)
    if degree is not None:
        base["modes"] = {**base.get("modes", {}), "basis": "full", "degree": degree}
    return study_at(base, dict(point or {}))


def problem_of(search: Search, climate: Climate, degree: int | None) -> Problem:
    """Return the problem of a search over a climate, with a degree of shell modes; none of a rigid buoy."""
    study, keys = study_of(search, degree), [one.key for one in search.variables]
    gain = search.maximise == "gain"
    twin = searching(search, study, climate, keys, degree, study.reference_design) if gain else None
    model = searching(search, study, climate, keys, degree)
    return Problem(
        model=model,
        variables=search.variables,
        maximise=search.maximise,
        limits=with_rest(search.kept, search.variables),
        shares=shares_of(study, keys),
        twin=twin,
        resting=AtRest(model),
    )


STEADIEST = 0.99
"""Share of its stiffness at most that a spring below zero may take from a buoy, so that it rests stably."""


def with_rest(limits: Mapping[str, float], variables: Sequence[Variable]) -> dict[str, float]:
    """Return limits with that of a spring that may be below zero."""
    below = any(one.key == SPRING and one.low < 0 for one in variables)
    return {**limits, **({"spring_share": STEADIEST} if below else {})}


def searching(
    search: Search,
    study: Study,
    climate: Climate,
    keys: Sequence[str],
    degree: int | None,
    design: str | None = None,
) -> DesignModel:
    """Return a model for a search, which looks beyond what bounds a buoy, and knows its cost; of its design if none."""
    model = DesignModel.of(study, design or search.design, climate, keys, degree, control_of(search))
    force = search.limits.get("force_rms", np.inf) if search.several else np.inf
    return replace(model, beyond=True, cost=search.cost, fatigue=search.fatigue, most_force=force)


def control_of(search: Search) -> RmsLimits | None:
    """Return the limits of causal control; none of a damper."""
    if search.tuning != CAUSAL:
        return None
    return RmsLimits(*(search.limits.get(name, np.inf) for name in CONTROLLED))


def shares_of(study: Study, keys: Sequence[str]) -> Callable[[FloatArray], Mapping[str, float]] | None:
    """Return what gives a buoy's shares of the limits every buoy has; None where the device does not vary."""
    of_device = [i for i, key in enumerate(keys) if key.startswith("device.")]
    if not of_device:
        return None

    @cache
    def found(*values: float) -> Mapping[str, float]:
        built = with_values(study, {keys[i]: value for i, value in zip(of_device, values, strict=True)})
        return shares(built.device, built.water, flexible=study.flexible)

    return lambda values: found(*map(float, values[of_device]))


def degrees_of(search: Search) -> Sequence[int | None]:
    """Return the degrees of shell modes to be tried; one of none for a rigid buoy."""
    return search.degrees or (None,)


def own_place(problem: Problem) -> FloatArray:
    """Return the place of the study's own buoy, moved into the bounds; with its optimal damper if it gives none."""
    model, variables = problem.model, problem.variables
    assert isinstance(model, DesignModel)
    keys = model.variables
    own = dict(zip(keys, model.point, strict=True))
    if own.get(DAMPER) == 0.0:
        others = tuple(key for key in keys if key != DAMPER)
        try:
            found = replace(model, variables=others, sloped=False).at([own[key] for key in others])
            own[DAMPER] = found["damping"].value
        except IMPOSSIBLE:
            own[DAMPER] = variables[keys.index(DAMPER)].value(0.5)
    return np.array([one.scaled(one.clipped(own[one.key])) for one in variables])


def places(problem: Problem, seed: int, start: int) -> list[FloatArray]:
    """Return the places a start tries in turn."""
    if not problem.variables:
        return [np.zeros(0)]
    return start_places(start, len(problem.variables), seed, None if start else own_place(problem))


def from_start(
    search: Search, climate: Climate, seed: int, start: int, seen: Progress, begin: "Outcome | None" = None
) -> Converged:
    """Return where a start ended, begun from where it ended under other limits, if given.

    Raises `ConvergenceError` if no buoy rests among the places it tried.
    """

    @cache
    def of(degree: int | None) -> Problem:
        return problem_of(search, climate, degree)

    degrees = degrees_of(search)
    tried, expected = places(of(degrees[0]), seed, start), partial(expected_of, search)
    if begin:
        tried.insert(0, of(degrees[0]).place(list(begin.values)))
    found = converged(of, degrees, search.tolerance, tried, seen, expected, uncertain_margins(search))
    return replace(found, optimum=judged_at_rest(search, found.optimum, found.degree))


def judged_at_rest(search: Search, end: Optimum, degree: int | None) -> Optimum:
    """Return an optimum, not accepted if its shell does not carry the load as that grows: its study would be refused.

    The search seeks the rest of a buoy from that of a close one.
    """
    if not end.accepted:
        return end
    keys = [one.key for one in search.variables]
    try:
        study = study_of(search, degree, dict(zip(keys, map(float, end.point.values), strict=True)))
        RestingBuoy.of(study, degree or 1)
    except IMPOSSIBLE as error:
        return replace(end, accepted=False, message=str(error))
    return end


def finer_of(search: Search, of: Callable[[int | None], Problem], point: Point, degree: int | None) -> Finer:
    """Return what shell modes beyond those of a buoy change.

    Raises one of `IMPOSSIBLE` if it has no stable equilibrium with more shell modes.
    """
    tried = degrees_of(search)
    degrees = tried[tried.index(degree) :][: 1 + FURTHER]
    return finer(of, degrees, point, partial(expected_of, search))


def uncertain_margins(search: Search) -> Callable[[Problem, Point], FloatArray] | None:
    """Return what gives the margins of limits for inputs that are uncertain, (limit,); None if none are asked for."""
    return partial(_deviations, search) if search.sigmas else None


def _deviations(search: Search, problem: Problem, point: Point) -> FloatArray:
    """`sigmas` standard deviations of the excesses over limits of a buoy as it may be built, (limit,).

    None of the limit that keeps the shell thin, which is one of theory.
    """
    assert isinstance(problem.model, DesignModel)
    scatter = spread(
        replace(problem.model, dampers=point.evaluation.dampers),
        problem.model.study_at([float(value) for value in point.values]),
        point.evaluation.damping,
        problem.limits,
        search.uncertain,
    )
    deviations = search.sigmas * np.linalg.norm(scatter, axis=1)
    return np.append(deviations, np.zeros(len(point.excess) - len(deviations)))


def expected_of(search: Search, point: Point, degree: int) -> float:
    """Return what further shell modes are expected to change of a buoy's power at least, relative."""
    keys = [one.key for one in search.variables]
    return expected_change(study_of(search, None, dict(zip(keys, point.values, strict=True))), degree)


@dataclass(frozen=True)
class Outcome:
    """Where one start ended, as a file keeps it."""

    keys: tuple[str, ...]
    start: FloatArray  # values of the variables where it began
    values: FloatArray  # and ended
    objective: float
    quantities: Mapping[str, float]
    gradients: Mapping[str, FloatArray]  # of the quantities by the variables
    multipliers: Mapping[str, float]
    kkt: float
    violation: float
    curvatures: tuple[float, ...]
    flat: tuple[str, ...]
    accepted: bool
    message: str
    evaluations: int
    degree: int | None
    truncation: tuple[float, float] | None  # of the power by all further degrees, relative: at most 0, at least 0
    margins: Mapping[str, float]  # most by which these raise excesses over limits, relative to them
    dampers: tuple[tuple[float, ...], ...] | None = None  # damper matrix of several ports

    @classmethod
    def of(cls, found: Converged, keys: Sequence[str]) -> "Outcome":
        """Return what is kept of a start."""
        end = found.optimum
        start, degree = found.start.values, found.degree
        return cls.at(end, keys, start, degree, found.truncation, found.evaluations, found.margins)

    @classmethod
    def at(
        cls,
        end: Optimum,
        keys: Sequence[str],
        start: FloatArray,
        degree: int | None,
        truncation: tuple[float, float] | None,
        evaluations: int,
        margins: Mapping[str, float],
    ) -> "Outcome":
        """Return what is kept of an optimum."""
        known, dampers = end.point.evaluation.quantities, end.point.evaluation.dampers
        return cls(
            keys=tuple(keys),
            start=start,
            values=end.point.values,
            objective=end.objective,
            quantities={name: one.value for name, one in known.items()},
            gradients={name: one.gradient for name, one in known.items()},
            multipliers=end.multipliers,
            kkt=end.kkt,
            violation=end.violation,
            curvatures=end.curvatures,
            flat=end.flat,
            accepted=end.accepted,
            message=end.message,
            evaluations=evaluations,
            degree=degree,
            truncation=truncation,
            margins=margins,
            dampers=None if dampers is None else tuple(map(tuple, dampers.tolist())),
        )

    @property
    def point(self) -> dict[str, float]:
        """Values of the variables by key."""
        return dict(zip(self.keys, map(float, self.values), strict=True))

    @property
    def feasible(self) -> bool:
        """Whether it is within all limits."""
        return self.violation <= VIOLATION

    @property
    def dataset(self) -> xr.Dataset:
        """The same as a dataset."""
        shape = (len(self.quantities), len(self.keys))  # of a rigid buoy without variables there are no keys
        gradient = np.array([self.gradients[name] for name in self.quantities]).reshape(shape)
        facts: dict[str, Any] = {
            "multipliers": dict(self.multipliers),
            "curvatures": self.curvatures,
            "flat": self.flat,
            "accepted": self.accepted,
            "message": self.message,
            "evaluations": self.evaluations,
            "degree": self.degree,
            "truncation": self.truncation,
            "margins": {name: None if np.isnan(value) else value for name, value in self.margins.items()},
            **({"dampers": self.dampers} if self.dampers else {}),
        }
        return xr.Dataset(
            {
                "start_value": ("variable", self.start),
                "best_value": ("variable", self.values),
                "objective": self.objective,
                "quantity_value": ("quantity", list(self.quantities.values())),
                "quantity_gradient": (("quantity", "variable"), gradient),
                "kkt": self.kkt,
                "violation": self.violation,
            },
            coords={"variable": np.array(self.keys, dtype=str), "quantity": list(self.quantities)},
            attrs={"outcome": json.dumps(facts)},
        )

    @classmethod
    def read(cls, ds: xr.Dataset) -> "Outcome | str":
        """Return what a file holds: where a start ended, or why it has no buoy."""
        if "outcome" not in ds.attrs:
            return str(ds.attrs["failure"])
        facts = json.loads(ds.attrs["outcome"])
        names = [str(name) for name in ds["quantity"].values]
        truncation, dampers = facts.pop("truncation"), facts.pop("dampers", None)
        margins = {name: np.nan if value is None else value for name, value in facts.pop("margins").items()}
        return cls(
            keys=tuple(map(str, ds["variable"].values)),
            start=ds["start_value"].values,
            values=ds["best_value"].values,
            objective=float(ds["objective"]),
            quantities=dict(zip(names, map(float, ds["quantity_value"].values), strict=True)),
            gradients=dict(zip(names, ds["quantity_gradient"].values, strict=True)),
            kkt=float(ds["kkt"]),
            violation=float(ds["violation"]),
            truncation=None if truncation is None else tuple(truncation),
            margins=margins,
            dampers=dampers and tuple(map(tuple, dampers)),
            **{**facts, "curvatures": tuple(facts["curvatures"]), "flat": tuple(facts["flat"])},
        )


def failed(reason: str) -> xr.Dataset:
    """Return what is kept of a start none of whose buoys rests."""
    return xr.Dataset(attrs={"failure": reason})


def best(found: Sequence[Outcome | str]) -> Outcome:
    """Return the best of some starts: of those accepted, else of those within all limits.

    Raises `ConvergenceError` if none is within all limits.
    """
    ended = [one for one in found if isinstance(one, Outcome)]
    chosen = [one for one in ended if one.accepted] or [one for one in ended if one.feasible]
    if not chosen:
        reasons = [one if isinstance(one, str) else one.message for one in found]
        raise ConvergenceError(
            f"design: none of {len(found)} starts found a buoy within all limits: {reasons[0]}; needs wider limits or "
            "bounds, or more starts"
        )
    return max(chosen, key=lambda one: one.objective)
