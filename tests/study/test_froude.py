"""Froude's scaling: the same buoy of another size, for every quantity a study can have."""

import inspect
import re
import typing
from pathlib import Path

import numpy as np
import pytest
from pydantic import BaseModel

from vsb.shell.modes import mode_basis
from vsb.study import study as config
from vsb.study.froude import FROUDE, scaled
from vsb.study.keys import KEYS

SEED = Path(__file__).parents[1] / "data" / "seed.yaml"
KEPT = {
    "poisson_ratio", "density", "adiabatic_index", "atmospheric_pressure", "degree", "clamp", "depth",
    "gravity", "power_tolerance", "tolerance", "rows", "efficiency", "colatitude", "between", "seed", "realisations",
    "gamma", "values", "coefficient", "order", "direction", "dofs", "profile",
}  # fmt: skip
"""Numbers without dimension, angles, and what stays as it is: material, water, air, figures published elsewhere;
a profile has the radius of its buoy."""


NOWHERE = {"hs", "tp", "band"}
"""Irregular seas: a campaign's are the climate's, and the study that is begun with has none."""


def numbers(model):
    """Names of all keys of a model, and of the sections below it, that may hold numbers."""
    found = set()

    def look(name, annotation):
        if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
            found.update(numbers(annotation))
        elif annotation in {int, float}:
            found.add(name)
        for part in typing.get_args(annotation):
            if not isinstance(part, str):
                look(name, part)

    for name, field in model.model_fields.items():
        look(name, field.annotation)
    return found


def test_every_number_of_a_study_scales_or_is_known_to_stay():
    """A key added later would scale in silence by nothing."""
    found = numbers(config.Study)
    assert found > {"radius", "damping", "stroke_limit"}
    assert found - set(FROUDE) == KEPT | NOWHERE | {"mooring"}


def test_a_mooring_scales_by_force_and_moment_per_length_and_angle():
    """Forces go with the cube of lengths, moments with the fourth power."""
    raw = {"mooring": [1.0] * 6}
    assert scaled(raw, 2.0) == {"mooring": [4.0] * 3 + [16.0] * 3}
    rows = scaled({"mooring": [[1.0] * 6] * 6}, 2.0)["mooring"]
    assert rows == [[4.0] * 3 + [8.0] * 3] * 3 + [[8.0] * 3 + [16.0] * 3] * 3
    assert scaled({"mooring": None}, 2.0) == {"mooring": None}


TAKE_OFF = {"damping": 1.0, "stiffness": 1.0, "force_limit": 1.0, "stroke_limit": 1.0, "efficiency": 1.0}


@pytest.mark.parametrize(
    ("port", "expected"),
    [
        ("heave", (32.0, 16.0, 64.0, 4.0)),  # N s/m, N/m, N, m
        ({"line_to": [0.0, -20.0]}, (32.0, 16.0, 64.0, 4.0)),
        ("volume", (1 / 8, 1 / 16, 4.0, 64.0)),  # Pa s/m^3, Pa/m^3, Pa, m^3
        ("pitch", (512.0, 256.0, 256.0, 1.0)),  # N m s, N m, N m, rad
    ],
)
def test_a_take_off_scales_by_what_its_port_moves_by(port, expected):
    found = scaled({"pto": {"port": port, **TAKE_OFF}}, 4.0)["pto"]
    assert tuple(found[key] for key in TAKE_OFF) == (*expected, 1.0)


def test_a_take_off_of_a_length_scales_as_the_table_says():
    found = scaled({"pto": TAKE_OFF}, 2.0)["pto"]
    assert found == {key: 2.0 ** FROUDE.get(key, 0.0) for key in TAKE_OFF}


def test_scaling_there_and_back_is_nothing():
    study = config.load(SEED).model_dump(exclude={"study"})
    twice = scaled(scaled(study, 4.0), 0.25)
    assert config.parse({"study": "seed", **twice}, source="twice").model_dump() == config.load(SEED).model_dump()


def test_dampers_by_name_and_lists_go_with_their_key():
    raw = {"pto": {"damping": {"FSB": 2.0, "VSWEC": 3.0}}, "simulation": {"window": [4.0, 8.0]}, "hydro": {"rows": 40}}
    assert scaled(raw, 4.0) == {
        "pto": {"damping": {"FSB": 64.0, "VSWEC": 96.0}}, "simulation": {"window": [8.0, 16.0]}, "hydro": {"rows": 40}
    }  # fmt: skip


@pytest.mark.parametrize("scale", [0.25, 4.0])
def test_a_scaled_shell_swings_more_slowly_by_the_root(scale):
    """Stiffness over inertia of every mode goes as gravity over length."""
    study = config.load(SEED)
    larger = config.parse(scaled(study.model_dump(), scale), source="larger")
    own, other = (
        np.linalg.eigvals(np.linalg.solve(basis.inertia, basis.stiffness)).real
        for basis in (mode_basis(one.device, "full", 4) for one in (study, larger))
    )
    assert np.sort(other) == pytest.approx(np.sort(own) / scale, rel=1e-9, abs=1e-6)


DIMENSIONS = {
    "m": "radius thickness stroke_limit amplitude initial_position lever centre_of_mass line_to line_from height length",
    "m^2": "area", "kg": "mass", "kg m^2": "ballast_inertia ballast_yaw_inertia",
    "s": "beta period duration window", "1/s": "alpha omega omega_max", "m/s": "initial_velocity",
    "kg m/s^2": "force_limit", "kg/s^2": "stiffness", "kg/s": "damping",
    "kg/m/s^2": "young_modulus internal_pressure pressure",
}  # fmt: skip
"""Quantities by their units; a take-off's are those of a port that moves by a length."""
OF_SCALE = {"m": 1.0, "kg": 3.0, "s": 0.5}
"""At the same density and gravity: kg/m^3 and m/s^2 stay."""


def power_of_scale(unit):
    """With which power of the length scale a unit goes."""
    powers, sign = 0.0, 1.0
    for part, divided in re.findall(r"([^/ ]+)([/ ]?)", unit):
        name, _, exponent = part.partition("^")
        powers += sign * OF_SCALE.get(name, 0.0) * float(exponent or 1)
        sign = -1.0 if divided == "/" else 1.0
    return powers


def test_every_quantity_scales_as_its_units_say():
    powers = {name: power_of_scale(unit) for unit, names in DIMENSIONS.items() for name in names.split()}
    assert power_of_scale("kg/m^3") == power_of_scale("m/s^2") == 0.0
    assert powers == FROUDE


def test_a_word_or_a_truth_is_no_quantity():
    assert scaled({"mass": True, "radius": "wide", "damping": None, "period": 2}, 4.0) == {
        "mass": True,
        "radius": "wide",
        "damping": None,
        "period": 4.0,
    }


UNSCALED = {"hs": "m", "tp": "s", "band": "rad/s", "depth": "m", "draft": "m", "seconds": "s", "atmospheric_pressure": "Pa",
            "mooring": "N/m, N, N m"}  # fmt: skip
"""Units of what has a dimension but no power of its own: of the sea, of the water and the air, of a mass, of a budget."""


def test_units_a_key_is_told_with_scale_as_the_key_does(monkeypatch):
    for name, power in {"N": 3.0, "Pa": 1.0}.items():
        monkeypatch.setitem(OF_SCALE, name, power)
    for section, keys in KEYS.items():
        for name, key in keys.items():
            if name in UNSCALED:
                assert key.unit == UNSCALED[name], (section, name)
            elif (section, name) == ("Device", "damping"):
                assert key.unit == ""  # a section; of a take-off it is a number
            elif name in FROUDE or key.unit not in ("", "-"):
                assert key.unit not in ("", "-"), (section, name)
                assert power_of_scale(key.unit) == FROUDE.get(name, 0.0), (section, name)
