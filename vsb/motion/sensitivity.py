"""How much the errors of hydrodynamic coefficients change the power of a port, and the gain of one over another.

With D = -w^2 (M + A) - i w (B + D_s + Z_l b b^T) + K of a take-off of impedance Z_l at the port b, q = D^-1 X and
lambda = D^-1 b, the velocity V = -i w b.q of the port changes by dV = -i w lambda.(dX - dD q), dD = -w^2 dA - i w dB.
The power P = sum a^2 Re Z_l |V|^2/2 of a sea changes by dP = sum a^2 Re Z_l Re(V* dV). Where the take-off is the best
of its kind, P does not change to first order with Z_l (envelope): the same law holds at fixed Z_l.
"""

from typing import NamedTuple

import numpy as np

from vsb.hydro.coefficients import Coefficients
from vsb.motion.port import Port
from vsb.tools.arrays import ComplexArray, FloatArray


class CoefficientError(NamedTuple):
    """An estimated error of the coefficients at some frequencies, from one source.

    Of `signed` errors added mass, damping, excitation and stiffness are each known as a whole, but not how they go
    together; of others only the size of every entry is known.
    """

    name: str
    error: Coefficients
    signed: bool
    stiffness: FloatArray | None = None  # of the still water, which panels give as well (dof, dof) [N/m]


class Sensitivity(NamedTuple):
    """Derivatives of the logarithm of a power by added mass, damping, excitation and stiffness, entry by entry."""

    added_mass: FloatArray  # (omega, dof, dof) [1/kg]
    damping: FloatArray  # (omega, dof, dof) [s/kg]
    excitation: ComplexArray  # (omega, dof) [m/N]
    stiffness: FloatArray  # (omega, dof, dof) [m/N]

    def __sub__(self, other: "Sensitivity") -> "Sensitivity":
        """Of the ratio of two powers, whose coefficients are the same: what they share cancels."""
        return Sensitivity(
            self.added_mass - other.added_mass,
            self.damping - other.damping,
            self.excitation - other.excitation,
            self.stiffness - other.stiffness,
        )

    def to(self, error: CoefficientError) -> float:
        """Return the largest change of ln P by an error of the coefficients [-]."""
        changes = (*error.error, 0.0 if error.stiffness is None else error.stiffness)
        products = [np.asarray(slope * change) for slope, change in zip(self, changes, strict=True)]
        if error.signed:
            return float(sum(abs(product.real.sum()) for product in products))
        return float(sum(np.abs(product).sum() for product in products))


def sensitivity(
    omega: FloatArray,
    moved: tuple[ComplexArray, ComplexArray],
    port: Port,
    load: ComplexArray,
    squares: FloatArray,
) -> Sensitivity:
    """Return the derivatives of the logarithm of the power of a sea.

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
    moved : tuple of ndarray, each shape (omega, dof)
        Motions free of the take-off and under its unit force, of `vsb.motion.frequency.LinearMotion.free_motion`.
    port : Port
        At these frequencies, as the load sees it.
    load : ndarray, shape (omega,) [N s/m]
        Z_l.
    squares : ndarray, shape (omega,) [m^2]
        Squared amplitudes of the sea.

    Notes
    -----
    By Sherman and Morrison from the motions without take-off: lambda = forced/(1 + Y Z_l), q = free - Z_l V forced with
    V = V0/(1 + Y Z_l); a chamber between port and take-off is part of Y. Added mass and damping are symmetric, so are
    their derivatives.
    """
    free, forced = moved
    velocity = port.velocity_under(load)
    response = free - (load * velocity)[:, None] * forced
    adjoint = forced / (1 + port.admittance * load)[:, None]
    power = float(np.sum(0.5 * squares * load.real * np.abs(velocity) ** 2))
    if not power > 0:
        none = np.zeros((*free.shape, free.shape[1]))
        return Sensitivity(none, none, np.zeros_like(free), none)
    weight = squares * load.real * velocity.conj() * (-1j * omega) / power
    towards = weight[:, None] * adjoint
    return _by_coefficients(omega, towards, -towards[:, :, None] * response[:, None, :])


def sensitivity_of_forces(
    omega: FloatArray,
    moved: tuple[ComplexArray, ComplexArray],
    waves: ComplexArray,
    forces: ComplexArray,
    power: float,
    shares: FloatArray,
) -> Sensitivity:
    """Return the derivatives of the logarithm of the mean power that optimal forces absorb in several seas.

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
    moved : tuple of ndarray, each shape (omega, dof)
        See `sensitivity`.
    waves, forces : ndarray, each shape (sea, omega) [m], [N]
        Complex amplitudes; of each sea the force of the port on the take-off.
    power : float
        The mean power they absorb [W]; without any there are no derivatives.
    shares : ndarray, shape (sea,)
        Weights of the seas in it.

    Notes
    -----
    P = Re(f* V)/2 of the motion under the force. Where f is the best of all, or within a limit of its own, P does not
    change to first order with it (envelope): dP = Re(f* dV)/2 at fixed f. What the coefficients change of a limit of
    the stroke is not counted.
    """
    free, forced = moved
    count, size = free.shape
    if not power > 0:
        none = np.zeros((count, size, size))
        return Sensitivity(none, none, np.zeros_like(free), none)
    response = waves[..., None] * free - forces[..., None] * forced
    weight = -0.5j * omega * shares[:, None] * forces.conj() / power
    towards = np.sum(weight * waves, axis=0)[:, None] * forced
    stiffness = -forced[:, :, None] * np.einsum("sw,swj->wj", weight, response)[:, None, :]
    return _by_coefficients(omega, towards, stiffness)


def _by_coefficients(omega: FloatArray, towards: ComplexArray, stiffness: ComplexArray) -> Sensitivity:
    """Derivatives by symmetric coefficients, from those by the force and by the entries of D, (omega, dof, dof)."""
    w, both = omega[:, None, None], 0.5 * (stiffness + stiffness.transpose(0, 2, 1))
    return Sensitivity(-(w**2) * both.real, np.real(-1j * w * both), towards, both.real)
