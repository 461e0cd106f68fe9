"""What figures show, and what they leave out."""

import numpy as np
import pytest
import xarray as xr

from vsb.report.band import USEFUL, useful_band
from vsb.report.canvas import StudyData
from vsb.report.figures import absorbed_power, added_mass_damping, directions, energy_audit, radiation_kernel, reactance
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


@pytest.mark.parametrize(("labels", "turns"), [(["Heave"], False), (["Heave", "b__Roll"], True), (["Yaw"], True)])
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
