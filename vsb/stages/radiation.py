"""Rule radiation: the passive radiation model."""

import time as clock
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vsb.hydro.database import load_database
from vsb.hydro.orders import order_groups
from vsb.hydro.retardation import DampingSpectrum
from vsb.hydro.statespace import RadiationModel, fit_radiation, joined
from vsb.hydro.variables import PAIR
from vsb.scenes.floating_system import stored_body
from vsb.stages.stage import stamp
from vsb.study.specs import BodyRadiationSpec, RadiationSpec
from vsb.tools.files import save

LONGEST = 60.0
"""Time the kernels of a body are shown for, times the end of its band [rad]."""


def run(spec: RadiationSpec | BodyRadiationSpec, database: str, out: str) -> None:
    """Fit and store the passive state-space radiation model, with the kernels to compare."""
    ds = load_database(database, spec.database)
    spectrum = DampingSpectrum(ds.omega.values, ds.radiation_damping.values)
    begun = clock.perf_counter()
    own: dict[str, Any] = {}
    repaired: dict[str, Any] = {}
    if isinstance(spec, BodyRadiationSpec):
        fit = stored_body(database).memory(spec.tolerance, limit=spec.added_mass_inf)
        memory = Memory(fit.model, fit.error)
        own, repaired = {"added_mass_inf": (PAIR, fit.added_mass_inf)}, {"history": fit.history}
        repaired |= {"up_to": fit.up_to} if fit.up_to < np.inf else {}
        longest = LONGEST / float(ds.omega[-1])
    else:
        memory = fit_orders(ds, spec.tolerance)
        longest = 40 / float(np.sqrt(float(ds.attrs["gravity"]) / float(ds.attrs["radius"])))
    model = memory.model
    time = np.linspace(0.0, longest, 401)
    labels = ds.influenced_dof.values
    damping = model.damping(ds.omega.values)
    channels = ("state",) if model.channel.ndim == 1 else ("state", "channel_of_order")
    save(
        xr.Dataset(
            {
                "state_matrix": (("state", "state_in"), model.state_matrix),
                "input_matrix": (("state", "radiating_dof"), model.input_matrix),
                "channel": (channels, model.channel),
                "kernel": (("time", *PAIR), spectrum.kernel(time)),
                "kernel_state_space": (("time", *PAIR), model.kernel(time)),
                "damping_state_space": (("omega", *PAIR), damping),
                **own,
            },
            coords={"time": time, "omega": ds.omega.values, "influenced_dof": labels, "radiating_dof": labels},
            attrs={
                **stamp(spec),
                "order": model.order,
                "fit_error": memory.error,
                "passivity_margin": least_damping(spectrum, damping),
                "seconds": clock.perf_counter() - begun,
                **repaired,
            },
        ),
        out,
    )


class Memory(NamedTuple):
    """The radiation memory of all azimuthal orders."""

    model: RadiationModel
    error: float  # the largest of their fits [-]


def fit_orders(ds: xr.Dataset, tolerance: float) -> Memory:
    """Return the passive memory of a database, of each azimuthal order one of a single channel; see `fit_radiation`.

    Motions that move no water, as pitch about a sphere's centre, are none of it.
    """
    omega, damping = ds.omega.values, ds.radiation_damping.values
    models, errors, fits = [], [], {}
    for order, group in order_groups(ds).items():
        wet = group[np.einsum("wii->wi", damping[:, group[:, None], group]).any(axis=0)]
        if order >= 0:
            fits[order] = fit_radiation(DampingSpectrum(omega, damping[:, wet[:, None], wet]), tolerance)
        model, error = fits[abs(order)]  # a sine's is that of its cosine
        inputs = np.zeros((model.order, damping.shape[1]))
        inputs[:, wet] = model.input_matrix
        models.append(RadiationModel(model.state_matrix, inputs, model.channel))
        errors.append(error)
    return Memory(joined(models), max(errors))


def least_damping(spectrum: DampingSpectrum, damping: np.ndarray) -> float:
    """Return the least eigenvalue of a model's damping, (omega, dof, dof), each motion in terms of its largest [-]."""
    scale = np.sqrt(np.einsum("wii->wi", spectrum.damping).max(axis=0))
    scale = np.where(scale > 0, scale, 1.0)  # of what moves no water
    return float(np.linalg.eigvalsh(damping / np.outer(scale, scale)).min())
