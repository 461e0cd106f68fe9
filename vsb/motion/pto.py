"""Power take-off forces."""

from dataclasses import dataclass

import numpy as np

from vsb.tools.units import FloatArray


@dataclass(frozen=True)
class LinearPto:
    """Damper between the heaving sphere centre and the sea bed: f = -c v, Eq. 91."""

    damping: float  # c [kg/s]

    def matrix(self, dof: int) -> FloatArray:
        """Return its damping over all degrees of freedom, heave first, shape (dof, dof) [kg/s]."""
        matrix = np.zeros((dof, dof))
        matrix[0, 0] = self.damping
        return matrix
