"""What a study computes: resolution, frequency grid, blocks, content ids and file names. Pure Python.

The Snakefile builds its graph from this module alone, so a dry run shows the true plan.
"""

from dataclasses import dataclass
from typing import Any

from vsb.study.blocks import BlockSpec, HydroPlan
from vsb.study.results_plan import ResultsPlan
from vsb.study.specs import (
    Band,
    CompareSpec,
    DatabaseSpec,
    DisplaySpec,
    Dynamics,
    LadderSpec,
    LoadedMesh,
    ModesSpec,
    PanelsSpec,
    RadiationSpec,
    ResponseSpec,
    SimulateSpec,
    SphereMesh,
    WitnessSpec,
)
from vsb.study.study import RegularWave, Study, Wave, content_id, parse
from vsb.study.witness import no_witness, witness_spec

FIGURES_PER_WAVE = ("heave_excitation", "velocity_pto", "power_energy", "energy_audit", "snapshots")
FIGURES_OF_THE_SHELL = ("extreme_shapes", "shapes_3d", "volume_area")


def figure_names(study: Study) -> list[str]:
    """Return the names of all figures of a study."""
    of_bem = ("absorbed_power", "reactance", "mode_shapes", "added_mass_damping", "radiation_kernel")
    names = of_bem if study.needs_bem else ("mode_shapes",)
    if study.has_spectra:
        names = (*names, "spectra")
    if not no_witness(study):
        names = (*names, "witness")
    per_wave = (*FIGURES_PER_WAVE, *(FIGURES_OF_THE_SHELL if study.flexible else ()))
    if study.motion != "heave":  # in which no meridian stands for all of a shell
        per_wave = ("directions", *(name for name in per_wave if name != "shapes_3d"))
    return [*names, *(f"{name}-{wave.label}" for wave in study.drawn_waves for name in per_wave)]


@dataclass(frozen=True)
class StudyPlan(HydroPlan, ResultsPlan):
    """Everything a study of a buoy needs computed, as specs with content ids."""

    root: str = "results"

    @classmethod
    def of(cls, raw: dict[str, Any], source: str = "study file") -> "StudyPlan":
        """Return the plan of a study given as nested mappings, with the results folder, if not `results`, as `root`."""
        study = parse({key: value for key, value in raw.items() if key != "root"}, source=source)
        return cls(study, root=raw.get("root", "results"))

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
        """Spec of the second solver; none where there is none (`vsb.study.witness`)."""
        return None if no_witness(self.study) else witness_spec(self)

    @property
    def radiation(self) -> RadiationSpec:
        """Spec of the radiation model."""
        return RadiationSpec(database=content_id(self.database), tolerance=self.study.hydro.tolerance)

    @property
    def modes(self) -> ModesSpec:
        """Spec of the shell modes."""
        names = ("device", "modes", "reference_shape", "designs", "water", "motion", "mooring")
        return ModesSpec(**self._sections(*names))

    @property
    def response(self) -> ResponseSpec:
        """Spec of the frequency response."""
        waves = [wave.omega for wave in self.study.waves if isinstance(wave, RegularWave)]
        extra = sorted({*waves, *(omega for omega in self.study.hydro.omega if omega >= self.first_omega)})
        return ResponseSpec(
            step=self.step,
            lowest=self.first_omega,
            omega_max=self.study.hydro.omega_max,
            omega=tuple(extra),
            directions=self.study.directions,
            **self._sections("device", "modes", "designs", "water", "pto", "motion", "mooring"),
        )

    @property
    def ladder(self) -> LadderSpec:
        """Spec of the tuning ladder; it follows no motion, so a method of the study's model is none of its own."""
        names = ("device", "modes", "reference_shape", "designs", "water", "pto", "drag", "waves", "motion", "mooring")
        sections = self._sections(*names)
        simulation = self.study.simulation.model_copy(update={"method": "auto"})
        hydro = Band(omega_max=self.study.hydro.omega_max)
        return LadderSpec(hydro=hydro, simulation=simulation, **sections | {"modes": self.study.modes})

    def simulation(self, design: str, wave: Wave) -> SimulateSpec:
        """Spec of one time-domain run: of the take-off its own damper, or how to find it."""
        study = self.study
        tuning = study.pto.tuning if study.pto.damping is None else study.tuning(wave)  # a year's members lie still
        damping = study.pto.damper(design) if tuning == "fixed" else None
        return SimulateSpec(
            designs={design: study.designs[design]},
            waves=(wave,),
            hydro=Dynamics(**study.hydro.model_dump(include=set(Dynamics.model_fields))),
            pto=study.pto.model_copy(update={"damping": damping, "tuning": tuning}),
            seas=study.one_of_each_sea if tuning == "one" else (),
            **self._sections("device", "modes", "reference_shape", "water", "drag", "simulation", "motion", "mooring"),
        )

    @property
    def comparison(self) -> CompareSpec:
        """Spec of the comparison."""
        return CompareSpec(study=self.study)

    def _sections(self, *names: str) -> dict[str, Any]:
        """Sections of the study a stage reads."""
        found = {name: getattr(self.study, name) for name in names}
        return found | ({"modes": self.study.modes.without_tolerance} if "modes" in found else {})

    @property
    def figures(self) -> list[str]:
        """Names of all figures."""
        return figure_names(self.study)

    @property
    def highest(self) -> float:
        """Highest frequency a sea may have components at [rad/s]."""
        return self.study.hydro.omega_max

    @property
    def shape_ids(self) -> dict[str, str]:
        """Files that show the shapes of the motions, each with its id."""
        own = {f"{self.folder}/modes.nc": content_id(self.modes)}
        return own | dict.fromkeys(self.display_paths, content_id(self.display))

    @property
    def modes_files(self) -> dict[str, str]:
        """Shapes of the shell modes, by the option that names them."""
        return {"modes": f"{self.folder}/modes.nc"}

    @property
    def solved_files(self) -> list[str]:
        """Blocks, and meshes of panels."""
        blocks = self.bem_blocks.values()
        meshes = [self.mesh_path(block.mesh) for block in blocks if isinstance(block, PanelsSpec)]
        return [*map(self.block_path, blocks), *meshes]

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
    def products(self) -> list[str]:
        """All files a run of the study promises."""
        modes = f"{self.folder}/modes.nc"
        return [*self.answers, modes, *self.witness_files.values(), *self.deformed_paths, *self.display_paths]

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
