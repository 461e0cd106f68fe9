"""Stage campaign: gathers the batches, every member at its point, and refuses those of another campaign."""

import csv
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from stages.test_members import gather, planned, with_seas

from vsb.pipeline.plans import members
from vsb.results.campaign import stacked
from vsb.tools.files import load, save
from vsb.tools.stamps import faults, read_manifest

VARIED = {"device.young_modulus": [3e6, 1e6], "device.thickness": [0.01, 0.02, 0.04]}
BY, BINS = ("design", "tuning"), ("hs", "te")


def made_up(one):
    """Results that identify their member: the power is the product of the varied values."""
    power = np.prod(list(one.point.values())) * np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    return xr.Dataset(
        {
            "annual_mean_power": (BY, power),
            "damping": ((*BY, *BINS), np.broadcast_to(power[..., None, None], (2, 3, 1, 2))),
            "margin": ((), 0.5),
            "viable": ("design", [True, True]),
            "reason": ("design", np.array(["", ""], dtype=object)),
            "count": (BINS, [[2, 0]]),
        },
        coords={"design": ["FSB", "VSWEC"], "tuning": ["fixed", "one", "each"], "hs": [1.25], "te": [4.5, 5.5]},
    )


@pytest.fixture
def plan(tmp_path):
    """A plan whose batches are there."""
    one = planned(with_seas(tmp_path, (1.0, 6.0)), VARIED)
    for batch, task in one.batches.items():
        spec = task.spec
        held = members(spec.base, spec.points, spec.climate, spec.tuning)
        whole = stacked([made_up(each) for each in held], [each.id for each in held])
        save(whole.assign_attrs(spec_id=batch), task.out)
    return one


def test_every_member_stands_at_its_point(plan):
    gather(plan)
    found = load(plan.data_path, expected=plan.identity)
    assert found.annual_mean_power.dims == ("young_modulus", "thickness", *BY)
    for modulus in VARIED["device.young_modulus"]:
        for thickness in VARIED["device.thickness"]:
            power = found.annual_mean_power.sel(young_modulus=modulus, thickness=thickness)
            np.testing.assert_allclose(power.sel(design="VSWEC", tuning="fixed"), 4 * modulus * thickness, rtol=1e-15)


def test_table_is_stamped_and_equals_the_data(plan):
    gather(plan)
    assert faults({plan.campaign.makes[1]: plan.identity}, read_manifest(plan.manifest)) == []
    rows = list(csv.DictReader(Path(plan.campaign.makes[1]).read_text().splitlines()))
    keys = ("device.young_modulus", "device.thickness", "design", "tuning")
    tunings = ["fixed", "one", "each"]
    points = [[f"{value:.12g}" for value in one.values()] for one in plan.campaign.spec.vary.points]
    expected = [[*one, design, tuning] for one in points for design in ("FSB", "VSWEC") for tuning in tunings]
    assert [[row[key] for key in keys] for row in rows] == expected
    for row in rows:
        factor = {"FSB": 0, "VSWEC": 3}[row["design"]] + 1 + tunings.index(row["tuning"])
        product = float(row["device.young_modulus"]) * float(row["device.thickness"])
        assert float(row["annual_mean_power"]) == pytest.approx(factor * product, rel=1e-11)
