"""Power take-off forces."""

from dataclasses import dataclass

from vsb.units import FloatArray


@dataclass(frozen=True)
class LinearPto:
    """Damper between the heaving sphere centre and the sea bed: f = -c v, Eq. 91."""

    damping: float  # c [kg/s]
    dof: int = 0  # heave

    def power(self, velocity: FloatArray) -> FloatArray:
        """Return the absorbed power -f v = c v^2 (C7), shape (time,) [W], of velocities (time, dof)."""
        return self.damping * velocity[:, self.dof] ** 2
