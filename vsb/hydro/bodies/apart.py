"""Bodies of one mesh must not lie in each other, nor touch: panels there see no water."""

from itertools import permutations

import numpy as np

from vsb.errors import ConfigError
from vsb.hydro.bodies.body import FlexibleBody, owners, parts
from vsb.tools.units import BoolArray, FloatArray, IntArray

_INSIDE = 0.5  # of a full solid angle
_CLOSED = 1e-6  # of the three volumes of a closed part, relatively
_MANY = 2**22  # solid angles at a time


def check_apart(body: FlexibleBody) -> None:
    """Check that the closed parts of a mesh lie outside each other and share no panel.

    Raises
    ------
    ConfigError
        If two of them overlap, or a panel is there twice.
    """
    owner = owners(body.vertices)
    corners = np.sort(owner[body.faces], axis=1)
    _, first, count = np.unique(corners, axis=0, return_index=True, return_counts=True)
    if (twice := first[count > 1]).size:
        at = ", ".join(f"{x:.4g}" for x in body.centres[twice[0]])
        raise ConfigError(f"mesh: panel {twice[0]} at ({at}) is there twice; needs bodies apart, water between them")
    part = parts(owner[body.faces], len(owner))
    for one, other in permutations(_closed(body, part), 2):
        inside = _winding(body, part == other, body.centres[part == one]) > _INSIDE
        if inside.any():
            at = ", ".join(f"{x:.4g}" for x in body.centres[part == one][inside][0])
            raise ConfigError(
                f"mesh: {np.count_nonzero(inside)} panels of one part lie inside another, the first at ({at}); needs "
                "bodies apart, water between them"
            )


def _closed(body: FlexibleBody, part: IntArray) -> list[int]:
    """Parts that enclose a volume by themselves: corners that do not meet, of single precision, leave none."""
    corner, area, _ = body.triangles
    volumes = np.zeros((int(part.max()) + 1, 3))
    np.add.at(volumes, np.concatenate([part, part]), corner.mean(axis=1) * area)
    largest = volumes.max(axis=1)
    return np.flatnonzero((largest > 0) & (np.ptp(volumes, axis=1) <= _CLOSED * largest)).tolist()


def _winding(body: FlexibleBody, chosen: BoolArray, points: FloatArray) -> FloatArray:
    """Share of the full solid angle a closed part fills, with its mirror image above still water, shape (point,).

    Of a triangle seen from a point (Van Oosterom and Strackee 1983); one inside, zero outside.
    """
    corner = body.triangles.corner[np.concatenate([chosen, chosen])]
    mirrored = corner[:, ::-1] * np.array([1.0, 1.0, -1.0])
    corner = np.concatenate([corner, mirrored])
    step = max(1, _MANY // len(corner))
    return np.concatenate([_solid_angle(corner, points[i : i + step]) for i in range(0, len(points), step)])


def _solid_angle(corner: FloatArray, points: FloatArray) -> FloatArray:
    """Solid angle of triangles (triangle, 3, xyz) seen from points, over 4 pi, shape (point,)."""
    a, b, c = (corner[None, :, k] - points[:, None] for k in range(3))
    na, nb, nc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
    triple = np.einsum("ptx,ptx->pt", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ptx,ptx->pt", u, v) for u, v in ((a, b), (b, c), (c, a)))
    return np.asarray(2 * np.arctan2(triple, na * nb * nc + ab * nc + bc * na + ca * nb).sum(axis=1) / (4 * np.pi))
