"""Comparison of results in two systems of units, and with designs and seas in another order."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from vsb.study import study as config

SEED = config.load(Path(__file__).parent / "data" / "seed.yaml").model_dump(exclude_none=True)
REGULAR = {"kind": "regular", "amplitude": 0.179, "period": 2.5}
JONSWAP = {"kind": "jonswap", "hs": 0.3, "tp": 3.0, "seed": 3, "realisations": 2}
HEAVE = SEED | {
    "modes": {"basis": "membrane", "degree": 2},
    "hydro": {"omega_max": 4.0, "witness": "none"},
    "designs": {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC90": {"clamp": 90}},
    "pto": {"damping": {"FSB": 6e3, "VSWEC": 8e3, "VSWEC90": 9e3}, "stiffness": 1e3, "efficiency": 0.9},
    "waves": [REGULAR, JONSWAP],
    "simulation": SEED["simulation"] | {"duration": 12.0, "window": [6.0, 12.0]},
}
LENGTH, MASS = 2.0, 4.0
"""Of another system of units, its second the same: twice the gravity, half the density."""
POWERS = {
    "radius": (1, 0), "thickness": (1, 0), "young_modulus": (-1, 1), "density": (-3, 1), "mass": (0, 1),
    "internal_pressure": (-1, 1), "atmospheric_pressure": (-1, 1), "pressure": (-1, 1), "gravity": (1, 0), "depth": (1, 0),
    "damping": (0, 1), "stiffness": (0, 1), "force_limit": (1, 1), "stroke_limit": (1, 0), "amplitude": (1, 0),
    "hs": (1, 0), "initial_velocity": (1, 0), "initial_position": (1, 0), "area": (2, 0), "centre_of_mass": (1, 0),
    "ballast_inertia": (2, 1), "mooring": (0, 1), "alpha": (0, 0), "beta": (0, 0),
}  # fmt: skip
"""Of length and mass in each quantity of a study."""
NAMES = {"FSB": "Zeta", "VSWEC": "Mid", "VSWEC90": "Alpha"}
"""Of designs, which are lines in the order of their names."""


def assert_close(found, expected, what, rtol=1e-7):
    """Compare to a fraction of the largest magnitude."""
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape, what
    np.testing.assert_allclose(
        found, expected, rtol=0, atol=rtol * np.nanmax(np.abs(expected), initial=0.0), err_msg=str(what)
    )


def restated(raw, power=(0, 0)):
    """Convert a study to the other units."""
    if isinstance(raw, dict):
        return {key: restated(part, POWERS.get(key, power)) for key, part in raw.items()}
    if isinstance(raw, list | tuple):
        return [restated(part, power) for part in raw]
    return raw if isinstance(raw, bool | str) or not any(power) else raw * LENGTH ** power[0] * MASS ** power[1]


def factor(units):
    """Factor between the systems of units for a unit such as "kg/(m^2 s)"."""
    known = {
        "m": LENGTH,
        "kg": MASS,
        "N": LENGTH * MASS,
        "J": LENGTH**2 * MASS,
        "W": LENGTH**2 * MASS,
        "Pa": MASS / LENGTH,
    }
    known |= dict.fromkeys(("1", "-", "", "rad", "s", "%"), 1.0)
    over, _, under = units.partition("/")
    parts = [
        (part.partition("^"), sign) for text, sign in ((over, 1), (under, -1)) for part in text.strip("()").split()
    ]
    return np.prod([known[name] ** (sign * float(power or 1)) for (name, _, power), sign in parts])


def renamed(raw):
    """The study with other names of designs, in another order."""
    return {NAMES.get(key, key): renamed(raw[key]) for key in reversed(raw)} if isinstance(raw, dict) else raw


def usual(text):
    """The text with the original names of designs."""
    names = {other: name for name, other in NAMES.items()}
    return re.sub("|".join(names), lambda found: names[found[0]], text)


UNITS = {
    "displacement_pp": "m", "velocity_pp": "m/s", "pto_force_pp": "N", "power_peak": "W", "power_mean": "W", "energy": "J",
    "capture_width": "m", "damping": "N s/m", "stiffness": "N/m", "power_low": "W", "power_high": "W",
    "power_linear": "W", "power_linear_record": "W", "force_rms": "N", "force_peak": "N", "stroke_peak": "m", "best_damping": "N s/m",
    "best_power": "W", "power": "W", "power_error": "W", "best_power_low": "W", "best_power_high": "W",
    "damper_power": "W", "record_power_mean": "W", "record_power_low": "W", "record_power_high": "W", "record_start": "s", "record_end": "s",
    "own_power": "W", "own_force_rms": "N", "period": "s",
}  # fmt: skip
"""Of the columns of tables that have some."""
MACHINE = ("seconds", "energy_residual", "constraint_drift")
"""What is of the machine or of its round-off."""


def datasets(plan):
    """Datasets of a plan by content; runs by design and number of the sea."""
    runs = {
        f"{design} {i}": plan.simulation(design, wave).out
        for design in plan.study.designs
        for i, wave in enumerate(plan.study.waves)
    }
    modes = f"{plan.folder}/modes.nc"  # of a shell
    response = {"response": plan.response.out} if plan.study.needs_bem else {}
    paths = plan.hydro_files | response | ({"modes": modes} if modes in plan.products else {}) | runs
    return {name: xr.load_dataset(path) for name, path in paths.items()}


def tables(plan):
    """Rows of tables and checks by name."""
    folder = Path(plan.folder)
    found = json.loads((folder / "tables.json").read_text())
    ladder = folder / "ladder.json"
    found["ladder"] = json.loads(ladder.read_text()) if ladder.exists() else []
    return {name: [flat(row) for row in rows] for name, rows in found.items() if isinstance(rows, list)}


def flat(row):
    """A row of a table with every source of an error budget as two columns, and the parts of the numerical error."""
    found = {}
    for key, value in row.items():
        if key in ("errors", "power_error", "gain_error"):
            for source in value or ():
                found |= {f"{key} {end} {source['name']}": float(source[end]) for end in ("low", "high")}
        elif isinstance(value, list) and all(isinstance(each, float) for each in value):
            found |= {f"{key} {i}": each for i, each in enumerate(value)}
        else:
            found[key] = value
    return found


def factors(name, values, coordinates):
    """Factors of the numbers of a variable: rotations have a length less, moments one more, by a rotation another."""
    units = values.attrs.get("units", "1")
    found = np.ones(values.shape) * factor(units)
    power = -1 if name in {"position", "velocity", "rao"} else float(units != "1")
    if name in {"kernel", "kernel_state_space", "damping_state_space"}:  # of each motion on itself
        power = 2
    for axis, dim in enumerate(values.dims):
        if "dof" in dim:
            pitch = np.where(coordinates[dim].values == "Pitch", LENGTH**power, 1.0)
            found = found * np.expand_dims(pitch, [i for i in range(values.ndim) if i != axis])
    return found


def assert_same_in_other_units(own, other, units=UNITS, free=()):
    """Compare every number of every file and table but those of variables that are not unique."""
    restated_too = datasets(other)
    for what, ds in datasets(own).items():
        for variable, values in ds.variables.items():
            if np.issubdtype(values.dtype, np.number) and variable not in free:
                expected = factors(variable, values, ds) * values.values
                assert_close(restated_too[what].variables[variable].values, expected, (what, variable))
    found = tables(other)
    for table, rows in tables(own).items():
        assert len(rows) == len(found[table])
        for row, restated_row in zip(rows, found[table], strict=True):
            for key, value in row.items():
                here = (table, row.get("name"), row.get("design"), key)
                if (
                    row.get("name") in MACHINE
                    or key in MACHINE
                    or key in {"wave", "sea", "explanation", "advice", "note"}
                ):
                    continue
                if isinstance(value, float):
                    unit = units.get(key.partition(" ")[0], "-")
                    if table == "ladder" and key in {"low", "high"}:
                        unit = "W"
                    elif key in {"value", "limit"}:
                        unit = row.get("unit", "-")
                    rtol = 0.01 if table == "checks" else part(key)
                    gain = key.endswith("gain_percent") or (key in {"low", "high"} and table != "ladder")
                    least = 100 * rtol if gain else 1e-9  # a gain is of two powers, each to rtol, in percent
                    assert restated_row[key] == pytest.approx(factor(unit) * value, rel=rtol, abs=least), here
                else:
                    assert restated_row[key] == value, here


def part(key):
    """Relative tolerance; error estimates are differences of two sensitivities."""
    return 1e-4 if key.startswith(("errors", "power_error", "gain_error", "numerical")) else 1e-6


def by_label(plan):
    """Datasets by label, with designs and directions sorted."""
    found = {}
    for name, ds in datasets(plan).items():
        design, _, sea = name.partition(" ")
        if "design" in ds.dims:
            ds = ds.assign_coords(design=[usual(str(one)) for one in ds.design.values]).sortby("design")
        for dim in ds.dims:
            if dim == "wave_direction" or dim.endswith("dof"):
                ds = ds.sortby(dim)
        free = [variable for variable in ds.variables if variable.startswith("wet_")]
        found[usual(design) + (plan.study.waves[int(sea)].label if sea else "")] = ds.drop_vars(free)
    return found


def rows_by_words(rows):
    """Words and numbers of the rows of a table, sorted by words."""
    lines = [{k: v for k, v in row.items() if k not in MACHINE} for row in rows if row.get("name") not in MACHINE]
    words = [[usual(str(v)) for v in row.values() if not isinstance(v, float)] for row in lines]
    numbers = [[(v, part(k)) for k, v in row.items() if isinstance(v, float)] for row in lines]
    return sorted(zip(words, numbers, strict=True))


def assert_same_in_another_order(own, other, free=()):
    """Compare every number of every file and table in any order of designs, seas and degrees of freedom."""
    found = by_label(other)
    for what, ds in by_label(own).items():
        for variable, values in ds.variables.items():
            if np.issubdtype(values.dtype, np.number) and variable not in free:
                assert_close(found[what].variables[variable].values, values.values, (what, variable))
    there = tables(other)
    for table, rows in tables(own).items():
        for (words, numbers), (same_words, same) in zip(rows_by_words(rows), rows_by_words(there[table]), strict=True):
            assert words == same_words, (table, words, same_words)
            for (value, rtol), (same_value, _) in zip(numbers, same, strict=True):
                assert value == pytest.approx(same_value, rel=rtol, abs=1e-9), (table, words)
