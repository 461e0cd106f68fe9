"""Mean power of a switching take-off in a regular wave, once its motion is periodic."""

from dataclasses import dataclass

import numpy as np

from vsb.engine.integrators.harmonic_balance import regular_frequency
from vsb.engine.integrators.switching import EXACT, Switching
from vsb.engine.motion.system import System
from vsb.errors import ConvergenceError
from vsb.tools.arrays import FloatArray

RECORDED = 16
"""Recorded instants of a period."""
FEWEST, MOST = 16, 64
"""Periods followed at first, and at most at a time; each time twice as many."""
FINEST = 2**15
"""Most instants of a period at which switches are looked for: more would take hours for a steady state."""
CONTINUED = 8
"""Periods followed at first from the end of another motion."""
FOLLOWED = 0.1
"""Tolerance of the motion over that of its mean power."""
Start = tuple[FloatArray, ...]
"""y [m], y' [m/s] and memory states."""


def periodic_power(system: System, tolerance: float = 1e-6) -> tuple[float, float]:
    """Return the mean absorbed power of a scene in a regular wave [W], starting at rest, and its unsteadiness.

    Raises `ConfigError` if the sea is not one regular wave; `ConvergenceError` if the port responds so fast that a
    period needs more than `FINEST` instants.

    Parameters
    ----------
    system : System
        Linear or body-exact except for a take-off that switches.
    tolerance : float
        Largest relative difference between the periods of the last half of what is followed at a time.

    Returns
    -------
    power : float
        Over whole periods, the last quarter of the run [W].
    unsteady : float
        Relative difference between periods: above the tolerance the motion is not periodic, or its transient outlasts
        the run.
    """
    step = 2 * np.pi / regular_frequency(system) / RECORDED
    runner = Switching(system)
    if (instants := RECORDED * runner.finer(step)) > FINEST:
        raise ConvergenceError(
            f"no steady state was computed: the port responds at {runner.rate(runner.stop):.3g} rad/s, so each "
            f"period needs {instants} instants, needs at most {FINEST}; leave out stiff modes or soften the shell"
        )
    found = _follow(system, tolerance, system.scene.start(0.0, 0.0), FEWEST, MOST)
    return found[0], found[1]


@dataclass
class Trials:
    """Periodic powers of one scene under several laws, each motion started from the end of the best one so far.

    A law may have several periodic motions: started from one that absorbs little it may stay in such a one.

    Parameters
    ----------
    tolerance : float
        Largest relative difference between late periods; after `CONTINUED` and `FEWEST` further ones
        the power is used as it is.
    """

    tolerance: float
    most: float = -np.inf  # [W]
    ended: Start | None = None  # the end of its motion

    def power(self, system: System) -> float:
        """Return the mean absorbed power of late periods [W]; 0 if the motion cannot be followed."""
        start = self.ended or system.scene.start(0.0, 0.0)
        try:
            power, _, ended = _follow(system, self.tolerance, start, CONTINUED, FEWEST)
        except ConvergenceError:
            return 0.0
        if power > self.most:
            self.most, self.ended = power, ended
        return power


def _follow(system: System, tolerance: float, start: Start, fewest: int, most: int) -> tuple[float, float, Start]:
    """Mean power of late periods of a motion started at a crest, their difference, and the end of the motion."""
    period, runner = 2 * np.pi / regular_frequency(system), Switching(system, max(FOLLOWED * tolerance, EXACT))
    begin, count = 0.0, fewest
    while True:
        end = begin + count * period
        motion, _ = runner.follow(np.linspace(begin, end, count * RECORDED + 1), start)
        half = (np.diff(motion.works["pto"][::RECORDED]) / period)[count // 2 :]
        unsteady = float(np.ptp(half) / max(np.abs(half).max(), np.finfo(float).tiny))
        start = (motion.position[-1], motion.velocity[-1], motion.memory[-1])
        if unsteady <= tolerance or count >= most:
            return float(half[count // 4 :].mean()), unsteady, start
        begin, count = end, 2 * count
