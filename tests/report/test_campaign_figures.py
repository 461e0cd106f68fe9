"""Figures of a campaign made up by hand: whose curves are shown, where optima stand, what is hatched and crossed."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.legend import Legend

from vsb.report.campaign_answer import shown_place, told_bounds, told_gain
from vsb.report.campaign_figures import (
    DRAWN,
    _label,
    _number,
    _scale,
    _told,
    is_mapped,
    pareto,
    power_matrices,
    sweep,
    tuned_power,
)
from vsb.report.canvas import style
from vsb.report.svg import data_csv

DESIGNS, TUNINGS, BINS = ["FSB", "VSWEC"], ["fixed", "one", "each"], ("hs", "te")
GAINS = np.array([[-5.0, 2.0], [8.0, -1.0]])  # of the flexible design, (modulus, thickness) [%]
DAMPERS = np.geomspace(1e3, 1e5, 21)


def campaign(gains=GAINS, margin=0.5, modulus=(1e6, 1e8), thickness=(0.01, 0.02), **attrs):
    """Results of a campaign over two keys: the rigid design takes 10 kW, power over its damper peaks at 10 kN s/m."""
    by, points = ("design", "tuning"), ("young_modulus", "thickness")
    shape = np.shape(gains)
    gain = np.zeros((*shape, 2, 3))
    gain[..., 1, :] = np.asarray(gains)[..., None]
    power = 1e4 * (1 + gain / 100)
    curve = 1e4 / (0.5 + 0.25 * (DAMPERS / 1e4 + 1e4 / DAMPERS))
    curves = np.broadcast_to(curve, (*shape, 2, len(DAMPERS)))
    count = np.array([[3, 0], [1, 2]])
    beyond = np.zeros((*shape, 2, 3, 2, 2))
    beyond[..., 1, :, 1, 1] = 0.5
    shares = np.broadcast_to(np.array([0.1, 0.0, 0.4, 0.9])[:, None, None], (*shape, 4, 2, 3))
    data = {
        "annual_mean_power": ((*points, *by), power),
        "annual_energy": ((*points, *by), power * 8766e-6),
        "capture_width": ((*points, *by), power / 1e4),
        "force_rms": ((*points, *by), 2e3 * np.ones_like(power)),
        "gain_percent": ((*points, *by), gain),
        "gain_low": ((*points, *by), gain - 3.0),
        "gain_high": ((*points, *by), gain + 3.0),
        "practice_power": ((*points, *by), 1.12 * power),
        "damping": ((*points, *by, *BINS), np.full((*shape, 2, 3, 2, 2), 1e4)),
        "power_matrix": ((*points, *by, *BINS), power[..., None, None] * np.array([[1.0, 9.0], [0.5, 2.0]])),
        "beyond_validity": ((*points, *by, *BINS), beyond),
        "energy_beyond": ((*points, "limit", *by), shares),
        "energy_beyond_validity": ((*points, *by), np.full((*shape, 2, 3), 0.25)),
        "tried_damping": ("tried", DAMPERS),
        "power_of_damping": ((*points, "design", "tried"), curves),
        "force_of_damping": ((*points, "design", "tried"), np.broadcast_to(DAMPERS / 10, curves.shape)),
        "margin": (points, np.broadcast_to(np.asarray(margin, dtype=float), shape)),
        "viable": ((*points, "design"), np.ones((*shape, 2), dtype=bool)),
        "reason": ((*points, "design"), np.full((*shape, 2), "", dtype=object)),
        "count": (BINS, count),
    }
    coords = {
        "young_modulus": ("young_modulus", list(modulus), {"units": "Pa"}),
        "thickness": ("thickness", list(thickness), {"units": "m"}),
        "design": DESIGNS, "tuning": TUNINGS, "hs": [0.75, 1.25], "te": [5.5, 6.5],
        "limit": ["steepness", "breaking", "deformation", "heave"],
    }  # fmt: skip
    told = {"varied": "young_modulus thickness", "reference": "FSB", "climate": "a buoy", "campaign": "made_up"}
    return xr.Dataset(data, coords, {**told, "study": "seed", "spec_id": "0" * 16, **attrs})


def colour(design):
    return to_hex(style(design, DESIGNS)["color"])


def test_the_member_shown_gains_most_of_those_that_carry_their_load():
    assert shown_place(campaign(), "one", "FSB") == {"young_modulus": 1, "thickness": 0}
    buckled = campaign(margin=[[0.5, 0.5], [-0.1, 0.5]])
    assert shown_place(buckled, "one", "FSB") == {"young_modulus": 0, "thickness": 1}
    assert shown_place(campaign(margin=-1.0), "one", "FSB") == {"young_modulus": 1, "thickness": 0}
    assert shown_place(campaign(), "one", None) == {"young_modulus": 1, "thickness": 0}


def by_runs(ds, gain, width=0.5, factor=1.0, model="body_exact"):
    """A campaign whose tuning `one` is verified: gains, their half width, powers in terms of linear ones."""
    begin = {"body_exact": "body_exact", "linear": "in_time"}[model]
    gain = gain.sel(tuning="one", drop=True)
    values = {"gain_percent": gain, "gain_low": gain - width, "gain_high": gain + width}
    rigid = ds.annual_mean_power.sel(tuning="one", design="FSB", drop=True)
    values["mean_power"] = factor * rigid * (1 + gain / 100)
    attrs = {"verified_tuning": "one", "verified_model": model, "verification": "tuning one: 4 seas"}
    return ds.assign({f"{begin}_{name}": value for name, value in values.items()}).assign_attrs(attrs)


def test_gains_told_are_those_of_runs_under_the_tuning_that_was_run_each_in_its_own_interval():
    ds = by_runs(campaign(), campaign().gain_percent - 1.0)
    assert told_gain(ds, "one").equals(ds.body_exact_gain_percent)
    assert told_gain(ds, "each").equals(ds.gain_percent)
    assert [bound.name for bound in told_bounds(ds, "one")] == ["body_exact_gain_low", "body_exact_gain_high"]
    assert [bound.name for bound in told_bounds(ds, "each")] == ["gain_low", "gain_high"]


def test_curves_and_optima_over_the_damper():
    ax = tuned_power(campaign(), "one", "FSB").axes[0]
    curve, best, *_ = (line for line in ax.lines if to_hex(line.get_color()) == colour("FSB"))
    np.testing.assert_allclose(curve.get_xdata(), DAMPERS)
    assert curve.get_xdata()[np.argmax(curve.get_ydata())] == pytest.approx(best.get_xdata()[0])
    assert best.get_ydata()[0] == 10.0
    assert (ax.get_xscale(), ax.get_xlabel()) == ("log", "damper [N s/m]")


def test_power_over_force_ends_at_the_best_damper():
    ax = pareto(campaign(), "one", "FSB").axes[0]
    curve = next(line for line in ax.lines if len(line.get_xdata()) > 1)
    assert (curve.get_xdata()[-1], curve.get_ydata()[-1]) == pytest.approx((1.0, 10.0))
    assert np.all(np.diff(curve.get_ydata()) > 0)


def test_power_under_limits_stands_at_its_force_in_the_units_of_the_axes():
    ds = campaign().sel(tuning=["one", "one"]).assign_coords(tuning=["one", "constrained"])
    ax = pareto(ds, "one", "FSB").axes[0]
    point = ds.isel(shown_place(ds, "one", "FSB")).sel(tuning="constrained")
    for design in DESIGNS:
        colours = (line for line in ax.lines if line.get_marker() == "s" and to_hex(line.get_color()) == colour(design))
        (at,) = (line.get_xydata()[0] for line in colours)
        assert at == pytest.approx(
            [float(point[v].sel(design=design)) / 1e3 for v in ("force_rms", "annual_mean_power")]
        )
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("rms force of the take-off [kN]", "mean power of the year [kW]")


def test_matrices_share_a_scale_leave_out_empty_bins_and_cross_what_is_beyond():
    figure = power_matrices(campaign(), "one", "FSB")
    meshes = [ax.collections[0] for ax in figure.axes[:2]]
    assert [ax.get_title() for ax in figure.axes[:2]] == DESIGNS
    assert meshes[0].get_clim() == meshes[1].get_clim() == pytest.approx((0.0, 21.6))
    np.testing.assert_allclose(meshes[0].get_array().filled(np.nan), [[10.0, np.nan], [5.0, 20.0]])
    crosses = [ax.collections[1].get_offsets() for ax in figure.axes[:2]]
    assert len(crosses[0]) == 0
    np.testing.assert_array_equal(crosses[1], [[6.5, 1.25]])


def test_a_design_that_is_not_viable_has_no_matrix():
    ds = campaign()
    ds["viable"] = ds.viable.where(ds.design != "VSWEC", other=False)
    ax = power_matrices(ds, "one", "FSB").axes[1]
    assert [text.get_text() for text in ax.texts] == ["not viable"]
    assert not ax.collections


def test_the_map_of_gains_is_hatched_where_unsure_and_lined_where_it_buckles():
    ax = sweep(campaign(margin=[[-0.5, 0.5], [0.5, 0.5]]), "one", "FSB").axes[0]
    mesh, hatched, line = ax.collections
    np.testing.assert_allclose(mesh.get_array().reshape(2, 2), GAINS)
    assert mesh.get_clim()[0] == -mesh.get_clim()[1]
    assert hatched.get_hatch() == "////"
    assert len(line.get_paths()[0]) > 1
    assert ax.get_yscale() == "log"
    assert ax.get_xscale() == "linear"
    sure = sweep(campaign(gains=10 * np.sign(GAINS)), "one", "FSB").axes[0]
    assert len(sure.collections) == 1


def test_cells_of_a_map_stand_around_their_values_and_ticks_at_them():
    """On a logarithmic axis halfway by ratio: once the cells of small values were cut off, and zero was passed."""
    ax = sweep(campaign(), "one", "FSB").axes[0]
    edges = ax.collections[0].get_coordinates()
    np.testing.assert_allclose(edges[:, 0, 1], [1e5, 1e7, 1e9])
    np.testing.assert_allclose(edges[0, :, 0], [0.005, 0.015, 0.025])
    assert [label.get_text() for label in ax.get_yticklabels()] == ["1e6", "1e8"]
    assert [label.get_text() for label in ax.get_xticklabels()] == ["0.01", "0.02"]
    odd = sweep(campaign(modulus=(1e6, 10**6.75), thickness=(2650.5, 123456.0)), "one", "FSB").axes[0]
    assert [label.get_text() for label in odd.get_yticklabels()] == ["1e6", "5.623e6"]
    assert [label.get_text() for label in odd.get_xticklabels()] == ["2650.5", "123456"]


def test_one_key_has_lines_and_the_band_of_the_interval():
    ds = campaign(gains=GAINS[:, :1], thickness=(0.01,))
    ax = sweep(ds, "one", "FSB").axes[0]
    line = ax.lines[0]
    np.testing.assert_allclose(line.get_ydata(), GAINS[:, 0])
    band = ax.collections[0].get_paths()[0].vertices
    assert (band[:, 1].min(), band[:, 1].max()) == (-8.0, 11.0)
    assert ax.get_xlabel() == "young modulus [Pa]"


@pytest.mark.parametrize(
    ("reference", "words"), [("", "no rigid design"), ("FSB", "a rigid design that takes nothing")]
)
def test_without_a_rigid_design_that_takes_power_there_is_no_gain_to_draw(reference, words):
    ax = sweep(campaign(reference=reference), "one", None).axes[0]
    assert [text.get_text() for text in ax.texts] == [f"{words} to compare with"]


@pytest.mark.parametrize("name", ["tuned_power", "pareto", "sweep"])
def test_where_no_design_is_viable_figures_say_so(name):
    lost = campaign()
    lost["viable"] = lost.viable & False
    (ax,) = DRAWN[name](lost, "one", None).axes
    assert [text.get_text() for text in ax.texts] == ["no design is viable"]


def test_where_no_design_is_viable_there_are_no_matrices_and_no_scale_of_them():
    lost = campaign()
    lost["viable"] = lost.viable & False
    axes = power_matrices(lost, "one", None).axes
    assert [[text.get_text() for text in ax.texts] for ax in axes] == [["not viable"]] * 2
    assert [(ax.get_title(), len(ax.collections)) for ax in axes] == [(design, 0) for design in DESIGNS]


def test_where_no_damper_takes_anything_none_is_on_a_logarithmic_axis(recwarn):
    still = campaign()
    still["tried_damping"] = 0.0 * still.tried_damping
    (ax,) = tuned_power(still, "one", None).axes
    assert [text.get_text() for text in ax.texts] == ["no damper takes anything"]
    still["tried_damping"] = still.tried_damping + 1e-3  # of a small model
    assert not tuned_power(still, "one", None).axes[0].texts
    assert not recwarn.list


def test_all_figures_are_drawn_by_name():
    assert list(DRAWN) == ["power_matrices", "tuned_power", "pareto", "sweep"]


def test_figures_of_a_take_off_of_the_volume_are_of_pressures():
    ds = campaign(port="volume")
    labels = [figure(ds, "one", "FSB").axes[0].get_xlabel() for figure in (tuned_power, pareto)]
    assert labels == ["damper [Pa s/m³]", "rms pressure of the take-off [kPa]"]
    assert pareto(campaign(), "one", "FSB").axes[0].get_xlabel() == "rms force of the take-off [kN]"


@pytest.mark.parametrize("name", ["tuned_power", "pareto"])
def test_curves_of_several_designs_have_a_legend_of_them(name):
    (legend,) = DRAWN[name](campaign(), "one", "FSB").findobj(Legend)
    assert {text.get_text() for text in legend.get_texts()} >= {"FSB", "VSWEC"}


def test_curves_are_of_the_member_that_gains_most_and_of_designs_that_rest_stably():
    """VSWEC takes 8 % more than 10 kW there, and half as much again if tuned in each sea."""
    ds = campaign()
    ds["annual_mean_power"] = ds.annual_mean_power * xr.where(ds.tuning == "each", 1.5, 1.0)
    lines = [
        line for line in tuned_power(ds, "one", "FSB").axes[0].lines if to_hex(line.get_color()) == colour("VSWEC")
    ]
    marked = {line.get_marker(): line.get_ydata()[0] for line in lines if line.get_marker() in "os"}
    assert marked == pytest.approx({"o": 10.8, "s": 10.8})
    assert lines[-1].get_ydata() == pytest.approx([16.2, 16.2])
    ds["viable"] = ds.viable.where(ds.design != "VSWEC", other=False)
    for draw in (tuned_power, pareto):
        drawn = {to_hex(line.get_color()) for line in draw(ds, "one", "FSB").axes[0].lines}
        assert (colour("FSB") in drawn, colour("VSWEC") in drawn) == (True, False)


def test_a_third_key_has_a_row_of_maps_for_each_of_its_first_values_and_a_fourth_its_first():
    """Rows say their value, columns their design; gains of all share one scale."""
    soft = campaign(gains=2 * GAINS).sel(design=["VSWEC"]).assign_coords(design=["SOFT"])
    ds = xr.concat([campaign(), soft], "design", data_vars="minimal").assign_attrs(
        varied="young_modulus thickness mass density"
    )
    mass, density = (
        ("mass", np.arange(8) * 100.0 + 100.0, {"units": "kg"}),
        ("density", [1.0, 2.0], {"units": "kg/m^3"}),
    )
    ds = ds.assign_coords(mass=mass, density=density)
    ds["gain_percent"] = ds.gain_percent + (ds.mass - 100) / 10 + 1000 * (ds.density - 1)
    figure = sweep(ds, "one", "FSB")
    maps = [ax for ax in figure.axes if ax.get_label() != "<colorbar>" and ax.get_visible()]
    assert len(maps) == 2 * 6
    for i, pair in enumerate(zip(maps[::2], maps[1::2], strict=True)):
        for k, ax in enumerate(pair):
            found = ax.collections[0].get_array().reshape(2, 2)
            np.testing.assert_allclose(found, (k + 1) * GAINS + 10 * i, rtol=1e-9)
            assert ax.get_title() == (["VSWEC", "SOFT"][k] if i == 0 else "")
            assert ax.collections[0].get_clim() == maps[0].collections[0].get_clim()
        assert pair[0].get_ylabel() == f"young modulus [Pa]\nmass {100 * (i + 1)} kg"
    assert [ax.get_xlabel() for ax in maps[-2:]] == ["thickness [m]"] * 2
    assert figure.axes[-1].get_ylabel() == "gain over the rigid design [%]"


@pytest.mark.parametrize(("gains", "largest"), [(GAINS, 7.55), (0.01 * GAINS, 1.0)])
def test_colours_reach_to_all_but_the_largest_twentieth_of_the_gains_and_to_one_per_cent_at_least(gains, largest):
    """Of 1, 2, 5, 8 % the 95th of a hundred lies 0.85 of the way from 5 to 8."""
    assert sweep(campaign(gains=gains), "one", "FSB").axes[0].collections[0].get_clim() == pytest.approx(
        (-largest, largest)
    )


def test_a_map_is_grey_behind_points_at_which_a_design_does_not_rest():
    ds = campaign()
    assert to_hex(sweep(ds, "one", "FSB").axes[0].get_facecolor()) != "#bbbbbb"
    ds["viable"] = ds.viable.where((ds.design != "VSWEC") | (ds.thickness > 0.015), other=False)
    assert to_hex(sweep(ds, "one", "FSB").axes[0].get_facecolor()) == "#bbbbbb"


def test_power_under_limits_is_a_line_along_the_limit_of_the_point_shown():
    """Whatever the order of the limits in the study; points of other shells are no part of it."""
    limits, power = np.array([3e3, 1e3, 2e3]), np.array([3.0, 1.0, 2.0])
    ds = campaign().sel(tuning=["one", "one"]).assign_coords(tuning=["one", "constrained"])
    ds = ds.expand_dims(force_limit=limits).assign_attrs(varied="young_modulus thickness force_limit")
    share = xr.DataArray(power, dims="force_limit", coords={"force_limit": limits})
    soft = xr.where(ds.young_modulus == ds.young_modulus[0], 100.0, 1.0)
    ds = ds.assign(
        annual_mean_power=1e3 * share * soft * xr.ones_like(ds.annual_mean_power),
        force_rms=0.5 * ds.force_limit * xr.ones_like(ds.force_rms),
    )
    ax = pareto(ds, "one", "FSB").axes[0]
    lines = [line for line in ax.lines if line.get_marker() == "s"]
    assert [to_hex(line.get_color()) for line in lines] == [colour(design) for design in DESIGNS]
    for line in lines:
        np.testing.assert_allclose(line.get_xydata(), [[0.5, 1.0], [1.0, 2.0], [1.5, 3.0]])


def test_a_map_of_values_told_in_any_order_is_that_of_values_in_order():
    """Its cells lie side by side, each with its own gain."""
    ds = campaign(np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]), modulus=(1e6, 2e6, 3e6))
    shuffled = ds.isel(young_modulus=[2, 0, 1], thickness=[1, 0])
    first, second = (sweep(one, "one", "FSB").axes[0].collections[0] for one in (ds, shuffled))
    np.testing.assert_array_equal(second.get_array(), first.get_array())
    np.testing.assert_array_equal(second.get_coordinates(), first.get_coordinates())
    assert (np.diff(second.get_coordinates()[0, :, 0]) > 0).all()


def over(values, gains, **attrs):
    """A campaign over values of the thickness alone."""
    return campaign(gains=np.atleast_2d(gains), modulus=(1e6,), thickness=values, **attrs)


@pytest.mark.parametrize(
    ("values", "told"),
    [(np.array(["paper", "full"], dtype=object), ["paper", "full"]), ((np.inf, 20.0), ["20", "inf"])],
)
def test_over_words_and_deep_water_gains_stand_side_by_side_each_at_its_name(values, told):
    """Words in the order they are given in, depths in theirs; once words made no figure, and deep water no point."""
    figure = sweep(over(values, [-5.0, 2.0]), "one", "FSB")
    (ax,) = figure.axes
    gains = [-5.0, 2.0] if told[0] == "paper" else [2.0, -5.0]
    np.testing.assert_array_equal(ax.lines[0].get_xydata(), [[0, gains[0]], [1, gains[1]]])
    band = ax.collections[0].get_paths()[0].vertices
    assert {tuple(point) for point in band} == {(k, gain + by) for k, gain in enumerate(gains) for by in (-3.0, 3.0)}
    assert (list(ax.get_xticks()), list(ax.get_xticks(minor=True)), ax.get_xscale()) == ([0, 1], [], "linear")
    assert [label.get_text() for label in ax.get_xticklabels()] == told
    assert f"VSWEC,1,{gains[1]:g}\n" in data_csv(figure)


@pytest.mark.parametrize(
    ("values", "told"),
    [(np.array(list("fbcdea"), dtype=object), list("fbcdea")), ((*np.arange(10.0, 60.0, 10.0), np.inf), ["10", "inf"])],
)
def test_on_a_map_words_and_deep_water_have_a_cell_and_a_tick_each(values, told):
    ds = campaign(gains=np.arange(12.0).reshape(2, 6), thickness=values)
    ax = sweep(ds, "one", "FSB").axes[0]
    mesh = ax.collections[0]
    np.testing.assert_array_equal(mesh.get_array(), np.arange(12.0).reshape(2, 6))
    np.testing.assert_array_equal(mesh.get_coordinates()[0, :, 0], np.arange(-0.5, 6.0))
    labels = [label.get_text() for label in ax.get_xticklabels()]
    assert (labels[0], labels[-1], len(labels), ax.get_xscale()) == (told[0], told[-1], 6, "linear")


@pytest.mark.parametrize(("count", "own"), [(5, True), (6, False)])
def test_few_numbers_of_a_key_have_ticks_of_their_own(count, own):
    """On a map; where there are more, ticks are those of the axis."""
    values = 0.01 + 0.0037 * np.arange(count)
    ax = sweep(campaign(gains=np.ones((2, count)), thickness=values), "one", "FSB").axes[0]
    assert np.array_equal(ax.get_xticks(), values) == own


@pytest.mark.parametrize(("count", "marker"), [(12, "o"), (13, "None")])
def test_up_to_a_dozen_values_are_marked_on_their_line(count, marker):
    ax = sweep(over(np.arange(1.0, count + 1), np.arange(count)), "one", "FSB").axes[0]
    assert ax.lines[0].get_marker() == (marker if marker == "o" else "")


def test_a_line_leads_from_value_to_value_whatever_their_order():
    ax = sweep(over((3.0, 1.0, 2.0), (30.0, 10.0, 20.0)), "one", "FSB").axes[0]
    np.testing.assert_array_equal(ax.lines[0].get_xydata(), [[1, 10], [2, 20], [3, 30]])


def test_bins_are_half_a_metre_high_and_a_second_wide_also_where_there_is_one_of_them():
    """Of a sheltered site: its only bin of heights once reached from -0.25 to 0.75 m."""
    low = campaign().isel(hs=[0], te=[0]).assign_coords(hs=[0.25], te=[5.5])
    ax = power_matrices(low, "one", "FSB").axes[0]
    corners = ax.collections[0].get_coordinates()
    np.testing.assert_allclose(corners[[0, -1], [0, -1]], [[5.0, 0.0], [6.0, 0.5]])
    assert ax.get_xlim() == (5.0, 6.0)
    more = power_matrices(campaign(), "one", "FSB").axes[0].collections[0].get_coordinates()
    np.testing.assert_allclose(more[:, 0, 1], [0.5, 1.0, 1.5])
    np.testing.assert_allclose(more[0, :, 0], [5.0, 6.0, 7.0])


def test_an_odd_design_has_a_matrix_and_a_map_beside_it_nothing():
    """Of three designs, and of three flexible ones, the last of four axes are hidden."""
    third = campaign().sel(design=["FSB", "VSWEC", "VSWEC"]).assign_coords(design=[*DESIGNS, "other"])
    fourth = third.sel(design=["FSB", "VSWEC", "VSWEC", "other"]).assign_coords(design=[*DESIGNS, "other", "last"])
    for figure in (power_matrices(third, "one", "FSB"), sweep(fourth, "one", "FSB")):
        assert [ax.get_visible() for ax in figure.axes] == [True, True, True, False, True]  # and the scale of colours


def test_figures_of_a_take_off_that_turns_are_of_moments():
    ds = campaign(port="pitch")
    labels = [figure(ds, "one", "FSB").axes[0].get_xlabel() for figure in (tuned_power, pareto)]
    assert labels == ["damper [N m s]", "rms moment of the take-off [kN m]"]


def by_tuning(*values):
    return xr.DataArray(list(values), {"tuning": TUNINGS}, ("tuning",))


def test_matrices_and_their_crosses_are_of_the_tuning_asked_for_and_of_seas_there_are():
    """Crosses are the larger, the more of a bin is beyond; of bins at the ends that are empty nothing is shown."""
    ds = campaign()
    ds["power_matrix"] = ds.power_matrix * by_tuning(1.0, 2.0, 3.0)
    ds["beyond_validity"] = ds.beyond_validity * by_tuning(0.2, 0.6, 1.0)
    ds["count"] = (BINS, [[0, 3], [0, 2]])
    for tuning, factor, share in (("fixed", 1.0, 0.1), ("one", 2.0, 0.3), ("each", 3.0, 0.5)):
        figure = power_matrices(ds, tuning, "FSB")
        first, second, scale = figure.axes
        np.testing.assert_allclose(
            second.collections[0].get_array().filled(np.nan), factor * 10.8 * np.array([[np.nan, 9.0], [np.nan, 2.0]])
        )
        assert second.collections[1].get_sizes() == pytest.approx([4 + 20 * share])
        assert first.get_xlim() == second.get_xlim() == (6.0, 7.0)
        labels = [(ax.get_xlabel(), ax.get_ylabel()) for ax in (first, second, scale)]
        assert labels == [("energy period Te [s]", "Hs [m]"), ("energy period Te [s]", ""), ("", "mean power [kW]")]
        assert [to_hex(ax.title.get_color()) for ax in (first, second)] == [colour(design) for design in DESIGNS]


def test_marks_of_one_damper_stand_at_their_own_damper_and_power_the_given_one_open():
    ds = campaign()
    ds["annual_mean_power"] = ds.annual_mean_power * by_tuning(0.5, 1.0, 2.0)
    own = xr.DataArray([[2e3, 1e4], [4e3, 3e4]], {"design": DESIGNS, "tuning": ["fixed", "one"]}, ("design", "tuning"))
    ds["damping"] = ds.damping * (own.reindex(tuning=TUNINGS, fill_value=7e3) / 1e4)
    ax = tuned_power(ds, "one", "FSB").axes[0]
    for design, power in (("FSB", 10.0), ("VSWEC", 10.8)):
        marks = {line.get_marker(): line for line in ax.lines if to_hex(line.get_color()) == colour(design)}
        for name, marker, share, face in (("one", "o", 1.0, colour(design)), ("fixed", "s", 0.5, "#ffffff")):
            (at,) = marks[marker].get_xydata()
            assert at == pytest.approx([float(own.sel(design=design, tuning=name)), share * power])
            assert to_hex(marks[marker].get_markerfacecolor()) == face
    assert (ax.get_ylim()[0], ax.get_ylabel()) == (0.0, "mean power of the year [kW]")
    without = tuned_power(ds.sel(tuning=["one"]), "one", "FSB").axes[0]
    assert [line.get_marker() for line in without.lines] == ["None", "o"] * 2
    given = tuned_power(ds.sel(tuning=["fixed"]), "fixed", "FSB").axes[0]
    assert [line.get_marker() for line in given.lines] == ["None", "s"] * 2


def test_power_over_force_begins_at_nothing_and_beside_optima_is_logarithmic():
    """An optimum of a limit nobody could keep is left out."""
    ax = pareto(campaign(), "one", "FSB").axes[0]
    assert (ax.get_xlim()[0], ax.get_ylim()[0], ax.get_xscale(), ax.get_yscale()) == (0.0, 0.0, "linear", "linear")
    ds = campaign().sel(tuning=["one", "one"]).assign_coords(tuning=["one", "constrained"])
    ds["annual_mean_power"] = ds.annual_mean_power.where((ds.tuning == "one") | (ds.design == "FSB"))
    ax = pareto(ds, "one", "FSB").axes[0]
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    squares = [line for line in ax.lines if line.get_marker() == "s"]
    assert [len(line.get_xdata()) for line in squares] == [1, 0]
    assert [to_hex(line.get_markerfacecolor()) for line in squares] == ["#ffffff"] * 2


def test_gains_corrected_by_runs_are_lines_and_those_of_linear_theory_dotted_beside_them():
    ds = campaign(gains=GAINS[:, :1], thickness=(0.01,))
    ds = by_runs(ds, ds.gain_percent - 1.5)
    for tuning, values in (("one", [GAINS[:, 0] - 1.5, GAINS[:, 0], [0.0, 0.0]]), ("each", [GAINS[:, 0], [0.0, 0.0]])):
        lines = sweep(ds, tuning, "FSB").axes[0].lines
        np.testing.assert_allclose([line.get_ydata() for line in lines], values)
    dotted = sweep(ds, "one", "FSB").axes[0].lines[1]
    assert (dotted.get_linestyle(), to_hex(dotted.get_color())) == (":", colour("VSWEC"))


def test_keys_that_are_varied_together_have_lines_over_the_first_of_them():
    """Members of a list are no grid: there is nothing between them to be mapped."""
    ds = campaign(gains=GAINS[:, :1], thickness=(0.01,)).isel(thickness=0, drop=True).rename(young_modulus="member")
    keys = {"thickness": ("member", [0.02, 0.01], {"units": "m"}), "mass": ("member", [10.0, 20.0], {"units": "kg"})}
    ds = ds.drop_vars("member").assign_coords(keys).assign_attrs(varied="thickness mass")
    assert not is_mapped(ds)
    assert is_mapped(campaign())
    (ax,) = sweep(ds.swap_dims(member="thickness").swap_dims(thickness="member"), "one", "FSB").axes
    assert ax.get_xlabel() == "thickness [m]"
    np.testing.assert_array_equal(ax.lines[0].get_xydata(), [[0.01, 8.0], [0.02, -5.0]])


def test_hatching_covers_the_cells_whose_interval_holds_zero_and_the_line_of_buckling_lies_at_a_margin_of_none():
    """Three moduli and two thicknesses; an interval that just ends at zero holds it."""
    gains = np.array([[-5.0, 3.0], [8.0, 4.0], [-3.0, 9.0]])
    margin = np.array([[-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0]])
    ds = campaign(gains=gains, margin=margin, modulus=(1e6, 2e6, 4e6), thickness=(0.01, 0.03))
    ax = sweep(ds, "one", "FSB").axes[0]
    _, hatched, line = ax.collections
    cells = sorted(tuple(path.vertices[:-1].mean(axis=0)) for path in hatched.get_paths())
    np.testing.assert_allclose(cells, [(0.01, 4e6), (0.03, 1e6)])
    sizes = sorted((box.width, box.height) for box in (path.get_extents() for path in hatched.get_paths()))
    np.testing.assert_allclose(sizes, [(0.02, 1e6), (0.02, 2e6)])
    share = np.log10(2.0) / (np.log10(2.0) + 6)  # of a margin of one, whose logarithm is cut
    assert len(line.get_paths()[0]) > 2
    np.testing.assert_allclose(line.get_paths()[0].vertices[:, 0], 0.01 + 0.02 * share, rtol=1e-9)
    for none in (0.5, -0.5):
        assert len(sweep(campaign(margin=none), "one", "FSB").axes[0].collections) == 2


@pytest.mark.parametrize(
    ("value", "text"),
    [(2650.5, "2650.5"), (-2.34567e7, "-2.346e7"), (2.34567e7, "2.346e7"), (1e-5, "1e-5"), (0.0, "0"), ("full", "full"),
     (1e6, "1e6"), (-999999.0, "-999999"), (12, "12")],
)  # fmt: skip
def test_numbers_beside_an_axis_are_written_as_in_study_files(value, text):
    assert _number(value) == text


@pytest.mark.parametrize(
    ("values", "scale"),
    [((1.0, 10.0), "log"), ((1.0, 9.99), "linear"), ((10.0, 3.0, 1.0), "log"), ((0.0, 10.0), "linear"),
     ((-1.0, 10.0), "linear"), ((-10.0, -1.0), "linear"), ((1.0, np.inf), "linear")],
)  # fmt: skip
def test_an_axis_is_logarithmic_from_a_decade_on(values, scale):
    ds = xr.Dataset(coords={"mass": ("mass", list(values), {"units": "kg"}), "clamp": ("clamp", [0.1], {"units": "1"})})
    assert _scale(ds, "mass") == scale
    assert (_label(ds, "mass"), _label(ds, "clamp")) == ("mass [kg]", "clamp [-]")
    assert (_label(ds.assign_coords(basis=["full"]), "basis")) == "basis [-]"


def test_a_value_of_a_row_is_told_in_words_of_its_own_unit():
    ds = xr.Dataset(
        coords={"young_modulus": ("young_modulus", [1e6, 3e9], {"units": "Pa"}), "basis": ["paper", "full"]}
    )
    assert [_told(ds, "young_modulus", i) for i in (0, 1)] == ["young modulus 1 MPa", "young modulus 3 GPa"]
    assert _told(ds, "basis", 1) == "basis full"


def test_a_map_is_of_the_gains_that_are_told():
    """Corrected by runs in time under their tuning, in colours of their own reach; of linear theory under another."""
    ds = by_runs(campaign(), 3.0 * campaign().gain_percent)
    for tuning, factor in (("one", 3.0), ("each", 1.0)):
        mesh = sweep(ds, tuning, "FSB").axes[0].collections[0]
        np.testing.assert_allclose(mesh.get_array().reshape(2, 2), factor * GAINS)
        assert mesh.get_clim() == pytest.approx((-7.55 * factor, 7.55 * factor))


def test_colours_of_losses_reach_as_far_as_those_of_gains():
    mesh = sweep(campaign(gains=-np.abs(GAINS)), "one", "FSB").axes[0].collections[0]
    assert mesh.get_clim() == pytest.approx((-7.55, 7.55))


def test_matrices_of_a_study_whose_rarest_bin_holds_one_sea_show_it():
    ds = campaign()
    ds["count"] = (BINS, [[1, 0], [0, 2]])
    assert power_matrices(ds, "one", "FSB").axes[0].get_xlim() == (5.0, 7.0)


def test_dampers_are_drawn_where_one_design_alone_takes_something():
    ds = campaign()
    curve = xr.ones_like(ds.power_of_damping) * xr.DataArray(DAMPERS, dims="tried")
    ds["tried_damping"] = curve.where(ds.design == "VSWEC", 0.0)
    ax = tuned_power(ds, "one", "FSB").axes[0]
    assert not ax.texts
    assert max(len(line.get_xdata()) for line in ax.lines) == len(DAMPERS)


@pytest.mark.parametrize("lost", DESIGNS)
def test_a_design_that_does_not_rest_is_no_reason_to_leave_out_others(lost):
    """Whichever of them, before the others or behind."""
    ds = campaign()
    ds["viable"] = ds.viable.where(ds.design != lost, other=False)
    (other,) = (design for design in DESIGNS if design != lost)
    for draw in (tuned_power, pareto):
        drawn = {to_hex(line.get_color()) for line in draw(ds, "one", "FSB").axes[0].lines}
        assert (colour(other) in drawn, colour(lost) in drawn) == (True, False)
    axes = power_matrices(ds, "one", "FSB").axes
    assert [bool(ax.collections) for ax in axes[:2]] == [design == other for design in DESIGNS]
    assert [[text.get_text() for text in ax.texts] for ax in axes[:2]] == [
        [] if design == other else ["not viable"] for design in DESIGNS
    ]


def test_where_all_designs_are_rigid_there_is_none_to_compare():
    ax = sweep(campaign().sel(design=["FSB"]), "one", "FSB").axes[0]
    assert [text.get_text() for text in ax.texts] == ["no flexible design to compare with"]


def test_a_dot_marks_the_best_damper_at_the_end_of_each_curve_over_force():
    ds = campaign()
    ds["force_of_damping"] = ds.force_of_damping * xr.where(ds.design == "FSB", 1.0, 3.0)
    ax = pareto(ds, "one", "FSB").axes[0]
    for design, force in zip(DESIGNS, (1.0, 3.0), strict=True):
        curve, dot = (line.get_xydata() for line in ax.lines if to_hex(line.get_color()) == colour(design))
        assert dot.tolist() == [curve[-1].tolist()]
        assert dot[0] == pytest.approx([force, 10.0])


@pytest.mark.parametrize("count", [1, 3])
def test_each_design_has_a_column_of_its_own_where_a_third_key_has_rows(count):
    """However many there are; without a third key they stand in pairs."""
    names = ["SOFT", "THIN", "WIDE"][:count]
    more = [
        campaign(gains=k * GAINS).sel(design=["VSWEC"]).assign_coords(design=[name]) for k, name in enumerate(names, 1)
    ]
    ds = xr.concat([campaign().sel(design=["FSB"]), *more], "design", data_vars="minimal")
    pairs = [ax for ax in sweep(ds, "one", "FSB").axes if ax.get_label() != "<colorbar>"]
    assert [ax.get_subplotspec().get_gridspec().ncols for ax in pairs] == [min(2, count)] * len(pairs)
    ds = ds.assign_attrs(varied="young_modulus thickness mass").assign_coords(
        mass=("mass", [1.0, 2.0], {"units": "kg"})
    )
    ds["gain_percent"] = ds.gain_percent + 100.0 * ds.mass
    maps = [ax for ax in sweep(ds, "one", "FSB").axes if ax.get_label() != "<colorbar>"]
    assert [(ax.get_subplotspec().rowspan.start, ax.get_subplotspec().colspan.start) for ax in maps] == [
        (i, k) for i in range(2) for k in range(count)
    ]
    for i, ax in enumerate(maps):
        expected = (i % count + 1) * GAINS + 100.0 * (1 + i // count)
        np.testing.assert_allclose(ax.collections[0].get_array().reshape(2, 2), expected)
