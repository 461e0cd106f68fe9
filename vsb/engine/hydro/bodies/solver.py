"""Radiation and diffraction by a body of any shape with any displacements, on capytaine's panels.

A lid is a set of panels on the water inside a body. One that reaches the waterline spoils coefficients away from the
irregular frequencies: in the corner between wall and lid the source strength is singular, since the water outside keeps
its free surface and the water inside has none, and flat panels resolve that badly however fine: surge added mass of a
box 10 x 8 x 4 m at 2.4 rad/s is 20 % off. A lid that ends one panel short of the waterline avoids the corner (2 %). The
open strip has modes of its own, but only in waves that the panels do not resolve either.

Errors are estimated from fewer panels on the same vertices. Panels around a vertex are joined into patches, four by
four where panels are quadrilaterals, and a patch becomes the quadrilaterals and triangles between its corners. On a
regular mesh this is the mesh of half the resolution, curvature and displacements included; panels that find no partners
stay, and panels are never joined across an edge of the body.
"""

import heapq
from collections import defaultdict
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.linalg import hadamard
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from vsb.engine.hydro.bodies.body import PLANES, SYMMETRIES, FlexibleBody, detected_symmetry, panel_areas, panel_size
from vsb.engine.hydro.bodies.mesh import SAME, at_centres, joined, owners, solid_angle_share
from vsb.engine.hydro.database import solved_dataset
from vsb.engine.hydro.panels.bem import PanelProblem, SymmetricPanels, panel_mesh
from vsb.engine.hydro.variables import PAIR
from vsb.engine.waves.water import Water, haskind_factor, wavenumber
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

_NARROW = 0.25  # width of a gap, relative to draught and beam


# Waterlines, irregular frequencies and lids


def waterlines(body: FlexibleBody) -> list[FloatArray]:
    """Return the edges at the water's surface, shape (edge, 2, xy) [m], of each closed waterline.

    They run clockwise, seen from above, where the body is inside, and anticlockwise around a moonpool.
    """
    edges = np.concatenate([body.faces[:, [i, (i + 1) % 4]] for i in range(4)])
    ends = body.vertices[edges]
    at_surface = (np.abs(ends[:, :, 2]) < SAME * body.size).all(axis=1)
    ends = ends[at_surface & (np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) > SAME * body.size)]
    if len(ends) == 0:
        return []
    start, end = owners(ends.reshape(-1, 3)).reshape(-1, 2).T
    graph = coo_matrix((np.ones(len(start)), (start, end)), shape=(2 * len(ends),) * 2)
    line = connected_components(graph, directed=False)[1][start]
    return [ends[line == each, :, :2] for each in np.unique(line)]


def first_irregular_frequency(body: FlexibleBody, gravity: float) -> float:
    """Return a lower bound of the irregular frequencies of a body [rad/s], infinite without a waterline.

    They are the eigenfrequencies of the water inside with its walls at zero potential, which rise as the space shrinks:
    those of the box around each part, omega^2 = pi g p/tanh(pi p d), p^2 = 1/L^2 + 1/B^2, lie below them.
    """
    if not waterlines(body):
        return float("inf")
    corners = [body.vertices[body.faces[body.part == p]].reshape(-1, 3) for p in range(body.part_count)]
    found = []
    for corner in (each for each in corners if each[:, 2].max() > -SAME * body.size):
        length, beam, _ = np.ptp(corner, axis=0)
        p = np.pi * np.hypot(1 / length, 1 / beam)
        found.append(float(np.sqrt(gravity * p / np.tanh(-p * corner[:, 2].min()))))
    return min(found)


class Resonance(NamedTuple):
    """Water between two bodies that heaves like a piston."""

    omega: float  # [rad/s], about
    width: float  # of the gap [m]


def gap_resonance(body: FlexibleBody, gravity: float) -> Resonance | None:
    """Return the first resonance of the narrowest gap between parts at the water's surface, None without one.

    As of a gap of width b between barges of width B and draught d (Molin 2001):
    omega^2 = g/(d + (b/pi) (3/2 + ln(B/2b))). It is no irregular frequency: such water does move, in linear theory more
    than in the sea, since only radiation damps it.
    """
    found = []
    corners = [body.vertices[np.unique(body.faces[body.part == p])] for p in range(body.part_count)]
    surface = [each for each in corners if each[:, 2].max() > -SAME * body.size]
    for one, other in combinations(surface, 2):
        at_surface = [each[np.abs(each[:, 2]) < SAME * body.size, :2] for each in (one, other)]
        width = float(np.min(cKDTree(at_surface[0]).query(at_surface[1])[0]))
        extent = np.min([np.ptp(one, axis=0), np.ptp(other, axis=0)], axis=0)
        draught, beam = float(extent[2]), float(min(extent[:2]))
        if 0 < width < _NARROW * min(draught, beam):
            depth = draught + width / np.pi * (1.5 + np.log(beam / (2 * width)))
            found.append(Resonance(float(np.sqrt(gravity / depth)), width))
    return min(found, key=lambda each: each.width, default=None)


def encloses_water(body: FlexibleBody) -> bool:
    """Return whether a body has open water inside, as a ring or a moonpool does."""
    return any(_enclosed(line) < 0 for line in waterlines(body))


def interior_lid(body: FlexibleBody, belts: int) -> tuple[FloatArray, IntArray] | None:
    """Return vertices and panels, normals down, of a lid inside every waterline of a body.

    Rectangles in rows along x and y, of the mean size of the body's panels, or larger: at most `belts` of them between
    the middle and the waterline. None is nearer to a waterline than the panels beside it are large.
    None without a waterline, and if the water inside is narrower than a few panels: so are its modes.
    """
    lines = waterlines(body)
    if not lines:
        return None
    beside = (np.abs(body.vertices[body.faces][:, :, 2]) < SAME * body.size).sum(axis=1) > 1
    panel, gap = panel_size(body), float(np.sqrt(panel_areas(body)[beside]).mean())
    every, area = np.concatenate(lines), [_enclosed(line) for line in lines]
    parts = []
    for line, own in zip(lines, area, strict=True):
        smaller = [each for each, size in zip(lines, area, strict=True) if abs(size) < abs(own)]
        points, panels = _grid(line, own, panel, gap, belts)
        margin = _distance(points, every) / min(gap, _width(line, own) / 4)
        inside = (_winding(points, line) > 0.5) & (np.round(margin, 6) > 0.9)
        for other in smaller:  # a moonpool, or another body in it
            inside &= np.abs(_winding(points, other)) < 0.5
        parts.append((points, panels[inside[panels].all(axis=1)]))
    flat, panels = joined(parts)
    return (np.pad(flat, ((0, 0), (0, 1))), panels) if len(panels) else None


def _enclosed(line: FloatArray) -> float:
    """Area inside a waterline [m^2], negative of a moonpool."""
    (xa, ya), (xb, yb) = line[:, 0].T, line[:, 1].T
    return float((xb * ya - xa * yb).sum() / 2)


def _width(line: FloatArray, area: float) -> float:
    """Radius of a circle, half the side of a square, width of a slender hull [m]."""
    return float(2 * abs(area) / np.linalg.norm(line[:, 1] - line[:, 0], axis=1).sum())


def _grid(line: FloatArray, area: float, panel: float, gap: float, belts: int) -> tuple[FloatArray, IntArray]:
    """Points (point, xy) and rectangles of even rows over the box around a waterline, less the gap beside it."""
    low, high, width = line.min(axis=(0, 1)), line.max(axis=(0, 1)), _width(line, area)
    side = min(max(panel, width / belts), width / 2)
    half = (high - low) / 2 - min(gap, width / 4)
    count = np.maximum(np.ceil(half / side - 1e-6), 1).astype(int)  # a panel never lies across the middle
    x, y = ((low[k] + high[k]) / 2 + half[k] * np.arange(-n, n + 1) / n for k, n in enumerate(count))
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    corner = np.arange(len(points)).reshape(len(x), len(y))
    panels = np.stack([corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]], axis=-1)
    return points, panels.reshape(-1, 4)


def _winding(points: FloatArray, line: FloatArray) -> FloatArray:
    """How often a waterline goes around points, clockwise, shape (point,)."""
    a, b = (line[None, :, k] - points[:, None] for k in range(2))
    turn = np.arctan2(a[..., 1] * b[..., 0] - a[..., 0] * b[..., 1], (a * b).sum(axis=-1))
    return np.asarray(turn.sum(axis=1) / (2 * np.pi))


def _distance(points: FloatArray, edges: FloatArray) -> FloatArray:
    """Distance of points from the nearest of some edges, shape (point,) [m]."""
    start, along = edges[None, :, 0], (edges[:, 1] - edges[:, 0])[None]
    from_start = points[:, None] - start
    share = np.clip((from_start * along).sum(axis=-1) / (along**2).sum(axis=-1), 0.0, 1.0)
    return np.asarray(np.linalg.norm(from_start - share[..., None] * along, axis=-1).min(axis=1))


# Fewer panels on the same vertices

_MOST = 8
"""Largest number of panels around a vertex that is the centre of a patch, not a pole."""
_ALIKE = np.cos(np.deg2rad(25.0))
"""Cosine between the normals of a panel and of its patch below which there is an edge of the body between panels."""
_BLUNT = 1 / 12
"""Share of a patch's area cut off with a vertex of its boundary, below which it is no corner.

Six triangles around a vertex, however stretched, have corners of a sixth.
"""
_STRAIGHT = 1e-9
"""Likewise of a flat patch, where only corners on a straight line are left out."""
_FLATTEST = 0.05  # of half a panel's area, in terms of the mean of its patch
_BOTH_WAYS = 2.5
"""Panels of a patch per panel between its corners from which on it counts as coarser both ways."""
_Around = dict[int, set[int]]


class Coarser(NamedTuple):
    """Fewer panels on the same vertices."""

    faces: IntArray  # (fewer, 4)
    share: float  # of the surface, where panels are larger both along and across


class CoarserBody(FlexibleBody):
    """A body on fewer panels, not checked: it is open where a corner of one panel lies on a side of another."""

    def __post_init__(self) -> None:
        """Nothing to check."""


def coarser_body(body: FlexibleBody, planes: tuple[str, ...]) -> tuple[CoarserBody, float]:
    """Return a body on fewer panels and its `Coarser.share`; displacements are those of the panels' corners."""
    faces, share = coarser_panels(body.vertices, body.faces, planes)
    modes = at_centres(body.vertices, faces, body.shapes)
    return CoarserBody(body.vertices, faces, body.labels, modes, body.shapes, bed=body.bed), share


def coarser_panels(vertices: FloatArray, faces: IntArray, planes: tuple[str, ...]) -> Coarser:
    """Return fewer panels between the same vertices, mirrored in planes of symmetry (`body.PLANES`)."""
    corners = owners(vertices)[faces]
    centres = vertices[corners].mean(axis=1)
    kept = np.all([np.ones(len(faces)), *(centres[:, PLANES[plane]] > 0 for plane in planes)], axis=0)
    corners = corners[kept]
    normals = _areas(vertices, corners)
    areas = np.linalg.norm(normals, axis=1)
    normals /= areas[:, None]
    panels, left, coarser = [], set(range(len(corners))), 0.0
    for patch in _patches(corners, normals):
        between = _between_corners(vertices, corners[patch])
        if 0 < len(between) < len(patch):
            panels += between
            left -= set(patch)
            coarser += float(areas[patch].sum()) * (len(patch) >= _BOTH_WAYS * len(between))
    found = np.array(panels + corners[sorted(left)].tolist(), dtype=int)
    tree = cKDTree(vertices)
    for plane in planes:
        image = np.asarray(tree.query(vertices * np.where(np.arange(3) == PLANES[plane], -1.0, 1.0))[1])
        found = np.concatenate([found, image[found][:, [1, 0, 3, 2]]])
    return Coarser(found, coarser / float(areas.sum()))


def _areas(vertices: FloatArray, corners: IntArray) -> FloatArray:
    """Vector areas of panels, shape (panel, xyz) [m^2]."""
    x = vertices[corners]
    return np.asarray(np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]) / 2)


def _patches(corners: IntArray, normals: FloatArray) -> list[list[int]]:
    """Panels around vertices, each in one patch at most: full patches first, beside those already found."""
    around, beside = _around(corners, normals), _beside(corners, normals)
    free, found = set(range(len(corners))), []

    def rank(vertex: int) -> tuple[int, int, int]:
        mine = around[vertex] & free
        outside = set().union(*(beside[panel] for panel in mine)) & free - mine
        return -len(mine), len(outside), vertex

    heap = [rank(vertex) for vertex in around]
    heapq.heapify(heap)
    while heap:
        before = heapq.heappop(heap)
        now = rank(before[2])
        if now[0] > -2:
            continue
        if now != before:
            heapq.heappush(heap, now)
            continue
        mine = around[now[2]] & free
        free -= mine
        found.append(sorted(mine))
        near = set().union(*(beside[panel] for panel in mine)) & free
        for vertex in {v for panel in near for v in corners[panel].tolist() if v in around}:
            heapq.heappush(heap, rank(vertex))
    return found


def _around(corners: IntArray, normals: FloatArray) -> _Around:
    """Panels around each vertex that may be a patch's centre."""
    found: _Around = defaultdict(set)
    for panel, own in enumerate(corners.tolist()):
        for vertex in own:
            found[vertex].add(panel)
    return {v: panels for v, panels in found.items() if 2 <= len(panels) <= _MOST and _smooth(normals, panels)}


def _beside(corners: IntArray, normals: FloatArray) -> _Around:
    """Neighbours of each panel, except across an edge of the body."""
    sides: dict[tuple[int, int], list[int]] = defaultdict(list)
    for panel, own in enumerate(corners.tolist()):
        for a, b in zip(own, own[1:] + own[:1], strict=True):
            if a != b:
                sides[min(a, b), max(a, b)].append(panel)
    found: _Around = defaultdict(set)
    for pair in sides.values():
        if len(pair) == 2 and _smooth(normals, set(pair)):
            found[pair[0]].add(pair[1])
            found[pair[1]].add(pair[0])
    return found


def _smooth(normals: FloatArray, panels: set[int]) -> bool:
    """Whether there is no edge of the body between panels."""
    own = normals[list(panels)]
    mean = own.sum(axis=0)
    return bool((own @ mean).min() > _ALIKE * np.linalg.norm(mean))


def _between_corners(vertices: FloatArray, corners: IntArray) -> list[list[int]]:
    """Fewest panels between the corners of a patch; none if it has no single boundary or is too bent."""
    loop = _boundary(corners)
    if len(loop) < 3:
        return []
    normal = _areas(vertices, corners).sum(axis=0)
    area = np.linalg.norm(normal)
    normal /= area
    flat = np.ptp(vertices[loop] @ normal) < 1e-6 * np.sqrt(area)
    blunt = _STRAIGHT if flat else _BLUNT
    polygon = _without_blunt_corners(vertices, loop, normal, blunt * float(area))
    cuts = [_cut(polygon[i:] + polygon[:i]) for i in range(len(polygon))]
    thinnest = [_thinnest(vertices, np.array(cut), normal) for cut in cuts]
    best = int(np.argmax(thinnest))
    return cuts[best] if thinnest[best] > _FLATTEST * area / (len(polygon) - 2) else []


def _without_blunt_corners(vertices: FloatArray, loop: list[int], normal: FloatArray, least: float) -> list[int]:
    """Vertices of a closed line without those that hardly bend it, the bluntest first, seen along a normal."""
    kept = list(loop)
    while len(kept) > 3:
        x = vertices[kept]
        lost = np.abs(np.cross(x - np.roll(x, 1, axis=0), np.roll(x, -1, axis=0) - x) @ normal) / 2
        if lost.min() > least:
            break
        del kept[int(np.argmin(lost))]
    return kept


def _boundary(corners: IntArray) -> list[int]:
    """Vertices around a patch in the order of its panels' corners; none unless it is one closed line."""
    sides = {(a, b) for own in corners.tolist() for a, b in zip(own, own[1:] + own[:1], strict=True) if a != b}
    onward = {a: b for a, b in sides if (b, a) not in sides}
    if not onward or len(onward) != sum((b, a) not in sides for a, b in sides):
        return []
    loop = [min(onward)]
    while (following := onward.get(loop[-1])) is not None and following != loop[0] and len(loop) <= len(onward):
        loop.append(following)
    return loop if following == loop[0] and len(loop) == len(onward) else []


def _cut(polygon: list[int]) -> list[list[int]]:
    """Quadrilaterals from the first corner of a polygon, and a triangle if its corners are odd in number."""
    ends = range(1, len(polygon) - 1, 2)
    return [[polygon[0], polygon[i], polygon[i + 1], polygon[min(i + 2, len(polygon) - 1)]] for i in ends]


def _thinnest(vertices: FloatArray, panels: IntArray, normal: FloatArray) -> float:
    """Smallest area of the halves of panels along a normal [m^2], negative if one is turned over."""
    halves = np.concatenate([panels[:, [0, 1, 2]], panels[panels[:, 2] != panels[:, 3]][:, [0, 2, 3]]])
    x = vertices[halves]
    return float((np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]) @ normal).min() / 2)


# The body in waves


def unit_wave(points: FloatArray, k: float, depth: float, directions: FloatArray) -> ComplexArray:
    """Return f = cosh k(z+d)/cosh kd e^{ik(x cos b + y sin b)} [-]: a wave of unit amplitude is -i g/omega f.

    At points, shape (point, xyz) [m], of waves to directions b, shape (direction,) [rad]: shape (direction, point).
    """
    z = points[:, 2]
    floor = (1 + np.exp(-2 * k * (z + depth))) / (1 + np.exp(-2 * k * depth))
    ahead = np.column_stack([np.cos(directions), np.sin(directions)])
    return np.asarray(np.exp(k * z + 1j * k * ahead @ points[:, :2].T) * floor)


def unit_wave_slope(
    points: FloatArray, normals: FloatArray, k: float, depth: float, directions: FloatArray
) -> ComplexArray:
    """Return the derivative of `unit_wave` along normals, shape (direction, point) [1/m]."""
    ahead = np.column_stack([np.cos(directions), np.sin(directions)])
    down = np.tanh(k * (points[:, 2] + depth))
    slope = 1j * ahead @ normals[:, :2].T + normals[:, 2] * down
    return np.asarray(k * slope * unit_wave(points, k, depth, directions))


@dataclass(frozen=True)
class MirroredPanels:
    """Panels of a body, then of a lid, with their planes of symmetry: a half or quarter of the matrices.

    Velocities need no symmetry: they are split into their parts of every parity, of which the characters (+1, -1) of
    the group of reflections, the rows of Hadamard's matrix, make systems of their own.
    """

    green: Any  # of `bem.green_function`
    body: FlexibleBody
    lid: tuple[FloatArray, IntArray] | None
    planes: tuple[str, ...]
    depth: float

    @cached_property
    def surface(self) -> tuple[FloatArray, IntArray]:
        """Vertices and panels of body and lid."""
        return joined([(self.body.vertices, self.body.faces), *([self.lid] if self.lid else [])])

    @cached_property
    def whole(self) -> Any:
        """All panels in their own order, as capytaine's mesh."""
        return panel_mesh(*self.surface)

    @cached_property
    def images(self) -> IntArray:
        """Panels by the half or quarter they lie in, shape (image, panel), each in the column of its images."""
        centres = self.whole.faces_centers
        sides = [centres[:, PLANES[plane]] > 0 for plane in self.planes]
        images = [centres[np.all([np.ones(len(centres)), *sides], axis=0)]]
        for plane in self.planes:
            images += [image * np.where(np.arange(3) == PLANES[plane], -1.0, 1.0) for image in images]
        return np.asarray(cKDTree(centres).query(images)[1])

    @cached_property
    def symmetric(self) -> SymmetricPanels:
        """The half or quarter that is mirrored, and its images."""
        vertices, faces = self.surface
        kept, count = self.images[0], len(self.images)
        return SymmetricPanels(
            self.green,
            part=panel_mesh(vertices, faces[kept]),
            images=panel_mesh(vertices, faces[self.images.ravel()]),
            weights=np.ones(count),
            characters=hadamard(count).astype(float),
            of_body=kept < len(self.body.faces),
            depth=self.depth,
            through_bed=solid_angle_share(self.body.bed_lid, self.whole.faces_centers[kept]),
        )

    def potentials(self, k: float, velocities: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return the sources that make normal velocities, and their potentials, each shape (n, panel)."""
        parity = self.symmetric.characters
        right = np.tensordot(parity, velocities[:, self.images], axes=(1, 1)).swapaxes(1, 2)
        fields = np.tensordot(parity, np.stack(self.symmetric.solve(k, right), axis=1), axes=1) / len(parity)
        found = np.empty((2, *velocities.shape), dtype=complex)
        found[:, :, self.images] = fields.transpose(1, 3, 0, 2)
        return found[0], found[1]


@dataclass(frozen=True)
class BodyProblem(PanelProblem):
    """A body in waves. Its panels have the symmetry given (`body.SYMMETRIES`); displacements and waves need none.

    The lid, vertices and panels with normals down, removes irregular frequencies.
    """

    green: Any  # of `bem.green_function`
    body: FlexibleBody
    water: Water
    symmetry: str = "none"
    lid: tuple[FloatArray, IntArray] | None = None

    def coarser(self) -> tuple["BodyProblem", float]:
        """Return the problem on fewer panels, those of the lid as well, and their share (`Coarser`)."""
        planes = SYMMETRIES[detected_symmetry(self.body)]  # also if the solver does not use them
        lid = (self.lid[0], coarser_panels(*self.lid, planes).faces) if self.lid else None
        body, share = coarser_body(self.body, planes)
        return replace(self, body=body, lid=lid), share

    def _panels(self, lid: tuple[FloatArray, IntArray] | None) -> MirroredPanels:
        """The body's panels and those of a lid."""
        return MirroredPanels(self.green, self.body, lid, SYMMETRIES[self.symmetry], self.water.depth)

    @cached_property
    def panels(self) -> MirroredPanels:
        """Panels of the body, then of the lid."""
        return self._panels(self.lid)

    @cached_property
    def velocities(self) -> FloatArray:
        """Normal velocities of the displacements, shape (dof, panel) [m/s per m/s]."""
        normals = self.panels.whole.faces_normals[: len(self.body.faces)]
        return np.asarray(np.einsum("ipx,px->ip", self.body.modes, normals))

    @cached_property
    def onto(self) -> FloatArray:
        """Generalized force of a unit potential on each panel of the body, -rho w_i dS, shape (dof, panel)."""
        return np.asarray(-self.water.density * self.velocities * self.panels.whole.faces_areas[: len(self.body.faces)])

    def potentials(self, k: float, velocities: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return sources and potentials of panels; see `PanelProblem.potentials`."""
        panels, n = self._panels(None) if np.isinf(k) and self.lid else self.panels, len(self.body.faces)
        padded = np.pad(velocities, ((0, 0), (0, panels.whole.nb_faces - n)))
        sources, potentials = panels.potentials(k, padded)
        return sources, potentials[:, :n]

    def at_infinity(self) -> xr.Dataset:
        """Return added_mass_inf [kg], shape (dof, dof)."""
        labels = list(self.body.labels)
        return xr.Dataset({"added_mass_inf": (PAIR, self.added_mass_inf())}, coords=dict.fromkeys(PAIR, labels))

    def froude_krylov(self, omegas: FloatArray, directions: FloatArray) -> ComplexArray:
        """Return the force of the undisturbed wave, shape (omega, direction, dof) [N/m]; parameters as of `solve`."""
        water, centres = self.water, self.panels.whole.faces_centers[: len(self.body.faces)]
        k = [wavenumber(float(omega), water.depth, water.gravity) for omega in omegas]
        waves = np.array([unit_wave(centres, each, water.depth, directions) for each in k])
        return np.asarray(water.gravity * waves @ self.onto.T)

    def solve(self, omega: float, directions: FloatArray) -> xr.Dataset:
        """Solve one frequency [rad/s] in waves of given directions [rad].

        Returns
        -------
        xarray.Dataset
            added_mass, radiation_damping, Froude_Krylov_force, diffraction_force, and from the radiated waves
            `haskind_force`, the excitation by Haskind's relation, and `far_field_damping`, by the energy they carry.

        Notes
        -----
        With sources sigma that make the potential phi_j = -int sigma/(4 pi) (1/r + ...), Green's theorem turns
        Haskind's relation into X_j = -rho g sum_k a_k sigma_jk f(x_k), exact for these sources. Energy is
        B_ij = k/(8 pi rho g v_g) int X_i X_j^* d beta, the trapezoidal rule exact to round-off.
        """
        water, panels, n = self.water, self.panels.whole, len(self.body.faces)
        centres, normals, k = panels.faces_centers, panels.faces_normals, wavenumber(omega, water.depth, water.gravity)
        unit = -1j * water.gravity / omega  # potential of a wave over its f
        slope = unit_wave_slope(centres[:n], normals[:n], k, water.depth, directions)
        wave = unit_wave(centres, k, water.depth, directions)
        solved = self.coefficients(omega, k, unit * wave[:, :n], unit * slope)
        strength = -water.density * water.gravity * panels.faces_areas * solved.sources
        count = 32 + 4 * int(np.ceil(k * self.body.size))
        x = strength @ unit_wave(centres, k, water.depth, 2 * np.pi * np.arange(count) / count).T
        (factor,) = haskind_factor(np.array([omega]), water.depth, water.density, water.gravity)
        ds = solved_dataset([omega], self.body.labels, [solved[:4]], directions)
        return ds.assign(
            far_field_damping=(("omega", *PAIR), (factor / count * (x @ x.conj().T).real)[None]),
            haskind_force=(ds.diffraction_force.dims, (wave @ strength.T)[None]),
        )
