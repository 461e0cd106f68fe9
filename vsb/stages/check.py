"""What is checked before a run, and what `vsb check` prints: of a study, of a body, of a campaign or of a design.

Each kind has a module of its own, imported only for a plan of that kind: a run waits for it.
"""

import importlib
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

from vsb.engine.waves.climate import Climate
from vsb.engine.waves.measured_spectra import read_spectra
from vsb.engine.waves.scatter import Spectrum, read_scatter
from vsb.errors import ConfigError
from vsb.pipeline.costs import GREEN_KEPT_SECONDS
from vsb.pipeline.graph import BodyPlan, StudyPlan
from vsb.pipeline.jobs import cost_line
from vsb.pipeline.plans import CampaignPlan, DesignPlan, Plan, base_study, degree_lines
from vsb.study.campaign import ClimateFile
from vsb.study.study import units_doubted, unlikely_units
from vsb.tools.files import sha256_of


def read_climate(year: ClimateFile, path: str) -> Climate:
    """Read the seas of a year from a file named by its contents.

    Raises `ConfigError` if it holds others, or cannot be read.
    """
    try:
        found = sha256_of(path)[:16]
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}); needs the climate of the campaign") from None
    if found != year.file:
        raise ConfigError(f"{path}: changed since the run was planned; run vsb run CONFIG again")
    return _seas_of(year, path)


@lru_cache(maxsize=1)
def _seas_of(year: ClimateFile, path: str) -> Climate:
    """Seas of a file whose contents are known: stages done by one process share them."""
    return read_seas(path, year.spectrum, year.gamma)


def read_seas(path: str | Path, form: Spectrum | Literal["spectra"] = "spectra", gamma: float = 3.3) -> Climate:
    """Read the seas of a year.

    Parameters
    ----------
    path : str or Path
        Measured spectra, or a scatter table of Hs and Te.
    form : {'spectra', 'jonswap', 'pierson_moskowitz'}
        What the file holds: spectra, or a table whose seas have spectra of this shape.
    gamma : float
        Peakedness of JONSWAP spectra of a table.

    Raises
    ------
    ConfigError
        If the file cannot be read, or holds something else.
    """
    if form != "spectra":
        return read_scatter(path, form, gamma)
    return read_spectra(path)


MODULES: dict[type, str] = {
    StudyPlan: "preview", BodyPlan: "body_preview", CampaignPlan: "campaign_preview", DesignPlan: "design_preview",
}  # fmt: skip
"""Kind of plan -> module here with the functions `check` and `summary`."""


def _of(plan: Plan) -> Any:
    """The module of a plan."""
    return importlib.import_module(f"vsb.stages.{MODULES[type(plan)]}")


def check_plan(plan: Plan) -> None:
    """Raise what would fail later in a run; raises `ConfigError` or `DatabaseError`."""
    with units_doubted(base_study(plan)):
        _of(plan).check(plan)


def unit_lines(plan: Plan) -> list[str]:
    """Return what is to be said of numbers that are likely only in another unit."""
    return [f"doubt        units: {line}" for line in unlikely_units(base_study(plan))]


def summary(plan: Plan) -> list[str]:
    """Return the lines `vsb check` prints: what would be computed, at what cost, and what to doubt."""
    with units_doubted(base_study(plan)):
        first, *others = _of(plan).summary(plan)
    degrees = degree_lines(plan) if isinstance(plan, StudyPlan | CampaignPlan) else []
    return [first, *sea_lines(plan), *cost_lines(plan), *others, *unit_lines(plan), *degrees]


def cost_lines(plan: Plan) -> list[str]:
    """Return the jobs left and their CPU time; a design measures its own."""
    return [] if isinstance(plan, DesignPlan) else [cost_line(plan, known_seconds(plan))]


def known_seconds(plan: Plan) -> dict[str, float]:
    """Return the CPU time of tasks by what they make, where more is known than the plan does [s].

    Of bodies from their meshes as built, and of the Green-function table that this machine may keep.
    """
    bodies = [plan] if isinstance(plan, BodyPlan) else plan.bodies if isinstance(plan, CampaignPlan) else []
    if not (some := [one for one in bodies if one.study.uses_panels]):
        return {}
    from vsb.engine.hydro.panels.bem import is_table_kept
    from vsb.stages.body_preview import solving_seconds

    apart = [task for task in plan.tasks if task.stage == "frequencies"]
    if apart:  # of one body: their database takes all of the estimate
        share = solving_seconds(some[0]) / sum(task.seconds for task in apart)
        known = {task.out: share * task.seconds for task in apart}
    else:
        known = {one.database.out: solving_seconds(one) for one in some}
    return known | {one.green.out: GREEN_KEPT_SECONDS for one in some if is_table_kept()}


def sea_lines(plan: Plan) -> list[str]:
    """Return height, energy period and energy flux of each sea of a study, or their means over the year of a climate.

    None where no coefficients are computed: there the period of a regular wave is used alone.
    """
    if isinstance(plan, CampaignPlan | DesignPlan):
        from vsb.stages.check import read_climate

        seas = read_climate(plan.climate, plan.loaded.climate_path)
        return [f"seas         {len(seas.hours)} over the year: {seas.means(plan.loaded.base.water)}"]

    found = {}
    for wave in plan.study.waves if plan.study.needs_bem else ():
        if wave.still:
            continue
        energy = wave.energy(plan.study.water)
        flux = f"{energy.flux / 1000:.3g} kW/m"
        if wave.regular:
            found[wave.label] = f"height {energy.height:.3g} m, period {energy.period:.3g} s, {flux}"
        else:
            found[wave.family] = f"Hs {energy.height:.3g} m, Te {energy.period:.3g} s, {flux}"
    return [f"sea          {name}: {text}" for name, text in found.items()]
