"""What a study of a body computes: its database by contents of its files, then what every study does. Pure Python."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from vsb.study.blocks import panel_solver
from vsb.study.body import NEEDED, WAMIT, BodyStudy, located
from vsb.study.body_file import PHYSICS, BodyFile
from vsb.study.body_specs import (
    BodyCompareSpec,
    BodyLadderSpec,
    BodyRadiationSpec,
    BodyResponseSpec,
    BodySimulateSpec,
    BodySpec,
)
from vsb.study.canonical import content_id
from vsb.study.plan import StudyPlan
from vsb.study.results_plan import ResultsPlan
from vsb.study.study import Study
from vsb.study.waves import RegularWave, Wave

OF_THE_BAND = ("absorbed_power", "reactance", "added_mass_damping", "radiation_kernel")
OF_A_SEA = ("port_motion", "degrees_of_freedom", "power_energy", "energy_audit")
_MOST_MOTIONS, _HIGHEST = 40, 20.0  # for memory alone: degrees of freedom and band of a body whose file is not read yet


@dataclass(frozen=True)
class BodyPlan(ResultsPlan):
    """Everything a study of a body needs computed, as specs with content ids; files are where its contents lie."""

    study: BodyStudy
    root: str = "results"
    files: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, raw: Mapping[str, Any], source: str) -> "BodyPlan":
        """Return the plan of a study given as nested mappings, with the results folder, if not `results`, as `root`."""
        plain = {key: value for key, value in raw.items() if key != "root"} if "root" in raw else raw
        found = located(plain, os.path.relpath(source))
        return cls(found.study, root=raw.get("root", "results"), files=found.files)

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
            solver=panel_solver() if self.solves else "",
            solved=PHYSICS if self.solves else 0,
        )

    @property
    def radiation(self) -> BodyRadiationSpec:
        """Spec of the radiation memory."""
        hydro = self.study.hydro
        return BodyRadiationSpec(
            database=content_id(self.database), tolerance=hydro.tolerance, added_mass_inf=hydro.added_mass_inf
        )

    @property
    def response(self) -> BodyResponseSpec:
        """Spec of the frequency response."""
        omega = {wave.omega for wave in self.study.waves if isinstance(wave, RegularWave)}
        return BodyResponseSpec(directions=self.study.directions, omega=tuple(sorted(omega)), **self._sections())

    @property
    def ladder(self) -> BodyLadderSpec:
        """Spec of the tuning ladder; it follows no motion, so a method is none of its own."""
        simulation = self.study.simulation.model_copy(update={"method": "auto"})
        return BodyLadderSpec(waves=self.study.waves, simulation=simulation, **self._sections())

    def simulation(self, design: str, wave: Wave) -> BodySimulateSpec:
        """Spec of one time-domain run: of the take-off its own damper, or how to find it."""
        study, tuning = self.study, self.study.tuning(wave)
        damping = study.pto.damper(design) if tuning == "fixed" else None
        own = {
            "designs": {design: study.designs[design]},
            "pto": study.pto.model_copy(update={"damping": damping, "tuning": tuning}),
        }
        seas = study.one_of_each_sea if tuning == "one" else ()
        run: dict[str, Any] = {"waves": (wave,), "seas": seas}
        return BodySimulateSpec(simulation=study.simulation, **run, **{**self._sections(), **own})

    @property
    def comparison(self) -> BodyCompareSpec:
        """Spec of the comparison."""
        return BodyCompareSpec(study=self.study)

    def _sections(self) -> dict[str, Any]:
        """Sections every stage after the database reads."""
        return {name: getattr(self.study, name) for name in ("designs", "water", "pto")}

    @property
    def figures(self) -> list[str]:
        """Names of all figures."""
        seas = ["spectra"] if self.study.has_spectra else []
        return [*OF_THE_BAND, *seas, *(f"{name}-{wave.label}" for wave in self.study.drawn_waves for name in OF_A_SEA)]

    @property
    def coordinates(self) -> int:
        """How many degrees of freedom a run may record."""
        return len(self.study.dofs or ()) or _MOST_MOTIONS

    @property
    def highest(self) -> float:
        """Highest frequency a sea may have components at [rad/s]."""
        return self.study.body.file.omega[-1] if isinstance(self.study.body.file, BodyFile) else _HIGHEST

    @property
    def products(self) -> list[str]:
        """All files a run of the study promises."""
        return self.answers

    @property
    def sources(self) -> dict[str, str]:
        """What the database is made from beside its spec, by option: the body's files, and where a mesh is solved."""
        solving = {"folder": f"{self.root}/hydro/bodies", "green": self.green_folder} if self.solves else {}
        return {**self.files, **solving}

    @property
    def inputs(self) -> list[str]:
        """Files the database is made from."""
        endings = {"wamit": WAMIT[:NEEDED]}
        files = [f"{path}{ending}" for kind, path in self.files.items() for ending in endings.get(kind, ("",))]
        return [*files, f"{self.green_folder}.done"] if self.solves else files

    @property
    def solves(self) -> bool:
        """Whether the database is solved of a mesh, not read."""
        return isinstance(self.study.body.file, BodyFile)


AnyPlan = StudyPlan | BodyPlan


def plan_for(study: Study | BodyStudy, root: str = "results") -> AnyPlan:
    """Return the plan of a study whose files, if it is of a body, need not be found: names and ids are known by it."""
    return BodyPlan(study, root=root) if isinstance(study, BodyStudy) else StudyPlan(study, root=root)
