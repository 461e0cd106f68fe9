"""Mean power of a take-off that switches in a regular wave, once its motion repeats."""

from dataclasses import dataclass

import numpy as np

from vsb.errors import ConvergenceError
from vsb.integrators.harmonic_balance import regular_frequency
from vsb.integrators.switching import EXACT, Switching
from vsb.motion.system import System
from vsb.tools.arrays import FloatArray

RECORDED = 16
"""Instants of a period; the lookout is finer where it must be."""
FEWEST, MOST = 16, 64
"""Periods followed at a time: twice as many when these were not enough."""
FINEST = 2**15
"""Instants of a period at which switches are looked for, at most: more would take hours for a steady state."""
CONTINUED = 8
"""Periods followed at first from where another motion ended."""
FOLLOWED = 0.1
"""To what part of the tolerance of a power its motion is followed: errors of periods add up to less."""
Start = tuple[FloatArray, ...]
"""y [m], y' [m/s] and memory states."""


def settled_power(system: System, tolerance: float = 1e-6) -> tuple[float, float]:
    """Return the mean absorbed power of a scene in a regular wave from rest on [W], and by how much it is unsettled.

    Parameters
    ----------
    system : System
        Linear or body-exact but for a take-off that switches.
    tolerance : float
        Largest relative difference between the periods of the last half of what is followed at a time.

    Returns
    -------
    power : float
        Of the last quarter, whole periods [W].
    unsettled : float
        Relative difference between periods: above the tolerance the motion does not repeat, or its transient outlasts
        all periods followed.

    Raises
    ------
    ConfigError
        If the sea is none of one frequency.
    ConvergenceError
        If the port feels motion so fast that a period takes more than `FINEST` instants.
    """
    step = 2 * np.pi / regular_frequency(system) / RECORDED
    runner = Switching(system)
    if (instants := RECORDED * runner.finer(step)) > FINEST:
        raise ConvergenceError(
            f"no steady state was sought: the port feels motion at {runner.rate(runner.stop):.3g} rad/s, so each "
            f"period takes {instants} instants, needs at most {FINEST}; leave out stiff modes or soften the shell"
        )
    found = _settling(system, tolerance, system.scene.start(0.0, 0.0), FEWEST, MOST)
    return found[0], found[1]


@dataclass
class Trials:
    """Settled powers of one scene under laws that differ, each motion begun where the one that took most ended.

    A law may have several motions that repeat: begun from one that takes little it may stay with such a one.

    Parameters
    ----------
    tolerance : float
        Largest relative difference between late periods; what differs more after `CONTINUED` and `FEWEST` further ones
        is taken as it is.
    """

    tolerance: float
    most: float = -np.inf  # [W]
    ended: Start | None = None  # the motion that took it

    def power(self, system: System) -> float:
        """Return the mean absorbed power of late periods [W]; nothing where the motion cannot be followed."""
        start = self.ended or system.scene.start(0.0, 0.0)
        try:
            power, _, ended = _settling(system, self.tolerance, start, CONTINUED, FEWEST)
        except ConvergenceError:
            return 0.0
        if power > self.most:
            self.most, self.ended = power, ended
        return power


def _settling(system: System, tolerance: float, start: Start, fewest: int, most: int) -> tuple[float, float, Start]:
    """Mean power of late periods of a motion begun at a crest, by how much these differ, and where it ends."""
    period, runner = 2 * np.pi / regular_frequency(system), Switching(system, max(FOLLOWED * tolerance, EXACT))
    begin, count = 0.0, fewest
    while True:
        end = begin + count * period
        motion, _ = runner.follow(np.linspace(begin, end, count * RECORDED + 1), start)
        half = (np.diff(motion.works["pto"][::RECORDED]) / period)[count // 2 :]
        unsettled = float(np.ptp(half) / max(np.abs(half).max(), np.finfo(float).tiny))
        start = (motion.position[-1], motion.velocity[-1], motion.memory[-1])
        if unsettled <= tolerance or count >= most:
            return float(half[count // 4 :].mean()), unsettled, start
        begin, count = end, 2 * count
