"""A body of any shape: its wetted panels, the displacements it can make, and what still water does to them.

Panels and displacements come from files (`bodies.files`). Displacements are dimensionless fields psi_i on the wetted
surface, one per degree of freedom, whose amplitudes are metres, or radians for rotations. Normals point into the water.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from vsb.errors import ConfigError
from vsb.hydro.bodies.closure import Gaps, check_closed, gaps, panel_edges
from vsb.hydro.bodies.rigid import Rigid, rigid_motion
from vsb.study.quantities import RIGID
from vsb.tools.arrays import FloatArray, IntArray

PLANES = {"xOz": 1, "yOz": 0}
"""Planes of symmetry and the coordinate each of them changes the sign of."""
SYMMETRIES = {"none": (), "xOz": ("xOz",), "yOz": ("yOz",), "xOz+yOz": ("xOz", "yOz")}
"""What a body file may declare."""
SAME = 1e-8
"""Of lengths, in lengths of the body."""
AT_SURFACE = 1e-6
"""Of a waterline, in lengths of the body: what single precision makes of z = 0."""
CLOSED = 1e-2
"""Largest relative difference of the three volumes of a surface taken for closed: what its gaps may matter."""
_LEAST_BODY = 0.01  # [m], lengths below which capytaine's own tolerances drop panels
_LARGEST_BODY = 1e5  # [m], beyond which no body lies
_BOTH_SIDES = 2  # panels of an edge
LEAST_PANELS = 4
"""Of a separate part: panels whose corners only nearly coincide make no body."""


class Triangles(NamedTuple):
    """Halves of the panels: corners, vector areas, and the displacements of the corners."""

    corner: FloatArray  # (triangle, 3, xyz) [m]
    area: FloatArray  # (triangle, xyz) [m^2], along the normal
    moved: FloatArray  # (dof, triangle, 3, xyz) [-]

    def integral(self, f: FloatArray, g: FloatArray) -> FloatArray:
        """Integral of the product of fields linear in each triangle, (..., triangle, 3) [-]; weights are f's."""
        return np.asarray((f.sum(axis=-1) * g.sum(axis=-1) + (f * g).sum(axis=-1)).sum(axis=-1) / 12)


@dataclass(frozen=True)
class FlexibleBody:
    """Wetted surface of a body at rest and the displacements it can make; checked when made.

    Triangles repeat their last corner. `mass` and `stiffness`, the modal matrices, shape (dof, dof) [kg, N/m], and
    `centre_of_mass`, shape (3,) [m], are None where the file has none; rotations need the latter, of one of several
    separate parts a row for each part, shape (part, 3), in the order of their first panels.
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

    def __post_init__(self) -> None:
        """Refuse what no solver can use."""
        _check_panels(self)
        _check_modes(self)

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
    def centres(self) -> FloatArray:
        """Centroids of the panels, shape (panel, xyz) [m]."""
        return np.asarray(at_centres(self.vertices, self.faces, self.vertices[None])[0])

    @cached_property
    def volumes(self) -> FloatArray:
        """Volume of displaced water three times, from the x, y and z components of the normals, shape (3,) [m^3]."""
        corner, area, _ = self.triangles
        return np.asarray((corner.mean(axis=1) * area).sum(axis=0))

    @cached_property
    def gaps(self) -> Gaps:
        """Gaps between panels whose edges run beside each other without meeting."""
        return gaps(self.vertices, owners(self.vertices)[self.faces], -AT_SURFACE * self.size)

    @property
    def volume(self) -> float:
        """Volume of displaced water [m^3]."""
        return float(self.volumes[2])

    @cached_property
    def rigid(self) -> dict[int, Rigid]:
        """Degrees of freedom that are rigid motions of all there is."""
        motions = {i: rigid_motion(self.vertices, shape) for i, shape in enumerate(self.shapes)}
        return {i: motion for i, motion in motions.items() if motion}

    @cached_property
    def part(self) -> IntArray:
        """Number of the separate part each panel belongs to, in the order of their first panels, shape (panel,)."""
        return parts(owners(self.vertices)[self.faces], self.gaps.beside)

    @cached_property
    def vertex_part(self) -> IntArray:
        """Part of each vertex; one that no panel has is of the part next to it, shape (vertex,)."""
        corners, first = np.unique(self.faces, return_index=True)
        nearest = cKDTree(self.vertices[corners]).query(self.vertices)[1]
        return np.asarray(np.repeat(self.part, self.faces.shape[1])[first][nearest])

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


def parts(faces: IntArray, beside: IntArray) -> IntArray:
    """Return the number of the connected part each panel belongs to, in the order of first panels, shape (panel,).

    Panels are connected if an edge belongs to both and to no third, or if they lie `beside` each other, shape
    (pair, 2): where bodies touch, an edge belongs to four.
    """
    edges, panel = panel_edges(faces)
    _, place, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    shared = count[place.ravel()] == _BOTH_SIDES
    start, end = panel[shared], place.ravel()[shared] + len(faces)
    start, end = (np.concatenate(pair) for pair in ((start, beside[:, 0]), (end, beside[:, 1])))
    graph = coo_matrix((np.ones(len(start)), (start, end)), shape=(len(faces) + len(edges),) * 2)
    found = connected_components(graph, directed=False)[1][: len(faces)]
    _, first, number = np.unique(found, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[number])


def rigid_misfit(body: FlexibleBody) -> float:
    """Return how far displacements named as rigid motions are from the unit ones, relatively.

    Other codes take a Pitch for the unit rotation about y, about whatever point, even if it is none.
    """
    named = [(mode, RIGID.index(label)) for mode, label in zip(body.modes, body.labels, strict=True) if label in RIGID]
    worst = 0.0
    for mode, k in named:
        unit = np.eye(3)[k] if k < 3 else np.cross(np.eye(3)[k - 3], body.centres)
        apart = mode - unit
        apart = apart - apart.mean(axis=0) if k >= 3 else apart
        worst = max(worst, float(np.abs(apart).max() / np.abs(unit).max()))
    return worst


def at_centres(vertices: FloatArray, faces: IntArray, values: FloatArray) -> FloatArray:
    """Return values linear in each half of a panel at the panel's centroid, (n, vertex, xyz) -> (n, panel, xyz)."""
    halves = [faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]]
    corner = [vertices[half] for half in halves]
    area = np.stack([np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1) for c in corner])
    if (flat := np.flatnonzero(area.sum(axis=0) <= 0)).size:
        raise ConfigError(f"mesh: panel {flat[0]} has no area; remove it")
    share = area / area.sum(axis=0)
    means = [values[:, half].mean(axis=2) for half in halves]
    return np.asarray(share[0][:, None] * means[0] + share[1][:, None] * means[1])


def at_vertices(vertices: FloatArray, faces: IntArray, values: FloatArray) -> FloatArray:
    """Return values given at panels as means over the panels around each vertex, (n, panel, xyz) -> (n, vertex, xyz).

    Coincident vertices share their panels: some formats give every panel its own corners.
    """
    owner = owners(vertices)
    total, count = np.zeros((len(vertices), len(values), 3)), np.zeros(len(vertices))
    for corner in owner[faces].T:
        np.add.at(count, corner, 1.0)
        np.add.at(total, corner, values.swapaxes(0, 1))
    return np.asarray((total[owner] / np.maximum(count[owner], 1.0)[:, None, None]).swapaxes(0, 1))


def owners(vertices: FloatArray) -> IntArray:
    """Return the first of the vertices that coincide with each, shape (vertex,)."""
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    same = cKDTree(vertices).query_pairs(SAME * size, output_type="ndarray")
    owner = np.arange(len(vertices))
    np.minimum.at(owner, same[:, 1], same[:, 0])
    return owner


def check_vertices(x: FloatArray) -> None:
    """Raise `ConfigError` unless points, shape (vertex, xyz) [m], can be those of a body in metres."""
    if not np.isfinite(x).all():
        raise ConfigError("mesh: a vertex is NaN or infinite; needs finite coordinates")
    if np.abs(x).max(initial=0.0) > _LARGEST_BODY:
        raise ConfigError(f"mesh: reaches {np.abs(x).max():.3g} m; needs at most {_LARGEST_BODY:g} m: is it in metres?")


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
    volumes = body.volumes
    if volumes.max() <= 0:
        raise ConfigError(f"mesh: encloses {volumes.max():.4g} m^3; needs normals that point into the water: flip them")
    check_closed(body.gaps)
    if np.ptp(volumes) > CLOSED * volumes.max():
        raise ConfigError(
            "mesh: encloses {:.6g}, {:.6g} and {:.6g} m^3 by the normals' x, y and z; needs a surface that is closed "
            "below z = 0 with all normals into the water".format(*volumes)
        )


def _check_modes(body: FlexibleBody) -> None:
    """Every degree of freedom needs a name of its own, a finite shape, and rows in the matrices."""
    n = len(body.labels)
    if n == 0 or len(set(body.labels)) < n:
        raise ConfigError(f"modes: labels {str(list(body.labels))[:200]}; needs at least one, and none twice")
    needed: dict[str, tuple[int, ...]] = {"modes": (n, len(body.faces), 3), "shapes": (n, len(body.vertices), 3)}
    needed |= dict.fromkeys(("mass", "stiffness"), (n, n)) | {"second_order": (n, n, len(body.vertices), 3)}
    for name, shape in needed.items():
        values = getattr(body, name)
        if values is None:
            continue
        if np.shape(values) != shape:
            raise ConfigError(f"{name}: shape {np.shape(values)}; needs {shape} for {n} labels and this mesh")
        if not np.isfinite(values).all():
            raise ConfigError(f"{name}: holds NaN or infinite values; needs finite ones")
    area = body.triangles.area[: len(body.faces)] + body.triangles.area[len(body.faces) :]
    flux = np.abs(np.einsum("ipx,px->ip", body.modes, area)).max(axis=1) / np.linalg.norm(area, axis=1).max()
    for label, moved, shape in zip(body.labels, flux, body.modes, strict=True):
        if moved <= 1e-12 * np.abs(shape).max():
            raise ConfigError(f"modes: {label} moves no water; remove it")
    _check_centre_of_mass(body)
    for name in ("mass", "stiffness", "second_order"):
        m = getattr(body, name)
        if m is not None and np.abs(m - m.swapaxes(0, 1)).max() > 1e-9 * np.abs(m).max():
            raise ConfigError(f"{name}: not symmetric; needs a symmetric matrix")


def _check_centre_of_mass(body: FlexibleBody) -> None:
    """Weight lifts what turns: its centre must be there, of each part if one turns alone."""
    count, centre = int(body.part.max()) + 1, body.centre_of_mass
    if centre is None:
        moved = [*body.rigid.values(), *(motion for motions in body.rigid_parts.values() for motion in motions)]
        if any(np.any(motion.rotation) for motion in moved):
            raise ConfigError("modes: centre_of_mass is missing; a body that rotates needs it [m]")
        return
    if np.shape(centre) not in ((3,), (count, 3)):
        raise ConfigError(f"centre_of_mass: shape {np.shape(centre)}; needs (3,), or a row for each part, {(count, 3)}")
    if not np.isfinite(centre).all():
        raise ConfigError("centre_of_mass: holds NaN or infinite values; needs finite ones")
    turning = [i for i, motions in body.rigid_parts.items() if any(np.any(motion.rotation) for motion in motions)]
    if turning and np.ndim(centre) == 1:
        raise ConfigError(
            f"centre_of_mass: received one, but {body.labels[turning[0]]} turns {count} separate parts, not all alike; "
            "needs a row for each part, in the order of their first panels [m]"
        )


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
    gaps = np.linalg.norm(corners[:, :, None] - images[:, None], axis=-1).min(axis=2)
    return bool(gaps.max() < tolerance and np.abs(body.centres[:, axis]).min() > tolerance)


def panel_areas(body: FlexibleBody) -> FloatArray:
    """Return the areas of the panels, shape (panel,) [m^2]."""
    return np.asarray(np.linalg.norm(body.triangles.area, axis=1).reshape(2, -1).sum(axis=0))


def panel_size(body: FlexibleBody) -> float:
    """Return the mean over the surface of the roots of its panels' areas [m]."""
    areas = panel_areas(body)
    return float((areas**1.5).sum() / areas.sum())


def panels_per_lobe(body: FlexibleBody) -> float:
    """Return the panels in half a wavelength of the shortest of the displacements, infinite if all are rigid [-].

    Notes
    -----
    The wavenumber of a displacement psi is k, k^2 = int |grad psi|^2 dS/int |psi|^2 dS, over the surface, psi linear in
    every half of a panel: sqrt(n(n + 1) + 2)/r of P_n e_r on a sphere. Rigid motions are exact on any panels.
    """
    rigid = body.rigid.keys() | body.rigid_parts.keys()
    t, flexible = body.triangles, [i for i in range(len(body.labels)) if i not in rigid]
    if not flexible:
        return float("inf")
    moved = t.moved[flexible]
    gradient = squared_gradients(t, flexible).sum(axis=1)
    size = (((moved**2).sum(axis=(2, 3)) + (moved.sum(axis=2) ** 2).sum(axis=2)) / 12) @ np.linalg.norm(t.area, axis=1)
    return float(np.pi * np.sqrt((size / np.maximum(gradient, 1e-300)).min()) / panel_size(body))


def squared_gradients(t: Triangles, dofs: list[int]) -> FloatArray:
    """Return int |grad psi|^2 dS of each triangle, zero of empty ones, shape (dof, triangle)."""
    (e, f), moved = (t.corner[:, k] - t.corner[:, 0] for k in (1, 2)), t.moved[dofs]
    de, df = (moved[:, :, k] - moved[:, :, 0] for k in (1, 2))
    area = np.linalg.norm(t.area, axis=1)
    whole = area > 1e-12 * area.max()
    ee, ef, ff = ((a * b).sum(axis=1) for a, b in ((e, e), (e, f), (f, f)))
    squared = ff * (de**2).sum(axis=2) - 2 * ef * (de * df).sum(axis=2) + ee * (df**2).sum(axis=2)
    return np.asarray(np.where(whole, squared / (4 * np.where(whole, area, 1.0)), 0.0))


def panel_diameters(body: FlexibleBody) -> FloatArray:
    """Return the largest diagonal or side of each panel, shape (panel,) [m]."""
    corner = body.vertices[body.faces]
    pairs = [(0, 2), (1, 3), *pairwise((0, 1, 2, 3, 0))]
    return np.asarray(np.max([np.linalg.norm(corner[:, a] - corner[:, b], axis=1) for a, b in pairs], axis=0))


def joined(parts: Sequence[tuple[FloatArray, IntArray]]) -> tuple[FloatArray, IntArray]:
    """Return vertices and panels of several meshes as one, panels in order."""
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = [panels + offset for (_, panels), offset in zip(parts, offsets, strict=False)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)
