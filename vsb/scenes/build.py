"""The scene of one design in one sea, from the files of a study, by its hydrodynamic model."""

import time as clock
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vsb.hydro import database
from vsb.hydro.dofs import flexible
from vsb.hydro.kernel import DampingSpectrum
from vsb.hydro.statespace import RadiationModel
from vsb.motion.builders import assumed_pressure_scene, body_exact_scene, linear_scene
from vsb.motion.forces import AssumedPressure
from vsb.motion.frequency import LinearBuoy, with_open_chamber
from vsb.motion.port import port_direction
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene
from vsb.motion.system import System, TakeOff
from vsb.scenes import automatic
from vsb.scenes.pause import best_pause_in_sea, with_pause
from vsb.scenes.take_off import linear_take_off, with_take_off
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import ModeBasis, design_motions, mode_basis, rigid_basis, study_basis
from vsb.study.study import RegularWave, Study, Wave
from vsb.tools.files import load
from vsb.tools.units import FloatArray
from vsb.waves.seas import NO_WAVES, Sea, sea

TUNED = "tuned_damping"
"""What a run records of its damper, if it was not given [N s/m]."""


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
    """Return the linear buoy of a study, without take-off, from its database, and the shell modes.

    To a take-off of the volume trapped gas is a chamber before it.
    """
    ds = database.load_database(database_path, Path(database_path).stem)
    shell_moves = flexible(ds.influenced_dof.values)  # of the database: a rigid design may share it with flexible ones
    modes = study.modes
    basis = mode_basis(study.device, modes.basis, modes.degree) if shell_moves else rigid_basis(study.device)
    buoy = LinearBuoy(ds, basis.damping, LinearPto(0.0))
    return (with_open_chamber(buoy, study_port(study, buoy, basis)) if study.opens_chamber else buoy), basis


def rest_shape(study: Study, buoy: LinearBuoy, basis: ModeBasis) -> DeformedShell:
    """Return the shell a linear buoy moves about."""
    return DeformedShell(basis, study.centre_height, buoy.database.reference_amplitude.values)


def radiation_model(path: str) -> RadiationModel:
    """Return a radiation model as it was stored."""
    ds = load(path, expected=Path(path).stem)
    return RadiationModel(ds.state_matrix.values, ds.input_matrix.values, ds.channel.values)


def study_port(study: Study, buoy: LinearBuoy, basis: ModeBasis) -> FloatArray:
    """Return b of the take-off of a study, shape (dof,); see `vsb.motion.port.port_direction`."""
    return port_direction(study.pto.port, rest_shape(study, buoy, basis))


def linear_design(study: Study, paths: dict[str, Any], seas: Sequence[Wave] = ()) -> DesignInSea:
    """Return the scene of linear hydrodynamics about the mean shape."""
    at = _from_bem(study, paths, seas)
    return at.with_scene(*_released(_linear(study, at), study, at), {"model": "linear"})


def body_exact_design(study: Study, paths: dict[str, Any], seas: Sequence[Wave] = ()) -> DesignInSea:
    """Return the scene with static and Froude-Krylov forces on the instantaneous wet shell, the rest linear."""
    at = _from_bem(study, paths, seas)
    scene = body_exact_scene(at.buoy, at.shape, at.radiation, at.sea, at.motions)
    scene = with_take_off(scene, study.pto, at.buoy.pto)
    return at.with_scene(*_released(scene, study, at), {"model": "body_exact"})


def automatic_design(study: Study, paths: dict[str, Any], seas: Sequence[Wave] = ()) -> DesignInSea:
    """Return the cheapest scene that gives the mean absorbed power to the tolerance of the study."""
    begun = clock.perf_counter()
    at = _from_bem(study, paths, seas)
    (design,) = study.designs
    ladder = automatic.motion_ladder(study, at.shape.basis, design)
    scenes = automatic.Scenes(at.buoy, at.shape, at.radiation, at.sea, ladder, study.simulation)
    choice = automatic.chosen(scenes, study.hydro.allowed_power_error)
    return at.with_scene(choice.scene, {**choice.notes, "choice_seconds": clock.perf_counter() - begun})


class _FromBem(NamedTuple):
    """What a scene with BEM is made of."""

    buoy: LinearBuoy  # with the take-off of the run
    shape: DeformedShell  # reference shape
    radiation: RadiationModel
    sea: Sea
    motions: FloatArray  # of the design
    notes: dict[str, Any]  # of the take-off

    def with_scene(self, scene: Scene, *notes: dict[str, Any]) -> DesignInSea:
        """The design in its sea by a scene."""
        said = {key: value for note in (*notes, self.notes) for key, value in note.items()}
        return DesignInSea(scene, self.shape, self.sea, self.buoy.spectrum, said)


def _linear(study: Study, at: _FromBem) -> Scene:
    """The linear scene with the take-off of a study."""
    return with_take_off(linear_scene(at.buoy, at.radiation, at.sea, at.motions), study.pto, at.buoy.pto)


def _released(scene: Scene, study: Study, at: _FromBem) -> tuple[Scene, dict[str, Any]]:
    """A scene whose law pauses as long as takes most of its sea by linear hydrodynamics, and notes of it."""
    if not (study.pto.pauses and isinstance(scene.forces.get(scene.take_off), TakeOff)):  # or nothing there moves
        return scene, {}
    best = best_pause_in_sea(_linear(study, at), at.sea, study.simulation)
    return with_pause(scene, best.pause), {f"pause{part}": value for part, value in zip(_PAUSE, best, strict=True)}


_PAUSE = ("", "_power", "_within")
"""What a run records of its pause: its length [s], the linear mean power [W] it takes, what it is known to [s]."""


def _from_bem(study: Study, paths: dict[str, Any], seas: Sequence[Wave]) -> _FromBem:
    """What a scene of one design in one sea is made of; a damper to be tuned is to suit that sea, or seas if given."""
    (design,), (wave,) = study.designs, study.waves
    bare, basis = linear_buoy(study, paths["database"])
    model = radiation_model(paths["radiation"])
    waves, *others = (sea(w, study.hydro.omega_max, study.simulation.duration) for w in (wave, *seas))
    shape = rest_shape(study, bare, basis)
    motions, port = design_motions(study, basis, design), port_direction(study.pto.port, shape)
    pto = linear_take_off(study.pto, design, bare, motions, port, others or [waves])
    notes = {} if study.pto.tuning == "fixed" else {TUNED: float(pto.damping)}
    return _FromBem(replace(bare, pto=pto), shape, model, waves, motions, notes)


def assumed_pressure_design(study: Study, _: dict[str, Any], seas: Sequence[Wave] = ()) -> DesignInSea:
    """Return the scene with static and assumed pressure on the wet shell; a rigid design needs no shell modes."""
    (design,), (wave,) = study.designs, study.waves
    basis = study_basis(study)
    omega = wave.omega if isinstance(wave, RegularWave) else 0.0
    load = AssumedPressure(study.hydro.pressure or 0.0 if omega else 0.0, omega)
    shell, water = DeformedShell(basis, study.centre_height, np.zeros(len(basis.labels))), study.water
    motions = design_motions(study, basis, design)
    pto = LinearPto(study.pto.damper(design) or 0.0, study.pto.stiffness)
    scene = assumed_pressure_scene(shell, pto, load, water.density, water.gravity, motions)
    scene = with_take_off(scene, study.pto, pto)
    return DesignInSea(scene, shell, NO_WAVES, None, {"model": "assumed_pressure"})


SCENES = {
    "linear": linear_design,
    "body_exact": body_exact_design,
    "assumed_pressure": assumed_pressure_design,
    "auto": automatic_design,
}
"""Hydrodynamic model -> the scene of one design in one sea, of seas one damper is to suit."""
