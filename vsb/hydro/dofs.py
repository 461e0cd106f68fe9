"""Degrees of freedom of a body of revolution, as values: rigid motions and the shell's shapes, of one azimuthal order.

On disk, and in content ids, they are labels: `Displacement.label` writes them, `displacements` alone reads them.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from vsb.errors import ConfigError
from vsb.hydro.azimuthal import legendre_function
from vsb.study.quantities import is_rigid
from vsb.tools.arrays import FloatArray

Kind = Literal["radial", "meridional", "surge", "heave", "pitch"]
_ORDER = {"surge": 1, "heave": 0, "pitch": 1}
"""Azimuthal order of the rigid motions in the plane of the waves."""
_NEEDED = (
    "needs Radial<n> (n >= order) or Meridional<n> (n >= order, n > 0), Heave of order 0, or Surge or Pitch of order 1"
)


@dataclass(frozen=True, slots=True)
class Displacement:
    """What the points of a shell do per unit amplitude, going with cos(m theta) around it; checked when made.

    Shapes of the shell are P_n^m(cos phi) along e_r (radial) and its derivative by phi along e_phi (meridional), phi
    the colatitude on the undeformed sphere. Rigid motions are surge along x, heave along z, and pitch about the y axis
    through the origin, as capytaine's [m/s per rad/s].
    """

    kind: Kind
    degree: int = 1  # n; of a rigid motion 1
    order: int = 0  # m

    def __post_init__(self) -> None:
        """Refuse what is no displacement, or none of this order."""
        if self.kind not in get_args(Kind):
            raise ConfigError(f"displacements: received kind {self.kind!r}; needs one of {', '.join(get_args(Kind))}")
        least = max(self.order, 1 if self.kind == "meridional" else 0)
        if self.order < 0 or (
            (self.order, self.degree) != (_ORDER[self.kind], 1) if self.rigid else self.degree < least
        ):
            raise ConfigError(f"displacements: received {self.label} of azimuthal order {self.order}; {_NEEDED}")

    @property
    def rigid(self) -> bool:
        """Whether the shell moves as a whole, else in a shape of its own."""
        return self.kind in _ORDER

    @property
    def label(self) -> str:
        """Its name among displacements of one azimuthal order, on disk and in content ids."""
        return self.kind.capitalize() + ("" if self.rigid and self.degree == 1 else str(self.degree))


def displacements(labels: Iterable[str], order: int = 0) -> tuple[Displacement, ...]:
    """Return the displacements of an azimuthal order that labels name: Radial<n>, Meridional<n>, Surge, Heave, Pitch.

    Raises
    ------
    ConfigError
        If the order has no displacement of a name.
    """

    def one(label: str) -> Displacement:
        match = re.fullmatch(r"(Radial|Meridional)(0|[1-9][0-9]{0,3})|Surge|Heave|Pitch", label)
        if match is None:
            raise ConfigError(
                f"displacements: received {' '.join(label.split())[:40]} of azimuthal order {order}; {_NEEDED}"
            )
        kinds: dict[str, Kind] = {kind.capitalize(): kind for kind in get_args(Kind)}
        return Displacement(kinds[match[1] or label], int(match[2] or 1), order)

    return tuple(one(str(label)) for label in labels)


def flexible(labels: Iterable[str], motions: FloatArray | None = None) -> bool:
    """Return whether any of the degrees of freedom labelled is a shape of its own, no rigid motion.

    Of those that `motions`, shape (dof, free), move, where they are given.
    """
    names = [str(label) for label in labels]
    moved = names if motions is None else [name for name, row in zip(names, motions, strict=True) if row.any()]
    return not all(map(is_rigid, moved))


def azimuthal_order(moved: Sequence[Displacement]) -> int:
    """Return the azimuthal order m that displacements have in common.

    Raises
    ------
    ConfigError
        If there are none, some are not values, some are the same, or orders mix: each is a problem of its own.
    """
    if names := [each for each in moved if not isinstance(each, Displacement)]:
        raise ConfigError(f"displacements: received {names[0]!r}; needs values such as Displacement('radial', 3)")
    orders = {each.order for each in moved}
    if len(orders) != 1 or len(set(moved)) < len(moved):
        received = ", ".join(f"{each.label} of order {each.order}" for each in moved) or "none"
        raise ConfigError(f"displacements: received {received}; needs one or more, all of one order, none twice")
    return orders.pop()


def normal_velocities(
    moved: Sequence[Displacement], colatitude: FloatArray, position: FloatArray, normal: FloatArray
) -> FloatArray:
    """Return the normal velocities at theta = 0 of displacements of unit rate, shape (displacement, point).

    Parameters
    ----------
    moved : sequence of Displacement
    colatitude : ndarray, shape (point,) [rad]
        Of the material points, on the undeformed sphere; strictly between the poles for m > 0.
    position, normal : ndarray, shape (2, point)
        Radius and height of the points [m], and of the unit normal there.
    """
    (x, z), (n_x, n_z), (sin, cos) = position, normal, (np.sin(colatitude), np.cos(colatitude))
    along_r, along_phi = n_x * sin + n_z * cos, n_x * cos - n_z * sin
    rigid = {"surge": n_x, "heave": n_z, "pitch": z * n_x - x * n_z}

    def velocity(each: Displacement) -> FloatArray:
        if each.rigid:
            return np.asarray(rigid[each.kind])
        p, slope = legendre_function(each.degree, each.order, colatitude)
        return np.asarray(p * along_r if each.kind == "radial" else slope * along_phi)

    return np.array([velocity(each) for each in moved])
