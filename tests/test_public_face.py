"""The public names of the package, and the example that uses them."""

import importlib
import itertools
import json
import re
import runpy
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from conftest import HERE, one_figure

import vsb
from vsb.cli import main
from vsb.engine.waves.kinds import jonswap_spectrum
from vsb.engine.waves.scatter import energy_period_over
from vsb.errors import ConfigError, DatabaseError
from vsb.tools.files import save

HOME = HERE.parent


@pytest.fixture(scope="module", autouse=True)
def with_one_figure():
    with one_figure():
        yield


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
        best = results.port(design, wave.omega).power(float(stored.best_damping))[0]
        assert best == pytest.approx(float(stored.absorbed_power), rel=1e-9) == pytest.approx(float(stored.best_power))
        assert float(stored.period) == pytest.approx(wave.period)
        port = results.port(design)
        assert np.array_equal(port.omega, results.database.omega)
        assert np.all(port.power(np.geomspace(1e2, 1e6, 9)) <= port.best_power * (1 + 1e-12))


def test_results_are_tables_series_and_scenes(results):
    by_design = {row["design"]: row for row in results.comparison.to_dict("records")}
    assert by_design.keys() == results.study.designs.keys() == {"rigid", "flexible"}
    for design in results.study.designs:
        run = results.trajectory(design, "regular_A0.18_T3")
        scene = results.scene(design)
        steady = vsb.harmonic_balance(scene.system)
        assert steady.power.pto == pytest.approx(run.attrs["steady_power"], rel=1e-9)
        again, _, _ = vsb.simulate(scene.system, scene.sea, results.study.simulation, scene.spectrum)
        end = again.position[-1] @ scene.scene.motions.T
        assert run.position.values[-1] == pytest.approx(end[: run.sizes["dof"]], rel=1e-12)
    assert results.statistics.to_dict("records") == []
    assert {"buckling", "power_limit", "hydro haskind"} <= {
        check["name"] for check in results.checks.to_dict("records")
    }
    levels = {(row["design"], row["rung"]): row for row in results.ladder.to_dict("records")}
    assert {level for _, level in levels} == {"best_damper", "best_damper_all_seas", "best_spring_damper", "matched"}
    for design, row in by_design.items():  # no damper is given: every run has its own best one, of linear theory
        assert row["damping"] == pytest.approx(levels[design, "best_damper"]["damping"], rel=1e-9)
        assert row["power_mean"] == pytest.approx(levels[design, "best_damper"]["power_mean"], rel=5e-3)
        assert row["stiffness"] == 0.0
    assert results.response.attrs["take_off"] == "best_damping at each frequency"
    assert np.isnan(levels["rigid", "best_damper"]["gap"])
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


def test_a_path_is_no_study():
    with pytest.raises(ConfigError, match=r"vsb.run: received 'buoy.yaml', needs what vsb.load, load_body or load_des"):
        vsb.run("buoy.yaml")


def test_study_that_cannot_run_leaves_nothing_behind(results, tmp_path):
    clamped = results.study.model_copy(update={"designs": {"none": vsb.Design(clamp=(0, 30, 60, 90, 120, 150, 180))}})
    with pytest.raises(ConfigError, match="clamp"):
        vsb.run(clamped, tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_file_without_hydro_database_is_refused(results):
    with pytest.raises(DatabaseError, match="holds no hydro database"):
        vsb.open_database(results.report.parent / "response.nc")


def test_results_are_opened_by_their_folder_alone(example, monkeypatch):
    monkeypatch.chdir(example["place"])
    found, run = vsb.open("results/first_steps"), example["results"]
    assert found.comparison.equals(run.comparison)
    assert found.comparison.attrs["units"]["power_mean"] == "W"
    assert "flexible, rigid" in repr(found)
    assert "<table" in found._repr_html_()
    with pytest.raises(DatabaseError, match="holds no results"):
        vsb.open("results/hydro")
    monkeypatch.chdir("results/first_steps")
    assert vsb.open(".").comparison.equals(run.comparison)


def test_best_buoy_is_read_by_a_process_that_imported_nothing_else(tmp_path):
    importlib.import_module("vsb.design.variables")
    values = xr.Dataset({"buoy_value": (("buoy", "quantity"), [[8.0]])}, attrs={"answer": "none pays"})
    save(values, tmp_path / "design.nc")
    code = "import sys, vsb; print(vsb.open(sys.argv[1]).answer)"
    done = subprocess.run([sys.executable, "-c", code, tmp_path], capture_output=True, text=True, check=True)
    assert done.stdout == "none pays\n"


def test_optimum_without_limits_is_the_matched_power(results):
    matched = results.ladder.query("rung == 'matched' and design == 'flexible'").power_mean.item()
    free = results.optimum("flexible")
    assert free.power == pytest.approx(matched, rel=1e-9)
    limited = results.optimum("flexible", force_limit=free.force_peak / 4)
    assert limited.power <= limited.bound < free.power
    assert limited.force_peak <= free.force_peak / 4 * (1 + 1e-9)


def test_weak_coulomb_damper_from_python_rubs_along_the_free_motion(results):
    """A friction force far below the wave's hardly changes the motion: 4 |z| of path in a period, by the RAO."""
    wave = results.study.waves[0]
    scene = results.scene("rigid", pto=vsb.Pto(law="coulomb", force_limit=5.0, damping=8e3))
    run, _, _ = vsb.simulate(scene.system, scene.sea, results.study.simulation, scene.spectrum)
    heave = (run.position @ scene.scene.motions.T)[:, 0]
    start = np.searchsorted(run.time, run.time[-1] - 5 * wave.period)
    path = np.abs(np.diff(heave[start:])).sum()
    free = abs(results.port("rigid", [wave.omega]).velocity[0]) / wave.omega * wave.amplitude
    assert path == pytest.approx(5 * 4 * free, rel=0.03)


def test_year_knows_the_spring_of_the_take_off(results):
    """A spring turns power into that of a port with the spring beside it, sea by sea over the spectra."""
    climate = vsb.read_seas(HOME / "config" / "climate" / "PacWave-South_Oregon_Wave-Resource.csv", "jonswap")
    plain = results.year(climate, ("one", "each"))
    energy = vsb.annual_energy(plain.capture_width_matrix[0, 0], plain.flux_matrix, plain.occurrence)
    assert energy / 1e6 == pytest.approx(float(plain.annual_energy[0, 0]), rel=1e-9)
    pto = results.study.pto.model_copy(update={"stiffness": -2e4})
    sprung = vsb.Results(results.study.model_copy(update={"pto": pto})).year(climate, ("one",))
    assert (sprung.annual_mean_power > 1.02 * plain.annual_mean_power.sel(tuning=["one"])).all()  # nearer to resonance
    lossy = vsb.Results(results.study.model_copy(update={"pto": pto.model_copy(update={"efficiency": 0.8})}))
    with pytest.raises(ConfigError, match="efficiency"):
        lossy.year(climate)


def test_power_matrix_is_the_mean_over_the_spectrum_of_each_sea(results, tmp_path, capsys):
    """Against a trapezoidal rule over JONSWAP's density; a higher sea has the same damper, and more power by Hs²."""
    hs, te = [1.0, 2.5], [5.0, 8.0]
    found = results.power_matrix(hs, te).isel(tuning=0)
    omega = np.linspace(*results.database.omega.values[[0, -1]], 4000)
    for design, period in itertools.product(found.design.values, te):
        one = found.sel(design=design, te=period)
        assert float(one.power_matrix[1] / one.power_matrix[0]) == pytest.approx(2.5**2, rel=1e-12)
        assert float(one.damping[1]) == pytest.approx(float(one.damping[0]), rel=1e-12)
        density = jonswap_spectrum(omega, 1.0, period / energy_period_over("tp", 3.3), 3.3)
        power = results.port(design, omega).power(float(one.damping[0]))
        assert float(one.power_matrix[0]) == pytest.approx(np.trapezoid(2 * density * power, omega), rel=5e-3)
    with pytest.raises(ConfigError, match=r"te: received 0\.5 s, seas of which more than 1%"):
        results.power_matrix(te=[0.5, 5.0])
    table = tmp_path / "matrix.csv"
    assert main(["matrix", results.plan.folder, "--out", str(table)]) == 0
    assert "mean power [kW] over Hs [m], down, and Te [s], across" in capsys.readouterr().out
    assert len(table.read_text().splitlines()) == 1 + results.power_matrix().power_matrix.size


def test_annual_energy_and_matrices_agree_with_mhkit():
    published = json.loads((HERE / "data" / "mhkit_performance.json").read_text(encoding="utf-8"))
    hs, te, flux = (np.array(published[name]) for name in ("hm0", "te", "flux"))
    width = np.array(published["power"]) / flux
    matrices = [vsb.power_matrix(hs, te, each) for each in (width, flux)]
    share = vsb.power_matrix(hs, te, flux, "frequency")
    row, column, mean, deviation, count, mean_flux = np.array(published["matrices"]).T
    at = row.astype(int), column.astype(int)
    assert len(hs) * share.values[at] == pytest.approx(count, rel=1e-12)
    assert int(share.notnull().sum()) == len(count)
    assert matrices[0].values[at] == pytest.approx(mean, rel=1e-10)
    assert matrices[1].values[at] == pytest.approx(mean_flux, rel=1e-10)
    assert vsb.power_matrix(hs, te, width, "std").values[at] == pytest.approx(deviation, rel=1e-10, abs=1e-10)
    assert vsb.annual_energy(*matrices, share) == pytest.approx(published["maep_Wh"], rel=1e-10)
    with pytest.raises(ConfigError, match="bins with seas but without a value"):
        vsb.annual_energy(matrices[0] * np.nan, matrices[1], share)


def test_annual_energy_of_series_is_that_of_its_mean_power():
    assert vsb.annual_energy_of_series([2.0, 4.0], [1e3, 5e3]) == pytest.approx(8766 * (2e3 + 20e3) / 2)
    for wrong in ([2.0], [2.0, np.nan]):
        with pytest.raises(ConfigError, match=r"annual_energy_of_series: received shapes .* needs as many finite"):
            vsb.annual_energy_of_series(wrong, [1e3, 5e3])


def test_table_of_gains_holds_those_of_the_comparison(results):
    best = results.ladder.query("rung == 'best_damper'").set_index("design").power_mean
    found = results.gains.set_index("design").best_gain_percent
    assert found["flexible"] == pytest.approx(100 * (best["flexible"] / best["rigid"] - 1), abs=1e-6)
    assert found["rigid"] == 0.0


def test_figures_take_and_return_axes(results, tmp_path, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    _, ax = plt.subplots()
    assert results.plot.rao(ax=ax) is ax
    drawn = {line.get_label(): line.get_ydata() for line in ax.lines}
    for design in results.study.designs:
        assert drawn[design] == pytest.approx(abs(results.response.rao.sel(design=design, dof="Heave")).values)
    with pytest.raises(ConfigError, match="dof: received 'Roll', needs one of Heave"):
        results.plot.rao("Roll")
    force = results.database.excitation_force.sel(influenced_dof="Heave").isel(wave_direction=0)
    line = results.plot.excitation().lines[0]
    assert line.get_ydata() == pytest.approx(abs(force).values / 1e3)
    best = {line.get_label(): line.get_ydata() for line in results.plot.power().lines}
    assert best["rigid"] == pytest.approx(results.response.best_power.sel(design="rigid").values / 1e3)
    lag = {line.get_label(): line.get_ydata() for line in results.plot.rao_phase().lines}["rigid"]
    rao = results.response.rao.sel(design="rigid", dof="Heave")
    assert np.exp(1j * np.radians(lag)) == pytest.approx((rao / abs(rao)).values)
    run = results.trajectory("rigid").sel(time=slice(*results.study.simulation.window))
    drawn = {line.get_label(): line.get_ydata() for line in results.plot.motion().lines}
    assert drawn["rigid"] == pytest.approx(run.position.sel(dof="Heave").values)
    monkeypatch.setattr("vsb.api.plots.PERIODS_SHOWN", 0.2)  # a frame takes a tenth of a second
    results.plot.animate("flexible").save(tmp_path / "heave.gif", writer="pillow", dpi=20)
    assert (tmp_path / "heave.gif").stat().st_size > 1000
    plt.close("all")


def test_wrong_values_are_errors_of_one_line():
    with pytest.raises(ConfigError) as raised:
        vsb.Device(radius=-2.0, thicknes=0.01, young_modulus=1e7, poisson_ratio=0.3, density=2700.0, mass=17170.0)
    lines = raised.value.mistakes
    assert any(re.match(r"Device: thicknes: .*thickness", line) for line in lines)
    assert any(re.match(r"Device: radius: received -2", line) for line in lines)
