"""The runs of a study in a folder: of a study of thousands of seas there are more than memory holds."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import xarray as xr

from vsb.scenes.floating_system import AnyStudy
from vsb.study.plan import plan_for, trajectory_name
from vsb.tools.files import attributes, check_stamp, load


@dataclass(frozen=True)
class StoredRuns(Mapping[tuple[str, str], xr.Dataset]):
    """Trajectories of a study in a folder, by design and sea: read when asked for, those of one sea kept at a time.

    Raises
    ------
    DatabaseError
        By every run that is missing, damaged, or of another specification.
    """

    study: AnyStudy
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
        study, plan = self.study, plan_for(self.study)
        return {(d, wave.label): plan.trajectory_id(d, wave) for wave in study.waves for d in study.designs}

    def _path(self, design: str, wave: str) -> str:
        """File of a run."""
        return f"{self.folder}/{trajectory_name(design, wave)}"
