"""Rule report: the report of a study."""

import json
import time as clock
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from vsb import __version__
from vsb.report.page import Report, render
from vsb.report.sketch import sketches
from vsb.results.comparison import in_direction
from vsb.results.statistics import families
from vsb.scenes.floating_system import AnyStudy
from vsb.stages.animated import moving_study
from vsb.stages.inputs import Inputs
from vsb.stages.interactive import living_study
from vsb.study.blocks import no_witness
from vsb.study.body import BodyStudy
from vsb.study.plan import StudyPlan
from vsb.study.study import StillWater, Study
from vsb.tools.files import write_text
from vsb.tools.stamps import read_text, record

ASSUMED = "hydrostatic and assumed uniform pressure of {:g} Pa on the instantaneous wet shell; no radiation"


def run(study: AnyStudy, trajectories: str, out: str, manifest: str, **files: str) -> None:
    """Write the report of a study, from its checked results alone."""
    stored = Inputs(study, trajectories, files)
    study_id = stored.plan.study_id
    found = json.loads(read_text(files["tables"], manifest, study_id))
    if isinstance(study, BodyStudy):
        hydrodynamics = _body_facts(stored)
    elif study.needs_bem:
        hydrodynamics = _bem_facts(stored) | _witness_facts(stored, study)
    else:
        hydrodynamics = {"Hydrodynamics": ASSUMED.format(study.hydro.pressure)}
    page = Report(
        study=study.model_dump(),
        seas=_seas(study),
        rows=found["comparison"],
        irregular=[wave.label for waves in families(study).values() for wave in waves],
        statistics=found["statistics"],
        equal_tuning=found["equal_tuning"],
        within_limits=found["within_limits"],
        invalid=found["invalid"],
        checks=found["checks"],
        response=in_direction(stored.response, study.waves[0]) if study.needs_bem else None,
        reference=study.reference_design,
        sketches=sketches(study) if isinstance(study, Study) else (),
        thing="buoy" if isinstance(study, Study) else "body",
        flexible=study.flexible,
        buoys=_buoys(stored),
        living=living_study(study, stored.path("database"), stored.response, found["within_limits"]),
        figures={n: read_text(f"{files['figures']}/{n}.svg", manifest, study_id) for n in stored.plan.figures},
        facts=_facts(study, hydrodynamics, stored.runs.attributes()),
    )
    write_text(out, render(page))
    record(manifest, study_id, [out])


def _buoys(stored: Inputs) -> dict[str, Any] | None:
    """Moving buoys of a page; of a body nothing is known that could be drawn."""
    if not isinstance(stored.plan, StudyPlan):
        return None
    return moving_study(stored, stored.modes, _seas(stored.plan.study))


def _seas(study: AnyStudy) -> dict[str, str]:
    """Every sea in words; an assumed pressure is no sea."""
    if isinstance(study, BodyStudy) or study.needs_bem:
        names = {name: waves[0].description for name, waves in families(study).items()}
        return {wave.label: wave.description for wave in study.waves} | names
    words = f"an assumed uniform pressure of {study.hydro.pressure:g} Pa and {{:g}} s period"
    return {
        w.label: w.description if isinstance(w, StillWater) else words.format(2 * np.pi / w.omega) for w in study.waves
    }


def _facts(study: AnyStudy, hydrodynamics: dict[str, str], runs: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """How the results were made, in words; by what runs say of themselves."""
    return {
        "Program": f"vsb {__version__}, {clock.strftime('%Y-%m-%d')}",
        **hydrodynamics,
        "Time domain": f"{runs[0]['method']}, {study.simulation.duration:g} s of motion in "
        f"{max(run['seconds'] for run in runs):.3f} s or less per design and sea",
        "Largest energy residual": f"{max(run['energy_residual'] for run in runs):.1e}",
        "Study": yaml.safe_dump(
            study.model_dump(exclude_none=True), sort_keys=False, default_flow_style=None, width=100
        ),
    }


def _body_facts(stored: Inputs) -> dict[str, str]:
    """Where the hydrodynamic coefficients of a body come from."""
    ds, model = stored.database, stored.radiation.attrs
    told = "; ".join(text for text in (ds.attrs.get("history", ""), model.get("history", "")) if text)
    return {
        "Coefficients": str(ds.attrs["solver"]),
        "Hydro database": f"{Path(stored.path('database')).name}: {ds.sizes['omega']} frequencies from "
        f"{float(ds.omega[0]):g} to {float(ds.omega[-1]):g} rad/s, degrees of freedom "
        f"{', '.join(map(str, ds.influenced_dof.values))}",
        "Radiation memory": f"{model['order']} states, rms error {model['fit_error']:.1e}, "
        f"fitted in {model['seconds']:.1f} s",
        **({"History": told} if told else {}),
    }


def _bem_facts(stored: Inputs) -> dict[str, str]:
    """Where the hydrodynamic coefficients come from."""
    ds, model = stored.database, stored.radiation.attrs
    return {
        "BEM": "spectral integral equation" if ds.attrs["solver"] == "spectral" else ds.attrs["solver"],
        "Hydro database": f"{Path(stored.path('database')).name}: {ds.sizes['omega']} frequencies up to "
        f"{float(ds.omega[-1]):g} rad/s, {ds.sizes['influenced_dof']} degrees of freedom",
        "Seconds of BEM": f"{ds.attrs['bem_seconds']:.1f} on one core",
        "Radiation model": f"{model['order']} states, rms error {model['fit_error']:.1e}, "
        f"fitted in {model['seconds']:.1f} s",
    }


def _witness_facts(stored: Inputs, study: Study) -> dict[str, str]:
    """What the second solver was, and took."""
    if reason := no_witness(study):
        return {"Witness": f"none ({reason})"}
    ds, name = stored.witness, Path(stored.path("witness")).name
    panels, spectral = (float(ds.witness_seconds.sel(solver=solver).sum()) for solver in ("panels", "spectral"))
    return {
        "Witness": f"{name}: {ds.sizes['shape']} shapes at {ds.sizes['omega']} frequencies by "
        f"{ds.attrs['panels']} on {ds.attrs['rows']} rows ({panels:.1f} s) and the spectral solver ({spectral:.1f} s)"
    }
