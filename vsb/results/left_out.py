"""What the shell modes that a study leaves out would change: of mean powers and of gains, in every sea."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from vsb.scenes.mode_convergence import TAKE_OFFS, ModeConvergence
from vsb.study.specs import LadderSpec
from vsb.study.study import Wave
from vsb.study.take_off import ShellPort
from vsb.tools.units import FloatArray
from vsb.waves.seas import Sea

ENDS = ("low", "high")
"""Of a range, about zero: where the value of all modes lies from the one computed."""


def modes_left_out(study: LadderSpec, seas: Sequence[tuple[Wave, Sea]]) -> xr.Dataset:
    """Return how far powers and gains may lie from those of a shell with all its modes.

    Parameters
    ----------
    study : LadderSpec
    seas : sequence of (Wave, Sea)
        Without still water.

    Returns
    -------
    xarray.Dataset
        `power(design, wave, take_off, end)`, of the mean power [-], and `gain(design, wave, take_off, end)`, of the
        gain over the reference design [percentage points], `end` as `ENDS`, `take_off` as of
        `vsb.scenes.mode_convergence.TAKE_OFFS`; nothing of what cannot be estimated.

    Notes
    -----
    The change from the basis of the study to the full basis of the highest degree tried, and what further degrees may
    change (`vsb.scenes.mode_convergence`). About the undeformed sphere and about its equilibrium; not known of other
    rest shapes, nor beside other ports than heave, volume and points of the shell where the buoy moves in more
    directions than heave.
    """
    known = study.motion == "heave" or study.pto.port in ("heave", "volume") or isinstance(study.pto.port, ShellPort)
    if not study.flexible or study.device.shape is not None or not known or not seas:
        return xr.Dataset()
    convergence = ModeConvergence(study, tuple(sea for _, sea in seas))
    before, further = convergence.powers(study.modes), convergence.further
    change = convergence.converged - before
    bounds = np.stack([np.minimum(change, 0.0) - further, np.maximum(change, 0.0) + further], axis=-1)
    designs, reference = list(study.designs), study.reference_design
    bounds[[i for i, name in enumerate(designs) if not study.designs[name].flexible]] = 0.0
    power, gain = _relative(bounds, before), np.zeros_like(bounds)
    if reference is not None:
        gain = 100 * _relative(bounds, before[[designs.index(reference)]])
    dims = ("design", "wave", "take_off", "end")
    coords = {"design": designs, "wave": [wave.label for wave, _ in seas], "take_off": list(TAKE_OFFS)}
    return xr.Dataset({"power": (dims, power), "gain": (dims, gain)}, {**coords, "end": list(ENDS)})


def _relative(bounds: FloatArray, size: FloatArray) -> FloatArray:
    """Bounds (..., end) in terms of powers (...); nothing of no power."""
    there = np.broadcast_to((size > 0)[..., None], bounds.shape)
    return np.divide(bounds, size[..., None], out=np.zeros_like(bounds), where=there)
