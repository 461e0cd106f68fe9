"""The public names of the package, and the example that uses them."""

import re
import runpy
import subprocess
import sys

import numpy as np
import pytest
from conftest import HERE

import vsb
from vsb.errors import ConfigError, DatabaseError

HOME = HERE.parent


@pytest.fixture(scope="module")
def example(tmp_path_factory):
    """Variables of `examples/first_steps.py`, run in a folder of its own."""
    place = tmp_path_factory.mktemp("first_steps")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        variables = runpy.run_path(str(HOME / "examples" / "first_steps.py"))
    return variables | {"place": place}


@pytest.fixture
def results(example, monkeypatch):
    monkeypatch.chdir(example["place"])
    return vsb.Results(example["study"])


def test_public_names_are_the_documented_names():
    rows = re.findall(r"^\| (`.*?) \|", (HOME / "docs" / "api.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(name for row in rows for name in re.findall(r"`(\w+)`", row)) == vsb.__all__ == sorted(vsb.__all__)
    assert set(dir(vsb)) == {*vsb.__all__, "__version__"}


def test_import_loads_only_the_standard_library():
    code = "import sys; before = {*sys.modules}; import vsb; print(*({*sys.modules} - before))"
    done = subprocess.run([sys.executable, "-c", code], cwd=HOME, capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert {name for name in loaded if name.partition(".")[0] not in sys.stdlib_module_names} == {"vsb"}


def test_example_gives_the_numbers_of_the_response(example, results):
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


def test_second_run_remakes_only_what_is_lost(results):
    files = {path: path.stat().st_mtime_ns for path in (results.report.parent).rglob("*.*") if path.name != ".lock"}
    lost = results.report.parent / "statistics.csv"
    text = lost.read_text()
    lost.unlink()
    vsb.run(results.study)
    assert lost.read_text() == text
    again = {path.name for path, time in files.items() if path.stat().st_mtime_ns != time}
    assert again == {"comparison.csv", "statistics.csv", "validity.json", "study.json", "tables.json", "manifest.json"}


def test_study_that_cannot_run_leaves_nothing_behind(results, tmp_path):
    clamped = results.study.model_copy(update={"designs": {"none": vsb.Design(clamp=(0, 30, 60, 90, 120, 150, 180))}})
    with pytest.raises(ConfigError, match="clamp"):
        vsb.run(clamped, tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_file_without_hydro_database_is_refused(results):
    with pytest.raises(DatabaseError, match="holds no hydro database"):
        vsb.open_database(results.report.parent / "response.nc")


def test_order_of_designs_does_not_matter(results):
    """Specifications sort them."""
    turned = results.study.model_copy(update={"designs": dict(reversed(results.study.designs.items()))})
    assert vsb.Results(turned).plan.ids == results.plan.ids
