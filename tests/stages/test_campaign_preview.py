"""What is told of a campaign before anything is solved."""

import subprocess
import sys

import numpy as np
import pytest
from stages.test_members import MODULI, planned, with_seas

from vsb.errors import ConfigError
from vsb.stages.campaign_preview import campaign_summary, check_campaign


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
