"""Panels of a surface: values at centres and corners, edges and gaps, the wetted part, rigid motions of points.

Panels are quadrilaterals, shape (panel, 4), of vertices, shape (vertex, xyz) [m]; triangles repeat their last corner.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from vsb.engine.hydro.panels.bem import immersed_panels
from vsb.errors import ConfigError
from vsb.tools.arrays import BoolArray, FloatArray, IntArray

SAME = 1e-8
"""Distance of vertices that coincide, relative to the size of the body."""
AT_SURFACE = 1e-6
"""Height of a waterline, relative to the size of the body: what single precision makes of z = 0."""
FLAT = 1e-7
"""Height of a panel without area, relative to the size of the body: round-off of single precision."""
RIGID_TO = 1e-6
"""Distance of a displacement from a rigid one, relative to the largest: round-off of single precision."""
_NO_MOTION = 1e-9  # relative to the largest displacement: round-off of a fit
_LARGEST_BODY = 1e5  # [m]
_MOST_TRIANGLES = 50_000
_MANY = 2**22  # solid angles at a time
_MOST_TRIED = 20  # parts looked at for being plates
_BESIDE = 0.1  # width of a gap between two edges, relative to the longer of them


# Values at panels and vertices


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
    """Return values at panels as means over the panels around each vertex, (n, panel, xyz) -> (n, vertex, xyz).

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


def without_area(vertices: FloatArray, faces: IntArray) -> BoolArray:
    """Return which panels have no area beyond round-off, shape (panel,)."""
    corner = vertices[faces]
    a, b, c = (corner[:, k] - corner[:, 0] for k in (1, 2, 3))
    area = (np.linalg.norm(np.cross(a, b), axis=1) + np.linalg.norm(np.cross(b, c), axis=1)) / 2
    longest = np.max([np.linalg.norm(corner[:, k] - corner[:, k - 1], axis=1) for k in range(4)], axis=0)
    return np.asarray(area <= FLAT * longest * np.linalg.norm(np.ptp(vertices, axis=0)))


def repeated(vertices: FloatArray, faces: IntArray) -> BoolArray:
    """Return which panels have the corners of an earlier one, in whatever order, shape (panel,)."""
    corners = np.sort(owners(vertices)[faces], axis=1)
    corners[:, 1:][np.diff(corners, axis=1) == 0] = -1  # triangles repeat one of theirs
    _, first = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
    later = np.ones(len(faces), dtype=bool)
    later[first] = False
    return later


def joined(meshes: Sequence[tuple[FloatArray, IntArray]]) -> tuple[FloatArray, IntArray]:
    """Return the vertices and panels of several meshes as one, panels in order."""
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    faces = [panels + offset for (_, panels), offset in zip(meshes, offsets, strict=False)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)


def divided(vertices: FloatArray, faces: IntArray, size: float) -> tuple[FloatArray, IntArray]:
    """Return a surface of triangles whose edges are no longer than a size [m]: the same surface, corners still meet.

    An edge that is the longest of both its triangles is halved, and they with it, until none is longer (Rivara, Int. J.
    Numer. Methods Eng. 20, 1984: no angle becomes much smaller). Raises `ConfigError` if that takes too many.
    """
    corners = owners(vertices)[np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])]
    corners = corners[(corners != np.roll(corners, 1, axis=1)).all(axis=1)]
    while len(corners) <= _MOST_TRIANGLES:
        sides = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1), axis=-1)
        edges, place = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True)
        place = place.reshape(-1, 3)
        length = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
        rank = np.argsort(np.argsort(length, kind="stable"))
        side, every = rank[place].argmax(axis=1), np.arange(len(corners))
        longest = place[every, side]
        halved = np.bincount(longest, minlength=len(edges)) == np.bincount(place.ravel(), minlength=len(edges))
        halved &= length > size
        if not halved.any():
            return vertices, np.column_stack([corners, corners[:, 2]])
        middle = len(vertices) - 1 + np.cumsum(halved)
        vertices = np.concatenate([vertices, vertices[edges[halved]].mean(axis=1)])
        cut = halved[longest]
        start, end, other = (corners[every, (side + k) % 3][cut] for k in range(3))
        new = middle[longest[cut]]
        halves = np.stack([start, new, other], axis=1), np.stack([new, end, other], axis=1)
        corners = np.concatenate([corners[~cut], *halves])
    raise ConfigError(f"panel: received {size:g} m, which makes more than {_MOST_TRIANGLES} panels; needs larger ones")


def triangulated(points: FloatArray) -> IntArray | None:
    """Return the triangles of a plane polygon by its corners, shape (corner, xyz) -> (triangle, 3); None if it crosses.

    Ears are cut: convex corners whose triangle holds no other corner, not even on its sides, so that corners along a
    straight side stay corners of panels (Meisters, Amer. Math. Monthly 82, 1975: every simple polygon has two).
    """
    doubled = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(doubled))
    if size <= 0:
        return None
    plane = np.linalg.svd(doubled[None] / size)[2][1:]
    plane = plane if np.cross(*plane) @ doubled > 0 else plane[::-1]
    flat, left, found = points @ plane.T, list(range(len(points))), []

    def doubled_area(a: int, b: int, c: int | list[int]) -> FloatArray:
        (x, y), (u, v) = flat[b] - flat[a], np.moveaxis(flat[c] - flat[a], -1, 0)
        return np.asarray(x * v - y * u)

    while len(left) > 2:
        for k, b in enumerate(left):
            a, c = left[k - 1], left[(k + 1) % len(left)]
            others = [p for p in left if p not in (a, b, c)]
            sides = [doubled_area(*side, others) >= -FLAT * size for side in ((a, b), (b, c), (c, a))]
            if doubled_area(a, b, c) > FLAT * size and not np.all(sides, axis=0).any():
                found.append([a, b, c])
                del left[k]
                break
        else:
            return None
    return np.array(found)


def check_finite(x: FloatArray) -> None:
    """Raise `ConfigError` unless points, shape (vertex, xyz), are finite."""
    if not np.isfinite(x).all():
        raise ConfigError("mesh: a vertex is NaN or infinite; needs finite coordinates")


def check_vertices(x: FloatArray) -> None:
    """Raise `ConfigError` unless points, shape (vertex, xyz), can be those of a body in metres."""
    check_finite(x)
    if np.abs(x).max(initial=0.0) > _LARGEST_BODY:
        raise ConfigError(
            f"mesh: reaches {np.abs(x).max():.3g} m; needs at most {_LARGEST_BODY:g} m: is it in metres? else give its "
            "unit, mesh: {file: ..., unit: mm}"
        )


def text_of(point: FloatArray) -> str:
    """Return a point as text for messages."""
    return "({})".format(", ".join(f"{x:.4g}" for x in point))


def solid_angle_share(corner: FloatArray, points: FloatArray) -> FloatArray:
    """Return the share of the full solid angle that triangles and their mirror images above still water fill, (point,).

    Of a closed surface with normals outward it is one inside and zero outside; of a triangle by Van Oosterom and
    Strackee (IEEE Trans. Biomed. Eng. 30, 1983). Triangles have the shape (triangle, 3, xyz), points (point, xyz).
    """
    corner = np.concatenate([corner, corner[:, ::-1] * np.array([1.0, 1.0, -1.0])])

    def seen_from(some: FloatArray) -> FloatArray:
        a, b, c = (corner[None, :, k] - some[:, None] for k in range(3))
        na, nb, nc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
        triple = np.einsum("ptx,ptx->pt", a, np.cross(b, c))
        ab, bc, ca = (np.einsum("ptx,ptx->pt", u, v) for u, v in ((a, b), (b, c), (c, a)))
        return np.asarray(np.arctan2(triple, na * nb * nc + ab * nc + bc * na + ca * nb).sum(axis=1) / (2 * np.pi))

    step = max(1, _MANY // max(1, len(corner)))
    return np.concatenate([seen_from(points[i : i + step]) for i in range(0, len(points), step)])


# Edges: which panels are connected, and where a surface is open


class Gaps(NamedTuple):
    """Edges below the water's surface that do not belong to two panels each.

    Meshers leave edges unmatched where patches do not meet corner by corner. Such an edge is closed if another one runs
    the other way beside it; how much the gap between them matters follows from the volumes (`body.CLOSED`).
    """

    width: float  # [m], of the widest gap between edges beside each other that do not meet
    place: FloatArray  # (xyz) [m], there
    beside: IntArray  # (n, 2): panels on both sides of such gaps
    open: FloatArray  # (edge, 2, xyz) [m]: edges that have no other beside them
    crowded: BoolArray  # (edge,): those of them that belong to three panels or more
    turned: FloatArray  # (edge, 2, xyz) [m]: edges along which panels face opposite ways
    low: FloatArray  # (xyz) [m]: least and largest coordinates of the panels
    high: FloatArray


def panel_edges(corners: IntArray) -> tuple[IntArray, IntArray]:
    """Return the edges of panels in the direction around them, shape (edge, 2), and the panel of each."""
    edges = np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1).reshape(-1, 2)
    panel = np.repeat(np.arange(len(corners)), corners.shape[1])
    some = edges[:, 0] != edges[:, 1]
    return edges[some], panel[some]


def parts(faces: IntArray, beside: IntArray) -> IntArray:
    """Return the number of the connected part each panel belongs to, in the order of first panels, shape (panel,).

    Panels are connected if an edge belongs to both and to no third, or if they lie `beside` each other, shape
    (pair, 2): where bodies touch, an edge belongs to four.
    """
    edges, panel = panel_edges(faces)
    _, place, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    shared = count[place.ravel()] == 2
    start = np.concatenate([panel[shared], beside[:, 0]])
    end = np.concatenate([place.ravel()[shared] + len(faces), beside[:, 1]])
    graph = coo_matrix((np.ones(len(start)), (start, end)), shape=(len(faces) + len(edges),) * 2)
    found = connected_components(graph, directed=False)[1][: len(faces)]
    _, first, number = np.unique(found, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[number])


def gaps(vertices: FloatArray, corners: IntArray, surface: float, bed: float = -np.inf) -> Gaps:
    """Return the gaps between panels; edges above the height `surface` [m] are the waterline's, those on a bed closed.

    `corners`, shape (panel, 4), are the numbers of vertices, one number for vertices that coincide.
    """
    edges, panel = panel_edges(corners)
    pairs, place, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    net = np.bincount(place.ravel(), weights=np.where(edges[:, 0] < edges[:, 1], 1, -1)).astype(int)
    of = np.empty(len(pairs), dtype=int)
    of[place.ravel()] = panel
    single = net != 0  # edges without one that runs the other way
    edges = np.where(net[single, None] > 0, pairs[single], pairs[single, ::-1])
    panel, net, crowded = of[single], net[single], count[single] > 2
    height = vertices[edges][..., 2]
    below = (height < surface).any(axis=1) & (height > bed).any(axis=1)
    ends, panel, crowded = vertices[edges[below]], panel[below], crowded[below]
    turned = vertices[edges[np.abs(net) >= 2]]
    low, high = (end(vertices[corners], axis=(0, 1)) for end in (np.min, np.max))
    if not len(ends):
        return Gaps(0.0, np.zeros(3), np.empty((0, 2), dtype=int), ends, crowded, turned, low, high)
    length, width = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), np.full(len(ends), np.inf)
    middle = ends.mean(axis=1)
    near, joins = cKDTree(middle).query_pairs(1.1 * float(length.max()), output_type="ndarray"), []
    for i, j in (near.T, near.T[::-1]):
        opposed = ((ends[i, 1] - ends[i, 0]) * (ends[j, 1] - ends[j, 0])).sum(axis=1) < 0
        a, b = i[opposed], j[opposed]
        along = ends[b, 1] - ends[b, 0]
        share = np.clip(((middle[a] - ends[b, 0]) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
        distance = np.linalg.norm(middle[a] - ends[b, 0] - share[:, None] * along, axis=1)
        beside = distance < _BESIDE * np.maximum(length[a], length[b])
        np.minimum.at(width, a[beside], distance[beside])
        joins.append(np.column_stack([panel[a[beside]], panel[b[beside]]]))
    matched = np.isfinite(width)
    widest = int(np.argmax(np.where(matched, width, -1.0)))
    beside, ends, crowded = np.concatenate(joins), ends[~matched], crowded[~matched]
    return Gaps(float(width[widest]), middle[widest], beside, ends, crowded, turned, low, high)


def turned_outward(vertices: FloatArray, faces: IntArray) -> IntArray:
    """Return panels all of which have their normals into the water, as far as that can be decided.

    Neighbours run along their common edge in opposite directions. Of a connected part the side that is outward follows
    from the volume it encloses, if it is closed below the water, else from most of its panels. Parts where three panels
    meet at an edge, or without two sides, stay as they are.
    """
    corners = owners(vertices)[faces]
    edges, panel = panel_edges(corners)
    _, place, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    place, forward = place.ravel(), edges[:, 0] < edges[:, 1]
    order = np.argsort(place, kind="stable")
    first = (np.cumsum(count) - count)[count == 2]
    tolerance = AT_SURFACE * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    i, j, opposed = panel[order[first]], panel[order[first + 1]], forward[order[first]] != forward[order[first + 1]]
    n, other = len(faces), np.where(opposed, 0, len(faces))
    ends = np.concatenate([i, i + n]), np.concatenate([j + other, j + n - other])  # panels as they are, and turned
    graph = coo_matrix((np.ones(2 * len(i)), ends), shape=(2 * n, 2 * n))
    group = connected_components(graph, directed=False)[1]
    _, root, part = np.unique(np.minimum(group[:n], group[n:]), return_index=True, return_inverse=True)
    sign = np.where(group[:n] == group[:n][root][part], 1, -1)
    crowded, open_below = count[place] > 2, (count[place] == 1) & (vertices[edges][..., 2] < -tolerance).any(axis=1)
    fixed = np.isin(part, part[panel[crowded]]) | (group[:n] == group[n:])
    is_open = np.isin(np.arange(len(root)), part[panel[open_below]])
    corner = vertices[np.stack([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])]
    area = np.cross(corner[:, :, 1] - corner[:, :, 0], corner[:, :, 2] - corner[:, :, 0]) / 2
    middle = corner.mean(axis=(0, 2))
    centre = np.array([np.bincount(part, x) for x in middle.T]).T / np.bincount(part)[:, None]
    flux = ((corner.mean(axis=2) - centre[part]) * area)[..., :2].sum(axis=(0, 2)) * sign
    outward = np.sign(np.where(is_open, np.bincount(part, sign), np.bincount(part, flux)))
    turned = (sign * outward[part] < 0) & ~fixed
    triangle = (faces[:, 2] == faces[:, 3])[:, None]  # which still repeats its last corner
    opposite = np.where(triangle, faces[:, [0, 2, 1, 1]], faces[:, [0, 3, 2, 1]])
    return np.where(turned[:, None], opposite, faces)


def check_closed(found: Gaps) -> None:
    """Raise `ConfigError`, which says where, if a surface is open or its panels are turned against each other."""
    if len(found.turned):
        raise ConfigError(
            f"mesh: panels at the edge at {text_of(found.turned[0].mean(axis=0))} list their corners in opposite "
            "order, or are there twice; needs each panel once and all normals into the water: turn or delete one"
        )
    if not len(ends := found.open):
        return
    on = np.abs(ends).max(axis=1)[:, :2] < 1e-6 * np.abs(ends).max()
    beside = on.any(axis=0) & (np.minimum(-found.low, found.high)[:2] < 1e-6 * np.abs(ends).max())  # on one side of it
    if on[:, beside].any(axis=1).all():
        planes = [f"{name} = 0" for k, name in enumerate("xy") if (on[:, k] & ~on[:, 1 - k]).any()]
        side = (
            f"; if {planes[0]} is its waterline it lies on its side: turn it by up: {planes[0][0]} or -{planes[0][0]}"
            if len(planes) == 1
            else ""
        )
        raise ConfigError(
            f"mesh: open along {' and '.join(planes)}, where {len(ends)} edges belong to one panel only: a half or "
            "quarter of a body; needs the whole wetted surface: mirror it, or set the symmetry flags of its file (ISX, "
            f"ISY of a GDF){side}"
        )
    longest = int(np.argmax(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)))
    several = "to three panels or more" if found.crowded[longest] else "to one panel only"
    raise ConfigError(
        f"mesh: open at {text_of(ends[longest].mean(axis=0))}: {len(ends)} edges below z = 0 belong {several}; "
        "needs a surface that is closed below z = 0: add missing panels, let corners meet, or delete a wall inside"
    )


def without_thickness(vertices: FloatArray, corners: IntArray, part: IntArray, surface: float) -> BoolArray:
    """Return the panels of an open surface without which the rest is closed, shape (panel,): plates, or walls inside.

    They are connected parts (`parts`) that are flat or meet two other panels at an edge; a hull with a hole is neither.
    """
    edges, panel = panel_edges(corners)
    _, place, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    below = (vertices[edges][..., 2] < surface).any(axis=1)
    at, every = count[place.ravel()], np.arange(part.max() + 1)
    free, crowded = (np.unique(part[panel[below & found]]) for found in (at == 1, at > 2))
    thin = [p for p in every if p in crowded or flatness(vertices[corners[part == p]]) <= AT_SURFACE]
    thin.sort(key=lambda p: int(np.count_nonzero(part == p)))
    tried = [[p for p in thin if p in free], *([p] for p in thin)]
    for some in tried[:_MOST_TRIED]:
        chosen = np.isin(part, some)
        if some and not chosen.all():
            rest = gaps(vertices, corners[~chosen], surface)
            if not len(rest.open) and not len(rest.turned):
                return chosen
    return np.zeros(len(corners), dtype=bool)


def flatness(corner: FloatArray) -> float:
    """Return the least extent of points, shape (..., xyz), over the largest; zero if they lie in a plane [-]."""
    points = corner.reshape(-1, 3)
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return float(spread[2] / spread[0])


# Rigid motions of points


class Rigid(NamedTuple):
    """A rigid motion t + a x r."""

    translation: FloatArray  # t (xyz)
    rotation: FloatArray  # a (xyz)

    def at(self, points: FloatArray) -> FloatArray:
        """Return the displacements of points, shape (..., xyz)."""
        return np.asarray(self.translation + np.cross(self.rotation, points))


def fitted_motion(points: FloatArray, moved: FloatArray, size: float) -> Rigid:
    """Return the rigid motion nearest to displacements of points, each shape (point, xyz), of at most `size`.

    Components that move no point beyond round-off are exactly zero.
    """
    columns = [np.tile(e, (len(points), 1)) for e in np.eye(3)] + [np.cross(e, points) for e in np.eye(3)]
    basis = np.array(columns).reshape(6, -1).T
    motion = np.asarray(np.linalg.lstsq(basis, moved.ravel(), rcond=None)[0])
    motion = np.where(np.abs(basis * motion).max(axis=0) > _NO_MOTION * size, motion, 0.0)
    return Rigid(motion[:3], motion[3:])


def rigid_motion(points: FloatArray, moved: FloatArray, size: float = 0.0) -> Rigid | None:
    """Return the rigid motion of points that displacements are, each shape (point, xyz); None if they are not rigid.

    Round-off is relative to the largest displacement or, for a part that hardly moves, to `size`.
    """
    size = max(size, float(np.abs(moved).max(initial=0.0)))
    motion = fitted_motion(points, moved, size)
    return motion if np.abs(motion.at(points) - moved).max(initial=0.0) < RIGID_TO * size else None


def rotation_centre(motions: Sequence[Rigid]) -> FloatArray | None:
    """Return the point nearest to the origin at rest in all motions, t + a x p = 0, (xyz,); None without one."""
    if not motions:
        return None
    crosses = np.concatenate([np.cross(np.eye(3), a).T for _, a in motions])  # rows of p -> p x a
    moved = np.concatenate([t for t, _ in motions])
    point = np.asarray(np.linalg.lstsq(crosses, moved)[0])
    size = RIGID_TO * (1.0 + np.abs(moved).max())
    return point if np.abs(crosses @ point - moved).max() < size else None


# The part below the water


class Wetted(NamedTuple):
    """Panels below z = 0, and where their vertices come from."""

    vertices: FloatArray  # (vertex, xyz) [m]
    faces: IntArray  # (panel, 4)
    parent: IntArray  # (panel,): panel of the mesh each is, or is a piece of
    ends: IntArray  # (vertex, 2): vertices of the mesh each lies between
    share: FloatArray  # (vertex,): how far it is from the first to the second
    history: str

    def at_vertices(self, values: FloatArray) -> FloatArray:
        """Return values at vertices of the mesh, shape (..., vertex, xyz), at those of the wetted part."""
        start, end = (values[..., self.ends[:, k], :] for k in range(2))
        return np.asarray(start + self.share[:, None] * (end - start))

    def at_panels(self, mesh: tuple[FloatArray, IntArray], values: FloatArray) -> FloatArray:
        """Return values at panels of the mesh, shape (n, panel, xyz), at those of the wetted part.

        Rigid motions stay rigid; otherwise the centre of a cut panel moves along the slope between the corners.
        """
        vertices, faces = mesh
        before, centres = (at_centres(x, f, x[None])[0] for x, f in (mesh, (self.vertices, self.faces)))
        corners = at_vertices(vertices, faces, values)
        moved = at_centres(self.vertices, self.faces, self.at_vertices(corners))
        found = values[:, self.parent] + moved - at_centres(vertices, faces, corners)[:, self.parent]
        for i, field in enumerate(values):
            if motion := rigid_motion(before, field):
                found[i] = motion.at(centres)
        return np.asarray(found)


def wetted(vertices: FloatArray, faces: IntArray, bed: float = -np.inf) -> Wetted | None:
    """Return the part of a mesh below z = 0, cut by capytaine, without a deck or lid; None if that is all of it.

    Panels on the sea bed the hull stands on, at a height [m], touch no water. Raises `ConfigError` if no panel is below
    the surface.
    """
    tolerance = AT_SURFACE * float(np.linalg.norm(np.ptp(vertices[np.unique(faces)], axis=0)))
    height = np.where(np.abs(vertices[:, 2]) <= tolerance, 0.0, vertices[:, 2])
    height = np.where(np.abs(height - bed) <= tolerance, bed, height)
    level = np.column_stack([vertices[:, :2], height])
    flat, above = np.all(height[faces] == 0, axis=1), np.any(height[faces] > 0, axis=1)
    bottom = np.all(height[faces] == bed, axis=1)
    if not (flat.any() or above.any() or bottom.any() or (height != vertices[:, 2]).any()):
        return None
    below = np.flatnonzero((height[faces] < 0).any(axis=1) & ~bottom)
    if not len(below):
        raise ConfigError(
            f"mesh: none of {len(faces)} panels lies below z = 0, the lowest point at {height[faces].min():.4g} m; "
            "needs the water's surface at z = 0: move it down by its draught, of rigid hulls by mesh: {file: "
            "hull.stl, draft: 2.0}"
        )
    points, panels, parent = immersed_panels(level, faces[below])
    whole = ~without_area(points, panels)
    panels, parent = panels[whole], parent[whole]
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)
    ends = ends[height[ends[:, 0]] * height[ends[:, 1]] < 0]
    share = height[ends[:, 0]] / (height[ends[:, 0]] - height[ends[:, 1]])
    same = np.repeat(np.arange(len(level))[:, None], 2, axis=1)
    ends, share = np.concatenate([same, ends]), np.concatenate([np.zeros(len(level)), share])
    places = level[ends[:, 0]] + share[:, None] * (level[ends[:, 1]] - level[ends[:, 0]])
    origin = cKDTree(places).query(points)[1]
    cut, standing = int(above[below].sum()), int(bottom.sum())
    dry = len(faces) - len(below) - standing
    clipped = f"clipped at z = 0: {cut} of {len(faces)} panels cut, {dry} above the water or in its surface left out"
    under = f"panels on the sea bed left out, which no water touches: {standing}"
    notes = "; ".join([*[clipped] * bool(cut or dry), *[under] * bool(standing)])
    points[:, 2] = np.minimum(points[:, 2], 0.0)
    return Wetted(points, panels, below[parent], ends[origin], share[origin], notes)
