"""Error against seconds of every integrator and radiation model, measured in one run.

Of a study with radiation (config/few_modes.yaml): four scenes of its first flexible design, linear and body-exact, each
in a regular wave and in an irregular sea, from rest, and the mean power of the body-exact steady state. Of a study
under assumed pressure (config/paper.yaml): every design by our method, beside the published run times, and the last by
all. Linear scenes are compared with DOP853 at `FINEST`, the others with exponential collocation at 1e-11, which DOP853
checks. A failed run is a row that says why. Seconds are those one processor works, the least of three runs, without
compilation.
"""

import tempfile
import time as clock
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

import numpy as np
from scipy.integrate import simpson

from benchmarks.compiled_solvers import COMPILED_DOP853, RK4
from benchmarks.general_solvers import SCIPY, SUNDIALS, Equation, Solution, best, solved
from benchmarks.measure import Row, as_csv, say
from vsb.engine.hydro.radiation import DampingSpectrum, RadiationModel, truncated
from vsb.engine.integrators.exact import convolve, propagate
from vsb.engine.integrators.exponential import integrate
from vsb.engine.integrators.harmonic_balance import steady_power
from vsb.engine.integrators.simulate import EXACT
from vsb.engine.motion.forces import RadiationMemory
from vsb.engine.motion.system import Motion, System
from vsb.engine.waves.kinds import RegularWave
from vsb.errors import ConfigError, VsbError
from vsb.models.automatic import absorbed
from vsb.models.build import DesignInSea, design_in_sea
from vsb.pipeline.graph import StudyPlan
from vsb.stages.make import hydro_files
from vsb.study.study import Study, parse
from vsb.tools.arrays import FloatArray
from vsb.tools.files import write_text

COLUMNS = (
    "table", "case", "method", "setting", "error", "error_energy", "seconds", "steps", "evaluations",
    "published_seconds", "ratio", "status",
)  # fmt: skip
EXPONENTIAL, CONVOLUTION = "exponential Adams", "convolution"
BALANCE = "harmonic balance"
PERIOD, PER_PERIOD = 2.5, 64
"""Period of the regular wave [s], and instants per period at which motions are compared."""
REGULAR, IRREGULAR = "regular wave", "irregular sea"
SEAS = {
    REGULAR: {"kind": "regular", "amplitude": 0.179, "period": PERIOD},
    IRREGULAR: {"kind": "jonswap", "hs": 0.5, "tp": 4.0},
}
MODELS = {"linear": {"model": "linear"}, "body-exact": {"model": "body_exact"}}
DURATION = 30.0
"""Of the scenes with radiation [s]."""
FINEST = 1e-13
"""Tolerance of DOP853 for the converged solution of a linear scene."""
TOLERANCES, ADAMS = (1e-3, 1e-5, 1e-7, 1e-9), (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
"""Of the general integrators, and of the exponential Adams method."""
RK4_STEPS = (2, 4, 8, 16, 32)
"""Of RK4 between two common instants."""
STRIDES = (8, 4, 2, 1, -2, -4)
"""A fixed step is so many common instants, or (negative) such a fraction of one."""
BALANCED, PERIODS = (1e-3, 1e-5, 1e-7), (5, 10, 20, 40, 80)
"""Mean power: tolerances of harmonic balance, and lengths of a simulation whose last five periods are averaged."""
TIME_LIMIT = 20.0
"""Of one run [s]."""
PUBLISHED_SECONDS, PUBLISHED_DURATION = {True: 2.4 * 3600, False: 2.11 * 60}, 60.0
"""Run time of the paper's flexible and fixed buoys [s], "2.4 hours" and "2.11 minutes" with MATLAB's ode45 on a machine
and at a tolerance it does not state, and the duration of the motion in its Table II [s]."""

# cases --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ModelKernel(DampingSpectrum):
    """Kernel of the state space itself, so that a convolution differs by its own errors only."""

    model: RadiationModel

    def kernel(self, time: FloatArray) -> FloatArray:
        """Return the kernel of the model."""
        return self.model.kernel(time)


@dataclass(frozen=True)
class Case:
    """The motion of one scene, compared at common instants."""

    system: System
    time: FloatArray  # common instants (time,) [s]
    start: tuple[FloatArray, FloatArray]  # y and y'
    spectrum: DampingSpectrum | None = None  # of the memory, for a convolution

    @classmethod
    def of(cls, scene: DesignInSea, duration: float, start: tuple[float, float] = (0.0, 0.0)) -> "Case":
        """Return the motion of a scene from a heave and its velocity; the instants are a multiple of all strides."""
        intervals = int(np.ceil(PER_PERIOD * duration / PERIOD / STRIDES[0]))
        time = np.linspace(0.0, duration, STRIDES[0] * intervals + 1)
        memory, kernel = scene.scene.memory, None
        if scene.spectrum is not None and memory is not None:
            kernel = ModelKernel(scene.spectrum.omega, scene.spectrum.damping, memory)
        return cls(scene.system, time, scene.scene.start(*start), kernel)

    @cached_property
    def equation(self) -> Equation:
        """The equation in plain coordinates, compiled."""
        equation = Equation.of(self.system, self.start)
        equation.rates(0.0, equation.first)
        return equation

    @cached_property
    def reference(self) -> Solution:
        """The converged solution."""
        return self.general("DOP853", FINEST, 3 * TIME_LIMIT) if self.system.linear else self.exponential(1e-11)

    def exponential(self, tolerance: float) -> Solution:
        """Run the exponential Adams method."""
        return self.ours(partial(integrate, self.system, self.time, self.start, tolerance))

    def ours(self, run: Callable[[], Motion | tuple[Motion, int]], stride: int = 1) -> Solution:
        """Run one of our integrators, which records every `stride`-th common instant, or fractions of them."""
        begun, none = clock.process_time(), np.zeros(0)
        try:
            out = run()
        except VsbError as error:
            return Solution(none, none, clock.process_time() - begun, None, None, str(error))
        motion, steps = out if isinstance(out, tuple) else (out, len(out.time) - 1)
        seconds, every = clock.process_time() - begun, max(-stride, 1)
        return Solution(motion.position[::every, 0], motion.velocity[::every, 0], seconds, steps, None)

    def general(self, method: str, tolerance: float, limit: float = TIME_LIMIT) -> Solution:
        """Run a general integrator."""
        return solved(self.equation, method, tolerance, self.time, limit)

    def convolved(self, stride: int) -> Solution:
        """Run the convolution, whose steps are fixed."""
        count = (len(self.time) - 1) * max(-stride, 1) // max(stride, 1)
        time = np.linspace(0.0, self.time[-1], count + 1)
        assert self.spectrum is not None
        return self.ours(partial(convolve, self.system, self.spectrum, time, self.start), stride)

    def errors(self, found: Solution, stride: int = 1) -> Row:
        """Return the largest error of heave over its range, and that of the energy absorbed; none of a failed run."""
        if not len(found.heave):
            return {}
        every = slice(None, None, max(stride, 1))
        time, heave, velocity = self.time[every], self.reference.heave[every], self.reference.velocity[every]
        exact, energy = (float(simpson(v**2, x=time)) for v in (velocity, found.velocity))
        error = float(np.abs(found.heave - heave).max() / np.ptp(heave))
        return {"error": error, "error_energy": abs(energy / exact - 1) if self.system.dampers()[0].any() else None}


def scene_of(study: Study, folder: str | Path) -> DesignInSea:
    """Return the scene of the only design in the only sea of a study; its hydro files are made in a folder."""
    (design,), (wave,) = study.designs, study.waves
    paths = hydro_files(study, folder)
    one = StudyPlan(study).simulation(design, wave).spec["run"]
    return design_in_sea(one, paths)


def varied(study: Study, design: str, wave: dict[str, object], hydro: dict[str, object], duration: float) -> Study:
    """Return a study of one design in one sea, for so long."""
    data = study.model_dump()
    data |= {"published": None, "designs": {design: data["designs"][design]}, "waves": [wave], "hydro": hydro}
    data["simulation"] |= {"duration": duration, "window": [duration / 2, duration], "method": "auto"}
    return parse(data, source=study.study)


def radiating(study: Study, folder: str) -> Iterator[tuple[str, Case]]:
    """Return the four scenes of the first flexible design, from rest.

    Raises
    ------
    ConfigError
        If no design is flexible, or the study needs panels.
    """
    design = next((name for name, one in study.designs.items() if one.flexible), None)
    if study.uses_panels:
        raise ConfigError("hydro: received a study of panels; needs hydro.solver: spectral, in deep enough water.")
    if design is None:
        raise ConfigError(f"designs: received only rigid ones, {', '.join(study.designs)}; needs a flexible one.")
    given = {key: study.model_dump()["hydro"][key] for key in ("tolerance", "omega_max")}
    for model, keys in MODELS.items():
        for sea, wave in SEAS.items():
            scene = scene_of(varied(study, design, wave, given | keys, DURATION), folder)
            yield f"{model}, {sea}", Case.of(scene, DURATION)


def under_pressure(study: Study, folder: str) -> Iterator[tuple[str, Case]]:
    """Return every design of a study under assumed pressure, in its first regular wave and from its start."""
    wave = next((wave for wave in study.waves if isinstance(wave, RegularWave)), None)
    if wave is None:
        raise ConfigError(f"waves: received {[wave.label for wave in study.waves]}; needs a regular wave")
    settings, data = study.simulation, study.model_dump()["hydro"]
    for design in study.designs:
        scene = scene_of(varied(study, design, wave.model_dump(), data, settings.duration), folder)
        yield design, Case.of(scene, settings.duration, (settings.initial_position, settings.initial_velocity))


# measurement --------------------------------------------------------------------------------------------------------


def row_of(table: str, case: str, method: str, setting: float, found: Solution, errors: Row) -> Row:
    """Return a row of the table."""
    measured = {key: getattr(found, key) for key in ("seconds", "steps", "evaluations", "status")}
    return {"table": table, "case": case, "method": method, "setting": setting, **errors, **measured}


def attempts(case: Case) -> Iterator[tuple[str, float, Callable[[], Solution], int]]:
    """Return method, setting, run and stride of everything a scene is followed by.

    The setting is a tolerance; of exact propagation the number of memory states; of fixed steps their number a period,
    of RK4 between two common instants.
    """
    system, scene = case.system, case.system.scene
    if not system.linear:
        for tolerance in ADAMS:
            yield EXPONENTIAL, tolerance, partial(case.exponential, tolerance), 1
    elif memory := scene.memory:
        for order in (*range(2, memory.order, 2), memory.order):
            forces = {**scene.forces, "radiation": RadiationMemory(truncated(memory, order))}
            exact = partial(propagate, System.of(replace(scene, forces=forces)), case.time, case.start)
            yield EXACT, order, partial(case.ours, exact), 1
    for stride in STRIDES if system.linear else ():
        per_period = PER_PERIOD / stride if stride > 0 else -PER_PERIOD * stride
        yield CONVOLUTION, per_period, partial(case.convolved, stride), stride
    for steps in RK4_STEPS:
        yield RK4, steps, partial(case.general, RK4, steps), 1
    for method in (COMPILED_DOP853, *SCIPY, SUNDIALS):
        for tolerance in TOLERANCES:
            yield method, tolerance, partial(case.general, method, tolerance), 1


def integrator_rows(case: Case, name: str) -> list[Row]:
    """Return error and seconds of every method on one scene, and the check of its reference by DOP853."""
    _ = case.reference  # compiles what is not compiled yet
    for method, setting in ((RK4, RK4_STEPS[0]), (COMPILED_DOP853, TOLERANCES[0])):
        case.general(method, setting)
    rows = [
        row_of("integrators", name, method, setting, found, case.errors(found, stride))
        for method, setting, run, stride in attempts(case)
        for found in (best(run),)
    ]
    check = case.general("DOP853", 1e-12, 3 * TIME_LIMIT)
    return [*rows, row_of("reference", name, "DOP853", 1e-12, check, case.errors(check))]


def power_rows(system: System, name: str) -> list[Row]:
    """Return error and seconds of the mean power in a regular wave: harmonic balance, and simulations of many periods.

    The setting is a tolerance; of a simulation, at 1e-6, its number of periods, of which the last five are averaged.
    """
    exact, rows = steady_power(system, BALANCED[-1] / 1000), []

    def mean(periods: int) -> float:
        time = np.linspace(0.0, periods * PERIOD, PER_PERIOD * periods + 1)
        motion, _ = integrate(system, time, system.scene.start(0.0, 0.0), 1e-6)
        return absorbed(system, motion, time[-1] - 5 * PERIOD)

    runs: list[tuple[str, float, Callable[[], float]]] = [
        *((BALANCE, tol, partial(steady_power, system, tol)) for tol in BALANCED),
        *((EXPONENTIAL, periods, partial(mean, periods)) for periods in PERIODS),
    ]
    for method, setting, run in runs:
        found: list[float] = []
        solution = best(partial(_timed, run, found))
        error = {"error": abs(found[-1] / exact - 1)} if found else {}
        rows.append(row_of("power", name, method, setting, solution, error))
    return rows


def _timed(run: Callable[[], float], found: list[float]) -> Solution:
    """Seconds of a function, whose result is appended."""
    begun, none, status = clock.process_time(), np.zeros(0), "completed"
    try:
        found.append(run())
    except VsbError as error:
        status = str(error)
    return Solution(none, none, clock.process_time() - begun, None, None, status)


def paper_row(study: Study, design: str, case: Case) -> Row:
    """Return seconds and error at the study's tolerance, beside the published run time of the same duration.

    The ratio says how long a user waits; it does not compare two machines.
    """
    settings = study.simulation
    found = best(partial(case.exponential, settings.tolerance))
    row = row_of("paper", design, EXPONENTIAL, settings.tolerance, found, case.errors(found))
    if settings.duration != PUBLISHED_DURATION:
        return row
    published = PUBLISHED_SECONDS[study.designs[design].flexible]
    return {**row, "published_seconds": published, "ratio": published / found.seconds}


# output -------------------------------------------------------------------------------------------------------------


def measured(study: Study, folder: str) -> list[Row]:
    """Return all rows of a study; its hydro files are made in a folder."""
    rows: list[Row] = []
    if study.hydro.model == "assumed_pressure":
        for name, case in under_pressure(study, folder):
            rows.append(paper_row(study, name, case))
        return rows + integrator_rows(case, name)
    for name, case in radiating(study, folder):
        say(f"{study.study}: {name}")
        rows += integrator_rows(case, name)
        if name == f"body-exact, {REGULAR}":
            rows += power_rows(case.system, name)
    return rows


def benchmark(study: Study, out: str | Path) -> list[Row]:
    """Measure a study and write a table.

    Parameters
    ----------
    study : Study
        With radiation (in deep water; only device, modes, water, take-off and the tolerance of `hydro` are used), or
        under assumed pressure.
    out : str or Path
    """
    with tempfile.TemporaryDirectory() as files:
        rows = measured(study, files)
    write_text(out, as_csv(rows, COLUMNS))
    return rows
