"""Rigid motions among displacements of points."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vsb.tools.arrays import FloatArray

RIGID_TO = 1e-6
"""Distance of a displacement from a rigid one, relative to the largest: what single precision leaves of it."""
_ROUND_OFF = 1e-9  # of the largest displacement: what a fit leaves of translations and rotations that are not there


class Rigid(NamedTuple):
    """A rigid motion t + a x r."""

    translation: FloatArray  # t (xyz)
    rotation: FloatArray  # a (xyz)


def rigid_motion(points: FloatArray, moved: FloatArray, size: float = 0.0) -> Rigid | None:
    """Return translation and rotation of a displacement of points, each shape (point, xyz), if it is rigid.

    To round-off of single precision, relative to the largest displacement or, of a part that hardly moves, to `size`.
    """
    size = max(size, float(np.abs(moved).max(initial=0.0)))
    motion = fitted_motion(points, moved, size)
    return motion if np.abs(displaced(motion, points) - moved).max(initial=0.0) < RIGID_TO * size else None


def fitted_motion(points: FloatArray, moved: FloatArray, size: float) -> Rigid:
    """Return the rigid motion nearest to a displacement; what moves no point by `_ROUND_OFF` of `size` is none."""
    columns = [np.tile(e, (len(points), 1)) for e in np.eye(3)] + [np.cross(e, points) for e in np.eye(3)]
    basis = np.array(columns).reshape(6, -1).T
    motion = np.asarray(np.linalg.lstsq(basis, moved.ravel(), rcond=None)[0])
    motion = np.where(np.abs(basis * motion).max(axis=0) > _ROUND_OFF * size, motion, 0.0)
    return Rigid(motion[:3], motion[3:])


def displaced(motion: Rigid, points: FloatArray) -> FloatArray:
    """Return the displacements t + a x r of points, shape (..., xyz)."""
    return np.asarray(motion.translation + np.cross(motion.rotation, points))


def rotation_centre(motions: Sequence[Rigid]) -> FloatArray | None:
    """Return a point that rotations leave at rest, (xyz,), nearest to the origin; None if there is none, or no motion.

    Where t + a x p = 0.
    """
    if not motions:
        return None
    crosses = np.concatenate([np.cross(np.eye(3), a).T for _, a in motions])  # rows of p -> p x a
    moved = np.concatenate([t for t, _ in motions])
    point = np.asarray(np.linalg.lstsq(crosses, moved)[0])
    size = RIGID_TO * (1.0 + np.abs(moved).max())
    return point if np.abs(crosses @ point - moved).max() < size else None
