"""Whether a shell carries its load: buckling margins and reasons of refused designs."""

import re
from pathlib import Path

import pytest

from vsb.models.rest import computed_buckling, reference_shell
from vsb.models.viability import buckling_margin, viability
from vsb.results import ledger
from vsb.study.study import load, parse

CONFIG = Path(__file__).parents[2] / "config"


def varied(study, **sections):
    """A study with other values in some sections."""
    raw = study.model_dump()
    return parse(raw | {name: raw[name] | values for name, values in sections.items()}, source="varied")


@pytest.fixture(scope="module")
def seed():
    """The shipped study."""
    return load(CONFIG.parent / "tests" / "data" / "seed.yaml")


def test_margin_matches_the_check_of_the_results(seed):
    """1 - load over buckling load; the published shell carries a fiftieth of its load."""
    (check,) = [one for one in ledger.viability_checks(seed) if one.name == "computed_buckling"]
    assert buckling_margin(seed) == pytest.approx(1 - check.value, rel=1e-6)


@pytest.mark.parametrize("factor", [0.5, 3.0, 100.0])
def test_margin_scales_with_the_modulus(seed, factor):
    """Buckling loads are proportional to Young's modulus where no gas is trapped."""
    stiffer = varied(seed, device={"young_modulus": factor * seed.device.young_modulus})
    assert 1 - buckling_margin(stiffer) == pytest.approx((1 - buckling_margin(seed)) / factor, rel=1e-9)


@pytest.mark.parametrize("modulus", [1e7, 3e9])
def test_margin_with_trapped_gas_matches_the_check_of_the_results(seed, modulus):
    gas = varied(seed, device={"young_modulus": modulus, "gas": {"adiabatic_index": 1.4}})
    (check,) = [one for one in ledger.viability_checks(gas) if one.name == "computed_buckling"]
    assert buckling_margin(gas) == pytest.approx(1 - check.value, rel=1e-6)
    assert (buckling_margin(gas) > 0) == (modulus > 1e9)


def test_shell_that_comes_to_rest_along_the_growing_load_carries_it():
    """Linear theory buckles it at 0.77 of its load; the checks of a study take that as advice."""
    study = load(CONFIG / "buoy.yaml")
    device = {"radius": 2.5, "thickness": 0.02, "young_modulus": 25e6, "mass": 29500.0}
    soft = varied(study, device=device, modes={"degree": 6})
    for one in (soft, soft.model_copy(update={"reference_shape": "undeformed"})):
        assert computed_buckling(one).load_factor == pytest.approx(0.77, abs=0.01)
        assert buckling_margin(one) == 0.0
        assert all(check.verdict != "fail" for check in ledger.viability_checks(one))
    assert viability(soft).reasons == {}


def test_rigid_designs_do_not_buckle(seed):
    rigid = parse(seed.model_dump() | {"designs": {"FSB": {"flexible": False}}}, source="rigid")
    found = viability(rigid)
    assert found.margin == 1.0
    assert found.reasons == {}


def test_unstable_spring_is_a_reason(seed):
    """Heave stiffness of a half-submerged sphere is rho g pi r^2."""
    water = seed.water.density * seed.water.gravity * 3.141592653589793 * seed.device.radius**2
    rigid = {"designs": {"FSB": {"flexible": False}}}
    held, lost = (
        viability(parse(seed.model_dump() | rigid | {"pto": {"damping": 1.0, "stiffness": -share * water}}, source="x"))
        for share in (0.99, 1.01)
    )
    assert held.reasons == {}
    assert lost.reasons["FSB"].startswith("unstable: least stiffness -")
    assert held.designs == ["FSB"]
    assert lost.designs == []


def test_missing_equilibrium_is_a_reason_for_every_design(seed):
    soft = parse(seed.model_dump() | {"reference_shape": "equilibrium"}, source="soft")
    found = viability(soft)
    assert found.reference is None
    assert set(found.reasons) == set(seed.designs)
    sentence = r"no equilibrium: the shell buckles at 0\.01\d+ of its load, into a shape of degree \d+"
    assert all(re.fullmatch(sentence, reason) for reason in found.reasons.values())
    assert found.designs == []


def test_capsizing_buoy_is_not_viable(seed, monkeypatch):
    monkeypatch.setattr("vsb.models.viability.buckling_margin", lambda study: -0.5)
    raw = seed.model_dump() | {"motion": "planar"}
    raw["device"] |= {"centre_of_mass": 0.1, "ballast_inertia": 9e3}
    raw["modes"] |= {"degree": 2, "order": 1}
    found = viability(parse(raw, source="top"))
    assert found.reasons == dict.fromkeys(seed.designs, "does not stay upright")
    assert found.reference is not None
    assert found.margin == -0.5
    assert found.designs == []


@pytest.mark.parametrize(("modulus", "verdict"), [(1e9, "ok"), (1e7, "doubt"), (5e6, "fail")])
def test_strain_at_rest_is_judged_as_in_a_study(seed, modulus, verdict):
    """Rigid designs have none."""
    study = varied(seed, device={"young_modulus": modulus})
    found, reference = viability(study), reference_shell(study)
    (check,) = [one for one in ledger.static_checks(study, reference) if one.name == "static_strain"]
    assert check.verdict == verdict
    assert found.reasons.get("VSWEC", "").startswith("overstrained: 14.8 % at rest" if verdict == "fail" else "")
    assert ("VSWEC" in found.reasons, "VSWEC" in found.doubts) == (verdict == "fail", verdict == "doubt")
    assert "FSB" not in {**found.reasons, **found.doubts}


def rubber(seed, **device):
    """The seed's buoy of neo-Hookean rubber about its rest shape."""
    raw = seed.model_dump()
    given = {"material": {"law": "neo_hookean", "mu": 1e6}, "thickness": 0.05, "density": 1100.0} | device
    hooke = ("young_modulus", "poisson_ratio")
    raw["device"] = {key: value for key, value in raw["device"].items() if key not in hooke} | given
    return parse({**raw, "modes": {"basis": "full", "degree": 4}, "reference_shape": "equilibrium"}, source="rubber")


def test_rubber_is_judged_by_its_own_law_and_its_path(seed):
    study = rubber(seed, internal_pressure=2e4)
    found, reference = viability(study), reference_shell(study)
    assert not found.reasons
    assert not found.doubts
    assert found.margin == pytest.approx(1 - 1 / 1.69, abs=0.01)
    checks = {check.name: check for check in ledger.shell_checks(study, reference)}
    assert {name: check.verdict for name, check in checks.items()} == dict.fromkeys(checks, "ok")
    assert checks["load_path"].value == pytest.approx(1 - found.margin)
    assert checks["static_strain"].value == pytest.approx(0.12, abs=0.01)


def test_rubber_that_wrinkles_or_bursts_is_told(seed):
    check = ledger.wrinkling_check(rubber(seed, internal_pressure=1.4e4))
    assert check.verdict == "doubt"
    assert "bending holds it, shapes of azimuthal order 2 keep 0.6 of their stiffness" in check.explanation
    burst = viability(rubber(seed, internal_pressure=4e4))
    assert burst.reference is None
    assert burst.margin < 0
    assert "the shell passes its limit point at 0." in burst.reasons["VSWEC"]
