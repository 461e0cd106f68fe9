"""Seas of a climate beyond the validity of linear waves and small motions, and their share of the energy."""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from vsb.engine.waves.climate import Climate
from vsb.engine.waves.water import Water, wavenumber
from vsb.models.floating_system import InWaves, SeveralInWaves
from vsb.results.year import Bins, Year, band_weights
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray, IntArray

STEEPEST = 0.05
"""Hs over the length of the energy period, as the ledger of a study has it [-]."""
HIGHEST_WAVE = 1.86
"""Highest of a thousand waves over Hs, sqrt(ln 1000/2) of Rayleigh's distribution [-]."""
HIGHEST_VALUE = 3.72
"""Highest of a thousand maxima over the standard deviation, sqrt(2 ln 1000) [-]."""
MICHE = 0.142
"""Height over length at which waves break in deep water, times tanh(k d) in any [-]."""
MOTION = 0.3
"""Heave over radius beyond which linear hydrodynamics are in doubt [-]."""
DEFORMATION = 0.1
"""Displacement of the shell over radius beyond which small deformations are [-]."""
LIMITS = ("steepness", "breaking", "deformation", "heave")
MARKED = LIMITS[:3]
"""Limits that mark a sea; heave does not: in long waves a buoy follows the water, however far."""
OF_WAVES = 2
"""Limits, the first ones, of the waves alone: of a body no others are known."""
NODES = 8
"""Dampers at which variances are computed, to interpolate between them to 1e-3."""

Marks = dict[str, tuple[tuple[str, ...], FloatArray]]
"""Dimensions and values by name."""


class Beyond(NamedTuple):
    """Seas beyond one limit."""

    name: str
    largest: float  # over the seas of the climate [-]
    limit: float
    seas: BoolArray  # (sea,)

    def energy(self, power: FloatArray, hours: FloatArray) -> float:
        """Return the part of a year's energy from those seas; power and hours of each sea, shape (sea,)."""
        total = float(power @ hours)
        return float((power * hours)[self.seas].sum()) / total if total > 0 else 0.0


def limits_of(radius: float | None) -> tuple[str, ...]:
    """Return the limits known of a buoy of a radius [m], or of a body."""
    return LIMITS if radius is not None else LIMITS[:OF_WAVES]


@lru_cache(maxsize=4)
def wave_limits(climate: Climate, water: Water) -> list[Beyond]:
    """Return the seas too steep for linear waves, and those whose highest of a thousand waves breaks (Miche)."""
    numbers = np.array([wavenumber(2 * np.pi / te, water.depth, water.gravity) for te in climate.te])
    steepness = climate.hs * numbers / (2 * np.pi)
    breaking = HIGHEST_WAVE * steepness / MICHE
    if np.isfinite(water.depth):
        breaking = breaking / np.tanh(numbers * water.depth)
    return [_beyond("steepness", steepness, STEEPEST), _beyond("breaking", breaking, 1.0)]


def motion_limits(motions: Mapping[str, FloatArray], radius: float) -> list[Beyond]:
    """Return the seas in which the highest of a thousand maxima exceeds its limit.

    Parameters
    ----------
    motions : mapping 'heave' or 'deformation' -> ndarray, shape (sea,) [m]
        Root mean squares, see `rms`.
    radius : float [m]
    """
    limits = {"heave": MOTION, "deformation": DEFORMATION}
    return [_beyond(name, HIGHEST_VALUE * value / radius, limits[name]) for name, value in motions.items()]


def _beyond(name: str, values: FloatArray, limit: float) -> Beyond:
    """Seas beyond a limit."""
    return Beyond(name, float(values.max()), limit, values > limit)


def motion_rms(waves: InWaves, climate: Climate, damping: FloatArray, stiffness: float) -> dict[str, FloatArray]:
    """Return the root mean squares of heave and deformation in each sea, shape (sea,) [m].

    Parameters
    ----------
    damping : ndarray, shape (sea,) [N s/m]
        Of each sea.
    stiffness : float [N/m]
        Of the take-off's spring.

    Notes
    -----
    Variances are smooth in the logarithm of the damper, see `vsb.engine.motion.tuning`: a polynomial through few.
    """
    dampers, shares = _nodes(damping)
    heave, shell = waves.motion.with_load(waves.port, waves.port.load(dampers, np.full(len(dampers), stiffness)))
    squares = np.concatenate([_square(heave)[:, None], _square(shell).sum(axis=1)], axis=1)
    squares = squares[:, [0, *(1 + np.flatnonzero(squares[:, 1:].any(axis=(0, 2))))]]  # points that move at all
    bands = (squares / 2) @ band_weights(waves.port.omega, climate).T
    if len(dampers) == 1:
        bands = np.concatenate([bands[:, :1], _undominated(bands[0, 1:])[None]], axis=1)
    each = bands @ climate.density.T  # (damper, row, sea)
    variance = np.maximum(np.einsum("nrs,ns->rs", each, shares), 0.0)
    return {"heave": np.sqrt(variance[0]), "deformation": np.sqrt(variance[1:].max(axis=0, initial=0.0))}


def rms_of_motions(
    waves: SeveralInWaves, climate: Climate, matrices: FloatArray, chosen: IntArray
) -> dict[str, FloatArray]:
    """Return `motion_rms` of damper matrices.

    Parameters
    ----------
    matrices : ndarray, shape (matrix, port, port)
    chosen : ndarray, shape (sea,)
        The matrix of each sea.
    """
    weights, found = band_weights(waves.port.omega, climate), np.zeros((2, len(chosen)))
    for one in np.unique(chosen):
        heave, shell = waves.motion(matrices[one])
        squares = np.concatenate([_square(heave)[None], _square(shell).sum(axis=0)])
        seas = chosen == one
        variance = (squares / 2 @ weights.T) @ climate.density[seas].T
        found[:, seas] = np.sqrt(np.stack([variance[0], variance[1:].max(axis=0, initial=0.0)]))
    return {"heave": found[0], "deformation": found[1]}


def _undominated(rows: FloatArray) -> FloatArray:
    """The rows no other exceeds in every band, (row, band): in any sea the largest is one of them."""
    below = (rows[:, None] <= rows).all(axis=2)
    twins = below & below.T
    return rows[~((below & ~twins) | np.tril(twins, -1)).any(axis=1)]


def _square(phasor: ComplexArray) -> FloatArray:
    """Squared size."""
    return np.asarray(phasor.real**2 + phasor.imag**2)


def _nodes(damping: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Chebyshev's nodes between the least and the largest damper, and the share of each in every sea."""
    low, high = float(damping.min()), float(damping.max())
    if low <= 0 or high - low <= 1e-9 * high:
        return np.array([high]), np.ones((1, len(damping)))
    nodes = np.cos((np.arange(NODES) + 0.5) * np.pi / NODES)
    middle, half = np.log(high * low) / 2, np.log(high / low) / 2
    x = (np.log(damping) - middle) / half
    others = [np.delete(nodes, k)[:, None] for k in range(NODES)]
    shares = [np.prod((x - other) / (node - other), axis=0) for node, other in zip(nodes, others, strict=True)]
    return np.exp(middle + half * nodes), np.array(shares)


def beyond_validity(year: Year, motions: Callable[[str, str], Mapping[str, FloatArray]], radius: float | None) -> Marks:
    """Return which part of the seas of each bin lies beyond validity, and their shares of the energy.

    Parameters
    ----------
    motions : callable
        Design, tuning -> root mean squares of its motions in each sea, as of `motion_rms`.
    radius : float or None [m]
        Of a buoy; of a body only the waves are judged.
    """
    of_waves, hours = wave_limits(year.climate, year.water), year.climate.hours
    sizes, known = (len(year.designs), len(year.tunings)), limits_of(radius)
    marked, energy = np.zeros((*sizes, *year.bins.shape)), np.zeros((*sizes, len(known)))
    together = np.zeros(sizes)
    for i, design in enumerate(year.designs):
        for j, tuning in enumerate(year.tunings):
            limits = list(of_waves)
            if radius is not None:
                limits += motion_limits(motions(design, tuning), radius)
            limits.sort(key=lambda one: known.index(one.name))
            power, beyond = year.power[i, j], np.any([one.seas for one in limits if one.name in MARKED], axis=0)
            marked[i, j] = year.bins.mean(beyond.astype(float))
            energy[i, j] = [one.energy(power, hours) for one in limits]
            together[i, j] = Beyond("marked", 0.0, 0.0, beyond).energy(power, hours)
    by = ("design", "tuning")
    return {
        "beyond_validity": ((*by, "hs", "te"), marked),
        "energy_beyond": ((*by, "limit"), energy),
        "energy_beyond_validity": (by, together),
    }


def beyond_in_bins(
    bins: Bins,
    climate: Climate,
    water: Water,
    power: FloatArray,
    moved: Mapping[str, FloatArray],
    radius: float | None,
) -> dict[str, float | FloatArray]:
    """Return the same of one design whose motion is known of the mean spectrum of each bin, which marks all of it.

    Parameters
    ----------
    power : ndarray, shape (hs, te) [W]
    moved : mapping 'heave' or 'deformation' -> ndarray, shape (hs, te) [m]
        Root mean squares.
    """
    shares = {limit.name: bins.mean(limit.seas.astype(float)) for limit in wave_limits(climate, water)}
    steep = bins.mean(np.any([limit.seas for limit in wave_limits(climate, water)], axis=0).astype(float))
    marked = steep
    if radius is not None:
        for limit in motion_limits({name: values.ravel() for name, values in moved.items()}, radius):
            shares[limit.name] = limit.seas.reshape(bins.shape).astype(float)
        marked = np.where(shares["deformation"] > 0, 1.0, steep)
    energy = bins.share * power
    total = max(float(energy.sum()), np.finfo(float).tiny)
    return {
        "beyond_validity": marked,
        "energy_beyond": np.array([float((energy * shares[name]).sum()) / total for name in limits_of(radius)]),
        "energy_beyond_validity": float((energy * marked).sum()) / total,
    }
