"""Sections of a study: every value has its range, its unit and one line that refuses others."""

import ast
import copy
import re

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import EXAMPLE, SEED, varied

from vsb.errors import ConfigError
from vsb.hydro import quality
from vsb.study import study as config
from vsb.study.sections import DEEPEST, Design, Hydro, Simulation, Water

RAW = yaml.safe_load(SEED.read_text())


def changed(path, value):
    raw = copy.deepcopy(RAW)
    *parents, last = path
    target = raw
    for key in parents:
        target = target[key]
    target[last] = value
    return raw


BAD = [
    (("device", "thicknes"), 0.01, r"device.thicknes: received 0.01; unknown key"),
    (("device", "thickness"), -0.01, r"device.thickness: received -0.01; needs a number above 0"),
    (("device", "thickness"), 0.5, r"device: thickness 0.5 m: thin-shell theory \(C3\) needs less than radius/10 = 0.2 m"),
    (("device", "radius"), "two", r"device.radius: received 'two'; needs a number"),
    (("device", "radius"), True, r"device.radius: received True; a number is needed"),
    (("device", "mass"), 1e9, r"study: device.mass 1e\+09 kg: the buoy would sink; needs less than 34348.\d kg"),
    (("device", "mass"), 100.0, r"device: mass 100 kg: needs at least the mass of the shell itself"),
    (("device", "gas"), {"adiabatic_index": 0.5}, r"device.gas.adiabatic_index: received 0.5"),
    (("reference_shape",), "bent", r"reference_shape: received 'bent'; .*'undeformed' or 'equilibrium'"),
    (("modes", "basis"), "spectral", r"modes.basis: received 'spectral'; needs 'paper', 'membrane' or 'full'"),
    (("modes", "degree"), 2.5, r"modes.degree: received 2.5; needs a whole number"),
    (("designs",), {}, r"designs: .*at least 1"),
    (("designs",), {"A": {"flexible": False, "clamp": 0}}, r"designs.A: clamp \[0.0\]: a rigid design .* remove one"),
    (("designs",), {"A": {"clamp": 200}}, r"designs.A.clamp: received 200; needs a number of at most 180"),
    (("waves",), [], r"waves: received \[\]; .*at least 1 item"),
    (("waves",), [{"kind": "regular", "amplitude": 0.1, "period": 0.3}], r"waves.0 .*too short .*period of at least 0.5236 s"),
    (("waves",), [{"kind": "tsunami"}], r"waves.0: .*'still', 'regular', 'jonswap'"),
    (("waves",), [{"kind": "still"}, {"kind": "still"}], r"waves .*same sea is listed twice"),
    (("water", "depth"), 1.5, r"water.depth 1.5 m: needs more than the draft of the buoy, 2 m"),
    (("hydro", "model"), "magic", r"hydro.model: received 'magic'; needs 'linear'"),
    (("hydro", "omega"), [3.0, 2.0], r"hydro: omega \[3.0, 2.0\]: frequencies must ascend"),
    (("hydro", "omega"), [3.0, 13.0], r"hydro.omega 13 rad/s: needs at most hydro.omega_max = 12 rad/s"),
    (("simulation", "window"), [50, 70], r"simulation: window \[50.0, 70.0\]: needs 0 <= start < end <= duration = 60 s"),
    (("device", "poisson_ratio"), 0.5, r"device.poisson_ratio: received 0.5; needs a number below 0.5"),
    (("device", "mass"), float("nan"), r"device.mass: received nan; needs a"),
    (("device", "damping", "beta"), -1.0, r"device.damping.beta: received -1.0; needs a number of at least 0"),
    (("modes", "degree"), True, r"modes.degree: received True; a number is needed, not true/false"),
    (("modes", "degree"), 91, r"modes.degree: received 91; needs a number of at most 90"),
    (("hydro", "rows"), False, r"hydro.rows: received False; a number is needed"),
    (("hydro", "tolerance"), 1.0, r"hydro.tolerance: received 1.0; needs a number of at most 0.1"),
    (("hydro", "omega"), [1.0, 1.0], r"hydro: omega \[1.0, 1.0\]: frequencies must ascend without repetition"),
    (("designs",), {"A": {"clamp": [10, -1]}}, r"designs.A.clamp.1: received -1; needs a number of at least 0"),
    (("designs",), {"A": {"clamp": True}}, r"designs.A.clamp: received True; a number is needed"),
    (("designs",), {"A B": {}}, r"designs.A B: received 'A B'; needs letters, digits and _"),
    (("waves",), [{"kind": "regular", "amplitude": 0.1, "period": 2, "phase": 1}], r"waves.0.phase: received 1; unknown key"),
    (("waves",), [{"kind": "white_noise", "hs": 1, "band": [2.0, 2.001]}], r"waves.0.band: .*one at least 1 % higher"),
    (("waves",), [{"kind": "white_noise", "hs": 1, "band": [2.0, 20.0]}], r"waves.0.band .*needs at most hydro.omega_max = 12"),
    (("water", "depth"), 1e5, r"water.depth: .*needs at most 20000 m, or .inf for deep water"),
    (("hydro",), {"power_tolerance": 0.1}, r"power_tolerance 0.1: only model auto has one"),
    (("hydro",), {"model": "assumed_pressure"}, r"hydro: pressure: missing; model assumed_pressure needs its amplitude in Pa"),
    (("hydro",), {"pressure": 0.0}, r"hydro: pressure 0 Pa: only model assumed_pressure has one; remove it"),
    (("hydro",), {"model": "auto", "power_tolerance": 0.9}, r"hydro.power_tolerance: received 0.9"),
    (("waves",), [{"kind": "jonswap", "hs": 1, "tp": 0.4}], r"waves.0 jonswap_Hs1_Tp0.4_g3.3_s1: the wave is too short"),
    (("waves",), [{"kind": "jonswap", "hs": 1, "tp": 8, "gamma": 0.5}], r"waves.0.gamma: received 0.5; needs a number of at least 1"),
    (("simulation", "window"), [50, 50], r"simulation: window \[50.0, 50.0\]: needs 0 <= start < end"),
    (("simulation", "window"), [60], r"simulation.window.1: .*required"),
    (("pto", "damping"), "soft", r"pto.damping: received 'soft'; needs a number"),
    (("study",), "a" * 65, r"study: received 'a+'; needs at most 64 characters"),
    (("waves",), [{"kind": "jonswap", "hs": 1, "tp": 4, "seed": 10**400}], r"waves.0: seed of 401 digits: needs at most 2\^32"),
    (("hydro", "accept"), ["haskind", "haskin"], r"hydro.accept \['haskin'\]: no such check; needs some of error_estimate, .*haskind"),
    (("study",), "logs", r"study: received 'logs'; 'logs' is the name of a results folder"),
    (("study",), "benchmarks", r"study: received 'benchmarks'; .*choose a name other than hydro, hydro_precision, barge, logs, benchmarks"),
    (("study",), "hydro", r"study: received 'hydro'; 'hydro' is the name of a results folder"),
    (("study",), "../evil", r"study: received '../evil'; needs letters, digits and _"),
]  # fmt: skip


@pytest.mark.parametrize(("path", "value", "message"), BAD, ids=[".".join(map(str, p)) + f"={v}" for p, v, _ in BAD])
def test_bad_value_is_one_line_with_file_key_and_need(tmp_path, path, value, message):
    file = tmp_path / "bad.yaml"
    file.write_text(yaml.safe_dump(changed(path, value)))
    with pytest.raises(ConfigError, match=message) as error:
        config.load(file)
    assert re.match(rf"{re.escape(str(file))}:\d+: ", str(error.value))
    assert "\n" not in str(error.value)


def test_one_clamp_may_stand_alone():
    assert config.Design(clamp=45) == config.Design(clamp=[45.0])


@pytest.mark.parametrize(
    ("wave", "label", "words"),
    [
        ({"kind": "still"}, "still", "still water"),
        (
            {"kind": "regular", "amplitude": 0.179, "period": 2.5},
            "regular_A0.179_T2.5",
            "regular waves of 0.179 m amplitude and 2.5 s period",
        ),
        (
            {"kind": "jonswap", "hs": 0.5, "tp": 4, "seed": 7},
            "jonswap_Hs0.5_Tp4_g3.3_s7",
            "a JONSWAP sea of Hs = 0.5 m and Tp = 4 s",
        ),
        (
            {"kind": "pierson_moskowitz", "hs": 0.5, "tp": 4, "seed": 7},
            "pierson_moskowitz_Hs0.5_Tp4_s7",
            "a Pierson-Moskowitz sea of Hs = 0.5 m and Tp = 4 s",
        ),
        (
            {"kind": "white_noise", "hs": 0.5, "band": [1, 3], "seed": 7},
            "white_noise_Hs0.5_w1-3_s7",
            "white noise of 1 to 3 rad/s and Hs = 0.5 m",
        ),
    ],
)
def test_labels_and_words_of_seas(seed, wave, label, words):
    (read,) = varied(seed, waves=[wave]).waves
    assert (read.label, read.description) == (label, words)


def test_figures_are_published_of_designs_there_are(seed):
    published = {"source": "x", "values": {"FSB": {"energy": 1.0}, "VSWEC45": {"energy": 2.0}}}
    with pytest.raises(
        ConfigError, match=r"published.values \['VSWEC45'\]: no such design; needs some of FSB, VSWEC, "
    ):
        config.parse({**seed.model_dump(), "published": published})


def test_checks_a_study_may_accept_are_those_there_are():
    """Names are known before anything is solved; every literal of the module is offered as the name of an estimate."""
    tree = ast.parse((EXAMPLE.parents[1] / "vsb" / "hydro" / "quality.py").read_text(encoding="utf-8"))
    literals = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}
    omega = np.arange(1, 9) * 0.5
    pair = ("influenced_dof", "radiating_dof")
    square = np.tile(np.eye(2), (8, 1, 1))
    ds = xr.Dataset(
        {
            "added_mass": (("omega", *pair), square),
            "radiation_damping": (("omega", *pair), square),
            "added_mass_inf": (pair, np.eye(2)),
            "excitation_force": (("omega", "wave_direction", "influenced_dof"), np.ones((8, 1, 2)) + 0j),
        },
        coords={"omega": omega},
    )
    estimates = [dict.fromkeys((name for name in literals if isinstance(name, str)), 0.0)]
    found = [
        *quality.pointwise_checks(ds, Water(density=1e3)),
        *quality.sweep_checks(ds),
        *quality.estimate_checks(estimates, 1e-3),
    ]
    assert sorted(check.name for check in found) == sorted(config.CHECKS)
    assert len(set(config.CHECKS)) == len(config.CHECKS)


@pytest.mark.parametrize("name", config.CHECKS)
def test_every_check_may_be_accepted(name):
    assert config.parse(changed(("hydro", "accept"), [name])).hydro.accept == (name,)


def test_limits_of_sections_are_part_of_them():
    assert Water(depth=DEEPEST).depth == DEEPEST
    with pytest.raises(ValueError, match=r"needs at most 20000 m, or .inf for deep water"):
        Water(depth=1.0001 * DEEPEST)
    assert Hydro(model="assumed_pressure", pressure=0.0).pressure == 0.0
    with pytest.raises(ValueError, match="pressure 0 Pa: only model assumed_pressure has one; remove it"):
        Hydro(pressure=0.0)
    assert Simulation(duration=60.0, window=(0.0, 60.0)).window == (0.0, 60.0)
    for window in ((0.0, 60.001), (5.0, 5.0), (6.0, 5.0)):
        with pytest.raises(ValueError, match=r"needs 0 <= start < end <= duration = 60 s"):
            Simulation(duration=60.0, window=window)
    for model in ("linear", "body_exact", "assumed_pressure"):
        pressure = {"pressure": 5.0} if model == "assumed_pressure" else {}
        with pytest.raises(ValueError, match=r"power_tolerance 0\.1: only model auto has one; remove it"):
            Hydro(model=model, power_tolerance=0.1, **pressure)
    for model in ("linear", "body_exact", "auto"):
        with pytest.raises(ValueError, match="pressure 5 Pa: only model assumed_pressure has one; remove it"):
            Hydro(model=model, pressure=5.0)
    for omega in ((1.0, 1.0), (2.0, 1.0)):
        with pytest.raises(ValueError, match="frequencies must ascend without repetition"):
            Hydro(omega=omega)


def test_a_rigid_design_has_no_clamps_one_or_many():
    for clamp in (90.0, (0.0, 90.0), (0.0,)):
        assert Design(clamp=clamp).flexible
        told = ", ".join(map(str, clamp if isinstance(clamp, tuple) else (clamp,)))
        with pytest.raises(
            ValueError, match=rf"clamp \[{told}\]: a rigid design \(flexible: false\) has no shell to clamp"
        ):
            Design(flexible=False, clamp=clamp)
    assert Design(clamp=(0.0, 90.0)).clamp == (0.0, 90.0)
