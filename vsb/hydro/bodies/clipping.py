"""The wetted part of a mesh that reaches above the water, as programs for design write it, displacements with it."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from vsb.errors import ConfigError
from vsb.hydro.bodies.body import AT_SURFACE, at_centres, at_vertices
from vsb.hydro.bodies.rigid import displaced, rigid_motion
from vsb.hydro.panels.rings import immersed_panels
from vsb.tools.arrays import BoolArray, FloatArray, IntArray

FLAT = 1e-7
"""Height of a panel, in lengths of the body, that single precision makes of none."""


class Wetted(NamedTuple):
    """Panels below z = 0 and where their vertices come from."""

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

        Rigid motions stay rigid; of others the centre of a cut panel moves along the slope between the corners.
        """
        vertices, faces = mesh
        before, centres = (at_centres(x, f, x[None])[0] for x, f in (mesh, (self.vertices, self.faces)))
        corners = at_vertices(vertices, faces, values)
        moved = at_centres(self.vertices, self.faces, self.at_vertices(corners))
        found = values[:, self.parent] + moved - at_centres(vertices, faces, corners)[:, self.parent]
        for i, field in enumerate(values):
            if motion := rigid_motion(before, field):
                found[i] = displaced(motion, centres)
        return np.asarray(found)


def wetted(vertices: FloatArray, faces: IntArray) -> Wetted | None:
    """Return the part of a mesh below z = 0, cut by capytaine, None if all of it is.

    Panels in the water's surface, a deck or a lid, are left out.

    Raises
    ------
    ConfigError
        If no panel is below the surface.
    """
    tolerance = AT_SURFACE * float(np.linalg.norm(np.ptp(vertices[np.unique(faces)], axis=0)))
    height = np.where(np.abs(vertices[:, 2]) <= tolerance, 0.0, vertices[:, 2])
    level = np.column_stack([vertices[:, :2], height])
    flat, above = np.all(height[faces] == 0, axis=1), np.any(height[faces] > 0, axis=1)
    if not (flat.any() or above.any() or (height != vertices[:, 2]).any()):
        return None
    below = np.flatnonzero((height[faces] < 0).any(axis=1))
    if not len(below):
        raise ConfigError(f"mesh: none of {len(faces)} panels lies below z = 0; needs the water's surface at z = 0")
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
    cut, dry = int(above[below].sum()), len(faces) - len(below)
    note = f"clipped at z = 0: {cut} of {len(faces)} panels cut, {dry} above the water or in its surface left out"
    points[:, 2] = np.minimum(points[:, 2], 0.0)
    return Wetted(points, panels, below[parent], ends[origin], share[origin], note if cut or dry else "")


def without_area(vertices: FloatArray, faces: IntArray) -> BoolArray:
    """Return which panels have no area but round-off's, shape (panel,): files have them where a quadrilateral ends."""
    corner = vertices[faces]
    a, b, c = (corner[:, k] - corner[:, 0] for k in (1, 2, 3))
    area = (np.linalg.norm(np.cross(a, b), axis=1) + np.linalg.norm(np.cross(b, c), axis=1)) / 2
    longest = np.max([np.linalg.norm(corner[:, k] - corner[:, k - 1], axis=1) for k in range(4)], axis=0)
    return np.asarray(area <= FLAT * longest * np.linalg.norm(np.ptp(vertices, axis=0)))
