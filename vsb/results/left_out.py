"""Errors by shell modes that a study leaves out: of mean powers and of gains, in every sea and over a year."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.motion.damper_matrix import Ports
from vsb.motion.port import Port
from vsb.results.year import band_weights
from vsb.scenes.floating_system import AnyBody, Floating, InWaves, SeveralInWaves
from vsb.scenes.mode_convergence import (
    JUDGED,
    SAMPLED,
    ModeConvergence,
    beyond,
    directed,
    mean_sea,
    motion_of_port,
    powers_of_ports,
    take_offs,
)
from vsb.scenes.ports import BuoyOfShape, buoy_at
from vsb.scenes.ring_loads import has_attachment_modes
from vsb.study.sections import DEGREES, Modes
from vsb.study.specs import AnyBuoy, BuoySystem
from vsb.study.study import Study
from vsb.study.waves import Wave
from vsb.tools.arrays import FloatArray
from vsb.waves.climate import Climate
from vsb.waves.seas import Sea

LEAST_RATIO = 1.4
"""Of degrees that are compared: the estimate of further degrees assumes steps as large as those of the list."""
ENDS = ("low", "high")
"""Of a range about zero: the value with all modes less the one computed."""


def modes_left_out(
    study: BuoySystem,
    seas: Sequence[tuple[Wave, Sea]],
    families: Sequence[int] | None = None,
    powers: Mapping[int, FloatArray] | None = None,
) -> xr.Dataset:
    """Return how far powers and gains may lie from those of a shell with all its modes.

    Parameters
    ----------
    seas : sequence of (Wave, Sea)
        Without still water.
    families : sequence of int, optional
        One sea of each, by index, that the damper for all seas is tuned to; by default all.
    powers : mapping, optional
        By degree, of the same seas and families, where `ModeConvergence.powers_by_degree` is known.

    Returns
    -------
    xarray.Dataset
        `power(design, wave, take_off, end)`, of the mean power [-], and `gain(design, wave, take_off, end)`, of the
        gain over the reference design [percentage points], `end` as `ENDS`, `take_off` as of
        `vsb.scenes.mode_convergence.take_offs`; empty of a rigid buoy, or without seas.

    Notes
    -----
    The change from the basis of the study to the full basis of the highest degree tried, completed by what all further
    degrees do at loaded rings, and what further degrees may change (`vsb.scenes.mode_convergence`).
    """
    if not study.flexible or not seas:
        return xr.Dataset()
    convergence = ModeConvergence(study, tuple(directed(wave, sea) for wave, sea in seas), families)
    powers, modes = powers or convergence.powers_by_degree, study.modes
    known = modes.basis == "full" and modes.max_degree in powers
    before = powers[modes.max_degree] if known else convergence.powers(modes)
    complete = convergence.completes
    power = _relative(_bounds(study, before, powers, complete=complete), before)
    gain = np.zeros((*before.shape, len(ENDS)))
    if (reference := study.reference_design) is not None:
        at = list(study.designs).index(reference)
        gains = {n: _gains(one, at) for n, one in powers.items()}
        gain = _bounds(study, _gains(before, at), gains, complete=complete)
    if not study.at_equilibrium:  # else the shape at rest depends on the modes, too
        power[[i for i, design in enumerate(study.designs.values()) if not design.flexible]] = 0.0
    dims = ("design", "wave", "take_off", "end")
    coords = {
        "design": list(study.designs),
        "wave": [wave.label for wave, _ in seas],
        "take_off": list(take_offs(study.pto)),
        "end": list(ENDS),
    }
    return xr.Dataset({"power": (dims, power), "gain": (dims, gain)}, coords)


class YearLeftOut(NamedTuple):
    """Errors of a year's mean power and of its gain by shell modes left out, `end` as `ENDS`."""

    power: FloatArray  # relative (design, end) [-]
    gain: FloatArray  # over the reference, 0 without one (design, end) [percentage points]


def left_out_of_year(
    study: Study | AnyBody,
    floating: Floating,
    climate: Climate,
    waves: Mapping[str, InWaves] | Mapping[str, SeveralInWaves],
) -> YearLeftOut:
    """Return how far a year's mean power and its gain may lie from those of a shell with all its modes.

    Parameters
    ----------
    study : Study or BodyStudy
        Of viable designs.
    floating : Floating
        What floats in it; a body has the modes of its files, and leaves out no others that are known.
    waves : mapping design -> InWaves or SeveralInWaves
        Of all its modes, at frequencies of the climate.

    Returns
    -------
    YearLeftOut
        The wider of the damper given and the optimal one; 0 of what has no shell modes of this project.

    Notes
    -----
    With the full basis lower degrees of it are compared, in the water given; see `beyond`. About an equilibrium each
    degree has its own shape at rest and water, since the rigid design depends on them, too. With another basis, or too
    few modes for that, powers of ascending degrees of the full basis are computed as in `modes_left_out`.
    """
    designs, rigid = list(study.designs), study.reference_design
    if not isinstance(floating, BuoyOfShape) or not floating.study.flexible:
        return YearLeftOut(*np.zeros((2, len(designs), len(ENDS))))
    buoy = floating.study
    heaving, complete = buoy.model_copy(update={"motion": "heave"}), False
    lower = [degree for degree in DEGREES if degree <= buoy.modes.max_degree / LEAST_RATIO][-2:]
    nested = buoy.modes.basis == "full" and lower
    degrees = [*lower, buoy.modes.max_degree]
    if nested and not buoy.at_equilibrium and motion_of_port(buoy) == "heave":
        omega = waves[designs[0]].port.omega
        squares, water = (climate.mean_density @ band_weights(omega, climate))[None], floating.swept.at(omega)
        seen: list[Mapping[str, Port | Ports]] = [{design: one.port for design, one in waves.items()}]
        complete = has_attachment_modes(heaving)
        for n in reversed(lower):
            at_degree = buoy_at(heaving, floating.reference, water, n)
            seen.insert(0, at_degree.several_ports() if study.pto.several else at_degree.ports())
        powers = [powers_of_ports(ports, study.pto, squares, judged=True) for ports in seen]
        tried, before = dict(zip(degrees, powers, strict=True)), powers[-1]
    else:
        convergence = ModeConvergence(buoy, [mean_sea(climate, buoy.hydro.omega_max)], judged=True)
        before = convergence.powers(buoy.modes)
        if nested:  # the shape at rest, and with it the rigid design, depends on the modes, too
            tried = {n: convergence.powers(Modes(basis="full", degree=n)) for n in lower}
            tried[degrees[-1]] = before
        else:
            tried, complete = dict(convergence.powers_by_degree), convergence.completes
    power, gain = _relative(_bounds(buoy, before, tried, complete=complete), before), np.zeros((*before.shape, 2))
    if not buoy.at_equilibrium:  # else the shape at rest depends on the modes, too
        power[[i for i, design in enumerate(buoy.designs.values()) if not design.flexible]] = 0.0
    if rigid is not None:
        at = designs.index(rigid)
        gain = _bounds(buoy, _gains(before, at), {n: _gains(one, at) for n, one in tried.items()}, complete=complete)
    return YearLeftOut(*(_widest(one[:, 0, :JUDGED]) for one in (power, gain)))


def _widest(bounds: FloatArray) -> FloatArray:
    """The widest range (design, end) of some take-offs, (design, take_off, end)."""
    return np.stack([bounds[..., 0].min(axis=1), bounds[..., 1].max(axis=1)], axis=-1)


def _bounds(study: AnyBuoy, before: FloatArray, tried: Mapping[int, FloatArray], *, complete: bool) -> FloatArray:
    """Range (..., end) about zero of what all modes change: to the highest of the degrees tried, and beyond it."""
    change = tried[max(tried)] - before
    missed = beyond(study, tried, complete=complete) + SAMPLED * np.abs(change)
    return np.stack([np.minimum(change, 0.0) - missed, np.maximum(change, 0.0) + missed], axis=-1)


def _gains(power: FloatArray, at: int) -> FloatArray:
    """Gains over one of the designs, of powers (design, sea, take-off) [percentage points]; 0 over no power."""
    base = np.broadcast_to(power[[at]], power.shape)
    return np.divide(100 * (power - base), base, out=np.zeros_like(power), where=base > 0)


def _relative(bounds: FloatArray, size: FloatArray) -> FloatArray:
    """Bounds (..., end) in terms of powers (...); 0 of no power."""
    there = np.broadcast_to((size > 0)[..., None], bounds.shape)
    return np.divide(bounds, size[..., None], out=np.zeros_like(bounds), where=there)
