"""What a study computes: resolution, frequency grid, blocks, content ids and file names. Pure Python.

The Snakefile builds its graph from this module alone, so a dry run shows the true plan.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import PurePosixPath
from typing import Any, ClassVar

from vsb.engine.hydro.bodies.body_file import PHYSICS, BodyFile
from vsb.engine.hydro.panel_solver import panel_solver
from vsb.engine.integrators.settings import RECORDS_PER_PERIOD, thinning
from vsb.engine.waves.kinds import IrregularSea, RecordedSea, RegularWave, Wave
from vsb.keys.quantities import content_id, result_id
from vsb.study import figure_names
from vsb.study.blocks import BlockSpec, HydroPlan, no_witness, witness_spec
from vsb.study.body import BodyStudy, wamit_files
from vsb.study.specs import (
    AnySystem,
    Band,
    BodySpec,
    BodySystem,
    BuoySystem,
    CompareSpec,
    DatabaseSpec,
    DisplaySpec,
    Dynamics,
    LadderSpec,
    LoadedMesh,
    ModesSpec,
    RadiationSpec,
    ResponseSpec,
    SimulateSpec,
    Spec,
    SphereMesh,
    WitnessSpec,
)
from vsb.study.study import BaseStudy, Study


def database_path(root: str, identity: str) -> str:
    """Return the path of a hydro database."""
    return f"{root}/hydro/db/{identity}.nc"


def radiation_path(root: str, identity: str) -> str:
    """Return the path of a radiation model."""
    return f"{root}/hydro/radiation/{identity}.nc"


def trajectory_name(design: str, wave: str) -> str:
    """Return the file name of the time series of one design in one sea."""
    return f"{design}-{wave}.nc"


class ResultsFolder(ABC):
    """Where the results of a study, a campaign or a design problem lie."""

    KIND: ClassVar[str] = "study"
    root: str  # of all results

    @property
    @abstractmethod
    def identity(self) -> str:
        """Id of what is made of all results together: tables, figures, report."""

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

    @abstractmethod
    def system(self, *names: str, **changed: Any) -> AnySystem:
        """What floats, as a stage reads it: sections beyond those of every stage by name, others changed."""

    @property
    def _memory(self) -> dict[str, Any]:
        """What the radiation model depends on beside the database."""
        return {}

    @property
    def _response_grid(self) -> dict[str, Any]:
        """Grid of the frequency response, if it is not that of the database."""
        return {}

    @property
    def radiation(self) -> RadiationSpec:
        """Spec of the radiation model."""
        return RadiationSpec(database=content_id(self.database), tolerance=self.study.hydro.tolerance, **self._memory)

    @property
    def response(self) -> ResponseSpec:
        """Spec of the frequency response."""
        omega = {wave.omega for wave in self.study.waves if isinstance(wave, RegularWave)} | {*self._tabulated}
        grid = {"omega": tuple(sorted(omega)), "directions": self.study.directions, **self._response_grid}
        return ResponseSpec(system=self.system(), **grid)

    @property
    def _tabulated(self) -> tuple[float, ...]:
        """Frequencies the study asks for [rad/s]."""
        return ()

    @property
    def ladder(self) -> LadderSpec:
        """Spec of the control levels; nothing is followed in time, so the method of the study does not matter."""
        study, simulation = self.study, self.study.simulation.model_copy(update={"method": "auto"})
        modes = {"modes": study.buoy.modes} if study.buoy else {}
        hydro = {"hydro": Band(omega_max=study.hydro.omega_max)} if study.buoy else {}
        system = self.system("reference_shape", "drag", **modes)
        return LadderSpec(system=system, waves=study.waves, simulation=simulation, **hydro)

    def simulation(self, design: str, wave: Wave) -> SimulateSpec:
        """Spec of one time-domain run; of its take-off only the damper of this design, or how to tune it."""
        study = self.study
        tuning = study.pto.tuning if study.pto.damping is None else study.tuning(wave)  # a year's members lie still
        damping = study.pto.damper(design) if tuning == "fixed" else None
        pto = study.pto.model_copy(update={"damping": damping, "tuning": tuning})
        dynamics = study.hydro.model_dump(include=set(Dynamics.model_fields)) if study.buoy else {}
        return SimulateSpec(
            system=self.system("reference_shape", "drag", designs={design: study.designs[design]}, pto=pto),
            simulation=study.simulation,
            waves=(wave,),
            seas=study.one_of_each_sea if tuning == "one" else (),
            **({"hydro": Dynamics(**dynamics)} if dynamics else {}),
        )

    @property
    def comparison(self) -> CompareSpec:
        """Spec of the comparison."""
        return CompareSpec(study=self.study)

    @property
    def modes_id(self) -> str:
        """Id of the shapes of the shell modes; empty of a body, whose own files hold those of its motions."""
        return ""

    @property
    @abstractmethod
    def solves_panels(self) -> bool:
        """Whether coefficients are solved on panels, which takes minutes."""

    @property
    def modes_files(self) -> dict[str, str]:
        """Shapes of the modes, by the option that names them; none of a body, likewise."""
        return {}

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
        """Id of the control levels."""
        return result_id(self.ladder, self.hydro_ids[0])

    @cached_property
    def identity(self) -> str:
        """Id of what is made of all results together: tables, figures, report; designs in any order."""
        response = [self.response_id, self.ladder_id] if self.study.needs_bem else []
        runs = [self.trajectory_id(design, wave) for wave in self.study.waves for design in sorted(self.study.designs)]
        witness = [PurePosixPath(path).stem for path in self.witness_files.values()]
        modes = filter(None, [self.modes_id])
        return result_id(self.comparison, *modes, *self.hydro_ids, *witness, *response, *runs)

    # memory ---------------------------------------------------------------------------------------------------------

    def record_megabytes(self, wave: Wave) -> int:
        """Memory that the time series of a design in a sea take [MB]: nine of every coordinate, ten others."""
        duration = self.study.simulation.duration
        instants = int(RECORDS_PER_PERIOD * self.study.fastest(wave) * duration / (2 * math.pi))
        return math.ceil(8e-6 * (9 * self.coordinates + 10) * instants / thinning(instants + 1))

    def simulation_megabytes(self, wave: Wave) -> int:
        """Memory of a run in a sea [MB]: three times its record, one leg, and the components of the sea."""
        band = self.highest if isinstance(wave, IrregularSea) else 0.0
        length = wave.file.length if isinstance(wave, RecordedSea) else self.study.simulation.duration
        return 800 + 3 * self.record_megabytes(wave) + math.ceil(6e-4 * band * length)

    @property
    def study_megabytes(self) -> int:
        """Memory of the time series of all designs in a sea at once [MB], and of drawing them."""
        largest = max(self.record_megabytes(wave) for wave in self.study.waves)
        return 800 + math.ceil(1.2 * len(self.study.designs) * largest)

    # file names -----------------------------------------------------------------------------------------------------

    @property
    def database_path(self) -> str:
        """Hydro database."""
        return database_path(self.root, content_id(self.database))

    @property
    def radiation_path(self) -> str:
        """Radiation model."""
        return radiation_path(self.root, content_id(self.radiation))

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
    def hydro_files(self) -> dict[str, str]:
        """Hydrodynamic files the time domain reads, by the option that names them; none without BEM."""
        return {"database": self.database_path, "radiation": self.radiation_path} if self.study.needs_bem else {}

    @property
    def response_files(self) -> dict[str, str]:
        """The frequency response, by the option that names it; none without BEM."""
        return {"response": f"{self.folder}/response.nc"} if self.study.needs_bem else {}

    @property
    def ladder_files(self) -> dict[str, str]:
        """The control levels with all digits, by the option that names it; none without BEM."""
        return {"levels": f"{self.folder}/ladder.json"} if self.study.needs_bem else {}


@dataclass(frozen=True)
class StudyPlan(HydroPlan, ResultsPlan):
    """Everything a study of a buoy needs computed, as specs with content ids."""

    root: str = "results"

    @property
    def display(self) -> DisplaySpec:
        """Spec of the viewable meshes, deformed by axisymmetric modes."""
        modes = self._modes and self._modes.model_copy(update={"order": 1})
        return DisplaySpec(modes=modes, **self._sections("device", "water", "reference_shape"))

    @property
    def database(self) -> DatabaseSpec:
        """Spec of the hydro database."""
        hydro = self.study.hydro
        return DatabaseSpec(
            sweep=tuple(map(content_id, self.sweep_blocks)),
            tabulated=tuple(map(content_id, self.tabulated_blocks)),
            omega=hydro.omega,
            omega_max=self.highest_omega,
            modes=self._modes,
            tolerance=hydro.tolerance,
            accept=tuple(sorted(hydro.accept)),
            **self._sections("device", "reference_shape", "water", "motion", "mooring"),
        )

    @property
    def witness(self) -> WitnessSpec | None:
        """Spec of the second solver; none where there is none (`vsb.study.blocks`)."""
        return None if no_witness(self.study) else witness_spec(self)

    @property
    def modes(self) -> ModesSpec:
        """Spec of the shell modes."""
        names = ("device", "modes", "reference_shape", "designs", "water", "motion", "mooring")
        return ModesSpec(**self._sections(*names))

    def system(self, *names: str, **changed: Any) -> BuoySystem:
        """The buoy, as a stage reads it."""
        every = ("device", "water", "motion", "mooring", "modes", "designs", "pto", *names)
        return BuoySystem(**self._sections(*every) | changed)

    def _sections(self, *names: str) -> dict[str, Any]:
        """Sections of the study a stage reads."""
        found = {name: getattr(self.study, name) for name in names}
        return found | ({"modes": self.study.modes.without_tolerance} if "modes" in found else {})

    @property
    def _response_grid(self) -> dict[str, Any]:
        """Grid of the frequency response."""
        return {"step": self.step, "lowest": self.first_omega, "omega_max": self.study.hydro.omega_max}

    @property
    def _tabulated(self) -> tuple[float, ...]:
        """Frequencies the study asks for, of those solved [rad/s]."""
        return tuple(omega for omega in self.study.hydro.omega if omega >= self.first_omega)

    @property
    def figures(self) -> list[str]:
        """Names of all figures."""
        return figure_names.of_buoy(self.study)

    @property
    def highest(self) -> float:
        """Highest frequency a sea may have components at [rad/s]."""
        return self.study.hydro.omega_max

    @property
    def modes_id(self) -> str:
        """Id of the shapes of the shell modes."""
        return content_id(self.modes)

    @property
    def solves_panels(self) -> bool:
        """Whether coefficients are solved on panels, which takes minutes."""
        return self.study.uses_panels

    @property
    def modes_files(self) -> dict[str, str]:
        """Shapes of the shell modes, by the option that names them."""
        return {"modes": f"{self.folder}/modes.nc"}

    # file names -----------------------------------------------------------------------------------------------------

    def mesh_path(self, spec: SphereMesh | LoadedMesh) -> str:
        """Mesh of a block."""
        return f"{self.root}/hydro/mesh/{content_id(spec)}/mean.nc"

    def block_path(self, spec: BlockSpec) -> str:
        """Result of one BEM job."""
        return f"{self.block_folder}/{content_id(spec)}.nc"

    @property
    def block_folder(self) -> str:
        """Folder of the results of all BEM jobs."""
        return f"{self.root}/hydro/blocks"

    @property
    def display_folder(self) -> str:
        """Folder of the viewable meshes."""
        return f"{self.root}/hydro/mesh/{content_id(self.display)}"

    @property
    def witness_files(self) -> dict[str, str]:
        """What two solvers say of the same shapes, by the option that names it; none without a second solver."""
        return {"witness": f"{self.root}/hydro/witness/{content_id(self.witness)}.nc"} if self.witness else {}

    @property
    def deformed_paths(self) -> list[str]:
        """Meshes the second solver is asked about: the mean wetted shell, and one for each of its modes and signs."""
        if not self.witness:
            return []
        meshes = self.witness.meshes
        folder = f"{self.root}/hydro/mesh/{content_id(meshes)}"
        return [f"{folder}/{name}.nc" for name in ("mean", *_either_sign(meshes.deformed))]

    @property
    def display_paths(self) -> list[str]:
        """Viewable meshes: the mean wetted shell, and one per degree of freedom and sign."""
        return [f"{self.display_folder}/{name}.vtu" for name in ("mean", *_either_sign(self.mode_labels))]


def _either_sign(modes: tuple[str, ...]) -> list[str]:
    """Names of the shapes deformed by modes."""
    return [f"{mode}_{sign}" for mode in modes for sign in ("minus", "plus")]


_MOST_MOTIONS, _HIGHEST = 40, 20.0  # for memory alone: degrees of freedom and band of a body whose file is not read yet


@dataclass(frozen=True)
class BodyPlan(ResultsPlan):
    """Everything a study of a body needs computed, as specs with content ids; files are where its contents lie."""

    study: BodyStudy
    root: str = "results"
    files: Mapping[str, str] = field(default_factory=dict)

    @property
    def database(self) -> BodySpec:
        """Spec of the hydro database."""
        study = self.study
        return BodySpec(
            body=study.body,
            water=study.water,
            dofs=study.dofs,
            omega_max=study.hydro.omega_max,
            accept=tuple(sorted(study.hydro.accept)),
            repair=tuple(sorted(study.hydro.repair)),
            solver=panel_solver() if self.solves_panels else "",
            solved=PHYSICS if self.solves_panels else 0,
        )

    def system(self, *names: str, **changed: Any) -> BodySystem:
        """The body, as a stage after its database reads it."""
        study, dragged = self.study, {"drag": self.study.drag} if "drag" in names and self.study.drag else {}
        return BodySystem(**{"designs": study.designs, "water": study.water, "pto": study.pto} | dragged | changed)

    @property
    def _memory(self) -> dict[str, Any]:
        """What its radiation model depends on beside its database."""
        return {"added_mass_inf": self.study.hydro.added_mass_inf}

    @property
    def figures(self) -> list[str]:
        """Names of all figures."""
        return figure_names.of_body(self.study)

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
        solving = {"folder": f"{self.root}/hydro/bodies", "green": self.green_folder} if self.solves_panels else {}
        return {**self.files, **solving}

    @property
    def inputs(self) -> list[str]:
        """Files the database is made from."""
        each = [wamit_files(path)[:3] if kind == "wamit" else [path] for kind, path in self.files.items()]
        files = [path for paths in each for path in paths]
        return [*files, f"{self.green_folder}.done"] if self.solves_panels else files

    @property
    def solves_panels(self) -> bool:
        """Whether the database is solved on the panels of a mesh, not read."""
        return isinstance(self.study.body.file, BodyFile)


AnyPlan = StudyPlan | BodyPlan


def plan_for(study: Study | BodyStudy, root: str = "results") -> AnyPlan:
    """Return the plan of a study whose files, if it is of a body, need not be found: names and ids are known by it."""
    return BodyPlan(study, root=root) if isinstance(study, BodyStudy) else StudyPlan(study, root=root)
