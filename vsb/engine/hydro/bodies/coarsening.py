"""Fewer panels on the same vertices: a second resolution of a mesh, to estimate errors with.

Panels around a vertex are joined into patches, four by four where panels are quadrilaterals, and a patch becomes the
quadrilaterals and triangles between its corners. On a regular mesh this is the mesh of half the resolution, curvature
and displacements included; panels that find no partners stay, and panels are never joined across an edge of the body.
"""

import heapq
from collections import defaultdict
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from vsb.engine.hydro.bodies.body import PLANES, FlexibleBody
from vsb.engine.hydro.bodies.mesh import at_centres, owners
from vsb.tools.arrays import FloatArray, IntArray

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
    """Return fewer panels between the same vertices, mirrored in planes of symmetry (`body.PLANES`).

    Parameters
    ----------
    vertices : ndarray, shape (vertex, xyz) [m]
    faces : ndarray, shape (panel, 4)
        Triangles repeat their last corner.
    """
    corners = owners(vertices)[faces]
    centres = vertices[corners].mean(axis=1)
    kept = np.all([np.ones(len(faces)), *(centres[:, PLANES[plane]] > 0 for plane in planes)], axis=0)
    found, share = _joined_panels(vertices, corners[kept])
    tree = cKDTree(vertices)
    for plane in planes:
        image = np.asarray(tree.query(vertices * np.where(np.arange(3) == PLANES[plane], -1.0, 1.0))[1])
        found = np.concatenate([found, image[found][:, [1, 0, 3, 2]]])
    return Coarser(found, share)


def _joined_panels(vertices: FloatArray, corners: IntArray) -> Coarser:
    """Panels of all patches, and those left over."""
    normals = _areas(vertices, corners)
    areas = np.linalg.norm(normals, axis=1)
    normals /= areas[:, None]
    found, left, coarser = [], set(range(len(corners))), 0.0
    for patch in _patches(corners, normals):
        joined = _between_corners(vertices, corners[patch])
        if 0 < len(joined) < len(patch):
            found += joined
            left -= set(patch)
            coarser += float(areas[patch].sum()) * (len(patch) >= _BOTH_WAYS * len(joined))
    return Coarser(np.array(found + corners[sorted(left)].tolist(), dtype=int), coarser / float(areas.sum()))


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
    blunt = _STRAIGHT if _flat(vertices[loop], normal, float(area)) else _BLUNT
    polygon = _without_blunt_corners(vertices, loop, normal, blunt * float(area))
    cuts = [_cut(polygon[i:] + polygon[:i]) for i in range(len(polygon))]
    thinnest = [_thinnest(vertices, np.array(cut), normal) for cut in cuts]
    best = int(np.argmax(thinnest))
    return cuts[best] if thinnest[best] > _FLATTEST * area / (len(polygon) - 2) else []


def _flat(boundary: FloatArray, normal: FloatArray, area: float) -> bool:
    """Whether the boundary of a patch lies in a plane."""
    return bool(np.ptp(boundary @ normal) < 1e-6 * np.sqrt(area))


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
