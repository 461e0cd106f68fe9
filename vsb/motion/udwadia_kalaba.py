"""Clamps by the paper's second route: Udwadia and Kalaba's constrained acceleration, Eq. 90, on all coordinates.

The default route, `ModeBasis.clamped`, moves in the null space of the constraint: no multipliers, no drift. This one
keeps every coordinate and corrects the acceleration. Both are the same motion to round-off.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import eigh, svd

from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.shell.modes import check_rank
from vsb.tools.arrays import FloatArray


def projector(mass: FloatArray, rows: FloatArray) -> FloatArray:
    """Return P of q'' = P M^-1 Q, the accelerations that the constraint Phi q = 0 allows, shape (dof, dof) [-].

    P P = P, Phi P = 0. Raises `ConfigError` if the rank of the rows cannot be decided.

    Parameters
    ----------
    mass : ndarray, shape (dof, dof) [kg]
        M, with the added mass at infinite frequency; positive definite.
    rows : ndarray, shape (constraint, dof) [-]
        Phi, from `ModeBasis.clamp_rows`; repeated and zero rows are harmless.

    Notes
    -----
    Eq. 90 prints Q_c = M^1/2 (A M^-1/2)^+ (b - A M^-1 (Q - a)), with b = 0 for clamps on a shell whose shapes do not
    change; divided by M it is -J Phi of M^-1 Q, J = M^-1/2 (Phi M^-1/2)^+, P = 1 - J Phi. The pseudo-inverse is cut at
    the rank of Phi, not of Phi M^-1/2: the two are equal, and that of Phi does not depend on the mass.
    """
    rank = check_rank(rows)
    values, vectors = eigh(mass)
    root = (vectors / np.sqrt(values)) @ vectors.T  # M^-1/2
    left, singular, right = svd(rows @ root, full_matrices=False)
    inverse = (right[:rank].T / singular[:rank]) @ left[:, :rank].T
    return np.asarray(np.eye(len(mass)) - root @ inverse @ rows)


def constrained(scene: Scene, rows: FloatArray) -> System:
    """Return a scene with all coordinates free but for the rows, Phi q = 0, enforced by Eq. 90.

    Raises `ValueError` if the scene is not linear: what is not would push at the clamps.

    Parameters
    ----------
    scene : Scene
        Its own motions are replaced by all of them.
    rows : ndarray, shape (constraint, dof) [-]
        Phi, from `ModeBasis.clamp_rows`.

    Notes
    -----
    In the natural modes p of the scene without clamps M = 1, so Eq. 90 is p'' = P a with a = M^-1 Q from the free
    system and P = 1 - (Phi V)^+ (Phi V) of the modes V: no mass matrix is inverted and no stiffness loses digits.
    """
    check_rank(rows)
    every, heave = np.eye(len(scene.labels)), scene.motions @ scene.heaving
    free = System.of(replace(scene, motions=every, origin=np.zeros(0), heave=heave))
    if not free.linear:
        names = ", ".join(name for name, part in scene.linear.items() if not part.fully_linear)
        raise ValueError(f"Eq. 90: received the nonlinear forces {names}, needs a linear scene; clamp its motions.")
    n = free.free
    allowed, matrix, rates = projector(np.eye(n), rows @ free.shapes), free.matrix.copy(), slice(n, 2 * n)
    matrix[rates] = allowed @ matrix[rates]
    return replace(free, matrix=matrix, waves=free.waves @ allowed.T)


def constraint_drift(positions: FloatArray, rows: FloatArray) -> float:
    """Return the largest displacement of a clamped point, max |Phi q| over time and rows [m]; exact motion has none.

    Parameters
    ----------
    positions : ndarray, shape (time, dof) [m]
        Heave and all modal amplitudes.
    rows : ndarray, shape (constraint, dof) [-]
    """
    return float(np.abs(positions @ rows.T).max(initial=0.0))
