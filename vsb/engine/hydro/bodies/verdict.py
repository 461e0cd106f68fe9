"""How far the coefficients of a body may be off: estimated errors, identities that must hold, and the verdict on both.

Displacements may be metres or radians: errors are stated after scaling each displacement to unit added mass at infinite
frequency, relative to the largest added mass, damping and excitation of the band.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from vsb.engine.hydro import quality
from vsb.engine.hydro.bodies.body import (
    SYMMETRIES,
    FlexibleBody,
    detected_symmetry,
    panel_diameters,
    panel_size,
    panels_per_lobe,
    rigid_misfit,
)
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.hydrostatics import hinge_gap, hydrostatic_stiffness, linear_share
from vsb.engine.hydro.bodies.mesh import at_centres, text_of
from vsb.engine.hydro.bodies.solver import (
    BodyProblem,
    coarser_body,
    encloses_water,
    first_irregular_frequency,
    gap_resonance,
)
from vsb.engine.hydro.database import ESTIMATE, Check, Rule, with_excitation
from vsb.engine.hydro.sweep import apart, joined
from vsb.engine.hydro.variables import PAIR
from vsb.engine.waves.water import haskind_factor, wavenumber
from vsb.tools.arrays import FloatArray

RULES = {
    "error_estimate": Rule(0.05, "estimated error of added mass, damping and excitation, relative to the largest "
        "entry; smaller panels lower it"),
    "resonance": Rule(0.05, "estimated error around resonances of the water the body encloses, which in linear theory "
        "only radiation damps:", doubt=np.inf),
    "interpolation_error": Rule(np.nan, "relative to the band's largest entry", doubt=1.0),  # limit: the tolerance
    "one_resolution": Rule(0.5, "share of the surface without fewer panels to compare with, whose part of the error no "
        "estimate has"),
    "symmetry": Rule(0.02, "added mass and damping are symmetric matrices"),
    "far_field": Rule(0.02, "damping is the energy of the waves sent in all directions"),
    "haskind": Rule(0.02, "excitation follows from the waves radiated"),
    "positive_damping": Rule(0.01, "no motion can draw energy from calm water", doubt=1.0),
    "lid": Rule(0.05, "change of coefficients by the lid, relative to the largest entry, where no irregular frequency "
        "is near:"),
    "panels": Rule(0.25, "largest panel in wavelengths; `panel` of a body file divides those of its mesh"),
    "modes": Rule(1 / 3.5, "panel in terms of half a wavelength of the shortest mode; beyond the limit the error may "
        "exceed its estimate", doubt=1.75),
    "corners": Rule(0.05, "displacement of panels agrees with that of corners"),
    "rigid_names": Rule(0.01, "displacements named Surge, ..., Yaw are unit rigid motions"),
    "hinge_gap": Rule(0.02, "share by which sealing the gap of a hinge, here full of water, would change its "
        "stiffness; waves see it sealed", doubt=np.inf),
    "second_order": Rule(0.02, "share of a displacement's stiffness that its unknown second-order part may have; "
        "second_order states it", doubt=np.inf),
    "closure": Rule(1e-3, "difference of the volumes by the normals' x, y and z, of gaps between panels"),
    "displaced_mass": Rule(0.01, "mass in heave is that of the water displaced", doubt=1.0),
    "trim": Rule(0.01, "the centres of mass and buoyancy of a body that rotates lie on one vertical, in terms of the "
        "cube root of the displaced volume", doubt=np.inf),
    "mass_coupling": Rule(0.02, "the mass matrix couples shifts and rotations as the centre of mass says, in terms of "
        "the cube root of the displaced volume"),
}  # fmt: skip
"""Limits of the checks and their meaning."""
WAYS = ("fewer panels", "waves radiated")
"""How the errors of coefficients are estimated."""
BELOW_IRREGULAR = 0.9
"""Share of the first irregular frequency up to which none affects the coefficients."""
_CLOSED = 1e-6  # difference of the volumes without gaps
_LEAST_SIZE = 0.3  # of a displacement, relative to all displaced water moving like the surface
_LEAST_RATIO = 1.2  # of two resolutions that allow an estimate
_MATRICES = ("added_mass", "radiation_damping")
_AROUND = 0.2  # a resonance, relative: frequencies its error is judged apart at
_DROP = 0.75  # of added mass between two frequencies, in terms of that at infinity, that makes a resonance
_IDENTITIES = ("symmetry", "far_field", "haskind")
_ABOUT = 0.1  # error of the frequency of a gap's resonance, relative
_IRREGULAR = "; irregular frequencies begin at about {:.3g} rad/s, a lid (lid: 8) removes them"
_PISTON = (
    "; near {:.3g} rad/s the water resonates in a gap of {:.3g} m between two bodies, which is no irregular frequency: "
    "panels there as small as the gap is wide, and viscous damping (body.damping), for linear waves hardly damp it"
)


def _check(name: str, value: float, more: str = "", limit: float | None = None) -> Check:
    """The check of a name in `RULES`."""
    return RULES[name].check(name, value, more, limit)


class Block(NamedTuple):
    """Solution at one frequency; at infinity there are no waves."""

    own: xr.Dataset  # coefficients
    fewer: xr.Dataset  # added mass, damping and excitation on fewer panels
    waves: xr.Dataset  # damping by the energy of the far field, excitation by Haskind's relation


class Swept(NamedTuple):
    """Coefficients at the frequencies asked for, and the solutions they come from."""

    coefficients: xr.Dataset
    solved: list[Block]  # frequencies ascending
    error: float  # estimated, of interpolation, relative to the band's largest entry of each

    @property
    def resolution_ratio(self) -> float:
        """How many times as large the fewer panels are, in the mean over the surface."""
        return float(self.solved[0].own.attrs["resolution_ratio"])


# Sizes and errors


def least_sizes(body: FlexibleBody, density: float) -> FloatArray:
    """Return the least size of displacements, shape (dof,): yaw of a round body moves no water beyond round-off."""
    return np.asarray(_LEAST_SIZE * np.sqrt(density * body.volume * (body.modes**2).sum(axis=2).mean(axis=1)))


def sizes(added_mass_inf: FloatArray, least: FloatArray) -> FloatArray:
    """Return the sizes of displacements, roots of added mass at infinite frequency or the least, shape (dof,)."""
    return np.asarray(np.sqrt(np.maximum(np.diag(added_mass_inf), least**2)))


def identities(ds: xr.Dataset, problem: BodyProblem) -> dict[str, float]:
    """Return errors at one frequency in terms of the radiation impedance |B_ii + i omega A_ii| of both motions [-].

    Of A and B from symmetry, of B from the energy of the far field, of excitation from Haskind's relation. An entry of
    B is relative to sqrt(Z_i Z_j), of X_i to the excitation that damping Z_i has, sqrt(4 rho g v_g Z_i/k).
    """
    omega, water = float(ds.omega[0]), problem.water
    impedance = (ds.radiation_damping + 1j * omega * ds.added_mass).values[0]
    z = np.maximum(np.abs(np.diag(impedance)), omega * least_sizes(problem.body, water.density) ** 2)
    pair = np.sqrt(np.outer(z, z))
    wave = np.sqrt(z / haskind_factor(ds.omega.values, water.depth, water.density, water.gravity))
    far = (ds.radiation_damping - ds.far_field_damping).values[0]
    haskind = (ds.Froude_Krylov_force + ds.diffraction_force - ds.haskind_force).values[0]
    errors = (impedance - impedance.T) / pair, far / pair, haskind / wave
    return {name: float(np.abs(error).max()) for name, error in zip(_IDENTITIES, errors, strict=True)}


class Resonance(NamedTuple):
    """Enclosed water that resonates: a motion's added mass drops, mostly below zero, where its damping peaks."""

    omega: float  # [rad/s], between two frequencies solved
    motion: str


def resonances(body: FlexibleBody, solved: Sequence[Block], size: FloatArray) -> list[Resonance]:
    """Return the resonances of the water a body encloses, the first of each motion, as its coefficients show them."""
    if len(solved) < 2 or not encloses_water(body):
        return []
    own = joined(*(block.own for block in solved)).sortby("omega")
    omega, found = own.omega.values, []
    for i, label in enumerate(body.labels):
        drops = -np.diff(own.added_mass.values[:, i, i]) / size[i] ** 2
        if drops.max() > _DROP:
            first = int(np.argmax(drops > _DROP))
            found.append(Resonance(float((omega[first] + omega[first + 1]) / 2), label))
    return found


class Error(NamedTuple):
    """Estimated error of coefficients, relative to the band's largest entry of each [-], and where it is largest."""

    value: float
    omega: float  # [rad/s]
    motion: str


def error_estimate(solved: Sequence[Block], infinite: Block, size: FloatArray) -> float:
    """Return the estimated error of coefficients, relative to the band's largest entry of each [-]."""
    return largest_error(solved, infinite, size).value


def largest_error(solved: Sequence[Block], infinite: Block, size: FloatArray) -> Error:
    """Return the estimated error of coefficients and where it is largest.

    With panels r times as large, in the mean over the surface, the error of a method of order p grows by r^p: the
    change is r^p - 1 >= r - 1 times the error for p >= 1, the order of flat panels at worst. Errors common to both
    meshes are added for damping and excitation: the distances from the energy of the far field and from Haskind's
    relation. One, all of it, if panels found no partners to be joined with.
    """
    own, fewer, waves = (joined(*parts) for parts in zip(*solved, strict=True))
    ratio, labels = float(infinite.own.attrs["resolution_ratio"]), own.influenced_dof.values
    if ratio < _LEAST_RATIO:
        return Error(1.0, float(own.omega.values.max()), str(labels[0]))
    value, coarse, known = (_in_units(ds, size) for ds in (with_excitation(own), fewer, waves))
    limit, other = (ds.added_mass_inf.values / np.outer(size, size) for ds in infinite[:2])
    value["added_mass"], coarse["added_mass"] = (
        np.concatenate([values["added_mass"], at_infinity[None]])
        for values, at_infinity in ((value, limit), (coarse, other))
    )
    largest = {name: float(np.abs(v).max()) or 1.0 for name, v in value.items()}
    both = sum(apart(value[name], known[name]) / largest[name] for name in known)
    missed = {name: np.abs(value[name] - coarse[name]) / largest[name] / (ratio - 1) for name in value}
    totals = {name: float(error.max()) + (both if name in known else 0.0) for name, error in missed.items()}
    worst = max(totals, key=totals.__getitem__)
    at = missed[worst] + (np.abs(value[worst] - known[worst]) / largest[worst] if worst in known else 0.0)
    place = np.unravel_index(int(np.argmax(at)), at.shape)
    motion = place[-1] if worst == "excitation_force" else place[1]
    return Error(totals[worst], float([*own.omega.values, np.inf][place[0]]), str(labels[motion]))


def signed_errors(found: Swept) -> xr.Dataset | None:
    """Return estimated errors of added mass, damping and excitation with their signs, value less better value.

    By each of `WAYS`, on straight lines between the frequencies solved: from fewer panels, for an order of at least one
    (`error_estimate`); and the distances from the energy of the far field and from Haskind's relation. None if panels
    found no partners to be joined with.
    """
    if (ratio := found.resolution_ratio) < _LEAST_RATIO:
        return None
    own, fewer, waves = (joined(*parts).sortby("omega") for parts in zip(*found.solved, strict=True))
    own, at = with_excitation(own), found.coefficients.omega.values
    swapped, errors = dict(zip(PAIR, PAIR[::-1], strict=True)), {}
    for name in (*_MATRICES, "excitation_force"):
        value = own[name]
        by_waves = value - waves[name] if name in waves else 0.0 * value
        both = xr.concat([(fewer[name] - value) / (ratio - 1), by_waves], dim=ESTIMATE)
        between = both.interp(omega=at) if both.sizes["omega"] > 1 else both
        error = between.transpose(ESTIMATE, *value.dims)
        if name in _MATRICES:  # symmetric, as the matrices will be
            error = 0.5 * (error + error.rename(swapped).transpose(*error.dims))
        errors[f"{name}_{ESTIMATE}"] = error
    return xr.Dataset(errors).assign_coords({ESTIMATE: list(WAYS)})


def stiffness_error(body: FlexibleBody, stiffness: FloatArray, ratio: float, density: float, g: float) -> FloatArray:
    """Return estimated errors of the stiffness of still water, as `signed_errors`, (way, dof, dof) [N/m].

    From the same fewer panels; radiated waves do not depend on it.
    """
    fewer, _ = coarser_body(body, SYMMETRIES[detected_symmetry(body)])
    fewer = replace(fewer, centre_of_mass=body.centre_of_mass, second_order=body.second_order)
    change = hydrostatic_stiffness(fewer, density, g) - stiffness
    return np.array([change / (ratio - 1), np.zeros_like(change)])


def _in_units(ds: xr.Dataset, size: FloatArray) -> dict[str, npt.NDArray[np.inexact[Any]]]:
    """Added mass, damping and excitation of a dataset, as far as it has them, for displacements of unit size."""
    units = dict.fromkeys(_MATRICES, np.outer(size, size)) | {"excitation_force": size}
    return {name: ds[name].values / unit for name, unit in units.items() if name in ds}


# Verdict


def verdict(study: BodyFile, body: FlexibleBody, infinite: Block, found: Swept, size: FloatArray) -> list[Check]:
    """Return the checks of a database before it is symmetrized."""
    inside = resonances(body, found.solved, size)
    places = [float(block.own.omega[0]) for block in found.solved]
    around = [any(abs(omega / one.omega - 1) < _AROUND for one in inside) for omega in places]
    solved = [block for block, near in zip(found.solved, around, strict=True) if not near] or found.solved
    error = largest_error(solved, infinite, size)
    negative = quality.negative_damping(found.coefficients, np.outer(size, size))
    first = first_irregular_frequency(body, study.water.gravity)
    cure = "" if study.lid or study.omega[-1] < BELOW_IRREGULAR * first else _IRREGULAR.format(first)
    gap = gap_resonance(body, study.water.gravity)
    near = gap is not None and study.omega[0] < (1 + _ABOUT) * gap.omega and (1 - _ABOUT) * gap.omega < study.omega[-1]
    cure += _PISTON.format(*gap) if gap and near else ""
    checks = [_check("error_estimate", error.value, _place(error, None if cure else body) + cure)]
    if len(solved) < len(found.solved):
        named = ", ".join(f"{one.motion} at about {one.omega:.3g} rad/s" for one in inside)
        checks.append(_check("resonance", error_estimate(found.solved, infinite, size), f" {named}"))
    if study.tolerance is not None:
        text = f"{len(solved)} solves for {len(study.omega)} frequencies; {RULES['interpolation_error'].explanation}"
        checks.append(replace(_check("interpolation_error", found.error, limit=study.tolerance), explanation=text))
    checks.append(_check("one_resolution", 1 - infinite.own.attrs["coarser_share"]))
    checks += [_check(name, max(block.own.attrs[name] for block in solved), cure) for name in _IDENTITIES]
    return [*checks, _check("positive_damping", negative), *mesh_checks(study, body)]


def _place(error: Error, body: FlexibleBody | None) -> str:
    """Where an error above its limit is largest, and the panels of a body that would do, of order one at worst.

    None of a body whose error smaller panels do not mend.
    """
    limit = RULES["error_estimate"].limit
    if error.value <= limit:
        return ""
    where = "at infinite frequency" if np.isinf(error.omega) else f"at {error.omega:.3g} rad/s"
    panels = f", for which panels of about {panel_size(body) * limit / error.value:.2g} m would do" if body else ""
    return f"; largest in {error.motion} {where}{panels}"


def lid_check(solved: Sequence[Block], bare: Block, size: FloatArray) -> Check:
    """Return the check of a lid at the frequency of `bare`, solved without it, where it should change nothing."""
    omega = float(bare.own.omega[0])
    every, without = (_in_units(with_excitation(ds), size) for ds in (joined(*(b.own for b in solved)), bare.own))
    place = [float(b.own.omega[0]) for b in solved].index(omega)
    change = max(
        apart(every[name][[place]], without[name]) / (float(np.abs(every[name]).max()) or 1.0) for name in every
    )
    return _check("lid", change, f" at {omega:g} rad/s")


def mesh_checks(study: BodyFile, body: FlexibleBody) -> list[Check]:
    """Return the checks of a body's panels, displacements and mass, for which nothing need be solved."""
    k = wavenumber(study.omega[-1], study.water.depth, study.water.gravity)
    misfit = np.abs(at_centres(body.vertices, body.faces, body.shapes) - body.modes).max(axis=(1, 2))
    checks = [
        _check("panels", float(panel_diameters(body).max()) * k / (2 * np.pi)),
        _check("modes", 1 / panels_per_lobe(body)),
        _check("corners", float((misfit / np.abs(body.modes).max(axis=(1, 2))).max())),
        _check("rigid_names", rigid_misfit(body)),
    ]
    for name, share in (("hinge_gap", hinge_gap(body)), ("second_order", linear_share(body))):
        checks += [_check(name, share)] if share is not None else []
    if body.open_share > _CLOSED:
        more = f" {body.gaps.width:.3g} m wide, widest at {text_of(body.gaps.place)}"
        checks.append(_check("closure", body.open_share, more))
    heave = [i for i, (t, a) in body.rigid.items() if np.allclose([*t, *a], [0, 0, 1, 0, 0, 0], atol=1e-9)]
    if body.mass is not None and heave:
        weight = body.mass[heave[0], heave[0]] / (study.water.density * body.volume)
        checks.append(_check("displaced_mass", abs(weight - 1)))
    turning = np.isinf(body.bed) and any(np.any(rotation) for _, rotation in body.rigid.values())
    if turning and (centre := body.centre_of_mass) is not None and centre.ndim == 1:
        apart = (centre - body.centre_of_buoyancy)[:2]
        checks.append(_check("trim", float(np.hypot(*apart) / body.volume ** (1 / 3))))
        if body.mass is not None and (errors := _mass_coupling(body, body.mass, centre)):
            checks.append(_check("mass_coupling", max(errors) / body.volume ** (1 / 3)))
    return checks


def _mass_coupling(body: FlexibleBody, mass: FloatArray, centre: FloatArray) -> list[float]:
    """Distances [m] between the centre of mass and where each shift and rotation puts it: M_ij = m t_i . (a_j x r)."""
    shifts = [(i, one) for i, one in body.rigid.items() if not np.any(one.rotation) and mass[i, i] > 0]
    turns = [(j, one) for j, one in body.rigid.items() if np.any(one.rotation)]
    return [
        abs(mass[i, j] / mass[i, i] - shift.translation @ turn.at(centre) / np.sum(shift.translation**2))
        / float(np.linalg.norm(turn.rotation))
        for (i, shift), (j, turn) in product(shifts, turns)
    ]
