"""What a campaign varies: values, points, dimensions, units."""

import inspect
import typing
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from vsb.engine.shell.modes import mode_basis
from vsb.keys.meanings import KEYS
from vsb.study import study as config
from vsb.study.vary import Vary, length_power, powers, read_vary, scaled, unit
from vsb.tools.variables import MOMENT, PRESSURE

TAKEN = ("damping", "hs")


def test_last_key_varies_fastest():
    vary = read_vary({"device.mass": [1.0, 2.0], "modes.basis": ["membrane", "full"]})
    assert vary.shape == (2, 2)
    assert vary.points[:2] == [
        {"device.mass": 1.0, "modes.basis": "membrane"},
        {"device.mass": 1.0, "modes.basis": "full"},
    ]


@pytest.mark.parametrize(
    ("narrow", "wide"),
    [({"log": [1e6, 1e9, 7]}, {"log": [1e5, 1e10, 11]}), ({"linear": [0.1, 0.4, 4]}, {"linear": [0.1, 0.7, 7]})],
)
def test_widened_sweep_holds_the_narrow_one(narrow, wide):
    before, after = (read_vary({"device.thickness": each}).values["device.thickness"] for each in (narrow, wide))
    assert set(before) <= set(after)


@given(st.integers(1, 50), st.integers(0, 9))
def test_latin_hypercube_has_one_value_in_every_stratum(samples, seed):
    keys = {"device.radius": {"linear": [1.0, 3.0]}, "device.mass": {"linear": [10.0, 20.0]}}
    vary = read_vary({**keys, "latin_hypercube": {"samples": samples, "seed": seed}})
    assert vary.together
    for low, high, key in ((1.0, 3.0, "device.radius"), (10.0, 20.0, "device.mass")):
        strata = [int((value - low) / (high - low) * samples) for value in vary.values[key]]
        assert sorted(strata) == list(range(samples))
    again = read_vary({**keys, "latin_hypercube": {"samples": samples, "seed": seed}})
    other = read_vary({**keys, "latin_hypercube": {"samples": samples, "seed": seed + 1}})
    assert again == vary != other


@pytest.mark.parametrize(
    ("spaced", "values"),
    [({"linear": [-1, 1, 3]}, (-1.0, 0.0, 1.0)), ({"linear": [3, 0, 4]}, (3.0, 2.0, 1.0, 0.0)),
     ({"linear": [5, 9, 1]}, (5.0,)), ({"log": [8, 1, 4]}, (8.0, 4.0, 2.0, 1.0)), ({"log": [5, 9, 1]}, (5.0,))],
)  # fmt: skip
def test_evenly_spaced_values(spaced, values):
    assert read_vary({"pto.stiffness": spaced}).lists == (values,)


def test_dimensions_are_the_last_words_unless_they_clash():
    keys = ("device.mass", "pto.damping", "device.damping.beta", "hydro.tolerance", "simulation.tolerance", "scale")
    names = Vary.of(dict.fromkeys(keys, (1.0,))).dimensions(TAKEN)
    assert list(names.values()) == ["mass", "pto_damping", "beta", "hydro_tolerance", "simulation_tolerance", "scale"]


@pytest.mark.parametrize(
    ("raw", "message"),
    [([1], r"received \[1\], needs keys of the study"),
        ({"waves.0.hs": [1.0]}, "waves.0.hs: needs scale, reference_shape, or a key of device, body, modes, designs, water,"),
        ({"device.mass": 5.0}, r"device.mass: received 5.0, needs a list of values, \{log"),
        ({"device.mass": {"log": [1, 2]}}, r"device.mass: received .*, needs \{log: \[first, last, count\]\}"),
        ({"device.mass": {"log": [0, 2, 3]}}, "needs ends above 0"),
        ({"device.mass": {"log": [1, "much", 3]}}, "needs finite numbers"),
        ({"device.mass": {"log": [1, float("inf"), 3]}}, r"^device.mass: received .*inf.*, needs finite numbers$"),
        ({"device.mass": [1.0, True]}, "device.mass: received True, needs numbers or words"),
        ({"device.mass": [float("nan")]}, "device.mass: received nan, needs numbers or words"),
        ({"device.mass": [10**400]}, "number of too many digits"),
        ({"device.mass": [1.0, 1]}, r"device.mass: received \[1.0, 1.0\], needs every value once"),
        ({"device.mass": [1.0, "x"]}, "needs numbers, or words"),
        ({"device.mass": [1], "pairs": "yes"}, "pairs: received 'yes', needs true or false"),
        ({"device.mass": {"linear": [1, 2, 100001]}}, "needs {linear"),
        ({"device.mass": [1], "latin_hypercube": {"samples": 3}}, r"device.mass: received \[1\], needs \{log"),
        ({"device.mass": {"log": [1, 2]}, "latin_hypercube": {"samples": 0}}, "latin_hypercube: received"),
        ({"device.mass": {"log": [1, 2]}, "latin_hypercube": {"samples": 3}, "pairs": True}, "and no pairs"),
        ({"device.mass": {"log": [1, 2]}, "latin_hypercube": {"samples": 100001}}, "^latin_hypercube: received"),
        ({"latin_hypercube": {"samples": 3}}, "^latin_hypercube: received {'samples': 3}, needs .* beside keys with")],
)  # fmt: skip
def test_errors_of_varied_keys(raw, message):
    with pytest.raises(ValueError, match=message) as caught:
        read_vary(raw)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("key", "force", "pressure", "moment"),
    [("pto.force_limit", "N", "Pa", "N m"), ("pto.stroke_limit", "m", "m^3", "rad"),
     ("pto.damping", "N s/m", "Pa s/m^3", "N m s"), ("pto.stiffness", "N/m", "Pa/m^3", "N m"),
     ("device.radius", "m", "m", "m"), ("pto.efficiency", "1", "1", "1")]
)  # fmt: skip
def test_units_of_the_take_off_follow_the_port(key, force, pressure, moment):
    assert (unit(key), unit(key, PRESSURE), unit(key, MOMENT)) == (force, pressure, moment)


SEED = Path(__file__).parents[1] / "data" / "seed.yaml"


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


def test_every_number_has_a_unit_by_which_it_scales():
    """A key added later would otherwise silently not scale."""
    pure = {name for section in KEYS.values() for name, key in section.items() if key.unit == "-"}
    by_themselves = {"mooring", "atmospheric_pressure", "depth"}
    in_sections = {"profile", "parameters", "values"}  # scaled to the radius, or not at all
    assert numbers(config.BuoyStudy) - pure - powers().keys() == by_themselves | in_sections


@pytest.mark.parametrize(
    ("unit", "power"),
    [("J", 4.0), ("N m s", 4.5), ("m/s^2", 0.0), ("rad/(m s)", -1.5), ("J^0.5/s", 1.5), ("J/kg", 1.0)],
)
def test_units_scale_by_froude(unit, power):
    """Masses with lengths cubed, times with their root, so that gravity and densities stay."""
    assert length_power(unit) == power


def test_mooring_scales_by_force_and_moment_per_length_and_angle():
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
        ({"strain": "area"}, (2.0, 1.0, 16.0, 16.0)),  # N s/m^3, N/m^3, N/m, m^2
        ({"strain": "hoop", "belt": [60, 120]}, (512.0, 256.0, 256.0, 1.0)),  # N m s, N m, N m, -
    ],
)
def test_take_off_scales_with_the_units_of_its_port(port, expected):
    found = scaled({"pto": {"port": port, **TAKE_OFF}}, 4.0)["pto"]
    assert tuple(found[key] for key in TAKE_OFF) == (*expected, 1.0)


def test_parameters_of_a_package_stay():
    """Whatever they are called: only the package knows what they mean."""
    pto = {"law": "my_package:law", "parameters": {"damping": 2.0, "length": 3.0}}
    assert scaled({"pto": pto}, 4.0)["pto"] == pto


def test_energy_of_a_material_scales_at_one_port_and_at_several():
    """J/kg, as stress over density."""
    one, several = {"port": {"strain": "area"}}, {"ports": {"a": {"strain": "area"}, "b": {"strain": "hoop"}}}
    for port in (one, several):
        assert scaled({"pto": port | {"energy_per_cycle": 2.0}}, 4.0)["pto"]["energy_per_cycle"] == 8.0


def test_damper_matrix_scales_with_the_units_of_its_ports():
    """N s/m, N s/m^2 across, N s/m^3 of a change of area."""
    ports = {"heave": "heave", "shell": {"strain": "area"}}
    for pto in ({"ports": ports, "damping": [[1.0] * 2] * 2}, {"port": {"ports": ports, "damping": [[1.0] * 2] * 2}}):
        found = scaled({"pto": {**pto, "tuning": "fixed"}}, 4.0)["pto"]
        assert found == {"ports": ports, "damping": [[32.0, 8.0], [8.0, 2.0]], "tuning": "fixed"}


@pytest.mark.parametrize("scale", [0.25, 4.0])
def test_natural_frequencies_scale_with_the_root_of_length(scale):
    study = config.load(SEED)
    larger = config.parse(scaled(study.model_dump(), scale), source="larger")
    own, other = (
        np.linalg.eigvals(np.linalg.solve(basis.inertia, basis.stiffness)).real
        for basis in (mode_basis(one.device, "full", 4) for one in (study, larger))
    )
    assert np.sort(other) == pytest.approx(np.sort(own) / scale, rel=1e-9, abs=1e-6)


"""Quantities by their units; a take-off's are those of a port that moves by a length."""
"""At the same density and gravity: kg/m^3 and m/s^2 stay."""
