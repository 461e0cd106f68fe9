"""Panels of the wetted mean shell and of its deformed shapes."""

from pathlib import Path

import meshio
import numpy as np
import xarray as xr

from vsb.engine.shell.deformed import DeformedShell, rigid_sphere
from vsb.tools.arrays import FloatArray
from vsb.tools.files import atomic_write

DISPLAY_ROWS, ROWS_PER_DEGREE, MOST_DISPLAY_ROWS = 40, 2, 120
"""Panels of a shell for display: around it and from pole to pole at least; there over the highest degree, at most."""


def graded_colatitudes(waterline: float, rows: int, keel: float = np.pi) -> FloatArray:
    """Return the edges of panel rows between waterline and keel, shape (rows + 1,) [rad], ever finer to the waterline.

    The flow varies fastest at the waterline corner; with 1 - cos(pi s/2) spacing the error there is of second order.
    """
    s = np.linspace(0.0, 1.0, rows + 1)
    return waterline + (keel - waterline) * (1 - np.cos(np.pi * s / 2))


def polygon_radius(azimuth: int) -> float:
    """Return the factor by which a regular polygon's corners must lie outside a circle of equal area [-]."""
    angle = 2 * np.pi / azimuth
    return float(np.sqrt(angle / np.sin(angle)))


def mean_mesh(radius: float, centre_height: float, rows: int, azimuth: int, lid_rows: int) -> xr.Dataset:
    """Return the mesh of a wetted sphere and the interior lid; see `deformed_mesh`."""
    return deformed_mesh(rigid_sphere(radius, centre_height), rows, azimuth, lid_rows)


def deformed_mesh(shell: DeformedShell, rows: int, azimuth: int, lid_rows: int) -> xr.Dataset:
    """Return the meridian of a wetted deformed shell and of the interior lid, to be revolved in `azimuth` panels.

    Raises `ConfigError` if the shell at rest does not cross the water exactly once, or its meridian the axis or itself.

    Returns
    -------
    xarray.Dataset
        meridian_radius, meridian_height (node) and lid_radius (lid_node) [m], from waterline to keel and from axis to
        waterline; the corner radii keep the area of every circle. Per row of panels the colatitude of its middle on
        the undeformed sphere [rad] and the shell's unit normal there, normal_radius and normal_height (row).
    """
    phi = graded_colatitudes(shell.waterline, rows)
    middle = (phi[1:] + phi[:-1]) / 2
    nodes, at = shell.meridian(phi), shell.meridian(middle)
    nodes.z[0] = nodes.x[-1] = 0.0
    length, corner = np.hypot(at.dx, at.dz), polygon_radius(azimuth)
    return xr.Dataset(
        {
            "meridian_radius": ("node", corner * nodes.x),
            "meridian_height": ("node", nodes.z),
            "lid_radius": ("lid_node", corner * np.linspace(0.0, nodes.x[0], lid_rows + 1)),
            "row_colatitude": ("row", middle),
            "normal_radius": ("row", -at.dz / length),
            "normal_height": ("row", at.dx / length),
        },
        attrs={"azimuth": azimuth},
    )


def revolved(x: FloatArray, z: FloatArray, azimuth: int) -> tuple[FloatArray, FloatArray]:
    """Return vertices (vertex, 3) [m] and quadrilaterals (face, 4) of a meridian revolved about the z axis."""
    theta = 2 * np.pi * np.arange(azimuth) / azimuth
    ring = np.stack([np.cos(theta), np.sin(theta)], axis=1)
    vertices = np.concatenate([np.column_stack([xi * ring, np.full(azimuth, zi)]) for xi, zi in zip(x, z, strict=True)])
    j = np.arange(azimuth)
    following = (j + 1) % azimuth
    quad = np.stack([j, following, azimuth + following, azimuth + j], axis=1)[:, ::-1]
    faces = np.concatenate([quad + azimuth * i for i in range(len(x) - 1)])
    return vertices, faces


def write_shell(shell: DeformedShell, path: str | Path) -> None:
    """Write a shell at rest as quadrilaterals with the displacement of every mode per unit amplitude at its points.

    To any format meshio knows with vectors at points, named as the modes: what a viewer deforms it by. Of each cell
    `wet` says whether it is under water.
    """
    rows = min(max(DISPLAY_ROWS, ROWS_PER_DEGREE * shell.basis.turns), MOST_DISPLAY_ROWS)
    at = shell.meridian(np.linspace(0.0, np.pi, rows + 1))
    points, faces = revolved(at.x, at.z, DISPLAY_ROWS)
    directions = revolved(np.ones(len(at.x)), np.zeros(len(at.x)), DISPLAY_ROWS)[0].astype(np.float32)
    across, up = (np.repeat(one, DISPLAY_ROWS, axis=1).astype(np.float32) for one in (at.shape_x, at.shape_z))
    moved = directions * across[..., None]
    moved[..., 2] = up
    modes = dict(zip(shell.basis.labels[1:], moved[1:], strict=True))
    wet = (points[faces, 2].mean(axis=1) < 0).astype(np.int8)
    mesh = meshio.Mesh(points, [("quad", faces)], point_data=modes, cell_data={"wet": [wet]})
    with atomic_write(path) as temporary:
        mesh.write(temporary, file_format=Path(path).suffix.removeprefix("."))
