"""Whether panels close a surface below the water's: a matter of edges, which belong to two panels each.

Meshers leave edges unmatched where patches do not meet corner by corner. Such an edge is closed if another one runs the
other way beside it; how much the gap between them matters is for the volumes to say.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray, IntArray

_BESIDE = 0.1  # width of a gap, in terms of the longer of its edges
_TWICE = 2  # panels that run along an edge the same way


class Gaps(NamedTuple):
    """Edges below the water's surface that do not belong to two panels each."""

    width: float  # [m], of the widest gap between edges beside each other that do not meet
    place: FloatArray  # (xyz) [m], there
    beside: IntArray  # (n, 2): panels on both sides of such gaps
    open: FloatArray  # (edge, 2, xyz) [m]: edges that have no other beside them
    turned: FloatArray  # (edge, 2, xyz) [m]: edges along which panels face opposite ways


def gaps(vertices: FloatArray, corners: IntArray, surface: float) -> Gaps:
    """Return the gaps between panels, shape (panel, 4), of vertices, shape (vertex, xyz) [m].

    `corners` are the numbers of vertices, one for those that coincide; edges above the height `surface` [m] are the
    waterline's.
    """
    edges, panel, net = _single_edges(corners)
    below = (vertices[edges][..., 2] < surface).any(axis=1)
    ends, panel = vertices[edges[below]], panel[below]
    turned = vertices[edges[np.abs(net) >= _TWICE]]
    if not len(ends):
        return Gaps(0.0, np.zeros(3), np.empty((0, 2), dtype=int), ends, turned)
    length, width = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), np.full(len(ends), np.inf)
    middle = ends.mean(axis=1)
    near, joins = cKDTree(middle).query_pairs(1.1 * float(length.max()), output_type="ndarray"), []
    for i, j in (near.T, near.T[::-1]):
        opposed = ((ends[i, 1] - ends[i, 0]) * (ends[j, 1] - ends[j, 0])).sum(axis=1) < 0
        a, b = i[opposed], j[opposed]
        distance = _distance(middle[a], ends[b])
        beside = distance < _BESIDE * np.maximum(length[a], length[b])
        np.minimum.at(width, a[beside], distance[beside])
        joins.append(np.column_stack([panel[a[beside]], panel[b[beside]]]))
    matched = np.isfinite(width)
    widest = int(np.argmax(np.where(matched, width, -1.0)))
    return Gaps(float(width[widest]), middle[widest], np.concatenate(joins), ends[~matched], turned)


def check_closed(found: Gaps) -> None:
    """Raise `ConfigError`, which says where, if edges of a surface have no other beside them or panels are turned."""
    if len(found.turned):
        raise ConfigError(
            f"mesh: the panels on both sides of the edge at {_words(found.turned[0].mean(axis=0))} list their corners "
            "in opposite order; needs all normals into the water: turn one of them"
        )
    if not len(ends := found.open):
        return
    on = np.abs(ends).max(axis=1)[:, :2] < 1e-6 * np.abs(ends).max()
    if on.any(axis=1).all():
        names = " and ".join(f"{name} = 0" for k, name in enumerate("xy") if (on[:, k] & ~on[:, 1 - k]).any())
        raise ConfigError(
            f"mesh: open along {names}, where {len(ends)} edges belong to one panel only: a half or quarter of a body; "
            "needs the whole wetted surface: mirror it, or set the symmetry flags of its file (ISX, ISY of a GDF)"
        )
    longest = int(np.argmax(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)))
    raise ConfigError(
        f"mesh: open at {_words(ends[longest].mean(axis=0))}: {len(ends)} edges below z = 0 belong to one panel only; "
        "needs a surface that is closed below z = 0: add the panels that lack, or let corners meet"
    )


def panel_edges(corners: IntArray) -> tuple[IntArray, IntArray]:
    """Return the edges of panels, shape (edge, 2), in the direction they go around them, and whose they are."""
    edges = np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1).reshape(-1, 2)
    panel = np.repeat(np.arange(len(corners)), corners.shape[1])
    some = edges[:, 0] != edges[:, 1]
    return edges[some], panel[some]


def _single_edges(corners: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Edges without one that runs the other way, shape (edge, 2), a panel of each, and how many run this way more."""
    edges, panel = panel_edges(corners)
    pairs, place = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    net = np.bincount(place.ravel(), weights=np.where(edges[:, 0] < edges[:, 1], 1, -1)).astype(int)
    single, of = net != 0, np.empty(len(pairs), dtype=int)
    of[place.ravel()] = panel
    return np.where(net[single, None] > 0, pairs[single], pairs[single, ::-1]), of[single], net[single]


def _distance(points: FloatArray, ends: FloatArray) -> FloatArray:
    """Distance of each point from its own edge, shape (point,) [m]."""
    along = ends[:, 1] - ends[:, 0]
    share = np.clip(((points - ends[:, 0]) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - ends[:, 0] - share[:, None] * along, axis=1))


def _words(point: FloatArray) -> str:
    """A place in an error's line."""
    return "({})".format(", ".join(f"{x:.4g}" for x in point))
