"""What a campaign varies: values, points, names of dimensions."""

import json

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vsb.study import vary
from vsb.study.keys import KEYS
from vsb.study.study import canonical
from vsb.study.vary import _VARIED_IN, VARIED, Vary, read_vary, unit

TAKEN = ("damping", "hs")


def test_a_product_has_the_last_key_vary_fastest():
    vary = read_vary({"device.mass": [1.0, 2.0], "modes.basis": ["membrane", "full"]})
    assert vary.shape == (2, 2)
    assert vary.points[:2] == [
        {"device.mass": 1.0, "modes.basis": "membrane"},
        {"device.mass": 1.0, "modes.basis": "full"},
    ]


def test_the_order_of_keys_survives_canonical_json():
    """Which sorts mappings: a map over two keys was drawn with its points in the order of the other."""
    vary = read_vary({"device.young_modulus": [1.0, 2.0], "device.mass": [3.0, 4.0, 5.0]})
    assert Vary.model_validate(json.loads(canonical(vary))) == vary
    assert Vary.model_validate(json.loads(canonical(vary))).points == vary.points


def test_pairs_go_together():
    vary = read_vary({"device.mass": [1.0, 2.0], "device.radius": [3.0, 4.0], "pairs": True})
    assert vary.points == [{"device.mass": 1.0, "device.radius": 3.0}, {"device.mass": 2.0, "device.radius": 4.0}]
    assert vary.shape == (2,)


def test_a_sweep_given_in_python_may_be_tuples():
    as_lists = {
        "device.mass": [1.0, 2.0],
        "device.radius": {"log": [1.0, 4.0, 3]},
        "device.draft": {"linear": [1, 2, 2]},
    }
    as_tuples = {
        "device.mass": (1.0, 2.0),
        "device.radius": {"log": (1.0, 4.0, 3)},
        "device.draft": {"linear": (1, 2, 2)},
    }
    assert read_vary(as_tuples) == read_vary(as_lists)
    assert read_vary(as_lists).values["device.radius"] == (1.0, 2.0, 4.0)
    assert read_vary(read_vary(as_lists)) == read_vary(as_lists)


def test_nothing_varied_is_one_point():
    assert Vary().points == [{}]
    assert Vary().shape == ()


def test_numbers_as_yaml_does_not_know_them():
    assert read_vary({"device.young_modulus": ["1.0e6", "1e7"]}).values["device.young_modulus"] == (1e6, 1e7)


@pytest.mark.parametrize(
    ("narrow", "wide"),
    [
        ({"log": [1e6, 1e9, 7]}, {"log": [1e5, 1e10, 11]}),
        ({"linear": [0.1, 0.4, 4]}, {"linear": [0.1, 0.7, 7]}),
    ],
)
def test_a_widened_sweep_holds_the_values_it_had(narrow, wide):
    before, after = (read_vary({"device.thickness": each}).values["device.thickness"] for each in (narrow, wide))
    assert set(before) <= set(after)


@given(st.integers(1, 50), st.integers(0, 9))
def test_a_latin_hypercube_has_one_value_in_every_stratum(samples, seed):
    keys = {"device.radius": {"linear": [1.0, 3.0]}, "device.mass": {"linear": [10.0, 20.0]}}
    vary = read_vary({**keys, "latin_hypercube": {"samples": samples, "seed": seed}})
    assert vary.together
    for low, high, key in ((1.0, 3.0, "device.radius"), (10.0, 20.0, "device.mass")):
        strata = [int((value - low) / (high - low) * samples) for value in vary.values[key]]
        assert sorted(strata) == list(range(samples))
    again = read_vary({**keys, "latin_hypercube": {"samples": samples, "seed": seed}})
    other = read_vary({**keys, "latin_hypercube": {"samples": samples, "seed": seed + 1}})
    assert again == vary != other


def test_a_latin_hypercube_draws_every_key_on_its_own_by_seed_one_if_none_is_given():
    ends = {"linear": [1.0, 3.0]}
    keys = {"device.radius": ends, "device.mass": ends}
    vary = read_vary({**keys, "latin_hypercube": {"samples": 20}})
    assert vary == read_vary({**keys, "latin_hypercube": {"samples": 20, "seed": 1}})
    strata = [[int(10 * (value - 1.0)) for value in values] for values in vary.lists]
    assert strata[0] != strata[1]
    assert [sorted(order) for order in strata] == [list(range(20))] * 2


@pytest.mark.parametrize(
    ("spaced", "values"),
    [({"linear": [-1, 1, 3]}, (-1.0, 0.0, 1.0)), ({"linear": [3, 0, 4]}, (3.0, 2.0, 1.0, 0.0)),
     ({"linear": [5, 9, 1]}, (5.0,)), ({"log": [8, 1, 4]}, (8.0, 4.0, 2.0, 1.0)), ({"log": [5, 9, 1]}, (5.0,))],
)  # fmt: skip
def test_values_spaced_evenly_go_from_the_first_to_the_last(spaced, values):
    assert read_vary({"pto.stiffness": spaced}).lists == (values,)


@pytest.mark.parametrize(
    "key",
    ["scale", "reference_shape", "device.mass", "device.damping.beta", "device.shape.spheroid.height", "modes.basis",
     "designs.soft.flexible", "water.depth", "hydro.tolerance", "pto.damping.soft", "pto.port.colatitude"],
)  # fmt: skip
def test_keys_of_any_depth_can_be_varied(key):
    assert read_vary({key: [1.0, 2.0]}).values == {key: (1.0, 2.0)}


def test_the_points_of_a_product_are_counted_those_of_pairs_are_one_list():
    spaced = {n: {"linear": [1, 2, n]} for n in (25, 400)}
    most = read_vary({"device.mass": spaced[25], "device.radius": spaced[400]})
    assert most.shape == (25, 400)
    assert read_vary({"device.mass": spaced[400], "device.radius": spaced[400], "pairs": True}).shape == (400,)


def test_dimensions_are_the_last_words_but_where_they_clash():
    keys = ("device.mass", "pto.damping", "device.damping.beta", "hydro.tolerance", "simulation.tolerance", "scale")
    names = Vary.of(dict.fromkeys(keys, (1.0,))).dimensions(TAKEN)
    assert list(names.values()) == ["mass", "pto_damping", "beta", "hydro_tolerance", "simulation_tolerance", "scale"]


def test_a_design_of_the_name_of_the_members_dimension_has_its_damper_under_all_of_its_key():
    assert Vary.of({"pto.damping.member": (1.0, 2.0)}).dimensions(()) == {"pto.damping.member": "pto_damping_member"}


@pytest.mark.parametrize(
    ("raw", "message"),
    [
        ([1], r"received \[1\], needs keys of the study"),
        (
            {"waves.0.hs": [1.0]},
            "waves.0.hs: needs scale, reference_shape, or a key of device, modes, designs, water, hydro, pto such as",
        ),
        ({"reference_shape.x": [1.0]}, "reference_shape.x: needs scale, reference_shape, or a key of device, modes"),
        ({"device": [1.0]}, "device: needs scale"),
        ({"device.mass": 5.0}, r"device.mass: received 5.0, needs a list of values, \{log"),
        ({"device.mass": []}, r"device.mass: received \[\], needs a list"),
        ({"device.mass": {"cubic": [1, 2, 3]}}, "device.mass: received .*cubic.*, needs a list"),
        ({"device.mass": {"log": [1, 2]}}, r"device.mass: received .*, needs \{log: \[first, last, count\]\}"),
        ({"device.mass": {"log": [1, 2, 2.5]}}, r"needs \{log: \[first, last, count\]\}"),
        ({"device.mass": {"log": [0, 2, 3]}}, "needs ends above 0"),
        ({"device.mass": {"log": [2, 0, 3]}}, "needs ends above 0"),
        ({"device.mass": {"log": [-2, -1, 3]}}, "needs ends above 0"),
        ({"device.mass": {"log": [1, 2, -3]}}, r"needs \{log: \[first, last, count\]\}"),
        ({"device.mass": {"linear": [1, 2, 0]}}, r"needs \{linear: \[first, last, count\]\}"),
        ({"device.mass": {"log": [1, "much", 3]}}, "needs finite numbers"),
        ({"device.mass": {"log": [1, float("inf"), 3]}}, r"^device.mass: received .*inf.*, needs finite numbers$"),
        ({"device.mass": {"linear": [float("-inf"), 1, 3]}}, r"^device.mass: received .*-inf.*, needs finite numbers$"),
        ({"device.mass": {"linear": [1, float("-inf"), 3]}}, r"^device.mass: received .*-inf.*, needs finite numbers$"),
        ({"device.mass": {}}, r"^device.mass: received {}, needs a list of values"),
        ({"device.mass": {"log": [1, 2, 3], "linear": [1, 2, 3]}}, r"^device.mass: received .*needs a list of values"),
        ({"device.mass": {"log": "12"}}, r"^device.mass: received {'log': '12'}, needs a list of values"),
        ({"device.mass": {"log": [1]}}, r"^device.mass: received {'log': \[1\]}, needs a list of values"),
        ({"device.mass": {"log": [1, 2, 3, 4]}}, r"^device.mass: received .*4\]}, needs a list of values"),
        ({"device.mass": [1.0, True]}, "device.mass: received True, needs numbers or words"),
        ({"device.mass": [1.0, False]}, "device.mass: received False, needs numbers or words"),
        ({"device.mass": {"linear": [False, 1, 3]}}, "device.mass: received False, needs numbers or words"),
        ({"pairs": True}, "^pairs: received {} values, needs as many of every key$"),
        ({"device.mass": [float("nan")]}, "device.mass: received nan, needs numbers or words"),
        ({"device.mass": [10**400]}, "number of too many digits"),
        ({"device.mass": [1.0, 1]}, r"device.mass: received \[1.0, 1.0\], needs every value once"),
        ({"device.mass": [1.0, *range(1, 60)]}, r"device.mass: received \[1.0, 1.0, 2.0, [0-9., ]{64}\.\.\., needs every value once"),
        ({"device.mass": [1.0, "x"]}, "needs numbers, or words"),
        ({"device.mass": [1.0, "x", 2.0]}, r'device.mass: received \[1.0, "x", 2.0\], needs numbers, or words$'),
        ({"device.mass": [*range(1, 15), 1]}, r"received \[1.0, [0-9., ]{70}1.0\]\.\.\., needs every value once$"),
        ({"device.mass": [*range(1, 14), 1, 5]}, r"received \[1.0, [0-9., ]{64}1.0, 5.0\], needs every value once$"),
        ({"device.mass": [1, 2], "device.radius": [1], "pairs": True}, "pairs: received .*needs as many of every key"),
        ({"device.mass": [1], "pairs": "yes"}, "pairs: received 'yes', needs true or false"),
        ({"device.mass": {"linear": [1, 2, 100001]}}, "needs {linear"),
        ({k: {"linear": [1, 2, 400]} for k in ("device.mass", "device.radius")}, "received 160000 points, needs at"),
        ({"device.mass": [1], "latin_hypercube": {"samples": 3}}, r"device.mass: received \[1\], needs \{log"),
        ({"device.mass": {"log": [1, 2]}, "latin_hypercube": {"samples": 0}}, "latin_hypercube: received"),
        ({"device.mass": {"log": [1, 2]}, "latin_hypercube": {"samples": 3, "sede": 1}}, "latin_hypercube: received"),
        ({"device.mass": {"log": [1, 2]}, "latin_hypercube": {"samples": 3}, "pairs": True}, "and no pairs"),
        ({"device.mass": {"log": [1, 2]}, "latin_hypercube": {"samples": 100001}}, "^latin_hypercube: received"),
        ({"device.mass": {"log": [1, 2]}, "latin_hypercube": {"samples": 2.0}}, "^latin_hypercube: received"),
        ({"device.mass": {"log": [1, 2]}, "latin_hypercube": {"samples": True}}, "^latin_hypercube: received"),
        ({"device.mass": {"log": [1, 2]}, "latin_hypercube": {"samples": 3, "seed": "x"}}, "^latin_hypercube: rec"),
        ({"device.mass": {"log": [1, 2]}, "latin_hypercube": 3}, "^latin_hypercube: received 3, needs {samples: n"),
        ({"latin_hypercube": {"samples": 3}}, "^latin_hypercube: received {'samples': 3}, needs .* beside keys with"),
    ],
)  # fmt: skip
def test_mistakes_are_told_in_one_line(raw, message):
    with pytest.raises(ValueError, match=message) as caught:
        read_vary(raw)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("key", "force", "pressure", "moment"),
    [("pto.force_limit", "N", "Pa", "N m"), ("pto.stroke_limit", "m", "m^3", "rad"),
     ("pto.damping", "N s/m", "Pa s/m^3", "N m s"), ("pto.stiffness", "N/m", "Pa/m^3", "N m"),
     ("device.radius", "m", "m", "m"), ("pto.efficiency", "1", "1", "1")]
)  # fmt: skip
def test_units_of_a_take_off_are_those_of_its_port(key, force, pressure, moment):
    assert (unit(key), unit(key, "volume"), unit(key, "pitch")) == (force, pressure, moment)


def test_the_damper_of_one_design_has_the_unit_of_a_damper():
    """Whatever the design is called; structural damping keeps its own."""
    for name in ("VSWEC", "mass", "beta"):
        assert [unit(f"pto.damping.{name}", port) for port in ("", "volume", "pitch")] == ["N s/m", "Pa s/m^3", "N m s"]
    assert unit("device.damping.beta", "pitch") == "s"


@pytest.mark.parametrize(
    ("key", "expected"),
    [
        ("device.radius", "m"), ("device.thickness", "m"), ("device.young_modulus", "Pa"), ("device.mass", "kg"),
        ("device.density", "kg/m^3"), ("device.draft", "m"), ("device.centre_of_mass", "m"),
        ("device.internal_pressure", "Pa"), ("device.ballast_inertia", "kg m^2"), ("device.damping.alpha", "1/s"),
        ("device.damping.beta", "s"), ("device.shape.spheroid.height", "m"), ("device.shape.capsule.length", "m"),
        ("device.gas.atmospheric_pressure", "Pa"), ("device.gas.adiabatic_index", "1"), ("device.poisson_ratio", "1"),
        ("designs.VSWEC.clamp", "degrees"), ("water.depth", "m"), ("water.gravity", "m/s^2"),
        ("hydro.omega_max", "rad/s"), ("hydro.pressure", "Pa"), ("hydro.tolerance", "1"), ("modes.degree", "1"),
        ("pto.damping", "N s/m"), ("pto.stiffness", "N/m"), ("pto.force_limit", "N"), ("pto.stroke_limit", "m"),
        ("pto.efficiency", "1"), ("scale", "1"), ("pto.port.colatitude", "degrees"), ("pto.port.line_to", "m"),
    ],
)  # fmt: skip
def test_units_of_what_is_varied(key, expected):
    assert unit(key) == expected


def test_no_two_keys_that_may_be_varied_have_one_name_and_two_units():
    """A unit is found by the last word of a key."""
    for section in _VARIED_IN:
        for name, key in KEYS[section].items():
            assert key.unit in ("", "-", unit(name)), (section, name)


SPACES = {"device.mass": {"log": [1, 2]}, "device.radius": {"linear": [-1, 2.5]}}


@pytest.mark.parametrize(
    ("raw", "valid"),
    [
        ({}, True), ({"pairs": False}, True), ({"device.mass": [1, 2.5], "modes.basis": ["full"], "pairs": True}, False),
        ({"device.mass": [1, 2.5], "modes.basis": ["full", "paper"], "pairs": True}, True),
        ({"device.mass": {"log": [1, 2, 3]}, "device.radius": {"linear": [1, 2, 3]}}, True),
        ({**SPACES, "latin_hypercube": {"samples": 1}}, True), ({**SPACES, "latin_hypercube": {"samples": 3, "seed": 0}}, True),
        ({**SPACES, "latin_hypercube": {"samples": 0}}, False), ({**SPACES, "latin_hypercube": {"seed": 1}}, False),
        ({**SPACES, "latin_hypercube": {"samples": 2.5}}, False), ({**SPACES, "latin_hypercube": {"samples": 2, "of": 1}}, False),
        ({"pairs": "yes"}, False), ({"device.mass": 3}, False), ({"device.mass": {"cubic": [1, 2, 3]}}, False),
        ({"device.mass": {"log": [1]}}, False), ({"device.mass": {"log": [1, 2, 3, 4]}}, False), ({"device.mass": [[1]]}, False),
        ([], False),
    ],
    ids=str,
)  # fmt: skip
def test_what_is_varied_is_taken_by_an_editor_as_it_is_read(raw, valid):
    """But for what a schema cannot say: as many values of every key."""
    known = jsonschema.Draft202012Validator(VARIED).is_valid(raw)
    assert known is (valid or raw == {"device.mass": [1, 2.5], "modes.basis": ["full"], "pairs": True})
    if valid:
        assert read_vary(raw).keys == tuple(key for key in raw if "." in key)
    else:
        with pytest.raises(ValueError, match="received"):
            read_vary(raw)


def test_there_may_be_as_many_points_of_any_kind_as_at_most(monkeypatch):
    """Of a list spaced evenly, of a product and of a hypercube; one more is refused."""
    monkeypatch.setattr(vary, "MOST_POINTS", 6)
    ends = {"device.mass": {"log": [1, 2]}}
    for count, enough in ((6, True), (7, False)):
        for raw in (
            {"device.mass": {"linear": [1, 2, count]}},
            {**ends, "latin_hypercube": {"samples": count}},
            {"device.mass": [1.0 * i for i in range(count)], "device.radius": [1.0]},
        ):
            if enough:
                assert len(read_vary(raw).points) == count
            else:
                with pytest.raises(ValueError, match="received"):
                    read_vary(raw)
