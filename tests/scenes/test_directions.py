"""A buoy that surges and pitches, from its study to its report: what couples with heave, what does not."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from conftest import SEED

from vsb.errors import ConfigError, ConvergenceError
from vsb.hydro.database import load_database
from vsb.integrators.audit import energies, residual
from vsb.integrators.harmonic_balance import harmonic_balance
from vsb.integrators.simulate import simulate
from vsb.motion.port import port_direction
from vsb.results.ladder import study_ladder
from vsb.results.run_checks import dampers_in_words
from vsb.scenes.afloat import towards
from vsb.scenes.build import linear_buoy, linear_design
from vsb.scenes.directions import (
    check_moored,
    check_upright,
    loaded_shell,
    mooring_stiffness,
    order_bases,
    order_stiffness,
    whole_labels,
    whole_stiffness,
)
from vsb.scenes.drag import LINEARISED
from vsb.scenes.rest import check_spring, check_stable, design_motions, reference_shell, study_basis
from vsb.scenes.viability import viability
from vsb.shell.elastic import ElasticShell
from vsb.shell.loaded import LoadedShell
from vsb.shell.order_prestress import prestress_stiffness
from vsb.stages import make
from vsb.stages.simulate import _steady
from vsb.study.plan import StudyPlan
from vsb.study.study import load, parse
from vsb.tools.files import load as load_data
from vsb.waves.dispersion import power_limit

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
    for job in make.jobs(plan):
        if job.stage in stages and not all(Path(path).exists() for path in job.makes):
            job.run()
    return plan


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("planar")


@pytest.fixture(scope="module")
def finished(folder):
    """The whole chain of a moored buoy under a damper on heave."""
    make.run(study_with(), folder)
    return StudyPlan(study_with(), root=str(folder))


@pytest.fixture(scope="module")
def heaving(folder):
    """The same buoy in heave alone."""
    data = {key: value for key, value in RAW.items() if key not in ("motion", "mooring")}
    data |= {"study": "heaving", "modes": {"basis": "membrane", "degree": 2}}
    return made(parse(data), folder, (*HYDRO, "response", "simulate"))


# the chain ----------------------------------------------------------------------------------------------------------


def responses(*plans):
    """Responses at the frequencies they share: beside its own resonances each has more."""
    found = [load_data(plan.response_files["response"]) for plan in plans]
    shared = np.intersect1d(*(one.omega for one in found))
    assert len(shared) > 100
    return [one.sel(omega=shared) for one in found]


def test_a_take_off_on_heave_sees_nothing_of_other_directions(finished, heaving):
    """To round-off: orders do not mix, in response and in time."""
    both, alone = responses(finished, heaving)
    for name in ("absorbed_power", "port_impedance", "matched_power", "best_damping"):
        np.testing.assert_allclose(both[name], alone[name], rtol=1e-9, atol=1e-9 * np.abs(alone[name]).max())
    np.testing.assert_allclose(both.rao.sel(dof=alone.dof), alone.rao, atol=1e-11)
    assert not both.attrs.get("limit")
    for design in RAW["designs"]:
        runs = [load_data(plan.trajectory_path(design, "regular_A0.1_T3")) for plan in (finished, heaving)]
        np.testing.assert_allclose(*(run.position.sel(dof="Heave") for run in runs), atol=1e-6)  # memories fitted apart
        np.testing.assert_allclose(*(run.attrs["steady_power"] for run in runs), rtol=1e-6)
        assert runs[0].attrs["energy_residual"] < 1e-9


def test_the_ledger_and_the_report_tell_of_directions(finished):
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


def test_modes_of_all_orders_are_written_and_drawn(finished):
    modes = load_data(f"{finished.folder}/modes.nc")
    assert modes.order.values.tolist() == [0, 0, 0, 1, 1, 2]
    dry = dict(zip(modes.mode.values, modes.dry_frequency.values, strict=True))
    assert dry["Membrane2c1"] == pytest.approx(dry["Membrane2"], rel=1e-12)  # degenerate in m
    assert dry["Membrane2c2"] == pytest.approx(dry["Membrane2"], rel=1e-12)
    assert Path(finished.folder, "figures", "directions-regular_A0.1_T3.svg").exists()


# structure ----------------------------------------------------------------------------------------------------------


def test_the_database_holds_pitch_of_the_weight_alone_and_the_mooring(finished):
    ds = load_database(finished.database_path, Path(finished.database_path).stem)
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


def test_mooring_acts_on_the_motions_it_names():
    rows = np.zeros((6, 6))
    rows[0, 0], rows[2, 2], rows[0, 4], rows[4, 0] = 1.0, 2.0, 3.0, 3.0
    study = study_with(mooring=rows.tolist())
    found = mooring_stiffness(study, ("Heave", "Membrane0", "Surge", "Pitch"))["mooring"]
    np.testing.assert_array_equal(found, [[2.0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 1.0, 3.0], [0, 0, 3.0, 0]])
    assert mooring_stiffness(study_with(mooring=None), ("Heave",)) == {}


def test_a_buoy_that_falls_over_is_refused_and_a_mooring_may_hold_it():
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


def test_a_mooring_may_couple_surge_and_pitch_as_far_as_both_are_held():
    """A quadratic form is positive as long as the square of its coupling is below the product of the stiffnesses.

    That of pitch is m g 0.6 m; with a mooring that outweighs a centre of mass above that of the sphere as without one.
    """
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


@pytest.mark.parametrize(("place", "name"), [(0, "surge"), (1, "sway"), (2, "heave"), (5, "yaw")])
def test_a_mooring_that_pushes_is_refused_by_the_motion_it_pushes(place, name):
    """Heave has the water's rho g pi r^2 against it, the others nothing."""
    water = 1025.0 * 9.81 * np.pi * 2.0**2 if name == "heave" else 0.0
    for push in (0.999 * water, 1.001 * water + 1.0):
        study = study_with(**{**FREE, "mooring": (-push * np.eye(6)[place]).tolist()})
        reference = reference_shell(study)
        if push < water or push == 0.0:
            check_moored(study, reference)
        else:
            with pytest.raises(ConfigError, match=rf"^mooring: received .* out of its rest, most in {name}; needs one"):
                check_moored(study, reference)


def on_one_line(angle, **changes):
    """A free buoy on a single horizontal line below its centre, in waves along that line; yaw is held beside."""
    along, across = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    pull = np.array([along, across, 0.0, 1.5 * across, -1.5 * along, 0.0])
    rows = 2e4 * np.outer(pull, pull) + np.diag([0.0] * 5 + [1e4])
    waves = [CALM | {"direction": angle}]
    return study_with(**{**FREE, "mooring": rows.tolist(), "waves": waves, "pto": {"damping": 8000.0}} | changes)


@pytest.mark.parametrize("angle", [20.0, 110.0])
def test_what_a_single_line_leaves_drifts_at_any_angle(folder, angle):
    """Line and waves turned together: the same frequencies and power, and across the line no mean place."""
    runs, frequencies = [], []
    for study in (on_one_line(0.0, study="ahead"), on_one_line(angle, study=f"turned{angle:g}")):
        check_stable(study, reference_shell(study))
        plan = made(study, folder, (*HYDRO, "response"))
        frequencies.append(load_data(plan.response_files["response"]).wet_natural_frequency.values)
        runs.append([linear_design(plan.simulation(d, study.waves[0]), plan.hydro_files) for d in study.designs])
    np.testing.assert_allclose(*frequencies, rtol=1e-8)
    for ahead, turned in zip(*runs, strict=True):
        assert turned.system.scene.adrift
        powers = [_steady(run.system) for run in (ahead, turned)]
        assert powers[0] == pytest.approx(powers[1], rel=1e-8)
        with pytest.raises(ConvergenceError, match=r"^harmonic balance: nothing holds a coordinate in a mean place"):
            harmonic_balance(turned.system)


def test_a_buoy_held_all_round_is_not_adrift(folder):
    study = study_with(**FREE | {"mooring": [2e4, 1e4, 0, 0, 0, 1e3]}, study="held", pto={"damping": 8000.0})
    plan = made(study, folder)
    for design in study.designs:
        assert not linear_design(plan.simulation(design, study.waves[0]), plan.hydro_files).system.scene.adrift


def test_stiffness_of_all_orders_is_over_all_labels(finished):
    study = study_with()
    reference = reference_shell(study)
    ds = load_database(finished.database_path, Path(finished.database_path).stem)
    assert list(whole_labels(study, reference)) == ds.influenced_dof.values.tolist()
    parts = ds.structural_stiffness + ds.hydrostatic_stiffness + ds.mooring_stiffness
    np.testing.assert_allclose(whole_stiffness(study, reference), parts, rtol=1e-12, atol=1e-6)


def test_a_stroke_limit_needs_a_port_that_has_a_place():
    study = study_with(pto={"port": "surge", "stroke_limit": 0.5}, mooring=None)
    with pytest.raises(
        ConfigError, match=r"pto.stroke_limit: received 0.5 m, but nothing holds the port of design FSB"
    ):
        check_spring(study, reference_shell(study))
    check_spring(study_with(pto={"port": "surge"}, mooring=None), reference_shell(study))
    with pytest.raises(ConfigError, match=r"pto.stiffness: received -1 N/m, .*needs more than 0 N/m"):
        check_spring(study_with(pto={"port": "surge", "stiffness": -1.0}, mooring=None), reference_shell(study))


# ports --------------------------------------------------------------------------------------------------------------

PORTS = {
    "surge": ("surge", 2), "pitch": ("pitch", 2), "heave": ("heave", 1), "volume": ("volume", 1),
    "line": ({"line_to": [12.0, -9.0], "line_from": [0.0, -1.0]}, 3), "upright line": ({"line_to": [0.0, -9.0]}, 1),
    "between": ({"between": [40.0, 130.0]}, 5),
}  # fmt: skip
"""Port, and the limit of its power in terms of wavelength/2 pi."""


@pytest.mark.parametrize(("port", "limit"), PORTS.values(), ids=PORTS)
def test_matched_power_is_limited_by_the_orders_a_port_reaches(finished, folder, port, limit):
    """Without structural loss a port of one order takes all of it."""
    plan = made(study_with(study="port", pto={"port": port}), folder, ("response",))
    ds = load_data(plan.response_files["response"])
    sharp = [power_limit(w, np.inf, RAW["water"]["density"], 9.81) for w in ds.omega.values]
    np.testing.assert_allclose(ds.power_limit, limit * np.array(sharp), rtol=1e-12)
    assert ds.attrs.get("limit") == (None if limit == 1 else f"{limit} λ/2π")
    share = (ds.matched_power.sel(design="VSWEC") / ds.power_limit).values
    assert (share < 1 + 2e-4).all()
    if limit < 3:
        np.testing.assert_allclose(share[20:], 1.0, rtol=2e-4)
    Path(plan.response_files["response"]).unlink()


def test_ports_of_all_orders_together_take_one_plus_twice_n(finished):
    """1/8 V0^H (Re Y)^-1 V0 of one port of each order, radiated by the buoy as a whole."""
    buoy, basis = linear_buoy(study_with(), finished.database_path)
    motions, omega = design_motions(study_with(), basis, "VSWEC"), np.array([1.3, 2.1, 3.0])
    ports = np.eye(len(buoy.labels))[[buoy.labels.index(name) for name in ("Heave", "Pitch", "Membrane2c2")]]
    free = buoy.free_motion(omega, motions, ports[0])[0]
    forced = np.stack([buoy.free_motion(omega, motions, port)[1] @ ports.T for port in ports], axis=-1)
    velocity = -1j * omega[:, None] * (free @ ports.T)
    admittance = -1j * omega[:, None, None] * forced
    loss = (admittance + admittance.conj().transpose(0, 2, 1)) / 2
    power = np.real(np.einsum("wi,wi->w", velocity.conj(), np.linalg.solve(loss, velocity[..., None])[..., 0])) / 8
    for order, (w, found) in enumerate(zip(omega, power, strict=True)):
        assert found == pytest.approx(5 * power_limit(w, np.inf, 1025.0, 9.81), rel=2e-4), order


def test_a_line_lengthens_as_its_attachment_moves_away_from_its_anchor():
    """By differences of distances."""
    line = {"line_to": [12.0, -9.0], "line_from": [0.3, -1.0]}
    study = study_with(pto={"port": line})
    reference = reference_shell(study)
    direction = port_direction(study.pto.port, reference.shape, order_bases(study, reference.basis))
    b = dict(zip(whole_labels(study, reference), direction, strict=True))

    def length(surge, heave, pitch):
        x, z = 0.3 * np.cos(pitch) - 1.0 * np.sin(pitch), -1.0 * np.cos(pitch) - 0.3 * np.sin(pitch)
        return np.hypot(surge + x - 12.0, study.centre_height + heave + z + 9.0)

    h = 1e-6
    for name, step in (("Surge", (h, 0, 0)), ("Heave", (0, h, 0)), ("Pitch", (0, 0, h))):
        slope = (length(*step) - length(*(-s for s in step))) / (2 * h)
        assert b[name] == pytest.approx(slope, rel=1e-8)
    assert {name for name, share in b.items() if share} == {"Surge", "Heave", "Pitch"}


# time ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("port", "mooring"), [("surge", None), ("pitch", [2e4, 0, 0, 0, 0, 0])])
@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_mean_power_in_time_is_that_of_the_response_and_the_audit_closes(folder, finished, port, mooring, design):
    """A damper on surge or pitch, moored or adrift: 0.5 % and 1e-6 are promised."""
    study = study_with(study="port", pto={"port": port, "damping": 6000.0}, mooring=mooring,
                       designs=RAW["designs"], simulation={"duration": 120.0, "window": [90.0, 120.0]})  # fmt: skip
    plan = made(study, folder)
    at = linear_design(plan.simulation(design, study.waves[0]), plan.hydro_files)
    motion, _, method = simulate(at.system, at.sea, study.simulation, at.spectrum)
    assert method == "exact propagation"
    energy = energies(at.system, motion)
    assert residual(energy) < 1e-9
    last = motion.time >= 90.0 - 1e-9
    mean = np.polyfit(motion.time[last], energy["pto"][last], 1)[0]
    buoy, basis = linear_buoy(study, plan.database_path)
    omega = np.array([2 * np.pi / 3])
    b = np.eye(len(buoy.labels))[buoy.labels.index(port.capitalize())]
    power = buoy.port(omega, design_motions(study, basis, design), b).power(6000.0)[0] * 0.1**2
    assert mean == pytest.approx(power, rel=5e-3)


# free: to all sides -------------------------------------------------------------------------------------------------

OBLIQUE = 30.0
FREE = {"motion": "free", "mooring": [2e4, 2e4, 0, 0, 0, 0], "device": {"ballast_yaw_inertia": 7e3}}


@pytest.fixture(scope="module")
def free(folder):
    """The whole chain of a buoy free to move, in the same wave from two sides; a line pulls it obliquely."""
    waves = [CALM | {"direction": OBLIQUE}, CALM]
    pto = {"port": {"line_to": [12.0, -9.0]}, "tuning": "one", "damping": None}
    study = study_with(**FREE, study="free", waves=waves, pto=pto)
    make.run(study, folder)
    return StudyPlan(study, root=str(folder))


def in_waves(plan, direction, name="rao"):
    """Part of the response of the free shell in waves of a direction [degrees]."""
    ds = load_data(plan.response_files["response"]).sel(design="VSWEC")
    return ds[name].sel(wave_direction=np.deg2rad(direction), method="nearest")


def test_along_x_a_free_buoy_is_a_planar_one(free, finished, folder):
    """To round-off: nothing moves it aside, nor turns it."""
    plane = made(study_with(study="plane", pto={"damping": 8000.0}), folder, (*HYDRO, "response"))
    all_round = made(study_with(**FREE, study="round", pto={"damping": 8000.0}), folder, (*HYDRO, "response"))
    one, other = responses(plane, all_round)
    np.testing.assert_allclose(other.rao.sel(dof=one.dof), one.rao, rtol=1e-10, atol=1e-13)
    for name in ("absorbed_power", "port_impedance", "matched_power"):
        np.testing.assert_allclose(other[name], one[name], rtol=1e-10)
    aside = [label for label in other.dof.values if label not in one.dof.values]
    assert aside == ["Sway", "Roll", "Membrane1s1", "Membrane2s1", "Membrane2s2", "Yaw"]
    assert not np.any(other.rao.sel(dof=aside))


def test_waves_from_another_side_turn_the_answer(free, folder):
    """Orders m go with cos and sin of m times the direction; heave does not know it; roll is pitch the other way."""
    study = study_with(**FREE, study="turned", waves=[CALM | {"direction": OBLIQUE}, CALM])
    plan = made(study, folder, (*HYDRO, "response"))
    here, along = in_waves(plan, OBLIQUE), in_waves(plan, 0.0)
    cos, sin = (f(np.deg2rad(OBLIQUE)) for f in (np.cos, np.sin))
    shares = {
        ("Heave", "Heave"): 1.0, ("Membrane2", "Membrane2"): 1.0, ("Surge", "Surge"): cos, ("Sway", "Surge"): sin,
        ("Pitch", "Pitch"): cos, ("Roll", "Pitch"): -sin, ("Membrane2s1", "Membrane2c1"): sin,
        ("Membrane2c2", "Membrane2c2"): cos**2 - sin**2, ("Membrane2s2", "Membrane2c2"): 2 * sin * cos,
    }  # fmt: skip
    for (turned, straight), share in shares.items():
        np.testing.assert_allclose(here.sel(dof=turned), share * along.sel(dof=straight), rtol=1e-9, atol=1e-14)
    assert not np.any(here.sel(dof="Yaw"))
    peaks = []
    for wave in study.waves:
        at = linear_design(plan.simulation("VSWEC", wave), plan.hydro_files)
        motion, *_ = simulate(at.system, at.sea, study.simulation, at.spectrum)
        assert residual(energies(at.system, motion)) < 1e-9
        moved = np.abs(motion.position @ at.scene.motions.T).max(axis=0)
        peaks.append(dict(zip(at.scene.labels, moved, strict=True)))
    turned, straight = peaks
    for name, of, share in (
        ("Heave", "Heave", 1),
        ("Surge", "Surge", cos),
        ("Sway", "Surge", sin),
        ("Roll", "Pitch", sin),
    ):
        assert turned[name] == pytest.approx(share * straight[of], rel=1e-6)
    assert straight["Sway"] == straight["Roll"] == turned["Yaw"] == 0.0


def test_powers_of_the_free_buoy_in_time_are_those_of_the_response(free):
    """A line that pulls obliquely takes another power of waves from each side; time and frequency agree to 0.5 %."""
    checks = json.loads(Path(free.folder, "validity.json").read_text())["checks"]
    agreed = [check for check in checks if check["name"] == "time_and_frequency_domain"]
    assert len(agreed) == 2 * len(RAW["designs"])
    assert max(check["value"] for check in agreed) < 5e-3
    assert all(check["verdict"] == "ok" for check in checks if check["name"] in ("energy_residual", "power_limit"))
    rows = [load_data(free.trajectory_path("FSB", wave.label)) for wave in free.study.waves]
    oblique, along = (row.attrs["steady_power"] for row in rows)
    assert oblique != pytest.approx(along, rel=3e-3)
    assert rows[0].attrs["tuned_damping"] == rows[1].attrs["tuned_damping"], "one damper for both"
    page = Path(free.folder, "report.html").read_text()
    assert "going to 30 degrees" in page


@pytest.mark.parametrize("direction", [0.0, OBLIQUE])
def test_ports_of_a_free_rigid_buoy_together_take_three(free, direction):
    """1/8 V0^H (Re Y)^+ V0 of all rigid motions is (1 + 2) lambda/2 pi from any side: surge and pitch share a channel."""
    buoy, basis = linear_buoy(free.study, free.database_path)
    buoy = towards(buoy, direction)
    motions, omega = design_motions(free.study, basis, "FSB"), np.array([1.3, 2.1, 3.0])
    names = ("Surge", "Sway", "Heave", "Roll", "Pitch")
    ports = np.eye(len(buoy.labels))[[buoy.labels.index(name) for name in names]]
    moved = buoy.free_motion(omega, motions, ports[0])[0]
    forced = np.stack([buoy.free_motion(omega, motions, port)[1] @ ports.T for port in ports], axis=-1)
    velocity = -1j * omega[:, None] * (moved @ ports.T)
    admittance = -1j * omega[:, None, None] * forced
    loss = np.linalg.pinv((admittance + admittance.conj().transpose(0, 2, 1)) / 2, rcond=1e-6, hermitian=True)
    power = np.real(np.einsum("wi,wij,wj->w", velocity.conj(), loss, velocity)) / 8
    limit = [3 * power_limit(w, np.inf, 1025.0, 9.81) for w in omega]
    np.testing.assert_allclose(power, limit, rtol=2e-4)


def test_yaw_turns_shell_and_ballast_and_moves_no_water(free):
    ds = load_database(free.database_path, Path(free.database_path).stem)
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


def test_a_wave_against_the_plane_is_mirrored(folder):
    """Of 180 degrees: surge and pitch swing the other way, heave does not; a line takes another power."""
    both = [CALM, CALM | {"direction": 180.0}]
    plan = made(study_with(study="mirrored", waves=both), folder, (*HYDRO, "response"))
    along, against = in_waves(plan, 0.0), in_waves(plan, 180.0)
    for name, sign in (("Heave", 1), ("Surge", -1), ("Pitch", -1), ("Membrane2c1", -1), ("Membrane2c2", 1)):
        np.testing.assert_allclose(against.sel(dof=name), sign * along.sel(dof=name), rtol=1e-12)


def test_a_free_buoy_that_falls_aside_is_refused(folder):
    top = study_with(
        **{**FREE, "mooring": [0, 0, 0, 0, 5e5, 0], "device": {"centre_of_mass": 0.2, "ballast_yaw_inertia": 1.0}}
    )
    with pytest.raises(
        ConfigError,
        match=r"device.centre_of_mass: received 0.2 m .* does not stay upright \("
        r"stiffness of roll -3.369e\+04 N m\); needs one below it, or a mooring that holds roll$",
    ):
        check_upright(top, reference_shell(top))


# drag ---------------------------------------------------------------------------------------------------------------

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


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_drag_of_three_directions_takes_what_its_equivalent_dampers_take(folder, design):
    """Steady state with all harmonics against equivalent linearisation; the audit of the run in time closes."""
    study = dragged()
    plan = made(study, folder)
    at = linear_design(plan.simulation(design, study.waves[0]), plan.hydro_files)
    found = harmonic_balance(at.system)
    assert at.notes[LINEARISED] == pytest.approx(found.power.pto, rel=5e-3)
    assert len(at.notes["drag_damping"]) == 3
    without = made(dragged(drag=None), folder)
    free = linear_design(without.simulation(design, study.waves[0]), plan.hydro_files)
    assert harmonic_balance(free.system).power.pto > 1.02 * found.power.pto
    motion, _, method = simulate(at.system, at.sea, study.simulation, at.spectrum)
    assert method.startswith("exponential collocation")
    assert residual(energies(at.system, motion)) < 1e-6


def test_drag_turns_with_the_waves(folder):
    """In waves along y sway and roll are braked as surge and pitch are along x; nothing brakes what stands still."""
    along = dragged(**FREE, drag=DRAG | ASIDE, pto={"port": "heave", "damping": 9000.0})
    across = dragged(
        **FREE, drag=DRAG | ASIDE, pto={"port": "heave", "damping": 9000.0}, waves=[SWELL | {"direction": 90.0}]
    )
    plan = made(along, folder)
    runs = [StudyPlan(study, root=str(folder)).simulation("FSB", study.waves[0]) for study in (along, across)]
    x, y = (linear_design(run, plan.hydro_files) for run in runs)
    surge, sway, heave, roll, pitch, yaw = x.notes["drag_damping"]
    assert sway == roll == yaw == 0.0
    assert min(surge, heave, pitch) > 0.0
    turned = y.notes["drag_damping"]
    np.testing.assert_allclose(turned, [0.0, surge, heave, pitch, 0.0, 0.0], rtol=1e-9, atol=1e-9 * surge)
    assert y.notes[LINEARISED] == pytest.approx(x.notes[LINEARISED], rel=1e-9)


def test_the_ladder_is_climbed_beside_drag_of_several_directions(folder):
    """From two sides; the page of it tells every damper with its direction."""
    seas = [SWELL, SWELL | {"direction": 40.0}]
    study = dragged(**FREE, waves=seas)
    plan = made(study, folder)
    rungs = study_ladder(plan.ladder, plan.database_path)
    power = {(r.design, r.wave, r.rung): r.power_mean for r in rungs}
    for design, wave in {(r.design, r.wave) for r in rungs}:
        fixed, one, best, pair, matched = (
            power[design, wave, name]
            for name in ("fixed", "best_damper_all_seas", "best_damper", "best_spring_damper", "matched")
        )
        assert max(fixed, one) <= best * (1 + 1e-9)
        assert best <= pair * (1 + 1e-9)
        assert pair < matched
        run = linear_design(plan.simulation(design, next(w for w in study.waves if w.label == wave)), plan.hydro_files)
        assert fixed == pytest.approx(run.notes[LINEARISED], rel=1e-8)
    told = dampers_in_words(study, {"drag_damping": [1.0, 2.0, 30.0]})
    assert told == "1 N s/m of surge and 2 N s/m of heave and 30 N m s of pitch"


# pressure inside ----------------------------------------------------------------------------------------------------


def test_pressure_inside_holds_all_sides(folder):
    """Prestress of every order, trapped gas of the volume alone; surge takes its 2 lambda/2 pi as before."""
    inside = {"internal_pressure": 3e4, "gas": {"adiabatic_index": 1.4}}
    study = study_with(study="inside", device=inside, pto={"port": "surge"}, designs={"VSWEC": {}})
    plan = made(study, folder, (*HYDRO, "response"))
    ds = load_database(plan.database_path, Path(plan.database_path).stem)
    labels = list(ds.influenced_dof.values)
    for name in ("Membrane0", "Membrane2c1", "Membrane2c2"):
        own = {"influenced_dof": name, "radiating_dof": name}
        assert ds.prestress_stiffness.sel(own).item() != 0.0
        assert (ds.gas_stiffness.sel(own).item() > 0.0) == (name == "Membrane0")
    for name in ("Surge", "Pitch"):
        assert not np.any(ds.prestress_stiffness.sel(influenced_dof=name))
    softer = load_data(made(study_with(study="vented", pto={"port": "surge"}, designs={"VSWEC": {}}), folder, (
        *HYDRO, "response")).response_files["response"])  # fmt: skip
    response = load_data(plan.response_files["response"])
    assert np.abs(response.wet_natural_frequency - softer.wet_natural_frequency).max() > 1e-3
    share = (response.matched_power / response.power_limit).sel(design="VSWEC").values
    np.testing.assert_allclose(share[20:], 1.0, rtol=2e-4)
    at = linear_design(plan.simulation("VSWEC", study.waves[0]), plan.hydro_files)
    motion, *_ = simulate(at.system, at.sea, study.simulation, at.spectrum)
    assert residual(energies(at.system, motion)) < 1e-9
    assert "prestress" in at.scene.forces
    assert labels[:4] == ["Heave", "Membrane0", "Membrane1", "Membrane2"]


@pytest.mark.parametrize(("motion", "orders"), [("heave", []), ("planar", [1, 2]), ("free", [1, -1, 2, -2, 0])])
@pytest.mark.parametrize("flexible", [True, False])
def test_orders_beside_heave_are_those_of_the_motion_each_to_both_sides_where_it_is_free(motion, orders, flexible):
    """A rigid buoy has the first alone; all are of the device's balance and damping."""
    free = {"motion": "free", "device": {"ballast_yaw_inertia": 7e3, "damping": {"alpha": 0.2, "beta": 1e-3}}}
    changes = free if motion == "free" else {"device": {"damping": {"alpha": 0.2, "beta": 1e-3}}}
    designs = {"A": {"flexible": flexible}}
    study = study_with(**changes, designs=designs, modes={"degree": 3})
    if motion == "heave":
        study = study.model_copy(update={"motion": "heave"})
    found = order_bases(study, study_basis(study))
    assert [each.signed for each in found] == [m for m in orders if flexible or abs(m) < 2]
    for each in found:
        assert each.ballast[:3] == (RAW["device"]["mass"], -0.6, 9e3)
        assert each.ballast.yaw_inertia == (7e3 if motion == "free" else 0.0)
        assert (each.alpha, each.beta) == ((0.2, 1e-3) if each.modes else (0.0, 0.0))
        assert bool(each.modes) == (flexible and each.order > 0)


def test_an_order_is_stiff_by_the_names_of_what_stiffens_the_shell(monkeypatch):
    """Its own and the water's, under pressure inside its prestress, of gas none; all symmetric."""
    monkeypatch.setattr(
        LoadedShell, "linear_resultants", lambda load, phi: (load.pressure_inside + np.cos(phi), 9.0 * np.sin(phi))
    )
    water = {"density": 1010.0, "gravity": 9.7}
    for pressure, gas in itertools.product((3e4, 0.0), ({"adiabatic_index": 1.4}, None)):
        study = study_with(device={"internal_pressure": pressure, "gas": gas}, water=water)
        more = {name for name, there in (("prestress", pressure), ("gas", gas)) if there}
        reference = reference_shell(study)
        for basis in order_bases(study, reference.basis):
            found = order_stiffness(study, basis, reference)
            assert set(found) == set(reference.stiffness) == {"structural", "hydrostatic"} | more
            np.testing.assert_array_equal(found["structural"], basis.stiffness)
            still = basis.hydrostatic_stiffness(study.centre_height, 1010.0, 9.7)
            np.testing.assert_allclose(found["hydrostatic"], (still + still.T) / 2, rtol=1e-14)
            assert not np.any(found.get("gas", 0.0))
            for matrix in found.values():
                np.testing.assert_array_equal(matrix, matrix.T)
            if pressure:
                elastic = ElasticShell(reference.basis)
                load = LoadedShell(elastic, study.centre_height, 1010.0, 9.7, 3e4, study.device.gas)
                expected = prestress_stiffness(basis, load)
                np.testing.assert_allclose(found["prestress"], (expected + expected.T) / 2, rtol=1e-12, atol=1e-9)


def test_a_mooring_acts_alike_from_every_motion_to_every_other():
    """All six of them, in their order, whatever the order and number of the degrees of freedom."""
    rows = np.arange(36.0).reshape(6, 6) - 20.0
    rows = rows + rows.T
    study = study_with(**FREE).model_copy(update={"mooring": rows.tolist()})
    labels = ("Yaw", "Heave", "Membrane2", "Roll", "Surge", "Pitch", "Sway")
    at = [5, 2, None, 3, 0, 4, 1]
    expected = [[0.0 if i is None or j is None else rows[i, j] for j in at] for i in at]
    np.testing.assert_array_equal(mooring_stiffness(study, labels)["mooring"], expected)


@pytest.mark.parametrize(("lower", "name"), [(3, "roll"), (4, "pitch")])
def test_the_way_a_free_buoy_falls_over_is_that_of_the_least_stiffness(lower, name):
    """Both are below zero; the mooring holds one of them a little."""
    held = np.zeros(6)
    held[7 - lower] = 1e3
    study = study_with(
        **{**FREE, "mooring": held.tolist(), "device": {"centre_of_mass": 0.2, "ballast_yaw_inertia": 1.0}}
    )
    with pytest.raises(ConfigError, match=rf"stiffness of {name} -3\.369e\+04 N m\).* or a mooring that holds {name}$"):
        check_upright(study, reference_shell(study))


@pytest.mark.parametrize("pressure", [3e4, 0.0])
@pytest.mark.parametrize("gas", [{"adiabatic_index": 1.4}, None])
def test_a_shell_is_loaded_by_its_own_water_and_by_what_is_inside(pressure, gas):
    device = {"internal_pressure": pressure, "gas": gas}
    study = study_with(device=device, water={"density": 1010.0, "gravity": 9.7})
    basis = study_basis(study)
    load = loaded_shell(study, basis)
    assert load.elastic.basis is basis
    assert (load.water_density, load.gravity, load.internal_pressure) == (1010.0, 9.7, pressure)
    assert (load.centre_height, load.gas) == (study.centre_height, study.device.gas)
    assert (load.gas is None) == (gas is None)


@pytest.mark.parametrize("motion", ["heave", "planar", "free"])
def test_all_stiffness_is_that_of_each_order_in_its_place_and_of_the_mooring_over_all(motion):
    """With what the shell, the water, pressure and gas inside add to it, order by order."""
    changes = FREE if motion == "free" else {}
    inside = {**changes.get("device", {}), "internal_pressure": 3e4, "gas": {"adiabatic_index": 1.4}}
    rows = np.diag([2e4, 3e4, 4e3, 5e5, 6e5, 7e4])
    rows[0, 4] = rows[4, 0] = -2e4
    study = study_with(**{**changes, "device": inside}).model_copy(update={"motion": motion, "mooring": rows.tolist()})
    reference = reference_shell(study)
    bases = order_bases(study, reference.basis)
    labels = [*reference.basis.labels, *(label for each in bases for label in each.labels)]
    assert list(whole_labels(study, reference)) == labels
    parts = [reference.total, *(sum(order_stiffness(study, each, reference).values()) for each in bases)]
    expected, at = np.zeros((len(labels), len(labels))), 0
    for part in parts:
        here = slice(at, at + len(part))
        expected[here, here] += part
        at += len(part)
    for i, one in enumerate(("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")):
        for j, other in enumerate(("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw")):
            if {one, other} <= {*labels}:
                expected[labels.index(one), labels.index(other)] += rows[i, j]
    found = whole_stiffness(study, reference)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-9 * np.abs(expected).max())
    assert at == len(labels) == {"heave": 4, "planar": 9, "free": 15}[motion]
