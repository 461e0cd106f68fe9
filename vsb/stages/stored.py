"""Results of a study in a folder, each read when it is asked for."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import xarray as xr

from vsb.engine.hydro.database import load_database
from vsb.pipeline.graph import ResultsPlan, plan_for, trajectory_name
from vsb.study.study import Study
from vsb.tools.files import attributes, check_stamp, load


@dataclass(frozen=True)
class StoredRuns(Mapping[tuple[str, str], xr.Dataset]):
    """Trajectories of a study in a folder, by design and sea: read when asked for, those of one sea kept at a time.

    Raises `DatabaseError` by every run that is missing, damaged, or of another specification.
    """

    study: Study
    folder: str
    _kept: dict[tuple[str, str], xr.Dataset] = field(default_factory=dict, repr=False)

    def __getitem__(self, run: tuple[str, str]) -> xr.Dataset:
        if run not in self._kept:
            for other in [kept for kept in self._kept if kept[1] != run[1]]:
                del self._kept[other]
            self._kept[run] = load(self._path(*run), expected=self._ids[run])
        return self._kept[run]

    def __iter__(self) -> Iterator[tuple[str, str]]:
        return iter(self._ids)

    def __len__(self) -> int:
        return len(self._ids)

    def attributes(self) -> list[dict[str, Any]]:
        """Return the attributes of all runs; what they hold is checked, and not read."""
        found = []
        for run, identity in self._ids.items():
            found.append(attributes(self._path(*run)))
            check_stamp(found[-1], identity, self._path(*run))
        return found

    @cached_property
    def _ids(self) -> dict[tuple[str, str], str]:
        """Content id of every run, sea by sea."""
        return {run: task.id for run, task in plan_for(self.study).runs.items()}

    def _path(self, design: str, wave: str) -> str:
        """File of a run."""
        return f"{self.folder}/{trajectory_name(design, wave)}"


@dataclass(frozen=True)
class Inputs:
    """Results of a study, each read when asked for; empty where the study has none.

    Raises `DatabaseError` by everything here: if a file is missing, damaged, or of another specification.
    """

    study: Study
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

    def _read(self, name: str) -> xr.Dataset:
        """A file by its name, of the id of its task; empty where the study has none."""
        if not (task := {**self.plan.solved, "modes": self.plan.modes}.get(name)):
            return xr.Dataset()
        path = self.path(name)
        return load_database(path, task.id) if name == "database" else load(path, expected=task.id)

    @cached_property
    def modes(self) -> xr.Dataset:
        """Shapes of the shell modes."""
        return self._read("modes")

    @cached_property
    def database(self) -> xr.Dataset:
        """The hydro database."""
        return self._read("database")

    @cached_property
    def radiation(self) -> xr.Dataset:
        """The radiation model."""
        return self._read("radiation")

    @cached_property
    def response(self) -> xr.Dataset:
        """The frequency response."""
        return self._read("response")

    @cached_property
    def witness(self) -> xr.Dataset:
        """What two solvers say of the same shapes."""
        return self._read("witness")
