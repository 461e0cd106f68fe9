"""Verdict on a hydro database: identities that hold for any mesh, and how far the numbers are from them.

Coefficients of different modes are compared after scaling the largest damping of every degree of freedom to one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from vsb.engine.hydro.database import Check, check_at_most
from vsb.engine.hydro.dofs import multiplicity
from vsb.engine.hydro.radiation import DampingSpectrum
from vsb.engine.hydro.sweep import joined
from vsb.engine.hydro.variables import is_of_ring
from vsb.engine.waves.water import Water, haskind_factor
from vsb.errors import DatabaseError
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray

LARGEST_LIMIT_DIFFERENCE = 0.02
"""Largest difference of added mass at infinite frequency from its extrapolation, as for Kramers-Kronig."""

FEWEST = 5
"""Frequencies of which a misfit about two terms is known."""
_DOUBTS = ("error_estimate", "limit_difference")
_LOWER = "lower hydro.tolerance or raise hydro.rows, change hydro.omega_max, deepen water the keel hardly clears"
_ADVICE = {
    "kramers_kronig": "raise hydro.omega_max: the band must reach beyond the peak of damping",
    "interpolation_error": "raise hydro.tolerance, change hydro.omega_max",
    "phases": "mend the file's headings",
    "added_mass_limits": "exchange the rows of zero and infinite frequency in the file",
    "parts": "make the file again of one run",
    "rotation_centre": "correct the centre of mass, or the point of the moments, in the file",
    "waterplane": "correct the centres in the file",
    "mass_coupling": "correct the mass matrix, or the centre of mass",
    "places": "make the file again with phases about one origin",
    "displaced_volume": "correct the volume in the file, or its length scale",
    "displaced_mass": "correct the mass, or how deep the mesh lies",
    "rigid_names": "correct the names of the displacements",
    "lid": "use smaller panels, or lid: 0 and frequencies below the first irregular one",
    "closure": "close the mesh there",
    "corners": "correct the displacements: of panels and of corners they are two",
}


def _scale(ds: xr.Dataset) -> FloatArray:
    """Outer product that scales the largest damping of each degree of freedom to one, shape (dof, dof)."""
    root = np.sqrt(np.abs(np.einsum("wii->wi", ds.radiation_damping.values)).max(axis=0))
    return np.outer(root, root)


def scaled_eigenvalues(ds: xr.Dataset, scale: FloatArray) -> FloatArray:
    """Return the eigenvalues of the damping over `scale`, ascending, in terms of the band's largest, (omega, dof)."""
    b = ds.radiation_damping.values
    values = np.linalg.eigvalsh(0.5 * (b + b.transpose(0, 2, 1)) / scale)
    return np.asarray(values / np.abs(values).max())


def asymmetry(ds: xr.Dataset) -> float:
    """Return the largest |M - M^T| of A and B relative to the largest entry of the band."""
    matrices = [ds.added_mass.values, ds.radiation_damping.values]
    return max(float(np.abs(m - m.transpose(0, 2, 1)).max() / np.abs(m).max()) for m in matrices)


def negative_damping(ds: xr.Dataset, scale: FloatArray | None = None) -> float:
    """Return how far the damping is from positive semidefinite: -(smallest eigenvalue), at least 0.

    Entries are divided by `scale`, shape (dof, dof); by default the largest damping of every motion becomes one.
    """
    return float(max(0.0, -scaled_eigenvalues(ds, _scale(ds) if scale is None else scale).min()))


def second_channel(ds: xr.Dataset, scale: FloatArray | None = None) -> float:
    """Return the largest second eigenvalue of the damping: an axisymmetric body has one radiation channel, rank one.

    Scaled as in `negative_damping`.
    """
    values = np.sort(np.abs(scaled_eigenvalues(ds, _scale(ds) if scale is None else scale)), axis=1)
    return float(values[:, -2].max()) if values.shape[1] > 1 else 0.0


def haskind_damping(ds: xr.Dataset, depth: float, density: float, gravity: float, order: int = 0) -> ComplexArray:
    """Return Haskind's damping from the excitation by waves to +x, real but for errors, (omega, dof, dof) [kg/s].

    B = k/(8 pi rho g v_g) int X X^H d beta over the directions beta, where X goes with cos(m beta): for order m = 0
    k X X^H/(4 rho g v_g), for m >= 1 half of that.
    """
    x = ds.excitation_force.values[:, 0, :]
    factor = haskind_factor(ds.omega.values, depth, density, gravity) / multiplicity(order)
    return np.asarray(factor[:, None, None] * x[:, :, None] * x[:, None, :].conj())


def haskind_difference(ds: xr.Dataset, depth: float, density: float, gravity: float, order: int = 0) -> float:
    """Return the largest difference between the damping and Haskind's."""
    haskind = haskind_damping(ds, depth, density, gravity, order)
    return float(np.abs((haskind - ds.radiation_damping.values) / _scale(ds)).max())


def kinks(omega: FloatArray, values: FloatArray) -> FloatArray:
    """Return the distances of values from the cubic through their four neighbours in frequency, (omega - 4, ...).

    An irregular frequency is a spike a few hundredths of a rad/s wide that its neighbours do not have.
    """
    place = np.array([0, 1, 3, 4])
    windows = np.lib.stride_tricks.sliding_window_view(omega, 5)
    x, here = windows[:, place], windows[:, 2]
    weights = np.array(
        [np.prod([(here - x[:, m]) / (x[:, n] - x[:, m]) for m in range(4) if m != n], 0) for n in range(4)]
    )
    neighbours = sum(
        weight[(...,) + (None,) * (values.ndim - 1)] * values[k : k + len(here)]
        for k, weight in zip(place, weights, strict=True)
    )
    return np.asarray(np.abs(values[2:-2] - neighbours))


def by_ogilvie(ds: xr.Dataset) -> FloatArray:
    """Return A(inf) by Ogilvie's relation, the mean over the lower half of the band, shape (dof, dof)."""
    half = _lower_half(ds)
    spectrum = DampingSpectrum(ds.omega.values, ds.radiation_damping.values)
    change = np.tensordot(spectrum.added_mass_shares(ds.omega.values[half]).mean(axis=0), spectrum.damping, 1)
    return np.asarray(ds.added_mass.values[half].mean(axis=0) - change)


def _lower_half(ds: xr.Dataset) -> BoolArray:
    """Which frequencies are in the lower half of the band, shape (omega,)."""
    return np.asarray(ds.omega.values <= 0.5 * ds.omega.values[-1])


def unlike_ogilvie(ds: xr.Dataset) -> float:
    """Return the misfit of Ogilvie's relation along the lower half of the band, of shapes beside loads alone.

    Relative to the diagonal of A(inf). Their A(inf) is that of the relation, whose mean says nothing of them: damping
    beyond the band adds a constant and a part with omega^2 to it, all else is a misfit.
    """
    ring = np.array([is_of_ring(str(label)) for label in ds.influenced_dof.values])
    half, omega = _lower_half(ds), ds.omega.values
    if not ring.any() or half.sum() < FEWEST:
        return 0.0
    shares = DampingSpectrum(omega, ds.radiation_damping.values).added_mass_shares(omega[half])
    root = np.sqrt(np.diag(ds.added_mass_inf.values))
    found = 0.0
    for i in np.flatnonzero(ring):
        limit = (ds.added_mass.values[half, i] - shares @ ds.radiation_damping.values[:, i]) / (root[i] * root)
        beyond = np.stack([np.ones(half.sum()), omega[half] ** 2], axis=1)
        left = limit - beyond @ np.linalg.lstsq(beyond, limit, rcond=None)[0]
        found = max(found, float(np.abs(left).max()))
    return found


def added_mass_difference(ds: xr.Dataset) -> float:
    """Return A(inf) solved minus A(inf) by Ogilvie's relation, relative to the diagonal of A(inf)."""
    root = np.sqrt(np.diag(ds.added_mass_inf.values))
    return float(np.abs((by_ogilvie(ds) - ds.added_mass_inf.values) / np.outer(root, root)).max())


def identity_check(name: str, value: float, limit: float, precision: float, explanation: str) -> Check:
    """Return the check of an identity: ok to a fraction `precision` of its limit, a failure above all of it."""
    held = check_at_most(name, value, limit, "-", explanation)
    if held.verdict == "fail":
        return held
    strict = check_at_most(name, value, precision * limit, "-", explanation)
    return strict if strict.verdict == "ok" else replace(strict, verdict="doubt")


def pointwise_checks(ds: xr.Dataset, water: Water, precision: float = 1.0, order: int = 0) -> list[Check]:
    """Return the checks that hold at every frequency by itself, to a fraction `precision` of what panels hold them."""
    haskind = haskind_difference(ds, water.depth, water.density, water.gravity, order)
    held = [
        ("symmetry", asymmetry(ds), 0.01, "added mass and damping are symmetric matrices"),
        ("positive_damping", negative_damping(ds), 0.01, "no motion can draw energy from calm water"),
        ("rank_one", second_channel(ds), 0.02, "axisymmetric motions radiate one ring wave"),
        ("haskind", haskind, 0.05, "damping follows from excitation"),
    ]
    return [identity_check(name, value, limit, precision, text) for name, value, limit, text in held]


def sweep_checks(sweep: xr.Dataset, precision: float = 1.0) -> list[Check]:
    """Return the checks that need the whole band, in equal steps; what lies above it keeps a tenth of the limit."""
    damping = np.einsum("wii->wi", sweep.radiation_damping.values / _scale(sweep))
    kink = kinks(sweep.omega.values, damping).max() if len(damping) >= 5 else 0.0
    misfit = max(added_mass_difference(sweep), unlike_ogilvie(sweep))
    smooth = "damping is smooth; an irregular frequency is a spike in it"
    ogilvie = "Ogilvie: added mass at infinity follows from damping"
    return [
        check_at_most("irregular_frequencies", kink, 0.02, "-", smooth),
        identity_check("kramers_kronig", misfit, 0.02, max(precision, 0.1), ogilvie),
    ]


def estimate_checks(blocks: Sequence[Mapping[str, Any]], tolerance: float) -> list[Check]:
    """Return the checks of the errors solver and sweep estimate of themselves, from the blocks' attributes.

    A tolerance that the solver does not reach, as may happen with panels, is a doubt. So is a band from which the
    limits cannot be extrapolated: those used are solved directly.
    """
    solves, frequencies = (sum(int(attrs.get(key, 0)) for attrs in blocks) for key in ("solves", "frequencies"))
    meaning = {
        "error_estimate": "estimated error of added mass, damping and excitation, relative to the largest entry; "
        f"{solves} solves for {frequencies} frequencies",
        "interpolation_error": "estimated error of interpolation between frequencies solved, relative to the band's "
        "largest entry",
        "limit_difference": "difference of added mass extrapolated to frequencies 0 and ∞ from that solved there",
    }
    limit = dict.fromkeys(meaning, tolerance) | {"limit_difference": LARGEST_LIMIT_DIFFERENCE}
    found = {name: [float(attrs[name]) for attrs in blocks if name in attrs] for name in meaning}
    checks = [check_at_most(name, max(e), limit[name], "-", meaning[name]) for name, e in found.items() if e]
    return [replace(c, verdict="doubt") if c.verdict == "fail" and c.name in _DOUBTS else c for c in checks]


def judged(
    checks: Sequence[Check], accept: Sequence[str], remedy: str = _LOWER, repairable: Sequence[str] = ()
) -> list[Check]:
    """Return the checks with failures the study accepts by name marked as such.

    Raises `DatabaseError` if a check fails that the study does not accept.

    Parameters
    ----------
    remedy : str
        Remedy where a check has no advice of its own; that of a buoy if not given.
    repairable : sequence of str
        Checks whose cause the study may have repaired.
    """
    checks = [replace(c, verdict="accepted") if c.verdict == "fail" and c.name in accept else c for c in checks]
    for check in checks:
        if check.verdict == "fail":
            advice = _ADVICE.get(check.name, remedy)
            advice += f", have it repaired (hydro.repair: [{check.name}])" if check.name in repairable else ""
            raise DatabaseError(
                f"hydro database: check {check.name!r} failed: {check.value:.3g}, needs at most {check.limit:g} "
                f"({check.explanation}); {advice}, or list the name under hydro.accept."
            )
    return checks


def verdict(
    sweep: xr.Dataset, tabulated: xr.Dataset | None, water: Water, precision: float = 1.0, order: int = 0
) -> list[Check]:
    """Return the checks of a database, before it is symmetrized: its sweep and any frequencies tabulated.

    Of one azimuthal order, and of what moves water; checks of orders m >= 1 say which.
    """
    everywhere = sweep if tabulated is None else joined(sweep, tabulated)
    checks = pointwise_checks(everywhere, water, precision, order) + sweep_checks(sweep, precision)
    return [replace(c, explanation=f"order {order}: {c.explanation}") for c in checks] if order else checks
