"""Figures of merit of runs, what linear theory expects of them, and the table of designs."""

import csv
import io

import numpy as np
import pytest
import xarray as xr
from conftest import SMALL, tables_of, varied
from scipy.interpolate import CubicSpline

import vsb
from vsb.cli import main
from vsb.engine.motion.port import Port
from vsb.engine.waves.kinds import RegularWave, StillWater
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.engine.waves.water import Water, group_velocity, power_limit
from vsb.errors import ConfigError
from vsb.models.build import TUNED
from vsb.pipeline.graph import StudyPlan
from vsb.results.comparison import (
    COLUMNS,
    as_csv,
    averaging_window,
    comparison,
    energy_flux,
    in_direction,
    merit,
    power_response,
    series_csv,
    time_series,
)
from vsb.study.study import parse

WAVE = RegularWave(kind="regular", amplitude=0.5, period=4.0)
STILL = StillWater(kind="still")
CONTRACT = (
    "design,wave,displacement_pp,velocity_pp,power_peak,power_mean,energy,capture_width,energy_gain_percent,"
    "energy_residual,damping,stiffness,power_gain_percent,low,high,power_low,power_high,"
    "record_power_mean,record_power_low,record_power_high,record_start,record_end"
)


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
            "power_absorbed": ("time", damping * v**2),
            "energy": (("time", "term"), energy[:, None]),
        },
        coords={"time": time, "dof": ["Heave"], "term": ["pto"]},
    )


def test_merit_of_harmonic_motion_is_its_closed_form():
    found = merit(harmonic_run(), WAVE, WAVE.realisation(), Water(), (21.0, 39.9))
    assert found.displacement_pp == pytest.approx(2 * 2.0 / (np.pi / 2), rel=1e-5)
    assert found.velocity_pp == pytest.approx(4.0, rel=1e-5)
    assert found.power_peak == pytest.approx(400.0, rel=1e-5)
    assert found.power_mean == pytest.approx(200.0, rel=1e-8)  # over whole periods
    assert found.energy == pytest.approx(100 * 4 * 20.0, rel=1e-6)
    assert found.capture_width == pytest.approx(200.0 / (1025 * 9.81**2 * 0.25 / (4 * np.pi / 2)), rel=1e-8)
    assert merit(harmonic_run(), STILL, NO_WAVES, Water(), (20.0, 40.0)).capture_width is None


def test_driving_take_off_has_negative_mean_power():
    run = harmonic_run()
    found = merit(
        run.assign(power_absorbed=-run.power_absorbed, energy=-run.energy),
        WAVE,
        WAVE.realisation(),
        Water(),
        (21.0, 39.9),
    )
    assert found.power_peak == pytest.approx(0.0, abs=1e-3)
    assert found.power_mean == pytest.approx(-200.0, rel=1e-8)


@pytest.mark.parametrize(
    ("window", "expected"), [((0.0, 9.0), (1.0, 9.0)), ((0.0, 3.0), (0.0, 3.0)), ((2e-9, 8.0), (0.0, 8.0))]
)
def test_means_are_taken_over_whole_periods(window, expected):
    assert averaging_window(WAVE, window) == pytest.approx(expected)
    assert averaging_window(STILL, window) == window


def test_energy_flux_of_deep_water_is_the_power_limit_and_of_finite_depth_uses_the_group_velocity():
    water, omega = Water(), WAVE.omega
    limit = power_limit(omega, np.inf, water.density, water.gravity) * 0.25
    assert limit / energy_flux(WAVE.realisation(), water) == pytest.approx(9.81 / omega**2)  # wavelength/(2 pi)
    water, omega = Water(density=900.0, gravity=9.0, depth=6.0), np.array([0.5, 0.9])
    speeds = [group_velocity(w, 6.0, 9.0) for w in omega]
    expected = 0.5 * 900.0 * 9.0 * (0.25 * speeds[0] + 0.04 * speeds[1])
    assert energy_flux(Sea(omega, np.array([0.3 + 0.4j, 0.2j])), water) == pytest.approx(expected, rel=1e-12)


def test_expected_power_of_a_tuned_damper_is_that_of_its_port(seed):
    omega = np.array([0.8, 1.6, 2.4])
    port = Port(omega, 1 / np.array([2e3 + 5e3j, 3e3 - 1e3j, 1e3 - 8e3j]), np.array([1.0 + 1j, 0.5j, -0.3]), 1e-4)
    dims = ("design", "omega")
    values = {"port_impedance": port.impedance, "port_velocity": port.velocity, "absorbed_power": port.power(1.0)}
    response = xr.Dataset({k: (dims, v[None]) for k, v in values.items()}, {"design": ["A"], "omega": omega})
    study = varied(seed, pto={"damping": 8000.0, "stiffness": -900.0})
    found = power_response(study, response, "A", {TUNED: 4e3})
    assert found.values == pytest.approx(port.power(4e3, -900.0), rel=1e-12)
    assert power_response(study, response, "A", {}).values == pytest.approx(port.power(1.0))


def test_response_is_selected_by_wave_direction():
    """Modulo 360 degrees; in still water any direction will do."""
    order = (90.0, -330.0, 0.0)
    response = xr.Dataset({"power": ("wave_direction", list(order))}, {"wave_direction": np.deg2rad(order)})

    def found(degrees):
        wave = RegularWave(kind="regular", amplitude=1.0, period=5.0, direction=degrees)
        return float(in_direction(response, wave).power) % 360.0

    assert [found(degrees) for degrees in (0.0, 30.0, 90.0, 360.0, -270.0)] == [0.0, 30.0, 90.0, 0.0, 90.0]
    assert float(in_direction(response, STILL).power) == order[0]
    with pytest.raises(ConfigError, match=r"received 45 degrees, needs one of 90, -330, 0$"):
        found(45.0)


def still_run(energy, residual):
    """A buoy at rest with a given absorbed energy [J]."""
    time = np.linspace(0.0, 60.0, 601)
    motion = {name: (("time", "dof"), np.zeros((len(time), 1))) for name in ("position", "velocity")}
    absorbed = (("time", "term"), energy * (time / time[-1])[:, None])
    coords = {"time": time, "dof": ["Heave"], "term": ["pto"]}
    power = {"power_absorbed": ("time", np.full(len(time), energy / time[-1]))}
    return xr.Dataset(motion | power | {"energy": absorbed}, coords, {"energy_residual": residual})


@pytest.mark.parametrize(("rigid", "gain"), [(1e3, 50.0), (1e-7, None), (0.0, None)])
def test_no_gain_over_a_reference_that_absorbs_nothing(seed, rigid, gain):
    designs = {"R": {"flexible": False}, "S": {"flexible": True}}
    two = varied(seed, designs=designs, waves=[{"kind": "still"}], published=None)
    rows = comparison(two, two.waves[0], {"R": still_run(rigid, 1e-7), "S": still_run(1.5e3, 3e-6)}, NO_WAVES)
    assert [row["design"] for row in rows] == ["R", "S"]
    assert [row["energy_residual"] for row in rows] == [1e-7, 3e-6]
    assert [row["energy"] for row in rows] == pytest.approx([rigid, 1.5e3])
    assert rows[1]["energy_gain_percent"] == (pytest.approx(gain) if gain else None)
    assert rows[1]["power_gain_percent"] is None  # no mean power in still water


def test_power_gain_is_of_the_window_and_energy_gain_of_the_run(seed):
    """The rigid buoy absorbs 10 W throughout; the other one 20 W, but nothing before the window."""
    designs = {"R": {"flexible": False}, "S": {"flexible": True}}
    two = varied(seed, designs=designs, pto={"damping": 8000.0, "stiffness": 500.0})
    time, (wave,) = np.linspace(0.0, 60.0, 601), two.waves
    runs = {name: still_run(600.0, 0.0) for name in designs}
    runs["S"]["energy"] = (("time", "term"), 20.0 * np.maximum(time - 40.0, 0.0)[:, None])
    rigid, shell = comparison(two, wave, runs, wave.realisation(12.0, 60.0))
    assert (rigid["power_gain_percent"], rigid["energy_gain_percent"]) == (0.0, 0.0)
    assert shell["power_gain_percent"] == pytest.approx(100.0, rel=1e-3)
    assert shell["energy_gain_percent"] == pytest.approx(-100 / 3, rel=1e-9)
    assert (shell["damping"], shell["stiffness"]) == (8000.0, 500.0)
    header, first = as_csv([rigid]).splitlines()
    assert (header, tuple(CONTRACT.split(","))) == (CONTRACT, COLUMNS)
    (back,) = csv.DictReader(io.StringIO(f"{header}\n{first}"))
    assert (back["low"], back["damping"]) == ("", "8000")


@pytest.mark.parametrize(("law", "damping"), [("saturated", "8000"), ("coulomb", "")])
def test_a_law_without_damping_has_none_in_the_table(seed, law, damping):
    """Of friction the damping given is that of the linear response alone."""
    one = varied(
        seed, designs={"R": {"flexible": False}}, waves=[{"kind": "still"}], pto={"law": law, "force_limit": 3e3}
    )
    rows = comparison(one, one.waves[0], {"R": still_run(1.0, 0.0)}, NO_WAVES)
    (found,) = csv.DictReader(io.StringIO(as_csv(rows)))
    assert found["damping"] == damping


@pytest.fixture
def results(small):
    return vsb.open("results/small")


@pytest.mark.parametrize("design", ["FSB", "VSWEC"])
def test_mean_power_is_that_of_the_comparison(results, design):
    found = results.series(design)
    (wave,) = results.study.waves
    start, end = averaging_window(wave, results.study.simulation.window)
    work = CubicSpline(found.time.values, found.power_absorbed.values).integrate(start, end)
    expected = results.comparison.set_index("design").record_power_mean[design]
    assert work / (end - start) == pytest.approx(expected, rel=1e-6)
    assert np.allclose(found.ptos_powerInternalMechanics, found.ptos_forceTotal * found.ptos_velocity)


def test_degrees_that_clamps_load_are_named(tmp_path):
    """Beside those of the database; the power is the port's."""
    held = {"modes": {"basis": "full", "degree": 2, "tolerance": 0.1}, "designs": {"held": {"clamp": 90}}}
    made = tables_of(StudyPlan(parse(SMALL | held), str(tmp_path)))
    found = made.series("held")
    assert "Ring1" in found.dof.values
    assert np.allclose(found.ptos_powerInternalMechanics, found.ptos_forceTotal * found.ptos_velocity)


def test_forces_are_those_of_the_equation_of_motion(results):
    """Total and take-off force of heave accelerate mass and added mass at infinite frequency."""
    found, database = results.series("FSB"), results.database
    heave = found.sel(dof="Heave")
    inertia = database.inertia_matrix + database.added_mass_inf
    mass = float(inertia.sel(influenced_dof="Heave", radiating_dof="Heave"))
    acceleration = CubicSpline(found.time.values, heave.bodies_velocity.values)(found.time.values, 1)
    force = heave.bodies_forceTotal + heave.ptos_forceTotal
    inside = slice(5, -5)
    assert force.values[inside] == pytest.approx(mass * acceleration[inside], abs=1e-4 * float(abs(force).max()))
    parts = heave.bodies_forceExcitation + heave.bodies_forceRadiationDamping + heave.bodies_forceRestoring
    assert parts.values == pytest.approx(heave.bodies_forceTotal.values, abs=1e-9 * float(abs(parts).max()))


def test_rotations_and_ports_have_their_units():
    """A port that moves half with pitch, by hand."""
    time, dof = np.arange(5.0), ["Heave", "Pitch"]
    run = xr.Dataset(
        {
            "position": (("time", "dof"), np.outer(time, [1.0, 0.5])),
            "velocity": (("time", "dof"), np.outer(np.ones(5), [1.0, 0.5])),
            "pto": (("time", "dof"), np.outer(np.ones(5), [-6.0, -3.0])),
            "end_stop": (("time", "dof"), np.outer(np.ones(5), [-2.0, -1.0])),
            "power_absorbed": ("time", np.full(5, 6.0)),
        },
        {"time": time, "dof": dof},
    )
    found = time_series(run, xr.DataArray([1.0, 0.5], {"dof": dof}, ("dof",)))
    assert found.ptos_velocity.values == pytest.approx(np.full(5, 1.25))
    assert found.ptos_forceInternalMechanics.values == pytest.approx(np.full(5, -6.0))
    assert found.ptos_forceTotal.values == pytest.approx(np.full(5, -8.0))
    assert found.ptos_powerInternalMechanics.values == pytest.approx(np.full(5, -7.5))
    assert found.power_absorbed.values == pytest.approx(np.full(5, 6.0))  # the rest is in a spring
    heads = next(csv.reader([series_csv(found).splitlines()[0]]))
    assert {"bodies_position_Heave [m]", "bodies_position_Pitch [rad]", "bodies_forceTotal_Pitch [N m]"} < set(heads)


@pytest.mark.parametrize("name", ["run.csv", "run.nc"])
def test_command_writes_what_python_returns(results, name, tmp_path, capsys):
    path = results.plan.simulation("VSWEC", results.study.waves[0]).out
    assert main(["series", path, str(tmp_path / name)]) == 0
    found = results.series("VSWEC")
    if name.endswith(".nc"):
        with xr.open_dataset(tmp_path / name) as written:
            assert written.load().identical(found)
    else:
        rows = list(csv.DictReader((tmp_path / name).read_text().splitlines()))
        assert [float(row["power_absorbed [W]"]) for row in rows] == pytest.approx(
            found.power_absorbed.values, rel=1e-9
        )
        assert float(rows[7]["bodies_position_Heave [m]"]) == pytest.approx(
            float(found.bodies_position[7, 0]), rel=1e-9
        )
    assert "instants of" in (printed := capsys.readouterr().out)
    assert "energy" in printed.partition("; left out, without a name of WEC-Sim's: ")[2]
