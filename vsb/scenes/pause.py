"""How long a take-off that pauses is to pause: the pause that takes most of one sea, found on the exact motion.

Latching holds the port from each reversal of its velocity on, declutching lets it go; when it is released decides what
it takes. In a regular wave the power is that of the settled motion, in an irregular sea the mean over the window of the
study, from the run's own start: what the run will show. Both have several maxima, so pauses up to half a period are
scanned, and the best is refined between its neighbours.

A body-exact scene pauses as long as takes most of its own motion: the pause of the linear scene, found over all pauses
there, is refined in its neighbourhood by trials on the wet shell, each begun where the best of those before ended.

The damper that takes most alone is far too heavy to latch with: it is as large as the reactance that the pause takes
away. Where it is not given, damper and pause are found together.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from vsb.errors import ConvergenceError
from vsb.integrators.settled import Trials, settled_power
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
TRIED = 1e-3
"""Relative error of a power while the pause is looked for; what is found is followed to `SETTLED`."""
KEPT = 0.98
"""Of the power a trial promised: a motion from rest that takes less repeats otherwise, and the search begins anew."""


PAIRED = 8
"""Pauses tried up to half a period with each of several dampers."""
ROUNDS = 4
"""Most times that pause and damper are refined in turn."""
LEVEL = 1e-3
"""Relative gain of power below which another round is not worth it."""


COARSE = 0.02
"""How well the logarithm of the damper is known: power is exact to its square."""


NEAR = 0.1
"""Of the longest pause: how far from the pause of the linear scene one is tried on the wet shell."""
KNOWN_WET = 0.01
"""Of the longest pause: how well the best one there is known."""
SETTLED_WET = 0.02
"""Relative error of a power there."""


Power = Callable[[float, float], float]
"""Damper [kg/s] and pause [s] -> mean power [W]."""


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
    between = float(tried[max(k - 1, 0)]), float(tried[min(k + 1, SCANNED)])
    pause, most = _refined(power, (float(tried[k]), powers[k]), between, within)
    return BestPause(pause, most, within)


def _refined(
    power: Callable[[float], float], at: tuple[float, float], between: tuple[float, float], within: float
) -> tuple[float, float]:
    """Where a power is largest between two bounds, and what it is there: no less than at the point given."""
    found = minimize_scalar(lambda x: -power(float(x)), bounds=between, method="bounded", options={"xatol": within})
    return at if at[1] >= -found.fun else (float(found.x), -float(found.fun))


def best_pair(
    power: Callable[[float, float], float], dampers: Sequence[float], longest: float
) -> tuple[float, BestPause]:
    """Return damper and pause at which a power is largest, no less than at any pair tried.

    Parameters
    ----------
    power : callable
        Damper [kg/s] and pause [s] -> mean power [W].
    dampers : sequence of float
        Tried with `PAIRED` pauses each, ascending; from the best of these pairs both are refined in turn.
    longest : float [s]
    """
    pauses, within = np.linspace(0.0, longest, PAIRED + 1), KNOWN * longest
    most, damper, pause = max((power(c, float(pause)), c, float(pause)) for c in dampers for pause in pauses)
    step, spread = longest / PAIRED, float(np.log(dampers[-1] / dampers[0])) / max(len(dampers) - 1, 1) + LEVEL
    for _ in range(ROUNDS):
        before, here = most, (max(pause - step, 0.0), min(pause + step, longest))
        pause, most = _refined(partial(power, damper), (pause, most), here, within)
        at = float(np.log(damper))
        u, most = _refined(partial(_of_logarithm, power, pause), (at, most), (at - spread, at + spread), COARSE)
        damper, step, spread = float(np.exp(u)), step / 2, spread / 2
        if most <= before * (1 + LEVEL):
            break
    return damper, BestPause(pause, most, within)


def _of_logarithm(power: Callable[[float, float], float], pause: float, u: float) -> float:
    """A power over the logarithm of the damper."""
    return power(float(np.exp(u)), pause)


def with_pause(scene: Scene, pause: float, damping: float | None = None) -> Scene:
    """Return a scene whose take-off pauses so long after each reversal, perhaps with another damper [kg/s]."""
    law = scene.law
    assert law is not None
    damper = law.damping if damping is None else damping
    return replace(scene, forces={**scene.forces, scene.take_off: replace(law, pause=pause, damping=damper)})


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
    assert scene.law is not None
    damper, longest = scene.law.damping, np.pi / strongest(sea)
    return _sought(lambda power: (damper, best_pause(partial(power, damper), longest)), scene, sea, settings)[1]


def best_pair_in_sea(scene: Scene, sea: Sea, settings: Simulation, dampers: Sequence[float]) -> tuple[float, BestPause]:
    """Return damper [kg/s] and pause with which the take-off of a linear scene takes most of a sea.

    Parameters
    ----------
    scene, sea, settings
        See `best_pause_in_sea`.
    dampers : sequence of float
        Tried first, ascending.
    """
    longest = np.pi / strongest(sea)
    return _sought(lambda power: best_pair(power, dampers, longest), scene, sea, settings)


def _sought(
    search: Callable[[Power], tuple[float, BestPause]], scene: Scene, sea: Sea, settings: Simulation
) -> tuple[float, BestPause]:
    """Damper and pause that a search finds by quick trials, with the power of the motion from rest on.

    Where that is less than the trials promised, or than without a pause, the search goes over motions from rest.
    """

    def power_of(follow: Callable[[System], float], damping: float, pause: float) -> float:
        return follow(System.of(with_pause(scene, pause, damping)))

    from_rest = partial(power_of, lambda system: _power(system, sea, settings))
    damper, best = search(partial(power_of, _trials(sea, settings)))
    power = from_rest(damper, best.pause)
    if power < KEPT * best.power or power < from_rest(damper, 0.0):
        return search(from_rest)
    return damper, best._replace(power=power)


def _trials(sea: Sea, settings: Simulation) -> Callable[[System], float]:
    """How the mean power of a system is tried [W]: in a regular wave from where the best trial before ended."""
    if sea.omega.size == 1:
        return Trials(TRIED).power
    quick = settings.model_copy(update={"tolerance": max(settings.tolerance, TRIED)})
    return lambda system: _followed(system, sea, quick)


def refined_pause(scene: Scene, linear: BestPause, sea: Sea, settings: Simulation) -> BestPause:
    """Return the pause near that of the linear scene with which a body-exact scene takes most; no less than with that.

    Parameters
    ----------
    scene : Scene
        Body-exact, its take-off a `TakeOff`.
    linear : BestPause
        What `best_pause_in_sea` or `best_pair_in_sea` found in the linear scene.
    sea : Sea
    settings : Simulation

    Notes
    -----
    Some eight trials: of 8 to 24 periods each in a regular wave, of the run's length in another sea.
    A pause with which the motion cannot be followed takes nothing.
    """
    if not sea.omega.size:
        return linear
    longest, trials = np.pi / strongest(sea), Trials(SETTLED_WET)

    def power(pause: float) -> float:
        system = System.of(with_pause(scene, pause))
        return trials.power(system) if sea.omega.size == 1 else _followed(system, sea, settings)

    between = max(linear.pause - NEAR * longest, 0.0), min(linear.pause + NEAR * longest, longest)
    within = KNOWN_WET * longest
    pause, most = _refined(power, (linear.pause, power(linear.pause)), between, within)
    return BestPause(pause, most, within)


def _followed(system: System, sea: Sea, settings: Simulation) -> float:
    """Mean power in the window of a run [W]; nothing where the motion cannot be followed."""
    try:
        return windowed_power(system, sea, settings)
    except ConvergenceError:
        return 0.0


def strongest(sea: Sea) -> float:
    """Return the frequency of the largest component of a sea [rad/s]."""
    return float(sea.omega[np.argmax(np.abs(sea.amplitude))])


def _power(system: System, sea: Sea, settings: Simulation) -> float:
    """Mean power of a scene in a sea: settled in a regular wave, else that of the run's window."""
    return settled_power(system, SETTLED)[0] if sea.omega.size == 1 else windowed_power(system, sea, settings)


def windowed_power(system: System, sea: Sea, settings: Simulation) -> float:
    """Return the mean power absorbed in the window of a run [W]."""
    (start, end), at_start, at_end = settings.window, 0.0, 0.0
    for leg in legs(system, sea, settings, None):
        time, absorbed = leg.motion.time, leg.energy["pto"]
        at_start = float(np.interp(start, time, absorbed)) if time[0] <= start else at_start
        at_end = float(np.interp(end, time, absorbed)) if time[0] <= end else at_end
    return (at_end - at_start) / (end - start)
