"""Checks of a campaign before anything is solved; imported before each run, so it imports little."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from vsb.engine.waves.climate import OUTSIDE, Climate, climate_line
from vsb.errors import ConfigError
from vsb.pipeline.graph import BodyPlan
from vsb.pipeline.plans import CampaignPlan
from vsb.stages.check import read_climate
from vsb.study.campaign import where_of
from vsb.study.study import Study
from vsb.tools import packed

MOST_POINTS = 24
"""Points of a campaign whose static load `vsb check` computes: a second each at most."""


def check(plan: CampaignPlan) -> None:
    """Raise what would fail later in a campaign: points that are no studies, frequencies that cannot be solved, seas.

    Raises `ConfigError`.
    """
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    for hydro in plan.waters:
        if isinstance(hydro, BodyPlan):
            _check_body(plan, hydro, seas)
        else:
            hydro.check_waves()
            _check_band(plan, seas, hydro.first_omega, hydro.study.hydro.omega_max)
    for member in plan.members:
        study = member.study
        if study.has_shell and any(
            one.flexible and study.modes.max_degree <= 2 * len(one.clamp) for one in study.designs.values()
        ):
            _check_clamps(study, where_of(member.point), plan.loaded.source)
    for task in plan.verifications.values() if not plan.bodies else ():
        _check_runs(task.spec["member"].study, plan.loaded.source)


def _check_band(plan: CampaignPlan, seas: Climate, omega_min: float, omega_max: float) -> None:
    """Raise if more than a hundredth of the variance lies outside the frequencies of a point [rad/s]."""
    outside = seas.variance_outside(omega_min, omega_max)
    if outside > OUTSIDE:
        needed = "a larger hydro.omega_max in the study" if not plan.bodies else "coefficients of a wider band"
        raise ConfigError(
            f"{plan.loaded.source}: climate: {100 * outside:.3g} % of its variance lies outside {omega_min:.4g} to "
            f"{omega_max:.4g} rad/s, which a point solves; needs at most {100 * OUTSIDE:.3g} %, {needed}"
        )


def _check_body(plan: CampaignPlan, body: BodyPlan, seas: Climate) -> None:
    """Raise what would fail of a body: its files, its band, the direction of the seas."""
    from vsb.stages.body_preview import check as check_body
    from vsb.stages.body_preview import check_direction

    without_seas = replace(body, study=body.study.model_copy(update={"waves": ()}))  # those of the year come instead
    try:
        found = check_body(without_seas).body
    except ConfigError as error:
        raise ConfigError(f"{plan.loaded.source}: study: {error}") from None
    direction = plan.loaded.campaign.climate.direction
    check_direction(direction, found, f"{plan.loaded.source}: climate.direction")
    _check_band(plan, seas, *map(float, found.database.omega.values[[0, -1]]))


def _check_clamps(buoy: Study, where: str, source: str) -> None:
    """Raise where clamps, of two equations each, leave no mode free: of few modes alone, for it reads what solves."""
    from vsb.models.rest import design_motions, study_basis

    try:
        for design in buoy.designs:
            design_motions(buoy, study_basis(buoy), design)
    except ConfigError as error:
        raise ConfigError(f"{source}: vary: {where}: {error}") from None


def _check_runs(study: Study, source: str) -> None:
    """Raise what would fail in the runs in time of a member; designs that are not viable are not run."""
    from vsb.models.viability import check_rests_advised, viability, with_designs

    rest = viability(study)
    if rest.designs and rest.reference:
        try:
            check_rests_advised(with_designs(study, rest.designs), rest.reference)
        except ConfigError as error:
            raise ConfigError(f"{source}: verify: {error}") from None


def summary(plan: CampaignPlan) -> list[str]:
    """Return the lines `vsb check` prints of a campaign: its points, what is done of them, the jobs left."""
    check(plan)
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    given = plan.loaded.campaign
    shapes = len({one.spec.sweep for one in plan.members})
    kinds = "databases" if plan.bodies else "shapes of the water"
    stored = packed.packs(Path(plan.folder, "members"))
    done = sum(one.id in stored for one in plan.members) if stored else 0
    jobs = sum(not Path(one.out).exists() for one in plan.batches.values())
    runs = []
    if verify := given.verify:
        ready = sum(Path(one.out).exists() for one in plan.verifications.values())
        each = f"of each of {len(plan.verifications)} points, {ready} done"
        runs = [f"verify       {verify.seas} seas, {verify.model}, {each}"]
    return [
        f"campaign     {plan.name}: {given.study} over {len(seas.hours)} seas, tuning {', '.join(plan.loaded.tuning)}",
        f"points       {len(plan.members)} of {' x '.join(given.vary.values) or 'nothing varied'}, {done} done",
        *runs,
        f"jobs         {jobs} of {len(plan.batches)} batches to do, {shapes} {kinds}",
        *map(climate_line, seas.notes),
        *_angle_lines(plan),
        *_load_lines(plan),
    ]


def _load_lines(plan: CampaignPlan) -> list[str]:
    """Whether the shells carry their static load: the answer is void if none does. Only of few points, for its time."""
    from vsb.engine.hydro.database import Check, Verdict
    from vsb.models.viability import OVERLOADED, advice, viability

    shells = [one.study for one in plan.members if one.study.has_shell]
    if not 0 < len(shells) <= MOST_POINTS:
        return []

    def line(name: str, value: float, limit: float, failing: Sequence[bool], text: str, nearest: Study | None) -> str:
        verdict: Verdict = "fail" if all(failing) else "doubt" if any(failing) else "ok"
        tried = advice(nearest) if verdict == "fail" and nearest else ""
        return Check(name, value, limit, "-", verdict, text, advice=tried).line

    rests = [viability(one) for one in shells]
    loads = [1.0 - rest.margin for rest in rests]
    nearest = shells[loads.index(min(loads))]
    buckled = [load > 1.0 for load in loads]
    text = (
        f"static load over the load at which the shell buckles: it does at {sum(buckled) or 'none'} of {len(loads)} "
        "points"
    )
    lines = [line("buckling", max(loads), 1.0, buckled, text, nearest)]
    flexible = [{name for name, one in shell.designs.items() if one.flexible} for shell in shells]
    lost = [not names & set(rest.designs) for names, rest in zip(flexible, rests, strict=True)]
    if any(lost) and not all(buckled):
        reason = next(iter(rests[lost.index(True)].reasons.values()))
        text = f"points of {len(lost)} at which no flexible design is viable: {reason}"
        lines.append(line("not_viable", sum(lost), 0.0, lost, text, nearest if reason.startswith(OVERLOADED) else None))
    return lines


def _angle_lines(plan: CampaignPlan) -> list[str]:
    """Doubts about angles that look like radians, in the study or among the points."""
    from vsb.results.ledger import DEGREES, angle_checks

    turned = any(key.split(".")[-1] in DEGREES for point in plan.loaded.campaign.vary.points for key in point)
    studies = [plan.loaded.base, *(member.study for member in plan.members if turned)]
    return list(dict.fromkeys(one.line for study in studies for one in angle_checks(study)))
