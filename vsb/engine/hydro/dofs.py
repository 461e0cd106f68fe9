"""Degrees of freedom of a body of revolution: rigid motions and shell shapes of one azimuthal order m.

Surge, pitch and shell shapes go with cos(m theta). On a body of revolution orders do not mix, neither in the shell nor
in the water: each is a problem of its own, and of a wave it sees one component of
e^{ikx} = sum_m (2 - delta_m0) i^m J_m(kR) cos(m theta). On disk, and in content ids, degrees of freedom are labels:
`Displacement.label` writes them, `displacements` alone reads them.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy.special import assoc_legendre_p, j0, j1, jv

from vsb.engine.hydro.variables import is_rigid
from vsb.engine.shell.ritz import legendre
from vsb.errors import ConfigError
from vsb.tools.arrays import ComplexArray, FloatArray


def legendre_function(degree: int, order: int, colatitude: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return P_n^m(cos phi), without Condon and Shortley's sign: P_1^1 = sin phi, and its derivative by phi.

    At colatitudes, shape (point,) [rad], strictly between the poles for m > 0.
    """
    if order == 0:
        p, dp, _ = legendre(degree, colatitude)
        return p[degree], dp[degree]
    p, by_cos = (-1.0) ** order * assoc_legendre_p(degree, order, np.cos(colatitude), diff_n=1)
    return np.asarray(p), np.asarray(-np.sin(colatitude) * by_cos)


def wave_around(order: int, points: int, kx: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Return the component of order m > 0 of exp(i kx cos theta) over points around a circle, and its rise by kx.

    2 i^m J_m(kx) and its derivative for many points; with few points aliased as the panels' solution is. `kx`, shape
    (circle,), is wavenumber times radius.
    """
    theta = 2 * np.pi * np.arange(points) / points
    weight, wave = 2 / points * np.cos(order * theta), np.exp(1j * np.outer(kx, np.cos(theta)))
    return np.asarray(wave @ weight), np.asarray(wave @ (1j * np.cos(theta) * weight))


def multiplicity(order: int) -> int:
    """Return Neumann's factor 2 - delta_m0 of an azimuthal order; int cos^2(m theta) d theta is 2 pi over it."""
    return 2 if order else 1


def bessel(order: int, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Bessel's J_m(x) and J_{m-1}(x), each of the shape of x [-]; J_m' = J_{m-1} - m J_m/x."""
    if order == 0:
        return j0(x), -j1(x)
    return (j1(x), j0(x)) if order == 1 else (jv(order, x), jv(order - 1, x))


Kind = Literal["radial", "meridional", "load", "surge", "heave", "pitch"]
_ORDER = {"surge": 1, "heave": 0, "pitch": 1}
"""Azimuthal order of the rigid motions in the plane of the waves."""
_NEEDED = (
    "needs Radial<n> (n >= order) or Meridional<n> (n >= order, n > 0), Load<i> or Heave of order 0, or Surge or Pitch "
    "of order 1"
)


@dataclass(frozen=True, slots=True)
class Displacement:
    """Displacement of the points of a shell per unit amplitude, going with cos(m theta) around it; checked when made.

    Shapes of the shell are P_n^m(cos phi) along e_r (radial) and its derivative by phi along e_phi (meridional), phi
    the colatitude on the undeformed sphere. Rigid motions are surge along x, heave along z, and pitch about the y axis
    through the origin, as capytaine's [m/s per rad/s]. What the wall does under a load at a ring has many degrees.
    """

    kind: Kind
    degree: int = 1  # n; of a rigid motion 1, of a load its number
    order: int = 0  # m
    parts: tuple[tuple[int, float, float], ...] = ()  # under a load: degrees, radial and meridional amplitude of each

    def __post_init__(self) -> None:
        """Refuse unknown kinds, and kinds that this order does not have."""
        if self.kind not in get_args(Kind):
            raise ConfigError(f"displacements: received kind {self.kind!r}; needs one of {', '.join(get_args(Kind))}")
        least = max(self.order, 0 if self.kind == "radial" else 1)
        if (
            self.order < 0
            or (self.kind == "load" and self.order)
            or ((self.order, self.degree) != (_ORDER[self.kind], 1) if self.rigid else self.degree < least)
        ):
            raise ConfigError(f"displacements: received {self.label} of azimuthal order {self.order}; {_NEEDED}")

    @property
    def rigid(self) -> bool:
        """Whether the shell moves as a whole, else in a shell shape."""
        return self.kind in _ORDER

    @property
    def highest(self) -> int:
        """The highest Legendre degree of it."""
        return max((part[0] for part in self.parts), default=self.degree)

    @property
    def label(self) -> str:
        """Its name among displacements of one azimuthal order, on disk and in content ids."""
        return self.kind.capitalize() + ("" if self.rigid and self.degree == 1 else str(self.degree))


def displacements(labels: Iterable[str], order: int = 0) -> tuple[Displacement, ...]:
    """Return the displacements of an azimuthal order that labels name: Radial<n>, Meridional<n>, Load<i>, Heave, ...

    Of loads the parts are not known.

    Raises `ConfigError` if the order has no displacement of a name.
    """

    def one(label: str) -> Displacement:
        match = re.fullmatch(r"(Radial|Meridional|Load)(0|[1-9][0-9]{0,3})|Surge|Heave|Pitch", label)
        if match is None:
            raise ConfigError(
                f"displacements: received {' '.join(label.split())[:40]} of azimuthal order {order}; {_NEEDED}"
            )
        kinds: dict[str, Kind] = {kind.capitalize(): kind for kind in get_args(Kind)}
        return Displacement(kinds[match[1] or label], int(match[2] or 1), order)

    return tuple(one(str(label)) for label in labels)


def flexible(labels: Iterable[str], motions: FloatArray | None = None) -> bool:
    """Return whether any of the labelled degrees of freedom is a shell shape, no rigid motion.

    Where `motions`, shape (dof, free), are given, only of those that they move.
    """
    names = [str(label) for label in labels]
    moved = names if motions is None else [name for name, row in zip(names, motions, strict=True) if row.any()]
    return not all(map(is_rigid, moved))


def azimuthal_order(moved: Sequence[Displacement]) -> int:
    """Return the azimuthal order m that displacements have in common.

    Raises `ConfigError` if there are none, or values of another type, duplicates or several orders.
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
        if each.kind == "load":
            degrees, radial, meridional = np.array(each.parts).T
            p, slope, _ = (table[degrees.astype(int)] for table in legendre(each.highest, colatitude))
            return np.asarray(along_r * (radial @ p) + along_phi * (meridional @ slope))
        p, slope = legendre_function(each.degree, each.order, colatitude)
        return np.asarray(p * along_r if each.kind == "radial" else slope * along_phi)

    return np.array([velocity(each) for each in moved])
