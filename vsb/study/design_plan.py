"""What a design problem computes: starts, Pareto fronts, content ids, file names. Pure Python, read at every parse."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import PurePosixPath
from typing import Any

from vsb.engine.integrators.settings import Simulation
from vsb.keys.quantities import content_id
from vsb.study import figure_names
from vsb.study.design import LoadedDesign
from vsb.study.plan import ResultsFolder
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
class DesignPlan(ResultsFolder):
    """Everything a design problem needs computed, with content ids."""

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

    def _starts(self, search: Search) -> dict[str, DesignStartSpec]:
        """Specs of the starts of a search by id; without variables there is one."""
        problem = self.loaded.problem
        count = problem.starts if search.variables else 1
        found = [DesignStartSpec(search=search, seed=problem.seed, start=i) for i in range(count)]
        return {content_id(spec): spec for spec in found}

    @cached_property
    def starts(self) -> dict[str, DesignStartSpec]:
        """Starts of the flexible buoy by id."""
        return self._starts(self.flexible)

    @cached_property
    def rigid_starts(self) -> dict[str, DesignStartSpec]:
        """Starts of the rigid competitor by id."""
        return self._starts(self.rigid)

    @cached_property
    def fronts(self) -> dict[str, DesignFrontSpec]:
        """Pareto fronts by id: for each limit that of the flexible buoy, then that of the rigid one."""
        found = []
        for limit, values in self.loaded.problem.pareto.items():
            for search, starts in ((self.flexible, self.starts), (self.rigid, self.rigid_starts)):
                found.append(DesignFrontSpec(search=search, limit=limit, values=values, starts=tuple(starts)))
        return {content_id(spec): spec for spec in found}

    @cached_property
    def verification(self) -> DesignVerificationSpec | None:
        """Runs in time of both buoys."""
        if not (verify := self.loaded.problem.verify):
            return None
        given = self.loaded.base.simulation
        return DesignVerificationSpec(
            flexible=self.flexible,
            rigid=self.rigid,
            verify=verify,
            simulation=Simulation(tolerance=given.tolerance, method=given.method),  # how long follows from the seas
            starts=tuple(self.starts),
            rigid_starts=tuple(self.rigid_starts),
        )

    @cached_property
    def design(self) -> DesignSpec:
        """Spec of the whole problem."""
        problem, verification = self.loaded.problem, self.verification
        return DesignSpec(
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
            verification=content_id(verification) if verification else None,
            runs=self.loaded.base.model_dump(include={"waves", "simulation"}, exclude_none=True),
            notes=tuple(self.loaded.notes),
        )

    @property
    def identity(self) -> str:
        """Id of what is made of all starts together."""
        return content_id(self.design)

    # file names -----------------------------------------------------------------------------------------------------

    def start_path(self, start: str) -> str:
        """Where one start ended."""
        return f"{self.folder}/starts/{start}.nc"

    def front_path(self, front: str) -> str:
        """A Pareto front."""
        return f"{self.folder}/fronts/{front}.nc"

    @property
    def start_paths(self) -> list[str]:
        """Where all starts ended."""
        return [self.start_path(start) for start in (*self.starts, *self.rigid_starts)]

    @property
    def front_paths(self) -> list[str]:
        """All Pareto fronts."""
        return [self.front_path(front) for front in self.fronts]

    @property
    def verification_paths(self) -> list[str]:
        """What runs in time say; none without `verify`."""
        return [f"{self.folder}/verification/{content_id(self.verification)}.nc"] if self.verification else []

    @property
    def tables(self) -> dict[str, str]:
        """Results made of all starts together, by name."""
        return {name: f"{self.folder}/{name}" for name in TABLES}

    @property
    def figure_paths(self) -> list[str]:
        """Figures of the report."""
        return figure_names.paths(self.folder, figure_names.of_design(self.design))
