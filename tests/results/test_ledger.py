"""The ledger of checks: buckling, static load, seas, coefficients; and which designs they invalidate."""

import json
import re
from dataclasses import asdict, replace

import numpy as np
import pytest
import xarray as xr
from conftest import SEED, varied

from vsb.engine.hydro.database import INVALIDATING, Check
from vsb.engine.integrators.settings import Simulation
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.loaded import ElasticShell
from vsb.engine.shell.shell import Shell
from vsb.engine.waves.kinds import Jonswap, PiersonMoskowitz, RegularWave, WhiteNoise
from vsb.engine.waves.water import Water, power_limit, wavenumber
from vsb.errors import ConvergenceError
from vsb.keys.reading import validated
from vsb.models.build import TUNED
from vsb.models.rest import reference_shell, study_basis
from vsb.models.viability import advice, static_modal_amplitude
from vsb.report.answer import ADVICE, REASONS
from vsb.results import ledger
from vsb.results.budget import MODES, Source
from vsb.results.ladder import ControlLevel
from vsb.results.ledger import (
    DAMPERS,
    LINEARISED,
    ROTATION,
    Invalid,
    agreement_checks,
    body_motion_checks,
    buoy_motion_checks,
    energy_check,
    flexible_designs,
    invalid_designs,
    law_checks,
    sea_checks,
    simplification_checks,
    transient_checks,
)
from vsb.results.verification import check_audit
from vsb.study.body import BodyStudy
from vsb.study.study import load, parse

WAVE = RegularWave(kind="regular", amplitude=0.5, period=4.0)
LENGTH = 2 * np.pi * 9.81 / WAVE.omega**2


def test_vented_shell_of_the_seed_is_not_viable(seed):
    """Keel pressure of about 20 kPa over the classical 303 Pa."""
    buckling, computed, static, strain = ledger.shell_checks(seed, reference_shell(seed))
    assert (buckling.name, buckling.verdict) == ("buckling", "fail")
    assert (computed.name, computed.verdict) == ("computed_buckling", "fail")
    assert computed.value == pytest.approx(1 / 0.018667, rel=1e-3)
    assert "viable from device.internal_pressure = 16320 Pa" in computed.advice
    assert buckling.advice == computed.advice, "one change mends both"
    assert strain.verdict == "doubt"
    assert buckling.value == pytest.approx(1025 * 9.81 * seed.draft / 302.6138, rel=1e-4)
    assert static.value * 2.0 == pytest.approx(0.137, abs=0.001)
    rigid = varied(seed, designs={"FSB": {"flexible": False}})
    assert ledger.shell_checks(rigid, reference_shell(rigid)) == []


@pytest.mark.parametrize(
    ("radius", "slenderness", "modulus", "index"), [(2.0, 5e-3, 7.0, 1.4), (0.8, 1.5e-2, 6.6, None)]
)
def test_advised_internal_pressure_passes_the_checks(seed, radius, slenderness, modulus, index):
    """Also when rounded, and with trapped gas."""
    device = {"radius": radius, "thickness": slenderness * radius, "young_modulus": 10.0**modulus}
    device["gas"] = index and {"adiabatic_index": index}
    vented = varied(seed, device={**device, "mass": 4.0 / 3.0 * np.pi * radius**3 * 512.0})
    advised = float(advice(vented).split("internal_pressure = ")[1].split(" Pa")[0])
    study = varied(vented, device={"internal_pressure": advised})
    computed, *others = ledger.shell_checks(study, reference_shell(study))
    assert (computed.name, computed.verdict) == ("computed_buckling", "ok")
    assert all(one.verdict != "ok" or one.value <= one.limit for one in (computed, *others))
    assert ledger.classical_check(study, reference_shell(study)).value > 1.0  # exceeded, and does not decide
    (check,) = ledger.viability_checks(varied(vented, device={"internal_pressure": 0.99 * advised}))
    assert check.value > 1.0


@pytest.mark.parametrize(
    ("pressure", "verdict"), [pytest.param(14.0e3, "fail", marks=pytest.mark.slow), (14.6e3, "doubt"), (16.4e3, "ok")]
)
def test_nonlinear_path_decides_on_viability(seed, pressure, verdict):
    """The seed's shell is stable from 14.3 kPa on, by linear buckling from 16.32 kPa."""
    study = varied(seed, device={"internal_pressure": pressure})
    found = {check.name: check for check in ledger.shell_checks(study, reference_shell(study))}
    computed = found["computed_buckling"]
    assert computed.verdict == verdict
    assert (computed.value > 1.0) == (verdict != "ok")
    assert ("buckling" in found) == (verdict == "fail")  # exceeded at all three, but then it does not decide
    assert ("advice only" in computed.explanation) == (verdict == "doubt")


@pytest.mark.slow
def test_a_long_spheroid_buckles_into_lobes(seed):
    """The seed's soft shell, with the pressure that would carry it."""
    shaped = varied(seed, device={"shape": {"spheroid": {"height": 6.0}}}, modes={"basis": "full", "degree": 3})
    check, *_ = ledger.shell_checks(shaped, reference_shell(shaped))
    assert (check.name, check.verdict) == ("computed_buckling", "fail")
    assert re.search(r"azimuthal order \d+$", check.explanation)
    assert check.advice.startswith("by linear buckling viable from device.internal_pressure = ")
    assert ledger.viability_checks(varied(seed, reference_shape="equilibrium")) == []


def test_static_modal_amplitude_balances_the_load_to_first_order(seed):
    basis = study_basis(seed)
    static = static_modal_amplitude(seed, reference_shell(seed))
    assert static[1] == pytest.approx(-0.06, abs=0.02)  # about 6 cm of the breathing mode

    def unbalance(scale):
        shell = DeformedShell(basis, seed.centre_height, scale * static)
        load = shell.hydrostatics(1025.0, 9.81)[0] - 9.81 * basis.inertia[0]
        return np.abs(load - basis.stiffness @ (scale * static)).max()

    rest = DeformedShell(basis, seed.centre_height).hydrostatics(1025.0, 9.81)[0] - 9.81 * basis.inertia[0]
    assert unbalance(1.0) < 0.1 * np.abs(rest).max()


@pytest.mark.parametrize(("shape", "moved", "limit"), [("undeformed", 0.05, 0.05), ("equilibrium", 0.2, 0.2)])
def test_static_deformation_is_doubted_above_its_limit(seed, shape, moved, limit):
    """Of a shell that breathes at rest, or one soft enough."""
    study, reference = varied(seed, reference_shape=shape), reference_shell(seed)
    for part, verdict in ((0.99, "ok"), (1.01, "doubt")):
        q = -2.0 * part * moved * np.eye(len(reference.basis.labels))[1]
        if shape == "equilibrium":
            resting = replace(reference, shape=replace(reference.shape, modal_amplitude=q))
        else:  # a stiffness under which the load moves the shell so far
            softness = part * moved / ledger.static_checks(study, reference)[0].value
            resting = replace(reference, stiffness={k: v / softness for k, v in reference.stiffness.items()})
        deformation, strain = ledger.static_checks(study, resting)
        assert (deformation.verdict, deformation.limit) == (verdict, limit)
        assert deformation.value == pytest.approx(part * moved, rel=2e-3)
        assert (strain.limit, strain.verdict != "ok") == (0.02, True)


def test_gas_pressure_at_rest_follows_the_adiabatic_law(seed):
    """Of a stiff shell: p V^1.4 constant between the undeformed volume and that at rest."""
    device = {"internal_pressure": 2e4, "gas": {"adiabatic_index": 1.4}, "young_modulus": 1e9}
    found = []
    for shape in ("undeformed", "equilibrium"):
        study = varied(seed, device=device, reference_shape=shape)
        reference = reference_shell(study)
        found.append(ledger.pressure_at_rest(study, reference))
        keel = 1025 * 9.81 * reference.keel_depth - found[-1]
        check = ledger.classical_check(study, reference)
        assert check.value * Shell.of(study.device).buckling_pressure == pytest.approx(max(0.0, keel))
    volume = ElasticShell(reference.basis).volume(reference.modal_amplitude)
    whole = (101325.0 + 2e4) * (32 / 3 * np.pi / volume) ** 1.4 - 101325.0
    assert found[1] == pytest.approx(whole, abs=1e-6)
    assert 0.005 * 2e4 < 2e4 - found[1] < 0.1 * 2e4
    assert found[0] == pytest.approx(whole, rel=5e-3)


@pytest.mark.parametrize(("lowest", "highest", "share"), [(1.25, 2.5, 0.375), (0.5, 2.5, 0.25)])
def test_energy_outside_the_band_adds_up(lowest, highest, share):
    """Share of a flat spectrum from 1 to 3 rad/s outside the band of a buoy, or of a body's database."""
    sea = WhiteNoise(kind="white_noise", hs=0.5, band=(1.0, 3.0))
    (_, cut) = ledger.wave_checks(sea, Water(), highest, lowest)
    assert cut.value == pytest.approx(share, rel=1e-9)
    waves = [{"kind": "white_noise", "hs": 0.5, "band": [1.0, 3.0]}]
    body = validated(
        BodyStudy, {"study": "a", "body": {"database": "-"}, "designs": {"a": {}}, "waves": waves}, "a.yaml"
    )
    (_, same, _) = ledger.seas_checks(body, xr.Dataset(coords={"omega": [lowest, highest]}))
    assert same.value == cut.value
    assert f"beyond {lowest:g} to {highest:g} rad/s of the database" in same.explanation


def test_steepness_is_height_over_wavelength():
    """Height: twice the amplitude of a regular wave, the significant height of a sea."""
    swell = RegularWave(kind="regular", amplitude=0.3, period=6.0)
    sea = Jonswap(kind="jonswap", hs=0.5, tp=7.0)
    for wave, height in ((swell, 0.6), (sea, 0.5)):
        checks = ledger.wave_checks(wave, Water(depth=6.0, gravity=9.0), 12.0)
        assert checks[0].value == pytest.approx(height * wavenumber(wave.omega, 6.0, 9.0) / (2 * np.pi), rel=1e-12)
        assert len(checks) == (1 if wave is swell else 2)


def of_wave(study, x):
    return ledger.wave_checks(RegularWave(kind="regular", amplitude=x * LENGTH / 2, period=4.0), Water(), 12.0)


def of_band(study, x):
    """A fully developed sea of which 1 - exp(-1.25 (omega_p/omega)^4) lies above 2 rad/s."""
    peak = 2.0 * (-np.log(1 - x) / 1.25) ** 0.25
    return ledger.wave_checks(PiersonMoskowitz(kind="pierson_moskowitz", hs=0.01, tp=2 * np.pi / peak), Water(), 2.0)


def of_radiation(study, error=0.0, margin=0.0):
    attrs = {"order": 8, "fit_error": error, "passivity_margin": margin}
    return ledger.radiation_checks(xr.Dataset(attrs=attrs), study.hydro.tolerance)


def of_limit(study, x):
    ds = xr.Dataset({"absorbed_power": (("design", "omega"), [[1.0, x]]), "power_limit": ("omega", [2.0, 1.0])})
    return ledger.limit_checks(study, ds)


def of_pressure(study, x):
    """Mean power as a share of the limit of a wave with the same pressure."""
    pressure = {"model": "assumed_pressure", "pressure": 0.3 * 1025 * 9.81}
    assumed = varied(study, hydro=pressure, waves=[WAVE.model_dump()])
    best = x * power_limit(WAVE.omega, np.inf, 1025.0, 9.81) * 0.3**2
    rows = [{"design": d, "wave": WAVE.label, "power_mean": p} for d, p in (("FSB", 0.5 * best), ("VSWEC", best))]
    return ledger.assumed_pressure_checks(assumed, rows)


def of_buckling(study, x):
    """A shell stiff enough for a load of this share of its buckling load."""
    modulus = study.device.young_modulus * ledger.viability_checks(study)[0].value
    return ledger.viability_checks(varied(study, device={"young_modulus": modulus / x}))


def of_modes(study, x):
    """Change of the power by the shell modes left out, at the optimal damping."""
    one = varied(study, designs={"VSWEC": {}}, waves=[WAVE.model_dump()])
    left = [asdict(Source(MODES, -4.0 * x, 0.0))]
    level = ControlLevel("VSWEC", one.waves[0].label, "best_damper", 1e4, 0.0, 4.0, *[None] * 5, power_error=left)
    return ledger.mode_checks(one, [level])


@pytest.mark.parametrize(
    ("name", "limit", "checks", "above"),
    [
        ("computed_buckling", 1.0, of_buckling, "fail"),
        ("steepness", 0.05, of_wave, "doubt"),
        ("spectrum_cut", 0.01, of_band, "doubt"),
        ("radiation_fit", 1e-3, lambda s, x: of_radiation(s, error=x), "doubt"),
        ("passivity", 1e-12, lambda s, x: of_radiation(s, margin=-x), "fail"),
        ("power_limit", 1.01, of_limit, "fail"),
        ("modes_left_out", 0.005, of_modes, "doubt"),
        ("assumed_pressure", 1.0, of_pressure, "fail"),
    ],
)
def test_check_changes_its_verdict_at_its_limit(seed, name, limit, checks, above):
    for part, verdict in ((0.99, "ok"), (1.01, above)):
        check = next(check for check in checks(seed, part * limit) if check.name == name)
        assert (check.verdict, check.limit) == (verdict, pytest.approx(limit, rel=1e-12))
        assert check.value == pytest.approx(part * limit, rel=2e-3)


@pytest.mark.parametrize(("clamp", "doubted"), [(1.5708, True), (3.14, True), (90.0, False), (1.6, False)])
def test_angles_that_look_like_radians_are_doubted(seed, clamp, doubted):
    checks = ledger.angle_checks(varied(seed, designs={"A": {"clamp": clamp}}))
    assert [check.verdict for check in checks] == ["doubt"] * doubted
    assert all(f"designs.A.clamp.0 {clamp:g} (" in check.explanation for check in checks)


def check(name, verdict="fail", design="", wave="", value=2.0):
    return Check(name, value, 1.0, "-", verdict, "why", design, wave)


@pytest.fixture
def three(seed):
    waves = [WAVE.model_dump(), {"kind": "jonswap", "hs": 1.0, "tp": 5.0, "realisations": 2}]
    return varied(seed, designs={"FSB": {"flexible": False}, "A": {}, "B": {}}, waves=waves)


def test_every_invalidating_check_has_a_reason_and_advice():
    assert set(REASONS) == set(INVALIDATING) <= set(ADVICE)


def test_failed_shell_check_invalidates_flexible_designs_only(three):
    seas = {wave.label if i == 0 else wave.family for i, wave in enumerate(three.waves)}
    assert flexible_designs(three) == ["A", "B"]
    found = invalid_designs(three, [check("buckling")])
    assert {(line.design, line.sea) for line in found} == {(design, sea) for design in "AB" for sea in seas}
    found = invalid_designs(three, [check("hydro panels", "accepted")])
    assert {(line.design, line.name) for line in found} == {(design, "panels") for design in ("FSB", "A", "B")}


def test_failed_check_invalidates_its_own_sea_only(three):
    swell, first, second = (wave.label for wave in three.waves)
    strained = [check("strain", design="A", wave=first, value=3.0), check("strain", design="A", wave=second, value=5.0)]
    assert invalid_designs(three, strained) == [Invalid("A", three.waves[1].family, "strain", 5.0, 1.0)]
    unbalanced = check("energy_residual", design="FSB", wave=swell)
    assert invalid_designs(three, [unbalanced]) == [Invalid("FSB", swell, "energy_residual", 2.0, 1.0)]
    doubts = [check("buckling", "doubt"), check("strain", "ok", "A"), check("steepness"), check("fair_damping")]
    assert invalid_designs(three, doubts) == []


def test_ledger_refuses_numbers_that_are_not_finite():
    assert json.loads(ledger.ledger_json("a_study", [])) == {"study": "a_study", "checks": [], "invalid": []}
    with pytest.raises(ValueError, match="Out of range float values are not JSON compliant"):
        ledger.ledger_json("s", [check("buckling", value=np.nan)])


SWELL = {"kind": "regular", "amplitude": 0.5, "period": 7.0, "direction": 90.0}
TIME = np.linspace(0.0, 60.0, 61)


def body_study(**changes):
    made = {"study": "a", "body": {"database": "-"}, "designs": {"a": {}}, "waves": [SWELL], "pto": {"damping": 1.0}}
    return validated(BodyStudy, {**made, **changes}, "a.yaml")


def moved(labels, position, **attrs):
    """A run that is displaced at 50 s only, of 60 s."""
    path = np.zeros((61, len(labels)))
    path[50] = position
    attrs = {"design": "VSWEC", "wave": "w", "energy_residual": 0.0, **attrs}
    return xr.Dataset({"position": (("time", "dof"), path)}, {"time": TIME, "dof": labels}, attrs)


@pytest.mark.parametrize(
    ("settings", "limit"), [({"tolerance": 1e-4}, 1e-4), ({"tolerance": 1e-9}, 1e-6), ({"method": "convolution"}, 1e-4)]
)
def test_energy_limit_follows_the_method_and_the_tolerance(settings, limit):
    verdicts = [energy_check(Simulation(**settings), part * limit).verdict for part in (0.99, 1.01, 5.01)]
    assert verdicts == ["ok", "doubt", "fail"]


def test_run_whose_audit_fails_is_refused():
    check_audit(Simulation(), 4.9e-6)
    with pytest.raises(ConvergenceError, match=r"^the energy audit fails: 5\.1e-06 .*needs 1e-06; lower simulation\."):
        check_audit(Simulation(), 5.1e-6)


@pytest.mark.parametrize(
    ("name", "limit", "motion"),
    [
        ("heave", 0.3, lambda x: {"heave": 2.0 * x}),
        ("deformation", 0.1, lambda x: {"breathing": 2.0 * x}),
        ("strain", 0.02, lambda x: {"breathing": 2.0 * x}),  # of a sphere that breathes, its share of the radius
        ("energy_residual", 1e-6, lambda x: {"energy_residual": x}),
        ("constraint_drift", 1e-9, lambda x: {"constraint_drift": x}),
    ],
)
def test_check_of_a_buoys_run_changes_its_verdict_at_its_limit(seed, name, limit, motion):
    one = varied(seed, designs={"VSWEC": {}}, waves=[{"kind": "still"}])
    labels, basis = ["Heave", *(f"Membrane{n}" for n in range(7))], study_basis(seed)

    def checks(heave=0.0, breathing=0.0, study=one, **attrs):
        run = moved(labels, [heave, breathing, *[0.0] * 6], **attrs)
        return {check.name: check for check in sea_checks(study, study.waves[0], {"VSWEC": run}, basis)}

    below, above = (checks(**motion(part * limit))[name] for part in (0.99, 1.01))
    assert (below.verdict, above.verdict) == ("ok", "fail" if name == "constraint_drift" else "doubt")
    assert (below.limit, above.value) == (pytest.approx(limit), pytest.approx(1.01 * limit, rel=2e-3))
    late = varied(one, simulation={"window": [51.0, 60.0]})  # motion before the window does not count
    assert checks(heave=5.0, breathing=1.0, study=late)["heave"].value == 0.0
    assert checks(heave=5.0, breathing=1.0, study=late)["strain"].value == 0.0


def test_tilt_combines_pitch_and_roll_and_drift_is_along_the_waves():
    """In waves at 30 degrees."""
    data = load(SEED).model_dump() | {"motion": "planar"}
    data["device"] |= {"centre_of_mass": -0.5, "ballast_inertia": 8e3}
    study = varied(parse(data), waves=[{"kind": "regular", "amplitude": 0.1, "period": 3.0}])
    wave = study.waves[0].model_copy(update={"direction": 30.0})
    number, towards = wavenumber(wave.omega, np.inf, 9.81), np.deg2rad(30.0)
    along, across = np.array([np.cos(towards), np.sin(towards)]), np.array([-np.sin(towards), np.cos(towards)])
    for shift, expected in ((-0.7 * along, 0.7), (9.0 * across, 0.0), (0.4 * along + 5.0 * across, 0.4)):
        run = moved(["Heave", "Surge", "Sway", "Roll", "Pitch"], [0.0, *shift, -0.04, 0.03])
        _, pitch, surge = buoy_motion_checks(study, study_basis(study), wave, run)
        assert pitch.value == pytest.approx(0.05, rel=1e-12)
        assert surge.value == pytest.approx(number * expected, abs=1e-12)


def test_largest_motion_of_a_body_in_the_window_counts():
    """Translations over the size of the smaller body; elastic modes have no limit."""
    study, where = body_study(), {"design": "a", "wave": "sea"}
    one = moved(["float__Heave", "spar__Pitch", "Mode7"], [-0.5, 1.5 * ROTATION, 9.0], **where)
    turned, shifted = body_motion_checks(study, xr.Dataset(attrs={"displaced_volume": 8.0}), one)
    assert (turned.name, turned.verdict, turned.value) == ("rotation", "doubt", pytest.approx(1.5 * ROTATION))
    assert (shifted.name, shifted.verdict, shifted.value) == ("translation", "ok", pytest.approx(0.25))
    apart = xr.Dataset(attrs={"displaced_volume_float": 1.0, "displaced_volume_spar": 8.0})
    (worst,) = body_motion_checks(study, apart, moved(["float__Heave", "spar__Heave"], [0.5, 0.6], **where))
    assert (worst.verdict, worst.value, worst.design, worst.wave) == ("doubt", pytest.approx(0.5), "a", "sea")
    late = body_study(simulation={"duration": 60.0, "window": [51.0, 60.0]})
    assert [check.value for check in body_motion_checks(late, apart, one)] == [0.0, 0.0]


def test_errors_of_model_auto_add_up_in_the_gain(seed):
    two = varied(seed, hydro={"model": "auto"}, designs={"FSB": {"flexible": False}, "VSWEC": {}})

    def checks(rigid, shell):
        attrs = {"description": "linear", "left_out": '[{"what": "shell_modes", "error": 0.0021}]'}
        runs = {"FSB": xr.Dataset(attrs={**attrs, "power_error": rigid})}
        runs["VSWEC"] = xr.Dataset(attrs={**attrs, "power_error": shell})
        return simplification_checks(two, two.waves[0], runs)

    rigid, shell, gain = checks(0.0099, 0.0101)
    assert [check.verdict for check in (rigid, shell, gain)] == ["ok", "fail", "ok"]
    assert (gain.value, gain.limit, gain.design) == (pytest.approx(0.02), 0.02, "VSWEC")
    assert "left out: shell modes 2.1e-03" in shell.explanation


def test_mean_power_is_compared_with_the_steady_state():
    row, steady = (
        {"design": "FSB", "wave": "w", "record_power_mean": 100.6},
        {"steady_power": 100.0, "steady_decay": 0.1},
    )
    (check,) = transient_checks({("FSB", "w"): steady}, [row])
    assert (check.verdict, check.value, check.limit) == ("doubt", pytest.approx(0.006), 0.005)
    (none,) = transient_checks({("FSB", "w"): {"no_steady_state": "it drifts"}}, [row])
    assert (none.verdict, none.explanation.endswith("it drifts")) == ("doubt", True)
    assert transient_checks({("FSB", "w"): {}}, [row]) == []


def test_latching_time_at_the_border_of_the_search_is_in_doubt():
    wet = {"model": "body_exact", "linear_latching_time": 1.0, "latching_time_searched": 0.25}
    runs = {
        ("A", "w"): {**wet, "latching_time": 1.05},
        ("B", "w"): {**wet, "latching_time": 0.76},
        ("C", "w"): {"model": "linear", "latching_time": 1.08},
        ("D", "w"): {**wet, "linear_latching_time": 0.2, "latching_time": 0.0},
    }
    near, far = law_checks(runs)
    assert near.name == far.name == "latching_time"
    assert (near.verdict, near.value) == ("ok", pytest.approx(0.2))
    assert (far.verdict, far.value, far.design) == ("doubt", pytest.approx(0.96), "B")


def test_power_in_time_is_compared_with_the_frequency_domain():
    """8 W/m^2 in waves of 0.5 m towards 90 degrees are 2 W."""
    one = body_study()
    (wave,) = one.waves
    coords = {"wave_direction": [0.0, np.pi / 2], "design": ["a"], "omega": [wave.omega - 0.1, wave.omega]}
    power = np.array([[[1.0, 1.0]], [[1.0, 8.0]]])
    frequency = xr.Dataset({"absorbed_power": (("wave_direction", "design", "omega"), power)}, coords)

    def checks(mean, study=one, scale=1.0, **run):
        rows = [{"design": "a", "wave": wave.label, "record_power_mean": mean}]
        return agreement_checks(study, scale * frequency, rows, {("a", wave.label): {"model": "linear", **run}})

    for sign in (1, -1):
        (below,), (above,) = (checks(2.0 * (1 + sign * part * 0.005)) for part in (0.98, 1.02))
        assert (below.name, below.verdict, above.verdict) == ("time_and_frequency_domain", "ok", "doubt")
        (below,), (above,) = (checks(2.0 * (1 + sign * part * 0.05), model="body_exact") for part in (0.98, 1.02))
        assert (below.name, below.verdict, above.verdict) == ("linearity", "ok", "doubt")
    (held,) = checks(3e-16, scale=1e-28)  # powers of round-off are equal
    assert held.verdict == "ok"
    assert checks(2.1, body_study(pto={"damping": 1.0, "force_limit": 10.0})) == []
    (drag,) = checks(9.4, **{LINEARISED: 10.0, DAMPERS: 30.0, "model": "body_exact"})
    assert (drag.name, drag.verdict, drag.value) == ("drag", "doubt", pytest.approx(0.06))
    assert "equivalent damper of 30 N s/m" in drag.explanation


def test_tuned_run_is_compared_at_its_own_damping():
    """P = c |Z V|^2/|Z + c|^2 / 2 of each design in waves of 0.5 m; the response is at another damping."""
    one = body_study(designs={"a": {}, "b": {}})
    (wave,) = one.waves
    impedance, velocity = np.array([[2.0 + 1j], [4.0 - 3j]]), np.array([[3.0 + 0j], [1j]])
    values = {"port_impedance": impedance, "port_velocity": velocity, "absorbed_power": np.full((2, 1), 99.0)}
    values = {name: (("design", "omega"), value) for name, value in values.items()}
    frequency = xr.Dataset(values, {"design": ["a", "b"], "omega": [wave.omega]})
    runs = {("a", wave.label): {"model": "linear", TUNED: 5.0}, ("b", wave.label): {"model": "linear", TUNED: 7.0}}
    means = [0.25 * 0.5 * 5.0 * 5.0 * 9.0 / 50.0, 0.25 * 0.5 * 7.0 * 25.0 / 130.0]
    rows = [{"design": d, "wave": wave.label, "record_power_mean": mean} for d, mean in zip("ab", means, strict=True)]
    found = agreement_checks(one, frequency, rows, runs)
    assert [check.design for check in found] == ["a", "b"]
    assert [check.value for check in found] == pytest.approx([0.0, 0.0], abs=1e-12)
