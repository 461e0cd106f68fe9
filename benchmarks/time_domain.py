"""Work and precision in the time domain: error against seconds of every integrator and radiation model, in one run.

Four scenes of the flexible design, linear and body-exact, each in a regular wave and in an irregular sea; mean power in
the steady state, with and without its transient; and seconds against modes, duration and memory states. Errors are
true ones: of linear scenes against DOP853 at `FINEST`, of body-exact ones against exponential collocation at 1e-11,
which DOP853 checks. A failure is a row that says why, and a cross in the figure. Seconds are of one core, the least of
three runs, without compilation.
"""

import tempfile
import time as clock
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullFormatter

from benchmarks.general_solvers import NOT_INSTALLED, SCIPY, SUNDIALS, Solution, best, measured_row
from benchmarks.integrators import COLUMNS, EXPONENTIAL
from benchmarks.integrators import STYLES as USUAL
from benchmarks.measure import Row, as_csv, say
from benchmarks.time_cases import (
    CONVOLUTION,
    MODELS,
    PER_PERIOD,
    PERIOD,
    REGULAR,
    SEAS,
    STEPS,
    STRIDES,
    TIME_LIMIT,
    Case,
    case_of,
    remembering,
    scene_of,
    varied,
)
from vsb.errors import ConfigError, VsbError
from vsb.hydro.statespace import fit_order, truncated
from vsb.integrators.exact import propagate
from vsb.integrators.exponential import integrate
from vsb.integrators.harmonic_balance import steady_power
from vsb.integrators.simulate import EXACT
from vsb.motion.system import System
from vsb.report.canvas import grid_of_axes, legend_above
from vsb.scenes.automatic import absorbed
from vsb.study.study import Study
from vsb.tools.files import write_text
from vsb.tools.tables import svg_text

BALANCE = "harmonic balance"
STYLES = {
    **USUAL, EXACT: ("#D55E00", "d"), CONVOLUTION: ("#56B4E9", "X"), STEPS: ("#8C510A", "h"),
    SUNDIALS: ("#882255", "<"), BALANCE: ("#117733", "p"),
}  # fmt: skip
"""Colour and marker of a method."""
DURATION = 30.0
"""Of the scenes whose error is measured [s]."""
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9)
OURS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
BALANCED = (1e-3, 1e-5, 1e-7)
"""Tolerances of harmonic balance; the converged mean power has a thousandth of the last."""
PERIODS = (5, 10, 20, 40, 80)
"""Of a motion whose last five tell its mean power."""
PANELS = tuple(f"{model}, {sea}" for model in MODELS for sea in SEAS)
POWER = "body-exact, mean power"
DEGREES, DURATIONS, ORDERS = (2, 5, 10, 20), (10.0, 60.0, 600.0, 3600.0), (2, 6, 10, 14, 18, 22)
"""Of the shell modes, of the motion [s], of the memory: what cost is measured against."""
CARRYING = {"internal_pressure": 16.5e3}
"""Pressure that carries a shell whose buckling modes are among those of `DEGREES` [Pa]."""
SCALED = {"linear": (EXACT, CONVOLUTION, STEPS, "RK45", SUNDIALS), "body-exact": (EXPONENTIAL, STEPS, "RK45", SUNDIALS)}
SCALED_TOLERANCE = 1e-6
"""Of what has one; fixed steps are `PER_PERIOD` a period."""
HOPELESS = 1.2
"""Limits a run may be expected to take: as the one before by what is varied, or by its square for a convolution."""
COSTS = {"modes": "shell modes", "duration": "duration [s]", "memory": "memory states"}
LEAST = 1e-16
"""Errors are drawn no smaller."""


# error against seconds ----------------------------------------------------------------------------------------------


def _attempts(case: Case) -> Iterator[tuple[str, float, Callable[[], Solution], int]]:
    """Method, setting, run and stride of everything a scene is followed by."""
    system, scene = case.system, case.system.scene
    if not system.linear:
        for tolerance in OURS:
            yield EXPONENTIAL, tolerance, partial(case.exponential, tolerance), 1
    elif memory := scene.memory:
        for order in (*range(2, memory.order, 2), memory.order):
            small = System.of(remembering(scene, truncated(memory, order)))
            exact = partial(propagate, small, case.time, case.start)
            yield EXACT, order, partial(case.ours, exact), 1
    for method in (STEPS, CONVOLUTION) if system.linear else (STEPS,):
        for stride in STRIDES:
            per_period = PER_PERIOD / stride if stride > 0 else -PER_PERIOD * stride
            yield method, per_period, partial(case.stepped, method, stride), stride
    for method in (*SCIPY, SUNDIALS):
        for tolerance in TOLERANCES:
            yield method, tolerance, partial(case.general, method, tolerance), 1


def integrator_rows(case: Case, name: str) -> list[Row]:
    """Return error and seconds of every method on one scene, and the check of its reference.

    The setting is a tolerance; of exact propagation the memory's states; of fixed steps their number in a period.
    """
    best(partial(case.stepped, STEPS, 1)), case.reference  # compile or load
    rows = [
        measured_row("integrators", name, method, setting, found, case.errors(found, stride))
        for method, setting, run, stride in _attempts(case)
        for found in (best(run),)
    ]
    check = case.general("DOP853", 1e-12, 3 * TIME_LIMIT)
    return [*rows, measured_row("reference", name, "DOP853", 1e-12, check, case.errors(check))]


def power_rows(system: System) -> list[Row]:
    """Return error and seconds of the mean power in a regular wave: harmonic balance, and motions of many periods.

    The setting is a tolerance; of a motion, followed at 1e-6, its number of periods, of which the last five tell.
    """
    exact, rows, period = steady_power(system, BALANCED[-1] / 1000), [], PERIOD

    def mean(periods: int) -> float:
        time = np.linspace(0.0, periods * period, PER_PERIOD * periods + 1)
        motion, _ = integrate(system, time, system.scene.start(0.0, 0.0), 1e-6)
        return absorbed(system, motion, time[-1] - 5 * period)

    runs: list[tuple[str, float, Callable[[], float]]] = [
        *((BALANCE, tol, partial(steady_power, system, tol)) for tol in BALANCED),
        *((EXPONENTIAL, periods, partial(mean, periods)) for periods in PERIODS),
    ]
    for method, setting, run in runs:
        found: list[float] = []
        solution = best(partial(_timed, run, found))
        error = {"error": abs(found[-1] / exact - 1)} if found else {}
        rows.append(measured_row("power", POWER, method, setting, solution, error))
    return rows


def _timed(run: Callable[[], float], found: list[float]) -> Solution:
    """Seconds of a function, whose result is appended."""
    begun, none, status = clock.perf_counter(), np.zeros(0), "completed"
    try:
        found.append(run())
    except VsbError as error:
        status = str(error)
    return Solution(none, none, clock.perf_counter() - begun, None, None, status)


# cost ---------------------------------------------------------------------------------------------------------------


class Size(NamedTuple):
    """One scene of a series whose cost is measured."""

    table: str  # what is varied
    setting: float
    case: Case


def series(study: Study, design: str, model: str, folder: str) -> Iterator[Size]:
    """Return scenes of more and more modes, longer and longer ones, and of larger and larger memories."""
    for degree in DEGREES:
        larger = varied(study, design, model, REGULAR, 10.0, device=CARRYING, modes={"degree": degree})
        scene = scene_of(larger, folder)
        yield Size("modes", scene.scene.motions.shape[1] - 1, case_of(scene, 10.0))
    scene = scene_of(varied(study, design, model, REGULAR, 10.0), folder)
    for duration in DURATIONS:
        yield Size("duration", duration, case_of(scene, duration))
    spectrum = scene.spectrum
    assert spectrum is not None  # of a database
    richest = fit_order(spectrum, spectrum.omega, max(ORDERS))[0]
    for order in ORDERS:
        plain = remembering(scene.scene, truncated(richest, order))
        yield Size("memory", order, case_of(scene._replace(scene=plain), 10.0))


def _run(case: Case, method: str) -> Solution:
    """A method at the settings whose cost is measured."""
    if method in (STEPS, CONVOLUTION):
        return case.stepped(method, 1)
    if method == EXACT:
        return case.ours(partial(propagate, case.system, case.time, case.start))
    if method == EXPONENTIAL:
        return case.exponential(SCALED_TOLERANCE)
    return case.general(method, SCALED_TOLERANCE)


def _not_tried(expected: float) -> Solution:
    """In place of a run that would not end in time."""
    return Solution(np.zeros(0), np.zeros(0), expected, None, None, f"not tried: {expected:.2g} s expected")


def cost_rows(study: Study, design: str, model: str, folder: str) -> list[Row]:
    """Return seconds against modes, duration and memory states; the setting is the number of them.

    A scene so much larger than the one before that its run would not end in time is not tried: a row says so.
    """
    rows: list[Row] = []
    last: dict[tuple[str, str], tuple[float, float]] = {}
    for table, setting, case in series(study, design, model, folder):
        case.stepped(STEPS, STRIDES[0])  # compiles or loads
        for method in SCALED[model]:
            before, seconds = last.get((table, method), (setting, 0.0))
            expected = seconds * (setting / before) ** (2 if method == CONVOLUTION else 1)
            tried = expected <= HOPELESS * TIME_LIMIT
            found = best(partial(_run, case, method)) if tried else _not_tried(expected)
            last[table, method] = setting, found.seconds
            one = measured_row(table, model, method, setting, found, {})
            rows.append(one if tried else {**one, "seconds": None})
    return rows


# output -------------------------------------------------------------------------------------------------------------


def _marked(ax: Axes, rows: Sequence[Row], x: str, y: str) -> None:
    """A line for each method, and a cross for every run that failed, near the upper edge, a row for each method."""
    ax.set_yscale("log")
    for i, method in enumerate(dict.fromkeys(row["method"] for row in rows)):
        colour, marker = STYLES[method]
        mine = [row for row in rows if row["method"] == method and row["status"] != NOT_INSTALLED]
        points = [(row[x], max(row[y], LEAST)) for row in mine if row["status"] == "completed"]
        if points:
            ax.plot(*zip(*points, strict=True), color=colour, marker=marker, markersize=4)
        if lost := [row[x] for row in mine if row["status"] != "completed"]:
            ax.plot(lost, [0.98 - 0.03 * i] * len(lost), "x", color=colour, transform=ax.get_xaxis_transform())


def _decades(ax: Axes) -> None:
    """A logarithmic axis of run times or durations from one power of ten to another."""
    ax.set_xscale("log")
    low, high = np.log10(ax.get_xlim())
    ax.set_xlim(10 ** np.floor(low), 10 ** np.ceil(high))
    ax.xaxis.set_minor_formatter(NullFormatter())


def _legend(axes: Axes, rows: Sequence[Row]) -> None:
    """Entries of all methods, for the legend, on one of the axes."""
    for method in dict.fromkeys(row["method"] for row in rows):
        axes.plot([], [], color=STYLES[method][0], marker=STYLES[method][1], markersize=4, label=method)
    axes.plot([], [], "x", color="#555555", label="failed or not tried")


def error_figure(rows: Sequence[Row]) -> Figure:
    """Draw error against seconds, a panel for each scene and one for mean power; crosses are runs that failed."""
    figure, axes = grid_of_axes(5.6, 2, 3)
    shown = [row for row in rows if row["table"] in ("integrators", "power")]
    for ax, case in zip(axes.flat, (*PANELS[:2], POWER, *PANELS[2:]), strict=False):
        _marked(ax, [row for row in shown if row["case"] == case], "seconds", "error")
        _decades(ax)
        ax.set_title(case, fontsize=9)
    axes[1, 2].set_axis_off()
    _legend(axes[0, 0], shown)
    legend_above(figure, axes[0, 0])
    figure.supxlabel("run time [s]", fontsize=9)
    figure.supylabel("largest error of heave over its range; of mean power, relative [-]", fontsize=9)
    return figure


def cost_figure(rows: Sequence[Row]) -> Figure:
    """Draw seconds against modes, duration and memory states, linear above body-exact."""
    figure, axes = grid_of_axes(5.6, len(MODELS), len(COSTS), sharex="col", sharey=True)
    shown = [row for row in rows if row["table"] in COSTS]
    for i, model in enumerate(MODELS):
        for j, (table, label) in enumerate(COSTS.items()):
            chosen = [row for row in shown if (row["case"], row["table"]) == (model, table)]
            _marked(axes[i, j], chosen, "setting", "seconds")
            axes[i, j].set_title(model, fontsize=9)
            axes[-1, j].set_xlabel(label)
            if table == "duration":
                _decades(axes[i, j])
            else:
                axes[i, j].xaxis.set_major_locator(MaxNLocator(integer=True))
        axes[i, 0].set_ylabel("run time [s]")
    _legend(axes[0, 0], shown)
    legend_above(figure, axes[0, 0])
    return figure


def measured(study: Study, design: str, folder: str) -> list[Row]:
    """Return all rows for one design of a study; its hydro files are made in a folder."""
    rows: list[Row] = []
    for model in MODELS:
        for sea in SEAS:
            say(f"{model}, {sea}")
            scene = scene_of(varied(study, design, model, sea, DURATION), folder)
            rows += integrator_rows(case_of(scene, DURATION), f"{model}, {sea}")
            if (model, sea) == ("body-exact", REGULAR):
                rows += power_rows(scene.system)
        say(f"{model}, cost")
        rows += cost_rows(study, design, model, folder)
    return rows


def benchmark(study: Study, folder: str | Path) -> list[Row]:
    """Measure the first flexible design of a study; write `time_precision.csv`, `time_precision.svg`, `time_cost.svg`.

    Parameters
    ----------
    study : Study
        In deep water; of its sections only device, modes, water and take-off are read, and the tolerance of `hydro`.
    folder : str or Path

    Raises
    ------
    ConfigError
        If no design is flexible.
    """
    design = next((name for name, one in study.designs.items() if one.flexible), None)
    if study.uses_panels:
        raise ConfigError("hydro: received a study of panels; needs hydro.solver: spectral, in deep enough water.")
    if design is None:
        raise ConfigError(f"designs: received only rigid ones, {', '.join(study.designs)}; needs a flexible one.")
    with tempfile.TemporaryDirectory() as files:
        rows = measured(study, design, files)
    write_text(Path(folder) / "time_precision.csv", as_csv(rows, COLUMNS))
    for name, draw in (("time_precision", error_figure), ("time_cost", cost_figure)):
        write_text(Path(folder) / f"{name}.svg", svg_text(draw(rows)))
    return rows
