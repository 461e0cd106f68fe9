"""Frequency domain: response amplitude operators, absorbed power, wet natural frequencies.

What holds motions in place: those nothing holds, and the softest of the others.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, final

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq

from vsb.errors import DatabaseError, StabilityError
from vsb.hydro.database import Coefficients
from vsb.hydro.orders import heading_shares, most_exciting, order_groups, orders_of, own_headings
from vsb.hydro.retardation import DampingSpectrum
from vsb.motion.channel import Channel
from vsb.motion.port import ROUND_OFF, LinearPto, Port
from vsb.tools.arrays import ComplexArray, FloatArray, IntArray

FASTEST = 1e9
"""Frequency [rad/s] beyond which nothing that has inertia swings."""
ADRIFT = 1e-6
"""Share of a steady force that no spring holds, from which on the port drifts [-]."""
STIFFNESS = ("structural", "hydrostatic", "prestress", "gas", "mooring")


@dataclass(frozen=True)
class LinearMotion(ABC):
    """Degrees of freedom about the mean shape, from a hydro database; every design moves in a subspace of them."""

    database: xr.Dataset
    structural_damping: FloatArray  # (dof, dof) [kg/s]
    pto: LinearPto
    chamber: float = 0.0  # compliance between port and take-off, of the gas before a turbine [m^3/Pa]

    @abstractmethod
    def coefficients(self, omega: FloatArray) -> Coefficients:
        """Return the coefficients between the frequencies solved; `DatabaseError` outside their band."""

    @abstractmethod
    def added_mass_at(self, omega: float) -> FloatArray:
        """Return the added mass at any frequency, in the band or not, shape (dof, dof) [kg]."""

    @property
    def heading_index(self) -> int:
        """Place of the waves' direction among those of the database; the first where all excite alike."""
        return 0

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the degrees of freedom."""
        return tuple(map(str, self.database.influenced_dof.values))

    @cached_property
    def spectrum(self) -> DampingSpectrum:
        """Radiation damping over frequency."""
        return DampingSpectrum(self.database.omega.values, self.database.radiation_damping.values)

    @cached_property
    def mass(self) -> FloatArray:
        """Inertia, shape (dof, dof) [kg]."""
        return np.asarray(self.database.inertia_matrix.values)

    @cached_property
    def added_mass_inf(self) -> FloatArray:
        """Added mass at infinite frequency, shape (dof, dof) [kg]."""
        return np.asarray(self.database.added_mass_inf.values)

    @cached_property
    def stiffness(self) -> FloatArray:
        """Sum of the stiffness of the reference shell, shape (dof, dof) [N/m]."""
        return np.asarray(sum(self.stiffness_parts.values()))

    @cached_property
    def stiffness_parts(self) -> dict[str, FloatArray]:
        """Stiffness of the reference shell by name, each shape (dof, dof) [N/m]."""
        names = [name for name in STIFFNESS if f"{name}_stiffness" in self.database]
        return {name: np.asarray(self.database[f"{name}_stiffness"].values) for name in names}

    def pto_at(self, omega: FloatArray) -> LinearPto:
        """Return damper and spring of the take-off as the port feels them, through the chamber if there is one."""
        return self.pto.behind(self.chamber, omega) if self.chamber else self.pto

    def damping_at(self, omega: FloatArray) -> FloatArray:
        """Return structural and power take-off damping, shape ([omega,] dof, dof) [kg/s]."""
        return self.structural_damping + self.pto_at(omega).matrix(len(self.mass))

    def held_at(self, omega: FloatArray) -> FloatArray:
        """Return stiffness of the reference shell and of the power take-off, shape ([omega,] dof, dof) [N/m]."""
        return self.stiffness + self.pto_at(omega).spring(len(self.mass))

    @property
    def damping(self) -> FloatArray:
        """Damping where no chamber relaxes, at frequency zero, shape ([omega,] dof, dof) [kg/s]."""
        return self.damping_at(np.zeros(()))

    @property
    def held(self) -> FloatArray:
        """Stiffness at rest, shape (dof, dof) [N/m]."""
        return self.held_at(np.zeros(()))

    def rao(self, omega: FloatArray, motions: FloatArray) -> ComplexArray:
        """Return displacement per unit wave amplitude under the take-off, shape (omega, dof) [m/m].

        Parameters
        ----------
        omega : ndarray, shape (omega,) [rad/s]
        motions : ndarray, shape (dof, free)
            The motions the design allows.

        Notes
        -----
        [-w^2 (M + A) - i w (B + D) + K + C] q = X (C1), projected on the motions.
        """
        c = self.coefficients(omega)
        matrices = (self.mass, self.damping_at(omega), self.held_at(omega))
        projected = motions.T @ dynamic_stiffness(omega, c, *matrices) @ motions
        return np.linalg.solve(projected, (c.excitation @ motions)[..., None])[..., 0] @ motions.T

    def free_motion(
        self, omega: FloatArray, motions: FloatArray, direction: FloatArray
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return displacements without take-off, per wave amplitude [m/m], and under its unit force [m/N].

        Parameters
        ----------
        omega : ndarray, shape (omega,) [rad/s]
        motions : ndarray, shape (dof, free)
            The motions the design allows.
        direction : ndarray, shape (dof,)
            b: the take-off moves with b.q.

        Returns
        -------
        free, forced : ndarray, each shape (omega, dof)
            A take-off's force F against the motion leaves free - F forced.
        """
        matrices = (self.mass, self.structural_damping, self.stiffness)
        c = self.coefficients(omega)
        return free_motion(dynamic_stiffness(omega, c, *matrices), c.excitation, motions, direction)

    def port(self, omega: FloatArray, motions: FloatArray, direction: FloatArray) -> Port:
        """Return what a take-off sees of a design, V0 = -i w b.q_free and Y = -i w b.q_forced; as `free_motion`.

        A chamber is in series with the port.
        """
        return self._port(omega, self.coefficients(omega), motions, direction)

    def extended_port(self, omega: FloatArray, motions: FloatArray, direction: FloatArray) -> Port:
        """Return `port` at any frequency: outside the band solved with the coefficients of its nearest end."""
        first, last = self.database.omega.values[[0, -1]]
        return self._port(omega, self.coefficients(np.clip(omega, first, last)), motions, direction)

    def _port(self, omega: FloatArray, c: Coefficients, motions: FloatArray, direction: FloatArray) -> Port:
        """The port by coefficients at these frequencies."""
        matrices = (self.mass, self.structural_damping, self.stiffness)
        moved = free_motion(dynamic_stiffness(omega, c, *matrices), c.excitation, motions, direction)
        seen = port_of_motion(omega, *moved, c.damping + self.structural_damping, self.stiffness, motions, direction)
        return seen.behind(self.chamber) if self.chamber else seen

    def absorbed_power(self, omega: FloatArray, rao: ComplexArray) -> FloatArray:
        """Return the mean power taken off per squared wave amplitude, c w^2 |b.q|^2/2, shape (omega,) [W/m^2]."""
        stroke = rao @ self.pto.direction(len(self.mass))
        return np.asarray(0.5 * self.pto_at(omega).damping * omega**2 * np.abs(stroke) ** 2)

    @abstractmethod
    def unrestrained(self, stiffness: FloatArray, motions: FloatArray) -> FloatArray:
        """Return the motions nothing holds, in those a design allows, shape (free, drifting).

        Parameters
        ----------
        stiffness : ndarray, shape (free, free) [N/m]
        motions : ndarray, shape (dof, free)

        Raises
        ------
        StabilityError
            If the body gives way at rest.
        """

    def natural_modes(self, motions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return wet natural frequencies [rad/s] and damping ratios [-] with the take-off, ascending, each (held,).

        Raises
        ------
        StabilityError
            If the body gives way at rest.

        Notes
        -----
        w_i solves 1 = w^2 mu_i(w), the i-th eigenvalue, largest first, of M + A(w) against K + C: stiffness of what
        rests stably is positive definite, inertia need not be, as the added mass of what is nearly immersed is negative
        at some frequencies. Motions nothing holds have no frequency; the others carry them along without force. The
        ratio counts radiation, structure and power take-off on the mode's diagonal; a damper behind a chamber stiffens
        and damps as it does at w_i.
        """
        loose = self.unrestrained(motions.T @ self.held @ motions, motions)
        held = null_space(loose.T) if loose.size else np.eye(motions.shape[1])
        results = [self._natural_mode(motions, loose, held, i) for i in range(held.shape[1])]
        frequency, ratio = np.array(results).reshape(-1, 2).T
        order = np.argsort(frequency)
        return frequency[order], ratio[order]

    def _natural_mode(self, motions: FloatArray, loose: FloatArray, held: FloatArray, i: int) -> tuple[float, float]:
        """One wet natural frequency and its damping ratio."""
        place, kept = held.shape[1] - 1 - i, motions @ held

        def eigen(omega: float) -> tuple[float, FloatArray]:
            k = kept.T @ self.held_at(np.asarray(omega)) @ kept
            inertia = motions.T @ (self.mass + self.added_mass_at(omega)) @ motions
            along = held - loose @ np.linalg.solve(loose.T @ inertia @ loose, loose.T @ inertia @ held)
            values, vectors = eigh(along.T @ inertia @ along, k, subset_by_index=[place, place])
            return float(omega**2 * values[0]), along @ vectors[:, 0]

        upper = 1.0
        while eigen(upper)[0] <= 1.0:
            upper *= 2
            if upper > FASTEST:
                raise DatabaseError("added mass at infinite frequency takes a mode's inertia; lower hydro.tolerance")
        omega = float(brentq(lambda w: eigen(w)[0] - 1.0, 1e-3, upper, xtol=1e-10))
        shape = omega * motions @ eigen(omega)[1]  # unit modal mass
        total = self.damping_at(np.asarray(omega)) + self.spectrum.at(np.array([omega]))[0]
        return omega, float(shape @ total @ shape / (2 * omega))


@final
@dataclass(frozen=True)
class LinearBuoy(LinearMotion):
    """Heave and modes of a shell of revolution, or all motions of orders up to some m; each has one channel."""

    direction: float = 0.0  # the waves go to [rad]

    @property
    def orders(self) -> IntArray:
        """Azimuthal order of each degree of freedom, shape (dof,)."""
        return orders_of(self.database)

    @cached_property
    def _splines(self) -> tuple[CubicSpline, Any]:
        """Added mass and excitation between the solved frequencies."""
        omega = self.database.omega.values
        force = CubicSpline(omega, most_exciting(self.database, "excitation_force"))
        return CubicSpline(omega, self.database.added_mass.values), force

    @cached_property
    def _channels(self) -> list[Channel]:
        """The radiation channel of each azimuthal order."""
        going = own_headings(self.database)
        return [Channel.of(self.database, group, going[group[0]]) for group in order_groups(self.database).values()]

    def coefficients(self, omega: FloatArray) -> Coefficients:
        """Return the coefficients by cubic splines between solved frequencies.

        Raises
        ------
        DatabaseError
            Outside the band solved.

        Notes
        -----
        Motions of one azimuthal order radiate through one channel, B = h X X^H (Haskind). Taken as such, what a
        take-off can get, |V0|^2/(8 Re Y), is the same at every port, as exactly as h: what the solver leaves beside the
        channel is its error, which `rank_one` of the database judges, and outweighs the channel where a port hardly
        radiates.
        """
        first, last = self.database.omega.values[[0, -1]]
        if omega.size and (omega.min() < first - 1e-9 or omega.max() > last + 1e-9):
            raise DatabaseError(
                f"frequencies {omega.min():.4g} to {omega.max():.4g} rad/s are asked for, the database holds "
                f"{first:g} to {last:g} rad/s; raise hydro.omega_max, or use waves below {2 * np.pi / first:.4g} s."
            )
        added_mass, excitation = self._splines
        force = excitation(omega).astype(complex)
        damping = np.sum([channel.damping(omega, force) for channel in self._channels], axis=0)
        return Coefficients(
            added_mass(omega), damping, np.asarray(force * heading_shares(self.orders, self.direction), dtype=complex)
        )

    def diffraction(self, omega: FloatArray) -> ComplexArray:
        """Return the diffraction force per unit wave amplitude, shape (omega, dof) [N/m]; band as `coefficients`."""
        self.coefficients(omega)
        force = CubicSpline(self.database.omega.values, most_exciting(self.database, "diffraction_force"))
        return np.asarray(force(omega) * heading_shares(self.orders, self.direction), dtype=complex)

    def added_mass_at(self, omega: float) -> FloatArray:
        """Return the added mass at any frequency by Kramers and Kronig, shape (dof, dof) [kg]."""
        return np.asarray(self.added_mass_inf + self.spectrum.added_mass_difference(np.array([omega]))[0])

    def unrestrained(self, stiffness: FloatArray, motions: FloatArray) -> FloatArray:
        """Return those of surge, sway and yaw that no mooring holds; water and shell hold the others."""
        loose = drifting_motions(stiffness, self.labels, motions)
        least, _ = softest(stiffness, loose)
        if least <= 0.0:
            raise StabilityError(
                f"the buoy gives way at rest: received a stiffness of {least:.4g} N/m, needs more than 0; "
                "raise device.young_modulus, device.thickness or device.internal_pressure"
            )
        return loose


def with_open_chamber(buoy: LinearBuoy, direction: FloatArray) -> LinearBuoy:
    """Return the buoy whose trapped gas stands between the shell and a take-off of its volume.

    Parameters
    ----------
    buoy : LinearBuoy
    direction : ndarray, shape (dof,)
        b of the volume port [m^2].

    Notes
    -----
    The gas resists volume alone, K = b b^T/C. Once it can leave through the take-off it holds the shell no more: what
    the port yields and what the gas yields add up (`Port.behind`).
    """
    gas = buoy.stiffness_parts.get("gas")
    if gas is None:
        return buoy
    return replace(buoy, database=buoy.database.drop_vars("gas_stiffness"), chamber=gas_compliance(gas, direction))


def gas_compliance(stiffness: FloatArray, direction: FloatArray) -> float:
    """Return C of a trapped gas from its stiffness b b^T/C [m^3/Pa]."""
    return float((direction @ direction) ** 2 / (direction @ stiffness @ direction))


def dynamic_stiffness(
    omega: FloatArray, c: Coefficients, mass: FloatArray, damping: FloatArray, stiffness: FloatArray
) -> ComplexArray:
    """Return -w^2 (M + A) - i w (B + D) + K, shape (omega, dof, dof) [N/m].

    Parameters
    ----------
    omega : ndarray, shape (omega,) [rad/s]
    c : Coefficients
        At these frequencies.
    mass, damping, stiffness : ndarray, shape ([omega,] dof, dof) [kg], [kg/s], [N/m]
        Of everything but radiation.
    """
    w = omega[:, None, None]
    return np.asarray(-(w**2) * (mass + c.added_mass) - 1j * w * (c.damping + damping) + stiffness, dtype=complex)


def free_motion(
    stiffness: ComplexArray, excitation: ComplexArray, motions: FloatArray, direction: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return `LinearMotion.free_motion` from a `dynamic_stiffness`, which all designs of a shape share."""
    pushed = np.broadcast_to(allowed_part(direction, motions), (len(excitation), motions.shape[1]))
    solved = np.linalg.solve(motions.T @ stiffness @ motions, np.stack([excitation @ motions, pushed], axis=-1))
    return solved[..., 0] @ motions.T, solved[..., 1] @ motions.T


def port_of_motion(
    omega: FloatArray,
    free: ComplexArray,
    forced: ComplexArray,
    lossy: FloatArray,
    stiffness: FloatArray,
    motions: FloatArray,
    direction: FloatArray,
) -> Port:
    """Return `LinearMotion.port` from the motions of `free_motion`; `lossy` is B + D.

    Notes
    -----
    Re Y is what a unit force loses, w^2 q^H (B + D) q: of a port that is nearly all spring, Re Y/|Y| down to 1e-13, the
    real part of b.q is round-off.
    """
    allowed, rate = allowed_part(direction, motions), -1j * omega
    along = motions @ allowed
    parts = np.stack([forced.real, forced.imag], axis=-1)
    loss = omega**2 * (parts * (lossy @ parts)).sum(axis=(1, 2))
    yields = compliance(motions.T @ stiffness @ motions, allowed)
    return Port(omega, loss + 1j * (rate * (forced @ along)).imag, rate * (free @ along), yields)


def compliance(stiffness: FloatArray, force: FloatArray) -> float:
    """Return the displacement of a port under a steady unit force along it, infinite if nothing holds it [m/N].

    Parameters
    ----------
    stiffness : ndarray, shape (free, free) [N/m]
    force : ndarray, shape (free,)
    """
    size = np.sqrt(np.abs(np.diag(stiffness)))
    if size.all() and np.linalg.cond(stiffness / np.outer(size, size)) < 1 / ROUND_OFF:
        return float(force @ np.linalg.solve(stiffness, force))
    moved = np.linalg.lstsq(stiffness, force, rcond=ROUND_OFF)[0]
    unrestrained = np.abs(stiffness @ moved - force).max(initial=0.0) > ADRIFT * np.abs(force).max(initial=0.0)
    return np.inf if unrestrained else float(force @ moved)


def allowed_part(direction: FloatArray, motions: FloatArray) -> FloatArray:
    """Return a port's direction in the motions of a design, N^T b, shape (free,): zero where only round-off is left."""
    part = motions.T @ direction
    return np.where(np.abs(part) > ROUND_OFF * np.linalg.norm(direction), part, 0.0)


def frequency_grid(step: float, lowest: float, omega_max: float, extra: Iterable[float]) -> FloatArray:
    """Return the frequencies of a response: a fine grid of a fifth of the solved step, and the ones asked for."""
    first, last = int(np.ceil(5 * lowest / step - 1e-9)), int(np.floor(5 * omega_max / step + 1e-9))
    grid = [round(step / 5 * i, 10) for i in range(first, last + 1)]
    return np.array(sorted({*grid, *extra}))


SLIDING = ("Surge", "Sway", "Yaw")
"""Rigid motions that neither water nor shell holds; a mooring may."""
_ROUND_OFF = 1e-13
"""Share of the largest stiffness that is round-off, each coordinate in terms of its own [-]."""


def drifting_motions(stiffness: FloatArray, labels: Sequence[str], motions: FloatArray) -> FloatArray:
    """Return the motions nothing holds, orthonormal in those a design allows, shape (free, loose).

    Parameters
    ----------
    stiffness : ndarray, shape (free, free) [N/m]
        Symmetric, of all that holds the buoy.
    labels : sequence of str
        Degrees of freedom.
    motions : ndarray, shape (dof, free)
        Those a design allows.

    Notes
    -----
    K v = 0, v of surge, sway and yaw: all of them without a mooring, the motion across a mooring of a single line.
    """
    sliding = motions[[label in SLIDING for label in labels]].T
    sliding = sliding[:, sliding.any(axis=0)]
    size = np.sqrt(np.abs(stiffness).max(axis=0, initial=0.0))
    size[size == 0.0] = 1.0
    own = np.abs(sliding).T @ size
    _, values, rows = np.linalg.svd(stiffness @ (sliding / own) / size[:, None])
    left = rows[np.count_nonzero(values > _ROUND_OFF) :].T / own[:, None]
    return np.linalg.qr(sliding @ (left / np.abs(left).max(axis=0, initial=0.0)))[0]


def softest(stiffness: FloatArray, loose: FloatArray) -> tuple[float, FloatArray]:
    """Return the least stiffness of what is held, and its motion, shape (free,); what rests stably has more than 0."""
    held = null_space(loose.T) if loose.size else np.eye(len(stiffness))
    values, shapes = np.linalg.eigh(held.T @ stiffness @ held)
    return float(values[0]), held @ shapes[:, 0]


def normal_modes(stiffness: FloatArray, mass: FloatArray, loose: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return squared frequencies and normal modes V, V^T M V = 1; of what nothing holds exactly zero.

    Parameters
    ----------
    stiffness, mass : ndarray, shape (free, free) [N/m], [kg]
    loose : ndarray, shape (free, loose)
        Of `drifting_motions`: round-off of their stiffness would give them a mean place.
    """
    squares, modes = eigh(stiffness, mass)
    if np.count_nonzero(squares == 0.0) >= loose.shape[1]:  # as of motions that nothing couples: kept as they are
        return squares, modes
    held, unrestrained = null_space(loose.T @ mass), loose @ eigh(loose.T @ mass @ loose)[1]
    unrestrained = unrestrained / np.sqrt(np.einsum("ij,ij->j", unrestrained, mass @ unrestrained))
    squares, shapes = eigh(held.T @ stiffness @ held, held.T @ mass @ held)
    return np.append(np.zeros(unrestrained.shape[1]), squares), np.hstack([unrestrained, held @ shapes])
