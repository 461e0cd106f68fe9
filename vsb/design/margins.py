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
from vsb.models.further_modes import by_all_modes
from vsb.study.design import OF_RIGID, limit_of
from vsb.study.study import Study
from vsb.tools.arrays import FloatArray

DRAWS = 100_000
"""Buoys drawn for the probability that all limits hold together."""
ROUND_OFF = 1e-8
"""Excess over a limit, relative to it, that is none."""


def by_modes(changes: Sequence[FloatArray]) -> FloatArray:
    """Return the most by which shell modes left out may raise excesses over limits, 0 or more, shape (limit,).

    Parameters
    ----------
    changes : sequence of ndarray
        Of the excesses from a basis to each of some with more degrees, ascending; none, as of a rigid sphere, are none.
    """
    if not changes:
        return np.zeros(())
    none = np.zeros_like(changes[0])
    return np.asarray(by_all_modes(none, [none, *changes])[..., 1])


def depends(study: Study, key: str) -> bool:
    """Return whether a buoy has an input at all: a rigid one that stays a sphere has only its size and mass."""
    return study.flexible or key in OF_RIGID


def spread(
    model: DesignModel, study: Study, damping: float | None, limits: Mapping[str, float], shares: Mapping[str, float]
) -> FloatArray:
    """Return what one standard deviation of each uncertain input changes excesses over limits, shape (part, input).

    The buoy keeps the damper it was designed with; a causal controller is that of the buoy as built.

    Parameters
    ----------
    model : DesignModel
        Whose nodes and frequencies are used, and damper matrix of several ports.
    study : Study
        The buoy.
    damping : float, optional
        Its damper [N s/m]; none under causal control, and at several ports.
    limits, shares : mapping
        Limits, and relative standard deviations of inputs.
    """
    keys = [key for key in shares if depends(study, key)]
    if damping is not None:
        study = study.model_copy(update={"pto": study.pto.model_copy(update={"damping": damping, "tuning": "fixed"})})
    built = replace(model, study=study, variables=tuple(keys) if damping is None else (*keys, DAMPER))
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
