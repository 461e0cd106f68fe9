"""The plan of a file: its shell modes converged before anything else is planned, for their degree stands in every id.

A degree is looked for once: a run keeps it under `hydro/degrees` of the results, by all that it follows from. What only
looks, as `vsb check` does, writes nothing.
"""

import contextlib
import hashlib
import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, overload

from vsb.errors import ConfigError, ConvergenceError
from vsb.study import plans
from vsb.study.campaign import study_at
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.design_plan import DesignPlan
from vsb.study.plan import BodyPlan, StudyPlan, degree_path
from vsb.study.plans import Plan
from vsb.study.quantities import canonical, content_id
from vsb.study.sections import DEGREES
from vsb.study.specs import DegreeSpec
from vsb.study.study import Study
from vsb.study.unlikely import units_doubted
from vsb.study.vary import Point


def plan_of(path: str, *, keep: bool = True) -> Plan:
    """Return the plan of a study file, of a buoy or of a body, or of a campaign file; see `with_degree`."""
    return with_degree(plans.plan_of(path), keep=keep)


def planned(raw: dict[str, Any], source: str) -> Plan:
    """Return the plan of a file as nested mappings, its results folder, if not `results`, as `root`."""
    return with_degree(plans.planned(raw, source))


@overload
def with_degree(plan: StudyPlan, *, keep: bool = True) -> StudyPlan: ...
@overload
def with_degree(plan: StudyPlan | BodyPlan, *, keep: bool = True) -> StudyPlan | BodyPlan: ...
@overload
def with_degree(plan: Plan, *, keep: bool = True) -> Plan: ...
def with_degree(plan: Plan, *, keep: bool = True) -> Plan:
    """Return a plan whose shell modes have a degree: the one given, or the least that meets `modes.tolerance`.

    Of a campaign it is the largest of those of its study and of the points with the least and the largest value of each
    key. The degree found is kept in the folder of results, unless `keep` is false. Raises `ConfigError` if the shell of
    a study does not carry its load, so that it has no modes about its equilibrium.
    """
    if isinstance(plan, BodyPlan | DesignPlan):  # an optimum has modes of its own
        return plan
    if isinstance(plan, StudyPlan):
        if plan.study.modes.degree is not None:
            return plan
        with units_doubted(plan.study), load_advised(plan.study):
            return StudyPlan(_with(plan.study, degree_needed(plan, keep=keep).degree), root=plan.root)
    if (base := plan.loaded.base.buoy) is None:
        return plan
    if base.modes.degree is not None or "modes.degree" in plan.loaded.campaign.vary.keys:
        return plan
    return CampaignPlan(
        plan.loaded.model_copy(update={"base": _with(base, degree_needed(plan, keep=keep).degree)}), root=plan.root
    )


@contextlib.contextmanager
def load_advised(study: Study) -> Iterator[None]:
    """Say in an error of a shell that does not carry its load what would carry it, tried now."""
    try:
        yield
    except ConfigError as error:
        from vsb.scenes.load_advice import advised  # only now: it imports what solves

        raise advised(study, error) from None


class Needed(NamedTuple):
    """Least degree of the full basis that meets `modes.tolerance`, or the highest there is."""

    degree: int
    met: bool  # whether the tolerance is met with it


def degree_needed(plan: StudyPlan | CampaignPlan, *, keep: bool = True) -> Needed:
    """Return the least degree of the full basis that meets `modes.tolerance`, whatever degree is given.

    Raises `ConfigError` if the shell of a study does not carry its load, so that it has no modes about its equilibrium.
    """
    if isinstance(plan, StudyPlan):
        search = _search(plan.degree, plan.root, keep=keep)
        return Needed(search.degree, search.met)
    studies = [study_at(plan.base, point) for point in extremes(plan.loaded.campaign.vary.points)]
    specs = [StudyPlan(study).degree.model_copy(update={"climate": plan.climate}) for study in studies]
    found = [NONE_FLEXIBLE]
    for spec in {content_id(spec): spec for spec in specs}.values():
        try:
            found.append(_search(spec, plan.root, plan.loaded.climate_path, keep=keep))
        except (ConfigError, ConvergenceError):
            continue  # a shell that does not carry its load: the campaign says that it is not viable
    return Needed(max(one.degree for one in found), all(one.met for one in found))


def degree_lines(plan: StudyPlan | CampaignPlan, *, keep: bool = True) -> list[str]:
    """Return what `vsb check` says of a given degree: nothing where the degree follows from the tolerance."""
    study = plan.study if isinstance(plan, StudyPlan) else plan.loaded.base.buoy
    if study is None:
        return []
    modes, varied = study.modes, isinstance(plan, CampaignPlan) and "modes.degree" in plan.loaded.campaign.vary.keys
    if not study.flexible or not study.needs_bem or modes.degree is None or varied:
        return []
    try:
        needed = degree_needed(plan, keep=keep)
    except (ConfigError, ConvergenceError) as error:
        return [f"doubt        modes: degree {modes.degree} is given; what it leaves out is not known: {error}"]
    estimated = "what is left out is estimated in the run and widens the intervals"
    if modes.basis != "full" or modes.degree < needed.degree:
        return [
            f"doubt        modes: {modes.basis}, degree {modes.degree}, but modes.tolerance {modes.tolerance:g} needs "
            f"the full basis to degree {needed.degree}: {estimated}"
        ]
    if not needed.met:
        return [
            f"doubt        modes: degree {modes.degree} may not meet modes.tolerance {modes.tolerance:g}, and higher "
            f"degrees are not computed: {estimated}"
        ]
    return [f"ok           modes: degree {modes.degree} meets modes.tolerance {modes.tolerance:g}"]


def extremes(points: Sequence[Point]) -> list[Point]:
    """Return the points with the least and the largest number of each key, and with each of its words, once each."""
    chosen: list[Point] = []
    for key in points[0]:
        values = [point[key] for point in points]
        numbers = [value for value in values if not isinstance(value, str)]
        words = {value: value for value in values if isinstance(value, str)}
        wanted = [*([min(numbers), max(numbers)] if numbers else []), *words]
        chosen += [next(point for point in points if point[key] == value) for value in wanted]
    return [point for i, point in enumerate(chosen or points[:1]) if point not in chosen[:i]]


def _with(study: Study, degree: int) -> Study:
    """The study with a degree."""
    return study.model_copy(update={"modes": study.modes.model_copy(update={"degree": degree})})


class ModeSearch(NamedTuple):
    """What a search for the degree of the shell modes found."""

    degree: int
    met: bool  # whether the tolerance is met with it
    powers: dict[str, dict[str, Any]]  # by degree and design, lists (plain or completed at rings, sea, take-off) [W]


NONE_FLEXIBLE = ModeSearch(DEGREES[0], True, {})


_FOUND: dict[str, ModeSearch] = {}
"""Searches of this process by content id, those that are not kept in files among them."""


def _search(spec: DegreeSpec, root: str, climate_path: str = "", *, keep: bool = True) -> ModeSearch:
    """The search for the degree that meets the tolerance, from where it is kept or made now."""
    if spec.buoy is None or not spec.buoy.flexible:
        return NONE_FLEXIBLE
    path = degree_path(root, spec)
    if (kept := stored_search(path)) is not None:
        return kept
    if not keep and (known := _FOUND.get(content_id(spec))):
        return known
    from vsb.scenes.mode_convergence import as_lists, mode_convergence  # only now: it imports what solves
    from vsb.stages.climate import read_climate
    from vsb.tools.files import write_text

    tolerance = f"modes.tolerance {spec.buoy.modes.tolerance:g}"
    words = f"finding how many shell modes meet {tolerance}: seconds{f', once, kept in {path}' if keep else ''}"
    print(words, file=sys.stderr, flush=True)
    search = mode_convergence(spec, read_climate(spec.climate, climate_path) if spec.climate else None)
    powers = as_lists(search.powers_by_degree, spec.buoy)
    found = _FOUND[content_id(spec)] = ModeSearch(search.degree, search.met, powers)
    if not keep:
        return found
    entry = {**found._asdict(), "checksum": _checksum(path, found), "spec": canonical(spec)}
    write_text(path, json.dumps(entry) + "\n")
    return found


def stored_search(path: str) -> ModeSearch | None:
    """Return what a search found; None if it is not there, or not what it should be."""
    try:
        kept = json.loads(Path(path).read_text(encoding="utf-8"))
        found = ModeSearch(int(kept["degree"]), bool(kept["met"]), kept["powers"])
        return found if kept["checksum"] == _checksum(path, found) else None
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


def _checksum(path: str, found: ModeSearch) -> str:
    """What a search is kept with: a flipped bit can make one degree of the list of another."""
    return hashlib.sha256(f"{Path(path).stem} {canonical(found._asdict())}".encode()).hexdigest()[:16]
