"""Mesh and modes files from anywhere: read, or refused in one line."""

import random
import re
import warnings

import meshio
import numpy as np
import pytest
import xarray as xr
from hydro.bodies.test_body import made, rigid

from examples import barge
from vsb.engine.hydro.bodies import files
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.build import build_body
from vsb.errors import ConfigError
from vsb.tools import files as tool_files

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
        files.write_body(made(*BOX, rigid(BOX[0])[[2, 4]], LABELS), path)
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
    vertices, faces, *_ = files.read_mesh(mesh_file(tmp_path, f"box.{kind}"))
    again = made(vertices, faces, rigid(vertices)[[2, 4]], LABELS)
    assert again.volumes == pytest.approx(body.volumes, rel=1e-6)
    assert again.triangles.area.sum(axis=0) == pytest.approx(body.triangles.area.sum(axis=0), abs=1e-4)


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


@pytest.mark.parametrize("name", ["none.vtu", "garbage.vtu", "garbage.stl", "garbage.gdf", "garbage.nc", "garbage.foo"])
def test_a_mesh_that_cannot_be_read_is_refused_in_one_line(tmp_path, name, capsys):
    if not name.startswith("none"):
        (tmp_path / name).write_text("garbage\n")
    with pytest.raises(
        ConfigError, match=rf"{name}: (mesh not found|cannot be read as a mesh|received a name that ends in .foo)"
    ) as error:
        files.read_mesh(tmp_path / name)
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
    vertices, faces, stated, notes = files.read_mesh(tmp_path / "mixed.vtk")
    assert vertices == pytest.approx(points)
    assert faces.tolist() == [[0, 3, 4, 1], [1, 4, 5, 5], [1, 5, 2, 2], [3, 6, 7, 4]]
    assert (stated, notes) == (4, ("left out, no surface: 1 line",))


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


@pytest.mark.parametrize("kind", ["gdf", "nc", "stl", "vtu", "modes.nc"])
def test_damaged_files_are_read_or_refused_in_one_line(tmp_path, kind, monkeypatch):
    """Ten of each kind: whatever other libraries make of them, no traceback, no warning, no end of memory or time."""
    monkeypatch.setattr(tool_files, "SECONDS", (1.0, 0.0))
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
                message = str(error)
                assert broken.name in message and len(message) < 700 and "\n" not in message  # noqa: PT018


def test_matrices_and_centres_come_back_from_the_file(tmp_path):
    shapes = rigid(BOX[0])[[2, 4]]
    mass, stiffness = np.array([[3.0, 0.5], [0.5, 7.0]]), np.array([[30.0, 5.0], [5.0, 70.0]])
    for given in ({}, {"mass": mass, "stiffness": stiffness}):
        files.write_body(
            made(*BOX, shapes, LABELS, centre_of_mass=np.array([0.1, 0.2, 0.3]), **given), tmp_path / "b.nc"
        )
        again = files.read_body(tmp_path / "b.nc", tmp_path / "b.nc")
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
