"""Figures, answer and page of a campaign, on made-up results whose curves and optima are known."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

from vsb.engine.waves.climate import YEAR_HOURS
from vsb.report import campaign_page
from vsb.report.campaign_answer import (
    answer,
    best_flexible,
    closing_answer,
    leading,
    of_points,
    shown_place,
    where,
    whole_answer,
)
from vsb.report.campaign_page import pareto, power_matrices, render, statements, sweep, tuned_power, warnings
from vsb.report.canvas import style, svg_text
from vsb.results.campaign import TABLE_OF_SEAS

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
        "annual_mean_power_low": ((*points, *by), 0.99 * power),
        "annual_mean_power_high": ((*points, *by), 1.02 * power),
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
    attributes = {"varied": "young_modulus thickness", "reference": "FSB", "climate": "a buoy", "campaign": "made_up"}
    return xr.Dataset(data, coords, {**attributes, "study": "seed", "spec_id": "0" * 16, **attrs})


def colour(design):
    return to_hex(style(design, DESIGNS, "FSB")["color"])


def test_member_shown_gains_most_among_those_that_do_not_buckle():
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


def test_curve_over_damping_peaks_at_the_marked_optimum():
    ax = tuned_power(campaign(), "one", "FSB").axes[0]
    curve, best, *_ = (line for line in ax.lines if to_hex(line.get_color()) == colour("FSB"))
    np.testing.assert_allclose(curve.get_xdata(), DAMPERS)
    assert curve.get_xdata()[np.argmax(curve.get_ydata())] == pytest.approx(best.get_xdata()[0])
    assert best.get_ydata()[0] == 10.0
    assert (ax.get_xscale(), ax.get_xlabel()) == ("log", "damping [N s/m]")


def test_constrained_optimum_is_drawn_at_its_force_and_power():
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


def test_power_matrices_share_a_scale_and_mark_empty_and_invalid_bins():
    figure = power_matrices(campaign(), "one", "FSB")
    meshes = [ax.collections[0] for ax in figure.axes[:2]]
    assert [ax.get_title() for ax in figure.axes[:2]] == DESIGNS
    assert meshes[0].get_clim() == meshes[1].get_clim() == pytest.approx((0.0, 21.6))
    np.testing.assert_allclose(meshes[0].get_array().filled(np.nan), [[10.0, np.nan], [5.0, 20.0]])
    crosses = [ax.collections[1].get_offsets() for ax in figure.axes[:2]]
    assert len(crosses[0]) == 0
    np.testing.assert_allclose(crosses[1], [[6.85, 1.425]])  # above and right of the number


def test_one_key_is_drawn_as_a_line_with_its_interval():
    ds = campaign(gains=GAINS[:, :1], thickness=(0.01,))
    ax = sweep(ds, "one", "FSB").axes[0]
    line = ax.lines[0]
    np.testing.assert_allclose(line.get_ydata(), GAINS[:, 0])
    ends = np.array([segment[:, 1] for segment in ax.collections[0].get_segments()])
    assert (ends.min(), ends.max(), line.get_linestyle()) == (-8.0, 11.0, "None")  # of two points
    ax.figure.draw_without_rendering()
    assert ax.get_xlabel() == "young modulus"
    assert "100 MPa" in {tick.get_text() for tick in ax.get_xticklabels()}


def test_a_map_of_many_points_is_one_image(monkeypatch):
    """Each of the points within an interval that includes zero; the map says nothing about one of them."""
    monkeypatch.setattr(campaign_page, "MOST_DRAWN", 150)
    axes = {"modulus": np.geomspace(1e6, 1e8, 13), "thickness": np.linspace(0.01, 0.02, 13)}
    few, many = (svg_text(sweep(campaign(np.zeros((n, n)), **{k: v[:n] for k, v in axes.items()}), "one", "FSB"))
                 for n in (12, 13))  # fmt: skip
    assert few.count("<path") > 150
    assert many.count("<path") < 75
    assert len(many) < 1e5


def over(values, gains, **attrs):
    """A campaign over values of the thickness alone."""
    return campaign(gains=np.atleast_2d(gains), modulus=(1e6,), thickness=values, **attrs)


def test_without_a_rigid_design_powers_are_drawn_with_their_intervals():
    ds = campaign(gains=GAINS[:, :1], thickness=(0.01,)).sel(design=["VSWEC"])
    ax = sweep(ds, "one", None).axes[0]
    np.testing.assert_allclose(ax.lines[0].get_ydata(), 10 * (1 + GAINS[:, 0] / 100))
    ends = np.array([segment[:, 1] for segment in ax.collections[0].get_segments()])
    assert (ends.min(), ends.max()) == pytest.approx((0.99 * 9.5, 1.02 * 10.8))
    assert ax.get_ylabel() == "mean power of the year [kW]"


def test_further_statements():
    each, points, beyond, practice = statements(campaign(margin=[[0.5, -0.5], [0.5, -0.5]]), "FSB", "one")
    assert "in each sea, the best flexible design, VSWEC at young modulus 100 MPa" in each
    assert points == "2 of 4 points are stable against buckling; a flexible design absorbs more at 1 of these."
    assert beyond == (
        "25 % of the energy comes from the seas crossed in the matrices: 10 % too steep, 0 % with breaking waves, "
        "40 % with shells deformed by more than a tenth of their radius."
    )
    assert practice.endswith("would change the annual energy by +12.0 %.")
    of_table = campaign(margin=[[0.5, -0.5], [0.5, -0.5]], seas=TABLE_OF_SEAS)  # in other bins than those of the table
    assert statements(of_table, "FSB", "one") == [each, points, beyond]


def test_warnings_of_a_campaign():
    theory, heave = warnings(campaign())
    assert theory.startswith("All results are linear theory")
    assert heave.startswith("Seas with 90 % of the year's energy have heave amplitudes above 0.3 of the radius")
    assert warnings(campaign(margin=[[0.5, -0.5], [0.5, 0.5]]))[2].startswith("At 1 of 4 points the shell would buckle")
    ds = campaign()
    runs, coverage = warnings(by_runs(ds, ds.gain_percent, width=0.1))[:2]
    assert "coverage is 77 to 95 % with 12 seas, 89 to 96 % with 24" in coverage
    assert runs.startswith("Time-domain runs correct the answer (tuning one: 4 seas). Figures")
    _, few, _ = warnings(by_runs(ds, ds.gain_percent, width=5.1))[:3]
    assert few == "The interval of the gain of VSWEC includes zero: more verify.seas would narrow it."
    lost = campaign()
    lost["viable"] = lost.viable & (lost.design != "VSWEC")
    lost["reason"] = lost.reason.where(lost.design != "VSWEC", other="unstable: at rest")
    assert warnings(lost)[-1] == "4 of 8 combinations of design and point are not viable: unstable."


@pytest.mark.parametrize(("port", "unit"), [("pressure", "Pa s/m³"), ("force", "N s/m")])
def test_units_of_the_page_follow_the_port(port, unit):
    text = render(campaign(port_kind=port, study="a.yaml", campaign="c", spec_id="1"), {})
    assert ("rms pressure [kPa]" in text, "rms force [kN]" in text) == (port == "pressure", port == "force")


def test_answer_names_the_best_flexible_design_that_does_not_buckle():
    assert answer(campaign(), "FSB", "one") == (
        "Over a year of a buoy, each design at its optimal damping for the year, the best flexible design, VSWEC at "
        "young modulus 100 MPa, thickness 0.01 m, absorbs 8.0 % more than the rigid FSB (+5.0 to +11.0 % by linear "
        "theory; 94.67 against 87.66 MWh)."
    )
    one, design = best_flexible(campaign(margin=[[0.5, 0.5], [-0.1, 0.5]]), "FSB", "one")
    assert (design, where(one)) == ("VSWEC", "young modulus 1 MPa, thickness 0.02 m")


def test_no_valid_answer_where_every_shell_buckles():
    found = whole_answer(campaign(margin=-1.0), "FSB", "one")
    assert found.stands == [
        "No valid answer yet: the shell buckles under its static load at all 4 points (2 times what it can carry). Change "
        "first: raise device.internal_pressure to carry the load, or device.thickness."
    ]
    assert closing_answer(campaign(margin=-1.0)) == found.stands[0]
    (below,) = found.below
    assert below.startswith("Computed although the model does not hold: Over a year of a buoy, each design")
    assert "94.67 against 87.66 MWh)" in below
    carries = whole_answer(campaign(), "FSB", "one")
    assert (carries.stands[0], carries.below) == (answer(campaign(), "FSB", "one"), [])


def test_no_valid_answer_where_no_flexible_design_is_viable():
    ds = campaign(advice="device.young_modulus of 11 MPa")
    ds["viable"] = ds.viable & (ds.design == "FSB")
    ds["reason"] = ds.reason.where(ds.viable, other="overstrained: 14.1 % at rest")
    blank = [name for name, of in ds.data_vars.items() if {"design", "tuning"} <= set(of.dims)]
    ds = ds.assign({name: ds[name].where(ds.viable) for name in blank})
    assert closing_answer(ds) == (
        "No valid answer yet: no flexible design is viable at all 4 points (overstrained). Change first: "
        "device.young_modulus of 11 MPa."
    )
    ds["viable"] = ds.viable | (ds.thickness > 0.01)
    assert "absorbs most" in closing_answer(ds)


def test_answer_of_time_domain_runs_also_gives_the_linear_gain():
    ds = campaign()
    gain = (ds.gain_percent - 2.0).where(ds.design != "FSB", 0.0)
    text = answer(by_runs(ds, gain, width=0.7, factor=0.917), "FSB", "one")
    assert "absorbs 6.0 % more" in text
    assert "(+5.3 to +6.7 % by body-exact runs; linear theory gives +8.0 %; 85.21 against 80.38 MWh)" in text
    text = answer(by_runs(ds, gain, width=7.0, model="linear"), "FSB", "one")
    assert (
        "(-1.0 to +13.0 % by linear time-domain runs; linear theory gives +8.0 %; too few runs to resolve the sign;"
        in text
    )


def test_no_gain_over_a_rigid_design_without_power():
    ds = campaign()
    ds.gain_percent.loc[{"tuning": "one"}] = np.nan
    assert leading(ds) == ("one", None)
    assert closing_answer(ds).endswith(
        "VSWEC at young modulus 100 MPa, thickness 0.01 m absorbs most: 94.67 MWh (93.73 to 96.57 with all known errors)."
    )
    ds["annual_mean_power"] = 0.0 * ds.annual_mean_power
    assert closing_answer(ds).endswith("optimal damping for the year, no design absorbs power.")
    ds = campaign()
    ds.gain_percent.loc[{"tuning": "fixed"}] = np.nan
    assert leading(ds) == ("one", "FSB")


def test_without_a_rigid_design_power_is_that_of_the_runs_too():
    """The power that `vsb compare` shows, with its interval; linear theory's has another column."""
    ds = campaign(gains=np.full((2, 2), 3.0))
    ds.gain_percent.loc[{"tuning": "one"}] = np.nan
    ds = by_runs(ds, ds.gain_percent)
    ds["body_exact_mean_power"] = 0.9 * ds.annual_mean_power.sel(tuning="one", drop=True)
    ds["body_exact_power_low"], ds["body_exact_power_high"] = 0.8 * ds.body_exact_mean_power, ds.body_exact_mean_power
    most = float(ds.body_exact_mean_power.max()) * YEAR_HOURS / 1e6
    assert closing_answer(ds).endswith(
        f"absorbs most: {most:.4g} MWh ({0.8 * most:.4g} to {most:.4g} with all known errors)."
    )


def test_points_that_buckle_are_not_counted_as_paying():
    """The interval must lie above zero; a margin of zero still carries."""
    expected = "{} stable against buckling; a flexible design absorbs more at {} of these."
    few = "3 of 4 points are", "1 of 4 points is"
    for margin, counts in (([[0.0, 0.5], [-0.1, 0.5]], (few[0], "none")), ([[-0.1, -0.1], [0.0, -0.1]], (few[1], 1))):
        assert of_points(campaign(margin=margin), "FSB", "one") == expected.format(*counts)
    assert of_points(campaign(gains=np.full((2, 2), 3.0)), "FSB", "one") == expected.format("All 4 points are", "none")


def test_points_say_under_which_damper_where_control_is_shown_too():
    """Under control flexible designs may gain where under dampers they do not."""
    ds = campaign().sel(tuning=["one", "one"]).assign_coords(tuning=["one", "causal"])
    assert "; each design at its optimal damping for the year, a flexible design absorbs" in of_points(ds, "FSB", "one")


def three(**changes):
    """The campaign with two flexible designs, the second with gains of its own."""
    ds = campaign().sel(design=["FSB", "VSWEC", "VSWEC"]).assign_coords(design=["FSB", "VSWEC", "other"])
    for name, values in changes.items():
        ds[name] = ds[name].copy()
        ds[name][{"design": 2}] = np.asarray(values)[..., None]
    return ds


def test_best_design_is_chosen_by_the_gains_of_the_runs():
    """Linear theory would choose another design and another point."""
    ds = three(gain_percent=[[1.0, 2.0], [12.0, 4.0]])
    ds = by_runs(ds, ds.gain_percent.copy(deep=True))
    ds.body_exact_gain_percent[1, 0, 2] = 3.0
    ds.body_exact_gain_percent[0, 1, 1] = 9.0
    one, design = best_flexible(ds, "FSB", "one")
    assert (design, where(one)) == ("VSWEC", "young modulus 1 MPa, thickness 0.02 m")
    one, design = best_flexible(ds, "FSB", "each")
    assert (design, where(one)) == ("other", "young modulus 100 MPa, thickness 0.01 m")
    ds.body_exact_gain_percent[0, 1, 2] = 10.0
    assert best_flexible(ds, "FSB", "one")[1] == "other"
