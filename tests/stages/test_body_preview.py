"""Errors of a study of a body that are found before anything is solved."""

import re
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import error_line
from hydro.bodies.test_body import made, rigid
from hydro.bodies.test_solution import body_file
from stages.test_coefficients import SWELL, as_body

from examples import barge
from vsb.cli import main
from vsb.engine.hydro.bodies.build import write_body
from vsb.engine.hydro.database import stored_checks
from vsb.engine.hydro.panels.bem import quick_green_function
from vsb.engine.waves.kinds import RegularWave, StillWater
from vsb.errors import ConfigError, DatabaseError
from vsb.keys.reading import validated
from vsb.pipeline.graph import BodyPlan
from vsb.pipeline.plans import plan_of
from vsb.stages.body_preview import check, check_wave, drifting_motions, held_still, solved_lines, solving_seconds
from vsb.stages.coefficients import finely_solved
from vsb.study.body import BodyStudy, located
from vsb.tools.commands import HOME


def test_check_summarises_a_body_study(finished, workplace, capsys):
    Path("a.yaml").write_text(yaml.safe_dump(as_body(finished)))
    assert main(["check", "a.yaml"]) == 0
    lines = capsys.readouterr().out.splitlines()
    (body,) = (line for line in lines if line.startswith("body "))
    assert body.startswith("body         4 degrees of freedom: Heave, Membrane0,")
    assert body.endswith("FSB moves in 1, VSWEC moves in 4")
    assert any(re.search("hydro .* frequencies from .*, read from ", line) for line in lines)
    assert any("steepness" in line for line in lines)


def test_cost_of_a_body_is_that_of_its_mesh_and_symmetry_as_built():
    """The size of a mesh file bounds its panels alone, which would be many times that; measured 3.5 CPU-seconds."""
    assert 3.5 / 2 < solving_seconds(plan_of(str(HOME / "config" / "hinged_barge.yaml"))) < 2 * 3.5


def checked(finished, capsys, **changes):
    """The line of the error of a study."""
    Path("a.yaml").write_text(yaml.safe_dump(as_body(finished, **changes)))
    return error_line(["check", "a.yaml"], capsys)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"waves": [{**SWELL, "direction": 30.0}]}, "waves.0.direction: received 30 degrees, needs one of 0"),
        ({"waves": [{**SWELL, "period": 500.0}]}, "waves.0 regular_A0.1_T500: received a frequency of 0.01257 rad/s"),
        ({"designs": {"a": {"dofs": ["Roof"]}}}, "designs: received dofs Roof; needs some of Heave, Membrane0"),
        ({"pto": {"damping": 1.0, "port": {"dof": "Roof"}}}, "pto.port: received Roof; needs some of Heave"),
        (
            {"pto": {"damping": 1.0, "stiffness": -1e6}},
            "designs.FSB: the body is statically unstable: received a negative",
        ),
        ({"water": {"density": 1000.0}}, "water.density: received 1000, needs 1025, as the body's files have"),
        ({"body": {"database": "gone.nc"}}, "body.database: gone.nc cannot be read"),
        ({"waves": [{"kind": "still"}], "pto": {}}, "waves.0 still: still water has no optimal damping"),
    ],
)
def test_errors_of_a_body_study_are_reported_by_check(finished, workplace, capsys, changes, message):
    if "designs" in changes:
        changes = {"pto": {"damping": 1.0}, **changes}
    assert message in checked(finished, capsys, **changes)
    assert {path.name for path in Path().iterdir()} == {"file", "a.yaml"}


KNOWN = xr.Dataset(coords={"omega": [0.5, 1.0, 2.0], "wave_direction": [0.0, np.pi / 2]})


@pytest.mark.parametrize(
    ("wave", "refused"),
    [
        ({"kind": "still"}, None),
        ({"kind": "regular", "amplitude": 0.1, "period": np.pi, "direction": 90}, None),
        ({"kind": "regular", "amplitude": 0.1, "period": np.pi * (1 - 1e-6)}, "needs 0.5 to 2 rad/s, the band"),
        ({"kind": "regular", "amplitude": 0.1, "period": 5.0, "direction": 45}, "received 45 degrees, needs one of 0"),
        ({"kind": "white_noise", "hs": 0.1, "band": [0.4, 1.9]}, None),
        ({"kind": "white_noise", "hs": 0.1, "band": [0.6, 2.1]}, "a frequency of 2.1 rad/s"),
        ({"kind": "white_noise", "hs": 0.1, "band": [0.3, 0.49]}, "a frequency of 0.49 rad/s, needs 0.5 to 2 rad/s"),
    ],
)
def test_waves_must_lie_in_band_and_directions_of_the_database(wave, refused):
    """An irregular sea may begin below the band, where it is cut."""
    made = {"study": "a", "body": {"database": "-"}, "designs": {"a": {}}, "waves": [wave], "pto": {"damping": 1.0}}
    (sea,) = validated(BodyStudy, made, "a.yaml").waves
    with pytest.raises(ConfigError, match=f"waves.7.*{refused}") if refused else nullcontext():
        check_wave(7, sea, SimpleNamespace(database=KNOWN))


BOX = {"omega": [0.5, 0.8, 1.1, 1.4], "lid": 1}


@pytest.mark.parametrize(
    ("file", "hydro", "aside", "message"),
    [
        ({"omega": [1.0, 2.0, 3.0, 6.0]}, {}, 0.0, "omega: received 6 rad/s, whose waves are 1.71 m long"),
        (
            {"water": {"depth": 2.0}, "omega": [0.7, 0.9]},
            {},
            0.0,
            "Heave lifts the foot of a hull that stands on the sea bed, at z = -2 m",
        ),
        ({"symmetry": "xOz"}, {}, 5.0, "symmetry xOz: the panels are not mirrored in the xOz plane"),
        ({}, {"repair": ["kramers_kronig"]}, 0.0, "hydro.repair: kramers_kronig needs 10 frequencies, received 4"),
    ],
)
def test_errors_of_a_mesh_are_reported_before_solving(tmp_path, file, hydro, aside, message):
    vertices, faces = barge.box(30.0, 10.0, 2.0, 1)
    plan = of_a_box(tmp_path, vertices + np.array([0.0, aside, 0.0]), faces, 1.0, file, hydro)
    with pytest.raises(ConfigError, match=re.escape(message)):
        check(plan)
    assert not Path(plan.root).exists()


def of_a_box(folder, vertices, faces, mass, file=None, hydro=None, own=None):
    """The plan of a study of a box in heave, with a mass in its file and optionally one in the study."""
    box = made(vertices, faces, rigid(vertices)[2:3], ("Heave",), mass=mass * np.eye(1))
    write_body(box, folder / "box.nc")
    raw = {"body": "box", "mesh": "box.nc", "modes": "box.nc", **BOX, **(file or {})}
    (folder / "box.yaml").write_text(yaml.safe_dump(raw))
    whole = {"file": "box.yaml"} | ({"mass": {"Heave": own}} if own else {})
    study = {"study": "a", "body": whole, "designs": {"a": {}}, "hydro": hydro or {}, "pto": {"damping": 1.0}}
    found = located(study | {"waves": [{"kind": "still"}]}, str(folder / "a.yaml"))
    return BodyPlan(found.study, root=str(folder / "results"), files=found.files)


SALT = 1025.0 * 30.0 * 10.0 * 2.0


@pytest.mark.parametrize(
    ("held", "own", "missed"),
    [(SALT, None, 0.0), (0.9 * SALT, None, 0.1), (0.5 * SALT, SALT, 0.0), (1e-3, 1.2 * SALT, 0.2)],
)
def test_mass_must_equal_that_of_the_displaced_water(tmp_path, held, own, missed):
    """That of the file, or of the study where it gives its own."""
    plan = of_a_box(tmp_path, *barge.box(30.0, 10.0, 2.0, 1), held, own=own)
    refused = rf"check 'displaced_mass' failed: {missed:g}, needs at most 0.01 \(.*\); correct the mass, or how deep the mesh lies"
    with pytest.raises(DatabaseError, match=refused) if missed else nullcontext():
        check(plan)
    check(of_a_box(tmp_path, *barge.box(30.0, 10.0, 2.0, 1), held, hydro={"accept": ["displaced_mass"]}, own=own))


def test_body_whose_mass_lies_beside_its_buoyancy_does_not_rest_upright(tmp_path):
    """Not a negative stiffness of yaw, which couples with the moment of weight and buoyancy."""
    hull = {"kind": "box", "length": 8.0, "width": 4.0, "height": 3.0, "draft": 1.5, "panel": 2.0}
    own = {"body": "box", "mesh": hull, "modes": "rigid", "mass": "displaced", "centre_of_mass": [0.4, 0.1, 0.0], **BOX}
    study = {"study": "a", "body": {"file": own}, "designs": {"a": {}}, "waves": [{"kind": "still"}]}
    found = located(study | {"pto": {"damping": 1.0}}, str(tmp_path / "a.yaml"))
    with pytest.raises(
        ConfigError, match=r"designs\.a: the body is not in equilibrium upright: .* 0\.11 of the cube root"
    ):
        check(BodyPlan(found.study, root=str(tmp_path), files=found.files))


@pytest.mark.parametrize(
    ("loose", "direction", "named"),
    [
        ([[1, 0], [0, 1], [0, 0]], 0.0, ["Surge"]),  # nothing moored
        ([[1, 0], [0, 1], [0, 0]], 30.0, ["Surge", "Sway"]),
        ([[0], [1], [0]], 0.0, []),  # surge moored: waves along it do not push to the side
        ([[1], [-1], [0]], 0.0, ["Surge", "Sway"]),  # free across one line
        ([[0], [0], [1]], 0.0, []),
        (np.empty((3, 0)), 0.0, []),
    ],
)
def test_a_body_drifts_where_waves_push_and_nothing_holds(loose, direction, named):
    waves = [StillWater(kind="still"), RegularWave(kind="regular", amplitude=0.1, period=5.0, direction=direction)]
    assert drifting_motions(["Surge", "Sway", "Yaw"], np.array(loose, dtype=float), waves) == named
    assert drifting_motions(["Surge", "Sway", "Yaw"], np.array(loose, dtype=float), waves[:1]) == []


def test_check_makes_coarse_panels_smaller_as_the_run_does(tmp_path):
    """A run that would be refused on smaller panels, too, is not let pass."""
    file = body_file(omega=[1.0, 2.0, 3.0, 3.4], mass="displaced")
    raw = {"study": "ball", "body": {"file": file.model_dump(exclude_none=True)}, "designs": {"a": {}},
           "pto": {"port": {"dof": "Heave"}}, "waves": [{"kind": "regular", "amplitude": 0.1, "period": 4.0}]}  # fmt: skip
    found = located(raw, str(tmp_path / "ball.yaml"))
    plan = BodyPlan(found.study, root=str(tmp_path), files=found.files)
    line, *doubts = solved_lines(plan, file, check(plan).mesh)
    run = finely_solved(file, (), {}, str(tmp_path / "run"), green=quick_green_function())
    smaller = [part for part in run.attrs["history"].split("; ") if part.startswith("panels made smaller")]
    assert smaller
    assert line == f"doubt        panels: as given they fail; in the run {'; '.join(smaller)}; 4 frequencies tried"
    kept = {one.name for one in stored_checks(run) if one.verdict == "doubt"}
    assert {re.match(r"doubt +hydro (\S+) =", doubt)[1] for doubt in doubts} == kept - {"panels"}


def test_too_few_frequencies_are_refused_in_words_of_the_file(tmp_path):
    raw = {"study": "ball", "body": {"file": body_file().model_dump(exclude_none=True)}, "designs": {"a": {}},
           "pto": {"port": {"dof": "Heave"}}, "waves": [{"kind": "regular", "amplitude": 0.1, "period": 4.0}]}  # fmt: skip
    found = located(raw, str(tmp_path / "ball.yaml"))
    with pytest.raises(ConfigError, match=r"^body: received 2 of 2 frequencies of the database above zero; needs 4 or"):
        check(BodyPlan(found.study, root=str(tmp_path), files=found.files))


def test_stiffness_far_above_the_band_is_doubted():
    """A motion of 1 kg with 1e5 times the stiffness that gives it the end of the band; none without mass."""
    database = xr.Dataset(coords={"omega": [1.0, 2.0]})
    body = SimpleNamespace(labels=("Heave", "Pitch"), mass=np.diag([1.0, 0.0]), database=database)
    assert held_still(SimpleNamespace(**vars(body), stiffness=4e5 * np.eye(2))) == [("Heave", 4e5)]
    assert held_still(SimpleNamespace(**vars(body), stiffness=4e3 * np.eye(2))) == []
