"""Files of bodies: meshes of any program, displacements in netCDF.

Files may be cut, damaged or of another kind: whatever error a library raises becomes one line.
"""

import contextlib
import io
import re
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import meshio
import numpy as np
import xarray as xr

from vsb.errors import ConfigError
from vsb.hydro.bodies.body import FlexibleBody, check_apart
from vsb.hydro.bodies.mesh import (
    FLAT,
    at_centres,
    at_vertices,
    check_vertices,
    repeated,
    text_of,
    wetted,
    without_area,
)
from vsb.hydro.panels import rings as bem
from vsb.hydro.variables import PAIR
from vsb.tools.arrays import FloatArray, IntArray
from vsb.tools.bounded import bounded_reading
from vsb.tools.files import atomic_write

PANEL_FILES = {
    ".gdf": "gdf", ".pnl": "pnl", ".hst": "hst", ".mar": "mar", ".nemoh": "mar", ".hams": "pnl",
}  # fmt: skip
"""Formats capytaine reads and meshio does not; meshio keeps the order of the vertices, which displacements refer to."""
_LARGEST = {
    "mode_shape": 1e6, "second_order": 1e6, "centre_of_mass": 1e6, "inertia_matrix": 1e30, "structural_stiffness": 1e30,
}  # fmt: skip
"""Bounds of displacements per unit amplitude [-], their second-order part [1/m], the centre of mass [m], mass and
stiffness [kg, N/m]."""
_HEADER = 4  # lines of a GDF: title, ULEN GRAV, ISX ISY, NPAN
FOOT = 0.3048
"""A foot [m]."""
_MATRICES = {
    "mass": "inertia_matrix", "stiffness": "structural_stiffness", "centre_of_mass": "centre_of_mass",
    "second_order": "second_order",
}  # fmt: skip


@contextlib.contextmanager
def _one_line(path: str | Path, what: str, needed: str) -> Iterator[None]:
    """Turn whatever error a library raises for a file into one line."""
    try:
        ignored = io.StringIO()  # meshio prints what it raises
        with warnings.catch_warnings(), contextlib.redirect_stderr(ignored), contextlib.redirect_stdout(ignored):
            warnings.simplefilter("ignore")
            with bounded_reading(path):
                yield
    except ConfigError:
        raise
    except ModuleNotFoundError as error:
        raise ConfigError(
            f"{path}: the Python package {error.name}, which reads such files, is missing; needs it, or another format"
        ) from None
    except MemoryError:
        raise ConfigError(
            f"{path}: cannot be read as {what} (it announces more than it holds); needs {needed}"
        ) from None
    except (Exception, SystemExit) as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise ConfigError(f"{path}: cannot be read as {what} ({reason}); needs {needed}") from None


def read_mesh(path: str | Path) -> tuple[FloatArray, IntArray]:
    """Return vertices (vertex, xyz) [m] and panels (panel, 4) of a mesh file.

    Quadrilaterals and triangles of any format meshio reads, in the order of the file; WAMIT, NEMOH, Hydrostar and HAMS
    panels; or netCDF with `vertices` (vertex, xyz) and `faces` (panel, corner). Extensions may be capitals. Raises
    `ConfigError`: in one line, whatever is wrong with the file.
    """
    if not Path(path).is_file():
        raise ConfigError(f"{path}: mesh not found; needs the path of a mesh file, from the folder of the body file")
    with _one_line(path, "a mesh", "a format of meshio or netCDF"):
        vertices, faces = _panels(Path(path))
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] not in (3, 4):
        raise ConfigError(
            f"{path}: vertices {vertices.shape} and faces {faces.shape}; needs (vertex, xyz) and (panel, corner), 3 "
            "or 4 corners"
        )
    if not len(faces):
        raise ConfigError(f"{path}: holds no panel; needs quadrilaterals or triangles")
    if (wrong := np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=-1))).size:
        corners, last = faces[wrong[0]].tolist(), len(vertices) - 1
        raise ConfigError(f"{path}: panel {wrong[0]} has corners {corners}; needs numbers from 0 to {last}")
    try:
        check_vertices(vertices)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None
    return vertices, np.column_stack([faces, faces[:, 2]]) if faces.shape[1] == 3 else faces


def _panels(path: Path) -> tuple[FloatArray, IntArray]:
    """Vertices and panels of a file."""
    suffix = path.suffix.lower()
    if suffix == ".nc":
        with xr.open_dataset(path, engine="netcdf4") as ds:
            faces = np.asarray(ds.faces.values)
            if not np.array_equal(faces, whole_numbers := faces.astype(int)):
                raise ValueError("corners of panels that are no whole numbers")
            return np.array(ds.vertices.values, dtype=float), whole_numbers
    if suffix == ".gdf":
        return bem.read_panels(io.StringIO(read_gdf(path).panels), "gdf")
    if form := _capytaine_format(path):
        return bem.read_panels(path, form)
    with np.errstate(all="ignore"):  # the first bytes of an STL in plain text are taken for a huge count
        mesh = meshio.read(path)
    cells = [block.data for block in mesh.cells if block.type in ("quad", "triangle")]
    if not cells:
        raise ConfigError(f"{path}: holds {[b.type for b in mesh.cells]}; needs quadrilaterals or triangles")
    panels = [np.column_stack([c, c[:, 2]]) if c.shape[1] == 3 else c for c in cells]
    points = np.asarray(mesh.points, dtype=float)
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1]))), np.concatenate(panels).astype(int)


def _capytaine_format(path: Path) -> str | None:
    """Name of the format of a file that capytaine reads, None for other formats."""
    suffix = path.suffix.lower()
    return "mar" if suffix == ".dat" and _is_nemoh(path) else PANEL_FILES.get(suffix)


def _is_nemoh(path: Path) -> bool:
    """Whether a .dat is NEMOH's, which begins with 2 and 0 or 1, or Tecplot's, which begins with words."""
    with path.open(encoding="utf-8", errors="replace") as file:
        words = file.readline(200).split()
    if words and all(word.isdigit() for word in words) and (words[0] != "2" or words[1:2] not in ([], ["0"], ["1"])):
        raise ConfigError(
            f"{path}:1: received {' '.join(words)!r}, as SALOME's .dat begins; needs NEMOH's '2 0' or '2 1', "
            "Tecplot's, or another format: write a .stl"
        )
    return all(word.isdigit() for word in words)


class Gdf(NamedTuple):
    """WAMIT's file of panels: a header, NPAN panels of twelve numbers, and perhaps more lines."""

    panels: str  # header and NPAN panels, as capytaine reads them
    gravity: float  # GRAV, in the length unit of the panels per s^2
    ignored: int  # lines behind the panels

    @property
    def note(self) -> str:
        """Return a note on the lines ignored."""
        return f"{self.ignored} lines behind the panels of the GDF ignored" if self.ignored else ""


def read_gdf(path: Path) -> Gdf:
    """Return the contents of a file of panels; ValueError if it is none."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    wanted, last = 12 * int(lines[_HEADER - 1].split()[0]), _HEADER
    numbers: list[str] = []
    while len(numbers) < wanted and last < len(lines):
        numbers += lines[last].split()
        last += 1
    if len(numbers) < wanted:
        raise ValueError(f"NPAN is {wanted // 12}, but {len(numbers) // 12} panels follow")
    rows = [" ".join(numbers[k : k + 3]) for k in range(0, wanted, 3)]
    ignored = sum(bool(line.strip()) for line in lines[last:])
    return Gdf("\n".join([*lines[:_HEADER], *rows]), float(lines[1].split()[1]), ignored)


def length_unit(mesh: str | Path, gravity: float) -> float:
    """Return the unit of length of a mesh [m]: that of a GDF whose GRAV is in feet/s^2 is 0.3048, all others are 1.

    Raises `ConfigError` if GRAV is that of water of a gravity [m/s^2] in neither unit.
    """
    path = Path(mesh)
    if path.suffix.lower() != ".gdf":
        return 1.0
    found = read_gdf(path).gravity
    for unit in (1.0, FOOT):
        if abs(found * unit / gravity - 1) <= 0.01:
            return unit
    raise ConfigError(
        f"{path}:2: GRAV: received {found:g}; needs water.gravity, {gravity:g} m/s^2, or that in feet: convert the "
        "mesh to metres"
    )


def read_body(mesh: str | Path, modes: str | Path, gravity: float | None = None) -> FlexibleBody:
    """Return a body from a mesh file and a netCDF file of its displacements, in water of a gravity [m/s^2] if given.

    The latter holds `mode_shape` (dof, vertex or panel, xyz) with names on `dof`, and optionally `inertia_matrix` and
    `structural_stiffness` (influenced_dof, radiating_dof), `centre_of_mass` (xyz), or (part, xyz) where separate parts
    do not all turn alike, and `second_order` (influenced_dof, radiating_dof, vertex, xyz), the second derivatives
    d2x/dq_i dq_j of the corners' positions [1/m]. Panels above the water are cut off, those without area or given twice
    dropped, which the body's `history` records. Raises `ConfigError`: in one line, whatever is wrong with the files.
    """
    vertices, faces = read_mesh(mesh)
    labels, values, by_vertex, known = _displacements(modes, (len(vertices), len(faces)), mesh)
    if gravity and length_unit(mesh, gravity) != 1:
        raise ConfigError(
            f"{mesh}:2: GRAV: received feet; needs metres here, as the unit of the displacements is unknown"
        )
    kept, notes = usable_panels(mesh, vertices, faces)
    faces, values = faces[kept], values if by_vertex else values[:, kept]
    try:
        if wet := wetted(vertices, faces):
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
        )
        check_apart(body)
    except (ConfigError, IndexError) as error:
        raise ConfigError(f"{mesh}, {modes}: {error}") from None
    return with_gaps_noted(body)


def usable_panels(mesh: str | Path, vertices: FloatArray, faces: IntArray) -> tuple[IntArray, list[str]]:
    """Return the panels of a mesh file with an area and given once, shape (panel,), and notes on all others."""
    path, notes = Path(mesh), list[str]()
    usable = np.flatnonzero(~(without_area(vertices, faces) | repeated(vertices, faces)))
    if path.suffix.lower() == ".gdf":
        notes.append(read_gdf(path).note)
    with _one_line(path, "a mesh", "a format of meshio or netCDF"):
        stated = _stated_panels(path) or len(faces)
    if dropped := stated - len(usable):
        notes.append(f"panels without area or given twice dropped: {dropped} of {stated}")
    return usable, notes


def _stated_panels(path: Path) -> int:
    """Number of panels in a file that capytaine reads, with their images: it drops some; 0 for other formats."""
    if (form := _capytaine_format(path)) is None:
        return 0
    text = path.read_text(encoding="utf-8", errors="replace")
    lines = text.splitlines()
    if form == "gdf":
        count, mirrors = int(lines[_HEADER - 1].split()[0]), sum(int(flag) == 1 for flag in lines[2].split()[:2])
    elif form == "pnl":
        count, _, *flags = map(int, lines[3].split())
        mirrors = sum(flags)
    elif form == "mar":
        begin, end = [i for i, line in enumerate(lines) if line.split()[:1] == ["0"]][:2]
        count, mirrors = end - begin - 1, int(lines[0].split()[1:2] == ["1"])
    else:
        blocks = re.findall(r"^\s*PANEL.*?\n(.*?)^\s*ENDPANEL", text, re.MULTILINE | re.DOTALL)
        count = sum(bool(line.strip()) for block in blocks for line in block.splitlines())
        symmetry = re.search(r"^\s*SYMMETRY.?:*\s*([12])\s*$", text, re.MULTILINE)
        mirrors = int(symmetry[1]) if symmetry else 0
    return int(count * 2**mirrors)


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
    with _one_line(modes, "netCDF", "mode_shape (dof, vertex, xyz) and dof"):
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
