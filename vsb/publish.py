"""The last two rules: all figures of a study, and its report."""

import csv
import io
import json
import time as clock
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from vsb import __version__, database
from vsb.config import StillWater, Study, parse
from vsb.figures import StudyData, draw
from vsb.report import Report, render
from vsb.specs import figure_names, solver_version
from vsb.units import load, write_text


def _study(path: str) -> Study:
    """The study in canonical form."""
    return parse(json.loads(Path(path).read_text(encoding="utf-8")), source=path)


def study_data(paths: dict[str, Any], trajectories: Sequence[str]) -> StudyData:
    """Return everything the figures are drawn from."""
    study = _study(paths["study"])
    response = load(paths["response"])
    wet = response.wet_natural_frequency.values
    return StudyData(
        designs=tuple(study.designs),
        reference=study.reference_design,
        wave_frequencies=tuple(wave.omega for wave in study.waves if not isinstance(wave, StillWater)),
        periods={w.label: 2 * np.pi / (wet.min() if isinstance(w, StillWater) else w.omega) for w in study.waves},
        window=study.simulation.window,
        modes=load(paths["modes"]),
        database=database.load_database(paths["database"], Path(paths["database"]).stem),
        radiation=load(paths["radiation"]),
        response=response,
        runs={(run.attrs["design"], run.attrs["wave"]): run for run in map(load, trajectories)},
    )


def figures(paths: dict[str, Any], trajectories: Sequence[str]) -> None:
    """Draw and write all figures of a study as SVG."""
    data = study_data(paths, trajectories)
    for name in figure_names(list(data.periods)):
        text = io.StringIO()
        draw(name, data).savefig(text, format="svg", metadata={"Date": None})
        write_text(Path(paths["out"]) / f"{name}.svg", text.getvalue())


def report(paths: dict[str, Any], trajectories: Sequence[str]) -> None:
    """Write the report of a study."""
    study = _study(paths["study"])
    with Path(paths["table"]).open(encoding="utf-8", newline="") as handle:
        rows = list(csv.DictReader(handle))
    names = figure_names([wave.label for wave in study.waves])
    page = Report(
        study=study.model_dump(),
        seas={wave.label: wave.description for wave in study.waves},
        rows=rows,
        checks=json.loads(Path(paths["validity"]).read_text(encoding="utf-8"))["checks"],
        response=load(paths["response"]),
        reference=study.reference_design,
        figures={name: (Path(paths["figures"]) / f"{name}.svg").read_text(encoding="utf-8") for name in names},
        facts=_facts(study, paths, [load(path) for path in trajectories]),
    )
    write_text(paths["out"], render(page))


def _facts(study: Study, paths: dict[str, Any], runs: Sequence[xr.Dataset]) -> dict[str, str]:
    """How the results were made, in words."""
    ds = database.load_database(paths["database"], Path(paths["database"]).stem)
    radiation = load(paths["radiation"]).attrs
    return {
        "Program": f"vsb {__version__}, {solver_version()}, {clock.strftime('%Y-%m-%d')}",
        "Hydro database": f"{Path(paths['database']).name}: {ds.sizes['omega']} frequencies up to "
        f"{float(ds.omega[-1]):g} rad/s, {ds.sizes['influenced_dof']} degrees of freedom",
        "Seconds of BEM": f"{ds.attrs['bem_seconds']:.1f} on one core",
        "Radiation model": f"{radiation['order']} states, rms error {radiation['fit_error']:.1e}, "
        f"fitted in {radiation['seconds']:.1f} s",
        "Time domain": f"{runs[0].attrs['method']}, {study.simulation.duration:g} s of motion in "
        f"{max(run.attrs['seconds'] for run in runs):.3f} s or less per design and sea",
        "Largest energy residual": f"{max(run.attrs['energy_residual'] for run in runs):.1e}",
        "Study": json.dumps(study.model_dump(mode="json"), default=str),
    }
