"""A body of any shape: its wetted panels and the displacements it can make, checked when made.

Displacements are dimensionless fields psi_i on the wetted surface, one per degree of freedom, whose amplitudes are
metres, or radians for rotations. Normals point into the water.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise, permutations
from typing import NamedTuple, Protocol

import numpy as np
import xarray as xr
from scipy.spatial import cKDTree

from vsb.engine.hydro.bodies.mesh import (
    AT_SURFACE,
    RIGID_TO,
    SAME,
    Gaps,
    Rigid,
    at_centres,
    check_closed,
    check_vertices,
    gaps,
    owners,
    panel_edges,
    parts,
    rigid_motion,
    solid_angle_share,
    text_of,
    without_thickness,
)
from vsb.engine.hydro.variables import RIGID, body_of
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray, IntArray


class Sections(NamedTuple):
    """Motion of the sections that points (..., xyz) lie in: psi = shift + turn x rho."""

    shift: FloatArray  # T (..., xyz) [-]
    turn: FloatArray  # omega (..., xyz) [1/m]
    stretch: FloatArray  # dT/ds (..., xyz) [1/m]
    bend: FloatArray  # d omega/ds (..., xyz) [1/m^2]

    def displacement(self, rho: FloatArray) -> FloatArray:
        """Return psi at places across the axis, shape (..., xyz)."""
        return np.asarray(self.shift + np.cross(self.turn, rho))

    def strain(self, rho: FloatArray, axis: int) -> FloatArray:
        """Return the strain along the axis at places across it, shape (...) [1/m]."""
        return np.asarray((self.stretch + np.cross(self.bend, rho))[..., axis])


class TurningField(Protocol):
    """A displacement of one part of a body whose sections or pieces rotate."""

    def sections(self, points: FloatArray, axis: int) -> Sections:
        """Return the motion at points of each of the part's triangles, shape (triangle, n, xyz)."""


class Beam(NamedTuple):
    """A displacement known to be that of a beam: its axis, 0 or 1, and the motion of its sections."""

    axis: int
    field: TurningField


PLANES = {"xOz": 1, "yOz": 0}
"""Planes of symmetry and the coordinate each of them changes the sign of."""
SYMMETRIES = {"none": (), "xOz": ("xOz",), "yOz": ("yOz",), "xOz+yOz": ("xOz", "yOz")}
"""Symmetries a body file may declare."""
CLOSED = 1e-2
"""Largest relative difference of the three volumes of a closed surface: the effect its gaps may have."""
LEAST_PANELS = 4
"""Of a separate part: panels whose corners only nearly coincide make no body."""
_LEAST_BODY = 0.01  # [m], lengths below which capytaine's own tolerances drop panels
_BEFORE = 1e-3  # distance in front of a panel at which there must be water, relative to the panel


class Triangles(NamedTuple):
    """Halves of the panels: corners, vector areas, and the displacements of the corners."""

    corner: FloatArray  # (triangle, 3, xyz) [m]
    area: FloatArray  # (triangle, xyz) [m^2], along the normal
    moved: FloatArray  # (dof, triangle, 3, xyz) [-]

    def integral(self, f: FloatArray, g: FloatArray) -> FloatArray:
        """Integral of the product of fields linear in each triangle, (..., triangle, 3) [-]; weights are f's."""
        return np.asarray((f.sum(axis=-1) * g.sum(axis=-1) + (f * g).sum(axis=-1)).sum(axis=-1) / 12)

    def squared_gradients(self, dofs: list[int]) -> FloatArray:
        """Return int |grad psi|^2 dS of each triangle, zero of empty ones, shape (dof, triangle)."""
        (e, f), moved = (self.corner[:, k] - self.corner[:, 0] for k in (1, 2)), self.moved[dofs]
        de, df = (moved[:, :, k] - moved[:, :, 0] for k in (1, 2))
        area = np.linalg.norm(self.area, axis=1)
        whole = area > 1e-12 * area.max()
        ee, ef, ff = ((a * b).sum(axis=1) for a, b in ((e, e), (e, f), (f, f)))
        squared = ff * (de**2).sum(axis=2) - 2 * ef * (de * df).sum(axis=2) + ee * (df**2).sum(axis=2)
        return np.asarray(np.where(whole, squared / (4 * np.where(whole, area, 1.0)), 0.0))


@dataclass(frozen=True)
class FlexibleBody:
    """Wetted surface of a body at rest and the displacements it can make.

    Triangles repeat their last corner. `mass` and `stiffness`, the modal matrices, shape (dof, dof) [kg, N/m], and
    `centre_of_mass`, shape (3,) [m], are None where the file has none. Rotations need the centre of mass; if one of
    several separate parts rotates alone, a row for each part, shape (part, 3), in the order of their first panels.
    """

    vertices: FloatArray  # (vertex, xyz) [m]
    faces: IntArray  # (panel, 4)
    labels: tuple[str, ...]
    modes: FloatArray  # (dof, panel, xyz): displacement of the panels' centres [-]
    shapes: FloatArray  # (dof, vertex, xyz): of their corners
    mass: FloatArray | None = None
    stiffness: FloatArray | None = None
    centre_of_mass: FloatArray | None = None
    second_order: FloatArray | None = None  # (dof, dof, vertex, xyz): d2x/dq_i dq_j of the corners [1/m]
    history: str = ""  # of repairs
    bed: float = -np.inf  # height of the sea bed the hull stands on [m]; the hull is open there
    beams: Mapping[int, Beam] = field(default_factory=dict)  # degrees of freedom known to bend as beams

    def __post_init__(self) -> None:
        """Refuse a body that cannot be solved."""
        _check_panels(self)
        _check_modes(self)
        _check_centre_of_mass(self)

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounding box [m]."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @cached_property
    def triangles(self) -> Triangles:
        """The panels as pairs of triangles, the second one empty if the panel is a triangle."""
        corner = self.vertices[self.triangle_corners]
        area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2
        return Triangles(corner, area, self.shapes[:, self.triangle_corners])

    @property
    def triangle_corners(self) -> IntArray:
        """Vertices of `triangles`, shape (triangle, 3)."""
        return np.concatenate([self.faces[:, [0, 1, 2]], self.faces[:, [0, 2, 3]]])

    @cached_property
    def vector_areas(self) -> FloatArray:
        """Vector areas of the panels, shape (panel, xyz) [m^2]."""
        return np.asarray(self.triangles.area.reshape(2, -1, 3).sum(axis=0))

    @cached_property
    def centres(self) -> FloatArray:
        """Centroids of the panels, shape (panel, xyz) [m]."""
        return np.asarray(at_centres(self.vertices, self.faces, self.vertices[None])[0])

    @cached_property
    def bed_edges(self) -> tuple[IntArray, IntArray]:
        """Edges on the sea bed in the direction around their panels, shape (edge, 2), and the panel of each."""
        edges, panel = panel_edges(owners(self.vertices)[self.faces])
        on = (self.vertices[edges][..., 2] <= self.bed).all(axis=1)
        return edges[on], panel[on]

    @cached_property
    def bed_lid(self) -> FloatArray:
        """Triangles that close the hull on the sea bed, whose signed areas add up, shape (edge, 3, xyz) [m]."""
        ends = self.vertices[self.bed_edges[0]]
        middle = np.broadcast_to(ends.mean(axis=(0, 1)), (len(ends), 3)) if len(ends) else np.empty((0, 3))
        return np.stack([ends[:, 1], ends[:, 0], middle], axis=1)

    @cached_property
    def _closed(self) -> tuple[FloatArray, FloatArray]:
        """Corners (triangle, 3, xyz) [m] and vector areas (triangle, xyz) [m^2] of the wetted surface and `bed_lid`."""
        lid = self.bed_lid
        under = np.cross(lid[:, 1] - lid[:, 0], lid[:, 2] - lid[:, 0]) / 2
        return np.concatenate([self.triangles.corner, lid]), np.concatenate([self.triangles.area, under])

    @cached_property
    def volumes(self) -> FloatArray:
        """Volume of displaced water three times, from the x, y and z components of the normals, shape (3,) [m^3].

        That of a hull on the sea bed ends there.
        """
        corner, area = self._closed
        return np.asarray((corner.mean(axis=1) * area).sum(axis=0))

    @property
    def volume(self) -> float:
        """Volume of displaced water [m^3]."""
        return float(self.volumes[2])

    @cached_property
    def centre_of_buoyancy(self) -> FloatArray:
        """Centre of the displaced water, shape (xyz,) [m]."""
        corner, area = self._closed
        square = ((corner**2).sum(axis=1) + corner.sum(axis=1) ** 2) / 12  # mean of x^2 over a triangle
        return np.asarray((square * area).sum(axis=0) / 2 / self.volumes)

    @cached_property
    def open_share(self) -> float:
        """Largest relative difference of the three volumes: the effect of gaps between panels."""
        return float(np.ptp(self.volumes) / self.volumes.max())

    @cached_property
    def gaps(self) -> Gaps:
        """Gaps between panels whose edges run beside each other without meeting."""
        return gaps(self.vertices, owners(self.vertices)[self.faces], -AT_SURFACE * self.size, self.bed)

    @cached_property
    def part(self) -> IntArray:
        """Number of the separate part each panel belongs to, in the order of their first panels, shape (panel,)."""
        return parts(owners(self.vertices)[self.faces], self.gaps.beside)

    @property
    def part_count(self) -> int:
        """Number of separate parts."""
        return int(self.part.max()) + 1

    @cached_property
    def vertex_part(self) -> IntArray:
        """Part of each vertex; a vertex of no panel is of the part next to it, shape (vertex,)."""
        corners, first = np.unique(self.faces, return_index=True)
        nearest = cKDTree(self.vertices[corners]).query(self.vertices)[1]
        return np.asarray(np.repeat(self.part, self.faces.shape[1])[first][nearest])

    @cached_property
    def rigid(self) -> dict[int, Rigid]:
        """Degrees of freedom that move the whole body rigidly."""
        motions = {i: rigid_motion(self.vertices, shape) for i, shape in enumerate(self.shapes)}
        return {i: motion for i, motion in motions.items() if motion}

    @cached_property
    def rigid_parts(self) -> dict[int, tuple[Rigid, ...]]:
        """Degrees of freedom that move each of several separate parts rigidly, not all alike: the motion of each."""
        found: dict[int, tuple[Rigid, ...]] = {}
        count = np.bincount(self.part)
        if len(count) == 1 or count.min() < LEAST_PANELS:
            return found
        corners = [np.unique(self.faces[self.part == p]) for p in range(len(count))]
        for i, shape in enumerate(self.shapes):
            size = float(np.abs(shape[self.faces]).max())
            motions = [rigid_motion(self.vertices[c], shape[c], size) for c in corners] if i not in self.rigid else []
            if rigid := tuple(motion for motion in motions if motion):
                found |= {i: rigid} if len(rigid) == len(corners) else {}
        return found

    @property
    def flexible(self) -> list[int]:
        """Degrees of freedom that move neither the body nor each of its parts rigidly."""
        return [i for i in range(len(self.labels)) if i not in self.rigid and i not in self.rigid_parts]


# Checks of a body when it is made


def _check_panels(body: FlexibleBody) -> None:
    """Panels must be finite, wet, and bound a volume of water from inside."""
    x, faces = body.vertices, body.faces
    check_vertices(x)
    if len(faces) == 0 or faces.min() < 0 or faces.max() >= len(x):
        raise ConfigError(f"mesh: {len(faces)} panels between {len(x)} vertices; needs panels whose corners are there")
    if body.size < _LEAST_BODY:
        raise ConfigError(f"mesh: body of {body.size:.3g} m; needs at least {_LEAST_BODY:g} m: is it in metres?")
    used = x[np.unique(faces)]
    if used[:, 2].max() > SAME * body.size:
        raise ConfigError(f"mesh: reaches z = {used[:, 2].max():.4g} m; needs z <= 0: clip it at the water's surface")
    if (x[faces][:, :, 2] > -SAME * body.size).all(axis=1).any():
        raise ConfigError("mesh: has panels in the water's surface; needs the wetted surface alone, no lid")
    if body.volumes.max() <= 0:
        raise ConfigError(
            f"mesh: encloses {body.volumes.max():.4g} m^3; needs normals that point into the water: flip them"
        )
    if len(body.gaps.open):  # plates without thickness and walls inside are named before what they leave open
        thin = without_thickness(x, owners(x)[faces], body.part, -AT_SURFACE * body.size)
        if thin.any():
            raise ConfigError(
                f"mesh: {np.count_nonzero(thin)} panels, the first at {text_of(body.centres[thin][0])}, enclose no "
                "volume: a plate without thickness, which is not solved, or a wall inside the hull; needs the plate "
                "with its thickness, or the wall deleted"
            )
    check_closed(body.gaps)
    if np.ptp(body.volumes) > CLOSED * body.volumes.max():
        raise ConfigError(
            "mesh: encloses {:.6g}, {:.6g} and {:.6g} m^3 by the normals' x, y and z; needs a surface that is closed "
            "below z = 0 with all normals into the water".format(*body.volumes)
        )


def bed_below(vertices: FloatArray, depth: float) -> float:
    """Return the height of the sea bed [m] if a hull, shape (vertex, xyz) [m], stands on it; -inf if it floats clear.

    Raises `ConfigError` if it reaches below the bed.
    """
    draught, tolerance = -float(vertices[:, 2].min()), AT_SURFACE * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if draught > depth + tolerance:
        raise ConfigError(
            f"water.depth: received {depth:g} m, less than the body's draught of {draught:.6g} m; needs deeper water, "
            "or a hull cut off at the sea bed, if it stands there"
        )
    return -depth if draught >= depth - tolerance else -np.inf


def _check_modes(body: FlexibleBody) -> None:
    """Every degree of freedom needs a name of its own, a finite shape, and rows in the matrices."""
    n = len(body.labels)
    if n == 0 or len(set(body.labels)) < n:
        raise ConfigError(f"modes: labels {str(list(body.labels))[:200]}; needs at least one, and none twice")
    needed: dict[str, tuple[int, ...]] = {"modes": (n, len(body.faces), 3), "shapes": (n, len(body.vertices), 3)}
    symmetric: dict[str, tuple[int, ...]] = dict.fromkeys(("mass", "stiffness"), (n, n))
    symmetric |= {"second_order": (n, n, len(body.vertices), 3)}
    for name, shape in (needed | symmetric).items():
        values = getattr(body, name)
        if values is None:
            continue
        if np.shape(values) != shape:
            raise ConfigError(f"{name}: shape {np.shape(values)}; needs {shape} for {n} labels and this mesh")
        if not np.isfinite(values).all():
            raise ConfigError(f"{name}: holds NaN or infinite values; needs finite ones")
        if name in symmetric and np.abs(values - values.swapaxes(0, 1)).max() > 1e-9 * np.abs(values).max():
            raise ConfigError(f"{name}: not symmetric; needs a symmetric matrix")
    foot = body.vertices[:, 2] <= body.bed  # sealed to the sea bed: what lifts it lets the water in
    for label, shape in zip(body.labels, body.shapes, strict=True):
        if np.abs(shape[foot, 2]).max(initial=0.0) > RIGID_TO * np.abs(shape).max():
            raise ConfigError(
                f"modes: {label} lifts the foot of a hull that stands on the sea bed, at z = {body.bed:g} m; needs "
                "motions along the bed (Surge, Sway, Yaw, or a file of displacements whose foot keeps its height); of "
                "a flap on a hinge the hull above the hinge, closed below"
            )
    flux = np.abs(np.einsum("ipx,px->ip", body.modes, body.vector_areas)).max(axis=1)
    flux /= np.linalg.norm(body.vector_areas, axis=1).max()
    for label, moved, shape in zip(body.labels, flux, body.modes, strict=True):
        if moved <= 1e-12 * np.abs(shape).max():
            raise ConfigError(f"modes: {label} moves no water; remove it")


def _check_centre_of_mass(body: FlexibleBody) -> None:
    """Rotations lift the weight: its centre must be known, for each part if one rotates alone."""
    count, centre = body.part_count, body.centre_of_mass
    turning = [i for i, motions in body.rigid_parts.items() if any(np.any(motion.rotation) for motion in motions)]
    if centre is None:
        if turning or any(np.any(motion.rotation) for motion in body.rigid.values()):
            raise ConfigError("modes: centre_of_mass is missing; a body that rotates needs it [m]")
        return
    if np.shape(centre) not in ((3,), (count, 3)):
        raise ConfigError(f"centre_of_mass: shape {np.shape(centre)}; needs (3,), or a row for each part, {(count, 3)}")
    if not np.isfinite(centre).all():
        raise ConfigError("centre_of_mass: holds NaN or infinite values; needs finite ones")
    if turning and np.ndim(centre) == 1:
        raise ConfigError(
            f"centre_of_mass: received one, but {body.labels[turning[0]]} turns {count} separate parts, not all alike; "
            "needs a row for each part, in the order of their first panels [m]"
        )


# Separate parts must not lie in each other


def check_apart(body: FlexibleBody) -> None:
    """Check that the separate parts of a mesh lie outside each other and share no panel.

    Raises `ConfigError` if two of them overlap or touch, or a panel occurs twice.
    """
    _check_walls(body)
    part, normal = body.part, body.vector_areas
    closed, whose = body._closed[0], np.concatenate([part, part, part[body.bed_edges[1]]])
    before = body.centres + _BEFORE * normal / np.sqrt(np.linalg.norm(normal, axis=1, keepdims=True))
    for one, other in permutations(range(body.part_count), 2):
        inside = solid_angle_share(closed[whose == other], before[part == one]) > 0.5
        if inside.any():
            raise ConfigError(
                f"mesh: {np.count_nonzero(inside)} panels of {_name(body, one)} lie inside {_name(body, other)} or on "
                f"its wall, the first at {text_of(body.centres[part == one][inside][0])}; needs bodies with water "
                "between them, and of a hollow hull the outer surface alone"
            )


def _check_walls(body: FlexibleBody) -> None:
    """No panel may lie on another: both sides of a plate, or the walls of two bodies that touch."""
    own = owners(body.vertices)[body.faces]
    _, same, count = np.unique(np.sort(own, axis=1), axis=0, return_inverse=True, return_counts=True)
    double = count[same.ravel()] > 1
    if not double.any():
        return
    edges, panel = panel_edges(own)
    _, place, uses = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    first = int(np.flatnonzero(double)[0])
    where = f"{np.count_nonzero(double)} panels lie on each other in pairs, the first at {text_of(body.centres[first])}"
    below = (body.vertices[edges][..., 2] < -AT_SURFACE * body.size).any(axis=1)
    if (double[panel] & (uses[place.ravel()] == 2) & below).any():  # an edge of two of them alone
        raise ConfigError(
            f"mesh: {where}: the two sides of a plate without thickness, which is not solved; needs its thickness"
        )
    moved = np.abs(body.modes[:, double]).max(axis=2) > 0
    names = sorted({body_of(label) for label, some in zip(body.labels, moved, strict=True) if some.any()} - {""})
    whose = f"the walls of {' and '.join(names)} coincide" if len(names) > 1 else "the walls of two bodies coincide"
    raise ConfigError(f"mesh: {where}: {whose}; needs water between bodies, or one surface around both")


def _name(body: FlexibleBody, part: int) -> str:
    """The body of a part, if labels such as `float__Heave` name it among the motions of this part alone."""
    here, there = (np.abs(body.modes[:, mine]).max(axis=(1, 2)) for mine in (body.part == part, body.part != part))
    names = [body_of(label) for label, own, rest in zip(body.labels, here, there, strict=True) if own > 0 == rest]
    return next(filter(None, names), f"part {part + 1}")


# Symmetry and resolution


def detected_symmetry(body: FlexibleBody) -> str:
    """Return the largest symmetry of the panels, a key of `SYMMETRIES`; displacements need not have it."""
    return "+".join(plane for plane in PLANES if _is_mirrored(body, plane)) or "none"


def check_symmetry(body: FlexibleBody, declared: str) -> None:
    """Raise `ConfigError` if the panels lack a plane of symmetry declared, a key of `SYMMETRIES`."""
    for plane in SYMMETRIES[declared]:
        if not _is_mirrored(body, plane):
            raise ConfigError(
                f"symmetry {declared}: the panels are not mirrored in the {plane} plane, or some lie across it; "
                "correct the mesh or declare less"
            )


def _is_mirrored(body: FlexibleBody, plane: str) -> bool:
    """Whether every panel has a mirror image other than itself among the panels, corner for corner."""
    axis, tolerance = PLANES[plane], SAME * body.size
    sign = np.where(np.arange(3) == axis, -1.0, 1.0)
    across = np.ptp(np.sign(np.where(np.abs(body.vertices) < tolerance, 0, body.vertices))[body.faces, axis], axis=1)
    distance, image = cKDTree(body.centres).query(body.centres * sign)
    if across.max() > 1 or np.max(distance) > tolerance:
        return False
    corners, images = body.vertices[body.faces] * sign, body.vertices[body.faces[image]]
    between = np.linalg.norm(corners[:, :, None] - images[:, None], axis=-1).min(axis=2)
    return bool(between.max() < tolerance and np.abs(body.centres[:, axis]).min() > tolerance)


def panel_areas(body: FlexibleBody) -> FloatArray:
    """Return the areas of the panels, shape (panel,) [m^2]."""
    return np.asarray(np.linalg.norm(body.triangles.area, axis=1).reshape(2, -1).sum(axis=0))


def panel_size(body: FlexibleBody) -> float:
    """Return the mean over the surface of the roots of its panels' areas [m]."""
    areas = panel_areas(body)
    return float((areas**1.5).sum() / areas.sum())


def panel_diameters(body: FlexibleBody) -> FloatArray:
    """Return the largest diagonal or side of each panel, shape (panel,) [m]."""
    corner = body.vertices[body.faces]
    pairs = [(0, 2), (1, 3), *pairwise((0, 1, 2, 3, 0))]
    return np.asarray(np.max([np.linalg.norm(corner[:, a] - corner[:, b], axis=1) for a, b in pairs], axis=0))


def panels_per_lobe(body: FlexibleBody) -> float:
    """Return the panels in half a wavelength of the shortest of the displacements, infinite if all are rigid [-].

    The wavenumber of a displacement psi is k, k^2 = int |grad psi|^2 dS/int |psi|^2 dS, over the surface, psi linear in
    every half of a panel: sqrt(n(n + 1) + 2)/r of P_n e_r on a sphere. Rigid motions are exact on any panels.
    """
    t, flexible = body.triangles, body.flexible
    if not flexible:
        return float("inf")
    moved = t.moved[flexible]
    gradient = t.squared_gradients(flexible).sum(axis=1)
    size = (((moved**2).sum(axis=(2, 3)) + (moved.sum(axis=2) ** 2).sum(axis=2)) / 12) @ np.linalg.norm(t.area, axis=1)
    return float(np.pi * np.sqrt((size / np.maximum(gradient, 1e-300)).min()) / panel_size(body))


def rigid_misfit(body: FlexibleBody) -> float:
    """Return how far displacements named as rigid motions are from the unit ones, relatively.

    Other codes take a Pitch for the unit rotation about y, about whatever point, even if it is none.
    """
    named = [(mode, RIGID.index(label)) for mode, label in zip(body.modes, body.labels, strict=True) if label in RIGID]
    worst = 0.0
    for mode, k in named:
        unit = np.eye(3)[k] if k < 3 else np.cross(np.eye(3)[k - 3], body.centres)
        misfit = mode - unit
        misfit = misfit - misfit.mean(axis=0) if k >= 3 else misfit
        worst = max(worst, float(np.abs(misfit).max() / np.abs(unit).max()))
    return worst


OUTLINE = "outline"
"""Variable of a database with the lines, shape (line, end, xyz) [m]."""
DISPLACED = "outline_displacement"
"""Variable with their displacement per unit amplitude of each degree of freedom."""


def cut(body: FlexibleBody) -> xr.Dataset:
    """Return the lines in which the plane y = const through the middle of each separate part cuts the panels.

    `OUTLINE`, shape (line, end, xyz) [m], and `DISPLACED`, shape (influenced_dof, line, end, xyz) [-], linear in every
    half of a panel, as displacements of panels are.
    """
    place, moved = body.triangles.corner, body.triangles.moved
    y, part = place[..., 1], np.concatenate([body.part, body.part])
    middle = np.array([(y[part == p].min() + y[part == p].max()) / 2 for p in range(body.part_count)])[part, None]
    beyond = y > middle
    crossed = np.flatnonzero(beyond.any(axis=1) & ~beyond.all(axis=1))
    single = beyond[crossed].sum(axis=1) == 1  # the corner beyond, or the one short of the plane, is alone
    alone = np.where(single, beyond[crossed].argmax(axis=1), beyond[crossed].argmin(axis=1))
    ends = np.stack([(alone + 1) % 3, (alone + 2) % 3], axis=1)
    start, from_y = alone[:, None], (y - middle)[crossed]
    near, far = (np.take_along_axis(from_y, which, axis=1) for which in (start, ends))
    share = near / (near - far)  # (line, end): how far the plane is from the corner alone to each of the others

    def between(values: np.ndarray) -> np.ndarray:
        """Values of corners, (..., triangle, 3, xyz), on the lines."""
        held, rows = values[..., crossed, :, :], np.arange(len(crossed))[:, None]
        first, second = held[..., rows, start, :], held[..., rows, ends, :]
        return np.asarray(first + share[..., None] * (second - first))

    lines = between(place)
    there = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > 1e-9 * body.size
    dims = ("line", "end", "xyz")
    return xr.Dataset(
        {OUTLINE: (dims, lines[there]), DISPLACED: (("influenced_dof", *dims), between(moved)[:, there])},
        {"influenced_dof": list(body.labels)},
    )
