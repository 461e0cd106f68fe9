"""Quantities in files: read where a key has a dimension, with the id of the same number in SI."""

import copy
import math
import re

import pytest
import yaml
from conftest import SEED

from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.errors import ConfigError
from vsb.keys.quantities import canonical
from vsb.keys.reading import validated
from vsb.keys.schema import in_si, unit_of
from vsb.pipeline.graph import StudyPlan
from vsb.study import study as config
from vsb.study.body import BodyStudy
from vsb.study.campaign import Campaign
from vsb.study.design import Optimisation
from vsb.study.study import BuoyStudy, unlikely_units
from vsb.tools.commands import HOME


def with_units(model, raw, place=()):
    """The same with the unit of its key behind every number that has one."""
    if isinstance(raw, dict):
        return {key: with_units(model, value, (*place, key)) for key, value in raw.items()}
    if isinstance(raw, list):
        return [with_units(model, value, (*place, i)) for i, value in enumerate(raw)]
    number = isinstance(raw, int | float) and not isinstance(raw, bool) and math.isfinite(raw)
    unit = unit_of(model, WHOLE[model], place) if number else None
    return f"{raw} {unit.unit}" if unit and not unit.several and unit.unit != "-" else raw


def read(name):
    return yaml.load((HOME / "config" / name).read_text(encoding="utf-8"), yaml.CSafeLoader)


WHOLE = {
    BuoyStudy: read("seed.yaml"),
    BodyStudy: read("barge.yaml"),
    BodyFile: read("barge/body.yaml"),
    Campaign: read("year.yaml") | {"vary": {"device.thickness": {"log": [0.01, 0.02, 3]}, "water.density": [1e3]}},
    Optimisation: read("best_buoy.yaml"),
}


@pytest.mark.parametrize("model", WHOLE, ids=lambda model: model.__name__)
def test_every_number_may_be_written_with_the_unit_of_its_key(model):
    """In every kind of file: what is read is the file without units."""
    written = with_units(model, WHOLE[model])
    assert written != WHOLE[model]
    assert in_si(model, written) == WHOLE[model]


def test_ids_are_those_of_the_numbers_in_si():
    raw = yaml.safe_load(SEED.read_text())
    given = copy.deepcopy(raw)
    given["device"] |= {"thickness": "10 mm", "radius": "200 cm", "young_modulus": "10 MPa", "poisson_ratio": "30 %"}
    given["pto"] = {"damping": "8 kN s/m"}
    given["simulation"]["duration"] = "1 min"
    assert canonical(config.parse(given)) == canonical(config.parse(raw))
    assert StudyPlan(config.parse(given)).database.out == StudyPlan(config.parse(raw)).database.out


@pytest.mark.parametrize(
    ("pto", "read"),
    [
        ({"damping": "8 kN s/m"}, 8e3),
        ({"damping": "8 kPa s/m^3", "port": "volume"}, 8e3),
        ({"damping": "8 kN m s", "port": "pitch"}, 8e3),
        ({"damping": {"FSB": "8 kN s/m"}}, {"FSB": 8e3}),
    ],
)
def test_unit_of_a_damper_is_that_of_its_port(pto, read):
    assert in_si(BuoyStudy, {"pto": pto})["pto"]["damping"] == read


@pytest.mark.parametrize(
    ("model", "changes", "message"),
    [
        (
            BuoyStudy,
            {"pto": {"damping": "8 kN/m"}},
            "pto.damping: received '8 kN/m'; needs a number in N s/m: kN/m is of",
        ),
        (
            BuoyStudy,
            {"pto": {"damping": "8 kN s/m", "port": "volume"}},
            "needs a number in Pa s/m.3: kN s/m is of another",
        ),
        (BuoyStudy, {"mooring": ["20 kN/m", 0, 0, 0, 0, 0]}, "without a unit: 20 kN/m is 20000 N/m"),
        (BodyStudy, {"body": {"bemio": "a", "mass": {"Pitch": "5 t"}}}, "without a unit: 5 t is 5000 kg"),
        (Optimisation, {"limits": {"force_rms": "20 kN"}}, "in N, without a unit: 20 kN is 20000 N"),
    ],
)
def test_a_unit_that_cannot_be_read_is_refused_with_the_conversion(model, changes, message):
    """A spring of a rotation and one of a translation stand under one key: the file must say which it means."""
    with pytest.raises(ConfigError, match=message) as error:
        validated(model, WHOLE[model] | changes, "file.yaml")
    assert error.value.mistakes[0].startswith("file.yaml: ")


@pytest.mark.parametrize(
    ("section", "values", "guess"),
    [
        ("device", {"thickness": 15}, r"thickness 15 m: .* did you mean 15 mm\?"),
        ("device", {"mass": 17}, r"mass 17 kg: .* did you mean 17 t\?"),
        ("device", {"poisson_ratio": 30}, r"poisson_ratio: received 30; .* did you mean 30 %\?"),
        ("device", {"radius": 2000}, r"radius: received 2000; .* did you mean 2000 mm\?"),
        ("device", {"draft": 450}, r"draft: received 450.* did you mean 450 mm\?"),
        ("pto", {"efficiency": 90}, r"efficiency: received 90; .* did you mean 90 %\?"),
    ],
)
def test_a_number_out_of_range_that_fits_in_another_unit_is_asked_for(section, values, guess):
    raw = copy.deepcopy(WHOLE[BuoyStudy])
    raw[section] = raw.get(section, {}) | values
    if "draft" in values:
        del raw["device"]["mass"]
    with pytest.raises(ConfigError, match=guess):
        config.parse(raw)


@pytest.mark.parametrize(
    ("section", "values"),
    [
        ("device", {"poisson_ratio": 0.5}),
        ("device", {"thickness": 0.25}),
        ("device", {"draft": 4.5}),
        ("device", {"draft": -1.0}),
        ("device", {"radius": -2.0}),
        ("pto", {"efficiency": 1.8}),
        ("pto", {"efficiency": 200}),
    ],
)
def test_a_number_unlikely_in_every_unit_is_asked_for_in_none(section, values):
    """Who writes 0.5 means a half, no shell has a quarter of a millimetre, no buoy a draft of 4.5 mm."""
    raw = copy.deepcopy(WHOLE[BuoyStudy])
    raw[section] = raw.get(section, {}) | values
    if "draft" in values:
        del raw["device"]["mass"]
    with pytest.raises(ConfigError) as error:
        config.parse(raw)
    assert "did you mean" not in str(error.value)


@pytest.mark.parametrize(
    ("section", "values", "guess"),
    [
        ("device", {"young_modulus": 40.0}, "device.young_modulus: 40 Pa is very little; did you mean 40 MPa?"),
        ("device", {"internal_pressure": 16.5}, "device.internal_pressure: 16.5 Pa .* did you mean 16.5 kPa?"),
        ("device", {"density": 1.1}, "device.density: 1.1 kg/m.3 is very little; did you mean 1.1 g/cm.3?"),
        ("water", {"density": 1.025}, "water.density: 1.025 kg/m.3 is very little; did you mean 1.025 g/cm.3?"),
        ("pto", {"damping": 8.0}, "pto.damping: 8 N s/m is very little; did you mean 8 kN s/m?"),
    ],
)
def test_a_number_that_is_usual_only_in_another_unit_is_doubted(section, values, guess):
    """All are possible, so none is refused; each is a thousand times too small or more."""
    raw = copy.deepcopy(WHOLE[BuoyStudy])
    raw[section] = raw.get(section, {}) | values
    if section == "water":
        raw["device"] |= {"mass": 30.0, "density": 1.0}
    lines = unlikely_units(config.parse(raw))
    assert any(re.match(guess.replace("?", r"\?"), line) for line in lines), lines


def test_shipped_studies_have_usual_numbers():
    for path in (HOME / "config").glob("*.yaml"):
        raw = yaml.safe_load(path.read_text(encoding="utf-8"))
        if "device" in raw:
            assert unlikely_units(config.load(path)) == [], path
