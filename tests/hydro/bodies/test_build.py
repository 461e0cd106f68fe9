"""Bodies of a mesh alone: rigid motions made here, and the mass of a mesh filled evenly."""

import math

import meshio
import numpy as np
import pytest
import xarray as xr

from vsb.engine.hydro.bodies.body import FlexibleBody, detected_symmetry
from vsb.engine.hydro.bodies.body_file import GIGABYTES, BodyFile, panel_count, solve_resources
from vsb.engine.hydro.bodies.build import build_body, write_body
from vsb.engine.hydro.bodies.hydrostatics import hydrostatic_stiffness
from vsb.engine.hydro.variables import RIGID
from vsb.errors import ConfigError
from vsb.keys.reading import validated

L, B, H, DRAUGHT = 6.0, 4.0, 3.0, 2.0  # m, of a box with a deck


def described(path, **changes) -> tuple[BodyFile, FlexibleBody]:
    """A body file of a mesh, and its body."""
    raw = {"body": "b", "mesh": path.name, "modes": "rigid", "omega": [1.0], **changes}
    file = validated(BodyFile, raw, "b.yaml")
    return file, build_body(file, {"mesh": path})


@pytest.fixture
def stl(tmp_path):
    """Function vertices, quadrilaterals -> STL of the triangles that have an area."""

    def write(vertices, faces):
        triangles = np.concatenate([faces[:, :3], faces[:, [0, 2, 3]]])
        corner = vertices[triangles]
        area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
        meshio.Mesh(vertices, [("triangle", triangles[area > 1e-9])]).write(tmp_path / "hull.stl")
        return tmp_path / "hull.stl"

    return write


def box():
    """Corners and sides, normals outward; the deck is the last."""
    x, y, z = (np.array([-1, 1, 1, -1] * 2) * L / 2, np.array([-1, -1, 1, 1] * 2) * B / 2, np.repeat([0.0, H], 4))
    sides = np.array([[3, 2, 1, 0], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]])
    return np.column_stack([x, y, z - DRAUGHT]), sides


def test_mass_of_a_box_filled_evenly(stl):
    """Inertia m (a^2 + b^2)/12 about the centre of mass, which is that of the box, deck included."""
    _, body = described(stl(*box()), density=700.0)
    m = 700.0 * L * B * H
    expected = m * np.array([1, 1, 1, (B**2 + H**2) / 12, (L**2 + H**2) / 12, (L**2 + B**2) / 12])
    assert body.labels == RIGID
    assert body.centre_of_mass == pytest.approx([0.0, 0.0, H / 2 - DRAUGHT], abs=1e-7)
    assert body.mass == pytest.approx(np.diag(expected), rel=1e-6, abs=1e-6 * m)
    assert body.volume == pytest.approx(L * B * DRAUGHT)
    assert "clipped at z = 0" in body.history
    pitch = body.modes[4] - np.cross([0, 1, 0], body.centres - body.centre_of_mass)
    assert np.abs(pitch).max() < 1e-6


def test_panels_that_face_inward_are_turned(stl):
    vertices, sides = box()
    _, body = described(stl(vertices, sides[:, ::-1]), density=700.0)
    assert "panels turned, as their normals pointed inward: 12 of 12" in body.history
    _, as_drawn = described(stl(vertices, sides), density=700.0)
    assert body.volume == pytest.approx(as_drawn.volume)
    assert body.mass == pytest.approx(as_drawn.mass, rel=1e-6, abs=1.0)


R, T = 2.0, 1.2  # radius and draft of round shapes [m]
SHAPES = {
    "sphere": ({"radius": R}, np.pi * T**2 * (R - T / 3), 4 / 3 * np.pi * R**3),
    "cylinder": ({"radius": R, "height": 3.0}, np.pi * R**2 * T, np.pi * R**2 * 3.0),
    "capsule": ({"radius": R, "height": 5.0}, np.pi * T**2 * (R - T / 3), np.pi * R**2 * (1 + 4 / 3 * R)),
    "box": ({"length": L, "width": B, "height": H}, L * B * T, L * B * H),
}


@pytest.mark.parametrize("kind", SHAPES)
def test_shapes_displace_and_hold_their_volumes(kind):
    """Symmetric in both planes, uncut at the waterline, Yaw only where it moves water."""
    sizes, displaced, whole = SHAPES[kind]
    raw = {"body": "b", "mesh": {"kind": kind, "draft": T, "panel": 0.2, **sizes}, "modes": "rigid", "omega": [1.0]}
    body = build_body(file := validated(BodyFile, {**raw, "density": 500.0}, "b.yaml"), {})
    assert file.paths == {}
    assert body.volume == pytest.approx(displaced, rel=5e-3)
    assert body.mass[0, 0] == pytest.approx(500.0 * whole, rel=5e-3)
    assert detected_symmetry(body) == "xOz+yOz"
    assert "0 of" in body.history
    assert body.labels == RIGID[: {"box": 6, "sphere": 3}.get(kind, 5)]
    with pytest.raises(ConfigError, match=r"mesh.panel: received 0.001 m, which makes .* panels; needs larger ones"):
        build_body(validated(BodyFile, {**raw, "mesh": {**raw["mesh"], "panel": 1e-3}}, "b.yaml"), {})


def test_displaced_mass_with_its_centre_and_radii(stl):
    """An open hull has the mass and metacentric height it is told."""
    vertices, sides = box()
    given = {"mass": "displaced", "centre_of_mass": [0.0, 0.0, -0.5], "radii_of_gyration": [1.5, 2.0, 2.2]}
    file, body = described(stl(vertices, sides[:-1]), modes=["Heave", "Pitch"], **given)
    m = file.water.density * L * B * DRAUGHT
    assert body.mass == pytest.approx(np.diag([m, m * 4.0]), rel=1e-6, abs=1e-6 * m)
    metacentric = -DRAUGHT / 2 + L**2 / 12 / DRAUGHT + 0.5
    stiffness = hydrostatic_stiffness(body, file.water.density, file.water.gravity)
    assert stiffness[1, 1] == pytest.approx(m * file.water.gravity * metacentric, rel=1e-6)


def test_sphere_hull_has_no_rotations_about_its_own_centre():
    """They move no water; its panels only nearly leave it at rest, which looks like a soft roll."""
    mesh = {"kind": "sphere", "radius": 2.0, "draft": 2.0, "panel": 1.0}
    raw = {"body": "b", "mesh": mesh, "modes": "rigid", "mass": "displaced", "omega": [1.0]}

    def built(**changes):
        return build_body(validated(BodyFile, {**raw, **changes}, "b.yaml"), {})

    assert built().labels == ("Surge", "Sway", "Heave")
    assert built(centre_of_mass=[0.0, 0.0, -1.0]).labels == ("Surge", "Sway", "Heave", "Roll", "Pitch")
    assert built(mass="1e3").mass[0, 0] == pytest.approx(1e3)


HULLS = {
    "sphere": {"kind": "sphere", "radius": 3.0, "draft": 2.5, "panel": 0.5},
    "cylinder": {"kind": "cylinder", "radius": 2.0, "height": 6.0, "draft": 4.0, "panel": 0.4},
    "capsule": {"kind": "capsule", "radius": 2.0, "height": 9.0, "draft": 5.0, "panel": 0.5},
    "box": {"kind": "box", "length": 8.0, "width": 4.0, "height": 3.0, "draft": 2.0, "panel": 0.5},
}


def body_file(mesh, **changes):
    return BodyFile.model_validate({"body": "own", "mesh": mesh, "modes": ["Heave"], "omega": [0.5, 1.0], **changes})


@pytest.mark.parametrize("hull", HULLS.values(), ids=HULLS)
def test_panels_of_plain_hulls_are_about_those_solved(hull):
    file = body_file(hull)
    solved = len(build_body(file, {}).faces)
    assert solved <= panel_count(file, {}) <= 2 * solved


def test_panels_of_files_are_bounded(tmp_path):
    """By a header or by the size of the file, neither too few nor by an order too many."""
    body = build_body(body_file(HULLS["box"]), {})
    n, corners = len(body.faces), body.vertices[body.faces].reshape(-1, 3)
    rows = "\n".join(" ".join(f"{x:.6f}" for x in point) for point in corners)
    (tmp_path / "box.gdf").write_text(f"a box\n1.0 9.81\n0 1\n{n}\n{rows}\n", encoding="utf-8")
    triangles = body.faces[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    meshio.write(tmp_path / "box.stl", meshio.Mesh(body.vertices, [("triangle", triangles)]), binary=True)
    meshio.write(tmp_path / "box.obj", meshio.Mesh(body.vertices, [("quad", body.faces)]))
    mesh = {"vertices": (("vertex", "xyz"), body.vertices), "faces": (("panel", "corner"), body.faces)}
    xr.Dataset(mesh).to_netcdf(tmp_path / "box.nc")
    write_body(body, tmp_path / "moved.nc")
    for name, panels in {"box.gdf": 2 * n, "box.stl": 2 * n, "box.obj": n, "box.nc": n, "moved.nc": n}.items():
        path = str(tmp_path / name)
        modes = {"modes": name} if name == "moved.nc" else {}
        found = panel_count(body_file(name, **modes), {"mesh": path, "modes": path})
        assert 0.5 * panels <= found <= 6 * panels, name
    assert panel_count(body_file("box.gdf"), {"mesh": str(tmp_path / "box.gdf")}) == 2 * n


def test_resources_grow_with_panels_frequencies_and_a_bottom():
    coarse, fine = (solve_resources(body_file({**HULLS["box"], "panel": p}), {}) for p in (0.4, 0.05))
    assert fine.megabytes > coarse.megabytes + 1e3 * GIGABYTES * 20_000**2 > 20_000
    assert solve_resources(body_file(HULLS["box"], water={"depth": 20.0}), {}).minutes >= coarse.minutes
    many = body_file({**HULLS["box"], "panel": 0.05}, omega=[0.5 + 0.02 * k for k in range(60)])
    assert 15 < solve_resources(many, {}).minutes / fine.minutes < 25
    assert solve_resources(body_file("unknown.stl"), {}).megabytes < 10_000
    assert math.isfinite(solve_resources(body_file({**HULLS["box"], "panel": 1e-3}), {}).minutes)
