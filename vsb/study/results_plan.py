"""What every plan of a study has: its results, their content ids and file names, the memory their jobs take.

Pure Python: the Snakefile builds its graph from plans alone, so a dry run shows the true one.
"""

import math
import re
import shlex
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import PurePosixPath

from vsb.study.base_study import BaseStudy
from vsb.study.blocks import panel_solver
from vsb.study.body_specs import BodySimulateSpec
from vsb.study.canonical import content_id, result_id
from vsb.study.resolution import RECORDS_PER_PERIOD, thinning
from vsb.study.specs import SimulateSpec, Spec
from vsb.study.waves import IrregularSea, Wave

FIGURE_KINDS = ("svg", "pdf", "csv")
"""Files of every figure: for a page, for print, and the data behind it."""


def figure_paths(folder: str, names: Iterable[str]) -> list[str]:
    """Return the paths of all files of some figures of the results in a folder."""
    return [f"{folder}/figures/{name}.{kind}" for name in names for kind in FIGURE_KINDS]


def trajectory_name(design: str, wave: str) -> str:
    """Return the file name of the time series of one design in one sea."""
    return f"{design}-{wave}.nc"


def options(files: dict[str, str]) -> str:
    """Return command-line options that name files; file names of this project need no quotes."""
    return " ".join(f"--{name} {path}" for name, path in files.items())


def quoted(files: Mapping[str, str]) -> str:
    """Return command-line options that name files of a user's, whose names may hold anything."""
    return " ".join(f"--{name} {shlex.quote(path)}" for name, path in files.items())


class ResultsFolder(ABC):
    """Where the results of a study or a campaign lie."""

    root: str  # of all results

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the study or campaign."""

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


class ResultsPlan(ResultsFolder):
    """Results of a study in a folder of results, as files with content ids."""

    study: BaseStudy

    @property
    @abstractmethod
    def database(self) -> Spec:
        """Spec of the hydro database."""

    @property
    @abstractmethod
    def radiation(self) -> Spec:
        """Spec of the radiation model."""

    @property
    @abstractmethod
    def response(self) -> Spec:
        """Spec of the frequency response."""

    @property
    @abstractmethod
    def ladder(self) -> Spec:
        """Spec of the tuning ladder."""

    @property
    @abstractmethod
    def comparison(self) -> Spec:
        """Spec of the comparison."""

    @abstractmethod
    def simulation(self, design: str, wave: Wave) -> SimulateSpec | BodySimulateSpec:
        """Spec of one time-domain run."""

    @property
    def shape_ids(self) -> dict[str, str]:
        """Files that show the shapes of the motions, each with its id; none of a body, whose own files hold them."""
        return {}

    @property
    def modes_files(self) -> dict[str, str]:
        """Shapes of the modes, by the option that names them; none of a body, likewise."""
        return {}

    @property
    def solved_files(self) -> list[str]:
        """Files solved of the water on the way to the database, named by their ids; of a body one job keeps its own."""
        return []

    @property
    def witness_files(self) -> dict[str, str]:
        """What two solvers say of the same shapes, by the option that names it; none without a second solver."""
        return {}

    @property
    @abstractmethod
    def figures(self) -> list[str]:
        """Names of all figures."""

    @property
    @abstractmethod
    def coordinates(self) -> int:
        """How many degrees of freedom a run may record."""

    @property
    @abstractmethod
    def highest(self) -> float:
        """Highest frequency a sea may have components at [rad/s]."""

    @property
    @abstractmethod
    def products(self) -> list[str]:
        """All files a run of the study promises."""

    # content ids ----------------------------------------------------------------------------------------------------

    @cached_property
    def hydro_ids(self) -> tuple[str, ...]:
        """Ids of the hydrodynamic files the time domain reads."""
        return (content_id(self.database), content_id(self.radiation)) if self.study.needs_bem else ()

    def trajectory_id(self, design: str, wave: Wave) -> str:
        """Id of one time-domain run."""
        return result_id(self.simulation(design, wave), *self.hydro_ids)

    @property
    def response_id(self) -> str:
        """Id of the frequency response."""
        return result_id(self.response, self.hydro_ids[0])

    @property
    def ladder_id(self) -> str:
        """Id of the tuning ladder."""
        return result_id(self.ladder, self.hydro_ids[0])

    @cached_property
    def study_id(self) -> str:
        """Id of what is made of all results together: tables, figures, report; designs in any order."""
        response = [self.response_id, self.ladder_id] if self.study.needs_bem else []
        runs = [self.trajectory_id(design, wave) for wave in self.study.waves for design in sorted(self.study.designs)]
        witness = [PurePosixPath(path).stem for path in self.witness_files.values()]
        shapes = dict.fromkeys(identity for path, identity in self.shape_ids.items() if not self.is_shared(path))
        return result_id(self.comparison, *shapes, *self.hydro_ids, *witness, *response, *runs)

    @cached_property
    def ids(self) -> dict[str, str]:
        """Id every file of the study must carry, those solved on the way included: a new product needs no entry.

        Files under `hydro` are named by theirs; what is not of one stage of its own is of the whole study.
        """
        own = {
            self.trajectory_path(d, w.label): self.trajectory_id(d, w)
            for w in self.study.waves
            for d in self.study.designs
        }
        if self.study.needs_bem:
            own |= dict.fromkeys(self.response_files.values(), self.response_id)
            own |= dict.fromkeys((f"{self.folder}/ladder.csv", *self.ladder_files.values()), self.ladder_id)
        own |= self.shape_ids
        return {path: own.get(path) or self._named_id(path) for path in [*self.products, *self.solved_files]}

    def _named_id(self, path: str) -> str:
        """Id in the name of a shared file or of its folder; of any other that of the study."""
        if not self.is_shared(path):
            return self.study_id
        name = PurePosixPath(path)
        return name.stem if re.fullmatch("[0-9a-f]{16}", name.stem) else name.parent.name

    # memory ---------------------------------------------------------------------------------------------------------

    def record_megabytes(self, wave: Wave) -> int:
        """Memory that the time series of a design in a sea take [MB]: nine of every coordinate, ten others."""
        duration = self.study.simulation.duration
        instants = int(RECORDS_PER_PERIOD * self.study.fastest(wave) * duration / (2 * math.pi))
        return math.ceil(8e-6 * (9 * self.coordinates + 10) * instants / thinning(instants + 1))

    def simulation_megabytes(self, wave: Wave) -> int:
        """Memory that a run in a sea takes [MB]: its record thrice, what a leg takes, and the sea's components."""
        band = self.highest if isinstance(wave, IrregularSea) else 0.0
        return 800 + 3 * self.record_megabytes(wave) + math.ceil(6e-4 * band * self.study.simulation.duration)

    @property
    def study_megabytes(self) -> int:
        """Memory that the time series of all designs in a sea take at one time [MB], and what drawing them takes."""
        largest = max(self.record_megabytes(wave) for wave in self.study.waves)
        return 800 + math.ceil(1.2 * len(self.study.designs) * largest)

    # file names -----------------------------------------------------------------------------------------------------

    @property
    def database_path(self) -> str:
        """Hydro database."""
        return f"{self.root}/hydro/db/{content_id(self.database)}.nc"

    @property
    def radiation_path(self) -> str:
        """Radiation model."""
        return f"{self.root}/hydro/radiation/{content_id(self.radiation)}.nc"

    @property
    def green_folder(self) -> str:
        """Folder of the Green-function table."""
        return f"{self.root}/hydro/green/{panel_solver().replace(' ', '-')}"

    @property
    def name(self) -> str:
        """Name of the study."""
        return self.study.study

    def trajectory_path(self, design: str, wave: str) -> str:
        """Time series of one design in one sea."""
        return f"{self.folder}/trajectories/{trajectory_name(design, wave)}"

    @property
    def answers(self) -> list[str]:
        """Files of results that every study has."""
        waves = [wave.label for wave in self.study.waves]
        tables = ["comparison.csv", "statistics.csv", "validity.json", "study.json", "tables.json"]
        return [
            *(f"{self.folder}/{name}" for name in ["report.html", *tables]),
            *figure_paths(self.folder, self.figures),
            *(self.trajectory_path(design, wave) for wave in waves for design in self.study.designs),
            *self.hydro_files.values(),
            *self.response_files.values(),
            *([f"{self.folder}/ladder.csv"] if self.study.needs_bem else []),
            *self.ladder_files.values(),
        ]

    @property
    def hydro_files(self) -> dict[str, str]:
        """Hydrodynamic files the time domain reads, by the option that names them; none without BEM."""
        return {"database": self.database_path, "radiation": self.radiation_path} if self.study.needs_bem else {}

    @property
    def response_files(self) -> dict[str, str]:
        """The frequency response, by the option that names it; none without BEM."""
        return {"response": f"{self.folder}/response.nc"} if self.study.needs_bem else {}

    @property
    def ladder_files(self) -> dict[str, str]:
        """The tuning ladder with all digits, by the option that names it; none without BEM."""
        return {"rungs": f"{self.folder}/ladder.json"} if self.study.needs_bem else {}
