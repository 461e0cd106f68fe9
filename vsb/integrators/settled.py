"""Mean power of a take-off that switches in a regular wave, once its motion repeats."""

import numpy as np

from vsb.integrators.regular_wave import regular_frequency
from vsb.integrators.switching import Switching
from vsb.motion.system import System
from vsb.tools.units import FloatArray

RECORDED = 16
"""Instants of a period; the lookout is finer where it must be."""
FEWEST, MOST = 16, 64
"""Periods followed at a time: twice as many when these were not enough."""


def settled_power(system: System, tolerance: float = 1e-6) -> tuple[float, float]:
    """Return the mean absorbed power of a scene in a regular wave from rest on [W], and by how much it is unsettled.

    Parameters
    ----------
    system : System
        Linear but for a take-off that switches.
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
    """
    period, runner = 2 * np.pi / regular_frequency(system), Switching(system)
    start: tuple[FloatArray, ...] = system.scene.start(0.0, 0.0)
    begin, count = 0.0, FEWEST
    while True:
        end = begin + count * period
        motion, _ = runner.follow(np.linspace(begin, end, count * RECORDED + 1), start)
        half = (np.diff(motion.works["pto"][::RECORDED]) / period)[count // 2 :]
        unsettled = float(np.ptp(half) / max(np.abs(half).max(), np.finfo(float).tiny))
        if unsettled <= tolerance or count >= MOST:
            return float(half[count // 4 :].mean()), unsettled
        start, begin, count = (motion.position[-1], motion.velocity[-1], motion.memory[-1]), end, 2 * count
