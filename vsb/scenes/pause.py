"""How long a take-off that pauses is to pause: the pause that takes most of one sea, found on the exact motion.

Latching holds the port from each reversal of its velocity on, declutching lets it go; when it is released decides what
it takes. In a regular wave the power is that of the settled motion, in an irregular sea the mean over the window of the
study, from the run's own start: what the run will show. Both have several maxima, so pauses up to half a period are
scanned, and the best is refined between its neighbours.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from vsb.integrators.settled import settled_power
from vsb.integrators.simulate import legs
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.study.study import Simulation
from vsb.waves.seas import Sea

SCANNED = 16
"""Pauses tried up to half a period; a maximum narrower than twice their distance may be missed."""
KNOWN = 1e-3
"""Of the longest pause: how well the best one is known."""
SETTLED = 1e-4
"""Relative error of the power in a regular wave."""


class BestPause(NamedTuple):
    """The best pause of a take-off in a sea."""

    pause: float  # [s]; 0: better without
    power: float  # mean [W]
    within: float  # the pause is known to [s]


def best_pause(power: Callable[[float], float], longest: float) -> BestPause:
    """Return the pause from 0 to the longest at which a power is largest, no less than at any pause tried.

    Parameters
    ----------
    power : callable
        Pause [s] -> mean power [W].
    longest : float [s]
    """
    tried = np.linspace(0.0, longest, SCANNED + 1)
    powers = [power(float(pause)) for pause in tried]
    k, within = int(np.argmax(powers)), KNOWN * longest
    between = tried[max(k - 1, 0)], tried[min(k + 1, SCANNED)]
    found = minimize_scalar(lambda pause: -power(pause), bounds=between, method="bounded", options={"xatol": within})
    best = (powers[k], float(tried[k])) if powers[k] >= -found.fun else (-float(found.fun), float(found.x))
    return BestPause(best[1], float(best[0]), within)


def with_pause(scene: Scene, pause: float) -> Scene:
    """Return a scene whose take-off pauses so long after each reversal."""
    law = scene.law
    assert law is not None
    return replace(scene, forces={**scene.forces, scene.take_off: replace(law, pause=pause)})


def best_pause_in_sea(scene: Scene, sea: Sea, settings: Simulation) -> BestPause:
    """Return the pause with which the take-off of a linear scene takes most of a sea; none in still water.

    Parameters
    ----------
    scene : Scene
        Its take-off is a `TakeOff`.
    sea : Sea
    settings : Simulation
    """
    if not sea.omega.size:
        return BestPause(0.0, 0.0, 0.0)

    def power(pause: float) -> float:
        system = System.of(with_pause(scene, pause))
        return settled_power(system, SETTLED)[0] if sea.omega.size == 1 else windowed_power(system, sea, settings)

    strongest = float(sea.omega[np.argmax(np.abs(sea.amplitude))])
    return best_pause(power, np.pi / strongest)


def windowed_power(system: System, sea: Sea, settings: Simulation) -> float:
    """Return the mean power absorbed in the window of a run [W]."""
    (start, end), at_start, at_end = settings.window, 0.0, 0.0
    for leg in legs(system, sea, settings, None):
        time, absorbed = leg.motion.time, leg.energy["pto"]
        at_start = float(np.interp(start, time, absorbed)) if time[0] <= start else at_start
        at_end = float(np.interp(end, time, absorbed)) if time[0] <= end else at_end
    return (at_end - at_start) / (end - start)
