"""What is said of a study of a body before anything is solved."""

import re
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import told
from hydro.bodies.test_body import made, rigid
from stages.test_coefficients import SWELL, as_body

from examples import barge
from vsb.cli import main
from vsb.errors import ConfigError, DatabaseError
from vsb.hydro.bodies.files import write_body
from vsb.stages import body_preview
from vsb.stages.body_preview import body_before_run, body_summary, check_stored, check_wave
from vsb.study.body import BodyStudy, located
from vsb.study.body_plan import BodyPlan
from vsb.study.canonical import content_id
from vsb.study.reading import validated


def checked(finished, capsys, **changes):
    """The one line in which a study is refused."""
    Path("a.yaml").write_text(yaml.safe_dump(as_body(finished, **changes)))
    return told(["check", "a.yaml"], capsys)


def test_a_summary_tells_what_moves_and_where_numbers_come_from(finished, workplace, capsys):
    Path("a.yaml").write_text(yaml.safe_dump(as_body(finished)))
    assert main(["check", "a.yaml"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].startswith("body         4 degrees of freedom: Heave, Membrane0,")
    assert lines[1].endswith("FSB moves in 1, VSWEC moves in 4")
    assert "frequencies from" in lines[2]
    assert "read from" in lines[2]
    assert any("steepness" in line for line in lines)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"waves": [{**SWELL, "direction": 30.0}]}, "waves.0.direction: received 30 degrees, needs one of 0"),
        ({"waves": [{**SWELL, "period": 500.0}]}, "waves.0 regular_A0.1_T500: received a frequency of 0.01257 rad/s"),
        ({"designs": {"a": {"dofs": ["Roof"]}}}, "designs: received dofs Roof; needs some of Heave, Membrane0"),
        ({"pto": {"damping": 1.0, "port": {"dof": "Roof"}}}, "pto.port: received Roof; needs some of Heave"),
        ({"pto": {"damping": 1.0, "stiffness": -1e6}}, "designs.FSB: the body does not rest: received a negative"),
        ({"water": {"density": 1000.0}}, "water.density: received 1000, needs 1025, as the body's files have"),
        ({"body": {"database": "gone.nc"}}, "body.database: gone.nc cannot be read"),
        ({"waves": [{"kind": "still"}], "pto": {}}, "waves.0 still: no damper is best where nothing comes in"),
    ],
)
def test_what_would_fail_later_is_refused_in_one_line(finished, workplace, capsys, changes, message):
    if "designs" in changes:
        changes = {"pto": {"damping": 1.0}, **changes}
    assert message in checked(finished, capsys, **changes)
    assert {path.name for path in Path().iterdir()} == {"file", "a.yaml"}


@pytest.mark.parametrize("stored", ["database_path", "radiation_path"])
def test_a_stored_result_a_run_would_go_on_from_is_read_by_the_check(finished, workplace, capsys, stored):
    """One that is damaged is told now, not after all before it was computed."""
    Path("a.yaml").write_text(yaml.safe_dump(as_body(finished)))
    found = located(as_body(finished), "a.yaml")
    path = Path(getattr(BodyPlan(found.study, files=found.files), stored))
    path.parent.mkdir(parents=True)
    path.write_bytes(b"half")
    assert told(["check", "a.yaml"], capsys).startswith(f"{path}: ")


KNOWN = xr.Dataset(coords={"omega": [0.5, 1.0, 2.0], "wave_direction": [0.0, np.pi / 2]})


@pytest.mark.parametrize(
    ("wave", "refused"),
    [
        ({"kind": "still"}, None),
        ({"kind": "regular", "amplitude": 0.1, "period": 4 * np.pi}, None),
        ({"kind": "regular", "amplitude": 0.1, "period": np.pi, "direction": 90}, None),
        ({"kind": "regular", "amplitude": 0.1, "period": np.pi * (1 - 1e-6)}, "needs 0.5 to 2 rad/s, the band"),
        (
            {"kind": "regular", "amplitude": 0.1, "period": 4 * np.pi * (1 + 1e-6)},
            "a frequency of 0.5 rad/s, needs 0.5",
        ),
        (
            {"kind": "regular", "amplitude": 0.1, "period": 5.0, "direction": 45},
            "received 45 degrees, needs one of 0, 90",
        ),
        (
            {"kind": "regular", "amplitude": 0.1, "period": 5.0, "direction": -90},
            "received -90 degrees, needs one of 0, 90",
        ),
        ({"kind": "white_noise", "hs": 0.1, "band": [0.4, 1.9]}, None),
        ({"kind": "white_noise", "hs": 0.1, "band": [0.6, 2.1]}, "a frequency of 2.1 rad/s"),
        ({"kind": "white_noise", "hs": 0.1, "band": [0.3, 0.51]}, None),
        ({"kind": "white_noise", "hs": 0.1, "band": [0.3, 0.49]}, "a frequency of 0.49 rad/s, needs 0.5 to 2 rad/s"),
    ],
)
def test_seas_lie_in_the_band_and_the_directions_of_a_bodys_database(wave, refused):
    """Ends of the band are of it; of an irregular sea what lies below is cut, unless it is all of it."""
    made = {"study": "a", "body": {"database": "-"}, "designs": {"a": {}}, "waves": [wave], "pto": {"damping": 1.0}}
    (sea,) = validated(BodyStudy, made, "a.yaml").waves
    with pytest.raises(ConfigError, match=f"waves.7.*{refused}") if refused else nullcontext():
        check_wave(7, sea, SimpleNamespace(database=KNOWN))


BOX = {"omega": [0.5, 0.8, 1.1, 1.4], "lid": 1}


@pytest.mark.parametrize(
    ("file", "hydro", "aside", "sunk", "message"),
    [
        ({"omega": [1.0, 2.0, 3.0, 6.0]}, {}, 0.0, 0.0, "omega: received 6 rad/s, whose waves are 1.71 m long"),
        (
            {"water": {"depth": 2.0}, "omega": [0.7, 0.9, 1.1, 1.3]},
            {},
            0.0,
            0.0,
            "water.depth: received 2 m, needs more than the body's draught of 2 m",
        ),
        ({"symmetry": "xOz"}, {}, 5.0, 0.0, "symmetry xOz: the panels are not mirrored in the xOz plane"),
        ({}, {}, 0.0, 5.0, "lid: the body does not cross the water's surface; needs lid: 0"),
        ({}, {"repair": ["kramers_kronig"]}, 0.0, 0.0, "hydro.repair: kramers_kronig needs 10 frequencies, received 4"),
    ],
)
def test_what_a_mesh_shows_is_refused_before_it_is_solved(tmp_path, file, hydro, aside, sunk, message):
    """All that `vsb body` would refuse before its first frequency."""
    vertices, faces = barge.box(30.0, 10.0, 2.0, 1)
    if sunk:
        faces = np.concatenate([faces, faces[:, ::-1] + len(vertices)])
        vertices = np.concatenate([vertices, vertices * [1, 1, -1]]) - np.array([0.0, 0.0, sunk])
    plan = of_a_box(tmp_path, vertices + np.array([0.0, aside, 0.0]), faces, 1.0, file, hydro)
    with pytest.raises(ConfigError, match=re.escape(message)):
        body_before_run(plan)
    assert not Path(plan.root).exists()


def of_a_box(folder, vertices, faces, mass, file=None, hydro=None, own=None):
    """The plan of a study of a box that heaves, with a mass in its file and perhaps one of the study's own."""
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
    [
        (SALT, None, 0.0),
        (0.9 * SALT, None, 0.1),
        (SALT, 0.9 * SALT, 0.1),
        (0.5 * SALT, SALT, 0.0),
        (1e-3, 1.2 * SALT, 0.2),
    ],
)
def test_the_mass_a_study_moves_is_that_of_the_water_it_displaces(tmp_path, held, own, missed):
    """Of the file, or of the study where it gives its own: tonnes for kilograms are seen before anything is solved."""
    plan = of_a_box(tmp_path, *barge.box(30.0, 10.0, 2.0, 1), held, own=own)
    refused = (
        rf"check 'afloat' failed: {missed:g}, needs at most 0.01 \(.*\); correct the mass, or how deep the mesh lies"
    )
    with pytest.raises(DatabaseError, match=refused) if missed else nullcontext():
        body_before_run(plan)
    body_before_run(of_a_box(tmp_path, *barge.box(30.0, 10.0, 2.0, 1), held, hydro={"accept": ["afloat"]}, own=own))


def test_a_stroke_counts_from_where_something_holds_the_port(tmp_path):
    """A mooring or the take-off's own spring; what is not held where it drifts is none either."""
    vertices, faces = barge.box(30.0, 10.0, 2.0, 1)
    shapes = rigid(vertices)[[0, 2]]
    box = made(vertices, faces, shapes, ("Surge", "Heave"), mass=SALT * np.eye(2))
    write_body(box, tmp_path / "box.nc")
    (tmp_path / "box.yaml").write_text(yaml.safe_dump({"body": "box", "mesh": "box.nc", "modes": "box.nc", **BOX}))

    def check(port, moored=0.0, spring=0.0, **design):
        pto = {"damping": 1.0, "port": {"dof": port}, "law": "coulomb", "force_limit": 1.0, "stroke_limit": 2.5}
        study = {
            "study": "a",
            "body": {"file": "box.yaml", "stiffness": {"Surge": moored}},
            "waves": [{"kind": "still"}],
        }
        study |= {"designs": {"free": design}, "pto": pto | {"stiffness": spring}}
        found = located(study, str(tmp_path / "a.yaml"))
        body_before_run(BodyPlan(found.study, root=str(tmp_path / "results"), files=found.files))

    with pytest.raises(
        ConfigError, match=r"pto.stroke_limit: received 2.5 m, but nothing holds the port of design free"
    ):
        check("Surge")
    check("Heave")
    check("Surge", moored=1e3)
    check("Surge", spring=1e3)
    check("Surge", held=[{"Surge": 1.0}])


def test_a_mode_without_mass_has_that_of_the_water_it_moves(tmp_path):
    """As a membrane's."""
    vertices, faces = barge.box(30.0, 10.0, 2.0, 1)
    bend = np.zeros_like(vertices)
    bend[:, 2] = (vertices[:, 0] / 15.0) ** 2
    shapes, matrices = (
        np.array([rigid(vertices)[2], bend]),
        {"mass": np.diag([SALT, 0.0]), "stiffness": np.diag([0.0, 1e6])},
    )
    write_body(made(vertices, faces, shapes, ("Heave", "Bend"), **matrices), tmp_path / "box.nc")
    (tmp_path / "box.yaml").write_text(yaml.safe_dump({"body": "box", "mesh": "box.nc", "modes": "box.nc", **BOX}))
    study = {
        "study": "a",
        "body": "box.yaml",
        "designs": {"a": {}},
        "pto": {"damping": 1.0},
        "waves": [{"kind": "still"}],
    }
    found = located(study | {"hydro": {"accept": ["modes"]}}, str(tmp_path / "a.yaml"))
    assert body_before_run(BodyPlan(found.study, root=str(tmp_path / "results"), files=found.files)).labels[1] == "Bend"


def test_a_summary_of_a_mesh_tells_what_would_be_solved(tmp_path):
    plan = of_a_box(tmp_path, *barge.box(30.0, 10.0, 2.0, 1), SALT)
    lines = body_summary(plan)
    assert lines[:4] == [
        "study        a: a in still",
        "body         1 degrees of freedom: Heave; a moves in 1",
        "hydro        4 frequencies from 0.5 to 1.4 rad/s, solved of the mesh",
        f"database     {plan.database_path}",
    ]
    fewer = of_a_box(
        tmp_path, *barge.box(30.0, 10.0, 2.0, 1), SALT, {"omega": [0.5, 0.8, 1.1, 1.4, 1.7]}, {"omega_max": 1.5}
    )
    assert body_summary(fewer)[2] == "hydro        4 frequencies from 0.5 to 1.4 rad/s, solved of the mesh"


def test_every_design_is_looked_at_and_named(tmp_path):
    """The first holds what nothing else does."""
    vertices, faces = barge.box(30.0, 10.0, 2.0, 1)
    box = made(vertices, faces, rigid(vertices)[[0, 2]], ("Surge", "Heave"), mass=SALT * np.eye(2))
    write_body(box, tmp_path / "box.nc")
    (tmp_path / "box.yaml").write_text(yaml.safe_dump({"body": "box", "mesh": "box.nc", "modes": "box.nc", **BOX}))
    designs = {"calm": {"held": [{"Surge": 1.0}]}, "loose": {}}

    def check(pto, stiffness=None):
        whole = {"file": "box.yaml"} | ({"stiffness": stiffness} if stiffness else {})
        study = {
            "study": "a",
            "body": whole,
            "designs": designs,
            "waves": [{"kind": "still"}],
            "pto": {"damping": 1.0} | pto,
        }
        found = located(study, str(tmp_path / "a.yaml"))
        return body_before_run(BodyPlan(found.study, root=str(tmp_path / "results"), files=found.files))

    limits = {"law": "coulomb", "force_limit": 1.0, "stroke_limit": 2.5}
    with pytest.raises(
        ConfigError, match=r"^pto.stroke_limit: received 2.5 m, but nothing holds the port of design loose"
    ):
        check({"port": {"dof": "Surge"}, **limits})
    with pytest.raises(
        ConfigError, match=r"^designs.loose: the body does not rest: received a negative stiffness of Surge"
    ):
        check({"port": {"dof": "Heave"}}, {"Surge": -1e3})
    with pytest.raises(
        ConfigError, match=r"^designs.calm: the body does not rest: received a negative stiffness of Heave"
    ):
        check({"port": {"dof": "Heave"}}, {"Heave": -1e8})
    with pytest.raises(
        ConfigError, match=r"^designs.calm: the body does not rest: received a negative stiffness of Heave"
    ):
        check({"port": {"dof": "Heave"}, "stiffness": -1e8})  # of the take-off's own spring
    assert check({"port": {"dof": "Surge"}, "stiffness": 2e3}, {"Surge": -1e3}).labels == ("Surge", "Heave")


READ = {
    "study": "raft", "body": {"wamit": "sha256:raft", "length": 2.5}, "designs": {"b": {}, "a": {}}, "pto": {"damping": 1.0},
    "waves": [{"kind": "regular", "amplitude": 0.5, "period": 7.0}, {"kind": "still"}], "hydro": {"omega_max": 3.0},
}  # fmt: skip


@pytest.mark.parametrize("kind", ["wamit", "bemio", "database"])
def test_a_file_is_read_in_the_water_of_the_study_and_judged_in_its_band(monkeypatch, kind):
    body = READ["body"] if kind == "wamit" else {kind: "sha256:raft"}
    own = BodyPlan(located({**READ, "body": body}, "a.yaml").study, files={kind: "run/raft"})
    seen = []

    def judged(*given):
        seen.append(given)
        raise InterruptedError

    monkeypatch.setattr(body_preview, "read_source", lambda *given: seen.append(given) or "found")
    monkeypatch.setattr(body_preview, "check_water", lambda *given: seen.append(given))
    monkeypatch.setattr(body_preview, "within_band", lambda *given: given)
    monkeypatch.setattr(body_preview, "judged", judged)
    with pytest.raises(InterruptedError):
        body_before_run(own)
    length = 2.5 if kind == "wamit" else 1.0
    water = own.study.water
    assert seen == [(kind, "run/raft", water, length), (water, "found"), (own.database, ("found", 3.0))]


@pytest.mark.parametrize("there", [False, True])
def test_a_summary_tells_whether_the_database_is_there_and_where_its_numbers_are_from(tmp_path, monkeypatch, there):
    own = BodyPlan(located(READ, "a.yaml").study, root=str(tmp_path), files={"wamit": "run/raft"})
    body = SimpleNamespace(labels=("Heave", "Yaw"), database=xr.Dataset(coords={"omega": [0.25, 0.5, 2.0]}))
    moves = SimpleNamespace(motions={"b": np.eye(2), "a": np.eye(2)[:, :1]})
    monkeypatch.setattr(body_preview, "checked_body", lambda plan: (body, []))
    monkeypatch.setattr(body_preview, "body_afloat", lambda *given: moves)
    monkeypatch.setattr(
        body_preview, "seas_checks", lambda *given: [SimpleNamespace(line="one"), SimpleNamespace(line="two")]
    )
    if there:
        Path(own.database_path).parent.mkdir(parents=True)
        Path(own.database_path).touch()
    swell, still = (wave.label for wave in own.study.waves)
    assert body_summary(own) == [
        f"study        raft: b, a in {swell}, {still}",
        "body         2 degrees of freedom: Heave, Yaw; b moves in 2, a moves in 1",
        "hydro        3 frequencies from 0.25 to 2 rad/s, read from run/raft",
        f"database     {own.database_path}{' (there)' if there else ''}",
        "one",
        "two",
    ]


def test_stored_results_are_looked_at_by_their_ids_where_there_are_some(tmp_path, monkeypatch):
    own = BodyPlan(located(READ, "a.yaml").study, root=str(tmp_path), files={"wamit": "run/raft"})
    seen = []
    monkeypatch.setattr(body_preview.database, "load_database", lambda *given: seen.append(given))
    monkeypatch.setattr(body_preview, "load", lambda *given: seen.append(given))
    check_stored(own)
    assert seen == []
    database, radiation = (own.database_path, content_id(own.database)), (own.radiation_path,)
    for path, expected in ((own.radiation_path, [radiation]), (own.database_path, [database, radiation])):
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).touch()
        seen.clear()
        check_stored(own)
        assert seen == expected


def test_every_sea_and_every_damper_is_looked_at(tmp_path, monkeypatch):
    """In their order, each by its number."""
    vertices, faces = barge.box(30.0, 10.0, 2.0, 1)
    plan = of_a_box(tmp_path, vertices, faces, SALT)
    waves = (
        {"kind": "still"},
        {"kind": "regular", "amplitude": 0.1, "period": 7.0},
        {"kind": "regular", "amplitude": 0.1, "period": 6.0},
    )
    study = plan.study.model_copy(update={"waves": located({**READ, "waves": list(waves)}, "a.yaml").study.waves})
    seen = []
    monkeypatch.setattr(body_preview, "check_wave", lambda i, wave, body: seen.append((i, wave.label, body.labels)))
    monkeypatch.setattr(body_preview, "check_stored", lambda given: seen.append(given))
    own = BodyPlan(study, root=plan.root, files=plan.files)
    body_before_run(own)
    assert seen == [*((i, wave.label, ("Heave",)) for i, wave in enumerate(study.waves)), own]


def test_what_is_repaired_counts_the_frequencies_that_are_kept(tmp_path):
    """Twelve in the file, nine of them in the band of the study."""
    omega = [round(0.4 + 0.1 * k, 1) for k in range(12)]
    for highest, left in ((1.2, 9), (1.3, 10)):
        hydro = {"repair": ["kramers_kronig"], "omega_max": highest}
        plan = of_a_box(tmp_path, *barge.box(30.0, 10.0, 2.0, 1), SALT, {"omega": omega}, hydro)
        if left == 10:
            assert body_before_run(plan).database.sizes["omega"] == 10
            continue
        with pytest.raises(ConfigError, match=r"^hydro.repair: kramers_kronig needs 10 frequencies, received 9$"):
            body_before_run(plan)
