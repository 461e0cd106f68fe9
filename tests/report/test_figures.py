"""Every curve is the quantity its axis names, in the unit the axis states; every figure has a caption."""

import io
import re

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.report.canvas import PORT, StudyData
from vsb.report.figures import captions, directions, draw, phases
from vsb.report.hydro_figures import added_mass_damping
from vsb.study.figure_names import of_study
from vsb.tools.variables import MOMENT

TIME = np.linspace(0.0, 20.0, 401)
WINDOW = (10.0, 20.0)
PHI = np.linspace(0.0, np.pi, 181)
DESIGNS = ("FSB", "VSWEC")
NONE = xr.Dataset()
MODES = xr.Dataset(
    {
        "radial": (("mode", "colatitude"), [np.ones_like(PHI), np.cos(PHI), np.cos(2 * PHI)]),
        "meridional": (("mode", "colatitude"), [0 * PHI, -np.sin(PHI), np.sin(2 * PHI)]),
        "degree": ("mode", [0, 1, 2]),
        "dry_frequency": ("mode", [51.434, 62.994, 86.824]),
        "static_amplitude": ("mode", [0.0, 0.0, 0.0]),
    },
    {"mode": ["Membrane0", "Membrane1", "Membrane2"], "colatitude": PHI},
    {"radius": 2.0, "centre_height": 0.3},
)
"""A breathing mode, one that moves the shell as a whole, and one more."""


def run(design, scale):
    """Signals without any likeness to each other, in SI units."""
    dofs = ["Heave"] if design == "FSB" else ["Heave", *MODES.mode.values]
    names = ("position", "velocity", "excitation", "froude_krylov", "diffraction", "pto", "radiation")
    sizes = (0.3, 0.7, 2e4, 3e3, 5e2, 6e3, 1e3)
    signals = {
        name: (("time", "dof"), scale * size * np.sin(np.outer(TIME, 1.0 + 0.1 * k + 0.01 * np.arange(len(dofs)))))
        for k, (name, size) in enumerate(zip(names, sizes, strict=True))
    }
    power = scale * np.cos(1.7 * TIME) ** 2
    scalars = {
        "power_absorbed": power,
        "volume": 30 + np.sin(TIME),
        "area": 50 + np.cos(TIME),
        "elevation": 0.2 * np.sin(3 * TIME),
        "stroke": scale * np.sin(1.1 * TIME),
        "stroke_rate": scale * np.cos(1.1 * TIME),
    }
    terms = ["pto", "radiated", "structural", "stored", "wave"]
    energy = (("time", "term"), scale * 1e3 * np.outer(TIME, np.arange(1, 6)))
    plain = {name: ("time", values) for name, values in scalars.items()}
    ds = xr.Dataset({**signals, **plain, "energy": energy}, {"time": TIME, "dof": dofs, "term": terms})
    ds.position.values[:, 1:] *= 0.01
    return ds


def data(**changes):
    runs = {(design, wave): run(design, k + 1) for k, design in enumerate(DESIGNS) for wave in ("w", "still")}
    given = dict.fromkeys(("database", "radiation", "response", "witness"), NONE) | {"modes": MODES, "runs": runs}
    place = {"wave_frequencies": (2.5,), "periods": {"w": 2.5, "still": 2.5}, "window": WINDOW}
    return StudyData(**{"designs": DESIGNS, "reference": "FSB", **place, **given, **changes})


def curve(ax, label):
    """Data of the line of a label."""
    return next(line for line in ax.get_lines() if line.get_label() == label).get_data()


FACTOR = {"kN": 1e3, "kW": 1e3, "kJ": 1e3, "m": 1.0, "m/s": 1.0, "m³": 1.0, "m²": 1.0}
SERIES = {
    "heave_excitation": [
        ("heave [m]", lambda r: r.position[:, 0]),
        ("excitation force [kN]", lambda r: (r.excitation + r.froude_krylov + r.diffraction)[:, 0]),
    ],
    "velocity_pto": [
        ("heave velocity [m/s]", lambda r: r.velocity[:, 0]),
        ("power take-off force [kN]", lambda r: r.pto[:, 0]),
    ],
    "power_energy": [
        ("absorbed power [kW]", lambda r: r.power_absorbed),
        ("absorbed energy [kJ]", lambda r: r.energy[:, 0]),
    ],
    "port_motion": [
        ("port's displacement [m]", lambda r: r.stroke),
        ("port's velocity [m/s]", lambda r: r.stroke_rate),
    ],
    "volume_area": [("enclosed volume [m³]", lambda r: r.volume), ("surface area [m²]", lambda r: r.area)],
}  # fmt: skip


@pytest.mark.parametrize("wave", ["w", "still"])
@pytest.mark.parametrize("name", SERIES)
def test_time_series_are_those_of_the_run(name, wave):
    """Within the window; from the start in still water and for energies."""
    given = data()
    axes = draw(f"{name}-{wave}", given).axes
    assert [ax.get_ylabel() for ax in axes] == [label for label, _ in SERIES[name]]
    for ax, (label, quantity) in zip(axes, SERIES[name], strict=True):
        whole = wave == "still" or "energy" in label
        factor = FACTOR[re.search(r"\[(.*)\]", label).group(1)]
        for design in DESIGNS:
            expected = quantity(given.runs[design, wave]).sel(time=slice(*(TIME[[0, -1]] if whole else WINDOW)))
            x, y = curve(ax, design)
            np.testing.assert_array_equal(x, expected.time)
            np.testing.assert_allclose(factor * np.asarray(y, dtype=float), expected.values, rtol=1e-12, atol=1e-9)


def test_audit_stacks_positive_and_negative_energies_separately():
    given, terms = data(), ["pto", "radiated", "structural", "stored"]
    values = np.array([[0.4, 30.0, 5.0, -8.0], [12.0, 0.3, -0.2, -0.7]])
    for design, ends in zip(DESIGNS, values, strict=True):
        given.runs[design, "w"].energy.loc[{"term": terms}] = np.outer(TIME / TIME[-1], 1e3 * ends)
    bars = draw("energy_audit-w", given).axes[0].patches
    for k, ends in enumerate(values):
        own = [sorted((bar.get_x(), bar.get_x() + bar.get_width())) for bar in bars[k :: len(DESIGNS)]]
        right, left = ([v for v in ends if sign * v > 0] for sign in (1, -1))
        stacked = [
            sorted(pair) for side in (right, left) for pair in zip(np.cumsum([0, *side]), np.cumsum(side), strict=False)
        ]
        assert sorted(own) == pytest.approx(np.array(sorted(stacked)))


OMEGA = np.linspace(0.4, 4.0, 37)


def responding():
    shape = np.exp(-((OMEGA - 2.0) ** 2))
    pair = ("design", "omega")
    best, given = 1e3 * np.array([2 * shape, 3 * shape]), 1e3 * np.array([shape, 1.2 * shape])
    impedance = np.array([3.0 + 4.0j + 0 * OMEGA, 1.0 - 2.0j * OMEGA])
    response = {"best_power": (pair, best), "absorbed_power": (pair, given), "power_limit": ("omega", 9e3 / OMEGA)}
    response["port_impedance"] = (pair, impedance)
    return data(response=xr.Dataset(response, {"design": list(DESIGNS), "omega": OMEGA}))


def test_power_at_optimal_damping_left_and_at_given_damping_right():
    given = responding()
    axes = draw("absorbed_power", given).axes
    for ax, name in ((axes[0], "best_power"), (axes[1], "absorbed_power")):
        for design in DESIGNS:
            np.testing.assert_allclose(curve(ax, design)[1], given.response[name].sel(design=design) / 1e3)
        np.testing.assert_allclose(curve(ax, "limit λ/2π")[1], 9 / OMEGA)
    assert "[kW/m²]" in axes[0].get_ylabel()
    for ax, gain in ((axes[2], 50.0), (axes[3], 20.0)):
        y = np.asarray(curve(ax, "VSWEC")[1], dtype=float)
        assert y[~np.isnan(y)] == pytest.approx(gain)
    assert "[%]" in axes[2].get_ylabel()


def test_share_of_optimal_damping_follows_from_the_reactance():
    """|X|/R of 4/3 leaves 2/(1 + 5/3) = 3/4 of the power of complex-conjugate control."""
    quality, share = draw("reactance", responding()).axes[:2]
    np.testing.assert_allclose(curve(quality, "FSB")[1], 4 / 3)
    np.testing.assert_allclose(curve(share, "FSB")[1], 0.75)
    np.testing.assert_allclose(curve(quality, "VSWEC")[1], 2 * OMEGA)


def test_kernels_are_drawn_in_thousands():
    labels = ["Heave", "Membrane0"]
    dims, own = ("time", "radiating_dof"), np.ones((401, 2))
    kernels = {"kernel": (dims, 5e3 * own), "kernel_state_space": (dims, 7e3 * own)}
    kernel = xr.Dataset(kernels, {"time": TIME, "radiating_dof": labels})
    for ax in draw("radiation_kernel", data(radiation=kernel)).axes:
        assert ax.get_ylabel().endswith("[10³ kg/s²]")
        assert set(curve(ax, "convolution kernel")[1]) == {5.0}
        assert set(curve(ax, "state space")[1]) == {7.0}


DIMS = ("wave_direction", "design", "omega", "dof")
LABELS = ["Surge", "Sway", "Heave", "Pitch", "Bend", PORT]


def raos(headings=(0.0, np.pi / 4), port=2.0):
    """Motions that lag further at higher frequencies, the second design's and heading's by half and a third as much."""
    fading = np.exp(-((OMEGA - 1.5) ** 2)) * np.exp(1j * OMEGA)
    sizes = np.array([0.5, 1e-9, 1.0, 0.1, 3.0, port])
    by_heading, by_design = 1 / (1 + np.arange(len(headings)) / 2), np.array([1.0, 0.5])
    values = np.einsum("h,d,w,k->hdwk", by_heading, by_design, fading, sizes)
    return xr.DataArray(
        values, {"wave_direction": list(headings), "design": list(DESIGNS), "omega": OMEGA, "dof": LABELS}, DIMS
    )


def over_frequency(name, **changes):
    given = responding()
    return draw(name, data(response=given.response, **changes))


def test_response_has_a_row_for_every_motion_and_the_port_and_a_curve_for_every_design_and_heading():
    axes = over_frequency("rao", raos=raos()).axes
    assert [ax.get_ylabel() for ax in axes[:8:2]] == [
        "surge\n[m/m]", "heave\n[m/m]", "pitch\n[degrees/m]", "port's displacement\n[m/m]"
    ]  # fmt: skip
    near = int(np.argmin(abs(OMEGA - 1.5)))
    for row, size in enumerate((0.5, 1.0, np.degrees(0.1), 2.0)):
        size *= abs(raos().values[0, 0, near, 2])
        for label, share in (("FSB, waves to 0°", 1.0), ("VSWEC, waves to 45°", 1 / 3)):
            assert curve(axes[2 * row], label)[1][near] == pytest.approx(share * size)
            assert curve(axes[2 * row + 1], label)[1][near] == pytest.approx(np.degrees(OMEGA[near]))


def test_design_without_a_motion_has_no_phase_of_it_at_several_headings():
    held = raos()
    held.loc[{"design": DESIGNS[1], "dof": "Surge"}] = 0.0
    figure = over_frequency("rao", raos=held)
    figure.savefig(io.BytesIO(), format="svg")
    amplitude, phase = figure.axes[:2]
    assert (len(amplitude.lines), len(phase.lines)) == (4, 2)


def test_of_many_headings_the_excitation_shows_those_of_the_waves():
    headings = np.radians(np.arange(0, 100, 10))
    size = (1e4 * (1 + np.arange(10)))[:, None, None] * np.exp(-OMEGA)[:, None] * np.array([1.0, 2.0, 1e-6, 3.0])
    coords = {"wave_direction": headings, "omega": OMEGA, "influenced_dof": ["Heave", "Pitch", "Roll", "Bend"]}
    database = xr.Dataset({"excitation_force": (("wave_direction", "omega", "influenced_dof"), size + 0j)}, coords)
    axes = over_frequency("excitation", raos=raos(headings=np.radians([0.0, 48.0])), database=database).axes
    assert [ax.get_ylabel() for ax in axes[:6:2]] == ["heave\n[kN/m]", "pitch\n[kN m/m]", "modes\n[kN/m]"]
    assert [line.get_label() for line in axes[0].lines] == ["waves to 0°", "waves to 50°"]
    np.testing.assert_allclose(curve(axes[2], "waves to 50°")[1], 6 * 20 * np.exp(-OMEGA))
    np.testing.assert_allclose(curve(axes[4], "Bend")[1], 30 * np.exp(-OMEGA))


def test_phases_are_continuous_start_in_one_turn_and_leave_out_noise():
    omega = np.linspace(0.0, 4.0, 401)
    shown = omega <= 3.0
    lagging = np.exp(4j * omega)
    opposite = -lagging * np.exp(-1e-9j)  # half a turn from the first, but for noise
    quiet = np.where(omega < 1.0, 1e-6, 1.0) * lagging
    first, second, third = phases([lagging, opposite, quiet], shown)
    np.testing.assert_allclose(first[shown], np.degrees(4 * omega[shown]), atol=1e-9)
    np.testing.assert_allclose(second[shown], first[shown] + 180, atol=1e-6)
    np.testing.assert_allclose(third[shown & (omega >= 1.0)] % 360, first[shown & (omega >= 1.0)] % 360)
    assert np.isnan(third[omega < 1.0]).all()
    assert np.isnan(first[~shown]).all()


def test_coefficients_are_drawn_on_axes_that_fit_them():
    """Zero damping is drawn below the logarithmic axis; a motion that moves no water is left out."""
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


def test_rotations_are_drawn_in_degrees_and_displacements_in_metres():
    time, labels = np.linspace(0.0, 1.0, 5), ["Heave", "Pitch", "Surge"]
    position = xr.DataArray(np.outer(time, [1.0, np.pi, -2.0]), {"time": time, "dof": labels}, ("time", "dof"))
    runs = {(design, "w"): xr.Dataset({"position": k * position}) for k, design in enumerate(("FSB", "VSWEC"))}
    figure = directions(data(runs=runs, periods={"w": 1.0}, window=(0.0, 1.0)), "w")
    assert [ax.get_ylabel() for ax in figure.axes] == ["surge [m]", "heave [m]", "pitch [degrees]"]
    for ax, end in zip(figure.axes, (-2.0, 1.0, 180.0), strict=True):
        rigid, shell = (line.get_ydata() for line in ax.get_lines())
        assert (rigid[-1], shell[-1]) == pytest.approx((0.0, end))


def test_port_that_rotates_is_drawn_in_radians():
    axes = draw("port_motion-w", data(port=MOMENT)).axes
    assert [ax.get_ylabel() for ax in axes] == ["port's rotation [rad]", "port's angular velocity [rad/s]"]


def test_bar_is_half_of_the_range_within_the_window():
    given = data()
    for found in given.runs.values():
        found.position[{"time": 0}] = 50.0
    (ax,) = draw("degrees_of_freedom-w", given).axes
    inside = [given.runs[design, "w"].position.sel(time=slice(*WINDOW)).values for design in DESIGNS]
    assert [bar.get_width() for bar in ax.patches] == pytest.approx(
        [*np.ptp(inside[0], axis=0) / 2, *np.ptp(inside[1], axis=0) / 2]
    )
    assert ax.get_xlabel() == "half of the range in the window [m or rad]"


def test_every_figure_of_a_study_has_a_caption(seed):
    irregular = varied(seed, waves=[{"kind": "jonswap", "hs": 0.5, "tp": 4.0}])
    names = {*of_study(irregular), *of_study(seed.model_copy(update={"motion": "planar"}))}
    assert {"spectra", "directions-regular_A0.179_T2.5"} < names
    assert {name.partition("-")[0] for name in names} <= captions(given=True, body=False).keys()
