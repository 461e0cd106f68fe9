"""What the stages of a whole study read of the stages before them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import xarray as xr

from vsb.hydro.database import load_database
from vsb.scenes.floating_system import AnyStudy
from vsb.stages.trajectories import StoredRuns
from vsb.study.plan import ResultsPlan, StudyPlan, plan_for
from vsb.study.quantities import content_id
from vsb.tools.files import load


@dataclass(frozen=True)
class Inputs:
    """Results of a study, each read when asked for; empty where the study has none.

    Raises
    ------
    DatabaseError
        By everything here: if a file is missing, damaged, or of another specification.
    """

    study: AnyStudy
    trajectories: str  # folder
    solved: Mapping[str, str] = field(default_factory=dict)  # paths of what is below, by its name

    def path(self, name: str) -> str:
        """Path of a file, empty where the study has none."""
        return self.solved.get(name, "")

    @cached_property
    def plan(self) -> ResultsPlan:
        """Names and content ids."""
        return plan_for(self.study)

    @cached_property
    def runs(self) -> StoredRuns:
        """Time series by design and sea."""
        return StoredRuns(self.study, self.trajectories)

    @cached_property
    def modes(self) -> xr.Dataset:
        """Shapes of the shell modes."""
        if not isinstance(self.plan, StudyPlan):
            return xr.Dataset()
        return load(self.path("modes"), expected=content_id(self.plan.modes))

    @cached_property
    def database(self) -> xr.Dataset:
        """The hydro database."""
        path = self.path("database")
        return load_database(path, Path(path).stem) if self.study.needs_bem else xr.Dataset()

    @cached_property
    def radiation(self) -> xr.Dataset:
        """The radiation model."""
        path = self.path("radiation")
        return load(path, expected=Path(path).stem) if self.study.needs_bem else xr.Dataset()

    @cached_property
    def response(self) -> xr.Dataset:
        """The frequency response."""
        needed = self.study.needs_bem
        return load(self.path("response"), expected=self.plan.response_id) if needed else xr.Dataset()

    @cached_property
    def witness(self) -> xr.Dataset:
        """What two solvers say of the same shapes."""
        path = self.path("witness")
        return load(path, expected=Path(path).stem) if self.plan.witness_files else xr.Dataset()
