"""Databases of bodies from their files: verdicts, interrupted runs, wrong files, panels that are too coarse."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
import yaml
from hydro.bodies.test_body import made, rigid

from examples import barge
from vsb.engine.hydro import database
from vsb.engine.hydro.bodies import build as bodyfiles
from vsb.engine.hydro.bodies import solution as bodystudy
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.bodies.build import build_body
from vsb.engine.hydro.bodies.solution import refined_file
from vsb.engine.hydro.bodies.solver import BodyProblem, CoarserBody
from vsb.engine.hydro.database import Check
from vsb.engine.hydro.panels.bem import quick_green_function
from vsb.errors import ConfigError
from vsb.keys.quantities import content_id
from vsb.stages.coefficients import finely_solved
from vsb.study import resolution as blocks
from vsb.tools.files import load

LABELS = ("Heave", "Pitch", "Bend")


@pytest.fixture(scope="module")
def body():
    vertices, faces = barge.box(6.0, 4.0, 2.0, 1)
    bend = np.zeros_like(vertices)
    bend[:, 2] = (vertices[:, 0] / 3.0) ** 2
    shapes = np.concatenate([rigid(vertices)[[2, 4]], bend[None]])
    mass = np.diag([1025.0 * 48.0, 1e5, 1e4])
    return made(vertices, faces, shapes, LABELS, mass=mass, stiffness=np.diag([0.0, 0.0, 1e6]))


def files(folder, body, **changes):
    """A body file and what it names, in one folder."""
    bodyfiles.write_body(body, folder / "box.nc")
    raw = {
        "body": "box",
        "mesh": "box.nc",
        "modes": "box.nc",
        "omega": [1.0, 1.3],
        "wave_direction": [0.0, 30.0],
        "lid": 1,
    }
    (folder / "box.yaml").write_text(yaml.safe_dump(raw | changes))
    return folder / "box.yaml"


@pytest.fixture
def calls(monkeypatch):
    """Frequencies solved, as they are solved."""
    solved = []
    monkeypatch.setattr(BodyProblem, "solve", counted(BodyProblem.solve, solved))
    monkeypatch.setattr(BodyProblem, "at_infinity", counted(BodyProblem.at_infinity, solved))
    return solved


def counted(method, solved):
    def call(self, *args):
        if not isinstance(self.body, CoarserBody):
            solved.append(args[0] if args else np.inf)
        return method(self, *args)

    return call


def test_body_file_gives_a_database_with_its_verdict(tmp_path, body, green_folder):
    water = {"density": 1000.0, "gravity": 9.8}
    checks = bodystudy.run(files(tmp_path, body, water=water), tmp_path / "out", green_folder)
    names = {"error_estimate", "symmetry", "far_field", "haskind", "positive_damping", "panels", "corners"}
    names |= {"rigid_names", "one_resolution", "second_order", "displaced_mass", "modes", "trim", "mass_coupling"}
    assert {check.name for check in checks} == names
    ds = load(tmp_path / "out/box.nc")
    assert database.stored_checks(ds) == checks
    assert database.load_database(tmp_path / "out/box.nc", ds.attrs["spec_id"]).attrs["symmetry"] == "xOz+yOz"
    assert list(ds.influenced_dof.values) == list(LABELS)
    assert ds.wave_direction.values == pytest.approx(np.deg2rad([0.0, 30.0]))
    assert ds.excitation_force.values == pytest.approx((ds.Froude_Krylov_force + ds.diffraction_force).values)
    for name in ("added_mass", "radiation_damping", "added_mass_inf", "hydrostatic_stiffness", "structural_stiffness"):
        assert ds[name].values == pytest.approx(ds[name].values.swapaxes(-1, -2), rel=1e-12, abs=1e-6), name
    assert ds.inertia_matrix.values == pytest.approx(body.mass)
    attrs = {"water_density": 1000.0, "gravity": 9.8, "water_depth": "inf", "symmetry": "xOz+yOz", "separate_sweep": 0}
    attrs |= {"solves": 2, "frequencies": 2, "solver": blocks.panel_solver(), "Conventions": "CF-1.8"}
    attrs |= {"title": f"hydro database of box: {len(body.faces)} panels, 3 degrees of freedom"}
    assert {name: ds.attrs[name] for name in attrs} == attrs
    assert ds.attrs["displaced_volume"] == pytest.approx(6.0 * 4.0 * 2.0)
    assert ds.attrs["centre_of_buoyancy"] == pytest.approx([0.0, 0.0, -1.0], abs=1e-9)
    assert float(ds.hydrostatic_stiffness[0, 0]) == pytest.approx(1000.0 * 9.8 * 6.0 * 4.0)
    assert ds.structural_stiffness.values == pytest.approx(np.diag([0.0, 0.0, 1e6]))
    spec, solved = json.loads(ds.attrs["spec"]), {path.stem: load(path) for path in tmp_path.glob("out/blocks/*.nc")}
    order = {"inf" if "omega" not in block.dims else float(block.omega[0]): name for name, block in solved.items()}
    assert spec["blocks"] == [order["inf"], order[1.0], order[1.3]]
    assert len(solved) == 3
    assert ds.attrs["bem_seconds"] == pytest.approx(sum(block.attrs["seconds"] for block in solved.values()), rel=1e-12)
    assert all(block.attrs["seconds"] > 0 for block in solved.values())
    assert ds.attrs["spec_id"] == content_id(spec)


def test_interrupted_run_continues_without_solving_twice(tmp_path, body, green_folder, calls, monkeypatch):
    config, out = files(tmp_path, body), tmp_path / "out"
    save = bodystudy.save

    def killed(ds, *args):
        if "omega" in ds.dims and float(ds.omega[0]) == 1.3:
            raise KeyboardInterrupt
        save(ds, *args)

    monkeypatch.setattr(bodystudy, "save", killed)
    with pytest.raises(KeyboardInterrupt):
        bodystudy.run(config, out, green_folder)
    assert not (out / "box.nc").exists()
    monkeypatch.setattr(bodystudy, "save", save)
    calls.clear()
    (block, *_) = [path for path in (out / "blocks").glob("*.nc") if "omega" in load(path).dims]
    block.write_bytes(block.read_bytes()[:200])  # cut short: solved again
    bodystudy.run(config, out, green_folder)
    assert calls == [1.0, 1.3]
    bodystudy.run(files(tmp_path, body, omega=[1.0, 1.15, 1.3], symmetry="none"), out, green_folder)
    assert calls == [1.0, 1.3, 1.15]
    assert list(load(out / "box.nc").omega.values) == [1.0, 1.15, 1.3]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"omega": []}, "needs at least one value"),
        ({"omega": [2.0, 1.0]}, "ascending without repetition"),
        ({"omega": [0.05], "water": {"depth": 10.0}}, "omega 0.05 rad/s: in 10 m of water needs at least"),
        ({"omega": [3.0], "water": {"depth": 0.9}}, "water.depth: received 0.9 m, less than the body's draught"),
        ({"symmetry": "xyz"}, "symmetry"),
        ({"lid": True}, "a number is needed"),
        ({"omega": [1e300]}, "omega.0: received 1e[+]300; needs a number of at most 1000"),
        ({"omega": [1.0, 400.0]}, "omega: received 400 rad/s, whose waves are 0.000385 m long and the largest panel"),
        ({"symmetry": "xOz", "mesh": "off.nc", "modes": "off.nc"}, "not mirrored in the xOz plane"),
        ({"mode": "x.nc"}, "unknown key"),
        ({"mesh": "gone.vtu"}, "gone.vtu: mesh not found"),
    ],
)
def test_wrong_body_files_are_refused_in_one_line(tmp_path, body, changes, message):
    bodyfiles.write_body(made(body.vertices + np.array([0.0, 0.2, 0.0]), body.faces, body.shapes), tmp_path / "off.nc")
    with pytest.raises(ConfigError, match=message) as error:
        bodystudy.run(files(tmp_path, body, **changes), tmp_path / "out")
    assert "\n" not in str(error.value)
    assert not (tmp_path / "out").exists()


def test_centre_of_buoyancy_of_a_sheared_body_off_the_origin(body):
    vertices = body.vertices + np.array([3.0, -2.0, 0.0])
    wedge = vertices.copy()
    wedge[:, 1] += 0.5 * vertices[:, 2]  # sheared: its centre moves by half a metre to the side
    facts = bodystudy._at_rest(made(wedge, body.faces, rigid(wedge)[[2]], ("Heave",)))
    assert facts["centre_of_buoyancy"] == pytest.approx([3.0, -2.5, -1.0], abs=1e-9)
    assert facts["displaced_volume"] == pytest.approx(48.0)


SPHERE = {"kind": "sphere", "radius": 3.0, "draft": 3.0, "panel": 1.4}
FAILED = Check("error_estimate", 0.5, 0.05, "-", "fail", "")


def body_file(**changes):
    """A body file of a coarse sphere, up to beyond its first irregular frequency."""
    given = {"body": "ball", "mesh": SPHERE, "modes": ["Heave"], "omega": [1.0, 3.4]}
    return BodyFile.model_validate(given | changes)


def test_panels_of_a_hull_become_smaller_by_no_more_than_a_half():
    """Errors fall at least in proportion to the panels: a tenth of the error would need a tenth of them, step by step."""
    file = body_file()
    body = build_body(file, {})
    assert refined_file(file, body, [FAILED]).mesh.panel == pytest.approx(0.7)
    assert refined_file(file, body, [replace(FAILED, value=0.06)]).mesh.panel == pytest.approx(1.4 * 0.8 / 1.2)
    assert refined_file(file, body, [replace(FAILED, verdict="doubt")]) is None


@pytest.mark.parametrize("changes", [{"lid": 0}, {"mesh": {**SPHERE, "panel": 0.18}}])
def test_panels_stay_where_smaller_ones_do_not_help_or_cost_too_much(changes):
    """Irregular frequencies without a lid are there on any mesh."""
    file = body_file(**changes)
    assert refined_file(file, build_body(file, {}), [FAILED]) is None


def test_a_coarse_sphere_is_solved_on_smaller_panels(tmp_path):
    """64 panels of half a radius fail at 3.4 rad/s; the database says what was changed and why."""
    found = finely_solved(body_file(), (), {}, str(tmp_path), green=quick_green_function())
    assert "panels made smaller, to 0.7 m from 1.4 m, because of error_estimate" in found.attrs["history"]
    assert not [check for check in database.stored_checks(found) if check.verdict == "fail"]


def test_resonance_of_enclosed_water_is_named_apart_from_resolution(tmp_path):
    """Inside a ring the water heaves like a piston near 1.6 rad/s, where finer panels change little."""
    path = tmp_path / "ring.obj"
    path.write_text(ring(24, 12, radius=6.0, tube=1.5))
    file = body_file(mesh="ring.obj", omega=[0.5, 0.9, 1.1, 1.3, 1.5, 1.7, 1.9, 2.3])
    found = finely_solved(file, ("error_estimate",), {"mesh": str(path)}, str(tmp_path), green=quick_green_function())
    checks = {check.name: check for check in database.stored_checks(found)}
    assert checks["resonance"].verdict == "doubt"
    assert "Heave at about 1.6 rad/s" in checks["resonance"].explanation
    assert checks["error_estimate"].value < 0.5 * checks["resonance"].value


def ring(around, about, radius, tube):
    """A ring of round section as OBJ, normals outward, no corner in still water."""
    lines = []
    for i in range(around):
        for j in range(about):
            theta, phi = 2 * math.pi * i / around, 2 * math.pi * (j + 0.5) / about
            r = radius + tube * math.cos(phi)
            lines.append(f"v {r * math.cos(theta):.9g} {r * math.sin(theta):.9g} {tube * math.sin(phi):.9g}")
    for i in range(around):
        for j in range(about):
            corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            lines.append("f " + " ".join(str(a % around * about + b % about + 1) for a, b in corners))
    return "\n".join(lines) + "\n"
