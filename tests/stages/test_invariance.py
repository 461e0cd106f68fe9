"""Results of whole studies do not depend on units of mass and length, nor on the order of designs and seas.

Every number of every file is compared, from the study to its tables and figures.
"""

import json
from functools import cache

import pytest
from invariance import (
    HEAVE,
    JONSWAP,
    REGULAR,
    SEED,
    assert_same_in_another_order,
    assert_same_in_other_units,
    renamed,
    restated,
)

from vsb.pipeline.graph import StudyPlan
from vsb.stages.make import make
from vsb.study import study as config

GAS = {"internal_pressure": 6e4, "gas": {"adiabatic_index": 1.4, "atmospheric_pressure": 101325.0}}
STUDIES = {
    "drag": HEAVE | {"drag": {"heave": {"coefficient": 1.0, "area": 6.0}}},
    "limits": HEAVE | {"pto": HEAVE["pto"] | {"force_limit": 900.0, "stroke_limit": 0.3},
                       "water": SEED["water"] | {"depth": 7.0}},
    "exact": HEAVE | {"hydro": {"model": "body_exact", "omega_max": 4.0, "tolerance": 1e-2, "witness": "none"}},
    "pressure": HEAVE | {"hydro": {"model": "assumed_pressure", "pressure": 900.0}, "waves": [REGULAR]},
    "gas": HEAVE | {"device": SEED["device"] | GAS, "reference_shape": "equilibrium",
                    "pto": HEAVE["pto"] | {"port": {"between": [0.0, 180.0]}}},
    "planar": HEAVE | {"motion": "planar", "mooring": [2e4, 0.0, 0.0, 0.0, 0.0, 0.0],
                       "device": SEED["device"] | {"centre_of_mass": -0.5, "ballast_inertia": 9e3},
                       "modes": {"basis": "membrane", "degree": 2, "order": 2},
                       "pto": HEAVE["pto"] | {"port": "surge"}, "waves": [REGULAR | {"direction": 180.0}, JONSWAP]},
}  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Function study, look -> plan of its results, with figures and page only where `look` is set."""

    @cache
    def run(text, look):
        plan = StudyPlan(config.parse(json.loads(text)), root=str(tmp_path_factory.mktemp("results")))
        people = () if look else (".html", ".svg", ".csv")
        make(
            plan,
            [path for path in plan.products if not path.endswith((".vtu", *people)) or path.endswith("ladder.csv")],
        )
        return plan

    return lambda raw, look=False: run(json.dumps(raw), look)


@pytest.mark.parametrize(
    "name", [name if name == "pressure" else pytest.param(name, marks=pytest.mark.slow) for name in STUDIES]
)
def test_results_do_not_depend_on_units(results, name):
    assert_same_in_other_units(results(STUDIES[name]), results(restated(STUDIES[name])))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["limits", "exact", "planar"])
def test_results_do_not_depend_on_the_order_of_designs_and_seas(results, name):
    raw = STUDIES[name]
    assert_same_in_another_order(results(raw), results(renamed(raw) | {"waves": raw["waves"][::-1]}))
