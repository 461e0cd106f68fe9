"""Power take-off forces."""

from dataclasses import dataclass

import numpy as np

from vsb.tools.units import FloatArray


@dataclass(frozen=True)
class LinearPto:
    """Damper and spring at a port b, f = -b (c b.q' + k b.q); of the heaving sphere centre against the bed, Eq. 91."""

    damping: FloatArray | float  # c [kg/s]; one for each frequency: (omega,)
    stiffness: float = 0.0  # k [N/m]
    port: FloatArray | None = None  # b (dof,) [-]; none: heave

    def direction(self, dof: int) -> FloatArray:
        """Return b over all degrees of freedom, heave first, shape (dof,) [-]."""
        return np.eye(dof)[0] if self.port is None else self.port

    def matrix(self, dof: int) -> FloatArray:
        """Return its damping over all degrees of freedom, shape ([omega,] dof, dof) [kg/s]."""
        return np.asarray(np.asarray(self.damping)[..., None, None] * self._outer(dof))

    def spring(self, dof: int) -> FloatArray:
        """Return its stiffness over all degrees of freedom, shape (dof, dof) [N/m]."""
        return self.stiffness * self._outer(dof)

    def _outer(self, dof: int) -> FloatArray:
        """B b^T."""
        return np.outer(self.direction(dof), self.direction(dof))
