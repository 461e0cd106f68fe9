"""Labelled time series of a run: motion, forces by name, energies."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.integrators.audit import Balance, terms
from vsb.motion.motion import Motion
from vsb.motion.system import System
from vsb.tools.arrays import BoolArray, FloatArray, IntArray
from vsb.waves.seas import Sea


class Leg(NamedTuple):
    """A part of a run: what needs memory at one time."""

    motion: Motion
    energy: Mapping[str, FloatArray]  # since the start of the run, each (time,) [J]; see `energies`
    balance: Balance  # at its end
    stride: int  # every how many instants make a readable record
    thinning: int  # every how many of those a long run records
    method: str
    steps: int  # the method took, if it takes steps

    @property
    def end(self) -> tuple[FloatArray, ...]:
        """Position, velocity and memory at the last instant, where the next leg starts."""
        return self.motion.position[-1], self.motion.velocity[-1], self.motion.memory[-1]


def recorded(system: System, leg: Leg, sea: Sea | None, window: tuple[float, float]) -> xr.Dataset:
    """Return the record of a leg: motion, forces by name, energies, elevation.

    Every readable instant of a short run. Of a long one a part of them, and those in the window [s] where a coordinate,
    a velocity or the power taken off is extreme: figures of merit are those of all instants.
    A rigid design carries its motions, a flexible one heave and all shell modes; an assumed pressure has no elevation.
    """
    motion, scene = leg.motion, system.scene
    carried = [i for i, row in enumerate(scene.motions) if scene.flexible or row.any()]
    labels, motions = [scene.labels[i] for i in carried], scene.motions[carried]
    named = {name: force[:, carried] for name, force in system.forces(motion).items()}
    series = {"position": motion.position @ motions.T, "velocity": motion.velocity @ motions.T} | named
    kept = np.append(np.arange(0, len(motion.time) - 1, leg.stride * leg.thinning), len(motion.time) - 1)
    if leg.thinning > 1:
        power = np.sum(named.get(scene.take_off, 0.0 * series["velocity"]) * series["velocity"], axis=1, keepdims=True)
        watched = np.hstack([series["position"], series["velocity"], power])
        kept = np.union1d(kept, _extremes(watched, (motion.time > window[0] - 1e-9) & (motion.time < window[1] + 1e-9)))
    balance = terms(leg.energy)
    run = xr.Dataset(
        {
            **{name: (("time", "dof"), values[kept]) for name, values in series.items()},
            "energy": (("time", "term"), np.stack([leg.energy[term][kept] for term in balance], axis=1)),
        },
        coords={"time": motion.time[kept], "dof": labels, "term": list(balance)},
    )
    return run.assign(elevation=("time", sea.elevation(motion.time)[kept])) if sea else run


def _extremes(series: FloatArray, inside: BoolArray) -> IntArray:
    """Rows, among those inside, in which a column of a series has its least or its largest value."""
    (rows,) = np.nonzero(inside)
    extremes = [series[rows].argmin(axis=0), series[rows].argmax(axis=0)] if rows.size else []
    return np.asarray(rows[np.ravel(extremes).astype(int)])
