"""Where published numbers come from: the commands, and what is read of their results."""

import html
import itertools
import json
import math
import os
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
import yaml

import vsb
from examples import claims, paper_at_optimal_damping, surprises
from examples.power_from_strain import SEAS
from examples.published.pages import Value
from examples.when_flexibility_pays import DEGREE
from vsb.engine.motion.port import Port
from vsb.engine.shell.loaded import equilibrium, stable_path
from vsb.engine.waves.kinds import RegularWave
from vsb.engine.waves.water import power_limit
from vsb.errors import VsbError
from vsb.models.floating_system import floating_system
from vsb.models.rest import carries_load, complete_at_rest, complete_loaded_shell, computed_buckling, reference_shell
from vsb.models.viability import static_modal_amplitude, static_strain, viable, wrinkles
from vsb.pipeline.graph import StudyPlan
from vsb.report.answer import gain_band
from vsb.results.ledger import classical_check
from vsb.stages.make import hydro_files
from vsb.study.campaign import AT_FORCE, CAUSAL
from vsb.study.study import Study, parse
from vsb.tools.arrays import FloatArray
from vsb.tools.files import write_text

HOME = Path(__file__).parents[2]
"""The checkout."""
EXAMPLE = HOME / "config" / "buoy.yaml"
PAPER_SHELL = HOME / "config" / "seed.yaml"
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


def examples_command(name: str, *words: str) -> None:
    """Run an example in the checkout."""
    subprocess.run([sys.executable, "-m", f"examples.{name}", *words], cwd=HOME, check=True, stdout=subprocess.DEVNULL)


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
    periods = np.arange(2.0, 6.0, 0.01)
    best_power = response.best_power.interp(omega=2 * np.pi / periods, method="cubic")
    gained = periods[(best_power.sel(design=FREE) > best_power.sel(design=RIGID)).values]
    found |= {"band.gain.from": float(gained.min()), "band.gain.to": float(gained.max())}
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
    device = vsb.load(EXAMPLE).device
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
    return found.figures | ({CONDITIONS: found.conditions} if found.conditions else {})


def pays_map(folder: Path) -> dict[str, Value]:
    """When flexibility pays: gains with a limited force over period and modulus, and the shells' strain at rest."""
    if not (folder / "map.csv").is_file():
        examples_command("when_flexibility_pays", str(folder))
    rows = pd.read_csv(folder / "map.csv")
    rows["modulus"] = rows.young_modulus / 1e6
    left_open = float((rows.gap / (1 - rows.gap) * (1 + rows.gain_percent / 100)).max())  # if one optimum is the bound
    # To the digit that is printed: where a search ends within its gap differs by a few per cent of it between machines.
    found: dict[str, Value] = {"gap": round(100 * float(rows.gap.max()), 1), "gap.points": round(100 * left_open, 1)}
    for row in rows[(rows.wave == "jonswap") & rows.force_limit.isin(FORCES) & rows.period.isin(PEAKS)].itertuples():
        found[f"{row.modulus:g}.{row.force_limit:g}.{row.period:g}"] = float(row.gain_percent)
    weak = rows[rows.force_limit == FORCES[0]]
    for modulus, some in weak[weak.wave == "regular"].groupby("modulus"):
        found[f"{modulus:g}.regular.3"] = float(some.gain_percent[some.period == 3.0].iloc[0])
    gain = weak[(weak.wave == "jonswap") & (weak.modulus == 40.0) & weak.period.between(3.0, 5.0)].gain_percent
    found |= {"weak.least": float(gain.min()), "weak.most": float(gain.max())}
    for modulus, some in rows[np.isinf(rows.force_limit)].groupby("modulus"):
        found[f"{modulus:g}.ideal"] = float(some.gain_percent.min())
    for modulus in (10.0, 20.0, 40.0):
        found[f"{modulus:g}.strain"] = 100 * strain_at_rest(1e6 * modulus)
    for wall in OPEN_WALLS:
        raw = vsb.load(PAPER_SHELL).model_dump()
        raw["device"]["thickness"] = 1e-3 * wall
        found[f"open.{wall}.modulus"] = raw["device"]["young_modulus"] / 1e6 / computed_buckling(parse(raw)).load_factor
    return found


OPEN_WALLS = (5, 50)
"""Walls of shells without internal pressure, whose least modulus that carries the load is published [mm]."""
FORCES, PEAKS = (0.1, 1.0), (2.0, 2.7, 3.0, 4.0, 5.0, 8.0)
"""Limits of force [rms force of the rigid buoy's optimal damper] and peak periods [s] of the page's table."""


def strain_at_rest(young_modulus: float) -> float:
    """Return the largest strain of the example's shell at rest with another modulus [-]."""
    raw = vsb.load(EXAMPLE).model_dump()
    raw["device"]["young_modulus"] = young_modulus
    raw["modes"] |= {"degree": DEGREE}
    study = parse(raw)
    reference = reference_shell(study)
    return static_strain(reference.basis, static_modal_amplitude(study, reference))


def pays_in_a_year(folder: Path) -> dict[str, Value]:
    """Gain within limits of force over the year, by modulus and limit, and the shells' strain at rest."""
    vsb_command("run", "config/when_it_pays.yaml", folder=folder)
    campaign = vsb.open(folder / "results" / "when_it_pays")
    assert isinstance(campaign, vsb.Campaign)
    found: dict[str, Value] = {}
    for row in campaign.table[campaign.table.design == FREE].to_dict("records"):
        modulus, limit = row["device.young_modulus"] / 1e6, row["pto.force_limit"] / 1e3
        found |= {f"{modulus:g}.{limit:g}.{end}": float(row[f"gain_{end}"]) for end in ("percent", "low", "high")}
    for modulus in MODULI:
        found[f"{modulus}.strain"] = 100 * strain_at_rest(1e6 * modulus)
    stiff = [modulus for modulus in MODULI if float(found[f"{modulus}.strain"]) <= DOUBTED]
    found["undoubted.most"] = max(float(found[f"{modulus}.{limit}.high"]) for modulus in stiff for limit in LIMITS)
    return found


def at_force(folder: Path) -> dict[str, Value]:
    """Gain over the same year at a given rms force, and at that of the optimal damper, and the rigid buoy's energy."""
    given = yaml.safe_load((HOME / "config" / "when_it_pays.yaml").read_text(encoding="utf-8"))
    del given["constrained"]
    found: dict[str, Value] = {}
    for name, tunings in (("at_force", AT_FORCE), (OWN_FORCE, ("one", CAUSAL))):
        files = {"study": str(EXAMPLE), "climate": {"spectra": str(HOME / SEAS)}}
        raw = {**given, **files, "campaign": name, "tuning": [*tunings], "vary": dict(given["vary"])}
        if name == OWN_FORCE:
            del raw["vary"]["pto.force_limit"]
        write_text(folder / f"{name}.yaml", yaml.safe_dump(raw, sort_keys=False))
        vsb_command("run", f"{name}.yaml", folder=folder)
        campaign = vsb.open(folder / "results" / name)
        assert isinstance(campaign, vsb.Campaign)
        found |= gains_at_force(campaign.table)
    return found


def gains_at_force(table: pd.DataFrame) -> dict[str, Value]:
    """Gains of the free shell and energies of the rigid buoy by force and tuning, from the table of a campaign."""
    found: dict[str, Value] = {}
    for row in table.to_dict("records"):
        force = f"{row['pto.force_limit'] / 1e3:g}" if "pto.force_limit" in row else OWN_FORCE
        place = f"{force}.{row['tuning']}"
        if row["design"] == RIGID:
            found[f"rigid.{place}"] = float(row["annual_energy"])
        if row["design"] == FREE:
            place = f"{row['device.young_modulus'] / 1e6:g}.{place}"
            found |= {f"{place}.{end}": float(row[f"gain_{end}"]) for end in ("percent", "low", "high")}
    return found


OWN_FORCE = "own_force"
"""In place of a limit: the rms force of the optimal damper."""
MODULI, LIMITS = (20, 40, 80, 160), (4, 12, 40)
"""Young's moduli [MPa] and limits of force [kN] of config/when_it_pays.yaml."""
DOUBTED = 2.0
"""Strain above which Hooke's law is doubted [%]."""


def best_buoy(folder: Path) -> dict[str, Value]:
    """The best flexible and the best rigid buoy of the design problem shipped, the proof, and what limits them."""
    raw = yaml.safe_load((HOME / "config" / "best_buoy.yaml").read_text(encoding="utf-8"))
    raw |= {"study": str(EXAMPLE), "climate": {"spectra": str(HOME / SEAS)}, "verify": VERIFY}
    write_text(folder / "best_buoy.yaml", yaml.safe_dump(raw, sort_keys=False))
    vsb_command("run", "best_buoy.yaml", folder=folder)
    best = vsb.open(folder / "results" / "best_buoy")
    assert isinstance(best, vsb.BestBuoy)
    facts = best.facts
    found: dict[str, Value] = {f"gain.{end}": float(value) for end, value in facts["gain"].items()}
    for name, power_of in facts["power"].items():
        found[f"{name}.power"] = float(power_of)
        found |= {f"{name}.{key}": float(value) for key, value in facts["quantities"][name].items() if key in SIZES}
    for name, one in facts["found"].items():
        found |= {f"{name}.{row['key']}": float(row["value"]) for row in one["variables"]}
        found[f"{name}.starts"] = sum(bool(start["accepted"]) for start in facts["starts"][name])
    found |= {f"runs.{end}": float(facts["verified"][end]) for end in ("value", "low", "high")}
    for row in facts["budget"]:
        found[f"error.{row['name']}"] = max(-float(row["low"]), float(row["high"]))
    for limit, buoys in facts["fronts"].items():
        for name, front in buoys.items():
            found |= {f"{name}.{limit}.{one['limit']:g}": float(one["objective"]) for one in front}
    weights = facts["found"]["flexible"]["multipliers"]
    for limit, more in (("force_rms", 0.1 * facts["limits"]["force_rms"]), ("beam", 0.1), ("stroke_rms", 0.1)):
        found[f"worth.{limit}"] = 100 * more / facts["limits"][limit] * float(weights.get(limit, 0.0))
    both = ("flexible", "rigid competitor")
    found["accepted"] = sum(int(found[f"{name}.starts"]) for name in both)
    beams = [float(found[f"{name}.beam"]) for name in ("flexible", "undeformed shape")]
    found["stretch"] = 100 * (beams[0] / beams[1] - 1)
    found["size_gain"] = 100 * (facts["power"]["flexible"] / facts["power"]["undeformed shape"] - 1)
    found["twin_gain"] = 100 * (facts["power"]["flexible"] / facts["power"]["rigid twin"] - 1)
    for force in ("10000", "20000", "40000"):
        flexible, rigid = (float(found[f"{name}.force_rms.{force}"]) for name in both)
        found[f"gain_at.{force}"] = 100 * (flexible / rigid - 1)
    return found


SITES: Mapping[str, dict[str, Any]] = {
    "NDBC 46042": {"spectra": SEAS},
    "PacWave": {"scatter": "config/climate/PacWave-South_Oregon_Wave-Resource.csv", "spectrum": "jonswap"},
    "short waves": {"scatter": "config/climate/short_waves.csv", "spectrum": "jonswap"},
}
CONTROL_NAMES = {"one": "damper", "causal": "control"}
AT_SITES = tuple((site, tuning) for site in SITES for tuning in CONTROL_NAMES)
SITE_FORCES = (5, 10, 20)
"""Climates of the sites compared, names of take-offs by `tuning`, what is compared, and limits of force [kN]."""


def best_buoy_of(site: str, tuning: str, folder: Path) -> dict[str, Value]:
    """The best buoys of a site over the limit of force, with one damper or causal control, from one start each."""
    raw = yaml.safe_load((HOME / "config" / "best_buoy.yaml").read_text(encoding="utf-8"))
    climate = {key: str(HOME / value) if key != "spectrum" else value for key, value in SITES[site].items()}
    name = f"{site.replace(' ', '_')}_{CONTROL_NAMES[tuning]}"
    raw |= {"design": name, "study": str(EXAMPLE), "climate": climate, "tuning": tuning, "starts": 1}
    raw["pareto"] = {"force_rms": [1e3 * force for force in SITE_FORCES]}
    if tuning == CAUSAL:
        raw["variables"] = {key: one for key, one in raw["variables"].items() if not key.startswith("pto.")}
        raw["competitor"] = {"variables": ["device.radius", "device.mass"]}
    write_text(folder / f"{name}.yaml", yaml.safe_dump(raw, sort_keys=False))
    vsb_command("run", f"{name}.yaml", folder=folder)
    best = vsb.open(folder / "results" / name)
    assert isinstance(best, vsb.BestBuoy)
    found: dict[str, Value] = {}
    for buoy, points in best.facts["fronts"]["force_rms"].items():
        for one in points:
            at = f"{one['limit'] / 1e3:g}"
            found[f"{buoy}.{at}"] = float(one["power"]["value"])
            found[f"{buoy}.{at}.accepted"] = str(one["accepted"] and not one["not_valid"])
            if one["gain"]:
                found |= {f"gain.{at}.{end}": float(one["gain"][end]) for end in ("value", "low", "high")}
    return found


def best_buoy_runs(name: str, limits: Mapping[str, float], folder: Path) -> dict[str, Value]:
    """The best buoys in short waves within the least force and other limits, and body-exact runs of both."""
    raw = yaml.safe_load((HOME / "config" / "best_buoy.yaml").read_text(encoding="utf-8"))
    climate = {"scatter": str(HOME / SITES["short waves"]["scatter"]), "spectrum": "jonswap"}
    raw |= {"design": name, "study": str(EXAMPLE), "climate": climate, "starts": 2, "pareto": {}}
    raw |= {"limits": raw["limits"] | {"force_rms": 1e3 * SITE_FORCES[0], **limits}, "verify": VERIFY | {"seas": 12}}
    write_text(folder / f"{name}.yaml", yaml.safe_dump(raw, sort_keys=False))
    vsb_command("run", f"{name}.yaml", folder=folder)
    best = vsb.open(folder / "results" / name)
    assert isinstance(best, vsb.BestBuoy)
    facts = best.facts
    found: dict[str, Value] = {f"gain.{end}": float(value) for end, value in facts["gain"].items()}
    found |= {f"runs.{end}": float(facts["verified"][end]) for end in ("value", "low", "high")}
    for buoy, one in facts["found"].items():
        found |= {f"{buoy}.{row['key']}": float(row["value"]) for row in one["variables"]}
        found[f"{buoy}.starts"] = sum(bool(start["accepted"]) for start in facts["starts"][buoy])
    found |= {f"{buoy}.power": float(power_of) for buoy, power_of in facts["power"].items()}
    found["strain"] = 100 * float(facts["quantities"]["flexible"]["static_strain"])
    return found


VERIFY = {"seas": 24, "model": "body_exact"}
SIZES = ("beam", "draft")


def directions_of(folder: Path) -> dict[str, Value]:
    """Gains at ports on heave, surge and pitch."""
    path = folder / "directions.csv"
    if not path.is_file():
        examples_command("directions", str(path))
    found: dict[str, Value] = {}
    rows = list(pd.read_csv(path).itertuples())
    for row in rows:
        name = f"{row.shell}.{row.port}.{row.period:g}"
        found |= {f"{name}.rigid": float(row.rigid_limit_fraction), f"{name}.gain": float(row.gain_percent)}
        found[f"{row.shell}.{row.port}.degree"] = int(row.degree)
    beyond = [abs(float(row.by_further_modes)) for row in rows if row.shell == "inflated"]
    return found | {"further": max(beyond)}


def strain(folder: Path) -> dict[str, Value]:
    """Shares of a year's power by take-off, mooring, size and shell."""
    path = folder / "power_from_strain.csv"
    if not path.is_file():
        examples_command("power_from_strain", str(folder), "config/strain.yaml", "config/pressurised.yaml")
    return {
        f"{row.study}.{row.scale:g}.{row.take_off}.{row.mooring}": float(row.share_percent)
        for row in pd.read_csv(path).itertuples()
    }


def paper(folder: Path) -> dict[str, Value]:
    """The paper's Table II with its own loading: as stated and as inferred, and with optimal damping."""
    found: dict[str, Value] = {}
    for name in PAPERS:
        vsb_command("run", f"config/{name}.yaml", folder=folder)
        results = vsb.open(folder / "results" / name)
        assert isinstance(results, vsb.Results)
        for row in results.comparison.itertuples():
            at = f"{name}.{row.design}"
            found |= {f"{at}.{key}": float(getattr(row, key)) for key in ("displacement_pp", "velocity_pp")}
            found[f"{at}.pto_force_pp"] = float(row.damping) * float(row.velocity_pp)
            found |= {
                f"{at}.{key}": float(getattr(row, key)) for key in ("power_peak", "energy", "energy_gain_percent")
            }
        found[f"{name}.over_limit"] = over_limit(vsb.load(HOME / "config" / f"{name}.yaml"), results)
        for best in paper_at_optimal_damping.rows_of(vsb.load(HOME / "config" / f"{name}.yaml")):
            found |= {f"{name}.{best.design}.{key}": value for key, value in best._asdict().items() if key != "design"}
    return found


def over_limit(study: Study, results: vsb.Results) -> float:
    """Return the rigid buoy's mean power under an assumed pressure over what a wave of the same pressure allows [-]."""
    water, (wave,) = study.water, study.waves
    assert isinstance(wave, RegularWave)
    assert study.hydro.pressure is not None
    amplitude = study.hydro.pressure / (water.density * water.gravity)
    limit = power_limit(2 * np.pi / wave.period, water.depth, water.density, water.gravity) * amplitude**2
    return float(results.comparison.set_index("design").power_mean[RIGID]) / float(limit)


def choices(folder: Path) -> dict[str, Value]:
    """Peak power and energy of the inferred case by what the paper leaves unstated: shell modes and damping."""
    raw = vsb.load(HOME / "config" / "paper_inferred.yaml").model_dump()
    found: dict[str, Value] = {}
    for basis, beta in itertools.product(BASES, DAMPINGS):
        raw["modes"] |= {"basis": basis}
        raw["device"]["damping"] |= {"beta": beta}
        study = parse({**raw, "study": f"inferred_{basis}_{1e3 * beta:g}"})
        results = vsb.run(study, folder / "results")
        for row in results.comparison.itertuples():
            at = f"{basis}.{beta:g}.{row.design}"
            found |= {f"{at}.power_peak": float(row.power_peak), f"{at}.energy": float(row.energy)}
    return found


BASES, DAMPINGS = ("paper", "membrane", "full"), (1e-3, 0.0)
"""Shell modes and structural damping, D = beta K [s]."""


def with_radiation(folder: Path) -> dict[str, Value]:
    """The paper's shell in its wave with radiation: buckling, what membrane modes give, and carried by pressure."""
    study = vsb.load(PAPER_SHELL)
    buckling = computed_buckling(study)
    membrane = _with_modes(study, "membrane", 6)
    seen = ports_of(membrane, folder, np.array([2.5]))
    best = {name: float(port.best_power[0]) for name, port in seen.items()}
    at_one = {name: float(port.power(8000.0)[0]) for name, port in seen.items()}
    return {
        "buckling": 100 * buckling.load_factor,
        "buckling.degree": buckling.degree,
        "buckling.classical": 100 / float(classical_check(study, reference_shell(membrane)).value),
        "membrane.best": 100 * (best[FREE] / best[RIGID] - 1),
        "membrane.8000": 100 * (at_one[FREE] / at_one[RIGID] - 1),
        **pressurised(folder),
    }


def pressurised(folder: Path) -> dict[str, Value]:
    """The paper's shell carried by internal pressure, at one damper: strain at rest, gains over periods."""
    study, periods = vsb.load(HOME / "config" / "pressurised.yaml"), np.arange(2.0, 10.0, 0.02)
    powers = [
        {name: port.power(8000.0) for name, port in ports_of(one, folder, periods).items()}
        for one in (study, _with_modes(study, "full", 10))
    ]
    few, more = powers
    gain = 100 * (few[FREE] / few[RIGID] - 1)
    reference = reference_shell(study)
    return {
        "pressurised.strain": 100 * static_strain(reference.basis, static_modal_amplitude(study, reference)),
        "pressurised.from": float(periods[np.flatnonzero(gain < 0).max() + 1]),
        "pressurised.most": float(gain.max()),
        "pressurised.most.period": float(periods[gain.argmax()]),
        "pressurised.2.5s": float(gain[np.searchsorted(periods, 2.5 - 1e-9)]),
        "pressurised.degrees": 100 * float(np.abs(more[FREE] - few[FREE]).max() / few[FREE].max()),
    }


def ports_of(study: Study, folder: Path, periods: FloatArray) -> dict[str, Port]:
    """Return what the take-off sees of the rigid and the free design in regular waves of some periods."""
    raw = study.model_dump()
    raw |= {"designs": {name: raw["designs"][name] for name in (RIGID, FREE)}}
    one = parse(raw)
    return floating_system(one, hydro_files(one, folder)["database"]).ports(2 * np.pi / periods)


def _with_modes(study: Study, basis: str, degree: int) -> Study:
    """A study with other shell modes."""
    return parse({**study.model_dump(), "modes": {"basis": basis, "degree": degree}})


def statics(folder: Path) -> dict[str, Value]:
    """Loads at which shells give way: the paper's, open inside and under pressure, and that of config/rubber.yaml."""
    del folder
    study, rubber = StudyPlan(vsb.load(PAPER_SHELL)).with_degree().study, vsb.load(HOME / "config" / "rubber.yaml")
    shell, least = complete_loaded_shell(study), viable(study).pressure
    carried, at_rest = complete_at_rest(_at_pressure(study, least))
    found: dict[str, Value] = {
        "classical.pressure": shell.basis.shell.buckling_pressure,
        "keel": study.water.density * study.water.gravity * study.draft / 1e3,
        "linear": 100 * computed_buckling(study).load_factor,
        "linear.degree": computed_buckling(study).degree,
        "classical": 100 / float(classical_check(study, reference_shell(study)).value),
        "path": 100 * stable_path(shell).reached,
        "least.linear": least / 1e3,
        "least.path": bound(study, carries_load, 14324.21875, 14335.9375) / 1e3,
        "strain": 100 * float(np.max(carried.elastic.strains(at_rest))),
        "rubber.tense": bound(rubber, lambda s: not wrinkles(*complete_at_rest(s)).compressed, 14250, 14269.53125)
        / 1e3,
        "rubber.limit": bound(rubber, lambda one: not carries_load(one), 32796.875, 32812.5) / 1e3,
    }
    for pressure in (10, 22, 30, 33):
        shell = complete_loaded_shell(_at_pressure(rubber, 1e3 * pressure))
        reached = stable_path(shell, until=2.0).reached
        found |= {f"rubber.{pressure}.load": reached, f"rubber.{pressure}.percent": 100 * reached}
        if pressure in (22, 30):
            strains = np.array(shell.elastic.strains(equilibrium(shell)))
            for name, strain in (("least", strains.min()), ("most", strains.max())):
                found[f"rubber.{pressure}.{name}"] = math.sqrt(1 + 2 * strain)
    return found


def shape_dependence(folder: Path) -> dict[str, Value]:
    """How far the power of the free shell of config/few_modes.yaml depends on the shapes its motion passes through."""
    printed = vsb_command("shape-dependence", "config/few_modes.yaml", "shape", folder=folder)
    (found,) = re.findall(rf"{FREE}, \S+: (\S+) W changes by (\S+) to (\S+) % .*?, (\S+) % on average", printed)
    return dict(zip(("power", "low", "high", "mean"), map(float, found), strict=True))


def stays_tense(study: Study) -> bool:
    """Whether no part of the shell at rest is compressed."""
    return not wrinkles(*complete_at_rest(study)).compressed


def bound(study: Study, holds: Callable[[Study], bool], low: float, high: float) -> float:
    """Return the internal pressure between two from which on something holds, to 20 Pa [Pa]."""
    for end, expected in ((low, False), (high, True)):
        if holds(_at_pressure(study, end)) != expected:
            raise VsbError(f"bound: received {low:g} to {high:g} Pa, needs pressures on both sides of where it holds")
    while high - low > 20.0:
        middle = (low + high) / 2
        low, high = (low, middle) if holds(_at_pressure(study, middle)) else (middle, high)
    return high


def _at_pressure(study: Study, pressure: float) -> Study:
    """A study with another internal pressure [Pa]."""
    raw = study.model_dump()
    return parse({**raw, "device": {**raw["device"], "internal_pressure": pressure}})


def bodies(folder: Path) -> dict[str, Value]:
    """Powers of the barge with a hinge, of WEC-Sim's two bodies and barge, and the float's year at three springs."""
    for name in ("hinged_barge", "float_year"):
        vsb_command("run", f"config/{name}.yaml", folder=folder)
    hinged, year = (vsb.open(folder / "results" / name) for name in ("hinged_barge", "float_year"))
    assert isinstance(hinged, vsb.Results)
    assert isinstance(year, vsb.Campaign)
    found: dict[str, Value] = {}
    for row in hinged.comparison.to_dict("records"):
        place = f"hinge.{row['wave'].rpartition('_T')[2]}.{row['design']}"
        found |= {f"{place}.{end}": float(row[f"power_{end}"]) / 1e3 for end in ("mean", "low", "high")}
    for row in hinged.ladder[hinged.ladder.rung == "best_spring_damper"].to_dict("records"):
        found[f"hinge.{row['wave'].rpartition('_T')[2]}.{row['design']}.spring"] = float(row["power_mean"]) / 1e3
    (gap,) = hinged.checks.value[hinged.checks.name.str.endswith("hinge_gap")]
    stiffness = float(hinged.database.hydrostatic_stiffness.sel(influenced_dof="Hinge", radiating_dof="Hinge"))
    found |= {"gap": 100 * float(gap), "hinge.stiffness": stiffness / 1e6, "sealed": stiffness / 1e6 / (1 - float(gap))}
    for row in year.table[(year.table.design == "heave") & (year.table.tuning == "one")].to_dict("records"):
        found[f"year.{row['pto.stiffness']:g}"] = float(row["annual_energy"])
    for name, data in (("rm3", "rm3/rm3"), ("wec_sim_barge", "barge/barge")):
        results = printed_study(name, f"wamit: {HOME / 'tests' / 'data' / data}", folder)
        for row in results.comparison.to_dict("records"):
            found[f"{name}.{row['design']}"] = float(row["power_mean"]) / 1e3
        apart = results.checks.value[results.checks.name == "time_and_frequency_domain"]
        found[f"{name}.time"] = 100 * float(apart.max())
    return found


def printed_study(name: str, source: str, folder: Path) -> vsb.Results:
    """Run a study that the page on bodies prints, with WAMIT's files where they are here."""
    page = (HOME / "docs" / "own-body.md").read_text(encoding="utf-8")
    (text,) = re.findall(rf"```yaml\n(study: {name}\n.*?)```", page, re.DOTALL)
    write_text(folder / f"{name}.yaml", re.sub(r"wamit: \w+", lambda _: source, text))
    vsb_command("run", f"{name}.yaml", folder=folder)
    results = vsb.open(folder / "results" / name)
    assert isinstance(results, vsb.Results)
    return results


PAPERS = ("paper", "paper_inferred")
CONDITIONS = "conditions"
SOURCES: Mapping[str, Source] = {
    "study": Source("make study", study),
    "check": Source("vsb check config/buoy.yaml", checked, quick=True),
    "map": Source("python -m examples.when_flexibility_pays results/when_flexibility_pays", pays_map),
    "when_it_pays": Source("vsb run config/when_it_pays.yaml", pays_in_a_year),
    "at_force": Source(
        "vsb run config/when_it_pays.yaml, with tuning: [damper_same_force, causal]; with [one, causal] and no "
        "force_limit",
        at_force,
    ),
    "best_buoy": Source("vsb run config/best_buoy.yaml, with verify: {seas: 24, model: body_exact}", best_buoy),
    **{
        f"best_buoy_of.{site} {CONTROL_NAMES[tuning]}": Source(
            f"vsb run config/best_buoy.yaml, in {site}, with tuning: {tuning}, starts: 1 and a front of force",
            partial(best_buoy_of, site, tuning),
        )
        for site, tuning in AT_SITES
    },
    **{
        f"best_buoy_of.{name}": Source(
            f"vsb run config/best_buoy.yaml, in short waves, with limits: {said}, starts: 2 and "
            "verify: {seas: 12, model: body_exact}",
            partial(best_buoy_runs, f"short_waves_{name}", limits),
        )
        for name, limits, said in (
            ("runs", {}, "{force_rms: 5000}"),
            ("stiff", {"static_strain": 0.02}, "{force_rms: 5000, static_strain: 0.02}"),
        )
    },
    "directions": Source("python -m examples.directions results/directions.csv", directions_of),
    "strain": Source(
        "python -m examples.power_from_strain results/power_from_strain config/strain.yaml config/pressurised.yaml",
        strain,
    ),
    "paper": Source("vsb run config/paper.yaml, config/paper_inferred.yaml", paper),
    "paper.choices": Source(
        "vsb run config/paper_inferred.yaml, with modes.basis paper, membrane and full, device.damping.beta 1e-3 and 0",
        choices,
    ),
    "paper.radiation": Source(
        "vsb run config/seed.yaml, with modes: {basis: membrane, degree: 6}; vsb run config/pressurised.yaml",
        with_radiation,
    ),
    "statics": Source("vsb check of config/seed.yaml and config/rubber.yaml at other pressures", statics, quick=True),
    "shape": Source("vsb shape-dependence config/few_modes.yaml shape", shape_dependence),
    "bodies": Source(
        "vsb run config/hinged_barge.yaml, config/float_year.yaml, and studies rm3 and wec_sim_barge of the page",
        bodies,
    ),
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
