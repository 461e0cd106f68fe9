"""Work and precision: error against seconds of the wet forces and of the integrators, measured in one run.

General integrators, Dormand and Prince's (the paper's ode45) among them, get the same compiled right-hand side as ours.
Seconds are of one core of the machine that ran the benchmark.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.general_solvers import Rates, Solution, best, measured_row, solved
from benchmarks.measure import Row, as_csv, say
from benchmarks.quadrature import disc_force, gauss_force, quadrature_precision, regular_wave, scene_of_design
from benchmarks.time_cases import Case
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.report.canvas import grid_of_axes, legend_above
from vsb.shell.deformed import DeformedShell
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray
from vsb.tools.files import write_text
from vsb.tools.tables import svg_text

COLUMNS = (
    "table", "case", "method", "setting", "error", "error_energy", "seconds", "steps", "evaluations", "order",
    "published_seconds", "ratio", "status",
)  # fmt: skip
PUBLISHED_SECONDS = {True: 2.4 * 3600, False: 2.11 * 60}
"""Run time of the paper's buoys, flexible and fixed [s]: "2.4 hours" and "2.11 minutes" with MATLAB's ode45, at the
start of its simulation results; neither the machine nor the tolerance is stated."""
PUBLISHED_DURATION = 60.0
"""Of the motion in the paper's Table II [s]."""
EXPONENTIAL = "exponential Adams"
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
SOLVERS: Mapping[str, Sequence[float]] = {
    "RK45": (1e-3, 1e-5, 1e-7, 1e-9),
    "DOP853": (1e-3, 1e-5, 1e-7, 1e-9),
    "Radau": (1e-3, 1e-5, 1e-7),
    "BDF": (1e-3, 1e-5, 1e-7),
    "LSODA": (1e-3, 1e-5, 1e-7, 1e-9),
}
TIME_LIMIT = 20.0
"""Of one run [s]."""
PLAIN_SPAN, PLAIN_TOLERANCE = 1.0, 1e-5
"""Motion followed with plain NumPy forces [s], and at which tolerance."""
Rule = Callable[[DeformedShell, int], tuple[FloatArray, FloatArray]]
PLAIN: Mapping[str, tuple[Rule, int]] = {"RK45, NumPy": (gauss_force, 40), "RK45, discs": (disc_force, 1000)}
"""Right-hand sides without compiled code: rule and its points or discs."""
STYLES = {
    EXPONENTIAL: ("#D55E00", "o"), "RK45": ("#000000", "s"), "DOP853": ("#0072B2", "^"), "Radau": ("#009E73", "D"),
    "BDF": ("#CC79A7", "v"), "LSODA": ("#E69F00", "P"), "RK45, NumPy": ("#56B4E9", "X"),
    "RK45, discs": ("#777777", "*"), "discs": ("#000000", "s"), "Gauss-Legendre": ("#0072B2", "^"),
    "exact kernel": ("#D55E00", "o"),
}  # fmt: skip
"""Colour and marker of a method; Okabe and Ito's palette."""


# integrators --------------------------------------------------------------------------------------------------------


def plain_rates(scene: Scene, rule: Rule, points: int) -> Rates:
    """Return y'' = R (f_water + weight) - K y - D y', q = N y, with forces by `gauss_force` or `disc_force`."""
    water, n, free = scene.water, scene.motions, scene.motions.shape[1]
    assert water is not None  # built by `scene_of_design`
    assert water.assumed is not None
    shell, pressure = water.shell, water.assumed
    inverse, springs = np.linalg.inv(n.T @ scene.mass @ n), (p.stiffness for p in scene.linear.values() if p.whole)
    stiffness, damping = inverse @ scene.projected(springs), inverse @ scene.damping

    def function(t: float, state: FloatArray) -> FloatArray:
        static, uniform = rule(DeformedShell(shell.basis, shell.centre_height, n @ state[:free]), points)
        force = water.specific_weight * static + pressure.at(np.array(t)) * uniform + scene.constant
        rate = inverse @ n.T @ force - stiffness @ state[:free] - damping @ state[free:]
        return np.concatenate([state[free:], rate])

    return function


def case_of_design(study: Study, design: str) -> Case:
    """Return the motion of one design in the regular wave of a study, 200 instants a period."""
    scene, settings = scene_of_design(study, design), study.simulation
    intervals = int(np.ceil(200 * settings.duration / regular_wave(study).period))
    start = scene.start(settings.initial_position, settings.initial_velocity)
    return Case(System.of(scene), np.linspace(0.0, settings.duration, intervals + 1), start)


def measured(case: Case, design: str, method: str, tolerance: float, attempt: Solution) -> Row:
    """Return a row of the table."""
    return measured_row("integrators", design, method, tolerance, attempt, case.errors(attempt))


def integrator_precision(study: Study, design: str) -> list[Row]:
    """Return error and seconds of the exponential Adams method and of general integrators on the motion of one design.

    All of scipy's are given the same compiled right-hand side. With plain NumPy forces RK45 follows the first
    second alone, and the error is of that; the seconds are those of one evaluation there times the evaluations of the
    compiled run of the same tolerance, as the status says.
    """
    case = case_of_design(study, design)
    row = partial(measured, case, design)
    rows = [row(EXPONENTIAL, tol, best(partial(case.exponential, tol))) for tol in TOLERANCES]
    for method, tolerances in SOLVERS.items():
        solved(case.equation, method, tolerances[0], case.time[:2], TIME_LIMIT)  # compiles and loads
        rows += [row(method, tol, best(partial(case.general, method, tol, TIME_LIMIT))) for tol in tolerances]
    check = row("DOP853", 1e-12, case.general("DOP853", 1e-12, 3 * TIME_LIMIT))
    same = next(row for row in rows if (row["method"], row["setting"]) == ("RK45", PLAIN_TOLERANCE))
    return [*rows, {**check, "table": "reference"}, *plain_rows(case, same)]


def plain_rows(case: Case, compiled: Row) -> list[Row]:
    """Return rows of RK45 with plain NumPy forces, from a short piece of the motion and the row of the compiled run."""
    count = min(len(case.time), int(np.searchsorted(case.time, PLAIN_SPAN)) + 1)
    rows = []
    for method, (rule, points) in PLAIN.items():
        plain = replace(case.equation, rates=plain_rates(case.system.scene, rule, points))
        attempt = solved(plain, "RK45", PLAIN_TOLERANCE, case.time[:count], TIME_LIMIT)
        seconds = attempt.seconds / (attempt.evaluations or 1) * compiled["evaluations"]
        note = f"{attempt.status}: {case.time[count - 1]:.3g} s of motion, seconds for the evaluations of compiled RK45"
        counts = {key: compiled[key] for key in ("steps", "evaluations")}
        row = measured(case, compiled["case"], method, PLAIN_TOLERANCE, attempt)
        rows.append({**row, **counts, "seconds": seconds, "status": note})
    return rows


def paper_precision(study: Study) -> list[Row]:
    """Return seconds and error of our run of every design at the study's tolerance, beside the published run time.

    The published time is of 60 s of motion on a machine the paper does not name; the ratio is a fact about what a user
    waits for, not about two machines. A study of another duration has none.
    """
    rows = []
    for name, design in study.designs.items():
        case, tolerance = case_of_design(study, name), study.simulation.tolerance
        row = measured(case, name, EXPONENTIAL, tolerance, best(partial(case.exponential, tolerance)))
        published = PUBLISHED_SECONDS[design.flexible] if study.simulation.duration == PUBLISHED_DURATION else None
        ratio = published / row["seconds"] if published else None
        rows.append({**row, "table": "paper", "published_seconds": published, "ratio": ratio})
    return rows


# output -------------------------------------------------------------------------------------------------------------


def _draw(ax: Axes, rows: Sequence[Row], case: str) -> None:
    """Error against seconds of all methods on one case; a failed run has no error and no mark."""
    shown = [row for row in rows if row["case"] == case and row.get("error") is not None]
    for method in dict.fromkeys(row["method"] for row in shown):
        points = [(row["seconds"], max(row["error"], 1e-17)) for row in shown if row["method"] == method]
        colour, marker = STYLES[method]
        ax.loglog(*zip(*points, strict=True), color=colour, marker=marker, markersize=4, label=method)
    ax.set_title(case, fontsize=9)


def precision_figure(rows: Sequence[Row], table: str, error: str) -> Figure:
    """Draw error against seconds of one table, a panel per case.

    Parameters
    ----------
    rows : sequence of Row
    table : {"quadrature", "integrators"}
    error : str
        What the error is of, for the axis.
    """
    chosen = [row for row in rows if row["table"] == table]
    cases = list(dict.fromkeys(row["case"] for row in chosen))
    columns = 3 if len(cases) == 3 else min(2, len(cases))
    lines = -(-len(cases) // columns)
    figure, axes = grid_of_axes(0.9 + 2.3 * lines, lines, columns, sharex=True, sharey=True)
    for ax, case in zip(axes.flat, cases, strict=False):
        _draw(ax, chosen, case)
    for ax in axes.flat[len(cases) :]:
        ax.set_axis_off()
    figure.supxlabel("time of one evaluation [s]" if table == "quadrature" else "run time [s]", fontsize=9)
    figure.supylabel(error, fontsize=9)
    legend_above(figure, axes[0, 0])
    return figure


FIGURES = {
    "quadrature": "relative error [-]",
    "integrators": "largest error of heave over its range [-]",
}


def benchmark(study: Study, folder: str | Path) -> None:
    """Measure everything on the designs of a study.

    Writes `workprecision.csv`, `workprecision/quadrature.svg` and `workprecision/integrators.svg` into the folder.
    """
    say(f"{study.study}: quadrature")
    rows = quadrature_precision(study)
    for design in study.designs:
        say(f"{study.study}: integrators, {design}")
        rows += integrator_precision(study, design)
    rows += paper_precision(study)
    write_text(Path(folder) / "workprecision.csv", as_csv(rows, COLUMNS))
    for name, error in FIGURES.items():
        write_text(Path(folder) / "workprecision" / f"{name}.svg", svg_text(precision_figure(rows, name, error)))
