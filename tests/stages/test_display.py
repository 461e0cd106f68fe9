"""Rule display: shapes to look at, of the mean shell and of every mode to either side."""

import json

import meshio
import numpy as np
import pytest
from conftest import varied

from vsb.stages import display
from vsb.study.plan import StudyPlan
from vsb.study.study import content_id


def test_every_shape_is_written_and_stands_in_the_manifest(seed, tmp_path):
    plan = StudyPlan(varied(seed, modes={"degree": 1}))
    display.run(plan.display, str(tmp_path / "shapes"), str(tmp_path / "manifest.json"))
    names = {path.rsplit("/")[-1] for path in plan.display_paths}
    assert {path.name for path in (tmp_path / "shapes").iterdir()} == names
    stamps = json.loads((tmp_path / "manifest.json").read_text())
    assert {entry["spec_id"] for entry in stamps.values()} == {content_id(plan.display)}
    assert sorted(path.rpartition("/")[2] for path in stamps) == sorted(names)
    mean = meshio.read(tmp_path / "shapes" / "mean.vtu").points - [0.0, 0.0, seed.centre_height]
    assert np.linalg.norm(mean, axis=1) == pytest.approx(seed.device.radius, rel=1e-6)
    for side, sign in (("plus", 1), ("minus", -1)):  # breathing: a sphere of another radius
        swollen = meshio.read(tmp_path / "shapes" / f"Membrane0_{side}.vtu").points - [0.0, 0.0, seed.centre_height]
        radii = np.linalg.norm(swollen, axis=1)
        assert np.ptp(radii) < 1e-6
        assert sign * (radii[0] - seed.device.radius) > 0.05
