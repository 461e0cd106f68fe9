"""Rule figures: all figures of a study."""

import matplotlib as mpl
import numpy as np
import xarray as xr

from vsb.report.canvas import StudyData
from vsb.report.figures import draw
from vsb.report.svg import drawn
from vsb.results.comparison import in_direction
from vsb.scenes.floating_system import AnyStudy
from vsb.stages.inputs import Inputs
from vsb.study.study import IrregularSea, StillWater, Study, Wave
from vsb.study.take_off import port_kind
from vsb.tools.stamps import record
from vsb.waves.seas import spectrum

FREQUENCIES = 2000
"""At which spectra are drawn."""


def run(study: AnyStudy, trajectories: str, out: str, manifest: str, **files: str) -> None:
    """Draw and write all figures of a study into a folder: SVG, PDF, and their data as CSV."""
    found = Inputs(study, trajectories, files)
    data = StudyData(
        designs=tuple(study.designs),
        reference=study.reference_design,
        wave_frequencies=tuple(wave.omega for wave in study.waves if not isinstance(wave, StillWater)),
        periods={wave.label: _period(study, wave, found.response) for wave in study.waves},
        window=study.simulation.window,
        modes=found.modes,
        database=found.database,
        radiation=found.radiation,
        response=in_direction(found.response, study.waves[0]),
        runs=found.runs,
        witness=found.witness,
        tuned=study.pto.damping is None,
        limit=f"limit {found.response.attrs.get('limit', 'λ/2π')}" if isinstance(study, Study) else "λ/2π",
        spectra=_spectra(study, found.plan.highest),
        port=port_kind(study.pto.port),
    )
    written: list[str] = []
    with mpl.rc_context():  # the caller's own figures keep their looks
        for name in found.plan.figures:
            written += drawn(draw(name, data), name).write(out, name)
    record(manifest, found.plan.study_id, written)


def _spectra(study: AnyStudy, highest: float) -> xr.DataArray:
    """Spectral density of each irregular sea, by its words, up to the highest frequency runs have components at."""
    waves = [wave for wave in study.drawn_waves if isinstance(wave, IrregularSea)]
    if not waves:
        return xr.DataArray()
    omega = np.geomspace(0.5 * min(wave.reach[0] for wave in waves), highest, FREQUENCIES)
    coords = {"sea": [wave.description for wave in waves], "omega": omega}
    return xr.DataArray([spectrum(wave, omega) for wave in waves], coords)


def _period(study: AnyStudy, wave: Wave, response: xr.Dataset) -> float:
    """Period of a sea, in still water of the slowest free motion [s]."""
    return 2 * np.pi / (_slowest(study, response) if isinstance(wave, StillWater) else wave.omega)


def _slowest(study: AnyStudy, response: xr.Dataset) -> float:
    """Lowest natural frequency [rad/s]; without BEM that of heave, sqrt(rho g pi r_w^2/m); 1 of what drifts alone."""
    if isinstance(study, Study) and not study.needs_bem:
        return study.heave_frequency
    return float(response.wet_natural_frequency.min()) if response.wet_natural_frequency.size else 1.0
