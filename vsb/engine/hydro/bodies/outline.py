"""Lines of a body that stand for it in a side view: its wetted hull cut along x, and how they are displaced."""

import numpy as np
import xarray as xr

from vsb.engine.hydro.bodies.body import FlexibleBody

OUTLINE = "outline"
"""Variable of a database with the lines, shape (line, end, xyz) [m]."""
DISPLACED = "outline_displacement"
"""Variable with their displacement per unit amplitude of each degree of freedom."""


def cut(body: FlexibleBody) -> xr.Dataset:
    """Return the lines in which the plane y = const through the middle of each separate part cuts the panels.

    Parameters
    ----------
    body : FlexibleBody

    Returns
    -------
    Dataset
        `outline`, shape (line, end, xyz) [m], and `outline_displacement`, shape (influenced_dof, line, end, xyz) [-].
        Both are linear in every half of a panel, as displacements of panels are.
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
