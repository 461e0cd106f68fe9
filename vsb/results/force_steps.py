"""Optima in a sea at a few limits of the take-off's force, for an interactive page to step through.

An irregular sea is taken to repeat: one realisation of its spectrum on equally spaced frequencies, the same for all
designs and limits, as many as a budget of time allows. How many follows from the size of the problem, not from a clock.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vsb.engine.motion.constrained import optimum_in_sea
from vsb.engine.motion.force_bound import Harmonics, Limits
from vsb.engine.motion.port import Port
from vsb.engine.motion.tuning import best_dampers
from vsb.engine.waves.kinds import Irregular, RegularWave
from vsb.engine.waves.seas import Sea
from vsb.errors import VsbError
from vsb.results.constrained_year import SECONDS_AT_LEAST, SECONDS_PER_CUBE
from vsb.tools.arrays import FloatArray

SHARES = (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0)
"""Limits of force, over the largest force of the reference's best damper [-]."""
SECONDS = 4.0
"""Budget of time of all seas, designs and limits of a page [s]."""
FEWEST, MOST = 64, 200
"""Harmonics of an irregular sea."""
WITHIN = 16
"""Frequencies at which a spectrum is averaged within the band of a harmonic."""

SeenPort = Callable[[FloatArray], Port]


@dataclass(frozen=True)
class ForceSteps:
    """Optima at some limits of force in one sea."""

    limits: tuple[float, ...]  # ascending [N]
    powers: Mapping[str, tuple[float | None, ...]]  # by design, at each limit [W]; None: not known
    of: str  # whose best damper needs the largest of the limits
    repeats: float | None  # period after which the sea is taken to repeat [s]; None of a regular wave


def harmonics_within(band: tuple[float, float], programmes: int) -> Harmonics:
    """Return equally spaced frequencies of a band [rad/s], as many as the budget allows for so many optima."""
    each = SECONDS / programmes - SECONDS_AT_LEAST
    count = int(np.clip(np.cbrt(max(each, 0.0) / SECONDS_PER_CUBE), FEWEST, MOST))
    low, high = band
    spacing = (high - low) / count
    first = max(1, int(np.ceil(low / spacing - 1e-9)))
    return Harmonics(spacing, float(first), int(high / spacing + 1e-9) - first + 1)


def repeating(wave: Irregular, harmonics: Harmonics) -> Sea:
    """Return a realisation of a spectrum on harmonics, each with the variance of the band around it.

    A record's own phases are not of these harmonics: it has random ones, too.
    """
    low, high = (harmonics.omega + side * harmonics.spacing / 2 for side in (-1, 1))
    amplitude = np.sqrt(2 * wave.variances(low, high))
    phase = np.random.default_rng(wave.seed if wave.drawn else 1).uniform(0.0, 2 * np.pi, harmonics.count)
    return Sea(harmonics.omega, amplitude * np.exp(1j * phase))


def force_steps(
    wave: RegularWave | Irregular,
    seen: Mapping[str, SeenPort],
    reference: str | None,
    band: tuple[float, float],
    seas: int = 1,
    stroke: float = np.inf,
) -> ForceSteps | None:
    """Return the optima of all designs in one sea; None where waves move no port.

    Parameters
    ----------
    seen : mapping design -> callable
        Frequencies -> its port, also outside the band.
    reference : str or None
        The design whose best damper the limits are of; else the first whose port waves move.
    band : (float, float) [rad/s]
        Of the force.
    seas : int
        How many the budget of time is for.
    stroke : float
        Limit of the port's displacement from rest [m].
    """
    if wave.irregular:
        harmonics = harmonics_within(band, seas * len(seen) * len(SHARES))
        waves, repeats = repeating(wave, harmonics), 2 * np.pi / harmonics.spacing
    else:
        waves, repeats = wave.realisation(), None
        harmonics = Harmonics.of_sea(waves.omega, *band)
    ports = {design: port(harmonics.port_omega) for design, port in seen.items()}
    of = next((d for d in (reference, *ports) if d in ports and ports[d].moves), None)
    if of is None:
        return None
    limits = tuple(share * _damper_force(ports[of], waves, harmonics) for share in SHARES)
    powers = {d: tuple(_power(port, waves, harmonics, limit, stroke) for limit in limits) for d, port in ports.items()}
    return ForceSteps(limits, powers, of, repeats)


def _damper_force(port: Port, waves: Sea, harmonics: Harmonics) -> float:
    """Largest force of the best damper in a sea [N]."""
    port, amplitude = port.at(np.arange(harmonics.count)), np.zeros(harmonics.count, dtype=complex)
    amplitude[np.rint(waves.omega / harmonics.spacing - harmonics.first).astype(int)] = waves.amplitude
    damping = float(best_dampers(port, np.abs(amplitude[None]) ** 2).damping[0])
    return float(np.abs(harmonics.signal(damping * port.velocity_under(port.load(damping)) * amplitude)).max())


def _power(port: Port, waves: Sea, harmonics: Harmonics, force: float, stroke: float) -> float | None:
    """Mean power of the best force within limits [W]; None where there is none, or none is found."""
    if not port.moves:
        return 0.0
    try:
        return optimum_in_sea(port, waves, harmonics, Limits(force, stroke)).power
    except VsbError:
        return None
