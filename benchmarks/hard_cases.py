"""Hard cases: studies at the edge of what the model can do, each run in one process and judged.

A case is a study file with changes, and what it must come to: a finished motion or a refusal in one line. Everything
else, a traceback, a motion that is not finite, the wrong one of the two, is `wrong`, and so is a motion far from its
reference. References are another method where there is one (Cummins' convolution for exact propagation and the other
way round), and the same method at a hundredth of the tolerance elsewhere. A few cases are no studies but `probe`s.
"""

import math
import tempfile
import time as clock
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from examples import paper_rotations as multibody
from vsb.engine.hydro.database import load_database
from vsb.engine.hydro.radiation import DampingSpectrum, fit_radiation
from vsb.engine.integrators.audit import energies, residual
from vsb.engine.integrators.exact import convolve, propagate
from vsb.engine.integrators.exponential import integrate
from vsb.engine.integrators.simulate import CONVOLVED, simulate
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.system import Motion, System
from vsb.engine.shell.device import Device
from vsb.engine.shell.modes import constraint_drift, rigid_basis
from vsb.errors import ConfigError, VsbError
from vsb.keys.reading import read_yaml
from vsb.models.build import design_in_sea
from vsb.models.rest import design_motions, reference_shell, study_basis
from vsb.pipeline.graph import StudyPlan
from vsb.stages.make import hydro_files
from vsb.study.study import Study, parse
from vsb.tools.arrays import FloatArray
from vsb.tools.files import write_text
from vsb.tools.stamps import check_table
from vsb.tools.words import csv_text

Outcome = Literal["completed", "refused", "not finite", "traceback"]
Verdict = Literal["ok", "doubt", "wrong"]
CONVOLVED_STEP, CONVOLVED_INSTANTS = 0.002, 2000
"""Largest step of a reference by convolution [s], and how many instants of it: its work grows with their square."""
FIT_ERRORS = 5.0
"""Exact propagation may differ from the convolution by so many tolerances of the radiation model."""
LOCAL_ERRORS = 10.0
"""The exponential Adams method may be off by so many tolerances: local errors add up over a run."""
ENERGY_LIMIT = 1e-6
"""Energy residual of a sound run [-], as in the validity ledger."""
FAR = 3.0
"""A motion of more radii is mentioned: the buoy is lost [-]."""
DOUBTFUL = 100.0
"""An error of so many times its limit is a doubt, more is wrong."""


@dataclass(frozen=True)
class Case:
    """A study file with changes, or a probe, and what it must come to."""

    name: str
    expected: Literal["completed", "refused"] = "completed"
    base: str = ""  # study file, beside the file of the cases
    designs: tuple[str, ...] = ("-",)
    overrides: dict[str, Any] = field(default_factory=dict)
    wet_mode: int | None = None  # the wave gets the period of this natural mode, 0: the slowest
    probe: str = "simulation"

    @classmethod
    def of(cls, name: str, given: object, folder: Path) -> "Case":
        """Return a case from its entry in the file.

        Raises
        ------
        ConfigError
            If an entry has unknown keys or names no probe there is.
        """
        known = {f.name for f in fields(cls)} - {"name"}
        if not isinstance(given, dict) or not given.keys() <= known:
            raise ConfigError(f"case {name}: received {given!r}, needs a mapping with keys among {sorted(known)}")
        if not isinstance(given.get("base", ""), str) or not isinstance(given.get("designs", []), list):
            raise ConfigError(f"case {name}: received {given!r}, needs a path as base and a list of designs")
        base = str(folder / given["base"]) if "base" in given else ""
        case = cls(name, **{**given, "base": base, "designs": tuple(given.get("designs", ("-",)))})
        if case.probe not in PROBES or case.expected not in ("completed", "refused"):
            wanted = f"needs one of {', '.join(PROBES)} and completed or refused"
            raise ConfigError(f"case {name}: received probe {case.probe!r} and expected {case.expected!r}, {wanted}")
        return case


@dataclass(frozen=True)
class Result:
    """What a run came to; None: there is no such quantity."""

    finished: Outcome
    method: str = ""
    error: float | None = None  # largest, over the largest range of any coordinate [-]
    steps: int | None = None
    energy_residual: float | None = None
    message: str = ""
    error_limit: float = math.inf
    energy_limit: float = math.inf
    warned: bool = False


@dataclass(frozen=True)
class Row:
    """Row of the table."""

    case: str
    design: str
    method: str
    finished: Outcome
    error: float | None
    steps: int | None
    seconds: float  # of everything not made by an earlier row, the reference too
    energy_residual: float | None
    verdict: Verdict
    message: str


COLUMNS = tuple(f.name for f in fields(Row))


def load_cases(path: str | Path) -> list[Case]:
    """Return the cases of a file.

    Raises
    ------
    ConfigError
        If it is no file of cases by name.
    """
    entries = read_yaml(path, "a file of cases such as config/hard_cases.yaml")
    if not isinstance(entries, dict):
        raise ConfigError(f"{path}: received {type(entries).__name__}, needs a mapping of cases by name")
    return [Case.of(name, given, Path(path).parent) for name, given in entries.items()]


def changed(base: dict[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return nested mappings with some values replaced; designs are replaced as a whole."""
    out = dict(base)
    for key, value in overrides.items():
        nested = isinstance(value, dict) and isinstance(out.get(key), dict) and key != "designs"
        out[key] = changed(out[key], value) if nested else value
    return out


def case_study(case: Case) -> Study:
    """Return the study of a case; nothing published applies to it."""
    raw = read_yaml(case.base, "a study file, as base of a case")
    if not isinstance(raw, dict):
        raise ConfigError(f"{case.base}: received {type(raw).__name__}, needs a study, as base of case {case.name}")
    return parse({**changed(raw, case.overrides), "published": None}, source=case.name)


# simulation ---------------------------------------------------------------------------------------------------------


def simulated(case: Case, design: str, folder: str | Path) -> Result:
    """Run one design of a case as the workflow does, and measure it against its reference."""
    study = case_study(case)
    paths, note = hydro_files(study, folder), ""
    if case.wet_mode is not None:
        omega = natural_frequency(study, design, paths, case.wet_mode)
        study, note = with_period(study, 2 * math.pi / omega), f"wave at the natural frequency {omega:.6g} rad/s"
    one = StudyPlan(study).simulation(design, study.waves[0]).spec["run"]
    made = design_in_sea(one, paths)
    scene, rows = made.scene, made.held
    motion, _, method = simulate(system := System.of(scene), made.sea, study.simulation, made.spectrum)
    moved = motion.position @ scene.motions.T
    if rows.size:
        note = f"clamps slip {constraint_drift(moved, rows):.1e} m"
    if (far := float(np.abs(moved).max()) / study.device.radius) > FAR:
        note = f"{note}; moves by {far:.2g} radii".lstrip("; ")
    return measured(study, system, motion, method, made.spectrum, note)


def with_period(study: Study, period: float) -> Study:
    """Return a study with its first wave, a regular one, of another period."""
    return parse(study.model_dump() | {"waves": [study.waves[0].model_dump() | {"period": period}]}, source=study.study)


def natural_frequency(study: Study, design: str, paths: dict[str, Any], index: int) -> float:
    """Return a natural frequency of a design in water [rad/s]; with an assumed pressure water has no inertia."""
    basis = study_basis(study)
    motions = design_motions(study, basis, design)
    if study.needs_bem:
        ds = load_database(paths["database"], Path(paths["database"]).stem)
        return float(LinearSystem(ds, basis.damping, LinearPto(0.0)).natural_modes(motions)[0][index])
    stiffness = motions.T @ reference_shell(study).total @ motions
    return float(np.sqrt(eigh(stiffness, motions.T @ basis.inertia @ motions, eigvals_only=True)[index]))


def measured(
    study: Study, system: System, motion: Motion, method: str, spectrum: DampingSpectrum | None, note: str = ""
) -> Result:
    """Return the result of a motion: its energy audit, and its error against the reference of its method."""
    name, _, steps = method.partition(", ")
    taken = int(steps.split()[0]) if steps else len(motion.time) - 1
    if not (np.isfinite(motion.position).all() and np.isfinite(motion.velocity).all()):
        return Result("not finite", name, steps=taken, message="the motion is not finite")
    tolerance = study.simulation.tolerance
    allowed = LOCAL_ERRORS * tolerance if not system.linear else max(FIT_ERRORS * study.hydro.tolerance, tolerance)
    try:
        error = reference_error(study, system, motion, name, spectrum)
    except VsbError as failed:
        error, note = None, f"{note}; no reference: {failed}".lstrip("; ")
    balanced = max(CONVOLVED if name == "convolution" else ENERGY_LIMIT, tolerance)
    return Result("completed", name, error, taken, residual(energies(system, motion)), note, allowed, balanced)


def reference_error(
    study: Study, system: System, motion: Motion, method: str, spectrum: DampingSpectrum | None
) -> float | None:
    """Return the largest difference of a motion from its reference, over the largest range of any coordinate."""
    start = system.scene.start(study.simulation.initial_position, study.simulation.initial_velocity)
    if not system.linear:
        tight = max(study.simulation.tolerance / 100, 1e-13)
        return _difference(motion.position, integrate(system, motion.time, start, tight)[0].position)
    if method == "convolution":
        return _difference(motion.position, propagate(system, motion.time, start).position)
    if spectrum is None:
        return None
    dt = motion.time[1] - motion.time[0]
    finer = math.ceil(dt / CONVOLVED_STEP)
    count = min(len(motion.time) - 1, max(CONVOLVED_INSTANTS // finer, 1))
    reference = convolve(system, spectrum, np.linspace(0.0, count * dt, count * finer + 1), start)
    return _difference(motion.position[: count + 1], reference.position[::finer])


def _difference(found: FloatArray, reference: FloatArray) -> float:
    """Largest difference over the largest range of any coordinate; of motion that hardly exists, in metres."""
    largest = float(np.ptp(reference, axis=0).max())
    return float(np.abs(found - reference).max() / (largest if largest > 1e-12 else 1.0))


# probes -------------------------------------------------------------------------------------------------------------


def turned(case: Case, design: str, folder: str | Path) -> Result:
    """Pitch a free rigid sphere through a right angle; it turns steadily, so the attitude is known."""
    device = Device(radius=2.0, thickness=0.01, young_modulus=1e7, poisson_ratio=0.3, density=2700.0, mass=17170.0)
    scene = multibody.GeneralScene(multibody.Body(rigid_basis(device)), {}, "free")
    time, w = np.linspace(0.0, 4.0, 41), np.array([0.0, 1.0, 0.0])
    motion = multibody.integrate(scene, scene.start(angular_velocity=w), time)
    exact = Rotation.from_rotvec(time[:, None] * w).as_matrix()
    error = float(np.abs([scene.state(y).rotation for y in motion] - exact).max())
    kinetic = np.array([scene.body.kinetic_energy(scene.state(y)) for y in motion])
    drift = float(np.ptp(kinetic) / kinetic[0])
    return Result("completed", "quaternion", error, len(time) - 1, drift, "", 1e-7, 1e-8)


def fitted(change: Callable[[FloatArray], FloatArray], case: Case, design: str, folder: str | Path) -> Result:
    """Fit a radiation model to damping that is not passive; what comes out must be."""
    omega = np.arange(0.1, 8.05, 0.1)
    damping = 1e4 * omega**3 / (1 + omega**6 / 64) * change(omega)
    model, error = fit_radiation(DampingSpectrum(omega, damping[:, None, None]), 1e-3)
    least = float(model.damping(np.linspace(0.05, 20.0, 400)).min() / np.abs(damping).max())
    finished: Outcome = "completed" if least >= -1e-12 else "not finite"
    note = f"least damping of the model {least:.1e} of the largest, given {damping.min() / np.abs(damping).max():.2g}"
    return Result(finished, "passive fit", error, model.order, None, note, 5e-3)


PROBES: Mapping[str, Callable[[Case, str, str | Path], Result]] = {
    "simulation": simulated,
    "quaternion": turned,
    "negative_damping": partial(fitted, lambda omega: -np.ones_like(omega)),
    "partly_negative_damping": partial(fitted, lambda omega: np.where(omega > 5.0, -0.5, 1.0)),
    "slightly_negative_damping": partial(fitted, lambda omega: np.where(np.abs(omega - 6.0) < 0.3, -0.1, 1.0)),
    "damping_not_a_number": partial(fitted, lambda omega: np.where(omega > 5.0, np.nan, 1.0)),
}
"""What a case may run."""


# judgement ----------------------------------------------------------------------------------------------------------


def judged(expected: str, result: Result) -> Verdict:
    """Return the verdict on a result.

    An energy audit that does not close is a doubt where a reference vouches for the motion: body-exact forces are made
    polynomials between records, which a slam or a fast ring may defy where the motion itself follows it.
    """
    if result.finished != expected or "\n" in result.message:
        return "wrong"
    pairs = ((result.error, result.error_limit), (result.energy_residual, result.energy_limit))
    excess = [value / limit for value, limit in pairs if value is not None]
    if not np.isfinite(excess).all() or (excess and excess[0] > DOUBTFUL):
        return "wrong"
    return "doubt" if max(excess, default=0.0) > 1.0 or result.warned else "ok"


def attempted(run: Callable[[], Result]) -> Result:
    """Return the result of a run whatever happens; a refusal is a result, and so is a traceback."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", RuntimeWarning)
        try:
            result = run()
        except VsbError as error:
            result = Result("refused", message=str(error))
        except Exception as error:  # the point of the table is to show it
            result = Result("traceback", message=f"{type(error).__name__}: {' '.join(str(error).split())}")
    if caught:
        first = " ".join(str(caught[0].message).split())
        result = replace(result, warned=True, message=f"{result.message}; warning: {first}".lstrip("; "))
    return result


def run_case(case: Case, folder: str | Path) -> list[Row]:
    """Return a row for every design of a case."""
    rows = []
    for design in case.designs:
        begun = clock.perf_counter()
        result = attempted(partial(PROBES[case.probe], case, design, folder))
        seconds = clock.perf_counter() - begun
        kept = {name: getattr(result, name) for name in COLUMNS if hasattr(result, name)}
        rows.append(Row(case=case.name, design=design, seconds=seconds, verdict=judged(case.expected, result), **kept))
    return rows


def run_cases(cases: Iterable[Case], folder: str | Path) -> list[Row]:
    """Run every case and return the rows; hydrodynamic files the cases share are kept in a folder."""
    return [row for case in cases for row in run_case(case, folder)]


# output -------------------------------------------------------------------------------------------------------------


def as_csv(rows: Sequence[Row]) -> str:
    """Return the table as CSV; an empty cell is a quantity that does not exist."""
    return csv_text(COLUMNS, (asdict(row).values() for row in rows), 4)


def benchmark(path: str | Path, out: str | Path) -> list[Row]:
    """Run the cases of a file; write the table as CSV, print the rows that are not ok and how many of each verdict."""
    check_table(out, COLUMNS)
    with tempfile.TemporaryDirectory() as folder:
        rows = run_cases(load_cases(path), folder)
    write_text(out, as_csv(rows))
    for row in rows:
        if row.verdict != "ok":
            print(f"{row.case}, {row.design}: {row.verdict}: {row.finished} by {row.method}: {row.message}")
    counts = Counter(row.verdict for row in rows)
    print(", ".join(f"{counts[verdict]} {verdict}" for verdict in ("ok", "doubt", "wrong")), out, sep="\n")
    return rows
