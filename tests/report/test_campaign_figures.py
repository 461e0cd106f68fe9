"""Figures of a campaign, on made-up results whose curves and optima are known."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

from vsb.report.campaign_answer import shown_place
from vsb.report.campaign_figures import (
    pareto,
    power_matrices,
    sweep,
    tuned_power,
)
from vsb.report.canvas import style

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
