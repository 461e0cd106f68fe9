"""How processor time grows: with duration, frequencies, modes, designs and points of a campaign, at three sizes each.

Duration and frequencies are one stage in this process, with all it does; modes, designs and points are whole commands,
each on one core in a process and a folder of its own. Beside each time stands an error: of duration that of the energy
absorbed against a run at a hundredth of the tolerance, of frequencies the largest of the coefficients, of modes that of
the mean power against the largest degree. More designs or points must not change those there are: their error is the
difference of the first one's power from that of the smallest size.
"""

import resource
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

import vsb
from benchmarks import coefficients
from benchmarks.measure import CONFIG, Row, as_csv, on_one_core, run_python, say, timed, written
from benchmarks.time_domain import IRREGULAR, SEAS, varied
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.shell.deformed import rigid_sphere
from vsb.pipeline.graph import StudyPlan
from vsb.stages.make import hydro_files
from vsb.stages.stage import run_task
from vsb.study.study import load
from vsb.tools.files import write_text

COLUMNS = ("direction", "size", "seconds", "error")
DURATIONS, TOLERANCE = (150, 300, 600), 1e-6
FREQUENCIES, NODES = (15, 60, 240), 16
DEGREES, DESIGNS, POINTS = (12, 24, 48), (2, 6, 18), (25, 100, 300)


def by_duration() -> Iterator[Row]:
    """A body-exact run in a JONSWAP sea: waves, motion, audit of energy, record, file."""
    study = load(CONFIG / "few_modes.yaml")
    with tempfile.TemporaryDirectory() as folder:

        def run(duration: float, tolerance: float) -> tuple[float, float]:
            one = varied(study, "VSWEC0", SEAS[IRREGULAR], {"model": "body_exact", "omega_max": 12.0}, duration)
            one = one.model_copy(update={"simulation": one.simulation.model_copy(update={"tolerance": tolerance})})
            paths, out = hydro_files(one, folder), str(Path(folder, "run.nc"))
            task = StudyPlan(one).simulation("VSWEC0", one.waves[0])
            task = replace(task, files={"out": out, "database": paths["database"], "radiation": paths["radiation"]})
            seconds, _ = timed(lambda: run_task(task))
            with xr.open_dataset(out) as record:
                return seconds, float(record.energy.sel(term="pto")[-1])

        run(10.0, TOLERANCE)  # compiles
        for duration in DURATIONS:
            (seconds, energy), (_, exact) = (run(duration, TOLERANCE / by) for by in (1, 100))
            yield {"size": duration, "seconds": seconds, "error": abs(energy / exact - 1)}


def by_frequencies() -> Iterator[Row]:
    """The spectral solver on a floating hemisphere in seven motions, its set-up included."""
    own = np.sqrt(coefficients.KA)
    for count in FREQUENCIES:
        omegas = np.union1d(own, np.linspace(own[0], own[-1], count - len(own) + 2)).tolist()

        def solve(omegas: list[float] = omegas) -> xr.Dataset:
            hull = rigid_sphere(1.0, 0.0)
            return SpectralProblem(hull, coefficients.DISPLACEMENTS, 1.0, 1.0, NODES).solve(omegas)

        seconds, found = min((timed(solve) for _ in range(3)), key=lambda one: one[0])
        yield {"size": count, "seconds": seconds, "error": coefficients.errors(found)["error"]}


def by_modes() -> Iterator[Row]:
    """A study of two designs in a regular wave, page and figures included."""
    rows, powers = zip(*(_study({"modes": {"degree": degree}}, degree) for degree in DEGREES), strict=True)
    for row, power in zip(rows[:-1], powers[:-1], strict=True):
        yield {**row, "error": abs(power / powers[-1] - 1)}
    yield rows[-1]


def by_designs() -> Iterator[Row]:
    """The same of shells clamped at different colatitudes."""
    clamped = {f"C{10 * i}": {"clamp": 10.0 * i} for i in range(max(DESIGNS))}
    return _unchanged(
        _study({"modes": {"degree": 6}, "designs": dict(list(clamped.items())[:count])}, count) for count in DESIGNS
    )


def _study(changed: Mapping[str, object], size: int) -> tuple[Row, float]:
    """Seconds of a study and the mean power of its first flexible design."""
    given = {"designs": {"FSB": {"flexible": False}, "C0": {"clamp": 0}}, "hydro": {"model": "linear"}}
    seconds, found = command("few_modes.yaml", given | dict(changed))
    return {"size": size, "seconds": seconds}, float(found.set_index("design").power_mean["C0"])


def by_points() -> Iterator[Row]:
    """A campaign of the example about its equilibrium over a measured year, by the spring of its take-off."""

    def run(count: int) -> tuple[Row, float]:
        springs = np.linspace(0.0, 4e4, count).tolist()
        seconds, found = command("year.yaml", {"vary": {"pto.stiffness": springs}, "tuning": ["one"], "verify": None})
        return {"size": count, "seconds": seconds}, float(found.annual_mean_power.iloc[0])

    return _unchanged(run(count) for count in POINTS)


def _unchanged(found: Iterator[tuple[Row, float]]) -> Iterator[Row]:
    """Rows with the difference of the first design or point from that of the smallest size."""
    first = None
    for row, power in found:
        first = first or power
        yield {**row, "error": abs(power / first - 1)}


def command(file: str, changed: Mapping[str, object]) -> tuple[float, pd.DataFrame]:
    """Return the processor time of `vsb run` on a file with some keys changed, cold [s], and the table it wrote."""
    with tempfile.TemporaryDirectory() as folder:
        name = written(file, changed, folder)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        run_python(folder, "-m", "vsb", "run", "one.yaml")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        found = vsb.open(Path(folder, "results", name))
        assert isinstance(found, vsb.Results | vsb.Campaign)
        table = found.comparison if isinstance(found, vsb.Results) else found.table
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, table


DIRECTIONS: Mapping[str, Callable[[], Iterator[Row]]] = {
    "duration": by_duration,
    "frequencies": by_frequencies,
    "modes": by_modes,
    "designs": by_designs,
    "points": by_points,
}


def benchmark(out: str | Path) -> list[Row]:
    """Measure every direction and write a table."""
    on_one_core()
    rows = []
    for direction, measured in DIRECTIONS.items():
        for row in measured():
            rows.append({"direction": direction, **row})
            say(str(rows[-1]))
    write_text(out, as_csv(rows, COLUMNS))
    return rows
