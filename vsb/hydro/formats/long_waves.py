"""What waves much longer than a body say of a file: lift, sign of phases, unit of headings, displaced volume.

Water moves with such a wave as a whole: by 1 upwards and by i g k/omega^2 along it per unit elevation at the origin
(C1, Re(X e^{-i omega t}), a wave e^{i k x}). A body at rest in it feels what it would if it moved so in still water,
the other way round. Per unit elevation

    X_heave = C - omega^2 (A + rho V) - i omega B,    X_surge = -i k g (rho V + A + i B/omega) cos(beta),

and sway likewise with sin(beta).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr

from vsb.hydro.database import Check, check_at_most
from vsb.hydro.formats.modes import volume_of
from vsb.study.quantities import RIGID, body_of, motion_of, of_bodies
from vsb.tools.arrays import ComplexArray, FloatArray
from vsb.waves.dispersion import wavenumber

LARGEST_PHASE = 0.2
"""Distance of the forces over headings from those of long waves, both scaled to length one, 0 to 2."""
_LONG = 0.2
"""Second order of heave, omega^2 (A + displaced water)/C, up to which waves are long."""
_PARTS = ("excitation_force", "Froude_Krylov_force", "diffraction_force")
_ALONG: dict[str, Callable[[FloatArray], FloatArray]] = {"Surge": np.cos, "Sway": np.sin}
_READINGS = (
    ("their complex conjugates would fit (or headings the waves come from)", -1.0, 1.0),
    ("headings would fit in degrees where they are read as radians", 1.0, np.pi / 180),
    ("headings would fit in radians where they are read as degrees", 1.0, 180 / np.pi),
)
"""What else a file may mean: sign of forces of surge and sway, and factor of its headings."""


class _Heaving(NamedTuple):
    """A body with a waterplane."""

    name: str
    heave: int  # its place among the degrees of freedom
    along: list[int]  # surge and sway
    second_order: FloatArray  # omega^2 (A + displaced water)/C, (omega,)


def _heaving(ds: xr.Dataset, added_mass: FloatArray) -> list[_Heaving]:
    """Bodies that heave with a waterplane; their largest added mass of a translation stands for the water displaced."""
    labels, stiffness = list(map(str, ds.influenced_dof.values)), np.diag(ds.hydrostatic_stiffness.values)
    found = []
    for i in (i for i, label in enumerate(labels) if motion_of(label) == "Heave" and stiffness[i] > 0):
        its = of_bodies(labels)[body_of(labels[i])]
        water = max(added_mass[j] for j in its if motion_of(labels[j]) in RIGID[:3])
        along = [j for j in its if motion_of(labels[j]) in _ALONG]
        order = ds.omega.values**2 * (added_mass[i] + water) / stiffness[i]
        found.append(_Heaving(body_of(labels[i]), i, along, order))
    return found


def lift_check(ds: xr.Dataset, added_mass: FloatArray) -> tuple[list[Check], list[str]]:
    """Return the check of the heave excitation in the longest wave against hydrostatic stiffness, or why there is none.

    The limit is widened by twice the second order. Of several bodies the worst counts, and those alone whose longest
    wave is one.

    Parameters
    ----------
    ds : xarray.Dataset
        Without zero frequency.
    added_mass : ndarray, shape (dof,) [kg]
        Sizes, see `foreign.sizes`.
    """
    bodies = _heaving(ds, added_mass)
    if not bodies:
        return [], ["not checked: long_waves, which needs heave and a waterplane"]
    found = []
    for body in (body for body in bodies if body.second_order[0] <= _LONG):
        force = np.abs(ds.excitation_force.values[0, :, body.heave])
        error = float(np.abs(force / float(ds.hydrostatic_stiffness[body.heave, body.heave]) - 1).max())
        found.append((error, 0.05 + 2 * float(body.second_order[0])))
    if not found:
        return [], [f"not checked: long_waves, of which {ds.omega.values[0]:.4g} rad/s is none for this body"]
    error, limit = max(found, key=lambda one: one[0] - one[1])
    text = "waves much longer than the body lift it by its hydrostatic stiffness"
    return [check_at_most("long_waves", error, limit, "-", text)], []


def phase_check(ds: xr.Dataset, added_mass: FloatArray) -> tuple[list[Check], list[str]]:
    """Return the check of phases and headings in long waves, or a line that they are not checked.

    Surge and sway beside heave show both, wherever the body lies; heave alone the sign of its own phase, about the
    origin. What another reading of the file explains is a failure, and named. Parameters as of `lift_check`.
    """
    bodies = _heaving(ds, added_mass)
    patterns = [pattern for body in bodies for pattern in _patterns(ds, body)]
    signs = [sign for body in bodies if (sign := _heave_sign(ds, body)) is not None]
    if not patterns and not signs:
        return [], ["not checked: phases, sign and headings of which surge and heave show in long waves"]
    headings = ds.wave_direction.values
    worst, where = max([(each.error(headings), each.where) for each in patterns] + signs)
    text = f"in waves much longer than the body forces follow from the motion of the water; most {where}"
    check = check_at_most("phases", worst, LARGEST_PHASE, "-", text, doubt=True)
    for reading, turn, factor in _READINGS if check.verdict != "ok" else ():
        errors = [each.error(headings * factor, turn) for each in patterns]
        errors += [error if turn > 0 else 2.0 - error for error, _ in signs]
        if max(errors) <= LARGEST_PHASE:
            return [Check("phases", worst, LARGEST_PHASE, "-", "fail", f"{text}; {reading}")], []
    return [check], []


class _Pattern(NamedTuple):
    """Forces of surge or sway over headings in the longest wave, relative to the phase of heave."""

    where: str
    force: ComplexArray  # (wave_direction,)
    share: ComplexArray  # of what the water's surge and its sway give, (2,)

    def error(self, headings: FloatArray, sign: float = 1.0) -> float:
        """Return the distance from long waves with these headings."""
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
    lift = ds.excitation_force.values[0, :, body.heave]
    turned = np.exp(-1j * np.angle(lift))
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
    """0 if heave has the imaginary part -omega B, 2 if it has the opposite one; none where it has neither.

    As away from the origin, where the phase is that of the place.
    """
    labels, long = list(map(str, ds.influenced_dof.values)), body.second_order <= 2 * _LONG
    heaves = [motion_of(label) == "Heave" for label in labels]
    own = ds.excitation_force.values[long, :, body.heave].imag.mean(axis=1)
    expected = -(ds.omega.values * ds.radiation_damping.values[:, body.heave, heaves].sum(axis=1))[long]
    for error, sign in ((0.0, 1.0), (2.0, -1.0)):
        if np.linalg.norm(own - sign * expected) < 0.5 * np.linalg.norm(expected):
            return error, f"up to {ds.omega.values[long][-1]:.4g} rad/s in {labels[body.heave]}"
    return None


def volume_check(ds: xr.Dataset, added_mass: FloatArray) -> list[Check]:
    """Return the check of the displaced volume by the Froude-Krylov force in long waves, k rho g V, where both are."""
    if "Froude_Krylov_force" not in ds:
        return []
    water = {name: float(ds.attrs[name]) for name in ("water_density", "gravity", "water_depth")}
    pull = wavenumber(float(ds.omega[0]), water["water_depth"], water["gravity"])
    pull *= water["water_density"] * water["gravity"]
    checks = []
    for body in (body for body in _heaving(ds, added_mass) if body.second_order[0] <= _LONG):
        volume = float(ds.attrs.get(volume_of(body.name), 0.0))
        for j in body.along:
            share = np.abs(_ALONG[motion_of(str(ds.influenced_dof.values[j]))](ds.wave_direction.values))
            if volume and share.max() > 0.5:
                own = float(np.abs(ds.Froude_Krylov_force.values[0, share.argmax(), j]) / share.max()) / pull
                text = f"long waves push with the water displaced; {own:.4g} m^3 would fit"
                limit = 0.05 + 2 * float(body.second_order[0])
                checks.append(check_at_most("displaced_volume", abs(own / volume - 1), limit, "-", text, doubt=True))
    return sorted(checks, key=lambda check: check.value - check.limit)[-1:]
