"""Whether a shell carries its load: margins against the ledger's buckling, and reasons in place of failures."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

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
    return load(CONFIG / "seed.yaml")


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
