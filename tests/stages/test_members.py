"""A campaign in one process: members against a year computed apart, resumed, widened, damaged, not viable."""

import csv
import re
import subprocess
import sys
import time
from multiprocessing import get_context
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import SEED, varied

from vsb.errors import ConfigError, DatabaseError, VsbError
from vsb.hydro.database import Check
from vsb.motion.frequency import LinearBuoy
from vsb.results.year import frequencies, year
from vsb.scenes.afloat import linear_buoy, study_port
from vsb.scenes.rest import design_motions, reference_shell
from vsb.stages import answer, campaign, members
from vsb.stages.campaign_preview import campaign_summary
from vsb.stages.climate import read_climate
from vsb.stages.make import make
from vsb.stages.stage import STAGES
from vsb.stages.verify import verify
from vsb.study.blocks import COARSEST_SWEEP
from vsb.study.campaign_plan import plan_of
from vsb.study.plan import StudyPlan
from vsb.study.study import canonical, content_id
from vsb.tools import packed
from vsb.tools.files import load
from vsb.tools.units import check_finite
from vsb.waves.climate import Climate
from vsb.waves.seas import jonswap_spectrum

BASE = yaml.safe_load(SEED.read_text())
BASE["modes"]["degree"] = 2
BASE["designs"] = {"FSB": {"flexible": False}, "VSWEC": {}}
BASE["hydro"] = {"omega_max": 5.0}
HERTZ = np.linspace(0.04, 0.5, 24)
MODULI = {"device.young_modulus": [1e6, 1e7]}
THICKER = {**MODULI, "device.thickness": [0.01, 0.02, 0.04]}


def with_seas(place, *seas):
    """A folder with the spectra of an hour of each sea, (Hs, Tp), as a buoy would measure them."""
    lines = ["YY MM DD hh " + " ".join(f"{f:.4f}" for f in HERTZ)]
    for hour, (hs, tp) in enumerate(seas):
        density = 2 * np.pi * jonswap_spectrum(2 * np.pi * HERTZ, hs, tp, 2.0)
        lines.append(f"1996 01 01 {hour:02d} " + " ".join(f"{s:.5f}" for s in density))
    (place / "sea.txt").write_text("\n".join(lines) + "\n")
    return place


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return with_seas(tmp_path_factory.mktemp("campaign"), (1.0, 6.0), (2.2, 9.0), (2.3, 9.5), (3.1, 12.0))


def planned(folder, vary=None, name="sweep", tuning=None, **sections):
    raw = {**BASE, **sections, "study": f"{name}_study"}
    (folder / f"{name}_study.yaml").write_text(yaml.safe_dump(raw))
    given = {"campaign": name, "study": f"{name}_study.yaml", "vary": vary or {}, "climate": {"spectra": "sea.txt"}}
    given |= {"tuning": tuning} if tuning else {}
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(given, sort_keys=False))
    plan = plan_of(str(folder / f"{name}.yaml"))
    return type(plan)(plan.loaded, root=str(folder / "results"))


def told(stage, spec):
    """A specification as a job reads it."""
    (one,) = (each for each in STAGES if each.name == stage)
    return one.read(canonical(spec))


def batches(plan):
    for name, spec in plan.batches.items():
        members.run(
            told("members", spec), plan.loaded.climate_path, f"{plan.folder}/members", plan.root, plan.batch_path(name)
        )


def gather(plan):
    folders, files = (f"{plan.folder}/batches", f"{plan.folder}/verification"), (plan.data_path, plan.table_path)
    campaign.run(told("campaign", plan.campaign), *folders, *files, plan.manifest)


def run(plan):
    batches(plan)
    gather(plan)
    answer.run(
        told("answer", plan.campaign),
        plan.data_path,
        plan.loaded.climate_path,
        plan.root,
        f"{plan.folder}/figures",
        f"{plan.folder}/report.html",
        plan.manifest,
    )
    return load(plan.data_path, expected=plan.campaign_id)


@pytest.fixture(scope="module")
def swept(folder):
    plan = planned(folder, MODULI)
    return plan, run(plan)


def test_check_counts_the_members_that_are_there(folder, swept):
    plan, _ = swept
    assert any(line.startswith("points       2 of device.young_modulus, 2 done") for line in campaign_summary(plan))
    wider = planned(folder, THICKER)
    assert any("6 of device.young_modulus x device.thickness, 2 done" in line for line in campaign_summary(wider))
    planned(folder, MODULI)  # as it was, for other tests


def test_a_member_is_the_year_of_its_study(folder, swept):
    """The same study by its own database, the ordinary buoy and the year: a way that shares no coefficients."""
    plan, found = swept
    study = plan.members[1].study
    one = StudyPlan(study, root=str(folder / "apart"))
    make(one, [one.database_path])
    buoy, basis = linear_buoy(study, one.database_path)
    assert isinstance(buoy, LinearBuoy)
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    omega = frequencies(seas, *buoy.database.omega.values[[0, -1]])
    ports = {
        name: buoy.port(omega, design_motions(study, basis, name), np.eye(len(basis.labels))[0])
        for name in BASE["designs"]
    }
    apart = year(ports, seas, study.water, ("fixed", "one", "each"), dict.fromkeys(ports, 8000.0), "FSB").dataset()
    at = found.sel(young_modulus=1e7)
    for name in ("annual_mean_power", "annual_energy", "capture_width"):
        np.testing.assert_allclose(at[name].values, apart[name].values, rtol=1e-9, err_msg=name)
    np.testing.assert_allclose(at.power_matrix.sel(tuning="each"), apart.power_matrix.sel(tuning="each"), rtol=1e-9)
    # Where power is flat the best damper is known less well than it; so is what one for the year takes of one bin.
    for name in ("damping", "force_rms", "power_matrix"):
        np.testing.assert_allclose(at[name].values, apart[name].values, rtol=1e-6, err_msg=name)
    np.testing.assert_allclose(at.gain_percent.values, apart.gain_percent.values, atol=1e-7)


PLANAR = {
    "motion": "planar", "mooring": [2e4, 0, 0, 0, 0, 0], "modes": {"basis": "membrane", "degree": 2, "order": 2},
    "device": BASE["device"] | {"centre_of_mass": -0.6, "ballast_inertia": 9e3},
    "pto": {"damping": 8000.0, "port": {"line_to": [12.0, -9.0]}},
}  # fmt: skip


def test_the_year_of_a_buoy_that_surges_and_pitches(folder):
    """A line that takes off surge and heave, against its own database and the year; what falls over is not viable."""
    plan = planned(folder, {"device.centre_of_mass": [-0.6, 0.1]}, name="planar", **PLANAR)
    found = run(plan)
    study = plan.members[0].study
    one = StudyPlan(study, root=plan.root)
    make(one, [one.database_path])
    buoy, basis = linear_buoy(study, one.database_path)
    port = study_port(study, buoy, basis)
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    omega = frequencies(seas, *buoy.database.omega.values[[0, -1]])
    ports = {name: buoy.port(omega, design_motions(study, basis, name), port) for name in BASE["designs"]}
    apart = year(ports, seas, study.water, ("fixed", "one", "each"), dict.fromkeys(ports, 8000.0), "FSB").dataset()
    at = found.sel(centre_of_mass=-0.6)
    assert at.viable.values.all()
    np.testing.assert_allclose(at.annual_energy.values, apart.annual_energy.values, rtol=1e-6)
    fallen = found.sel(centre_of_mass=0.1)
    assert not fallen.viable.values.any()
    assert set(fallen.reason.values) == {"does not stay upright"}
    assert np.isnan(fallen.annual_energy).all()


def test_the_table_holds_the_dataset(swept):
    plan, found = swept
    rows = list(csv.DictReader(Path(plan.table_path).read_text().splitlines()))
    assert len(rows) == 2 * 2 * 3
    for row in rows:
        at = found.sel(young_modulus=float(row["device.young_modulus"]), design=row["design"], tuning=row["tuning"])
        assert float(row["annual_energy"]) == pytest.approx(float(at.annual_energy), rel=1e-11)
        assert (row["damping"] == "") == (row["tuning"] == "each")
        if row["tuning"] == "fixed":
            assert float(row["damping"]) == 8000.0


def test_every_variable_has_units(swept):
    _, found = swept
    numbers = [v for v in found.variables.values() if v.dtype.kind in "fi"]
    assert all("units" in variable.attrs and "long_name" in variable.attrs for variable in numbers)
    assert found.young_modulus.attrs["units"] == "Pa"
    assert found.power_matrix.dims == ("young_modulus", "design", "tuning", "hs", "te")


def test_the_curve_of_dampers_has_its_top_at_the_best_one(swept):
    _, found = swept
    best = found.sel(tuning="one").damping.where(found["count"] > 0).max(("hs", "te"))
    middle = found.tried_damping.isel(damper=30)
    np.testing.assert_allclose(middle, best, rtol=1e-9)
    assert bool((found.power_of_damping.argmax("damper") == 30).all())
    np.testing.assert_allclose(
        found.power_of_damping.isel(damper=30), found.annual_mean_power.sel(tuning="one"), rtol=1e-9
    )
    np.testing.assert_allclose(found.force_of_damping.isel(damper=30), found.force_rms.sel(tuning="one"), rtol=1e-9)


def test_a_member_without_limits_reads_nothing_that_is_compiled_or_opens_meshes():
    """Starting takes as long as dozens of members."""
    heavy = {"numba", "meshio", "capytaine", "matplotlib"}
    script = f"import sys, vsb.stages.members; print({heavy} & {{*sys.modules}})"
    assert (
        subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout == "set()\n"
    )


def test_a_widened_sweep_computes_new_points_alone(folder, swept, monkeypatch):
    _, found = swept
    made = []
    monkeypatch.setattr(members.Work, "results", _counted(made, members.Work.results))
    wide = planned(folder, {"device.young_modulus": [1e6, 3e6, 1e7]})
    again = run(wide)
    assert made == [wide.members[1].id]
    np.testing.assert_array_equal(again.power_matrix.sel(young_modulus=[1e6, 1e7]), found.power_matrix)


def test_a_map_has_every_point_in_its_place(folder):
    plan = planned(folder, THICKER, name="map")
    found = run(plan)
    assert found.annual_energy.dims[:2] == ("young_modulus", "thickness")
    for one in plan.members:
        point = {key.rpartition(".")[2]: value for key, value in one.point.items()}
        stored = packed.load(f"{plan.folder}/members/{one.id}.npz", expected=one.id)
        assert float(found.margin.sel(point)) == float(stored.margin)
        np.testing.assert_array_equal(found.annual_energy.sel(point), stored.annual_energy)


def test_what_is_damaged_is_computed_anew_to_the_same_bytes(folder, swept, capsys):
    plan = planned(folder, MODULI)
    path = folder / "results" / "sweep" / "members" / f"{plan.members[0].id}.npz"
    before, data = path.read_bytes(), (folder / "results" / "sweep" / "campaign.nc")
    batches(plan)
    gather(plan)
    whole = data.read_bytes()
    path.write_bytes(before[:-200] + b"x" + before[-199:])
    with pytest.raises(VsbError, match="its contents are not those it was written with"):
        verify(plan.folder, heal=False)
    batches(plan)
    gather(plan)
    assert "computed anew" in capsys.readouterr().out
    assert path.read_bytes() == before
    assert data.read_bytes() == whole


@pytest.mark.parametrize("seed", range(2))
def test_killed_anywhere_and_resumed_it_ends_in_the_same_bytes(folder, seed):
    """Killed five times on its way, each time at another point drawn at random."""
    plan = planned(folder, {"device.young_modulus": {"log": [1e6, 1e9, 12]}}, name="killed")
    whole, cut = (type(plan)(plan.loaded, root=str(folder / name)) for name in ("whole", f"cut{seed}"))
    begun = time.perf_counter()
    batches(whole)
    gather(whole)
    seconds, random = time.perf_counter() - begun, np.random.default_rng(seed)
    for _ in range(5):
        job = get_context("fork").Process(target=batches, args=(cut,))
        job.start()
        time.sleep(random.uniform(0.0, 0.5 * seconds))
        job.kill()
        job.join()
    batches(cut)
    gather(cut)
    for batch in plan.batches:
        assert Path(cut.batch_path(batch)).read_bytes() == Path(whole.batch_path(batch)).read_bytes()
    for name in ("data_path", "table_path"):
        assert Path(getattr(cut, name)).read_bytes() == Path(getattr(whole, name)).read_bytes()


def test_what_is_not_viable_is_a_result(folder):
    """At its equilibrium the vented seed buckles; with internal pressure it does not."""
    plan = planned(
        folder, {"device.internal_pressure": [0.0, 25e3]}, name="pressed", reference_shape="equilibrium"
    )  # fmt: skip
    found = run(plan)
    assert found.viable.sel(internal_pressure=0.0).values.tolist() == [False, False]
    assert found.viable.sel(internal_pressure=25e3).values.tolist() == [True, True]
    assert (found.margin.values > 0).tolist() == [False, True]
    lost = found.sel(internal_pressure=0.0)
    assert all(np.isnan(lost[name]).all() for name in ("annual_energy", "power_matrix", "gain_percent", "damping"))
    assert all(text.startswith("no equilibrium: the shell buckles") for text in lost.reason.values)
    check_finite(found, "all that is viable")
    rows = list(csv.DictReader(Path(plan.table_path).read_text().splitlines()))
    assert {row["annual_energy"] == "" for row in rows if row["viable"] == "false"} == {True}


@pytest.mark.parametrize(
    ("pto", "missing"),
    [
        ({"damping": 8e3, "port": {"between": [0, 180]}}, ["fixed", "one"]),
        ({"damping": 8e3, "port": {"colatitude": 90, "against": "frame", "direction": "radial"}}, ["fixed", "one"]),
        ({"damping": 0.0}, ["fixed"]),
    ],
    ids=["between", "frame", "nothing"],
)
def test_where_the_rigid_design_takes_nothing_there_are_no_gains_and_all_the_rest(folder, pto, missing):
    """Its shell does not move, or the damper is none; under a tuning of its own it may take some."""
    plan = planned(folder, name="over_nothing", tuning=["fixed", "one"], pto=pto)
    found = run(plan)
    gains = found.gain_percent.sel(design="VSWEC")
    assert found.tuning.values[np.isnan(gains)].tolist() == missing
    assert (found.annual_mean_power.sel(design="FSB") > 0).values.tolist() == [
        name not in missing for name in ("fixed", "one")
    ]
    assert float(found.annual_mean_power.sel(design="VSWEC", tuning="one")) > 0
    rows = list(csv.DictReader(Path(plan.table_path).read_text().splitlines()))
    assert {row["tuning"] for row in rows if row["gain_percent"] == ""} == set(missing)


@pytest.mark.parametrize("vary", [{}, {"device.mass": [17e3, 18e3]}], ids=["one point", "two"])
def test_where_no_design_is_viable_at_any_point_the_campaign_says_so(folder, vary):
    plan = planned(
        folder, vary, name="lost", reference_shape="equilibrium", designs={"VSWEC": {}, "FSB": {"flexible": False}}
    )
    found = run(plan)
    assert not found.viable.values.any()
    page = Path(plan.folder, "report.html").read_text()
    assert "no design is viable" in page
    words = re.sub(r"<(script|style|svg).*?</\1>|<[^>]*>", " ", page, flags=re.DOTALL).lower().split()
    assert not {"nan", "nan%", "inf"} & set(words)


def test_a_climate_that_changed_is_refused(folder):
    plan = planned(folder)
    with pytest.raises(ConfigError, match="changed since the run was planned"):
        read_climate(plan.climate.model_copy(update={"contents": "0" * 16}), plan.loaded.climate_path)
    with pytest.raises(ConfigError, match="cannot be read"):
        read_climate(plan.climate, str(folder / "absent.txt"))


def test_pairs_have_one_dimension_with_keys_as_coordinates(folder):
    found = run(planned(folder, {**MODULI, "device.thickness": [0.01, 0.02], "pairs": True}, name="pairs"))
    assert found.margin.dims == ("member",)
    assert found.thickness.values.tolist() == [0.01, 0.02]
    assert found.young_modulus.dims == ("member",)


def test_a_campaign_may_vary_nothing(folder):
    found = run(planned(folder, name="single"))
    assert found.annual_energy.dims == ("design", "tuning")
    assert found.margin.dims == ()


def _counted(made, results):
    """The results of a member, its id noted."""

    def counted(self, one):
        made.append(one.id)
        return results(self, one)

    return counted


def test_limits_of_the_take_off_are_an_axis_of_the_best_force(folder):
    """The best force within them takes the more the wider they are; a damper is told of none of them."""
    plan = planned(folder, {"pto.force_limit": [2e3, 2e4]}, name="scarce", tuning=["constrained"])
    found = run(plan)
    assert found.force_limit.attrs["units"] == "N"
    power = found.annual_mean_power.sel(tuning="constrained")
    assert bool((power.sel(force_limit=2e4) > 2 * power.sel(force_limit=2e3)).all())
    assert bool((found.power_bound >= power).all())
    rows = list(csv.DictReader(Path(plan.table_path).read_text().splitlines()))
    assert len(rows) == 2 * 2
    for row in rows:
        at = found.sel(force_limit=float(row["pto.force_limit"]), design=row["design"])
        assert row["damping"] == row["practice_power"] == ""
        assert float(row["power_bound"]) == pytest.approx(float(at.power_bound), rel=1e-11)
    page = Path(f"{plan.folder}/report.html").read_text()
    assert "under the best force there is within its limits" in page
    assert "knows all waves beforehand" in page


def test_seas_beyond_what_is_described_are_told(folder, swept):
    plan, found = swept
    assert found.beyond_validity.dims == found.power_matrix.dims
    assert found.energy_beyond.limit.values.tolist() == ["steepness", "breaking", "deformation", "heave"]
    union = found.energy_beyond.sel(limit=["steepness", "breaking", "deformation"])
    assert bool((found.energy_beyond_validity <= union.sum("limit") + 1e-12).all())
    assert bool((found.energy_beyond_validity >= union.max("limit") - 1e-12).all())
    rows = csv.DictReader(Path(plan.table_path).read_text().splitlines())
    shares = [float(row["energy_beyond_validity"]) for row in rows]
    np.testing.assert_allclose(shares, found.energy_beyond_validity.values.ravel(), rtol=1e-9)
    assert "of the energy is from seas beyond what is described" in Path(f"{plan.folder}/report.html").read_text()


def known(omega, order=0):
    """A buoy whose coefficients are known in a band: they are the frequency itself."""
    label = "Radial2"
    return SimpleNamespace(
        labels=(label,), coefficients=lambda at: (order, at), database=xr.Dataset(coords={"omega": omega})
    )


@pytest.mark.parametrize("highest", [1.2, 2.4, 9.0])
def test_a_year_is_known_as_far_as_both_the_shape_and_its_seas_go(highest):
    """Up to the highest frequency solved, or that of the seas where they end before; every order at the same ones."""
    density = np.exp(-((np.arange(1.0, 4.0, 0.1) - 1.5) ** 2))
    seas = Climate.of_spectra(np.arange(1.0, 4.0, 0.1), density[None], np.ones(1), "a sea")
    solved = np.linspace(0.2, highest, 24)
    swept = members.Swept((known(solved), known(solved, order=1)))
    year = swept.of_year(seas)
    assert year.omega[[0, -1]] == pytest.approx([0.95, min(highest, 3.95)])
    np.testing.assert_array_equal(year.omega, frequencies(seas, 0.2, highest))
    assert [one.coefficients[0] for one in (year, *year.orders)] == [0, 1]
    for one in (year, *year.orders):
        np.testing.assert_array_equal(one.coefficients[1], year.omega)
    assert swept.of_year(seas) is year
    longer = Climate.of_spectra(np.arange(0.5, 1.0, 0.05), np.ones((1, 10)), np.ones(1), "a swell")
    np.testing.assert_array_equal(swept.of_year(longer).omega, frequencies(longer, 0.2, highest))
    np.testing.assert_array_equal(swept.of_year(seas).omega, year.omega)


def test_a_shape_is_solved_where_the_campaign_s_results_are(seed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    asked = []
    monkeypatch.setattr(members, "solve", lambda plan: asked.append(plan.root))
    monkeypatch.setattr(members, "_of_order", lambda plan, *_: asked.append(plan.root))
    members.swept_shape(seed, reference_shell(seed).basis, "elsewhere")
    assert asked == ["elsewhere"] * 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("order", [0, 1])
def test_a_member_s_water_is_judged_as_a_database_is_and_what_a_study_accepts_is_accepted(seed, monkeypatch, order):
    asked = []
    failing = Check("haskind", 1.0, 0.01, "-", "fail", "why")
    monkeypatch.setattr(members.quality, "verdict", lambda *given: asked.append(given) or [failing])
    with pytest.raises(DatabaseError, match="check 'haskind' failed"):
        members._judge(seed, [], "sweep", order)
    members._judge(varied(seed, hydro={"accept": ["haskind"]}), [], "sweep", order)
    sweep, tabulated, water, precision, of = asked[0]
    assert (sweep, tabulated, water, of) == ("sweep", None, seed.water, order)
    assert 0 < precision <= 1.0


def test_a_shape_is_kept_while_members_of_it_follow_and_years_are_of_its_own_water(monkeypatch):
    made, asked = [], []

    def swept_shape(study, basis, root):
        made.append((study, basis, root))
        return SimpleNamespace(of_year=lambda climate: (study, climate), at=lambda omega: (study, omega))

    monkeypatch.setattr(members, "swept_shape", swept_shape)
    monkeypatch.setattr(members, "member", lambda *given: asked.append(given) or "results")
    work = members.Work("climate", SimpleNamespace(tuning=("one", "each"), constrained=None), "root")
    for number, shape in enumerate(
        ["ac", "ac", "bc", "bc", "bd"]
    ):  # blocks of which some may be those of another shape
        one = SimpleNamespace(study=f"study {number}", spec=SimpleNamespace(sweep=tuple(shape)))
        assert work.results(one) == "results"
        study, water, *others = asked[-1]
        assert (study, others) == (one.study, ["climate", ("one", "each"), None, work._rigid])
        assert others[-1] is work._rigid  # years that members share
        assert water("basis") == (made[-1][0], "climate")
    assert made == [(f"study {number}", "basis", "root") for number in (0, 2, 4)]


@pytest.mark.parametrize(
    ("hydro", "precision"),
    [
        ({"tolerance": 0.1 * COARSEST_SWEEP}, 0.1),
        ({"tolerance": COARSEST_SWEEP}, 1.0),
        ({"tolerance": 10 * COARSEST_SWEEP}, 1.0),
        ({"tolerance": 0.1 * COARSEST_SWEEP, "rows": 16}, 1.0),
    ],
)
def test_errors_of_all_blocks_count_and_a_finer_sweep_is_held_to_finer_limits(seed, monkeypatch, hydro, precision):
    """Never to coarser ones, and panels to the same whatever the tolerance; the worst block decides."""
    study, told = varied(seed, hydro=hydro), []
    blocks = [xr.Dataset(attrs={"error_estimate": part * study.hydro.tolerance}) for part in (0.1, 3.0, 0.2)]
    monkeypatch.setattr(members.quality, "verdict", lambda *given: told.append(given) or [])
    monkeypatch.setattr(members.quality, "judged", lambda checks, accept: told.append((checks, accept)) or [])
    members._judge(study, blocks, "sweep", 2)
    (sweep, tabulated, water, found, order), (checks, accept) = told
    assert (sweep, tabulated, water, order) == ("sweep", None, study.water, 2)
    assert found == pytest.approx(precision)
    assert accept == study.hydro.accept
    (error,) = checks
    assert (error.name, error.limit) == ("error_estimate", study.hydro.tolerance)
    assert error.value == pytest.approx(3.0 * study.hydro.tolerance)
    assert error.verdict == "doubt"  # panels may not reach what is asked


def test_coefficients_of_an_order_are_of_its_own_blocks_in_the_study_s_water(seed, monkeypatch):
    """Each by its id; of orders from one on damping is Haskind's, of heave and axisymmetric modes it is solved."""
    water = {"depth": 7.0, "density": 1010.0, "gravity": 9.5}
    study, asked = varied(seed, water=water), []
    blocks = {f"{order}{part}": SimpleNamespace(order=order) for order in (0, 1, 2) for part in "ab"}
    paths = {id(block): f"blocks/{name}.nc" for name, block in blocks.items()}
    plan = SimpleNamespace(
        study=study, sweep_blocks=list(blocks.values()), block_path=lambda block: paths[id(block)]
    )  # fmt: skip
    raw = xr.Dataset(coords={"influenced_dof": ["a", "b", "c"]})
    stored = {name: SimpleNamespace(attrs={"error_estimate": 0.1 * i}) for i, name in enumerate(blocks)}
    monkeypatch.setattr(members, "load", lambda path, expected: asked.append((path, expected)) or stored[expected])
    monkeypatch.setattr(members.database, "merged_blocks", lambda found: ("merged", *found))
    monkeypatch.setattr(members.database, "with_excitation", lambda whole: ("excited", *whole))
    monkeypatch.setattr(members.database, "in_modes", lambda whole, basis: ("modes", whole, basis))
    monkeypatch.setattr(members.orders, "in_wet_modes", lambda whole, family: ("wet", whole, family))
    monkeypatch.setattr(members.database, "with_symmetrized", lambda whole: raw)
    monkeypatch.setattr(members.orders, "with_haskind_damping", lambda *given: asked.append(given) or raw)
    monkeypatch.setattr(members, "_judge", lambda *given: asked.append(given))
    monkeypatch.setattr(members, "LinearBuoy", lambda *given: given)
    for order, family in ((0, None), (1, SimpleNamespace(order=1)), (2, SimpleNamespace(order=2))):
        asked.clear()
        database, damping, take_off = members._of_order(plan, "basis", family)
        own = [f"{order}a", f"{order}b"]
        files = [stored[name] for name in own]
        whole = ("excited", "merged", *files)
        assert asked[:2] == [(f"blocks/{name}.nc", name) for name in own]
        sweep = ("wet", whole, family) if family else ("modes", whole, "basis")
        assert asked[2] == (study, files, sweep, order)
        assert asked[3:] == ([(raw, order, 7.0, 1010.0, 9.5)] if order else [])
        assert database.influenced_dof.identical(raw.influenced_dof)
        assert database.attrs == {"error_estimate": 0.1 * (2 * order + 1), "interpolation_error": 0.0}
        assert (damping.shape, damping.any(), take_off.damping) == ((3, 3), False, 0.0)


def test_years_within_limits_are_of_the_member_s_own_water_seconds_and_seed(monkeypatch):
    """And share what was found of rigid designs; without limits nothing is read."""
    given = []
    monkeypatch.setattr("vsb.results.constrained_member.Optima", lambda *one: given.append(one))
    work = members.Work("climate", SimpleNamespace(constrained=SimpleNamespace(seconds=70.0, seed=5)), "root")
    monkeypatch.setattr(members.Work, "swept", lambda self, one, basis: SimpleNamespace(at=lambda w: (one, basis, w)))
    work._years_within("member")
    ((water, seconds, seed, optima),) = given
    assert (seconds, seed) == (70.0, 5)
    assert optima is work._optima
    assert optima is not work._rigid
    assert water("basis", "omega") == ("member", "basis", "omega")
    none = members.Work("climate", SimpleNamespace(constrained=None), "root")
    assert none._years_within("member") is None
    assert len(given) == 1


def test_a_batch_is_all_its_members_in_their_order_each_kept_by_itself(tmp_path, monkeypatch):
    """Known by their ids together."""
    batch, made = [SimpleNamespace(id=name) for name in ("b", "a", "c")], []
    spec = SimpleNamespace(base="base", points="points", climate="seas", tuning=("one",), constrained="limits")
    monkeypatch.setattr(members, "members", lambda *given: given == tuple(vars(spec).values()) and batch)
    monkeypatch.setattr(members, "read_climate", lambda *given: given)
    monkeypatch.setattr(members, "finished", lambda path, one, work: made.append((path, one.id, work)) or one.id)
    monkeypatch.setattr(members, "stacked", lambda found, ids: xr.Dataset(attrs={"found": found, "ids": ids}))
    monkeypatch.setattr(members, "save", lambda ds, out: made.append((ds.attrs, out)))
    members.run(spec, "climate.nc", "folder", "root", "out.nc")
    (attrs, out), works = made.pop(), [work for *_, work in made]
    assert [(path, name) for path, name, _ in made] == [(Path(f"folder/{name}{packed.SUFFIX}"), name) for name in "bac"]
    assert all(work is works[0] for work in works)
    assert (works[0].climate, works[0].spec, works[0].root) == (("seas", "climate.nc"), spec, "root")
    ids = ["b", "a", "c"]
    assert (attrs, out) == ({"found": ids, "ids": ids, "spec_id": content_id(ids)}, "out.nc")


@pytest.mark.parametrize(("there", "sound"), [(False, False), (True, False), (True, True)])
def test_a_member_that_is_there_is_kept_and_of_one_that_is_damaged_it_is_said(
    tmp_path, monkeypatch, capsys, there, sound
):
    """What is written says what it is of."""
    path, one, saved = tmp_path / "x.npz", SimpleNamespace(id="id", spec="spec"), []
    if there:
        path.touch()

    def loaded(where, expected):
        if sound:
            return where, expected
        raise DatabaseError(f"{where}: is no {expected}.")

    monkeypatch.setattr(members.packed, "load", loaded)
    monkeypatch.setattr(members.packed, "save", lambda ds, where: saved.append((ds.attrs, where)))
    monkeypatch.setattr(members, "canonical", lambda spec: f"canonical {spec}")
    work = SimpleNamespace(results=lambda of: xr.Dataset(attrs={"of": of.id}))
    found = members.finished(path, one, work)
    if sound:
        assert (found, saved) == ((path, "id"), [])
    else:
        attrs = {"of": "id", "spec": "canonical spec", "spec_id": "id"}
        assert (found.attrs, saved) == (attrs, [(attrs, path)])
    told = f"{path}: is no id. It is computed anew.\n" if there and not sound else ""
    assert capsys.readouterr().out == told


def test_coefficients_of_every_order_are_in_its_own_displacements(monkeypatch):
    """By its own labels, at the frequencies asked for; outside those solved with the coefficients of the nearest end."""
    monkeypatch.setattr(members, "displacements", lambda labels, order: (labels, order))
    omega, solved = np.array([0.1, 0.5, 0.7, 9.0]), np.linspace(0.2, 4.0, 24)
    buoys = tuple(known(solved, order=order) for order in range(3))
    for order, buoy in enumerate(buoys):
        buoy.labels = (f"label {order}",)
    found = members.Swept(buoys).at(omega)
    for order, one in enumerate((found, *found.orders)):
        moved, at, coefficients = (getattr(one, name) for name in list(vars(one))[:3])
        assert (moved, coefficients[0]) == (((f"label {order}",), order), order)
        assert at is omega
        np.testing.assert_array_equal(coefficients[1], [0.2, 0.5, 0.7, 4.0])
