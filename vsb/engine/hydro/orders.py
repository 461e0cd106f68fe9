"""The hydro database of a buoy that moves in several directions: coefficients of every azimuthal order side by side.

Orders do not mix on a body of revolution: all matrices are blocks, each with one radiation channel of its own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.linalg import block_diag

from vsb.engine.hydro.database import transformed, with_history
from vsb.engine.hydro.dofs import Displacement, displacements
from vsb.engine.hydro.quality import haskind_damping
from vsb.engine.hydro.variables import PAIR
from vsb.engine.shell.orders import OrderBasis, semi_normalisation
from vsb.errors import DatabaseError
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

ORDER = "azimuthal_order"
"""Variable of a database with the order m of each degree of freedom; without it all are of order 0.

Negative for motions that go with sin(m theta), as real spherical harmonics are numbered: a separate channel.
"""


def order_shares(solved: Sequence[Displacement], basis: OrderBasis) -> FloatArray:
    """Return the displacements of the undeformed sphere that a basis consists of, shape (dof, displacement) [-].

    Meridional ones, along the surface, move no water; nor does pitch, about the sphere's centre. Raises `DatabaseError`
    if a displacement they need was not solved for.
    """
    wanted = basis.radial
    needed = {Displacement("radial", degree, basis.order) for degree, share in wanted if share}
    if missing := sorted(each.label for each in needed - set(solved)):
        labels = [each.label for each in solved]
        raise DatabaseError(f"displacements {missing} of order {basis.order} are not among those solved, {labels}.")
    rows = [
        [share * semi_normalisation(degree, basis.order) * (each.degree == degree) for each in solved]
        for degree, share in wanted
    ]
    return np.array(rows)


def in_order_modes(raw: xr.Dataset, basis: OrderBasis) -> xr.Dataset:
    """Return coefficients of radial displacements of an order as coefficients of rigid motions and modes."""
    solved = displacements(raw.influenced_dof.values, basis.order)
    return transformed(raw, order_shares(solved, basis), basis.labels)


def in_wet_modes(raw: xr.Dataset, basis: OrderBasis) -> xr.Dataset:
    """Return the same without pitch, which about a sphere's centre moves no water."""
    moved = in_order_modes(raw, basis)
    still = [label for label in basis.labels if label == "Pitch"]
    return moved.drop_sel(influenced_dof=still, radiating_dof=still)


def with_haskind_damping(ds: xr.Dataset, order: int, depth: float, density: float, gravity: float) -> xr.Dataset:
    """Return the dataset with the damping its excitation implies, the repair recorded in `history`.

    Radiation of order m >= 1 vanishes as a high power of frequency, below the errors of solver and interpolation, which
    may be negative; the check `haskind` bounds the change.
    """
    damping = haskind_damping(ds, depth, density, gravity, order).real
    made = ds.assign(radiation_damping=(ds.radiation_damping.dims, damping))
    return with_history(made, f"damping of order {order} from excitation (Haskind)")


def heading_shares(orders: IntArray | int, direction: float) -> FloatArray:
    """Return the excitation of orders by waves going to a direction [rad], relative to the largest, (order,) [-].

    cos m(theta - beta) = cos(m theta) cos(m beta) + sin(m theta) sin(m beta); negative orders go with the sine.
    """
    turned = np.multiply(orders, direction)
    return np.where(np.less(orders, 0), -np.sin(turned), np.cos(turned))


def own_heading(order: int) -> float:
    """Return the direction of waves that excite an order most [rad]: 0, of a sine 90 degrees/m."""
    return -np.pi / (2 * order) if order < 0 else 0.0


def headings(orders: Sequence[int]) -> list[float]:
    """Return directions from which the excitation of orders follows for all others, ascending [rad]."""
    return sorted({own_heading(order) for order in orders} | {0.0})


def in_headings(ds: xr.Dataset, order: int, directions: Sequence[float]) -> xr.Dataset:
    """Return coefficients of an order, known for the direction of largest excitation, in waves of directions [rad]."""
    share = xr.DataArray([float(heading_shares(order, at)) for at in directions], dims="wave_direction")
    turned = {
        name: (data.isel(wave_direction=0, drop=True) * share).transpose(*data.dims)
        for name, data in ds.data_vars.items()
        if "wave_direction" in data.dims
    }
    return ds.drop_dims("wave_direction").assign(turned).assign_coords(wave_direction=list(directions))


def renamed(ds: xr.Dataset, labels: Sequence[str]) -> xr.Dataset:
    """Return coefficients with other names of their degrees of freedom."""
    return ds.assign_coords({dim: list(labels) for dim in PAIR})


def still_part(like: xr.Dataset, basis: OrderBasis) -> xr.Dataset:
    """Return the coefficients of motions that move no water, as of another part of a database."""
    one = like.isel({dim: [0] * len(basis.labels) for dim in PAIR})
    return (0.0 * one).assign_coords({dim: list(basis.labels) for dim in PAIR}).assign_attrs(like.attrs)


def side_by_side(parts: Sequence[xr.Dataset], orders: Sequence[int]) -> xr.Dataset:
    """Return datasets of several orders as one, without coupling.

    Parameters
    ----------
    parts : sequence of xarray.Dataset
        Of the same frequencies and directions, each with all its matrices.
    orders : sequence of int
        Azimuthal order of each, negative of sines.
    """
    labels = [str(label) for part in parts for label in part.influenced_dof.values]
    found = {name: _joined([part[name] for part in parts]) for name in parts[0].data_vars}
    of = np.repeat(orders, [part.sizes["influenced_dof"] for part in parts])
    kept = {str(dim): values for dim, values in parts[0].coords.items() if dim not in PAIR}
    history = "; ".join(dict.fromkeys(part.attrs["history"] for part in parts if part.attrs.get("history")))
    together = xr.Dataset({**found, ORDER: (PAIR[0], of)}, {**kept, **dict.fromkeys(PAIR, labels)})
    return together.assign_attrs({**parts[0].attrs, "history": history})


def _joined(blocks: Sequence[xr.DataArray]) -> tuple[tuple[str, ...], npt.NDArray[np.inexact]]:
    """Dims and values of one variable over all degrees of freedom, which its dims end with."""
    dims = tuple(map(str, blocks[0].dims))
    values = [np.asarray(block.values) for block in blocks]
    if dims[-2:] != PAIR:
        return dims, np.concatenate(values, axis=-1)
    lead = values[0].shape[:-2]
    rows = [value.reshape(-1, *value.shape[-2:]) for value in values]
    stacked = np.array([block_diag(*matrices) for matrices in zip(*rows, strict=True)])
    return dims, stacked.reshape(*lead, *stacked.shape[-2:])


def orders_of(ds: xr.Dataset) -> IntArray:
    """Return the azimuthal order of each degree of freedom of a database, shape (dof,)."""
    return np.asarray(ds[ORDER].values) if ORDER in ds else np.zeros(ds.sizes["influenced_dof"], dtype=int)


def own_headings(ds: xr.Dataset) -> IntArray:
    """Return the index of the direction that excites each degree of freedom most, shape (dof,)."""
    own = np.array([own_heading(int(order)) for order in orders_of(ds)])
    if not own.any():
        return np.zeros(len(own), dtype=np.intp)
    return np.asarray(np.argmin(np.abs(ds.wave_direction.values - own[:, None]), axis=1))


def most_exciting(ds: xr.Dataset, name: str) -> ComplexArray:
    """Return a force in the waves that excite each degree of freedom most, shape (omega, dof) [N/m]."""
    found: ComplexArray = ds[name].values[:, own_headings(ds), np.arange(ds.sizes["influenced_dof"])]
    return found


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions of waves that differ from frequency to frequency."""

    omega: FloatArray  # ascending (component,) [rad/s]
    direction: FloatArray  # (component,) [rad]

    def at(self, omega: FloatArray) -> FloatArray:
        """Return the direction of the component nearest to each frequency, shape (omega,) [rad]."""
        between = (self.omega[1:] + self.omega[:-1]) / 2
        return np.asarray(self.direction[np.searchsorted(between, omega)])

    def shares(self, orders: IntArray, omega: FloatArray) -> FloatArray:
        """Return `heading_shares` at each frequency, shape (omega, dof) [-]."""
        known, place = np.unique(self.at(omega), return_inverse=True)
        return np.array([heading_shares(orders, float(one)) for one in known])[place]


def order_groups(ds: xr.Dataset) -> dict[int, IntArray]:
    """Return the indices of the degrees of freedom of each azimuthal order, ascending, sines after cosines."""
    orders = orders_of(ds)
    return {int(m): np.flatnonzero(orders == m) for m in sorted(np.unique(orders), key=lambda m: (abs(m), -m))}


def with_order_structure(ds: xr.Dataset, basis: OrderBasis, stiffness: Mapping[str, FloatArray]) -> xr.Dataset:
    """Return the dataset of an order with inertia and stiffness by name; as of `hydro.database.with_structure`."""
    nothing = ("influenced_dof", np.zeros(len(basis.labels)))  # no radial motion of the pole, no shape at rest
    matrices = {f"{name}_stiffness": (PAIR, matrix) for name, matrix in stiffness.items()}
    return ds.assign(matrices).assign(
        inertia_matrix=(PAIR, basis.inertia), pole_radial_displacement=nothing, reference_amplitude=nothing
    )
