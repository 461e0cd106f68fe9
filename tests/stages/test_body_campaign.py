"""A site's year of a body: RM3, float and spar with a take-off between them, from the coefficients WAMIT published."""

from contextlib import chdir
from pathlib import Path

import numpy as np
import pytest
import yaml
from stages.test_members import with_seas
from stages.test_published_bodies import BOTH, DAMPER, HEAVES, MASSES, RM3, wamit

from vsb.engine.hydro.formats.wamit import import_wamit
from vsb.errors import ConfigError
from vsb.pipeline.plans import plan_of
from vsb.stages.campaign_preview import summary
from vsb.stages.check import check_plan
from vsb.stages.stage import run_task
from vsb.tools.files import load

SEAS = (1.5, 8.0), (2.5, 9.0), (2.0, 11.0), (3.0, 7.0)
HEAVIER = 1.2
TUNINGS = ["one", "fixed", "each", "constrained"]


def year_of_rm3(place, **changes):
    """The plan of a year of RM3 whose float's mass is varied, beside one whose spar is held."""
    apart = {HEAVES[0]: 1.0, HEAVES[1]: -1.0}
    study = {
        "study": "rm3",
        "body": wamit(),
        "designs": {"float": {"dofs": HEAVES[:1]}, "rm3": {"dofs": HEAVES}},
        "hydro": {"repair": BOTH},
        "water": {"density": 1000.0, "gravity": 9.81},
        "pto": {"damping": DAMPER, "port": {"dofs": apart}},
        "waves": [{"kind": "regular", "amplitude": 1.0, "period": 8.0}],
    }
    campaign = {
        "campaign": "rm3_year",
        "study": "rm3.yaml",
        "vary": {f"body.mass.{HEAVES[0]}": [MASSES[0], HEAVIER * MASSES[0]]},
        "climate": {"spectra": "sea.txt"},
        "tuning": TUNINGS,
        "constrained": {"seconds": 0.05},
        "verify": {"seas": 4},
        **changes,
    }
    with_seas(place, *SEAS)
    (place / "rm3.yaml").write_text(yaml.safe_dump(study))
    (place / "year.yaml").write_text(yaml.safe_dump(campaign, sort_keys=False))
    with chdir(place):
        return plan_of("year.yaml")


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """The plan and the results of the whole campaign."""
    place = tmp_path_factory.mktemp("rm3_year")
    plan = year_of_rm3(place)
    with chdir(place):
        check_plan(plan)
        for task in plan.tasks:
            run_task(task)
        return plan, load(plan.data_path, expected=plan.identity), Path(plan.folder, "report.html").read_text()


def powers(mass, damping, design):
    """Mean power in each sea by the equation of motion and a plain sum over fine frequencies [W]."""
    theirs = import_wamit(RM3, "rm3", density=1000.0, gravity=9.81)
    edges = 2 * np.pi * (np.linspace(0.04, 0.5, 24)[:, None] + [-0.01, 0.01])  # of bands of 0.02 Hz
    step = np.diff(edges[0])[0] / 40
    omega = np.arange(edges[0, 0] + step / 2, edges[-1, 1], step)
    omega = omega[(omega > float(theirs.omega[0])) & (omega < float(theirs.omega[-1]))]
    here = theirs.interp(omega=omega, method="cubic")
    free = np.eye(2)[:, :1] if design == "float" else np.eye(2)
    lossy = here.radiation_damping.values + damping * np.outer([1, -1], [1, -1])
    inertia = np.diag([mass, MASSES[1]]) + here.added_mass.values
    w = omega[:, None, None]
    impedance = free.T @ (-(w**2) * inertia - 1j * w * lossy + theirs.hydrostatic_stiffness.values) @ free
    moved = np.linalg.solve(impedance, (here.excitation_force.values[:, 0] @ free)[..., None])[..., 0] @ free.T
    absorbed = 0.5 * damping * omega**2 * np.abs(moved[:, 0] - moved[:, 1]) ** 2
    lines = Path("sea.txt").read_text().splitlines()[1:]
    density = np.array([line.split()[4:] for line in lines], dtype=float) / (2 * np.pi)
    band = np.clip(((omega - edges[0, 0]) / (edges[0, 1] - edges[0, 0])).astype(int), 0, 23)
    return 2 * step * density[:, band] @ absorbed


def test_year_is_the_sum_over_its_seas(found, tmp_path, monkeypatch):
    """The damper as given and the one found, for both masses and designs."""
    _, ds, _ = found
    with_seas(tmp_path, *SEAS)
    monkeypatch.chdir(tmp_path)
    for i, mass in enumerate((MASSES[0], HEAVIER * MASSES[0])):
        for design in ("float", "rm3"):
            one = ds.isel({str(ds.margin.dims[0]): i}).sel(design=design)
            for tuning in ("fixed", "one"):
                damping = float(one.damping.sel(tuning=tuning).max())
                expected = powers(mass, damping, design).mean()
                assert float(one.annual_mean_power.sel(tuning=tuning)) == pytest.approx(expected, rel=2e-3), (
                    mass,
                    design,
                )
            powers_near = [powers(mass, factor * damping, design).mean() for factor in (0.8, 1.0, 1.25)]
            assert max(powers_near) == powers_near[1]


def test_tunings_of_a_year_of_a_body_are_in_order(found):
    """Without limits the best force absorbs no less than dampers; each sea's own damper no less than one for all."""
    _, ds, _ = found
    power = ds.annual_mean_power
    assert bool((power.sel(tuning="each") >= power.sel(tuning="one") * (1 - 1e-9)).all())
    assert bool((power.sel(tuning="one") >= power.sel(tuning="fixed") * (1 - 1e-9)).all())
    assert bool((ds.power_bound > power.sel(tuning="each")).all())


def test_linear_runs_in_time_give_the_year_of_linear_theory(found):
    """The same damper in the same waves: what is left is the error of the radiation memory."""
    _, ds, _ = found
    assert ds.attrs["verified_model"] == "linear"
    linear = ds.annual_mean_power.sel(tuning=ds.attrs["verified_tuning"])
    np.testing.assert_allclose(ds.in_time_mean_power, linear, rtol=0.03)


def test_gain_over_the_first_rigid_design_has_an_interval(found):
    """Coefficients of files that state no error are taken as 1 % uncertain."""
    _, ds, _ = found
    assert ds.attrs["reference"] == "float"
    one = ds.sel(design="rm3", tuning="one")
    assert bool((one.gain_low < one.gain_percent).all())
    assert bool((one.gain_high - one.gain_percent > 0.1).all())
    assert ds.limit.values.tolist() == ["steepness", "breaking"]


def test_page_of_a_body_has_no_word_of_shells(found):
    _, _, page = found
    assert "of the energy comes from seas that are too steep or break." in page
    assert "shells deformed" not in page
    assert "buckl" not in page
    assert "flexib" not in page


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"verify": {"seas": 4, "model": "body_exact"}}, "verify.model: received body_exact; a body needs linear"),
        (
            {"vary": {"scale": [1, 2]}},
            r"vary\.scale: received a body, whose files have one size; needs keys of its study",
        ),
        (
            {"climate": {"spectra": "sea.txt", "direction": 30.0}},
            r"climate\.direction: received 30 degrees, needs one of 0",
        ),
    ],
)
def test_what_a_year_of_a_body_cannot_have(tmp_path, changes, message):
    with chdir(tmp_path), pytest.raises(ConfigError, match=message):
        check_plan(year_of_rm3(tmp_path, **changes))


def test_check_counts_the_databases_of_a_body(tmp_path):
    plan = year_of_rm3(tmp_path)
    with chdir(tmp_path):
        assert any(line.endswith("2 databases") for line in summary(plan))
