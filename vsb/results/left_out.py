"""What the shell modes that a study leaves out would change: of mean powers and of gains, in every sea."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from vsb.hydro.orders import of_order
from vsb.motion.frequency import LinearBuoy, with_open_chamber
from vsb.motion.port import port_direction
from vsb.motion.pto import LinearPto
from vsb.motion.tuning import best_dampers
from vsb.scenes.afloat import Afloat, met
from vsb.scenes.rest import design_motions, reference_shell, study_basis
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis, mode_basis
from vsb.study.specs import LadderSpec
from vsb.study.study import Study, Wave
from vsb.study.take_off import ShellPort
from vsb.tools.units import PAIR, FloatArray
from vsb.waves.seas import Sea

ENDS = ("low", "high")
"""Of a range, about zero: where the value of all modes lies from the one computed."""


def modes_left_out(study: LadderSpec, database: xr.Dataset, seas: Sequence[tuple[Wave, Sea]]) -> xr.Dataset:
    """Return how far powers and gains may lie from those of a shell with all its modes.

    Parameters
    ----------
    study : LadderSpec
    database : xarray.Dataset
        Its hydro database.
    seas : sequence of (Wave, Sea)
        Without still water.

    Returns
    -------
    xarray.Dataset
        `power(design, wave, end)`, of the mean power [-], and `gain(design, wave, end)`, of the gain over the reference
        design [percentage points], `end` as `ENDS`; nothing of what cannot be estimated.

    Notes
    -----
    Estimated is what a shell with bending modes of the same degrees changes, each design at its own optimal damper:
    the truth is taken to lie between none and all of that change. About an equilibrium bending modes move other water
    than the basis, and beside other ports than heave, volume and points of the shell no estimate is known.
    """
    known = study.motion == "heave" or study.pto.port in ("heave", "volume") or isinstance(study.pto.port, ShellPort)
    deformed = bool(np.any(database.reference_amplitude.values)) if "reference_amplitude" in database else False
    if not study.flexible or study.modes.basis == "full" or study.modes.degree < 2 or deformed or not known:
        return xr.Dataset()
    axisymmetric = list(study_basis(study).labels)  # orders do not mix; yaw, of order 0 too, moves no water
    narrow = of_order(database, 0).sel(influenced_dof=axisymmetric, radiating_dof=axisymmetric)
    before = _powers(study, narrow, study_basis(study), seas)
    after = _powers(study, *with_full_basis(narrow, study), seas)
    reference = study.reference_design
    designs, labels = list(study.designs), [wave.label for wave, _ in seas]
    power, gain = (np.zeros((len(designs), len(labels), 2)) for _ in range(2))
    for i, design in enumerate(designs):
        if not study.designs[design].flexible:
            continue
        there = before[design] > 0
        change = np.where(there, after[design] / np.where(there, before[design], 1.0) - 1, 0.0)
        power[i] = _range(change)
        if reference is not None:
            base = before[reference]
            moved = np.where(base > 0, 100 * (after[design] - before[design]) / np.where(base > 0, base, 1.0), 0.0)
            gain[i] = _range(moved)
    dims = ("design", "wave", "end")
    return xr.Dataset(
        {"power": (dims, power), "gain": (dims, gain)}, {"design": designs, "wave": labels, "end": list(ENDS)}
    )


def _range(change: FloatArray) -> FloatArray:
    """Between none and all of a change, shape (sea, end)."""
    return np.stack([np.minimum(change, 0.0), np.maximum(change, 0.0)], axis=-1)


def _powers(
    study: LadderSpec, database: xr.Dataset, basis: ModeBasis, seas: Sequence[tuple[Wave, Sea]]
) -> Mapping[str, FloatArray]:
    """Mean power of every design at its own optimal damper in every sea, each shape (sea,) [W]."""
    alone = study.model_copy(update={"motion": "heave"})
    port = port_direction(study.pto.port, DeformedShell(basis, study.centre_height))
    buoy = LinearBuoy(database, basis.damping, LinearPto(0.0))
    buoy = with_open_chamber(buoy, port) if study.opens_chamber else buoy
    motions = {design: design_motions(alone, basis, design) for design in study.designs}
    floating, found = Afloat(buoy, motions, port), {}
    for design in study.designs:
        seen, squares, _ = met(floating, design, seas)
        found[design] = best_dampers(seen, squares, study.pto.stiffness, study.pto.efficiency).power
    return found


def with_full_basis(database: xr.Dataset, study: LadderSpec | Study) -> tuple[xr.Dataset, ModeBasis]:
    """Return the database and basis with both branches of the shell, from one that has a mode of every degree.

    Possible without BEM: on the undeformed sphere a mode acts on the water by its radial part alone.
    """
    full = mode_basis(study.device, "full", study.modes.degree)
    old = study_basis(study)
    pick = [0, *(old.degrees.index(n, 1) for n in full.degrees[1:])]
    ratio = full.pole_radial_displacement / old.pole_radial_displacement[pick]
    out = {}
    for name, data in database.data_vars.items():
        indexers = {dim: pick for dim in PAIR if dim in data.dims}
        scaled = data.isel(indexers)
        for dim in indexers:
            scaled = scaled.assign_coords({dim: list(full.labels)}) * xr.DataArray(
                ratio, coords={dim: list(full.labels)}
            )
        out[name] = scaled.transpose(*data.dims)
    out["inertia_matrix"] = xr.DataArray(full.inertia, dims=PAIR)
    for name, stiffness in reference_shell(study, full).stiffness.items():
        out[f"{name}_stiffness"] = xr.DataArray(stiffness, dims=PAIR)
    return xr.Dataset(out, attrs=database.attrs), full
