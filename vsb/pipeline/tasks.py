"""The tasks of any plan: one stage each, its specification, its files, what it needs and makes. Pure Python.

The rules of the workflow, a run in one process and the plan of a dry run all follow from this list.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any

from vsb.pipeline import costs
from vsb.study import figure_names
from vsb.study.body import BodyFile
from vsb.study.body_cost import panel_count, solve_resources
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.design_plan import DesignPlan
from vsb.study.plan import AnyPlan, BodyPlan, StudyPlan, degree_path
from vsb.study.plans import Plan
from vsb.study.quantities import id_in
from vsb.study.specs import PanelsSpec

WORDS = {
    "modes": "shell modes", "display": "the shell deformed by each mode", "green": "Green-function table of the panels",
    "mesh": "mean wetted mesh", "panels": "a block of frequencies by panels",
    "spectral": "all frequencies by the spectral solver", "deformed": "meshes of the shell deformed by each mode",
    "witness": "panels and spectral solver on the deformed shells", "coefficients": "hydro database of the body",
    "database": "hydro database", "radiation": "radiation memory", "response": "frequency response",
    "ladder": "control levels", "simulate": "motion in time", "compare": "comparison and doubts",
    "figures": "figures", "report": "report", "members": "points over the year",
    "verification": "seas of the year in time", "campaign": "all points together", "campaign_report": "report",
    "design_start": "a search from one start", "design_front": "the best over the values of a limit",
    "design_verification": "the best buoys in time", "design_results": "the best buoys together",
    "design_report": "report",
}  # fmt: skip
"""What each stage does."""


@dataclass(frozen=True)
class Task:
    """One stage at work."""

    stage: str
    spec: Any  # what it computes from; None of a stage without specification
    files: Mapping[str, str]  # by parameter of its function `run_STAGE`
    makes: tuple[str, ...]
    needs: tuple[str, ...] = ()  # files of other tasks; those of users stand in its specification by their contents
    id: str = ""  # content id that the files it makes carry; none of the Green-function table
    seconds: float = 0.15  # CPU time it takes, without the start of a process
    megabytes: int = 1000
    minutes: int = 30

    @property
    def words(self) -> str:
        """What it does, and of several of its kind which."""
        which = PurePosixPath(self.makes[0]).stem if self.stage == "simulate" else ""
        return f"{WORDS[self.stage]}{which and f' {which}'}"

    @property
    def handed(self) -> dict[str, Any]:
        """What a process of its own is handed over."""
        names = ("stage", "id", "spec", "files", "makes")
        return {name: getattr(self, name) for name in names}


def tasks(plan: Plan) -> list[Task]:
    """Return the tasks of a study, campaign or design problem, each after those whose files it needs."""
    ids = plan.ids
    return [replace(task, id=ids.get(task.makes[0], id_in(task.makes[0]))) if task.spec else task for task in _of(plan)]


def _of(plan: Plan) -> Iterator[Task]:
    """The tasks of a plan in their order."""
    if isinstance(plan, CampaignPlan):
        yield from _year(plan)
    elif isinstance(plan, DesignPlan):
        yield from _design(plan)
    else:
        if isinstance(plan, BodyPlan):
            yield from _body(plan)
        else:
            yield from _buoy(plan)
        if plan.study.needs_bem:
            yield from _coefficients(plan)
        yield from (*_runs(plan), *_answers(plan))


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
    yield Task("modes", plan.modes, {"out": modes}, (modes,))
    yield Task("display", plan.display, display, tuple(plan.display_paths))
    if not plan.study.needs_bem:
        return
    yield from blocks(plan)
    if witness := plan.witness:
        meshes, out = tuple(plan.deformed_paths), plan.witness_files["witness"]
        files = {"meshes": str(PurePosixPath(meshes[0]).parent), "out": out}
        yield Task("deformed", witness.meshes, {"out": files["meshes"]}, meshes)
        seconds = costs.witness_seconds(len(meshes), witness)
        yield Task("witness", witness, files, (out,), meshes, seconds=seconds)
    out, solved = plan.database_path, tuple(map(plan.block_path, plan.bem_blocks.values()))
    yield Task("database", plan.database, {"blocks": plan.block_folder, "out": out}, (out,), solved)


def blocks(plan: StudyPlan) -> Iterator[Task]:
    """Return the tasks of all blocks of frequencies; by panels with their meshes and the Green-function table."""
    green = f"{plan.green_folder}.done"
    if plan.study.uses_panels:
        yield _green(plan)
    by_panels = [block for block in plan.bem_blocks.values() if isinstance(block, PanelsSpec)]
    for mesh, spec in {plan.mesh_path(block.mesh): block.mesh for block in by_panels}.items():
        yield Task("mesh", spec, {"out": mesh}, (mesh,))
    for block in plan.bem_blocks.values():
        out, seconds = plan.block_path(block), costs.block_seconds(block)
        if isinstance(block, PanelsSpec):
            mesh = plan.mesh_path(block.mesh)
            files = {"mesh": mesh, "green": plan.green_folder, "out": out}
            yield Task("panels", block, files, (out,), (mesh, green), seconds=seconds)
        else:
            yield Task("spectral", block, {"out": out}, (out,), seconds=seconds)


def _green(plan: StudyPlan | BodyPlan) -> Task:
    """The Green-function table of panels."""
    green = f"{plan.green_folder}.done"
    return Task("green", None, {"folder": plan.green_folder, "out": green}, (green,), seconds=20.0)


def _body(plan: BodyPlan) -> Iterator[Task]:
    """The hydro database of a body, solved or read."""
    if plan.solves_panels:
        yield _green(plan)
    yield _database_of_body(plan)


def _database_of_body(plan: BodyPlan) -> Task:
    """The hydro database of a body alone."""
    out = plan.database_path
    task = Task("coefficients", plan.database, {**plan.sources, "out": out}, (out,), tuple(plan.inputs), seconds=0.5)
    if isinstance(file := plan.study.body.file, BodyFile):
        memory, minutes = solve_resources(file, plan.files)
        seconds = costs.body_seconds(file, panel_count(file, plan.files))
        return replace(task, seconds=seconds, megabytes=memory, minutes=minutes)
    return replace(task, megabytes=4000)


def _radiation(plan: AnyPlan) -> Task:
    """The radiation memory of a hydro database."""
    read, out = plan.database_path, plan.radiation_path
    files = {"database": read, "out": out}
    return Task("radiation", plan.radiation, files, (out,), (read,), seconds=costs.MEMORY_SECONDS)


def _coefficients(plan: AnyPlan) -> Iterator[Task]:
    """What follows from the hydro database alone."""
    stored = plan.database_path
    response, ladder = plan.response_files["response"], f"{plan.folder}/ladder.csv"
    levels = plan.ladder_files["levels"]
    read = {"database": stored}
    yield _radiation(plan)
    yield Task("response", plan.response, {**read, "out": response}, (response,), (stored,), seconds=0.8)
    files = {**read, "out": ladder, "levels": levels, "manifest": plan.manifest}
    if isinstance(plan, StudyPlan):
        files["degrees"] = degree_path(plan.root, plan.degree)
    yield Task("ladder", plan.ladder, files, (ladder, levels), (stored,), seconds=0.5)


def _runs(plan: AnyPlan) -> Iterator[Task]:
    """One run in time per design and sea."""
    hydro = plan.hydro_files
    for wave in plan.study.waves:
        seconds, memory = costs.run_seconds(plan.study, wave), plan.simulation_megabytes(wave)
        for design in plan.study.designs:
            spec, out = plan.simulation(design, wave), plan.trajectory_path(design, wave.label)
            needs = tuple(hydro.values())
            yield Task("simulate", spec, {**hydro, "out": out}, (out,), needs, seconds=seconds, megabytes=memory)


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
    compared = files | levels | tables
    yield Task("compare", plan.comparison, compared, tuple(tables.values()), needs, seconds=0.5, megabytes=memory)
    figures = tuple(figure_names.paths(folder, plan.figures))
    needs, seconds = (*read, *plan.modes_files.values()), costs.FIGURE_SECONDS * len(figures)
    drawn = {**files, **plan.modes_files, "out": f"{folder}/figures"}
    yield Task("figures", study, drawn, figures, needs, seconds=seconds, megabytes=memory)
    report, shown = f"{folder}/report.html", {"tables": tables["tables"], "figures": f"{folder}/figures"}
    files, needs = {**files, **plan.modes_files, **shown, "out": report}, (*needs, shown["tables"], *figures)
    yield Task("report", study, files, (report,), needs, seconds=1.5, megabytes=memory)


# a campaign ---------------------------------------------------------------------------------------------------------


def _year(plan: CampaignPlan) -> Iterator[Task]:
    """Databases of bodies, batches of members, their runs in time, all of them together, the report."""
    climate, folder, bodies = plan.loaded.climate_path, plan.folder, plan.bodies
    read = {"climate": climate, "root": plan.root}
    yield from {one.green_folder: _green(one) for one in bodies.values() if one.solves_panels}.values()
    yield from map(_database_of_body, bodies.values())
    databases = tuple(one.database_path for one in bodies.values())
    for name, batch in plan.batches.items():
        files, out = {**read, "folder": f"{folder}/members"}, plan.batch_path(name)
        seconds = costs.members_seconds(plan, plan.members_by_batch[name])
        minutes = plan.batch_minutes
        yield Task(
            "members", batch, {**files, "out": out}, (out,), databases,
            seconds=seconds, megabytes=2000, minutes=minutes,
        )  # fmt: skip
    if plan.verifications:
        yield from map(_radiation, bodies.values())
    memories = tuple(one.radiation_path for one in bodies.values())
    for name, verification in plan.verifications.items():
        out, seconds = plan.verification_path(name), costs.verification_seconds(verification)
        files = {**read, "out": out}
        yield Task("verification", verification, files, (out,), memories, seconds=seconds, megabytes=2000, minutes=240)
    data, table, stamps = plan.data_path, plan.table_path, {"manifest": plan.manifest}
    files = {"batches": f"{folder}/batches", "verifications": f"{folder}/verification", "out": data, "table": table}
    needs = (*plan.batch_paths, *plan.verification_paths)
    yield Task("campaign", plan.campaign, {**files, **stamps}, (data, table), needs, seconds=0.3, megabytes=4000)
    report = f"{folder}/report.html"
    files = {**read, "data": data, "figures": f"{folder}/figures", "out": report, **stamps}
    made = (report, *plan.figure_paths)
    yield Task("campaign_report", plan.campaign, files, made, (data,), seconds=3.0, megabytes=4000)


# a design problem ---------------------------------------------------------------------------------------------------


def _design(plan: DesignPlan) -> Iterator[Task]:
    """Starts, Pareto fronts and runs in time from them, all of them together, the report."""
    folder, read = plan.folder, {"climate": plan.loaded.climate_path}
    for starts, seconds in ((plan.starts, costs.START_SECONDS), (plan.rigid_starts, costs.RIGID_START_SECONDS)):
        for name, start in starts.items():
            out = plan.start_path(name)
            yield Task("design_start", start, {**read, "out": out}, (out,), seconds=seconds, minutes=120)
    begun = {**read, "starts": f"{folder}/starts"}
    for name, front in plan.fronts.items():
        out, needs = plan.front_path(name), tuple(map(plan.start_path, front.starts))
        seconds = costs.START_SECONDS
        yield Task("design_front", front, {**begun, "out": out}, (out,), needs, seconds=seconds, minutes=240)
    found = tuple(plan.start_paths)
    for out in plan.verification_paths:
        files, spec = {**begun, "root": plan.root, "out": out}, plan.verification
        yield Task("design_verification", spec, files, (out,), found, seconds=60.0, minutes=600, megabytes=2000)
    tables = tuple(plan.tables.values())
    files = {**begun, "fronts": f"{folder}/fronts", "verifications": f"{folder}/verification", "folder": folder}
    files["manifest"] = plan.manifest
    needs = (*found, *plan.front_paths, *plan.verification_paths)
    yield Task("design_results", plan.design, files, tables, needs, seconds=8.0, megabytes=2000)
    report, data = f"{folder}/report.html", plan.tables["design.nc"]
    files = {"data": data, "figures": f"{folder}/figures", "out": report, "manifest": plan.manifest}
    made = (report, *plan.figure_paths)
    yield Task("design_report", plan.design, files, made, (data,), seconds=3.0, megabytes=2000)
