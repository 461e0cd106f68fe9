"""Work and precision: error against seconds of the wet forces and of the integrators, measured in one run.

General integrators, Dormand and Prince's (the paper's ode45) among them, get the same compiled right-hand side as ours.
Seconds are of one core of the machine that ran the benchmark.
"""

import csv
import io
import sys
import time as clock
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.integrate import simpson, solve_ivp

from benchmarks.quadrature import (
    Row,
    design_plant,
    disc_force,
    gauss_force,
    quadrature_precision,
    regular_wave,
    water_and_weight,
)
from vsb.errors import ConvergenceError
from vsb.integrators.exponential import integrate
from vsb.motion.motion import Motion
from vsb.motion.scene import Damper, Plant, Spring
from vsb.motion.wetted import Shape, wet_force
from vsb.report.canvas import grid_of_axes, legend_above
from vsb.shell.deformed import DeformedShell
from vsb.study.study import Study
from vsb.tools.compiled import njit
from vsb.tools.files import write_text
from vsb.tools.units import FloatArray

COLUMNS = (
    "table", "case", "method", "setting", "error", "error_energy", "seconds", "steps", "evaluations", "order",
    "published_seconds", "ratio", "status",
)  # fmt: skip
PUBLISHED_SECONDS = {True: 2.4 * 3600, False: 2.11 * 60}
"""Run time of the paper's buoys, flexible and fixed [s]: "2.4 hours" and "2.11 minutes" with MATLAB's ode45, at the
start of its simulation results; neither the machine nor the tolerance is stated."""
PUBLISHED_DURATION = 60.0
"""Of the motion in the paper's Table II [s]."""
Solver = Literal["RK45", "DOP853", "Radau", "BDF", "LSODA"]
Function = Callable[[float, FloatArray], FloatArray]
EXPONENTIAL = "exponential Adams"
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
SOLVERS: Mapping[Solver, Sequence[float]] = {
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


class Scene(NamedTuple):
    """What the compiled right-hand side needs: y'' = R (f_water + weight) - K y - D y', q = N y."""

    shape: Shape
    motions: FloatArray  # N (dof, free)
    project: FloatArray  # R = (N^T M N)^-1 N^T (free, dof)
    stiffness: FloatArray  # (free, free) [1/s^2]
    damping: FloatArray  # (free, free) [1/s]
    weight: FloatArray  # (dof,) [N]
    specific_weight: float
    amplitude: float
    omega: float

    @classmethod
    def of(cls, plant: Plant) -> "Scene":
        """Scene of a body-exact plant."""
        water, weight = water_and_weight(plant)
        assert water.assumed is not None  # built by `design_plant`
        inverse = np.linalg.inv(plant.motions.T @ plant.mass @ plant.motions)
        return cls(
            water.shell.shape,
            np.ascontiguousarray(plant.motions),
            np.ascontiguousarray(inverse @ plant.motions.T),
            inverse @ plant.total(Spring),
            inverse @ plant.total(Damper),
            weight,
            water.specific_weight,
            water.assumed.amplitude,
            water.assumed.omega,
        )


@njit(cache=True)
def rates(t: float, state: FloatArray, s: Scene) -> FloatArray:
    """Return (y', y'') of (y, y'), compiled, in plain coordinates: what a general integrator is given."""
    n = s.motions.shape[1]
    y, v = np.ascontiguousarray(state[:n]), np.ascontiguousarray(state[n:])
    q = s.motions @ y
    static, uniform, out = np.empty(len(q)), np.empty(len(q)), np.empty(2 * n)
    wet_force(s.shape, q, static, uniform)
    force = s.specific_weight * static + s.amplitude * np.cos(s.omega * t) * uniform + s.weight
    out[:n] = v
    out[n:] = s.project @ force - s.stiffness @ y - s.damping @ v
    return out


def plain_rates(plant: Plant, rule: Rule, points: int) -> Function:
    """Return the same right-hand side with forces by `gauss_force` or `disc_force`, no compiled code."""
    s, shell, n = Scene.of(plant), water_and_weight(plant)[0].shell, plant.motions.shape[1]

    def function(t: float, state: FloatArray) -> FloatArray:
        static, uniform = rule(DeformedShell(shell.basis, shell.centre_height, s.motions @ state[:n]), points)
        force = s.specific_weight * static + s.amplitude * np.cos(s.omega * t) * uniform + s.weight
        return np.concatenate([state[n:], s.project @ force - s.stiffness @ state[:n] - s.damping @ state[n:]])

    return function


class Attempt(NamedTuple):
    """One run of an integrator; heave and its velocity only if it completed."""

    heave: FloatArray  # (time,) [m]
    velocity: FloatArray  # (time,) [m/s]
    seconds: float
    steps: int
    evaluations: int | None  # not counted by the exponential integrator
    status: str = "completed"


@dataclass(frozen=True)
class Case:
    """The motion of one design in the regular wave of a study, 200 instants a period, and its converged solution."""

    study: Study
    design: str

    @cached_property
    def plant(self) -> Plant:
        """The scene."""
        return design_plant(self.study, self.design)

    @cached_property
    def time(self) -> FloatArray:
        """Recorded instants, shape (time,) [s]."""
        duration = self.study.simulation.duration
        return np.linspace(0.0, duration, int(np.ceil(200 * duration / regular_wave(self.study).period)) + 1)

    @property
    def start(self) -> tuple[FloatArray, FloatArray]:
        """Initial y and y'."""
        settings = self.study.simulation
        return self.plant.start(settings.initial_position, settings.initial_velocity)

    @cached_property
    def reference(self) -> Motion:
        """Converged solution: exponential Adams at 1e-11; DOP853 at 1e-12 checks it in the table."""
        return integrate(self.plant, self.time, self.start, 1e-11)[0]

    def exponential(self, tolerance: float) -> Attempt:
        """Run our integrator; its seconds hold everything but compilation."""
        begun = clock.perf_counter()
        try:
            motion, steps = integrate(self.plant, self.time, self.start, tolerance)
        except ConvergenceError as error:
            return Attempt(np.zeros(0), np.zeros(0), clock.perf_counter() - begun, 0, None, str(error))
        return Attempt(motion.position[:, 0], motion.velocity[:, 0], motion.seconds, steps, None)

    def errors(self, attempt: Attempt) -> Row:
        """Largest error of heave over its range, and error of the absorbed energy; none of a run that failed."""
        count, damping = len(attempt.heave), self.study.pto.damping
        if not count:
            return {}
        heave, velocity = self.reference.position[:count, 0], self.reference.velocity[:count, 0]
        error = float(np.abs(attempt.heave - heave).max() / np.ptp(heave))
        exact, found = (float(simpson(v**2, x=self.time[:count])) for v in (velocity, attempt.velocity))
        return {"error": error, "error_energy": abs(found / exact - 1) if damping else None}

    def row(self, method: str, tolerance: float, attempt: Attempt) -> Row:
        """Row of the table."""
        found = {key: getattr(attempt, key) for key in ("seconds", "steps", "evaluations", "status")}
        named = {"table": "integrators", "case": self.design, "method": method, "setting": tolerance}
        return {**named, **self.errors(attempt), **found}


@dataclass
class Counted:
    """A right-hand side that counts its calls and gives up at a deadline."""

    function: Function
    deadline: float
    calls: int = 0

    def __call__(self, t: float, state: FloatArray) -> FloatArray:
        """Return the rates; `TimeoutError` after the deadline."""
        self.calls += 1
        if clock.perf_counter() > self.deadline:
            raise TimeoutError(f"stopped after its limit at t = {t:.4g} s")
        return self.function(t, state)

    def fill(self, t: float, state: FloatArray, out: FloatArray) -> None:
        """Fill the rates, as CVODE wants them."""
        out[:] = self(t, state)


def solve(
    case: Case, method: Solver, tolerance: float, function: Function, count: int, limit: float = TIME_LIMIT
) -> Attempt:
    """Return the motion at the first `count` instants by an integrator of scipy.

    Its tolerance is relative, and absolute in m and m/s. Failures are results: the status says what happened.
    """
    begun = clock.perf_counter()
    counted, time, none = Counted(function, begun + limit), case.time[:count], np.zeros(0)
    try:
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            span, first = (0.0, float(time[-1])), np.concatenate(case.start)
            out = solve_ivp(counted, span, first, method, rtol=tolerance, atol=tolerance, dense_output=True)
            if out.status < 0 or out.sol is None:
                raise ArithmeticError(str(out.message))
            states = out.sol(time)
            if not np.isfinite(states).all():
                raise ArithmeticError("the motion is not finite")
    except (ArithmeticError, TimeoutError, ValueError, np.linalg.LinAlgError) as error:
        return Attempt(none, none, clock.perf_counter() - begun, 0, counted.calls, str(error))
    half = len(states) // 2
    return Attempt(states[0], states[half], clock.perf_counter() - begun, len(out.t) - 1, counted.calls)


def _best(run: Callable[[], Attempt]) -> Attempt:
    """The fastest of three; the first alone where it takes more than a second."""
    first = run()
    return first if first.seconds > 1.0 else min(first, run(), run(), key=lambda attempt: attempt.seconds)


def integrator_precision(study: Study, design: str) -> list[Row]:
    """Return error and seconds of the exponential Adams method and of general integrators on the motion of one design.

    All of scipy's are given the same compiled right-hand side, `rates`. With plain NumPy forces RK45 follows the first
    second alone, and the error is of that; the seconds are those of one evaluation there times the evaluations of the
    compiled run of the same tolerance, as the status says.
    """
    case = Case(study, design)
    scene, count = Scene.of(case.plant), len(case.time)

    def compiled(t: float, state: FloatArray) -> FloatArray:
        return np.asarray(rates(t, state, scene))

    rows = [case.row(EXPONENTIAL, tol, _best(partial(case.exponential, tol))) for tol in TOLERANCES]
    for method, tolerances in SOLVERS.items():
        solve(case, method, tolerances[0], compiled, 2)  # compiles and loads
        rows += [case.row(method, tol, _best(partial(solve, case, method, tol, compiled, count))) for tol in tolerances]
    check = case.row("DOP853", 1e-12, solve(case, "DOP853", 1e-12, compiled, count, 3 * TIME_LIMIT))
    same = next(row for row in rows if (row["method"], row["setting"]) == ("RK45", PLAIN_TOLERANCE))
    return [*rows, {**check, "table": "reference"}, *plain_rows(case, same)]


def plain_rows(case: Case, compiled: Row) -> list[Row]:
    """Return rows of RK45 with plain NumPy forces, from a short piece of the motion and the row of the compiled run."""
    count = min(len(case.time), int(np.searchsorted(case.time, PLAIN_SPAN)) + 1)
    rows = []
    for method, (rule, points) in PLAIN.items():
        attempt = solve(case, "RK45", PLAIN_TOLERANCE, plain_rates(case.plant, rule, points), count)
        seconds = attempt.seconds / (attempt.evaluations or 1) * compiled["evaluations"]
        note = f"{attempt.status}: {case.time[count - 1]:.3g} s of motion, seconds for the evaluations of compiled RK45"
        counts = {key: compiled[key] for key in ("steps", "evaluations")}
        rows.append({**case.row(method, PLAIN_TOLERANCE, attempt), **counts, "seconds": seconds, "status": note})
    return rows


def paper_precision(study: Study) -> list[Row]:
    """Return seconds and error of our run of every design at the study's tolerance, beside the published run time.

    The published time is of 60 s of motion on a machine the paper does not name; the ratio is a fact about what a user
    waits for, not about two machines. A study of another duration has none.
    """
    rows = []
    for name, design in study.designs.items():
        case, tolerance = Case(study, name), study.simulation.tolerance
        row = case.row(EXPONENTIAL, tolerance, _best(partial(case.exponential, tolerance)))
        published = PUBLISHED_SECONDS[design.flexible] if study.simulation.duration == PUBLISHED_DURATION else None
        ratio = published / row["seconds"] if published else None
        rows.append({**row, "table": "paper", "published_seconds": published, "ratio": ratio})
    return rows


# output -------------------------------------------------------------------------------------------------------------


def as_csv(rows: Sequence[Row], columns: Sequence[str] = COLUMNS) -> str:
    """Return the table as CSV; an empty cell is a quantity that does not exist, such as the error of a failed run."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, restval="", lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({key: f"{v:.6g}" if isinstance(v, float) else v for key, v in row.items()})
    return text.getvalue()


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
    _say(f"{study.study}: quadrature")
    rows = quadrature_precision(study)
    for design in study.designs:
        _say(f"{study.study}: integrators, {design}")
        rows += integrator_precision(study, design)
    rows += paper_precision(study)
    write_text(Path(folder) / "workprecision.csv", as_csv(rows))
    for name, error in FIGURES.items():
        text = io.StringIO()
        precision_figure(rows, name, error).savefig(text, format="svg", metadata={"Date": None})
        write_text(Path(folder) / "workprecision" / f"{name}.svg", text.getvalue())


def _say(line: str) -> None:
    """Progress, for the terminal only."""
    print(line, file=sys.stderr, flush=True)
