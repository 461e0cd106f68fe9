"""The scene of one design in one sea, from the files of a study, by its hydrodynamic model."""

import time as clock
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vsb.engine.hydro.radiation import DampingSpectrum, RadiationModel
from vsb.engine.motion.forces import AssumedPressure
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.reduced import ReducedMotions, reduced_motions
from vsb.engine.motion.scene import Scene, assumed_pressure_scene, body_exact_scene, linear_scene, unit_heave
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import Pto, SeveralPorts
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.orders import OrderBasis, all_clamp_rows
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.errors import DatabaseError
from vsb.models import automatic
from vsb.models.drag import dragged, dragged_port, linearised, with_drag
from vsb.models.floating_system import (
    FloatingSystem,
    expected_sea,
    floating_system,
    heading,
    heading_in,
    held_rows,
    study_sea,
)
from vsb.models.latching import (
    NEAR,
    LatchingTime,
    body_exact_latching_time,
    linear_damper_and_time,
    linear_latching_time,
    longest_time,
    strongest,
    with_latching_time,
)
from vsb.models.rest import design_motions, mooring_rows, order_bases, rubber_shell, study_basis
from vsb.models.stationary import controlled
from vsb.models.take_off import tuned_take_off, with_take_off
from vsb.study.sections import POWER_TOLERANCE
from vsb.study.specs import BodySystem, BuoySystem, Dynamics, SimulateSpec
from vsb.tools.arrays import FloatArray
from vsb.tools.files import load

UNFOLLOWED = 1e-3
"""Share of a sea's variance that may lie where a radiation memory does not follow the coefficients."""
LIGHTEST = 0.01
"""Least damper tried with latching, over the best one without."""
TUNED = "tuned_damping"
"""What a run records of its damper, if it was not given [N s/m]."""
TUNED_MATRIX = "tuned_damper_matrix"
"""What it records of the damper matrix of several ports, row by row."""


class Memory(NamedTuple):
    """The radiation memory of a body."""

    model: RadiationModel
    added_mass_inf: FloatArray  # it was fitted with (dof, dof) [kg]
    up_to: float = np.inf  # frequency up to which it follows the coefficients [rad/s]


class DesignInSea(NamedTuple):
    """One design in one sea."""

    scene: Scene
    shape: DeformedShell | None  # reference shape; none of a body
    sea: Sea
    spectrum: DampingSpectrum | None  # of the radiation damping, where there is one
    notes: dict[str, Any]  # what the run records of its model
    held: FloatArray  # combinations of degrees of freedom held at zero, Phi q = 0 (constraint, dof)
    orders: Sequence[OrderBasis] = ()  # of a shell that moves in more directions than heave
    port: FloatArray | None = None  # b (dof,) of a body, whose port is no point of the shape

    @property
    def system(self) -> System:
        """The scene as integrators see it."""
        return System.of(self.scene)


def design_in_sea(run: SimulateSpec, paths: dict[str, Any]) -> DesignInSea:
    """Return the scene of a run by what floats and its hydrodynamic model, and what goes with it.

    Parameters
    ----------
    paths : mapping of option to path
        `database` and `radiation`, where the model has them.
    """
    return SCENES[run.hydro.model if run.hydro else "body"](run, paths)


def radiation_model(path: str, labels: Sequence[str]) -> RadiationModel:
    """Return a radiation model as it was stored, over labelled degrees of freedom; others radiate nothing."""
    ds = load(path, expected=Path(path).stem).reindex(radiating_dof=list(labels), fill_value=0)
    return RadiationModel(ds.state_matrix.values, ds.input_matrix.values, ds.channel.values)


def linear_design(run: SimulateSpec, paths: dict[str, Any]) -> DesignInSea:
    """Return the scene of linear hydrodynamics about the mean shape."""
    at = _from_bem(run, paths)
    scene, notes = _tuned_in_time(_linear(run, at), run, at)
    return at.with_scene(with_drag(scene, _buoy_of(run)[0], run.waves[0], at.sea), notes, {"model": "linear"})


def body_exact_design(run: SimulateSpec, paths: dict[str, Any]) -> DesignInSea:
    """Return the scene with static and Froude-Krylov forces on the instantaneous wet shell, the rest linear."""
    at = _from_bem(run, paths)
    rubber = rubber_shell(_buoy_of(run)[0], at.shape.basis)
    scene = body_exact_scene(at.buoy, at.shape, at.radiation, at.sea, at.motions, rubber)
    scene, notes = _tuned_in_time(with_take_off(scene, run.pto, at.buoy.pto), run, at)
    return at.with_scene(with_drag(scene, _buoy_of(run)[0], run.waves[0], at.sea), notes, {"model": "body_exact"})


def automatic_design(run: SimulateSpec, paths: dict[str, Any]) -> DesignInSea:
    """Return the cheapest scene that gives the mean absorbed power to the tolerance of the run."""
    begun = clock.perf_counter()
    at = _from_bem(run, paths)
    (design,), (buoy, hydro) = run.designs, _buoy_of(run)
    ladder = automatic.motion_ladder(buoy, at.shape.basis, design)
    rubber = rubber_shell(buoy, at.shape.basis)
    scenes = automatic.Scenes(at.buoy, at.shape, at.radiation, at.sea, ladder, run.simulation, rubber)
    choice = automatic.chosen(scenes, hydro.power_tolerance or POWER_TOLERANCE)
    return at.with_scene(choice.scene, {**choice.notes, "choice_seconds": clock.perf_counter() - begun})


class _FromBem(NamedTuple):
    """What a scene with BEM is made of."""

    buoy: LinearSystem  # with the take-off of the run
    shape: DeformedShell  # reference shape
    radiation: RadiationModel
    sea: Sea
    motions: FloatArray  # of the design; of a linear model reduced ones (`vsb.engine.motion.reduced`)
    notes: dict[str, Any]  # of the take-off
    held: FloatArray  # clamps of the design (constraint, dof)
    orders: Sequence[OrderBasis]  # beside heave and axisymmetric modes
    floating: FloatingSystem
    spectral: tuple[Wave, Sea]  # the wave and the sea powers are expected in

    def with_scene(self, scene: Scene, *notes: dict[str, Any]) -> DesignInSea:
        """The design in its sea by a scene."""
        said = {key: value for note in (self.notes, *notes) for key, value in note.items()}
        return DesignInSea(scene, self.shape, self.sea, self.buoy.spectrum, said, self.held, self.orders)


def _linear(run: SimulateSpec, at: _FromBem) -> Scene:
    """The linear scene with the take-off of a run."""
    return with_take_off(linear_scene(at.buoy, at.radiation, at.sea, at.motions), run.pto, at.buoy.pto)


def _tuned_in_time(scene: Scene, run: SimulateSpec, at: _FromBem) -> tuple[Scene, dict[str, Any]]:
    """A scene with the latching time or causal controller that maximises mean power, if its law has one; metadata.

    A damper tuned to its sea is found together with the latching time by linear hydrodynamics; where the water's force
    is not linear the time is refined on the scene itself.
    """
    if run.pto.law == "causal" and scene.law:
        (design,) = run.designs
        return controlled(scene, at.floating, design, run.pto, *at.spectral)
    if not (run.pto.has_latching_time and scene.law):  # or nothing there moves
        return scene, {}
    damper, best, notes = _latched(_linear(run, at), run, at.sea, at.buoy, at.motions)
    if scene.water is not None and at.sea.omega.size:
        notes |= {"linear_latching_time": best.time, "latching_time_searched": NEAR * longest_time(at.sea)}
        latched = with_latching_time(scene, best.time, damper)
        best = body_exact_latching_time(latched, best, at.sea, run.simulation)
    return with_latching_time(scene, best.time, damper), notes | _noted(best)


def _latched(
    linear: Scene, run: SimulateSpec, sea: Sea, floating: LinearSystem, motions: FloatArray
) -> tuple[float, LatchingTime, dict[str, float]]:
    """Damper [N s/m] and latching time in a linear scene; a damper tuned to its sea is found with it, and recorded."""
    if run.pto.tuning != "each":
        return float(floating.pto.damping), linear_latching_time(linear, sea, run.simulation), {}
    damper, best = linear_damper_and_time(linear, sea, run.simulation, _dampers(floating, motions, sea))
    return damper, best, {TUNED: damper}


def _noted(best: LatchingTime) -> dict[str, float]:
    """What a run records of its latching time: its length [s], the mean power [W], what it is known to [s]."""
    return {"latching_time": best.time, "latching_power": best.power, "latching_time_within": best.within}


def _dampers(floating: LinearSystem, motions: FloatArray, sea: Sea) -> list[float]:
    """Dampers from the resistance of the port at the strongest wave up to the best one alone, ascending [N s/m].

    Latching takes the reactance away: what is left to match is the resistance, or a little more.
    """
    alone, direction = float(floating.pto.damping), floating.pto.direction(len(motions))
    impedance = floating.port(np.array([strongest(sea)]), motions, direction).impedance
    least = max(float(impedance.real[0]), LIGHTEST * alone)
    return [float(damping) for damping in np.geomspace(min(least, alone), max(least, alone), 3)]


def _from_bem(run: SimulateSpec, paths: dict[str, Any]) -> _FromBem:
    """What a scene of one design in one sea is made of; a damper is tuned to that sea, or to those named."""
    (design,), (wave,), (system, hydro) = run.designs, run.waves, _buoy_of(run)
    floating = floating_system(system, paths["database"])
    model = radiation_model(paths["radiation"], floating.linear.labels)
    shape, motions, ds = floating.shell, floating.motions[design], floating.linear.database
    orders = order_bases(system, shape.basis)
    waves, spectral = study_sea(run, wave, ds), expected_sea(run, wave, ds)
    others = [(w, expected_sea(run, w, ds)) for w in run.seas]
    dragged = partial(dragged_port, system) if system.plates else None
    pto = tuned_take_off(run.pto, design, floating, others or [(wave, spectral)], dragged)
    notes = tuned_notes(run.pto, pto)
    notes |= linearised(system, floating, design, pto, wave, spectral)
    buoy = replace(floating.towards(heading_in(wave, waves)), pto=pto)
    if hydro.model == "linear":
        reduced = _reduced(floating, design, system)
        motions, notes = reduced.motions, notes | reduced.notes
    held = all_clamp_rows(system.designs[design].clamp, shape.basis, orders)
    if not orders:
        held = np.concatenate([held, mooring_rows(system, shape.basis)])
    return _FromBem(buoy, shape, model, waves, motions, notes, held, orders, floating, (wave, spectral))


def _reduced(floating: FloatingSystem, design: str, system: BuoySystem) -> ReducedMotions:
    """The motions of a design that waves, take-off, drag and initial conditions in heave excite."""
    linear, motions = floating.linear, floating.motions[design]
    loaded = floating.port.reshape(len(motions), -1)
    if system.plates:
        loaded = np.column_stack([loaded, dragged(system.plates, linear.labels).T])
    heave = unit_heave(linear.labels, linear.mass + linear.added_mass_inf, motions)
    return reduced_motions(linear, motions, loaded, heave)


def tuned_notes(pto: Pto, linear: LinearPto) -> dict[str, Any]:
    """Return what a run records of a damper that was not given: of several ports the matrix, row by row."""
    if pto.tuning == "fixed":
        return {}
    if isinstance(pto.port, SeveralPorts):
        return {TUNED_MATRIX: np.asarray(linear.damping).ravel().tolist()}
    return {TUNED: float(np.asarray(linear.damping).ravel()[0])}


def body_design(run: SimulateSpec, paths: dict[str, Any]) -> DesignInSea:
    """Return the scene of a body, linear about its rest; a damper to be tuned is to suit its sea, or those named."""
    (design,), (wave,), system = run.designs, run.waves, run.system
    assert isinstance(system, BodySystem)
    floating = floating_system(system, paths["database"])
    body = floating.linear
    waves = study_sea(run, wave, body.database)
    tuned_in = [(one, expected_sea(run, one, body.database)) for one in run.seas or (wave,)]
    dragged = partial(dragged_port, system) if system.plates else None
    pto = tuned_take_off(run.pto, design, floating, tuned_in, dragged)
    notes = {"model": "linear"} | ({} if run.pto.tuning == "fixed" else {TUNED: float(pto.damping)})
    notes |= linearised(system, floating, design, pto, wave, expected_sea(run, wave, body.database))
    motions = floating.motions[design]
    equipped = replace(floating.towards(heading(wave)), pto=pto)
    memory = body_memory(paths["radiation"])
    check_followed(memory, waves, wave.label)
    scene = linear_scene(equipped, memory.model, waves, motions, memory.added_mass_inf)
    scene = with_drag(with_take_off(scene, run.pto, pto), system, wave, waves)
    if run.pto.has_latching_time and scene.law:
        damper, best, tuned = _latched(scene, run, waves, equipped, motions)
        scene = with_latching_time(scene, best.time, damper)
        notes |= tuned | _noted(best)
    if run.pto.law == "causal" and scene.law:
        scene, own = controlled(scene, floating, design, run.pto, wave, expected_sea(run, wave, body.database))
        notes |= own
    held = held_rows(system.designs[design], scene.labels)
    return DesignInSea(scene, None, waves, body.spectrum, notes, held, port=floating.port)


def check_followed(memory: Memory, waves: Sea, label: str) -> None:
    """Check that a memory follows the coefficients where a sea has its waves.

    Raises `DatabaseError` if more than `UNFOLLOWED` of the variance of the sea lies above.
    """
    squares = np.abs(waves.amplitude) ** 2
    beyond = float(squares[waves.omega > memory.up_to + 1e-9].sum() / (squares.sum() or 1.0))
    if beyond > UNFOLLOWED:
        raise DatabaseError(
            f"radiation memory: follows the coefficients up to {memory.up_to:.4g} rad/s, but {100 * beyond:.2g} % of "
            f"the variance of {label} lies above; needs coefficients without irregular frequencies there (smaller "
            "panels, smaller steps of frequency), or longer waves"
        )


def body_memory(path: str) -> Memory:
    """Return the radiation memory of a body as it was stored, with its added mass at infinite frequency."""
    ds = load(path, expected=Path(path).stem)
    model = RadiationModel(ds.state_matrix.values, ds.input_matrix.values, ds.channel.values)
    return Memory(model, ds.added_mass_inf.values, float(ds.attrs.get("up_to", np.inf)))


def assumed_pressure_design(run: SimulateSpec, _: dict[str, Any]) -> DesignInSea:
    """Return the scene with static and assumed pressure on the wet shell; a rigid design needs no shell modes."""
    (design,), (wave,), (buoy, hydro), pto = run.designs, run.waves, _buoy_of(run), run.pto
    basis = study_basis(buoy)
    omega = wave.omega if wave.regular else 0.0
    load = AssumedPressure(hydro.pressure or 0.0 if omega else 0.0, omega)
    shell, water = DeformedShell(basis, buoy.centre_height, np.zeros(len(basis.labels))), run.water
    motions, take_off = design_motions(buoy, basis, design), LinearPto(pto.damper(design) or 0.0, pto.stiffness)
    scene = assumed_pressure_scene(shell, take_off, load, water.density, water.gravity, motions)
    scene, held = with_take_off(scene, pto, take_off), all_clamp_rows(buoy.designs[design].clamp, basis, ())
    return DesignInSea(scene, shell, NO_WAVES, None, {"model": "assumed_pressure"}, held)


SCENES = {
    "linear": linear_design,
    "body_exact": body_exact_design,
    "assumed_pressure": assumed_pressure_design,
    "auto": automatic_design,
    "body": body_design,
}
"""Hydrodynamic model of a buoy, or a body -> the scene of one design in one sea."""


def _buoy_of(run: SimulateSpec) -> tuple[BuoySystem, Dynamics]:
    """The buoy of a run and its hydrodynamic model."""
    assert run.buoy is not None
    assert run.hydro is not None
    return run.buoy, run.hydro
