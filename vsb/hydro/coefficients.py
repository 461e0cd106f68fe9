"""Hydrodynamic coefficients at any frequencies: what a solver or a database gives, what a response needs."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from vsb.tools.arrays import ComplexArray, FloatArray


class Coefficients(NamedTuple):
    """Hydrodynamic coefficients at any frequencies."""

    added_mass: FloatArray  # (omega, dof, dof) [kg]
    damping: FloatArray  # (omega, dof, dof) [kg/s]
    excitation: ComplexArray  # (omega, dof) [N/m]

    @classmethod
    def side_by_side(cls, parts: Sequence["Coefficients"]) -> "Coefficients":
        """Return coefficients of motions that do not couple through the water, as those of azimuthal orders."""
        if len(parts) == 1:
            return parts[0]
        return cls(
            _blocks([part.added_mass for part in parts]),
            _blocks([part.damping for part in parts]),
            np.concatenate([part.excitation for part in parts], axis=1),
        )


def _blocks(matrices: Sequence[FloatArray]) -> FloatArray:
    """Matrices over frequency as blocks of one, (omega, dof, dof)."""
    return np.array([block_diag(*at) for at in zip(*matrices, strict=True)])
