"""The port: a buoy as its take-off sees it, with all other motions eliminated, one or several; the linear take-off.

The take-off acts on one combination b of the degrees of freedom, with a force F against its velocity V = b.q'. Per
frequency and unit wave amplitude V = V0 - Y F, with a free velocity V0 and an admittance Y (Thevenin's equivalent).
All phasors are Re(. exp(-i omega t)) (C1).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
import numpy.typing as npt

from vsb.engine.hydro.dofs import multiplicity
from vsb.engine.motion.take_off import (
    BetweenPort,
    DistributedPort,
    DofPort,
    LinePort,
    PortChoice,
    SeveralPorts,
    ShellPort,
    StrainPort,
)
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.loaded import ElasticShell
from vsb.engine.shell.orders import OrderBasis
from vsb.errors import ConfigError, DatabaseError
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

_ROUND_OFF = 1e-6
"""Error of Re Y relative to |Y| where a port hardly radiates."""
RADIATES_NOTHING = 1e-9
"""Share of the largest loss of several ports at a frequency below which a combination of them radiates nothing [-]."""
EQUAL_STEP, APART, FALLEN = 0.25, 6, 0.01
"""Step of the logarithm of a damper that is the same at several ports, steps beyond the optimum, and the part of the
largest power to which power has fallen there: an optimum between steps is found to 1e-10 of its power."""


@dataclass(frozen=True)
class Port:
    """Thevenin's equivalent of one design at its port, over frequency.

    Units are those of a force port; of a volume port, pressure and volume flow take their place. Raises `DatabaseError`
    if the port is not passive, because its coefficients are not.

    Examples
    --------
    An impedance 3 + 4i [N s/m] that waves of 1 m move at 2 m/s: the optimal damper is its modulus, and absorbs
    2/(1 + sqrt(1 + Q^2)) of what any take-off could, Q = 4/3 [N s/m, W, W].

    >>> import numpy as np
    >>> from vsb.engine.motion.port import Port
    >>> port = Port(np.array([1.0]), np.array([1 / (3 + 4j)]), np.array([2.0 + 0j]), compliance=1.0)
    >>> [round(float(value[0]), 6) for value in (port.best_damping, port.best_power, port.matched_power)]
    [5.0, 3.125, 4.166667]
    """

    omega: FloatArray  # (omega,) [rad/s]
    admittance: ComplexArray  # Y (omega,) [m/(N s)]
    velocity: ComplexArray  # V0 per wave amplitude (omega,) [1/s]
    compliance: float  # displacement under a steady force [m/N]; 0: the port cannot move, infinite: it is unrestrained

    def __post_init__(self) -> None:
        """Check that the port is passive, Re Y >= 0, to round-off where waves hardly move it."""
        wrong = (self.admittance.real <= 0.0) & (self.velocity != 0.0)
        least, sound = _ROUND_OFF * np.abs(self.admittance), self.admittance.real > 0.0
        if wrong.any() and sound.any():
            power = (np.abs(self.velocity[sound]) ** 2 / np.maximum(self.admittance.real, least)[sound]).max()
            lost = wrong & (self.admittance.real > -least) & (np.abs(self.velocity) ** 2 <= power * least)
            object.__setattr__(self, "admittance", np.where(lost, least + 1j * self.admittance.imag, self.admittance))
            wrong &= ~lost
        if wrong.any():
            at, received = self.omega[wrong][0], self.admittance.real[wrong][0]
            raise DatabaseError(
                f"port: not passive at {at:.4g} rad/s, received Re Y = {received:.3g} m/(N s), needs more than 0; "
                "lower hydro.tolerance or hydro.omega_max, or a body's hydro.repair: [positive_damping]"
            )

    @property
    def moves(self) -> bool:
        """Whether waves move the port at all; a rigid buoy has no motion between its own points."""
        return bool(self.velocity.any())

    @cached_property
    def impedance(self) -> ComplexArray:
        """Z = 1/Y = R + iX, shape (omega,) [N s/m]; 0 where the port cannot move: there is no finite one."""
        return np.divide(1.0, self.admittance, out=np.zeros_like(self.admittance), where=self.admittance != 0)

    @cached_property
    def reactance_ratio(self) -> FloatArray:
        """Q = |X|/R = |Im Y|/Re Y, shape (omega,) [-]: what a damper cannot match; 0 where the port cannot move."""
        loss = self.admittance.real
        return np.divide(np.abs(self.admittance.imag), loss, out=np.zeros_like(loss), where=loss > 0)

    @cached_property
    def matched_power(self) -> FloatArray:
        """Mean power under the optimal force, |V0|^2/(8 Re Y) per squared amplitude, shape (omega,) [W/m^2].

        Of axisymmetric motion without structural loss J lambda/(2 pi), J the energy flux, whatever port and shell:
        there is one radiation channel, so |V0|^2 and Re Y are the same square of one radiated amplitude.
        """
        loss = 8 * self.admittance.real
        return np.asarray(np.divide(np.abs(self.velocity) ** 2, loss, out=np.zeros_like(loss), where=loss > 0))

    @cached_property
    def best_damping(self) -> FloatArray:
        """The optimal damper at each frequency, |Z|, shape (omega,) [N s/m]."""
        return np.abs(self.impedance)

    @cached_property
    def best_power(self) -> FloatArray:
        """Its power, 2/(1 + sqrt(1 + Q^2)) of the matched power, per squared amplitude, shape (omega,) [W/m^2]."""
        return np.asarray(self.matched_power * 2 / (1 + np.sqrt(1 + self.reactance_ratio**2)))

    def at(self, chosen: npt.NDArray[np.bool_ | np.intp]) -> "Port":
        """Return the port at some of its frequencies, by index or mask."""
        return Port(self.omega[chosen], self.admittance[chosen], self.velocity[chosen], self.compliance)

    def load(self, damping: FloatArray | float, stiffness: FloatArray | float = 0.0) -> ComplexArray:
        """Return the impedance c + i k/omega of a damper and a spring in parallel, shape (..., omega) [N s/m].

        Parameters
        ----------
        damping, stiffness : float or ndarray, shape (...) [N s/m], [N/m]
        """
        c, k = np.asarray(damping)[..., None], np.asarray(stiffness)[..., None]
        return np.asarray(c + 1j * k / self.omega)

    def velocity_under(self, load: ComplexArray) -> ComplexArray:
        """Return V under a load, V0/(1 + Y Z_load) per wave amplitude, shape (..., omega) [1/s]."""
        return np.asarray(self.velocity / (1 + self.admittance * load))

    def force(self, damping: FloatArray | float, stiffness: float = 0.0) -> ComplexArray:
        """Return the force of dampers beside a spring per wave amplitude, shape (..., omega) [N/m]."""
        load = self.load(damping, stiffness)
        return np.asarray(load * self.velocity_under(load))

    def power(self, damping: FloatArray | float, stiffness: FloatArray | float = 0.0) -> FloatArray:
        """Return the mean power of a damper beside a spring, c |V|^2/2 per squared amplitude, (..., omega) [W/m^2].

        Parameters
        ----------
        damping, stiffness : float or ndarray, shape (...) [N s/m], [N/m]
        """
        return np.asarray(0.5 * np.asarray(damping)[..., None] * self.speed_under(damping, stiffness))

    def speed_under(self, damping: FloatArray | float, stiffness: FloatArray | float = 0.0) -> FloatArray:
        """Return |V|^2 under a damper and a spring, per squared wave amplitude, shape (..., omega) [1/s^2].

        Parameters
        ----------
        damping, stiffness : float or ndarray, shape (...) [N s/m], [N/m]

        Notes
        -----
        |1 + Y (c + i k/omega)|^2 by its real and its imaginary part: a table of many dampers costs a third of what it
        does in complex numbers.
        """
        c, g, b = np.asarray(damping)[..., None], self.admittance.real, self.admittance.imag
        real, imaginary = 1 + g * c, b * c
        if np.any(stiffness):
            reactance = np.asarray(stiffness)[..., None] / self.omega
            real, imaginary = real - b * reactance, imaginary + g * reactance
        return np.asarray((self.velocity.real**2 + self.velocity.imag**2) / (real**2 + imaginary**2))

    @cached_property
    def matched_force(self) -> ComplexArray:
        """The optimal force per wave amplitude, V0/(2 Re Y), shape (omega,) [N/m]; beside it V = V0 - Y F."""
        loss = 2 * self.admittance.real
        return np.divide(self.velocity, loss, out=np.zeros_like(self.velocity), where=loss > 0)

    @property
    def softest_spring(self) -> float:
        """Stiffness a spring at the port must exceed for the buoy to rest stably, -1/compliance [N/m]."""
        return -1 / self.compliance if self.compliance > 0 else -np.inf

    def beside(self, stiffness: float) -> "Port":
        """Return the port with a spring built in: what a damper in parallel with the spring sees."""
        if not stiffness:
            return self
        loaded = 1 + self.admittance * self.load(0.0, stiffness)
        own = self.compliance
        compliance = 1 / stiffness if np.isinf(own) else own / (1 + stiffness * own)
        return replace(
            self, admittance=self.admittance / loaded, velocity=self.velocity / loaded, compliance=compliance
        )

    def behind(self, compliance: float) -> "Port":
        """Return the port with a spring of this compliance [m/N] in series: a chamber's gas before the turbine."""
        if not compliance:
            return self
        return replace(
            self, admittance=self.admittance - 1j * self.omega * compliance, compliance=self.compliance + compliance
        )


@dataclass(frozen=True)
class Ports:
    """Thevenin's equivalent of one design at several ports, over frequency; units are those of each port's kind.

    The take-off acts on p combinations B of the degrees of freedom with forces F = C V against their velocities
    V = B^T q', and V = V0 - Y F with Y (p, p) symmetric. `Port` is the case p = 1, whose optima have closed forms.
    """

    omega: FloatArray  # (omega,) [rad/s]
    admittance: ComplexArray  # Y (omega, port, port) [m/(N s)]
    velocity: ComplexArray  # V0 per wave amplitude (omega, port) [1/s]

    @property
    def moves(self) -> bool:
        """Whether waves move any of the ports."""
        return bool(self.velocity.any())

    @cached_property
    def size(self) -> FloatArray:
        """Mean modulus of each port's own admittance, shape (port,): what makes the ports comparable."""
        own = np.abs(np.einsum("wii->wi", self.admittance))
        return np.asarray(np.exp(np.log(np.where(own > 0, own, 1.0)).mean(axis=0)))

    @cached_property
    def impedance(self) -> ComplexArray:
        """Z = Y^-1, shape (omega, port, port); 0 of ports that cannot move."""
        scale = np.sqrt(np.outer(self.size, self.size))
        return np.asarray(np.linalg.pinv(self.admittance / scale, rcond=1e-13) / scale)

    @cached_property
    def matched_power(self) -> FloatArray:
        """Mean power under the optimal forces, V0^H (Re Y)^-1 V0/8 per squared amplitude, shape (omega,) [W/m^2].

        Where ports radiate through fewer channels than there are ports and lose nothing else, Re Y is singular, and V0
        in its range.
        """
        scale = np.sqrt(np.outer(self.size, self.size))
        loss, free = (self.admittance / scale).real, self.velocity / np.sqrt(self.size)
        values, vectors = np.linalg.eigh(loss)
        along = np.abs(np.einsum("wij,wi->wj", vectors, free)) ** 2
        kept = values > RADIATES_NOTHING * np.abs(values).max(axis=1, keepdims=True)
        return np.asarray(np.divide(along, 8 * values, out=np.zeros_like(along), where=kept).sum(axis=1))

    def velocity_under(self, damping: FloatArray) -> ComplexArray:
        """Return V = (1 + Y C)^-1 V0 under damper matrices (..., port, port), shape (..., omega, port) [1/s]."""
        loaded = np.eye(damping.shape[-1]) + self.admittance @ damping[..., None, :, :]
        return np.asarray(np.linalg.solve(loaded, self.velocity[..., None])[..., 0])

    def force(self, damping: FloatArray, stiffness: float = 0.0) -> ComplexArray:
        """Return the forces C V of damper matrices per wave amplitude, shape (..., omega, port); there is no spring."""
        return np.asarray(self.velocity_under(damping) @ damping)

    def power(self, damping: FloatArray) -> FloatArray:
        """Return the mean power V^H C V/2 of damper matrices per squared amplitude, shape (..., omega) [W/m^2]."""
        velocity = self.velocity_under(damping)
        return np.asarray(0.5 * np.real((velocity.conj() * (velocity @ damping)).sum(axis=-1)))

    def load(self, damping: FloatArray, stiffness: float = 0.0) -> FloatArray:
        """Return the impedance of a damper matrix, itself: several ports have no spring."""
        return damping

    def beside(self, stiffness: float) -> "Ports":
        """Return the same: several ports have no spring."""
        return self

    @cached_property
    def equal_dampers(self) -> tuple[FloatArray, FloatArray]:
        """Dampers c, the same at all ports, shape (damper,), and the mean power of each as of `power` (damper, omega).

        Evenly in their logarithms, of which the power is analytic within pi/2 of the real axis: 1 + c Y is singular for
        no c of a positive real part. From where c |Y x| < |x| for every x, so that power still grows with c, to where
        at every frequency it has fallen to `FALLEN` of its largest.
        """
        modulus = np.sqrt((np.abs(self.admittance) ** 2).sum(axis=(1, 2)))
        sizes, powers, identity = list[float](), list[FloatArray](), np.eye(self.velocity.shape[1])
        size = float(np.exp(-APART * EQUAL_STEP) / modulus.max())
        while len(powers) < 2 * APART or (powers[-APART] > FALLEN * np.max(powers, axis=0)).any():
            sizes.append(size)
            velocity = np.linalg.solve(identity + size * self.admittance, self.velocity[..., None])[..., 0]
            powers.append(0.5 * size * (np.abs(velocity) ** 2).sum(axis=1))
            size *= float(np.exp(EQUAL_STEP))
        return np.array(sizes), np.array(powers)

    def power_and_slope(self, damping: FloatArray, squares: FloatArray, price: float = 0.0) -> tuple[float, FloatArray]:
        """Return the mean power in a sea [W] and its derivative by the entries of a symmetric damper matrix.

        Parameters
        ----------
        damping : ndarray, shape (port, port)
        squares : ndarray, shape (omega,)
            Squared amplitudes of the sea [m^2].
        price : float [m/(N s)]
            Less this times the mean square of all forces.
        """
        inverse = np.linalg.inv(np.eye(len(damping)) + self.admittance @ damping)
        velocity = (inverse @ self.velocity[..., None])[..., 0]
        force = velocity @ damping
        beyond = velocity - (self.admittance.conj() @ force[..., None])[..., 0] - 2 * price * force
        adjoint = (inverse @ beyond.conj()[..., None])[..., 0]  # conjugate: Y is symmetric
        power = 0.5 * float(squares @ np.real(((velocity - price * force).conj() * force).sum(axis=1)))
        slope = 0.5 * np.real((squares[:, None] * adjoint).T @ velocity)
        return power, (slope + slope.T) / 2

    def force_rms(self, damping: FloatArray, squares: FloatArray) -> FloatArray:
        """Return the root mean square of each port's force in a sea under a damper matrix, shape (port,)."""
        return np.asarray(np.sqrt(0.5 * squares @ np.abs(self.force(damping)) ** 2))

    def at(self, chosen: FloatArray) -> "Ports":
        """Return the ports at some of their frequencies, by index or mask."""
        return Ports(self.omega[chosen], self.admittance[chosen], self.velocity[chosen])


@dataclass(frozen=True)
class PortMotion:
    """Displacements of the buoy and of points of its shell in waves, and per force at its port, or at each of several.

    Forces F against the motion of the ports leave free - F forced.
    """

    heave: tuple[ComplexArray, ComplexArray]  # free (omega,) [-], forced (omega,) or (omega, port) [m/N]
    shell: tuple[ComplexArray, ComplexArray]  # of a meridian, free (2, point, omega), forced also (..., port)

    def under(self, force: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return heave (..., omega) and shell (..., 2, point, omega) per wave amplitude [-].

        Parameters
        ----------
        force : ndarray, shape (..., omega) or, of several ports, (..., omega, port) [N/m]
        """
        (heave, of_heave), (shell, of_shell) = self.heave, self.shell
        if of_heave.ndim == 1:  # one product for each frequency
            return heave - force * of_heave, shell - force[..., None, None, :] * of_shell
        moved = np.einsum("...wp,wp->...w", force, of_heave), np.einsum("...wp,xnwp->...xnw", force, of_shell)
        return heave - moved[0], shell - moved[1]


ROUND_OFF = 1e-12
"""A share of a motion below this is none [-]."""


def port_direction(choice: PortChoice, shape: DeformedShell, orders: Sequence[OrderBasis] = ()) -> FloatArray:
    """Return b of a port, whose velocity is b.q', shape (dof,) [-]; of volume [m^2], area [m], strain [1/m], pitch [m].

    Of several ports B, shape (dof, port); of a damper spread over the shell L of its membrane's stiffness L L^T.

    Parameters
    ----------
    shape : DeformedShell
        The shape at rest.
    orders : sequence of OrderBasis
        Degrees of freedom beside the axisymmetric ones; surge, pitch and lines need those of order 1.

    Notes
    -----
    A ring of points moves radially by v and vertically by v cos phi - u sin phi, heave included, m >= 1 on average not;
    between two points of the meridian theta = 0 counts what lengthens the line that joins them, of a line to the sea
    bed likewise, attached to the frame; of the volume, its gradient int n.psi dS; of strain, that of the shape at rest
    (`DeformedShell.strain_gradients`), to which orders m >= 1 add nothing.
    """
    if isinstance(choice, SeveralPorts):
        return np.stack([port_direction(one, shape, orders) for one in choice.ports.values()], axis=-1)
    labels = [*shape.basis.labels, *(label for basis in orders for label in basis.labels)]
    if isinstance(choice, DistributedPort):
        spread = ElasticShell(shape.basis).membrane_factor(shape.modal_amplitude)
        return np.concatenate([spread, np.zeros((len(labels) - len(spread), spread.shape[1]))])
    if isinstance(choice, LinePort):
        return combination(labels, line_shares(choice, shape.centre_height))
    if isinstance(choice, DofPort):
        return combination(labels, choice.dofs)
    if choice == "surge" or choice == "pitch":
        return combination(labels, {choice.capitalize(): 1.0})
    beyond = [_between(choice, shape, basis) for basis in orders]
    return np.concatenate([_axisymmetric_port(choice, shape), *beyond])


def channels_reached(direction: FloatArray, orders: IntArray) -> int:
    """Return the power limit of a port over lambda/(2 pi): 1 for order 0 and 2 for each m >= 1 [-].

    Parameters
    ----------
    direction : ndarray, shape (dof,)
        b.
    orders : ndarray, shape (dof,)
        Azimuthal order of each degree of freedom.
    """
    reached = direction.any(axis=1) if direction.ndim == 2 else direction != 0.0
    return sum(multiplicity(int(order)) for order in np.unique(np.abs(orders[reached])))


def line_shares(line: LinePort, centre_height: float) -> dict[str, float]:
    """Return the lengthening of a line to the sea bed per unit of each rigid motion [-], of pitch [m].

    The attachment at (x, z) from the sphere's centre moves by (surge + z pitch, heave - x pitch); the stiffness across
    the line by its tension at rest is not part of the take-off.
    """
    x, z = line.line_from
    along_x, along_z = x - line.line_to[0], centre_height + z - line.line_to[1]
    length = math.hypot(along_x, along_z)
    along_x, along_z = along_x / length, along_z / length
    return {"Surge": along_x, "Heave": along_z, "Pitch": along_x * z - along_z * x}


def _between(choice: PortChoice, shape: DeformedShell, basis: OrderBasis) -> FloatArray:
    """Share of an order in a port: in one between two points of the meridian theta = 0, else none."""
    if not isinstance(choice, BetweenPort) or basis.odd:  # whose shapes are none at theta = 0
        return np.zeros(len(basis.labels))
    at = np.deg2rad(choice.between)
    v, u, _ = basis.ring_field(at)
    m, sin, cos = shape.meridian(at), np.sin(at), np.cos(at)
    chord = np.array([np.diff(m.x)[0], np.diff(m.z)[0]])
    apart = np.array([np.diff(v * sin + u * cos)[:, 0], np.diff(v * cos - u * sin)[:, 0]])
    apart[:, : basis.rigid] = 0.0
    return np.asarray(chord @ apart / np.linalg.norm(chord))


def _axisymmetric_port(
    choice: Literal["heave", "volume"] | ShellPort | BetweenPort | StrainPort, shape: DeformedShell
) -> FloatArray:
    """Share of heave and axisymmetric modes in a port."""
    heave = np.eye(len(shape.basis.labels))[0]
    if choice == "heave":
        return np.asarray(heave)
    if choice == "volume":
        direction: FloatArray = ElasticShell(shape.basis).volume_gradient(shape.modal_amplitude)
    elif isinstance(choice, StrainPort):
        upper, lower = np.deg2rad(choice.belt)
        hoop, meridional, area = shape.strain_gradients(float(upper), float(lower))
        direction = {"hoop": hoop, "meridional": meridional, "area": area * (hoop + meridional)}[choice.strain]
    elif isinstance(choice, BetweenPort):
        at = np.deg2rad(choice.between)
        m, (v, u) = shape.meridian(at), shape.basis.ring_displacement(at)
        chord = np.array([np.diff(m.x)[0], np.diff(m.z)[0]])
        sin, cos = np.sin(at), np.cos(at)
        apart = np.array([np.diff(v * sin + u * cos)[:, 0], np.diff(v * cos - u * sin)[:, 0]])
        direction = np.asarray(chord @ apart / np.sqrt(chord @ chord))
    else:
        at = np.deg2rad([choice.colatitude])
        radial, meridional = shape.basis.ring_displacement(at)
        raised = radial * np.cos(at) - meridional * np.sin(at)
        direction = (radial if choice.direction == "radial" else raised)[:, 0]
    if not isinstance(choice, ShellPort) or choice.against == "frame":
        direction = direction * (1 - heave)  # rigid heave does not move these
    kept = np.abs(direction) > ROUND_OFF * np.abs(direction).max()
    return np.asarray(direction - np.where(kept, 0.0, direction.real))  # an imaginary step remains


def combination(labels: Sequence[str], shares: Mapping[str, float]) -> FloatArray:
    """Return b of a port that moves with a combination of degrees of freedom, b.q = sum of share times amplitude.

    Raises `ConfigError` if a degree of freedom is not there, or the combination is none.
    """
    if unknown := sorted(set(shares) - set(labels)):
        raise ConfigError(f"pto.port: received {', '.join(unknown)}; needs some of {', '.join(labels)}.")
    b = np.array([float(shares.get(label, 0.0)) for label in labels])
    if not (np.isfinite(b).all() and b.any()):
        raise ConfigError(f"pto.port: received {dict(shares)}; needs finite shares, not all zero.")
    return b


@dataclass(frozen=True)
class LinearPto:
    """Damper and spring at a port b, f = -b (c b.q' + k b.q); of the heaving sphere centre against the bed, Eq. 91."""

    damping: FloatArray | float  # c [N s/m]; one for each frequency: (omega,); of several ports C (port, port)
    stiffness: FloatArray | float = 0.0  # k [N/m]; likewise; 0 of several
    port: FloatArray | None = None  # b (dof,) [-]; none: heave; of several ports B (dof, port)

    @property
    def several(self) -> bool:
        """Whether it acts on several ports at once."""
        return self.port is not None and self.port.ndim == 2

    def direction(self, dof: int) -> FloatArray:
        """Return b over all degrees of freedom, heave first, shape (dof,) [-]."""
        return np.eye(dof)[0] if self.port is None else self.port

    def matrix(self, dof: int) -> FloatArray:
        """Return its damping over all degrees of freedom, shape ([omega,] dof, dof) [N s/m]."""
        if self.port is not None and self.port.ndim == 2:
            return np.asarray(self.port @ self.damping @ self.port.T)
        return np.asarray(np.asarray(self.damping)[..., None, None] * self._outer(dof))

    def spring(self, dof: int) -> FloatArray:
        """Return its stiffness over all degrees of freedom, shape ([omega,] dof, dof) [N/m]."""
        if self.several:
            return np.zeros((dof, dof))
        return np.asarray(np.asarray(self.stiffness)[..., None, None] * self._outer(dof))

    def relaxed(self, compliance: float) -> tuple["LinearPto", float]:
        """Return the spring beside a damper behind a compliance that does what damper and spring do behind another.

        Raises `ConfigError` if a negative spring makes the chamber statically unstable.

        Parameters
        ----------
        compliance : float
            C of the spring in series with both: a chamber's gas [m/N]; 1 + k C > 0.

        Returns
        -------
        LinearPto
            k/(1 + k C) and c/(1 + k C)^2.
        float
            C (1 + k C), in series with that damper alone.

        Notes
        -----
        The force F moves the port by S = S' + C F and the take-off by S', F = c dS'/dt + k S'. Without S',
        c C F' + (1 + k C) F = c S' + k S: a spring, and what relaxes beside it. Both store and lose the same.
        """
        share = 1 + float(self.stiffness) * compliance
        if share <= 0:
            raise ConfigError(
                f"pto.stiffness: received {self.stiffness:g}, which makes the air chamber statically "
                f"unstable; needs more than {-1 / compliance:.6g}"
            )
        return replace(self, damping=self.damping / share**2, stiffness=self.stiffness / share), compliance * share

    def behind(self, compliance: float, omega: FloatArray) -> "LinearPto":
        """Return damper and spring, one for each frequency, that do what these do behind a compliance [m/N]."""
        beside, own = self.relaxed(compliance)
        lag = omega * own * beside.damping
        damping = beside.damping / (1 + lag**2)
        return replace(self, damping=damping, stiffness=beside.stiffness + omega * lag * damping)

    def _outer(self, dof: int) -> FloatArray:
        """B b^T."""
        return np.outer(self.direction(dof), self.direction(dof))
