"""What a whole study finds is the same in other units of mass and length, and in any order of its designs and seas.

Every number of every file is compared, from a study's file to its tables and figures: a density, a length or a sea's own
value that goes missing anywhere between them shows, and so does the first sea or design taken in place of each.
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
import xarray as xr
from invariance import HEAVE, JONSWAP, LENGTH, REGULAR, SEED, assert_close, factor, renamed, restated, usual

from vsb.stages.make import make
from vsb.study import study as config
from vsb.study.plan import StudyPlan

GAS = {"internal_pressure": 6e4, "gas": {"adiabatic_index": 1.4, "atmospheric_pressure": 101325.0}}
STUDIES = {
    "drag": HEAVE | {"drag": {"heave": {"coefficient": 1.0, "area": 6.0}}},
    "limits": HEAVE | {"pto": HEAVE["pto"] | {"force_limit": 900.0, "stroke_limit": 0.3},
                       "water": SEED["water"] | {"depth": 7.0}},
    "law": HEAVE | {"pto": {"law": "coulomb", "force_limit": 700.0}, "waves": [REGULAR]},
    "best": HEAVE | {"pto": {"stiffness": 1e3}},
    "exact": HEAVE | {"hydro": {"model": "body_exact", "omega_max": 4.0, "tolerance": 1e-2, "witness": "none"}},
    "pressure": HEAVE | {"hydro": {"model": "assumed_pressure", "pressure": 900.0}, "waves": [REGULAR]},
    "gas": HEAVE | {"device": SEED["device"] | GAS, "reference_shape": "equilibrium",
                    "pto": HEAVE["pto"] | {"port": {"between": [0.0, 180.0]}}},
    "planar": HEAVE | {"motion": "planar", "mooring": [2e4, 0.0, 0.0, 0.0, 0.0, 0.0],
                       "device": SEED["device"] | {"centre_of_mass": -0.5, "ballast_inertia": 9e3},
                       "modes": {"basis": "membrane", "degree": 2, "order": 2},
                       "pto": HEAVE["pto"] | {"port": "surge"}, "waves": [REGULAR | {"direction": 180.0}, JONSWAP]},
}  # fmt: skip
UNITS = {
    "displacement_pp": "m", "velocity_pp": "m/s", "pto_force_pp": "N", "power_peak": "W", "power_mean": "W", "energy": "J",
    "capture_width": "m", "damping": "N s/m", "stiffness": "N/m", "power_low": "W", "power_high": "W",
    "power_linear": "W", "force_rms": "N", "force_peak": "N", "stroke_peak": "m", "best_damping": "N s/m",
    "best_power": "W", "power": "W",
}  # fmt: skip
"""Of the columns of tables that have some."""
MACHINE = ("seconds", "energy_residual", "constraint_drift")
"""What is of the machine or of its round-off."""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Function study, look -> plan of its results: without meshes, and without figures and page but to look at them."""

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


def datasets(plan):
    """Its datasets by what they hold: a run by design and number of its sea."""
    runs = {
        f"{design} {i}": plan.trajectory_path(design, wave.label)
        for design in plan.study.designs
        for i, wave in enumerate(plan.study.waves)
    }
    paths = plan.hydro_files | plan.response_files | {"modes": f"{plan.folder}/modes.nc"} | runs
    return {name: xr.load_dataset(path) for name, path in paths.items()}


def tables(plan):
    """Rows of its tables and its checks, by their names."""
    folder = Path(plan.folder)
    found = json.loads((folder / "tables.json").read_text())
    ladder = folder / "ladder.json"
    found["ladder"] = json.loads(ladder.read_text()) if ladder.exists() else []
    return {name: rows for name, rows in found.items() if isinstance(rows, list)}


# units


def factors(name, values, coordinates):
    """What each number of a variable is multiplied by; a rotation has a length less, the moment on it one more."""
    units = values.attrs.get("units", "1")
    found = np.ones(values.shape) * factor(units)
    power = -1 if name in {"position", "velocity", "rao"} else float(units != "1")
    for axis, dim in enumerate(values.dims):
        if "dof" in dim:
            pitch = np.where(coordinates[dim].values == "Pitch", LENGTH**power, 1.0)
            found = found * np.expand_dims(pitch, [i for i in range(values.ndim) if i != axis])
    return found


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_in_other_units_finds_the_same(results, name):
    own, other = results(STUDIES[name]), results(restated(STUDIES[name]))
    restated_too = datasets(other)
    for what, ds in datasets(own).items():
        for variable, values in ds.variables.items():
            if np.issubdtype(values.dtype, np.number):
                expected = factors(variable, values, ds) * values.values
                assert_close(restated_too[what].variables[variable].values, expected, (what, variable))
    found = tables(other)
    for table, rows in tables(own).items():
        assert len(rows) == len(found[table])
        for row, restated_row in zip(rows, found[table], strict=True):
            for key, value in row.items():
                here = (table, row.get("name"), row.get("design"), key)
                if row.get("name") in MACHINE or key in MACHINE or key in {"wave", "sea", "explanation"}:
                    continue
                if isinstance(value, float):
                    units = row["unit"] if key in {"value", "limit"} else UNITS.get(key, "-")
                    rtol = 0.01 if table == "checks" else 1e-6
                    assert restated_row[key] == pytest.approx(factor(units) * value, rel=rtol, abs=1e-9), here
                else:
                    assert restated_row[key] == value, here


# order


def by_label(plan):
    """Its datasets by their words, designs and directions in order."""
    found = {}
    for name, ds in datasets(plan).items():
        design, _, sea = name.partition(" ")
        if "design" in ds.dims:
            ds = ds.assign_coords(design=[usual(str(one)) for one in ds.design.values]).sortby("design")
        if "wave_direction" in ds.dims:
            ds = ds.sortby("wave_direction")
        free = [variable for variable in ds.variables if variable.startswith("wet_")]
        found[usual(design) + (plan.study.waves[int(sea)].label if sea else "")] = ds.drop_vars(free)
    return found


def rows_by_words(rows):
    """Words and numbers of the rows of a table, in the order of their words."""
    told = [{k: v for k, v in row.items() if k not in MACHINE} for row in rows if row.get("name") not in MACHINE]
    words = [[usual(str(v)) for v in row.values() if not isinstance(v, float)] for row in told]
    numbers = [[v for v in row.values() if isinstance(v, float)] for row in told]
    return sorted(zip(words, numbers, strict=True))


@pytest.mark.parametrize("name", [name for name in STUDIES if len(STUDIES[name]["waves"]) > 1])
def test_designs_and_seas_in_another_order_find_the_same(results, name):
    raw = STUDIES[name]
    own, other = results(raw), results(renamed(raw) | {"waves": raw["waves"][::-1]})
    found = by_label(other)
    for what, ds in by_label(own).items():
        for variable, values in ds.variables.items():
            if np.issubdtype(values.dtype, np.number):
                assert_close(found[what].variables[variable].values, values.values, (what, variable))
    there = tables(other)
    for table, rows in tables(own).items():
        for (words, numbers), (same_words, same) in zip(rows_by_words(rows), rows_by_words(there[table]), strict=True):
            assert words == same_words
            assert numbers == pytest.approx(same, rel=1e-6, abs=1e-9), (table, words)


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
    """Points of every curve with a name, by its figure, axes and name, sorted."""
    found = {}
    for path in Path(plan.folder).glob("figures/*.csv"):
        for row in csv.DictReader(usual(path.read_text()).splitlines()):
            if not row["series"].startswith("line "):
                found.setdefault((path.name, row["axes"], row["series"]), []).append((float(row["x"]), float(row["y"])))
    return found


def test_figures_and_page_of_another_order_show_the_same(results):
    """The same curves and bars, the same words as often."""
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
