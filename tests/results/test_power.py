import numpy as np
import pytest
import xarray as xr
from conftest import varied

from vsb.errors import ConfigError
from vsb.motion.port import Port
from vsb.results.power import (
    apart,
    averaging_window,
    damper_of,
    energy_flux,
    in_direction,
    lead,
    merit,
    power_response,
)
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
    assert found.power_mean == pytest.approx(200.0, rel=1e-8)  # over whole periods, whatever the window
    assert found.energy == pytest.approx(100 * 4 * 20.0, rel=1e-6)
    assert found.capture_width == pytest.approx(200.0 / (1025 * 9.81**2 * 0.25 / (4 * np.pi / 2)), rel=1e-8)


@pytest.mark.parametrize("spring", [900.0, -900.0, 0.0])
def test_linear_power_of_a_damper_that_was_tuned_is_what_its_port_gives_beside_the_spring(seed, spring):
    omega = np.array([0.8, 1.6, 2.4])
    port = Port(omega, 1 / np.array([2e3 + 5e3j, 3e3 - 1e3j, 1e3 - 8e3j]), np.array([1.0 + 1j, 0.5j, -0.3]), 1e-4)
    dims = ("design", "omega")
    values = {"port_impedance": port.impedance, "port_velocity": port.velocity, "absorbed_power": port.power(1.0)}
    response = xr.Dataset({k: (dims, v[None]) for k, v in values.items()}, {"design": ["A"], "omega": omega})
    study = varied(seed, pto={"damping": 8000.0, "stiffness": spring})
    found = power_response(study, response, "A", {TUNED: 4e3})
    assert found.values == pytest.approx(port.power(4e3, spring), rel=1e-12)
    assert power_response(study, response, "A", {}).values == pytest.approx(port.power(1.0))


def test_capture_width_of_the_limit_is_a_wavelength_over_two_pi():
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
        ((2e-9, 8.0), (0.0, 8.0)),  # a period less by round-off is one
        ((2e-8, 8.0), (4.0, 8.0)),
    ],
)
def test_means_are_over_whole_periods_at_the_end(window, expected):
    assert averaging_window(WAVE, window) == pytest.approx(expected)
    assert averaging_window(StillWater(kind="still"), window) == window


def test_a_take_off_that_drives_absorbs_at_no_instant():
    run = harmonic_run()
    driven = run.assign(pto=-run.pto, energy=-run.energy)
    found = merit(driven, WAVE, regular(WAVE), Water(), (21.0, 39.9))
    assert found.power_peak == pytest.approx(0.0, abs=1e-3)
    assert found.power_mean == pytest.approx(-200.0, rel=1e-8)


@pytest.mark.parametrize(("beyond", "swing"), [(5e-10, 4.0), (2e-9, 2.0)])
def test_instants_at_the_ends_of_a_window_are_in_it_but_for_round_off(beyond, swing):
    """Positions 2, 1, -1, -2 at whole seconds; a window from the first to the last, short of them by so much."""
    motion = ("time", "dof")
    run = xr.Dataset(
        {
            "position": (motion, np.array([[2.0], [1.0], [-1.0], [-2.0]])),
            "velocity": (motion, np.zeros((4, 1))),
            "pto": (motion, np.zeros((4, 1))),
            "energy": (("time", "term"), np.zeros((4, 1))),
        },
        coords={"time": np.arange(4.0), "dof": ["Heave"], "term": ["pto"]},
    )
    still = Sea(np.zeros(0), np.zeros(0, dtype=complex))
    for window, least in (((beyond, 3.0), 3.0), ((0.0, 3.0 - beyond), 3.0)):
        found = merit(run, StillWater(kind="still"), still, Water(), window).displacement_pp
        assert found == pytest.approx(4.0 if swing == 4.0 else least)


def test_powers_of_round_off_are_none_and_others_are_compared():
    assert apart(3e-9, 0.9e-9) == 3e-9
    assert apart(3.3e-9, 1.1e-9) == pytest.approx(2.0)
    assert apart(99.0, -100.0) == pytest.approx(1.99)


@pytest.mark.parametrize("order", [(0.0, 30.0, 90.0), (30.0, 0.0, 90.0), (90.0, -330.0, 0.0)])
def test_a_response_is_found_by_its_direction_in_whatever_order(order):
    """Full turns left out; in still water any will do, and none is taken for another."""
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


def test_a_sea_over_a_sea_bed_brings_energy_at_its_own_speed():
    """Every wave at its group velocity there, in water of its own density and gravity."""
    water, omega = Water(density=900.0, gravity=9.0, depth=6.0), np.array([0.5, 0.9])
    sea = Sea(omega, np.array([0.3 + 0.4j, 0.2j]))
    speeds = [group_velocity(w, 6.0, 9.0) for w in omega]
    expected = 0.5 * 900.0 * 9.0 * (0.25 * speeds[0] + 0.04 * speeds[1])
    assert energy_flux(sea, water) == pytest.approx(expected, rel=1e-12)


def test_a_run_has_the_damper_it_says_it_was_tuned_to_or_else_the_one_given(seed):
    study = varied(seed, pto={"damping": {name: 1e3 * (i + 1) for i, name in enumerate(seed.designs)}})
    second = list(seed.designs)[1]
    assert (damper_of(study, second, {}), damper_of(study, second, {TUNED: 70.0})) == (2e3, 70.0)
    assert damper_of(study, second, {TUNED: 0.0}) == 0.0
    assert damper_of(varied(seed, pto={"damping": None, "tuning": "each"}), second, {}) == 0.0


def test_a_port_that_does_not_move_gives_a_tuned_damper_nothing(seed):
    """Its impedance counts as 0, beside which a damper of 0 would be nothing over nothing."""
    response = xr.Dataset(
        {name: (("design", "omega"), np.zeros((1, 2), dtype=complex)) for name in ("port_impedance", "port_velocity")}
    ).assign(absorbed_power=(("design", "omega"), np.zeros((1, 2))))
    response = response.assign_coords(design=["A"], omega=[1.0, 2.0])
    for damper in (0.0, 4e3):
        assert power_response(seed, response, "A", {TUNED: damper}).values.tolist() == [0.0, 0.0]


def of_a_body(absorbed=True):
    """Surge and pitch of a body whose port is something else, and dampers at both, one of which drives."""
    time, w = np.linspace(0.0, 40.0, 4001), np.pi / 2
    v = np.stack([np.cos(w * time), 3.0 * np.cos(w * time)], axis=1)
    force = np.stack([-100.0 * v[:, 0], 10.0 * v[:, 1]], axis=1)  # 100 W in, at most, 90 W out
    motion = ("time", "dof")
    run = xr.Dataset(
        {
            "position": (motion, v), "velocity": (motion, v), "pto": (motion, force),
            "stroke": ("time", 0.2 * np.sin(w * time) - 0.01 * (time < 10)), "stroke_rate": ("time", 0.7 * np.cos(w * time) - 0.3 * (time < 10)),
            "energy": (("time", "term"), np.stack([0.0 * time, 7.0 * time - 1.0], axis=1)),
        },
        {"time": time, "dof": ["Surge", "Pitch"], "term": ["waves", "pto"]},
    )  # fmt: skip
    return run if absorbed else run.drop_vars("pto")


def test_a_body_is_told_by_its_port_and_all_that_its_take_off_does():
    """Stroke and its rate within the window alone, power over all motions, energy of the take-off to the end."""
    found = merit(of_a_body(), WAVE, regular(WAVE), Water(), (21.0, 33.9))
    assert (found.displacement_pp, found.velocity_pp) == (pytest.approx(0.4, rel=1e-6), pytest.approx(1.4, rel=1e-6))
    assert found.power_peak == pytest.approx(10.0, rel=1e-6)
    assert (found.power_mean, found.energy) == (pytest.approx(7.0, rel=1e-9), pytest.approx(279.0))
    assert merit(of_a_body(absorbed=False), WAVE, regular(WAVE), Water(), (21.0, 33.9)).power_peak == 0.0


def test_a_window_between_two_instants_of_the_record_is_refused():
    with pytest.raises(
        ConfigError,
        match=r"simulation\.window: received \[20\.001, 20\.009\] s, which holds none of the instants recorded, 0\.01 s "
        r"apart; needs to be longer than that",
    ):
        merit(of_a_body(), WAVE, regular(WAVE), Water(), (20.001, 20.009))


def test_a_run_is_told_by_heave_among_other_motions_where_nothing_else_leads():
    time, motion = np.arange(3.0), ("time", "dof")
    position, velocity = np.arange(6.0).reshape(3, 2), -np.arange(6.0).reshape(3, 2)
    run = xr.Dataset({"position": (motion, position), "velocity": (motion, velocity)}, {"time": time})
    assert [values.tolist() for values in lead(run)] == [[0.0, 2.0, 4.0], [0.0, -2.0, -4.0]]
    ported = run.assign(stroke=("time", [7.0, 8.0, 9.0]), stroke_rate=("time", [1.0, 3.0, 5.0]))
    assert [values.tolist() for values in lead(ported)] == [[7.0, 8.0, 9.0], [1.0, 3.0, 5.0]]
