"""Every curve is the quantity its axis names, in the unit the axis states."""

import re

import numpy as np
import pytest
import xarray as xr

from vsb.report.canvas import StudyData
from vsb.report.figures import draw

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
