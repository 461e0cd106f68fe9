"""Rule design_results: the best flexible buoy beside the best rigid one, as tables and as studies that run."""

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import yaml

from vsb.design.compared import (
    COMPETITOR,
    FLEXIBLE,
    SHAPE_POINTS,
    Buoy,
    Uncertainty,
    buoy_of,
    gain,
    sphere,
    twin,
    uncertainty,
)
from vsb.design.problem import POWER
from vsb.design.searched import Outcome, best
from vsb.report.design_answer import answer, no_answer
from vsb.results.budget import Budget, Source
from vsb.scenes.viability import viability
from vsb.stages.climate import read_climate
from vsb.stages.design import outcomes
from vsb.study.design import Limits, limit_of, unit_of
from vsb.study.design_plan import TABLES
from vsb.study.quantities import canonical, content_id
from vsb.study.specs import DesignSpec, Search
from vsb.study.study import Study
from vsb.study.vary import unit
from vsb.tools.files import load, save, write_text
from vsb.tools.stamps import record
from vsb.tools.tables import csv_text

LINEAR_THEORY = "linear theory"
Table = tuple[list[str], list[list[object]]]
"""Head and rows."""


def run_design_results(
    spec: DesignSpec, climate: str, starts: str, fronts: str, verifications: str, folder: str, manifest: str
) -> None:
    """Write what all starts together say."""
    seas, identity = read_climate(spec.flexible.climate, climate), content_id(spec)
    ends = {FLEXIBLE: outcomes(starts, spec.starts), COMPETITOR: outcomes(starts, spec.rigid_starts)}
    found = {name: best(some) for name, some in ends.items()}
    buoys = {
        FLEXIBLE: buoy_of(FLEXIBLE, spec.flexible, found[FLEXIBLE]),
        COMPETITOR: buoy_of(COMPETITOR, spec.rigid, found[COMPETITOR]),
    }
    for one in (twin(spec, seas, found[FLEXIBLE]), sphere(spec, seas, found[FLEXIBLE])):
        buoys |= {one.name: one} if one else {}
    verified = None
    if spec.verification:
        verified = load(Path(verifications) / f"{spec.verification}.nc", expected=spec.verification)
    doubts = uncertainty(spec, seas, buoys[FLEXIBLE], buoys[COMPETITOR], found[FLEXIBLE].truncation)
    value = gain(buoys[FLEXIBLE].power, buoys[COMPETITOR].power)
    runs = None if verified is None else dict(json.loads(verified.attrs["verified"]))
    if runs and "failure" not in runs:
        doubts = _with_linear_theory(doubts, value, runs)
    curves = _fronts(spec, fronts)
    facts = {
        **_facts(spec, found, ends, buoys, doubts),
        **_at_rest(buoys[FLEXIBLE]),
        "held": {name: one.displacement_held for name, one in buoys.items() if one.study.pto.stiffness < 0},
        "fronts": curves,
        "verified": runs,
    }
    tables = {
        "starts.csv": starts_table(spec, ends),
        "pareto.csv": pareto_table(curves),
        "sensitivity.csv": sensitivity_table(spec, found),
        "budget.csv": budget_table(doubts.budget),
    }
    for name, (head, rows) in tables.items():
        write_text(f"{folder}/{name}", csv_text(head, rows))
    for name, one in (("optimum", buoys[FLEXIBLE]), ("competitor", buoys[COMPETITOR])):
        write_text(f"{folder}/{name}.yaml", study_text(spec, one, name))
    said = {"answer": " ".join(answer(facts).stands), "valid": int(not no_answer(facts))}
    said["facts"] = json.dumps(facts, allow_nan=False)
    stamps = {"spec": canonical(spec), "spec_id": identity}
    save(_dataset(buoys).assign_attrs(**said, **stamps), f"{folder}/design.nc")
    record(manifest, identity, [f"{folder}/{name}" for name in TABLES if not name.endswith(".nc")])


def _with_linear_theory(doubts: Uncertainty, value: float, runs: Mapping[str, float]) -> Uncertainty:
    """What linear theory errs by, as runs in time of both buoys in the same seas say: their interval of the gain."""
    source = Source(LINEAR_THEORY, min(0.0, runs["low"] - value), max(0.0, runs["high"] - value))
    return Uncertainty(doubts.budget + Budget((source,)), doubts.unknown)


def _at_rest(buoy: Buoy) -> dict[str, str]:
    """Why a buoy is not viable, and what of it is doubted, in a basis that resolves buckling; "" where it is sound."""
    rest = viability(buoy.study)
    return {"not_viable": rest.reasons.get(buoy.design, ""), "doubted": rest.doubts.get(buoy.design, "")}


def _facts(
    spec: DesignSpec,
    found: Mapping[str, Outcome],
    ends: Mapping[str, Sequence[Outcome | str]],
    buoys: Mapping[str, Buoy],
    doubts: Uncertainty,
) -> dict[str, Any]:
    """All that a page says, as JSON."""
    power = {name: one.power for name, one in buoys.items()}
    value = gain(power[FLEXIBLE], power[COMPETITOR])
    low, high = doubts.budget.interval(value)
    return {
        "name": spec.name,
        "study": spec.study,
        "climate": spec.climate_name,
        "maximise": spec.flexible.maximise,
        "limits": spec.flexible.limits,
        "notes": list(spec.notes),
        "designs": {FLEXIBLE: spec.flexible.design, COMPETITOR: spec.rigid.design},
        "power": power,
        "quantities": {name: dict(one.quantities) for name, one in buoys.items()},
        "gain": {"value": value, "low": low, "high": high},
        "budget": doubts.budget.rows,
        "unknown": list(doubts.unknown),
        "sensitivity": [dict(zip(SENSITIVITY, row, strict=True)) for row in sensitivity_table(spec, found)[1]],
        "found": {name: _found(search, found[name]) for name, search in _searches(spec).items()},
        "starts": {name: [_end(one) for one in some] for name, some in ends.items()},
    }


def _searches(spec: DesignSpec) -> dict[str, Search]:
    """Searches by the buoy they find."""
    return {FLEXIBLE: spec.flexible, COMPETITOR: spec.rigid}


def _found(search: Search, one: Outcome) -> dict[str, Any]:
    """The best buoy of a search."""
    return {
        "variables": [
            {
                "key": variable.key,
                "unit": unit(variable.key),
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


def _end(one: Outcome | str) -> dict[str, Any]:
    """Where one start ended, in short."""
    if isinstance(one, str):
        return {"message": one, "accepted": False, "objective": None, "power": None, "evaluations": 0}
    return {
        "message": one.message,
        "accepted": one.accepted,
        "feasible": one.feasible,
        "objective": one.objective,
        "power": one.quantities[POWER],
        "kkt": one.kkt,
        "violation": one.violation,
        "evaluations": one.evaluations,
    }


def starts_table(spec: DesignSpec, ends: Mapping[str, Sequence[Outcome | str]]) -> Table:
    """Return the table of all starts: variables, objective, limits, multipliers, and the certificate."""
    keys = [one.key for one in spec.flexible.variables]
    known = [one for some in ends.values() for one in some if isinstance(one, Outcome)]
    limits = list(dict.fromkeys(name for one in known for name in one.quantities))
    held = list(dict.fromkeys(name for one in known for name in one.multipliers))
    head = [
        "buoy", "start", "accepted", "objective", *keys, *limits, *(f"multiplier {name}" for name in held), "kkt",
        "violation", "evaluations", "degree", "modes left out, low", "modes left out, high", "flat", "message",
    ]  # fmt: skip
    rows: list[list[object]] = []
    for name, some in ends.items():
        for i, one in enumerate(some):
            if isinstance(one, str):
                rows.append([name, i, "no", *[""] * (len(head) - 4), one])
                continue
            cells: list[object] = [name, i, "yes" if one.accepted else "no", one.objective]
            cells += [one.point.get(key, "") for key in keys]
            cells += [one.quantities.get(limit, "") for limit in limits]
            cells += [one.multipliers.get(limit, 0.0) for limit in held]
            cells += [one.kkt, one.violation, one.evaluations, "" if one.degree is None else one.degree]
            cells += one.truncation or ("", "")
            rows.append([*cells, "; ".join(one.flat), one.message])
    return head, rows


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
        for variable, value, slope in zip(search.variables, one.values, slopes, strict=True):
            per = "logarithm" if variable.low > 0 else "range"
            times = float(value) if per == "logarithm" else variable.high - variable.low
            rows.append([name, variable.key, unit(variable.key), float(value), per, float(slope * times / power)])
        for limit, value in one.multipliers.items():
            base = limit_of(limit)
            per = "limit" if base in Limits.model_fields or base == "thin_shell" else "bound"
            given = search.limits.get(base, math.nan)
            shown: object = given if math.isfinite(given) else ""
            rows.append([name, limit, unit_of(base) if base in Limits.model_fields else "1", shown, per, value])
    return list(SENSITIVITY), rows


def budget_table(budget: Budget) -> Table:
    """Return what the gain is uncertain by, in percentage points."""
    rows: list[list[object]] = [
        [one.name, one.low, one.high, "yes" if 0.0 in (one.low, one.high) else "no", "yes" if one.shared else "no"]
        for one in budget.sources
    ]
    return ["source", "low", "high", "one_sided", "shared"], rows


def _fronts(spec: DesignSpec, folder: str) -> dict[str, dict[str, list[dict[str, Any]]]]:
    """Pareto fronts by limit and buoy."""
    found: dict[str, dict[str, list[dict[str, Any]]]] = {}
    names = [(limit, buoy) for limit in spec.pareto for buoy in (FLEXIBLE, COMPETITOR)]
    for (limit, buoy), front in zip(names, spec.fronts, strict=True):
        ds = load(Path(folder) / f"{front}.nc", expected=front)
        found.setdefault(limit, {})[buoy] = [
            {
                "limit": float(one.limit_value),
                "objective": float(one.objective),
                "accepted": bool(one.accepted),
                "kkt": float(one.kkt),
                "violation": float(one.violation),
                "quantities": dict(zip(map(str, ds["quantity"].values), map(float, one.quantity_value), strict=True)),
                "point": dict(zip(map(str, ds["variable"].values), map(float, one.best_value), strict=True)),
            }
            for one in (ds.isel(limit_value=i) for i in range(ds.sizes["limit_value"]))
        ]
    return found


def pareto_table(curves: Mapping[str, Mapping[str, Sequence[Mapping[str, Any]]]]) -> Table:
    """Return the fronts as rows."""
    ends = [(limit, buoy, one) for limit, of in curves.items() for buoy, some in of.items() for one in some]
    keys = list(dict.fromkeys(key for _, _, one in ends for key in one["point"]))
    names = list(dict.fromkeys(name for _, _, one in ends for name in one["quantities"]))
    rows: list[list[object]] = [
        [
            limit, buoy, one["limit"], one["objective"], "yes" if one["accepted"] else "no", one["kkt"],
            *(one["point"].get(key, "") for key in keys), *(one["quantities"].get(name, "") for name in names),
        ]
        for limit, buoy, one in ends
    ]  # fmt: skip
    return ["limit", "buoy", "value", "objective", "accepted", "kkt", *keys, *names], rows


def study_text(spec: DesignSpec, one: Buoy, name: str) -> str:
    """Return a study of a buoy that runs: its values, its damper, the seas and runs of the study it is from."""
    study = written_study(spec, one, name)
    raw = json.loads(json.dumps(study.model_dump(exclude_none=True, exclude_defaults=True)))
    about = f"# The {one.name} of design {spec.name}: {one.power:.6g} W, mean over the year of {spec.climate_name}.\n"
    return about + yaml.safe_dump(raw, sort_keys=False, allow_unicode=True)


def written_study(spec: DesignSpec, one: Buoy, name: str) -> Study:
    """Return the study of a buoy in the seas of the study it is from."""
    raw = one.with_damper().study.model_dump(exclude_none=True)
    return Study(**raw | {"study": f"{spec.name}_{name}", **spec.runs})


def _dataset(buoys: Mapping[str, Buoy]) -> xr.Dataset:
    """Hulls at rest and quantities of the buoys compared."""
    names = list(buoys[COMPETITOR].quantities)
    outlines = np.array([one.outline for one in buoys.values()])
    return xr.Dataset(
        {
            "outline_x": (("buoy", "colatitude"), outlines[:, 0]),
            "outline_z": (("buoy", "colatitude"), outlines[:, 1]),
            "buoy_value": (("buoy", "quantity"), [[one.quantities[key] for key in names] for one in buoys.values()]),
        },
        coords={"buoy": list(buoys), "quantity": names, "colatitude": np.linspace(0.0, np.pi, SHAPE_POINTS)},
    )
