"""A study of a mesh, from panels to the page, and its limits of a stiff and of a held body."""

import base64
import json
import re
import shutil
from contextlib import chdir
from pathlib import Path

import numpy as np
import pytest
import yaml

import vsb
from examples.barge import Barge
from vsb.api.results import Results
from vsb.engine.hydro.bodies.build import write_body
from vsb.engine.hydro.panels import bem
from vsb.pipeline.graph import BodyPlan
from vsb.stages.make import make
from vsb.study.body import load_body
from vsb.study.figure_names import of_study

pytestmark = pytest.mark.slow

BARGE = Barge(length=20.0, beam=6.0, draught=2.0, bending_stiffness=1e8, modes=1, hinge_stiffness=0.0)
DOFS = list(BARGE.labels)
BOW = {"Heave": 1.0, "Pitch": -10.0, "Bending1": 1.0, "Hinge": 1.0}
FILE = {
    "body": "barge",
    "mesh": "barge.nc",
    "modes": "barge.nc",
    "omega": [round(0.3 + 0.15 * i, 2) for i in range(13)],
    "wave_direction": [0.0, 30.0],
    "lid": 0,
}


def unpacked(text):
    """Numbers of a page."""
    return np.frombuffer(base64.b64decode(text), dtype="<f4")


def study(folder, **changes):
    """A study file of the barge, rigid, flexible and hinged, take-off at the bow."""
    raw = {
        "study": "raft",
        "body": "body.yaml",
        "designs": {"rigid": {"dofs": "rigid"}, "flexible": {"dofs": DOFS[:-1]}, "hinged": {}},
        "hydro": {"tolerance": 0.005, "accept": ["error_estimate", "modes", "one_resolution"]},
        "pto": {"port": {"dofs": BOW}},
        "waves": [{"kind": "regular", "amplitude": 0.2, "period": 5.0, "direction": 30.0}],
        "simulation": {"duration": 100.0, "window": [75.0, 100.0]},
        **changes,
    }
    (folder / "study.yaml").write_text(yaml.safe_dump(raw, sort_keys=False))
    return load_body(folder / "study.yaml")


@pytest.fixture(scope="module")
def folder(tmp_path_factory, green_folder):
    """Mesh, body file, and the Green function's table where a study looks for it."""
    place = tmp_path_factory.mktemp("mesh")
    write_body(BARGE.body(2, 1025.0), place / "barge.nc")
    (place / "body.yaml").write_text(yaml.safe_dump(FILE))
    found = study(place)
    table = Path(BodyPlan(found.study, root=str(place / "results")).green.files["folder"])
    shutil.copytree(green_folder, table)
    assert bem.stored_green_function(table)
    return place


@pytest.fixture(scope="module")
def found(folder):
    """Results of the study."""
    return vsb.run(study(folder), folder / "results")


def ladder(folder, name, **changes):
    """Control levels of a changed study with the same hydrodynamics."""
    located = study(folder, study=name, **changes)
    plan = BodyPlan(located.study, root=str(folder / "results"), files=located.files)
    make(plan, [plan.database.out, f"{plan.folder}/ladder.csv"])
    return Results(located.study, str(folder / "results")).ladder.to_dict("records")


def test_study_of_a_mesh_from_panels_to_page(found):
    assert {row["design"] for row in found.comparison.to_dict("records")} == {"rigid", "flexible", "hinged"}
    for row in found.comparison.to_dict("records"):
        numbers = [row[name] for name in ("displacement_pp", "velocity_pp", "power_mean", "energy", "capture_width")]
        assert np.isfinite(numbers).all()
        assert row["power_mean"] > 0
    response = found.response
    for name in ("rao", "port_impedance", "port_velocity", "best_power", "matched_power", "best_damping"):
        assert np.isfinite(response[name].sel(design="hinged").values).all()
    levels = {(row["design"], row["rung"]): row["power_mean"] for row in found.ladder.to_dict("records")}
    for design in ("rigid", "flexible", "hinged"):
        powers = [levels[design, level] for level in ("best_damper", "best_spring_damper", "matched")]
        assert 0 < powers[0] <= powers[1] * (1 + 1e-9) <= powers[2] * (1 + 2e-9)
    for check in found.checks.to_dict("records"):
        assert np.isfinite(check["value"])
        assert check["verdict"] != "fail"
    assert {"hydro error_estimate", "hydro displaced_mass", "rotation", "translation"} <= {
        c["name"] for c in found.checks.to_dict("records")
    }
    assert "Does the flexible body absorb more power than the rigid one?" in found.report.read_text()
    figures = {path.stem for path in (Path(found.folder) / "raft" / "figures").glob("*.svg")}
    assert figures == set(of_study(found.study))


def test_page_shows_the_body_moving_as_its_response_says(found, tmp_path, monkeypatch):
    """The hull's ends rise by |sum RAO_i psi_i| a, at the phase of the wave that is drawn."""
    data = json.loads(re.search(r'id="buoys-data">(.+?)</script>', found.report.read_text(), re.DOTALL)[1])
    outline, displacement = (unpacked(data["shapes"][name]) for name in ("outline", "displacement"))
    (sea,), omega = data["seas"], 2 * np.pi / 5.0
    wave = np.exp(-1j * omega * (sea["start"] + sea["step"] * np.arange(sea["frames"])))
    for design, frames in zip(data["designs"], sea["designs"], strict=True):
        amplitudes = unpacked(frames["shell"]).reshape(len(wave), -1)
        rao = found.response.rao.sel(design=design["name"])
        rao = rao.sel(wave_direction=np.deg2rad(30.0), method="nearest") if "wave_direction" in rao.dims else rao
        expected = 0.2 * rao.interp(omega=omega, method="cubic").values @ displacement.reshape(len(DOFS), -1)
        drawn = amplitudes @ displacement.reshape(len(DOFS), -1)
        phasor = np.linalg.lstsq(np.column_stack([wave.real, -wave.imag]), drawn, rcond=None)[0]
        np.testing.assert_allclose(phasor[0] + 1j * phasor[1], expected, atol=0.02 * np.abs(expected).max())
    assert outline.reshape(-1, 2).min(axis=0) == pytest.approx([-10.0, -2.0])
    surface = unpacked(sea["surface"]).reshape(len(wave), -1)
    np.testing.assert_allclose(surface[:, surface.shape[1] // 2], 0.2 * wave.real, atol=1e-4)
    monkeypatch.setattr("vsb.api.plots.PERIODS_SHOWN", 0.2)
    found.plot.animate("hinged", magnify=3.0).save(tmp_path / "barge.gif", writer="pillow", dpi=20)


@pytest.mark.parametrize("design", ["rigid", "flexible", "hinged"])
def test_time_and_frequency_domain_agree_and_energy_is_conserved(found, design):
    row = next(row for row in found.comparison.to_dict("records") if row["design"] == design)
    best = next(r for r in found.ladder.to_dict("records") if (r["design"], r["rung"]) == (design, "best_damper"))
    assert row["power_mean"] == pytest.approx(best["power_mean"], rel=5e-3)
    assert row["energy_residual"] < 1e-9
    run = found.trajectory(design, found.study.waves[0].label)
    assert np.isfinite(run.position.values).all()


def test_stiff_body_absorbs_the_power_of_the_rigid_one(folder, found):
    """The difference decreases with stiffness, to 1e-6 at a million times the stiffness."""
    rigid = {row["rung"]: row["power_mean"] for row in found.ladder.to_dict("records") if row["design"] == "rigid"}
    before = np.inf
    for factor, apart in ((1e3, 1e-3), (1e6, 1e-6)):
        k = factor * float(BARGE.stiffness[2, 2])
        matrix = {"file": "body.yaml", "stiffness": {"Bending1": k, "Hinge": k}}
        rows = ladder(folder, f"stiff{factor:.0e}".replace("+", ""), body=matrix, designs={"hinged": {}})
        stiff = {row["rung"]: row["power_mean"] for row in rows if row["design"] == "hinged"}
        worst = max(abs(stiff[level] / power - 1) for level, power in rigid.items())
        assert worst < apart
        assert worst < 2e-3 * before
        before = worst


def test_power_of_a_hinge_is_that_of_the_equation_of_motion(folder):
    """The matched power; the rigid body absorbs nothing."""
    designs = {"rigid": {"dofs": "rigid"}, "hinged": {}}
    with chdir(folder):
        rows = ladder(folder, "hinge", pto={"port": {"dof": "Hinge"}}, designs=designs)
    powers = {(row["design"], row["rung"]): row["power_mean"] for row in rows}
    assert powers["rigid", "matched"] == 0.0
    located = study(folder, study="hinge", pto={"port": {"dof": "Hinge"}}, designs=designs)
    ds = Results(located.study, str(folder / "results")).database
    omega = 2 * np.pi / 5.0
    here = ds.interp(omega=omega, method="cubic")
    mass = here.inertia_matrix.values + here.added_mass.values
    stiffness = here.hydrostatic_stiffness.values + here.structural_stiffness.values
    impedance = -(omega**2) * mass - 1j * omega * here.radiation_damping.values + stiffness
    compliance = np.linalg.inv(impedance)[-1, -1]
    force = here.excitation_force.sel(wave_direction=np.deg2rad(30.0), method="nearest").values
    free = 0.2 * omega * abs(np.linalg.solve(impedance, force)[-1])
    matched = free**2 / (8 * omega * compliance.imag)
    assert powers["hinged", "matched"] == pytest.approx(matched, rel=2e-3)
