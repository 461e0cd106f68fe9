"""Meshes of plain hulls, whole, deck included, with a row of corners at the waterline."""

import math
from itertools import pairwise

import numpy as np

from vsb.engine.hydro.bodies.plain_hulls import BoxHull, CapsuleHull, CylinderHull, SphereHull
from vsb.engine.hydro.panels.mesh import polygon_radius, revolved
from vsb.engine.hydro.panels.rings import box_panels
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray, IntArray

_ARC = 2000  # points of a quarter circle
_MOST = 200_000  # panels


def hull_panels(hull: SphereHull | CylinderHull | CapsuleHull | BoxHull) -> tuple[FloatArray, IntArray]:
    """Return vertices (vertex, xyz) [m] and panels (panel, 4) of a plain hull on the z axis, normals outward.

    Round waterlines are polygons of the circle's area, their corners in multiples of four: both planes are symmetric.
    Raises `ConfigError` if the panels are too many.
    """
    if isinstance(hull, BoxHull):
        return _box(hull)
    edges = _rows(_profile(hull), hull.panel)
    around = 4 * max(2, math.ceil(np.pi * hull.radius / (2 * hull.panel)))
    _check_count(len(edges) * around, hull.panel)
    vertices, faces = revolved(edges[:, 0] * polygon_radius(around), edges[:, 1], around)
    return vertices, faces.astype(int)


def _check_count(count: float, panel: float) -> None:
    """Raise `ConfigError` for more panels than can be solved."""
    if count > _MOST:
        raise ConfigError(f"mesh.panel: received {panel:g} m, which makes {count:.3g} panels; needs larger ones")


def _box(hull: BoxHull) -> tuple[FloatArray, IntArray]:
    """A box, an even number of panels along and across it, rows below and above the water of their own height."""
    levels = [-hull.draft, *([0.0] if hull.draft < hull.height else []), hull.height - hull.draft]
    rows = [math.ceil(high / hull.panel - low / hull.panel) for low, high in pairwise(levels)]
    along, across = (2 * math.ceil(side / (2 * hull.panel)) for side in (hull.length, hull.width))
    _check_count(2.0 * (along * across + (along + across) * sum(rows)), hull.panel)
    vertices, faces = box_panels((hull.length, hull.width, 1.0), (along, across, sum(rows)))
    even = np.concatenate([[0], np.cumsum(rows)]) / sum(rows) - 0.5
    vertices[:, 2] = np.interp(vertices[:, 2], even, levels)
    return vertices, faces


def _profile(hull: SphereHull | CylinderHull | CapsuleHull) -> list[FloatArray]:
    """Pieces of the meridian from top to bottom, each of points (point, rz) [m]."""
    top, bottom, r = hull.height - hull.draft, -hull.draft, hull.radius
    if isinstance(hull, CylinderHull):
        corners = np.array([[0.0, top], [r, top], [r, bottom], [0.0, bottom]])
        return [corners[k : k + 2] for k in range(3)]
    angle = np.linspace(0.0, np.pi / 2, _ARC)
    arc = r * np.column_stack([np.sin(angle), np.cos(angle)])
    upper, lower = arc + np.array([0.0, top - r]), arc[::-1] * [1.0, -1.0] + np.array([0.0, bottom + r])
    if isinstance(hull, SphereHull):
        return [np.concatenate([upper, lower[1:]])]
    return [upper, np.array([upper[-1], lower[0]]), lower] if hull.height > 2 * r else [upper, lower]


def _rows(pieces: list[FloatArray], panel: float) -> FloatArray:
    """Edges of even rows of panels along the pieces of a meridian, cut at the waterline, shape (edge, rz) [m]."""
    edges = [pieces[0][:1]]
    for piece in pieces:
        s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(piece, axis=0), axis=1))])
        ends = [0.0, s[-1]]
        if piece[0, 1] > 0 > piece[-1, 1]:
            ends.insert(1, float(np.interp(0.0, -piece[:, 1], s)))
        for start, end in pairwise(ends):
            count = min(math.ceil((end - start) / panel), _MOST)
            at = np.linspace(start, end, count + 1)[1:]
            edges.append(np.column_stack([np.interp(at, s, piece[:, k]) for k in (0, 1)]))
    found = np.concatenate(edges)
    return np.where(np.abs(found) < 1e-12 * np.abs(found).max(), 0.0, found)
