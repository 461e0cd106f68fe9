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

from vsb import __version__
from vsb.hydro import database
from vsb.report.canvas import StudyData
from vsb.report.figures import draw
from vsb.report.page import Report, render
from vsb.results.statistics import families
from vsb.stages.stage import stored_runs
from vsb.study.plan import figure_names
from vsb.study.study import StillWater, Study, Wave, parse
from vsb.tools.files import load, write_text

Spec = dict[str, Any]


def study_data(study: Study, paths: dict[str, Any]) -> StudyData:
    """Return everything the figures are drawn from."""
    bem = study.needs_bem
    response = load(paths["response"]) if bem else xr.Dataset()
    return StudyData(
        designs=tuple(study.designs),
        reference=study.reference_design,
        wave_frequencies=tuple(wave.omega for wave in study.waves if not isinstance(wave, StillWater)),
        periods={wave.label: _period(study, wave, response) for wave in study.waves},
        window=study.simulation.window,
        modes=load(paths["modes"]),
        database=database.load_database(paths["database"], Path(paths["database"]).stem) if bem else xr.Dataset(),
        radiation=load(paths["radiation"]) if bem else xr.Dataset(),
        response=response,
        runs=stored_runs(study, paths["trajectories"]),
    )


def _period(study: Study, wave: Wave, response: xr.Dataset) -> float:
    """Period of a sea, in still water of the slowest free motion [s]."""
    return 2 * np.pi / (_slowest(study, response) if isinstance(wave, StillWater) else wave.omega)


def _slowest(study: Study, response: xr.Dataset) -> float:
    """Lowest natural frequency [rad/s]; without BEM that of heave, sqrt(rho g pi r_w^2/m)."""
    return float(response.wet_natural_frequency.min()) if study.needs_bem else study.heave_frequency


def figures(spec: Spec, paths: dict[str, Any]) -> None:
    """Draw and write all figures of a study as SVG."""
    study = parse(spec, source="spec")
    data = study_data(study, paths)
    for name in figure_names(study):
        text = io.StringIO()
        draw(name, data).savefig(text, format="svg", metadata={"Date": None})
        write_text(Path(paths["out"]) / f"{name}.svg", text.getvalue())


def report(spec: Spec, paths: dict[str, Any]) -> None:
    """Write the report of a study."""
    study = parse(spec, source="spec")
    names = figure_names(study)
    page = Report(
        study=study.model_dump(),
        seas=_seas(study),
        rows=_rows(paths["table"]),
        irregular=[wave.label for waves in families(study).values() for wave in waves],
        statistics=_rows(paths["statistics"]),
        checks=json.loads(Path(paths["validity"]).read_text(encoding="utf-8"))["checks"],
        response=load(paths["response"]) if study.needs_bem else None,
        reference=study.reference_design,
        figures={name: (Path(paths["figures"]) / f"{name}.svg").read_text(encoding="utf-8") for name in names},
        facts=_facts(study, paths, list(stored_runs(study, paths["trajectories"]).values())),
    )
    write_text(paths["out"], render(page))


def _rows(path: str) -> list[dict[str, str]]:
    """The rows of a table."""
    with Path(path).open(encoding="utf-8", newline="") as handle:
        return list(csv.DictReader(handle))


def _seas(study: Study) -> dict[str, str]:
    """Every sea in words; an assumed pressure is no sea."""
    if study.needs_bem:
        names = {name: waves[0].description for name, waves in families(study).items()}
        return {wave.label: wave.description for wave in study.waves} | names
    words = f"an assumed uniform pressure of {study.hydro.pressure:g} Pa and {{:g}} s period"
    return {
        w.label: w.description if isinstance(w, StillWater) else words.format(2 * np.pi / w.omega) for w in study.waves
    }


def _facts(study: Study, paths: dict[str, Any], runs: Sequence[xr.Dataset]) -> dict[str, str]:
    """How the results were made, in words."""
    return {
        "Program": f"vsb {__version__}, {clock.strftime('%Y-%m-%d')}",
        **(_bem_facts(paths) if study.needs_bem else {"Hydrodynamics": ASSUMED.format(study.hydro.pressure)}),
        "Time domain": f"{runs[0].attrs['method']}, {study.simulation.duration:g} s of motion in "
        f"{max(run.attrs['seconds'] for run in runs):.3f} s or less per design and sea",
        "Largest energy residual": f"{max(run.attrs['energy_residual'] for run in runs):.1e}",
        "Study": json.dumps(study.model_dump(mode="json"), default=str),
    }


ASSUMED = "hydrostatic and assumed uniform pressure of {:g} Pa on the instantaneous wet shell; no radiation"


def _bem_facts(paths: dict[str, Any]) -> dict[str, str]:
    """Where the hydrodynamic coefficients come from."""
    ds = database.load_database(paths["database"], Path(paths["database"]).stem)
    radiation = load(paths["radiation"]).attrs
    return {
        "BEM": "spectral integral equation" if ds.attrs["solver"] == "spectral" else ds.attrs["solver"],
        "Hydro database": f"{Path(paths['database']).name}: {ds.sizes['omega']} frequencies up to "
        f"{float(ds.omega[-1]):g} rad/s, {ds.sizes['influenced_dof']} degrees of freedom",
        "Seconds of BEM": f"{ds.attrs['bem_seconds']:.1f} on one core",
        "Radiation model": f"{radiation['order']} states, rms error {radiation['fit_error']:.1e}, "
        f"fitted in {radiation['seconds']:.1f} s",
    }
