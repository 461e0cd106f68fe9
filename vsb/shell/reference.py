"""Shape at rest of a shell, and its stiffness about it by name."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis
from vsb.tools.arrays import FloatArray


@dataclass(frozen=True)
class ReferenceShell:
    """Shape at rest and the stiffness about it; motions are measured from there."""

    shape: DeformedShell
    stiffness: Mapping[str, FloatArray]  # structural, hydrostatic, and where there are: prestress, gas (dof, dof) [N/m]

    @property
    def basis(self) -> ModeBasis:
        """Heave and shell modes."""
        return self.shape.basis

    @property
    def total(self) -> FloatArray:
        """Sum of the stiffness, shape (dof, dof) [N/m]."""
        return np.asarray(sum(self.stiffness.values()))

    @property
    def modal_amplitude(self) -> FloatArray:
        """Heave and modal amplitudes of the shape at rest, shape (dof,) [m]; zero if undeformed."""
        return self.shape.modal_amplitude

    @property
    def keel_depth(self) -> float:
        """Depth of the keel below still water [m]."""
        return -float(self.shape.meridian(np.array([np.pi])).z[0])
