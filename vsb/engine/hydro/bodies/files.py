"""Files of bodies: a mesh with displacements in netCDF."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from vsb.engine.hydro.bodies.body import FlexibleBody, bed_below, check_apart
from vsb.engine.hydro.bodies.mesh import (
    AT_SURFACE,
    FLAT,
    at_centres,
    at_vertices,
    gaps,
    owners,
    repeated,
    text_of,
    turned_outward,
    wetted,
    without_area,
)
from vsb.engine.hydro.bodies.mesh_files import MeshFile, length_unit, one_line, read_mesh
from vsb.engine.hydro.variables import PAIR
from vsb.engine.waves.water import Water
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray, IntArray
from vsb.tools.files import atomic_write

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
