"""All members of a campaign together: one dimension for each varied key, and the same as a tidy table."""

import itertools
from collections.abc import Iterable, Sequence

import numpy as np
import xarray as xr

from vsb.engine.motion.damper_matrix import matrix_text
from vsb.engine.motion.take_off import port_kind
from vsb.pipeline.plans import VARIABLES
from vsb.results.member import SAME_FOR_ALL
from vsb.results.year import POWER_ENDS
from vsb.study.body import BodyDesign
from vsb.study.campaign import AT_FORCE, CONSTRAINED, GAIN_IN_TIME, IN_TIME, POWER_IN_TIME, leading_tuning
from vsb.study.specs import CampaignSpec
from vsb.study.study import first_rigid
from vsb.study.vary import MEMBER, PORT, unit
from vsb.tools.arrays import AnyArray, FloatArray
from vsb.tools.variables import PortKind
from vsb.tools.words import csv_text

BY = ("design", "tuning")
TABLE = (
    "viable", "margin", "annual_mean_power", "annual_energy", "capture_width", "gain_percent", "gain_low", "gain_high",
    "force_rms", "practice_power", "quadrature_error", "energy_beyond_validity",
)  # fmt: skip
"""Variables of a table with a row for each point, design and tuning; dampers and reasons stand beside them."""
EFFICIENCY = "pto.efficiency"
OF_OPTIMA = ("power_bound", "impossible_share")
"""Variables only the tuning `constrained` has."""
POWER, GAIN = (tuple(f"corrected_{name}" for name in names) for names in (POWER_IN_TIME, GAIN_IN_TIME))
"""Powers and gains of a year corrected by runs in time (`vsb.results.verification`)."""


def stacked(members: Sequence[xr.Dataset], ids: Sequence[str]) -> xr.Dataset:
    """Return members along a dimension of their ids; how often seas of a bin occur is the same for all."""
    first = members[0]
    names = [name for name in first.data_vars if name not in SAME_FOR_ALL]
    values = {
        name: ((MEMBER, *first.variables[name].dims), np.stack([one.variables[name].values for one in members]))
        for name in names
    }
    same = {name: first[name] for name in SAME_FOR_ALL if name in first}
    return xr.Dataset({**values, **same}, coords={**first.coords, MEMBER: list(ids)})


def gathered(spec: CampaignSpec, batches: Iterable[xr.Dataset]) -> xr.Dataset:
    """Return the results of all members over the dimensions of what is varied.

    Parameters
    ----------
    batches : iterable of Dataset
        Each with the dimension `member`, whose coordinate holds ids; one after the other, for all are gigabytes.
    """
    names, kind = spec.vary.dimensions(VARIABLES), _port_kind(spec)
    coordinates = {
        name: (MEMBER if spec.vary.together else name, _values(values), {"units": unit(key, kind), "long_name": key})
        for (key, name), values in zip(names.items(), spec.vary.lists, strict=True)
    }
    attrs = {"varied": " ".join(names.values()), **_attrs(spec)}
    place, found = {one: i for i, one in enumerate(spec.members)}, dict[str, tuple[tuple[str, ...], AnyArray]]()
    for batch in batches:
        at, same = [place[str(one)] for one in batch[MEMBER].values], batch.drop_dims(MEMBER)
        for name, variable in batch.drop_vars(MEMBER).data_vars.items():
            if MEMBER not in variable.dims:
                continue
            dims, values = tuple(map(str, variable.dims[1:])), variable.values
            if name not in found:
                found[str(name)] = (dims, np.empty((len(place), *values.shape[1:]), values.dtype))
            found[str(name)][1][at] = values
    over, shape = ((MEMBER,), (len(place),)) if spec.vary.together and names else ((*names.values(),), spec.vary.shape)
    unfolded = {name: ((*over, *dims), one.reshape((*shape, *one.shape[1:]))) for name, (dims, one) in found.items()}
    return same.assign(unfolded).assign_coords(coordinates).assign_attrs(attrs)


def _attrs(spec: CampaignSpec) -> dict[str, str]:
    """Attributes of the file: names, reference design, conventions."""
    designs = spec.base["designs"]
    if "body" in spec.base:
        reference = first_rigid({name: BodyDesign(**design) for name, design in designs.items()})
    else:
        reference = next((name for name, design in designs.items() if not design["flexible"]), None)
    names = {"campaign": spec.campaign, "study": spec.study, "climate": spec.climate_name}
    efficiency = spec.base["pto"].get("efficiency", 1.0)
    words = "as varied" if EFFICIENCY in spec.vary.keys else f"of {efficiency:g}" if efficiency < 1 else ""
    after = {"efficiency": words} if words else {}
    kind = _port_kind(spec).load
    return {**names, "reference": reference or "", "Conventions": "CF-1.8", "port_kind": kind, **after}


def _port_kind(spec: CampaignSpec) -> PortKind:
    """What the take-off acts with, the same at every point (`vsb.study.campaign`)."""
    return port_kind(spec.vary.values.get(PORT, (spec.base["pto"].get("port"),))[0])


def _values(values: Sequence[float | str]) -> AnyArray:
    """Values of a key as a coordinate."""
    return np.array(values, dtype=object if isinstance(values[0], str) else float)


def with_verification(spec: CampaignSpec, ds: xr.Dataset, runs: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return the results of a campaign with those of runs in time, named by their model (`IN_TIME`).

    The statistical intervals of their powers and gains are wider by the errors of linear theory, whose ratio to runs
    they correct: coefficients, quadrature and shell modes left out are the same in both.

    Parameters
    ----------
    ds : Dataset
        See `gathered`.
    runs : sequence of Dataset
        See `vsb.results.verification`, in the order of the members; none of a campaign that verifies nothing. Where
        all failed, linear theory stands alone.
    """
    failures = sorted({one.attrs.get("failure", "") for one in runs} - {""})
    ds = ds.assign_attrs(failed_runs="\n".join(failures)) if failures else ds
    if all(one.attrs.get("failure") for one in runs):
        return ds
    model, tuning = runs[0].attrs["model"], leading_tuning(spec.tuning)
    names = {name: in_time(model, name) for name in (*POWER, *GAIN) if name in runs[0]}
    found = ds.assign({new: _of_members(ds, [one[name] for one in runs]) for name, new in names.items()})
    for end, own in zip(GAIN[1:], GAIN_IN_TIME[1:], strict=True):
        if end in names and own in ds:
            beyond = (ds[own] - ds.gain_percent).sel(tuning=tuning, drop=True)
            found[names[end]] = (found[names[end]] + beyond).transpose(*found[names[end]].dims)
    for end, own in zip(POWER[1:], POWER_ENDS, strict=True):
        if own not in ds:
            continue
        beyond = (ds[own] - ds.annual_mean_power).sel(tuning=tuning, drop=True)
        found[names[end]] = (found[names[end]] + beyond).transpose(*found[names[end]].dims)
    return found.assign_attrs(
        {
            **ds.attrs,
            "verification": f"tuning {tuning}: {runs[0].attrs['runs']}",
            "verified_tuning": tuning,
            "verified_model": model,
        }
    )


def in_time(model: str, name: str) -> str:
    """Return the name in a campaign of a result of runs in time, one of `POWER` and `GAIN`, by their model."""
    return name.replace("corrected", IN_TIME[model])


def _of_members(ds: xr.Dataset, values: Sequence[xr.DataArray]) -> tuple[tuple[str, ...], FloatArray]:
    """Values of members over the dimensions of what is varied."""
    stacked = np.stack([one.values for one in values])
    dims = (*map(str, ds.margin.dims), *map(str, values[0].dims))
    return dims, stacked.reshape((*ds.margin.shape, *stacked.shape[1:]))


def as_csv(spec: CampaignSpec, ds: xr.Dataset) -> str:
    """Return a row for each point, design and tuning; an empty cell is a result that does not exist (not viable)."""
    points = [str(dim) for dim in ds.margin.dims]
    verified = ds.tuning == ds.attrs.get("verified_tuning")
    damping = {"damper_matrix": _matrices(ds)} if "damper_matrix" in ds else {"damping": damper(ds)}
    columns = {name: ds[name] for name in TABLE if name in ds} | {**damping, "reason": ds.reason}
    if "verified_model" in ds.attrs:
        said = [in_time(ds.attrs["verified_model"], name) for name in (*POWER, *GAIN)]
        columns |= {name: ds[name].where(verified) for name in said if name in ds}
    columns |= {name: ds[name].where(ds.tuning == CONSTRAINED) for name in OF_OPTIMA if name in ds}
    columns |= {name: ds[name] for name in POWER_ENDS if name in ds}
    by = xr.zeros_like(ds.annual_mean_power, dtype=bool)
    cells = [each.broadcast_like(by).transpose(*points, *BY).values.ravel().tolist() for each in columns.values()]
    names = itertools.product(ds.design.values, ds.tuning.values)
    labels = ([*point.values(), *name] for point, name in itertools.product(spec.vary.points, list(names)))
    rows = zip(labels, zip(*cells, strict=True), strict=True)
    return csv_text([*spec.vary.values, *BY, *columns], (map(_cell, (*label, *row)) for label, row in rows))


def damper(ds: xr.Dataset) -> xr.DataArray:
    """Return the damper of every tuning that has one for all seas [N s/m]; NaN of the others."""
    occupied = ds["damping"].where((ds["count"] > 0) & ~ds.tuning.isin([*AT_FORCE, CONSTRAINED]))
    lowest, highest = occupied.min(("hs", "te")), occupied.max(("hs", "te"))
    return highest.where(highest - lowest <= 1e-9 * highest)


def _matrices(ds: xr.Dataset) -> xr.DataArray:
    """Damper matrices as text by point, design and tuning."""
    stacked = ds.damper_matrix.transpose(..., "port", "port_")
    flat = stacked.values.reshape(-1, *stacked.shape[-2:])
    texts = np.array([matrix_text(one, 12) for one in flat], dtype=object).reshape(stacked.shape[:-2])
    return xr.DataArray(texts, {name: ds[name] for name in BY}, stacked.dims[:-2])


def _cell(value: object) -> object:
    """A value as it stands in a table: whole digits, nothing for what is missing."""
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.12g}"
    return value
