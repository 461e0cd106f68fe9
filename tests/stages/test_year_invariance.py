"""Results of a year do not depend on units, nor on the order of designs and hours."""

import json

import numpy as np
import pytest
import yaml
from invariance import HEAVE, LENGTH, assert_close, factor, renamed, restated, usual

from vsb.engine.waves.kinds import jonswap_spectrum
from vsb.keys.quantities import canonical
from vsb.pipeline.plans import plan_of
from vsb.stages import campaign
from vsb.stages.stage import function_of, specification
from vsb.tools.files import load

pytestmark = pytest.mark.slow

HERTZ = np.linspace(0.04, 0.5, 24)
SEAS = [(1.0, 6.0), (2.2, 9.0), (2.3, 9.5), (3.1, 12.0)]
BASE = HEAVE | {"designs": {"FSB": {"flexible": False}, "VSWEC": {}}, "hydro": {"omega_max": 4.0}}
BASE |= {"pto": {"damping": {"FSB": 6e3, "VSWEC": 8e3}, "stiffness": 1e3}}
STUDIES = {
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
    campaign.run_members(
        specification(function_of("members"), json.loads(canonical(task.spec))),
        plan.loaded.climate_path,
        f"{root}/members",
        root,
        f"{root}/{batch}.nc",
    )
    return load(f"{root}/{batch}.nc")


def of_the_year(ds):
    """Numbers of the whole year that do not depend on its bins, which are in metres."""
    return {
        name: values
        for name, values in ds.data_vars.items()
        if np.issubdtype(values.dtype, np.number) and name != "practice_power" and not {"hs", "te"} & set(values.dims)
    }


@pytest.mark.parametrize("name", STUDIES)
def test_year_does_not_depend_on_units(tmp_path, name):
    own, other = year(tmp_path / "own", STUDIES[name]), year(tmp_path / "other", restated(STUDIES[name]), height=LENGTH)
    found = of_the_year(other)
    assert {"annual_mean_power", "force_rms", "gain_percent"} <= set(found)
    for what, values in of_the_year(own).items():
        units = values.attrs["units"].replace("MWh", "J")
        assert_close(found[what].values, factor(units) * values.values, what, 1e-6)


def test_year_does_not_depend_on_order(tmp_path):
    own, other = year(tmp_path / "own", BASE), year(tmp_path / "other", renamed(BASE), SEAS[::-1])
    other = other.assign_coords(design=[usual(str(design)) for design in other.design.values]).sel(design=own.design)
    for what, values in own.data_vars.items():
        if np.issubdtype(values.dtype, np.number):
            assert_close(other[what].values, values.values, what, 1e-6)
