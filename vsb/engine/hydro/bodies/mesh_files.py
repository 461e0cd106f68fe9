"""Mesh files of any program: panels of a hull, with a note on every other cell a file holds.

Surface cells become panels: polygons are cut into triangles, cells of higher order lose the corners along their sides.
Lines, points and the inside of a volume bound no water and are left out. What cannot be accounted for is refused, in
one line, whatever error a library raises for a damaged file.
"""

import contextlib
import io
import re
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import meshio
import netCDF4
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from vsb.engine.hydro.bodies.mesh import check_finite, text_of, triangulated
from vsb.engine.hydro.panels.bem import read_panels
from vsb.errors import ConfigError
from vsb.tools.arrays import FloatArray, IntArray
from vsb.tools.files import bounded_reading, reason_of
from vsb.tools.units import parsed_unit

PANEL_FILES = {".pnl": "pnl", ".hst": "hst", ".mar": "mar", ".nemoh": "mar", ".hams": "pnl"}
"""Formats capytaine reads and meshio does not; meshio keeps the order of the vertices, which displacements refer to."""
FOOT = float(parsed_unit("ft").factor)
"""A foot [m]."""
_CAD = (".step", ".stp", ".iges", ".igs", ".brep", ".dxf", ".dwg", ".3dm", ".sat", ".x_t", ".sldprt", ".fcstd")
_LINES = ("vertex", "line", "empty", "VTK_LAGRANGE_CURVE", "VTK_BEZIER_CURVE")
_VOLUMES = ("tetra", "hexahedron", "wedge", "pyramid", "penta_prism", "hexa_prism", "polyhedron", "VTK_")
_HEADER = 4  # lines of a GDF: title, ULEN GRAV, ISX ISY, NPAN
_NEEDED = "a whole STL, OBJ, PLY, VTK, GMSH, MED, Nastran, GDF or netCDF, for example"


class MeshFile(NamedTuple):
    """What a mesh file holds of a hull."""

    vertices: FloatArray  # (vertex, xyz) [m]
    faces: IntArray  # (panel, 4); triangles repeat their last corner
    stated: int  # panels of the file, with their mirror images: a reader may have dropped some
    notes: tuple[str, ...] = ()  # on what was changed and left out


class _Cells(NamedTuple):
    """Cells of one kind, in meshio's words, and their corners, shape (cell, corner)."""

    kind: str
    corners: IntArray


@contextlib.contextmanager
def one_line(path: str | Path, what: str, needed: str) -> Iterator[io.StringIO]:
    """Turn whatever error a library raises for a file into one line of our own; yield what it prints."""
    try:
        printed = io.StringIO()
        with warnings.catch_warnings(), contextlib.redirect_stderr(printed), contextlib.redirect_stdout(printed):
            warnings.simplefilter("ignore")
            with bounded_reading(path):
                yield printed
    except ConfigError:
        raise
    except ModuleNotFoundError as error:
        raise ConfigError(
            f"{path}: the Python package {error.name}, which reads such files, is missing; needs it, or another format"
        ) from None
    except (Exception, SystemExit) as error:
        raise ConfigError(f"{path}: cannot be read as {what} ({reason_of(error)}); needs {needed}") from None


def read_mesh(path: str | Path) -> MeshFile:
    """Return the panels of a mesh file.

    Surface cells of any format meshio reads, in the order of the file, OBJ and VTK's POLYDATA (.vtk, .vtp) among them;
    WAMIT, NEMOH, Hydrostar and HAMS panels; or netCDF with `vertices` (vertex, xyz) and `faces` (panel, corner).
    Extensions may be capitals. Raises `ConfigError`: in one line, whatever is wrong with the file.
    """
    place = Path(path)
    if not place.is_file():
        raise ConfigError(f"{path}: mesh not found; needs the path of a mesh file, from the folder of the body file")
    if place.suffix.lower() in _CAD:
        raise ConfigError(f"{path}: is a CAD model; needs a mesh of its surface: export it as STL")
    with one_line(path, "a mesh", _NEEDED) as printed:
        found = _read(place, printed)
    vertices, faces = found.vertices, found.faces
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
        check_finite(vertices)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None
    return found._replace(faces=np.column_stack([faces, faces[:, 2]]) if faces.shape[1] == 3 else faces)


def _read(path: Path, printed: io.StringIO) -> MeshFile:
    """Panels of a file that is there; corners may still have wrong numbers."""
    suffix = path.suffix.lower()
    if suffix == ".nc":
        return _netcdf(path)
    if suffix == ".gdf":
        return _gdf(path)
    if form := "mar" if suffix == ".dat" and _is_nemoh(path) else PANEL_FILES.get(suffix):
        vertices, faces = read_panels(path, form)
        return MeshFile(vertices, faces, _stated_panels(path, form))
    own = {".obj": _obj, ".off": _off}
    if suffix in own:
        return _surface(path, *own[suffix](path))
    if suffix not in (".vtp", *meshio.extension_to_filetypes):
        raise ConfigError(
            f"{path}: received a name that ends in {suffix or 'nothing'}, no kind of mesh; needs {_NEEDED}"
        )
    points, cells = _by_meshio(path)
    if re.search("skip|cannot handle|ignor|could not parse", text := printed.getvalue().lower()):
        kind = re.search(r"type (\d+)", text)
        raise ConfigError(
            f"{path}: holds cells{f' of the kind {kind[1]}' if kind else ''} that are not understood; needs triangles, "
            "quadrilaterals or polygons: convert it"
        )
    return _surface(path, points, cells)


# Cells of all kinds


def _surface(path: Path, points: FloatArray, cells: Sequence[_Cells]) -> MeshFile:
    """The panels among cells, in their order, and notes on all others."""
    panels, straightened, cut, beside = list[IntArray](), Counter[str](), 0, 0.0
    lines, volumes = Counter[str](), Counter[str]()
    for kind, corners in cells:
        if not corners.size:
            continue
        if kind.startswith(_LINES):
            lines[kind] += len(corners)
        elif kind == "polygon":
            for corner in corners:
                panels.append(_polygon(path, points, corner))
                cut += len(corner) > 4
        elif sides := _sides(kind):
            order = [0, 1, 3, 2] if kind == "pixel" else list(range(sides))
            flat = corners[:, order]
            panels.append(flat if sides == 4 else flat[:, [0, 1, 2, 2]])
            if (more := corners.shape[1] - sides) > 0:
                straightened[kind] += len(corners)
                beside = max(beside, _off_the_sides(points, corners, sides)) if more >= sides else beside
        elif kind.startswith(_VOLUMES):
            volumes[kind] += len(corners)
        else:
            raise ConfigError(f"{path}: holds cells {kind}; needs triangles, quadrilaterals or polygons: convert it")
    if not panels:
        held = _counted(lines + volumes) or "no cell"
        raise ConfigError(f"{path}: holds {held}; needs the triangles or quadrilaterals of its surface")
    faces = np.concatenate(panels).astype(int)
    if volumes:
        _check_surrounded(path, points, faces, [cell.corners for cell in cells if cell.kind in volumes])
    notes = []
    if cut:
        notes.append(f"polygons cut into triangles: {cut}")
    if straightened:
        off = f", which were up to {beside:.2g} of the file's lengths off the corners along them" if beside else ""
        notes.append(f"sides made straight{off}: {_counted(straightened)}")
    if volumes:
        notes.append(f"left out, inside the surface: {_counted(volumes)}")
    if lines:
        notes.append(f"left out, no surface: {_counted(lines)}")
    return MeshFile(points, faces, len(faces), tuple(notes))


def _counted(kinds: Counter[str]) -> str:
    """How many cells of each kind there are, as text."""
    return ", ".join(f"{count} {kind}" for kind, count in kinds.items())


def _sides(kind: str) -> int:
    """Sides of a surface cell of whatever order, by meshio's name; 0 of other cells."""
    name = kind.lower()
    if re.fullmatch(r"(vtk_\w+_)?triangle\d*", name):
        return 3
    return 4 if name == "pixel" or re.fullmatch(r"(vtk_\w+_)?quad(rilateral)?\d*", name) else 0


def _off_the_sides(points: FloatArray, corners: IntArray, sides: int) -> float:
    """Largest distance of the corners on the sides of cells of second order from the middles of straight ones [m]."""
    if corners.max() >= len(points) or corners.min() < 0:
        return 0.0  # which is refused later
    ends, middle = points[corners[:, :sides]], points[corners[:, sides : 2 * sides]]
    return float(np.linalg.norm(middle - (ends + np.roll(ends, -1, axis=1)) / 2, axis=-1).max())


def _check_surrounded(path: Path, points: FloatArray, faces: IntArray, volumes: Sequence[IntArray]) -> None:
    """Refuse volume cells that are connected to no panel: a body without its surface."""
    pairs = [np.column_stack([c[:, :1].repeat(c.shape[1], axis=1).ravel(), c.ravel()]) for c in (faces, *volumes)]
    start, end = np.concatenate(pairs).T
    graph = coo_matrix((np.ones(len(start)), (start, end)), shape=(len(points),) * 2)
    part = connected_components(graph, directed=False)[1]
    lonely = [c[~np.isin(part[c[:, 0]], part[faces])] for c in volumes]
    if count := sum(map(len, lonely)):
        place = next(points[c[0, 0]] for c in lonely if len(c))
        raise ConfigError(
            f"{path}: {count} cells of a volume, the first at {text_of(place)}, have no surface cells around them; "
            "needs the surface of every body: export it, too"
        )


def _polygon(path: Path, points: FloatArray, corners: IntArray) -> IntArray:
    """A polygon as panels: one of three or four corners as it is, others cut into triangles."""
    own = [int(corner) for corner in corners]
    if wrong := [corner for corner in own if not 0 <= corner < len(points)]:
        return np.full((1, 4), wrong[0])  # which is refused later
    if len(own) > 4:
        before = np.roll(points[own], 1, axis=0)
        own = [corner for corner, last in zip(own, before, strict=True) if (points[corner] != last).any()] or own[:1]
    if len(own) <= 4:
        return np.array([[*own, *own[-1:] * 3][:4]])
    if (triangles := triangulated(points[own])) is None:
        raise ConfigError(f"{path}: a polygon at {text_of(points[own[0]])} crosses itself; needs simple polygons")
    return np.array(own)[triangles[:, [0, 1, 2, 2]]]


# Formats


def _netcdf(path: Path) -> MeshFile:
    """Panels of a netCDF file."""
    with netCDF4.Dataset(path) as file:
        if missing := [name for name in ("vertices", "faces") if name not in file.variables]:
            raise ConfigError(f"{path}: holds no {' and no '.join(missing)}; needs vertices and faces of a mesh")
        vertices, faces = (np.ma.filled(file[name][...].astype(float), np.nan) for name in ("vertices", "faces"))
    if not (np.isfinite(faces).all() and np.array_equal(faces, faces.astype(int))):
        raise ConfigError(f"{path}: faces holds corners that are no whole numbers; needs numbers of vertices")
    return MeshFile(vertices, faces.astype(int), len(faces))


def _gdf(path: Path) -> MeshFile:
    """Panels of WAMIT's file, mirrored as it says."""
    numbers, stated, _, notes = read_gdf(path)
    isx, isy = stated
    vertices, faces = numbers.reshape(-1, 3), np.arange(len(numbers) * 4).reshape(-1, 4)
    for axis in [axis for axis, mirrored in enumerate((isx, isy)) if mirrored]:
        image = vertices * np.where(np.arange(3) == axis, -1.0, 1.0)
        vertices, faces = np.concatenate([vertices, image]), np.concatenate([faces, faces[:, ::-1] + len(vertices)])
    vertices, place = np.unique(vertices, axis=0, return_inverse=True)
    return MeshFile(vertices, place.reshape(-1)[faces], len(faces), notes)


class Gdf(NamedTuple):
    """WAMIT's file of panels: a header, NPAN panels of twelve numbers, and perhaps more lines."""

    corners: FloatArray  # (panel, 4, xyz), in the file's unit of length
    mirrored: tuple[bool, bool]  # in x = 0 (ISX) and in y = 0 (ISY)
    gravity: float  # GRAV, in the length unit of the panels per s^2
    notes: tuple[str, ...]


def read_gdf(path: Path) -> Gdf:
    """Return the contents of a file of flat panels; ValueError or LookupError if it is none."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    gravity, flags = float(lines[1].split()[1]), lines[2].split()[:2]
    count, *kind = lines[_HEADER - 1].split()
    if kind and kind[0].lstrip("-").isdigit() and int(kind[0]) != 0:
        raise ConfigError(
            f"{path}:{_HEADER}: IGDEF: received {kind[0]}, patches of a curved surface; needs flat panels (IGDEF = 0)"
        )
    wanted, last = 12 * int(count), _HEADER
    numbers: list[str] = []
    while len(numbers) < wanted and last < len(lines):
        numbers += lines[last].split()
        last += 1
    if len(numbers) < wanted:
        raise ConfigError(
            f"{path}:{_HEADER}: NPAN: received {wanted // 12}, but {len(numbers) // 12} panels follow; needs as many"
        )
    corners = np.array([float(word.upper().replace("D", "E")) for word in numbers[:wanted]]).reshape(-1, 4, 3)
    ignored = sum(bool(line.strip()) for line in lines[last:])
    notes = (f"{ignored} lines behind the panels of the GDF ignored",) if ignored else ()
    isx, isy = (int(flag) == 1 for flag in flags)
    return Gdf(corners, (isx, isy), gravity, notes)


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


def _stated_panels(path: Path, form: str) -> int:
    """Number of panels in a file that capytaine reads, with their images: it drops some."""
    text = path.read_text(encoding="utf-8", errors="replace")
    lines = text.splitlines()
    if form == "pnl":
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


def _obj(path: Path) -> tuple[FloatArray, list[_Cells]]:
    """Points and polygons of a Wavefront OBJ; normals, textures, colours, groups and smoothing mean nothing here.

    meshio reads it only where there are as many normals and textures as points, and without polygons of several sizes.
    """
    points: list[list[float]] = []
    cells: list[_Cells] = []
    text = path.read_text(encoding="utf-8", errors="replace").replace("\\\n", " ")
    for number, line in enumerate(text.splitlines(), 1):
        key, *words = line.split("#")[0].split() or [""]
        if key == "v":
            points.append([float(word) for word in words[:3]])
        elif key in ("f", "fo", "l", "p"):
            corners = [int(word.split("/")[0]) for word in words]
            from_one = [corner - 1 if corner > 0 else len(points) + corner for corner in corners]
            if 0 in corners:
                raise ConfigError(f"{path}:{number}: received {line[:40]!r}; needs corners by their numbers, from 1")
            cells.append(_Cells({"l": "line", "p": "vertex"}.get(key, "polygon"), np.array([from_one])))
        elif key in ("curv", "curv2", "surf", "bzp", "bsp"):
            raise ConfigError(f"{path}:{number}: received {key}, a curved surface; needs polygons: export a mesh")
    if not (points or cells):
        raise ConfigError(f"{path}: cannot be read as a mesh: holds no line of an OBJ, v or f; needs {_NEEDED}")
    return np.array(points, dtype=float).reshape(len(points), -1), cells


def _off(path: Path) -> tuple[FloatArray, list[_Cells]]:
    """Points and polygons of an OFF; meshio reads triangles alone."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    rows = [words for line in lines if (words := line.split("#")[0].split())]
    head = rows[0] if rows else []
    if not head or not re.fullmatch(r"[A-Z]*OFF", head[0]) or "4" in head[0] or "n" in head[0]:
        raise ConfigError(f"{path}:1: received {' '.join(head)[:40]!r}; needs OFF of points in space")
    counts, rows = (head[1:], rows[1:]) if len(head) > 1 else (rows[1], rows[2:])
    corners, polygons = int(counts[0]), int(counts[1])
    if len(rows) < corners + polygons:
        raise ConfigError(
            f"{path}: states {corners} points and {polygons} polygons, holds {len(rows)} lines; needs all"
        )
    points = np.array([[float(word) for word in row[:3]] for row in rows[:corners]])
    faces = [np.array([[int(word) for word in row[1 : int(row[0]) + 1]]]) for row in rows[corners : corners + polygons]]
    return points.reshape(corners, -1), [_Cells("polygon", face) for face in faces]


def _by_meshio(path: Path) -> tuple[FloatArray, list[_Cells]]:
    """Points and cells of a file as meshio reads it, once it is written as meshio expects it."""
    data = path.read_bytes()
    suffix, rewritten = path.suffix.lower(), data
    if suffix == ".vtk" and re.search(rb"(?im)^\s*DATASET\s+POLYDATA", data[:2000]):
        rewritten = _polydata(path, data)
    elif suffix == ".vtp":
        suffix, rewritten = ".vtu", _vtp(path, data)
    elif suffix == ".msh":  # meshio fails where some entities have physical groups and others none
        rewritten = re.sub(rb"\$Entities.*?\$EndEntities\s*\n", b"", data, count=1, flags=re.DOTALL)
    elif suffix == ".ply":
        rewritten = re.sub(rb"(property list \w+ \w+ )vertex_index(\s)", rb"\1vertex_indices\2", data, count=1)
    with np.errstate(all="ignore"):  # the first bytes of an STL in plain text are taken for a huge count
        if rewritten == data:
            mesh = meshio.read(path)
        else:
            with tempfile.TemporaryDirectory() as folder:
                copy = Path(folder, f"mesh{suffix}")
                copy.write_bytes(rewritten)
                mesh = meshio.read(copy)
    points = np.asarray(mesh.points, dtype=float)
    points = np.pad(points, ((0, 0), (0, max(0, 3 - points.shape[1]))))
    return points, [_Cells(block.type, np.asarray(block.data)) for block in mesh.cells]


def _polydata(path: Path, data: bytes) -> bytes:
    """VTK's legacy POLYDATA as an unstructured grid of polygons."""
    head = re.search(rb"(?m)^POLYGONS (\d+) (\d+)", data)
    others = re.findall(rb"(?m)^(VERTICES|LINES|TRIANGLE_STRIPS) \d+", data)
    if head is None or others:
        held = ", ".join(sorted(other.decode() for other in others)) or "no POLYGONS"
        raise ConfigError(f"{path}: POLYDATA holds {held}; needs POLYGONS alone: triangulate it")
    later = re.match(rb".*?version\s+[5-9]", data[:200], re.DOTALL | re.IGNORECASE) is not None
    count = int(head[1]) - later  # since version 5 the number of offsets
    binary = re.search(rb"(?im)^\s*BINARY\s*$", data[:2000]) is not None
    types = np.full(count, 7, dtype=">i4").tobytes() if binary else b"7\n" * count
    grid = re.sub(rb"(?im)^(\s*DATASET\s+)POLYDATA", rb"\1UNSTRUCTURED_GRID", data, count=1)
    grid = grid.replace(b"\nPOLYGONS ", b"\nCELLS ", 1)
    return grid + (b"" if grid.endswith(b"\n") else b"\n") + b"CELL_TYPES %d\n" % count + types + b"\n"


def _vtp(path: Path, data: bytes) -> bytes:
    """VTK's XML PolyData as an unstructured grid of polygons."""
    counts = {name.decode(): int(value) for name, value in re.findall(rb'NumberOf(\w+)="(\d+)"', data)}
    if held := [name for name in ("Verts", "Lines", "Strips") if counts.get(name)]:
        raise ConfigError(f"{path}: PolyData holds {', '.join(held)}; needs polygons alone: triangulate it")
    count = counts["Polys"]
    types = b'<DataArray type="UInt8" Name="types" format="ascii">' + b"7 " * count + b"</DataArray></Cells>"
    for name in (b"Verts", b"Lines", b"Strips"):
        data = re.sub(rb"<%b>.*?</%b>|<%b\s*/>" % (name, name, name), b"", data, count=1, flags=re.DOTALL)
        data = re.sub(rb'\sNumberOf%b="\d+"' % name, b"", data, count=1)
    data = data.replace(b"NumberOfPolys=", b"NumberOfCells=", 1).replace(b"<Polys>", b"<Cells>", 1)
    return data.replace(b"</Polys>", types, 1).replace(b"PolyData", b"UnstructuredGrid")
