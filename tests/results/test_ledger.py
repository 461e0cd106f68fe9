"""The ledger of checks: buckling, static load, seas, transients, simplifications."""

import json

import numpy as np
import pytest
from conftest import varied
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from vsb.hydro.database import Check
from vsb.results import ledger
from vsb.results.ledger import largest_strain, static_modal_amplitude
from vsb.scenes.rest import reference_shell, study_basis
from vsb.shell.deformed import DeformedShell
from vsb.shell.elastic import ElasticShell
from vsb.shell.sphere import Shell
from vsb.study.device import Spheroid
from vsb.study.study import Jonswap, RegularWave, Water, WhiteNoise
from vsb.waves.dispersion import wavenumber


def test_vented_shell_of_the_seed_is_not_viable(seed):
    """Keel pressure of about 20 kPa over the classical 303 Pa."""
    buckling, computed, static, strain = ledger.shell_checks(seed, reference_shell(seed))
    assert (buckling.name, buckling.verdict) == ("buckling", "fail")
    assert (computed.name, computed.verdict) == ("computed_buckling", "fail")
    assert computed.value == pytest.approx(1 / 0.018667, rel=1e-3)
    assert "viable from device.internal_pressure = 16320 Pa" in computed.explanation
    assert strain.verdict == "doubt"
    assert buckling.value == pytest.approx(1025 * 9.81 * seed.draft / 302.6138, rel=1e-4)
    assert static.value * 2.0 == pytest.approx(0.137, abs=0.001)
    rigid = varied(seed, designs={"FSB": {"flexible": False}})
    assert ledger.shell_checks(rigid, reference_shell(rigid)) == []


@settings(max_examples=3)
@given(st.floats(0.5, 4.0), st.floats(5e-3, 2e-2), st.floats(6.5, 8.0), st.sampled_from([None, 1.4]))
@example(2.0, 5e-3, 7.0, 1.4)
def test_advised_internal_pressure_passes_the_checks(seed, radius, slenderness, modulus, index):
    """Also when rounded, and with trapped gas."""
    device = {"radius": radius, "thickness": slenderness * radius, "young_modulus": 10.0**modulus}
    device["gas"] = index and {"adiabatic_index": index}
    vented = varied(seed, device={**device, "mass": 4.0 / 3.0 * np.pi * radius**3 * 512.0})
    text = ledger.viable_text(vented)
    assume(vented.device.internal_pressure == 0.0 and "viable from" in text)
    advised = float(text.split("internal_pressure = ")[1].split(" Pa")[0])
    assume(advised > 0.0)
    study = varied(vented, device={"internal_pressure": advised})
    classical, computed = ledger.shell_checks(study, reference_shell(study))[:2]
    assert (classical.name, classical.verdict) == ("buckling", "ok")
    assert (computed.name, computed.verdict) == ("computed_buckling", "ok")
    assert "a remark" in classical.explanation
    below = varied(vented, device={"internal_pressure": 0.99 * advised})
    (check,) = ledger.viability_checks(below)
    assert check.value > 1.0
    assert check.verdict == ("doubt" if ledger.carries_load(below) else "fail")


@pytest.mark.parametrize(("pressure", "verdict"), [(14.0e3, "fail"), (14.6e3, "doubt"), (16.4e3, "ok")])
def test_nonlinear_path_decides_on_viability(seed, pressure, verdict):
    """The seed's shell is stable from 14.3 kPa on, by linear buckling from 16.32 kPa."""
    study = varied(seed, device={"internal_pressure": pressure})
    classical, computed = ledger.shell_checks(study, reference_shell(study))[:2]
    assert (computed.name, computed.verdict) == ("computed_buckling", verdict)
    assert (computed.value > 1.0) == (verdict != "ok")
    assert classical.verdict == ("fail" if verdict == "fail" else "ok")
    assert ("advice only" in computed.explanation) == (verdict == "doubt")


def test_static_modal_amplitude_balances_the_load_to_first_order(seed):
    basis = study_basis(seed)
    static = static_modal_amplitude(seed, reference_shell(seed))
    assert static[1] == pytest.approx(-0.06, abs=0.02)  # about 6 cm of the breathing mode

    def unbalance(scale):
        shell = DeformedShell(basis, seed.centre_height, scale * static)
        load = shell.hydrostatic_force(1025.0, 9.81) - 9.81 * basis.inertia[0]
        return np.abs(load - basis.stiffness @ (scale * static)).max()

    rest = DeformedShell(basis, seed.centre_height).hydrostatic_force(1025.0, 9.81) - 9.81 * basis.inertia[0]
    assert unbalance(1.0) < 0.1 * np.abs(rest).max()


@pytest.mark.parametrize("mode", [1, 4, 7])
def test_largest_strain_equals_that_of_the_elastic_shell(seed, mode):
    """To first order in the amplitude of a mode."""
    basis = study_basis(seed)
    q = 1e-7 * np.eye(len(basis.labels))[mode]
    strains = ElasticShell(basis).strains(q, np.linspace(0.01, np.pi - 0.01, 361))
    assert largest_strain(basis, q) == pytest.approx(np.abs(strains).max(), rel=1e-5)


def test_gas_pressure_at_rest_follows_the_adiabatic_law(seed):
    """Of a stiff shell: p V^1.4 constant between the undeformed volume and that at rest."""
    device = {"internal_pressure": 2e4, "gas": {"adiabatic_index": 1.4}, "young_modulus": 1e9}
    found = []
    for shape in ("undeformed", "equilibrium"):
        study = varied(seed, device=device, reference_shape=shape)
        reference = reference_shell(study)
        found.append(ledger.pressure_at_rest(study, reference))
        keel = 1025 * 9.81 * reference.keel_depth - found[-1]
        check = ledger.classical_check(study, reference, carried=False)
        assert check.value * Shell.of(study.device).buckling_pressure == pytest.approx(max(0.0, keel))
    volume = ElasticShell(reference.basis).volume(reference.modal_amplitude)
    whole = (101325.0 + 2e4) * (32 / 3 * np.pi / volume) ** 1.4 - 101325.0
    assert found[1] == pytest.approx(whole, abs=1e-6)
    assert 0.005 * 2e4 < 2e4 - found[1] < 0.1 * 2e4
    assert found[0] == pytest.approx(whole, rel=5e-3)


def test_ledger_refuses_numbers_that_are_not_finite():
    assert json.loads(ledger.ledger_json("a_study", [])) == {"study": "a_study", "checks": [], "invalid": []}
    for value in (np.nan, np.inf):
        with pytest.raises(ValueError, match="Out of range float values are not JSON compliant"):
            ledger.ledger_json("s", [Check("buckling", value, 1.0, "-", "fail", "why")])


@pytest.mark.parametrize(("lowest", "highest", "share"), [(1.25, 2.5, 0.375), (0.5, 2.5, 0.25), (1.25, 3.5, 0.125)])
def test_energy_outside_the_band_adds_up(lowest, highest, share):
    """Share of a flat spectrum from 1 to 3 rad/s outside the band."""
    sea = WhiteNoise(kind="white_noise", hs=0.5, band=(1.0, 3.0))
    (_, cut) = ledger.wave_checks(sea, Water(), highest, lowest)
    assert cut.value == pytest.approx(share, rel=1e-9)


def test_buckling_of_a_spheroid_is_unknown(seed):
    shaped = seed.model_copy(update={"device": seed.device.model_copy(update={"shape": Spheroid(height=3.0)})})
    (check,) = ledger.viability_checks(shaped)
    assert (check.name, check.value, check.limit, check.verdict) == ("computed_buckling", 1.0, 1.0, "doubt")
    assert ledger.viability_checks(varied(seed, reference_shape="equilibrium")) == []


def test_steepness_is_height_over_wavelength():
    """Height: twice the amplitude of a regular wave, the significant height of a sea."""
    water = Water(depth=6.0, gravity=9.0)
    swell = RegularWave(kind="regular", amplitude=0.3, period=6.0)
    sea = Jonswap(kind="jonswap", hs=0.5, tp=7.0)
    for wave, height in ((swell, 0.6), (sea, 0.5)):
        checks = ledger.wave_checks(wave, water, 12.0)
        assert checks[0].value == pytest.approx(height * wavenumber(wave.omega, 6.0, 9.0) / (2 * np.pi), rel=1e-12)
        assert {check.wave for check in checks} == {wave.label}
        assert len(checks) == (1 if wave is swell else 2)


@pytest.mark.parametrize(
    ("clamp", "doubted"), [(1.5708, True), (3.14, True), (90.0, False), (0.0, False), (1.6, False)]
)
def test_angles_that_look_like_radians_are_doubted(seed, clamp, doubted):
    checks = ledger.angle_checks(varied(seed, designs={"A": {"clamp": clamp}}))
    assert [check.verdict for check in checks] == ["doubt"] * doubted
    assert all(f"designs.A.clamp.0 {clamp:g} (" in check.explanation for check in checks)
