"""Estimated errors of hydrodynamic coefficients at any frequencies, from what a database says of itself."""

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.ndimage import maximum_filter1d

from vsb.hydro.coefficients import Coefficients
from vsb.hydro.database import ESTIMATE, stored_checks
from vsb.hydro.orders import order_groups
from vsb.motion.frequency import LinearBuoy, LinearMotion
from vsb.motion.sensitivity import CoefficientError
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.waves.dispersion import group_velocity, wavenumber

UNSTATED = 0.01
"""Relative error taken of coefficients of another code, whose files state none [-]."""
RESOLUTION, INTERPOLATION = "resolution of the coefficients", "interpolation between frequencies"
OF_OTHERS = f"coefficients read from a file that states no error, taken as {100 * UNSTATED:g} %"
_NEIGHBOURS = 24
"""Part of the band within which interpolation errors change sign: that between about a dozen frequencies solved."""
_SAFETY = 3.0
"""Factor on the misfit of damping and excitation, which share a part of their errors.

Against a tenth of the tolerance, errors of 6840 powers and 1824 gains of 57 random buoys in regular and irregular seas
were at most 0.98 and 0.28 of the bound.
"""


def coefficient_errors(linear: LinearMotion, omega: FloatArray) -> list[CoefficientError]:
    """Return the estimated errors of the coefficients of a buoy or body, each source by itself.

    Parameters
    ----------
    linear : LinearMotion
        In waves of some direction.
    omega : ndarray, shape (omega,) [rad/s]
        In the band solved.

    Notes
    -----
    Where a database holds the change of every coefficient by coarser panels and by the energy of the waves radiated,
    those are taken as they are, frequency by frequency. Else the estimate of the solver is taken as the relative error
    of every entry by itself, in the worst combination.
    """
    found, stated = linear.coefficients(omega), {check.name: check.value for check in stored_checks(linear.database)}
    if f"added_mass_{ESTIMATE}" in linear.database:
        errors = _stored(linear, omega)
    elif "error_estimate" in stated:
        errors = [relative_error(RESOLUTION, found, stated["error_estimate"])]
    else:
        errors = [relative_error(OF_OTHERS, found, UNSTATED)]
    between = stated.get("interpolation_error", 0.0)
    if isinstance(linear, LinearBuoy):
        errors.append(_between(linear, omega, found, between))
    elif between:
        errors.append(relative_error(INTERPOLATION, found, between))
    return errors


def relative_error(name: str, found: Coefficients, size: float) -> CoefficientError:
    """Return errors of every entry by a part of itself."""
    mass, damping, force = (size * np.abs(values) for values in found)
    return CoefficientError(name, Coefficients(mass, damping, force.astype(complex)), signed=False)


def _stored(linear: LinearMotion, omega: FloatArray) -> list[CoefficientError]:
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
            f"{RESOLUTION} ({source})", Coefficients(mass[:, i], damping[:, i], force[:, i, near]), True, stiffness[i]
        )
        for i, source in enumerate(map(str, ds[ESTIMATE].values))
    ]


def _between(linear: LinearBuoy, omega: FloatArray, found: Coefficients, stated: float) -> CoefficientError:
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
        mass[block], damping[block], force[:, own] = (make_interp_spline(at, each, k=1)(omega) for each in misfits)
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
    damping : ndarray, shape (omega, dof, dof) [kg/s]
        As solved and interpolated.
    channelled : ndarray, shape (omega, dof, dof) [kg/s]
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
    k, speed = (np.array([of(w, depth, gravity) for w in omega]) for of in (wavenumber, group_velocity))
    factor = k / (4 * density * gravity * speed)
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
    return np.asarray(maximum_filter1d(values, 2 * reach + 1, axis=0, mode="nearest"))
