"""Kinds of ports: what a take-off acts with and what it moves, and the units of both."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

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
