"""Checks of coefficients from other codes: identities of any body, what they leave open, and likely causes of errors.

Sizes: modes have amplitudes in metres or radians, and some move no water. Errors of added mass are relative to the
median of a mode's added mass over the band, errors of damping to its largest value, neither below `LEAST_SIZE` squared
of the displaced water moving with the mode: yaw of a round body is round-off, and so is all that follows from it.

Waves much longer than a body show the conventions of a file. Water moves with such a wave as a whole: by 1 upwards and
by i g k/omega^2 along it per unit elevation at the origin (C1, Re(X e^{-i omega t}), a wave e^{i k x}), and the force
on a fixed body is that on one that moves the opposite way in still water. Per unit elevation

    X_heave = C - omega^2 (A + rho V) - i omega B,    X_surge = -i k g (rho V + A + i B/omega) cos(beta),

and sway likewise with sin(beta). The slope i k of the surface turns the body by its stiffness, with the weight at the
centre of rotation, and the surging water pulls at it:

    X_pitch = -i k cos(beta) (C + g A_pitch,surge),    X_roll = i k sin(beta) (C - g A_roll,sway),

with A + i B/omega for A; the Froude-Krylov moment is the part of C alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.engine.hydro import quality
from vsb.engine.hydro.database import Check, Rule
from vsb.engine.hydro.formats import points
from vsb.engine.hydro.formats.common import rotation_centre, volume_of
from vsb.engine.hydro.radiation import DampingSpectrum
from vsb.engine.hydro.variables import RIGID, ROTATIONS, body_of, motion_of, of_bodies
from vsb.engine.waves.water import haskind_factor, wavenumber
from vsb.errors import ConfigError, DatabaseError
from vsb.tools.arrays import BoolArray, ComplexArray, FloatArray

RULES = {
    "symmetry": Rule(0.02, "added mass and damping are symmetric matrices",
        causes="too few panels; files of two runs; rows and columns of a matrix exchanged"),
    "displaced_mass": Rule(0.01, "mass in heave is that of the water displaced", doubt=20.0,  # a mooring, coarse panels
        causes="{density}; {length}; a mooring that carries or pulls"),
    "displaced_volume": Rule(0.05, "long waves push with the water displaced",
        causes="{length}; the volume of another body or run"),
    "trim": Rule(0.01, "the centres of mass and buoyancy lie on one vertical, in terms of the cube root of the "
        "displaced volume", doubt=np.inf,
        causes="centres of another body or about another origin; a mooring that carries or pulls"),
    "parts": Rule(0.01, "the excitation is its Froude-Krylov part and its diffraction part", doubt=1.0,
        causes="parts of another run; phases of the other sign in one of them"),
    "positive_damping": Rule(0.01, "no motion can draw energy from calm water", doubt=1.0,
        causes="an irregular frequency{irr}; panels too large for the shortest waves; panels inside out"),
    "rank_one": Rule(0.02, "axisymmetric motions radiate one ring wave", doubt=1.0,
        causes="a body or mode that is not axisymmetric (leave --axisymmetric out); too few panels"),
    "irregular_frequencies": Rule(0.02, "added mass and damping are smooth; an irregular frequency is a spike",
        doubt=np.inf,
        causes="an irregular frequency{irr}; frequencies too far apart for a resonance that is real"),
    "kramers_kronig": Rule(quality.LARGEST_LIMIT_DIFFERENCE, "added mass follows from damping",
        causes="{period}; an irregular frequency{irr}; added mass at infinite frequency of another run or "
        "exchanged with that at zero; panels too large for the shortest waves"),
    "added_mass_limits": Rule(0.5, "added mass begins near that at zero frequency and ends near that at infinite; "
        "above the limit: exchanged", doubt=1.0, causes="added mass at zero and at infinite frequency exchanged"),
    "long_waves": Rule(0.05, "waves much longer than the body lift it by its hydrostatic stiffness", doubt=1.0,
        causes="{period}; excitation and stiffness of different runs or lengths"),
    "phases": Rule(0.2, "in waves much longer than the body forces follow from the motion of the water",  # from 0 to 2
        causes="phases of the other sign; headings in another unit; the force of another body or run"),
    "tilt": Rule(0.1, "such waves turn the body in roll and pitch by its hydrostatic stiffness and added mass",
        causes="moments of the other sign or about another point; stiffness about another point or without the weight; "
        "centres of another run"),
    "haskind": Rule(0.05, "damping follows from excitation", doubt=1.0,
        causes="{depth}; {length}; {gravity}; {period}; an irregular frequency{irr}; too few panels"),
    "haskind_scale": Rule(0.01, "excitation and damping have one scale", causes="{length}; {gravity}; too few panels"),
    "haskind_long_waves": Rule(0.05, "damping follows from excitation in the longest waves, which feel the depth",
        causes="{depth}; {length}; {gravity}; damping or excitation of another run or in other units"),
    "hydrostatic_symmetry": Rule(np.nan, "",  # of `hydro.repairs`
        causes="rows and columns exchanged; a body that does not float upright"),
    **points.RULES,
}  # fmt: skip
"""Limits of the checks, their meaning, and likely causes in the words of a file's format."""
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
NEMOH_WORDS = {
    "density": "RHO of Nemoh.cal not that of the run",
    "length": "a mesh that is not in metres",
    "gravity": "G of Nemoh.cal not that of the run",
    "depth": "DEPTH of Nemoh.cal not that of the run",
    "period": "first column not what its heading says",
    "irr": " (IRR of input_solver.txt, a lid, removes it)",
}
LEAST_SIZE = 0.3
"""Of a mode, relative to the displaced water moving with it, as for bodies from meshes."""
LARGEST_MASS_ERROR = 0.2
"""Relative difference of a body's mass from the displaced water that a mooring or coarse panels may explain."""
_LEAST_DAMPING = 1e-3  # relative to frequency times added mass: no panels are more accurate
_HELD, _FALLEN = 0.05, 0.5  # damping at the ends of a band that holds it, and that has seen it fall, over the largest
_LARGEST_UNKNOWN = 0.2  # relative added mass that damping outside the band and between the steps may give
_ALONE = 5.0  # ratio of a spike of added mass or damping to the other's: a resonance shows in both
_LONG = 0.2  # second order of heave, omega^2 (A + displaced water)/C, up to which waves are long
_RING = 0.1  # square of wavenumber times length up to which heave sends out ring waves
_COUPLED = 0.1  # moment of the lift of a wave over that of its slope, above which the latter is not seen
_ROUND = 0.1  # stiffness over that of a body with arms of the cube root of its volume, below which nothing turns it
_SMALLEST, _LARGEST = 0.005, 200.0  # largest added mass of a translation over the water displaced, of any body
_PARTS = ("excitation_force", "Froude_Krylov_force", "diffraction_force")
_ALONG: dict[str, Callable[[FloatArray], FloatArray]] = {"Surge": np.cos, "Sway": np.sin}
_TURNING = {"Pitch": ("Surge", np.cos, -1.0), "Roll": ("Sway", np.sin, 1.0)}
"""Motion of the water that pulls at a rotation, its share by heading, and the sign of the slope's moment."""
_READINGS = (  # other readings of a file: sign of forces of surge and sway, and factor of its headings
    ("their complex conjugates would fit (or headings the waves come from)", -1.0, 1.0),
    ("headings would fit in degrees where they are read as radians", 1.0, np.pi / 180),
    ("headings would fit in radians where they are read as degrees", 1.0, 180 / np.pi),
)
_DENSITY = "not checked: density, with which all coefficients grow alike; it needs mass in heave and displaced volume"
_TOO_FEW = (
    "not checked: haskind, but for the heave of one body in long waves: it sees a wrong length, gravity or depth and "
    "needs wave directions in fine, equal steps all around, or one direction and --axisymmetric; received {}"
)
Found = tuple[list[Check], list[str]]
"""Checks, and a line on each that is not made."""


def _check(name: str, value: float, more: str = "", limit: float | None = None) -> Check:
    """The check of a name in `RULES`."""
    return RULES[name].check(name, value, more, limit)


def causes(check: Check, words: dict[str, str]) -> str:
    """Return the likely causes of a check that does not hold, in the words of the format of the file."""
    return f"{check.name}: {RULES[check.name].causes.format(**words)}?"


class Sizes(NamedTuple):
    """Units of errors."""

    added_mass: FloatArray  # (dof,) [kg], rotations [kg m^2]
    damping: FloatArray  # (dof,) [N s/m]
    wet: BoolArray  # whether a mode moves water, (dof,)

    def of(self, modes: BoolArray) -> "Sizes":
        """Return those of some of the modes."""
        return Sizes(self.added_mass[modes], self.damping[modes], self.wet[modes])


def sizes(ds: xr.Dataset) -> Sizes:
    """Return the sizes of added mass and damping of every mode, and which modes move water.

    Modes with less than a hundredth of `LEAST_SIZE` do not. The displaced water is that of the file, or else the
    largest added mass of a translation; its arm in rotations is the cube root of its volume. Generalized modes, whose
    scale is arbitrary, are compared among themselves, and so are modes without a translation beside them. Every body
    has its own displaced water.
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
    floor = _LEAST_DAMPING * omega[damping.argmax(axis=0)] * size
    return Sizes(size, np.maximum(largest, floor), (mass > 1e-4 * least) & (largest > 0))


def coefficient_checks(
    ds: xr.Dataset, *, axisymmetric: bool = False, dofs: Sequence[str] | None = None
) -> tuple[list[Check], list[str]]:
    """Return the checks that a database of another code allows, and a line on each that is left out.

    Damping follows from excitation (Haskind) by an integral over all wave directions; for an `axisymmetric` body with
    axisymmetric generalized modes one direction is enough, and damping of heave and these, one radiation channel, then
    also has rank one. Added mass follows from damping (Kramers and Kronig), as far as the band holds it. Raises
    `ConfigError` if the motions are said to be axisymmetric, and none can be; `DatabaseError` if nothing makes waves or
    moves water.

    Parameters
    ----------
    dofs : sequence of str, optional
        Degrees of freedom that are judged; the others only show the conventions of the file. Default: all.
    """
    whole = ds.sel(omega=ds.omega > 0)
    ds = whole if dofs is None else whole.sel(influenced_dof=list(dofs), radiating_dof=list(dofs))
    radiating = np.einsum("wii->wi", ds.radiation_damping.values).any(axis=0)
    if not radiating.any():
        raise DatabaseError("radiation damping is zero for all motions; needs coefficients of waves.")
    if not ds.added_mass.values.any():
        raise DatabaseError("added mass is zero for all motions; needs coefficients of waves.")
    size, of_all = sizes(ds), sizes(whole).added_mass
    wet, among = ds.isel(influenced_dof=radiating, radiating_dof=radiating), size.of(radiating)
    checks = [_symmetry(ds, size), *displaced_mass_checks(ds), *_displaced_volume(whole, of_all), *_at_rest(ds)]
    lowest = -quality.scaled_eigenvalues(wet, np.sqrt(np.outer(among.damping, among.damping)))[:, 0]
    where = f"; most at {wet.omega.values[lowest.argmax()]:.4g} rad/s"
    checks.append(_check("positive_damping", max(0.0, lowest.max()), where))
    ring = np.ones(wet.sizes["influenced_dof"], dtype=bool)
    if axisymmetric:
        labels = wet.influenced_dof.values
        ring = np.array([label == "Heave" or label not in RIGID for label in labels])
        if not ring.any():
            raise ConfigError(f"--axisymmetric: received {', '.join(labels)}; needs heave or modes.")
    part, its = wet.isel(influenced_dof=ring, radiating_dof=ring), among.of(ring)
    if axisymmetric:
        checks.append(_check("rank_one", quality.second_channel(part, np.sqrt(np.outer(its.damping, its.damping)))))
    found = [_smooth(wet, among), _causal(wet, among), _limits(ds, size), lift_check(ds, size.added_mass)]
    found += [phase_check(whole, of_all), _tilt(whole, of_all), _haskind(part, its, axisymmetric)]
    if not found[-1][0]:
        found.append((_ring_waves(whole, of_all), []))
    left_out: set[str] = set()  # points that forces say only if their phases are right, those of rotations if it turns
    if any(check.verdict != "ok" for check in found[4][0]):
        left_out |= {*points.BY_WAVES}
    if not any(motion_of(str(label)) in ROTATIONS for label in ds.influenced_dof.values):
        left_out |= {*points.OF_ROTATIONS}
    found.append(([check for check in points.point_checks(whole) if check.name not in left_out], []))
    notes = [line for _, lines in found for line in lines]
    notes += [] if any(check.name == "displaced_mass" for check in checks) else [_DENSITY]
    return [*checks, *(check for some, _ in found for check in some)], notes


def _where(ds: xr.Dataset, error: FloatArray) -> str:
    """Frequency and modes of the largest error, (omega, dof) or (omega, dof, dof)."""
    w, *modes = (int(i) for i in np.unravel_index(int(np.argmax(error)), error.shape))
    names = dict.fromkeys(str(ds.influenced_dof.values[i]) for i in modes)
    return f"; most at {ds.omega.values[w]:.4g} rad/s in {' and '.join(names)}"


def _over(error: FloatArray, size: FloatArray, known: BoolArray) -> FloatArray:
    """Errors over sizes, zero where these are not known."""
    return np.asarray(np.divide(error, size, out=np.zeros_like(error), where=known))


# Matrices and the body at rest


def _symmetry(ds: xr.Dataset, size: Sizes) -> Check:
    """Symmetry of the radiation impedance, relative to the impedances of both motions."""
    omega = ds.omega.values[:, None, None]
    impedance = ds.radiation_damping.values + 1j * omega * ds.added_mass.values
    least = _LEAST_DAMPING * ds.omega.values[:, None] * size.added_mass
    z = np.maximum(np.abs(np.einsum("wii->wi", impedance)), least)
    pair = np.sqrt(z[:, :, None] * z[:, None, :])
    error = _over(np.abs(impedance - impedance.transpose(0, 2, 1)), pair, pair > 0)
    return _check("symmetry", error.max(), _where(ds, error))


def displaced_mass_checks(ds: xr.Dataset, largest: float = LARGEST_MASS_ERROR) -> list[Check]:
    """Return the check of mass in heave against the displaced water, of bodies of which a database has both.

    A moored body may weigh less, and coarse panels displace less than the body: a doubt up to the `largest` difference.
    """
    errors, labels = [], list(map(str, ds.influenced_dof.values))
    for i in [i for i, label in enumerate(labels) if motion_of(label) == "Heave" and "inertia_matrix" in ds]:
        volume = float(ds.attrs.get(volume_of(body_of(labels[i])), 0.0))
        mass = float(ds.inertia_matrix.values[i, i])
        if volume and mass:  # not stated, as in the files of rigid bodies
            errors.append(abs(mass / (float(ds.attrs["water_density"]) * volume) - 1))
    rule = RULES["displaced_mass"]
    return [rule._replace(doubt=largest / rule.limit).check("displaced_mass", max(errors))] if errors else []


def _at_rest(ds: xr.Dataset) -> list[Check]:
    """Centres of mass and buoyancy on one vertical, and the excitation as the sum of its parts, if they are known."""
    checks, volume = [], float(ds.attrs.get(volume_of(""), 0.0))
    if {"centre_of_mass", "centre_of_buoyancy"} <= set(ds.attrs) and volume:
        apart = np.subtract(ds.attrs["centre_of_mass"], ds.attrs["centre_of_buoyancy"])[:2]
        checks.append(_check("trim", float(np.hypot(*apart) / volume ** (1 / 3))))
    if set(_PARTS) <= set(ds):
        total, incident, diffracted = (ds[name].values for name in _PARTS)
        largest = np.abs(total).max(axis=(0, 1))
        error = _over(np.abs(total - incident - diffracted).max(axis=1), largest, largest > 1e-6 * largest.max())
        checks.append(_check("parts", error.max(), _where(ds, error)))
    return checks


# Smoothness and causality


def _smooth(wet: xr.Dataset, size: Sizes) -> Found:
    """Spikes of added mass and damping: a doubt if both have one, a failure if only one of them has."""
    omega = wet.omega.values
    if len(omega) < 5:
        return [], [f"not checked: irregular_frequencies, which needs five frequencies; received {len(omega)}"]
    rule = RULES["irregular_frequencies"]
    mass, damping = (np.einsum("wii->wi", wet[name].values) for name in ("added_mass", "radiation_damping"))
    kinks = np.stack([quality.kinks(omega, mass), quality.kinks(omega, damping)])
    error = np.max(kinks / np.stack([size.added_mass, size.damping])[:, None], axis=0)
    kinks[1] /= omega[2:-2, None]  # [kg]
    around = [np.pad(kinks, ((0, 0), (2, 2), (0, 0)))[:, k : k + len(omega) - 4] for k in range(5)]
    low, high = np.sort(np.max(around, axis=0), axis=0)
    alone = (high > _ALONE * low) & (error > 5 * rule.limit)
    where = wet.isel(omega=slice(2, -2))
    if not alone.any():
        return [rule.check("irregular_frequencies", error.max(), _where(where, error))], []
    error = np.where(alone, error, 0.0)
    more = f", here of one without the other{_where(where, error)}"
    return [rule._replace(doubt=1.0).check("irregular_frequencies", error.max(), more)], []


def _causal(wet: xr.Dataset, size: Sizes) -> Found:
    """Added mass from damping by Kramers and Kronig, of modes whose damping the band holds or has seen fall by half.

    The error of the integral by the steps of frequency is its change when every other one is left out. Where that is
    not small, or the band does not hold the damping, both errors widen the limit of the mode.
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
    exact = (ends <= _HELD) & (steps <= quality.LARGEST_LIMIT_DIFFERENCE)
    wider = outside + 2 * steps
    lasts = (ends > _FALLEN) | ((ends > _HELD) & (outside > _LARGEST_UNKNOWN).all(axis=0))
    roughly = ~exact & (ends <= _FALLEN) & (wider <= _LARGEST_UNKNOWN).any(axis=0)
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
    error[:, roughly, roughly] = np.where(wider <= _LARGEST_UNKNOWN, np.maximum(single - wider, 0.0), 0.0)[:, roughly]
    error = error[:, kept[:, None], kept]
    more = _where(wet.isel(influenced_dof=kept), error) if error.any() else ""
    if (roughly & size.wet).any():
        more += f"; of {', '.join(sorted(names[roughly & size.wet]))} only what exceeds the error of band and steps"
    return [_check("kramers_kronig", error.max(), more)], notes


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


def _limits(ds: xr.Dataset, size: Sizes) -> Found:
    """Added mass at the ends of the band against its limits, where both are known, and against them exchanged."""
    if {"added_mass_zero", "added_mass_inf"} - set(ds):
        return [], []
    first, last = (np.diag(ds.added_mass.values[i]) for i in (0, -1))
    zero, infinite = (np.diag(ds[name].values) for name in ("added_mass_zero", "added_mass_inf"))
    far, swapped = (
        float(((np.abs(first - one) + np.abs(last - other)) / size.added_mass)[size.wet].sum())
        for one, other in ((zero, infinite), (infinite, zero))
    )
    return [_check("added_mass_limits", far / (far + swapped or 1.0))], []


# Long waves


class _Heaving(NamedTuple):
    """A body with a waterplane."""

    name: str
    heave: int  # its place among the degrees of freedom
    along: list[int]  # surge and sway
    second_order: FloatArray  # omega^2 (A + displaced water)/C, (omega,)


def _heaving(ds: xr.Dataset, added_mass: FloatArray) -> list[_Heaving]:
    """Bodies that heave with a waterplane; the displaced water is their largest added mass of a translation."""
    labels, stiffness = list(map(str, ds.influenced_dof.values)), np.diag(ds.hydrostatic_stiffness.values)
    found = []
    for i in (i for i, label in enumerate(labels) if motion_of(label) == "Heave" and stiffness[i] > 0):
        its = of_bodies(labels)[body_of(labels[i])]
        water = max(added_mass[j] for j in its if motion_of(labels[j]) in RIGID[:3])
        along = [j for j in its if motion_of(labels[j]) in _ALONG]
        order = ds.omega.values**2 * (added_mass[i] + water) / stiffness[i]
        found.append(_Heaving(body_of(labels[i]), i, along, order))
    return found


def lift_check(ds: xr.Dataset, added_mass: FloatArray) -> Found:
    """Return the check of the heave excitation in the longest wave against hydrostatic stiffness, or why there is none.

    The limit is widened by twice the second order. Of several bodies whose longest wave is long the worst counts.
    `added_mass`, shape (dof,) [kg], is that of `sizes`.
    """
    bodies = _heaving(ds, added_mass)
    if not bodies:
        return [], ["not checked: long_waves, which needs heave and a waterplane"]
    found = []
    for body in (body for body in bodies if body.second_order[0] <= _LONG):
        force = np.abs(ds.excitation_force.values[0, :, body.heave])
        error = float(np.abs(force / float(ds.hydrostatic_stiffness[body.heave, body.heave]) - 1).max())
        limit = RULES["long_waves"].limit + 2 * float(body.second_order[0])
        found.append((error - limit, error, limit))
    if not found:
        return [], [f"not checked: long_waves, of which {ds.omega.values[0]:.4g} rad/s is none for this body"]
    _, error, limit = max(found)
    return [_check("long_waves", error, limit=limit)], []


def phase_check(ds: xr.Dataset, added_mass: FloatArray) -> Found:
    """Return the check of phases and headings in long waves, or a line that they are not checked.

    Surge and sway relative to heave show both, wherever the body lies; heave alone the sign of its own phase, about the
    origin. An error that another reading of the file explains is a failure, and the reading is named.
    """
    bodies = _heaving(ds, added_mass)
    patterns = [pattern for body in bodies for pattern in _patterns(ds, body)]
    signs = [sign for body in bodies if (sign := _heave_sign(ds, body)) is not None]
    if not patterns and not signs:
        return [], ["not checked: phases, sign and headings of which surge and heave show in long waves"]
    notes = [] if patterns else ["not checked: phases of other motions than heave, headings: no wave is long enough"]
    for body in bodies:
        if (turn := _constant_phase(ds, body)) is not None and abs(np.exp(1j * turn) - 1) > RULES["phases"].limit:
            more = f"; of heave in ever longer waves; phases later by {np.degrees(-turn) % 360:.0f} degrees would fit"
            return [_check("phases", float(abs(np.exp(1j * turn) - 1)), more)], notes
    headings = ds.wave_direction.values
    worst, where = max([(each.error(headings), each.where) for each in patterns] + signs)
    check = _check("phases", worst, f"; most {where}")
    for reading, turn, factor in _READINGS if check.verdict != "ok" else ():
        errors = [each.error(headings * factor, turn) for each in patterns]
        errors += [error if turn > 0 else 2.0 - error for error, _ in signs]
        if max(errors) <= check.limit:
            return [replace(check, verdict="fail", explanation=f"{check.explanation}; {reading}")], notes
    return [check], notes


def _tilt(ds: xr.Dataset, added_mass: FloatArray) -> Found:
    """Moments on a single body in the longest wave against its stiffness, the larger of the errors of roll and pitch.

    Not of a body that the lift of the wave turns as well, and of one whose stiffness or point of rotation is unknown.
    """
    bodies, centre = _heaving(ds, added_mass), rotation_centre(ds)
    volume = float(ds.attrs.get(volume_of(""), 0.0))
    if len(bodies) != 1 or centre is None or "centre_of_mass" not in ds.attrs or not volume:
        return [], []
    (body,), labels = bodies, list(map(str, ds.influenced_dof.values))
    if body.second_order[0] > _LONG:
        return [], []
    omega, headings = float(ds.omega[0]), ds.wave_direction.values
    density, gravity, depth = (float(ds.attrs[name]) for name in ("water_density", "gravity", "water_depth"))
    k = wavenumber(omega, depth, gravity)
    inertia = ds.added_mass.values[0] + 1j * ds.radiation_damping.values[0] / omega
    stiffness, excitation, found = ds.hydrostatic_stiffness.values, ds.excitation_force.values, []
    for motion in (motion for motion in _TURNING if motion in labels):
        pulling, along, sign = _TURNING[motion]
        j, at = labels.index(motion), int(np.abs(along(headings)).argmax())
        pull = gravity * inertia[j, labels.index(pulling)] if pulling in labels else 0.0
        own = stiffness[j, j] + density * gravity * volume * float(ds.attrs["centre_of_mass"][2] - centre[2])
        lift = max(abs(stiffness[body.heave, j]), omega**2 * abs(inertia[body.heave, j]))
        for name, turning in (("Froude_Krylov_force", own), ("excitation_force", own - sign * pull)):
            expected = 1j * sign * k * along(headings[at]) * turning
            small = abs(turning) < _ROUND * density * gravity * volume ** (4 / 3) or lift > _COUPLED * abs(expected)
            if name in ds and not small:
                turned = ds[name].values[0, at, j] * np.exp(-1j * np.angle(excitation[0, at, body.heave]))
                found.append((float(abs(turned / expected - 1)), f"{name.lower().replace('_', ' ')} of {motion}"))
    if not found:
        return [], ["not checked: tilt: no wave is long enough, or no heading or stiffness turns the body"]
    limit = RULES["tilt"].limit + 2 * float(body.second_order[0])
    return [_check("tilt", max(found)[0], f"; most at {omega:.4g} rad/s in {max(found)[1]}", limit)], []


class _Pattern(NamedTuple):
    """Forces of surge or sway over headings in the longest wave, relative to the phase of heave."""

    where: str
    force: ComplexArray  # (wave_direction,)
    share: ComplexArray  # of the forces by surge and sway of the water, (2,)

    def error(self, headings: FloatArray, sign: float = 1.0) -> float:
        """Return the distance from long waves with these headings, both scaled to length one, 0 to 2."""
        expected = self.share @ np.array([along(headings) for along in _ALONG.values()])
        size, other = np.linalg.norm(self.force), np.linalg.norm(expected)
        if not size > 0 or other < 1e-3 * np.linalg.norm(self.share):  # across the waves
            return 0.0
        return float(np.linalg.norm(sign * self.force / size - expected / other))


def _patterns(ds: xr.Dataset, body: _Heaving) -> list[_Pattern]:
    """Excitation of surge and sway of a body, and its parts: their signs may differ."""
    if body.second_order[0] > _LONG:
        return []
    labels, first = list(map(str, ds.influenced_dof.values)), float(ds.omega[0])
    turned = np.exp(-1j * np.angle(ds.excitation_force.values[0, :, body.heave]))
    inertia = ds.added_mass.values[0] + 1j * ds.radiation_damping.values[0] / first
    displaced = float(ds.attrs["water_density"]) * float(ds.attrs.get(volume_of(body.name), 0.0))
    found = []
    for j in body.along:
        share = [
            inertia[j, [motion_of(label) == motion for label in labels]].sum()
            + displaced * (motion == motion_of(labels[j]))
            for motion in _ALONG
        ]
        for name in (name for name in _PARTS if name in ds):
            where = f"at {first:.4g} rad/s in {name.lower().replace('_', ' ')} of {labels[j]}"
            found.append(_Pattern(where, ds[name].values[0, :, j] * turned, -1j * np.array(share)))
    return found


def _heave_sign(ds: xr.Dataset, body: _Heaving) -> tuple[float, str] | None:
    """0 if heave has the imaginary part -omega B, 2 if the opposite; None if neither, as away from the origin."""
    labels, long = list(map(str, ds.influenced_dof.values)), body.second_order <= 2 * _LONG
    heaves = [motion_of(label) == "Heave" for label in labels]
    own = ds.excitation_force.values[long, :, body.heave].imag.mean(axis=1)
    expected = -(ds.omega.values * ds.radiation_damping.values[:, body.heave, heaves].sum(axis=1))[long]
    for error, sign in ((0.0, 1.0), (2.0, -1.0)):
        if np.linalg.norm(own - sign * expected) < 0.5 * np.linalg.norm(expected):
            return error, f"up to {ds.omega.values[long][-1]:.4g} rad/s in {labels[body.heave]}"
    return None


def _constant_phase(ds: xr.Dataset, body: _Heaving) -> float | None:
    """Phase of heave as waves grow longer [rad], 0 wherever the body lies; None if two long waves do not show it."""
    if np.count_nonzero(body.second_order <= _LONG) < 2:
        return None
    gravity, depth = float(ds.attrs["gravity"]), float(ds.attrs["water_depth"])
    near, far = (wavenumber(float(w), depth, gravity) for w in ds.omega.values[:2])
    first, second = ds.excitation_force.values[:2, :, body.heave]
    step = np.angle(second * first.conj())
    if np.abs(step).max() > np.pi / 4:  # a body so far away that its distance is not sure
        return None
    limit = np.exp(1j * (np.angle(first) - step * near / (far - near)))
    return float(np.angle(limit.mean())) if np.abs(limit.mean()) > 1 - _ROUND else None


def _displaced_volume(ds: xr.Dataset, added_mass: FloatArray) -> list[Check]:
    """Displaced volume by the size of added mass, and by the Froude-Krylov force in long waves, k rho g V."""
    labels, rule = list(map(str, ds.influenced_dof.values)), RULES["displaced_volume"]
    mass = np.median(np.abs(np.einsum("wii->wi", ds.added_mass.values)), axis=0)
    for name, places in of_bodies(labels).items():
        largest = max((mass[j] for j in places if motion_of(labels[j]) in RIGID[:3]), default=0.0)
        water = float(ds.attrs["water_density"]) * float(ds.attrs.get(volume_of(name), 0.0))
        if largest and water and not _SMALLEST < (ratio := largest / water) < _LARGEST:
            return [rule.check("displaced_volume", abs(ratio - 1), f"; added mass is {ratio:.2g} times that water")]
    if "Froude_Krylov_force" not in ds:
        return []
    density, gravity, depth = (float(ds.attrs[name]) for name in ("water_density", "gravity", "water_depth"))
    pull = wavenumber(float(ds.omega[0]), depth, gravity) * density * gravity
    checks = []
    for body in (body for body in _heaving(ds, added_mass) if body.second_order[0] <= _LONG):
        volume = float(ds.attrs.get(volume_of(body.name), 0.0))
        for j in body.along:
            share = np.abs(_ALONG[motion_of(str(ds.influenced_dof.values[j]))](ds.wave_direction.values))
            if volume and share.max() > 0.5:
                own = float(np.abs(ds.Froude_Krylov_force.values[0, share.argmax(), j]) / share.max()) / pull
                limit = RULES["displaced_volume"].limit + 2 * float(body.second_order[0])
                more = f"; {own:.4g} m^3 would fit"
                checks.append(_check("displaced_volume", abs(own / volume - 1), more, limit))
    return sorted(checks, key=lambda check: check.value - check.limit)[-1:]


# Damping from excitation


def haskind_damping(ds: xr.Dataset, size: FloatArray, axisymmetric: bool) -> tuple[FloatArray, BoolArray] | None:
    """Return the damping from the excitation, (omega, dof, dof), and where it may be compared, (omega, dof).

    From headings all around, or from the first one alone for motions that send out ring waves. None if the headings are
    not in equal steps. `size`, shape (dof,) [N s/m], is that of `sizes`.

    B = k/(8 pi rho g v_g) int X X^H d beta (Newman, Marine Hydrodynamics, ch. 6), by the trapezoidal rule, which is
    exact for Fourier series over beta that end below half the number of headings. A mode is resolved up to the
    frequency at which the last two orders hold more than 2.5 % of its largest power in the band, or of its size: above
    it orders that are too high may look like low ones.
    """
    density, gravity, depth = (float(ds.attrs[name]) for name in ("water_density", "gravity", "water_depth"))
    if axisymmetric:
        damping = np.real(quality.haskind_damping(ds, depth, density, gravity))
        return damping, np.ones(damping.shape[:2], dtype=bool)
    degrees, first = np.unique(np.round(np.degrees(ds.wave_direction.values) % 360, 3) % 360, return_index=True)
    n = len(degrees)
    if n < 6 or not np.allclose(np.diff([*degrees, degrees[0] + 360]), 360 / n, atol=0.01):
        return None
    factor = haskind_factor(ds.omega.values, depth, density, gravity)
    x = ds.excitation_force.values[:, first, :] * np.sqrt(factor)[:, None, None]
    power = np.abs(np.fft.fft(x, axis=1) / n) ** 2
    last = np.abs(np.fft.fftfreq(n, 1 / n)) >= n // 2 - 1
    largest = np.maximum(power.sum(axis=1).max(axis=0), size)
    resolved = np.logical_and.accumulate(power[:, last].sum(axis=1) <= RULES["haskind"].limit / 2 * largest)
    return np.einsum("whi,whj->wij", x, x.conj()).real / n, resolved


def _haskind(part: xr.Dataset, size: Sizes, axisymmetric: bool) -> Found:
    """Damping from excitation where the headings resolve it: its largest error, its scale, and that of long waves."""
    found = haskind_damping(part, size.damping, axisymmetric)
    large = np.abs(np.einsum("wii->wi", part.radiation_damping.values)) > 0.1 * size.damping
    if found is None or not (found[1] & large).any():
        return [], [_TOO_FEW.format(part.sizes["wave_direction"])]
    damping, resolved = found
    error = np.abs(damping - part.radiation_damping.values) * (resolved[:, :, None] & resolved[:, None, :])
    error /= np.sqrt(np.outer(size.damping, size.damping))
    checks = [_check("haskind", error.max(), _where(part, error))]
    n, omega = part.sizes["omega"], part.omega.values
    missing = [
        f"{label} ({np.count_nonzero(~held)} of {n} frequencies, from {omega[~held][0]:.4g} rad/s)"
        for label, held in zip(part.influenced_dof.values, resolved.T, strict=True)
        if not held.all()
    ]
    few = f"which {part.sizes['wave_direction']} directions do not resolve"
    notes = [f"not checked: haskind of {', '.join(missing)}, {few}"] if missing else []
    return checks + _ratios(part, damping, resolved & size.wet), notes


def _ring_waves(ds: xr.Dataset, added_mass: FloatArray) -> list[Check]:
    """Damping of the heave of one body from its excitation in long waves, which is the same from all directions.

    The relative error is about the wavenumber squared times the waterplane's area; the limit is widened by it.
    """
    bodies = _heaving(ds, added_mass)
    if len(bodies) != 1 or len(of_bodies(list(map(str, ds.influenced_dof.values)))) != 1:
        return []
    density, gravity, depth = (float(ds.attrs[name]) for name in ("water_density", "gravity", "water_depth"))
    i, omega = bodies[0].heave, ds.omega.values
    area = float(ds.hydrostatic_stiffness.values[i, i]) / (density * gravity)
    second = np.array([wavenumber(w, depth, gravity) for w in omega]) ** 2 * area
    if not (long := np.flatnonzero(second <= _RING)).size:
        return []
    force = (np.abs(ds.excitation_force.values[long[-1], :, i]) ** 2).mean()
    expected = force * haskind_factor(omega[long[-1:]], depth, density, gravity)[0]
    error, limit = ds.radiation_damping.values[long[-1], i, i] / expected - 1, second[long[-1]]
    more = f"; at {omega[long[-1]]:.4g} rad/s in heave, whatever the direction"
    rule = RULES["haskind_long_waves"]
    return [_check("haskind_long_waves", float(abs(error)), more, rule.limit + float(limit))]


def _ratios(part: xr.Dataset, damping: FloatArray, known: BoolArray) -> list[Check]:
    """Ratio of damping from excitation to damping: its median, which length/gravity multiplies, and in long waves."""
    theirs, own = (np.einsum("wii->wi", b) for b in (damping, part.radiation_damping.values))
    largest = np.abs(own).max(axis=0)
    share = _over(own, largest, known & (largest > 0))
    if not (share > 0.1).any():
        return []
    ratio = np.divide(theirs, own, out=np.ones_like(own), where=share > 0)
    scale = float(np.median(ratio[share > 0.1]))
    checks = [_check("haskind_scale", abs(scale - 1), f"; length/gravity is {scale:.4g} times that of the run")]
    modes = np.flatnonzero((share > 0.03).any(axis=0))
    first = (share > 0.03).argmax(axis=0)[modes]
    longest, omega = ratio[first, modes], part.omega.values[first]
    worst = int(np.abs(longest - 1).argmax())
    more = f"; most at {omega[worst]:.4g} rad/s in {part.influenced_dof.values[modes[worst]]}"
    check = _check("haskind_long_waves", float(np.abs(longest - 1).max()), more)
    depth, gravity = float(part.attrs["water_depth"]), float(part.attrs["gravity"])
    if check.verdict != "ok" and (other := fitting_depth(longest, omega, depth, gravity)):
        more = f"; {other:.3g} m would fit" if np.isfinite(other) else "; deep water would fit"
        check = replace(check, explanation=check.explanation + more)
    return [*checks, check]


def fitting_depth(ratio: FloatArray, omega: FloatArray, depth: float, gravity: float) -> float | None:
    """Return the depth with which ratios of Haskind's damping to damping would be one, to the limit of `haskind`.

    Of ratios with `depth`, shape (entry,) [-], at frequencies, shape (entry,) [rad/s].
    """
    own, limit = haskind_factor(omega, depth, 1.0, gravity), RULES["haskind"].limit
    longest = gravity / float(omega.min()) ** 2
    tried = np.array([np.inf, *(longest * np.geomspace(3.0, 1e-4, 150))])
    error = [np.abs(ratio * haskind_factor(omega, h, 1.0, gravity) / own - 1).max() for h in tried]
    best = int(np.argmin(error))
    return float(tried[best]) if error[best] <= limit else None
