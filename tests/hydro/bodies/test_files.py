"""Mesh and modes files from anywhere: read, or refused in one line."""

import importlib.util
import random
import re
import struct
import sys
import warnings
from contextlib import nullcontext
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import xarray as xr
from hydro.bodies.test_body import made, rigid

from examples import barge
from vsb.errors import ConfigError
from vsb.hydro.bodies import files
from vsb.hydro.panels.mesh import revolved
from vsb.tools import bounded

LABELS = ("Heave", "Pitch")
BOX = barge.box(6.0, 4.0, 2.0, 1)


@pytest.fixture(scope="module")
def body():
    return made(*BOX, rigid(BOX[0])[[2, 4]], LABELS)


def text_of(rows):
    return "\n".join(" ".join(f"{value:.12g}" for value in row) for row in rows)


def numbered(rows):
    return text_of([[i + 1, *row] for i, row in enumerate(rows)])


def mesh_file(folder, name):
    """The box in a format of any program, by the name's end."""
    (vertices, faces), path, kind = BOX, folder / name, name.split(".")[-1].lower()
    if kind == "gdf":
        path.write_text(f"box\n1.0 9.81\n0 0\n{len(faces)}\n{text_of(vertices[faces].reshape(-1, 3))}\n")
    elif kind in ("dat", "mar"):
        path.write_text(f"2 0\n{numbered(vertices)}\n0 0. 0. 0.\n{text_of(faces + 1)}\n0 0 0 0\n")
    elif kind == "hst":
        panels = f"PANEL TYPE 0\n{text_of(faces + 1)}\nENDPANEL\nENDFILE\n"
        path.write_text(f"COORDINATES\n{numbered(vertices)}\nENDCOORDINATES\n{panels}")
    elif kind == "nc":
        files.write_body(made(*BOX, rigid(BOX[0])[[2, 4]], LABELS), path)
    elif kind in ("stl", "off"):
        triangles = np.concatenate([faces[:, :3], faces[:, [0, 2, 3]]])
        meshio.Mesh(vertices, [("triangle", triangles)]).write(path)
    else:
        meshio.Mesh(vertices, [("quad", faces.astype(np.int32))]).write(path)
    return path


KINDS = ("gdf", "GDF", "dat", "mar", "hst", "nc", "NC", "stl", "STL", "off", "vtu", "vtk", "ply", "obj", "msh", "inp")


@pytest.mark.parametrize("kind", KINDS)
def test_mesh_files_of_other_programs_give_the_same_body(tmp_path, body, kind):
    """Extensions in capitals, as on other systems, and NEMOH's .dat, which is Tecplot's as well, among them."""
    vertices, faces = files.read_mesh(mesh_file(tmp_path, f"box.{kind}"))
    again = made(vertices, faces, rigid(vertices)[[2, 4]], LABELS)
    assert again.volumes == pytest.approx(body.volumes, rel=1e-6)
    assert again.triangles.area.sum(axis=0) == pytest.approx(body.triangles.area.sum(axis=0), abs=1e-4)


def test_tecplots_dat_is_read_as_such(tmp_path):
    mesh_file(tmp_path, "box.tec").rename(tmp_path / "box.dat")
    assert files.read_mesh(tmp_path / "box.dat")[0] == pytest.approx(BOX[0])
    first, rest = (tmp_path / "box.dat").read_bytes().split(b"\n", 1)
    (tmp_path / "box.dat").write_bytes(b'TITLE = "K\xf6rper"\n' + first + b"\n" + rest)  # of whatever alphabet
    assert not files._is_nemoh(tmp_path / "box.dat")


def test_modes_at_panels_do_as_well_as_at_corners(tmp_path, body):
    files.write_body(body, tmp_path / "box.nc")
    by_panel = xr.Dataset(
        {"mode_shape": (("dof", "panel", "xyz"), body.modes), "centre_of_mass": ("xyz", body.centre_of_mass)},
        coords={"dof": list(LABELS)},
    )
    by_panel.to_netcdf(tmp_path / "modes.nc")
    again = files.read_body(tmp_path / "box.nc", tmp_path / "modes.nc")
    assert again.modes == pytest.approx(body.modes)
    assert again.mass is None
    assert again.labels == LABELS


def written(tmp_path, body, **changes):
    """Modes file with some variables changed."""
    files.write_body(body, tmp_path / "box.nc")
    shape = np.array(body.shapes)
    data = {"mode_shape": (("dof", "vertex", "xyz"), shape), "centre_of_mass": ("xyz", body.centre_of_mass)}
    xr.Dataset(data | changes, coords={"dof": list(LABELS)}).to_netcdf(tmp_path / "modes.nc")
    return tmp_path / "box.nc", tmp_path / "modes.nc"


def test_a_modes_file_that_does_not_fit_is_refused_by_name(tmp_path, body):
    count = len(body.vertices)
    with pytest.raises(ConfigError, match=rf"modes.nc: mode_shape .*{count - 1}.*with {count} vertices"):
        files.read_body(*written(tmp_path, body, mode_shape=(("dof", "vertex", "xyz"), body.shapes[:, 1:])))
    plane = {"mode_shape": (("dof", "vertex", "xyz"), body.shapes[..., :2]), "centre_of_mass": ((), 0.0)}
    with pytest.raises(ConfigError, match=r"mode_shape \{.*'xyz': 2\}; needs \(dof, vertex, xyz\)"):
        files.read_body(*written(tmp_path, body, **plane))
    with pytest.raises(ConfigError, match=r"modes.nc: .*NaN"):
        files.read_body(*written(tmp_path, body, mode_shape=(("dof", "vertex", "xyz"), np.nan * body.shapes)))
    xr.Dataset({"shape": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc")
    with pytest.raises(ConfigError, match=r"other.nc: holds \['shape'\]; needs mode_shape"):
        files.read_body(tmp_path / "box.nc", tmp_path / "other.nc")
    (tmp_path / "text.nc").write_text("no netCDF")
    with pytest.raises(ConfigError, match=r"text.nc: cannot be read as netCDF"):
        files.read_body(tmp_path / "box.nc", tmp_path / "text.nc")


def test_displacements_without_names_are_refused(tmp_path, body):
    files.write_body(body, tmp_path / "box.nc")
    shapes = {"mode_shape": (("dof", "vertex", "xyz"), body.shapes), "centre_of_mass": ("xyz", body.centre_of_mass)}
    xr.Dataset(shapes).to_netcdf(tmp_path / "modes.nc")
    with pytest.raises(
        ConfigError, match=r"modes.nc: holds \['mode_shape', 'centre_of_mass'\]; needs mode_shape .* and dof"
    ):
        files.read_body(tmp_path / "box.nc", tmp_path / "modes.nc")


def test_a_mesh_without_anything_is_refused_by_name(tmp_path, body):
    """Zero panels between zero points have no length to be measured in."""
    _, modes = written(tmp_path, body)
    none = {"vertices": (("vertex", "xyz"), np.zeros((0, 3))), "faces": (("panel", "corner"), np.zeros((0, 4), int))}
    xr.Dataset(none).to_netcdf(tmp_path / "none.nc")
    with pytest.raises(ConfigError, match=r"none.nc: holds no panel; needs quadrilaterals or triangles$"):
        files.read_body(tmp_path / "none.nc", modes)


def test_what_is_infinite_is_told_to_be_so_not_to_be_too_large(tmp_path, body):
    shapes = np.array(body.shapes)
    shapes[0, 0, 2] = np.inf
    with pytest.raises(ConfigError) as refused:
        files.read_body(*written(tmp_path, body, mode_shape=(("dof", "vertex", "xyz"), shapes)))
    assert "NaN or infinite" in str(refused.value)
    assert "reaches" not in str(refused.value)


@pytest.mark.parametrize(
    ("name", "limit"),
    [
        ("mode_shape", 1e6), ("centre_of_mass", 1e6), ("inertia_matrix", 1e30), ("structural_stiffness", 1e30),
        ("second_order", 1e6),
    ],
)  # fmt: skip
def test_the_largest_numbers_a_body_has(tmp_path, body, name, limit):
    pair = ("influenced_dof", "radiating_dof")
    unit = {"mode_shape": (("dof", "vertex", "xyz"), np.eye(1, body.shapes.size).reshape(body.shapes.shape))}
    unit |= {"centre_of_mass": ("xyz", np.array([0.0, 0.0, -1.0])), "inertia_matrix": (pair, np.eye(2))}
    unit |= {"structural_stiffness": (pair, np.eye(2))}
    unit |= {"second_order": ((*pair, "vertex", "xyz"), np.ones((2, 2, len(body.vertices), 3)))}
    dims, values = unit[name]
    mesh, modes = written(tmp_path, body, **{name: (dims, limit * values)})
    read = files._displacements(modes, (len(body.vertices), len(body.faces)), mesh)
    assert np.abs(read[1] if name == "mode_shape" else read[3][name]).max() == limit
    with pytest.raises(ConfigError) as refused:
        files.read_body(*written(tmp_path, body, **{name: (dims, -1.001 * limit * values)}))
    assert str(refused.value) == f"{modes}: {name} reaches {1.001 * limit:.3g}; needs at most {limit:g}"


@pytest.mark.parametrize("name", ["none.vtu", "garbage.vtu", "garbage.stl", "garbage.gdf", "garbage.nc", "garbage.foo"])
def test_a_mesh_that_cannot_be_read_is_refused_in_one_line(tmp_path, name, capsys):
    if not name.startswith("none"):
        (tmp_path / name).write_text("garbage\n")
    with pytest.raises(ConfigError, match=rf"{name}: (mesh not found|cannot be read as a mesh)") as error:
        files.read_mesh(tmp_path / name)
    assert "\n" not in str(error.value)


def test_lines_and_points_are_no_panels(tmp_path):
    meshio.Mesh(np.eye(3), [("line", [[0, 1]])]).write(tmp_path / "line.vtu")
    with pytest.raises(ConfigError, match=r"line.vtu: holds \['line'\]; needs quadrilaterals"):
        files.read_mesh(tmp_path / "line.vtu")


def test_a_closed_cylinder_of_triangles_loses_those_without_area(tmp_path):
    """Circles that end in a point leave triangles whose corners coincide, in single precision nearly."""
    radius, height = np.array([0.0, 0.5, 1.0, 1.0, 0.5, 0.0]), np.array([-1.0, -1.0, -1.0, -3.0, -3.0, -3.0])
    vertices, faces = revolved(radius, height, 12)
    triangles = np.concatenate([faces[:, :3], faces[:, [0, 2, 3]]])
    with np.errstate(invalid="ignore"):  # normals of nothing
        meshio.Mesh(vertices + 0.1, [("triangle", triangles)]).write(tmp_path / "cylinder.stl")
    corners, panels = files.read_mesh(tmp_path / "cylinder.stl")
    for at, shape in {"vertex": len(corners), "panel": len(panels)}.items():
        modes = xr.Dataset({"mode_shape": (("dof", at, "xyz"), np.tile([0.0, 0.0, 1.0], (1, shape, 1)))})
        modes.assign_coords(dof=["Heave"]).to_netcdf(tmp_path / f"{at}.nc")
        body = files.read_body(tmp_path / "cylinder.stl", tmp_path / f"{at}.nc")
        assert len(body.faces) == len(triangles) - 24
        assert body.history == f"panels without area dropped: 24 of {len(triangles)}"
        assert body.volume == pytest.approx(12 / 2 * np.sin(2 * np.pi / 12) * 2.0, rel=1e-5)
    own = np.linspace(1.0, 2.0, len(panels))  # each panel keeps its own displacement
    modes = xr.Dataset({"mode_shape": (("dof", "panel", "xyz"), own[None, :, None] * [0.0, 0.0, 1.0])})
    modes.assign_coords(dof=["Stretch"]).to_netcdf(tmp_path / "own.nc")
    body = files.read_body(tmp_path / "cylinder.stl", tmp_path / "own.nc")
    assert body.modes[0, :, 2].tolist() == own[~files.without_area(corners, panels)].tolist()


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_panel_has_no_area_if_it_is_lower_than_single_precision_shows(size, share):
    """Height of a rectangle, over the diagonal of what all panels span, however large the body is."""
    corners = np.array(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0, 0), (0.5, 0, 1), (0, 0, 1), (0, 0, 0)], float
    )
    vertices = size * np.vstack([corners, [(0.5, share * 3**0.5 * 1e-7, 0), (0, share * 3**0.5 * 1e-7, 0)]])
    faces = np.array([[0, 1, 2, 3], [0, 4, 5, 6], [0, 4, 8, 9], [0, 1, 2, 2]])
    for away in (0.0, 0.5 * size):  # wherever it lies
        assert files.without_area(vertices + away, faces).tolist() == [False, False, share < 1, False]


def test_a_body_without_such_panels_has_no_history(tmp_path):
    path = mesh_file(tmp_path, "box.nc")
    assert files.read_body(path, path).history == ""


def test_triangles_of_netcdf_end_in_their_third_corner_twice(tmp_path):
    faces = [[0, 1, 2], [3, 2, 1]]
    xr.Dataset({"vertices": (("vertex", "xyz"), np.eye(4, 3)), "faces": (("panel", "corner"), faces)}).to_netcdf(
        tmp_path / "mesh.nc"
    )
    assert files.read_mesh(tmp_path / "mesh.nc")[1].tolist() == [[0, 1, 2, 2], [3, 2, 1, 1]]


def test_panels_of_every_kind_are_read_in_the_order_of_the_file(tmp_path):
    """Triangles between two blocks of quadrilaterals, and lines, which are none."""
    points = np.array([[x, y, -1.0] for x in range(3) for y in range(3)], dtype=float)
    blocks = [
        ("quad", [[0, 3, 4, 1]]),
        ("line", [[0, 1]]),
        ("triangle", [[1, 4, 5], [1, 5, 2]]),
        ("quad", [[3, 6, 7, 4]]),
    ]
    meshio.Mesh(points, blocks).write(tmp_path / "mixed.vtk")
    vertices, faces = files.read_mesh(tmp_path / "mixed.vtk")
    assert vertices == pytest.approx(points)
    assert faces.tolist() == [[0, 3, 4, 1], [1, 4, 5, 5], [1, 5, 2, 2], [3, 6, 7, 4]]


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize("corner", [-1, 4, 1_000_000])
def test_a_panel_with_a_corner_that_does_not_exist_is_named(tmp_path, corner, place):
    faces = np.array([[0, 1, 2, 3], [0, 1, 2, 3]])
    faces[1, place] = corner
    own = ", ".join(map(str, faces[1]))
    xr.Dataset({"vertices": (("vertex", "xyz"), np.eye(4, 3)), "faces": (("panel", "corner"), faces)}).to_netcdf(
        tmp_path / "mesh.nc"
    )
    with pytest.raises(ConfigError, match=rf"panel 1 has corners \[{own}\]; needs numbers from 0 to 3"):
        files.read_mesh(tmp_path / "mesh.nc")


@pytest.mark.parametrize(
    ("variables", "message"),
    [
        ({"faces": (("panel", "corner"), [[0.0, 1.0, 2.5, 3.0]])}, "corners of panels that are no whole numbers"),
        ({"faces": ("panel", [0, 1, 2])}, r"vertices \(4, 3\) and faces \(3,\); needs \(vertex, xyz\)"),
        ({"vertices": (("vertex", "xy"), np.zeros((4, 2)))}, r"vertices \(4, 2\) and faces \(1, 4\); needs"),
        ({"vertices": ("vertex", np.zeros(4))}, r"vertices \(4,\) and faces \(1, 4\); needs \(vertex, xyz\)"),
        ({"faces": (("panel", "corner"), [[0, 1]])}, r"faces \(1, 2\); needs .* 3 or 4 corners"),
        ({"faces": (("panel", "corner"), [[0, 1, 2, 3, 0]])}, r"faces \(1, 5\); needs .* 3 or 4 corners"),
        ({"faces": (("panel", "corner"), np.zeros((0, 4), dtype=int))}, "holds no panel; needs quadrilaterals"),
        ({"vertices": (("vertex", "xyz"), np.full((4, 3), np.nan))}, "a vertex is NaN or infinite"),
        ({"vertices": (("vertex", "xyz"), np.full((4, 3), 1e300))}, r"reaches 1e\+300 m; needs at most 100000 m"),
    ],
)
def test_a_mesh_of_other_shape_is_refused(tmp_path, variables, message):
    usual = {"vertices": (("vertex", "xyz"), np.eye(4, 3)), "faces": (("panel", "corner"), [[0, 1, 2, 3]])}
    xr.Dataset(usual | variables).to_netcdf(tmp_path / "mesh.nc")
    with pytest.raises(ConfigError, match=rf"mesh.nc: .*{message}"):
        files.read_mesh(tmp_path / "mesh.nc")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"mode_shape": (("dof", "vertex", "xyz"), 1e300 * rigid(BOX[0])[[2, 4]])},
            "mode_shape reaches 3e[+]300; needs at most 1e[+]06",
        ),
        ({"centre_of_mass": ("xyz", [0.0, 0.0, -1e300])}, "centre_of_mass reaches 1e[+]300; needs at most 1e[+]06"),
        ({"inertia_matrix": (("influenced_dof", "radiating_dof"), 1e300 * np.eye(2))}, "inertia_matrix reaches 1e"),
    ],
)
def test_numbers_no_body_has_are_refused(tmp_path, body, changes, message):
    with pytest.raises(ConfigError, match=rf"modes.nc: {message}"):
        files.read_body(*written(tmp_path, body, **changes))


HUGE = b"""ply
format binary_little_endian 1.0
element vertex 4000000000
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
"""


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("huge.ply", HUGE + 100 * b"\0", r"cannot be read as a mesh \(it announces more than it holds\)"),
        ("huge.stl", 80 * b"\0" + struct.pack("<I", 4_000_000_000) + 50 * b"\0", r"holds \[\]; needs quadrilaterals"),
    ],
)
def test_a_header_that_announces_more_than_there_is_takes_no_memory(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ConfigError, match=f"{name}: {message}"):
        files.read_mesh(tmp_path / name)


def test_a_reader_that_waits_for_an_end_that_was_cut_off_is_ended(tmp_path, monkeypatch):
    monkeypatch.setattr(bounded, "SECONDS", (0.3, 0.0))
    whole = mesh_file(tmp_path, "box.tec").read_bytes()
    (tmp_path / "cut.tec").write_bytes(whole[:200])  # of 75 vertices two
    with pytest.raises(ConfigError, match=r"cut.tec: cannot be read as a mesh \(it takes more than 0.3 s\)"):
        files.read_mesh(tmp_path / "cut.tec")


def damaged(data, chance):
    """A file with one bit turned, cut short, one number replaced, or eight bytes of anything."""
    at = chance.randrange(len(data))
    kind = chance.choice(["bit", "head", "cut", "number", "bytes"])
    if kind == "cut":
        return data[:at]
    if kind == "bytes":
        return data[:at] + chance.randbytes(8) + data[at + 8 :]
    if kind == "number" and (numbers := list(re.finditer(rb"\d+", data))):
        found = chance.choice(numbers[:40])
        new = chance.choice([b"4000000000", b"-1", b"1e300", b"nan", b"0", b"99999999999999999999"])
        return data[: found.start()] + new + data[found.end() :]
    at = chance.randrange(min(400, len(data))) if kind == "head" else at
    return data[:at] + bytes([data[at] ^ 1 << chance.randrange(8)]) + data[at + 1 :]


@pytest.mark.parametrize("kind", [*KINDS, "modes.nc", "tec", "mdpa", "avs"])
def test_damaged_files_are_read_or_refused_in_one_line(tmp_path, kind, monkeypatch):
    """Ten of each kind: whatever other libraries make of them, no traceback, no warning, no end of memory or time."""
    monkeypatch.setattr(bounded, "SECONDS", (1.0, 0.0))
    mesh, chance = mesh_file(tmp_path, "box.nc"), random.Random(kind)
    whole = mesh.read_bytes() if kind == "modes.nc" else mesh_file(tmp_path, f"box.{kind}").read_bytes()
    for i in range(11):
        broken = tmp_path / f"broken{i}.{kind}"
        broken.write_bytes(damaged(whole, chance))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                files.read_body(mesh, broken) if kind == "modes.nc" else files.read_mesh(broken)
            except ConfigError as error:
                told = str(error)
                assert broken.name in told and len(told) < 700 and "\n" not in told  # noqa: PT018


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("a.PNL", "pnl"), ("a.hst", "hst"), ("a.mar", "mar"), ("a.Nemoh", "mar"), ("a.hams", "pnl"),
        ("a.dat", "mar"), ("a.DAT", "mar"),
    ],
)  # fmt: skip
def test_panels_of_other_programs_are_read_by_the_end_of_their_name(tmp_path, monkeypatch, name, kind):
    (tmp_path / name).write_text("2 0\n")
    asked = []
    monkeypatch.setattr(
        files.bem, "read_panels", lambda *given: asked.append(given) or (np.eye(3), np.array([[0, 1, 2]]))
    )
    assert files.read_mesh(tmp_path / name)[1].tolist() == [[0, 1, 2, 2]]
    assert asked == [(tmp_path / name, kind)]


def test_points_in_a_plane_lie_in_the_waters_surface(tmp_path, monkeypatch):
    """Some formats leave out a height that is none."""
    points = np.array([[0.0, 1.0], [2.0, 3.0], [4.0, 6.0]])
    cells = [SimpleNamespace(type="triangle", data=np.array([[0, 1, 2]])), SimpleNamespace(type="vertex", data=None)]
    monkeypatch.setattr(files.meshio, "read", lambda path: SimpleNamespace(points=points, cells=cells))
    (tmp_path / "a.vtk").touch()
    vertices, faces = files.read_mesh(tmp_path / "a.vtk")
    assert vertices.tolist() == [[0.0, 1.0, 0.0], [2.0, 3.0, 0.0], [4.0, 6.0, 0.0]]
    assert faces.tolist() == [[0, 1, 2, 2]]


def test_all_kinds_of_cells_that_are_no_panels_are_named(tmp_path, monkeypatch):
    cells = [SimpleNamespace(type=kind, data=None) for kind in ("line", "quad8", "tetra")]
    monkeypatch.setattr(files.meshio, "read", lambda path: SimpleNamespace(points=np.eye(3), cells=cells))
    (tmp_path / "a.vtk").touch()
    with pytest.raises(ConfigError, match=r"a.vtk: holds \['line', 'quad8', 'tetra'\]; needs quadrilaterals or tri"):
        files.read_mesh(tmp_path / "a.vtk")


def test_matrices_and_centres_of_a_body_come_back_from_its_file(tmp_path):
    """Those there are, each its own."""
    shapes = rigid(BOX[0])[[2, 4]]
    mass, stiffness = np.array([[3.0, 0.5], [0.5, 7.0]]), np.array([[30.0, 5.0], [5.0, 70.0]])
    for given in ({}, {"mass": mass}, {"stiffness": stiffness}, {"mass": mass, "stiffness": stiffness}):
        body = made(*BOX, shapes, LABELS, centre_of_mass=np.array([0.1, 0.2, 0.3]), **given)
        files.write_body(body, tmp_path / "box.nc")
        again = files.read_body(tmp_path / "box.nc", tmp_path / "box.nc")
        assert again.centre_of_mass.tolist() == [0.1, 0.2, 0.3]
        for name in ("mass", "stiffness"):
            held = getattr(again, name)
            assert (held is None) == (name not in given)
            assert held is None or held.tolist() == given[name].tolist()
    heave = made(*BOX, shapes[:1], LABELS[:1], centre_of_mass=None)
    files.write_body(heave, tmp_path / "box.nc")
    assert files.read_body(tmp_path / "box.nc", tmp_path / "box.nc").centre_of_mass is None


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (MemoryError("much"), "it announces more than it holds"),
        (SystemExit(), "SystemExit"),
        (KeyError(), "KeyError"),
        (ValueError("two\n  lines"), "two lines"),
        (OSError("x" * 300), "x" * 200),
    ],
)
def test_whatever_a_library_makes_of_a_mesh_is_one_line(tmp_path, monkeypatch, capfd, error, reason):
    def broken(path):
        print("what is not heard")
        print("nor this", file=sys.stderr)
        raise error

    (tmp_path / "a.vtk").touch()
    monkeypatch.setattr(files, "_panels", broken)
    with pytest.raises(ConfigError) as refused:
        files.read_mesh(tmp_path / "a.vtk")
    path = tmp_path / "a.vtk"
    assert str(refused.value) == f"{path}: cannot be read as a mesh ({reason}); needs a format of meshio or netCDF"
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("size", [0, 1000])
def test_a_file_may_take_as_much_memory_and_time_as_it_is_large(tmp_path, monkeypatch, size):
    (tmp_path / "a.vtk").write_bytes(bytes(size))
    given = []
    for name in ("bounded_memory", "bounded_time"):
        monkeypatch.setattr(bounded, name, lambda most: given.append(most) or nullcontext())
    monkeypatch.setattr(files, "_panels", lambda path: (np.eye(3), np.array([[0, 1, 2, 2]])))
    files.read_mesh(tmp_path / "a.vtk")
    assert given == [2**30 + 200 * size, pytest.approx(20.0 + 2e-5 * size, rel=1e-12)]


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_the_longest_side_counts_wherever_it_stands_among_the_corners(share):
    """A trapezium of 2/3 of its height, its long side the first to the last: one panel from each corner on, both ways."""
    height = share * 1.5e-7 * 2**0.5
    corners = [(0, 0, 0), (1 / 3, height, 0), (2 / 3, height, 0), (1, 0, 0), (0, 0, 1)]
    ways = [np.roll(order, k) for order in ((0, 1, 2, 3), (3, 2, 1, 0)) for k in range(4)]
    assert files.without_area(np.array(corners), np.array(ways)).tolist() == [share < 1] * 8


def gdf(gravity=9.81, behind=""):
    """A box of five panels, as WAMIT writes it."""
    vertices, faces = barge.box(4.0, 2.0, 1.0, 1)
    rows = [" ".join(map(repr, point)) for point in vertices[faces].reshape(-1, 3).tolist()]
    return "\n".join(["box", f"1.0 {gravity}", "0 0", str(len(faces)), *rows]) + behind


def test_what_stands_behind_the_panels_of_a_gdf_is_ignored_with_a_note(tmp_path):
    (tmp_path / "plain.gdf").write_text(gdf())
    (tmp_path / "trail.gdf").write_text(gdf(behind="\n0\nend of file\n"))
    plain, trail = (files.read_mesh(tmp_path / f"{name}.gdf") for name in ("plain", "trail"))
    assert all(one.tolist() == other.tolist() for one, other in zip(plain, trail, strict=True))
    modes = xr.Dataset(
        {"mode_shape": (("dof", "vertex", "xyz"), np.ones((1, len(plain[0]), 3)))}, coords={"dof": ["Drift"]}
    )
    modes.to_netcdf(tmp_path / "modes.nc")
    assert files.read_body(tmp_path / "trail.gdf", tmp_path / "modes.nc", 9.81).history == (
        "2 lines behind the panels of the GDF ignored"
    )
    (tmp_path / "feet.gdf").write_text(gdf(32.174))
    with pytest.raises(ConfigError, match=r"feet.gdf:2: GRAV: received 32.174, which is in feet; needs water.gravity"):
        files.read_body(tmp_path / "feet.gdf", tmp_path / "modes.nc", 9.81)
    (tmp_path / "short.gdf").write_text(gdf().rpartition("\n")[0])
    with pytest.raises(ConfigError, match=r"short.gdf: cannot be read as a mesh \(NPAN is \d+, but \d+ panels follow"):
        files.read_mesh(tmp_path / "short.gdf")


def test_files_of_salome_are_refused_in_words(tmp_path):
    (tmp_path / "a.dat").write_text("8 17\n1 0.0 0.0 0.0\n")
    with pytest.raises(ConfigError, match=r"a.dat:1: received '8 17', as SALOME's .dat begins; needs NEMOH's"):
        files.read_mesh(tmp_path / "a.dat")
    (tmp_path / "a.med").write_bytes(b"\x89HDF")
    if importlib.util.find_spec("h5py") is None:
        with pytest.raises(ConfigError, match=r"a.med: the Python package h5py, which reads such files, is missing"):
            files.read_mesh(tmp_path / "a.med")
