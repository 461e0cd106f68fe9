"""Results of whole studies do not depend on units of mass and length, nor on the order of designs and seas.

Every number of every file is compared, from the study to its tables and figures.
"""

import csv
import json
import re
from collections import Counter
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from invariance import (
    HEAVE,
    JONSWAP,
    REGULAR,
    SEED,
    assert_close,
    assert_same_in_another_order,
    assert_same_in_other_units,
    renamed,
    restated,
    usual,
)

from vsb.stages.make import make
from vsb.study import study as config
from vsb.study.plan import StudyPlan

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
        people = () if look else (".html", ".pdf", ".svg", ".csv")
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


class Words(HTMLParser):
    """Words of a page, without those of figures and scripts, files, seconds and the study's own text."""

    LEFT_OUT = frozenset({"svg", "script", "style", "pre"})

    def __init__(self):
        super().__init__()
        self.inside, self.found = [], []

    def handle_starttag(self, tag, attrs):
        if tag in self.LEFT_OUT or (tag == "td" and "id" in (dict(attrs).get("class") or "").split()):
            self.inside.append(tag)

    def handle_endtag(self, tag):
        if self.inside and self.inside[-1] == tag:
            self.inside.pop()

    def handle_data(self, data):
        if not self.inside:
            self.found += re.findall(r"[^\s,;:()]+", usual(data))


def curves(plan):
    """Points of every named curve, by figure, axes and name."""
    found = {}
    for path in Path(plan.folder).glob("figures/*.csv"):
        for row in csv.DictReader(usual(path.read_text()).splitlines()):
            if not row["series"].startswith("line "):
                found.setdefault((path.name, row["axes"], row["series"]), []).append((float(row["x"]), float(row["y"])))
    return found


@pytest.mark.slow
def test_figures_and_page_do_not_depend_on_the_order(results):
    """The same curves and bars, and the same words equally often."""
    raw = STUDIES["drag"]
    own, other = results(raw, True), results(renamed(raw) | {"waves": raw["waves"][::-1]}, True)
    found = curves(other)
    shown = curves(own)
    assert shown.keys() == found.keys()
    for name, points in shown.items():
        for there, here in zip(np.sort(found[name], axis=0).T, np.sort(points, axis=0).T, strict=True):
            assert_close(there, here, name, 1e-4)
    pages = []
    for plan in (own, other):
        words = Words()
        words.feed(Path(plan.folder, "report.html").read_text())
        pages.append(Counter(words.found))
    assert (pages[0] - pages[1], pages[1] - pages[0]) == (Counter(), Counter())
