"""Where published numbers come from: the commands, and what is read of their results."""

import html
import itertools
import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr

import vsb
from examples import claims, surprises
from examples.published.pages import Value
from vsb.errors import VsbError
from vsb.report.band import gain_band

HOME = Path(__file__).parents[2]
"""The checkout."""
RIGID, FREE = "FSB", "VSWEC"


class Source(NamedTuple):
    """Commands and what they give."""

    command: str  # what a reader types for the same numbers
    compute: Callable[[Path], Mapping[str, Value]]  # in a folder of its own, whose finished results are reused
    quick: bool = False  # seconds


def vsb_command(*words: str, folder: Path) -> str:
    """Return what a command of vsb prints, run in a folder; paths begin at the checkout."""
    folder.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "vsb", *(str(HOME / word) if (HOME / word).is_file() else word for word in words)]
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, text=True, check=False, env=os.environ)
    if done.returncode:
        raise VsbError(f"vsb {' '.join(words)}: exit code {done.returncode}")
    return done.stdout


def response_at(response: xr.Dataset, period: float) -> xr.Dataset:
    """Return a frequency response at a wave period [s]."""
    return response.interp(omega=2 * np.pi / period, method="cubic")


def power(response: xr.Dataset, damping: float) -> xr.DataArray:
    """Return mean powers at one damper [N s/m], c |V0/(1 + c/Z)|^2/2 per wave amplitude squared [W/m^2]."""
    found: xr.DataArray = damping * np.abs(response.port_velocity / (1 + damping / response.port_impedance)) ** 2 / 2
    return found


def gains(powers: xr.DataArray) -> dict[str, float]:
    """Return gains over the rigid design by design [%]."""
    found = 100 * (powers / powers.sel(design=RIGID) - 1)
    return {str(name): float(found.sel(design=name)) for name in found.design.values if name != RIGID}


def study(folder: Path) -> dict[str, Value]:
    """The example buoy in its wave and over its year."""
    printed = vsb_command("run", "config/buoy.yaml", folder=folder)
    buoy = folder / "results" / "buoy"
    found = of_buoy(vsb.open(buoy)) | {
        "last_line": printed.strip().splitlines()[-1],
        "answer": answer_on(buoy / "report.html"),
    }
    vsb_command("run", "config/year.yaml", folder=folder)
    return found | of_year(vsb.open(folder / "results" / "year"))


def answer_on(page: Path) -> str:
    """Return the answer of a report, as its first lines say it."""
    (box,) = re.findall(r'<div class="answer">(.*?)</div>', page.read_text(encoding="utf-8"), re.DOTALL)
    return html.unescape(" ".join(re.sub("<[^>]+>", " ", box).split()))


def of_buoy(results: object) -> dict[str, Value]:
    """Gains of the example's designs, with intervals, and over all waves."""
    assert isinstance(results, vsb.Results)
    table = results.gains.set_index("design")
    flexible = [name for name in table.index if name != RIGID]
    best = max(flexible, key=lambda name: float(table.best_gain_percent[name]))
    found: dict[str, Value] = {"best": best, "doubts": int((results.checks.verdict == "doubt").sum())}
    for name, design in (("best", best), *((name, name) for name in flexible)):
        found |= {
            f"{name}.gain": float(table.best_gain_percent[design]),
            f"{name}.low": float(table.best_low[design]),
            f"{name}.high": float(table.best_high[design]),
        }
    found["least.gain"] = min(float(table.best_gain_percent[name]) for name in flexible)
    (strain,) = results.checks.value[results.checks.name == "static_strain"]
    found["strain"] = 100 * float(strain)
    response = results.response
    shown = response.best_power.where(gain_band(response.best_power, RIGID), drop=True)
    gain = 100 * (shown / shown.sel(design=RIGID) - 1).sel(design=flexible).stack(at=("design", "omega"))
    for name, at in (("most", gain.idxmax("at").item()), ("least", gain.idxmin("at").item())):
        found |= {f"band.{name}": float(gain.sel(at=at)), f"band.{name}.period": 2 * np.pi / float(at[1])}
    for period in (2.5, 2.9, 4.0, 5.0):
        wave = response_at(response, period)
        by_design = gains(wave.best_power)
        found |= {f"best_damper.{period:g}s.{name}": value for name, value in by_design.items()}
        found |= {
            f"best_damper.{period:g}s.most": max(by_design.values()),
            f"best_damper.{period:g}s.least": min(by_design.values()),
        }
        at_one = gains(power(wave, 8000.0))
        found |= {f"8000.{period:g}s.{name}": value for name, value in at_one.items()}
    return found


def of_year(campaign: object) -> dict[str, Value]:
    """Gains over the year with the best damper for it: by linear theory and by body-exact runs, at both sizes."""
    assert isinstance(campaign, vsb.Campaign)
    table = campaign.table
    found: dict[str, Value] = {}
    for row in table[(table.tuning == "one") & (table.design != RIGID)].itertuples():
        for model, columns in (("linear", "gain"), ("exact", "body_exact_gain")):
            for end in ("percent", "low", "high"):
                value = float(getattr(row, f"{columns}_{end}"))
                found[f"year.{row.scale:g}.{row.design}.{model}.{end}"] = value
    for size, model in itertools.product(("1", "4"), ("linear", "exact")):
        for name, end, extreme in (
            ("least", "percent", min),
            ("most", "percent", max),
            ("low", "low", min),
            ("high", "high", max),
        ):
            among = [
                float(found[f"year.{size}.{design}.{model}.{end}"]) for design in campaign.designs if design != RIGID
            ]
            found[f"year.{size}.{model}.{name}"] = extreme(among)
    return found


def checked(folder: Path) -> dict[str, Value]:
    """What `vsb check` says of the example before it is run: shell modes, doubts."""
    printed = vsb_command("check", "config/buoy.yaml", folder=folder)
    (modes,) = re.findall(r"^modes +(\d.*)$", printed, re.MULTILINE)
    (strain,) = re.findall(r"static_strain = (\S+)", printed)
    device = vsb.load(HOME / "config" / "buoy.yaml").device
    return {
        "modes": modes,
        "strain": 100 * float(strain),
        "radius": device.radius,
        "thickness_mm": 1e3 * device.thickness,
        "pressure_kpa": device.internal_pressure / 1e3,
    }


def claim(name: str, folder: Path) -> dict[str, Value]:
    """Figures of a published claim, and the shells and modes they hold for."""
    found = claims.recorded(name, folder)
    return {**found.figures, CONDITIONS: found.conditions}


CONDITIONS = "conditions"
SOURCES: Mapping[str, Source] = {
    "study": Source("make study", study),
    "check": Source("vsb check config/buoy.yaml", checked, quick=True),
    **{
        f"claims.{name}": Source(f"python -m examples.claims results/claims {name}", partial(claim, name))
        for name in claims.CASES
    },
    **{
        f"surprises.{name}": Source(f"python -m examples.surprises results/surprises {name}", case)
        for name, case in surprises.CASES.items()
    },
}
"""By name: GROUP or GROUP.CASE; the cases of a group share a folder."""


def stored(path: Path) -> dict[str, Value]:
    """Return all values stored, by SOURCE.NAME, with the CPU seconds of each group's commands."""
    found: dict[str, Value] = {}
    for name, entry in json.loads(path.read_text(encoding="utf-8")).items():
        found |= {f"{name}.{key}": value for key, value in entry["values"].items()}
        total = f"{name.partition('.')[0]}.cpu_seconds"
        found[total] = float(found.get(total, 0.0)) + entry.get("cpu_seconds", 0.0)
    return found
