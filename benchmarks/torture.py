"""Studies at random, broken ones and odd ones: each is refused in one line or runs to finite results.

Broken studies are the seed's with a key taken out, renamed or given junk, or its text cut and altered. Odd ones are
drawn from physical ranges: sizes, shells, depths, bands, seas, windows, methods, clamps, small enough to take a second.
Equipped ones are odd, too, in what takes power off: ports, laws, tunings, limits, directions, drag.
"""

import copy
import math
import random
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import yaml

from benchmarks.measure import Outcome, tabulated
from vsb.pipeline.graph import StudyPlan
from vsb.stages import preview
from vsb.stages.make import make
from vsb.study.study import Study, load
from vsb.tools.commands import HOME

Raw = dict[str, Any]
FEW_MODES = HOME / "config" / "few_modes.yaml"
DIGITS = "twenty thousand digits"
JUNK: tuple[Any, ...] = (
    None, True, "", "x", "1e5", "é" * 3, "/etc", [], {}, [[]], {"a": {"b": 1}}, -1, 0, 0.5, 1e308, -1e308, 1e25, 1e-300,
    math.nan, math.inf, -math.inf, 10**30, -(10**30), DIGITS, [1.0, "two"], "x" * 100_000, list(range(3000)),
)  # fmt: skip
"""Values that no key wants, or not of that size."""


BAD = ("failed after check", "traceback", "not finite", "long message")
"""What must not become of a study."""


# studies ------------------------------------------------------------------------------------------------------------


def broken(rng: random.Random) -> str:
    """Return the text of a study with one to three things wrong with it."""
    raw: Raw = yaml.safe_load(FEW_MODES.read_text(encoding="utf-8"))
    raw["modes"]["degree"], raw["hydro"] = 2, {"model": "linear", "tolerance": 0.01, "omega_max": 4.0}
    raw["simulation"] |= {"duration": 6.0, "window": [3.0, 6.0]}
    for _ in range(rng.randint(1, 3)):
        damage(rng, raw, JUNK)
    text = yaml.safe_dump(raw, sort_keys=False, allow_unicode=True).replace(DIGITS, f"0x{'f' * 20_000}")
    if rng.random() < 0.15:
        at = rng.randrange(len(text))
        text = rng.choice([text[:at], text[:at] + rng.choice("{}[]:,&*#|>\t\x00\ufeff") + text[at:]])
    return text


def damage(rng: random.Random, raw: Any, junk: Sequence[Any]) -> str:
    """Take a key out of nested values, misspell it, or give it junk, anywhere; return its place."""
    here, place = raw, ""
    while True:
        keys = list(here) if isinstance(here, dict) else list(range(len(here)))
        if not keys:
            return place
        key = rng.choice(keys)
        place = f"{place}.{key}".lstrip(".")
        deeper = isinstance(here[key], dict | list) and rng.random() < 0.8
        if not deeper:
            break
        here = here[key]
    kind = rng.random()
    if kind < 0.2:
        here.pop(key)
    elif kind < 0.3 and isinstance(here, dict):
        here[str(key) + rng.choice("_x9 ")] = here.pop(key)
    else:
        here[key] = copy.deepcopy(rng.choice(junk))
    return place


def odd(rng: random.Random) -> str:
    """Return the text of a study from physical ranges, small enough to take a second or two; not all can be."""
    return yaml.safe_dump(_odd(rng))


def _odd(rng: random.Random) -> Raw:
    """A study from physical ranges, with a plain damper."""
    radius, density, gravity = 10 ** rng.uniform(-0.7, 1.5), rng.choice([1025.0, 1000.0, 800.0]), 9.81
    thickness = radius * 10 ** rng.uniform(-3.3, -1.05)
    full, natural = 4 / 3 * math.pi * radius**3 * density, math.sqrt(gravity / radius)
    mass = full * rng.choice([0.5, rng.uniform(0.02, 0.98)])
    shell_density = min(rng.uniform(500.0, 8000.0), 0.9 * mass / (4 * math.pi * radius**2 * thickness))
    weight = density * gravity * radius
    model = rng.choice(["linear", "linear", "linear", "body_exact", "assumed_pressure", "auto"])
    device = {
        "radius": radius,
        "thickness": thickness,
        "young_modulus": weight * radius / thickness * 10 ** rng.uniform(0.5, 5.0),
        "poisson_ratio": rng.uniform(-0.3, 0.49),
        "density": shell_density,
        "mass": mass,
        "internal_pressure": 0.0 if rng.random() < 0.6 else weight * rng.uniform(-0.3, 1.5),
        "damping": {"alpha": rng.choice([0.0, 0.1]), "beta": rng.choice([0.0, 1e-3, 0.1])},
    }
    if rng.random() < 0.2:
        device["gas"] = {}
    highest = natural * rng.uniform(1.5, 5.0)
    hydro: Raw = {"model": model, "tolerance": rng.choice([1e-2, 1e-3, 3e-2]), "omega_max": highest, "witness": "none"}
    if model == "assumed_pressure":
        hydro = {"model": model, "pressure": weight * 10 ** rng.uniform(-3.0, -0.5)}
    waves = [_wave(rng, radius, natural, highest) for _ in range(rng.choice([1, 1, 2]))]
    periods = [float(wave.get("period") or wave.get("tp") or 0.0) for wave in waves]
    slowest = max(2 * math.pi / natural, *periods)
    duration = slowest * 10 ** rng.uniform(-1.0, 1.0 if model == "linear" else 0.3)
    begin, end = sorted(rng.uniform(0.0, duration) for _ in range(2))
    method = {"linear": ["auto", "exact", "convolution"], "auto": ["auto"]}.get(model, ["auto", "exponential"])
    depth = math.inf if rng.random() < 0.6 else radius * 10 ** rng.uniform(-0.5, 1.5)
    return {
        "study": "odd",
        "device": device,
        "modes": {"basis": rng.choice(["membrane", "full", "paper"]), "degree": rng.choice([0, 1, 2, 2, 3])},
        "reference_shape": rng.choice(["undeformed"] * 3 + ["equilibrium"]),
        "designs": _designs(rng),
        "water": {"density": density, "depth": depth, "gravity": gravity},
        "hydro": hydro,
        "pto": {"damping": rng.choice([0.0, 1.0, 1.0, 1.0]) * density * radius**3 * natural * 10 ** rng.uniform(-3, 2)},
        "waves": waves,
        "simulation": {
            "duration": duration,
            "window": rng.choice([[begin, end], [0.0, duration], [0.5 * duration, duration]]),
            "initial_position": rng.choice([0.0, radius * rng.uniform(-0.3, 0.3)]),
            "initial_velocity": rng.choice([0.0, natural * radius * rng.uniform(-0.2, 0.2)]),
            "tolerance": rng.choice([1e-3, 1e-4]),
            "method": rng.choice(method),
        },
    }  # fmt: skip


def _wave(rng: random.Random, radius: float, natural: float, highest: float) -> Raw:
    """A sea of any kind within the band, or nearly."""
    omega = min(natural * rng.uniform(0.15, 3.0), rng.choice([1.0, 1.05]) * highest)
    height = radius * 10 ** rng.uniform(-3, -1)
    kind = rng.choice(["regular", "regular", "regular", "jonswap", "pierson_moskowitz", "white_noise", "still"])
    if kind == "regular":
        return {"kind": kind, "amplitude": height, "period": 2 * math.pi / omega}
    if kind == "still":
        return {"kind": kind}
    if kind == "white_noise":
        return {"kind": kind, "hs": height, "band": [0.3 * omega, omega], "seed": rng.randrange(100)}
    return {"kind": kind, "hs": height, "tp": 2 * math.pi / omega, "seed": rng.randrange(100)}


def _designs(rng: random.Random) -> Raw:
    """One to three designs with any clamps."""
    clamps: list[Any] = [0, 90, 180, rng.uniform(0.0, 180.0), [0, 180], [rng.uniform(0.0, 180.0), 90.0]]
    found: Raw = {"FSB": {"flexible": False}} if rng.random() < 0.8 else {}
    if rng.random() < 0.7 or not found:
        found["VSWEC"] = {}
    if rng.random() < 0.4:
        found["CLAMPED"] = {"clamp": rng.choice(clamps)}
    return found


def equipped(rng: random.Random) -> str:
    """Return the text of an odd study with any take-off, some of them in the plane of the waves, some with drag."""
    raw = _odd(rng)
    radius, natural, damping = (
        raw["device"]["radius"],
        9.81**0.5 * raw["device"]["radius"] ** -0.5,
        raw["pto"]["damping"],
    )
    if rng.random() < 0.8:
        raw["hydro"] = {"model": rng.choice(["linear", "linear", "body_exact"]), "tolerance": 1e-2, "witness": "none"}
        raw["simulation"] |= {
            "method": "auto",
            "duration": 12 * math.pi / natural,
            "window": [0.0, 12 * math.pi / natural],
        }
    sideways = rng.random() < 0.3
    if sideways:
        _sideways(rng, raw)
    if rng.random() < 0.2:
        area = math.pi * radius**2 * rng.uniform(0.1, 2.0)
        raw["drag"] = {"heave": {"coefficient": rng.uniform(0.0, 2.0), "area": area}}
    raw["pto"] = _take_off(rng, raw["device"]["mass"], natural, damping, sideways)
    return yaml.safe_dump(raw)


def _sideways(rng: random.Random, raw: Raw) -> None:
    """Surge and pitch: an attitude, a mooring, modes to the sides; mostly about the vented sphere."""
    device, radius = raw["device"], raw["device"]["radius"]
    raw["motion"] = "planar"
    raw["modes"]["order"] = rng.choice([0, 1, 1, 2])
    device |= {"centre_of_mass": radius * rng.uniform(-0.7, 0.1), "ballast_inertia": 0.1 * device["mass"] * radius**2}
    if rng.random() < 0.5:
        weight = device["mass"] * 9.81 / radius
        raw["mooring"] = [
            weight * rng.choice([0.0, 0.01, 1.0]),
            0,
            0,
            0,
            weight * radius**2 * rng.choice([0.0, 0.1]),
            0,
        ]
    if rng.random() < 0.9:
        device["internal_pressure"], raw["reference_shape"] = 0.0, "undeformed"
        device.pop("gas", None)


def _take_off(rng: random.Random, mass: float, natural: float, damping: float, sideways: bool) -> Raw:
    """A port, a tuning, a law and limits, of which about half are the default."""

    def sometimes(value: Any) -> Any:
        """A value one time in four."""
        return value if rng.random() < 0.25 else None

    angle, weight = rng.uniform(0.0, 180.0), mass * 9.81
    ports: list[Any] = [
        "volume",
        {"colatitude": angle},
        {"colatitude": angle, "direction": "radial", "against": "frame"},
    ]
    ports += [{"between": [0, 180]}, {"between": [angle, 90]}, {"dof": "Heave"}]
    if sideways:
        ports += [*["surge", "pitch", {"line_to": [5.0, -50.0], "line_from": [0.0, -0.5]}] * 2]
    kept = {
        "damping": damping if rng.random() < 0.6 else None,
        "tuning": sometimes(rng.choice(["each", "one", "fixed"])),
        "stiffness": sometimes(mass * natural**2 * rng.uniform(-0.3, 1.0)),
        "efficiency": sometimes(rng.uniform(0.3, 1.0)),
        "port": rng.choice(ports) if rng.random() < 0.5 else None,
        "law": rng.choice(["saturated", "coulomb", "latching", "declutching"]) if rng.random() < 0.4 else None,
        "force_limit": weight * 10 ** rng.uniform(-4, 0) if rng.random() < 0.4 else None,
        "stroke_limit": sometimes(10 ** rng.uniform(-2, 1)),
    }
    return {key: value for key, value in kept.items() if value is not None}


# their fate ---------------------------------------------------------------------------------------------------------


def fate(text: str, folder: Path, run: bool = True) -> Outcome:
    """Return what becomes of a study, refused, completed or one of `BAD`: check it, run it if it passes, look at it."""
    path, checked = folder / "study.yaml", False
    path.write_text(text, encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            study = load(path)
            plan = StudyPlan(study, root=str(folder / "results"))
            preview.summary(plan)
            checked = True
            worst = run_stages(study, plan) if run else ""
        except Exception as error:
            return Outcome.of(error, "failed after check" if checked else "refused")
    return Outcome("not finite" if worst else "completed", worst)


def run_stages(study: Study, plan: StudyPlan) -> str:
    """Run a study in this process, without second solver, figures and report; return what is not finite, if anything.

    A second solver takes far longer than all the rest.
    """
    alone = study.model_copy(update={"hydro": study.hydro.model_copy(update={"witness": "none"})})
    plan = replace(plan, study=alone)
    make(plan, numbers(plan))
    return not_finite(Path(plan.folder))


def numbers(plan: StudyPlan) -> list[str]:
    """Return the products of a study that hold its numbers: no figures, page or meshes, which are made of them."""
    return [
        path for path in plan.products if "figures" not in Path(path).parts and not path.endswith((".html", ".vtu"))
    ]


def not_finite(folder: Path) -> str:
    """Return where results hold what is no number; nothing where they do not."""
    for path in sorted(folder.rglob("*.nc")):
        with xr.open_dataset(path) as ds:
            for name, values in ds.variables.items():
                if np.issubdtype(values.dtype, np.number) and not np.isfinite(values.values).all():
                    return f"{path.name}: {name}"
    for path in [*sorted(folder.glob("*.csv")), folder / "validity.json"]:
        cells = path.read_text(encoding="utf-8").replace("\n", ",").replace(": ", ",").lower().split(",")
        if {"nan", "inf", "-inf", "infinity"} & set(cells):
            return path.name
    return ""


def study_text(index: int) -> str:
    """Return the text of a study, always the same for an index: every other one broken, of the rest half equipped."""
    kind = broken if index % 2 == 0 else (odd, equipped)[index // 2 % 2]
    return kind(random.Random(index))


def fates(count: int) -> Iterator[tuple[tuple[int], Outcome]]:
    """Meet so many studies with their fate."""
    for index in range(count):
        with tempfile.TemporaryDirectory() as folder:
            yield (index,), fate(study_text(index), Path(folder))


def benchmark(count: int, out: str) -> Counter[str]:
    """Write what becomes of so many studies as a table; return how often each of `BAD` fell."""
    return tabulated(fates(count), ("index",), BAD, out)
