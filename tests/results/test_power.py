"""Figures of a run: absorbed power, energy, capture width, averaging, wave directions."""

import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.errors import ConfigError
from vsb.motion.port import Port
from vsb.results.power import averaging_window, energy_flux, in_direction, merit, power_response
from vsb.scenes.build import TUNED
from vsb.study.study import RegularWave, StillWater, Water
from vsb.waves.dispersion import group_velocity, power_limit
from vsb.waves.seas import Sea, regular

WAVE = RegularWave(kind="regular", amplitude=0.5, period=4.0)


def harmonic_run(velocity=2.0, damping=100.0, period=4.0):
    """Heave velocity 2 cos(wt) on a damper of 100 N s/m, with its exact absorbed energy."""
    time = np.linspace(0.0, 40.0, 4001)
    w = 2 * np.pi / period
    v = velocity * np.cos(w * time)
    energy = damping * velocity**2 * (time / 2 + np.sin(2 * w * time) / (4 * w))
    motion = ("time", "dof")
    return xr.Dataset(
        {
            "position": (motion, velocity / w * np.sin(w * time)[:, None]),
            "velocity": (motion, v[:, None]),
            "pto": (motion, -damping * v[:, None]),
            "energy": (("time", "term"), energy[:, None]),
        },
        coords={"time": time, "dof": ["Heave"], "term": ["pto"]},
    )


def test_harmonic_motion_in_closed_form():
    found = merit(harmonic_run(), WAVE, regular(WAVE), Water(), (21.0, 39.9))
    assert found.displacement_pp == pytest.approx(2 * 2.0 / (np.pi / 2), rel=1e-5)
    assert found.velocity_pp == pytest.approx(4.0, rel=1e-5)
    assert found.power_peak == pytest.approx(400.0, rel=1e-5)
    assert found.power_mean == pytest.approx(200.0, rel=1e-8)  # over whole periods
    assert found.energy == pytest.approx(100 * 4 * 20.0, rel=1e-6)
    assert found.capture_width == pytest.approx(200.0 / (1025 * 9.81**2 * 0.25 / (4 * np.pi / 2)), rel=1e-8)


def test_linear_power_of_a_tuned_damper(seed):
    omega = np.array([0.8, 1.6, 2.4])
    port = Port(omega, 1 / np.array([2e3 + 5e3j, 3e3 - 1e3j, 1e3 - 8e3j]), np.array([1.0 + 1j, 0.5j, -0.3]), 1e-4)
    dims = ("design", "omega")
    values = {"port_impedance": port.impedance, "port_velocity": port.velocity, "absorbed_power": port.power(1.0)}
    response = xr.Dataset({k: (dims, v[None]) for k, v in values.items()}, {"design": ["A"], "omega": omega})
    study = varied(seed, pto={"damping": 8000.0, "stiffness": -900.0})
    found = power_response(study, response, "A", {TUNED: 4e3})
    assert found.values == pytest.approx(port.power(4e3, -900.0), rel=1e-12)
    assert power_response(study, response, "A", {}).values == pytest.approx(port.power(1.0))


def test_maximum_capture_width_is_the_wavelength_over_two_pi():
    water, omega = Water(), WAVE.omega
    limit = power_limit(omega, np.inf, water.density, water.gravity) * 0.25
    assert limit / energy_flux(regular(WAVE), water) == pytest.approx(9.81 / omega**2)


def test_still_water_has_no_capture_width():
    still = Sea(np.zeros(0), np.zeros(0, dtype=complex))
    assert merit(harmonic_run(), StillWater(kind="still"), still, Water(), (20.0, 40.0)).capture_width is None


@pytest.mark.parametrize(
    ("window", "expected"),
    [
        ((0.0, 9.0), (1.0, 9.0)),
        ((0.0, 8.0), (0.0, 8.0)),
        ((0.0, 3.0), (0.0, 3.0)),
        ((2e-9, 8.0), (0.0, 8.0)),  # within round-off
    ],
)
def test_means_are_taken_over_whole_periods(window, expected):
    assert averaging_window(WAVE, window) == pytest.approx(expected)
    assert averaging_window(StillWater(kind="still"), window) == window


def test_driving_take_off_has_negative_mean_power():
    run = harmonic_run()
    driven = run.assign(pto=-run.pto, energy=-run.energy)
    found = merit(driven, WAVE, regular(WAVE), Water(), (21.0, 39.9))
    assert found.power_peak == pytest.approx(0.0, abs=1e-3)
    assert found.power_mean == pytest.approx(-200.0, rel=1e-8)


@pytest.mark.parametrize("order", [(0.0, 30.0, 90.0), (90.0, -330.0, 0.0)])
def test_response_is_selected_by_wave_direction(order):
    """Modulo 360 degrees; in still water any direction will do."""
    response = xr.Dataset({"power": ("wave_direction", list(order))}, {"wave_direction": np.deg2rad(order)})

    def found(degrees):
        wave = RegularWave(kind="regular", amplitude=1.0, period=5.0, direction=degrees)
        return float(in_direction(response, wave).power) % 360.0

    assert [found(degrees) for degrees in (0.0, 30.0, 90.0, 360.0, -270.0)] == [0.0, 30.0, 90.0, 0.0, 90.0]
    assert float(in_direction(response, StillWater(kind="still")).power) == order[0]
    with pytest.raises(
        ConfigError, match=f"received 45 degrees, needs one of {', '.join(f'{each:g}' for each in order)}$"
    ):
        found(45.0)
    assert in_direction(response.isel(wave_direction=0), StillWater(kind="still")).power == order[0]


def test_energy_flux_uses_the_group_velocity_at_depth():
    water, omega = Water(density=900.0, gravity=9.0, depth=6.0), np.array([0.5, 0.9])
    sea = Sea(omega, np.array([0.3 + 0.4j, 0.2j]))
    speeds = [group_velocity(w, 6.0, 9.0) for w in omega]
    expected = 0.5 * 900.0 * 9.0 * (0.25 * speeds[0] + 0.04 * speeds[1])
    assert energy_flux(sea, water) == pytest.approx(expected, rel=1e-12)
