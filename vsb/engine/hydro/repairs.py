"""Repairs of coefficients that a study requests by the name of the check that failed: bounded and recorded.

Noise of panels, of single precision and of iterative solvers makes damping slightly negative and added mass
inconsistent with damping. A motion's added mass may be right to four digits and its memory, the part that depends on
frequency, to two. Repairs are made only on request and only within the size of noise; the stiffness of still water
alone is always made symmetric, for its asymmetry is no matter of precision. Phases of the other sign are no noise:
their repair is exact, and the check that failed must then hold.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from vsb.engine.hydro.database import Check, with_history
from vsb.engine.hydro.formats.checks import sizes
from vsb.engine.hydro.radiation import DampingSpectrum
from vsb.engine.hydro.variables import PAIR, is_rigid
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray

LARGEST_CHANGE = {"positive_damping": 0.2, "kramers_kronig": 0.1}
"""Largest change of damping, relative to both motions' largest, and of added mass, relative to both motions' own."""
_LEAST = 1e-12  # eigenvalue that replaces a negative one, relative to the motions' largest damping
_ROUNDS = 100
_EVEN, _UNEVEN = 1e-6, 0.02  # asymmetry taken as round-off, and from which on it is a doubt, relative
_BETWEEN = np.arange(1, 8) / 8  # places between two frequencies
FEWEST = 10
"""Frequencies that a transform of damping needs."""


def with_passive_damping(ds: xr.Dataset) -> xr.Dataset:
    """Return a database whose damping draws no energy from calm water, and the repair in its history.

    At every frequency the nearest damping without an eigenvalue below a floor (Higham 1988), with distances measured in
    the motions' largest damping. The floor is round-off, and more around frequencies between which a cubic spline would
    draw energy. Motions that move no water remain without damping, which must be symmetric. Raises `ConfigError` if
    splines stay negative.
    """
    omega, size, damping = ds.omega.values, sizes(ds), ds.radiation_damping.values
    wet = np.flatnonzero(size.wet)
    scale = np.sqrt(np.outer(size.damping, size.damping))[wet[:, None], wet]
    own = damping[:, wet[:, None], wet] / scale
    values, vectors = np.linalg.eigh(own)
    floor = np.zeros(len(omega))
    inside = omega[:-1] + _BETWEEN[:, None] * np.diff(omega)
    for _ in range(_ROUNDS):
        lifted = np.maximum(np.where(values < 0, _LEAST, values), floor[:, None])
        changed = np.asarray((lifted > values).any(axis=1))
        assembled = np.einsum("wim,wm,wjm->wij", vectors, lifted, vectors)
        kept = np.where(changed[:, None, None], assembled, own)
        least = np.linalg.eigvalsh(CubicSpline(omega, kept)(inside))[..., 0].min(axis=0)
        if (least > 0).all():
            break
        lacking = np.maximum(-1.5 * least, 0.0)
        floor = floor + np.maximum(np.append(lacking, 0.0), np.append(0.0, lacking))
    else:
        raise ConfigError(
            f"hydro.repair: positive_damping leaves damping that is negative between the frequencies, up to "
            f"{omega[-1]:.4g} rad/s; needs smaller steps of frequency, or a lower hydro.omega_max"
        )
    mended = np.where(np.outer(size.wet, size.wet), damping, 0.0)
    mended[np.ix_(changed, wet, wet)] = kept[changed] * scale  # the others stay as they are
    count = f"{np.count_nonzero(changed)} of {len(omega)} frequencies"
    mended_at = ds.assign(radiation_damping=(("omega", *PAIR), mended))
    return with_history(mended_at, f"damping made positive definite at {count}")


def with_causal_added_mass(ds: xr.Dataset) -> xr.Dataset:
    """Return a database whose added mass follows from its damping (Kramers, Kronig), and the repair in its history.

    Added mass at infinite frequency is the median over the band of added mass less what follows from damping. Raises
    `ConfigError` if there are fewer than ten frequencies.
    """
    omega = ds.omega.values
    check_repairable(["kramers_kronig"], omega)
    change = DampingSpectrum(omega, ds.radiation_damping.values).added_mass_difference(omega)
    limit = np.median(ds.added_mass.values - change, axis=0)
    made = {"added_mass": (("omega", *PAIR), limit + change), "added_mass_inf": (PAIR, limit)}
    return with_history(ds.assign(made), "added mass made that of the damping by Kramers and Kronig")


def with_conjugated_forces(ds: xr.Dataset) -> tuple[xr.Dataset, Check]:
    """Return a database with the complex conjugates of its wave forces, to be checked anew, and a doubt that says so.

    Whoever writes phasors as exp(+i omega t) states phases of the other sign. If the file's phases were right, the
    check of `phases` now fails.
    """
    forces = [name for name in ("excitation_force", "Froude_Krylov_force", "diffraction_force") if name in ds]
    mended = with_history(ds.assign({name: np.conj(ds[name]) for name in forces}), "wave forces conjugated")
    mended.attrs.pop("quality", None)
    text = f"{', '.join(forces)} replaced by their complex conjugates"
    return mended, Check("repaired phases", 0.0, 0.0, "-", "doubt", text)


def with_symmetric_stiffness(ds: xr.Dataset) -> tuple[xr.Dataset, list[Check]]:
    """Return a database whose hydrostatic stiffness is symmetric, as that of an energy, and a doubt if it was not.

    WAMIT's is C_ij = rho g int psi_j.n (w_i + z div psi_i) dS (Newman 1994). For a rigid motion i that is exact, but
    for weight. Its transpose lacks the work of the load at rest in the bending body: surging in still water, WAMIT's
    barge would bend. So the rows of rigid motions are kept, and means taken where both modes are generalized.
    """
    c = ds.hydrostatic_stiffness.values
    labels = list(map(str, ds.influenced_dof.values))
    rigid = np.array([is_rigid(label) for label in labels])
    own = np.sqrt(np.maximum(np.abs(c).max(axis=0), np.abs(c).max(axis=1)) + 1e-300)
    uneven = np.abs(c - c.T) / np.outer(own, own)
    even = np.where(np.outer(rigid, ~rigid), c, np.where(np.outer(~rigid, rigid), c.T, 0.5 * (c + c.T)))
    mended = ds.assign(hydrostatic_stiffness=(PAIR, even))
    if uneven.max() <= _EVEN:
        return mended, []
    i, j = np.unravel_index(int(uneven.argmax()), uneven.shape)
    text = f"stiffness of still water is symmetric, as an energy's; most between {labels[i]} and {labels[j]}; made so"
    largest = float(uneven.max())
    check = Check("hydrostatic_symmetry", largest, _UNEVEN, "-", "doubt" if largest > _UNEVEN else "ok", text)
    return with_history(mended, "hydrostatic stiffness made symmetric"), [check]


_REPAIRS: dict[str, tuple[Callable[[xr.Dataset], xr.Dataset], str, str, str]] = {
    "positive_damping": (
        with_passive_damping, "radiation_damping", "damping", "damping, in terms of both motions' largest"
    ),
    "kramers_kronig": (with_causal_added_mass, "added_mass", "added_mass", "added mass, in terms of both motions' own"),
}  # fmt: skip
"""Repair by the check's name: function, variable, its measure among `sizes`, and what changes in words."""


def check_repairable(names: Sequence[str], omega: FloatArray) -> None:
    """Check that the repairs named can be made at so many frequencies [rad/s]; `ConfigError`."""
    if "kramers_kronig" in names and len(omega) < FEWEST:
        raise ConfigError(f"hydro.repair: kramers_kronig needs {FEWEST} frequencies, received {len(omega)}")


def repaired(ds: xr.Dataset, names: Sequence[str]) -> tuple[xr.Dataset, list[Check]]:
    """Return a database with the repairs named, damping first, and a doubt on each with the size of its change.

    Raises `ConfigError` if a change is more than `LARGEST_CHANGE`.
    """
    checks = []
    for name in [name for name in _REPAIRS if name in names]:
        repair, variable, measure, what = _REPAIRS[name]
        root = np.sqrt(getattr(sizes(ds), measure))
        mended = repair(ds)
        difference = np.abs(mended[variable].values - ds[variable].values)
        change = (difference / np.outer(root, root)).max(axis=(1, 2))
        at = f"most at {float(ds.omega.values[change.argmax()]):.4g} rad/s"
        largest, limit = float(change.max()), LARGEST_CHANGE[name]
        if largest > limit:
            raise ConfigError(
                f"hydro.repair: {name} would change {what}, by {largest:.2g} ({at}), needs at most {limit:g}, "
                "the size of noise: choose other degrees of freedom or hydro.omega_max, or solve the coefficients again"
            )
        checks.append(Check(f"repaired {name}", largest, limit, "-", "doubt", f"largest change of {what}; {at}"))
        ds = mended
    return ds, checks


def failures_as_doubts(checks: Sequence[Check], names: Sequence[str]) -> list[Check]:
    """Return checks of the original coefficients, failures of those repaired as doubts: what failed is not used."""
    return [
        replace(check, verdict="doubt", explanation=f"{check.explanation}; repaired")
        if check.verdict == "fail" and check.name in _REPAIRS and check.name in names
        else check
        for check in checks
    ]
