"""WEC-Sim's flexible barge: the response published by WAMIT from the same coefficients."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from vsb.api.results import Results
from vsb.engine.hydro.formats.checks import coefficient_checks
from vsb.engine.hydro.formats.wamit import import_wamit
from vsb.pipeline.graph import BodyPlan
from vsb.stages.make import make
from vsb.study.body import load_body

BARGE = Path(__file__).parents[1] / "data" / "barge"
MODES = {"Surge": 1, "Heave": 3, "Pitch": 5, "Mode7": 7, "Mode8": 8, "Mode9": 9, "Mode10": 10}
RIGID = ["Surge", "Heave", "Pitch"]


@pytest.fixture
def response(tmp_path, monkeypatch):
    """Function changes -> results of a study of the barge with response and control levels."""
    monkeypatch.chdir(tmp_path)

    def made(**changes):
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
        Path("barge.yaml").write_text(yaml.safe_dump(raw))
        found = load_body("barge.yaml")
        plan = BodyPlan(found.study, files=found.files)
        make(plan, [plan.database.out, plan.response.out, f"{plan.folder}/ladder.csv"])
        return Results(found.study)

    return made


def theirs(label):
    """Frequencies, ascending, and WAMIT's response amplitude operators of a motion (C1)."""
    rows = [list(map(float, line.split())) for line in (BARGE / "barge.4").read_text().splitlines()[1:]]
    found = [(2 * np.pi / row[0], complex(row[5], -row[6])) for row in reversed(rows) if row[2] == MODES[label]]
    return np.array([w for w, _ in found]), np.array([x for _, x in found])


def test_response_is_that_published_by_wamit(response):
    """To 0.1 % of the largest; pitch, where WAMIT's stiffness is not symmetric, to 0.5 %."""
    found = response().response.isel(wave_direction=0).sel(design="flexible")
    for label, apart in {"Surge": 1e-3, "Heave": 1e-3, "Pitch": 5e-3, "Mode7": 1e-3, "Mode9": 1e-3}.items():
        frequencies, wanted = theirs(label)
        rao = np.array([complex(found.rao.sel(dof=label).sel(omega=w, method="nearest")) for w in frequencies])
        assert np.abs(rao - wanted).max() < apart * np.abs(wanted).max(), label


def test_response_with_wamits_stiffness_is_that_published_by_wamit(response):
    """WAMIT's hydrostatic stiffness is not symmetric."""
    ds = response().database
    own = import_wamit(BARGE, "barge", density=1000.0, gravity=9.81).hydrostatic_stiffness.values
    omega = ds.omega.values[:, None, None]
    inertia = ds.inertia_matrix.values + ds.added_mass.values
    impedance = -(omega**2) * inertia - 1j * omega * ds.radiation_damping.values + own + ds.structural_stiffness.values
    rao = np.linalg.solve(impedance, ds.excitation_force.values[:, 0, :, None])[..., 0]
    for i, label in enumerate(ds.influenced_dof.values):
        frequencies, wanted = theirs(str(label))
        assert frequencies == pytest.approx(ds.omega.values, rel=1e-5)
        assert np.abs(rao[:, i] - wanted).max() < 1e-3 * np.abs(wanted).max(), label


def test_bending_changes_the_power_at_the_bow(response):
    """Power increases along the control levels; in waves of 8 s bending changes the power by more than 2 %."""
    bow = {"Heave": 1.0, "Pitch": -40.0, **{f"Mode{n}": 1.0 for n in range(7, 11)}}
    ladder = response(pto={"port": {"dofs": bow}}).ladder.to_dict("records")
    powers = {(row["design"], row["rung"]): row["power_mean"] for row in ladder}
    for design in ("rigid", "flexible"):
        levels = [powers[design, level] for level in ("best_damper", "best_spring_damper", "matched")]
        assert 0 < levels[0] <= levels[1] * (1 + 1e-9) <= levels[2] * (1 + 2e-9)
    assert abs(powers["flexible", "best_damper"] / powers["rigid", "best_damper"] - 1) > 0.02


def test_time_domain_equals_frequency_domain(tmp_path, response):
    """At the tolerance of docs/own-body.md, for the rigid barge."""
    bow = {"Heave": 1.0, "Pitch": -40.0}
    found = response(
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
