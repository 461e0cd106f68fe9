"""The public names are the documented ones, cost nothing until used, and do what the example asks of them."""

import re
import runpy
import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest
from conftest import HERE

import vsb
from vsb.errors import ConfigError, DatabaseError, VsbError
from vsb.stages.alone import alone
from vsb.study.study import parse

HOME = HERE.parent


@pytest.fixture(scope="module")
def example(tmp_path_factory):
    """`examples/first_steps.py` run in a folder of its own: its variables, and the looks of figures before and after."""
    place = tmp_path_factory.mktemp("first_steps")
    looks = dict(mpl.rcParams)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        variables = runpy.run_path(str(HOME / "examples" / "first_steps.py"))
    return variables | {"place": place, "looks": (looks, dict(mpl.rcParams))}


@pytest.fixture
def results(example, monkeypatch):
    monkeypatch.chdir(example["place"])
    return vsb.Results(example["study"])


def test_the_public_names_are_the_documented_names():
    rows = re.findall(r"^\| (`.*?) \|", (HOME / "docs" / "api.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(name for row in rows for name in re.findall(r"`(\w+)`", row)) == vsb.__all__ == sorted(vsb.__all__)
    assert set(dir(vsb)) == {*vsb.__all__, "__version__"}


@pytest.mark.parametrize("name", vsb.__all__)
def test_every_public_name_is_there_under_its_own(name):
    assert getattr(vsb, name).__name__ == name
    assert getattr(vsb, name).__doc__


def test_what_is_not_public_is_not_there():
    with pytest.raises(AttributeError, match="module 'vsb' has no attribute 'Buoy'"):
        _ = vsb.Buoy


def test_import_loads_nothing_but_the_standard_library():
    code = "import sys; before = {*sys.modules}; import vsb; print(*({*sys.modules} - before))"
    done = subprocess.run([sys.executable, "-c", code], cwd=HOME, capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert {name for name in loaded if name.partition(".")[0] not in sys.stdlib_module_names} == {"vsb"}


def test_the_example_is_short_and_its_numbers_are_those_of_the_response(example, results):
    text = (HOME / "examples" / "first_steps.py").read_text(encoding="utf-8")
    assert len([line for line in text.split("import vsb\n")[1].splitlines() if line]) <= 15
    wave = example["waves"][0]
    for design in example["designs"]:
        stored = results.response.sel(design=design, omega=wave.omega)
        best = results.port(design, [wave.omega]).power(float(stored.best_damping))[0]
        assert best == pytest.approx(float(stored.absorbed_power), rel=1e-9) == pytest.approx(float(stored.best_power))
        port = results.port(design)
        assert np.array_equal(port.omega, results.database.omega)
        assert np.all(port.power(np.geomspace(1e2, 1e6, 9)) <= port.best_power * (1 + 1e-12))


def test_the_callers_figures_keep_their_looks(example):
    before, after = example["looks"]
    assert before == after


def test_results_are_tables_series_and_scenes(results):
    by_design = {row["design"]: row for row in results.comparison}
    assert by_design.keys() == results.study.designs.keys() == {"rigid", "flexible"}
    for design in results.study.designs:
        run = results.trajectory(design, "regular_A0.18_T3")
        scene = results.scene(design)
        steady = vsb.harmonic_balance(scene.system)
        assert steady.power.pto == pytest.approx(run.attrs["steady_power"], rel=1e-9)
        again, _, _ = vsb.simulate(scene.system, scene.sea, results.study.simulation, scene.spectrum)
        end = again.position[-1] @ scene.scene.motions.T
        assert run.position.values[-1] == pytest.approx(end[: run.sizes["dof"]], rel=1e-12)
    assert results.statistics == []
    assert {"buckling", "power_limit", "hydro haskind"} <= {check["name"] for check in results.checks}
    rungs = {(row["design"], row["rung"]): row for row in results.ladder}
    assert {rung for _, rung in rungs} == {"best_damper", "best_damper_all_seas", "best_spring_damper", "matched"}
    for design, row in by_design.items():  # no damper is given: every run has its own best one, of linear theory
        assert row["damping"] == pytest.approx(rungs[design, "best_damper"]["damping"], rel=1e-9)
        assert row["power_mean"] == pytest.approx(rungs[design, "best_damper"]["power_mean"], rel=5e-3)
        assert row["stiffness"] == 0.0
    assert results.response.attrs["take_off"] == "best_damping at each frequency"
    assert rungs["rigid", "best_damper"]["gap"] is None
    assert results.report.is_file()
    assert vsb.open_database(results.plan.database_path).identical(results.database)


def test_a_second_run_keeps_what_is_there_and_makes_what_is_lost(results):
    files = {path: path.stat().st_mtime_ns for path in (results.report.parent).rglob("*.*") if path.name != ".lock"}
    lost = results.report.parent / "statistics.csv"
    text = lost.read_text()
    lost.unlink()
    vsb.run(results.study)
    assert lost.read_text() == text
    again = {path.name for path, time in files.items() if path.stat().st_mtime_ns != time}
    assert again == {"comparison.csv", "statistics.csv", "validity.json", "study.json", "tables.json", "manifest.json"}


def test_a_folder_in_use_is_left_alone(results):
    with alone(results.report.parent), pytest.raises(VsbError, match="another run is at work"):
        vsb.run(results.study)


def test_a_study_that_cannot_be_run_leaves_nothing_behind(results, tmp_path):
    clamped = results.study.model_copy(update={"designs": {"none": vsb.Design(clamp=(0, 30, 60, 90, 120, 150, 180))}})
    with pytest.raises(ConfigError, match="clamp"):
        vsb.run(clamped, tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_results_that_are_not_there_are_refused(results, tmp_path):
    with pytest.raises(ConfigError, match="design: received 'FSB', needs one of rigid, flexible"):
        results.trajectory("FSB")
    with pytest.raises(ConfigError, match=r"wave: received 'still', needs one of regular_A0\.18_T3"):
        results.scene("rigid", "still")
    with pytest.raises(DatabaseError, match="file not found"):
        _ = vsb.Results(results.study, str(tmp_path)).comparison
    other = results.study.model_copy(update={"pto": vsb.Pto(damping=1.0)})
    with pytest.raises(DatabaseError, match="stale or foreign"):
        vsb.Results(other).trajectory("rigid")
    raw = results.study.model_dump() | {"hydro": {"model": "assumed_pressure", "pressure": 1800.0}}
    raw["pto"] = {"damping": 8000.0}
    dry = vsb.Results(parse(raw))
    for name, words in (
        ("response", "frequency response"),
        ("ladder", "tuning ladder"),
        ("database", "hydro database"),
    ):
        with pytest.raises(ConfigError, match=f"'assumed_pressure', which has no {words}"):
            getattr(dry, name)
    with pytest.raises(ConfigError, match="has no port"):
        dry.port("rigid")


def test_what_is_no_hydro_database_is_refused(results):
    with pytest.raises(DatabaseError, match="holds no hydro database"):
        vsb.open_database(results.report.parent / "response.nc")


def test_the_order_of_designs_does_not_matter(results):
    """In a specification, and so in a job, it is that of the alphabet."""
    turned = results.study.model_copy(update={"designs": dict(reversed(results.study.designs.items()))})
    assert vsb.Results(turned).plan.ids == results.plan.ids
