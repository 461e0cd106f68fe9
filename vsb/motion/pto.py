"""Power take-off forces."""

from dataclasses import dataclass, replace

import numpy as np

from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray


@dataclass(frozen=True)
class LinearPto:
    """Damper and spring at a port b, f = -b (c b.q' + k b.q); of the heaving sphere centre against the bed, Eq. 91."""

    damping: FloatArray | float  # c [kg/s]; one for each frequency: (omega,)
    stiffness: FloatArray | float = 0.0  # k [N/m]; likewise
    port: FloatArray | None = None  # b (dof,) [-]; none: heave

    def direction(self, dof: int) -> FloatArray:
        """Return b over all degrees of freedom, heave first, shape (dof,) [-]."""
        return np.eye(dof)[0] if self.port is None else self.port

    def matrix(self, dof: int) -> FloatArray:
        """Return its damping over all degrees of freedom, shape ([omega,] dof, dof) [kg/s]."""
        return np.asarray(np.asarray(self.damping)[..., None, None] * self._outer(dof))

    def spring(self, dof: int) -> FloatArray:
        """Return its stiffness over all degrees of freedom, shape ([omega,] dof, dof) [N/m]."""
        return np.asarray(np.asarray(self.stiffness)[..., None, None] * self._outer(dof))

    def relaxed(self, compliance: float) -> tuple["LinearPto", float]:
        """Return the spring beside a damper behind a compliance that does what damper and spring do behind another.

        Parameters
        ----------
        compliance : float
            C of the spring in series with both: a chamber's gas [m/N]; 1 + k C > 0.

        Returns
        -------
        LinearPto
            k/(1 + k C) and c/(1 + k C)^2.
        float
            C (1 + k C), in series with that damper alone.

        Raises
        ------
        ConfigError
            If a negative spring is softer than the compliance: it would run away with the gas.

        Notes
        -----
        The force F moves the port by S = S' + C F and the take-off by S', F = c dS'/dt + k S'. Without S',
        c C F' + (1 + k C) F = c S' + k S: a spring, and what relaxes beside it. Both store and lose the same.
        """
        share = 1 + float(self.stiffness) * compliance
        if share <= 0:
            raise ConfigError(
                f"pto.stiffness: received {self.stiffness:g}, with which the gas before the take-off does not "
                f"rest; needs more than {-1 / compliance:.6g}"
            )
        return replace(self, damping=self.damping / share**2, stiffness=self.stiffness / share), compliance * share

    def behind(self, compliance: float, omega: FloatArray) -> "LinearPto":
        """Return damper and spring, one for each frequency, that do what these do behind a compliance [m/N]."""
        beside, own = self.relaxed(compliance)
        lag = omega * own * beside.damping
        damping = beside.damping / (1 + lag**2)
        return replace(self, damping=damping, stiffness=beside.stiffness + omega * lag * damping)

    def _outer(self, dof: int) -> FloatArray:
        """B b^T."""
        return np.outer(self.direction(dof), self.direction(dof))
