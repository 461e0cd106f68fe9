"""Results of studies, bodies and years do not depend on units, nor on the order of designs, seas and motions."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from conftest import run_at
from invariance import (
    HEAVE,
    JONSWAP,
    LENGTH,
    MASS,
    REGULAR,
    SEED,
    UNITS,
    assert_close,
    assert_same_in_another_order,
    assert_same_in_other_units,
    factor,
    renamed,
    restated,
    usual,
)

from vsb.engine.hydro.database import save_database
from vsb.engine.hydro.formats.wamit import import_wamit
from vsb.engine.waves.kinds import jonswap_spectrum
from vsb.pipeline.graph import BodyPlan, StudyPlan
from vsb.pipeline.plans import plan_of
from vsb.stages.make import make
from vsb.study import study as config
from vsb.study.body import load_body
from vsb.tools.files import load

GAS = {"internal_pressure": 6e4, "gas": {"adiabatic_index": 1.4, "atmospheric_pressure": 101325.0}}
STUDIES = {
    "drag": HEAVE | {"drag": {"heave": {"coefficient": 1.0, "area": 6.0}}},
    "limits": HEAVE | {"pto": HEAVE["pto"] | {"force_limit": 900.0, "stroke_limit": 0.3},
                       "water": SEED["water"] | {"depth": 7.0}},
    "exact": HEAVE | {"hydro": {"model": "body_exact", "omega_max": 4.0, "tolerance": 1e-2, "witness": "none"}},
    "pressure": HEAVE | {"hydro": {"model": "assumed_pressure", "pressure": 900.0}, "waves": [REGULAR]},
    "gas": HEAVE | {"device": SEED["device"] | GAS, "reference_shape": "equilibrium",
                    "pto": HEAVE["pto"] | {"port": {"between": [0.0, 180.0]}}},
    "planar": HEAVE | {"motion": "planar", "mooring": [2e4, 0.0, 0.0, 0.0, 0.0, 0.0],
                       "device": SEED["device"] | {"centre_of_mass": -0.5, "ballast_inertia": 9e3},
                       "modes": {"basis": "membrane", "degree": 2, "order": 2},
                       "pto": HEAVE["pto"] | {"port": "surge"}, "waves": [REGULAR | {"direction": 180.0}, JONSWAP]},
}  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Function study, look -> plan of its results, with figures and page only where `look` is set."""

    @cache
    def run(text, look):
        plan = StudyPlan(config.parse(json.loads(text)), root=str(tmp_path_factory.mktemp("results")))
        people = () if look else (".html", ".svg", ".csv")
        make(
            plan,
            [path for path in plan.products if not path.endswith((".vtu", *people)) or path.endswith("ladder.csv")],
        )
        return plan

    return lambda raw, look=False: run(json.dumps(raw), look)


@pytest.mark.parametrize(
    "name", [name if name == "pressure" else pytest.param(name, marks=pytest.mark.slow) for name in STUDIES]
)
def test_results_do_not_depend_on_units(results, name):
    assert_same_in_other_units(results(STUDIES[name]), results(restated(STUDIES[name])))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["limits", "exact", "planar"])
def test_results_do_not_depend_on_the_order_of_designs_and_seas(results, name):
    raw = STUDIES[name]
    assert_same_in_another_order(results(raw), results(renamed(raw) | {"waves": raw["waves"][::-1]}))


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


def body_study(case, length=1.0, mass=1.0):
    """Flexible, rigid and with heave locked to pitch, at a port of several motions or of the rotation."""
    unit, turned = 4e6 * mass, 4e6 * mass * length**2
    moved = {"port": {"dofs": {"Heave": 1.0, "Pitch": -3.0 * length, "Mode9": 0.5}}, "damping": 0.2 * unit,
             "stiffness": 0.1 * unit, "efficiency": 0.9}  # fmt: skip
    pto = {"port": moved, "turn": {"port": {"dof": "Pitch"}, "damping": 90 * turned, "stiffness": 40 * turned}}[case]
    other = {"port": {"kind": "still"}, "turn": {"kind": "jonswap", "hs": 1.2 * length, "tp": 9.0, "seed": 2}}[case]
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
        "waves": [{"kind": "regular", "amplitude": 0.5 * length, "period": 8.0}, other],
        "simulation": {"duration": 20.0, "window": [10.0, 20.0], "tolerance": 1e-8,
                       "initial_position": 0.1 * length, "initial_velocity": -0.1 * length},
    }  # fmt: skip


@pytest.fixture(scope="module")
def body_results(tmp_path_factory):
    """Function case, variant -> plan of its results, without pages and figures."""

    @cache
    def run(case, changed):
        folder = tmp_path_factory.mktemp(case)
        units = (LENGTH, MASS) if changed == "units" else ()
        raw = body_study(case, *units)
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


BODIES = pytest.mark.parametrize("case", ["port", pytest.param("turn", marks=pytest.mark.slow)])


@BODIES
def test_results_of_a_body_do_not_depend_on_units(body_results, case):
    units = UNITS | TURNED if case == "turn" else UNITS
    assert_same_in_other_units(body_results(case, "own"), body_results(case, "units"), units, FREE)


@BODIES
def test_results_of_a_body_do_not_depend_on_order(body_results, case):
    assert_same_in_another_order(body_results(case, "own"), body_results(case, "order"), FREE)


HERTZ = np.linspace(0.04, 0.5, 24)
SEAS = [(1.0, 6.0), (2.2, 9.0), (2.3, 9.5), (3.1, 12.0)]
BASE = HEAVE | {"designs": {"FSB": {"flexible": False}, "VSWEC": {}}, "hydro": {"omega_max": 4.0}}
BASE |= {"pto": {"damping": {"FSB": 6e3, "VSWEC": 8e3}, "stiffness": 1e3}}
YEARS = {
    "spring": BASE,
    "between": BASE
    | {"pto": BASE["pto"] | {"port": {"between": [0.0, 180.0]}}, "water": BASE["water"] | {"depth": 9.0}},
}


def year(folder, raw, seas=SEAS, height=1.0):
    """Results of a year of these seas, heights in units of `height`."""
    folder.mkdir()
    lines = ["YY MM DD hh " + " ".join(f"{f:.4f}" for f in HERTZ)]
    for hour, (hs, tp) in enumerate(seas):
        density = height**2 * 2 * np.pi * jonswap_spectrum(2 * np.pi * HERTZ, hs, tp, 2.0)
        lines.append(f"1996 01 01 {hour:02d} " + " ".join(f"{s:.9e}" for s in density))
    (folder / "sea.txt").write_text("\n".join(lines) + "\n")
    (folder / "study.yaml").write_text(yaml.safe_dump(raw | {"study": "buoy"}))
    given = {"campaign": "year", "study": "study.yaml", "climate": {"spectra": "sea.txt"}}
    (folder / "year.yaml").write_text(yaml.safe_dump(given | {"tuning": ["fixed", "one", "each"]}))
    plan = plan_of(str(folder / "year.yaml"))
    ((batch, task),) = plan.batches.items()
    root = str(folder / "results")
    run_at(task, folder=f"{root}/members", root=root, out=f"{root}/{batch}.nc")
    return load(f"{root}/{batch}.nc")


def of_the_year(ds):
    """Numbers of the whole year that do not depend on its bins, which are in metres."""
    return {
        name: values
        for name, values in ds.data_vars.items()
        if np.issubdtype(values.dtype, np.number) and name != "practice_power" and not {"hs", "te"} & set(values.dims)
    }


@pytest.mark.slow
@pytest.mark.parametrize("name", YEARS)
def test_year_does_not_depend_on_units(tmp_path, name):
    own, other = year(tmp_path / "own", YEARS[name]), year(tmp_path / "other", restated(YEARS[name]), height=LENGTH)
    found = of_the_year(other)
    assert {"annual_mean_power", "force_rms", "gain_percent"} <= set(found)
    for what, values in of_the_year(own).items():
        units = values.attrs["units"].replace("MWh", "J")
        assert_close(found[what].values, factor(units) * values.values, what, 1e-6)


@pytest.mark.slow
def test_year_does_not_depend_on_order(tmp_path):
    own, other = year(tmp_path / "own", BASE), year(tmp_path / "other", renamed(BASE), SEAS[::-1])
    other = other.assign_coords(design=[usual(str(design)) for design in other.design.values]).sel(design=own.design)
    for what, values in own.data_vars.items():
        if np.issubdtype(values.dtype, np.number):
            assert_close(other[what].values, values.values, what, 1e-6)
