"""Buoys that surge and pitch or move freely, from study to report: decoupled orders, radiation limits, drag, moorings."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import SEED

from vsb.engine.hydro.database import load_database
from vsb.engine.integrators.audit import energies, residual
from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.integrators.simulate import simulate
from vsb.engine.waves.water import power_limit
from vsb.errors import ConfigError
from vsb.models.build import linear_design
from vsb.models.floating_system import floating_system, port_in_seas, study_sea
from vsb.models.rest import check_moored, check_stable, check_upright, reference_shell
from vsb.models.take_off import LINEARISED
from vsb.models.viability import viability
from vsb.pipeline.graph import StudyPlan
from vsb.report.figures import forecast
from vsb.results.gains import worth_of_knowledge
from vsb.results.ladder import study_ladder
from vsb.stages import make
from vsb.stages.stage import run_task
from vsb.study.study import load, parse
from vsb.tools.files import load as load_data

CALM = {"kind": "regular", "amplitude": 0.1, "period": 3.0}
RAW = load(SEED).model_dump() | {
    "study": "planar", "motion": "planar", "modes": {"basis": "membrane", "degree": 2, "order": 2},
    "designs": {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC0": {"clamp": 0.0}}, "waves": [CALM],
    "mooring": [2e4, 0, 0, 0, 0, 0], "simulation": {"duration": 60.0, "window": [48.0, 60.0]},
}  # fmt: skip
RAW["device"] |= {"centre_of_mass": -0.6, "ballast_inertia": 9e3, "damping": {"beta": 0.0}}
RAW["hydro"] |= {"omega_max": 6.0, "witness": "none"}
HYDRO = ("modes", "spectral", "database", "radiation")


def study_with(**changes):
    data = dict(RAW)
    for name, update in changes.items():
        merged = isinstance(update, dict) and name not in ("designs", "drag")
        data[name] = {**data[name], **update} if merged else update
    return parse(data)


def made(study, folder, stages=HYDRO):
    """The plan of a study of which some stages were run."""
    plan = StudyPlan(study, root=str(folder))
    for task in plan.tasks:
        if task.stage in stages and not all(Path(path).exists() for path in task.makes):
            run_task(task)
    return plan


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("planar")


@pytest.fixture(scope="module")
def solved(folder):
    """A moored buoy in surge, heave and pitch, its hydrodynamics alone."""
    return made(study_with(), folder)


@pytest.fixture(scope="module")
def finished(folder):
    """The whole chain of a moored buoy under a damper on heave."""
    make.run(StudyPlan(study_with(), root=str(folder)))
    return StudyPlan(study_with(), root=str(folder))


@pytest.fixture(scope="module")
def heaving(folder):
    """The same buoy in heave alone."""
    data = {key: value for key, value in RAW.items() if key not in ("motion", "mooring")}
    data |= {"study": "heaving", "modes": {"basis": "membrane", "degree": 2}}
    return made(parse(data), folder, (*HYDRO, "response", "simulate"))


def responses(*plans):
    """Responses at the frequencies they share: beside its own resonances each has more."""
    found = [load_data(plan.response.out) for plan in plans]
    shared = np.intersect1d(*(one.omega for one in found))
    assert len(shared) > 100
    return [one.sel(omega=shared) for one in found]


@pytest.mark.slow
def test_take_off_on_heave_is_decoupled_from_other_orders(finished, heaving):
    """To round-off, in the response and in time."""
    both, alone = responses(finished, heaving)
    for name in ("absorbed_power", "port_impedance", "matched_power", "best_damping"):
        np.testing.assert_allclose(both[name], alone[name], rtol=1e-9, atol=1e-9 * np.abs(alone[name]).max())
    np.testing.assert_allclose(both.rao.sel(dof=alone.dof), alone.rao, atol=1e-11)
    assert not both.attrs.get("limit")
    for design in RAW["designs"]:
        runs = [load_data(f"{plan.folder}/trajectories/{design}-regular_A0.1_T3.nc") for plan in (finished, heaving)]
        np.testing.assert_allclose(*(run.position.sel(dof="Heave") for run in runs), atol=1e-6)  # memories fitted apart
        np.testing.assert_allclose(*(run.attrs["steady_power"] for run in runs), rtol=1e-6)
        assert runs[0].attrs["energy_residual"] < 1e-9


@pytest.mark.slow
def test_checks_and_report_include_surge_and_pitch(finished):
    checks = json.loads(Path(finished.folder, "validity.json").read_text())["checks"]
    named = {(check["name"], check["design"]): check for check in checks}
    assert {
        ("pitch", "FSB"),
        ("surge", "VSWEC"),
        ("deformation", "VSWEC"),
        ("constraint_drift", "VSWEC0"),
    } <= named.keys()
    assert named["constraint_drift", "VSWEC0"]["verdict"] == "ok"
    for design in RAW["designs"]:
        assert named["time_and_frequency_domain", design]["value"] < 5e-3
    orders = [check for check in checks if check["name"] == "hydro haskind"]
    assert [check["explanation"][:8] for check in orders] == ["damping ", "order 1:", "order 2:"]
    assert all(check["verdict"] == "ok" for check in orders)
    page = Path(finished.folder, "report.html").read_text()
    assert "Surge, heave and pitch" in page


def test_database_has_pitch_stiffness_and_mooring(solved):
    ds = load_database(solved.database.out, Path(solved.database.out).stem)
    pitch, surge = ({"influenced_dof": name, "radiating_dof": name} for name in ("Pitch", "Surge"))
    mass = RAW["device"]["mass"]
    assert ds.hydrostatic_stiffness.sel(pitch).item() == pytest.approx(mass * 9.81 * 0.6, rel=1e-10)
    assert ds.mooring_stiffness.sel(surge).item() == 2e4
    assert ds.mooring_stiffness.values.sum() == 2e4
    assert ds.inertia_matrix.sel(influenced_dof="Surge", radiating_dof="Pitch").item() == pytest.approx(-0.6 * mass)
    assert ds.azimuthal_order.values.tolist() == [0, 0, 0, 0, 1, 1, 1, 1, 2]
    assert "order 2 from excitation" in ds.attrs["history"]
    for matrix in (ds.inertia_matrix, ds.hydrostatic_stiffness, ds.added_mass[3]):
        np.testing.assert_allclose(matrix, matrix.values.T, atol=1e-9 * np.abs(matrix).max())


def test_capsizing_buoy_is_refused_unless_moored():
    top = study_with(device={"centre_of_mass": 0.2}, mooring=None)
    reference = reference_shell(top)
    match = (
        r"device.centre_of_mass: received 0.2 m above the sphere's centre, with which the buoy does not stay upright"
    )
    with pytest.raises(ConfigError, match=match):
        check_stable(top, reference)
    with pytest.raises(ConfigError, match=r"received 0 m .* \(stiffness of pitch 0 N m\)"):
        check_upright(study_with(device={"centre_of_mass": 0.0}, mooring=None), reference)
    held = study_with(device={"centre_of_mass": 0.2}, mooring=[0, 0, 0, 0, 5e5, 0])
    check_upright(held, reference_shell(held))
    check_stable(study_with(mooring=None), reference_shell(study_with(mooring=None)))  # surge alone may drift


def test_mooring_that_couples_surge_and_pitch_must_be_positive():
    """The square of the coupling must be below the product of the stiffnesses."""
    for centre, held in ((-0.6, 0.0), (0.2, 5e5)):
        pitch = -RAW["device"]["mass"] * 9.81 * centre + held
        for share in (0.999, 1.001, -0.999, -1.001):
            rows = np.diag([2e4, 0.0, 0.0, 0.0, held, 0.0])
            rows[0, 4] = rows[4, 0] = share * np.sqrt(2e4 * pitch)
            study = study_with(
                designs={"FSB": {"flexible": False}}, device={"centre_of_mass": centre}, mooring=rows.tolist()
            )
            reference = reference_shell(study)
            check_upright(study, reference)
            if abs(share) < 1:
                check_stable(study, reference)
            else:
                with pytest.raises(
                    ConfigError, match=r"^mooring: received a stiffness that drives .*, most in surge; "
                ):
                    check_stable(study, reference)
                assert viability(study).reasons["FSB"].startswith("unstable: least stiffness -")


@pytest.mark.parametrize(("place", "name"), [(0, "surge"), (2, "heave")])
def test_repelling_mooring_is_refused(place, name):
    """The waterplane stiffness rho g pi r^2 opposes it in heave, nothing in surge."""
    water = 1025.0 * 9.81 * np.pi * 2.0**2 if name == "heave" else 0.0
    for push in (0.999 * water, 1.001 * water + 1.0):
        study = study_with(**{**FREE, "mooring": (-push * np.eye(6)[place]).tolist()})
        reference = reference_shell(study)
        if push <= water:
            check_moored(study, reference)
            continue
        with pytest.raises(ConfigError, match=rf"^mooring: received .* out of its rest, most in {name}; needs one"):
            check_moored(study, reference)


PORTS = {
    "surge": ("surge", 2), "line": ({"line_to": [12.0, -9.0], "line_from": [0.0, -1.0]}, 3),
}  # fmt: skip
"""Port, and the limit of its power in terms of wavelength/2 pi."""


@pytest.mark.parametrize(("port", "limit"), PORTS.values(), ids=PORTS)
def test_matched_power_is_limited_by_the_orders_of_the_port(folder, port, limit):
    """Without structural damping a port of one order absorbs all of it."""
    plan = made(study_with(study="port", pto={"port": port}), folder, (*HYDRO, "response"))
    ds = load_data(plan.response.out)
    sharp = [power_limit(w, np.inf, RAW["water"]["density"], 9.81) for w in ds.omega.values]
    np.testing.assert_allclose(ds.power_limit, limit * np.array(sharp), rtol=1e-12)
    assert ds.attrs.get("limit") == (None if limit == 1 else f"{limit} λ/2π")
    share = (ds.matched_power.sel(design="VSWEC") / ds.power_limit).values
    assert (share < 1 + 2e-4).all()
    if limit < 3:
        np.testing.assert_allclose(share[20:], 1.0, rtol=2e-4)
    Path(plan.response.out).unlink()


@pytest.mark.parametrize(
    ("port", "mooring"), [("surge", None), pytest.param("pitch", [2e4, 0, 0, 0, 0, 0], marks=pytest.mark.slow)]
)
def test_mean_power_in_time_agrees_with_the_response(folder, port, mooring):
    """A damper on surge or pitch, moored or unrestrained."""
    study = study_with(study="port", pto={"port": port, "damping": 6000.0}, mooring=mooring,
                       designs=RAW["designs"], simulation={"duration": 120.0, "window": [90.0, 120.0]})  # fmt: skip
    plan = made(study, folder)
    at = linear_design(plan.simulation("VSWEC", study.waves[0]).spec["run"], plan.hydro_files)
    motion, _, method = simulate(at.system, at.sea, study.simulation, at.spectrum)
    assert method == "exact propagation"
    energy = energies(at.system, motion)
    assert residual(energy) < 1e-9
    last = motion.time >= 90.0 - 1e-9
    mean = np.polyfit(motion.time[last], energy["pto"][last], 1)[0]
    seen = floating_system(study, plan.database.out).ports(np.array([2 * np.pi / 3]))["VSWEC"]
    power = seen.power(6000.0)[0] * 0.1**2
    assert mean == pytest.approx(power, rel=5e-3)


OBLIQUE = 30.0
FREE = {"motion": "free", "mooring": [2e4, 2e4, 0, 0, 0, 0], "device": {"ballast_yaw_inertia": 7e3}}


@pytest.fixture(scope="module")
def free(folder):
    """The whole chain of a buoy free to move, in the same wave from two sides; a line pulls it obliquely."""
    waves = [CALM | {"direction": OBLIQUE}, CALM]
    pto = {"port": {"line_to": [12.0, -9.0]}, "tuning": "one", "damping": None}
    study = study_with(**FREE, study="free", waves=waves, pto=pto)
    make.run(StudyPlan(study, root=str(folder)))
    return StudyPlan(study, root=str(folder))


@pytest.fixture(scope="module")
def free_solved(folder):
    """A buoy free to move in waves from two sides, its hydrodynamics and response alone."""
    study = study_with(**FREE, study="turned", waves=[CALM | {"direction": OBLIQUE}, CALM])
    return made(study, folder, (*HYDRO, "response"))


def in_waves(plan, direction, name="rao"):
    """Part of the response of the free shell in waves of a direction [degrees]."""
    ds = load_data(plan.response.out).sel(design="VSWEC")
    return ds[name].sel(wave_direction=np.deg2rad(direction), method="nearest")


def test_response_in_oblique_waves_is_the_rotated_one(free_solved):
    """Order m goes with cos and sin of m times the direction; roll is minus pitch."""
    here, along = in_waves(free_solved, OBLIQUE), in_waves(free_solved, 0.0)
    cos, sin = (f(np.deg2rad(OBLIQUE)) for f in (np.cos, np.sin))
    shares = {
        ("Heave", "Heave"): 1.0, ("Membrane2", "Membrane2"): 1.0, ("Surge", "Surge"): cos, ("Sway", "Surge"): sin,
        ("Pitch", "Pitch"): cos, ("Roll", "Pitch"): -sin, ("Membrane2s1", "Membrane2c1"): sin,
        ("Membrane2c2", "Membrane2c2"): cos**2 - sin**2, ("Membrane2s2", "Membrane2c2"): 2 * sin * cos,
    }  # fmt: skip
    for (turned, straight), share in shares.items():
        np.testing.assert_allclose(here.sel(dof=turned), share * along.sel(dof=straight), rtol=1e-9, atol=1e-14)
    assert not np.any(here.sel(dof="Yaw"))


@pytest.mark.slow
def test_powers_of_the_free_buoy_agree_in_time_and_frequency(free):
    checks = json.loads(Path(free.folder, "validity.json").read_text())["checks"]
    agreed = [check for check in checks if check["name"] == "time_and_frequency_domain"]
    assert len(agreed) == 2 * len(RAW["designs"])
    assert max(check["value"] for check in agreed) < 5e-3
    assert all(check["verdict"] == "ok" for check in checks if check["name"] in ("energy_residual", "power_limit"))
    rows = [load_data(free.simulation("FSB", wave).out) for wave in free.study.waves]
    oblique, along = (row.attrs["steady_power"] for row in rows)
    assert oblique != pytest.approx(along, rel=3e-3)
    assert rows[0].attrs["tuned_damping"] == rows[1].attrs["tuned_damping"], "one damper for both"
    page = Path(free.folder, "report.html").read_text()
    assert "going to 30 degrees" in page


def test_yaw_has_inertia_but_moves_no_water(free_solved):
    ds = load_database(free_solved.database.out, Path(free_solved.database.out).stem)
    yaw = ds.sel(influenced_dof="Yaw", radiating_dof="Yaw")
    shell = 4 * np.pi * 2.0**2 * 0.01 * 2700.0
    assert yaw.inertia_matrix.item() == pytest.approx(2 / 3 * shell * 2.0**2 + 7e3, rel=1e-12)
    for name in (
        "added_mass",
        "radiation_damping",
        "hydrostatic_stiffness",
        "structural_stiffness",
        "excitation_force",
    ):
        assert not np.any(yaw[name])
    assert ds.azimuthal_order.values.tolist() == [0, 0, 0, 0, 1, 1, 1, 1, -1, -1, -1, -1, 2, -2, 0]
    np.testing.assert_allclose(ds.wave_direction, [0, np.pi / 4, np.pi / 2])


DRAG = {
    "surge": {"coefficient": 1.0, "area": 6.28}, "heave": {"coefficient": 1.0, "area": 12.57},
    "pitch": {"coefficient": 1.0, "area": 3.0, "lever": 2.0},
}  # fmt: skip
ASIDE = {"sway": DRAG["surge"], "roll": DRAG["pitch"], "yaw": DRAG["pitch"]}
SWELL = {"kind": "regular", "amplitude": 0.3, "period": 4.0}


def dragged(**changes):
    """A moored buoy under a damper on a line, in a swell that drags it."""
    changes = {"drag": DRAG, "waves": [SWELL], "pto": {"port": {"line_to": [12.0, -9.0]}, "damping": 9000.0}} | changes
    return study_with(
        study="dragged", designs=RAW["designs"], simulation={"duration": 40.0, "window": [30.0, 40.0]}, **changes
    )


@pytest.mark.slow
def test_quadratic_drag_agrees_with_its_equivalent_dampers(folder):
    """Harmonic balance against equivalent linearisation; the energy balance of the run closes."""
    study = dragged()
    plan = made(study, folder)
    at = linear_design(plan.simulation("VSWEC", study.waves[0]).spec["run"], plan.hydro_files)
    found = harmonic_balance(at.system)
    assert at.notes[LINEARISED] == pytest.approx(found.power.pto, rel=5e-3)
    assert len(at.notes["drag_damping"]) == 3
    without = made(dragged(drag=None), folder)
    free = linear_design(without.simulation("VSWEC", study.waves[0]).spec["run"], plan.hydro_files)
    assert harmonic_balance(free.system).power.pto > 1.02 * found.power.pto
    motion, _, method = simulate(at.system, at.sea, study.simulation, at.spectrum)
    assert method.startswith("exponential collocation")
    assert residual(energies(at.system, motion)) < 1e-6


def test_drag_rotates_with_the_waves(folder):
    """In waves along y sway and roll are braked as surge and pitch are along x; nothing brakes what stands still."""
    along = dragged(**FREE, drag=DRAG | ASIDE, pto={"port": "heave", "damping": 9000.0})
    across = dragged(
        **FREE, drag=DRAG | ASIDE, pto={"port": "heave", "damping": 9000.0}, waves=[SWELL | {"direction": 90.0}]
    )
    plan = made(along, folder)
    runs = [
        StudyPlan(study, root=str(folder)).simulation("FSB", study.waves[0]).spec["run"] for study in (along, across)
    ]
    x, y = (linear_design(run, plan.hydro_files) for run in runs)
    surge, sway, heave, roll, pitch, yaw = x.notes["drag_damping"]
    assert sway == roll == yaw == 0.0
    assert min(surge, heave, pitch) > 0.0
    turned = y.notes["drag_damping"]
    np.testing.assert_allclose(turned, [0.0, surge, heave, pitch, 0.0, 0.0], rtol=1e-9, atol=1e-9 * surge)
    assert y.notes[LINEARISED] == pytest.approx(x.notes[LINEARISED], rel=1e-9)


def spread(s):
    return {"kind": "jonswap", "hs": 0.5, "tp": 3.5, "spreading": {"s": s, "directions": 7}}


def test_a_port_that_no_wave_moves_has_a_figure_that_says_so(folder):
    """Sway in waves along x."""
    wave = {"kind": "jonswap", "hs": 0.5, "tp": 3.5}
    port = {"damping": 1.9e4, "port": {"dof": "Sway"}}
    study = study_with(**FREE, waves=[wave], pto=port, designs={"FSB": {"flexible": False}})
    floating = floating_system(study, made(study, folder).database.out)
    found = worth_of_knowledge(study, floating, study.waves[0])
    assert (found.over_forecast.shape[0], found.over_noise.shape[0], found.damper.size) == (0, 0, 0)
    (text,) = forecast(SimpleNamespace(knowledge={"sea": found}), "sea").axes[0].texts
    assert text.get_text() == "waves move no design's port"


@pytest.mark.parametrize(("s", "count"), [(10.0, 9), (2.0, 31)])
def test_powers_in_a_spread_sea_are_those_of_its_law(folder, s, count):
    """At a surging port E cos^2 of the directions is left of every power, whatever turns they take in a run."""
    waves = [{**spread(s), "spreading": {"s": s, "directions": count}}]
    waves.append({key: value for key, value in waves[0].items() if key != "spreading"})
    study = study_with(waves=waves, pto={"damping": 1.9e4, "port": "surge"}, designs={"FSB": {"flexible": False}})
    short, long = (wave.label for wave in study.waves)
    levels = study_ladder(study, made(study, folder).database.out)
    found = {(level.wave, level.rung): level.power_mean for level in levels}
    for rung in ("fixed", "best_damper", "causal", "matched"):
        left = found[short, rung] / found[long, rung]
        assert left == pytest.approx(0.5 + 0.5 * s * (s - 1) / ((s + 1) * (s + 2)), rel=2e-4), rung


def test_spread_sea_moves_a_surging_port_by_the_cosine_of_each_direction(folder):
    """The same amplitudes, V0 of every component times cos; s = 1e4 is the long-crested sea; heave does not know."""
    waves = [{key: value for key, value in spread(4).items() if key != "spreading"}, spread(4), spread(1e4)]
    for port, power in (("surge", lambda angle: np.cos(angle) ** 2), ("heave", np.ones_like)):
        study = study_with(waves=waves, pto={"damping": 1.9e4, "port": port})
        floating = floating_system(study, made(study, folder).database.out)
        seas = [(wave, study_sea(study, wave, floating.linear.database)) for wave in study.waves]
        found = port_in_seas(floating, "FSB", seas)
        squares = [np.abs(found.port.velocity[place]) ** 2 for place in found.places]
        assert squares[1] == pytest.approx(squares[0] * power(np.radians(seas[1][1].heading)), rel=1e-9)
        energy = [float(np.sum(one * np.abs(sea.amplitude) ** 2)) for one, (_, sea) in zip(squares, seas, strict=True)]
        assert energy[2] == pytest.approx(energy[0], rel=1e-3)
        assert energy[1] <= energy[0] * (1 + 1e-12)
