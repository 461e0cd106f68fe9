"""Forces of a scene: the linear part of each, its value along a motion, its potential energy and dissipated power.

Forces do not know each other or the integrator. A force that is entirely linear is given by `linear` alone.

A take-off law and an end stop are piecewise linear in the stroke S = b.q of the port and its velocity V. One form
serves all laws: a spring and a damper with limited force, F = -clip(c V + k S, -limit, limit). Without a limit this is
the linear take-off; an infinite c is friction, which holds the port at rest while the force needed stays within the
limit (Coulomb's law, a hydraulic take-off of constant pressure). For a latching time after each reversal of V the law
may change: held by friction the port is latched, without force it is declutched.

Viscous material is Maxwell branches, springs in series with dashpots, beside the stiffness K of the shell. A branch of
ratio r and relaxation time tau carries r K (q - s) with the dashpot's displacement s, tau s' = q - s. At a frequency
the shell then has the complex stiffness (C1)

    K [1 + sum r (-i w tau)/(1 - i w tau)] = K [1 + sum r w^2 tau^2/(1 + w^2 tau^2)] - i w K sum r tau/(1 + w^2 tau^2),

storage and loss modulus of a generalised Maxwell model (Ferry, Viscoelastic Properties of Polymers, 1980). At rest the
branches carry nothing. In time their states x = sqrt(r) L^T (q - s), K = L L^T, store |x|^2/2 and lose |x|^2/tau.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from vsb.engine.hydro.radiation import RadiationModel
from vsb.engine.motion.controller import Controller
from vsb.engine.motion.wetted import Incident, WetShell, scaled, wave_forces
from vsb.engine.shell.device import MaxwellBranch
from vsb.engine.shell.loaded import LoadedShell
from vsb.engine.waves.sampling import Sampler
from vsb.engine.waves.seas import superposed
from vsb.errors import ConfigError
from vsb.tools.arrays import ComplexArray, FloatArray

EXCITING = ("excitation", "froude_krylov", "diffraction")
"""Names of the forces by waves, or by a pressure in their place."""


class Linear(NamedTuple):
    """Linear part of a force: -K q - D v - G^T x with x' = A x + G v, and waves; absent parts are None."""

    stiffness: FloatArray | None = None  # K (dof, dof) [N/m]
    damping: FloatArray | None = None  # D (dof, dof) [N s/m]
    memory: RadiationModel | None = None  # A and G; it radiates |L^T x|^2/2
    waves: "Excitation | None" = None
    fully_linear: bool = True


During = Callable[..., FloatArray]
"""A force at rows of given instants, from q and v there and these rows (all by default), shape (row, dof) [N]."""


class Force(ABC):
    """One force of a scene over all degrees of freedom, heave first."""

    @abstractmethod
    def linear(self) -> Linear:
        """Return its linear part."""

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the force along a motion, but for that of memory states, shape (time, dof) [N].

        Times [s] are equally spaced; q [m] and v [m/s] have shape (time, dof).
        """
        part = self.linear()
        terms = [x @ matrix.T for x, matrix in ((q, part.stiffness), (v, part.damping)) if matrix is not None]
        return -sum(terms[1:], terms[0]) if terms else np.zeros(q.shape)

    def during(self, time: FloatArray) -> During:
        """Return the force at some of these instants from q and v there; time-dependent parts are computed once."""
        return lambda q, v, rows=slice(None): self.force(np.ascontiguousarray(time[rows]), q, v)  # compiled once

    def named(self, name: str, time: FloatArray, q: FloatArray, v: FloatArray) -> dict[str, FloatArray]:
        """Return the force as a run records it, under its own name or in parts with theirs; see `force`."""
        return {name: self.force(time, q, v)}

    def potential_energy(self, q: FloatArray) -> FloatArray:
        """Return its potential energy, shape (time,) [J]."""
        k = self.linear().stiffness
        return np.zeros(len(q)) if k is None else 0.5 * np.einsum("ti,ti->t", q @ k, q)

    def dissipated_power(self, v: FloatArray) -> FloatArray:
        """Return the power it dissipates or absorbs, shape (time,) [W]."""
        d = self.linear().damping
        return np.zeros(len(v)) if d is None else np.einsum("ti,ti->t", v @ d, v)

    def absorbed_power(self, q: FloatArray, v: FloatArray, force: FloatArray) -> FloatArray:
        """Return the power a take-off absorbs, -force.v less the rate of its potential energy, shape (time,) [W].

        `force` is its own along the motion, (time, dof), which q and v may not tell.
        """
        return self.dissipated_power(v)

    def frequencies(self) -> FloatArray:
        """Return the frequencies of its waves, shape (component,) [rad/s]."""
        return np.zeros(0)

    def scaled_waves(self, share: float) -> Self:
        """Return the force with its waves scaled."""
        return self


@dataclass(frozen=True)
class Spring(Force):
    """f = -K q."""

    stiffness: FloatArray  # (dof, dof) [N/m]

    def linear(self) -> Linear:
        """All of it."""
        return Linear(stiffness=self.stiffness)


@dataclass(frozen=True)
class Damper(Force):
    """f = -D v."""

    damping: FloatArray  # (dof, dof) [N s/m]

    def linear(self) -> Linear:
        """All of it."""
        return Linear(damping=self.damping)


@dataclass(frozen=True)
class SpringDamper(Force):
    """f = -K (q - q0) - D v."""

    stiffness: FloatArray  # (dof, dof) [N/m]
    damping: FloatArray  # (dof, dof) [N s/m]
    rest: FloatArray  # q0, where the spring is slack (dof,) [m]

    def linear(self) -> Linear:
        """All of it, if the spring is slack at q = 0."""
        return Linear(stiffness=self.stiffness, damping=self.damping, fully_linear=not self.rest.any())

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return it along a motion."""
        return super().force(time, q - self.rest, v)

    def potential_energy(self, q: FloatArray) -> FloatArray:
        """Return the energy of its spring."""
        return super().potential_energy(q - self.rest)


@dataclass(frozen=True)
class RadiationMemory(Force):
    """f = -G^T x with memory states x' = A x + G v."""

    model: RadiationModel

    def linear(self) -> Linear:
        """All of it."""
        return Linear(memory=self.model)


@dataclass(frozen=True)
class RelaxingDamper(Force):
    """f = -K q - b x/sqrt(C) with C p' = b.v - p/c, x = sqrt(C) p: a spring, and a damper behind a compliance.

    Its memory state is the pressure of a chamber's gas; the damper absorbs |x|^2/(c C) = p^2/c.
    """

    stiffness: FloatArray  # K (dof, dof) [N/m]
    direction: FloatArray  # b (dof,) [-]; of a volume [m^2]
    damping: float  # c [N s/m]; of a volume [Pa s/m^3]
    compliance: float  # C [m/N]; of a volume [m^3/Pa]

    @cached_property
    def model(self) -> RadiationModel:
        """Its memory."""
        rate = 1 / (self.damping * self.compliance)
        return RadiationModel(
            np.array([[-rate]]), self.direction[None] / np.sqrt(self.compliance), np.array([np.sqrt(2 * rate)])
        )

    def linear(self) -> Linear:
        """All of it."""
        return Linear(stiffness=self.stiffness, memory=self.model)


@dataclass(frozen=True)
class Excitation(Force):
    """f = Re sum F_j exp(-i omega_j t) (C1)."""

    omega: FloatArray  # (component,) [rad/s]
    phasors: ComplexArray  # F (component, dof) [N]

    def linear(self) -> Linear:
        """All of it."""
        return Linear(waves=self)

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the sum of its components."""
        return superposed(self.omega, self.phasors, time)

    def frequencies(self) -> FloatArray:
        """Return those of its components."""
        return self.omega

    def scaled_waves(self, share: float) -> Self:
        """Return it with scaled waves."""
        return replace(self, phasors=share * self.phasors)


@dataclass(frozen=True)
class ConstantForce(Force):
    """A constant force."""

    value: FloatArray  # (dof,) [N]

    def linear(self) -> Linear:
        """Nothing."""
        return Linear(fully_linear=False)

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return it at every instant."""
        return np.broadcast_to(self.value, q.shape)

    def potential_energy(self, q: FloatArray) -> FloatArray:
        """Return -f.q."""
        return -q @ self.value


@dataclass(frozen=True)
class QuadraticDrag(Force):
    """f = -sum c |u| u b, c = rho C A/2 and u = b.q' - w the velocity past the water, w = Re sum W_j exp(-i omega_j t).

    Morison's drag on rigid directions of the buoy; w is the undisturbed flow of the waves along each.
    """

    direction: FloatArray  # b (dragged, dof) [-]
    coefficient: FloatArray  # c (dragged,) [kg/m]
    omega: FloatArray  # of the waves (component,) [rad/s]
    flow: ComplexArray  # W (component, dragged) [m/s]

    def linear(self) -> Linear:
        """Nothing: it and its slope vanish at rest."""
        return Linear(fully_linear=False)

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return it along a motion."""
        return self.during(time)(q, v)

    def during(self, time: FloatArray) -> During:
        """Return it at some of these instants; the water's flow is computed once."""
        flow = superposed(self.omega, self.flow, time)

        def force(q: FloatArray, v: FloatArray, rows: slice = slice(None)) -> FloatArray:
            past = v @ self.direction.T - flow[rows]
            return np.asarray(-(self.coefficient * np.abs(past) * past) @ self.direction)

        return force

    def scaled_waves(self, share: float) -> Self:
        """Return it with scaled waves."""
        return replace(self, flow=share * self.flow)


@dataclass(frozen=True)
class AssumedPressure:
    """A uniform pressure P cos(omega t) on the wet shell, the paper's stand-in for waves."""

    amplitude: float  # P [Pa]
    omega: float  # [rad/s]

    def at(self, time: FloatArray) -> FloatArray:
        """Return the pressure, shape (time,) [Pa]."""
        return np.asarray(self.amplitude * np.cos(self.omega * time))


@dataclass(frozen=True)
class WaterPressure(Force):
    """f_j = -int p n.psi_j dS on the instantaneous wet part of the deformed shell.

    The pressure is that of still water with an assumed P cos(omega t), or with waves
    (`vsb.engine.motion.wetted`).
    """

    shell: WetShell
    rest: FloatArray  # amplitudes of the reference shape, about which q is measured (dof,) [m]
    specific_weight: float  # rho g [N/m^3]
    tangent: FloatArray  # -df/dq of the static part about the reference shape, (dof, dof) [N/m]
    assumed: AssumedPressure | None = None
    waves: Incident | None = None

    def linear(self) -> Linear:
        """Its tangent about the reference shape."""
        return Linear(stiffness=self.tangent, fully_linear=False)

    @cached_property
    def _sampler(self) -> Sampler | None:
        """The series of the waves."""
        return Sampler(self.waves.signals) if self.waves else None

    def waves_during(self, begin: float, end: float) -> Incident | None:
        """Return the waves, sampled for a span of time [s]; none in still water."""
        if self.waves is None or self._sampler is None:
            return None
        return self.waves._replace(signals=self._sampler.during(begin, end))

    def _in_waves(self, time: FloatArray, q: FloatArray, waves: Incident) -> FloatArray:
        """Force on the wet shell in waves."""
        return np.asarray(self.specific_weight * wave_forces(self.shell.shape, self.rest + q, waves, time))

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the force on the wet shell."""
        if waves := self.waves_during(float(time[0]), float(time[-1])):
            return self._in_waves(time, q, waves)
        static, uniform, _ = self.shell.forces(self.rest + q)
        pressure = self.assumed.at(time)[:, None] if self.assumed else 0.0
        return np.asarray(self.specific_weight * static + pressure * uniform)

    def named(self, name: str, time: FloatArray, q: FloatArray, v: FloatArray) -> dict[str, FloatArray]:
        """Return the force in still water, and what an assumed pressure or waves add."""
        static, uniform, _ = self.shell.forces(self.rest + q)
        out = {"hydrostatic": self.specific_weight * static}
        if self.assumed and self.assumed.amplitude:
            out["excitation"] = self.assumed.at(time)[:, None] * uniform
        if waves := self.waves_during(float(time[0]), float(time[-1])):
            out["froude_krylov"] = self._in_waves(time, q, waves) - out["hydrostatic"]
        return out

    def potential_energy(self, q: FloatArray) -> FloatArray:
        """Return the potential energy of the water displaced."""
        moment = self.shell.forces(self.rest + q)[2]
        return -self.specific_weight * moment

    def frequencies(self) -> FloatArray:
        """Return those of the waves, or of the assumed pressure."""
        if self.waves:
            return self.waves.omega
        return np.array([self.assumed.omega] if self.assumed and self.assumed.amplitude else [])

    def scaled_waves(self, share: float) -> Self:
        """Return it with scaled waves or assumed pressure."""
        if self.waves:
            return replace(self, waves=scaled(self.waves, share))
        if self.assumed:
            return replace(self, assumed=replace(self.assumed, amplitude=share * self.assumed.amplitude))
        return self


@dataclass(frozen=True)
class TakeOff(Force):
    """f = -b clip(c V + k S, -limit, limit); for a time `latching_time` after each reversal of V, c differs and k is 0.

    A causal controller adds the output C x of its states, which are part of the motion, and so is then this force.

    Its spring stores what a port that moves slowly would give it, U = int clip(k S, -limit, limit) dS, and absorbs
    nothing: without latching the power absorbed, (clip(c V + k S) - clip(k S)) V, is never negative, and c V^2 below
    the limit. The force of friction at rest and the latching times are part of the motion, which gives this force.
    Raises `ValueError` of friction without a limit: it would never move.
    """

    direction: FloatArray  # b (dof,) [-]
    damping: float  # c [N s/m]; infinite: friction
    stiffness: float = 0.0  # k [N/m]
    limit: float = np.inf  # [N]
    latching_time: float = 0.0  # latching or declutching time [s]
    latching_damping: float = np.inf  # c in that time [N s/m]; infinite: latched, 0: declutched
    rest: float = 0.0  # S at rest, from where the spring counts [m]
    controller: Controller | None = None  # that adds C x to c V + k S, c and k its own

    def __post_init__(self) -> None:
        """Check that the port moves."""
        if np.isinf(self.damping) and not 0 < self.limit < np.inf:
            raise ValueError(f"friction: received a limit of {self.limit:g} N, needs a finite one above 0")

    def linear(self) -> Linear:
        """Nothing: its linear part changes along the motion."""
        return Linear(fully_linear=False)

    def coefficients(self, in_latching_time: bool) -> tuple[float, float]:
        """Return c and k, within the latching time or out of it."""
        return (self.latching_damping, 0.0) if in_latching_time else (self.damping, self.stiffness)

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the law outside its latching times; zero for friction at rest."""
        speed = v @ self.direction
        if np.isinf(self.damping):
            wanted = self.limit * np.sign(speed)
        else:
            wanted = np.clip(
                self.damping * speed + self.stiffness * (q @ self.direction - self.rest), -self.limit, self.limit
            )
        return np.asarray(-np.outer(wanted, self.direction))

    def potential_energy(self, q: FloatArray) -> FloatArray:
        """Return the energy U of its spring; of a controller none."""
        if self.controller or not self.stiffness:
            return np.zeros(len(q))
        stroke = q @ self.direction - self.rest
        held = np.clip(self.stiffness * stroke, -self.limit, self.limit)
        return np.asarray(held * stroke - held**2 / (2 * self.stiffness))

    def absorbed_power(self, q: FloatArray, v: FloatArray, force: FloatArray) -> FloatArray:
        """Return -f.v less the rate of U."""
        spring = 0.0 if self.controller else self.stiffness
        held = np.clip(spring * (q @ self.direction - self.rest), -self.limit, self.limit)
        return np.asarray(-np.einsum("ti,ti->t", force, v) - held * (v @ self.direction))


@dataclass(frozen=True)
class PortForce(Force):
    """f = b F(S, V, t), F any smooth function of the port's motion and time: a take-off law of one's own.

    Raises `ConfigError` where F is no finite number at every instant.
    """

    direction: FloatArray  # b (dof,) [-]
    function: Callable[[FloatArray, FloatArray, FloatArray], FloatArray]  # S, V, t, each (time,) -> F (time,) [N]
    name: str
    rest: float = 0.0  # S at rest, from where it counts [m]

    def linear(self) -> Linear:
        """Nothing: what is linear of it is not known."""
        return Linear(fully_linear=False)

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return it along a motion."""
        stroke, speed = q @ self.direction - self.rest, v @ self.direction
        try:
            result = np.asarray(self.function(stroke, speed, time), dtype=float)
        except Exception as error:  # whatever a function of others may raise
            reason = " ".join(str(error).split()) or "no reason given"
            raise ConfigError(f"pto.law: {self.name} raised {type(error).__name__}: {reason}") from error
        if result.shape != stroke.shape or not np.isfinite(result).all():
            received = f"shape {result.shape}" if result.shape != stroke.shape else "NaN or infinite values"
            raise ConfigError(
                f"pto.law: received {received} of {self.name}, needs a finite force at every instant, shape "
                f"{stroke.shape}"
            )
        return np.asarray(np.outer(result, self.direction))

    def absorbed_power(self, q: FloatArray, v: FloatArray, force: FloatArray) -> FloatArray:
        """Return -f.v: what such a law stores is not known."""
        return np.asarray(-np.einsum("ti,ti->t", force, v))


@dataclass(frozen=True)
class EndStop(Force):
    """A spring beyond a stroke of either sign, and a damper while it is being loaded: it pushes and never pulls."""

    direction: FloatArray  # b (dof,) [-]
    stroke: float  # [m]
    stiffness: float  # [N/m]
    damping: float  # [N s/m]
    rest: float = 0.0  # S at rest, from where the stroke counts [m]

    def linear(self) -> Linear:
        """Nothing: mostly it is not in contact."""
        return Linear(fully_linear=False)

    def beyond(self, q: FloatArray) -> FloatArray:
        """Return the compression of the stop, with the sign of the stroke, shape (time,) [m]."""
        stroke = q @ self.direction - self.rest
        return np.asarray(np.sign(stroke) * np.maximum(np.abs(stroke) - self.stroke, 0.0))

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the force of the stop."""
        pressed, speed = self.beyond(q), v @ self.direction
        loading = self.damping * speed * (pressed * speed > 0)
        return np.asarray(-np.outer(self.stiffness * pressed + loading, self.direction))

    def potential_energy(self, q: FloatArray) -> FloatArray:
        """Return the energy of its spring."""
        return np.asarray(0.5 * self.stiffness * self.beyond(q) ** 2)


# the shell: rubber, however far it is stretched, and viscous material ------------------------------------------------


@dataclass(frozen=True)
class ShellForce(Force):
    """A force of the position alone with a potential, f = -dU/dq at the amplitudes of rest and motion together."""

    loaded: LoadedShell
    rest: FloatArray  # amplitudes of the reference shape, about which q is measured (dof,) [m]

    @abstractmethod
    def stiffness(self, q: FloatArray) -> FloatArray:
        """Return -df/dq, shape (dof, dof) [N/m]."""

    def linear(self) -> Linear:
        """Its tangent about the reference shape."""
        return Linear(stiffness=self.stiffness(np.zeros_like(self.rest)), fully_linear=False)


@dataclass(frozen=True)
class ElasticForce(ShellForce):
    """The elastic force of the shell."""

    def stiffness(self, q: FloatArray) -> FloatArray:
        """Return the Hessian of the elastic energy."""
        return self.loaded.elastic.stiffness(self.rest + q)

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the elastic force along a motion, shape (time, dof) [N]."""
        return self.loaded.elastic.force(self.rest + q)

    def potential_energy(self, q: FloatArray) -> FloatArray:
        """Return the elastic energy."""
        return np.asarray(self.loaded.elastic.energy(self.rest + q))


@dataclass(frozen=True)
class InsidePressure(ShellForce):
    """The force of the pressure inside, p dV/dq, constant or of trapped gas."""

    def stiffness(self, q: FloatArray) -> FloatArray:
        """Return that of the follower pressure and of the gas."""
        at = self.rest + q
        return self.loaded.pressure_stiffness(at) + self.loaded.gas_stiffness(at)

    def force(self, time: FloatArray, q: FloatArray, v: FloatArray) -> FloatArray:
        """Return the force of the pressure along a motion, shape (time, dof) [N]."""
        at = self.rest + q
        return np.asarray(np.asarray(self.loaded.pressure(at))[..., None] * self.loaded.elastic.volume_gradient(at))

    def potential_energy(self, q: FloatArray) -> FloatArray:
        """Return minus the work of the pressure."""
        return self.loaded.contents_energy(self.rest + q)


def shell_forces(loaded: LoadedShell, rest: FloatArray) -> dict[str, ShellForce]:
    """Return the forces of a shell by name: elastic, and of the pressure inside if there is any."""
    forces: dict[str, ShellForce] = {"elastic": ElasticForce(loaded, rest)}
    if loaded.internal_pressure or loaded.gas:
        forces["internal_pressure"] = InsidePressure(loaded, rest)
    return forces


_ROUND_OFF = 1e-13
"""Eigenvalue of a stiffness, over its largest, that is round-off: of a rigid motion [-]."""


def stiffening(branches: Sequence[MaxwellBranch], omega: FloatArray) -> FloatArray:
    """Return what branches add to a stiffness at frequencies, as a fraction of it, of the shape of omega [-]."""
    squares = [(omega * branch.time) ** 2 for branch in branches]
    return sum((b.ratio * x / (1 + x) for b, x in zip(branches, squares, strict=True)), np.zeros_like(omega))


def loss(branches: Sequence[MaxwellBranch], omega: FloatArray) -> FloatArray:
    """Return the damping of branches at frequencies over the stiffness, of the shape of omega [s]."""
    return sum((b.ratio * b.time / (1 + (omega * b.time) ** 2) for b in branches), np.zeros_like(omega))


@dataclass(frozen=True)
class ViscousForce(Force):
    """The force of Maxwell branches beside a stiffness K."""

    branches: tuple[MaxwellBranch, ...]
    stiffness: FloatArray  # K (dof, dof) [N/m]

    @cached_property
    def model(self) -> RadiationModel:
        """Its memory."""
        values, vectors = np.linalg.eigh(self.stiffness)
        kept = values > _ROUND_OFF * values[-1]
        factor = (vectors[:, kept] * np.sqrt(values[kept])).T
        rates = np.repeat([1 / branch.time for branch in self.branches], len(factor))
        inputs = np.concatenate([np.sqrt(branch.ratio) * factor for branch in self.branches])
        return RadiationModel(-np.diag(rates), inputs, np.diag(np.sqrt(2 * rates)))

    def linear(self) -> Linear:
        """All of it."""
        return Linear(memory=self.model)
