"""Checks of a campaign before anything is solved; imported before each run, so it imports little."""

from pathlib import Path

from vsb.errors import ConfigError
from vsb.stages.climate import read_climate
from vsb.study.campaign import where_of
from vsb.study.campaign_plan import CampaignPlan, Member
from vsb.study.plan import StudyPlan
from vsb.study.study import Study
from vsb.tools import packed
from vsb.waves.climate import OUTSIDE


def check_campaign(plan: CampaignPlan) -> None:
    """Raise what would fail later in a campaign: points that are no studies, frequencies that cannot be solved, seas.

    Raises
    ------
    ConfigError
    """
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    for one in {member.spec.sweep: member for member in plan.members}.values():
        hydro = StudyPlan(one.study, root=plan.root)
        hydro.check_waves()
        outside = seas.variance_outside(hydro.first_omega, one.study.hydro.omega_max)
        if outside > OUTSIDE:
            raise ConfigError(
                f"{plan.loaded.source}: climate: {outside:.1%} of its variance lies outside {hydro.first_omega:.4g} to "
                f"{one.study.hydro.omega_max:.4g} rad/s, which a point solves; needs at most {OUTSIDE:.0%}, a larger "
                "hydro.omega_max in the study"
            )
    for member in plan.members:
        if any(
            one.flexible and member.study.modes.max_degree <= 2 * len(one.clamp)
            for one in member.study.designs.values()
        ):
            _check_clamps(member, plan.loaded.source)
    for spec in plan.verifications.values():
        _check_runs(spec.simulated, plan.loaded.source)


def _check_clamps(member: Member, source: str) -> None:
    """Raise where clamps, of two equations each, leave no mode free: of few modes alone, for it reads what solves."""
    from vsb.scenes.rest import design_motions, study_basis

    try:
        for design in member.study.designs:
            design_motions(member.study, study_basis(member.study), design)
    except ConfigError as error:
        raise ConfigError(f"{source}: vary: {where_of(member.point)}: {error}") from None


def _check_runs(study: Study, source: str) -> None:
    """Raise what would fail in the runs in time of a member; designs that are not viable are not run."""
    from vsb.scenes.rest import check_rests
    from vsb.scenes.viability import viability

    if viable := viability(study).viable:
        try:
            check_rests(*viable)
        except ConfigError as error:
            raise ConfigError(f"{source}: verify: {error}") from None


def campaign_summary(plan: CampaignPlan) -> list[str]:
    """Return the lines `vsb check` prints of a campaign: its points, what is done of them, the jobs left."""
    check_campaign(plan)
    seas = read_climate(plan.climate, plan.loaded.climate_path)
    given = plan.loaded.campaign
    shapes = len({one.spec.sweep for one in plan.members})
    done = sum(Path(plan.folder, "members", f"{one.id}{packed.SUFFIX}").exists() for one in plan.members)
    jobs = sum(not Path(path).exists() for path in plan.batch_paths)
    return [
        f"campaign     {plan.name}: {given.study} over {len(seas.hours)} seas, tuning {', '.join(plan.loaded.tuning)}",
        f"points       {len(plan.members)} of {' x '.join(given.vary.values) or 'nothing varied'}, {done} done",
        *_runs_lines(plan),
        f"jobs         {jobs} of {len(plan.batches)} batches to do, {shapes} shapes of the water",
        *(f"climate      {note}" for note in seas.notes),
        *_angle_lines(plan),
    ]


def _angle_lines(plan: CampaignPlan) -> list[str]:
    """Doubts about angles that look like radians, in the study or among the points."""
    from vsb.results.ledger import DEGREES, angle_checks

    turned = any(key.split(".")[-1] in DEGREES for point in plan.loaded.campaign.vary.points for key in point)
    studies = [plan.loaded.base, *(member.study for member in plan.members if turned)]
    return list(dict.fromkeys(check.line for study in studies for check in angle_checks(study)))


def _runs_lines(plan: CampaignPlan) -> list[str]:
    """What is simulated in time."""
    if not (verify := plan.loaded.campaign.verify):
        return []
    done = sum(Path(path).exists() for path in plan.verification_paths)
    return [
        f"verify       {verify.seas} seas, {verify.model}, of each of {len(plan.verifications)} points, {done} done"
    ]
