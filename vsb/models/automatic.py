"""Model `auto`: the cheapest description of a scene that gives the mean absorbed power to a tolerance.

A description is rigid or has shell modes up to some Legendre degree, has a radiation memory of some order, and is
linear or body-exact. Powers come without simulating a transient where there is a steady state: linear from phasors,
body-exact from harmonic balance. Elsewhere both descriptions are simulated in the same record of the sea.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from vsb.engine.hydro.radiation import RadiationModel, truncated
from vsb.engine.integrators.collocation import collocated
from vsb.engine.integrators.exact import propagate, steady_state
from vsb.engine.integrators.exponential import integrate
from vsb.engine.integrators.harmonic_balance import steady_power
from vsb.engine.integrators.settings import Simulation
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.scene import Scene, body_exact_scene, linear_scene
from vsb.engine.motion.system import Motion, System
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.loaded import LoadedShell
from vsb.engine.shell.modes import ModeBasis
from vsb.engine.waves.seas import Sea
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.models.rest import design_motions, motions_to_degree
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

RIGID = -1
"""Degree of a description without shell modes."""
INFINITE = -1
"""Memory that is the coefficients themselves."""
RECORD = (10.0, 40.0)
"""Part of a record over which powers are compared, in periods of its largest component."""
PRECISION = 1e-7
"""Relative tolerance of the motions that are compared."""
INTERPLAY = 1.25
"""Factor on the sum of errors measured one at a time: together they were up to 7 % more (0.271 for 0.254 permille)."""


class Description(NamedTuple):
    """How much of a scene is kept."""

    degree: int  # highest Legendre degree of the shell modes, or `RIGID`
    memory: int  # states of the radiation memory
    body_exact: bool  # hydrostatics and Froude-Krylov forces on the instantaneous wet shell

    @property
    def text(self) -> str:
        """The description in words."""
        shell = "rigid" if self.degree == RIGID else f"shell modes to degree {self.degree}"
        return f"{'body-exact' if self.body_exact else 'linear'}, {shell}, {self.memory} memory states"


class LeftOut(NamedTuple):
    """One simplification and the relative error of mean absorbed power it causes, estimated."""

    what: str
    error: float


@dataclass(frozen=True)
class Choice:
    """A description, what it leaves out, and its scene."""

    description: Description
    left_out: tuple[LeftOut, ...]
    scene: Scene
    unmeasured: str = ""  # why body-exact powers could not be computed

    @property
    def notes(self) -> dict[str, str | float]:
        """What a run records of the choice."""
        model = "body_exact" if self.description.body_exact else "linear"
        left_out = json.dumps([item._asdict() for item in self.left_out])
        found: dict[str, str | float] = {"model": model, "description": self.description.text, "left_out": left_out}
        return found | {"power_error": self.error} | ({"unmeasured": self.unmeasured} if self.unmeasured else {})

    @property
    def error(self) -> float:
        """Estimated error of mean absorbed power by everything left out together [-]."""
        return INTERPLAY * sum(item.error for item in self.left_out)


def motion_ladder(study: Study, basis: ModeBasis, design: str) -> dict[int, FloatArray]:
    """Return the motions of a design, shape (dof, free), by the highest degree of the shell modes they use.

    `RIGID` is always among them; degrees at which clamps leave no mode free are not.
    """
    ladder: dict[int, FloatArray] = {RIGID: np.eye(len(basis.labels), 1)}
    if not study.designs[design].flexible:
        return ladder
    for degree in range(study.modes.max_degree):
        try:
            ladder[degree] = motions_to_degree(study, basis, design, degree)
        except ConfigError:  # every mode clamped
            continue
    return {**ladder, study.modes.max_degree: design_motions(study, basis, design)}


@dataclass(frozen=True)
class Scenes:
    """All descriptions of one design in one sea, and the mean absorbed power each gives."""

    buoy: LinearSystem
    shape: DeformedShell
    radiation: RadiationModel
    sea: Sea
    ladder: Mapping[int, FloatArray]
    settings: Simulation
    rubber: LoadedShell | None = None  # the shell, if it is of rubber

    @property
    def full(self) -> Description:
        """The richest description."""
        return Description(max(self.ladder), self.radiation.order, True)

    def scene(self, d: Description) -> Scene:
        """Return the scene of a description."""
        memory, motions = truncated(self.radiation, d.memory), self.ladder[d.degree]
        if d.body_exact:
            return body_exact_scene(self.buoy, self.shape, memory, self.sea, motions, self.rubber)
        return linear_scene(self.buoy, memory, self.sea, motions)

    def system(self, d: Description) -> System:
        """Return the system of a description."""
        return System.of(self.scene(d))

    @cached_property
    def _powers(self) -> dict[Description, float]:
        """Powers computed so far."""
        return {}

    def power(self, d: Description) -> float:
        """Return the mean power a description absorbs [W]."""
        if d not in self._powers:
            self._powers[d] = self._power(self.system(d))
        return self._powers[d]

    def _power(self, system: System) -> float:
        """Steady mean power if there is a steady state, else that of a record."""
        if self.sea.omega.size and system.linear:
            return linear_power(system)
        return steady_power(system, PRECISION) if self.sea.omega.size == 1 else self._recorded_power(system)

    def _recorded_power(self, system: System) -> float:
        """Mean power over a record of the sea; in still water over the whole run."""
        end, begin = self.settings.duration, 0.0
        if self.sea.omega.size:
            period = 2 * np.pi / self.sea.omega[np.argmax(np.abs(self.sea.amplitude))]
            begin, end = (min(part * period, share * end) for part, share in zip(RECORD, (0.25, 1.0), strict=True))
        time = np.linspace(0.0, end, int(np.ceil(end / self._sampling)) + 1)
        start = system.scene.start(self.settings.initial_position, self.settings.initial_velocity)
        if system.linear:
            return absorbed(system, propagate(system, time, start), begin)
        follow = collocated if system.not_compiled else integrate  # compiled steps do not know rubber
        return absorbed(system, follow(system, time, start, PRECISION)[0], begin)

    @property
    def _sampling(self) -> float:
        """Interval of a record [s]: a fiftieth of the shortest period that matters, of the wave's or of free heave."""
        strong = self.sea.omega[np.abs(self.sea.amplitude) > 0.05 * np.abs(self.sea.amplitude).max(initial=0.0)]
        heave = self.buoy.stiffness[0, 0] / (self.buoy.mass + self.buoy.added_mass_inf)[0, 0]
        return float(2 * np.pi / max(np.sqrt(heave), strong.max(initial=0.0)) / 50)

    def nonlinear_part(self, d: Description) -> float:
        """Return the relative error of a linear description's power for being linear; on the same record, if on one."""
        exact = d._replace(body_exact=True)
        if self.sea.omega.size > 1:
            return relative(self._recorded_power(self.system(d)), self.power(exact))
        return relative(self.power(d), self.power(exact))

    def power_of_coefficients(self, degree: int, body_exact: bool) -> float:
        """Return the power with the coefficients themselves in place of a radiation memory [W].

        Where that needs a memory, body-exact without a period and in still water, with all of its states.
        """
        omega, whole = self.sea.omega, Description(degree, self.radiation.order, body_exact)
        if not omega.size or (body_exact and omega.size > 1):
            return self.power(whole)
        if not body_exact:
            return self.sea.mean_of(self.buoy.absorbed_power(omega, self.buoy.rao(omega, self.ladder[degree])))
        ideal = whole._replace(memory=INFINITE)
        if ideal not in self._powers:
            self._powers[ideal] = steady_power(self.system(whole), PRECISION, self.buoy.spectrum.transfer)
        return self._powers[ideal]


def linear_power(system: System) -> float:
    """Return the mean power a linear scene absorbs in its steady state, sum v^H D v/2 over the components [W]."""
    velocity = steady_state(system)[:, system.free : 2 * system.free] @ system.shapes.T
    return 0.5 * float(sum(np.sum(system.scene.dissipated_power(part)[0]) for part in (velocity.real, velocity.imag)))


def absorbed(system: System, motion: Motion, begin: float) -> float:
    """Return the mean power absorbed from a time on, by the trapezoidal rule [W]."""
    inside = motion.time >= begin
    power, _ = system.scene.dissipated_power(motion.velocity[inside] @ system.scene.motions.T)
    time = motion.time[inside]
    return float(np.trapezoid(power, time) / (time[-1] - time[0]))


def chosen(scenes: Scenes, tolerance: float) -> Choice:
    """Return the cheapest description whose estimated error of mean absorbed power is within tolerance.

    Parameters
    ----------
    tolerance : float
        Relative; of it divided by `INTERPLAY` a third each for modes, for memory, and for forces about the mean shape.

    Notes
    -----
    Each error is measured, not extrapolated: modes against all modes, memory against the coefficients, linear against
    body-exact, with the modes kept and with all: forces may act through modes left out. If a body-exact power cannot be
    computed, no mode and no force is left out, and the choice records why.
    """
    share = tolerance / (3 * INTERPLAY)
    try:
        return _chosen(scenes, share)
    except (ConvergenceError, StabilityError) as error:
        full = scenes.full
        memory = relative(
            scenes.power(full._replace(body_exact=False)), scenes.power_of_coefficients(full.degree, False)
        )
        left_out = (LeftOut(f"memory_beyond_{full.memory}_states", memory),)
        return Choice(full, left_out, scenes.scene(full), str(error))


def _chosen(scenes: Scenes, share: float) -> Choice:
    """See `chosen`; `share` is the error each simplification may cause."""
    full = scenes.full

    def modes_lost(degree: int, body_exact: bool) -> float:
        exact = full._replace(body_exact=body_exact)
        return relative(scenes.power(exact._replace(degree=degree)), scenes.power(exact))

    def memory_lost(order: int, body_exact: bool) -> float:
        exact = scenes.power_of_coefficients(degree, body_exact)
        return relative(scenes.power(Description(degree, order, body_exact)), exact)

    def fewest_states(least: int, body_exact: bool) -> int:
        orders = range(least, full.memory, 2)
        return next((m for m in orders if memory_lost(m, body_exact) <= share), full.memory)

    degrees = sorted(scenes.ladder)
    degree = next(d for d in degrees if modes_lost(d, False) <= share)  # the last one loses nothing
    order = fewest_states(2, False)
    nonlinear = max(scenes.nonlinear_part(Description(d, order, False)) for d in {degree, full.degree})
    body_exact = nonlinear > share
    if body_exact:
        degree = next(d for d in degrees if d >= degree and modes_lost(d, True) <= share)
        order = fewest_states(order, True)
    left_out = [LeftOut(f"memory_beyond_{order}_states", memory_lost(order, body_exact))]
    if degree < full.degree:
        what = "modes_above_degree" if degree > RIGID else "shell_modes"
        left_out.append(LeftOut(what, modes_lost(degree, body_exact)))
    if not body_exact:
        left_out.append(LeftOut("body_exact_forces", nonlinear))
    description = Description(degree, order, body_exact)
    return Choice(description, tuple(left_out), scenes.scene(description))


def relative(value: float, exact: float) -> float:
    """Return |value - exact| over the exact value; zero if both are."""
    return abs(value - exact) / abs(exact) if exact else abs(value)
