"""Forces of a shell of rubber along a motion: elastic and of the pressure inside, exact however far it is stretched."""

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from vsb.engine.motion.forces import Force, Linear
from vsb.engine.shell.loaded import LoadedShell
from vsb.tools.arrays import FloatArray


@dataclass(frozen=True)
class ShellForce(Force):
    """A force of the position alone with a potential, f = -dU/dq at the amplitudes of rest and motion together."""

    loaded: LoadedShell
    rest: FloatArray  # amplitudes of the reference shape, about which q is measured (dof,) [m]

    @abstractmethod
    def stiffness(self, q: FloatArray) -> FloatArray:
        """Return -df/dq, shape (dof, dof) [N/m]."""

    def linear(self) -> Linear:
        """Its tangent about the reference shape."""
        return Linear(stiffness=self.stiffness(np.zeros_like(self.rest)), fully_linear=False)


@dataclass(frozen=True)
class ElasticForce(ShellForce):
    """The elastic force of the shell."""

    def stiffness(self, q: FloatArray) -> FloatArray:
        """Return the Hessian of the elastic energy."""
        return self.loaded.elastic.stiffness(self.rest + q)

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the elastic force along a motion, shape (time, dof) [N]."""
        return self.loaded.elastic.force(self.rest + q)

    def potential_energy(self, q: FloatArray) -> FloatArray:
        """Return the elastic energy."""
        return np.asarray(self.loaded.elastic.energy(self.rest + q))


@dataclass(frozen=True)
class InsidePressure(ShellForce):
    """The force of the pressure inside, p dV/dq, constant or of trapped gas."""

    def stiffness(self, q: FloatArray) -> FloatArray:
        """Return that of the follower pressure and of the gas."""
        at = self.rest + q
        return self.loaded.pressure_stiffness(at) + self.loaded.gas_stiffness(at)

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the force of the pressure along a motion, shape (time, dof) [N]."""
        at = self.rest + q
        return np.asarray(np.asarray(self.loaded.pressure(at))[..., None] * self.loaded.elastic.volume_gradient(at))

    def potential_energy(self, q: FloatArray) -> FloatArray:
        """Return minus the work of the pressure."""
        return self.loaded.contents_energy(self.rest + q)


def shell_forces(loaded: LoadedShell, rest: FloatArray) -> dict[str, ShellForce]:
    """Return the forces of a shell by name: elastic, and of the pressure inside if there is any."""
    forces: dict[str, ShellForce] = {"elastic": ElasticForce(loaded, rest)}
    if loaded.internal_pressure or loaded.gas:
        forces["internal_pressure"] = InsidePressure(loaded, rest)
    return forces
