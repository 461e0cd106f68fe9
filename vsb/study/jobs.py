"""The jobs of any plan: one stage each, its specification, its files, what it needs and makes. Pure Python.

The workflow's rules, a run in one process and the plan of a dry run all follow from this list.
"""

import re
import shlex
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any

from vsb.study import figure_names
from vsb.study.body import BodyFile
from vsb.study.body_cost import solve_resources
from vsb.study.campaign_plan import CampaignPlan
from vsb.study.design_plan import DesignPlan
from vsb.study.plan import AnyPlan, BodyPlan, StudyPlan, degree_path
from vsb.study.plans import Plan
from vsb.study.quantities import canonical
from vsb.study.specs import PanelsSpec

IN_SECONDS = ("modes", "display", "mesh", "deformed")
"""Stages of a second or less: on a cluster they run where `vsb run` does."""


@dataclass(frozen=True)
class Job:
    """One stage at work."""

    stage: str
    spec: Any  # what it computes from; None of a stage without specification
    files: Mapping[str, str]  # by option of its command
    makes: tuple[str, ...]
    needs: tuple[str, ...] = ()  # files of other jobs; those of users stand in its specification by their contents
    name: str = ""  # part of the path of the only file it makes, where a stage may have several jobs
    megabytes: int = 1000
    minutes: int = 30

    @property
    def text(self) -> str:
        """Its specification as canonical JSON, which its command reads from standard input; `null` if it has none."""
        return canonical(self.spec)

    @property
    def options(self) -> str:
        """Options of its command; a path may begin with '-'."""
        return " ".join(f"--{option}={shlex.quote(path)}" for option, path in self.files.items())


@dataclass(frozen=True)
class Rule:
    """All jobs of one stage, as Snakemake's rule: where there may be several the wildcard `job` is their name."""

    stage: str
    jobs: Mapping[str, Job]  # by name
    plan: Plan

    @property
    def names(self) -> str:
        """Names of its jobs as a regular expression."""
        return "|".join(map(re.escape, self.jobs))

    @property
    def makes(self) -> list[str]:
        """Files it makes."""
        name, job = next(iter(self.jobs.items()))
        if not name:
            return list(job.makes)
        folder, _, ending = job.makes[0].rpartition(name)  # the folder of the study may be called as a job is
        return [f"{folder}{{job}}{ending}"]

    def record(self, kind: str) -> str:
        """Return the name of a record of a job: `logs` or `benchmarks`."""
        folder, ending = f"{self.plan.root}/{kind}/{self.stage}", {"logs": "log", "benchmarks": "tsv"}[kind]
        return f"{folder}/{self.plan.name}{'-{job}' if '' not in self.jobs else ''}.{ending}"

    # functions of wildcards, which Snakemake asks --------------------------------------------------------------------

    def job(self, wildcards: Any) -> Job:
        """Return the job of a file."""
        return self.jobs[getattr(wildcards, "job", "")]

    def needs(self, wildcards: Any) -> list[str]:
        """Return the files a job needs."""
        return list(self.job(wildcards).needs)

    def options(self, wildcards: Any, output: Any) -> str:
        """Return the options of a job's command, which Snakemake does not compare between runs, for `output` is asked.

        Studies that share meshes record them in manifests of their own.
        """
        return self.job(wildcards).options

    def text(self, wildcards: Any) -> str:
        """Return the specification of a job."""
        return self.job(wildcards).text

    def megabytes(self, wildcards: Any) -> int:
        """Return the memory a job may take [MB]."""
        return self.job(wildcards).megabytes

    def minutes(self, wildcards: Any) -> int:
        """Return how long a job may take [min]."""
        return self.job(wildcards).minutes


def rules(plan: Plan) -> list[Rule]:
    """Return the rules of a study or campaign, in the order of the workflow."""
    found: dict[str, dict[str, Job]] = {}
    for job in jobs(plan):
        found.setdefault(job.stage, {})[job.name] = job
    return [Rule(stage, some, plan) for stage, some in found.items()]


def jobs(plan: Plan) -> list[Job]:
    """Return the jobs of a study or campaign, each after those whose files it needs."""
    if isinstance(plan, CampaignPlan):
        return [*_year(plan)]
    if isinstance(plan, DesignPlan):
        return [*_design(plan)]
    if isinstance(plan, BodyPlan):
        return [*_body(plan), *_coefficients(plan), *_runs(plan), *_answers(plan)]
    if not plan.study.needs_bem:
        return [*_shell(plan), *_runs(plan), *_answers(plan)]
    solved = [*blocks(plan), *_witness(plan), *_database(plan), *_coefficients(plan)]
    return [*_shell(plan), *solved, *_runs(plan), *_answers(plan)]


def due(ordered: Sequence[Job], targets: Collection[str], stale: Collection[str] = ()) -> list[Job]:
    """Return the jobs that make what is wanted and missing or stale: targets, and what other such jobs need."""
    wanted, found = set(targets), []
    for job in reversed(ordered):
        if any(path in wanted and (path in stale or not Path(path).exists()) for path in job.makes):
            found.append(job)
            wanted.update(job.needs)
    return found[::-1]


# a buoy or a body ---------------------------------------------------------------------------------------------------


def _body(plan: BodyPlan) -> Iterator[Job]:
    """The hydro database of a body, solved or read."""
    if plan.solves_panels:
        yield _green(plan)
    yield _database_of_body(plan)


def _database_of_body(plan: BodyPlan) -> Job:
    """The hydro database of a body alone."""
    out = plan.database_path
    files, name = {**plan.sources, "out": out}, PurePosixPath(out).stem
    job = Job("coefficients", plan.database, files, (out,), tuple(plan.inputs), name, megabytes=4000)
    if isinstance(file := plan.study.body.file, BodyFile):
        memory, minutes = solve_resources(file, plan.files)
        job = replace(job, megabytes=memory, minutes=minutes)
    return job


def _shell(plan: StudyPlan) -> Iterator[Job]:
    """Shell modes and viewable meshes."""
    modes, folder = f"{plan.folder}/modes.nc", plan.display_folder
    display = {"out": folder, "manifest": f"{folder}/manifest.json"}  # beside them: studies share them
    yield Job("modes", plan.modes, {"out": modes}, (modes,))
    yield Job("display", plan.display, display, tuple(plan.display_paths))


def _green(plan: StudyPlan | BodyPlan) -> Job:
    """The Green-function table of panels."""
    green = f"{plan.green_folder}.done"
    return Job("green", None, {"folder": plan.green_folder, "out": green}, (green,))


def blocks(plan: StudyPlan) -> Iterator[Job]:
    """Return the jobs of all blocks of frequencies; by panels with their meshes and the Green-function table."""
    green = f"{plan.green_folder}.done"
    if plan.study.uses_panels:
        yield _green(plan)
    by_panels = [block for block in plan.bem_blocks.values() if isinstance(block, PanelsSpec)]
    for mesh, spec in {plan.mesh_path(block.mesh): block.mesh for block in by_panels}.items():
        yield Job("mesh", spec, {"out": mesh}, (mesh,), name=PurePosixPath(mesh).parent.name)
    for name, block in plan.bem_blocks.items():
        out = plan.block_path(block)
        if isinstance(block, PanelsSpec):
            mesh = plan.mesh_path(block.mesh)
            files = {"mesh": mesh, "green": plan.green_folder, "out": out}
            yield Job("panels", block, files, (out,), (mesh, green), name)
        else:
            yield Job("spectral", block, {"out": out}, (out,), name=name)


def _witness(plan: StudyPlan) -> Iterator[Job]:
    """The second solver."""
    if plan.witness:
        meshes, out = tuple(plan.deformed_paths), plan.witness_files["witness"]
        files = {"meshes": str(PurePosixPath(meshes[0]).parent), "out": out}
        yield Job("deformed", plan.witness.meshes, {"out": files["meshes"]}, meshes)
        yield Job("witness", plan.witness, files, (out,), meshes)


def _database(plan: StudyPlan) -> Iterator[Job]:
    """The hydro database of a buoy."""
    stored, solved = plan.database_path, tuple(map(plan.block_path, plan.bem_blocks.values()))
    yield Job("database", plan.database, {"blocks": plan.block_folder, "out": stored}, (stored,), solved)


def _radiation(plan: AnyPlan) -> Job:
    """The radiation memory of a hydro database."""
    stored, out = plan.database_path, plan.radiation_path
    return Job(
        "radiation", plan.radiation, {"database": stored, "out": out}, (out,), (stored,), PurePosixPath(out).stem
    )


def _coefficients(plan: AnyPlan) -> Iterator[Job]:
    """What follows from the hydro database alone."""
    stored = plan.database_path
    response, ladder = plan.response_files["response"], f"{plan.folder}/ladder.csv"
    levels = plan.ladder_files["levels"]
    read = {"database": stored}
    yield _radiation(plan)
    yield Job("response", plan.response, {**read, "out": response}, (response,), (stored,))
    climbed = {**read, "out": ladder, "levels": levels, "manifest": plan.manifest}
    if isinstance(plan, StudyPlan):
        climbed["degrees"] = degree_path(plan.root, plan.degree)
    yield Job("ladder", plan.ladder, climbed, (ladder, levels), (stored,))


def _runs(plan: AnyPlan) -> Iterator[Job]:
    """One run in time per design and sea."""
    hydro = plan.hydro_files
    for wave in plan.study.waves:
        for design in plan.study.designs:
            out = plan.trajectory_path(design, wave.label)
            spec, needs, name = plan.simulation(design, wave), tuple(hydro.values()), PurePosixPath(out).stem
            memory = plan.simulation_megabytes(wave)
            yield Job("simulate", spec, {**hydro, "out": out}, (out,), needs, name, megabytes=memory)


def _answers(plan: AnyPlan) -> Iterator[Job]:
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
    yield Job("compare", plan.comparison, files | levels | tables, tuple(tables.values()), needs, megabytes=memory)
    figures = tuple(figure_names.paths(folder, plan.figures))
    needs = (*read, *plan.modes_files.values())
    drawn = {**files, **plan.modes_files, "out": f"{folder}/figures"}
    yield Job("figures", study, drawn, figures, needs, megabytes=memory)
    report, shown = f"{folder}/report.html", {"tables": tables["tables"], "figures": f"{folder}/figures"}
    files = {**files, **plan.modes_files, **shown, "out": report}
    yield Job("report", study, files, (report,), (*needs, shown["tables"], *figures), megabytes=memory)


# a campaign ---------------------------------------------------------------------------------------------------------


def _year(plan: CampaignPlan) -> Iterator[Job]:
    """Databases of bodies, batches of members, their runs in time, all of them together, the report."""
    climate, folder, bodies = plan.loaded.climate_path, plan.folder, plan.bodies
    read = {"climate": climate, "root": plan.root}
    yield from {one.green_folder: _green(one) for one in bodies.values() if one.solves_panels}.values()
    yield from map(_database_of_body, bodies.values())
    databases = {name: one.database_path for name, one in bodies.items()}
    for name, batch in plan.batches.items():
        out = plan.batch_path(name)
        files, needs = {**read, "folder": f"{folder}/members", "out": out}, tuple(databases.values())
        yield Job("members", batch, files, (out,), needs, name, megabytes=2000, minutes=plan.batch_minutes)
    if plan.verifications:
        yield from map(_radiation, bodies.values())
    for name, verification in plan.verifications.items():
        out = plan.verification_path(name)
        files, needs = {**read, "out": out}, tuple(one.radiation_path for one in bodies.values())
        yield Job("verification", verification, files, (out,), needs, name, megabytes=2000, minutes=240)
    data, table, stamps = plan.data_path, plan.table_path, {"manifest": plan.manifest}
    files = {"batches": f"{folder}/batches", "verifications": f"{folder}/verification", "out": data, "table": table}
    needs = (*plan.batch_paths, *plan.verification_paths)
    yield Job("campaign", plan.campaign, {**files, **stamps}, (data, table), needs, megabytes=4000)
    report = f"{folder}/report.html"
    files = {**read, "data": data, "figures": f"{folder}/figures", "out": report, **stamps}
    yield Job("campaign_report", plan.campaign, files, (report, *plan.figure_paths), (data,), megabytes=4000)


# a design problem ---------------------------------------------------------------------------------------------------


def _design(plan: DesignPlan) -> Iterator[Job]:
    """Starts, Pareto fronts and runs in time from them, all of them together, the report."""
    climate, folder = plan.loaded.climate_path, plan.folder
    starts, read = f"{folder}/starts", {"climate": climate}
    for name, start in (plan.starts | plan.rigid_starts).items():
        out = plan.start_path(name)
        yield Job("design_start", start, {**read, "out": out}, (out,), (), name, minutes=120)
    begun = {**read, "starts": starts}
    for name, front in plan.fronts.items():
        out, needs = plan.front_path(name), tuple(map(plan.start_path, front.starts))
        yield Job("design_front", front, {**begun, "out": out}, (out,), needs, name, minutes=240)
    found = tuple(plan.start_paths)
    for out in plan.verification_paths:
        files = {**begun, "root": plan.root, "out": out}
        yield Job("design_verification", plan.verification, files, (out,), found, minutes=600, megabytes=2000)
    tables = tuple(plan.tables.values())
    files = {**begun, "fronts": f"{folder}/fronts", "verifications": f"{folder}/verification", "folder": folder}
    needs = (*found, *plan.front_paths, *plan.verification_paths)
    yield Job("design_results", plan.design, {**files, "manifest": plan.manifest}, tables, needs, megabytes=2000)
    report = f"{folder}/report.html"
    files = {"data": plan.tables["design.nc"], "figures": f"{folder}/figures", "out": report, "manifest": plan.manifest}
    needs = (plan.tables["design.nc"],)
    yield Job("design_report", plan.design, files, (report, *plan.figure_paths), needs, megabytes=2000)


# Snakemake's own report ---------------------------------------------------------------------------------------------

_SHOWN = {
    "comparison.csv": ("comparison", "Numbers", {"table": "designs side by side"}),
    "statistics.csv": ("statistics", "Numbers", {"table": "irregular seas"}),
    "validity.json": ("validity", "What to doubt", {"table": "ledger"}),
    "ladder.csv": ("ladder", "Numbers", {"table": "control levels"}),
    "starts.csv": ("starts", "Numbers", {"table": "where every start ended"}),
    "budget.csv": ("budget", "Numbers", {"table": "what the gain is uncertain by"}),
    "campaign.csv": ("campaign_table", "Numbers", {"table": "every point, design and tuning"}),
    "report.html": ("report", "The answer", {"page": "report"}),
}
"""Products in Snakemake's report: caption, category, labels."""


def shown(path: str, plan: Plan) -> dict[str, Any]:
    """Return how a product stands in Snakemake's report: options of its function `report`; empty if it does not."""
    file = PurePosixPath(path)
    of = "" if plan.KIND == "study" else f"{plan.KIND}_"
    if file.name in _SHOWN:
        caption, category, labels = _SHOWN[file.name]
        prefix = of if file.name == "report.html" else ""
        return {"caption": f"report/{prefix}{caption}.rst", "category": category, "labels": labels}
    if file.parent.name != "figures" or file.suffix != ".svg":
        return {}
    name, _, wave = file.stem.partition("-")
    found = {"category": "Figures", "labels": {"figure": name.replace("_", " ")}}
    if of:
        return {**found, "caption": f"report/{of}figures.rst"}
    return {**found, "caption": "report/figures.rst", "subcategory": wave or "the whole band"}
