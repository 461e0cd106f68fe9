"""Rule radiation: the passive radiation model."""

import time as clock

import numpy as np
import xarray as xr

from vsb.hydro.database import load_database
from vsb.hydro.kernel import DampingSpectrum
from vsb.hydro.statespace import fit_radiation
from vsb.stages.stage import stamp
from vsb.study.specs import RadiationSpec
from vsb.tools.files import save


def run(spec: RadiationSpec, database: str, out: str) -> None:
    """Fit and store the passive state-space radiation model, with the kernels to compare."""
    ds = load_database(database, spec.database)
    spectrum = DampingSpectrum(ds.omega.values, ds.radiation_damping.values)
    begun = clock.perf_counter()
    model, error = fit_radiation(spectrum, spec.tolerance)
    time = np.linspace(0.0, 40 / np.sqrt(float(ds.attrs["gravity"]) / float(ds.attrs["radius"])), 401)
    pair = ("influenced_dof", "radiating_dof")
    labels = ds.influenced_dof.values
    damping = model.damping(ds.omega.values)
    scale = np.sqrt(np.einsum("wii->wi", ds.radiation_damping.values).max(axis=0))
    margin = float(np.linalg.eigvalsh(damping / np.outer(scale, scale)).min())
    save(
        xr.Dataset(
            {
                "state_matrix": (("state", "state_in"), model.state_matrix),
                "input_matrix": (("state", "radiating_dof"), model.input_matrix),
                "channel": ("state", model.channel),
                "kernel": (("time", *pair), spectrum.kernel(time)),
                "kernel_state_space": (("time", *pair), model.kernel(time)),
                "damping_state_space": (("omega", *pair), damping),
            },
            coords={"time": time, "omega": ds.omega.values, "influenced_dof": labels, "radiating_dof": labels},
            attrs={
                **stamp(spec),
                "order": model.order,
                "fit_error": error,
                "passivity_margin": margin,
                "seconds": clock.perf_counter() - begun,
            },
        ),
        out,
    )
