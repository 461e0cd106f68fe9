"""General integrators and CVODE on every scene, errors by independent routes, failures as rows, figures. No timings."""

import csv
import io
from dataclasses import replace

import numpy as np
import pytest
from conftest import HERE, varied

from benchmarks import general_solvers as generalsolvers
from benchmarks import time_cases as timecases
from benchmarks import time_domain as timeprecision
from benchmarks.general_solvers import NOT_INSTALLED, SCIPY, SUNDIALS, Equation, solved
from benchmarks.integrators import COLUMNS
from benchmarks.measure import as_csv
from benchmarks.time_cases import CONVOLUTION, STEPS, STRIDES, case_of, scene_of
from benchmarks.time_domain import (
    BALANCE,
    BALANCED,
    COSTS,
    EXACT,
    EXPONENTIAL,
    PANELS,
    POWER,
    SCALED,
    SEAS,
    STYLES,
    benchmark,
    cost_figure,
    cost_rows,
    error_figure,
    integrator_rows,
    power_rows,
)
from vsb.errors import ConfigError, ConvergenceError
from vsb.motion.system import System
from vsb.study import study as config

DURATION = 2.5


@pytest.fixture(scope="module")
def seed_study():
    return config.load(HERE.parent / "config" / "few_modes.yaml")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("hydro")


@pytest.fixture(scope="module")
def case(seed_study, folder):
    """Function (model, sea) -> two and a half seconds of the free shell."""

    def build(model, sea, duration=DURATION):
        return case_of(scene_of(timecases.varied(seed_study, "VSWEC", model, sea, duration), folder), duration)

    return build


@pytest.fixture(scope="module")
def rows(case):
    """Rows of one linear and one body-exact scene, and what is varied shortened."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(timeprecision, "TOLERANCES", (1e-5, 1e-7))
        patch.setattr(timeprecision, "OURS", (1e-4, 1e-6, 1e-8))
        patch.setattr(generalsolvers, "ENOUGH", 0.0)
        return {panel: integrator_rows(case(*panel.split(", ")), panel) for panel in (PANELS[1], PANELS[2])}


def errors(rows, method):
    return np.array([row["error"] for row in rows if row["method"] == method])


# general integrators -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("panel", PANELS)
@pytest.mark.parametrize("method", ["DOP853", "LSODA", SUNDIALS])
def test_the_plain_equation_has_the_same_motion(case, panel, method):
    if method == SUNDIALS:
        pytest.importorskip("sksundae")
    scene = case(*panel.split(", "))
    found = solved(scene.equation, method, 1e-9, scene.time, 60.0)
    assert scene.errors(found)["error"] < 2e-6
    assert scene.errors(found)["error_energy"] < 1e-5
    assert found.evaluations > 100


@pytest.mark.parametrize("method", SCIPY)
def test_a_deadline_is_a_status(case, method):
    scene = case("linear", next(iter(SEAS)))
    found = solved(scene.equation, method, 1e-7, scene.time, 0.0)
    assert found.status == "stopped after its limit at t = 0 s"
    assert not len(found.heave)
    assert scene.errors(found) == {}


@pytest.mark.parametrize("method", ["RK45", SUNDIALS])
def test_a_motion_that_blows_up_is_a_status(method):
    if method == SUNDIALS:
        pytest.importorskip("sksundae")
    runaway = Equation(lambda t, z: z**2, np.ones(2), 1)
    found = solved(runaway, method, 1e-6, np.linspace(0.0, 3.0, 5), 20.0)
    assert found.status != "completed"
    assert not len(found.heave)


def test_a_motion_that_is_no_number_is_a_status():
    nothing = Equation(lambda t, z: np.full(2, np.nan), np.ones(2), 1)
    found = solved(nothing, "LSODA", 1e-6, np.linspace(0.0, 3.0, 5), 20.0)
    assert found.status != "completed"


def test_without_sundials_the_row_says_so(case, monkeypatch):
    monkeypatch.setattr(generalsolvers, "CVODE", None)
    scene = case("linear", next(iter(SEAS)))
    found = scene.general(SUNDIALS, 1e-6)
    assert found.status == NOT_INSTALLED
    rows = [generalsolvers.measured_row("integrators", PANELS[0], SUNDIALS, 1e-6, found, scene.errors(found))]
    assert next(csv.DictReader(io.StringIO(as_csv(rows, COLUMNS))))["error"] == ""
    error_figure(rows)


# errors --------------------------------------------------------------------------------------------------------------


def test_the_two_references_agree(rows):
    for panel, found in rows.items():
        (check,) = (row["error"] for row in found if row["table"] == "reference")
        assert check < 1e-8, panel


def test_every_method_is_there_and_completes(rows):
    linear, exact = rows.values()
    assert {row["method"] for row in linear} == {EXACT, STEPS, CONVOLUTION, *SCIPY, SUNDIALS}
    assert {row["method"] for row in exact} == {EXPONENTIAL, STEPS, *SCIPY, SUNDIALS}
    assert {row["status"] for row in linear + exact} <= {"completed", NOT_INSTALLED}


def test_exact_propagation_is_exact_and_few_memory_states_are_not(rows):
    found = errors(rows[PANELS[1]], EXACT)
    assert found[-1] < 1e-9
    assert np.all(found[:3] > 1e-5)
    assert found[0] > 10 * found[3]


def test_fixed_steps_have_their_order(case):
    """Two for the convolution, four for ours, of the rigid buoy, which has no stiff mode."""
    scene = case("linear", next(iter(SEAS)))
    rigid = replace(scene.system.scene, motions=np.eye(len(scene.system.scene.labels), 1))
    one = replace(scene, system=System.of(rigid), start=rigid.start(0.0, 0.0))
    for method, order, tolerance in ((CONVOLUTION, 2.0, 0.15), (STEPS, 4.0, 0.3)):
        found = [one.errors(one.stepped(method, stride), stride)["error"] for stride in STRIDES[:5]]
        orders = -np.diff(np.log2(found))
        assert np.all(np.abs(orders - order) < tolerance), (method, orders)


def test_a_smaller_tolerance_is_a_smaller_error(rows):
    for found in rows.values():
        for method in (*SCIPY, EXPONENTIAL):
            these = errors(found, method)
            assert np.all(np.diff(these) < 0), (method, these)


def test_a_run_of_ours_that_fails_is_a_row(case):
    scene = case("linear", next(iter(SEAS)))

    def fails():
        raise ConvergenceError("the motion cannot be followed")

    found = scene.ours(fails)
    assert (found.status, scene.errors(found)) == ("the motion cannot be followed", {})


def test_mean_power_without_a_transient_is_that_after_it(case, monkeypatch):
    monkeypatch.setattr(timeprecision, "PERIODS", (10, 20, 40))
    found = power_rows(case("body-exact", next(iter(SEAS))).system)
    balance = np.array([row["error"] for row in found if row["method"] == BALANCE])
    motion = np.array([row["error"] for row in found if row["method"] == EXPONENTIAL])
    assert np.all(balance < np.array(BALANCED))
    assert np.all(np.diff(motion) < 0)
    assert motion[-1] < 1e-2


def test_a_power_that_fails_is_a_row(case, monkeypatch):
    def fails(system, tolerance):
        if tolerance > 1e-9:
            raise ConvergenceError("no steady state is found")
        return 1.0

    monkeypatch.setattr(timeprecision, "PERIODS", ())
    monkeypatch.setattr(timeprecision, "steady_power", fails)
    found = power_rows(case("linear", next(iter(SEAS))).system)
    assert {row["status"] for row in found[:3]} == {"no steady state is found"}
    assert "error" not in found[0]
    error_figure(found)


# cost, output --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def small():
    """Few and small scenes, most of which are said to be out of reach."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(timeprecision, "DEGREES", (2, 3))
        patch.setattr(timeprecision, "DURATIONS", (5.0, 500.0))
        patch.setattr(timeprecision, "ORDERS", (2, 6))
        patch.setattr(timeprecision, "HOPELESS", 1e-9)
        yield


@pytest.mark.usefixtures("small")
def test_cost_has_a_row_for_every_method_and_size(seed_study, folder):
    found = cost_rows(seed_study, "VSWEC", "linear", folder)
    assert {row["table"] for row in found} == set(COSTS)
    assert {row["method"] for row in found} == set(SCALED["linear"])
    assert [row["setting"] for row in found if (row["table"], row["method"]) == ("modes", EXACT)] == [3, 4]
    status = {(row["table"], row["setting"]): row["status"] for row in found if row["method"] == STEPS}
    assert status["duration", 5.0] == "completed"
    assert status["duration", 500.0].startswith("not tried: ")
    assert status["duration", 500.0].endswith(" s expected")
    assert all((row["seconds"] is None) == row["status"].startswith("not tried") for row in found)
    cost_figure(found)


def test_the_benchmark_writes_its_table_and_figures(seed_study, tmp_path, monkeypatch):
    """Cost, which has its own test, is one row of every model here."""
    one = {"table": "modes", "method": STEPS, "setting": 3.0, "seconds": 0.1, "status": "completed"}
    monkeypatch.setattr(timeprecision, "cost_rows", lambda study, design, model, folder: [{**one, "case": model}])
    monkeypatch.setattr(timeprecision, "DURATION", 1.25)
    monkeypatch.setattr(timeprecision, "TOLERANCES", (1e-5,))
    monkeypatch.setattr(timeprecision, "OURS", (1e-5,))
    monkeypatch.setattr(timeprecision, "PERIODS", (6,))
    rows = benchmark(seed_study, tmp_path)
    with (tmp_path / "time_precision.csv").open() as handle:
        assert len(list(csv.DictReader(handle))) == len(rows)
    for name in ("time_precision", "time_cost"):
        assert (tmp_path / f"{name}.svg").read_text().startswith("<?xml")


def test_every_method_has_a_style():
    assert {EXACT, EXPONENTIAL, CONVOLUTION, STEPS, SUNDIALS, BALANCE, *SCIPY} <= set(STYLES)
    assert POWER not in PANELS


def test_a_study_of_rigid_designs_has_nothing_to_measure(seed_study, tmp_path):
    rigid = varied(seed_study, designs={"FSB": {"flexible": False}})
    with pytest.raises(ConfigError, match=r"designs: received only rigid ones, FSB; needs a flexible one"):
        benchmark(rigid, tmp_path)


def test_a_study_of_panels_is_refused_before_anything_is_solved(seed_study, tmp_path):
    with pytest.raises(ConfigError, match=r"hydro: received a study of panels; needs hydro.solver: spectral"):
        benchmark(varied(seed_study, hydro={"rows": 20}), tmp_path)
