"""What can be said of numbers that came in: identities that hold of any body, what they leave open, and likely causes.

Sizes: modes have amplitudes in metres or radians, and some move no water. Added mass of a mode counts in terms of its
median over the band, damping in terms of its largest value, neither below `LEAST_SIZE` squared of what the mode would
have if the displaced water moved with it: yaw of a round body is round-off, and so is all that follows from it.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.errors import ConfigError, DatabaseError
from vsb.hydro import quality
from vsb.hydro.database import Check, check_at_most
from vsb.hydro.formats.haskind import LARGEST_HASKIND, Haskind, fitting_depth, haskind_axisymmetric, haskind_headings
from vsb.hydro.formats.long_waves import lift_check, phase_check, volume_check
from vsb.hydro.formats.modes import volume_of
from vsb.hydro.retardation import DampingSpectrum
from vsb.study.quantities import RIGID, body_of, motion_of, of_bodies
from vsb.tools.arrays import BoolArray, FloatArray

LEAST_SIZE = 0.3
"""Of a mode, in terms of the displaced water moving with it, as for bodies from meshes."""
LEAST_DAMPING = 1e-3
"""Of a mode, in terms of frequency times added mass: no panels know it better."""
HELD, FALLEN = 0.05, 0.5
"""Damping at the ends of a band that holds a mode's damping, and of one that has seen it fall, of the largest."""
LARGEST_UNKNOWN = 0.2
"""Added mass that damping outside the band and between the steps may give, of a mode's own, where enough is known."""
LARGEST_UNAFLOAT = 0.2
"""Difference of a body's mass from that of the water displaced that a mooring or coarse panels may make."""
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
    "kramers_kronig": "{period}; an irregular frequency{irr}; added mass at infinite frequency of another run or "
    "exchanged with that at zero; panels too large for the shortest waves",
    "added_mass_limits": "added mass at zero and at infinite frequency exchanged",
    "long_waves": "{period}; excitation and stiffness of different runs or lengths",
    "phases": "phases of the other sign; headings in another unit; the force of another body or run",
    "displaced_volume": "{length}; the volume of another body or run",
    "trim": "centres of another body or about another origin; a mooring that carries or pulls",
    "parts": "parts of another run; phases of the other sign in one of them",
    "hydrostatic_symmetry": "rows and columns exchanged; a body that does not float upright",
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


def foreign_checks(
    ds: xr.Dataset, *, axisymmetric: bool = False, dofs: Sequence[str] | None = None
) -> tuple[list[Check], list[str]]:
    """Return the checks that a database of another code allows, and a line on each of what they leave unchecked.

    Damping follows from excitation (Haskind) by an integral over all wave directions, which one direction replaces if
    the body and all generalized modes are `axisymmetric`; damping of heave and these, one radiation channel, then also
    has rank one. Added mass follows from damping (Kramers and Kronig), as far as the band holds it.

    Parameters
    ----------
    ds : xarray.Dataset
    axisymmetric : bool
    dofs : sequence of str, optional
        Degrees of freedom that are judged, of which the others only tell the conventions; all.

    Raises
    ------
    ConfigError
        If the motions are said to be axisymmetric, and none can be.
    DatabaseError
        If nothing makes waves or moves water.
    """
    whole = ds.sel(omega=ds.omega > 0)
    ds = whole if dofs is None else whole.sel(influenced_dof=list(dofs), radiating_dof=list(dofs))
    radiating = np.einsum("wii->wi", ds.radiation_damping.values).any(axis=0)
    if not radiating.any():
        raise DatabaseError("radiation damping is zero for all motions; needs coefficients of waves.")
    if not ds.added_mass.values.any():
        raise DatabaseError("added mass is zero for all motions; needs coefficients of waves.")
    size, of_all = sizes(ds), sizes(whole).added_mass
    wet = ds.isel(influenced_dof=radiating, radiating_dof=radiating)
    among = size.of(radiating)
    checks = [_symmetry(ds, size), *afloat_checks(ds), *volume_check(whole, of_all), *trim_checks(ds), *_parts(ds)]
    checks.append(_positive(wet, among))
    ring = _ring(wet) if axisymmetric else np.ones(wet.sizes["influenced_dof"], dtype=bool)
    part, its = wet.isel(influenced_dof=ring, radiating_dof=ring), among.of(ring)
    if axisymmetric:
        channel = quality.second_channel(part, np.sqrt(np.outer(its.damping, its.damping)))
        checks.append(check_at_most("rank_one", channel, 0.02, "-", "axisymmetric motions radiate one ring wave"))
    parts = [
        _smooth(wet, among),
        _causal(wet, among),
        (_limits(ds, size), []),
        lift_check(ds, size.added_mass),
        phase_check(whole, of_all),
        _haskind(part, its, axisymmetric),
    ]
    unseen = [] if any(check.name == "afloat" for check in checks) else [_DENSITY]
    return [*checks, *(check for found, _ in parts for check in found)], [
        line for _, notes in parts for line in notes
    ] + unseen


def _parts(ds: xr.Dataset) -> list[Check]:
    """The excitation as the sum of its two parts, where a database has all three."""
    names = ("excitation_force", "Froude_Krylov_force", "diffraction_force")
    if not set(names) <= set(ds):
        return []
    total, incident, diffracted = (ds[name].values for name in names)
    largest = np.abs(total).max(axis=(0, 1))
    error = np.abs(total - incident - diffracted).max(axis=1)
    error = np.divide(error, largest, out=np.zeros_like(error), where=largest > 1e-6 * largest.max())
    text = f"the excitation is its Froude-Krylov part and its diffraction part; {_where(ds, error)}"
    return [check_at_most("parts", error.max(), 0.01, "-", text)]


def trim_checks(ds: xr.Dataset) -> list[Check]:
    """Return the check that the centre of mass is above or below that of buoyancy, if a database has both.

    A doubt at most: a mooring may carry the difference.
    """
    if {"centre_of_mass", "centre_of_buoyancy"} - set(ds.attrs) or not ds.attrs.get(volume_of("")):
        return []
    apart = np.subtract(ds.attrs["centre_of_mass"], ds.attrs["centre_of_buoyancy"])[:2]
    value = float(np.hypot(*apart) / float(ds.attrs[volume_of("")]) ** (1 / 3))
    text = "the centres of mass and buoyancy lie on one vertical, in terms of the cube root of the displaced volume"
    check = check_at_most("trim", value, 0.01, "-", text)
    return [check if check.verdict == "ok" else replace(check, verdict="doubt")]


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


def afloat_checks(ds: xr.Dataset, largest: float = LARGEST_UNAFLOAT) -> list[Check]:
    """Return the check of mass in heave against the water displaced, of bodies of which a database has both.

    A moored one may weigh less, and coarse panels displace less than the body: a doubt up to the `largest` difference.
    """
    errors, labels = [], list(map(str, ds.influenced_dof.values))
    for i in [i for i, label in enumerate(labels) if motion_of(label) == "Heave" and "inertia_matrix" in ds]:
        volume = float(ds.attrs.get(volume_of(body_of(labels[i])), 0.0))
        mass = float(ds.inertia_matrix.values[i, i])
        if volume and mass:  # not stated, as in the files of rigid bodies
            errors.append(abs(mass / (float(ds.attrs["water_density"]) * volume) - 1))
    text = "mass in heave is that of the water displaced"
    checks = [check_at_most("afloat", max(errors), 0.01, "-", text)] if errors else []
    return [replace(c, verdict="doubt") if c.verdict == "fail" and c.value <= largest else c for c in checks]


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
    """Added mass from damping by Kramers and Kronig, of modes whose damping the band holds or has seen fall by half.

    What the steps of frequency do to the integral is its change when every other one is left out. Where that is not
    little, or the band does not hold the damping, both errors widen the limit, of each mode by itself.
    """
    omega, damping = wet.omega.values, wet.radiation_damping.values
    if len(omega) < 10:
        return [], [f"not checked: kramers_kronig, which needs ten frequencies; received {len(omega)}"]
    own = np.abs(np.einsum("wii->wi", damping))
    ends = np.maximum(own[0], own[-1]) / size.damping
    change = DampingSpectrum(omega, damping).added_mass_difference(omega)
    fewer = slice(1 - len(omega) % 2, None, 2)  # the last one stays
    coarse = DampingSpectrum(omega[fewer], damping[fewer]).added_mass_difference(omega) - change
    steps = np.abs(np.einsum("wii->wi", coarse)).max(axis=0) / size.added_mass
    outside = _outside(omega, own) / size.added_mass
    exact = (ends <= HELD) & (steps <= quality.LARGEST_LIMIT_DIFFERENCE)
    wider = outside + 2 * steps
    lasts = (ends > FALLEN) | ((ends > HELD) & (outside > LARGEST_UNKNOWN).all(axis=0))
    roughly = ~exact & (ends <= FALLEN) & (wider <= LARGEST_UNKNOWN).any(axis=0)
    names, kept = wet.influenced_dof.values, np.flatnonzero((exact | roughly) & size.wet)
    notes = [
        f"not checked: kramers_kronig of {', '.join(names[left])}, whose damping {why}"
        for left, why in (
            (size.wet & ~exact & ~roughly & lasts, "lasts beyond the band"),
            (size.wet & ~exact & ~roughly & ~lasts, "needs smaller steps of frequency"),
        )
        if left.any()
    ]
    if not kept.size:
        return [], notes
    limit = wet.added_mass.values - change
    known = wet.added_mass_inf.values if "added_mass_inf" in wet else np.median(limit, axis=0)
    root = np.sqrt(size.added_mass)
    error = np.abs(limit - known) / np.outer(root, root)
    single = np.einsum("wii->wi", error)
    error = np.where(np.outer(exact, exact), error, 0.0)
    error[:, roughly, roughly] = np.where(wider <= LARGEST_UNKNOWN, np.maximum(single - wider, 0.0), 0.0)[:, roughly]
    error = error[:, kept[:, None], kept]
    place = f"; {_where(wet.isel(influenced_dof=kept), error)}" if error.any() else ""
    text = f"added mass follows from damping{place}"
    if (roughly & size.wet).any():
        text += f"; of {', '.join(sorted(names[roughly & size.wet]))} only what exceeds the error of band and steps"
    return [
        check_at_most("kramers_kronig", error.max(), quality.LARGEST_LIMIT_DIFFERENCE, "-", text, doubt=True)
    ], notes


def _limits(ds: xr.Dataset, size: Sizes) -> list[Check]:
    """Added mass at the ends of the band nearer to its limits, where both are known, than to them exchanged."""
    if {"added_mass_zero", "added_mass_inf"} - set(ds):
        return []
    first, last = (np.diag(ds.added_mass.values[i]) for i in (0, -1))
    zero, infinite = (np.diag(ds[name].values) for name in ("added_mass_zero", "added_mass_inf"))
    far, swapped = (
        float(((np.abs(first - one) + np.abs(last - other)) / size.added_mass)[size.wet].sum())
        for one, other in ((zero, infinite), (infinite, zero))
    )
    text = "added mass begins near that at zero frequency and ends near that at infinite; above the limit: exchanged"
    return [check_at_most("added_mass_limits", far / (far + swapped or 1.0), 0.5, "-", text)]


def _outside(omega: FloatArray, damping: FloatArray) -> FloatArray:
    """Added mass that damping (omega, dof) outside the band may give, likewise [kg]; infinite at its ends.

    Twice the tail of `DampingSpectrum` above, and the damping of the first frequency all the way below it.
    """
    (first, top), (low, high), at = omega[[0, -1]], np.abs(damping[[0, -1]]), omega[:, None]
    with np.errstate(divide="ignore"):
        x = (at / top) ** 2
        above = 2 * high / top * (-x - np.log1p(-x)) / (2 * x**2)
        below = low / (2 * at) * np.log((at + first) / (at - first))
    return np.asarray(2 / np.pi * (above + below))


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
