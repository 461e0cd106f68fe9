"""Which seas of a climate lie beyond what linear waves and small motions describe, and their share of the energy."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from vsb.motion.port import Port
from vsb.results.year import band_weights
from vsb.study.study import Water
from vsb.tools.units import FloatArray
from vsb.waves.climate import Climate
from vsb.waves.seas import wavenumber

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

BoolArray = npt.NDArray[np.bool_]


class Beyond(NamedTuple):
    """Seas beyond one limit."""

    name: str
    largest: float  # over the seas of the climate [-]
    limit: float
    seas: BoolArray  # (sea,)

    def energy(self, power: FloatArray, hours: FloatArray) -> float:
        """Return the part of a year's energy those seas bring; power and hours of each sea, shape (sea,)."""
        total = float(power @ hours)
        return float((power * hours)[self.seas].sum()) / total if total > 0 else 0.0


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


def rms(climate: Climate, omega: FloatArray, response: FloatArray) -> FloatArray:
    """Return the root mean square of a signal in each sea, sqrt(int S |H|^2 dw), shape (sea,).

    Parameters
    ----------
    climate : Climate
    omega : ndarray, shape (omega,) [rad/s]
    response : ndarray, shape (omega,)
        Squared size |H|^2 of its phasor per wave amplitude.
    """
    return np.sqrt(climate.density @ (band_weights(omega, climate) @ (response / 2)))


def stroke_rms(port: Port, climate: Climate, damping: float) -> FloatArray:
    """Return the root mean square of the port's displacement under a damper in each sea, shape (sea,) [m]."""
    velocity = port.velocity_under(port.load(damping))
    return rms(climate, port.omega, np.abs(velocity / port.omega) ** 2)
