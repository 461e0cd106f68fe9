"""The graph of a design problem: starts, Pareto fronts, runs in time, all together. Pure Python."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import PurePosixPath
from typing import Any

from vsb.engine.integrators.settings import Simulation
from vsb.keys.quantities import content_id
from vsb.pipeline import costs
from vsb.pipeline.graph import ID, Graph, Task, task
from vsb.study import figure_names
from vsb.study.design import LoadedDesign
from vsb.study.sections import DEGREES
from vsb.study.specs import (
    ClimateSpec,
    DesignFrontSpec,
    DesignSpec,
    DesignStartSpec,
    DesignVerificationSpec,
    Search,
)

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
    def climate(self) -> ClimateSpec:
        """What the seas of the year are read from."""
        return ClimateSpec.of(self.loaded.problem.climate, self.loaded.climate_id)

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
        specs = (
            DesignStartSpec(search=search, seed=problem.seed, start=i)
            for i in range(problem.starts if search.variables else 1)
        )
        out, read = f"{self.folder}/starts/{ID}.nc", self._climate_file
        found = [task("design_start", spec, out, files=read, seconds=seconds, minutes=120) for spec in specs]
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
                spec = DesignFrontSpec(search=search, limit=limit, values=values, starts=tuple(starts))
                found.append(
                    task(
                        "design_front", spec, f"{self.folder}/fronts/{ID}.nc", files=self._begun,
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
        return task(
            "design_verification", spec, f"{self.folder}/verification/{ID}.nc", files=self._begun | {"root": self.root},
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
        return Task(
            "design_results", spec, self._begun | files | {"manifest": self.manifest}, tuple(made),
            tuple(one.out for one in before), content_id(spec), seconds=8.0, megabytes=2000,
        )  # fmt: skip

    @cached_property
    def report(self) -> Task:
        """The report of the problem and its figures."""
        spec, report = self.design.spec, f"{self.folder}/report.html"
        figures = figure_names.paths(self.folder, figure_names.of_design(spec))
        files = {"data": self.data_path, "figures": f"{self.folder}/figures", "manifest": self.manifest}
        return task(
            "design_report", spec, report, files=files, makes=(report, *figures), needs=(self.data_path,),
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
