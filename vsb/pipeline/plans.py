"""Plans of campaigns and design problems: members and their batches, starts and fronts; and the plan of any file.

Pure Python, read at every parse. A member is one point of what is varied, over the whole year, every design and tuning
inside it. Batches follow from the campaign's files alone, so that a dry run shows the true plan; within a batch
finished members are kept.
"""

import gc
import itertools
import math
import os
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path, PurePath, PurePosixPath
from typing import Any, Self

from vsb.engine.integrators.settings import Simulation
from vsb.engine.waves.kinds import StillWater, Wave
from vsb.engine.waves.scatter import read_scatter
from vsb.errors import ConfigError
from vsb.keys.quantities import canonical, content_id
from vsb.keys.reading import read_yaml
from vsb.pipeline import costs
from vsb.pipeline.graph import ID, AnyPlan, BodyPlan, Graph, StudyPlan, Task, plan_for
from vsb.study import figure_names
from vsb.study.body import read_study
from vsb.study.campaign import (
    AT_FORCE,
    ClimateFile,
    Constrained,
    LoadedCampaign,
    Scatter,
    Tunings,
    is_campaign,
    leading_tuning,
    read,
    sections,
    sizes_hull,
    study_at,
    where_of,
)
from vsb.study.design import LoadedDesign, is_design
from vsb.study.design import read as read_design
from vsb.study.resolution import block_id, degree_needed, in_band
from vsb.study.sections import DEGREES
from vsb.study.specs import (
    RUN_BY,
    CampaignSpec,
    DesignSpec,
    DesignVerificationSpec,
    MemberSpec,
    Search,
    VerificationSpec,
    spec_of,
)
from vsb.study.study import Study
from vsb.study.vary import Point

# a campaign -----------------------------------------------------------------------------------------------------------


MOST_BATCHES = 32
BATCH_SECONDS = 8.0
"""What a batch is to take at least, so that starting it, 2 s, does not count."""


def _shared(one: "Member") -> tuple[Any, ...]:
    """What members may share: coefficients of a shape, a take-off, and shapes and buckling of a thickness."""
    return one.spec.sweep, canonical(one.study.pto), one.study.device.thickness if one.study.KIND == "buoy" else 0.0


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
    study: Study
    spec: MemberSpec

    @cached_property
    def id(self) -> str:
        """Content id."""
        return content_id(spec_of("member", member=self.spec))


def members(
    base: Mapping[str, Any],
    points: Iterable[Point],
    climate: ClimateFile,
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
    return members_of([study_at(base, point) for point in some], some, climate, tuning, constrained)


def members_of(
    studies: Iterable[Study],
    points: Iterable[Point],
    climate: ClimateFile,
    tuning: Sequence[Tunings],
    constrained: Constrained | None = None,
) -> list[Member]:
    """Return the same of studies that are read already."""
    swept: dict[Hashable, tuple[str, ...]] = {}  # members of one shape share it
    found = []
    for study, point in zip(studies, points, strict=True):
        if (shape := _shape(study)) not in swept:
            swept[shape] = _coefficients(study)
        read = study.only("designs", "water", "pto", "hydro", *study.FLOATS, drag=None)  # a year has none
        budget = {"climate": climate, "tuning": tuple(tuning), "constrained": constrained}
        found.append(Member(point, study, MemberSpec(study=read, sweep=swept[shape], **budget)))
    return found


def _coefficients(study: Study) -> tuple[str, ...]:
    """Ids of the blocks of a buoy's shape, or of the database of a body."""
    plan = plan_for(study)
    return tuple(map(block_id, plan.sweep_blocks)) if isinstance(plan, StudyPlan) else (plan.database.id,)


def _shape(study: Study) -> Hashable:
    """All that coefficients depend on: of an undeformed shell neither its material nor its clamps."""
    if study.KIND == "body":
        return canonical([study.body, study.dofs, study.hydro])
    device = study.device
    of_shell: Hashable = study.modes.max_degree if study.flexible else None
    own: Hashable = device.radius, device.mass, device.shape
    if study.rests_deformed:
        of_shell = study.modes, study.reference_shape
        own = tuple(value for name, value in device if name != "damping")
    return own, of_shell, study.water, study.hydro, study.orders


@dataclass(frozen=True)
class CampaignPlan(Graph):
    """Everything a campaign needs computed."""

    KIND = "campaign"
    loaded: LoadedCampaign
    root: str = "results"
    read: tuple[Study, ...] = field(default=(), repr=False, compare=False)  # studies of the points, if they are

    @property
    def name(self) -> str:
        """Name of the campaign."""
        return self.loaded.campaign.campaign

    @property
    def degree_needed(self) -> int | None:
        """Degree of the full basis that `modes.tolerance` needs at every point; none where the degree is varied."""
        return None if "modes.degree" in self.loaded.campaign.vary.keys else max(map(degree_needed, self.studies))

    def with_degree(self) -> Self:
        """Return a plan whose shell modes have a degree, the largest of those that its points need.

        The automatic band of a point of another shape than the sphere follows from it.
        """
        base = self.loaded.base
        if base.KIND == "body":
            return self
        degree = self.degree_needed if base.modes.degree is None else None
        automatic = base.device.shape is not None and "omega_max" not in base.hydro.model_fields_set
        if degree is None and not automatic:
            return self
        studies = self.studies
        if degree is not None:
            base, studies = base.with_degree(degree), tuple(one.with_degree(degree) for one in studies)
        found = tuple(in_band(one, automatic=automatic) for one in studies)
        return replace(self, loaded=self.loaded.model_copy(update={"base": base}), read=found)

    @cached_property
    def base(self) -> dict[str, Any]:
        """Sections of its study; where its draft may vary, with what decides it in the file."""
        found, keys = sections(self.loaded.base), self.loaded.campaign.vary.keys
        floats = any(sizes_hull(key) or key in ("device.draft", "water.density") for key in keys)
        if "device" not in found or not floats:
            return found
        others = {key: value for key, value in found["device"].items() if key != "mass"}
        return {**found, "device": others | self.loaded.floats_by}

    @property
    def climate(self) -> ClimateFile:
        """What the seas of the year are read from."""
        return self.loaded.campaign.climate.of_contents(self.loaded.climate_id)

    @cached_property
    def studies(self) -> tuple[Study, ...]:
        """Studies in the order of the points.

        Raises `ConfigError` if a point has no study; in one line with its values.
        """
        try:
            with _kept():
                return self.read or tuple(study_at(self.base, point) for point in self.loaded.campaign.vary.points)
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
        seconds = self.member_seconds * len(ordered) + costs.BLOCK_SECONDS * shapes
        count = min(MOST_BATCHES, len(ordered), math.ceil(seconds / BATCH_SECONDS))
        ends = [len(ordered) * i // count for i in range(count + 1)]
        batches = [ordered[first:last] for first, last in itertools.pairwise(ends)]
        return {content_id([one.id for one in some]): some for some in batches}

    @cached_property
    def batches(self) -> dict[str, Task]:
        """Batches by id: every design and tuning of their members over the year; finished members are kept."""
        read, databases = {**self._read, "folder": f"{self.folder}/members"}, [one.database.out for one in self.bodies]
        most = max(map(len, self.members_by_batch.values()))
        minutes, made = 60 + math.ceil(self.member_seconds * most / 60), dict[str, Task]()
        for name, some in self.members_by_batch.items():
            points = [one.point for one in some]
            asked = {"year": self.climate, "tuning": self.loaded.tuning, "constrained": self.loaded.constrained}
            spec = spec_of("members", base=self.base, points=points, **asked)
            out = f"{self.folder}/batches/{name}.nc"
            made[name] = Task(
                "members", spec, {**read, "out": out}, (out,), tuple(databases), name,
                seconds=self._seconds(some), megabytes=2000 + 2 * self._megabytes(len(some)), minutes=minutes,
            )  # fmt: skip
        return made

    @property
    def _read(self) -> dict[str, str]:
        """The file of its seas and the folder of all results, by option."""
        return {"climate": self.loaded.climate_path, "root": self.root}

    # what members take ----------------------------------------------------------------------------------------------

    @property
    def member_seconds(self) -> float:
        """Time a member takes once its coefficients are known [s]."""
        constrained, base = self.loaded.constrained, self.loaded.base
        each = costs.OVER_BUDGET * constrained.seconds if constrained else 0.0
        if {*AT_FORCE} & {*self.loaded.tuning}:
            seconds = costs.CAUSAL_AT_PORTS_SECONDS if base.pto.several else costs.CAUSAL_YEAR_SECONDS
            if base.pto.several and base.pto.control.force_rms < math.inf:
                seconds += costs.MATRICES_WITHIN_SECONDS
            each += seconds * (costs.WITH_LOSSES if base.pto.efficiency < 1 else 1.0)
            each *= base.band[1] / costs.CAUSAL_BAND if base.band else 1.0
        matrices = costs.matrices_of_year(base, self.loaded.tuning)
        return costs.MEMBER_SECONDS + each * len(base.designs) + matrices

    def _seconds(self, some: Sequence[Member]) -> float:
        """CPU time of members [s]: their coefficients, their rest, their year."""
        each = costs.MEMBER_SECONDS + (self.member_seconds - costs.MEMBER_SECONDS) * self._part_of_bins
        shapes = {one.spec.sweep: one.study for one in some if one.study.KIND == "buoy"}.values()
        water = sum(costs.block_seconds(block) for buoy in shapes for block in StudyPlan(buoy).sweep_blocks)
        water += sum(costs.finer_water_seconds(buoy) for buoy in shapes if not buoy.at_equilibrium)
        resting = [one for one in some if one.study.at_equilibrium]
        rests = len({one.spec.sweep for one in resting})
        of_rests = costs.REST_SECONDS * rests + costs.SAME_REST_SECONDS * (len(resting) - rests)
        as_built = [one.study for one in some if one.study.has_shell and not one.study.at_equilibrium]
        left_out = sum(map(costs.left_out_seconds, {study.device: study for study in as_built}.values()))
        return each * len(some) + of_rests + left_out + water

    @cached_property
    def _part_of_bins(self) -> float:
        """How long control of a year takes over that of one with `BINS` bins: known of the cells of a scatter table."""
        if self.loaded.constrained or not isinstance(self.loaded.campaign.climate, Scatter):
            return 1.0
        try:
            cells = len(read_scatter(self.loaded.climate_path).hours)
        except ConfigError:  # of a file that is gone, or other than it was: said where it is read for its seas
            return 1.0
        return costs.ONCE + (1 - costs.ONCE) * cells / costs.BINS

    def _megabytes(self, points: int) -> int:
        """Memory that the results of some points take, beside that of a process [MB]."""
        return math.ceil(costs.YEAR_MEGABYTES * points * len(self.loaded.base.designs) * len(self.loaded.tuning))

    def seconds_left(self, some: Sequence[Task]) -> float:
        """Return the CPU time of tasks whose files are not there [s]; finished members of a batch are kept."""
        from vsb.tools.packed import packs

        stored, seconds = packs(Path(self.folder, "members")), 0.0
        for one in some:
            batch = self.members_by_batch[one.id] if stored and one.stage == "members" else []
            seconds += one.seconds * (sum(each.id not in stored for each in batch) / len(batch) if batch else 1.0)
        return seconds

    # runs in time, all together, report -----------------------------------------------------------------------------

    @cached_property
    def verifications(self) -> dict[str, Task]:
        """The runs in time of every member by id, in the order of the members; none without `verify`.

        Raises `ConfigError` if the study's `simulation` cannot follow the model.
        """
        memories = [one.radiation.out for one in self.bodies]
        found = [self._verification(one) for one in self.members] if self.loaded.campaign.verify else []
        out = f"{self.folder}/verification/{ID}.nc"
        made = [
            Task.of(
                "verification", {"member": spec, "versions": RUN_BY}, out, files=self._read, needs=memories,
                seconds=costs.verification_seconds(spec), megabytes=2000, minutes=240,
            )
            for spec in found
        ]  # fmt: skip
        return {one.id: one for one in made}

    def _verification(self, one: Member) -> VerificationSpec:
        """Spec of the runs in time of a member: its study by the better model, tolerance and method of the base."""
        verify = self.loaded.campaign.verify
        assert verify is not None
        given, changed = self.loaded.base.simulation, dict[str, Any]()
        simulation = Simulation(tolerance=given.tolerance, method=given.method)  # how long follows from the seas
        raw = one.study.model_dump(exclude_none=True)
        raw |= {"simulation": simulation, "hydro": {**raw["hydro"], "model": verify.model}}
        try:
            changed["hydro"] = read_study(raw, "with the study's simulation").study.hydro
        except ConfigError as error:
            raise ConfigError(f"{self.loaded.source}: verify: {error}") from None
        parts = dict(one.spec)
        still: tuple[Wave, ...] = (StillWater(kind="still"),)  # the seas are those of the year
        changed |= {"study": "member", "simulation": simulation, "waves": still}
        study = one.spec.study.model_copy(update=changed)
        parts |= {"study": study, "verify": verify, "tuning": (leading_tuning(self.loaded.tuning),)}
        return VerificationSpec(**parts)

    @cached_property
    def campaign(self) -> Task:
        """All members together: data and table."""
        given, folder, members = self.loaded.campaign, self.folder, len(self.members)
        spec = CampaignSpec(
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
        files = {"batches": f"{folder}/batches", "verifications": f"{folder}/verification", "manifest": self.manifest}
        table, before = f"{folder}/campaign.csv", (*self.batches.values(), *self.verifications.values())
        return Task.of(
            "campaign", {"spec": spec}, self.data_path, files=files | {"table": table}, makes=(self.data_path, table),
            needs=[one.out for one in before], seconds=0.3 + 1e-3 * members, megabytes=2000 + self._megabytes(members),
        )  # fmt: skip

    @cached_property
    def report(self) -> Task:
        """The report of a campaign and its figures."""
        whole, report = self.campaign, f"{self.folder}/report.html"
        figures = figure_names.paths(self.folder, figure_names.of_campaign(whole.spec["spec"]))
        files = {**self._read, "figures": f"{self.folder}/figures", "manifest": self.manifest}
        return Task(
            "campaign_report", whole.spec, files | {"data": whole.out, "out": report}, (report, *figures), (whole.out,),
            whole.id, seconds=1.2 + 1e-3 * len(self.members), megabytes=whole.megabytes,
        )  # fmt: skip

    def _tasks(self) -> Iterator[Task]:
        """Yield databases of bodies, batches of members, their runs in time, all of them together, the report."""
        bodies = self.bodies
        yield from {one.green.out: one.green for one in bodies if one.study.uses_panels}.values()
        yield from (replace(one.solved_database(), on_the_way=True) for one in bodies)
        yield from self.batches.values()
        if self.verifications:
            yield from (replace(one.radiation, on_the_way=True) for one in bodies)
        yield from (*self.verifications.values(), self.campaign, self.report)

    @property
    def identity(self) -> str:
        """Id of what is made of all members together."""
        return self.campaign.id

    @property
    def data_path(self) -> str:
        """All results."""
        return f"{self.folder}/campaign.nc"

    @cached_property
    def waters(self) -> list[AnyPlan]:
        """Plans of the coefficients of all points, those of one shape or database once."""
        each = {one.spec.sweep: one.study for one in self.members}.values()
        return [plan_for(study, self.root, self.loaded.files) for study in each]

    @property
    def bodies(self) -> list[BodyPlan]:
        """Those of bodies; none of a buoy."""
        return [plan for plan in self.waters if isinstance(plan, BodyPlan)]


# a design problem -----------------------------------------------------------------------------------------------------


TABLES = (
    "starts.csv", "optimum.yaml", "competitor.yaml", "pareto.csv", "sensitivity.csv", "budget.csv", "power_budget.csv",
    "design.nc",
)  # fmt: skip
"""Results in the folder of a design problem."""


@dataclass(frozen=True)
class DesignPlan(Graph):
    """Everything a design problem needs computed."""

    KIND = "design"
    loaded: LoadedDesign
    root: str = "results"

    @property
    def name(self) -> str:
        """Name of the design problem."""
        return self.loaded.problem.design

    @property
    def climate(self) -> ClimateFile:
        """What the seas of the year are read from."""
        return self.loaded.problem.climate.of_contents(self.loaded.climate_id)

    @cached_property
    def flexible(self) -> Search:
        """What the flexible buoy is optimised over."""
        loaded, problem = self.loaded, self.loaded.problem
        return Search(
            base=loaded.sections,
            design=loaded.flexible,
            climate=self.climate,
            variables=problem.variables,
            maximise=problem.maximise,
            limits=loaded.limits,
            cost=problem.prices,
            fatigue=problem.fatigue,
            degrees=self._degrees,
            tolerance=loaded.base.modes.tolerance,
            tuning=problem.tuning,
            **self._kept_away,
        )

    @property
    def _kept_away(self) -> dict[str, Any]:
        """Standard deviations limits are kept away by, and the inputs they are of; nothing else depends on these."""
        problem = self.loaded.problem
        return {"sigmas": problem.limits.sigmas, "uncertain": problem.uncertain} if problem.limits.sigmas else {}

    @property
    def _degrees(self) -> tuple[int, ...]:
        """Degrees of shell modes to be tried: all, or the one the study gives; the last two for errors."""
        given = self.loaded.base.modes.degree
        if given is None:
            return DEGREES
        return (given, *(degree for degree in DEGREES if degree > given))[:3]

    @cached_property
    def rigid(self) -> Search:
        """What the rigid competitor is optimised over."""
        loaded, problem = self.loaded, self.loaded.problem
        over = "annual_mean_power" if problem.maximise == "gain" else problem.maximise  # a gain over itself is none
        return Search(
            base=loaded.rigid_sections,
            design=loaded.rigid,
            climate=self.climate,
            variables=loaded.competing,
            maximise=over,
            limits=loaded.rigid_limits,
            cost=problem.prices,
            tuning=problem.tuning,
            **self._kept_away,
        )

    def _starts(self, search: Search, seconds: float) -> dict[str, Task]:
        """The starts of a search by id; without variables there is one."""
        problem = self.loaded.problem
        given = {"search": search, "seed": problem.seed}
        out, read = f"{self.folder}/starts/{ID}.nc", self._climate_file
        found = [
            Task.of("design_start", given | {"start": i}, out, files=read, seconds=seconds, minutes=120)
            for i in range(problem.starts if search.variables else 1)
        ]
        return {one.id: one for one in found}

    @cached_property
    def starts(self) -> dict[str, Task]:
        """Starts of the flexible buoy by id."""
        return self._starts(self.flexible, costs.START_SECONDS)

    @cached_property
    def rigid_starts(self) -> dict[str, Task]:
        """Starts of the rigid competitor by id."""
        return self._starts(self.rigid, costs.RIGID_START_SECONDS)

    @property
    def all_starts(self) -> list[Task]:
        """Both."""
        return [*self.starts.values(), *self.rigid_starts.values()]

    @cached_property
    def fronts(self) -> dict[str, Task]:
        """Pareto fronts by id: for each limit that of the flexible buoy, then that of the rigid one."""
        found = []
        for limit, values in self.loaded.problem.pareto.items():
            for search, starts in ((self.flexible, self.starts), (self.rigid, self.rigid_starts)):
                given = {"search": search, "limit": limit, "values": values, "begun": tuple(starts)}
                found.append(
                    Task.of(
                        "design_front", given, f"{self.folder}/fronts/{ID}.nc", files=self._begun,
                        needs=[one.out for one in starts.values()], seconds=costs.START_SECONDS, minutes=240,
                    )
                )  # fmt: skip
        return {one.id: one for one in found}

    @cached_property
    def verification(self) -> Task | None:
        """Runs in time of both buoys; none without `verify`."""
        if not (verify := self.loaded.problem.verify):
            return None
        given = self.loaded.base.simulation
        spec = DesignVerificationSpec(
            flexible=self.flexible,
            rigid=self.rigid,
            verify=verify,
            simulation=Simulation(tolerance=given.tolerance, method=given.method),  # how long follows from the seas
            starts=tuple(self.starts),
            rigid_starts=tuple(self.rigid_starts),
        )
        out = f"{self.folder}/verification/{ID}.nc"
        return Task.of(
            "design_verification", {"spec": spec, "versions": RUN_BY}, out, files=self._begun | {"root": self.root},
            needs=[one.out for one in self.all_starts], seconds=60.0, minutes=600, megabytes=2000,
        )  # fmt: skip

    @cached_property
    def design(self) -> Task:
        """The whole problem: all tables."""
        problem, verification, folder = self.loaded.problem, self.verification, self.folder
        spec = DesignSpec(
            name=self.name,
            study=self.loaded.base.study,
            climate_name=PurePosixPath(problem.climate.file).name.partition(".")[0],
            flexible=self.flexible,
            rigid=self.rigid,
            starts=tuple(self.starts),
            rigid_starts=tuple(self.rigid_starts),
            fronts=tuple(self.fronts),
            pareto=tuple(problem.pareto),
            uncertain=problem.uncertain,
            verification=verification.id if verification else None,
            runs=self.loaded.base.model_dump(include={"waves", "simulation"}, exclude_none=True),
            notes=tuple(self.loaded.notes),
        )
        made = [f"{folder}/{name}" for name in TABLES]
        before = [*self.all_starts, *self.fronts.values(), *([verification] if verification else [])]
        files = {"fronts": f"{folder}/fronts", "verifications": f"{folder}/verification", "folder": folder}
        read = spec_of("design_results", spec=spec)
        return Task(
            "design_results", read, self._begun | files | {"manifest": self.manifest}, tuple(made),
            tuple(one.out for one in before), content_id(read), seconds=8.0, megabytes=2000,
        )  # fmt: skip

    @cached_property
    def report(self) -> Task:
        """The report of the problem and its figures."""
        whole, report = self.design, f"{self.folder}/report.html"
        figures = figure_names.paths(self.folder, figure_names.of_design(whole.spec["spec"]))
        files = {"data": self.data_path, "figures": f"{self.folder}/figures", "manifest": self.manifest}
        return Task(
            "design_report", whole.spec, files | {"out": report}, (report, *figures), (self.data_path,), whole.id,
            seconds=3.0, megabytes=2000,
        )  # fmt: skip

    def _tasks(self) -> Iterator[Task]:
        """Yield starts, Pareto fronts and runs in time from them, all of them together, the report."""
        yield from (*self.all_starts, *self.fronts.values())
        yield from filter(None, (self.verification, self.design, self.report))

    @property
    def _climate_file(self) -> dict[str, str]:
        """The file of its seas, by option."""
        return {"climate": self.loaded.climate_path}

    @property
    def _begun(self) -> dict[str, str]:
        """What follows the starts: the file of its seas and where they ended, by option."""
        return {**self._climate_file, "starts": f"{self.folder}/starts"}

    @property
    def identity(self) -> str:
        """Id of what is made of all starts together."""
        return self.design.id

    @property
    def data_path(self) -> str:
        """All results."""
        return f"{self.folder}/design.nc"


# any file -------------------------------------------------------------------------------------------------------------


MESHES = {".stl", ".obj", ".ply", ".gdf", ".vtk", ".vtp", ".vtu", ".msh", ".step", ".stp", ".igs", ".iges"}
"""Endings of files that hold a hull, not a study."""

Plan = StudyPlan | BodyPlan | CampaignPlan | DesignPlan


def planned(raw: dict[str, Any], source: str) -> Plan:
    """Return the plan of a file as nested mappings, its results folder, if not `results`, as `root`."""
    own = {key: value for key, value in raw.items() if key != "root"}
    return _plan(own, os.path.relpath(source), raw.get("root", "results"))


def plan_of(path: str, root: str = "results") -> Plan:
    """Return the plan of a study file, of a buoy or of a body, of a campaign file or of a design file.

    `root` is the folder of all results; shell modes have a degree, that given or that `modes.tolerance` needs.
    """
    if PurePath(path).suffix.lower() in MESHES:
        raise ConfigError(
            f"{path}: received a hull, needs a study of it: vsb init my.yaml --body writes one, in which mesh: "
            f"{PurePath(path).name} names the hull"
        )
    return _plan(read_yaml(path, "a study file such as config/buoy.yaml"), path, root)


def _plan(raw: object, source: str, root: str) -> Plan:
    """The plan of what a file holds."""
    if is_campaign(raw):
        return CampaignPlan(read(raw, source), root=root).with_degree()
    if is_design(raw):
        return DesignPlan(read_design(raw, source), root=root)
    study, files = read_study(raw, source)
    return plan_for(study, root, files).with_degree()


def base_study(plan: Plan) -> Study:
    """Return the study of a plan, or the one a campaign or a design problem begins with."""
    return plan.study if isinstance(plan, AnyPlan) else plan.loaded.base


def degree_lines(plan: StudyPlan | CampaignPlan) -> list[str]:
    """Return what `vsb check` says of modes that are given: a doubt where the tolerance needs others."""
    study = base_study(plan)
    if not study.has_shell or not study.needs_bem or (degree := study.modes.degree) is None:
        return []
    needed, modes = plan.degree_needed, study.modes
    if needed is None or (modes.basis == "full" and degree >= needed):
        return []
    return [
        f"doubt        modes: {modes.basis}, degree {degree}, but modes.tolerance {modes.tolerance:g} needs "
        f"the full basis to about degree {needed}: what is left out is measured in the run and widens the "
        f"intervals, and beyond {500 * modes.tolerance:g} % of a power its answer is not valid"
    ]
