"""A design evaluated: the year's mean power and everything that limits it, each with its exact derivatives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from vsb.design.limits import SeaMoments, damage, hull, inverse_load_factors, static_strain
from vsb.design.linearised import CLAMPED, Linearised, displacements, linearised, of_all
from vsb.design.resting import RestingBuoy, Stepped, value_of, with_values
from vsb.design.take_offs import (
    ControlGrid,
    ControlledPorts,
    ControlledYear,
    ConvertedYear,
    SeveralYear,
    controlled_band,
)
from vsb.design.year import FrequencyGrid, PortYear, YearMotion, band, chebyshev, interpolation
from vsb.engine.hydro.spectral.solver import SpectralProblem, largest_error
from vsb.engine.motion.causal import KEPT, RmsLimits
from vsb.engine.motion.take_off import DofPort, SeveralPorts
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.modes import ModeBasis, rigid_basis
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.models.stationary import BEYOND
from vsb.study.campaign import sections, study_at
from vsb.study.design import ANGLE, CLAMP, LEAST_STROKE, NUMBERED, VARIABLES, Fatigue, is_variable, of_forces
from vsb.study.feasible import OF_EVERY_BUOY, shares
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

NEEDED = ("thin_shell", "least_draft", "floats")
"""Limits of every buoy beyond which there is nothing to evaluate."""
DAMPER, SPRING = "pto.damping", "pto.stiffness"
NODES, MOST_NODES = 32, 128
"""Nodes of the boundary elements: derivatives by shape are then right to 1e-8 where the shape itself is resolved."""
SOLVES, FURTHER, MOST_SOLVES = 16, 4, 64
"""Frequencies solved, and by how many they increase until coefficients between them are known."""
MOST_TIMES = 16
"""Most times as many frequencies of a causal controller as resolve the sea."""
KEPT_RESTS, SMALL = 16, 1e-9
"""Buoys whose rest is kept for those close to them, and what is added to variables in whose terms these are close."""
POINTS = 6
"""Points of quadrature in each band of a climate."""
RESOLVED, ROUND_OFF = 1e-8, 1e-6
"""Relative error of coefficients that is aimed at, by frequencies and by nodes, and the one below which round-off may
leave it; above, an error that falls slowly is one of shell modes shorter than the nodes resolve as yet.
"""


@dataclass(frozen=True)
class Quantity:
    """A value and its derivatives by the variables of a design."""

    value: float
    gradient: FloatArray  # (variable,)

    def __truediv__(self, other: "Quantity") -> "Quantity":
        """Return the ratio to another quantity of the same variables."""
        ratio = self.value / other.value
        return Quantity(ratio, (self.gradient - ratio * other.gradient) / other.value)

    def gain(self, reference: "Quantity") -> "Quantity":
        """Return the gain over a quantity of the same variables [%]."""
        ratio = self / reference
        return Quantity(100 * (ratio.value - 1), 100 * ratio.gradient)

    def deviation(self, deviations: Sequence[float]) -> float:
        """Return the standard deviation by those of the variables, which are independent of each other.

        sqrt(sum (dq/dx s)^2): right as long as the quantity is nearly linear within the deviations.
        """
        return float(np.linalg.norm(self.gradient * np.asarray(deviations, dtype=float)))


@dataclass(frozen=True)
class Evaluation:
    """What a design does and needs, by name: see `DesignModel.at`."""

    quantities: Mapping[str, Quantity]
    worth: Mapping[str, float] = field(default_factory=dict)  # relative gain of power per widening of a control's limit
    dampers: FloatArray | None = None  # matrix of several ports, (port, port); its units are those of the ports

    def __getitem__(self, name: str) -> Quantity:
        """Return a quantity by name."""
        return self.quantities[name]

    @property
    def damping(self) -> float | None:
        """The damper [N s/m]; None under causal control, and at several ports."""
        return self["damping"].value if "damping" in self.quantities else None


class Rest(NamedTuple):
    """Where a buoy rests."""

    values: FloatArray  # of the variables (variable,)
    amplitude: FloatArray  # (dof,) [m], with the height of the centre in heave's
    slopes: FloatArray  # of it by the variables (variable, dof)


@dataclass(frozen=True)
class DesignModel:
    """One design of a study over a climate as a smooth function of some keys of the study.

    Degree, nodes and frequencies are frozen, so that values of close designs differ by the designs alone. A search may
    look `beyond` what bounds a buoy, where the formulas still hold: a wall heavier than the buoy, a spring that pushes
    it over, are limits of the search then (`vsb.study.feasible.shares`, `spring_share`), and no errors.
    """

    study: Study
    design: str
    climate: Climate
    variables: tuple[str, ...]
    degree: int  # highest Legendre degree of the shell's displacements
    nodes: int  # of the boundary elements on the wet meridian
    grid: FrequencyGrid
    beyond: bool = False
    cost: Mapping[str, float] = field(default_factory=dict)  # prices by the quantity they are of
    control: RmsLimits | None = None  # limits of causal control; none: a damper
    fatigue: Fatigue | None = None  # cycles of strain the wall bears; none: no damage is computed
    dampers: FloatArray | None = None  # matrix of several ports that is kept; none: the one that absorbs most
    closer: int = 1  # how many times as many frequencies a causal controller has as it needs
    most_force: float = np.inf  # rms of all forces of several ports together, at most [N]
    sloped: bool = True  # else values alone: derivatives by what moves the buoy are zero, in half the time
    rests: dict[tuple[object, ...], list["Rest"]] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def of(
        cls,
        study: Study,
        design: str,
        climate: Climate,
        variables: Sequence[str],
        degree: int | None = None,
        control: RmsLimits | None = None,
    ) -> "DesignModel":
        """Return the model of a design; the degree is that of the study if not given.

        With limits of rms force and displacement its take-off is the optimal causal control within them.

        Raises
        ------
        ConfigError
            If it has no such design or variable, or its year depends on more than axisymmetric motion.
        """
        if design not in study.designs:
            raise ConfigError(f"design: received {design!r}; needs one of {', '.join(study.designs)}")
        clamps = [f"designs.{name}.clamp" for name, one in study.designs.items() if one.clamp]
        unknown = [key for key in variables if not is_variable(key) or (CLAMP.fullmatch(key) and key not in clamps)]
        if unknown:
            known = ", ".join((*VARIABLES, *NUMBERED, *clamps))
            raise ConfigError(f"variables: received {unknown[0]}; needs some of {known}")
        if study.motion != "heave":
            raise ConfigError(f"motion: received {study.motion!r}; derivatives of designs need heave")
        if study.device.damping.maxwell:
            raise ConfigError("device.damping.maxwell: received branches; derivatives of designs need none")
        if control and study.pto.several and not of_forces(study.pto):
            raise ConfigError(
                "pto.port: received the whole shell, or other loads than forces; causal control needs forces"
            )
        if isinstance(port := study.pto.port, DofPort) and set(port.dofs) != {"Heave"}:
            raise ConfigError(
                f"pto.port: received {port.dofs}; derivatives of designs know no natural modes, need Heave"
            )
        if study.opens_chamber and (study.pto.stiffness or SPRING in variables):
            raise ConfigError("pto.stiffness: received with pto.port: volume and device.gas; a design needs none there")
        if study.flexible and study.modes.basis != "full":
            raise ConfigError(f"modes.basis: received {study.modes.basis!r}; derivatives of designs need full")
        if degree is None:
            degree = study.modes.max_degree if study.flexible else 1
        if control and (given := next((key for key in (DAMPER, SPRING) if key in variables), None)):
            raise ConfigError(f"variables: received {given}; causal control is the whole force of the take-off")
        if control and study.pto.stiffness:
            raise ConfigError(f"pto.stiffness: received {study.pto.stiffness:g}; causal control is the whole force")
        high = study.hydro.omega_max
        nodes, solves = _resolution(study, (controlled_band if control else band)(climate, high), degree)
        grid = (
            ControlGrid.of_control(climate, high, solves)
            if control
            else FrequencyGrid.of(climate, high, solves, POINTS)
        )
        return cls(study, design, climate, tuple(variables), degree, nodes, grid, control=control)

    @property
    def finer(self) -> "DesignModel":
        """The same by half again as many nodes, frequencies solved and twice the points: for the numerical error."""
        high, solves = self.study.hydro.omega_max, 3 * len(self.grid.solved) // 2
        if self.control:
            grid: FrequencyGrid = ControlGrid.of_control(self.climate, high, solves, further=2 * BEYOND)
        else:
            grid = FrequencyGrid.of(self.climate, high, solves, 2 * POINTS)
        return replace(self, nodes=3 * self.nodes // 2, grid=grid, closer=2)

    @cached_property
    def point(self) -> tuple[float, ...]:
        """Values of the variables in the study itself, 0 of a damper that is not given."""

        def value(key: str) -> float:
            if key == DAMPER:
                return float(self.study.pto.damper(self.design) or 0.0)
            if key.startswith("designs."):
                return float(self.study.designs[key.split(".")[1]].clamp[0])
            return value_of(self.study, key)

        return tuple(map(value, self.variables))

    def study_at(self, values: Sequence[float]) -> Study:
        """Return the study with values of the variables.

        Raises
        ------
        ConfigError
            If no study has such values.
        """
        point: dict[str, float | str] = dict(zip(self.variables, values, strict=True))
        if not self.beyond:
            return study_at(sections(self.study), point)
        study = with_values(self.study, dict(zip(self.variables, values, strict=True)))
        try:
            used = shares(study.device, study.water, flexible=study.flexible)
        except ValueError as error:
            raise ConfigError(f"device: {error}") from None
        if no_buoy := [name for name in NEEDED if used.get(name, 0.0) >= 1]:
            raise ConfigError(f"device: a buoy needs {OF_EVERY_BUOY[no_buoy[0]]}")
        return study

    def at(self, values: Sequence[float]) -> Evaluation:
        """Return the year and the limits of the design at values of the variables, with their derivatives.

        Returns
        -------
        Evaluation
            `annual_mean_power` [W] under one damper all year, the optimal one unless it is a variable, after conversion
            with the efficiency of the take-off; `damping`, that damper [N s/m]; or, without `damping`, under one causal
            controller, or the damper matrix of several ports that absorbs most; root mean squares of the take-off's
            `force_rms` [N] and `stroke_rms` [m], of one port that is not spread over the shell; under causal control
            with a limit of stroke `stroke_rms_least` [m], the least that control within the force keeps; `beam` and
            `draft` of the hull at rest [m], its `surface` [m^2] and `volume` [m^3]; `mass` [kg]. Where heave moves the
            port `spring_pull_above` and `_below`, the force of a spring below zero at the rms stroke over the most by
            which the water brings the buoy back from above and from below [-]; `spring_share`, the stiffness of a
            spring below zero over that at which it ceases to rest stably [-]; the `cost`, with prices. If the study has
            a flexible design also the four largest inverse load factors of buckling `load_factor_inverse_0` to `_3`
            [-], and `static_strain`, the largest membrane strain at rest [-].

        Raises
        ------
        ConfigError
            If no study has such values.
        ConvergenceError
            If the shell buckles before it carries its load.
        StabilityError
            If the buoy is not stable at rest beside the spring of its take-off.
        """
        study = self.study_at(values)
        buoy = RestingBuoy.of(study, self.degree, self.design, self._near(study, values))
        of_device, stepped = self._stepped(buoy)
        self._remember(study, values, buoy, dict(zip(of_device, stepped, strict=True)))
        clamp = f"designs.{self.design}.clamp"
        angles = [i for i, key in enumerate(self.variables) if key == clamp or ANGLE.fullmatch(key)]
        turned = angles if self.sloped else []
        steps: list[Stepped | str] = [*stepped, *(self.variables[i].replace(clamp, CLAMPED) for i in turned)]
        linear, change = linearised(buoy, self.design, steps, self.grid.solved, self.nodes)
        _check_stable(linear, 0.0 if self.beyond else study.pto.stiffness, self.design)
        places = of_device + turned
        motion = self._motion(study, linear, change, places)
        year = self._year(study, motion)
        found = {**year.quantities, **self._at_rest(buoy, of_device, stepped)}
        if self.fatigue and study.designs[self.design].flexible:
            if study.opens_chamber:
                raise ConfigError(
                    "fatigue: received with pto.port: volume and device.gas; needs another port or no gas"
                )
            if isinstance(study.pto.port, SeveralPorts):
                raise ConfigError("fatigue: received with several ports, whose damper matrix has no derivatives")
            damper = found["damping"].value, found["damping"].gradient
            of_wall = damage(self.fatigue, self.climate, buoy, self.design, steps, places, motion, damper)
            found["damage"] = Quantity(*of_wall)
        if study.pto.moved_by_heave and not study.pto.several:
            found |= self._spring_pulls(study, found)
        if self.cost:
            found["cost"] = Quantity(
                sum(price * found[of].value for of, price in self.cost.items()),
                np.sum([price * found[of].gradient for of, price in self.cost.items()], axis=0),
            )
        return replace(year, quantities=found)

    def _near(self, study: Study, values: Sequence[float]) -> FloatArray | None:
        """Amplitudes near those at rest, from the closest of the buoys known and its slopes, (dof,) [m]."""
        known = self.rests.get((self.degree, *self.variables), [])
        if not known or not self.variables:
            return None
        apart = [np.asarray(values) - one.values for one in known]
        size = np.abs(values) + SMALL
        closest = int(np.argmin([np.abs(step / size).max() for step in apart]))
        amplitude = known[closest].amplitude + apart[closest] @ known[closest].slopes
        return np.asarray(amplitude - study.centre_height * np.eye(len(amplitude))[0])

    def _remember(self, study: Study, values: Sequence[float], buoy: RestingBuoy, steps: Mapping[int, Stepped]) -> None:
        """Keep where a buoy rests, and how that changes with the variables, for buoys that are close."""
        if not study.at_equilibrium:
            return
        heave = np.arange(len(buoy.modal_amplitude)) == 0
        slopes = np.zeros((len(self.variables), len(heave)))
        for i, one in steps.items():
            slopes[i] = one.derivative(lambda b: b.modal_amplitude + heave * b.loaded.centre_height)
        known = self.rests.setdefault((self.degree, *self.variables), [])
        known.append(Rest(np.array(values), buoy.modal_amplitude + heave * study.centre_height, slopes))
        del known[:-KEPT_RESTS]

    def _stepped(self, buoy: RestingBuoy) -> tuple[list[int], list[Stepped]]:
        """Places of the variables of the device, and the buoy with a step of each."""
        places = [i for i, key in enumerate(self.variables) if self.sloped and key.startswith("device.")]
        return places, [buoy.with_step(self.variables[i]) for i in places]

    def _at_rest(self, buoy: RestingBuoy, places: Sequence[int], stepped: Sequence[Stepped]) -> dict[str, Quantity]:
        """Hull, strain and buckling of a buoy, with derivatives by the variables at `places`."""
        slopes, count = hull(buoy, stepped), len(self.variables)
        if buoy.study.flexible:
            slopes["static_strain"] = static_strain(buoy, stepped)
            factors = inverse_load_factors(buoy.study, [self.variables[i] for i in places])
            slopes |= {f"load_factor_inverse_{i}": factor for i, factor in enumerate(factors)}
        return {name: Quantity(value, of_all(np.array(by), places, count)) for name, (value, by) in slopes.items()}

    def _spring_pulls(self, study: Study, found: Mapping[str, Quantity]) -> dict[str, Quantity]:
        """Force of a spring below zero at the rms stroke over the most by which the water brings the buoy back.

        Out of the water that is the weight, below it the buoyancy left: the force of the spring grows beyond both.
        """
        k, water = study.pto.stiffness, study.water
        k_change = np.array([float(key == SPRING) for key in self.variables])
        stroke, mass, volume = (found[name] for name in ("stroke_rms", "mass", "volume"))
        weight = Quantity(mass.value * water.gravity, mass.gradient * water.gravity)
        full = water.density * water.gravity
        left = Quantity(full * volume.value - weight.value, full * volume.gradient - weight.gradient)
        force = Quantity(0.0 - k * stroke.value, -k * stroke.gradient - k_change * stroke.value)
        return {"spring_pull_above": force / weight, "spring_pull_below": force / left}

    def _motion(self, study: Study, buoy: Linearised, change: Linearised, places: Sequence[int]) -> YearMotion:
        """The motion over the year beside the spring; derivatives of matrices are by the variables at `places`."""
        parts = {part.name: of_all(getattr(change, part.name), places, len(self.variables)) for part in fields(change)}
        if self._is(SPRING).any():
            parts["stiffness"] = parts["stiffness"] + self._is(SPRING)[:, None, None] * np.outer(buoy.port, buoy.port)
        return YearMotion(self.grid, buoy, Linearised(**parts), study.pto.stiffness)

    def _is(self, name: str) -> FloatArray:
        """Derivatives of a variable by all variables, 1 by itself, shape (variable,)."""
        return np.array([float(key == name) for key in self.variables])

    def _year(self, study: Study, motion: YearMotion) -> Evaluation:
        """Power, damper, force and stroke over the year."""
        if study.pto.several:
            return self._year_of_several(study, motion)
        k, is_damper, k_change = study.pto.stiffness, self._is(DAMPER), self._is(SPRING)
        controlled = self.controlled(study, motion) if self.control else None
        assert not isinstance(controlled, ControlledPorts)
        port = controlled.year if controlled else PortYear(motion)
        steadiness = {"spring_share": _spring_share(k, k_change, motion.buoy, motion.change)}
        converted = None if controlled or study.pto.efficiency == 1 else self.converted(study, port)
        if controlled and np.isfinite(controlled.limits.stroke):
            steadiness[LEAST_STROKE] = Quantity(*controlled.least_stroke)
        if controlled and controlled.damper is None:
            found = _controlled(controlled)
            return replace(found, quantities={**found.quantities, **steadiness})
        if controlled and controlled.damper:
            c, c_change, *_ = controlled.damper
        elif is_damper.any():
            c, c_change = study.pto.damper(self.design) or 0.0, is_damper
        elif converted:
            c, c_change = converted.optimal_damping, converted.optimal_damping_change(k_change)
        else:
            c = port.optimal_damping
            c_change = port.optimal_damping_change(c)
        speed, speed_change = port.mean_square(c, port.grid.omega**2, c_change)
        stroke, stroke_change = port.mean_square(c, np.ones_like(port.grid.omega), c_change)
        force = np.sqrt(c**2 * speed + k**2 * stroke)
        half = c**2 * speed_change / 2 + c * c_change * speed + k**2 * stroke_change / 2 + k * k_change * stroke
        power = Quantity(c * speed, c * speed_change + c_change * speed)
        if converted:
            *by, by_damper = converted.slopes(c, k_change)
            power = Quantity(float(self.climate.hours @ converted.of_seas(c)), np.array(by) + by_damper * c_change)
        quantities = {
            "annual_mean_power": power,
            **({} if controlled else {"damping": Quantity(c, c_change)}),
            "force_rms": Quantity(float(force), half / force),
            "stroke_rms": Quantity(float(np.sqrt(stroke)), stroke_change / (2 * np.sqrt(stroke))),
        }
        worth = {"force_rms": controlled.damper.worth} if controlled and controlled.damper else {}
        return Evaluation(quantities | steadiness, worth)

    def controlled(self, study: Study, motion: YearMotion) -> ControlledYear | ControlledPorts:
        """Return the year under the best causal controller within its limits.

        Of one port at as many frequencies as it needs: one whose force is small against that of the waves resonates
        within less than resolves the sea.
        """
        grid, limits, control = self.grid, self.control, study.pto.control
        assert limits
        assert isinstance(grid, ControlGrid)
        if isinstance(port := study.pto.port, SeveralPorts):
            own = replace(motion, grid=grid.finer(self.closer)) if self.closer > 1 else motion
            return ControlledPorts(SeveralYear(own), limits, control, port.matrix)

        def at(times: int) -> ControlledYear:
            own = replace(motion, grid=grid.finer(times)) if times > 1 else motion
            return ControlledYear(PortYear(own), limits, control)

        times, found = 1, at(1)
        while times < MOST_TIMES and not found.resolved:
            times *= 2
            found = at(times)
        return found if self.closer == 1 else at(self.closer * times)

    def converted(self, study: Study, port: PortYear) -> ConvertedYear:
        """Return the year of a port whose power is converted with an efficiency."""
        return ConvertedYear(port, SeaMoments(self.grid, self.climate), study.pto.efficiency, study.pto.stiffness)

    def _year_of_several(self, study: Study, motion: YearMotion) -> Evaluation:
        """Power at several ports, or of a damper spread over the shell, and the dampers."""
        year = SeveralYear(motion)
        if isinstance(study.pto.port, SeveralPorts):
            dampers, price, force, kind = self.dampers, 0.0, self.most_force, study.pto.port.matrix
            if self.control:
                controlled = self.controlled(study, motion)
                assert isinstance(controlled, ControlledPorts)
                year = controlled.year
                if controlled.damper is None:
                    return _controlled(controlled)
                (dampers, price), force = controlled.damper, self.control.force
            elif dampers is None and np.isfinite(force):
                dampers, price = year.within(force, kind)
            elif dampers is None:
                dampers = year.best(kind)
            less, slopes = year.power(dampers, price=price)
            chosen = None if self.control else dampers
            if not price:
                return Evaluation({"annual_mean_power": Quantity(less, slopes)}, dampers=chosen)
            paid = price * force**2
            found = {
                "annual_mean_power": Quantity(less + paid, slopes),
                "force_rms": Quantity(force, np.zeros_like(slopes)),
            }
            return Evaluation(found, {"force_rms": 2 * paid / (less + paid)}, chosen)
        is_damper, count = self._is(DAMPER), len(year.motion.rows)
        if is_damper.any():
            c, c_change = study.pto.damper(self.design) or 0.0, is_damper
        else:
            c = float(year.best("uniform")[0, 0])
            c_change = year.optimal_change(c)
        power = year.power(c * np.eye(count), c_change[:, None, None] * np.eye(count))
        return Evaluation({"annual_mean_power": Quantity(*power), "damping": Quantity(c, c_change)})


@dataclass(frozen=True)
class AtRest:
    """What `DesignModel.at` says of a buoy without waves; of a shell that does not carry its load by linear theory."""

    model: DesignModel

    def at(self, values: Sequence[float]) -> Evaluation:
        """Return the quantities at rest at values of the variables, with their derivatives."""
        study = self.model.study_at(values)
        try:
            buoy = RestingBuoy.of(study, self.model.degree)
        except ConvergenceError:
            buoy = RestingBuoy.of(study.model_copy(update={"reference_shape": "undeformed"}), self.model.degree)
        return Evaluation(self.model._at_rest(buoy, *self.model._stepped(buoy)))


def _controlled(year: ControlledYear | ControlledPorts) -> Evaluation:
    """Power, force and, of one port, stroke under causal control, and what a wider limit of either is worth."""
    found, slopes, limits = year.found, year.slopes, year.limits
    quantities, worth = {"annual_mean_power": Quantity(found.power, slopes.power)}, {}
    for name, limit, rms, change, weight in (
        ("force_rms", limits.force, found.force_rms, slopes.force, found.weights.force),
        ("stroke_rms", limits.stroke, found.stroke_rms, slopes.stroke, found.weights.stroke),
    )[: 2 if isinstance(year, ControlledYear) else 1]:
        binds = limit * (1 - KEPT) < rms <= limit * (1 + KEPT)
        quantities[name] = Quantity(limit if binds else rms, change / (2 * rms))
        if binds:
            worth[name] = 2 * weight * limit**2 / found.power
    return Evaluation(quantities, worth)


def _spring_share(k: float, k_change: FloatArray, buoy: Linearised, change: Linearised) -> Quantity:
    """Share of the stiffness at its port that a spring k takes from a buoy, -k b^T K^-1 b; at 1 it rests no more."""
    yielding = np.linalg.solve(buoy.stiffness, buoy.port)
    own = change.stiffness - k_change[:, None, None] * np.outer(buoy.port, buoy.port)
    compliance, slope = buoy.port @ yielding, 2 * change.port @ yielding - yielding @ own @ yielding
    return Quantity(float(0.0 - k * compliance), -k * slope - k_change * compliance)


def _check_stable(buoy: Linearised, spring: float, design: str) -> None:
    """Check that a buoy beside a spring at its port [N/m] returns to its rest; its linear motion means nothing else."""
    beside = spring * np.outer(buoy.port, buoy.port) if spring else 0.0
    least = np.linalg.eigvalsh(buoy.stiffness + beside)[0]
    if least <= 0:
        raise StabilityError(f"design {design} is not stable at rest: its least stiffness is {least:.3g} N/m")


def _resolution(study: Study, between: tuple[float, float], degree: int) -> tuple[int, int]:
    """Nodes and frequencies that resolve the coefficients of the undeformed buoy in a band [rad/s].

    Those of other designs need about as many: radius and frequency enter as omega^2 r/g.
    """
    basis = rigid_basis(study.device)
    return _resolved(basis, study.centre_height, study.water, between, degree if study.flexible else 0)


@lru_cache(maxsize=32)
def _resolved(
    basis: ModeBasis, centre_height: float, water: Water, between: tuple[float, float], degree: int
) -> tuple[int, int]:
    """The same, kept for all starts of a search."""
    shell, moved = DeformedShell(basis, centre_height), displacements(degree)
    problem = SpectralProblem(shell, moved, water.density, water.gravity, NODES, water.depth)
    ends = [between[0], sum(between) / 2, between[1]]
    error = largest_error(problem.error_estimate(ends))
    while error > RESOLVED and problem.nodes < MOST_NODES:
        finer = replace(problem, nodes=problem.nodes * 3 // 2)
        before, error = error, largest_error(finer.error_estimate(ends))
        if before / 2 < error < ROUND_OFF:
            break
        problem = finer
    solves, error = SOLVES, np.inf
    while error > RESOLVED and solves < MOST_SOLVES:
        coarse, fine = (chebyshev(*between, count) for count in (solves, 2 * solves))
        between_them, known = (problem.onto @ problem.potentials(list(omega)) for omega in (coarse, fine))
        guessed = np.tensordot(interpolation(coarse, fine), between_them, 1)
        error, solves = float(np.abs(guessed - known).max() / np.abs(known).max()), solves + FURTHER
    return problem.nodes, solves - FURTHER
