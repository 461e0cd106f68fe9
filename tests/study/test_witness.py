"""What the second solver of a study is asked."""

import math

import pytest
import xarray as xr
from conftest import shipped, varied

from vsb.results.ledger import witness_checks
from vsb.study.blocks import no_witness
from vsb.study.plan import StudyPlan, figure_names
from vsb.study.study import load


@pytest.mark.parametrize(
    ("name", "change", "reason", "checks"),
    [
        ("seed", {"hydro": {"witness": "none"}}, "hydro.witness: none", 0),
        ("paper", {}, "an assumed pressure has no coefficients", None),
        ("seed", {"water": {"depth": 2.02}}, "the spectral solver needs a water.depth of 1.02 drafts", 1),
    ],
)
def test_reason_for_no_cross_check(name, change, reason, checks):
    study = varied(load(shipped(name)), **change)
    plan = StudyPlan(study)
    assert no_witness(study) == reason
    assert plan.witness is None
    assert plan.deformed_paths == []
    assert plan.witness_files == {}
    assert "witness" not in figure_names(study)
    if checks is not None:
        found = witness_checks(study, xr.Dataset(), xr.Dataset())
        assert [check.verdict for check in found] == ["doubt"] * checks
        assert all(reason in check.explanation for check in found)


@pytest.mark.parametrize("depth", [math.inf, 100.0, 20.0, 2.5])
def test_waves_lie_within_reach_of_both_solvers(seed, depth):
    spec = StudyPlan(varied(seed, water={"depth": depth})).witness
    assert len(spec.omega) == 3
    assert list(spec.omega) == sorted(set(spec.omega))
    wavenumbers = [w**2 / 9.81 for w in spec.omega]  # or larger
    assert wavenumbers[-1] * 2.0 == pytest.approx(3.0, rel=1e-2)
    if math.isinf(depth):
        assert wavenumbers[0] * 2.0 == pytest.approx(0.3, rel=1e-5)
    else:
        assert spec.omega[0] >= math.sqrt(9.81 * 0.3 / depth * math.tanh(0.3)) - 1e-5


def test_no_cross_check_of_other_shapes_or_very_shallow_water(seed):
    spheroid = {
        "device": {"shape": {"spheroid": {"height": 3.0}}, "mass": 9e3},
        "modes": {"basis": "full", "degree": 2},
    }
    assert no_witness(varied(seed, **spheroid)) == "panels are those of the sphere"
    deep = varied(seed, water={"depth": 1.02 * seed.draft})
    assert no_witness(deep) == ""
    shallow = varied(seed, water={"depth": 1.0199 * seed.draft})
    assert no_witness(shallow) == "the spectral solver needs a water.depth of 1.02 drafts"
