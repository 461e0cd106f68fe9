"""The best flexible buoy beside rigid ones, and the gain over the best of them.

Three rigid buoys separate size from flexibility: the competitor, optimised in every variable it has, under the same
limits; the twin, of the flexible one's rest shape and mass; the sphere before it was inflated. The last two have the
take-off that is optimal within the limits of the problem.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.integrate import cumulative_trapezoid

from vsb.design.certificate import VIOLATION
from vsb.design.evaluation import DAMPER, DesignModel
from vsb.design.linearised import linearised
from vsb.design.optimise import FURTHER, left_out, optimised
from vsb.design.problem import IMPOSSIBLE, POWER, Problem
from vsb.design.resting import RestingBuoy
from vsb.design.searched import Outcome, control_of, searching, study_of, with_rest
from vsb.design.take_offs import ControlledPorts, ControlledYear
from vsb.design.year import YearMotion
from vsb.engine.motion.causal import RmsLimits
from vsb.engine.motion.take_off import Pto, SeveralPorts
from vsb.engine.waves.climate import Climate
from vsb.study.design import LEAST_STROKE, OF_RIGID, Variable, comparable, limit_of, of_designs
from vsb.study.sections import DEGREES
from vsb.study.specs import DesignSpec, Search
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

FLEXIBLE, COMPETITOR, TWIN, UNDEFORMED = "flexible", "rigid competitor", "rigid twin", "undeformed shape"
"""Names of the buoys compared."""
OF_TAKE_OFF = ("force_rms", "stroke_rms", "spring_pull")
"""Limits that a take-off can meet."""
SHAPE_POINTS = 181


@dataclass(frozen=True)
class Buoy:
    """One of the buoys compared."""

    name: str
    study: Study  # with all its values
    design: str
    degree: int | None
    quantities: Mapping[str, float]
    truncation: tuple[float, float] | None = (0.0, 0.0)  # of its power, as `Outcome.truncation`; none of a rigid sphere
    control: RmsLimits | None = None  # limits of its causal control; none: a damper
    dampers: tuple[tuple[float, ...], ...] | None = None  # damper matrix of several ports

    @property
    def power(self) -> float:
        """Annual mean power [W]."""
        return self.quantities[POWER]

    @cached_property
    def resting(self) -> RestingBuoy:
        """The buoy where it rests."""
        return RestingBuoy.of(self.study, self.degree or 1, self.design)

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
        keys = variables if self.control or self.dampers else [*variables, DAMPER]
        model = DesignModel.of(self.study, self.design, climate, keys, self.degree, self.control)
        return replace(model, dampers=np.array(self.dampers)) if self.dampers else model

    def motion(self, model: DesignModel) -> YearMotion:
        """Return its motion over the year without its damper, with the nodes and frequencies of its model."""
        matrices = linearised(self.resting, self.design, [], model.grid.solved, model.nodes)
        return YearMotion(model.grid, *matrices, self.study.pto.stiffness)

    def controlled(self, model: DesignModel) -> ControlledYear | ControlledPorts:
        """Return its year under the best causal controller."""
        assert self.control
        return model.controlled(self.study, self.motion(model))

    def with_damper(self) -> "Buoy":
        """Return the same with the damper it has been found with given; with causal control, with its limit of force.

        A study reads that as the rms force of its control level `causal`.
        """
        given: dict[str, object] = {"damping": self.quantities.get("damping"), "tuning": "fixed"}
        if self.control and self.study.pto.several:
            control = self.study.pto.control.model_copy(update={"force_rms": self.control.force})
            given = {"damping": None, "tuning": "each", "control": control}
        elif self.control:
            given = {"damping": None, "tuning": "each", "force_limit": self.control.force}
        elif self.dampers and isinstance(self.study.pto.port, SeveralPorts):
            given = {"port": self.study.pto.port.model_copy(update={"damping": self.dampers}), "tuning": "fixed"}
        return replace(self, study=self.study.model_copy(update={"pto": self.study.pto.model_copy(update=given)}))


def buoy_of(name: str, search: Search, found: Outcome) -> Buoy:
    """Return the buoy a search has found."""
    truncation = (0.0, 0.0) if found.degree is None else found.truncation
    study = study_of(search, found.degree, found.point)
    control = control_of(search)
    return Buoy(name, study, search.design, found.degree, found.quantities, truncation, control, found.dampers)


def twin(spec: DesignSpec, climate: Climate, found: Outcome) -> Buoy | None:
    """Return the rigid buoy of the flexible one's rest shape and mass; None if it cannot be."""
    own, rigid = spec.flexible.base, spec.rigid.base
    designs = {**rigid["designs"], **own["designs"]}
    base = {**own, "pto": of_designs(rigid["pto"], designs), "designs": designs}
    changes = {"base": base, "limits": spec.rigid.limits, "variables": _of_both(spec)}
    search = spec.flexible.model_copy(update={"design": spec.rigid.design, "maximise": POWER, **changes})
    return _with_take_off(TWIN, search, climate, found)


def undeformed(spec: DesignSpec, climate: Climate, found: Outcome) -> Buoy | None:
    """Return the rigid sphere of the flexible one's undeformed radius and its mass; None if it sinks."""
    search = spec.rigid.model_copy(update={"variables": _of_both(spec), "maximise": POWER})
    return _with_take_off(UNDEFORMED, search, climate, replace(found, degree=None))


def _of_both(spec: DesignSpec) -> tuple[Variable, ...]:
    """Variables of the flexible buoy without those of a take-off that rigid buoys have not."""
    own, rigid = (Pto(**search.base["pto"]) for search in (spec.flexible, spec.rigid))
    kept = OF_RIGID if own.port == rigid.port or comparable(own) else ()
    return tuple(one for one in spec.flexible.variables if not one.key.startswith("pto.") or one.key in kept)


def _with_take_off(name: str, search: Search, climate: Climate, found: Outcome) -> Buoy | None:
    """A rigid buoy with the take-off that is best within the limits."""
    free = tuple(one for one in search.variables if one.key.startswith("pto."))
    point = {key: value for key, value in found.point.items() if key.startswith("device.")}
    try:
        study = study_of(search, found.degree, point)
        keys = [one.key for one in free]
        model = searching(search, study, climate, keys, found.degree)
        limits = {key: value for key, value in search.kept.items() if limit_of(key) in OF_TAKE_OFF}
        problem = Problem(model, free, POWER, with_rest(limits, free))
        place = problem.place([found.point[key] for key in keys])
        end = optimised(problem, problem.at(place))
        if LEAST_STROKE in limits and end.violation > VIOLATION:
            return None
        values = dict(zip(keys, map(float, end.point.values), strict=True))
        quantities = {key: one.value for key, one in end.point.evaluation.quantities.items()}
        study = study_of(search, found.degree, point | values)
    except IMPOSSIBLE:
        return None
    shape_error = _by_rest_shape(model, end.point.values, quantities[POWER])
    dampers = end.point.evaluation.dampers
    matrix = None if dampers is None else tuple(map(tuple, dampers.tolist()))
    return Buoy(name, study, search.design, found.degree, quantities, shape_error, model.control, matrix)


def _by_rest_shape(model: DesignModel, values: FloatArray, power: float) -> tuple[float, float] | None:
    """Change of a rigid buoy's power by shell modes that its shape at rest leaves out, see `left_out`."""
    if not (model.study.flexible and model.study.at_equilibrium):
        return 0.0, 0.0
    degrees = [model.degree, *[degree for degree in DEGREES if degree > model.degree][:FURTHER]]
    try:
        finer = [replace(model, degree=degree, sloped=False).at(list(values))[POWER].value for degree in degrees[1:]]
    except IMPOSSIBLE:
        return None
    return left_out([one / power - 1 for one in finer]) if len(finer) == FURTHER else None


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
