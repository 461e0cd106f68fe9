"""Irregular frequencies and the lids that remove them; resonance of the water between two bodies.

A lid is a set of panels on the water inside a body. One that reaches the waterline spoils coefficients away from the
irregular frequencies: in the corner between wall and lid the source strength is singular, since the water outside keeps
its free surface and the water inside has none, and flat panels resolve that badly however fine: surge added mass of a
box 10 x 8 x 4 m at 2.4 rad/s is 20 % off. A lid that ends one panel short of the waterline avoids the corner (2 %). The
open strip has modes of its own, but only in waves that the panels do not resolve either.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from vsb.engine.hydro.bodies.body import FlexibleBody, panel_areas, panel_size
from vsb.engine.hydro.bodies.mesh import SAME, joined, owners
from vsb.tools.arrays import FloatArray, IntArray

_NARROW = 0.25  # width of a gap, relative to draught and beam


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
