"""Causal control in a stationary sea: ports at equally spaced frequencies to beyond the band, controllers in time."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from vsb.engine.integrators.switching import Mode, Switching
from vsb.engine.motion.causal import Controlled, RmsLimits, StationaryPort, StationaryPorts, optimum
from vsb.engine.motion.controller import Controller, achieved, realised, within_limit
from vsb.engine.motion.drag import GAUSSIAN, MOST_TURNS
from vsb.engine.motion.frequency import LinearEquation
from vsb.engine.motion.port import Port, Ports
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.engine.motion.take_off import Pto, named_ports, port_kind
from vsb.engine.motion.tuning import best_dampers
from vsb.engine.waves.kinds import Irregular, Wave
from vsb.engine.waves.seas import RESOLVED, Sea
from vsb.errors import ConvergenceError, StabilityError
from vsb.models.floating_system import AtFrequencies, FloatingSystem, heading, narrow_band, port_in_seas
from vsb.models.take_off import dragged_port
from vsb.study.study import Study
from vsb.tools.arrays import AnyArray, ComplexArray, FloatArray, IntArray

BEYOND = 4.0
"""End of the frequencies of a controller, over that of the band: its force may change within a time step."""
SAME_DRAG = 1e-6
"""Relative change of the dampers equivalent to drag with which a controller beside them is found [-]."""
POINTS = 64
"""Frequencies beyond the band at which the port is computed; between them it is interpolated."""


def stationary_ports(floating: FloatingSystem, wave: Irregular, sea: Sea) -> dict[str, Any]:
    """Return the port of all designs, or their several ports, in a sea whose components carry its spectrum.

    Parameters
    ----------
    wave : Irregular
    sea : Sea
        See `vsb.models.floating_system.expected_sea`.

    Notes
    -----
    Outside the band ports have the coefficients of its nearest end. Of a record and of white noise the spectrum is
    taken at frequencies of its own, of a record averaged (`vsb.engine.waves.kinds.RecordedSea.density`), and of a
    spread sea: the density of the free velocity is the sum of those of its directions. Buoys with several ports are of
    revolution, and answer waves of all directions alike.
    """
    going = wave.shares_around if wave.drawn and sea.heading is not None and floating.port.ndim == 1 else None
    sea, spacing, at, count = _on_grid(floating, wave, sea)

    def seen(equation: LinearEquation) -> Mapping[str, Port | Ports]:
        return AtFrequencies(equation, floating.motions, floating.port).seen()

    linear = floating.towards(heading(wave))
    near, far = (seen(linear.extended_equation(omega)) for omega in grid(spacing, count))
    spectrum, found = np.abs(sea.amplitude) ** 2 / (2 * spacing), {}
    own = {design: free_density(port.velocity[at], spectrum) for design, port in near.items()}
    if going is not None:
        own = dict.fromkeys(own, np.zeros(len(at)))
        for direction, share in going(sea.omega):
            for design, port in seen(floating.towards(direction).equation(sea.omega)).items():
                own[design] = own[design] + share * free_density(port.velocity, spectrum)
    for design, port in near.items():
        density = np.zeros((count, *own[design].shape[1:]), dtype=own[design].dtype)
        density[at] = own[design]
        found[design] = continued(spacing, port, far[design], density)
    return found


def free_density(velocity: ComplexArray, spectrum: FloatArray) -> AnyArray:
    """Return the density V0 V0^H S of the free velocities of several ports in a sea, of one port |V0|^2 S.

    Parameters
    ----------
    velocity : ndarray, shape (omega,) or (omega, port)
        V0 per wave amplitude [1/s].
    spectrum : ndarray, shape (omega,)
        S [m^2 s].
    """
    if velocity.ndim == 1:
        return np.asarray(np.abs(velocity) ** 2 * spectrum)
    return np.asarray(velocity[:, :, None] * velocity[:, None].conj() * spectrum[:, None, None])


class BesideDrag(NamedTuple):
    """The optimal causal control of a port with quadratic drag, as the damper equivalent to it under this control."""

    port: StationaryPort  # beside the damper
    best: Controlled
    damping: FloatArray  # D (dragged,) [N s/m]
    matched_power: float  # of the port without drag, on the same grid [W]


def optimum_with_drag(
    system: Study, floating: FloatingSystem, design: str, wave: Irregular, sea: Sea, pto: Pto, force: float
) -> BesideDrag:
    """Return the optimal causal control, of a given rms force [N], of a design with drag in a sea of one direction.

    Raises `ConvergenceError` if drag and control do not converge.

    Notes
    -----
    By statistical linearisation, as dampers have it (`vsb.engine.motion.drag`): the drag is the damper
    D = sqrt(8/pi) c s, s the standard deviation of the velocity past the water under the controller that is the optimum
    beside D. Found by repetition, each step halfway on a logarithmic scale.
    """
    sea, spacing, at, count = _on_grid(floating, wave, sea)
    inside, beyond = grid(spacing, count)
    near, far = (dragged_port(system, floating, design, {heading(wave): omega}) for omega in (inside, beyond))
    squares, noise, forecast = np.zeros(count), pto.control.noise, pto.control.forecast
    squares[at] = np.abs(sea.amplitude) ** 2

    def beside(damping: FloatArray) -> tuple[Port, StationaryPort]:
        seen = near.beside(damping)
        density = free_density(seen.velocity, squares / (2 * spacing))
        return seen, continued(spacing, seen, far.beside(damping), density)

    none = np.zeros(len(near.coefficient))
    matched = beside(none)[1].matched_power
    damping = GAUSSIAN * near.coefficient * near.spread(np.zeros(count, dtype=complex), none, squares)
    for _ in range(MOST_TURNS):
        seen, port = beside(damping)
        best = optimum(port, RmsLimits(force), noise, forecast, pto.efficiency)
        gain = port.controller(best.weights, noise, forecast)[:count]
        moved = near.spread(gain * seen.velocity * seen.impedance, damping, squares)
        before, damping = damping, np.sqrt(damping * GAUSSIAN * near.coefficient * moved)
        if np.all(np.abs(damping - before) <= SAME_DRAG * damping):
            return BesideDrag(port, best, before, matched)
    raise ConvergenceError(f"drag: no causal control found beside it after {MOST_TURNS} repetitions")


def _on_grid(floating: FloatingSystem, wave: Irregular, sea: Sea) -> tuple[Sea, float, IntArray, int]:
    """A sea, the spacing of a controller's frequencies, the places of its components, and how many the band has."""
    if not wave.even_components or sea.heading is not None:
        low, high = floating.band  # components at the centres of equal bands that begin at zero
        width = narrow_band(wave) if wave.even_components else RESOLVED * wave.omega
        omega = (np.arange(int(high / width)) + 0.5) * width
        omega = omega[omega >= low]
        sea = Sea(omega, np.sqrt(2 * wave.density(omega) * width).astype(complex))
    spacing = float(np.diff(sea.omega).min())
    at = np.rint(sea.omega / spacing - 0.5).astype(int)
    return sea, spacing, at, int(np.ceil(max(floating.band[1] / spacing, at.max() + 1)))


def grid(spacing: float, count: int, beyond: float = BEYOND) -> tuple[FloatArray, FloatArray]:
    """Return the frequencies of a band, (k + 1/2) spacing, and some beyond, at which a port is to be known [rad/s]."""
    first, last = (count + 0.5) * spacing, (int(beyond * count) - 0.5) * spacing
    return (np.arange(count) + 0.5) * spacing, np.geomspace(first, last, POINTS)


def continued(spacing: float, near: Port | Ports, far: Port | Ports, density: AnyArray) -> Any:
    """Return a port, or several, known at both frequencies of `grid`, with the density of its free velocity there.

    Where no waves are that the port would show, Re Y is made passive.
    """
    count, omega = len(near.omega), (np.arange(int(BEYOND * len(near.omega))) + 0.5) * spacing
    beyond = make_interp_spline(np.log(far.omega), far.admittance, k=1)(np.log(omega[count:]))
    admittance, spectrum = np.concatenate([near.admittance, beyond]), np.concatenate([density, np.zeros_like(beyond)])
    if admittance.ndim == 1:
        return StationaryPort(spacing, np.maximum(admittance.real, 0.0) + 1j * admittance.imag, spectrum.real)
    loss, along = np.linalg.eigh(admittance.real)
    passive = (along * np.maximum(loss, 0.0)[:, None]) @ along.swapaxes(1, 2)
    return StationaryPorts(spacing, passive + 1j * admittance.imag, spectrum)


def rms_limits(pto: Pto, seen: Port, squares: FloatArray) -> RmsLimits:
    """Return the rms values a causal controller keeps: those given; of force without one its optimal damper's.

    Parameters
    ----------
    squares : ndarray, shape (omega,) [m^2]
        Squared amplitudes of the sea at the frequencies of the port.
    """
    if (force := rms_force(pto, np.inf)) < np.inf:
        return RmsLimits(force, pto.stroke_limit)
    best = best_dampers(seen, squares[None], pto.stiffness, pto.efficiency)
    square = 0.5 * np.abs(seen.force(best.damping, pto.stiffness)[0]) ** 2 @ squares
    return RmsLimits(float(np.sqrt(square)), pto.stroke_limit)


def rms_force(pto: Pto, optimal: float) -> float:
    """Return the rms force of causal control: that given, else the force limit, else that of the optimal damper [N]."""
    return next((force for force in (pto.control.force_rms, pto.force_limit) if force < np.inf), optimal)


def forces_alike(pto: Pto) -> bool:
    """Return whether the forces of several ports have one unit."""
    return len({port_kind(one).load_unit for one in named_ports(pto).values()}) == 1


def force_units(pto: Pto, rms: FloatArray) -> FloatArray:
    """Return the units in which the forces of several ports are counted together, shape (port,).

    Those of unlike ports (newton, pascal) in terms of the rms values (port,) of the optimal damper matrix: the rms of
    all forces together has no other meaning.
    """
    return np.ones_like(rms) if forces_alike(pto) else np.where(rms > 0, rms, 1.0)


def controlled(
    scene: Scene, floating: FloatingSystem, design: str, pto: Pto, wave: Wave, sea: Sea
) -> tuple[Scene, dict[str, float]]:
    """Return a scene whose take-off follows the causal control of its sea, and what a run records of it.

    Raises `StabilityError` if the loop of controller and scene, linear about its rest, is not stable.

    Parameters
    ----------
    scene : Scene
        With a take-off that switches.
    sea : Sea
        See `vsb.models.floating_system.expected_sea`.
    """
    law = scene.law
    assert law is not None
    assert wave.irregular  # a study's own check
    one = replace(floating, motions={design: floating.motions[design]})
    seen, squares, _ = port_in_seas(floating, design, [(wave, sea)])
    port, limits = stationary_ports(one, wave, sea)[design], rms_limits(pto, seen, squares[0])
    best = optimum(port, limits, pto.control.noise, 0.0, pto.efficiency)
    if best.power <= 0:
        return scene, {}
    controller, error = realised_within(port, best, pto.control.noise, law.limit)
    _, margin = controller.stability(port.omega, port.admittance)
    scene = with_controller(scene, controller)
    loop_rates(scene, design)
    power, force = achieved(port, controller.gain(port.omega, port.admittance))
    notes = {"states": len(controller.output), "error": error, "margin": margin, "power": power, "force_rms": force}
    return scene, {f"controller_{name}": value for name, value in notes.items()}


def realised_within(port: StationaryPort, best: Controlled, noise: float, limit: float) -> tuple[Controller, float]:
    """Return the filter of an optimum whose force is cut at a limit [N], and its error; see `realised`."""
    gain = port.controller(best.weights, noise) if limit == np.inf else within_limit(port, best, noise, limit)
    return realised(port, gain)


def with_controller(scene: Scene, controller: Controller) -> Scene:
    """Return a scene whose take-off, one that switches, follows a controller."""
    assert scene.law is not None
    own = replace(scene.law, damping=controller.damping, stiffness=controller.stiffness, controller=controller)
    return replace(scene, forces={**scene.forces, scene.take_off: own})


def loop_rates(scene: Scene, design: str) -> ComplexArray:
    """Return the eigenvalues of a scene and its controller, linear about its rest, shape (state,) [1/s].

    Raises `StabilityError` if a disturbance grows.
    """
    runner = Switching(System.of(scene))
    loop = runner.phase(Mode(1), runner.lookout(np.array([0.0, 1.0]), 1))[0].matrix[:-1, :-1]
    rates = np.linalg.eigvals(loop)
    if (growth := float(rates.real.max())) >= 0:
        raise StabilityError(
            f"pto.law causal: the loop of controller and {design} is unstable, a disturbance grows by {growth:.2g}/s; "
            "lower pto.force_limit, or raise pto.control.noise"
        )
    return np.asarray(rates)
