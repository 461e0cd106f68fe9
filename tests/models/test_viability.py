"""Whether a shell carries its load: buckling margins and reasons of refused designs."""

import re
from pathlib import Path

import pytest
from conftest import varied

from vsb.errors import ConfigError
from vsb.models.rest import check_stable, computed_buckling, reference_shell
from vsb.models.viability import advised, buckling_margin, check_rests_advised, static_strain, viability, viable
from vsb.results import ledger
from vsb.results.ledger import shell_checks
from vsb.study.study import load, parse

CONFIG = Path(__file__).parents[2] / "config"


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


@pytest.mark.slow
@pytest.mark.parametrize("gas", [{}, {"gas": {}}], ids=["open", "trapped"])
def test_a_wall_that_no_pressure_carries_is_told_the_least_that_stands(gas):
    """Of rubber of 1 MPa, 12 mm thick and 3.2 m in radius: it inflates without bound from 1.24 mu h/r = 4.65 kPa, and
    buckles below the 32 kPa of the water at its keel, so that "more" and "less pressure" would be advised in turn.
    """
    device = {"radius": 3.2, "thickness": 0.012, "density": 1100.0, "internal_pressure": 16500.0, **gas}
    device["material"] = {"law": "neo_hookean", "mu": 1e6}
    study = parse(
        {"study": "a", "device": device, "modes": {"degree": 4}, "reference_shape": "equilibrium",
         "designs": {"V": {}}, "pto": {"damping": 1e4}, "waves": [{"kind": "still"}]}
    )  # fmt: skip
    with pytest.raises(ConfigError) as error:
        reference_shell(study)
    text = str(advised(study, error.value))
    assert "no device.internal_pressure from 0 to" in text
    assert "from a thickness of about" in text
    assert "mm at" in text
    assert "or from a shear modulus of" in text


def soft(changes, **device):
    """A study about its equilibrium of a shell of 10 MPa, 5 mm thick, but for some changes."""
    shell = {"radius": 2.0, "thickness": 0.005, "young_modulus": 1e7, "poisson_ratio": 0.3, "density": 1100.0}
    return parse(
        {"study": "a", "device": {**shell, **device, **changes}, "modes": {"degree": 4}, "designs": {"V": {}},
         "reference_shape": "equilibrium", "pto": {"damping": 1e4}, "waves": [{"kind": "still"}]}
    )  # fmt: skip


@pytest.mark.parametrize(
    "device",
    [
        {"mass": 17170.0, "internal_pressure": 5e3},
        pytest.param({"mass": 12e3, "shape": {"spheroid": {"height": 3.0}}}, marks=pytest.mark.slow),
        pytest.param({"mass": 3e4, "shape": {"capsule": {"length": 2.0}}}, marks=pytest.mark.slow),
    ],
    ids=["sphere", "spheroid", "capsule"],
)
def test_modulus_and_pressure_that_are_advised_carry_the_shell_at_strains_hookes_law_holds_for(device):
    """Each shell of 10 MPa would stand at some pressure, strained beyond 10 %: that is no advice."""
    study = soft({}, **device)
    with pytest.raises(ConfigError) as error:
        reference_shell(study)
    text = str(advised(study, error.value))
    assert "without straining it too far; from a thickness of about" in text
    modulus, pressure = re.search(r"or from young_modulus (\S+) MPa at (\S+) Pa, it is stable \(tried\)", text).groups()
    better = soft({"young_modulus": 1e6 * float(modulus), "internal_pressure": float(pressure)}, **device)
    rest = reference_shell(better)
    assert static_strain(rest.basis, rest.modal_amplitude) < 0.1
    assert computed_buckling(better).load_factor > 1.0


@pytest.mark.parametrize(
    "shape",
    [{}, pytest.param({"shape": {"spheroid": {"height": 3.0}}}, marks=pytest.mark.slow)],
    ids=["sphere", "spheroid"],
)
def test_what_is_advised_about_the_undeformed_shape_passes_its_checks(shape):
    """The pressure from which a shell of 10 MPa does not buckle strains it beyond the 10 % of Hooke's law: raising the
    pressure and then a stiffer shell would be advised in turn.
    """
    study = soft({}, mass=17170.0, **shape).model_copy(update={"reference_shape": "undeformed"})
    (line,) = (check for check in shell_checks(study, reference_shell(study)) if check.name == "computed_buckling")
    words = r"where its law ends at 10 %; from a thickness of about (\S+) mm at (\S+) Pa, or from young_modulus (\S+) MPa at (\S+) Pa"
    wall, at, modulus, pressure = map(float, re.search(words, line.advice).groups())
    for changes in (
        {"thickness": 1e-3 * wall, "internal_pressure": at},
        {"young_modulus": 1e6 * modulus, "internal_pressure": pressure},
    ):
        better = study.model_copy(update={"device": study.device.model_copy(update=changes)})
        assert all(check.verdict != "fail" for check in shell_checks(better, reference_shell(better)))


def test_a_shell_that_its_pressure_makes_unstable_is_advised_less():
    """More of modulus, wall or pressure is no advice where the pressure, 60 times what the shell needs, is the cause."""
    shell = {"young_modulus": 2e6, "thickness": 0.015}
    study = soft(shell, mass=17170.0, internal_pressure=2e5, shape={"spheroid": {"height": 3.0}})
    study = study.model_copy(update={"reference_shape": "undeformed"})
    with pytest.raises(ConfigError, match="is unstable") as error:
        check_stable(study, reference_shell(study))
    text = str(advised(study, error.value))
    modulus, pressure = re.search(r"from young_modulus (\S+) MPa at (\S+) Pa, it is stable \(tried\)", text).groups()
    assert float(pressure) < 2e5
    device = {"young_modulus": 1e6 * float(modulus), "internal_pressure": float(pressure)}
    better = study.model_copy(update={"device": study.device.model_copy(update=device)})
    check_stable(better, reference_shell(better))


def test_pressure_that_strains_a_shell_beyond_its_law_is_advised_to_be_less():
    """Thirteen times the water's pressure at the keel: the shell stands, at strains no law of linear elasticity holds for."""
    study = soft({"young_modulus": 4e7, "thickness": 0.015}, mass=17170.0, internal_pressure=2e5)
    (line,) = (check for check in shell_checks(study, reference_shell(study)) if check.name == "static_strain")
    assert line.verdict == "fail"
    (pressure,) = re.search(r"device.internal_pressure of (\S+) Pa carries this shell \(tried\)", line.advice).groups()
    assert float(pressure) < 2e5


def test_pressure_that_is_advised_for_rubber_leaves_no_wrinkles():
    """Four spans between too little pressure and too much: buckled, wrinkled, at rest, burst."""
    device = {"radius": 2.0, "thickness": 0.05, "density": 1100.0, "mass": 17170.0}
    device |= {"material": {"law": "neo_hookean", "mu": 1e6}, "internal_pressure": 1e4}
    study = parse(
        {"study": "a", "device": device, "modes": {"degree": 4}, "reference_shape": "equilibrium",
         "designs": {"V": {}}, "pto": {"damping": 1e4}, "waves": [{"kind": "still"}]}
    )  # fmt: skip
    with pytest.raises(ConfigError, match="buckles at") as error:
        reference_shell(study)
    (pressure,) = re.search(r"device.internal_pressure of (\S+) Pa carries", str(advised(study, error.value))).groups()
    device = study.device.model_copy(update={"internal_pressure": float(pressure)})
    better = study.model_copy(update={"device": device})
    assert all(check.verdict == "ok" for check in shell_checks(better, reference_shell(better)))


def test_advised_pressure_is_not_that_at_which_the_shell_gives_way(seed):
    """Just where a load factor of 1 is reached the rest of a shape of degree 10 has no end: a strain of 2790."""
    wall = {"radius": 4.51, "thickness": 0.146, "young_modulus": 27.5e6, "poisson_ratio": 0.38, "density": 1035.0}
    study = varied(seed, device=wall | {"mass": 211660.0}, modes={"basis": "full", "degree": 30})
    pressure, strain = viable(study)
    assert 430.6 < pressure < 1000.0
    assert 0.01 < strain < 0.02


def test_pressure_advised_for_body_exact_water_is_one_at_which_the_shell_rests():
    """More of each of three things was advised, as of rubber that more pressure only inflates."""
    study = load(CONFIG / "pressurised.yaml")
    low = varied(study, hydro={"model": "body_exact"}, device={"internal_pressure": 5e3, "thickness": 0.02})
    low = low.model_copy(update={"reference_shape": "undeformed"})
    with pytest.raises(ConfigError, match=r"gives way under the static load; device.*\(tried\), or use") as refused:
        check_rests_advised(low, reference_shell(low))
    pressure = float(re.search(r"internal_pressure of (\S+) Pa", str(refused.value))[1])
    assert pressure > 14e3
    rests = varied(low, device={"internal_pressure": pressure})
    check_rests_advised(rests, reference_shell(rests))
    assert buckling_margin(rests) >= 0
