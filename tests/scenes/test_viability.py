"""Whether a shell carries its load: margins against the ledger's buckling, and reasons in place of failures."""

import math
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from vsb.errors import ConfigError, ConvergenceError
from vsb.motion.port import port_direction
from vsb.results import ledger
from vsb.scenes.rest import reference_shell
from vsb.scenes.viability import buckling_margin, viability
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


def test_the_margin_is_that_of_the_ledger(seed):
    """1 - load over buckling load; the seed's shell carries a fiftieth of its load."""
    (check,) = [one for one in ledger.viability_checks(seed) if one.name == "computed_buckling"]
    assert buckling_margin(seed) == pytest.approx(1 - check.value, rel=1e-6)


@pytest.mark.parametrize("factor", [0.5, 3.0, 100.0])
def test_the_margin_goes_with_the_modulus(seed, factor):
    """Buckling loads are proportional to Young's modulus where no gas is trapped."""
    stiffer = varied(seed, device={"young_modulus": factor * seed.device.young_modulus})
    assert 1 - buckling_margin(stiffer) == pytest.approx((1 - buckling_margin(seed)) / factor, rel=1e-9)


@pytest.mark.parametrize("modulus", [1e7, 3e9])
def test_with_trapped_gas_the_margin_is_that_of_the_ledger(seed, modulus):
    """Of a shell that gives way and of one that stands."""
    gas = varied(seed, device={"young_modulus": modulus, "gas": {"adiabatic_index": 1.4}})
    (check,) = [one for one in ledger.viability_checks(gas) if one.name == "computed_buckling"]
    assert buckling_margin(gas) == pytest.approx(1 - check.value, rel=1e-6)
    assert (buckling_margin(gas) > 0) == (modulus > 1e9)


def test_a_study_of_rigid_designs_does_not_buckle(seed):
    rigid = parse(seed.model_dump() | {"designs": {"FSB": {"flexible": False}}}, source="rigid")
    found = viability(rigid)
    assert found.margin == 1.0
    assert found.reasons == {}


def test_a_shell_that_buckles_about_the_sphere_keeps_its_result(seed):
    found = viability(seed)
    assert found.margin < 0
    assert found.reference is not None
    assert found.reasons == {}


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


def test_a_spring_that_pulls_harder_than_water_is_a_reason(seed):
    """Heave stiffness of a half-immersed sphere is rho g pi r^2."""
    water = seed.water.density * seed.water.gravity * 3.141592653589793 * seed.device.radius**2
    rigid = {"designs": {"FSB": {"flexible": False}}}
    held, lost = (
        viability(parse(seed.model_dump() | rigid | {"pto": {"damping": 1.0, "stiffness": -share * water}}, source="x"))
        for share in (0.99, 1.01)
    )
    assert held.reasons == {}
    assert lost.reasons["FSB"].startswith("unstable: least stiffness -")
    assert held.viable is not None
    assert lost.viable is None


def test_a_spring_behind_a_chamber_is_a_reason_only_where_shell_and_gas_together_give_way(seed):
    """On the volume v a spring k behind a chamber C, V/(kappa p) of the gas, is k/(1 + k C) to the shell."""
    study = varied(seed, device={"gas": {"adiabatic_index": 1.4}}, modes={"degree": 2}, pto={"port": "volume"})
    reference = reference_shell(study)
    chamber = 4 / 3 * math.pi * 2.0**3 / (1.4 * 101325.0)
    b = port_direction("volume", reference.shape)
    opened = reference.total - reference.stiffness["gas"]
    least = -1 / (chamber + float(b @ np.linalg.solve(opened, b)))
    held, lost = (viability(varied(study, pto={"stiffness": share * least})) for share in (0.999, 1.001))
    assert held.reasons == {}
    assert lost.reasons.keys() == {"VSWEC"}
    for found in (held, lost):
        alone, shell = found.viable
        assert list(alone.designs) == [name for name in study.designs if name not in found.reasons]
        assert shell is found.reference


def test_no_shape_at_rest_is_a_reason_for_every_design(seed):
    soft = parse(seed.model_dump() | {"reference_shape": "equilibrium"}, source="soft")
    found = viability(soft)
    assert found.reference is None
    assert set(found.reasons) == set(seed.designs)
    sentence = r"no equilibrium: the shell buckles at 0\.01\d+ of its load, into a shape of degree \d+"
    assert all(re.fullmatch(sentence, reason) for reason in found.reasons.values())
    assert found.viable is None


@pytest.mark.parametrize("error", [ConfigError("no shape"), ConvergenceError("it sinks; raise something")])
@pytest.mark.parametrize("shape", ["equilibrium", "undeformed"])
def test_only_where_a_shape_at_rest_is_asked_for_its_lack_is_a_reason(seed, monkeypatch, error, shape):
    """About the sphere it is a mistake of the study, told as such."""

    def none(study):
        raise error

    monkeypatch.setattr("vsb.scenes.viability.reference_shell", none)
    monkeypatch.setattr("vsb.scenes.viability.buckling_margin", lambda study: 0.25)
    study = seed.model_copy(update={"reference_shape": shape})
    if shape == "undeformed":
        with pytest.raises(type(error), match=str(error)):
            viability(study)
        return
    found = viability(study)
    assert (found.study, found.reference, found.margin, found.viable) == (study, None, 0.25, None)
    assert found.reasons == dict.fromkeys(seed.designs, f"no equilibrium: {str(error).partition(';')[0]}")


def test_buckling_is_computed_of_the_shell_in_its_water_at_one_modulus_whatever_else_the_study_says(seed, monkeypatch):
    """Damping, depth and modes do not load it; what it buckles under goes with its own modulus."""
    asked = []

    def computed(study):
        asked.append(study)
        return SimpleNamespace(load_factor=8.0)

    monkeypatch.setattr("vsb.scenes.viability.computed_buckling", computed)
    device = {"thickness": 0.0123, "internal_pressure": 4e3, "young_modulus": 2e8}
    study = varied(seed, device=device, water={"density": 987.0, "gravity": 9.7})
    for change in ({}, {"device": {"damping": {"alpha": 3.0}}}, {"water": {"depth": 30.0}}, {"modes": {"degree": 3}}):
        assert buckling_margin(varied(study, **change)) == pytest.approx(1 - 5.0 / 8.0, rel=1e-14)
    (shell,) = asked  # once for all
    assert shell.device.model_copy(update={"young_modulus": 2e8, "damping": study.device.damping}) == study.device
    assert (shell.device.young_modulus, shell.water) == (1e9, study.water)
    assert shell.centre_height == study.centre_height
    gas = varied(study, device={"gas": {"adiabatic_index": 1.4}})
    assert buckling_margin(gas) == 1 - 1.0 / 8.0
    assert asked[1:] == [gas]


def test_a_buoy_that_falls_over_is_not_viable_in_any_design(seed, monkeypatch):
    monkeypatch.setattr("vsb.scenes.viability.buckling_margin", lambda study: -0.5)
    raw = seed.model_dump() | {"motion": "planar"}
    raw["device"] |= {"centre_of_mass": 0.1, "ballast_inertia": 9e3}
    raw["modes"] |= {"degree": 2, "order": 1}
    found = viability(parse(raw, source="top"))
    assert found.reasons == dict.fromkeys(seed.designs, "does not stay upright")
    assert found.reference is not None
    assert found.margin == -0.5
    assert found.viable is None


def test_each_design_that_gives_way_is_told_by_its_own_least_stiffness(seed, monkeypatch):
    """One of none at all does not rest either; those that do stay in their order, with the shell at rest."""
    least = dict(zip(seed.designs, (-3.217, 2e4, 0.0, 1e-9), strict=True))
    assert len(least) == 4
    monkeypatch.setattr("vsb.scenes.viability.design_stiffness", lambda study, seen, design, spring: least[design])
    monkeypatch.setattr("vsb.scenes.viability.buckling_margin", lambda study: 0.125)
    found = viability(seed)
    names = list(seed.designs)
    assert found.reasons == {
        names[0]: "unstable: least stiffness -3.22 N/m",
        names[2]: "unstable: least stiffness 0 N/m",
    }
    assert found.margin == 0.125
    alone, shell = found.viable
    assert list(alone.designs.items()) == [(name, seed.designs[name]) for name in (names[1], names[3])]
    assert shell is found.reference
    assert found.study is seed


def test_the_spring_of_a_take_off_acts_where_its_port_is_and_on_no_chamber_else(seed, monkeypatch):
    """k b b^T beside the shell as the port finds it, for every design."""
    asked = []
    monkeypatch.setattr("vsb.scenes.viability.design_stiffness", lambda *given: asked.append(given) or 1.0)
    monkeypatch.setattr("vsb.scenes.viability.buckling_margin", lambda study: 0.125)
    study = varied(seed, pto={"port": {"between": [30, 150]}, "stiffness": -2.5e3}, modes={"degree": 3})
    found = viability(study)
    b = port_direction(study.pto.port, found.reference.shape)
    assert np.abs(b).max() > 0.1
    assert [design for _, _, design, _ in asked] == list(study.designs)
    for given, reference, _, spring in asked:
        assert (given, reference) == (study, found.reference)
        np.testing.assert_allclose(spring, -2.5e3 * np.outer(b, b), rtol=1e-12, atol=1e-9)
