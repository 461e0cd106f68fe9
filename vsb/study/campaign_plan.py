"""What a campaign computes: members, batches, content ids and file names. Pure Python, read at every parse.

A member is one point of what is varied, over the whole year, every design and tuning inside it. Batches follow from the
campaign's files alone, so that a dry run shows the true plan; within a batch finished members are kept.
"""

import gc
import itertools
import math
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import PurePosixPath
from typing import Any

from vsb.engine.integrators.settings import Simulation
from vsb.errors import ConfigError
from vsb.keys.quantities import canonical, content_id
from vsb.study import figure_names
from vsb.study.body import AnyStudy, BodyStudy
from vsb.study.campaign import (
    AT_FORCE,
    GAIN_IN_TIME,
    IN_TIME,
    POWER_IN_TIME,
    Constrained,
    LoadedCampaign,
    Tunings,
    any_study_at,
    leading_tuning,
    sections,
    sizes_hull,
    where_of,
)
from vsb.study.plan import BodyPlan, ResultsFolder, StudyPlan, plan_for
from vsb.study.specs import (
    BodySystem,
    BuoySystem,
    CampaignSpec,
    ClimateSpec,
    MemberSpec,
    MembersSpec,
    Spec,
    VerificationSpec,
)
from vsb.study.study import parse
from vsb.study.vary import Point

MOST_BATCHES = 32
BATCH_SECONDS = 8.0
"""What a batch is to take at least, so that starting it, 2 s, does not count."""
MEMBER_SECONDS, BLOCK_SECONDS = 0.016, 2.0
"""Of a member whose coefficients are there, of coefficients of a shape."""
CAUSAL_YEAR_SECONDS, CAUSAL_AT_PORTS_SECONDS = 5.0, 50.0
"""CPU time of the causal controllers of a design in a year of some ninety bins, at one port and at two."""
MATRICES_WITHIN_SECONDS = 150.0
"""Of the damper matrices of a given rms force in each of these bins."""
WITH_LOSSES = 5.0
"""That with losses in conversion, over it: weights are found by repetition."""
YEAR_MEGABYTES = 0.02
"""Of a design's year under one tuning, power matrices and all."""
OVER_BUDGET = 2.0
"""CPU time of optima within limits over their budget, by which their number was chosen; measured 2.1 to 3 on a busy
machine."""
VARIABLES = (
    "annual_mean_power", "annual_energy", "capture_width", "gain_percent", "gain_low", "gain_high", "damping",
    "force_rms", "viable", "margin", "reason", "practice_power", "quadrature_error", "power_matrix", "power_deviation",
    "capture_width_matrix", "capture_width_deviation", "count", "tried_damping", "power_of_damping",
    "force_of_damping", "damper_matrix", "damper", "design", "tuning", "hs", "te", "energy_beyond", "limit",
    "energy_beyond_validity", "beyond_validity", "power_bound", "optimum_gap", "optimum_share", "optimum_excess",
    "impossible_share", "occurrence", "flux_matrix", "annual_mean_power_low", "annual_mean_power_high",
    *(f"{model}_{name}" for model in IN_TIME.values() for name in (*POWER_IN_TIME, *GAIN_IN_TIME)),
)  # fmt: skip
"""Names in the results that no varied key can have."""


def _shared(one: "Member") -> tuple[Any, ...]:
    """What members may share: coefficients of a shape, a take-off, and shapes and buckling of a thickness."""
    return one.spec.sweep, canonical(one.study.pto), one.study.buoy.device.thickness if one.study.buoy else 0.0


@contextmanager
def _kept() -> Iterator[None]:
    """Do not look for what could be freed among a hundred thousand points, all of which stay: a third of their time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


@dataclass(frozen=True)
class Member:
    """One point of a campaign."""

    point: Point
    study: AnyStudy
    spec: MemberSpec

    @cached_property
    def id(self) -> str:
        """Content id."""
        return content_id(self.spec)


def members(
    base: Mapping[str, Any],
    points: Iterable[Point],
    climate: ClimateSpec,
    tuning: Sequence[Tunings],
    constrained: Constrained | None = None,
) -> list[Member]:
    """Return the members of some points.

    Parameters
    ----------
    base : mapping
        `vsb.study.campaign.sections` of the study.
    tuning : sequence of {'fixed', 'one', 'each', 'constrained'}
    """
    some = [*points]
    return members_of([any_study_at(base, point) for point in some], some, climate, tuning, constrained)


def members_of(
    studies: Iterable[AnyStudy],
    points: Iterable[Point],
    climate: ClimateSpec,
    tuning: Sequence[Tunings],
    constrained: Constrained | None = None,
) -> list[Member]:
    """Return the same of studies that are read already."""
    swept: dict[Hashable, tuple[str, ...]] = {}  # members of one shape share it
    found = []
    for study, point in zip(studies, points, strict=True):
        if (shape := _shape(study)) not in swept:
            swept[shape] = _coefficients(study)
        kind = BodySystem if isinstance(study, BodyStudy) else BuoySystem
        system = kind(**{name: getattr(study, name) for name in kind.model_fields if name != "drag"})  # a year has none
        budget = {"climate": climate, "tuning": tuple(tuning), "constrained": constrained}
        found.append(Member(point, study, MemberSpec(system=system, hydro=study.hydro, sweep=swept[shape], **budget)))
    return found


def _coefficients(study: AnyStudy) -> tuple[str, ...]:
    """Ids of the blocks of a buoy's shape, or of the database of a body."""
    plan = plan_for(study)
    specs = plan.sweep_blocks if isinstance(plan, StudyPlan) else [plan.database]
    return tuple(content_id(spec) for spec in specs)


def _shape(study: AnyStudy) -> Hashable:
    """All that coefficients depend on: of an undeformed shell neither its material nor its clamps."""
    if isinstance(study, BodyStudy):
        return canonical([study.body, study.dofs, study.hydro])
    device = study.device
    of_shell: Hashable = study.modes.max_degree if study.flexible else None
    own: Hashable = device.radius, device.mass, device.shape
    if study.rests_deformed:
        of_shell = study.modes, study.reference_shape
        own = tuple(value for name, value in device if name != "damping")
    return own, of_shell, study.water, study.hydro, study.orders


@dataclass(frozen=True)
class CampaignPlan(ResultsFolder):
    """Everything a campaign needs computed, with content ids."""

    KIND = "campaign"
    loaded: LoadedCampaign
    root: str = "results"
    read: tuple[AnyStudy, ...] = field(default=(), repr=False, compare=False)  # studies of the points, if they are

    @property
    def name(self) -> str:
        """Name of the campaign."""
        return self.loaded.campaign.campaign

    @cached_property
    def base(self) -> dict[str, Any]:
        """Sections of its study; where its draft may vary, with what decides it in the file."""
        found, keys = sections(self.loaded.base), self.loaded.campaign.vary.keys
        floats = any(sizes_hull(key) or key in ("device.draft", "water.density") for key in keys)
        if not self.loaded.base.buoy or not floats:
            return found
        others = {key: value for key, value in found["device"].items() if key != "mass"}
        return {**found, "device": others | self.loaded.floats_by}

    @property
    def climate(self) -> ClimateSpec:
        """What the seas of the year are read from."""
        return ClimateSpec.of(self.loaded.campaign.climate, self.loaded.climate_id)

    @cached_property
    def studies(self) -> tuple[AnyStudy, ...]:
        """Studies in the order of the points.

        Raises `ConfigError` if a point has no study; in one line with its values.
        """
        try:
            with _kept():
                return self.read or tuple(any_study_at(self.base, point) for point in self.loaded.campaign.vary.points)
        except ConfigError as error:
            raise ConfigError(f"{self.loaded.source}: vary: {error}") from None

    @cached_property
    def members(self) -> list[Member]:
        """Members in the order of the points; raises as `studies` does."""
        loaded, points = self.loaded, self.loaded.campaign.vary.points
        with _kept():
            found = members_of(self.studies, points, self.climate, loaded.tuning, loaded.constrained)
        try:
            for one in found:
                loaded.check_take_off(one.study, where_of(one.point))
        except ConfigError as error:
            raise ConfigError(f"{loaded.source}: vary: {error}") from None
        return found

    @cached_property
    def members_by_batch(self) -> dict[str, list[Member]]:
        """Members of each batch by its id: of as many each, those of one shape, take-off and thickness together."""
        ordered = sorted(self.members, key=_shared)
        shapes = len({one.spec.sweep for one in ordered})
        seconds = self.member_seconds * len(ordered) + BLOCK_SECONDS * shapes
        count = min(MOST_BATCHES, len(ordered), math.ceil(seconds / BATCH_SECONDS))
        ends = [len(ordered) * i // count for i in range(count + 1)]
        batches = [ordered[first:last] for first, last in itertools.pairwise(ends)]
        return {content_id([one.id for one in some]): some for some in batches}

    @cached_property
    def batches(self) -> dict[str, MembersSpec]:
        """Specs of the batches by id."""
        return {
            name: MembersSpec(
                base=self.base,
                points=tuple(one.point for one in some),
                climate=self.climate,
                tuning=self.loaded.tuning,
                constrained=self.loaded.constrained,
            )
            for name, some in self.members_by_batch.items()
        }

    @property
    def member_seconds(self) -> float:
        """Time a member takes once its coefficients are known [s]."""
        constrained, base = self.loaded.constrained, self.loaded.base
        each = OVER_BUDGET * constrained.seconds if constrained else 0.0
        if {*AT_FORCE} & {*self.loaded.tuning}:
            seconds = CAUSAL_AT_PORTS_SECONDS if base.pto.several else CAUSAL_YEAR_SECONDS
            if base.pto.several and base.pto.control.force_rms < math.inf:
                seconds += MATRICES_WITHIN_SECONDS
            each += seconds * (WITH_LOSSES if base.pto.efficiency < 1 else 1.0)
        return MEMBER_SECONDS + each * len(base.designs)

    @property
    def batch_minutes(self) -> int:
        """What a batch may take [min]: an hour, and what its members are expected to take."""
        most = max(map(len, self.members_by_batch.values()))
        return 60 + math.ceil(self.member_seconds * most / 60)

    def megabytes(self, points: int) -> int:
        """Memory that the results of some points take, beside that of a process [MB]."""
        return math.ceil(YEAR_MEGABYTES * points * len(self.loaded.base.designs) * len(self.loaded.tuning))

    @cached_property
    def verifications(self) -> dict[str, VerificationSpec]:
        """Specs of the runs in time of every member by id, in the order of the members; none without `verify`.

        Raises `ConfigError` if the study's `simulation` cannot follow the model.
        """
        found = [self._verification(one) for one in self.members] if self.loaded.campaign.verify else []
        return {content_id(spec): spec for spec in found}

    def _verification(self, one: Member) -> VerificationSpec:
        """Spec of the runs in time of a member: its study by the better model, tolerance and method of the base."""
        verify = self.loaded.campaign.verify
        assert verify is not None
        given, hydro = self.loaded.base.simulation, one.spec.hydro
        simulation = Simulation(tolerance=given.tolerance, method=given.method)  # how long follows from the seas
        if one.study.buoy:
            raw = one.study.model_dump(exclude_none=True)
            raw |= {"simulation": simulation, "hydro": {**raw["hydro"], "model": verify.model}}
            try:
                hydro = parse(raw, source="with the study's simulation").hydro
            except ConfigError as error:
                raise ConfigError(f"{self.loaded.source}: verify: {error}") from None
        parts = {name: value for name, value in one.spec if name not in Spec.model_fields}
        parts |= {"hydro": hydro, "simulation": simulation, "verify": verify}
        return VerificationSpec(**parts | {"tuning": (leading_tuning(self.loaded.tuning),)})

    @cached_property
    def campaign(self) -> CampaignSpec:
        """Spec of the whole campaign."""
        given = self.loaded.campaign
        return CampaignSpec(
            campaign=self.name,
            study=self.loaded.base.study,
            base=self.base,
            vary=given.vary,
            climate=self.climate,
            climate_name=PurePosixPath(given.climate.file).name.partition(".")[0],
            tuning=self.loaded.tuning,
            batches=tuple(self.batches),
            members=tuple(one.id for one in self.members),
            verifications=tuple(self.verifications),
        )

    @property
    def identity(self) -> str:
        """Id of what is made of all members together."""
        return content_id(self.campaign)

    @cached_property
    def bodies(self) -> dict[str, BodyPlan]:
        """Plans of the bodies of all points by the id of their database; none of a buoy."""
        plans = (
            BodyPlan(one.study, root=self.root, files=self.loaded.files)
            for one in self.members
            if isinstance(one.study, BodyStudy)
        )
        return {content_id(plan.database): plan for plan in plans}

    # file names -----------------------------------------------------------------------------------------------------

    def batch_path(self, batch: str) -> str:
        """Results of the members of a batch."""
        return f"{self.folder}/batches/{batch}.nc"

    def verification_path(self, verification: str) -> str:
        """What runs in time say about a member."""
        return f"{self.folder}/verification/{verification}.nc"

    @property
    def verification_paths(self) -> list[str]:
        """What runs in time say about all members."""
        return [self.verification_path(one) for one in self.verifications]

    @property
    def data_path(self) -> str:
        """All results."""
        return f"{self.folder}/campaign.nc"

    @property
    def table_path(self) -> str:
        """All results as a tidy table."""
        return f"{self.folder}/campaign.csv"

    @property
    def figure_paths(self) -> list[str]:
        """Figures of the report."""
        return figure_names.paths(self.folder, figure_names.of_campaign(self.campaign))

    @property
    def batch_paths(self) -> list[str]:
        """Results of all batches."""
        return [self.batch_path(batch) for batch in self.batches]
