"""Estimated errors of hydrodynamic coefficients, and how much they change the power of a port.

With D = -w^2 (M + A) - i w (B + D_s + Z_l b b^T) + K of a take-off of impedance Z_l at the port b, q = D^-1 X and
lambda = D^-1 b, the velocity V = -i w b.q of the port changes by dV = -i w lambda.(dX - dD q), dD = -w^2 dA - i w dB.
The power P = sum a^2 Re Z_l |V|^2/2 of a sea changes by dP = sum a^2 Re Z_l Re(V* dV). Where the take-off is optimal,
P does not change to first order with Z_l (envelope theorem): the same expression holds at fixed Z_l.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from scipy.interpolate import make_interp_spline

from vsb.engine.hydro.database import ESTIMATE, Coefficients, stored_checks
from vsb.engine.hydro.orders import order_groups
from vsb.engine.hydro.variables import AT_GEOMETRY, OF_GEOMETRY, RESOLUTION
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import Port, Ports
from vsb.engine.waves.water import haskind_factor
from vsb.tools.arrays import ComplexArray, FloatArray


@dataclass(frozen=True, eq=False)
class CoefficientError:
    """An estimated error of the coefficients at some frequencies, from one source.

    Of `signed` errors added mass, damping, excitation and stiffness are each known as a whole, but not how they go
    together; of others only the size of every entry is known, not negative.
    """

    name: str
    error: Coefficients
    signed: bool
    stiffness: FloatArray | None = None  # of the still water, which panels give as well (dof, dof) [N/m]
    _kept: list[FloatArray] = field(default_factory=list, repr=False)

    def sizes(self, omega: FloatArray) -> FloatArray:
        """Sizes of the error of D, at its frequencies: of every entry that of Re D, then of Im D (omega, ...)."""
        if not self._kept:  # of all designs and dampings of a year the same
            mass, damping, _ = self.error
            parts = np.stack([mass, damping], axis=-1) * omega[:, None, None, None] ** [2, 1]
            if self.stiffness is not None:
                parts[..., 0] += self.stiffness
            self._kept.append(parts.reshape(len(omega), -1))
        return self._kept[0]


AT_ONCE = 2**15
"""Entries of matrices over frequency held at a time."""


@dataclass(frozen=True)
class Sensitivity:
    """Derivatives of the logarithm of a power by the coefficients, entry by entry.

    By the dynamic stiffness they are sums of products of two vectors at each frequency, and kept as such: those of all
    designs and levels in a sea of a thousand components would be gigabytes.
    """

    omega: FloatArray  # (omega,) [rad/s]
    excitation: ComplexArray  # by the excitation (omega, dof) [m/N]
    products: tuple[tuple[ComplexArray, ComplexArray], ...]  # u, q of -u q^T, by D, each (omega, dof)

    def __sub__(self, other: "Sensitivity") -> "Sensitivity":
        """Of the ratio of two powers, whose coefficients are the same: what they share cancels."""
        of_other = tuple((-towards, response) for towards, response in other.products)
        return Sensitivity(self.omega, self.excitation - other.excitation, (*self.products, *of_other))

    def _factors(self, part: slice) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
        """Real L and R, (omega, dof, column), of Re and Im of the derivative by D, L R^T, made symmetric.

        D = -w^2 A - i w B + K: by A it is -w^2 Re, by B w Im, by K Re.
        """
        count, dof = self.excitation[part].shape
        none = (np.zeros((count, dof), dtype=complex),) * 2  # of a port that does not move
        of_both = [(one, other) for t, q in self.products for one, other in ((t[part], q[part]), (q[part], t[part]))]
        left, right = (np.stack(side, axis=-1) for side in zip(*(of_both or [none]), strict=True))
        real = np.concatenate([-left.real, left.imag], axis=-1), np.concatenate([right.real, right.imag], axis=-1) / 2
        imaginary = np.concatenate([-left.real, -left.imag], axis=-1), np.concatenate([right.imag, right.real], axis=-1)
        return real, (imaginary[0], imaginary[1] / 2)

    def to(self, error: CoefficientError) -> float:
        """Return the largest change of ln P by an error of the coefficients [-]."""
        step = max(1, AT_ONCE // max(1, self.excitation.shape[1] ** 2))
        changes = self._signed if error.signed else self._worst
        parts = [changes(error, slice(start, start + step)) for start in range(0, len(self.omega), step)]
        return float(np.abs(np.sum(parts, axis=0)).sum())

    def _signed(self, error: CoefficientError, part: slice) -> FloatArray:
        """Changes of ln P at some frequencies by mass, damping, excitation and stiffness of an error, shape (4,)."""
        (left, right), (turned, beside) = self._factors(part)
        w, (mass, damping, force) = self.omega[part], error.error
        by_mass, by_damping = (
            np.einsum("wik,wik->w", one, matrix[part] @ other)
            for matrix, one, other in ((mass, left, right), (damping, turned, beside))
        )
        held = 0.0 if error.stiffness is None else np.vdot(left, error.stiffness @ right)
        return np.array([-(w**2) @ by_mass, w @ by_damping, np.sum(self.excitation[part] * force[part]).real, held])

    def _worst(self, error: CoefficientError, part: slice) -> FloatArray:
        """Changes by excitation and D if all entries of the error go together: sums of sizes."""
        by_force = float(np.abs(self.excitation[part] * error.error.excitation[part]).sum())
        if not self.products:
            return np.array([by_force, 0.0])
        towards, response = (np.stack([one[part] for one in side]) for side in zip(*self.products, strict=True))
        left, right = np.concatenate([towards, response]), np.concatenate([response, towards])
        both = (left.transpose(1, 2, 0) @ right.transpose(1, 0, 2)).view(float).ravel()
        return np.array([by_force, np.abs(both, out=both) @ error.sizes(self.omega)[part].ravel() / 2])


def sensitivity(
    moved: tuple[ComplexArray, ComplexArray], seen: Port | Ports, load: Any, squares: FloatArray
) -> Sensitivity:
    """Return the derivatives of the logarithm of the power of a sea.

    Parameters
    ----------
    moved : tuple of ndarray, shapes (omega, dof), and (omega, dof) or (omega, dof, port)
        Motions free of the take-off and under its unit forces, of
        `vsb.engine.motion.frequency.LinearEquation.free_motion`.
    seen : Port or Ports
        At these frequencies, as the load sees it.
    load : ndarray, shape (omega,) [N s/m] or (port, port)
        Impedance Z of damper and spring at one port, or a real damper matrix C at several.
    squares : ndarray, shape (omega,) [m^2]
        Squared amplitudes of the sea.

    Notes
    -----
    dP = sum a^2 Re((Re Z V)^H dV), dV = -i w l^T (dX - dD q), by Sherman and Morrison from the motions without
    take-off: l = forced (1 + Z Y)^-1, q = free - forced Z V, V = (1 + Y Z)^-1 V0. A chamber between port and take-off
    is part of Y. An optimal C does not change P to first order (envelope).
    """
    omega, (free, forced) = seen.omega, moved
    velocity = seen.velocity_under(load)
    one = velocity.ndim == 1  # a 1 x 1 matrix is divided by, which is quicker than to solve
    force = load * velocity if one else velocity @ load
    resistive = load.real * velocity if one else force
    power = 0.5 * float(squares @ np.real(resistive.conj() * velocity).reshape(len(omega), -1).sum(axis=1))
    if not power > 0:
        return Sensitivity(omega, np.zeros_like(free), ())
    weight = ((-1j * omega * squares / power) * resistive.conj().T).T
    if one:
        response = free - force[:, None] * forced
        towards = (weight / (1 + seen.admittance * load))[:, None] * forced
    else:
        response = free - (forced @ force[..., None])[..., 0]
        beside = np.linalg.solve(np.eye(len(load)) + load @ seen.admittance, weight[..., None])
        towards = (forced @ beside)[..., 0]
    return Sensitivity(omega, towards, ((towards, response),))


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
    moved : tuple of ndarray
        See `sensitivity`.
    waves, forces : ndarray, shapes (sea, omega) [m], (sea, omega) or (sea, omega, port) [N]
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
    if not power > 0:
        return Sensitivity(omega, np.zeros_like(free), ())
    forced, forces = forced.reshape(*free.shape, -1), forces.reshape(*waves.shape, -1)
    response = waves[..., None] * free - np.einsum("wjp,swp->swj", forced, forces)
    weight = -0.5j * omega[:, None] * shares[:, None, None] * forces.conj() / power
    towards = np.einsum("swp,sw,wjp->wj", weight, waves, forced)
    adjoint = np.einsum("swp,swj->pwj", weight, response)
    return Sensitivity(omega, towards, tuple(zip(np.moveaxis(forced, 2, 0), adjoint, strict=True)))


UNSTATED = 0.01
"""Relative error taken of coefficients of another code, whose files state none [-]."""
RESOLVED, INTERPOLATION = "resolution of the coefficients", "interpolation between frequencies"
GEOMETRY = "shape between the points of the profile"
OF_OTHERS = f"coefficients read from a file that states no error, taken as {100 * UNSTATED:g} %"
_NEIGHBOURS = 24
"""Part of the band within which interpolation errors change sign: that between about a dozen frequencies solved."""
_SAFETY = 3.0
"""Factor on the misfit of damping and excitation, which share a part of their errors.

Against a tenth of the tolerance, errors of 6840 powers and 1824 gains of 57 random buoys in regular and irregular seas
were at most 0.98 and 0.28 of the bound.
"""


def coefficient_errors(linear: LinearSystem, omega: FloatArray) -> list[CoefficientError]:
    """Return the estimated errors of the coefficients of a buoy or body, each source by itself.

    Parameters
    ----------
    linear : LinearSystem
        In waves of some direction.
    omega : ndarray, shape (omega,) [rad/s]
        In the band solved.

    Notes
    -----
    Where a database holds the change of every coefficient by coarser panels and by the energy of the waves radiated,
    those are taken as they are, frequency by frequency. Else the estimate of the solver, of each degree of freedom
    where it is known, is taken as the relative error of every entry by itself, in the worst combination.
    """
    found, stated = linear.coefficients(omega), {check.name: check.value for check in stored_checks(linear.database)}
    if f"added_mass_{ESTIMATE}" in linear.database:
        errors = _stored(linear, omega)
    elif RESOLUTION in linear.database:
        errors = [relative_error(RESOLVED, found, _by_motion(linear.database))]
    elif "error_estimate" in stated:
        errors = [relative_error(RESOLVED, found, stated["error_estimate"])]
    else:
        errors = [relative_error(OF_OTHERS, found, UNSTATED)]
    if AT_GEOMETRY in linear.database.attrs:
        errors.append(_of_geometry(linear, omega, found))
    between = stated.get("interpolation_error", 0.0)
    if linear.axisymmetric:
        errors.append(_between(linear, omega, found, between))
    elif between:
        errors.append(relative_error(INTERPOLATION, found, between))
    return errors


def _of_geometry(linear: LinearSystem, omega: FloatArray, found: Coefficients) -> CoefficientError:
    """Errors by what is unknown of the shape, each coefficient by a part of itself that changes with frequency."""
    ds = linear.database
    sizes = {name: np.interp(omega, ds.attrs[AT_GEOMETRY], ds.attrs[attr]) for name, attr in OF_GEOMETRY.items()}
    mass, damping = (
        sizes[name][:, None, None] * np.abs(values)
        for name, values in (("added_mass", found.added_mass), ("radiation_damping", found.damping))
    )
    force = (sizes["excitation_force"][:, None] * np.abs(found.excitation)).astype(complex)
    stiffness = sizes["hydrostatic_stiffness"].max() * np.abs(ds.hydrostatic_stiffness.values)
    return CoefficientError(GEOMETRY, Coefficients(mass, damping, force), False, stiffness)


def relative_error(name: str, found: Coefficients, size: FloatArray | float) -> CoefficientError:
    """Return errors of every entry by a part of itself, of coupling by the larger of those of its motions, (dof,)."""
    both = np.maximum.outer(size, size)
    mass, damping, force = (part * np.abs(values) for part, values in zip((both, both, size), found, strict=True))
    return CoefficientError(name, Coefficients(mass, damping, force.astype(complex)), signed=False)


def combined(errors: Sequence[CoefficientError]) -> list[CoefficientError]:
    """Return errors whose changes of a power are added: those of which only sizes are known as one, their sum."""
    signed = [one for one in errors if one.signed or one.stiffness is not None]
    sizes = [one.error for one in errors if not (one.signed or one.stiffness is not None)]
    if not sizes:
        return signed
    together = Coefficients(*(np.sum([np.abs(one) for one in part], axis=0) for part in zip(*sizes, strict=True)))
    return [*signed, CoefficientError(RESOLVED, together._replace(excitation=together.excitation + 0j), signed=False)]


def _by_motion(ds: xr.Dataset) -> FloatArray:
    """Relative error of the solver in each degree of freedom, (dof,) [-]; of what moves no water none."""
    largest = np.sqrt(np.abs(np.einsum("wii->iw", ds.added_mass.values)).max(axis=1))
    return np.asarray(np.divide(ds[RESOLUTION].values, largest, out=np.zeros_like(largest), where=largest > 0))


def _stored(linear: LinearSystem, omega: FloatArray) -> list[CoefficientError]:
    """Errors as a database holds them, on straight lines between its frequencies."""
    ds = linear.database
    mass, damping, force = (
        make_interp_spline(ds.omega.values, ds[f"{name}_{ESTIMATE}"].transpose("omega", ...).values, k=1)(omega)
        for name in ("added_mass", "radiation_damping", "excitation_force")
    )
    near = linear.heading_index
    stiffness = ds[f"hydrostatic_stiffness_{ESTIMATE}"].values
    return [
        CoefficientError(
            f"{RESOLVED} ({source})", Coefficients(mass[:, i], damping[:, i], force[:, i, near]), True, stiffness[i]
        )
        for i, source in enumerate(map(str, ds[ESTIMATE].values))
    ]


def _between(linear: LinearSystem, omega: FloatArray, found: Coefficients, stated: float) -> CoefficientError:
    """Errors of what is interpolated between the frequencies solved, of a body of revolution.

    Of orders m >= 1, whose damping is made from excitation, the stated error of interpolation is taken of every entry.
    """
    mass, damping, force = (stated * np.abs(values) for values in found)
    ds, groups = linear.database, order_groups(linear.database)
    if 0 in groups:
        own, at = groups[0], ds.omega.values
        block, pair = (np.ix_(np.arange(len(some)), own, own) for some in (omega, at))
        water = (float(ds.attrs[name]) for name in ("water_depth", "water_density", "gravity"))
        known = linear.coefficients(at)
        misfits = haskind_misfits(
            at, ds.radiation_damping.values[pair], known.damping[pair], known.excitation[:, own], *water
        )
        mass[block], damping[block], force[:, own] = (
            np.abs(make_interp_spline(at, each, k=1)(omega)) for each in misfits
        )
    return CoefficientError(INTERPOLATION, Coefficients(mass, damping, force.astype(complex)), signed=False)


def haskind_misfits(
    omega: FloatArray,
    damping: FloatArray,
    channelled: FloatArray,
    excitation: ComplexArray,
    depth: float,
    density: float,
    gravity: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return bounds of the errors of added mass, damping and excitation of axisymmetric motions, entry by entry.

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
        Closer than the frequencies solved.
    damping : ndarray, shape (omega, dof, dof) [N s/m]
        As solved and interpolated.
    channelled : ndarray, shape (omega, dof, dof) [N s/m]
        As it is used, of one radiation channel.
    excitation : ndarray, shape (omega, dof) [N/m]
    depth, density, gravity : float

    Notes
    -----
    Damping and excitation are interpolated apart, and say the same twice: B_ij = h X_i X_j*, h = k/(4 rho g v_g)
    (Haskind). |X_i| is off by its distance from sqrt(B_ii/h), B by its distance from the channel it is taken as. Added
    mass is the real part of the function whose imaginary part is B/omega: it is off as B is off from rank one. These
    distances change sign between the frequencies solved, so at each frequency the largest nearby is taken.
    """
    factor = haskind_factor(omega, depth, density, gravity)
    root = np.sqrt(np.maximum(np.einsum("wii->wi", damping), 0.0))
    rank_one = np.sign(damping) * root[:, :, None] * root[:, None, :]
    distances = (
        np.abs(damping - rank_one) / omega[:, None, None],
        np.abs(damping - channelled),
        np.abs(root / np.sqrt(factor)[:, None] - np.abs(excitation)),
    )
    mass, of_damping, force = (_SAFETY * _nearby(each) for each in distances)
    return mass, of_damping, force


def _nearby(values: FloatArray) -> FloatArray:
    """The largest of neighbours in frequency, a `_NEIGHBOURS`-th of the band to either side."""
    reach = len(values) // _NEIGHBOURS
    around = np.pad(values, [(reach, reach)] + [(0, 0)] * (values.ndim - 1), mode="edge")
    return np.asarray(np.lib.stride_tricks.sliding_window_view(around, 2 * reach + 1, axis=0).max(axis=-1))
