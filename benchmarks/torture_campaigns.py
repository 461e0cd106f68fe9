"""Campaigns at random: years of odd buoys over what may be varied, refused in one line or told from check to page.

Buoys are those of `benchmarks.torture`, with their ports, limits, clamps, shells that buckle and dampers of nothing;
climates are a few hours of measured spectra. Runs in time, which take far longer than all the rest, are left out.
"""

import random
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from benchmarks import torture
from benchmarks.measure import Outcome, tabulated
from vsb.stages import answer, campaign, members
from vsb.stages.campaign_preview import campaign_summary
from vsb.stages.stage import STAGES
from vsb.study.campaign_plan import CampaignPlan, plan_of
from vsb.study.study import canonical
from vsb.waves.seas import jonswap_spectrum

HERTZ = np.linspace(0.04, 0.5, 24)
KEYS = (
    "device.young_modulus", "device.thickness", "device.internal_pressure", "device.mass", "pto.damping",
    "pto.stiffness", "modes.degree", "scale", "",
)  # fmt: skip
"""What is varied; sometimes nothing."""


def drawn(index: int) -> dict[str, str]:
    """Return the files of a campaign by name, always the same for an index; not all can be."""
    rng = random.Random(index)
    study = yaml.safe_load((torture.equipped if rng.random() < 0.7 else torture.odd)(rng))
    _of_linear_theory(rng, study)
    limits = {"force_limit", "stroke_limit"} & set(study["pto"])
    tunings = rng.sample(["fixed", "one", "each"], rng.randint(1, 3))
    if "damping" not in study["pto"]:
        tunings = [name for name in tunings if name != "fixed"] or ["one"]
    given: dict[str, Any] = {"campaign": "odd_year", "study": "study.yaml", "climate": {"spectra": "sea.txt"}}
    given["tuning"] = [*tunings, "constrained"] if limits else tunings
    if limits:
        given["constrained"] = {"seconds": 1.0}
    if key := rng.choice(KEYS):
        given["vary"] = {key: _values(rng, study, key)}
    radius = study["device"]["radius"]
    return {"study.yaml": yaml.safe_dump(study), "sea.txt": _sea(rng, radius), "year.yaml": yaml.safe_dump(given)}


def _of_linear_theory(rng: random.Random, study: torture.Raw) -> None:
    """Take out most of what a year by linear theory does not know; the rest is to be refused."""
    for section, keys, odds in (
        (study, ("drag",), 0.95),
        (study["pto"], ("efficiency", "law", "tuning"), 0.95),
        (study["pto"], ("force_limit", "stroke_limit"), 0.6),
    ):
        if rng.random() < odds:
            for key in keys:
                section.pop(key, None)
    study["simulation"]["method"] = "auto"
    if rng.random() < 0.8:
        study["hydro"] = {"tolerance": 1e-2}


def _values(rng: random.Random, study: torture.Raw, key: str) -> list[float]:
    """Two values of a key, its own among them, if it has one."""
    if key in {"scale", "modes.degree"}:
        return [1, 2]
    section, _, name = key.partition(".")
    own = study[section].get(name) or rng.choice([0.0, 1e3])
    return [own, own * rng.uniform(0.3, 3.0) or 1e3]


def _sea(rng: random.Random, radius: float) -> str:
    """One to four hours of measured spectra, as a buoy would write them."""
    lines = ["YY MM DD hh " + " ".join(f"{f:.4f}" for f in HERTZ)]
    for hour in range(rng.randint(1, 4)):
        height, period = rng.uniform(0.05, 3.0) * min(1.0, radius / 2), rng.uniform(4.0, 14.0)
        density = 2 * np.pi * jonswap_spectrum(2 * np.pi * HERTZ, height, period, 2.0)
        lines.append(f"1996 01 01 {hour:02d} " + " ".join(f"{one:.9e}" for one in density))
    return "\n".join(lines) + "\n"


def fate(files: dict[str, str], folder: Path) -> Outcome:
    """Return what becomes of a campaign: check it, run it in this process if it passes, to its page."""
    checked = False
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        warnings.simplefilter("error", UserWarning)
        try:
            plan = plan_of(str(folder / "year.yaml"))
            assert isinstance(plan, CampaignPlan)
            plan = CampaignPlan(plan.loaded, root=str(folder / "results"))
            campaign_summary(plan)
            checked = True
            run_campaign(plan)
        except Exception as error:
            return Outcome.of(error, "failed after check" if checked else "refused")
    return Outcome("completed", "")


def run_campaign(plan: CampaignPlan) -> None:
    """Run a campaign in this process, all its members, its tables, figures and page; what is no number is refused."""
    read = {stage.name: stage.read for stage in STAGES}
    climate, whole = plan.loaded.climate_path, canonical(plan.campaign)
    for name, spec in plan.batches.items():
        batch = read["members"](canonical(spec))
        members.run(batch, climate, f"{plan.folder}/members", plan.root, plan.batch_path(name))
    folders = (f"{plan.folder}/batches", f"{plan.folder}/verification")
    campaign.run(read["campaign"](whole), *folders, plan.data_path, plan.table_path, plan.manifest)
    out = (f"{plan.folder}/figures", f"{plan.folder}/report.html", plan.manifest)
    answer.run(read["answer"](whole), plan.data_path, climate, plan.root, *out)


def fates(count: int) -> Iterator[tuple[tuple[int], Outcome]]:
    """Meet so many campaigns with their fate."""
    for index in range(count):
        with tempfile.TemporaryDirectory() as folder:
            yield (index,), fate(drawn(index), Path(folder))


def benchmark(count: int, out: str) -> Counter[str]:
    """Write what becomes of so many campaigns as a table; return how often each of `torture.BAD` fell."""
    return tabulated(fates(count), ("index",), torture.BAD, out)
