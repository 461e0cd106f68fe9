"""The radiation channel of motions of one azimuthal order, B = h X X^H (Haskind), between the frequencies solved."""

from typing import NamedTuple, Self

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.ndimage import binary_dilation

from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

_BESIDE = 2
"""Frequencies to either side of a damping below zero that say nothing of the waves made."""
_FEWEST = 4
"""Frequencies a spline is drawn through at least."""


class Channel(NamedTuple):
    """What some motions radiate by their excitation."""

    group: IntArray  # their numbers
    factor: CubicSpline  # h over a power of frequency
    power: int

    @classmethod
    def of(cls, database: xr.Dataset, group: IntArray, heading: int = 0) -> Self:
        """Return the channel of some motions of a database: Haskind's factor h = tr B/|X|^2 of them.

        X in waves of the `heading`-th direction, which must excite them.
        It leaves zero with omega^3 in deep water, with omega in shallow: divided by that power it is smooth.
        Where hardly any wave is made, B and X are the solver's error: next to a damping that is none, the factor is
        left to the frequencies around.
        """
        omega, damping = database.omega.values, database.radiation_damping.values[:, group[:, None], group]
        factor = haskind_factor(damping, database.excitation_force.values[:, heading, group])
        known = ~binary_dilation(factor <= 0, iterations=_BESIDE)
        if known.sum() >= _FEWEST:
            omega, factor = omega[known], factor[known]
        slope = np.log(factor[1] / factor[0]) / np.log(omega[1] / omega[0])
        power = int(np.clip(np.rint(slope), 1, 3))
        return cls(group, CubicSpline(omega, factor / omega**power), power)

    def damping(self, omega: FloatArray, excitation: ComplexArray) -> FloatArray:
        """Return the damping at frequencies of which the excitation, (omega, dof), is known, (omega, dof, dof) [kg/s].

        Of all degrees of freedom; those of other orders have none here.
        """
        found = np.zeros((len(omega), excitation.shape[1], excitation.shape[1]))
        own = (self.factor(omega) * omega**self.power)[:, None, None] * one_channel(excitation[:, self.group])
        found[:, self.group[:, None], self.group] = own
        return found


def one_channel(excitation: ComplexArray) -> FloatArray:
    """Return Re X X^H of excitation forces (omega, dof), shape (omega, dof, dof)."""
    return np.real(excitation[:, :, None] * excitation[:, None, :].conj())


def haskind_factor(damping: FloatArray, excitation: ComplexArray) -> FloatArray:
    """Return h = tr B/|X|^2 of damping (omega, dof, dof) and excitation (omega, dof), shape (omega,)."""
    return np.asarray(np.einsum("wii->w", damping) / np.einsum("wii->w", one_channel(excitation)))


def channelled(damping: FloatArray, excitation: ComplexArray) -> FloatArray:
    """Return the part h Re X X^H of a damping, shape (omega, dof, dof): what is left is the solver's error."""
    return haskind_factor(damping, excitation)[:, None, None] * one_channel(excitation)
