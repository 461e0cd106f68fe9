"""The body a body file describes: its displacements read from a file, or modes made here with their mass."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from vsb.engine.hydro.bodies.body import FlexibleBody, Triangles, bed_below, check_apart
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.families import Hull, LineMode, line_modes, structural_stiffness
from vsb.engine.hydro.bodies.files import read_body, usable_panels, with_gaps_noted
from vsb.engine.hydro.bodies.hulls import hull_panels
from vsb.engine.hydro.bodies.hydrostatics import columns_of
from vsb.engine.hydro.bodies.mesh import (
    AT_SURFACE,
    SAME,
    Rigid,
    at_centres,
    check_vertices,
    divided,
    gaps,
    owners,
    wetted,
)
from vsb.engine.hydro.bodies.mesh_files import FOOT, length_unit, read_mesh
from vsb.engine.hydro.bodies.plain_hulls import PlacedMesh, SphereHull
from vsb.engine.hydro.bodies.plates import PlateMode, plate_modes, plate_stiffness
from vsb.engine.hydro.bodies.sections import Beam
from vsb.engine.hydro.labels import RIGID, ROTATIONS
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray, IntArray

_WHOLE = "it, or a mesh closed above the water, deck included"
_ALONG_THE_BED = ("Surge", "Sway", "Yaw")


class Solid(NamedTuple):
    """A closed mesh filled evenly."""

    volume: float  # [m^3]
    centre: FloatArray  # (xyz) [m]
    moments: FloatArray  # (xyz, xyz): int r r^T dV/V about the centre [m^2]


def build_body(file: BodyFile, paths: Mapping[str, str | Path]) -> FlexibleBody:
    """Return the body of a body file, its files found at `paths`, by key.

    Panels above the water are cut off, those without area or given twice dropped: the body's `history` records it.
    Raises `ConfigError`: in one line, whatever is wrong with the files, or missing of the dry body.
    """
    if file.rigid_motions is None:
        return read_body(paths["mesh"], paths["modes"], file.water)
    if file.hull:
        return _made_body(file, *hull_panels(file.hull), [])
    mesh = paths["mesh"]
    found = read_mesh(mesh)
    in_feet = file.metres == 1 and length_unit(mesh, file.water.gravity) != 1
    unit = FOOT if in_feet else file.metres
    try:
        _, faces, notes = usable_panels(found)
        if unit != 1:
            notes.append(f"{'GRAV is in feet: ' * in_feet}lengths of the mesh multiplied by {unit:g}")
        vertices = _placed(unit * found.vertices, faces, file.mesh)
        return _made_body(file, vertices, faces, [*notes, _extent(vertices[np.unique(faces)])])
    except ConfigError as error:
        raise ConfigError(f"{mesh}: {error}") from None


_UPRIGHT = {
    "x": [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
    "y": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
    "z": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "-x": [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
    "-y": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
    "-z": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
}
"""The rotation that sets a hull upright, by the axis of its file that points upwards."""


TALLEST = 100.0
"""Height of a hull over its draft from which its file is rather in another unit."""


def _placed(vertices: FloatArray, faces: IntArray, mesh: object) -> FloatArray:
    """The corners of a hull [m] turned upright and moved to its draft."""
    if not isinstance(mesh, PlacedMesh):
        return vertices
    upright: FloatArray = vertices @ np.array(_UPRIGHT[mesh.up], dtype=float).T
    if mesh.draft is not None:
        height = float(np.ptp(upright[np.unique(faces), 2]))
        if height > TALLEST * mesh.draft and mesh.metres == 1:
            raise ConfigError(
                f"mesh: received a hull {height:.4g} m high with a draft of {mesh.draft:g} m; needs metres, or the "
                "unit of its file, such as unit: mm"
            )
        upright[:, 2] -= upright[np.unique(faces), 2].min() + mesh.draft
    return upright


def _extent(points: FloatArray) -> str:
    """How large a hull is and how deep it lies."""
    (length, width, _), height = np.ptp(points, axis=0), np.round(points[:, 2], 3) + 0.0  # no negative zero
    low, high = height.min(), height.max()
    return f"hull {length:.3g} m along x, {width:.3g} m along y, from {low:.4g} to {high:.4g} m above still water"


def _made_body(file: BodyFile, vertices: FloatArray, faces: IntArray, notes: list[str]) -> FlexibleBody:
    """The body of a mesh in the rigid motions and the families of modes of a body file."""
    labels = list(file.rigid_motions or ())
    check_vertices(vertices)
    bed = bed_below(vertices[np.unique(faces)], file.water.depth)
    if np.isfinite(bed) and file.families:
        raise ConfigError(
            "modes: received families of modes, which lift the foot of a hull that stands on the sea bed; needs Surge, "
            "Sway, Yaw, or a file of displacements whose foot keeps its height"
        )
    if np.isfinite(bed) and file.all_rigid:
        labels = list(_ALONG_THE_BED)
        notes = [*notes, "Heave, Roll and Pitch left out: the hull stands on the sea bed"]
    rotates, weighed = bool(set(ROTATIONS) & set(labels)), file.mass is not None or file.density is not None
    centre = None if file.centre_of_mass is None else np.array(file.centre_of_mass)
    solid = filled(vertices, faces)
    if solid is None and (needed := _missing(file, rotates)):
        raise ConfigError(f"{needed}: received none, and the mesh is not closed above the water; needs {_WHOLE}")
    if centre is None and solid:
        centre = solid.centre
        notes = [*notes, "centre of mass that of the mesh filled evenly"]
    pivot = centre if file.rotation_point is None else np.array(file.rotation_point)
    wet = wetted(vertices, faces, bed)
    points, panels = (wet.vertices, wet.faces) if wet else (vertices, faces)
    if file.panel is not None:
        points, panels = divided(points, panels, file.panel)
        notes = [*notes, f"panels divided to edges of at most {file.panel:g} m"]
    if file.all_rigid and _still(points, panels, _motion("Yaw", pivot)):
        labels.remove("Yaw")
        notes = [*notes, "Yaw left out: it moves no water"]
    if file.all_rigid and _turns_about_its_centre(file.hull, pivot):
        labels = [label for label in labels if label not in ROTATIONS]
        notes = [*notes, "Roll and Pitch left out: about its own centre a sphere moves no water"]
    motions: list[Rigid | LineMode | PlateMode] = [_motion(label, pivot) for label in labels]
    stiffness, beams = None, dict[int, Beam]()
    if file.families:
        hull = _hull(vertices[np.unique(faces)], points, panels, centre)
        lines, plates = line_modes(file.families, hull), plate_modes(file.families.plate, hull.low, hull.high)
        elastic = [structural_stiffness(file.families, hull, lines), plate_stiffness(file.families.plate, plates)]
        stiffness = block_diag(np.zeros((len(labels), len(labels))), *elastic)
        beams = {i: Beam(line.axis, line) for i, line in enumerate(lines, len(labels)) if line.smooth}
        labels = [*labels, *(line.label for line in lines), *(plate.label for plate in plates)]
        motions = [*motions, *lines, *plates]
    shapes = np.array([motion.at(points) for motion in motions])
    history = "; ".join(filter(None, [*notes, wet.history if wet else ""]))
    modes = at_centres(points, panels, shapes)
    body = FlexibleBody(
        points,
        panels,
        tuple(labels),
        modes,
        shapes,
        stiffness=stiffness if stiffness is not None and stiffness.any() else None,
        centre_of_mass=centre,
        history=history,
        bed=bed,
        beams=beams,
    )
    check_apart(body)
    if weighed:
        rigid = [motion for motion in motions if isinstance(motion, Rigid)]
        mass, block = _mass_matrix(file, body, solid, rigid)
        if file.families:
            moved = np.array([motion.at(hull.masses_at) for motion in motions])
            whole = mass * np.einsum("ipx,jpx,p->ij", moved, moved, hull.shares, optimize=True)
            whole[: len(rigid), : len(rigid)] = block
            block = whole
        body = replace(body, mass=block)
    return with_gaps_noted(body)


def _hull(vertices: FloatArray, points: FloatArray, panels: IntArray, centre: FloatArray | None) -> Hull:
    """The extent of a hull, deck included, and where the water is that its wetted panels displace."""
    halves = np.concatenate([panels[:, [0, 1, 2]], panels[:, [0, 2, 3]]])
    corner = points[halves]
    area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2
    columns = columns_of(Triangles(corner, area, np.zeros((0, *corner.shape))))
    volume = columns.volume.sum(axis=-1).ravel()
    at = columns.points.reshape(-1, 3)
    return Hull(vertices.min(axis=0), vertices.max(axis=0), centre, at, volume / volume.sum())


def _turns_about_its_centre(mesh: object, centre: FloatArray | None) -> bool:
    """Whether rotations are those of a sphere about its own centre, which its panels only nearly leave at rest."""
    if not isinstance(mesh, SphereHull) or centre is None:
        return False
    own = np.array([0.0, 0.0, mesh.radius - mesh.draft])
    return bool(np.abs(centre - own).max() <= 1e-3 * mesh.radius)


def _still(vertices: FloatArray, faces: IntArray, motion: Rigid) -> bool:
    """Whether a motion moves no water, on panels of single precision as well."""
    centres = at_centres(vertices, faces, vertices[None])[0]
    corner = vertices[faces]
    area = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]) / 2
    moved = motion.at(centres)
    flux = np.abs(np.einsum("px,px->p", moved, area))
    return bool(flux.max() <= AT_SURFACE * np.linalg.norm(area, axis=1).max() * np.abs(moved).max())


def _missing(file: BodyFile, rotates: bool) -> str | None:
    """The first key that only a closed mesh can stand for."""
    if file.density is not None:
        return "mass"
    if file.families and file.centre_of_mass is None:
        return "centre_of_mass"
    if not rotates or file.mass is None:
        return None
    return next((key for key in ("centre_of_mass", "radii_of_gyration") if getattr(file, key) is None), None)


def _mass_matrix(
    file: BodyFile, body: FlexibleBody, solid: Solid | None, motions: Sequence[Rigid]
) -> tuple[float, FloatArray]:
    """Mass [kg] and matrix of rigid motions, shape (dof, dof): m v_i.v_j + a_i.I a_j, v_i at the centre of mass."""
    if file.density is not None and solid:
        mass = file.density * solid.volume
    else:
        mass = file.water.density * body.volume if file.mass == "displaced" else float(file.mass or 0)
    if file.radii_of_gyration is not None:
        inertia = np.diag(np.square(file.radii_of_gyration))
    else:
        inertia = np.trace(solid.moments) * np.eye(3) - solid.moments if solid else np.zeros((3, 3))
    centre = np.zeros(3) if body.centre_of_mass is None else body.centre_of_mass
    moved = np.array([motion.at(centre) for motion in motions]).reshape(-1, 3)
    turned = np.array([motion.rotation for motion in motions]).reshape(-1, 3)
    return mass, np.asarray(mass * (moved @ moved.T + turned @ inertia @ turned.T))


def filled(vertices: FloatArray, faces: IntArray) -> Solid | None:
    """Return the solid inside the panels of a mesh, filled evenly; None if they do not close it, deck included."""
    found = gaps(vertices, owners(vertices)[faces], np.inf)
    if len(found.open) or len(found.turned):
        return None
    origin = vertices[np.unique(faces)].mean(axis=0)
    corner = vertices[np.concatenate([faces[:, [0, 1, 2]], faces[:, [0, 2, 3]]])] - origin
    part = np.einsum("tx,tx->t", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])) / 6
    volume = float(part.sum())
    if volume <= 0:
        return None
    total = corner.sum(axis=1)
    centre = part @ total / 4 / volume
    second = (np.einsum("t,tx,ty->xy", part, total, total) + np.einsum("t,tkx,tky->xy", part, corner, corner)) / 20
    moments = second / volume - np.outer(centre, centre)
    size = float(np.linalg.norm(np.ptp(corner.reshape(-1, 3), axis=0)))
    place = origin + centre
    return Solid(
        volume,
        np.where(np.abs(place) < SAME * size, 0.0, place),
        np.where(np.abs(moments) < SAME * size**2, 0.0, moments),
    )


def _motion(label: str, centre: FloatArray | None) -> Rigid:
    """A unit rigid motion by its name, rotations about a point, or about the origin without one."""
    axis, k = np.eye(3)[RIGID.index(label) % 3], RIGID.index(label)
    if k < 3:
        return Rigid(axis, np.zeros(3))
    return Rigid(np.zeros(3) if centre is None else -np.cross(axis, centre), axis)
