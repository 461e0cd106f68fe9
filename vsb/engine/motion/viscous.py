"""Viscous material: Maxwell branches, springs in series with dashpots, beside the stiffness K of the shell.

A branch of ratio r and relaxation time tau carries r K (q - s) with the dashpot's displacement s, tau s' = q - s. At a
frequency the shell then has the complex stiffness (C1)

    K [1 + sum r (-i w tau)/(1 - i w tau)] = K [1 + sum r w^2 tau^2/(1 + w^2 tau^2)] - i w K sum r tau/(1 + w^2 tau^2),

storage and loss modulus of a generalised Maxwell model (Ferry, Viscoelastic Properties of Polymers, 1980). At rest the
branches carry nothing. In time their states x = sqrt(r) L^T (q - s), K = L L^T, store |x|^2/2 and lose |x|^2/tau.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.motion.forces import Force, Linear
from vsb.engine.shell.device import MaxwellBranch
from vsb.tools.arrays import FloatArray

_ROUND_OFF = 1e-13
"""Eigenvalue of a stiffness, over its largest, that is round-off: of a rigid motion [-]."""


def stiffening(branches: Sequence[MaxwellBranch], omega: FloatArray) -> FloatArray:
    """Return what branches add to a stiffness at frequencies, as a fraction of it, of the shape of omega [-]."""
    squares = [(omega * branch.time) ** 2 for branch in branches]
    return sum((b.ratio * x / (1 + x) for b, x in zip(branches, squares, strict=True)), np.zeros_like(omega))


def loss(branches: Sequence[MaxwellBranch], omega: FloatArray) -> FloatArray:
    """Return the damping of branches at frequencies over the stiffness, of the shape of omega [s]."""
    return sum((b.ratio * b.time / (1 + (omega * b.time) ** 2) for b in branches), np.zeros_like(omega))


@dataclass(frozen=True)
class ViscousForce(Force):
    """The force of Maxwell branches beside a stiffness K."""

    branches: tuple[MaxwellBranch, ...]
    stiffness: FloatArray  # K (dof, dof) [N/m]

    @cached_property
    def model(self) -> RadiationModel:
        """Its memory."""
        values, vectors = np.linalg.eigh(self.stiffness)
        kept = values > _ROUND_OFF * values[-1]
        factor = (vectors[:, kept] * np.sqrt(values[kept])).T
        rates = np.repeat([1 / branch.time for branch in self.branches], len(factor))
        inputs = np.concatenate([np.sqrt(branch.ratio) * factor for branch in self.branches])
        return RadiationModel(-np.diag(rates), inputs, np.diag(np.sqrt(2 * rates)))

    def linear(self) -> Linear:
        """All of it."""
        return Linear(memory=self.model)
