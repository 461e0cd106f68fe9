"""The ledger of checks: buckling, static load, seas, coefficients; and which designs they invalidate."""

import json
import re
from dataclasses import asdict, replace

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.engine.hydro.database import INVALIDATING, Check
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.loaded import ElasticShell
from vsb.engine.shell.shell import Shell
from vsb.engine.waves.kinds import Jonswap, PiersonMoskowitz, RegularWave, WhiteNoise
from vsb.engine.waves.water import Water, power_limit, wavenumber
from vsb.keys.reading import validated
from vsb.models.load_advice import advice
from vsb.models.rest import reference_shell, study_basis
from vsb.models.viability import static_modal_amplitude
from vsb.report.answer import ADVICE, REASONS
from vsb.results import ledger
from vsb.results.budget import MODES, Source
from vsb.results.ladder import ControlLevel
from vsb.results.ledger import Invalid, flexible_designs, invalid_designs
from vsb.study.body import BodyStudy

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
    ("pressure", "verdict"),
    [pytest.param(14.0e3, "fail", marks=pytest.mark.slow), (14.6e3, "doubt"), (16.4e3, "ok")],
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
    return [ledger.limit_check(ds)]


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
