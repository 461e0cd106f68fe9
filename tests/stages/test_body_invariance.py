"""Results of a body do not depend on units, nor on the order of designs, seas and degrees of freedom."""

from functools import cache
from pathlib import Path

import pytest
import xarray as xr
import yaml
from invariance import (
    LENGTH,
    MASS,
    UNITS,
    assert_same_in_another_order,
    assert_same_in_other_units,
    renamed,
)

from vsb.engine.hydro.database import save_database
from vsb.engine.hydro.formats.wamit import import_wamit
from vsb.pipeline.graph import BodyPlan
from vsb.stages.make import make
from vsb.study.body import load_body

BARGE = Path(__file__).parents[1] / "data" / "barge"
FREE = ("state_matrix", "input_matrix", "output_matrix", "channel")
"""Radiation states may be any that give the same memory."""
TURNED = {"displacement_pp": "-", "velocity_pp": "-", "pto_force_pp": "N m", "damping": "N m s", "stiffness": "N m",
          "force_rms": "N m", "own_force_rms": "N m", "force_peak": "N m", "stroke_peak": "-", "best_damping": "N m s"}  # fmt: skip
"""Units of columns whose take-off acts on a rotation."""
NAMES = ["Mode9", "Heave", "Surge", "Pitch", "Mode7"]
"""Another order of what moves."""


def barge(length=1.0, mass=1.0, order=()):
    """WEC-Sim's barge as published, in given units of length and mass and order of degrees of freedom."""
    ds = import_wamit(BARGE, "barge", density=1000.0, gravity=9.81)
    kept = list(order) or [str(name) for name in ds.influenced_dof.values if name in NAMES]
    ds = ds.sel(influenced_dof=kept, radiating_dof=kept)
    for name, values in ds.data_vars.items():
        for dim in ("influenced_dof", "radiating_dof"):
            if dim in values.dims:
                values = values * xr.where(ds[dim] == "Pitch", length, 1.0)
        ds[name] = (mass * values).transpose(*ds[name].dims)
    lengths = {name: ds.attrs[name] * length for name in ("centre_of_mass", "centre_of_buoyancy", "gravity")}
    ds.attrs |= lengths | {"water_density": 1000.0 * mass / length**3, "displaced_volume": 4000.0 * length**3}
    return ds


def study(case, length=1.0, mass=1.0):
    """Flexible, rigid and with heave locked to pitch, at a port of several motions or of the rotation."""
    unit, turned = 4e6 * mass, 4e6 * mass * length**2
    moved = {"port": {"dofs": {"Heave": 1.0, "Pitch": -3.0 * length, "Mode9": 0.5}}, "damping": 0.2 * unit,
             "stiffness": 0.1 * unit, "efficiency": 0.9}  # fmt: skip
    pto = {
        "port": moved,
        "turn": {"port": {"dof": "Pitch"}, "damping": 90 * turned, "stiffness": 40 * turned},
    }[case]
    waves = [
        {"kind": "regular", "amplitude": 0.5 * length, "period": 8.0},
        {"kind": "jonswap", "hs": 1.2 * length, "tp": 9.0, "seed": 2},
        {"kind": "still"},
    ]
    return {
        "study": "wec_sim",
        "body": {
            "database": "barge.nc",
            "stiffness": {"Surge": 0.2 * unit, "Pitch": 2 * turned, "Surge Heave": 0.01 * unit},
            "damping": {"Heave": 0.1 * unit, "Pitch": 0.3 * turned},
        },
        "water": {"density": 1000.0 * mass / length**3, "gravity": 9.81 * length},
        "designs": {"FSB": {"dofs": ["Heave", "Pitch", "Surge"]}, "VSWEC": {}, "VSWEC90": {"held": [{"Heave": 1.0, "Pitch": -15.0 * length}]}},
        "pto": pto,
        "waves": waves if case == "port" else waves[:2],
        "simulation": {"duration": 40.0, "window": [20.0, 40.0], "tolerance": 1e-8,
                       "initial_position": 0.1 * length, "initial_velocity": -0.1 * length},
    }  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Function case, variant -> plan of its results, without pages and figures."""

    @cache
    def run(case, changed):
        folder = tmp_path_factory.mktemp(case)
        units = (LENGTH, MASS) if changed == "units" else ()
        raw = study(case, *units)
        if changed == "order":
            raw = renamed(raw) | {"waves": raw["waves"][::-1]}
        save_database(barge(*units, order=NAMES if changed == "order" else ()), None, folder / "barge.nc")
        (folder / "barge.yaml").write_text(yaml.safe_dump(raw))
        found = load_body(folder / "barge.yaml")
        plan = BodyPlan(found.study, root=str(folder / "results"), files=found.files)
        people = (".html", ".svg", ".csv")
        make(plan, [path for path in plan.products if not path.endswith(people) or path.endswith("ladder.csv")])
        return plan

    return run


@pytest.mark.parametrize("case", ["port", pytest.param("turn", marks=pytest.mark.slow)])
def test_results_of_a_body_do_not_depend_on_units(results, case):
    units = UNITS | TURNED if case == "turn" else UNITS
    assert_same_in_other_units(results(case, "own"), results(case, "units"), units, FREE)


def test_results_of_a_body_do_not_depend_on_order(results):
    assert_same_in_another_order(results("port", "own"), results("port", "order"), FREE)
