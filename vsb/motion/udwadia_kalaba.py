"""Clamps by the paper's second route: Udwadia and Kalaba's constrained acceleration, Eq. 90, on all coordinates.

The default route, `ModeBasis.clamped`, moves in the null space of the constraint: no multipliers, no drift. This one
keeps every coordinate and corrects the acceleration. Both are the same motion to round-off; the clamps' forces and the
drift of this route are what it adds.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import eigh, svd

from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.shell.modes import check_rank
from vsb.tools.arrays import FloatArray


@dataclass(frozen=True)
class Constraint:
    """Phi q = 0 on coordinates of mass M, enforced through the acceleration; made by `udwadia_kalaba`."""

    mass: FloatArray  # M (dof, dof) [kg]
    rows: FloatArray  # Phi (constraint, dof) [-]
    correction: FloatArray  # J = M^-1/2 (Phi M^-1/2)^+ (dof, constraint) [-]

    @cached_property
    def projector(self) -> FloatArray:
        """P = 1 - J Phi: accelerations the constraint allows, shape (dof, dof) [-]; P P = P, Phi P = 0."""
        return np.eye(len(self.mass)) - self.correction @ self.rows

    def acceleration(self, force: FloatArray, wanted: FloatArray | float = 0.0) -> FloatArray:
        """Return q'' = a + J (b - Phi a), a = M^-1 Q, shape (..., dof) [m/s^2].

        Parameters
        ----------
        force : ndarray, shape (..., dof) [N]
            Q, all forces but the constraint's.
        wanted : ndarray, shape (..., constraint) [m/s^2]
            b = Phi q'', zero for clamps on a shell whose shapes do not change.
        """
        free = np.linalg.solve(self.mass, force[..., None])[..., 0]
        return np.asarray(free + (wanted - free @ self.rows.T) @ self.correction.T)

    def force(self, force: FloatArray, wanted: FloatArray | float = 0.0) -> FloatArray:
        """Return Eq. 90, Q_c = M^1/2 (Phi M^-1/2)^+ (b - Phi M^-1 Q) = M J (b - Phi a), shape (..., dof) [N]."""
        free = np.linalg.solve(self.mass, force[..., None])[..., 0]
        return np.asarray((wanted - free @ self.rows.T) @ (self.mass @ self.correction).T)


def udwadia_kalaba(mass: FloatArray, rows: FloatArray) -> Constraint:
    """Return the constraint Phi q = 0 in Udwadia and Kalaba's form.

    Raises `ConfigError` if the rank of the rows cannot be decided.

    Parameters
    ----------
    mass : ndarray, shape (dof, dof) [kg]
        M, with the added mass at infinite frequency; positive definite.
    rows : ndarray, shape (constraint, dof) [-]
        Phi, from `ModeBasis.clamp_rows`; repeated and zero rows are harmless.

    Notes
    -----
    Eq. 90 prints Q_c = M^1/2 (A M^-1/2)^+ (b - A M^-1 (Q - a)); divided by M it is the J below. The pseudo-inverse is
    cut at the rank of Phi, not of Phi M^-1/2: the two are equal, and that of Phi does not depend on the mass.
    """
    rank = check_rank(rows)
    values, vectors = eigh(mass)
    root = (vectors / np.sqrt(values)) @ vectors.T  # M^-1/2
    left, singular, right = svd(rows @ root, full_matrices=False)
    inverse = (right[:rank].T / singular[:rank]) @ left[:, :rank].T
    return Constraint(mass, rows, root @ inverse)


def constrained(scene: Scene, rows: FloatArray, rate: float = 0.0) -> System:
    """Return a scene with all coordinates free but for the rows, Phi q = 0, enforced by Eq. 90.

    Raises `ValueError` if the scene is not linear: what is not would push at the clamps.

    Parameters
    ----------
    scene : Scene
        Its own motions are replaced by all of them.
    rows : ndarray, shape (constraint, dof) [-]
        Phi, from `ModeBasis.clamp_rows`.
    rate : float
        Rate gamma of Baumgarte's stabilisation [1/s]; 0 is the paper's b = 0.

    Notes
    -----
    In the natural modes p of the scene without clamps M = 1, so Eq. 90 is p'' = P a - (1 - P)(2 gamma p' + gamma^2 p)
    with a = M^-1 Q from the free system and P = 1 - (Phi V)^+ (Phi V) of the modes V: no mass matrix is inverted and no
    stiffness loses digits.
    """
    check_rank(rows)
    every, heave = np.eye(len(scene.labels)), scene.motions @ scene.heaving
    free = System.of(replace(scene, motions=every, origin=np.zeros(0), heave=heave))
    if not free.linear:
        names = ", ".join(name for name, part in scene.linear.items() if not part.fully_linear)
        raise ValueError(f"Eq. 90: received the nonlinear forces {names}, needs a linear scene; clamp its motions.")
    n = free.free
    constraint = udwadia_kalaba(np.eye(n), rows @ free.shapes)
    matrix = free.matrix.copy()
    rates, held = slice(n, 2 * n), np.eye(n) - constraint.projector
    matrix[rates] = constraint.projector @ matrix[rates]
    matrix[rates, rates] -= 2 * rate * held
    matrix[rates, :n] -= rate**2 * held / free.scale
    return replace(free, matrix=matrix, waves=free.waves @ constraint.projector.T)


def constraint_drift(positions: FloatArray, rows: FloatArray) -> float:
    """Return the largest displacement of a clamped point, max |Phi q| over time and rows [m]; exact motion has none.

    Parameters
    ----------
    positions : ndarray, shape (time, dof) [m]
        Heave and all modal amplitudes.
    rows : ndarray, shape (constraint, dof) [-]
    """
    return float(np.abs(positions @ rows.T).max(initial=0.0))
