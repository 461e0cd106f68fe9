"""Margins of limits: what shell modes left out, and inputs that are uncertain, may change a limited quantity by.

An optimiser goes to the limits. Where shell modes beyond those of its basis, or a wall as it is built, strain the shell
more, a buoy that meets a limit exactly exceeds it. With g the excess over a limit, relative to it, a buoy holds if
g + m <= 0 with m = m_modes + k sigma: m_modes the most that further shell modes add (`by_modes`), sigma the standard
deviation of g by the uncertain inputs, sigma^2 = sum (dg/d ln p s)^2 to first order (`spread`), k how many of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from vsb.design.evaluation import DAMPER, DesignModel
from vsb.design.problem import excesses
from vsb.engine.shell.shell import Shell
from vsb.models.rest import loaded_at_ring
from vsb.study.design import OF_RIGID, limit_of
from vsb.study.specs import AnyBuoy
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

DRAWS = 100_000
"""Buoys drawn for the probability that all limits hold together."""
ROUND_OFF = 1e-8
"""Excess over a limit, relative to it, that is none."""
SAFETY = 2.0
"""Of the last steps of the list, for what all further degrees may change where powers do not approach a limit yet."""
RESOLVED = 2.0
"""Degree that resolves what bends about a loaded ring, in terms of `bending_degree`."""


def beyond(changes: Sequence[FloatArray], degrees: Sequence[int] = (), bending: float | None = None) -> FloatArray:
    """Return the most that shell modes beyond the last degree may change numbers, as in studies.

    Parameters
    ----------
    changes : sequence of ndarray
        Of the numbers from a basis to each of the degrees beyond it, ascending.
    degrees : sequence of int
        Of the basis and those; needed with `bending` only.
    bending : float, optional
        See `bending_degree`.
    """
    numbers = [np.zeros_like(changes[0]), *changes]
    return further(numbers) if bending is None else further_about_rings(numbers, degrees, bending)


def further(powers: Sequence[FloatArray]) -> FloatArray:
    """Return what degrees beyond the last may change, shape of the powers [W]: the span of the last three powers.

    That holds of errors that fall like 1/degree or faster, because two steps of `DEGREES` double the degree. One step
    would not do: before bending is resolved it may be small by chance. Steps of opposite signs have a small span, and
    count at least `SAFETY` times the last; where the last step is larger than the one before, errors do not fall yet:
    `SAFETY` times both.

    Parameters
    ----------
    powers : sequence of ndarray [W]
        With two or more ascending degrees of `DEGREES`.
    """
    step = np.abs(powers[-1] - powers[-2])
    if len(powers) == 2:
        return SAFETY * step
    previous = np.abs(powers[-2] - powers[-3])
    falling = np.maximum(np.ptp(powers[-3:], axis=0), SAFETY * step)
    return np.where(step > previous, SAFETY * (step + previous), falling)


def further_about_rings(powers: Sequence[FloatArray], degrees: Sequence[int], bending: float) -> FloatArray:
    """Return what degrees beyond the last may change where a load acts at a ring of the shell, shape of the powers [W].

    Below `bending_degree` each degree yields about as much to such a load as the one before, more or less with its
    amplitude at the ring: the steepest change per degree seen counts up to `RESOLVED` times that degree. Beyond it
    errors fall like 1/degree, unevenly. `SAFETY` times the larger of that and of both last steps.

    Parameters
    ----------
    powers : sequence of ndarray [W]
        With two or more ascending degrees of `DEGREES`.
    degrees : sequence of int
    bending : float
        See `bending_degree`.
    """
    steps, widths = np.abs(np.diff(powers[-3:], axis=0)), np.diff(degrees[-3:])
    per_degree = (steps.T / widths).T.max(axis=0)
    missing = max(RESOLVED * bending - degrees[-1], 0.0)
    return np.asarray(SAFETY * np.maximum(steps.sum(axis=0), missing * per_degree))


def bending_degree(study: AnyBuoy, design: str) -> float | None:
    """Return the degree at which the shell is as stiff by bending as by its membrane; None if no load acts at a ring.

    D n^4/r^4 = E h/r^2 with D = E h^3/(12 (1 - nu^2)), r the largest radius or half the height. See `loaded_at_ring`.
    """
    if not loaded_at_ring(study, design):
        return None
    shell = Shell.of(study.device)
    return float((12 * (1 - shell.poisson_ratio**2)) ** 0.25 * np.sqrt(shell.reach / shell.thickness))


def by_modes(changes: Sequence[FloatArray], degrees: Sequence[int] = (), bending: float | None = None) -> FloatArray:
    """Return the most by which shell modes left out may raise excesses over limits, 0 or more, shape (limit,).

    Parameters are those of `beyond`; no changes, as of a rigid sphere, are none.
    """
    if not changes:
        return np.zeros(())
    return np.asarray(np.maximum(0.0, np.max(changes, axis=0) + beyond(changes, degrees, bending)))


def depends(study: Study, key: str) -> bool:
    """Return whether a buoy has an input at all: a rigid one that stays a sphere has only its size and mass."""
    return study.flexible or key in OF_RIGID


def spread(
    model: DesignModel, study: Study, damping: float, limits: Mapping[str, float], shares: Mapping[str, float]
) -> FloatArray:
    """Return what one standard deviation of each uncertain input changes excesses over limits, shape (part, input).

    The buoy keeps the damper it was designed with.

    Parameters
    ----------
    model : DesignModel
        Whose nodes and frequencies are used.
    study : Study
        The buoy.
    damping : float
        Its damper [N s/m].
    limits, shares : mapping
        Limits, and relative standard deviations of inputs.
    """
    keys = [key for key in shares if depends(study, key)]
    pto = study.pto.model_copy(update={"damping": damping, "tuning": "fixed"})
    built = replace(model, study=study.model_copy(update={"pto": pto}), variables=(*keys, DAMPER))
    terms = excesses(built.at(built.point), limits)
    sizes = np.array([shares[key] * value for key, value in zip(keys, built.point, strict=False)])
    return np.array([one.gradient[: len(keys)] * sizes for one in terms]).reshape(len(terms), len(keys))


def probabilities(excess: FloatArray, scatter: FloatArray, parts: Sequence[str], seed: int = 1) -> dict[str, float]:
    """Return the probability that each limit holds of a buoy as it is built, and that all hold, under `all`.

    Inputs are normal and independent, excesses linear in them.

    Parameters
    ----------
    excess : ndarray, shape (part,)
        Of the buoy as designed, with what shell modes left out add.
    scatter : ndarray, shape (part, input)
        Of `spread`.
    parts : sequence of str
        Names of the parts.
    """
    drawn = np.random.default_rng(seed).standard_normal((DRAWS, scatter.shape[1]))
    holds = excess + drawn @ scatter.T <= ROUND_OFF
    limits = [limit_of(part) for part in parts]
    found = {
        limit: float(holds[:, [one == limit for one in limits]].all(axis=1).mean()) for limit in dict.fromkeys(limits)
    }
    return {**found, "all": float(holds.all(axis=1).mean())}


Spread = Callable[[FloatArray], FloatArray]
"""Values of the variables -> `spread` at them, (part, input)."""
