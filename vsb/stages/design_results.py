"""Rule design_results: the best flexible buoy beside the best rigid one, as tables, studies that run, and a report."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
import yaml
from matplotlib.figure import Figure

from vsb.design.budgets import LINEAR_THEORY, PowerParts, Uncertainty, power_parts, uncertainty, with_linear_theory
from vsb.design.compared import (
    COMPETITOR,
    FLEXIBLE,
    SHAPE_POINTS,
    TWIN,
    UNDEFORMED,
    Buoy,
    buoy_of,
    gain,
    twin,
    undeformed,
)
from vsb.design.evaluation import Evaluation, Quantity
from vsb.design.problem import IMPOSSIBLE, POWER, depends, excesses, limit_parts, probabilities, spread
from vsb.design.searched import Outcome, best
from vsb.engine.motion.take_off import named_ports, port_kind
from vsb.engine.waves.climate import Climate
from vsb.keys.quantities import Section
from vsb.models.viability import viability
from vsb.pipeline.plans import TABLES
from vsb.report.canvas import drawn
from vsb.report.design_answer import answer, no_answer, objective_text
from vsb.report.design_page import figure_of, render
from vsb.results.campaign import POWER as IN_TIME
from vsb.stages.check import read_climate
from vsb.stages.design import outcomes, points_of, under_limit
from vsb.stages.stage import Stamp
from vsb.study import figure_names
from vsb.study.design import DIVISORS, LIMITS, limit_of, unit_of
from vsb.study.feasible import OF_EVERY_BUOY
from vsb.study.specs import DesignSpec, Search
from vsb.study.study import Study
from vsb.study.vary import unit
from vsb.tools.files import load, save, write_text
from vsb.tools.stamps import record
from vsb.tools.words import csv_text, watts_within

Table = tuple[list[str], list[list[object]]]
"""Head and rows."""


def run_design_results(
    spec: DesignSpec,
    climate: str,
    starts: str,
    fronts: str,
    verifications: str,
    folder: str,
    manifest: str,
    stamp: Stamp,
) -> None:
    """Write what all starts together say."""
    seas = read_climate(spec.flexible.climate, climate)
    ends = {FLEXIBLE: outcomes(starts, spec.starts), COMPETITOR: outcomes(starts, spec.rigid_starts)}
    found = {name: best(some) for name, some in ends.items()}
    buoys = {name: buoy_of(name, search, found[name]) for name, search in _searches(spec).items()}
    for one in (twin(spec, seas, found[FLEXIBLE]), undeformed(spec, seas, found[FLEXIBLE])):
        buoys |= {one.name: one} if one else {}
    known = Known(spec, seas, {name: one.power for name, one in buoys.items()}, _runs(spec, verifications))
    curves = _fronts(spec, known, fronts)
    facts = {
        **_facts(spec, found, ends, buoys, known),
        **known.at_rest(buoys[FLEXIBLE]),
        "holds": {
            name: _holds(spec, search, found[name], buoys[name], seas) for name, search in _searches(spec).items()
        },
        "control": _control(buoys, seas),
        "held": {name: one.displacement_held for name, one in buoys.items() if one.study.pto.stiffness < 0},
        "fronts": curves,
        "verified": known.runs,
    }
    tables = {
        "starts.csv": starts_table(spec, ends, facts["starts"]),
        "pareto.csv": pareto_table(curves),
        "sensitivity.csv": sensitivity_table(spec, found),
        "budget.csv": budget_table(facts["budget"]),
        "power_budget.csv": power_budget_table(facts["powers"]),
    }
    for table, (head, rows) in tables.items():
        write_text(f"{folder}/{table}", csv_text(head, rows))
    for name, best_of in (("optimum", FLEXIBLE), ("competitor", COMPETITOR)):
        text = study_text(spec, buoys[best_of], name, facts["powers"][best_of], objective_text(facts, best_of))
        write_text(f"{folder}/{name}.yaml", text)
    said = {"answer": " ".join(answer(facts).stands), "valid": int(not no_answer(facts))}
    said["facts"] = json.dumps(facts, allow_nan=False)
    save(_dataset(buoys).assign_attrs(**said, **stamp), f"{folder}/design.nc")
    record(manifest, stamp["spec_id"], [f"{folder}/{name}" for name in TABLES if not name.endswith(".nc")])


def _runs(spec: DesignSpec, folder: str) -> dict[str, Any] | None:
    """What runs in time of both buoys say: of their gain, and of the year's mean power of each; None without any."""
    if not spec.verification:
        return None
    ds = load(Path(folder) / f"{spec.verification}.nc", expected=spec.verification)
    runs = dict(json.loads(ds.attrs["verified"]))
    if "failure" not in runs:
        runs["powers"] = {
            name: [float(ds[end].sel(design=search.design)) for end in IN_TIME[1:]]
            for name, search in _searches(spec).items()
        }
    return runs


@dataclass(frozen=True)
class Known:
    """What is known of the errors of powers and gains of a design problem."""

    spec: DesignSpec
    climate: Climate
    best: Mapping[str, float]  # power of the buoys compared by name [W]
    runs: Mapping[str, Any] | None
    _parts: dict[tuple[object, ...], PowerParts] = field(default_factory=dict)
    _rests: dict[tuple[object, ...], dict[str, str]] = field(default_factory=dict)

    def of_power(self, buoy: Buoy) -> Uncertainty:
        """Return what the power of a buoy is uncertain by [W]."""
        known = uncertainty([self._of(buoy)], self.spec.uncertain)
        runs = self._runs_of(buoy)
        return known if runs is None else with_linear_theory(known, buoy.power, *runs)

    def of_gain(self, flexible: Buoy, rigid: Buoy) -> Uncertainty:
        """Return what the gain of a buoy over another is uncertain by [percentage points]."""
        known = uncertainty([self._of(flexible), self._of(rigid)], self.spec.uncertain)
        if self.runs is None or None in (self._runs_of(flexible), self._runs_of(rigid)):
            return known
        return with_linear_theory(known, gain(flexible.power, rigid.power), self.runs["low"], self.runs["high"])

    def _runs_of(self, buoy: Buoy) -> Sequence[float] | None:
        """Ends of the power of a buoy by runs in time [W]; None of one that was not followed."""
        followed = self.runs is not None and buoy.power == self.best[buoy.name]
        return self.runs.get("powers", {}).get(buoy.name) if self.runs and followed else None

    def _of(self, buoy: Buoy) -> PowerParts:
        """The parts of a buoy's errors."""
        if (key := self._key(buoy)) not in self._parts:
            ordered = self.spec.flexible.climate.spectrum == "spectra"
            self._parts[key] = power_parts(buoy, self.climate, [*self.spec.uncertain], ordered=ordered)
        return replace(self._parts[key], truncation=buoy.truncation)

    def objectives(self, buoys: Mapping[str, Buoy]) -> dict[str, Any] | None:
        """Return what is maximised of both best buoys with intervals, and the gain in it [%]; None of power itself."""
        maximise = self.spec.flexible.maximise
        if maximise not in DIVISORS:
            return None
        parts = {
            name: power_parts(
                buoys[name], self.climate, [*self.spec.uncertain], maximise=maximise, cost=self.spec.flexible.cost
            )
            for name in (FLEXIBLE, COMPETITOR)
        }
        found = {name: _ends(one.power, uncertainty([one], self.spec.uncertain)) for name, one in parts.items()}
        pair = list(parts.values())
        over = _ends(gain(*(one.power for one in pair)), uncertainty(pair, self.spec.uncertain))
        divisor = unit_of(DIVISORS[maximise])
        return {"unit": "W" if divisor == "1" else f"W/{divisor}", "gain": over, **found}

    @staticmethod
    def _key(buoy: Buoy) -> tuple[object, ...]:
        """What starts that ended at the same buoy, to nine digits, share."""
        return (buoy.name, buoy.degree, buoy.truncation is None, *(f"{x:.9g}" for x in buoy.quantities.values()))

    def at_rest(self, buoy: Buoy) -> dict[str, str]:
        """Why a buoy is not viable, and what of it is doubted, in a basis that resolves buckling; "" if it is sound."""
        if (key := self._key(buoy)) not in self._rests:
            try:
                rest = viability(buoy.study)
                said = rest.reasons.get(buoy.design, ""), rest.doubts.get(buoy.design, "")
            except IMPOSSIBLE as error:
                said = str(error), ""
            self._rests[key] = dict(zip(("not_viable", "doubted"), said, strict=True))
        return self._rests[key]

    def power(self, buoy: Buoy) -> dict[str, Any]:
        """Return the power of a buoy with its interval [W] and its budget, as JSON."""
        return self._as_json(buoy.power, self.of_power(buoy), followed=self._runs_of(buoy) is not None)

    def gain(self, flexible: Buoy, rigid: Buoy) -> dict[str, Any]:
        """Return the gain of a buoy over another with its interval [%] and its budget, as JSON."""
        both = None not in (self._runs_of(flexible), self._runs_of(rigid))
        return self._as_json(gain(flexible.power, rigid.power), self.of_gain(flexible, rigid), followed=both)

    @staticmethod
    def _as_json(value: float, known: Uncertainty, *, followed: bool) -> dict[str, Any]:
        """A number with its interval, its budget, and what is not in it."""
        low, high = known.budget.interval(value)
        unknown = [*known.unknown, *([] if followed else [LINEAR_THEORY])]
        return {"value": value, "low": low, "high": high, "budget": known.budget.rows, "unknown": unknown}


def _ends(value: float, known: Uncertainty) -> list[float]:
    """A number with the ends of its interval."""
    return [value, *known.budget.interval(value)]


def _holds(spec: DesignSpec, search: Search, found: Outcome, buoy: Buoy, climate: Climate) -> dict[str, float]:
    """Probability that each limit holds of a buoy as built, and that `all` hold; none without uncertain inputs."""
    parts = limit_parts(search.kept)
    shares = {key: share for key, share in spec.uncertain.items() if depends(buoy.study, key)}
    margins = [found.margins.get(part, math.nan) for part in parts]
    if not shares or not parts or not np.isfinite(margins).all():
        return {}
    evaluation = Evaluation({name: Quantity(value, found.gradients[name]) for name, value in found.quantities.items()})
    excess = np.array([one.value for one in excesses(evaluation, search.kept)]) + margins
    scatter = spread(
        replace(buoy.model(climate), cost=search.cost, fatigue=search.fatigue),
        buoy.study,
        evaluation.damping,
        search.kept,
        shares,
    )
    return probabilities(excess, scatter, parts)


def _control(buoys: Mapping[str, Buoy], climate: Climate) -> dict[str, Any] | None:
    """What causal controllers know, and by buoy the power of other take-offs of the same rms force."""
    if buoys[FLEXIBLE].control is None:
        return None
    known, found = buoys[FLEXIBLE].study.pto.control, {}
    for name, one in buoys.items():
        levels = one.controlled(one.model(climate)).other_levels
        found[name] = {"damper_same_force": levels["damper_same_force"], "causal": one.power, **levels}
    return {"noise": known.noise, "forecast": known.forecast, "levels": found}


def _facts(
    spec: DesignSpec,
    found: Mapping[str, Outcome],
    ends: Mapping[str, Sequence[Outcome | str]],
    buoys: Mapping[str, Buoy],
    known: Known,
) -> dict[str, Any]:
    """All that a page says, as JSON."""
    of_gain = known.gain(buoys[FLEXIBLE], buoys[COMPETITOR])
    return {
        "name": spec.name,
        "study": spec.study,
        "climate": spec.climate_name,
        "maximise": spec.flexible.maximise,
        "limits": spec.flexible.limits,
        "sigmas": spec.flexible.sigmas,
        "notes": list(spec.notes),
        "designs": {FLEXIBLE: spec.flexible.design, COMPETITOR: spec.rigid.design},
        "power": {name: one.power for name, one in buoys.items()},
        "powers": {name: known.power(one) for name, one in buoys.items()},
        "quantities": {name: dict(one.quantities) for name, one in buoys.items()},
        "take_offs": {name: _take_off(one) for name, one in buoys.items()},
        "over": {name: known.gain(buoys[FLEXIBLE], one) for name, one in buoys.items() if name in (TWIN, UNDEFORMED)},
        "gain": {key: of_gain[key] for key in ("value", "low", "high")},
        "objectives": known.objectives(buoys),
        "budget": of_gain["budget"],
        "unknown": [name for name in of_gain["unknown"] if name != LINEAR_THEORY],
        "sensitivity": [dict(zip(SENSITIVITY, row, strict=True)) for row in sensitivity_table(spec, found)[1]],
        "found": {name: _found(search, found[name]) for name, search in _searches(spec).items()},
        "starts": {name: [_end(spec, known, name, one, buoys) for one in some] for name, some in ends.items()},
    }


def _take_off(one: Buoy) -> dict[str, Any]:
    """Where the take-off of a buoy acts, by which load, and its damper matrix by the names of several ports."""
    pto = one.study.pto
    port = pto.port.model_dump(exclude={"damping"}) if isinstance(pto.port, Section) else pto.port
    found = {"port": port, "kind": port_kind(pto.port).load}
    return found | ({"matrix": one.dampers, "ports": list(named_ports(pto))} if one.dampers else {})


def _searches(spec: DesignSpec) -> dict[str, Search]:
    """Searches by the buoy they find."""
    return {FLEXIBLE: spec.flexible, COMPETITOR: spec.rigid}


def _found(search: Search, one: Outcome) -> dict[str, Any]:
    """The best buoy of a search."""
    kind = port_kind(search.base["pto"].get("port", "heave"))
    return {
        "variables": [
            {
                "key": variable.key,
                "unit": unit(variable.key, kind),
                "value": one.point[variable.key],
                "low": variable.low,
                "high": variable.high,
            }
            for variable in search.variables
        ],
        "objective": one.objective,
        "multipliers": dict(one.multipliers),
        "kkt": one.kkt,
        "violation": one.violation,
        "flat": list(one.flat),
        "accepted": one.accepted,
        "message": one.message,
        "degree": one.degree,
        "truncation": one.truncation,
    }


def _end(spec: DesignSpec, known: Known, name: str, one: Outcome | str, buoys: Mapping[str, Buoy]) -> dict[str, Any]:
    """Where one start ended, in short."""
    if isinstance(one, str):
        return {"message": one, "accepted": False, "objective": None, "power": None, "evaluations": 0}
    buoy = buoy_of(name, _searches(spec)[name], one)
    return {
        "message": one.message,
        "accepted": one.accepted,
        "feasible": one.feasible,
        "objective": one.objective,
        "power": one.quantities[POWER],
        "within": known.power(buoy),
        "gain": known.gain(buoy, buoys[COMPETITOR]) if name == FLEXIBLE else None,
        "not_valid": known.at_rest(buoy)["not_viable"],
        "kkt": one.kkt,
        "violation": one.violation,
        "evaluations": one.evaluations,
    }


ENDS = ("power_low", "power_high", "gain", "low", "high", "not_in_interval", "valid")
"""Columns: interval of a power [W], gain over the rigid buoy with its own [%], what both leave out, and whether the
buoy rests in a stable shape."""


def ends_of(power: Mapping[str, Any], over: Mapping[str, Any] | None, not_valid: str) -> list[object]:
    """Return the cells of the columns `ENDS`."""
    of_gain = [over[key] for key in ("value", "low", "high")] if over else [""] * 3
    return [
        power["low"],
        power["high"],
        *of_gain,
        "; ".join(power["unknown"]),
        f"no: {not_valid}" if not_valid else "yes",
    ]


def starts_table(
    spec: DesignSpec, ends: Mapping[str, Sequence[Outcome | str]], said: Mapping[str, Sequence[Mapping[str, Any]]]
) -> Table:
    """Return the table of all starts: variables, objective, limits, multipliers, the certificate, and intervals."""
    keys = [one.key for one in spec.flexible.variables]
    known = [one for some in ends.values() for one in some if isinstance(one, Outcome)]
    limits = list(dict.fromkeys(name for one in known for name in one.quantities))
    held = list(dict.fromkeys(name for one in known for name in one.multipliers))
    head = [
        "buoy", "start", "accepted", "objective", *keys, *limits, *(f"multiplier {name}" for name in held), "kkt",
        "violation", "evaluations", "degree", "modes left out, low", "modes left out, high", "flat", "message", *ENDS,
    ]  # fmt: skip
    rows: list[list[object]] = []
    for name, some in ends.items():
        for i, one in enumerate(some):
            if isinstance(one, str):
                rows.append([name, i, "no", *[""] * (len(head) - 4 - len(ENDS)), one, *[""] * len(ENDS)])
                continue
            cells: list[object] = [name, i, "yes" if one.accepted else "no", one.objective]
            cells += [one.point.get(key, "") for key in keys]
            cells += [one.quantities.get(limit, "") for limit in limits]
            cells += [one.multipliers.get(limit, 0.0) for limit in held]
            cells += [
                significant(one.kkt, 2),
                significant(one.violation, 2),
                one.evaluations,
                "" if one.degree is None else one.degree,
            ]
            cells += [significant(end, 6) for end in one.truncation] if one.truncation else ["", ""]
            end = said[name][i]
            last = ends_of(end["within"], end["gain"], end["not_valid"])
            rows.append([*cells, "; ".join(one.flat), one.message, *last])
    return head, rows


FLAT = 1e-9
"""Relative slope up to which power does not change: what is left is round-off, and residual of an optimum."""
SENSITIVITY = ("buoy", "variable", "unit", "value", "per", "slope")


def sensitivity_table(spec: DesignSpec, found: Mapping[str, Outcome]) -> Table:
    """Return how annual mean power changes with each variable, limits left aside, and with each limit.

    d ln P / d ln variable, or d ln P / d (variable/range) where the variable may be 0 or negative; of a limit the
    relative gain of the objective per relative widening.
    """
    rows: list[list[object]] = []
    for name, search in _searches(spec).items():
        one = found[name]
        power, slopes = one.quantities[POWER], one.gradients[POWER]
        kind = port_kind(search.base["pto"].get("port", "heave"))
        for variable, value, slope in zip(search.variables, one.values, slopes, strict=True):
            per = "logarithm" if variable.low > 0 else "range"
            times = float(value) if per == "logarithm" else variable.high - variable.low
            relative = float(slope * times / power)
            shown_slope = relative if abs(relative) > FLAT else 0.0
            rows.append([name, variable.key, unit(variable.key, kind), float(value), per, shown_slope])
        for limit, value in one.multipliers.items():
            base = limit_of(limit)
            per = "limit" if base in LIMITS or base in OF_EVERY_BUOY or base == "spring_share" else "bound"
            given = search.limits.get(base, math.nan)
            shown: object = given if math.isfinite(given) else ""
            rows.append([name, limit, unit_of(base) if base in LIMITS else "1", shown, per, value])
    return list(SENSITIVITY), rows


def budget_table(rows: Sequence[Mapping[str, Any]]) -> Table:
    """Return what a number is uncertain by, in its unit, from the rows of its budget."""
    cells: list[list[object]] = [
        [
            one["name"], significant(one["low"], 6), significant(one["high"], 6),
            "yes" if (one["low"] == 0) != (one["high"] == 0) else "no",
            "yes" if one["shared"] else "no",
        ]
        for one in rows
    ]  # fmt: skip
    return ["source", "low", "high", "one_sided", "shared"], cells


def power_budget_table(powers: Mapping[str, Mapping[str, Any]]) -> Table:
    """Return what the powers of the buoys compared are uncertain by [W]."""
    rows: list[list[object]] = []
    for name, one in powers.items():
        head, cells = budget_table(one["budget"])
        rows += [[name, *row] for row in cells]
    return ["buoy", *head], rows


def significant(value: float, digits: int) -> float:
    """Return a number of some significant digits: those of errors and residuals beyond are round-off."""
    return float(f"{value:.{digits}g}")


def _fronts(spec: DesignSpec, known: Known, folder: str) -> dict[str, dict[str, list[dict[str, Any]]]]:
    """Pareto fronts by limit and buoy, each gain over the rigid buoy of the same limit if both are proven optima."""
    found: dict[str, dict[str, list[dict[str, Any]]]] = {}
    names = [(limit, name) for limit in spec.pareto for name in _searches(spec)]
    points = {
        which: points_of(load(Path(folder) / f"{front}.nc", expected=front))
        for which, front in zip(names, spec.fronts, strict=True)
    }
    for (limit, name), some in points.items():
        rigid = {
            value: buoy_of(COMPETITOR, under_limit(spec.rigid, limit, value), one)
            for value, one in points[limit, COMPETITOR]
            if name == FLEXIBLE and one.accepted
        }
        found.setdefault(limit, {})[name] = []
        for value, one in some:
            buoy = buoy_of(name, under_limit(_searches(spec)[name], limit, value), one)
            found[limit][name].append(
                {
                    "limit": value,
                    "objective": one.objective,
                    "accepted": one.accepted,
                    "message": one.message,
                    "kkt": one.kkt,
                    "violation": one.violation,
                    "quantities": dict(one.quantities),
                    "point": one.point,
                    "power": known.power(buoy),
                    "gain": known.gain(buoy, rigid[value]) if value in rigid and one.accepted else None,
                    "not_valid": known.at_rest(buoy)["not_viable"],
                }
            )
    return found


def pareto_table(curves: Mapping[str, Mapping[str, Sequence[Mapping[str, Any]]]]) -> Table:
    """Return the fronts as rows."""
    ends = [(limit, buoy, one) for limit, of in curves.items() for buoy, some in of.items() for one in some]
    keys = list(dict.fromkeys(key for _, _, one in ends for key in one["point"]))
    names = list(dict.fromkeys(name for _, _, one in ends for name in one["quantities"]))
    rows: list[list[object]] = [
        [
            limit, buoy, one["limit"], one["objective"], "yes" if one["accepted"] else "no", significant(one["kkt"], 2),
            *(one["point"].get(key, "") for key in keys), *(one["quantities"].get(name, "") for name in names),
            *ends_of(one["power"], one["gain"], one["not_valid"]),
        ]
        for limit, buoy, one in ends
    ]  # fmt: skip
    return ["limit", "buoy", "value", "objective", "accepted", "kkt", *keys, *names, *ENDS], rows


def study_text(spec: DesignSpec, one: Buoy, name: str, power: Mapping[str, Any], maximised: str = "") -> str:
    """Return a study of a buoy that runs: its values, its damper, the seas and runs of the study it is from.

    Above it stand its power and, if that is not what was `maximised`, what was.
    """
    study = written_study(spec, one, name)
    raw = json.loads(json.dumps(study.model_dump(exclude_none=True, exclude_defaults=True)))
    (words,), unit = watts_within([(power["value"], power["low"], power["high"])])
    kind = "flexible buoy" if one.name == FLEXIBLE else one.name
    about = f"# The best {kind} of design {spec.name}: {words} {unit}, mean over the year of {spec.climate_name}.\n"
    about += f"# Maximised: {maximised}.\n" if maximised else ""
    if one.name == COMPETITOR:
        about += "# A rigid buoy is one of its size and mass: the wall given here has no mass and bounds nothing.\n"
    return about + yaml.safe_dump(raw, sort_keys=False, allow_unicode=True)


def written_study(spec: DesignSpec, one: Buoy, name: str) -> Study:
    """Return the study of a buoy in the seas of the study it is from."""
    raw = one.with_damper().study.model_dump(exclude_none=True)
    return Study(**raw | {"study": f"{spec.name}_{name}", **spec.runs})


def _dataset(buoys: Mapping[str, Buoy]) -> xr.Dataset:
    """Hulls at rest and quantities of the buoys compared."""
    names = [key for key in buoys[COMPETITOR].quantities if all(key in one.quantities for one in buoys.values())]
    outlines = np.array([one.outline for one in buoys.values()])
    return xr.Dataset(
        {
            "outline_x": (("buoy", "colatitude"), outlines[:, 0]),
            "outline_z": (("buoy", "colatitude"), outlines[:, 1]),
            "buoy_value": (("buoy", "quantity"), [[one.quantities[key] for key in names] for one in buoys.values()]),
        },
        coords={"buoy": list(buoys), "quantity": names, "colatitude": np.linspace(0.0, np.pi, SHAPE_POINTS)},
    )


# figures and report ---------------------------------------------------------------------------------------------------


def run_design_report(spec: DesignSpec, data: str, figures: str, out: str, manifest: str, stamp: Stamp) -> None:
    """Draw the figures of a design problem and write its report."""
    identity = stamp["spec_id"]
    ds = load(data, expected=identity)
    facts = json.loads(ds.attrs["facts"])
    with mpl.rc_context():  # the caller's own figures keep their looks
        every = {name: drawn(figure, name) for name, figure in figures_of(spec, ds)}
    files = [path for name, one in every.items() for path in one.write(figures, name)]
    write_text(out, render(facts, {name: one.svg for name, one in every.items()}, identity))
    record(manifest, identity, [out, *files])


def figures_of(spec: DesignSpec, ds: xr.Dataset) -> Iterator[tuple[str, Figure]]:
    """Draw the figures of a design problem by name."""
    facts = json.loads(ds.attrs["facts"])
    yield from ((name, figure_of(name, facts, ds)) for name in figure_names.of_design(spec))
