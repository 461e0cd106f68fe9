"""Bodies of one mesh must not lie in each other, nor touch: panels there see no water."""

from itertools import permutations

import numpy as np

from vsb.errors import ConfigError
from vsb.hydro.bodies.body import FlexibleBody, owners
from vsb.study.quantities import body_of
from vsb.tools.arrays import BoolArray, FloatArray

_INSIDE = 0.5  # of a full solid angle
_BEFORE = 1e-3  # of the size of a panel: how far before it there must be water
_MANY = 2**22  # solid angles at a time


def check_apart(body: FlexibleBody) -> None:
    """Check that the separate parts of a mesh lie outside each other and share no panel.

    Raises
    ------
    ConfigError
        If two of them overlap or touch, or a panel is there twice.
    """
    owner = owners(body.vertices)
    corners = np.sort(owner[body.faces], axis=1)
    _, first, count = np.unique(corners, axis=0, return_index=True, return_counts=True)
    if (twice := first[count > 1]).size:
        at = ", ".join(f"{x:.4g}" for x in body.centres[twice[0]])
        raise ConfigError(f"mesh: panel {twice[0]} at ({at}) is there twice; needs bodies apart, water between them")
    part, normal = body.part, body.triangles.area.reshape(2, -1, 3).sum(axis=0)
    before = body.centres + _BEFORE * normal / np.sqrt(np.linalg.norm(normal, axis=1, keepdims=True))
    for one, other in permutations(range(int(part.max()) + 1), 2):
        inside = _winding(body, part == other, before[part == one]) > _INSIDE
        if inside.any():
            at = ", ".join(f"{x:.4g}" for x in body.centres[part == one][inside][0])
            raise ConfigError(
                f"mesh: {np.count_nonzero(inside)} panels of {_name(body, one)} lie inside {_name(body, other)} or on "
                f"its wall, the first at ({at}); needs bodies apart, water between them"
            )


def _name(body: FlexibleBody, part: int) -> str:
    """The body a part is, if labels such as `float__Heave` say so of what moves it alone."""
    here, there = (np.abs(body.modes[:, mine]).max(axis=(1, 2)) for mine in (body.part == part, body.part != part))
    names = [body_of(label) for label, own, rest in zip(body.labels, here, there, strict=True) if own > 0 == rest]
    return next(filter(None, names), f"part {part + 1}")


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
