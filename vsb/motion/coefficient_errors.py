"""Estimated errors of hydrodynamic coefficients at any frequencies, from what a database says of itself."""

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.ndimage import maximum_filter1d

from vsb.hydro.coefficients import Coefficients
from vsb.hydro.database import ESTIMATE, stored_checks
from vsb.hydro.orders import order_groups
from vsb.motion.bodies import LinearBody
from vsb.motion.frequency import LinearBuoy, LinearMotion
from vsb.motion.sensitivity import CoefficientError
from vsb.tools.units import FloatArray, IntArray
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
        errors = [_relative(RESOLUTION, found, stated["error_estimate"])]
    else:
        errors = [_relative(OF_OTHERS, found, UNSTATED)]
    between = stated.get("interpolation_error", 0.0)
    if isinstance(linear, LinearBuoy):
        errors.append(_between(linear, omega, found, between))
    elif between:
        errors.append(_relative(INTERPOLATION, found, between))
    return errors


def _relative(name: str, found: Coefficients, size: float) -> CoefficientError:
    """Errors of every entry by a part of itself."""
    mass, damping, force = (size * np.abs(values) for values in found)
    return CoefficientError(name, Coefficients(mass, damping, force.astype(complex)), signed=False)


def _stored(linear: LinearMotion, omega: FloatArray) -> list[CoefficientError]:
    """Errors as a database holds them, on straight lines between its frequencies."""
    ds = linear.database
    mass, damping, force = (
        make_interp_spline(ds.omega.values, ds[f"{name}_{ESTIMATE}"].transpose("omega", ...).values, k=1)(omega)
        for name in ("added_mass", "radiation_damping", "excitation_force")
    )
    near = linear.heading_index if isinstance(linear, LinearBody) else 0
    stiffness = ds[f"hydrostatic_stiffness_{ESTIMATE}"].values
    return [
        CoefficientError(
            f"{RESOLUTION} ({source})", Coefficients(mass[:, i], damping[:, i], force[:, i, near]), True, stiffness[i]
        )
        for i, source in enumerate(map(str, ds[ESTIMATE].values))
    ]


def _between(linear: LinearBuoy, omega: FloatArray, found: Coefficients, stated: float) -> CoefficientError:
    """Errors of what is interpolated between the frequencies solved, of a body of revolution.

    Notes
    -----
    Damping and excitation are interpolated apart, and say the same twice: B_ij = h X_i X_j*, h = k/(4 rho g v_g)
    (Haskind). |X_i| is off by its distance from sqrt(B_ii/h), B by its distance from the channel it is taken as. Added
    mass is the real part of the function whose imaginary part is B/omega: it is off as B is off from rank one. These
    distances change sign between the frequencies solved, so at each frequency the largest nearby is taken. Of orders
    m >= 1, whose damping is made from excitation, the stated error of interpolation is taken of every entry.
    """
    mass, damping, force = (stated * np.abs(values) for values in found)
    groups = order_groups(linear.database)
    if 0 in groups:
        own = groups[0]
        block = np.ix_(np.arange(len(omega)), own, own)
        mass[block], damping[block], force[:, own] = (
            _SAFETY * make_interp_spline(linear.database.omega.values, _nearby(values), k=1)(omega)
            for values in _misfits(linear, own)
        )
    return CoefficientError(INTERPOLATION, Coefficients(mass, damping, force.astype(complex)), signed=False)


def _misfits(linear: LinearBuoy, own: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Distances of added mass, damping and excitation of order 0 from what they must be, at the database's omega."""
    ds = linear.database
    omega = ds.omega.values
    found = linear.coefficients(omega)
    pair = np.ix_(np.arange(len(omega)), own, own)
    raw = ds.radiation_damping.values[pair]
    radiated = np.sqrt(_diagonal(raw) / _haskind_factor(linear, omega))
    force = np.abs(radiated - np.abs(found.excitation[:, own]))
    return np.abs(raw - _rank_one(raw)) / omega[:, None, None], np.abs(raw - found.damping[pair]), force


def _nearby(values: FloatArray) -> FloatArray:
    """The largest of neighbours in frequency, a `_NEIGHBOURS`-th of the band to either side."""
    reach = len(values) // _NEIGHBOURS
    return np.asarray(maximum_filter1d(values, 2 * reach + 1, axis=0, mode="nearest"))


def _diagonal(matrices: FloatArray) -> FloatArray:
    """Diagonals, none below zero, shape (omega, dof)."""
    return np.asarray(np.maximum(np.einsum("wii->wi", matrices), 0.0))


def _rank_one(damping: FloatArray) -> FloatArray:
    """The matrix of rank one of the same diagonal, shape (omega, dof, dof)."""
    root = np.sqrt(_diagonal(damping))
    return np.asarray(np.sign(damping) * root[:, :, None] * root[:, None, :])


def _haskind_factor(linear: LinearBuoy, omega: FloatArray) -> FloatArray:
    """Return h = k/(4 rho g v_g), shape (omega, 1) [m^2 s/kg]."""
    attrs = linear.database.attrs
    depth, density, gravity = (float(attrs[name]) for name in ("water_depth", "water_density", "gravity"))
    k, speed = (np.array([of(w, depth, gravity) for w in omega]) for of in (wavenumber, group_velocity))
    return np.asarray(k / (4 * density * gravity * speed))[:, None]
