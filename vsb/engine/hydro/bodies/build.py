"""The body a body file describes: displacements read from netCDF, or modes made here with their mass; plain hulls."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.linalg import block_diag

from vsb.engine.hydro.bodies.body import Beam, FlexibleBody, Triangles, bed_below, check_apart
from vsb.engine.hydro.bodies.body_file import BodyFile, BoxHull, CapsuleHull, CylinderHull, PlacedMesh, SphereHull
from vsb.engine.hydro.bodies.families import (
    Hull,
    LineMode,
    PlateMode,
    line_modes,
    plate_modes,
    plate_stiffness,
    structural_stiffness,
)
from vsb.engine.hydro.bodies.hydrostatics import columns_of
from vsb.engine.hydro.bodies.mesh import (
    AT_SURFACE,
    FLAT,
    SAME,
    Rigid,
    at_centres,
    at_vertices,
    check_vertices,
    divided,
    gaps,
    owners,
    repeated,
    text_of,
    turned_outward,
    wetted,
    without_area,
)
from vsb.engine.hydro.bodies.mesh_files import FOOT, MeshFile, length_unit, one_line, read_mesh
from vsb.engine.hydro.panels.bem import box_panels
from vsb.engine.hydro.panels.mesh import polygon_radius, revolved
from vsb.engine.hydro.variables import PAIR, RIGID, ROTATIONS
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray, IntArray
from vsb.tools.files import atomic_write

_ARC = 2000  # points of a quarter circle
_MOST = 200_000  # panels


# Plain hulls


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


# Files of displacements

_LARGEST = {
    "mode_shape": 1e6, "second_order": 1e6, "centre_of_mass": 1e6, "inertia_matrix": 1e30, "structural_stiffness": 1e30,
}  # fmt: skip
"""Bounds of displacements per unit amplitude [-], their second-order part [1/m], the centre of mass [m], mass and
stiffness [kg, N/m]."""
_MATRICES = {
    "mass": "inertia_matrix", "stiffness": "structural_stiffness", "centre_of_mass": "centre_of_mass",
    "second_order": "second_order",
}  # fmt: skip


def read_body(mesh: str | Path, modes: str | Path, water: Water | None = None) -> FlexibleBody:
    """Return a body from a mesh file and a netCDF file of its displacements, which floats in water if that is given.

    The latter holds `mode_shape` (dof, vertex or panel, xyz) with names on `dof`, and optionally `inertia_matrix` and
    `structural_stiffness` (influenced_dof, radiating_dof), `centre_of_mass` (xyz), or (part, xyz) where separate parts
    do not all turn alike, and `second_order` (influenced_dof, radiating_dof, vertex, xyz), the second derivatives
    d2x/dq_i dq_j of the corners' positions [1/m]. Panels above the water are cut off, those without area or given twice
    dropped, which the body's `history` records. Raises `ConfigError`: in one line, whatever is wrong with the files.
    """
    found = read_mesh(mesh)
    vertices, faces = found.vertices, found.faces
    labels, values, by_vertex, known = _displacements(modes, (len(vertices), len(faces)), mesh)
    if water and length_unit(mesh, water.gravity) != 1:
        raise ConfigError(
            f"{mesh}:2: GRAV: received feet; needs metres here, as the unit of the displacements is unknown"
        )
    try:
        kept, faces, notes = usable_panels(found)
        values = values if by_vertex else values[:, kept]
        bed = bed_below(vertices[np.unique(faces)], water.depth) if water else -np.inf
        if wet := wetted(vertices, faces, bed):
            second = known.get("second_order")
            known |= {} if second is None else {"second_order": wet.at_vertices(second)}
            values = wet.at_vertices(values) if by_vertex else wet.at_panels((vertices, faces), values)
            vertices, faces = wet.vertices, wet.faces
            notes.append(wet.history)
        matrices: dict[str, Any] = {field: known.get(name) for field, name in _MATRICES.items()}
        body = FlexibleBody(
            vertices,
            faces,
            labels,
            at_centres(vertices, faces, values) if by_vertex else values,
            values if by_vertex else at_vertices(vertices, faces, values),
            **matrices,
            history="; ".join(filter(None, notes)),
            bed=bed,
        )
        check_apart(body)
    except (ConfigError, IndexError) as error:
        raise ConfigError(f"{mesh}, {modes}: {error}") from None
    return with_gaps_noted(body)


def usable_panels(found: MeshFile) -> tuple[IntArray, IntArray, list[str]]:
    """Return which panels of a mesh file have an area and are given once, these with normals outward, and notes.

    Panels given again in the opposite direction stay where the surface is open without them: they are the two sides of
    a plate, or walls of two bodies that touch, which a body is checked for. Raises `ConfigError` if none has an area.
    """
    vertices, faces, notes = found.vertices, found.faces, list(found.notes)
    flat, again = without_area(vertices, faces), repeated(vertices, faces)
    if flat.all():
        far = found.vertices[np.argmax(np.abs(found.vertices).max(axis=1))]
        raise ConfigError(
            f"mesh: none of {len(faces)} panels has an area, seen from a corner at {text_of(far)}; correct it"
        )
    usable = np.flatnonzero(~(flat | again))
    if again.any() and _is_open(vertices, faces[usable]) and not _is_open(vertices, faces[~flat]):
        usable = np.flatnonzero(~flat)
    if dropped := found.stated - len(usable):
        notes.append(f"panels without area or given twice dropped: {dropped} of {found.stated}")
    outward = turned_outward(vertices, faces[usable])
    if turned := np.count_nonzero((outward != faces[usable]).any(axis=1)):
        notes.append(f"panels turned, as their normals pointed inward: {turned} of {len(usable)}")
    return usable, outward, notes


def _is_open(vertices: FloatArray, faces: IntArray) -> bool:
    """Whether panels leave the water a way in."""
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    found = gaps(vertices, owners(vertices)[faces], -AT_SURFACE * size)
    return bool(len(found.open) or len(found.turned))


def with_gaps_noted(body: FlexibleBody) -> FlexibleBody:
    """Return a body whose history notes gaps between its panels."""
    if (gap := body.gaps).width <= FLAT * body.size:
        return body
    note = (
        f"gaps between panels taken for closed: up to {gap.width:.2g} m wide at {text_of(gap.place)}, "
        f"{body.open_share:.1e} of the volume"
    )
    return replace(body, history="; ".join(filter(None, (body.history, note))))


def _displacements(
    modes: str | Path, counts: tuple[int, int], mesh: str | Path
) -> tuple[tuple[str, ...], FloatArray, bool, dict[str, FloatArray]]:
    """Labels, displacements, whether these are of vertices or else of panels, and the matrices of a file."""
    names = ("mode_shape", "dof", *_MATRICES.values())
    with one_line(modes, "netCDF", "mode_shape (dof, vertex, xyz) and dof"):
        with xr.open_dataset(modes, engine="netcdf4") as opened:
            found = [str(name)[:40] for name in opened.variables]
            ds = opened[[name for name in names if name in opened.variables]].load()
        if "mode_shape" not in ds or "dof" not in ds.coords:
            raise ConfigError(f"{modes}: holds {found[:20]}; needs mode_shape (dof, vertex, xyz) and dof")
        arrays = {name: np.array(ds[name].values, dtype=float) for name in names if name in ds.data_vars}
        labels, dims, sizes = tuple(map(str, ds.dof.values)), ds.mode_shape.dims, dict(ds.mode_shape.sizes)
    for name, array in arrays.items():
        if np.isfinite(array).all() and (largest := np.abs(array).max(initial=0.0)) > _LARGEST[name]:
            raise ConfigError(f"{modes}: {name} reaches {largest:.3g}; needs at most {_LARGEST[name]:g}")
    values, (vertices, panels) = arrays.pop("mode_shape"), counts
    expected: dict[tuple[Any, ...], int] = {("dof", "vertex", "xyz"): vertices, ("dof", "panel", "xyz"): panels}
    if expected.get(dims) != values.shape[1] or values.shape[2] != 3:
        raise ConfigError(
            f"{modes}: mode_shape {sizes}; needs (dof, vertex, xyz) or (dof, panel, xyz) with {vertices} vertices or "
            f"{panels} panels, as {mesh} has"
        )
    return labels, values, dims[1] == "vertex", arrays


def write_body(body: FlexibleBody, path: str | Path) -> None:
    """Write a body as one netCDF file that serves `read_body` both as the mesh and as the modes."""
    data: dict[str, Any] = {
        "vertices": (("vertex", "xyz"), body.vertices),
        "faces": (("panel", "corner"), body.faces),
        "mode_shape": (("dof", "vertex", "xyz"), body.shapes),
    }
    if (centre := body.centre_of_mass) is not None:
        data["centre_of_mass"] = (("part", "xyz")[2 - np.ndim(centre) :], centre)
    for field, name in _MATRICES.items():
        if name not in data and getattr(body, field) is not None:
            data[name] = ((*PAIR, "vertex", "xyz") if field == "second_order" else PAIR, getattr(body, field))
    with atomic_write(path) as temporary:
        xr.Dataset(data, coords={"dof": list(body.labels)}).to_netcdf(temporary, engine="netcdf4")


# Bodies of a mesh and named modes

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
        points = vertices[np.unique(faces)]
        (length, width, _), height = np.ptp(points, axis=0), np.round(points[:, 2], 3) + 0.0  # no negative zero
        notes.append(
            f"hull {length:.3g} m along x, {width:.3g} m along y, from {height.min():.4g} to {height.max():.4g} m "
            "above still water"
        )
        return _made_body(file, vertices, faces, notes)
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
