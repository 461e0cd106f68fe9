"""A study in this process: its stages in the order of their inputs, finished files kept, without Snakemake."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vsb.stages.alone import alone, sharing
from vsb.stages.planning import with_degree
from vsb.stages.stage import STAGES
from vsb.stages.verify import stale_products
from vsb.study.body import LocatedBody
from vsb.study.body_plan import AnyPlan, BodyPlan
from vsb.study.plan import StudyPlan
from vsb.study.results_plan import figure_paths
from vsb.study.specs import PanelsSpec
from vsb.study.study import Study, canonical
from vsb.tools.files import check_folder

if TYPE_CHECKING:
    from vsb.stages.stored import Results


@dataclass(frozen=True)
class Job:
    """One stage at work: its specification, none where it has none, and its files."""

    stage: str
    spec: Any
    files: dict[str, str]  # by option, as on the command line
    makes: tuple[str, ...]
    needs: tuple[str, ...] = ()

    def run(self) -> None:
        """Run the stage on its specification as text, as a rule hands it over."""
        (stage,) = (stage for stage in STAGES if stage.name == self.stage)
        stage.run({**dict.fromkeys(stage.optional), **self.files}, canonical(self.spec) if self.spec else "")


def run(study: Study | LocatedBody, folder: str | Path = "results") -> "Results":
    """Run a whole study in this process: files and numbers are those of `vsb run`, finished ones are kept.

    Parameters
    ----------
    study : Study or LocatedBody
        See `vsb.load`, `vsb.load_body`.
    folder : str or Path
        Folder of all results; studies in it share their hydrodynamics.

    Raises
    ------
    VsbError
        If the study cannot be run, a check of its hydrodynamics fails, or another run is at work in the folder.
    """
    from vsb.stages.stored import Results

    plan = _checked(study, str(folder))
    check_folder(folder)
    with alone(Path(plan.folder)):
        make(plan, plan.products, stale=stale_products(plan, dry=False))
    return Results(plan.study, str(folder))


def _checked(study: Study | LocatedBody, root: str) -> AnyPlan:
    """The plan of a study after its checks."""
    if isinstance(study, LocatedBody):
        from vsb.stages.body_preview import body_before_run  # readers of meshes, which no buoy needs

        plan = BodyPlan(study.study, root=root, files=study.files)
        body_before_run(plan)
        return plan
    from vsb.stages.preview import check_before_run

    found = with_degree(StudyPlan(study, root=root))
    check_before_run(found.study, found)
    return found


def make(plan: AnyPlan, targets: Collection[str], stale: Collection[str] = ()) -> None:
    """Make files of a study, and what they need; those that are there, and not stale, are kept."""
    _run(plan, due(jobs(plan), targets, stale), stale)


def solve(plan: StudyPlan) -> None:
    """Solve the frequencies of a buoy's shape that are not there: what of a study a member of a campaign needs."""
    targets = [plan.block_path(block) for block in plan.sweep_blocks]
    if not all(Path(path).exists() for path in targets):
        _run(plan, due([*(_green(plan) if plan.study.uses_panels else []), *_blocks(plan)], targets))


def _run(plan: AnyPlan, some: Sequence[Job], stale: Collection[str] = ()) -> None:
    """Run jobs in their order, each alone at its shared files."""
    for job in some:
        with sharing(plan.root, filter(plan.is_shared, job.makes)):
            if not all(Path(path).exists() and path not in stale for path in job.makes):  # made meanwhile, by another
                job.run()


def due(ordered: Sequence[Job], targets: Collection[str], stale: Collection[str] = ()) -> list[Job]:
    """Return the jobs that make what is wanted and missing or stale: targets, and what other such jobs need."""
    wanted, found = set(targets), []
    for job in reversed(ordered):
        if any(path in wanted and (path in stale or not Path(path).exists()) for path in job.makes):
            found.append(job)
            wanted.update(job.needs)
    return found[::-1]


def jobs(plan: AnyPlan) -> list[Job]:
    """Return the jobs of a study, the rules of the workflow, each after those whose files it needs."""
    if isinstance(plan, BodyPlan):
        return [*_body(plan), *_coefficients(plan), *_runs(plan), *_answers(plan)]
    solved = [*_green(plan), *_blocks(plan), *_witness(plan), *_database(plan)] if plan.study.needs_bem else []
    coefficients = _coefficients(plan) if plan.study.needs_bem else []
    return [*_shell(plan), *solved, *coefficients, *_runs(plan), *_answers(plan)]


def _body(plan: BodyPlan) -> Iterator[Job]:
    """The hydro database of a body, solved or read."""
    if plan.solves:
        green = f"{plan.green_folder}.done"
        yield Job("green", None, {"folder": plan.green_folder, "out": green}, (green,))
    files = {**plan.sources, "out": plan.database_path}
    yield Job("coefficients", plan.database, files, (plan.database_path,), tuple(plan.inputs))


def _shell(plan: StudyPlan) -> Iterator[Job]:
    """Shell modes and viewable meshes."""
    modes, display = f"{plan.folder}/modes.nc", {"out": plan.display_folder, "manifest": plan.manifest}
    yield Job("modes", plan.modes, {"out": modes}, (modes,))
    yield Job("display", plan.display, display, tuple(plan.display_paths))


def _green(plan: StudyPlan) -> Iterator[Job]:
    """The Green-function table, where panels solve or vouch."""
    green = f"{plan.green_folder}.done"
    if plan.study.uses_panels or plan.witness:
        yield Job("green", None, {"folder": plan.green_folder, "out": green}, (green,))


def _blocks(plan: StudyPlan) -> Iterator[Job]:
    """Blocks of frequencies; their meshes if by panels."""
    green = f"{plan.green_folder}.done"
    by_panels = [block for block in plan.bem_blocks.values() if isinstance(block, PanelsSpec)]
    for mesh, spec in {plan.mesh_path(block.mesh): block.mesh for block in by_panels}.items():
        yield Job("mesh", spec, {"out": mesh}, (mesh,))
    for block in plan.bem_blocks.values():
        out = plan.block_path(block)
        if isinstance(block, PanelsSpec):
            mesh = plan.mesh_path(block.mesh)
            yield Job("panels", block, {"mesh": mesh, "green": plan.green_folder, "out": out}, (out,), (mesh, green))
        else:
            yield Job("spectral", block, {"out": out}, (out,))


def _witness(plan: StudyPlan) -> Iterator[Job]:
    """The second solver."""
    if plan.witness:
        meshes, out = tuple(plan.deformed_paths), plan.witness_files["witness"]
        files = {"meshes": str(Path(meshes[0]).parent), "green": plan.green_folder, "out": out}
        yield Job("deformed", plan.witness.meshes, {"out": files["meshes"]}, meshes)
        yield Job("witness", plan.witness, files, (out,), (*meshes, f"{plan.green_folder}.done"))


def _database(plan: StudyPlan) -> Iterator[Job]:
    """The hydro database of a buoy."""
    stored, blocks = plan.database_path, tuple(map(plan.block_path, plan.bem_blocks.values()))
    yield Job("database", plan.database, {"blocks": plan.block_folder, "out": stored}, (stored,), blocks)


def _coefficients(plan: AnyPlan) -> Iterator[Job]:
    """What follows from the hydro database alone."""
    stored, radiation = plan.database_path, plan.radiation_path
    response, ladder = plan.response_files["response"], f"{plan.folder}/ladder.csv"
    rungs = plan.ladder_files["rungs"]
    read = {"database": stored}
    yield Job("radiation", plan.radiation, {**read, "out": radiation}, (radiation,), (stored,))
    yield Job("response", plan.response, {**read, "out": response}, (response,), (stored,))
    climbed = {**read, "out": ladder, "rungs": rungs, "manifest": plan.manifest}
    yield Job("ladder", plan.ladder, climbed, (ladder, rungs), (stored,))


def _runs(plan: AnyPlan) -> Iterator[Job]:
    """One run in time per design and sea."""
    hydro = plan.hydro_files
    for wave in plan.study.waves:
        for design in plan.study.designs:
            out = plan.trajectory_path(design, wave.label)
            yield Job("simulate", plan.simulation(design, wave), {**hydro, "out": out}, (out,), tuple(hydro.values()))


def _answers(plan: AnyPlan) -> Iterator[Job]:
    """Tables, figures, report."""
    folder, study = plan.folder, plan.study
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
    rungs = plan.ladder_files
    yield Job("compare", plan.comparison, files | rungs | tables, tuple(tables.values()), (*read, *rungs.values()))
    figures = tuple(figure_paths(folder, plan.figures))
    needs = (*read, *plan.modes_files.values())
    yield Job("figures", study, {**files, **plan.modes_files, "out": f"{folder}/figures"}, figures, needs)
    report, drawn = f"{folder}/report.html", {"tables": tables["tables"], "figures": f"{folder}/figures"}
    files = {**files, **plan.modes_files, **drawn, "out": report}
    yield Job("report", study, files, (report,), (*needs, drawn["tables"], *figures))
