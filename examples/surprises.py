"""Surprises of the fair comparison: the studies and figures of docs/surprises.md.

    python -m examples.surprises results/surprises

prints the figures of every case; some of them by name:

    python -m examples.surprises results/surprises drag negative_spring
"""

import argparse
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from examples import command
from examples.paper_at_optimal_damping import rows_of
from vsb.errors import ConfigError
from vsb.models.build import linear_design
from vsb.models.floating_system import floating_system
from vsb.pipeline.graph import StudyPlan
from vsb.results.ladder import ControlLevel, study_ladder
from vsb.stages.make import hydro_files
from vsb.study.study import Study, load, parse

Figures = dict[str, float]
RIGID, FLEXIBLE = "FSB", "VSWEC"
BASE: dict[str, Any] = {
    "designs": {RIGID: {"flexible": False}, FLEXIBLE: {}},
    "hydro": {"model": "linear", "tolerance": 1e-3, "omega_max": 8.0, "witness": "none"},
    "pto": {"damping": None, "tuning": "each"},
    "modes": {"basis": "full", "degree": 14},
    "published": None,
}
"""Changes to the example in all cases: two designs, no damper given, modes converged for softer shells, too."""
NOTHING = 1e-6
"""Smaller figures are printed as zero."""


def regular(period: float, amplitude: float = 0.1) -> dict[str, Any]:
    """A regular wave."""
    return {"kind": "regular", "amplitude": amplitude, "period": period}


def jonswap(tp: float, hs: float = 0.3) -> dict[str, Any]:
    """A JONSWAP sea."""
    return {"kind": "jonswap", "hs": hs, "tp": tp, "seed": 1}


def study_of(waves: Sequence[Mapping[str, Any]], **changes: Any) -> Study:
    """Return the example with the changes of a case."""
    raw = load("config/buoy.yaml").model_dump()
    for section, update in {**BASE, **changes, "waves": list(waves)}.items():
        merged = isinstance(update, dict) and isinstance(raw.get(section), dict) and section not in ("designs", "pto")
        raw[section] = {**raw[section], **update} if merged else update
    return parse(raw)


class Ladder:
    """Control levels of a study, by design, sea and name of the level."""

    def __init__(self, study: Study, folder: Path) -> None:
        """Compute all levels."""
        self.waves = [wave.label for wave in study.waves]
        found = study_ladder(StudyPlan(study).ladder.spec["study"], hydro_files(study, folder)["database"])
        self.levels = {(level.design, level.wave, level.rung): level for level in found}

    def at(self, design: str, level: str, wave: int = 0) -> ControlLevel:
        """Return a control level in a sea."""
        return self.levels[design, self.waves[wave], level]

    def power(self, design: str, level: str, wave: int = 0) -> float:
        """Return its mean power [W]."""
        return self.at(design, level, wave).power_mean or 0.0

    def gain(self, level: str, wave: int = 0) -> float:
        """Return the gain of the flexible over the rigid design [%]."""
        return 100 * (self.power(FLEXIBLE, level, wave) / self.power(RIGID, level, wave) - 1)

    def reactance_ratio(self, design: str, wave: int = 0) -> float:
        """Return Q = |X|/R in a regular wave, from P(best damper)/P(limit) = 2/(1 + sqrt(1 + Q^2))."""
        share = self.at(design, "best_damper", wave).limit_fraction or 0.0
        return float(np.sqrt((2 / share - 1) ** 2 - 1))


def one_damper(folder: Path) -> Figures:
    """A damper far from both optima makes the shell look better."""
    found = Ladder(study_of([regular(4.0)], pto={"damping": 8000.0}), folder)
    shares = {d: 100 * found.power(d, "fixed") / found.power(d, "best_damper") for d in (RIGID, FLEXIBLE)}
    return {
        "gain at 8000 N s/m [%]": found.gain("fixed"),
        "gain at optimal damping [%]": found.gain("best_damper"),
        "rigid buoy: optimal damping [N s/m]": found.at(RIGID, "best_damper").damping or 0.0,
        "flexible buoy: optimal damping [N s/m]": found.at(FLEXIBLE, "best_damper").damping or 0.0,
        "rigid buoy: power at 8000 N s/m over its optimum [%]": shares[RIGID],
        "flexible buoy: power at 8000 N s/m over its optimum [%]": shares[FLEXIBLE],
    }


def narrow_band(folder: Path) -> Figures:
    """At optimal damping the shell gains where it lowers Q, and nowhere else."""
    periods = (2.5, 3.06, 5.0)
    return gain_beside_q(Ladder(study_of([regular(period) for period in periods]), folder), periods)


def gain_beside_q(found: Ladder, periods: Sequence[float]) -> Figures:
    """Return the gain at optimal damping and Q of both designs in regular waves of some periods."""
    figures = {}
    for i, period in enumerate(periods):
        figures[f"gain at {period:g} s [%]"] = found.gain("best_damper", i)
        for name, design in (("rigid", RIGID), ("flexible", FLEXIBLE)):
            figures[f"Q at {period:g} s, {name}"] = found.reactance_ratio(design, i)
    return figures


def same_limit(folder: Path) -> Figures:
    """The limit with ideal control does not depend on the shell."""
    figures, young = {}, load("config/buoy.yaml").device.young_modulus
    for factor in (0.25, 1.0, 100.0):
        found = Ladder(study_of([regular(3.06)], device={"young_modulus": factor * young}), folder)
        figures[f"matched gain, Young's modulus times {factor:g} [%]"] = found.gain("matched")
        figures[f"gain at optimal damping, Young's modulus times {factor:g} [%]"] = found.gain("best_damper")
    return figures


def port_within(folder: Path) -> Figures:
    """A take-off between the poles: nothing from a rigid buoy; from a shell, in theory, as much as from heave."""
    found = Ladder(study_of([regular(3.06)], pto={"port": {"between": (0.0, 180.0)}}, modes={"degree": 60}), folder)
    heave = Ladder(study_of([regular(3.06)]), folder)
    return {
        "rigid, optimal damper [W]": found.power(RIGID, "best_damper"),
        "flexible, optimal damper [W]": found.power(FLEXIBLE, "best_damper"),
        "flexible, matched [W]": found.power(FLEXIBLE, "matched"),
        "flexible, matched on heave [W]": heave.power(FLEXIBLE, "matched"),
        "Q, flexible": found.reactance_ratio(FLEXIBLE),
        "Q on heave, flexible": heave.reactance_ratio(FLEXIBLE),
    }


def one_for_all(folder: Path) -> Figures:
    """One damper for seas of 3 to 8 s, whose optimal dampers differ by a factor of seven."""
    found = Ladder(study_of([jonswap(tp) for tp in (3.0, 4.0, 5.0, 6.0, 8.0)]), folder)
    figures = {}
    for name, design in (("rigid", RIGID), ("flexible", FLEXIBLE)):
        each, one = (
            np.array([found.power(design, level, i) for i in range(len(found.waves))])
            for level in ("best_damper", "best_damper_all_seas")
        )
        dampers = [found.at(design, "best_damper", i).damping or 0.0 for i in range(len(found.waves))]
        figures[f"{name}, largest optimal damper over the smallest"] = max(dampers) / min(dampers)
        figures[f"{name}, lost with one damper, all seas [%]"] = 100 * (1 - one.sum() / each.sum())
        figures[f"{name}, lost with one damper, worst sea [%]"] = 100 * float((1 - one / each).max())
    return figures


def negative_spring(folder: Path) -> Figures:
    """In long waves the optimal spring is negative."""
    study = study_of([jonswap(3.0), jonswap(8.0)])
    found, stiffness = Ladder(study, folder), study.water.density * study.water.gravity * np.pi * study.device.radius**2
    figures = {}
    for i, tp in enumerate((3, 8)):
        pair = found.at(RIGID, "best_spring_damper", i)
        figures[f"Tp {tp} s: optimal spring over waterplane stiffness [%]"] = 100 * (pair.stiffness or 0.0) / stiffness
        figures[f"Tp {tp} s: power over that of the optimal damper"] = (pair.power_mean or 0.0) / found.power(
            RIGID, "best_damper", i
        )
    return figures


def limit_that_costs_nothing(folder: Path) -> Figures:
    """A force limit above the peak of the matched force costs nothing, half of it little."""
    matched = Ladder(study_of([jonswap(5.0)]), folder).at(RIGID, "matched")
    peak, figures = matched.force_peak or 0.0, {"matched power [W]": matched.power_mean or 0.0}
    for share in (1.05, 0.5, 0.1):
        found = Ladder(study_of([jonswap(5.0)], pto={**BASE["pto"], "force_limit": share * peak}), folder)
        kept = found.at(RIGID, "constrained").limit_fraction or 0.0  # of the matched power in the waves of one period
        figures[f"limit {share:g} of the matched peak: power lost [%]"] = 100 * (1 - kept)
    return figures


def scarce_force(folder: Path) -> Figures:
    """With a tenth of the optimal damper's force the shell gains where with the damper it lost."""
    free = Ladder(study_of([jonswap(4.0)]), folder)
    limit = 0.1 * (free.at(RIGID, "best_damper").force_rms or 0.0)
    study = study_of([jonswap(4.0)], pto={**BASE["pto"], "force_limit": limit})
    found, free_speed = Ladder(study, folder), free_velocity(study, folder)
    return {
        "gain at optimal damping [%]": free.gain("best_damper"),
        "gain with ideal control, no limits [%]": free.gain("matched"),
        "gain at a tenth of the force [%]": found.gain("constrained"),
        "force limit [N]": limit,
        "gain in free velocity, rms [%]": 100 * (free_speed[FLEXIBLE] / free_speed[RIGID] - 1),
    }


def free_velocity(study: Study, folder: Path) -> dict[str, float]:
    """Return the rms velocity of heave in the first sea without a take-off, by design [m/s]."""
    floating = floating_system(study, hydro_files(study, folder)["database"])
    waves = study.waves[0].realisation(study.hydro.omega_max, study.simulation.duration)
    seen = {name: floating.extended_port(name, waves.omega) for name in study.designs}
    return {name: float(np.linalg.norm(port.velocity * waves.amplitude) / np.sqrt(2)) for name, port in seen.items()}


def drag(folder: Path) -> Figures:
    """Drag costs a damper little, a spring and damper much."""
    seas, figures = [regular(4.0, 0.5)], {}
    without = Ladder(study_of(seas), folder)
    braked = Ladder(study_of(seas, drag={"heave": {"coefficient": 1.0, "area": 12.57}}), folder)
    for name, level in (("optimal damper", "best_damper"), ("optimal spring and damper", "best_spring_damper")):
        for kind, design in (("rigid", RIGID), ("flexible", FLEXIBLE)):
            lost = 100 * (1 - braked.power(design, level) / without.power(design, level))
            figures[f"{kind}: loss with {name} [%]"] = lost
    return figures


def latching(folder: Path) -> Figures:
    """The optimal damper is far too large for latching."""
    wave, figures = regular(5.0), {}
    best = Ladder(study_of([wave]), folder)
    heavy = best.at(RIGID, "best_damper").damping or 0.0
    figures["optimal damper [N s/m]"], figures["its power [W]"] = heavy, best.power(RIGID, "best_damper")
    for name, damping in (("the optimal damper", heavy), ("a fifth of it", heavy / 5)):
        study = study_of([wave], pto={"damping": damping, "law": "latching"}, designs={RIGID: {"flexible": False}})
        notes = linear_design(
            StudyPlan(study).simulation(RIGID, study.waves[0]).spec["run"], hydro_files(study, folder)
        ).notes
        figures[f"latching with {name} [W]"] = notes["latching_power"]
    figures["matched [W]"] = best.power(RIGID, "matched")
    return figures


def the_paper(_: Path) -> Figures:
    """The published +57 % at optimal damping, in the paper's own loading."""
    figures = {}
    for name in ("paper_inferred", "paper"):
        study = load(f"config/{name}.yaml")
        rows = {row.design: row for row in rows_of(study)}
        figures[f"{name}: gain at the one damper [%]"] = rows[FLEXIBLE].gain_percent
        figures[f"{name}: gain at optimal damping [%]"] = rows[FLEXIBLE].best_gain_percent
    return figures


CASES: Mapping[str, Callable[[Path], Figures]] = {
    case.__name__: case
    for case in (
        one_damper, narrow_band, same_limit, port_within, one_for_all, negative_spring, limit_that_costs_nothing,
        scarce_force, drag, latching, the_paper,
    )
}  # fmt: skip
"""By name."""


def table(name: str, figures: Figures) -> str:
    """Return the figures of a case as the page has them."""
    lines = [
        f"| `{name}` | |",
        "|---|---|",
        *(f"| {key} | {value if abs(value) > NOTHING else 0.0:.4g} |" for key, value in figures.items()),
    ]
    return "\n".join(lines) + "\n"


def chosen(names: Sequence[str], known: Iterable[str]) -> list[str]:
    """Return the names of cases, of all if none is given; `ConfigError` if one is unknown."""
    if unknown := set(names) - set(known):
        raise ConfigError(f"case: received {', '.join(sorted(unknown))}, needs some of {', '.join(known)}")
    return list(names or known)


def run(args: argparse.Namespace) -> int:
    """Print the figures of some cases, or of all."""
    for name in chosen(args.cases, CASES):
        print(table(name, CASES[name](Path(args.folder))), flush=True)
    return 0


main = command("surprises", __doc__, run, "{folder}/", folder="FOLDER", cases="CASE...")

if __name__ == "__main__":
    sys.exit(main(None))
