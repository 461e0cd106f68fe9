"""The tasks of any plan: one stage each, its specification, its files, what it needs and makes. Pure Python.

The rules of the workflow, a run in one process and the plan of a dry run all follow from this list.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from vsb.engine.hydro.bodies.body_file import PHYSICS, BodyFile
from vsb.engine.hydro.bodies.cost import panel_count, solve_resources
from vsb.engine.hydro.panel_solver import panel_solver
from vsb.keys.quantities import content_id
from vsb.pipeline import costs
from vsb.study import figure_names
from vsb.study.body import Body
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.design_plan import DesignPlan
from vsb.study.plan import AnyPlan, BodyPlan, StudyPlan
from vsb.study.plans import Plan
from vsb.study.specs import FrequenciesSpec, PanelsSpec


class Stage(NamedTuple):
    """What a task may do: the function `run_STAGE` of a module of `vsb.stages`."""

    rule: str  # of the workflow whose jobs do it
    module: str
    words: str


STAGES = {
    "modes": Stage("modes", "shell", "shell modes"),
    "display": Stage("meshes", "shell", "the shell deformed by each mode"),
    "green": Stage("green", "panels", "Green-function table of the panels"),
    "mesh": Stage("mesh", "panels", "mean wetted mesh"),
    "panels": Stage("panels", "panels", "a block of frequencies by panels"),
    "spectral": Stage("spectral", "water", "all frequencies by the spectral solver"),
    "deformed": Stage("cross_check", "panels", "meshes of the shell deformed by each mode"),
    "witness": Stage("cross_check", "panels", "panels and spectral solver on the deformed shells"),
    "frequencies": Stage("frequencies", "coefficients", "frequencies of the body"),
    "coefficients": Stage("coefficients", "coefficients", "hydro database of the body"),
    "database": Stage("database", "water", "hydro database"),
    "radiation": Stage("database", "frequency", "radiation memory"),
    "response": Stage("response", "frequency", "frequency response"),
    "ladder": Stage("response", "frequency", "control levels"),
    "simulate": Stage("simulate", "simulate", "motion in time"),
    "compare": Stage("results", "compare", "comparison and doubts"),
    "figures": Stage("results", "report", "figures"),
    "report": Stage("results", "report", "report"),
    "members": Stage("members", "campaign", "points over the year"),
    "verification": Stage("verification", "verification", "seas of the year in time"),
    "campaign": Stage("campaign", "campaign", "all points together"),
    "campaign_report": Stage("campaign", "campaign_report", "report"),
    "design_start": Stage("design_start", "design", "a search from one start"),
    "design_front": Stage("design_front", "design", "the best over the values of a limit"),
    "design_verification": Stage("design_verification", "design_verification", "the best buoys in time"),
    "design_results": Stage("design_results", "design_results", "the best buoys together"),
    "design_report": Stage("design_results", "design_report", "report"),
}
"""Stages in the order of the chain; the radiation memory of a body is made with its database."""


@dataclass(frozen=True)
class Task:
    """One stage at work."""

    stage: str
    spec: Any  # what it computes from; None of a stage without specification
    files: Mapping[str, str]  # by parameter of its function `run_STAGE`
    makes: tuple[str, ...]
    needs: tuple[str, ...] = ()  # files of other tasks; those of users stand in its specification by their contents
    id: str = ""  # content id that the files it makes carry; none of the Green-function table
    on_the_way: bool = False  # made for other tasks, and not missed once what these make is there
    seconds: float = 0.15  # CPU time it takes, without the start of a process
    megabytes: int = 1000
    minutes: int = 30

    @property
    def words(self) -> str:
        """What it does, and of several of its kind which."""
        which = PurePosixPath(self.makes[0]).stem if self.stage == "simulate" else ""
        return f"{STAGES[self.stage].words}{which and f' {which}'}"

    @property
    def handed(self) -> dict[str, Any]:
        """What a process of its own is handed over."""
        names = ("stage", "id", "spec", "files", "makes")
        return {name: getattr(self, name) for name in names}


def tasks(plan: Plan) -> list[Task]:
    """Return the tasks of a study, campaign or design problem, each after those whose files it needs.

    The plan keeps them: of thousands of points they take seconds.
    """
    known: dict[str, tuple[Task, ...]] = plan.__dict__
    if "_tasks" not in known:
        known["_tasks"] = tuple(_tasks(plan))
    return [*known["_tasks"]]


def _tasks(plan: Plan) -> Iterator[Task]:
    """The tasks of a plan."""
    if isinstance(plan, CampaignPlan):
        yield from _year(plan)
    elif isinstance(plan, DesignPlan):
        yield from _design(plan)
    else:
        yield from _body(plan) if isinstance(plan, BodyPlan) else _buoy(plan)
        if plan.study.needs_bem:
            yield from _coefficients(plan)
        yield from _runs(plan)
        yield from _answers(plan)


def file_ids(plan: Plan) -> dict[str, str]:
    """Return the content id that every file of a plan must carry, those made on the way included."""
    return {path: task.id for task in tasks(plan) if task.id for path in task.makes}


def products(plan: Plan) -> list[str]:
    """Return all files a run of a plan promises."""
    return [path for task in tasks(plan) if not task.on_the_way for path in task.makes]


def due(ordered: Sequence[Task], targets: Collection[str], stale: Collection[str] = ()) -> list[Task]:
    """Return the tasks that make what is wanted and missing or stale: targets, and what other such tasks need."""
    wanted, found = set(targets), []
    for task in reversed(ordered):
        if any(path in wanted and (path in stale or not Path(path).exists()) for path in task.makes):
            found.append(task)
            wanted.update(task.needs)
    return found[::-1]


# a buoy or a body ---------------------------------------------------------------------------------------------------


def _buoy(plan: StudyPlan) -> Iterator[Task]:
    """Shell modes and viewable meshes; the coefficients of the water by block, their cross-check and the database."""
    modes, folder = f"{plan.folder}/modes.nc", plan.display_folder
    display = {"out": folder, "manifest": f"{folder}/manifest.json"}  # beside them: studies share them
    yield Task("modes", plan.modes, {"out": modes}, (modes,), id=plan.modes_id)
    yield Task("display", plan.display, display, tuple(plan.display_paths), id=content_id(plan.display))
    if not plan.study.needs_bem:
        return
    yield from blocks(plan)
    if witness := plan.witness:
        meshes, out = tuple(plan.deformed_paths), plan.witness_files["witness"]
        files = {"meshes": str(PurePosixPath(meshes[0]).parent), "out": out}
        yield Task("deformed", witness.meshes, {"out": files["meshes"]}, meshes, id=content_id(witness.meshes))
        seconds = costs.witness_seconds(len(meshes), witness)
        yield Task("witness", witness, files, (out,), meshes, content_id(witness), seconds=seconds)
    out, solved = plan.database_path, tuple(map(plan.block_path, plan.bem_blocks.values()))
    files = {"blocks": plan.block_folder, "out": out}
    yield Task("database", plan.database, files, (out,), solved, content_id(plan.database))


def blocks(plan: StudyPlan) -> Iterator[Task]:
    """Return the tasks of all blocks of frequencies; by panels with their meshes and the Green-function table."""
    green = f"{plan.green_folder}.done"
    if plan.study.uses_panels:
        yield _green(plan)
    by_panels = [block for block in plan.bem_blocks.values() if isinstance(block, PanelsSpec)]
    for mesh, spec in {plan.mesh_path(block.mesh): block.mesh for block in by_panels}.items():
        yield Task("mesh", spec, {"out": mesh}, (mesh,), id=content_id(spec), on_the_way=True)
    for name, block in plan.bem_blocks.items():
        out, seconds = plan.block_path(block), costs.block_seconds(block)
        if isinstance(block, PanelsSpec):
            mesh = plan.mesh_path(block.mesh)
            files = {"mesh": mesh, "green": plan.green_folder, "out": out}
            yield Task("panels", block, files, (out,), (mesh, green), name, on_the_way=True, seconds=seconds)
        else:
            yield Task("spectral", block, {"out": out}, (out,), (), name, on_the_way=True, seconds=seconds)


def _green(plan: StudyPlan | BodyPlan) -> Task:
    """The Green-function table of panels."""
    green = f"{plan.green_folder}.done"
    files = {"folder": plan.green_folder, "out": green}
    return Task("green", None, files, (green,), on_the_way=True, seconds=costs.GREEN_SECONDS)


def _body(plan: BodyPlan) -> Iterator[Task]:
    """The hydro database of a body, solved or read."""
    apart = list[Task]()
    if plan.solves_panels:
        yield _green(plan)
        assert isinstance(plan.study.body.file, BodyFile)
        apart = list(frequencies(plan.study.body.file, plan.sources, plan.inputs, f"{plan.root}/hydro/bodies"))
    yield from apart
    yield _database_of_body(plan, apart)


def frequencies(
    file: BodyFile, sources: Mapping[str, str], inputs: Sequence[str], folder: str | Path
) -> Iterator[Task]:
    """Return tasks that solve the frequencies of a body, if they take long; none of an adaptive sweep is known.

    Parameters
    ----------
    file : BodyFile
    sources : mapping of str
        Paths of the files of the body, by key; where blocks and the Green function's table are.
    inputs : sequence of str
        Files they need.
    folder : str or Path
        Where it is noted that they are solved.
    """
    memory, minutes = solve_resources(file, sources)
    seconds = costs.body_seconds(file, costs.matrices_seconds(file, panel_count(file, sources)))
    most = min(len(file.omega), costs.MOST_OF_FREQUENCIES)
    count = min(most, int(seconds / costs.FREQUENCIES_SECONDS)) if file.tolerance is None else 0
    for first in range(count if count > 1 else 0):
        omega = (*file.omega, math.inf)[first::count]
        spec = FrequenciesSpec(body=Body(file=file), omega=omega, solver=panel_solver(), solved=PHYSICS)
        out = f"{folder}/{content_id(spec)}.done"
        yield Task(
            "frequencies", spec, {**sources, "out": out}, (out,), tuple(inputs), on_the_way=True,
            seconds=seconds * len(omega) / len(file.omega), megabytes=memory, minutes=minutes,
        )  # fmt: skip


def _database_of_body(plan: BodyPlan, solved: Sequence[Task] = ()) -> Task:
    """The hydro database of a body alone, and of which frequencies it finds solved."""
    out, apart = plan.database_path, tuple(path for task in solved for path in task.makes)
    files, needs, identity = {**plan.sources, "out": out}, (*plan.inputs, *apart), content_id(plan.database)
    task = Task("coefficients", plan.database, files, (out,), needs, identity, seconds=1.0 if apart else 0.5)
    if isinstance(file := plan.study.body.file, BodyFile):
        memory, minutes = solve_resources(file, plan.files)
        matrices = costs.matrices_seconds(file, panel_count(file, plan.files))
        seconds = task.seconds if apart else costs.body_seconds(file, matrices)
        return replace(task, seconds=seconds, megabytes=memory, minutes=minutes)
    return replace(task, megabytes=4000)


def _radiation(plan: AnyPlan) -> Task:
    """The radiation memory of a hydro database."""
    read, out = plan.database_path, plan.radiation_path
    files = {"database": read, "out": out}
    identity = content_id(plan.radiation)
    return Task("radiation", plan.radiation, files, (out,), (read,), identity, seconds=costs.MEMORY_SECONDS)


def _coefficients(plan: AnyPlan) -> Iterator[Task]:
    """What follows from the hydro database alone."""
    stored = plan.database_path
    response, ladder = plan.response_files["response"], f"{plan.folder}/ladder.csv"
    levels = plan.ladder_files["levels"]
    read = {"database": stored}
    yield _radiation(plan)
    files = {**read, "out": response}
    yield Task("response", plan.response, files, (response,), (stored,), plan.response_id, seconds=0.8)
    files = {**read, "out": ladder, "levels": levels, "manifest": plan.manifest}
    seconds = costs.ladder_seconds(plan.study)
    yield Task("ladder", plan.ladder, files, (ladder, levels), (stored,), plan.ladder_id, seconds=seconds)


def _runs(plan: AnyPlan) -> Iterator[Task]:
    """One run in time per design and sea."""
    hydro = plan.hydro_files
    for wave in plan.study.waves:
        memory = plan.simulation_megabytes(wave)
        for design, one in plan.study.designs.items():
            seconds = costs.run_seconds(plan.study, wave, flexible=one.flexible)
            spec, out = plan.simulation(design, wave), plan.trajectory_path(design, wave.label)
            files, needs, identity = {**hydro, "out": out}, tuple(hydro.values()), plan.trajectory_id(design, wave)
            yield Task("simulate", spec, files, (out,), needs, identity, seconds=seconds, megabytes=memory)


def _answers(plan: AnyPlan) -> Iterator[Task]:
    """Tables, figures, report."""
    folder, study, memory = plan.folder, plan.study, plan.study_megabytes
    files = {**plan.hydro_files, **plan.response_files, **plan.witness_files}
    runs = tuple(plan.trajectory_path(design, wave.label) for wave in study.waves for design in study.designs)
    read = (*files.values(), *runs)
    files |= {"trajectories": f"{folder}/trajectories", "manifest": plan.manifest}
    tables = {
        "out": f"{folder}/comparison.csv",
        "statistics": f"{folder}/statistics.csv",
        "validity": f"{folder}/validity.json",
        "study": f"{folder}/study.json",
        "tables": f"{folder}/tables.json",
    }
    levels = plan.ladder_files
    needs = (*read, *levels.values())
    compared, whole = files | levels | tables, plan.identity
    made = tuple(tables.values())
    once, each = costs.COMPARED_SECONDS
    seconds = once + each * len(runs)
    yield Task("compare", plan.comparison, compared, made, needs, whole, seconds=seconds, megabytes=memory)
    figures = tuple(figure_names.paths(folder, plan.figures))
    needs, seconds = (*read, *plan.modes_files.values()), costs.FIGURE_SECONDS * len(figures)
    drawn = {**files, **plan.modes_files, "out": f"{folder}/figures"}
    yield Task("figures", study, drawn, figures, needs, whole, seconds=seconds, megabytes=memory)
    report, shown = f"{folder}/report.html", {"tables": tables["tables"], "figures": f"{folder}/figures"}
    files, needs = {**files, **plan.modes_files, **shown, "out": report}, (*needs, shown["tables"], *figures)
    once, each = costs.REPORTED_SECONDS
    seconds = once + each * len(runs)
    yield Task("report", study, files, (report,), needs, whole, seconds=seconds, megabytes=memory)


# a campaign ---------------------------------------------------------------------------------------------------------


def _year(plan: CampaignPlan) -> Iterator[Task]:
    """Databases of bodies, batches of members, their runs in time, all of them together, the report."""
    climate, folder, bodies = plan.loaded.climate_path, plan.folder, plan.bodies
    read = {"climate": climate, "root": plan.root}
    yield from {one.green_folder: _green(one) for one in bodies.values() if one.solves_panels}.values()
    yield from (replace(_database_of_body(one), on_the_way=True) for one in bodies.values())
    databases = tuple(one.database_path for one in bodies.values())
    for name, batch in plan.batches.items():
        files, out = {**read, "folder": f"{folder}/members"}, plan.batch_path(name)
        own, minutes = plan.members_by_batch[name], plan.batch_minutes
        seconds, memory = costs.members_seconds(plan, own), 2000 + 2 * plan.megabytes(len(own))
        yield Task(
            "members", batch, {**files, "out": out}, (out,), databases, name,
            seconds=seconds, megabytes=memory, minutes=minutes,
        )  # fmt: skip
    if plan.verifications:
        yield from (replace(_radiation(one), on_the_way=True) for one in bodies.values())
    memories = tuple(one.radiation_path for one in bodies.values())
    for name, verification in plan.verifications.items():
        files, out = {**read, "out": plan.verification_path(name)}, plan.verification_path(name)
        seconds = costs.verification_seconds(verification)
        yield Task(
            "verification", verification, files, (out,), memories, name, seconds=seconds, megabytes=2000, minutes=240
        )
    data, table, stamps, whole = plan.data_path, plan.table_path, {"manifest": plan.manifest}, plan.identity
    files = {"batches": f"{folder}/batches", "verifications": f"{folder}/verification", "out": data, "table": table}
    files, needs = {**files, **stamps}, (*plan.batch_paths, *plan.verification_paths)
    memory, seconds = 2000 + plan.megabytes(len(plan.members)), 1e-3 * len(plan.members)
    yield Task("campaign", plan.campaign, files, (data, table), needs, whole, seconds=0.3 + seconds, megabytes=memory)
    report = f"{folder}/report.html"
    files = {**read, "data": data, "figures": f"{folder}/figures", "out": report, **stamps}
    made = (report, *plan.figure_paths)
    seconds += 3.0
    yield Task("campaign_report", plan.campaign, files, made, (data,), whole, seconds=seconds, megabytes=memory)


# a design problem ---------------------------------------------------------------------------------------------------


def _design(plan: DesignPlan) -> Iterator[Task]:
    """Starts, Pareto fronts and runs in time from them, all of them together, the report."""
    folder, read, whole = plan.folder, {"climate": plan.loaded.climate_path}, plan.identity
    for starts, seconds in ((plan.starts, costs.START_SECONDS), (plan.rigid_starts, costs.RIGID_START_SECONDS)):
        for name, start in starts.items():
            out = plan.start_path(name)
            files = {**read, "out": out}
            yield Task("design_start", start, files, (out,), (), name, seconds=seconds, minutes=120)
    begun = {**read, "starts": f"{folder}/starts"}
    for name, front in plan.fronts.items():
        out, needs = plan.front_path(name), tuple(map(plan.start_path, front.starts))
        files, seconds = {**begun, "out": out}, costs.START_SECONDS
        yield Task("design_front", front, files, (out,), needs, name, seconds=seconds, minutes=240)
    found = tuple(plan.start_paths)
    for out in plan.verification_paths:
        files, spec = {**begun, "root": plan.root, "out": out}, plan.verification
        identity = content_id(spec)
        yield Task(
            "design_verification", spec, files, (out,), found, identity, seconds=60.0, minutes=600, megabytes=2000
        )
    tables = tuple(plan.tables.values())
    files = {**begun, "fronts": f"{folder}/fronts", "verifications": f"{folder}/verification", "folder": folder}
    files["manifest"] = plan.manifest
    needs = (*found, *plan.front_paths, *plan.verification_paths)
    yield Task("design_results", plan.design, files, tables, needs, whole, seconds=8.0, megabytes=2000)
    report, data = f"{folder}/report.html", plan.tables["design.nc"]
    files = {"data": data, "figures": f"{folder}/figures", "out": report, "manifest": plan.manifest}
    made = (report, *plan.figure_paths)
    yield Task("design_report", plan.design, files, made, (data,), whole, seconds=3.0, megabytes=2000)
