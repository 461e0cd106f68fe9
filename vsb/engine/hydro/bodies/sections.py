"""Motion of sections across an axis of a body, which turn without deforming."""

from typing import NamedTuple, Protocol

import numpy as np

from vsb.tools.arrays import FloatArray


class Sections(NamedTuple):
    """Motion of the sections that points (..., xyz) lie in: psi = shift + turn x rho."""

    shift: FloatArray  # T (..., xyz) [-]
    turn: FloatArray  # omega (..., xyz) [1/m]
    stretch: FloatArray  # dT/ds (..., xyz) [1/m]
    bend: FloatArray  # d omega/ds (..., xyz) [1/m^2]

    def displacement(self, rho: FloatArray) -> FloatArray:
        """Return psi at places across the axis, shape (..., xyz)."""
        return np.asarray(self.shift + np.cross(self.turn, rho))

    def strain(self, rho: FloatArray, axis: int) -> FloatArray:
        """Return the strain along the axis at places across it, shape (...) [1/m]."""
        return np.asarray((self.stretch + np.cross(self.bend, rho))[..., axis])


class TurningField(Protocol):
    """A displacement of one part of a body whose sections or pieces rotate."""

    def sections(self, points: FloatArray, axis: int) -> Sections:
        """Return the motion at points of each of the part's triangles, shape (triangle, n, xyz)."""


class Beam(NamedTuple):
    """A displacement known to be that of a beam: its axis, 0 or 1, and the motion of its sections."""

    axis: int
    field: TurningField
