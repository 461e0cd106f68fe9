"""Latching and declutching: how long a take-off holds or frees the port for the largest mean power in a sea.

From each reversal of the velocity on latching holds the port and declutching frees it; the latching time is when that
ends. In a regular wave the power is that of the steady motion, in an irregular sea the mean over the window of the
study, from the run's own start: what the run will show. Both have several maxima, so latching times up to half a period
are scanned, and the best is refined between its neighbours.

In a body-exact scene the latching time of the linear scene is refined in its neighbourhood by body-exact trials, each
begun where the best of those before ended.

The damper that is optimal without latching is far too heavy to latch with: it is as large as the reactance that
latching takes away. Where it is not given, damper and latching time are found together.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import legs
from vsb.engine.integrators.switching import Trials, periodic_power
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.engine.waves.seas import Sea
from vsb.errors import ConvergenceError

SCANNED, PAIRED = 16, 8
"""Latching times tried up to half a period, alone and with each of several dampers.

A maximum narrower than twice their distance may be missed.
"""
KNOWN, KNOWN_BODY_EXACT = 1e-3, 0.01
"""How well the best latching time is known in the linear and the body-exact scene, over the longest one."""
NEAR = 0.1
"""How far from the latching time of the linear scene body-exact ones are tried, over the longest one."""
STEADY, TRIED, TRIED_BODY_EXACT = 1e-4, 1e-3, 0.02
"""Relative error of the power in a regular wave: of the result, of linear trials and of body-exact ones."""
KEPT = 0.98
"""Part of the power of the trials that the motion from rest must reach, or the search is repeated from rest."""
ROUNDS = 4
"""Most times that latching time and damper are refined in turn."""
LEVEL = 1e-3
"""Relative gain of power below which another round is not worth it."""
COARSE = 0.02
"""How well the logarithm of the damper is known: the error of the power is of second order in it."""

Power = Callable[[float, float], float]
"""Damper [N s/m] and latching time [s] -> mean power [W]."""


class LatchingTime(NamedTuple):
    """The best latching time of a take-off in a sea."""

    time: float  # [s]; 0: better without
    power: float  # mean [W]
    within: float  # the time is known to [s]


def best_latching_time(power: Callable[[float], float], longest: float) -> LatchingTime:
    """Return the latching time from 0 to the longest at which a power is largest, no less than at any time tried.

    Parameters
    ----------
    power : callable
        Latching time [s] -> mean power [W].
    longest : float [s]
    """
    tried = np.linspace(0.0, longest, SCANNED + 1)
    powers = [power(float(time)) for time in tried]
    k, within = int(np.argmax(powers)), KNOWN * longest
    between = float(tried[max(k - 1, 0)]), float(tried[min(k + 1, SCANNED)])
    time, most = _refined(power, (float(tried[k]), powers[k]), between, within)
    return LatchingTime(time, most, within)


def _refined(
    power: Callable[[float], float], at: tuple[float, float], between: tuple[float, float], within: float
) -> tuple[float, float]:
    """Where a power is largest between two bounds, and what it is there: no less than at the point given."""
    found = minimize_scalar(lambda x: -power(float(x)), bounds=between, method="bounded", options={"xatol": within})
    return at if at[1] >= -found.fun else (float(found.x), -float(found.fun))


def best_damper_and_time(power: Power, dampers: Sequence[float], longest: float) -> tuple[float, LatchingTime]:
    """Return damper and latching time at which a power is largest, no less than at any pair tried.

    Parameters
    ----------
    power : callable
        Damper [N s/m] and latching time [s] -> mean power [W].
    dampers : sequence of float
        Tried with `PAIRED` times each, ascending; from the best of these pairs both are refined in turn.
    longest : float [s]
    """
    times, within = np.linspace(0.0, longest, PAIRED + 1), KNOWN * longest
    most, damper, time = max((power(c, float(time)), c, float(time)) for c in dampers for time in times)
    step, spread = longest / PAIRED, float(np.log(dampers[-1] / dampers[0])) / max(len(dampers) - 1, 1) + LEVEL
    for _ in range(ROUNDS):
        before, here = most, (max(time - step, 0.0), min(time + step, longest))
        time, most = _refined(partial(power, damper), (time, most), here, within)
        at, held = float(np.log(damper)), time

        def of_logarithm(u: float, held: float = held) -> float:
            return power(float(np.exp(u)), held)

        u, most = _refined(of_logarithm, (at, most), (at - spread, at + spread), COARSE)
        damper, step, spread = float(np.exp(u)), step / 2, spread / 2
        if most <= before * (1 + LEVEL):
            break
    return damper, LatchingTime(time, most, within)


def with_latching_time(scene: Scene, time: float, damping: float | None = None) -> Scene:
    """Return a scene whose take-off latches for so long [s], perhaps with another damper [N s/m]."""
    law = scene.law
    assert law is not None
    damper = law.damping if damping is None else damping
    return replace(scene, forces={**scene.forces, scene.take_off: replace(law, latching_time=time, damping=damper)})


def linear_latching_time(scene: Scene, sea: Sea, settings: Simulation) -> LatchingTime:
    """Return the latching time at which the take-off of a linear scene absorbs most in a sea; 0 in still water.

    Parameters
    ----------
    scene : Scene
        Its take-off is a `TakeOff`.
    """
    if not sea.omega.size:
        return LatchingTime(0.0, 0.0, 0.0)
    assert scene.law is not None
    damper, longest = scene.law.damping, longest_time(sea)

    def search(power: Power) -> tuple[float, LatchingTime]:
        return damper, best_latching_time(partial(power, damper), longest)

    return _searched(search, scene, sea, settings)[1]


def linear_damper_and_time(
    scene: Scene, sea: Sea, settings: Simulation, dampers: Sequence[float]
) -> tuple[float, LatchingTime]:
    """Return damper [N s/m] and latching time at which the take-off of a linear scene absorbs most in a sea.

    Parameters
    ----------
    scene, sea, settings
        See `linear_latching_time`.
    dampers : sequence of float
        Tried first, ascending.
    """
    return _searched(lambda power: best_damper_and_time(power, dampers, longest_time(sea)), scene, sea, settings)


def _searched(
    search: Callable[[Power], tuple[float, LatchingTime]], scene: Scene, sea: Sea, settings: Simulation
) -> tuple[float, LatchingTime]:
    """Damper and latching time that a search finds by quick trials, with the power of the motion from rest.

    Where that is less than the trials promised, or than without latching, the search is repeated from rest.
    """
    coarse = settings.model_copy(update={"tolerance": max(settings.tolerance, TRIED)})
    regular, trials = sea.omega.size == 1, Trials(TRIED)

    def quick(system: System) -> float:
        return trials.power(system) if regular else _followed(system, sea, coarse)

    def steady(system: System) -> float:
        return periodic_power(system, STEADY)[0] if regular else windowed_power(system, sea, settings)

    def power_of(follow: Callable[[System], float], damping: float, time: float) -> float:
        return follow(System.of(with_latching_time(scene, time, damping)))

    from_rest = partial(power_of, steady)
    damper, best = search(partial(power_of, quick))
    power = from_rest(damper, best.time)
    if power < KEPT * best.power or power < from_rest(damper, 0.0):
        return search(from_rest)
    return damper, best._replace(power=power)


def body_exact_latching_time(scene: Scene, linear: LatchingTime, sea: Sea, settings: Simulation) -> LatchingTime:
    """Return the best latching time of a body-exact scene near that of the linear one, at least as good as that.

    Parameters
    ----------
    scene : Scene
        Body-exact, its take-off a `TakeOff`.
    linear : LatchingTime
        Of the linear scene.

    Notes
    -----
    Some eight trials: of 8 to 24 periods each in a regular wave, of the run's length in another sea. A motion that
    cannot be followed counts as no power.
    """
    if not sea.omega.size:
        return linear
    longest, trials = longest_time(sea), Trials(TRIED_BODY_EXACT)

    def power(time: float) -> float:
        system = System.of(with_latching_time(scene, time))
        return trials.power(system) if sea.omega.size == 1 else _followed(system, sea, settings)

    between = max(linear.time - NEAR * longest, 0.0), min(linear.time + NEAR * longest, longest)
    within = KNOWN_BODY_EXACT * longest
    time, most = _refined(power, (linear.time, power(linear.time)), between, within)
    return LatchingTime(time, most, within)


def strongest(sea: Sea) -> float:
    """Return the frequency of the largest component of a sea [rad/s]."""
    return float(sea.omega[np.argmax(np.abs(sea.amplitude))])


def longest_time(sea: Sea) -> float:
    """Return the longest latching time that is tried in a sea, half the period of its largest component [s]."""
    return float(np.pi / strongest(sea))


def _followed(system: System, sea: Sea, settings: Simulation) -> float:
    """Mean power in the window of a run [W]; zero where the motion cannot be followed."""
    try:
        return windowed_power(system, sea, settings)
    except ConvergenceError:
        return 0.0


def windowed_power(system: System, sea: Sea, settings: Simulation) -> float:
    """Return the mean power absorbed in the window of a run [W]."""
    (start, end), at_start, at_end = settings.window, 0.0, 0.0
    for leg in legs(system, sea, settings, None):
        time, absorbed = leg.motion.time, leg.energy["pto"]
        at_start = float(np.interp(start, time, absorbed)) if time[0] <= start else at_start
        at_end = float(np.interp(end, time, absorbed)) if time[0] <= end else at_end
    return (at_end - at_start) / (end - start)
