"""Checks and summary of a campaign before anything is solved."""

from pathlib import Path

import pytest
import xarray as xr
from stages.test_members import planned, with_seas

from vsb.errors import ConfigError
from vsb.stages.campaign_preview import check, summary
from vsb.tools.packed import SUFFIX, Pack


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return with_seas(tmp_path_factory.mktemp("campaign"), (1.0, 6.0), (2.2, 9.0), (2.3, 9.5), (3.1, 12.0))


def test_clamps_that_leave_no_free_mode_are_refused(folder):
    """Two clamps hold both modes of degree 1; modes of higher degrees leave some free."""
    designs = {"FSB": {"flexible": False}, "HELD": {"clamp": [0, 90]}}
    modes = {"basis": "membrane", "degree": 1}
    message = r"few.yaml: vary: with modes.degree: 1.0: designs.HELD.clamp: received \[0.0, 90.0\], which leaves none"
    with pytest.raises(ConfigError, match=message):
        check(planned(folder, {"modes.degree": [4, 1]}, name="few", designs=designs, modes=modes))
    check(planned(folder, {"modes.degree": [4, 5]}, name="some", designs=designs, modes=modes))


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
def test_points_with_an_unsolvable_band_are_refused(folder, monkeypatch, varied, message):
    """The first point can be solved, the last cannot."""
    monkeypatch.chdir(folder)
    with pytest.raises(ConfigError, match=message):
        check(planned(folder, varied, name="band"))


def test_check_counts_points_batches_and_shapes(folder, monkeypatch):
    """Elastic moduli and densities share the hydrodynamics."""
    monkeypatch.chdir(folder)
    plan = planned(folder, {"device.young_modulus": [1e6, 1e7], "device.density": [2e3, 2.5e3]}, name="counted")
    assert summary(plan)[-1].startswith("fail         buckling = ")
    assert summary(plan)[:3] == [
        "campaign     counted: counted_study.yaml over 4 seas, tuning fixed, one, each",
        "points       4 of device.young_modulus x device.density, 0 done",
        "jobs         1 of 1 batches to do, 1 shapes of the water",
    ]
    Pack(Path(plan.folder, "members", f"other{SUFFIX}")).append(xr.Dataset(attrs={"spec_id": plan.members[2].id}))
    (batch,) = (Path(one.out) for one in plan.batches.values())
    batch.parent.mkdir(parents=True, exist_ok=True)
    batch.touch()
    assert summary(plan)[1:3] == [
        "points       4 of device.young_modulus x device.density, 1 done",
        "jobs         0 of 1 batches to do, 1 shapes of the water",
    ]
