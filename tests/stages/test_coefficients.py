"""A body's database, and the whole chain upon it: the small study's buoy as a body by the general route."""

import json
import re
from contextlib import chdir
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import SMALL, SMALL_PLAN, told, varied

import vsb
from vsb.errors import DatabaseError
from vsb.hydro.database import Check
from vsb.hydro.formats.sources import read_source
from vsb.results.ladder import study_ladder
from vsb.scenes.build import TUNED, design_in_sea
from vsb.stages import coefficients
from vsb.stages.stored import Results
from vsb.study.body import Body, load_body, located
from vsb.study.body_plan import plan_for
from vsb.tools.units import PAIR

DOFS = ["Heave", "Membrane0", "Membrane1", "Membrane2"]
SWELL = {"kind": "regular", "amplitude": 0.1, "period": 2.5}


def as_body(finished, **changes):
    """The small study, what floats in it a body read from its database."""
    kept = {key: SMALL[key] for key in ("water", "pto", "simulation") if key in SMALL}
    designs = {"FSB": {"dofs": ["Heave"]}, "VSWEC": {"dofs": "all"}}
    made = {"study": "general", "body": {"database": str(finished / SMALL_PLAN.database_path)}, "designs": designs}
    waves = [*SMALL["waves"], {**SWELL, "direction": 0.0}]
    return {**made, "hydro": {"tolerance": 1e-3}, "waves": waves[:1], **kept, **changes}


@pytest.fixture(scope="module")
def general(finished, tmp_path_factory):
    """Results of that study."""
    folder = tmp_path_factory.mktemp("general")
    with chdir(folder):
        Path("general.yaml").write_text(yaml.safe_dump(as_body(finished)))
        vsb.run(vsb.load_body("general.yaml"))
    return folder


@pytest.fixture
def both(finished, general):
    """Results by the axisymmetric chain and by the general route."""
    with chdir(finished):
        study = vsb.load("small.yaml")
    with chdir(general):
        body = load_body("general.yaml").study
    return Results(study, str(finished / "results")), Results(body, str(general / "results"))


def test_its_response_is_that_of_the_axisymmetric_chain(both):
    """Between solved frequencies the one takes a channel, the other splines: within the tolerance of the database."""
    own, body = both[0].response, both[1].response.isel(wave_direction=0)
    omega = [w for w in both[1].database.omega.values if w < 4.5]
    for design in ("FSB", "VSWEC"):
        for name in ("rao", "port_impedance", "port_velocity", "best_power", "matched_power", "absorbed_power"):
            a, b = (ds[name].sel(design=design).sel(omega=omega, method="nearest").values for ds in (own, body))
            assert np.abs(a - b).max() < 2e-3 * np.abs(a).max(), (design, name)
    frequencies = [ds.wet_natural_frequency.values for ds in (own, body)]
    assert frequencies[1] == pytest.approx(frequencies[0], rel=2e-3)


def test_its_ladder_is_that_of_the_axisymmetric_chain(both):
    for own, body in zip(both[0].ladder, both[1].ladder, strict=True):
        assert [own[k] for k in ("design", "wave", "rung")] == [body[k] for k in ("design", "wave", "rung")]
        assert body["power_mean"] == pytest.approx(own["power_mean"], rel=2e-3)


def test_its_motion_in_time_is_that_of_the_axisymmetric_chain(both):
    for own, body in zip(both[0].comparison, both[1].comparison, strict=True):
        for name in ("displacement_pp", "velocity_pp", "power_mean", "energy"):
            assert body[name] == pytest.approx(own[name], rel=5e-3), (own["design"], name)
        assert body["energy_residual"] < 1e-9


def test_it_latches_with_the_damper_and_pause_of_the_axisymmetric_chain(finished, general, both):
    """Tuned to its sea, damper and pause are found together; the damper that is best alone is far heavier."""
    pto, wave = {"law": "latching", "tuning": "each"}, {"kind": "regular", "amplitude": 0.1, "period": 5.0}
    scenes, kept = [], {"duration": 12.0, "window": [6.0, 12.0]}
    for folder, study in (
        (finished, varied(SMALL_PLAN.study, pto=pto, waves=[wave], simulation=kept)),
        (general, None),
    ):
        with chdir(folder):
            if study is None:
                raw = as_body(finished, pto=pto, waves=[wave], simulation={**SMALL["simulation"], **kept})
                Path("latching.yaml").write_text(yaml.safe_dump(raw))
                study = load_body("latching.yaml").study
            plan = plan_for(study)
            paths = {"database": plan.database_path, "radiation": plan.radiation_path}
            scenes.append(design_in_sea(plan.simulation("FSB", study.waves[0]), paths))
    own, body = (scene.notes for scene in scenes)
    assert body["pause"] == pytest.approx(own["pause"], abs=2 * own["pause_within"])
    assert body[TUNED] == pytest.approx(own[TUNED], rel=0.05)
    assert body["pause_power"] == pytest.approx(own["pause_power"], rel=5e-3)
    alone = float(both[1].response.best_damping.sel(design="FSB").interp(omega=2 * np.pi / 5))
    assert scenes[1].scene.law.damping == body[TUNED] < 0.6 * alone


def test_a_take_off_that_pauses_where_a_design_does_not_move_leaves_it_as_it_is(finished, general):
    pto = {"law": "latching", "damping": 100.0, "port": {"dofs": {"Membrane0": 1.0}}}
    with chdir(general):
        Path("elsewhere.yaml").write_text(yaml.safe_dump(as_body(finished, pto=pto)))
        study = load_body("elsewhere.yaml").study
        plan = plan_for(study)
        paths = {"database": plan.database_path, "radiation": plan.radiation_path}
        found = design_in_sea(plan.simulation("FSB", study.waves[0]), paths)
    assert found.scene.law is None
    assert found.notes == {"model": "linear"}


@pytest.mark.parametrize("tuning", ["each", "one"])
def test_a_damper_of_a_run_is_that_of_the_ladder_of_its_own_sea_or_of_all(finished, general, tuning):
    waves = [{**SWELL, "period": period, "direction": 0.0} for period in (2.0, 3.5)]
    with chdir(general):
        raw = as_body(finished, pto={"tuning": tuning}, waves=waves)
        Path("tuned.yaml").write_text(yaml.safe_dump(raw))
        study = load_body("tuned.yaml").study
        plan = plan_for(study)
        paths = {"database": plan.database_path, "radiation": plan.radiation_path}
        found = [design_in_sea(plan.simulation("VSWEC", wave), paths).notes[TUNED] for wave in study.waves]
        name = {"each": "best_damper", "one": "best_damper_all_seas"}[tuning]
        rungs = [r for r in study_ladder(plan.ladder, plan.database_path) if (r.design, r.rung) == ("VSWEC", name)]
    assert found == pytest.approx([rung.damping for rung in rungs], rel=1e-6)
    assert (found[0] == found[1]) == (tuning == "one")


def test_its_ledger_asks_of_a_body_what_there_is_to_ask(both):
    names = {check["name"] for check in both[1].checks}
    assert {"energy_residual", "radiation_fit", "passivity", "steepness", "transient", "hydro rank_one"} <= names
    assert not names & {"heave", "buckling", "power_limit", "witness", "modes_left_out"}
    failed = [check["name"] for check in both[1].checks if check["verdict"] == "fail"]
    assert failed == [
        check["name"] for check in both[0].checks if check["verdict"] == "fail" and check["name"] in names
    ]


def test_its_page_and_figures_are_there(both, general):
    page = both[1].report.read_text()
    assert "Does the flexible body absorb more power than the rigid one?" in page
    assert "port, peak to peak [m]" in page
    assert {path.stem for path in (general / "results" / "general" / "figures").glob("*.svg")} == set(
        both[1].plan.figures
    )


def test_ids_are_of_contents_not_of_paths(finished, general, tmp_path):
    """Another name and place of the same file is the same body; another file is another one."""
    source = finished / SMALL_PLAN.database_path
    (tmp_path / "copy.nc").write_bytes(source.read_bytes())
    raw = as_body(finished, body={"database": "copy.nc"})
    (tmp_path / "copy.yaml").write_text(yaml.safe_dump(raw))
    copied = load_body(tmp_path / "copy.yaml").study
    assert Results(copied).plan.ids.keys() == Results(load_body(general / "general.yaml").study).plan.ids.keys()
    assert Results(copied).plan.study_id == Results(load_body(general / "general.yaml").study).plan.study_id
    (tmp_path / "copy.nc").write_bytes(source.read_bytes() + b" ")
    assert Results(load_body(tmp_path / "copy.yaml").study).plan.study_id != Results(copied).plan.study_id


def test_its_database_says_what_it_is(both):
    ds = both[1].database
    assert list(map(str, ds.influenced_dof.values)) == DOFS
    assert {"structural_damping_matrix", "inertia_matrix", "structural_stiffness"} <= set(ds)
    assert json.loads(ds.attrs["spec"])["stage"] == "body"


def test_a_database_of_other_water_or_whose_checks_fail_is_refused(finished, workplace, capsys):
    raw = as_body(finished, water={"density": 1000.0})
    Path("salt.yaml").write_text(yaml.safe_dump(raw))
    expected = "water.density: received 1000, needs 1025, as the body's files have"
    assert told(["check", "salt.yaml"], capsys) == f"salt.yaml: {expected}"
    with xr.open_dataset(finished / SMALL_PLAN.database_path) as ds:
        dull = ds.load().assign_attrs(quality=json.dumps([
            {"name": "symmetry", "value": 1.0, "limit": 0.02, "unit": "-", "verdict": "fail", "explanation": "even"}
        ]))  # fmt: skip
    dull.attrs.pop("checksum")
    dull.to_netcdf("dull.nc")
    Path("dull.yaml").write_text(yaml.safe_dump(as_body(finished, body={"database": "dull.nc"})))
    refused = "check 'symmetry' failed: 1, needs at most 0.02 (even); use smaller"
    assert told(["check", "dull.yaml"], capsys).startswith(f"hydro database: {refused}")
    with pytest.raises(DatabaseError, match=re.escape(refused)):
        vsb.run(vsb.load_body("dull.yaml"))
    assert not Path("results").exists()


def test_what_no_design_moves_is_neither_judged_nor_stored(finished, tmp_path):
    """Two of four degrees of freedom: the numbers they had among the four."""
    Path(tmp_path / "few.yaml").write_text(
        yaml.safe_dump(as_body(finished, designs={"A": {"dofs": ["Heave", "Membrane1"]}}))
    )
    plan = plan_for(load_body(tmp_path / "few.yaml").study, str(tmp_path))
    found = read_source("database", str(finished / SMALL_PLAN.database_path), plan.study.water)
    coefficients.store(plan.database, found, str(tmp_path / "few.nc"))
    with xr.open_dataset(tmp_path / "few.nc") as ds:
        assert (
            list(map(str, ds.influenced_dof.values))
            == list(map(str, ds.radiating_dof.values))
            == ["Heave", "Membrane1"]
        )
        few = found.added_mass.sel(influenced_dof=ds.influenced_dof, radiating_dof=ds.radiating_dof)
        assert ds.added_mass.shape[1:] == (2, 2)
        np.testing.assert_allclose(ds.added_mass.values[-3:], few.values[-3:], rtol=1e-6)


@pytest.mark.parametrize("uneven", [False, True])
def test_a_stiffness_that_is_no_energy_s_is_made_so_and_told(finished, tmp_path, uneven):
    """Of what a file says of heave and a bending mode the row of heave counts."""
    (tmp_path / "one.yaml").write_text(yaml.safe_dump(as_body(finished)))
    plan = plan_for(load_body(tmp_path / "one.yaml").study, str(tmp_path))
    found = read_source("database", str(finished / SMALL_PLAN.database_path), plan.study.water)
    stiffness = found.hydrostatic_stiffness.copy(deep=True)
    if uneven:
        stiffness.loc[{"influenced_dof": "Membrane1", "radiating_dof": "Heave"}] += 0.3 * float(stiffness.max())
    coefficients.store(plan.database, found.assign(hydrostatic_stiffness=stiffness), str(tmp_path / "one.nc"))
    with xr.open_dataset(tmp_path / "one.nc") as ds:
        matrix = ds.hydrostatic_stiffness.values
        told = [one for one in json.loads(ds.attrs["quality"]) if one["name"] == "hydrostatic_symmetry"]
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-6 * np.abs(matrix).max())
    assert [(one["verdict"], "between" in one["explanation"]) for one in told] == uneven * [("doubt", True)]


RAFT = {
    "study": "raft", "body": {"wamit": "sha256:raft", "length": 2.5}, "designs": {"a": {}},
    "waves": [{"kind": "regular", "amplitude": 0.5, "period": 7.0}], "water": {"density": 1010.0, "gravity": 9.7},
}  # fmt: skip


@pytest.mark.parametrize("kind", ["wamit", "bemio", "file"])
def test_what_a_database_is_made_of_is_handed_on(monkeypatch, kind):
    """Of a mesh its files and where it is solved, else the file of its kind in the study's water; then what is kept."""
    mesh = {"body": "raft", "mesh": "sha256:m", "modes": "sha256:d", "omega": [0.6, 0.9]}
    body = {"wamit": RAFT["body"], "bemio": {"bemio": "sha256:raft"}, "file": {"file": mesh}}[kind]
    own = plan_for(located({**RAFT, "body": body, "hydro": {"omega_max": 3.0}}, "raft.yaml").study).database
    seen = []
    monkeypatch.setattr(coefficients, "read_body", lambda *given: given)
    monkeypatch.setattr(coefficients, "solved", lambda *given: seen.append(given) or ("found", []))
    monkeypatch.setattr(coefficients, "read_source", lambda *given: seen.append(given) or "found")
    monkeypatch.setattr(coefficients, "check_water", lambda *given: seen.append(given))
    monkeypatch.setattr(coefficients, "within_band", lambda *given: given)
    monkeypatch.setattr(coefficients, "store", lambda *given: seen.append(given))
    files = {name: name.upper() for name in ("mesh", "modes", "folder", "green", "wamit", "bemio")}
    coefficients.run(own, "out.nc", **files)
    source = {
        "wamit": ("wamit", "WAMIT", own.water, 2.5),
        "bemio": ("bemio", "BEMIO", own.water, 1.0),
        "file": (own.body.file, ("MESH", "MODES", 9.81), "FOLDER", "GREEN"),
    }[kind]
    assert seen == [source, (own.water, "found"), (own, ("found", 3.0), "out.nc")]


@pytest.mark.parametrize(
    ("told", "solver"),
    [({"solver": "panels 1", "source": "vsb"}, "panels 1"), ({"source": "WAMIT"}, "WAMIT"), ({}, "unknown")],
)
def test_a_database_keeps_what_is_known_of_its_bodies_and_tells_what_was_not_checked(monkeypatch, told, solver):
    spec = plan_for(located(RAFT, "raft.yaml").study).database
    facts = {"displaced_volume_float": 3.0, "displaced_volume_spar": 4.0, "bem_seconds": 2.0, "symmetry": "xOz"}
    facts |= {"displaced_volume": 9.0, "centre_of_buoyancy": [0.0, 1.0, 2.0], "centre_of_mass": [3.0, 4.0, 5.0]}
    ds = xr.Dataset(
        {"omega": ("w", [1.0])}, attrs={**facts, "history": "read", "displaced_volume_boat": 7.0, "title": "x"}
    )
    labels, checks, saved = ("float__Heave", "spar__Heave", "spar__Pitch"), [], []
    monkeypatch.setattr(
        coefficients,
        "judged",
        lambda *_: coefficients.Judged(SimpleNamespace(labels=labels), ds.copy(), checks, ["no a", "no b"]),
    )
    monkeypatch.setattr(coefficients.database, "save_database", lambda *given: saved.append(given))
    coefficients.store(spec, xr.Dataset(attrs=told), "out.nc")
    ((stored, _, out),) = saved
    water = {"water_density": 1010.0, "gravity": 9.7, "water_depth": "inf"}
    assert out == "out.nc"
    assert {name: stored.attrs[name] for name in (*facts, *water)} == {**facts, **water}
    assert stored.attrs["history"] == "read; no a; no b"
    assert stored.attrs["title"] == "hydro database of a body: float__Heave, spar__Heave, spar__Pitch"
    assert stored.attrs["solver"] == solver
    assert stored.attrs["quality"] == "[]"
    assert "displaced_volume_boat" not in stored.attrs


def test_only_a_mass_of_the_studys_own_is_judged_anew(monkeypatch):
    checks = [SimpleNamespace(name=name) for name in ("symmetry", "afloat", "haskind")]
    monkeypatch.setattr(coefficients, "afloat_checks", lambda ds: [f"anew of {ds}"])
    body = SimpleNamespace(database="its database")
    for given in ({}, {"damping": {"Heave": 1.0}}, {"stiffness": {"Heave": 1.0}}):
        assert coefficients.of_own_mass(checks, Body(database="-", **given), body) == checks
    for mass in ({"Heave": 1.0}, ((0.0,),)):
        found = coefficients.of_own_mass(checks, Body(database="-", mass=mass), body)
        assert found == [checks[0], checks[2], "anew of its database"]


def test_a_body_is_judged_in_what_its_designs_move_with_what_is_repaired_and_accepted(monkeypatch):
    """Checks of what came, in the order of the body; that of its own mass anew; then what was made even or repaired."""
    raw = {**RAFT, "body": {"database": "sha256:x", "mass": {"Heave": 1.0}}}
    hydro = {"accept": ["haskind", "afloat"], "repair": ["positive_damping"], "omega_max": 3.0}
    spec = plan_for(
        located({**raw, "hydro": hydro, "designs": {"a": {"dofs": ["Yaw", "Heave"]}}}, "a.yaml").study
    ).database
    labels, asked = ["Heave", "Roll", "Yaw"], []
    found = xr.Dataset({"a": (PAIR, np.arange(9.0).reshape(3, 3))}, dict.fromkeys(PAIR, labels))
    damping, its = np.array([[1.0, 2.0], [3.0, 4.0]]), xr.Dataset({"its": ("w", [1.0])})
    body = SimpleNamespace(labels=("Heave", "Yaw"), database=its, structural_damping=damping)

    def check(name, verdict="fail"):
        return Check(name, 1.0, 0.5, "-", verdict, name)

    def source(ds):
        asked.append(ds)
        return [check("haskind"), check("positive_damping"), check("afloat"), check("symmetry", "ok")], ["unseen"]

    monkeypatch.setattr(coefficients, "complete_body", lambda *given: asked.append(given) or body)
    monkeypatch.setattr(coefficients, "source_checks", source)
    monkeypatch.setattr(coefficients, "afloat_checks", lambda ds: [check("afloat", "doubt")])
    monkeypatch.setattr(
        coefficients, "with_symmetric_stiffness", lambda ds: asked.append(ds) or (None, [check("even", "doubt")])
    )
    monkeypatch.setattr(
        coefficients,
        "repaired",
        lambda *given: asked.append(given) or (its.assign_attrs(history="mended"), [check("mended", "doubt")]),
    )
    judged = coefficients.judged(spec, found)
    assert judged.body is body
    assert judged.unseen == ["unseen"]
    assert [(one.name, one.verdict) for one in judged.checks] == [
        ("haskind", "accepted"), ("positive_damping", "doubt"), ("symmetry", "ok"), ("afloat", "doubt"),
        ("even", "doubt"), ("mended", "doubt"),
    ]  # fmt: skip
    assert judged.checks[1].explanation == "positive_damping; repaired"
    assert judged.database.attrs["history"] == "mended"
    assert judged.database.structural_damping_matrix.values.tolist() == damping.tolist()
    assert judged.database.its.values.tolist() == [1.0]
    (given, kept, same), first, second, mending = asked
    assert (given, kept) == (spec.body, ("Heave", "Yaw"))
    assert same is found
    for one in (first, second):
        assert one.a.values.tolist() == [[0.0, 2.0], [6.0, 8.0]]
        assert one.radiating_dof.values.tolist() == ["Heave", "Yaw"]
    assert mending[0] is its
    assert mending[1] == ("positive_damping",)
    monkeypatch.setattr(coefficients, "source_checks", lambda _: ([check("symmetry")], []))
    with pytest.raises(
        DatabaseError, match=rf"check 'symmetry' failed: .*; {re.escape(coefficients.REMEDY)}, or list the"
    ):
        coefficients.judged(spec, found)
