"""What holds motions in place: those nothing holds, and the softest of the others."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eigh, null_space

from vsb.tools.arrays import FloatArray

SLIDING = ("Surge", "Sway", "Yaw")
"""Rigid motions that neither water nor shell holds; a mooring may."""
_ROUND_OFF = 1e-13
"""Share of the largest stiffness that is round-off, each coordinate in terms of its own [-]."""


def drifting_motions(stiffness: FloatArray, labels: Sequence[str], motions: FloatArray) -> FloatArray:
    """Return the motions nothing holds, orthonormal in those a design allows, shape (free, loose).

    Parameters
    ----------
    stiffness : ndarray, shape (free, free) [N/m]
        Symmetric, of all that holds the buoy.
    labels : sequence of str
        Degrees of freedom.
    motions : ndarray, shape (dof, free)
        Those a design allows.

    Notes
    -----
    K v = 0, v of surge, sway and yaw: all of them without a mooring, the motion across a mooring of a single line.
    """
    sliding = motions[[label in SLIDING for label in labels]].T
    sliding = sliding[:, sliding.any(axis=0)]
    size = np.sqrt(np.abs(stiffness).max(axis=0, initial=0.0))
    size[size == 0.0] = 1.0
    own = np.abs(sliding).T @ size
    _, values, rows = np.linalg.svd(stiffness @ (sliding / own) / size[:, None])
    left = rows[np.count_nonzero(values > _ROUND_OFF) :].T / own[:, None]
    return np.linalg.qr(sliding @ (left / np.abs(left).max(axis=0, initial=0.0)))[0]


def softest(stiffness: FloatArray, loose: FloatArray) -> tuple[float, FloatArray]:
    """Return the least stiffness of what is held, and its motion, shape (free,); what rests stably has more than 0."""
    held = null_space(loose.T) if loose.size else np.eye(len(stiffness))
    values, shapes = np.linalg.eigh(held.T @ stiffness @ held)
    return float(values[0]), held @ shapes[:, 0]


def normal_modes(stiffness: FloatArray, mass: FloatArray, loose: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return squared frequencies and normal modes V, V^T M V = 1; of what nothing holds exactly zero.

    Parameters
    ----------
    stiffness, mass : ndarray, shape (free, free) [N/m], [kg]
    loose : ndarray, shape (free, loose)
        Of `drifting_motions`: round-off of their stiffness would give them a mean place.
    """
    squares, modes = eigh(stiffness, mass)
    if np.count_nonzero(squares == 0.0) >= loose.shape[1]:  # as of motions that nothing couples: kept as they are
        return squares, modes
    held, unrestrained = null_space(loose.T @ mass), loose @ eigh(loose.T @ mass @ loose)[1]
    unrestrained = unrestrained / np.sqrt(np.einsum("ij,ij->j", unrestrained, mass @ unrestrained))
    squares, shapes = eigh(held.T @ stiffness @ held, held.T @ mass @ held)
    return np.append(np.zeros(unrestrained.shape[1]), squares), np.hstack([unrestrained, held @ shapes])
