"""Variables of netCDF files: their dimensions, units and meaning, which each room of the package registers itself."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vsb.errors import DatabaseError

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class PortKind:
    """A pair of load and rate whose product is power, and the units of what a take-off is described by."""

    load: str
    motion: str
    rate: str
    load_unit: str
    motion_unit: str
    rate_unit: str
    damping_unit: str  # load over rate
    stiffness_unit: str  # load over motion
    rate_per_amplitude: str  # rate over wave amplitude


FORCE = PortKind("force", "displacement", "velocity", "N", "m", "m/s", "N s/m", "N/m", "1/s")
MOMENT = PortKind("moment", "rotation", "angular velocity", "N m", "rad", "rad/s", "N m s", "N m", "rad/(m s)")
PRESSURE = PortKind("pressure", "volume", "volume flow", "Pa", "m^3", "m^3/s", "Pa s/m^3", "Pa/m^3", "m^2/s")
TENSION = PortKind(
    "surface tension", "change of area", "rate of area", "N/m", "m^2", "m^2/s", "N s/m^3", "N/m^3", "m/s"
)
WORK = PortKind("work per strain", "mean strain", "strain rate", "N m", "1", "1/s", "N m s", "N m", "1/(m s)")
_NORM = ("J^0.5", "J^0.5", "J^0.5/s", "s", "1", "J^0.5/(m s)")  # of elastic energy: L^T q, stiffness L L^T
MEMBRANE = PortKind("membrane stress", "membrane strain", "membrane strain rate", *_NORM)
KINDS = {kind.load: kind for kind in (FORCE, MOMENT, PRESSURE, TENSION, WORK, MEMBRANE)}


SEVERAL = PortKind("loads of several ports", "motions", "rates", *("SI",) * 6)
"""Stands for ports of several kinds, each in SI units of its own."""


def kind_of(ds: "xr.Dataset") -> PortKind:
    """Return the kind of the port of a file by its attribute `port_kind`; a file without it is of forces."""
    return {**KINDS, SEVERAL.load: SEVERAL}[ds.attrs.get("port_kind", FORCE.load)]


at_port: Callable[[str], Callable[[PortKind], str]] = attrgetter
"""Units of a variable that depend on the port: those of a field of `PortKind`."""


class Variable(NamedTuple):
    """Dimensions, units and meaning of one variable; "..." are any further dimensions."""

    dims: tuple[str, ...]
    units: str | Callable[[PortKind], str]
    long_name: str

    def units_at(self, kind: PortKind) -> str:
        """Return the units at a kind of port."""
        return self.units if isinstance(self.units, str) else self.units(kind)


Missing = Callable[["xr.Dataset", str], Any]
"""Dataset, variable -> where its values may be missing."""
VARIABLES: dict[str, Variable] = {
    "omega": Variable(("omega",), "rad/s", "angular frequency"),
    "time": Variable(("time",), "s", "time"),
}
"""Every variable a file of this project may hold, by name."""
_MISSING: list[Missing] = []


def register(variables: Mapping[str, Variable], missing: Missing | None = None) -> None:
    """Add variables to `VARIABLES`, and a rule of where values may be missing."""
    VARIABLES.update(variables)
    if missing is not None:
        _MISSING.append(missing)


def described(ds: "xr.Dataset") -> "xr.Dataset":
    """Return the dataset with dimensions in order and units on everything but labels.

    Coordinates listed in the attribute `varied`, keys of a study, keep their own units. The attribute `port_kind` says
    what the take-off acts with. Raises `DatabaseError` if a variable is not registered.
    """
    varied = set(str(ds.attrs.get("varied", "")).split())
    numbers = {name: variable for name, variable in ds.variables.items() if variable.dtype.kind not in "OSU"}
    if unknown := {str(name) for name in numbers} - set(VARIABLES) - varied:
        raise DatabaseError(f"variables {sorted(unknown)} are unknown; register them in variables.py of their room.")
    kind, out = kind_of(ds), ds.copy()
    for name in numbers:
        if (known := VARIABLES.get(str(name))) is None or name in varied:
            continue
        ordered = ds.variables[name].transpose(*(... if dim == "..." else dim for dim in known.dims))
        if ordered.dims != ds.variables[name].dims:
            out = out.assign({name: ordered}).set_coords({name} & set(ds.coords))
        out.variables[name].attrs = {"units": known.units_at(kind), "long_name": known.long_name}
    return out


def check_finite(ds: "xr.Dataset", source: str) -> None:
    """Raise `DatabaseError` if any number of the dataset is NaN or infinite, but for coordinates and known gaps."""
    for name, numbers in ds.variables.items():
        if not np.issubdtype(numbers.dtype, np.number) or np.isfinite(numbers.values).all() or name in ds.coords:
            continue
        known = np.isfinite(ds[name])
        for missing in _MISSING:
            known = known | missing(ds, str(name))
        if not known.all():
            raise DatabaseError(f"{source}: variable {name} holds NaN or infinite values; this result cannot be used.")
