"""A run as time series under WEC-Sim's names, for those who read its `output` structure; as CSV, too.

Forces act on the body: they add up to its mass and added mass at infinite frequency times its acceleration.
"""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from vsb.engine.hydro.variables import ROTATIONS, motion_of
from vsb.tools.variables import kind_of
from vsb.tools.words import csv_text

BODY_FORCES = {
    "forceExcitation": ("excitation", "froude_krylov", "diffraction"),
    "forceRadiationDamping": ("radiation",),
    "forceRestoring": ("hydrostatic", "weight"),
    "forceMorisonAndViscous": ("drag",),
    "forceLinearDamping": ("structural_damping", "viscous"),
    "forceMooring": ("mooring",),
    "forceElastic": ("elastic", "prestress", "preload", "gas"),
}
"""Force of a body under WEC-Sim's name -> the forces of a run it is the sum of; `forceElastic` is no name of WEC-Sim's.

`forceRadiationDamping` has the opposite sign of WEC-Sim's, which is subtracted there.
"""
TAKE_OFF, END_STOP = "pto", "end_stop"
WORDS = {
    "wave_elevation": "undisturbed wave elevation at the buoy's axis",
    "bodies_position": "displacements and modal amplitudes",
    "bodies_velocity": "their rates",
    "bodies_forceTotal": "all forces on the body but the take-off's",
    "ptos_position": "displacement of the take-off's port",
    "ptos_velocity": "velocity of the take-off's port",
    "ptos_forceTotal": "force of take-off and end stop at the port",
    "ptos_forceInternalMechanics": "force of the take-off at the port",
    "ptos_powerInternalMechanics": "that force times the velocity of the port, a spring's share included",
    "power_absorbed": "power absorbed by the take-off, without what its spring gives back",
}
"""Variable -> its meaning; what stands before the first _ is a field of WEC-Sim's `output`, what follows one of it."""


def time_series(run: xr.Dataset, port: xr.DataArray) -> xr.Dataset:
    """Return the time series of a run under WEC-Sim's names.

    Parameters
    ----------
    run : Dataset
        See `vsb.engine.integrators.simulate.recorded`.
    port : DataArray, dims (dof,)
        b of the take-off, which moves with b.q.

    Returns
    -------
    Dataset
        Dims (time,) and (time, dof), each variable with `units` and `long_name`. Of degrees of freedom that are
        rotations units are rad and N m in place of m and N. The attribute `left_out` names the variables of the run
        that have no name of WEC-Sim's.
    """
    kind, moving = kind_of(run), port.reindex(dof=run.dof, fill_value=0.0)
    forces = [str(name) for name, v in run.data_vars.items() if v.dims == ("time", "dof")]
    forces = [name for name in forces if name not in ("position", "velocity")]
    own = [name for name in forces if name not in (TAKE_OFF, END_STOP)]
    listed = {name for names in BODY_FORCES.values() for name in names}
    named = {**BODY_FORCES, **{f"force{name.title().replace('_', '')}": (name,) for name in own if name not in listed}}
    none = xr.zeros_like(run.velocity)

    def total(names: list[str]) -> xr.DataArray:
        return sum((run[name] for name in names), none)

    found = {"wave_elevation": run["elevation"]} if "elevation" in run else {}
    found |= {"bodies_position": run.position, "bodies_velocity": run.velocity}
    present = {name: [part for part in parts if part in own] for name, parts in named.items()}
    found |= {f"bodies_{name}": total(parts) for name, parts in present.items() if parts}
    found["bodies_forceTotal"] = total(own)
    along = moving / float(moving @ moving) if float(moving @ moving) else moving
    force, velocity = total([n for n in forces if n == TAKE_OFF]), run.velocity @ moving
    found |= {"ptos_position": run.position @ moving, "ptos_velocity": velocity}
    found["ptos_forceTotal"] = total([name for name in forces if name not in own]) @ along
    found["ptos_forceInternalMechanics"] = force @ along
    found |= {"ptos_powerInternalMechanics": (force * run.velocity).sum("dof"), "power_absorbed": run.power_absorbed}
    units = {"ptos_position": kind.motion_unit, "ptos_velocity": kind.rate_unit, "wave_elevation": "m"}
    units |= {"ptos_powerInternalMechanics": "W", "power_absorbed": "W"}
    units |= {"bodies_position": "m", "bodies_velocity": "m/s"}
    out = xr.Dataset()
    for name, values in found.items():
        unit = units.get(name, kind.load_unit if name.startswith("ptos") else "N")
        words = WORDS.get(name) or f"sum of {', '.join(present[name.removeprefix('bodies_')])}"
        out[name] = values.drop_attrs().assign_attrs(units=unit, long_name=words)
    kept = ("design", "wave", "method", "model", "energy_residual", "spec_id")
    attrs = {name: run.attrs[name] for name in kept if name in run.attrs}
    unnamed = {*map(str, run.data_vars)} - {"position", "velocity", "elevation", "power_absorbed", *forces}
    out = out.assign_attrs(left_out=", ".join(sorted(unnamed)))
    return out.assign_coords(time=run.time.assign_attrs(units="s", long_name="time")).assign_attrs(attrs)


def as_csv(series: xr.Dataset) -> str:
    """Return time series as CSV: a column of each variable, or of each of its degrees of freedom, with its unit."""
    columns = [("time [s]", series.time.values), *_columns(series)]
    return csv_text([name for name, _ in columns], zip(*(values.tolist() for _, values in columns), strict=True))


def _columns(series: xr.Dataset) -> Iterator[tuple[str, np.ndarray]]:
    """Heads and values of the columns but time."""
    for name, values in series.data_vars.items():
        unit = str(values.attrs["units"])
        if "dof" not in values.dims:
            yield f"{name} [{unit}]", values.values
            continue
        for dof in map(str, values.dof.values):
            turned = motion_of(dof) in ROTATIONS
            its = {"m": "rad", "m/s": "rad/s", "N": "N m"}[unit] if turned else unit
            yield f"{name}_{dof} [{its}]", values.sel(dof=dof).values
