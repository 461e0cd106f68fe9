"""Runs in time of a campaign: the correction they say, where it stands, what is kept, what is refused."""

import csv
from contextlib import chdir
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import varied
from stages.test_members import BASE, batches, gather, told, with_seas

from vsb.cli import main
from vsb.errors import ConfigError, ConvergenceError, StabilityError
from vsb.report.campaign_answer import closing_answer
from vsb.report.campaign_figures import sweep
from vsb.report.campaign_page import statements, warnings
from vsb.results.in_time import DesignInTime
from vsb.stages import answer, verification
from vsb.stages.campaign_preview import check_campaign
from vsb.study.campaign_plan import plan_of
from vsb.study.plan import StudyPlan
from vsb.tools import packed
from vsb.tools.files import load

RUNS = {"duration": 60.0, "window": [40.0, 60.0], "tolerance": 1e-4}
VERIFY = {"seas": 4, "seed": 3}
MASSES = {"device.mass": [17170.0, 17000.0]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return with_seas(tmp_path_factory.mktemp("verified"), (0.6, 5.0), (1.0, 6.0), (1.3, 6.5), (1.6, 7.0))


def planned(folder, name="checked", vary=None, verify=None, tuning=("fixed", "one"), **sections):
    raw = {**BASE, **sections, "study": f"{name}_study", "simulation": {**BASE["simulation"], **RUNS}}
    (folder / f"{name}_study.yaml").write_text(yaml.safe_dump(raw))
    given = {"campaign": name, "study": f"{name}_study.yaml", "climate": {"spectra": "sea.txt"}, "vary": vary or {}}
    given |= {"tuning": list(tuning), "verify": verify or VERIFY}
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(given, sort_keys=False))
    with chdir(folder):
        return plan_of(f"{name}.yaml")


def simulated(plan):
    for name, spec in plan.verifications.items():
        verification.run(
            told("verification", spec), plan.loaded.climate_path, plan.root, plan.verification_path(name)
        )  # fmt: skip
    return [load(path, expected=name) for name, path in zip(plan.verifications, plan.verification_paths, strict=True)]


def run(plan):
    batches(plan)
    found = simulated(plan)
    gather(plan)
    files = (f"{plan.folder}/figures", f"{plan.folder}/report.html", plan.manifest)
    answer.run(told("answer", plan.campaign), plan.data_path, plan.loaded.climate_path, plan.root, *files)
    return found, load(plan.data_path, expected=plan.campaign_id)


@pytest.fixture(scope="module")
def checked(folder):
    plan = planned(folder, vary=MASSES)
    with chdir(folder):
        return plan, *run(plan)


def test_the_correction_is_the_ratio_of_weighted_means(checked):
    """Sum h (N - L) over sum h L is the ratio of the means of (N - L) h/q and L h/q: by hand, from what is stored."""
    _, runs, found = checked
    for i, one in enumerate(runs):
        at = found.isel(mass=i)
        difference = (one.drawn_weight * (one.run_power - one.linear_run_power)).mean("draw")
        ratio = difference / (one.drawn_weight * one.drawn_power).mean("draw")
        expected = at.annual_mean_power.sel(tuning="one") * (1 + ratio)
        np.testing.assert_allclose(at.corrected_mean_power, expected, rtol=1e-9)
        assert float(np.abs(ratio).max()) > 1e-2
        rigid, shell = at.corrected_mean_power.values
        assert float(at.corrected_gain_percent.sel(design="VSWEC")) == pytest.approx(100 * (shell / rigid - 1))


def test_the_interval_of_the_gain_is_that_of_the_runs_under_their_tuning_alone(folder, checked):
    plan, runs, found = checked
    with chdir(folder):
        linear = [packed.load(f"{plan.folder}/members/{one.id}.npz", expected=one.id) for one in plan.members]
    for i, (one, before) in enumerate(zip(runs, linear, strict=True)):
        at = found.isel(mass=i)
        for end in ("gain_low", "gain_high"):
            np.testing.assert_array_equal(at[end].sel(tuning="one"), one[f"corrected_{end}"])
            np.testing.assert_array_equal(at[end].sel(tuning="fixed"), before[end].sel(tuning="fixed"))
        np.testing.assert_array_equal(at.gain_percent, before.gain_percent)
        low, gain, high = (
            float(one[f"corrected_gain_{part}"].sel(design="VSWEC")) for part in ("low", "percent", "high")
        )
        assert low < gain < high
    assert found.attrs["verification"] == (
        "tuning one: 4 seas of 60 s, body_exact, means from 40 to 60 s; there gain_low and gain_high are the 95 % "
        "interval of the corrected gain"
    )


def test_table_and_report_say_which(folder, checked):
    plan, _, found = checked
    rows = list(csv.DictReader((folder / plan.table_path).read_text().splitlines()))
    for row in rows:
        at = found.sel(mass=float(row["device.mass"]), design=row["design"])
        assert (row["corrected_mean_power"] == "") == (row["tuning"] == "fixed")
        if row["tuning"] == "one":
            assert float(row["corrected_mean_power"]) == pytest.approx(float(at.corrected_mean_power), rel=1e-11)
            assert float(row["gain_low"]) == pytest.approx(float(at.gain_low.sel(tuning="one")), abs=1e-9)
    best = found.isel(mass=int(found.corrected_gain_percent.sel(design="VSWEC").argmax("mass"))).sel(design="VSWEC")
    one, gain = best.sel(tuning="one"), float(best.corrected_gain_percent)
    sentence = closing_answer(found)
    assert f"takes {abs(gain):.1f} % {'more' if gain > 0 else 'less'} than the rigid FSB" in sentence
    assert f"({float(one.gain_low):+.1f} to {float(one.gain_high):+.1f} % by body-exact runs" in sentence
    assert (
        f"linear theory says {float(one.gain_percent):+.1f} %; {float(best.corrected_mean_power) * 8766e-6:.4g}"
        in sentence
    )
    assert sentence in (folder / plan.folder / "report.html").read_text()
    assert any(
        "of the energy is from seas beyond what is described" in line for line in statements(found, "FSB", "one")
    )
    assert any("heaves by more than 0.3 of its radius" in line for line in warnings(found))


def test_the_figure_of_a_sweep_shows_the_corrected_gain_beside_the_linear_one(checked):
    _, _, found = checked
    shell = found.sel(design="VSWEC").sortby("mass")
    axes = sweep(found, "one", "FSB").axes[0]
    corrected, linear = (line.get_ydata() for line in axes.lines[:2])
    np.testing.assert_array_equal(corrected, shell.corrected_gain_percent)
    np.testing.assert_array_equal(linear, shell.gain_percent.sel(tuning="one"))
    np.testing.assert_array_equal(
        sweep(found, "fixed", "FSB").axes[0].lines[0].get_ydata(), shell.gain_percent.sel(tuning="fixed")
    )


def test_a_map_shows_the_corrected_gain(checked):
    _, _, found = checked
    wide = found.expand_dims(thickness=[0.01, 0.02]).assign_attrs(varied="thickness mass")
    drawn = sweep(wide, "one", "FSB").axes[0].collections[0].get_array()
    np.testing.assert_array_equal(drawn, wide.sortby("mass").corrected_gain_percent.sel(design="VSWEC"))


def test_linear_runs_correct_nothing(folder):
    """What is left of linear theory beside itself is the fitted memory and the end of the transient."""
    plan = planned(folder, "same", verify={**VERIFY, "model": "linear"})
    with chdir(folder):
        _, found = run(plan)
    assert found.corrected_mean_power.dims == ("design",)
    np.testing.assert_allclose(found.corrected_mean_power, found.annual_mean_power.sel(tuning="one"), rtol=2e-3)
    assert " by linear runs" in closing_answer(found)


def test_a_run_goes_on_from_the_runs_in_time_that_are_there(folder, checked, capsys):
    """What is missing is made by the workflow, to the same bytes; what is there is kept."""
    plan, _, _ = checked
    kept, lost = (folder / path for path in plan.verification_paths)
    data = folder / plan.data_path
    before, stamp = {path: path.read_bytes() for path in (kept, lost, data)}, kept.stat().st_mtime_ns
    lost.unlink(), data.unlink()
    with chdir(folder):
        assert main(["run", "checked.yaml"]) == 0, capsys.readouterr()
    assert {path: path.read_bytes() for path in before} == before
    assert kept.stat().st_mtime_ns == stamp


def test_designs_that_are_not_viable_are_not_run(folder):
    """At its equilibrium the vented seed buckles; nothing of it is simulated."""
    plan = planned(folder, "lost", reference_shape="equilibrium", device={**BASE["device"], "internal_pressure": 0.0})
    with chdir(folder):
        (found,) = simulated(plan)
    assert not found.viable.any()
    assert np.isnan(found.corrected_mean_power).all()
    assert np.isnan(found.corrected_gain_low).all()


def test_a_point_at_which_nothing_is_taken_needs_no_runs_and_loses_no_other(folder):
    """Of two dampers one takes nothing: its corrected power is none, its gains are missing, the other's are there."""
    vary, verify = {"pto.damping": [0.0, 8e3]}, {"seas": 4, "model": "linear"}
    plan = planned(folder, "nothing", vary=vary, verify=verify, tuning=["fixed"])
    with chdir(folder):
        _, found = run(plan)
    none, some = (found.isel({found.margin.dims[0]: i}) for i in range(2))
    assert none.corrected_mean_power.values.tolist() == [0.0, 0.0]
    assert np.isnan(none.corrected_gain_percent).all()
    assert (some.corrected_mean_power > 0).all()
    assert np.isfinite(some.corrected_gain_percent).all()


def test_a_shell_that_finds_no_rest_on_the_water_is_refused_before_the_run(folder):
    plan = planned(folder, "soft", device={**BASE["device"], "young_modulus": 1e6})
    with chdir(folder), pytest.raises(ConfigError, match=r"soft.yaml: verify: .*for design VSWEC, but"):
        check_campaign(plan)


@pytest.mark.parametrize("error", [ConvergenceError, StabilityError])
def test_a_run_that_fails_names_its_sea(folder, checked, monkeypatch, error):
    plan, _, _ = checked

    def fails(*_):
        raise error("the buoy has left the water")

    monkeypatch.setattr(DesignInTime, "powers", fails)
    expected = r"verify: FSB in a sea of Hs [\d.]+ m and Te [\d.]+ s: the buoy has left the water"
    with chdir(folder), pytest.raises(error, match=expected):
        simulated(plan)


def test_check_tells_of_the_runs(folder, checked, capsys):
    with chdir(folder):
        assert main(["check", str(Path("checked.yaml"))]) == 0
    assert "verify       4 seas of 60 s, body_exact, of each of 2 points, 2 done" in capsys.readouterr().out


def test_every_design_has_its_own_damper_of_the_sea_it_meets(monkeypatch):
    """That of the first tuning, by which the runs go; 100 times the number of the design, and that of the sea."""
    monkeypatch.setattr(verification, "realised", lambda *_: None)
    spec = SimpleNamespace(simulation=SimpleNamespace(duration=60.0), verify=SimpleNamespace(model="linear"))
    damping = 100.0 * np.arange(2)[:, None, None] + 1000.0 * np.arange(2)[:, None] + np.arange(3)
    year = SimpleNamespace(climate=SimpleNamespace(hs=np.ones(3), te=np.ones(3)), damping=damping)
    database = xr.Dataset(coords={"omega": np.linspace(0.2, 5.0, 40)})
    buoy = SimpleNamespace(database=database)
    taking = SimpleNamespace(buoy=buoy, under=lambda c: SimpleNamespace(powers=lambda *_: (c, 0.5 * c)))
    sample = SimpleNamespace(sea=np.array([2, 0]), seed=np.array([7, 9]))
    better, linear = verification._powers(spec, year, sample, {"A": taking, "B": taking})
    assert better.tolist() == [[2.0, 0.0], [102.0, 100.0]]
    assert linear.tolist() == [[1.0, 0.0], [51.0, 50.0]]


def test_runs_are_in_waves_of_the_whole_band_that_is_solved_and_no_others(monkeypatch):
    """Of each design's own database; each design meets the same sea of the same seed."""
    omega, asked = np.linspace(0.2, 5.0, 40), []
    monkeypatch.setattr(verification, "realised", lambda *given: asked.append(given[1:]))
    simulation = SimpleNamespace(duration=60.0)
    spec = SimpleNamespace(simulation=simulation, verify=SimpleNamespace(model="linear"))
    climate = SimpleNamespace(hs=np.ones(3), te=np.full(3, 5.0))
    year = SimpleNamespace(climate=climate, damping=np.ones((2, 1, 3)))
    sample = SimpleNamespace(sea=np.array([2, 0]), seed=np.array([7, 9]))

    def design(highest):
        """Of a database up to another frequency; it takes 3 and 2 W."""
        found = SimpleNamespace(powers=lambda *_: (3.0, 2.0))
        database = xr.Dataset(coords={"omega": omega[:highest]})
        return SimpleNamespace(buoy=SimpleNamespace(database=database), under=lambda damping: found)

    better, linear = verification._powers(spec, year, sample, {"A": design(40), "B": design(30)})
    ends = [(0.2, 5.0), (0.2, omega[29])]
    assert asked == [(sea, 60.0, seed, *map(float, ends[i])) for sea, seed in ((2, 7), (0, 9)) for i in (0, 1)]
    assert (better.tolist(), linear.tolist()) == ([[3.0, 3.0]] * 2, [[2.0, 2.0]] * 2)


def test_every_design_is_run_under_its_own_damper_of_the_drawn_sea(monkeypatch, capsys):
    """Dampers by design and sea; a power tells which was taken."""
    monkeypatch.setattr(verification, "realised", lambda *given: given[1])
    spec = SimpleNamespace(simulation=SimpleNamespace(duration=60.0), verify=SimpleNamespace(model="linear"))
    climate = SimpleNamespace(hs=np.array([1.0, 2.0, 3.0]), te=np.array([5.0, 6.0, 7.0]))
    damping = np.array([[[1.0, 2.0, 3.0]], [[10.0, 20.0, 30.0]]])
    year, sample = SimpleNamespace(climate=climate, damping=damping), SimpleNamespace(sea=[2, 0], seed=[7, 9])

    class Design:
        buoy = SimpleNamespace(database=xr.Dataset(coords={"omega": [0.2, 5.0]}))

        def under(self, damping):
            return SimpleNamespace(powers=lambda sea, *_: (damping + 0.1 * sea, -damping))

    better, linear = verification._powers(spec, year, sample, {"A": Design(), "B": Design()})
    assert better == pytest.approx(np.array([[3.2, 1.0], [30.2, 10.0]]))
    assert linear.tolist() == [[-3.0, -1.0], [-30.0, -10.0]]
    assert capsys.readouterr().out.splitlines() == [
        f"{name} in a sea of Hs {hs} m and Te {te} s: {better:.5g} W, {linear:.5g} W by linear theory"
        for name, hs, te, better, linear in (
            ("A", 3, 7, 3.2, -3.0), ("B", 3, 7, 30.2, -30.0), ("A", 1, 5, 1.0, -1.0), ("B", 1, 5, 10.0, -10.0)
        )
    ]  # fmt: skip


def test_runs_are_told_by_their_seas_their_length_their_model_and_their_window():
    """A window that ends before the run does."""
    simulation = SimpleNamespace(duration=60.0, window=(20.5, 45.0))
    spec = SimpleNamespace(verify=SimpleNamespace(seas=8, model="linear", seed=3), simulation=simulation)
    assert verification._in_words(spec) == "8 seas of 60 s, linear, means from 20.5 to 45 s"


def test_designs_in_time_are_each_in_its_own_motions_on_the_study_s_spring_and_laws(seed, monkeypatch):
    """Of the database and the radiation memory, made if they are not there, beside the spring and without a damper."""
    pto = {"damping": 5e3, "stiffness": 700.0, "stroke_limit": 1.5}
    study, made = varied(seed, pto=pto, designs={"A": {"flexible": False}, "B": {}}), []
    plan = StudyPlan(study, root="elsewhere")
    monkeypatch.setattr(verification, "make", lambda plan, targets: made.append((plan.root, targets)))
    monkeypatch.setattr(verification, "linear_buoy", lambda *given: (given, "basis"))
    monkeypatch.setattr(verification, "radiation_model", lambda path: path)
    monkeypatch.setattr(verification, "rest_shape", lambda *given: given)
    monkeypatch.setattr(verification, "study_port", lambda *given: np.array([1.0, 2.0]))
    monkeypatch.setattr(verification, "design_motions", lambda study, basis, design: (basis, design))
    found = verification.in_time(study, "elsewhere")
    assert made == [("elsewhere", [plan.database_path, plan.radiation_path])]
    assert list(found) == ["A", "B"]
    for name, one in found.items():
        buoy = (study, plan.database_path)
        assert (one.buoy, one.shape, one.radiation) == (buoy, (study, buoy, "basis"), plan.radiation_path)
        assert (one.motions, one.pto) == (("basis", name), study.pto)
        assert (one.take_off.damping, one.take_off.stiffness) == (0.0, 700.0)
        assert one.take_off.direction(2).tolist() == [1.0, 2.0]


def test_the_seas_of_a_year_are_drawn_as_many_as_asked_by_the_seed_asked_for(monkeypatch):
    """By the year under the only tuning; where nothing is taken no sea is."""
    asked, power = [], np.array([[0.0], [2.0]])
    spec = SimpleNamespace(tuning=("one",), verify=SimpleNamespace(seas=8, seed=3, model="linear"))
    seas, swept = SimpleNamespace(hours="hours"), SimpleNamespace(of_year=lambda seas: ("water", seas))
    year, rest = SimpleNamespace(annual_mean_power=power), SimpleNamespace(basis="basis")
    monkeypatch.setattr(verification, "swept_shape", lambda *given: asked.append(given) or swept)
    monkeypatch.setattr(verification, "design_ports", lambda *given: asked.append(given) or "ports")
    monkeypatch.setattr(verification, "ports_year", lambda *given: asked.append(given) or year)
    monkeypatch.setattr(verification, "chances", lambda *given: ("chances", *given))
    monkeypatch.setattr(verification, "drawn", lambda *given: asked.append(given) or "sample")
    monkeypatch.setattr(verification, "in_time", lambda *given: ("designs", *given))
    monkeypatch.setattr(verification, "_powers", lambda *given: asked.append(given) or ("better", "linear"))
    monkeypatch.setattr(verification, "verified", lambda *given: ("verified", *given))
    monkeypatch.setattr(verification, "verified_dataset", lambda *given: given)
    monkeypatch.setattr(verification, "of_nothing", lambda year: "nothing")
    found = verification._of_viable(spec, "study", rest, seas, "root")
    assert asked == [
        ("study", "basis", "root"),
        ("study", rest, ("water", seas)),
        ("study", "ports", seas, ("one",)),
        (("chances", year, "one"), "hours", 8, 3),
        (spec, year, "sample", ("designs", "study", "root")),
    ]
    assert found == (year, "one", ("verified", year, "one", "sample", "better", "linear"))
    year.annual_mean_power = 0 * power
    assert verification._of_viable(spec, "study", rest, seas, "root") == "nothing"


@pytest.mark.parametrize("viable", [None, ("of the viable", "at rest")])
def test_designs_that_are_lost_stand_beside_those_that_were_run(seed, monkeypatch, viable):
    """All of the study's, over its rigid one; what is written says which runs, of what model, under which id."""
    study, asked = varied(seed, designs={"A": {}, "B": {"flexible": False}}), []
    spec = SimpleNamespace(simulated=study, climate="seas", verify=SimpleNamespace(model="linear"))
    ran = xr.Dataset(coords={"design": ["B"]})
    monkeypatch.setattr(verification, "read_climate", lambda *given: given)
    monkeypatch.setattr(verification, "viability", lambda of: SimpleNamespace(viable=viable))
    monkeypatch.setattr(verification, "_of_viable", lambda *given: asked.append(given) or ran)
    monkeypatch.setattr(verification, "with_lost", lambda *given: asked.append(given) or given[0])
    monkeypatch.setattr(verification, "_in_words", lambda spec: "words")
    monkeypatch.setattr(verification, "stamp", lambda spec: {"spec_id": "id"})
    monkeypatch.setattr(verification, "save", lambda ds, out: asked.append((ds.attrs, out)))
    verification.run(spec, "climate.nc", "root", "out.nc")
    if viable:
        assert asked.pop(0) == (spec, *viable, ("seas", "climate.nc"), "root")
    (found, names, reference), written = asked
    assert (list(found.design.values), names, reference) == (["B"] if viable else [], ["A", "B"], "B")
    assert written == ({"runs": "words", "model": "linear", "spec_id": "id"}, "out.nc")
