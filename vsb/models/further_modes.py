"""What all further shell modes may change: from numbers with a basis, and with up to about twice as many degrees."""

from collections.abc import Sequence

import numpy as np

from vsb.models.rest import loaded_at_ring
from vsb.study.resolution import bending_degree
from vsb.study.specs import AnyBuoy
from vsb.tools.arrays import FloatArray

SAFETY = 2.0
"""At a ring of the shell errors fall unevenly: over what would be left if they did not [-]."""
RESOLVED = 2.0
"""Degree that resolves what bends about a loaded ring, over that at which bending is as stiff as the membrane [-]."""


def by_all_modes(
    before: FloatArray, finer: Sequence[FloatArray], reach: FloatArray | float = 1.0, least: FloatArray | float = 0.0
) -> FloatArray:
    """Return the range (..., end) about zero of what all modes change: to the last finer number, and as much beyond.

    Parameters
    ----------
    before : ndarray
        Numbers of which the change is asked.
    finer : sequence of ndarray
        The same with ascending degrees, to about twice the first of them.
    reach : ndarray or float
        What degrees beyond the last change at most, in terms of the span of these; 1 where errors fall like 1/degree.
    least : ndarray or float
        What they change at least, whatever the span: it may be small by chance.
    """
    change = finer[-1] - before
    missed = np.maximum(reach * np.ptp(finer, axis=0), least)
    return np.stack([np.minimum(change, 0.0) - missed, np.maximum(change, 0.0) + missed], axis=-1)


def reach_of_modes(study: AnyBuoy, design: str, degree: int) -> float:
    """Return what degrees beyond one may change, in terms of the change from half of it, where modes stand alone [-].

    Errors fall like 1/degree or faster, but where a load acts at a ring of the shell. There each degree yields about as
    much as the one before up to that at which bending is as stiff as the membrane.
    """
    if not loaded_at_ring(study, design):
        return 1.0
    return SAFETY * max(1.0, 2 * RESOLVED * bending_degree(study) / degree - 2)
