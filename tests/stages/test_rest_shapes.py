"""Studies of a spheroid, through all stages."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from shell.test_device import raw

from vsb.engine.hydro import database
from vsb.engine.hydro.formats.common import floating
from vsb.pipeline.graph import StudyPlan
from vsb.stages.make import make
from vsb.study.study import parse

pytestmark = pytest.mark.slow

WAVES = [{"kind": "regular", "amplitude": 0.1, "period": 3.0}]
SHORT = {"duration": 18.0, "window": [12.0, 18.0], "initial_velocity": 0.0}
DESIGNS = {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC90": {"clamp": 90}}


def planned(root, shape, model="linear", amplitude=0.1, designs=DESIGNS, tolerance=1e-3):
    """The plan of a small study of a shape."""
    study = parse(
        raw(shape, study="shaped", waves=[{**WAVES[0], "amplitude": amplitude}], simulation=SHORT, designs=designs, device={"thickness": 0.02},
            hydro={"model": model, "tolerance": tolerance, "omega_max": 6.0, "witness": "none"},
            pto={"damping": 8000.0}, modes={"basis": "full", "degree": 2})
    )  # fmt: skip
    return StudyPlan(study, root=str(root))


@pytest.fixture(scope="module")
def oblate(tmp_path_factory):
    plan = planned(tmp_path_factory.mktemp("oblate"), {"spheroid": {"height": 3.0}})
    make(plan, plan.products)
    return plan


def test_spheroid_of_equal_radii_is_the_sphere(tmp_path):
    """Closed forms of the sphere against quadrature and natural modes of any meridian; under a clamp only the sphere
    knows what further degrees do.
    """
    designs = {name: DESIGNS[name] for name in ("FSB", "VSWEC")}
    shapes = {"sphere": None, "ball": {"spheroid": {"height": 4.0}}}
    plans = [planned(tmp_path / name, shape, designs=designs, tolerance=1e-5) for name, shape in shapes.items()]
    for plan in plans:
        make(plan, [plan.response.out])
    one, other = (xr.open_dataset(plan.response.out) for plan in plans)
    for quantity in ("absorbed_power", "best_power", "best_damping"):
        assert other[quantity].values == pytest.approx(one[quantity].values, rel=5e-4), quantity


def test_hydrostatics_and_added_mass_of_a_half_spheroid(oblate):
    ds = database.open_database(oblate.database.out)
    weight = 1025.0 * 9.81
    assert float(ds.hydrostatic_stiffness[0, 0]) == pytest.approx(weight * math.pi * 4.0, rel=1e-9)
    assert float(ds.inertia_matrix[0, 0]) == pytest.approx(1025.0 * 2 / 3 * math.pi * 4 * 1.5, rel=1e-9)
    volume, buoyancy, _ = floating(ds, "oblate")
    assert volume == pytest.approx(2 / 3 * math.pi * 4 * 1.5, rel=1e-9)
    assert buoyancy[2] == pytest.approx(-3 / 8 * 1.5, rel=1e-9)  # of half a spheroid
    e = math.sqrt(1 - 1.5**2 / 2**2)
    along = 2 / e**3 * (e - math.sqrt(1 - e**2) * math.asin(e))  # Lamb 1932, art. 114
    assert float(ds.added_mass_inf[0, 0]) == pytest.approx(volume * 1025.0 * along / (2 - along), rel=1e-3)


def test_time_and_frequency_domain_agree_and_energy_is_conserved(oblate):
    checks = json.loads(Path(f"{oblate.folder}/validity.json").read_text())
    checks = checks["checks"] if isinstance(checks, dict) else checks
    verdicts = {check["name"]: check["verdict"] for check in checks}
    failed = {name for name, verdict in verdicts.items() if verdict == "fail"}
    assert failed == {"computed_buckling", "modes_left_out"}  # it is thin and soft, and has few modes
    assert verdicts["time_and_frequency_domain"] == verdicts["energy_residual"] == verdicts["power_limit"] == "ok"


def test_body_exact_motion_in_small_waves_is_linear(oblate):
    """Of the rigid spheroid; the flexible one oscillates about a deformed shape."""
    plan = planned(oblate.root, {"spheroid": {"height": 3.0}}, "body_exact", 2e-3)
    names = {design: plan.simulation(design, plan.study.waves[0]).out for design in ("FSB", "VSWEC")}
    make(plan, names.values())
    runs = {design: xr.open_dataset(path).load() for design, path in names.items()}
    settled = runs["FSB"].position.sel(time=slice(12.0, 18.0))[:, 0]
    response = xr.open_dataset(oblate.response.out)
    omega = 2 * np.pi / 3.0
    rao = response.rao.sel(design="FSB", dof="Heave").sel(omega=omega, method="nearest")
    heave = float(np.hypot(*rao.values))  # of real and imaginary part
    assert float(settled.max() - settled.min()) / 2 == pytest.approx(2e-3 * heave, rel=5e-3)
    assert runs["VSWEC"].attrs["model"] == "body_exact"
    assert np.isfinite(runs["VSWEC"].position).all()
