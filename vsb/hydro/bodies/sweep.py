"""Coefficients of a general body over a band: how far they may be off, and interpolated from as few solves as it needs.

Displacements may be metres or radians: all errors are told after scaling each to unit added mass at infinite frequency,
in terms of the largest added mass, damping and excitation of the band.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from vsb.errors import DatabaseError
from vsb.hydro.bodies.body import FlexibleBody
from vsb.hydro.bodies.solver import unit_wave
from vsb.hydro.database import ESTIMATE, with_excitation
from vsb.hydro.sweep import FORCES, MOST_SOLVES, IncidentWave, apart, joined, on_grid
from vsb.hydro.variables import PAIR
from vsb.study.study import Water
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.waves.dispersion import wavenumber

_LEAST_SIZE = 0.3
"""Of a displacement, in terms of the water it would move if all of the displaced water moved like the surface."""
_WEAKEST = 1.2
"""Ratio of resolutions from which on two of them say something of the error."""
_MATRICES = ("added_mass", "radiation_damping")


@dataclass(frozen=True)
class Measure:
    """What coefficients are measured in: displacements of unit added mass, waves seen from the middle of the body."""

    size: FloatArray  # (dof,): root of the added mass at infinite frequency
    centre: FloatArray  # (xyz) [m]
    directions: FloatArray  # (direction,) [rad]
    water: Water

    def __post_init__(self) -> None:
        """Refuse what no size can be."""
        if not (self.size > 0).all():
            raise DatabaseError(
                "added_mass_inf: received a diagonal not above zero; needs another mesh: correct panels"
            )

    def force(self, omega: FloatArray) -> ComplexArray:
        """Return the units of forces, those of a unit wave over the middle, shape (omega, direction, dof) [N/m]."""
        over = np.append(self.centre[:2], 0.0)[None]
        k = [wavenumber(float(w), self.water.depth, self.water.gravity) for w in omega]
        waves = np.array([unit_wave(over, each, self.water.depth, self.directions)[:, 0] for each in k])
        return np.asarray(waves[:, :, None] * self.size)

    def applied(self, ds: xr.Dataset) -> xr.Dataset:
        """Return coefficients in this measure."""
        return _times(ds, 1 / self.size, 1 / self.force(ds.omega.values))

    def undone(self, ds: xr.Dataset) -> xr.Dataset:
        """Return coefficients in this measure as they were."""
        return _times(ds, self.size, self.force(ds.omega.values))


def _times(ds: xr.Dataset, size: FloatArray, force: ComplexArray) -> xr.Dataset:
    """Coefficients multiplied by the sizes of their displacements, forces by theirs."""
    matrices = {name: ds[name] * np.outer(size, size) for name in _MATRICES}
    return xr.Dataset(matrices | {name: ds[name] * force for name in FORCES})


class Block(NamedTuple):
    """What is solved at one frequency; at infinity there are no waves."""

    own: xr.Dataset  # coefficients
    fewer: xr.Dataset  # added mass, damping and excitation on fewer panels
    waves: xr.Dataset  # damping by the energy of the far field, excitation by Haskind's relation


class Swept(NamedTuple):
    """Coefficients at the frequencies asked for, and what they come from."""

    coefficients: xr.Dataset
    solved: list[Block]  # frequencies ascending
    error: float  # estimated, of interpolation, relative to the band's largest entry of each


def swept(
    solve: Callable[[float], Block],
    froude_krylov: Callable[[FloatArray], ComplexArray],
    omega: Sequence[float],
    tolerance: float | None,
    measure: Measure,
) -> Swept:
    """Return coefficients at frequencies from as few solves as a tolerance asks (`hydro.sweep`), from all without one.

    Waves are not turned back by a phase at the waterline: on a long barge no such phase saved solves.

    Parameters
    ----------
    solve : callable
        Block of one frequency [rad/s]; it is called once or twice for each that is needed.
    froude_krylov : callable
        Froude-Krylov force of frequencies, shape (omega, direction, dof) [N/m].
    omega : sequence of float [rad/s]
        Ascending.
    tolerance : float [-] or None
        Of the interpolation, as `error`.
    measure : Measure
    """
    if tolerance is None:
        blocks = [solve(w) for w in omega]
        return Swept(joined(*(block.own for block in blocks)), blocks, 0.0)

    def in_measure(some: list[float]) -> xr.Dataset:
        return measure.applied(joined(*(solve(w).own for w in some)))

    def known(at: FloatArray) -> ComplexArray:
        return np.asarray(froude_krylov(at) / measure.force(at))

    found = on_grid(in_measure, omega, tolerance, IncidentWave(np.zeros_like, known, 0), most=MOST_SOLVES)
    blocks, left = [solve(w) for w in found.solved], sorted(set(omega) - set(found.solved))
    between = [measure.undone(found.coefficients.sel(omega=left))] if left else []
    everywhere = joined(*(block.own for block in blocks), *between).sortby("omega")
    return Swept(everywhere, blocks, found.sweep.error if found.sweep else 0.0)


def least_sizes(body: FlexibleBody, density: float) -> FloatArray:
    """Return the least size of displacements, shape (dof,): yaw of a round body moves no water but round-off's."""
    return np.asarray(_LEAST_SIZE * np.sqrt(density * body.volume * (body.modes**2).sum(axis=2).mean(axis=1)))


def sizes(added_mass_inf: FloatArray, least: FloatArray) -> FloatArray:
    """Return the sizes of displacements, roots of added mass at infinite frequency or the least, shape (dof,)."""
    return np.asarray(np.sqrt(np.maximum(np.diag(added_mass_inf), least**2)))


def error_estimate(solved: Sequence[Block], infinite: Block, size: FloatArray) -> float:
    """Return the estimated error of coefficients, relative to the band's largest entry of each [-].

    Notes
    -----
    With panels r times as large, in the mean over the surface, the error of a method of order p grows by r^p: the
    change is r^p - 1 >= r - 1 times the error for p >= 1, the order of flat panels at worst. What both meshes have
    wrong is added for damping and excitation: the distances of the one from the energy of the far field and of the
    other from Haskind's relation. One, all that is, if panels found no partners to be joined with.
    """
    ratio = float(infinite.own.attrs["resolution_ratio"])
    if ratio < _WEAKEST:
        return 1.0
    own, fewer, waves = (joined(*parts) for parts in zip(*solved, strict=True))
    value, coarse, known = (_in_units(ds, size) for ds in (with_excitation(own), fewer, waves))
    limit, other = (ds.added_mass_inf.values / np.outer(size, size) for ds in infinite[:2])
    value["added_mass"], coarse["added_mass"] = (
        np.concatenate([values["added_mass"], at_infinity[None]])
        for values, at_infinity in ((value, limit), (coarse, other))
    )
    largest = {name: float(np.abs(v).max()) or 1.0 for name, v in value.items()}
    both = sum(apart(value[name], known[name]) / largest[name] for name in known)
    change = {name: apart(value[name], coarse[name]) / largest[name] / (ratio - 1) for name in value}
    return max(error + (both if name in known else 0.0) for name, error in change.items())


def change_by_lid(solved: Sequence[Block], bare: Block, size: FloatArray) -> float:
    """Return the change of coefficients by a lid at the frequency of `bare`, relative to the largest entry of each."""
    every, without = (_in_units(with_excitation(ds), size) for ds in (joined(*(b.own for b in solved)), bare.own))
    place = [float(b.own.omega[0]) for b in solved].index(float(bare.own.omega[0]))
    return max(apart(every[name][[place]], without[name]) / (float(np.abs(every[name]).max()) or 1.0) for name in every)


def resolution_ratio(found: Swept) -> float:
    """Return how many times as large the fewer panels are, in the mean over the surface."""
    return float(found.solved[0].own.attrs["resolution_ratio"])


WAYS = ("fewer panels", "waves radiated")
"""How the errors of coefficients are estimated."""


def signed_errors(found: Swept) -> xr.Dataset | None:
    """Return estimated errors of added mass, damping and excitation as they are, value less better value.

    Of each of `WAYS`, on straight lines between the frequencies solved: from fewer panels, for an order of at least one
    (`error_estimate`); and the distances from the energy of the far field and from Haskind's relation. None if panels
    found no partners to be joined with.
    """
    if (ratio := resolution_ratio(found)) < _WEAKEST:
        return None
    own, fewer, waves = (joined(*parts).sortby("omega") for parts in zip(*found.solved, strict=True))
    own, at = with_excitation(own), found.coefficients.omega.values
    errors = {}
    for name in (*_MATRICES, "excitation_force"):
        value = own[name]
        by_waves = value - waves[name] if name in waves else 0.0 * value
        both = xr.concat([(fewer[name] - value) / (ratio - 1), by_waves], dim=ESTIMATE)
        between = both.interp(omega=at) if both.sizes["omega"] > 1 else both
        errors[f"{name}_{ESTIMATE}"] = between.transpose(ESTIMATE, *value.dims)
    return with_symmetric(xr.Dataset(errors).assign_coords({ESTIMATE: list(WAYS)}))


def with_symmetric(errors: xr.Dataset) -> xr.Dataset:
    """Return errors of matrices made symmetric, as the matrices themselves are."""
    swapped = dict(zip(PAIR, PAIR[::-1], strict=True))
    even = {
        name: 0.5 * (data + data.rename(swapped).transpose(*data.dims))
        for name, data in errors.data_vars.items()
        if set(PAIR) <= set(data.dims)
    }
    return errors.assign(even)


def _in_units(ds: xr.Dataset, size: FloatArray) -> dict[str, npt.NDArray[np.inexact[Any]]]:
    """Those of added mass, damping and excitation there are, for displacements of unit size."""
    units = dict.fromkeys(_MATRICES, np.outer(size, size)) | {"excitation_force": size}
    return {name: ds[name].values / unit for name, unit in units.items() if name in ds}
