"""What figures show, and what they leave out."""

import numpy as np
import pytest
import xarray as xr

from vsb.report.band import USEFUL, useful_band
from vsb.report.canvas import StudyData
from vsb.report.figures import (
    _band,
    absorbed_power,
    added_mass_damping,
    directions,
    draw,
    energy_audit,
    radiation_kernel,
    reactance,
)
from vsb.report.shell_figures import mode_shapes
from vsb.report.svg import drawn

OMEGA = np.linspace(0.1, 6.0, 600)
NONE = xr.Dataset()


def data(**changes):
    """A rigid and a flexible design; what a figure is drawn of is put in."""
    given = dict.fromkeys(("modes", "database", "radiation", "response", "witness"), NONE)
    return StudyData(**{
        "designs": ("FSB", "VSWEC"), "reference": "FSB", "wave_frequencies": (2.5,), "periods": {}, "window": (0.0, 1.0),
        "runs": {}, **given, **changes,
    })  # fmt: skip


@pytest.fixture
def responding():
    """A bump of power at 2 rad/s; the gain runs away where nothing is absorbed any more."""
    power = np.exp(-4 * (OMEGA - 2.0) ** 2) * np.array([np.ones_like(OMEGA), 1 + 0.01 * OMEGA**4])
    pair = (("design", "omega"), 1e3 * power)
    response = xr.Dataset(
        {"best_power": pair, "absorbed_power": pair, "power_limit": ("omega", 5e3 / OMEGA)},
        coords={"design": ["FSB", "VSWEC"], "omega": OMEGA},
    )
    return data(response=response)


def test_gains_are_drawn_where_power_is_absorbed_and_the_axis_fits_them(responding):
    (_, _, low, _) = absorbed_power(responding).axes[:4]
    drawn = next(line for line in low.get_lines() if line.get_label() == "VSWEC")
    best = responding.response.best_power.max("design").values
    shown = ~np.isnan(drawn.get_ydata())
    assert shown.any()
    assert (best[shown] >= USEFUL * best.max()).all()
    assert low.get_ylim()[1] < 250  # beyond the bump it is a thousand


@pytest.mark.filterwarnings("error")
def test_what_best_dampers_take_beyond_the_band_shown_leaves_the_axis_its_bounds(responding):
    best = 1e3 * np.exp(-40 * (OMEGA - 5.5) ** 2) * np.ones((2, 1))
    response = responding.response.assign(best_power=(("design", "omega"), best))
    (_, _, low, _) = absorbed_power(data(response=response)).axes[:4]
    assert low.get_ylim()[0] <= -20 < 20 <= low.get_ylim()[1]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("limit", [0.0, 3e3])
def test_where_no_design_absorbs_the_axis_holds_the_limit_or_a_kilowatt(responding, limit):
    none = {name: 0.0 * responding.response[name] for name in ("best_power", "absorbed_power")}
    response = responding.response.assign(**none, power_limit=("omega", np.full(OMEGA.shape, limit)))
    (top, *_) = absorbed_power(data(response=response)).axes
    assert top.get_ylim() == (0.0, limit / 1e3 or 1.0)


def test_without_a_rigid_design_there_is_no_empty_panel_of_gains(responding):
    alone = data(response=responding.response, reference=None)
    assert len(absorbed_power(alone).axes) < len(absorbed_power(responding).axes)
    labels = [ax.get_xlabel() for ax in absorbed_power(alone).axes]
    assert labels == ["wave frequency [rad/s]"] * 2


def test_the_studys_wave_is_marked_on_the_axis_and_crosses_nothing(responding):
    for ax in absorbed_power(responding).axes[:4]:
        (mark,) = (line for line in ax.get_lines() if line.get_label() == "study's wave")
        assert mark.get_linestyle() == "None"
        assert list(mark.get_ydata()) == [0.0]
        assert mark.get_transform() == ax.get_xaxis_transform()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("omega", [0.12, 2.5, 5.8])
def test_the_band_shown_holds_the_studys_wave_where_it_lies_outside_what_absorbs(responding, omega):
    """Once its mark lay beside the axes, which were laid out away to nothing."""
    figure = absorbed_power(data(response=responding.response, wave_frequencies=(omega,)))
    low, high = figure.axes[0].get_xlim()
    assert low <= omega <= high
    assert low <= 0.3 < 2.9 < high
    drawn(figure, "absorbed_power")
    assert min(ax.get_position().width for ax in figure.axes[:4]) > 0.2


def test_heave_is_seen_where_a_mode_lies_under_it():
    labels = ["Heave", "Membrane0", "Membrane1"]
    value = (("omega", "influenced_dof", "radiating_dof"), np.ones((2, 3, 3)))
    coords = {"omega": [0.0, 1.0], "influenced_dof": labels, "radiating_dof": labels}
    database = xr.Dataset({"added_mass": value, "radiation_damping": value}, coords=coords)
    database["added_mass_inf"] = database.added_mass.isel(omega=0)
    for ax in added_mass_damping(data(database=database)).axes:
        heave, under = (
            next(line for line in ax.get_lines() if line.get_label() == one) for one in ("Heave", "Membrane1")
        )
        assert heave.get_zorder() > under.get_zorder()
        assert (heave.get_linestyle(), under.get_linestyle()) == (":", "-") or heave.is_dashed()


def test_a_motion_that_never_moves_has_no_panel():
    """Waves do not turn a sphere about its axis; where nothing moves at all every motion is shown to be zero."""
    time, labels = np.linspace(0.0, 1.0, 5), ["Heave", "Surge", "Yaw"]

    def panels_of(moved):
        position = xr.DataArray(np.outer(time, moved), {"time": time, "dof": labels}, ("time", "dof"))
        run = xr.Dataset({"position": position})
        found = directions(data(runs={(design, "w"): run for design in ("FSB", "VSWEC")}, periods={"w": 1.0}), "w")
        return [ax.get_ylabel() for ax in found.axes]

    assert panels_of([1.0, 1.0, 0.0]) == ["surge [m]", "heave [m]"]
    assert panels_of([0.0, 0.0, 0.0]) == ["surge [m]", "heave [m]", "yaw [degrees]"]


def test_no_bar_of_energies_ends_at_the_edge():
    terms = ["pto", "radiated", "structural", "stored", "wave"]
    energy = (("time", "term"), 1e3 * np.array([[24.0, 24.0, 0.0, -7.0, 41.0]]))
    run = xr.Dataset({"energy": energy}, coords={"term": terms, "time": [1.0]})
    ax = energy_audit(data(runs={(design, "w"): run for design in ("FSB", "VSWEC")}), "w").axes[0]
    assert [0.0, 0.0] in [
        list(line.get_xdata()) for line in ax.get_lines()
    ]  # what is given up is told from what is got
    assert "stored below 0" in ax.get_xlabel()
    left, right = ax.get_xlim()
    assert left < -7.0 * 1.05
    assert right > 48.0 * 1.02


def test_rotations_have_units_of_their_own():
    labels = ["Heave", "Pitch"]
    value = (("omega", "influenced_dof", "radiating_dof"), np.ones((2, 2, 2)))
    coords = {"omega": [0.0, 1.0], "influenced_dof": labels, "radiating_dof": labels}
    database = xr.Dataset({"added_mass": value, "radiation_damping": value}, coords=coords)
    database["added_mass_inf"] = database.added_mass.isel(omega=0)
    top, bottom = added_mass_damping(data(database=database)).axes
    assert ("of rotations kg m²]" in top.get_ylabel(), "of rotations kg m²/s]" in bottom.get_ylabel()) == (True, True)


@pytest.mark.parametrize("degree", [2, 3, 6])
def test_no_meridian_of_a_mode_folds(degree):
    """Points of the shell keep their order along it, however much they move along it."""
    phi = np.linspace(0.0, np.pi, 181)
    v, u = np.cos(degree * phi) / degree, np.sin(degree * phi)
    modes = xr.Dataset(
        {"radial": (("mode", "colatitude"), [v]), "meridional": (("mode", "colatitude"), [u]),
         "degree": ("mode", [degree]), "dry_frequency": ("mode", [10.0])},
        coords={"mode": ["M"], "colatitude": phi},
    )  # fmt: skip
    circle, meridian = mode_shapes(data(modes=modes)).axes[0].get_lines()
    x, z = (np.asarray(a[:181], dtype=float) for a in meridian.get_data())
    along = np.diff(x) * np.cos(phi[:-1]) - np.diff(z) * np.sin(phi[:-1])
    assert (along > 0).all()
    assert np.hypot(*circle.get_data()) == pytest.approx(1.0)


def test_coefficients_are_drawn_as_they_are_down_to_where_a_logarithm_ends():
    """A zero is drawn at a gram a second, far below the axis; a motion that moves no water is left out."""
    labels = ["Heave", "Pitch", "Membrane0"]
    added, damping = np.zeros((2, 4, 3))
    added[:, 0], added[:, 2] = [5.0, 4.0, 3.0, 2.0], [1.0, 2.0, 3.0, -4.0]
    damping[:, 0], damping[:, 2] = [0.0, 40.0, 200.0, 1e-5], [0.0, 0.5, 3.0, 2.0]
    pair = ("omega", "influenced_dof", "radiating_dof")
    coords = {"omega": [0.5, 1.0, 2.0, 4.0], "influenced_dof": labels, "radiating_dof": labels}
    values = {"added_mass": added, "radiation_damping": damping}
    database = xr.Dataset({name: (pair, v[:, :, None] * np.eye(3)) for name, v in values.items()}, coords)
    database["added_mass_inf"] = (pair[1:], np.diag([2.5, 0.0, 1.5]))
    figure = added_mass_damping(data(database=database))
    top, bottom = figure.axes
    drawn_ = {line.get_label(): line for line in bottom.get_lines()}
    assert list(drawn_) == ["Heave", "Membrane0"]
    assert drawn_["Heave"].get_ydata().tolist() == [1e-3, 40.0, 200.0, 1e-3]
    assert drawn_["Membrane0"].get_ydata().tolist() == [1e-3, 0.5, 3.0, 2.0]
    assert drawn_["Heave"].get_xdata().tolist() == [0.5, 1.0, 2.0, 4.0]
    assert (bottom.get_yscale(), bottom.get_ylim(), bottom.get_xlim()) == ("log", (2e-3, 400.0), (0.0, 4.0))
    lines = [line.get_ydata() for line in top.get_lines()]
    assert [list(y) for y in lines] == [list(added[:, 0]), [2.5, 2.5], list(added[:, 2]), [1.5, 1.5]]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["Heave", "Membrane0"]


@pytest.mark.parametrize(("ratio", "plain"), [(60.0, True), (70.0, False)])
def test_an_axis_of_less_than_two_decades_has_more_numbers_than_powers_of_ten(ratio, plain):
    """With a twentieth of the data's span to either side, ends are a hundredfold apart where data are 65.8-fold."""
    pair = ("omega", "influenced_dof", "radiating_dof")
    values = np.array([200.0, 200.0 * ratio]).reshape(2, 1, 1)
    database = xr.Dataset(
        {"added_mass": (pair, values), "radiation_damping": (pair, values), "added_mass_inf": (pair[1:], [[200.0]])},
        {"omega": [1.0, 2.0], "influenced_dof": ["Heave"], "radiating_dof": ["Heave"]},
    )
    figure = added_mass_damping(data(database=database))
    figure.draw_without_rendering()
    told = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert ("500" in told, any("10^" in text for text in told)) == (plain, not plain)


@pytest.mark.parametrize(
    ("labels", "shown"),
    [
        (["Pitch"], ["Pitch\n[10³ kg m²/s²]"]),
        (["a__Pitch", "Bend", "a__Heave"], ["a__Heave\n[10³ kg/s²]", "Bend\n[10³ kg/s²]"]),
        (["Mode7", "Heave", "Mode8", "Surge"], ["Heave\n[10³ kg/s²]", "Surge\n[10³ kg/s²]", "Mode7\n[10³ kg/s²]"]),
    ],
)
def test_kernels_are_of_displacements_and_of_rotations_where_there_are_no_others(labels, shown):
    """A flap has its pitch alone; motions of one of several bodies are known by their names, too."""
    time, pair = np.linspace(0.0, 5.0, 11), ("influenced_dof", "radiating_dof")
    values = (("time", *pair), np.exp(-time)[:, None, None] * np.ones((len(labels), len(labels))))
    kernel = xr.Dataset({"kernel": values, "kernel_state_space": values}, dict.fromkeys(pair, labels) | {"time": time})
    assert [ax.get_ylabel() for ax in radiation_kernel(data(radiation=kernel)).axes] == shown


@pytest.mark.parametrize(
    ("labels", "turns"), [(["Heave"], False), (["Heave", "b__Roll"], True), (["Yaw"], True), (["Pitch", "Bend"], True)]
)
def test_coefficients_beside_those_of_rotations_say_so(labels, turns):
    value = (("omega", "influenced_dof", "radiating_dof"), np.ones((2, len(labels), len(labels))))
    coords = {"omega": [0.0, 1.0], "influenced_dof": labels, "radiating_dof": labels}
    database = xr.Dataset({"added_mass": value, "radiation_damping": value}, coords=coords)
    database["added_mass_inf"] = database.added_mass.isel(omega=0)
    for ax in added_mass_damping(data(database=database)).axes:
        assert ("of rotations" in ax.get_ylabel()) == turns


@pytest.mark.parametrize(("last", "first"), [(0.7, 0.3), (0.5, 0.06)])
def test_a_band_below_that_of_seas_is_shown_whole(last, first):
    """Of a body of hundreds of metres: what is left above 0.3 rad/s would be nothing, or next to nothing."""
    omega = np.linspace(0.06, last, 50)
    power = (("design", "omega"), np.array([1e3 * omega, 2e3 * omega]))
    response = xr.Dataset(
        {"best_power": power, "absorbed_power": power, "power_limit": ("omega", 1 / omega)},
        coords={"design": ["FSB", "VSWEC"], "omega": omega},
    )
    (top, *_) = absorbed_power(data(response=response, wave_frequencies=())).axes
    assert top.get_xlim() == pytest.approx((first, last))
    assert np.isfinite(top.get_ylim()).all()
    assert useful_band(response.best_power).values.tolist() == (omega >= max(first, 0.05 * last)).tolist()


def test_a_study_of_several_waves_marks_them_all_and_one_of_none_none(responding):
    for waves, label in (((2.5, 1.0), "study's waves"), ((1.0,), "study's wave"), ((), None)):
        figure = absorbed_power(data(response=responding.response, wave_frequencies=waves))
        for ax in figure.axes[:4]:
            marks = [line for line in ax.get_lines() if str(line.get_label()).startswith("study's")]
            assert [(line.get_label(), tuple(line.get_xdata())) for line in marks] == (
                [(label, waves)] if waves else []
            )


def test_of_tuned_designs_powers_are_drawn_at_their_own_best_dampers_alone(responding):
    for tuned, titles in ((True, ["each at its own best damper", ""]), (False, 1)):
        figure = absorbed_power(data(response=responding.response, tuned=tuned, limit="limit 2 λ/2π"))
        found = [ax.get_title() for ax in figure.axes]
        assert found == (titles if tuned else ["each at its own best damper", "all at the given damper", "", ""])
        assert "limit 2 λ/2π" in {line.get_label() for line in figure.axes[0].get_lines()}


@pytest.mark.parametrize(
    ("gains", "ends"),
    [((0.0, 0.0), (-20, 20)), ((-0.4, 0.6), (-46, 69)), ((-0.95, 0.1), (-100, 20)), ((0.1, 4.0), (-20, 250))],
)
def test_an_axis_of_gains_reaches_a_little_beyond_the_least_and_the_most(gains, ends):
    """At own best dampers one, at the given one the other; never beyond -100 and 250 %."""
    shape = 1e3 * np.exp(-((OMEGA - 2.0) ** 2))
    power = [(("design", "omega"), np.array([shape, (1 + gain) * shape])) for gain in gains]
    for best, given in (power, power[::-1]):
        response = xr.Dataset(
            {"best_power": best, "absorbed_power": given, "power_limit": ("omega", 5e3 / OMEGA)},
            {"design": ["FSB", "VSWEC"], "omega": OMEGA},
        )
        ax = absorbed_power(data(response=response)).axes[2]
        assert ax.get_ylim() == pytest.approx(ends)
        assert ax.get_ylabel() == "gain over FSB [%]"


def test_gains_over_a_rigid_design_that_takes_nothing_at_some_wave_are_not_drawn(responding):
    response = responding.response.copy(deep=True)
    response.absorbed_power[0, 300] = 0.0
    best, given = absorbed_power(data(response=response)).axes[2:4]
    assert [text.get_text() for text in given.texts] == ["no absorbed power to compare with"]
    assert not best.texts


def test_an_axis_of_reactances_holds_those_of_the_band_shown_and_resistances_of_nothing_have_none(responding):
    """Half as much again as the largest, however it is signed; beyond the band shown it may be a thousand."""
    omega = OMEGA
    quality = np.where(omega > 4.0, 1e3, 6.0 - omega)
    impedance = np.array([1.0 + 1j * quality, 2.0 - 2j * quality])
    impedance[1, 250] = -1.0 + 50.0j
    response = responding.response.assign(port_impedance=(("design", "omega"), impedance))
    figure = reactance(data(response=response))
    top, bottom = figure.axes
    low, high = top.get_xlim()
    assert top.get_ylim() == pytest.approx((0.05, 1.5 * quality[(omega > low) & (omega < high)].max()))
    drawn_ = {line.get_label(): np.asarray(line.get_ydata(), dtype=float) for line in top.get_lines()}
    assert np.flatnonzero(np.isnan(drawn_["VSWEC"])).tolist() == [250]
    np.testing.assert_allclose(np.delete(drawn_["VSWEC"], 250), np.delete(quality, 250))
    assert (bottom.get_ylim(), top.get_yscale()) == ((0.0, 1.02), "log")


@pytest.mark.parametrize(("last", "end"), [(5.0, 5.0), (40.0, 12.0)])
def test_kernels_are_shown_to_twelve_seconds_at_most(last, end):
    time, pair = np.linspace(0.0, last, 11), ("influenced_dof", "radiating_dof")
    values = (("time", *pair), np.exp(-time)[:, None, None] * np.ones((1, 1)))
    kernel = xr.Dataset(
        {"kernel": values, "kernel_state_space": values}, {"time": time, **{dim: ["Heave"] for dim in pair}}
    )
    assert radiation_kernel(data(radiation=kernel)).axes[0].get_xlim() == (0.0, end)


def test_rotations_are_drawn_in_degrees_and_displacements_in_metres():
    time, labels = np.linspace(0.0, 1.0, 5), ["Heave", "Pitch", "Surge"]
    position = xr.DataArray(np.outer(time, [1.0, np.pi, -2.0]), {"time": time, "dof": labels}, ("time", "dof"))
    runs = {(design, "w"): xr.Dataset({"position": k * position}) for k, design in enumerate(("FSB", "VSWEC"))}
    figure = directions(data(runs=runs, periods={"w": 1.0}), "w")
    assert [ax.get_ylabel() for ax in figure.axes] == ["surge [m]", "heave [m]", "pitch [degrees]"]
    for ax, end in zip(figure.axes, (-2.0, 1.0, 180.0), strict=True):
        rigid, shell = (line.get_ydata() for line in ax.get_lines())
        assert (rigid[-1], shell[-1]) == pytest.approx((0.0, end))


def test_an_audit_has_the_terms_all_designs_have_by_their_names():
    """What drag took in one design alone is no bar; nothing is given up where all of it was got."""
    terms = ["pto", "radiated", "structural", "drag", "stored", "wave"]
    run = xr.Dataset(
        {"energy": (("time", "term"), 1e3 * np.array([[1.0, 2.0, 3.0, 4.0, 5.0, 15.0]]))},
        {"term": terms, "time": [1.0]},
    )
    for other, names in (
        (run, ["power take-off", "radiated", "structural damping", "drag", "stored"]),
        (run.drop_sel(term="drag"), ["power take-off", "radiated", "structural damping", "stored"]),
    ):
        for runs in ((run, other), (other, run)):
            figure = energy_audit(data(runs=dict(zip([("FSB", "w"), ("VSWEC", "w")], runs, strict=True))), "w")
            (ax,) = figure.axes
            assert [bars.get_label() for bars in ax.containers] == names
            assert ax.get_xlabel() == "energy over the run [kJ]"
            assert [label.get_text() for label in ax.get_yticklabels()] == ["FSB", "VSWEC"]
            assert ax.yaxis_inverted()


@pytest.mark.parametrize(
    ("waves", "ends"),
    [((), (0.3, 4.5)), ((1.0, 5.2, 0.15), (0.15, 5.2)), ((2.0, 5.2), (0.3, 5.2)), ((0.15,), (0.15, 4.5))],
)
def test_the_band_shown_reaches_over_what_any_design_absorbs_and_all_waves(waves, ends):
    """The first design absorbs most, and nothing above 3 rad/s; the others a fiftieth of it up to 4.5 rad/s."""
    omega = np.linspace(0.1, 6.0, 60)
    first = np.where(omega <= 3.0, 50.0, 0.0)
    others = [np.where(omega <= last + 1e-9, 1.0, 0.4) for last in (4.5, 4.0)]
    power = (("design", "omega"), np.array([first, *others]))
    response = xr.Dataset({"absorbed_power": power}, {"design": ["FSB", "VSWEC", "C"], "omega": omega})
    assert _band(data(response=response, wave_frequencies=waves)) == pytest.approx(ends)


def test_of_what_no_design_absorbs_the_whole_band_is_shown():
    power = (("design", "omega"), np.zeros((2, 60)))
    response = xr.Dataset({"absorbed_power": power}, {"design": ["FSB", "VSWEC"], "omega": np.linspace(0.1, 6.0, 60)})
    assert _band(data(response=response)) == pytest.approx((0.3, 6.0))


def test_powers_and_their_limit_are_kilowatts_and_gains_per_cent_of_the_same_dampers():
    """What is taken beyond the band shown, above 4 rad/s, raises no axis; of best dampers more is gained."""
    shape = np.exp(-((OMEGA - 2.0) ** 2))
    given = 1e3 * np.array([shape, 1.5 * shape])
    best = np.where(OMEGA > 5.0, 9e4, 2e3 * np.array([shape, 1.2 * shape]))
    pairs = {name: (("design", "omega"), values) for name, values in (("absorbed_power", given), ("best_power", best))}
    response = xr.Dataset(
        {**pairs, "power_limit": ("omega", 5e3 / OMEGA)}, {"design": ["FSB", "VSWEC"], "omega": OMEGA}
    )
    figure = absorbed_power(data(response=response, wave_frequencies=()))
    left, right, *gains = figure.axes[:4]
    for ax, power in ((left, best), (right, given)):
        limit, *designs = ax.get_lines()
        np.testing.assert_allclose(limit.get_ydata(), 5 / OMEGA)
        np.testing.assert_allclose([line.get_ydata() for line in designs], power / 1e3)
        assert [line.get_label() for line in ax.get_lines()] == ["limit λ/2π", "FSB", "VSWEC"]
    low, high = left.get_xlim()
    assert high < 5.0
    shown = (low < OMEGA) & (high > OMEGA)
    assert left.get_ylim() == pytest.approx((0.0, 1.25 * best[:, shown].max() / 1e3))
    for ax, power, gain in zip(gains, (best, given), (20.0, 50.0), strict=True):
        (line,) = (one for one in ax.get_lines() if one.get_label() == "VSWEC")
        drawn_gain = np.asarray(line.get_ydata(), dtype=float)
        useful = useful_band(xr.DataArray(power, {"design": ["FSB", "VSWEC"], "omega": OMEGA})).values
        np.testing.assert_array_equal(~np.isnan(drawn_gain), useful)
        np.testing.assert_allclose(drawn_gain[useful & (OMEGA < 5.0)], gain)
        assert line.get_color() == "#D55E00"
        assert 0.0 in [one.get_ydata()[0] for one in ax.get_lines()]


def test_the_share_of_the_limit_is_that_of_a_damper_alone():
    """A damper c = |Z| takes 4 R c/|R + iX + c|^2 of what matching takes."""
    impedance = np.array([1.0 + 1j * (OMEGA - 2.0), 3.0 - 4j * OMEGA])
    power = (("design", "omega"), np.ones((2, len(OMEGA))))
    response = xr.Dataset(
        {"port_impedance": (("design", "omega"), impedance), "absorbed_power": power},
        {"design": ["FSB", "VSWEC"], "omega": OMEGA},
    )
    top, bottom = reactance(data(response=response)).axes[:2]
    c = np.abs(impedance)
    lines = {line.get_label(): line.get_ydata() for line in bottom.get_lines()}
    np.testing.assert_allclose([lines["FSB"], lines["VSWEC"]], 4 * impedance.real * c / np.abs(impedance + c) ** 2)
    lines = {line.get_label(): line.get_ydata() for line in top.get_lines()}
    np.testing.assert_allclose([lines["FSB"], lines["VSWEC"]], np.abs(impedance.imag) / impedance.real)


def moving(**more):
    """Runs of two designs in two seas: every motion, velocity and force is told from every other."""
    time, runs = np.linspace(0.0, 10.0, 11), {}
    for i, (design, sea) in enumerate((d, w) for d in ("FSB", "VSWEC") for w in ("a-b", "w")):
        own = np.array([1.0, 10.0, 100.0]) * (i + 1)
        values = {name: (("time", "dof"), k * np.outer(1 + time, own)) for k, name in enumerate(more, 1)}
        energy = (("time", "term"), 1e3 * (i + 1) * np.outer(time, [1.0, 7.0]))
        coords = {"time": time, "dof": ["Heave", "Surge", "Bend"], "term": ["pto", "wave"]}
        runs[design, sea] = xr.Dataset({**values, "energy": energy}, coords)
    return data(runs=runs, periods={"a-b": 0.2, "w": 5.0}, window=(4.0, 8.0))


def test_power_is_that_of_all_motions_in_the_window_and_energy_of_the_whole_run():
    """P = -F.v; a sea's name may have dashes, and is that of its own runs and of its own fifteen periods."""
    given = moving(pto=None, velocity=None)
    for wave, window in (("a-b", (5.0, 8.0)), ("w", (4.0, 8.0))):
        top, bottom = draw(f"power_energy-{wave}", given).axes
        for line, below, design in zip(top.get_lines(), bottom.get_lines(), ("FSB", "VSWEC"), strict=True):
            run = given.runs[design, wave]
            inside = (run.time.values >= window[0]) & (run.time.values <= window[1])
            power = -(run.pto.values * run.velocity.values).sum(axis=1)[inside] / 1e3
            np.testing.assert_allclose(line.get_xydata(), np.stack([run.time.values[inside], power], axis=1))
            energy = run.energy.values[:, 0] / 1e3
            np.testing.assert_allclose(below.get_xydata(), np.stack([run.time.values, energy], axis=1))
            assert line.get_label() == below.get_label() == design
        assert (top.get_xlim(), bottom.get_xlim()) == (pytest.approx(window), (0.0, 10.0))
        labels = ("absorbed power [kW]", "time [s]", "absorbed energy [kJ]", "time [s]")
        assert (top.get_ylabel(), top.get_xlabel(), bottom.get_ylabel(), bottom.get_xlabel()) == labels


@pytest.mark.parametrize(
    ("name", "first", "second"),
    [("heave_excitation", "position", "excitation"), ("velocity_pto", "velocity", "pto")],
)
def test_motion_and_force_of_the_papers_figures_are_those_of_heave(name, first, second):
    given = moving(**dict.fromkeys(("position", "velocity", "excitation", "pto")))
    top, bottom = draw(f"{name}-w", given).axes
    for ax, quantity, unit in ((top, first, 1.0), (bottom, second, 1e3)):
        for line, design in zip(ax.get_lines(), ("FSB", "VSWEC"), strict=True):
            run = given.runs[design, "w"].sel(time=slice(4.0, 8.0))
            np.testing.assert_allclose(line.get_ydata(), run[quantity].isel(dof=0) / unit)
    force = "power take-off force [kN]" if second == "pto" else "excitation force [kN]"
    motion = "heave velocity [m/s]" if second == "pto" else "heave [m]"
    assert (top.get_ylabel(), bottom.get_ylabel()) == (motion, force)


def test_a_motion_has_a_panel_if_any_design_moves_in_it_in_that_very_sea():
    time, labels = np.linspace(0.0, 1.0, 5), ["Heave", "Surge", "Pitch"]

    def run(*moved):
        return xr.Dataset(
            {"position": xr.DataArray(np.outer(time, moved), {"time": time, "dof": labels}, ("time", "dof"))}
        )

    runs = {
        ("FSB", "w"): run(1.0, 0.0, 0.0), ("VSWEC", "w"): run(1.0, 0.0, 0.5),
        ("FSB", "v"): run(1.0, 2.0, 0.0), ("VSWEC", "v"): run(1.0, 0.0, 0.0),
    }  # fmt: skip
    given = data(runs=runs, periods={"w": 1.0, "v": 1.0})
    for wave, shown in (("w", ["heave [m]", "pitch [degrees]"]), ("v", ["surge [m]", "heave [m]"])):
        assert [ax.get_ylabel() for ax in directions(given, wave).axes] == shown


def test_bars_of_an_audit_stand_end_to_end_on_their_own_side_of_nothing():
    """What is got goes to the right, what is given up to the left, in the order of the terms; the wave's work beside."""
    terms = ["pto", "radiated", "structural", "stored", "wave"]
    final = {"FSB": [24.0, -3.0, 2.0, -7.0, 16.0], "VSWEC": [-5.0, 10.0, 4.0, 6.0, 15.0]}
    runs = {
        (design, "w"): xr.Dataset(
            {"energy": (("time", "term"), 1e3 * np.array([np.full(5, 99.0), values]))},
            {"time": [0.0, 1.0], "term": terms},
        )
        for design, values in final.items()
    }
    (ax,) = energy_audit(data(runs=runs), "w").axes
    found = [
        [(bar.get_x(), bar.get_width(), round(bar.get_y() + bar.get_height() / 2)) for bar in bars]
        for bars in ax.containers
    ]
    assert [bars.get_label() for bars in ax.containers] == [
        "power take-off",
        "radiated",
        "structural damping",
        "stored",
    ]
    assert found == [
        [(0.0, 24.0, 0), (0.0, -5.0, 1)], [(0.0, -3.0, 0), (0.0, 10.0, 1)],
        [(24.0, 2.0, 0), (10.0, 4.0, 1)], [(-3.0, -7.0, 0), (14.0, 6.0, 1)],
    ]  # fmt: skip
    (work,) = (line for line in ax.get_lines() if line.get_label() == "work of the wave")
    assert (list(work.get_xdata()), list(work.get_ydata())) == ([16.0, 15.0], [0, 1])
    assert "stored below 0" in ax.get_xlabel()


def test_kernels_are_thousands_of_their_units_convolved_and_as_a_state_space():
    time, pair = np.linspace(0.0, 5.0, 11), ("influenced_dof", "radiating_dof")
    sizes = np.array([[2e3, 5.0], [7.0, 3e3]])
    kernels = {
        name: (("time", *pair), factor * np.exp(-time)[:, None, None] * sizes)
        for name, factor in (("kernel", 1.0), ("kernel_state_space", 1.1))
    }
    kernel = xr.Dataset(kernels, {"time": time, **{dim: ["Bend", "Heave"] for dim in pair}})
    for ax, size in zip(radiation_kernel(data(radiation=kernel)).axes, (3.0, 2.0), strict=True):
        whole, states = ax.get_lines()
        np.testing.assert_allclose(whole.get_ydata(), size * np.exp(-time))
        np.testing.assert_allclose(states.get_ydata(), 1.1 * size * np.exp(-time))
        assert (whole.get_label(), states.get_label()) == ("convolution kernel", "state space")


@pytest.mark.filterwarnings("error")
def test_where_the_rigid_design_takes_nothing_at_one_tuning_gains_of_the_other_have_their_axis(responding):
    """Nothing is divided by what it takes at the given damper."""
    given = responding.response.absorbed_power.copy()
    given[0] = 0.0
    best, other = absorbed_power(data(response=responding.response.assign(absorbed_power=given))).axes[2:4]
    assert [text.get_text() for text in other.texts] == ["no absorbed power to compare with"]
    (gain,) = (line.get_ydata() for line in best.get_lines() if line.get_label() == "VSWEC")
    assert best.get_ylim() == pytest.approx((-20.0, 1.15 * np.nanmax(gain)))
    assert np.nanmax(gain) < 100


def test_an_axis_of_reactances_has_its_bounds_where_there_are_hardly_any(responding):
    impedance = (("design", "omega"), np.full((2, len(OMEGA)), 1 + 1e-3j))
    top, bottom = reactance(data(response=responding.response.assign(port_impedance=impedance))).axes[:2]
    assert top.get_ylim() == pytest.approx((0.05, 0.15))
    for ax in (top, bottom):
        assert "study's wave" in [line.get_label() for line in ax.get_lines()]
    assert [line.get_ydata()[0] for line in bottom.get_lines()[:2]] == pytest.approx([1.0, 1.0], abs=1e-6)


@pytest.mark.parametrize("stored", [(-7.0, 3.0), (3.0, -7.0), (3.0, 4.0)])
def test_what_any_design_gave_up_is_told(stored):
    runs = {
        (design, "w"): xr.Dataset(
            {"energy": (("time", "term"), 1e3 * np.array([[5.0, own, 5.0 + own]]))},
            {"time": [1.0], "term": ["pto", "stored", "wave"]},
        )
        for design, own in zip(("FSB", "VSWEC"), stored, strict=True)
    }
    (ax,) = energy_audit(data(runs=runs), "w").axes
    assert ("given up by the motion it started with" in ax.get_xlabel()) == (min(stored) < 0)


def test_an_axis_of_gains_leaves_out_those_beyond_the_band_shown_and_those_of_no_use(responding):
    """At their best dampers designs take more of waves that the given one leaves, and gain most there."""
    best = np.array([np.exp(-8 * (OMEGA - 2.0) ** 2), np.exp(-40 * (OMEGA - 5.5) ** 2), 1e-3 * np.ones_like(OMEGA)])
    gained = [best.sum(0), np.array([1.4, 3.0, 2.0]) @ best]
    given = np.array([1.0, 0.6])[:, None] * np.exp(-8 * (OMEGA - 2.0) ** 2)
    pair = ("design", "omega")
    response = responding.response.assign(best_power=(pair, 1e3 * np.array(gained)), absorbed_power=(pair, 1e3 * given))
    for ax in absorbed_power(data(response=response)).axes[2:4]:
        assert ax.get_ylim() == pytest.approx((1.15 * -40.0, 1.15 * 40.0), abs=1.0)
