"""Error intervals hold the results of ten times the accuracy, and overlap for different meshes."""

import itertools

import numpy as np
import pytest
import yaml
from conftest import SEED, varied
from stages.test_members import MODULI, planned, with_seas
from stages.test_members import run as run_campaign

from examples.barge import Barge
from vsb.engine.hydro.bodies.build import write_body
from vsb.pipeline.graph import BodyPlan, StudyPlan
from vsb.results.budget import MODES
from vsb.results.ladder import study_ladder
from vsb.stages.make import make
from vsb.study import study as config
from vsb.study.body import load_body

pytestmark = pytest.mark.slow

PERIODS = (2.0, 2.5, 3.0, 3.3, 4.0, 5.0, 8.0)


def buoy(i, tolerance):
    """A random buoy in regular and irregular waves: with or without internal pressure, in deep water or not."""
    rng, raw = np.random.default_rng(100 + i), yaml.safe_load(SEED.read_text())
    radius = rng.uniform(1.2, 3.0)
    size, mass = radius / 2, 1025.0 * 2 / 3 * np.pi * radius**3
    raw["device"] |= {
        "radius": radius, "thickness": 0.005 * radius * rng.uniform(0.8, 4), "mass": mass,
        "young_modulus": 10 ** rng.uniform(7.0, 8.0),
    }  # fmt: skip
    if i % 2:
        raw["device"]["internal_pressure"] = 1025 * 9.81 * radius * rng.uniform(0.7, 1.0)
        raw["reference_shape"] = "equilibrium"
    raw["modes"] = {"basis": "full", "degree": int(rng.integers(3, 7))}
    raw["water"]["depth"] = np.inf if i % 3 else radius * rng.uniform(3, 10)
    raw["hydro"] = {"tolerance": tolerance, "omega_max": 12.0 / np.sqrt(size)}
    raw["designs"] = {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC90": {"clamp": 90}}
    raw["waves"] = [{"kind": "regular", "amplitude": 0.05, "period": T * np.sqrt(size)} for T in PERIODS]
    raw["waves"].append({"kind": "jonswap", "hs": 0.5, "tp": 4 * np.sqrt(size)})
    return config.parse(raw)


def climbed(study, root):
    """Control levels of a study by design, sea and name."""
    plan = StudyPlan(study, root=str(root))
    make(plan, [plan.database.out])
    return {
        (level.design, level.wave, level.rung): level
        for level in study_ladder(plan.ladder.spec["study"], plan.database.out)
    }


def half(errors):
    """Half-width of the interval without the error of the shell modes, which both studies share."""
    return sum(source["high"] for source in errors if source["name"] != MODES)


def test_error_intervals_hold_results_of_a_tenth_of_the_tolerance(tmp_path):
    """Of every power and gain; half-widths of gains are far below a hundredth of a percentage point."""
    widths = []
    for i in range(2):
        rough, fine = (climbed(buoy(i, tolerance), tmp_path) for tolerance in (1e-3, 1e-4))
        for key, level in rough.items():
            assert level.low < level.power_mean < level.high
            assert abs(fine[key].power_mean - level.power_mean) <= half(level.power_error), (i, key)
            if level.gain_error is None or key[2] not in ("fixed", "best_damper"):
                continue
            was, now = (100 * found[key].power_mean / found["FSB", *key[1:]].power_mean for found in (rough, fine))
            assert abs(now - was) <= half(level.gain_error), (i, key)
            widths.append(half(level.gain_error))
    assert np.median(widths) < 5e-3  # percentage points; twice a tolerance of 1e-3 of both powers was 0.2


def test_interval_of_a_power_below_zero_holds_it(tmp_path, seed):
    """A stiff spring with losses gives back more than its damper absorbs."""
    lossy = {"damping": 500.0, "stiffness": 3e4, "efficiency": 0.5}
    study = varied(seed, pto=lossy, modes={"basis": "full", "degree": 3}, hydro={"omega_max": 5.0})
    given = [level for (_, _, rung), level in climbed(study, tmp_path).items() if rung == "fixed"]
    assert given
    for one in given:
        assert one.low < one.power_mean < min(0.0, one.high)


def test_common_errors_cancel_in_the_gain(tmp_path, seed):
    """A very stiff shell is nearly rigid: its power is as uncertain as that of the rigid design, its gain is not."""
    stiff = varied(seed, device={"young_modulus": 1e12}, modes={"basis": "full", "degree": 3}, hydro={"omega_max": 5.0})
    level = climbed(stiff, tmp_path)["VSWEC", stiff.waves[0].label, "best_damper"]
    of_power, of_gain = half(level.power_error) / level.power_mean, half(level.gain_error) / 100
    assert of_gain < 1e-3 * of_power


def test_campaign_intervals_hold_results_of_a_tenth_of_the_tolerance(tmp_path):
    folder = with_seas(tmp_path, (1.0, 6.0), (2.2, 9.0), (3.1, 12.0))
    rough, fine = (
        run_campaign(planned(folder, MODULI, name=name, hydro={"omega_max": 5.0, "tolerance": tolerance}))
        for name, tolerance in (("rough", 1e-3), ("fine", 1e-4))
    )
    low, gain, high = (rough[name].sel(design="VSWEC") for name in ("gain_low", "gain_percent", "gain_high"))
    there = fine.gain_percent.sel(design="VSWEC")
    assert bool(((low <= there) & (there <= high) & (low < gain) & (gain < high)).all())


BODY = {
    "body": "barge", "mesh": "barge.nc", "modes": "barge.nc", "lid": 0,
    "omega": [round(0.4 + 0.1 * i, 2) for i in range(9)],
}  # fmt: skip
PORT = {"Heave": 1.0, "Pitch": -40.0, "Bending1": 1.0, "Bending2": 1.0}
STUDY = {
    "body": "body.yaml",
    "designs": {"rigid": {"dofs": "rigid"}, "flexible": {}},
    "hydro": {"tolerance": 0.01, "accept": ["error_estimate", "modes", "one_resolution"]},
    "pto": {"port": {"dofs": PORT}},
    "waves": [{"kind": "regular", "amplitude": 0.5, "period": T} for T in (6.0, 6.5, 7.0, 8.0, 10.0, 12.0)],
    "simulation": {"duration": 400.0, "window": [300.0, 400.0]},
}


@pytest.fixture(scope="module")
def meshes(tmp_path_factory, green_folder):
    """Control levels of a barge by number of panels over its draught."""
    found, root = {}, tmp_path_factory.mktemp("meshes")
    for panels in (2, 3, 4):
        folder = root / str(panels)
        folder.mkdir()
        barge = Barge(length=80.0, beam=10.0, draught=5.0, bending_stiffness=2e10, modes=2)
        write_body(barge.body(panels, 1025.0), folder / "barge.nc")
        (folder / "body.yaml").write_text(yaml.safe_dump(BODY))
        (folder / "study.yaml").write_text(yaml.safe_dump({"study": f"raft{panels}", **STUDY}))
        located = load_body(folder / "study.yaml")
        plan = BodyPlan(located.study, root=str(root / "results"), files=located.files)
        make(plan, [plan.database.out])
        found[panels] = {
            (level.design, level.wave): level
            for level in study_ladder(plan.ladder.spec["study"], plan.database.out)
            if level.rung == "best_damper"
        }
    return found


def test_intervals_of_different_meshes_overlap(meshes):
    """Of powers and gains; finer meshes have narrower intervals."""
    for coarse, fine in itertools.combinations(meshes.values(), 2):
        for (design, wave), one in coarse.items():
            other = fine[design, wave]
            assert one.low <= other.high, (design, wave)
            assert other.low <= one.high, (design, wave)
            if design == "rigid":
                continue
            was, now = (
                100 * found[design, wave].power_mean / found["rigid", wave].power_mean for found in (coarse, fine)
            )
            assert abs(now - was) <= half(one.gain_error) + half(other.gain_error), (design, wave)
    widths = [
        np.median([half(level.gain_error) for (d, _), level in of.items() if d != "rigid"]) for of in meshes.values()
    ]
    assert widths == sorted(widths, reverse=True)
    assert widths[-1] < 1.0  # percentage points
