"""Bodies of WEC-Sim from published coefficients: RM3, float and spar with a take-off between them; a flexible barge."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from browser import evaluated
from conftest import one_figure, tables_of

import vsb
from vsb.api.results import Results
from vsb.engine.hydro.formats.checks import coefficient_checks
from vsb.engine.hydro.formats.wamit import import_wamit
from vsb.errors import ConfigError
from vsb.pipeline.graph import BodyPlan
from vsb.report import page as pages
from vsb.report.page import STILL
from vsb.stages.make import make
from vsb.study.body import load_body

RM3 = Path(__file__).parents[1] / "data" / "rm3"
HEAVES = ["body1__Heave", "body2__Heave"]
MASSES, DAMPER, AMPLITUDE, PERIOD = (725833.0, 886687.0), 1.2e6, 1.25, 8.0  # WEC-Sim's examples/RM3
PUBLISHED = (0.9816, 0.1252, 0.8637)
"""Heave amplitudes of float, spar, and of one against the other [m], of its regression test `RegularWaves/regular`."""
BOTH = ["positive_damping", "kramers_kronig"]


def study(folder, source, heaves=HEAVES, **changes):
    """A study file of RM3, both bodies locked together and free to move apart."""
    apart = {heaves[0]: 1.0, heaves[1]: -1.0}
    raw = {
        "study": "rm3",
        "body": source,
        "designs": {"locked": {"dofs": heaves, "held": [apart]}, "rm3": {"dofs": heaves}},
        "hydro": {"repair": BOTH},
        "water": {"density": 1000.0, "gravity": 9.81},
        "pto": {"damping": DAMPER, "port": {"dofs": apart}},
        "waves": [{"kind": "regular", "amplitude": AMPLITUDE, "period": PERIOD}],
        "simulation": {"duration": 120.0, "window": [80.0, 120.0]},
    }
    (folder / "rm3.yaml").write_text(yaml.safe_dump({**raw, **changes}))
    return folder / "rm3.yaml"


def wamit(**more):
    """WAMIT's files as a source, with masses."""
    return {"wamit": str(RM3 / "rm3"), "mass": dict(zip(HEAVES, MASSES, strict=True)), **more}


@pytest.fixture(scope="module")
def rm3(tmp_path_factory):
    """Results of the study of WAMIT's files."""
    folder = tmp_path_factory.mktemp("rm3")
    with one_figure():
        return vsb.run(load_body(study(folder, wamit())), folder / "results")


@pytest.fixture(scope="module")
def theirs():
    """WAMIT's coefficients as they are."""
    return import_wamit(RM3, "rm3", density=1000.0, gravity=9.81)


def solved(ds, coupled=True, drag=0.0):
    """Heaves of float and spar in the regular wave, by the equation of motion alone [m]; a damper drags the float."""
    omega, b = 2 * np.pi / PERIOD, np.array([1.0, -1.0])
    kept = np.ones((2, 2)) if coupled else np.eye(2)
    here = ds.interp(omega=omega, method="cubic")
    inertia = np.diag(MASSES) + kept * here.added_mass.values
    damping = kept * here.radiation_damping.values + DAMPER * np.outer(b, b) + np.diag([drag, 0.0])
    impedance = -(omega**2) * inertia - 1j * omega * damping + ds.hydrostatic_stiffness.values
    return AMPLITUDE * np.linalg.solve(impedance, here.excitation_force.values[0])


def power(heaves):
    """Mean power of the damper between them [W]."""
    return 0.5 * DAMPER * (2 * np.pi / PERIOD * np.abs(heaves[0] - heaves[1])) ** 2


def level(found, design, name):
    """Mean power of a control level [W]."""
    return next(r["power_mean"] for r in found.ladder.to_dict("records") if (r["design"], r["rung"]) == (design, name))


def test_power_is_that_of_the_equation_of_motion(rm3, theirs):
    """Repairs change it by 5e-4."""
    assert level(rm3, "rm3", "fixed") == pytest.approx(power(solved(theirs)), rel=2e-3)


def test_page_computes_the_power_of_two_bodies(rm3, tmp_path):
    """Equal to the control levels; a locked port absorbs nothing; the page says why it has no animation."""
    page = rm3.report.read_text()
    data = json.loads(re.search(r'id="interactive-data">(.+?)</script>', page, re.DOTALL)[1])
    expression = f"""data.seas.map((sea) => {{
      const grid = unpackedGrid(data.grids[sea.grid]);
      const squares = seaSquares(sea, grid);
      return grid.ports.map((port) => [{DAMPER}, bestDamper(port, squares)].map((c) => power(port, squares, c)));
    }})"""
    ((locked, free),) = evaluated([pages.text_of("algebra.js")], expression, data, tmp_path)
    assert free == pytest.approx([level(rm3, "rm3", name) for name in ("fixed", "best_damper")], rel=1e-6)
    assert locked == [0.0, 0.0]
    assert STILL in page
    assert "How much power does the rigid body absorb?" in page


def test_motion_without_hydrodynamic_coupling_is_that_published_by_wec_sim(rm3, theirs):
    """To 1 %; with coupling, which WEC-Sim leaves out by default, the float moves 4 % and the spar 31 % more."""
    alone, both = solved(theirs, coupled=False), solved(theirs)
    assert np.abs([*alone, alone[0] - alone[1]]) == pytest.approx(PUBLISHED, rel=1e-2)
    assert np.abs(alone[0] - alone[1]) == pytest.approx(PUBLISHED[2], rel=5e-3)
    assert np.abs(both) / np.abs(alone) == pytest.approx([1.035, 1.317], abs=5e-3)


def test_power_between_two_bodies_reaches_the_limit_of_heave_radiation(rm3):
    """Matched, relative heave of any axisymmetric pair absorbs the power of lambda/2 pi of wave crest."""
    response = rm3.response.isel(wave_direction=0)
    omega = response.omega.values
    flux = 0.5 * 1000.0 * 9.81 * 9.81 / (2 * omega)  # of a wave of 1 m
    share = response.matched_power.sel(design="rm3").values / (flux * 9.81 / omega**2)
    here = (omega > 0.3) & (omega < 1.5)
    assert share[here] == pytest.approx(1.0, abs=0.012)


def test_quadratic_drag_of_the_float(theirs, tmp_path):
    """As WEC-Sim's quadDrag, on the velocity of the float alone: 8/(3 pi) c |U| by iteration, and the run in time."""
    plate = {"coefficient": 1.0, "area": 314.0}
    c, drag = 0.5 * 1000.0 * 1.0 * 314.0, 0.0
    for _ in range(60):
        drag = 8 / (3 * np.pi) * c * 2 * np.pi / PERIOD * abs(solved(theirs, drag=drag)[0])
    expected = power(solved(theirs, drag=drag))
    assert expected != pytest.approx(power(solved(theirs)), rel=0.03)  # else the drag would not have been tested
    changes = {"designs": {"rm3": {"dofs": HEAVES}}, "drag": {HEAVES[0]: plate}}
    changes["simulation"] = {"duration": 56.0, "window": [40.0, 56.0]}
    located = load_body(study(tmp_path, wamit(), **changes))
    found = tables_of(BodyPlan(located.study, root=str(tmp_path / "results"), files=located.files))
    assert level(found, "rm3", "fixed") == pytest.approx(expected, rel=2e-3)
    row = found.comparison.to_dict("records")[0]
    assert row["power_mean"] == pytest.approx(expected, rel=0.01)
    assert row["energy_residual"] < 1e-6
    with pytest.raises(ConfigError, match=r"drag.Heave: no such degree of freedom; needs some of body1__Heave"):
        vsb.run(load_body(study(tmp_path, wamit(), drag={"Heave": plate})), tmp_path / "results")


def test_locked_bodies_absorb_nothing(rm3):
    assert {row["power_mean"] for row in rm3.ladder.to_dict("records") if row["design"] == "locked"} == {0.0}
    rows = {row["design"]: row for row in rm3.comparison.to_dict("records")}
    moved = 100 * np.finfo(float).eps * 1.25  # the difference of two equal motions in waves of 1.25 m
    assert rows["locked"]["displacement_pp"] <= moved
    assert abs(rows["locked"]["power_mean"]) <= rows["rm3"]["power_mean"] * moved
    assert rows["rm3"]["power_gain_percent"] is None


def test_time_and_frequency_domain_agree_and_energy_is_conserved(rm3):
    row = next(row for row in rm3.comparison.to_dict("records") if row["design"] == "rm3")
    assert row["power_mean"] == pytest.approx(level(rm3, "rm3", "fixed"), rel=5e-3)
    assert row["energy_residual"] < 1e-9
    run = rm3.trajectory("rm3", "regular_A1.25_T8")
    assert list(map(str, run.dof.values)) == HEAVES


def test_repaired_capytaine_file_gives_the_power_of_wamits(tmp_path, monkeypatch, rm3):
    """To 5 %: its panels resolve the thin plate less well."""
    monkeypatch.chdir(tmp_path)
    located = load_body(study(tmp_path, {"database": str(RM3 / "rm3.nc")}, ["rm3_float__Heave", "rm3_spar__Heave"]))
    plan = BodyPlan(located.study, files=located.files)
    make(plan, [plan.database.out, plan.radiation.out, f"{plan.folder}/ladder.csv"])
    found = Results(plan.study)
    assert level(found, "rm3", "fixed") == pytest.approx(level(rm3, "rm3", "fixed"), rel=0.05)
    checks = {check["name"]: check for check in json.loads(found.database.attrs["quality"])}
    assert checks["positive_damping"]["verdict"] == "doubt"
    assert checks["positive_damping"]["explanation"].endswith("; repaired")
    assert 0.08 < checks["repaired positive_damping"]["value"] < 0.12


BARGE = Path(__file__).parents[1] / "data" / "barge"
MODES = {"Surge": 1, "Heave": 3, "Pitch": 5, "Mode7": 7, "Mode8": 8, "Mode9": 9, "Mode10": 10}
RIGID = ["Surge", "Heave", "Pitch"]


def barge(folder, **changes):
    """Results of a study of the barge with response and control levels."""
    raw = {
        "study": "wec_sim",
        "body": {"wamit": str(BARGE / "barge")},
        "designs": {"rigid": {"dofs": RIGID}, "flexible": {}},
        "water": {"density": 1000.0, "gravity": 9.81},
        "pto": {"damping": 0.0},
        "waves": [{"kind": "regular", "amplitude": 1.0, "period": 8.0}],
        "simulation": {"duration": 80.0, "window": [40.0, 80.0]},
        **changes,
    }
    (folder / "barge.yaml").write_text(yaml.safe_dump(raw))
    found = load_body(folder / "barge.yaml")
    plan = BodyPlan(found.study, root=str(folder / "results"), files=found.files)
    make(plan, [plan.database.out, plan.response.out, f"{plan.folder}/ladder.csv"])
    return Results(found.study, plan.root)


@pytest.fixture(scope="module")
def undamped(tmp_path_factory):
    """The barge without a take-off that absorbs."""
    return barge(tmp_path_factory.mktemp("barge"))


def published(label):
    """Frequencies, ascending, and WAMIT's response amplitude operators of a motion (C1)."""
    rows = [list(map(float, line.split())) for line in (BARGE / "barge.4").read_text().splitlines()[1:]]
    found = [(2 * np.pi / row[0], complex(row[5], -row[6])) for row in reversed(rows) if row[2] == MODES[label]]
    return np.array([w for w, _ in found]), np.array([x for _, x in found])


def test_response_is_that_published_by_wamit(undamped):
    """To 0.1 % of the largest; pitch, where WAMIT's stiffness is not symmetric, to 0.5 %."""
    found = undamped.response.isel(wave_direction=0).sel(design="flexible")
    for label, apart in {"Surge": 1e-3, "Heave": 1e-3, "Pitch": 5e-3, "Mode7": 1e-3, "Mode9": 1e-3}.items():
        frequencies, wanted = published(label)
        rao = np.array([complex(found.rao.sel(dof=label).sel(omega=w, method="nearest")) for w in frequencies])
        assert np.abs(rao - wanted).max() < apart * np.abs(wanted).max(), label


def test_response_with_wamits_stiffness_is_that_published_by_wamit(undamped):
    """WAMIT's hydrostatic stiffness is not symmetric."""
    ds = undamped.database
    own = import_wamit(BARGE, "barge", density=1000.0, gravity=9.81).hydrostatic_stiffness.values
    omega = ds.omega.values[:, None, None]
    inertia = ds.inertia_matrix.values + ds.added_mass.values
    impedance = -(omega**2) * inertia - 1j * omega * ds.radiation_damping.values + own + ds.structural_stiffness.values
    rao = np.linalg.solve(impedance, ds.excitation_force.values[:, 0, :, None])[..., 0]
    for i, label in enumerate(ds.influenced_dof.values):
        frequencies, wanted = published(str(label))
        assert frequencies == pytest.approx(ds.omega.values, rel=1e-5)
        assert np.abs(rao[:, i] - wanted).max() < 1e-3 * np.abs(wanted).max(), label


def test_bending_changes_the_power_at_the_bow(tmp_path):
    """Power increases along the control levels; in waves of 8 s bending changes the power by more than 2 %."""
    bow = {"Heave": 1.0, "Pitch": -40.0, **{f"Mode{n}": 1.0 for n in range(7, 11)}}
    ladder = barge(tmp_path, pto={"port": {"dofs": bow}}).ladder.to_dict("records")
    powers = {(row["design"], row["rung"]): row["power_mean"] for row in ladder}
    for design in ("rigid", "flexible"):
        levels = [powers[design, level] for level in ("best_damper", "best_spring_damper", "matched")]
        assert 0 < levels[0] <= levels[1] * (1 + 1e-9) <= levels[2] * (1 + 2e-9)
    assert abs(powers["flexible", "best_damper"] / powers["rigid", "best_damper"] - 1) > 0.02


def test_time_domain_equals_frequency_domain(tmp_path):
    """At the tolerance of docs/own-body.md, for the rigid barge."""
    bow = {"Heave": 1.0, "Pitch": -40.0}
    found = barge(
        tmp_path,
        designs={"rigid": {"dofs": RIGID}}, pto={"port": {"dofs": bow}}, hydro={"omega_max": 3.0, "tolerance": 3e-3},
        simulation={"duration": 200.0, "window": [160.0, 200.0]},
    )  # fmt: skip
    plan = found.plan
    make(plan, [f"{plan.folder}/validity.json"])
    checks = {check["name"]: check for check in json.loads(Path(f"{plan.folder}/validity.json").read_text())["checks"]}
    assert checks["time_and_frequency_domain"]["value"] < 5e-4
    assert checks["energy_residual"]["value"] < 1e-10


def test_damping_of_heave_follows_from_one_heading_in_long_waves():
    """As a ring wave, of which a barge of 80 m at 0.31 rad/s, kL = 0.8, sends out nearly one."""
    checks, _ = coefficient_checks(import_wamit(BARGE, "barge", density=1000.0, gravity=9.81))
    (check,) = (one for one in checks if one.name == "haskind_long_waves")
    assert (check.verdict, check.value < 0.03) == ("ok", True)
