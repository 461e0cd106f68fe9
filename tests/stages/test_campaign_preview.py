"""What is told of a campaign before anything is solved."""

import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from stages.test_members import MODULI, planned, with_seas

from vsb.errors import ConfigError
from vsb.stages import campaign_preview
from vsb.stages.campaign_preview import campaign_summary, check_campaign
from vsb.tools.packed import SUFFIX
from vsb.waves.climate import OUTSIDE, Climate


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return with_seas(tmp_path_factory.mktemp("campaign"), (1.0, 6.0), (2.2, 9.0), (2.3, 9.5), (3.1, 12.0))


def test_a_campaign_is_checked_before_anything_that_solves_or_draws_is_read(folder):
    """A run waits for its check, and for the answer it closes with."""
    planned(folder, MODULI, name="light")
    heavy = {"numba", "scipy", "xarray", "netCDF4", "matplotlib", "capytaine"}
    check = "from vsb.stages.campaign_preview import check_campaign; check_campaign(plan_of('light.yaml'))"
    script = f"import sys; from vsb.cli import plan_of; import vsb.stages.run, vsb.stages.verify; {check}; print({heavy} & {{*sys.modules}})"
    done = subprocess.run([sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
    script = (
        "import sys, vsb.report.campaign_answer; print({'matplotlib', 'numba', 'scipy', 'vsb.scenes'} & {*sys.modules})"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


def test_what_is_left_to_do_is_told(folder, monkeypatch):
    monkeypatch.chdir(folder)
    lines = campaign_summary(planned(folder, MODULI, name="told"))
    assert lines[0] == "campaign     told: told_study.yaml over 4 seas, tuning fixed, one, each"
    assert lines[1] == "points       2 of device.young_modulus, 0 done"
    assert lines[2] == "jobs         1 of 1 batches to do, 1 shapes of the water"


def test_clamps_that_leave_no_mode_free_are_refused_at_the_point_that_has_so_few(folder):
    """Two of the shell, clamped at a pole and at the equator; of more modes, or at one colatitude, some stay free."""
    designs = {"FSB": {"flexible": False}, "HELD": {"clamp": [0, 90]}}
    modes = {"basis": "membrane", "degree": 1}
    message = r"few.yaml: vary: with modes.degree: 1.0: designs.HELD.clamp: received \[0.0, 90.0\], which leaves none"
    with pytest.raises(ConfigError, match=message):
        check_campaign(planned(folder, {"modes.degree": [4, 1]}, name="few", designs=designs, modes=modes))
    check_campaign(planned(folder, {"modes.degree": [4, 5]}, name="some", designs=designs, modes=modes))


def test_waves_beyond_what_is_solved_are_refused(tmp_path, monkeypatch):
    """A tank's waves of a second are above 5 rad/s; those of before are not."""
    monkeypatch.setattr("stages.test_members.HERTZ", np.linspace(0.1, 3.0, 40))
    with_seas(tmp_path, (0.02, 1.0), (0.03, 1.1))
    monkeypatch.chdir(tmp_path)
    with pytest.raises(
        ConfigError, match=r"climate: \d+\.\d% of its variance lies outside .* to 5 rad/s, .* a larger hydro"
    ):
        check_campaign(planned(tmp_path, MODULI, name="tank"))


@pytest.mark.parametrize(
    ("varied", "message"),
    [
        (
            {"hydro.omega_max": [5.0, 2.5]},
            r"hydro\.omega_max: received 2.5 rad/s, needs at least .* rad/s, because the radiation memory",
        ),
        (
            {"hydro.omega_max": [5.0, 50.0]},
            r"hydro\.omega_max: received 50 rad/s, needs at most 14\.\d+ rad/s with the spec",
        ),
    ],
)
def test_a_point_whose_band_no_solver_takes_is_refused_before_any_is_solved(folder, monkeypatch, varied, message):
    """The first point can be solved, the last cannot."""
    monkeypatch.chdir(folder)
    with pytest.raises(ConfigError, match=message):
        check_campaign(planned(folder, varied, name="band"))


def test_what_is_told_of_a_campaign_is_told_after_it_was_checked(folder, monkeypatch):
    monkeypatch.chdir(folder)
    with pytest.raises(ConfigError, match=r"hydro\.omega_max: received 2.5 rad/s, needs at least"):
        campaign_summary(planned(folder, {"hydro.omega_max": [5.0, 2.5]}, name="narrow"))


@pytest.mark.parametrize(("part", "refused"), [(0.9, False), (1.1, True)])
def test_a_share_of_the_climate_may_lie_outside_what_is_solved(folder, monkeypatch, part, refused):
    monkeypatch.chdir(folder)
    plan = planned(folder, MODULI, name="outside")
    monkeypatch.setattr(Climate, "variance_outside", lambda self, low, high: part * OUTSIDE)
    with pytest.raises(ConfigError, match=OUTSIDE_TOLD) if refused else nullcontext():
        check_campaign(plan)


OUTSIDE_TOLD = (
    rf"outside.yaml: climate: {1.1 * OUTSIDE:.1%} of its variance lies outside [\d.]+ to 5 rad/s, which a point"
)


def test_points_done_jobs_and_shapes_are_counted(folder, monkeypatch):
    """Two moduli share what water does; two radii do not. A result of a point or of a batch is one less to do."""
    monkeypatch.chdir(folder)
    plan = planned(folder, {"device.young_modulus": [1e6, 1e7], "device.density": [2e3, 2.5e3]}, name="counted")
    assert campaign_summary(plan)[1:3] == [
        "points       4 of device.young_modulus x device.density, 0 done",
        "jobs         1 of 1 batches to do, 1 shapes of the water",
    ]
    done = Path(plan.folder, "members", f"{plan.members[2].id}{SUFFIX}")
    done.parent.mkdir(parents=True)
    done.touch()
    (batch,) = map(Path, plan.batch_paths)
    batch.parent.mkdir(parents=True, exist_ok=True)
    batch.touch()
    assert campaign_summary(plan)[1:3] == [
        "points       4 of device.young_modulus x device.density, 1 done",
        "jobs         0 of 1 batches to do, 1 shapes of the water",
    ]
    assert campaign_summary(planned(folder, name="alone"))[1].startswith("points       1 of nothing varied, 0 done")


def test_every_shape_of_the_water_is_checked_once_and_every_run_in_time(monkeypatch):
    """The climate against the band of each; of members of one shape, that of the last decides."""
    asked = []

    def member(shape, degree, designs, omega_max=5.0):
        study = SimpleNamespace(
            modes=SimpleNamespace(max_degree=degree), designs=designs, hydro=SimpleNamespace(omega_max=omega_max)
        )
        return SimpleNamespace(spec=SimpleNamespace(sweep=shape), study=study)

    rigid, free, held = (
        SimpleNamespace(flexible=flexible, clamp=clamp)
        for flexible, clamp in ((False, (0.0, 90.0)), (True, ()), (True, (0.0, 90.0)))
    )
    members = [
        member("a", 2, {"A": rigid, "B": free}),
        member("b", 4, {"A": free, "B": held}, 6.0),
        member("c", 5, {"A": held, "B": rigid}, 7.0),
        member("b", 0, {"A": free}, 6.0),
    ]
    hydro = lambda study, root: SimpleNamespace(  # noqa: E731
        check_waves=lambda: asked.append((study, root)), first_omega=0.1 * study.hydro.omega_max
    )
    seas = SimpleNamespace(variance_outside=lambda low, high: asked.append((low, high)) or 0.0)
    monkeypatch.setattr(campaign_preview, "read_climate", lambda *given: asked.append(given) or seas)
    monkeypatch.setattr(campaign_preview, "StudyPlan", hydro)
    monkeypatch.setattr(campaign_preview, "_check_clamps", lambda *given: asked.append(given))
    monkeypatch.setattr(campaign_preview, "_check_runs", lambda *given: asked.append(given))
    plan = SimpleNamespace(
        members=members, climate="seas", root="root", loaded=SimpleNamespace(climate_path="sea.txt", source="c.yaml"),
        verifications={name: SimpleNamespace(simulated=name) for name in "xy"},
    )  # fmt: skip
    check_campaign(plan)
    assert asked.pop(0) == ("seas", "sea.txt")
    banded = [members[0], members[3], members[2]]
    ends = [(0.1 * one.study.hydro.omega_max, one.study.hydro.omega_max) for one in banded]
    assert asked[:6] == [each for one, band in zip(banded, ends, strict=True) for each in ((one.study, "root"), band)]
    few = [(members[1], "c.yaml"), (members[3], "c.yaml")]
    assert asked[6:] == [*few, ("x", "c.yaml"), ("y", "c.yaml")]


def test_runs_in_time_are_told_by_the_verification(tmp_path):
    """As many points as are run, which may be fewer than there are; those done are there."""
    paths = [str(tmp_path / name) for name in "abc"]
    verify = SimpleNamespace(seas=6, model="linear", seed=3)
    plan = SimpleNamespace(
        loaded=SimpleNamespace(campaign=SimpleNamespace(verify=verify)),
        verifications=dict.fromkeys("abc"), verification_paths=paths, members=list("abcde"),
    )  # fmt: skip
    Path(paths[1]).touch()
    words = "verify       6 seas, linear, of each of 3 points, 1 done"
    assert campaign_preview._runs_lines(plan) == [words]
    plan.loaded.campaign.verify = None
    assert campaign_preview._runs_lines(plan) == []


def test_what_a_climate_lacks_is_told_last_and_members_and_batches_are_counted(tmp_path, monkeypatch):
    """Two shapes of three points in two batches, one of which is there."""
    asked = []
    plan = SimpleNamespace(
        name="wide", climate="seas", folder=str(tmp_path), batches=dict.fromkeys("ab"), verifications={},
        members=[SimpleNamespace(id=name, spec=SimpleNamespace(sweep=shape)) for name, shape in zip("xyz", "aba", strict=True)],
        batch_paths=[str(tmp_path / "a.nc"), str(tmp_path / "b.nc")],
        loaded=SimpleNamespace(
            climate_path="sea.txt", tuning=("one", "each"),
            campaign=SimpleNamespace(study="study.yaml", vary=SimpleNamespace(values={"k": 1, "l": 2}), verify=None),
        ),
    )  # fmt: skip
    seas = SimpleNamespace(hours=[0.2, 0.3, 0.5], notes=("a gap", "another"))
    monkeypatch.setattr(campaign_preview, "check_campaign", asked.append)
    monkeypatch.setattr(campaign_preview, "read_climate", lambda *given: seas if given == ("seas", "sea.txt") else None)
    (tmp_path / "members").mkdir()
    (tmp_path / "members" / f"y{SUFFIX}").touch()
    (tmp_path / "a.nc").touch()
    assert campaign_summary(plan) == [
        "campaign     wide: study.yaml over 3 seas, tuning one, each",
        "points       3 of k x l, 1 done",
        "jobs         1 of 2 batches to do, 2 shapes of the water",
        "climate      a gap",
        "climate      another",
    ]
    assert asked == [plan]


def test_designs_that_are_not_viable_are_not_looked_at_and_others_must_rest(monkeypatch):
    asked = []
    monkeypatch.setattr("vsb.scenes.viability.viability", lambda study: SimpleNamespace(viable=study))

    def rests(*given):
        asked.append(given)
        if given[0] == "soft":
            raise ConfigError("no rest")

    monkeypatch.setattr("vsb.scenes.rest.check_rests", rests)
    campaign_preview._check_runs(None, "c.yaml")
    campaign_preview._check_runs(("stiff", "at rest"), "c.yaml")
    with pytest.raises(ConfigError, match=r"^c\.yaml: verify: no rest$"):
        campaign_preview._check_runs(("soft", "at rest"), "c.yaml")
    assert asked == [("stiff", "at rest"), ("soft", "at rest")]
