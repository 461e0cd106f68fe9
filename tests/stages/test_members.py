"""Campaigns in one process: members against their studies, sweeps, damage and resume, designs that are not viable."""

import csv
import io
import time
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
import yaml
from conftest import SEED

from vsb.api.campaign import Campaign
from vsb.engine.motion.tuning import best_matrix
from vsb.engine.waves.kinds import jonswap_spectrum
from vsb.errors import VsbError
from vsb.models.floating_system import floating_system
from vsb.pipeline.graph import StudyPlan
from vsb.pipeline.plans import plan_of
from vsb.results.budget import left_out_of_year
from vsb.results.year import band_weights, frequencies, year
from vsb.stages.check import read_climate
from vsb.stages.make import make
from vsb.stages.stage import run_task
from vsb.stages.verify import verify
from vsb.tools.files import load
from vsb.tools.packed import Pack, packs

BASE = yaml.safe_load(SEED.read_text())
BASE["modes"] |= {"degree": 2, "tolerance": 0.1}
BASE["designs"] = {"FSB": {"flexible": False}, "VSWEC": {}}
BASE["hydro"] = {"omega_max": 5.0}
HERTZ = np.linspace(0.04, 0.5, 24)
MODULI = {"device.young_modulus": [1e7, 1e8]}


def with_seas(place, *seas):
    """Write one hourly spectrum of each sea (Hs, Tp) to a folder, in the format of a buoy."""
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


def batches(plan):
    for task in plan.batches.values():
        run_task(task)


def gather(plan):
    run_task(plan.campaign)


def computed(plan):
    """Data of a campaign without its report."""
    batches(plan)
    gather(plan)
    return load(plan.data_path, expected=plan.identity)


def run(plan):
    """Data of a campaign with its report."""
    found = computed(plan)
    run_task(plan.report)
    return found


@pytest.fixture(scope="module", autouse=True)
def given_modes():
    """Years without the error of shell modes left out, whose water is solved to high degrees: no test of these is it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vsb.results.campaign.left_out_of_year", lambda *_: None)
        yield


@pytest.fixture(scope="module")
def swept(folder):
    plan = planned(folder, MODULI)
    return plan, computed(plan)


def year_apart(plan, study, root):
    """The year of a member's study from its own database in a folder of results."""
    one = StudyPlan(study, root=root)
    make(one, [one.database.out])
    floating = floating_system(study, one.database.out)
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    ports = floating.ports(frequencies(seas, *floating.linear.database.omega.values[[0, -1]]))
    return year(ports, seas, study.water, ("fixed", "one", "each"), dict.fromkeys(ports, 8000.0), "FSB").dataset()


def test_campaign_member_equals_the_year_of_its_study(folder, swept):
    """Computed from the database of the study, which shares no coefficients with the campaign."""
    plan, found = swept
    study = plan.members[1].study
    apart = year_apart(plan, study, str(folder / "apart"))
    at = found.sel(young_modulus=study.device.young_modulus)
    for name in ("annual_mean_power", "annual_energy", "capture_width"):
        np.testing.assert_allclose(at[name].values, apart[name].values, rtol=1e-9, err_msg=name)
    np.testing.assert_allclose(at.power_matrix.sel(tuning="each"), apart.power_matrix.sel(tuning="each"), rtol=1e-9)
    for name in ("damping", "force_rms", "power_matrix"):
        np.testing.assert_allclose(at[name].values, apart[name].values, rtol=1e-6, err_msg=name)
    np.testing.assert_allclose(at.gain_percent.values, apart.gain_percent.values, atol=1e-7)


def test_member_of_another_shape_equals_the_year_of_its_study(folder, tmp_path):
    """A capsule under pressure, the longer one of two."""
    device = {
        "radius": 1.5, "shape": {"capsule": {"length": 1.0}}, "thickness": 0.03, "young_modulus": 5e7,
        "poisson_ratio": 0.3, "density": 1100.0, "internal_pressure": 3e4,
    }  # fmt: skip
    more = {"device": device, "modes": {"degree": 4}, "reference_shape": "equilibrium", "hydro": {"omega_max": 9.0}}
    plan = planned(folder, {"device.shape.capsule.length": [1.0, 1.5]}, "capsule", **more)
    found = computed(plan)
    apart, at = year_apart(plan, plan.members[1].study, str(tmp_path / "apart")), found.sel(length=1.5)
    for name in ("annual_mean_power", "capture_width"):
        np.testing.assert_allclose(at[name].values, apart[name].values, rtol=1e-6, err_msg=name)
    np.testing.assert_allclose(at.gain_percent.values, apart.gain_percent.values, atol=1e-5)


def test_scatter_figure_shows_the_share_of_hours_of_each_bin(swept):
    plan, found = swept
    ax = Campaign(plan.folder).plot.scatter()
    drawn = np.ma.asarray(ax.collections[0].get_array()).compressed()
    assert np.nansum(drawn) == pytest.approx(100.0)
    corners = ax.collections[0].get_coordinates()
    for axis, bins in enumerate((found.te.values, found.hs.values)):  # a cell lies about the centre of its bin
        edges = corners[0, :, 0] if axis == 0 else corners[:, 0, 1]
        centres = (edges[1:] + edges[:-1])[:, None] / 2
        np.testing.assert_allclose(np.abs(centres - bins).min(axis=1), 0.0, atol=1e-9)
    assert sorted(drawn[drawn > 0]) == pytest.approx(sorted(100 * found.occurrence.values[found["count"].values > 0]))


PLANAR = {
    "motion": "planar", "mooring": [2e4, 0, 0, 0, 0, 0], "modes": {"basis": "membrane", "degree": 1, "order": 1},
    "designs": {"FSB": {"flexible": False}}, "hydro": {"omega_max": 4.0, "tolerance": 1e-2},
    "device": BASE["device"] | {"centre_of_mass": -0.6, "ballast_inertia": 9e3},
    "pto": {"damping": 8000.0, "port": {"line_to": [12.0, -9.0]}},
}  # fmt: skip


def test_year_of_a_buoy_in_surge_and_pitch(folder):
    """With a take-off line in surge and heave; a buoy that capsizes is not viable."""
    plan = planned(folder, {"device.centre_of_mass": [-0.6, 0.1]}, name="planar", **PLANAR)
    found = computed(plan)
    study = plan.members[0].study
    apart = year_apart(plan, study, plan.root)
    at = found.sel(centre_of_mass=-0.6)
    assert at.viable.values.all()
    np.testing.assert_allclose(at.annual_energy.values, apart.annual_energy.values, rtol=1e-6)
    fallen = found.sel(centre_of_mass=0.1)
    assert not fallen.viable.values.any()
    assert set(fallen.reason.values) == {"does not stay upright"}
    assert np.isnan(fallen.annual_energy).all()


def test_widened_sweep_computes_only_new_points(folder, swept):
    plan, found = swept
    before = {path: path.stat().st_mtime_ns for path in Path(plan.folder, "members").iterdir()}
    wide = planned(folder, {"device.young_modulus": [1e7, 3e7, 1e8]})
    again = computed(wide)
    assert {path: path.stat().st_mtime_ns for path in before} == before
    (new,) = [Pack(path) for path in Path(plan.folder, "members").iterdir() if path not in before]
    assert [*new.places] == [wide.members[1].id]
    np.testing.assert_array_equal(again.power_matrix.sel(young_modulus=[1e7, 1e8]), found.power_matrix)


def test_damaged_member_is_recomputed_to_the_same_bytes(folder, swept, capsys):
    plan = planned(folder, MODULI)
    pack, data = packs(folder / "results" / "sweep" / "members")[plan.members[0].id], Path(plan.data_path)
    batches(plan)
    gather(plan)
    whole, before = data.read_bytes(), pack.path.read_bytes()
    at = pack.places[plan.members[0].id][1] - 200
    pack.path.write_bytes(before[:at] + b"x" + before[at + 1 :])
    with pytest.raises(VsbError, match="its contents are not those it was written with"):
        verify(plan.folder)
    batches(plan)
    gather(plan)
    assert "computed anew" in capsys.readouterr().out
    assert data.read_bytes() == whole
    batches(plan)
    assert "computed anew" not in capsys.readouterr().out


@pytest.mark.slow
def test_killed_campaign_resumes_to_the_same_bytes(folder):
    """Killed three times at random instants."""
    plan = planned(folder, {"device.young_modulus": {"log": [1e6, 1e9, 6]}}, name="killed")
    whole, cut = (type(plan)(plan.loaded, root=str(folder / name)) for name in ("whole", "cut"))
    begun = time.perf_counter()
    batches(whole)
    gather(whole)
    seconds, random = time.perf_counter() - begun, np.random.default_rng(0)
    for _ in range(3):
        job = get_context("fork").Process(target=batches, args=(cut,))
        job.start()
        time.sleep(random.uniform(0.0, 0.5 * seconds))
        job.kill()
        job.join()
    batches(cut)
    gather(cut)
    for batch in plan.batches:
        assert Path(cut.batches[batch].out).read_bytes() == Path(whole.batches[batch].out).read_bytes()
    for one, other in zip(cut.campaign.makes, whole.campaign.makes, strict=True):
        assert Path(one).read_bytes() == Path(other).read_bytes()


def test_designs_that_buckle_are_recorded_as_not_viable(folder):
    """The seed at its equilibrium buckles without internal pressure."""
    plan = planned(
        folder, {"device.internal_pressure": [0.0, 25e3]}, name="pressed", reference_shape="equilibrium",
        device={**BASE["device"], "young_modulus": 4e7},
    )  # fmt: skip
    found = computed(plan)
    assert found.viable.sel(internal_pressure=0.0).values.tolist() == [False, False]
    assert found.viable.sel(internal_pressure=25e3).values.tolist() == [True, True]
    assert (found.margin.values > 0).tolist() == [False, True]
    lost = found.sel(internal_pressure=0.0)
    assert all(np.isnan(lost[name]).all() for name in ("annual_energy", "power_matrix", "gain_percent", "damping"))
    assert all(text.startswith("no equilibrium: the shell buckles") for text in lost.reason.values)
    rows = list(csv.DictReader(Path(plan.campaign.makes[1]).read_text().splitlines()))
    assert {row["annual_energy"] == "" for row in rows if row["viable"] == "false"} == {True}


@pytest.mark.parametrize(
    ("pto", "missing"),
    [({"damping": 8e3, "port": {"between": [0, 180]}}, ["fixed", "one"]), ({"damping": 0.0}, ["fixed"])],
    ids=["between two points of the shell", "no damping"],
)
def test_no_gain_is_given_where_the_rigid_design_absorbs_nothing(folder, pto, missing):
    """Its port does not move, or nothing damps it."""
    plan = planned(folder, name="over_nothing", tuning=["fixed", "one"], pto=pto)
    found = computed(plan)
    gains = found.gain_percent.sel(design="VSWEC")
    assert found.tuning.values[np.isnan(gains)].tolist() == missing
    assert (found.annual_mean_power.sel(design="FSB") > 0).values.tolist() == [
        name not in missing for name in ("fixed", "one")
    ]
    assert float(found.annual_mean_power.sel(design="VSWEC", tuning="one")) > 0


TWO = {"ports": {"a": "heave", "b": "volume"}, "damping": [[8e3, 0.0], [0.0, 0.0]]}


def test_year_of_a_damper_matrix_that_acts_on_heave_alone_is_that_of_a_damper(folder):
    alike = {"tuning": ["fixed"], "designs": {"VSWEC": {}}}
    plan = planned(folder, name="matrix", pto=TWO, **alike)
    found, alone = run(plan), computed(planned(folder, name="damper", pto={"damping": 8e3}, **alike))
    for name in ("annual_mean_power", "power_matrix", "practice_power", "quadrature_error"):
        np.testing.assert_allclose(found[name], alone[name], rtol=1e-9, atol=1e-9, err_msg=name)
    for name in ("energy_beyond", "beyond_validity"):
        np.testing.assert_allclose(found[name], alone[name], rtol=1e-6, err_msg=name)
    assert found.damper_matrix.sel(design="VSWEC", tuning="fixed").values.tolist() == TWO["damping"]
    first = next(csv.DictReader(io.StringIO(Path(plan.campaign.makes[1]).read_text())))
    assert first["damper_matrix"] == "[[8000.0, 0.0], [0.0, 0.0]]"
    assert "damper matrix" in Path(plan.folder, "report.html").read_text()


def year_at_ports(plan):
    """Seas of a campaign, several ports of the flexible design of its first member, and weights of their frequencies."""
    study = StudyPlan(plan.members[0].study, root=plan.root)
    make(study, [study.database.out])
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    floating = floating_system(study.study, study.database.out)
    omega = frequencies(seas, *floating.band)
    return seas, floating.several_ports(omega)["VSWEC"], band_weights(omega, seas)


@pytest.mark.slow
def test_damper_matrix_of_each_sea_absorbs_within_a_few_thousandths_of_the_optimum_there(folder, monkeypatch):
    """The interval of its gain contains what modes left out and coefficients may change."""
    monkeypatch.setattr("vsb.results.campaign.left_out_of_year", left_out_of_year)
    plan = planned(folder, name="optimal", pto={"ports": TWO["ports"]})
    found = computed(plan)
    power, flexible = found.annual_mean_power, found.sel(design="VSWEC")
    assert (flexible.gain_low < flexible.gain_percent).all()
    assert (flexible.gain_percent < flexible.gain_high).all()
    assert (power.sel(tuning="one") < power.sel(tuning="each")).all()
    seas, ports, weights = year_at_ports(plan)
    best = np.array([best_matrix(ports, sea @ weights).power for sea in seas.density])
    assert float(power.sel(design="VSWEC", tuning="each")) == pytest.approx(best @ seas.hours, rel=3e-3)


def test_year_of_a_damper_spread_over_the_shell(folder):
    """Its power at its damper follows from the ports of single waves."""
    pto = {"port": {"distributed": "membrane"}, "damping": 0.01}
    plan = planned(folder, name="spread", tuning=["fixed", "one"], pto=pto, designs={"VSWEC": {}})
    found = computed(plan)
    power = found.annual_mean_power
    seas, ports, weights = year_at_ports(plan)
    squares = seas.mean_density @ weights
    count = ports.velocity.shape[1]
    for tuning, beta in zip(found.tuning.values, found.damper_matrix.sel(design="VSWEC").values.ravel(), strict=True):
        direct = float(squares @ ports.power(beta * np.eye(count)))
        assert float(power.sel(design="VSWEC", tuning=tuning)) == pytest.approx(direct, rel=2e-3)
        for other in (0.97, 1.03):
            assert tuning == "fixed" or squares @ ports.power(other * beta * np.eye(count)) < direct
