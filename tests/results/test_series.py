"""Time series under WEC-Sim's names: forces add up, power is the comparison's, files hold what Python returns."""

import csv

import numpy as np
import pytest
import xarray as xr
from conftest import SMALL, tables_of
from scipy.interpolate import CubicSpline

import vsb
from vsb.cli import main
from vsb.pipeline.graph import StudyPlan
from vsb.results.comparison import averaging_window
from vsb.results.series import as_csv, time_series
from vsb.study.study import parse


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
    held = {"modes": {"basis": "full", "degree": 2}, "designs": {"held": {"clamp": 90}}}
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
    heads = next(csv.reader([as_csv(found).splitlines()[0]]))
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
