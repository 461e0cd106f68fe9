"""The scene of one design in one sea, from the files of a study, by its hydrodynamic model; its latching time."""

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from vsb.engine.hydro.radiation import DampingSpectrum, RadiationModel
from vsb.engine.integrators.settings import Simulation
from vsb.engine.integrators.simulate import legs
from vsb.engine.integrators.switching import Trials, periodic_power
from vsb.engine.motion.forces import AssumedPressure
from vsb.engine.motion.linear import LinearSystem
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.reduced import reduced_motions
from vsb.engine.motion.scene import Scene, assumed_pressure_scene, body_exact_scene, linear_scene, unit_heave
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import Pto, SeveralPorts
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.orders import OrderBasis, all_clamp_rows
from vsb.engine.waves.kinds import Wave
from vsb.engine.waves.seas import NO_WAVES, Sea
from vsb.errors import ConvergenceError, DatabaseError
from vsb.models import automatic
from vsb.models.floating_system import (
    FloatingSystem,
    expected_sea,
    floating_system,
    heading_in,
    held_rows,
    study_sea,
)
from vsb.models.rest import design_motions, mooring_rows, order_bases, rubber_shell, study_basis
from vsb.models.stationary import controlled
from vsb.models.take_off import dragged, dragged_port, linearised, tuned_take_off, with_drag, with_take_off
from vsb.study.sections import POWER_TOLERANCE
from vsb.study.specs import Run
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


# latching and declutching ---------------------------------------------------------------------------------------------

# From each reversal of the velocity on latching holds the port and declutching frees it; the latching time is when that
# ends. In a regular wave the power is that of the steady motion, in an irregular sea the mean over the window of the
# study, from the run's own start: what the run will show. Both have several maxima, so latching times up to half a
# period are scanned, and the best is refined between its neighbours. In a body-exact scene the latching time of the
# linear scene is refined in its neighbourhood by body-exact trials, each begun where the best of those before ended.
# The damper that is optimal without latching is far too heavy to latch with: it is as large as the reactance that
# latching takes away. Where it is not given, damper and latching time are found together.

SCANNED, PAIRED = 16, 8
"""Latching times tried up to half a period, alone and with each of several dampers.

A maximum narrower than twice their distance may be missed.
"""
KNOWN, KNOWN_BODY_EXACT = 1e-3, 0.01
"""How well the best latching time is known in the linear and the body-exact scene, over the longest one."""
NEAR = 0.1
"""How far from the latching time of the linear scene body-exact ones are tried, over the longest one."""
STEADY, TRIED, TRIED_BODY_EXACT = 1e-4, 1e-3, 0.02
"""Relative error of the power in a regular wave: of the result, of linear trials and of body-exact ones."""
KEPT = 0.98
"""Part of the power of the trials that the motion from rest must reach, or the search is repeated from rest."""
ROUNDS = 4
"""Most times that latching time and damper are refined in turn."""
LEVEL = 1e-3
"""Relative gain of power below which another round is not worth it."""
COARSE = 0.02
"""How well the logarithm of the damper is known: the error of the power is of second order in it."""

Power = Callable[[float, float], float]
"""Damper [N s/m] and latching time [s] -> mean power [W]."""


class LatchingTime(NamedTuple):
    """The best latching time of a take-off in a sea."""

    time: float  # [s]; 0: better without
    power: float  # mean [W]
    within: float  # the time is known to [s]


def best_latching_time(power: Callable[[float], float], longest: float) -> LatchingTime:
    """Return the latching time from 0 to the longest at which a power is largest, no less than at any time tried.

    Parameters
    ----------
    power : callable
        Latching time [s] -> mean power [W].
    longest : float [s]
    """
    tried = np.linspace(0.0, longest, SCANNED + 1)
    powers = [power(float(time)) for time in tried]
    k, within = int(np.argmax(powers)), KNOWN * longest
    between = float(tried[max(k - 1, 0)]), float(tried[min(k + 1, SCANNED)])
    time, most = _refined(power, (float(tried[k]), powers[k]), between, within)
    return LatchingTime(time, most, within)


def _refined(
    power: Callable[[float], float], at: tuple[float, float], between: tuple[float, float], within: float
) -> tuple[float, float]:
    """Where a power is largest between two bounds, and what it is there: no less than at the point given."""
    found = minimize_scalar(lambda x: -power(float(x)), bounds=between, method="bounded", options={"xatol": within})
    return at if at[1] >= -found.fun else (float(found.x), -float(found.fun))


def best_damper_and_time(power: Power, dampers: Sequence[float], longest: float) -> tuple[float, LatchingTime]:
    """Return damper and latching time at which a power is largest, no less than at any pair tried.

    Parameters
    ----------
    power : callable
        Damper [N s/m] and latching time [s] -> mean power [W].
    dampers : sequence of float
        Tried with `PAIRED` times each, ascending; from the best of these pairs both are refined in turn.
    longest : float [s]
    """
    times, within = np.linspace(0.0, longest, PAIRED + 1), KNOWN * longest
    most, damper, time = max((power(c, float(time)), c, float(time)) for c in dampers for time in times)
    step, spread = longest / PAIRED, float(np.log(dampers[-1] / dampers[0])) / max(len(dampers) - 1, 1) + LEVEL
    for _ in range(ROUNDS):
        before, here = most, (max(time - step, 0.0), min(time + step, longest))
        time, most = _refined(partial(power, damper), (time, most), here, within)
        at, held = float(np.log(damper)), time

        def of_logarithm(u: float, held: float = held) -> float:
            return power(float(np.exp(u)), held)

        u, most = _refined(of_logarithm, (at, most), (at - spread, at + spread), COARSE)
        damper, step, spread = float(np.exp(u)), step / 2, spread / 2
        if most <= before * (1 + LEVEL):
            break
    return damper, LatchingTime(time, most, within)


def with_latching_time(scene: Scene, time: float, damping: float | None = None) -> Scene:
    """Return a scene whose take-off latches for so long [s], perhaps with another damper [N s/m]."""
    law = scene.law
    assert law is not None
    damper = law.damping if damping is None else damping
    return replace(scene, forces={**scene.forces, scene.take_off: replace(law, latching_time=time, damping=damper)})


def linear_latching_time(scene: Scene, sea: Sea, settings: Simulation) -> LatchingTime:
    """Return the latching time at which the take-off of a linear scene absorbs most in a sea; 0 in still water.

    Parameters
    ----------
    scene : Scene
        Its take-off is a `TakeOff`.
    """
    if not sea.omega.size:
        return LatchingTime(0.0, 0.0, 0.0)
    assert scene.law is not None
    damper, longest = scene.law.damping, longest_time(sea)

    def search(power: Power) -> tuple[float, LatchingTime]:
        return damper, best_latching_time(partial(power, damper), longest)

    return _searched(search, scene, sea, settings)[1]


def _searched(
    search: Callable[[Power], tuple[float, LatchingTime]], scene: Scene, sea: Sea, settings: Simulation
) -> tuple[float, LatchingTime]:
    """Damper and latching time that a search finds by quick trials, with the power of the motion from rest.

    Where that is less than the trials promised, or than without latching, the search is repeated from rest.
    """
    coarse = settings.model_copy(update={"tolerance": max(settings.tolerance, TRIED)})
    regular, trials = sea.omega.size == 1, Trials(TRIED)

    def quick(system: System) -> float:
        return trials.power(system) if regular else _followed(system, sea, coarse)

    def steady(system: System) -> float:
        return periodic_power(system, STEADY)[0] if regular else windowed_power(system, sea, settings)

    def power_of(follow: Callable[[System], float], damping: float, time: float) -> float:
        return follow(System.of(with_latching_time(scene, time, damping)))

    from_rest = partial(power_of, steady)
    damper, best = search(partial(power_of, quick))
    power = from_rest(damper, best.time)
    if power < KEPT * best.power or power < from_rest(damper, 0.0):
        return search(from_rest)
    return damper, best._replace(power=power)


def body_exact_latching_time(scene: Scene, linear: LatchingTime, sea: Sea, settings: Simulation) -> LatchingTime:
    """Return the best latching time of a body-exact scene near that of the linear one, at least as good as that.

    Parameters
    ----------
    scene : Scene
        Body-exact, its take-off a `TakeOff`.
    linear : LatchingTime
        Of the linear scene.

    Notes
    -----
    Some eight trials: of 8 to 24 periods each in a regular wave, of the run's length in another sea. A motion that
    cannot be followed counts as no power.
    """
    if not sea.omega.size:
        return linear
    longest, trials = longest_time(sea), Trials(TRIED_BODY_EXACT)

    def power(time: float) -> float:
        system = System.of(with_latching_time(scene, time))
        return trials.power(system) if sea.omega.size == 1 else _followed(system, sea, settings)

    between = max(linear.time - NEAR * longest, 0.0), min(linear.time + NEAR * longest, longest)
    within = KNOWN_BODY_EXACT * longest
    time, most = _refined(power, (linear.time, power(linear.time)), between, within)
    return LatchingTime(time, most, within)


def strongest(sea: Sea) -> float:
    """Return the frequency of the largest component of a sea [rad/s]."""
    return float(sea.omega[np.argmax(np.abs(sea.amplitude))])


def longest_time(sea: Sea) -> float:
    """Return the longest latching time that is tried in a sea, half the period of its largest component [s]."""
    return float(np.pi / strongest(sea))


def _followed(system: System, sea: Sea, settings: Simulation) -> float:
    """Mean power in the window of a run [W]; zero where the motion cannot be followed."""
    try:
        return windowed_power(system, sea, settings)
    except ConvergenceError:
        return 0.0


def windowed_power(system: System, sea: Sea, settings: Simulation) -> float:
    """Return the mean power absorbed in the window of a run [W]."""
    (start, end), at_start, at_end = settings.window, 0.0, 0.0
    for leg in legs(system, sea, settings, None):
        time, absorbed = leg.motion.time, leg.energy["pto"]
        at_start = float(np.interp(start, time, absorbed)) if time[0] <= start else at_start
        at_end = float(np.interp(end, time, absorbed)) if time[0] <= end else at_end
    return (at_end - at_start) / (end - start)


# scenes ---------------------------------------------------------------------------------------------------------------


class Memory(NamedTuple):
    """The radiation memory of what floats."""

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


def design_in_sea(run: Run, paths: dict[str, Any]) -> DesignInSea:
    """Return the scene of a run by what floats and its hydrodynamic model, and what goes with it.

    Parameters
    ----------
    paths : mapping of option to path
        `database` and `radiation`, where the model has them.
    """
    return SCENES["linear" if run.study.KIND == "body" else run.study.hydro.model](run, paths)


def stored_memory(path: str, linear: LinearSystem) -> Memory:
    """Return the radiation memory of what floats as it was stored; degrees of freedom it does not have radiate nothing.

    That of a body has an added mass at infinite frequency of its own.
    """
    ds = load(path, expected=Path(path).stem).reindex(radiating_dof=list(linear.labels), fill_value=0)
    model = RadiationModel(ds.state_matrix.values, ds.input_matrix.values, ds.channel.values)
    fitted = ds.added_mass_inf.values if "added_mass_inf" in ds else linear.added_mass_inf
    return Memory(model, fitted, float(ds.attrs.get("up_to", np.inf)))


def linear_design(run: Run, paths: dict[str, Any]) -> DesignInSea:
    """Return the scene of linear hydrodynamics about the mean shape, or of a body about its rest."""
    at = _from_bem(run, paths)
    scene, notes = _tuned_in_time(_linear(run, at), run, at)
    return at.with_scene(with_drag(scene, run.study, run.study.waves[0], at.sea), notes, {"model": "linear"})


def body_exact_design(run: Run, paths: dict[str, Any]) -> DesignInSea:
    """Return the scene with static and Froude-Krylov forces on the instantaneous wet shell, the rest linear."""
    at = _from_bem(run, paths)
    shape = at.floating.shell
    rubber = rubber_shell(run.study, shape.basis)
    scene = body_exact_scene(at.linear, shape, at.memory.model, at.sea, at.motions, rubber)
    scene, notes = _tuned_in_time(with_take_off(scene, run.study.pto, at.linear.pto), run, at)
    return at.with_scene(with_drag(scene, run.study, run.study.waves[0], at.sea), notes, {"model": "body_exact"})


def automatic_design(run: Run, paths: dict[str, Any]) -> DesignInSea:
    """Return the cheapest scene that gives the mean absorbed power to the tolerance of the run."""
    begun = clock.perf_counter()
    at = _from_bem(run, paths)
    (design,), buoy, shape = run.study.designs, run.study, at.floating.shell
    ladder = automatic.motion_ladder(buoy, shape.basis, design)
    rubber = rubber_shell(buoy, shape.basis)
    scenes = automatic.Scenes(at.linear, shape, at.memory.model, at.sea, ladder, run.study.simulation, rubber)
    choice = automatic.chosen(scenes, buoy.hydro.power_tolerance or POWER_TOLERANCE)
    return at.with_scene(choice.scene, {**choice.notes, "choice_seconds": clock.perf_counter() - begun})


class _FromBem(NamedTuple):
    """What a scene with BEM is made of."""

    linear: LinearSystem  # with the take-off of the run
    memory: Memory
    sea: Sea
    motions: FloatArray  # of the design; of a linear model reduced ones (`vsb.engine.motion.reduced`)
    notes: dict[str, Any]  # of the take-off
    held: FloatArray  # combinations of degrees of freedom held at zero, Phi q = 0 (constraint, dof)
    orders: Sequence[OrderBasis]  # beside heave and axisymmetric modes
    floating: FloatingSystem
    spectral: tuple[Wave, Sea]  # the wave and the sea powers are expected in

    def with_scene(self, scene: Scene, *notes: dict[str, Any]) -> DesignInSea:
        """The design in its sea by a scene."""
        said = {key: value for note in (self.notes, *notes) for key, value in note.items()}
        shape, port = self.floating.shape, self.floating.port
        spectrum = self.linear.spectrum
        return DesignInSea(scene, shape, self.sea, spectrum, said, self.held, self.orders, None if shape else port)


def _linear(run: Run, at: _FromBem) -> Scene:
    """The linear scene with the take-off of a run."""
    scene = linear_scene(at.linear, at.memory.model, at.sea, at.motions, at.memory.added_mass_inf)
    return with_take_off(scene, run.study.pto, at.linear.pto)


def _tuned_in_time(scene: Scene, run: Run, at: _FromBem) -> tuple[Scene, dict[str, Any]]:
    """A scene with the latching time or causal controller that maximises mean power, if its law has one; metadata.

    A damper tuned to its sea is found together with the latching time by linear hydrodynamics; where the water's force
    is not linear the time is refined on the scene itself.
    """
    if run.study.pto.law == "causal" and scene.law:
        (design,) = run.study.designs
        return controlled(scene, at.floating, design, run.study.pto, *at.spectral)
    if not (run.study.pto.has_latching_time and scene.law):  # or nothing there moves
        return scene, {}
    damper, best, notes = _latched(_linear(run, at), run, at.sea, at.linear, at.motions)
    if scene.water is not None and at.sea.omega.size:
        notes |= {"linear_latching_time": best.time, "latching_time_searched": NEAR * longest_time(at.sea)}
        latched = with_latching_time(scene, best.time, damper)
        best = body_exact_latching_time(latched, best, at.sea, run.study.simulation)
    return with_latching_time(scene, best.time, damper), notes | _noted(best)


def _latched(
    linear: Scene, run: Run, sea: Sea, floating: LinearSystem, motions: FloatArray
) -> tuple[float, LatchingTime, dict[str, float]]:
    """Damper [N s/m] and latching time in a linear scene; a damper tuned to its sea is found with it, and recorded."""
    if run.study.pto.tuning != "each":
        return float(floating.pto.damping), linear_latching_time(linear, sea, run.study.simulation), {}
    # Latching takes the reactance away: what is left to match is the resistance, or a little more. Dampers are tried
    # from the resistance of the port at the strongest wave up to the best one alone.
    alone, direction = float(floating.pto.damping), floating.pto.direction(len(motions))
    impedance = floating.port(np.array([strongest(sea)]), motions, direction).impedance
    least = max(float(impedance.real[0]), LIGHTEST * alone)
    tried = [float(damping) for damping in np.geomspace(min(least, alone), max(least, alone), 3)]
    damper, best = _searched(
        lambda power: best_damper_and_time(power, tried, longest_time(sea)), linear, sea, run.study.simulation
    )
    return damper, best, {TUNED: damper}


def _noted(best: LatchingTime) -> dict[str, float]:
    """What a run records of its latching time: its length [s], the mean power [W], what it is known to [s]."""
    return {"latching_time": best.time, "latching_power": best.power, "latching_time_within": best.within}


def _from_bem(run: Run, paths: dict[str, Any]) -> _FromBem:
    """What a scene of one design in one sea is made of; a damper is tuned to that sea, or to those named."""
    system = run.study
    (design,), (wave,) = system.designs, system.waves
    floating = floating_system(system, paths["database"])
    linear, motions = floating.linear, floating.motions[design]
    memory = stored_memory(paths["radiation"], linear)
    waves, spectral = study_sea(system, wave, linear.database), expected_sea(system, wave, linear.database)
    check_followed(memory, waves, wave.label)
    others = [(w, expected_sea(system, w, linear.database)) for w in run.seas]
    port = partial(dragged_port, system) if system.plates else None
    pto = tuned_take_off(run.study.pto, design, floating, others or [(wave, spectral)], port)
    notes = tuned_notes(run.study.pto, pto)
    notes |= linearised(system, floating, design, pto, wave, spectral)
    equipped = replace(floating.towards(heading_in(wave, waves)), pto=pto)
    if (shape := floating.shape) is None:
        held = held_rows(system.designs[design], linear.labels)
        return _FromBem(equipped, memory, waves, motions, notes, held, (), floating, (wave, spectral))
    orders = order_bases(system, shape.basis)
    if system.hydro.model == "linear":
        loaded = floating.port.reshape(len(motions), -1)
        if system.plates:
            loaded = np.column_stack([loaded, dragged(system.plates, linear.labels).T])
        heave = unit_heave(linear.labels, linear.mass + linear.added_mass_inf, motions)
        reduced = reduced_motions(linear, motions, loaded, heave)
        motions, notes = reduced.motions, notes | reduced.notes
    held = all_clamp_rows(system.designs[design].clamp, shape.basis, orders)
    if not orders:
        held = np.concatenate([held, mooring_rows(system, shape.basis)])
    return _FromBem(equipped, memory, waves, motions, notes, held, orders, floating, (wave, spectral))


def tuned_notes(pto: Pto, linear: LinearPto) -> dict[str, Any]:
    """Return what a run records of a damper that was not given: of several ports the matrix, row by row."""
    if pto.tuning == "fixed":
        return {}
    if isinstance(pto.port, SeveralPorts):
        return {TUNED_MATRIX: np.asarray(linear.damping).ravel().tolist()}
    return {TUNED: float(np.asarray(linear.damping).ravel()[0])}


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


def assumed_pressure_design(run: Run, _: dict[str, Any]) -> DesignInSea:
    """Return the scene with static and assumed pressure on the wet shell; a rigid design needs no shell modes."""
    buoy = run.study
    (design,), (wave,), pto = buoy.designs, buoy.waves, buoy.pto
    basis = study_basis(buoy)
    omega = wave.omega if wave.regular else 0.0
    load = AssumedPressure(buoy.hydro.pressure or 0.0 if omega else 0.0, omega)
    shell, water = DeformedShell(basis, buoy.centre_height, np.zeros(len(basis.labels))), buoy.water
    motions, take_off = design_motions(buoy, basis, design), LinearPto(pto.damper(design) or 0.0, pto.stiffness)
    scene = assumed_pressure_scene(shell, take_off, load, water.density, water.gravity, motions)
    scene, held = with_take_off(scene, pto, take_off), all_clamp_rows(buoy.designs[design].clamp, basis, ())
    return DesignInSea(scene, shell, NO_WAVES, None, {"model": "assumed_pressure"}, held)


SCENES = {
    "linear": linear_design,
    "body_exact": body_exact_design,
    "assumed_pressure": assumed_pressure_design,
    "auto": automatic_design,
}
"""Hydrodynamic model -> the scene of one design in one sea."""
