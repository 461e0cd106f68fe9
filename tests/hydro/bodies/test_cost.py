"""Memory and time of jobs that solve bodies, from what is known of their panels."""

import math

import meshio
import pytest
import xarray as xr

from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.build import build_body
from vsb.engine.hydro.bodies.cost import GIGABYTES, panel_count, solve_resources
from vsb.engine.hydro.bodies.files import write_body

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
