"""Hydrodynamic coefficients at any frequencies: what a solver or a database gives, what a response needs."""

from typing import NamedTuple

from vsb.tools.units import ComplexArray, FloatArray


class Coefficients(NamedTuple):
    """Hydrodynamic coefficients at any frequencies."""

    added_mass: FloatArray  # (omega, dof, dof) [kg]
    damping: FloatArray  # (omega, dof, dof) [kg/s]
    excitation: ComplexArray  # (omega, dof) [N/m]
