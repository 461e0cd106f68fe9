"""What can be said of numbers that came in: identities that hold of any body, what they leave open, and likely causes.

Sizes: modes have amplitudes in metres or radians, and some move no water. Added mass of a mode counts in terms of its
median over the band, damping in terms of its largest value, neither below `LEAST_SIZE` squared of what the mode would
have if the displaced water moved with it: yaw of a round body is round-off, and so is all that follows from it.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.errors import ConfigError, DatabaseError
from vsb.hydro import quality
from vsb.hydro.database import Check, check_at_most
from vsb.hydro.formats.haskind import LARGEST_HASKIND, Haskind, fitting_depth, haskind_axisymmetric, haskind_headings
from vsb.hydro.formats.modes import volume_of
from vsb.hydro.retardation import DampingSpectrum
from vsb.study.quantities import RIGID, body_of, motion_of, of_bodies
from vsb.tools.units import BoolArray, FloatArray

LEAST_SIZE = 0.3
"""Of a mode, in terms of the displaced water moving with it, as for bodies from meshes."""
LEAST_DAMPING = 1e-3
"""Of a mode, in terms of frequency times added mass: no panels know it better."""
HELD = 0.05
"""Damping at the ends of a band that holds a mode's damping, in terms of the largest."""
LARGEST_SPIKE = 0.02
"""Distance of added mass and damping from the cubic through their neighbours."""
LONE = 5.0
"""A resonance shows in added mass and damping alike: one of them alone that many times the other is none."""

_CAUSES = {
    "symmetry": "too few panels; files of two runs; rows and columns of a matrix exchanged",
    "afloat": "{density}; {length}; a mooring that carries or pulls",
    "positive_damping": "an irregular frequency{irr}; panels too large for the shortest waves; panels inside out",
    "rank_one": "a body or mode that is not axisymmetric (leave --axisymmetric out); too few panels",
    "irregular_frequencies": "an irregular frequency{irr}; frequencies too far apart for a resonance that is real",
    "kramers_kronig": "{period}; an irregular frequency{irr}; added mass at infinite frequency of another run; panels "
    "too large for the shortest waves",
    "long_waves": "{period}; excitation and stiffness of different runs or lengths",
    "haskind": "{depth}; {length}; {gravity}; {period}; an irregular frequency{irr}; too few panels",
    "haskind_scale": "{length}; {gravity}; too few panels",
    "haskind_long_waves": "{depth}; {length}; {gravity}",
}
WAMIT_WORDS = {
    "density": "--density not that of the run",
    "length": "--length not ULEN",
    "gravity": "--gravity not GRAV",
    "depth": "--depth not HBOT",
    "period": "PER not a column of periods (IPEROUT = 1)",
    "irr": " (IRR = 1 in the run removes it)",
}
BEMIO_WORDS = {
    "density": "rho not that of the run",
    "length": "scaled not what the numbers are",
    "gravity": "g not that of the run",
    "depth": "water_depth not that of the run",
    "period": "w not in rad/s",
    "irr": " (to be removed in the run)",
}


class Sizes(NamedTuple):
    """What errors are measured by."""

    added_mass: FloatArray  # (dof,) [kg], rotations [kg m^2]
    damping: FloatArray  # (dof,) [kg/s]
    wet: BoolArray  # whether a mode moves water, (dof,)

    def of(self, modes: BoolArray) -> "Sizes":
        """Return those of some of the modes."""
        return Sizes(self.added_mass[modes], self.damping[modes], self.wet[modes])


def causes(check: Check, words: dict[str, str]) -> str:
    """Return what may be behind a check that does not hold, in the words of the files the numbers are from."""
    return f"{check.name}: {_CAUSES[check.name].format(**words)}?"


def sizes(ds: xr.Dataset) -> Sizes:
    """Return the sizes of added mass and damping of every mode, and which modes move water.

    Those that move less than a hundredth of `LEAST_SIZE` do not. The displaced water is that of the file, or has the
    largest added mass of a translation; it turns with the cube root of its volume for arm. Generalized modes, scaled
    as their authors like, are compared among themselves, as is what has no translation beside it. Every body has its
    own displaced water.
    """
    omega, labels, density = ds.omega.values, list(map(str, ds.influenced_dof.values)), float(ds.attrs["water_density"])
    own, damping = (np.abs(np.einsum("wii->wi", ds[name].values)) for name in ("added_mass", "radiation_damping"))
    mass, largest = np.median(own, axis=0), damping.max(axis=0)
    least, moves = np.zeros(len(labels)), np.array([motion_of(label) for label in labels])
    for body, places in of_bodies(labels).items():
        its = np.isin(np.arange(len(labels)), places)
        shift, turn = its & np.isin(moves, RIGID[:3]), its & np.isin(moves, RIGID[3:])
        displaced = density * float(ds.attrs.get(volume_of(body), 0.0)) or float(mass[shift].max(initial=0.0))
        arm = (displaced / density) ** (1 / 3)
        for kind, whole in ((shift, displaced), (turn, displaced * arm**2), (its & ~shift & ~turn, 0.0)):
            least[kind] = LEAST_SIZE**2 * (whole or mass[kind].max(initial=0.0))
    size = np.maximum(mass, least)
    floor = LEAST_DAMPING * omega[damping.argmax(axis=0)] * size
    return Sizes(size, np.maximum(largest, floor), (mass > 1e-4 * least) & (largest > 0))


def foreign_checks(ds: xr.Dataset, *, axisymmetric: bool = False) -> tuple[list[Check], list[str]]:
    """Return the checks that a database of another code allows, and a line on each of what they leave unchecked.

    Damping follows from excitation (Haskind) by an integral over all wave directions, which one direction replaces if
    the body and all generalized modes are `axisymmetric`; damping of heave and these, one radiation channel, then also
    has rank one. Added mass follows from damping (Kramers and Kronig), wherever the band holds it.

    Raises
    ------
    ConfigError
        If the motions are said to be axisymmetric, and none can be.
    """
    ds = ds.sel(omega=ds.omega > 0)
    radiating = np.einsum("wii->wi", ds.radiation_damping.values).any(axis=0)
    if not radiating.any():
        raise DatabaseError("radiation damping is zero for all motions; needs coefficients of waves.")
    size = sizes(ds)
    wet = ds.isel(influenced_dof=radiating, radiating_dof=radiating)
    among = size.of(radiating)
    checks = [_symmetry(ds, size), *afloat_checks(ds), _positive(wet, among)]
    ring = _ring(wet) if axisymmetric else np.ones(wet.sizes["influenced_dof"], dtype=bool)
    part, its = wet.isel(influenced_dof=ring, radiating_dof=ring), among.of(ring)
    if axisymmetric:
        channel = quality.second_channel(part, np.sqrt(np.outer(its.damping, its.damping)))
        checks.append(check_at_most("rank_one", channel, 0.02, "-", "axisymmetric motions radiate one ring wave"))
    parts = [_smooth(wet, among), _causal(wet, among), _lifting(ds, size), _haskind(part, its, axisymmetric)]
    unseen = [] if any(check.name == "afloat" for check in checks) else [_DENSITY]
    return [*checks, *(check for found, _ in parts for check in found)], [
        line for _, notes in parts for line in notes
    ] + unseen


_DENSITY = "not checked: density, with which all coefficients grow alike; it needs mass in heave and displaced volume"


def _ring(wet: xr.Dataset) -> BoolArray:
    """Modes of an axisymmetric body that send out ring waves, (dof,)."""
    labels = wet.influenced_dof.values
    ring = np.array([label == "Heave" or label not in RIGID for label in labels])
    if not ring.any():
        raise ConfigError(f"--axisymmetric: received {', '.join(labels)}; needs heave or modes.")
    return ring


def _where(ds: xr.Dataset, error: FloatArray) -> str:
    """Frequency and modes of the largest error, (omega, dof) or (omega, dof, dof)."""
    w, *modes = (int(i) for i in np.unravel_index(int(np.argmax(error)), error.shape))
    names = dict.fromkeys(str(ds.influenced_dof.values[i]) for i in modes)
    return f"most at {ds.omega.values[w]:.4g} rad/s in {' and '.join(names)}"


def _symmetry(ds: xr.Dataset, size: Sizes) -> Check:
    """Symmetry of the radiation impedance, in terms of the impedances of both motions."""
    omega = ds.omega.values[:, None, None]
    impedance = ds.radiation_damping.values + 1j * omega * ds.added_mass.values
    least = LEAST_DAMPING * ds.omega.values[:, None] * size.added_mass
    z = np.maximum(np.abs(np.einsum("wii->wi", impedance)), least)
    pair = np.sqrt(z[:, :, None] * z[:, None, :])
    error = np.abs(impedance - impedance.transpose(0, 2, 1))
    error = np.divide(error, pair, out=np.zeros_like(error), where=pair > 0)
    text = f"added mass and damping are symmetric matrices; {_where(ds, error)}"
    return check_at_most("symmetry", error.max(), 0.02, "-", text, doubt=True)


def afloat_checks(ds: xr.Dataset) -> list[Check]:
    """Return the check of mass in heave against the water displaced, of bodies of which a database has both.

    A moored one may weigh less, which is a doubt first.
    """
    errors, labels = [], list(map(str, ds.influenced_dof.values))
    for i in [i for i, label in enumerate(labels) if motion_of(label) == "Heave" and "inertia_matrix" in ds]:
        volume = float(ds.attrs.get(volume_of(body_of(labels[i])), 0.0))
        mass = float(ds.inertia_matrix.values[i, i])
        if volume and mass:  # not stated, as in the files of rigid bodies
            errors.append(abs(mass / (float(ds.attrs["water_density"]) * volume) - 1))
    text = "mass in heave is that of the water displaced"
    return [check_at_most("afloat", max(errors), 0.01, "-", text, doubt=True)] if errors else []


def _positive(wet: xr.Dataset, size: Sizes) -> Check:
    """Damping as a positive semidefinite matrix."""
    lowest = -quality.scaled_eigenvalues(wet, np.sqrt(np.outer(size.damping, size.damping)))[:, 0]
    text = f"no motion can draw energy from calm water; most at {wet.omega.values[lowest.argmax()]:.4g} rad/s"
    return check_at_most("positive_damping", max(0.0, lowest.max()), 0.01, "-", text)


def _smooth(wet: xr.Dataset, size: Sizes) -> tuple[list[Check], list[str]]:
    """Spikes of added mass and damping: a doubt if both have one, a failure if only one of them has."""
    omega = wet.omega.values
    if len(omega) < 5:
        return [], [f"not checked: irregular_frequencies, which needs five frequencies; received {len(omega)}"]
    mass, damping = (np.einsum("wii->wi", wet[name].values) for name in ("added_mass", "radiation_damping"))
    kinks = np.stack([quality.kinks(omega, mass), quality.kinks(omega, damping)])
    error = np.max(kinks / np.stack([size.added_mass, size.damping])[:, None], axis=0)
    kinks[1] /= omega[2:-2, None]  # [kg]
    around = [np.pad(kinks, ((0, 0), (2, 2), (0, 0)))[:, k : k + len(omega) - 4] for k in range(5)]
    low, high = np.sort(np.max(around, axis=0), axis=0)
    alone = (high > LONE * low) & (error > 5 * LARGEST_SPIKE)
    found = np.where(alone, error, 0.0) if alone.any() else error
    text = "added mass and damping are smooth; an irregular frequency is a spike"
    text += f", here of one without the other; {_where(wet.isel(omega=slice(2, -2)), found)}" * bool(alone.any())
    text += f"; {_where(wet.isel(omega=slice(2, -2)), found)}" * bool(not alone.any())
    check = check_at_most("irregular_frequencies", found.max(), LARGEST_SPIKE, "-", text)
    return [replace(check, verdict="doubt") if check.verdict == "fail" and not alone.any() else check], []


def _causal(wet: xr.Dataset, size: Sizes) -> tuple[list[Check], list[str]]:
    """Added mass from damping by Kramers and Kronig over the whole band, of modes whose damping the band holds.

    What the steps of frequency do to the integral is its change when every other one is left out.
    """
    omega, damping = wet.omega.values, wet.radiation_damping.values
    if len(omega) < 10:
        return [], [f"not checked: kramers_kronig, which needs ten frequencies; received {len(omega)}"]
    own = np.abs(np.einsum("wii->wi", damping))
    held = np.maximum(own[0], own[-1]) <= HELD * size.damping
    change = DampingSpectrum(omega, damping).added_mass_difference(omega)
    fewer = slice(1 - len(omega) % 2, None, 2)  # the last one stays
    coarse = DampingSpectrum(omega[fewer], damping[fewer]).added_mass_difference(omega) - change
    resolved = np.abs(np.einsum("wii->wi", coarse)).max(axis=0) <= quality.LARGEST_LIMIT_DIFFERENCE * size.added_mass
    names = wet.influenced_dof.values
    notes = [
        f"not checked: kramers_kronig of {', '.join(names[left])}, whose damping {why}"
        for left, why in ((~held, "lasts beyond the band"), (held & ~resolved, "needs smaller steps of frequency"))
        if left.any()
    ]
    kept = np.flatnonzero(held & resolved)
    if not kept.size:
        return [], notes
    limit = wet.added_mass.values - change
    known = wet.added_mass_inf.values if "added_mass_inf" in wet else np.median(limit, axis=0)
    root = np.sqrt(size.added_mass)
    error = (np.abs(limit - known) / np.outer(root, root))[:, kept[:, None], kept]
    text = f"added mass follows from damping; {_where(wet.isel(influenced_dof=kept), error)}"
    return [
        check_at_most("kramers_kronig", error.max(), quality.LARGEST_LIMIT_DIFFERENCE, "-", text, doubt=True)
    ], notes


def _lifting(ds: xr.Dataset, size: Sizes) -> tuple[list[Check], list[str]]:
    """Heave excitation in the longest wave, C - omega^2 (A + displaced water) to second order, against stiffness C.

    The limit is widened by twice the second order, with the largest added mass of a translation for that of the water.
    Of several bodies the worst counts, and those alone whose longest wave is one.
    """
    labels, stiffness = list(map(str, ds.influenced_dof.values)), np.diag(ds.hydrostatic_stiffness.values)
    heaves = [i for i, label in enumerate(labels) if motion_of(label) == "Heave" and stiffness[i] > 0]
    if not heaves:
        return [], ["not checked: long_waves, which needs heave and a waterplane"]
    found = []
    for i in heaves:
        its = of_bodies(labels)[body_of(labels[i])]
        water = max(size.added_mass[j] for j in its if motion_of(labels[j]) in RIGID[:3])
        second = float(ds.omega.values[0] ** 2 * (size.added_mass[i] + water) / stiffness[i])
        error = float(np.abs(np.abs(ds.excitation_force.values[0, :, i]) / stiffness[i] - 1).max())
        found += [(error, 0.05 + 2 * second)] if second <= 0.2 else []
    if not found:
        return [], [f"not checked: long_waves, of which {ds.omega.values[0]:.4g} rad/s is none for this body"]
    error, limit = max(found, key=lambda one: one[0] - one[1])
    text = "waves much longer than the body lift it by its hydrostatic stiffness"
    return [check_at_most("long_waves", error, limit, "-", text)], []


_TOO_FEW = (
    "not checked: haskind, the only check that sees a wrong length, gravity or depth: it needs wave directions in "
    "fine, equal steps all around, or one direction and --axisymmetric; received {}"
)


def _haskind(part: xr.Dataset, size: Sizes, axisymmetric: bool) -> tuple[list[Check], list[str]]:
    """Damping from excitation where the headings resolve it: its largest error, its scale, and that of long waves."""
    water = {"depth": float(part.attrs["water_depth"]), "gravity": float(part.attrs["gravity"])}
    density = float(part.attrs["water_density"])
    found = haskind_axisymmetric(part, density=density, **water) if axisymmetric else None
    if found is None:
        found = haskind_headings(part, size.damping, density=density, **water)
    large = np.abs(np.einsum("wii->wi", part.radiation_damping.values)) > 0.1 * size.damping
    if found is None or not (found.resolved & large).any():
        return [], [_TOO_FEW.format(part.sizes["wave_direction"])]
    both = found.resolved[:, :, None] & found.resolved[:, None, :]
    error = np.abs(found.damping - part.radiation_damping.values) * both
    error /= np.sqrt(np.outer(size.damping, size.damping))
    text = f"damping follows from excitation; {_where(part, error)}"
    checks = [check_at_most("haskind", error.max(), LARGEST_HASKIND, "-", text)]
    return checks + _ratios(part, found, size.wet, **water), _skipped(part, found)


def _skipped(part: xr.Dataset, found: Haskind) -> list[str]:
    """A line on the modes and frequencies the headings do not resolve, if any."""
    n, omega = part.sizes["omega"], part.omega.values
    missing = [
        f"{label} ({np.count_nonzero(~held)} of {n} frequencies, from {omega[~held][0]:.4g} rad/s)"
        for label, held in zip(part.influenced_dof.values, found.resolved.T, strict=True)
        if not held.all()
    ]
    few = (
        f"not checked: haskind of {', '.join(missing)}, which {part.sizes['wave_direction']} directions do not resolve"
    )
    return [few] * bool(missing)


def _ratios(part: xr.Dataset, found: Haskind, wet: BoolArray, *, depth: float, gravity: float) -> list[Check]:
    """Ratio of damping from excitation to damping: its median, which length/gravity multiplies, and in long waves."""
    theirs, own = (np.einsum("wii->wi", b) for b in (found.damping, part.radiation_damping.values))
    largest = np.abs(own).max(axis=0)
    share = np.divide(own, largest, out=np.zeros_like(own), where=found.resolved & wet & (largest > 0))
    if not (share > 0.1).any():
        return []
    ratio = np.divide(theirs, own, out=np.ones_like(own), where=share > 0)
    scale = float(np.median(ratio[share > 0.1]))
    text = f"excitation and damping have one scale; length/gravity is {scale:.4g} times that of the run"
    checks = [check_at_most("haskind_scale", abs(scale - 1), 0.01, "-", text, doubt=True)]
    modes = np.flatnonzero((share > 0.03).any(axis=0))
    first = (share > 0.03).argmax(axis=0)[modes]
    longest, omega = ratio[first, modes], part.omega.values[first]
    error = float(np.abs(longest - 1).max())
    worst = int(np.abs(longest - 1).argmax())
    text = "so they do in the longest waves, which feel the depth; "
    text += f"most at {omega[worst]:.4g} rad/s in {part.influenced_dof.values[modes[worst]]}"
    if error > LARGEST_HASKIND and (other := fitting_depth(longest, omega, depth, gravity)):
        text += f"; {other:.3g} m would fit" if np.isfinite(other) else "; deep water would fit"
    return [*checks, check_at_most("haskind_long_waves", error, LARGEST_HASKIND, "-", text, doubt=True)]
