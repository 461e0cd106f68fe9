"""Results of a study in a folder, each read when it is asked for."""

import csv
import json
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from vsb.errors import ConfigError
from vsb.hydro.database import load_database
from vsb.motion.port import Port
from vsb.scenes.build import DesignInSea, design_in_sea
from vsb.scenes.floating_system import AnyStudy, FloatingSystem, floating_system, towards
from vsb.stages.planning import with_degree
from vsb.study.plan import ResultsPlan, plan_for
from vsb.study.study import Wave
from vsb.tools.files import load
from vsb.tools.stamps import read_text


@dataclass(frozen=True)
class Results:
    """Results of a study: read when asked for, and refused if they are not what the study asks for.

    Raises
    ------
    DatabaseError
        By everything here: if a file is missing, damaged, or of another study.
    ConfigError
        If the study has no such design or sea, or its model no such result.
    """

    study: AnyStudy
    folder: str = "results"  # of all results

    @cached_property
    def plan(self) -> ResultsPlan:
        """Names and content ids of all files."""
        return with_degree(plan_for(self.study, self.folder))

    @property
    def comparison(self) -> list[dict[str, Any]]:
        """A row per design and sea."""
        return self._tables["comparison"]

    @property
    def statistics(self) -> list[dict[str, Any]]:
        """A row per design and irregular sea, over its realisations."""
        return self._tables["statistics"]

    @property
    def checks(self) -> list[dict[str, Any]]:
        """The validity ledger, worst first."""
        return self._tables["checks"]

    @property
    def ladder(self) -> list[dict[str, Any]]:
        """A row per design, sea and rung of the tuning ladder; None in place of what a rung does not have."""
        path = self._of_bem("tuning ladder", f"{self.plan.folder}/ladder.csv")
        rows = csv.DictReader(read_text(path, self.plan.manifest, self.plan.ids[path]).splitlines())
        words = ("design", "wave", "rung")
        return [{k: v if k in words else float(v) if v else None for k, v in row.items()} for row in rows]

    @cached_property
    def response(self) -> xr.Dataset:
        """Response amplitude operators, ports, powers and wet natural frequencies of all designs."""
        path = self._of_bem("frequency response", *self.plan.response_files.values())
        return load(path, expected=self.plan.response_id)

    @cached_property
    def database(self) -> xr.Dataset:
        """The hydro database."""
        path = self._of_bem("hydro database", *self.plan.hydro_files.values())
        return load_database(path, Path(path).stem)

    @property
    def report(self) -> Path:
        """The report, to be opened in a browser."""
        return Path(self.plan.folder, "report.html")

    def trajectory(self, design: str, wave: str | None = None) -> xr.Dataset:
        """Return the time series of a design in a sea, named by its label; by default in the first."""
        found = self._wave(wave)
        path = self.plan.trajectory_path(self._design(design), found.label)
        return load(path, expected=self.plan.trajectory_id(design, found))

    def scene(self, design: str, wave: str | None = None) -> DesignInSea:
        """Return the scene of a design in a sea, as it was simulated: what integrators and harmonic balance take."""
        spec = self.plan.simulation(self._design(design), self._wave(wave))
        return design_in_sea(spec, dict(self.plan.hydro_files))

    def port(self, design: str, omega: npt.ArrayLike | None = None, direction: float = 0.0) -> Port:
        """Return what the take-off sees of a design, at the database's frequencies or at others [rad/s].

        Of a body in waves of a direction [degrees].
        """
        motions, linear = self._afloat.motions[self._design(design)], towards(self._afloat.linear, direction)
        at = linear.database.omega.values if omega is None else np.asarray(omega, dtype=float)
        return linear.port(at, motions, self._afloat.port)

    @cached_property
    def _tables(self) -> dict[str, list[dict[str, Any]]]:
        """Tables as data."""
        found: dict[str, list[dict[str, Any]]] = json.loads(
            read_text(f"{self.plan.folder}/tables.json", self.plan.manifest, self.plan.study_id)
        )
        return found

    @cached_property
    def _afloat(self) -> FloatingSystem:
        """What floats."""
        return floating_system(self.study, self._of_bem("port", *self.plan.hydro_files.values()))

    def _of_bem(self, what: str, *paths: str) -> str:
        """The first of the files that only a model with BEM has."""
        if not self.study.needs_bem:
            raise ConfigError(f"hydro.model: received {self.study.hydro.model!r}, which has no {what}; needs linear")
        return paths[0]

    def _design(self, name: str) -> str:
        """A design there is."""
        return _known("design", name, self.study.designs)

    def _wave(self, label: str | None) -> Wave:
        """A sea there is."""
        waves = {wave.label: wave for wave in self.study.waves}
        return waves[_known("wave", label or next(iter(waves)), waves)]


def _known(what: str, name: str, names: Iterable[str]) -> str:
    """Check a name."""
    if name not in (known := list(names)):
        raise ConfigError(f"{what}: received {name!r}, needs one of {', '.join(known)}")
    return name
