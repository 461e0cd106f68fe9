"""The graph of a study: each stage with what it reads, its files, its id and its costs. Pure Python.

The rules of the workflow, a run in one process, a dry run and the ids that files must carry all follow from its tasks.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Any, ClassVar, NamedTuple, Self

from vsb.engine.hydro.bodies.body_file import PHYSICS, BodyFile, panel_count, solve_resources
from vsb.engine.hydro.panels import panel_solver
from vsb.engine.motion.take_off import Pto
from vsb.engine.waves.kinds import Wave
from vsb.keys.quantities import content_id, result_id
from vsb.pipeline import costs
from vsb.study import figure_names
from vsb.study.body import BodyStudy, wamit_files
from vsb.study.resolution import (
    AnyBlock,
    HydroPlan,
    block_id,
    degree_needed,
    in_band,
    no_witness,
    wets_rings,
    witness_meshes,
    witness_omega,
)
from vsb.study.sections import Hydro
from vsb.study.specs import (
    BodySource,
    DeformedMeshes,
    PanelsBlock,
    Run,
    spec_of,
)
from vsb.study.study import Study


class Stage(NamedTuple):
    """What a task may do: the function `run_STAGE` of a module of `vsb.stages`."""

    rule: str  # of the workflow whose jobs do it
    module: str
    words: str
    tag: str = ""  # of its version of the physics in `PHYSICS`, if not its own name


STAGES = {
    "modes": Stage("modes", "water", "shell modes", "mesh"),
    "display": Stage("meshes", "water", "the shell deformed by each mode", "mesh"),
    "green": Stage("green", "panels", "Green-function table of the panels"),
    "mesh": Stage("mesh", "panels", "mean wetted mesh"),
    "panels": Stage("panels", "panels", "a block of frequencies by panels", "block"),
    "spectral": Stage("spectral", "water", "all frequencies by the spectral solver", "block"),
    "deformed": Stage("cross_check", "panels", "meshes of the shell deformed by each mode", "mesh"),
    "witness": Stage("cross_check", "panels", "panels and spectral solver on the deformed shells"),
    "frequencies": Stage("frequencies", "coefficients", "frequencies of the body", "body"),
    "coefficients": Stage("coefficients", "coefficients", "hydro database of the body", "body"),
    "database": Stage("database", "water", "hydro database"),
    "radiation": Stage("database", "frequency", "radiation memory"),
    "response": Stage("response", "frequency", "frequency response"),
    "ladder": Stage("response", "frequency", "control levels"),
    "simulate": Stage("simulate", "simulate", "motion in time"),
    "compare": Stage("results", "report", "comparison and doubts"),
    "figures": Stage("results", "report", "figures"),
    "report": Stage("results", "report", "report"),
    "members": Stage("members", "members", "points over the year"),
    "verification": Stage("verification", "members", "seas of the year in time"),
    "campaign": Stage("campaign", "campaign", "all points together"),
    "campaign_report": Stage("campaign", "campaign", "report", "campaign"),
    "design_start": Stage("design_start", "design", "a search from one start"),
    "design_front": Stage("design_front", "design", "the best over the values of a limit"),
    "design_verification": Stage("design_verification", "design_verification", "the best buoys in time"),
    "design_results": Stage("design_results", "design_results", "the best buoys together"),
    "design_report": Stage("design_results", "design_results", "report", "design_results"),
}
"""Stages in the order of the chain; the radiation memory of a body is made with its database."""
MEMORY = {"tolerance", "added_mass_inf"}
"""Keys of `hydro` that the radiation memory follows from; the second a body has alone."""
ID = "{id}"
"""Stands for the id of a task in the name of its file."""


@dataclass(frozen=True)
class Task:
    """One stage at work."""

    stage: str
    spec: dict[str, Any]  # what it reads of the study, by parameter of its function `run_STAGE`, and its physics
    files: Mapping[str, str]  # by parameter likewise
    makes: tuple[str, ...]
    needs: tuple[str, ...] = ()  # files of other tasks; those of users stand in its specification by their contents
    id: str = ""  # content id that the files it makes carry; none of the Green-function table
    on_the_way: bool = False  # made for other tasks, and not missed once what these make is there
    seconds: float = 0.15  # CPU time it takes, without the start of a process
    megabytes: int = 1000
    minutes: int = 30

    @property
    def out(self) -> str:
        """The file it makes, of several the first."""
        return self.makes[0]

    @property
    def words(self) -> str:
        """What it does, and of several of its kind which."""
        which = PurePosixPath(self.out).stem if self.stage == "simulate" else ""
        return f"{STAGES[self.stage].words}{which and f' {which}'}"

    @classmethod
    def of(
        cls,
        stage: str,
        given: Mapping[str, Any],
        out: str,
        reads: Mapping[str, "Task"] | None = None,
        *,
        needs: Sequence[str] = (),
        files: Mapping[str, str] | None = None,
        makes: Sequence[str] = (),
        stamps: Sequence["Task"] = (),
        **options: Any,
    ) -> Self:
        """Return a task whose id follows from what it reads, the version of its physics, and what it follows.

        Parameters
        ----------
        given : mapping
            What it reads of the study, by parameter of its function.
        out : str
            Path of the file it makes, or their folder; `ID` in it is replaced by the id.
        reads : mapping of str to Task, optional
            Tasks it follows by the option that names their file.
        needs, files, makes : optional
            Further files it needs; further options; the files it makes, if not `out` alone.
        stamps : sequence of Task
            Those it follows that it is not given the ids of.
        """
        spec = spec_of(STAGES[stage].tag or stage, **given)
        identity = result_id(spec, *(one.id for one in stamps))
        read = {name: one.out for name, one in (reads or {}).items()}
        out = out.replace(ID, identity)
        named = {name: path.replace(ID, identity) for name, path in (files or {}).items()}
        made = tuple(path.replace(ID, identity) for path in makes) or (out,)
        return cls(stage, spec, {**read, **named, "out": out}, made, (*read.values(), *needs), identity, **options)

    @property
    def handed(self) -> dict[str, Any]:
        """What a process of its own is handed over."""
        names = ("stage", "id", "spec", "files", "makes")
        return {name: getattr(self, name) for name in names}


def due(ordered: Sequence[Task], targets: Collection[str], stale: Collection[str] = ()) -> list[Task]:
    """Return the tasks that make what is wanted and missing or stale: targets, and what other such tasks need."""
    wanted, found = set(targets), []
    for one in reversed(ordered):
        if any(path in wanted and (path in stale or not Path(path).exists()) for path in one.makes):
            found.append(one)
            wanted.update(one.needs)
    return found[::-1]


def database_path(root: str, identity: str) -> str:
    """Return the path of a hydro database."""
    return f"{root}/hydro/db/{identity}.nc"


def radiation_path(root: str, identity: str) -> str:
    """Return the path of a radiation model."""
    return f"{root}/hydro/radiation/{identity}.nc"


def trajectory_name(design: str, wave: str) -> str:
    """Return the file name of the time series of one design in one sea."""
    return f"{design}-{wave}.nc"


class Graph(ABC):
    """What a study, a campaign or a design problem computes, and where its results lie."""

    KIND: ClassVar[str] = "study"
    root: str  # of all results

    @property
    @abstractmethod
    def identity(self) -> str:
        """Id of what is made of all results together: tables, figures, report."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the study, campaign or design problem."""

    @abstractmethod
    def _tasks(self) -> Iterator[Task]:
        """Yield its tasks, each after those whose files it needs."""

    @cached_property
    def tasks(self) -> tuple[Task, ...]:
        """Its tasks, each after those whose files it needs."""
        return tuple(self._tasks())

    @property
    def products(self) -> list[str]:
        """All files a run of it promises."""
        return [path for one in self.tasks if not one.on_the_way for path in one.makes]

    @property
    def file_ids(self) -> dict[str, str]:
        """The content id that every file of it must carry, those made on the way included."""
        return {path: one.id for one in self.tasks if one.id for path in one.makes}

    @property
    def folder(self) -> str:
        """Folder of its own results."""
        return f"{self.root}/{self.name}"

    @property
    def manifest(self) -> str:
        """Stamps of products that are no netCDF files."""
        return f"{self.folder}/manifest.json"

    def is_shared(self, path: str) -> bool:
        """Whether studies share a file."""
        return path.startswith(f"{self.root}/hydro/")

    def seconds_left(self, some: Sequence[Task]) -> float:
        """Return the CPU time of tasks whose files are not there [s]."""
        return sum(one.seconds for one in some)


class ResultsPlan(Graph):
    """What a study of a buoy or of a body computes."""

    study: Study

    def with_degree(self) -> Self:
        """Return a plan whose shell modes, if there are any, have a degree."""
        return self

    @property
    def modes(self) -> Task | None:
        """Shapes of the shell modes; none of a body, whose own files hold those of its motions."""
        return None

    @property
    def witness(self) -> Task | None:
        """What two solvers say of the same shapes; none without a second solver."""
        return None

    @property
    @abstractmethod
    def database(self) -> Task:
        """The hydro database."""

    @property
    def database_path(self) -> str:
        """Path of the hydro database, as `vsb.open_database` takes it."""
        return self.database.out

    def part(self, *names: str, **changed: Any) -> Study:
        """Return what a stage of motion reads of the study: what floats, and further sections by name."""
        return self.study.only("designs", "water", "pto", *self.study.FLOATS, *names, **changed)

    of_ladder: ClassVar[tuple[str, ...]] = ()
    """Sections control levels read beyond those of every stage of motion."""

    def of_hydro(self, *names: str) -> dict[str, Hydro]:
        """Return what a stage of motion reads of the section `hydro`: of a body its database holds all."""
        return {}

    @property
    @abstractmethod
    def coordinates(self) -> int:
        """How many degrees of freedom a run may record."""

    @property
    @abstractmethod
    def highest(self) -> float:
        """Highest frequency a sea may have components at [rad/s]."""

    @property
    def moved(self) -> int:
        """How many motions all flexible designs have together."""
        return 0

    def _in_seas(self, stage: str) -> float:
        """CPU time a stage takes to know what the take-off sees in irregular seas [s]."""
        seas = len({wave.family for wave in self.study.waves if wave.irregular}) if self.study.needs_bem else 0
        return costs.IN_SEAS[stage] * costs.IN_A_SEA_SECONDS * seas * self.moved * self.coordinates

    @abstractmethod
    def _water(self) -> Iterator[Task]:
        """Yield what comes before motion: shell modes, coefficients of the water, the hydro database."""

    def _tasks(self) -> Iterator[Task]:
        yield from self._water()
        if self.study.needs_bem:
            yield from (self.radiation, self.response, self.ladder)
        yield from self.runs.values()
        yield from self._answers()

    @property
    def green(self) -> Task:
        """The Green-function table of panels."""
        folder = f"{self.root}/hydro/green/{panel_solver().replace(' ', '-')}"
        files, out = {"folder": folder}, f"{folder}.done"
        return Task("green", {}, {**files, "out": out}, (out,), on_the_way=True, seconds=costs.GREEN_SECONDS)

    # frequency domain -----------------------------------------------------------------------------------------------

    @cached_property
    def radiation(self) -> Task:
        """The radiation memory of the hydro database."""
        given = self.study.hydro.model_dump(include=MEMORY)
        read, out = {"database": self.database}, radiation_path(self.root, ID)
        return Task.of(
            "radiation", given, out, read, stamps=(self.database,),
            seconds=costs.motions_seconds("radiation", self.coordinates),
        )  # fmt: skip

    @cached_property
    def response(self) -> Task:
        """The frequency response."""
        grid = self._response_grid
        omega = {wave.omega for wave in self.study.waves if wave.regular} | {*grid.pop("omega", ())}
        given = {"study": self.part(), "omega": sorted(omega), "directions": self.study.directions, **grid}
        read, out = {"database": self.database}, f"{self.folder}/response.nc"
        seconds = costs.motions_seconds("response", self.moved)
        return Task.of("response", given, out, read, stamps=(self.database,), seconds=seconds)

    @property
    def _response_grid(self) -> dict[str, Any]:
        """Grid of the frequency response, if it is not that of the database, and frequencies the study asks for."""
        return {}

    @cached_property
    def ladder(self) -> Task:
        """The control levels; nothing is followed in time, so the method of the study does not matter."""
        study, simulation = self.study, self.study.simulation.model_copy(update={"method": "auto"})
        read = self.part("drag", "waves", *self.of_ladder, simulation=simulation, **self.of_hydro("omega_max"))
        table, levels = f"{self.folder}/ladder.csv", f"{self.folder}/ladder.json"
        return Task.of(
            "ladder", {"study": read}, table,
            {"database": self.database}, stamps=(self.database,), makes=(table, levels),
            files={"levels": levels, "manifest": self.manifest},
            seconds=costs.ladder_seconds(study) + self._in_seas("ladder"),
        )  # fmt: skip

    # time domain ----------------------------------------------------------------------------------------------------

    @cached_property
    def _hydro(self) -> dict[str, Task]:
        """What the time domain reads, by the option that names it; nothing without coefficients of the water."""
        return {"database": self.database, "radiation": self.radiation} if self.study.needs_bem else {}

    @property
    def hydro_files(self) -> dict[str, str]:
        """Files the time domain reads, by the option that names them."""
        return {name: one.out for name, one in self._hydro.items()}

    def simulation(self, design: str, wave: Wave) -> Task:
        """Return a run in time; of its take-off it reads only the damper of this design, or how to tune it."""
        study = self.study
        tuning = study.pto.tuning if study.pto.damping is None else study.tuning(wave)  # a year's members lie still
        damping = study.pto.damper(design) if tuning == "fixed" else None
        pto = study.pto.model_copy(update={"damping": damping, "tuning": tuning})
        one = {"designs": {design: study.designs[design]}, "pto": pto, "waves": (wave,)}
        dynamics = self.of_hydro("omega_max", "model", "pressure", "power_tolerance")
        read = self.part("drag", "simulation", **one, **dynamics)
        run = Run(study=read, seas=study.one_of_each_sea if tuning == "one" else ())
        solved, out = self._hydro, f"{self.folder}/trajectories/{trajectory_name(design, wave.label)}"
        motions = self.coordinates if self.moved and study.designs[design].flexible else 0
        seconds = costs.run_seconds(study, wave, flexible=study.designs[design].flexible)
        seconds += costs.motions_seconds("simulate", motions)
        seconds += 2 * wave.irregular * costs.IN_A_SEA_SECONDS * motions**2  # of its spectrum and of its record
        memory = costs.run_megabytes(study, wave, self.coordinates, self.highest)
        return Task.of(
            "simulate", {"run": run}, out, solved, stamps=[*solved.values()], seconds=seconds, megabytes=memory
        )

    @cached_property
    def runs(self) -> dict[tuple[str, str], Task]:
        """Runs in time by design and label of the sea."""
        study = self.study
        return {(design, wave.label): self.simulation(design, wave) for wave in study.waves for design in study.designs}

    # tables, figures, report ----------------------------------------------------------------------------------------

    @cached_property
    def compare(self) -> Task:
        """The comparison of the whole study, whose id all have that is made of all results; designs in any order."""
        study, folder, solved = self.study, self.folder, self._hydro
        levels = (self.response, self.ladder) if study.needs_bem else ()
        ordered = [self.runs[design, wave.label] for wave in study.waves for design in sorted(study.designs)]
        stamps = [one for one in (self.modes, *solved.values(), self.witness, *levels, *ordered) if one]
        files = self._read | {
            "statistics": f"{folder}/statistics.csv",
            "validity": f"{folder}/validity.json",
            "study": f"{folder}/study.json",
            "tables": f"{folder}/tables.json",
        }
        needs, out = [one.out for one in (*self.solved.values(), *self.runs.values())], f"{folder}/comparison.csv"
        if study.needs_bem:
            files["levels"] = self.ladder.files["levels"]
            needs.append(files["levels"])
        made = (out, *(files[name] for name in ("statistics", "validity", "study", "tables")))
        once, each = costs.COMPARED_SECONDS
        return Task.of(
            "compare", {"compared": study}, out, files=files, needs=needs, makes=made, stamps=stamps,
            seconds=once + each * len(self.runs) + self._in_seas("compare"),
            megabytes=costs.study_megabytes(self.study, self.coordinates),
        )  # fmt: skip

    @property
    def solved(self) -> dict[str, Task]:
        """What there is beside runs in time for tables and figures, by the option that names it."""
        further = {"response": self.response if self.study.needs_bem else None, "witness": self.witness}
        return self._hydro | {name: one for name, one in further.items() if one}

    @property
    def _read(self) -> dict[str, str]:
        """What tables, figures and report read, by option."""
        stored = {name: one.out for name, one in self.solved.items()}
        return stored | {"trajectories": f"{self.folder}/trajectories", "manifest": self.manifest}

    def _answers(self) -> Iterator[Task]:
        """Yield tables, figures, report."""
        yield (compared := self.compare)
        folder, whole, memory = self.folder, self.identity, costs.study_megabytes(self.study, self.coordinates)
        modes = {"modes": self.modes.out} if self.modes else {}
        files, figures = self._read | modes, tuple(figure_names.paths(folder, figure_names.of_study(self.study)))
        needs = (*(one.out for one in (*self.solved.values(), *self.runs.values())), *modes.values())
        seconds = costs.FIGURE_SECONDS * len(figures) + costs.motions_seconds("figures", self.moved)
        seconds += self._in_seas("figures")
        drawn = files | {"out": f"{folder}/figures"}
        yield Task("figures", {"study": self.study}, drawn, figures, needs, whole, seconds=seconds, megabytes=memory)
        report, tables = f"{folder}/report.html", compared.files["tables"]
        files |= {"tables": tables, "figures": f"{folder}/figures", "out": report}
        once, each = costs.REPORTED_SECONDS
        needs, seconds = (*needs, tables, *figures), once + each * len(self.runs) + self._in_seas("report")
        yield Task("report", {"study": self.study}, files, (report,), needs, whole, seconds=seconds, megabytes=memory)

    @property
    def identity(self) -> str:
        """Id of what is made of all results together: tables, figures, report."""
        return self.compare.id

    @property
    def name(self) -> str:
        """Name of the study."""
        return self.study.study


@dataclass(frozen=True)
class StudyPlan(HydroPlan, ResultsPlan):
    """Everything a study of a buoy needs computed."""

    root: str = "results"
    of_ladder = ("modes",)  # with their tolerance

    def part(self, *names: str, **changed: Any) -> Study:
        """Return what a stage of motion reads of the study, in most the modes without their tolerance."""
        modes = {} if "modes" in names else {"modes": self.study.modes.without_tolerance}
        return super().part(*names, **modes | changed)

    def of_hydro(self, *names: str) -> dict[str, Hydro]:
        """Return what a stage of motion reads of the section `hydro`, beside the database."""
        return {"hydro": self.study.hydro.only(*names)}

    @property
    def degree_needed(self) -> int:
        """Degree of the full basis that `modes.tolerance` needs, whatever is given."""
        return degree_needed(self.study)

    def with_degree(self) -> Self:
        """Return a plan whose shell modes have a degree, and whose automatic band has that of their damping.

        The degree is the one given, or the one that `modes.tolerance` needs.
        """
        given = self.study.modes.degree is not None
        study = in_band(self.study if given else self.study.with_degree(self.degree_needed))
        return self if study is self.study else replace(self, study=study)

    @property
    def moved(self) -> int:
        """How many motions all flexible designs have together."""
        return self.coordinates * sum(bool(one.flexible) for one in self.study.designs.values())

    @cached_property
    def modes(self) -> Task:
        """The shell modes."""
        return Task.of("modes", {"study": self.part(pto=Pto())}, f"{self.folder}/modes.nc")

    @cached_property
    def display(self) -> Task:
        """A mesh to look at: the shell at rest with the displacement of each axisymmetric mode; studies share it."""
        modes, folder = self.study.modes.without_tolerance, f"{self.root}/hydro/mesh/{ID}"
        shell = self.shell(**({"modes": modes.model_copy(update={"order": 1})} if self.study.flexible else {}))
        return Task.of(
            "display", {"study": shell}, f"{folder}/shell.vtu", files={"manifest": f"{folder}/manifest.json"},
            seconds=costs.motions_seconds("display", len(self.mode_labels)),
        )  # fmt: skip

    def block_path(self, block: AnyBlock) -> str:
        """Coefficients of a block of frequencies."""
        return f"{self.root}/hydro/blocks/{block_id(block)}.nc"

    def blocks(self) -> Iterator[Task]:
        """Yield all blocks of frequencies, of this shape at least; by panels with their meshes and the table."""
        every, out = self.bem_blocks.values(), f"{self.root}/hydro/blocks/{ID}.nc"
        folder = f"{self.root}/hydro/mesh/{ID}"
        if self.study.uses_panels:
            yield self.green
        meshes = {
            content_id(one.mesh): Task.of("mesh", {"grid": one.mesh}, f"{folder}/mean.nc", on_the_way=True)
            for one in every
            if isinstance(one, PanelsBlock)
        }
        yield from meshes.values()
        for block in every:
            options: dict[str, Any] = {"on_the_way": True, "seconds": costs.block_seconds(block)}
            if isinstance(block, PanelsBlock):
                read, files = {"mesh": meshes[content_id(block.mesh)]}, {"green": self.green.files["folder"]}
                needs = (self.green.out,)
                yield Task.of("panels", {"block": block}, out, read, files=files, needs=needs, **options)
            else:
                memory = costs.spectral_megabytes(len(block.displacements))
                yield Task.of("spectral", {"block": block}, out, megabytes=memory, **options)

    @cached_property
    def deformed(self) -> Task | None:
        """Meshes the second solver is asked about: the mean wetted shell, and one for each of its modes and signs."""
        if no_witness(self.study):
            return None
        return Task.of("deformed", {"shapes": witness_meshes(self)}, f"{self.root}/hydro/mesh/{ID}/shapes.nc")

    @cached_property
    def witness(self) -> Task | None:
        """What two solvers say of the same shapes; none without a second solver (`vsb.study.resolution`)."""
        if not (deformed := self.deformed):
            return None
        shapes: DeformedMeshes = deformed.spec["shapes"]
        water, omega = self.study.water, witness_omega(self.study)
        given = {"solver": panel_solver(), "shapes": shapes, "water": water, "omega": omega}
        seconds = costs.witness_seconds(shapes.count, shapes.rows)
        return Task.of("witness", given, f"{self.root}/hydro/witness/{ID}.nc", {"meshes": deformed}, seconds=seconds)

    @cached_property
    def database(self) -> Task:
        """The hydro database: the blocks in terms of the shell modes."""
        hydro = self.study.hydro
        given = {
            "study": self.loaded_shell("motion", "mooring")
            if wets_rings(self.study)
            else self.shell("motion", "mooring"),
            "sweep": [*map(block_id, self.sweep_blocks)],
            "tabulated": [*map(block_id, self.tabulated_blocks)],
            "omega_max": self.highest_omega,
            "tolerance": hydro.tolerance,
            "accept": sorted(hydro.accept),
        }
        blocks = f"{self.root}/hydro/blocks"
        needs = [f"{blocks}/{name}.nc" for name in self.bem_blocks]
        once, each = costs.DATABASE_SECONDS
        return Task.of(
            "database", given, database_path(self.root, ID), files={"blocks": blocks}, needs=needs,
            seconds=once + each * self.coordinates**2,
        )  # fmt: skip

    def _water(self) -> Iterator[Task]:
        """Yield shell modes and viewable meshes; coefficients of the water, their cross-check and the database."""
        yield from (self.modes, self.display)
        if self.study.needs_bem:
            yield from self.blocks()
            yield from filter(None, (self.deformed, self.witness))
            yield self.database

    @property
    def _response_grid(self) -> dict[str, Any]:
        """Grid of the frequency response, and frequencies the study asks for, of those solved."""
        hydro, first = self.study.hydro, self.first_omega
        asked = [omega for omega in hydro.omega if omega >= first]
        return {"step": self.step, "lowest": first, "omega_max": hydro.omega_max, "omega": asked}

    @property
    def highest(self) -> float:
        """Highest frequency a sea may have components at [rad/s]."""
        return float(self.study.hydro.omega_max)


_MOST_MOTIONS, _HIGHEST = 40, 20.0  # for memory alone: degrees of freedom and band of a body whose file is not read yet


@dataclass(frozen=True)
class BodyPlan(ResultsPlan):
    """Everything a study of a body needs computed; files are where its contents lie."""

    study: Study
    root: str = "results"
    files: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def database(self) -> Task:
        """The hydro database, solved or read; how long that takes is known where its files are."""
        study, solved = self.study, self.study.uses_panels
        source = BodySource(
            body=study.body,
            water=study.water,
            dofs=study.dofs,
            omega_max=study.hydro.omega_max,
            accept=tuple(sorted(study.hydro.accept)),
            repair=tuple(sorted(study.hydro.repair)),
        )
        given = {"source": source} | ({"versions": solved_by()} if solved else {})
        return Task.of("coefficients", given, database_path(self.root, ID), files=self.sources, needs=self.inputs)

    def solved_database(self, apart: Sequence[Task] = ()) -> Task:
        """Return the same with what it takes, beside which frequencies are solved apart."""
        if not isinstance(file := self.study.body.file, BodyFile):
            return replace(self.database, seconds=0.5, megabytes=4000)
        memory, minutes = solve_resources(file, self.files)
        matrices = costs.matrices_seconds(file, panel_count(file, self.files))
        seconds, needs = costs.body_seconds(file, matrices), (*self.inputs, *(one.out for one in apart))
        seconds = 1.0 if apart else seconds
        return replace(self.database, needs=needs, seconds=seconds, megabytes=memory, minutes=minutes)

    def _water(self) -> Iterator[Task]:
        """Yield what makes the hydro database, solved or read."""
        apart = list[Task]()
        if isinstance(file := self.study.body.file, BodyFile):
            yield self.green
            apart += frequencies(file, self.sources, self.inputs, f"{self.root}/hydro/bodies")
        yield from (*apart, self.solved_database(apart))

    @property
    def coordinates(self) -> int:
        """How many degrees of freedom a run may record."""
        return len(self.study.dofs or ()) or _MOST_MOTIONS

    @property
    def highest(self) -> float:
        """Highest frequency a sea may have components at [rad/s]."""
        return self.study.body.file.omega[-1] if isinstance(self.study.body.file, BodyFile) else _HIGHEST

    @property
    def sources(self) -> dict[str, str]:
        """What the database is made from beside its spec, by option: the body's files, and where a mesh is solved."""
        if not self.study.uses_panels:
            return {**self.files}
        return {**self.files, "folder": f"{self.root}/hydro/bodies", "green": self.green.files["folder"]}

    @property
    def inputs(self) -> list[str]:
        """Files the database is made from."""
        each = [wamit_files(path)[:3] if kind == "wamit" else [path] for kind, path in self.files.items()]
        files = [path for paths in each for path in paths]
        return [*files, self.green.out] if self.study.uses_panels else files


def solved_by() -> dict[str, Any]:
    """Return the versions of what solves a body on panels."""
    return {"solver": panel_solver(), "physics": PHYSICS}


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
        spec = spec_of("body", body=file, omega=omega, versions=solved_by())
        out = f"{folder}/{content_id(spec)}.done"
        yield Task(
            "frequencies", spec, {**sources, "out": out}, (out,), tuple(inputs), on_the_way=True,
            seconds=seconds * len(omega) / len(file.omega), megabytes=memory, minutes=minutes,
        )  # fmt: skip


AnyPlan = StudyPlan | BodyPlan


def plan_for(study: Study, root: str = "results", files: Mapping[str, str] | None = None) -> AnyPlan:
    """Return the plan of a study; names and ids are known without the files of a body."""
    return BodyPlan(study, root, files or {}) if isinstance(study, BodyStudy) else StudyPlan(study, root=root)
