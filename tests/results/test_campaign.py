"""Members of a campaign together: their order, one damper or many, what a cell of the table says of what is missing."""

import csv
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from stages.test_campaign import made_up
from stages.test_members import planned, with_seas

from vsb.results.campaign import (
    GAIN,
    OF_OPTIMA,
    POWER,
    _cell,
    _port,
    _told,
    _unfolded,
    _values,
    as_csv,
    damper,
    gathered,
    stacked,
    with_verification,
)
from vsb.study.campaign_plan import members
from vsb.study.vary import MEMBER, Vary
from vsb.study.year_options import CONSTRAINED
from vsb.tools.units import described


@pytest.fixture
def held(tmp_path):
    """A plan of two moduli and its members."""
    plan = planned(with_seas(tmp_path, (1.0, 6.0)), {"device.young_modulus": [3e6, 1e6]})
    (spec,) = plan.batches.values()
    return plan, members(spec.base, spec.points, spec.climate, spec.tuning)


def test_batches_in_any_order_make_the_same_campaign(held):
    """Members stand by their ids, not by when they were done."""
    plan, found = held
    parts = [stacked([made_up(one)], [one.id]) for one in found]
    one, other = (gathered(plan.campaign, some) for some in (parts, parts[::-1]))
    xr.testing.assert_identical(one, other)
    assert one.young_modulus.values.tolist() == [3e6, 1e6]
    assert one.young_modulus.attrs == {"units": "Pa", "long_name": "device.young_modulus"}
    assert one.attrs["reference"] == "FSB"


def test_a_tuning_has_one_damper_if_all_its_seas_have_it():
    """Bins without a sea say nothing; dampers apart by less than 1e-9 are one."""
    dampers = [[[1.0, 7.0, np.nan]], [[2.0, 2.0 + 1e-10, 9.0]], [[3.0, 4.0, 9.0]]]
    ds = xr.Dataset({"damping": (("tuning", "hs", "te"), dampers), "count": (("hs", "te"), [[1, 1, 0]])})
    ds = ds.assign_coords(tuning=["each", "one", "fixed"])
    np.testing.assert_array_equal(damper(ds), [np.nan, 2.0 + 1e-10, np.nan])
    np.testing.assert_array_equal(damper(ds.assign_coords(tuning=["each", CONSTRAINED, "fixed"])), 3 * [np.nan])


def test_what_is_missing_is_an_empty_cell_and_truth_a_word(held):
    plan, found = held
    lost = made_up(found[1]).assign(
        viable=("design", [True, False]), reason=("design", np.array(["", "buckles"], dtype=object))
    )
    lost["annual_mean_power"] = lost.annual_mean_power.where(lost.viable)
    ds = gathered(plan.campaign, [stacked([made_up(found[0]), lost], [one.id for one in found])])
    rows = list(csv.DictReader(as_csv(plan.campaign, ds).splitlines()))
    missing = [row for row in rows if row["annual_mean_power"] == ""]
    assert {(row["device.young_modulus"], row["design"], row["viable"], row["reason"]) for row in missing} == {
        ("1000000", "VSWEC", "false", "buckles")
    }
    assert [row["tuning"] for row in missing] == ["fixed", "one", "each"]
    assert len(rows) == 12


@pytest.mark.parametrize(
    ("port", "unit"),
    [
        ("heave", "N s/m"), ("volume", "Pa s/m^3"), ("pitch", "N m s"), ({"dofs": {"Pitch": 1.0}}, "N m s"),
        ({"dofs": {"Pitch": 1.0, "Heave": 1.0}}, "N s/m"), ({"between": [0.0, 90.0]}, "N s/m"),
    ],
    ids=str,
)  # fmt: skip
def test_dampers_of_a_campaign_have_the_unit_of_its_port(held, port, unit):
    """Force, pressure or moment over what the take-off moves at."""
    plan, found = held
    base = plan.campaign.base | {"pto": plan.campaign.base["pto"] | {"port": port}}
    spec = plan.campaign.model_copy(update={"base": base})
    ds = described(gathered(spec, [stacked([made_up(one)], [one.id]) for one in found]))
    assert ds.damping.attrs["units"] == unit


@pytest.mark.parametrize(("port", "unit"), [("heave", "N s/m"), ("volume", "Pa s/m^3"), ("pitch", "N m s")])
@pytest.mark.parametrize("together", [False, True])
def test_dampers_that_are_varied_have_the_unit_of_the_port_too(tmp_path, port, unit, together):
    """Beside another key, which has its own."""
    varied = {"device.young_modulus": [3e6, 1e6], "pto.damping": [1e3, 2e3]}
    plan = planned(with_seas(tmp_path, (1.0, 6.0)), varied)
    (spec,) = plan.batches.values()
    base = plan.campaign.base | {"pto": plan.campaign.base["pto"] | {"port": port}}
    whole, vary = plan.campaign, plan.campaign.vary
    found = members(spec.base, spec.points, spec.climate, spec.tuning)
    assert [list(values) for values in vary.values.values()] == [[3e6, 1e6], [1e3, 2e3]]
    if together:
        ids = [whole.members[0], whole.members[-1]]
        found = [one for one in found if one.id in ids]
        whole = whole.model_copy(update={"vary": Vary.of(vary.values, together=True), "members": tuple(ids)})
    parts = [stacked([made_up(one)], [one.id]) for one in found]
    ds = gathered(whole.model_copy(update={"base": base}), parts)
    assert ds.pto_damping.attrs == {"units": unit, "long_name": "pto.damping"}
    assert ds.young_modulus.attrs["units"] == "Pa"
    assert ds.pto_damping.dims == (("member",) if together else ("pto_damping",))
    assert described(ds).pto_damping.attrs["units"] == unit


@pytest.fixture
def swept(tmp_path):
    """A plan of two moduli by three thicknesses and its members, with gains."""
    varied = {"device.young_modulus": [3e6, 1e6], "device.thickness": [0.01, 0.02, 0.04]}
    plan = planned(with_seas(tmp_path, (1.0, 6.0)), varied)
    (spec,) = plan.batches.values()
    found = members(spec.base, spec.points, spec.climate, spec.tuning)
    parts = []
    for one in found:
        ds = made_up(one)
        gain = 1e-4 * ds.annual_mean_power
        parts.append(ds.assign(gain_percent=gain, gain_low=gain - 1.0, gain_high=gain + 2.0))
    ordered = sorted(found, key=lambda one: list(plan.campaign.members).index(one.id))
    return plan, ordered, gathered(plan.campaign, [stacked(parts, [one.id for one in found])])


def runs_of(found, names):
    """What runs in time say of each member: a number that tells which, of each design and each name."""
    return [
        xr.Dataset({name: ("design", 1000.0 * i + 100.0 * k + np.arange(2.0)) for k, name in enumerate(names)})
        .assign_coords(design=["FSB", "VSWEC"])
        .assign_attrs(runs=f"runs of {i}", model="body_exact")
        for i, _ in enumerate(found)
    ]


def test_what_runs_say_stands_at_the_point_and_under_the_tuning_they_are_of(swept):
    """Of two keys; gains of linear theory and their intervals stay what they are, and widen those of runs."""
    beyond = {"body_exact_gain_low": -1.0, "body_exact_gain_high": 2.0}
    plan, found, ds = swept
    told = with_verification(plan.campaign, ds, runs_of(found, (*POWER, *GAIN)))
    ours = ["body_exact_mean_power", "body_exact_power_low", "body_exact_power_high"]
    ours += ["body_exact_gain_percent", "body_exact_gain_low", "body_exact_gain_high"]
    order = {one.id: i for i, one in enumerate(found)}
    for one in found:
        point = {"young_modulus": one.point["device.young_modulus"], "thickness": one.point["device.thickness"]}
        at, before, i = told.sel(point), ds.sel(point), order[one.id]
        for k, name in enumerate(ours):
            said = 1000.0 * i + 100.0 * k + beyond.get(name, 0.0)
            assert at[name].values == pytest.approx([said, said + 1.0], abs=1e-9)
        for name in ("gain_percent", "gain_low", "gain_high"):
            np.testing.assert_array_equal(at[name], before[name])
    assert not {*POWER, *GAIN} & {*told.data_vars}
    assert {key: told.attrs[key] for key in ("verified_tuning", "verified_model", "verification")} == {
        "verified_tuning": "one",
        "verified_model": "body_exact",
        "verification": "tuning one: runs of 0",
    }
    assert told.attrs["campaign"] == ds.attrs["campaign"]
    rows = list(csv.DictReader(as_csv(plan.campaign, told).splitlines()))
    for name in ours:
        assert {row["tuning"] for row in rows if row[name]} == {"one"}
        assert len([row for row in rows if row[name]]) == 12


def test_without_a_reference_runs_say_nothing_of_gains_and_without_runs_there_is_nothing_to_say(swept):
    plan, found, ds = swept
    bare = ds.drop_vars(["gain_percent", "gain_low", "gain_high"])
    told = with_verification(plan.campaign, bare, runs_of(found, POWER))
    assert told.attrs["verification"] == "tuning one: runs of 0"
    assert {"body_exact_mean_power", "body_exact_power_low", "body_exact_power_high"} <= {*told.data_vars}
    assert not [name for name in told.data_vars if "gain" in name]
    assert with_verification(plan.campaign, ds, []) is ds


def test_what_optima_alone_have_stands_in_their_rows(swept):
    """Of the tuning constrained; a damper in those of the others that have one."""
    plan, _, ds = swept
    some = ds.assign_coords(tuning=["fixed", "one", CONSTRAINED])
    whole = some.assign({name: some.margin + 0.0 * some.design.str.len() + k for k, name in enumerate(OF_OPTIMA)})
    rows = list(csv.DictReader(as_csv(plan.campaign, whole).splitlines()))
    for row in rows:
        optimum = row["tuning"] == CONSTRAINED
        assert [row[name] for name in OF_OPTIMA] == (["0.5", "1.5"] if optimum else ["", ""])
        assert (row["damping"] == "") == optimum


def test_a_campaign_without_a_rigid_design_names_no_reference(held):
    plan, found = held
    designs = {name: {**design, "flexible": True} for name, design in plan.campaign.base["designs"].items()}
    spec = plan.campaign.model_copy(update={"base": plan.campaign.base | {"designs": designs}})
    assert gathered(spec, [stacked([made_up(one)], [one.id]) for one in found]).attrs["reference"] == ""


@pytest.mark.parametrize(
    ("ports", "base", "named"),
    [
        (None, "volume", "volume"), (None, "pitch", "pitch"), (None, "heave", ""), (None, None, ""),
        (["volume", "heave"], "volume", ""), (["pitch", "heave"], "pitch", ""), (["heave", "heave"], "volume", ""),
        (["volume"], "heave", "volume"), (["pitch", "pitch"], "heave", "pitch"), (["volume", "pitch"], "pitch", ""),
    ],
)  # fmt: skip
def test_units_are_those_of_a_port_only_where_all_members_have_it(ports, base, named):
    """What is varied goes before what the study says."""
    vary = Vary.of({"device.thickness": [0.01], **({"pto.port": ports} if ports else {})})
    designs = {"soft": {"flexible": True}, "first": {"flexible": False}, "other": {"flexible": False}}
    spec = SimpleNamespace(
        vary=vary,
        base={"pto": {"port": base} if base else {}, "designs": designs},
        campaign="c",
        study="s",
        climate_name="n",
    )
    assert _port(spec) == named
    told = {"campaign": "c", "study": "s", "climate": "n", "reference": "first", "Conventions": "CF-1.8"}
    assert _told(spec) == told | ({"port": named} if named else {})


def test_points_that_are_no_product_stay_side_by_side_and_a_single_one_needs_no_dimension():
    values = np.arange(12.0).reshape(2, 6)
    ds = xr.Dataset({"power": (("design", MEMBER), values), "count": ("hs", [1, 2])})
    keys = {"device.thickness": [1.0, 2.0], "device.mass": [1.0, 2.0, 3.0]}
    product = _unfolded(ds, Vary.of(keys), ["thickness", "mass"])
    assert product.power.dims == ("thickness", "mass", "design")
    np.testing.assert_array_equal(product.power, values.T.reshape(2, 3, 2))
    assert product["count"].dims == ("hs",)
    pairs = {name: [1.0] * 6 for name in keys}
    assert _unfolded(ds, Vary.of(pairs, together=True), ["thickness", "mass"]).identical(ds)
    for together in (False, True):
        one = _unfolded(ds.isel(member=[4]), Vary.of({}, together=together), [])
        assert one.power.dims == ("design",)
        assert one.power.values.tolist() == [4.0, 10.0]


def test_a_damper_is_one_by_its_own_size_and_a_cell_has_twelve_digits():
    dampers = [[[1e6, 1e6 + 1e-4]], [[1e6, 1e6 + 1e-2]], [[0.0, 0.0]]]
    ds = xr.Dataset({"damping": (("tuning", "hs", "te"), dampers), "count": (("hs", "te"), [[1, 1]])})
    ds = ds.assign_coords(tuning=["one", "each", "fixed"])
    np.testing.assert_array_equal(damper(ds), [1e6 + 1e-4, np.nan, 0.0])
    cells = [_cell(value) for value in (1 / 3, -0.5, np.nan, True, np.bool_(False), "full", 7)]
    assert cells == ["0.333333333333", "-0.5", "", "true", "false", "full", 7]


def test_values_of_a_key_are_numbers_or_words_as_they_are_given():
    numbers, words = _values((1, 2.5)), _values(("full", "paper"))
    assert (numbers.dtype, words.dtype) == (np.dtype(float), np.dtype(object))
    assert (numbers.tolist(), words.tolist()) == ([1.0, 2.5], ["full", "paper"])


def test_values_that_are_varied_together_stand_beside_the_members_they_are_of(tmp_path):
    """Two moduli each with its own thickness: no grid, and a row for each of the two."""
    varied = {"pairs": True, "device.young_modulus": [3e6, 1e6], "device.thickness": [0.02, 0.01]}
    plan = planned(with_seas(tmp_path, (1.0, 6.0)), varied)
    (spec,) = plan.batches.values()
    found = members(spec.base, spec.points, spec.climate, spec.tuning)
    power = {1e6: 5.0, 3e6: 7.0}
    parts = [
        stacked(
            [one.assign(annual_mean_power=power[each.point["device.young_modulus"]] + 0 * one.annual_mean_power)],
            [each.id],
        )
        for each in found
        for one in [made_up(each)]
    ]
    ds = gathered(plan.campaign, parts)
    assert ds.attrs["varied"] == "young_modulus thickness"
    assert ds.annual_mean_power.dims[0] == MEMBER
    for name, values in (("young_modulus", [3e6, 1e6]), ("thickness", [0.02, 0.01])):
        assert (ds[name].dims, ds[name].values.tolist()) == ((MEMBER,), values)
    assert ds.annual_mean_power.isel(design=0, tuning=0).values.tolist() == [7.0, 5.0]
    rows = list(csv.DictReader(as_csv(plan.campaign, ds).splitlines()))
    told = {(row["device.young_modulus"], row["device.thickness"], row["annual_mean_power"]) for row in rows}
    assert told == {("3000000", "0.02", "7"), ("1000000", "0.01", "5")}
    assert len(rows) == 12


def test_every_row_of_the_table_tells_the_values_of_its_own_point_design_and_tuning(swept):
    """Two keys, two designs, three tunings: a number of each that no other has, whatever the order of dimensions."""
    plan, _, ds = swept
    point = ds.young_modulus / 1e6 + 1e3 * ds.thickness
    design = xr.DataArray(1000.0 * (1 + np.arange(ds.sizes["design"])), dims="design")
    tuning = xr.DataArray(1e5 * (1 + np.arange(ds.sizes["tuning"])), dims="tuning")
    told = ds.assign(annual_mean_power=(tuning + design + point), margin=point)
    rows = list(csv.DictReader(as_csv(plan.campaign, told).splitlines()))
    assert len(rows) == 2 * 3 * 2 * 3
    order = [(p["device.young_modulus"], p["device.thickness"]) for p in plan.campaign.vary.points]
    expected = [(*p, d, t) for p in order for d in ds.design.values for t in ds.tuning.values]
    keys = ("device.young_modulus", "device.thickness", "design", "tuning")
    for row, (modulus, thickness, name, tuned) in zip(rows, expected, strict=True):
        assert [row[key] for key in keys] == [f"{modulus:.12g}", f"{thickness:.12g}", name, tuned]
        at = told.sel(young_modulus=modulus, thickness=thickness)
        assert float(row["margin"]) == pytest.approx(float(at.margin), rel=1e-11)
        assert float(row["annual_mean_power"]) == pytest.approx(
            float(at.annual_mean_power.sel(design=name, tuning=tuned)), rel=1e-11
        )
