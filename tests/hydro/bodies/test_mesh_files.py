"""Mesh files as CAD and mesh programs write them: every cell is used, noted or refused, and the first cause is named."""

import random
import re
import warnings
from itertools import pairwise

import meshio
import numpy as np
import pytest
import xarray as xr
from hydro.bodies.test_body import made, rigid

from examples import barge
from vsb.engine.hydro.bodies import build
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.build import build_body
from vsb.engine.hydro.bodies.mesh import joined, triangulated, turned_outward
from vsb.engine.hydro.bodies.mesh_files import read_mesh
from vsb.errors import ConfigError
from vsb.keys.reading import validated
from vsb.tools import files as tool_files

R, T, N = 2.0, 3.0, 12  # radius and draught of an upright cylinder [m], panels around
VOLUME = N / 2 * np.sin(2 * np.pi / N) * R**2 * T


def cylinder():
    """Corners (corner, xyz), two rows of quadrilaterals of the side, and the keel as one polygon, normals outward."""
    angle = 2 * np.pi * np.arange(N) / N
    ring = np.column_stack([R * np.cos(angle), R * np.sin(angle)])
    points = np.concatenate([np.column_stack([ring, np.full(N, z)]) for z in (0.0, -T / 2, -T)])
    around = [(j, (j + 1) % N) for j in range(N)]
    side = [[k * N + a, (k + 1) * N + a, (k + 1) * N + b, k * N + b] for k in (0, 1) for a, b in around]
    return points, side, [2 * N + j for j in range(N)][::-1]


def described(path, modes=("Heave",), **changes):
    mesh = {"file": path.name, **changes.pop("mesh")} if "mesh" in changes else path.name
    raw = {"body": "b", "mesh": mesh, "modes": list(modes), "mass": "displaced", "omega": [1.0], **changes}
    return build_body(validated(BodyFile, raw, "b.yaml"), {"mesh": path})


def obj(path, points, polygons, corner="{0}", head=""):
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in points]
    lines += ["f " + " ".join(corner.format(i + 1) for i in polygon) for polygon in polygons]
    path.write_text(head + "\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("corner", ["{0}", "{0}/1/1", "{0}//1", "{0}/1"])
def test_obj_with_normals_textures_and_a_polygon_keel_is_read(tmp_path, corner):
    points, side, keel = cylinder()
    head = "mtllib a.mtl\no hull\nvt 0 0\nvn 0 0 1\ns off\nusemtl steel\n"
    body = described(obj(tmp_path / "hull.obj", points, [*side, keel], corner, head))
    assert body.volume == pytest.approx(VOLUME, rel=1e-8)
    assert "polygons cut into triangles: 1" in body.history


def test_obj_that_counts_from_the_end_and_colours_its_corners_is_the_same(tmp_path):
    points, side, keel = cylinder()
    lines = [f"v {x:.9g} {y:.9g} {z:.9g} 1 0 0" for x, y, z in points]
    lines += ["f " + " ".join(str(i - len(points)) for i in polygon) for polygon in [*side, keel]]
    (tmp_path / "hull.obj").write_text("\n".join(lines))
    assert described(tmp_path / "hull.obj").volume == pytest.approx(VOLUME, rel=1e-8)


def test_off_of_polygons_and_lines_that_go_on_are_read(tmp_path):
    points, side, keel = cylinder()
    rows = [" ".join(map(repr, point)) for point in points.tolist()]
    rows += [" ".join(map(str, [len(polygon), *polygon])) for polygon in [*side, keel]]
    (tmp_path / "hull.off").write_text(f"OFF # a hull\n{len(points)} {len(side) + 1} 0\n" + "\n".join(rows))
    assert described(tmp_path / "hull.off").volume == pytest.approx(VOLUME, rel=1e-12)
    path = obj(tmp_path / "hull.obj", points, [*side, keel])
    path.write_text(path.read_text().replace(" 36", " \\\n36"))
    assert described(path).volume == pytest.approx(VOLUME, rel=1e-8)


def test_gmsh_with_groups_of_some_of_its_surfaces_is_read(tmp_path):
    """GMSH 4.1: meshio fails where some entities are of a physical group and others, as this line, of none."""
    points, side, _ = cylinder()
    nodes = "\n".join(f"{x:.9g} {y:.9g} {z:.9g}" for x, y, z in points)
    tags = "\n".join(str(i + 1) for i in range(len(points)))
    quads = "\n".join(f"{k + 3} " + " ".join(str(i + 1) for i in quad) for k, quad in enumerate(side))
    (tmp_path / "hull.msh").write_text(
        '$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 "side"\n$EndPhysicalNames\n$Entities\n0 1 1 0\n'
        f"1 -2 -2 -3 2 2 0 0 0\n1 -2 -2 -3 2 2 0 1 1 0\n$EndEntities\n$Nodes\n1 {len(points)} 1 {len(points)}\n"
        f"2 1 0 {len(points)}\n{tags}\n{nodes}\n$EndNodes\n$Elements\n2 {len(side) + 1} 1 {len(side) + 1}\n"
        f"1 1 1 1\n1 1 2\n2 1 3 {len(side)}\n{quads}\n$EndElements\n"
    )
    found = read_mesh(tmp_path / "hull.msh")
    assert (len(found.faces), found.notes) == (len(side), ("left out, no surface: 1 line",))


def polydata(path, version, mode, points, polygons):
    """VTK's POLYDATA of a version, ASCII or BINARY."""
    sizes = [len(p) for p in polygons]
    head = f"# vtk DataFile Version {version}\nhull\n{mode}\nDATASET POLYDATA\nPOINTS {len(points)} double\n".encode()
    binary = mode == "BINARY"

    def block(values, kind):
        return np.asarray(values, kind).tobytes() + b"\n" if binary else " ".join(map(repr, values)).encode() + b"\n"

    data = head + block(np.ravel(points).tolist(), ">f8")
    if version < "5":
        flat = [number for p in polygons for number in (len(p), *p)]
        data += b"POLYGONS %d %d\n" % (len(polygons), len(flat)) + block(flat, ">i4")
    else:
        data += b"POLYGONS %d %d\nOFFSETS vtktypeint64\n" % (len(polygons) + 1, sum(sizes))
        data += block([0, *np.cumsum(sizes).tolist()], ">i8") + b"CONNECTIVITY vtktypeint64\n"
        data += block([i for p in polygons for i in p], ">i8")
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("version", ["3.0", "5.1"])
@pytest.mark.parametrize("mode", ["ASCII", "BINARY"])
def test_polydata_of_old_and_new_vtk_is_read(tmp_path, version, mode):
    points, side, keel = cylinder()
    body = described(polydata(tmp_path / "hull.vtk", version, mode, points, [*side, keel]))
    assert body.volume == pytest.approx(VOLUME, rel=1e-12)


def test_vtp_as_paraview_writes_surfaces_is_read(tmp_path):
    points, side, keel = cylinder()
    polygons = [*side, keel]

    def array(kind, name, values, more=""):
        text = " ".join(map(str, values))
        return f'<DataArray type="{kind}" Name="{name}"{more} format="ascii">{text}</DataArray>'

    ends = np.cumsum([len(p) for p in polygons]).tolist()
    (tmp_path / "hull.vtp").write_text(
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian">\n<PolyData>\n'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" '
        f'NumberOfPolys="{len(polygons)}">\n<Points>'
        + array("Float64", "Points", np.ravel(points).tolist(), ' NumberOfComponents="3"')
        + "</Points>\n<Polys>"
        + array("Int64", "connectivity", [i for p in polygons for i in p])
        + array("Int64", "offsets", ends)
        + "</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n"
    )
    assert described(tmp_path / "hull.vtp").volume == pytest.approx(VOLUME, rel=1e-12)


def second_order(corners, points):
    """Cells of second order: triangles or quadrilaterals with a corner in the middle of each side."""
    points, cells = list(points), []
    for cell in corners:
        ends = list(zip(cell, [*cell[1:], cell[0]], strict=True))
        cells.append([*cell, *range(len(points), len(points) + len(cell))])
        points += [(np.array(points[a]) + np.array(points[b])) / 2 for a, b in ends]
    return np.array(points), np.array(cells)


def test_second_order_cells_beside_plain_ones_are_straightened_not_dropped(tmp_path):
    """Two floats, the second of triangles of second order: both displace 32 m^3; half of it was left out."""
    (near, near_faces), (far, far_faces) = (barge.box(4.0, 4.0, 2.0, 2) for _ in range(2))
    triangles = np.concatenate([far_faces[:, :3], far_faces[:, [0, 2, 3]]]).tolist()
    far, cells = second_order(triangles, far + np.array([8.0, 0.0, 0.0]))
    points = np.concatenate([near, far])
    for kind, form in {"vtk": None, "vtu": None, "msh": "gmsh22"}.items():
        path = tmp_path / f"floats.{kind}"
        blocks = [("quad", near_faces), ("triangle6", cells + len(near))]
        meshio.Mesh(points, blocks).write(path, file_format=form)
        body = described(path)
        assert body.volume == pytest.approx(64.0)
        assert f"sides made straight: {len(cells)} triangle6" in body.history


def test_sides_that_were_curved_say_by_how_much(tmp_path):
    points, side, keel = cylinder()
    points, cells = second_order(side, points)
    lower = np.where(np.arange(len(points)) < 3 * N, 1.0, R / np.hypot(points[:, 0], points[:, 1]))
    points = points * np.column_stack([lower, lower, np.ones(len(points))])
    triangles = [[keel[0], a, b] for a, b in pairwise(keel[1:])]
    meshio.Mesh(points, [("quad8", cells), ("triangle", np.array(triangles))]).write(tmp_path / "hull.vtk")
    body = described(tmp_path / "hull.vtk")
    assert body.volume == pytest.approx(VOLUME, rel=1e-6)
    assert f"up to {R * (1 - np.cos(np.pi / N)):.2g} of the file's lengths off" in body.history


def test_the_inside_of_a_volume_is_left_out_and_a_volume_without_surface_is_refused(tmp_path):
    """GMSH's "save all" holds tetrahedra, too; a second body of these alone would vanish."""
    points = np.array([[0, 0, -1], [1, 0, -1], [0, 1, -1], [0.3, 0.3, -2.0]], dtype=float)
    surface, inside = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]], [[0, 1, 2, 3]]
    meshio.Mesh(points, [("triangle", surface), ("tetra", inside), ("vertex", [[0]])]).write(tmp_path / "one.vtk")
    assert read_mesh(tmp_path / "one.vtk").notes == (
        "left out, inside the surface: 1 tetra",
        "left out, no surface: 1 vertex",
    )
    both = [("triangle", surface), ("tetra", [*inside, [4, 5, 6, 7]])]
    meshio.Mesh(np.concatenate([points, points + 5.0]), both).write(tmp_path / "two.vtk")
    with pytest.raises(ConfigError, match=r"two.vtk: 1 cells of a volume, the first at \(5, 5, 4\), have no surface"):
        read_mesh(tmp_path / "two.vtk")
    meshio.Mesh(points, [("tetra", inside)]).write(tmp_path / "none.vtk")
    with pytest.raises(ConfigError, match=r"none.vtk: holds 1 tetra; needs the triangles or quadrilaterals"):
        read_mesh(tmp_path / "none.vtk")


def test_cells_a_library_skips_are_refused(tmp_path):
    """A strip of triangles beside a triangle: meshio leaves it out and goes on."""
    (tmp_path / "strip.vtu").write_text(
        '<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>'
        '<Piece NumberOfPoints="4" NumberOfCells="2"><Points><DataArray type="Float64" NumberOfComponents="3" '
        'format="ascii">0 0 0 1 0 0 1 1 -1 0 1 -1</DataArray></Points><Cells>'
        '<DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 0 1 2 3</DataArray>'
        '<DataArray type="Int64" Name="offsets" format="ascii">3 7</DataArray>'
        '<DataArray type="UInt8" Name="types" format="ascii">5 6</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>'
    )
    with pytest.raises(ConfigError, match=r"strip.vtu: holds cells of the kind 6 that are not understood"):
        read_mesh(tmp_path / "strip.vtu")


def test_polygons_are_cut_without_leaving_their_outline():
    """Areas add up; a corner along a straight side stays a corner, or its neighbours would leave a gap."""
    step = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], dtype=float)  # an L
    points = np.column_stack([step, 3 * step[:, 0] - step[:, 1]])
    triangles = triangulated(points)
    assert sorted(set(triangles.ravel())) == list(range(7))
    a, b, c = points[triangles].swapaxes(0, 1)
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(3.0)
    assert triangulated(points[[0, 3, 1, 6, 4]]) is None


def test_normals_are_turned_panel_by_panel_whatever_side_the_file_lists(tmp_path):
    """GMSH and CAD orient every surface of a hull on its own."""
    vertices, faces = barge.box(6.0, 4.0, 2.0, 2)
    some = np.random.default_rng(3).random(len(faces)) < 0.5
    turned = np.where(some[:, None], faces[:, ::-1], faces)
    moved = np.concatenate([vertices, vertices + np.array([9.0, 0.0, 0.0])])
    both = np.concatenate([faces[:, ::-1], turned + len(vertices)])
    outward = turned_outward(moved, both)
    area = np.cross(moved[outward[:, 2]] - moved[outward[:, 0]], moved[outward[:, 3]] - moved[outward[:, 1]]) / 2
    expected = (
        np.cross(vertices[faces[:, 2]] - vertices[faces[:, 0]], vertices[faces[:, 3]] - vertices[faces[:, 1]]) / 2
    )
    assert area == pytest.approx(np.concatenate([expected, expected]))
    meshio.Mesh(vertices, [("quad", turned)]).write(tmp_path / "box.vtk")
    body = described(tmp_path / "box.vtk")
    assert body.volume == pytest.approx(48.0)
    assert f"panels turned, as their normals pointed inward: {np.count_nonzero(some)} of" in body.history


@pytest.mark.parametrize(
    ("more", "factor"), [({"scale": 0.001}, 1e-3), ({"unit": "mm"}, 1e-3), ({"unit": "ft"}, 0.3048)]
)
def test_a_hull_in_another_unit_weighs_its_water(tmp_path, more, factor):
    points, side, keel = cylinder()
    body = described(obj(tmp_path / "hull.obj", points / factor, [*side, keel]), mesh=more)
    assert body.mass[0, 0] == pytest.approx(1025.0 * VOLUME, rel=1e-7)
    assert f"lengths of the mesh multiplied by {factor:g}" in body.history
    with pytest.raises(ConfigError, match=r"a hull .* m high with a draft of 0.01 m; needs metres, or the unit"):
        described(tmp_path / "hull.obj", mesh={"draft": 0.01})


def test_a_unit_is_one_of_length_and_not_beside_a_scale():
    raw = {"body": "b", "modes": ["Heave"], "mass": "displaced", "omega": [1.0]}
    with pytest.raises(ConfigError, match=r"mesh.*unit: received mm and scale 0.5; needs one of them"):
        validated(BodyFile, {**raw, "mesh": {"file": "a.stl", "scale": 0.5, "unit": "mm"}}, "b.yaml")
    with pytest.raises(ConfigError, match=r"b.yaml: mesh.*unit: received 'kg'"):
        validated(BodyFile, {**raw, "mesh": {"file": "a.stl", "unit": "kg"}}, "b.yaml")
    with pytest.raises(ConfigError, match="displacements in the file of modes are of the mesh as it is; needs metres"):
        validated(BodyFile, {"body": "b", "mesh": {"file": "a.nc", "unit": "mm"}, "modes": "a.nc", "omega": [1.0]}, "b")


@pytest.mark.parametrize("up", ["x", "y", "z", "-x", "-y", "-z"])
def test_a_hull_drawn_along_any_axis_from_any_origin_is_set_upright_at_its_draft(tmp_path, up):
    """Turned as a CAD program may have it, the hull is the same, to its centre of mass and its normals."""
    points, side, keel = cylinder()
    points = points + np.array([0.3, 0.0, 0.1 * T])  # neither centred nor symmetric
    axis = "xyz".index(up[-1])
    turned = np.roll(points, axis + 1, axis=1)  # z becomes the axis; a cyclic change keeps the hand
    if up[0] == "-":
        turned = turned * np.where(np.arange(3) == (axis + 1) % 3, 1, -1)  # half a turn about another axis
    hull = obj(tmp_path / "hull.obj", turned, [*side, keel])
    body = described(hull, mesh={"up": up, "draft": T})
    assert body.mass[0, 0] == pytest.approx(1025.0 * VOLUME, rel=1e-7)
    assert body.vertices[:, 2].min() == pytest.approx(-T)
    assert "turned, as their normals" not in body.history
    assert f"from -{T:.3g} to 0 m above still water" in body.history


@pytest.mark.parametrize("twice", [False, True])
def test_a_plate_without_thickness_is_named_before_the_edges_it_leaves_open(tmp_path, twice):
    points, side, keel = cylinder()
    # a disc without thickness around the keel, its panels given once or on both sides
    outer = points[2 * N :] * [2.0, 2.0, 1.0]
    quads = [[2 * N + j, 2 * N + (j + 1) % N, 3 * N + (j + 1) % N, 3 * N + j] for j in range(N)]
    points, disc = np.concatenate([points, outer]), quads + [quad[::-1] for quad in quads if twice]
    with pytest.raises(ConfigError, match=r"a plate without thickness, which is not solved"):
        described(obj(tmp_path / "spar.obj", points, [*side, keel, *disc]))


def test_a_wall_inside_a_hull_is_named(tmp_path):
    vertices, faces = barge.box(6.0, 4.0, 2.0, 1)
    keel = [i for i, v in enumerate(vertices) if v[0] == 0 and v[2] == -2.0]
    deck = [i for i, v in enumerate(vertices) if v[0] == 0 and v[2] == 0.0]
    wall = [min(deck, key=lambda i: vertices[i, 1]), *sorted(keel, key=lambda i: vertices[i, 1])]
    wall.append(max(deck, key=lambda i: vertices[i, 1]))
    with pytest.raises(ConfigError, match=r"panels, the first at \(0, .*\), enclose no volume"):
        described(obj(tmp_path / "box.obj", vertices, [*faces.tolist(), wall]))


def test_walls_of_two_bodies_that_coincide_are_refused_by_name(tmp_path):
    """A ring around a spar of its own inner radius: the panels of the ring's inner wall were dropped as given twice."""
    angle = 2 * np.pi * np.arange(N) / N

    def rings(places):
        return np.concatenate(
            [np.column_stack([r * np.cos(angle), r * np.sin(angle), 0 * angle + z]) for r, z in places]
        )

    def walls(count):
        j = np.arange(N)
        return np.concatenate(
            [
                np.stack([k * N + j, (k + 1) * N + j, (k + 1) * N + (j + 1) % N, k * N + (j + 1) % N], 1)
                for k in range(count)
            ]
        )

    spar, ring = rings([(3, 0), (3, -1), (3, -2), (3, -4), (1e-9, -4)]), rings([(5, 0), (5, -1), (3, -1), (3, 0)])
    vertices, faces = joined([(spar, walls(4)), (ring, walls(3))])
    shapes = np.zeros((2, len(vertices), 3))
    shapes[0, : len(spar), 2] = shapes[1, len(spar) :, 2] = 1.0
    path = tmp_path / "pair.nc"
    data = {"vertices": (("vertex", "xyz"), vertices), "faces": (("panel", "corner"), faces)}
    data |= {"mode_shape": (("dof", "vertex", "xyz"), shapes)}
    xr.Dataset(data, coords={"dof": ["spar__Heave", "ring__Heave"]}).to_netcdf(path)
    with pytest.raises(
        ConfigError, match=rf"{2 * N} panels lie on each other in pairs.*the walls of ring and spar coinc"
    ):
        build.read_body(path, path)


def test_a_corner_out_of_all_proportion_is_named(tmp_path):
    points, side, keel = cylinder()
    points[3] *= 1e12
    with pytest.raises(ConfigError, match=r"hull.obj: mesh: none of 34 panels has an area, seen from a corner at \("):
        described(obj(tmp_path / "hull.obj", points, [*side, keel]))


def test_a_hull_on_its_side_or_below_the_water_is_named(tmp_path):
    points, side, keel = cylinder()
    with pytest.raises(
        ConfigError, match=r"open along y = 0.*if y = 0 is its waterline it lies on its side: turn it by up: y"
    ):
        described(obj(tmp_path / "side.obj", points[:, [0, 2, 1]] * [1, 1, -1], [*side, keel]))
    with pytest.raises(
        ConfigError,
        match=r"lowest point at 0 m; needs .* move it down by its draught, of rigid hulls by mesh: {file: hull.stl, draft",
    ):
        described(obj(tmp_path / "keel.obj", points + np.array([0, 0, T]), [*side, keel]))


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("hull.step", "ISO-10303-21;", r"is a CAD model; needs a mesh of its surface: export it as STL"),
        ("hull.xyz", "1 2 3", r"received a name that ends in .xyz, no kind of mesh"),
        ("hull.off", "STOFF\n1 1 0", r"hull.off: states|cannot be read as a mesh"),
        ("hull.obj", "f 0 1 2", r"hull.obj:1: received 'f 0 1 2'; needs corners by their numbers"),
        ("hull.obj", "garbage", r"cannot be read as a mesh: holds no line of an OBJ"),
        ("hull.obj", "v 0 0 0\nsurf 0 1", r"hull.obj:2: received surf, a curved surface; needs polygons"),
        ("hull.gdf", "b\n1 9.81\n0 0\n3 1\n", r"hull.gdf:4: IGDEF: received 1, patches of a curved surface"),
        ("hull.gdf", "b\n1 9.81\n0 0\n3\n1 2 3", r"hull.gdf:4: NPAN: received 3, but 0 panels follow"),
        (
            "hull.vtk",
            "# vtk\na\nASCII\nDATASET POLYDATA\nLINES 1 3\n2 0 1",
            r"POLYDATA holds LINES; needs POLYGONS alone",
        ),
    ],
)
def test_what_is_no_mesh_is_told_in_a_line(tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(ConfigError, match=message):
        read_mesh(tmp_path / name)


LABELS = ("Heave", "Pitch")
BOX = barge.box(6.0, 4.0, 2.0, 1)


@pytest.fixture(scope="module")
def body():
    return made(*BOX, rigid(BOX[0])[[2, 4]], LABELS)


def text_of(rows):
    return "\n".join(" ".join(f"{value:.12g}" for value in row) for row in rows)


def numbered(rows):
    return text_of([[i + 1, *row] for i, row in enumerate(rows)])


def mesh_file(folder, name, panels=BOX):
    """Panels, those of the box by default, in a format of any program, by the name's end."""
    (vertices, faces), path, kind = panels, folder / name, name.split(".")[-1].lower()
    if kind == "gdf":
        path.write_text(f"box\n1.0 9.81\n0 0\n{len(faces)}\n{text_of(vertices[faces].reshape(-1, 3))}\n")
    elif kind in ("dat", "mar"):
        path.write_text(f"2 0\n{numbered(vertices)}\n0 0. 0. 0.\n{text_of(faces + 1)}\n0 0 0 0\n")
    elif kind == "hst":
        panels = f"PANEL TYPE 0\n{text_of(faces + 1)}\nENDPANEL\nENDFILE\n"
        path.write_text(f"COORDINATES\n{numbered(vertices)}\nENDCOORDINATES\n{panels}")
    elif kind == "nc":
        build.write_body(made(*BOX, rigid(BOX[0])[[2, 4]], LABELS), path)
    elif kind in ("stl", "off"):
        triangles = np.concatenate([faces[:, :3], faces[:, [0, 2, 3]]])
        meshio.Mesh(vertices, [("triangle", triangles)]).write(path)
    else:
        meshio.Mesh(vertices, [("quad", faces.astype(np.int32))]).write(path)
    return path


KINDS = ("gdf", "dat", "hst", "nc", "STL", "vtu", "ply", "msh")


@pytest.mark.parametrize("kind", KINDS)
def test_mesh_files_of_other_programs_give_the_same_body(tmp_path, body, kind):
    """Extensions in capitals and NEMOH's .dat, which is Tecplot's as well, among them."""
    vertices, faces, *_ = build.read_mesh(mesh_file(tmp_path, f"box.{kind}"))
    again = made(vertices, faces, rigid(vertices)[[2, 4]], LABELS)
    assert again.volumes == pytest.approx(body.volumes, rel=1e-6)
    assert again.triangles.area.sum(axis=0) == pytest.approx(body.triangles.area.sum(axis=0), abs=1e-4)


def written(tmp_path, body, **changes):
    """Modes file with some variables changed."""
    build.write_body(body, tmp_path / "box.nc")
    shape = np.array(body.shapes)
    data = {"mode_shape": (("dof", "vertex", "xyz"), shape), "centre_of_mass": ("xyz", body.centre_of_mass)}
    xr.Dataset(data | changes, coords={"dof": list(LABELS)}).to_netcdf(tmp_path / "modes.nc")
    return tmp_path / "box.nc", tmp_path / "modes.nc"


def test_a_modes_file_that_does_not_fit_is_refused_by_name(tmp_path, body):
    count = len(body.vertices)
    with pytest.raises(ConfigError, match=rf"modes.nc: mode_shape .*{count - 1}.*with {count} vertices"):
        build.read_body(*written(tmp_path, body, mode_shape=(("dof", "vertex", "xyz"), body.shapes[:, 1:])))
    plane = {"mode_shape": (("dof", "vertex", "xyz"), body.shapes[..., :2]), "centre_of_mass": ((), 0.0)}
    with pytest.raises(ConfigError, match=r"mode_shape \{.*'xyz': 2\}; needs \(dof, vertex, xyz\)"):
        build.read_body(*written(tmp_path, body, **plane))
    with pytest.raises(ConfigError, match=r"modes.nc: .*NaN"):
        build.read_body(*written(tmp_path, body, mode_shape=(("dof", "vertex", "xyz"), np.nan * body.shapes)))
    xr.Dataset({"shape": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc")
    with pytest.raises(ConfigError, match=r"other.nc: holds \['shape'\]; needs mode_shape"):
        build.read_body(tmp_path / "box.nc", tmp_path / "other.nc")
    (tmp_path / "text.nc").write_text("no netCDF")
    with pytest.raises(ConfigError, match=r"text.nc: cannot be read as netCDF"):
        build.read_body(tmp_path / "box.nc", tmp_path / "text.nc")


@pytest.mark.parametrize("name", ["none.vtu", "garbage.vtu", "garbage.stl", "garbage.gdf", "garbage.nc", "garbage.foo"])
def test_a_mesh_that_cannot_be_read_is_refused_in_one_line(tmp_path, name, capsys):
    if not name.startswith("none"):
        (tmp_path / name).write_text("garbage\n")
    with pytest.raises(
        ConfigError, match=rf"{name}: (mesh not found|cannot be read as a mesh|received a name that ends in .foo)"
    ) as error:
        build.read_mesh(tmp_path / name)
    assert "\n" not in str(error.value)


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
    vertices, faces, stated, notes = build.read_mesh(tmp_path / "mixed.vtk")
    assert vertices == pytest.approx(points)
    assert faces.tolist() == [[0, 3, 4, 1], [1, 4, 5, 5], [1, 5, 2, 2], [3, 6, 7, 4]]
    assert (stated, notes) == (4, ("left out, no surface: 1 line",))


LIBRARIES = re.compile("meshio|numpy|index|could not|NetCDF:|codec|literal|unpack|(?<!mode_)shape|buffer|array")


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


@pytest.mark.parametrize("kind", ["obj", "vtk", "vtp", "off", "ply", "msh", "gdf", "nc", "stl", "vtu", "modes.nc"])
def test_damaged_files_are_read_or_refused_in_one_line(tmp_path, kind, monkeypatch):
    """Eleven of each kind: no traceback, no warning, no words of a library, no end of memory or time."""
    monkeypatch.setattr(tool_files, "SECONDS", (1.0, 0.0))
    mesh, chance, (points, side, _) = mesh_file(tmp_path, "box.nc"), random.Random(kind), cylinder()
    path = tmp_path / f"hull.{kind}"
    if kind == "obj":
        obj(path, points, side, "{0}/1/1", "vt 0 0\nvn 0 0 1\n")
    elif kind == "vtk":
        polydata(path, "3.0", "ASCII", points, side)
    elif kind == "vtp":
        test_vtp_as_paraview_writes_surfaces_is_read(tmp_path)
    else:
        path = mesh if kind == "modes.nc" else mesh_file(tmp_path, f"box.{kind}")
    whole = path.read_bytes()
    for i in range(11):
        broken = tmp_path / f"broken{i}.{kind}"
        broken.write_bytes(damaged(whole, chance))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                build.read_body(mesh, broken) if kind == "modes.nc" else build.read_mesh(broken)
            except ConfigError as error:
                message = str(error)
                assert broken.name in message and len(message) < 700 and "\n" not in message  # noqa: PT018
                assert not LIBRARIES.search(message.replace(str(broken), "")), message


def test_matrices_and_centres_come_back_from_the_file(tmp_path):
    shapes = rigid(BOX[0])[[2, 4]]
    mass, stiffness = np.array([[3.0, 0.5], [0.5, 7.0]]), np.array([[30.0, 5.0], [5.0, 70.0]])
    for given in ({}, {"mass": mass, "stiffness": stiffness}):
        build.write_body(
            made(*BOX, shapes, LABELS, centre_of_mass=np.array([0.1, 0.2, 0.3]), **given), tmp_path / "b.nc"
        )
        again = build.read_body(tmp_path / "b.nc", tmp_path / "b.nc")
        assert again.centre_of_mass.tolist() == [0.1, 0.2, 0.3]
        assert (again.mass is None, again.stiffness is None) == (not given, not given)
    assert (again.mass.tolist(), again.stiffness.tolist()) == (mass.tolist(), stiffness.tolist())


def gdf(gravity=9.81, behind=""):
    """A box of five panels, as WAMIT writes it."""
    vertices, faces = barge.box(4.0, 2.0, 1.0, 1)
    rows = [" ".join(map(repr, point)) for point in vertices[faces].reshape(-1, 3).tolist()]
    return "\n".join(["box", f"1.0 {gravity}", "0 0", str(len(faces)), *rows]) + behind


def test_gdf_in_feet_is_scaled_where_its_displacements_are_made(tmp_path):
    """A box of 4 x 2 x 1 feet weighs its displaced water; GRAV of neither unit is refused."""
    (tmp_path / "feet.gdf").write_text(gdf(32.174))
    file = BodyFile(body="feet", mesh="feet.gdf", modes=["Heave"], mass="displaced", omega=[1.0])
    made = build_body(file, {"mesh": tmp_path / "feet.gdf"})
    assert made.mass[0, 0] == pytest.approx(1025.0 * 8 * 0.3048**3, rel=1e-9)
    assert "GRAV is in feet" in made.history
    (tmp_path / "feet.gdf").write_text(gdf(3.7))
    with pytest.raises(
        ConfigError, match=r"feet.gdf:2: GRAV: received 3.7; needs water.gravity, 9.81 m/s\^2, or that in"
    ):
        build_body(file, {"mesh": tmp_path / "feet.gdf"})


@pytest.mark.parametrize("kind", ["gdf", "mar", "hst", "vtu"])
def test_a_panel_given_twice_is_dropped_and_noted(tmp_path, kind):
    """In either direction, if the first is the right one."""
    vertices, faces = BOX
    for again in (np.roll(faces[:1], 1, axis=1), faces[:1, ::-1]):
        path = mesh_file(tmp_path, f"twice.{kind}", (vertices, np.concatenate([faces, again])))
        file = BodyFile(body="twice", mesh=path.name, modes=["Heave"], mass="displaced", omega=[1.0])
        made = build_body(file, {"mesh": path})
        assert f"panels without area or given twice dropped: 1 of {len(faces) + 1}" in made.history
        assert made.volume == pytest.approx(48.0)
    file = BodyFile(body="once", mesh=f"once.{kind}", modes=["Heave"], mass="displaced", omega=[1.0])
    assert "dropped" not in build_body(file, {"mesh": mesh_file(tmp_path, f"once.{kind}")}).history
