"""The year of a buoy under causal control: one controller, the best at a given rms force in the mean spectrum.

The controller is linear: its mean power and the mean square of its force over the seas of the year are those in the
mean spectrum of the year. See `vsb.engine.motion.causal`.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.fft import next_fast_len

from vsb.design.year import Damper, FrequencyGrid, PortYear, band, chebyshev
from vsb.engine.motion.causal import KEPT, Controlled, RmsLimits, StationaryPort, optimum, steadiest
from vsb.engine.motion.causal_slopes import Slopes, slopes
from vsb.engine.motion.take_off import Control
from vsb.engine.waves.climate import Climate
from vsb.engine.waves.kinds import RESOLVED
from vsb.models.stationary import BEYOND, grid
from vsb.tools.arrays import AnyArray, FloatArray

SOLVED = 2.5
"""End of the band whose coefficients are solved, over that of the climate's waves: the controller acts there, too. With
more of it the gain of the example changes by less than 0.001 points."""


def controlled_band(climate: Climate, omega_max: float) -> tuple[float, float]:
    """Return the band solved for causal control, up to a given frequency at most [rad/s]."""
    low, high = band(climate, omega_max)
    return low, min(SOLVED * high, omega_max)


@dataclass(frozen=True)
class ControlGrid(FrequencyGrid):
    """The frequencies of a causal controller, (k + 1/2) spacing within the band solved, and some beyond it.

    Outside the band added mass and radiation damping are those of its nearest end. Between the frequencies of the
    climate its mean density is a broken line, scaled such that the variance is that of its bands.
    """

    ends: tuple[float, float]  # of the band solved [rad/s]
    spacing: float  # [rad/s]
    count: int  # of frequencies in the band

    @classmethod
    def of_control(cls, climate: Climate, omega_max: float, solves: int, finer: int = 1) -> "ControlGrid":
        """Return the grid of a climate; a finer one has less spacing, and goes as much further beyond the band."""
        low, high = controlled_band(climate, omega_max)
        spacing = RESOLVED * 2 * np.pi / (finer * float(climate.te @ climate.hours))
        count = next_fast_len(int(np.ceil(high / spacing)))
        inside, beyond = grid(spacing, count, finer * BEYOND)
        density, edges = climate.mean_density, np.clip(climate.edges, *band(climate, omega_max))
        broken = np.interp(inside, climate.omega, density, left=0.0, right=0.0)
        variance = np.append(broken * (density @ np.diff(edges)) / broken.sum(), np.zeros_like(beyond))
        omega = np.append(inside, beyond)
        return cls(chebyshev(low, high, solves), omega, variance, (low, high), spacing, count)

    @cached_property
    def known(self) -> FloatArray:
        """Frequencies whose coefficients stand for those at all frequencies, shape (omega,) [rad/s]."""
        return np.clip(self.omega, *self.ends)

    def throughout(self, values: AnyArray) -> AnyArray:
        """Return values at all frequencies of the controller from those at the frequencies of this grid, last axis."""
        end = (np.round(self.omega[-1] / self.spacing + 0.5)).astype(int)
        beyond = (np.arange(self.count, end) + 0.5) * self.spacing
        place = np.interp(np.log(beyond), np.log(self.omega[self.count :]), np.arange(len(self.omega) - self.count))
        low = self.count + np.minimum(place.astype(int), len(self.omega) - self.count - 2)
        part = self.count + place - low
        between = (1 - part) * values[..., low] + part * values[..., low + 1]
        return np.concatenate([values[..., : self.count], between], axis=-1)


@dataclass(frozen=True)
class ControlledYear:
    """A buoy's port over the year under the best causal controller within limits, or the damper that absorbs more."""

    year: PortYear
    limits: RmsLimits
    control: Control

    @cached_property
    def port(self) -> StationaryPort:
        """The port in the year's mean spectrum."""
        grid, omega = self._grid, self.year.grid.omega
        density = omega**2 * grid.variance * np.abs(self.year.motion) ** 2 / grid.spacing
        admittance = grid.throughout(-1j * omega * self.year.receptance)
        passive = np.maximum(admittance.real, 0.0) + 1j * admittance.imag
        return StationaryPort(grid.spacing, passive, grid.throughout(density))

    @property
    def _grid(self) -> ControlGrid:
        assert isinstance(self.year.grid, ControlGrid)
        return self.year.grid

    @cached_property
    def found(self) -> Controlled:
        """The optimum, or, where no control keeps the stroke, the one with the least: a search looks beyond limits."""
        if not self.keeps_stroke:
            return self.steadiest
        return optimum(self.port, self.limits, self.control.noise, self.control.forecast)

    @cached_property
    def steadiest(self) -> Controlled:
        """The control with the least stroke."""
        return steadiest(self.port, self.limits.force, self.control.noise, self.control.forecast)

    @property
    def keeps_stroke(self) -> bool:
        """Whether some control keeps the stroke."""
        limit = self.limits.stroke
        return bool(np.isinf(limit)) or self.steadiest.stroke_rms <= limit * (1 + KEPT)

    @cached_property
    def damper(self) -> Damper | None:
        """The best damper of the same rms force, where it absorbs more than the controller."""
        best = self.year.damper_within(self.limits.force)
        return best if best.power > self.found.power and best.stroke <= self.limits.stroke else None

    @property
    def absorbed(self) -> tuple[FloatArray, FloatArray, float]:
        """Frequencies [rad/s], mean power by frequency, shape (omega,), and what noise loses of it in each sea [W]."""
        if self.damper:
            return self.year.grid.omega, self.year.absorbed(self.damper.damping), 0.0
        port, noise = self.port, self.control.noise
        gain = port.controller(self.found.weights, noise, self.control.forecast)
        lost = port.integral(port.admittance.real * np.abs(gain) ** 2) * noise * float(port.excitation.max())
        return port.omega, port.spacing * port.absorbed(gain), lost

    @property
    def other_levels(self) -> dict[str, float]:
        """Mean power of the best damper whose force has the same rms, and with the future known [W]."""
        damper = self.year.damper_within(self.found.force_rms)
        return {"damper_same_force": damper.power, "future_known": optimum(self.port, self.limits, 0.0, np.inf).power}

    @property
    def slopes(self) -> Slopes:
        """Derivatives of power and mean squares by the variables."""
        return self._slopes(self.found, steadiest=not self.keeps_stroke)

    @property
    def least_stroke(self) -> tuple[float, FloatArray]:
        """Least rms stroke within the limit of force [m], and its derivatives by the variables, shape (variable,)."""
        rms = self.steadiest.stroke_rms
        return rms, self._slopes(self.steadiest, steadiest=True).stroke / (2 * rms)

    def _slopes(self, found: Controlled, *, steadiest: bool) -> Slopes:
        """Derivatives of an optimum."""
        grid, year = self._grid, self.year
        admittance = grid.throughout(-1j * grid.omega * year.receptance_change)
        admittance = np.where(self.port.admittance.real > 0, admittance.real, 0.0) + 1j * admittance.imag
        moved = 2 * np.real(year.motion.conj() * year.motion_change)
        density = grid.throughout(grid.omega**2 * grid.variance * moved / grid.spacing)
        known = self.control
        return slopes(self.port, found, admittance, density, known.noise, known.forecast, steadiest=steadiest)
