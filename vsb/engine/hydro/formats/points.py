"""Points that a file of coefficients states, found again from its forces and matrices.

The undisturbed wave e^{kz + ikx} of deep water is the generating function of a body's moments. With its integrals J
over the displaced water and W over the waterplane, and Gauss's theorem, its forces on the body are

    X_surge = -i k rho g J,    X_heave = rho g (W - k J),    X_pitch = i dX_heave/dk - X_surge/k - z X_surge + x X_heave

per unit elevation at the origin, rotations about (x, z): the forces say which point the moments are about. And
ln J = ln V + k (z_b + i x_b) + O(k^2) holds the displaced volume and the centre of buoyancy. In waves from another
direction x is measured along it.

Among all waterplanes of an area S a disc has the smallest polar moment, S^2/(2 pi), which with C_heave = rho g S and
C_roll + C_pitch = rho g (S_xx + S_yy + 2 V (z_b - z_g)) bounds the height of the centre of mass from below. A mass
matrix couples shifts t and rotations a by m t . (a x (r_g - r)), r the centre of rotation.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from vsb.engine.hydro.database import Check, Rule
from vsb.engine.hydro.formats.common import point_of, rotation_centre, volume_of
from vsb.engine.hydro.variables import RIGID, ROTATIONS, motion_of, of_bodies
from vsb.engine.waves.water import wavenumber
from vsb.tools.arrays import ComplexArray, FloatArray

RULES = {
    "rotation_centre": Rule(0.05, "moments of the undisturbed wave are about the point that rotations turn about, in "
        "terms of the cube root of the displaced volume",
        causes="centre of mass or of rotations of another body or run; moments about another point; phases about the "
        "place of each of several bodies"),
    "centre_of_buoyancy": Rule(0.05, "forces of the undisturbed wave act at the centre of buoyancy, in terms of the "
        "cube root of the displaced volume", doubt=np.inf,
        causes="the centre of another body or run; phases about another point"),
    "waterplane": Rule(0.02, "height by which the centre of mass is too low, over the cube root of the displaced "
        "volume: stiffness in roll and pitch leaves the waterplane less than the moments of a disc of its area",
        causes="a centre of mass too low or of buoyancy too high; stiffness of another body or run"),
    "mass_coupling": Rule(0.02, "the mass matrix couples shifts and rotations as the centre of mass says, in terms of "
        "the cube root of the displaced volume",
        causes="mass matrix about another point; centre of mass of another body or run"),
    "places": Rule(0.3, "bodies lie where the phases of heave say, in terms of the cube root of the displaced volume",
        doubt=1.0, causes="phases about the place of each body; centres of another run"),
}  # fmt: skip
"""Limits of the checks, their meaning, and likely causes."""
OF_ROTATIONS = ("rotation_centre", "waterplane", "mass_coupling")
"""Checks that do not concern a body that only shifts."""
BY_WAVES = ("rotation_centre", "centre_of_buoyancy", "places")
"""Checks of the forces of waves."""
_DEEP = 3.0  # depth times wavenumber from which water is deep
_FEWEST = 6  # frequencies
_COARSE = 0.08  # of the moments of a waterplane, by coarse panels
_SMALL = 1e-6  # share of a motion in those along a direction that is none


class _Single(NamedTuple):
    """What a database knows of one body; lengths are relative to the cube root of its volume."""

    name: str
    places: dict[str, int]  # of its rigid motions among the degrees of freedom
    volume: float  # [m^3]
    buoyancy: FloatArray | None  # centres (xyz,) [m]
    mass: FloatArray | None
    rotation: FloatArray | None

    @property
    def size(self) -> float:
        """Cube root of the displaced volume [m]."""
        return float(self.volume ** (1 / 3))

    def share(self, values: ComplexArray, along: dict[str, float]) -> ComplexArray | None:
        """Return the sum of forces of motions (..., dof) by their shares; None if one that has a share is missing."""
        used = {motion: part for motion, part in along.items() if abs(part) > _SMALL}
        if used.keys() - self.places.keys():
            return None
        return np.asarray(sum(part * values[..., self.places[motion]] for motion, part in used.items()))


def point_checks(ds: xr.Dataset) -> list[Check]:
    """Return the checks of the points a database of positive frequencies states, as far as they follow from it."""
    found = []
    for body in _bodies(ds):
        found += [*_in_waves(ds, body), *_at_rest(ds, body), *_placed(ds, body)]
    worst: dict[str, Check] = {}
    for check in found:
        if check.name not in worst or check.value / check.limit > worst[check.name].value / worst[check.name].limit:
            worst[check.name] = check
    return list(worst.values())


def _bodies(ds: xr.Dataset) -> list[_Single]:
    """Bodies whose volume is known."""
    labels, found = list(map(str, ds.influenced_dof.values)), []
    for name, places in of_bodies(labels).items():
        volume = float(ds.attrs.get(volume_of(name), 0.0))
        rigid = {motion_of(labels[i]): i for i in places if motion_of(labels[i]) in RIGID}
        buoyancy, mass, turned = (
            None if (value := ds.attrs.get(point_of(key, name))) is None else np.asarray(value, dtype=float)
            for key in ("centre_of_buoyancy", "centre_of_mass", "rotation_centre")
        )
        if volume > 0 and rigid:
            found.append(_Single(name, rigid, volume, buoyancy, mass, turned if name else rotation_centre(ds)))
    return found


def _along(heading: float) -> tuple[FloatArray, dict[str, float], dict[str, float]]:
    """A direction, and the shares of shifts along it and of rotations across it."""
    x, y = np.cos(heading), np.sin(heading)
    return np.array([x, y, 0.0]), {"Surge": x, "Sway": y}, {"Pitch": x, "Roll": -y}


def _in_waves(ds: xr.Dataset, body: _Single) -> list[Check]:
    """Centres of rotation and of buoyancy by the Froude-Krylov forces of deep water."""
    if "Froude_Krylov_force" not in ds or "Heave" not in body.places:
        return []
    depth, gravity, density = (float(ds.attrs[name]) for name in ("water_depth", "gravity", "water_density"))
    waves = np.array([wavenumber(float(omega), depth, gravity) for omega in ds.omega.values])
    deep = waves * depth > _DEEP
    if np.count_nonzero(deep) < _FEWEST:
        return []
    k, forces, checks = waves[deep], ds.Froude_Krylov_force.values[deep], []
    for j, heading in enumerate(ds.wave_direction.values):
        direction, shifts, turns = _along(float(heading))
        centre = next((point for point in (body.rotation, body.buoyancy) if point is not None), np.zeros(3))
        x = float(centre @ direction)  # forces are smoother with phases about there
        near = forces[:, j] * np.exp(-1j * k * x)[:, None]
        surge, heave, pitch = body.share(near, shifts), near[:, body.places["Heave"]], body.share(near, turns)
        if surge is None or not np.abs(surge).any():
            continue
        if pitch is not None and np.abs(pitch).any() and body.rotation is not None:
            point, misfit = _turned_about(k, surge, heave, pitch)
            unsure = np.abs(_turned_about(k[::2], surge[::2], heave[::2], pitch[::2])[0] - point).max()
            error = max(float(np.abs(point - [0.0, body.rotation[2]]).max()), misfit) / body.size
            limit = RULES["rotation_centre"].limit + 2 * float(unsure) / body.size
            more = f"; {_text(point[0] + x, point[1])} m would fit{_of(body)}"
            checks.append(RULES["rotation_centre"].check("rotation_centre", error, more, limit))
        long = k * body.size <= 1
        if body.buoyancy is not None and np.count_nonzero(long) >= _FEWEST and k[0] * body.size < 1 / 2:
            moments = 1j * surge[long] / (k[long] * density * gravity * body.volume)
            logarithm = np.log(np.abs(moments)) + 1j * np.unwrap(np.angle(moments))
            slope = np.polynomial.polynomial.polyfit(k[long], logarithm, 3)[1] + 1j * x
            stated = complex(body.buoyancy[2], body.buoyancy @ direction)
            more = f"; {_text(slope.imag, slope.real)} m would fit{_of(body)}"
            error = max(abs((slope - stated).real), abs((slope - stated).imag)) / body.size
            checks.append(RULES["centre_of_buoyancy"].check("centre_of_buoyancy", error, more))
    return checks


def _turned_about(
    k: FloatArray, surge: ComplexArray, heave: ComplexArray, pitch: ComplexArray
) -> tuple[FloatArray, float]:
    """Point (x, z) that moments are about, and how far the moments are from it [m]."""
    rest = pitch - 1j * CubicSpline(k, heave)(k, 1) + surge / k
    forces = np.stack([heave, -surge], axis=-1)
    point, *_ = np.linalg.lstsq(np.concatenate([forces.real, forces.imag]), np.concatenate([rest.real, rest.imag]))
    return point, float(np.linalg.norm(rest - forces @ point) / np.linalg.norm(forces))


def _at_rest(ds: xr.Dataset, body: _Single) -> list[Check]:
    """The waterplane that stiffness and centres leave, and the mass matrix by the centre of mass."""
    if body.mass is None:
        return []
    found, density, gravity = [], float(ds.attrs["water_density"]), float(ds.attrs["gravity"])
    if body.buoyancy is not None and {"Heave", "Roll", "Pitch"} <= body.places.keys():
        area, roll, pitch = (
            float(ds.hydrostatic_stiffness.values[i, i]) / (density * gravity)
            for i in (body.places[motion] for motion in ("Heave", "Roll", "Pitch"))
        )
        least = area**2 / (2 * np.pi)
        polar = roll + pitch + 2 * body.volume * float(body.mass[2] - body.buoyancy[2])
        if least > 1e-3 * body.size**4:
            low = max(0.0, (1 - _COARSE) * least - polar) / (2 * body.volume * body.size)
            found.append(RULES["waterplane"].check("waterplane", low, _of(body)))
    if "inertia_matrix" in ds and body.rotation is not None:
        matrix, arm = ds.inertia_matrix.values, body.mass - body.rotation
        errors = [
            abs(matrix[i, j] - matrix[i, i] * np.cross(np.eye(3)[ROTATIONS.index(turn)], arm)[RIGID.index(shift)])
            / (matrix[i, i] * body.size)
            for turn, j in body.places.items()
            for shift, i in body.places.items()
            if turn in ROTATIONS and shift not in ROTATIONS and matrix[i, i] > 0
        ]
        if errors:
            found.append(RULES["mass_coupling"].check("mass_coupling", float(max(errors)), _of(body)))
    return found


def _placed(ds: xr.Dataset, body: _Single) -> list[Check]:
    """The phase of heave in the longest wave by the place of one of several bodies, see `checks`."""
    labels = list(map(str, ds.influenced_dof.values))
    names = of_bodies(labels)
    stated = {name: ds.attrs.get(point_of("centre_of_mass", name)) for name in names}
    if len(names) < 2 or "Heave" not in body.places or any(centre is None for centre in stated.values()):
        return []
    depth, gravity, density = (float(ds.attrs[name]) for name in ("water_depth", "gravity", "water_density"))
    omega, row, checks = float(ds.omega[0]), body.places["Heave"], []
    centres = {name: np.asarray(centre, dtype=float) for name, centre in stated.items()}
    k, stiffness = wavenumber(omega, depth, gravity), float(ds.hydrostatic_stiffness.values[row, row])
    inertia = ds.added_mass.values[0, row] + 1j * ds.radiation_damping.values[0, row] / omega
    if not stiffness > 0 or k * body.size > 1 / 2:
        return []
    for j, heading in enumerate(ds.wave_direction.values):
        direction, shifts, _ = _along(float(heading))
        at = {name: np.exp(1j * k * float(centre @ direction)) for name, centre in centres.items()}
        expected = (stiffness - omega**2 * density * body.volume) * at[body.name]
        for label, mass in zip(labels, inertia, strict=True):
            name = next(one for one in names if labels.index(label) in names[one])
            slid = 1j * k * gravity / omega**2 * at[name]
            moved = {"Heave": at[name]} | {shift: part * slid for shift, part in shifts.items()}
            expected -= omega**2 * mass * moved.get(motion_of(label), 0.0)
        turned = float(np.angle(ds.excitation_force.values[0, j, row] / expected))
        more = f"; heave of {body.name} is {np.degrees(turned):.3g} degrees ahead at {omega:.4g} rad/s"
        checks.append(RULES["places"].check("places", abs(turned) / (k * body.size), more))
    return checks


def _text(x: float, z: float) -> str:
    """A point along the waves and upwards."""
    return f"{round(x, 3) + 0.0:.4g} along the waves and z = {round(z, 3) + 0.0:.4g}"


def _of(body: _Single) -> str:
    """Which of several bodies."""
    return f", of {body.name}" if body.name else ""
