"""The scene of one design in one sea, from the files of a study, by its hydrodynamic model."""

import time as clock
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vsb.hydro import database
from vsb.hydro.dofs import flexible
from vsb.hydro.kernel import DampingSpectrum
from vsb.hydro.statespace import RadiationModel
from vsb.motion.builders import assumed_pressure_scene, body_exact_scene, linear_scene
from vsb.motion.forces import AssumedPressure
from vsb.motion.frequency import LinearBuoy
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.scenes import automatic
from vsb.scenes.take_off import with_take_off
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis, design_motions, mode_basis, rigid_basis, study_basis
from vsb.study.study import RegularWave, Study
from vsb.tools.files import load
from vsb.tools.units import FloatArray
from vsb.waves.seas import NO_WAVES, Sea, sea


class DesignInSea(NamedTuple):
    """One design in one sea."""

    scene: Scene
    shape: DeformedShell  # reference shape
    sea: Sea
    spectrum: DampingSpectrum | None  # of the radiation damping, where there is one
    notes: dict[str, Any]  # what the run records of its model

    @property
    def system(self) -> System:
        """The scene as integrators see it."""
        return System.of(self.scene)


def linear_buoy(study: Study, database_path: str) -> tuple[LinearBuoy, ModeBasis]:
    """Return the linear buoy of a study from its database, and the shell modes."""
    ds = database.load_database(database_path, Path(database_path).stem)
    shell_moves = flexible(ds.influenced_dof.values)  # of the database: a rigid design may share it with flexible ones
    modes = study.modes
    basis = mode_basis(study.device, modes.basis, modes.degree) if shell_moves else rigid_basis(study.device)
    return LinearBuoy(ds, basis.damping, LinearPto(study.pto.damping)), basis


def linear_design(study: Study, paths: dict[str, Any]) -> DesignInSea:
    """Return the scene of linear hydrodynamics about the mean shape."""
    buoy, shape, model, waves, motions = _from_bem(study, paths)
    scene = with_take_off(linear_scene(buoy, model, waves, motions), study.pto)
    return DesignInSea(scene, shape, waves, buoy.spectrum, {"model": "linear"})


def body_exact_design(study: Study, paths: dict[str, Any]) -> DesignInSea:
    """Return the scene with static and Froude-Krylov forces on the instantaneous wet shell, the rest linear."""
    buoy, shape, model, waves, motions = _from_bem(study, paths)
    scene = body_exact_scene(buoy, shape, model, waves, motions)
    return DesignInSea(scene, shape, waves, buoy.spectrum, {"model": "body_exact"})


def automatic_design(study: Study, paths: dict[str, Any]) -> DesignInSea:
    """Return the cheapest scene that gives the mean absorbed power to the tolerance of the study."""
    begun = clock.perf_counter()
    buoy, shape, model, waves, _ = _from_bem(study, paths)
    (design,) = study.designs
    ladder = automatic.motion_ladder(study, shape.basis, design)
    scenes = automatic.Scenes(buoy, shape, model, waves, ladder, study.simulation)
    choice = automatic.chosen(scenes, study.hydro.allowed_power_error)
    notes = {**choice.notes, "choice_seconds": clock.perf_counter() - begun}
    return DesignInSea(choice.scene, shape, waves, buoy.spectrum, notes)


def _from_bem(study: Study, paths: dict[str, Any]) -> tuple[LinearBuoy, DeformedShell, RadiationModel, Sea, FloatArray]:
    """What a scene with BEM is made of: buoy, reference shape, radiation model, sea, motions of the design."""
    (design,), (wave,) = study.designs, study.waves
    buoy, basis = linear_buoy(study, paths["database"])
    ds = load(paths["radiation"], expected=Path(paths["radiation"]).stem)
    model = RadiationModel(ds.state_matrix.values, ds.input_matrix.values, ds.channel.values)
    waves = sea(wave, study.hydro.omega_max, study.simulation.duration)
    shape = DeformedShell(basis, study.centre_height, buoy.database.reference_amplitude.values)
    return buoy, shape, model, waves, design_motions(study, basis, design)


def assumed_pressure_design(study: Study, _: dict[str, Any]) -> DesignInSea:
    """Return the scene with static and assumed pressure on the wet shell; a rigid design needs no shell modes."""
    (design,), (wave,) = study.designs, study.waves
    basis = study_basis(study)
    omega = wave.omega if isinstance(wave, RegularWave) else 0.0
    load = AssumedPressure(study.hydro.pressure or 0.0 if omega else 0.0, omega)
    shell, water = DeformedShell(basis, study.centre_height, np.zeros(len(basis.labels))), study.water
    motions = design_motions(study, basis, design)
    scene = assumed_pressure_scene(shell, LinearPto(study.pto.damping), load, water.density, water.gravity, motions)
    return DesignInSea(scene, shell, NO_WAVES, None, {"model": "assumed_pressure"})


SCENES = {
    "linear": linear_design,
    "body_exact": body_exact_design,
    "assumed_pressure": assumed_pressure_design,
    "auto": automatic_design,
}
"""Hydrodynamic model -> the scene of one design in one sea."""
